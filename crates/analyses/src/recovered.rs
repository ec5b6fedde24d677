//! The error of a mesh, estimated from the run itself.
//!
//! A finite mesh is too stiff: it lacks the flexibility of strains that it cannot follow. The energy of these strains is estimated by patch
//! recovery ([`StrainErrors`]), as a small matrix over a few motions: the modes followed, and the motions at the peaks of two loops of each.
//! Given back as flexibility along these motions, it makes a second structure. What differs in its modes and in these loops estimates what
//! the limit of the mesh would change.

use super::deformed::unlocked;
use super::ensemble::loops_alone;
use super::error_bar::{ErrorBar, Place};
use super::mode_backbone::ModeAnalysis;
use super::outcome::Analysis;
use super::prepared::Prepared;
use super::prestress::linearise;
use super::solver::Solver;
use crate::Error;
use dense_algebra::{Limits, SystemMatrix, product, symmetric_eigen};
use faer::{Mat, MatRef};
use finite_elements::mesh::Mesh;
use finite_elements::recovery::StrainErrors;
use joint_model::Bodies;
use joints::interface::InterfaceForce;
use joints::progress::{Progress, Within};
use joints::structure::Structure;

/// Damping ratio from which on loops are chosen for the error of damping: below it no mesh resolves where slip begins.
const RESOLVED_DAMPING: f64 = 5e-3;

/// Damping ratio below which a loop has none whose error anyone asks for; those of joints that open far are the longest to compute.
const NEGLIGIBLE_DAMPING: f64 = 1e-6;

/// Motions that differ from the others by less than this share of their energy are none of their own.
const SAME_MOTION: f64 = 1e-8;

/// Places where the mesh errs most that are named.
const PLACES: usize = 5;

/// What is done of the work when the displacements are found, and when the strains are recovered.
const FACTORED: f64 = 0.55;
const RECOVERED: f64 = 0.6;

/// Where the figures come from.
const SOURCE: &str = "estimated for this run from recovered strains (Zienkiewicz and Zhu) of the modes followed and of two loops of each";

impl Prepared {
    /// The error bar of the mesh, estimated; none where the bodies have no mesh or a table has the error of the mesh.
    ///
    /// # Errors
    /// An interruption. Whatever else prevents an estimate is said in its place.
    pub(super) fn estimated_error(&self, analysis: &Analysis, within: &Within<'_>) -> Result<Option<ErrorBar>, Error> {
        let Some(structure) = self.structure.as_ref().filter(|_| ErrorBar::is_estimated(&self.scene)) else {
            return Ok(None);
        };
        let Bodies::Meshed(bodies) = &structure.joint.bodies else {
            return Ok(None);
        };
        within.note("the structure is factored again, to estimate the error of its mesh");
        match self.estimate(structure, &bodies.assembly.mesh, analysis, within) {
            Ok(bar) => Ok(Some(bar)),
            Err(error) if error.is_interruption() => Err(error),
            Err(error) => Ok(Some(ErrorBar::unknown(&format!("the estimate failed: {error}")))),
        }
    }

