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
    /// All that change.
    const SCALED: [Self; 6] = [
        Self::Interference,
        Self::Sliding(0),
        Self::Sliding(1),
        Self::Traction,
        Self::Force,
        Self::Normal,
    ];

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

    /// How much what a path was gone back along for grows per unit of the parameter by points of the law, from the sums of all its steps; those of the
    /// law's points begin at `first`. Changes of the path's first history come beside it.
    ///
    /// # Panics
    /// When there are fewer sums than points.
    pub fn of_path(&self, sums: &PointSums, first: usize) -> f64 {
        let of = sums
            .of
            .each_ref()
            .map(|values| &values[first..first + self.points.len()]);
        let of_point = |(i, point): (usize, &Similarity)| {
            let kinds = Kind::SCALED.into_iter().zip(of);
            kinds.map(|(kind, values)| point.of(kind) * values[i]).sum::<f64>()
        };
        self.points.iter().enumerate().map(of_point).sum()
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

/// What is found on the way back along a path of all that scales, point by point: adjoints times tractions, less those times jumps. Whatever the number
/// of parameters, the path is gone back once ([`Scaling::of_path`]).
///
/// Histories take part as well, but each as the end of one step and as the begin of the next, with opposite signs. Of a whole path that of its begin
/// is left.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSums {
    /// In the order of [`Kind::SCALED`].
    of: [Vec<f64>; Kind::SCALED.len()],
}

impl PointSums {
    /// Before the first step.
    pub fn new(n_points: usize) -> Self {
        Self {
            of: core::array::from_fn(|_| vec![0.0; n_points]),
        }
    }

    /// Adds what a step finds at `points`, which `adjoint` has come back through.
    ///
    /// # Panics
    /// When a list is shorter than the points, or the sums are.
    pub fn add_step(
        &mut self,
        points: Range<usize>,
        jump: Components<'_>,
        traction: Components<'_>,
        adjoint: &Adjoint<'_>,
    ) {
        let (to_jump, of_traction) = (&adjoint.jump, adjoint.traction);
        let jumps = [(&*to_jump.x, jump.x), (&*to_jump.y, jump.y), (&*to_jump.n, jump.n)];
        for (kind, (adjoints, values)) in Kind::JUMP.into_iter().zip(jumps) {
            self.add(kind, &points, -1.0, adjoints, values);
        }
        let tractions = [
            (of_traction.x, traction.x),
            (of_traction.y, traction.y),
            (of_traction.n, traction.n),
        ];
        for (kind, (adjoints, values)) in Kind::TRACTIONS.into_iter().zip(tractions) {
            self.add(kind, &points, 1.0, adjoints, values);
        }
    }

    /// Adds what is left of the histories of `points` of a law with this `state`, by those that the path begins with and their adjoints, both
    /// `[component][point]` without holes.
    ///
    /// # Panics
    /// When the sums are shorter than the points.
    pub fn add_begin(&mut self, points: Range<usize>, state: &[Quantity], begin: &[f64], adjoint: &[f64]) {
        let n = points.len().max(1);
        let components = begin.chunks_exact(n).zip(adjoint.chunks_exact(n));
        for (quantity, (values, adjoints)) in state.iter().zip(components) {
            // Laws with another quantity are not scaled.
            if let Some(kind) = Kind::of(quantity) {
                self.add(kind, &points, -1.0, adjoints, values);
            }
        }
    }

    fn add(&mut self, kind: Kind, points: &Range<usize>, sign: f64, adjoints: &[f64], values: &[f64]) {
        let sums = Kind::SCALED
            .into_iter()
            .zip(&mut self.of)
            .find(|(other, _)| *other == kind);
        if let Some((_, sums)) = sums {
            let terms = adjoints[..points.len()].iter().zip(&values[..points.len()]);
            let sums = sums[points.clone()].iter_mut().zip(terms);
            sums.for_each(|(sum, (adjoint, value))| *sum += sign * adjoint * value);
        }
    }
}
