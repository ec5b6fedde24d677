//! From a scene's structure to its reduced model.

use crate::Error;
use crate::cache::{self, KeyBuilder};
use crate::interface::operators;
use crate::joint::{Bodies, Joint};
use crate::matrices::ImportedBodies;
use crate::progress::{Progress, Stage};
use crate::scene::{BoltBehaviour, FormulationName, Model, RefinementName, Symmetry};
use brake_reuss_beam::mesh::Refinement;
use reduction::{InterfacePairs, ReducedModel, RelativeSystem, Settings, Step, checks, reduce};
use serde::{Deserialize, Serialize};
use sprs::{CsMat, TriMat};
use std::borrow::Cow;
use std::path::Path;
use substructure::assemble::System;
use substructure::elements::Formulation;
use substructure::mesh::{Cell, Dof, GroundSpring, Material};
use zte_assembly::InterfaceMesh;

/// Frequencies compared between the full and the reduced model.
const N_CHECKED: usize = 10;

/// Residual that modes reach where only their frequencies matter, whose error is of the order of its square.
const FREQUENCY_TOLERANCE: f64 = 1e-4;

/// Uniform stiffness of the spectrum check, as a multiple of Young's modulus per metre: of the order of a bolted
/// interface's contact stiffness.
const CHECK_STIFFNESS: f64 = 50.0;

/// Of a free body.
const RIGID_MOTIONS: usize = 6;
/// Zero-energy modes of the half of a free structure with the interface stuck: along x and z, and about y.
const HALF_ZERO_ENERGY_MODES: usize = 3;

/// What is known of the full model behind a reduced one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Nodes of the solid mesh.
    pub n_nodes: Option<usize>,
    /// Elements of the solid mesh.
    pub n_elements: Option<usize>,
    /// Independent displacement components after constraints, or coordinates of imported matrices.
    pub n_dofs: usize,
    /// Mass (kg), if it is known.
    pub mass: Option<f64>,
    /// Zero-energy modes without any contact.
    pub zem_unstressed: usize,
    /// Frequencies of the reduced model without any contact (Hz).
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

/// The structure of a scene, before anything is computed with it.
#[derive(Clone, Debug)]
pub struct Structure {
    /// What it is made of.
    pub joint: Joint,
    settings: Settings,
    symmetry: Symmetry,
    reduction_error: Option<f64>,
    youngs_modulus: f64,
}

impl Structure {
    /// Meshes or reads the structure of a scene; bolts are loaded by unit tension, and may be locked later if they behave
    /// so.
    ///
    /// # Errors
    /// Of the mesher, the deck or the matrices; [`Error::Symmetry`].
    pub fn try_new(model: &Model, bolts: BoltBehaviour, progress: &dyn Progress) -> Result<Self, Error> {
        if model.symmetry == Symmetry::Half && (model.deck.is_some() || model.matrices.is_some()) {
            return Err(Error::Symmetry {
                place: "the structure".into(),
                what: "a deck or matrices",
            });
        }
        if let Some(matrices) = &model.matrices {
            let joint = Joint::from_matrices(matrices, &mut |note| progress.note(note))?;
            return Ok(Self::new(model, bolts, joint));
        }
        if let Some(deck) = &model.deck {
            let hexahedra = model.formulation.map(formulation);
            let joint = Joint::from_deck(deck, &material(model), hexahedra, &mut |note| progress.note(note))?;
            return Ok(Self::new(model, bolts, joint));
        }
        let mut refinement = match model.refinement {
            RefinementName::Quick => Refinement::quick(),
            RefinementName::Coarse => Refinement::coarse(),
            RefinementName::Default => Refinement::default(),
            RefinementName::Fine => Refinement::fine(),
            RefinementName::Finest => Refinement::finest(),
        };
        if let Some(layers) = model.arm_layers {
            refinement.arm_layers = layers;
        }
        if model.symmetry == Symmetry::Half {
            progress.note("only the half y >= 0 is modelled, which leaves out all modes that are not symmetric");
        }
        Self::with_refinement(model, bolts, &refinement)
    }

    /// The block mesh with a refinement of one's own instead of a named one.
    ///
    /// # Errors
    /// Of the mesher.
    pub fn with_refinement(model: &Model, bolts: BoltBehaviour, refinement: &Refinement) -> Result<Self, Error> {
        let hexahedra = model.formulation.map(formulation).unwrap_or_default();
        let joint = Joint::beam(refinement, model.symmetry, &material(model), hexahedra)?;
        Ok(Self::new(model, bolts, joint))
    }

