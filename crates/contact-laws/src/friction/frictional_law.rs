//! The law that puts a history rule on contact curves.

use core::ops::Range;

use super::block_start::{Present, Start};
use super::cone::{BoxWorkspace, Cone, respond};
use super::history_rule::{HistoryRule, Needs};
use super::return_map::{Block, CurveChange, Derivative, Workspace};
use super::rule::StiffnessAt;
use super::{JUMP, MU, has_friction, require_friction};
use crate::curves::{CurveBlock, PointCurves};
use crate::error::Error;
use crate::law::{
    Along, Components, ComponentsMut, LawInfo, PAPER_DOI, Regime, RegimeCounts, StateView, StateViewMut, Sticking,
    TangentMut, TractionLaw, evaluates_by,
};
use crate::parameters::{Parameter, PointParameters};
use crate::simd::bounds::{bounded, is_finite};
use crate::simd::{Lanes, Pass, part, part_mut, run};

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
            parameters: parameters.iter().map(Parameter::quantity).chain([MU]).collect(),
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

    /// [`TractionLaw::evaluate`] or, along a direction, [`TractionLaw::derivative`] in blocks of `B` points.
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
        along: Option<Along<'_>>,
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
        let mut along = along.map(|along| Blocks {
            d_jump: [along.d_jump.x, along.d_jump.y, along.d_jump.n],
            d_begin: along.d_begin.components::<5>(n),
            d_end: along.d_end.components::<5>(n),
            d_traction: [along.d_traction.x, along.d_traction.y, along.d_traction.n],
            curves: CurveChange::<B>::new(),
        });
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
                let curvature = curvature && (tangent.is_some() || along.is_some());
                self.curves
                    .evaluate(first, u_n, middle, curvature, &mut for_curves, &mut curves);
            }
            let mu = &mut mu.0[..m];
            match sticking {
                Sticking::Frictionless => mu.fill(0.0),
                Sticking::Coulomb | Sticking::Full => self.mu.copy_to(first, mu),
            }
            let derivative = along
                .as_mut()
                .map(|along| along.derivative(&block, stiffness, mu, &u_n, begin[2], &curves));
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
                derivative,
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

    evaluates_by!(evaluate_blocks in blocks);

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

