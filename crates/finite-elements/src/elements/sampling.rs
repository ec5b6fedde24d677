//! Where the strains of an element are best, and how they are carried to its corners.

use super::cell::{Cell, ElementType, Formulation};
use super::hex8::{HEX8, incompatible_gradients, incompatible_motion};
use super::matrices::{Jacobian, Place};
use super::quadrature::{Point, TETRAHEDRON_4, hexahedron_8, hexahedron_27, tetrahedron_64, wedge_6, wedge_9};
use super::tet4::TET4;
use super::wedge6::WEDGE6;
use crate::Error;
use crate::material::Material;
use crate::mesh::Mesh;
use nalgebra::{DMatrix, Vector3};

/// Components of a strain: normal along x, y, z, then the engineering shears yz, xz, xy.
pub(crate) const COMPONENTS: usize = 6;

/// Where strains are, and what they are: [`COMPONENTS`] of each motion.
#[derive(Clone, Debug)]
pub(crate) struct Strains {
    pub(crate) at: [f64; 3],
    pub(crate) values: Vec<f64>,
}

/// Points of an element type for the recovery of strains.
#[derive(Debug)]
pub(crate) struct Samples {
    /// Natural coordinates at which strains are of a higher order than elsewhere: the centre of linear elements, the points of
    /// reduced integration of quadratic ones (Barlow 1976, DOI 10.1002/nme.1620100202) and of those that bend by incompatible modes.
    pub(crate) best: Vec<[f64; 3]>,
    /// From strains there to those at the corners: constant, or linear along each coordinate.
    to_corners: DMatrix<f64>,
    /// Quadrature for squares of differences of strains.
    pub(crate) integration: Vec<IntegrationPoint>,
}

/// A point of the quadrature.
#[derive(Debug)]
pub(crate) struct IntegrationPoint {
    pub(crate) at: [f64; 3],
    pub(crate) weight: f64,
    /// Values of the shape functions there.
    pub(crate) nodes: Vec<f64>,
    /// Values of the shape functions of the corners alone.
    pub(crate) corners: Vec<f64>,
}

impl Samples {
    pub(crate) fn of(row: &ElementType, formulation: Formulation) -> Self {
        let n_corners = row.n_nodes() - row.middles.len();
        let points = |points: &[Point]| points.iter().map(|point| point.at).collect::<Vec<_>>();
        let (linear, best, integration): (&ElementType, _, Vec<Point>) = match n_corners {
            8 => (&HEX8, points(&hexahedron_8()), hexahedron_27()),
            6 => (&WEDGE6, points(&wedge_6()), wedge_9()),
            _ => (&TET4, points(&TETRAHEDRON_4), tetrahedron_64()),
        };
        let bends = formulation == Formulation::IncompatibleModes;
        let (best, to_corners) = if row.middles.is_empty() && !bends {
            let sum = |c: usize| row.nodes.iter().map(|node| node[c]).sum::<f64>();
            let centre = [0, 1, 2].map(|c| sum(c) / n_corners as f64);
            (vec![centre], DMatrix::from_element(n_corners, 1, 1.0))
        } else {
            let values: Vec<Vec<f64>> = best.iter().map(|at| linear.shape_functions(*at).0).collect();
            let at_best = DMatrix::from_fn(best.len(), n_corners, |i, j| values[i][j]);
            let to_corners = at_best.try_inverse();
            // The points lie like the corners, nearer to the centre.
            (
                best,
                to_corners.unwrap_or_else(|| DMatrix::identity(n_corners, n_corners)),
            )
        };
        let integration = integration.into_iter().map(|point| IntegrationPoint {
            at: point.at,
            weight: point.weight,
            nodes: row.shape_functions(point.at).0,
            corners: linear.shape_functions(point.at).0,
        });
        Self {
            best,
            to_corners,
            integration: integration.collect(),
        }
    }

    /// Strains of several motions at the best points of an element.
    pub(crate) fn strains(
        &self,
        number: usize,
        cell: &Cell,
        mesh: &Mesh,
        material: &Material,
        motions: &[Vec<[f64; 3]>],
    ) -> Result<Vec<Strains>, Error> {
        let x: Vec<[f64; 3]> = cell.nodes().iter().map(|node| mesh.nodes[*node as usize]).collect();
        let place = Place {
            element: number,
            x: &x,
            material,
        };
        let row = cell.element_type();
        let incompatible = match cell.formulation() {
            Formulation::IncompatibleModes => {
                let centre = Jacobian::try_new(&place, 8, &row.shape_functions([0.0; 3]).1)?;
                let of_motion = |motion: &Vec<[f64; 3]>| {
                    let nodes = std::array::from_fn(|i| motion[cell.nodes()[i] as usize]);
                    incompatible_motion(&place, &nodes)
                };
                Some((centre, motions.iter().map(of_motion).collect::<Result<Vec<_>, _>>()?))
            }
            _ => None,
        };
        let at_point = |at: &[f64; 3]| {
            let (values, derivatives) = row.shape_functions(*at);
            let jacobian = Jacobian::try_new(&place, 0, &derivatives)?;
            let mut strains = vec![0.0; COMPONENTS * motions.len()];
            let mut position = [0.0; 3];
            for (local, (value, derivative)) in values.iter().zip(derivatives).enumerate() {
                (0..3).for_each(|c| position[c] += value * x[local][c]);
                let g = jacobian.gradient(derivative);
                let node = cell.nodes()[local] as usize;
                for (strain, motion) in strains.chunks_exact_mut(COMPONENTS).zip(motions) {
                    add_strain(strain, g, motion[node]);
                }
            }
            if let Some((centre, amplitudes)) = &incompatible {
                for (mode, g) in incompatible_gradients(centre, &jacobian, *at).into_iter().enumerate() {
                    for (strain, amplitudes) in strains.chunks_exact_mut(COMPONENTS).zip(amplitudes) {
                        add_strain(strain, g, amplitudes[mode]);
                    }
                }
            }
            Ok(Strains {
                at: position,
                values: strains,
            })
        };
        self.best.iter().map(at_point).collect()
    }

    /// Strains at the corners.
    pub(crate) fn at_corners(&self, best: &[Strains]) -> Vec<Vec<f64>> {
        let width = best.first().map_or(0, |strains| strains.values.len());
        let of_corner = |corner: usize| {
            let factors = self.to_corners.row(corner);
            let sum = |k: usize| factors.iter().zip(best).map(|(f, strains)| f * strains.values[k]).sum();
            (0..width).map(sum).collect()
        };
        (0..self.to_corners.nrows()).map(of_corner).collect()
    }
}

/// Adds the strain of a shape function with gradient `g` and displacement `u`.
fn add_strain(strain: &mut [f64], g: Vector3<f64>, u: [f64; 3]) {
    (0..3).for_each(|c| strain[c] += g[c] * u[c]);
    for (shear, [i, j]) in [[1, 2], [0, 2], [0, 1]].into_iter().enumerate() {
        strain[3 + shear] += g[i] * u[j] + g[j] * u[i];
    }
}

/// Determinant of the Jacobian at a point of an element.
pub(crate) fn determinant(
    number: usize,
    cell: &Cell,
    mesh: &Mesh,
    material: &Material,
    at: [f64; 3],
) -> Result<f64, Error> {
    let x: Vec<[f64; 3]> = cell.nodes().iter().map(|node| mesh.nodes[*node as usize]).collect();
    let place = Place {
        element: number,
        x: &x,
        material,
    };
    Ok(Jacobian::try_new(&place, 0, &cell.element_type().shape_functions(at).1)?.determinant)
}
