//! Tools to test a traction law, this crate's or anyone's: a tangent checker and proptest strategies for its input.
//!
//! The strategies cover interferences from 1e-12 m to 1e-2 m, open points, exact kinks, denormal numbers and signed
//! zeros.

use core::ops::Range;

use proptest::prelude::*;

use crate::curves::elastic::ElasticCurves;
use crate::curves::fitted::{FittedCurves, NormalFit, TangentialEnds, TangentialFit};
use crate::law::{
    Components, ComponentsMut, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut, TractionLaw,
};

/// What a law answers at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointResponse {
    /// Traction along x, y, n (Pa).
    pub traction: [f64; 3],
    /// Row `i` holds the derivatives of traction `i` with respect to the jump (Pa/m).
    pub tangent: [[f64; 3]; 3],
    /// State reached.
    pub end: Vec<f64>,
    /// Regime.
    pub regime: Regime,
}

/// Evaluates one point of a law under `jump` (m) from the state `begin`.
pub fn evaluate_point<L: TractionLaw + ?Sized>(
    law: &L,
    point: usize,
    sticking: Sticking,
    jump: [f64; 3],
    begin: &[f64],
) -> PointResponse {
    let mut end = vec![0.0; law.info().n_state()];
    let [mut x, mut y, mut n] = [[0.0]; 3];
    let mut j = [[0.0]; 9];
    let mut regime = [Regime::Open];
    law.evaluate(
        point..point + 1,
        sticking,
        Components::new(&jump[..1], &jump[1..2], &jump[2..]),
        StateView::new(begin, 1, 0),
        StateViewMut::new(&mut end, 1, 0),
        ComponentsMut::new(&mut x, &mut y, &mut n),
        Some(TangentMut::from_entries(j.each_mut().map(|entry| entry.as_mut_slice()))),
        Some(&mut regime),
    );
    let tangent = core::array::from_fn(|i| core::array::from_fn(|k| j[3 * i + k][0]));
    PointResponse {
        traction: [x[0], y[0], n[0]],
        tangent,
        end,
        regime: regime[0],
    }
}

impl PointResponse {
    /// All numbers: traction, tangent, state reached.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let all = self.traction.iter().chain(self.tangent.as_flattened()).chain(&self.end);
        all.copied()
    }

    /// Whether both have the same bits, up to the payload of what is not a number.
    pub fn is_identical(&self, other: &Self) -> bool {
        self.regime == other.regime && self.numbers().map(bits).eq(other.numbers().map(bits))
    }
}

/// The bits of a number, the same for all that are none.
fn bits(value: f64) -> u64 {
    if value.is_nan() {
        f64::NAN.to_bits()
    } else {
        value.to_bits()
    }
}

/// Evaluates all points of a law, one call per chunk: jumps (m) and begin states per point.
///
/// # Panics
/// When the chunks leave out a point, or a count differs from the regimes of its chunk.
pub fn evaluate_batch<L: TractionLaw + ?Sized>(
    law: &L,
    sticking: Sticking,
    chunks: impl IntoIterator<Item = Range<usize>>,
    jump: &[[f64; 3]],
    begin: &[Vec<f64>],
) -> Vec<PointResponse> {
    let (n, n_state) = (jump.len(), law.info().n_state());
    let jump: [Vec<f64>; 3] = core::array::from_fn(|q| jump.iter().map(|u| u[q]).collect());
    let begin: Vec<f64> = (0..n_state)
        .flat_map(|c| begin.iter().map(move |state| state[c]))
        .collect();
    let mut end = vec![0.0; n_state * n];
    let mut out = vec![vec![0.0; n]; 12];
    let mut regimes = vec![None; n];
    for c in chunks {
        let mut found = vec![Regime::Open; c.len()];
        let mut parts = out.iter_mut().map(|values| &mut values[c.clone()]);
        let mut next = || parts.next().expect("12 outputs");
        let [x, y, n_] = core::array::from_fn(|_| next());
        let tangent = core::array::from_fn(|_| next());
        let counts = law.evaluate(
            c.clone(),
            sticking,
            Components::new(&jump[0][c.clone()], &jump[1][c.clone()], &jump[2][c.clone()]),
            StateView::new(&begin, n, c.start),
            StateViewMut::new(&mut end, n, c.start),
            ComponentsMut::new(x, y, n_),
            Some(TangentMut::from_entries(tangent)),
            Some(&mut found),
        );
        let mut recounted = RegimeCounts::default();
        found.iter().for_each(|&regime| recounted.count(regime));
        assert_eq!(recounted, counts, "regimes of the points {c:?}");
        for (i, regime) in c.zip(found) {
            regimes[i] = Some(regime);
        }
    }
    let point = |i: usize| PointResponse {
        traction: core::array::from_fn(|q| out[q][i]),
        tangent: core::array::from_fn(|q| core::array::from_fn(|k| out[3 + 3 * q + k][i])),
        end: (0..n_state).map(|c| end[c * n + i]).collect(),
        regime: regimes[i].expect("the chunks cover every point"),
    };
    (0..n).map(point).collect()
}

