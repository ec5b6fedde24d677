//! Assembled matrices of Ansys (`.full`).
//!
//! Layout: *Ansys Mechanical APDL Programmer's Reference*, "Format of the FULL file" (`fdfull.inc`), symbolic assembly. A
//! record is its number of words (of four bytes), a word of flags, the words, and their number again. The file has a standard
//! head, the head of this format, the degrees of freedom of the model and the numbers of the nodes in the order of the
//! equations; the second head points to the rest. A matrix has two records for each equation: the columns of the upper
//! triangle from one, the diagonal last, and the entries. Records with many zeros or equal numbers may have them in short.

use std::path::Path;

use crate::Error;
use crate::columns::Position;
use crate::triplets::{self, Entry, Origin};
use crate::value::{Assembled, Dof};
use file_io::{Place, Source};

/// Bytes of a word.
const WORD: usize = 4;

/// Flags of a record: numbers of single precision, packed (zlib), in short form by windows or by the bits of a word.
const SINGLE: u32 = 1 << 30;
const PACKED: u32 = 1 << 29;
const BY_WINDOWS: u32 = 1 << 28;
const BY_BITS: u32 = 1 << 27;
const BITS: usize = 32;

/// Numbers of this format and of superelements in the standard head.
const FULL: i32 = 4;
const SUPERELEMENT: i32 = 8;

/// Highest degree of freedom that is a displacement or a rotation.
const COMPONENTS: i32 = 6;

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Assembled, Error> {
    crate::text::read(path, parse)
}

/// Reads stiffness, and mass and damping where they are there. Degrees of freedom that the model holds are left out, and
/// so are the loads.
///
/// # Errors
/// [`Error::Unsupported`] for files of superelements, of one process of several, compressed ones, and for matrices that are
/// unsymmetric, lumped, scaled, with constraint equations or for other than displacements and rotations;
/// [`Error::Malformed`], [`Error::Oversized`], [`Error::OutOfRange`], [`Error::Duplicate`], [`Error::NotFinite`].
pub fn parse(source: Source<'_>) -> Result<Assembled, Error> {
    let mut reader = Reader { source, at: 0 };
    let standard = reader.integers(Length::Any)?;
    match standard.first() {
        Some(&FULL) => {}
        Some(&SUPERELEMENT) => {
            return Err(reader.unsupported(
                "a file of a superelement",
                "read it in Ansys by *SMAT or *DMAT, and write its matrices by *EXPORT as Matrix Market files",
            ));
        }
        other => {
            return Err(reader.malformed(
                format!("the number {}", other.copied().unwrap_or(0)),
                "4, which is that of a file FULL",
            ));
        }
    }
    let head = Head(reader.integers(Length::Any)?);
    for (is_there, found, remedy) in [
        (
            head.at(0) != -FULL,
            "a matrix of the frontal solver",
            "write it by the sparse solver (EQSLV,SPARSE)",
        ),
        (head.at(10) != 0, "a lumped mass", "write a consistent one (LUMPM,OFF)"),
        (
            head.at(13) != 0,
            "an unsymmetric matrix",
            "leave out what makes it so, such as friction (NROPT,FULL)",
        ),
        (
            head.at(20) != 0,
            "a model with constraint equations",
            "couple its parts by nodes in common, or by contact here",
        ),
        (
            head.at(62) != 0,
            "the file of one process of several",
            "join them by COMBINE,FULL",
        ),
    ] {
        if is_there {
            return Err(reader.unsupported(found, remedy));
        }
    }
    let n = head.count(1);
    reader.check_size("the number of equations", n, source.bytes.len())?;
    let _kinds = reader.integers(Length::Any)?;
    let n_nodes = head.count(32);
    let nodes = reader.integers(Length::Exactly(n_nodes))?;

    reader.at = head.pointer(35);
    let per_node = reader.integers(Length::Exactly(n_nodes))?;
    let components = reader.integers(Length::Exactly(n))?;
    let labels = nodes.iter().zip(&per_node);
    let mut labels = labels.flat_map(|(node, count)| (0..*count).map(move |_| *node));
    let (mut dofs, mut places) = (Vec::new(), vec![None; n]);
    for (place, component) in places.iter_mut().zip(&components) {
        let node = labels.next().filter(|node| *node > 0);
        let node = node.ok_or_else(|| reader.malformed(format!("{n} equations"), "nodes for all of them"))?;
        if !(1..=COMPONENTS).contains(&component.abs()) {
            let found = format!("the degree of freedom {} of node {node}", component.abs());
            return Err(reader.unsupported(found, "write a model with displacements and rotations alone"));
        }
        // Those that are held are negative.
        if *component > 0 {
            *place = Some(dofs.len());
            dofs.push(Dof::new(node.into(), component.unsigned_abs()));
        }
    }
    if labels.next().is_some() {
        return Err(reader.malformed("more degrees of freedom at nodes", format!("{n}, as many as equations")));
    }
    let scale = head.pointer(59);
    if scale > 0 {
        reader.at = scale;
        if reader.reals(n)?.iter().any(|factor| *factor != 1.0) {
            return Err(reader.unsupported("a scaled matrix", "write it without scaling"));
        }
    }
    let mut found = Assembled {
        dofs,
        matrices: Default::default(),
    };
    for (name, terms, pointer) in [
        (Assembled::STIFFNESS, [8, 9], 18),
        (Assembled::MASS, [33, 21], 26),
        (Assembled::DAMPING, [34, 39], 28),
    ] {
        if terms.map(|index| head.at(index)) != [0, 0] {
            reader.at = head.pointer(pointer);
            let entries = reader.matrix(&places)?;
            let origin = Origin {
                file: source.name,
                place: Place::Byte,
            };
            let matrix = triplets::symmetric(origin, found.dofs.len(), entries, false)?;
            found.matrices.insert(name.into(), matrix);
        }
    }
    Ok(found)
}

