//! From the text of a deck to blocks: a keyword line with its parameters, and the data lines below it.

use super::Line;
use crate::error::{DeckProblem, Error};
use crate::formats::common::visible;
use crate::formats::includes::{Includes, Open, file_name};
use std::path::{Path, PathBuf};

/// All files of a deck, included ones in place of the lines that include them.
pub(super) struct Source {
    /// File names.
    pub(super) files: Vec<String>,
    /// Which of them are outside the folder of the deck.
    outside: Vec<bool>,
    /// Their places; none for a text.
    pub(super) paths: Vec<PathBuf>,
    text: String,
    /// End in `text` and origin of each line.
    lines: Vec<(usize, Line)>,
    /// The last line of the deck's own file, if it has no end.
    unended: Option<Line>,
}

impl Source {
    pub(super) fn from_text(name: &str, text: &str) -> Result<Self, Error> {
        let mut source = Self::empty();
        source.append(name, text, false, &mut |source, _, at| {
            Err(source.error(
                at,
                DeckProblem::Include {
                    path: String::new(),
                    reason: "a deck given as text has no folder to look in; read it from its file".into(),
                },
            ))
        })?;
        Ok(source)
    }

    /// A deck, which may have `limit` bytes with all that it includes.
    pub(super) fn from_file(path: &Path, includes: Includes, limit: u64) -> Result<Self, Error> {
        Self::opened(path, Open::new(path, includes, limit)?)
    }

    /// A deck of which only the mesh is read.
    pub(super) fn mesh_from_file(path: &Path) -> Result<Self, Error> {
        Self::opened(path, Open::mesh(path)?)
    }

    fn opened(path: &Path, (mut open, bytes): (Open, Vec<u8>)) -> Result<Self, Error> {
        let mut source = Self::empty();
        source.paths.push(open.current().to_owned());
        source.append_file(&file_name(path), bytes, false, &mut open)?;
        Ok(source)
    }

    fn empty() -> Self {
        Self {
            files: Vec::new(),
            outside: Vec::new(),
            paths: Vec::new(),
            text: String::new(),
            lines: Vec::new(),
            unended: None,
        }
    }

    fn append_file(&mut self, name: &str, bytes: Vec<u8>, outside: bool, open: &mut Open) -> Result<(), Error> {
        // Comments may be in any old encoding; nothing else needs more than ASCII.
        let text =
            String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned());
        self.append(name, &text, outside, &mut |source, input, at| {
            let included = open.include(input, source.files.len());
            let (bytes, outside) = included.map_err(|reason| {
                let path = input.to_owned();
                source.error(at, DeckProblem::Include { path, reason })
            })?;
            source.paths.push(open.current().to_owned());
            source.append_file(input, bytes, outside, open)?;
            open.leave();
            Ok(())
        })
    }

    fn append(
        &mut self,
        name: &str,
        text: &str,
        outside: bool,
        include: &mut dyn FnMut(&mut Self, &str, Line) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let file = self.files.len() as u32;
        self.files.push(name.to_owned());
        self.outside.push(outside);
        for (number, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let line = line.trim();
            let at = Line {
                file,
                number: u32::try_from(number + 1).unwrap_or(u32::MAX),
            };
            if line.is_empty() || line.starts_with("**") {
                continue;
            }
            if let Some(header) = line.strip_prefix('*')
                && key(header.split(',').next().unwrap_or("")) == "INCLUDE"
            {
                let block = Block::new(self, header, at)?;
                block.allow(self, &["INPUT"])?;
                let input = block.required(self, "INPUT")?.to_owned();
                include(self, &input, at)?;
                continue;
            }
            self.text.push_str(line);
            self.lines.push((self.text.len(), at));
        }
        if file == 0 && !text.ends_with('\n') {
            self.unended = self.lines.last().map(|(_, at)| *at);
        }
        Ok(())
    }

    /// The last line.
    pub(super) fn last_line(&self) -> Line {
        self.lines.last().map(|(_, at)| *at).unwrap_or_default()
    }

    /// Refuses a deck that ends in the middle of a data line: the last number of a mesh would be another one.
    pub(super) fn check_end(&self, blocks: &[Block<'_>]) -> Result<(), Error> {
        let last = blocks.last().and_then(|block| block.data.last());
        match last {
            Some(line) if self.unended == Some(line.at) => Err(self.error(
                line.at,
                DeckProblem::Syntax {
                    found: excerpt(line.text),
                    reason: "the file ends in the middle of this line: save it again, or end the line if it is complete",
                },
            )),
            _ => Ok(()),
        }
    }

    /// Number of bytes that are neither comments nor blank lines.
    pub(super) fn size(&self) -> usize {
        self.text.len()
    }

    /// The error for a line; lines of files outside the folder of the deck are not quoted.
    pub(super) fn error(&self, at: Line, problem: DeckProblem) -> Error {
        let problem = match self.outside[at.file as usize] {
            true => DeckProblem::NotQuoted,
            false => problem,
        };
        Error::Deck {
            file: self.files[at.file as usize].clone(),
            line: at.number,
            problem,
        }
    }

    pub(super) fn blocks(&self) -> Result<Vec<Block<'_>>, Error> {
        let mut blocks: Vec<Block<'_>> = Vec::new();
        let (mut start, mut continues) = (0, false);
        for &(end, at) in &self.lines {
            let line = &self.text[start..end];
            start = end;
            if let Some(header) = line.strip_prefix('*') {
                continues = header.ends_with(',');
                blocks.push(Block::new(self, header, at)?);
                continue;
            }
            let Some(block) = blocks.last_mut() else {
                return Err(self.error(
                    at,
                    DeckProblem::Syntax {
                        found: excerpt(line),
                        reason: "data stand before the first keyword; give an input deck, in which lines with a star come first",
                    },
                ));
            };
            if continues {
                block.add_parameters(self, line, at)?;
                continues = line.ends_with(',');
            } else {
                block.data.push(Data { at, text: line });
            }
        }
        Ok(blocks)
    }
}

