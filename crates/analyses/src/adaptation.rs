//! Settings that are adapted to the errors that a scene bears.
//!
//! What misses more than its part of the error that is borne gets as much more as its error needs; what misses next to nothing gets less, once.

use super::amplitude::AmplitudeResult;
use super::dials::{AmplitudeError, Dial, DialError};
use super::error_bar;
use joint_model::benchmark::RefinementLevel;
use scenes::{Scene, Target};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Part of what a setting may miss below which it gets less.
const NEXT_TO_NOTHING: f64 = 0.1;

/// Part of the error borne that the mesh may take.
const OF_MESH: f64 = 0.5;

/// Largest growth of a number in a step.
const GROWTH: f64 = 2.5;

/// Smallest tolerance of residuals that is chosen.
const TIGHTEST: f64 = 1e-11;

/// Damping ratio of friction below which its error counts as if it were that of this ratio: what tests and materials add is larger.
const SMALLEST_DAMPING: f64 = 1e-4;

/// Settings that are adapted beside a benchmark's mesh, with the least and the most of each.
const ADAPTED: [(Dial, usize, usize); 4] = [
    (Dial::Points, 2, 5),
    (Dial::Bins, 4, 128),
    (Dial::Radii, 4, 64),
    (Dial::Vertices, 4, 128),
];

/// How settings were adapted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Adaptation {
    /// Relative error of frequencies that is borne.
    pub frequency: Option<f64>,
    /// Error of the logarithm of damping ratios that is borne; of those below 1e-4 it is in proportion to 1e-4.
    pub damping: Option<f64>,
    /// Whether the errors estimated of the run are not larger, at all amplitudes.
    pub met: bool,
    /// Where they are, the settings that miss most, the largest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limited_by: Vec<Dial>,
    /// Pilots at a few amplitudes, and runs at all of them; the last is that of the results.
    pub steps: Vec<AdaptationStep>,
}

/// Settings that were tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AdaptationStep {
    /// Loops.
    pub loops: usize,
    /// What they cost: equilibria, all cycles together.
    pub load_points: usize,
    /// Refinement of a benchmark's mesh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refinement: Option<RefinementLevel>,
    /// Numbers: points per direction, bins, radii, vertices per quarter.
    pub numbers: BTreeMap<Dial, usize>,
    /// Largest error over the loops; of damping ratios below 1e-4 it is in proportion to 1e-4.
    pub error: DialError,
    /// Largest error by each setting, likewise.
    pub of: BTreeMap<Dial, DialError>,
}

