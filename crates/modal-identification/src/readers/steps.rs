//! Tables of stepped-sine tests (`.csv`): columns `frequency [Hz]`, `amplitude [..]`, `phase_lag [deg]` and `force [N]`, and `level [..]` where there are several;
//! columns beside these are passed over. The phase is that of the quantity whose amplitude is given. `forced.csv` of a run that holds the response is such a table.

use super::recording::malformed;
use crate::Error;
use crate::signal::Unit;
use crate::stepped_sine::{Level, Step};
use ::csv::{ReaderBuilder, StringRecord, Trim};
use file_io::{Place, Source};
use std::path::Path;

/// The table at `path`, level by level.
///
/// # Errors
/// [`Error::File`], [`Error::UnknownUnit`].
pub fn read(path: &Path) -> Result<Vec<Level>, Error> {
    let bytes = file_io::input::read(path, file_io::input::Kind::Record).map_err(matrix_files::Error::from)?;
    parse(Source {
        name: &path.to_string_lossy(),
        bytes: &bytes,
    })
}

/// The table in the bytes of a file.
///
/// # Errors
/// [`Error::File`], [`Error::UnknownUnit`].
pub fn parse(source: Source<'_>) -> Result<Vec<Level>, Error> {
    let mut reader = ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(source.bytes);
    let wrong = |error: ::csv::Error| {
        let line = error.position().map_or(1, ::csv::Position::line) as usize;
        malformed(
            source,
            Place::Line(line),
            error,
            "a table with a heading and rows of equal length",
        )
    };
    let header = reader.headers().map_err(wrong)?.clone();
    let column = |name: &str, example: &str| -> Result<(usize, String), Error> {
        let found = header.iter().enumerate().find_map(|(at, heading)| {
            let (own, unit) = heading.split_once('[')?;
            (own.trim() == name).then(|| (at, unit.trim_end_matches(']').trim().to_owned()))
        });
        found.ok_or_else(|| {
            let headings: Vec<&str> = header.iter().collect();
            malformed(
                source,
                Place::Line(1),
                format!("no column `{name}` with a unit among {}", headings.join(", ")),
                format!("columns such as `{example}`"),
            )
        })
    };
    let in_unit = |name: &str, wanted: &str| -> Result<usize, Error> {
        let (at, unit) = column(name, &format!("{name} [{wanted}]"))?;
        match unit == wanted {
            true => Ok(at),
            false => Err(malformed(
                source,
                Place::Line(1),
                format!("`{name}` in {unit}"),
                format!("`{name} [{wanted}]`"),
            )),
        }
    };
    let (frequency, phase, force) = (
        in_unit("frequency", "Hz")?,
        in_unit("phase_lag", "deg")?,
        in_unit("force", "N")?,
    );
    let (response, unit) = column("amplitude", "amplitude [m]")?;
    let unit: Unit = unit.parse()?;
    let level = column("level", "").ok().map(|(at, _)| at);
    let mut levels: Vec<Level> = Vec::new();
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(wrong)? {
        let row = record.position().map_or(0, ::csv::Position::line) as usize;
        let number = |at: usize| -> Result<f64, Error> {
            let cell = record.get(at).unwrap_or_default();
            let value = cell.parse().ok().filter(|value: &f64| value.is_finite());
            value.ok_or_else(|| {
                malformed(
                    source,
                    Place::Line(row),
                    format!("`{cell}`"),
                    format!("a number as `{}`", &header[at]),
                )
            })
        };
        let positive = |at: usize| match number(at)? {
            value if value > 0.0 => Ok(value),
            value => Err(malformed(
                source,
                Place::Line(row),
                value,
                format!("a positive number as `{}`", &header[at]),
            )),
        };
        let step = Step {
            frequency_hz: positive(frequency)?,
            force: positive(force)?,
            response: unit.scale * positive(response)?,
            // Of the displacement.
            phase_deg: (number(phase)? + 90.0 * f64::from(unit.quantity.derivatives())).rem_euclid(360.0),
            drift_hz_per_s: 0.0,
        };
        let name = level.and_then(|at| record.get(at)).unwrap_or_default();
        match levels.iter_mut().find(|known| known.name == name) {
            Some(known) => known.steps.push(step),
            None => levels.push(Level {
                name: name.to_owned(),
                quantity: unit.quantity,
                steps: vec![step],
            }),
        }
    }
    match levels.is_empty() {
        true => Err(malformed(
            source,
            Place::Line(2),
            "no rows",
            "one row for each steady state",
        )),
        false => Ok(levels),
    }
}
