//! Hashes of what stored results depend on.

use file_io::durable::hex;
use sha2::{Digest, Sha256};
use sprs::CsMat;

/// Changes whenever the meaning of the stored numbers or the way they are computed does.
const VERSION: u32 = 3;

/// Hash of the inputs of a reduced model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key(pub String);

/// Collects inputs into a [`Key`].
#[derive(Clone)]
pub struct KeyBuilder(Sha256);

impl KeyBuilder {
    /// Begins with what else changes the numbers: the program, of which `build` is the caller's, and the arithmetic of the
    /// processor.
    pub fn new(build: Option<&str>) -> Self {
        let mut hash = Sha256::new();
        hash.update(VERSION.to_le_bytes());
        let mut key = Self(hash);
        key.text(env!("CARGO_PKG_VERSION"));
        key.text(build.unwrap_or_default());
        key.text(contact_laws::instruction_set());
        key.text(dense_algebra::arithmetic_fingerprint());
        key
    }

    /// Adds numbers, bit by bit.
    pub fn numbers(&mut self, values: impl IntoIterator<Item = f64>) {
        for value in values {
            self.0.update(value.to_le_bytes());
        }
        self.0.update([0xfe]);
    }

    /// Adds integers.
    pub fn integers(&mut self, values: impl IntoIterator<Item = u64>) {
        for value in values {
            self.0.update(value.to_le_bytes());
        }
        self.0.update([0xff]);
    }

    /// Adds a sparse matrix.
    pub fn matrix(&mut self, matrix: &CsMat<f64>) {
        self.integers(matrix.indptr().raw_storage().iter().map(|&i| i as u64));
        self.integers(matrix.indices().iter().map(|&i| i as u64));
        self.numbers(matrix.data().iter().copied());
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.0.update(text.as_bytes());
        self.0.update([0xfd]);
    }

    /// The hash of all that was added.
    pub fn finish(self) -> Key {
        Key(hex(&self.0.finalize()))
    }
}

impl Key {
    /// Enough of the key to tell files apart by name.
    pub fn short(&self) -> &str {
        &self.0[..32]
    }
}
