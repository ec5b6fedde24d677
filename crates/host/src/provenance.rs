//! What only programs know about where their results come from.

use crate::Error;
use analyses::results::provenance::{Input, ProgramBuild, Provenance};
use std::time::{SystemTime, UNIX_EPOCH};

/// Name of the program, whichever of its faces was used.
const PROGRAM: &str = "microslip";

/// The commit that the program is built from, if it is known.
pub fn commit() -> Option<String> {
    let commit = env!("MICROSLIP_COMMIT");
    (!commit.is_empty()).then(|| commit.to_owned())
}

/// The build of this program.
pub fn program() -> ProgramBuild {
    ProgramBuild {
        name: PROGRAM.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: commit(),
    }
}

/// Of a run that begins now and reads `inputs`. The environment variable `SOURCE_DATE_EPOCH` stands for the clock where it is
/// set.
///
/// # Errors
/// [`Error::Date`] if the variable is no number of seconds; [`Error::WorkingDirectory`].
pub fn of(inputs: Vec<Input>) -> Result<Provenance, Error> {
    let seconds = match std::env::var("SOURCE_DATE_EPOCH") {
        Ok(text) => match text.trim().parse() {
            Ok(seconds) => seconds,
            Err(source) => return Err(Error::Date { text, source }),
        },
        Err(_) => SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_secs()),
    };
    let directory = std::env::current_dir().map_err(Error::WorkingDirectory)?;
    let command = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    Ok(Provenance::new(
        program(),
        Some(date(seconds)),
        command.collect(),
        &directory,
        inputs,
    ))
}

/// Seconds since 1970 as ISO 8601 in UTC, by the civil calendar (H. Hinnant, chrono-compatible low-level date algorithms).
fn date(seconds: u64) -> String {
    let (days, time) = (seconds / 86_400, seconds % 86_400);
    // Years begin in March here, so that the leap day is their last one; an era has 400 years.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 {
        shifted_month + 3
    } else {
        shifted_month - 9
    };
    let year = 400 * era + year_of_era + u64::from(month <= 2);
    let (hours, minutes) = (time / 3600, time / 60 % 60);
    format!(
        "{year:04}-{month:02}-{day:02}T{hours:02}:{minutes:02}:{:02}Z",
        time % 60
    )
}

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn dates_follow_the_calendar() {
        for (seconds, expected) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_709_164_800, "2024-02-29T00:00:00Z"),
            (1_798_761_599, "2026-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(date(seconds), expected);
        }
    }
}
