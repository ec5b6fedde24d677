//! The evaluation of a batch of points.

use core::ffi::c_char;
use core::mem::MaybeUninit;
use core::ops::Range;
use core::ptr;
use core::slice;

use contact_laws::{Components, ComponentsMut, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut};

use crate::boundary::{CHUNK, Error, Message, Region, SCRATCH, array, check, guarded};
use crate::choice::choice;
use crate::{
    CL_ERROR, CL_INVALID_POINTS, CL_REGIME_INVALID, CL_REGIME_OPEN, CL_REGIME_SLIP, CL_REGIME_STICK, CL_SUCCESS, Law,
};

/// Number of points in each regime.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// In contact below the slip limit.
    pub stick: usize,
    /// In contact at the slip limit.
    pub slip: usize,
    /// No contact.
    pub open: usize,
    /// Input that is not finite.
    pub invalid: usize,
}

impl From<RegimeCounts> for Counts {
    fn from(counts: RegimeCounts) -> Self {
        let RegimeCounts {
            stick,
            slip,
            open,
            invalid,
        } = counts;
        Self {
            stick,
            slip,
            open,
            invalid,
        }
    }
}

/// Tractions, end state and, on request, tangent and regimes of the points first, ..., first + count - 1 of a law.
/// Entry i of every array belongs to point first + i. Allocates nothing.
///
/// - sticking: one of CL_STICKING_...
/// - jump_x, jump_y, jump_n: jump (m), count numbers each; jump_n > 0 is interference, the gap already subtracted.
/// - begin: state committed last, component by component: component c of point first + i is begin[c * stride + i].
///   It reaches over (cl_law_n_state(law) - 1) * stride + count numbers. All zeros is a point that touches nothing.
/// - end: state reached, stored alike. It may be the same array as begin.
/// - stride: at least count. For a block of all points, pass block + first and the number of points of the block.
/// - traction_x, traction_y, traction_n: tractions (Pa), count numbers each, to be written.
/// - tangent: NULL, or nine arrays of count numbers each, to be written (Pa/m), in the order xx, xy, xn, yx, yy, yn,
///   nx, ny, nn, where xn is the derivative of traction_x with respect to jump_n.
/// - regimes: NULL, or count codes CL_REGIME_... to be written.
/// - counts: NULL, or where the number of points in each regime is written.
/// - message: NULL, or a buffer of message_capacity bytes that receives the reason of a refusal, ended by a zero.
///
/// Returns
/// - CL_SUCCESS (1): computed;
/// - CL_INVALID_POINTS (0): computed, but the jump or begin state of some points was not finite: their tractions and
///   tangents are NaN, their end state must not be committed; counts and regimes say which;
/// - CL_ERROR (-1): refused; nothing was written but the message. NULL or misaligned pointers, points that the law does
///   not have, a stride below count, sizes beyond the memory, unknown codes, or two arrays that overlap of which one is
///   written (the message is one of them; it is not written then). Two exceptions: begin may be end, and components of
///   states may lie between those of other arrays.
///
/// # Safety
/// The law is NULL or not yet freed. Pointers that are not NULL have the lengths stated. During the call nobody else
/// writes to what is read, or reads or writes what is written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_evaluate(
    law: *const Law,
    first: usize,
    count: usize,
    sticking: i32,
    jump_x: *const f64,
    jump_y: *const f64,
    jump_n: *const f64,
    begin: *const f64,
    end: *mut f64,
    stride: usize,
    traction_x: *mut f64,
    traction_y: *mut f64,
    traction_n: *mut f64,
    tangent: *const *mut f64,
    regimes: *mut i32,
    counts: *mut Counts,
    message: *mut c_char,
    message_capacity: usize,
) -> i32 {
    let message = Message::new(message, message_capacity);
    let body = || {
        // SAFETY: the caller vouches for the law and for nine pointers in `tangent`.
        let (law, pointers) = unsafe { (&array(message, "law", law, 1)?[0], tangent_pointers(tangent)?) };
        let batch = Batch {
            law,
            points: points(law, first, count)?,
            sticking: choice("sticking", sticking)?,
            jump: [jump_x, jump_y, jump_n],
            begin,
            end,
            stride,
            traction: [traction_x, traction_y, traction_n],
            tangent: pointers,
            tangent_table: tangent,
            regimes: if regimes.is_null() { None } else { Some(regimes) },
            counts: if counts.is_null() { None } else { Some(counts) },
            message,
        };
        batch.check()?;
        // SAFETY: checked; lengths and exclusive use are the caller's promise.
        let found = unsafe { batch.run() };
        if let Some(counts) = batch.counts {
            // SAFETY: neither NULL nor misaligned, and the caller vouches that it may be written.
            unsafe { counts.write(found.into()) };
        }
        Ok(if found.invalid > 0 {
            CL_INVALID_POINTS
        } else {
            CL_SUCCESS
        })
    };
    // SAFETY: the caller vouches for the message buffer.
    unsafe { guarded(message, body) }.unwrap_or(CL_ERROR)
}

