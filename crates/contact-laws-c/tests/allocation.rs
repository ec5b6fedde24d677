//! Evaluations and refused evaluations allocate nothing.
#![allow(unsafe_code)]

use std::ptr;

use contact_laws::{Choice, HistoryRule, Sticking};
use contact_laws_c::*;
use test_support::memory::{self, Counting};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn evaluations_do_not_allocate() {
    const N: usize = 1000;
    let (k, mu) = (1e12, 0.2);
    // SAFETY: one set of parameters, one friction coefficient, no message.
    let (law, made) = memory::blocks(|| unsafe {
        cl_elastic_dry_friction_law(
            N,
            &k,
            &k,
            &k,
            1,
            &mu,
            1,
            HistoryRule::Incremental.number(),
            ptr::null_mut(),
            0,
        )
    });
    assert!(!law.is_null() && made > 0, "the count counts");

    let (jump, begin, mut out) = (vec![1e-6; N], vec![0.0; 5 * N], vec![0.0; (5 + 3 + 9) * N]);
    let (mut regimes, mut counts, mut message) = (vec![0; N], Counts::default(), [0_u8; 100]);
    let rows: [*mut f64; 17] = {
        let start = out.as_mut_ptr();
        std::array::from_fn(|row| start.wrapping_add(row * N))
    };
    let mut call = |count: usize| {
        // SAFETY: arrays of `N` points; the law looks at no array when it lacks the points.
        unsafe {
            cl_law_evaluate(
                law,
                0,
                count,
                Sticking::Coulomb.number(),
                jump.as_ptr(),
                jump.as_ptr(),
                jump.as_ptr(),
                begin.as_ptr(),
                rows[0],
                N,
                rows[5],
                rows[6],
                rows[7],
                rows[8..].as_ptr(),
                regimes.as_mut_ptr(),
                &mut counts,
                message.as_mut_ptr().cast(),
                message.len(),
            )
        }
    };
    let (statuses, allocated) = memory::blocks(|| [call(N), call(1), call(N + 1)]);
    assert_eq!((statuses, allocated), ([CL_SUCCESS, CL_SUCCESS, CL_ERROR], 0));
    assert!(message.starts_with(b"1001 points"));
    // SAFETY: from the constructor.
    unsafe { cl_law_free(law) };
}
