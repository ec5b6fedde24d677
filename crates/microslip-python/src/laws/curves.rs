//! Contact curves: normal traction and tangential stiffness as functions of the interference.

use super::{choice, chosen, refused};
use crate::arrays::{readable, slice};
use crate::error::{Exception, input};
use contact_laws::{
    AsperityPopulation, AsperitySumCurves, ContactCurves, CurvesInfo, ElasticCurves, ElasticPair, Exponents,
    FittedCurves, GapDistribution, GreenwoodWilliamsonCurves, GreenwoodWilliamsonSurface, HeightDistribution, Jet,
    NormalFit, SampledCurves, TableOptions, Tabulated, TangentialFit,
};
use pyo3::prelude::*;

/// Curves of one kind: one set for all points, or several.
#[derive(Clone)]
pub(crate) enum Sets {
    Elastic(Vec<ElasticCurves>),
    Fitted(Vec<FittedCurves>),
    AsperitySum(Vec<AsperitySumCurves>),
    GreenwoodWilliamson(Vec<GreenwoodWilliamsonCurves>),
    Sampled(Vec<SampledCurves>),
    Table(Vec<Tabulated<Source>>),
}

/// The expression with the list of curves behind the name.
macro_rules! with_sets {
    ($sets:expr, $list:ident => $body:expr) => {
        match $sets {
            $crate::laws::curves::Sets::Elastic($list) => $body,
            $crate::laws::curves::Sets::Fitted($list) => $body,
            $crate::laws::curves::Sets::AsperitySum($list) => $body,
            $crate::laws::curves::Sets::GreenwoodWilliamson($list) => $body,
            $crate::laws::curves::Sets::Sampled($list) => $body,
            $crate::laws::curves::Sets::Table($list) => $body,
        }
    };
}
pub(crate) use with_sets;

impl Sets {
    pub(crate) fn len(&self) -> usize {
        with_sets!(self, list => list.len())
    }
}

/// What a table was made from.
#[derive(Clone)]
pub(crate) enum Source {
    Elastic(ElasticCurves),
    Fitted(FittedCurves),
    AsperitySum(AsperitySumCurves),
    GreenwoodWilliamson(GreenwoodWilliamsonCurves),
}

impl Source {
    fn curves(&self) -> &dyn ContactCurves {
        match self {
            Self::Elastic(curves) => curves,
            Self::Fitted(curves) => curves,
            Self::AsperitySum(curves) => curves,
            Self::GreenwoodWilliamson(curves) => curves,
        }
    }
}

impl ContactCurves for Source {
    fn info(&self) -> &'static CurvesInfo {
        self.curves().info()
    }

    fn normal(&self, u_n: f64) -> (f64, f64) {
        self.curves().normal(u_n)
    }

    fn tangential(&self, u_n: f64) -> [Jet; 2] {
        self.curves().tangential(u_n)
    }

    fn exponents(&self) -> Exponents {
        self.curves().exponents()
    }

    fn contact_area_ratio(&self, u_n: f64) -> Option<f64> {
        self.curves().contact_area_ratio(u_n)
    }

    fn yielded_fraction(&self, u_n: f64, omega_c: f64) -> Option<f64> {
        self.curves().yielded_fraction(u_n, omega_c)
    }
}

/// A parameter: one value, or one for each set.
pub(crate) struct Parameter {
    pub(crate) name: &'static str,
    values: Vec<f64>,
}

impl Parameter {
    /// # Errors
    /// `InputError` for anything but a list of at least one number.
    pub(crate) fn new(name: &'static str, value: &Bound<'_, PyAny>) -> Result<Self, Exception> {
        let array = readable::<f64, numpy::Ix1>(name, value)?;
        let values = slice(name, &array)?.to_vec();
        if values.is_empty() {
            return Err(input(format!("{name} has no values; give one, or one for each point")));
        }
        Ok(Self { name, values })
    }

    /// Several of them.
    fn all<const N: usize>(names: [&'static str; N], values: [&Bound<'_, PyAny>; N]) -> Result<[Self; N], Exception> {
        let mut made = Vec::with_capacity(N);
        for (name, value) in names.into_iter().zip(values) {
            made.push(Self::new(name, value)?);
        }
        made.try_into().map_err(|_| input("as many parameters as names"))
    }

