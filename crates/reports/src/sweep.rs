//! Sweeps of forced responses: their table and what is said of them.

use crate::Error;
use crate::csv::{number, table};
use analyses::forced::ForcedSummary;
use analyses::sweep::Swept;
use std::fmt::Write;

/// Name of the table of sweeps in time.
pub(crate) const SWEEP: &str = "sweep.csv";

/// A row per period of each sweep that was followed in time; none if there is no such sweep.
pub(crate) fn in_time(levels: &[ForcedSummary]) -> Result<Option<String>, Error> {
    let swept = levels
        .iter()
        .filter_map(|level| Some((level, level.sweep.as_ref()?.in_time.as_ref()?)));
    let mut swept = swept.filter(|(_, found)| found.failure.is_none()).peekable();
    let Some((first, _)) = swept.peek() else {
        return Ok(None);
    };
    let level = format!("level [{}]", first.level_unit);
    let rows = swept.flat_map(|(level, found)| {
        let points = found.frequency_hz.iter().zip(&found.amplitude);
        points.map(|(f, a)| [level.level, *f, *a].map(number).to_vec())
    });
    table(&[&level, "frequency [Hz]", "amplitude [m]"], rows).map(Some)
}

/// What is said of a sweep: how fast it may be, where it jumps, and what it finds in time.
pub(crate) fn said(swept: &Swept) -> String {
    let mut said = String::from(match swept.is_slow {
        true => "the sweep is slow, and finds the steady motions",
        false => "the sweep is not slow everywhere",
    });
    // Writing to a string cannot fail.
    for at in &swept.resonances {
        let (f, rate, limit) = (at.frequency_hz, at.rate_hz_per_s, at.limit_hz_per_s);
        let _ = write!(said, "; {rate:.3} Hz/s at {f:.3} Hz, slow below {limit:.3} Hz/s");
    }
    for jump in &swept.jumps {
        let [before, after] = jump.amplitude;
        let _ = write!(
            said,
            "; slowly, it would jump at {:.3} Hz from {before:.4e} to {after:.4e} m",
            jump.frequency_hz
        );
    }
    if let Some(found) = &swept.in_time {
        match (&found.failure, found.peak) {
            (Some(reason), _) => {
                let _ = write!(said, "; NOT FOLLOWED IN TIME: {reason}");
            }
            (None, Some([f, a])) => {
                let _ = write!(said, "; in time its largest amplitude is {a:.4e} m at {f:.3} Hz");
            }
            (None, None) => said.push_str("; it has no whole period"),
        }
    }
    said
}
