//! Laws, and their evaluation on arrays.

use super::curves::{Curves, Parameter, Sets, per_set};
use super::{chosen, refused};
use crate::arrays::{check_shape, readable, slice, writable};
use crate::error::{Exception, input};
use contact_laws::{
    Asperity, AsperityBins, AsperityFriction, Components, ComponentsMut, Cone, ContactCurves, ElasticPair,
    FittedPoints, FoundationLaw, FrictionalLaw, HistoryRule, LinearisedContact, PointCurves, PointParameters, Quantity,
    Radii, Regime, ResolvedLaw, StateView, StateViewMut, StaticPoint, Sticking, TangentMut, TractionLaw, Yield,
};
use numpy::{PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Names and units.
type Labels = Vec<(String, &'static str)>;

/// Jump, traction and stiffness, component by component, and slip limit; and which points are in contact.
type StaticPoints<'py> = ([Bound<'py, PyArray1<f64>>; 10], Vec<bool>);

/// A traction law over a number of points. It never changes.
#[pyclass(frozen, module = "microslip._native")]
pub struct Law {
    pub(crate) law: Arc<dyn TractionLaw>,
}

impl Law {
    fn new(law: impl TractionLaw + 'static) -> Self {
        Self { law: Arc::new(law) }
    }
}

/// Which parameter set belongs to each point.
struct Points {
    count: usize,
    index: Option<Vec<u32>>,
}

