//! What building an interface may take, and who hears of it.

use crate::progress::{Progress, Silent};
use crate::store::Options;
use dense_algebra::Limits;

/// What building an interface may take, and who hears of it.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    pub(super) limits: Limits<'a>,
    pub(super) options: &'a Options,
    pub(super) progress: &'a dyn Progress,
}

/// Nothing is stored.
static NOWHERE: Options = Options {
    cache: None,
    build: None,
    memory: None,
};

impl Default for Work<'_> {
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            options: &NOWHERE,
            progress: &Silent,
        }
    }
}
