//! Linear solves with the tangent, bordered or not: directly, or by GMRES preconditioned with the inverse of the stuck
//! one.

use crate::Error;
use crate::force::PatternView;
use dense_algebra::{
    ConjugateResiduals, Factor, Inner, Inverse, ReflectedInverse, Reflection, SystemMatrixRef, Vector, dot,
};
use faer::{Mat, MatRef};

/// Most GMRES steps before the direct solve takes over.
const MAX_KRYLOV: usize = 100;

/// Fewest coordinates for which reflections are of use.
const LEAST_REFLECTED: usize = 256;

/// Difference between an entry `ij` of the stiffness and its image, relative to the root of the product of the entries `ii` and `jj`, that is round-off.
const REFLECTED: f64 = 1e-8;

/// Largest distance between the stuck structure and its mean with its image, in which the latter takes its place: a Krylov step on two halves is half the
/// work, and where the distance is 0.16 there are a third more of them where little slips, and as many where much does.
const NEAR: f64 = 0.3;

/// Products by which that distance is estimated.
const POWERS: usize = 8;

/// Most directions that are kept for right-hand sides that share a matrix.
const MOST_SEARCHED: usize = 400;

/// A displacement `v` and the force `p = P v` that would hold it in the stuck structure.
///
/// With both at hand a residual costs one product with the inverse of `P`, and a Krylov step one more; neither needs the
/// stiffness or a triangular solve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) v: Vec<f64>,
    pub(crate) p: Vec<f64>,
}

impl Motion {
    pub(crate) fn zero(n: usize) -> Self {
        Self {
            v: vec![0.0; n],
            p: vec![0.0; n],
        }
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.v.copy_from_slice(&other.v);
        self.p.copy_from_slice(&other.p);
    }
}

impl Vector for Motion {
    fn add(&mut self, factor: f64, other: &Self) {
        let add = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(a, b)| *a += factor * b);
        add(&mut self.v, &other.v);
        add(&mut self.p, &other.p);
    }

    fn scale(&mut self, factor: f64) {
        self.v.iter_mut().for_each(|v| *v *= factor);
        self.p.iter_mut().for_each(|p| *p *= factor);
    }
}

/// In the energy of the stuck structure: the norm is `sqrt(v^T P v)`.
impl Inner for Motion {
    fn dot(&self, other: &Self) -> f64 {
        dot(&self.p, &other.v)
    }
}

/// A unit load, and what the stuck structure does under it.
pub(crate) struct UnitLoad {
    pub(crate) force: Vec<f64>,
    pub(crate) response: Motion,
}

impl UnitLoad {
    /// Its energy norm.
    pub(crate) fn norm(&self) -> f64 {
        dot(&self.force, &self.response.v).sqrt()
    }

    pub(crate) fn scale(&mut self, factor: f64) {
        self.force.iter_mut().for_each(|f| *f *= factor);
        self.response.scale(factor);
    }
}

/// Round-off in the contact forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundOff {
    /// Its energy norm, if the errors of the coordinates are independent.
    pub(crate) energy: f64,
    /// Sum of its magnitudes over the coordinates.
    pub(crate) force: f64,
}

/// The structure with everything in contact stuck, or one that is near it and its own mirror image, `P`: preconditioner and energy norm. With another
/// symmetric tangent of the contact it is a preconditioner alone.
#[derive(Clone, Debug)]
pub(crate) struct Stuck {
    flexibility: Flexibility,
    /// Tangent values that went into it (symmetrised).
    tangent: Vec<f64>,
}

/// `P^-1`.
#[derive(Clone, Debug)]
enum Flexibility {
    Whole(Inverse),
    /// Where a reflection leaves `P` as it is.
    Reflected(ReflectedInverse),
}

