//! Derivatives of laws with respect to parameters that scale them.
//!
//! With factors `f_u` of interferences, `f_n` of normal tractions, `f_q` of the tangential stiffnesses along `q` and `f_mu` of the friction
//! coefficient, a law becomes
//!
//! ```text
//! t_n = f_n t_n0(u_n / f_u),    k_q = f_q k_q0(u_n / f_u),    |t| <= f_mu mu t_n .
//! ```
//!
//! That is the law before in other coordinates: tangential tractions in units of `f_t = f_mu f_n`, tangential jumps in units of `f_t / f_q`,
//! interferences in units of `f_u`; histories likewise. So the change with a parameter that the factors depend on is a change along a direction of
//! jump and history, which [`TractionLaw::derivative`] gives on the branch that the law takes, and a change of units. No law is evaluated
//! anywhere else. Of resolved friction `f_N`, the factor of the number of asperities per area, tells forces of asperities from tractions.
//!
//! Radii, density and heights of elastic asperities, their moduli and friction coefficients are such parameters. What has a length or a
//! strength of its own is not: the onset of yield, and radii in absolute terms at which asperities slip. A rule with a potential
//! couples tangential and normal tractions, and is not scaled by such factors either.

use crate::curves::CurveFactors;
use crate::law::{Components, ComponentsMut, Quantity, StateView, StateViewMut, Sticking, TractionLaw};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::transposed::Adjoint;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// Logarithmic derivatives of the factors of a law with respect to a parameter, per unit of the parameter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Similarity {
    /// Of interferences.
    pub interference: f64,
    /// Of normal tractions.
    pub normal: f64,
    /// Of tangential stiffnesses along x and y.
    pub tangential: [f64; 2],
    /// Of the friction coefficient.
    pub friction: f64,
    /// Of the number of asperities per area.
    pub density: f64,
}

impl Similarity {
    /// From the curves at two neighbouring values of a parameter, a distance `apart` from one another: `factors` lead from the curves at the
    /// smaller value to those at the larger one.
    pub fn between(factors: CurveFactors, apart: f64) -> Self {
        let rate = |factor: f64| factor.ln() / apart;
        Self {
            interference: rate(factors.interference),
            normal: rate(factors.normal),
            tangential: factors.tangential.map(rate),
            ..Self::default()
        }
    }

    /// Of tangential tractions.
    fn traction(&self) -> f64 {
        self.normal + self.friction
    }

    /// Of what has the given kind.
    fn of(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Interference => self.interference,
            Kind::Sliding(axis) => self.traction() - self.tangential[axis],
            Kind::Traction => self.traction(),
            Kind::Force => self.traction() - self.density,
            Kind::Normal => self.normal,
            Kind::Fixed => 0.0,
        }
    }

    /// Whether single asperities keep their curves.
    fn keeps_asperities(&self) -> bool {
        self.interference == 0.0 && self.normal == self.density && self.tangential == [self.density; 2]
    }
}

/// How a number of a jump, a traction or a history scales.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Interference,
    /// Along x or y.
    Sliding(usize),
    /// Tangential, on the surface.
    Traction,
    /// Of one asperity.
    Force,
    /// Normal, on the surface.
    Normal,
    /// A measure of one asperity.
    Fixed,
}

impl Kind {
    const JUMP: [Self; 3] = [Self::Sliding(0), Self::Sliding(1), Self::Interference];
    const TRACTIONS: [Self; 3] = [Self::Traction, Self::Traction, Self::Normal];

    fn of(quantity: &Quantity) -> Option<Self> {
        let name = quantity.name.as_ref();
        let mut parts = name.splitn(3, '_');
        let (what, axis, bin) = (parts.next()?, parts.next()?, parts.next());
        match (what, axis, bin) {
            ("u", "n", None) => Some(Self::Interference),
            ("u" | "e" | "stretch", "x", _) => Some(Self::Sliding(0)),
            ("u" | "e" | "stretch", "y", _) => Some(Self::Sliding(1)),
            ("t", "x" | "y", None) => Some(Self::Traction),
            ("f" | "t", "x" | "y", Some(_)) => Some(Self::Force),
            ("a" | "w" | "f", ..) => Some(Self::Fixed),
            _ => None,
        }
    }
}

