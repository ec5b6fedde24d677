//! Periodic motions: pictures and arrays of EPMC backbones and forced responses.

use crate::plot::{
    Canvas, Curve, Marks, Points, amplitude_label, bounds, decimals, log, margin, panel, picture, power, ticks, widen,
};
use crate::{Drawing, Error};
use analyses::Run;
use analyses::epmc::PointLoop;
use analyses::forced::ForcedSummary;
use analyses::results::summary::{MethodSummary, Summary};
use matrix_files::npz;
use matrix_files::value::{Array, Dense};
use plotters::prelude::*;
use scenes::EPMC;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

const SIZE: (u32, u32) = (900, 1000);

/// Room beside the curves for the legend, over their range of frequencies.
const LEGEND: f64 = 0.27;

/// Most names that a legend has room for.
const NAMES: usize = 10;

/// Shares of harmonics below this are round-off.
const NO_SHARE: f64 = 1e-12;

/// Parts that a line is divided into where it is cut at the edge of a diagram.
const PARTS: usize = 64;

/// What the arrays are; goes with them.
pub(crate) const ABOUT: &str = "\
Periodic motions; SI units, vectors are columns.
epmc_*: free motions by EPMC, a row per mode and amplitude that converged. epmc_mode (from 1), epmc_modal_amplitude [sqrt(kg) m],
epmc_displacement [m] (first harmonic at the response point), epmc_frequency [Hz] (first harmonic), epmc_damping_ratio and
epmc_damping_floor [-], epmc_dissipation [J], epmc_residual [-], epmc_share_of_harmonics [-] (a column per harmonic from the first
on, amplitude over that of the first in the norm of the mass; 0 beyond epmc_harmonics, the highest one that was solved for).
forced_*: forced responses, a row per point along the curve of each level. forced_level [N], of moving
supports [m/s^2], of responses that are held [m], forced_force [N] or [m/s^2], forced_frequency [Hz],
forced_amplitude [m] (first harmonic at the response point), forced_phase [degrees behind the force], forced_harmonics [m] (a column per
harmonic from the first on), forced_residual [-], forced_turning (1 where the frequency turns back, else 0).
resonance_*: motions a quarter period behind the force. resonance_level [N], resonance_frequency [Hz], resonance_amplitude [m].
single_mode_*: responses of the nonlinear mode alone, from its EPMC backbone. single_mode_level [N], single_mode_frequency [Hz],
single_mode_amplitude [m], single_mode_phase [degrees].
Groups that a run does not have are left out.
";

/// What a run found of periodic motions.
#[derive(Clone, Debug)]
pub(crate) struct PeriodicMotions<'a> {
    /// EPMC backbones with their modes, counted from 1.
    pub epmc: Vec<(usize, &'a [MethodSummary])>,
    /// Forced responses, level by level.
    pub forced: &'a [ForcedSummary],
    /// Responses of the nonlinear mode alone, level by level.
    pub single_mode: Vec<Vec<SingleModePoint>>,
    /// The response point in words.
    pub response: &'a str,
}

/// The points of a curve that are not unstable, and those that are with their neighbours.
fn by_stability(level: &ForcedSummary, points: Points) -> [Points; 2] {
    let stable = level.floquet.as_ref().map_or(&[][..], |found| &found.stable);
    let is_unstable = |i: usize| stable.get(i) == Some(&Some(false));
    let beside = |i: usize| (i.saturating_sub(1)..i + 2).any(is_unstable);
    let dotted = points.iter().copied().filter(|p| beside(p.0)).collect();
    [points.into_iter().filter(|p| !is_unstable(p.0)).collect(), dotted]
}

/// A number of a free motion.
type Value = fn(&MethodSummary) -> Option<f64>;

/// A point of the response of the nonlinear mode alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SingleModePoint {
    /// Frequency of the force (Hz).
    pub frequency_hz: f64,
    /// Amplitude of the first harmonic at the response point (m).
    pub amplitude: f64,
    /// How far it lags behind the force (degrees), from 0 to 360.
    pub phase: f64,
}

