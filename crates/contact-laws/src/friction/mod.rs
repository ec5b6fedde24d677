//! Coulomb friction on top of contact curves (eqs. 18-20): stick from the state committed last, slip on the circular
//! cone `|t_t| <= mu t_n`, no traction when open.
//!
//! With the begin state (index 0), the jump `u_x, u_y, u_n` and the curves `t_n(u_n)`, `k_q(u_n)`, `q` in {x, y}, the
//! stuck trial of the tangential traction follows by one of three [`HistoryRule`]s.
//!
//! # Incremental
//! The midpoint rule for `dt_q = k_q(u_n) du_q` on the closed part of the straight path from the begin state:
//! <div>
//! $$ t_q^{\text{trial}} = t_{q0} + f \, k_q(m) \, (u_q - u_{q0}), \qquad
//! l = \max(u_{n0}, 0), \qquad m = \frac{u_n + l}{2}, \qquad f = \frac{u_n - l}{u_n - u_{n0}} . $$
//! </div>
//!
//! `f` is the share of the path that is closed, 1 when the point was closed before. A re-contacting point sticks from
//! where its path meets `u_n = 0`. The result does not depend on the origin of the displacements.
//!
//! # Paper
//! As published (eq. 18), linearised about the end point:
//! <div>
//! $$ t_q^{\text{trial}} = t_{q0} + k_q(u_n) \, (u_q - u_{q0}) + k_q'(u_n) \, (u_n - u_{n0}) \, u_q . $$
//! </div>
//!
//! It depends on the total displacement, so on slip in the past. The whole path counts, also the part along which the
//! point was open.
//!
//! # Potential
//! The stored energy per area, with the elastic stretch `e` (m) as state in place of the traction, is
//! <div>
//! $$ \psi = \psi_n(u_n) + \tfrac{1}{2} \left( k_x(u_n) \, e_x^2 + k_y(u_n) \, e_y^2 \right),
//! \qquad \psi_n' = \text{the normal traction of the curves}. $$
//! </div>
//!
//! Both tractions are its derivatives: the normal traction answers the change of the tangential stiffness. The stuck
//! trial moves the stretch by the closed share `f` of the path, as above, and slip shortens it:
//! <div>
//! $$ e_q^{\text{trial}} = e_{q0} + f \, (u_q - u_{q0}), \qquad
//! t_q = k_q(u_n) \, e_q, \qquad
//! t_n = \psi_n'(u_n) + \tfrac{1}{2} \left( k_x'(u_n) \, e_x^2 + k_y'(u_n) \, e_y^2 \right) . $$
//! </div>
//!
//! An open point has no stretch. The cone uses `psi_n'`, not the whole `t_n`.
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
//! With `Potential` read `psi_n'` for `t_n`; both components of the stretch are shortened by the ratio of the traction
//! to its trial. Where the slip limit is zero (`mu = 0`) every closed point slips and the tangential tangent is zero in
//! all directions, also for a trial of zero length.
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
//! The trial's own derivatives, with `f' = (1 - f)/(u_n - u_n0)` for a point that was open and 0 for one that was
//! closed:
//!
//! | rule | along `u_q` | along `u_n` |
//! |---|---|---|
//! | `Incremental` | `f k_q(m)` | `(f' k_q(m) + f k_q'(m)/2) (u_q - u_q0)` |
//! | `Paper` | `k_q + k_q' (u_n - u_n0)` | `k_q' (u_q - u_q0) + (k_q' + k_q'' (u_n - u_n0)) u_q` |
//! | `Potential` | `f k_q` | `k_q' e_q + k_q f' (u_q - u_q0)` |
//!
//! The normal traction depends on `u_n` alone, except with `Potential`, where its row follows from `e_q` by the chain
//! rule; there the stuck tangent of a point that was closed is symmetric.
//!
//! # Energy
//! - `Potential` with a commit at every step: no closed path gains energy, also through changing `u_n` and opening. In
//!   every step the traction along the slip, `t_t . (du - de)`, is not negative. With a commit at load reversals only
//!   this is not guaranteed, since a point may reverse on its own.
//! - `Incremental` and `Paper` do not derive from a potential: a stuck cycle along which `u_n` changes may gain or lose
//!   a little energy.
//! - At constant `u_n` closed collinear cycles dissipate and obey Masing's rule with all three.
//!
//! # Parameters and state
//! | quantity | unit |
//! |---|---|
//! | friction coefficient `mu`, not negative, per point | 1 |
//! | state `u_x, u_y, u_n` of the point committed last | m |
//! | state `t_x, t_y` (`Incremental`, `Paper`) | Pa |
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

