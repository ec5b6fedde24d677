//! The laws a second time, from the method's description alone, with derivatives by dual numbers: tractions and
//! consistent tangents of the crate against them over the whole domain.

use std::cell::Cell;

use proptest::prelude::*;

use super::described::{Described, Quantity3};
use super::dual::{Dual, Real, Rounded};
use super::{STEEL, config, histories, hold, law, memory, remembered, rough, table};
use crate::friction::rule::Memory;
use crate::testing::{
    PointResponse, closed_interference, evaluate_point, fitted_curves, friction_coefficient, log_uniform, step,
    work_along,
};
use crate::*;

/// Normal traction and tangential stiffnesses as functions of the interference.
pub(super) trait Curves {
    fn normal<T: Real>(&self, u: T) -> T;
    fn tangential<T: Real>(&self, q: usize, u: T) -> T;
    /// Largest tangential traction.
    fn limit<T: Real>(&self, mu: f64, u: T) -> T {
        T::from(mu) * self.normal(u)
    }
}

/// `f` and `f'` at `u`.
fn with_slope<T: Real>(f: impl Fn(Dual<T, 1>) -> Dual<T, 1>, u: T) -> (T, T) {
    let f = f(Dual::variable(u, 0));
    (f.value, f.derivatives[0])
}

/// How a curve given up to `end` goes on with a log-slope that is linear in `v = u/end`, in `1/v`, or constant.
enum Beyond {
    Below { exponent: f64 },
    Above,
    AboveToConstant,
}

fn go_on<T: Real>(formula: impl Fn(Dual<Rounded, 1>) -> Dual<Rounded, 1>, end: f64, u: T, beyond: Beyond) -> T {
    let (value, slope) = with_slope(formula, Rounded::from(end));
    let (value, log_slope) = (T::from(value.value), T::from(slope.value * end / value.value));
    let one = T::from(1.0);
    let v = u / T::from(end);
    let change = match beyond {
        // The integral of (p + (g - p) v)/v from 1 to v.
        Beyond::Below { exponent } => {
            let exponent = T::from(exponent);
            exponent * v.ln() + (log_slope - exponent) * (v - one)
        }
        Beyond::Above => log_slope * v.ln(),
        // The integral of g/v^2.
        Beyond::AboveToConstant => log_slope * (one - one / v),
    };
    value * change.exp()
}

fn eq_28<T: Real>(fit: &NormalFit, u: T) -> T {
    let ln_u = (u / T::from(fit.u_ref)).ln();
    let y = (ln_u + T::from(fit.d)) / T::from(fit.e);
    let bell = T::from(fit.c) * (-(y * y) / T::from(2.0)).exp();
    (T::from(fit.a) + T::from(fit.b) * ln_u + bell).exp()
}

fn eq_29<T: Real>(fit: &TangentialFit, u: T) -> T {
    let ln_u = (u / T::from(fit.u_ref)).ln();
    (T::from(fit.a) + T::from(fit.b) * (T::from(fit.d) * (ln_u - T::from(fit.c))).tanh()).exp()
}

/// Eqs. (28), (29) and their continuation.
impl Curves for FittedCurves {
    fn normal<T: Real>(&self, u: T) -> T {
        let fit = self.normal_fit();
        match fit.range {
            Some([lower, _]) if u.value() < lower => {
                go_on(|u| eq_28(fit, u), lower, u, Beyond::Below { exponent: 1.5 })
            }
            Some([_, upper]) if u.value() > upper => go_on(|u| eq_28(fit, u), upper, u, Beyond::Above),
            _ => eq_28(fit, u),
        }
    }

