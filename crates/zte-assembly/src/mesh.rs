//! The interface mesh: flat quadrilaterals and triangles between two bodies whose nodes coincide in pairs.

/// An interface element: node numbers in cyclic (counter-clockwise) order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// Three-node triangle.
    Tri3([u32; 3]),
    /// Four-node quadrilateral.
    Quad4([u32; 4]),
}

/// A flat interface mesh. Node `i` stands for a pair of coinciding nodes, one on each body.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceMesh {
    /// In-plane coordinates (x, y) of the nodes [m].
    pub nodes: Vec<[f64; 2]>,
    /// Elements.
    pub elements: Vec<Element>,
}
