//! What stands between a caller in C and the laws: checks of pointers and codes, messages, and the stop for panics.

use core::ffi::c_char;
use core::fmt::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Why a call was refused.
#[derive(Debug)]
pub(crate) enum Error {
    Null {
        argument: &'static str,
    },
    Misaligned {
        argument: &'static str,
        bytes: usize,
    },
    /// More bytes than memory has.
    TooLong {
        argument: &'static str,
    },
    Overlap {
        arguments: [&'static str; 2],
    },
    NoPoints,
    TooManyPoints {
        n_points: usize,
    },
    Sets {
        argument: &'static str,
        n_sets: usize,
        n_points: usize,
    },
    Points {
        first: usize,
        count: usize,
        n_points: usize,
    },
    Stride {
        stride: usize,
        count: usize,
    },
    /// More state components per point than an evaluation has room for.
    State {
        n_state: usize,
        most: usize,
    },
    Code {
        argument: &'static str,
        code: i32,
        /// Writes the codes that there are.
        allowed: fn(&mut fmt::Formatter<'_>) -> fmt::Result,
    },
    Parameters {
        set: usize,
        error: contact_laws::Error,
    },
    Law(contact_laws::Error),
}

impl From<contact_laws::Error> for Error {
    fn from(error: contact_laws::Error) -> Self {
        Self::Law(error)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Null { argument } => write!(f, "{argument} is NULL"),
            Error::Misaligned { argument, bytes } => {
                write!(
                    f,
                    "{argument} is not aligned to {bytes} bytes: it is not an array of its type"
                )
            }
            Error::TooLong { argument } => {
                write!(
                    f,
                    "{argument} would reach beyond the memory: check the numbers of entries and the stride"
                )
            }
            Error::Overlap { arguments: [a, b] } => write!(f, "{a} and {b} overlap: give arrays of their own"),
            Error::NoPoints => write!(f, "n_points = 0: a law needs at least one point"),
            Error::TooManyPoints { n_points } => {
                write!(
                    f,
                    "n_points = {n_points}: at most {} fit in a law, make several",
                    u32::MAX
                )
            }
            Error::Sets {
                argument,
                n_sets,
                n_points,
            } => write!(
                f,
                "{argument} = {n_sets}: must be 1 or the number of points, {n_points}"
            ),
            Error::Points { first, count, n_points } => write!(
                f,
                "{count} points from point {first} on: the law has {n_points} points, counted from 0"
            ),
            Error::Stride { stride, count } => write!(
                f,
                "stride = {stride}: must be at least the {count} points of the call, it is the distance between the \
                 state components of a point"
            ),
            Error::State { n_state, most } => write!(
                f,
                "the law has {n_state} state components per point: at most {most} fit, take fewer bins or radii"
            ),
            Error::Code {
                argument,
                code,
                allowed,
            } => {
                write!(f, "{argument} = {code}: must be ")?;
                allowed(f)
            }
            Error::Parameters { set, error } => write!(f, "parameter set {set} (counted from 0): {error}"),
            Error::Law(error) => error.fmt(f),
        }
    }
}

/// The caller's buffer for a message.
#[derive(Clone, Copy)]
pub(crate) struct Message {
    bytes: *mut c_char,
    /// Zero where there is no buffer.
    len: usize,
}

impl Message {
    pub(crate) const NAME: &str = "message";

    pub(crate) fn new(bytes: *mut c_char, capacity: usize) -> Self {
        let len = if bytes.is_null() { 0 } else { capacity.min(MOST_BYTES) };
        Self { bytes, len }
    }

    /// The bytes that a message may be written to.
    pub(crate) fn region(&self) -> Region {
        Region::new(Self::NAME, self.bytes, self.len)
    }
}

/// The bytes of an argument: `pieces` times `width`, one every `stride` bytes.
#[derive(Clone, Copy)]
pub(crate) struct Region {
    argument: &'static str,
    start: usize,
    width: usize,
    stride: usize,
    pieces: usize,
}

impl Region {
    /// `len` entries, which [`check`] found to fit in memory.
    pub(crate) fn new<T>(argument: &'static str, pointer: *const T, len: usize) -> Self {
        Self::strided(argument, pointer, len, len, 1)
    }

