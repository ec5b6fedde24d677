//! Friction coefficients of the quadrature points.

use crate::Error;
use contact_laws::PointParameters;
use scenes::{Length, Scene};

/// Friction coefficient at each point, from the scene's own and its zones.
///
/// # Errors
/// [`Error::FrictionZone`] for a zone without points and for points in two zones.
pub(super) fn coefficients(scene: &Scene, positions: &[[f64; 2]]) -> Result<PointParameters<f64>, Error> {
    if scene.interfaces.friction_zones.is_empty() {
        return Ok(PointParameters::uniform(scene.interfaces.mu, positions.len()));
    }
    let mut zone_of = vec![None; positions.len()];
    let mut mu = vec![scene.interfaces.mu; positions.len()];
    for (number, zone) in (1..).zip(&scene.interfaces.friction_zones) {
        let [x, y] = [zone.x, zone.y].map(|range| range.map(Length::si));
        let within = |range: [f64; 2], at: f64| range[0] <= at && at <= range[1];
        let mut n_points = 0;
        for (point, position) in positions.iter().enumerate() {
            if !(within(x, position[0]) && within(y, position[1])) {
                continue;
            }
            n_points += 1;
            mu[point] = zone.mu;
            if let Some(other) = zone_of[point].replace(number) {
                let at = position.map(|at| 1e3 * at);
                return Err(Error::FrictionZone {
                    number,
                    reason: format!(
                        "the point at ({:.3}, {:.3}) mm lies in number {other} too; give zones that share no point",
                        at[0], at[1]
                    ),
                });
            }
        }
        if n_points == 0 {
            let range = |axis: usize| {
                let all = positions.iter().map(|at| 1e3 * at[axis]);
                let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), at| (at.min(l), at.max(h)));
                format!("{low:.3} to {high:.3} mm")
            };
            return Err(Error::FrictionZone {
                number,
                reason: format!(
                    "no quadrature point lies in it; those of the interface have x from {} and y from {}",
                    range(0),
                    range(1)
                ),
            });
        }
    }
    Ok(PointParameters::per_point(mu))
}
