//! Reduced models on disk, keyed by a hash of everything they depend on. A checksum covers every byte.

use super::key::Key;
use crate::Error;
use faer::Mat;
use reduction::ReducedModel;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// First line of a stored model; the numbers follow as little-endian doubles in the order of the fields.
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
    let columns = n
        .checked_mul(2)?
        .checked_add(header.n_loads)?
        .checked_add(header.n_recovered)?;
    if Some(payload.len()) != columns.checked_mul(n)?.checked_mul(8) || header.n_relative > n {
        return None;
    }
    let mut numbers = payload
        .chunks_exact(8)
        .map(|c| f64::from_le_bytes(c.try_into().unwrap_or_default()));
    let mut matrix = |rows: usize, columns: usize| {
        let mut m = Mat::zeros(rows, columns);
        for j in 0..columns {
            for i in 0..rows {
                m[(i, j)] = numbers.next().unwrap_or(f64::NAN);
            }
        }
        m
    };
    let mass = matrix(n, n);
    let stiffness = matrix(n, n);
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
    let mut payload = Vec::new();
    let mut put = |m: faer::MatRef<'_, f64>| {
        for column in m.col_iter() {
            for value in column.iter() {
                payload.extend_from_slice(&value.to_le_bytes());
            }
        }
    };
    put(reduced.mass.as_ref());
    put(reduced.stiffness.as_ref());
    let n = reduced.mass.nrows();
    put(Mat::from_fn(n, reduced.loads.len(), |i, j| reduced.loads[j][i]).as_ref());
    put(reduced.recovery.as_ref());
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
    bytes.extend_from_slice(&payload);
    Ok(file_io::durable::write_sealed(&path, &bytes)?)
}
