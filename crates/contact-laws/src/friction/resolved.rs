//! Friction resolved over asperities: a population in [bins](crate::AsperityBins), each with a history of its own.
//!
//! [`FrictionalLaw`](crate::FrictionalLaw) limits the sum of a point's tangential forces by the sum of its normal
//! forces: nothing slips until everything does. But asperities that touch late carry little load, so they slip early,
//! and a point dissipates long before it slips as a whole.
//!
//! With the gap `g_j` and the number per area `n_j` of bin `j`, and the interference `w_j = u_n - g_j` of its asperities,
//! <div>
//! $$ t_n = \sum_j n_j F_j(w_j), \qquad \boldsymbol{t}_t = \sum_j n_j \boldsymbol{T}_j, \qquad
//! k_j = \frac{2 E}{(2 - \nu)(1 + \nu)} \, a_j(w_j), \qquad |\boldsymbol{T}_j| \le \mu F_j . $$
//! </div>
//!
//! Normal force `F` and contact radius `a` are those of [one asperity](crate::elastic_plastic), elastic or with yield and
//! unloading. How the tangential force `T_j` follows from the history is the [`HistoryRule`], with forces in the place of
//! tractions and the interference beyond the residual depth in the place of `u_n`; its limit is a [`Cone`]. Or every
//! asperity slips from its rim inwards ([`AsperityFriction::Annuli`], [`AsperityFriction::MindlinIwan`],
//! [`radii`](super::radii)). In the place of `mu F_j` asperities that yield can have a [limit](crate::slip_limit) that follows
//! from their strength.
//!
//! # Exponential gaps
//! The number of asperities of an exponential tail of heights falls with the interference as `exp(-w/s)`. Where all have been
//! moved by `d` at constant `u_n`, far from the first touch, those with `w < c d` slip, `c = k_j w/(F_j mu)`, and
//! <div>
//! $$ \frac{t_t}{\mu t_n} = 1 - Q\left(\tfrac{5}{2}, z\right) + z \, Q\left(\tfrac{3}{2}, z\right)
//! \frac{\Gamma(3/2)}{\Gamma(5/2)}, \qquad z = \frac{c d}{s}, \qquad
//! c = \frac{3}{2} \, \frac{2 (1 - \nu)}{(2 - \nu) \mu} , $$
//! </div>
//!
//! with the regularised upper incomplete gamma function `Q`.
//!
//! # Derivative along a direction
//! [`TractionLaw::derivative`] is that of the [rules](super) for every bin, along changes of its memory and of its dent. The
//! dent `w_0, f_0` moves the residual depth `d = w_0 - b` and the stiffness `s = f_0/b^(3/2)` of unloading, where
//! `b = f_0/(4/3 E* sqrt(R w_0))`:
//! <div>
//! $$ \mathrm{d} b = b \left( \frac{\mathrm{d} f_0}{f_0} - \frac{\mathrm{d} w_0}{2 w_0} \right), \qquad
//! \mathrm{d} s = s \left( \frac{\mathrm{d} f_0}{f_0} - \frac{3 \, \mathrm{d} b}{2 b} \right), \qquad
//! \mathrm{d} F = s \, \tfrac{3}{2} (w - d)^{1/2} \, \mathrm{d}(w - d) + (w - d)^{3/2} \, \mathrm{d} s . $$
//! </div>
//!
//! # Energy
//! At constant `u_n` closed cycles never give energy. At changing `u_n` only [`HistoryRule::Potential`] never does, with a
//! commit at every step. It is for elastic asperities alone: with yield the contact radius jumps between loading and unloading,
//! which no potential describes.
//!
//! The largest tangential work that came out of 3000 random closed paths from rest with changing `u_n` and opening, 400 steps
//! each, relative to the sum of `mu t_n |du_t|`:
//!
//! | | elastic | continuous yield | published yield |
//! |---|---|---|---|
//! | `Incremental`, `EndPoint` | 4.4 % | 3.6 % | 13.5 % |
//! | `Paper` | 72 % | 69 % | 69 % |
//! | `Annuli` with `Incremental` | 1.7 % | 1.4 % | |
//! | `MindlinIwan`, 7 radii, 600 paths | 2.8 % | | 3.2 % |
//! | `Incremental`, limit `Ceb`, relative to `t_n \|du_t\|` | | 5.1 % | |
//! | `Incremental`, limit `ShearStrength`, relative to `t_n \|du_t\|` | | 2.7 % | |
//!
//! # Parameters and state
//! | quantity | unit |
//! |---|---|
//! | Young's modulus, Poisson's ratio, radius of the asperities | Pa, 1, m |
//! | yield strength, tangent modulus, if they yield | Pa |
//! | gap and density of every bin | m, 1/m^2 |
//! | friction coefficient `mu`, per point, with Coulomb's limit | 1 |
//! | state `u_x, u_y, u_n` of the point committed last | m |
//! | state of every bin, or of every annulus: `f_x, f_y`, with `Potential` `e_x, e_y` | N, m |
//! | with `MindlinIwan` instead the contact radius and `t_x, t_y` at every radius | m, Pa |
//! | and with yield the largest interference and the force there | m, N |
//!
//! [`Regime::Slip`] is gross slip: all bins in contact slip.
//!
//! Source: J. H. Porter and M. R. W. Brake, *Towards a predictive, physics-based friction model for the dynamics of
//! jointed structures*, Mech. Syst. Signal Process. 192 (2023) 110210.
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! let asperity = Asperity::try_new(ElasticPair::new(192.31e9, 0.3), 1.4e-3, None)?;
//! let bins = AsperityBins::try_new(asperity, vec![0.0, 2e-6, 4e-6], vec![1e5; 3])?;
//! let (bins, mu) = (PointParameters::uniform(bins, 1), PointParameters::uniform(0.1, 1));
//! let law = ResolvedLaw::try_new(bins, mu, AsperityFriction::StickSlip(HistoryRule::Incremental), Cone::Circle)?;
//!
//! // Closed by 4.1 um and moved along x: the asperities with the largest gap slip first.
//! let mut begin = vec![0.0; law.info().n_state()];
//! begin[2] = 4.1e-6;
//! let mut end = begin.clone();
//! let [mut t_x, mut t_y, mut t_n] = [[0.0]; 3];
//! law.evaluate(
//!     0..1,
//!     Sticking::Coulomb,
//!     Components::new(&[0.1e-6], &[0.0], &[4.1e-6]),
//!     StateView::new(&begin, 1, 0),
//!     StateViewMut::new(&mut end, 1, 0),
//!     ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
//!     None,
//!     None,
//! );
//! let limit = 0.1 * asperity.loading(0.1e-6).force.value;
//! assert!((end[7] / limit - 1.0).abs() < 1e-9, "the third bin slips");
//! assert!(end[3] < 0.1 * asperity.loading(4.1e-6).force.value, "the first sticks");
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use super::annuli::{Annuli, AnnuliBack, Slopes};
use super::block_start::{Present, Rows, States, common, gather, spread_nan, states_from};
use super::cone::{BoxWorkspace, Cone, respond};
use super::history_rule::HistoryRule;
use super::radii::{Circle, CircleChange, MAX_RADII, Radii, Reaction};
use super::return_map::{Block, CurveChange, Derivative, OPEN, SLIP, STICK, Workspace, of_parts};
use super::rule::{Memory, StiffnessAt};
use super::shares::{N_ANNULI, shares};
use super::{JUMP, MU, has_friction, require_friction};
use crate::curves::CurveBlock;
use crate::error::Error;
use crate::law::{
    Along, Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking,
    TangentMut, TractionLaw, check_points, evaluates_by,
};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::PointParameters;
use crate::physics::bins::AsperityBins;
use crate::physics::elastic_plastic::{Asperity, Dent, Unloading};
use crate::physics::slip_limit::AsperityLimit;
use crate::simd::bounds::{bounded, within};
use crate::simd::elementary::{max, min};
use crate::simd::{BLOCK, Lanes, Pass, SHORT_BLOCK, part, part_mut, run};
use crate::transposed::{self, Adjoint, Input, Part, WHOLE, WayBack};
use alloc::borrow::Cow;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// State components before those of the bins: the jump.
const N_JUMP: usize = 3;

/// Entries of the tangent without the derivatives of the normal traction along the surface, which are zero unless the rule has a
/// potential.
const UNCOUPLED: [usize; 7] = [0, 1, 2, 3, 4, 5, 8];

/// Bound of what one bin adds to a traction (Pa) or a tangent (Pa/m).
const LARGEST: f64 = 1e300;

/// How the tangential force of an asperity follows from its history.
#[derive(Debug, Clone, PartialEq)]
pub enum AsperityFriction {
    /// It sticks or slips as a whole.
    StickSlip(HistoryRule),
    /// It slips from its rim inwards: 1 to [`MAX_ANNULI`](super::shares::MAX_ANNULI) annuli of its contact circle stick or slip, with the shares of stiffness and slip
    /// limit that follow Mindlin's loading curve ([`shares`](super::shares), with its errors). An annulus remembers its
    /// force and keeps its place relative to the contact radius.
    Annuli(HistoryRule, usize),
    /// As published: an annulus remembers its traction at its radius, which is interpolated when the contact radius changes. The
    /// interpolation smooths the history a little at every commit, so that cycles with changing `u_n` close slowly.
    MindlinIwan(Radii),
}