    fn estimate(
        &self,
        structure: &Structure,
        mesh: &Mesh,
        analysis: &Analysis,
        within: &Within<'_>,
    ) -> Result<ErrorBar, Error> {
        let chosen_of = |open_too: bool| -> Vec<Vec<usize>> {
            let modes = analysis.modes.iter();
            modes.map(|mode| chosen(mode, open_too)).collect()
        };
        // The change of a loop from cycle to cycle is not that with the mesh, and such loops are the longest to compute. None of a fixed number of
        // cycles counts as closed.
        let mut chosen = chosen_of(self.scene.analyses.backbone.cycles.is_some());
        if chosen.iter().all(Vec::is_empty) {
            chosen = chosen_of(true);
        }
        let forces: Vec<Vec<f64>> = (analysis.modes.iter().zip(&chosen))
            .map(|(mode, numbers)| {
                let force = |number: &usize| mode.amplitudes[*number].point.modal_force;
                numbers.iter().map(force).collect()
            })
            .collect();
        let mut scene = loops_alone(&self.scene, true);
        scene.analyses.backbone.amplitudes = forces.iter().map(Vec::len).max().unwrap_or(0);
        let uncached = joints::store::Options {
            cache: None,
            ..self.options.clone()
        };
        let motions = self.motions(analysis, &chosen)?;
        let (stop, hear) = (|| within.interrupted(), |done| within.done(done));
        let limits = Limits::default().until(&stop).heard_by(&hear);
        let displacements =
            structure.displacements(&self.model, motions.as_ref(), &self.options, limits.part(0.0, FACTORED))?;
        let errors = StrainErrors::try_new(mesh, &displacements).map_err(joints::Error::from)?;
        limits.done(RECOVERED);
        let n = errors.n_motions;
        let lacking = Mat::from_fn(n, n, |i, j| errors.products[n * i + j]);
        let mut softer = self.model.clone();
        softer.reduced.stiffness = softened(&self.model.reduced.stiffness, motions.as_ref(), lacking.as_ref())?;
        if let (SystemMatrix::Blocks(stiffness), SystemMatrix::Blocks(mass)) =
            (&softer.reduced.stiffness, &self.model.reduced.mass)
        {
            softer.reduced.mass = SystemMatrix::Blocks(mass.over_tree(stiffness.tree()));
        }
        let solver = Solver {
            model: &softer,
            neighbours: &[],
            options: &uncached,
            loop_elements: &[],
            connections: &[],
            ..self.solver()
        };
        let (interface, closure) = (&self.interface.interface, self.interface.closure);
        let other = solver.analyse(&scene, interface, closure, Some(&forces), &within.part(RECOVERED, 1.0))?;
        let (mut frequency, mut damping) = (0.0_f64, None::<f64>);
        for ((own_mode, numbers), other_mode) in analysis.modes.iter().zip(&chosen).zip(&other.modes) {
            let at = own_mode.mode - 1;
            frequency = frequency.max((other.frequencies[at] / analysis.frequencies[at] - 1.0).abs());
            for (number, b) in numbers.iter().zip(&other_mode.amplitudes) {
                let (Ok(a), Ok(b)) = (&own_mode.amplitudes[*number].point.result, &b.point.result) else {
                    continue;
                };
                frequency = frequency.max((b.omega / a.omega - 1.0).abs());
                if a.is_resolved() && b.is_resolved() {
                    let difference = (b.zeta / a.zeta).ln().abs();
                    damping = Some(damping.map_or(difference, |worst| worst.max(difference)));
                }
            }
        }
        let shares = shares(&errors);
        Ok(ErrorBar {
            frequency_relative: Some(frequency),
            damping_ln: damping,
            source: SOURCE.to_owned(),
            worst: worst(mesh, &shares),
            shares,
        })
    }

    /// Modes and motions at the peaks of the `chosen` loops of each as columns, over the coordinates of the structure whose bolts are not locked.
    fn motions(&self, analysis: &Analysis, chosen: &[Vec<usize>]) -> Result<Mat<f64>, Error> {
        let scene = &self.scene;
        let locked = self.solver().locked(scene)?;
        let vibrating = locked.as_ref().unwrap_or(&self.model.reduced);
        let force = InterfaceForce::new(&self.interface.interface);
        let line = linearise(scene, vibrating, &force, &analysis.prestress.solution)?;
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (mode, numbers) in analysis.modes.iter().zip(chosen) {
            columns.push(line.shapes.col(mode.mode - 1).iter().copied().collect());
            let peaks = numbers.iter().filter_map(|number| {
                let peak = mode.amplitudes[*number].fields.as_ref()?.displacement.as_ref()?;
                Some(peak.iter().zip(line.displacement()).map(|(u, rest)| u - rest).collect())
            });
            columns.extend(peaks);
        }
        let over_vibrating = Mat::from_fn(vibrating.size(), columns.len(), |i, j| columns[j][i]);
        unlocked(&self.model, scene.bolts.behaviour, over_vibrating)
    }
}

