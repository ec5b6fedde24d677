//! What an element type is, and the nodes of one element.

use super::face::{Face, FaceType};
use super::matrices::{Matrices, Place};
use crate::Error;
use std::fmt;

/// Most nodes that an element can have. A row of the table with more does not compile.
pub(super) const MAX_NODES: usize = 27;

/// How the strain of an element is formed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Formulation {
    /// Incompatible modes (`C3D8I`): bends without shear locking. The three bending modes of Taylor, Beresford and
    /// Wilson (1976, DOI 10.1002/nme.1620100602) join the trilinear field; their gradients are taken with the Jacobian
    /// of the element's centre, scaled by `det J0 / det J`, so that the patch test is passed on distorted elements.
    #[default]
    IncompatibleModes,
    /// Full integration with the mean volumetric strain (`C3D8`; Hughes 1980, DOI 10.1002/nme.1620150914): does not lock
    /// at Poisson ratios near 0.5, but does in bending.
    BBar,
    /// Full integration of the displacement field: the only formulation of wedges, tetrahedra and hexahedra of 27 nodes, and
    /// that of `C3D20`. Hexahedra of eight nodes lock with it both in bending and near incompressibility; it is kept for
    /// comparison.
    Full,
    /// Of eight nodes (`C3D8R`): the mean strain alone, lumped mass and an artificial stiffness of 0.005 shear moduli against
    /// the deformations that it does not see (Flanagan and Belytschko 1981, DOI 10.1002/nme.1620170504): soft in bending.
    ///
    /// Of twenty nodes (`C3D20R`): 2 x 2 x 2 points for the stiffness, consistent mass. Six deformations of a single element
    /// cost no energy, nor do three of two boxes in a row; in meshes that are two elements wide all but rigid motion does.
    Reduced,
}

/// Shape functions of an element type: values and natural derivatives at a point, one per node.
pub(crate) type Interpolation = fn([f64; 3], &mut [f64], &mut [[f64; 3]]);

/// One row of the table of elements: all that the crate knows of an element type.
///
/// Nodes are in the order that Abaqus and CalculiX share: the corners of one face counter-clockwise seen from within
/// the element, then those of the opposite one (or its apex), so that the Jacobian determinant is positive; after the
/// corners the middles of the edges, then those of the faces and the centre.
pub struct ElementType {
    /// Name: shape and number of nodes.
    pub name: &'static str,
    /// What messages call elements of the type.
    pub description: &'static str,
    /// Natural coordinates of the nodes.
    pub nodes: &'static [[f64; 3]],
    /// For each node after the corners those between which it lies: two for an edge, all of a face, or all.
    pub middles: &'static [&'static [usize]],
    /// Faces with the element's own numbers of their nodes, in the numbering of Abaqus and CalculiX (`S1` comes first).
    pub faces: &'static [(&'static FaceType, &'static [usize])],
    /// Formulations on offer, the default first, and what Abaqus and CalculiX call each, if they have it.
    pub formulations: &'static [(Formulation, Option<&'static str>)],
    /// Type number and order of nodes in Gmsh.
    pub gmsh: ForeignType,
    /// Cell type and order of nodes in VTK.
    pub vtk: ForeignType,
    pub(crate) interpolation: Interpolation,
    pub(crate) matrices: fn(&Place<'_>, Formulation) -> Result<Matrices, Error>,
}

/// An element type in a file format.
pub struct ForeignType {
    /// Number of the type.
    pub number: u8,
    /// This crate's number of each node of the file; empty if the orders are the same.
    pub order: &'static [usize],
    /// A second order that files use under the same number.
    pub alternative: Option<Alternative>,
}

/// A second order of nodes under one type number.
pub struct Alternative {
    /// This crate's number of each node of the file.
    pub order: &'static [usize],
    /// Whether nodes with these positions (m), taken in the first order, must be in the second.
    pub applies: fn(&[[f64; 3]]) -> bool,
}

impl ForeignType {
    /// A type whose nodes are in this crate's order.
    pub(super) const fn same_order(number: u8) -> Self {
        Self {
            number,
            order: &[],
            alternative: None,
        }
    }

    /// Nodes in the order of the file from those in this crate's order.
    pub(crate) fn to_file(&self, nodes: &[u32]) -> Vec<u32> {
        match self.order {
            [] => nodes.to_vec(),
            order => order.iter().map(|&local| nodes[local]).collect(),
        }
    }

    /// Nodes in this crate's order from those in the order of the file.
    pub(crate) fn ours(&self, nodes: &[u32]) -> Vec<u32> {
        reorder(self.order, nodes)
    }
}

impl Alternative {
    /// Nodes in this crate's order from those in this second order of the file.
    pub(crate) fn ours(&self, nodes: &[u32]) -> Vec<u32> {
        reorder(self.order, nodes)
    }
}

