//! Records as lines.

use super::stream::Stream;
use crate::Error;
use crate::columns::{Header, Position};
use crate::text::Line;
use file_io::{Place, Source, quoted};

/// Fewest and most characters of a number: `1.E+00` is the shortest.
const WIDTHS: std::ops::RangeInclusive<usize> = 6..=100;

pub(super) struct Text<'a> {
    source: Source<'a>,
    at: usize,
    line: Line<'a>,
    /// Numbers in a line, and characters of each.
    layout: [usize; 2],
}

impl<'a> Text<'a> {
    pub(super) fn new(source: Source<'a>) -> Self {
        Self {
            source,
            at: 0,
            line: Line {
                file: source.name,
                number: 0,
                text: b"",
            },
            layout: [0, 0],
        }
    }

    /// The next line with the blanks ahead, which belong to its fields.
    fn advance(&mut self) -> Option<Line<'a>> {
        let rest = self.source.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += length + 1;
        self.line.number += 1;
        self.line.text = rest[..length].trim_ascii_end();
        Some(self.line)
    }

    fn line(&mut self, expected: &str) -> Result<Line<'a>, Error> {
        let line = self.advance();
        line.ok_or_else(|| self.malformed("the end of the file", expected))
    }

    /// Integers between blanks, or in fields of eight characters where these touch.
    fn integers<const N: usize>(&mut self, expected: &str) -> Result<[usize; N], Error> {
        let line = self.line(expected)?;
        let fields = line.fields::<N>(expected).or_else(|error| {
            let fields: Vec<&[u8]> = line.text.chunks(8).map(<[u8]>::trim_ascii).collect();
            fields.try_into().map_err(|_| error)
        })?;
        let mut integers = [0; N];
        for (integer, field) in integers.iter_mut().zip(fields) {
            *integer = line.integer(field, expected)?;
        }
        Ok(integers)
    }
}

impl Position for Text<'_> {
    fn file(&self) -> &str {
        self.source.name
    }

    fn place(&self) -> Place {
        Place::Line(self.line.number.max(1))
    }
}

impl Stream for Text<'_> {
    fn at(&self) -> usize {
        self.at
    }

    fn header(&mut self) -> Result<Option<Header>, Error> {
        const EXPECTED: &str = "columns, rows, form, type, name and a format such as `1P,3E24.16` of a matrix";
        let Some(line) = std::iter::from_fn(|| self.advance()).find(|line| !line.text.is_empty()) else {
            return Ok(None);
        };
        let wrong = || line.malformed(quoted(line.text), EXPECTED);
        // Long counts have fields of sixteen characters, and say so at the end.
        let (text, width) = match line.text.strip_suffix(b"|I16") {
            Some(text) => (text, 16),
            None => (line.text, 8),
        };
        let ends = [width, 2 * width, 2 * width + 8, 2 * width + 16];
        let mut numbers = [0; 4];
        let mut start = 0;
        for (number, end) in numbers.iter_mut().zip(ends) {
            let field = text.get(start..end).ok_or_else(wrong)?;
            *number = line.integer(field.trim_ascii(), EXPECTED)?;
            start = end;
        }
        let rest = &text[start..];
        let (name, format) = rest.split_at(rest.len().min(8));
        self.layout = layout(format.trim_ascii()).ok_or_else(wrong)?;
        self.head(numbers, name).map(Some)
    }

    fn column(&mut self) -> Result<[usize; 3], Error> {
        self.integers("column, row and number of words")
    }

    fn string<const N: usize>(&mut self) -> Result<[usize; N], Error> {
        self.integers("the length and the row of a string")
    }

    fn words(&self, is_double: bool, is_dense: bool) -> usize {
        if is_double && !is_dense { 2 } else { 1 }
    }

    fn numbers(&mut self, count: usize, _is_double: bool, values: &mut Vec<f64>) -> Result<(), Error> {
        let [per_line, width] = self.layout;
        let mut left = count;
        while left > 0 {
            let line = self.line("numbers")?;
            let expected = left.min(per_line);
            if line.text.len().div_ceil(width) != expected {
                let expected = format!("{expected} numbers of {width} characters");
                return Err(line.malformed(quoted(line.text), expected));
            }
            for number in line.text.chunks(width) {
                values.push(line.real(number.trim_ascii())?);
            }
            left -= expected;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Error> {
        Ok(())
    }
}

/// Numbers in a line and characters of each from `1P,5E16.9`, with or without its scale, or nothing, which means the same.
fn layout(format: &[u8]) -> Option<[usize; 2]> {
    let format = std::str::from_utf8(format).ok()?.to_ascii_uppercase();
    if format.is_empty() {
        return Some([5, 16]);
    }
    let format = format.strip_prefix("1P").unwrap_or(&format);
    let (per_line, number) = format.trim_start_matches(',').split_once(['E', 'D'])?;
    let (width, digits) = number.split_once('.')?;
    let (per_line, width) = (per_line.parse().ok()?, width.parse().ok()?);
    digits.parse::<u32>().ok()?;
    ((1..=1000).contains(&per_line) && WIDTHS.contains(&width)).then_some([per_line, width])
}
