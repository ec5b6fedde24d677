//! From a scene's structure to its reduced model.

use crate::Error;
use crate::cache::{self, KeyBuilder};
use crate::joint::Joint;
use crate::progress::{Progress, Stage};
use crate::scene::{BoltBehaviour, FormulationName, Model, RefinementName};
use brake_reuss_beam::mesh::Refinement;
use reduction::{InterfacePairs, ReducedModel, RelativeSystem, Settings, Step, checks, reduce};
use serde::{Deserialize, Serialize};
use sprs::{CsMat, TriMat};
use std::path::Path;
use substructure::assemble::System;
use substructure::elements::Formulation;
use substructure::mesh::{Cell, Dof, Material};
use zte_assembly::{InterfaceMesh, Operators};

/// Frequencies compared between the full and the reduced model.
const N_CHECKED: usize = 10;

/// Uniform stiffness of the spectrum check, as a multiple of Young's modulus per metre: of the order of a bolted
/// interface's contact stiffness.
const CHECK_STIFFNESS: f64 = 50.0;

/// What is known of the full model behind a reduced one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Nodes of the solid mesh.
    pub n_nodes: usize,
    /// Elements of the solid mesh.
    pub n_elements: usize,
    /// Independent displacement components after constraints.
    pub n_dofs: usize,
    /// Mass (kg).
    pub mass: f64,
    /// Zero-energy modes without any contact.
    pub zem_unstressed: usize,
    /// Frequencies without any contact (Hz).
    pub unstressed_frequencies_hz: Vec<f64>,
    /// Frequencies of the full model with a uniform linear stiffness on the interface, the bolts locked if they are so
    /// in vibration (Hz).
    pub penalty_frequencies_hz: Vec<f64>,
    /// Largest relative difference of the reduced model's frequencies to these.
    pub penalty_error: f64,
}

/// A reduced structure.
#[derive(Clone, Debug)]
pub struct StructuralModel {
    /// Matrices; load `i` is unit tension of bolt `i`, recovery row 0 the response displacement. With attachment modes
    /// of the loads if the bolts lock; they are not locked yet.
    pub reduced: ReducedModel,
    /// What is known of the full model.
    pub facts: Facts,
}

/// The meshed structure, before anything is computed with it.
#[derive(Clone, Debug)]
pub struct MeshedStructure {
    /// What is meshed.
    pub joint: Joint,
    settings: Settings,
    youngs_modulus: f64,
}

impl MeshedStructure {
    /// Meshes or reads the structure of a scene; bolts are loaded by unit tension, and may be locked later if they behave
    /// so.
    ///
    /// # Errors
    /// Of the mesher or the deck.
    pub fn try_new(model: &Model, bolts: BoltBehaviour, progress: &dyn Progress) -> Result<Self, Error> {
        if let Some(deck) = &model.deck {
            let hexahedra = model.formulation.map(formulation);
            let joint = Joint::from_deck(deck, &material(model), hexahedra, &mut |note| progress.note(note))?;
            return Ok(Self::new(model, bolts, joint));
        }
        let refinement = match model.refinement {
            RefinementName::Quick => Refinement::quick(),
            RefinementName::Coarse => Refinement::coarse(),
            RefinementName::Default => Refinement::default(),
            RefinementName::Fine => Refinement::fine(),
            RefinementName::Finest => Refinement::finest(),
        };
        Self::with_refinement(model, bolts, &refinement)
    }

    /// The block mesh with a refinement of one's own instead of a named one.
    ///
    /// # Errors
    /// Of the mesher.
    pub fn with_refinement(model: &Model, bolts: BoltBehaviour, refinement: &Refinement) -> Result<Self, Error> {
        let mut joint = Joint::beam(refinement, &material(model))?;
        let hexahedra = model.formulation.map(formulation).unwrap_or_default();
        joint.assembly.mesh.set_formulation(hexahedra);
        Ok(Self::new(model, bolts, joint))
    }

