//! Modes of the structure linearised about a prestressed state with everything stuck (eq. 39).

use crate::Error;
use crate::error::check_size;
use crate::force::{HystereticForce, Sliding};
use crate::linear::{Motion, Stuck, multiply};
use crate::newton::Equilibrium;
use faer::{Mat, MatRef};

/// The prestressed structure, ready for its loops.
#[derive(Clone, Debug)]
pub struct Linearisation<'a, S> {
    pub(crate) stiffness: MatRef<'a, f64>,
    pub(crate) mass: MatRef<'a, f64>,
    pub(crate) stuck: Stuck,
    pub(crate) displacement: Vec<f64>,
    pub(crate) state: S,
    pub(crate) contact_force: Vec<f64>,
    /// Energy norm of the round-off in the contact forces.
    pub(crate) round_off: f64,
    /// `omega^2` of the modes, ascending (rad^2/s^2).
    pub eigenvalues: Vec<f64>,
    /// Mass-normalised mode shapes, `n x n_modes`.
    pub shapes: Mat<f64>,
}

impl<S> Linearisation<'_, S> {
    /// Displacements of the static state.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// Displacements of the structure with everything in contact stuck under the force `force` (N).
    ///
    /// # Errors
    /// [`Error::Size`].
    pub fn stuck_response(&self, force: &[f64]) -> Result<Vec<f64>, Error> {
        check_size("the force", force.len(), self.shapes.nrows())?;
        Ok(self.stuck.response(force).v)
    }

    /// Equilibrium in increments from the static state.
    pub(crate) fn equilibrium<'b, F: HystereticForce<State = S>>(&'b self, force: &'b F) -> Equilibrium<'b, F> {
        Equilibrium {
            stiffness: self.stiffness,
            force,
            stuck: &self.stuck,
            reference: &self.displacement[..force.n_dofs()],
            reference_force: &self.contact_force,
            round_off: self.round_off,
        }
    }

    /// Frequencies of the modes (Hz).
    pub fn frequencies(&self) -> Vec<f64> {
        self.eigenvalues
            .iter()
            .map(|w2| w2.max(0.0).sqrt() / (2.0 * std::f64::consts::PI))
            .collect()
    }

    /// Turns the signs of the shapes so that the given row (for example a response) is not negative on each of them.
    ///
    /// # Errors
    /// [`Error::Size`].
    pub fn orient(&mut self, row: &[f64]) -> Result<(), Error> {
        check_size("the orientation row", row.len(), self.shapes.nrows())?;
        for mode in 0..self.shapes.ncols() {
            let along: f64 = self.shapes.col(mode).iter().zip(row).map(|(a, b)| a * b).sum();
            if along < 0.0 {
                self.shapes.col_mut(mode).iter_mut().for_each(|v| *v = -*v);
            }
        }
        Ok(())
    }
}

/// The mode that is followed.
pub(crate) struct Mode {
    pub(crate) shape: Vec<f64>,
    /// `omega^2` (rad^2/s^2).
    pub(crate) eigenvalue: f64,
    /// `M phi`, the load of unit modal force, and the stuck structure's response to it.
    pub(crate) unit: Motion,
}

impl Mode {
    /// Mode number `mode`, zero-based.
    pub(crate) fn try_new<S>(structure: &Linearisation<'_, S>, mode: usize) -> Result<Self, Error> {
        let Some(&eigenvalue) = structure.eigenvalues.get(mode) else {
            return Err(Error::Setting {
                field: "mode",
                value: mode as f64,
                requirement: "less than the number of linearised modes (counted from 0)",
            });
        };
        let shape: Vec<f64> = structure.shapes.col(mode).iter().copied().collect();
        let mut load = vec![0.0; shape.len()];
        multiply(structure.mass, &shape, &mut load);
        Ok(Self {
            shape,
            eigenvalue,
            unit: structure.stuck.response(&load),
        })
    }
}

