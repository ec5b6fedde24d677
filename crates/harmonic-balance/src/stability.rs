//! Stability of forced motions: Hill's method, with the history of the contact followed along what grows.
//!
//! A small change `Re(exp(alpha t) x(t))` of a periodic motion, `x` with its period, keeps the equations if
//!
//! `D(alpha) x = K x + G(alpha) x + M (d/dt + alpha)^2 x + C (d/dt + alpha) x = 0`.
//!
//! `G(alpha) x` is the change of the contact force, divided by `exp(alpha t)`. Without history it does not depend on `alpha`, and the method is Hill's. With
//! friction it is found by following the derivative of the law along the growing change for as many periods as the motion itself, so that the states
//! at which points begin to slip or turn back take part. `alpha` is a Floquet exponent and `exp(2 pi alpha / omega)` a multiplier of the motion. At
//! `alpha = 0` the matrix is the Jacobian of harmonic balance: one exponent vanishes where a curve of forced responses turns back.
//!
//! The eigenvalue problem is projected on few vectors: the modes whose frequencies the harmonics reach, each with the harmonic nearest to it, the
//! motion, its rate, and what the preconditioner answers to the residuals (nonlinear Arnoldi method, Voss 2004, DOI 10.1023/B:BITN.0000039424.56697.8b).
//! In it `G` is linear in `alpha`; the exponents are then corrected with the whole of it.

use crate::force::PointwiseForce;
use crate::forced::Point;
use crate::harmonics::{Harmonics, add_rotated};
use crate::solve::{Failure, Reason};
use crate::system::{Derivative, System, Unknown};
use nalgebra::{Complex, DMatrix, DVector, SVD, Schur};
use std::f64::consts::TAU;

/// Residual of an eigenvector, in the energy norm relative to its own, that is searched for.
const TOLERANCE: f64 = 1e-6;

/// Most times that residuals are added to what is searched in.
const MOST_ROUNDS: usize = 15;

/// Vectors whose part outside of those before is smaller than this, relative to them, bring nothing new.
const NOTHING_NEW: f64 = 1e-9;

/// Growth per period from which the change of the contact force with `alpha` is found.
const SMALL_GROWTH: f64 = 1e-5;

/// Most corrections of an exponent, its error relative to the frequency at which they end, and the largest one that is made, over a period.
const MOST_CORRECTIONS: usize = 30;
const SETTLED: f64 = 1e-7;
const LARGEST_CORRECTION: f64 = 0.3;

/// Distance from the edges of the strip of width `omega`, relative to half of it, within which an exponent is found a second time on the other side, and
/// within which the two are one.
const NEAR_EDGE: f64 = 0.04;
const EDGE: f64 = 1e-6;

/// Distance of a mode from a multiple of the frequency, relative to the frequency, up to which it begins with that harmonic: midway between two it
/// needs both, because there they excite one another.
const NEIGHBOUR: f64 = 0.75;

/// Imaginary part of a multiplier, relative to its real part, up to which it passes for real.
const REAL: f64 = 1e-4;

/// A Floquet exponent of a motion; of a pair the one with the positive imaginary part.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Exponent {
    /// Rate of growth (1/s).
    pub growth: f64,
    /// Angular frequency of what grows against the motion (rad/s), from 0 to half of that of the motion.
    pub detuning: f64,
    /// Estimate of its error (1/s), from the last correction and the square of the residual of its eigenvector.
    pub error: f64,
}

impl Exponent {
    /// Real and imaginary part of the multiplier of a motion of this angular frequency (rad/s).
    pub fn multiplier(&self, omega: f64) -> [f64; 2] {
        let period = TAU / omega;
        let (sine, cosine) = (self.detuning * period).sin_cos();
        let size = (self.growth * period).exp();
        [size * cosine, size * sine]
    }
}

/// How a motion loses its stability.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Bifurcation {
    /// A multiplier passes 1: the curve turns back, or branches.
    Fold,
    /// A multiplier passes -1: a motion of twice the period branches off.
    PeriodDoubling,
    /// A pair passes the unit circle elsewhere: a motion with a second frequency branches off.
    NeimarkSacker,
}

