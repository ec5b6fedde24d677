//! The interface mesh: elements between two bodies, in the plane or gently curved out of it, or single points of contact.

use crate::Error;
use crate::overlap::{self, Overlap};
use crate::quadrature::Quadrature;
use std::collections::HashMap;

pub use crate::element::{Element, PointContact};

/// An interface mesh. Node `i` stands for a node of one body and for what faces it on the other: a node that coincides with it, or
/// a point of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceMesh {
    /// In-plane coordinates (x, y) of the nodes (m).
    pub nodes: Vec<[f64; 2]>,
    /// Elements.
    pub elements: Vec<Element>,
    /// Distance of each node from the plane (m); empty where the interface is flat. Areas are those of the curved elements.
    pub heights: Vec<f64>,
    /// Elements that the other body faces in part, by ascending number; all others are in contact as a whole.
    pub covered: Vec<Covered>,
}

/// The part of an element that the other body faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covered {
    /// The element.
    pub element: usize,
    /// Share of the element's area in the plane, above 0 and below 1.
    pub share: f64,
    /// Centre of area of that part in the plane (m).
    pub centroid: [f64; 2],
    /// Its second moments of area about that centre, over its area: xx, xy, yy (m^2).
    pub spread: [f64; 3],
}

impl Covered {
    /// Points and shares of the part's area of a rule with its area, centre and second moments: that of a rectangle of the same moments, from
    /// abscissae and weights on -1 to 1 (of sum 2).
    pub(crate) fn rule(&self, line: &[(f64, f64)]) -> Vec<([f64; 2], f64)> {
        let [xx, xy, yy] = self.spread;
        // Principal axes and the half edges along them.
        let (mean, difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let radius = difference.hypot(xy);
        let angle = 0.5 * xy.atan2(difference);
        let (sine, cosine) = angle.sin_cos();
        let halves = [mean + radius, mean - radius].map(|moment| (3.0 * moment.max(0.0)).sqrt());
        let along = |&(a, v): &(f64, f64), &(b, w): &(f64, f64)| {
            let (p, q) = (halves[0] * a, halves[1] * b);
            let at = [
                self.centroid[0] + cosine * p - sine * q,
                self.centroid[1] + sine * p + cosine * q,
            ];
            (at, 0.25 * v * w)
        };
        line.iter()
            .flat_map(|second| line.iter().map(move |first| along(first, second)))
            .collect()
    }
}

impl InterfaceMesh {
    /// The mesh of a flat interface whose elements are faced as a whole. Nothing is checked.
    pub fn flat(nodes: Vec<[f64; 2]>, elements: Vec<Element>) -> Self {
        Self {
            nodes,
            elements,
            heights: Vec::new(),
            covered: Vec::new(),
        }
    }

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
        let mesh = Self::flat(nodes, elements);
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
        let finite = |quantity, index, value: f64| match value.is_finite() {
            true => Ok(()),
            false => Err(Error::Value {
                quantity,
                place: "interface node",
                index,
                value,
                requirement: "finite",
            }),
        };
        for (index, x) in self.nodes.iter().enumerate() {
            x.iter().try_for_each(|&value| finite("coordinate", index, value))?;
        }
        if !self.heights.is_empty() && self.heights.len() != count {
            return Err(Error::Coverage {
                what: "heights",
                found: self.heights.len(),
                expected: count,
            });
        }
        for (index, &value) in self.heights.iter().enumerate() {
            finite("height", index, value)?;
        }
        for part in &self.covered {
            let finite = part.centroid.iter().chain(&part.spread).all(|x| x.is_finite());
            let [xx, xy, yy] = part.spread;
            let sound = part.share > 0.0 && part.share < 1.0 && finite && xx * yy > xy * xy;
            if !sound || part.element >= self.elements.len() {
                return Err(Error::Value {
                    quantity: "share in contact",
                    place: "interface element",
                    index: part.element,
                    value: part.share,
                    requirement: "above 0 and below 1, of an element that exists, with finite moments",
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
            if let Some(PointContact { area, .. }) = nodes.contact()
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
        match overlap::find(&self.nodes, &self.elements) {
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
        self.elements.iter().all(|element| element.contact().is_some())
    }

    /// Coordinates (3 node + component), ascending, that the structure lacks at points of contact.
    pub fn held(&self) -> Vec<usize> {
        let of_point = |element: &Element| {
            let held = element.contact().map_or([false; 3], |contact| contact.held);
            let node = element.nodes()[0] as usize;
            (0..3).filter(move |&c| held[c]).map(move |c| 3 * node + c)
        };
        let mut held: Vec<usize> = self.elements.iter().flat_map(of_point).collect();
        held.sort_unstable();
        held
    }

    /// Area of each element that is in contact (m^2), exact also for curved edges; of a point that which it stands for.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas: Vec<f64> = match self.heights.is_empty() {
            true => self.areas_in_plane(),
            false => {
                let finest = Quadrature::finest();
                let curved = |element| self.curved_area(element, &finest);
                self.elements.iter().map(curved).collect()
            }
        };
        for part in &self.covered {
            areas[part.element] *= part.share;
        }
        areas
    }

    /// Area of an element that leaves the plane.
    fn curved_area(&self, element: &Element, quadrature: &Quadrature) -> f64 {
        if let Some(contact) = element.contact() {
            return contact.area;
        }
        let points = quadrature.points(element.shape()).iter();
        points
            .map(|point| {
                let (_, derivatives) = element.shape().functions(point.xi);
                point.weight * self.area_density(element, &derivatives).1
            })
            .sum()
    }

    /// Derivatives of the place by the natural coordinates, in the plane and out of it, make these densities of area (m^2 per
    /// natural area): of the projection onto the plane, whose sign tells the sense, and of the curved element.
    pub(crate) fn area_density(&self, element: &Element, derivatives: &[[f64; 2]]) -> (f64, f64) {
        let mut jacobian = [[0.0; 2]; 3];
        for (derivative, &node) in derivatives.iter().zip(element.nodes()) {
            let [x, y] = self.nodes[node as usize];
            let height = self.heights.get(node as usize).copied().unwrap_or(0.0);
            for (row, value) in jacobian.iter_mut().zip([x, y, height]) {
                row[0] += value * derivative[0];
                row[1] += value * derivative[1];
            }
        }
        let minor = |a: usize, b: usize| jacobian[a][0] * jacobian[b][1] - jacobian[a][1] * jacobian[b][0];
        let plane = minor(0, 1);
        if self.heights.is_empty() {
            return (plane, plane);
        }
        (plane, plane.hypot(minor(1, 2)).hypot(minor(2, 0)))
    }

    fn areas_in_plane(&self) -> Vec<f64> {
        self.elements
            .iter()
            .map(|element| self.area_in_plane(element))
            .collect()
    }

    /// Area of an element's projection onto the plane (m^2); of a point that which it stands for.
    pub(crate) fn area_in_plane(&self, element: &Element) -> f64 {
        if let Some(contact) = element.contact() {
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
    }
}
