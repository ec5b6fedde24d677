//! NumPy archives (`.npz`): a ZIP file of arrays in `.npy` format, plain (`savez`) or compressed (`savez_compressed`).
//!
//! Layout: NumPy Enhancement Proposal 1 and `numpy.lib.format`. A sparse matrix is five arrays, as
//! `scipy.sparse.save_npz` writes them: `format` (`csr` or `csc`), `shape`, `indptr`, `indices`, `data`. Alone in a
//! file it is called [`MATRIX`] here; beside others its arrays are called `name.format`, `name.shape` and so on.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Write as _};
use std::path::Path;

use sprs::CsMat;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::archive;
use crate::text;
use crate::triplets::{self, Entry};
use crate::value::{Array, Collection, Dense, Skipped, Source, plausible};
use crate::{Error, Place, writing};

/// Name of a sparse matrix that is alone in its file, as `scipy.sparse.save_npz` writes it and `load_npz` reads it.
pub const MATRIX: &str = "matrix";

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::Io`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Collection, Error> {
    let bytes = text::load(path)?;
    parse(Source {
        name: &path.to_string_lossy(),
        bytes: &bytes,
    })
}

/// Reads all arrays: real numbers, integers, truth values and text of up to two dimensions, by rows or columns, and
/// sparse matrices. Single numbers are 1 x 1, vectors are columns. Other members of the archive are listed as skipped.
///
/// Entries of a sparse matrix at the same place add up, as SciPy defines.
///
/// # Errors
/// [`Error::Malformed`], [`Error::Unsupported`] for sparse matrices in other formats, [`Error::Oversized`],
/// [`Error::OutOfRange`], [`Error::NotFinite`].
pub fn parse(source: Source<'_>) -> Result<Collection, Error> {
    let mut found = arrays(source, false)?;
    sparse_matrices(source, &mut found.arrays)?;
    Ok(found)
}

/// Reads the arrays of a measurement: full ones only, and with NaN and infinities kept, since NumPy marks missing values
/// by NaN.
///
/// # Errors
/// [`Error::Malformed`], [`Error::Oversized`].
pub fn parse_measured(source: Source<'_>) -> Result<Collection, Error> {
    arrays(source, true)
}

/// Reads one array in a file of its own (`.npy`), with NaN and infinities kept as by [`parse_measured`].
///
/// # Errors
/// [`Error::Malformed`], [`Error::Unsupported`], [`Error::Oversized`].
pub fn parse_measured_array(source: Source<'_>) -> Result<Array, Error> {
    let npy = Npy {
        file: source.name,
        member: None,
        measured: true,
        bytes: source.bytes,
    };
    npy.parse()?.map_err(|found| Error::Unsupported {
        file: source.name.into(),
        place: Place::Byte(0),
        found,
        remedy: "save real numbers as an array of one or two dimensions",
    })
}

fn arrays(source: Source<'_>, measured: bool) -> Result<Collection, Error> {
    let mut archive = archive::Archive::open(source)?;
    let mut found = Collection::default();
    for (index, name) in archive.names()?.into_iter().enumerate() {
        let bytes = archive.member(index)?;
        let Some(key) = name.strip_suffix(".npy") else {
            found.skip(&name, "it is no array");
            continue;
        };
        let npy = Npy {
            file: source.name,
            member: Some(&name),
            measured,
            bytes: &bytes,
        };
        match npy.parse()? {
            Err(reason) => found.skip(key, &reason),
            Ok(array) => {
                if found.arrays.insert(key.into(), array).is_some() {
                    return Err(npy.malformed(0, "a second array of this name", "each name once"));
                }
            }
        }
    }
    Ok(found)
}

impl Collection {
    fn skip(&mut self, name: &str, reason: &str) {
        self.skipped.push(Skipped {
            name: name.into(),
            reason: reason.into(),
        });
    }
}

/// One array file.
#[derive(Clone, Copy)]
struct Npy<'a> {
    file: &'a str,
    /// Its name in the archive, unless it is the file itself.
    member: Option<&'a str>,
    /// Whether NaN and infinities are kept.
    measured: bool,
    bytes: &'a [u8],
}

/// What the header says.
struct Header {
    /// Type of the entries; `None` if it is a structure.
    kind: Option<String>,
    by_columns: bool,
    shape: Vec<usize>,
}

impl Npy<'_> {
    fn place(&self, byte: usize) -> Place {
        match self.member {
            None => Place::Byte(byte),
            Some(member) => Place::Inside {
                part: format!("`{}`", member.escape_debug()),
                byte,
            },
        }
    }

    fn malformed(&self, byte: usize, found: impl std::fmt::Display, expected: impl std::fmt::Display) -> Error {
        Error::Malformed {
            file: self.file.into(),
            place: self.place(byte),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    /// The array, or why it is skipped.
    fn parse(&self) -> Result<Result<Array, String>, Error> {
        let (header, start) = match *self.bytes {
            [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, a, b, ..] => (usize::from(u16::from_le_bytes([a, b])), 10),
            [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, _, a, b, c, d, ..] => {
                (u32::from_le_bytes([a, b, c, d]) as usize, 12)
            }
            _ => {
                return Err(self.malformed(
                    0,
                    text::quoted(&self.bytes[..self.bytes.len().min(8)]),
                    "`\\x93NUMPY` and 1 to 3",
                ));
            }
        };
        let Some((header, data)) = self.bytes[start..].split_at_checked(header) else {
            return Err(Error::Oversized {
                file: self.file.into(),
                place: self.place(start),
                what: "the number of bytes of the header",
                stated: header as u128,
                possible: self.bytes.len() - start,
            });
        };
        let data_at = start + header.len();
        let Some(Header {
            kind,
            by_columns,
            shape,
        }) = dictionary(header)
        else {
            return Err(self.malformed(start, text::quoted(header), "`descr`, `fortran_order` and `shape`"));
        };
        let (rows, columns) = match shape[..] {
            [] => (1, 1),
            [rows] => (rows, 1),
            [rows, columns] => (rows, columns),
            _ => return Ok(Err(format!("an array of {} dimensions", shape.len()))),
        };
        let Some(kind) = kind else {
            return Ok(Err("an array of structures".into()));
        };
        let (order, code) = match kind.as_bytes() {
            [order @ (b'<' | b'>' | b'|' | b'='), code @ ..] => (*order, code),
            code => (b'=', code),
        };
        let entry = match code {
            [b'b' | b'i' | b'u', size @ (b'1' | b'2' | b'4' | b'8')] => usize::from(size - b'0'),
            b"f4" => 4,
            b"f8" => 8,
            [letter @ (b'U' | b'S'), size @ ..] => {
                let size = std::str::from_utf8(size).ok().and_then(|s| s.parse::<usize>().ok());
                let size = size.and_then(|s| s.checked_mul(if *letter == b'U' { 4 } else { 1 }));
                size.ok_or_else(|| self.malformed(start, &kind, "a length of text"))?
            }
            _ => return Ok(Err(format!("entries of the type `{}`", kind.escape_debug()))),
        };
        let stated = rows as u128 * columns as u128 * entry as u128;
        if stated > data.len() as u128 {
            return Err(Error::Oversized {
                file: self.file.into(),
                place: self.place(data_at),
                what: "the number of bytes of the entries",
                stated,
                possible: data.len(),
            });
        }
        if stated < data.len() as u128 {
            return Err(self.malformed(data_at, format!("{} bytes of entries", data.len()), stated));
        }
        // In the order of storage.
        let arrange = |values| {
            Order {
                rows,
                columns,
                by_columns,
            }
            .dense(values)
        };
        let big = order == b'>';
        macro_rules! numbers {
            ($type:ty) => {
                data.as_chunks::<{ size_of::<$type>() }>().0.iter().map(|bytes| {
                    if big {
                        <$type>::from_be_bytes(*bytes)
                    } else {
                        <$type>::from_le_bytes(*bytes)
                    }
                })
            };
        }
        macro_rules! integers {
            ($type:ty) => {
                Order {
                    rows,
                    columns,
                    by_columns,
                }
                .dense(numbers!($type).map(i64::from).collect())
            };
        }
        Ok(Ok(match code {
            b"f4" => Array::Dense(self.finite(data_at, 4, arrange(numbers!(f32).map(f64::from).collect())?)?),
            b"f8" => Array::Dense(self.finite(data_at, 8, arrange(numbers!(f64).collect())?)?),
            b"b1" | b"u1" => Array::Integers(integers!(u8)?),
            b"i1" => Array::Integers(integers!(i8)?),
            b"i2" => Array::Integers(integers!(i16)?),
            b"u2" => Array::Integers(integers!(u16)?),
            b"i4" => Array::Integers(integers!(i32)?),
            b"u4" => Array::Integers(integers!(u32)?),
            b"i8" => Array::Integers(integers!(i64)?),
            b"u8" => {
                let too_large = |v| self.malformed(data_at, v, "an integer of 64 bits with sign");
                let values = numbers!(u64).map(|v| i64::try_from(v).map_err(|_| too_large(v)));
                Array::Integers(
                    Order {
                        rows,
                        columns,
                        by_columns,
                    }
                    .dense(values.collect::<Result<_, _>>()?)?,
                )
            }
            [b'U' | b'S', ..] if shape.len() < 2 => {
                let wide = code[0] == b'U';
                let lines = data
                    .chunks(entry.max(1))
                    .map(|line| if wide { wide_text(line, big) } else { Some(latin(line)) });
                let lines: Option<Vec<String>> = lines.collect();
                let lines = lines.ok_or_else(|| self.malformed(data_at, "numbers that are no characters", "text"))?;
                Array::Text(lines.join("\n"))
            }
            _ => {
                return Ok(Err(format!(
                    "a matrix with entries of the type `{}`",
                    kind.escape_debug()
                )));
            }
        }))
    }

    fn finite(&self, start: usize, size: usize, values: Dense<f64>) -> Result<Dense<f64>, Error> {
        let refused = |v: &f64| !v.is_finite() && !self.measured;
        match values.data().iter().position(refused) {
            None => Ok(values),
            Some(at) => Err(Error::NotFinite {
                file: self.file.into(),
                place: self.place(start + at * size),
                value: values.data()[at],
            }),
        }
    }
}

/// How entries follow one another.
struct Order {
    rows: usize,
    columns: usize,
    by_columns: bool,
}

impl Order {
    fn dense<T: Copy>(&self, values: Vec<T>) -> Result<Dense<T>, Error> {
        if self.by_columns {
            Dense::try_new(self.rows, self.columns, values)
        } else {
            Dense::try_from_rows(self.rows, self.columns, values)
        }
    }
}

/// Text in 32-bit characters, padded with zeros.
fn wide_text(bytes: &[u8], big: bool) -> Option<String> {
    let units = bytes.as_chunks::<4>().0.iter();
    let codes = units.map(|u| {
        if big {
            u32::from_be_bytes(*u)
        } else {
            u32::from_le_bytes(*u)
        }
    });
    let text: String = codes.map(char::from_u32).collect::<Option<_>>()?;
    Some(text.trim_end_matches('\0').into())
}

fn latin(bytes: &[u8]) -> String {
    let text: String = bytes.iter().map(|b| char::from(*b)).collect();
    text.trim_end_matches('\0').into()
}

/// The header: a dictionary as Python writes it.
fn dictionary(text: &[u8]) -> Option<Header> {
    let text = std::str::from_utf8(text).ok()?.trim();
    let mut rest = text.strip_prefix('{')?.strip_suffix('}')?.trim_start();
    let (mut kind, mut by_columns, mut shape) = (None, None, None);
    while !rest.is_empty() {
        let (key, after) = string_literal(rest)?;
        rest = after.trim_start().strip_prefix(':')?.trim_start();
        rest = match key {
            "descr" if rest.starts_with('[') => {
                // A list of fields ends before the next key.
                kind = Some(None);
                rest.split_once("'fortran_order'")
                    .map(|(fields, _)| &rest[fields.len()..])?
            }
            "descr" => {
                let (code, after) = string_literal(rest)?;
                kind = Some(Some(code.to_owned()));
                after
            }
            "fortran_order" => {
                let (value, after) = rest.split_at_checked(if rest.starts_with("True") { 4 } else { 5 })?;
                by_columns = Some(match value {
                    "True" => true,
                    "False" => false,
                    _ => return None,
                });
                after
            }
            "shape" => {
                let (numbers, after) = rest.strip_prefix('(')?.split_once(')')?;
                let sizes = numbers.split(',').map(str::trim).filter(|n| !n.is_empty());
                shape = Some(
                    sizes
                        .map(|n| n.trim_end_matches('L').parse().ok())
                        .collect::<Option<_>>()?,
                );
                after
            }
            _ => return None,
        };
        rest = rest.trim_start();
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    Some(Header {
        kind: kind?,
        by_columns: by_columns?,
        shape: shape?,
    })
}

/// What stands in quotation marks, and what follows.
fn string_literal(text: &str) -> Option<(&str, &str)> {
    let mark = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(mark)
}

const PARTS: [&str; 5] = ["format", "shape", "indptr", "indices", "data"];

/// Puts sparse matrices together from their arrays.
fn sparse_matrices(source: Source<'_>, arrays: &mut BTreeMap<String, Array>) -> Result<(), Error> {
    let prefix = |key: &String| match key.strip_suffix("format") {
        Some(prefix) if prefix.is_empty() || prefix.ends_with('.') => Some(prefix.to_owned()),
        _ => None,
    };
    let prefixes: Vec<String> = arrays.keys().filter_map(prefix).collect();
    for prefix in prefixes {
        let place = Place::Inside {
            part: format!("the sparse matrix `{}`", prefix.escape_debug()),
            byte: 0,
        };
        let of = |part: &str| format!("{prefix}{part}");
        if !matches!(arrays.get(&of("format")), Some(Array::Text(_))) || !arrays.contains_key(&of("shape")) {
            continue;
        }
        if PARTS.iter().any(|part| !arrays.contains_key(&of(part))) {
            return Err(Error::Unsupported {
                file: source.name.into(),
                place,
                found: "a sparse matrix in another format than csr and csc".into(),
                remedy: "convert it with `.tocsr()` before saving",
            });
        }
        let [format, shape, starts, indices, data] = PARTS.map(|part| arrays.remove(&of(part)));
        let sparse = Sparse {
            source,
            place,
            format,
            shape,
            starts,
            indices,
            data,
        };
        // Tells SciPy's arrays and matrices apart.
        arrays.remove(&of("_is_array"));
        let name = if prefix.is_empty() {
            MATRIX
        } else {
            prefix.trim_end_matches('.')
        };
        let matrix = Array::Sparse(sparse.assemble()?);
        if arrays.insert(name.into(), matrix).is_some() {
            return Err(Error::Malformed {
                file: source.name.into(),
                place: Place::Byte(0),
                found: format!("both a full and a sparse `{name}`"),
                expected: "each name once".into(),
            });
        }
    }
    Ok(())
}

/// The arrays of a sparse matrix.
struct Sparse<'a> {
    source: Source<'a>,
    place: Place,
    format: Option<Array>,
    shape: Option<Array>,
    starts: Option<Array>,
    indices: Option<Array>,
    data: Option<Array>,
}

impl Sparse<'_> {
    fn malformed(&self, found: impl std::fmt::Display, expected: impl std::fmt::Display) -> Error {
        Error::Malformed {
            file: self.source.name.into(),
            place: self.place.clone(),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    fn assemble(&self) -> Result<CsMat<f64>, Error> {
        let integers = |array: &Option<Array>, what| match array {
            Some(Array::Integers(m)) => {
                let sizes: Option<Vec<usize>> = m.data().iter().map(|v| usize::try_from(*v).ok()).collect();
                sizes.ok_or_else(|| self.malformed(format!("negative {what}"), "no negative number"))
            }
            _ => Err(self.malformed(format!("{what} that are no integers"), "integers")),
        };
        let by_rows = match &self.format {
            Some(Array::Text(text)) if text == "csr" => true,
            Some(Array::Text(text)) if text == "csc" => false,
            _ => {
                return Err(Error::Unsupported {
                    file: self.source.name.into(),
                    place: self.place.clone(),
                    found: "a sparse matrix in another format than csr and csc".into(),
                    remedy: "convert it with `.tocsr()` before saving",
                });
            }
        };
        let &[rows, columns] = &integers(&self.shape, "sizes")?[..] else {
            return Err(self.malformed("a shape", "the numbers of rows and columns"));
        };
        let real;
        let values = match &self.data {
            Some(Array::Dense(m)) => m.data(),
            Some(Array::Integers(m)) => {
                let exact = |v: &i64| (v.unsigned_abs() <= 1 << f64::MANTISSA_DIGITS).then_some(*v as f64);
                let values: Option<Vec<f64>> = m.data().iter().map(exact).collect();
                real = values.ok_or_else(|| self.malformed("an entry beyond 2^53", "exact numbers"))?;
                &real
            }
            _ => return Err(self.malformed("entries that are no numbers", "numbers")),
        };
        plausible(rows, columns, self.source.bytes.len()).map_err(|(stated, possible)| Error::Oversized {
            file: self.source.name.into(),
            place: self.place.clone(),
            what: "the number of rows or columns",
            stated: stated as u128,
            possible,
        })?;
        let starts = integers(&self.starts, "starts")?;
        let indices = integers(&self.indices, "indices")?;
        let (outer, inner) = if by_rows { (rows, columns) } else { (columns, rows) };
        let ascending = starts.is_sorted() && starts.first() == Some(&0) && starts.last() == Some(&indices.len());
        if starts.len() != outer + 1 || !ascending || indices.len() != values.len() {
            let found = format!(
                "{} starts, {} indices, {} entries",
                starts.len(),
                indices.len(),
                values.len()
            );
            return Err(self.malformed(
                found,
                format!("{} ascending starts for as many indices as entries", outer + 1),
            ));
        }
        let mut entries = Vec::with_capacity(values.len());
        for (line, range) in starts.windows(2).enumerate() {
            for at in range[0]..range[1] {
                let index = indices[at];
                if index >= inner {
                    return Err(Error::OutOfRange {
                        file: self.source.name.into(),
                        place: self.place.clone(),
                        what: "index (from zero)",
                        index: index as i128,
                        first: 0,
                        last: inner.saturating_sub(1),
                    });
                }
                let (row, column) = if by_rows { (line, index) } else { (index, line) };
                entries.push(Entry {
                    row,
                    column,
                    value: values[at],
                    line: at,
                });
            }
        }
        let matrix = triplets::summed((rows, columns), entries);
        match matrix.data().iter().find(|v| !v.is_finite()) {
            None => Ok(matrix),
            Some(&value) => Err(Error::NotFinite {
                file: self.source.name.into(),
                place: self.place.clone(),
                value,
            }),
        }
    }
}

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
