//! Friction resolved over asperities a second time, asperity by asperity from the description alone, and its special
//! cases.

use std::cell::Cell;
use std::f64::consts::PI;

use proptest::prelude::*;

use super::described::{Described, Quantity3};
use super::dual::{Dual, Real, Rounded};
use super::elastic_plastic::{At, Formulas, published};
use super::oracle::{Curves, error, expected};
use super::{config, histories, hold, law, relative};
use crate::friction::rule::Memory;
use crate::testing::{evaluate_point, log_uniform, step};
use crate::*;

/// Asperities with friction at one point.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub(super) formulas: Formulas,
    pub(super) gaps: Vec<f64>,
    pub(super) densities: Vec<f64>,
    pub(super) mu: f64,
    pub(super) friction: AsperityFriction,
    pub(super) cone: Cone,
    /// Of asperities that yield.
    pub(super) limit: AsperityLimit,
}

impl Case {
    pub(super) fn bins(&self) -> AsperityBins {
        AsperityBins::try_new(self.formulas.asperity(), self.gaps.clone(), self.densities.clone()).unwrap()
    }

    pub(super) fn law(&self) -> ResolvedLaw {
        let (bins, mu) = (self.bins(), self.mu);
        let (bins, mu) = (PointParameters::uniform(bins, 1), PointParameters::uniform(mu, 1));
        let law = ResolvedLaw::try_new(bins, mu, self.friction.clone(), self.cone).unwrap();
        law.with_limit(self.limit()).unwrap()
    }

    fn single(formulas: Formulas, mu: f64, friction: AsperityFriction, cone: Cone) -> Self {
        Self {
            formulas,
            gaps: vec![0.0],
            densities: vec![1.0],
            mu,
            friction,
            cone,
            limit: AsperityLimit::Coulomb,
        }
    }

    pub(super) fn yields(&self) -> bool {
        self.formulas.yielding.is_some()
    }

    pub(super) fn limit(&self) -> AsperityLimit {
        if self.yields() {
            self.limit
        } else {
            AsperityLimit::Coulomb
        }
    }

    /// State components of one bin.
    pub(super) fn n_memory(&self) -> usize {
        let friction = match &self.friction {
            AsperityFriction::StickSlip(_) => 2,
            AsperityFriction::Annuli(_, n) => 2 * n,
            AsperityFriction::MindlinIwan(radii) => 1 + 2 * radii.len(),
        };
        friction + if self.yields() { 2 } else { 0 }
    }
}

/// Curves of the asperities of a bin over the interference beyond their residual depth.
struct Bin {
    formulas: Formulas,
    dent: Dent,
    depth: f64,
    limit: AsperityLimit,
    /// Of the slip limit, and of the stiffness: 1 unless it is one of several annuli.
    shares: [f64; 2],
}

impl Bin {
    fn at<T: Real>(&self, u: T) -> At<T> {
        let none = At {
            force: T::from(0.0),
            radius: T::from(0.0),
        };
        let w = if self.depth == 0.0 { u } else { u + T::from(self.depth) };
        self.formulas.contact(w, self.dent).unwrap_or(none)
    }
}

impl Curves for Bin {
    fn normal<T: Real>(&self, u: T) -> T {
        T::from(self.shares[0]) * self.at(u).force
    }

    fn tangential<T: Real>(&self, _q: usize, u: T) -> T {
        T::from(self.shares[1] * self.formulas.tangential_modulus()) * self.at(u).radius
    }

    fn limit<T: Real>(&self, mu: f64, u: T) -> T {
        match self.limit {
            AsperityLimit::Coulomb => T::from(mu) * self.normal(u),
            limit => T::from(self.shares[0]) * self.formulas.slip_limit(limit, self.at(u), u, self.dent),
        }
    }
}

/// What the description says about a point.
pub(super) struct Sum {
    pub(super) traction: [Quantity3; 3],
    pub(super) regime: Regime,
    /// Least distance of a trial from its limit, and of a bin from where it opens or yields, relative.
    pub(super) distance: f64,
    /// How many bins load first beyond the onset, unload or reload, close again, stay open in their dent.
    pub(super) kinds: [u32; 4],
}

/// One asperity's forces with the regime and the distance of the trials from the cone.
type Response = ([Quantity3; 3], Regime, f64);

/// Each direction by itself, cut at its own limit.
fn response_in_box(
    bin: &Bin,
    mu: f64,
    rule: HistoryRule,
    sticking: Sticking,
    jump: [f64; 3],
    begin: [f64; 5],
) -> Response {
    let number = Quantity3::from;
    let u: [Quantity3; 3] = std::array::from_fn(|q| Dual::variable(Rounded::from(jump[q]), q));
    let closed_from = number(begin[2].max(0.0));
    let share = match begin[2] < 0.0 {
        true => u[2] / (u[2] - number(begin[2])),
        false => number(1.0),
    };
    let with_slope = |u: Quantity3| {
        let of = bin.tangential(0, Dual::<Quantity3, 1>::variable(u, 0));
        (of.value, of.derivatives[0])
    };
    let normal = bin.normal(u[2]);
    let limit = bin.limit(mu, u[2]);
    let mut sum = [number(0.0), number(0.0), normal];
    let (mut regime, mut distance) = (Regime::Stick, f64::INFINITY);
    for q in 0..2 {
        let moved = u[q] - number(begin[q]);
        let memory = number(begin[3 + q]);
        let trial = rule.described(&Described {
            memory,
            u: u[q],
            moved,
            u_n: u[2],
            moved_n: u[2] - number(begin[2]),
            closed_from,
            share,
            k: &with_slope,
        });
        let stretch = (super::memory(rule) == Memory::Stretch).then(|| memory + share * moved);
        let slips = sticking == Sticking::Coulomb && !(trial.value().abs() <= limit.value() && limit.value() > 0.0);
        let signed = if trial.value() < 0.0 { -limit } else { limit };
        sum[q] = if slips { signed } else { trial };
        if let Some(stretch) = stretch {
            let (k, slope) = with_slope(u[2]);
            let held = if slips { signed / k } else { stretch };
            sum[2] = sum[2] + slope * held * held / number(2.0);
        }
        if slips {
            regime = Regime::Slip;
        }
        if sticking == Sticking::Coulomb && limit.value() > 0.0 {
            let rounding = trial.value.rounding.max(limit.value());
            distance = distance.min((trial.value().abs() - limit.value()).abs() / rounding);
        }
    }
    (sum, regime, distance)
}

