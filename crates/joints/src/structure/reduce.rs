//! Assembly and reduction of a structure.

use super::linear_interface::CHECK_STIFFNESS;
use super::meshed::{Meshed, relative};
use super::{Facts, N_CHECKED, StructuralModel, Structure};
use crate::Error;
use crate::progress::{Progress, Silent, Stage, end_stage, go_on};
use crate::store::Options;
use crate::store::cache;
use crate::store::key::{Key, KeyBuilder};
use finite_elements::assemble::System;
use finite_elements::mesh::{Assembly, Cell};
use joint_model::{Bodies, Excited, ImportedBodies, MeshedBodies, Sides};
use reduction::checks::{self, ReducedSpectrum};
use reduction::{Limits, LinearCheck, ReducedModel, Reduction, RelativeSystem, Settings, reduce, reduce_with_modes};
use sprs::CsMat;
use std::borrow::Cow;

/// Residual that modes reach where only their frequencies matter, whose error is of the order of its square.
const FREQUENCY_TOLERANCE: f64 = 1e-4;

/// Times that the assembled matrices are held while they are factored: as they are, and as the part, shifted or with springs, that is worked
/// on.
const COPIES: u64 = 2;

/// Dense matrices of the size of the reduced model that prestress, modes and loops hold at their peak: 10 were measured on the Brake-Reuss
/// beam with 588 and with 2352 elements.
const MATRICES: usize = 10;

/// Columns of the basis of a joint, if its coupling to others is of low rank: 40 to 220 were measured.
const EXPECTED_RANK: usize = 128;

/// Residual of the modes of structures whose differences are wanted.
const NEIGHBOUR_TOLERANCE: f64 = 1e-9;

/// What may be left out of the coupling of joints in these structures, relative to what may otherwise: differences enlarge it by the inverse of their step.
const NEIGHBOUR_COUPLING: f64 = 1e-3;

impl Structure {
    /// The reduced model, from the cache if it holds one for the same inputs.
    ///
    /// # Errors
    /// Of assembly and reduction, of which memory and interruption; [`Error::Memory`]. A cache that cannot be written is noted, not fatal.
    pub fn reduce(&self, options: &Options, progress: &dyn Progress) -> Result<StructuralModel, Error> {
        self.refuse_too_large(options.memory)?;
        let (cache, key) = (options.cache.as_deref(), self.key(options.build.as_deref()));
        if let Some((reduced, facts)) = cache.and_then(|directory| cache::load(directory, &key)) {
            progress.note("the reduced model was read from the cache");
            return Ok(StructuralModel { reduced, facts });
        }
        progress.begin(Stage::Assemble);
        let assembled = self.assemble_until(progress)?;
        end_stage(progress, Stage::Assemble)?;
        let stop = || progress.interrupted();
        let left = options
            .memory
            .map(|memory| memory.saturating_sub(COPIES * assembled.memory()));
        let limits = Limits::default().until(&stop).within(left);
        progress.begin(Stage::Factor);
        let springs = self.springs(self.check_interface(), |_| true)?;
        let check = LinearCheck {
            springs: &springs,
            count: N_CHECKED,
            tolerance: FREQUENCY_TOLERANCE,
            is_locked: self.locks,
        };
        let hear = |done| progress.fraction(Stage::Factor, done);
        let Assembled {
            relative,
            rows,
            carried,
            n_nodes,
            n_elements,
            mass,
            ..
        } = assembled;
        let n_dofs = relative.stiffness.rows();
        let Reduction {
            model: mut reduced,
            modes,
            frequencies,
        } = reduce_with_modes(relative, &rows, self.settings, Some(check), limits.heard_by(&hear))?;
        end_stage(progress, Stage::Factor)?;
        progress.begin(Stage::Reduce);
        check_closing(&reduced)?;
        let (zem_unstressed, unstressed) = checks::unstressed_spectrum(&reduced, N_CHECKED)?;
        let facts = Facts {
            n_nodes,
            n_elements,
            n_dofs,
            mass,
            zem_unstressed,
            unstressed_frequencies_hz: unstressed,
            penalty_error: self.compare(&mut reduced, &springs, &frequencies)?,
            penalty_frequencies_hz: frequencies,
            coupling_tolerance: self.settings.coupling_tolerance,
            carried,
        };
        let model = StructuralModel { reduced, facts };
        let stored = cache.map(|directory| {
            cache::store(directory, &key, &model.reduced, &model.facts)?;
            cache::store_modes(directory, &key, &modes)
        });
        if let Some(Err(error)) = stored {
            progress.note(&format!("the reduced model was not cached: {error}"));
        }
        progress.end(Stage::Reduce);
        Ok(model)
    }

