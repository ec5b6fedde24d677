//! What the evaluation of a block begins with: the interferences at which its curves are needed, and what is present.

use super::rule::StiffnessAt;
use crate::law::{StateView, StateViewMut};
use crate::simd::bounds::{bounded, is_finite};
use crate::simd::elementary::max;
use crate::simd::{Lanes, Pass, WIDTH, run};
use core::ops::Range;

/// Start of a block: the interferences at which its curves are needed, zero where a point is open and NaN where its
/// input is no number; and the jump as part of the end state.
pub(crate) struct Start<'a, const B: usize> {
    pub(crate) jump: [&'a [f64]; 3],
    pub(crate) begin: [&'a [f64]; 5],
    pub(crate) stiffness: StiffnessAt,
    pub(crate) u_n: &'a mut Lanes<f64, B>,
    pub(crate) middle: &'a mut Lanes<f64, B>,
    pub(crate) end: [&'a mut [f64]; 3],
    pub(crate) present: &'a mut Present,
}

/// What a block has to deal with.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Present {
    /// A closed point.
    pub(crate) closed: bool,
    /// A closed point that was open at its begin state.
    pub(crate) reclosed: bool,
}

impl<const B: usize> Pass for Start<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let [x, y, n] = self.jump;
        let [x_0, y_0, n_0, memory_1, memory_2] = self.begin;
        let [end_x, end_y, end_n] = self.end;
        *self.present = start(
            self.stiffness == StiffnessAt::Middle,
            x,
            y,
            n,
            x_0,
            y_0,
            n_0,
            memory_1,
            memory_2,
            self.u_n,
            self.middle,
            end_x,
            end_y,
            end_n,
        );
    }
}

/// [`Start`]. Every array is an argument of its own, here and below, because that alone tells the compiler that they do
/// not overlap.
#[inline(always)]
fn start<const B: usize>(
    halfway: bool,
    jump_x: &[f64],
    jump_y: &[f64],
    jump_n: &[f64],
    begin_x: &[f64],
    begin_y: &[f64],
    begin_n: &[f64],
    begin_1: &[f64],
    begin_2: &[f64],
    closed_u_n: &mut Lanes<f64, B>,
    middle: &mut Lanes<f64, B>,
    end_x: &mut [f64],
    end_y: &mut [f64],
    end_n: &mut [f64],
) -> Present {
    let n = jump_x.len().min(B);
    let (jump_x, jump_y, jump_n) = (&jump_x[..n], &jump_y[..n], &jump_n[..n]);
    let (begin_x, begin_y, begin_n) = (&begin_x[..n], &begin_y[..n], &begin_n[..n]);
    let (begin_1, begin_2) = (&begin_1[..n], &begin_2[..n]);
    let (end_x, end_y, end_n) = (&mut end_x[..n], &mut end_y[..n], &mut end_n[..n]);
    let (mut n_closed, mut n_reclosed) = (0_u64, 0_u64);
    for i in 0..n {
        let (u_x, u_y, u_n, u_n0) = (jump_x[i], jump_y[i], jump_n[i], begin_n[i]);
        let finite = is_finite([u_x, u_y, u_n, begin_x[i], begin_y[i], u_n0, begin_1[i], begin_2[i]]);
        let closed = finite & (u_n > 0.0);
        let from = if halfway { max(u_n0, 0.0) } else { u_n };
        // The mean of two positive numbers: halves first, their sum could overflow; but a halved denormal could vanish.
        let mean = max(0.5 * u_n + 0.5 * from, f64::from_bits(1));
        let fill = if finite { 0.0 } else { f64::NAN };
        closed_u_n.0[i] = if closed { u_n } else { fill };
        middle.0[i] = if closed { mean } else { 0.0 };
        end_x[i] = u_x + fill;
        end_y[i] = u_y + fill;
        end_n[i] = u_n + fill;
        n_closed += u64::from(closed);
        n_reclosed += u64::from(closed & (u_n0 < 0.0));
    }
    Present {
        closed: n_closed > 0,
        reclosed: n_reclosed > 0,
    }
}

