//! Elastic contact with friction as a foundation of linear springs: the method of dimensionality reduction.
//!
//! Any elastic contact whose normal traction `t_n(u_n)` grows with a stiffness `k(u_n)` that does not fall, has the same normal tractions as
//! springs of stiffness `dk` that touch at the gaps `g`. By the theorem of Ciavarella and Jaeger, they have its tangential tractions too: every spring has the
//! tangential stiffness `r dk`, with Mindlin's ratio `r = 2 (1 - nu)/(2 - nu)`, and Coulomb's limit of its own.
//! <div>
//! $$ t_n = \sum_j \kappa_j (u_n - g_j)_+, \qquad \boldsymbol{t}_t = r \sum_j \kappa_j \boldsymbol{e}_j, \qquad
//! |\boldsymbol{e}_j| \le \frac{\mu}{r} (u_n - g_j)_+ , \qquad
//! \boldsymbol{t}_t = \mu \left[ t_n(u_n) - t_n\left(u_n - \frac{r}{\mu} |\boldsymbol{u}_t|\right) \right]
//! \frac{\boldsymbol{u}_t}{|\boldsymbol{u}_t|} $$
//! </div>
//!
//! The last equation is that of first loading at constant `u_n`: partial slip as Cattaneo and Mindlin found it for the sphere, and for asperities
//! that differ or influence one another. The first ones hold for any path, as far as those authors' assumptions do: equal bodies, slip along
//! the load, no influence of tangential on normal tractions.
//!
//! # History
//! A spring remembers its stretch `e`. On a step it stretches by the step's tangential motion, of which a spring that was open counts the
//! share `f = w/(w - w_0)` after it has closed, with `w = u_n - g` now and `w_0` before; beyond its limit it slips and keeps the direction
//! of the trial. Stiffnesses are constant, so no closed path gives energy.
//!
//! # Springs
//! [`Growth::springs`] takes the springs of a curve from Gauss rules in the stiffness, which keep its mass and first three moments in every
//! interval of gaps. With shifted intervals at neighbouring points the errors of single points cancel in their mean, also of cycles so small that
//! only the springs slip that touched last.
//!
//! Errors of the mean over 16 shifts for one sphere, with `x` the motion over that of gross slip: of the pressure, of the loading curve relative to
//! gross slip, of the area of cycles.
//!
//! | springs | pressure | loading | cycles, `x` in 0.1..2 | cycles, `x` in 0.01..0.1 |
//! |---|---|---|---|---|
//! | 8 | 1.6e-5 | 4.6e-3 | 4.6e-2 | 1 |
//! | 16 | 8.7e-7 | 1.2e-3 | 1.5e-2 | 0.56 |
//! | 32 | 2.5e-6 | 1.2e-3 | 7.3e-3 | 6.4e-2 |
//! | 64 | 2.4e-6 | 1.2e-4 | 2.0e-3 | 2.5e-2 |
//!
//! Where the interference at rest is known, [`Growth::springs_about`] places them closer together towards it, as those slip first:
//!
//! | springs | pressure | loading | cycles, `x` in 0.1..2 | 0.01..0.1 | 1e-3..0.01 | 1e-4..1e-3 |
//! |---|---|---|---|---|---|---|
//! | 16 | 2.5e-6 | 5.9e-3 | 6.1e-2 | 7.5e-2 | 0.10 | 0.13 |
//! | 32 | 2.5e-6 | 6.9e-4 | 1.0e-2 | 7.0e-3 | 1.0e-2 | 1.4e-2 |
//! | 48 | 2.5e-6 | 5.5e-4 | 3.6e-3 | 2.1e-3 | 3.2e-3 | 3.9e-3 |
//!
//! Where the pressure changes as well, [annuli](crate::AsperityFriction::Annuli), which keep their places relative to the contact radius, are not the same
//! contact: on a path of a test that is pressed further while it slips, they differ by 7 % of gross slip. Springs follow Mindlin and Deresiewicz there: pressed and moved in proportion, they do not slip.
//!
//! # Parameters and state
//! | quantity | unit |
//! |---|---|
//! | gap and stiffness of every spring | m, Pa/m |
//! | ratio of tangential to normal stiffness | 1 |
//! | friction coefficient `mu`, per point | 1 |
//! | state `u_x, u_y, u_n` of the point committed last | m |
//! | state `stretch_x, stretch_y` of every spring | m |
//!
//! [`Regime::Slip`] is gross slip: all springs in contact slip.
//!
//! Sources: V. L. Popov and M. Hess, *Method of Dimensionality Reduction in Contact Mechanics and Friction*, Springer 2015; M. Ciavarella, *The
//! generalized Cattaneo partial slip plane contact problem*, Int. J. Solids Struct. 35 (1998) 2349-2362; J. Jaeger, *A new principle in contact
//! mechanics*, J. Tribol. 120 (1998) 677-684.
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! // A sphere of 1 mm against its like: the stiffness grows as the root of the interference.
//! let gaps = GapDistribution::try_from_samples(vec![0.0])?;
//! let steel = ElasticPair::new(200e9, 0.3);
//! let sphere = AsperityPopulation::try_new(gaps, 1e6, [1e-3; 2])?;
//! let curves = AsperitySumCurves::try_new(sphere, steel, TangentialReading::Mindlin)?;
//! let (at, mu) = (PointParameters::uniform(curves.clone(), 1), PointParameters::uniform(0.3, 1));
//! let law = FoundationLaw::of_curves(at, mu, steel.mindlin_ratio(), 64, 2e-6)?;
//!
//! // Pressed by 1 um and moved to half of gross slip.
//! let mut begin = vec![0.0; law.info().n_state()];
//! begin[2] = 1e-6;
//! let mut end = begin.clone();
//! let [mut t_x, mut t_y, mut t_n] = [[0.0]; 3];
//! law.evaluate(
//!     0..1,
//!     Sticking::Coulomb,
//!     Components::new(&[0.5e-6 * 0.3 / steel.mindlin_ratio()], &[0.0], &[1e-6]),
//!     StateView::new(&begin, 1, 0),
//!     StateViewMut::new(&mut end, 1, 0),
//!     ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
//!     None,
//!     None,
//! );
//! let (pressed, _) = curves.normal(1e-6);
//! assert!((t_n[0] / pressed - 1.0).abs() < 1e-3);
//! assert!((t_x[0] / (0.3 * pressed) - (1.0 - 0.5_f64.powf(1.5))).abs() < 2e-3);
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use super::block_start::Rows;
use super::return_map::{OPEN, SLIP, STICK, of_parts};
use super::{JUMP, MU, has_friction, require_friction};
use crate::curves::ContactCurves;
use crate::error::{Error, Place, require};
use crate::law::{
    Along, Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking,
    TangentMut, TractionLaw, check_path, check_points, evaluates_by, step_by_step,
};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter, PointParameters};
use crate::physics::bins::{GaussSet, MAX_BINS, between_third_and_whole, gauss_between, gauss_sets, relative_errors};
use crate::physics::population::GapDistribution;
use crate::simd::bounds::bounded;
use crate::simd::elementary::{max, min};
use crate::simd::{BLOCK, Lanes, Pass, WIDTH, lanes, part, part_mut, run};
use crate::transposed::{Adjoint, WayBack};
use alloc::borrow::Cow;
use alloc::format;
use alloc::vec::Vec;
use core::ops::Range;

/// State components before those of the springs: the jump.
const N_JUMP: usize = 3;

/// Square of the largest stretch and of the largest limit.
const LARGEST: f64 = 1e300;

/// Intervals of the interference in which the growth of the stiffness is taken as even: up to the reach, and beyond.
const EVEN: [usize; 2] = [4096, 512];

/// Of the springs about an interference, one part of so many lies above it.
const SHARE_ABOVE: usize = 3;

/// Distances of the nearest limit from the interference at rest, over the interference below it and the rest of the reach above it.
const FINEST: [f64; 2] = [2e-5, 1e-3];

/// Exponent of the limits' logarithms: of 1 to 2.5 the one with the smallest errors of cycles from a thousandth of gross slip on.
const GRADING: f64 = 1.3;

