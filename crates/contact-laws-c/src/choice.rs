//! The codes of what a caller chooses: those of [`contact_laws::Choice`], as constants `CL_SUBJECT_NAME`.

use core::fmt;

use contact_laws::Choice;

use crate::boundary::Error;

/// What a code stands for.
pub(crate) fn choice<T: Choice>(argument: &'static str, code: i32) -> Result<T, Error> {
    T::by_number(code).ok_or(Error::Code {
        argument,
        code,
        allowed: allowed::<T>,
    })
}

/// The constants, as a refusal lists them.
fn allowed<T: Choice>(f: &mut fmt::Formatter<'_>) -> fmt::Result {
    for (i, &value) in T::ALL.iter().enumerate() {
        let before = match i {
            0 => "",
            _ if i + 1 == T::ALL.len() => " or ",
            _ => ", ",
        };
        write!(f, "{before}{}", Constant(value))?;
    }
    Ok(())
}

/// The name of a value's constant in C.
#[derive(Debug)]
pub struct Constant<T>(pub T);

impl<T: Choice> fmt::Display for Constant<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CL_{}_", T::SUBJECT)?;
        self.0.name().chars().try_for_each(|letter| match letter {
            '-' => f.write_str("_"),
            letter => write!(f, "{}", letter.to_ascii_uppercase()),
        })
    }
}