/// Linearises about `displacement` with the committed history `state`, and finds the `n_modes` lowest modes.
///
/// The mass may be semi-definite: massless coordinates are allowed, and there are as many modes as its rank. The stuck
/// tangent is symmetrised: laws whose history rule makes it unsymmetric lose that part here, and only here.
///
/// # Errors
/// Sizes that do not match; [`Error::Dense`] if the stuck structure can still move freely; [`Error::Setting`] if there
/// are fewer than `n_modes` modes.
pub fn linearise<'a, F: HystereticForce>(
    stiffness: MatRef<'a, f64>,
    mass: MatRef<'a, f64>,
    force: &F,
    displacement: Vec<f64>,
    state: F::State,
    n_modes: usize,
) -> Result<Linearisation<'a, F::State>, Error> {
    let n = stiffness.nrows();
    check_size("the mass matrix", mass.nrows(), n)?;
    check_size("the prestress displacement", displacement.len(), n)?;
    let nc = force.n_dofs();
    let mut tangent = vec![0.0; force.pattern().indices.len()];
    let mut contact_force = vec![0.0; nc];
    let mut end = state.clone();
    let mut workspace = force.workspace();
    let u = &displacement[..nc];
    force.evaluate(
        u,
        Sliding::Prevented,
        &state,
        &mut end,
        &mut workspace,
        &mut contact_force,
        Some(&mut tangent),
    );
    // The reference force must be the one that the loops will compute, with friction.
    force.evaluate(
        u,
        Sliding::Allowed,
        &state,
        &mut end,
        &mut workspace,
        &mut contact_force,
        None,
    );
    let (lower, stuck) = Stuck::try_new(stiffness, force.pattern(), &tangent)?;
    let (eigenvalues, shapes) = lowest_modes(lower.as_ref(), mass, n_modes.min(n))?;
    let u = &displacement[..nc];
    Ok(Linearisation {
        stiffness,
        mass,
        round_off: stuck.round_off(force.pattern(), u, &contact_force),
        stuck,
        displacement,
        state,
        contact_force,
        eigenvalues,
        shapes,
    })
}

/// Most subspace iterations; a dozen are usual.
const MAX_ITERATIONS: usize = 200;

/// Subspace iteration on `C = L^-1 M L^-T`, whose eigenvalues are `1 / omega^2`.
fn lowest_modes(lower: MatRef<'_, f64>, mass: MatRef<'_, f64>, n_modes: usize) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let n = mass.nrows();
    let c = dense_algebra::congruent(lower, mass);
    let width = (2 * n_modes + 10).min(n);
    let mut image = dense_algebra::scattered(n, width);
    let mut previous = vec![0.0; n_modes];
    for _ in 0..MAX_ITERATIONS {
        let basis = orthonormal(image)?;
        image = dense_algebra::product(c.as_ref(), basis.as_ref());
        let small = dense_algebra::symmetric(dense_algebra::product(basis.transpose(), image.as_ref()).as_ref());
        let (ascending, rotation) = dense_algebra::symmetric_eigen(small.as_ref())?;
        // Images of the Ritz vectors are nearly orthogonal, however far apart their eigenvalues are.
        image = dense_algebra::product(image.as_ref(), rotation.as_ref());
        let values: Vec<f64> = ascending.into_iter().rev().take(n_modes).collect();
        if values.len() < n_modes || !values.iter().all(|v| *v > 0.0) {
            return Err(Error::Setting {
                field: "n_modes",
                value: n_modes as f64,
                requirement: "no more than the rank of a finite, positive semi-definite mass matrix",
            });
        }
        let change = values
            .iter()
            .zip(&previous)
            .map(|(a, b)| (a / b - 1.0).abs())
            .fold(0.0, f64::max);
        previous.clone_from(&values);
        // Eigenvalues converge with the square of the shapes: ask for round-off in the values.
        if change < 1e-13 {
            let mut shapes = Mat::from_fn(n, n_modes, |i, j| image[(i, image.ncols() - 1 - j)]);
            dense_algebra::solve_lower_transposed(lower, shapes.as_mut());
            normalise(mass, shapes.as_mut());
            return Ok((values.iter().map(|v| 1.0 / v).collect(), shapes));
        }
    }
    Err(Error::Modes {
        iterations: MAX_ITERATIONS,
    })
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
        let gram = dense_algebra::product(columns.transpose(), columns.as_ref());
        let (values, vectors) = dense_algebra::symmetric_eigen(gram.as_ref())?;
        let kept: Vec<usize> = (0..values.len()).filter(|&j| values[j] > round_off).collect();
        let turn = Mat::from_fn(values.len(), kept.len(), |i, j| {
            vectors[(i, kept[j])] / values[kept[j]].sqrt()
        });
        columns = dense_algebra::product(columns.as_ref(), turn.as_ref());
    }
    Ok(columns)
}

fn normalise(mass: MatRef<'_, f64>, mut shapes: faer::MatMut<'_, f64>) {
    let n = mass.nrows();
    let mut image = vec![0.0; n];
    for j in 0..shapes.ncols() {
        let shape: Vec<f64> = (0..n).map(|i| shapes[(i, j)]).collect();
        multiply(mass, &shape, &mut image);
        let length = crate::linear::dot(&shape, &image).sqrt();
        for i in 0..n {
            shapes[(i, j)] = shape[i] / length;
        }
    }
}