    fn tangential<T: Real>(&self, q: usize, u: T) -> T {
        let fit = &self.tangential_fits()[q];
        let (exponent, above) = match fit.ends {
            TangentialEnds::Mindlin => (0.5, Beyond::Above),
            TangentialEnds::Constant => (0.0, Beyond::AboveToConstant),
        };
        match fit.range {
            Some([lower, _]) if u.value() < lower => go_on(|u| eq_29(fit, u), lower, u, Beyond::Below { exponent }),
            Some([_, upper]) if u.value() > upper => go_on(|u| eq_29(fit, u), upper, u, above),
            _ => eq_29(fit, u),
        }
    }
}

/// Constant stiffnesses.
#[derive(Debug)]
struct Constant {
    normal: f64,
    tangential: [f64; 2],
}

impl Curves for Constant {
    fn normal<T: Real>(&self, u: T) -> T {
        T::from(self.normal) * u
    }

    fn tangential<T: Real>(&self, q: usize, _u: T) -> T {
        T::from(self.tangential[q])
    }
}

/// Curves of the crate as they are: for the friction on top of them.
pub(super) struct AsGiven<'a, C>(pub(super) &'a C);

impl<C: ContactCurves> Curves for AsGiven<'_, C> {
    fn normal<T: Real>(&self, u: T) -> T {
        let x = u.value();
        let (value, slope) = self.0.normal(x);
        u.apply(&[value, slope, slope / x])
    }

    fn tangential<T: Real>(&self, q: usize, u: T) -> T {
        let x = u.value();
        let Jet {
            value,
            slope,
            curvature,
        } = self.0.tangential(x)[q];
        // The third derivative serves the estimate of rounding only.
        u.apply(&[value, slope, curvature, curvature / x])
    }
}

/// Asperities by gap `start..start + width`, with the probability of each piece.
#[derive(Debug, Clone)]
struct Asperities {
    pieces: Vec<(f64, f64, f64)>,
    density: f64,
    radii: [f64; 2],
    reading: TangentialReading,
    nodes: Vec<(f64, f64)>,
}

impl Asperities {
    /// Partial expectation `E[(u - s)_+^n]`.
    fn moment<T: Real>(&self, u: T, n: f64) -> T {
        let mut sum = T::from(0.0);
        for &(start, width, probability) in &self.pieces {
            let a = u - T::from(start);
            let b = a - T::from(width);
            let p = T::from(probability);
            let integral = |x: T| x.pow(n + 1.0) / T::from(n + 1.0);
            sum = sum
                + if a.value() <= 0.0 {
                    T::from(0.0)
                } else if width == 0.0 {
                    p * a.pow(n)
                } else if b.value() <= 0.0 {
                    p / T::from(width) * integral(a)
                } else if b.value() < width {
                    p / T::from(width) * (integral(a) - integral(b))
                } else {
                    // The difference would cancel; far from the singularity ten nodes integrate to rounding.
                    self.nodes.iter().fold(T::from(0.0), |sum, &(x, weight)| {
                        sum + p * T::from(weight) * (a - T::from(width * x)).pow(n)
                    })
                };
        }
        sum
    }
}

impl Curves for Asperities {
    fn normal<T: Real>(&self, u: T) -> T {
        let (modulus, nu) = (STEEL.youngs_modulus, STEEL.poisson_ratio);
        let beta = (self.radii[0] * self.radii[1]).sqrt();
        let factor = self.density * 2.0 / 3.0 * modulus / (1.0 - nu * nu) * beta.sqrt();
        T::from(factor) * self.moment(u, 1.5)
    }

    fn tangential<T: Real>(&self, q: usize, u: T) -> T {
        let (modulus, nu) = (STEEL.youngs_modulus, STEEL.poisson_ratio);
        let shear = modulus / ((2.0 - nu) * (1.0 + nu));
        match self.reading {
            TangentialReading::Mindlin => {
                let beta = (self.radii[0] * self.radii[1]).sqrt();
                T::from(self.density * 2.0 * shear * beta.sqrt()) * self.moment(u, 0.5)
            }
            TangentialReading::Paper => T::from(self.density * 4.0 * shear * self.radii[q]) * self.moment(u, 0.0),
        }
    }
}