impl<'a> PeriodicMotions<'a> {
    /// Those of a run; none where its scene asks for none.
    pub(crate) fn of(run: &Run, summary: &'a Summary) -> Option<Self> {
        let first = [(run.first().mode, &summary.methods)];
        let further = summary.backbones.iter().skip(1).map(|of| (of.mode, &of.methods));
        let epmc: Vec<_> = first
            .into_iter()
            .chain(further)
            .filter_map(|(mode, methods)| Some((mode, methods.get(EPMC)?.as_slice())))
            .filter(|(_, points)| !points.is_empty())
            .collect();
        let single_mode = run.vibration.forced.iter().flatten().map(|level| {
            let points = level.synthesis.iter().map(|p| SingleModePoint {
                frequency_hz: p.omega / TAU,
                amplitude: p.displacement,
                phase: p.phase.to_degrees().rem_euclid(360.0),
            });
            points.collect()
        });
        let found = Self {
            epmc,
            forced: &summary.forced,
            single_mode: single_mode.collect(),
            response: &summary.response,
        };
        (!found.epmc.is_empty() || !found.forced.is_empty()).then_some(found)
    }

    /// Amplitude above, phase below, against frequency: a curve per level, with turning points, resonances, the EPMC backbones
    /// and the responses of the nonlinear mode alone. None without forced responses.
    ///
    /// # Errors
    /// [`Error::Picture`].
    pub(crate) fn response_picture(&self, title: &str) -> Result<Option<String>, Error> {
        let frequencies = self.forced.iter().flat_map(|level| level.frequency.iter().copied());
        let amplitudes = self.forced.iter().flat_map(|level| level.ordinate().iter().copied());
        let (Some(x), Some(y)) = (bounds(frequencies), bounds(amplitudes.filter(|a| *a > 0.0))) else {
            return Ok(None);
        };
        let picture = picture("the forced responses", SIZE, |root| {
            let root = root.titled(title, ("sans-serif", 20))?;
            let (upper, lower) = root.split_vertically(SIZE.1 * 3 / 5);
            let Range { start, end } = margin(&x);
            let x = start..end + LEGEND * (end - start);
            self.amplitudes(&upper, x.clone(), &widen(&y, 1.5))?;
            self.phases(&lower, x)
        });
        picture.map(Some)
    }

    fn amplitudes(&self, area: &Canvas<'_>, x: Range<f64>, y: &Range<f64>) -> Result<(), Drawing> {
        let n = self.forced.len();
        let mut curves = Vec::new();
        for (index, level) in self.forced.iter().enumerate() {
            let points = level.frequency.iter().zip(level.ordinate());
            let [stable, unstable] = by_stability(level, numbered(points.map(|(f, a)| (*f, *a))));
            curves.push(Curve {
                name: named(index, n, || format!("{} {}", short(level.level), level.level_unit)),
                points: stable,
                ..solid(shade(index, n))
            });
            curves.push(Curve {
                dashes: Some((1, 3)),
                points: unstable,
                ..solid(shade(index, n))
            });
        }
        let swept = self.forced.iter().map(|level| level.sweep.as_ref()?.in_time.as_ref());
        for (index, swept) in swept.enumerate().filter_map(|(index, swept)| Some((index, swept?))) {
            let line = numbered(swept.frequency_hz.iter().copied().zip(swept.amplitude.iter().copied()));
            curves.push(Curve {
                name: (if index == 0 { "sweep in time" } else { "" }).into(),
                dashes: Some((8, 3)),
                points: inside(&line, &x, y),
                ..solid(shade(index, n))
            });
        }
        let alone = self
            .single_mode
            .iter()
            .enumerate()
            .filter(|(_, points)| !points.is_empty());
        for (place, (index, points)) in alone.enumerate() {
            let line = numbered(points.iter().map(|p| (p.frequency_hz, p.amplitude)));
            curves.push(Curve {
                name: (if place == 0 { "nonlinear mode alone" } else { "" }).into(),
                dashes: Some((4, 4)),
                points: inside(&line, &x, y),
                ..solid(shade(index, n))
            });
        }
        for (mode, points) in self.epmc.iter().filter(|_| !self.holds_response()) {
            let points = points.iter().enumerate();
            let line = points.filter_map(|(i, p)| Some((i, p.frequency_first_harmonic_hz?, p.response_displacement?)));
            let line: Points = line.collect();
            curves.push(Curve {
                name: match self.epmc.len() {
                    1 => "EPMC backbone".into(),
                    _ => format!("EPMC backbone, mode {mode}"),
                },
                points: inside(&line, &x, y),
                ..solid(BLACK)
            });
            curves.push(Curve {
                marks: Marks::Bounds,
                points: line.into_iter().filter(|p| within((p.1, p.2), &x, y)).collect(),
                ..solid(BLACK)
            });
        }
        curves.extend(self.marks(|level, i| level.ordinate().get(i).copied(), |amplitude| amplitude, true));
        let (x_text, y_ticks) = (decimals(&x), ticks(y));
        panel(
            area,
            x,
            log(y, &y_ticks),
            match self.holds_response() {
                true => "amplitude of the force [N]",
                false => "amplitude, first harmonic [m]",
            },
            "",
            [&x_text, &power],
            &curves,
            &[],
            SeriesLabelPosition::UpperRight,
        )
    }