/// What a law answers at one point, with derivatives along a direction.
#[derive(Debug, Clone, PartialEq)]
pub struct PointDerivative {
    /// Traction along x, y, n (Pa).
    pub traction: [f64; 3],
    /// Derivative of the traction.
    pub d_traction: [f64; 3],
    /// State reached.
    pub end: Vec<f64>,
    /// Derivative of the state reached.
    pub d_end: Vec<f64>,
}

impl PointDerivative {
    /// Whether both have the same bits, up to the payload of what is not a number.
    pub fn is_identical(&self, other: &Self) -> bool {
        let numbers = |found: &Self| -> Vec<u64> {
            let tractions = found.traction.iter().chain(&found.d_traction);
            let all = tractions.chain(&found.end).chain(&found.d_end);
            all.copied().map(bits).collect()
        };
        numbers(self) == numbers(other)
    }
}

/// [`TractionLaw::derivative`] at all points of a law, one call per chunk. Per point: jump (m) and begin state, and the
/// direction as a change of both.
///
/// # Panics
/// When the counts of a chunk do not add up to its points.
pub fn derivative_batch<L: TractionLaw + ?Sized>(
    law: &L,
    sticking: Sticking,
    chunks: impl IntoIterator<Item = Range<usize>>,
    at: &[([f64; 3], Vec<f64>)],
    along: &[([f64; 3], Vec<f64>)],
) -> Vec<PointDerivative> {
    let (n, n_state) = (at.len(), law.info().n_state());
    let jumps = |of: &[([f64; 3], Vec<f64>)]| -> [Vec<f64>; 3] {
        core::array::from_fn(|q| of.iter().map(|(u, _)| u[q]).collect())
    };
    let states = |of: &[([f64; 3], Vec<f64>)]| -> Vec<f64> {
        let component = |c: usize| of.iter().map(move |(_, state)| state[c]);
        (0..n_state).flat_map(component).collect()
    };
    let ([jump, d_jump], [begin, d_begin]) = ([at, along].map(jumps), [at, along].map(states));
    let [mut end, mut d_end] = [(); 2].map(|()| vec![0.0; n_state * n]);
    let mut out = vec![vec![0.0; n]; 6];
    for c in chunks {
        let mut parts = out.iter_mut().map(|values| &mut values[c.clone()]);
        let [x, y, z, d_x, d_y, d_z] = core::array::from_fn(|_| parts.next().expect("6 outputs"));
        let counts = law.derivative(
            c.clone(),
            sticking,
            Components::new(&jump[0][c.clone()], &jump[1][c.clone()], &jump[2][c.clone()]),
            StateView::new(&begin, n, c.start),
            Components::new(&d_jump[0][c.clone()], &d_jump[1][c.clone()], &d_jump[2][c.clone()]),
            StateView::new(&d_begin, n, c.start),
            StateViewMut::new(&mut end, n, c.start),
            StateViewMut::new(&mut d_end, n, c.start),
            ComponentsMut::new(x, y, z),
            ComponentsMut::new(d_x, d_y, d_z),
        );
        assert_eq!(counts.total(), c.len(), "regimes of the points {c:?}");
    }
    let point = |i: usize| PointDerivative {
        traction: core::array::from_fn(|q| out[q][i]),
        d_traction: core::array::from_fn(|q| out[3 + q][i]),
        end: (0..n_state).map(|c| end[c * n + i]).collect(),
        d_end: (0..n_state).map(|c| d_end[c * n + i]).collect(),
    };
    (0..n).map(point).collect()
}