/// The numbers of the second head.
struct Head(Vec<i32>);

impl Head {
    /// Numbers that older versions of the format lack are zero.
    fn at(&self, index: usize) -> i32 {
        self.0.get(index).copied().unwrap_or(0)
    }

    /// A number that is not negative.
    fn count(&self, index: usize) -> usize {
        usize::try_from(self.at(index)).unwrap_or(0)
    }

    /// A byte, from words stated in two halves.
    fn pointer(&self, index: usize) -> usize {
        let [low, high] = [self.at(index), self.at(index + 1)].map(|half| u64::from(half.cast_unsigned()));
        usize::try_from(high << 32 | low).map_or(usize::MAX, |words| words.saturating_mul(WORD))
    }
}

/// Numbers that a record must have.
#[derive(Clone, Copy)]
enum Length {
    Any,
    Exactly(usize),
}

struct Reader<'a> {
    source: Source<'a>,
    at: usize,
}

impl Reader<'_> {
    /// The entries of the upper triangle among the degrees of freedom that are not held.
    fn matrix(&mut self, places: &[Option<usize>]) -> Result<Vec<Entry>, Error> {
        let mut entries = Vec::new();
        for row in places {
            let at = self.at;
            let columns = self.integers(Length::Any)?;
            let values = self.reals(columns.len())?;
            for (column, value) in columns.into_iter().zip(values) {
                let index = usize::try_from(column).ok().and_then(|column| column.checked_sub(1));
                let column = index
                    .and_then(|index| places.get(index))
                    .ok_or_else(|| Error::OutOfRange {
                        file: self.source.name.into(),
                        place: Place::Byte(at),
                        what: "column",
                        index: column.into(),
                        first: 1,
                        last: places.len(),
                    })?;
                if let (Some(row), Some(column)) = (*row, *column) {
                    entries.push(Entry { row, column, value, at });
                }
            }
        }
        Ok(entries)
    }

    fn integers(&mut self, length: Length) -> Result<Vec<i32>, Error> {
        self.numbers(length, i32::from_le_bytes)
    }

    fn reals(&mut self, count: usize) -> Result<Vec<f64>, Error> {
        let at = self.at;
        let values = self.numbers(Length::Exactly(count), f64::from_le_bytes)?;
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(Error::NotFinite {
                file: self.source.name.into(),
                place: Place::Byte(at),
                value: *value,
            }),
            None => Ok(values),
        }
    }

    /// The numbers of a record, of `SIZE` bytes each.
    fn numbers<const SIZE: usize, T: Copy + Default>(
        &mut self,
        length: Length,
        number: fn([u8; SIZE]) -> T,
    ) -> Result<Vec<T>, Error> {
        let stated = self.word(self.at)?;
        let flags = self.word(self.at.saturating_add(WORD))?.cast_unsigned();
        let start = self.at + 2 * WORD;
        let possible = (self.source.bytes.len() - start) / WORD;
        let words = usize::try_from(stated).ok().filter(|words| *words <= possible);
        let words = words.ok_or_else(|| {
            self.oversized(
                "the number of words of a record",
                stated.unsigned_abs().into(),
                possible,
            )
        })?;
        let end = start + words * WORD;
        if self.word(end)? != stated {
            return Err(self.malformed(format!("a record of {words} words"), "their number at its end"));
        }
        if flags & (SINGLE | PACKED) != 0 {
            return Err(self.unsupported("a packed record", "write the file without compression (/FCOMP,FULL,0)"));
        }
        // What a record in short form stands for must be known from elsewhere, or a few bytes could demand any memory.
        let most = match length {
            Length::Exactly(count) => count,
            Length::Any => words.max(BITS),
        };
        let contents = &self.source.bytes[start..end];
        let found = if flags & (BY_BITS | BY_WINDOWS) == 0 {
            let (chunks, rest) = contents.as_chunks::<SIZE>();
            rest.is_empty()
                .then(|| chunks.iter().map(|chunk| number(*chunk)).collect())
        } else {
            expand(flags, contents, most, number)
        };
        let found: Vec<T> = found.ok_or_else(|| self.malformed("a record that breaks off", "all of its numbers"))?;
        match length {
            Length::Exactly(count) if count != found.len() => {
                Err(self.malformed(format!("a record of {} numbers", found.len()), count))
            }
            _ => {
                self.at = end + WORD;
                Ok(found)
            }
        }
    }

    fn word(&self, at: usize) -> Result<i32, Error> {
        let bytes = self.source.bytes.get(at..).and_then(<[u8]>::first_chunk::<WORD>);
        let bytes = bytes.ok_or_else(|| self.malformed("the end of the file", "more bytes"))?;
        Ok(i32::from_le_bytes(*bytes))
    }
}

