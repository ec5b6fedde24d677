//! Laws whose parameters a scene gives itself.

use super::law::frictional;
use super::surface::material;
use crate::Error;
use contact_laws::{
    ContactCurves, ElasticCurves, ElasticPair, FittedCurves, FittedPoints, GreenwoodWilliamsonCurves,
    GreenwoodWilliamsonSurface, HeightDistribution, NormalFit, PointParameters, TangentialEnds, TangentialFit,
    TractionLaw,
};
use scenes::{
    ContactStiffness, Curves, Fitted, GreenwoodWilliamson, Heights, Length, ParameterSet, Parameters, Per, Scene,
    Stress,
};
use std::sync::Arc;
use surface_characterisation::ElementSurface;

/// A law from given parameters.
pub(crate) struct GivenLaw {
    pub law: Arc<dyn TractionLaw>,
    /// As in reports.
    pub kind: &'static str,
    /// Gap at each point (m).
    pub gap: Vec<f64>,
    /// Interference at each point that the preload belongs to (m).
    pub interference: Vec<f64>,
    /// Preload at each point (Pa).
    pub preload: Vec<f64>,
    curves: Vec<Box<dyn ContactCurves>>,
    set_of: Vec<u32>,
}

impl GivenLaw {
    /// The law at points whose elements are `element_of`, in ascending order.
    ///
    /// # Errors
    /// [`Error::Parameters`]; those of the law.
    pub(crate) fn try_new(
        scene: &Scene,
        parameters: &Parameters,
        element_of: &[u32],
        mu: &PointParameters<f64>,
    ) -> Result<Self, Error> {
        let Parameters { per, sets } = parameters;
        let n_points = element_of.len();
        let (set_of, expected, what): (Vec<u32>, _, _) = match per {
            Per::Interface => (vec![0; n_points], 1, "set for the interface"),
            Per::Element => {
                let n = element_of.last().map_or(0, |&last| last as usize + 1);
                (element_of.to_vec(), n, "elements")
            }
            Per::Point => ((0..n_points as u32).collect(), n_points, "points"),
        };
        let complete = (sets.len() == expected).then_some(sets.as_slice());
        let Some([ParameterSet { curves: first, .. }, ..]) = complete else {
            return Err(Error::Parameters {
                reason: format!("{} sets are given for {expected} {what}", sets.len()),
            });
        };
        let per_point = |of: &dyn Fn(usize) -> f64| set_of.iter().map(|&set| of(set as usize)).collect::<Vec<f64>>();
        let of_sets = sets.iter().any(|set| set.mu.is_some());
        if of_sets && !scene.interfaces.friction_zones.is_empty() {
            return Err(Error::Parameters {
                reason: "sets have `mu`, and so have interfaces.friction_zones; leave one of them out".into(),
            });
        }
        let mu = if of_sets {
            PointParameters::per_point(per_point(&|set| sets[set].mu.unwrap_or(scene.interfaces.mu)))
        } else {
            mu.clone()
        };
        let gap = per_point(&|set| sets[set].gap.si());
        let built = match first {
            Curves::Elastic(_) => {
                let read = |curves: &Curves| match curves {
                    Curves::Elastic(e) => Some(ElasticCurves::try_new(
                        e.normal_stiffness.si(),
                        e.tangential_stiffness.map(ContactStiffness::si),
                    )),
                    _ => None,
                };
                let curves = one_kind(sets, read)?;
                let points = PointParameters::try_indexed(curves.clone(), set_of.clone())?;
                ("elastic", frictional(points, mu, scene)?, boxed(curves))
            }
            Curves::Fitted(_) => {
                let read = |curves: &Curves| match curves {
                    Curves::Fitted(fitted) => Some(fitted_curves(fitted)),
                    _ => None,
                };
                let curves = one_kind(sets, read)?;
                let points = PointParameters::try_indexed(curves.clone(), set_of.clone())?;
                let points = FittedPoints::<f64>::new(&points);
                ("fitted", frictional(points, mu, scene)?, boxed(curves))
            }
            Curves::GreenwoodWilliamson(_) => {
                let material = material(scene)?;
                let read = |curves: &Curves| match curves {
                    Curves::GreenwoodWilliamson(surface) => Some(greenwood_williamson(surface, material)),
                    _ => None,
                };
                let curves = one_kind(sets, read)?;
                let points = PointParameters::try_indexed(curves.clone(), set_of.clone())?;
                ("greenwood-williamson", frictional(points, mu, scene)?, boxed(curves))
            }
        };
        let (kind, law, curves) = built;
        let preloaded = (1..).zip(sets.iter().zip(&curves));
        let interference = preloaded.map(|(number, (set, curves))| interference(&**curves, set.preload.si(), number));
        let interference = interference.collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            law,
            kind,
            gap,
            interference: per_point(&|set| interference[set]),
            preload: per_point(&|set| sets[set].preload.si()),
            curves,
            set_of,
        })
    }

    /// The curves at a point.
    pub(crate) fn at(&self, point: usize) -> &dyn ContactCurves {
        &*self.curves[self.set_of[point] as usize]
    }
}