/// [`TractionLaw::derivative`] at one point of a law: jump (m) and begin state, and the direction as a change of both.
pub fn derivative_at_point<L: TractionLaw + ?Sized>(
    law: &L,
    point: usize,
    sticking: Sticking,
    (jump, begin): ([f64; 3], &[f64]),
    (d_jump, d_begin): ([f64; 3], &[f64]),
) -> PointDerivative {
    let n_state = law.info().n_state();
    let [mut end, mut d_end] = [(); 2].map(|()| vec![0.0; n_state]);
    let [mut x, mut y, mut n, mut d_x, mut d_y, mut d_n] = [[0.0]; 6];
    law.derivative(
        point..point + 1,
        sticking,
        Components::new(&jump[..1], &jump[1..2], &jump[2..]),
        StateView::new(begin, 1, 0),
        Components::new(&d_jump[..1], &d_jump[1..2], &d_jump[2..]),
        StateView::new(d_begin, 1, 0),
        StateViewMut::new(&mut end, 1, 0),
        StateViewMut::new(&mut d_end, 1, 0),
        ComponentsMut::new(&mut x, &mut y, &mut n),
        ComponentsMut::new(&mut d_x, &mut d_y, &mut d_n),
    );
    PointDerivative {
        traction: [x[0], y[0], n[0]],
        d_traction: [d_x[0], d_y[0], d_n[0]],
        end,
        d_end,
    }
}

/// Work per area (J/m^2) along a path of jumps (m) from the state `begin` at its first point, with a commit at every
/// step, and the state at its end. By the trapezoidal rule; `respond` answers to a jump from a begin state.
pub fn work_along(
    path: &[[f64; 3]],
    begin: &[f64],
    respond: impl Fn([f64; 3], &[f64]) -> PointResponse,
) -> (f64, Vec<f64>) {
    let mut state = begin.to_vec();
    let mut work = 0.0;
    for step in path.windows(2) {
        let before = respond(step[0], &state).traction;
        let after = respond(step[1], &state);
        work += (0..3)
            .map(|q| 0.5 * (before[q] + after.traction[q]) * (step[1][q] - step[0][q]))
            .sum::<f64>();
        state = after.end;
    }
    (work, state)
}

/// Largest error of a law's tangent against differences of its tractions, or `None` where differences are no judge:
/// beside a change of regime, or where rounding hides them. A jump of second derivatives within the steps misleads
/// them.
///
/// Asks nothing of the law but its responses. The differences are central ones with steps falling from 1/20 of the
/// length over which the response changes (`u_n`; along the surface the traction over the stiffness of the law without
/// slip), extrapolated to zero as long as that converges (Ridders 1982); they count if they converge to 1e-7. Entry
/// `(i, k)` is measured relative to the larger of itself and traction `i` over the length of direction `k`.
pub fn tangent_error<L: TractionLaw + ?Sized>(
    law: &L,
    point: usize,
    sticking: Sticking,
    jump: [f64; 3],
    begin: &[f64],
) -> Option<f64> {
    let here = evaluate_point(law, point, sticking, jump, begin);
    let stuck = evaluate_point(law, point, Sticking::Full, jump, begin);
    let length = |t: [f64; 3]| t[0].hypot(t[1]);
    let stiffness = stuck.tangent[0][0].abs().max(stuck.tangent[1][1].abs());
    let reach = length(stuck.traction) / stiffness;
    let along = if reach.is_normal() { reach } else { jump[2].abs() };
    let lengths = [along, along, jump[2].abs()];
    // Closing may turn the direction of slip faster than it changes the curves.
    let closing = length(stuck.traction) / stuck.tangent[0][2].hypot(stuck.tangent[1][2]);
    let closing = if closing.is_normal() { closing } else { f64::INFINITY };
    let steps = [along, along, closing.min(jump[2].abs())];
    // Tractions below have lost digits to underflow.
    let tangential = length(here.traction).max(f64::MIN_POSITIVE / f64::EPSILON);
    let tractions = [tangential, tangential, here.traction[2].abs()];

    // The relative error of a traction: a steep curve takes the exponential of a large number, whose rounding it magnifies.
    const ROUNDING: f64 = 128.0 * f64::EPSILON;
    let mut worst = 0.0_f64;
    for k in 0..3 {
        // Difference quotients of the three tractions over two steps and what rounding of the tractions makes of them,
        // if the regime does not change between them and the steps survive rounding.
        let quotient = |step: f64| {
            if step < 1e4 * f64::EPSILON * jump[k].abs() {
                return None;
            }
            let [left, right] = [-step, step].map(|step| {
                let mut moved = jump;
                moved[k] += step;
                (moved[k], evaluate_point(law, point, sticking, moved, begin))
            });
            let same = [&left.1, &right.1]
                .iter()
                .all(|response| response.regime == here.regime);
            // Divided by the step as it was rounded.
            same.then(|| {
                let of = |i: usize| {
                    let (from, to) = (left.1.traction[i], right.1.traction[i]);
                    let rounding = ROUNDING * from.abs().max(to.abs()) / step;
                    ((to - from) / (right.0 - left.0), rounding)
                };
                (0..3).map(of).collect()
            })
        };
        for (i, (value, uncertainty)) in extrapolate(0.05 * steps[k], &quotient)?.into_iter().enumerate() {
            let (entry, over_length) = (here.tangent[i][k], tractions[i] / lengths[k]);
            if entry == value {
                continue;
            }
            if !(uncertainty <= 1e-7 * value.abs().max(over_length)) {
                return None;
            }
            worst = worst.max((value - entry).abs() / entry.abs().max(over_length));
        }
    }
    Some(worst)
}