pub mod linearised;
pub mod mindlin_iwan;
mod return_map;

use core::ops::Range;

use crate::curves::{CurveBlock, PointCurves};
use crate::error::{Error, Place, require};
use crate::friction::return_map::{Block, INCREMENTAL, PAPER, POTENTIAL, Present, Start, Workspace};
use crate::law::{
    Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut,
    TractionLaw, check_points,
};
use crate::parameters::PointParameters;
use crate::simd::{BLOCK, Lanes, SHORT_BLOCK, run};

/// Reference of eqs. (18)-(20), (28), (29), (45).
pub(crate) const PAPER_DOI: &str = "10.1016/j.ymssp.2020.106615";

/// State of the laws of this crate: first the jump committed last.
pub(crate) const JUMP: [Quantity; 3] = [
    Quantity::new("u_x", "m"),
    Quantity::new("u_y", "m"),
    Quantity::new("u_n", "m"),
];
const TRACTION: [Quantity; 2] = [Quantity::new("t_x", "Pa"), Quantity::new("t_y", "Pa")];
const STRETCH: [Quantity; 2] = [Quantity::new("e_x", "m"), Quantity::new("e_y", "m")];

/// Friction coefficient, as it appears in every law's parameters.
pub(crate) const MU: Quantity = Quantity::new("mu", "1");

/// How the stuck traction follows from the state committed last; see the [module](self).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum HistoryRule {
    /// Midpoint rule along the closed part of the path.
    #[default]
    Incremental,
    /// As published: linearised about the end point, with the total displacement.
    Paper,
    /// From a potential, with the elastic stretch as state.
    Potential,
}

/// Contact curves with Coulomb friction. State per point: `u_x, u_y, u_n` (m) and `t_x, t_y` (Pa), or with
/// [`HistoryRule::Potential`] `e_x, e_y` (m).
#[derive(Debug, Clone)]
pub struct FrictionalLaw<C> {
    curves: C,
    mu: PointParameters<f64>,
    history: HistoryRule,
    info: LawInfo,
}

impl<C: PointCurves> FrictionalLaw<C> {
    /// A law over `curves.len()` points with the friction coefficient `mu` per point.
    ///
    /// # Errors
    /// [`Error::Length`] when `mu` has another number of points, [`Error::Parameter`] when a coefficient is negative or
    /// not finite.
    pub fn try_new(curves: C, mu: PointParameters<f64>, history: HistoryRule) -> Result<Self, Error> {
        require_friction(&mu, curves.len())?;
        let (name, reference, parameters) = match curves.info() {
            None => ("no points", PAPER_DOI, &[][..]),
            Some(info) => (info.name, info.reference, info.parameters),
        };
        let memory = match history {
            HistoryRule::Incremental | HistoryRule::Paper => TRACTION,
            HistoryRule::Potential => STRETCH,
        };
        let info = LawInfo {
            name,
            reference,
            state: JUMP.into_iter().chain(memory).collect(),
            parameters: parameters.iter().cloned().chain([MU]).collect(),
        };
        Ok(Self {
            curves,
            mu,
            history,
            info,
        })
    }

    /// The curves of every point.
    pub fn curves(&self) -> &C {
        &self.curves
    }

    /// The friction coefficients.
    pub fn mu(&self) -> &PointParameters<f64> {
        &self.mu
    }

    /// The history rule.
    pub fn history(&self) -> HistoryRule {
        self.history
    }

