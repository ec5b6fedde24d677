//! Traction laws at points: `microslip.laws`.

mod curves;
mod law;

use crate::error::{Exception, input};
use contact_laws::Choice;
pub(crate) use curves::Curves;
pub(crate) use law::{Law, regime_number, time_law};

/// A refusal of contact-laws.
fn refused(error: contact_laws::Error) -> Exception {
    input(error.to_string())
}

/// What a name stands for.
///
/// # Errors
/// `InputError` with the names that there are.
pub(crate) fn choice<T: Copy>(argument: &str, name: &str, names: &[(&str, T)]) -> Result<T, Exception> {
    match names.iter().find(|(known, _)| *known == name) {
        Some((_, value)) => Ok(*value),
        None => {
            let known: Vec<String> = names.iter().map(|(known, _)| format!("'{known}'")).collect();
            Err(input(format!(
                "{argument} is '{name}'; it must be one of {}",
                known.join(", ")
            )))
        }
    }
}

/// What a name of the registry stands for.
///
/// # Errors
/// `InputError` with the names that there are.
pub(crate) fn chosen<T: Choice>(argument: &str, name: &str) -> Result<T, Exception> {
    let names: Vec<(&str, T)> = T::ALL.iter().map(|&value| (value.name(), value)).collect();
    choice(argument, name, &names)
}
