//! The errors of a run's numerical settings, amplitude by amplitude, estimated from the run itself.
//!
//! Bins, radii, points and vertices are estimated without further equilibria along the loops. The motion of a measured loop is walked once more,
//! with the interface of the run and with one that has another number of them, each from its own static state. At a given motion the relative change of
//! the work of the contact forces is that of the square of the frequency, and the change of the logarithm of the loop's area that of damping, both
//! to first order. For the vertices every second one is walked. What that changes, times [`Dial::share`], is the estimate.

use super::amplitude::AmplitudeResult;
use super::dials::{AmplitudeError, Dial, DialError};
use super::error_bar::ErrorBar;
use super::prestress::PrestressResult;
use crate::Error;
use contact_laws::Sticking;
use cqsma_solver::BackbonePoint;
use joint_model::InterfacePart;
use joints::interface::{PartReport, SceneInterface};
use reduction::ReducedModel;
use scenes::{Friction, Scene};
use std::collections::BTreeMap;
use zte_assembly::{Interface, InterfaceMesh, State};

/// Bins and radii from which on half as many are compared with, and not twice as many.
const MANY: usize = 16;

/// The same for springs of a foundation.
const MANY_SPRINGS: usize = 66;

/// Edges of a loop that the walks go along, where it has a multiple of them: two for a branch. Differences of laws need no more: twice as many change
/// estimates above 2 % by a quarter at most.
const EDGES: usize = 4;

/// The interface with another number of a setting, or none where it could not be built.
#[derive(Debug)]
pub(super) struct Beside {
    pub(super) dial: Dial,
    pub(super) interface: Option<SceneInterface>,
}

impl Beside {
    /// In its static state, if it has one.
    pub(super) fn at_rest<'a>(&'a self, found: Option<&'a PrestressResult>) -> Option<AtRest<'a>> {
        let (built, found) = self.interface.as_ref().zip(found)?;
        Some(AtRest::new(&built.interface, found))
    }
}

/// The largest number of bins at a point; zero where asperities have no history of their own.
pub(super) fn bins(parts: &[PartReport]) -> usize {
    let resolved = parts.iter().filter_map(|part| part.law.resolved.as_ref());
    resolved.map(|report| report.bins).max().unwrap_or(0)
}

/// The interfaces of a scene with another number of each setting of the law that it has. `interface` is its own, with `bins` at a point at most; `told`
/// hears how much is done, and may stop it.
///
/// # Errors
/// Of `told`.
pub(super) fn beside(
    scene: &Scene,
    (mesh, parts): (&InterfaceMesh, &[InterfacePart]),
    (interface, bins): (&SceneInterface, usize),
    load: f64,
    settled: impl Fn(&Scene, SceneInterface) -> Option<SceneInterface>,
    told: &dyn Fn(f64) -> Result<(), Error>,
) -> Result<Vec<Beside>, Error> {
    let many = match scene.interfaces.law.friction() {
        Friction::Foundation => MANY_SPRINGS,
        _ => MANY,
    };
    let of = |dial: Dial| {
        if mesh.is_of_points() && dial == Dial::Points {
            return None;
        }
        let number = dial.number(scene, bins)?;
        let other = match (dial, number) {
            // One more than three would leave more than half of the error.
            (Dial::Points, 1..=4) => (number + 1) | 1,
            (Dial::Points, _) => number - 2,
            // More of many would cost more than the run.
            _ if number >= many => number / 2,
            _ => 2 * number,
        };
        let scene = dial.with(scene, other);
        let other = SceneInterface::knowing(Some(interface), &scene, mesh, parts, load).ok();
        let interface = match (dial, interface.pressures_at_rest()) {
            // Other points have other pressures.
            (Dial::Points, _) | (_, None) => other.and_then(|other| settled(&scene, other)),
            (_, Some(pressures)) => other.and_then(|other| other.about(pressures).ok()),
        };
        Some(Beside { dial, interface })
    };
    let mut found = Vec::new();
    // Other points take longest: their surface is another one too.
    for (dial, done) in [(Dial::Points, 0.65), (Dial::Bins, 0.95), (Dial::Radii, 1.0)] {
        found.extend(of(dial));
        told(done)?;
    }
    Ok(found)
}

