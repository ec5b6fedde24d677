//! The elementary functions of `std`, from `libm` where there is no `std`.

/// Methods of `f64` that `core` lacks, under the names that `std` gives them.
pub(crate) trait Float: Sized {
    fn sqrt(self) -> Self;
    fn exp(self) -> Self;
    fn exp_m1(self) -> Self;
    fn ln(self) -> Self;
    fn ln_1p(self) -> Self;
    fn powf(self, exponent: Self) -> Self;
    fn powi(self, exponent: i32) -> Self;
    fn hypot(self, other: Self) -> Self;
    fn atan(self) -> Self;
    fn sin(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
}

impl Float for f64 {
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }

    fn exp(self) -> Self {
        libm::exp(self)
    }

    fn exp_m1(self) -> Self {
        libm::expm1(self)
    }

    fn ln(self) -> Self {
        libm::log(self)
    }

    fn ln_1p(self) -> Self {
        libm::log1p(self)
    }

    fn powf(self, exponent: Self) -> Self {
        libm::pow(self, exponent)
    }

    fn powi(self, exponent: i32) -> Self {
        libm::pow(self, exponent.into())
    }

    fn hypot(self, other: Self) -> Self {
        libm::hypot(self, other)
    }

    fn atan(self) -> Self {
        libm::atan(self)
    }

    fn sin(self) -> Self {
        libm::sin(self)
    }

    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
}
