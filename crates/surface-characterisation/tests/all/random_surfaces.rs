//! Gaussian surfaces of known spectrum against the theory of random processes.
//!
//! The autocorrelation is `m0 exp(-(s/l)^2 - (t/l)^2)`, with profile moments `m2 = 2 m0/l^2`, `m4 = 12 m0/l^4` and
//! `alpha = m0 m4/m2^2 = 3`. Every figure is the mean of independent faces; it may differ from the theory by four
//! standard errors of that mean, taken from the scatter between the faces, and by what the step is known to do.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::f64::consts::PI;

use rayon::prelude::*;

use contact_laws::{ElasticPair, TangentialReading};
use surface_characterisation::{
    ArealParameters, ArealPatch, ElementOutlines, HeightMap, Options, PairAsperities, SyntheticFace, characterise,
    line_peaks, summits, traction_curves,
};

const SQ: f64 = 1.5e-6;
const FACES: u64 = 12;

/// A face of `n` by `n` points at unit correlation lengths of `per_length` steps of 10 um.
fn face(seed: u64, n: usize, per_length: [f64; 2]) -> HeightMap {
    SyntheticFace {
        points: [n, n],
        step: [10e-6; 2],
        origin: [0.0; 2],
        rms: SQ,
        correlation_length: per_length.map(|l| l * 10e-6),
        waviness: vec![],
        tilt: [0.0; 2],
        height_step: None,
        seed,
    }
    .generate(|_| false)
    .unwrap()
}

fn heights(map: &HeightMap) -> Vec<f64> {
    (0..map.nx() * map.ny())
        .map(|k| map.height(k % map.nx(), k / map.nx()).unwrap())
        .collect()
}

/// Correlation of the generated heights at lag `k` for `per_length` steps per correlation length: that of the weights
/// that [`SyntheticFace`] documents, which is the Gaussian one but for coarse grids.
fn correlation(per_length: f64, k: i64) -> f64 {
    let reach = (2.5 * per_length).ceil() as i64;
    let weight = |m: i64| {
        if m.abs() > reach {
            0.0
        } else {
            (-2.0 * (m as f64 / per_length).powi(2)).exp()
        }
    };
    let product = |lag: i64| (-reach..=reach).map(|m| weight(m) * weight(m + lag)).sum::<f64>();
    product(k) / product(0)
}

/// Share of the ordinates of a profile that are peaks, their mean height and mean three-point curvature, for
/// correlations at one and two steps: exact at any step (Whitehouse and Archard, Proc. R. Soc. A 316, 1970).
fn sampled_peaks(per_length: f64) -> [f64; 3] {
    let (r1, r2) = (correlation(per_length, 1), correlation(per_length, 2));
    let bend = 3.0 - 4.0 * r1 + r2;
    let share = (bend / (1.0 - r2)).sqrt().atan() / PI;
    let height = SQ * ((1.0 - r1) / PI).sqrt() / (2.0 * share);
    [
        share,
        height,
        SQ * bend / (2.0 * share * (PI * (1.0 - r1)).sqrt()) / 1e-10,
    ]
}

#[derive(Clone, Copy)]
struct Estimate {
    mean: f64,
    error: f64,
}

/// Means over the faces and their standard errors.
fn estimate<const N: usize>(of: impl Fn(u64) -> [f64; N] + Sync) -> [Estimate; N] {
    let values: Vec<[f64; N]> = (0..FACES).into_par_iter().map(|k| of(100 + k)).collect();
    std::array::from_fn(|n| {
        let mean = values.iter().map(|v| v[n]).sum::<f64>() / FACES as f64;
        let variance = values.iter().map(|v| (v[n] - mean).powi(2)).sum::<f64>() / (FACES - 1) as f64;
        Estimate {
            mean,
            error: (variance / FACES as f64).sqrt(),
        }
    })
}

/// Within `bias` of theory, relative, and four standard errors.
fn agrees(name: &str, found: Estimate, theory: f64, bias: f64) {
    println!(
        "{name}: {:.6e} +- {:.1e}, theory {theory:.6e}, {:+.2} %",
        found.mean,
        found.error,
        100.0 * (found.mean / theory - 1.0)
    );
    assert!(
        (found.mean - theory).abs() < 4.0 * found.error + bias * theory.abs(),
        "{name}"
    );
    // The test means something: the standard error itself is small.
    assert!(found.error < 0.03 * theory.abs(), "{name}: {}", found.error);
}