/// Quadrature over the radii: `rho`, weight, `k pi a^2/k_t`.
fn quadrature(radii: &Radii) -> Vec<[f64; 3]> {
    let n = radii.len();
    let stiffness = |rho: f64| {
        let s = (1.0 - rho * rho).sqrt();
        0.8709 + 0.1291 / s + 0.0629 * rho - 0.8915 * rho.powi(2) + 0.6998 * rho.powi(3)
    };
    let h = 1.0 / (n - 1) as f64;
    // The edge carries nothing.
    (0..n - 1)
        .map(|i| {
            let rho = i as f64 * h;
            [rho, if i == 0 { 0.5 * h } else { h }, stiffness(rho)]
        })
        .collect()
}

/// Shares of the slip limit and of the stiffness of annulus `k` of `n`: what slips between two displacements of Mindlin's curve.
fn shares(k: usize, n: usize) -> [f64; 2] {
    let p = |j: usize| ((6.0 * j as f64 / n as f64).exp() - 1.0) / (6.0_f64.exp() - 1.0);
    let limit = |p: f64| 1.5 * p * p - 0.5 * p * p * p;
    [limit(p(k + 1)) - limit(p(k)), p(k + 1) - p(k)]
}

/// Sliders at radii. `begin`: `u_x, u_y`; `memory`: contact radius and tractions.
fn microslip(
    case: &Case,
    radii: &Radii,
    at: At<Quantity3>,
    total: Quantity3,
    sticking: Sticking,
    jump: [f64; 3],
    begin: &[f64],
    memory: &[f64],
) -> Response {
    let number = Quantity3::from;
    let nodes = quadrature(radii);
    let At { force, radius } = at;
    let area = number(PI) * radius * radius;
    let whole = number(case.formulas.tangential_modulus()) * radius;
    let before = memory[0];
    // Traction remembered at a radius: constant inside the first node, linear between, zero from the edge on.
    let remembered = |r: Quantity3, q: usize| {
        let inside = before > 0.0 && r.value() < before;
        if !inside {
            return number(0.0);
        }
        let rho = r / number(before);
        let traction = |i: usize| match i < nodes.len() {
            true => number(memory[1 + 2 * i + q]),
            false => number(0.0),
        };
        let place = |i: usize| nodes.get(i).map_or(1.0, |node| node[0]);
        match nodes
            .iter()
            .position(|node| node[0] >= rho.value())
            .unwrap_or(nodes.len())
        {
            0 => traction(0),
            i => {
                let part = (rho - number(place(i - 1))) / number(place(i) - place(i - 1));
                traction(i - 1) + part * (traction(i) - traction(i - 1))
            }
        }
    };
    let mut sum = [number(0.0), number(0.0), force];
    let (mut sticks, mut distance) = (false, f64::INFINITY);
    for &[rho, weight, stiffness] in &nodes {
        let k = whole / area * number(stiffness);
        let limit = number(1.5 * (1.0 - rho * rho).sqrt()) * total / area;
        let r = radius * number(rho);
        let trial: [Quantity3; 2] = std::array::from_fn(|q| {
            let u = Quantity3::variable(Rounded::from(jump[q]), q);
            remembered(r, q) + k * (u - number(begin[q]))
        });
        let all = number(2.0 * weight * rho) * area;
        let cut = |length: Quantity3| {
            let stuck = sticking == Sticking::Full || (length.value() <= limit.value() && limit.value() > 0.0);
            (stuck, if stuck { number(1.0) } else { limit / length })
        };
        let length = |parts: [Quantity3; 2]| {
            let largest = parts[0].value().abs().max(parts[1].value().abs());
            match largest > 0.0 {
                true => {
                    let [x, y] = parts.map(|t| t / number(largest));
                    (x * x + y * y).pow(0.5) * number(largest)
                }
                false => number(0.0),
            }
        };
        let zero = number(0.0);
        let lengths = match case.cone {
            Cone::Circle => [length(trial); 2],
            Cone::Box => [length([trial[0], zero]), length([zero, trial[1]])],
        };
        for q in 0..2 {
            let (_, factor) = cut(lengths[q]);
            if limit.value() > 0.0 || sticking == Sticking::Full {
                sum[q] = sum[q] + all * factor * trial[q];
            }
            if sticking == Sticking::Coulomb && limit.value() > 0.0 && weight * rho > 0.0 {
                let rounding = lengths[q].value.rounding.max(limit.value());
                distance = distance.min((lengths[q].value() - limit.value()).abs() / rounding);
            }
        }
        sticks |= lengths.into_iter().all(|length| cut(length).0);
    }
    (sum, if sticks { Regime::Stick } else { Regime::Slip }, distance)
}