    /// `pieces` times `len` entries, one piece every `stride` entries.
    pub(crate) fn strided<T>(
        argument: &'static str,
        pointer: *const T,
        len: usize,
        stride: usize,
        pieces: usize,
    ) -> Self {
        Self {
            argument,
            start: pointer.addr(),
            width: len * size_of::<T>(),
            stride: stride * size_of::<T>(),
            pieces,
        }
    }

    fn starts(&self) -> impl Iterator<Item = usize> {
        (0..self.pieces).map(|piece| self.start + piece * self.stride)
    }

    fn span(&self) -> usize {
        (self.pieces - 1) * self.stride + self.width
    }

    /// Refuses a common byte.
    pub(crate) fn apart_from(&self, other: &Self) -> Result<(), Error> {
        let meet = |a: usize, n_a: usize, b: usize, n_b: usize| n_a > 0 && n_b > 0 && a < b + n_b && b < a + n_a;
        // Pieces of two arrays may lie in turn.
        let common = meet(self.start, self.span(), other.start, other.span())
            && self
                .starts()
                .any(|a| other.starts().any(|b| meet(a, self.width, b, other.width)));
        if common {
            let arguments = [self.argument, other.argument];
            return Err(Error::Overlap { arguments });
        }
        Ok(())
    }
}

/// Runs the body of an exported function. A refusal or a panic becomes a message in the caller's buffer and `None`.
/// Nothing is written to a buffer that overlaps an array.
///
/// # Safety
/// The message has no bytes, or as many that may be written.
pub(crate) unsafe fn guarded<T>(message: Message, body: impl FnOnce() -> Result<T, Error>) -> Option<T> {
    // Whatever the body was doing when it panicked is dropped or belongs to the caller, who is told.
    let refusal = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(value)) => return Some(value),
        Ok(Err(Error::Overlap { arguments })) if arguments.contains(&Message::NAME) => return None,
        Ok(Err(error)) => Refusal::Error(error),
        Err(payload) => Refusal::Panic(match payload.downcast::<String>() {
            Ok(text) => *text,
            Err(other) => other
                .downcast::<&str>()
                .map_or("no message".into(), |text| (*text).into()),
        }),
    };
    if message.len > 0 {
        // SAFETY: neither NULL nor of no length, and the caller of this function vouches for the bytes.
        let bytes = unsafe { core::slice::from_raw_parts_mut(message.bytes.cast::<u8>(), message.len) };
        write_message(bytes, &refusal);
    }
    None
}

/// Longest message, so that no capacity, however wrong, makes a slice larger than any memory.
const MOST_BYTES: usize = 4096;

enum Refusal {
    Error(Error),
    Panic(String),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Error(error) => error.fmt(f),
            Refusal::Panic(text) => write!(f, "defect in contact-laws, results may be incomplete: {text}"),
        }
    }
}

/// As much of the text as fits, ended by a zero.
fn write_message(bytes: &mut [u8], text: &impl fmt::Display) {
    let Some((end, room)) = bytes.split_last_mut() else {
        return;
    };
    let mut cursor = Cursor { room, used: 0 };
    // An error says only that the buffer is full.
    let _ = write!(cursor, "{text}");
    let Cursor { room, used } = cursor;
    *room.get_mut(used).unwrap_or(end) = 0;
}

struct Cursor<'a> {
    room: &'a mut [u8],
    used: usize,
}

impl Write for Cursor<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let left = &mut self.room[self.used..];
        let n = text.floor_char_boundary(left.len());
        left[..n].copy_from_slice(&text.as_bytes()[..n]);
        self.used += n;
        if n < text.len() { Err(fmt::Error) } else { Ok(()) }
    }
}

/// Whether an array of `len` entries can begin at `pointer`.
pub(crate) fn check<T>(argument: &'static str, pointer: *const T, len: usize) -> Result<(), Error> {
    if pointer.is_null() {
        return Err(Error::Null { argument });
    }
    if !pointer.is_aligned() {
        return Err(Error::Misaligned {
            argument,
            bytes: align_of::<T>(),
        });
    }
    let fits = len
        .checked_mul(size_of::<T>())
        .is_some_and(|bytes| bytes <= isize::MAX as usize && pointer.addr().checked_add(bytes).is_some());
    if fits { Ok(()) } else { Err(Error::TooLong { argument }) }
}