impl Stuck {
    /// That of `stiffness + tangent`, with a symmetric `tangent`. Where one of the `reflections` leaves the stiffness as it is, and the contact nearly, the
    /// contact is that of its mean with its image.
    pub(crate) fn try_new(
        stiffness: SystemMatrixRef<'_>,
        pattern: PatternView<'_>,
        tangent: &[f64],
        reflections: Vec<Reflection>,
    ) -> Result<Self, Error> {
        match Self::near_image(stiffness, pattern, tangent, reflections)? {
            Some(found) => Ok(found),
            None => {
                let factor = stiffness.to_owned().factor_plus(pattern.entries(tangent))?;
                Ok(Self::of_factor(factor, tangent))
            }
        }
    }

    /// The same of a matrix that is factored.
    pub(crate) fn of_factor(factor: Factor, tangent: &[f64]) -> Self {
        Self {
            flexibility: Flexibility::Whole(factor.into_inverse()),
            tangent: tangent.to_vec(),
        }
    }

    /// That with the mean of the contact and its image, where a reflection allows it.
    pub(crate) fn near_image(
        stiffness: SystemMatrixRef<'_>,
        pattern: PatternView<'_>,
        tangent: &[f64],
        reflections: Vec<Reflection>,
    ) -> Result<Option<Self>, Error> {
        let Some(stiffness) = stiffness.dense().filter(|matrix| matrix.nrows() >= LEAST_REFLECTED) else {
            return Ok(None);
        };
        for reflection in reflections {
            if let Some(found) = Self::reflected(stiffness, pattern, tangent, reflection)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    fn reflected(
        stiffness: MatRef<'_, f64>,
        pattern: PatternView<'_>,
        tangent: &[f64],
        reflection: Reflection,
    ) -> Result<Option<Self>, Error> {
        let reflection = reflection.of_first(stiffness.nrows());
        let Some(mean) = reflected_mean(pattern, tangent, &reflection) else {
            return Ok(None);
        };
        let contact = pattern.entries(&mean);
        let Some(inverse) = ReflectedInverse::try_new(stiffness, contact, &reflection, REFLECTED)? else {
            return Ok(None);
        };
        let found = Self {
            flexibility: Flexibility::Reflected(inverse),
            tangent: mean,
        };
        Ok((found.distance(pattern, tangent, stiffness.nrows()) <= NEAR).then_some(found))
    }

    /// Largest change of a displacement, relative and in the energy norm, where a symmetric contact tangent takes the place of the one in `P`: by
    /// powers of `P^-1 dT`, from below.
    fn distance(&self, pattern: PatternView<'_>, tangent: &[f64], n: usize) -> f64 {
        let difference: Vec<f64> = tangent.iter().zip(&self.tangent).map(|(a, b)| a - b).collect();
        // Of no symmetry.
        let start: Vec<f64> = (0..n).map(|i| (1.0 + i as f64).sin()).collect();
        let mut motion = self.response(&start);
        let mut largest = 0.0;
        for _ in 0..POWERS {
            let length = motion.norm();
            if length == 0.0 {
                break;
            }
            motion.scale(1.0 / length);
            motion.p.fill(0.0);
            pattern.add_product(&difference, &motion.v, &mut motion.p);
            self.solve_into(&motion.p, &mut motion.v);
            largest = motion.norm();
        }
        largest
    }

    /// That at the tangent of a state that slips, symmetrised: a preconditioner beside the stuck one. None of a structure in blocks, whose factors are
    /// large, and where the tangent is not positive definite.
    pub(crate) fn slipping(
        stiffness: SystemMatrixRef<'_>,
        pattern: PatternView<'_>,
        tangent: &[f64],
        reflections: Vec<Reflection>,
    ) -> Option<Self> {
        stiffness.dense()?;
        Self::try_new(stiffness, pattern, &symmetrised(pattern, tangent), reflections).ok()
    }

    /// Sum of the differences of tangent values (N/m).
    fn difference(&self, tangent: &[f64]) -> f64 {
        self.tangent.iter().zip(tangent).map(|(a, b)| (a - b).abs()).sum()
    }

    /// Whether the contact in `P` is much nearer to `tangent` than the one in `other`.
    pub(crate) fn is_nearer(&self, tangent: &[f64], other: &Self) -> bool {
        2.0 * self.difference(tangent) < other.difference(tangent)
    }

    /// Tangent values of the contact in `P`.
    pub(crate) fn tangent(&self) -> &[f64] {
        &self.tangent
    }

    /// `v = P^-1 p`.
    pub(crate) fn solve_into(&self, p: &[f64], v: &mut [f64]) {
        match &self.flexibility {
            Flexibility::Whole(inverse) => inverse.product_into(p, v),
            Flexibility::Reflected(inverse) => inverse.product_into(p, v),
        }
    }

    /// Memory that a product with `P^-1` reads.
    pub(crate) fn bytes(&self) -> usize {
        match &self.flexibility {
            Flexibility::Whole(inverse) => inverse.bytes(),
            Flexibility::Reflected(inverse) => inverse.bytes(),
        }
    }

    /// Round-off that evaluating the contact force `force` at the displacements `u` leaves.
    pub(crate) fn round_off(&self, pattern: PatternView<'_>, u: &[f64], force: &[f64]) -> RoundOff {
        let tangent: Vec<f64> = self.tangent.iter().map(|t| t.abs()).collect();
        let u: Vec<f64> = u.iter().map(|u| u.abs()).collect();
        let mut size: Vec<f64> = force.iter().map(|f| f.abs()).collect();
        pattern.add_product(&tangent, &u, &mut size);
        let diagonal: Vec<f64> = match &self.flexibility {
            Flexibility::Whole(inverse) => inverse.diagonal(),
            Flexibility::Reflected(inverse) => inverse.diagonal(),
        };
        let squares = size.iter().zip(diagonal).map(|(f, c)| f * f * c);
        RoundOff {
            energy: f64::EPSILON * squares.sum::<f64>().sqrt(),
            force: f64::EPSILON * size.iter().sum::<f64>(),
        }
    }

    /// The motion under a force `p`.
    pub(crate) fn response(&self, p: &[f64]) -> Motion {
        let mut v = vec![0.0; p.len()];
        self.solve_into(p, &mut v);
        Motion { v, p: p.to_vec() }
    }
}

/// The mean of tangent values and their images; none if an image is not in the pattern.
fn reflected_mean(pattern: PatternView<'_>, values: &[f64], reflection: &Reflection) -> Option<Vec<f64>> {
    let mut out = values.to_vec();
    for row in 0..pattern.indptr.len() - 1 {
        let (image, sign) = reflection.image(row);
        let range = *pattern.indptr.get(image)?..*pattern.indptr.get(image + 1)?;
        for k in pattern.indptr[row]..pattern.indptr[row + 1] {
            let (column, turned) = reflection.image(pattern.indices[k]);
            let at = pattern.indices[range.clone()].binary_search(&column).ok()?;
            out[k] = 0.5 * (values[k] + sign * turned * values[range.start + at]);
        }
    }
    Some(out)
}

pub(crate) fn symmetrised(pattern: PatternView<'_>, values: &[f64]) -> Vec<f64> {
    let mut out = values.to_vec();
    for row in 0..pattern.indptr.len() - 1 {
        for k in pattern.indptr[row]..pattern.indptr[row + 1] {
            let column = pattern.indices[k];
            let range = pattern.indptr[column]..pattern.indptr[column + 1];
            // An entry without a mirror image is halved, as its mirror is zero.
            let mirror = pattern.indices[range.clone()]
                .binary_search(&row)
                .map_or(0.0, |at| values[range.start + at]);
            out[k] = 0.5 * (values[k] + mirror);
        }
    }
    out
}

/// What it adds to a linear system that the load is the inertia `lambda M u` of a motion `u` of given amplitude:
/// `-lambda M` in the matrix, and a border that keeps the solution mass-orthogonal to `u`, with `M u` beside it for the
/// change of `lambda`.
pub(crate) struct Border<'a> {
    pub(crate) mass: SystemMatrixRef<'a>,
    pub(crate) lambda: f64,
    /// The force `M u`, and the stuck structure's response to it.
    pub(crate) inertia: &'a Motion,
}

impl Border<'_> {
    /// Takes the part along the response to `M u` out of a motion; the rest is mass-orthogonal to `u`.
    fn project(&self, motion: &mut Motion) {
        let Motion { v, p } = self.inertia;
        motion.add(-dot(&motion.p, v) / dot(p, v), self.inertia);
    }
}