/// Nodes and weights of Gauss and Legendre for the interval from 0 to 1.
pub(super) fn gauss_legendre(n: u32) -> Vec<(f64, f64)> {
    let polynomial = |x: f64| {
        let (mut before, mut p) = (1.0, x);
        for k in 2..=n {
            let k = f64::from(k);
            (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
        }
        (p, f64::from(n) * (x * p - before) / (x * x - 1.0))
    };
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (f64::from(i) + 0.75) / (f64::from(n) + 0.5)).cos();
            for _ in 0..20 {
                let (p, slope) = polynomial(x);
                x -= p / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * polynomial(x).1.powi(2)))
        })
        .collect()
}

/// What the description says.
#[derive(Debug)]
pub(super) struct Expected {
    pub(super) regime: Regime,
    pub(super) traction: [Quantity3; 3],
    /// Last two components of the state: tangential tractions, or the elastic stretch.
    pub(super) memory: [Quantity3; 2],
    /// What the elastic stretch adds to the normal traction.
    pub(super) coupling: Quantity3,
    /// Distance from the cone over the slip limit; regime and tangent are open where it is of the order of rounding.
    pub(super) cone_distance: f64,
}

pub(super) fn expected(
    curves: &impl Curves,
    mu: f64,
    rule: HistoryRule,
    sticking: Sticking,
    jump: [f64; 3],
    begin: &[f64],
) -> Expected {
    let number = Quantity3::from;
    if jump[2] <= 0.0 {
        return Expected {
            regime: Regime::Open,
            traction: [number(0.0); 3],
            memory: [number(0.0); 2],
            coupling: number(0.0),
            cone_distance: f64::INFINITY,
        };
    }
    let u: [Quantity3; 3] = std::array::from_fn(|q| Dual::variable(Rounded::from(jump[q]), q));
    let moved: [Quantity3; 3] = std::array::from_fn(|q| u[q] - number(begin[q]));
    let closed_from = number(begin[2].max(0.0));
    let share = if begin[2] < 0.0 {
        (u[2] - closed_from) / moved[2]
    } else {
        number(1.0)
    };
    let normal = curves.normal(u[2]);
    // Stuck tangential tractions.
    let trial: [Quantity3; 2] = std::array::from_fn(|q| {
        rule.described(&Described {
            memory: number(begin[3 + q]),
            u: u[q],
            moved: moved[q],
            u_n: u[2],
            moved_n: moved[2],
            closed_from,
            share,
            k: &|u| with_slope(|u| curves.tangential(q, u), u),
        })
    });

    let limit = curves.limit(mu, u[2]);
    let largest = trial[0].value().abs().max(trial[1].value().abs());
    let length = if largest > 0.0 {
        let [x, y] = trial.map(|t| t / number(largest));
        (x * x + y * y).pow(0.5) * number(largest)
    } else {
        number(0.0)
    };
    let stick = sticking == Sticking::Full || (limit.value() > 0.0 && length.value() <= limit.value());
    // What the trial is scaled by.
    let scale = match (stick, limit.value() > 0.0) {
        (true, _) => number(1.0),
        (false, true) => limit / length,
        (false, false) => number(0.0),
    };
    let tangential = trial.map(|t| if stick { t } else { scale * t });
    let cone_distance = if sticking == Sticking::Full || limit.value() == 0.0 {
        f64::INFINITY
    } else {
        let rounding = length.value.rounding + limit.value.rounding;
        (length.value() - limit.value()).abs() / (rounding.max(limit.value()))
    };
    let (memory, coupling) = match memory(rule) {
        Memory::Traction => (tangential, number(0.0)),
        Memory::Stretch => {
            let stretch = std::array::from_fn(|q| scale * (number(begin[3 + q]) + share * moved[q]));
            let coupling = [0, 1].into_iter().fold(number(0.0), |sum, q| {
                let slope = with_slope(|u| curves.tangential(q, u), u[2]).1;
                sum + slope * stretch[q] * stretch[q] / number(2.0)
            });
            (stretch, coupling)
        }
    };
    Expected {
        regime: if stick { Regime::Stick } else { Regime::Slip },
        traction: [tangential[0], tangential[1], normal + coupling],
        memory,
        coupling,
        cone_distance,
    }
}