/// The caller's `len` numbers at `pointer`, which no message may be written over.
///
/// # Safety
/// If `pointer` is neither NULL nor misaligned, `len` entries can be read there and nobody writes to them during `'a`.
pub(crate) unsafe fn array<'a, T>(
    message: Message,
    argument: &'static str,
    pointer: *const T,
    len: usize,
) -> Result<&'a [T], Error> {
    check(argument, pointer, len)?;
    Region::new(argument, pointer, len).apart_from(&message.region())?;
    // SAFETY: not NULL, aligned, no longer than memory; the rest is the caller's promise.
    Ok(unsafe { core::slice::from_raw_parts(pointer, len) })
}

/// The caller's `rows` times `len` numbers at `pointer`, row by row.
///
/// # Safety
/// As for [`array`], with `rows * len` entries.
pub(crate) unsafe fn rows<'a, const ROWS: usize>(
    message: Message,
    argument: &'static str,
    pointer: *const f64,
    len: usize,
) -> Result<[&'a [f64]; ROWS], Error> {
    let total = ROWS.checked_mul(len).ok_or(Error::TooLong { argument })?;
    // SAFETY: the caller's promise.
    let all = unsafe { array(message, argument, pointer, total) }?;
    Ok(core::array::from_fn(|row| &all[row * len..][..len]))
}

/// Points evaluated at a time, and room for their states.
pub(crate) const CHUNK: usize = 128;
pub(crate) const SCRATCH: usize = 16 * CHUNK;

/// Refuses a law if the states of one point do not fit into the scratch memory.
pub(crate) fn require_state_fits(n_state: usize) -> Result<(), Error> {
    match n_state {
        1..=SCRATCH => Ok(()),
        _ => Err(Error::State { n_state, most: SCRATCH }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_cut_between_characters_and_always_ended() {
        for (capacity, expected) in [(1, &b"\0"[..]), (2, b"a\0"), (3, b"a\0"), (4, "aß\0".as_bytes())] {
            let mut bytes = vec![b'#'; capacity];
            write_message(&mut bytes, &"aßcd");
            assert_eq!(&bytes[..expected.len()], expected, "{capacity}");
        }
        let mut bytes = [b'#'; 8];
        write_message(&mut bytes, &"abc");
        assert_eq!(&bytes, b"abc\0####");
    }

    #[test]
    fn arrays_that_cannot_be_are_refused() {
        let numbers = [0.0_f64; 4];
        let inside = numbers.as_ptr().cast::<u8>().wrapping_add(1).cast::<f64>();
        let text = |result: Result<(), Error>| result.unwrap_err().to_string();
        assert_eq!(text(check::<f64>("a", core::ptr::null(), 1)), "a is NULL");
        assert!(text(check("a", inside, 1)).contains("aligned to 8"));
        for len in [usize::MAX, usize::MAX / 8, isize::MAX as usize / 8 + 1] {
            assert!(
                text(check("a", numbers.as_ptr(), len)).contains("beyond the memory"),
                "{len}"
            );
        }
        let top = core::ptr::without_provenance::<f64>(usize::MAX - 7);
        assert!(text(check("a", top, 1)).contains("beyond the memory"));
        assert!(check("a", numbers.as_ptr(), 4).is_ok());
    }

    #[test]
    fn panics_become_messages() {
        let mut bytes = [0_u8; 200];
        // SAFETY: the buffer has the length given.
        let outcome = unsafe {
            guarded(
                Message::new(bytes.as_mut_ptr().cast(), bytes.len()),
                || -> Result<(), Error> { panic!("number {}", 7) },
            )
        };
        assert!(outcome.is_none());
        let text = core::ffi::CStr::from_bytes_until_nul(&bytes).unwrap().to_str().unwrap();
        assert!(text.contains("defect") && text.ends_with("number 7"), "{text}");
    }
}