    /// Refuses a reduced model that takes more memory than the run may, before any work is done for it.
    ///
    /// # Errors
    /// [`Error::Memory`].
    fn refuse_too_large(&self, memory: Option<u64>) -> Result<(), Error> {
        let needed = (MATRICES * size_of::<f64>()) as u64 * self.reduced_entries();
        match memory {
            Some(limit) if needed > limit => Err(Error::Memory {
                coordinates: self.reduced_coordinates(),
                needed,
                limit,
            }),
            _ => Ok(()),
        }
    }

    fn reduced_coordinates(&self) -> usize {
        3 * self.joint.interface.nodes.len() + self.settings.n_modes
    }

    /// Numbers that a matrix of the reduced model has; those of blocks are an estimate.
    pub fn reduced_entries(&self) -> u64 {
        match (&self.joint.bodies, self.settings.coupling_tolerance) {
            (
                Bodies::Meshed(MeshedBodies {
                    sides: Sides::Projected(parts),
                    ..
                }),
                Some(_),
            ) => {
                // A node unites two, and the core the last two.
                let nodes = std::iter::repeat_n(2 * EXPECTED_RANK, parts.len());
                let core = 2 * EXPECTED_RANK + self.settings.n_modes;
                let sizes = parts.iter().map(|part| 3 * part.own.len()).chain(nodes).chain([core]);
                sizes.map(|size| (size as u64).pow(2)).sum()
            }
            _ => (self.reduced_coordinates() as u64).pow(2),
        }
    }

    /// Factors of stiffness and mass, if the matrices of this structure are those of `known` times them, so that both are reduced by the same basis.
    pub fn multiple_of(&self, known: &Self) -> Option<[f64; 2]> {
        let (Bodies::Meshed(own), Bodies::Meshed(others)) = (&self.joint.bodies, &known.joint.bodies) else {
            return None;
        };
        let place = |bodies: &MeshedBodies| (bodies.response_node, bodies.response_direction);
        let is_same = place(own) == place(others)
            && own.excitations == others.excitations
            && own.sides == others.sides
            && self.joint.frame == known.joint.frame
            && self.joint.node_frames == known.joint.node_frames;
        let factors = own.assembly.multiple_of(&others.assembly).filter(|_| is_same)?;
        // The load of a moving base is of the mass, and not scaled with it.
        let is_carried = own
            .excitations
            .iter()
            .any(|excited| matches!(excited, Excited::Base(_)));
        (!is_carried || factors[1] == 1.0).then_some(factors)
    }

    /// The reduced model of a structure that differs little from that of `model`, over the same coordinates: modes in the same order, with the same
    /// signs.
    ///
    /// # Errors
    /// As [`Structure::reduce`]; [`reduction::Error::OtherModel`] for a structure with other coordinates.
    pub fn neighbour_of(&self, model: &ReducedModel, progress: &dyn Progress) -> Result<ReducedModel, Error> {
        progress.note("the structure is reduced again, for a derivative");
        let assembled = self.assemble()?;
        let settings = Settings {
            n_modes: model.n_modes(),
            mode_tolerance: NEIGHBOUR_TOLERANCE,
            coupling_tolerance: self
                .settings
                .coupling_tolerance
                .map(|tolerance| NEIGHBOUR_COUPLING * tolerance),
            ..self.settings
        };
        let stop = || progress.interrupted();
        let limits = Limits::default().until(&stop);
        let mut reduced = reduce(&assembled.relative, &assembled.rows, settings, limits)?;
        reduced.align_with(model)?;
        Ok(reduced)
    }