/// Sum over the asperities.
pub(super) fn sum(case: &Case, sticking: Sticking, jump: [f64; 3], begin: &[f64]) -> Sum {
    let number = Quantity3::from;
    let n_memory = case.n_memory();
    let mut total = Sum {
        traction: [number(0.0); 3],
        regime: Regime::Open,
        distance: f64::INFINITY,
        kinds: [0; 4],
    };
    for (j, (gap, density)) in case.gaps.iter().zip(&case.densities).enumerate() {
        let memory = &begin[3 + j * n_memory..][..n_memory];
        let dent = match case.yields() {
            true => Dent {
                interference: memory[n_memory - 2],
                force: memory[n_memory - 1],
            },
            false => Dent::default(),
        };
        let depth = case.formulas.residual_depth(dent);
        let bin = Bin {
            formulas: case.formulas,
            dent,
            depth,
            limit: case.limit(),
            shares: [1.0; 2],
        };
        let (w, w_before) = (jump[2] - gap, begin[2] - gap);
        let (u, u_before) = (w - depth, w_before - depth);
        let onset = case.formulas.asperity().onset_of_yield();
        // Digits that the interference beyond the depth has lost count as a kink.
        let size = jump[2].abs().max(begin[2].abs());
        total.distance = total
            .distance
            .min((u.abs() / size).powi(2))
            .min((w / onset - 1.0).abs());
        if dent.interference > onset {
            total.distance = total.distance.min((w / dent.interference - 1.0).abs());
        }
        if u <= 0.0 {
            total.kinds[3] += u32::from(w > 0.0);
            continue;
        }
        total.kinds[0] += u32::from(w > onset.max(dent.interference));
        total.kinds[1] += u32::from(w < dent.interference && dent.interference > onset);
        total.kinds[2] += u32::from(u_before < 0.0 && dent.interference > 0.0);
        if case.limit() == AsperityLimit::Ceb {
            // The limit ends with an infinite slope.
            let left = (case.formulas.elastic_range(dent) / u - 1.0).abs();
            total.distance = total.distance.min(left * left);
        }
        let jump = [jump[0], jump[1], u];
        let before = [begin[0], begin[1], u_before, memory[0], memory[1]];
        let middle = 0.5 * (u + u_before.max(0.0)) + depth;
        if !matches!(case.friction, AsperityFriction::MindlinIwan(_)) {
            for kink in [onset, dent.interference] {
                total.distance = total.distance.min((middle / kink - 1.0).abs());
            }
        }
        let stick_or_slip = |bin: &Bin, rule: HistoryRule, before: [f64; 5]| match case.cone {
            Cone::Box => response_in_box(bin, case.mu, rule, sticking, jump, before),
            Cone::Circle => {
                let found = expected(bin, case.mu, rule, sticking, jump, &before);
                (found.traction, found.regime, found.cone_distance)
            }
        };
        let (force, regime, distance) = match &case.friction {
            AsperityFriction::StickSlip(rule) => stick_or_slip(&bin, *rule, before),
            AsperityFriction::Annuli(rule, n) => {
                let mut all = ([number(0.0); 3], Regime::Slip, f64::INFINITY);
                for k in 0..*n {
                    let annulus = Bin {
                        shares: shares(k, *n),
                        ..bin
                    };
                    let before = [begin[0], begin[1], u_before, memory[2 * k], memory[2 * k + 1]];
                    let (force, regime, distance) = stick_or_slip(&annulus, *rule, before);
                    for (sum, force) in all.0.iter_mut().zip(force) {
                        *sum = *sum + force;
                    }
                    if regime == Regime::Stick {
                        all.1 = regime;
                    }
                    all.2 = all.2.min(distance);
                }
                all
            }
            AsperityFriction::MindlinIwan(radii) => {
                let u = Quantity3::variable(Rounded::from(u), 2);
                microslip(
                    case,
                    radii,
                    bin.at(u),
                    bin.limit(case.mu, u),
                    sticking,
                    jump,
                    &before,
                    memory,
                )
            }
        };
        for (sum, force) in total.traction.iter_mut().zip(force) {
            *sum = *sum + number(*density) * force;
        }
        total.distance = total.distance.min(distance);
        if *density > 0.0 && total.regime != Regime::Stick {
            total.regime = regime;
        }
    }
    total
}

/// Bins of a few gaps, one of them maybe without asperities.
fn populations() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    let gap = prop_oneof![1 => Just(0.0), 5 => log_uniform(1e-8, 5e-6)];
    let density = prop_oneof![1 => Just(0.0), 6 => log_uniform(1e4, 1e7)];
    prop::collection::vec((gap, density), 1..5).prop_map(|bins| bins.into_iter().unzip())
}

pub(super) fn frictions(yields: bool) -> impl Strategy<Value = AsperityFriction> {
    let rules = histories();
    let rules = rules.filter(move |rule| !yields || *rule != HistoryRule::Potential);
    let rules: Vec<HistoryRule> = rules.collect();
    let radii = (3..8_usize).prop_map(|n| Radii::equally_spaced(n).unwrap());
    let annuli = (prop::sample::select(rules.clone()), 1..6_usize);
    prop_oneof![
        2 => prop::sample::select(rules).prop_map(AsperityFriction::StickSlip),
        1 => annuli.prop_map(|(rule, n)| AsperityFriction::Annuli(rule, n)),
        1 => radii.prop_map(AsperityFriction::MindlinIwan),
    ]
}

