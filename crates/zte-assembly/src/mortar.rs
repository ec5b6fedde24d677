//! Faces whose meshes do not match: the motion of one side at the nodes of the other.
//!
//! The nodes of one side (the *own* side) carry the jump. What faces them is a weighted mean of the motion of the other side's
//! nodes, by the mortar method with dual multipliers on the intersection of both meshes:
//!
//! `w = P v`, with `P = D^-1 M`, `D_ii = int N_i dA`, `M_ij = int Psi_i N_j' dA`
//!
//! where `N'` are the shape functions of the other side and `Psi` those that are dual to the own ones on the part of each element that is faced.
//! Integrals run over the polygons that elements of both sides share. Whatever their accuracy,
//!
//! - the weights of a node sum to one, so that a translation of both sides is no jump;
//! - positions in the plane are reproduced, so that rotations about the normal are no jump either, and resultants and moments
//!   of tractions arrive on the other side;
//! - a uniform traction, integrated over the own side, arrives as the consistent nodal forces of the other side, as far as the
//!   integrals are exact (polynomials of degree 6 on each triangle): the patch test is passed.
//!
//! Shape functions of quadratic elements have integrals that vanish or are negative at corners. There the dual functions belong to a
//! basis with positive integrals: each corner takes a fifth of the functions of the middles beside it.
//!
//! Sources: Wohlmuth 2000, DOI 10.1137/S0036142999350929 (dual multipliers); Popp, Wohlmuth, Gee, Wall 2012, DOI
//! 10.1137/110848190 (quadratic elements); Puso, Laursen 2004, DOI 10.1016/j.cma.2003.10.010 (segments).

use crate::Error;
use crate::clip::{Cut, Polygon, area};
use crate::mesh::{Covered, Element, InterfaceMesh};
use crate::quadrature::{Point, Quadrature};
use crate::shape::{Domain, Functions, MAX_NODES};
use crate::tree::{Bounded, Tree};
use sprs::{CsMat, TriMat};
use std::collections::{BTreeMap, BTreeSet};

/// Share of its area from which on an element counts as faced as a whole: what is missing is round-off.
const WHOLE: f64 = 1.0 - 1e-9;

/// Least share of its area that an element must be faced by.
const LEAST_SHARE: f64 = 0.05;

/// Least share of a function's integral over whole elements that must be faced. With less, at the edge of contact, the node moves
/// with the nearest element of the other side, continued beyond its edge.
const LEAST_INTEGRAL: f64 = 0.1;

/// Part of the functions of a middle that each corner beside it takes over, in elements with negative integrals.
const TRANSFER: f64 = 0.2;

/// Largest natural coordinate of a point in an element that is continued beyond its edge.
const FARTHEST: f64 = 8.0;

/// What faces an interface mesh.
#[derive(Clone, Debug)]
pub struct Mortar {
    /// `P`, the motion of the other side at the own nodes (own x other); rows of nodes without an element that is faced are empty.
    pub projection: CsMat<f64>,
    /// Own elements that are faced, ascending.
    pub elements: Vec<usize>,
    /// Which of these are faced in part; numbers count the own elements.
    pub covered: Vec<Covered>,
    /// Own elements of which too little is faced to keep them: number and share of the area.
    pub dropped: Vec<(usize, f64)>,
    /// Largest distance along the normal between the two sides where they face one another (m).
    pub largest_distance: f64,
    /// Height of the other side above the own one where they face one another.
    pub rise: Rise,
    /// Areas of the own and the other side in the plane (m^2).
    pub areas: [f64; 2],
}

/// The height of one side above the other, along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rise {
    /// Area that faces the other side, in the plane (m^2).
    pub area: f64,
    /// Mean over that area (m).
    pub mean: f64,
    /// Mean of its size (m).
    pub mean_size: f64,
    /// Least and largest (m).
    pub range: [f64; 2],
}

impl Default for Rise {
    /// Of nothing.
    fn default() -> Self {
        Self {
            area: 0.0,
            mean: 0.0,
            mean_size: 0.0,
            range: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }
}

impl Rise {
    /// That of the own side above the other one.
    pub fn reversed(self) -> Self {
        Self {
            mean: -self.mean,
            range: [-self.range[1], -self.range[0]],
            ..self
        }
    }