impl Points {
    /// From what is given for some points or all: lists with their lengths, the number of points and an index.
    fn new(
        lists: &[(&'static str, usize)],
        per_point: &[(&'static str, usize)],
        n_points: Option<usize>,
        index: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self, Exception> {
        let index = match index {
            None => None,
            Some(index) => {
                let array = readable::<i64, numpy::Ix1>("index", index)?;
                let number = |&i: &i64| {
                    u32::try_from(i).map_err(|_| input(format!("index holds {i}; it must count parameter sets from 0")))
                };
                Some(
                    slice("index", &array)?
                        .iter()
                        .map(number)
                        .collect::<Result<Vec<u32>, Exception>>()?,
                )
            }
        };
        let mut known: Option<(&'static str, usize)> = None;
        let sizes = index.iter().map(|index| ("index", index.len()));
        let sizes = sizes.chain(n_points.map(|n| ("n_points", n)));
        // An index tells sets from points.
        let of_sets = lists.iter().filter(|_| index.is_none()).chain(per_point);
        for (name, size) in sizes.chain(of_sets.copied().filter(|(_, size)| *size != 1)) {
            match known {
                Some((first, count)) if count != size => {
                    return Err(input(format!(
                        "{name} is for {size} points, but {first} is for {count}; give one value, or one for each point"
                    )));
                }
                _ => known = known.or(Some((name, size))),
            }
        }
        let count = known.map_or(1, |(_, count)| count);
        if count == 0 || u32::try_from(count).is_err() {
            return Err(input(format!(
                "the law is for {count} points; it must have at least one, and less than 2^32"
            )));
        }
        Ok(Self { count, index })
    }

    fn spread<T: Clone>(&self, sets: &[T]) -> Result<PointParameters<T>, Exception> {
        match &self.index {
            Some(index) => PointParameters::try_indexed(sets.to_vec(), index.clone()).map_err(refused),
            None => Ok(PointParameters::one_or_each(sets.to_vec(), self.count)),
        }
    }

    fn friction(&self, mu: Parameter) -> PointParameters<f64> {
        PointParameters::one_or_each(mu.into_values(), self.count)
    }
}

#[pymethods]
impl Law {
    /// Contact curves with a history rule of friction.
    #[staticmethod]
    #[pyo3(signature = (curves, mu, history, cone, n_points, index))]
    fn frictional(
        curves: &Curves,
        mu: &Bound<'_, PyAny>,
        history: &str,
        cone: &str,
        n_points: Option<usize>,
        index: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self, Exception> {
        let (history, cone) = (chosen("history", history)?, chosen("cone", cone)?);
        let mu = Parameter::new("mu", mu)?;
        let points = Points::new(&[("curves", curves.0.len())], &[("mu", mu.len())], n_points, index)?;
        let mu = points.friction(mu);
        fn law<C: PointCurves + 'static>(
            curves: C,
            mu: PointParameters<f64>,
            history: HistoryRule,
            cone: Cone,
        ) -> Result<Law, Exception> {
            let law = FrictionalLaw::try_new(curves, mu, history).map_err(refused)?;
            Ok(Law::new(law.with_cone(cone)))
        }
        match &curves.0 {
            Sets::Elastic(list) => law(points.spread(list)?, mu, history, cone),
            Sets::Fitted(list) => law(FittedPoints::<f64>::new(&points.spread(list)?), mu, history, cone),
            Sets::AsperitySum(list) => law(points.spread(list)?, mu, history, cone),
            Sets::GreenwoodWilliamson(list) => law(points.spread(list)?, mu, history, cone),
            Sets::Sampled(list) => law(points.spread(list)?, mu, history, cone),
            Sets::Table(list) => law(points.spread(list)?, mu, history, cone),
        }
    }

    /// Springs of contact curves.
    #[staticmethod]
    #[pyo3(signature = (curves, mu, ratio, n_springs, reach, n_points, index))]
    fn foundation(
        curves: &Curves,
        mu: &Bound<'_, PyAny>,
        ratio: f64,
        n_springs: usize,
        reach: f64,
        n_points: Option<usize>,
        index: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self, Exception> {
        let mu = Parameter::new("mu", mu)?;
        let points = Points::new(&[("curves", curves.0.len())], &[("mu", mu.len())], n_points, index)?;
        let mu = points.friction(mu);
        fn law<C: ContactCurves + 'static>(
            curves: PointParameters<C>,
            mu: PointParameters<f64>,
            (ratio, n_springs, reach): (f64, usize, f64),
        ) -> Result<Law, Exception> {
            let law = FoundationLaw::of_curves(curves, mu, ratio, n_springs, reach).map_err(refused)?;
            Ok(Law::new(law))
        }
        super::curves::with_sets!(&curves.0, list => law(points.spread(list)?, mu, (ratio, n_springs, reach)))
    }

    /// Asperities bin by bin; `gaps` and `densities` are bins x sets.
    #[staticmethod]
    #[pyo3(signature = (gaps, densities, radius, youngs_modulus, poisson_ratio, yielding, mu, history, annuli, radii, cone, slip_limit, n_points, index))]
    fn resolved(
        gaps: &Bound<'_, PyAny>,
        densities: &Bound<'_, PyAny>,
        radius: f64,
        youngs_modulus: f64,
        poisson_ratio: f64,
        yielding: Option<(f64, f64, String)>,
        mu: &Bound<'_, PyAny>,
        history: &str,
        annuli: Option<usize>,
        radii: Option<usize>,
        cone: &str,
        slip_limit: &str,
        n_points: Option<usize>,
        index: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self, Exception> {
        let limit = chosen("slip_limit", slip_limit)?;
        let (history, cone) = (chosen("history", history)?, chosen("cone", cone)?);
        let yielding = match yielding {
            None => None,
            Some((strength, tangent_modulus, curves)) => Some(Yield {
                strength,
                tangent_modulus,
                curves: chosen("yield_curves", &curves)?,
            }),
        };
        let friction = match (annuli, radii) {
            (None, None) => AsperityFriction::StickSlip(history),
            (Some(n), None) => AsperityFriction::Annuli(history, n),
            (None, Some(n)) => AsperityFriction::MindlinIwan(Radii::equally_spaced(n).map_err(refused)?),
            (Some(_), Some(_)) => return Err(input("annuli and radii are both given; give one of them, or neither")),
        };
        let asperity =
            Asperity::try_new(ElasticPair::new(youngs_modulus, poisson_ratio), radius, yielding).map_err(refused)?;
        let gaps = readable::<f64, numpy::Ix2>("gaps", gaps)?;
        let densities = readable::<f64, numpy::Ix2>("densities", densities)?;
        check_shape("densities", densities.shape(), gaps.shape())?;
        let n_sets = gaps.shape()[1];
        let column = |of: &PyReadonlyArray2<'_, f64>, set: usize| of.as_array().column(set).to_vec();
        let bins = per_set(n_sets, |set| {
            AsperityBins::try_new(asperity, column(&gaps, set), column(&densities, set))
        })?;
        let mu = Parameter::new("mu", mu)?;
        let points = Points::new(&[("gaps", n_sets)], &[("mu", mu.len())], n_points, index)?;
        let law = ResolvedLaw::try_new(points.spread(&bins)?, points.friction(mu), friction, cone)
            .and_then(|law| law.with_limit(limit))
            .map_err(refused)?;
        Ok(Self::new(law))
    }

    /// Linearised contact; what is 3 x n has a row for each of x, y, n, and `closed` tells points that are in contact.
    #[staticmethod]
    fn linearised(
        jump: &Bound<'_, PyAny>,
        traction: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        slip_limit: &Bound<'_, PyAny>,
        closed: Vec<bool>,
    ) -> Result<Self, Exception> {
        let n = closed.len();
        let field = |name, value| -> Result<PyReadonlyArray2<'_, f64>, Exception> {
            let array = readable::<f64, numpy::Ix2>(name, value)?;
            check_shape(name, array.shape(), &[3, n])?;
            Ok(array)
        };
        let (jump, traction, stiffness) = (
            field("jump", jump)?,
            field("traction", traction)?,
            field("stiffness", stiffness)?,
        );
        let limit = Parameter::new("slip_limit", slip_limit)?.into_values();
        check_shape("slip_limit", &[limit.len()], &[n])?;
        let at = |of: &PyReadonlyArray2<'_, f64>, point: usize| [0, 1, 2].map(|row| of.as_array()[[row, point]]);
        let points = (0..n).map(|point| {
            closed[point].then(|| StaticPoint {
                jump: at(&jump, point),
                traction: at(&traction, point),
                stiffness: at(&stiffness, point),
                slip_limit: limit[point],
            })
        });
        Ok(Self::new(
            LinearisedContact::try_new(points.collect()).map_err(refused)?,
        ))
    }

    /// What [`Self::linearised`] takes, of this law about a static state.
    #[pyo3(signature = (jump: "numpy.typing.NDArray[numpy.float64]", state: "numpy.typing.NDArray[numpy.float64]") -> "tuple[list[numpy.typing.NDArray[numpy.float64]], list[bool]]")]
    fn about<'py>(
        &self,
        py: Python<'py>,
        jump: &Bound<'py, PyAny>,
        state: &Bound<'py, PyAny>,
    ) -> Result<StaticPoints<'py>, Exception> {
        let n = self.law.len();
        let (jump, state) = (self.jump("jump", jump)?, self.state("state", state)?);
        let (jump, state) = (slice("jump", &jump)?, slice("state", &state)?);
        let found = LinearisedContact::about(
            self.law.as_ref(),
            Components::stacked(jump),
            StateView::new(state, n, 0),
        )
        .map_err(refused)?;
        let points = found.points();
        let column = |of: &dyn Fn(&StaticPoint) -> f64| {
            let values = points.iter().map(|point| point.as_ref().map_or(0.0, of));
            PyArray1::from_vec(py, values.collect())
        };
        let columns = std::array::from_fn(|i| match i {
            0..3 => column(&|point| point.jump[i]),
            3..6 => column(&|point| point.traction[i - 3]),
            6..9 => column(&|point| point.stiffness[i - 6]),
            _ => column(&|point| point.slip_limit),
        });
        Ok((columns, points.iter().map(Option::is_some).collect()))
    }

    #[getter]
    fn n_points(&self) -> usize {
        self.law.len()
    }

    #[getter]
    fn n_state(&self) -> usize {
        self.law.info().n_state()
    }

    /// Name, reference, state and parameters.
    fn info(&self) -> (&'static str, &'static str, Labels, Labels) {
        let info = self.law.info();
        let labels = |list: &[Quantity]| list.iter().map(|q| (q.name.to_string(), q.unit)).collect();
        (info.name, info.reference, labels(&info.state), labels(&info.parameters))
    }

    /// Tractions, end state and, where there is an array for it, the tangent; the arrays are written.
    #[pyo3(signature = (jump, begin, sticking, traction, tangent, end))]
    fn evaluate(
        &self,
        py: Python<'_>,
        jump: &Bound<'_, PyAny>,
        begin: &Bound<'_, PyAny>,
        sticking: &str,
        traction: &Bound<'_, PyAny>,
        tangent: Option<&Bound<'_, PyAny>>,
        end: &Bound<'_, PyAny>,
    ) -> Result<(), Exception> {
        let (n, law) = (self.law.len(), self.law.as_ref());
        let sticking = chosen("sticking", sticking)?;
        let (jump, begin) = (self.jump("jump", jump)?, self.state("state", begin)?);
        let (jump, begin) = (slice("jump", &jump)?, slice("state", &begin)?);
        let mut traction = writable::<numpy::Ix2>("traction", traction, &[3, n])?;
        let mut end = writable::<numpy::Ix2>("end state", end, &[law.info().n_state(), n])?;
        let mut tangent = match tangent {
            None => None,
            Some(tangent) => Some(writable::<numpy::Ix3>("tangent", tangent, &[3, 3, n])?),
        };
        let (traction, end) = (contiguous(traction.as_slice_mut())?, contiguous(end.as_slice_mut())?);
        let tangent = match &mut tangent {
            None => None,
            Some(tangent) => Some(contiguous(tangent.as_slice_mut())?),
        };
        py.detach(|| evaluate(law, sticking, jump, begin, traction, tangent, end));
        Ok(())
    }

    /// The same, with the change of tractions and end state along a direction.
    fn derivative(
        &self,
        py: Python<'_>,
        jump: &Bound<'_, PyAny>,
        begin: &Bound<'_, PyAny>,
        d_jump: &Bound<'_, PyAny>,
        d_begin: &Bound<'_, PyAny>,
        sticking: &str,
        traction: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        d_traction: &Bound<'_, PyAny>,
        d_end: &Bound<'_, PyAny>,
    ) -> Result<(), Exception> {
        let (n, law) = (self.law.len(), self.law.as_ref());
        let sticking = chosen("sticking", sticking)?;
        let (jump, d_jump) = (self.jump("jump", jump)?, self.jump("d_jump", d_jump)?);
        let (jump, d_jump) = (slice("jump", &jump)?, slice("d_jump", &d_jump)?);
        let (begin, d_begin) = (self.state("state", begin)?, self.state("d_state", d_begin)?);
        let (begin, d_begin) = (slice("state", &begin)?, slice("d_state", &d_begin)?);
        let shape = [law.info().n_state(), n];
        let mut traction = writable::<numpy::Ix2>("traction", traction, &[3, n])?;
        let mut d_traction = writable::<numpy::Ix2>("d_traction", d_traction, &[3, n])?;
        let mut end = writable::<numpy::Ix2>("end state", end, &shape)?;
        let mut d_end = writable::<numpy::Ix2>("d_state", d_end, &shape)?;
        let (traction, d_traction) = (
            contiguous(traction.as_slice_mut())?,
            contiguous(d_traction.as_slice_mut())?,
        );
        let (end, d_end) = (contiguous(end.as_slice_mut())?, contiguous(d_end.as_slice_mut())?);
        py.detach(|| {
            law.derivative(
                0..n,
                sticking,
                Components::stacked(jump),
                StateView::new(begin, n, 0),
                Components::stacked(d_jump),
                StateView::new(d_begin, n, 0),
                StateViewMut::new(end, n, 0),
                StateViewMut::new(d_end, n, 0),
                ComponentsMut::stacked(traction),
                ComponentsMut::stacked(d_traction),
            )
        });
        Ok(())
    }

    /// Regimes of the points: 0 stick, 1 slip, 2 open, 3 input that is not finite.
    #[pyo3(signature = (jump: "numpy.typing.NDArray[numpy.float64]", begin: "numpy.typing.NDArray[numpy.float64]") -> "numpy.typing.NDArray[numpy.uint8]")]
    fn regimes<'py>(
        &self,
        py: Python<'py>,
        jump: &Bound<'py, PyAny>,
        begin: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyArray1<u8>>, Exception> {
        let (n, law) = (self.law.len(), self.law.as_ref());
        let (jump, begin) = (self.jump("jump", jump)?, self.state("state", begin)?);
        let (jump, begin) = (slice("jump", &jump)?, slice("state", &begin)?);
        let regimes = py.detach(|| {
            let mut regimes = vec![Regime::Open; n];
            let (mut end, mut traction) = (vec![0.0; begin.len()], vec![0.0; 3 * n]);
            law.evaluate(
                0..n,
                Sticking::Coulomb,
                Components::stacked(jump),
                StateView::new(begin, n, 0),
                StateViewMut::new(&mut end, n, 0),
                ComponentsMut::stacked(&mut traction),
                None,
                Some(&mut regimes),
            );
            regimes.into_iter().map(regime_number).collect()
        });
        Ok(PyArray1::from_vec(py, regimes))
    }
}

impl Law {
    fn jump<'py>(&self, name: &str, jump: &Bound<'py, PyAny>) -> Result<PyReadonlyArray2<'py, f64>, Exception> {
        let array = readable::<f64, numpy::Ix2>(name, jump)?;
        check_shape(name, array.shape(), &[3, self.law.len()])?;
        Ok(array)
    }

    fn state<'py>(&self, name: &str, state: &Bound<'py, PyAny>) -> Result<PyReadonlyArray2<'py, f64>, Exception> {
        let array = readable::<f64, numpy::Ix2>(name, state)?;
        check_shape(name, array.shape(), &[self.law.info().n_state(), self.law.len()])?;
        Ok(array)
    }
}