    /// The system in relative coordinates.
    pub(super) fn assemble(&self) -> Result<Assembled<'_>, Error> {
        self.assemble_until(&Silent)
    }

    fn assemble_until(&self, progress: &dyn Progress) -> Result<Assembled<'_>, Error> {
        let bodies = match &self.joint.bodies {
            Bodies::Imported(bodies) => return Ok(Assembled::imported(bodies)),
            Bodies::Meshed(bodies) => bodies,
        };
        let system = System::try_new(&bodies.assembly)?;
        go_on(progress)?;
        let relative = relative(&self.joint, &system, &bodies.sides)?;
        let meshed = Meshed { system, relative };
        let rows = meshed.rows(bodies)?;
        let Meshed { system, relative } = meshed;
        let along = |direction: &[f64; 3]| {
            bodies
                .response_direction
                .iter()
                .zip(direction)
                .map(|(a, b)| a * b)
                .sum()
        };
        let carried = bodies.excitations.iter().map(|excited| match excited {
            Excited::Force { .. } => None,
            Excited::Base(direction) => Some(along(direction)),
        });
        Ok(Assembled {
            carried: carried.collect(),
            relative: Cow::Owned(relative),
            rows,
            n_nodes: Some(bodies.assembly.mesh.nodes.len()),
            n_elements: Some(bodies.assembly.mesh.elements.len()),
            mass: Some(system.total_mass),
            n_untied_slaves: system.dofs.untied.len(),
            largest_adjustment: system.dofs.largest_adjustment,
        })
    }

    /// Largest error of the reduced model's frequencies, relative to those of the full one, after leaving out the modes that the wanted accuracy does not need.
    fn compare(&self, reduced: &mut ReducedModel, springs: &CsMat<f64>, full: &[f64]) -> Result<f64, Error> {
        let is_locked = self.locks;
        let vibrating = |reduced: &ReducedModel| match is_locked {
            true => checks::reduced_spectrum(&reduced.locked()?, springs, N_CHECKED),
            false => checks::reduced_spectrum(reduced, springs, N_CHECKED),
        };
        let error_of = |small: &ReducedSpectrum| {
            let errors = full.iter().zip(&small.frequencies).map(|(a, b)| (b / a - 1.0).abs());
            errors.fold(0.0, f64::max)
        };
        let small = vibrating(reduced)?;
        let mut error = error_of(&small);
        if let Some(target) = self.reduction_error {
            // Modes are left out of the model before it is locked.
            let without = match is_locked {
                true => checks::reduced_spectrum(reduced, springs, N_CHECKED)?.without_mode,
                false => small.without_mode,
            };
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
            if n_modes < without.len() {
                reduced.truncate(n_modes);
                error = error_of(&vibrating(reduced)?);
            }
        }
        Ok(error)
    }

    /// Hash of what the file of a reduced model depends on.
    pub(super) fn key(&self, build: Option<&str>) -> Key {
        let mut key = self.hash(build);
        // The springs of the spectrum check depend on these.
        key.text(&format!("{:?}{:?}", self.youngs_modulus, (N_CHECKED, CHECK_STIFFNESS)));
        let interface = &self.joint.interface;
        key.numbers(interface.nodes.iter().flatten().chain(&interface.heights).copied());
        key.text(&format!("{:?}{:?}", interface.elements, interface.covered));
        key.finish()
    }

    /// Hash of everything that the reduced matrices depend on.
    pub fn hash(&self, build: Option<&str>) -> KeyBuilder {
        let mut key = KeyBuilder::new(build);
        key.numbers(self.joint.frame.iter().flatten().copied());
        key.numbers(self.joint.node_frames.iter().flatten().flatten().copied());
        key.text(&format!("{:?}{:?}", self.settings, self.reduction_error));
        key.integers([u64::from(self.locks)]);
        match &self.joint.bodies {
            Bodies::Imported(bodies) => {
                // Fields by name, here and below, so that none is forgotten.
                let ImportedBodies {
                    relative,
                    response,
                    excitations,
                    dampers,
                    is_reduced,
                    zero_energy_modes,
                    mass,
                } = bodies;
                key.matrix(&relative.stiffness);
                key.matrix(&relative.mass);
                key.numbers(relative.loads.iter().flatten().chain(response).copied());
                for excited in excitations {
                    key.numbers(excited.row.iter().chain(&excited.carried).copied());
                }
                key.numbers(dampers.iter().flatten().copied());
                key.text(&format!(
                    "{:?}",
                    (relative.n_relative, is_reduced, zero_energy_modes, mass)
                ));
            }
            Bodies::Meshed(bodies) => {
                let MeshedBodies {
                    assembly,
                    sides,
                    response_node,
                    response_direction,
                    excitations,
                    moved_pairs: _,
                    raised: _,
                    rigid_motions,
                } = bodies;
                let Assembly {
                    mesh,
                    ties,
                    couplings,
                    shanks,
                    cuts,
                    rigid_masses,
                    equations,
                    supports,
                    springs,
                    masses,
                    loads,
                    superelements,
                } = assembly;
                key.numbers(mesh.nodes.iter().flatten().copied());
                key.integers(mesh.elements.iter().flat_map(|e| {
                    e.cell
                        .nodes()
                        .iter()
                        .map(|&n| u64::from(n))
                        .chain([u64::from(e.material), kind(&e.cell)])
                }));
                match sides {
                    Sides::Pairs { top, bottom } => key.integers(top.iter().chain(bottom).map(|&n| u64::from(n))),
                    Sides::Projected(parts) => {
                        for part in parts {
                            let nodes = part.own.iter().chain(&part.other);
                            key.integers(nodes.map(|&n| u64::from(n)).chain([u64::from(part.own_is_top)]));
                            key.matrix(&part.projection);
                        }
                    }
                }
                for body in superelements {
                    key.text(&format!("{:?}", (&body.coordinates, body.is_held)));
                    key.matrix(&body.stiffness);
                    key.matrix(&body.mass);
                }
                // Small parts, where a readable form costs nothing.
                key.text(&format!(
                    "{:?}",
                    (response_node, response_direction, excitations, rigid_motions)
                ));
                key.text(&format!(
                    "{:?}",
                    (&mesh.materials, ties, couplings, shanks, cuts, rigid_masses)
                ));
                key.text(&format!("{:?}", (equations, supports, springs, masses, loads)));
            }
        }
        key
    }
}

