//! C interface of `contact-laws`: traction laws at points, for finite-element codes in C, C++ and Fortran.
//!
//! The functions are declared in `include/contact_laws.h`. A law is made by one of the constructors, evaluated over any
//! part of its points any number of times, and freed.
//!
//! # Sign, axes, units, state
//!
//! As in `contact-laws`: the jump is `u_top - u_bottom` along x, y and n, where n points from the top body into the
//! bottom body, with the gap subtracted, so that `jump_n > 0` is interference. `t_n >= 0` is pressure. SI units. The
//! state is an array `[component][point]`: component `c` of the call's point `i` is `state[c * stride + i]`. It begins
//! as zeros. [`cl_law_n_state`] says how many components there are.
//!
//! # Status
//!
//! [`cl_law_evaluate`] returns
//!
//! - [`CL_SUCCESS`] (1): everything was computed;
//! - [`CL_INVALID_POINTS`] (0): everything was computed, but the jump or begin state of some points was not finite.
//!   Their tractions and tangents are NaN, they are counted in `counts` and marked in `regimes`. All other points are
//!   as they would be with status 1. Do not commit the end state: reduce the step;
//! - [`CL_ERROR`] (-1): the call was refused, the message says why, and nothing was written but the message.
//!
//! # Ownership
//!
//! The caller owns every array; constructors copy what they need, so that parameter arrays may be reused at once. A law
//! belongs to the caller from the constructor's return until it is handed to [`cl_law_free`], once. Texts returned by
//! the `cl_law_*_name` and `cl_law_*_unit` functions belong to the law and live as long. Messages are written to a
//! buffer of the caller, cut to its size and ended by a zero; the buffer is left alone unless the call is refused.
//!
//! # Memory
//!
//! `cl_law_evaluate` allocates nothing. Arrays that are only read may overlap one another. An array that is written
//! (end state, tractions, tangents, regimes, counts, message) must overlap no other array, or the call is refused. The
//! states are read before they are written, point by point, so `begin` and `end` may be the same array (with the commit
//! then made at every call). What counts is the points of the call: their components may lie between those of others.
//! Parameters of constructors may overlap one another, but not the message.
//!
//! # Threads
//!
//! A law never changes: any number of threads may evaluate the same law at the same time, also over parts of the same
//! state block, as long as no two of them write to the same point. No state is kept between calls. Freeing a law while
//! another thread uses it is an error that cannot be detected.
//!
//! # Failure
//!
//! What can be checked is checked before anything is written: NULL, alignment, ranges of points, strides, sizes that do
//! not fit in memory, overlaps, codes and parameters. Lengths of arrays cannot be seen through a pointer: they are the caller's
//! promise. No panic leaves a function; one would be a defect, becomes [`CL_ERROR`] or `NULL`, and the message says
//! that results may be incomplete. Running out of memory in a constructor ends the process.

// The interface takes pointers from C. Every use of them is in a block with its reason.
#![allow(unsafe_code)]
#![warn(clippy::undocumented_unsafe_blocks)]

mod boundary;
mod choice;
mod construct;
mod evaluate;
mod queries;

#[cfg(test)]
mod tests;

use std::ffi::CString;

use contact_laws::{Quantity, TractionLaw};

pub use choice::Constant;
pub use construct::{cl_asperity_table_law, cl_elastic_dry_friction_law, cl_resolved_law, cl_rough_law};
pub use evaluate::{Counts, cl_law_evaluate};
pub use queries::{
    cl_law_free, cl_law_n_parameters, cl_law_n_points, cl_law_n_state, cl_law_name, cl_law_parameter_name,
    cl_law_parameter_unit, cl_law_reference, cl_law_state_name, cl_law_state_unit,
};

/// Status: the call was refused and nothing was written but the message.
pub const CL_ERROR: i32 = -1;
/// Status: computed, but the input of some points was not finite; their results are NaN.
pub const CL_INVALID_POINTS: i32 = 0;
/// Status: computed.
pub const CL_SUCCESS: i32 = 1;

/// Regime: in contact below the slip limit.
pub const CL_REGIME_STICK: i32 = 0;
/// Regime: in contact at the slip limit.
pub const CL_REGIME_SLIP: i32 = 1;
/// Regime: no contact.
pub const CL_REGIME_OPEN: i32 = 2;
/// Regime: input that is not finite.
pub const CL_REGIME_INVALID: i32 = 3;

/// A traction law over a number of points. Made by a constructor, freed by cl_law_free.
pub struct Law {
    law: Box<dyn TractionLaw>,
    name: CString,
    reference: CString,
    state: Vec<Labels>,
    parameters: Vec<Labels>,
}

/// A quantity's name and unit.
struct Labels {
    name: CString,
    unit: CString,
}

impl Law {
    fn try_new(law: impl TractionLaw + 'static) -> Result<Self, boundary::Error> {
        let text = |text: &str| CString::new(text).expect("names of laws hold no zero");
        let labels = |quantities: &[Quantity]| {
            let label = |quantity: &Quantity| Labels {
                name: text(&quantity.name),
                unit: text(quantity.unit),
            };
            quantities.iter().map(label).collect::<Vec<_>>()
        };
        let info = law.info();
        boundary::require_state_fits(info.n_state())?;
        Ok(Self {
            name: text(info.name),
            reference: text(info.reference),
            state: labels(&info.state),
            parameters: labels(&info.parameters),
            law: Box::new(law),
        })
    }
}
