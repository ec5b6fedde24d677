//! The lowest modes of a large sparse pair, zero-energy modes included.
//!
//! Block Krylov subspace of `(K + sigma M)^-1 M` with full reorthogonalisation in the mass inner product, followed
//! by a Rayleigh-Ritz step on one more inverse iteration and a residual check with the true matrices. The block finds
//! repeated frequencies; the shift makes the matrix definite however many zero-energy modes there are.

use crate::Error;
use crate::factor::SparseCholesky;
use crate::sparse::{diagonal, multiply_into};
use dense_algebra::{Krylov, Limits, product_into};
use faer::{Mat, MatMut, MatRef, unzip, zip};
use sprs::CsMat;

/// Systems of at most this size are always solved whole.
const WHOLE: usize = 128;

/// Motions whose `omega^2` is more than the inverse of this times [`shift`] have no mass but round-off.
const MASSLESS: f64 = 1e-13;

/// Vectors advanced together: more cost little, because each solve reads the whole factor.
const BLOCK: usize = Krylov::WIDTH;

/// `omega^2` over [`shift`] from which a mode stores energy: motions without any are found at 1e-8 of it at most, and bodies on springs of 1 N/m
/// must be told from them.
const ENERGY: f64 = 1e-6;

/// Most vectors of a subspace, relative to the number of modes.
const MOST_VECTORS: usize = 20;

/// Modes of `K phi = omega^2 M phi` in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// `omega^2` (rad^2/s^2); zero-energy modes come first with values at round-off.
    pub eigenvalues: Vec<f64>,
    /// Mass-normalised mode shapes, `n x m` (1/sqrt(kg)).
    pub shapes: Mat<f64>,
    /// How many of them cost no energy.
    pub n_zero: usize,
    /// Largest relative residual `|K phi - omega^2 M phi| / ((omega^2 + sigma) |M phi|)` of the modes that store energy, in
    /// the norm of the inverse of the stiffness shifted by sigma ([`shift`]): shifted frequencies are known to its square. A
    /// mode below the shift, such as that of a body on soft springs, is told from the zero-energy modes by its Rayleigh
    /// quotient.
    pub residual: f64,
}

impl Modes {
    /// Frequencies of the modes that store energy (Hz).
    pub fn frequencies(&self) -> Vec<f64> {
        self.eigenvalues[self.n_zero..]
            .iter()
            .map(|w2| w2.sqrt() / (2.0 * std::f64::consts::PI))
            .collect()
    }

    /// The zero-energy mode shapes, `n x n_zero`.
    pub fn zero_energy(&self) -> MatRef<'_, f64> {
        self.shapes.subcols(0, self.n_zero)
    }

    /// The mode shapes that store energy.
    pub fn elastic(&self) -> MatRef<'_, f64> {
        self.shapes.subcols(self.n_zero, self.shapes.ncols() - self.n_zero)
    }
}

/// The shift that makes the stiffness definite: far above its round-off, about the first elastic mode of a slender body.
///
/// The ratio of the traces is of the order of the square of the highest frequency of the mesh; round-off in `K` is
/// 1e-16 of it, first elastic modes lie at 1e-9 (slender, fine mesh) to 1e-3 of it. A much smaller shift lets the
/// zero-energy modes swamp all others in round-off, a much larger one slows the iteration.
pub fn shift(stiffness: &CsMat<f64>, mass: &CsMat<f64>) -> f64 {
    1e-8 * diagonal(stiffness).iter().sum::<f64>() / diagonal(mass).iter().sum::<f64>()
}

/// The `n_elastic` lowest modes that store energy, or all that have mass if there are fewer, and all that do not.
///
/// A mode counts as free of energy when its `omega^2` is below 1e-6 of [`shift`] or of the first elastic one found, whichever is larger.
///
/// # Errors
/// [`Error::NotPositiveDefinite`] if `K + sigma M` is not definite, [`Error::EigenNotConverged`] if the residuals of
/// the wanted modes do not fall below `tolerance`.
pub fn lowest_modes(
    stiffness: &CsMat<f64>,
    mass: &CsMat<f64>,
    positions: &[[f64; 3]],
    n_elastic: usize,
    tolerance: f64,
) -> Result<Modes, Error> {
    lowest_modes_within(Limits::default(), stiffness, mass, positions, n_elastic, tolerance)
}

