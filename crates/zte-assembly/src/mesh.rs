//! The interface mesh: flat elements between two bodies whose nodes coincide in pairs, or single points of contact.

use crate::Error;
use crate::overlap::{self, Overlap};
use crate::shape::{MAX_NODES, POINT1, QUAD4, QUAD8, QUAD9, Shape, TRI3, TRI6};
use std::collections::HashMap;
use std::fmt;

/// An interface element: its shape and node numbers, the corners in cyclic (counter-clockwise) order, then the middles of the
/// edges, then the centre.
#[derive(Clone, Copy, PartialEq)]
pub struct Element {
    shape: &'static Shape,
    /// Zero beyond the nodes of the shape.
    nodes: [u32; MAX_NODES],
    /// Of points of contact alone.
    contact: Option<PointContact>,
}

/// What a point of contact is beside its node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointContact {
    /// Area that it stands for (m^2): tractions times it are forces. Positive and finite.
    pub area: f64,
    /// Components x, y, n along which the structure has no coordinate: the jump along them is zero and takes no force.
    pub held: [bool; 3],
}

impl Element {
    /// The element with these nodes, whose number tells its shape; `None` if no shape with an area has so many.
    pub fn from_nodes(nodes: &[u32]) -> Option<Self> {
        let shape = Shape::with_nodes(nodes.len()).filter(|shape| **shape != POINT1);
        shape.map(|shape| Self::from_row(shape, nodes))
    }

    /// Point of contact at a node.
    pub fn point(node: u32, contact: PointContact) -> Self {
        Self {
            contact: Some(contact),
            ..Self::from_row(&POINT1, &[node])
        }
    }

    /// Three-node triangle.
    pub fn tri3(nodes: [u32; 3]) -> Self {
        Self::from_row(&TRI3, &nodes)
    }

    /// Four-node quadrilateral.
    pub fn quad4(nodes: [u32; 4]) -> Self {
        Self::from_row(&QUAD4, &nodes)
    }

    /// Six-node triangle.
    pub fn tri6(nodes: [u32; 6]) -> Self {
        Self::from_row(&TRI6, &nodes)
    }

    /// Eight-node quadrilateral.
    pub fn quad8(nodes: [u32; 8]) -> Self {
        Self::from_row(&QUAD8, &nodes)
    }

    /// Nine-node quadrilateral.
    pub fn quad9(nodes: [u32; 9]) -> Self {
        Self::from_row(&QUAD9, &nodes)
    }

    /// `nodes` are as many as the shape has.
    fn from_row(shape: &'static Shape, nodes: &[u32]) -> Self {
        let mut element = Self {
            shape,
            nodes: [0; MAX_NODES],
            contact: None,
        };
        element.nodes[..nodes.len()].copy_from_slice(nodes);
        element
    }

    /// Its row in the table of shapes.
    pub fn shape(&self) -> &'static Shape {
        self.shape
    }

    /// What a point of contact is beside its node; `None` of shapes with an area of their own.
    pub fn contact(&self) -> Option<PointContact> {
        self.contact
    }

    /// Its nodes.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.shape.n_nodes]
    }

    /// Its nodes, to be changed.
    pub fn nodes_mut(&mut self) -> &mut [u32] {
        &mut self.nodes[..self.shape.n_nodes]
    }

    /// The same element on other nodes: `of` gives the new number of each node.
    ///
    /// # Errors
    /// The first error of `of`.
    pub fn try_map_nodes<E>(&self, mut of: impl FnMut(u32) -> Result<u32, E>) -> Result<Self, E> {
        let mut mapped = *self;
        for node in mapped.nodes_mut() {
            *node = of(*node)?;
        }
        Ok(mapped)
    }

    /// The nodes at its corners.
    pub fn corners(&self) -> &[u32] {
        &self.nodes[..self.shape.n_corners]
    }

    /// The nodes in the middle of its edges, the first between the first two corners; none where edges are straight.
    fn middles(&self) -> &[u32] {
        let n = self.shape.n_corners;
        self.nodes().get(n..2 * n).unwrap_or_default()
    }

    /// The nodes on its boundary, counter-clockwise: corners, and the middles between them where edges have one.
    pub fn outline(&self) -> Vec<u32> {
        let middles = self.middles();
        let corners = self.corners().iter().enumerate();
        corners
            .flat_map(|(i, &corner)| std::iter::once(corner).chain(middles.get(i).copied()))
            .collect()
    }
}

impl fmt::Debug for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut tuple = f.debug_tuple(self.shape.name);
        tuple.field(&self.nodes());
        if let Some(contact) = &self.contact {
            tuple.field(contact);
        }
        tuple.finish()
    }
}

/// A flat interface mesh. Node `i` stands for a pair of coinciding nodes, one on each body.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceMesh {
    /// In-plane coordinates (x, y) of the nodes (m).
    pub nodes: Vec<[f64; 2]>,
    /// Elements.
    pub elements: Vec<Element>,
}