    fn phases(&self, area: &Canvas<'_>, x: Range<f64>) -> Result<(), Drawing> {
        let n = self.forced.len();
        let mut curves = vec![Curve {
            dashes: Some((2, 4)),
            points: numbered([(x.start, 90.0), (x.end, 90.0)].into_iter()),
            ..solid(RGBColor(110, 110, 110))
        }];
        for (index, level) in self.forced.iter().enumerate() {
            let points = level.frequency.iter().zip(&level.phase);
            let [stable, unstable] = by_stability(level, numbered(points.map(|(f, p)| (*f, lag(*p)))));
            for (points, dashes) in [(stable, None), (unstable, Some((1, 3)))] {
                curves.push(Curve {
                    points,
                    dashes,
                    ..solid(shade(index, n))
                });
            }
        }
        for (index, points) in self.single_mode.iter().enumerate() {
            curves.push(Curve {
                dashes: Some((4, 4)),
                points: numbered(points.iter().map(|p| (p.frequency_hz, lag(p.phase)))),
                ..solid(shade(index, n))
            });
        }
        curves.extend(self.marks(|level, i| level.phase.get(i).copied().map(lag), |_| 90.0, false));
        let phases = curves.iter().flat_map(|curve| curve.points.iter().map(|p| p.2));
        let y = bounds(phases.chain([0.0, 180.0])).unwrap_or(0.0..180.0);
        let x_text = decimals(&x);
        let label = "frequency [Hz]";
        panel(
            area,
            x,
            margin(&y),
            "phase behind the force [°]",
            label,
            [&x_text, &|v| format!("{v:.0}")],
            &curves,
            &[],
            SeriesLabelPosition::LowerRight,
        )
    }

    /// Turning points and resonances; `turning` gives the ordinate of a point, `resonance` that of a resonance's amplitude.
    fn marks(
        &self,
        turning: fn(&ForcedSummary, usize) -> Option<f64>,
        resonance: fn(f64) -> f64,
        in_legend: bool,
    ) -> impl Iterator<Item = Curve> {
        let turns = self.forced.iter().flat_map(|level| {
            let indices = level.turning_points.iter();
            indices.filter_map(move |&i| Some((*level.frequency.get(i)?, turning(level, i)?)))
        });
        let resonances = self.forced.iter().flat_map(|level| &level.resonances);
        let held = self.holds_response();
        let resonances = resonances
            .filter_map(move |r| Some((r.frequency_hz?, resonance(if held { r.force } else { r.amplitude }?))));
        let kinds = [
            ("turning point", Marks::Triangles, numbered(turns)),
            ("resonance", Marks::Crosses, numbered(resonances)),
        ];
        kinds
            .into_iter()
            .filter(|(.., points)| !points.is_empty())
            .map(move |(name, marks, points)| Curve {
                name: (if in_legend { name } else { "" }).into(),
                marks,
                points,
                ..solid(BLACK)
            })
    }

    /// Whether the responses were held.
    fn holds_response(&self) -> bool {
        self.forced.iter().any(ForcedSummary::holds_response)
    }

    /// The arrays, named as [`ABOUT`] says.
    ///
    /// # Errors
    /// [`Error::Arrays`] for numbers that are not finite.
    pub(crate) fn arrays(&self) -> Result<BTreeMap<String, Array>, Error> {
        let mut arrays = Arrays::default();
        self.free_arrays(&mut arrays)?;
        self.forced_arrays(&mut arrays)?;
        let mut arrays = arrays.0;
        arrays.insert("about".into(), Array::Text(ABOUT.into()));
        Ok(arrays)
    }

    /// The arrays as a NumPy archive.
    ///
    /// # Errors
    /// [`Error::Arrays`] for numbers that are not finite.
    pub(crate) fn archive(&self) -> Result<Vec<u8>, Error> {
        npz::to_bytes(&self.arrays()?).map_err(|error| Error::Arrays(Box::new(error)))
    }