/// The components of [`Along`], block by block.
struct Blocks<'a, const B: usize> {
    d_jump: [&'a [f64]; 3],
    d_begin: [&'a [f64]; 5],
    d_end: [&'a mut [f64]; 5],
    d_traction: [&'a mut [f64]; 3],
    curves: CurveChange<B>,
}

impl<const B: usize> Blocks<'_, B> {
    /// Changes of the curves of a block, and of the jump as part of the end state.
    fn derivative(
        &mut self,
        block: &Range<usize>,
        stiffness: StiffnessAt,
        mu: &[f64],
        u_n: &Lanes<f64, B>,
        u_n0: &[f64],
        curves: &CurveBlock<B>,
    ) -> Derivative<'_, B> {
        let (jump, begin) = (part(&self.d_jump, block), part(&self.d_begin, block));
        let [end_x, end_y, end_n, end_1, end_2] = part_mut(&mut self.d_end, block);
        run(StartChanges {
            jump,
            begin,
            halfway: stiffness == StiffnessAt::Middle,
            mu,
            u_n,
            u_n0,
            curves,
            changes: &mut self.curves,
            end: [end_x, end_y, end_n],
        });
        Derivative {
            jump,
            begin,
            curves: &self.curves,
            memory: [end_1, end_2],
            traction: part_mut(&mut self.d_traction, block),
        }
    }
}

/// Changes of curves that depend on the interferences alone, as [`Start`] takes these.
struct StartChanges<'a, const B: usize> {
    jump: [&'a [f64]; 3],
    begin: [&'a [f64]; 5],
    /// Whether the stiffnesses are those halfway along the closed part of the path.
    halfway: bool,
    mu: &'a [f64],
    u_n: &'a Lanes<f64, B>,
    u_n0: &'a [f64],
    curves: &'a CurveBlock<B>,
    changes: &'a mut CurveChange<B>,
    end: [&'a mut [f64]; 3],
}

impl<const B: usize> Pass for StartChanges<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let ([x, y, n], [x_0, y_0, n_0, memory_1, memory_2]) = (self.jump, self.begin);
        let [end_x, end_y, end_n] = self.end;
        let CurveChange {
            normal,
            limit,
            tangential: [k_x, k_y],
            tangential_slope: [slope_x, slope_y],
            fill,
        } = self.changes;
        start_changes(
            self.halfway,
            x,
            y,
            n,
            x_0,
            y_0,
            n_0,
            memory_1,
            memory_2,
            self.mu,
            self.u_n,
            self.u_n0,
            self.curves,
            normal,
            limit,
            k_x,
            k_y,
            slope_x,
            slope_y,
            fill,
            end_x,
            end_y,
            end_n,
        );
    }
}

/// [`StartChanges`].
#[inline(always)]
fn start_changes<const B: usize>(
    halfway: bool,
    change_x: &[f64],
    change_y: &[f64],
    change_n: &[f64],
    change_x0: &[f64],
    change_y0: &[f64],
    change_n0: &[f64],
    change_1: &[f64],
    change_2: &[f64],
    mu: &[f64],
    u_n: &Lanes<f64, B>,
    u_n0: &[f64],
    curves: &CurveBlock<B>,
    normal: &mut Lanes<f64, B>,
    limit: &mut Lanes<f64, B>,
    k_x: &mut Lanes<f64, B>,
    k_y: &mut Lanes<f64, B>,
    slope_x: &mut Lanes<f64, B>,
    slope_y: &mut Lanes<f64, B>,
    fill: &mut Lanes<f64, B>,
    end_x: &mut [f64],
    end_y: &mut [f64],
    end_n: &mut [f64],
) {
    let n = change_x.len().min(B);
    let (change_x, change_y, change_n) = (&change_x[..n], &change_y[..n], &change_n[..n]);
    let (change_x0, change_y0, change_n0) = (&change_x0[..n], &change_y0[..n], &change_n0[..n]);
    let (change_1, change_2, mu, u_n0) = (&change_1[..n], &change_2[..n], &mu[..n], &u_n0[..n]);
    let (end_x, end_y, end_n) = (&mut end_x[..n], &mut end_y[..n], &mut end_n[..n]);
    let [stiffness_x, stiffness_y] = &curves.tangential_slope;
    let [curvature_x, curvature_y] = &curves.tangential_curvature;
    for i in 0..n {
        let finite = is_finite([
            change_x[i],
            change_y[i],
            change_n[i],
            change_x0[i],
            change_y0[i],
            change_n0[i],
            change_1[i],
            change_2[i],
        ]);
        let spoilt = if finite { 0.0 } else { f64::NAN };
        // NaN as well where jump or begin state are no numbers.
        let all = spoilt + 0.0 * u_n.0[i];
        end_x[i] = change_x[i] + all;
        end_y[i] = change_y[i] + all;
        end_n[i] = change_n[i] + all;
        fill.0[i] = spoilt;
        let closing = bounded(change_n[i]);
        let from = if u_n0[i] < 0.0 { 0.0 } else { bounded(change_n0[i]) };
        let middle = if halfway { 0.5 * closing + 0.5 * from } else { closing };
        let pressing = bounded(curves.normal_slope.0[i]) * closing;
        normal.0[i] = pressing;
        limit.0[i] = mu[i] * bounded(pressing);
        k_x.0[i] = bounded(stiffness_x.0[i]) * middle;
        k_y.0[i] = bounded(stiffness_y.0[i]) * middle;
        slope_x.0[i] = bounded(curvature_x.0[i]) * middle;
        slope_y.0[i] = bounded(curvature_y.0[i]) * middle;
    }
}