/// A keyword or parameter name without blanks, in capitals.
fn key(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_whitespace())
        .map(|c| c.to_ascii_uppercase())
        .collect()
}

/// The beginning of a text, for messages.
pub(super) fn excerpt(text: &str) -> String {
    const SHOWN: usize = 60;
    let more = text.chars().nth(SHOWN).map_or("", |_| " ...");
    visible(text.chars().take(SHOWN)) + more
}

/// Entries between commas outside quotes; a comma at the end adds none.
fn entries(text: &str) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    let text = text.strip_suffix(',').unwrap_or(text);
    text.split(move |c| {
        quoted ^= c == '"';
        c == ',' && !quoted
    })
    .map(str::trim)
}

fn unquoted(text: &str) -> &str {
    text.strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'))
        .unwrap_or(text)
}

/// A data line.
#[derive(Clone, Copy)]
pub(super) struct Data<'a> {
    pub(super) at: Line,
    pub(super) text: &'a str,
}

impl<'a> Data<'a> {
    pub(super) fn entries(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        entries(self.text).map(unquoted)
    }

    /// The entries, padded by empty ones; more than `N` are an error.
    pub(super) fn columns<const N: usize>(&self, source: &Source) -> Result<[&'a str; N], Error> {
        let mut columns = [""; N];
        for (i, entry) in self.entries().enumerate() {
            match columns.get_mut(i) {
                Some(column) => *column = entry,
                None if entry.is_empty() => {}
                None => {
                    return Err(source.error(
                        self.at,
                        DeckProblem::Syntax {
                            found: excerpt(self.text),
                            reason: "the line has more entries than the keyword takes",
                        },
                    ));
                }
            }
        }
        Ok(columns)
    }

    /// A finite number; Fortran's exponents `D` are understood, and an empty entry is zero.
    pub(super) fn number(&self, source: &Source, what: &'static str, text: &str) -> Result<f64, Error> {
        if text.is_empty() {
            return Ok(0.0);
        }
        let parsed = match text.find(['d', 'D']) {
            Some(at) => [&text[..at], "e", &text[at + 1..]].concat().parse::<f64>(),
            None => text.parse(),
        };
        parsed
            .ok()
            .filter(|value| value.is_finite())
            .ok_or_else(|| self.invalid(source, what, text, "a finite number"))
    }

    pub(super) fn label(&self, source: &Source, what: &'static str, text: &str) -> Result<u32, Error> {
        text.parse()
            .ok()
            .filter(|label| *label > 0)
            .ok_or_else(|| self.invalid(source, what, text, "a whole number from 1 to 4294967295"))
    }

    pub(super) fn invalid(&self, source: &Source, what: &'static str, found: &str, requirement: &'static str) -> Error {
        source.error(
            self.at,
            DeckProblem::Value {
                what,
                found: excerpt(found),
                requirement,
            },
        )
    }
}

/// A keyword with its parameters and data lines.
pub(super) struct Block<'a> {
    /// In capitals without blanks and star.
    pub(super) key: String,
    /// In capitals, for messages.
    pub(super) keyword: String,
    pub(super) at: Line,
    parameters: Vec<(String, &'a str)>,
    pub(super) data: Vec<Data<'a>>,
}