#[test]
fn peaks_of_sampled_profiles() {
    for per_length in [0.2, 2.0, 6.0] {
        let [share, height, curvature] = sampled_peaks(per_length);
        let [peaks, ordinate, bend] = estimate(|seed| {
            let n = 400;
            let z = heights(&face(seed, n, [per_length; 2]));
            let (mut count, mut ordinates, mut curvatures) = (0.0, 0.0, 0.0);
            for row in z.chunks(n) {
                for peak in line_peaks(row, 10e-6, 0.0) {
                    count += 1.0;
                    ordinates += row[peak.index];
                    curvatures += peak.curvature;
                }
            }
            [count / (n * (n - 2)) as f64, ordinates / count, curvatures / count]
        });
        println!("{per_length} steps per correlation length");
        agrees("peaks per ordinate", peaks, share, 0.0);
        agrees("mean ordinate of the peaks", ordinate, height, 0.0);
        agrees("mean curvature of the peaks", bend, curvature, 0.0);
    }
}

fn areal(map: &HeightMap, pruning: f64) -> ArealParameters {
    let z = heights(map);
    let patch = ArealPatch {
        heights: &z,
        nx: map.nx(),
        step: map.step(),
        height_step: 0.0,
    };
    patch.parameters(pruning, |_| true).unwrap().unwrap()
}

#[test]
fn areal_parameters_of_gaussian_surfaces() {
    let (n, lengths) = (500, [6.0, 8.0]);
    let [sq, sa, ssk, sku, sdq] = estimate(|seed| {
        let a = areal(&face(seed, n, lengths), 0.05);
        [a.sq, a.sa, a.ssk.unwrap(), a.sku.unwrap(), a.sdq.unwrap()]
    });
    agrees("Sq", sq, SQ, 1e-3);
    agrees("Sa", sa, SQ * (2.0 / PI).sqrt(), 2e-3);
    agrees("Sku", sku, 3.0, 1e-2);
    println!("Ssk: {:.4} +- {:.4}, theory 0", ssk.mean, ssk.error);
    assert!(ssk.mean.abs() < 4.0 * ssk.error && ssk.error < 0.02);
    // Differences of neighbours: 2 m0 (1 - exp(-1/L^2))/d^2 each way, and sqrt(m2x + m2y) in the limit of small steps.
    let sampled = |l: f64| 2.0 * (1.0 - (-1.0 / (l * l)).exp());
    let gradient = SQ / 10e-6 * (sampled(lengths[0]) + sampled(lengths[1])).sqrt();
    let limit = SQ / 10e-6 * (2.0 / lengths[0].powi(2) + 2.0 / lengths[1].powi(2)).sqrt();
    agrees("Sdq", sdq, gradient, 1e-3);
    agrees("Sdq against the limit of small steps", sdq, limit, 0.01);
}

#[test]
fn summits_of_isotropic_surfaces() {
    // Nayak, J. Lubr. Technol. 93 (1971): m4/(6 sqrt(3) pi m2) summits per area, their mean height 4 sqrt(m0/(pi alpha)),
    // and mean curvature (8/3) sqrt(m4/pi).
    let of = |per_length: f64, n: usize| {
        let l = per_length * 10e-6;
        let (m2, m4) = (2.0 * (SQ / l).powi(2), 12.0 * (SQ / (l * l)).powi(2));
        estimate(|seed| {
            let map = face(seed, n, [per_length; 2]);
            let a = areal(&map, 0.0);
            let found = summits(&heights(&map), n, 0.0);
            assert_eq!(found.len(), a.peaks);
            let height = found.iter().map(|s| s.height).sum::<f64>() / found.len() as f64;
            [
                // Points on the border are not resolved.
                a.spd * ((n * n) as f64 / ((n - 2) * (n - 2)) as f64) / (m4 / (6.0 * 3f64.sqrt() * PI * m2)),
                height / (4.0 * SQ / (3.0 * PI).sqrt()),
                a.spc.unwrap() / (8.0 / 3.0 * (m4 / PI).sqrt()),
            ]
        })
    };
    for (per_length, n, bias) in [(6.0, 500, [0.02, 0.01, 0.03]), (12.0, 1000, [0.01, 0.01, 0.01])] {
        println!("{per_length} steps per correlation length, over theory");
        let found = of(per_length, n);
        for (k, name) in ["summit density", "mean summit height", "mean summit curvature"]
            .into_iter()
            .enumerate()
        {
            agrees(name, found[k], 1.0, bias[k]);
        }
    }
}