/// Two amplitudes of a mode whose loops closed, or are `open_too`: the smallest and the largest whose damping a mesh resolves, or the last ones that have any
/// to speak of.
fn chosen(mode: &ModeAnalysis, open_too: bool) -> Vec<usize> {
    let resolved = |least: f64| -> Vec<usize> {
        let is_resolved = |number: &usize| {
            let result = mode.amplitudes[*number].point.result.as_ref();
            result.is_ok_and(|found| (open_too || found.closed) && found.is_resolved() && found.zeta >= least)
        };
        (0..mode.amplitudes.len()).filter(is_resolved).collect()
    };
    let mut numbers = resolved(RESOLVED_DAMPING);
    match numbers.len() {
        0 | 1 => {
            numbers = resolved(NEGLIGIBLE_DAMPING);
            numbers.drain(..numbers.len().saturating_sub(2));
        }
        many => drop(numbers.drain(1..many - 1)),
    }
    numbers
}

/// A stiffness with more flexibility along some motions (columns): `lacking` has what the energy norm of these motions (twice the energy) lacks.
///
/// With motions `v` that are orthonormal in the stiffness `k` and the matrix `p` of what they lack, `k^-1 + v p v^T` is the new
/// flexibility, whose inverse is `k - k v (1 + p)^-1 p v^T k`: it stays positive whatever `p` is.
fn softened(
    stiffness: &SystemMatrix,
    motions: MatRef<'_, f64>,
    lacking: MatRef<'_, f64>,
) -> Result<SystemMatrix, Error> {
    let forces = stiffness.as_ref().product(motions);
    let n = motions.ncols();
    let energies = product(motions.transpose(), forces.as_ref());
    let size = |i: usize| energies[(i, i)].max(f64::MIN_POSITIVE).sqrt();
    let scaled = Mat::from_fn(n, n, |i, j| energies[(i, j)] / (size(i) * size(j)));
    let dense = |error| Error::from(cqsma_solver::Error::from(error));
    let (values, vectors) = symmetric_eigen(scaled.as_ref()).map_err(dense)?;
    let kept: Vec<usize> = (0..n).filter(|i| values[*i] > SAME_MOTION).collect();
    let basis = Mat::from_fn(n, kept.len(), |i, j| {
        vectors[(i, kept[j])] / (size(i) * values[kept[j]].sqrt())
    });
    let own = product(lacking, basis.as_ref());
    let own = product(basis.transpose(), own.as_ref());
    let (shares, turned) = symmetric_eigen(own.as_ref()).map_err(dense)?;
    let basis = product(basis.as_ref(), turned.as_ref());
    let forces = product(forces.as_ref(), basis.as_ref());
    let taken: Vec<(f64, &[f64])> = (0..forces.ncols())
        .map(|j| {
            let share = shares[j].max(0.0);
            (-share / (1.0 + share), forces.col_as_slice(j))
        })
        .collect();
    Ok(stiffness.clone().plus_outer(&taken))
}

/// What the elements have of the error of the first motion.
fn shares(errors: &StrainErrors) -> Vec<f64> {
    let of_elements = errors.of_elements.chunks(errors.n_motions);
    let own = || of_elements.clone().map(|of_motions| of_motions[0]);
    let sum = own().sum::<f64>().max(f64::MIN_POSITIVE);
    own().map(|error| error / sum).collect()
}

/// Where shares are largest.
fn worst(mesh: &Mesh, shares: &[f64]) -> Vec<Place> {
    let mut all: Vec<(f64, usize)> = shares.iter().copied().zip(0..).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let place = |&(share, element): &(f64, usize)| {
        let nodes = mesh.elements[element].cell.nodes();
        let mean = |c: usize| nodes.iter().map(|node| mesh.nodes[*node as usize][c]).sum::<f64>() / nodes.len() as f64;
        Place {
            element: element + 1,
            at: [0, 1, 2].map(mean),
            share,
        }
    };
    all.iter()
        .take(PLACES)
        .filter(|(share, _)| *share > 0.0)
        .map(place)
        .collect()
}
