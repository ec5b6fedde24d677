//! Matrices between points as Nastran's entries `DMIG`, in punch and bulk data files (`.pch`, `.bdf`, `.dat`).
//!
//! Layout: *MSC Nastran Quick Reference Guide*, entry `DMIG` and the formats of bulk data. A matrix has a header and
//! an entry for each column:
//!
//! ```text
//! DMIG    NAME           0     IFO     TIN    TOUT   POLAR            NCOL
//! DMIG    NAME          GJ      CJ              G1      C1      A1
//!               G2      C2      A2
//! ```
//!
//! `GJ` and `CJ` are the grid point and component of a column, `G1` and `C1` those of a row, `A1` is the entry there.
//! Scalar points have component 0 or none. Fields have 8 characters, 16 in lines that are marked by `*`, or stand
//! between commas.

mod fields;
mod writer;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use sprs::CsMat;

pub use self::writer::to_bytes;
use crate::text::{self, Line};
use crate::triplets::{self, Entry, Origin};
use crate::value::{Dof, Skipped, plausible};
use crate::{Error, writing};
use file_io::{Source, quoted};

/// Highest component of a point.
const COMPONENTS: usize = 6;

/// Forms that are read: square, rectangular, symmetric, with numbered columns.
pub(crate) const FORMS: [u32; 4] = [1, 2, 6, 9];
pub(crate) const FORMS_TO_WRITE: &str = "write it as a square, symmetric or rectangular one (IFO 1, 6 or 9)";

/// Matrices over the points of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointMatrices {
    /// What rows belong to: every point and component that any matrix names, in ascending order. Component 0 is that of
    /// a scalar point.
    pub dofs: Vec<Dof>,
    /// Matrices by name whose columns belong to the same (`IFO` 1, 2 and 6), compressed by rows, both triangles filled;
    /// columns that a rectangular one does not have are zero.
    pub matrices: BTreeMap<String, CsMat<f64>>,
    /// Matrices by name whose columns are numbered (`IFO` 9).
    pub numbered: BTreeMap<String, CsMat<f64>>,
    /// What else is in the file, by the names of the entries.
    pub skipped: Vec<Skipped>,
}

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<PointMatrices, Error> {
    text::read(path, parse)
}

/// Reads all matrices by their names in capitals.
///
/// Of symmetric ones (`IFO` 6) each pair of entries is given once. The precisions that `TIN` and `TOUT` state change no number.
/// Other entries of bulk data, and what stands before `BEGIN BULK` and after `ENDDATA`, are listed as skipped.
///
/// # Errors
/// [`Error::Unsupported`] for complex matrices and other forms, [`Error::Malformed`], [`Error::Oversized`],
/// [`Error::OutOfRange`], [`Error::NotFinite`]; [`Error::Duplicate`] and [`Error::Asymmetric`], which count rows and
/// columns along [`PointMatrices::dofs`].
pub fn parse(source: Source<'_>) -> Result<PointMatrices, Error> {
    let mut reader = Reader {
        names: BTreeMap::new(),
        matrices: Vec::new(),
        entry: Current::None,
        others: BTreeMap::new(),
    };
    let starts = |line: &Line<'_>, word: &[u8]| {
        let text = line.text.trim_ascii_start();
        text.get(..word.len())
            .is_some_and(|start| start.eq_ignore_ascii_case(word))
    };
    let mut skipped = Vec::new();
    let mut skip = |what: &str, lines: usize| {
        if lines > 0 {
            skipped.push(Skipped {
                name: what.into(),
                reason: format!("{lines} lines outside the bulk data"),
            });
        }
    };
    let is_begin = |line: &Line<'_>| starts(line, b"BEGIN");
    let mut lines = text::indented_lines(source);
    if text::indented_lines(source).any(|line| is_begin(&line)) {
        skip("BEGIN BULK", lines.by_ref().take_while(|line| !is_begin(line)).count());
    }
    let mut last = None;
    let mut fields = Vec::new();
    for line in lines.by_ref() {
        last = Some(line);
        if starts(&line, b"ENDDATA") {
            break;
        }
        if let Some(first) = fields::split(line, &mut fields)? {
            reader.line(line, first, &fields)?;
        }
    }
    skip("ENDDATA", lines.filter(|line| !line.text.is_empty()).count());
    let others = reader.others.iter().map(|(name, count)| Skipped {
        name: String::from_utf8_lossy(name).trim_end().to_owned(),
        reason: format!("{count} entries that are no DMIG"),
    });
    skipped.extend(others);
    match last {
        Some(line) if reader.matrices.is_empty() => Err(line.malformed("the end of the bulk data", "entries DMIG")),
        _ => assemble(Origin::lines(source.name), source.bytes.len(), reader.matrices, skipped),
    }
}

/// What continuations belong to.
enum Current {
    None,
    Other,
    /// The first half of the header of a matrix.
    Header(usize),
    /// The whole header.
    Complete,
    /// Matrix and column.
    Column(usize, usize),
}

