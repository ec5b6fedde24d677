//! Matrices in the files that Nastran's module `OUTPUT2` writes (`.op2`), beside results and tables.
//!
//! Layout: *MSC Nastran DMAP Programmer's Guide*, module `OUTPUT2` and data block `MATPOOL`. A file consists of Fortran
//! records. Keys, records of one word, stand between them. A block has a name, seven words that describe it (of matrices: number,
//! columns, rows, form, type, words in use, density), and logical records. Each of these begins with the keys 1 and its
//! kind (0 in tables, 1 for a column of a matrix), goes on with parts, each after a positive key, and ends with a negative
//! key; the key 0 in the place of the first part ends the block. A part of a column is a row and entries from there on.
//!
//! `EXTSEOUT(DMIGOP2)` writes the matrices of an external superelement as tables of entries `DMIG`: a logical record
//! with the words 114, 1, 120, name (two words), 0, `IFO`, `TIN`, `TOUT`, `POLAR`, 0, `NCOL`, and for each column its
//! point and component, then point, component and value for each row, then -1, -1; the matrix ends with -1, -1, and
//! another may follow. Where all blocks are named `EXTDB`, and so are their matrices, the names are in the block `XSOP2DIR`
//! ahead: `MATK`, `MATM` and so on.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use crate::columns::{Columns, Position, text_of};
use crate::dmig::{self, FORMS, FORMS_TO_WRITE, Matrix, PointMatrices};
use crate::fortran::Records;
use crate::triplets::{Entry, Origin};
use crate::value::{Array, Collection, Skipped};
use crate::{Error, writing};
use file_io::{Place, Source};

/// The block that names those after it, and the name that these have instead.
const DIRECTORY: &str = "XSOP2DIR";
const EXTERNAL: &str = "EXTDB";

/// The words that begin a table of entries `DMIG`.
const DMIG: [i64; 3] = [114, 1, 120];

/// What a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Matrices by the names of their blocks; all other blocks are skipped.
    pub arrays: Collection,
    /// Matrices that are tables of entries `DMIG`, by the names in them.
    pub points: PointMatrices,
}

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Contents, Error> {
    crate::text::read(path, parse)
}

/// Reads all matrices, in either byte order, with words of 32 or 64 bits, in single and double precision. Matrices come
/// as [`crate::op4::parse`] gives them, tables `DMIG` as [`crate::dmig::parse`] does.
///
/// Other tables, complex matrices, forms that are not read, and names that several blocks have are listed as skipped.
///
/// # Errors
/// [`Error::Malformed`], [`Error::Oversized`], [`Error::OutOfRange`], [`Error::NotFinite`]; [`Error::Unsupported`] for
/// files with text in the place of records; of tables `DMIG` also [`Error::Duplicate`] and [`Error::Asymmetric`].
pub fn parse(source: Source<'_>) -> Result<Contents, Error> {
    let Some(records) = Records::detect(source, 1) else {
        return Err(Error::Unsupported {
            file: source.name.into(),
            place: Place::Byte(0),
            found: "a file that begins with no key of `OUTPUT2`".into(),
            remedy: "write it in binary form",
        });
    };
    let mut reader = Reader {
        source,
        records,
        stated: 0,
        matrices: BTreeMap::new(),
        skipped: Vec::new(),
        points: Vec::new(),
        directory: VecDeque::new(),
    };
    reader.file()?;
    let mut arrays = Collection::default();
    for (name, matrix) in std::mem::take(&mut reader.matrices) {
        match matrix {
            Some(matrix) => {
                arrays.arrays.insert(name, matrix);
            }
            None => reader.skip(name, "several blocks have this name"),
        }
    }
    arrays.skipped = reader.skipped;
    let points = reader.points;
    let origin = Origin {
        file: source.name,
        place: Place::Byte,
    };
    let points = dmig::assemble(origin, source.bytes.len(), points, Vec::new())?;
    Ok(Contents { arrays, points })
}

struct Reader<'a> {
    source: Source<'a>,
    records: Records<'a>,
    /// Rows or columns of all matrices so far.
    stated: usize,
    /// By the names of their blocks; none where several have one.
    matrices: BTreeMap<String, Option<Array>>,
    skipped: Vec<Skipped>,
    points: Vec<(String, Matrix)>,
    /// Names of the blocks that come next.
    directory: VecDeque<String>,
}