/// Whether all exponents decay; `None` where errors leave it open, or where there are none.
pub fn is_stable(exponents: &[Exponent]) -> Option<bool> {
    if exponents.iter().any(|e| e.growth > e.error) {
        Some(false)
    } else if !exponents.is_empty() && exponents.iter().all(|e| e.growth < -e.error) {
        Some(true)
    } else {
        None
    }
}

/// What happens between two motions of which both are judged, each given with its angular frequency (rad/s).
pub fn bifurcation(one: (f64, &[Exponent]), other: (f64, &[Exponent])) -> Option<Bifurcation> {
    let growing = |(omega, of): (f64, &[Exponent])| {
        let mut found: Vec<Exponent> = of.iter().copied().filter(|e| e.growth > e.error).collect();
        found.sort_by(|a, b| a.growth.total_cmp(&b.growth));
        (omega, found)
    };
    let (less, (omega, more)) = match [growing(one), growing(other)] {
        [a, b] if a.1.len() <= b.1.len() => (a.1.len(), b),
        [a, b] => (b.1.len(), a),
    };
    // The least of them has passed last.
    let passed = more.first().filter(|_| more.len() > less)?;
    let [cosine, sine] = passed.multiplier(omega);
    Some(match (sine.abs() <= REAL * cosine.abs(), cosine > 0.0) {
        (true, true) => Bifurcation::Fold,
        (true, false) => Bifurcation::PeriodDoubling,
        _ => Bifurcation::NeimarkSacker,
    })
}

/// A real vector, and what the parts of `D` that do not depend on `alpha`, are linear and quadratic in it make of it.
struct Direction {
    v: Harmonics,
    p: Harmonics,
    whole: [Harmonics; 3],
}

type Pair = [Harmonics; 2];

/// Floquet exponents of a forced motion, one or a pair for each mode whose frequency the harmonics reach.
pub(crate) fn exponents<F: PointwiseForce>(system: &System<'_, F>, point: &Point) -> Result<Vec<Exponent>, Failure> {
    let mut unknown = Unknown {
        p: point.displacement.clone(),
        v: point.displacement.clone(),
        parameters: [point.omega * point.omega, 0.0, point.force],
    };
    system.restore(&mut unknown);
    let mut search = Search {
        system,
        unknown: &unknown,
        omega: point.omega,
        basis: Vec::new(),
        products: Default::default(),
    };
    let n_modes = search.begin();
    let n_first = search.basis.len();
    let [v, p] = [&unknown.v, &unknown.p];
    search.add(v.clone(), p.clone());
    search.add(rate(v, point.omega), rate(p, point.omega));
    let mut rounds = 0;
    let targets = loop {
        if system.line().limits.stops() {
            return Err(fail(Reason::Interrupted));
        }
        let targets = search.targets(n_first, 2 * n_modes)?;
        let rests: Vec<Pair> = targets.iter().filter_map(|target| search.rest(target)).collect();
        rounds += 1;
        if rests.is_empty() || rounds > MOST_ROUNDS {
            break targets;
        }
        let known = search.basis.len();
        for part in rests.into_iter().flatten() {
            let answer = system.solve_stuck(&part);
            let [v, p] = system.precondition(&unknown, &part, &answer);
            search.add(v, p);
        }
        if search.basis.len() == known {
            break targets;
        }
    };
    let found: Vec<Exponent> = targets
        .iter()
        .map(|target| search.exponent(target))
        .collect::<Result<_, _>>()?;
    let inside = |e: &Exponent| e.detuning <= 0.5 * (1.0 + EDGE) * point.omega;
    Ok(found.into_iter().filter(inside).collect())
}

fn fail(reason: Reason) -> Failure {
    Failure {
        reason,
        history: Vec::new(),
    }
}

/// Rate of a periodic vector.
fn rate(x: &Harmonics, omega: f64) -> Harmonics {
    let mut out = Harmonics::zeros(x.size(), x.count());
    for h in 1..=x.count() {
        add_rotated(out.pair_mut(h), x.pair(h), 0.0, h as f64 * omega);
    }
    out
}

