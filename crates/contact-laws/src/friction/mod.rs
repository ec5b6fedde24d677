//! Friction on top of contact curves (eqs. 18-20): stick from the state committed last, slip on the circular cone
//! `|t_t| <= mu t_n` (or in a [box](Cone)), no traction when open.
//!
//! With the begin state (index 0), the jump `u_x, u_y, u_n` and the curves `t_n(u_n)`, `k_q(u_n)`, `q` in {x, y}, the
//! stuck trial of the tangential traction follows by a [`HistoryRule`]: the [table of rules](HISTORY_RULES) has
//! them all.
//!
//! [`resolved`] applies a rule to every asperity. Two laws have no history rule: [`foundation`] slips spring by spring,
//! [`linearised`] keeps the slip limit of a static state.
//!
//! # Cone
//! <div>
//! $$ \boldsymbol{t}_t = \begin{cases}
//! \boldsymbol{t}^{\text{trial}} & |\boldsymbol{t}^{\text{trial}}| \le \mu t_n \quad \text{(stick)} \\
//! \mu t_n \, \boldsymbol{s}, \quad \boldsymbol{s} = \boldsymbol{t}^{\text{trial}} / |\boldsymbol{t}^{\text{trial}}|
//! & \text{otherwise (slip)} \\
//! \boldsymbol{0} & u_n \le 0 \quad \text{(open, with } t_n = 0 \text{)}
//! \end{cases} $$
//! </div>
//!
//! With `Potential` read `psi_n'` for `t_n`, the normal traction of the curves alone. Where the slip limit is zero
//! (`mu = 0`) every closed point slips and the tangential tangent is zero in all directions, also for a trial of zero
//! length.
//!
//! # Tangent
//! The derivative of the tractions returned, exact in every regime; not symmetric in slip. When stuck it is that of the
//! trial, in slip
//! <div>
//! $$ \mathrm{d} \boldsymbol{t}_t = \frac{\mu t_n}{|\boldsymbol{t}^{\text{trial}}|}
//! \left( \boldsymbol{I} - \boldsymbol{s} \boldsymbol{s}^{\mathsf{T}} \right) \mathrm{d} \boldsymbol{t}^{\text{trial}}
//! + \mu \, t_n'(u_n) \, \boldsymbol{s} \, \mathrm{d} u_n . $$
//! </div>
//!
//! The trial's own derivatives stand on the pages of the rules. The normal traction depends on `u_n` alone, except with
//! `Potential`.
//!
//! # Derivative along a direction
//! [`TractionLaw::derivative`](crate::TractionLaw::derivative) gives the changes of tractions and end state along a change
//! of the jump and of the begin state together. The formula is that of the tangent, with the change of the trial
//! <div>
//! $$ \mathrm{d} \boldsymbol{t}^{\text{trial}} =
//! \frac{\partial \boldsymbol{t}^{\text{trial}}}{\partial \boldsymbol{u}} \, \mathrm{d} \boldsymbol{u}
//! + \frac{\partial \boldsymbol{t}^{\text{trial}}}{\partial \boldsymbol{z}_0} \, \mathrm{d} \boldsymbol{z}_0, \qquad
//! \mathrm{d} f = \frac{(1 - f) \, \mathrm{d} u_n + f \, \mathrm{d} u_{n0}}{u_n - u_{n0}} \quad (u_{n0} < 0) $$
//! </div>
//!
//! along the whole begin state `z_0`. The share `f` of the path that is closed and the middle of the path depend on `u_n` and
//! on `u_n0`. A traction that is remembered changes as the traction does. A stretch that is remembered is `r e^trial` with
//! `r = |t|/|t^trial|`, so `de = r de^trial + dr e^trial`, and its change reaches the normal traction.
//!
//! # Energy
//! At constant `u_n` closed collinear cycles dissipate and obey Masing's rule with all rules. At changing `u_n`
//! only `Potential` never gives back more than was put in, with a commit at every step.
//!
//! # Parameters and state
//! | quantity | unit |
//! |---|---|
//! | friction coefficient `mu`, not negative, per point | 1 |
//! | state `u_x, u_y, u_n` of the point committed last | m |
//! | state `t_x, t_y`, unless the rule says otherwise | Pa |
//! | state `e_x, e_y` (`Potential`) | m |
//!
//! Source: N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear dynamic modeling of bolted
//! joints: formulation, application, and trends in micro-scale interface evolution*, Mech. Syst. Signal Process. 139,
//! 2020, 106615, eqs. (15)-(20): rule `Paper` and the cone.
//!
//! # Example
//! A point that was open by 1 um closes to 1 um while it moves along x, first by 0.2 um, then by 1 um: the rules differ
//! in where it begins to stick, and agree in slip.
//! ```
//! use contact_laws::*;
//!
//! for (history, stuck) in [
//!     (HistoryRule::Incremental, 1.5e5),
//!     (HistoryRule::Paper, 3e5),
//!     (HistoryRule::EndPoint, 3e5),
//!     (HistoryRule::Potential, 1.5e5),
//! ] {
//!     // t_n = 2 MPa at u_n = 1 um, k_x = k_y = 1.5e12 Pa/m, mu = 0.3.
//!     let curves = PointParameters::uniform(ElasticCurves::try_new(2e12, [1.5e12; 2])?, 1);
//!     let law = ElasticDryFriction::try_new(curves, PointParameters::uniform(0.3, 1), history)?;
//!     let (begin, mut end) = ([0.0, 0.0, -1e-6, 0.0, 0.0], [0.0; 5]);
//!     for (u_x, expected, slips) in [(0.2e-6, stuck, 0), (1e-6, 0.3 * 2e6, 1)] {
//!         let [mut t_x, mut t_y, mut t_n] = [[0.0]; 3];
//!         let counts = law.evaluate(
//!             0..1,
//!             Sticking::Coulomb,
//!             Components::new(&[u_x], &[0.0], &[1e-6]),
//!             StateView::new(&begin, 1, 0),
//!             StateViewMut::new(&mut end, 1, 0),
//!             ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
//!             None,
//!             None,
//!         );
//!         assert!((t_x[0] - expected).abs() < 1e-6 && counts.slip == slips);
//!     }
//! }
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