/// Springs with fewer are not placed about an interference.
const LEAST_ABOUT: usize = 12;

/// Least reach over an interference at rest.
const REACH_BEYOND_REST: f64 = 1.5;

/// Up to where the stiffness grows, over the reach.
pub const BEYOND_REACH: f64 = 4.0;

const GAP: Parameter = Parameter::new("spring_gap", "m", Bounds::Within([0.0, 1e100], "from 0 to 1e100"));
const STIFFNESS: Parameter = Parameter::new("spring_stiffness", "Pa/m", GAP.bounds);
const RATIO: Parameter = Parameter::new(
    "tangential_ratio",
    "1",
    Bounds::Within([1e-3, 1e3], "from 0.001 to 1000"),
);
const COUNT: Parameter = Parameter::new("springs", "1", Bounds::Within([1.0, MAX_BINS as f64], "from 1 to 1024"));

/// Linear springs that stand for the contact of an area.
#[derive(Debug, Clone, PartialEq)]
pub struct Foundation {
    gaps: Vec<f64>,
    stiffnesses: Vec<f64>,
    ratio: f64,
}

impl Foundation {
    /// From the gap (m, not negative) and the stiffness (Pa/m, not negative) of every spring, and the ratio of its tangential to its normal
    /// stiffness.
    ///
    /// # Errors
    /// [`Error::Length`] when the lists differ in length, [`Error::Parameter`] when there are no springs or more than [`MAX_BINS`], or when an
    /// entry is out of bounds.
    pub fn try_new(gaps: Vec<f64>, stiffnesses: Vec<f64>, ratio: f64) -> Result<Self, Error> {
        COUNT.check(gaps.len() as f64)?;
        RATIO.check(ratio)?;
        if stiffnesses.len() != gaps.len() {
            return Err(Error::Length {
                list: "stiffnesses of the springs",
                expected: gaps.len(),
                found: stiffnesses.len(),
            });
        }
        for (parameter, values) in [(GAP, &gaps), (STIFFNESS, &stiffnesses)] {
            for (i, &value) in values.iter().enumerate() {
                parameter.check_at(Place::Entry(i), value)?;
            }
        }
        Ok(Self {
            gaps,
            stiffnesses,
            ratio,
        })
    }

    /// [`AsperityBins::errors`](crate::AsperityBins::errors) of sets of springs.
    pub fn errors(sets: &[Self], reference: &Self, reach: f64, smallest: f64) -> [f64; 3] {
        // The stiffness has a step at every spring.
        let interferences: Vec<f64> = between_third_and_whole(reach, 1000).collect();
        let cycles: Vec<(f64, Range<usize>)> = interferences.iter().map(|u| (*u, 0..sets.len())).collect();
        Self::errors_in(sets, reference, (&interferences, &cycles), reach, smallest)
    }

    /// The same of springs about interferences, of which each stands beside its springs: cycles are at those alone.
    pub fn errors_about(sets: &[(f64, Vec<Self>)], reference: &Self, reach: f64, smallest: f64) -> [f64; 3] {
        let interferences: Vec<f64> = between_third_and_whole(reach, 1000).collect();
        let all: Vec<Self> = sets.iter().flat_map(|(_, springs)| springs.iter().cloned()).collect();
        let mut first = 0;
        let cycles = sets.iter().map(|(rest, springs)| {
            let own = first..first + springs.len();
            first = own.end;
            (*rest, own)
        });
        let cycles: Vec<(f64, Range<usize>)> = cycles.collect();
        Self::errors_in(&all, reference, (&interferences, &cycles), reach, smallest)
    }

    fn errors_in(
        sets: &[Self],
        reference: &Self,
        of: (&[f64], &[(f64, Range<usize>)]),
        reach: f64,
        smallest: f64,
    ) -> [f64; 3] {
        let sets: Vec<_> = sets.iter().map(Self::parts).collect();
        let forms: [&dyn Fn(f64) -> f64; 2] = [&|w| w, &|_| 1.0];
        relative_errors(&sets, reference.parts(), of, reach, smallest, forms)
    }

    fn parts(&self) -> [&[f64]; 2] {
        [&self.gaps, &self.stiffnesses]
    }

    /// Gaps (m).
    pub fn gaps(&self) -> &[f64] {
        &self.gaps
    }

    /// Normal stiffnesses (Pa/m).
    pub fn stiffnesses(&self) -> &[f64] {
        &self.stiffnesses
    }

    /// Tangential over normal stiffness.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }
}

/// How the stiffness of curves grows with the interference: what springs are taken from.
#[derive(Debug, Clone)]
pub struct Growth {
    /// Share of the stiffness by the interference at which it is there.
    shares: GapDistribution,
    /// Stiffness at the largest interference (Pa/m).
    total: f64,
    ratio: f64,
    reach: f64,
}

impl Growth {
    /// Of curves whose tangential over normal stiffness is `ratio`, with most detail up to the interference `reach` (m), and none beyond
    /// `largest`, where the stiffness stays.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a number is out of bounds, or when the stiffness of the curves falls somewhere: no springs do that.
    pub fn of_curves(
        curves: &(impl ContactCurves + ?Sized),
        ratio: f64,
        reach: f64,
        largest: f64,
    ) -> Result<Self, Error> {
        let ok = reach > 0.0 && largest > reach && largest.is_finite();
        require(
            ok,
            "reach",
            reach,
            "m",
            Place::Whole,
            "above zero, and finite and below the largest interference",
        )?;
        // At once: a stiffness that is there from the beginning.
        let beginning = 1e-9 * reach;
        let up_to = (0..EVEN[0]).map(|i| beginning.max(reach * i as f64 / EVEN[0] as f64));
        let beyond = (0..=EVEN[1]).map(|i| reach + (largest - reach) * i as f64 / EVEN[1] as f64);
        let mut gaps = alloc::vec![0.0];
        let mut stiffnesses = alloc::vec![0.0];
        for u in up_to.chain(beyond) {
            let (_, stiffness) = curves.normal(u);
            let last = stiffnesses[stiffnesses.len() - 1];
            let requirement = "not falling with the interference";
            let ok = stiffness >= last * (1.0 - 1e-9) && stiffness.is_finite();
            require(ok, "normal stiffness", stiffness, "Pa/m", Place::Whole, requirement)?;
            gaps.push(u);
            stiffnesses.push(max(stiffness, last));
        }
        let total = stiffnesses[stiffnesses.len() - 1];
        require(
            total > 0.0,
            "normal stiffness",
            total,
            "Pa/m",
            Place::Whole,
            "above zero",
        )?;
        let mut shares: Vec<f64> = stiffnesses.iter().map(|stiffness| stiffness / total).collect();
        let last = shares.len() - 1;
        shares[last] = 1.0;
        Ok(Self {
            shares: GapDistribution::try_from_quantiles(&shares, &gaps)?,
            total,
            ratio,
            reach,
        })
    }

    /// `n` springs, an even number, up to the reach and up to four beyond; once for each of the `shifts` from 0 to 1
    /// ([`AsperityBins::gauss`](crate::AsperityBins::gauss)).
    ///
    /// # Errors
    /// [`Error::Parameter`] when a number is out of bounds.
    pub fn springs(&self, n: usize, shifts: &[f64]) -> Result<Vec<Foundation>, Error> {
        let sets = gauss_sets(&self.shares, n, self.reach, shifts)?.into_iter();
        sets.map(|set| self.foundation(set)).collect()
    }

