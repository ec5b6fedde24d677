//! How far strains of a mesh are from smoother ones: superconvergent patch recovery (Zienkiewicz and Zhu 1992, DOI
//! 10.1002/nme.1620330702).
//!
//! A polynomial is fitted to the strains at the best points of the elements around each corner, quadratic for quadratic elements and linear
//! for linear ones. Interpolated between the nodes, these polynomials are nearer to the exact strains than those of the
//! mesh are, so that the energy of the difference estimates the energy that the mesh lacks. Nothing is smoothed across an interface (bodies
//! share no nodes) or across a change of material.

use crate::Error;
use crate::elements::{COMPONENTS, Cell, ElementType, Formulation, Samples, Strains, determinant};
use crate::mesh::{Element, Mesh};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Reduced integration makes quadratic elements softer, which cancels part of their error. On refined meshes of a beam and a lap joint a tenth to
/// three fifths of the error of full integration were left: this share is taken.
const SHARE_OF_REDUCED: f64 = 0.5;

/// Strains per term of a fit: fewer would let polynomials follow the noise.
const STRAINS_PER_TERM: usize = 2;

/// Weight of the terms of second degree. Where strains do not tell a slope from a curvature, the fit of the smallest coefficients takes the
/// slope then.
const CURVATURE: f64 = 1e-2;

/// Singular value that counts as none, relative to the largest.
const UNSEEN: f64 = 1e-7;

/// Energies of the differences between recovered strains and those of the mesh, of several motions.
#[derive(Clone, Debug, PartialEq)]
pub struct StrainErrors {
    /// Number of motions.
    pub n_motions: usize,
    /// Integral of `(difference of motion i) . stress (of the difference of motion j)` (J for displacements in m), row by row: twice the
    /// energy where `i` is `j`. Of a motion with unit modal mass the entry estimates by how much the square of its angular frequency
    /// is too large.
    pub products: Vec<f64>,
    /// The diagonal by element: those of all motions of the first element, then of the next.
    pub of_elements: Vec<f64>,
}

impl StrainErrors {
    /// Of displacements of all nodes (m), motion by motion.
    ///
    /// # Errors
    /// [`Error::InvertedElement`].
    ///
    /// # Panics
    /// If a motion has not as many displacements as the mesh has nodes.
    pub fn try_new(mesh: &Mesh, motions: &[Vec<[f64; 3]>]) -> Result<Self, Error> {
        assert!(motions.iter().all(|motion| motion.len() == mesh.nodes.len()));
        let m = motions.len();
        let kind = |cell: &Cell| (cell.element_type().name, cell.formulation() as usize);
        let mut kinds: BTreeMap<_, Samples> = BTreeMap::new();
        for element in &mesh.elements {
            let cell = &element.cell;
            let new = || Samples::of(cell.element_type(), cell.formulation());
            kinds.entry(kind(cell)).or_insert_with(new);
        }
        let samples = |cell: &Cell| &kinds[&kind(cell)];
        let material = |element: &Element| &mesh.materials[usize::from(element.material)];
        // Positions and strains at the best points, element by element.
        let found = mesh.elements.par_iter().enumerate().map(|(number, element)| {
            samples(&element.cell).strains(number, &element.cell, mesh, material(element), motions)
        });
        let found: Vec<Vec<Strains>> = found.collect::<Result<_, _>>()?;
        let recovered = Recovered::new(mesh, &found, COMPONENTS * m);
        let of_element = mesh.elements.par_iter().enumerate().map(|(number, element)| {
            let [lambda, mu] = material(element).lame();
            let samples = samples(&element.cell);
            let corners = samples.at_corners(&found[number]);
            let nodes: Vec<&[f64]> = element
                .cell
                .nodes()
                .iter()
                .map(|node| recovered.at(*node, element.material))
                .collect();
            let is_soft =
                element.cell.formulation() == Formulation::Reduced && !element.cell.element_type().middles.is_empty();
            let share = if is_soft { SHARE_OF_REDUCED } else { 1.0 };
            let mut products = vec![0.0; m * m];
            for point in &samples.integration {
                let weight =
                    share * point.weight * determinant(number, &element.cell, mesh, material(element), point.at)?;
                let mut difference = vec![0.0; COMPONENTS * m];
                for (factor, values) in point.nodes.iter().zip(&nodes) {
                    add(&mut difference, values, *factor);
                }
                for (factor, values) in point.corners.iter().zip(&corners) {
                    add(&mut difference, values, -*factor);
                }
                let strain = |motion: usize| &difference[COMPONENTS * motion..][..COMPONENTS];
                for i in 0..m {
                    for j in 0..m {
                        products[m * i + j] += weight * energy(strain(i), strain(j), lambda, mu);
                    }
                }
            }
            Ok(products)
        });
        let of_element: Vec<Vec<f64>> = of_element.collect::<Result<_, Error>>()?;
        let mut products = vec![0.0; m * m];
        of_element.iter().for_each(|own| add(&mut products, own, 1.0));
        let diagonals = of_element.iter().flat_map(|own| (0..m).map(|i| own[(m + 1) * i]));
        Ok(Self {
            n_motions: m,
            products,
            of_elements: diagonals.collect(),
        })
    }
}

