//! Transposed derivatives of a law by derivatives along as few directions as its parts allow.
//!
//! Numbers of a begin state that act on different numbers of the end state share a direction (A. R. Curtis, M. J. D. Powell, J. K. Reid, J. Inst.
//! Math. Appl. 13 (1974) 117-119). Where they add to the same traction, the law tells the changes of the tractions part by part.

use alloc::vec;
use core::ops::Range;

use crate::simd::BLOCK;
use crate::views::{Components, StateView, StateViewMut};

/// Adjoints of what points answer, and where that of the begin state goes.
#[derive(Debug)]
pub struct Adjoint<'a> {
    /// Of the end state.
    pub end: StateView<'a>,
    /// Of the tractions.
    pub traction: Components<'a>,
    /// Of the begin state, which is overwritten.
    pub begin: StateViewMut<'a>,
}

/// Numbers of a begin state with all that they act on.
pub(crate) struct Part {
    /// Components of the begin state.
    pub(crate) begin: Range<usize>,
    /// Components of the end state.
    pub(crate) end: Range<usize>,
    /// Parts of the tractions.
    pub(crate) tractions: Range<usize>,
}

/// The adjoints of the begin state of `points`, counted within the views. Parts of one of the `passes` share directions: their end states and parts of
/// tractions are not the same. `along` gives, for a chunk of the points and `d_begin`, the changes of the end state and of each of `n_tractions` parts
/// of the tractions, `[part][x, y, n][point]`; all without holes.
pub(crate) fn to_begin(
    points: Range<usize>,
    n_state: usize,
    n_tractions: usize,
    passes: &[&[Part]],
    adjoints: &mut [Adjoint<'_>],
    mut along: impl FnMut(Range<usize>, &[f64], &mut [f64], &mut [f64]),
) {
    let mut unit = vec![0.0; n_state * BLOCK];
    let mut d_end = vec![0.0; n_state * BLOCK];
    let mut d_traction = vec![0.0; 3 * n_tractions * BLOCK];
    for first in points.clone().step_by(BLOCK) {
        let chunk = first..points.end.min(first + BLOCK);
        let n = chunk.len();
        let row = |c: usize| c * n..(c + 1) * n;
        let (unit, d_end) = (&mut unit[..n_state * n], &mut d_end[..n_state * n]);
        let d_traction = &mut d_traction[..3 * n_tractions * n];
        for parts in passes {
            let directions = parts.iter().map(|part| part.begin.len()).max().unwrap_or(0);
            for direction in 0..directions {
                let seeded = || {
                    let parts = parts.iter().filter(|part| direction < part.begin.len());
                    parts.map(|part| (part.begin.start + direction, part))
                };
                seeded().for_each(|(c, _)| unit[row(c)].fill(1.0));
                d_traction.fill(0.0);
                along(chunk.clone(), unit, d_end, d_traction);
                for adjoint in &mut *adjoints {
                    let tractions = [adjoint.traction.x, adjoint.traction.y, adjoint.traction.n];
                    let StateViewMut { data, stride, offset } = &mut adjoint.begin;
                    for (c, part) in seeded() {
                        let sum = &mut data[c * *stride + *offset + chunk.start..][..n];
                        sum.fill(0.0);
                        for c in part.end.clone() {
                            let of_end = &adjoint.end.component(c, chunk.end)[chunk.clone()];
                            add_products(of_end, &d_end[row(c)], sum);
                        }
                        for k in part.tractions.clone() {
                            for (q, traction) in tractions.iter().enumerate() {
                                add_products(&traction[chunk.clone()], &d_traction[row(3 * k + q)], sum);
                            }
                        }
                    }
                }
                seeded().for_each(|(c, _)| unit[row(c)].fill(0.0));
            }
        }
    }
}

fn add_products(a: &[f64], b: &[f64], sum: &mut [f64]) {
    for ((sum, a), b) in sum.iter_mut().zip(a).zip(b) {
        *sum += a * b;
    }
}
