//! Modes of the structure linearised about a prestressed state with everything stuck (eq. 39).

use crate::Error;
use crate::error::check_size;
use crate::force::{HystereticForce, PatternView};
use crate::linear::{RoundOff, Stuck, UnitLoad, solve_krylov, symmetrised};
use crate::newton::Equilibrium;
use contact_laws::Sticking;
use dense_algebra::{Inner, Limits, SystemMatrixRef, dot};
use faer::Mat;
use std::ops::Range;

/// The prestressed structure, ready for its loops.
#[derive(Clone, Debug)]
pub struct Linearisation<'a, S> {
    pub(crate) stiffness: SystemMatrixRef<'a>,
    pub(crate) mass: SystemMatrixRef<'a>,
    pub(crate) stuck: Stuck,
    /// Tangent of the stuck contact (symmetrised).
    pub(crate) tangent: Vec<f64>,
    pub(crate) displacement: Vec<f64>,
    pub(crate) state: S,
    pub(crate) contact_force: Vec<f64>,
    /// Round-off in the contact forces.
    pub(crate) round_off: RoundOff,
    /// `omega^2` of the modes, ascending (rad^2/s^2).
    pub eigenvalues: Vec<f64>,
    /// Mass-normalised mode shapes, `n x n_modes`.
    pub shapes: Mat<f64>,
    /// Rows `d` of viscous dampers, each of which resists with `d (d^T v')` (sqrt(kg/s)); none by default. They act in motions in time and in forced ones,
    /// and in no mode of this structure.
    pub dampers: Vec<Vec<f64>>,
    /// Asked often by the analyses about this state; by default it never ends them.
    pub limits: Limits<'a>,
}

impl<'a, S> Linearisation<'a, S> {
    /// Displacements of the static state.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// History of the static state.
    pub fn state(&self) -> &S {
        &self.state
    }

    /// Contact forces of the static state (N).
    pub fn contact_force(&self) -> &[f64] {
        &self.contact_force
    }

    /// Stiffness without contact.
    pub fn stiffness(&self) -> SystemMatrixRef<'a> {
        self.stiffness
    }

    /// Mass.
    pub fn mass(&self) -> SystemMatrixRef<'a> {
        self.mass
    }

    /// Energy norm, in the stiffness with everything in contact stuck, of the round-off that evaluating the contact forces leaves
    /// (sqrt(J)): a residual below it says nothing.
    pub fn round_off(&self) -> f64 {
        self.round_off.energy
    }

    /// Symmetrised tangent of the stuck contact over the pattern of the force (N/m).
    pub fn stuck_tangent(&self) -> &[f64] {
        &self.tangent
    }

    /// Tangent values in the place of [`stuck_tangent`](Self::stuck_tangent) for which [`preconditioner_solve_into`](Self::preconditioner_solve_into) is
    /// exact: the same, or their mean with those of the reflected contact, where that is near (N/m).
    pub fn preconditioner_tangent(&self) -> &[f64] {
        self.stuck.tangent()
    }

    /// Memory that a [solve](Self::preconditioner_solve_into) reads (bytes).
    pub fn preconditioner_bytes(&self) -> usize {
        self.stuck.bytes()
    }

    /// `v`, the displacements under the force `p` of the structure with the contact of [`preconditioner_tangent`](Self::preconditioner_tangent); both
    /// have as many numbers as there are coordinates.
    ///
    /// # Panics
    /// On other lengths.
    pub fn preconditioner_solve_into(&self, p: &[f64], v: &mut [f64]) {
        self.stuck.solve_into(p, v);
    }

    /// Displacements of the structure with the contact tangent `tangent` over `pattern` (N/m) under the force `force` (N), found by GMRES up to
    /// `tolerance` (relative, energy norm of the stuck structure), with that norm of the force; none if it is not reached.
    ///
    /// # Errors
    /// [`Error::Size`].
    pub fn tangent_response(
        &self,
        pattern: PatternView<'_>,
        tangent: &[f64],
        force: &[f64],
        tolerance: f64,
    ) -> Result<Option<(Vec<f64>, f64)>, Error> {
        check_size("the force", force.len(), self.shapes.nrows())?;
        let start = self.stuck.response(force);
        let norm = start.norm();
        if norm == 0.0 {
            return Ok(Some((start.v, norm)));
        }
        let found = solve_krylov(&self.stuck, pattern, tangent, None, &start, norm, tolerance);
        Ok(found.map(|(motion, _)| (motion.v, norm)))
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
            limits: self.limits,
        }
    }

    /// Frequencies of the modes (Hz).
    pub fn frequencies(&self) -> Vec<f64> {
        self.eigenvalues
            .iter()
            .map(|w2| w2.max(0.0).sqrt() / (2.0 * std::f64::consts::PI))
            .collect()
    }

    /// What the dampers take of a mode, zero-based, `sum (d^T phi)^2` (1/s).
    pub fn damper_coefficient(&self, mode: usize) -> f64 {
        let shape = self.shapes.col_as_slice(mode);
        self.dampers.iter().map(|damper| dot(damper, shape).powi(2)).sum()
    }

    /// Derivatives of the logarithm of the frequency of a mode, zero-based, with respect to those of the stiffness of parts of the contact, each over a range
    /// of coordinates of its own (-): half of what each has of the energy of the mode, `phi^T T phi / (2 omega^2)`. `pattern` is that of the force.
    pub fn by_stiffness(
        &self,
        pattern: PatternView<'_>,
        mode: usize,
        parts: impl IntoIterator<Item = Range<usize>>,
    ) -> Vec<f64> {
        let shape = self.shapes.col_as_slice(mode);
        let mut force = vec![0.0; shape.len()];
        pattern.add_product(&self.tangent, shape, &mut force);
        let parts = parts.into_iter();
        parts
            .map(|part| 0.5 * dot(&force[part.clone()], &shape[part]) / self.eigenvalues[mode])
            .collect()
    }

    /// Damping ratio of a mode, zero-based, by the dampers alone: their coefficient over `2 omega`; zero of a mode without stiffness.
    pub fn damper_ratio(&self, mode: usize) -> f64 {
        let eigenvalue = self.eigenvalues[mode];
        match eigenvalue > 0.0 {
            true => self.damper_coefficient(mode) / (2.0 * eigenvalue.sqrt()),
            false => 0.0,
        }
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
    /// That of unit modal force, `M phi`, with the response `phi / omega^2`.
    pub(crate) unit: UnitLoad,
}

