//! From a scene's structure to its reduced model.

use crate::Error;
use crate::cache::{self, KeyBuilder};
use crate::progress::{Progress, Stage};
use crate::scene::{BoltBehaviour, FormulationName, Model, RefinementName};
use brake_reuss_beam::geometry::Geometry;
use brake_reuss_beam::mesh::{BrakeReussBeam, Refinement, build};
use reduction::{InterfacePairs, ReducedModel, RelativeSystem, Settings, Step, checks, reduce};
use serde::{Deserialize, Serialize};
use std::path::Path;
use substructure::assemble::System;
use substructure::elements::Formulation;
use substructure::mesh::{Dof, Material};
use zte_assembly::InterfaceMesh;

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
    beam: BrakeReussBeam,
    /// The bolt-hole clearance: by how much the bodies can slide before a shank touches its hole (m).
    pub clearance: f64,
    formulation: Formulation,
    settings: Settings,
    youngs_modulus: f64,
}

impl MeshedStructure {
    /// Meshes the structure of a scene; bolts are loaded by unit tension, and may be locked later if they behave so.
    ///
    /// # Errors
    /// Of the mesher.
    pub fn try_new(model: &Model, bolts: BoltBehaviour) -> Result<Self, Error> {
        let refinement = match model.refinement {
            RefinementName::Quick => Refinement::quick(),
            RefinementName::Coarse => Refinement::coarse(),
            RefinementName::Default => Refinement::default(),
            RefinementName::Fine => Refinement::fine(),
            RefinementName::Finest => Refinement::finest(),
        };
        Self::with_refinement(model, bolts, &refinement)
    }

    /// The same with a mesh of one's own instead of a named one.
    ///
    /// # Errors
    /// Of the mesher.
    pub fn with_refinement(model: &Model, bolts: BoltBehaviour, refinement: &Refinement) -> Result<Self, Error> {
        let geometry = Geometry::default();
        let material = Material {
            name: "beam, bolts, washers and nuts".into(),
            youngs_modulus: model.material.youngs_modulus,
            poisson_ratio: model.material.poisson_ratio,
            density: model.material.density,
        };
        let formulation = match model.formulation {
            FormulationName::IncompatibleModes => Formulation::IncompatibleModes,
            FormulationName::BBar => Formulation::BBar,
            FormulationName::Full => Formulation::Full,
            FormulationName::Reduced => Formulation::Reduced,
        };
        let mut beam = build(&geometry, refinement, &material, 1.0)?;
        beam.assembly.mesh.set_formulation(formulation);
        Ok(Self {
            beam,
            clearance: 0.5 * (geometry.hole_diameter - geometry.shank_diameter),
            formulation,
            settings: Settings {
                n_modes: model.modes,
                n_reported: model.modes.max(N_CHECKED),
                attachment_modes: bolts == BoltBehaviour::Locked,
                ..Settings::default()
            },
            youngs_modulus: model.material.youngs_modulus,
        })
    }

    /// The interface mesh.
    pub fn interface(&self) -> &InterfaceMesh {
        &self.beam.interface
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
        let system = System::try_new(&self.beam.assembly)?;
        let pairs = InterfacePairs {
            top: &self.beam.top_nodes,
            bottom: &self.beam.bottom_nodes,
            frame: self.beam.frame,
        };
        let relative = RelativeSystem::try_new(&system, pairs)?;
        let direction = self.beam.response_direction;
        let terms: Vec<_> = (0..3_u8)
            .map(|c| (Dof::Node(self.beam.response_node, c), direction[c as usize]))
            .collect();
        let row = relative.row(&system.dofs.force(&self.beam.assembly, "the response", &terms)?);
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
        let facts = self.facts(&system, &relative, &reduced, progress)?;
        let model = StructuralModel { reduced, facts };
        if let Some(Err(error)) = cache.map(|directory| cache::store(directory, &key, &model)) {
            progress.note(&format!("the reduced model was not cached: {error}"));
        }
        progress.end(Stage::Reduce);
        Ok(model)
    }

    fn facts(
        &self,
        system: &System,
        relative: &RelativeSystem,
        reduced: &ReducedModel,
        progress: &dyn Progress,
    ) -> Result<Facts, Error> {
        let tolerance = self.settings.mode_tolerance;
        let loose = vec![0.0; relative.n_relative];
        let (zem_unstressed, unstressed) = checks::full_frequencies(relative, &loose, N_CHECKED, tolerance)?;
        progress.fraction(Stage::Reduce, 0.88);
        let area = self.beam.interface.areas().iter().sum::<f64>() / (relative.n_relative as f64 / 3.0);
        let penalty = vec![CHECK_STIFFNESS * self.youngs_modulus * area; relative.n_relative];
        // The check is of the model that vibrates.
        let locked = match self.settings.attachment_modes {
            true => Some((relative.locked()?, reduced.locked()?)),
            false => None,
        };
        let (relative, reduced) = locked
            .as_ref()
            .map_or((relative, reduced), |(full, small)| (full, small));
        let (_, full) = checks::full_frequencies(relative, &penalty, N_CHECKED, tolerance)?;
        let small = checks::reduced_frequencies(reduced, &penalty, N_CHECKED)?;
        let error = full
            .iter()
            .zip(&small)
            .map(|(a, b)| (b / a - 1.0).abs())
            .fold(0.0, f64::max);
        Ok(Facts {
            n_nodes: self.beam.assembly.mesh.nodes.len(),
            n_elements: self.beam.assembly.mesh.elements.len(),
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
        let assembly = &self.beam.assembly;
        key.numbers(assembly.mesh.nodes.iter().flatten().copied());
        key.integers(assembly.mesh.elements.iter().flat_map(|e| {
            e.cell
                .nodes()
                .iter()
                .map(|&n| u64::from(n))
                .chain(std::iter::once(u64::from(e.material)))
        }));
        key.integers(
            self.beam
                .top_nodes
                .iter()
                .chain(&self.beam.bottom_nodes)
                .map(|&n| u64::from(n)),
        );
        key.numbers(
            self.beam
                .frame
                .iter()
                .flatten()
                .chain(&self.beam.response_direction)
                .copied(),
        );
        // Small parts, where a readable form costs nothing.
        key.text(&format!(
            "{:?}{:?}{:?}{:?}{:?}{:?}{:?}{:?}{:?}",
            assembly.mesh.materials,
            assembly.ties,
            assembly.couplings,
            assembly.equations,
            assembly.loads,
            self.beam.response_node,
            self.formulation,
            self.settings,
            (N_CHECKED, CHECK_STIFFNESS),
        ));
        key.finish()
    }
}
