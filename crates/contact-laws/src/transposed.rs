//! Transposed derivatives of a law by derivatives along as few directions as its parts allow.
//!
//! Numbers of the input, jump and begin state, that act on different numbers of the end state share a direction (A. R. Curtis, M. J. D. Powell, J. K. Reid, J. Inst.
//! Math. Appl. 13 (1974) 117-119). Where they add to the same traction, the law tells the changes of the tractions part by part.

use alloc::vec;
use core::ops::Range;

use crate::simd::BLOCK;
use crate::views::{Along, Components, ComponentsMut, StateView, StateViewMut};

/// Adjoints of the history and of the tractions of points, and where that of the jump goes.
#[derive(Debug)]
pub struct Adjoint<'a> {
    /// Of the history, after the step; before it, afterwards.
    pub history: StateViewMut<'a>,
    /// Of the tractions.
    pub traction: Components<'a>,
    /// Of the jump, which is overwritten.
    pub jump: ComponentsMut<'a>,
}

/// What becomes of the adjoint of a history on the way back through a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WayBack {
    /// The end state was committed: the adjoint of the end state becomes that of the begin state.
    Committed,
    /// The end state was not committed: what the tractions depend on the begin state by is added, and the end state counts nowhere.
    Passed,
    /// That of the jump alone is wanted, of a step that was committed. The adjoint of the history stays.
    JumpAlone,
}

impl WayBack {
    /// The adjoint of the history before a step, from that after it and what came through the step.
    #[inline(always)]
    pub(crate) fn before(self, after: f64, through: f64) -> f64 {
        match self {
            Self::Committed => through,
            Self::Passed => after + through,
            Self::JumpAlone => after,
        }
    }

    /// The adjoint of the end state.
    #[inline(always)]
    pub(crate) fn of_end(self, after: f64) -> f64 {
        if self == Self::Passed { 0.0 } else { after }
    }
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

/// Numbers of the input with all that they act on.
pub(crate) struct Part {
    /// Components of the jump and, after those, of the begin state.
    pub(crate) input: Range<usize>,
    /// Components of the end state.
    pub(crate) end: Range<usize>,
    /// The [`WHOLE`] tractions, or parts of them, counted after that.
    pub(crate) tractions: Range<usize>,
}

/// What all parts add up to.
pub(crate) const WHOLE: Range<usize> = 0..1;

/// Components of a jump.
pub(crate) const N_JUMP: usize = 3;

/// [`TractionLaw::transposed`](crate::TractionLaw::transposed) by derivatives. Parts of one of the `passes` share directions: their end states and
/// parts of tractions are not the same. `derivative` is that of the law along a direction, with `n_parts` parts of the tractions.
pub(crate) fn transposed(
    input: &Input<'_>,
    n_parts: usize,
    passes: &[&[Part]],
    way: WayBack,
    adjoints: &mut [Adjoint<'_>],
    mut derivative: impl FnMut(Input<'_>, StateViewMut<'_>, ComponentsMut<'_>, Along<'_>),
) {
    let parts = passes.iter().copied().flatten();
    let n_state = parts.map(|part| part.end.end).max().unwrap_or(0);
    let n_inputs = N_JUMP + n_state;
    let wanted = match way {
        WayBack::JumpAlone => N_JUMP,
        WayBack::Committed | WayBack::Passed => n_inputs,
    };
    let mut traction = [[0.0; BLOCK]; 3];
    let [mut end, mut d_end] = [0; 2].map(|_| vec![0.0; n_state * BLOCK]);
    let mut unit = vec![0.0; n_inputs * BLOCK];
    let mut d_traction = vec![0.0; 3 * (WHOLE.end + n_parts) * BLOCK];
    let mut through = vec![vec![0.0; n_inputs * BLOCK]; adjoints.len()];
    for first in (0..input.points.len()).step_by(BLOCK) {
        let chunk = first..input.points.len().min(first + BLOCK);
        let n = chunk.len();
        let row = |c: usize| c * n..(c + 1) * n;
        for parts in passes {
            let directions = parts.iter().map(|part| part.input.len()).max().unwrap_or(0);
            for direction in 0..directions {
                let seeded = || {
                    let parts = parts.iter().filter(|part| direction < part.input.len());
                    let seeded = parts.map(|part| (part.input.start + direction, part));
                    seeded.filter(|(c, _)| *c < wanted)
                };
                if seeded().next().is_none() {
                    continue;
                }
                seeded().for_each(|(c, _)| unit[row(c)].fill(1.0));
                d_traction.fill(0.0);
                let (whole, of_parts) = d_traction.split_at_mut(3 * n);
                let [x, y, normal] = traction.each_mut().map(|values| &mut values[..n]);
                let (d_x, rest) = whole.split_at_mut(n);
                let (d_y, d_n) = rest.split_at_mut(n);
                let along = Along {
                    d_jump: Components::new(&unit[row(0)], &unit[row(1)], &unit[row(2)]),
                    d_begin: StateView::new(&unit[N_JUMP * n..], n, 0),
                    d_end: StateViewMut::new(&mut d_end, n, 0),
                    d_traction: ComponentsMut::new(d_x, d_y, d_n),
                    parts: Some(of_parts),
                };
                let end = StateViewMut::new(&mut end, n, 0);
                derivative(input.part(&chunk), end, ComponentsMut::new(x, y, normal), along);
                for (adjoint, through) in adjoints.iter().zip(&mut through) {
                    let tractions = [adjoint.traction.x, adjoint.traction.y, adjoint.traction.n];
                    for (c, part) in seeded() {
                        let sum = &mut through[row(c)];
                        sum.fill(0.0);
                        if way != WayBack::Passed {
                            for c in part.end.clone() {
                                let of_end = &adjoint.history.as_view().component(c, chunk.end)[chunk.clone()];
                                add_products(of_end, &d_end[row(c)], sum);
                            }
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
        for (adjoint, through) in adjoints.iter_mut().zip(&through) {
            let ComponentsMut { x, y, n: normal } = &mut adjoint.jump;
            for (c, into) in [x, y, normal].into_iter().enumerate() {
                into[chunk.clone()].copy_from_slice(&through[row(c)]);
            }
            let StateViewMut {
                data, stride, offset, ..
            } = &mut adjoint.history;
            for c in N_JUMP..wanted {
                let history = &mut data[(c - N_JUMP) * *stride + *offset + first..][..n];
                for (history, through) in history.iter_mut().zip(&through[row(c)]) {
                    *history = way.before(*history, *through);
                }
            }
        }
    }
}

fn add_products(a: &[f64], b: &[f64], sum: &mut [f64]) {
    for ((sum, a), b) in sum.iter_mut().zip(a).zip(b) {
        *sum += a * b;
    }
}
