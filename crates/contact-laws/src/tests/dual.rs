//! Numbers that carry derivatives, and how far rounding may have moved them.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Field operations and analytic functions, enough to write a traction law once for values and derivatives.
pub(crate) trait Real:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The number without what it carries.
    fn value(self) -> f64;

    /// `f(self)`, from `f` and as many of its derivatives at `self.value()` as this type carries, and one more.
    fn apply(self, f: &[f64]) -> Self;

    fn exp(self) -> Self {
        self.apply(&[self.value().exp(); 4])
    }

    fn ln(self) -> Self {
        let x = self.value();
        self.apply(&[x.ln(), 1.0 / x, -1.0 / x / x, 2.0 / x / x / x])
    }

    fn pow(self, p: f64) -> Self {
        let x = self.value();
        let [a, b, c] = [p, p * (p - 1.0), p * (p - 1.0) * (p - 2.0)];
        self.apply(&[x.powf(p), a * x.powf(p - 1.0), b * x.powf(p - 2.0), c * x.powf(p - 3.0)])
    }

    fn cos(self) -> Self {
        let (sin, cos) = self.value().sin_cos();
        self.apply(&[cos, -sin, -cos, sin])
    }

    /// `1 - 2/(exp(2x) + 1)`, whose derivatives do not cancel.
    fn tanh(self) -> Self {
        let one = Self::from(1.0);
        one - Self::from(2.0) / ((self * Self::from(2.0)).exp() + one)
    }
}

/// A number with a bound of its rounding error in units of the rounding of one operation (running error analysis,
/// Wilkinson 1963): how much of a result is left after cancellation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rounded {
    pub(super) value: f64,
    pub(super) rounding: f64,
}

/// A number with its derivatives with respect to `N` variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dual<T, const N: usize> {
    pub(super) value: T,
    pub(super) derivatives: [T; N],
}

impl<T: Real, const N: usize> Dual<T, N> {
    /// The variable with the number `i`.
    pub(super) fn variable(value: T, i: usize) -> Self {
        let mut derivatives = [T::from(0.0); N];
        derivatives[i] = T::from(1.0);
        Self { value, derivatives }
    }
}

impl From<f64> for Rounded {
    fn from(value: f64) -> Self {
        Self { value, rounding: 0.0 }
    }
}

impl<T: Real, const N: usize> From<f64> for Dual<T, N> {
    fn from(value: f64) -> Self {
        Self {
            value: T::from(value),
            derivatives: [T::from(0.0); N],
        }
    }
}

impl Real for Rounded {
    fn value(self) -> f64 {
        self.value
    }

    fn apply(self, f: &[f64]) -> Self {
        Self {
            value: f[0],
            rounding: f[1].abs() * self.rounding + f[0].abs(),
        }
    }
}

impl<T: Real, const N: usize> Real for Dual<T, N> {
    fn value(self) -> f64 {
        self.value.value()
    }

    fn apply(self, f: &[f64]) -> Self {
        let slope = self.value.apply(&f[1..]);
        Self {
            value: self.value.apply(f),
            derivatives: self.derivatives.map(|d| d * slope),
        }
    }
}

impl Add for Rounded {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let value = self.value + b.value;
        Self {
            value,
            rounding: self.rounding + b.rounding + value.abs(),
        }
    }
}

#[allow(clippy::suspicious_arithmetic_impl)]
impl Mul for Rounded {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let value = self.value * b.value;
        Self {
            value,
            rounding: self.rounding * b.value.abs() + self.value.abs() * b.rounding + value.abs(),
        }
    }
}

#[allow(clippy::suspicious_arithmetic_impl)]
impl Div for Rounded {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Self {
            value,
            rounding: (self.rounding + value.abs() * b.rounding) / b.value.abs() + value.abs(),
        }
    }
}

impl Neg for Rounded {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            ..self
        }
    }
}

impl Sub for Rounded {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl<T: Real, const N: usize> Add for Dual<T, N> {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self {
            value: self.value + b.value,
            derivatives: std::array::from_fn(|i| self.derivatives[i] + b.derivatives[i]),
        }
    }
}

#[allow(clippy::suspicious_arithmetic_impl)]
impl<T: Real, const N: usize> Mul for Dual<T, N> {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self {
            value: self.value * b.value,
            derivatives: std::array::from_fn(|i| self.derivatives[i] * b.value + self.value * b.derivatives[i]),
        }
    }
}

#[allow(clippy::suspicious_arithmetic_impl)]
impl<T: Real, const N: usize> Div for Dual<T, N> {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Self {
            value,
            derivatives: std::array::from_fn(|i| (self.derivatives[i] - value * b.derivatives[i]) / b.value),
        }
    }
}

impl<T: Real, const N: usize> Neg for Dual<T, N> {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            derivatives: self.derivatives.map(|d| -d),
        }
    }
}

impl<T: Real, const N: usize> Sub for Dual<T, N> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

/// Derivatives written out by hand, first and second.
#[test]
fn derivatives_of_known_functions() {
    type Second = Dual<Dual<Rounded, 1>, 1>;
    let x = 0.7_f64;
    let variable = Second::variable(Dual::variable(Rounded::from(x), 0), 0);
    let (t, s) = (x.tanh(), 1.0 / x.cosh().powi(2));
    let cases: [(Second, [f64; 3]); 6] = [
        (variable.exp(), [x.exp(); 3]),
        (variable.ln(), [x.ln(), 1.0 / x, -1.0 / (x * x)]),
        (variable.pow(1.5), [x.powf(1.5), 1.5 * x.sqrt(), 0.75 / x.sqrt()]),
        (variable.tanh(), [t, s, -2.0 * t * s]),
        (variable.cos(), [x.cos(), -x.sin(), -x.cos()]),
        (
            variable * variable / (variable - Second::from(2.0)),
            [
                x * x / (x - 2.0),
                1.0 - 4.0 / (x - 2.0).powi(2),
                8.0 / (x - 2.0).powi(3),
            ],
        ),
    ];
    for (i, (found, [value, slope, curvature])) in cases.into_iter().enumerate() {
        let pairs = [
            (found.value.value, value),
            (found.derivatives[0].value, slope),
            (found.value.derivatives[0], slope),
            (found.derivatives[0].derivatives[0], curvature),
        ];
        for (found, expected) in pairs {
            let error = (found.value - expected).abs();
            assert!(
                error <= 4.0 * f64::EPSILON * found.rounding,
                "{i}: {found:?} {expected}"
            );
            assert!(found.rounding < 100.0 * expected.abs(), "{i}: {found:?}");
        }
    }
}