    fn free_arrays(&self, arrays: &mut Arrays) -> Result<(), Error> {
        let points = self.epmc.iter().flat_map(|&(mode, points)| {
            let converged = points.iter().filter(|p| p.converged);
            converged.map(move |p| (mode, p))
        });
        let points: Vec<_> = points.collect();
        if points.is_empty() {
            return Ok(());
        }
        let integers = |of: fn(&(usize, &MethodSummary)) -> usize| points.iter().map(of).collect::<Vec<_>>();
        arrays.integers("epmc_mode", &integers(|(mode, _)| *mode))?;
        arrays.integers("epmc_harmonics", &integers(|(_, p)| p.harmonics.unwrap_or(0)))?;
        let columns: [(&str, Value); 7] = [
            ("epmc_modal_amplitude", |p| p.modal_amplitude),
            ("epmc_displacement", |p| p.response_displacement),
            ("epmc_frequency", |p| p.frequency_first_harmonic_hz),
            ("epmc_damping_ratio", |p| p.damping_ratio),
            ("epmc_damping_floor", |p| p.damping_floor),
            ("epmc_dissipation", |p| p.dissipation),
            ("epmc_residual", |p| p.residual),
        ];
        for (name, value) in columns {
            // Motions that converged have all of them; one that does not cannot be told by a number.
            let values: Option<Vec<f64>> = points.iter().map(|(_, p)| value(p)).collect();
            if let Some(values) = values {
                arrays.column(name, values)?;
            }
        }
        let shares = points
            .iter()
            .map(|(_, p)| p.share_of_harmonics.as_deref().unwrap_or_default());
        arrays.rows("epmc_share_of_harmonics", &shares.collect::<Vec<_>>())
    }

    fn forced_arrays(&self, arrays: &mut Arrays) -> Result<(), Error> {
        if self.forced.is_empty() {
            return Ok(());
        }
        let forced = self.forced;
        let each = |of: fn(&ForcedSummary) -> &[f64]| forced.iter().flat_map(of).copied().collect::<Vec<f64>>();
        let levels = forced
            .iter()
            .flat_map(|level| level.frequency.iter().map(|_| level.level));
        arrays.column("forced_level", levels.collect())?;
        arrays.column("forced_frequency", each(|level| &level.frequency))?;
        arrays.column("forced_force", each(|level| &level.force))?;
        arrays.column("forced_amplitude", each(|level| &level.amplitude))?;
        arrays.column("forced_phase", each(|level| &level.phase))?;
        arrays.column("forced_residual", each(|level| &level.residual))?;
        let harmonics = forced
            .iter()
            .flat_map(|level| level.harmonics.iter().map(Vec::as_slice));
        arrays.rows("forced_harmonics", &harmonics.collect::<Vec<_>>())?;
        let turning = forced.iter().flat_map(|level| {
            let points = 0..level.frequency.len();
            points.map(|i| usize::from(level.turning_points.contains(&i)))
        });
        arrays.integers("forced_turning", &turning.collect::<Vec<_>>())?;

        let resonances = forced.iter().flat_map(|level| {
            let found = level.resonances.iter();
            found.filter_map(|r| Some([level.level, r.frequency_hz?, r.amplitude?]))
        });
        let resonances: Vec<_> = resonances.collect();
        arrays.columns("resonance", ["level", "frequency", "amplitude"], &resonances)?;
        let alone = forced.iter().zip(&self.single_mode).flat_map(|(level, points)| {
            let row = |p: &SingleModePoint| [level.level, p.frequency_hz, p.amplitude, p.phase];
            points.iter().map(row)
        });
        let alone: Vec<_> = alone.collect();
        arrays.columns("single_mode", ["level", "frequency", "amplitude", "phase"], &alone)
    }
}

/// Share of each harmonic above the first in an EPMC backbone, over the amplitude; both logarithmic.
///
/// # Errors
/// [`Error::Picture`].
pub(crate) fn harmonics_picture(points: &[MethodSummary], response: &str, title: &str) -> Result<String, Error> {
    let share = |p: &MethodSummary, h: usize| p.share_of_harmonics.as_ref()?.get(h - 1).copied();
    let highest = points.iter().filter_map(|p| Some(p.share_of_harmonics.as_ref()?.len()));
    let highest = highest.max().unwrap_or(1);
    let curves = (2..=highest).map(|h| {
        let points = points.iter().enumerate();
        let points = points.filter_map(|(i, p)| Some((i, p.response_displacement?, share(p, h)?)));
        Curve {
            name: named(h - 2, highest - 1, || format!("harmonic {h}")),
            marks: Marks::Dots,
            points: points.filter(|p| p.2 > NO_SHARE).collect(),
            ..solid(shade(h - 2, highest - 1))
        }
    });
    let curves: Vec<Curve> = curves.collect();
    picture("the harmonics", (800, 480), |root| {
        let root = root.titled(title, ("sans-serif", 20))?;
        let all = || curves.iter().flat_map(|curve| &curve.points);
        let amplitudes = points.iter().filter_map(|p| p.response_displacement);
        let x = widen(&bounds(amplitudes).unwrap_or(1e-6..1e-3), 1.3);
        let y = widen(&bounds(all().map(|p| p.2)).unwrap_or(1e-6..1.0), 2.0);
        let (x_ticks, y_ticks) = (ticks(&x), ticks(&y));
        panel(
            &root,
            log(&x, &x_ticks),
            log(&y, &y_ticks),
            "share of the first harmonic [-]",
            &format!("{} [m]", amplitude_label(response)),
            [&power, &power],
            &curves,
            &[],
            SeriesLabelPosition::LowerRight,
        )
    })
}

