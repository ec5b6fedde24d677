//! Eight-node hexahedron: stiffness and mass of one element.
//!
//! The default formulation adds the three incompatible bending modes of Taylor, Beresford and Wilson (1976,
//! DOI 10.1002/nme.1620100602) to the trilinear displacement field. Their gradients are taken with the Jacobian of
//! the element's centre, scaled by `det J0 / det J`, so that the patch test is passed on distorted elements.

use crate::Error;
use crate::mesh::Material;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Stiffness of one element, node-major order `3 node + component` (N/m).
pub type Stiffness = SMatrix<f64, 24, 24>;
/// Consistent mass of one element, the same for all three components (kg).
pub type NodalMass = SMatrix<f64, 8, 8>;

/// How the strain of an element is formed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formulation {
    /// Incompatible modes (`C3D8I`): bends without shear locking.
    #[default]
    IncompatibleModes,
    /// Full integration of the trilinear field (`C3D8`): locks in bending; kept for comparison.
    Full,
}

/// Natural coordinates of the eight nodes.
pub const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Shape functions and their natural derivatives (`8 x 3`) at a point of the reference cube.
fn shape(xi: [f64; 3]) -> (SMatrix<f64, 8, 1>, SMatrix<f64, 8, 3>) {
    let mut value = SMatrix::<f64, 8, 1>::zeros();
    let mut derivative = SMatrix::<f64, 8, 3>::zeros();
    for (a, corner) in CORNERS.iter().enumerate() {
        let f = [0, 1, 2].map(|i| 0.5 * (1.0 + corner[i] * xi[i]));
        value[a] = f[0] * f[1] * f[2];
        derivative[(a, 0)] = 0.5 * corner[0] * f[1] * f[2];
        derivative[(a, 1)] = 0.5 * corner[1] * f[0] * f[2];
        derivative[(a, 2)] = 0.5 * corner[2] * f[0] * f[1];
    }
    (value, derivative)
}

/// Rows of the strain operator (engineering shear: xy, yz, zx) for a field whose gradient is `g`.
fn strain_columns(g: Vector3<f64>) -> SMatrix<f64, 6, 3> {
    SMatrix::<f64, 6, 3>::from_row_slice(&[
        g.x, 0.0, 0.0, //
        0.0, g.y, 0.0, //
        0.0, 0.0, g.z, //
        g.y, g.x, 0.0, //
        0.0, g.z, g.y, //
        g.z, 0.0, g.x,
    ])
}

/// Isotropic elasticity matrix (engineering shear strains) (Pa).
fn elasticity(material: &Material) -> SMatrix<f64, 6, 6> {
    let (e, nu) = (material.youngs_modulus, material.poisson_ratio);
    let shear = e / (2.0 * (1.0 + nu));
    let lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let mut d = SMatrix::<f64, 6, 6>::zeros();
    for i in 0..3 {
        for j in 0..3 {
            d[(i, j)] = lambda;
        }
        d[(i, i)] += 2.0 * shear;
        d[(i + 3, i + 3)] = shear;
    }
    d
}

