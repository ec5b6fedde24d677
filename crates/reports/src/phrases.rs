//! Phrases that several documents use.

use analyses::Run;
use analyses::results::summary::{BackboneSummary, Status};

/// Tension of the bolts as text.
pub(crate) fn tensions(run: &Run) -> String {
    let all = run.prestress.tensions.iter().map(|tension| tension / 1e3);
    let (low, high) = all.fold((f64::INFINITY, 0.0_f64), |(l, h), load| (l.min(load), h.max(load)));
    match low < high {
        true => format!("{low:.3} to {high:.3} kN"),
        false => format!("{low:.3} kN each"),
    }
}

/// Total damping ratio as text, or the floor that it lies below.
pub(crate) fn damping(b: &BackboneSummary) -> String {
    match (b.status, b.damping_ratio, b.damping_floor) {
        (Status::BelowFloor, _, Some(floor)) => format!("< {floor:.1e}"),
        (_, Some(zeta), _) => format!("{zeta:.4e}"),
        _ => "-".into(),
    }
}