    fn new(model: &Model, bolts: BoltBehaviour, joint: Joint) -> Self {
        Self {
            joint,
            settings: Settings {
                n_modes: model.modes,
                n_reported: model.modes.max(N_CHECKED),
                attachment_modes: bolts == BoltBehaviour::Locked,
                ..Settings::default()
            },
            youngs_modulus: model.material.youngs_modulus,
        }
    }

    /// The interface mesh.
    pub fn interface(&self) -> &InterfaceMesh {
        &self.joint.interface
    }

    /// The reduced model, from the cache if it holds one for the same inputs.
    ///
    /// # Errors
    /// Of assembly and reduction. A cache that cannot be written is noted, not fatal.
    pub fn reduce(&self, cache: Option<&Path>, progress: &dyn Progress) -> Result<StructuralModel, Error> {
        let key = self.key();
        if let Some(model) = cache.and_then(|directory| cache::load(directory, &key)) {
            progress.note("the reduced model was read from the cache");
            return Ok(model);
        }
        progress.begin(Stage::Assemble);
        let (system, relative) = self.assemble()?;
        let direction = self.joint.response_direction;
        let terms: Vec<_> = (0..3_u8)
            .map(|c| (Dof::Node(self.joint.response_node, c), direction[c as usize]))
            .collect();
        let row = relative.row(&system.dofs.force(&self.joint.assembly, "the response", &terms)?);
        progress.end(Stage::Assemble);
        progress.begin(Stage::Factor);
        let reduced = reduce(&relative, &[row], self.settings, &mut |step, done| match step {
            Step::Factor => {
                progress.fraction(Stage::Factor, done);
                if done == 1.0 {
                    progress.end(Stage::Factor);
                    progress.begin(Stage::Reduce);
                }
            }
            Step::Stream => progress.fraction(Stage::Reduce, 0.8 * done),
        })?;
        check_closing(&reduced)?;
        let facts = self.facts(&system, &relative, &reduced, progress)?;
        let model = StructuralModel { reduced, facts };
        if let Some(Err(error)) = cache.map(|directory| cache::store(directory, &key, &model)) {
            progress.note(&format!("the reduced model was not cached: {error}"));
        }
        progress.end(Stage::Reduce);
        Ok(model)
    }

    /// The system of both bodies, and the same in relative coordinates.
    fn assemble(&self) -> Result<(System, RelativeSystem), Error> {
        let system = System::try_new(&self.joint.assembly)?;
        let pairs = InterfacePairs {
            top: &self.joint.top_nodes,
            bottom: &self.joint.bottom_nodes,
            frame: self.joint.frame,
        };
        let relative = RelativeSystem::try_new(&system, pairs)?;
        Ok((system, relative))
    }

    /// What the structure is, without reducing it; on request with its `spectrum`: so many frequencies of each kind, with
    /// this linear interface or the default's.
    ///
    /// # Errors
    /// Of assembly and eigensolver.
    pub fn describe(
        &self,
        spectrum: Option<(usize, Option<LinearInterface>)>,
        progress: &dyn Progress,
    ) -> Result<Description, Error> {
        progress.begin(Stage::Assemble);
        let (system, relative) = self.assemble()?;
        progress.end(Stage::Assemble);
        let spectrum = spectrum.map(|(count, linear)| {
            let linear = linear.unwrap_or_else(|| self.check_interface());
            self.spectrum(&relative, count, linear, progress)
        });
        let mesh = &self.joint.assembly.mesh;
        Ok(Description {
            n_nodes: mesh.nodes.len(),
            n_elements: mesh.elements.len(),
            n_dofs: system.n_dofs(),
            mass: system.total_mass,
            n_interface_elements: self.joint.interface.elements.len(),
            interface_area: self.joint.interface.areas().iter().sum(),
            n_untied_slaves: system.dofs.untied.len(),
            largest_adjustment: system.dofs.largest_adjustment,
            spectrum: spectrum.transpose()?,
        })
    }

