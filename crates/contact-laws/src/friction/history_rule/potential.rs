//! The rule [`HistoryRule::Potential`](crate::HistoryRule::Potential): tractions from a potential of the elastic
//! stretch.
//!
//! The stored energy per area, with the elastic stretch `e` (m) as state in place of the traction, is
//! <div>
//! $$ \psi = \psi_n(u_n) + \tfrac{1}{2} \left( k_x(u_n) \, e_x^2 + k_y(u_n) \, e_y^2 \right),
//! \qquad \psi_n' = \text{the normal traction of the curves}. $$
//! </div>
//!
//! Both tractions are its derivatives: the normal traction answers the change of the tangential stiffness. The stuck
//! trial moves the stretch by the closed share `f` of the straight path from the begin state (index 0), and slip
//! shortens it:
//! <div>
//! $$ e_q^{\text{trial}} = e_{q0} + f \, (u_q - u_{q0}), \qquad
//! f = \frac{u_n - \max(u_{n0}, 0)}{u_n - u_{n0}}, \qquad
//! t_q = k_q(u_n) \, e_q, \qquad
//! t_n = \psi_n'(u_n) + \tfrac{1}{2} \left( k_x'(u_n) \, e_x^2 + k_y'(u_n) \, e_y^2 \right) . $$
//! </div>
//!
//! `f` is 1 when the point was closed before. An open point has no stretch. The slip limit is Coulomb's with `psi_n'`,
//! not the whole `t_n`; both components of the stretch are shortened by the ratio of the traction to its trial.
//!
//! | derivative of the trial | |
//! |---|---|
//! | along `u_q` | `f k_q` |
//! | along `u_n` | `k_q' e_q + k_q f' (u_q - u_q0)` |
//!
//! `f' = (1 - f)/(u_n - u_n0)` for a point that was open and 0 for one that was closed. The row of the normal traction
//! follows from the stretch by the chain rule; the stuck tangent of a point that was closed is symmetric.
//!
//! With a commit at every step no closed path gains energy, also through changing `u_n` and opening. In every step the
//! traction along the slip, `t_t . (du - de)`, is not negative. With a commit at load reversals only this is not
//! guaranteed, since a point may reverse on its own.
#![doc = include_str!("../../../katex.html")]

use crate::friction::rule::{
    FrictionRule, Memory, NormalAddition, Path, PathChange, StiffnessAt, StiffnessChange, Trial,
};
use crate::jet::Jet;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Potential;

impl FrictionRule for Potential {
    const MEMORY: Memory = Memory::Stretch;
    const STIFFNESS: StiffnessAt = StiffnessAt::End;
    const CURVATURE: bool = true;

    #[inline(always)]
    fn trial(self, path: Path, k: Jet) -> Trial {
        Trial {
            traction: k.value * path.stretch,
            along: path.share * k.value,
            closing: k.slope * path.stretch + k.value * path.stretch_slope,
        }
    }

    #[inline(always)]
    fn trial_change(self, path: Path, k: Jet, change: PathChange, k_change: StiffnessChange) -> f64 {
        k_change.value * path.stretch + k.value * change.stretch
    }

    #[inline(always)]
    fn normal_addition(self, [e_x, e_y]: [f64; 2], [k_x, k_y]: [Jet; 2]) -> NormalAddition {
        NormalAddition {
            value: 0.5 * (k_x.slope * e_x * e_x + k_y.slope * e_y * e_y),
            along: [k_x.slope * e_x, k_y.slope * e_y],
            closing: 0.5 * (k_x.curvature * e_x * e_x + k_y.curvature * e_y * e_y),
        }
    }

    #[cfg(test)]
    fn described(path: &crate::tests::described::Described<'_>) -> crate::tests::described::Quantity3 {
        (path.k)(path.u_n).0 * (path.memory + path.share * path.moved)
    }
}
