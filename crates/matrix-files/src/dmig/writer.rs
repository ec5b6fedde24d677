//! Writing.

use std::fmt::Write as _;

use sprs::CsMat;

use super::PointMatrices;
use crate::value::Dof;
use crate::{Error, writing};

/// Highest number of a point.
const HIGHEST: u64 = 99_999_999;

/// Characters of a number.
const WIDTH: usize = 16;

/// A file with `about` as comments, and the matrices in double precision (`TIN` 2) with fields of 16 characters:
/// those that are exactly symmetric as such (`IFO` 6), other square ones as such (`IFO` 1), numbered columns as `IFO` 9.
///
/// Numbers that need more than 16 characters are rounded to what these hold, 9 to 13 digits. Zeros are written where they are stored.
///
/// # Errors
/// [`Error::Unwritable`] for names that Nastran does not allow or that occur twice, entries that are not finite, matrices
/// that do not fit the degrees of freedom, and degrees of freedom that are no components 0 to 6 of points up to
/// 99999999, occur twice or have no entry in any matrix.
pub fn to_bytes(model: &PointMatrices, about: &str) -> Result<Vec<u8>, Error> {
    let mut out = String::new();
    for line in about.lines() {
        // Writing into a string cannot fail, here and below.
        let _ = writeln!(out, "$ {line}");
    }
    let points = points(&model.dofs)?;
    let mut has_entry = vec![false; points.len()];
    for (name, m) in &model.matrices {
        check(name, m, points.len(), m.cols() == points.len())?;
        let is_symmetric = writing::is_symmetric(m);
        let form = if is_symmetric { 6 } else { 1 };
        header(&mut out, name, form, None);
        let kept = |row: usize, column: usize| !is_symmetric || row >= column;
        columns(&mut out, name, m, &points, |j| points[j], kept, &mut has_entry);
        for (_, (_, column)) in m.iter() {
            has_entry[column] = true;
        }
    }
    for (name, m) in &model.numbered {
        check(name, m, points.len(), !model.matrices.contains_key(name))?;
        header(&mut out, name, 9, Some(m.cols()));
        let number = |j: usize| (j as u64 + 1, 0);
        columns(&mut out, name, m, &points, number, |_, _| true, &mut has_entry);
    }
    if let Some(lost) = has_entry.iter().position(|has| !has) {
        let (point, component) = points[lost];
        return Err(writing::unwritable(
            "dofs",
            format!("no matrix has an entry of point {point}, component {component}"),
            "store a zero on the diagonal of one",
        ));
    }
    Ok(out.into_bytes())
}

/// Numbers and components of points.
fn points(dofs: &[Dof]) -> Result<Vec<(u64, u32)>, Error> {
    let mut seen = std::collections::HashSet::new();
    let mut points = Vec::with_capacity(dofs.len());
    for dof in dofs {
        match *dof {
            Dof::Nodal { node, component } if component <= 6 && node <= HIGHEST && seen.insert(dof) => {
                points.push((node, component));
            }
            _ => {
                let (label, component) = (dof.label(), dof.component());
                return Err(writing::unwritable(
                    "dofs",
                    format!("component {component} of {label} is there twice, or not from 0 to 6 of 1 to {HIGHEST}"),
                    "give generalised coordinates the numbers of scalar points, with component 0",
                ));
            }
        }
    }
    Ok(points)
}

fn check(name: &str, m: &CsMat<f64>, size: usize, fits: bool) -> Result<(), Error> {
    let is_name = writing::is_nastran_name(name) && !name.bytes().any(|b| b.is_ascii_lowercase());
    if !is_name {
        return Err(writing::unwritable(
            name,
            "it is no name in capitals that Nastran allows",
            writing::NASTRAN_NAME,
        ));
    }
    if m.rows() != size || !fits {
        return Err(writing::unwritable(
            name,
            format!(
                "it has {} rows and {} columns for {size} degrees of freedom, or the name of another",
                m.rows(),
                m.cols()
            ),
            "give all matrices over the same degrees of freedom, and names of their own",
        ));
    }
    writing::finite_values(name, m.data())
}

fn header(out: &mut String, name: &str, form: u32, n_columns: Option<usize>) {
    let n_columns = n_columns.map_or(String::new(), |n| n.to_string());
    let line = format!(
        "DMIG    {name:<8}{:8}{form:8}{:8}{:8}{:8}{:8}{n_columns:>8}",
        0, 2, 0, 0, ""
    );
    let _ = writeln!(out, "{}", line.trim_end());
}

/// The entries that are `kept`, by columns, and marks their rows.
fn columns(
    out: &mut String,
    name: &str,
    m: &CsMat<f64>,
    points: &[(u64, u32)],
    of_column: impl Fn(usize) -> (u64, u32),
    kept: impl Fn(usize, usize) -> bool,
    has_entry: &mut [bool],
) {
    for (j, entries) in m.to_csc().outer_iterator().enumerate() {
        let mut is_first = true;
        for (i, value) in entries.iter().filter(|(i, _)| kept(*i, j)) {
            if is_first {
                let (point, component) = of_column(j);
                let _ = writeln!(out, "DMIG*   {name:<16}{point:16}{component:16}");
            }
            is_first = false;
            has_entry[i] = true;
            let (point, component) = points[i];
            let _ = writeln!(out, "*       {point:16}{component:16}{:>WIDTH$}", number(*value));
        }
    }
}

/// A number with the exponent of double precision, with as many digits as there is room for.
fn number(value: f64) -> String {
    let mut text = format!("{value:E}");
    if !text.contains('.') {
        text = text.replace('E', ".0E");
    }
    let mut digits = WIDTH - 3;
    while text.len() > WIDTH {
        text = format!("{value:.digits$E}");
        digits -= 1;
    }
    text.replace('E', "D")
}