fn add(into: &mut [f64], values: &[f64], factor: f64) {
    for (into, value) in into.iter_mut().zip(values) {
        *into += factor * value;
    }
}

/// One strain times the stress of another.
fn energy(a: &[f64], b: &[f64], lambda: f64, mu: f64) -> f64 {
    let trace = |e: &[f64]| e[0] + e[1] + e[2];
    let normal: f64 = (0..3).map(|i| a[i] * b[i]).sum();
    let shear: f64 = (3..6).map(|i| a[i] * b[i]).sum();
    lambda * trace(a) * trace(b) + mu * (2.0 * normal + shear)
}

/// The elements of one material around each of their corners.
type Around = BTreeMap<(u32, u16), Vec<usize>>;

/// What a patch says of a node.
type OfNode = (u32, Vec<f64>);

/// Recovered strains at the nodes, those of each material on its own.
struct Recovered {
    /// Place in the values, by node and material.
    place: BTreeMap<(u32, u16), usize>,
    values: Vec<f64>,
    width: usize,
}

impl Recovered {
    fn new(mesh: &Mesh, found: &[Vec<Strains>], width: usize) -> Self {
        let mut around = Around::new();
        for (number, element) in mesh.elements.iter().enumerate() {
            for node in corners(&element.cell) {
                around.entry((*node, element.material)).or_default().push(number);
            }
        }
        let patches: Vec<(&(u32, u16), &Vec<usize>)> = around.iter().collect();
        let contributions = patches.par_iter().map(|((node, material), elements)| {
            let patch = widened(mesh, found, &around, *material, elements);
            let fit = Fit::new(mesh, found, *node, &patch, width);
            let mut own = vec![(*node, fit.at(mesh.nodes[*node as usize]))];
            for number in elements.iter() {
                let cell = &mesh.elements[*number].cell;
                let nodes = cell.nodes();
                let first_middle = corners(cell).len();
                let middles = cell.element_type().middles.iter().enumerate();
                let beside = middles.filter(|(_, between)| between.iter().any(|&local| nodes[local] == *node));
                own.extend(beside.map(|(i, _)| {
                    let middle = nodes[first_middle + i];
                    (middle, fit.at(mesh.nodes[middle as usize]))
                }));
            }
            (*material, own)
        });
        let contributions: Vec<(u16, Vec<OfNode>)> = contributions.collect();
        let mut place = BTreeMap::new();
        let (mut values, mut counts) = (Vec::new(), Vec::new());
        for (material, own) in contributions {
            for (node, value) in own {
                let index = *place.entry((node, material)).or_insert(counts.len());
                if index == counts.len() {
                    counts.push(0.0_f64);
                    values.resize(values.len() + width, 0.0);
                }
                counts[index] += 1.0;
                add(&mut values[width * index..][..width], &value, 1.0);
            }
        }
        for (values, count) in values.chunks_mut(width.max(1)).zip(&counts) {
            values.iter_mut().for_each(|value| *value /= count);
        }
        Self { place, values, width }
    }