struct Reader {
    /// Places of matrices.
    names: BTreeMap<String, usize>,
    matrices: Vec<(String, Matrix)>,
    entry: Current,
    others: BTreeMap<[u8; 8], usize>,
}

/// A matrix as it stands; a point and its component are one number.
#[derive(Default)]
pub(crate) struct Matrix {
    /// Where it begins.
    pub(crate) at: usize,
    pub(crate) form: Option<u32>,
    pub(crate) n_columns: Option<usize>,
    /// Columns that have entries `DMIG`, and the number of these.
    pub(crate) columns: BTreeSet<usize>,
    pub(crate) n_entries: usize,
    pub(crate) terms: Vec<Entry>,
}

impl Reader {
    fn line(&mut self, line: Line<'_>, first: &[u8], fields: &[&[u8]]) -> Result<(), Error> {
        let (groups, _) = fields.as_chunks::<4>();
        let mut groups = groups.iter();
        if first.eq_ignore_ascii_case(b"DMIG") {
            if let Some(group) = groups.next() {
                self.entry = self.begin(line, *group)?;
            }
        } else if !first.is_empty() {
            let name = std::str::from_utf8(first)
                .ok()
                .filter(|name| writing::is_nastran_name(name));
            let name = name.ok_or_else(|| line.malformed(quoted(line.text), "an entry of bulk data"))?;
            let mut key = [b' '; 8];
            for (to, from) in key.iter_mut().zip(name.bytes()) {
                *to = from.to_ascii_uppercase();
            }
            *self.others.entry(key).or_default() += 1;
            self.entry = Current::Other;
        }
        for group in groups {
            self.group(line, *group)?;
        }
        Ok(())
    }

    /// The first four fields.
    fn begin(&mut self, line: Line<'_>, [name, point, third, fourth]: [&[u8]; 4]) -> Result<Current, Error> {
        let text = String::from_utf8_lossy(name).to_ascii_uppercase();
        if !writing::is_nastran_name(&text) {
            return Err(line.malformed(quoted(name), "a name of up to eight letters and digits"));
        }
        let found = self.names.get(&text).copied().unwrap_or(self.matrices.len());
        if found == self.matrices.len() {
            self.names.insert(text.clone(), found);
            let at = line.number;
            self.matrices.push((
                text,
                Matrix {
                    at,
                    ..Matrix::default()
                },
            ));
        }
        let (_, matrix) = &mut self.matrices[found];
        if line.integer::<u64>(point, "0 or a point")? > 0 {
            if !fourth.is_empty() {
                return Err(line.malformed(quoted(fourth), "an empty field after the component of a column"));
            }
            let column = key(line, point, third)?;
            matrix.columns.insert(column);
            matrix.n_entries += 1;
            return Ok(Current::Column(found, column));
        }
        if matrix.form.is_some() {
            return Err(line.malformed(format!("a second header of {}", quoted(name)), "each name once"));
        }
        let form = line.integer(third, "the form IFO")?;
        if !FORMS.contains(&form) {
            let found = format!("the form {form} of the matrix {}", quoted(name));
            return Err(line.unsupported(found, FORMS_TO_WRITE));
        }
        precision(line, fourth)?;
        (matrix.form, matrix.at) = (Some(form), line.number);
        Ok(Current::Header(found))
    }

    /// Four fields more.
    fn group(&mut self, line: Line<'_>, group: [&[u8]; 4]) -> Result<(), Error> {
        let [first, second, third, fourth] = group;
        let is_empty = group == [b""; 4];
        match self.entry {
            Current::None => return Err(line.malformed(quoted(line.text), "an entry before its continuation")),
            Current::Complete if !is_empty => return Err(line.malformed(quoted(line.text), "the end of the header")),
            Current::Header(matrix) => {
                if !matches!(first, b"" | b"0") {
                    precision(line, first)?;
                }
                if !matches!(second, b"" | b"0") {
                    return Err(line.unsupported("a matrix as amplitudes and phases", "write real numbers (POLAR 0)"));
                }
                if !third.is_empty() {
                    return Err(line.malformed(quoted(third), "an empty field before NCOL"));
                }
                if !fourth.is_empty() {
                    let n_columns: usize = line.integer(fourth, "the number of columns NCOL")?;
                    self.matrices[matrix].1.n_columns = Some(n_columns);
                }
                self.entry = Current::Complete;
            }
            Current::Column(matrix, column) if !is_empty => {
                if !fourth.is_empty() && line.real(fourth)? != 0.0 {
                    return Err(line.unsupported("an imaginary part", "write real matrices"));
                }
                self.matrices[matrix].1.terms.push(Entry {
                    row: key(line, first, second)?,
                    column,
                    value: line.real(third)?,
                    at: line.number,
                });
            }
            Current::Other | Current::Complete | Current::Column(..) => {}
        }
        Ok(())
    }
}