/// Solves `(stiffness + tangent) x = b`, or the bordered system, by LU; `None` if the matrix is numerically singular, or in blocks.
pub(crate) fn solve_direct(
    stiffness: SystemMatrixRef<'_>,
    pattern: PatternView<'_>,
    tangent: &[f64],
    border: Option<&Border<'_>>,
    b: &[f64],
) -> Option<Vec<f64>> {
    let matrix = pattern.added_to(stiffness.dense()?, tangent);
    let Some(Border { mass, lambda, inertia }) = border else {
        return dense_algebra::solve_general(matrix, b);
    };
    let mass = mass.dense()?;
    let n = b.len();
    // The border has the unit of the matrix; its scale only enters the unknown that is dropped.
    let largest = inertia.p.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    let scale = matrix
        .diagonal()
        .column_vector()
        .iter()
        .fold(0.0_f64, |m, d| m.max(d.abs()))
        / largest;
    let bordered = Mat::from_fn(n + 1, n + 1, |i, j| match (i == n, j == n) {
        (false, false) => matrix[(i, j)] - lambda * mass[(i, j)],
        (true, true) => 0.0,
        _ => scale * inertia.p[i.min(j)],
    });
    let mut right: Vec<f64> = b.to_vec();
    right.push(0.0);
    let mut x = dense_algebra::solve_general(bordered, &right)?;
    x.truncate(n);
    Some(x)
}