/// A line of this colour without points and name.
/// Hysteresis loops of single points: the tangential traction against the jump in the direction in which the largest one moves most,
/// both from their means.
///
/// # Errors
/// [`Error::Picture`].
pub(crate) fn loops_picture(loops: &[PointLoop], title: &str) -> Result<String, Error> {
    let extent = |values: &[f64]| bounds(values.iter().copied()).map_or(0.0, |range| range.end - range.start);
    let last = loops.last().map(|found| &found.history.jump);
    let q = usize::from(last.is_some_and(|jump| extent(&jump[1]) > extent(&jump[0])));
    let from_mean = |values: &[f64], unit: f64| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter().map(|v| (v - mean) / unit).collect()
    };
    let curves: Vec<Curve> = loops
        .iter()
        .enumerate()
        .map(|(index, found)| {
            let history = &found.history;
            let (jump, traction) = (from_mean(&history.jump[q], 1e-6), from_mean(&history.traction[q], 1e6));
            let closed = jump.iter().zip(&traction).chain(jump.first().zip(traction.first()));
            Curve {
                name: named(index, loops.len(), || {
                    format!("point {}, q = {}", history.point + 1, short(found.modal_amplitude))
                }),
                points: numbered(closed.map(|(x, y)| (*x, *y))),
                ..solid(shade(index, loops.len()))
            }
        })
        .collect();
    picture("the loops", (800, 560), |root| {
        let root = root.titled(title, ("sans-serif", 20))?;
        let all = || curves.iter().flat_map(|curve| &curve.points);
        let x = margin(&bounds(all().map(|p| p.1)).unwrap_or(-1.0..1.0));
        let y = margin(&bounds(all().map(|p| p.2)).unwrap_or(-1.0..1.0));
        let (x_text, y_text) = (decimals(&x), decimals(&y));
        panel(
            &root,
            x,
            y,
            "tangential traction [MPa]",
            "tangential jump [um]",
            [&x_text, &y_text],
            &curves,
            &[],
            SeriesLabelPosition::LowerRight,
        )
    })
}

fn solid(colour: RGBColor) -> Curve {
    Curve {
        name: String::new(),
        colour,
        dashes: None,
        marks: Marks::None,
        points: Vec::new(),
    }
}

fn numbered(points: impl Iterator<Item = (f64, f64)>) -> Points {
    points.enumerate().map(|(i, (x, y))| (i, x, y)).collect()
}

/// The name, for so many curves of `n` as the legend has room for.
fn named(index: usize, n: usize, name: impl FnOnce() -> String) -> String {
    let stride = n.div_ceil(NAMES).max(1);
    if index.is_multiple_of(stride) {
        name()
    } else {
        String::new()
    }
}

/// A number with four digits at most.
pub(crate) fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    rounded.to_string()
}

/// A phase lag (degrees) from -90 to 270, so that neither a motion in phase nor one against it jumps by a turn with the sign of
/// round-off.
fn lag(phase: f64) -> f64 {
    (phase + 90.0).rem_euclid(360.0) - 90.0
}

/// Colours of an ordered series, from blue to red.
pub(crate) fn shade(index: usize, n: usize) -> RGBColor {
    const STOPS: [[f64; 3]; 5] = [
        [31.0, 93.0, 153.0],
        [33.0, 145.0, 140.0],
        [110.0, 160.0, 40.0],
        [214.0, 126.0, 0.0],
        [178.0, 40.0, 46.0],
    ];
    let last = STOPS.len() - 1;
    let place = last as f64 * index as f64 / n.saturating_sub(1).max(1) as f64;
    let stop = (place as usize).min(last - 1);
    let mix = |c: usize| STOPS[stop][c] + (place - stop as f64) * (STOPS[stop + 1][c] - STOPS[stop][c]);
    let [r, g, b] = [0, 1, 2].map(|c| mix(c).round() as u8);
    RGBColor(r, g, b)
}

