//! What readers say of the place where something stands.

use std::fmt;

/// The bytes of a file and what to call it in messages.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// Its bytes.
    pub bytes: &'a [u8],
}

/// Where in a file something stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, counted from one.
    Line(usize),
    /// Byte of a binary file, counted from zero.
    Byte(usize),
    /// Byte of a part that is stored compressed or as a member of an archive.
    Inside {
        /// The part.
        part: String,
        /// Byte of the unpacked part, counted from zero.
        byte: usize,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Inside { part, byte } => write!(f, "byte {byte} of {part}"),
        }
    }
}

/// The start of a piece of a file, for messages: in backquotes, at most 60 bytes of it, control characters escaped.
pub fn quoted(text: &[u8]) -> String {
    const SHOWN: usize = 60;
    let shown = String::from_utf8_lossy(&text[..text.len().min(SHOWN)]);
    format!(
        "`{}`{}",
        shown.escape_debug(),
        if text.len() > SHOWN { " ..." } else { "" }
    )
}