    /// `n` springs, an even number, and up to two beyond the reach, that are the closer together the closer their gaps are to the interference
    /// `rest` (m): those are the first to slip, to open and to close when the contact vibrates about it. Shifts from 0 to 1 move the limits
    /// between them.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a number is out of bounds.
    pub fn springs_about(&self, rest: f64, n: usize, shift: f64) -> Result<Foundation, Error> {
        let reach = max(self.reach, REACH_BEYOND_REST * rest);
        if !(rest > 1e-3 * reach) || n < LEAST_ABOUT {
            return Ok(self.springs(n, &[shift])?.remove(0));
        }
        let above = n / 2 / SHARE_ABOVE;
        let below = n / 2 - above;
        let limits =
            |count: usize, finest: f64| move |k: usize| finest.powf(((k as f64 + shift) / count as f64).powf(GRADING));
        let (from_below, from_above) = (limits(below - 1, FINEST[0]), limits(above - 1, FINEST[1]));
        let inner = (0..below - 1).map(|k| rest * (1.0 - from_below(k)));
        let outer = (0..above - 1).rev().map(|k| rest + (reach - rest) * from_above(k));
        let largest = self.shares.largest();
        let limits = inner.chain([rest]).chain(outer).chain([reach, largest]);
        let limits: Vec<f64> = limits
            .map(|limit| limit.min(largest))
            .filter(|limit| *limit > 0.0)
            .collect();
        self.foundation(gauss_between(&self.shares, &limits))
    }

    fn foundation(&self, (gaps, shares): GaussSet) -> Result<Foundation, Error> {
        let stiffnesses = shares.into_iter().map(|share| share * self.total).collect();
        Foundation::try_new(gaps, stiffnesses, self.ratio)
    }
}

/// Springs of contact curves, with friction. State per point: `u_x, u_y, u_n` (m), then the stretch of every spring along x and y (m).
#[derive(Debug, Clone)]
pub struct FoundationLaw<C> {
    springs: PointParameters<Foundation>,
    curves: PointParameters<C>,
    mu: PointParameters<f64>,
    n_springs: usize,
    /// Of every spring and point, `[spring][point]`. Points with fewer springs end with some of no stiffness.
    gaps: Vec<f64>,
    stiffnesses: Vec<f64>,
    /// Of every point.
    ratios: Vec<f64>,
    info: LawInfo,
}

impl<C: ContactCurves> FoundationLaw<C> {
    /// A law over `springs.len()` points with the friction coefficient `mu` per point. The curves say the contact area and how much yields.
    ///
    /// # Errors
    /// [`Error::Length`] when curves or `mu` have another number of points, [`Error::Parameter`] when a coefficient is negative or not finite.
    pub fn try_new(
        springs: PointParameters<Foundation>,
        curves: PointParameters<C>,
        mu: PointParameters<f64>,
    ) -> Result<Self, Error> {
        require_friction(&mu, springs.len())?;
        if curves.len() != springs.len() {
            return Err(Error::Length {
                list: "curves",
                expected: springs.len(),
                found: curves.len(),
            });
        }
        let n_springs = springs.sets().iter().map(|set| set.gaps.len()).max().unwrap_or(0);
        let at_points = || (0..springs.len()).map(|point| springs.at(point));
        let of_all = |of: &dyn Fn(&Foundation, usize) -> f64| {
            let springs = (0..n_springs).flat_map(|spring| at_points().map(move |set| of(set, spring)));
            springs.collect::<Vec<f64>>()
        };
        let gaps = of_all(&|set, spring| set.gaps[spring.min(set.gaps.len() - 1)]);
        let stiffnesses = of_all(&|set, spring| set.stiffnesses.get(spring).copied().unwrap_or(0.0));
        let ratios = at_points().map(|set| set.ratio).collect();
        let stretches = (1..=n_springs).flat_map(|j| {
            ["x", "y"].map(|q| Quantity {
                name: Cow::Owned(format!("stretch_{q}_{j}")),
                unit: "m",
            })
        });
        let info = LawInfo {
            name: "elastic foundation",
            reference: "10.1007/978-3-642-53876-6",
            state: JUMP.into_iter().chain(stretches).collect(),
            parameters: [GAP, STIFFNESS, RATIO]
                .map(|of| of.quantity())
                .into_iter()
                .chain([MU])
                .collect(),
        };
        Ok(Self {
            springs,
            curves,
            mu,
            n_springs,
            gaps,
            stiffnesses,
            ratios,
            info,
        })
    }

    /// Foundations of `n` springs up to the interference `reach` (m) for curves, whose tangential over normal stiffness is `ratio`.
    ///
    /// # Errors
    /// As [`Growth::of_curves`], [`Growth::springs`] and [`Self::try_new`].
    pub fn of_curves(
        curves: PointParameters<C>,
        mu: PointParameters<f64>,
        ratio: f64,
        n: usize,
        reach: f64,
    ) -> Result<Self, Error> {
        let springs = curves.try_map(|curves| {
            let growth = Growth::of_curves(curves, ratio, reach, BEYOND_REACH * reach)?;
            Ok(growth.springs(n, &[0.5])?.remove(0))
        })?;
        Self::try_new(springs, curves, mu)
    }

    /// The springs of every point.
    pub fn springs(&self) -> &PointParameters<Foundation> {
        &self.springs
    }

    /// The curves of every point.
    pub fn curves(&self) -> &PointParameters<C> {
        &self.curves
    }

    /// The friction coefficients.
    pub fn mu(&self) -> &PointParameters<f64> {
        &self.mu
    }

    /// Springs' limits over their interference at points from `first` on.
    fn reaches(&self, first: usize, reach: &mut [f64]) {
        self.mu.copy_to(first, reach);
        for (reach, ratio) in reach.iter_mut().zip(&self.ratios[first..]) {
            *reach = bounded(*reach / ratio);
        }
    }

    /// Springs' limits over their interference at a block of points from `first` on.
    fn begin_block<const B: usize>(&self, first: usize, sticking: Sticking, m: usize, room: &mut Room<B>) {
        match sticking {
            Sticking::Frictionless => room.reach.0 = [0.0; B],
            Sticking::Coulomb | Sticking::Full => self.reaches(first, &mut room.reach.0[..m]),
        }
    }

    /// [`TractionLaw::follow`] of `W` points, the path's from `from` on and the law's from `first` on.
    fn follow_some<const W: usize>(
        &self,
        [first, from, n]: [usize; 3],
        path: &[f64],
        state: &mut [f64],
        traction: &mut [f64],
    ) {
        let mut reach = [0.0; W];
        self.reaches(first, &mut reach);
        let law = self;
        run(FollowedSprings {
            law,
            first,
            from,
            n,
            reach,
            path,
            state,
            traction,
        });
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
        let mut room = Room::<B>::new();
        let mut counts = RegimeCounts::default();
        let mut block = 0..0;
        while block.end < n {
            block = block.end..n.min(block.end + B);
            let m = block.len();
            let unlimited = sticking == Sticking::Full;
            let u = part(&jump, &block);
            let mut states = Rows::of(begin, &mut end, n, &block);
            let first = points.start + block.start;
            self.begin_block(first, sticking, m, &mut room);
            // Of the stretches, the springs look.
            let n_looked_at = if along.is_some() { self.info.n_state() } else { N_JUMP };
            room.fill = states.spread_nan(u, n_looked_at);
            room.sums = Sums::filled(room.fill);
            room.spoilt.0.fill(0.0);
            states.end_at(u, &room.fill);
            let mut direction = along.as_mut().map(|along| {
                let d_u = part(&[along.d_jump.x, along.d_jump.y, along.d_jump.n], &block);
                (d_u, Rows::of(along.d_begin, &mut along.d_end, n, &block))
            });
            if let Some((d_u, changes)) = &mut direction {
                room.no_change = changes.spread_nan(*d_u, self.info.n_state());
                for (no_change, fill) in room.no_change.0.iter_mut().zip(&room.fill.0) {
                    *no_change += fill;
                }
                room.changes = [room.no_change; 3];
                changes.end_at(*d_u, &room.no_change);
            }
            room.motion.begin(u, [0, 1, 2].map(|c| states.begin(c)));
            for spring in 0..self.n_springs {
                let at = spring * self.ratios.len() + first;
                let (gap, stiffness) = (&self.gaps[at..][..m], &self.stiffnesses[at..][..m]);
                let c = N_JUMP + 2 * spring;
                let memory = [c, c + 1].map(|c| states.begin(c));
                let mut acts = Acts::default();
                run(Springs {
                    memory,
                    unlimited,
                    with_tangent: tangent.is_some(),
                    gap,
                    stiffness,
                    end: states.end::<2>(c),
                    room: &mut room,
                    acts: &mut acts,
                });
                if let Some((d_u, changes)) = &mut direction {
                    let [d_x, d_y, d_n, d_memory_x, d_memory_y] = [0, 1, 2, c, c + 1].map(|c| changes.begin(c));
                    run(Change {
                        acts,
                        step: room.motion.step(m),
                        memory,
                        d_u: *d_u,
                        d_u_0: [d_x, d_y, d_n],
                        d_memory: [d_memory_x, d_memory_y],
                        unlimited,
                        gap,
                        stiffness,
                        reach: &room.reach,
                        fill: &room.no_change,
                        end: changes.end::<2>(c),
                        traction: &mut room.changes,
                    });
                }
            }
            if room.spoilt.0[..m].iter().any(|spoilt| *spoilt != 0.0) {
                room.spoil();
                for c in 0..self.info.n_state() {
                    let [end] = states.end::<1>(c);
                    end.iter_mut()
                        .zip(&room.spoilt.0)
                        .for_each(|(end, spoilt)| *end += spoilt);
                }
            }
            let Room {
                sums, changes, fill, ..
            } = &room;
            let ratio = &self.ratios[first..][..m];
            let scaled = |sum: &Lanes<f64, B>, ratio: Option<&[f64]>, into: &mut [f64]| {
                for i in 0..m {
                    into[i] = ratio.map_or(1.0, |ratio| ratio[i]) * sum.0[i];
                }
            };
            for (q, traction) in part_mut(&mut traction, &block).into_iter().enumerate() {
                scaled(&sums.traction[q], (q < 2).then_some(ratio), traction);
            }
            if let Some(tangent) = &mut tangent {
                for (entry, tangent) in part_mut(tangent, &block).into_iter().enumerate() {
                    scaled(&sums.tangent[entry], (entry < 6).then_some(ratio), tangent);
                }
            }
            if let Some(along) = &mut along {
                let ComponentsMut { x, y, n } = &mut along.d_traction;
                for (q, into) in [x, y, n].into_iter().enumerate() {
                    scaled(&changes[q], (q < 2).then_some(ratio), &mut into[block.clone()]);
                }
            }
            let regimes = regimes.as_deref_mut().map(|regimes| &mut regimes[block.clone()]);
            counts += of_parts(&sums.regimes(), fill, m, regimes);
        }
        counts
    }
}

