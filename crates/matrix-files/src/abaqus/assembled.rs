//! Assembled matrices of one model.

use std::collections::{BTreeMap, BTreeSet};

use sprs::CsMat;

use crate::Error;
use crate::text;
use crate::triplets::{self, Entry, Origin};
use crate::value::{Assembled, Dof};
use file_io::{Place, Source, quoted};

/// Reads assembled matrices from the files of one model, each under a name of the caller's, as `*MATRIX OUTPUT` writes
/// them in its formats `MATRIX INPUT` and `LABELS`.
///
/// The degrees of freedom are those that occur in any of the files, nodes first, in ascending order. A matrix is
/// given as one triangle or as both with equal values.
///
/// # Errors
/// [`Error::NoDofMap`] for the format `COORDINATE` (`row, column, value`) and for files without entries,
/// [`Error::Malformed`], [`Error::Unsupported`] for unsymmetric matrices, [`Error::NotFinite`], [`Error::Duplicate`],
/// [`Error::Asymmetric`].
pub fn parse_assembled(sources: &[(&str, Source<'_>)]) -> Result<Assembled, Error> {
    let mut files = Vec::new();
    let mut found = BTreeSet::new();
    for (name, source) in sources {
        let terms = terms(*source)?;
        found.extend(terms.iter().flat_map(|term| [term.row, term.column]));
        files.push((*name, source.name, terms));
    }
    let dofs: Vec<Dof> = found.into_iter().collect();
    // Every degree of freedom comes from the list.
    let place = |dof: Dof| dofs.partition_point(|d| *d < dof);
    let mut matrices = BTreeMap::new();
    for (name, file, terms) in files {
        let entries = terms.iter().map(|term| Entry {
            row: place(term.row),
            column: place(term.column),
            value: term.value,
            at: term.line,
        });
        let matrix: CsMat<f64> = triplets::symmetric(Origin::lines(file), dofs.len(), entries.collect(), true)?;
        if matrices.insert(name.to_owned(), matrix).is_some() {
            return Err(Error::Malformed {
                file: file.into(),
                place: Place::Line(1),
                found: format!("a second matrix called `{name}`"),
                expected: "a name for each file".into(),
            });
        }
    }
    Ok(Assembled { dofs, matrices })
}

struct Term {
    row: Dof,
    column: Dof,
    value: f64,
    line: usize,
}

fn terms(source: Source<'_>) -> Result<Vec<Term>, Error> {
    const EXPECTED: &str = "node, component, node, component and value";
    let mut terms = Vec::new();
    for line in text::lines(source) {
        if line.text.is_empty() || line.text.starts_with(b"**") {
            continue;
        }
        if line.text.starts_with(b"*") {
            let keyword = line.text.to_ascii_uppercase();
            if !keyword.starts_with(b"*MATRIX") {
                return Err(line.malformed(quoted(line.text), "*MATRIX or a comment"));
            }
            if keyword.windows(6).any(|w| w == b"UNSYMM") {
                return Err(line.unsupported("an unsymmetric matrix", "write symmetric ones"));
            }
            continue;
        }
        if line.tokens().take(4).count() == 3 && terms.is_empty() {
            return Err(Error::NoDofMap {
                file: source.name.into(),
                missing: format!(
                    "the node and component of each entry (line {} has three numbers)",
                    line.number
                ),
                remedy: "write the matrix with *MATRIX OUTPUT, FORMAT=MATRIX INPUT",
            });
        }
        let [node, component, other, other_component, value] = line.fields(EXPECTED)?;
        let dof = |label, component| {
            let label = line.integer(label, "a node label")?;
            Ok::<_, Error>(Dof::new(label, line.integer(component, "a component")?))
        };
        terms.push(Term {
            row: dof(node, component)?,
            column: dof(other, other_component)?,
            value: line.real(value)?,
            line: line.number,
        });
    }
    if terms.is_empty() {
        return Err(Error::NoDofMap {
            file: source.name.into(),
            missing: "every entry".into(),
            remedy: "check that the step with *MATRIX OUTPUT ran to its end",
        });
    }
    Ok(terms)
}
