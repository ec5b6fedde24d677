//! Ranges of the values of a scene.

use crate::error::Error;

/// Refuses values outside their range, naming the file of the scene.
pub(super) struct Check<'a> {
    pub(super) place: &'a str,
}

impl Check<'_> {
    pub(super) fn that(
        &self,
        holds: bool,
        field: &'static str,
        value: f64,
        unit: &'static str,
        requirement: &'static str,
    ) -> Result<(), Error> {
        if holds {
            return Ok(());
        }
        Err(Error::Value {
            place: self.place.into(),
            field,
            value,
            unit,
            requirement,
        })
    }

    pub(super) fn positive(&self, field: &'static str, value: f64, unit: &'static str) -> Result<(), Error> {
        self.that(is_positive(value), field, value, unit, "positive and finite")
    }

    pub(super) fn not_negative(&self, field: &'static str, value: f64, unit: &'static str) -> Result<(), Error> {
        let holds = value.is_finite() && value >= 0.0;
        self.that(holds, field, value, unit, "finite and not negative")
    }
}

pub(super) fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}
