//! Uncertain numbers of a scene that is read: made SI, taken about the scene's own values, and tried at their ends.

use crate::distribution::{Marginal, cholesky};
use crate::error::Error;
use crate::json::Refusal;
use crate::law::LawKind;
use crate::parameter::Parameter;
use crate::scene::Scene;
use crate::surface::Surface;
use crate::uncertain::{Distribution, LAW_ERROR, Lognormal, NumberOrText, Uncertain, beyond, of_parameter};
use crate::units::Units;
use serde_json::json;

/// Probability beyond which the scene need not accept a value, at either end of a distribution.
const BEYOND: f64 = 1e-6;

impl Uncertain {
    /// The distributions in numbers (SI), in the order of the parameters.
    ///
    /// # Errors
    /// [`Error::Uncertain`] for a distribution that is none; [`Error::Parameter`] where the scene has no such number.
    pub fn marginals(&self, scene: &Scene) -> Result<Vec<Marginal>, Error> {
        let marginal = |(parameter, distribution): (&Parameter, &Distribution)| {
            let nominal = parameter.value(scene)?;
            let found = distribution.marginal(parameter, nominal);
            found.map_err(|reason| of_parameter(parameter, reason))
        };
        self.parameters.iter().map(marginal).collect()
    }

    /// With the error of the law among the parameters, where it is to be in.
    pub fn with_law_error(&self, scene: &Scene) -> Self {
        let mut all = self.clone();
        let factor = self.law_error.unwrap_or(LAW_ERROR);
        if factor > 1.0 && self.lacks_law_error(scene).is_none() {
            let lognormal = Lognormal {
                median: Some(NumberOrText::Number(scene.interfaces.scale.asperity_height)),
                factor: Some(factor),
                cov: None,
            };
            let distribution = Distribution {
                lognormal: Some(lognormal),
                ..Distribution::default()
            };
            all.parameters.insert(Parameter::asperity_height(), distribution);
        }
        all
    }

    /// Why no error of the law can be added; none where it can.
    fn lacks_law_error(&self, scene: &Scene) -> Option<&'static str> {
        if self.parameters.contains_key(&Parameter::asperity_height()) {
            return Some("interfaces.scale.asperity_height has a distribution of its own");
        }
        let all = scene
            .interfaces
            .single()
            .all(|one| !matches!(one.surface, Surface::Parameters(_)) && one.law.kind != LawKind::BoundaryElements);
        (!all).then_some("it is known of sums over asperities alone, and an interface has another law")
    }

    /// Makes all values SI. `units` are those of the file that the scene was read from.
    pub(super) fn convert(&mut self, scene: &Scene, units: Units) -> Result<(), Error> {
        for (parameter, distribution) in &mut self.parameters {
            parameter.value(scene)?;
            for (place, given) in distribution.quantities() {
                let raw = match &*given {
                    NumberOrText::Number(value) => json!(value),
                    NumberOrText::Text(text) => json!(text),
                };
                let read = parameter.read(scene, raw, units);
                let si =
                    read.map_err(|Refusal { message, .. }| of_parameter(parameter, format!("{place}: {message}")))?;
                *given = NumberOrText::Number(si);
            }
        }
        Ok(())
    }

    /// Refuses what cannot be sampled; `scene` is without its uncertain inputs.
    pub(super) fn validate(&self, scene: &Scene) -> Result<(), Error> {
        let refused = |field: &str, reason: String| Error::Uncertain {
            field: field.into(),
            reason,
        };
        if self.parameters.is_empty() {
            let reason = "there are none; name one, such as { \"mu\": { \"uniform\": [0.15, 0.25] } }";
            return Err(refused("parameters", reason.into()));
        }
        if !(self.confidence > 0.0 && self.confidence < 1.0) {
            let reason = format!(
                "{} is no probability; it must be between 0 and 1, such as 0.9",
                self.confidence
            );
            return Err(refused("confidence", reason));
        }
        Parameter::refuse_together(self.parameters.keys(), scene).map_err(|reason| refused("parameters", reason))?;
        for (parameter, marginal) in self.parameters.keys().zip(self.marginals(scene)?) {
            for probability in [BEYOND, 1.0 - BEYOND] {
                let value = marginal.quantile(probability);
                if let Err(error) = parameter.with(scene, value) {
                    return Err(of_parameter(parameter, beyond(value, &error)));
                }
            }
        }
        if let Some(factor) = self.law_error {
            if !(factor >= 1.0 && factor.is_finite()) {
                return Err(refused(
                    "law_error",
                    format!("{factor} must be at least 1: it is a factor, and 1 is no error"),
                ));
            }
            if let (true, Some(reason)) = (factor > 1.0, self.lacks_law_error(scene)) {
                return Err(refused(
                    "law_error",
                    format!("{factor} does nothing: {reason}; leave it out"),
                ));
            }
        }
        cholesky(&self.correlation()?).map_err(|reason| refused("correlations", reason))?;
        if self.sobol_indices && !self.correlations.is_empty() {
            let reason =
                "shares of the variance belong to independent parameters; leave out correlations or sobol_indices";
            return Err(refused("sobol_indices", reason.into()));
        }
        Ok(())
    }
}
