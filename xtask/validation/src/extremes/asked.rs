//! What is asked at its limits: amplitudes, vertices, other analyses, and the law that resolves friction over asperities.

use super::bench::Bench;
use super::case::Case;
use super::findings::{Findings, Refusal, worst};
use analyses::Run;
use analyses::random::RandomVibration;
use anyhow::{Context, Result};
use harmonic_balance::Reason;
use harmonic_balance::stability::is_stable;
use scenes::{
    AmplitudeRange, Amplitudes, Bins, Epmc, Force, Forced, Friction, Length, ModalAmplitude, PointForce, Random, Scene,
};
use std::f64::consts::TAU;

pub(super) static CASES: &[Case] = &[
    Case {
        name: "vertices-1-and-1000",
        change: "1, 100 and 1000 vertices per quarter of a loop",
        expected: "converges; 100 and 1000 agree, and damping with one lies within a factor of two",
        run: vertices,
    },
    Case {
        name: "bolt-load-1-N-to-1-GN",
        change: "bolts of 1 N, 1 kN, 1 MN and 1 GN, without and with friction resolved over asperities",
        expected: "first frequencies that rise with the load, from that without contact to that with a stuck interface; where bins have not \
                   the error asked for, a refusal, and the same with their number given",
        run: bolt_loads,
    },
    Case {
        name: "resolved-mu-1e-9-and-10",
        change: "friction resolved over asperities in 16 bins, with mu = 1e-9 and 10",
        expected: "hardly any damping and free sliding; hardly any damping and no sliding",
        run: resolved_friction,
    },
    Case {
        name: "resolved-1e-15-m-to-1-m",
        change: "friction resolved over asperities, amplitudes from 1e-15 m to 1 m",
        expected: "the linear frequency at first; no convergence only beyond the force at which the bolts hold the halves together",
        run: resolved_amplitudes,
    },
    Case {
        name: "epmc-1e-20-m-to-10-mm",
        change: "free periodic motions from 1e-20 m to 10 mm",
        expected: "the status says where a motion is within round-off; then the linear frequency, a lower one later",
        run: periodic,
    },
    Case {
        name: "epmc-of-asperities",
        change: "free periodic motions with friction resolved over asperities, from 1 nm to 20 um",
        expected: "frequencies and damping beside those of loops: the loops' secants to a thousandth, their damping to a fifth where it is above 1e-5",
        run: periodic_resolved,
    },
    Case {
        name: "forced-1e-9-N-to-1-kN",
        change: "harmonic forces of 1e-9 N and of 1 kN about the first resonance, without and with friction resolved over asperities",
        expected: "a linear resonance of the background damping; far less amplitude per force at 1 kN, or a reason why the curve ends",
        run: forced,
    },
    Case {
        name: "random-1e-12-to-1e9",
        change: "a random force over the first mode, at levels of 1e-12, 1e-9 and 1e9 of 1 N, and stability of responses at 1e-9 N",
        expected: "responses in proportion at the smallest levels; at the largest a reason why the backbone does not reach so far; stable",
        run: random,
    },
];

fn resolve(scene: &mut Scene) {
    scene.interfaces.law.friction = Some(Friction::Resolved);
}

/// Frequency (Hz) and damping ratio of each amplitude that converged.
fn backbone(run: &Run) -> Vec<[f64; 2]> {
    let found = run.amplitudes().iter().filter_map(|a| a.point.result.as_ref().ok());
    found.map(|r| [r.omega / TAU, r.zeta]).collect()
}

fn vertices(bench: &Bench) -> Result<Findings> {
    let with = |vertices: usize| {
        bench.run(|scene| {
            scene.analyses.backbone.vertices_per_quarter = vertices;
            scene.analyses.backbone.amplitudes = 1;
            (
                scene.analyses.backbone.amplitude_from,
                scene.analyses.backbone.amplitude_to,
            ) = (Length::from_si(2e-4), Length::from_si(2e-4));
        })
    };
    let runs = [with(1)?, with(100)?, with(1000)?];
    let mut findings = Findings::default();
    for (run, prefix) in runs.iter().zip(["1, ", "100, ", "1000, "]) {
        findings.sound(prefix, run)?;
    }
    let found = runs.each_ref().map(backbone);
    let [Some(few), Some(many), Some(most)] = found.each_ref().map(|all| all.first().copied()) else {
        findings.that("all converged", false);
        return Ok(findings);
    };
    findings.equal("frequency, 100 against 1000", many[0], most[0], 1e-6);
    findings.equal("damping, 100 against 1000", many[1], most[1], 1e-3);
    findings.between("damping, 1 against 1000", few[1] / most[1], 0.5, 2.0);
    findings.outcome = format!("converged, damping {:.4e}, {:.4e} and {:.4e}", few[1], many[1], most[1]);
    Ok(findings)
}