/// Largest errors of tractions and tangent, relative to the values where rounding leaves them.
#[derive(Debug, Clone, Copy, Default)]
struct Worst {
    traction: f64,
    tangent: f64,
}

/// Below, numbers lose digits to underflow.
pub(super) const SMALLEST: f64 = 1e-250;

pub(super) fn error(found: f64, expected: Rounded, share: f64) -> f64 {
    if found == expected.value {
        0.0
    } else {
        (found - expected.value).abs() / (expected.value.abs() + share * expected.rounding + SMALLEST)
    }
}

impl Worst {
    fn of(found: &PointResponse, expected: &Expected) -> Self {
        let mut worst = Self::default();
        // Rounding counts with the few units that another order of operations may cost: 1e-14 beside 1e-12 for
        // tractions, 1e-13 beside 1e-9 for tangents.
        for (found, expected) in found.traction.iter().zip(&expected.traction) {
            worst.traction = worst.traction.max(error(*found, expected.value, 1e-2));
        }
        for (found, expected) in found.end[3..].iter().zip(&expected.memory) {
            worst.traction = worst.traction.max(error(*found, expected.value, 1e-2));
        }
        if expected.cone_distance > 1e-11 {
            for (row, expected) in found.tangent.iter().zip(&expected.traction) {
                for (k, mut derivative) in expected.derivatives.into_iter().enumerate() {
                    if k == 2 {
                        // Of a curve that is all but constant, the derivative is known no better than the curve.
                        derivative.rounding += expected.value.rounding / found.end[2];
                    }
                    worst.tangent = worst.tangent.max(error(row[k], derivative, 1e-4));
                }
            }
        }
        worst
    }
}

/// Runs `compare` over many cases and prints the largest errors.
fn measure<S: Strategy>(
    name: &'static str,
    cases: u32,
    strategy: S,
    compare: impl Fn(S::Value) -> Vec<(PointResponse, Expected)>,
) where
    S::Value: std::fmt::Debug,
{
    let config = config(cases, file!(), Some(name));
    let worst = Cell::new(Worst::default());
    let counted = Cell::new([0_u32; 3]);
    hold(config, &strategy, |case| {
        for (found, expected) in compare(case) {
            let here = Worst::of(&found, &expected);
            prop_assert!(
                here.traction <= 1e-12 && here.tangent <= 1e-9,
                "{here:?} {found:?} {expected:?}"
            );
            if expected.cone_distance > 1e-11 {
                prop_assert_eq!(found.regime, expected.regime);
            }
            let so_far = worst.get();
            worst.set(Worst {
                traction: so_far.traction.max(here.traction),
                tangent: so_far.tangent.max(here.tangent),
            });
            let mut counts = counted.get();
            counts[found.regime as usize] += 1;
            counted.set(counts);
        }
        Ok(())
    });
    let [stick, slip, open] = counted.get();
    let Worst { traction, tangent } = worst.get();
    println!(
        "{name}: {stick} stuck, {slip} slipping, {open} open: tractions within {traction:.1e}, tangents {tangent:.1e}"
    );
    assert!(
        stick > cases / 10 && slip > cases / 10,
        "the cases do not cover the regimes"
    );
}