    fn spectrum(
        &self,
        relative: &RelativeSystem,
        count: usize,
        linear: LinearInterface,
        progress: &dyn Progress,
    ) -> Result<Spectrum, Error> {
        progress.begin(Stage::Factor);
        let tolerance = self.settings.mode_tolerance;
        let modes = |(zero_energy_modes, frequencies_hz)| Frequencies {
            zero_energy_modes,
            frequencies_hz,
        };
        let unstressed = modes(checks::full_frequencies(relative, None, count, tolerance)?);
        progress.fraction(Stage::Factor, 0.33);
        let stuck = modes(checks::stuck_frequencies(relative, count, tolerance)?);
        progress.fraction(Stage::Factor, 0.67);
        let springs = linear.matrix(&self.joint.interface)?;
        let with_linear = modes(checks::full_frequencies(relative, Some(&springs), count, tolerance)?);
        progress.end(Stage::Factor);
        Ok(Spectrum {
            unstressed,
            stuck,
            linear,
            with_linear,
        })
    }

    /// The uniform interface stiffness that reductions are checked with.
    fn check_interface(&self) -> LinearInterface {
        let stiffness = CHECK_STIFFNESS * self.youngs_modulus;
        LinearInterface {
            normal_stiffness: stiffness,
            tangential_stiffness: stiffness,
            points_per_direction: 2,
        }
    }

    fn facts(
        &self,
        system: &System,
        relative: &RelativeSystem,
        reduced: &ReducedModel,
        progress: &dyn Progress,
    ) -> Result<Facts, Error> {
        let tolerance = self.settings.mode_tolerance;
        let (zem_unstressed, unstressed) = checks::full_frequencies(relative, None, N_CHECKED, tolerance)?;
        progress.fraction(Stage::Reduce, 0.88);
        let springs = self.check_interface().matrix(&self.joint.interface)?;
        // The check is of the model that vibrates.
        let locked = match self.settings.attachment_modes {
            true => Some((relative.locked()?, reduced.locked()?)),
            false => None,
        };
        let (relative, reduced) = locked
            .as_ref()
            .map_or((relative, reduced), |(full, small)| (full, small));
        let (_, full) = checks::full_frequencies(relative, Some(&springs), N_CHECKED, tolerance)?;
        let small = checks::reduced_frequencies(reduced, &springs, N_CHECKED)?;
        let error = full
            .iter()
            .zip(&small)
            .map(|(a, b)| (b / a - 1.0).abs())
            .fold(0.0, f64::max);
        Ok(Facts {
            n_nodes: self.joint.assembly.mesh.nodes.len(),
            n_elements: self.joint.assembly.mesh.elements.len(),
            n_dofs: system.n_dofs(),
            mass: system.total_mass,
            zem_unstressed,
            unstressed_frequencies_hz: unstressed,
            penalty_frequencies_hz: full,
            penalty_error: error,
        })
    }

    /// Hash of everything the reduced model depends on.
    fn key(&self) -> cache::Key {
        let mut key = KeyBuilder::new();
        let assembly = &self.joint.assembly;
        key.numbers(assembly.mesh.nodes.iter().flatten().copied());
        key.integers(assembly.mesh.elements.iter().flat_map(|e| {
            e.cell
                .nodes()
                .iter()
                .map(|&n| u64::from(n))
                .chain([u64::from(e.material), kind(&e.cell)])
        }));
        key.integers(
            self.joint
                .top_nodes
                .iter()
                .chain(&self.joint.bottom_nodes)
                .map(|&n| u64::from(n)),
        );
        key.numbers(
            self.joint
                .frame
                .iter()
                .flatten()
                .chain(&self.joint.response_direction)
                .copied(),
        );
        // Small parts, where a readable form costs nothing.
        key.text(&format!(
            "{:?}{:?}{:?}{:?}{:?}{:?}{:?}{:?}{:?}{:?}",
            assembly.mesh.materials,
            assembly.ties,
            assembly.couplings,
            assembly.equations,
            assembly.loads,
            assembly.supports,
            assembly.springs,
            self.joint.response_node,
            self.settings,
            (N_CHECKED, CHECK_STIFFNESS),
        ));
        key.finish()
    }
}

