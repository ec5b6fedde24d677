//! The lowest modes of a large sparse pair, zero-energy modes included.
//!
//! Block Krylov subspace of `(K + sigma M)^-1 M` with full reorthogonalisation in the mass inner product, followed
//! by a Rayleigh-Ritz step on one more inverse iteration and a residual check with the true matrices. The block finds
//! repeated frequencies; the shift makes the matrix definite however many zero-energy modes there are. Where these are known
//! beforehand, no shift is needed ([`Pair`]).

use crate::Error;
use crate::factor::SparseCholesky;
use crate::sparse::{diagonal, multiply, multiply_into};
use dense_algebra::{Krylov, Limits, product, product_into};
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

/// Modes found beside those that are wanted where those without energy are not known: room for the usual six rigid motions and a few mechanisms; more, if
/// more turn up.
const ROOM: usize = 8;

/// Square of a length, of motions of unit length, below which one depends on the others.
const INDEPENDENT: f64 = 1e-10;

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
    /// No modes of `n` coordinates.
    pub fn none(n: usize) -> Self {
        Self {
            eigenvalues: Vec::new(),
            shapes: Mat::zeros(n, 0),
            n_zero: 0,
            residual: 0.0,
        }
    }

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

/// Products with a stiffness and a mass, and solves, from which [`Pair::lowest_modes`] finds modes.
pub struct Pair<'a> {
    /// `y = K x` for all columns.
    pub stiffness: &'a Product<'a>,
    /// `y = M x` for all columns.
    pub mass: &'a Product<'a>,
    /// `x = (K + sigma M)^-1 x` for all columns, which are forces. Without a shift, what of them is not in equilibrium may be left out, and
    /// displacements may contain any of the known modes without energy.
    pub solve: &'a Solve<'a>,
    /// The shift `sigma` (rad^2/s^2).
    pub sigma: f64,
    /// `omega^2` from which a mode stores energy ([`least_energy`]).
    pub energy: f64,
    /// Mass-orthonormal modes without energy that are known; there may be none.
    pub zero_energy: MatRef<'a, f64>,
}

/// `y = a x` for all columns.
pub type Product<'a> = dyn Fn(MatRef<'_, f64>, MatMut<'_, f64>) + Sync + 'a;

/// `x = a^-1 x` for all columns.
pub type Solve<'a> = dyn Fn(MatMut<'_, f64>) + Sync + 'a;

/// The shift that makes the stiffness definite: far above its round-off, about the first elastic mode of a slender body.
///
/// The ratio of the traces is of the order of the square of the highest frequency of the mesh; round-off in `K` is
/// 1e-16 of it, first elastic modes lie at 1e-9 (slender, fine mesh) to 1e-3 of it. A much smaller shift lets the
/// zero-energy modes swamp all others in round-off, a much larger one slows the iteration.
pub fn shift(stiffness: &CsMat<f64>, mass: &CsMat<f64>) -> f64 {
    1e-8 * diagonal(stiffness).iter().sum::<f64>() / diagonal(mass).iter().sum::<f64>()
}

/// `omega^2` from which a mode of this pair stores energy.
pub fn least_energy(stiffness: &CsMat<f64>, mass: &CsMat<f64>) -> f64 {
    ENERGY * shift(stiffness, mass)
}

/// Whether all modes of so many coordinates are found where `n_elastic` are wanted: a subspace of most of the space gains nothing over the whole.
pub fn finds_all(n: usize, n_elastic: usize) -> bool {
    n <= WHOLE || n_elastic > n / 4
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
    if finds_all(n, n_elastic) {
        return all_modes(stiffness, mass, n_elastic);
    }
    let sigma = shift(stiffness, mass);
    let vectors = (size_of::<f64>() * n * krylov_limit(n_elastic + ROOM, 0, n)) as u64;
    let beside = (vectors, solves(n_elastic + ROOM));
    let (factor, limits) =
        SparseCholesky::of_sum(stiffness, sigma, mass, positions, "shifted stiffness", beside, limits)?;
    let none = Mat::zeros(n, 0);
    let pair = Pair {
        stiffness: &with(stiffness),
        mass: &with(mass),
        solve: &|x| factor.solve_in_place(x),
        sigma,
        energy: ENERGY * sigma,
        zero_energy: none.as_ref(),
    };
    pair.lowest_modes(n_elastic, tolerance, limits)
}

/// Products with a matrix.
fn with(a: &CsMat<f64>) -> impl Fn(MatRef<'_, f64>, MatMut<'_, f64>) + Sync {
    |x, y| multiply_into(a, x, y)
}

