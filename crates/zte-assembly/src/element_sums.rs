//! Sums over the nodes and over the quadrature points of one element: what products with `Q` and `T` do entry by entry.
//! Shape functions depend on the reference element alone, so one small dense matrix per shape serves all elements.

use crate::mesh::Element;
use crate::quadrature::{Quadrature, shape};

/// Unordered pairs of an element's nodes.
pub(crate) const PAIRS: usize = 10;

/// Number of the pair of nodes `a` and `b`.
pub(crate) const PAIR: [[usize; 4]; 4] = [[0, 1, 3, 6], [1, 2, 4, 7], [3, 4, 5, 8], [6, 7, 8, 9]];

/// Shape functions of a reference element at its quadrature points; those of a triangle's missing node are zero.
#[derive(Clone, Debug)]
pub(crate) struct ShapeValues {
    /// `N_a`, one row per point.
    pub(crate) values: Vec<[f64; 4]>,
    /// `N_a N_b`, one row per point.
    pub(crate) products: Vec<[f64; PAIRS]>,
}

impl ShapeValues {
    pub(crate) fn new(quadrature: &Quadrature, element: &Element) -> Self {
        let points = quadrature.points(element).iter();
        let values: Vec<_> = points.map(|point| shape(element, point.xi).0).collect();
        let products = values.iter().map(|row| {
            let mut products = [0.0; PAIRS];
            for a in 0..4 {
                for b in a..4 {
                    products[PAIR[a][b]] = row[a] * row[b];
                }
            }
            products
        });
        Self {
            products: products.collect(),
            values,
        }
    }
}

/// `sum_a N_a u_a` at each point, from the jumps x, y, n of the nodes.
pub(crate) fn interpolate(values: &[[f64; 4]], nodal: [[f64; 3]; 4], x: &mut [f64], y: &mut [f64], n: &mut [f64]) {
    for (((row, x), y), n) in values.iter().zip(x).zip(y).zip(n) {
        let at = |c: usize| row[0] * nodal[0][c] + row[1] * nodal[1][c] + row[2] * nodal[2][c] + row[3] * nodal[3][c];
        *x = at(0);
        *y = at(1);
        *n = at(2);
    }
}

/// `sum_p B_pk w_p f_p` of each field `f` for all `k`, in the order of the points.
///
/// The sums run side by side: vectorised without a change to the order of any.
pub(crate) fn integrate<const K: usize, const M: usize>(
    rows: &[[f64; K]],
    weights: &[f64],
    fields: [&[f64]; M],
) -> [[f64; K]; M] {
    let mut sums = [[0.0; K]; M];
    let n = rows.len();
    let weights = &weights[..n];
    let fields = fields.map(|field| &field[..n]);
    for p in 0..n {
        for m in 0..M {
            let weighted = weights[p] * fields[m][p];
            for k in 0..K {
                sums[m][k] += weighted * rows[p][k];
            }
        }
    }
    sums
}