/// Found and expected, by every history rule, with and without the slip limit.
fn both<L: TractionLaw>(
    law: impl Fn(HistoryRule) -> L,
    oracle: &impl Curves,
    mu: f64,
    jump: [f64; 3],
    begin: [f64; 5],
) -> Vec<(PointResponse, Expected)> {
    let mut pairs = Vec::new();
    for history in histories() {
        let (law, begin) = (law(history), remembered(history, begin));
        for sticking in [Sticking::Coulomb, Sticking::Full] {
            let found = evaluate_point(&law, 0, sticking, jump, &begin);
            pairs.push((found, expected(oracle, mu, history, sticking, jump, &begin)));
        }
    }
    pairs
}

/// Steps whose end is closed or clearly open.
fn steps() -> impl Strategy<Value = ([f64; 3], [f64; 5])> {
    (step(), closed_interference()).prop_map(|((mut u, begin), n)| {
        if u[2].abs() < 1e-12 {
            u[2] = n;
        }
        (u, begin)
    })
}

#[test]
fn fitted_law() {
    measure(
        "fitted_law",
        6000,
        (fitted_curves(), friction_coefficient(), steps()),
        |(curves, mu, (jump, begin))| both(|history| law(curves, mu, history), &curves, mu, jump, begin),
    );
}

/// The same in vector registers.
#[test]
fn rough_law() {
    measure(
        "rough_law",
        6000,
        (fitted_curves(), friction_coefficient(), steps()),
        |(curves, mu, (jump, begin))| both(|history| rough(curves, mu, history), &curves, mu, jump, begin),
    );
}

#[test]
fn elastic_law() {
    let strategy = (
        log_uniform(1e9, 1e15),
        prop::array::uniform2(log_uniform(1e9, 1e15)),
        friction_coefficient(),
        steps(),
    );
    measure(
        "elastic_law",
        6000,
        strategy,
        |(normal, tangential, mu, (jump, begin))| {
            let curves = ElasticCurves::try_new(normal, tangential).unwrap();
            let oracle = Constant { normal, tangential };
            both(|history| law(curves, mu, history), &oracle, mu, jump, begin)
        },
    );
}

/// Populations of samples and of quantiles, some of them equal.
fn asperities() -> impl Strategy<Value = (Asperities, AsperitySumCurves)> {
    let gap = || prop_oneof![1 => Just(0.0), 6 => log_uniform(1e-9, 1e-4)];
    let gaps = (prop::collection::vec((gap(), 0.1..1.0_f64), 2..8), any::<bool>()).prop_map(|(mut list, sampled)| {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = list.len();
        let values: Vec<f64> = list.iter().map(|gap| gap.0).collect();
        if sampled {
            let pieces = values.iter().map(|&gap| (gap, 0.0, 1.0 / n as f64)).collect();
            return (pieces, GapDistribution::try_from_samples(values).unwrap());
        }
        let total: f64 = list[1..].iter().map(|gap| gap.1).sum();
        let mut probabilities: Vec<f64> = (0..n)
            .map(|i| list[1..=i].iter().map(|gap| gap.1).sum::<f64>() / total)
            .collect();
        probabilities[n - 1] = 1.0;
        let piece = |i: usize| {
            (
                values[i - 1],
                values[i] - values[i - 1],
                probabilities[i] - probabilities[i - 1],
            )
        };
        let gaps = GapDistribution::try_from_quantiles(&probabilities, &values).unwrap();
        ((1..n).map(piece).collect::<Vec<_>>(), gaps)
    });
    let readings = prop::sample::select(vec![TangentialReading::Mindlin, TangentialReading::Paper]);
    let radii = prop::array::uniform2(log_uniform(1e-5, 1e-2));
    (gaps, log_uniform(1e4, 1e10), radii, readings).prop_map(|((pieces, gaps), density, radii, reading)| {
        let population = AsperityPopulation::try_new(gaps, density, radii).unwrap();
        let curves = AsperitySumCurves::try_new(population, STEEL, reading).unwrap();
        let nodes = gauss_legendre(10);
        let oracle = Asperities {
            pieces,
            density,
            radii,
            reading,
            nodes,
        };
        (oracle, curves)
    })
}

