//! Reduced models, and contact by boundary elements, on disk, keyed by a hash of everything they depend on. A checksum covers every byte.

use super::key::Key;
use crate::Error;
use dense_algebra::{BlockMatrix, SystemMatrix};
use faer::{Mat, MatRef};
use reduction::ReducedModel;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use surface_characterisation::PressedElement;

/// First line of a stored model; the numbers follow as little-endian doubles in the order of the fields, of mass and stiffness the lower triangles.
#[derive(Serialize, Deserialize)]
struct Header<F> {
    key: String,
    n: usize,
    /// Of matrices in blocks.
    groups: Option<Groups>,
    n_relative: usize,
    n_attachment: usize,
    n_loads: usize,
    n_recovered: usize,
    zem_stuck: usize,
    asymmetry: f64,
    stuck_frequencies: Vec<f64>,
    facts: F,
}

/// Coordinates of each block, and columns of its basis.
#[derive(Serialize, Deserialize)]
struct Groups {
    sizes: Vec<usize>,
    ranks: Vec<usize>,
}

impl Groups {
    /// Numbers that bases and two matrices of `n` coordinates take; none if that is no size.
    fn numbers(&self, n: usize) -> Option<usize> {
        let triangle = |size: usize| Some(size.checked_add(1)?.checked_mul(size)? / 2);
        let (mut bases, mut blocks, mut coordinates, mut rank) = (0_usize, 0_usize, 0_usize, 0_usize);
        for (&size, &own) in self.sizes.iter().zip(&self.ranks) {
            bases = bases.checked_add(size.checked_mul(own)?)?;
            blocks = blocks.checked_add(triangle(size)?)?;
            coordinates = coordinates.checked_add(size)?;
            rank = rank.checked_add(own)?;
        }
        let rest = n
            .checked_sub(coordinates)
            .filter(|_| self.sizes.len() == self.ranks.len())?;
        let core = triangle(rank.checked_add(rest)?)?;
        let matrix = blocks.checked_add(rest)?.checked_add(core)?;
        bases.checked_add(matrix.checked_mul(2)?)
    }
}

fn path_of(directory: &Path, key: &Key) -> PathBuf {
    directory.join(format!("reduced-{}.bin", key.short()))
}

fn path_of_elements(directory: &Path, key: &Key) -> PathBuf {
    directory.join(format!("contact-{}.json", key.short()))
}

/// The contact of elements stored for `key`, if there is an intact file.
pub fn load_elements(directory: &Path, key: &Key) -> Option<Vec<PressedElement>> {
    let bytes = file_io::durable::read_sealed(&path_of_elements(directory, key))?;
    let (of, elements): (String, Vec<PressedElement>) = serde_json::from_slice(&bytes).ok()?;
    (of == key.0).then_some(elements)
}

/// Stores the contact of elements; the file appears whole or not at all.
pub fn store_elements(directory: &Path, key: &Key, elements: &[PressedElement]) -> Result<(), Error> {
    let path = path_of_elements(directory, key);
    let bytes = serde_json::to_vec(&(&key.0, elements)).map_err(|error| Error::File {
        path: path.clone(),
        operation: "encoding the contact of elements",
        source: error.into(),
    })?;
    Ok(file_io::durable::write_sealed(&path, &bytes)?)
}

