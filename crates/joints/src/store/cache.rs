//! Reduced models, the modes of their bases, and contact by boundary elements, on disk, keyed by a hash of everything they depend on. A checksum covers every byte.

use super::key::Key;
use crate::Error;
use dense_algebra::{BlockMatrix, Node, Symmetric, SystemMatrix, Tree, mirror_lower};
use faer::{Mat, MatRef};
use finite_elements::eigen::Modes;
use reduction::ReducedModel;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use surface_characterisation::PressedElement;

/// What precedes the numbers of a stored model, which follow in the order of the fields, of mass and stiffness the lower triangles.
#[derive(Serialize, Deserialize)]
struct Header<F> {
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
    let (header, mut numbers) = Numbers::read::<Header<F>>(&path_of(directory, key), key)?;
    let n = header.n;
    // Loads and recovery, and twice the entries of a matrix, of which blocks share their bases.
    let rows = header.n_loads.checked_add(header.n_recovered)?.checked_mul(n)?;
    let matrices = match &header.tree {
        None => n.checked_add(1)?.checked_mul(n)?,
        Some(shapes) => numbers_of_blocks(shapes, n)?,
    };
    if Some(numbers.left()) != matrices.checked_add(rows) || header.n_relative > n {
        return None;
    }
    let (mass, stiffness) = match &header.tree {
        None => (numbers.lower(n).into(), numbers.lower(n).into()),
        Some(shapes) => {
            let nodes = shapes.iter().map(|shape| Node {
                children: shape.children.clone(),
                basis: numbers.matrix(shape.coordinates, shape.combinations),
            });
            let tree = Arc::new(Tree::try_new(nodes.collect())?);
            let n_rest = n - tree.n_coordinates();
            let mut blocks = || {
                let packed = |shape: &Shape| Symmetric::from_lower(numbers.lower(shape.coordinates).as_ref());
                let local = shapes.iter().map(packed).map(Arc::new).collect();
                let rest = (0..n_rest).map(|_| numbers.next()).collect();
                let core = numbers.lower(tree.rank() + n_rest);
                SystemMatrix::Blocks(BlockMatrix::new(tree.clone(), local, rest, core))
            };
            (blocks(), blocks())
        }
    };
    let loads = numbers.matrix(n, header.n_loads);
    let recovery = numbers.matrix(header.n_recovered, n);
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
    let mut record = Record::new(path_of(directory, key), key, &header, "encoding the reduced model")?;
    if let SystemMatrix::Blocks(mass) = &reduced.mass {
        mass.tree().nodes().iter().for_each(|node| record.matrix(&node.basis));
    }
    for matrix in [&reduced.mass, &reduced.stiffness] {
        match matrix {
            SystemMatrix::Dense(matrix) => record.lower(matrix.as_ref()),
            SystemMatrix::Blocks(matrix) => {
                let blocks = matrix.local().iter().map(|block| block.to_dense());
                blocks.for_each(|block| record.lower(block.as_ref()));
                record.numbers(matrix.rest());
                record.lower(matrix.core());
            }
        }
    }
    record.numbers(reduced.loads.iter().flatten());
    record.matrix(&reduced.recovery);
    record.write()
}

/// The modes stored for `key`, if there is an intact file.
pub fn load_modes(directory: &Path, key: &Key) -> Option<Vec<Modes>> {
    let (parts, mut numbers) = Numbers::read::<Vec<ModesOfPart>>(&path_of_modes(directory, key), key)?;
    let expected = parts.iter().try_fold(0_usize, |sum, part| {
        let shapes_and_values = part.coordinates.checked_add(1)?.checked_mul(part.modes)?;
        sum.checked_add(shapes_and_values)?.checked_add(1)
    });
    if Some(numbers.left()) != expected || parts.iter().any(|part| part.n_zero > part.modes) {
        return None;
    }
    let modes = parts.into_iter().map(|part| Modes {
        eigenvalues: (0..part.modes).map(|_| numbers.next()).collect(),
        residual: numbers.next(),
        shapes: numbers.matrix(part.coordinates, part.modes),
        n_zero: part.n_zero,
    });
    Some(modes.collect())
}

