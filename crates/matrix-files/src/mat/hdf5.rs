//! Files of `-v7.3`: HDF5 with MATLAB's attributes.
//!
//! A variable is a data set whose dimensions are reversed, so that its numbers stand column by column; a sparse matrix is a
//! group of the data sets `data`, `ir` and `jc`, and a structure a group of its fields. `MATLAB_class` names the class,
//! `MATLAB_sparse` the number of rows, `MATLAB_empty` marks data sets that hold dimensions.

use crate::Error;
use crate::value::{Array, Collection, Dense, Skipped, plausible};
use file_io::{Place, Source};
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, H5Type, Hdf5File, OpenOptions};
use sprs::CsMat;

/// How deep structures may be nested.
const DEPTH: usize = 32;

/// Most bytes for each byte of the file that a data set may have once it is unpacked: what deflate reaches.
const PACKED: usize = 1032;

pub(super) fn parse(source: Source<'_>) -> Result<Collection, Error> {
    let most = source.bytes.len().saturating_mul(PACKED);
    let options = OpenOptions {
        max_chunk_bytes: most,
        max_read_bytes: most,
        ..OpenOptions::default()
    };
    let reader = Reader {
        file: source.name,
        most,
    };
    let no_file =
        |reason: hdf5_reader::error::Error| reader.malformed("", reason.to_string(), "HDF5 as MATLAB writes it");
    let file = Hdf5File::from_bytes_with_options(source.bytes, options).map_err(no_file)?;
    if file.superblock().eof_address > source.bytes.len() as u64 {
        return Err(reader.malformed("", "the end of the file", "as many bytes as it states"));
    }
    let root = file.root_group().map_err(no_file)?;
    let mut found = Collection::default();
    reader.members(&root, None, 0, &mut found)?;
    Ok(found)
}

struct Reader<'a> {
    file: &'a str,
    most: usize,
}

