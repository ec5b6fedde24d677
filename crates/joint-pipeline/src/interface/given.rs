//! Laws whose parameters a scene gives itself.

use crate::Error;
use crate::scene::{ContactStiffness, Curves, Fitted, Length, ParameterSet, Parameters, Per, Scene, Stress};
use contact_laws::{
    ContactCurves, ElasticCurves, FittedCurves, FittedPoints, FrictionalLaw, NormalFit, PointParameters,
    TangentialEnds, TangentialFit, TractionLaw,
};
use std::sync::Arc;
use surface_characterisation::ElementSurface;

/// A law from given parameters.
pub(crate) struct GivenLaw {
    pub(crate) law: Arc<dyn TractionLaw>,
    /// As in reports.
    pub(crate) kind: &'static str,
    /// Gap at each point (m).
    pub(crate) gap: Vec<f64>,
    curves: Vec<Box<dyn ContactCurves>>,
    set_of: Vec<u32>,
}

impl GivenLaw {
    /// The law at points whose elements are `element_of`, in ascending order.
    ///
    /// # Errors
    /// [`Error::Parameters`]; those of the law.
    pub(crate) fn try_new(scene: &Scene, parameters: &Parameters, element_of: &[u32]) -> Result<Self, Error> {
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
        let mu = PointParameters::per_point(per_point(&|set| sets[set].mu.unwrap_or(scene.mu)));
        let gap = per_point(&|set| sets[set].gap.si());
        let mixed = |set: usize| Error::Parameters {
            reason: format!(
                "set {} has other curves than the first; give all sets curves of one kind",
                set + 1
            ),
        };
        let (history, cone) = (scene.law.history, scene.law.cone);
        let (law, kind, curves): (Arc<dyn TractionLaw>, _, Vec<Box<dyn ContactCurves>>) = match first {
            Curves::Elastic(_) => {
                let curves = sets
                    .iter()
                    .enumerate()
                    .map(|(index, set)| match &set.curves {
                        Curves::Elastic(e) => Ok(ElasticCurves::try_new(
                            e.normal_stiffness.si(),
                            e.tangential_stiffness.map(ContactStiffness::si),
                        )?),
                        Curves::Fitted(_) => Err(mixed(index)),
                    })
                    .collect::<Result<Vec<_>, Error>>()?;
                let points = PointParameters::try_indexed(curves.clone(), set_of.clone())?;
                let law = Arc::new(FrictionalLaw::try_new(points, mu, history)?.with_cone(cone));
                (law, "elastic", curves.into_iter().map(|c| Box::new(c) as _).collect())
            }
            Curves::Fitted(_) => {
                let curves = sets
                    .iter()
                    .enumerate()
                    .map(|(index, set)| match &set.curves {
                        Curves::Fitted(fitted) => fitted_curves(fitted),
                        Curves::Elastic(_) => Err(mixed(index)),
                    })
                    .collect::<Result<Vec<_>, Error>>()?;
                let points = PointParameters::try_indexed(curves.clone(), set_of.clone())?;
                let law =
                    Arc::new(FrictionalLaw::try_new(FittedPoints::<f64>::new(&points), mu, history)?.with_cone(cone));
                (law, "fitted", curves.into_iter().map(|c| Box::new(c) as _).collect())
            }
        };
        Ok(Self {
            law,
            kind,
            gap,
            curves,
            set_of,
        })
    }

    /// The curves at a point.
    pub(crate) fn at(&self, point: usize) -> &dyn ContactCurves {
        &*self.curves[self.set_of[point] as usize]
    }
}

impl From<&ElementSurface> for Curves {
    /// The fits of one element of a scan. Scenes continue eq. (29) beyond its range as a Mindlin stiffness.
    fn from(element: &ElementSurface) -> Self {
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
        Self::Fitted(Fitted {
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
}

fn fitted_curves(fitted: &Fitted) -> Result<FittedCurves, Error> {
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
    Ok(FittedCurves::try_new(normal, tangential)?)
}