    /// Takes a part of the area into account.
    pub fn add(&mut self, area: f64, height: f64) {
        self.area += area;
        if self.area > 0.0 {
            let weight = area / self.area;
            self.mean += weight * (height - self.mean);
            self.mean_size += weight * (height.abs() - self.mean_size);
        }
        self.range = [self.range[0].min(height), self.range[1].max(height)];
    }
}

impl Mortar {
    /// Finds what faces the elements of `own` among those of `other`, both in the same plane coordinates and counter-clockwise
    /// in them. Parts that are farther apart along the normal than `reach` (m) do not face one another.
    ///
    /// # Errors
    /// Of [`InterfaceMesh::validate`] for either mesh; [`Error::Inverted`]; [`Error::NotFacing`] where nothing is faced;
    /// [`Error::Mapping`] for elements too distorted to find natural coordinates in.
    pub fn try_new(own: &InterfaceMesh, other: &InterfaceMesh, reach: f64) -> Result<Self, Error> {
        own.validate()?;
        other.validate()?;
        let (parts, facing) = (triangles(own)?, triangles(other)?);
        let areas = [&parts, &facing].map(|all| all.iter().map(|part| part.area).sum());
        let tree = Tree::new(facing);
        let quadrature = Quadrature::finest();
        let mut mortar = Self {
            projection: CsMat::zero((own.nodes.len(), other.nodes.len())),
            elements: Vec::new(),
            covered: Vec::new(),
            dropped: Vec::new(),
            largest_distance: 0.0,
            rise: Rise::default(),
            areas,
        };
        let mut sums = vec![Sums::default(); own.nodes.len()];
        let mut cut = Cut::default();
        for parts in parts.chunk_by(|a, b| a.element == b.element) {
            let element = parts[0].element;
            let mut integrals = Integrals::new(own, &own.elements[element]);
            for part in parts {
                let mut failed = None;
                tree.visit(part.bounds(), &mut |facing: &Polygon| {
                    let shared = part.shared(facing, &mut cut);
                    if shared.len() < 3 || area(shared) <= 1e-14 * part.area.min(facing.area) {
                        return;
                    }
                    let sides = [(own, element), (other, facing.element)];
                    match integrals.add(sides, shared, quadrature.triangle(), reach) {
                        Ok(None) => {}
                        Ok(Some(rise)) => mortar.rise.add(area(shared), rise),
                        Err(error) => failed = failed.take().or(Some(error)),
                    }
                });
                if let Some(error) = failed {
                    return Err(error);
                }
            }
            let whole: f64 = parts.iter().map(|part| part.area).sum();
            let share = integrals.area / whole;
            if share < LEAST_SHARE {
                mortar.dropped.push((element, share));
                continue;
            }
            mortar.elements.push(element);
            mortar.largest_distance = mortar.largest_distance.max(integrals.largest_distance);
            if share < WHOLE {
                mortar.covered.push(integrals.covered(element, share));
            }
            let whole = integrals_of_functions(own, element, &quadrature);
            integrals.add_dual(&own.elements[element], &whole, &mut sums);
        }
        if mortar.elements.is_empty() {
            return Err(Error::NotFacing { reach });
        }
        mortar.projection = projection(own, other, &mortar.elements, &sums)?;
        Ok(mortar)
    }
}

/// What is summed over the elements of a node.
#[derive(Clone, Debug, Default)]
struct Sums {
    /// Integral of its function over the faced parts.
    own: f64,
    /// Over the whole elements.
    whole: f64,
    /// `M_ij` by nodes of the other side.
    coupling: BTreeMap<u32, f64>,
    /// Elements of the other side that face its elements.
    facing: BTreeSet<usize>,
}

/// Triangles that make up the elements, in their order; curved edges count as the lines to and from their middles.
fn triangles(mesh: &InterfaceMesh) -> Result<Vec<Polygon>, Error> {
    let mut found = Vec::new();
    for (index, element) in mesh.elements.iter().enumerate() {
        let nodes = element.nodes();
        let lists: &[[usize; 3]] = match (element.shape().domain, nodes.len()) {
            (Domain::Triangle, 3) => &[[0, 1, 2]],
            (Domain::Triangle, _) => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
            (Domain::Square, 4) => &[[0, 1, 2], [0, 2, 3]],
            (Domain::Square, 8) => &[[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 6], [4, 6, 7]],
            (Domain::Square, _) => &[
                [0, 4, 8],
                [4, 1, 8],
                [1, 5, 8],
                [5, 2, 8],
                [2, 6, 8],
                [6, 3, 8],
                [3, 7, 8],
                [7, 0, 8],
            ],
            (Domain::Point, _) => return Err(Error::NotFacing { reach: 0.0 }),
        };
        for (point, list) in lists.iter().enumerate() {
            let corners = list.map(|local| mesh.nodes[nodes[local] as usize]);
            let triangle = Polygon::try_new(index, corners.into_iter()).ok_or(Error::Inverted {
                element: index,
                point,
                determinant: 2.0 * area(&corners),
            })?;
            found.push(triangle);
        }
    }
    Ok(found)
}

/// Whether the element's functions are transferred from middles to corners.
fn is_transferred(element: &Element) -> bool {
    // The functions of nine nodes have positive integrals as they are.
    matches!(element.nodes().len(), 6 | 8)
}

/// Integrals over the faced part of one element.
struct Integrals {
    n: usize,
    area: f64,
    /// A point of the element, about which moments are taken: the distance from the coordinates' origin would cost digits.
    origin: [f64; 2],
    /// First moments of the area.
    first: [f64; 2],
    /// Second moments xx, xy, yy.
    second: [f64; 3],
    /// Of the products of the own functions, transferred where they are.
    products: Vec<f64>,
    /// Of the own functions.
    functions: Vec<f64>,
    /// Of the products with the functions of nodes of the other side.
    coupling: BTreeMap<u32, Vec<f64>>,
    facing: BTreeSet<usize>,
    largest_distance: f64,
}

impl Integrals {
    fn new(mesh: &InterfaceMesh, element: &Element) -> Self {
        let n = element.nodes().len();
        Self {
            n,
            area: 0.0,
            origin: mesh.nodes[element.nodes()[0] as usize],
            first: [0.0; 2],
            second: [0.0; 3],
            products: vec![0.0; n * n],
            functions: vec![0.0; n],
            coupling: BTreeMap::new(),
            facing: BTreeSet::new(),
            largest_distance: 0.0,
        }
    }

