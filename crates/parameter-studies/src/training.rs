//! Which cases of a structure the others learn from.

use crate::Error;
use crate::case::Case;
use crate::design::Design;
use crate::plan::{HyperReduction, Plan};
use analyses::cases::ErrorBounds;
use analyses::hyper_reduced::ErrorEstimate;
use scenes::{Accuracy, Commit, Scene};
use serde_json::Value;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Cases that are learned from with up to two parameters, and with more.
const CASES: [usize; 2] = [9, 27];

/// Most cases that are learned from: what is learned is found among all their motions at once.
const MOST_CASES: usize = 64;

/// Errors that are borne where neither the plan nor the accuracy of the scene says so.
const BORNE: ErrorBounds = ErrorBounds {
    frequency: 5e-4,
    damping: 1e-2,
};

/// Part of the errors that a scene bears which those of few coordinates and points may be.
const SHARE: f64 = 0.25;

/// What cases must have in common beside their structure, and what is borne.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Terms {
    pub(crate) modes: Vec<usize>,
    pub(crate) points_per_direction: usize,
    /// Whether errors can be estimated for its loops.
    pub(crate) is_judged: bool,
    pub(crate) borne: ErrorBounds,
}

impl Terms {
    /// Those of a scene with all that it asks for.
    pub(crate) fn of(scene: &Scene, plan: &HyperReduction) -> Self {
        let asked = scene.accuracy.map(|accuracy| match accuracy {
            Accuracy::Target(target) => [target.frequency, target.damping],
            Accuracy::Level(_) => {
                let preset = accuracy.preset().ok();
                [
                    preset.map(|preset| preset.frequency_error),
                    preset.map(|preset| preset.damping_error),
                ]
            }
        });
        let [frequency, damping] = asked.unwrap_or([None; 2]).map(|error| error.map(|error| SHARE * error));
        Self {
            modes: scene.analyses.modes.followed.to_vec(),
            points_per_direction: scene.interfaces.points_per_direction,
            is_judged: scene.analyses.backbone.cycles.is_none()
                && scene.analyses.backbone.commit == Commit::AtEveryVertex,
            borne: ErrorBounds {
                frequency: plan.frequency.or(frequency).unwrap_or(BORNE.frequency),
                damping: plan.damping.or(damping).unwrap_or(BORNE.damping),
            },
        }
    }
}

/// Refuses numbers that mean nothing.
pub(crate) fn check(plan: &Plan, name: &str) -> Result<(), Error> {
    let Some(settings) = &plan.hyper_reduction else {
        return Ok(());
    };
    let refused = |field: &str, reason: String| Error::Plan {
        plan: name.into(),
        field: format!("hyper_reduction.{field}"),
        reason,
    };
    if let Some(training @ 0..2) = settings.training {
        return Err(refused(
            "training",
            format!("{training} cases teach nothing of what varies; give 2 or more"),
        ));
    }
    if let Some(training) = settings.training.filter(|training| *training > MOST_CASES) {
        return Err(refused(
            "training",
            format!("{training} cases are more than can be learned from at once; give {MOST_CASES} or less"),
        ));
    }
    for (field, value) in [("frequency", settings.frequency), ("damping", settings.damping)] {
        if let Some(value) = value.filter(|value| !(*value > 0.0 && value.is_finite())) {
            return Err(refused(
                field,
                format!("{value} is no relative error; give a positive number, such as 0.01"),
            ));
        }
    }
    Ok(())
}