/// A system in relative coordinates, and what is known of it.
pub(super) struct Assembled<'a> {
    pub(super) relative: Cow<'a, RelativeSystem>,
    /// Quantities to recover: the response, then one for each excitation, then one for each damper.
    pub(super) rows: Vec<Vec<f64>>,
    /// Of excitations by moving supports, the displacement at the response point when everything moves with them by one.
    pub(super) carried: Vec<Option<f64>>,
    pub(super) n_nodes: Option<usize>,
    pub(super) n_elements: Option<usize>,
    pub(super) mass: Option<f64>,
    pub(super) n_untied_slaves: usize,
    pub(super) largest_adjustment: f64,
}

impl<'a> Assembled<'a> {
    /// Memory of its matrices (bytes).
    fn memory(&self) -> u64 {
        let entries = self.relative.stiffness.nnz() + self.relative.mass.nnz();
        (entries * (size_of::<f64>() + size_of::<usize>())) as u64
    }

    fn imported(bodies: &'a ImportedBodies) -> Self {
        Self {
            relative: Cow::Borrowed(&bodies.relative),
            rows: std::iter::once(&bodies.response)
                .chain(bodies.excitations.iter().map(|excited| &excited.row))
                .chain(&bodies.dampers)
                .cloned()
                .collect(),
            carried: bodies.excitations.iter().map(|excited| excited.carried).collect(),
            n_nodes: None,
            n_elements: None,
            mass: bodies.mass,
            n_untied_slaves: 0,
            largest_adjustment: 0.0,
        }
    }
}

/// Number of a cell's type and formulation, for keys.
fn kind(cell: &Cell) -> u64 {
    u64::from(cell.element_type().vtk.number) << 8 | cell.formulation() as u64
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