#[test]
fn asperity_sum() {
    measure(
        "asperity_sum",
        4000,
        (asperities(), friction_coefficient(), steps()),
        |((oracle, curves), mu, (jump, begin))| {
            both(|history| law(curves.clone(), mu, history), &oracle, mu, jump, begin)
        },
    );
}

/// Friction on top of a table, whose curves are taken as they are.
#[test]
fn friction_on_a_table() {
    let table = table();
    measure(
        "friction_on_a_table",
        4000,
        (friction_coefficient(), steps()),
        |(mu, (jump, begin))| {
            both(
                |history| law(table.clone(), mu, history),
                &AsGiven(&table),
                mu,
                jump,
                begin,
            )
        },
    );
}

/// Answer of [`HistoryRule::Potential`] as that of a law with the stretch as its memory, and what that adds to `t_n`.
fn potential(curves: &impl Curves, mu: f64, sticking: Sticking, jump: [f64; 3], begin: &[f64]) -> (PointResponse, f64) {
    let found = expected(curves, mu, HistoryRule::Potential, sticking, jump, begin);
    let response = PointResponse {
        traction: found.traction.map(|t| t.value()),
        tangent: found.traction.map(|t| t.derivatives.map(|d| d.value)),
        end: jump.into_iter().chain(found.memory.map(|e| e.value())).collect(),
        regime: found.regime,
    };
    (response, found.coupling.value())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Without slip and opening the tractions are a gradient: the tangent is symmetric. With slip the stretch ends on
    /// the cone of the elastic normal traction, and opening forgets it.
    #[test]
    fn potential_tractions_have_a_potential(
        curves in fitted_curves(), mu in 0.01..10.0_f64, n in closed_interference(), n_begin in closed_interference(),
        e in prop::array::uniform2(-1e-5..1e-5_f64), de in prop::array::uniform2(-1e-6..1e-6_f64),
    ) {
        let begin = [0.0, 0.0, n_begin, e[0], e[1]];
        let jump = [de[0], de[1], n];
        let stuck = potential(&curves, mu, Sticking::Full, jump, &begin).0;
        for (i, k) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (stuck.tangent[i][k], stuck.tangent[k][i]);
            // Off the diagonal stands k' e, from terms of the size of k.
            let scale = a.abs().max(stuck.tangent[0][0].max(stuck.tangent[1][1]) * 1e-3);
            prop_assert!((a - b).abs() <= 1e-12 * scale, "{stuck:?}");
        }
        let found = potential(&curves, mu, Sticking::Coulomb, jump, &begin).0;
        let [x, y, _] = found.traction;
        let limit = mu * ContactCurves::normal(&curves, n).0;
        match found.regime {
            Regime::Slip => prop_assert!((x.hypot(y) / limit - 1.0).abs() < 1e-13),
            _ => prop_assert!(x.hypot(y) <= limit),
        }
        prop_assert_eq!(&potential(&curves, mu, Sticking::Coulomb, [de[0], de[1], 0.0], &begin).0.end[3..], &[0.0; 2]);
    }
}

/// A closed smooth path around a compressed point; with `depth` above 1 it opens on its way.
pub(super) fn closed_path(amplitudes: [f64; 3], phases: [f64; 3], depth: f64, n: u32) -> Vec<[f64; 3]> {
    let mean = amplitudes[2] / depth;
    (0..=n)
        .map(|i| {
            let s = 2.0 * std::f64::consts::PI * f64::from(i % n) / f64::from(n);
            let wave = |q: usize| amplitudes[q] * ((s + phases[q]).sin() + 0.3 * (2.0 * s - phases[q]).cos());
            [wave(0), wave(1), mean + wave(2)]
        })
        .collect()
}

