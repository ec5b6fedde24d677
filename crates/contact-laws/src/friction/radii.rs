//! Microslip within one asperity: sliders at radii of the contact circle.
//!
//! With `rho = r/a`, normal force `F`, contact radius `a` and the tangential stiffness `k_t` of the whole contact, an annulus
//! has stiffness and limit per area
//! <div>
//! $$ k(\rho) = \frac{k_t}{\pi a^2} \left( 0.8709 + \frac{0.1291}{\sqrt{1 - \rho^2}} + 0.0629 \rho - 0.8915 \rho^2
//! + 0.6998 \rho^3 \right), \qquad
//! l(\rho) = \mu \frac{3 F}{2 \pi a^2} \sqrt{1 - \rho^2}, \qquad
//! T = 2 \pi \int_0^a t \, r \, dr . $$
//! </div>
//!
//! An annulus sticks with the stiffness at the end of the path, from the traction that the state committed last has at the
//! same radius: between the radii remembered tractions are interpolated linearly, at the edge of the contact and beyond they are zero.
//!
//! # Error
//! Against Mindlin's sphere at constant normal force: the loading curve relative to `mu N`, and the area of the loop relative
//! to that of the closed form, the largest error over amplitudes in ranges of the displacement of full slip.
//!
//! | radii | loading | loop, 0.1 to 0.3 | 0.3 to 1 | 1 to 2 |
//! |---|---|---|---|---|
//! | `equally_spaced(100)` | 0.2 % | 54 % | 9.6 % | 0.7 % |
//!
//! The area of small loops falls with the third power of the amplitude, so that the few radii at the rim carry all of it.
//!
//! Source: J. H. Porter and M. R. W. Brake, *Towards a predictive, physics-based friction model for the dynamics of
//! jointed structures*, Mech. Syst. Signal Process. 192 (2023) 110210.

use super::cone::Cone;
use crate::error::Error;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter};
use crate::simd::bounds::within;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Bound of tractions (Pa): their squares are finite.
const LARGEST: f64 = 1e150;

/// Most radii of a contact circle.
pub const MAX_RADII: usize = 256;

/// Quadrature over the radii of a contact circle.
#[derive(Debug, Clone, PartialEq)]
pub struct Radii {
    /// Ascending, from 0 to 1.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    rho: f64,
    /// `2 w rho`, with the weight `w` of the quadrature over `rho`.
    weight: f64,
    /// `k(rho) pi a^2/k_t`.
    stiffness: f64,
    /// `3/2 sqrt(1 - rho^2)`.
    limit: f64,
    /// One over the distance to the next node, or to the edge.
    per_width: f64,
}

impl Radii {
    /// `n` equally spaced radii from 0 to 1 and the trapezoidal rule: as published, with 100.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `n` is not from 3 to [`MAX_RADII`].
    pub fn equally_spaced(n: usize) -> Result<Self, Error> {
        let bounds = Bounds::Within([3.0, MAX_RADII as f64], "from 3 to 256");
        Parameter::new("radii", "1", bounds).check(n as f64)?;
        let spacing = 1.0 / (n - 1) as f64;
        let nodes = (0..n).map(|i| {
            // The edge carries nothing.
            let rho = if i + 1 == n { 1.0 } else { i as f64 * spacing };
            let end = if i == 0 || i + 1 == n { 0.5 } else { 1.0 };
            Node::new(rho, 2.0 * end * spacing * rho)
        });
        let mut nodes: Vec<Node> = nodes.collect();
        let ends: Vec<f64> = nodes.iter().skip(1).map(|node| node.rho).chain([1.0]).collect();
        for (node, end) in nodes.iter_mut().zip(ends) {
            node.per_width = if end > node.rho { 1.0 / (end - node.rho) } else { 0.0 };
        }
        Ok(Self { nodes })
    }

    /// Number of radii.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// False: there is at least one radius.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
}

impl Node {
    fn new(rho: f64, weight: f64) -> Self {
        let s = ((1.0 - rho) * (1.0 + rho)).sqrt();
        let edge = if s > 0.0 { 0.1291 / s } else { 0.0 };
        Self {
            rho,
            weight,
            stiffness: 0.8709 + edge + rho * (0.0629 + rho * (-0.8915 + rho * 0.6998)),
            limit: 1.5 * s,
            per_width: 0.0,
        }
    }
}