impl Reader<'_> {
    fn file(&mut self) -> Result<(), Error> {
        let mut is_first = true;
        while !self.records.is_at_end() {
            match self.key()? {
                // The date and names of the file.
                3 if is_first => {
                    self.skip_record()?;
                    self.skip_until(-1)?;
                    self.keys(&[0])?;
                }
                0 => {}
                key if key > 0 => self.block()?,
                key => return Err(self.records.malformed(format!("the key {key}"), "the name of a block")),
            }
            is_first = false;
        }
        Ok(())
    }

    fn block(&mut self) -> Result<(), Error> {
        let own = self.name()?;
        let listed = self.directory.pop_front().filter(|_| own == EXTERNAL);
        let is_listed = listed.is_some();
        let name = listed.unwrap_or(own);
        // The version of the program, in newer files.
        self.skip_until(-1)?;
        self.key()?;
        self.records.begin()?;
        let mut description = [0; 7];
        for word in &mut description {
            *word = self.records.integer()?;
        }
        self.records.finish()?;
        self.keys(&[-2, 1, 0])?;
        self.skip_until(-3)?;
        let (mut is_first, mut has_points) = (true, false);
        while let Some((kind, is_open)) = self.logical_record()? {
            if is_first && kind == 1 {
                return self.matrix(name, description, is_open);
            }
            is_first = false;
            if is_open && name == DIRECTORY {
                self.directory.push_back(text_of(self.records.rest()));
                self.pass_over()?;
            } else if is_open {
                has_points |= self.table(&name, is_listed)?;
            }
        }
        if !has_points {
            self.skip(name, "a table");
        }
        Ok(())
    }

    /// The columns of a matrix, of which the first has begun.
    fn matrix(&mut self, name: String, description: [i64; 7], mut is_open: bool) -> Result<(), Error> {
        let start = self.records.at;
        let [_, columns, rows, form, kind, ..] = description;
        // Others are complex, and passed over.
        let is_real = matches!(kind, 1 | 2);
        let real = if is_real { kind } else { 1 };
        let header = self.records.head([columns, rows, form, real], name.as_bytes())?;
        self.stated = self.stated.saturating_add(header.rows.max(header.columns));
        let bytes = self.source.bytes.len();
        self.records
            .check_size("the number of rows or columns", self.stated, bytes)?;
        let size = if header.is_double { 8 } else { self.records.word };
        let mut found = Columns::new(false);
        loop {
            if found.next() > header.columns {
                return Err(self.records.out_of_range("column", found.next(), header.columns));
            }
            while is_open {
                if !is_real {
                    self.records.at = self.records.end;
                } else {
                    let stated = self.records.integer()?;
                    let row = usize::try_from(stated).map_err(|_| self.records.malformed(stated, "a row"))?;
                    let count = self.records.rest().len() / size;
                    let rows = found.string(&self.records, &header, row, count)?;
                    self.records.numbers(count, header.is_double, &mut found.values)?;
                    found.rows.extend(rows);
                }
                is_open = self.next_part()?;
            }
            found.skip_to(found.next() + 1);
            match self.logical_record()? {
                Some((1, open)) => is_open = open,
                Some((kind, _)) => return Err(self.records.malformed(format!("a record of kind {kind}"), "a column")),
                None => break,
            }
        }
        found.skip_to(header.columns + 1);
        if !is_real {
            self.skip(name, "a complex matrix");
            return Ok(());
        }
        found.is_sparse = found.has_gaps(header.rows);
        match found.array(&self.records, &header, self.records.at - start) {
            Ok(array) => {
                let is_first = !self.matrices.contains_key(&name);
                self.matrices.insert(name, is_first.then_some(array));
            }
            Err(Error::Unsupported { found, .. }) => self.skip(name, &found),
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn skip(&mut self, name: String, reason: &str) {
        let skipped = Skipped {
            name,
            reason: reason.to_owned(),
        };
        if !self.skipped.contains(&skipped) {
            self.skipped.push(skipped);
        }
    }

    /// The parts of a record of a table; whether they are entries `DMIG`.
    fn table(&mut self, name: &str, is_listed: bool) -> Result<bool, Error> {
        let mut is_dmig = self.records.rest().len() >= DMIG.len() * self.records.word;
        for expected in DMIG {
            is_dmig = is_dmig && self.records.integer()? == expected;
        }
        if is_dmig {
            loop {
                match self.entries(is_listed.then_some(name)) {
                    // Another matrix may follow.
                    Ok(()) if self.records.at < self.records.end || self.next_part()? => {}
                    Ok(()) => return Ok(true),
                    Err(Error::Unsupported { found, .. }) => break self.skip(name.to_owned(), &found),
                    Err(error) => return Err(error),
                }
            }
        }
        self.pass_over()?;
        Ok(is_dmig)
    }

    /// Passes over what is left of a logical record.
    fn pass_over(&mut self) -> Result<(), Error> {
        loop {
            self.records.at = self.records.end;
            if !self.next_part()? {
                return Ok(());
            }
        }
    }

    /// A matrix of a table, which follows the words [`DMIG`] or another one.
    fn entries(&mut self, listed: Option<&str>) -> Result<(), Error> {
        let at = self.records.at;
        let bytes = self.records.rest().get(..2 * self.records.word);
        let bytes = bytes.ok_or_else(|| self.records.malformed("the end of the record", "the name of a matrix"))?;
        let name = text_of(bytes);
        self.records.at += bytes.len();
        let mut words = [0; 7];
        for word in &mut words {
            *word = self.word()?;
        }
        let [_, form, kind, _, polar, _, n_columns] = words;
        let name = listed.unwrap_or(&name).to_ascii_uppercase();
        if !writing::is_nastran_name(&name) || self.points.iter().any(|(known, _)| *known == name) {
            let found = format!("the name `{}` of a matrix", name.escape_debug());
            return Err(self
                .records
                .malformed(found, "up to eight letters and digits, each name once"));
        }
        let form = u32::try_from(form).ok().filter(|form| FORMS.contains(form));
        let form = form.ok_or_else(|| {
            let found = format!("the form {} of the matrix `{name}`", words[1]);
            self.records.unsupported(found, FORMS_TO_WRITE)
        })?;
        if !matches!(kind, 1 | 2) || polar != 0 {
            let found = format!("the complex matrix `{name}`");
            return Err(self
                .records
                .unsupported(found, "write its real part (TIN and TOUT 1 or 2)"));
        }
        let mut matrix = Matrix {
            at,
            form: Some(form),
            n_columns: (form == 9).then_some(usize::try_from(n_columns).unwrap_or(0)),
            ..Matrix::default()
        };
        while let Some(column) = self.point(form == 9)? {
            matrix.columns.insert(column);
            matrix.n_entries += 1;
            while let Some(row) = self.point(false)? {
                let at = self.records.at;
                let value = self.number(kind == 2)?;
                matrix.terms.push(Entry { row, column, value, at });
            }
        }
        self.points.push((name, matrix));
        Ok(())
    }

    /// A point and its component, or the end of a list.
    fn point(&mut self, is_number: bool) -> Result<Option<usize>, Error> {
        let [point, component] = [self.word()?, self.word()?];
        if [point, component] == [-1, -1] {
            return Ok(None);
        }
        let key = match [usize::try_from(point), usize::try_from(component)] {
            [Ok(point), _] if is_number => dmig::point_key(point, 0),
            [Ok(point), Ok(component)] => dmig::point_key(point, component),
            _ => None,
        };
        let expected = "the positive number of a point, and a component from 0 to 6";
        key.map(Some).ok_or_else(|| {
            self.records
                .malformed(format!("point {point}, component {component}"), expected)
        })
    }

    /// The next word of a logical record, in this part or the next.
    fn word(&mut self) -> Result<i64, Error> {
        self.reach_part()?;
        self.records.integer()
    }

    fn number(&mut self, is_double: bool) -> Result<f64, Error> {
        self.reach_part()?;
        let mut value = Vec::with_capacity(1);
        self.records.numbers(1, is_double, &mut value)?;
        Ok(value[0])
    }

    fn reach_part(&mut self) -> Result<(), Error> {
        if self.records.at == self.records.end && !self.next_part()? {
            return Err(self.records.malformed("the end of a matrix", "-1, -1 ahead of it"));
        }
        Ok(())
    }

    /// Kind of the next logical record, and whether it has a part, which has begun; none at the end of the block.
    fn logical_record(&mut self) -> Result<Option<(i64, bool)>, Error> {
        self.keys(&[1])?;
        let kind = self.key()?;
        match self.key()? {
            0 => Ok(None),
            key if key < 0 => Ok(Some((kind, false))),
            _ => {
                self.records.begin()?;
                Ok(Some((kind, true)))
            }
        }
    }

    /// Leaves a part; whether another one has begun.
    fn next_part(&mut self) -> Result<bool, Error> {
        self.records.finish()?;
        let is_more = self.key()? > 0;
        if is_more {
            self.records.begin()?;
        }
        Ok(is_more)
    }

    fn key(&mut self) -> Result<i64, Error> {
        let length = self.records.begin()?;
        if length != self.records.word {
            let expected = format!("a key, of {} bytes", self.records.word);
            return Err(self.records.malformed(format!("a record of {length} bytes"), expected));
        }
        let key = self.records.integer()?;
        self.records.finish()?;
        Ok(key)
    }

    fn keys(&mut self, expected: &[i64]) -> Result<(), Error> {
        for expected in expected {
            let key = self.key()?;
            if key != *expected {
                return Err(self.records.malformed(format!("the key {key}"), format!("{expected}")));
            }
        }
        Ok(())
    }

    /// Passes over records after positive keys, up to the key `last`.
    fn skip_until(&mut self, last: i64) -> Result<(), Error> {
        loop {
            match self.key()? {
                key if key > 0 => self.skip_record()?,
                key if key == last => return Ok(()),
                key => return Err(self.records.malformed(format!("the key {key}"), format!("{last}"))),
            }
        }
    }

    fn skip_record(&mut self) -> Result<(), Error> {
        self.records.begin()?;
        self.records.at = self.records.end;
        self.records.finish()
    }

    /// The record with the name of a block.
    fn name(&mut self) -> Result<String, Error> {
        self.records.begin()?;
        let name = self.records.checked_name(self.records.rest())?;
        self.records.at = self.records.end;
        self.records.finish()?;
        Ok(name)
    }
}