/// Work that a closed path leaves in a point beside the elastic normal work, with a commit at every step, for paths of
/// 250, 500 and 1000 steps.
fn works(path: impl Fn(u32) -> Vec<[f64; 3]>, respond: impl Fn([f64; 3], &[f64]) -> PointResponse) -> [f64; 3] {
    [250, 500, 1000].map(|n| {
        let path = path(n);
        let [x, y, u_n] = path[0];
        work_along(&path, &[x, y, u_n, 0.0, 0.0], &respond).0
    })
}

/// Answer of a law with [`HistoryRule::Potential`] without the normal traction that it has without stretch: the elastic
/// normal work is none on a closed path, but finite steps and rounding would leave some.
fn without_elastic_traction(law: &dyn TractionLaw, u: [f64; 3], begin: &[f64]) -> PointResponse {
    let mut found = evaluate_point(law, 0, Sticking::Coulomb, u, begin);
    let unstretched = evaluate_point(law, 0, Sticking::Coulomb, u, &[u[0], u[1], u[2], 0.0, 0.0]);
    found.traction[2] -= unstretched.traction[2];
    found
}

/// Closed paths through changing interference, from no stretch, with a commit at every step, take up work.
#[test]
fn potential_cycles_dissipate() {
    const CASES: u32 = 100;
    let config = config(CASES, file!(), None);
    let (dissipating, opening) = (Cell::new(0), Cell::new(0));
    let strategy = (
        (fitted_curves(), friction_coefficient()),
        (log_uniform(1e-7, 1e-5), 0.1..1.5_f64),
        prop::array::uniform2(0.01..3.0_f64),
        prop::array::uniform3(0.0..6.3_f64),
    );
    hold(config, &strategy, |((curves, mu), (size, depth), shares, phases)| {
        let amplitudes = [shares[0] * size, shares[1] * size, size];
        let path = |n| closed_path(amplitudes, phases, depth, n);
        let (scalar, vector) = (
            law(curves, mu, HistoryRule::Potential),
            rough(curves, mu, HistoryRule::Potential),
        );
        let of_the_oracle = works(path, |u, begin| {
            let mut found = potential(&curves, mu, Sticking::Coulomb, u, begin);
            found.0.traction[2] = found.1;
            found.0
        });
        let of_the_laws = [
            works(path, |u, begin| without_elastic_traction(&scalar, u, begin)),
            works(path, |u, begin| without_elastic_traction(&vector, u, begin)),
        ];
        // Rounding of the difference of normal tractions over the length of the path.
        let largest = path(1000).iter().fold(0.0_f64, |most, u| most.max(u[2]));
        let rounding = 1e-14 * ContactCurves::normal(&curves, largest.max(1e-12)).0 * 10.0 * size;
        for [coarse, middle, fine] in of_the_laws.into_iter().chain([of_the_oracle]) {
            prop_assert!(
                fine >= -(fine - middle).abs() - (middle - coarse).abs() - rounding,
                "{coarse:e} {middle:e} {fine:e} {rounding:e}"
            );
        }
        let [_, _, oracle] = of_the_oracle;
        for [_, _, fine] in of_the_laws {
            prop_assert!(
                (fine - oracle).abs() <= 1e-9 * oracle.abs() + rounding,
                "{fine:e} {oracle:e} {rounding:e}"
            );
        }
        dissipating.set(dissipating.get() + u32::from(of_the_laws[1][2] > rounding));
        opening.set(opening.get() + u32::from(path(250).iter().any(|u| u[2] <= 0.0)));
        Ok(())
    });
    let (dissipating, opening) = (dissipating.get(), opening.get());
    println!("{dissipating} of {CASES} cycles dissipate, {opening} open on their way");
    assert!(dissipating > CASES / 3 && opening > CASES / 6);
}