/// Stiffness and consistent nodal mass by 2 x 2 x 2 Gauss points.
///
/// `coordinates` are the eight nodes (m); `element` is used in messages only.
///
/// # Errors
/// [`Error::InvertedElement`] if the Jacobian is not positive at an integration point or at the centre.
pub fn matrices(
    element: usize,
    coordinates: &[[f64; 3]; 8],
    material: &Material,
    formulation: Formulation,
) -> Result<(Stiffness, NodalMass), Error> {
    let x = SMatrix::<f64, 8, 3>::from_fn(|a, i| coordinates[a][i]);
    let d = elasticity(material);
    let jacobian = |derivative: &SMatrix<f64, 8, 3>| -> Matrix3<f64> { derivative.transpose() * x };
    let inverse = |j: Matrix3<f64>, point: usize| {
        let determinant = j.determinant();
        match j.try_inverse() {
            Some(inverse) if determinant > 0.0 => Ok((determinant, inverse)),
            _ => Err(Error::InvertedElement {
                element,
                point,
                determinant,
            }),
        }
    };
    let (det0, inverse0) = inverse(jacobian(&shape([0.0; 3]).1), 8)?;
    let mut kuu = Stiffness::zeros();
    let mut kua = SMatrix::<f64, 24, 9>::zeros();
    let mut kaa = SMatrix::<f64, 9, 9>::zeros();
    let mut mass = NodalMass::zeros();
    let gauss = 1.0 / 3.0_f64.sqrt();
    for (point, corner) in CORNERS.iter().enumerate() {
        let xi = corner.map(|sign| sign * gauss);
        let (n, derivative) = shape(xi);
        let (determinant, inverse_j) = inverse(jacobian(&derivative), point)?;
        mass += n * n.transpose() * (material.density * determinant);
        let gradient = derivative * inverse_j.transpose();
        let mut b = SMatrix::<f64, 6, 24>::zeros();
        for a in 0..8 {
            b.fixed_view_mut::<6, 3>(0, 3 * a)
                .copy_from(&strain_columns(gradient.row(a).transpose()));
        }
        let db = d * b * determinant;
        kuu += b.transpose() * db;
        if formulation == Formulation::IncompatibleModes {
            let mut g = SMatrix::<f64, 6, 9>::zeros();
            for mode in 0..3 {
                // Gradient of 1 - xi_m^2.
                let natural = -2.0 * xi[mode];
                let gradient = inverse0.column(mode) * (natural * det0 / determinant);
                g.fixed_view_mut::<6, 3>(0, 3 * mode)
                    .copy_from(&strain_columns(gradient));
            }
            kua += db.transpose() * g;
            kaa += g.transpose() * d * g * determinant;
        }
    }
    if formulation == Formulation::IncompatibleModes {
        // kaa is positive definite for any admissible material and positive Jacobian.
        if let Some(cholesky) = kaa.cholesky() {
            kuu -= kua * cholesky.solve(&kua.transpose());
        }
    }
    Ok(((kuu + kuu.transpose()) * 0.5, mass))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steel() -> Material {
        Material {
            name: "steel".into(),
            youngs_modulus: 192.85e9,
            poisson_ratio: 0.29,
            density: 7857.8,
        }
    }

    fn distorted() -> [[f64; 3]; 8] {
        let jitter = [
            [0.1, -0.05, 0.02],
            [-0.08, 0.1, 0.05],
            [0.03, 0.12, -0.1],
            [-0.1, -0.02, 0.09],
            [0.07, 0.05, 0.1],
            [0.02, -0.1, -0.06],
            [-0.12, 0.04, 0.08],
            [0.05, 0.09, -0.03],
        ];
        std::array::from_fn(|a| std::array::from_fn(|i| 1e-3 * (0.5 * CORNERS[a][i] * (i + 1) as f64 + jitter[a][i])))
    }

    #[test]
    fn rigid_motion_costs_no_energy_and_nothing_else_is_free() {
        let x = distorted();
        for formulation in [Formulation::IncompatibleModes, Formulation::Full] {
            let (k, _) = matrices(0, &x, &steel(), formulation).unwrap();
            let eigen = k.symmetric_eigen().eigenvalues;
            let largest = eigen.max();
            let zero = eigen.iter().filter(|v| v.abs() < 1e-11 * largest).count();
            assert_eq!(zero, 6, "{formulation:?}: {eigen}");
            assert!(eigen.min() > -1e-12 * largest);
        }
    }

    #[test]
    fn constant_strain_is_exact_on_a_distorted_element() {
        // A linear field must cost its exact energy and produce no force from the incompatible modes.
        let x = distorted();
        let material = steel();
        let (k, m) = matrices(0, &x, &material, Formulation::IncompatibleModes).unwrap();
        let volume = m.sum() / material.density;
        let h = [[1e-3, 2e-4, -3e-4], [5e-4, -7e-4, 1e-4], [2e-4, 6e-4, 4e-4]];
        let u = SMatrix::<f64, 24, 1>::from_fn(|r, _| (0..3).map(|j| h[r % 3][j] * x[r / 3][j]).sum());
        let strain = SMatrix::<f64, 6, 1>::from_column_slice(&[
            h[0][0],
            h[1][1],
            h[2][2],
            h[0][1] + h[1][0],
            h[1][2] + h[2][1],
            h[2][0] + h[0][2],
        ]);
        let exact = (strain.transpose() * elasticity(&material) * strain)[0] * volume;
        let energy = (u.transpose() * k * u)[0];
        assert!((energy / exact - 1.0).abs() < 1e-12, "{energy} {exact}");
    }

    #[test]
    fn inverted_element_is_refused() {
        let mut x = distorted();
        x.swap(0, 1);
        assert!(matches!(
            matrices(7, &x, &steel(), Formulation::Full),
            Err(Error::InvertedElement { element: 7, .. })
        ));
    }
}
