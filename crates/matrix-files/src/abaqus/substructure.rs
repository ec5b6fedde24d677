//! Matrices of one substructure.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use crate::Error;
use crate::text::{self, Line};
use crate::value::{Dense, Dof, Skipped};
use file_io::{Source, quoted};

/// A reduced substructure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Substructure {
    /// What rows and columns belong to; retained modes are [`Dof::Generalised`].
    pub dofs: Vec<Dof>,
    /// Symmetric matrices by their `TYPE`: `STIFFNESS`, `MASS` and others.
    pub matrices: BTreeMap<String, Dense<f64>>,
    /// Load vectors over [`Substructure::dofs`] by the name of their load case.
    pub loads: BTreeMap<String, Vec<f64>>,
    /// What recovers the motion of other points.
    pub recovery: Option<Recovery>,
    /// Sections that were not read.
    pub skipped: Vec<Skipped>,
}

/// `x_out = R x` with `x` over the retained degrees of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovery {
    /// `R`, with a column for each retained degree of freedom.
    pub matrix: Dense<f64>,
    /// The lines between `** RECOVERY MATRIX` and the first column, which tell what the rows are, as they stand: their
    /// layout is not documented.
    pub heading: Vec<String>,
}

/// Reads the substructure file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse_substructure`].
pub fn read_substructure(path: &Path) -> Result<Substructure, Error> {
    text::read(path, parse_substructure)
}

/// Reads the matrices of one substructure.
///
/// ```text
/// *USER ELEMENT,NODES=          3,LINEAR
/// ** ELEMENT NODES
/// **        11,        12,        -1,
///  1, 2, 3
///  3, 1
/// *MATRIX,TYPE=STIFFNESS
///  (lower triangle row by row)
/// ** SUBSTRUCTURE LOAD CASE VECTOR. SLOAD CASE (name)
/// ***CLOAD
/// ** 1, 3, (value)
/// *MATRIX,TYPE=MASS
///  (lower triangle row by row)
/// ** RECOVERY MATRIX
/// ** (lines on its rows)
/// ** SUBSTRUCTURE RECOVERY VECTOR CORRESPONDING TO RETAINED DOFS NUMBER 1
/// ** (entries of a column)
/// ```
///
/// The first list of components belongs to the first node; later lines begin with the position in the list of nodes
/// from which theirs apply. Loads refer to nodes by the same positions. Labels of retained modes are negative. A
/// section of another name is listed as skipped.
///
/// # Errors
/// [`Error::NoDofMap`] if node labels or components are missing, [`Error::Malformed`], [`Error::Unsupported`] for
/// unsymmetric or complex matrices and several elements, [`Error::Oversized`], [`Error::OutOfRange`],
/// [`Error::NotFinite`].
pub fn parse_substructure(source: Source<'_>) -> Result<Substructure, Error> {
    let mut reader = Reader {
        bytes: source.bytes.len(),
        section: Section::Preamble,
        n_nodes: None,
        labels: Vec::new(),
        components: Vec::new(),
        places: BTreeMap::new(),
        result: Substructure::default(),
        heading: None,
        columns: BTreeMap::new(),
    };
    let mut last = Line {
        file: source.name,
        number: 1,
        text: b"",
    };
    for line in text::lines(source) {
        last.number = line.number;
        if !line.text.is_empty() {
            reader.line(line)?;
        }
    }
    reader.finish(last)
}

/// What the lines being read belong to.
enum Section {
    /// Before the element is defined.
    Preamble,
    Labels,
    Components,
    Matrix(String, Vec<f64>),
    Load(String, Vec<Option<f64>>),
    RecoveryHeading,
    RecoveryColumn(usize, Vec<f64>),
    /// Listed as skipped; whether numbers came.
    Foreign(bool),
}

struct Reader {
    /// Size of the file.
    bytes: usize,
    section: Section,
    n_nodes: Option<usize>,
    labels: Vec<i64>,
    /// Lists of components, and the position of the first node to which each applies.
    components: Vec<(usize, Vec<u32>)>,
    /// Row by position of the node and component.
    places: BTreeMap<(usize, u32), usize>,
    result: Substructure,
    heading: Option<Vec<String>>,
    columns: BTreeMap<usize, Vec<f64>>,
}

