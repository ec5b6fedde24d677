//! The rule [`HistoryRule::EndPoint`](crate::HistoryRule::EndPoint): stick with the stiffness at the end of the path.
//!
//! With the begin state (index 0) and `q` in {x, y}:
//! <div>
//! $$ t_q^{\text{trial}} = t_{q0} + k_q(u_n) \, (u_q - u_{q0}) . $$
//! </div>
//!
//! The whole path counts, also the part along which the point was open. The result does not depend on the origin of the
//! displacements.
//!
//! | derivative of the trial | |
//! |---|---|
//! | along `u_q` | `k_q` |
//! | along `u_n` | `k_q' (u_q - u_q0)` |
//!
//! The slip limit is Coulomb's.
//!
//! The rule does not derive from a potential: a stuck cycle along which `u_n` changes may gain or lose energy.
//!
//! Source: J. H. Porter and M. R. W. Brake, *Towards a predictive, physics-based friction model for the dynamics of
//! jointed structures*, Mech. Syst. Signal Process. 192 (2023) 110210, where it holds for every asperity.
#![doc = include_str!("../../../katex.html")]

use crate::friction::rule::{FrictionRule, Memory, Path, PathChange, StiffnessAt, StiffnessChange, Trial};
use crate::jet::Jet;

#[derive(Debug, Clone, Copy)]
pub(crate) struct EndPoint;

impl FrictionRule for EndPoint {
    const MEMORY: Memory = Memory::Traction;
    const STIFFNESS: StiffnessAt = StiffnessAt::End;
    const CURVATURE: bool = false;

    #[inline(always)]
    fn trial(self, path: Path, k: Jet) -> Trial {
        Trial {
            traction: path.traction + k.value * path.du,
            along: k.value,
            closing: k.slope * path.du,
        }
    }

    #[inline(always)]
    fn trial_change(self, path: Path, k: Jet, change: PathChange, k_change: StiffnessChange) -> f64 {
        change.traction + k_change.value * path.du + k.value * change.du
    }

    #[cfg(test)]
    fn described(path: &crate::tests::described::Described<'_>) -> crate::tests::described::Quantity3 {
        path.memory + (path.k)(path.u_n).0 * path.moved
    }
}