/// # Safety
/// `tangent` is NULL, misaligned or points to nine pointers.
unsafe fn tangent_pointers(tangent: *const *mut f64) -> Result<Option<[*mut f64; 9]>, Error> {
    if tangent.is_null() {
        return Ok(None);
    }
    check("tangent", tangent, 9)?;
    // SAFETY: neither NULL nor misaligned, and the caller vouches for the nine.
    Ok(Some(unsafe { tangent.cast::<[*mut f64; 9]>().read() }))
}

fn points(law: &Law, first: usize, count: usize) -> Result<Range<usize>, Error> {
    let n_points = law.law.len();
    match first.checked_add(count) {
        Some(end) if end <= n_points => Ok(first..end),
        _ => Err(Error::Points { first, count, n_points }),
    }
}

/// A call, its pointers not yet followed.
struct Batch<'a> {
    law: &'a Law,
    points: Range<usize>,
    sticking: Sticking,
    jump: [*const f64; 3],
    begin: *const f64,
    end: *mut f64,
    stride: usize,
    traction: [*mut f64; 3],
    tangent: Option<[*mut f64; 9]>,
    /// Where the nine pointers of `tangent` stand.
    tangent_table: *const *mut f64,
    regimes: Option<*mut i32>,
    counts: Option<*mut Counts>,
    message: Message,
}

const JUMP: [&str; 3] = ["jump_x", "jump_y", "jump_n"];
const TRACTION: [&str; 3] = ["traction_x", "traction_y", "traction_n"];
const TANGENT: [&str; 9] = [
    "tangent[0] (xx)",
    "tangent[1] (xy)",
    "tangent[2] (xn)",
    "tangent[3] (yx)",
    "tangent[4] (yy)",
    "tangent[5] (yn)",
    "tangent[6] (nx)",
    "tangent[7] (ny)",
    "tangent[8] (nn)",
];

/// The arrays of a call, those that are read before those that are written.
struct Regions {
    all: [Region; 21],
    len: usize,
}

impl Regions {
    fn push(&mut self, region: Region) {
        self.all[self.len] = region;
        self.len += 1;
    }

    /// Checks the array and notes it.
    fn add<T>(&mut self, argument: &'static str, pointer: *const T, len: usize) -> Result<(), Error> {
        check(argument, pointer, len)?;
        self.push(Region::new(argument, pointer, len));
        Ok(())
    }
}

