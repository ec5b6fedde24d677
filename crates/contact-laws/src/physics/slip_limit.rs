//! The largest tangential force of a single asperity.
//!
//! With the normal force `F`, the contact radius `a` and the interference `x` beyond the residual depth of
//! [one asperity](crate::elastic_plastic):
//!
//! | limit | largest tangential force `L` | parameters |
//! |---|---|---|
//! | [`Coulomb`](AsperityLimit::Coulomb) | `mu F` | friction coefficient |
//! | [`ShearStrength`](AsperityLimit::ShearStrength) | `pi a^2 sqrt((P^2 - p^2)/3)`, mean pressure `p = F/(pi a^2)`, hardness `P` | yield strength |
//! | [`Ceb`](AsperityLimit::Ceb) | `C_f F sqrt(x_m/x - 1)` | yield strength |
//!
//! # Shear strength
//! What the normal pressure leaves of the strength of a contact that the shear makes fully plastic, by the criterion of
//! von Mises. The hardness `P` is that of full plasticity at the contact radius; where `p` is above it nothing is left.
//! `L/F` falls from infinity at the first touch to what a plastic contact has left; with `p = 0.9 P` it is 0.28.
//! At first loading, with `S/E = 0.0017`, `H/E = 0.003` and `nu = 0.3`:
//!
//! | `w/delta_y` | 2 | 3 | 10 | 30 | 100 |
//! |---|---|---|---|---|---|
//! | `L/F` | 0.92 | 0.78 | 0.45 | 0.18 | 0 |
//!
//! The radius of first loading is the published one with both [`YieldCurves`](crate::YieldCurves), as the elastic one makes
//! pressures of twice the hardness; at unloading it falls from there with the root of `x`, so that `L` does not jump.
//!
//! # CEB
//! The tangential force that begins to yield a sphere in full sliding, at the depth `zeta a` where the normal force alone
//! would begin it. On the axis of the contact circle, relative to Hertz's largest pressure, the difference of the normal
//! stresses `D` and the shear stress `T` under a traction of Hertz's shape are
//! <div>
//! $$ D = \frac{1}{1 + \zeta^2} \cdot \frac{3}{2} - (1 + \nu) \left(1 - \zeta \arctan \tfrac{1}{\zeta}\right), \qquad
//! T = 1 - \tfrac{3}{2} \zeta \arctan \tfrac{1}{\zeta} + \frac{\zeta^2}{2 (1 + \zeta^2)}, \qquad
//! C_f = \frac{D}{\sqrt{3} \, T} \ \text{where } D \text{ is largest}. $$
//! </div>
//!
//! For `nu = 0.3` it is 1.26. Contact is elastic up to the interference `x_m`: that of the first yield `delta_y`, or
//! after a larger load that load's. So an asperity that carries more than ever before has no friction, and one that is
//! unloaded from there regains it with an infinite slope: `L/F` is 0.13 at 1 % and 0.42 at 10 % below `x_m`.
//!
//! # Sources
//! W. R. Chang, I. Etsion and D. B. Bogy, *Static friction coefficient model for metallic rough surfaces*, J. Tribol. 110
//! (1988) 57-63: the criterion; stresses on the axis: G. M. Hamilton, *Explicit equations for the stresses beneath a sliding
//! spherical contact*, Proc. Inst. Mech. Eng. C 197 (1983) 53-59, and K. L. Johnson, *Contact Mechanics* (1985), eq. (3.45). That the elastic
//! range grows with the largest load is not part of their model, which has no friction beyond the first yield; it follows from
//! unloading being elastic.
#![doc = include_str!("../../katex.html")]

use super::elastic_plastic::{Asperity, Dent, Plastic, Unloading};
use crate::choice::choices;
use crate::jet::Jet;
use core::f64::consts::PI;

choices! {
    /// What limits the tangential force of an asperity.
    pub enum AsperityLimit, "LIMIT", "Slip limit of an asperity" {
        Coulomb = "coulomb", 0, "A constant share of the normal force.";
        Ceb = "ceb", 1, "First yield under both forces.";
        ShearStrength = "shear-strength", 2, "The shear strength that the normal pressure leaves.";
    }
}

