//! Settings of a parameter against its last one: errors, limits, and what is uncertain of the scene in all.

use super::parameters::{AMPLITUDES, Parameter, Share};
use analyses::comparison::Backbone;
use analyses::error_bar::ErrorBar;
use analyses::results::trends::{Extrapolation, extrapolate};
use scenes::PRESETS;

/// A setting that was run.
pub(crate) struct Measured {
    /// Linearised frequency of the mode followed (Hz).
    pub(super) linear: f64,
    /// Over displacement.
    pub(super) backbone: Backbone,
    /// Of mesh, assembly and reduction (s).
    pub(super) structure_seconds: f64,
    /// Of everything else that its backbone needs (s).
    pub(super) interface_seconds: f64,
    pub(super) peak_memory: Option<u64>,
    pub(super) error_bar: ErrorBar,
    pub(super) not_converged: usize,
}

impl Measured {
    /// From nothing to the backbone.
    pub(super) fn seconds(&self) -> f64 {
        self.structure_seconds + self.interface_seconds
    }
}

/// How far a setting is from its reference.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Errors {
    /// Relative, of the linearised frequency.
    pub(crate) linear: f64,
    /// Of the frequency shift, relative to the linearised frequency, at the three amplitudes.
    pub(crate) shift: [Option<f64>; 3],
    /// Of the logarithm of the damping ratio there.
    pub(crate) damping: [Option<f64>; 3],
}

impl Errors {
    /// Largest relative error of a frequency.
    pub(crate) fn frequency(&self) -> f64 {
        let at = |shift: &Option<f64>| shift.map_or(0.0, |shift| (self.linear + shift).abs());
        self.shift.iter().map(at).fold(self.linear.abs(), f64::max)
    }

    /// Largest error of the logarithm of the damping ratio.
    pub(crate) fn damping(&self) -> Option<f64> {
        self.damping.iter().flatten().map(|e| e.abs()).reduce(f64::max)
    }
}

/// A setting with what came of it.
pub(crate) struct Outcomes {
    pub(crate) measured: Result<Measured, String>,
    pub(crate) errors: Option<Errors>,
    /// Whether no other setting of the parameter is both faster and nearer to the reference.
    pub(crate) pareto: bool,
}

/// The limit of a refinement, from its three finest settings.
pub(crate) struct Limit {
    /// What converges.
    pub(crate) quantity: &'static str,
    pub(crate) extrapolation: Option<Extrapolation>,
    /// Distance of the finest setting from the limit: relative of frequencies, of the logarithm of damping; zero where refinement changes
    /// nothing.
    pub(crate) uncertainty: Option<f64>,
}

/// A parameter that was measured.
pub(crate) struct Ladder {
    pub(crate) parameter: Parameter,
    pub(crate) outcomes: Vec<Outcomes>,
    pub(crate) limits: Vec<Limit>,
}

/// Judges the settings of a parameter by its last one.
pub(super) fn ladder(parameter: Parameter, measured: Vec<Result<Measured, String>>) -> Ladder {
    let errors: Vec<Option<Errors>> = match measured.last() {
        Some(Ok(reference)) => measured
            .iter()
            .map(|setting| setting.as_ref().ok().map(|setting| errors(setting, reference)))
            .collect(),
        _ => measured.iter().map(|_| None).collect(),
    };
    let limits = limits(&parameter, &measured);
    let cost: Vec<Option<(f64, f64)>> = measured
        .iter()
        .zip(&errors)
        .map(|(measured, errors)| {
            let (measured, errors) = (measured.as_ref().ok()?, errors.as_ref()?);
            let error = errors.damping().unwrap_or(f64::INFINITY).max(errors.frequency());
            Some((measured.seconds(), error))
        })
        .collect();
    let outcomes = measured
        .into_iter()
        .zip(errors)
        .enumerate()
        .map(|(index, (measured, errors))| {
            let beaten = |own: (f64, f64)| cost.iter().flatten().any(|other| other.0 < own.0 && other.1 < own.1);
            Outcomes {
                measured,
                errors,
                pareto: cost[index].is_some_and(|own| !beaten(own)),
            }
        })
        .collect();
    Ladder {
        parameter,
        outcomes,
        limits,
    }
}

/// How far a setting is from another.
pub(super) fn errors(setting: &Measured, reference: &Measured) -> Errors {
    let at = |amplitude: f64| setting.backbone.at(amplitude).zip(reference.backbone.at(amplitude));
    let shift = |amplitude| {
        let ((own, _), (right, _)) = at(amplitude)?;
        Some(((own - setting.linear) - (right - reference.linear)) / reference.linear)
    };
    let damping = |amplitude| {
        let ((_, own), (_, right)) = at(amplitude)?;
        Some((own? / right?).ln())
    };
    Errors {
        linear: setting.linear / reference.linear - 1.0,
        shift: AMPLITUDES.map(shift),
        damping: AMPLITUDES.map(damping),
    }
}