impl Reader<'_> {
    /// A variable; of the file itself, which has no name, its beginning.
    fn place(name: &str) -> Place {
        if name.is_empty() {
            return Place::Byte(0);
        }
        Place::Inside {
            part: format!("the variable `{name}`"),
            byte: 0,
        }
    }

    fn malformed(&self, name: &str, found: impl Into<String>, expected: &str) -> Error {
        Error::Malformed {
            file: self.file.into(),
            place: Self::place(name),
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// All variables of the file, or fields of a structure.
    fn members(&self, group: &Group, parent: Option<&str>, depth: usize, found: &mut Collection) -> Result<(), Error> {
        let members = group.members();
        let (groups, sets) =
            members.map_err(|reason| self.malformed(parent.unwrap_or_default(), reason.to_string(), "variables"))?;
        let joined = |name: &str| parent.map_or_else(|| name.to_owned(), |parent| format!("{parent}.{name}"));
        for group in groups {
            let name = joined(group.name());
            // What cells and objects refer to.
            if group.name().starts_with('#') {
                continue;
            }
            let attributes = group.attributes();
            let attributes =
                attributes.map_err(|reason| self.malformed(&name, reason.to_string(), "MATLAB's attributes"))?;
            match (
                word(&attributes, "MATLAB_sparse"),
                text(&attributes, "MATLAB_class").as_deref(),
            ) {
                (Some(rows), _) => {
                    let matrix = self.sparse(&group, &name, rows)?;
                    found.arrays.insert(name, Array::Sparse(matrix));
                }
                (None, Some("struct") | None) if depth < DEPTH => {
                    self.members(&group, Some(&name), depth + 1, found)?;
                }
                (None, class) => skip(found, name, format!("a group of class {}", class.unwrap_or("struct"))),
            }
        }
        for set in sets {
            let name = joined(set.name().rsplit('/').next().unwrap_or_default());
            self.variable(&set, name, found)?;
        }
        Ok(())
    }

    fn variable(&self, set: &Dataset, name: String, found: &mut Collection) -> Result<(), Error> {
        let attributes = set.attributes();
        let class = text(&attributes, "MATLAB_class").unwrap_or_default();
        let is_empty = word(&attributes, "MATLAB_empty").is_some_and(|value| value > 0);
        let shape: Vec<usize> = if is_empty {
            let dimensions = self.integers(set, &name)?;
            dimensions.iter().map(|size| (*size).max(0) as usize).collect()
        } else {
            set.shape().iter().rev().map(|size| *size as usize).collect()
        };
        let &[rows, columns] = &shape[..] else {
            skip(found, name, format!("an array of {} dimensions", shape.len()));
            return Ok(());
        };
        if is_empty && rows.min(columns) > 0 {
            return Err(self.malformed(&name, format!("{rows} x {columns}"), "an empty array"));
        }
        if is_empty {
            plausible(rows, columns, self.most)
                .map_err(|_| self.malformed(&name, format!("{rows} x {columns}"), "an array that the file can hold"))?;
        }
        let array = match (class.as_str(), set.dtype()) {
            ("char", _) if is_empty => Array::Text(String::new()),
            ("double" | "single", _) if is_empty => Array::Dense(Dense::try_new(rows, columns, Vec::new())?),
            ("char", Datatype::FixedPoint { .. }) => Array::Text(self.characters(set, &name, rows)?),
            ("double" | "single", Datatype::FloatingPoint { .. }) => {
                Array::Dense(Dense::try_new(rows, columns, self.reals(set, &name)?)?)
            }
            ("logical", Datatype::FixedPoint { .. }) | (_, Datatype::FixedPoint { .. })
                if class == "logical" || class.contains("int") =>
            {
                let values = if is_empty {
                    Vec::new()
                } else {
                    self.integers(set, &name)?
                };
                Array::Integers(Dense::try_new(rows, columns, values)?)
            }
            (_, Datatype::Compound { .. }) => {
                skip(found, name, "an array of complex numbers");
                return Ok(());
            }
            (class, _) => {
                skip(found, name, format!("an array of class `{class}`"));
                return Ok(());
            }
        };
        found.arrays.insert(name, array);
        Ok(())
    }

    /// All numbers of a data set in the order of the file.
    fn read<T: H5Type>(&self, set: &Dataset, name: &str) -> Result<Vec<T>, Error> {
        let count = set.num_elements().ok().filter(|count| *count <= self.most as u64);
        if count.is_none() {
            return Err(self.malformed(name, "more numbers than the file can hold", "fewer"));
        }
        let array = set.read_array::<T>();
        let array = array.map_err(|reason| self.malformed(name, reason.to_string(), "numbers"))?;
        Ok(array.into_iter().collect())
    }

    fn reals(&self, set: &Dataset, name: &str) -> Result<Vec<f64>, Error> {
        let values = match set.dtype() {
            Datatype::FloatingPoint { size: 4, .. } => {
                let single = self.read::<f32>(set, name)?;
                single.into_iter().map(f64::from).collect()
            }
            Datatype::FloatingPoint { .. } => self.read::<f64>(set, name)?,
            _ => self
                .integers(set, name)?
                .into_iter()
                .map(|value| value as f64)
                .collect(),
        };
        match values.iter().find(|value| !value.is_finite()) {
            Some(&value) => Err(Error::NotFinite {
                file: self.file.into(),
                place: Self::place(name),
                value,
            }),
            None => Ok(values),
        }
    }

    fn integers(&self, set: &Dataset, name: &str) -> Result<Vec<i64>, Error> {
        macro_rules! widened {
            ($type:ty) => {
                self.read::<$type>(set, name)?
                    .into_iter()
                    .map(i64::from)
                    .collect()
            };
        }
        let Datatype::FixedPoint { size, signed, .. } = set.dtype() else {
            return Err(self.malformed(name, "another type", "whole numbers"));
        };
        Ok(match (size, signed) {
            (1, false) => widened!(u8),
            (1, true) => widened!(i8),
            (2, false) => widened!(u16),
            (2, true) => widened!(i16),
            (4, false) => widened!(u32),
            (4, true) => widened!(i32),
            (8, true) => self.read::<i64>(set, name)?,
            (8, false) => {
                let wide = self.read::<u64>(set, name)?.into_iter().map(i64::try_from);
                wide.collect::<Result<_, _>>()
                    .map_err(|_| self.malformed(name, "a number beyond 2^63", "an integer of 64 bits with sign"))?
            }
            _ => return Err(self.malformed(name, format!("numbers of {size} bytes"), "1, 2, 4 or 8")),
        })
    }

    /// Text, the rows of which are stored column by column.
    fn characters(&self, set: &Dataset, name: &str, rows: usize) -> Result<String, Error> {
        let units: Option<Vec<u16>> = (self.integers(set, name)?.into_iter())
            .map(|unit| u16::try_from(unit).ok())
            .collect();
        let no_text = || self.malformed(name, "numbers that are no text", "text in UTF-16");
        let units = units.ok_or_else(no_text)?;
        let lines = (0..rows).map(|row| {
            let line: Vec<u16> = units[row.min(units.len())..].iter().step_by(rows).copied().collect();
            String::from_utf16(&line).map_err(|_| no_text())
        });
        let mut lines = lines.collect::<Result<Vec<_>, _>>()?;
        if rows > 1 {
            let trimmed = |line: &mut String| line.truncate(line.trim_end_matches([' ', '\0']).len());
            lines.iter_mut().for_each(trimmed);
        }
        Ok(lines.join("\n"))
    }

    /// A sparse matrix: values and rows of its entries, and where its columns begin.
    fn sparse(&self, group: &Group, name: &str, rows: usize) -> Result<CsMat<f64>, Error> {
        let set = |part: &str| group.dataset(part).ok();
        let starts = set("jc").ok_or_else(|| self.malformed(name, "no `jc`", "the beginnings of the columns"))?;
        let sizes = |set: &Dataset| -> Result<Vec<usize>, Error> {
            let sizes = self.integers(set, name)?.into_iter().map(usize::try_from);
            sizes
                .collect::<Result<_, _>>()
                .map_err(|_| self.malformed(name, "a negative index", "numbers from 0"))
        };
        let begins = sizes(&starts)?;
        let columns = begins.len().saturating_sub(1);
        plausible(rows, columns, self.most).map_err(|(stated, possible)| Error::Oversized {
            file: self.file.into(),
            place: Self::place(name),
            what: "the number of rows or columns",
            stated: stated as u128,
            possible,
        })?;
        let count = begins.last().copied().unwrap_or(0);
        // Without entries there are no data sets for them.
        let (mut row_of, mut values) = match (set("ir"), set("data")) {
            (Some(row_of), Some(values)) => (sizes(&row_of)?, self.reals(&values, name)?),
            _ => (Vec::new(), Vec::new()),
        };
        let is_sound = begins.first() == Some(&0)
            && begins.is_sorted()
            && row_of.len() >= count
            && values.len() >= count
            && begins.windows(2).all(|ends| {
                let inside = &row_of[ends[0]..ends[1]];
                inside.is_sorted_by(|a, b| a < b) && inside.last().is_none_or(|last| *last < rows)
            });
        if !is_sound {
            return Err(self.malformed(
                name,
                "columns and rows that do not fit",
                "columns that ascend from 0, and in each the rows once and in ascending order",
            ));
        }
        row_of.truncate(count);
        values.truncate(count);
        Ok(CsMat::new_csc((rows, columns), begins, row_of, values).to_csr())
    }
}

fn skip(found: &mut Collection, name: String, reason: impl Into<String>) {
    found.skipped.push(Skipped {
        name,
        reason: reason.into(),
    });
}

fn attribute<'a>(attributes: &'a [Attribute], name: &str) -> Option<&'a Attribute> {
    attributes.iter().find(|attribute| attribute.name == name)
}

fn text(attributes: &[Attribute], name: &str) -> Option<String> {
    attribute(attributes, name)?.read_string().ok()
}

fn word(attributes: &[Attribute], name: &str) -> Option<usize> {
    let value = attribute(attributes, name)?.read_as_f64().ok()?;
    (0.0..1e15).contains(&value).then_some(value as usize)
}
