//! The rule [`HistoryRule::Paper`](crate::HistoryRule::Paper): stick as published, linearised about the end point.
//!
//! With the begin state (index 0) and `q` in {x, y}, eq. (18):
//! <div>
//! $$ t_q^{\text{trial}} = t_{q0} + k_q(u_n) \, (u_q - u_{q0}) + k_q'(u_n) \, (u_n - u_{n0}) \, u_q . $$
//! </div>
//!
//! It depends on the total displacement, so on slip in the past. The whole path counts, also the part along which the
//! point was open.
//!
//! | derivative of the trial | |
//! |---|---|
//! | along `u_q` | `k_q + k_q' (u_n - u_n0)` |
//! | along `u_n` | `k_q' (u_q - u_q0) + (k_q' + k_q'' (u_n - u_n0)) u_q` |
//!
//! The slip limit is Coulomb's.
//!
//! The rule does not derive from a potential: a stuck cycle along which `u_n` changes may gain or lose a little energy.
//!
//! Source: N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear dynamic modeling of bolted
//! joints: formulation, application, and trends in micro-scale interface evolution*, Mech. Syst. Signal Process. 139,
//! 2020, 106615, eqs. (15)-(20).
#![doc = include_str!("../../../katex.html")]

use crate::friction::rule::{FrictionRule, Memory, Path, PathChange, StiffnessAt, StiffnessChange, Trial};
use crate::jet::Jet;
use crate::simd::bounds::bounded;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Paper;

impl FrictionRule for Paper {
    const MEMORY: Memory = Memory::Traction;
    const STIFFNESS: StiffnessAt = StiffnessAt::End;
    const CURVATURE: bool = true;

    #[inline(always)]
    fn trial(self, path: Path, k: Jet) -> Trial {
        let change = bounded(k.slope * path.du_n);
        Trial {
            traction: path.traction + k.value * path.du + change * path.u,
            along: k.value + change,
            closing: k.slope * path.du + (k.slope + bounded(k.curvature * path.du_n)) * path.u,
        }
    }

    #[inline(always)]
    fn trial_change(self, path: Path, k: Jet, change: PathChange, k_change: StiffnessChange) -> f64 {
        let closing = bounded(k.slope * path.du_n);
        let closing_change = bounded(k_change.slope * path.du_n + k.slope * change.du_n);
        let moved = k_change.value * path.du + k.value * change.du;
        change.traction + moved + closing_change * path.u + closing * change.u
    }

    #[cfg(test)]
    fn described(path: &crate::tests::described::Described<'_>) -> crate::tests::described::Quantity3 {
        let (k, slope) = (path.k)(path.u_n);
        path.memory + k * path.moved + slope * path.moved_n * path.u
    }
}
