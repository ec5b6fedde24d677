//! Numbers and lines of text files.

use crate::Error;
use std::fmt::Display;
use std::path::Path;

use file_io::{Place, Source, quoted};

/// The bytes of a file.
pub(crate) fn load(path: &Path) -> Result<Vec<u8>, Error> {
    Ok(file_io::input::read(path, file_io::input::Kind::Matrices)?)
}

/// What `parse` makes of a file.
pub(crate) fn read<T>(path: &Path, parse: impl FnOnce(Source<'_>) -> Result<T, Error>) -> Result<T, Error> {
    parse(Source {
        name: &path.to_string_lossy(),
        bytes: &load(path)?,
    })
}

/// A line without its end, with its number from one.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    pub(crate) file: &'a str,
    pub(crate) number: usize,
    pub(crate) text: &'a [u8],
}

/// All lines, trimmed.
pub(crate) fn lines<'a>(source: Source<'a>) -> impl Iterator<Item = Line<'a>> {
    indented_lines(source).map(|line| Line {
        text: line.text.trim_ascii_start(),
        ..line
    })
}

/// All lines with the blanks ahead, for layouts in columns.
pub(crate) fn indented_lines<'a>(source: Source<'a>) -> impl Iterator<Item = Line<'a>> {
    source
        .bytes
        .split(|b| *b == b'\n')
        .zip(1..)
        .map(move |(text, number)| Line {
            file: source.name,
            number,
            text: text.trim_ascii_end(),
        })
}

impl<'a> Line<'a> {
    pub(crate) fn malformed(&self, found: impl Display, expected: impl Display) -> Error {
        Error::Malformed {
            file: self.file.into(),
            place: Place::Line(self.number),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    pub(crate) fn unsupported(&self, found: impl Display, remedy: &'static str) -> Error {
        Error::Unsupported {
            file: self.file.into(),
            place: Place::Line(self.number),
            found: found.to_string(),
            remedy,
        }
    }

    /// The tokens between commas and white space.
    pub(crate) fn tokens(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.text
            .split(|b| *b == b',' || b.is_ascii_whitespace())
            .filter(|token| !token.is_empty())
    }

    /// Exactly `N` tokens.
    pub(crate) fn fields<const N: usize>(&self, expected: &str) -> Result<[&'a [u8]; N], Error> {
        let mut tokens = self.tokens();
        let mut fields = [&b""[..]; N];
        for field in &mut fields {
            *field = tokens
                .next()
                .ok_or_else(|| self.malformed(quoted(self.text), expected))?;
        }
        match tokens.next() {
            None => Ok(fields),
            Some(_) => Err(self.malformed(quoted(self.text), expected)),
        }
    }

    /// A finite number.
    pub(crate) fn real(&self, token: &[u8]) -> Result<f64, Error> {
        match real(token) {
            Some(value) if value.is_finite() => Ok(value),
            Some(value) => Err(Error::NotFinite {
                file: self.file.into(),
                place: Place::Line(self.number),
                value,
            }),
            None => Err(self.malformed(quoted(token), "a number")),
        }
    }

    /// An integer.
    pub(crate) fn integer<T: std::str::FromStr>(&self, token: &[u8], what: &str) -> Result<T, Error> {
        let text = std::str::from_utf8(token).ok();
        text.and_then(|text| text.parse().ok())
            .ok_or_else(|| self.malformed(quoted(token), what))
    }

    /// An index counted from one, as one counted from zero.
    pub(crate) fn index(&self, token: &[u8], what: &'static str, count: usize) -> Result<usize, Error> {
        let index: i128 = self.integer(token, what)?;
        match usize::try_from(index) {
            Ok(i) if i >= 1 && i <= count => Ok(i - 1),
            _ => Err(Error::OutOfRange {
                file: self.file.into(),
                place: Place::Line(self.number),
                what,
                index,
                first: 1,
                last: count,
            }),
        }
    }

    pub(crate) fn oversized(&self, what: &'static str, stated: u128, possible: usize) -> Error {
        Error::Oversized {
            file: self.file.into(),
            place: Place::Line(self.number),
            what,
            stated,
            possible,
        }
    }
}

/// A number in the spellings of C and Fortran: `1.5`, `1.5E+3`, `1.5D+03`, `1.5+103`.
fn real(token: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(token).ok()?;
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    // Three digits of exponent push Fortran's letter out of the field.
    let exponent = text
        .find(['d', 'D'])
        .or_else(|| Some(text.get(1..)?.find(['+', '-'])? + 1))?;
    let (mantissa, exponent) = (&text[..exponent], text[exponent..].trim_start_matches(['d', 'D']));
    let number = mantissa.ends_with(|c: char| c.is_ascii_digit() || c == '.');
    number.then(|| format!("{mantissa}e{exponent}").parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::real;

    #[test]
    fn spellings_of_numbers() {
        for (text, value) in [
            ("1.5", 1.5),
            ("-.5E+3", -500.0),
            ("1.5D+03", 1500.0),
            ("1.5d3", 1500.0),
            ("0.25-101", 0.25e-101),
            ("-7.+100", -7e100),
        ] {
            assert_eq!(real(text.as_bytes()), Some(value), "{text}");
        }
        for text in ["", "-", "1-", "x", "1.5D", "1e5-3", "--3", "1,5", "é-3"] {
            assert_eq!(real(text.as_bytes()), None, "{text}");
        }
        assert!(real(b"nan").unwrap().is_nan() && real(b"1e999").unwrap().is_infinite());
    }
}