/// Number of a regime in arrays.
pub(crate) fn regime_number(regime: Regime) -> u8 {
    match regime {
        Regime::Stick => 0,
        Regime::Slip => 1,
        Regime::Open => 2,
        Regime::Invalid => 3,
    }
}

/// What [`writable`] has made sure of.
fn contiguous<T, E>(slice: Result<T, E>) -> Result<T, Exception> {
    slice.map_err(|_| input("arrays that are written must be contiguous in C order"))
}

/// One evaluation at all points, on arrays of the right size.
fn evaluate(
    law: &dyn TractionLaw,
    sticking: Sticking,
    jump: &[f64],
    begin: &[f64],
    traction: &mut [f64],
    tangent: Option<&mut [f64]>,
    end: &mut [f64],
) {
    let n = law.len();
    let tangent = tangent.map(|mut rest| {
        TangentMut::from_entries(std::array::from_fn(|_| {
            let (entry, after) = std::mem::take(&mut rest).split_at_mut(n);
            rest = after;
            entry
        }))
    });
    law.evaluate(
        0..n,
        sticking,
        Components::stacked(jump),
        StateView::new(begin, n, 0),
        StateViewMut::new(end, n, 0),
        ComponentsMut::stacked(traction),
        tangent,
        None,
    );
}