/// As [`lowest_modes`], within limits of time and memory.
///
/// # Errors
/// As [`lowest_modes`]; [`Error::Memory`], [`Error::Interrupted`].
pub fn lowest_modes_within(
    limits: Limits<'_>,
    stiffness: &CsMat<f64>,
    mass: &CsMat<f64>,
    positions: &[[f64; 3]],
    n_elastic: usize,
    tolerance: f64,
) -> Result<Modes, Error> {
    let n = stiffness.rows();
    // A subspace of most of the space gains nothing over the whole.
    if n <= WHOLE || n_elastic > n / 4 {
        return all_modes(stiffness, mass, n_elastic);
    }
    let sigma = shift(stiffness, mass);
    let vectors = (size_of::<f64>() * n * krylov_limit(n_elastic + 8, 0, n)) as u64;
    let beside = (vectors, solves(n_elastic + 8));
    let (factor, limits) =
        SparseCholesky::of_sum(stiffness, sigma, mass, positions, "shifted stiffness", beside, limits)?;
    // The estimate of what has converged within a subspace may be too good. Then a larger one is needed.
    let mut least = 0;
    loop {
        let found = subspace(stiffness, mass, (&factor, sigma), n_elastic, tolerance, least, limits)?;
        let wanted = n_elastic.min(found.modes.eigenvalues.len() - found.modes.n_zero);
        if found.converged >= wanted {
            return Ok(found.modes);
        }
        let next = found.vectors + 6 * BLOCK;
        if next > n.min(MOST_VECTORS * (n_elastic + 8)) {
            return Err(Error::EigenNotConverged {
                converged: found.converged,
                wanted: n_elastic,
                tolerance,
                vectors: found.vectors,
                worst: found.modes.residual,
            });
        }
        least = next;
    }
}

/// Modes from one subspace.
struct SubspaceModes {
    modes: Modes,
    /// Size of the subspace.
    vectors: usize,
    /// Modes that store energy and whose residual is within the tolerance.
    converged: usize,
}

/// As [`lowest_modes`], from a subspace of `least` vectors at least, whatever their residuals.
fn subspace(
    stiffness: &CsMat<f64>,
    mass: &CsMat<f64>,
    (factor, sigma): (&SparseCholesky, f64),
    n_elastic: usize,
    tolerance: f64,
    least: usize,
    limits: Limits<'_>,
) -> Result<SubspaceModes, Error> {
    let n = stiffness.rows();
    // Room for the usual six rigid motions and a few mechanisms; more, if more turn up.
    let mut wanted = (n_elastic + 8).min(n);
    let (eigenvalues, shapes, n_zero, vectors) = loop {
        let (vectors, basis) = krylov_basis(mass, (factor, sigma), (wanted, n_elastic), least, tolerance, limits)?;
        let (eigenvalues, shapes) = rayleigh_ritz(stiffness, mass, basis.as_ref())?;
        let n_zero = count_zero(&eigenvalues, ENERGY * sigma);
        if n_zero + n_elastic <= eigenvalues.len() || wanted == n {
            break (eigenvalues, shapes, n_zero, vectors);
        }
        wanted = (n_zero + n_elastic + 8).max(2 * wanted).min(n);
    };
    let keep = (n_zero + n_elastic).min(eigenvalues.len());
    let elastic = shapes.subcols(n_zero, keep - n_zero);
    let mut residual = Mat::zeros(n, elastic.ncols());
    let mut momentum = residual.clone();
    multiply_into(stiffness, elastic, residual.as_mut());
    multiply_into(mass, elastic, momentum.as_mut());
    for (mode, w2) in eigenvalues[n_zero..keep].iter().enumerate() {
        zip!(residual.col_mut(mode), momentum.col(mode)).for_each(|unzip!(r, m)| *r -= w2 * m);
    }
    // Plain lengths would count the round-off of the stiffest components most, which move the least: with nearly
    // incompressible material they would never be small.
    let residual_lengths = lengths(factor, residual);
    let (mut worst, mut converged) = (0.0_f64, 0);
    for (mode, w2) in eigenvalues[n_zero..keep].iter().enumerate() {
        // The mode is (K + sigma M)^-1 [r + (omega^2 + sigma) M phi], has no part in the residual r and unit mass, so that the
        // momentum has this length.
        let square = residual_lengths[mode].powi(2) / (w2 + sigma);
        let momentum_length = ((1.0 + square) / (w2 + sigma)).sqrt();
        let relative = residual_lengths[mode] / ((w2 + sigma) * momentum_length);
        worst = worst.max(relative);
        converged += usize::from(relative <= tolerance);
    }
    Ok(SubspaceModes {
        modes: Modes {
            eigenvalues: eigenvalues[..keep].to_vec(),
            shapes: shapes.subcols(0, keep).to_owned(),
            n_zero,
            residual: worst,
        },
        vectors,
        converged,
    })
}

