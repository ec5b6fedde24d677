//! From a scene's structure to its reduced model.

pub mod bolt;
mod deck;
mod displacements;
mod excited;
pub mod export;
mod facing;
mod linear_interface;
mod masses;
mod material;
mod matrices;
mod matrix_contents;
mod mesh;
mod meshed;
mod mode_names;
mod modes;
mod overview;
mod reduce;
mod reduced;
mod rigid_motions;
mod shape;
mod spectrum;
mod superelements;
mod surface;
pub mod survey;
mod touching;

pub use linear_interface::LinearInterface;
pub use matrix_contents::matrix_files_of;
pub use mode_names::Shares;
pub use modes::{Assurance, Contact, ModalModel, ModeShape, ModesOfContact};
pub use overview::{BoltOverview, MaterialOverview, Overview, choice_name};
pub use reduced::{Facts, StructuralModel};
pub use shape::Shape;
pub use spectrum::{Description, Frequencies, Spectrum};
pub use surface::OuterSurface;

use crate::Error;
use crate::progress::Progress;
use finite_elements::mesh::GroundSpring;
use joint_model::benchmark::{MeshSettings, Symmetry};
use joint_model::{Bodies, Joint, MeshedBodies, Sides};
use material::material;
use meshed::Meshed;
use reduction::{Limits, Settings, checks};
use scenes::{BoltBehaviour, Model, Scene, StructureSource};
use zte_assembly::InterfaceMesh;

/// Frequencies compared between the full and the reduced model.
const N_CHECKED: usize = 10;

/// Coordinates across several interfaces up to which the reduced matrices are dense unless a scene says otherwise, and what may be left out of the coupling
/// of larger ones.
const LARGEST_DENSE: usize = 3000;
const COUPLING_TOLERANCE: f64 = 1e-7;

/// Rigid motions of benchmarks, which are free structures.
const FREE: usize = 6;

/// Zero-energy modes of the half of a free structure with the interface stuck: along x and z, and about y.
const HALF_ZERO_ENERGY_MODES: usize = 3;

/// The structure of a scene, before anything is computed with it.
#[derive(Clone, Debug)]
pub struct Structure {
    /// What it is made of.
    pub joint: Joint,
    settings: Settings,
    /// Whether the bolts are locked in vibration.
    locks: bool,
    symmetry: Symmetry,
    reduction_error: Option<f64>,
    /// That of the scene's material, if it has one.
    youngs_modulus: Option<f64>,
}

impl Structure {
    /// Meshes or reads the structure of a scene; bolts are loaded by unit tension, and may be locked later if they behave
    /// so.
    ///
    /// # Errors
    /// Those of the mesher, the deck or the matrices; [`scenes::Error::Symmetry`].
    pub fn try_new(scene: &Scene, progress: &dyn Progress) -> Result<Self, Error> {
        let mut structure = Self::as_read(scene, progress)?;
        if let Some(mode) = scene.structure.mesh().and_then(|mesh| mesh.response.mode) {
            structure.respond_where_a_mode_moves_most(mode, progress)?;
        }
        Ok(structure)
    }

    /// As [`Structure::try_new`], before anything is factored: a response where a mode moves most is not known yet.
    ///
    /// # Errors
    /// As [`Structure::try_new`].
    pub fn as_read(scene: &Scene, progress: &dyn Progress) -> Result<Self, Error> {
        let model = &scene.model;
        if model.symmetry == Symmetry::Half && scene.structure.benchmark().is_none() {
            return Err(scenes::Error::Symmetry {
                place: "the structure".into(),
                what: "a deck or matrices",
            }
            .into());
        }
        if let (Some(_), Some(mesh)) = (&scene.analyses.tightening, scene.structure.mesh())
            && let Some(bolt) = mesh.all_bolts().iter().position(|bolt| bolt.axis.is_none())
        {
            return Err(Error::NoElongation { bolt: Some(bolt + 1) });
        }
        let notes = &mut |note: &str| progress.note(note);
        let masses = &scene.structure.point_masses;
        let joint = match &scene.structure.source {
            StructureSource::Matrices(source) => matrices::joint(source, scene, notes)?,
            StructureSource::Deck(source) => deck::joint(source, scene, notes)?,
            StructureSource::Mesh(source) => mesh::joint(source, scene, notes)?,
            StructureSource::Benchmark(benchmark) => {
                if model.symmetry == Symmetry::Half {
                    notes("only the half y >= 0 is modelled, which leaves out all modes that are not symmetric");
                }
                excited::require_held(scene, FREE)?;
                let settings = MeshSettings {
                    refinement: model.refinement,
                    arm_layers: model.arm_layers,
                    symmetry: model.symmetry,
                    element_order: scene.element_order(),
                    hexahedra: scene.hexahedra(),
                    material: material(model)?,
                };
                let mut joint = benchmark.joint(&settings).map_err(|source| Error::Benchmark {
                    benchmark: benchmark.name(),
                    source,
                })?;
                if let Bodies::Meshed(bodies) = &mut joint.bodies {
                    let placed = masses::at_positions(&bodies.assembly.mesh.nodes, masses)?;
                    bodies.assembly.masses.extend(placed);
                }
                joint
            }
        };
        let mut structure = Self::from_joint(model, scene.bolts.behaviour, joint);
        structure.settings.attachment_modes |= scene.analyses.tightening.is_some();
        Ok(structure)
    }