    fn new(model: &Model, bolts: BoltBehaviour, joint: Joint) -> Self {
        let mut settings = Settings {
            n_modes: model.n_modes(),
            n_reported: model.n_modes().max(N_CHECKED),
            attachment_modes: bolts == BoltBehaviour::Locked,
            ..Settings::default()
        };
        if model.symmetry == Symmetry::Half {
            settings.expected_zem = HALF_ZERO_ENERGY_MODES;
        }
        if let Bodies::Imported(bodies) = &joint.bodies {
            settings.expected_zem = bodies.zero_energy_modes;
            if bodies.is_reduced {
                settings.n_modes = bodies.relative.stiffness.rows() - bodies.relative.n_relative;
            }
        }
        Self {
            joint,
            settings,
            symmetry: model.symmetry,
            reduction_error: model.reduction_error,
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
        let assembled = self.assemble()?;
        progress.end(Stage::Assemble);
        progress.begin(Stage::Factor);
        let mut reduced = reduce(
            &assembled.relative,
            &assembled.rows,
            self.settings,
            &mut |step, done| match step {
                Step::Factor => {
                    progress.fraction(Stage::Factor, done);
                    if done == 1.0 {
                        progress.end(Stage::Factor);
                        progress.begin(Stage::Reduce);
                    }
                }
                Step::Stream => progress.fraction(Stage::Reduce, 0.8 * done),
            },
        )?;
        check_closing(&reduced)?;
        let facts = self.facts(&assembled, &mut reduced, progress)?;
        let model = StructuralModel { reduced, facts };
        if let Some(Err(error)) = cache.map(|directory| cache::store(directory, &key, &model)) {
            progress.note(&format!("the reduced model was not cached: {error}"));
        }
        progress.end(Stage::Reduce);
        Ok(model)
    }

    /// The system in relative coordinates.
    fn assemble(&self) -> Result<Assembled<'_>, Error> {
        let bodies = match &self.joint.bodies {
            Bodies::Imported(bodies) => return Ok(Assembled::imported(bodies)),
            Bodies::Meshed(bodies) => bodies,
        };
        let system = System::try_new(&bodies.assembly)?;
        let pairs = InterfacePairs {
            top: &bodies.top_nodes,
            bottom: &bodies.bottom_nodes,
            frame: self.joint.frame,
        };
        let relative = RelativeSystem::try_new(&system, pairs)?;
        let terms: Vec<_> = (0..3_u8)
            .map(|c| {
                let direction = bodies.response_direction[usize::from(c)];
                (Dof::Node(bodies.response_node, c), direction)
            })
            .collect();
        let response = relative.row(&system.dofs.force(&bodies.assembly, "the response", &terms)?);
        Ok(Assembled {
            relative: Cow::Owned(relative),
            rows: [response],
            n_nodes: Some(bodies.assembly.mesh.nodes.len()),
            n_elements: Some(bodies.assembly.mesh.elements.len()),
            mass: Some(system.total_mass),
            n_untied_slaves: system.dofs.untied.len(),
            largest_adjustment: system.dofs.largest_adjustment,
        })
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
        let assembled = self.assemble()?;
        progress.end(Stage::Assemble);
        let spectrum = spectrum.map(|(count, linear)| {
            let linear = linear.unwrap_or_else(|| self.check_interface());
            self.spectrum(&assembled.relative, count, linear, progress)
        });
        Ok(Description {
            n_nodes: assembled.n_nodes,
            n_elements: assembled.n_elements,
            n_dofs: assembled.relative.stiffness.rows(),
            mass: assembled.mass,
            n_interface_elements: self.joint.interface.elements.len(),
            interface_area: operators(&self.joint.interface, self.symmetry, 2)?.area(),
            n_untied_slaves: assembled.n_untied_slaves,
            largest_adjustment: assembled.largest_adjustment,
            spectrum: spectrum.transpose()?,
        })
    }

