//! The bodies as loads deform them.

use super::amplitude::AmplitudeResult;
use super::outcome::Analysis;
use crate::Error;
use dense_algebra::{Limits, product};
use faer::Mat;
use finite_elements::mesh::Mesh;
use joint_model::Bodies;
use joints::store::Options;
use joints::structure::{StructuralModel, Structure};
use scenes::{BoltBehaviour, Scene};

/// Displacements of the bodies under the bolt loads, and at the positive peaks of loops.
#[derive(Clone, Debug)]
pub struct Deformed {
    /// The mesh, undeformed.
    pub mesh: Mesh,
    /// Displacement of each node in the static state (m).
    pub prestress: Vec<[f64; 3]>,
    /// The same at the positive peak, bolt loads included, by mode followed and by amplitude; of the amplitudes whose fields are stored.
    pub peaks: Vec<Vec<Option<Vec<[f64; 3]>>>>,
}

impl Deformed {
    pub(super) fn new(
        structure: &Structure,
        model: &StructuralModel,
        scene: &Scene,
        analysis: &Analysis,
        options: &Options,
        limits: Limits<'_>,
    ) -> Result<Self, Error> {
        let stored = scene.fields_at();
        let Bodies::Meshed(bodies) = &structure.joint.bodies else {
            return Err(joints::Error::NoMesh.into());
        };
        let at_rest = &analysis.prestress.solution.displacement;
        let amplitudes = analysis
            .modes
            .iter()
            .flat_map(|mode| mode.amplitudes.iter().enumerate());
        let peaks: Vec<&[f64]> = amplitudes.filter_map(|one| peak(&stored, one)).collect();
        let motions = motions(model, scene.bolts.behaviour, at_rest, &peaks)?;
        let mut found = structure
            .displacements(model, motions.as_ref(), options, limits)?
            .into_iter();
        let prestress = found.next().unwrap_or_default();
        let mut of_amplitude = |one| peak(&stored, one).and_then(|_| found.next());
        let peaks = analysis.modes.iter().map(|mode| {
            let amplitudes = mode.amplitudes.iter().enumerate();
            amplitudes.map(&mut of_amplitude).collect()
        });
        Ok(Self {
            peaks: peaks.collect(),
            mesh: bodies.assembly.mesh.clone(),
            prestress,
        })
    }
}

/// The positive peak of an amplitude, with its place, that is among those `stored`.
fn peak<'a>(stored: &[usize], (index, amplitude): (usize, &'a AmplitudeResult)) -> Option<&'a [f64]> {
    let fields = amplitude.fields.as_ref().filter(|_| stored.contains(&(index + 1)))?;
    fields.displacement.as_deref()
}

/// The static state and the peaks as columns over the coordinates of the reduced structure.
///
/// Bolts that are locked in vibration take coordinates away. Those beside the jump count from the static state then.
fn motions(
    model: &StructuralModel,
    behaviour: BoltBehaviour,
    at_rest: &[f64],
    peaks: &[&[f64]],
) -> Result<Mat<f64>, Error> {
    let n = at_rest.len();
    let mut motions = Mat::from_fn(n, 1 + peaks.len(), |i, _| at_rest[i]);
    if peaks.is_empty() {
        return Ok(motions);
    }
    let vibrating = peaks[0].len();
    let nd = model.reduced.n_relative;
    let start = |i: usize| match behaviour {
        BoltBehaviour::Locked if i >= nd => 0.0,
        _ => at_rest[i],
    };
    let since = Mat::from_fn(vibrating, peaks.len(), |i, j| peaks[j][i] - start(i));
    let mut of_peaks = motions.subcols_mut(1, peaks.len());
    of_peaks += unlocked(model, behaviour, since)?;
    Ok(motions)
}

/// Motions of the structure that vibrates, over the coordinates of the one whose bolts are not locked.
pub(super) fn unlocked(
    model: &StructuralModel,
    behaviour: BoltBehaviour,
    vibrating: Mat<f64>,
) -> Result<Mat<f64>, Error> {
    Ok(match behaviour {
        BoltBehaviour::DeadLoad => vibrating,
        BoltBehaviour::Locked => {
            let (nd, (_, motions)) = (model.reduced.n_relative, model.reduced.locked_with_motions()?);
            let mut whole = Mat::zeros(model.reduced.size(), vibrating.ncols());
            whole.subrows_mut(0, nd).copy_from(vibrating.subrows(0, nd));
            let rest = product(motions.as_ref(), vibrating.as_ref());
            whole.subrows_mut(nd, rest.nrows()).copy_from(&rest);
            whole
        }
    })
}