    fn at(&self, node: u32, material: u16) -> &[f64] {
        let index = self.place[&(node, material)];
        &self.values[self.width * index..][..self.width]
    }
}

fn corners(cell: &Cell) -> &[u32] {
    let row: &ElementType = cell.element_type();
    &cell.nodes()[..row.n_nodes() - row.middles.len()]
}

/// Elements, with their neighbours until their strains are enough for a fit.
fn widened(mesh: &Mesh, found: &[Vec<Strains>], around: &Around, material: u16, elements: &[usize]) -> Vec<usize> {
    let mut patch: BTreeSet<usize> = elements.iter().copied().collect();
    let is_quadratic = |number: &usize| !mesh.elements[*number].cell.element_type().middles.is_empty();
    let terms = if elements.iter().any(is_quadratic) { 10 } else { 4 };
    while patch.iter().map(|number| found[*number].len()).sum::<usize>() < STRAINS_PER_TERM * terms {
        let nodes = patch.iter().flat_map(|number| corners(&mesh.elements[*number].cell));
        let wider = nodes.filter_map(|node| around.get(&(*node, material))).flatten();
        let wider: BTreeSet<usize> = wider.copied().collect();
        if wider.len() == patch.len() {
            break;
        }
        patch = wider;
    }
    patch.into_iter().collect()
}

/// A polynomial fitted to the strains about a node.
struct Fit {
    centre: [f64; 3],
    size: f64,
    coefficients: DMatrix<f64>,
}

impl Fit {
    fn new(mesh: &Mesh, found: &[Vec<Strains>], node: u32, elements: &[usize], width: usize) -> Self {
        let is_quadratic = elements
            .iter()
            .any(|number| !mesh.elements[*number].cell.element_type().middles.is_empty());
        let samples: Vec<&Strains> = elements.iter().flat_map(|number| &found[*number]).collect();
        let terms = match samples.len() / STRAINS_PER_TERM {
            10.. if is_quadratic => 10,
            4.. => 4,
            _ => 1,
        };
        let centre = mesh.nodes[node as usize];
        let distance = |sample: &&Strains| (0..3).map(|c| (sample.at[c] - centre[c]).powi(2)).sum::<f64>();
        let size = samples.iter().map(distance).fold(0.0, f64::max).sqrt();
        let size = if size > 0.0 { size } else { 1.0 };
        let weights = |j: usize| if j < 4 { 1.0 } else { CURVATURE };
        let mut rows = DMatrix::zeros(samples.len(), terms);
        for (i, sample) in samples.iter().enumerate() {
            let basis = basis(sample.at, centre, size);
            (0..terms).for_each(|j| rows[(i, j)] = basis[j] * weights(j));
        }
        let values = DMatrix::from_fn(samples.len(), width, |i, j| samples[i].values[j]);
        let svd = rows.svd(true, true);
        let largest = svd.singular_values.max();
        // Directions that the samples do not see stay out of the fit; both factors were asked for.
        let mut coefficients = svd
            .solve(&values, UNSEEN * largest)
            .unwrap_or_else(|_| DMatrix::zeros(terms, width));
        for (j, mut row) in coefficients.row_iter_mut().enumerate() {
            row *= weights(j);
        }
        Self {
            centre,
            size,
            coefficients,
        }
    }

    fn at(&self, x: [f64; 3]) -> Vec<f64> {
        let basis = basis(x, self.centre, self.size);
        let value = |column: nalgebra::DVectorView<'_, f64>| column.iter().zip(basis).map(|(c, b)| c * b).sum();
        self.coefficients.column_iter().map(value).collect()
    }
}

/// Monomials up to the second degree, constant and linear ones first.
fn basis(x: [f64; 3], centre: [f64; 3], size: f64) -> [f64; 10] {
    let [x, y, z] = [0, 1, 2].map(|c| (x[c] - centre[c]) / size);
    [1.0, x, y, z, x * x, y * y, z * z, y * z, x * z, x * y]
}
