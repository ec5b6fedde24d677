//! Interpolation `Q` from nodes to quadrature points and integration `T = (W Q)^T` back (eq. 5).

use crate::Error;
use crate::element_sums::ShapeValues;
use crate::mesh::{Element, InterfaceMesh};
use crate::mortar::natural;
use crate::quadrature::Quadrature;
use crate::shape::{MAX_NODES, SHAPES, Shape};
use sprs::{CsMat, TriMat};
use std::ops::Range;

/// Everything geometric about an interface and its quadrature.
///
/// `Q` and `T` are for use outside; [`crate::Interface`] applies the same two maps element by element.
///
/// Equation (5) of the paper prints `T D Q^T` for the tangent; the dimensions require `T D Q`.
#[derive(Clone, Debug)]
pub struct Operators {
    /// `Q`, `n_points x n_nodes`, rows sum to one.
    pub interpolation: CsMat<f64>,
    /// `T`, `n_nodes x n_points` (m^2).
    pub integration: CsMat<f64>,
    /// Area that each point stands for (m^2).
    pub weights: Vec<f64>,
    /// Position of each point (x, y) (m).
    pub positions: Vec<[f64; 2]>,
    /// First point of each element, and the number of points at the end.
    pub first_point: Vec<usize>,
    elements: Vec<Element>,
    /// Coordinates, of three per node, that are held at zero.
    held: Vec<usize>,
    /// Of each element its row in `shapes`.
    shape_of: Vec<u32>,
    /// In the order of the table of shapes, then of the elements that are faced in part.
    shapes: Vec<ShapeValues>,
}

impl Operators {
    /// From the first to the last node that points in a range have a share in.
    pub fn nodes_of(&self, points: Range<usize>) -> Range<usize> {
        let rows = points.filter_map(|point| self.interpolation.outer_view(point));
        // Columns ascend.
        let ends = rows.filter_map(|row| Some([*row.indices().first()?, *row.indices().last()?]));
        let both = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        both.map_or(0..0, |[first, last]| first..last + 1)
    }

    /// Quadrature points run element by element. A point of contact has one, whatever `points_per_direction` is, with its area as
    /// weight. An element that is faced in part has that part's area, centre and second moments.
    ///
    /// With two points per direction the quadratic shapes have fewer points than nodes: an element by itself then has jumps
    /// that meet no traction. Three are as many as nodes or more.
    ///
    /// # Errors
    /// Invalid meshes, inverted elements, unsupported quadratures.
    pub fn try_new(mesh: &InterfaceMesh, points_per_direction: usize) -> Result<Self, Error> {
        mesh.validate()?;
        let quadrature = Quadrature::try_new(points_per_direction)?;
        let mut shapes = SHAPES.map(|shape| ShapeValues::new(&quadrature, shape)).to_vec();
        let mut shape_of: Vec<u32> = mesh.elements.iter().map(row).collect();
        let whole = |shape: &'static Shape| quadrature.points(shape).iter().map(|point| (point.xi, point.weight));
        // The rule of each element: natural coordinates, and weights over the natural area.
        let mut rules: Vec<Vec<([f64; 2], f64)>> = mesh
            .elements
            .iter()
            .map(|element| whole(element.shape()).collect())
            .collect();
        for part in &mesh.covered {
            let element = &mesh.elements[part.element];
            let rule = part.rule(quadrature.line());
            let places = rule.iter().map(|&(at, _)| natural(mesh, part.element, at));
            let places = places.collect::<Result<Vec<_>, _>>()?;
            let area = part.share * mesh.area_in_plane(element);
            let weights = places.iter().zip(&rule).map(|(&xi, &(_, share))| {
                let (_, derivatives) = element.shape().functions(xi);
                (xi, share * area / mesh.area_density(element, &derivatives).0)
            });
            shape_of[part.element] = shapes.len() as u32;
            shapes.push(ShapeValues::at(element.shape(), places.iter().copied()));
            rules[part.element] = weights.collect();
        }
        let n_points = rules.iter().map(Vec::len).sum();
        let size = (n_points, mesh.nodes.len());
        let mut interpolation = TriMat::with_capacity(size, MAX_NODES * n_points);
        let mut integration = TriMat::with_capacity((size.1, size.0), MAX_NODES * n_points);
        let mut weights = Vec::with_capacity(n_points);
        let mut positions = Vec::with_capacity(n_points);
        let mut first_point = Vec::with_capacity(mesh.elements.len() + 1);
        for (index, (element, rule)) in mesh.elements.iter().zip(rules).enumerate() {
            first_point.push(weights.len());
            for (local, (xi, natural_weight)) in rule.into_iter().enumerate() {
                let (values, derivatives) = element.shape().functions(xi);
                let mut position = [0.0; 2];
                for (value, &node) in values.iter().zip(element.nodes()) {
                    let x = mesh.nodes[node as usize];
                    (0..2).for_each(|i| position[i] += value * x[i]);
                }
                let (determinant, density) = match element.contact() {
                    Some(contact) => (contact.area, contact.area),
                    None => mesh.area_density(element, &derivatives),
                };
                // `!(a > b)` also catches NaN.
                if !(determinant > 0.0) {
                    return Err(Error::Inverted {
                        element: index,
                        point: local,
                        determinant,
                    });
                }
                let weight = natural_weight * density;
                for (a, &node) in element.nodes().iter().enumerate() {
                    interpolation.add_triplet(weights.len(), node as usize, values[a]);
                    integration.add_triplet(node as usize, weights.len(), weight * values[a]);
                }
                weights.push(weight);
                positions.push(position);
            }
        }
        first_point.push(weights.len());
        Ok(Self {
            interpolation: interpolation.to_csr(),
            integration: integration.to_csr(),
            weights,
            positions,
            first_point,
            elements: mesh.elements.clone(),
            held: mesh.held(),
            shape_of,
            shapes,
        })
    }