/// Largest error of [`TractionLaw::derivative`] along a direction against differences of tractions and end states, or
/// `None` where differences are no judge: beside a change of regime or another kink, or where rounding hides them.
///
/// A unit of the direction should change the input by its own size. The differences are as in [`tangent_error`], with
/// first steps from 1e-2 to 1e-6, of which two limits must agree to 2e-7. A derivative is measured relative to the larger of itself and the size of what it
/// belongs to: the traction along the surface or the normal; of the state the largest of the neighbours of the same
/// unit.
pub fn derivative_error<L: TractionLaw + ?Sized>(
    law: &L,
    point: usize,
    sticking: Sticking,
    (jump, begin): ([f64; 3], &[f64]),
    (d_jump, d_begin): ([f64; 3], &[f64]),
) -> Option<f64> {
    let at = |step: f64| {
        let moved = core::array::from_fn(|q| jump[q] + step * d_jump[q]);
        let begin: Vec<f64> = begin.iter().zip(d_begin).map(|(v, d)| v + step * d).collect();
        let found = evaluate_point(law, point, sticking, moved, &begin);
        let numbers: Vec<f64> = found.traction.iter().chain(&found.end).copied().collect();
        (found.regime, numbers)
    };
    let (regime, here) = at(0.0);
    let here = &here[..];
    let units: Vec<&str> = law.info().state.iter().map(|quantity| quantity.unit).collect();
    let sizes: Vec<f64> = (0..here.len())
        .map(|i| match i {
            0 | 1 => here[0].hypot(here[1]),
            2 => here[2].abs(),
            i => {
                let near = (i - 1).max(3)..(i + 2).min(here.len());
                let alike = near.filter(|other| units[other - 3] == units[i - 3]);
                alike.fold(0.0, |most, other| here[other].abs().max(most))
            }
        })
        .collect();
    let pair = |step: f64| {
        let [left, right] = [-step, step].map(&at);
        (left.0 == regime && right.0 == regime).then_some((left.1, right.1))
    };
    // Beside a smooth place the second difference over the step falls with it, at a kink it does not.
    let kinks = |step: f64| {
        let (left, right) = pair(step)?;
        Some((0..here.len()).map(move |i| (left[i] - here[i] + (right[i] - here[i])).abs() / step))
    };
    // From large steps a kink nearby looks like one here.
    for step in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3] {
        let Some((near, far)) = kinks(step).zip(kinks(2.0 * step)) else {
            break;
        };
        for ((near, far), size) in near.zip(far).zip(&sizes) {
            if near > 1e-7 * size && near > 0.7 * far {
                return None;
            }
        }
    }
    // Steps of the input are rounded, too.
    let inputs = jump.iter().zip(&d_jump).chain(begin.iter().zip(d_begin));
    let ratios = inputs.map(|(v, d)| if *d == 0.0 { 0.0 } else { (v / d).abs() });
    let coarsest = ratios.fold(0.0, f64::max);
    const ROUNDING: f64 = 128.0 * f64::EPSILON;
    let quotient = |step: f64| {
        let (left, right) = pair(step)?;
        let of = |i: usize| {
            let value = (right[i] - left[i]) / (2.0 * step);
            let rounding = ROUNDING * left[i].abs().max(right[i].abs()) + f64::EPSILON * coarsest * value.abs();
            (value, rounding / step)
        };
        Some((0..here.len()).map(of).collect())
    };
    let found = derivative_at_point(law, point, sticking, (jump, begin), (d_jump, d_begin));
    let derivatives: Vec<f64> = found.d_traction.iter().chain(&found.d_end).copied().collect();
    let limits: Vec<Vec<(f64, f64)>> = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
        .into_iter()
        .filter_map(|first| extrapolate(first, &quotient))
        .collect();
    let mut worst = 0.0_f64;
    for (i, derivative) in derivatives.into_iter().enumerate() {
        let converged = limits.iter().map(|limit| limit[i]).filter(|(value, uncertainty)| {
            let size = value.abs().max(sizes[i]);
            *uncertainty <= 1e-7 * size || *value == derivative
        });
        let converged: Vec<f64> = converged.map(|(value, _)| value).collect();
        let (least, most) = converged
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| {
                (value.min(least), value.max(most))
            });
        // Kinks beyond small steps and within large ones make these limits differ.
        let size = derivative.abs().max(sizes[i]);
        if converged.len() < 2 || most - least > 2e-7 * size {
            return None;
        }
        if size > 0.0 {
            worst = worst.max((derivative - least).abs().max((derivative - most).abs()) / size);
        }
    }
    Some(worst)
}

