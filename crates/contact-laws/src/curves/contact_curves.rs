//! Contact curves of one point and of the points of a block.

use crate::error::Error;
use crate::jet::Jet;
use crate::parameters::{Parameter, PointParameters, require_positive};
use crate::simd::Lanes;

/// Log-slopes `d ln f / d ln u_n` of the curves as the interference vanishes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exponents {
    /// Exponent of the normal traction: 3/2 where single Hertz contacts touch first.
    pub normal: f64,
    /// Exponents of the tangential stiffnesses along x and y: 1/2 where single Mindlin contacts touch first.
    pub tangential: [f64; 2],
}

/// Factors between contact curves of the same form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveFactors {
    /// Of interferences.
    pub interference: f64,
    /// Of normal tractions.
    pub normal: f64,
    /// Of tangential stiffnesses along x and y.
    pub tangential: [f64; 2],
}

impl CurveFactors {
    pub(crate) fn validate(&self) -> Result<(), Error> {
        let [x, y] = self.tangential;
        for (name, factor) in [
            ("factor of interferences", self.interference),
            ("factor of normal tractions", self.normal),
            ("factor of tangential stiffnesses along x", x),
            ("factor of tangential stiffnesses along y", y),
        ] {
            require_positive(name, factor, "(no unit)")?;
        }
        Ok(())
    }
}

/// Description of contact curves.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvesInfo {
    /// Name of the law that these curves make together with friction.
    pub name: &'static str,
    /// Where they are described.
    pub reference: &'static str,
    /// Their page in `docs/laws`.
    pub page: &'static str,
    /// Their parameters.
    pub parameters: &'static [Parameter],
}

/// The curves of one point (or of all points of an element): `t_n(u_n)`, `k_x(u_n)`, `k_y(u_n)`.
///
/// `normal` and `tangential` are called with a finite interference `u_n > 0` (m) and must return no NaN there. Values
/// may overflow to infinity: the friction law brings them back into range.
pub trait ContactCurves: Send + Sync {
    /// Description.
    fn info(&self) -> &'static CurvesInfo;

    /// Normal traction (Pa), not negative and not falling, and its derivative (Pa/m).
    fn normal(&self, u_n: f64) -> (f64, f64);

    /// Tangential stiffnesses per area in x and y (Pa/m), not negative, with two derivatives.
    fn tangential(&self, u_n: f64) -> [Jet; 2];

    /// Behaviour towards zero interference, for tables that must end somewhere.
    fn exponents(&self) -> Exponents;

    /// Real contact area per nominal area at any `u_n`, if the curves know it.
    fn contact_area_ratio(&self, _u_n: f64) -> Option<f64> {
        None
    }

    /// Fraction of the loaded asperities whose own interference exceeds `omega_c` (m) at any `u_n`, if the
    /// curves know asperities. Zero when none is loaded.
    fn yielded_fraction(&self, _u_n: f64, _omega_c: f64) -> Option<f64> {
        None
    }
}

/// The curves of all points of a law, evaluated in blocks. Implemented by [`PointParameters`] of any [`ContactCurves`]
/// and by [`crate::FittedPoints`].
pub trait PointCurves: Send + Sync {
    /// Room for intermediate results.
    type Workspace<const B: usize>: Default;

    /// Description; none without points.
    fn info(&self) -> Option<&'static CurvesInfo>;

    /// Number of points.
    fn len(&self) -> usize;

    /// True when there is no point.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Normal tractions at `u_n` and tangential stiffnesses at `middle` (m), each not negative, of the points from
    /// `first` on, as many as `u_n` and `middle` are long and at most a block. What is returned where `u_n`
    /// is not above zero is not used. Second derivatives only if `curvature`.
    fn evaluate<const B: usize>(
        &self,
        first: usize,
        u_n: &[f64],
        middle: &[f64],
        curvature: bool,
        workspace: &mut Self::Workspace<B>,
        out: &mut CurveBlock<B>,
    );

    /// [`ContactCurves::contact_area_ratio`] of `point`.
    fn contact_area_ratio(&self, _point: usize, _u_n: f64) -> Option<f64> {
        None
    }

    /// [`ContactCurves::yielded_fraction`] of `point`.
    fn yielded_fraction(&self, _point: usize, _u_n: f64, _omega_c: f64) -> Option<f64> {
        None
    }
}

/// Values of contact curves at the points of a block: normal traction (Pa) with its slope, tangential stiffnesses
/// (Pa/m) along x and y with two derivatives.
#[derive(Debug)]
pub struct CurveBlock<const B: usize> {
    pub(crate) normal: Lanes<f64, B>,
    pub(crate) normal_slope: Lanes<f64, B>,
    pub(crate) tangential: [Lanes<f64, B>; 2],
    pub(crate) tangential_slope: [Lanes<f64, B>; 2],
    pub(crate) tangential_curvature: [Lanes<f64, B>; 2],
}

impl<const B: usize> CurveBlock<B> {
    pub(crate) fn new() -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            normal: zero,
            normal_slope: zero,
            tangential: [zero; 2],
            tangential_slope: [zero; 2],
            tangential_curvature: [zero; 2],
        }
    }
}

impl<C: ContactCurves> PointCurves for PointParameters<C> {
    type Workspace<const B: usize> = ();

    fn info(&self) -> Option<&'static CurvesInfo> {
        (!self.is_empty()).then(|| self.at(0).info())
    }

    fn len(&self) -> usize {
        self.len()
    }

    fn evaluate<const B: usize>(
        &self,
        first: usize,
        u_n: &[f64],
        middle: &[f64],
        _curvature: bool,
        (): &mut (),
        out: &mut CurveBlock<B>,
    ) {
        for i in 0..u_n.len() {
            if u_n[i] > 0.0 {
                let curves = self.at(first + i);
                (out.normal.0[i], out.normal_slope.0[i]) = curves.normal(u_n[i]);
                for (q, k) in curves.tangential(middle[i]).into_iter().enumerate() {
                    out.tangential[q].0[i] = k.value;
                    out.tangential_slope[q].0[i] = k.slope;
                    out.tangential_curvature[q].0[i] = k.curvature;
                }
            }
        }
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        self.at(point).contact_area_ratio(u_n)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        self.at(point).yielded_fraction(u_n, omega_c)
    }
}