/// Cases of every kind.
pub(super) fn cases() -> impl Strategy<Value = Case> {
    let limits = [AsperityLimit::Coulomb, AsperityLimit::Ceb, AsperityLimit::ShearStrength];
    (coulomb_cases(), prop::sample::select(limits.to_vec())).prop_map(|(case, limit)| Case { limit, ..case })
}

/// Cases of every kind with Coulomb's limit.
pub(super) fn coulomb_cases() -> impl Strategy<Value = Case> {
    let hardening = prop_oneof![1 => Just(0.0), 4 => log_uniform(1e-3, 0.3)];
    let curves = prop::sample::select(vec![YieldCurves::Continuous, YieldCurves::Published]);
    let yielding = (log_uniform(2e-4, 5e-3), hardening);
    let formulas = (
        prop::option::of(yielding),
        0.0..0.5_f64,
        log_uniform(3e-4, 3e-3),
        curves,
    )
        .prop_map(|(yielding, nu, radius, curves)| {
            let yielding = yielding.map(|(s, h)| [192e9 * s, 192e9 * h]);
            Formulas::new(192e9, nu, radius, yielding).with_curves(curves)
        });
    let mu = prop_oneof![1 => Just(0.0), 8 => log_uniform(1e-2, 10.0)];
    let cone = prop::sample::select(vec![Cone::Circle, Cone::Box]);
    (formulas, populations(), mu, cone).prop_flat_map(|(formulas, (gaps, densities), mu, cone)| {
        frictions(formulas.yielding.is_some()).prop_map(move |friction| Case {
            formulas,
            gaps: gaps.clone(),
            densities: densities.clone(),
            mu,
            friction,
            cone,
            limit: AsperityLimit::Coulomb,
        })
    })
}

/// Paths that close, yield, open and close again; tangential steps about the sizes that slip begins at.
pub(super) fn paths(mu: f64) -> impl Strategy<Value = Vec<[f64; 3]>> {
    let along = move || {
        (log_uniform(1e-3, 10.0), any::<bool>()).prop_map(move |(size, minus)| {
            let size = size * mu.max(1e-2) * 1e-6;
            if minus { -size } else { size }
        })
    };
    let normal = prop_oneof![8 => log_uniform(1e-7, 8e-6), 1 => log_uniform(1e-8, 1e-5).prop_map(|u| -u)];
    prop::collection::vec((along(), along(), normal), 2..9).prop_map(|steps| {
        let mut at = [0.0; 2];
        steps
            .into_iter()
            .map(|(x, y, n)| {
                at = [at[0] + x, at[1] + y];
                [at[0], at[1], n]
            })
            .collect()
    })
}

/// Tractions within 1e-11, tangents within 1e-9, of values of the size of their terms.
#[test]
fn tractions_and_tangents_follow_the_description() {
    let config = config(6000, file!(), Some("resolved_oracle"));
    let kinds = Cell::new([0_u32; 4]);
    let regimes = Cell::new([0_u32; 3]);
    let worst = Cell::new([0.0_f64; 2]);
    let strategy = cases().prop_flat_map(|case| {
        let mu = case.mu;
        (Just(case), paths(mu))
    });
    hold(config, &strategy, |(case, path)| {
        let law = case.law();
        let mut state = vec![0.0; law.info().n_state()];
        for u in path {
            for sticking in [Sticking::Full, Sticking::Coulomb] {
                let found = evaluate_point(&law, 0, sticking, u, &state);
                let sum = sum(&case, sticking, u, &state);
                if sum.distance > 1e-8 {
                    prop_assert_eq!(found.regime, sum.regime);
                    for (i, expected) in sum.traction.iter().enumerate() {
                        let mut largest = worst.get();
                        let here = error(found.traction[i], expected.value, 1e-1);
                        prop_assert!(here < 1e-11, "{i} {here:e} {:e} {expected:?}", found.traction[i]);
                        largest[0] = largest[0].max(here);
                        for k in 0..3 {
                            let mut derivative = expected.derivatives[k];
                            derivative.rounding += expected.value.rounding / u[2].abs();
                            let here = error(found.tangent[i][k], derivative, 1e-3);
                            prop_assert!(here < 1e-9, "{i}{k} {here:e} {:e} {derivative:?}", found.tangent[i][k]);
                            largest[1] = largest[1].max(here);
                        }
                        worst.set(largest);
                    }
                    if sticking == Sticking::Coulomb {
                        let mut counts = kinds.get();
                        counts
                            .iter_mut()
                            .zip(sum.kinds)
                            .for_each(|(count, here)| *count += here);
                        kinds.set(counts);
                        let mut counts = regimes.get();
                        counts[found.regime as usize] += 1;
                        regimes.set(counts);
                    }
                }
                if sticking == Sticking::Coulomb {
                    state = found.end;
                }
            }
        }
        Ok(())
    });
    let ([loading, unloading, closing, dented], [stick, slip, open]) = (kinds.get(), regimes.get());
    println!(
        "{stick} stuck, {slip} slipping, {open} open; bins: {loading} load beyond the onset, {unloading} below a dent's \
         depth, {closing} close again, {dented} open in their dents; tractions within {:.1e}, tangents {:.1e}",
        worst.get()[0],
        worst.get()[1]
    );
    assert!(stick > 1000 && slip > 1000 && open > 500);
    assert!(loading > 1000 && unloading > 1000 && closing > 1000 && dented > 300);
}