impl AsperityFriction {
    fn stiffness(&self) -> (StiffnessAt, bool) {
        match self {
            Self::StickSlip(history) | Self::Annuli(history, _) => {
                let needs = history.needs();
                (needs.stiffness, needs.curvature)
            }
            Self::MindlinIwan(_) => (StiffnessAt::End, false),
        }
    }

    /// Whether a stretch adds to the normal force.
    fn presses(&self) -> bool {
        match self {
            Self::StickSlip(history) | Self::Annuli(history, _) => history.needs().memory == Memory::Stretch,
            Self::MindlinIwan(_) => false,
        }
    }

    /// What a bin remembers of its tangential force.
    fn memory(&self, bin: usize) -> Vec<Quantity> {
        let named = |name: &str, unit| Quantity {
            name: Cow::Owned(format!("{name}_{bin}")),
            unit,
        };
        let of = |history: HistoryRule| match history.needs().memory {
            Memory::Traction => ("f", "N"),
            Memory::Stretch => ("e", "m"),
        };
        match self {
            Self::StickSlip(history) => {
                let (name, unit) = of(*history);
                ["x", "y"].map(|q| named(&format!("{name}_{q}"), unit)).to_vec()
            }
            Self::Annuli(history, n) => {
                let (name, unit) = of(*history);
                let at = |i| ["x", "y"].map(|q| named(&format!("{name}_{q}_{i}"), unit));
                (1..=*n).flat_map(at).collect()
            }
            Self::MindlinIwan(radii) => {
                let at = |i| ["x", "y"].map(|q| named(&format!("t_{q}_{i}"), "Pa"));
                let tractions = (1..=radii.len()).flat_map(at);
                core::iter::once(named("a", "m")).chain(tractions).collect()
            }
        }
    }
}

/// Bins of asperities with friction. State per point: `u_x, u_y, u_n` (m), then two or, with yield, four numbers of
/// every bin.
#[derive(Debug, Clone)]
pub struct ResolvedLaw {
    bins: PointParameters<AsperityBins>,
    mu: PointParameters<f64>,
    friction: AsperityFriction,
    cone: Cone,
    limit: AsperityLimit,
    tables: Tables,
    /// Of slip limit and stiffness, of the annuli.
    shares: Vec<[f64; 2]>,
    info: LawInfo,
}

/// The sets of bins as the loops read them.
#[derive(Debug, Clone)]
struct Tables {
    n_bins: usize,
    yields: bool,
    /// Of every set.
    asperities: Vec<Asperity>,
    hertz: Vec<f64>,
    mindlin: Vec<f64>,
    onset: Vec<f64>,
    /// Of every bin and set, `[bin][set]`. Sets with fewer bins end with empty ones.
    gaps: Vec<f64>,
    densities: Vec<f64>,
    /// Smallest gap of every bin and those after it.
    least: Vec<f64>,
}

impl Tables {
    fn new(sets: &[AsperityBins]) -> Self {
        let n_bins = sets.iter().map(AsperityBins::len).max().unwrap_or(0);
        let each = |of: &dyn Fn(&Asperity) -> f64| sets.iter().map(|set| of(set.asperity())).collect::<Vec<_>>();
        let onset = each(&Asperity::onset_of_yield);
        let mut gaps = Vec::with_capacity(n_bins * sets.len());
        let mut densities = Vec::with_capacity(n_bins * sets.len());
        for bin in 0..n_bins {
            for set in sets {
                gaps.push(set.gaps()[bin.min(set.len() - 1)]);
                densities.push(set.densities().get(bin).copied().unwrap_or(0.0));
            }
        }
        let mut least = gaps.clone();
        for at in (0..least.len() - sets.len()).rev() {
            least[at] = min(least[at], least[at + sets.len()]);
        }
        Self {
            n_bins,
            least,
            yields: onset.iter().any(|onset| onset.is_finite()),
            asperities: sets.iter().map(|set| *set.asperity()).collect(),
            hertz: each(&Asperity::hertz_factor),
            mindlin: each(&Asperity::mindlin_factor),
            onset,
            gaps,
            densities,
        }
    }

    /// Whether the asperities of a bin and of all after it are open at the points of a block with these interferences, if none has a dent.
    fn are_open_from(&self, bin: usize, sets: &[u32], u_n: &[f64]) -> bool {
        let n_sets = self.asperities.len();
        let Some(least) = self.least.get(bin * n_sets..).filter(|least| !least.is_empty()) else {
            return true;
        };
        !sets.iter().zip(u_n).any(|(&set, u_n)| *u_n > least[set as usize])
    }

    /// Gaps or densities of a bin at the points of a block.
    fn gather(&self, values: &[f64], bin: usize, sets: &[u32], one_set: Option<u32>, into: &mut [f64]) {
        let n_sets = self.asperities.len();
        gather(&values[bin * n_sets..][..n_sets], sets, one_set, into);
    }
}

impl ResolvedLaw {
    /// A law over `bins.len()` points with the friction coefficient `mu` per point.
    ///
    /// # Errors
    /// [`Error::Length`] when `mu` has another number of points, [`Error::Parameter`] when a coefficient is negative or
    /// not finite or when the number of annuli is out of bounds, [`Error::Combination`] for asperities that yield with [`HistoryRule::Potential`].
    pub fn try_new(
        bins: PointParameters<AsperityBins>,
        mu: PointParameters<f64>,
        friction: AsperityFriction,
        cone: Cone,
    ) -> Result<Self, Error> {
        require_friction(&mu, bins.len())?;
        let tables = Tables::new(bins.sets());
        let shares = match friction {
            AsperityFriction::Annuli(_, n) => {
                N_ANNULI.check(n as f64)?;
                shares(n)
            }
            AsperityFriction::StickSlip(_) | AsperityFriction::MindlinIwan(_) => Vec::new(),
        };

        if tables.yields && friction.presses() {
            return Err(Error::Combination {
                first: "asperities that yield",
                second: "the history rule `potential`",
                remedy: "take another rule, or elastic asperities",
            });
        }
        let dent = |bin: usize| {
            let named = [("w_max", "m"), ("f_max", "N")].map(|(name, unit)| Quantity {
                name: Cow::Owned(format!("{name}_{bin}")),
                unit,
            });
            named.into_iter().filter(|_| tables.yields)
        };
        let state = (1..=tables.n_bins).flat_map(|bin| friction.memory(bin).into_iter().chain(dent(bin)));
        let elastic = [
            Quantity::new("youngs_modulus", "Pa"),
            Quantity::new("poisson_ratio", "1"),
            Quantity::new("asperity_radius", "m"),
            Quantity::new("bin_gap", "m"),
            Quantity::new("bin_density", "1/m^2"),
        ];
        let plastic = [
            Quantity::new("yield_strength", "Pa"),
            Quantity::new("tangent_modulus", "Pa"),
        ];
        let plastic = plastic.into_iter().filter(|_| tables.yields);
        let info = LawInfo {
            name: "friction resolved over asperities",
            reference: "10.1016/j.ymssp.2023.110210",
            state: JUMP.into_iter().chain(state).collect(),
            parameters: elastic.into_iter().chain(plastic).chain([MU]).collect(),
        };
        Ok(Self {
            bins,
            mu,
            friction,
            cone,
            limit: AsperityLimit::default(),
            tables,
            shares,
            info,
        })
    }

    /// The same law with another limit of the asperities' tangential forces. Of [`AsperityLimit::Ceb`] and
    /// [`AsperityLimit::ShearStrength`] `mu` is no parameter.
    ///
    /// # Errors
    /// [`Error::Combination`] for another limit than Coulomb's where some asperities do not yield.
    pub fn with_limit(mut self, limit: AsperityLimit) -> Result<Self, Error> {
        let coulomb = limit == AsperityLimit::Coulomb;
        if !coulomb && !self.tables.onset.iter().all(|onset| onset.is_finite()) {
            return Err(Error::Combination {
                first: "elastic asperities",
                second: "a slip limit that follows from the yield strength",
                remedy: "give the yield strength, or take Coulomb's limit",
            });
        }
        self.info.parameters.retain(|parameter| *parameter != MU);
        self.info.parameters.extend(coulomb.then_some(MU));
        self.limit = limit;
        Ok(self)
    }

    /// What limits the asperities' tangential forces.
    pub fn limit(&self) -> AsperityLimit {
        self.limit
    }

    /// The bins of every point.
    pub fn bins(&self) -> &PointParameters<AsperityBins> {
        &self.bins
    }

    /// The friction coefficients.
    pub fn mu(&self) -> &PointParameters<f64> {
        &self.mu
    }

    /// How tangential forces follow from the history.
    pub fn friction(&self) -> &AsperityFriction {
        &self.friction
    }

    /// The cone.
    pub fn cone(&self) -> Cone {
        self.cone
    }

    /// How much a bin remembers: its tangential force, then its dent if it can have one; and of that its dent.
    fn memories(&self) -> (usize, usize) {
        let Tables { n_bins, yields, .. } = self.tables;
        let of_bin = (self.info.n_state() - N_JUMP).checked_div(n_bins).unwrap_or(0);
        (of_bin, if yields { 2 } else { 0 })
    }