/// Lengths of forces in the norm of the inverse of the factorised stiffness.
fn lengths(factor: &SparseCholesky, forces: Mat<f64>) -> Vec<f64> {
    let mut motions = forces.clone();
    factor.solve_in_place(motions.as_mut());
    (0..forces.ncols())
        .map(|j| {
            let work: f64 = forces
                .col(j)
                .iter()
                .zip(motions.col(j).iter())
                .map(|(a, b)| a * b)
                .sum();
            work.max(0.0).sqrt()
        })
        .collect()
}

/// How many of the ascending eigenvalues are round-off: below the `limit`, or 1e-6 of the first above it.
pub fn count_zero(eigenvalues: &[f64], limit: f64) -> usize {
    let first = eigenvalues.iter().copied().find(|w2| *w2 > limit).unwrap_or(limit);
    let zero = |w2: &&f64| **w2 < limit.max(1e-6 * first);
    eigenvalues.iter().take_while(zero).count()
}

/// The lowest modes of a small pair, found with all others.
fn all_modes(stiffness: &CsMat<f64>, mass: &CsMat<f64>, n_elastic: usize) -> Result<Modes, Error> {
    let n = stiffness.rows();
    let mut modes = Modes {
        eigenvalues: Vec::new(),
        shapes: Mat::zeros(n, 0),
        n_zero: 0,
        residual: 0.0,
    };
    if n == 0 {
        return Ok(modes);
    }
    let sigma = shift(stiffness, mass);
    let (mut metric, mut full_mass) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
    for (value, (i, j)) in stiffness {
        metric[(i, j)] += value;
    }
    for (value, (i, j)) in mass {
        metric[(i, j)] += sigma * value;
        full_mass[(i, j)] += value;
    }
    // The mass in the metric of the stiffness, not the other way round: it need not be definite.
    let (inverse, vectors) = dense_algebra::symmetric_pair(full_mass.as_ref(), metric.as_ref())?;
    let massless = inverse.iter().take_while(|theta| **theta * sigma < MASSLESS).count();
    let basis = Mat::from_fn(n, n - massless, |i, j| {
        vectors[(i, n - 1 - j)] / inverse[n - 1 - j].sqrt()
    });
    (modes.eigenvalues, modes.shapes) = rayleigh_ritz(stiffness, mass, basis.as_ref())?;
    let largest = modes.eigenvalues.last().map_or(0.0, |w2| w2.abs());
    // Above the round-off of the decomposition, which is relative to the largest.
    modes.n_zero = count_zero(&modes.eigenvalues, (ENERGY * sigma).max(1e-13 * largest));
    let keep = (modes.n_zero + n_elastic).min(modes.eigenvalues.len());
    modes.eigenvalues.truncate(keep);
    modes.shapes.truncate(n, keep);
    Ok(modes)
}

/// Solves that the `wanted` lowest modes usually take: those of the subspace, of one more inverse iteration, and of the residuals.
fn solves(wanted: usize) -> usize {
    4 * wanted + 2 * BLOCK
}