/// Limits of difference quotients, given with their rounding, for vanishing step with their uncertainties, by the table
/// of polynomial extrapolation in the square of the step; the first step is the largest one at which there is a
/// quotient.
fn extrapolate(step: f64, quotient: &impl Fn(f64) -> Option<Vec<(f64, f64)>>) -> Option<Vec<(f64, f64)>> {
    const RATIO: f64 = 2.0;
    const ROWS: i32 = 8;
    let first = (0..10)
        .map(|i| step * 0.25_f64.powi(i))
        .find(|&step| quotient(step).is_some())?;
    let values = |found: &[(f64, f64)]| -> Vec<f64> { found.iter().map(|(value, _)| *value).collect() };
    let mut above: Vec<Vec<f64>> = vec![values(&quotient(first)?)];
    let mut best = vec![(f64::NAN, f64::INFINITY); above[0].len()];
    for row in 1..ROWS {
        let step = first / RATIO.powi(row);
        let Some(quotient) = quotient(step) else { break };
        let mut current = vec![values(&quotient)];
        for (column, before) in (1..).zip(&above) {
            let factor = RATIO.powi(2 * column);
            let same = &current[current.len() - 1];
            let extrapolated = |i: usize| (factor * same[i] - before[i]) / (factor - 1.0);
            let next: Vec<f64> = (0..best.len()).map(extrapolated).collect();
            for i in 0..best.len() {
                let change = (next[i] - same[i]).abs().max((next[i] - before[i]).abs());
                // Quotients of rounded values may agree by chance.
                let uncertainty = change + quotient[i].1;
                if uncertainty < best[i].1 {
                    best[i] = (next[i], uncertainty);
                }
            }
            current.push(next);
        }
        above = current;
    }
    Some(best)
}

/// Numbers spread evenly over the decades between `lower` and `upper`.
pub fn log_uniform(lower: f64, upper: f64) -> impl Strategy<Value = f64> {
    (lower.ln()..upper.ln()).prop_map(f64::exp)
}

fn special() -> impl Strategy<Value = f64> {
    let tiny = f64::from_bits(1);
    prop::sample::select(vec![0.0, -0.0, tiny, -tiny, f64::MIN_POSITIVE, -f64::MIN_POSITIVE])
}

/// Interferences of closed points, 1e-12 m to 1e-2 m.
pub fn closed_interference() -> impl Strategy<Value = f64> {
    log_uniform(1e-12, 1e-2)
}

/// Interferences of closed and open points, with zeros and denormal numbers.
pub fn interference() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => closed_interference(),
        2 => closed_interference().prop_map(|u| -u),
        1 => special(),
    ]
}

