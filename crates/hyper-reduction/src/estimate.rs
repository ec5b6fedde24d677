//! How far a hyper-reduced loop may be from that of the whole joint.

use crate::force::pattern_of;
use crate::joint::HyperReducedJoint;
use crate::training::dissipation;
use contact_laws::Sticking;
use cqsma_solver::LoopResult;
use std::f64::consts::PI;
use zte_assembly::flux::LoopArea;
use zte_assembly::{State, Workspace};

/// Most times that the points are taken around a loop until they take the same energy each time.
const MOST_LAPS: usize = 4;

/// Change of that energy from one lap to the next, relative, that is none.
const SETTLED: f64 = 1e-3;

/// Accuracy of the corrections (relative, energy norm).
const CORRECTION: f64 = 0.1;

/// Safety factors and floors of the estimates, set so that they are rarely below the errors measured on the Brake-Reuss beam.
const FREQUENCY: (f64, f64) = (4.0, 1e-4);
const DAMPING: (f64, f64) = (2.0, 2e-3);

/// What the residual adds to the estimate of the damping.
const OF_RESIDUAL: f64 = 0.1;

/// Estimated errors of a loop, relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Of the frequency.
    pub frequency: f64,
    /// Of the damping ratio; infinite where the whole joint dissipates and the reduced one does not; none where neither does.
    pub damping: Option<f64>,
}

impl ErrorEstimate {
    /// The least errors of frequency and damping ratio that are ever estimated.
    pub const FLOORS: [f64; 2] = [FREQUENCY.1, DAMPING.1];

    /// Whether neither error is beyond what is borne.
    pub fn is_within(&self, frequency: f64, damping: f64) -> bool {
        self.frequency <= frequency && self.damping.is_none_or(|own| own <= damping)
    }
}

/// Takes all points of a joint along a loop of its hyper-reduced twin: increments from the static state at the vertices (m), which begin and end at
/// the positive peak, with modal forces `loads`.
///
/// The residual at the two reversals, in the energy of the stuck structure and relative to the load, is `eta`; a Newton step there moves the
/// modal amplitude by `delta`, relative. The points take the energy `D` along the loop as it is and `D'` along the loop moved by the two steps.
/// Errors are estimated as `4 (|delta| / 2 + eta^2)` of the frequency and `2 max(|D/D_r - 1|, |D'/(D_r (1 + delta)) - 1|) + eta / 10` of the
/// damping ratio, `D_r` being the dissipation of the reduced loop, and floors of 1e-4 and 2e-3.
pub(crate) fn estimate(
    joint: &HyperReducedJoint<'_>,
    result: &LoopResult,
    loads: &[f64],
    coordinates: &[Vec<f64>],
) -> Option<ErrorEstimate> {
    let increments: Vec<Vec<f64>> = coordinates.iter().map(|y| joint.motion(y)).collect();
    let mut lap = Lap::new(joint);
    let peak = loads.iter().fold(0.0_f64, |most, load| most.max(load.abs()));
    let per_damping = 2.0 * PI * peak * result.modal_amplitude;
    let mut taken = lap.run(&increments);
    for _ in 1..MOST_LAPS {
        let next = lap.run(&increments);
        let is_settled =
            (next - taken).abs() <= SETTLED * next.abs() || (next / per_damping).abs() <= result.zeta_floor;
        taken = next;
        if is_settled {
            break;
        }
    }
    let middle = loads.len() / 2;
    let mut steps = Vec::new();
    let mut eta2 = 0.0;
    for (place, at) in [loads.len() - 1, middle].into_iter().enumerate() {
        let residual = lap.residual(&increments[at], &coordinates[at], loads[at], place)?;
        let pattern = pattern_of(joint.interface());
        let solved = joint
            .whole()
            .tangent_response(pattern, &lap.tangent, &residual, CORRECTION);
        let (step, norm) = solved.ok()??;
        eta2 += 0.5 * norm * norm / joint.energy_of_load(peak);
        steps.push(step);
    }
    let (upper, lower) = (&steps[0], &steps[1]);
    let moved: Vec<Vec<f64>> = increments
        .iter()
        .zip(loads)
        .map(|(increment, load)| {
            let part = 0.5 * (1.0 + load / peak);
            let steps = upper.iter().zip(lower).map(|(up, low)| part * up + (1.0 - part) * low);
            increment.iter().zip(steps).map(|(v, step)| v - step).collect()
        })
        .collect();
    let delta = -0.5 * (joint.amplitude(upper) - joint.amplitude(lower)) / result.modal_amplitude;
    let frequency = FREQUENCY.0 * (0.5 * delta.abs() + eta2) + FREQUENCY.1;
    let is_quiet = |taken: f64| (taken / per_damping).abs() <= result.zeta_floor;
    let damping = match (result.is_resolved(), is_quiet(taken)) {
        (false, true) => None,
        (false, false) => Some(f64::INFINITY),
        (true, _) => {
            let corrected = lap.run(&moved) / (result.loop_area * (1.0 + delta));
            let (off, off_corrected) = ((taken / result.loop_area - 1.0).abs(), (corrected - 1.0).abs());
            // The larger one would hide one that is not a number.
            let off = if off > off_corrected { off } else { off_corrected };
            let off = if taken.is_finite() { off } else { f64::NAN };
            Some(DAMPING.0 * off + OF_RESIDUAL * eta2.sqrt() + DAMPING.1)
        }
    };
    // What is not a number is no small error.
    let bounded = |error: f64| if error.is_finite() { error } else { f64::INFINITY };
    Some(ErrorEstimate {
        frequency: bounded(frequency),
        damping: damping.map(bounded),
    })
}