/// For each structure with more cases than are learned from, the cases that are, by index, in the order of their values, so that neither the order
/// of a plan nor the build of the program has a say in what is learned; `cases` lie structure by structure, and `of_plan` are their indices by the numbers of the plan, which `terms` go by.
pub(crate) fn choose(
    plan: &Plan,
    name: &str,
    design: &Design,
    cases: &[Case],
    of_plan: &[usize],
    terms: &[Option<Terms>],
) -> Result<BTreeMap<usize, Vec<usize>>, Error> {
    let Some(settings) = &plan.hyper_reduction else {
        return Ok(BTreeMap::new());
    };
    let number = settings
        .training
        .unwrap_or(CASES[usize::from(design.columns.len() > 2)]);
    let refused = |field: &str, reason: String| Error::Plan {
        plan: name.into(),
        field: format!("hyper_reduction{field}"),
        reason,
    };
    let mut chosen = BTreeMap::new();
    let mut first = 0;
    for group in cases.chunk_by(|a, b| a.structure == b.structure) {
        let own = first..first + group.len();
        first = own.end;
        if group.len() <= number {
            continue;
        }
        let of_group = of_plan.iter().zip(terms).zip(1..);
        let of_group = of_group.filter(|((index, _), _)| own.contains(index));
        let mut of_group = of_group.filter_map(|((_, terms), number)| Some((terms.as_ref()?, number)));
        let Some((one, its_number)) = of_group.next() else {
            continue;
        };
        if let Some((_, other)) = of_group.find(|(terms, _)| *terms != one) {
            return Err(refused(
                "",
                format!(
                    "cases {its_number} and {other} have the same structure, but other modes, points per direction, ways to follow loops or \
                     accuracy, so that they cannot learn from the same cases; put them into plans of their own"
                ),
            ));
        }
        if !one.is_judged {
            let reason = "errors are estimated for loops that are followed until they close, with their history committed at every vertex; \
                          leave analyses.backbone.cycles and analyses.backbone.commit out of the scene, or hyper_reduction out of the plan";
            return Err(refused("", reason.into()));
        }
        let borne = [("frequency", one.borne.frequency), ("damping", one.borne.damping)];
        for ((field, value), floor) in borne.into_iter().zip(ErrorEstimate::FLOORS) {
            if value <= floor {
                let reason = format!(
                    "{value} is not above {floor}, the least that is ever estimated; give more, or leave hyper_reduction out"
                );
                return Err(refused(&format!(".{field}"), reason));
            }
        }
        let mut places: Vec<(Vec<f64>, usize)> = places(design, group).into_iter().zip(own).collect();
        places.sort_by(|(a, _), (b, _)| {
            let different = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
            different.unwrap_or(Ordering::Equal)
        });
        let (places, indices): (Vec<Vec<f64>>, Vec<usize>) = places.into_iter().unzip();
        let taught = spread(&places, number);
        let taught = taught
            .into_iter()
            .filter_map(|place| indices.get(place).copied())
            .collect();
        if let Some(case) = group.first() {
            chosen.insert(case.structure, taught);
        }
    }
    Ok(chosen)
}

/// Of each case where it lies among the values of each parameter, from 0 to 1; parameters in the order of their pointers.
fn places(design: &Design, cases: &[Case]) -> Vec<Vec<f64>> {
    let values: Vec<Vec<Option<&Value>>> = cases.iter().map(|case| design.values(case.number)).collect();
    let mut places = vec![Vec::with_capacity(design.columns.len()); cases.len()];
    let mut columns: Vec<_> = design.columns.iter().enumerate().collect();
    columns.sort_by(|(_, a), (_, b)| a.pointer.cmp(&b.pointer));
    for (at, column) in columns {
        let own = || values.iter().map(|values| values.get(at).copied().flatten());
        let numbers: Option<Vec<f64>> = own().map(|value| column.number(value?)).collect();
        // What has no numbers is in the order of its text.
        let keys = numbers.unwrap_or_else(|| {
            let text = |value: Option<&Value>| value.map(Value::to_string);
            let mut known: Vec<Option<String>> = own().map(text).collect();
            known.sort_unstable();
            known.dedup();
            own()
                .map(|value| known.partition_point(|other| *other < text(value)) as f64)
                .collect()
        });
        let mut distinct = keys.clone();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        let last = distinct.len().saturating_sub(1).max(1) as f64;
        for (places, key) in places.iter_mut().zip(keys) {
            places.push(distinct.partition_point(|other| *other < key) as f64 / last);
        }
    }
    places
}

/// So many of the places, the one in the middle first and then each as far from those before as can be; the first of several.
fn spread(places: &[Vec<f64>], number: usize) -> Vec<usize> {
    let distance = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum() };
    let middle = vec![0.5; places.first().map_or(0, Vec::len)];
    let mut nearest: Vec<f64> = places.iter().map(|place| -distance(place, &middle)).collect();
    let mut chosen = Vec::new();
    while chosen.len() < number.min(places.len()) {
        let farthest = nearest.iter().enumerate().rev().max_by(|a, b| a.1.total_cmp(b.1));
        let Some((next, _)) = farthest else { break };
        let Some(place) = places.get(next) else { break };
        let is_first = chosen.is_empty();
        chosen.push(next);
        for (nearest, other) in nearest.iter_mut().zip(places) {
            let own = distance(place, other);
            *nearest = if is_first { own } else { nearest.min(own) };
        }
        // Not twice.
        for &taken in &chosen {
            if let Some(nearest) = nearest.get_mut(taken) {
                *nearest = f64::NEG_INFINITY;
            }
        }
    }
    chosen.sort_unstable();
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_that_teach_lie_in_the_middle_at_the_corners_and_between() {
        let grid: Vec<Vec<f64>> = (0..25)
            .map(|k| vec![f64::from(k / 5) / 4.0, f64::from(k % 5) / 4.0])
            .collect();
        assert_eq!(spread(&grid, 5), [0, 4, 12, 20, 24]);
        assert_eq!(spread(&grid, 9), [0, 2, 4, 10, 12, 14, 20, 22, 24]);
        let all = spread(&grid, 40);
        assert_eq!(all, (0..25).collect::<Vec<_>>());
        assert_eq!(spread(&vec![Vec::new(); 3], 2), [0, 1]);
    }
}