    pub(crate) fn at(&self, set: usize) -> f64 {
        if self.values.len() == 1 {
            self.values[0]
        } else {
            self.values[set]
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.values.len()
    }

    pub(crate) fn into_values(self) -> Vec<f64> {
        self.values
    }
}

/// Number of sets that parameters are given for.
///
/// # Errors
/// `InputError` when lists of several values differ in length.
fn n_sets(parameters: &[&Parameter]) -> Result<usize, Exception> {
    let mut longest: Option<&Parameter> = None;
    for &parameter in parameters.iter().filter(|parameter| parameter.len() > 1) {
        match longest {
            None => longest = Some(parameter),
            Some(first) if first.len() != parameter.len() => {
                return Err(input(format!(
                    "{} has {} values where {} has {}; give one value, or the same number of them",
                    parameter.name,
                    parameter.len(),
                    first.name,
                    first.len()
                )));
            }
            Some(_) => {}
        }
    }
    Ok(longest.map_or(1, Parameter::len))
}

/// Curves, set by set.
fn sets<C>(
    parameters: &[&Parameter],
    make: impl Fn(usize) -> Result<C, contact_laws::Error>,
) -> Result<Vec<C>, Exception> {
    per_set(n_sets(parameters)?, make)
}

/// What is made of every set of parameters.
pub(crate) fn per_set<T>(
    count: usize,
    make: impl Fn(usize) -> Result<T, contact_laws::Error>,
) -> Result<Vec<T>, Exception> {
    (0..count)
        .map(|set| make(set).map_err(|error| of_set(error, set, count)))
        .collect()
}

/// A refusal with the set that it is about.
fn of_set(error: contact_laws::Error, set: usize, count: usize) -> Exception {
    match count {
        1 => refused(error),
        _ => input(format!("parameters with the index {set}: {error}")),
    }
}

/// Parameters of a population of asperities.
const ASPERITIES: [&str; 5] = [
    "asperity_density",
    "beta_x",
    "beta_y",
    "youngs_modulus",
    "poisson_ratio",
];

/// Contact curves of all points.
#[pyclass(frozen, module = "microslip._native")]
pub struct Curves(pub(crate) Sets);

#[pymethods]
impl Curves {
    /// Number of parameter sets.
    fn __len__(&self) -> usize {
        self.0.len()
    }

    /// Constant stiffnesses.
    #[staticmethod]
    fn elastic(k_n: &Bound<'_, PyAny>, k_x: &Bound<'_, PyAny>, k_y: &Bound<'_, PyAny>) -> Result<Self, Exception> {
        let [k_n, k_x, k_y] = Parameter::all(["k_n", "k_x", "k_y"], [k_n, k_x, k_y])?;
        let list = sets(&[&k_n, &k_x, &k_y], |set| {
            ElasticCurves::try_new(k_n.at(set), [k_x.at(set), k_y.at(set)])
        })?;
        Ok(Self(Sets::Elastic(list)))
    }

    /// Curves through points.
    #[staticmethod]
    fn sampled(
        interferences: Vec<f64>,
        tractions: Vec<f64>,
        areas: Vec<f64>,
        tangential_ratio: f64,
    ) -> Result<Self, Exception> {
        let made = SampledCurves::try_new(interferences, tractions, areas, tangential_ratio);
        Ok(Self(Sets::Sampled(vec![made.map_err(refused)?])))
    }

