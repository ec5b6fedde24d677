//! Transposed derivatives of a law by derivatives along as few directions as its parts allow.
//!
//! Numbers of a begin state that act on different numbers of the end state share a direction (A. R. Curtis, M. J. D. Powell, J. K. Reid, J. Inst.
//! Math. Appl. 13 (1974) 117-119). Where they add to the same traction, the law tells the changes of the tractions part by part.

use alloc::vec;
use core::ops::Range;

use crate::simd::BLOCK;
use crate::views::{Along, Components, ComponentsMut, StateView, StateViewMut};

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

/// Where points are, and where they were.
pub(crate) struct Input<'a> {
    pub(crate) points: Range<usize>,
    pub(crate) jump: Components<'a>,
    pub(crate) begin: StateView<'a>,
}

impl<'a> Input<'a> {
    /// That of a chunk of the points, counted from the first.
    fn part(&self, chunk: &Range<usize>) -> Self {
        let of = |values: &'a [f64]| &values[chunk.clone()];
        let Self { points, jump, begin } = self;
        Self {
            points: points.start + chunk.start..points.start + chunk.end,
            jump: Components::new(of(jump.x), of(jump.y), of(jump.n)),
            begin: StateView::new(begin.data, begin.stride, begin.offset + chunk.start),
        }
    }
}

/// Numbers of a begin state with all that they act on.
pub(crate) struct Part {
    /// Components of the begin state.
    pub(crate) begin: Range<usize>,
    /// Components of the end state.
    pub(crate) end: Range<usize>,
    /// The [`WHOLE`] tractions, or parts of them, counted after that.
    pub(crate) tractions: Range<usize>,
}

/// What all parts add up to.
pub(crate) const WHOLE: Range<usize> = 0..1;

/// The adjoints of the begin state. Parts of one of the `passes` share directions: their end states and parts of tractions are not the same. `derivative`
/// is that of the law along a direction, with `n_parts` parts of the tractions.
pub(crate) fn to_begin(
    input: &Input<'_>,
    n_parts: usize,
    passes: &[&[Part]],
    adjoints: &mut [Adjoint<'_>],
    mut derivative: impl FnMut(Input<'_>, StateViewMut<'_>, ComponentsMut<'_>, Along<'_>),
) {
    let n_state = passes
        .iter()
        .copied()
        .flatten()
        .map(|part| part.end.end)
        .max()
        .unwrap_or(0);
    let still = [0.0; BLOCK];
    let mut traction = [[0.0; BLOCK]; 3];
    let [mut unit, mut end, mut d_end] = [0; 3].map(|_| vec![0.0; n_state * BLOCK]);
    let mut d_traction = vec![0.0; 3 * (WHOLE.end + n_parts) * BLOCK];
    for first in (0..input.points.len()).step_by(BLOCK) {
        let chunk = first..input.points.len().min(first + BLOCK);
        let n = chunk.len();
        let row = |c: usize| c * n..(c + 1) * n;
        for parts in passes {
            let directions = parts.iter().map(|part| part.begin.len()).max().unwrap_or(0);
            for direction in 0..directions {
                let seeded = || {
                    let parts = parts.iter().filter(|part| direction < part.begin.len());
                    parts.map(|part| (part.begin.start + direction, part))
                };
                seeded().for_each(|(c, _)| unit[row(c)].fill(1.0));
                d_traction.fill(0.0);
                let (whole, of_parts) = d_traction.split_at_mut(3 * n);
                let [x, y, normal] = traction.each_mut().map(|values| &mut values[..n]);
                let (d_x, rest) = whole.split_at_mut(n);
                let (d_y, d_n) = rest.split_at_mut(n);
                let along = Along {
                    d_jump: Components::new(&still[..n], &still[..n], &still[..n]),
                    d_begin: StateView::new(&unit, n, 0),
                    d_end: StateViewMut::new(&mut d_end, n, 0),
                    d_traction: ComponentsMut::new(d_x, d_y, d_n),
                    parts: Some(of_parts),
                };
                let end = StateViewMut::new(&mut end, n, 0);
                derivative(input.part(&chunk), end, ComponentsMut::new(x, y, normal), along);
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