impl Mode {
    /// Mode number `mode`, zero-based, with the contact over `pattern`.
    pub(crate) fn try_new<S>(
        structure: &Linearisation<'_, S>,
        pattern: PatternView<'_>,
        mode: usize,
    ) -> Result<Self, Error> {
        let Some(&eigenvalue) = structure.eigenvalues.get(mode) else {
            return Err(Error::Setting {
                field: "mode",
                value: mode as f64,
                requirement: "less than the number of linearised modes (counted from 0)",
            });
        };
        let shape: Vec<f64> = structure.shapes.col(mode).iter().copied().collect();
        let mut force = vec![0.0; shape.len()];
        structure.mass.multiply(&shape, &mut force);
        // The contact may differ from the one of the preconditioner: P v = M phi + dT phi / omega^2.
        let mut held = vec![0.0; shape.len()];
        let tangents = structure.stuck.tangent().iter().zip(&structure.tangent);
        let difference: Vec<f64> = tangents.map(|(a, b)| (a - b) / eigenvalue).collect();
        pattern.add_product(&difference, &shape, &mut held);
        held.iter_mut().zip(&force).for_each(|(h, f)| *h += f);
        Ok(Self {
            shape,
            eigenvalue,
            unit: UnitLoad {
                force,
                response: structure.stuck.response(&held),
            },
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
    stiffness: impl Into<SystemMatrixRef<'a>>,
    mass: impl Into<SystemMatrixRef<'a>>,
    force: &F,
    displacement: Vec<f64>,
    state: F::State,
    n_modes: usize,
) -> Result<Linearisation<'a, F::State>, Error> {
    let (stiffness, mass) = (stiffness.into(), mass.into());
    let n = stiffness.size();
    check_size("the mass matrix", mass.size(), n)?;
    check_size("the prestress displacement", displacement.len(), n)?;
    let nc = force.n_dofs();
    let mut tangent = vec![0.0; force.pattern().indices.len()];
    let mut contact_force = vec![0.0; nc];
    let mut end = state.clone();
    let mut workspace = force.workspace();
    let u = &displacement[..nc];
    force.evaluate(
        u,
        Sticking::Full,
        &state,
        &mut end,
        &mut workspace,
        &mut contact_force,
        Some(&mut tangent),
    );
    // The reference force must be the one that the loops will compute, with friction.
    force.evaluate(
        u,
        Sticking::Coulomb,
        &state,
        &mut end,
        &mut workspace,
        &mut contact_force,
        None,
    );
    let tangent = symmetrised(force.pattern(), &tangent);
    let near = Stuck::near_image(stiffness, force.pattern(), &tangent, force.reflections())?;
    let factor = stiffness.to_owned().factor_plus(force.pattern().entries(&tangent))?;
    let (eigenvalues, shapes) = factor.lowest_pairs(mass, n_modes.min(n)).map_err(|error| match error {
        dense_algebra::Error::Rank { .. } => Error::Setting {
            field: "n_modes",
            value: n_modes as f64,
            requirement: "no more than the rank of a finite, positive semi-definite mass matrix",
        },
        other => other.into(),
    })?;
    let stuck = near.unwrap_or_else(|| Stuck::of_factor(factor, &tangent));
    let u = &displacement[..nc];
    Ok(Linearisation {
        stiffness,
        mass,
        round_off: stuck.round_off(force.pattern(), u, &contact_force),
        stuck,
        tangent,
        displacement,
        state,
        contact_force,
        eigenvalues,
        shapes,
        dampers: Vec::new(),
        limits: Limits::default(),
    })
}