/// All points on their way.
struct Lap<'a> {
    joint: &'a HyperReducedJoint<'a>,
    workspace: Workspace,
    force: Vec<f64>,
    tangent: Vec<f64>,
    /// History that the next vertex starts from.
    begin: State,
    end: State,
    /// That of the vertices at the end of the loop and in the middle.
    before: [State; 2],
}

impl<'a> Lap<'a> {
    fn new(joint: &'a HyperReducedJoint<'a>) -> Self {
        let (interface, state) = (joint.interface(), joint.whole().state());
        Self {
            joint,
            workspace: interface.workspace(),
            force: vec![0.0; interface.n_dofs()],
            tangent: vec![0.0; interface.pattern().indices.len()],
            begin: state.clone(),
            end: state.clone(),
            before: [state.clone(), state.clone()],
        }
    }

    /// Goes along the vertices; gives the energy that the points take (J).
    fn run(&mut self, increments: &[Vec<f64>]) -> f64 {
        let interface = self.joint.interface();
        let mut area = LoopArea::new(interface.operators().n_points());
        for (at, increment) in increments.iter().enumerate() {
            if at == increments.len() / 2 {
                self.before[1].clone_from(&self.begin);
            } else if at + 1 == increments.len() {
                self.before[0].clone_from(&self.begin);
            }
            interface.evaluate(
                &self.joint.jump(increment),
                Sticking::Coulomb,
                &self.begin,
                &mut self.end,
                &mut self.workspace,
                &mut self.force,
                None,
            );
            area.add(&self.workspace);
            std::mem::swap(&mut self.begin, &mut self.end);
        }
        dissipation(interface, area).iter().sum()
    }

    /// Residual force of the whole joint at a reversal of the last lap, and the tangent of the contact there.
    fn residual(&mut self, increment: &[f64], coordinates: &[f64], load: f64, place: usize) -> Option<Vec<f64>> {
        self.joint.interface().evaluate(
            &self.joint.jump(increment),
            Sticking::Coulomb,
            self.before.get(place)?,
            &mut self.end,
            &mut self.workspace,
            &mut self.force,
            Some(&mut self.tangent),
        );
        Some(self.joint.residual(coordinates, &self.force, load))
    }
}