/// The fits of one element of a scan. Scenes continue eq. (29) beyond its range as a Mindlin stiffness.
pub fn curves_of_element(element: &ElementSurface) -> Curves {
    let NormalFit {
        a,
        b,
        c,
        d,
        e,
        u_ref,
        t_ref,
        range,
    } = element.normal.parameters;
    Curves::Fitted(Fitted {
        normal: [a, b, c, d, e],
        tangential: element.tangential.each_ref().map(|fit| {
            let TangentialFit { a, b, c, d, .. } = fit.parameters;
            [a, b, c, d]
        }),
        u_ref: Length::from_si(u_ref),
        t_ref: Stress::from_si(t_ref),
        k_ref: ContactStiffness::from_si(element.tangential[0].parameters.k_ref),
        range: range.map(|range| range.map(Length::from_si)),
    })
}

/// The interference at which curves have a pressure (Pa): bisection on a rising function. `number` is that of the set.
fn interference(curves: &dyn ContactCurves, pressure: f64, number: usize) -> Result<f64, Error> {
    if pressure == 0.0 {
        return Ok(0.0);
    }
    let (mut low, mut high) = (0.0, 1e-12);
    while curves.normal(high).0 < pressure {
        (low, high) = (high, 2.0 * high);
        if !(high < 1e30) {
            return Err(Error::Parameters {
                reason: format!("set {number} has a preload of {pressure:.4e} Pa, which its curves never reach"),
            });
        }
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Ok(high);
        }
        match curves.normal(middle).0 < pressure {
            true => low = middle,
            false => high = middle,
        }
    }
}

/// The curves of all sets, which must be of one kind: `read` finds none in others.
fn one_kind<C>(
    sets: &[ParameterSet],
    read: impl Fn(&Curves) -> Option<Result<C, contact_laws::Error>>,
) -> Result<Vec<C>, Error> {
    let curves = (1..).zip(sets).map(|(number, set)| match read(&set.curves) {
        Some(curves) => Ok(curves?),
        None => Err(Error::Parameters {
            reason: format!("set {number} has other curves than the first; give all sets curves of one kind"),
        }),
    });
    curves.collect()
}

fn boxed<C: ContactCurves + 'static>(curves: Vec<C>) -> Vec<Box<dyn ContactCurves>> {
    curves.into_iter().map(|curves| Box::new(curves) as _).collect()
}

fn greenwood_williamson(
    given: &GreenwoodWilliamson,
    material: ElasticPair,
) -> Result<GreenwoodWilliamsonCurves, contact_laws::Error> {
    let heights = match given.heights {
        Heights::Exponential(scale) => HeightDistribution::Exponential { scale: scale.si() },
        Heights::Gaussian(deviation) => HeightDistribution::Gaussian {
            standard_deviation: deviation.si(),
        },
    };
    let surface = GreenwoodWilliamsonSurface {
        heights,
        reference_height: given.reference_height.si(),
        asperity_density: given.asperity_density.si(),
        radii: given.radii.map(Length::si),
    };
    GreenwoodWilliamsonCurves::try_new(surface, material, given.tangential)
}

fn fitted_curves(fitted: &Fitted) -> Result<FittedCurves, contact_laws::Error> {
    let [a, b, c, d, e] = fitted.normal;
    let (u_ref, range) = (fitted.u_ref.si(), fitted.range.map(|range| range.map(Length::si)));
    let normal = NormalFit {
        a,
        b,
        c,
        d,
        e,
        u_ref,
        t_ref: fitted.t_ref.si(),
        range,
    };
    let tangential = fitted.tangential.map(|[a, b, c, d]| TangentialFit {
        a,
        b,
        c,
        d,
        u_ref,
        k_ref: fitted.k_ref.si(),
        range,
        ends: TangentialEnds::Mindlin,
    });
    FittedCurves::try_new(normal, tangential)
}