/// A parameter that scales the points of a law, ready for [`Scaling::derivative`].
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    points: Vec<Similarity>,
    kinds: Vec<Kind>,
}

impl Scaling {
    /// `points` has one entry per point of the law. `None` where the law is not scaled by such factors.
    pub fn try_new(law: &dyn TractionLaw, points: Vec<Similarity>) -> Option<Self> {
        let state = &law.info().state;
        let kinds: Vec<Kind> = state.iter().map(Kind::of).collect::<Option<_>>()?;
        // Stretches are remembered by the rule with a potential alone.
        let has_potential = state.iter().any(|quantity| quantity.name.starts_with("e_"));
        let has_measures = kinds.contains(&Kind::Fixed);
        let suits = |point: &Similarity| {
            let keeps = point.keeps_asperities();
            (keeps || !(has_measures || has_potential)) && (point.friction == 0.0 || !has_potential)
        };
        (points.len() == law.len() && points.iter().all(suits)).then_some(Self { points, kinds })
    }

    /// As [`TractionLaw::derivative`], with the change of the parameter by one beside that of jump and begin state. `d_jump` and
    /// `d_begin`, `[component][point]` without holes, are used up.
    ///
    /// # Panics
    /// As [`TractionLaw::derivative`].
    pub fn derivative(
        &self,
        law: &dyn TractionLaw,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: ComponentsMut<'_>,
        d_begin: &mut [f64],
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    ) {
        let n = points.len();
        let rates = &self.points[points.clone()];
        // In the coordinates of the law as it is.
        let into = |values: &[f64], changes: &mut [f64], kind: Kind| {
            for ((change, value), rate) in changes.iter_mut().zip(values).zip(rates) {
                *change -= rate.of(kind) * value;
            }
        };
        let ComponentsMut { x, y, n: normal } = d_jump;
        for ((values, changes), kind) in [jump.x, jump.y, jump.n]
            .into_iter()
            .zip([&mut *x, &mut *y, &mut *normal])
            .zip(Kind::JUMP)
        {
            into(values, changes, kind);
        }
        for (c, (&kind, changes)) in self.kinds.iter().zip(d_begin.chunks_exact_mut(n.max(1))).enumerate() {
            into(begin.component(c, n), changes, kind);
        }
        law.derivative(
            points,
            sticking,
            jump,
            begin,
            Components::new(x, y, normal),
            StateView::new(d_begin, n, 0),
            StateViewMut::new(end.data, end.stride, end.offset),
            StateViewMut::new(d_end.data, d_end.stride, d_end.offset),
            ComponentsMut::new(traction.x, traction.y, traction.n),
            ComponentsMut::new(d_traction.x, d_traction.y, d_traction.n),
        );
        let out = |values: &[f64], changes: &mut [f64], kind: Kind| {
            for ((change, value), rate) in changes.iter_mut().zip(values).zip(rates) {
                *change += rate.of(kind) * value;
            }
        };
        for (c, &kind) in self.kinds.iter().enumerate() {
            let at = c * end.stride + end.offset;
            let of_change = c * d_end.stride + d_end.offset;
            out(&end.data[at..at + n], &mut d_end.data[of_change..of_change + n], kind);
        }
        let ComponentsMut { x, y, n } = d_traction;
        for ((values, changes), kind) in [traction.x, traction.y, traction.n]
            .into_iter()
            .zip([x, y, n])
            .zip(Kind::TRACTIONS)
        {
            out(values, changes, kind);
        }
    }

