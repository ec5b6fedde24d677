//! The interface mesh: flat quadrilaterals and triangles between two bodies whose nodes coincide in pairs.

use crate::Error;

/// An interface element: node numbers in cyclic (counter-clockwise) order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// Three-node triangle.
    Tri3([u32; 3]),
    /// Four-node quadrilateral.
    Quad4([u32; 4]),
}

impl Element {
    /// Its nodes.
    pub fn nodes(&self) -> &[u32] {
        match self {
            Element::Tri3(nodes) => nodes,
            Element::Quad4(nodes) => nodes,
        }
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
    /// Checks references and coordinates; shapes are checked where quadrature points are known.
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
        }
        match used.iter().position(|used| !used) {
            Some(node) => Err(Error::Unused { node }),
            None => Ok(()),
        }
    }

    /// Area of each element (m^2) (exact for straight edges).
    pub fn areas(&self) -> Vec<f64> {
        self.elements
            .iter()
            .map(|element| {
                let corners = element.nodes();
                let at = |i: usize| self.nodes[corners[i % corners.len()] as usize];
                0.5 * (0..corners.len())
                    .map(|i| at(i)[0] * at(i + 1)[1] - at(i + 1)[0] * at(i)[1])
                    .sum::<f64>()
            })
            .collect()
    }
}
