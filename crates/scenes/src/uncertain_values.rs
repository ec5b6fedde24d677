//! Uncertain numbers of a scene that is read: made SI, taken about the scene's own values, and tried at their ends.

use crate::distribution::{Marginal, cholesky};
use crate::error::Error;
use crate::json::Refusal;
use crate::parameter::Parameter;
use crate::scene::Scene;
use crate::uncertain::{Distribution, NumberOrText, Uncertain, beyond, of_parameter};
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
        cholesky(&self.correlation()?).map_err(|reason| refused("correlations", reason))?;
        if self.sobol_indices && !self.correlations.is_empty() {
            let reason =
                "shares of the variance belong to independent parameters; leave out correlations or sobol_indices";
            return Err(refused("sobol_indices", reason.into()));
        }
        Ok(())
    }
}