    /// Measures amplitudes at the node that moves most in a mode of the structure with a stuck interface, along its motion.
    fn respond_where_a_mode_moves_most(&mut self, mode: usize, progress: &dyn Progress) -> Result<(), Error> {
        let Bodies::Meshed(bodies) = &self.joint.bodies else {
            return Err(Error::NoMesh);
        };
        let Meshed { system, relative } = Meshed::try_new(&self.joint, bodies)?;
        let stop = || progress.interrupted();
        let limits = Limits::default().until(&stop);
        let found = checks::stuck_modes(&relative, mode, self.settings.mode_tolerance, limits)?;
        let shapes = found.elastic();
        let last = shapes.ncols().min(mode);
        let over = relative.displacements(shapes.subcols(last - 1, 1));
        let motion = |node: usize| {
            [0, 1, 2].map(|c| {
                system
                    .dofs
                    .row(3 * node + c)
                    .map(|(column, value)| value * over[(column, 0)])
                    .sum::<f64>()
            })
        };
        let size = |x: [f64; 3]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let nodes = &bodies.assembly.mesh.nodes;
        // The first of equal ones, so that round-off does not choose.
        let largest = (0..nodes.len()).fold((0, 0.0), |best, node| {
            let moved = size(motion(node));
            if moved > best.1 * (1.0 + 1e-6) {
                (node, moved)
            } else {
                best
            }
        });
        let (node, moved) = largest;
        let direction = motion(node).map(|v| v / moved);
        let response = format!(
            "the node at {:?} m that moves most in mode {last} of the stuck structure, along {direction:?}",
            nodes[node]
        );
        progress.note(&format!("amplitudes are measured at {response}"));
        self.joint.response = response;
        if let Bodies::Meshed(bodies) = &mut self.joint.bodies {
            (bodies.response_node, bodies.response_direction) = (node as u32, direction);
        }
        Ok(())
    }

    /// A joint that is already there, reduced as a scene's `model` says; its bolts may be locked later if they behave so.
    pub fn from_joint(model: &Model, bolts: BoltBehaviour, joint: Joint) -> Self {
        let mut settings = Settings {
            n_modes: model.n_modes(),
            n_reported: model.n_modes().max(N_CHECKED),
            attachment_modes: bolts == BoltBehaviour::Locked,
            ..Settings::default()
        };
        if let Bodies::Meshed(bodies) = &joint.bodies {
            settings.expected_zem = bodies.rigid_motions;
        }
        if model.symmetry == Symmetry::Half {
            settings.expected_zem = HALF_ZERO_ENERGY_MODES;
        }
        if let Bodies::Imported(bodies) = &joint.bodies {
            settings.expected_zem = bodies.zero_energy_modes;
            if bodies.is_reduced {
                settings.n_modes = bodies.relative.stiffness.rows() - bodies.relative.n_relative;
            }
        }
        let several = matches!(&joint.bodies, Bodies::Meshed(MeshedBodies { sides: Sides::Projected(parts), .. }) if parts.len() > 1);
        if several {
            let is_large = 3 * joint.interface.nodes.len() > LARGEST_DENSE;
            let by_size = is_large.then_some(COUPLING_TOLERANCE);
            settings.blocks_if_smaller = model.coupling_tolerance.is_none();
            settings.coupling_tolerance = model
                .coupling_tolerance
                .or(by_size)
                .filter(|tolerance| *tolerance > 0.0);
        }
        Self {
            joint,
            settings,
            locks: bolts == BoltBehaviour::Locked,
            symmetry: model.symmetry,
            reduction_error: model.reduction_error,
            youngs_modulus: model.material.map(|material| material.youngs_modulus.si()),
        }
    }

    /// How many bolts it has.
    pub fn n_bolts(&self) -> usize {
        match &self.joint.bodies {
            Bodies::Imported(bodies) => bodies.relative.loads.len(),
            Bodies::Meshed(bodies) => bodies.assembly.loads.len(),
        }
    }

    /// The interface mesh.
    pub fn interface(&self) -> &InterfaceMesh {
        &self.joint.interface
    }

    /// The structure on two cords: springs to the ground of this stiffness (N/m) along each axis at the outermost nodes along
    /// the interface. None for matrices, whose nodes are not known.
    pub fn hung(&self, stiffness: f64) -> Option<Self> {
        let mut hung = self.clone();
        let along = hung.joint.frame[0];
        let Bodies::Meshed(bodies) = &mut hung.joint.bodies else {
            return None;
        };
        let place = |x: &[f64; 3]| x.iter().zip(along).map(|(x, a)| x * a).sum::<f64>();
        let nodes = (0_u32..).zip(bodies.assembly.mesh.nodes.iter().map(place));
        let first = nodes.clone().min_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let last = nodes.max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let springs = [first, last].into_iter().flat_map(|node| {
            (0..3).map(move |component| GroundSpring {
                node,
                component,
                stiffness,
            })
        });
        bodies.assembly.springs.extend(springs);
        Some(hung)
    }
}
