//! What came of a case.

use analyses::{Error, Run};
use anyhow::{Context, Result};
use serde_json::{Map, Value, json};

/// Outcome, work and checks of a case.
#[derive(Default)]
pub(super) struct Findings {
    /// In a few words.
    pub(super) outcome: String,
    /// Newton iterations of all runs of the case.
    pub(super) iterations: Option<usize>,
    checks: Vec<(String, Check)>,
}

struct Check {
    holds: bool,
    account: Value,
}

/// Largest magnitude; NaN, where there is one.
pub(super) fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    values
        .into_iter()
        .fold(0.0, |m: f64, v| if m.is_nan() || v.abs() <= m { m } else { v.abs() })
}

/// What the message of a refusal must name.
pub(super) struct Refusal<'a> {
    pub(super) place: &'a str,
    pub(super) value: &'a str,
    pub(super) remedy: &'a str,
}

impl Findings {
    /// A case that did not end as cases do.
    pub(super) fn defect(what: String) -> Self {
        let mut findings = Self::default();
        findings.that("came to an end", false);
        findings.outcome = what;
        findings
    }

    pub(super) fn passed(&self) -> bool {
        !self.checks.is_empty() && self.checks.iter().all(|(_, check)| check.holds)
    }

    /// Checks that do not hold.
    pub(super) fn broken(&self) -> impl Iterator<Item = (&str, &Value)> {
        let broken = self.checks.iter().filter(|(_, check)| !check.holds);
        broken.map(|(name, check)| (name.as_str(), &check.account))
    }

    pub(super) fn checks(&self) -> Map<String, Value> {
        let checks = self.checks.iter();
        checks
            .map(|(name, check)| (name.clone(), check.account.clone()))
            .collect()
    }

    fn add(&mut self, name: &str, holds: bool, mut account: Value) {
        account["holds"] = json!(holds);
        self.checks.push((name.to_owned(), Check { holds, account }));
    }

    /// Something that is so or is not.
    pub(super) fn that(&mut self, name: &str, holds: bool) {
        self.add(name, holds, json!({}));
    }

    /// A magnitude that must not exceed what is allowed; NaN does.
    pub(super) fn within(&mut self, name: &str, value: f64, allowed: f64) {
        self.add(
            name,
            value.abs() <= allowed,
            json!({ "value": value, "allowed": allowed }),
        );
    }

    /// A value between two others.
    pub(super) fn between(&mut self, name: &str, value: f64, low: f64, high: f64) {
        let holds = low <= value && value <= high;
        self.add(name, holds, json!({ "value": value, "allowed": [low, high] }));
    }

    /// A value that is known.
    pub(super) fn equal(&mut self, name: &str, value: f64, known: f64, tolerance: f64) {
        let error = value / known - 1.0;
        self.add(
            name,
            error.abs() <= tolerance,
            json!({ "value": value, "known": known, "error": error, "allowed": tolerance }),
        );
    }

    /// Counts the iterations of a run.
    pub(super) fn count(&mut self, run: &Run) {
        let of_loops = run
            .amplitudes()
            .iter()
            .map(|a| a.point.effort.iterations)
            .sum::<usize>();
        let of_prestress = run.prestress.solution.iterations.iter().sum::<usize>();
        *self.iterations.get_or_insert(0) += of_loops + of_prestress;
    }

    /// What holds for every sound run: finite numbers, vertical equilibrium, residuals as small as asked for, as much energy
    /// dissipated at the points as the loops do work, and convergence wherever there is an equilibrium.
    pub(super) fn sound(&mut self, prefix: &str, run: &Run) -> Result<()> {
        self.sound_within(prefix, run, run.scene.analyses.backbone.tolerance)
    }