impl Batch<'_> {
    /// Refuses everything that can be seen to be wrong before a pointer is followed. No point needs no array.
    fn check(&self) -> Result<(), Error> {
        let (count, stride) = (self.points.len(), self.stride);
        let mut regions = Regions {
            all: [Region::new("", ptr::null::<u8>(), 0); 21],
            len: 0,
        };
        if self.tangent.is_some() {
            regions.add("tangent", self.tangent_table, TANGENT.len())?;
        }
        if count == 0 {
            return self.check_written(regions, None);
        }
        if stride < count {
            return Err(Error::Stride { stride, count });
        }
        let n_state = self.law.state.len();
        let span = (n_state - 1).checked_mul(stride).and_then(|n| n.checked_add(count));
        let span = span.ok_or(Error::TooLong { argument: "stride" })?;
        check("begin", self.begin, span)?;
        check("end", self.end.cast_const(), span)?;
        for (name, jump) in JUMP.iter().zip(self.jump) {
            regions.add(name, jump, count)?;
        }
        let states = [("begin", self.begin), ("end", self.end.cast_const())];
        let states = states.map(|(name, state)| Region::strided(name, state, count, stride, n_state));
        self.check_written(regions, Some(states))
    }

    /// Adds what is written to the arrays that are read, and compares all pairs but those of arrays that are only read.
    fn check_written(&self, mut regions: Regions, states: Option<[Region; 2]>) -> Result<(), Error> {
        let mut n_read = regions.len;
        if let Some([begin, end]) = states {
            regions.push(begin);
            n_read += 1;
            // Updated in place, the state is one array, which is written.
            if self.begin == self.end.cast_const() {
                n_read -= 1;
            } else {
                regions.push(end);
            }
            let count = self.points.len();
            for (name, traction) in TRACTION.iter().zip(self.traction) {
                regions.add(name, traction.cast_const(), count)?;
            }
            for (name, entry) in TANGENT.iter().zip(self.tangent.iter().flatten()) {
                regions.add(name, entry.cast_const(), count)?;
            }
            if let Some(regimes) = self.regimes {
                regions.add("regimes", regimes.cast_const(), count)?;
            }
        }
        if let Some(counts) = self.counts {
            regions.add("counts", counts.cast_const(), 1)?;
        }
        regions.push(self.message.region());
        let regions = &regions.all[..regions.len];
        // Where the message is part of two overlaps, it must not tell of another first.
        for (i, written) in regions.iter().enumerate().skip(n_read).rev() {
            regions[..i].iter().try_for_each(|other| other.apart_from(written))?;
        }
        Ok(())
    }

    /// The evaluation, chunk by chunk. The states pass through memory of our own: a block's other points, between the
    /// components of ours, may be in use by other threads, and no slice may reach over them; and `begin` may be `end`.
    ///
    /// # Safety
    /// `check` has passed, the arrays have the lengths that it assumes, and nobody else uses them in a way that the
    /// interface forbids.
    unsafe fn run(&self) -> RegimeCounts {
        let n_state = self.law.state.len();
        let largest = (SCRATCH / n_state).min(CHUNK);
        let mut begin_scratch = [const { MaybeUninit::<f64>::uninit() }; SCRATCH];
        let mut end_scratch = [const { MaybeUninit::<f64>::uninit() }; SCRATCH];
        let mut regimes = [Regime::Open; CHUNK];
        let mut counts = RegimeCounts::default();
        let mut done = 0;
        while done < self.points.len() {
            let n = largest.min(self.points.len() - done);
            let begin = &mut begin_scratch[..n_state * n];
            for (c, component) in begin.chunks_exact_mut(n).enumerate() {
                // SAFETY: entry `c * stride + done + n - 1` is within the span checked, and the scratch memory is ours.
                unsafe {
                    let source = self.begin.add(c * self.stride + done);
                    ptr::copy_nonoverlapping(source, component.as_mut_ptr().cast::<f64>(), n);
                }
            }
            let end = &mut end_scratch[..n_state * n];
            for value in end.iter_mut() {
                value.write(0.0);
            }
            // SAFETY: both were just filled.
            let (begin, end) = unsafe { (begin.assume_init_ref(), end.assume_init_mut()) };
            // SAFETY: `done + n` is at most the number of points, and the arrays that are written overlap no other.
            let (jump, traction, tangent) = unsafe {
                let [x, y, n_] = self.jump.map(|p| slice::from_raw_parts(p.add(done), n));
                let written = |p: *mut f64| slice::from_raw_parts_mut(p.add(done), n);
                let [tx, ty, tn] = self.traction.map(written);
                let tangent = self.tangent.map(|pointers| pointers.map(written));
                (Components::new(x, y, n_), ComponentsMut::new(tx, ty, tn), tangent)
            };
            let first = self.points.start + done;
            counts += self.law.law.evaluate(
                first..first + n,
                self.sticking,
                jump,
                StateView::new(begin, n, 0),
                StateViewMut::new(end, n, 0),
                traction,
                tangent.map(TangentMut::from_entries),
                self.regimes.is_some().then_some(&mut regimes[..n]),
            );
            for (c, component) in end_scratch[..n_state * n].chunks_exact(n).enumerate() {
                // SAFETY: as for `begin`; the slices made above are no longer used.
                unsafe {
                    let target = self.end.add(c * self.stride + done);
                    ptr::copy_nonoverlapping(component.as_ptr().cast::<f64>(), target, n);
                }
            }
            if let Some(codes) = self.regimes {
                for (i, &regime) in regimes[..n].iter().enumerate() {
                    // SAFETY: within the `count` entries checked.
                    unsafe { codes.add(done + i).write(code(regime)) };
                }
            }
            done += n;
        }
        counts
    }
}

fn code(regime: Regime) -> i32 {
    match regime {
        Regime::Stick => CL_REGIME_STICK,
        Regime::Slip => CL_REGIME_SLIP,
        Regime::Open => CL_REGIME_OPEN,
        Regime::Invalid => CL_REGIME_INVALID,
    }
}