impl Reader {
    fn line(&mut self, line: Line<'_>) -> Result<(), Error> {
        if let Some(comment) = line.text.strip_prefix(b"**") {
            self.comment(line, comment.trim_ascii())
        } else if let Some(heading) = self.heading_lines()
            && !line.text.to_ascii_uppercase().starts_with(b"*MATRIX")
        {
            heading.push(String::from_utf8_lossy(line.text).into_owned());
            Ok(())
        } else if line.text.starts_with(b"*") {
            self.keyword(line)
        } else {
            self.data(line)
        }
    }

    fn heading_lines(&mut self) -> Option<&mut Vec<String>> {
        matches!(self.section, Section::RecoveryHeading).then_some(self.heading.as_mut())?
    }

    fn keyword(&mut self, line: Line<'_>) -> Result<(), Error> {
        let keyword = String::from_utf8_lossy(&line.text[1..]).to_ascii_uppercase();
        let mut words = keyword.split(',').map(str::trim);
        let name = words.next().unwrap_or_default();
        let parameters: BTreeMap<&str, &str> = words
            .map(|word| {
                word.split_once('=')
                    .map_or((word, ""), |(key, value)| (key.trim(), value.trim()))
            })
            .collect();
        if parameters.contains_key("UNSYMM") {
            return Err(line.unsupported(
                "an unsymmetric matrix",
                "ask for symmetric matrices (UNSYMM=NO on *STEP)",
            ));
        }
        match name {
            "USER ELEMENT" if self.n_nodes.is_some() => Err(line.unsupported(
                "a second element in the same file",
                "write one substructure per file with *SUBSTRUCTURE MATRIX OUTPUT",
            )),
            "USER ELEMENT" => {
                let nodes = parameters.get("NODES").copied().unwrap_or_default();
                self.n_nodes = Some(line.integer(nodes.as_bytes(), "NODES= and the number of nodes")?);
                Ok(())
            }
            "MATRIX" => {
                self.close(line)?;
                self.number_dofs(line)?;
                let kind = parameters.get("TYPE").copied().unwrap_or_default();
                if kind.is_empty() || self.result.matrices.contains_key(kind) {
                    return Err(line.malformed(quoted(line.text), "TYPE= and a type that was not given before"));
                }
                self.section = Section::Matrix(kind.into(), Vec::new());
                Ok(())
            }
            _ => Err(line.malformed(quoted(line.text), "*USER ELEMENT, *MATRIX or a comment")),
        }
    }

