//! Reduced models, and contact by boundary elements, on disk, keyed by a hash of everything they depend on. A checksum covers every byte.

use super::key::Key;
use crate::Error;
use faer::Mat;
use reduction::ReducedModel;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use surface_characterisation::PressedElement;

/// First line of a stored model; the numbers follow as little-endian doubles in the order of the fields, of mass and stiffness the lower triangles.
#[derive(Serialize, Deserialize)]
struct Header<F> {
    key: String,
    n: usize,
    n_relative: usize,
    n_attachment: usize,
    n_loads: usize,
    n_recovered: usize,
    zem_stuck: usize,
    asymmetry: f64,
    stuck_frequencies: Vec<f64>,
    facts: F,
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
    // Two triangles, loads and recovery.
    let columns = n
        .checked_add(1)?
        .checked_add(header.n_loads)?
        .checked_add(header.n_recovered)?;
    if Some(payload.len()) != columns.checked_mul(n)?.checked_mul(8) || header.n_relative > n {
        return None;
    }
    let mut numbers = payload.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
    let mut next = || numbers.next().unwrap_or(f64::NAN);
    let mut symmetric = || {
        let mut m = Mat::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                let value = next();
                (m[(i, j)], m[(j, i)]) = (value, value);
            }
        }
        m
    };
    let (mass, stiffness) = (symmetric(), symmetric());
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
    let n = reduced.mass.nrows();
    let header = Header {
        key: key.0.clone(),
        n,
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
    for matrix in [&reduced.mass, &reduced.stiffness] {
        let lower = matrix
            .col_iter()
            .enumerate()
            .flat_map(|(j, column)| column.iter().skip(j));
        lower.for_each(&mut put);
    }
    reduced.loads.iter().flatten().for_each(&mut put);
    let recovery = reduced.recovery.col_iter().flat_map(|column| column.iter());
    recovery.for_each(&mut put);
    Ok(file_io::durable::write_sealed(&path, &bytes)?)
}
