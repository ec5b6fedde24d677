//! Errors of this crate.

/// What can be wrong with an interface.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The mesh has no elements.
    #[error("the interface mesh has no elements")]
    Empty,
    /// An element names a node that does not exist.
    #[error("interface element {element} refers to node {node}, but there are only {count} nodes")]
    Dangling {
        /// Element.
        element: usize,
        /// Node referred to.
        node: u32,
        /// Number of nodes.
        count: usize,
    },
    /// An element has a number of nodes that no shape has.
    #[error("interface element {element} has {found} nodes; triangles have 3 or 6 and quadrilaterals 4, 8 or 9")]
    NodeCount {
        /// Element.
        element: usize,
        /// Number of its nodes.
        found: usize,
    },
    /// An element names a node twice.
    #[error("interface element {element} names node {node} twice; its nodes must differ")]
    RepeatedNode {
        /// Element.
        element: usize,
        /// The node.
        node: u32,
    },
    /// Two elements have the same nodes, so they would carry the load twice.
    #[error("interface element {element} has the nodes of element {first}; remove one of the two")]
    DuplicateElement {
        /// Element.
        element: usize,
        /// The earlier one.
        first: usize,
    },
    /// Two elements cover the same area, which would carry the load twice.
    #[error(
        "interface elements {first} and {element} overlap: both cover {shared:.3e} m^2, and at most {tolerance:e} of the smaller \
         one's area may be shared; remove one of the two, or correct their nodes"
    )]
    OverlappingElements {
        /// Element.
        element: usize,
        /// The earlier one.
        first: usize,
        /// Area that both cover (m^2).
        shared: f64,
        /// Part of the smaller area that may be shared.
        tolerance: f64,
    },
    /// A node belongs to no element, so no traction could ever reach it.
    #[error("interface node {node} belongs to no element; remove it, or add the missing element")]
    Unused {
        /// Node.
        node: usize,
    },
    /// A coordinate, a gap or an interference is not finite, or one of the latter is negative.
    #[error("{quantity} of {place} {index} is {value} m; it must be {requirement}")]
    Value {
        /// Quantity.
        quantity: &'static str,
        /// Node or point.
        place: &'static str,
        /// Its number.
        index: usize,
        /// Value (m).
        value: f64,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// An element is inverted or has no area.
    #[error(
        "interface element {element} is inverted or degenerate: area density {determinant:.3e} m^2 at point {point}; \
         order its nodes counter-clockwise and keep it convex"
    )]
    Inverted {
        /// Element.
        element: usize,
        /// Quadrature point in the element.
        point: usize,
        /// Jacobian determinant (m^2).
        determinant: f64,
    },
    /// A point of contact that stands for no area.
    #[error(
        "interface element {element} is a point of contact with an area of {area} m^2; it must be positive and finite"
    )]
    PointArea {
        /// Element.
        element: usize,
        /// Its area (m^2).
        area: f64,
    },
    /// An unsupported quadrature.
    #[error("{per_direction} quadrature points per direction are not supported; choose 1, 2, 3, 4 or 5")]
    Quadrature {
        /// Points per direction.
        per_direction: usize,
    },
    /// A law cannot be made of a static state.
    #[error(transparent)]
    Law(#[from] contact_laws::Error),
    /// Laws or gaps do not match the quadrature points.
    #[error("{what} cover {found} of the interface's {expected} quadrature points")]
    Coverage {
        /// What.
        what: &'static str,
        /// Points covered.
        found: usize,
        /// Points there are.
        expected: usize,
    },
    /// No part of one mesh faces the other.
    #[error(
        "nowhere do the two meshes face one another within {reach:.3e} m along the normal; check which faces are named, and the \
         distance that is allowed"
    )]
    NotFacing {
        /// Distance that is allowed (m).
        reach: f64,
    },
    /// An element is too distorted, or too small a part of it is faced, to project onto it.
    #[error(
        "the elements at interface node {node} are too distorted to be projected onto one another; improve the mesh there"
    )]
    Mapping {
        /// The node.
        node: usize,
    },
}
