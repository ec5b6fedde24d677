//! What is said of the errors of numerical settings.

use analyses::adaptation::Adaptation;
use analyses::dials::{AmplitudeError, DialError};
use analyses::results::summary::{BackboneSummary, Summary};

/// Estimated errors of all backbones; none where none were estimated.
pub(crate) fn errors(summary: &Summary) -> Option<String> {
    let modes: Vec<_> = summary.by_mode().collect();
    let points = modes.iter().flat_map(|(_, mode)| &mode.backbone);
    let known: Vec<(&BackboneSummary, &AmplitudeError)> = points
        .filter_map(|point| Some((point, point.error.as_ref()?)))
        .collect();
    if known.is_empty() {
        return None;
    }
    let frequency = match range(known.iter().filter_map(|(_, error)| error.frequency_relative)) {
        Some([least, most]) => format!("{:.2} to {:.2} % of frequency", 100.0 * least, 100.0 * most),
        None => "not known of frequency".into(),
    };
    let damping = |error: &AmplitudeError| error.damping_ln;
    let worst = known
        .iter()
        .max_by(|a, b| damping(a.1).unwrap_or(0.0).total_cmp(&damping(b.1).unwrap_or(0.0)));
    let damping = match (range(known.iter().filter_map(|(_, error)| damping(error))), worst) {
        (Some([least, most]), Some((point, error))) => {
            let part = |part: &DialError| part.damping_ln.unwrap_or(0.0);
            let largest = error.of.iter().max_by(|a, b| part(a.1).total_cmp(&part(b.1)));
            format!(
                "{least:.3} to {most:.3} of the logarithm of damping, most at {:.2e} m by {}",
                point.response_displacement.unwrap_or(f64::NAN),
                largest.map_or("", |(dial, _)| dial.name())
            )
        }
        _ => "not known of damping".into(),
    };
    Some(format!("{frequency}; {damping}"))
}

/// Smallest and largest.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, value| match range {
        None => Some([value; 2]),
        Some([least, most]) => Some([least.min(value), most.max(value)]),
    })
}

/// How settings were adapted, and whether that was enough.
pub(crate) fn adaptation(adaptation: &Adaptation) -> String {
    let borne = [("frequency", adaptation.frequency), ("ln(damping)", adaptation.damping)];
    let borne: Vec<String> = borne
        .into_iter()
        .filter_map(|(name, error)| Some(format!("{:.1e} of {name}", error?)))
        .collect();
    let numbers = adaptation.steps.last().into_iter().flat_map(|last| &last.numbers);
    let numbers: Vec<String> = numbers.map(|(dial, n)| format!("{n} {}", dial.name())).collect();
    let before = adaptation.steps.split_last().map_or(&[][..], |(_, before)| before);
    let cost: usize = before.iter().map(|step| step.load_points).sum();
    let met = match adaptation.met {
        true => "met".to_owned(),
        false => {
            let names: Vec<&str> = adaptation.limited_by.iter().map(|dial| dial.name()).collect();
            match names.as_slice() {
                [] => "NOT met, as no error could be estimated".to_owned(),
                names => format!("NOT met, most is missed by {}", names.join(", ")),
            }
        }
    };
    format!(
        "{} borne, {met}; chosen: {}; {cost} equilibria to find them",
        borne.join(" and "),
        numbers.join(", ")
    )
}
