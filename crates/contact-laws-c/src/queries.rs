//! What a law says about itself, and its end.

use core::ffi::c_char;
use core::ptr;
use std::ffi::CString;

use crate::{Labels, Law};

/// Number of points, 0 if the law is NULL.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_n_points(law: *const Law) -> usize {
    // SAFETY: the caller's promise, here and in the other functions of this module.
    unsafe { law.as_ref() }.map_or(0, |law| law.law.len())
}

/// Number of state components per point, 0 if the law is NULL.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_n_state(law: *const Law) -> usize {
    // SAFETY: as in cl_law_n_points.
    unsafe { law.as_ref() }.map_or(0, |law| law.state.len())
}

/// Number of parameters, 0 if the law is NULL.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_n_parameters(law: *const Law) -> usize {
    // SAFETY: as in cl_law_n_points.
    unsafe { law.as_ref() }.map_or(0, |law| law.parameters.len())
}

/// Name of the law, NULL if the law is NULL. The text lives as long as the law.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_name(law: *const Law) -> *const c_char {
    // SAFETY: as in cl_law_n_points.
    text(unsafe { law.as_ref() }.map(|law| &law.name))
}

/// Where the law is described, NULL if the law is NULL. The text lives as long as the law.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_reference(law: *const Law) -> *const c_char {
    // SAFETY: as in cl_law_n_points.
    text(unsafe { law.as_ref() }.map(|law| &law.reference))
}

/// Name of a state component, counted from 0, NULL if there is none. The text lives as long as the law.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_state_name(law: *const Law, component: usize) -> *const c_char {
    // SAFETY: as in cl_law_n_points.
    text(unsafe { label(law, |law| &law.state, component) }.map(|label| &label.name))
}

/// Unit of a state component, counted from 0, NULL if there is none. The text lives as long as the law.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_state_unit(law: *const Law, component: usize) -> *const c_char {
    // SAFETY: as in cl_law_n_points.
    text(unsafe { label(law, |law| &law.state, component) }.map(|label| &label.unit))
}

/// Name of a parameter, counted from 0, NULL if there is none. The text lives as long as the law.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_parameter_name(law: *const Law, parameter: usize) -> *const c_char {
    // SAFETY: as in cl_law_n_points.
    text(unsafe { label(law, |law| &law.parameters, parameter) }.map(|label| &label.name))
}

/// Unit of a parameter, counted from 0, NULL if there is none. The text lives as long as the law.
///
/// # Safety
/// The law is NULL or not yet freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_parameter_unit(law: *const Law, parameter: usize) -> *const c_char {
    // SAFETY: as in cl_law_n_points.
    text(unsafe { label(law, |law| &law.parameters, parameter) }.map(|label| &label.unit))
}

/// Frees a law and the texts it gave. NULL is left alone.
///
/// # Safety
/// The law is NULL or comes from a constructor, has not been freed and is not in use.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_law_free(law: *mut Law) {
    if !law.is_null() {
        // SAFETY: constructors hand out boxes, and the caller gives each back once.
        drop(unsafe { Box::from_raw(law) });
    }
}

/// # Safety
/// The law is NULL or lives during `'a`.
unsafe fn label<'a>(law: *const Law, list: fn(&Law) -> &Vec<Labels>, index: usize) -> Option<&'a Labels> {
    // SAFETY: the caller's promise.
    unsafe { law.as_ref() }.and_then(|law| list(law).get(index))
}

fn text(text: Option<&CString>) -> *const c_char {
    text.map_or(ptr::null(), |text| text.as_ptr())
}