#[test]
fn elements_find_the_curvature_of_their_profiles() {
    // 25 elements of 120 x 120 points away from the grid's border, with correlation lengths of 5 and 9 steps.
    let lengths = [5.0, 9.0];
    let nodes = (0..36)
        .map(|k| [f64::from(k % 6) * 1.2e-3 + 95e-6, f64::from(k / 6) * 1.2e-3 + 95e-6])
        .collect();
    let quads = (0..25u32)
        .map(|e| {
            let a = e / 5 * 6 + e % 5;
            vec![a, a + 1, a + 7, a + 6]
        })
        .collect();
    let elements = ElementOutlines::try_new(nodes, quads).unwrap();
    let steel = ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    };
    let mut options = Options::new(steel);
    options.bootstrap.realisations = 0;
    for axis in 0..2 {
        let [share, _, curvature] = sampled_peaks(lengths[axis]);
        // Points on the outline of all elements have no neighbour beyond it: two of 600 are never peaks.
        let share = share * 598.0 / 600.0;
        let [inverse, peaks, samples, single, doubled] = estimate(|seed| {
            let map = face(seed, 620, lengths);
            let found = characterise(&map, &map, &elements, &options).unwrap();
            let mut sums = [0.0; 5];
            for e in &found.elements {
                let (f, resolution) = (&e.faces[0], &e.faces[0].resolution);
                let each = [
                    1.0 / f.radius[axis].unwrap(),
                    f.peaks[axis] as f64 / f.points as f64,
                    resolution.samples_per_peak[axis].unwrap(),
                    resolution.curvature[axis].unwrap(),
                    resolution.curvature_at_double_step[axis].unwrap(),
                ];
                for (sum, value) in sums.iter_mut().zip(each) {
                    *sum += value / found.elements.len() as f64;
                }
            }
            sums
        });
        agrees("1/radius of the elements", inverse, curvature, 2e-3);
        agrees("peaks per point", peaks, share, 2e-3);
        agrees("samples per peak", samples, 1.0 / share, 2e-3);
        // On a smooth surface twice the step sees nearly the same curvature.
        println!(
            "axis {axis}: at twice the step {:.3} of the curvature",
            doubled.mean / single.mean
        );
        assert!((0.85..1.0).contains(&(doubled.mean / single.mean)));
    }
}

#[test]
fn scatter_of_sums_over_few_heights() {
    // Relative rms of the traction of N_s independent Gaussian heights: sqrt((F_3/F_1.5^2 - 1)/N_s) at separation h with
    // F_n(h) = int_h^inf (t - h)^n phi(t) dt.
    let partial = |n: f64, h: f64| {
        let steps = 20_000;
        let width = 12.0 / f64::from(steps);
        (0..steps)
            .map(|k| {
                let t = (f64::from(k) + 0.5) * width;
                t.powf(n) * (-0.5 * (t + h).powi(2)).exp() / (2.0 * PI).sqrt() * width
            })
            .sum::<f64>()
    };
    assert!((partial(1.5, 0.0) / 0.43002 - 1.0).abs() < 2e-5);
    let unit = ElasticPair {
        youngs_modulus: 1.5 * 0.75,
        poisson_ratio: 0.5,
    };
    // White noise: every point is an independent height.
    let z: Vec<f64> = (0..4)
        .flat_map(|seed| heights(&face(500 + seed, 500, [1e-3; 2])))
        .map(|z| z / SQ)
        .collect();
    for (h, n) in [(0.0, 100), (1.0, 100), (1.0, 400), (2.0, 400)] {
        let sums: Vec<f64> = z
            .chunks_exact(n)
            .map(|sample| {
                let pop = PairAsperities::try_new(1.0, 1.0, [1.0; 2], 1.0, sample.to_vec()).unwrap();
                let u = pop.heights()[0] - h;
                traction_curves(&pop, unit, TangentialReading::Mindlin, &[u])
                    .unwrap()
                    .normal[0]
            })
            .collect();
        let count = sums.len() as f64;
        let mean = sums.iter().sum::<f64>() / count;
        let rms = (sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt() / mean;
        let (half, third) = (partial(1.5, h), partial(3.0, h));
        let theory = ((third / (half * half) - 1.0) / n as f64).sqrt();
        println!("h = {h}, N_s = {n}: {rms:.4} of {count} samples, theory {theory:.4}");
        assert!((mean / half - 1.0).abs() < 4.0 * theory / count.sqrt());
        // Relative standard error of an rms of skewed sums: below 3/sqrt(2 count) for these.
        assert!(
            (rms / theory - 1.0).abs() < 4.0 * 3.0 / (2.0 * count).sqrt(),
            "{rms} {theory}"
        );
    }
}