/// Most vectors of a subspace for the `wanted` lowest modes of `n`.
fn krylov_limit(wanted: usize, least: usize, n: usize) -> usize {
    (6 * wanted + 60).max(least).min(n)
}

/// Approximations of the `wanted` lowest modes, and the size of the subspace they come from, `least` vectors if there are so many. Those without energy and
/// `n_elastic` of the others are found to the `tolerance`.
fn krylov_basis(
    mass: &CsMat<f64>,
    (factor, sigma): (&SparseCholesky, f64),
    (wanted, n_elastic): (usize, usize),
    least: usize,
    tolerance: f64,
    limits: Limits<'_>,
) -> Result<(usize, Mat<f64>), Error> {
    let n = mass.rows();
    let limit = krylov_limit(wanted, least, n);
    let multiply = |x: MatRef<'_, f64>, y: MatMut<'_, f64>| multiply_into(mass, x, y);
    let is_zero = |theta: &&f64| 1.0 / **theta < (1.0 + ENERGY) * sigma;
    let needed = |values: &[f64]| (values.iter().take_while(is_zero).count() + n_elastic).min(wanted);
    let mut krylov = Krylov::new(n, limit);
    let mut block = dense_algebra::scattered(n, BLOCK.min(n));
    loop {
        if limits.stops() {
            return Err(Error::Interrupted);
        }
        block = krylov.append(&multiply, block);
        // The true residual weighs the stiffest components most, the Ritz residual the softest: demand more of it.
        let done = krylov.size() >= least.max(2 * wanted) && krylov.converged(needed, 1e-3 * tolerance)?;
        if done || krylov.size() >= limit || block.ncols() == 0 {
            break;
        }
        factor.solve_in_place(block.as_mut());
        krylov.follow(block.ncols());
        limits.done(krylov.size() as f64 / solves(wanted).max(krylov.size() + wanted) as f64);
    }
    // The zero-energy modes dominate the projected operator, and its round-off mixes the higher modes with their
    // neighbours: keep those too, and let the Rayleigh-Ritz step with the true stiffness part them.
    let (_, shapes) = krylov.ritz_pairs(wanted + BLOCK)?;
    let size = krylov.size();
    // What follows takes as much memory.
    drop(krylov);
    // One more inverse iteration damps what is left of the stiff components.
    let mut image = Mat::zeros(n, shapes.ncols());
    multiply_into(mass, shapes.as_ref(), image.as_mut());
    factor.solve_in_place(image.as_mut());
    // It also blows up what the higher modes contain of the zero-energy ones, by omega^2 / sigma: orthogonalise, the
    // lowest first.
    let mut polished = Krylov::new(n, image.ncols());
    for first in (0..image.ncols()).step_by(BLOCK) {
        let width = BLOCK.min(image.ncols() - first);
        polished.append(&multiply, image.subcols(first, width).to_owned());
    }
    Ok((size, polished.into_basis()))
}

/// Eigenpairs of the pair projected on the columns of `basis`, with mass-normalised vectors.
fn rayleigh_ritz(
    stiffness: &CsMat<f64>,
    mass: &CsMat<f64>,
    basis: MatRef<'_, f64>,
) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let (n, m) = (basis.nrows(), basis.ncols());
    let mut image = Mat::zeros(n, m);
    let mut project = |a: &CsMat<f64>| {
        multiply_into(a, basis, image.as_mut());
        let mut small = Mat::<f64>::zeros(m, m);
        product_into(small.as_mut(), basis.transpose(), image.as_ref());
        Mat::from_fn(m, m, |i, j| 0.5 * (small[(i, j)] + small[(j, i)]))
    };
    let (k, g) = (project(stiffness), project(mass));
    let (values, small) = dense_algebra::symmetric_pair(k.as_ref(), g.as_ref())?;
    let mut vectors = Mat::zeros(n, m);
    product_into(vectors.as_mut(), basis, small.as_ref());
    Ok((values, vectors))
}