    /// [`TractionLaw::evaluate`] in blocks of `B` points.
    fn evaluate_blocks<const B: usize>(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
        mut regimes: Option<&mut [Regime]>,
    ) -> RegimeCounts {
        let n = points.len();
        let (jump, begin) = ([jump.x, jump.y, jump.n], begin.components::<5>(n));
        let (mut end, mut traction) = (end.components::<5>(n), [traction.x, traction.y, traction.n]);
        let mut tangent = tangent.map(TangentMut::into_entries);
        let (mut for_curves, mut curves, mut workspace) = (
            C::Workspace::<B>::default(),
            CurveBlock::<B>::new(),
            Workspace::<B>::new(),
        );
        let (mut u_n, mut middle, mut mu) = (Lanes([0.0; B]), Lanes([0.0; B]), Lanes([0.0; B]));
        let mut counts = RegimeCounts::default();
        let (mut block, mut present) = (0..0, Present::default());
        while block.end < n {
            block = block.end..n.min(block.end + B);
            let (jump, begin) = (part(&jump, &block), part(&begin, &block));
            let [end_x, end_y, end_n, end_1, end_2] = part_mut(&mut end, &block);
            run(Start {
                jump,
                begin,
                halfway: self.history == HistoryRule::Incremental,
                u_n: &mut u_n,
                middle: &mut middle,
                end: [end_x, end_y, end_n],
                present: &mut present,
            });
            let (m, first) = (block.len(), points.start + block.start);
            if present.closed {
                let (u_n, middle) = (&u_n.0[..m], &middle.0[..m]);
                let curvature = tangent.is_some() && self.history != HistoryRule::Incremental;
                self.curves
                    .evaluate(first, u_n, middle, curvature, &mut for_curves, &mut curves);
            }
            let mu = &mut mu.0[..m];
            self.mu.copy_to(first, mu);
            let block = Block {
                jump,
                begin,
                mu,
                u_n: &u_n,
                present,
                curves: &curves,
                sticking,
                workspace: &mut workspace,
                memory: [end_1, end_2],
                traction: part_mut(&mut traction, &block),
                tangent: tangent.as_mut().map(|tangent| part_mut(tangent, &block)),
                regimes: regimes.as_mut().map(|regimes| &mut regimes[block.clone()]),
            };
            counts += match self.history {
                HistoryRule::Incremental => block.respond::<INCREMENTAL>(),
                HistoryRule::Paper => block.respond::<PAPER>(),
                HistoryRule::Potential => block.respond::<POTENTIAL>(),
            };
        }
        counts
    }
}

impl<C: PointCurves> TractionLaw for FrictionalLaw<C> {
    fn info(&self) -> &LawInfo {
        &self.info
    }

    fn len(&self) -> usize {
        self.curves.len()
    }

    fn evaluate(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
        regimes: Option<&mut [Regime]>,
    ) -> RegimeCounts {
        check_points(&points, self);
        if points.len() <= SHORT_BLOCK {
            self.evaluate_blocks::<SHORT_BLOCK>(points, sticking, jump, begin, end, traction, tangent, regimes)
        } else {
            self.evaluate_blocks::<BLOCK>(points, sticking, jump, begin, end, traction, tangent, regimes)
        }
    }

    fn dissipates(&self) -> bool {
        let different = if self.mu.is_uniform() {
            self.mu.len().min(1)
        } else {
            self.mu.len()
        };
        (0..different).any(|point| *self.mu.at(point) != 0.0)
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        self.curves.contact_area_ratio(point, u_n)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        self.curves.yielded_fraction(point, u_n, omega_c)
    }
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
        let value = *mu.at(point);
        let ok = value.is_finite() && value >= 0.0;
        require(
            ok,
            "mu",
            value,
            "(no unit)",
            Place::Point(point),
            "finite and not negative",
        )?;
    }
    Ok(())
}

/// The numbers of a block in each slice.
#[inline]
fn part<'a, const N: usize>(slices: &[&'a [f64]; N], block: &Range<usize>) -> [&'a [f64]; N] {
    let mut parts: [&[f64]; N] = [&[]; N];
    for (part, slice) in parts.iter_mut().zip(slices) {
        *part = &slice[block.clone()];
    }
    parts
}

/// Like [`part`], to be written.
#[inline]
fn part_mut<'a, const N: usize>(slices: &'a mut [&mut [f64]; N], block: &Range<usize>) -> [&'a mut [f64]; N] {
    let mut parts: [&mut [f64]; N] = core::array::from_fn(|_| -> &mut [f64] { &mut [] });
    for (part, slice) in parts.iter_mut().zip(slices) {
        *part = &mut slice[block.clone()];
    }
    parts
}
