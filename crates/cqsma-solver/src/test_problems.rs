//! Small structures with known answers, shared by tests and benches.

use crate::force::{HystereticForce, Pattern, PointCounts, Sliding};
use faer::Mat;

/// Independent Jenkins elements: a spring of stiffness `k` in series with a slider of limit `f`, one per coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Jenkins {
    elements: Vec<(f64, f64)>,
    pattern: Pattern,
}

impl Jenkins {
    /// One `(stiffness (N/m), slip force (N))` per leading coordinate.
    pub fn new(elements: Vec<(f64, f64)>) -> Self {
        let n = elements.len();
        Self {
            elements,
            pattern: Pattern {
                indptr: (0..=n).collect(),
                indices: (0..n).collect(),
            },
        }
    }
}

impl HystereticForce for Jenkins {
    /// Displacement and force at the last reversal.
    type State = Vec<(f64, f64)>;
    type Workspace = ();

    fn n_dofs(&self) -> usize {
        self.elements.len()
    }

    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn initial_state(&self) -> Self::State {
        vec![(0.0, 0.0); self.elements.len()]
    }

    fn workspace(&self) {}

    fn evaluate(
        &self,
        u: &[f64],
        sliding: Sliding,
        begin: &Self::State,
        end: &mut Self::State,
        (): &mut (),
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> PointCounts {
        let mut counts = PointCounts::default();
        let mut slopes = tangent;
        for (i, &(k, limit)) in self.elements.iter().enumerate() {
            let trial = begin[i].1 + k * (u[i] - begin[i].0);
            let slips = sliding == Sliding::Allowed && trial.abs() > limit;
            force[i] = if slips { limit.copysign(trial) } else { trial };
            end[i] = (u[i], force[i]);
            if let Some(slopes) = &mut slopes {
                slopes[i] = if slips { 0.0 } else { k };
            }
            if slips { counts.slip += 1 } else { counts.stick += 1 }
        }
        counts
    }
}

/// A chain fixed at one end: springs between unit masses, a Jenkins element from each mass to the ground.
pub struct JenkinsChain {
    /// Stiffness of the chain (N/m).
    pub stiffness: Mat<f64>,
    /// Mass (kg).
    pub mass: Mat<f64>,
    /// The sliders.
    pub force: Jenkins,
}

impl JenkinsChain {
    /// `n` masses of 1 kg, springs of `spring` (N/m), sliders `(stiffness, slip force)` on every mass.
    pub fn new(n: usize, spring: f64, slider: (f64, f64)) -> Self {
        let stiffness = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 if i + 1 == n => spring,
            0 => 2.0 * spring,
            1 => -spring,
            _ => 0.0,
        });
        Self {
            stiffness,
            mass: Mat::identity(n, n),
            force: Jenkins::new(vec![slider; n]),
        }
    }
}