    /// [`TractionLaw::evaluate`] or, along a direction, [`TractionLaw::derivative`] in blocks of `B` points.
    fn evaluate_blocks<const B: usize>(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        mut end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
        mut regimes: Option<&mut [Regime]>,
        mut along: Option<Along<'_>>,
    ) -> RegimeCounts {
        let n = points.len();
        let jump = [jump.x, jump.y, jump.n];
        let mut traction = [traction.x, traction.y, traction.n];
        let mut tangent = tangent.map(TangentMut::into_entries);
        let mut room = Scratch::<B>::new(self.cone);
        let mut changes = along.is_some().then(Changes::<B>::new);
        let mut counts = RegimeCounts::default();
        // Of end state and its change.
        let mut zeros_from = [0; 2];
        let mut block = 0..0;
        while block.end < n {
            block = block.end..n.min(block.end + B);
            let m = block.len();
            let of_block = along.as_mut().zip(changes.as_mut()).map(|(along, changes)| Direction {
                jump: part(&[along.d_jump.x, along.d_jump.y, along.d_jump.n], &block),
                rows: Rows::of(along.d_begin, &mut along.d_end, n, &block),
                changes,
                parts: along.parts.as_deref_mut(),
            });
            let rows = Rows::of(begin, &mut end, n, &block);
            let left = self.block(
                points.start + block.start,
                sticking,
                part(&jump, &block),
                rows,
                tangent.is_some(),
                &mut room,
                of_block,
            );
            zeros_from = core::array::from_fn(|which| zeros_from[which].max(left[which]));
            if let Some((along, changes)) = along.as_mut().zip(changes.as_ref()) {
                let ComponentsMut { x, y, n } = &mut along.d_traction;
                for (q, traction) in [x, y, n].into_iter().enumerate() {
                    traction[block.clone()].copy_from_slice(&changes.sum[q].0[..m]);
                }
            }
            for (q, traction) in part_mut(&mut traction, &block).into_iter().enumerate() {
                traction.copy_from_slice(&room.sums.response.traction[q].0[..m]);
            }
            if let Some(tangent) = &mut tangent {
                for (entry, tangent) in part_mut(tangent, &block).into_iter().enumerate() {
                    tangent.copy_from_slice(&room.sums.response.tangent[entry].0[..m]);
                }
            }
            let regimes = regimes.as_deref_mut().map(|regimes| &mut regimes[block.clone()]);
            counts += of_parts(&room.sums.regimes, &room.fill, m, regimes);
        }
        let states = [Some(end), along.map(|along| along.d_end)];
        for (state, component) in states.into_iter().flatten().zip(zeros_from) {
            if let Some(leaves) = state.leaves_zeros_from {
                *leaves = component;
            }
        }
        counts
    }

    /// The points of a block from `first` on: from which components on end state and its change are zero.
    fn block<const B: usize>(
        &self,
        first: usize,
        sticking: Sticking,
        jump: [&[f64]; 3],
        mut rows: Rows<'_>,
        with_tangent: bool,
        room: &mut Scratch<B>,
        mut direction: Option<Direction<'_, B>>,
    ) -> [usize; 2] {
        let tables = &self.tables;
        let (stiffness, curvature) = self.friction.stiffness();
        let couples = self.friction.presses();
        let entries: &[usize] = match (with_tangent, couples) {
            (false, _) => &[],
            (true, false) => &UNCOUPLED,
            (true, true) => &[0, 1, 2, 3, 4, 5, 6, 7, 8],
        };
        let (n_memory, n_dent) = self.memories();
        let m = jump[0].len();
        self.begin_block(first, sticking, m, room);
        let Scratch {
            sets,
            gap,
            density,
            hertz,
            mindlin,
            onset,
            mu,
            ratio,
            fill,
            approach,
            u_n,
            middle,
            curves,
            of_annulus,
            workspace,
            box_workspace,
            bin,
            of_bin,
            sliders,
            sums,
            ..
        } = room;
        let sets = &sets[..m];
        let one_set = common(sets);
        // Zero, or NaN where any input is no number.
        *fill = rows.spread_nan(jump, self.info.n_state());
        sums.begin(fill);
        if let Some(direction) = &mut direction {
            direction.begin(self.info.n_state(), fill);
        }
        rows.end_at(jump, fill);
        let u_closing = jump[2];
        for j in 0..tables.n_bins {
            tables.gather(&tables.gaps, j, sets, one_set, &mut gap.0[..m]);
            tables.gather(&tables.densities, j, sets, one_set, &mut density.0[..m]);
            let base = N_JUMP + j * n_memory;
            let dent_base = base + n_memory - n_dent;
            let begin: [&[f64]; 5] = core::array::from_fn(|c| {
                if c < N_JUMP {
                    rows.begin(c)
                } else {
                    rows.begin(base + c - N_JUMP)
                }
            });
            let dent = tables
                .yields
                .then(|| [rows.begin(dent_base), rows.begin(dent_base + 1)]);
            run(Elastic {
                u_n: jump[2],
                u_n0: begin[2],
                gap,
                fill,
                hertz,
                approach,
            });
            if let Some([interference, force]) = dent {
                run(Unload {
                    interference,
                    force,
                    onset,
                    approach,
                    hertz,
                });
            }
            if let Some(Direction {
                jump, rows, changes, ..
            }) = &mut direction
            {
                run(ApproachChanges {
                    w: jump[2],
                    u_n0: rows.begin(2),
                    dent: dent.map(|dent| [dent, [rows.begin(dent_base), rows.begin(dent_base + 1)]]),
                    onset,
                    hertz,
                    change: &mut changes.approach,
                });
            }
            let w = &approach.u_n.0[..m];
            let jump = [jump[0], jump[1], w];
            let begin = [begin[0], begin[1], &approach.u_n0.0[..m], begin[3], begin[4]];
            let present = close(stiffness, fill, approach, u_n, middle);
            if present.closed {
                run(Hertz {
                    u_n,
                    middle,
                    approach,
                    hertz,
                    mindlin,
                    dented: dent.is_some(),
                    at_end: stiffness == StiffnessAt::End,
                    curvature: curvature && (with_tangent || direction.is_some()),
                    curves,
                });
                if let Some([interference, _]) = dent {
                    self.load(sets, interference, approach, onset, u_n, middle, stiffness, curves);
                }
                let [mu, mu_slope] = match (dent, sticking) {
                    (Some(dent), Sticking::Coulomb | Sticking::Full) if self.limit != AsperityLimit::Coulomb => {
                        self.limits(sets, dent, approach, u_n, curves, ratio);
                        [&ratio[0], &ratio[1]]
                    }
                    _ => [&*mu, &*mu],
                };
                if let Some(Direction { rows, changes, .. }) = &mut direction {
                    run(CurveChanges {
                        halfway: stiffness == StiffnessAt::Middle,
                        u_n,
                        middle,
                        u_n0: &approach.u_n0,
                        stiffness: &approach.stiffness,
                        hertz,
                        mindlin,
                        curves,
                        approach: &changes.approach,
                        middle_change: &mut changes.middle,
                        change: &mut changes.curves,
                    });
                    if let Some([interference, _]) = dent {
                        load_changes(
                            m,
                            interference,
                            approach,
                            onset,
                            u_n,
                            middle,
                            stiffness,
                            curves,
                            changes,
                        );
                    }
                    run(CoulombChanges {
                        mu,
                        normal: &changes.curves.normal,
                        limit: &mut changes.curves.limit,
                    });
                    if let Some(dent) = dent
                        && self.limit != AsperityLimit::Coulomb
                        && sticking != Sticking::Frictionless
                    {
                        self.limit_changes(sets, dent, rows.begin(dent_base), approach, u_n, changes);
                    }
                }
                let at_once = !couples && direction.is_none() && box_workspace.is_none();
                let mut stick_or_slip = |history: HistoryRule,
                                         curves: &CurveBlock<B>,
                                         memory: usize,
                                         workspace: &mut Workspace<B>,
                                         bin: &mut Response<B>,
                                         part: usize,
                                         annulus: Option<[f64; 2]>| {
                    let derivative = direction
                        .as_mut()
                        .map(|direction| direction.derivative(m, memory, annulus));
                    let block = Block {
                        jump,
                        begin: [begin[0], begin[1], begin[2], rows.begin(memory), rows.begin(memory + 1)],
                        mu: &mu.0[..m],
                        mu_slope: &mu_slope.0[..m],
                        u_n,
                        present,
                        curves,
                        sticking,
                        workspace,
                        memory: rows.end::<2>(memory),
                        traction: bin.traction.each_mut().map(|lanes| &mut lanes.0[..m]),
                        tangent: with_tangent.then(|| bin.tangent.each_mut().map(|lanes| &mut lanes.0[..m])),
                        regimes: None,
                        derivative,
                    };
                    respond(history, box_workspace, block);
                    if let Some(direction) = &mut direction {
                        direction.add(part, density);
                    }
                };
                match &self.friction {
                    AsperityFriction::StickSlip(history) => {
                        stick_or_slip(*history, curves, base, workspace, bin, j, None);
                        sums.add(density, bin, &workspace.regime, entries);
                    }
                    AsperityFriction::Annuli(history, _) if at_once => {
                        let memory = rows.begin_from(base);
                        history.annuli(Annuli {
                            shares: &self.shares,
                            jump,
                            begin: [begin[0], begin[1], begin[2]],
                            reclosed: present.reclosed,
                            mu: &mu.0[..m],
                            mu_slope: &mu_slope.0[..m],
                            u_n,
                            curves,
                            unlimited: sticking == Sticking::Full,
                            memory,
                            end: rows.end_from(base),
                            traction: &mut bin.traction,
                            tangent: with_tangent.then_some(&mut bin.tangent),
                            regimes: &mut workspace.regime,
                            slopes: None,
                        });
                        sums.add(density, bin, &workspace.regime, entries);
                    }
                    AsperityFriction::Annuli(history, _) => {
                        *of_bin = Response::of(Lanes([0.0; B]));
                        for (k, &[limit, stiffness]) in self.shares.iter().enumerate() {
                            run(Share {
                                limit,
                                stiffness,
                                of: curves,
                                into: of_annulus,
                            });
                            let shares = Some([limit, stiffness]);
                            let part = j * self.shares.len() + k;
                            stick_or_slip(*history, of_annulus, base + 2 * k, workspace, bin, part, shares);
                            of_bin.sum_up(bin, entries);
                            sums.merge(density, &workspace.regime);
                        }
                        sums.response.add(density, of_bin, entries);
                    }
                    AsperityFriction::MindlinIwan(radii) => {
                        for i in 0..m {
                            let modulus = tables.asperities[sets[i] as usize].tangential_modulus();
                            let at = Lane {
                                i,
                                base,
                                modulus,
                                mu: [mu.0[i], mu_slope.0[i]],
                                u_n: u_n.0[i],
                                fill: fill.0[i],
                            };
                            let answer = (&mut *bin, &mut *sliders);
                            workspace.regime.0[i] = self.microslip(
                                radii,
                                at,
                                sticking,
                                jump,
                                begin,
                                curves,
                                &mut rows,
                                answer,
                                direction.as_mut(),
                            );
                        }
                        sums.add(density, bin, &workspace.regime, entries);
                        if let Some(direction) = &mut direction {
                            direction.add(j, density);
                        }
                    }
                }
            } else {
                // Dents stay when asperities open.
                let has_none = dent.is_none() || (direction.is_none() && rows.begin.zero_from <= base);
                if has_none && tables.are_open_from(j + 1, sets, u_closing) {
                    let n_state = self.info.n_state();
                    rows.end_from_with(base, n_state, &fill.0[..m]);
                    if let Some(Direction { rows, changes, .. }) = &mut direction {
                        rows.end_from_with(base, n_state, &changes.nothing.0[..m]);
                    }
                    break;
                }
                rows.end_with(base..dent_base, &fill.0[..m]);
                if let Some(Direction { rows, changes, .. }) = &mut direction {
                    rows.end_with(base..dent_base, &changes.nothing.0[..m]);
                }
            }
            if let Some([w_0, f_0]) = dent {
                let [end_w, end_f] = rows.end::<2>(dent_base);
                for i in 0..m {
                    let further = (u_n.0[i] > 0.0) & (approach.interference.0[i] > w_0[i]);
                    end_w[i] = fill.0[i] + if further { approach.interference.0[i] } else { w_0[i] };
                    end_f[i] = fill.0[i]
                        + if further {
                            min(curves.normal.0[i], LARGEST)
                        } else {
                            f_0[i]
                        };
                }
                if let Some(Direction { rows, changes, .. }) = &mut direction {
                    let [w_change, f_change] = [rows.begin(dent_base), rows.begin(dent_base + 1)];
                    let [end_w, end_f] = rows.end::<2>(dent_base);
                    for i in 0..m {
                        let further = (u_n.0[i] > 0.0) & (approach.interference.0[i] > w_0[i]);
                        let Changes {
                            approach,
                            curves,
                            nothing,
                            ..
                        } = &**changes;
                        let loaded = [approach.interference.0[i], within(curves.normal.0[i], LARGEST)];
                        let [w, f] = if further { loaded } else { [w_change[i], f_change[i]] };
                        (end_w[i], end_f[i]) = (nothing.0[i] + w, nothing.0[i] + f);
                    }
                }
            }
        }
        [
            rows.zero_from,
            direction.map_or(0, |direction| direction.rows.zero_from),
        ]
    }

