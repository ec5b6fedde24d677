//! The law that puts a history rule on contact curves.

use core::ops::Range;

use super::block_start::{Present, Start};
use super::cone::{BoxWorkspace, Cone, respond};
use super::history_rule::{HistoryRule, Needs};
use super::return_map::{Block, Workspace};
use super::{JUMP, MU, has_friction, require_friction};
use crate::curves::{CurveBlock, PointCurves};
use crate::error::Error;
use crate::law::{
    Components, ComponentsMut, LawInfo, PAPER_DOI, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut,
    TractionLaw, check_points,
};
use crate::parameters::PointParameters;
use crate::simd::{BLOCK, Lanes, SHORT_BLOCK, part, part_mut, run};

/// Contact curves with Coulomb friction. State per point: `u_x, u_y, u_n` (m) and `t_x, t_y` (Pa), or with
/// [`HistoryRule::Potential`] `e_x, e_y` (m).
#[derive(Debug, Clone)]
pub struct FrictionalLaw<C> {
    curves: C,
    mu: PointParameters<f64>,
    history: HistoryRule,
    cone: Cone,
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
        let info = LawInfo {
            name,
            reference,
            state: JUMP.into_iter().chain(history.needs().memory.quantities()).collect(),
            parameters: parameters.iter().cloned().chain([MU]).collect(),
        };
        Ok(Self {
            curves,
            mu,
            history,
            cone: Cone::default(),
            info,
        })
    }

    /// The same law with another cone.
    #[must_use]
    pub fn with_cone(self, cone: Cone) -> Self {
        Self { cone, ..self }
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
        let Needs {
            stiffness, curvature, ..
        } = self.history.needs();
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
        let mut in_box = (self.cone == Cone::Box).then(BoxWorkspace::new);
        let mut counts = RegimeCounts::default();
        let (mut block, mut present) = (0..0, Present::default());
        while block.end < n {
            block = block.end..n.min(block.end + B);
            let (jump, begin) = (part(&jump, &block), part(&begin, &block));
            let [end_x, end_y, end_n, end_1, end_2] = part_mut(&mut end, &block);
            run(Start {
                jump,
                begin,
                stiffness,
                u_n: &mut u_n,
                middle: &mut middle,
                end: [end_x, end_y, end_n],
                present: &mut present,
            });
            let (m, first) = (block.len(), points.start + block.start);
            if present.closed {
                let (u_n, middle) = (&u_n.0[..m], &middle.0[..m]);
                let curvature = curvature && tangent.is_some();
                self.curves
                    .evaluate(first, u_n, middle, curvature, &mut for_curves, &mut curves);
            }
            let mu = &mut mu.0[..m];
            match sticking {
                Sticking::Frictionless => mu.fill(0.0),
                Sticking::Coulomb | Sticking::Full => self.mu.copy_to(first, mu),
            }
            let block = Block {
                jump,
                begin,
                mu,
                mu_slope: mu,
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
            counts += respond(self.history, &mut in_box, block);
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

    fn friction_coefficient(&self, point: usize) -> Option<f64> {
        Some(*self.mu.at(point))
    }

    fn dissipates(&self) -> bool {
        has_friction(&self.mu)
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        self.curves.contact_area_ratio(point, u_n)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        self.curves.yielded_fraction(point, u_n, omega_c)
    }
}
