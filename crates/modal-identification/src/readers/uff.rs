//! Universal files (`.uff`, `.unv`, `.uf`): dataset 58, functions at nodal degrees of freedom, as text and binary (58b).
//!
//! Layout: *Universal File Formats*, Structural Dynamics Research Corporation, kept by the University of Cincinnati. Time
//! responses with real values are read; other functions and datasets are listed as skipped. Units are those of the axis
//! label; where it is blank or `NONE`, SI units times the factor of length of a preceding dataset 164, if there is one.
//!
//! A channel is called by the first line of its description and its node and direction, `hammer side 3:+Z`; what is blank,
//! `NONE` or zero is left out. Text has the sampling step with six digits only: state the sample rate beside it.

use file_io::{Place, Source, quoted};
use matrix_files::value::Skipped;

use super::recording::{Recording, malformed, seconds};
use crate::Error;
use crate::signal::{Channel, Timing};

/// Lines between the number of a dataset 58 and its data.
const HEADER: usize = 11;

/// Reads all time responses.
///
/// # Errors
/// [`Error::File`].
pub fn parse(source: Source<'_>) -> Result<Recording, Error> {
    let mut file = File { source, at: 0, line: 0 };
    let mut found = Recording {
        file: source.name.into(),
        channels: Vec::new(),
        skipped: Vec::new(),
    };
    // Metres per unit of length.
    let mut length = None;
    while let Some(line) = file.line() {
        match line.trim_ascii() {
            b"" => continue,
            b"-1" => {}
            other => return Err(file.malformed(quoted(other), "`-1`, the start of a dataset")),
        }
        let line = file.expect_line("the number of a dataset")?;
        let head = line.trim_ascii();
        let digits = head.iter().take_while(|b| b.is_ascii_digit()).count();
        let (number, rest) = head.split_at(digits);
        let binary = matches!(rest.first(), Some(b'b' | b'B')).then(|| &rest[1..]);
        match (number, binary) {
            (b"", _) => return Err(file.malformed(quoted(head), "the number of a dataset")),
            (b"58", None) => file.function(None, length, &mut found)?,
            (b"58", Some(fields)) => {
                let fields = file.binary(fields)?;
                file.function(Some(fields), length, &mut found)?;
            }
            (b"164", None) => length = Some(file.length_unit()?),
            (_, None) => file.skip_text()?,
            (_, Some(fields)) => {
                let fields = file.binary(fields)?;
                for _ in 0..fields.lines {
                    file.expect_line("a line of the header")?;
                }
                file.take(fields.bytes)?;
            }
        }
        if !matches!(number, b"58" | b"164") {
            found.skipped.push(Skipped {
                name: format!("dataset {}", String::from_utf8_lossy(number)),
                reason: "it holds no functions".into(),
            });
        }
        file.end()?;
    }
    Ok(found)
}

/// What the first line of a binary dataset says.
struct Binary {
    big: bool,
    lines: usize,
    bytes: usize,
}

/// A position in a file.
struct File<'a> {
    source: Source<'a>,
    at: usize,
    line: usize,
}

impl<'a> File<'a> {
    fn malformed(&self, found: impl ToString, expected: impl ToString) -> Error {
        malformed(self.source, Place::Line(self.line), found, expected)
    }

    fn unsupported(&self, found: String, remedy: &'static str) -> Error {
        let error = matrix_files::Error::Unsupported {
            file: self.source.name.into(),
            place: Place::Line(self.line),
            found,
            remedy,
        };
        error.into()
    }