    /// What the `m` points of a block from `first` on have in common for all bins.
    fn begin_block<const B: usize>(&self, first: usize, sticking: Sticking, m: usize, room: &mut Scratch<B>) {
        let (tables, sets) = (&self.tables, &mut room.sets[..m]);
        self.bins.copy_set_numbers(first, sets);
        match sticking {
            Sticking::Frictionless => room.mu.0 = [0.0; B],
            Sticking::Coulomb | Sticking::Full => self.mu.copy_to(first, &mut room.mu.0[..m]),
        }
        for (i, &set) in sets.iter().enumerate() {
            let set = set as usize;
            room.hertz.0[i] = tables.hertz[set];
            room.mindlin.0[i] = tables.mindlin[set];
            room.onset.0[i] = tables.onset[set];
        }
    }

    /// History rule and shares of annuli, or of whole asperities as one, of laws whose way back through a step [`AnnuliBack`] tells: those of which a
    /// bin remembers nothing but its forces.
    fn slipping_together(&self) -> Option<(HistoryRule, &[[f64; 2]])> {
        let remembers_forces = !self.friction.presses() && !self.tables.yields && self.cone == Cone::Circle;
        match &self.friction {
            AsperityFriction::StickSlip(history) if remembers_forces => Some((*history, &[[1.0; 2]])),
            AsperityFriction::Annuli(history, _) if remembers_forces => Some((*history, &self.shares)),
            _ => None,
        }
    }