impl InterfaceMesh {
    /// The mesh of nodes (m) and lists of node numbers, from zero and counter-clockwise, one list per element.
    ///
    /// # Errors
    /// [`Error::NodeCount`] for a list of another length than the shapes have; otherwise as
    /// [`InterfaceMesh::validate`].
    pub fn try_from_lists<L: AsRef<[u32]>>(
        nodes: Vec<[f64; 2]>,
        lists: impl IntoIterator<Item = L>,
    ) -> Result<Self, Error> {
        let elements = lists.into_iter().enumerate().map(|(element, list)| {
            let nodes = list.as_ref();
            let found = nodes.len();
            Element::from_nodes(nodes).ok_or(Error::NodeCount { element, found })
        });
        let elements = elements.collect::<Result<_, _>>()?;
        let mesh = Self { nodes, elements };
        mesh.validate()?;
        Ok(mesh)
    }

    /// Checks coordinates, references and the areas of points, that no element has a node twice or the nodes of another, and that
    /// no two elements share more than 1e-4 of the smaller one's area, edges taken as the lines between corners; shapes are
    /// checked where quadrature points are known. Points may be at the same place, also at the nodes of other elements.
    ///
    /// # Errors
    /// The first defect found.
    pub fn validate(&self) -> Result<(), Error> {
        if self.elements.is_empty() {
            return Err(Error::Empty);
        }
        let count = self.nodes.len();
        for (index, x) in self.nodes.iter().enumerate() {
            if let Some(&value) = x.iter().find(|v| !v.is_finite()) {
                let (quantity, place) = ("coordinate", "interface node");
                return Err(Error::Value {
                    quantity,
                    place,
                    index,
                    value,
                    requirement: "finite",
                });
            }
        }
        let mut used = vec![false; count];
        for (element, nodes) in self.elements.iter().enumerate() {
            for &node in nodes.nodes() {
                *used
                    .get_mut(node as usize)
                    .ok_or(Error::Dangling { element, node, count })? = true;
            }
            if let Some(PointContact { area, .. }) = nodes.contact
                && !(area.is_finite() && area > 0.0)
            {
                return Err(Error::PointArea { element, area });
            }
        }
        let mut first = HashMap::with_capacity(self.elements.len());
        for (element, nodes) in self.elements.iter().enumerate() {
            let mut nodes = nodes.nodes().to_vec();
            nodes.sort_unstable();
            if let Some(pair) = nodes.windows(2).find(|pair| pair[0] == pair[1]) {
                let node = pair[0];
                return Err(Error::RepeatedNode { element, node });
            }
            if let Some(first) = first.insert(nodes, element) {
                return Err(Error::DuplicateElement { element, first });
            }
        }
        if let Some(node) = used.iter().position(|used| !used) {
            return Err(Error::Unused { node });
        }
        match overlap::find(self) {
            Some(Overlap { element, first, shared }) => Err(Error::OverlappingElements {
                element,
                first,
                shared,
                tolerance: overlap::TOLERANCE,
            }),
            None => Ok(()),
        }
    }

    /// Whether it has points of contact alone, and so no outline.
    pub fn is_of_points(&self) -> bool {
        self.elements.iter().all(|element| element.contact.is_some())
    }

    /// Coordinates (3 node + component), ascending, that the structure lacks at points of contact.
    pub fn held(&self) -> Vec<usize> {
        let of_point = |element: &Element| {
            let held = element.contact.map_or([false; 3], |contact| contact.held);
            let node = element.nodes[0] as usize;
            (0..3).filter(move |&c| held[c]).map(move |c| 3 * node + c)
        };
        let mut held: Vec<usize> = self.elements.iter().flat_map(of_point).collect();
        held.sort_unstable();
        held
    }

    /// Area of each element (m^2), exact also for curved edges; of a point that which it stands for.
    pub fn areas(&self) -> Vec<f64> {
        self.elements
            .iter()
            .map(|element| {
                if let Some(contact) = element.contact {
                    return contact.area;
                }
                let (corners, middles) = (element.corners(), element.middles());
                let at = |i: usize| self.nodes[corners[i % corners.len()] as usize];
                let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - b[0] * a[1];
                let edge = |i: usize| match middles.get(i) {
                    None => cross(at(i), at(i + 1)),
                    // The integral of x dy - y dx along the parabola through the three nodes.
                    Some(&middle) => {
                        let middle = self.nodes[middle as usize];
                        (4.0 * (cross(at(i), middle) + cross(middle, at(i + 1))) - cross(at(i), at(i + 1))) / 3.0
                    }
                };
                0.5 * (0..corners.len()).map(edge).sum::<f64>()
            })
            .collect()
    }
}