fn reorder(order: &[usize], nodes: &[u32]) -> Vec<u32> {
    let mut ours = nodes.to_vec();
    for (&local, &node) in order.iter().zip(nodes) {
        ours[local] = node;
    }
    ours
}

impl ElementType {
    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// The formulation of elements whose file does not name one.
    pub fn default_formulation(&self) -> Formulation {
        self.formulations[0].0
    }

    /// Whether the type has this formulation.
    pub fn offers(&self, formulation: Formulation) -> bool {
        self.formulations.iter().any(|(known, _)| *known == formulation)
    }

    /// Values and natural derivatives (`[d/dr, d/ds, d/dt]`) of the shape functions at the natural coordinates `at`,
    /// one per node.
    pub fn shape_functions(&self, at: [f64; 3]) -> (Vec<f64>, Vec<[f64; 3]>) {
        let n = self.n_nodes();
        let (mut values, mut derivatives) = (vec![0.0; n], vec![[0.0; 3]; n]);
        (self.interpolation)(at, &mut values, &mut derivatives);
        (values, derivatives)
    }
}

/// Types are equal if they are the same row of the table.
impl PartialEq for ElementType {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl Eq for ElementType {}

impl fmt::Debug for ElementType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// Type, formulation and nodes (zero based) of an element.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    element_type: &'static ElementType,
    formulation: Formulation,
    /// Zero beyond the nodes of the type.
    nodes: [u32; MAX_NODES],
}

impl Cell {
    /// An element of any type; `None` if the number of nodes is not that of the type, or the type does not have the
    /// formulation.
    pub fn try_new(element_type: &'static ElementType, formulation: Formulation, nodes: &[u32]) -> Option<Self> {
        let fits = nodes.len() == element_type.n_nodes() && element_type.offers(formulation);
        fits.then(|| Self::from_row(element_type, formulation, nodes))
    }

    /// An element in the default formulation of its type; `nodes` are as many as the type has.
    pub(crate) fn of_type(element_type: &'static ElementType, nodes: &[u32]) -> Self {
        Self::from_row(element_type, element_type.default_formulation(), nodes)
    }

    /// For constructors of the types' own files, which know the number of nodes and the formulations.
    pub(super) fn from_row(element_type: &'static ElementType, formulation: Formulation, nodes: &[u32]) -> Self {
        let mut cell = Self {
            element_type,
            formulation,
            nodes: [0; MAX_NODES],
        };
        cell.nodes[..nodes.len()].copy_from_slice(nodes);
        cell
    }

    /// Its row in the table of elements.
    pub fn element_type(&self) -> &'static ElementType {
        self.element_type
    }

    /// How its strain is formed.
    pub fn formulation(&self) -> Formulation {
        self.formulation
    }

    /// Changes the formulation, if the type has the new one.
    pub fn set_formulation(&mut self, formulation: Formulation) {
        if self.element_type.offers(formulation) {
            self.formulation = formulation;
        }
    }

    /// All nodes.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.element_type.n_nodes()]
    }

    /// The same element on other nodes: `of` gives the new number of each node.
    ///
    /// # Errors
    /// The first error of `of`.
    pub fn try_map_nodes<E>(&self, mut of: impl FnMut(u32) -> Result<u32, E>) -> Result<Self, E> {
        let mut mapped = *self;
        for node in &mut mapped.nodes[..self.element_type.n_nodes()] {
            *node = of(*node)?;
        }
        Ok(mapped)
    }

    /// As [`Cell::try_map_nodes`], where every node has a new number.
    pub fn map_nodes(&self, mut of: impl FnMut(u32) -> u32) -> Self {
        let Ok(mapped) = self.try_map_nodes(|node| Ok::<_, std::convert::Infallible>(of(node)));
        mapped
    }

    /// The face with this number from zero (`S1` is 0), counter-clockwise seen from outside.
    ///
    /// # Panics
    /// If the element has no such face.
    pub fn face(&self, number: usize) -> Face {
        let (face_type, locals) = self.element_type.faces[number];
        Face::from_row(face_type, locals.iter().map(|&local| self.nodes[local]))
    }

    /// Volume (m^3), with `nodes` of the mesh (m).
    ///
    /// # Panics
    /// If a node does not exist.
    pub fn volume(&self, nodes: &[[f64; 3]]) -> f64 {
        let origin = nodes[self.nodes[0] as usize].into();
        self.faces().map(|face| face.volume_from(origin, nodes)).sum()
    }

    /// All faces, counter-clockwise seen from outside, in the numbering of Abaqus and CalculiX (`S1` comes first).
    pub fn faces(&self) -> impl Iterator<Item = Face> + use<> {
        let cell = *self;
        (0..self.element_type.faces.len()).map(move |number| cell.face(number))
    }
}

impl fmt::Debug for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple(self.element_type.name)
            .field(&self.nodes())
            .field(&self.formulation)
            .finish()
    }
}