impl<C: ContactCurves> TractionLaw for FoundationLaw<C> {
    fn info(&self) -> &LawInfo {
        &self.info
    }

    fn len(&self) -> usize {
        self.springs.len()
    }

    evaluates_by!(evaluate_blocks in blocks);

    /// Spring by spring through many steps at once: one that neither slips nor opens in them adds to the stiffness alone.
    fn follow(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        path: &[f64],
        state: &mut [f64],
        room: &mut [f64],
        traction: &mut [f64],
    ) {
        check_points(&points, self);
        check_path(&points, self, path, state, traction);
        if sticking != Sticking::Coulomb || !are_moderate(path) || !are_moderate(state) {
            return step_by_step(self, points, sticking, path, state, room, traction);
        }
        let n = points.len();
        let whole = n - n % WIDTH;
        for from in (0..whole).step_by(WIDTH) {
            self.follow_some::<WIDTH>([points.start + from, from, n], path, state, traction);
        }
        for from in whole..n {
            self.follow_some::<ONE>([points.start + from, from, n], path, state, traction);
        }
    }

    /// Spring by spring, without a derivative along any direction.
    fn transposed(
        &self,
        points: Range<usize>,
        jump: Components<'_>,
        begin: StateView<'_>,
        way: WayBack,
        adjoints: &mut [Adjoint<'_>],
    ) {
        check_points(&points, self);
        let (n, jump) = (points.len(), [jump.x, jump.y, jump.n]);
        let mut room = Room::<BLOCK>::new();
        let mut block = 0..0;
        while block.end < n {
            block = block.end..n.min(block.end + BLOCK);
            let (m, first) = (block.len(), points.start + block.start);
            self.begin_block(first, Sticking::Coulomb, m, &mut room);
            let u = part(&jump, &block);
            let begin_at = |c: usize| &begin.component(c, n)[block.clone()];
            room.motion.begin(u, [0, 1, 2].map(begin_at));
            let step = room.motion.step(m);
            let of_spring = |spring: usize| {
                let at = spring * self.ratios.len() + first;
                let c = N_JUMP + 2 * spring;
                (&self.gaps[at..][..m], &self.stiffnesses[at..][..m], c)
            };
            for Adjoint {
                history,
                traction,
                jump,
            } in &mut *adjoints
            {
                let StateViewMut {
                    data, stride, offset, ..
                } = history;
                let at = |c: usize| c * *stride + *offset + block.start;
                let mut sums = [Lanes([0.0; BLOCK]); 4];
                for spring in 0..self.n_springs {
                    let (gap, stiffness, c) = of_spring(spring);
                    let (x, y) = data[at(c)..].split_at_mut(*stride);
                    run(Transposed {
                        way,
                        step,
                        memory: [c, c + 1].map(begin_at),
                        gap,
                        stiffness,
                        ratio: &self.ratios[first..][..m],
                        reach: &room.reach,
                        traction: part(&[traction.x, traction.y, traction.n], &block),
                        history: [&mut x[..m], &mut y[..m]],
                        sums: &mut sums,
                    });
                }
                let ComponentsMut { x, y, n } = jump;
                let [along_x, along_y, of_n, of_begin_n] = &sums;
                for (c, (of_jump, into)) in [along_x, along_y, of_n].into_iter().zip([x, y, n]).enumerate() {
                    let history = data[at(c)..][..m].iter_mut();
                    for (i, (history, into)) in history.zip(&mut into[block.clone()]).enumerate() {
                        let of_begin = if c < 2 { -of_jump.0[i] } else { of_begin_n.0[i] };
                        *into = way.of_end(*history) + of_jump.0[i];
                        *history = way.before(*history, of_begin);
                    }
                }
            }
        }
    }

    fn friction_coefficient(&self, point: usize) -> Option<f64> {
        Some(*self.mu.at(point))
    }

    fn dissipates(&self) -> bool {
        has_friction(&self.mu)
    }

    fn slips_in_parts(&self) -> bool {
        true
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        self.curves.at(point).contact_area_ratio(u_n)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        self.curves.at(point).yielded_fraction(u_n, omega_c)
    }
}

/// What one spring does at one point.
#[derive(Clone, Copy)]
struct Answer {
    /// Interference now and before, positive where the spring is closed now.
    w: [f64; 2],
    /// Share of the step that it is closed.
    share: f64,
    /// Stretch.
    stretch: [f64; 2],
    closed: bool,
    sticks: bool,
    /// Of slip, zero without; and what slip leaves of the trial.
    direction: [f64; 2],
    left: f64,
}

impl Answer {
    /// Derivative of the share along changes of both interferences.
    #[inline(always)]
    fn share_change(self, d_w: [f64; 2]) -> f64 {
        let [w, w_0] = self.w;
        let path = w - w_0;
        let reclosed = self.closed & (w_0 < 0.0);
        let change = ((1.0 - self.share) * d_w[0] + self.share * d_w[1]) / path;
        if reclosed { bounded(change) } else { 0.0 }
    }