mod annuli;
mod block_start;
mod cone;
pub mod foundation;
mod frictional_law;
pub mod history_rule;
mod laws;
pub mod linearised;
pub mod radii;
pub mod resolved;
mod return_map;
pub(crate) mod rule;
pub mod shares;
pub mod similarity;

pub use cone::Cone;
pub use frictional_law::FrictionalLaw;
pub use history_rule::{HISTORY_RULES, HistoryRule, HistoryRuleInfo};
pub use laws::{AsperityLaw, ElasticDryFriction, GreenwoodWilliamsonLaw, RoughLaw, TableLaw};

use crate::error::{Error, Place};
use crate::law::Quantity;
use crate::parameters::{Bounds, Parameter, PointParameters};

/// State of the laws of this crate: first the jump committed last.
pub(crate) const JUMP: [Quantity; 3] = [
    Quantity::new("u_x", "m"),
    Quantity::new("u_y", "m"),
    Quantity::new("u_n", "m"),
];

/// Friction coefficient, as it appears in every law's parameters.
pub(crate) const MU: Quantity = COEFFICIENT.quantity();
const COEFFICIENT: Parameter = Parameter::new("mu", "1", Bounds::NotNegative);

/// Whether any point has friction.
pub(crate) fn has_friction(mu: &PointParameters<f64>) -> bool {
    !mu.is_empty() && mu.sets().iter().any(|mu| *mu != 0.0)
}

/// Refuses friction coefficients that are negative or not finite, or not one per point.
pub(crate) fn require_friction(mu: &PointParameters<f64>, n_points: usize) -> Result<(), Error> {
    if mu.len() != n_points {
        return Err(Error::Length {
            list: "mu",
            expected: n_points,
            found: mu.len(),
        });
    }
    // A uniform value needs to be looked at once only.
    for point in 0..if mu.is_uniform() { n_points.min(1) } else { n_points } {
        COEFFICIENT.check_at(Place::Point(point), *mu.at(point))?;
    }
    Ok(())
}