    /// [`TractionLaw::transposed`] bin by bin.
    fn transposed_blocks<const B: usize>(
        &self,
        (history, shares): (HistoryRule, &[[f64; 2]]),
        of: &Input<'_>,
        way: WayBack,
        adjoints: &mut [Adjoint<'_>],
    ) {
        let Input { points, jump, begin } = of;
        let (tables, stiffness) = (&self.tables, history.needs().stiffness);
        let (n, n_state) = (points.len(), self.info.n_state());
        let (n_memory, _) = self.memories();
        let mut room = Scratch::<B>::new(self.cone);
        let mut slopes = Slopes::new(shares.len());
        let mut sums = vec![[Lanes([0.0; B]); 6]; adjoints.len()];
        // Component from which on nothing was written.
        let mut untouched = 0;
        for start in (0..n).step_by(B) {
            let block = start..n.min(start + B);
            let m = block.len();
            self.begin_block(points.start + start, Sticking::Coulomb, m, &mut room);
            let Scratch {
                sets,
                gap,
                density,
                hertz,
                mindlin,
                mu,
                fill,
                approach,
                u_n,
                middle,
                curves,
                workspace,
                bin,
                ..
            } = &mut room;
            let sets = &sets[..m];
            let one_set = common(sets);
            let jump = part(&[jump.x, jump.y, jump.n], &block);
            let begin_at = |c: usize| &begin.component(c, n)[block.clone()];
            let begun = [0, 1, 2].map(begin_at);
            *fill = spread_nan(jump, *begin, &block, n_state);
            sums.fill([*fill; 6]);
            let mut open_from = n_state;
            for j in 0..tables.n_bins {
                tables.gather(&tables.gaps, j, sets, one_set, &mut gap.0[..m]);
                tables.gather(&tables.densities, j, sets, one_set, &mut density.0[..m]);
                let base = N_JUMP + j * n_memory;
                run(Elastic {
                    u_n: jump[2],
                    u_n0: begun[2],
                    gap,
                    fill,
                    hertz,
                    approach,
                });
                let present = close(stiffness, fill, approach, u_n, middle);
                if !present.closed {
                    let are_open = tables.are_open_from(j + 1, sets, jump[2]);
                    let until = if are_open { n_state } else { base + n_memory };
                    let is_finite = fill.0[..m].iter().all(|fill| *fill == 0.0);
                    for Adjoint { history, .. } in &mut *adjoints {
                        // Nothing comes through an open bin.
                        let written = match (way, is_finite) {
                            (WayBack::JumpAlone, _) | (WayBack::Passed, true) => base..base,
                            (WayBack::Passed, false) => base..until,
                            (WayBack::Committed, _) => base..until.min(history.zero_from).max(base),
                        };
                        for c in written {
                            let values = &mut history.data[c * history.stride + history.offset + start..][..m];
                            for (value, fill) in values.iter_mut().zip(&fill.0) {
                                *value = way.before(*value, *fill);
                            }
                        }
                    }
                    if are_open {
                        open_from = if is_finite { base } else { n_state };
                        break;
                    }
                    continue;
                }
                run(Hertz {
                    u_n,
                    middle,
                    approach,
                    hertz,
                    mindlin,
                    dented: false,
                    at_end: stiffness == StiffnessAt::End,
                    curvature: history.needs().curvature,
                    curves,
                });
                history.annuli(Annuli {
                    shares,
                    jump: [jump[0], jump[1], &approach.u_n.0[..m]],
                    begin: [begun[0], begun[1], &approach.u_n0.0[..m]],
                    reclosed: present.reclosed,
                    mu: &mu.0[..m],
                    mu_slope: &mu.0[..m],
                    u_n,
                    curves,
                    unlimited: false,
                    memory: states_from(*begin, base, start),
                    end: States {
                        data: &mut [],
                        stride: 0,
                        first: 0,
                    },
                    traction: &mut bin.traction,
                    tangent: None,
                    regimes: &mut workspace.regime,
                    slopes: Some(&mut slopes),
                });
                for (adjoint, sums) in adjoints.iter_mut().zip(&mut sums) {
                    let Adjoint { history, traction, .. } = adjoint;
                    let first = base * history.stride + history.offset + start;
                    run(AnnuliBack {
                        way,
                        shares,
                        slopes: &slopes,
                        density,
                        traction: part(&[traction.x, traction.y, traction.n], &block),
                        history: (&mut history.data[first..], history.stride),
                        sums,
                    });
                }
            }
            untouched = untouched.max(open_from);
            for (Adjoint { history, jump, .. }, sums) in adjoints.iter_mut().zip(&sums) {
                let ComponentsMut { x, y, n } = jump;
                for (c, into) in [x, y, n].into_iter().enumerate() {
                    let values = &mut history.data[c * history.stride + history.offset + start..][..m];
                    for (i, (value, into)) in values.iter_mut().zip(&mut into[block.clone()]).enumerate() {
                        *into = way.of_end(*value) + sums[c].0[i];
                        *value = way.before(*value, sums[N_JUMP + c].0[i]);
                    }
                }
            }
        }
        for Adjoint { history, .. } in adjoints {
            if let Some(leaves) = &mut history.leaves_zeros_from {
                **leaves = match way {
                    WayBack::JumpAlone => history.zero_from,
                    WayBack::Passed => history.zero_from.max(untouched),
                    WayBack::Committed => untouched,
                };
            }
        }
    }

    /// The asperities of a bin at one point, annulus by annulus.
    fn microslip<const B: usize>(
        &self,
        radii: &Radii,
        at: Lane,
        sticking: Sticking,
        jump: [&[f64]; 3],
        begin: [&[f64]; 5],
        curves: &CurveBlock<B>,
        rows: &mut Rows<'_>,
        (answer, sliders): (&mut Response<B>, &mut Sliders),
        direction: Option<&mut Direction<'_, B>>,
    ) -> u64 {
        let Lane {
            i,
            base,
            modulus,
            mu,
            u_n,
            fill,
        } = at;
        let (radius, reaction) = if u_n > 0.0 {
            let [k, slope] = [&curves.tangential, &curves.tangential_slope].map(|of| bounded(of[0].0[i]) / modulus);
            let circle = Circle {
                force: bounded(curves.normal.0[i]),
                radius: [k, slope],
                modulus,
                radius_before: rows.begin(base)[i],
                du: [0, 1].map(|q| bounded(jump[q][i] - begin[q][i])),
                limit: [
                    mu[0] * bounded(curves.normal.0[i]),
                    mu[1] * bounded(curves.normal_slope.0[i]),
                ],
                cone: self.cone,
                unlimited: sticking == Sticking::Full,
            };
            let n_radii = radii.len();
            let [before, after] = [&mut sliders.before[..n_radii], &mut sliders.after[..n_radii]];
            rows.gather(base + 1, i, before);
            let reaction = radii.react(&circle, before, after);
            rows.scatter(base + 1, i, after, 0.0);
            if let Some(direction) = direction {
                direction.microslip(radii, &circle, base, i, before);
            }
            (k, reaction)
        } else {
            for component in base + 1..base + 1 + 2 * radii.len() {
                rows.end::<1>(component)[0][i] = fill;
            }
            if let Some(Direction { rows, changes, .. }) = direction {
                for component in base..base + 1 + 2 * radii.len() {
                    rows.end::<1>(component)[0][i] = changes.nothing.0[i];
                }
                for traction in &mut changes.traction {
                    traction.0[i] = 0.0;
                }
            }
            (0.0, Reaction::default())
        };
        rows.end::<1>(base)[0][i] = radius + fill;
        let closed = u_n > 0.0;
        let normal = |of: &Lanes<f64, B>| if closed { of.0[i] } else { 0.0 };
        let Reaction { force, tangent, slips } = reaction;
        let rows = [tangent[0], tangent[1], [0.0, 0.0, normal(&curves.normal_slope)]];
        for (traction, value) in answer
            .traction
            .iter_mut()
            .zip([force[0], force[1], normal(&curves.normal)])
        {
            traction.0[i] = value;
        }
        for (entry, value) in answer.tangent.iter_mut().zip(rows.as_flattened()) {
            entry.0[i] = *value;
        }
        match (closed, slips) {
            (false, _) => OPEN,
            (true, false) => STICK,
            (true, true) => SLIP,
        }
    }

    /// Slip limits over normal forces, and the same of their derivatives, asperity by asperity.
    fn limits<const B: usize>(
        &self,
        sets: &[u32],
        [interference, force]: [&[f64]; 2],
        approach: &Approach<B>,
        u_n: &Lanes<f64, B>,
        curves: &CurveBlock<B>,
        ratio: &mut [Lanes<f64, B>; 2],
    ) {
        for (i, &set) in sets.iter().enumerate() {
            let asperity = &self.tables.asperities[set as usize];
            let dent = Dent {
                interference: interference[i],
                force: force[i],
            };
            let closed = u_n.0[i] > 0.0;
            let limit = closed
                .then(|| asperity.slip_limit(self.limit, approach.interference.0[i], dent))
                .flatten()
                .unwrap_or_default();
            let over = |limit: f64, of: f64| if of > 0.0 { bounded(limit / of) } else { 0.0 };
            ratio[0].0[i] = over(limit.value, curves.normal.0[i]);
            ratio[1].0[i] = over(limit.slope, curves.normal_slope.0[i]);
        }
    }

    /// Changes of [`Self::limits`] times the normal forces, asperity by asperity.
    fn limit_changes<const B: usize>(
        &self,
        sets: &[u32],
        [interference, force]: [&[f64]; 2],
        past_change: &[f64],
        approach: &Approach<B>,
        u_n: &Lanes<f64, B>,
        changes: &mut Changes<B>,
    ) {
        for (i, &set) in sets.iter().enumerate() {
            if u_n.0[i] > 0.0 {
                let asperity = &self.tables.asperities[set as usize];
                let dent = Dent {
                    interference: interference[i],
                    force: force[i],
                };
                let Changes {
                    approach: moved,
                    curves,
                    ..
                } = &mut *changes;
                let unloading = Unloading {
                    residual_depth: moved.depth.0[i],
                    stiffness: moved.stiffness.0[i],
                };
                let w = (approach.interference.0[i], moved.interference.0[i]);
                let change = asperity.slip_limit_change(self.limit, w, (dent, past_change[i]), unloading);
                curves.limit.0[i] = bounded(change.unwrap_or_default());
            }
        }
    }

    /// Puts first loading beyond the onset of yield in the place of unloading. Few points do it at a time.
    fn load<const B: usize>(
        &self,
        sets: &[u32],
        past: &[f64],
        approach: &Approach<B>,
        onset: &Lanes<f64, B>,
        u_n: &Lanes<f64, B>,
        middle: &Lanes<f64, B>,
        stiffness: StiffnessAt,
        curves: &mut CurveBlock<B>,
    ) {
        for (i, &set) in sets.iter().enumerate() {
            let limit = max(past[i], onset.0[i]);
            let w = approach.interference.0[i];
            if u_n.0[i] > 0.0 && w > limit {
                let asperity = &self.tables.asperities[set as usize];
                let contact = asperity.loading(w);
                curves.normal.0[i] = contact.force.value;
                curves.normal_slope.0[i] = contact.force.slope;
                let at = match stiffness {
                    StiffnessAt::End => w,
                    StiffnessAt::Middle => middle.0[i] + approach.depth.0[i],
                };
                if at > limit {
                    let radius = asperity.loading_radius(at);
                    let modulus = asperity.tangential_modulus();
                    for q in 0..2 {
                        curves.tangential[q].0[i] = modulus * radius.value;
                        curves.tangential_slope[q].0[i] = modulus * radius.slope;
                        curves.tangential_curvature[q].0[i] = modulus * radius.curvature;
                    }
                }
            }
        }
    }
}

impl TractionLaw for ResolvedLaw {
    fn info(&self) -> &LawInfo {
        &self.info
    }

    fn len(&self) -> usize {
        self.bins.len()
    }

    evaluates_by!(evaluate_blocks in blocks);