/// Solves `(P + dT) x = r` by GMRES on `1 + P^-1 dT` in the inner product of `P`, where `dT` is the difference between
/// the tangent and the stuck one: one product with `P^-1` and a sparse one per step. With a border one product with the
/// mass is added, and the search is kept in the subspace that the border leaves, where the operator is regular although
/// the matrix nearly is not.
///
/// `start` holds the force `r` and the motion `P^-1 r`, `norm` its energy norm. Returns the solution and the number of
/// steps, or `None` if `tolerance` (relative, energy norm) is not reached.
pub(crate) fn solve_krylov(
    stuck: &Stuck,
    pattern: PatternView<'_>,
    tangent: &[f64],
    border: Option<&Border<'_>>,
    start: &Motion,
    norm: f64,
    tolerance: f64,
) -> Option<(Motion, usize)> {
    let n = start.v.len();
    let difference: Vec<f64> = tangent.iter().zip(&stuck.tangent).map(|(a, b)| a - b).collect();
    let scaled = |motion: &Motion, length: f64| Motion {
        v: motion.v.iter().map(|v| v / length).collect(),
        p: motion.p.iter().map(|p| p / length).collect(),
    };
    let mut basis = vec![scaled(start, norm)];
    // Columns of the Hessenberg matrix made triangular by Givens rotations, and the rotated right-hand side.
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut rotations: Vec<(f64, f64)> = Vec::new();
    let mut rhs = vec![norm];
    let mut image = Motion::zero(n);
    for step in 0..MAX_KRYLOV.min(n) {
        match border {
            None => image.p.fill(0.0),
            Some(border) => {
                border.mass.multiply(&basis[step].v, &mut image.p);
                image.p.iter_mut().for_each(|p| *p *= -border.lambda);
            }
        }
        pattern.add_product(&difference, &basis[step].v, &mut image.p);
        stuck.solve_into(&image.p, &mut image.v);
        image.add(1.0, &basis[step]);
        if let Some(border) = border {
            border.project(&mut image);
        }
        let mut h = Vec::with_capacity(step + 2);
        for known in &basis {
            let c = dot(&image.p, &known.v);
            image.add(-c, known);
            h.push(c);
        }
        let length = image.norm();
        for (i, &(c, s)) in rotations.iter().enumerate() {
            (h[i], h[i + 1]) = (c * h[i] + s * h[i + 1], c * h[i + 1] - s * h[i]);
        }
        let radius = h[step].hypot(length);
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let (c, s) = (h[step] / radius, length / radius);
        h[step] = radius;
        rotations.push((c, s));
        columns.push(h);
        let last = rhs[step];
        rhs[step] = c * last;
        rhs.push(-s * last);
        if rhs[step + 1].abs() <= tolerance * norm || length <= f64::EPSILON * radius {
            let m = step + 1;
            let mut y = vec![0.0; m];
            for i in (0..m).rev() {
                let known: f64 = (i + 1..m).map(|j| columns[j][i] * y[j]).sum();
                y[i] = (rhs[i] - known) / columns[i][i];
            }
            let mut x = Motion::zero(n);
            for (vector, c) in basis.iter().zip(&y) {
                x.add(*c, vector);
            }
            return Some((x, m));
        }
        basis.push(scaled(&image, length));
    }
    None
}