impl Position for Reader<'_> {
    fn file(&self) -> &str {
        self.source.name
    }

    fn place(&self) -> Place {
        Place::Byte(self.at)
    }
}

/// The at most so many numbers of a record in short form: their number, then bits for those that are not zero, or the
/// number of windows. A window is a place and a number, or the negative of a place, a length and numbers; if the length is
/// negative, one number stands for all.
fn expand<const SIZE: usize, T: Copy + Default>(
    flags: u32,
    contents: &[u8],
    most: usize,
    number: fn([u8; SIZE]) -> T,
) -> Option<Vec<T>> {
    let mut left = contents;
    let count = take(&mut left).map(i32::from_le_bytes)?;
    let second = take(&mut left).map(i32::from_le_bytes)?;
    let count = usize::try_from(count).ok().filter(|count| *count <= most)?;
    let mut values = vec![T::default(); count];
    if flags & BY_BITS != 0 {
        for (place, value) in values.iter_mut().take(BITS).enumerate() {
            if second.cast_unsigned() >> place & 1 == 1 {
                *value = number(take(&mut left)?);
            }
        }
        return Some(values);
    }
    for _ in 0..second {
        let place = take(&mut left).map(i32::from_le_bytes)?;
        let length = match place {
            1.. => 1,
            _ => take(&mut left).map(i32::from_le_bytes)?,
        };
        let window = values.get_mut(place.unsigned_abs() as usize..)?;
        let window = window.get_mut(..length.unsigned_abs() as usize)?;
        if length < 0 {
            window.fill(number(take(&mut left)?));
        } else {
            for value in window {
                *value = number(take(&mut left)?);
            }
        }
    }
    Some(values)
}

fn take<const N: usize>(left: &mut &[u8]) -> Option<[u8; N]> {
    let (bytes, rest) = left.split_first_chunk::<N>()?;
    *left = rest;
    Some(*bytes)
}
