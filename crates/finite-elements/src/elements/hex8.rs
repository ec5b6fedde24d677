//! Eight-node hexahedron: 2 x 2 x 2 Gauss points, or the mean strain.

use super::cell::{Cell, ElementType, ForeignType, Formulation};
use super::face::QUAD4;
use super::matrices::{Jacobian, Matrices, Place, add_stiffness, add_volumetric};
use crate::Error;
use nalgebra::{SMatrix, SVector, Vector3};

/// Eight-node hexahedron.
pub static HEX8: ElementType = ElementType {
    name: "Hex8",
    description: "hexahedra of 8 nodes",
    nodes: &CORNERS,
    middles: &[],
    faces: &[
        (&QUAD4, &[0, 3, 2, 1]),
        (&QUAD4, &[4, 5, 6, 7]),
        (&QUAD4, &[0, 1, 5, 4]),
        (&QUAD4, &[1, 2, 6, 5]),
        (&QUAD4, &[2, 3, 7, 6]),
        (&QUAD4, &[3, 0, 4, 7]),
    ],
    formulations: &[
        (Formulation::IncompatibleModes, Some("C3D8I")),
        (Formulation::BBar, Some("C3D8")),
        (Formulation::Reduced, Some("C3D8R")),
        // Abaqus and CalculiX integrate no hexahedron fully without further measures.
        (Formulation::Full, None),
    ],
    gmsh: ForeignType::same_order(5),
    vtk: ForeignType::same_order(12),
    interpolation,
    matrices,
};

