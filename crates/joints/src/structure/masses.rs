//! Masses at positions of a mesh.

use crate::Error;
use finite_elements::mesh::PointMass;
use scenes::{Length, Mass};

/// How far a node may be from the position of its mass where nothing else is said, relative to the largest extent of the
/// structure along an axis.
const WITHIN: f64 = 0.01;

/// The masses of a scene at the nodes nearest to their positions.
///
/// # Errors
/// [`Error::NoNodeNear`].
pub(super) fn at_positions(nodes: &[[f64; 3]], masses: &[scenes::PointMass]) -> Result<Vec<PointMass>, Error> {
    let extent = |axis: usize| {
        let along = nodes.iter().map(|x| x[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let default = WITHIN * (0..3).map(extent).fold(0.0, f64::max);
    let placed = masses
        .iter()
        .enumerate()
        .filter_map(|(index, point)| Some((index, point, point.at?)));
    placed
        .map(|(index, point, at)| {
            let position = at.map(Length::si);
            let distance = |x: &[f64; 3]| x.iter().zip(position).map(|(x, p)| (x - p).powi(2)).sum::<f64>().sqrt();
            let nearest = (0_u32..)
                .zip(nodes)
                .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
            let within = point.within.map_or(default, Length::si);
            match nearest {
                Some((node, x)) if distance(x) <= within => Ok(PointMass {
                    node,
                    mass: Mass::si(point.mass),
                }),
                other => {
                    let nearest = other.map_or([f64::NAN; 3], |(_, x)| *x);
                    Err(Error::NoNodeNear {
                        number: index + 1,
                        position,
                        nearest,
                        distance: distance(&nearest),
                        within,
                    })
                }
            }
        })
        .collect()
}