/// NaN where a value of some rows is no finite number.
struct SpreadNan<'a, const B: usize> {
    /// From the first point of the first row on.
    rows: &'a [f64],
    stride: usize,
    n_rows: usize,
    /// Points.
    m: usize,
    fill: &'a mut Lanes<f64, B>,
}

impl<const B: usize> Pass for SpreadNan<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            rows,
            stride,
            n_rows,
            m,
            fill,
        } = self;
        let (wide, rest) = fill.0[..m.min(B)].as_chunks_mut::<WIDTH>();
        for (place, fill) in wide.iter_mut().enumerate() {
            spread(rows, stride, n_rows, WIDTH * place, fill);
        }
        let first = WIDTH * wide.len();
        for (place, fill) in rest.iter_mut().enumerate() {
            spread(rows, stride, n_rows, first + place, core::array::from_mut(fill));
        }
    }
}

/// The same for `W` points from one on, with as many sums as a processor adds up beside one another.
#[inline(always)]
fn spread<const W: usize>(rows: &[f64], stride: usize, n_rows: usize, first: usize, fill: &mut [f64; W]) {
    const SUMS: usize = 4;
    let mut sums = [[0.0; W]; SUMS];
    let mut add = |sum: usize, row: usize| {
        let values = &rows[row * stride + first..][..W];
        for (sum, value) in sums[sum].iter_mut().zip(values) {
            *sum += 0.0 * value;
        }
    };
    let whole = n_rows - n_rows % SUMS;
    for row in (0..whole).step_by(SUMS) {
        for sum in 0..SUMS {
            add(sum, row + sum);
        }
    }
    for row in whole..n_rows {
        add(0, row);
    }
    for (k, fill) in fill.iter_mut().enumerate() {
        *fill += (sums[0][k] + sums[1][k]) + (sums[2][k] + sums[3][k]);
    }
}

/// The set that all points of a block have, as in most blocks, which lie within one element.
pub(crate) fn common(sets: &[u32]) -> Option<u32> {
    let first = sets.first().copied();
    first.filter(|first| sets.iter().all(|set| set == first))
}

/// Values of sets at the points of a block.
pub(crate) fn gather(of_sets: &[f64], sets: &[u32], common: Option<u32>, into: &mut [f64]) {
    if let Some(set) = common {
        into.fill(of_sets[set as usize]);
        return;
    }
    for (into, &set) in into.iter_mut().zip(sets) {
        *into = of_sets[set as usize];
    }
}

/// Zero, or NaN where a number of the jump or of the begin state of a block's points is not finite.
pub(crate) fn spread_nan<const B: usize>(
    jump: [&[f64]; 3],
    begin: StateView<'_>,
    block: &Range<usize>,
    n_state: usize,
) -> Lanes<f64, B> {
    let mut fill = Lanes([0.0; B]);
    for values in jump {
        for (fill, value) in fill.0.iter_mut().zip(values) {
            *fill += 0.0 * value;
        }
    }
    let StateView {
        data,
        stride,
        offset,
        is_finite,
        ..
    } = begin;
    if !is_finite {
        run(SpreadNan {
            rows: &data[offset + block.start..],
            stride,
            n_rows: n_state,
            m: block.len(),
            fill: &mut fill,
        });
    }
    fill
}

/// States from a component on.
pub(crate) struct States<T> {
    pub(crate) data: T,
    /// Points from one component to the next, and the number of the first point.
    pub(crate) stride: usize,
    pub(crate) first: usize,
}

/// What states hold from a component and a point on.
pub(crate) fn states_from(states: StateView<'_>, component: usize, point: usize) -> States<&[f64]> {
    States {
        data: &states.data[component * states.stride..],
        stride: states.stride,
        first: states.offset + point,
    }
}

/// The states of a block's points.
pub(crate) struct Rows<'a> {
    pub(crate) begin: StateView<'a>,
    pub(crate) end: StateViewMut<'a>,
    pub(crate) n: usize,
    pub(crate) block: Range<usize>,
    /// Component from which on the end states are left zero.
    pub(crate) zero_from: usize,
}