/// Limits of what a refinement converges to.
fn limits(parameter: &Parameter, measured: &[Result<Measured, String>]) -> Vec<Limit> {
    let sizes: Vec<Option<f64>> = parameter.settings.iter().map(|setting| setting.size).collect();
    let [.., Some(a), Some(b), Some(c)] = sizes[..] else {
        return Vec::new();
    };
    let [.., Ok(first), Ok(second), Ok(third)] = measured else {
        return Vec::new();
    };
    let of = |quantity, value: &dyn Fn(&Measured) -> Option<f64>, is_logarithm: bool| {
        let values = [first, second, third].map(value);
        let [Some(x), Some(y), Some(z)] = values else {
            return Limit {
                quantity,
                extrapolation: None,
                uncertainty: None,
            };
        };
        if x == y && y == z {
            return Limit {
                quantity,
                extrapolation: None,
                uncertainty: Some(0.0),
            };
        }
        let extrapolation = extrapolate([a, b, c], [x, y, z]);
        let distance = |e: &Extrapolation| {
            let difference = (z - e.limit).abs();
            if is_logarithm {
                difference
            } else {
                difference / e.limit.abs()
            }
        };
        Limit {
            quantity,
            uncertainty: extrapolation.as_ref().map(distance),
            extrapolation,
        }
    };
    vec![
        of("linearised frequency [Hz]", &|m| Some(m.linear), false),
        of(
            "ln(damping ratio) at the middle amplitude",
            &|m| Some(m.backbone.at(AMPLITUDES[1])?.1?.ln()),
            true,
        ),
    ]
}

/// Settings of scenes that are farther from the reference than their entry says.
pub(super) fn exceeded(ladders: &[Ladder]) -> Vec<(&'static str, String)> {
    let mut found = Vec::new();
    for ladder in ladders.iter().filter(|ladder| ladder.parameter.name == "accuracy") {
        for (setting, outcome) in PRESETS.iter().zip(&ladder.outcomes) {
            let Some(errors) = &outcome.errors else { continue };
            let (frequency, damping) = (errors.frequency(), errors.damping().unwrap_or(f64::INFINITY));
            if frequency > setting.frequency_error || damping > setting.damping_error {
                found.push((
                    setting.name,
                    format!(
                        "measured errors {frequency:.1e} and {damping:.1e}, but {:.1e} and {:.1e} are what scenes are promised",
                        setting.frequency_error, setting.damping_error
                    ),
                ));
            }
        }
    }
    found
}

/// A part of what is uncertain about the scene that the parameters are about.
pub(crate) struct Part {
    pub(crate) parameter: &'static str,
    pub(crate) kind: Share,
    /// Relative.
    pub(crate) frequency: f64,
    /// Of the logarithm of the damping ratio.
    pub(crate) damping_ln: f64,
}

/// Numerical errors by the settings whose results are those of the scene itself, choices and sampling by the setting that is farthest from
/// the reference.
pub(crate) fn budget(ladders: &[Ladder], own: &Measured) -> Vec<Part> {
    let part = |ladder: &Ladder| {
        let size = |errors: &Errors| [errors.frequency(), errors.damping().unwrap_or(0.0)];
        let all = || ladder.outcomes.iter().filter_map(|outcome| outcome.errors.as_ref());
        let farthest = || all().map(size).reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let [frequency, damping_ln] = match ladder.parameter.share {
            Share::None => return None,
            Share::Error => {
                // To the bit, also where a setting spells out the default.
                let is_own = |m: &Measured| m.linear == own.linear && m.backbone == own.backbone;
                let mut outcomes = ladder.outcomes.iter();
                let found = outcomes.find(|outcome| outcome.measured.as_ref().is_ok_and(is_own))?;
                let bar = (own.error_bar.frequency_relative).zip(own.error_bar.damping_ln);
                if let ("mesh", Some((frequency, damping_ln))) = (ladder.parameter.name, bar) {
                    // Against the limit of the mesh, which the refinements of scenes are too uneven to extrapolate to.
                    return Some(Part {
                        parameter: ladder.parameter.name,
                        kind: ladder.parameter.share,
                        frequency,
                        damping_ln,
                    });
                }
                let [frequency, damping] = found.errors.as_ref().map(size)?;
                // What the reference itself is away from the limit counts as well.
                let rest = |index: usize| {
                    ladder
                        .limits
                        .get(index)
                        .and_then(|limit| limit.uncertainty)
                        .unwrap_or(0.0)
                };
                [frequency + rest(0), damping + rest(1)]
            }
            Share::Choice | Share::Sampling => farthest()?,
        };
        Some(Part {
            parameter: ladder.parameter.name,
            kind: ladder.parameter.share,
            frequency,
            damping_ln,
        })
    };
    ladders.iter().filter_map(part).collect()
}

/// All numerical errors together: relative of frequencies, of the logarithm of damping.
pub(crate) fn total(budget: &[Part]) -> [f64; 2] {
    let errors = || budget.iter().filter(|part| part.kind == Share::Error);
    let root = |of: fn(&Part) -> f64| errors().map(|part| of(part).powi(2)).sum::<f64>().sqrt();
    [root(|part| part.frequency), root(|part| part.damping_ln)]
}
