//! The backbone of one mode, with all that is found along it.

use super::amplitude::AmplitudeResult;
use super::comparison::{Backbone, Point};
use super::epmc::EpmcBackbone;
use super::methods::MethodResult;
use super::sensitivities::Sensitivity;
use super::validity::Validity;
use crate::Error;
use scenes::EPMC;
use std::f64::consts::TAU;

/// The backbone of one mode.
#[derive(Clone, Debug)]
pub struct ModeBackbone {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Its damping ratio apart from friction: that of the scene, and that of the structure's dampers in the linearised mode.
    pub background: f64,
    /// Amplitudes in ascending order.
    pub amplitudes: Vec<AmplitudeResult>,
    /// Results of the methods beside CQSMA, in the scene's order.
    pub methods: Vec<MethodResult>,
    /// Free periodic motions, if the scene asks for them.
    pub epmc: Option<EpmcBackbone>,
    /// Derivatives with respect to the parameters of the scene's `sensitivities`, in their order.
    pub sensitivities: Vec<Sensitivity>,
    /// Limits of the model.
    pub validity: Validity,
}

impl ModeBackbone {
    /// All backbones over the acceleration at the response point, by name.
    ///
    /// # Errors
    /// [`Error::Comparison`].
    pub fn over_acceleration(&self) -> Result<Vec<(String, Backbone)>, Error> {
        backbones(&self.amplitudes, &self.methods, self.epmc.as_ref(), self.background)
    }
}

/// One mode, before its validity is judged.
pub(crate) struct ModeAnalysis {
    pub(crate) mode: usize,
    /// As [`ModeBackbone::background`].
    pub(crate) background: f64,
    /// [`Validity::separation_modal_force`].
    pub(crate) separation: Option<f64>,
    /// Relative error of the linearised frequency by the modes that the reduction leaves out.
    pub(crate) truncation: f64,
    pub(crate) amplitudes: Vec<AmplitudeResult>,
    pub(crate) methods: Vec<MethodResult>,
    pub(crate) epmc: Option<EpmcBackbone>,
    pub(crate) sensitivities: Vec<Sensitivity>,
}

impl ModeAnalysis {
    /// As [`ModeBackbone::over_acceleration`].
    pub(crate) fn over_acceleration(&self) -> Result<Vec<(String, Backbone)>, Error> {
        backbones(&self.amplitudes, &self.methods, self.epmc.as_ref(), self.background)
    }
}

/// Backbones over the acceleration at the response point, by name: `cqsma` (secants, amplitudes of the linearised mode), the same loops with
/// the frequency of their first harmonic over the motion as it was, the other methods of the scene, and free motions; without those of
/// which fewer than two amplitudes converged. `background` is the damping ratio apart from friction.
///
/// # Errors
/// [`Error::Comparison`].
fn backbones(
    amplitudes: &[AmplitudeResult],
    methods: &[MethodResult],
    epmc: Option<&EpmcBackbone>,
    background: f64,
) -> Result<Vec<(String, Backbone)>, Error> {
    let point = |displacement: f64, omega: f64, friction: Option<f64>| Point {
        amplitude: displacement * omega * omega,
        frequency_hz: omega / TAU,
        damping_ratio: friction.map(|zeta| zeta + background),
    };
    let converged = || {
        let all = amplitudes.iter();
        all.filter_map(|a| Some((a.point.result.as_ref().ok()?, a)))
    };
    let secant = converged().filter_map(|(r, a)| {
        let zeta = r.is_resolved().then_some(r.zeta);
        Some(point(a.response_displacement?, r.omega, zeta))
    });
    let harmonic = converged().filter_map(|(r, a)| {
        let zeta = r.is_resolved().then_some(r.harmonic_zeta());
        Some(point(a.fields.as_ref()?.response_motion, r.harmonic_omega, zeta))
    });
    let mut all = vec![
        ("cqsma", secant.collect()),
        ("cqsma, first harmonic", harmonic.collect()),
    ];
    for method in methods {
        let found = method.points.iter().filter_map(|p| p.result.as_ref().ok());
        let points = found.map(|v| point(v.response_displacement, v.omega, v.zeta)).collect();
        all.push((method.method.name(), points));
    }
    if let Some(epmc) = epmc {
        let found = epmc.points.iter().zip(&epmc.response_displacement);
        let found = found.filter_map(|(point, displacement)| Some((point.result.as_ref().ok()?, (*displacement)?)));
        // Below it the balance of energies says nothing.
        let resolved =
            |m: &harmonic_balance::backbone::Motion| m.zeta.filter(|zeta| *zeta > m.energy_error.max(m.residual));
        let points = found
            .map(|(motion, x)| point(x, motion.omega, resolved(motion)))
            .collect();
        all.push((EPMC, points));
    }
    let several = all.into_iter().filter(|(_, points): &(_, Vec<Point>)| points.len() > 1);
    several
        .map(|(name, points)| Ok((name.to_owned(), Backbone::try_new(name, points)?)))
        .collect()
}
