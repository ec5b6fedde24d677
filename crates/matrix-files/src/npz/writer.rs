//! Writing of archives.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Write as _};

use sprs::CsMat;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::sparse::MATRIX;
use crate::value::{Array, Dense};
use crate::{Error, writing};

/// An archive, not compressed, of the arrays: full ones by columns in two dimensions, text as one string, sparse
/// matrices as five arrays.
///
/// # Errors
/// [`Error::Unwritable`] for empty names and such with slashes or control characters, names that collide with the
/// arrays of a sparse matrix, entries that are not finite, and text with zeros.
pub fn to_bytes(arrays: &BTreeMap<String, Array>) -> Result<Vec<u8>, Error> {
    let mut archive = Archive {
        zip: ZipWriter::new(Cursor::new(Vec::new())),
        names: BTreeSet::new(),
    };
    for (name, array) in arrays {
        writing::finite(name, array)?;
        match array {
            Array::Dense(m) => archive.dense(name, "<f8", m, |v| v.to_le_bytes())?,
            Array::Integers(m) => archive.dense(name, "<i8", m, |v| v.to_le_bytes())?,
            Array::Text(text) => archive.text(name, text)?,
            Array::Sparse(m) => archive.sparse(name, m)?,
        }
    }
    let failed = |e: zip::result::ZipError| writing::unwritable("archive", e.to_string(), "write fewer arrays");
    Ok(archive.zip.finish().map_err(failed)?.into_inner())
}

struct Archive {
    zip: ZipWriter<Cursor<Vec<u8>>>,
    names: BTreeSet<String>,
}

impl Archive {
    fn add(&mut self, name: &str, kind: &str, by_columns: bool, shape: &str, data: &[u8]) -> Result<(), Error> {
        if name.is_empty() || name.contains(['/', '\\']) || name.contains(char::is_control) {
            return Err(writing::unwritable(
                name,
                "it is no name of a file",
                "use letters, digits, `_` and `.`",
            ));
        }
        if !self.names.insert(name.into()) {
            return Err(writing::unwritable(
                name,
                "a sparse matrix has an array of this name",
                "rename one of them",
            ));
        }
        let order = if by_columns { "True" } else { "False" };
        let header = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}, }}");
        // Entries begin at a multiple of 64 bytes.
        let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
        let too_long = |_| writing::unwritable(name, "its header is too long", "use shorter text");
        let stated = u16::try_from(length).map_err(too_long)?;
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(stated.to_le_bytes());
        bytes.extend(format!("{header:<0$}\n", length - 1).into_bytes());
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(data.len() + bytes.len() > u32::MAX as usize);
        self.zip
            .start_file(format!("{name}.npy"), options)
            .and_then(|()| Ok(self.zip.write_all(&bytes).and_then(|()| self.zip.write_all(data))?))
            .map_err(|e| writing::unwritable(name, e.to_string(), "use a shorter name"))
    }

    fn dense<T: Copy, const N: usize>(
        &mut self,
        name: &str,
        kind: &str,
        m: &Dense<T>,
        to: impl Fn(T) -> [u8; N],
    ) -> Result<(), Error> {
        let bytes: Vec<u8> = m.data().iter().flat_map(|v| to(*v)).collect();
        self.add(name, kind, true, &format!("({}, {})", m.rows(), m.columns()), &bytes)
    }

    fn vector(&mut self, name: &str, values: impl ExactSizeIterator<Item = usize>) -> Result<(), Error> {
        let shape = format!("({},)", values.len());
        let bytes: Vec<u8> = values.flat_map(|v| (v as u64).to_le_bytes()).collect();
        self.add(name, "<i8", false, &shape, &bytes)
    }

    fn text(&mut self, name: &str, text: &str) -> Result<(), Error> {
        if text.contains('\0') {
            return Err(writing::unwritable(name, "text with zeros loses them", "remove them"));
        }
        let mut bytes: Vec<u8> = text.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        bytes.resize(bytes.len().max(4), 0);
        self.add(name, &format!("<U{}", bytes.len() / 4), false, "()", &bytes)
    }

    fn sparse(&mut self, name: &str, m: &CsMat<f64>) -> Result<(), Error> {
        let of = |part: &str| {
            if name == MATRIX {
                part.to_owned()
            } else {
                format!("{name}.{part}")
            }
        };
        let m = m.to_csr();
        self.add(&of("format"), "|S3", false, "()", b"csr")?;
        self.vector(&of("shape"), [m.rows(), m.cols()].into_iter())?;
        self.vector(&of("indptr"), m.indptr().raw_storage().iter().copied())?;
        self.vector(&of("indices"), m.indices().iter().copied())?;
        let bytes: Vec<u8> = m.data().iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&of("data"), "<f8", false, &format!("({},)", m.nnz()), &bytes)
    }
}