    /// The `count` lowest elastic modes of the full structure whose interface is `linear` on the elements that are `closed`, and
    /// open on all others. Frequencies of rigid motions on ground springs are not among them.
    ///
    /// # Errors
    /// Of assembly and eigensolver.
    pub fn frequencies(
        &self,
        linear: LinearInterface,
        closed: impl Fn(usize) -> bool,
        count: usize,
    ) -> Result<Frequencies, Error> {
        let assembled = self.assemble()?;
        let springs = self.springs(linear, closed)?;
        let tolerance = self.settings.mode_tolerance;
        let (zero_energy_modes, frequencies) =
            checks::full_frequencies(&assembled.relative, Some(&springs), count + RIGID_MOTIONS, tolerance)?;
        // Springs to the ground make modes of rigid motions.
        let rigid = RIGID_MOTIONS.saturating_sub(zero_energy_modes);
        Ok(Frequencies {
            zero_energy_modes,
            frequencies_hz: frequencies.into_iter().skip(rigid).take(count).collect(),
        })
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
        let springs = self.springs(linear, |_| true)?;
        let with_linear = modes(checks::full_frequencies(relative, Some(&springs), count, tolerance)?);
        progress.end(Stage::Factor);
        Ok(Spectrum {
            unstressed,
            stuck,
            linear,
            with_linear,
        })
    }