/// The motions that cost no energy among combinations of the columns of `candidates`, mass-orthonormal; columns may depend on one another.
///
/// # Errors
/// If the eigenvalues of the small matrices of the candidates do not converge.
pub fn zero_energy_motions(
    stiffness: &CsMat<f64>,
    mass: &CsMat<f64>,
    candidates: MatRef<'_, f64>,
) -> Result<Mat<f64>, Error> {
    let m = candidates.ncols();
    let gram = product(candidates.transpose(), multiply(mass, candidates).as_ref());
    let scale: Vec<f64> = (0..m)
        .map(|i| gram[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip())
        .collect();
    let unit = Mat::from_fn(m, m, |i, j| 0.5 * (gram[(i, j)] + gram[(j, i)]) * scale[i] * scale[j]);
    let (lengths, combinations) = dense_algebra::symmetric_eigen(unit.as_ref())?;
    let dependent = lengths.iter().take_while(|length| **length < INDEPENDENT).count();
    let combinations = Mat::from_fn(m, m - dependent, |i, j| {
        scale[i] * combinations[(i, dependent + j)] / lengths[dependent + j].sqrt()
    });
    let basis = product(candidates, combinations.as_ref());
    let (values, shapes) = rayleigh_ritz(&with(stiffness), &with(mass), basis.as_ref())?;
    let limit = least_energy(stiffness, mass);
    let count = values.iter().take_while(|value| **value < limit).count();
    Ok(shapes.subcols(0, count).to_owned())
}

impl Pair<'_> {
    /// The `n_elastic` lowest modes that store energy, after all that do not.
    ///
    /// # Errors
    /// As [`lowest_modes_within`].
    pub fn lowest_modes(&self, n_elastic: usize, tolerance: f64, limits: Limits<'_>) -> Result<Modes, Error> {
        // The estimate of what has converged within a subspace may be too good. Then a larger one is needed.
        let mut least = 0;
        loop {
            let found = self.subspace(n_elastic, tolerance, least, limits)?;
            let wanted = n_elastic.min(found.modes.eigenvalues.len() - found.modes.n_zero);
            if found.converged >= wanted {
                return Ok(found.modes);
            }
            let next = found.vectors + 6 * BLOCK;
            if next > self.size().min(MOST_VECTORS * (n_elastic + ROOM)) {
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

    /// Coordinates.
    fn size(&self) -> usize {
        self.zero_energy.nrows()
    }

    /// Modes found beside those that are wanted.
    fn room(&self) -> usize {
        match self.sigma > 0.0 {
            true => ROOM,
            false => 0,
        }
    }

    /// As [`Self::lowest_modes`], from a subspace of `least` vectors at least, whatever their residuals.
    fn subspace(
        &self,
        n_elastic: usize,
        tolerance: f64,
        least: usize,
        limits: Limits<'_>,
    ) -> Result<SubspaceModes, Error> {
        let n = self.size();
        let mut wanted = (n_elastic + self.room()).min(n);
        let (eigenvalues, shapes, n_zero, vectors) = loop {
            let (vectors, basis) = self.krylov_basis((wanted, n_elastic), least, tolerance, limits)?;
            let (eigenvalues, shapes) = rayleigh_ritz(self.stiffness, self.mass, basis.as_ref())?;
            let n_zero = count_zero(&eigenvalues, self.energy);
            if n_zero + n_elastic <= eigenvalues.len() || wanted == n {
                break (eigenvalues, shapes, n_zero, vectors);
            }
            wanted = (n_zero + n_elastic + ROOM).max(2 * wanted).min(n);
        };
        let keep = (n_zero + n_elastic).min(eigenvalues.len());
        let elastic = shapes.subcols(n_zero, keep - n_zero);
        let mut residual = Mat::zeros(n, elastic.ncols());
        let mut momentum = residual.clone();
        (self.stiffness)(elastic, residual.as_mut());
        (self.mass)(elastic, momentum.as_mut());
        for (mode, w2) in eigenvalues[n_zero..keep].iter().enumerate() {
            zip!(residual.col_mut(mode), momentum.col(mode)).for_each(|unzip!(r, m)| *r -= w2 * m);
        }
        // Plain lengths would count the round-off of the stiffest components most, which move the least: with nearly
        // incompressible material they would never be small.
        let residual_lengths = self.lengths(residual);
        let (mut worst, mut converged) = (0.0_f64, 0);
        for (mode, w2) in eigenvalues[n_zero..keep].iter().enumerate() {
            let shifted = w2 + self.sigma;
            // The mode is (K + sigma M)^-1 [r + (omega^2 + sigma) M phi], has no part in the residual r and unit mass, so that the
            // momentum has this length.
            let square = residual_lengths[mode].powi(2) / shifted;
            let momentum_length = ((1.0 + square) / shifted).sqrt();
            let relative = residual_lengths[mode] / (shifted * momentum_length);
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

    /// Lengths of forces in the norm of the inverse of the shifted stiffness.
    fn lengths(&self, forces: Mat<f64>) -> Vec<f64> {
        let mut motions = forces.clone();
        (self.solve)(motions.as_mut());
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

    /// Approximations of the `wanted` lowest modes, and the size of the subspace they come from, `least` vectors if there are so many. Those without energy and
    /// `n_elastic` of the others are found to the `tolerance`.
    fn krylov_basis(
        &self,
        (wanted, n_elastic): (usize, usize),
        least: usize,
        tolerance: f64,
        limits: Limits<'_>,
    ) -> Result<(usize, Mat<f64>), Error> {
        let n = self.size();
        let limit = krylov_limit(wanted, least, n);
        let is_zero = |theta: &&f64| 1.0 / **theta < self.sigma + self.energy;
        let needed = |values: &[f64]| (values.iter().take_while(is_zero).count() + n_elastic).min(wanted);
        let n_known = self.zero_energy.ncols();
        let mut krylov = Krylov::new(n, limit + n_known);
        krylov.leave_out(self.mass, self.zero_energy);
        let mut block = dense_algebra::scattered(n, BLOCK.min(n));
        // Motions that can be, not any.
        (self.solve)(block.as_mut());
        loop {
            if limits.stops() {
                return Err(Error::Interrupted);
            }
            block = krylov.append(self.mass, block);
            let size = krylov.size() - n_known;
            // One more inverse iteration and the Rayleigh-Ritz step make the true residual ten times smaller than the Ritz residual, or more.
            let done = size >= least.max(2 * wanted) && krylov.converged(needed, tolerance)?;
            if done || size >= limit || block.ncols() == 0 {
                break;
            }
            (self.solve)(block.as_mut());
            krylov.follow(block.ncols());
            limits.done(size as f64 / solves(wanted).max(size + wanted) as f64);
        }
        // With a shift, the zero-energy modes dominate the projected operator, and its round-off mixes the higher modes with their
        // neighbours: keep those too, and let the Rayleigh-Ritz step with the true stiffness part them. Solves take whole blocks.
        let (_, shapes) = krylov.ritz_pairs((wanted + self.room()).next_multiple_of(BLOCK))?;
        let size = krylov.size() - n_known;
        // What follows takes as much memory.
        drop(krylov);
        // One more inverse iteration damps what is left of the stiff components.
        let mut image = Mat::zeros(n, shapes.ncols());
        (self.mass)(shapes.as_ref(), image.as_mut());
        (self.solve)(image.as_mut());
        // It also blows up what the higher modes contain of the zero-energy ones, by omega^2 / sigma: orthogonalise, the
        // lowest first.
        let mut polished = Krylov::new(n, n_known + image.ncols());
        polished.leave_out(self.mass, self.zero_energy);
        for first in (0..image.ncols()).step_by(BLOCK) {
            let width = BLOCK.min(image.ncols() - first);
            polished.append(self.mass, image.subcols(first, width).to_owned());
        }
        Ok((size, polished.into_basis()))
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

/// How many of the ascending eigenvalues are round-off: below the `limit`, or 1e-6 of the first above it.
pub fn count_zero(eigenvalues: &[f64], limit: f64) -> usize {
    let first = eigenvalues.iter().copied().find(|w2| *w2 > limit).unwrap_or(limit);
    let zero = |w2: &&f64| **w2 < limit.max(1e-6 * first);
    eigenvalues.iter().take_while(zero).count()
}

/// The lowest modes of a small pair, found with all others.
fn all_modes(stiffness: &CsMat<f64>, mass: &CsMat<f64>, n_elastic: usize) -> Result<Modes, Error> {
    let n = stiffness.rows();
    let mut modes = Modes::none(n);
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
    (modes.eigenvalues, modes.shapes) = rayleigh_ritz(&with(stiffness), &with(mass), basis.as_ref())?;
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

/// Eigenpairs of the pair projected on the columns of `basis`, with mass-normalised vectors.
fn rayleigh_ritz(
    stiffness: &Product<'_>,
    mass: &Product<'_>,
    basis: MatRef<'_, f64>,
) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let (n, m) = (basis.nrows(), basis.ncols());
    let mut image = Mat::zeros(n, m);
    let mut project = |a: &Product<'_>| {
        a(basis, image.as_mut());
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
