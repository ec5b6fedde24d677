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
    let ends = |of: fn(&DialError) -> Option<f64>, total: fn(&AmplitudeError) -> Option<f64>| {
        let found = known
            .iter()
            .filter_map(|(point, error)| Some((total(error)?, *point, *error)));
        let least = found.clone().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let most = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let largest = most.2.of.iter().max_by(|a, b| {
            let size = |error: &DialError| of(error).unwrap_or(0.0);
            size(a.1).total_cmp(&size(b.1))
        });
        let place = most.1.response_displacement.unwrap_or(f64::NAN);
        let why = largest.map_or("", |(dial, _)| dial.name());
        Some((least.0, most.0, place, why))
    };
    if known.is_empty() {
        return None;
    }
    let frequency = match ends(|part| part.frequency_relative, |error| error.frequency_relative) {
        Some((least, most, ..)) => format!("{:.2} to {:.2} % of frequency", 100.0 * least, 100.0 * most),
        None => "not known of frequency".into(),
    };
    let damping = match ends(|part| part.damping_ln, |error| error.damping_ln) {
        Some((least, most, place, why)) => {
            format!("{least:.3} to {most:.3} of the logarithm of damping, most at {place:.2e} m by {why}")
        }
        None => "not known of damping".into(),
    };
    Some(format!("{frequency}; {damping}"))
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