/// `sum_j c_j x_j`, real and imaginary part.
fn combine<'x>(coefficients: &DVector<Complex<f64>>, of: impl Iterator<Item = &'x Harmonics>) -> Pair {
    let mut sum: Option<Pair> = None;
    for (c, x) in coefficients.iter().zip(of) {
        let zero = || Harmonics::zeros(x.size(), x.count());
        let [re, im] = sum.get_or_insert_with(|| [zero(), zero()]);
        re.add(c.re, x);
        im.add(c.im, x);
    }
    sum.unwrap_or_else(|| std::array::from_fn(|_| Harmonics::zeros(0, 0)))
}

/// An eigenvalue of the projected problem with its vectors.
struct Target {
    alpha: Complex<f64>,
    right: DVector<Complex<f64>>,
    left: DVector<Complex<f64>>,
}

struct Search<'s, 'a, F: PointwiseForce> {
    system: &'s System<'a, F>,
    unknown: &'s Unknown,
    omega: f64,
    /// Orthonormal in the energy of the stuck structure.
    basis: Vec<Direction>,
    /// `[row][column]` of the three parts of the projected problem.
    products: [Vec<Vec<f64>>; 3],
}

impl<F: PointwiseForce> Search<'_, '_, F> {
    /// Begins with the modes that the harmonics reach: how many these are.
    fn begin(&mut self) -> usize {
        let line = self.system.line();
        let (size, count) = (self.unknown.v.size(), self.unknown.v.count());
        let mut found = 0;
        for (mode, lambda) in line.eigenvalues.iter().enumerate() {
            let ratio = lambda.max(0.0).sqrt() / self.omega;
            if ratio.round() as usize > count {
                continue;
            }
            found += 1;
            let reached = (0..=count).filter(|h| (ratio - *h as f64).abs() <= NEIGHBOUR);
            for column in reached.flat_map(|h| (2 * h).saturating_sub(1)..2 * h + 1) {
                let [mut v, mut p] = [Harmonics::zeros(size, count), Harmonics::zeros(size, count)];
                v.column_mut(column).copy_from_slice(line.shapes.col_as_slice(mode));
                p.column_mut(column).copy_from_slice(self.system.elastic_force(mode));
                self.add(v, p);
            }
        }
        found
    }

    /// Adds what a vector has beside those there, if it is more than round-off.
    fn add(&mut self, mut v: Harmonics, mut p: Harmonics) {
        let norm = |v: &Harmonics, p: &Harmonics| v.dot(p).max(0.0).sqrt();
        let first = norm(&v, &p);
        // Twice, for vectors that lie almost in the space.
        for _ in 0..2 {
            for known in &self.basis {
                let along = v.dot(&known.p);
                v.add(-along, &known.v);
                p.add(-along, &known.p);
            }
        }
        let left = norm(&v, &p);
        if !(left > NOTHING_NEW * first && left.is_finite()) {
            return;
        }
        v.scale(1.0 / left);
        p.scale(1.0 / left);
        let growth = SMALL_GROWTH * self.omega / TAU;
        let none = Harmonics::zeros(v.size(), v.count());
        let contact = self
            .system
            .contact_derivative(self.unknown, [&v, &p], &Derivative::Exact);
        let [mut slope, _] = self
            .system
            .growing_contact(&self.unknown.v, [&v, &none], SMALL_GROWTH.into());
        slope.add(-1.0, &contact);
        let mut whole = self.structure(&v, &p);
        whole[0].add(1.0, &contact);
        whole[1].add(1.0 / growth, &slope);
        let new = Direction { v, p, whole };
        for (power, products) in self.products.iter_mut().enumerate() {
            for (row, known) in products.iter_mut().zip(&self.basis) {
                row.push(known.v.dot(&new.whole[power]));
            }
            let row = self.basis.iter().map(|known| new.v.dot(&known.whole[power]));
            let row: Vec<f64> = row.chain([new.v.dot(&new.whole[power])]).collect();
            products.push(row);
        }
        self.basis.push(new);
    }

