//! Matrices that CalculiX stores with `*FREQUENCY, SOLVER=MATRIXSTORAGE`.
//!
//! `job.sti` and `job.mas` hold the stiffness and the mass as lines `row column value`, counted from one, the upper
//! triangle with the diagonal; `job.dof` has a line `node.direction` for each row (manual of CalculiX CrunchiX,
//! `*FREQUENCY`; checked against version 2.20). Fixed and dependent components do not occur.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::text;
use crate::triplets::{self, Entry, Origin};
use crate::value::{Assembled, Dof, plausible};
use file_io::{Place, Source, quoted};

/// The three files of a job.
#[derive(Clone, Copy, Debug)]
pub struct Files<'a> {
    /// `job.sti`.
    pub stiffness: Source<'a>,
    /// `job.mas`.
    pub mass: Source<'a>,
    /// `job.dof`.
    pub dofs: Source<'a>,
}

/// The `.sti`, `.mas` and `.dof` of a job; `path` is any of them, or their common name without extension.
#[must_use]
pub fn files(path: &Path) -> [PathBuf; 3] {
    let known = |e: &std::ffi::OsStr| ["sti", "mas", "dof"].iter().any(|k| e.eq_ignore_ascii_case(k));
    let job = if path.extension().is_some_and(known) {
        path.with_extension("")
    } else {
        path.to_owned()
    };
    // Appended, because the name of a job may contain dots.
    let beside = |extension: &str| {
        let mut name = job.clone().into_os_string();
        name.push(extension);
        PathBuf::from(name)
    };
    [".sti", ".mas", ".dof"].map(beside)
}

/// Reads the three files that lie beside one another; `path` is any of them, or their common name without extension.
///
/// # Errors
/// [`Error::NoDofMap`] if there is no `.dof`, [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Assembled, Error> {
    let [sti, mas, dof] = files(path);
    if !dof.exists() {
        return Err(Error::NoDofMap {
            file: sti.to_string_lossy().into_owned(),
            missing: format!("the file {}", dof.display()),
            remedy: "copy it here too: CalculiX writes it beside the matrices",
        });
    }
    let names = [&sti, &mas, &dof].map(|path| path.to_string_lossy());
    let bytes = [text::load(&sti)?, text::load(&mas)?, text::load(&dof)?];
    let source = |i: usize| Source {
        name: &names[i],
        bytes: &bytes[i],
    };
    parse(Files {
        stiffness: source(0),
        mass: source(1),
        dofs: source(2),
    })
}

/// Reads [`Assembled::STIFFNESS`] and [`Assembled::MASS`].
///
/// # Errors
/// [`Error::NoDofMap`] for an empty list of components, [`Error::Malformed`], [`Error::OutOfRange`],
/// [`Error::NotFinite`], [`Error::Duplicate`], [`Error::Asymmetric`], [`Error::Oversized`].
pub fn parse(files: Files<'_>) -> Result<Assembled, Error> {
    let dofs = dofs(files.dofs)?;
    let mut matrices = BTreeMap::new();
    for (name, source) in [(Assembled::STIFFNESS, files.stiffness), (Assembled::MASS, files.mass)] {
        matrices.insert(name.to_owned(), matrix(source, dofs.len())?);
    }
    Ok(Assembled { dofs, matrices })
}

fn dofs(source: Source<'_>) -> Result<Vec<Dof>, Error> {
    const EXPECTED: &str = "`node.direction`";
    let mut dofs = Vec::new();
    let mut seen = std::collections::HashSet::new();
    for line in text::lines(source).filter(|line| !line.text.is_empty()) {
        let point = line.text.iter().position(|b| *b == b'.');
        let point = point.ok_or_else(|| line.malformed(quoted(line.text), EXPECTED))?;
        let label: i64 = line.integer(&line.text[..point], EXPECTED)?;
        let dof = Dof::new(label, line.integer(&line.text[point + 1..], EXPECTED)?);
        if label < 1 || !seen.insert(dof) {
            return Err(line.malformed(quoted(line.text), "each component of each node once"));
        }
        dofs.push(dof);
    }
    if dofs.is_empty() {
        return Err(Error::NoDofMap {
            file: source.name.into(),
            missing: "every line `node.direction`".into(),
            remedy: "run CalculiX again and look for the message that it stores the file",
        });
    }
    Ok(dofs)
}

fn matrix(source: Source<'_>, size: usize) -> Result<sprs::CsMat<f64>, Error> {
    plausible(size, size, source.bytes.len()).map_err(|(stated, possible)| Error::Oversized {
        file: source.name.into(),
        place: Place::Line(1),
        what: "the number of rows",
        stated: stated as u128,
        possible,
    })?;
    let mut entries = Vec::new();
    for line in text::lines(source).filter(|line| !line.text.is_empty()) {
        let [row, column, value] = line.fields("row, column and value")?;
        entries.push(Entry {
            row: line.index(row, "row", size)?,
            column: line.index(column, "column", size)?,
            value: line.real(value)?,
            at: line.number,
        });
    }
    triplets::symmetric(Origin::lines(source.name), size, entries, true)
}
