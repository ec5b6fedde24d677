//! Elements whose stiffness and mass are sums over quadrature points.

use super::cell::ElementType;
use super::matrices::{Jacobian, Matrices, Place, add_stiffness};
use super::quadrature::Point;
use crate::Error;

/// Stiffness and mass by quadrature of the strain and of the displacement, each with its own points.
pub(super) fn isoparametric(
    place: &Place<'_>,
    row: &ElementType,
    stiffness: &[Point],
    mass: &[Point],
) -> Result<Matrices, Error> {
    let n = row.n_nodes();
    let mut out = Matrices::zeros(n);
    let (mut values, mut derivatives) = (vec![0.0; n], vec![[0.0; 3]; n]);
    let mut gradients = Vec::with_capacity(n);
    for (number, point) in stiffness.iter().enumerate() {
        (row.interpolation)(point.at, &mut values, &mut derivatives);
        let jacobian = Jacobian::try_new(place, number, &derivatives)?;
        gradients.clear();
        gradients.extend(derivatives.iter().map(|d| jacobian.gradient(*d)));
        let weight = point.weight * jacobian.determinant;
        add_stiffness(&mut out.stiffness, &gradients, place.material.lame(), weight);
    }
    for (number, point) in mass.iter().enumerate() {
        (row.interpolation)(point.at, &mut values, &mut derivatives);
        let jacobian = Jacobian::try_new(place, number, &derivatives)?;
        out.add_mass(&values, place.material.density * point.weight * jacobian.determinant);
    }
    Ok(out)
}
