//! Small structures with known answers, shared by tests and benches.

use crate::force::{HystereticForce, PatternView};
use crate::sensitivity::{DifferentiableForce, Step};
use contact_laws::{RegimeCounts, Sticking, WayBack};
use faer::Mat;

/// Independent Jenkins elements: a spring of stiffness `k` in series with a slider of limit `f`, one per coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Jenkins {
    elements: Vec<(f64, f64)>,
    /// Row starts of the diagonal tangent; but for the last, its columns too.
    diagonal: Vec<usize>,
}

impl Jenkins {
    /// One `(stiffness (N/m), slip force (N))` per leading coordinate.
    pub fn new(elements: Vec<(f64, f64)>) -> Self {
        let n = elements.len();
        Self {
            elements,
            diagonal: (0..=n).collect(),
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

    fn pattern(&self) -> PatternView<'_> {
        PatternView {
            indptr: &self.diagonal,
            indices: &self.diagonal[..self.elements.len()],
        }
    }

    fn initial_state(&self) -> Self::State {
        vec![(0.0, 0.0); self.elements.len()]
    }

    fn workspace(&self) {}

    fn evaluate(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &Self::State,
        end: &mut Self::State,
        (): &mut (),
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        let mut counts = RegimeCounts::default();
        let mut slopes = tangent;
        for (i, &(k, limit)) in self.elements.iter().enumerate() {
            let trial = begin[i].1 + k * (u[i] - begin[i].0);
            let slips = sticking == Sticking::Coulomb && trial.abs() > limit;
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

impl DifferentiableForce for Jenkins {
    /// Changes of stiffness and slip force of each element.
    type Parameter = Vec<(f64, f64)>;
    /// By stiffness (m) and slip force of each element (-).
    type LocalGradient = Vec<(f64, f64)>;

    fn derivative(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &Self::State,
        d_u: &[f64],
        d_begin: &Self::State,
        parameter: Option<&Self::Parameter>,
        end: &mut Self::State,
        d_end: &mut Self::State,
        workspace: &mut (),
        force: &mut [f64],
        d_force: &mut [f64],
    ) {
        self.evaluate(u, sticking, begin, end, workspace, force, Some(d_force));
        for (i, &(k, _)) in self.elements.iter().enumerate() {
            let (d_k, d_limit) = parameter.map_or((0.0, 0.0), |parameter| parameter[i]);
            let sticks = d_force[i] != 0.0;
            d_force[i] = if sticks {
                d_begin[i].1 + k * (d_u[i] - d_begin[i].0) + d_k * (u[i] - begin[i].0)
            } else {
                d_limit.copysign(d_limit * force[i])
            };
            d_end[i] = (d_u[i], d_force[i]);
        }
    }

    fn initial_change(&self, _: &Self::Parameter) -> Self::State {
        self.no_change()
    }

    fn stuck_tangent(
        &self,
        _: &[f64],
        _: &Self::State,
        parameter: Option<(&Self::Parameter, f64)>,
        (): &mut (),
        tangent: &mut [f64],
    ) {
        for (i, (tangent, &(k, _))) in tangent.iter_mut().zip(&self.elements).enumerate() {
            *tangent = k + parameter.map_or(0.0, |(parameter, step)| step * parameter[i].0);
        }
    }

    fn transposed(
        &self,
        Step { u, begin, .. }: Step<'_, Self>,
        way: WayBack,
        adjoints: &mut [Self::State],
        forces: &[Vec<f64>],
        to_displacements: &mut [Vec<f64>],
        gradients: &mut [Self::LocalGradient],
        before: Option<(Step<'_, Self>, &mut [Vec<f64>])>,
    ) {
        for (goal, adjoint) in adjoints.iter_mut().enumerate() {
            for (i, &(k, limit)) in self.elements.iter().enumerate() {
                let step = u[i] - begin[i].0;
                let trial = begin[i].1 + k * step;
                let sticks = trial.abs() <= limit;
                let after = adjoint[i];
                let end = if way == WayBack::Passed { (0.0, 0.0) } else { after };
                let own = end.1 - forces.get(goal).map_or(0.0, |force| force[i]);
                let of_force = if sticks { own } else { 0.0 };
                to_displacements[goal][i] = end.0 + k * of_force;
                adjoint[i] = match way {
                    WayBack::Committed => (-k * of_force, of_force),
                    WayBack::Passed => (after.0 - k * of_force, after.1 + of_force),
                    WayBack::JumpAlone => after,
                };
                if let Some(gradient) = gradients.get_mut(goal) {
                    let (by_k, by_limit) = &mut gradient[i];
                    match sticks {
                        true => *by_k += own * step,
                        false => *by_limit += own * trial.signum(),
                    }
                }
            }
        }
        if let Some((step, to_displacements)) = before {
            let way = WayBack::JumpAlone;
            self.transposed(step, way, adjoints, &[], to_displacements, &mut [], None);
        }
    }

    fn no_gradient(&self) -> Self::LocalGradient {
        vec![(0.0, 0.0); self.elements.len()]
    }

    fn at_start(&self, _: &Self::State, _: &Self::State, _: &mut Self::LocalGradient) {}

    fn of_parameter(&self, gradient: &Self::LocalGradient, parameter: &Self::Parameter) -> f64 {
        let pairs = gradient.iter().zip(parameter);
        pairs
            .map(|((by_k, by_limit), (d_k, d_limit))| by_k * d_k + by_limit * d_limit)
            .sum()
    }

    fn product(&self, adjoint: &Self::State, change: &Self::State) -> f64 {
        let pairs = adjoint.iter().zip(change);
        pairs.map(|((a, b), (x, y))| a * x + b * y).sum()
    }

    fn no_change(&self) -> Self::State {
        self.initial_state()
    }

    fn add_change(&self, state: &mut Self::State, factor: f64, change: &Self::State) {
        for ((u, f), (d_u, d_f)) in state.iter_mut().zip(change) {
            (*u, *f) = (*u + factor * d_u, *f + factor * d_f);
        }
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

/// A massless elastic bar, bonded along its length to the ground by an elastic layer of limited strength, with a mass
/// at its free end: a shear-layer model of micro-slip in the manner of Menq, Bielak and Griffin (1986, Journal of Sound
/// and Vibration 107, 279-293), with uniform properties. What follows is derived here.
///
/// # The bar
///
/// The coordinate `x >= 0` runs from the pulled end into the bar, `u` is positive along the pull `P`, so that the
/// tension is `N = -EA u'` and `N(0) = P`. The layer resists with `k u` (N/m) up to `f` (N/m), beyond which it slides:
/// `EA u'' = k u` or `f`. The bar is infinitely long. With
///
/// `lambda = sqrt(k / EA)`, `u_y = f / k`, `P_y = f / lambda`, `p = P / P_y`
///
/// the stuck bar is `u = u(0) exp(-lambda x)` with `P = EA lambda u(0)`, thus `u(0) / u_y = p`, and sliding begins at
/// the end when `p = 1`. Beyond, the stuck part begins at `x = s` where `u = u_y` and `N = P_y`; the balance of the
/// sliding part and its elongation give
///
/// `P = P_y + f s`, `u(0) = u_y + (P_y s + f s^2 / 2) / EA`, that is `lambda s = p - 1`, `u(0) / u_y = (1 + p^2) / 2`.
///
/// # The loop
///
/// Every point of the layer is a Jenkins element, and load and displacements grow in one direction at all points at
/// once: Masing's rule holds, unloading and reloading are the loading curve magnified twice, whatever the mean load. A
/// force of amplitude `P` at the end thus dissipates per cycle
///
/// `D = 8 integral P du - 4 P u(0) = (2/3) P_y u_y (p - 1)^2 (p + 2)` for `p > 1`, otherwise 0:
///
/// the square of the excess just after the onset, the cube of the force in the long run.
///
/// # The load of the mode
///
/// The end mass `m` is all the mass there is. So there is one mode, `M phi` is `sqrt(m)` at the pulled end and zero
/// elsewhere, and the modal load is a force `P = sqrt(m) alpha` at that end, exactly; `q = sqrt(m) u(0)`. The secant
/// frequency and damping are `omega^2 = P / (m u(0))` and `zeta = D / (2 pi P u(0))`.
///
/// # The mesh
///
/// Linear elements of length `h` cover the bar up to `x = length`, with the layer lumped at the nodes; the last node
/// carries a spring of `sqrt(EA k + (k h / 2)^2)` for all elements beyond, which must stick: `s < length`. The bar
/// thus answers as the infinite mesh, of any length. When the node at `x = j h` begins to slide, that mesh has
///
/// `p_j = lambda j h + sqrt(1 + (lambda h)^2 / 4)`, `u(0) / u_y = (1 + p_j^2) / 2 - (lambda h)^2 / 8`,
///
/// and it follows the chords between: its displacement lies up to `u_y (lambda h)^2 / 8` below the bar's. At these
/// forces Masing's rule on the chords puts its dissipation `P_y u_y (p - 1) (lambda h)^2 / 6` below, to leading order.
#[derive(Clone, Debug)]
pub struct FrictionalBar {
    /// Stiffness of the bar without its layer (N/m), `(elements + 1)^2`; coordinate 0 is the pulled end.
    pub stiffness: Mat<f64>,
    /// Mass (kg): the end mass, rank 1.
    pub mass: Mat<f64>,
    /// The layer.
    pub force: Jenkins,
    end_mass: f64,
    /// `P_y` (N).
    onset_force: f64,
    /// `u_y` (m).
    onset_displacement: f64,
    /// `1 / lambda` (m).
    decay_length: f64,
}

impl FrictionalBar {
    /// At least one element over `length` (m) of a bar of `axial_stiffness` EA (N) on a `layer` of stiffness (N/m^2)
    /// and limit (N/m), with `end_mass` (kg).
    pub fn new(elements: usize, length: f64, axial_stiffness: f64, layer: (f64, f64), end_mass: f64) -> Self {
        let n = elements + 1;
        let (k, f) = layer;
        let h = length / elements as f64;
        let spring = axial_stiffness / h;
        let beyond = (axial_stiffness * k + (0.5 * k * h).powi(2)).sqrt();
        let stiffness = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 if i == 0 => spring,
            0 if i == elements => spring + beyond,
            0 => 2.0 * spring,
            1 => -spring,
            _ => 0.0,
        });
        // The other half of the last node's share belongs to the elements beyond.
        let share = |i| if i == 0 || i == elements { 0.5 * h } else { h };
        let decay_length = (axial_stiffness / k).sqrt();
        Self {
            stiffness,
            mass: Mat::from_fn(n, n, |i, j| if i == 0 && j == 0 { end_mass } else { 0.0 }),
            force: Jenkins::new((0..n).map(|i| (k * share(i), f * share(i))).collect()),
            end_mass,
            onset_force: f * decay_length,
            onset_displacement: f / k,
            decay_length,
        }
    }

    /// End force that starts to slide, `P_y` (N).
    pub fn onset_force(&self) -> f64 {
        self.onset_force
    }

    /// End displacement that starts to slide, `u_y` (m).
    pub fn onset_displacement(&self) -> f64 {
        self.onset_displacement
    }

    /// Modal force (sqrt(kg) m/s^2) of the end force (N).
    pub fn modal_force(&self, end_force: f64) -> f64 {
        end_force / self.end_mass.sqrt()
    }

    /// Length of the sliding part (m) when the unloaded bar is pulled with `end_force` (N).
    pub fn slip_length(&self, end_force: f64) -> f64 {
        self.decay_length * (end_force / self.onset_force - 1.0).max(0.0)
    }

    /// Displacement of the end (m) when the unloaded bar is pulled with `end_force` (N); half the range of the loop.
    pub fn end_displacement(&self, end_force: f64) -> f64 {
        let p = end_force / self.onset_force;
        self.onset_displacement * if p > 1.0 { 0.5 * (1.0 + p * p) } else { p }
    }

    /// Dissipation per cycle (J) at an end force of amplitude `end_force` (N).
    pub fn dissipation(&self, end_force: f64) -> f64 {
        let excess = (end_force / self.onset_force - 1.0).max(0.0);
        2.0 / 3.0 * self.onset_force * self.onset_displacement * excess * excess * (excess + 3.0)
    }

    /// Secant frequency (rad/s) at an end force of amplitude `end_force` (N).
    pub fn omega(&self, end_force: f64) -> f64 {
        (end_force / (self.end_mass * self.end_displacement(end_force))).sqrt()
    }

    /// Damping ratio at an end force of amplitude `end_force` (N).
    pub fn zeta(&self, end_force: f64) -> f64 {
        self.dissipation(end_force) / (2.0 * std::f64::consts::PI * end_force * self.end_displacement(end_force))
    }
}