/// Whether a point is within both ranges.
fn within(p: (f64, f64), x: &Range<f64>, y: &Range<f64>) -> bool {
    (x.start..=x.end).contains(&p.0) && (y.start..=y.end).contains(&p.1)
}

/// The part of a line over a linear abscissa and a logarithmic ordinate that lies within both ranges, with a gap in the numbers of its
/// points wherever the line leaves them.
fn inside(line: &[(usize, f64, f64)], x: &Range<f64>, y: &Range<f64>) -> Points {
    let mut out = Points::new();
    let mut number = 0;
    for pair in line.windows(2) {
        let [(first, x0, y0), (second, x1, y1)] = [pair[0], pair[1]];
        if first + 1 != second {
            number += 1;
            continue;
        }
        let parts = match within((x0, y0), x, y) && within((x1, y1), x, y) {
            true => 1,
            false => PARTS,
        };
        let points = (0..=parts).map(|i| {
            let t = i as f64 / parts as f64;
            (x0 + t * (x1 - x0), y0 * (y1 / y0).powf(t))
        });
        let points: Vec<(usize, (f64, f64))> = points.enumerate().filter(|(_, p)| within(*p, x, y)).collect();
        let (Some(&(enters, from)), Some(&(leaves, to))) = (points.first(), points.last()) else {
            number += 1;
            continue;
        };
        number += usize::from(enters > 0);
        out.push((number, from.0, from.1));
        out.push((number + 1, to.0, to.1));
        number += 2 + usize::from(leaves < parts);
    }
    out
}

/// Arrays by name.
#[derive(Default)]
struct Arrays(BTreeMap<String, Array>);

impl Arrays {
    fn column(&mut self, name: &str, values: Vec<f64>) -> Result<(), Error> {
        let array = Dense::try_new(values.len(), 1, values).map_err(|error| Error::Arrays(Box::new(error)))?;
        self.0.insert(name.into(), Array::Dense(array));
        Ok(())
    }

    fn integers(&mut self, name: &str, values: &[usize]) -> Result<(), Error> {
        let values: Vec<i64> = values.iter().map(|v| i64::try_from(*v).unwrap_or(i64::MAX)).collect();
        let array = Dense::try_new(values.len(), 1, values).map_err(|error| Error::Arrays(Box::new(error)))?;
        self.0.insert(name.into(), Array::Integers(array));
        Ok(())
    }

    /// Rows of different lengths, filled up with zeros.
    fn rows(&mut self, name: &str, rows: &[&[f64]]) -> Result<(), Error> {
        let n = rows.iter().map(|row| row.len()).max().unwrap_or(0);
        let values = rows
            .iter()
            .flat_map(|row| (0..n).map(|k| row.get(k).copied().unwrap_or(0.0)));
        let array =
            Dense::try_from_rows(rows.len(), n, values.collect()).map_err(|error| Error::Arrays(Box::new(error)))?;
        self.0.insert(name.into(), Array::Dense(array));
        Ok(())
    }