impl Asperity {
    /// Largest tangential force (N) at the interference `w` (m) after a past, with its derivatives with respect to `w`;
    /// `None` with Coulomb's limit and where nothing can yield. Zero without contact.
    pub fn slip_limit(&self, limit: AsperityLimit, w: f64, dent: Dent) -> Option<Jet> {
        let yielding = self.yielding()?;
        let (contact, _) = self.contact(w, dent);
        let force = contact.force;
        let zero = Jet::default();
        match limit {
            AsperityLimit::Coulomb => None,
            AsperityLimit::ShearStrength => {
                let radius = match self.unloading(dent) {
                    Some(unloading) if w <= dent.interference => {
                        let loaded = yielding.radius(self, dent.interference).value;
                        let range = dent.interference - unloading.residual_depth;
                        (Jet::variable((w - unloading.residual_depth).max(0.0)) * (1.0 / range)).power(0.5) * loaded
                    }
                    _ if w > self.onset_of_yield() => yielding.radius(self, w),
                    _ => contact.radius,
                };
                Some(self.shear_strength(yielding, radius, force))
            }
            AsperityLimit::Ceb => {
                let (depth, elastic) = match self.unloading(dent) {
                    Some(unloading) => (unloading.residual_depth, dent.interference),
                    None => (0.0, dent.interference.max(yielding.first_yield())),
                };
                let (x, x_m) = (Jet::variable(w - depth), elastic - depth);
                let left = x.power(-1.0) * x_m - Jet::constant(1.0);
                let below = w > depth && w < elastic && left.value > 0.0;
                Some(if below {
                    force * left.power(0.5) * yielding.ceb_factor()
                } else {
                    zero
                })
            }
        }
    }

    fn shear_strength(&self, yielding: &Plastic, radius: Jet, force: Jet) -> Jet {
        let area = radius * radius * PI;
        let hard = area * yielding.hardness(self.radius(), radius);
        let square = (hard * hard - force * force) * (1.0 / 3.0);
        if square.value > 0.0 {
            square.power(0.5)
        } else {
            Jet::default()
        }
    }

    /// Change of [`Self::slip_limit`] along a direction, from the changes of the interference, of the dent's interference
    /// and of how the dent unloads.
    pub(crate) fn slip_limit_change(
        &self,
        limit: AsperityLimit,
        (w, w_change): (f64, f64),
        (dent, past_change): (Dent, f64),
        change: Unloading,
    ) -> Option<f64> {
        let yielding = self.yielding()?;
        let here = self.slip_limit(limit, w, dent)?;
        let past = Jet::along(dent.interference, past_change);
        let Some(unloading) = self.unloading(dent) else {
            // The elastic range of first loading ends where the largest interference was.
            let moves = limit == AsperityLimit::Ceb && here.value > 0.0 && dent.interference > yielding.first_yield();
            let by_past = if moves {
                here.value * past_change * 0.5 / (dent.interference - w)
            } else {
                0.0
            };
            return Some(here.slope * w_change + by_past);
        };
        if w > dent.interference {
            return Some(here.slope * w_change);
        }
        if here.value <= 0.0 {
            return Some(0.0);
        }
        let depth = Jet::along(unloading.residual_depth, change.residual_depth);
        let (beyond, range) = (Jet::along(w, w_change) - depth, past - depth);
        let force = beyond.power(1.5) * Jet::along(unloading.stiffness, change.stiffness);
        Some(match limit {
            AsperityLimit::Coulomb => return None,
            AsperityLimit::ShearStrength => {
                let loaded = yielding.radius(self, dent.interference);
                let radius =
                    (beyond * range.power(-1.0)).power(0.5) * Jet::along(loaded.value, loaded.slope * past_change);
                self.shear_strength(yielding, radius, force).slope
            }
            AsperityLimit::Ceb => {
                let left = beyond.power(-1.0) * range - Jet::constant(1.0);
                (force * left.power(0.5)).slope * yielding.ceb_factor()
            }
        })
    }
}