/// What a step dissipates per area and the size of its parts: the traction times what the displacement of the closed
/// part of the path did not turn into stretch, eq. (20) for a slip limit at the end of the step.
fn dissipated(found: &PointResponse, jump: [f64; 3], begin: &[f64]) -> (f64, f64) {
    let closed = match (jump[2] > 0.0, begin[2] < 0.0) {
        (false, _) => 0.0,
        (true, false) => 1.0,
        (true, true) => jump[2] / (jump[2] - begin[2]),
    };
    [0, 1].into_iter().fold((0.0, 0.0), |(sum, parts), q| {
        let (t, moved) = (found.traction[q], closed * (jump[q] - begin[q]));
        let (before, after) = (begin[3 + q], found.end[3 + q]);
        // The displacements themselves are rounded before they cancel.
        let size = moved.abs() + before.abs() + after.abs();
        (sum + t * (moved - (after - before)), parts + t.abs() * size)
    })
}

/// In every single step, whatever the curves do, the traction works against the slip.
#[test]
fn potential_steps_dissipate() {
    let config = config(10_000, file!(), None);
    let slipping = Cell::new([0_u32; 2]);
    let worst = Cell::new(0.0_f64);
    let strategy = (fitted_curves(), friction_coefficient(), step());
    hold(config, &strategy, |(curves, mu, (jump, begin))| {
        let begin = remembered(HistoryRule::Potential, begin);
        let laws: [Box<dyn TractionLaw>; 2] = [
            Box::new(law(curves, mu, HistoryRule::Potential)),
            Box::new(rough(curves, mu, HistoryRule::Potential)),
        ];
        for law in laws {
            let found = evaluate_point(&*law, 0, Sticking::Coulomb, jump, &begin);
            let (dissipated, parts) = dissipated(&found, jump, &begin);
            prop_assert!(
                dissipated >= -4.0 * f64::EPSILON * parts,
                "{dissipated:e} {parts:e} {found:?}"
            );
            worst.set(worst.get().min(dissipated / (parts + f64::MIN_POSITIVE)));
            if found.regime == Regime::Slip && dissipated > 1e-3 * parts {
                let [closed, reopened] = slipping.get();
                slipping.set(if begin[2] < 0.0 {
                    [closed, reopened + 1]
                } else {
                    [closed + 1, reopened]
                });
            }
        }
        Ok(())
    });
    let ([closed, reopened], worst) = (slipping.get(), worst.get());
    println!("{closed} closed and {reopened} reopened points dissipate by slip, least share of the parts {worst:.1e}");
    assert!(closed > 1000 && reopened > 200);
}

/// The same cycles tell the rules apart: without a potential some of them give energy away for nothing.
#[test]
fn rules_without_a_potential_can_gain_energy() {
    let curves = super::fitted();
    let work = |rule: HistoryRule, phase: f64| {
        let path = closed_path([1e-7, 0.0, 1e-6], [phase, 0.0, 0.0], 0.5, 4000);
        let [x, y, u_n] = path[0];
        let respond = |u: [f64; 3], begin: &[f64]| {
            let found = expected(&curves, 0.0, rule, Sticking::Full, u, begin);
            PointResponse {
                traction: found.traction.map(|t| t.value()),
                tangent: [[0.0; 3]; 3],
                end: u.into_iter().chain(found.memory.map(|m| m.value())).collect(),
                regime: found.regime,
            }
        };
        work_along(&path, &[x, y, u_n, 0.0, 0.0], respond).0
    };
    let works = |rule| [0.0, 1.0, 2.0, 4.0, 5.0].map(|phase| work(rule, phase));
    let (incremental, conserving) = (works(HistoryRule::Incremental), works(HistoryRule::Potential));
    println!("work of stuck cycles: incremental {incremental:?}, potential {conserving:?} J/m^2");
    let gained = incremental.iter().fold(0.0_f64, |least, w| least.min(*w));
    // What is left to the potential is energy of the stretch at the end, and never negative.
    assert!(gained < 0.0 && conserving.iter().all(|w| *w >= 1e-3 * gained));
}
