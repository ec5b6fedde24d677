//! Whether results depend on a number of a scene at all.

use crate::Error;
use contact_laws::Sticking;
use joints::interface::SceneInterface;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::{Parameter, Scene};
use zte_assembly::Interface;

/// Relative change of a number that is tried.
const STEP: f64 = 1e-3;

/// Changes of a number that is zero, in its SI unit: of slopes, and of lengths and pure numbers that take no small ones.
const STEPS_FROM_ZERO: [f64; 2] = [1e-6, 1e-3];

/// Difference of forces relative to the largest that is round-off; [`STEP`] of a number that acts leaves far more.
const ROUND_OFF: f64 = 1e-10;

/// How far the faces are closed, and slide on one another (m): from where asperities only just touch to beyond every strength.
const MOTIONS: [f64; 5] = [1e-8, 1e-6, 1e-4, 1e-2, 1.0];

/// What the results of a scene follow from: its structure, its contact, and the loads of its bolts.
pub(crate) struct Effects<'a> {
    scene: &'a Scene,
    structure: &'a Structure,
    interface: SceneInterface,
    /// Gap from which motions are counted (m).
    gap: f64,
    /// Forces (N), motion by motion.
    contact: Vec<Vec<f64>>,
}

impl<'a> Effects<'a> {
    /// Of a scene and its structure. Asperities are those of `known`, an interface of the same scene.
    ///
    /// # Errors
    /// As [`SceneInterface::try_new`].
    pub(crate) fn try_new(
        scene: &'a Scene,
        structure: &'a Structure,
        known: Option<&SceneInterface>,
    ) -> Result<Self, Error> {
        let interface = contact_of(scene, structure, known)?;
        let gaps = interface.interface.gap().unwrap_or(&[0.0]).iter().copied();
        let gap = gaps.fold(f64::INFINITY, f64::min);
        Ok(Self {
            scene,
            structure,
            contact: forces(&interface.interface, gap),
            interface,
            gap,
        })
    }

    /// Whether another scene can have other results.
    ///
    /// # Errors
    /// Of the structure and the interface of the other one.
    pub(crate) fn differs(&self, other: &Scene) -> Result<bool, Error> {
        let loads = |scene: &Scene| -> Vec<f64> { (0..self.structure.n_bolts()).map(|n| scene.tension(n)).collect() };
        if loads(other) != loads(self.scene) || other.analyses.tightening != self.scene.analyses.tightening {
            return Ok(true);
        }
        let own;
        let structure = match other.structure == self.scene.structure && other.model == self.scene.model {
            true => self.structure,
            false => {
                own = Structure::try_new(other, &Silent)?;
                let hash = |structure: &Structure| structure.hash(None).finish();
                if hash(&own) != hash(self.structure) {
                    return Ok(true);
                }
                &own
            }
        };
        // Asperities that are known belong to the mesh of the interface.
        let is_same = structure.interface() == self.structure.interface();
        let interface = contact_of(other, structure, is_same.then_some(&self.interface))?;
        let found = forces(&interface.interface, self.gap);
        Ok(found.len() != self.contact.len() || found.iter().zip(&self.contact).any(|(a, b)| are_others(a, b)))
    }

    /// Refuses a parameter that the results do not depend on. One that has no admissible values beside its own is left to those who vary it.
    ///
    /// # Errors
    /// [`scenes::Error::Parameter`].
    pub(crate) fn require(&self, parameter: &Parameter) -> Result<(), Error> {
        let value = parameter.value(self.scene)?;
        let beside: Vec<f64> = match value == 0.0 {
            true => STEPS_FROM_ZERO.to_vec(),
            false => vec![value * (1.0 + STEP), value * (1.0 - STEP)],
        };
        let mut bare = self.scene.clone();
        bare.analyses.sensitivities.clear();
        bare.uncertain = None;
        for other in beside {
            let varied = parameter.with(&bare, other).map_err(Error::from);
            match varied.and_then(|varied| self.differs(&varied)) {
                // What is wrong with a value beside it is found by those who run it.
                Ok(true) | Err(_) => return Ok(()),
                Ok(false) => {}
            }
        }
        Err(scenes::Error::Parameter {
            path: parameter.path().into(),
            reason: "no result depends on it: structure, contact and bolt loads of this scene are the same with another value; leave it out, \
                     or name the number that is used in its place"
                .into(),
        }.into())
    }
}

/// The interface of a scene, whose law may depend on the load of the bolts.
fn contact_of(scene: &Scene, structure: &Structure, known: Option<&SceneInterface>) -> Result<SceneInterface, Error> {
    let load = (0..structure.n_bolts()).map(|bolt| scene.tension(bolt)).sum();
    let (mesh, parts) = (structure.interface(), &structure.joint.parts);
    Ok(SceneInterface::knowing(known, scene, mesh, parts, load)?)
}

/// Whether forces differ from others by more than round-off.
fn are_others(forces: &[f64], than: &[f64]) -> bool {
    let largest = forces.iter().chain(than).fold(0.0_f64, |m, force| m.max(force.abs()));
    let is_same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a - b).abs() <= ROUND_OFF * largest;
    forces.len() != than.len() || !forces.iter().zip(than).all(is_same)
}

/// Forces of an interface that closes, slides, slides back and opens half, farther and farther.
fn forces(interface: &Interface, gap: f64) -> Vec<Vec<f64>> {
    let mut path = Vec::new();
    let held = interface.operators().held();
    let is_held = |coordinate: usize| held.binary_search(&coordinate).is_ok();
    for motion in MOTIONS {
        for (slide, close) in [(0.0, 1.0), (0.1, 1.0), (10.0, 1.0), (-1.0, 1.0), (0.0, 0.5)] {
            let to = [slide * motion, 0.5 * slide * motion, gap + close * motion];
            let jump = (0..interface.n_dofs()).map(|i| if is_held(i) { 0.0 } else { to[i % 3] });
            path.push(jump.collect());
        }
    }
    let forces = interface.along_path(&path, Sticking::Coulomb, &interface.initial_state());
    let free = |force: Vec<f64>| {
        let free = force.into_iter().enumerate().filter(|(i, _)| !is_held(*i));
        free.map(|(_, force)| force).collect()
    };
    forces.into_iter().map(free).collect()
}
