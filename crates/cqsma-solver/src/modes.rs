//! Modes of the structure linearised about a prestressed state with everything stuck (eq. 39).

use crate::Error;
use crate::error::check_size;
use crate::force::{HystereticForce, Sliding};
use crate::linear::{StuckFactor, multiply};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Side};

/// The prestressed structure, ready for its loops.
#[derive(Clone, Debug)]
pub struct Linearisation<'a, S> {
    pub(crate) stiffness: MatRef<'a, f64>,
    pub(crate) mass: MatRef<'a, f64>,
    pub(crate) factor: StuckFactor,
    pub(crate) displacement: Vec<f64>,
    pub(crate) state: S,
    pub(crate) contact_force: Vec<f64>,
    /// `omega^2` of the modes, ascending (rad^2/s^2).
    pub eigenvalues: Vec<f64>,
    /// Mass-normalised mode shapes, `n x n_modes`.
    pub shapes: Mat<f64>,
}

impl<S> Linearisation<'_, S> {
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

/// Linearises about `displacement` with the committed history `state`, and finds the `n_modes` lowest modes.
///
/// The stuck tangent is symmetrised: laws whose history rule makes it unsymmetric lose that part here, and only here.
///
/// # Errors
/// Sizes that do not match; [`Error::NotPositiveDefinite`] if the stuck structure can still move freely.
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
    let factor = StuckFactor::try_new(stiffness, force.pattern(), &tangent)?;
    let (eigenvalues, shapes) = lowest_modes(&factor, mass, n_modes.min(n))?;
    Ok(Linearisation {
        stiffness,
        mass,
        factor,
        displacement,
        state,
        contact_force,
        eigenvalues,
        shapes,
    })
}

/// Subspace iteration on `C = L^-1 M L^-T`, whose eigenvalues are `1 / omega^2`.
fn lowest_modes(factor: &StuckFactor, mass: MatRef<'_, f64>, n_modes: usize) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let n = mass.nrows();
    let fail = |e: &dyn std::fmt::Debug| Error::Modes {
        reason: format!("{e:?}"),
    };
    let lower = factor.lower();
    let mut half = mass.to_owned();
    lower.solve_lower_triangular_in_place(half.as_mut());
    let mut c = half.transpose().to_owned();
    lower.solve_lower_triangular_in_place(c.as_mut());
    let width = (2 * n_modes + 10).min(n);
    // Reproducible start: a 64-bit linear congruential generator.
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut basis = Mat::from_fn(n, width, |_, _| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    });
    let mut previous = vec![0.0; n_modes];
    for _ in 0..200 {
        let q = basis.qr().compute_thin_Q();
        let mut image = Mat::zeros(n, width);
        matmul(image.as_mut(), Accum::Replace, c.as_ref(), q.as_ref(), 1.0, Par::Seq);
        let mut small = Mat::<f64>::zeros(width, width);
        matmul(
            small.as_mut(),
            Accum::Replace,
            q.transpose(),
            image.as_ref(),
            1.0,
            Par::Seq,
        );
        // Brought to unit size: the library's tolerances are absolute.
        let scale = small.norm_max();
        let small = Mat::from_fn(width, width, |i, j| 0.5 / scale * (small[(i, j)] + small[(j, i)]));
        let evd = small.self_adjoint_eigen(Side::Lower).map_err(|e| fail(&e))?;
        let values: Vec<f64> = (0..n_modes).map(|i| scale * evd.S()[width - 1 - i]).collect();
        let change = values
            .iter()
            .zip(&previous)
            .map(|(a, b)| (a / b - 1.0).abs())
            .fold(0.0, f64::max);
        previous.clone_from(&values);
        // Eigenvalues converge with the square of the shapes: ask for round-off in the values.
        if change < 1e-14 {
            let rotation = Mat::from_fn(width, n_modes, |i, j| evd.U()[(i, width - 1 - j)]);
            let mut shapes = Mat::zeros(n, n_modes);
            matmul(
                shapes.as_mut(),
                Accum::Replace,
                image.as_ref(),
                rotation.as_ref(),
                1.0,
                Par::Seq,
            );
            lower.transpose().solve_upper_triangular_in_place(shapes.as_mut());
            normalise(mass, shapes.as_mut());
            return Ok((values.iter().map(|v| 1.0 / v).collect(), shapes));
        }
        basis = image;
    }
    Err(Error::Modes {
        reason: "subspace iteration did not settle in 200 steps".into(),
    })
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