    /// The next line without its end.
    fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.source.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| *b == b'\n');
        let line = &rest[..length.unwrap_or(rest.len())];
        self.at += line.len() + 1;
        self.line += 1;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn expect_line(&mut self, expected: &str) -> Result<&'a [u8], Error> {
        match self.line() {
            Some(line) => Ok(line),
            None => Err(self.malformed("the end of the file", expected)),
        }
    }

    /// The next bytes, binary.
    fn take(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let rest = self.source.bytes.get(self.at..).unwrap_or_default();
        let Some(bytes) = rest.get(..count) else {
            let error = matrix_files::Error::Oversized {
                file: self.source.name.into(),
                place: Place::Byte(self.at),
                what: "the number of bytes of a dataset",
                stated: count as u128,
                possible: rest.len(),
            };
            return Err(error.into());
        };
        self.at += count;
        Ok(bytes)
    }

    /// The line that ends a dataset.
    fn end(&mut self) -> Result<(), Error> {
        let mut line = self.expect_line("`-1`, the end of a dataset")?;
        // Behind binary data some programs begin a new line, some do not.
        if line.is_empty() {
            line = self.expect_line("`-1`, the end of a dataset")?;
        }
        match line.trim_ascii() {
            b"-1" => Ok(()),
            other => Err(self.malformed(quoted(other), "`-1`, the end of a dataset")),
        }
    }

    /// Passes over a dataset of text, up to its end.
    fn skip_text(&mut self) -> Result<(), Error> {
        loop {
            let (at, line) = (self.at, self.line);
            if self.expect_line("`-1`, the end of a dataset")?.trim_ascii() == b"-1" {
                (self.at, self.line) = (at, line);
                return Ok(());
            }
        }
    }

    fn number<T: std::str::FromStr>(&self, token: Option<&[u8]>, expected: &str) -> Result<T, Error> {
        let token = token.unwrap_or_default();
        let text = std::str::from_utf8(token)
            .ok()
            .map(|text| text.trim().replace(['D', 'd'], "e"));
        text.and_then(|text| text.parse().ok())
            .ok_or_else(|| self.malformed(quoted(token), expected))
    }

    fn binary(&self, fields: &[u8]) -> Result<Binary, Error> {
        let mut tokens = tokens(fields);
        let order: u8 = self.number(tokens.next(), "the order of bytes, 1 or 2")?;
        let format: u8 = self.number(tokens.next(), "the format of numbers")?;
        if !matches!(order, 1 | 2) {
            return Err(self.malformed(order, "the order of bytes, 1 or 2"));
        }
        if format != 2 {
            return Err(self.unsupported(
                format!("the format {format} of numbers"),
                "write them in the format 2 (IEEE 754)",
            ));
        }
        Ok(Binary {
            big: order == 2,
            lines: self.number(tokens.next(), "a number of lines")?,
            bytes: self.number(tokens.next(), "a number of bytes")?,
        })
    }

    /// Dataset 164: metres per unit of length.
    fn length_unit(&mut self) -> Result<f64, Error> {
        self.expect_line("a code of units")?;
        let line = self.expect_line("factors of units")?;
        let factor: f64 = self.number(tokens(line).next(), "the factor of length")?;
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(self.malformed(factor, "a positive factor of length"));
        }
        self.skip_text()?;
        Ok(1.0 / factor)
    }

    /// Dataset 58, up to its end.
    fn function(&mut self, binary: Option<Binary>, length: Option<f64>, found: &mut Recording) -> Result<(), Error> {
        if let Some(fields) = &binary
            && fields.lines != HEADER
        {
            return Err(self.malformed(format!("{} lines of header", fields.lines), HEADER));
        }
        let description = text(self.expect_line("a description")?);
        for _ in 1..5 {
            self.expect_line("a description")?;
        }
        let line = self.expect_line("the type of a function")?;
        let kind: i32 = self.number(line.get(..5).or(Some(line)), "the type of a function")?;
        // Behind the type: number, version, load case; then the response's name, node and direction.
        let node = tokens(line.get(41..51).unwrap_or_default()).next().map(text);
        let direction = tokens(line.get(51..55).unwrap_or_default()).next().map(text);
        let name = name(description, node, direction);

        let line = self.expect_line("the form of the data")?;
        let mut form = tokens(line);
        let data: u8 = self.number(form.next(), "a type of data, 2, 4, 5 or 6")?;
        let count: usize = self.number(form.next(), "a number of values")?;
        let even: u8 = self.number(form.next(), "0 or 1 for spacing")?;
        form.next();
        let step: f64 = self.number(form.next(), "a step of the abscissa")?;
        let (complex, double) = match data {
            2 => (false, false),
            4 => (false, true),
            5 => (true, false),
            6 => (true, true),
            _ => return Err(self.malformed(data, "a type of data, 2, 4, 5 or 6")),
        };
        if even > 1 {
            return Err(self.malformed(even, "0 or 1 for spacing"));
        }
        let axis = self.expect_line("the abscissa")?;
        let axis_kind: i32 = self.number(axis.get(..10).or(Some(axis)), "a type of abscissa")?;
        let time_unit = label(axis);
        let time_scale = match &time_unit {
            None => Some(1.0),
            Some(unit) => seconds(unit),
        };
        let axis_line = self.line;
        let ordinate = self.expect_line("the ordinate")?;
        let ordinate_kind: i32 = self.number(ordinate.get(..10).or(Some(ordinate)), "a type of ordinate")?;
        let of_length = match ordinate_kind {
            8 => Some("m"),
            11 => Some("m/s"),
            12 => Some("m/s^2"),
            _ => None,
        };
        let unit = label(ordinate).or_else(|| Some(format!("{} {}", length?, of_length?)));
        for _ in 0..2 {
            self.expect_line("a denominator or third axis")?;
        }

        let reason = match (kind, axis_kind, complex) {
            (_, _, true) => Some("its values are complex".into()),
            (0 | 1, 0 | 1 | 17, false) => None,
            _ => Some(format!("it is a function of type {kind}, no time response")),
        };
        if let Some(reason) = reason {
            found.skipped.push(Skipped { name, reason });
            return match binary {
                Some(fields) => self.take(fields.bytes).map(drop),
                None => self.skip_text(),
            };
        }
        let Some(time_scale) = time_scale else {
            self.line = axis_line;
            return Err(self.malformed(
                format!("the unit `{}` of time", time_unit.unwrap_or_default()),
                "s, ms or us",
            ));
        };
        let values = match binary {
            Some(fields) => self.binary_values(&fields, count, double, even == 0)?,
            None => self.text_values(count, double, even == 0)?,
        };
        let (timing, samples) = if even == 1 {
            if !(step > 0.0 && step.is_finite()) {
                return Err(self.malformed(format!("a step of {step}"), "a positive step of the abscissa"));
            }
            (Timing::Rate(1.0 / (step * time_scale)), values)
        } else {
            let times = values.iter().step_by(2).map(|t| t * time_scale).collect();
            let samples = values.iter().skip(1).step_by(2).copied().collect();
            (Timing::Times(times), samples)
        };
        found.channels.push(Channel {
            name,
            unit,
            timing,
            samples,
        });
        Ok(())
    }

    /// Values, or pairs of abscissa and value.
    fn binary_values(&mut self, fields: &Binary, count: usize, double: bool, pairs: bool) -> Result<Vec<f64>, Error> {
        let size = if double { 8 } else { 4 };
        let bytes = self.take(fields.bytes)?;
        // Abscissae are single by the format; some programs write them double.
        let single_abscissae = count.checked_mul(4 + size) == Some(bytes.len());
        let widths = match pairs {
            true if single_abscissae => [4, size],
            _ => [size, size],
        };
        let numbers = if pairs { count.checked_mul(2) } else { Some(count) };
        let whole = numbers.and_then(|n| n.checked_mul(widths[0] + widths[1]));
        if whole != Some(2 * bytes.len()) {
            return Err(self.malformed(
                format!("{} bytes of data", bytes.len()),
                format!("{count} values of {size} bytes"),
            ));
        }
        let chunks = bytes.chunks_exact(widths[0] + widths[1]);
        let rest = chunks.remainder();
        let mut values = Vec::with_capacity(numbers.unwrap_or_default());
        for chunk in chunks {
            let (a, b) = chunk.split_at(widths[0]);
            values.extend([binary_number(a, fields.big), binary_number(b, fields.big)]);
        }
        if !rest.is_empty() {
            values.push(binary_number(rest, fields.big));
        }
        Ok(values)
    }

    /// Values, or pairs of abscissa and value, up to the end of the dataset.
    fn text_values(&mut self, count: usize, double: bool, pairs: bool) -> Result<Vec<f64>, Error> {
        let widths: [usize; 2] = match (double, pairs) {
            (false, _) => [13, 13],
            (true, false) => [20, 20],
            (true, true) => [13, 20],
        };
        let mut values = Vec::new();
        loop {
            let (at, number) = (self.at, self.line);
            let line = self.expect_line("`-1`, the end of a dataset")?;
            if line.trim_ascii() == b"-1" {
                (self.at, self.line) = (at, number);
                break;
            }
            let before = values.len();
            for token in tokens(line) {
                match self.number(Some(token), "a number") {
                    Ok(value) => values.push(value),
                    Err(_) => {
                        // Columns without a blank between them.
                        values.truncate(before);
                        self.columns(line, widths, &mut values)?;
                        break;
                    }
                }
            }
        }
        let stated = if pairs { count.checked_mul(2) } else { Some(count) };
        if stated != Some(values.len()) {
            let what = if pairs { "numbers in pairs" } else { "values" };
            return Err(self.malformed(
                format!("{} {what}", values.len()),
                format!("as many as stated, {count}"),
            ));
        }
        Ok(values)
    }

    /// The numbers of a line with columns of fixed widths in turn.
    fn columns(&self, line: &[u8], widths: [usize; 2], values: &mut Vec<f64>) -> Result<(), Error> {
        let mut rest = line.trim_ascii_end();
        for width in widths.iter().cycle() {
            if rest.is_empty() {
                break;
            }
            let (column, after) = rest.split_at((*width).min(rest.len()));
            values.push(self.number(Some(column), "a number")?);
            rest = after;
        }
        Ok(())
    }
}

