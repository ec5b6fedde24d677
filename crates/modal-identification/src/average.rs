//! The mean backbone of several hits.

use crate::Error;
use crate::backbone::Point;

/// One point of a mean backbone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanPoint {
    /// Amplitude (SI unit of its quantity).
    pub amplitude: f64,
    /// Mean natural frequency (Hz).
    pub frequency_hz: f64,
    /// Mean damping ratio.
    pub damping_ratio: f64,
    /// Number of hits that reach this amplitude.
    pub hits: usize,
    /// Standard deviations of frequency (Hz) and damping ratio between the hits; none for a single one.
    pub spread: Option<[f64; 2]>,
}

/// Most points of a mean backbone: far more than any record has periods, and a table of 100 MB.
pub const MOST_POINTS: usize = 1_000_000;

/// Averages backbones at `points` amplitudes, equally spaced in their logarithm from the smallest to the largest that any
/// hit reaches. Each hit counts where it has been; between its points it is interpolated linearly over the logarithm of the
/// amplitude. Where an amplitude does not fall from one point to the next (noise), the later point is left out.
///
/// A single backbone keeps its points. Points ascend in amplitude.
///
/// # Errors
/// [`Error::Average`] for no backbone, one without two points, fewer than two points or more than [`MOST_POINTS`] asked for.
pub fn average(backbones: &[&[Point]], points: usize) -> Result<Vec<MeanPoint>, Error> {
    let refuse = |what: String| Err(Error::Average { what });
    if backbones.is_empty() {
        return refuse("there is no backbone".into());
    }
    if !(2..=MOST_POINTS).contains(&points) {
        return refuse(format!(
            "{points} points were asked for; it must be from 2 to {MOST_POINTS}"
        ));
    }
    let falling: Vec<Vec<Point>> = backbones.iter().map(|b| falling(b)).collect();
    if let Some(k) = falling.iter().position(|b| b.len() < 2) {
        return refuse(format!("backbone {} has {} points", k + 1, falling[k].len()));
    }
    if let [only] = &falling[..] {
        let single = |p: &Point| MeanPoint {
            amplitude: p.amplitude,
            frequency_hz: p.frequency_hz,
            damping_ratio: p.damping_ratio,
            hits: 1,
            spread: None,
        };
        return Ok(only.iter().map(single).collect());
    }
    let smallest = falling.iter().map(|b| b[0].amplitude).fold(f64::INFINITY, f64::min);
    let largest = falling.iter().map(|b| b[b.len() - 1].amplitude).fold(0.0, f64::max);
    let grid = (0..points).map(|i| {
        // The ends are met exactly.
        let part = i as f64 / (points - 1) as f64;
        let inside = smallest * (largest / smallest).powf(part);
        if i + 1 == points { largest } else { inside.max(smallest) }
    });
    // Between hits that share no amplitude there is nothing.
    Ok(grid.filter_map(|amplitude| mean(&falling, amplitude)).collect())
}

/// Points in ascending order of amplitude.
fn falling(backbone: &[Point]) -> Vec<Point> {
    let mut lowest = f64::INFINITY;
    let mut kept: Vec<Point> = Vec::new();
    for point in backbone {
        if point.amplitude < lowest {
            lowest = point.amplitude;
            kept.push(*point);
        }
    }
    kept.reverse();
    kept
}

fn mean(backbones: &[Vec<Point>], amplitude: f64) -> Option<MeanPoint> {
    let found: Vec<[f64; 2]> = backbones.iter().filter_map(|b| at(b, amplitude)).collect();
    let hits = found.len();
    if hits == 0 {
        return None;
    }
    let mean = [0, 1].map(|c| found.iter().map(|f| f[c]).sum::<f64>() / hits as f64);
    let deviation = |c: usize| {
        let squares: f64 = found.iter().map(|f| (f[c] - mean[c]).powi(2)).sum();
        (squares / (hits - 1) as f64).sqrt()
    };
    Some(MeanPoint {
        amplitude,
        frequency_hz: mean[0],
        damping_ratio: mean[1],
        hits,
        spread: (hits > 1).then(|| [deviation(0), deviation(1)]),
    })
}

/// Frequency and damping ratio at an amplitude.
fn at(backbone: &[Point], amplitude: f64) -> Option<[f64; 2]> {
    let above = backbone.partition_point(|p| p.amplitude < amplitude);
    let b = backbone.get(above)?;
    if b.amplitude == amplitude {
        return Some([b.frequency_hz, b.damping_ratio]);
    }
    let a = backbone[above.checked_sub(1)?];
    let part = (amplitude / a.amplitude).ln() / (b.amplitude / a.amplitude).ln();
    let between = |a: f64, b: f64| a + part * (b - a);
    Some([
        between(a.frequency_hz, b.frequency_hz),
        between(a.damping_ratio, b.damping_ratio),
    ])
}
