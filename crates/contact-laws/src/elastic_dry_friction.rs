//! Elastic dry friction: constant normal and tangential stiffnesses with the Coulomb limit, the field's baseline.
//! `t_n = k_n u_n`, `k_x` and `k_y` constant.

use crate::curves::{ContactCurves, CurvesInfo, Exponents, Jet};
use crate::error::{Error, Place, require, require_positive};
use crate::friction::{FrictionalLaw, PAPER_DOI};
use crate::law::Quantity;
use crate::parameters::PointParameters;

/// Elastic dry friction.
pub type ElasticDryFriction = FrictionalLaw<PointParameters<ElasticCurves>>;

static INFO: CurvesInfo = CurvesInfo {
    name: "elastic dry friction",
    reference: PAPER_DOI,
    parameters: &[
        Quantity::new("k_n", "Pa/m"),
        Quantity::new("k_x", "Pa/m"),
        Quantity::new("k_y", "Pa/m"),
    ],
};

/// Constant stiffnesses per area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticCurves {
    normal: f64,
    tangential: [f64; 2],
}

impl ElasticCurves {
    /// From the normal stiffness `k_n > 0` and the tangential ones `k_x, k_y >= 0` (Pa/m).
    ///
    /// # Errors
    /// [`Error::Parameter`] with the value.
    pub fn try_new(normal: f64, tangential: [f64; 2]) -> Result<Self, Error> {
        require_positive("k_n", normal, "Pa/m")?;
        for (name, k) in ["k_x", "k_y"].into_iter().zip(tangential) {
            require(
                k.is_finite() && k >= 0.0,
                name,
                k,
                "Pa/m",
                Place::Whole,
                "finite and not negative",
            )?;
        }
        Ok(Self { normal, tangential })
    }
}

impl ContactCurves for ElasticCurves {
    fn info(&self) -> &'static CurvesInfo {
        &INFO
    }

    #[inline]
    fn normal(&self, u_n: f64) -> (f64, f64) {
        (self.normal * u_n, self.normal)
    }

    #[inline]
    fn tangential(&self, _u_n: f64) -> [Jet; 2] {
        self.tangential.map(|value| Jet {
            value,
            slope: 0.0,
            curvature: 0.0,
        })
    }

    fn exponents(&self) -> Exponents {
        Exponents {
            normal: 1.0,
            tangential: [0.0; 2],
        }
    }
}