    /// A change of the trial as one of the stretch, at a constant limit; symmetric.
    #[inline(always)]
    fn across(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let along = self.direction[0] * x + self.direction[1] * y;
        [
            self.left * (x - along * self.direction[0]),
            self.left * (y - along * self.direction[1]),
        ]
    }
}

/// The answer of a spring that neither slips nor closes: as [`answer`], without its divisions and its root.
#[inline(always)]
fn resting(w: [f64; 2], du: [f64; 2], memory: [f64; 2]) -> Answer {
    let closed = w[0] > 0.0;
    let left = if closed { 1.0 } else { 0.0 };
    Answer {
        w,
        share: 1.0,
        stretch: [0, 1].map(|q| left * bounded(memory[q] + du[q])),
        closed,
        sticks: closed,
        direction: [0.0; 2],
        left,
    }
}

/// The answer of a spring to a step.
#[inline(always)]
fn answer([w, w_0]: [f64; 2], du: [f64; 2], memory: [f64; 2], reach: f64, unlimited: bool) -> Answer {
    let closed = w > 0.0;
    let reclosed = closed & (w_0 < 0.0);
    let share = if reclosed { w / (w - w_0) } else { 1.0 };
    let x = bounded(memory[0] + share * du[0]);
    let y = bounded(memory[1] + share * du[1]);
    let limit = bounded(reach * w);
    let sticks = closed & (unlimited | ((x * x + y * y <= limit * limit) & (limit > 0.0)));
    let length = (x * x + y * y).sqrt();
    let slips = closed & !sticks & (limit > 0.0);
    let per_length = if slips { 1.0 / length } else { 0.0 };
    let left = if sticks { 1.0 } else { limit * per_length };
    Answer {
        w: [w, w_0],
        share,
        stretch: [left * x, left * y],
        closed,
        sticks,
        direction: [x * per_length, y * per_length],
        left,
    }
}

/// Numbers of a block.
struct Room<const B: usize> {
    reach: Lanes<f64, B>,
    /// Zero, or NaN where any input is no number; and the same of the direction.
    fill: Lanes<f64, B>,
    no_change: Lanes<f64, B>,
    /// Zero, or NaN where a stretch is no number.
    spoilt: Lanes<f64, B>,
    sums: Sums<B>,
    changes: [Lanes<f64, B>; 3],
    motion: Motion<B>,
}

/// The numbers of a [`Step`].
struct Motion<const B: usize> {
    du: [Lanes<f64, B>; 2],
    u_n: [Lanes<f64, B>; 2],
}

impl<const B: usize> Motion<B> {
    /// That of a block from the jumps now and before.
    fn begin(&mut self, u: [&[f64]; 3], u_0: [&[f64]; 3]) {
        for (q, du) in self.du.iter_mut().enumerate() {
            for ((du, u), u_0) in du.0.iter_mut().zip(u[q]).zip(u_0[q]) {
                *du = bounded(u - u_0);
            }
        }
        for (u_n, values) in self.u_n.iter_mut().zip([u[2], u_0[2]]) {
            for (u_n, value) in u_n.0.iter_mut().zip(values) {
                *u_n = bounded(*value);
            }
        }
    }

    /// That of the first `m` points.
    fn step(&self, m: usize) -> Step<'_> {
        Step {
            du: self.du.each_ref().map(|du| &du.0[..m]),
            u_n: self.u_n.each_ref().map(|u_n| &u_n.0[..m]),
        }
    }
}

impl<const B: usize> Room<B> {
    fn new() -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            reach: zero,
            fill: zero,
            no_change: zero,
            spoilt: zero,
            sums: Sums::filled(zero),
            changes: [zero; 3],
            motion: Motion {
                du: [zero; 2],
                u_n: [zero; 2],
            },
        }
    }

    /// Makes what points answer NaN where a stretch is no number.
    fn spoil(&mut self) {
        let Sums { traction, tangent, .. } = &mut self.sums;
        for sum in traction.iter_mut().chain(tangent).chain([&mut self.fill]) {
            sum.0
                .iter_mut()
                .zip(&self.spoilt.0)
                .for_each(|(sum, spoilt)| *sum += spoilt);
        }
    }
}

/// Sums over the springs, the tangential ones over the ratio.
struct Sums<const B: usize> {
    traction: [Lanes<f64, B>; 3],
    /// Row by row.
    tangent: [Lanes<f64, B>; 9],
    /// Stiffness of the springs that stick, and of those that slip: summed, as the largest would be stored under a mask.
    sticking: Lanes<f64, B>,
    slipping: Lanes<f64, B>,
}

impl<const B: usize> Sums<B> {
    fn filled(fill: Lanes<f64, B>) -> Self {
        Self {
            traction: [fill; 3],
            tangent: [fill; 9],
            sticking: Lanes([0.0; B]),
            slipping: Lanes([0.0; B]),
        }
    }

    /// A point with a spring that sticks does so.
    fn regimes(&self) -> Lanes<u64, B> {
        Lanes(core::array::from_fn(|i| {
            match (self.sticking.0[i] > 0.0, self.slipping.0[i] > 0.0) {
                (true, _) => STICK,
                (false, true) => SLIP,
                (false, false) => OPEN,
            }
        }))
    }
}

/// What a spring is found to do at the points of a block.
#[derive(Clone, Copy, Default)]
struct Acts {
    /// Is closed somewhere.
    closes: bool,
    /// Slips somewhere, or closes on its way.
    moves: bool,
}

/// The step of a block of points, in numbers of which products are finite.
#[derive(Clone, Copy)]
struct Step<'a> {
    /// Motion along x and y.
    du: [&'a [f64]; 2],
    /// Interference now and before.
    u_n: [&'a [f64]; 2],
}

/// One spring at the points of a block.
struct Springs<'a, const B: usize> {
    memory: [&'a [f64]; 2],
    unlimited: bool,
    with_tangent: bool,
    gap: &'a [f64],
    stiffness: &'a [f64],
    end: [&'a mut [f64]; 2],
    room: &'a mut Room<B>,
    acts: &'a mut Acts,
}

impl<const B: usize> Pass for Springs<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            memory: [memory_x, memory_y],
            unlimited,
            gap,
            stiffness,
            end: [end_x, end_y],
            room,
            acts,
            ..
        } = self;
        let Room {
            reach,
            fill,
            spoilt,
            sums,
            motion,
            ..
        } = room;
        let Motion {
            du: [du_x, du_y],
            u_n: [u_n, n_0],
        } = motion;
        let Sums {
            traction: [t_x, t_y, t_n],
            tangent: [xx, xy, xn, yx, yy, yn, _, _, nn],
            sticking,
            slipping,
        } = sums;
        let m = gap.len().min(B);
        macro_rules! springs {
            ($tangent:literal, $width:ident, $range:expr) => {
                springs::<$tangent, $width>(
                    unlimited,
                    of(memory_x, $range),
                    of(memory_y, $range),
                    of(gap, $range),
                    of(stiffness, $range),
                    of_mut(end_x, $range),
                    of_mut(end_y, $range),
                    of(&reach.0, $range),
                    of(&fill.0, $range),
                    of(&du_x.0, $range),
                    of(&du_y.0, $range),
                    of(&u_n.0, $range),
                    of(&n_0.0, $range),
                    of_mut(&mut spoilt.0, $range),
                    of_mut(&mut t_x.0, $range),
                    of_mut(&mut t_y.0, $range),
                    of_mut(&mut t_n.0, $range),
                    of_mut(&mut xx.0, $range),
                    of_mut(&mut xy.0, $range),
                    of_mut(&mut xn.0, $range),
                    of_mut(&mut yx.0, $range),
                    of_mut(&mut yy.0, $range),
                    of_mut(&mut yn.0, $range),
                    of_mut(&mut nn.0, $range),
                    of_mut(&mut sticking.0, $range),
                    of_mut(&mut slipping.0, $range),
                    acts,
                )
            };
        }
        let whole = m - m % WIDTH;
        match self.with_tangent {
            true => {
                springs!(true, WIDTH, 0..whole);
                springs!(true, ONE, whole..m);
            }
            false => {
                springs!(false, WIDTH, 0..whole);
                springs!(false, ONE, whole..m);
            }
        }
    }
}

/// The points that are left.
const ONE: usize = 1;

/// A range of points, `W` by `W`.
#[inline(always)]
fn of<const W: usize>(all: &[f64], range: Range<usize>) -> &[[f64; W]] {
    all[range].as_chunks().0
}

/// [`of`], to be written.
#[inline(always)]
fn of_mut<const W: usize>(all: &mut [f64], range: Range<usize>) -> &mut [[f64; W]] {
    all[range].as_chunks_mut().0
}