fn bolt_loads(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let [free, stuck] = bench.bounds();
    let mut told = Vec::new();
    for (law, friction) in [("lumped", Friction::Lumped), ("resolved", Friction::Resolved)] {
        let mut before = free;
        for load in [1.0, 1e3, 1e6, 1e9] {
            let with = |bins: Bins| {
                bench.run(|scene| {
                    scene.interfaces.law.friction = Some(friction);
                    scene.interfaces.law.bins = bins;
                    scene.bolts.load = Force::from_si(load);
                    scene.analyses.backbone.amplitudes = 0;
                })
            };
            let prefix = format!("{law}, {load:e} N, ");
            let run = match with(bench.scene.interfaces.law.bins) {
                // Nearly no asperities touch, or nearly all: no number of bins has the error asked for.
                outcome @ Err(_) if friction == Friction::Resolved && !(1e2..1e5).contains(&load) => {
                    let refusal = Refusal {
                        place: "interfaces.law.bins.error",
                        value: "3e-4",
                        remedy: "give their number",
                    };
                    findings.refused(&prefix, outcome, &refusal);
                    with(Bins::Gauss(64))?
                }
                outcome => outcome?,
            };
            findings.sound(&prefix, &run)?;
            // At most the stuck one, but for the round-off of contact that is far stiffer than the bodies.
            let (found, most) = (run.frequencies[0], stuck * (1.0 + 1e-6));
            findings.between(&format!("{prefix}first frequency (Hz)"), found, before, most);
            before = found;
            told.push(format!("{before:.2}"));
        }
    }
    findings.outcome = format!("converged, {} Hz", told.join(", "));
    Ok(findings)
}

fn resolved_friction(bench: &Bench) -> Result<Findings> {
    let with = |mu: f64| {
        bench.run(|scene| {
            resolve(scene);
            scene.interfaces.mu = mu;
            // Between few bins at the rims of contact the frequency changes by 1.1e-5 over the first loop.
            scene.interfaces.law.bins = Bins::Gauss(16);
        })
    };
    let (little, much) = (with(1e-9)?, with(10.0)?);
    let mut findings = Findings::default();
    findings.sound("1e-9, ", &little)?;
    findings.sound("10, ", &much)?;
    let [slid, stuck] = [&little, &much].map(backbone);
    findings.that("all converged", slid.len() == 3 && stuck.len() == 3);
    findings.within("damping with 1e-9", worst(slid.iter().map(|[_, zeta]| *zeta)), 1e-6);
    // Asperities at the rim of contact slip at any mu; they carry little.
    findings.within(
        "damping with 10",
        stuck.first().map_or(f64::NAN, |[_, zeta]| *zeta),
        1e-5,
    );
    findings.equal("frequency with 10 (Hz)", stuck[0][0], much.frequencies[0], 1e-5);
    findings.that(
        "sliding lowers the frequency",
        slid.iter().all(|[f, _]| *f < stuck[0][0]),
    );
    findings.outcome = format!(
        "converged, {:.3} Hz and damping {:.1e} with 1e-9, {:.3} Hz and {:.1e} with 10",
        slid[0][0], slid[0][1], stuck[0][0], stuck[0][1]
    );
    Ok(findings)
}

fn resolved_amplitudes(bench: &Bench) -> Result<Findings> {
    let run = bench.run(|scene| {
        resolve(scene);
        scene.analyses.backbone.amplitude_from = Length::from_si(1e-15);
        scene.analyses.backbone.amplitude_to = Length::from_si(1.0);
        scene.analyses.backbone.amplitudes = 6;
    })?;
    let mut findings = Findings::default();
    findings.sound_within("", &run, 1e-2)?;
    let first = run.amplitudes().first().context("no amplitude")?;
    match &first.point.result {
        Ok(found) => findings.equal("frequency at 1e-15 m (Hz)", found.omega / TAU, run.frequencies[0], 1e-3),
        Err(failure) => findings.that(
            "says that it is below round-off",
            failure.reason.to_string().contains("round-off"),
        ),
    }
    let found = backbone(&run);
    findings.outcome = format!("{} of {} converged", found.len(), run.amplitudes().len());
    Ok(findings)
}

