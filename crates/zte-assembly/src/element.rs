//! Elements of an interface, and single points of contact.

use crate::shape::{MAX_NODES, POINT1, QUAD4, QUAD8, QUAD9, Shape, TRI3, TRI6};
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
    pub(crate) fn middles(&self) -> &[u32] {
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
