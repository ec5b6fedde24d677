//! What the descriptions of history rules speak of.

use super::dual::{Dual, Rounded};

/// A quantity with its derivatives with respect to the jump.
pub(crate) type Quantity3 = Dual<Rounded, 3>;

/// The path of a point along one tangential direction, as descriptions of rules speak of it.
pub(crate) struct Described<'a> {
    /// What the state remembers beside the jump: traction or stretch.
    pub(crate) memory: Quantity3,
    /// Jump reached, and its change since the state committed last.
    pub(crate) u: Quantity3,
    pub(crate) moved: Quantity3,
    /// The same of the interference.
    pub(crate) u_n: Quantity3,
    pub(crate) moved_n: Quantity3,
    /// Interference at which the closed part of the path begins.
    pub(crate) closed_from: Quantity3,
    /// Share of the path that is closed.
    pub(crate) share: Quantity3,
    /// Tangential stiffness at an interference, and its slope.
    pub(crate) k: &'a dyn Fn(Quantity3) -> (Quantity3, Quantity3),
}

impl Described<'_> {
    pub(crate) fn middle(&self) -> Quantity3 {
        (self.u_n + self.closed_from) / Quantity3::from(2.0)
    }
}