    /// The interface whose half `y >= 0` is `mesh` and whose other half is the mirror image, in motions that are symmetric
    /// too: every point stands for its image as well, and the jump along y of nodes on the line `y = 0` is zero and
    /// takes no force.
    ///
    /// # Errors
    /// As [`Operators::try_new`]; [`Error::Value`] for a node beyond the line, and where none is on it.
    pub fn try_new_mirrored(mesh: &InterfaceMesh, points_per_direction: usize) -> Result<Self, Error> {
        let mut operators = Self::try_new(mesh, points_per_direction)?;
        let ys = || mesh.nodes.iter().map(|x| x[1]);
        let least = ys().enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, value)) = least.filter(|(_, y)| *y != 0.0) {
            return Err(Error::Value {
                quantity: "least y",
                place: "interface node",
                index,
                value,
                requirement: "0, on the line of symmetry of the half that is meshed",
            });
        }
        operators.weights.iter_mut().for_each(|w| *w *= 2.0);
        operators.integration.scale(2.0);
        let on_line = ys().enumerate().filter(|(_, y)| *y == 0.0);
        operators.held.extend(on_line.map(|(node, _)| 3 * node + 1));
        operators.held.sort_unstable();
        operators.held.dedup();
        Ok(operators)
    }

    /// Coordinates (3 node + component), ascending, whose jump is zero and takes no force: by symmetry, or because the structure
    /// has no such coordinate at a point of contact.
    pub fn held(&self) -> &[usize] {
        &self.held
    }

    /// Nodes, points and shape functions of each element.
    pub(crate) fn elements(&self) -> impl Iterator<Item = (&[u32], Range<usize>, &ShapeValues)> {
        let points = self.first_point.windows(2).map(|ends| ends[0]..ends[1]);
        let elements = self.elements.iter().zip(&self.shape_of).zip(points);
        elements.map(|((element, &row), points)| (element.nodes(), points, &self.shapes[row as usize]))
    }

    /// Number of quadrature points.
    pub fn n_points(&self) -> usize {
        self.weights.len()
    }

    /// Number of interface nodes.
    pub fn n_nodes(&self) -> usize {
        self.integration.rows()
    }

    /// Number of elements.
    pub fn n_elements(&self) -> usize {
        self.first_point.len() - 1
    }

    /// Area of the interface (m^2).
    pub fn area(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// Where a uniform traction acts on each node: the mean place of the points, weighted with the node's shape function (x, y) (m).
    pub fn places(&self) -> Vec<[f64; 2]> {
        let place = |node: usize| {
            let shares = self.integration.outer_view(node);
            let (mut sum, mut moment) = (0.0, [0.0; 2]);
            for (point, share) in shares.iter().flat_map(|row| row.iter()) {
                sum += share;
                (0..2).for_each(|c| moment[c] += share * self.positions[point][c]);
            }
            moment.map(|moment| moment / sum)
        };
        (0..self.integration.rows()).map(place).collect()
    }

    /// Area-weighted mean over each element of a field given at the points.
    ///
    /// # Panics
    /// If the field does not have one value per point.
    pub fn element_means(&self, field: &[f64]) -> Vec<f64> {
        assert_eq!(field.len(), self.n_points());
        (0..self.n_elements())
            .map(|element| self.element_mean(element, field))
            .collect()
    }

    /// Area-weighted mean over one element of a field given at the points.
    ///
    /// # Panics
    /// If there is no such element, or the field ends before its points.
    pub fn element_mean(&self, element: usize, field: &[f64]) -> f64 {
        let points = self.first_point[element]..self.first_point[element + 1];
        let integral: f64 = points.map(|p| self.weights[p] * field[p]).sum();
        integral / self.element_area(element)
    }

    /// Area of an element (m^2).
    ///
    /// # Panics
    /// If there is no such element.
    pub fn element_area(&self, element: usize) -> f64 {
        self.weights[self.first_point[element]..self.first_point[element + 1]]
            .iter()
            .sum()
    }

    /// The point of each element that is closest to its centre of area: the centre itself where the rule has a point there.
    pub fn central_points(&self) -> Vec<usize> {
        let [x, y] = [0, 1].map(|axis| {
            let coordinate: Vec<f64> = self.positions.iter().map(|p| p[axis]).collect();
            self.element_means(&coordinate)
        });
        let distance = |e: usize, p: usize| {
            let [px, py] = self.positions[p];
            (px - x[e]).hypot(py - y[e])
        };
        let closest = |(e, range): (usize, &[usize])| {
            let by_distance = |a: &usize, b: &usize| distance(e, *a).total_cmp(&distance(e, *b));
            (range[0]..range[1]).min_by(by_distance).unwrap_or(range[0])
        };
        self.first_point.windows(2).enumerate().map(closest).collect()
    }

    /// Nodal values whose interpolation comes closest, in the mean square over the area, to a field given at the points:
    /// `x` of `T Q x = T f`. Where the field is steep, such as at the edge of contact, they overshoot it.
    ///
    /// The values are unique where the elements have as many points as nodes or more; with fewer, they are the smallest
    /// correction of zero that conjugate gradients find.
    ///
    /// # Panics
    /// If the field does not have one value per point.
    pub fn nodal_least_squares(&self, field: &[f64]) -> Vec<f64> {
        assert_eq!(field.len(), self.n_points());
        let gram: CsMat<f64> = &self.integration * &self.interpolation;
        let mut residual = product(&self.integration, field);
        let diagonal: Vec<f64> = (0..gram.rows())
            .map(|i| gram.get(i, i).copied().unwrap_or(1.0))
            .collect();
        let scaled = |r: &[f64]| r.iter().zip(&diagonal).map(|(r, d)| r / d).collect::<Vec<f64>>();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut values = vec![0.0; residual.len()];
        let mut direction = scaled(&residual);
        let mut size = dot(&residual, &direction);
        let target = LEAST_SQUARES_TOLERANCE * LEAST_SQUARES_TOLERANCE * size;
        // Scaled by its diagonal the matrix has a condition number of about ten, whatever the mesh.
        for _ in 0..1000 {
            if size <= target {
                break;
            }
            let image = product(&gram, &direction);
            let step = size / dot(&direction, &image);
            values.iter_mut().zip(&direction).for_each(|(x, d)| *x += step * d);
            residual.iter_mut().zip(&image).for_each(|(r, a)| *r -= step * a);
            let next = scaled(&residual);
            let grown = dot(&residual, &next);
            let ratio = grown / size;
            direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + ratio * *d);
            size = grown;
        }
        values
    }
}

/// Row of an element in the table of shapes.
fn row(element: &Element) -> u32 {
    let rows = SHAPES.into_iter().zip(0..);
    // Every element's shape is a row of the table.
    rows.filter(|(shape, _)| *shape == element.shape())
        .map(|(_, row)| row)
        .sum()
}

/// Residual, relative to the load, at which a least-squares problem counts as solved.
const LEAST_SQUARES_TOLERANCE: f64 = 1e-12;

/// Product of a matrix stored by rows with a vector.
fn product(matrix: &CsMat<f64>, vector: &[f64]) -> Vec<f64> {
    let row = |row: sprs::CsVecView<'_, f64>| row.iter().map(|(j, a)| a * vector[j]).sum();
    matrix.outer_iterator().map(row).collect()
}
