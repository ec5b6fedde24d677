//! Pressures that laws are made for.

use super::resolved::Counted;

/// Pressures that a law is made for.
#[derive(Clone, Copy)]
pub(super) struct Pressures<'a> {
    /// Of the bolts over the whole interface (Pa).
    pub(super) mean: f64,
    /// At the points under the bolt loads (Pa); none before they are known.
    pub(super) at_rest: Option<&'a [f64]>,
    /// What is found for these once for all parts.
    pub(super) counted: &'a Counted,
}
