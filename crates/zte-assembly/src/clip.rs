//! Convex polygons in the plane, and what two of them share.

use crate::tree::{Bounded, Bounds};

/// A convex polygon with counter-clockwise corners, as part of an element.
#[derive(Debug)]
pub(crate) struct Polygon {
    /// The element it belongs to.
    pub(crate) element: usize,
    pub(crate) corners: Vec<[f64; 2]>,
    pub(crate) area: f64,
    bounds: Bounds,
}

impl Bounded for Polygon {
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
}

/// Memory for cutting.
#[derive(Debug, Default)]
pub(crate) struct Cut {
    rest: Vec<[f64; 2]>,
    next: Vec<[f64; 2]>,
}

impl Polygon {
    /// None if the corners are not those of a convex polygon, counter-clockwise.
    pub(crate) fn try_new(element: usize, corners: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let corners: Vec<[f64; 2]> = corners.collect();
        let n = corners.len();
        let convex = (0..n).all(|i| side(corners[i], corners[(i + 1) % n], corners[(i + 2) % n]) > 0.0);
        convex.then(|| Self {
            element,
            area: area(&corners),
            bounds: Bounds::around(&corners),
            corners,
        })
    }

    /// What both cover: this polygon cut along the edges of the other; fewer than three corners where they share nothing.
    pub(crate) fn shared<'c>(&self, other: &Self, cut: &'c mut Cut) -> &'c [[f64; 2]] {
        let Cut { rest, next } = cut;
        rest.clone_from(&self.corners);
        let n = other.corners.len();
        for i in 0..n {
            let (from, to) = (other.corners[i], other.corners[(i + 1) % n]);
            next.clear();
            for (j, &a) in rest.iter().enumerate() {
                let b = rest[(j + 1) % rest.len()];
                let (inside_a, inside_b) = (side(from, to, a), side(from, to, b));
                if inside_a >= 0.0 {
                    next.push(a);
                }
                if (inside_a > 0.0 && inside_b < 0.0) || (inside_a < 0.0 && inside_b > 0.0) {
                    let part = inside_a / (inside_a - inside_b);
                    next.push([0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis])));
                }
            }
            std::mem::swap(rest, next);
        }
        rest
    }
}

/// Positive where `x` is to the left of the line.
fn side(from: [f64; 2], to: [f64; 2], x: [f64; 2]) -> f64 {
    (to[0] - from[0]) * (x[1] - from[1]) - (to[1] - from[1]) * (x[0] - from[0])
}

/// About the first corner, so that the distance from the origin costs no digits; zero for fewer than three corners.
pub(crate) fn area(corners: &[[f64; 2]]) -> f64 {
    let fan = corners.windows(2).skip(1);
    0.5 * fan.map(|edge| side(corners[0], edge[0], edge[1])).sum::<f64>()
}