    /// What structure and viscous damping make of a vector: the parts of `D` by powers of `alpha`.
    fn structure(&self, v: &Harmonics, p: &Harmonics) -> [Harmonics; 3] {
        let (system, omega) = (self.system, self.omega);
        let mass = system.momentum_of(v);
        let mut constant = p.clone();
        system.subtract_stuck(v, &mut constant);
        let mut linear = rate(&mass, omega);
        constant.add(1.0, &rate(&linear, omega));
        linear.scale(2.0);
        if let Some(damping) = system.damping(v, p, &mass) {
            constant.add(1.0, &rate(&damping, omega));
            linear.add(1.0, &damping);
        }
        [constant, linear, mass]
    }

    fn projected(&self, power: usize) -> DMatrix<f64> {
        let n = self.basis.len();
        DMatrix::from_fn(n, n, |i, j| self.products[power][i][j])
    }

    /// The projected problem at `alpha`.
    fn at(&self, parts: &[DMatrix<f64>; 3], alpha: Complex<f64>) -> DMatrix<Complex<f64>> {
        let [constant, linear, square] = parts;
        let of = |i, j| constant[(i, j)] + alpha * (linear[(i, j)] + alpha * square[(i, j)]);
        DMatrix::from_fn(constant.nrows(), constant.ncols(), of)
    }

    /// As many eigenvalues in the strip about the real axis that is `omega` wide as fill `wanted` dimensions, a pair counting for two: those whose
    /// vectors are most of the first `n_first` ones. Near the edges of the strip each of a pair comes twice.
    fn targets(&self, n_first: usize, wanted: usize) -> Result<Vec<Target>, Failure> {
        let n = self.basis.len();
        let parts: [DMatrix<f64>; 3] = std::array::from_fn(|power| self.projected(power));
        // In units of the frequency, so that all entries are of a kind.
        let [constant, linear, square] = &parts;
        let square = (square * self.omega.powi(2))
            .try_inverse()
            .ok_or_else(|| fail(Reason::LinearSolve))?;
        let mut companion = DMatrix::zeros(2 * n, 2 * n);
        companion.view_mut((0, n), (n, n)).fill_with_identity();
        companion.view_mut((n, 0), (n, n)).copy_from(&(-(&square * constant)));
        companion
            .view_mut((n, n), (n, n))
            .copy_from(&(-(&square * linear) * self.omega));
        if companion.iter().any(|value| !value.is_finite()) {
            return Err(fail(Reason::NotFinite));
        }
        let schur = Schur::try_new(companion, f64::EPSILON, 1000 * n).ok_or_else(|| fail(Reason::LinearSolve))?;
        let inside = |alpha: &&Complex<f64>| alpha.im >= 0.0 && alpha.im <= 0.5 * (1.0 + NEAR_EDGE);
        let values = schur.complex_eigenvalues();
        let mut found = Vec::new();
        for alpha in values.iter().filter(inside) {
            let alpha = alpha * self.omega;
            let svd = SVD::try_new(self.at(&parts, alpha), true, true, f64::EPSILON, 1000 * n);
            let svd = svd.ok_or_else(|| fail(Reason::LinearSolve))?;
            let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
                return Err(fail(Reason::LinearSolve));
            };
            let least = svd.singular_values.imin();
            let right = v_t.row(least).adjoint();
            let first: f64 = right.iter().take(n_first).map(|c| c.norm_sqr()).sum();
            let left = u.column(least).into_owned();
            found.push((first, Target { alpha, right, left }));
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut dimensions = 0;
        let chosen = found.into_iter().map(|(_, target)| target).take_while(|target| {
            let before = dimensions;
            let is_single = target.alpha.im == 0.0 || (2.0 * target.alpha.im / self.omega - 1.0).abs() <= NEAR_EDGE;
            dimensions += if is_single { 1 } else { 2 };
            before < wanted
        });
        Ok(chosen.collect())
    }

    /// The residual of a vector with what `G` is linearised, if it is too large.
    fn rest(&self, target: &Target) -> Option<Pair> {
        let rest = self.residual(target.alpha, &target.right);
        (self.norm(&rest) > TOLERANCE).then_some(rest)
    }