    /// Fitted curves; `ranges` are lower and upper ends of the normal fit, of that along x and of that along y, or nothing.
    #[staticmethod]
    fn fitted(
        normal: [Bound<'_, PyAny>; 5],
        tangential_x: [Bound<'_, PyAny>; 4],
        tangential_y: [Bound<'_, PyAny>; 4],
        u_ref: &Bound<'_, PyAny>,
        ranges: Option<[[f64; 2]; 3]>,
        ends: &str,
    ) -> Result<Self, Exception> {
        let ends = chosen("ends", ends)?;
        let normal = Parameter::all(
            ["normal a", "normal b", "normal c", "normal d", "normal e"],
            normal.each_ref(),
        )?;
        let x = Parameter::all(
            ["tangential_x a", "tangential_x b", "tangential_x c", "tangential_x d"],
            tangential_x.each_ref(),
        )?;
        let y = Parameter::all(
            ["tangential_y a", "tangential_y b", "tangential_y c", "tangential_y d"],
            tangential_y.each_ref(),
        )?;
        let u_ref = Parameter::new("u_ref", u_ref)?;
        let all: Vec<&Parameter> = normal.iter().chain(&x).chain(&y).chain([&u_ref]).collect();
        let list = sets(&all, |set| {
            let tangential = |of: &[Parameter], fit: usize| TangentialFit {
                a: of[0].at(set),
                b: of[1].at(set),
                c: of[2].at(set),
                d: of[3].at(set),
                u_ref: u_ref.at(set),
                k_ref: 1.0,
                range: ranges.map(|ranges| ranges[fit]),
                ends,
            };
            let fit = NormalFit {
                a: normal[0].at(set),
                b: normal[1].at(set),
                c: normal[2].at(set),
                d: normal[3].at(set),
                e: normal[4].at(set),
                u_ref: u_ref.at(set),
                t_ref: 1.0,
                range: ranges.map(|ranges| ranges[0]),
            };
            FittedCurves::try_new(fit, [tangential(&x, 1), tangential(&y, 2)])
        })?;
        Ok(Self(Sets::Fitted(list)))
    }

    /// Sums over asperities whose gaps are samples, or with `probabilities` quantiles.
    #[staticmethod]
    fn asperity_sum(
        gaps: &Bound<'_, PyAny>,
        probabilities: Option<&Bound<'_, PyAny>>,
        asperity_density: &Bound<'_, PyAny>,
        beta_x: &Bound<'_, PyAny>,
        beta_y: &Bound<'_, PyAny>,
        youngs_modulus: &Bound<'_, PyAny>,
        poisson_ratio: &Bound<'_, PyAny>,
        reading: &str,
    ) -> Result<Self, Exception> {
        let reading = chosen("reading", reading)?;
        let gaps = Parameter::new("gaps", gaps)?.into_values();
        let gaps = match probabilities {
            None => GapDistribution::try_from_samples(gaps),
            Some(probabilities) => {
                let probabilities = Parameter::new("probabilities", probabilities)?.into_values();
                GapDistribution::try_from_quantiles(&probabilities, &gaps)
            }
        }
        .map_err(refused)?;
        let [density, beta_x, beta_y, modulus, ratio] = Parameter::all(
            ASPERITIES,
            [asperity_density, beta_x, beta_y, youngs_modulus, poisson_ratio],
        )?;
        let list = sets(&[&density, &beta_x, &beta_y, &modulus, &ratio], |set| {
            let radii = [beta_x.at(set), beta_y.at(set)];
            let population = AsperityPopulation::try_new(gaps.clone(), density.at(set), radii)?;
            AsperitySumCurves::try_new(population, ElasticPair::new(modulus.at(set), ratio.at(set)), reading)
        })?;
        Ok(Self(Sets::AsperitySum(list)))
    }

    /// Closed forms for exponential or Gaussian heights.
    #[staticmethod]
    fn greenwood_williamson(
        heights: &str,
        scale: &Bound<'_, PyAny>,
        reference_height: &Bound<'_, PyAny>,
        asperity_density: &Bound<'_, PyAny>,
        beta_x: &Bound<'_, PyAny>,
        beta_y: &Bound<'_, PyAny>,
        youngs_modulus: &Bound<'_, PyAny>,
        poisson_ratio: &Bound<'_, PyAny>,
        reading: &str,
    ) -> Result<Self, Exception> {
        let reading = chosen("reading", reading)?;
        let is_gaussian = choice("heights", heights, &[("exponential", false), ("gaussian", true)])?;
        let [scale, reference] = Parameter::all(["scale", "reference_height"], [scale, reference_height])?;
        let [density, beta_x, beta_y, modulus, ratio] = Parameter::all(
            ASPERITIES,
            [asperity_density, beta_x, beta_y, youngs_modulus, poisson_ratio],
        )?;
        let all = [&scale, &reference, &density, &beta_x, &beta_y, &modulus, &ratio];
        let list = sets(&all, |set| {
            let scale = scale.at(set);
            let heights = match is_gaussian {
                false => HeightDistribution::Exponential { scale },
                true => HeightDistribution::Gaussian {
                    standard_deviation: scale,
                },
            };
            let surface = GreenwoodWilliamsonSurface {
                heights,
                reference_height: reference.at(set),
                asperity_density: density.at(set),
                radii: [beta_x.at(set), beta_y.at(set)],
            };
            GreenwoodWilliamsonCurves::try_new(surface, ElasticPair::new(modulus.at(set), ratio.at(set)), reading)
        })?;
        Ok(Self(Sets::GreenwoodWilliamson(list)))
    }

    /// Tables of other curves between two interferences.
    #[staticmethod]
    fn table(
        py: Python<'_>,
        source: &Curves,
        range: [f64; 2],
        tolerance_normal: f64,
        tolerance_tangential: f64,
        max_knots_per_octave: u32,
    ) -> Result<Self, Exception> {
        let options = TableOptions {
            tolerance_normal,
            tolerance_tangential,
            max_knots_per_octave,
        };
        let sources: Vec<Source> = match &source.0 {
            Sets::Elastic(list) => list.iter().copied().map(Source::Elastic).collect(),
            Sets::Fitted(list) => list.iter().cloned().map(Source::Fitted).collect(),
            Sets::AsperitySum(list) => list.iter().cloned().map(Source::AsperitySum).collect(),
            Sets::GreenwoodWilliamson(list) => list.iter().copied().map(Source::GreenwoodWilliamson).collect(),
            Sets::Sampled(_) => return Err(input("source is sampled already; give the law the samples themselves")),
            Sets::Table(_) => return Err(input("source is a table already; make a table of the curves behind it")),
        };
        let count = sources.len();
        let made = py.detach(|| {
            let table = |(set, source)| Tabulated::try_new(source, range, options).map_err(|error| (error, set));
            sources
                .into_iter()
                .enumerate()
                .map(table)
                .collect::<Result<Vec<_>, _>>()
        });
        made.map(|list| Self(Sets::Table(list)))
            .map_err(|(error, set)| of_set(error, set, count))
    }

    /// Largest relative errors of normal traction and tangential stiffness that tables have in their range; none of other curves.
    fn table_errors(&self) -> Option<(f64, f64)> {
        let Sets::Table(list) = &self.0 else { return None };
        let largest = |error: fn(&Tabulated<Source>) -> f64| list.iter().map(error).fold(0.0, f64::max);
        Some((
            largest(Tabulated::max_relative_error_normal),
            largest(Tabulated::max_relative_error_tangential),
        ))
    }
}