impl<'a> Block<'a> {
    /// `header` is the keyword line without its star.
    fn new(source: &Source, header: &'a str, at: Line) -> Result<Self, Error> {
        let (name, rest) = header.split_once(',').unwrap_or((header, ""));
        let words: Vec<String> = name.split_whitespace().map(str::to_ascii_uppercase).collect();
        let mut block = Self {
            key: key(name),
            keyword: excerpt(&words.join(" ")),
            at,
            parameters: Vec::new(),
            data: Vec::new(),
        };
        if block.key.is_empty() {
            return Err(source.error(
                at,
                DeckProblem::Syntax {
                    found: excerpt(header),
                    reason: "no keyword follows the star",
                },
            ));
        }
        block.add_parameters(source, rest, at)?;
        Ok(block)
    }

    fn add_parameters(&mut self, source: &Source, text: &'a str, at: Line) -> Result<(), Error> {
        for entry in entries(text).filter(|entry| !entry.is_empty()) {
            let (name, value) = entry.split_once('=').unwrap_or((entry, ""));
            let name = key(name);
            if self.parameters.iter().any(|(other, _)| *other == name) {
                return Err(source.error(
                    at,
                    DeckProblem::Syntax {
                        found: excerpt(entry),
                        reason: "the parameter is given twice",
                    },
                ));
            }
            self.parameters.push((name, unquoted(value.trim())));
        }
        Ok(())
    }

    /// Refuses parameters that are not in the list.
    pub(super) fn allow(&self, source: &Source, known: &[&str]) -> Result<(), Error> {
        match self.parameters.iter().find(|(name, _)| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some((name, _)) => Err(self.refuse(source, name, "remove it, or express the model without it")),
        }
    }

    pub(super) fn optional(&self, name: &str) -> Option<&'a str> {
        self.parameters
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| *value)
    }

    pub(super) fn required(&self, source: &Source, name: &'static str) -> Result<&'a str, Error> {
        self.optional(name).filter(|value| !value.is_empty()).ok_or_else(|| {
            source.error(
                self.at,
                DeckProblem::MissingParameter {
                    keyword: self.keyword.clone(),
                    parameter: name,
                },
            )
        })
    }

    pub(super) fn flag(&self, name: &str) -> bool {
        self.optional(name).is_some()
    }

    /// The number given as a parameter.
    pub(super) fn number(&self, source: &Source, name: &'static str) -> Result<Option<f64>, Error> {
        let Some(text) = self.optional(name) else {
            return Ok(None);
        };
        let line = Data { at: self.at, text };
        if text.is_empty() {
            return Err(line.invalid(source, name, text, "a finite number"));
        }
        line.number(source, name, text).map(Some)
    }

    /// The error for a parameter, or a value of it, that is not supported.
    pub(super) fn refuse(&self, source: &Source, parameter: &str, remedy: &'static str) -> Error {
        let value = self.optional(parameter).unwrap_or("");
        let shown = if value.is_empty() {
            parameter.to_owned()
        } else {
            format!("{parameter}={value}")
        };
        source.error(
            self.at,
            DeckProblem::Parameter {
                keyword: self.keyword.clone(),
                parameter: excerpt(&shown),
                remedy,
            },
        )
    }

    /// One of the listed values of a parameter, or the first if it is not given.
    pub(super) fn choice(&self, source: &Source, name: &str, values: &[&'static str]) -> Result<&'static str, Error> {
        match self.optional(name) {
            None => Ok(values[0]),
            Some(given) => {
                let found = values.iter().find(|value| key(given) == **value);
                found.copied().ok_or_else(|| {
                    self.refuse(source, name, "this value is not supported; remove it or choose another")
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::TemporaryFolder;

    #[test]
    fn a_deck_and_its_includes_share_one_limit() {
        let folder = TemporaryFolder::new("finite-elements-includes");
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        let nodes = format!("*NODE\n** {}\n1, 0., 0., 0.\n", "-".repeat(960));
        write("nodes.inp", &nodes);
        // The same file again and again counts each time.
        write("main.inp", &"*INCLUDE, INPUT=nodes.inp\n".repeat(50));
        let read = |limit: u64| Source::from_file(&folder.join("main.inp"), Includes::BelowTheDeck, limit);
        let needed = 50 * (26 + nodes.len() as u64);
        assert_eq!(read(needed).unwrap().files.len(), 51);
        let error = read(needed - 1).err().unwrap().to_string();
        assert!(error.starts_with("main.inp:50: *INCLUDE of `nodes.inp`"), "{error}");
        assert!(error.contains(&format!("leave {} of", nodes.len() - 1)), "{error}");
        let error = read(100).err().unwrap();
        assert!(
            matches!(
                error,
                Error::InputFile(file_io::input::Error::TooLarge { limit: 100, .. })
            ),
            "{error}"
        );
    }
}