    /// `sum_k alpha^k D_k x`.
    fn residual(&self, alpha: Complex<f64>, right: &DVector<Complex<f64>>) -> Pair {
        let mut factor = Complex::new(1.0, 0.0);
        let mut sum: Option<Pair> = None;
        for power in 0..3 {
            let scaled = right.map(|c| c * factor);
            let part = combine(&scaled, self.basis.iter().map(|d| &d.whole[power]));
            match &mut sum {
                None => sum = Some(part),
                Some(sum) => sum.iter_mut().zip(&part).for_each(|(sum, part)| sum.add(1.0, part)),
            }
            factor *= alpha;
        }
        sum.unwrap_or_else(|| combine(right, self.basis.iter().map(|d| &d.v)))
    }

    fn norm(&self, x: &Pair) -> f64 {
        x.iter()
            .map(|part| part.dot(&self.system.solve_stuck(part)).max(0.0))
            .sum::<f64>()
            .sqrt()
    }

    /// The exponent with the contact as it answers to what grows so: Newton's method on the exponent, and on the vector what the preconditioner answers to
    /// the rest.
    fn exponent(&self, target: &Target) -> Result<Exponent, Failure> {
        let [_, linear, square]: [DMatrix<f64>; 3] = std::array::from_fn(|power| self.projected(power));
        let left = combine(&target.left, self.basis.iter().map(|d| &d.v));
        let mut v = combine(&target.right, self.basis.iter().map(|d| &d.v));
        let mut p = combine(&target.right, self.basis.iter().map(|d| &d.p));
        let mut alpha = target.alpha;
        let slope = {
            let moved = linear.map(Complex::from) + square.map(|value| alpha * (2.0 * value));
            (target.left.adjoint() * moved * &target.right)[(0, 0)]
        };
        let period = TAU / self.omega;
        let (mut error, mut last) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..MOST_CORRECTIONS {
            if self.system.line().limits.stops() {
                return Err(fail(Reason::Interrupted));
            }
            let [re, im] = [0, 1].map(|part| self.structure(&v[part], &p[part]));
            let mut rest = self
                .system
                .growing_contact(&self.unknown.v, [&v[0], &v[1]], alpha * period);
            // What changes with the exponent, without the contact.
            let mut rate: Pair = std::array::from_fn(|_| Harmonics::zeros(v[0].size(), v[0].count()));
            for power in 0..3 {
                let pair = [&re[power], &im[power]];
                add_product(alpha.powu(power as u32), pair, &mut rest);
                if power > 0 {
                    let factor = alpha.powu(power as u32 - 1) * power as f64;
                    add_product(factor, pair, &mut rate);
                }
            }
            let change = -product(&left, &rest) / slope;
            let change = if alpha.im == 0.0 { change.re.into() } else { change };
            add_product(change, [&rate[0], &rate[1]], &mut rest);
            let size = change.norm() * period;
            let residual = self.norm(&rest);
            if !(residual.is_finite() && size.is_finite()) {
                return Err(fail(Reason::NotFinite));
            }
            // As of a Rayleigh quotient: of second order in the residual.
            let estimate = change.norm() + residual * residual / slope.norm();
            // What does not contract is left where it was.
            if size > LARGEST_CORRECTION || residual > last {
                error = error.min(estimate);
                break;
            }
            alpha += change;
            (error, last) = (estimate, residual);
            if error <= SETTLED * self.omega {
                break;
            }
            for part in 0..2 {
                let answer = self.system.solve_stuck(&rest[part]);
                let [step, held] = self.system.precondition(self.unknown, &rest[part], &answer);
                v[part].add(-1.0, &step);
                p[part].add(-1.0, &held);
            }
        }
        Ok(Exponent {
            growth: alpha.re,
            detuning: alpha.im,
            error,
        })
    }
}

/// Adds a complex factor times a vector.
fn add_product(factor: Complex<f64>, [re, im]: [&Harmonics; 2], to: &mut Pair) {
    to[0].add(factor.re, re);
    to[0].add(-factor.im, im);
    to[1].add(factor.im, re);
    to[1].add(factor.re, im);
}

/// `left^H right`.
fn product(left: &Pair, right: &Pair) -> Complex<f64> {
    let dot = |i: usize, j: usize| left[i].dot(&right[j]);
    Complex::new(dot(0, 0) + dot(1, 1), dot(0, 1) - dot(1, 0))
}