/// One asperity and its path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    /// Normal force (N).
    pub(super) force: f64,
    /// Contact radius (m) with its derivative with respect to the interference.
    pub(super) radius: [f64; 2],
    /// `k_t/a` (Pa).
    pub(super) modulus: f64,
    /// Contact radius of the state committed last (m).
    pub(super) radius_before: f64,
    /// Change of the tangential jump (m).
    pub(super) du: [f64; 2],
    /// Slip limit (N) with its derivative.
    pub(super) limit: [f64; 2],
    pub(super) cone: Cone,
    pub(super) unlimited: bool,
}

impl Circle {
    /// Nothing is left of an asperity that just touches.
    fn carries(&self) -> bool {
        PI * self.radius[0] * self.radius[0] >= f64::MIN_POSITIVE && self.force > 0.0
    }
}

/// Changes of a [`Circle`] along a direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct CircleChange {
    pub(super) radius: f64,
    pub(super) radius_before: f64,
    pub(super) du: [f64; 2],
    pub(super) limit: f64,
}

/// What an asperity answers.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reaction {
    pub(super) force: [f64; 2],
    /// Rows of the tangential forces; columns x, y, n.
    pub(super) tangent: [[f64; 3]; 2],
    /// No annulus sticks.
    pub(super) slips: bool,
}

impl Radii {
    /// Tangential force of an asperity. `before` holds the tractions remembered at the radii, `after` takes the new ones.
    pub(super) fn react(&self, circle: &Circle, before: &[[f64; 2]], after: &mut [[f64; 2]]) -> Reaction {
        let Circle {
            radius: [a, a_slope],
            modulus,
            radius_before,
            du,
            limit: [total, total_slope],
            ..
        } = *circle;
        let area = PI * a * a;
        let mut reaction = Reaction {
            slips: true,
            ..Reaction::default()
        };
        if !circle.carries() {
            after.fill([0.0; 2]);
            return reaction;
        }
        let growth = a_slope / a;
        let stretch = if radius_before > 0.0 {
            a / radius_before
        } else {
            f64::INFINITY
        };
        let [mean_limit, mean_slope] = [total, total_slope].map(|total| within(total, LARGEST) / area);
        let mean_stiffness = modulus / (PI * a);
        let mut cursor = 0;
        for (node, after) in self.nodes.iter().zip(after) {
            let (history, history_slope) = self.remembered(node.rho * stretch, &mut cursor, before);
            let k = mean_stiffness * node.stiffness;
            let limit = mean_limit * node.limit;
            let mut trial = [0.0; 2];
            // Derivatives of the trial along the interference.
            let mut closing = [0.0; 2];
            for q in 0..2 {
                trial[q] = within(history[q] + k * du[q], LARGEST);
                let moved = if stretch < f64::INFINITY {
                    history_slope[q] * node.rho * stretch
                } else {
                    0.0
                };
                closing[q] = (moved - k * du[q]) * growth;
            }
            let limit_slope = mean_slope * node.limit - 2.0 * limit * growth;
            let cut = Cut::new(circle, trial, k, closing, limit, limit_slope);
            reaction.slips &= cut.slips;
            // The outermost of equally spaced radii carries nothing and counts for nothing.
            let (t, tangent) = if node.limit > 0.0 {
                (cut.traction, cut.tangent)
            } else {
                ([0.0; 2], [[0.0; 3]; 2])
            };
            *after = t;
            let weight = area * node.weight;
            for q in 0..2 {
                reaction.force[q] += weight * t[q];
                for c in 0..3 {
                    reaction.tangent[q][c] += weight * tangent[q][c];
                }
            }
        }
        for q in 0..2 {
            reaction.tangent[q][2] += 2.0 * growth * reaction.force[q];
        }
        reaction
    }

