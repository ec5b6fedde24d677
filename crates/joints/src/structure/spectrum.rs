//! What a structure is, without reducing it: sizes, and frequencies with linear interfaces.

use super::Structure;
use crate::Error;
use crate::progress::{Progress, Stage, end_stage};
use joint_model::quadratic::RaisedElements;
use joint_model::{Bodies, MovedPairs};
use reduction::{Limits, RelativeSystem, checks};
use serde::Serialize;
use sprs::{CsMat, TriMat};

/// Uniform stiffness of the spectrum check, as a multiple of Young's modulus per metre: of the order of a bolted
/// interface's contact stiffness.
pub(super) const CHECK_STIFFNESS: f64 = 50.0;

/// Of a free body.
const RIGID_MOTIONS: usize = 6;
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
    /// Pairs of interface nodes that were moved; none where all nodes coincide in pairs.
    pub moved_pairs: Option<MovedPairs>,
    /// Linear elements of a deck that were made quadratic; none where the elements have the order that they were meshed in.
    pub raised: Option<RaisedElements>,
    /// Where asked for.
    pub spectrum: Option<Spectrum>,
}

impl Structure {
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
        end_stage(progress, Stage::Assemble)?;
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
            interface_area: self.symmetry.operators(&self.joint.interface, 2)?.area(),
            n_untied_slaves: assembled.n_untied_slaves,
            largest_adjustment: assembled.largest_adjustment,
            moved_pairs: self.joint.moved_pairs(),
            raised: self.joint.raised(),
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
        let (zero_energy_modes, frequencies) = checks::full_frequencies(
            &assembled.relative,
            Some(&springs),
            count + RIGID_MOTIONS,
            tolerance,
            Limits::default(),
        )?;
        // Springs to the ground make modes of rigid motions.
        let rigid = RIGID_MOTIONS.saturating_sub(zero_energy_modes);
        Ok(Frequencies {
            zero_energy_modes,
            frequencies_hz: frequencies.into_iter().skip(rigid).take(count).collect(),
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
        let stop = || progress.interrupted();
        let limits = Limits::default().until(&stop);
        let modes = |(zero_energy_modes, frequencies_hz)| Frequencies {
            zero_energy_modes,
            frequencies_hz,
        };
        let unstressed = modes(checks::full_frequencies(relative, None, count, tolerance, limits)?);
        progress.fraction(Stage::Factor, 0.33);
        let stuck = modes(checks::stuck_frequencies(relative, count, tolerance, limits)?);
        progress.fraction(Stage::Factor, 0.67);
        let springs = self.springs(linear, |_| true)?;
        let with_linear = modes(checks::full_frequencies(
            relative,
            Some(&springs),
            count,
            tolerance,
            limits,
        )?);
        progress.end(Stage::Factor);
        Ok(Spectrum {
            unstressed,
            stuck,
            linear,
            with_linear,
        })
    }

    /// Stiffness of a linear interface over the jump coordinates (N/m).
    pub(super) fn springs(&self, linear: LinearInterface, closed: impl Fn(usize) -> bool) -> Result<CsMat<f64>, Error> {
        let operators = self
            .symmetry
            .operators(&self.joint.interface, linear.points_per_direction)?;
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
    pub(super) fn check_interface(&self) -> LinearInterface {
        let stiffness = match &self.joint.bodies {
            Bodies::Imported(bodies) if self.joint.interface.is_of_points() || self.youngs_modulus.is_none() => {
                let areas = self.joint.interface.areas().iter().sum::<f64>();
                mean_stiffness(&bodies.relative) / areas * self.joint.interface.elements.len() as f64
            }
            Bodies::Imported(_) => CHECK_STIFFNESS * self.youngs_modulus.unwrap_or(f64::NAN),
            Bodies::Meshed(bodies) => {
                let largest = |materials: &[finite_elements::mesh::Material]| {
                    materials.iter().map(|own| own.youngs_modulus).fold(0.0, f64::max)
                };
                CHECK_STIFFNESS
                    * self
                        .youngs_modulus
                        .unwrap_or_else(|| largest(&bodies.assembly.mesh.materials))
            }
        };
        LinearInterface {
            normal_stiffness: stiffness,
            tangential_stiffness: stiffness,
            points_per_direction: 2,
        }
    }
}

/// Mean stiffness of a coordinate of the jump (N/m), to which the contact at a point is compared: its area, unlike that of
/// faces, says nothing of the size of the bodies.
fn mean_stiffness(relative: &RelativeSystem) -> f64 {
    let own = (0..relative.n_relative).filter_map(|i| relative.stiffness.get(i, i).copied());
    let mean = own.sum::<f64>() / relative.n_relative as f64;
    // Masses that contact alone holds have no stiffness at all.
    if mean > 0.0 { mean } else { 1.0 }
}