/// The model stored for `key` and the facts stored with it, if there is an intact file. Damaged or foreign files count as
/// absent.
pub fn load<F: DeserializeOwned>(directory: &Path, key: &Key) -> Option<(ReducedModel, F)> {
    let bytes = file_io::durable::read_sealed(&path_of(directory, key))?;
    let end = bytes.iter().position(|b| *b == b'\n')?;
    let header: Header<F> = serde_json::from_slice(&bytes[..end]).ok()?;
    let payload = &bytes[end + 1..];
    if header.key != key.0 {
        return None;
    }
    let n = header.n;
    // Loads and recovery, and twice the entries of a matrix, of which blocks share their bases.
    let rows = header.n_loads.checked_add(header.n_recovered)?.checked_mul(n)?;
    let numbers = match &header.groups {
        None => n.checked_add(1)?.checked_mul(n)?.checked_add(rows)?,
        Some(groups) => groups.numbers(n)?.checked_add(rows)?,
    };
    if Some(payload.len()) != numbers.checked_mul(8) || header.n_relative > n {
        return None;
    }
    let mut numbers = payload.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
    let mut next = || numbers.next().unwrap_or(f64::NAN);
    fn lower(n: usize, next: &mut impl FnMut() -> f64) -> Mat<f64> {
        let mut m = Mat::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                let value = next();
                (m[(i, j)], m[(j, i)]) = (value, value);
            }
        }
        m
    }
    let (mass, stiffness) = match &header.groups {
        None => (lower(n, &mut next).into(), lower(n, &mut next).into()),
        Some(groups) => {
            let bases = (groups.sizes.iter().zip(&groups.ranks)).map(|(&size, &rank)| {
                let mut basis = Mat::zeros(size, rank);
                basis
                    .col_iter_mut()
                    .for_each(|column| column.iter_mut().for_each(|value| *value = next()));
                basis
            });
            let bases = Arc::new(bases.collect::<Vec<_>>());
            let rank: usize = groups.ranks.iter().sum();
            let n_rest = n - groups.sizes.iter().sum::<usize>();
            let mut blocks = || {
                let local = groups.sizes.iter().map(|&size| lower(size, &mut next)).collect();
                let rest = (0..n_rest).map(|_| next()).collect();
                let core = lower(rank + n_rest, &mut next);
                SystemMatrix::Blocks(BlockMatrix::new(bases.clone(), Arc::new(local), rest, core))
            };
            (blocks(), blocks())
        }
    };
    let mut matrix = |rows, columns| {
        let mut m = Mat::zeros(rows, columns);
        m.col_iter_mut()
            .for_each(|column| column.iter_mut().for_each(|value| *value = next()));
        m
    };
    let loads = matrix(n, header.n_loads);
    let recovery = matrix(header.n_recovered, n);
    let reduced = ReducedModel {
        mass,
        stiffness,
        loads: loads.col_iter().map(|c| c.iter().copied().collect()).collect(),
        n_relative: header.n_relative,
        n_attachment: header.n_attachment,
        recovery,
        stuck_frequencies: header.stuck_frequencies,
        zem_stuck: header.zem_stuck,
        asymmetry: header.asymmetry,
    };
    Some((reduced, header.facts))
}

/// Stores a model with `facts` about it; the file appears whole or not at all.
pub fn store(directory: &Path, key: &Key, reduced: &ReducedModel, facts: &impl Serialize) -> Result<(), Error> {
    let groups = match &reduced.mass {
        SystemMatrix::Dense(_) => None,
        SystemMatrix::Blocks(mass) => Some(Groups {
            sizes: mass.bases().iter().map(|basis| basis.nrows()).collect(),
            ranks: mass.bases().iter().map(|basis| basis.ncols()).collect(),
        }),
    };
    let header = Header {
        key: key.0.clone(),
        n: reduced.size(),
        groups,
        n_relative: reduced.n_relative,
        n_attachment: reduced.n_attachment,
        n_loads: reduced.loads.len(),
        n_recovered: reduced.recovery.nrows(),
        zem_stuck: reduced.zem_stuck,
        asymmetry: reduced.asymmetry,
        stuck_frequencies: reduced.stuck_frequencies.clone(),
        facts,
    };
    let path = path_of(directory, key);
    let mut bytes = serde_json::to_vec(&header).map_err(|error| Error::File {
        path: path.clone(),
        operation: "encoding the reduced model",
        source: error.into(),
    })?;
    bytes.push(b'\n');
    let mut put = |value: &f64| bytes.extend_from_slice(&value.to_le_bytes());
    let lower = |matrix: MatRef<'_, f64>, put: &mut dyn FnMut(&f64)| {
        for (j, column) in matrix.col_iter().enumerate() {
            column.iter().skip(j).for_each(&mut *put);
        }
    };
    if let SystemMatrix::Blocks(mass) = &reduced.mass {
        let bases = mass.bases().iter();
        bases
            .flat_map(|basis| basis.col_iter().flat_map(|column| column.iter()))
            .for_each(&mut put);
    }
    for matrix in [&reduced.mass, &reduced.stiffness] {
        match matrix {
            SystemMatrix::Dense(matrix) => lower(matrix.as_ref(), &mut put),
            SystemMatrix::Blocks(matrix) => {
                matrix.local().iter().for_each(|block| lower(block.as_ref(), &mut put));
                matrix.rest().iter().for_each(&mut put);
                lower(matrix.core(), &mut put);
            }
        }
    }
    reduced.loads.iter().flatten().for_each(&mut put);
    let recovery = reduced.recovery.col_iter().flat_map(|column| column.iter());
    recovery.for_each(&mut put);
    Ok(file_io::durable::write_sealed(&path, &bytes)?)
}