/// An interface in its static state.
pub(super) struct AtRest<'a> {
    interface: &'a Interface,
    state: &'a State,
    /// The jump (m), followed by coordinates that are not looked at.
    displacement: &'a [f64],
    /// Contact forces (N).
    force: &'a [f64],
}

/// The interface of a run at rest, and those with another number of a setting, as far as they have a static state.
pub(super) struct Walks<'a> {
    pub(super) own: AtRest<'a>,
    pub(super) beside: Vec<(Dial, Option<AtRest<'a>>)>,
}

/// Work of the contact forces along a loop.
#[derive(Clone, Copy, Debug)]
struct Work {
    /// Mean over both reversals of the change of the force since rest times the motion (J).
    reversals: f64,
    /// Area of the loop (J).
    area: f64,
}

impl<'a> AtRest<'a> {
    pub(super) fn new(interface: &'a Interface, found: &'a PrestressResult) -> Self {
        Self {
            interface,
            state: &found.solution.state,
            displacement: &found.solution.displacement,
            force: &found.contact_force,
        }
    }

    /// Along the jumps of a closed loop from its positive reversal on (m), relative to the static state.
    fn walk<'p>(&self, path: impl ExactSizeIterator<Item = &'p [f64]> + Clone) -> Work {
        let from_rest = |motion: &[f64]| self.displacement.iter().zip(motion).map(|(rest, u)| rest + u).collect();
        let jumps: Vec<Vec<f64>> = path.clone().map(from_rest).collect();
        let forces = self.interface.along_path(&jumps, Sticking::Coulomb, self.state);
        let middle = path.len() / 2;
        let mut work = Work {
            reversals: 0.0,
            area: 0.0,
        };
        let mut before: Option<(Vec<f64>, &[f64])> = None;
        for (vertex, (motion, force)) in path.zip(&forces).enumerate() {
            let found: Vec<f64> = force.iter().zip(self.force).map(|(force, rest)| force - rest).collect();
            if vertex == 0 || vertex == middle {
                work.reversals += 0.5 * found.iter().zip(motion).map(|(f, u)| f * u).sum::<f64>();
            }
            if let Some((old, from)) = &before {
                let steps = found.iter().zip(old).zip(motion.iter().zip(*from));
                work.area += steps.map(|((f, g), (u, v))| 0.5 * (f + g) * (u - v)).sum::<f64>();
            }
            before = Some((found, motion));
        }
        work
    }
}

impl Walks<'_> {
    /// Errors of the settings of the law and of the vertices, from the jumps (m) along a measured loop; `point` is its result.
    pub(super) fn errors(&self, path: &[Vec<f64>], point: &BackbonePoint) -> Vec<(Dial, DialError)> {
        let Ok(result) = &point.result else { return Vec::new() };
        let rest = self.own.displacement;
        // Reversals are at the ends and in the middle of as many edges as there are.
        let edges = path.len().saturating_sub(1);
        let stride = if edges.is_multiple_of(EDGES) {
            (edges / EDGES).max(1)
        } else {
            1
        };
        let motions: Vec<Vec<f64>> = path
            .iter()
            .step_by(stride)
            .map(|jump| jump.iter().zip(rest).map(|(u, rest)| u - rest).collect())
            .collect();
        let along = |every: usize| motions.iter().step_by(every).map(Vec::as_slice);
        let own = self.own.walk(along(1));
        let load = point.modal_force * result.modal_amplitude;
        let compare = |dial: Dial, other: Work, [own_area, other_area]: [f64; 2]| {
            let damping = (result.is_resolved() && own_area > 0.0 && other_area > 0.0)
                .then(|| dial.share() * (other_area / own_area).ln().abs());
            let frequency = 0.5 * ((other.reversals - own.reversals) / load).abs();
            DialError {
                frequency_relative: Some(dial.share() * frequency),
                damping_ln: damping,
            }
        };
        let of_law = self.beside.iter().map(|(dial, beside)| {
            let error = beside.as_ref().map(|beside| {
                let other = beside.walk(along(1));
                compare(*dial, other, [own.area, other.area])
            });
            (*dial, error.unwrap_or_default())
        });
        let second = self.own.walk(along(2));
        let areas = [result.loop_area, result.coarse_loop_area.unwrap_or(f64::NAN)];
        of_law
            .chain(std::iter::once((
                Dial::Vertices,
                compare(Dial::Vertices, second, areas),
            )))
            .collect()
    }
}