    /// Without yield bin by bin, where the derivatives of what its asperities do serve all adjoints. Otherwise by a derivative for each number of the
    /// jump, of what an annulus remembers and of a dent: bins share nothing but the jump, annuli the dent.
    fn transposed(
        &self,
        points: Range<usize>,
        jump: Components<'_>,
        begin: StateView<'_>,
        way: WayBack,
        adjoints: &mut [Adjoint<'_>],
    ) {
        check_points(&points, self);
        let input = Input { points, jump, begin };
        if let Some(slipping) = self.slipping_together() {
            return match input.points.len() <= SHORT_BLOCK {
                true => self.transposed_blocks::<SHORT_BLOCK>(slipping, &input, way, adjoints),
                false => self.transposed_blocks::<BLOCK>(slipping, &input, way, adjoints),
            };
        }
        let n_bins = self.tables.n_bins;
        let (n_memory, n_dent) = self.memories();
        let per_bin = self.shares.len().max(1);
        let per_part = (n_memory - n_dent) / per_bin;
        let of_bin = |bin: usize| N_JUMP + bin * n_memory..N_JUMP + (bin + 1) * n_memory;
        let place = |state: Range<usize>| transposed::N_JUMP + state.start..transposed::N_JUMP + state.end;
        let motion = [Part {
            input: 0..place(0..N_JUMP).end,
            end: 0..self.info.n_state(),
            tractions: WHOLE,
        }];
        let forces = (0..n_bins * per_bin).map(|part| {
            let first = of_bin(part / per_bin).start + part % per_bin * per_part;
            let memory = first..first + per_part;
            Part {
                input: place(memory.clone()),
                end: memory,
                tractions: WHOLE.end + part..WHOLE.end + part + 1,
            }
        });
        let dents = (0..n_bins).map(|bin| Part {
            input: place(of_bin(bin).end - n_dent..of_bin(bin).end),
            end: of_bin(bin),
            tractions: WHOLE.end + bin * per_bin..WHOLE.end + (bin + 1) * per_bin,
        });
        let (forces, dents): (Vec<Part>, Vec<Part>) = (forces.collect(), dents.collect());
        let passes: [&[Part]; 3] = [&motion, &forces, &dents];
        transposed::transposed(
            &input,
            n_bins * per_bin,
            &passes,
            way,
            adjoints,
            |of, end, traction, along| {
                let Input { points, jump, begin } = of;
                let coulomb = Sticking::Coulomb;
                self.evaluate_blocks::<BLOCK>(points, coulomb, jump, begin, end, traction, None, None, Some(along));
            },
        );
    }

    fn friction_coefficient(&self, point: usize) -> Option<f64> {
        (self.limit == AsperityLimit::Coulomb).then(|| *self.mu.at(point))
    }

    fn dissipates(&self) -> bool {
        self.tables.yields || has_friction(&self.mu)
    }

    fn slips_in_parts(&self) -> bool {
        true
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        let bins = self.bins.at(point);
        let loaded = bins.gaps().iter().zip(bins.densities());
        let sum: f64 = loaded.map(|(gap, density)| density * (u_n - gap).max(0.0)).sum();
        Some(core::f64::consts::PI * bins.asperity().radius() * sum)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        let bins = self.bins.at(point);
        let beyond = |limit: f64| -> f64 {
            let loaded = bins.gaps().iter().zip(bins.densities());
            loaded
                .filter(|(gap, _)| u_n - *gap > limit)
                .map(|(_, density)| density)
                .sum()
        };
        let loaded = beyond(0.0);
        Some(if loaded > 0.0 {
            beyond(omega_c.max(0.0)) / loaded
        } else {
            0.0
        })
    }
}

/// One point of a block, for what is done point by point.
struct Lane {
    i: usize,
    /// First state component of the bin.
    base: usize,
    modulus: f64,
    /// Slip limit over the normal force, and the same of their derivatives.
    mu: [f64; 2],
    /// Interference beyond the residual depth, zero where open, NaN where the input is no number (m).
    u_n: f64,
    fill: f64,
}

/// A direction of the input of a block's points, and where the derivatives of the states go.
struct Direction<'a, const B: usize> {
    jump: [&'a [f64]; 3],
    rows: Rows<'a>,
    changes: &'a mut Changes<B>,
    /// As in [`Along`].
    parts: Option<&'a mut [f64]>,
}

/// Changes along a direction at the points of a block.
struct Changes<const B: usize> {
    approach: ApproachChange<B>,
    /// Interference at which stiffnesses are taken.
    middle: Lanes<f64, B>,
    curves: CurveChange<B>,
    of_annulus: CurveChange<B>,
    sliders: Sliders,
    /// Of what one asperity of a bin answers, or one of its annuli.
    traction: [Lanes<f64, B>; 3],
    /// Of what the points answer.
    sum: [Lanes<f64, B>; 3],
    /// Zero, or NaN where any input or its direction is no number.
    nothing: Lanes<f64, B>,
}

/// Changes of an [`Approach`].
struct ApproachChange<const B: usize> {
    interference: Lanes<f64, B>,
    depth: Lanes<f64, B>,
    stiffness: Lanes<f64, B>,
    u_n: Lanes<f64, B>,
    u_n0: Lanes<f64, B>,
}

impl<const B: usize> Changes<B> {
    fn new() -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            approach: ApproachChange {
                interference: zero,
                depth: zero,
                stiffness: zero,
                u_n: zero,
                u_n0: zero,
            },
            middle: zero,
            curves: CurveChange::new(),
            of_annulus: CurveChange::new(),
            sliders: Sliders {
                before: [[0.0; 2]; MAX_RADII],
                after: [[0.0; 2]; MAX_RADII],
            },
            traction: [zero; 3],
            sum: [zero; 3],
            nothing: zero,
        }
    }
}

impl<const B: usize> Direction<'_, B> {
    /// Nothing is in contact yet; `fill` is NaN where the input is no number.
    fn begin(&mut self, n_state: usize, fill: &Lanes<f64, B>) {
        let Self {
            jump, rows, changes, ..
        } = self;
        let spoilt = &mut changes.curves.fill;
        *spoilt = rows.spread_nan(*jump, n_state);
        for i in 0..B {
            changes.nothing.0[i] = fill.0[i] + spoilt.0[i];
        }
        changes.sum = [changes.nothing; 3];
        rows.end_at(*jump, &changes.nothing);
    }

    /// Adds what a number of asperities per area answer, or one of their annuli.
    fn add(&mut self, part: usize, density: &Lanes<f64, B>) {
        let Rows { n, block, .. } = &self.rows;
        for (q, (sum, own)) in self.changes.sum.iter_mut().zip(&self.changes.traction).enumerate() {
            run(Add(density, own, sum));
            if let Some(parts) = &mut self.parts {
                let values = parts[(3 * part + q) * n..][block.clone()].iter_mut();
                let terms = own.0.iter().zip(&density.0);
                values
                    .zip(terms)
                    .for_each(|(value, (own, density))| *value = density * own);
            }
        }
    }

    /// The direction as the friction of one bin or of an annulus with shares of slip limit and stiffness sees it.
    fn derivative(&mut self, m: usize, memory: usize, annulus: Option<[f64; 2]>) -> Derivative<'_, B> {
        let Self {
            jump, rows, changes, ..
        } = self;
        let Changes {
            approach,
            curves,
            of_annulus,
            traction,
            ..
        } = &mut **changes;
        if let Some([limit, stiffness]) = annulus {
            run(ShareChanges {
                limit,
                stiffness,
                of: curves,
                into: of_annulus,
            });
        }
        Derivative {
            jump: [jump[0], jump[1], &approach.u_n.0[..m]],
            begin: [
                rows.begin(0),
                rows.begin(1),
                &approach.u_n0.0[..m],
                rows.begin(memory),
                rows.begin(memory + 1),
            ],
            curves: if annulus.is_some() { of_annulus } else { curves },
            memory: rows.end::<2>(memory),
            traction: traction.each_mut().map(|lanes| &mut lanes.0[..m]),
        }
    }

    /// Changes of the asperities of a bin at one point, radius by radius.
    fn microslip(&mut self, radii: &Radii, circle: &Circle, base: usize, i: usize, before: &[[f64; 2]]) {
        let Self {
            jump, rows, changes, ..
        } = self;
        let Changes {
            curves,
            sliders,
            traction,
            nothing,
            ..
        } = &mut **changes;
        let radius = bounded(curves.tangential[0].0[i]) / circle.modulus;
        let change = CircleChange {
            radius,
            radius_before: bounded(rows.begin(base)[i]),
            du: [0, 1].map(|q| bounded(jump[q][i] - rows.begin(q)[i])),
            limit: curves.limit.0[i],
        };
        let [before_change, after_change] = [&mut sliders.before[..radii.len()], &mut sliders.after[..radii.len()]];
        rows.gather(base + 1, i, before_change);
        let force = radii.change(circle, &change, before, before_change, after_change);
        rows.scatter(base + 1, i, after_change, nothing.0[i]);
        rows.end::<1>(base)[0][i] = radius + nothing.0[i];
        for (traction, value) in traction.iter_mut().zip([force[0], force[1], curves.normal.0[i]]) {
            traction.0[i] = value;
        }
    }
}

