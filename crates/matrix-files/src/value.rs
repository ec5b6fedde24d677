//! What the files hold: dense and sparse matrices, integers and text, by name, and what their rows belong to.

use std::collections::BTreeMap;
use std::ops::Index;

use sprs::CsMat;

use crate::Error;

/// A full matrix, stored by columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dense<T> {
    rows: usize,
    columns: usize,
    data: Vec<T>,
}

impl<T> Dense<T> {
    /// A matrix of `rows` x `columns` entries listed column by column.
    ///
    /// # Errors
    /// [`Error::Shape`].
    pub fn try_new(rows: usize, columns: usize, data: Vec<T>) -> Result<Self, Error> {
        if rows.checked_mul(columns) != Some(data.len()) {
            let entries = data.len();
            return Err(Error::Shape { rows, columns, entries });
        }
        Ok(Self { rows, columns, data })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The entries, column by column.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// The entries, column by column.
    pub fn into_data(self) -> Vec<T> {
        self.data
    }
}

impl<T: Copy> Dense<T> {
    /// The matrix whose entries are listed row by row.
    ///
    /// # Errors
    /// [`Error::Shape`].
    pub fn try_from_rows(rows: usize, columns: usize, data: Vec<T>) -> Result<Self, Error> {
        let listed = Self::try_new(columns, rows, data)?;
        if rows.min(columns) <= 1 {
            return Self::try_new(rows, columns, listed.data);
        }
        let turned = (0..columns).flat_map(|j| listed.data[j..].iter().step_by(columns).copied());
        Self::try_new(rows, columns, turned.collect())
    }
}

impl<T> Index<(usize, usize)> for Dense<T> {
    type Output = T;

    fn index(&self, (row, column): (usize, usize)) -> &T {
        assert!(row < self.rows, "row {row} of {}", self.rows);
        &self.data[row + column * self.rows]
    }
}

/// One array of a file. Every number in it is finite, except in measurements ([`crate::npz::parse_measured`]).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Array {
    /// A full matrix; vectors are single columns unless the file says otherwise.
    Dense(Dense<f64>),
    /// A sparse matrix, compressed by rows, with ascending columns in each row; stored zeros are kept.
    Sparse(CsMat<f64>),
    /// Integers and truth values.
    Integers(Dense<i64>),
    /// Text; the rows of a character matrix become lines.
    Text(String),
}

/// The arrays of a file by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collection {
    /// What was read.
    pub arrays: BTreeMap<String, Array>,
    /// What was not.
    pub skipped: Vec<Skipped>,
}

/// Something in a file that is not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// Its name in the file.
    pub name: String,
    /// Why it is not read.
    pub reason: String,
}

/// What a row of a matrix belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Dof {
    /// A component at a node of the mesh: 1, 2, 3 are displacements, 4, 5, 6 rotations, others as the program counts
    /// them.
    Nodal {
        /// Node label, positive.
        node: u64,
        /// Component.
        component: u32,
    },
    /// A generalised coordinate: a retained mode, or a variable internal to the program that wrote the file.
    Generalised {
        /// Label as the program gives it, zero or negative.
        label: i64,
        /// Component.
        component: u32,
    },
}

impl Dof {
    /// From a node label as structural programs write it: labels that are not positive belong to generalised
    /// coordinates.
    pub fn new(label: i64, component: u32) -> Self {
        match u64::try_from(label) {
            Ok(node) if node > 0 => Self::Nodal { node, component },
            _ => Self::Generalised { label, component },
        }
    }

    /// Node label, or the label of the generalised coordinate.
    pub fn label(&self) -> i64 {
        match *self {
            // Labels are read as `i64`.
            Self::Nodal { node, .. } => i64::try_from(node).unwrap_or(i64::MAX),
            Self::Generalised { label, .. } => label,
        }
    }

    /// Component.
    pub fn component(&self) -> u32 {
        match *self {
            Self::Nodal { component, .. } | Self::Generalised { component, .. } => component,
        }
    }

    /// A table with a row `label, component` for each, for files that have no place for a map of their own.
    pub fn table(dofs: &[Self]) -> Array {
        let labels = dofs.iter().map(Self::label);
        let data = labels.chain(dofs.iter().map(|dof| dof.component().into())).collect();
        Array::Integers(Dense {
            rows: dofs.len(),
            columns: 2,
            data,
        })
    }

    /// The rows of such a table; `None` if it has not two columns, or components below zero or beyond 32 bits.
    pub fn from_table(table: &Dense<i64>) -> Option<Vec<Self>> {
        let (labels, components) = (table.columns == 2).then(|| table.data.split_at(table.rows))?;
        let pairs = labels.iter().zip(components);
        pairs
            .map(|(label, c)| Some(Self::new(*label, u32::try_from(*c).ok()?)))
            .collect()
    }
}

/// Sparse matrices over one list of degrees of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembled {
    /// What rows and columns belong to.
    pub dofs: Vec<Dof>,
    /// Square matrices by name, compressed by rows, both triangles filled.
    pub matrices: BTreeMap<String, CsMat<f64>>,
}

impl Assembled {
    /// Name of the stiffness.
    pub const STIFFNESS: &str = "STIFFNESS";
    /// Name of the mass.
    pub const MASS: &str = "MASS";
    /// Name of viscous damping.
    pub const DAMPING: &str = "DAMPING";
}

/// Refuses sizes that would let a few bytes demand memory without bound: at most as many rows or columns as the file
/// has bytes, or 2^20.
pub(crate) fn plausible(rows: usize, columns: usize, bytes: usize) -> Result<(), (usize, usize)> {
    let possible = bytes.max(1 << 20);
    let larger = rows.max(columns);
    if larger > possible {
        Err((larger, possible))
    } else {
        Ok(())
    }
}
