//! A reduced structure, and what is known of the full one behind it.

use reduction::ReducedModel;
use serde::{Deserialize, Serialize};

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
    /// What may be left out of the coupling between interfaces, relative to the largest; none of dense matrices.
    #[serde(default)]
    pub coupling_tolerance: Option<f64>,
    /// For each excitation, whose recovery rows follow that of the response: of moving supports, the displacement at the response point when everything
    /// moves with them by one; none of a force.
    #[serde(default)]
    pub carried: Vec<Option<f64>>,
}

/// A reduced structure.
#[derive(Clone, Debug)]
pub struct StructuralModel {
    /// Matrices; load `i` is unit tension of bolt `i`, recovery row 0 the response displacement, the last ones those of the dampers. With attachment modes
    /// of the loads if the bolts lock; they are not locked yet.
    pub reduced: ReducedModel,
    /// What is known of the full model.
    pub facts: Facts,
}

impl StructuralModel {
    /// That of a structure whose stiffness and mass are these `factors` times its own ([`Structure::multiple_of`](super::Structure::multiple_of)). What is
    /// known of the full model beside its mass is not carried over.
    pub fn scaled(&self, [stiffness, mass]: [f64; 2]) -> Self {
        let (reduced, facts) = (&self.reduced, &self.facts);
        Self {
            reduced: ReducedModel {
                stiffness: reduced.stiffness.scaled(stiffness),
                mass: reduced.mass.scaled(mass),
                ..reduced.clone()
            },
            facts: Facts {
                mass: facts.mass.map(|own| mass * own),
                unstressed_frequencies_hz: Vec::new(),
                penalty_frequencies_hz: Vec::new(),
                penalty_error: f64::NAN,
                ..facts.clone()
            },
        }
    }

    /// First of the recovery rows that are viscous dampers.
    pub(super) fn first_damper(&self) -> usize {
        1 + self.facts.carried.len()
    }

    /// Rows of the viscous dampers over the coordinates of the structure that vibrates, which is this one, perhaps with locked bolts.
    pub fn dampers(&self, vibrating: &ReducedModel) -> Vec<Vec<f64>> {
        (self.first_damper()..vibrating.recovery.nrows())
            .map(|number| vibrating.recovery.row(number).iter().copied().collect())
            .collect()
    }
}
