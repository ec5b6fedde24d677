//! What products with `Q` and `T` do entry by entry. Shape functions depend on the reference element alone, so one small
//! dense matrix per shape serves all elements.

use crate::quadrature::Quadrature;
use crate::shape::Shape;

/// Shape functions of a reference element at its quadrature points.
#[derive(Clone, Debug)]
pub(crate) struct ShapeValues {
    pub(crate) shape: &'static Shape,
    /// `N_a`, one row per point.
    pub(crate) values: Vec<f64>,
    /// `N_a N_b` of all pairs, one row per point.
    pub(crate) products: Vec<f64>,
}

impl ShapeValues {
    pub(crate) fn new(quadrature: &Quadrature, shape: &'static Shape) -> Self {
        Self::at(shape, quadrature.points(shape).iter().map(|point| point.xi))
    }

    /// At these natural coordinates.
    pub(crate) fn at(shape: &'static Shape, points: impl Iterator<Item = [f64; 2]>) -> Self {
        let (mut values, mut products) = (Vec::new(), Vec::new());
        for xi in points {
            let (row, _) = shape.functions(xi);
            for b in 0..row.len() {
                products.extend(row[..=b].iter().map(|value| value * row[b]));
            }
            values.extend(row);
        }
        Self {
            shape,
            values,
            products,
        }
    }
}