/// Relative error of a linearised frequency by the modes that the reduction leaves out, from what the upper half of those kept does:
/// without a mode that takes part by `eta` in a mass-normalised shape, the eigenvalue `lambda` is higher by `eta^2 (omega^2 - lambda)`.
pub(super) fn of_modes(reduced: &ReducedModel, shape: &[f64], eigenvalue: f64) -> f64 {
    let (first, n) = (reduced.n_relative, reduced.n_modes());
    let upper = first + n / 2..first + n;
    let squares = reduced.stiffness.as_ref().diagonal();
    let added = upper.map(|i| shape[i] * shape[i] * (squares[i] - eigenvalue).max(0.0));
    0.5 * added.sum::<f64>() / eigenvalue
}

impl AmplitudeError {
    /// The error of one of the amplitudes of a mode, if it has a result, with that of the mesh, if there is one, and of the modes kept, which all
    /// of them share.
    ///
    /// Where bins and radii slip one after the other, errors change their sign along the amplitudes, and near such a place the estimate would be
    /// too small: of an amplitude and its neighbours the largest one is taken.
    pub(super) fn of(amplitudes: &[AmplitudeResult], at: usize, mesh: Option<&ErrorBar>, modes: f64) -> Option<Self> {
        let result = amplitudes[at].point.result.as_ref().ok()?;
        let neighbours = amplitudes.iter().take(at + 2).skip(at.saturating_sub(1));
        let mut own = BTreeMap::<Dial, DialError>::new();
        for (dial, error) in neighbours
            .filter_map(|one| one.fields.as_ref())
            .flat_map(|fields| &fields.errors)
        {
            own.entry(*dial).or_default().raise(error);
        }
        // Nothing is to be made of a neighbour that has what this one has not.
        for (dial, error) in &amplitudes[at].fields.as_ref()?.errors {
            let known = own.entry(*dial).or_default();
            known.frequency_relative = error.frequency_relative.and(known.frequency_relative);
            known.damping_ln = error.damping_ln.and(known.damping_ln);
        }
        let of_damping = |error: f64| result.is_resolved().then_some(error);
        // Errors of meshes are known where much slips. Where slip begins, elements resolve it no better than the points within them do.
        let of_points = own.get(&Dial::Points).and_then(|error| error.damping_ln);
        let unresolved = of_points.unwrap_or(0.0);
        let mesh = mesh.map(|mesh| {
            let error = DialError {
                frequency_relative: mesh.frequency_relative,
                damping_ln: mesh.damping_ln.map(|error| error.max(unresolved)).and_then(of_damping),
            };
            (Dial::Mesh, error)
        });
        let shared = [
            (
                Dial::Modes,
                DialError {
                    frequency_relative: Some(modes),
                    damping_ln: of_damping(modes),
                },
            ),
            (
                Dial::Equilibrium,
                DialError {
                    frequency_relative: Some(0.5 * result.residual),
                    damping_ln: of_damping(result.zeta_floor / result.zeta.abs()),
                },
            ),
        ];
        let of: BTreeMap<Dial, DialError> = own.into_iter().chain(mesh).chain(shared).collect();
        let sum = |part: fn(&DialError) -> Option<f64>| of.values().map(part).sum::<Option<f64>>();
        Some(Self {
            frequency_relative: sum(|error| error.frequency_relative),
            damping_ln: sum(|error| error.damping_ln),
            of,
        })
    }
}