/// A linear interface without friction or opening.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LinearInterface {
    /// Per area (Pa/m).
    pub normal_stiffness: f64,
    /// Per area, in both directions (Pa/m).
    pub tangential_stiffness: f64,
    /// Integration points per direction of each element.
    pub points_per_direction: usize,
}

impl LinearInterface {
    /// Stiffness over the jump coordinates (N/m).
    fn matrix(&self, mesh: &InterfaceMesh) -> Result<CsMat<f64>, Error> {
        let operators = Operators::try_new(mesh, self.points_per_direction)?;
        // Integral of the products of the shape functions.
        let products: CsMat<f64> = &operators.integration * &operators.interpolation;
        let stiffness = [
            self.tangential_stiffness,
            self.tangential_stiffness,
            self.normal_stiffness,
        ];
        let size = 3 * products.rows();
        let mut matrix = TriMat::with_capacity((size, size), 3 * products.nnz());
        for (&value, (i, j)) in &products {
            for (c, k) in stiffness.into_iter().enumerate().filter(|(_, k)| *k != 0.0) {
                matrix.add_triplet(3 * i + c, 3 * j + c, k * value);
            }
        }
        Ok(matrix.to_csr())
    }
}

/// A number of zero-energy modes and the frequencies above them (Hz).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Frequencies {
    /// Motions without energy.
    pub zero_energy_modes: usize,
    /// Ascending.
    pub frequencies_hz: Vec<f64>,
}

/// Frequencies of a structure with linear interfaces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spectrum {
    /// Without contact.
    pub unstressed: Frequencies,
    /// With the interface stuck.
    pub stuck: Frequencies,
    /// The linear interface of `with_linear`.
    pub linear: LinearInterface,
    /// With it.
    pub with_linear: Frequencies,
}

/// What is known of a structure before it is reduced.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Description {
    /// Nodes of the solid mesh.
    pub n_nodes: usize,
    /// Its elements.
    pub n_elements: usize,
    /// Independent displacement components.
    pub n_dofs: usize,
    /// Mass (kg).
    pub mass: f64,
    /// Interface elements.
    pub n_interface_elements: usize,
    /// Area of the interface (m^2).
    pub interface_area: f64,
    /// Slaves left free beyond the tolerance of their tie.
    pub n_untied_slaves: usize,
    /// Largest move of a slave onto its master face (m).
    pub largest_adjustment: f64,
    /// Where asked for.
    pub spectrum: Option<Spectrum>,
}

fn material(model: &Model) -> Material {
    Material {
        name: "scene".into(),
        youngs_modulus: model.material.youngs_modulus,
        poisson_ratio: model.material.poisson_ratio,
        density: model.material.density,
    }
}

fn formulation(name: FormulationName) -> Formulation {
    match name {
        FormulationName::IncompatibleModes => Formulation::IncompatibleModes,
        FormulationName::BBar => Formulation::BBar,
        FormulationName::Full => Formulation::Full,
        FormulationName::Reduced => Formulation::Reduced,
    }
}

/// Number of a cell's type, for keys.
fn kind(cell: &Cell) -> u64 {
    match cell {
        Cell::Hex8(_, Formulation::IncompatibleModes) => 0,
        Cell::Hex8(_, Formulation::BBar) => 1,
        Cell::Hex8(_, Formulation::Full) => 2,
        Cell::Hex8(_, Formulation::Reduced) => 3,
        Cell::Wedge6(_) => 4,
        Cell::Tet4(_) => 5,
        Cell::Tet10(_) => 6,
    }
}

/// Refuses bolts that open the interface: a uniform closure must yield to their load.
fn check_closing(reduced: &ReducedModel) -> Result<(), Error> {
    for (index, load) in reduced.loads.iter().enumerate() {
        let closing: f64 = load[2..reduced.n_relative].iter().step_by(3).sum();
        // Also catches NaN.
        if !(closing > 0.0) {
            return Err(Error::OpeningLoad {
                bolt: index + 1,
                force: closing,
            });
        }
    }
    Ok(())
}