    /// What a path on the way back through a step finds of the parameter in jumps and tractions: how much the product of the adjoints with them
    /// grows per unit of the parameter, for points of the law.
    ///
    /// Histories take part as well, but each as the end of one step and as the begin of the next, with opposite signs. Of a whole path nothing is left
    /// but [`Self::at_start`].
    ///
    /// # Panics
    /// When a list is shorter than the points.
    pub fn on_the_way(
        &self,
        points: Range<usize>,
        jump: Components<'_>,
        traction: Components<'_>,
        adjoint: &Adjoint<'_>,
    ) -> f64 {
        let rates = &self.points[points];
        let sum = |kinds: [Kind; 3], adjoints: [&[f64]; 3], values: [&[f64]; 3]| {
            let of_kind = |((kind, adjoints), values): ((Kind, &[f64]), &[f64])| {
                let points = rates.iter().zip(adjoints).zip(values);
                points
                    .map(|((rate, adjoint), value)| rate.of(kind) * adjoint * value)
                    .sum::<f64>()
            };
            kinds.into_iter().zip(adjoints).zip(values).map(of_kind).sum::<f64>()
        };
        let (to_jump, of_traction) = (&adjoint.jump, adjoint.traction);
        let of_tractions = [of_traction.x, of_traction.y, of_traction.n];
        sum(Kind::TRACTIONS, of_tractions, [traction.x, traction.y, traction.n])
            - sum(Kind::JUMP, [to_jump.x, to_jump.y, to_jump.n], [jump.x, jump.y, jump.n])
    }

    /// What is left of the histories of a whole path ([`Self::on_the_way`]), by the history that it begins with and the adjoint of that, both
    /// `[component][point]` without holes.
    pub fn at_start(&self, points: Range<usize>, begin: &[f64], adjoint: &[f64]) -> f64 {
        let rates = &self.points[points];
        let n = rates.len().max(1);
        let components = self
            .kinds
            .iter()
            .zip(begin.chunks_exact(n))
            .zip(adjoint.chunks_exact(n));
        // Histories have many numbers of few kinds.
        let mut products: Vec<(Kind, Vec<f64>)> = Vec::new();
        for ((&kind, values), adjoints) in components {
            let place = products.iter().position(|(known, _)| *known == kind);
            let place = place.unwrap_or_else(|| {
                products.push((kind, vec![0.0; n]));
                products.len() - 1
            });
            let sums = products[place].1.iter_mut();
            let terms = values.iter().zip(adjoints).map(|(value, adjoint)| value * adjoint);
            sums.zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let of_kind = |(kind, products): (Kind, Vec<f64>)| {
            let points = rates.iter().zip(products);
            points.map(|(rate, product)| rate.of(kind) * product).sum::<f64>()
        };
        -products.into_iter().map(of_kind).sum::<f64>()
    }

    /// Brings jump and begin state of points, `[component][point]` without holes, into the coordinates in which the law at the parameter's value plus
    /// `step` is the law as it is.
    pub fn transform(&self, points: Range<usize>, step: f64, [x, y, n]: [&mut [f64]; 3], begin: &mut [f64]) {
        let rates = &self.points[points];
        let by = |values: &mut [f64], kind: Kind| {
            for (value, rate) in values.iter_mut().zip(rates) {
                *value *= (-step * rate.of(kind)).exp();
            }
        };
        for (values, kind) in [x, y, n].into_iter().zip(Kind::JUMP) {
            by(values, kind);
        }
        for (&kind, values) in self.kinds.iter().zip(begin.chunks_exact_mut(rates.len().max(1))) {
            by(values, kind);
        }
    }

    /// Brings a tangent (row by row, Pa/m) found in these coordinates back.
    pub fn transform_tangent(&self, points: Range<usize>, step: f64, tangent: [&mut [f64]; 9]) {
        for (entry, values) in tangent.into_iter().enumerate() {
            let (row, column) = (Kind::TRACTIONS[entry / 3], Kind::JUMP[entry % 3]);
            for (value, rate) in values.iter_mut().zip(&self.points[points.clone()]) {
                *value *= (step * (rate.of(row) - rate.of(column))).exp();
            }
        }
    }
}
