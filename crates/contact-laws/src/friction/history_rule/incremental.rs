//! The rule [`HistoryRule::Incremental`](crate::HistoryRule::Incremental): stick by the midpoint rule.
//!
//! With the begin state (index 0) and `q` in {x, y}, the midpoint rule for `dt_q = k_q(u_n) du_q` on the closed part of
//! the straight path from the begin state:
//! <div>
//! $$ t_q^{\text{trial}} = t_{q0} + f \, k_q(m) \, (u_q - u_{q0}), \qquad
//! l = \max(u_{n0}, 0), \qquad m = \frac{u_n + l}{2}, \qquad f = \frac{u_n - l}{u_n - u_{n0}} . $$
//! </div>
//!
//! `f` is the share of the path that is closed, 1 when the point was closed before. A re-contacting point sticks from
//! where its path meets `u_n = 0`. The result does not depend on the origin of the displacements.
//!
//! | derivative of the trial | |
//! |---|---|
//! | along `u_q` | `f k_q(m)` |
//! | along `u_n` | `(f' k_q(m) + f k_q'(m)/2) (u_q - u_q0)` |
//!
//! `f' = (1 - f)/(u_n - u_n0)` for a point that was open and 0 for one that was closed. The slip limit is Coulomb's.
//!
//! The rule does not derive from a potential: a stuck cycle along which `u_n` changes may gain or lose a little energy.
//!
//! Source: eqs. (17), (19), (20) of N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear
//! dynamic modeling of bolted joints: formulation, application, and trends in micro-scale interface evolution*, Mech.
//! Syst. Signal Process. 139, 2020, 106615; the midpoint in the place of (18) is this crate's.
#![doc = include_str!("../../../katex.html")]

use crate::friction::rule::{FrictionRule, Memory, Path, PathChange, StiffnessAt, StiffnessChange, Trial};
use crate::jet::Jet;
use crate::simd::bounds::bounded;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Incremental;

impl FrictionRule for Incremental {
    const MEMORY: Memory = Memory::Traction;
    const STIFFNESS: StiffnessAt = StiffnessAt::Middle;
    const CURVATURE: bool = false;

    #[inline(always)]
    fn trial(self, path: Path, k: Jet) -> Trial {
        Trial {
            traction: path.traction + path.share * k.value * path.du,
            along: path.share * k.value,
            closing: (bounded(k.value * path.share_slope) + 0.5 * path.share * k.slope) * path.du,
        }
    }

    #[inline(always)]
    fn trial_change(self, path: Path, k: Jet, change: PathChange, k_change: StiffnessChange) -> f64 {
        let stiffness = bounded(change.share * k.value) + path.share * k_change.value;
        change.traction + stiffness * path.du + path.share * k.value * change.du
    }

    #[cfg(test)]
    fn described(path: &crate::tests::described::Described<'_>) -> crate::tests::described::Quantity3 {
        path.memory + path.share * (path.k)(path.middle()).0 * path.moved
    }
}