    fn comment(&mut self, line: Line<'_>, comment: &[u8]) -> Result<(), Error> {
        const LOAD: &str = "SUBSTRUCTURE LOAD CASE VECTOR";
        const CASE: &[u8] = b"SLOAD CASE";
        let upper = String::from_utf8_lossy(comment).to_ascii_uppercase();
        if upper == "ELEMENT NODES" && matches!(self.section, Section::Preamble) && self.n_nodes.is_some() {
            self.section = Section::Labels;
        } else if upper.starts_with(LOAD) {
            self.close(line)?;
            self.number_dofs(line)?;
            let rest = &comment[LOAD.len()..];
            let case = rest
                .windows(CASE.len())
                .position(|word| word.eq_ignore_ascii_case(CASE));
            let name = String::from_utf8_lossy(&rest[case.map_or(0, |at| at + CASE.len())..]);
            let name = name.trim_matches([' ', '\t', '.']);
            if self.result.loads.contains_key(name) {
                return Err(line.malformed(quoted(line.text), "a load case that was not given before"));
            }
            let size = self.result.dofs.len();
            // All load cases together stay within the size of the file, which lists each of their entries.
            let stated = (self.result.loads.len() + 1) * size;
            if stated > self.bytes.max(size) {
                return Err(line.oversized("the number of entries of all load cases", stated as u128, self.bytes));
            }
            self.section = Section::Load(name.into(), vec![None; size]);
        } else if upper.starts_with("SUBSTRUCTURE RECOVERY VECTOR") {
            self.close(line)?;
            self.number_dofs(line)?;
            let number = upper
                .rsplit(|c: char| c.is_ascii_whitespace() || c == '=')
                .next()
                .unwrap_or_default();
            let column = line.index(number.as_bytes(), "retained degree of freedom", self.result.dofs.len())?;
            if self.columns.contains_key(&column) {
                return Err(line.malformed(quoted(line.text), "each retained degree of freedom once"));
            }
            self.section = Section::RecoveryColumn(column, Vec::new());
        } else if upper.starts_with("RECOVERY MATRIX") && self.heading.is_none() {
            self.close(line)?;
            self.heading = Some(Vec::new());
            self.section = Section::RecoveryHeading;
        } else if let Some(heading) = self.heading_lines() {
            heading.push(String::from_utf8_lossy(line.text).into_owned());
        } else if upper.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
            return self.commented_numbers(Line { text: comment, ..line });
        } else if let Some(keyword) = upper.strip_prefix('*') {
            // `***CLOAD`: a keyword made a comment.
            if !matches!(self.section, Section::Load(..)) || !keyword.trim().starts_with("CLOAD") {
                return self.foreign(line, &upper);
            }
            if keyword.contains("IMAG") {
                return Err(line.unsupported("an imaginary load", "write real loads"));
            }
        } else if !upper.is_empty() {
            return self.foreign(line, &upper);
        }
        Ok(())
    }

    /// A heading that is not known. Before the matrices it is a remark, later it would have been data.
    fn foreign(&mut self, line: Line<'_>, heading: &str) -> Result<(), Error> {
        let new = match self.section {
            Section::Preamble | Section::Labels | Section::Components | Section::Foreign(false) => false,
            Section::Foreign(true) => true,
            _ => {
                self.close(line)?;
                true
            }
        };
        if new {
            self.section = Section::Foreign(false);
            self.result.skipped.push(Skipped {
                name: heading.to_owned(),
                reason: format!("the section of line {} is of no known kind", line.number),
            });
        }
        Ok(())
    }

    fn commented_numbers(&mut self, line: Line<'_>) -> Result<(), Error> {
        match &mut self.section {
            Section::Labels => {
                for token in line.tokens() {
                    self.labels.push(line.integer(token, "a node label")?);
                }
            }
            Section::Load(_, values) => {
                let [node, component, value] = line.fields("position of the node, component and load")?;
                let node = line.index(node, "position of the node", self.labels.len())?;
                let component = line.integer(component, "a component")?;
                let row = self.places.get(&(node, component)).copied();
                let row = row.ok_or_else(|| line.malformed(quoted(line.text), "a retained degree of freedom"))?;
                if values[row].replace(line.real(value)?).is_some() {
                    return Err(line.malformed(quoted(line.text), "each retained degree of freedom once"));
                }
            }
            Section::RecoveryColumn(_, values) => {
                for token in line.tokens() {
                    values.push(line.real(token)?);
                }
            }
            Section::Foreign(numbers) => *numbers = true,
            // A remark that begins with a number.
            Section::Preamble | Section::Components => {}
            Section::Matrix(..) | Section::RecoveryHeading => {
                return Err(line.malformed(quoted(line.text), "the entries of the matrix without `**`"));
            }
        }
        Ok(())
    }

    fn data(&mut self, line: Line<'_>) -> Result<(), Error> {
        if matches!(self.section, Section::Labels)
            || self.n_nodes.is_some() && matches!(self.section, Section::Preamble)
        {
            self.section = Section::Components;
        }
        match &mut self.section {
            Section::Components => {
                if self.labels.is_empty() {
                    return Err(missing(line, "the list of nodes after `** ELEMENT NODES`"));
                }
                let mut tokens = line.tokens();
                let from = match self.components.last() {
                    None => 0,
                    Some((last, _)) => {
                        let token = tokens.next().unwrap_or_default();
                        let from = line.index(token, "position of the node", self.labels.len())?;
                        if from <= *last {
                            return Err(line.malformed(quoted(line.text), "a node after that of the line before"));
                        }
                        from
                    }
                };
                let components: Vec<u32> = tokens
                    .map(|token| line.integer(token, "a component"))
                    .collect::<Result<_, _>>()?;
                if components.is_empty() || components.iter().collect::<HashSet<_>>().len() < components.len() {
                    return Err(line.malformed(quoted(line.text), "components, each once"));
                }
                self.components.push((from, components));
            }
            Section::Matrix(_, values) => {
                let expected = triangle(self.result.dofs.len());
                for token in line.tokens() {
                    if values.len() == expected {
                        return Err(line.malformed("more entries", format!("the end after {expected} entries")));
                    }
                    values.push(line.real(token)?);
                }
            }
            Section::Foreign(numbers) => *numbers = true,
            Section::Preamble => {
                return Err(line.malformed(
                    quoted(line.text),
                    "*USER ELEMENT first (files of *MATRIX OUTPUT are read by another function)",
                ));
            }
            _ => return Err(line.malformed(quoted(line.text), "a comment or *MATRIX")),
        }
        Ok(())
    }

    /// Ends the section before `line`.
    fn close(&mut self, line: Line<'_>) -> Result<(), Error> {
        match std::mem::replace(&mut self.section, Section::Foreign(true)) {
            Section::Matrix(kind, values) => {
                let size = self.result.dofs.len();
                let (found, expected) = (values.len(), triangle(size));
                if found != expected {
                    return Err(line.malformed(
                        format!("{found} entries of the {kind}"),
                        format!("{expected}, the lower triangle of {size} rows"),
                    ));
                }
                let mut full = vec![0.0; size * size];
                let places = (0..size).flat_map(|i| (0..=i).map(move |j| (i, j)));
                for ((i, j), value) in places.zip(values) {
                    full[i + j * size] = value;
                    full[j + i * size] = value;
                }
                self.result.matrices.insert(kind, Dense::try_new(size, size, full)?);
            }
            Section::Load(name, values) => {
                self.result
                    .loads
                    .insert(name, values.into_iter().map(Option::unwrap_or_default).collect());
            }
            Section::RecoveryColumn(column, values) => {
                let rows = self.columns.values().next().map_or(values.len(), Vec::len);
                if values.len() != rows || rows == 0 {
                    let found = format!("{} entries in column {}", values.len(), column + 1);
                    return Err(line.malformed(found, "as many in all columns of the recovery matrix"));
                }
                self.columns.insert(column, values);
            }
            _ => {}
        }
        Ok(())
    }

    /// Lists the degrees of freedom, once.
    fn number_dofs(&mut self, line: Line<'_>) -> Result<(), Error> {
        if !self.result.dofs.is_empty() {
            return Ok(());
        }
        let n_nodes = self
            .n_nodes
            .ok_or_else(|| missing(line, "*USER ELEMENT with the number of nodes"))?;
        if self.components.is_empty() {
            return Err(missing(line, "the list of components after the list of nodes"));
        }
        if self.labels.len() != n_nodes {
            let found = format!("{} node labels", self.labels.len());
            return Err(line.malformed(found, format!("{n_nodes}, as *USER ELEMENT states")));
        }
        let ends = self.components[1..].iter().map(|(from, _)| *from).chain([n_nodes]);
        let runs: Vec<(usize, usize, &[u32])> = self
            .components
            .iter()
            .zip(ends)
            .map(|((from, list), end)| (*from, end, &list[..]))
            .collect();
        let size: usize = runs.iter().map(|(from, end, list)| (end - from) * list.len()).sum();
        // A matrix has at least a digit and a separator for each entry of its triangle.
        let possible = self.bytes.isqrt();
        if size > possible {
            return Err(line.oversized("the number of degrees of freedom", size as u128, possible));
        }
        let mut seen = HashSet::new();
        for (from, end, list) in runs {
            for node in from..end {
                for &component in list {
                    let dof = Dof::new(self.labels[node], component);
                    // Internal variables without a label of their own are all called 0.
                    if !seen.insert(dof) && dof.label() != 0 {
                        let found = format!("component {component} of node {} twice", dof.label());
                        return Err(line.malformed(found, "each component of each node once"));
                    }
                    self.places.insert((node, component), self.result.dofs.len());
                    self.result.dofs.push(dof);
                }
            }
        }
        Ok(())
    }

    fn finish(mut self, end: Line<'_>) -> Result<Substructure, Error> {
        self.close(end)?;
        if self.result.matrices.is_empty() {
            return Err(end.malformed("the end of the file", "*MATRIX, TYPE=STIFFNESS or another type"));
        }
        if self.heading.is_some() || !self.columns.is_empty() {
            let (found, expected) = (self.columns.len(), self.result.dofs.len());
            if found != expected {
                return Err(end.malformed(format!("{found} columns of the recovery matrix"), expected));
            }
            let rows = self.columns.values().next().map_or(0, Vec::len);
            let data = self.columns.into_values().flatten().collect();
            self.result.recovery = Some(Recovery {
                matrix: Dense::try_new(rows, expected, data)?,
                heading: self.heading.unwrap_or_default(),
            });
        }
        Ok(self.result)
    }
}

fn missing(line: Line<'_>, what: &str) -> Error {
    Error::NoDofMap {
        file: line.file.into(),
        missing: format!("{what} before line {}", line.number),
        remedy: "keep the whole file as *SUBSTRUCTURE MATRIX OUTPUT wrote it",
    }
}

/// Number of entries of a triangle with the diagonal.
fn triangle(size: usize) -> usize {
    size * (size + 1) / 2
}
