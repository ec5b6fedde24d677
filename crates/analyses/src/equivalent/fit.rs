//! The element of a family nearest to levels, by least squares of the relative errors of stiffness and dissipation.
//!
//! Both are linear in stiffnesses. So the other two numbers, a displacement and a power, are looked for on a grid first; then
//! Levenberg-Marquardt finds all from the best places of it. Of the stiffnesses the first is always there, each other one only if the errors ask for it.

use super::level::{Hysteretic, Level};
use crate::Error;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Matrix3, Owned, Vector3};
use serde::Serialize;

/// Largest relative error of stiffness or dissipation beyond which a fit is poor.
pub const POOR: f64 = 0.1;

/// Places of the grid that are looked at: displacements from half the smallest amplitude on, and powers.
const DISPLACEMENTS: usize = 30;
const POWERS: usize = 12;
const MOST_DISPLACEMENT: f64 = 1e3;
const POWER_RANGE: [f64; 2] = [0.1, 6.0];

/// Places from which the search begins.
const STARTS: usize = 4;

/// To which part the sum of squares must fall for a further stiffness to be believed.
const BETTER: f64 = 0.95;

/// Relative error that is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Stiffnesses of an element: the first belongs to the displacement and the power.
pub(super) type Stiffnesses = [f64; 3];

/// Stiffness and dissipation at an amplitude per unit of each stiffness.
pub(super) struct Columns {
    pub(super) stiffness: Stiffnesses,
    pub(super) dissipation: Stiffnesses,
}

fn dot(a: Stiffnesses, b: Stiffnesses) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Columns {
    pub(super) fn stiffness(&self, of: Stiffnesses) -> f64 {
        dot(self.stiffness, of)
    }

    pub(super) fn dissipation(&self, of: Stiffnesses) -> f64 {
        dot(self.dissipation, of)
    }
}

/// Elements of a displacement (at which all slips), a positive power, and stiffnesses of which all but the first may be zero.
pub(super) trait Family: Sized {
    /// Which stiffnesses are there, from the fewest to the most.
    const CHOICES: &'static [[bool; 3]];

    fn columns(u: f64, shape: [f64; 2]) -> Columns;

    fn of(shape: [f64; 2], stiffnesses: Stiffnesses) -> Self;

    /// What [`Family::of`] makes it from.
    fn apart(&self) -> ([f64; 2], Stiffnesses);
}

impl<F: Family> Hysteretic for F {
    fn stiffness(&self, u: f64) -> f64 {
        let (shape, linear) = self.apart();
        Self::columns(u, shape).stiffness(linear)
    }

    fn dissipation(&self, u: f64) -> f64 {
        let (shape, linear) = self.apart();
        Self::columns(u, shape).dissipation(linear)
    }
}

/// How far an element is from levels, relative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Root mean square.
    pub rms: f64,
    /// Largest.
    pub largest: f64,
}

impl Deviation {
    fn of(errors: &[f64]) -> Self {
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        Self {
            rms: (squares / errors.len() as f64).sqrt(),
            largest: errors.iter().fold(0.0, |most, e| most.max(e.abs())),
        }
    }
}

/// Whether a fit stands for the levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quality {
    /// No stiffness and no dissipation is further off than [`POOR`].
    Good,
    /// One is.
    Poor,
}

/// An element with its errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fit<E> {
    /// The element.
    pub element: E,
    /// Error of the stiffness.
    pub stiffness: Deviation,
    /// Error of the dissipation.
    pub dissipation: Deviation,
    /// Smallest and largest amplitude of the levels; elsewhere the element is a guess.
    pub amplitudes: [f64; 2],
    /// Levels.
    pub levels: usize,
    /// Levels with a dissipation.
    pub levels_with_dissipation: usize,
    /// Whether it stands for them.
    pub quality: Quality,
    /// Whether the levels reach the displacement at which all slips. If not, they know three numbers and no fourth: `beta` or `alpha` is zero then, and
    /// the slip force is no prediction.
    pub slips_wholly: bool,
}

fn errors<E: Hysteretic>(element: &E, levels: &[Level]) -> [Vec<f64>; 2] {
    let stiffness = levels
        .iter()
        .map(|level| element.stiffness(level.amplitude) / level.stiffness - 1.0);
    let dissipation = levels
        .iter()
        .filter_map(|level| Some(element.dissipation(level.amplitude) / level.dissipation? - 1.0));
    [stiffness.collect(), dissipation.collect()]
}

/// The best stiffnesses for a displacement and a power, and their sum of squares; none where one is not positive.
fn best<F: Family>(levels: &[Level], shape: [f64; 2], there: [bool; 3]) -> Option<(f64, Stiffnesses)> {
    let rows: Vec<Stiffnesses> = levels
        .iter()
        .flat_map(|level| {
            let columns = F::columns(level.amplitude, shape);
            let stiffness = columns.stiffness.map(|value| value / level.stiffness);
            let dissipation = level
                .dissipation
                .map(|found| columns.dissipation.map(|value| value / found));
            std::iter::once(stiffness).chain(dissipation)
        })
        .collect();
    // Normal equations with ones on the right; what is not there has an equation of its own.
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for row in &rows {
        let row = Vector3::from_fn(|i, _| if there[i] { row[i] } else { 0.0 });
        matrix += row * row.transpose();
        right += row;
    }
    let scale = matrix[(0, 0)];
    (0..3).filter(|i| !there[*i]).for_each(|i| matrix[(i, i)] = scale);
    let found: Stiffnesses = matrix.cholesky()?.solve(&right).into();
    let is_good = (0..3).all(|i| found[i].is_finite() && (found[i] > 0.0 || !there[i]));
    let cost = rows.iter().map(|row| (dot(*row, found) - 1.0).powi(2)).sum();
    is_good.then_some((cost, found))
}

