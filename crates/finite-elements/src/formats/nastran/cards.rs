//! From the text of bulk data to cards of fields.

use crate::Error;
use crate::error::Position;
use crate::formats::common::quoted;
use crate::formats::includes::{Open, file_name};
use crate::formats::lines::real;
use std::path::{Path, PathBuf};

/// All files, included ones in place of the lines that include them.
pub(super) struct Source {
    files: Vec<String>,
    pub(super) paths: Vec<PathBuf>,
    text: String,
    /// End in `text`, file and number of each line.
    lines: Vec<(usize, u32, u32)>,
    /// Whether the file itself ends in the middle of a line.
    is_unended: bool,
}

/// A card: its name in capitals, and its fields, those of every line filled up.
pub(super) struct Card<'a> {
    /// Its first line, counted over all files.
    pub(super) at: u32,
    pub(super) name: String,
    pub(super) fields: Vec<&'a str>,
}

impl Source {
    pub(super) fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let mut source = Self::empty();
        source.append(name, bytes, &mut |source, _, at| {
            Err(source.contents(
                at,
                "a file given as text includes another".into(),
                "read it from its folder",
            ))
        })?;
        Ok(source)
    }

    pub(super) fn from_file(path: &Path) -> Result<Self, Error> {
        let (mut open, bytes) = Open::mesh(path)?;
        let mut source = Self::empty();
        source.paths.push(open.current().to_owned());
        source.append_file(&file_name(path), &bytes, &mut open)?;
        Ok(source)
    }

    fn empty() -> Self {
        Self {
            files: Vec::new(),
            paths: Vec::new(),
            text: String::new(),
            lines: Vec::new(),
            is_unended: false,
        }
    }

    fn append_file(&mut self, name: &str, bytes: &[u8], open: &mut Open) -> Result<(), Error> {
        self.append(name, bytes, &mut |source, input, at| {
            let (bytes, _) = open.include(input, source.files.len()).map_err(|reason| {
                source.contents(
                    at,
                    format!("INCLUDE of `{input}`: {reason}"),
                    "correct the line, or remove it",
                )
            })?;
            source.paths.push(open.current().to_owned());
            source.append_file(input, &bytes, open)?;
            open.leave();
            Ok(())
        })
    }

    fn append(
        &mut self,
        name: &str,
        bytes: &[u8],
        include: &mut dyn FnMut(&mut Self, &str, u32) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let file = self.files.len() as u32;
        self.files.push(name.to_owned());
        // Comments may be in any old encoding; nothing else needs more than ASCII.
        let text = String::from_utf8_lossy(bytes);
        for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let line = line.trim_end();
            if line.is_empty() {
                continue;
            }
            push_without_tabs(&mut self.text, line);
            self.lines.push((self.text.len(), file, number));
            if line.get(..7).is_some_and(|word| word.eq_ignore_ascii_case("INCLUDE")) {
                let input = line[7..].trim().trim_matches(['\'', '"']).to_owned();
                include(self, &input, self.lines.len() as u32 - 1)?;
            }
        }
        if file == 0 {
            self.is_unended = !text.ends_with('\n');
        }
        Ok(())
    }

    fn place(&self, at: u32) -> (String, Position) {
        let (_, file, number) = self.lines.get(at as usize).copied().unwrap_or((0, 0, 1));
        (self.files[file as usize].clone(), Position::Line(number as usize))
    }

    /// The name of the file itself.
    pub(super) fn name(&self) -> &str {
        &self.files[0]
    }

    pub(super) fn last(&self) -> u32 {
        (self.lines.len() as u32).saturating_sub(1)
    }

    pub(super) fn contents(&self, at: u32, problem: String, remedy: &'static str) -> Error {
        let (file, at) = self.place(at);
        Error::MeshContents {
            file,
            at,
            problem,
            remedy,
        }
    }

    pub(super) fn unsupported(&self, at: u32, what: String, remedy: &'static str) -> Error {
        let (file, at) = self.place(at);
        Error::MeshUnsupported {
            file,
            at,
            what,
            remedy: remedy.into(),
        }
    }

    pub(super) fn syntax(&self, at: u32, expected: &str, found: &str) -> Error {
        let (file, at) = self.place(at);
        Error::MeshSyntax {
            file,
            at,
            expected: expected.into(),
            found: quoted(found.as_bytes()),
        }
    }

    /// Calls `card` for each card between `BEGIN BULK`, if there is one, and `ENDDATA`, and `comment` for each comment.
    pub(super) fn cards<'a>(
        &'a self,
        mut card: impl FnMut(Card<'a>) -> Result<(), Error>,
        mut comment: impl FnMut(&'a str),
    ) -> Result<(), Error> {
        let mut start = 0;
        let lines = self.lines.iter().map(|(end, ..)| {
            let line = &self.text[start..*end];
            start = *end;
            line
        });
        let lines: Vec<(u32, &str)> = (0..).zip(lines).collect();
        let begin = lines.iter().position(|(_, line)| {
            let mut words = line.split_ascii_whitespace();
            let mut is = |word: &str| words.next().is_some_and(|found| found.eq_ignore_ascii_case(word));
            is("BEGIN") && is("BULK")
        });
        let mut current: Option<Card<'a>> = None;
        for &(at, line) in &lines[begin.map_or(0, |line| line + 1)..] {
            let (data, remark) = line.split_at(line.find('$').unwrap_or(line.len()));
            if !remark.is_empty() {
                comment(remark);
            }
            if data.trim().is_empty() {
                continue;
            }
            let line = self.line(at, data)?;
            match (line.name.is_empty(), &mut current) {
                (true, Some(card)) => card.fields.extend(line.fields),
                (true, None) => {
                    return Err(self.syntax(at, "the name of a card", data.trim()));
                }
                (false, _) => {
                    let name = line.name.to_ascii_uppercase();
                    if let Some(done) = current.take() {
                        card(done)?;
                    }
                    if name == "ENDDATA" {
                        return Ok(());
                    }
                    current = Some(Card {
                        at,
                        name,
                        fields: line.fields,
                    });
                }
            }
        }
        if self.is_unended {
            return Err(self.contents(
                self.last(),
                "the file ends in the middle of this line".into(),
                "save it again, or end the line if it is complete",
            ));
        }
        current.map_or(Ok(()), card)
    }

    /// The fields of a line; the name is empty on continuations.
    fn line<'a>(&self, at: u32, data: &'a str) -> Result<Line<'a>, Error> {
        if !data.is_ascii() {
            return Err(self.syntax(at, "plain letters, digits and signs", data));
        }
        let is_continuation = data.starts_with([' ', '+', '*', ',']);
        if let Some(comma) = data.find(',')
            && (comma <= 8 || !data[..8].contains(' '))
        {
            let mut fields: Vec<&str> = data.split(',').map(str::trim).collect();
            let name = fields.remove(0);
            let is_large = name.ends_with('*');
            let count = if is_large { 4 } else { 8 };
            if fields.len() > count + 1 && fields[count + 1..].iter().any(|field| !field.is_empty()) {
                return Err(self.syntax(
                    at,
                    "at most eight fields, or four of a card with a star, and a continuation",
                    data,
                ));
            }
            fields.resize(count, "");
            return Ok(Line {
                name: if is_continuation {
                    ""
                } else {
                    name.trim_end_matches('*').trim()
                },
                fields,
            });
        }
        let head = data[..8.min(data.len())].trim();
        let is_large = head.ends_with('*') || data.starts_with('*');
        let (count, width) = if is_large { (4, 16) } else { (8, 8) };
        let mut fields = Vec::with_capacity(count);
        for number in 0..count {
            let first = 8 + number * width;
            let field = match first < data.len() {
                false => "",
                true => &data[first..(first + width).min(data.len())],
            };
            fields.push(field.trim());
        }
        Ok(Line {
            name: if is_continuation {
                ""
            } else {
                head.trim_end_matches('*').trim()
            },
            fields,
        })
    }
}