fn periodic(bench: &Bench) -> Result<Findings> {
    let scale = bench.base.amplitudes().first().and_then(|first| {
        let found = first.point.result.as_ref().ok()?;
        Some(found.modal_amplitude / first.response_displacement?)
    });
    let scale = scale.context("the scene has no amplitudes")?;
    let run = bench.run(|scene| {
        scene.analyses.backbone.amplitudes = 0;
        scene.analyses.epmc = Some(Epmc {
            modal_amplitudes: Some(Amplitudes::Range(AmplitudeRange {
                from: ModalAmplitude::from_si(1e-20 * scale),
                to: ModalAmplitude::from_si(1e-2 * scale),
                number: 10,
            })),
            ..Epmc::default()
        });
    })?;
    let mut findings = Findings::default();
    findings.sound("", &run)?;
    let points = &run.first().epmc.as_ref().context("no periodic motions")?.points;
    let found: Vec<_> = points.iter().filter_map(|point| point.result.as_ref().ok()).collect();
    findings.that("one result for each amplitude", points.len() == 10);
    let finite = |m: &&_| {
        let m: &harmonic_balance::backbone::Motion = m;
        m.omega.is_finite() && m.zeta.is_none_or(f64::is_finite) && m.residual.is_finite()
    };
    findings.that("all numbers are finite", found.iter().all(finite));
    let tiny = points.first().and_then(|point| point.result.as_ref().err());
    findings.that(
        "the smallest is within round-off",
        tiny.is_some_and(|failure| failure.reason == Reason::BelowRoundOff),
    );
    let others = points.iter().filter_map(|point| point.result.as_ref().err());
    findings.that(
        "no other reason",
        others
            .into_iter()
            .all(|failure| failure.reason == Reason::BelowRoundOff),
    );
    let linear = TAU * run.frequencies[0];
    let first = found.first().context("no motion was found")?;
    findings.equal(
        "frequency of the smallest motion found (rad/s)",
        first.omega,
        linear,
        1e-2,
    );
    let small = found.iter().find(|m| m.modal_amplitude >= 1e-12 * scale);
    findings.equal(
        "frequency at 1e-12 m (rad/s)",
        small.map_or(f64::NAN, |m| m.omega),
        linear,
        1e-6,
    );
    let balance = worst(found.iter().filter_map(|m| Some(m.energy_error / m.zeta?.max(1e-6))));
    findings.within("balance of energy over the damping", balance, 1e-2);
    findings.outcome = format!(
        "{} of 10 converged, from {:.3} Hz to {:.3} Hz",
        found.len(),
        first.omega / TAU,
        found.last().map_or(f64::NAN, |m| m.omega / TAU)
    );
    Ok(findings)
}

fn periodic_resolved(bench: &Bench) -> Result<Findings> {
    let run = bench.run(|scene| {
        resolve(scene);
        scene.analyses.backbone.amplitude_from = Length::from_si(1e-9);
        scene.analyses.backbone.amplitude_to = Length::from_si(2e-5);
        scene.analyses.backbone.amplitudes = 5;
        scene.analyses.epmc = Some(Epmc::default());
    })?;
    let mut findings = Findings::default();
    findings.sound("", &run)?;
    let epmc = run.first().epmc.as_ref().context("no periodic motions")?;
    findings.that(
        "one result for each amplitude",
        epmc.points.len() == run.amplitudes().len(),
    );
    let mut told = Vec::new();
    for (loops, motion) in run.amplitudes().iter().zip(&epmc.points) {
        let name = format!("{:.0e} m, ", loops.response_displacement.unwrap_or(f64::NAN));
        let (Ok(loops), Ok(motion)) = (&loops.point.result, &motion.result) else {
            findings.that(&format!("{name}converged"), false);
            continue;
        };
        findings.equal(&format!("{name}frequency (rad/s)"), motion.omega, loops.omega, 1e-3);
        let damping = motion.zeta.unwrap_or(0.0);
        if loops.zeta > 1e-5 {
            findings.equal(&format!("{name}damping"), damping, loops.zeta, 0.2);
        }
        told.push(format!("{damping:.1e} ({:.1e})", loops.zeta));
    }
    findings.outcome = format!("damping (that of loops) {}", told.join(", "));
    Ok(findings)
}