/// Whether a closed spring is seen to stick: where squares are too small or too large to tell, it may move.
#[inline(always)]
fn rests(w: f64, [x, y]: [f64; 2], reach: f64) -> bool {
    let limit = reach * w;
    x * x + y * y < min(limit * limit, LARGEST)
}

/// [`Springs`]; every array is an argument of its own, which alone tells the compiler that they do not overlap.
#[inline(always)]
fn springs<const TANGENT: bool, const W: usize>(
    unlimited: bool,
    memory_x: &[[f64; W]],
    memory_y: &[[f64; W]],
    gap: &[[f64; W]],
    stiffness: &[[f64; W]],
    end_x: &mut [[f64; W]],
    end_y: &mut [[f64; W]],
    reach: &[[f64; W]],
    fill: &[[f64; W]],
    du_x: &[[f64; W]],
    du_y: &[[f64; W]],
    u_n: &[[f64; W]],
    n_0: &[[f64; W]],
    spoilt: &mut [[f64; W]],
    t_x: &mut [[f64; W]],
    t_y: &mut [[f64; W]],
    t_n: &mut [[f64; W]],
    xx: &mut [[f64; W]],
    xy: &mut [[f64; W]],
    xn: &mut [[f64; W]],
    yx: &mut [[f64; W]],
    yy: &mut [[f64; W]],
    yn: &mut [[f64; W]],
    nn: &mut [[f64; W]],
    sticking: &mut [[f64; W]],
    slipping: &mut [[f64; W]],
    acts: &mut Acts,
) {
    let n = gap.len();
    let (memory_x, memory_y, stiffness) = (&memory_x[..n], &memory_y[..n], &stiffness[..n]);
    let (end_x, end_y) = (&mut end_x[..n], &mut end_y[..n]);
    let (reach, fill, du_x, du_y) = (&reach[..n], &fill[..n], &du_x[..n], &du_y[..n]);
    let (u_n, n_0, spoilt) = (&u_n[..n], &n_0[..n], &mut spoilt[..n]);
    let (t_x, t_y, t_n) = (&mut t_x[..n], &mut t_y[..n], &mut t_n[..n]);
    let (xx, xy, xn, yx) = (&mut xx[..n], &mut xy[..n], &mut xn[..n], &mut yx[..n]);
    let (yy, yn, nn) = (&mut yy[..n], &mut yn[..n], &mut nn[..n]);
    let (sticking, slipping) = (&mut sticking[..n], &mut slipping[..n]);
    for c in 0..n {
        let zero = [0.0; W];
        let (mut w, mut x, mut y) = (zero, zero, zero);
        let (mut closed, mut moving) = ([false; W], [false; W]);
        for i in 0..W {
            w[i] = u_n[c][i] - gap[c][i];
            x[i] = memory_x[c][i] + du_x[c][i];
            y[i] = memory_y[c][i] + du_y[c][i];
            spoilt[c][i] += 0.0 * x[i] + 0.0 * y[i];
            let rests = unlimited | rests(w[i], [x[i], y[i]], reach[c][i]);
            let moves = (n_0[c][i] < gap[c][i]) | !rests;
            closed[i] = w[i] > 0.0;
            moving[i] = (w[i] > 0.0) & moves;
        }
        if closed == [false; W] {
            (end_x[c], end_y[c]) = (fill[c], fill[c]);
            continue;
        }
        acts.closes = true;
        if moving == [false; W] {
            for i in 0..W {
                let left = if w[i] > 0.0 { 1.0 } else { 0.0 };
                let kappa = stiffness[c][i];
                let (x, y) = (left * bounded(x[i]), left * bounded(y[i]));
                end_x[c][i] = x + fill[c][i];
                end_y[c][i] = y + fill[c][i];
                t_x[c][i] += kappa * x;
                t_y[c][i] += kappa * y;
                t_n[c][i] += kappa * max(w[i], 0.0);
                if TANGENT {
                    xx[c][i] += left * kappa;
                    yy[c][i] += left * kappa;
                    nn[c][i] += left * kappa;
                }
                sticking[c][i] += left * kappa;
            }
            continue;
        }
        acts.moves = true;
        for i in 0..W {
            let du = [du_x[c][i], du_y[c][i]];
            let (w, memory) = ([w[i], n_0[c][i] - gap[c][i]], [memory_x[c][i], memory_y[c][i]]);
            let found = answer(w, du, memory, reach[c][i], unlimited);
            let kappa = stiffness[c][i];
            let [x, y] = found.stretch;
            end_x[c][i] = x + fill[c][i];
            end_y[c][i] = y + fill[c][i];
            t_x[c][i] += kappa * x;
            t_y[c][i] += kappa * y;
            t_n[c][i] += kappa * max(found.w[0], 0.0);
            if TANGENT {
                let [d_x, d_y] = found.direction;
                let left = kappa * found.left;
                let across = left * found.share;
                xx[c][i] += across * (1.0 - d_x * d_x);
                yy[c][i] += across * (1.0 - d_y * d_y);
                let mixed = -across * d_x * d_y;
                xy[c][i] += mixed;
                yx[c][i] += mixed;
                let rate = found.share_change([1.0, 0.0]);
                let [c_x, c_y] = found.across([bounded(rate * du[0]), bounded(rate * du[1])]);
                xn[c][i] += kappa * (c_x + reach[c][i] * d_x);
                yn[c][i] += kappa * (c_y + reach[c][i] * d_y);
                nn[c][i] += if found.closed { kappa } else { 0.0 };
            }
            let sticks = if found.sticks { kappa } else { 0.0 };
            let slips = if found.closed & !found.sticks { kappa } else { 0.0 };
            sticking[c][i] += sticks;
            slipping[c][i] += slips;
        }
    }
}

/// Steps that are followed together.
const TILE: usize = 32;

/// What rounding may leave between a stretch that is bounded and one that is followed (relative).
const BOUND_MARGIN: f64 = 1e-9;

/// The springs of `W` points along a path, some steps at a time.
///
/// A spring is stretched by no more than it was before them, and the farthest motion in them. If its limit at the least interference is larger, it
/// pulls by its stiffness times the motion: such springs are added up before the steps.
struct FollowedSprings<'a, C: ContactCurves, const W: usize> {
    law: &'a FoundationLaw<C>,
    /// The first of the points in the law and in the path, which has `n`.
    first: usize,
    from: usize,
    n: usize,
    reach: [f64; W],
    path: &'a [f64],
    state: &'a mut [f64],
    traction: &'a mut [f64],
}

