//! Elements of one degree of freedom that stand for a joint in other programs: what a linear element has at each amplitude, and the
//! four-parameter Iwan and the Bouc-Wen element nearest to all of them.

mod bouc_wen;
mod fit;
mod iwan;
mod level;

pub use bouc_wen::BoucWen;
pub use fit::{Deviation, Fit, POOR, Quality};
pub use iwan::Iwan;
pub use level::{Hysteretic, Level};

use crate::Error;

/// The Iwan element nearest to the levels.
///
/// # Errors
/// [`Error::Equivalent`] for fewer than three levels with a dissipation, and for numbers that are not positive.
pub fn iwan(levels: &[Level]) -> Result<Fit<Iwan>, Error> {
    fit::nearest(levels)
}

/// The Bouc-Wen element nearest to the levels.
///
/// # Errors
/// As [`iwan`].
pub fn bouc_wen(levels: &[Level]) -> Result<Fit<BoucWen>, Error> {
    fit::nearest(levels)
}