    /// Change of the tangential force along a direction. `before` and `before_change` hold the tractions remembered at the
    /// radii and their changes, `after_change` takes those of the new ones.
    pub(super) fn change(
        &self,
        circle: &Circle,
        change: &CircleChange,
        before: &[[f64; 2]],
        before_change: &[[f64; 2]],
        after_change: &mut [[f64; 2]],
    ) -> [f64; 2] {
        let Circle {
            radius: [a, _],
            modulus,
            radius_before,
            du,
            limit: [total, _],
            ..
        } = *circle;
        let mut force_change = [0.0; 2];
        if !circle.carries() {
            after_change.fill([0.0; 2]);
            return force_change;
        }
        let area = PI * a * a;
        let growth = within(change.radius / a, LARGEST);
        let remembers = radius_before > 0.0;
        let stretch = if remembers { a / radius_before } else { f64::INFINITY };
        let stretching = if remembers {
            within(growth - change.radius_before / radius_before, LARGEST)
        } else {
            0.0
        };
        let [mean_limit, mean_change] = [total, change.limit].map(|total| within(total, LARGEST) / area);
        let mean_stiffness = modulus / (PI * a);
        let [mut cursor, mut cursor_change] = [0; 2];
        for (node, after_change) in self.nodes.iter().zip(after_change) {
            let at = node.rho * stretch;
            let (history, slope) = self.remembered(at, &mut cursor, before);
            let (history_change, _) = self.remembered(at, &mut cursor_change, before_change);
            let k = mean_stiffness * node.stiffness;
            let limit = mean_limit * node.limit;
            let trial = [0, 1].map(|q| within(history[q] + k * du[q], LARGEST));
            let trial_change = [0, 1].map(|q| {
                let moved = if stretch < f64::INFINITY { slope[q] * at } else { 0.0 };
                let stuck = history_change[q] + within(moved * stretching, LARGEST);
                within(stuck + within(k * (change.du[q] - growth * du[q]), LARGEST), LARGEST)
            });
            let limit_change = within(mean_change * node.limit - 2.0 * limit * growth, LARGEST);
            let cut = Cut::new(circle, trial, k, trial_change, limit, limit_change);
            // The outermost of equally spaced radii carries nothing and counts for nothing.
            let (t, t_change) = if node.limit > 0.0 {
                (cut.traction, cut.tangent.map(|row| row[2]))
            } else {
                ([0.0; 2], [0.0; 2])
            };
            *after_change = t_change;
            for q in 0..2 {
                force_change[q] += within(area * node.weight * (t_change[q] + 2.0 * growth * t[q]), LARGEST);
            }
        }
        force_change
    }

    /// Traction remembered at `rho` of the contact circle committed last, and its derivative with respect to `rho`.
    #[inline]
    fn remembered(&self, rho: f64, cursor: &mut usize, before: &[[f64; 2]]) -> ([f64; 2], [f64; 2]) {
        let nodes = &self.nodes;
        if !(rho < 1.0) {
            return ([0.0; 2], [0.0; 2]);
        }
        // Ascending from call to call.
        while *cursor < nodes.len() && nodes[*cursor].rho < rho {
            *cursor += 1;
        }
        match *cursor {
            0 => (before[0], [0.0; 2]),
            n => {
                let inner = &nodes[n - 1];
                let t_inner = before[n - 1];
                let t_outer = before.get(n).copied().unwrap_or([0.0; 2]);
                let slope = [0, 1].map(|q| (t_outer[q] - t_inner[q]) * inner.per_width);
                let beyond = rho - inner.rho;
                ([0, 1].map(|q| t_inner[q] + beyond * slope[q]), slope)
            }
        }
    }
}

/// A traction under its limit, with derivatives along x, y and n.
struct Cut {
    traction: [f64; 2],
    tangent: [[f64; 3]; 2],
    slips: bool,
}

impl Cut {
    fn stuck(trial: [f64; 2], k: f64, closing: [f64; 2]) -> Self {
        Self {
            traction: trial,
            tangent: [[k, 0.0, closing[0]], [0.0, k, closing[1]]],
            slips: false,
        }
    }

    #[inline]
    fn new(circle: &Circle, trial: [f64; 2], k: f64, closing: [f64; 2], limit: f64, limit_slope: f64) -> Self {
        let stuck = Self::stuck(trial, k, closing);
        match circle.cone {
            _ if circle.unlimited => stuck,
            Cone::Box => {
                let mut cut = stuck;
                for q in 0..2 {
                    if trial[q].abs() > limit {
                        cut.slips = true;
                        cut.traction[q] = limit.copysign(trial[q]);
                        cut.tangent[q] = [0.0, 0.0, limit_slope.copysign(trial[q] * limit_slope)];
                    }
                }
                cut
            }
            Cone::Circle => {
                let square = trial[0] * trial[0] + trial[1] * trial[1];
                if square <= limit * limit && limit > 0.0 {
                    return stuck;
                }
                let per_length = if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 };
                let d = trial.map(|t| t * per_length);
                let ratio = limit * per_length;
                let across = [
                    [ratio * d[1] * d[1], -ratio * d[0] * d[1]],
                    [-ratio * d[0] * d[1], ratio * d[0] * d[0]],
                ];
                Self {
                    traction: d.map(|d| limit * d),
                    tangent: [0, 1].map(|q| {
                        [
                            across[q][0] * k,
                            across[q][1] * k,
                            across[q][0] * closing[0] + across[q][1] * closing[1] + limit_slope * d[q],
                        ]
                    }),
                    slips: true,
                }
            }
        }
    }
}