/// Changes of [`Approach`].
struct ApproachChanges<'a, const B: usize> {
    w: &'a [f64],
    u_n0: &'a [f64],
    /// Interference and force of the dents, and their changes.
    dent: Option<[[&'a [f64]; 2]; 2]>,
    onset: &'a Lanes<f64, B>,
    hertz: &'a Lanes<f64, B>,
    change: &'a mut ApproachChange<B>,
}

impl<const B: usize> Pass for ApproachChanges<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let ApproachChange {
            interference,
            depth,
            stiffness,
            u_n,
            u_n0,
        } = self.change;
        let n = self.w.len().min(B);
        let (now, before) = (&self.w[..n], &self.u_n0[..n]);
        for i in 0..n {
            interference.0[i] = now[i];
            u_n.0[i] = bounded(now[i]);
            u_n0.0[i] = bounded(before[i]);
        }
        let Some([[past, force], [past_change, force_change]]) = self.dent else {
            return;
        };
        let (past, force) = (&past[..n], &force[..n]);
        let (past_change, force_change) = (&past_change[..n], &force_change[..n]);
        for i in 0..n {
            let yielded = past[i] > self.onset.0[i];
            let loaded = max(force[i], 0.0);
            let loaded_change = if force[i] > 0.0 { bounded(force_change[i]) } else { 0.0 };
            let past_change = bounded(past_change[i]);
            let elastic = self.hertz.0[i] * past[i].sqrt();
            let plain = loaded / elastic;
            let plain_change = loaded_change / elastic - 0.5 * plain / past[i] * past_change;
            let (beyond, beyond_change) = if plain < past[i] {
                (plain, bounded(plain_change))
            } else {
                (past[i], past_change)
            };
            let power = max(beyond * beyond.sqrt(), f64::MIN_POSITIVE);
            let less = if beyond > 0.0 {
                1.5 * (loaded / power) / beyond * beyond_change
            } else {
                0.0
            };
            depth.0[i] = if yielded { past_change - beyond_change } else { 0.0 };
            stiffness.0[i] = if yielded {
                bounded(bounded(loaded_change / power) - bounded(less))
            } else {
                0.0
            };
            u_n.0[i] = bounded(u_n.0[i] - depth.0[i]);
            u_n0.0[i] = bounded(u_n0.0[i] - depth.0[i]);
        }
    }
}

/// Changes of what [`Hertz`] gives.
struct CurveChanges<'a, const B: usize> {
    halfway: bool,
    u_n: &'a Lanes<f64, B>,
    middle: &'a Lanes<f64, B>,
    u_n0: &'a Lanes<f64, B>,
    stiffness: &'a Lanes<f64, B>,
    hertz: &'a Lanes<f64, B>,
    mindlin: &'a Lanes<f64, B>,
    curves: &'a CurveBlock<B>,
    approach: &'a ApproachChange<B>,
    middle_change: &'a mut Lanes<f64, B>,
    change: &'a mut CurveChange<B>,
}

impl<const B: usize> Pass for CurveChanges<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let CurveChange {
            normal,
            tangential: [k_x, k_y],
            tangential_slope: [slope_x, slope_y],
            ..
        } = self.change;
        for i in 0..B {
            let (u, m) = (self.u_n.0[i], self.middle.0[i]);
            let closing = self.approach.u_n.0[i];
            let stiffening = self.approach.stiffness.0[i];
            let reopened = self.u_n0.0[i] < 0.0;
            let from = if reopened { 0.0 } else { self.approach.u_n0.0[i] };
            let moved = if self.halfway {
                0.5 * closing + 0.5 * from
            } else {
                closing
            };
            let root = u.sqrt();
            let pressing = bounded(1.5 * root * self.stiffness.0[i]) * closing;
            let slope = self.curves.tangential_slope[0].0[i];
            let per_stiffness = m.sqrt() * self.mindlin.0[i] / self.hertz.0[i];
            let k = bounded(bounded(slope) * moved + bounded(per_stiffness) * stiffening);
            let steeper = bounded(0.5 * k / m - bounded(slope / m) * moved);
            self.middle_change.0[i] = moved;
            normal.0[i] = pressing + bounded(u * root) * stiffening;
            (k_x.0[i], k_y.0[i]) = (k, k);
            (slope_x.0[i], slope_y.0[i]) = (steeper, steeper);
        }
    }
}

/// Changes of Coulomb's limit.
struct CoulombChanges<'a, const B: usize> {
    mu: &'a Lanes<f64, B>,
    normal: &'a Lanes<f64, B>,
    limit: &'a mut Lanes<f64, B>,
}

impl<const B: usize> Pass for CoulombChanges<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        for i in 0..B {
            self.limit.0[i] = self.mu.0[i] * bounded(self.normal.0[i]);
        }
    }
}

/// Share of an annulus in the changes of the curves of its asperity.
struct ShareChanges<'a, const B: usize> {
    limit: f64,
    stiffness: f64,
    of: &'a CurveChange<B>,
    into: &'a mut CurveChange<B>,
}

impl<const B: usize> Pass for ShareChanges<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            limit,
            stiffness,
            of,
            into,
        } = self;
        for i in 0..B {
            into.normal.0[i] = limit * of.normal.0[i];
            into.limit.0[i] = limit * of.limit.0[i];
            into.fill.0[i] = of.fill.0[i];
        }
        for q in 0..2 {
            for i in 0..B {
                into.tangential[q].0[i] = stiffness * of.tangential[q].0[i];
                into.tangential_slope[q].0[i] = stiffness * of.tangential_slope[q].0[i];
            }
        }
    }
}

/// Puts changes at first loading beyond the onset of yield in the place of those at unloading, as [`ResolvedLaw::load`] does.
fn load_changes<const B: usize>(
    m: usize,
    past: &[f64],
    approach: &Approach<B>,
    onset: &Lanes<f64, B>,
    u_n: &Lanes<f64, B>,
    middle: &Lanes<f64, B>,
    stiffness: StiffnessAt,
    curves: &CurveBlock<B>,
    changes: &mut Changes<B>,
) {
    let Changes {
        approach: moved,
        middle: middle_change,
        curves: change,
        ..
    } = changes;
    for i in 0..m {
        let limit = max(past[i], onset.0[i]);
        let w = approach.interference.0[i];
        if u_n.0[i] > 0.0 && w > limit {
            let closing = bounded(moved.interference.0[i]);
            change.normal.0[i] = bounded(curves.normal_slope.0[i]) * closing;
            let (at, at_change) = match stiffness {
                StiffnessAt::End => (w, closing),
                StiffnessAt::Middle => (
                    middle.0[i] + approach.depth.0[i],
                    bounded(middle_change.0[i] + moved.depth.0[i]),
                ),
            };
            if at > limit {
                for q in 0..2 {
                    change.tangential[q].0[i] = bounded(curves.tangential_slope[q].0[i]) * at_change;
                    change.tangential_slope[q].0[i] = bounded(curves.tangential_curvature[q].0[i]) * at_change;
                }
            }
        }
    }
}

/// Scratch for the numbers of a block.
struct Scratch<const B: usize> {
    sets: [u32; B],
    gap: Lanes<f64, B>,
    density: Lanes<f64, B>,
    hertz: Lanes<f64, B>,
    mindlin: Lanes<f64, B>,
    onset: Lanes<f64, B>,
    mu: Lanes<f64, B>,
    /// Slip limits over normal forces, and the same of their derivatives.
    ratio: [Lanes<f64, B>; 2],
    fill: Lanes<f64, B>,
    approach: Approach<B>,
    u_n: Lanes<f64, B>,
    middle: Lanes<f64, B>,
    curves: CurveBlock<B>,
    of_annulus: CurveBlock<B>,
    workspace: Workspace<B>,
    box_workspace: Option<BoxWorkspace<B>>,
    /// What one asperity of a bin answers, or one of its annuli.
    bin: Response<B>,
    /// The sum over its annuli.
    of_bin: Response<B>,
    sliders: Sliders,
    sums: Sums<B>,
}

/// Tractions at the radii of one asperity.
struct Sliders {
    before: [[f64; 2]; MAX_RADII],
    after: [[f64; 2]; MAX_RADII],
}

/// Tractions, and tangent row by row.
struct Response<const B: usize> {
    traction: [Lanes<f64, B>; 3],
    tangent: [Lanes<f64, B>; 9],
}

impl<const B: usize> Response<B> {
    /// All numbers are `number`.
    fn of(number: Lanes<f64, B>) -> Self {
        Self {
            traction: [number; 3],
            tangent: [number; 9],
        }
    }

    /// Adds what an annulus answers, of the tangent some entries.
    fn sum_up(&mut self, annulus: &Self, entries: &[usize]) {
        for (sum, part) in self.traction.iter_mut().zip(&annulus.traction) {
            run(Sum(part, sum));
        }
        for &entry in entries {
            run(Sum(&annulus.tangent[entry], &mut self.tangent[entry]));
        }
    }

    /// Adds what a number of asperities per area answer, of the tangent some entries.
    fn add(&mut self, density: &Lanes<f64, B>, part: &Self, entries: &[usize]) {
        for (sum, part) in self.traction.iter_mut().zip(&part.traction) {
            run(Add(density, part, sum));
        }
        for &entry in entries {
            run(Add(density, &part.tangent[entry], &mut self.tangent[entry]));
        }
    }
}

/// What the points answer.
struct Sums<const B: usize> {
    response: Response<B>,
    /// Regimes of all bins that hold asperities, bit by bit.
    regimes: Lanes<u64, B>,
}

impl<const B: usize> Sums<B> {
    /// Nothing is in contact yet; `fill` is NaN where the input is no number.
    fn begin(&mut self, fill: &Lanes<f64, B>) {
        self.response = Response::of(*fill);
        self.regimes.0 = [0; B];
    }

    /// Adds what a number of asperities per area answer, of the tangent some entries.
    fn add(&mut self, density: &Lanes<f64, B>, part: &Response<B>, regime: &Lanes<u64, B>, entries: &[usize]) {
        self.response.add(density, part, entries);
        self.merge(density, regime);
    }

    /// Regimes of asperities, if there are any.
    fn merge(&mut self, density: &Lanes<f64, B>, regime: &Lanes<u64, B>) {
        run(Merge(density, regime, &mut self.regimes));
    }
}