impl<C: ContactCurves, const W: usize> Pass for FollowedSprings<'_, C, W> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            law,
            first,
            from,
            n,
            reach,
            path,
            state,
            traction,
        } = self;
        let n_points = law.ratios.len();
        let mut at: [[f64; W]; 3] = [0, 1, 2].map(|q| lanes(&state[q * n + from..]));
        for (path, traction) in path.chunks(TILE * 3 * n).zip(traction.chunks_mut(TILE * 3 * n)) {
            let count = path.len() / (3 * n);
            let mut steps = [Stage::<W>::ZERO; TILE];
            let mut sums = [[[0.0; W]; 3]; TILE];
            let (mut along, mut far) = ([[0.0; W]; 2], [0.0; W]);
            let (mut low, mut high) = (at[2], [f64::NEG_INFINITY; W]);
            for (step, jump) in steps.iter_mut().zip(path.chunks_exact(3 * n)) {
                let u: [[f64; W]; 3] = [0, 1, 2].map(|q| lanes(&jump[q * n + from..]));
                for i in 0..W {
                    step.du_x[i] = u[0][i] - at[0][i];
                    step.du_y[i] = u[1][i] - at[1][i];
                    step.u_n[i] = u[2][i];
                    step.n_0[i] = at[2][i];
                    along[0][i] += step.du_x[i];
                    along[1][i] += step.du_y[i];
                    step.x[i] = along[0][i];
                    step.y[i] = along[1][i];
                    far[i] = max(far[i], along[0][i] * along[0][i] + along[1][i] * along[1][i]);
                    low[i] = min(low[i], step.u_n[i]);
                    high[i] = max(high[i], step.u_n[i]);
                }
                at = u;
            }
            for far in &mut far {
                *far = far.sqrt();
            }
            let zero = [0.0; W];
            let (mut stiff, mut pull_x, mut pull_y, mut push) = (zero, zero, zero, zero);
            let mut waiting: Option<Moving<W>> = None;
            for spring in 0..law.n_springs {
                let own = spring * n_points + first;
                let gap: [f64; W] = lanes(&law.gaps[own..]);
                let kappa: [f64; W] = lanes(&law.stiffnesses[own..]);
                let at = [0, 1].map(|q| (N_JUMP + 2 * spring + q) * n + from);
                let [mut m_x, mut m_y]: [[f64; W]; 2] = at.map(|at| lanes(&state[at..]));
                let (mut turns, mut slips, mut closed) = ([false; W], [false; W], [false; W]);
                for i in 0..W {
                    let least = low[i] - gap[i];
                    let most = (1.0 + BOUND_MARGIN) * ((m_x[i] * m_x[i] + m_y[i] * m_y[i]).sqrt() + far[i]);
                    closed[i] = least > 0.0;
                    turns[i] = !closed[i] & (high[i] > gap[i]);
                    slips[i] = closed[i] & (most >= reach[i] * least);
                }
                if turns == [false; W] && slips == [false; W] {
                    for i in 0..W {
                        let left = if closed[i] { 1.0 } else { 0.0 };
                        let own = left * kappa[i];
                        stiff[i] += own;
                        pull_x[i] += own * m_x[i];
                        pull_y[i] += own * m_y[i];
                        push[i] += own * (low[i] - gap[i]);
                        m_x[i] = left * (m_x[i] + along[0][i]);
                        m_y[i] = left * (m_y[i] + along[1][i]);
                    }
                    state[at[0]..][..W].copy_from_slice(&m_x);
                    state[at[1]..][..W].copy_from_slice(&m_y);
                    continue;
                }
                let this = Moving {
                    at,
                    gap,
                    kappa,
                    stretch: [m_x, m_y],
                    turns: turns != [false; W],
                };
                match waiting.take() {
                    None => waiting = Some(this),
                    Some(other) => move_springs([other, this], &reach, &steps[..count], &mut sums, state),
                }
            }
            if let Some(last) = waiting {
                move_springs([last], &reach, &steps[..count], &mut sums, state);
            }
            let ratio: [f64; W] = lanes(&law.ratios[first..]);
            for ((step, sums), traction) in steps.iter().zip(&sums).zip(traction.chunks_exact_mut(3 * n)) {
                let mut t = [[0.0; W]; 3];
                for i in 0..W {
                    t[0][i] = ratio[i] * (sums[0][i] + (stiff[i] * step.x[i] + pull_x[i]));
                    t[1][i] = ratio[i] * (sums[1][i] + (stiff[i] * step.y[i] + pull_y[i]));
                    t[2][i] = sums[2][i] + (stiff[i] * (step.u_n[i] - low[i]) + push[i]);
                }
                for (q, t) in t.iter().enumerate() {
                    traction[q * n + from..][..W].copy_from_slice(t);
                }
            }
        }
        for (q, at) in at.iter().enumerate() {
            state[q * n + from..][..W].copy_from_slice(at);
        }
    }
}

/// A spring that slips, opens or closes in some of the steps of a tile.
struct Moving<const W: usize> {
    /// Where its stretch stands in the state.
    at: [usize; 2],
    gap: [f64; W],
    kappa: [f64; W],
    stretch: [[f64; W]; 2],
    /// Whether it opens or closes.
    turns: bool,
}

/// Follows some springs. One waits for a root and a quotient at each step; two wait for theirs together.
#[inline(always)]
fn move_springs<const S: usize, const W: usize>(
    mut springs: [Moving<W>; S],
    reach: &[f64; W],
    steps: &[Stage<W>],
    sums: &mut [[[f64; W]; 3]],
    state: &mut [f64],
) {
    match springs.iter().any(|spring| spring.turns) {
        true => move_each::<true, S, W>(&mut springs, reach, steps, sums),
        false => move_each::<false, S, W>(&mut springs, reach, steps, sums),
    }
    for spring in springs {
        for (at, stretch) in spring.at.into_iter().zip(&spring.stretch) {
            state[at..][..W].copy_from_slice(stretch);
        }
    }
}

/// As [`answer`], in numbers of which no product overflows.
#[inline(always)]
fn move_each<const TURNS: bool, const S: usize, const W: usize>(
    springs: &mut [Moving<W>; S],
    reach: &[f64; W],
    steps: &[Stage<W>],
    sums: &mut [[[f64; W]; 3]],
) {
    for (step, sums) in steps.iter().zip(sums) {
        for spring in &mut *springs {
            let [m_x, m_y] = &mut spring.stretch;
            for i in 0..W {
                let (gap, kappa) = (spring.gap[i], spring.kappa[i]);
                let (w, w_0) = (step.u_n[i] - gap, step.n_0[i] - gap);
                let share = if TURNS & (w > 0.0) & (w_0 < 0.0) {
                    w / (w - w_0)
                } else {
                    1.0
                };
                let (x, y) = (m_x[i] + share * step.du_x[i], m_y[i] + share * step.du_y[i]);
                let w = max(w, 0.0);
                let limit = reach[i] * w;
                let square = x * x + y * y;
                let left = if square <= limit * limit {
                    1.0
                } else {
                    limit / square.sqrt()
                };
                (m_x[i], m_y[i]) = (left * x, left * y);
                sums[0][i] += kappa * m_x[i];
                sums[1][i] += kappa * m_y[i];
                sums[2][i] += kappa * w;
            }
        }
    }
}

/// A step of `W` points in numbers of which products are finite, and how far they have come since the first of the tile.
#[derive(Clone, Copy)]
struct Stage<const W: usize> {
    du_x: [f64; W],
    du_y: [f64; W],
    u_n: [f64; W],
    n_0: [f64; W],
    x: [f64; W],
    y: [f64; W],
}

impl<const W: usize> Stage<W> {
    const ZERO: Self = Self {
        du_x: [0.0; W],
        du_y: [0.0; W],
        u_n: [0.0; W],
        n_0: [0.0; W],
        x: [0.0; W],
        y: [0.0; W],
    };
}

/// Whether all numbers are far from where their products overflow, by eight sums at once.
fn are_moderate(values: &[f64]) -> bool {
    let mut squares = [0.0; WIDTH];
    for chunk in values.chunks(WIDTH) {
        for (square, value) in squares.iter_mut().zip(chunk) {
            *square += value * value;
        }
    }
    // Also false for NaN.
    squares.iter().all(|square| *square < MODERATE * MODERATE)
}

/// Numbers that are smaller have products that do not overflow.
const MODERATE: f64 = 1e140;