/// [`solve_krylov`] for the force `r` with `near` in the place of the stuck structure, to which the solution belongs; one product more.
pub(crate) fn solve_near(
    near: &Stuck,
    stuck: &Stuck,
    pattern: PatternView<'_>,
    tangent: &[f64],
    r: &[f64],
    tolerance: f64,
) -> Option<(Motion, usize)> {
    let start = near.response(r);
    let (mut x, steps) = solve_krylov(near, pattern, tangent, None, &start, start.norm(), tolerance)?;
    // The force that holds the motion is another one there.
    let difference: Vec<f64> = stuck.tangent.iter().zip(&near.tangent).map(|(a, b)| a - b).collect();
    pattern.add_product(&difference, &x.v, &mut x.p);
    Some((x, steps + 1))
}

/// Solves `(stiffness + tangent) x = b`, or the bordered system, by GMRES up to `tolerance` (relative, energy norm), and directly where that is not
/// reached; `None` if the matrix is numerically singular, or is in blocks and GMRES does not do.
pub(crate) fn solve(
    stuck: &Stuck,
    stiffness: SystemMatrixRef<'_>,
    pattern: PatternView<'_>,
    tangent: &[f64],
    border: Option<&Border<'_>>,
    b: &[f64],
    tolerance: f64,
) -> Option<Vec<f64>> {
    let mut start = stuck.response(b);
    if let Some(border) = border {
        border.project(&mut start);
    }
    let norm = start.norm();
    if norm == 0.0 {
        return Some(start.v);
    }
    match solve_krylov(stuck, pattern, tangent, border, &start, norm, tolerance) {
        Some((motion, _)) => Some(motion.v),
        None => solve_direct(stiffness, pattern, tangent, border, b),
    }
}

/// Solutions of `(P + dT)^T x = r` for several right-hand sides, on `1 + P^-1 dT^T` in the inner product of `P`. They have much in common:
/// points that slip.
pub(crate) struct TransposedSolves<'a> {
    stuck: &'a Stuck,
    pattern: PatternView<'a>,
    difference: Vec<f64>,
    residuals: ConjugateResiduals<Motion, Motion>,
}

impl<'a> TransposedSolves<'a> {
    pub(crate) fn new(stuck: &'a Stuck, pattern: PatternView<'a>, tangent: &[f64]) -> Self {
        Self {
            stuck,
            pattern,
            difference: tangent.iter().zip(&stuck.tangent).map(|(a, b)| a - b).collect(),
            residuals: ConjugateResiduals::new(MOST_SEARCHED),
        }
    }

    /// The solution for the force `right`, or `None` if `tolerance` (relative, energy norm) is not reached.
    pub(crate) fn solve(&mut self, right: &[f64], tolerance: f64) -> Option<Motion> {
        let (stuck, pattern, difference) = (self.stuck, self.pattern, &self.difference);
        let search = |rest: &Motion| {
            let mut image = Motion::zero(right.len());
            pattern.add_transposed_product(difference, &rest.v, &mut image.p);
            stuck.solve_into(&image.p, &mut image.v);
            image.add(1.0, rest);
            Some((rest.clone(), image))
        };
        let rest = stuck.response(right);
        let renew = |rest: &mut Motion| stuck.solve_into(&rest.p, &mut rest.v);
        self.residuals
            .solve(rest, Motion::zero(right.len()), tolerance, renew, search)
    }
}