impl<'a> Rows<'a> {
    /// Those of a block of `n` points.
    pub(crate) fn of(begin: StateView<'a>, end: &'a mut StateViewMut<'_>, n: usize, block: &Range<usize>) -> Self {
        Self {
            begin,
            end: StateViewMut {
                zero_from: end.zero_from,
                ..StateViewMut::new(&mut *end.data, end.stride, end.offset)
            },
            n,
            block: block.clone(),
            zero_from: usize::MAX,
        }
    }

    /// [`spread_nan`] of the block.
    pub(crate) fn spread_nan<const B: usize>(&self, jump: [&[f64]; 3], n_state: usize) -> Lanes<f64, B> {
        spread_nan(jump, self.begin, &self.block, n_state)
    }

    /// The jump as part of the end state, NaN where `fill` is.
    pub(crate) fn end_at<const B: usize>(&mut self, jump: [&[f64]; 3], fill: &Lanes<f64, B>) {
        for (end, jump) in self.end::<3>(0).into_iter().zip(jump) {
            for ((end, jump), fill) in end.iter_mut().zip(jump).zip(&fill.0) {
                *end = jump + fill;
            }
        }
    }

    pub(crate) fn begin(&self, component: usize) -> &'a [f64] {
        &self.begin.component(component, self.n)[self.block.clone()]
    }

    /// What states hold from a component on.
    pub(crate) fn begin_from(&self, component: usize) -> States<&'a [f64]> {
        states_from(self.begin, component, self.block.start)
    }

    /// The same of the end states.
    pub(crate) fn end_from(&mut self, component: usize) -> States<&mut [f64]> {
        let StateViewMut {
            data, stride, offset, ..
        } = &mut self.end;
        States {
            data: &mut data[component * *stride..],
            stride: *stride,
            first: *offset + self.block.start,
        }
    }

    /// `N` components from one on.
    pub(crate) fn end<const N: usize>(&mut self, component: usize) -> [&mut [f64]; N] {
        let (stride, offset) = (self.end.stride, self.end.offset);
        let rows = StateViewMut::new(&mut self.end.data[component * stride..], stride, offset);
        rows.components::<N>(self.n).map(|row| &mut row[self.block.clone()])
    }

    /// Each of a range of components at the points: the values given.
    pub(crate) fn end_with(&mut self, components: Range<usize>, values: &[f64]) {
        let StateViewMut {
            data, stride, offset, ..
        } = &mut self.end;
        // Zero, and without holes, as nearly always: at once.
        if self.block.len() == *stride && values.iter().all(|value| *value == 0.0) {
            data[components.start * *stride..components.end * *stride].fill(0.0);
            return;
        }
        for component in components {
            let first = component * *stride + *offset + self.block.start;
            data[first..first + values.len()].copy_from_slice(values);
        }
    }

    /// Each component from one on, of as many as there are: the values given. What is zero already is not written.
    pub(crate) fn end_from_with(&mut self, component: usize, n_state: usize, values: &[f64]) {
        let are_zero = values.iter().all(|value| *value == 0.0);
        let (until, zero_from) = match are_zero {
            true => (n_state.min(self.end.zero_from), component),
            false => (n_state, usize::MAX),
        };
        self.end_with(component..until.max(component), values);
        self.zero_from = zero_from;
    }

    /// Pairs of components of point `i` from one component on.
    pub(crate) fn gather(&self, component: usize, i: usize, into: &mut [[f64; 2]]) {
        let StateView {
            data, stride, offset, ..
        } = self.begin;
        let values = data[component * stride + offset + self.block.start + i..].iter();
        for (into, value) in into.as_flattened_mut().iter_mut().zip(values.step_by(stride)) {
            *into = bounded(*value);
        }
    }

    /// Pairs of components of point `i` from one component on, with an addition to each number.
    pub(crate) fn scatter(&mut self, component: usize, i: usize, from: &[[f64; 2]], fill: f64) {
        let StateViewMut {
            data, stride, offset, ..
        } = &mut self.end;
        let values = data[component * *stride + *offset + self.block.start + i..].iter_mut();
        for (value, from) in values.step_by(*stride).zip(from.as_flattened()) {
            *value = *from + fill;
        }
    }
}
