//! Hashes of what stored results depend on.

use file_io::durable::hex;
use sha2::{Digest, Sha256};

/// Changes whenever the meaning of the stored numbers or the way they are computed does.
const VERSION: u32 = 3;

/// Hash of the inputs of a reduced model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Key(pub(crate) String);

/// Collects inputs into a [`Key`].
#[derive(Clone)]
pub(crate) struct KeyBuilder(Sha256);

impl KeyBuilder {
    /// Begins with what else changes the numbers: the program, of which `build` is the caller's, and the arithmetic of the
    /// processor.
    pub(crate) fn new(build: Option<&str>) -> Self {
        let mut hash = Sha256::new();
        hash.update(VERSION.to_le_bytes());
        let mut key = Self(hash);
        key.text(env!("CARGO_PKG_VERSION"));
        key.text(build.unwrap_or_default());
        key.text(contact_laws::instruction_set());
        key.text(dense_algebra::arithmetic_fingerprint());
        key
    }

    pub(crate) fn numbers(&mut self, values: impl IntoIterator<Item = f64>) {
        for value in values {
            self.0.update(value.to_le_bytes());
        }
        self.0.update([0xfe]);
    }

    pub(crate) fn integers(&mut self, values: impl IntoIterator<Item = u64>) {
        for value in values {
            self.0.update(value.to_le_bytes());
        }
        self.0.update([0xff]);
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.0.update(text.as_bytes());
        self.0.update([0xfd]);
    }

    pub(crate) fn finish(self) -> Key {
        Key(hex(&self.0.finalize()))
    }
}

impl Key {
    /// Enough of the key to tell files apart by name.
    pub(crate) fn short(&self) -> &str {
        &self.0[..32]
    }
}
