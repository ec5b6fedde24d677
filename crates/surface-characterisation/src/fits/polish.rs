//! Levenberg-Marquardt with a robust loss and bounded parameters.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use super::samples::Samples;

/// Bounds of a parameter during the polish; infinite for none.
pub(super) type Bounds = [f64; 2];
/// No bounds.
pub(super) const FREE: Bounds = [f64::NEG_INFINITY, f64::INFINITY];
/// Value of a curve at `x` for parameters, and its derivatives by them. Not generic, so that the solver is compiled once.
type Model<'a> = dyn Fn(&[f64], f64, &mut [f64]) -> f64 + 'a;

/// Levenberg-Marquardt from `start` with a pseudo-Huber loss scaled by the start's own residuals.
pub(super) fn polish<const N: usize>(
    samples: &Samples,
    start: [f64; N],
    bounds: &[Bounds; N],
    model: impl Fn(&[f64; N], f64, &mut [f64; N]) -> f64,
) -> [f64; N] {
    let of_slices = |p: &[f64], x: f64, gradient: &mut [f64]| match (p.try_into(), gradient.try_into()) {
        (Ok(p), Ok(gradient)) => model(p, x, gradient),
        _ => f64::NAN,
    };
    let found = minimise(samples, &start, bounds, &of_slices);
    std::array::from_fn(|k| found[k])
}

/// The parameters of least loss, as many as at the start.
fn minimise(samples: &Samples, start: &[f64], bounds: &[Bounds], model: &Model<'_>) -> Vec<f64> {
    let mut unused = vec![0.0; start.len()];
    let residual = |(x, y): (&f64, &f64)| (model(start, *x, &mut unused) - y).abs();
    let mut residuals: Vec<f64> = samples.x.iter().zip(&samples.y).map(residual).collect();
    residuals.sort_by(f64::total_cmp);
    // Twice the robust standard deviation; the floor only guards the division for exact data.
    let scale = (2.0 * 1.4826 * residuals[residuals.len() / 2]).max(1e-9);
    let free = start.iter().zip(bounds).map(|(value, bounds)| unbound(*value, *bounds));
    let problem = RobustCurve {
        samples,
        scale,
        bounds,
        model,
        free: DVector::from_iterator(start.len(), free),
    };
    let solver = LevenbergMarquardt::new().with_tol(1e-13).with_patience(60);
    let mut problem = solver.minimize(problem).0;
    problem.settle();
    problem.bounded()
}

/// The free parameter behind a bounded one: logit between two bounds, logarithm above one.
fn unbound(value: f64, [low, high]: Bounds) -> f64 {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => {
            // Starts on a bound are moved inside, where the map has a slope.
            let s = ((value - low) / (high - low)).clamp(1e-3, 1.0 - 1e-3);
            (s / (1.0 - s)).ln()
        }
        (true, false) => (value - low).ln(),
        _ => value,
    }
}

/// Bounded value and its derivative by the free parameter.
fn bound(free: f64, [low, high]: Bounds) -> (f64, f64) {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => {
            let s = 1.0 / (1.0 + (-free).exp());
            ((low + (high - low) * s).clamp(low, high), (high - low) * s * (1.0 - s))
        }
        (true, false) => (low + free.exp(), free.exp()),
        _ => (free, 1.0),
    }
}

/// Residuals whose squares sum to the pseudo-Huber loss of a curve.
struct RobustCurve<'a> {
    samples: &'a Samples,
    scale: f64,
    bounds: &'a [Bounds],
    model: &'a Model<'a>,
    free: DVector<f64>,
}

impl RobustCurve<'_> {
    fn bounded(&self) -> Vec<f64> {
        let pairs = self.free.iter().zip(self.bounds);
        pairs.map(|(free, bounds)| bound(*free, *bounds).0).collect()
    }

    /// Gauss-Newton steps at the minimum. A sum of squares fixes its minimiser only to the root of the rounding error
    /// (1e-8), so that changing units would show in the fit; the steps go on by their own size, to 1e-13.
    fn settle(&mut self) {
        let mut largest = 1e-4;
        for _ in 0..30 {
            let (Some(residuals), Some(jacobian)) = (self.residuals(), self.jacobian()) else {
                return;
            };
            let qr = jacobian.qr();
            let Some(step) = qr.r().solve_upper_triangular(&(qr.q().transpose() * residuals)) else {
                return;
            };
            let size = step.amax();
            if size.is_nan() || size >= largest {
                return;
            }
            self.free -= step;
            largest = size;
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for RobustCurve<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, free: &DVector<f64>) {
        self.free.copy_from(free);
    }

    fn params(&self) -> DVector<f64> {
        self.free.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let p = self.bounded();
        let mut unused = vec![0.0; p.len()];
        let values = self.samples.x.iter().zip(&self.samples.y).map(|(&x, y)| {
            let r = (self.model)(&p, x, &mut unused) - y;
            // r sqrt(2/(1 + q)), q = sqrt(1 + (r/s)^2): its square is 2 s^2 (q - 1) without cancellation.
            r * (2.0 / (1.0 + (r / self.scale).hypot(1.0))).sqrt()
        });
        Some(DVector::from_iterator(self.samples.x.len(), values))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let p = self.bounded();
        let mut jacobian = DMatrix::zeros(self.samples.x.len(), p.len());
        let mut gradient = vec![0.0; p.len()];
        for (row, (&x, y)) in self.samples.x.iter().zip(&self.samples.y).enumerate() {
            let r = (self.model)(&p, x, &mut gradient) - y;
            let q = (r / self.scale).hypot(1.0);
            let loss_slope = (0.5 * (1.0 + q)).sqrt() / q;
            for k in 0..p.len() {
                jacobian[(row, k)] = loss_slope * gradient[k] * bound(self.free[k], self.bounds[k]).1;
            }
        }
        Some(jacobian)
    }
}