/// Seconds that each of `repeats` evaluations with tangent takes without Python in between, on the same arrays: what calls from
/// Python are compared with.
#[pyfunction]
pub(crate) fn time_law(
    py: Python<'_>,
    law: &Law,
    jump: &Bound<'_, PyAny>,
    begin: &Bound<'_, PyAny>,
    traction: &Bound<'_, PyAny>,
    tangent: &Bound<'_, PyAny>,
    end: &Bound<'_, PyAny>,
    repeats: usize,
) -> Result<Vec<f64>, Exception> {
    let (n, of) = (law.law.len(), law.law.as_ref());
    let (jump, begin) = (law.jump("jump", jump)?, law.state("state", begin)?);
    let (jump, begin) = (slice("jump", &jump)?, slice("state", &begin)?);
    let mut traction = writable::<numpy::Ix2>("traction", traction, &[3, n])?;
    let mut tangent = writable::<numpy::Ix3>("tangent", tangent, &[3, 3, n])?;
    let mut end = writable::<numpy::Ix2>("end state", end, &[of.info().n_state(), n])?;
    let (traction, tangent) = (
        contiguous(traction.as_slice_mut())?,
        contiguous(tangent.as_slice_mut())?,
    );
    let end = contiguous(end.as_slice_mut())?;
    Ok(py.detach(|| {
        let mut time = || {
            let start = Instant::now();
            evaluate(of, Sticking::Coulomb, jump, begin, traction, Some(tangent), end);
            start.elapsed().as_secs_f64()
        };
        (0..repeats).map(|_| time()).collect()
    }))
}
