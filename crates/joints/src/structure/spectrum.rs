//! What a structure is, without reducing it: sizes, and frequencies with linear interfaces.

use super::{LinearInterface, Structure};
use crate::Error;
use crate::progress::{Progress, Stage, end_stage};
use joint_model::MovedPairs;
use joint_model::quadratic::RaisedElements;
use reduction::{Limits, RelativeSystem, checks};
use serde::Serialize;

/// Of a free body.
const RIGID_MOTIONS: usize = 6;

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
}
