//! Lines of text files, numbers as Fortran writes them, and the errors that name them.

use super::common::quoted;
use crate::Error;
use crate::error::Position;

/// A file of lines.
pub(super) struct Text<'a> {
    pub(super) file: &'a str,
    pub(super) lines: Vec<&'a str>,
}

impl<'a> Text<'a> {
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        Self {
            file,
            lines: text.lines().collect(),
        }
    }

    /// The error for a line, counted from zero.
    pub(super) fn syntax(&self, at: usize, expected: impl Into<String>, found: &str) -> Error {
        Error::MeshSyntax {
            file: self.file.into(),
            at: Position::Line(at + 1),
            expected: expected.into(),
            found: match at < self.lines.len() {
                true => quoted(found.as_bytes()),
                false => "the end of the file".into(),
            },
        }
    }

    pub(super) fn contents(&self, at: u32, problem: String, remedy: &'static str) -> Error {
        Error::MeshContents {
            file: self.file.into(),
            at: Position::Line(at as usize + 1),
            problem,
            remedy,
        }
    }

    pub(super) fn unsupported(&self, at: usize, what: String, remedy: &'static str) -> Error {
        Error::MeshUnsupported {
            file: self.file.into(),
            at: Position::Line(at + 1),
            what,
            remedy: remedy.into(),
        }
    }
}

/// A real number as Fortran writes it: also with `D` for the exponent, or with a sign alone.
pub(super) fn real(text: &str) -> Option<f64> {
    let text = text.trim();
    if let Ok(value) = text.parse::<f64>() {
        // Names of what is no number are no numbers of Fortran.
        return text
            .ends_with(|c: char| c.is_ascii_digit() || c == '.')
            .then_some(value);
    }
    let mut plain = text.replace(['D', 'd'], "e");
    // The sign of an exponent without letter stands behind a digit or the point.
    if !plain.contains(['e', 'E'])
        && let Some(sign) = plain.rfind(['+', '-']).filter(|at| *at > 0)
    {
        plain.insert(sign, 'e');
    }
    plain.parse().ok().filter(|value: &f64| value.is_finite())
}