fn random(bench: &Bench) -> Result<Findings> {
    let background = 1e-3;
    let mut findings = Findings::default();
    let rest = bench.run(|scene| scene.analyses.backbone.amplitudes = 0)?;
    let first = rest.frequencies[0];
    let run = bench.run(|scene| {
        scene.background_damping = background;
        scene.analyses.random = Some(Random {
            base: None,
            force: Some(PointForce::default()),
            psd: [0.5, 1.5].map(|of| (of * first, 1.0 / first)).into(),
            levels: vec![1e-12, 1e-9, 1e9],
            in_time: None,
        });
        let levels = vec![Force::from_si(1e-9)];
        let mut forced = Forced::new(levels, 0.98 * first, 1.02 * first);
        forced.stability = true;
        scene.analyses.forced = Some(forced);
    })?;
    let found = match &run.vibration.random {
        Some(Ok(found)) => found.as_slice(),
        _ => &[],
    };
    let [least, small, large] = found else {
        findings.that("three levels", false);
        return Ok(findings);
    };
    let rms = |of: &RandomVibration| of.squares.displacement.sqrt();
    findings.equal(
        "response at 1e-9 over that at 1e-12",
        rms(small) / rms(least),
        1e3,
        1e-9,
    );
    let is_finite = rms(large).is_finite() && !large.validity.reasons.is_empty();
    findings.that(
        "the largest level has a finite response and reasons to doubt it",
        is_finite,
    );
    let motions = run.vibration.forced.iter().flatten().flat_map(|level| &level.points);
    let judged: Vec<Option<bool>> = motions
        .map(|point| {
            point
                .exponents
                .as_ref()?
                .as_ref()
                .ok()
                .and_then(|found| is_stable(found))
        })
        .collect();
    let are_stable = !judged.is_empty() && judged.iter().all(|stable| *stable == Some(true));
    findings.that("all motions at 1e-9 N are stable", are_stable);
    findings.outcome = format!("{:.3e} m/N, {} stable motions", rms(least) / 1e-12, judged.len());
    Ok(findings)
}

fn forced(bench: &Bench) -> Result<Findings> {
    let background = 1e-3;
    let mut findings = Findings::default();
    let mut told = Vec::new();
    for (law, friction) in [("lumped", Friction::Lumped), ("resolved", Friction::Resolved)] {
        let rest = bench.run(|scene| {
            scene.interfaces.law.friction = Some(friction);
            scene.analyses.backbone.amplitudes = 0;
        })?;
        let first = rest.frequencies[0];
        let run = bench.run(|scene| {
            scene.interfaces.law.friction = Some(friction);
            scene.background_damping = background;
            scene.analyses.backbone.amplitudes = 0;
            let levels = [1e-9, 1e3].map(Force::from_si).into();
            scene.analyses.forced = Some(Forced::new(levels, 0.98 * first, 1.02 * first));
        })?;
        findings.sound(&format!("{law}, "), &run)?;
        let [small, large] = run.vibration.forced.as_deref().unwrap_or_default() else {
            findings.that("two responses", false);
            return Ok(findings);
        };
        let peak = small.peak().context("no response to the smallest force")?;
        findings.equal(
            &format!("{law}, resonance at 1e-9 N (Hz)"),
            peak.frequency_hz,
            first,
            1e-4,
        );
        let per_force =
            |of: &analyses::forced::ForcedResponse| of.peak().map_or(f64::NAN, |p| p.harmonics[0] / of.level);
        let finite = [small, large]
            .iter()
            .flat_map(|of| &of.points)
            .all(|p| p.harmonics[0].is_finite());
        findings.that(&format!("{law}, all numbers are finite"), finite);
        findings.that(
            &format!("{law}, 1 kN has less amplitude per force, or says why it ends"),
            per_force(large) < per_force(small) || large.failure.is_some(),
        );
        let end = large
            .failure
            .as_ref()
            .map_or_else(String::new, |failure| format!(", ends: {}", failure.reason));
        told.push(format!(
            "{law} {:.3e} m/N at 1e-9 N, {:.3e} m/N at 1 kN{end}",
            per_force(small),
            per_force(large)
        ));
    }
    findings.outcome = told.join("; ");
    Ok(findings)
}