/// What one spring changes along a direction.
struct Change<'a, const B: usize> {
    acts: Acts,
    step: Step<'a>,
    memory: [&'a [f64]; 2],
    d_u: [&'a [f64]; 3],
    d_u_0: [&'a [f64]; 3],
    d_memory: [&'a [f64]; 2],
    unlimited: bool,
    gap: &'a [f64],
    stiffness: &'a [f64],
    reach: &'a Lanes<f64, B>,
    fill: &'a Lanes<f64, B>,
    end: [&'a mut [f64]; 2],
    traction: &'a mut [Lanes<f64, B>; 3],
}

impl<const B: usize> Pass for Change<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        match (self.acts.closes, self.acts.moves) {
            (true, true) => self.of::<true>(),
            (true, false) => self.of::<false>(),
            (false, _) => {
                for (end, fill) in self.end.into_iter().flat_map(|end| end.iter_mut().zip(&self.fill.0)) {
                    *end = *fill;
                }
            }
        }
    }
}

impl<const B: usize> Change<'_, B> {
    #[inline(always)]
    fn of<const MOVES: bool>(self) {
        let Self {
            step,
            memory,
            d_u,
            d_u_0,
            d_memory,
            ..
        } = self;
        let [end_x, end_y] = self.end;
        let [t_x, t_y, t_n] = self.traction;
        for i in 0..self.gap.len().min(B) {
            let gap = self.gap[i];
            let (du, w) = (step.du.map(|du| du[i]), step.u_n.map(|u_n| u_n[i] - gap));
            let memory = [memory[0][i], memory[1][i]];
            let found = match MOVES {
                true => answer(w, du, memory, self.reach.0[i], self.unlimited),
                false => resting(w, du, memory),
            };
            let share_change = match MOVES {
                true => found.share_change([d_u[2][i], d_u_0[2][i]]),
                false => 0.0,
            };
            let trial = [0, 1].map(|q| d_memory[q][i] + share_change * du[q] + found.share * (d_u[q][i] - d_u_0[q][i]));
            let [x, y] = found.across(trial);
            let limit = self.reach.0[i] * d_u[2][i];
            let x = bounded(x + limit * found.direction[0]);
            let y = bounded(y + limit * found.direction[1]);
            let kappa = self.stiffness[i];
            end_x[i] = x + self.fill.0[i];
            end_y[i] = y + self.fill.0[i];
            t_x.0[i] += kappa * x;
            t_y.0[i] += kappa * y;
            t_n.0[i] += if found.closed { kappa * bounded(d_u[2][i]) } else { 0.0 };
        }
    }
}

/// One spring on the way back through a step: the transpose of [`Change`].
struct Transposed<'a, const B: usize> {
    way: WayBack,
    step: Step<'a>,
    memory: [&'a [f64]; 2],
    gap: &'a [f64],
    stiffness: &'a [f64],
    ratio: &'a [f64],
    reach: &'a Lanes<f64, B>,
    /// Adjoints of the tractions and of the stretch.
    traction: [&'a [f64]; 3],
    history: [&'a mut [f64]; 2],
    /// What springs add to those of the jump, which is what they take along the surface from that of the jump of the begin state; and what they add
    /// to that of its interference.
    sums: &'a mut [Lanes<f64, B>; 4],
}

impl<const B: usize> Pass for Transposed<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            way,
            step: Step {
                du: [du_x, du_y],
                u_n: [u_n, n_0],
            },
            memory: [memory_x, memory_y],
            gap,
            stiffness,
            ratio,
            reach,
            traction: [t_x, t_y, t_n],
            history: [history_x, history_y],
            sums: [along_x, along_y, of_n, of_begin_n],
        } = self;
        macro_rules! back {
            ($way:ident, $width:ident, $range:expr) => {
                back::<$width>(
                    // Known where the loop is compiled.
                    WayBack::$way,
                    of(du_x, $range),
                    of(du_y, $range),
                    of(u_n, $range),
                    of(n_0, $range),
                    of(memory_x, $range),
                    of(memory_y, $range),
                    of(gap, $range),
                    of(stiffness, $range),
                    of(ratio, $range),
                    of(&reach.0, $range),
                    of(t_x, $range),
                    of(t_y, $range),
                    of(t_n, $range),
                    of_mut(history_x, $range),
                    of_mut(history_y, $range),
                    of_mut(&mut along_x.0, $range),
                    of_mut(&mut along_y.0, $range),
                    of_mut(&mut of_n.0, $range),
                    of_mut(&mut of_begin_n.0, $range),
                )
            };
        }
        let m = gap.len().min(B);
        let whole = m - m % WIDTH;
        match way {
            WayBack::Committed => {
                back!(Committed, WIDTH, 0..whole);
                back!(Committed, ONE, whole..m);
            }
            WayBack::Passed => {
                back!(Passed, WIDTH, 0..whole);
                back!(Passed, ONE, whole..m);
            }
            WayBack::JumpAlone => {
                back!(JumpAlone, WIDTH, 0..whole);
                back!(JumpAlone, ONE, whole..m);
            }
        }
    }
}

/// [`Transposed`]; every array is an argument of its own, as in [`springs`].
#[inline(always)]
fn back<const W: usize>(
    way: WayBack,
    du_x: &[[f64; W]],
    du_y: &[[f64; W]],
    u_n: &[[f64; W]],
    n_0: &[[f64; W]],
    memory_x: &[[f64; W]],
    memory_y: &[[f64; W]],
    gap: &[[f64; W]],
    stiffness: &[[f64; W]],
    ratio: &[[f64; W]],
    reach: &[[f64; W]],
    t_x: &[[f64; W]],
    t_y: &[[f64; W]],
    t_n: &[[f64; W]],
    history_x: &mut [[f64; W]],
    history_y: &mut [[f64; W]],
    along_x: &mut [[f64; W]],
    along_y: &mut [[f64; W]],
    of_n: &mut [[f64; W]],
    of_begin_n: &mut [[f64; W]],
) {
    let n = gap.len();
    let (du_x, du_y, u_n, n_0) = (&du_x[..n], &du_y[..n], &u_n[..n], &n_0[..n]);
    let (memory_x, memory_y, stiffness) = (&memory_x[..n], &memory_y[..n], &stiffness[..n]);
    let (ratio, reach, t_x, t_y, t_n) = (&ratio[..n], &reach[..n], &t_x[..n], &t_y[..n], &t_n[..n]);
    let (history_x, history_y) = (&mut history_x[..n], &mut history_y[..n]);
    let (along_x, along_y) = (&mut along_x[..n], &mut along_y[..n]);
    let (of_n, of_begin_n) = (&mut of_n[..n], &mut of_begin_n[..n]);
    for c in 0..n {
        let mut w = [0.0; W];
        // Compared as a whole: a sum of them would be taken number by number here.
        let (mut closed, mut moving) = ([0_u64; W], [0_u64; W]);
        for i in 0..W {
            w[i] = u_n[c][i] - gap[c][i];
            let x = [memory_x[c][i] + du_x[c][i], memory_y[c][i] + du_y[c][i]];
            let moves = (n_0[c][i] < gap[c][i]) | !rests(w[i], x, reach[c][i]);
            closed[i] = u64::from(w[i] > 0.0);
            moving[i] = u64::from((w[i] > 0.0) & moves);
        }
        if closed == [0; W] {
            for i in 0..W {
                history_x[c][i] = way.before(history_x[c][i], 0.0);
                history_y[c][i] = way.before(history_y[c][i], 0.0);
            }
            continue;
        }
        if moving == [0; W] {
            for i in 0..W {
                let kappa = stiffness[c][i];
                let pull = ratio[c][i] * kappa;
                let after = [history_x[c][i], history_y[c][i]];
                let left = if w[i] > 0.0 { 1.0 } else { 0.0 };
                let x = left * (way.of_end(after[0]) + pull * t_x[c][i]);
                let y = left * (way.of_end(after[1]) + pull * t_y[c][i]);
                history_x[c][i] = way.before(after[0], x);
                history_y[c][i] = way.before(after[1], y);
                along_x[c][i] += x;
                along_y[c][i] += y;
                of_n[c][i] += left * (kappa * t_n[c][i]);
            }
            continue;
        }
        for i in 0..W {
            let du = [du_x[c][i], du_y[c][i]];
            let w = [w[i], n_0[c][i] - gap[c][i]];
            let found = answer(w, du, [memory_x[c][i], memory_y[c][i]], reach[c][i], false);
            let kappa = stiffness[c][i];
            let pull = ratio[c][i] * kappa;
            let after = [history_x[c][i], history_y[c][i]];
            let stretch = [
                way.of_end(after[0]) + pull * t_x[c][i],
                way.of_end(after[1]) + pull * t_y[c][i],
            ];
            let [x, y] = found.across(stretch);
            history_x[c][i] = way.before(after[0], x);
            history_y[c][i] = way.before(after[1], y);
            along_x[c][i] += found.share * x;
            along_y[c][i] += found.share * y;
            let along = x * du[0] + y * du[1];
            let slip = stretch[0] * found.direction[0] + stretch[1] * found.direction[1];
            of_n[c][i] += if found.closed { kappa * t_n[c][i] } else { 0.0 };
            of_n[c][i] += along * found.share_change([1.0, 0.0]) + reach[c][i] * slip;
            of_begin_n[c][i] += along * found.share_change([0.0, 1.0]);
        }
    }
}
