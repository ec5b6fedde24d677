//! Elastic dry friction: constant normal and tangential stiffnesses with the Coulomb limit (eq. 16), the field's
//! baseline.
//!
//! One spring and one slider per direction of a point, the slider on the [circular cone](crate::friction):
//! <div>
//! $$ t_n = k_n \, \max(u_n, 0), \qquad k_x, k_y = \text{const}, \qquad |\boldsymbol{t}_t| \le \mu t_n . $$
//! </div>
//!
//! At constant interference a cycle between `-u` and `u` along one axis dissipates nothing below the slip limit, and
//! per area, with the displacement `d` at which it slips,
//! <div>
//! $$ D = 4 \mu t_n \, (u - d) \quad (u > d), \qquad d = \frac{\mu t_n}{k_t} . $$
//! </div>
//!
//! # Parameters
//! | parameter | unit | bounds |
//! |---|---|---|
//! | normal stiffness per area `k_n` | Pa/m | above 0 |
//! | tangential stiffnesses per area `k_x`, `k_y` | Pa/m | not negative |
//! | friction coefficient `mu` | 1 | not negative |
//!
//! Source: G. M. Jenkins, *Analysis of the stress-strain relationships in reactor grade graphite*, Br. J. Appl. Phys.
//! 13, 1962; for joints N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear dynamic
//! modeling of bolted joints: formulation, application, and trends in micro-scale interface evolution*, Mech. Syst.
//! Signal Process. 139, 2020, 106615, eq. (16).
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! let curves = PointParameters::uniform(ElasticCurves::try_new(2e12, [1.5e12; 2])?, 1);
//! let law = ElasticDryFriction::try_new(curves, PointParameters::uniform(0.3, 1), HistoryRule::Incremental)?;
//!
//! // Closed by 1 um: t_n = 2 MPa, slip at d = 0.4 um. The area of the loop between -1 um and 1 um, with a commit at
//! // every step.
//! let (mut begin, mut end) = ([0.0, 0.0, 1e-6, 0.0, 0.0], [0.0; 5]);
//! let mut area = 0.0;
//! for (turn, step) in (0..3).flat_map(|turn| (1..=100).map(move |step| (turn, step))) {
//!     let x = f64::from(step) / 100.0;
//!     let u_x = 1e-6 * [x, 1.0 - 2.0 * x, 2.0 * x - 1.0][turn];
//!     let [mut t_x, mut t_y, mut t_n] = [[0.0]; 3];
//!     law.evaluate(
//!         0..1,
//!         Sticking::Coulomb,
//!         Components::new(&[u_x], &[0.0], &[1e-6]),
//!         StateView::new(&begin, 1, 0),
//!         StateViewMut::new(&mut end, 1, 0),
//!         ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
//!         None,
//!         None,
//!     );
//!     if turn > 0 {
//!         area += 0.5 * (t_x[0] + begin[3]) * (u_x - begin[0]);
//!     }
//!     begin = end;
//! }
//! let (limit, d) = (0.3 * 2e6, 0.4e-6);
//! assert!((area / (4.0 * limit * (1e-6 - d)) - 1.0).abs() < 1e-12);
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use crate::curves::{ContactCurves, CurvesInfo, Exponents};
use crate::error::Error;
use crate::jet::Jet;
use crate::law::PAPER_DOI;
use crate::parameters::{Bounds, Parameter};

const K_N: Parameter = Parameter::new("k_n", "Pa/m", Bounds::Positive);
const K_X: Parameter = Parameter::new("k_x", "Pa/m", Bounds::NotNegative);
const K_Y: Parameter = K_X.named("k_y");

pub(super) static INFO: CurvesInfo = CurvesInfo {
    name: "elastic dry friction",
    reference: PAPER_DOI,
    page: "elastic.md",
    parameters: &[K_N, K_X, K_Y],
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
        K_N.check(normal)?;
        K_X.check(tangential[0])?;
        K_Y.check(tangential[1])?;
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