    /// Adds a polygon that an element of both meshes covers, unless they are too far apart there, and says by how much the other one is
    /// above the own one in its middle.
    fn add(
        &mut self,
        [(own, element), (other, facing)]: [(&InterfaceMesh, usize); 2],
        polygon: &[[f64; 2]],
        rule: &[Point],
        reach: f64,
    ) -> Result<Option<f64>, Error> {
        let (of_own, of_other) = (&own.elements[element], &other.elements[facing]);
        let centre = mean(polygon);
        let [own_height, other_height] = [(own, element), (other, facing)]
            .map(|(mesh, index)| Ok::<f64, Error>(height(mesh, index, locate(mesh, index, centre)?.1.values())));
        let rise = other_height? - own_height?;
        let distance = rise.abs();
        if distance > reach {
            return Ok(None);
        }
        self.largest_distance = self.largest_distance.max(distance);
        self.facing.insert(facing);
        let mut columns = [[0.0; MAX_NODES]; MAX_NODES];
        let pieces = pieces(centre, polygon, is_affine(own, of_own) && is_affine(other, of_other));
        for [origin, a, b] in pieces {
            let whole = 2.0 * area(&[origin, a, b]);
            for point in rule {
                let [s, t] = point.xi;
                let x = [0, 1].map(|c| origin[c] + s * (a[c] - origin[c]) + t * (b[c] - origin[c]));
                let (_, at_own) = locate(own, element, x)?;
                let (flat, curved) = own.area_density(of_own, at_own.derivatives());
                let in_plane = point.weight * whole;
                self.area += in_plane;
                let [p, q] = [0, 1].map(|c| x[c] - self.origin[c]);
                for (sum, moment) in self.first.iter_mut().zip([p, q]) {
                    *sum += in_plane * moment;
                }
                for (sum, moment) in self.second.iter_mut().zip([p * p, p * q, q * q]) {
                    *sum += in_plane * moment;
                }
                let weight = in_plane * curved / flat;
                let mut memory = [0.0; MAX_NODES];
                let values = &mut memory[..self.n];
                values.copy_from_slice(at_own.values());
                if is_transferred(of_own) {
                    transfer(values, of_own.corners().len());
                }
                for (i, value) in values.iter().enumerate() {
                    self.functions[i] += weight * value;
                    for (j, other) in values.iter().enumerate() {
                        self.products[i * self.n + j] += weight * value * other;
                    }
                }
                let (_, at_other) = locate(other, facing, x)?;
                for (column, share) in columns.iter_mut().zip(at_other.values()) {
                    for (entry, value) in column.iter_mut().zip(&*values) {
                        *entry += weight * value * share;
                    }
                }
            }
        }
        for (&node, column) in of_other.nodes().iter().zip(&columns) {
            let sums = self.coupling.entry(node).or_insert_with(|| vec![0.0; self.n]);
            sums.iter_mut().zip(column).for_each(|(sum, value)| *sum += value);
        }
        Ok(Some(rise))
    }