    /// As [`Findings::sound`], with the residuals of loops that round-off allows.
    pub(super) fn sound_within(&mut self, prefix: &str, run: &Run, largest_residual: f64) -> Result<()> {
        self.count(run);
        let name = |what: &str| format!("{prefix}{what}");
        let p = &run.prestress;
        self.within(
            &name("equilibrium"),
            p.equilibrium_error,
            10.0 * p.residual_ratio + 1e-12,
        );
        self.within(&name("residual of the prestress"), p.residual_ratio, 1e-6);
        let mut finite = run.frequencies.iter().all(|f| f.is_finite());
        finite &= p.solution.displacement.iter().all(|u| u.is_finite());
        let (mut residual, mut energy) = (0.0_f64, 0.0_f64);
        for a in run.amplitudes() {
            let (Ok(r), Some(fields)) = (&a.point.result, &a.fields) else {
                continue;
            };
            let numbers = [
                r.modal_amplitude,
                r.omega,
                r.zeta,
                r.zeta_floor,
                r.loop_area,
                fields.dissipation,
            ];
            finite &= numbers.iter().all(|v| v.is_finite());
            residual = residual.max(r.residual);
            // A residual moves work between the modal force and the points.
            let work = a.point.modal_force * r.modal_amplitude;
            let allowed =
                1e-6 * fields.dissipation.abs() + 10.0 * run.scene.analyses.backbone.tolerance.max(r.residual) * work;
            energy = worst([energy, (fields.dissipation - r.loop_area).abs() / allowed]);
        }
        self.that(&name("all numbers are finite"), finite);
        if !run.amplitudes().is_empty() {
            self.within(&name("residual of the loops"), residual, largest_residual);
            self.within(&name("energy identity, of what is allowed"), energy, 1.0);
        }
        if let Some(limit) = run.validity().separation_modal_force {
            let found = run.amplitudes().iter().filter(|a| a.point.result.is_ok());
            let largest = found.map(|a| a.point.modal_force).fold(0.0, f64::max);
            self.within(
                &name("modal force with a result, over the bolts' limit"),
                largest / limit,
                1.0,
            );
        }
        let failed = run.amplitudes().iter().filter(|a| a.point.result.is_err());
        let least = failed.map(|a| a.point.modal_force).fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            let limit = run
                .validity()
                .separation_modal_force
                .context("nothing is known of what the bolts hold together")?;
            self.between(
                &name("modal force without an equilibrium, over the bolts' limit"),
                least / limit,
                1.0,
                f64::MAX,
            );
        }
        Ok(())
    }

    /// Frequencies and damping of `run` are those of `other` times a factor, at amplitudes of the response times another.
    pub(super) fn alike(&mut self, prefix: &str, run: &Run, other: &Run, factor: [f64; 2], tolerance: f64) {
        let name = |what: &str| format!("{prefix}{what}");
        let [of_frequency, of_motion] = factor;
        let pairs = run.frequencies.iter().zip(&other.frequencies);
        let linear = worst(pairs.map(|(a, b)| a / (b * of_frequency) - 1.0));
        self.within(&name("linear frequencies"), linear, tolerance);
        self.that(
            &name("the same number of results"),
            run.frequencies.len() == other.frequencies.len() && run.amplitudes().len() == other.amplitudes().len(),
        );
        let mut errors = [Vec::new(), Vec::new(), Vec::new()];
        for (a, b) in run.amplitudes().iter().zip(other.amplitudes()) {
            let (r, s) = match (&a.point.result, &b.point.result) {
                (Ok(r), Ok(s)) => (r, s),
                (Err(_), Err(_)) => continue,
                _ => {
                    errors[0].push(f64::NAN);
                    continue;
                }
            };
            errors[0].push(r.omega / (s.omega * of_frequency) - 1.0);
            let motion = [a, b].map(|a| a.response_displacement.unwrap_or(f64::NAN));
            errors[1].push(motion[0] / (motion[1] * of_motion) - 1.0);
            // The floors are of what residuals may do.
            let noise = r.zeta_floor + s.zeta_floor;
            errors[2].push(((r.zeta - s.zeta).abs() - noise).max(0.0) / s.zeta.abs().max(noise));
        }
        let [omega, motion, zeta] = errors.map(worst);
        self.within(&name("frequencies"), omega, tolerance);
        self.within(&name("response"), motion, tolerance);
        self.within(&name("damping"), zeta, tolerance);
    }

    /// A refusal whose message names place, value and remedy.
    pub(super) fn refused<T>(&mut self, prefix: &str, outcome: Result<T, Error>, refusal: &Refusal<'_>) {
        let name = |what: &str| format!("{prefix}{what}");
        let Err(error) = outcome else {
            self.outcome = "ran to its end".into();
            self.that(&name("refused"), false);
            return;
        };
        let text = error.to_string();
        for (what, word) in [
            ("names the place", refusal.place),
            ("names the value", refusal.value),
            ("names the remedy", refusal.remedy),
        ] {
            self.add(
                &name(what),
                text.contains(word),
                json!({ "text": text, "wanted": word }),
            );
        }
        self.outcome = format!("refused: {text}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a single check holds.
    fn holds(check: impl FnOnce(&mut Findings)) -> bool {
        let mut findings = Findings::default();
        check(&mut findings);
        findings.passed()
    }

    #[test]
    fn nothing_passes_unchecked_and_nan_fails_everything() {
        assert!(!Findings::default().passed());
        assert!(holds(|f| f.within("x", -2.0, 2.0)) && !holds(|f| f.within("x", -2.1, 2.0)));
        assert!(holds(|f| f.between("x", 1.0, 1.0, 2.0)) && !holds(|f| f.between("x", 2.1, 1.0, 2.0)));
        assert!(holds(|f| f.equal("x", 1.01, 1.0, 0.02)) && !holds(|f| f.equal("x", 1.03, 1.0, 0.02)));
        assert!(!holds(|f| f.within("x", f64::NAN, f64::MAX)));
        assert!(!holds(|f| f.between("x", f64::NAN, f64::MIN, f64::MAX)));
        assert!(!holds(|f| f.equal("x", f64::NAN, 1.0, f64::MAX)));
        assert!(worst([1.0, f64::NAN, -3.0]).is_nan());
        assert_eq!(worst([1.0, -3.0, 2.0]), 3.0);
        // One broken check of many breaks the case.
        let both = |f: &mut Findings| {
            f.that("a", true);
            f.that("b", false);
        };
        assert!(!holds(both));
    }

    #[test]
    fn a_refusal_must_name_place_value_and_remedy() {
        let outcome = || {
            Err::<(), Error>(
                joints::Error::NoContact {
                    load: 3.0,
                    closure: 1.0,
                    carried: 0.5,
                }
                .into(),
            )
        };
        let names = |remedy| Refusal {
            place: "bolt load",
            value: "3.0000e0 N",
            remedy,
        };
        assert!(holds(|f| f.refused("", outcome(), &names("check the gap"))));
        assert!(!holds(|f| f.refused("", outcome(), &names("buy new bolts"))));
        assert!(!holds(|f| f.refused("", Ok(()), &names("check the gap"))));
    }
}