impl AdaptationStep {
    pub(super) fn of<'a>(scene: &Scene, bins: usize, amplitudes: impl Iterator<Item = &'a AmplitudeResult>) -> Self {
        let (mut loops, mut load_points) = (0, 0);
        let (mut error, mut of) = (DialError::default(), BTreeMap::<Dial, DialError>::new());
        for amplitude in amplitudes {
            loops += 1;
            load_points += amplitude.point.effort.solves;
            let Some(AmplitudeError {
                frequency_relative,
                damping_ln,
                of: parts,
            }) = &amplitude.error
            else {
                continue;
            };
            let zeta = amplitude.point.result.as_ref().map_or(0.0, |result| result.zeta.abs());
            let counted = |error: &DialError| DialError {
                damping_ln: error.damping_ln.map(|error| error * (zeta / SMALLEST_DAMPING).min(1.0)),
                ..*error
            };
            error.raise(&counted(&DialError {
                frequency_relative: *frequency_relative,
                damping_ln: *damping_ln,
            }));
            for (dial, part) in parts {
                of.entry(*dial).or_default().raise(&counted(part));
            }
        }
        let numbers = ADAPTED
            .iter()
            .filter_map(|(dial, ..)| Some((*dial, dial.number(scene, bins)?)));
        Self {
            loops,
            load_points,
            refinement: scene.structure.benchmark().map(|_| scene.model.refinement),
            numbers: numbers.collect(),
            error,
            of,
        }
    }

    /// Whether the errors are within a target. Where nothing is known of one, it is not.
    pub(super) fn meets(&self, target: &Target) -> bool {
        pairs(&self.error, target).all(|(error, target)| error.is_some_and(|error| error <= target))
    }

    /// What misses most of a target, the largest first; nothing where it is met.
    pub(super) fn limits(&self, target: &Target) -> Vec<Dial> {
        if self.meets(target) {
            return Vec::new();
        }
        let share = |part: &DialError| {
            let shares = pairs(part, target).map(|(error, target)| error.map_or(f64::INFINITY, |error| error / target));
            shares.fold(0.0, f64::max)
        };
        let mut all: Vec<(f64, Dial)> = self.of.iter().map(|(dial, part)| (share(part), *dial)).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let limit = 0.5 * all.first().map_or(0.0, |first| first.0);
        all.into_iter()
            .filter(|(share, _)| *share >= limit)
            .map(|(_, dial)| dial)
            .collect()
    }

    /// The scene with more of what misses a target, and with less of what misses next to nothing if it `may_shrink`; none where nothing is to be
    /// changed.
    pub(super) fn refined(&self, scene: &Scene, target: &Target, may_shrink: bool) -> Option<Scene> {
        let met = self.meets(target);
        if met && !may_shrink {
            return None;
        }
        let given = |dial: Dial| match dial {
            Dial::Points => target.given.points,
            Dial::Bins => target.given.bins,
            Dial::Radii => target.given.radii,
            Dial::Vertices => target.given.vertices,
            Dial::Equilibrium => target.given.tolerance,
            Dial::Mesh | Dial::Modes => true,
        };
        let adapted = |dial: &Dial| (*dial == Dial::Equilibrium || self.numbers.contains_key(dial)) && !given(*dial);
        let n = ADAPTED.iter().filter(|(dial, ..)| adapted(dial)).count().max(1) as f64;
        let fixed = |of: fn(&DialError) -> Option<f64>| {
            let fixed = self.of.iter().filter(|(dial, _)| !adapted(dial));
            fixed.filter_map(|(_, part)| of(part)).sum::<f64>()
        };
        let fixed = DialError {
            frequency_relative: Some(fixed(|part| part.frequency_relative)),
            damping_ln: Some(fixed(|part| part.damping_ln)),
        };
        // What each setting may miss. Where what stays misses the target already, half as much again is soon enough.
        let allowed: Vec<f64> = pairs(&fixed, target)
            .map(|(fixed, target)| match fixed.unwrap_or(0.0) {
                fixed if fixed < target => (target - fixed).max(0.25 * target) / n,
                fixed => 0.5 * fixed / n,
            })
            .collect();
        // How many times what it may miss a setting misses.
        let excess = |dial: Dial| {
            let error = self.of.get(&dial).copied().unwrap_or_default();
            let excess = pairs(&error, target).zip(&allowed);
            let excess = excess.filter_map(|((error, _), allowed)| Some(error? / allowed));
            excess.fold(0.0, f64::max)
        };
        let mut next = scene.clone();
        let residuals = excess(Dial::Equilibrium);
        if residuals > 1.0 && !met && !given(Dial::Equilibrium) {
            let tolerance = &mut next.analyses.backbone.tolerance;
            *tolerance = (*tolerance / (GROWTH * residuals)).max(TIGHTEST.min(*tolerance));
        }
        for (dial, least, most) in ADAPTED.into_iter().filter(|(dial, ..)| adapted(dial)) {
            let number = self.numbers[&dial];
            let excess = excess(dial);
            let wanted = if excess > 1.0 && !met {
                // Errors by bins, which slip one after the other, fall with their number, the others with its square at least.
                let factor = if dial == Dial::Bins { excess } else { excess.sqrt() };
                (number as f64 * factor.min(GROWTH)).ceil() as usize
            } else if excess < NEXT_TO_NOTHING && may_shrink {
                number.div_ceil(2)
            } else {
                number
            };
            // What the scene has may lie beyond either end.
            let wanted = wanted.clamp(least.min(number), most.max(number));
            let wanted = match dial {
                // The numbers that errors are estimated with.
                Dial::Points if wanted > 2 => wanted | 1,
                Dial::Bins | Dial::Vertices => wanted.next_multiple_of(2),
                _ => wanted,
            };
            if wanted != number {
                next = dial.with(&next, wanted);
            }
        }
        if !met && !target.given.mesh {
            next.model.refinement = self.finer_mesh(scene, target).unwrap_or(next.model.refinement);
        }
        (next != *scene).then_some(next)
    }

    /// The coarsest mesh of a benchmark that takes its part of the target at most, or the finest that was measured, if it is finer than that
    /// of the scene.
    fn finer_mesh(&self, scene: &Scene, target: &Target) -> Option<RefinementLevel> {
        let mesh = self.of.get(&Dial::Mesh)?;
        let is_fine = |error: &DialError| {
            pairs(error, target).all(|(error, target)| error.is_some_and(|error| error <= OF_MESH * target))
        };
        if is_fine(mesh) {
            return None;
        }
        let accuracy = error_bar::accuracy(scene).ok()?;
        let mut finer: Vec<_> = accuracy
            .of(scene.element_order(), scene.hexahedra())
            .filter(|row| row.refinement as usize > scene.model.refinement as usize)
            .collect();
        finer.sort_by_key(|row| row.refinement as usize);
        let of = |row: &joint_model::benchmark::MeshError| DialError {
            frequency_relative: Some(row.frequency),
            damping_ln: Some(row.damping),
        };
        let found = finer.iter().find(|row| is_fine(&of(row))).or(finer.last())?;
        Some(found.refinement)
    }

    /// What was found, for readers.
    pub(super) fn sentence(&self, target: &Target) -> String {
        let numbers = self.numbers.iter().map(|(dial, n)| format!("{n} {}", dial.name()));
        let numbers: Vec<String> = numbers.collect();
        let errors = pairs(&self.error, target).zip(["frequency", "ln(damping)"]);
        let errors = errors.map(|((error, target), name)| match error {
            Some(error) => format!("{error:.1e} of {name} ({target:.1e} borne)"),
            None => format!("an unknown one of {name} ({target:.1e} borne)"),
        });
        let errors: Vec<String> = errors.collect();
        format!(
            "pilot of {} loops with {}: an error of {} is estimated",
            self.loops,
            numbers.join(", "),
            errors.join(" and ")
        )
    }
}

/// Errors with the target of each that the scene names.
fn pairs<'a>(error: &'a DialError, target: &'a Target) -> impl Iterator<Item = (Option<f64>, f64)> + 'a {
    [
        (error.frequency_relative, target.frequency),
        (error.damping_ln, target.damping),
    ]
    .into_iter()
    .filter_map(|(error, target)| Some((error, target?)))
}