    /// Stiffness of a linear interface over the jump coordinates (N/m).
    fn springs(&self, linear: LinearInterface, closed: impl Fn(usize) -> bool) -> Result<CsMat<f64>, Error> {
        let operators = operators(&self.joint.interface, self.symmetry, linear.points_per_direction)?;
        let mut interpolation = operators.interpolation.clone();
        for element in (0..operators.n_elements()).filter(|&element| !closed(element)) {
            for point in operators.first_point[element]..operators.first_point[element + 1] {
                if let Some(mut row) = interpolation.outer_view_mut(point) {
                    row.iter_mut().for_each(|(_, value)| *value = 0.0);
                }
            }
        }
        // Integral of the products of the shape functions.
        let products: CsMat<f64> = &operators.integration * &interpolation;
        let stiffness = [
            linear.tangential_stiffness,
            linear.tangential_stiffness,
            linear.normal_stiffness,
        ];
        let is_held = |coordinate: usize| operators.held().binary_search(&coordinate).is_ok();
        let size = 3 * products.rows();
        let mut matrix = TriMat::with_capacity((size, size), 3 * products.nnz());
        for (&value, (i, j)) in &products {
            for (c, k) in stiffness.into_iter().enumerate().filter(|(_, k)| *k != 0.0) {
                if !(is_held(3 * i + c) || is_held(3 * j + c)) {
                    matrix.add_triplet(3 * i + c, 3 * j + c, k * value);
                }
            }
        }
        Ok(matrix.to_csr())
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

    /// Compares the reduced model with the full one, after leaving out the modes that the wanted accuracy does not need.
    fn facts(
        &self,
        assembled: &Assembled<'_>,
        reduced: &mut ReducedModel,
        progress: &dyn Progress,
    ) -> Result<Facts, Error> {
        let tolerance = FREQUENCY_TOLERANCE;
        let relative: &RelativeSystem = &assembled.relative;
        let (zem_unstressed, unstressed) = checks::unstressed_spectrum(reduced, N_CHECKED)?;
        progress.fraction(Stage::Reduce, 0.85);
        let springs = self.springs(self.check_interface(), |_| true)?;
        // The check is of the model that vibrates.
        let is_locked = self.settings.attachment_modes;
        let full = match is_locked {
            true => checks::full_frequencies(&relative.locked()?, Some(&springs), N_CHECKED, tolerance)?.1,
            false => checks::full_frequencies(relative, Some(&springs), N_CHECKED, tolerance)?.1,
        };
        let error_of = |reduced: &ReducedModel| -> Result<f64, Error> {
            let small = match is_locked {
                true => checks::reduced_spectrum(&reduced.locked()?, &springs, N_CHECKED)?,
                false => checks::reduced_spectrum(reduced, &springs, N_CHECKED)?,
            };
            let errors = full.iter().zip(&small.frequencies).map(|(a, b)| (b / a - 1.0).abs());
            Ok(errors.fold(0.0, f64::max))
        };
        let mut error = error_of(reduced)?;
        if let Some(target) = self.reduction_error {
            let without = checks::reduced_spectrum(reduced, &springs, N_CHECKED)?.without_mode;
            // From the highest mode down, as long as what is left out stays within the target.
            let mut left_out = error;
            let dispensable = without.iter().rev().take_while(|rise| {
                left_out += **rise;
                left_out <= target
            });
            let n_modes = without.len() - dispensable.count();
            if error > target {
                return Err(Error::ReductionTarget {
                    target,
                    error,
                    modes: without.len(),
                });
            }
            reduced.truncate(n_modes);
            error = error_of(reduced)?;
        }
        Ok(Facts {
            n_nodes: assembled.n_nodes,
            n_elements: assembled.n_elements,
            n_dofs: assembled.relative.stiffness.rows(),
            mass: assembled.mass,
            zem_unstressed,
            unstressed_frequencies_hz: unstressed,
            penalty_frequencies_hz: full,
            penalty_error: error,
        })
    }

    /// Hash of everything the reduced model depends on.
    fn key(&self) -> cache::Key {
        let mut key = KeyBuilder::new();
        key.numbers(self.joint.frame.iter().flatten().copied());
        key.text(&format!(
            "{:?}{:?}{:?}",
            self.settings,
            self.reduction_error,
            (N_CHECKED, CHECK_STIFFNESS)
        ));
        // The springs of the spectrum check depend on these.
        key.numbers(self.joint.interface.nodes.iter().flatten().copied());
        key.text(&format!("{:?}{:?}", self.joint.interface.elements, self.youngs_modulus));
        match &self.joint.bodies {
            Bodies::Imported(bodies) => {
                let relative = &bodies.relative;
                for matrix in [&relative.stiffness, &relative.mass] {
                    key.integers(matrix.indptr().raw_storage().iter().map(|&i| i as u64));
                    key.integers(matrix.indices().iter().map(|&i| i as u64));
                    key.numbers(matrix.data().iter().copied());
                }
                key.numbers(relative.loads.iter().flatten().chain(&bodies.response).copied());
                key.text(&format!("{:?}", (relative.n_relative, bodies.mass)));
            }
            Bodies::Meshed(bodies) => {
                let assembly = &bodies.assembly;
                key.numbers(assembly.mesh.nodes.iter().flatten().copied());
                key.integers(assembly.mesh.elements.iter().flat_map(|e| {
                    e.cell
                        .nodes()
                        .iter()
                        .map(|&n| u64::from(n))
                        .chain([u64::from(e.material), kind(&e.cell)])
                }));
                let facing = bodies.top_nodes.iter().chain(&bodies.bottom_nodes);
                key.integers(facing.map(|&n| u64::from(n)));
                key.numbers(bodies.response_direction);
                // Small parts, where a readable form costs nothing.
                key.text(&format!(
                    "{:?}{:?}{:?}{:?}{:?}{:?}{:?}{:?}",
                    assembly.mesh.materials,
                    assembly.ties,
                    assembly.couplings,
                    assembly.equations,
                    assembly.loads,
                    assembly.supports,
                    assembly.springs,
                    bodies.response_node,
                ));
            }
        }
        key.finish()
    }
}

/// A system in relative coordinates, and what is known of it.
struct Assembled<'a> {
    relative: Cow<'a, RelativeSystem>,
    /// Quantities to recover: the response.
    rows: [Vec<f64>; 1],
    n_nodes: Option<usize>,
    n_elements: Option<usize>,
    mass: Option<f64>,
    n_untied_slaves: usize,
    largest_adjustment: f64,
}

impl<'a> Assembled<'a> {
    fn imported(bodies: &'a ImportedBodies) -> Self {
        Self {
            relative: Cow::Borrowed(&bodies.relative),
            rows: [bodies.response.clone()],
            n_nodes: None,
            n_elements: None,
            mass: bodies.mass,
            n_untied_slaves: 0,
            largest_adjustment: 0.0,
        }
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
    pub n_nodes: Option<usize>,
    /// Its elements.
    pub n_elements: Option<usize>,
    /// Independent displacement components, or coordinates of imported matrices.
    pub n_dofs: usize,
    /// Mass (kg), if it is known.
    pub mass: Option<f64>,
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

/// Refuses bolts that do not close the interface: of all uniform jumps, a closure must yield most to their load.
fn check_closing(reduced: &ReducedModel) -> Result<(), Error> {
    for (index, load) in reduced.loads.iter().enumerate() {
        let [x, y, closing] = [0, 1, 2].map(|c| load[c..reduced.n_relative].iter().step_by(3).sum::<f64>());
        let sliding = x.hypot(y);
        // Also catches NaN.
        if !(closing > sliding) {
            return Err(Error::OpeningLoad {
                bolt: index + 1,
                closing,
                sliding,
            });
        }
    }
    Ok(())
}