/// One elastic asperity per area that touches at once is the law of the point, by all rules.
#[test]
fn one_bin_is_friction_on_hertz_and_mindlin() {
    let (radius, steel) = (1.4e-3, super::STEEL);
    let formulas = Formulas::new(steel.youngs_modulus, steel.poisson_ratio, radius, None);
    let gaps = GapDistribution::try_from_samples(vec![0.0]).unwrap();
    let population = AsperityPopulation::try_new(gaps, 1.0, [radius; 2]).unwrap();
    let curves = AsperitySumCurves::try_new(population, steel, TangentialReading::Mindlin).unwrap();
    let config = config(3000, file!(), Some("one_bin"));
    let regimes = Cell::new([0_u32; 4]);
    let strategy = (step(), log_uniform(1e-3, 10.0));
    hold(config, &strategy, |((u, begin), mu)| {
        // Third derivatives of the oracle leave the number range beside zero.
        prop_assume!(u[2] <= 0.0 || u[2] >= 1e-12);
        for history in histories() {
            let mut begin = super::remembered(history, begin);
            // Forces of a single asperity, or the stretch as it is.
            if super::memory(history) == crate::friction::rule::Memory::Traction {
                begin[3..].iter_mut().for_each(|t| *t *= 1e-6);
            }
            let resolved = Case::single(formulas, mu, AsperityFriction::StickSlip(history), Cone::Circle).law();
            let point = law(curves.clone(), mu, history);
            for sticking in [Sticking::Coulomb, Sticking::Full] {
                let [a, b] = [
                    evaluate_point(&resolved, 0, sticking, u, &begin),
                    evaluate_point(&point, 0, sticking, u, &begin),
                ];
                let oracle = expected(&super::oracle::AsGiven(&curves), mu, history, sticking, u, &begin);
                if oracle.cone_distance < 1e-11 {
                    continue;
                }
                prop_assert_eq!(a.regime, b.regime);
                let mut counts = regimes.get();
                counts[a.regime as usize] += 1;
                regimes.set(counts);
                for i in 0..3 {
                    let value = oracle.traction[i].value;
                    let allowed = 1e-12 * value.value.abs() + 1e-14 * value.rounding + super::oracle::SMALLEST;
                    prop_assert!((a.traction[i] - b.traction[i]).abs() <= allowed, "{a:?} {b:?}");
                    for k in 0..3 {
                        let entry = oracle.traction[i].derivatives[k];
                        let over = if k == 2 && u[2] > 0.0 {
                            value.rounding / u[2]
                        } else {
                            0.0
                        };
                        let allowed = 1e-11 * entry.value.abs() + 1e-12 * (entry.rounding + over);
                        prop_assert!(
                            (a.tangent[i][k] - b.tangent[i][k]).abs() <= allowed + super::oracle::SMALLEST,
                            "{a:?} {b:?}"
                        );
                    }
                }
                for (a, b) in a.end[3..].iter().zip(&b.end[3..]) {
                    let size = 1e-12 * a.abs().max(b.abs());
                    let rounding = oracle.memory.iter().fold(0.0_f64, |m, t| m.max(t.value.rounding));
                    prop_assert!((a - b).abs() <= size + 1e-14 * rounding + super::oracle::SMALLEST);
                }
            }
        }
        Ok(())
    });
    let counts = regimes.get();
    assert!(counts[..3].iter().all(|count| *count > 1000), "{counts:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// A sum over bins is the sum of single bins, moved by their gaps: to the last bit, unless annuli are added in another order.
    #[test]
    fn bins_add_up((case, path) in cases().prop_flat_map(|case| {
        let mu = case.mu;
        (Just(case), paths(mu))
    })) {
        let law = case.law();
        let n_memory = case.n_memory();
        let mut state = vec![0.0; law.info().n_state()];
        for u in path {
            let found = evaluate_point(&law, 0, Sticking::Coulomb, u, &state);
            let (mut traction, mut tangent) = ([0.0; 3], [[0.0; 3]; 3]);
            for (j, (&gap, &density)) in case.gaps.iter().zip(&case.densities).enumerate() {
                let of_bin = 3 + j * n_memory..3 + (j + 1) * n_memory;
                let alone = Case { gaps: vec![0.0], densities: vec![density], ..case.clone() };
                let mut begin = state[..3].to_vec();
                begin[2] -= gap;
                begin.extend_from_slice(&state[of_bin.clone()]);
                let part = evaluate_point(&alone.law(), 0, Sticking::Coulomb, [u[0], u[1], u[2] - gap], &begin);
                prop_assert_eq!(&part.end[3..], &found.end[of_bin]);
                for i in 0..3 {
                    traction[i] += part.traction[i];
                    for k in 0..3 {
                        tangent[i][k] += part.tangent[i][k];
                    }
                }
            }
            if matches!(case.friction, AsperityFriction::Annuli(..)) {
                let size = found.tangent.as_flattened().iter().fold(0.0_f64, |m, k| m.max(k.abs()));
                let tangents = tangent.as_flattened().iter().zip(found.tangent.as_flattened());
                prop_assert!(tangents.into_iter().all(|(a, b)| (a - b).abs() <= 1e-13 * size));
                let size = (1.0 + case.mu) * found.traction[2];
                let tractions = traction.iter().zip(&found.traction);
                prop_assert!(tractions.into_iter().all(|(a, b)| (a - b).abs() <= 1e-13 * size));
            } else {
                prop_assert_eq!((traction, tangent), (found.traction, found.tangent));
            }
            state = found.end;
        }
    }
}

/// `2/sqrt(pi) integral of exp(-t^2)` from `x`, by Simpson's rule to 12.
fn erfc(x: f64) -> f64 {
    let n = 4000;
    let h = (12.0 - x) / f64::from(n);
    let sum: f64 = (0..=n)
        .map(|i| {
            let t = x + h * f64::from(i);
            let weight = match i {
                0 => 1.0,
                i if i == n => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * (-t * t).exp()
        })
        .sum();
    sum * h / 3.0 * 2.0 / PI.sqrt()
}

/// The number of asperities that an interference `w` has grows as `exp(-w/s)`: with `F = H w^(3/2)`, `k = K w^(1/2)` and
/// `c = K/(H mu)` those below `c d` slip, so that
/// `t_t = mu H s^(5/2) gamma(5/2, z) + K d s^(3/2) Gamma(3/2, z)` and `t_n = H s^(5/2) Gamma(5/2)`, `z = c d/s`.
#[test]
fn exponential_gaps() {
    let (mu, scale, nu) = (0.3, 1e-7, 0.3);
    let formulas = Formulas::new(192e9, nu, 1.4e-3, None);
    // Equally spaced roots of the interference, in which force and stiffness are smooth.
    let (n, last) = (1024, 6.4);
    let u_n = scale * last * last;
    let h = last / f64::from(n);
    let roots: Vec<f64> = (0..n).map(|i| h * (f64::from(i) + 0.5)).collect();
    let case = Case {
        formulas,
        gaps: roots.iter().map(|x| (u_n - scale * x * x).max(0.0)).collect(),
        densities: roots.iter().map(|x| 1e8 * 2.0 * x * (-x * x).exp() * h).collect(),
        mu,
        friction: AsperityFriction::StickSlip(HistoryRule::EndPoint),
        cone: Cone::Circle,
        limit: AsperityLimit::Coulomb,
    };
    let law = case.law();
    let mut begin = vec![0.0; law.info().n_state()];
    begin[2] = u_n;
    let c = 1.5 * 2.0 * (1.0 - nu) / ((2.0 - nu) * mu);
    let mut worst = 0.0_f64;
    for z in [0.0_f64, 1e-3, 0.01, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 20.0] {
        let q_3 = erfc(z.sqrt()) + 2.0 * (z / PI).sqrt() * (-z).exp();
        let q_5 = q_3 + z.powf(1.5) * (-z).exp() / (0.75 * PI.sqrt());
        let closed_form = 1.0 - q_5 + z * q_3 / 1.5;
        let d = z * scale / c;
        let found = evaluate_point(&law, 0, Sticking::Coulomb, [0.6 * d, -0.8 * d, u_n], &begin);
        let t = found.traction[0].hypot(found.traction[1]) / (mu * found.traction[2]);
        worst = worst.max((t - closed_form).abs());
        assert!((t - closed_form).abs() < 2e-6, "{z}: {t} {closed_form}");
        let expected = 1e8 * formulas.asperity().loading(scale).force.value * 0.75 * PI.sqrt();
        assert!(relative(found.traction[2], expected) < 1e-9);
    }
    println!("exponential gaps: within {worst:.1e} of mu t_n");
}

/// The published asperities with friction: gross slip begins where the last asperity slips.
#[test]
fn gross_slip_begins_with_the_first_asperity_to_touch() {
    let [formulas, _] = published();
    let case = Case {
        formulas: Formulas {
            yielding: None,
            ..formulas
        },
        gaps: vec![0.0, 1e-6, 2e-6],
        densities: vec![1e5; 3],
        mu: 0.2,
        friction: AsperityFriction::StickSlip(HistoryRule::Incremental),
        cone: Cone::Circle,
        limit: AsperityLimit::Coulomb,
    };
    let law = case.law();
    let u_n = 2.5e-6;
    let mut begin = vec![0.0; law.info().n_state()];
    begin[2] = u_n;
    let nu = formulas.material.poisson_ratio;
    // mu F/k = mu w (2 - nu)/(3 (1 - nu)).
    let at = |w: f64| 0.2 * w * (2.0 - nu) / (3.0 * (1.0 - nu));
    let respond = |d: f64| evaluate_point(&law, 0, Sticking::Coulomb, [d, 0.0, u_n], &begin);
    assert_eq!(respond(at(u_n) * (1.0 - 1e-12)).regime, Regime::Stick);
    let slipping = respond(at(u_n) * (1.0 + 1e-12));
    assert_eq!(slipping.regime, Regime::Slip);
    assert!(relative(slipping.traction[0], 0.2 * slipping.traction[2]) < 1e-14);
    // Between, the tangent loses the stiffness of the asperities that slip.
    let tangents = [0.4, 1.0, 2.0].map(|w| respond(at(w * 1e-6)).tangent[0][0]);
    assert!(tangents[0] > tangents[1] && tangents[1] > tangents[2] && tangents[2] > 0.0);
}

/// Traction, tangent and memory of points, number by number.
fn all_of(law: &ResolvedLaw, sticking: Sticking, jump: &[Vec<f64>; 3], begin: &[f64]) -> Vec<Vec<f64>> {
    all_from(law, sticking, jump, StateView::new(begin, jump[0].len(), 0))
}

fn all_from(law: &ResolvedLaw, sticking: Sticking, jump: &[Vec<f64>; 3], begin: StateView<'_>) -> Vec<Vec<f64>> {
    let n = jump[0].len();
    // What stands there before must not matter.
    let mut end = vec![f64::NAN; begin.data.len()];
    let mut found = all_into(law, sticking, jump, begin, StateViewMut::new(&mut end, n, 0));
    found.extend(end.chunks(n).map(<[f64]>::to_vec));
    found
}

/// Traction and tangent of points, whose memory goes to `end`.
fn all_into(
    law: &ResolvedLaw,
    sticking: Sticking,
    jump: &[Vec<f64>; 3],
    begin: StateView<'_>,
    end: StateViewMut<'_>,
) -> Vec<Vec<f64>> {
    let n = jump[0].len();
    let mut found = vec![vec![0.0; n]; 12];
    let mut lists = found.iter_mut();
    let [x, y, z, tangent @ ..]: [&mut [f64]; 12] = core::array::from_fn(|_| lists.next().unwrap().as_mut_slice());
    law.evaluate(
        0..n,
        sticking,
        Components::new(&jump[0], &jump[1], &jump[2]),
        begin,
        end,
        ComponentsMut::new(x, y, z),
        Some(TangentMut::from_entries(tangent)),
        None,
    );
    found
}

/// Annuli of asperities that press without bound are answered a second time, with powers of two taken off. The points beside them keep their bits.
#[test]
fn annuli_have_the_same_bits_beside_a_point_out_of_bounds() {
    let [formulas, _] = published();
    let elastic = Formulas {
        yielding: None,
        ..formulas
    };
    let bins = AsperityBins::try_new(elastic.asperity(), vec![0.0, 1e-6], vec![1e5; 2]).unwrap();
    let friction = AsperityFriction::Annuli(HistoryRule::Incremental, 4);
    let n = 21;
    let (bins, mu) = (PointParameters::uniform(bins, n), PointParameters::uniform(0.2, n));
    let law = ResolvedLaw::try_new(bins, mu, friction, Cone::Circle).unwrap();
    let of = |scale: f64| {
        (0..n)
            .map(move |i| scale * (1.7 * i as f64 + 0.3).sin())
            .collect::<Vec<f64>>()
    };
    let jump = [of(4e-7), of(2e-7), vec![3e-6; n]];
    let start = vec![0.0; n * law.info().n_state()];
    for sticking in [Sticking::Coulomb, Sticking::Full, Sticking::Frictionless] {
        let plain = all_of(&law, sticking, &jump, &start);
        for (direction, value) in [(0, 1e200), (1, -1e200), (0, 1e-200), (2, 1e-160)] {
            let mut beside = jump.clone();
            beside[direction][n - 1] = value;
            let found = all_of(&law, sticking, &beside, &start);
            for (a, b) in plain.iter().zip(&found) {
                assert_eq!(a[..n - 1], b[..n - 1], "{direction} {value} {sticking:?}");
                assert!(b[n - 1].is_finite());
            }
        }
    }
}

/// What is known to be zero is neither read nor written, and nobody can tell: along a path on which asperities close, open, yield and close again.
#[test]
fn zeros_that_are_known_change_no_bit() {
    let [_, yielding] = published();
    let elastic = Formulas {
        yielding: None,
        ..yielding
    };
    for (formulas, friction) in [
        (elastic, AsperityFriction::Annuli(HistoryRule::Incremental, 3)),
        (elastic, AsperityFriction::StickSlip(HistoryRule::Incremental)),
        (yielding, AsperityFriction::Annuli(HistoryRule::Incremental, 2)),
        (yielding, AsperityFriction::StickSlip(HistoryRule::EndPoint)),
    ] {
        let n = 64;
        let gaps = vec![0.0, 1e-6, 2e-6, 4e-6, 8e-6];
        let bins = AsperityBins::try_new(formulas.asperity(), gaps, vec![1e5; 5]).unwrap();
        let (bins, mu) = (PointParameters::uniform(bins, n), PointParameters::uniform(0.2, n));
        let law = ResolvedLaw::try_new(bins, mu, friction, Cone::Circle).unwrap();
        let n_state = law.info().n_state();
        let [mut plain, mut known, mut room] = [(); 3].map(|()| vec![0.0; n * n_state]);
        let (mut zeros, mut room_zeros) = (0, 0);
        let (mut fewest, mut most) = (usize::MAX, 0);
        for (step, u_n) in [1.5e-6, 3e-6, 0.5e-6, -1e-6, 5e-6, 2.5e-6, 9e-6, 1e-6, 1.2e-6]
            .into_iter()
            .enumerate()
        {
            let sine = |i: usize| (1.3 * i as f64 + step as f64).sin();
            let along = |scale: f64| (0..n).map(|i| scale * sine(i)).collect::<Vec<f64>>();
            let jump = [
                along(3e-7),
                along(-1e-7),
                (0..n).map(|i| u_n + 1e-7 * sine(i)).collect(),
            ];
            let found = all_of(&law, Sticking::Coulomb, &jump, &plain);
            plain = found[12..].concat();
            let begin = StateView::new(&known, n, 0).known_finite(true).with_zeros_from(zeros);
            let end = StateViewMut::new(&mut room, n, 0).with_zeros_from(&mut room_zeros);
            let knowing = all_into(&law, Sticking::Coulomb, &jump, begin, end);
            std::mem::swap(&mut known, &mut room);
            std::mem::swap(&mut zeros, &mut room_zeros);
            assert_eq!(known, plain, "step {step}");
            assert_eq!(knowing, found[..12], "step {step}");
            let first = zeros.min(n_state);
            assert!(known[n * first..].iter().all(|value| *value == 0.0));
            (fewest, most) = (fewest.min(first), most.max(first));
        }
        assert!(fewest < n_state && fewest < most, "{fewest} {most}");
    }
}

/// Beside a point that was open, whose path is closed in part, an annulus answers the same at the others.
#[test]
fn annuli_have_the_same_bits_beside_a_point_that_was_open() {
    let [formulas, _] = published();
    for (rule, sticking) in [
        (HistoryRule::Incremental, Sticking::Coulomb),
        (HistoryRule::Incremental, Sticking::Full),
        (HistoryRule::EndPoint, Sticking::Coulomb),
        (HistoryRule::Paper, Sticking::Frictionless),
    ] {
        let case = Case {
            formulas: Formulas {
                yielding: None,
                ..formulas
            },
            gaps: vec![0.0, 1e-6, 2e-6, 4e-6],
            densities: vec![1e5; 4],
            mu: 0.2,
            friction: AsperityFriction::Annuli(rule, 5),
            cone: Cone::Circle,
            limit: AsperityLimit::Coulomb,
        };
        let (n, one) = (21, case.law());
        let mu = PointParameters::uniform(case.mu, n);
        let law = ResolvedLaw::try_new(PointParameters::uniform(case.bins(), n), mu, case.friction, case.cone).unwrap();
        // Points that lie apart, moved from a state with some slip.
        let spread = |i: usize, scale: f64| scale * (1.7 * i as f64 + 0.3).sin();
        let jump = |scale: f64| -> [Vec<f64>; 3] {
            [1.0, 0.6, 0.0].map(|share| {
                let of = |i| match share {
                    0.0 => 3e-6 + spread(i, 2.5e-6),
                    _ => share * spread(i, scale),
                };
                (0..n).map(of).collect()
            })
        };
        let start = vec![0.0; n * one.info().n_state()];
        let before = all_of(&law, Sticking::Coulomb, &jump(2e-7), &start);
        let begin = before[12..].concat();
        let mut beside = begin.clone();
        beside[2 * n + n - 1] = -1e-6;
        let [alone, with_other] = [&begin, &beside].map(|begin| all_of(&law, sticking, &jump(5e-7), begin));
        for (a, b) in alone.iter().zip(&with_other) {
            assert_eq!(a[..n - 1], b[..n - 1], "{rule:?} {sticking:?}");
        }
        let moved = alone.iter().any(|row| row[..n - 1].iter().any(|value| *value != 0.0));
        assert!(moved);
    }
}

/// Bins in any order, of which some stay open, in blocks whose points have other bins than their neighbours: every point as if it were alone, also
/// where its history is known to be finite.
#[test]
fn bins_that_stay_open_matter_to_no_point() {
    let [_, yielding] = published();
    let elastic = Formulas {
        yielding: None,
        ..yielding
    };
    for (formulas, friction) in [
        (elastic, AsperityFriction::Annuli(HistoryRule::Incremental, 3)),
        (elastic, AsperityFriction::StickSlip(HistoryRule::Potential)),
        (yielding, AsperityFriction::Annuli(HistoryRule::EndPoint, 2)),
    ] {
        let bins = |gaps: [f64; 4]| AsperityBins::try_new(formulas.asperity(), gaps.to_vec(), vec![1e5; 4]).unwrap();
        let sets = vec![bins([0.0, 6e-6, 2e-6, 9e-6]), bins([5e-6, 1e-6, 8e-6, 3e-6])];
        for n in [64, 130] {
            // The second block of points has one set alone.
            let of_point = (0..n as u32).map(|i| if i < 64 { i % 2 } else { 1 }).collect();
            let bins = PointParameters::try_indexed(sets.clone(), of_point).unwrap();
            let mu = PointParameters::uniform(0.2, n);
            let law = ResolvedLaw::try_new(bins, mu, friction.clone(), Cone::Circle).unwrap();
            let spread = |i: usize, scale: f64| scale * (1.7 * i as f64 + 0.3).sin();
            let jump = |scale: f64, closure: f64| -> [Vec<f64>; 3] {
                let of = |share: f64, mean: f64| (0..n).map(|i| mean + spread(i, share)).collect();
                [of(scale, 0.0), of(0.6 * scale, 0.0), of(2.5e-6, closure)]
            };
            let mut begin = vec![0.0; n * law.info().n_state()];
            for jump in [jump(2e-7, 5e-6), jump(5e-7, 3e-6), jump(-3e-7, 4e-6)] {
                let batch = all_of(&law, Sticking::Coulomb, &jump, &begin);
                let known = StateView::new(&begin, n, 0).known_finite(true);
                assert_eq!(batch, all_from(&law, Sticking::Coulomb, &jump, known));
                for i in 0..n {
                    let own: Vec<f64> = begin.iter().skip(i).step_by(n).copied().collect();
                    let u = [0, 1, 2].map(|q| jump[q][i]);
                    let alone = evaluate_point(&law, i, Sticking::Coulomb, u, &own);
                    let found = |rows: std::ops::Range<usize>| rows.map(|row| batch[row][i]).collect::<Vec<f64>>();
                    assert_eq!(found(0..3), alone.traction);
                    assert_eq!(found(3..12), alone.tangent.concat());
                    assert_eq!(found(12..batch.len()), alone.end);
                }
                begin = batch[12..].concat();
            }
            assert!(begin.iter().any(|value| *value != 0.0));
        }
    }
}