    /// The part that is faced.
    fn covered(&self, element: usize, share: f64) -> Covered {
        let [x, y] = self.first.map(|moment| moment / self.area);
        let [xx, xy, yy] = self.second.map(|moment| moment / self.area);
        Covered {
            element,
            share,
            centroid: [self.origin[0] + x, self.origin[1] + y],
            spread: [xx - x * x, xy - x * y, yy - y * y],
        }
    }

    /// Adds `int Psi N'` and `int N`, with the dual functions `Psi = diag(int N) (int N N^T)^-1 N` of this part.
    /// `whole` are the integrals over the whole element.
    fn add_dual(mut self, element: &Element, whole: &[f64], sums: &mut [Sums]) {
        let columns: Vec<u32> = self.coupling.keys().copied().collect();
        let mut right: Vec<f64> = self.coupling.values().flatten().copied().collect();
        solve_symmetric(&mut self.products, self.n, &mut right);
        for (local, &node) in element.nodes().iter().enumerate() {
            let (own, sums) = (self.functions[local], &mut sums[node as usize]);
            sums.own += own;
            sums.whole += whole[local];
            sums.facing.extend(&self.facing);
            for (at, &column) in columns.iter().enumerate() {
                *sums.coupling.entry(column).or_insert(0.0) += own * right[at * self.n + local];
            }
        }
    }
}

/// Triangles that fill a convex polygon around its `centre`. Shape functions of distorted elements are no polynomials of the place:
/// there triangles are divided once more, which brings the error of the integrals from 1e-8 to 1e-10.
fn pieces(centre: [f64; 2], polygon: &[[f64; 2]], affine: bool) -> Vec<[[f64; 2]; 3]> {
    let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let edges = polygon.iter().enumerate();
    let fan = edges.map(|(i, &a)| [centre, a, polygon[(i + 1) % polygon.len()]]);
    let fan = fan.filter(|triangle| area(triangle) > 0.0);
    match affine {
        true => fan.collect(),
        false => fan
            .flat_map(|[a, b, c]| {
                let [p, q, r] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
            })
            .collect(),
    }
}

/// Whether natural coordinates are linear in the place: parallelograms, and triangles with straight edges halved by their middles.
fn is_affine(mesh: &InterfaceMesh, element: &Element) -> bool {
    let at = |node: u32| mesh.nodes[node as usize];
    let corners: Vec<[f64; 2]> = element.corners().iter().map(|&node| at(node)).collect();
    let size = (corners[1][0] - corners[0][0]).hypot(corners[1][1] - corners[0][1]);
    let small = |x: [f64; 2]| x[0].hypot(x[1]) <= 1e-10 * size;
    let parallel = match corners[..] {
        [a, b, c, d] => small([0, 1].map(|i| a[i] - b[i] + c[i] - d[i])),
        _ => true,
    };
    let straight = element.nodes()[corners.len()..]
        .iter()
        .enumerate()
        .all(|(edge, &middle)| {
            let mean = match edge < corners.len() {
                true => [0, 1].map(|i| 0.5 * (corners[edge][i] + corners[(edge + 1) % corners.len()][i])),
                false => mean(&corners),
            };
            small([0, 1].map(|i| at(middle)[i] - mean[i]))
        });
    parallel && straight
}

/// Replaces the functions of corners and middles by those with positive integrals.
fn transfer(values: &mut [f64], n_corners: usize) {
    for edge in 0..n_corners {
        let part = TRANSFER * values[n_corners + edge];
        values[edge] += part;
        values[(edge + 1) % n_corners] += part;
        values[n_corners + edge] -= 2.0 * part;
    }
}

/// Solves with a symmetric positive definite matrix of `n` rows for columns that follow one another, by Cholesky's method.
fn solve_symmetric(matrix: &mut [f64], n: usize, columns: &mut [f64]) {
    for j in 0..n {
        for k in 0..j {
            let factor = matrix[j * n + k];
            for i in j..n {
                matrix[i * n + j] -= factor * matrix[i * n + k];
            }
        }
        let pivot = matrix[j * n + j].sqrt();
        for i in j..n {
            matrix[i * n + j] /= pivot;
        }
    }
    for column in columns.chunks_exact_mut(n) {
        for i in 0..n {
            for k in 0..i {
                column[i] -= matrix[i * n + k] * column[k];
            }
            column[i] /= matrix[i * n + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                column[i] -= matrix[k * n + i] * column[k];
            }
            column[i] /= matrix[i * n + i];
        }
    }
}

/// Integrals of the functions, transferred where they are, over an element.
fn integrals_of_functions(mesh: &InterfaceMesh, index: usize, quadrature: &Quadrature) -> Vec<f64> {
    let element = &mesh.elements[index];
    let mut integrals = vec![0.0; element.nodes().len()];
    for point in quadrature.points(element.shape()) {
        let (mut values, derivatives) = element.shape().functions(point.xi);
        let weight = point.weight * mesh.area_density(element, &derivatives).1;
        if is_transferred(element) {
            transfer(&mut values, element.corners().len());
        }
        integrals
            .iter_mut()
            .zip(values)
            .for_each(|(sum, value)| *sum += weight * value);
    }
    integrals
}

/// `D^-1 M`, brought back from the transferred functions to the nodes.
fn projection(
    own: &InterfaceMesh,
    other: &InterfaceMesh,
    elements: &[usize],
    sums: &[Sums],
) -> Result<CsMat<f64>, Error> {
    // The corners beside each middle whose functions were transferred.
    let mut beside = vec![None; own.nodes.len()];
    let mut used = vec![false; own.nodes.len()];
    for element in elements.iter().map(|&index| &own.elements[index]) {
        element.nodes().iter().for_each(|&node| used[node as usize] = true);
        if is_transferred(element) {
            let corners = element.corners();
            for (edge, &corner) in corners.iter().enumerate() {
                let middle = element.nodes()[corners.len() + edge];
                beside[middle as usize] = Some([corner, corners[(edge + 1) % corners.len()]].map(|node| node as usize));
            }
        }
    }
    // The other side's weights in the coefficient of each function.
    let coefficient = |node: usize| -> Result<Vec<(usize, f64)>, Error> {
        let Sums {
            own: faced,
            whole,
            coupling,
            facing,
        } = &sums[node];
        if *faced > LEAST_INTEGRAL * whole {
            let weights = coupling.iter().map(|(&column, value)| (column as usize, value / faced));
            return Ok(weights.collect());
        }
        // What the coefficient is in the field of positions.
        let at = |node: usize| own.nodes[node];
        let x = match beside[node] {
            None => at(node),
            Some([a, b]) => [0, 1].map(|c| (at(node)[c] - TRANSFER * (at(a)[c] + at(b)[c])) / (1.0 - 2.0 * TRANSFER)),
        };
        let beyond = |xi: [f64; 2]| xi[0].abs().max(xi[1].abs());
        let places = facing
            .iter()
            .filter_map(|&index| Some((index, natural(other, index, x).ok()?)));
        let nearest = places.min_by(|a, b| beyond(a.1).total_cmp(&beyond(b.1)));
        let (index, xi) = nearest.ok_or(Error::Mapping { node })?;
        let element = &other.elements[index];
        let nodes = element.nodes().iter().map(|&node| node as usize);
        Ok(nodes.zip(element.shape().functions(xi).0).collect())
    };
    let mut rows = TriMat::new((own.nodes.len(), other.nodes.len()));
    for node in (0..own.nodes.len()).filter(|&node| used[node]) {
        let mut add = |of: usize, factor: f64| -> Result<(), Error> {
            for (column, value) in coefficient(of)? {
                rows.add_triplet(node, column, factor * value);
            }
            Ok(())
        };
        match beside[node] {
            None => add(node, 1.0)?,
            Some(corners) => {
                add(node, 1.0 - 2.0 * TRANSFER)?;
                corners.into_iter().try_for_each(|corner| add(corner, TRANSFER))?;
            }
        }
    }
    Ok(rows.to_csr())
}

/// Distance from the plane of the point with these values of the shape functions.
fn height(mesh: &InterfaceMesh, index: usize, values: &[f64]) -> f64 {
    let nodes = mesh.elements[index].nodes().iter();
    let heights = nodes.map(|&node| mesh.heights.get(node as usize).copied().unwrap_or(0.0));
    heights.zip(values).map(|(height, value)| height * value).sum()
}

/// Natural coordinates of a point of the plane in an element.
pub(crate) fn natural(mesh: &InterfaceMesh, index: usize, x: [f64; 2]) -> Result<[f64; 2], Error> {
    Ok(locate(mesh, index, x)?.0)
}

/// Natural coordinates of a point of the plane in an element, by Newton's method, and the shape functions there.
fn locate(mesh: &InterfaceMesh, index: usize, x: [f64; 2]) -> Result<([f64; 2], Functions), Error> {
    let element = &mesh.elements[index];
    let mut xi = match element.shape().domain {
        Domain::Triangle => [1.0 / 3.0; 2],
        Domain::Square | Domain::Point => [0.0; 2],
    };
    let mut at = Functions::new(element.shape(), xi);
    for _ in 0..40 {
        let (mut rest, mut j) = (x, [[0.0; 2]; 2]);
        for ((value, slope), &node) in at.values().iter().zip(at.derivatives()).zip(element.nodes()) {
            let place = mesh.nodes[node as usize];
            for i in 0..2 {
                rest[i] -= value * place[i];
                (0..2).for_each(|k| j[i][k] += place[i] * slope[k]);
            }
        }
        let determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        let step = [
            (j[1][1] * rest[0] - j[0][1] * rest[1]) / determinant,
            (j[0][0] * rest[1] - j[1][0] * rest[0]) / determinant,
        ];
        let moved = step[0].abs().max(step[1].abs());
        if moved < 1e-14 {
            return Ok((xi, at));
        }
        (0..2).for_each(|i| xi[i] += step[i]);
        // `!(a < b)` also catches NaN.
        if !(moved < 1e3) {
            break;
        }
        at = Functions::new(element.shape(), xi);
    }
    // Round-off may keep the last step above the threshold; then the point is known as well as it can be.
    match xi.iter().all(|v| v.abs() < FARTHEST) {
        true => Ok((xi, at)),
        false => Err(Error::Mapping {
            node: element.nodes()[0] as usize,
        }),
    }
}

/// Mean of the corners of a convex polygon, a point inside it.
fn mean(corners: &[[f64; 2]]) -> [f64; 2] {
    let sum = corners.iter().fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
    sum.map(|sum| sum / corners.len() as f64)
}
