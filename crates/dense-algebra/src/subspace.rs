//! A few eigenpairs of a large dense pair.

use crate::{
    Error, cholesky_in_place, product, scattered, solve_lower, solve_lower_transposed, symmetric, symmetric_eigen,
};
use faer::{Mat, MatRef};

/// Most subspace iterations; a dozen are usual.
const MAX_ITERATIONS: usize = 200;

/// Relative change of the eigenvalues from one iteration to the next at which they count as found. Eigenvalues converge with
/// the square of the shapes: round-off in the values is asked for.
const SETTLED: f64 = 1e-13;

/// Round-off in all eigenvalues, relative to the largest: one far below it cannot settle any closer.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Largest part of an eigenvalue that this round-off may be.
const LARGEST_ROUND_OFF: f64 = 1e-6;

/// Change of the eigenvalues, relative to each, that may be the round-off of an ill-conditioned factor: it counts as found where it has
/// not fallen for some iterations.
const LARGEST_PLATEAU: f64 = 1e-9;
const PLATEAU: usize = 5;

/// Shift over the highest eigenvalue sought, where the lowest are so far below it that its inverse drowns in their round-off.
const SHIFT: f64 = 1e-4;

/// Round-off that each of them may have then.
const KNOWN: f64 = 1e-2;

/// The `count` lowest eigenpairs of `L L^T y = lambda m y` for a positive semi-definite `m`, with `y^T m y = 1`,
/// by subspace iteration on `L^-1 m L^-T`, whose eigenvalues are `1 / lambda`. Where these are too far apart, as those of a body on soft
/// springs are, `L L^T` is shifted by a multiple of `m`.
///
/// # Errors
/// [`Error::Rank`] if `m` has fewer than `count` positive eigenvalues, or holds infinities or NaN;
/// [`Error::NoConvergence`].
pub fn lowest_pairs(lower: MatRef<'_, f64>, m: MatRef<'_, f64>, count: usize) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let failed = || Error::NoConvergence { size: m.nrows() };
    let highest = match iterate(lower, m, count)? {
        Ok(found) => return Ok(found),
        Err(highest) => highest,
    };
    let sigma = SHIFT * highest;
    let size = m.nrows();
    let lower = Mat::from_fn(size, size, |i, j| if i < j { 0.0 } else { lower[(i, j)] });
    let stiffness = product(lower.as_ref(), lower.transpose());
    let shifted = Mat::from_fn(size, size, |i, j| stiffness[(i, j)] + sigma * m[(i, j)]);
    let shifted = cholesky_in_place(shifted).map_err(|_| failed())?;
    let (values, shapes) = iterate(shifted.as_ref(), m, count)?.map_err(|_| failed())?;
    let values: Vec<f64> = values.into_iter().map(|value| value - sigma).collect();
    // What round-off in the shift and in the entries of the matrix is to the quotient of a shape.
    let sizes = |a: &Mat<f64>| Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs());
    let (sizes, terms) = (
        sizes(&shapes),
        product(sizes(&stiffness).as_ref(), sizes(&shapes).as_ref()),
    );
    let noise = |j: usize| ROUND_OFF * sigma + f64::EPSILON * (sizes.col(j).transpose() * terms.col(j));
    let are_known = values.iter().enumerate().all(|(j, value)| noise(j) < KNOWN * value);
    if are_known { Ok((values, shapes)) } else { Err(failed()) }
}

/// Eigenvalues and shapes.
type Pairs = (Vec<f64>, Mat<f64>);