    /// One array per column of the rows, named after the group; none for a group without rows.
    fn columns<const N: usize>(&mut self, group: &str, names: [&str; N], rows: &[[f64; N]]) -> Result<(), Error> {
        for (k, name) in names.iter().enumerate().filter(|_| !rows.is_empty()) {
            self.column(&format!("{group}_{name}"), rows.iter().map(|row| row[k]).collect())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{csv, markup};
    use file_io::Source;
    use serde_json::json;

    fn level(level: f64, frequency: &[f64], turning_points: &[usize]) -> ForcedSummary {
        let amplitude: Vec<f64> = frequency
            .iter()
            .map(|f| 1e-6 * level / (1.0 + (f - 168.0).abs()))
            .collect();
        let harmonics: Vec<Vec<f64>> = amplitude.iter().map(|a| vec![*a, 1e-3 * a, 0.1 * 1e-3 * a]).collect();
        let phase: Vec<f64> = frequency
            .iter()
            .map(|f| if *f < 168.0 { 1.0 / 3.0 } else { 180.0 })
            .collect();
        let value = json!({
            "level": level, "frequency": frequency, "amplitude": amplitude, "phase": phase, "harmonics": harmonics,
            "residual": vec![1e-9; frequency.len()], "turning_points": turning_points,
            "resonances": [
                { "frequency_hz": 168.25, "amplitude": 0.9e-6 * level, "residual": 1e-10, "failure": null },
                { "frequency_hz": null, "amplitude": null, "residual": null, "failure": "too many iterations" },
            ],
            "peak": [168.0, 1e-6 * level], "single_mode_peak": null, "single_mode_error": null,
            "stability": "not judged", "krylov_steps": 7, "failure": null,
        });
        serde_json::from_value(value).expect("a level")
    }

    fn free(frequency: Option<f64>, displacement: f64, shares: &[f64]) -> MethodSummary {
        MethodSummary {
            response_displacement: frequency.map(|_| displacement),
            frequency_hz: frequency,
            frequency_first_harmonic_hz: frequency,
            damping_ratio: frequency.map(|_| 0.01),
            damping_floor: frequency.map(|_| 1e-9),
            modal_amplitude: Some(displacement * 1.5),
            dissipation: frequency.map(|_| 1e-7),
            residual: frequency.map(|_| 1e-10),
            harmonics: frequency.map(|_| shares.len()),
            share_of_harmonics: frequency.map(|_| shares.to_vec()),
            converged: frequency.is_some(),
            failure: frequency.is_none().then(|| "diverged, twice".into()),
            ..MethodSummary::default()
        }
    }

    /// Two levels, the second with a turn, and a backbone with a point that did not converge and shares that grow in number.
    fn example(of: impl FnOnce(&PeriodicMotions<'_>)) {
        let forced = [
            level(0.5, &[160.0, 166.0, 168.0, 175.0], &[]),
            level(2.0, &[160.0, 167.0, 169.0, 168.5, 175.0], &[2, 3]),
        ];
        let epmc = [
            free(Some(169.5), 2e-7, &[1.0, 1e-3]),
            free(None, 5e-7, &[]),
            free(Some(168.5), 6e-7, &[1.0, 2e-3, 1e-5]),
            free(Some(167.5), 1e-6, &[1.0, 4e-3, 3e-5]),
        ];
        let alone = |frequency_hz, amplitude, phase| SingleModePoint {
            frequency_hz,
            amplitude,
            phase,
        };
        let single_mode = vec![
            Vec::new(),
            vec![
                alone(162.0, 3e-7, 1.0),
                alone(167.8, 1.1e-6, 90.0),
                alone(174.0, 2e-7, 179.0),
            ],
        ];
        of(&PeriodicMotions {
            epmc: vec![(1, &epmc)],
            forced: &forced,
            single_mode,
            response: "the tip",
        });
    }

    #[test]
    fn the_response_picture_names_levels_backbone_and_marks() {
        example(|motions| {
            let svg = motions
                .response_picture("a & b")
                .expect("a picture")
                .expect("forced responses");
            assert_eq!(markup::check(&svg), Ok(()));
            for text in [
                "a &amp; b",
                "0.5 N",
                "2 N",
                "EPMC backbone",
                "nonlinear mode alone",
                "turning point",
                "resonance",
                "amplitude, first harmonic [m]",
                "phase behind the force",
                "frequency [Hz]",
            ] {
                assert!(svg.contains(text), "`{text}` is not in the picture");
            }
            // Two turning points above and below, and one in the legend.
            assert_eq!(svg.matches("<polygon").count(), 5);
            let none = PeriodicMotions {
                forced: &[],
                ..motions.clone()
            };
            assert_eq!(none.response_picture("").expect("no error"), None);
        });
    }

    #[test]
    fn the_harmonics_picture_names_the_harmonics_above_the_first() {
        example(|motions| {
            let svg = harmonics_picture(motions.epmc[0].1, motions.response, "title").expect("a picture");
            assert_eq!(markup::check(&svg), Ok(()));
            for text in [
                "harmonic 2",
                "harmonic 3",
                "share of the first harmonic",
                "at the tip [m]",
            ] {
                assert!(svg.contains(text), "`{text}` is not in the picture");
            }
            assert!(!svg.contains("harmonic 1") && !svg.contains("harmonic 4"));
        });
    }

    #[test]
    fn tables_have_a_row_per_point_and_a_column_per_harmonic() {
        example(|motions| {
            let forced = csv::forced(motions.forced).expect("a table");
            let rows: Vec<Vec<&str>> = forced.lines().map(|line| line.split(',').collect()).collect();
            assert_eq!(
                rows[0],
                [
                    "level [N]",
                    "number",
                    "frequency [Hz]",
                    "amplitude [m]",
                    "phase_lag [deg]",
                    "amplitude_of_harmonic_2 [m]",
                    "amplitude_of_harmonic_3 [m]",
                    "residual [-]",
                    "turns"
                ]
            );
            assert_eq!(rows.len(), 1 + 4 + 5);
            let expected = &motions.forced[1];
            assert_eq!((rows[7][0], rows[7][1], rows[7][8]), ("2.0", "3", "true"));
            assert_eq!(rows[7][2].parse(), Ok(expected.frequency[2]));
            assert_eq!(rows[7][6].parse(), Ok(expected.harmonics[2][2]));
            assert_eq!(rows[6][8], "false");

            let epmc = csv::epmc(&motions.epmc).expect("a table");
            let mut lines = epmc.lines();
            let headings: Vec<&str> = lines.next().expect("headings").split(',').collect();
            assert_eq!(
                (headings[0], headings[1], headings.len()),
                ("mode", "number", 2 + 21 + 2 + 1)
            );
            let place = |name: &str| headings.iter().position(|heading| *heading == name).expect(name);
            let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
            assert_eq!(rows.len(), 4);
            let share = place("share_of_harmonic_3 [-]");
            assert_eq!([0, 2, 3].map(|row| rows[row][share]), ["", "1e-5", "3e-5"]);
            assert_eq!(rows[1][place("converged")], "false");
            assert!(epmc.contains("\"diverged, twice\""), "{epmc}");
        });
    }

    #[test]
    fn arrays_are_read_back_to_the_same_bits() {
        example(|motions| {
            let bytes = motions.archive().expect("an archive");
            let source = Source {
                name: "periodic.npz",
                bytes: &bytes,
            };
            let found = npz::parse(source).expect("what was written");
            assert!(found.skipped.is_empty());
            assert_eq!(found.arrays, motions.arrays().expect("finite numbers"));
            let shape = |name: &str| match &found.arrays[name] {
                Array::Dense(m) => (m.rows(), m.columns()),
                Array::Integers(m) => (m.rows(), m.columns()),
                other => panic!("{name}: {other:?}"),
            };
            assert_eq!(shape("forced_harmonics"), (9, 3));
            assert_eq!(shape("epmc_share_of_harmonics"), (3, 3));
            assert_eq!((shape("resonance_level"), shape("single_mode_phase")), ((2, 1), (3, 1)));
            let Array::Dense(harmonics) = &found.arrays["forced_harmonics"] else {
                panic!("no numbers");
            };
            let expected = &motions.forced[1].harmonics;
            for (i, row) in expected.iter().enumerate() {
                for (h, value) in row.iter().enumerate() {
                    assert_eq!(harmonics[(4 + i, h)].to_bits(), value.to_bits());
                }
            }
            // Every array is described.
            for name in found.arrays.keys().filter(|name| *name != "about") {
                assert!(ABOUT.contains(name.as_str()), "{name}");
            }
        });
    }

    #[test]
    fn lines_end_at_the_edge_of_the_diagram() {
        let line = vec![(0, 0.0, 1.0), (1, 10.0, 1.0), (2, 10.0, 100.0), (4, 5.0, 1.0)];
        let cut = inside(&line, &(5.0..20.0), &(0.5..10.0));
        let ends = (cut.first().expect("points"), cut.last().expect("points"));
        assert!(
            (ends.0.1 - 5.0).abs() < 0.2 && (ends.1.2 / 10.0 - 1.0).abs() < 0.1,
            "{ends:?}"
        );
        assert!(cut.iter().all(|p| within((p.1, p.2), &(5.0..20.0), &(0.5..10.0))));
        // One piece: the way back to the last point is missing.
        assert!(cut.windows(2).all(|pair| pair[0].0 + 1 == pair[1].0));
        assert_eq!(inside(&line[..2], &(0.0..20.0), &(0.5..10.0)).len(), 2);
    }

    #[test]
    fn legends_have_room_for_their_names() {
        for n in [1, 2, 10, 11, 500] {
            let named = (0..n).filter(|i| !named(*i, n, || "x".into()).is_empty()).count();
            assert!((1..=NAMES).contains(&named), "{named} of {n}");
        }
        assert_eq!(shade(0, 1), shade(0, 9));
        assert_ne!(shade(0, 2), shade(1, 2));
        assert_eq!([lag(90.0), lag(180.0), lag(-180.0)], [90.0, 180.0, 180.0]);
        assert!(lag(359.999_999_9).abs() < 1e-6);
    }
}