/// Where the asperities of a bin are.
struct Approach<const B: usize> {
    /// Interference (m).
    interference: Lanes<f64, B>,
    /// Residual depth (m).
    depth: Lanes<f64, B>,
    /// Normal force over the interference beyond the residual depth to the power 3/2.
    stiffness: Lanes<f64, B>,
    /// Interference beyond the residual depth, now and at the begin state.
    u_n: Lanes<f64, B>,
    u_n0: Lanes<f64, B>,
}

impl<const B: usize> Scratch<B> {
    fn new(cone: Cone) -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            sets: [0; B],
            gap: zero,
            density: zero,
            hertz: zero,
            mindlin: zero,
            onset: zero,
            mu: zero,
            ratio: [zero; 2],
            fill: zero,
            approach: Approach {
                interference: zero,
                depth: zero,
                stiffness: zero,
                u_n: zero,
                u_n0: zero,
            },
            u_n: zero,
            middle: zero,
            curves: CurveBlock::new(),
            of_annulus: CurveBlock::new(),
            workspace: Workspace::new(),
            box_workspace: (cone == Cone::Box).then(BoxWorkspace::new),
            bin: Response::of(zero),
            of_bin: Response::of(zero),
            sliders: Sliders {
                before: [[0.0; 2]; MAX_RADII],
                after: [[0.0; 2]; MAX_RADII],
            },
            sums: Sums {
                response: Response::of(zero),
                regimes: Lanes([0; B]),
            },
        }
    }
}

/// Sum of what the annuli of a bin carry.
struct Sum<'a, const B: usize>(&'a Lanes<f64, B>, &'a mut Lanes<f64, B>);

impl<const B: usize> Pass for Sum<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(part, sum) = self;
        for i in 0..B {
            sum.0[i] += part.0[i];
        }
    }
}

/// Sum of what the bins carry.
struct Add<'a, const B: usize>(&'a Lanes<f64, B>, &'a Lanes<f64, B>, &'a mut Lanes<f64, B>);

impl<const B: usize> Pass for Add<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(density, part, sum) = self;
        for i in 0..B {
            sum.0[i] += within(density.0[i] * part.0[i], LARGEST);
        }
    }
}

/// Regimes that some asperities are in.
struct Merge<'a, const B: usize>(&'a Lanes<f64, B>, &'a Lanes<u64, B>, &'a mut Lanes<u64, B>);

impl<const B: usize> Pass for Merge<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(density, regime, merged) = self;
        for i in 0..B {
            merged.0[i] |= if density.0[i] > 0.0 { regime.0[i] } else { 0 };
        }
    }
}

/// Share of an annulus in the curves of its asperity.
struct Share<'a, const B: usize> {
    limit: f64,
    stiffness: f64,
    of: &'a CurveBlock<B>,
    into: &'a mut CurveBlock<B>,
}

impl<const B: usize> Pass for Share<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            limit,
            stiffness,
            of,
            into,
        } = self;
        for i in 0..B {
            into.normal.0[i] = limit * bounded(of.normal.0[i]);
            into.normal_slope.0[i] = limit * bounded(of.normal_slope.0[i]);
        }
        for q in 0..2 {
            for i in 0..B {
                into.tangential[q].0[i] = stiffness * bounded(of.tangential[q].0[i]);
                into.tangential_slope[q].0[i] = stiffness * bounded(of.tangential_slope[q].0[i]);
                into.tangential_curvature[q].0[i] = stiffness * bounded(of.tangential_curvature[q].0[i]);
            }
        }
    }
}

/// Asperities without a past.
struct Elastic<'a, const B: usize> {
    u_n: &'a [f64],
    u_n0: &'a [f64],
    gap: &'a Lanes<f64, B>,
    fill: &'a Lanes<f64, B>,
    hertz: &'a Lanes<f64, B>,
    approach: &'a mut Approach<B>,
}

impl<const B: usize> Pass for Elastic<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Approach {
            interference,
            depth,
            stiffness,
            u_n,
            u_n0,
        } = self.approach;
        let n = self.u_n.len().min(B);
        let (now, before) = (&self.u_n[..n], &self.u_n0[..n]);
        // Beyond the points nothing is closed.
        u_n.0[n..].fill(0.0);
        for i in 0..n {
            let w = now[i] - self.gap.0[i] + self.fill.0[i];
            interference.0[i] = w;
            u_n.0[i] = w;
            u_n0.0[i] = before[i] - self.gap.0[i];
            depth.0[i] = 0.0;
            stiffness.0[i] = self.hertz.0[i];
        }
    }
}

/// Asperities with a dent: see [`Asperity::unloading`].
struct Unload<'a, const B: usize> {
    interference: &'a [f64],
    force: &'a [f64],
    onset: &'a Lanes<f64, B>,
    hertz: &'a Lanes<f64, B>,
    approach: &'a mut Approach<B>,
}

impl<const B: usize> Pass for Unload<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Approach {
            depth,
            stiffness,
            u_n,
            u_n0,
            ..
        } = self.approach;
        let n = self.interference.len().min(B);
        let (past, force) = (&self.interference[..n], &self.force[..n]);
        for i in 0..n {
            let yielded = past[i] > self.onset.0[i];
            let force = max(force[i], 0.0);
            let beyond = min(force / (self.hertz.0[i] * past[i].sqrt()), past[i]);
            let residual = past[i] - beyond;
            // A begin state that no loading leaves has a dent without force.
            let factor = force / max(beyond * beyond.sqrt(), f64::MIN_POSITIVE);
            depth.0[i] = if yielded { residual } else { 0.0 };
            stiffness.0[i] = if yielded { factor } else { self.hertz.0[i] };
            u_n.0[i] -= depth.0[i];
            u_n0.0[i] -= depth.0[i];
        }
    }
}

/// Interferences at which the forces are needed, as [`Start`](super::block_start::Start) has them for points.
struct Close<'a, const B: usize> {
    halfway: bool,
    fill: &'a Lanes<f64, B>,
    approach: &'a Approach<B>,
    u_n: &'a mut Lanes<f64, B>,
    middle: &'a mut Lanes<f64, B>,
    present: &'a mut Present,
}

/// What is closed, and the interferences at which its forces are needed.
fn close<const B: usize>(
    stiffness: StiffnessAt,
    fill: &Lanes<f64, B>,
    approach: &Approach<B>,
    u_n: &mut Lanes<f64, B>,
    middle: &mut Lanes<f64, B>,
) -> Present {
    let mut present = Present::default();
    run(Close {
        halfway: stiffness == StiffnessAt::Middle,
        fill,
        approach,
        u_n,
        middle,
        present: &mut present,
    });
    present
}

impl<const B: usize> Pass for Close<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let (mut n_closed, mut n_reclosed) = (0_u64, 0_u64);
        for i in 0..B {
            let (u_n, u_n0) = (self.approach.u_n.0[i], self.approach.u_n0.0[i]);
            // Not where the input is no number, which is in the interference.
            let closed = u_n > 0.0;
            let from = if self.halfway { max(u_n0, 0.0) } else { u_n };
            let mean = max(0.5 * u_n + 0.5 * from, f64::from_bits(1));
            self.u_n.0[i] = if closed { u_n } else { self.fill.0[i] };
            self.middle.0[i] = if closed { mean } else { 0.0 };
            n_closed += u64::from(closed);
            n_reclosed += u64::from(closed & (u_n0 < 0.0));
        }
        *self.present = Present {
            closed: n_closed > 0,
            reclosed: n_reclosed > 0,
        };
    }
}

/// Normal force and tangential stiffness of asperities that do not yield now.
struct Hertz<'a, const B: usize> {
    u_n: &'a Lanes<f64, B>,
    middle: &'a Lanes<f64, B>,
    approach: &'a Approach<B>,
    hertz: &'a Lanes<f64, B>,
    mindlin: &'a Lanes<f64, B>,
    /// Whether there are dents, so that stiffnesses differ from those of the elastic contact.
    dented: bool,
    /// Whether `middle` is `u_n` where a point is closed.
    at_end: bool,
    curvature: bool,
    curves: &'a mut CurveBlock<B>,
}

impl<const B: usize> Pass for Hertz<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let CurveBlock {
            normal,
            normal_slope,
            tangential: [k_x, k_y],
            tangential_slope: [slope_x, slope_y],
            tangential_curvature: [curvature_x, curvature_y],
        } = self.curves;
        for i in 0..B {
            let stiffness = self.approach.stiffness.0[i];
            let (u, m) = (self.u_n.0[i], self.middle.0[i]);
            let u_root = u.sqrt();
            let root = u_root * stiffness;
            normal.0[i] = u * root;
            normal_slope.0[i] = 1.5 * root;
            let m_root = if self.at_end { u_root } else { m.sqrt() };
            let share = if self.dented { stiffness / self.hertz.0[i] } else { 1.0 };
            let k = m_root * self.mindlin.0[i] * share;
            let slope = 0.5 * k / m;
            (k_x.0[i], k_y.0[i]) = (k, k);
            (slope_x.0[i], slope_y.0[i]) = (slope, slope);
            if self.curvature {
                let curvature = -0.5 * slope / m;
                (curvature_x.0[i], curvature_y.0[i]) = (curvature, curvature);
            }
        }
    }
}