/// Matrices of a file of so many bytes over all points that any of them names.
pub(crate) fn assemble(
    origin: Origin<'_>,
    bytes: usize,
    matrices: Vec<(String, Matrix)>,
    skipped: Vec<Skipped>,
) -> Result<PointMatrices, Error> {
    let mut keys: Vec<usize> = Vec::new();
    for (_, matrix) in &matrices {
        keys.extend(matrix.terms.iter().map(|term| term.row));
        if matrix.form != Some(9) {
            keys.extend(&matrix.columns);
        }
    }
    keys.sort_unstable();
    keys.dedup();
    // A matrix takes room for its rows even if it has no entries.
    let rows = keys.len().saturating_mul(matrices.len());
    let oversized = |at, what, (stated, possible): (usize, usize)| Error::Oversized {
        file: origin.file.into(),
        place: (origin.place)(at),
        what,
        stated: stated as u128,
        possible,
    };
    plausible(rows, 0, bytes).map_err(|found| {
        oversized(
            matrices.first().map_or(1, |(_, first)| first.at),
            "the number of rows of all",
            found,
        )
    })?;
    let mut found = PointMatrices {
        dofs: keys
            .iter()
            .map(|key| Dof::Nodal {
                node: (key / (COMPONENTS + 1)) as u64,
                component: (key % (COMPONENTS + 1)) as u32,
            })
            .collect(),
        skipped,
        ..PointMatrices::default()
    };
    let n = keys.len();
    // Every row is in the list.
    let place = |key: usize| keys.partition_point(|k| *k < key);
    for (name, mut matrix) in matrices {
        let form = matrix.form.ok_or_else(|| Error::Malformed {
            file: origin.file.into(),
            place: (origin.place)(matrix.at),
            found: format!("columns of `{name}`"),
            expected: "a header of it in the same file".into(),
        })?;
        if form == 9 {
            let n_columns = matrix.number_columns(origin)?;
            plausible(0, n_columns, bytes).map_err(|found| oversized(matrix.at, "NCOL", found))?;
            matrix.terms.iter_mut().for_each(|term| term.row = place(term.row));
            let numbered = triplets::general(origin, (n, n_columns), matrix.terms)?;
            found.numbered.insert(name, numbered);
            continue;
        }
        for term in &mut matrix.terms {
            (term.row, term.column) = (place(term.row), place(term.column));
        }
        let square = match form {
            6 => triplets::symmetric(origin, n, matrix.terms, false)?,
            _ => triplets::general(origin, (n, n), matrix.terms)?,
        };
        found.matrices.insert(name, square);
    }
    Ok(found)
}

impl Matrix {
    /// Columns become numbers: the points themselves if their number is stated, else positions in ascending order.
    fn number_columns(&mut self, origin: Origin<'_>) -> Result<usize, Error> {
        let Some(stated) = self.n_columns else {
            let columns: Vec<usize> = self.columns.iter().copied().collect();
            if self.n_entries > columns.len() {
                let found = format!("{} entries of {} columns without NCOL", self.n_entries, columns.len());
                return Err(Error::Malformed {
                    file: origin.file.into(),
                    place: (origin.place)(self.at),
                    found,
                    expected: "NCOL, or one entry for each column".into(),
                });
            }
            for term in &mut self.terms {
                term.column = columns.partition_point(|column| *column < term.column);
            }
            return Ok(columns.len());
        };
        for term in &mut self.terms {
            let point = term.column / (COMPONENTS + 1);
            if point > stated {
                return Err(Error::OutOfRange {
                    file: origin.file.into(),
                    place: (origin.place)(term.at),
                    what: "column",
                    index: point as i128,
                    first: 1,
                    last: stated,
                });
            }
            term.column = point - 1;
        }
        Ok(stated)
    }
}

/// A point and its component as one number, which ascends with both.
fn key(line: Line<'_>, point: &[u8], component: &[u8]) -> Result<usize, Error> {
    let component = match component {
        b"" => 0,
        given => line.integer(given, "a component")?,
    };
    if component > COMPONENTS {
        return Err(line.malformed(format!("component {component}"), "a component from 0 to 6"));
    }
    let number: usize = line.integer(point, "a point")?;
    point_key(number, component).ok_or_else(|| line.malformed(quoted(point), "the positive number of a point"))
}

/// The same of numbers; none for what no point can be.
pub(crate) fn point_key(point: usize, component: usize) -> Option<usize> {
    let key = point.checked_mul(COMPONENTS + 1)?.checked_add(component)?;
    (point > 0 && component <= COMPONENTS).then_some(key)
}

/// Refuses complex matrices.
fn precision(line: Line<'_>, field: &[u8]) -> Result<(), Error> {
    match line.integer(field, "a type from 1 to 4")? {
        1_u32 | 2 => Ok(()),
        3 | 4 => Err(line.unsupported("a complex matrix", "write its real part (TIN and TOUT 1 or 2)")),
        kind => Err(line.malformed(format!("type {kind}"), "a type from 1 to 4")),
    }
}