/// Tangential displacements of either sign up to 1e-3 m, with zeros and denormal numbers.
pub fn displacement() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => log_uniform(1e-14, 1e-3),
        4 => log_uniform(1e-14, 1e-3).prop_map(|u| -u),
        1 => special(),
    ]
}

/// Jumps `[u_x, u_y, u_n]`.
pub fn jump() -> impl Strategy<Value = [f64; 3]> {
    (displacement(), displacement(), interference()).prop_map(|(x, y, n)| [x, y, n])
}

/// Begin states `[u_x, u_y, u_n, t_x, t_y]`; open points carry no traction.
pub fn begin_state() -> impl Strategy<Value = [f64; 5]> {
    let traction = || {
        (any::<bool>(), log_uniform(1e-3, 1e9), 0..8).prop_map(|(negative, t, zero)| match (zero, negative) {
            (0, _) => 0.0,
            (_, false) => t,
            (_, true) => -t,
        })
    };
    (jump(), traction(), traction()).prop_map(|([x, y, n], tx, ty)| {
        if n > 0.0 {
            [x, y, n, tx, ty]
        } else {
            [x, y, n, 0.0, 0.0]
        }
    })
}

/// Jumps with begin states, from unrelated to coincident: any of [`jump`] and [`begin_state`], small steps, steps at
/// constant interference, and no step at all.
pub fn step() -> impl Strategy<Value = ([f64; 3], [f64; 5])> {
    (jump(), begin_state(), log_uniform(1e-9, 1e-1), 0..8).prop_map(|(u, mut begin, share, kind)| {
        match kind {
            0 => begin[..3].copy_from_slice(&u),
            1 => begin[2] = u[2],
            2 | 3 => (0..3).for_each(|q| begin[q] = u[q] + share * (begin[q] - u[q])),
            _ => {}
        }
        if begin[2] <= 0.0 {
            begin[3..].fill(0.0);
        }
        (u, begin)
    })
}

/// Fits of eqs. (28), (29) over the domain of their bounds, with and without a range, with either end.
pub fn fitted_curves() -> impl Strategy<Value = FittedCurves> {
    let range = || prop::option::weighted(0.8, (log_uniform(1e-9, 1e-6), log_uniform(3.0, 1e4)));
    let range = move || range().prop_map(|range| range.map(|(lower, ratio)| [lower, lower * ratio]));
    let u_ref = || prop_oneof![Just(1e-6), log_uniform(1e-7, 1e-5)];
    let shape = (10.0..25.0, 0.5..8.0, -0.99..0.99_f64, -2.0..2.0, 0.15..5.0);
    let normal = (shape, u_ref(), range()).prop_map(|((a, b, share, d, e), u_ref, range)| NormalFit {
        a,
        b,
        // At most where the curve stops rising: b = exp(-1/2) |c|/e.
        c: share * b * e * 0.5_f64.exp(),
        d,
        e,
        u_ref,
        t_ref: 1.0,
        range,
    });
    let tangential = || {
        let shape = (20.0..35.0, 0.0..4.0, -2.0..2.0, 0.0..3.0);
        let ends = prop::sample::select(vec![TangentialEnds::Mindlin, TangentialEnds::Constant]);
        (shape, u_ref(), range(), ends).prop_map(|((a, b, c, d), u_ref, range, ends)| TangentialFit {
            a,
            b,
            c,
            d,
            u_ref,
            k_ref: 1.0,
            range,
            ends,
        })
    };
    (normal, tangential(), tangential())
        .prop_map(|(n, x, y)| FittedCurves::try_new(n, [x, y]).expect("fits within their bounds"))
}

/// Constant stiffnesses from 1e9 to 1e15 Pa/m; tangential ones may be zero.
pub fn elastic_curves() -> impl Strategy<Value = ElasticCurves> {
    let stiffness = || log_uniform(1e9, 1e15);
    let tangential = move || prop_oneof![1 => Just(0.0), 7 => stiffness()];
    (stiffness(), tangential(), tangential())
        .prop_map(|(n, x, y)| ElasticCurves::try_new(n, [x, y]).expect("stiffnesses above zero"))
}

/// Friction coefficients from 0 to 10, both included.
pub fn friction_coefficient() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 1 => Just(10.0), 6 => 0.0..10.0, 2 => log_uniform(1e-6, 1.0)]
}