/// Adds a line in which tabs go on to the next field of eight characters.
fn push_without_tabs(text: &mut String, line: &str) {
    let start = text.len();
    for part in line.split_inclusive('\t') {
        match part.strip_suffix('\t') {
            None => text.push_str(part),
            Some(part) => {
                text.push_str(part);
                let column = text.len() - start;
                text.extend(std::iter::repeat_n(' ', 8 - column % 8));
            }
        }
    }
}

struct Line<'a> {
    name: &'a str,
    fields: Vec<&'a str>,
}

impl<'a> Card<'a> {
    /// A field, counted from zero after the name; empty where the card ends before.
    pub(super) fn field(&self, number: usize) -> &'a str {
        self.fields.get(number).copied().unwrap_or("")
    }

    /// A whole number that is not negative.
    pub(super) fn integer(&self, source: &Source, number: usize) -> Result<u64, Error> {
        let field = self.field(number);
        field.parse().map_err(|_| self.fails(source, number, "a whole number"))
    }

    /// Zero where the field is empty.
    pub(super) fn integer_or_zero(&self, source: &Source, number: usize) -> Result<u64, Error> {
        match self.field(number) {
            "" => Ok(0),
            _ => self.integer(source, number),
        }
    }

    /// Three real numbers; empty fields are zero.
    pub(super) fn triple(&self, source: &Source, first: usize) -> Result<[f64; 3], Error> {
        let mut values = [0.0; 3];
        for (number, value) in (first..).zip(&mut values) {
            let field = self.field(number);
            if !field.is_empty() {
                *value = real(field).ok_or_else(|| self.fails(source, number, "a real number"))?;
            }
        }
        Ok(values)
    }

    fn fails(&self, source: &Source, number: usize, expected: &str) -> Error {
        let expected = format!("{expected} in field {} of {}", number + 2, self.name);
        source.syntax(self.at, &expected, self.field(number))
    }

    /// The numbers in the fields from `first` on, with `A THRU B` written out.
    ///
    /// `most` is how many there may be.
    pub(super) fn list(&self, source: &Source, first: usize, most: usize) -> Result<Vec<u64>, Error> {
        let mut list: Vec<u64> = Vec::new();
        let mut number = first;
        while number < self.fields.len() {
            let field = self.field(number);
            if field.eq_ignore_ascii_case("THRU") {
                let end = self.integer(source, number + 1)?;
                let Some(&begin) = list.last() else {
                    return Err(self.fails(source, number, "a number before THRU"));
                };
                if end < begin || end - begin > most as u64 {
                    return Err(self.fails(source, number + 1, "the end of a range of what is in the file"));
                }
                list.extend(begin + 1..=end);
                number += 2;
                continue;
            }
            if !field.is_empty() {
                list.push(self.integer(source, number)?);
            }
            number += 1;
        }
        Ok(list)
    }
}
