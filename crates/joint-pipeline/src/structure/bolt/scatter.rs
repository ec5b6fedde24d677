//! Scatter of the preload by the method of tightening (VDI 2230-1, table A8).

use crate::Error;

/// A method of tightening with the range of its tightening factor `alpha_A`: the largest over the smallest preload of assembly that is
/// to be expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TighteningMethod {
    /// Its name.
    pub name: &'static str,
    /// Range of `alpha_A` (-), for favourable and for unfavourable conditions.
    pub factor: [f64; 2],
}

const fn method(name: &'static str, factor: [f64; 2]) -> TighteningMethod {
    TighteningMethod { name, factor }
}

/// Guide values of VDI 2230-1:2003 and 2015, table A8.
///
/// | method | alpha_A |
/// |---|---|
/// | elongation measured by ultrasound | 1.1 to 1.2 |
/// | elongation measured mechanically | 1.1 to 1.5 |
/// | yield controlled, by motor or by hand | 1.2 to 1.4 |
/// | angle controlled, by motor or by hand | 1.2 to 1.4 |
/// | hydraulic tensioning | 1.2 to 1.6 |
/// | torque wrench, torque found by tests on the joint | 1.4 to 1.6 |
/// | torque wrench, friction estimated in class B (0.08 to 0.16) | 1.6 to 2.0 |
/// | torque wrench, friction estimated in class A (0.04 to 0.10) | 1.7 to 2.5 |
/// | impact or impulse wrench | 2.5 to 4.0 |
pub const TIGHTENING_METHODS: [TighteningMethod; 9] = [
    method("ultrasonic-elongation", [1.1, 1.2]),
    method("mechanical-elongation", [1.1, 1.5]),
    method("yield-controlled", [1.2, 1.4]),
    method("angle-controlled", [1.2, 1.4]),
    method("hydraulic", [1.2, 1.6]),
    method("torque-wrench-tested", [1.4, 1.6]),
    method("torque-wrench-class-b", [1.6, 2.0]),
    method("torque-wrench-class-a", [1.7, 2.5]),
    method("impact-wrench", [2.5, 4.0]),
];

/// Standard deviations on either side of the mean at which the largest and the smallest preload are taken to lie.
const DEVIATIONS: f64 = 2.0;

/// Standard deviation of a normally distributed preload over its mean (-), for a tightening factor `alpha_A`.
///
/// With the mean in the middle between both, the largest and the smallest preload are `(alpha_A - 1) / (alpha_A + 1)` of it away. The
/// guideline does not say how many bolts lie between them. Here it is 95.4 %, two standard deviations on either side: its values are guides
/// from experience and no bounds, and three would make the same range a scatter smaller by a third.
///
/// # Errors
/// [`Error::Value`] for factors below 1.
pub fn relative_deviation(factor: f64) -> Result<f64, Error> {
    // Also catches NaN.
    if !(factor >= 1.0 && factor.is_finite()) {
        return Err(Error::Value {
            place: "scatter of a preload".into(),
            field: "tightening factor alpha_A",
            value: factor,
            unit: "",
            requirement: "at least 1, the largest over the smallest preload",
        });
    }
    Ok((factor - 1.0) / (factor + 1.0) / DEVIATIONS)
}