/// The element of the family nearest to the levels.
pub(super) fn nearest<F: Family>(levels: &[Level]) -> Result<Fit<F>, Error> {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let refused = |reason: String| Error::Equivalent { reason };
    for level in levels {
        let values = [level.amplitude, level.stiffness, level.dissipation.unwrap_or(1.0)];
        if !values.iter().all(|value| positive(*value)) {
            return Err(refused(format!(
                "the level of amplitude {:e} has the stiffness {:e} and the dissipation {:e}; all must be positive and finite",
                level.amplitude,
                level.stiffness,
                level.dissipation.unwrap_or_default()
            )));
        }
    }
    let known = levels.iter().filter(|level| level.dissipation.is_some()).count();
    if known < 3 {
        return Err(refused(format!(
            "{known} amplitudes have a stiffness and a dissipation above its floor, and an element needs three; ask for more in analyses.backbone"
        )));
    }
    let amplitudes = levels.iter().map(|level| level.amplitude);
    let range = amplitudes.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], u| {
        [low.min(u), high.max(u)]
    });
    let noise = (levels.len() + known) as f64 * ROUND_OFF.powi(2);
    let mut found: Option<(f64, usize, F)> = None;
    for there in F::CHOICES {
        let count = there.iter().filter(|there| **there).count();
        let Some((cost, element)) = searched::<F>(levels, range, *there) else {
            continue;
        };
        let is_better = found.as_ref().is_none_or(|(least, fewer, _)| {
            cost < if count > *fewer { BETTER * least } else { *least } && (*least > noise || count == *fewer)
        });
        if is_better {
            found = Some((cost, count, element));
        }
    }
    let Some((.., element)) = found else {
        return Err(refused("no element comes near to the levels".into()));
    };
    let [stiffness, dissipation] = errors(&element, levels).map(|errors| Deviation::of(&errors));
    let ([largest, _], [_, others @ ..]) = element.apart();
    Ok(Fit {
        quality: match stiffness.largest.max(dissipation.largest) <= POOR {
            true => Quality::Good,
            false => Quality::Poor,
        },
        slips_wholly: others.iter().any(|other| *other > 0.0) || largest < range[1],
        element,
        stiffness,
        dissipation,
        amplitudes: range,
        levels: levels.len(),
        levels_with_dissipation: known,
    })
}

/// The nearest element with the stiffnesses that are there, and its sum of squares.
fn searched<F: Family>(levels: &[Level], [low, high]: [f64; 2], there: [bool; 3]) -> Option<(f64, F)> {
    let step = |k: usize, n: usize, [from, to]: [f64; 2]| from * (to / from).powf(k as f64 / (n - 1) as f64);
    let places = (0..DISPLACEMENTS).flat_map(|i| (0..POWERS).map(move |j| (i, j)));
    let mut starts: Vec<(f64, [f64; 2], Stiffnesses)> = places
        .filter_map(|(i, j)| {
            let shape = [
                step(i, DISPLACEMENTS, [0.5 * low, MOST_DISPLACEMENT * high]),
                step(j, POWERS, POWER_RANGE),
            ];
            let (cost, stiffnesses) = best::<F>(levels, shape, there)?;
            Some((cost, shape, stiffnesses))
        })
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let solver = LevenbergMarquardt::new().with_tol(1e-15).with_patience(100);
    let found = starts.iter().take(STARTS).map(|(_, shape, stiffnesses)| {
        let free = stiffnesses
            .iter()
            .zip(there)
            .filter(|(_, there)| *there)
            .map(|(value, _)| *value);
        let numbers: Vec<f64> = shape.iter().copied().chain(free).map(f64::ln).collect();
        let problem = Problem::<F> {
            levels,
            there,
            logarithms: DVector::from_vec(numbers),
            family: std::marker::PhantomData,
        };
        let problem = solver.minimize(problem).0;
        let element = problem.element(&problem.logarithms);
        let cost = errors(&element, levels).iter().flatten().map(|e| e * e).sum::<f64>();
        (cost, element)
    });
    found
        .filter(|(cost, _)| cost.is_finite())
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Relative errors over the logarithms of the numbers.
struct Problem<'a, F> {
    levels: &'a [Level],
    there: [bool; 3],
    logarithms: DVector<f64>,
    family: std::marker::PhantomData<F>,
}

impl<F: Family> Problem<'_, F> {
    fn element(&self, logarithms: &DVector<f64>) -> F {
        let mut values = logarithms.iter().map(|logarithm| logarithm.exp());
        let mut next = |is_there: bool| if is_there { values.next().unwrap_or(0.0) } else { 0.0 };
        let shape = [next(true), next(true)];
        F::of(shape, self.there.map(next))
    }

    fn errors(&self, logarithms: &DVector<f64>) -> DVector<f64> {
        let [stiffness, dissipation] = errors(&self.element(logarithms), self.levels);
        DVector::from_vec([stiffness, dissipation].concat())
    }
}

impl<F: Family> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, F> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, logarithms: &DVector<f64>) {
        self.logarithms.copy_from(logarithms);
    }

    fn params(&self) -> DVector<f64> {
        self.logarithms.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let errors = self.errors(&self.logarithms);
        errors.iter().all(|e| e.is_finite()).then_some(errors)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        const STEP: f64 = 1e-5;
        let columns: Vec<DVector<f64>> = (0..self.logarithms.len())
            .map(|k| {
                let beside = |step: f64| {
                    let mut at = self.logarithms.clone();
                    at[k] += step;
                    self.errors(&at)
                };
                (beside(STEP) - beside(-STEP)) / (2.0 * STEP)
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        jacobian.iter().all(|x| x.is_finite()).then_some(jacobian)
    }
}
