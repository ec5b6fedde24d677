//! Writing of substructures.

use std::fmt::Write as _;

use super::substructure::{Recovery, Substructure, parse_substructure};
use crate::value::{Dense, Dof};
use crate::{Error, writing};
use file_io::Source;

/// The file of a substructure, in the order in which Abaqus writes: stiffness, loads, other matrices, recovery.
///
/// # Errors
/// [`Error::Unwritable`] for matrices that are not symmetric, sizes that differ, entries that are not finite, and names
/// that the layout has no room for.
pub fn substructure_to_bytes(substructure: &Substructure) -> Result<Vec<u8>, Error> {
    let size = substructure.dofs.len();
    let nodes: Vec<&[Dof]> = substructure
        .dofs
        .chunk_by(|a, b| a.label() == b.label() && a.component() < b.component())
        .collect();
    let mut out = String::from("**\n** SUBSTRUCTURE MATRICES\n");
    write_element(&mut out, &nodes);
    let (first, others): (Vec<_>, Vec<_>) = substructure.matrices.iter().partition(|(kind, _)| *kind == "STIFFNESS");
    for (kind, matrix) in first {
        write_matrix(&mut out, size, kind, matrix)?;
    }
    for (name, load) in &substructure.loads {
        check_shape(size, name, [load.len(), 1], load.len() == size)?;
        write_load(&mut out, &nodes, name, load);
    }
    for (kind, matrix) in others {
        write_matrix(&mut out, size, kind, matrix)?;
    }
    if let Some(recovery) = &substructure.recovery {
        write_recovery(&mut out, size, recovery)?;
    }
    // Names could hold what reads as something else, so the file must prove itself.
    let bytes = out.into_bytes();
    let name = "substructure";
    let reason = match parse_substructure(Source { name, bytes: &bytes }) {
        Ok(read) if read.same_content(substructure) => return Ok(bytes),
        Ok(_) => "it would not be read back as it is".into(),
        Err(error) => error.to_string(),
    };
    Err(writing::unwritable(
        name,
        reason,
        "use finite numbers, each component once, and short names in capitals",
    ))
}

/// Refuses what does not fit the `size` degrees of freedom.
fn check_shape(size: usize, name: &str, [rows, columns]: [usize; 2], fits: bool) -> Result<(), Error> {
    if fits {
        return Ok(());
    }
    Err(writing::unwritable(
        name,
        format!("it has {rows} rows and {columns} columns for {size} degrees of freedom"),
        "give all matrices over the same degrees of freedom",
    ))
}

/// Labels of the nodes, and their components where these change. Writing into a string cannot fail, here and below.
fn write_element(out: &mut String, nodes: &[&[Dof]]) {
    let _ = writeln!(out, "*USER ELEMENT,NODES={:>11},LINEAR\n** ELEMENT NODES", nodes.len());
    for labels in nodes.chunks(10) {
        let listed: String = labels.iter().map(|node| format!("{:>10},", node[0].label())).collect();
        let _ = writeln!(out, "**{listed}");
    }
    let mut before: Vec<u32> = Vec::new();
    for (node, position) in nodes.iter().zip(1..) {
        let components: Vec<u32> = node.iter().map(Dof::component).collect();
        if components != before {
            let listed: Vec<String> = components.iter().map(u32::to_string).collect();
            let position = if position == 1 {
                String::new()
            } else {
                format!("{position}, ")
            };
            let _ = writeln!(out, " {position}{}", listed.join(", "));
        }
        before = components;
    }
}

fn write_matrix(out: &mut String, size: usize, kind: &str, m: &Dense<f64>) -> Result<(), Error> {
    let shape = [m.rows(), m.columns()];
    check_shape(size, kind, shape, shape == [size, size])?;
    if (0..size).any(|j| (0..j).any(|i| m[(i, j)] != m[(j, i)])) {
        return Err(writing::unwritable(
            kind,
            "it is not symmetric",
            "this file holds symmetric matrices only",
        ));
    }
    let _ = writeln!(out, "*MATRIX,TYPE={kind}");
    for i in 0..size {
        write_numbers(out, " ", (0..=i).map(|j| m[(i, j)]));
    }
    Ok(())
}

fn write_load(out: &mut String, nodes: &[&[Dof]], name: &str, load: &[f64]) {
    let _ = writeln!(out, "** SUBSTRUCTURE LOAD CASE VECTOR. SLOAD CASE {name}\n***CLOAD");
    let places = nodes
        .iter()
        .zip(1..)
        .flat_map(|(node, position)| node.iter().map(move |dof| (position, dof)));
    for ((position, dof), value) in places.zip(load) {
        let _ = writeln!(out, "** {position}, {}, {value:E}", dof.component());
    }
    out.push_str("**\n");
}

fn write_recovery(out: &mut String, size: usize, Recovery { matrix, heading }: &Recovery) -> Result<(), Error> {
    check_shape(
        size,
        "recovery matrix",
        [matrix.rows(), matrix.columns()],
        matrix.columns() == size && matrix.rows() > 0,
    )?;
    out.push_str("** RECOVERY MATRIX\n");
    for line in heading {
        let _ = writeln!(out, "{line}");
    }
    for (column, number) in matrix.data().chunks(matrix.rows()).zip(1..) {
        let _ = writeln!(
            out,
            "** SUBSTRUCTURE RECOVERY VECTOR CORRESPONDING TO RETAINED DOFS NUMBER {number}"
        );
        write_numbers(out, "** ", column.iter().copied());
    }
    Ok(())
}

impl Substructure {
    fn same_content(&self, other: &Self) -> bool {
        self.dofs == other.dofs
            && self.matrices == other.matrices
            && self.loads == other.loads
            && self.recovery == other.recovery
    }
}

/// Numbers four to a line.
fn write_numbers(out: &mut String, start: &str, numbers: impl Iterator<Item = f64>) {
    for (i, number) in numbers.enumerate() {
        let before = match i % 4 {
            0 if i > 0 => "\n",
            0 => "",
            _ => " ",
        };
        let start = if i % 4 == 0 { start } else { "" };
        let _ = write!(out, "{before}{start}{number:E},");
    }
    out.push('\n');
}
