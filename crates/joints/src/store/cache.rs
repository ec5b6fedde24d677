//! Reduced models, the modes of their bases, and contact by boundary elements, on disk, keyed by a hash of everything they depend on. A checksum covers every byte.

use super::key::Key;
use crate::Error;
use dense_algebra::{BlockMatrix, Node, Symmetric, SystemMatrix, Tree};
use faer::{Mat, MatRef};
use finite_elements::eigen::Modes;
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
    tree: Option<Vec<Shape>>,
    n_relative: usize,
    n_attachment: usize,
    n_loads: usize,
    n_recovered: usize,
    zem_stuck: usize,
    asymmetry: f64,
    stuck_frequencies: Vec<f64>,
    facts: F,
}

/// Of a node of the tree of matrices in blocks.
#[derive(Serialize, Deserialize)]
struct Shape {
    children: Vec<usize>,
    coordinates: usize,
    combinations: usize,
}

/// Numbers that bases and two matrices of `n` coordinates take; none if that is no size.
fn numbers_of_blocks(shapes: &[Shape], n: usize) -> Option<usize> {
    let (mut numbers, mut coordinates, mut rank) = (0_usize, 0_usize, 0_usize);
    for (number, shape) in shapes.iter().enumerate() {
        let basis = shape.coordinates.checked_mul(shape.combinations)?;
        let matrices = shape.coordinates.checked_add(1)?.checked_mul(shape.coordinates)?;
        numbers = numbers.checked_add(basis)?.checked_add(matrices)?;
        if shape.children.is_empty() {
            coordinates = coordinates.checked_add(shape.coordinates)?;
        }
        if !shapes.iter().any(|other| other.children.contains(&number)) {
            rank = rank.checked_add(shape.combinations)?;
        }
    }
    let rest = n.checked_sub(coordinates)?;
    let core = rank.checked_add(rest)?;
    let cores = core.checked_add(1)?.checked_mul(core)?;
    numbers.checked_add(rest.checked_mul(2)?)?.checked_add(cores)
}

fn path_of(directory: &Path, key: &Key) -> PathBuf {
    directory.join(format!("reduced-{}.bin", key.short()))
}

fn path_of_elements(directory: &Path, key: &Key) -> PathBuf {
    directory.join(format!("contact-{}.json", key.short()))
}

fn path_of_modes(directory: &Path, key: &Key) -> PathBuf {
    directory.join(format!("modes-{}.bin", key.short()))
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
    let matrices = match &header.tree {
        None => n.checked_add(1)?.checked_mul(n)?,
        Some(shapes) => numbers_of_blocks(shapes, n)?,
    };
    let numbers = matrices.checked_add(rows)?;
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
    let (mass, stiffness) = match &header.tree {
        None => (lower(n, &mut next).into(), lower(n, &mut next).into()),
        Some(shapes) => {
            let nodes = shapes.iter().map(|shape| {
                let mut basis = Mat::zeros(shape.coordinates, shape.combinations);
                basis
                    .col_iter_mut()
                    .for_each(|column| column.iter_mut().for_each(|value| *value = next()));
                let children = shape.children.clone();
                Node { children, basis }
            });
            let tree = Arc::new(Tree::try_new(nodes.collect())?);
            let n_rest = n - tree.n_coordinates();
            let mut blocks = || {
                let packed = |shape: &Shape| Symmetric::from_lower(lower(shape.coordinates, &mut next).as_ref());
                let local = shapes.iter().map(packed).map(Arc::new).collect();
                let rest = (0..n_rest).map(|_| next()).collect();
                let core = lower(tree.rank() + n_rest, &mut next);
                SystemMatrix::Blocks(BlockMatrix::new(tree.clone(), local, rest, core))
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
    let shape = |node: &Node| Shape {
        children: node.children.clone(),
        coordinates: node.basis.nrows(),
        combinations: node.basis.ncols(),
    };
    let tree = match &reduced.mass {
        SystemMatrix::Dense(_) => None,
        SystemMatrix::Blocks(mass) => Some(mass.tree().nodes().iter().map(shape).collect()),
    };
    let header = Header {
        key: key.0.clone(),
        n: reduced.size(),
        tree,
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
        let columns = mass.tree().nodes().iter().flat_map(|node| node.basis.col_iter());
        columns.flat_map(|column| column.iter()).for_each(&mut put);
    }
    for matrix in [&reduced.mass, &reduced.stiffness] {
        match matrix {
            SystemMatrix::Dense(matrix) => lower(matrix.as_ref(), &mut put),
            SystemMatrix::Blocks(matrix) => {
                let blocks = matrix.local().iter().map(|block| block.to_dense());
                blocks.for_each(|block| lower(block.as_ref(), &mut put));
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

/// First line of stored modes; of each part follow the eigenvalues, the residual and the shapes as little-endian doubles.
#[derive(Serialize, Deserialize)]
struct ModesHeader {
    key: String,
    /// Coordinates, modes, and how many of these cost no energy, of each part.
    parts: Vec<[usize; 3]>,
}

/// The modes stored for `key`, if there is an intact file.
pub fn load_modes(directory: &Path, key: &Key) -> Option<Vec<Modes>> {
    let bytes = file_io::durable::read_sealed(&path_of_modes(directory, key))?;
    let end = bytes.iter().position(|b| *b == b'\n')?;
    let header: ModesHeader = serde_json::from_slice(&bytes[..end]).ok()?;
    let payload = &bytes[end + 1..];
    let expected = header.parts.iter().try_fold(0_usize, |sum, [rows, count, _]| {
        sum.checked_add(rows.checked_add(1)?.checked_mul(*count)?)?
            .checked_add(1)
    });
    if header.key != key.0 || Some(payload.len()) != expected?.checked_mul(8) {
        return None;
    }
    let mut numbers = payload.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
    let mut next = || numbers.next().unwrap_or(f64::NAN);
    let modes = header.parts.into_iter().map(|[rows, count, n_zero]| {
        let eigenvalues = (0..count).map(|_| next()).collect();
        let residual = next();
        let mut shapes = Mat::zeros(rows, count);
        shapes
            .col_iter_mut()
            .for_each(|shape| shape.iter_mut().for_each(|value| *value = next()));
        (n_zero <= count).then_some(Modes {
            eigenvalues,
            shapes,
            n_zero,
            residual,
        })
    });
    modes.collect()
}

/// Stores modes; the file appears whole or not at all.
pub fn store_modes(directory: &Path, key: &Key, modes: &[Modes]) -> Result<(), Error> {
    let shape = |modes: &Modes| [modes.shapes.nrows(), modes.shapes.ncols(), modes.n_zero];
    let header = ModesHeader {
        key: key.0.clone(),
        parts: modes.iter().map(shape).collect(),
    };
    let path = path_of_modes(directory, key);
    let mut bytes = serde_json::to_vec(&header).map_err(|error| Error::File {
        path: path.clone(),
        operation: "encoding modes",
        source: error.into(),
    })?;
    bytes.push(b'\n');
    for modes in modes {
        let numbers = modes.eigenvalues.iter().chain([&modes.residual]);
        let all = numbers.chain(modes.shapes.col_iter().flat_map(|shape| shape.iter()));
        all.for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
    }
    Ok(file_io::durable::write_sealed(&path, &bytes)?)
}