/// Stores modes; the file appears whole or not at all.
pub fn store_modes(directory: &Path, key: &Key, modes: &[Modes]) -> Result<(), Error> {
    let of_part = |modes: &Modes| ModesOfPart {
        coordinates: modes.shapes.nrows(),
        modes: modes.shapes.ncols(),
        n_zero: modes.n_zero,
    };
    let parts: Vec<ModesOfPart> = modes.iter().map(of_part).collect();
    let mut record = Record::new(path_of_modes(directory, key), key, &parts, "encoding modes")?;
    for modes in modes {
        record.numbers(modes.eigenvalues.iter().chain([&modes.residual]));
        record.matrix(&modes.shapes);
    }
    record.write()
}

/// What precedes the numbers of stored modes, of each part: its eigenvalues follow, the residual and the shapes.
#[derive(Serialize, Deserialize)]
struct ModesOfPart {
    coordinates: usize,
    modes: usize,
    n_zero: usize,
}

/// Numbers of a stored file, one after the other: little-endian doubles behind a line with its key and what precedes them.
struct Numbers {
    bytes: Vec<u8>,
    at: usize,
}

impl Numbers {
    /// The file of a key with what precedes its numbers, if it is intact.
    fn read<H: DeserializeOwned>(path: &Path, key: &Key) -> Option<(H, Self)> {
        let bytes = file_io::durable::read_sealed(path)?;
        let end = bytes.iter().position(|b| *b == b'\n')?;
        let (of, header): (String, H) = serde_json::from_slice(&bytes[..end]).ok()?;
        let at = end + 1;
        (of == key.0 && (bytes.len() - at).is_multiple_of(size_of::<f64>())).then_some((header, Self { bytes, at }))
    }

    /// How many there are still.
    fn left(&self) -> usize {
        (self.bytes.len() - self.at) / size_of::<f64>()
    }

    /// NaN behind the last one.
    fn next(&mut self) -> f64 {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some(bytes) = rest.first_chunk() else {
            return f64::NAN;
        };
        self.at += bytes.len();
        f64::from_le_bytes(*bytes)
    }

    fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        let mut m = Mat::zeros(rows, columns);
        for column in m.col_iter_mut() {
            column.iter_mut().for_each(|value| *value = self.next());
        }
        m
    }

    /// A symmetric matrix from its lower triangle.
    fn lower(&mut self, n: usize) -> Mat<f64> {
        let mut m = Mat::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                m[(i, j)] = self.next();
            }
        }
        mirror_lower(m.as_mut());
        m
    }
}

/// A file of [`Numbers`] that is being made.
struct Record {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl Record {
    fn new(path: PathBuf, key: &Key, header: &impl Serialize, operation: &'static str) -> Result<Self, Error> {
        let mut bytes = serde_json::to_vec(&(&key.0, header)).map_err(|error| Error::File {
            path: path.clone(),
            operation,
            source: error.into(),
        })?;
        bytes.push(b'\n');
        Ok(Self { path, bytes })
    }

    fn numbers<'a>(&mut self, numbers: impl IntoIterator<Item = &'a f64>) {
        // Whole numbers, where bytes one by one would take longer than writing the file.
        for value in numbers {
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
    }

    fn matrix(&mut self, matrix: &Mat<f64>) {
        self.numbers(matrix.col_iter().flat_map(|column| column.iter()));
    }

    fn lower(&mut self, matrix: MatRef<'_, f64>) {
        let n = matrix.nrows();
        self.bytes.reserve(size_of::<f64>() * n * (n + 1) / 2);
        let columns = matrix.col_iter().enumerate();
        self.numbers(columns.flat_map(|(j, column)| column.iter().skip(j)));
    }

    /// The file appears whole or not at all.
    fn write(self) -> Result<(), Error> {
        Ok(file_io::durable::write_sealed(&self.path, &self.bytes)?)
    }
}