/// As [`lowest_pairs`], without a shift; the last estimate of the highest eigenvalue sought where they do not settle.
fn iterate(lower: MatRef<'_, f64>, m: MatRef<'_, f64>, count: usize) -> Result<Result<Pairs, f64>, Error> {
    let size = m.nrows();
    // Forming the product of three matrices would cost more than all iterations.
    let apply = |basis: &Mat<f64>| {
        let mut motions = basis.clone();
        solve_lower_transposed(lower, motions.as_mut());
        let mut image = product(m, motions.as_ref());
        solve_lower(lower, image.as_mut());
        image
    };
    let width = (2 * count + 10).min(size);
    let mut image = scattered(size, width);
    let mut previous = vec![0.0; count];
    let (mut least_change, mut since) = (f64::INFINITY, 0);
    for _ in 0..MAX_ITERATIONS {
        let basis = orthonormal(image)?;
        image = apply(&basis);
        let small = symmetric(product(basis.transpose(), image.as_ref()).as_ref());
        let (ascending, rotation) = symmetric_eigen(small.as_ref())?;
        // Images of the Ritz vectors are nearly orthogonal, however far apart their eigenvalues are.
        image = product(image.as_ref(), rotation.as_ref());
        let values: Vec<f64> = ascending.into_iter().rev().take(count).collect();
        let largest = values.first().copied().unwrap_or_default();
        if values.len() < count || !values.iter().all(|v| *v > f64::EPSILON * largest) {
            return Err(Error::Rank { size, count });
        }
        let round_off = ROUND_OFF * largest;
        let changes = values
            .iter()
            .zip(&previous)
            .map(|(value, before)| (value - before).abs() / value);
        let change = changes.fold(0.0, f64::max);
        since = if change < least_change { 0 } else { since + 1 };
        least_change = change.min(least_change);
        let is_plateau = since >= PLATEAU && change < LARGEST_PLATEAU;
        let settled = values.iter().zip(&previous).all(|(value, before)| {
            let change = (value - before).abs();
            change < SETTLED * value || (change < round_off && round_off < LARGEST_ROUND_OFF * value)
        });
        previous.clone_from(&values);
        if settled || is_plateau {
            let mut shapes = Mat::from_fn(size, count, |i, j| image[(i, image.ncols() - 1 - j)]);
            solve_lower_transposed(lower, shapes.as_mut());
            normalise(&mut shapes, m);
            return Ok(Ok((values.iter().map(|v| 1.0 / v).collect(), shapes)));
        }
    }
    Ok(Err(previous.last().map_or(f64::NAN, |value| 1.0 / value)))
}

/// Makes the columns orthonormal in the inner product of `m`, the first ones first: a far lower eigenvalue enlarges what
/// round-off leaves of its shape in the others.
fn normalise(shapes: &mut Mat<f64>, m: MatRef<'_, f64>) {
    // One product for all shapes, which reads the matrix once; what is taken out of a shape is taken out of its momentum too.
    let mut momenta = product(m, shapes.as_ref());
    for j in 0..shapes.ncols() {
        let common = product(shapes.subcols(0, j).transpose(), momenta.subcols(j, 1));
        let own = |columns: &Mat<f64>| columns.subcols(j, 1) - product(columns.subcols(0, j), common.as_ref());
        let (shape, momentum) = (own(shapes), own(&momenta));
        let length = (shape.col(0).transpose() * momentum.col(0)).sqrt();
        shapes.col_mut(j).copy_from(shape.col(0) / faer::Scale(length));
        momenta.col_mut(j).copy_from(momentum.col(0) / faer::Scale(length));
    }
    // Without the round-off of what was taken out.
    let momenta = product(m, shapes.as_ref());
    for (j, momentum) in momenta.col_iter().enumerate() {
        let length = (shapes.col(j).transpose() * momentum).sqrt();
        shapes.col_mut(j).iter_mut().for_each(|value| *value /= length);
    }
}

/// Orthonormal basis of the space of the columns, by two passes over the eigenvectors of their Gram matrix
/// (Stathopoulos and Wu 2002, SIAM Journal on Scientific Computing 23, 2165-2182); fewer columns than given where some
/// depend on others or are round-off.
fn orthonormal(mut columns: Mat<f64>) -> Result<Mat<f64>, Error> {
    for _ in 0..2 {
        let longest = columns.col_iter().map(|column| column.norm_l2()).fold(0.0, f64::max);
        let round_off = f64::EPSILON * columns.nrows() as f64;
        for column in columns.as_mut().col_iter_mut() {
            let length = column.norm_l2();
            let scale = if length > round_off * longest {
                length.recip()
            } else {
                0.0
            };
            column.iter_mut().for_each(|v| *v *= scale);
        }
        let gram = product(columns.transpose(), columns.as_ref());
        let (values, vectors) = symmetric_eigen(gram.as_ref())?;
        let kept: Vec<usize> = (0..values.len()).filter(|&j| values[j] > round_off).collect();
        let turn = Mat::from_fn(values.len(), kept.len(), |i, j| {
            vectors[(i, kept[j])] / values[kept[j]].sqrt()
        });
        columns = product(columns.as_ref(), turn.as_ref());
    }
    Ok(columns)
}