fn tokens(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.trim_ascii()).into_owned()
}

/// Label of an axis' unit.
fn label(line: &[u8]) -> Option<String> {
    let label = text(line.get(47..line.len().min(67))?);
    (!label.is_empty() && !label.eq_ignore_ascii_case("none")).then_some(label)
}

fn name(description: String, node: Option<String>, direction: Option<String>) -> String {
    let direction = match direction.as_deref() {
        Some("1") => "+X",
        Some("-1") => "-X",
        Some("2") => "+Y",
        Some("-2") => "-Y",
        Some("3") => "+Z",
        Some("-3") => "-Z",
        Some("0") | None => "",
        Some(other) => other,
    };
    let node = node.filter(|node| node != "0").unwrap_or_default();
    let place = match (node.as_str(), direction) {
        ("", "") => String::new(),
        (node, "") => node.into(),
        (node, direction) => format!("{node}:{direction}"),
    };
    match (description.as_str(), place.as_str()) {
        ("" | "NONE", "") => "unnamed".into(),
        ("" | "NONE", _) => place,
        (_, "") => description,
        _ => format!("{description} {place}"),
    }
}

/// A number of four or eight bytes.
fn binary_number(bytes: &[u8], big: bool) -> f64 {
    match (<[u8; 8]>::try_from(bytes), <[u8; 4]>::try_from(bytes)) {
        (Ok(bytes), _) if big => f64::from_be_bytes(bytes),
        (Ok(bytes), _) => f64::from_le_bytes(bytes),
        (_, Ok(bytes)) if big => f32::from_be_bytes(bytes).into(),
        (_, Ok(bytes)) => f32::from_le_bytes(bytes).into(),
        // Chunks have one of these sizes.
        _ => f64::NAN,
    }
}
