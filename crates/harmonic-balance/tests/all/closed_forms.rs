//! Free periodic motions against closed forms.

use crate::common::{Element, Elements, linearised};
use faer::Mat;
use harmonic_balance::backbone::{Kind, Motion, Point, Settings, follow};
use harmonic_balance::{NewtonSettings, Sampling};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

fn settings(harmonics: usize, samples: usize) -> Settings {
    Settings {
        mode: 0,
        sampling: Sampling {
            harmonics,
            samples,
            periods: 2,
        },
        accuracy: None,
        newton: NewtonSettings {
            tolerance: 1e-11,
            ..NewtonSettings::default()
        },
    }
}

fn motions(
    stiffness: &Mat<f64>,
    mass: &Mat<f64>,
    force: &Elements,
    amplitudes: &[f64],
    settings: &Settings,
) -> Vec<Motion> {
    let line = linearised(stiffness, mass, force, stiffness.nrows());
    let points = follow(&line, force, Kind::Free, amplitudes, settings, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("the settings are admissible");
    let found = |point: Point| point.result.expect("the motion converges");
    points.into_iter().map(found).collect()
}

/// First harmonic of a Jenkins element of stiffness `k` that slips at `u_y`, over an amplitude: in phase and lagging (N/m).
fn jenkins(k: f64, u_y: f64, amplitude: f64) -> [f64; 2] {
    if amplitude <= u_y {
        return [k, 0.0];
    }
    let theta = (1.0 - 2.0 * u_y / amplitude).acos();
    let in_phase = k / PI * (theta - 0.5 * (2.0 * theta).sin());
    let loss = 4.0 * k * u_y * (amplitude - u_y) / (PI * amplitude * amplitude);
    [in_phase, loss]
}

#[test]
fn one_harmonic_of_a_jenkins_element_is_its_describing_function() {
    let (k, k_t, u_y, m) = (1e4, 4e3, 1e-3, 2.0_f64);
    let (stiffness, mass) = (Mat::full(1, 1, k), Mat::full(1, 1, m));
    let force = Elements::new(vec![Element::Jenkins {
        stiffness: k_t,
        limit: k_t * u_y,
    }]);
    let displacements = [0.5e-3, 0.999e-3, 1.5e-3, 3e-3, 1e-2, 0.1];
    let amplitudes: Vec<f64> = displacements.iter().map(|u| u * m.sqrt()).collect();
    // Sampling the corners of the loop is what limits the agreement: second order in the samples.
    let found = motions(&stiffness, &mass, &force, &amplitudes, &settings(1, 1 << 14));
    for (motion, u) in found.iter().zip(displacements) {
        let [in_phase, loss] = jenkins(k_t, u_y, u);
        let square = (k + in_phase) / m;
        let zeta = 0.5 * loss / (m * square);
        assert!(
            (motion.omega / square.sqrt() - 1.0).abs() < 1e-6,
            "{u}: {}",
            motion.omega
        );
        assert!(
            (motion.zeta.unwrap() - zeta).abs() < 1e-6 * zeta.max(1e-3),
            "{u}: {:?} for {zeta}",
            motion.zeta
        );
        assert!(motion.energy_error < 1e-10 && motion.residual < 1e-9 && motion.drift < 1e-9);
        let energy = 4.0 * k_t * u_y * (u - u_y).max(0.0);
        assert!((motion.dissipation - energy).abs() < 1e-6 * energy.max(1e-9));
    }
}

#[test]
fn harmonics_of_a_duffing_oscillator_converge_to_its_period() {
    let (k, m, cubic) = (1e4, 2.0, 3e9);
    let (stiffness, mass) = (Mat::full(1, 1, k), Mat::full(1, 1, m));
    let force = Elements::new(vec![Element::Cubic { coefficient: cubic }]);
    let found = motions(&stiffness, &mass, &force, &[1e-3, 3e-3, 1e-2], &settings(11, 128));
    for motion in found {
        // From the peak, where the velocity is zero: w t = integral of du / sqrt(2 (E - V)), with u = A sin x.
        let peak: f64 = (0..=11)
            .map(|h| {
                if h == 0 {
                    motion.displacement.column(0)[0]
                } else {
                    motion.displacement.column(2 * h - 1)[0]
                }
            })
            .sum();
        let n = 20_000;
        let integrand = |x: f64| {
            let s = x.sin();
            1.0 / (k / m + 0.5 * cubic / m * peak * peak * (1.0 + s * s)).sqrt()
        };
        let quarter: f64 = (0..n)
            .map(|i| integrand((i as f64 + 0.5) / n as f64 * PI / 2.0))
            .sum::<f64>()
            * PI
            / 2.0
            / n as f64;
        let omega = TAU / (4.0 * quarter);
        assert!(
            (motion.omega / omega - 1.0).abs() < 1e-6,
            "{} for {omega}",
            motion.omega
        );
        assert!(motion.zeta.unwrap().abs() < 1e-9);
    }
}