impl Cell {
    /// An eight-node hexahedron.
    pub fn hex8(nodes: [u32; 8], formulation: Formulation) -> Self {
        Self::from_row(&HEX8, formulation, &nodes)
    }
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

/// Stiffness against hourglass deformations relative to the shear modulus.
const HOURGLASS: f64 = 0.005;

fn interpolation(xi: [f64; 3], values: &mut [f64], derivatives: &mut [[f64; 3]]) {
    for (a, corner) in CORNERS.iter().enumerate() {
        let f = [0, 1, 2].map(|i| 0.5 * (1.0 + corner[i] * xi[i]));
        values[a] = f[0] * f[1] * f[2];
        derivatives[a] = [
            0.5 * corner[0] * f[1] * f[2],
            0.5 * corner[1] * f[0] * f[2],
            0.5 * corner[2] * f[0] * f[1],
        ];
    }
}

fn matrices(place: &Place<'_>, formulation: Formulation) -> Result<Matrices, Error> {
    let material = place.material;
    let mut out = Matrices::zeros(8);
    let [lambda, mu] = material.lame();
    let bulk = lambda + 2.0 / 3.0 * mu;
    let (mut values, mut derivatives) = ([0.0; 8], [[0.0; 3]; 8]);
    interpolation([0.0; 3], &mut values, &mut derivatives);
    // An element that is inverted at its centre is refused in every formulation.
    Jacobian::try_new(place, 8, &derivatives)?;
    let (mut volume, mut mean) = (0.0, [Vector3::zeros(); 8]);
    let gauss = 1.0 / 3.0_f64.sqrt();
    for (point, corner) in CORNERS.iter().enumerate() {
        let xi = corner.map(|sign| sign * gauss);
        interpolation(xi, &mut values, &mut derivatives);
        let jacobian = Jacobian::try_new(place, point, &derivatives)?;
        let weight = jacobian.determinant;
        out.add_mass(&values, material.density * weight);
        let g = derivatives.map(|d| jacobian.gradient(d));
        volume += weight;
        for (mean, g) in mean.iter_mut().zip(&g) {
            *mean += g * weight;
        }
        match formulation {
            Formulation::Full => add_stiffness(&mut out.stiffness, &g, [lambda, mu], weight),
            // What is left without the volumetric strain.
            Formulation::BBar => add_stiffness(&mut out.stiffness, &g, [lambda - bulk, mu], weight),
            Formulation::Reduced | Formulation::IncompatibleModes => {}
        }
    }
    for mean in &mut mean {
        *mean /= volume;
    }
    match formulation {
        Formulation::Full => {}
        Formulation::BBar => add_volumetric(&mut out.stiffness, &mean, bulk * volume),
        Formulation::Reduced => {
            add_stiffness(&mut out.stiffness, &mean, [lambda, mu], volume);
            add_hourglass(&mut out.stiffness, place.x, &mean, HOURGLASS * mu * volume);
            out.lump();
        }
        Formulation::IncompatibleModes => condense(&with_incompatible_modes(place)?, &mut out.stiffness),
    }
    Ok(out)
}

/// Gradients of the incompatible modes `1 - xi_m^2`.
pub(super) fn incompatible_gradients(centre: &Jacobian, here: &Jacobian, xi: [f64; 3]) -> [Vector3<f64>; 3] {
    [0, 1, 2].map(|m| centre.inverse.column(m) * (-2.0 * xi[m] * centre.determinant / here.determinant))
}

/// Stiffness over the nodes and, behind them like three more nodes, the incompatible modes.
fn with_incompatible_modes(place: &Place<'_>) -> Result<SMatrix<f64, 33, 33>, Error> {
    let mut extended = vec![0.0; 33 * 33];
    let (mut values, mut derivatives) = ([0.0; 8], [[0.0; 3]; 8]);
    interpolation([0.0; 3], &mut values, &mut derivatives);
    let centre = Jacobian::try_new(place, 8, &derivatives)?;
    let gauss = 1.0 / 3.0_f64.sqrt();
    for (point, corner) in CORNERS.iter().enumerate() {
        let xi = corner.map(|sign| sign * gauss);
        interpolation(xi, &mut values, &mut derivatives);
        let jacobian = Jacobian::try_new(place, point, &derivatives)?;
        let g = derivatives.map(|d| jacobian.gradient(d));
        let modes = incompatible_gradients(&centre, &jacobian, xi);
        let all: Vec<_> = g.into_iter().chain(modes).collect();
        add_stiffness(&mut extended, &all, place.material.lame(), jacobian.determinant);
    }
    Ok(SMatrix::from_row_slice(&extended))
}

/// Amplitudes of the incompatible modes, three components of each, for displacements of the nodes.
pub(super) fn incompatible_motion(place: &Place<'_>, nodes: &[[f64; 3]; 8]) -> Result<[[f64; 3]; 3], Error> {
    let all = with_incompatible_modes(place)?;
    let forces = all.fixed_view::<9, 24>(24, 0) * SVector::<f64, 24>::from_iterator(nodes.iter().flatten().copied());
    // Positive definite for any admissible material and positive Jacobian.
    let own = all.fixed_view::<9, 9>(24, 24).into_owned().cholesky();
    let found = own.map_or_else(SVector::zeros, |own| -own.solve(&forces));
    Ok([0, 1, 2].map(|m| [0, 1, 2].map(|c| found[3 * m + c])))
}

/// Eliminates the incompatible modes, on which no force acts.
fn condense(all: &SMatrix<f64, 33, 33>, stiffness: &mut [f64]) {
    let coupling = all.fixed_view::<24, 9>(0, 24);
    let mut condensed: SMatrix<f64, 24, 24> = all.fixed_view::<24, 24>(0, 0).into_owned();
    // Positive definite for any admissible material and positive Jacobian.
    if let Some(cholesky) = all.fixed_view::<9, 9>(24, 24).into_owned().cholesky() {
        condensed -= coupling * cholesky.solve(&coupling.transpose());
    }
    for (i, row) in stiffness.chunks_exact_mut(24).enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = 0.5 * (condensed[(i, j)] + condensed[(j, i)]);
        }
    }
}

/// Adds `scale (b : b) gamma gamma^T` for each of the four hourglass vectors and each direction, `b` the mean gradients.
///
/// The vectors are made orthogonal to linear fields, `gamma = h - sum (h . x_i) b_i`, so that neither rotation nor constant
/// strain meets any resistance.
fn add_hourglass(stiffness: &mut [f64], x: &[[f64; 3]], mean: &[Vector3<f64>; 8], scale: f64) {
    let products: [fn([f64; 3]) -> f64; 4] = [
        |[_, s, t]| s * t,
        |[r, _, t]| r * t,
        |[r, s, _]| r * s,
        |[r, s, t]| r * s * t,
    ];
    let size: f64 = mean.iter().map(Vector3::norm_squared).sum();
    for product in products {
        let mut gamma = CORNERS.map(product);
        let along: Vector3<f64> = gamma.iter().zip(x).map(|(h, x)| Vector3::from(*x) * *h).sum();
        for (gamma, b) in gamma.iter_mut().zip(mean) {
            *gamma -= along.dot(b);
        }
        for (a, ga) in gamma.iter().enumerate() {
            for (b, gb) in gamma.iter().enumerate() {
                for i in 0..3 {
                    stiffness[(3 * a + i) * 24 + 3 * b + i] += scale * size * ga * gb;
                }
            }
        }
    }
}
