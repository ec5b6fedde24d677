//! Uniform springs in the place of the scene's law, without friction or opening.

use super::Structure;
use crate::Error;
use joint_model::Bodies;
use reduction::RelativeSystem;
use serde::Serialize;
use sprs::{CsMat, TriMat};

/// Uniform stiffness of the spectrum check, as a multiple of Young's modulus per metre: of the order of a bolted
/// interface's contact stiffness.
pub(super) const CHECK_STIFFNESS: f64 = 50.0;

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

impl Structure {
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
