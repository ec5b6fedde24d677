//! Cases that differ, and parts of them.

use crate::Error;
use analyses::cases::ErrorBounds;
use std::str::FromStr;

/// A case that differs from all others.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// SHA-256 of all that it depends on.
    pub(crate) address: String,
    /// Its first number in the plan.
    pub(crate) number: usize,
    /// Index of its structure.
    pub(crate) structure: usize,
    /// Index of its surface.
    pub(crate) surface: usize,
    /// What its results may be off by where it learns from other cases.
    pub(crate) learns: Option<ErrorBounds>,
}

/// One of several parts of equal numbers of cases. Which cases a part has depends on the plan alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which, from 1.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl Part {
    /// Its cases of so many.
    pub(crate) fn range(self, cases: usize) -> std::ops::Range<usize> {
        let end = |part: usize| (part as u128 * cases as u128 / self.of as u128) as usize;
        end(self.number - 1)..end(self.number)
    }
}

impl FromStr for Part {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        let parts = text.split_once('/').and_then(|(k, n)| Some((number(k)?, number(n)?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err(Error::Part { text: text.into() }),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn parts_have_every_case_once() {
        for (cases, of) in [(10, 3), (7, 7), (3, 8), (1000, 2), (1, 1)] {
            let mut covered = Vec::new();
            for number in 1..=of {
                covered.extend(Part { number, of }.range(cases));
            }
            assert_eq!(covered, (0..cases).collect::<Vec<_>>());
        }
        assert_eq!("2/5".parse::<Part>().unwrap(), Part { number: 2, of: 5 });
        for text in ["0/5", "6/5", "1", "a/b", "1/0", "-1/2"] {
            let message = text.parse::<Part>().unwrap_err().to_string();
            assert!(message.contains(text) && message.contains("3/20"), "{message}");
        }
    }
}
