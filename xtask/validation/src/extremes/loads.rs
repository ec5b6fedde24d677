//! Bolt loads, modal forces, moduli, masses and units far from the usual.

use super::bench::Bench;
use super::case::Case;
use super::findings::{Findings, Refusal, worst};
use analyses::results::summary::{Status, Summary};
use analyses::{Error, Run, run};
use anyhow::{Context, Result};
use brake_reuss_beam::BrakeReussBenchmark;
use joints::Options;
use joints::progress::Silent;
use joints::structure::export::arrays;
use matrix_files::npz;
use scenes::{
    BenchmarkRef, Coordinates, Force, Length, Matrices, MatrixVector, Model, Scene, StructureSource, Surface, Units,
};
use serde_json::json;
use std::collections::BTreeMap;

pub(super) static CASES: &[Case] = &[
    Case {
        name: "bolt-load-1e-3",
        change: "bolts of a thousandth of the load",
        expected: "converges; a lower first frequency than before, above that without contact",
        run: |bench| bolt_load(bench, 1e-3),
    },
    Case {
        name: "bolt-load-1e3",
        change: "bolts of a thousand times the load",
        expected: "converges; a higher first frequency than before, below that with a stuck interface",
        run: |bench| bolt_load(bench, 1e3),
    },
    Case {
        name: "bolt-load-0",
        change: "bolts without load",
        expected: "a refusal of the value of bolts.load",
        run: no_bolt_load,
    },
    Case {
        name: "one-bolt-loose",
        change: "of three bolts the first, the second or the third carries nothing",
        expected: "converges with the load of two; the pressure is symmetric about the beam's axis, loosening either end nearly the \
                   same; lower first frequencies than with a stuck interface",
        run: one_bolt_loose,
    },
    Case {
        name: "modal-force-1e-9-to-1e7",
        change: "modal forces from 1e-9 to 1e7 sqrt(kg) m/s^2, a response from 1e-15 m to metres",
        expected: "the linear frequency at first, that of an open interface at last; damping below its floor is called so; no \
                   convergence only beyond the force at which the bolts hold the halves together",
        run: all_modal_forces,
    },
    Case {
        name: "modal-force-below-round-off",
        change: "responses from 1e-24 to 1e-12 m",
        expected: "no frequency where round-off of the prestress is a hundredth of the load: the status says so; the linear one above",
        run: tiny_modal_forces,
    },
    Case {
        name: "stiffness-1e6",
        change: "a Young's modulus a million times larger, with the same bolt load, and with one as much larger",
        expected: "frequencies a thousand times as high as with a millionth of the load, or as with the usual load",
        run: |bench| stiffness(bench, 1e6),
    },
    Case {
        name: "stiffness-1e-6",
        change: "a Young's modulus a million times smaller, with the same bolt load, and with one as much smaller",
        expected: "frequencies a thousand times as low as with a million times the load, or as with the usual load",
        run: |bench| stiffness(bench, 1e-6),
    },
    Case {
        name: "mass-1e6",
        change: "a density a million times larger",
        expected: "frequencies a thousand times lower, the same damping and response",
        run: mass,
    },
    Case {
        name: "units-mm-t-s",
        change: "the same scene in millimetres, tonnes and seconds",
        expected: "the same results",
        run: units,
    },
];

fn bolt_load(bench: &Bench, factor: f64) -> Result<Findings> {
    let run = bench.run(|scene| scene.bolts.load = scene.bolts.load * factor)?;
    let mut findings = Findings::default();
    findings.sound("", &run)?;
    let (first, usual) = (run.frequencies[0], bench.base.frequencies[0]);
    let [free, stuck] = bench.bounds();
    let (low, high) = if factor < 1.0 { (free, usual) } else { (usual, stuck) };
    findings.between("first frequency (Hz)", first, low, high);
    findings.outcome = format!("converged, {first:.3} Hz instead of {usual:.3} Hz");
    Ok(findings)
}

fn no_bolt_load(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let refusal = Refusal {
        place: "bolts.load",
        value: "0 N",
        remedy: "must be positive",
    };
    findings.refused("", bench.run(|scene| scene.bolts.load = Force::from_si(0.0)), &refusal);
    Ok(findings)
}

fn one_bolt_loose(bench: &Bench) -> Result<Findings> {
    let path = bench.folder.join("reduced.npz");
    let exported = npz::to_bytes(&arrays(&bench.base.model, &bench.structure()?.joint)?)?;
    std::fs::write(&path, exported).with_context(|| format!("writing {}", path.display()))?;
    let model = Model {
        element_order: None,
        ..crate::paper_scene("")?.model
    };
    let with = |bolts: &[usize]| {
        let scene = bench.changed(|scene| {
            scene.structure = StructureSource::Matrices(Box::new(Matrices {
                path: path.clone(),
                units: Units::SI,
                coordinates: Coordinates::Jump,
                interface: None,
                points: None,
                bolts: Some(bolts.iter().map(|&b| MatrixVector::Number(b)).collect()),
                response: MatrixVector::Number(1),
                zero_energy_modes: None,
                bolt_hole_clearance: None,
            }))
            .into();
            scene.model = model.clone();
            // Matrices have no measured surface of their own.
            scene.interfaces.surface = Surface::Benchmark(BenchmarkRef(&BrakeReussBenchmark));
        });
        run(&scene, &Options::default(), &Silent)
    };
    let mut findings = Findings::default();
    let all = with(&[1, 2, 3])?;
    findings.alike("all three, ", &all, &bench.base, [1.0; 2], 1e-6);
    let [first, second, third] = [with(&[2, 3])?, with(&[1, 3])?, with(&[1, 2])?];
    for (which, run) in [("first", &first), ("second", &second), ("third", &third)] {
        findings.sound(&format!("{which} loose, "), run)?;
        findings.between(
            &format!("{which} loose, first frequency (Hz)"),
            run.frequencies[0],
            bench.bounds()[0],
            bench.bounds()[1],
        );
        findings.within(
            &format!("{which} loose, moment of the pressure about the axis"),
            moment(run),
            1e-6,
        );
    }
    // Half a turn about the axis across the beam exchanges the half-beams, and heads with nuts, which are not alike.
    findings.equal("either end", first.frequencies[0], third.frequencies[0], 0.02);
    findings.outcome = format!(
        "converged, {:.3}, {:.3} and {:.3} Hz instead of {:.3} Hz",
        first.frequencies[0], second.frequencies[0], third.frequencies[0], bench.base.frequencies[0]
    );
    Ok(findings)
}

/// Moment of the contact pressure about the beam's axis over that of its magnitude.
fn moment(run: &Run) -> f64 {
    let (operators, pressure) = (run.interface.operators(), &run.prestress.fields.traction[2]);
    let points = (0..pressure.len()).map(|p| operators.weights[p] * pressure[p] * operators.positions[p][1]);
    let (sum, all) = points.fold((0.0, 0.0), |(sum, all), m| (sum + m, all + m.abs()));
    sum / all
}

/// Modal force per displacement of the response at small amplitudes.
fn force_per_displacement(run: &Run) -> Result<f64> {
    let first = run.amplitudes().first().context("the scene has no amplitudes")?;
    Ok(first.point.modal_force
        / first
            .response_displacement
            .context("the first amplitude did not converge")?)
}

fn all_modal_forces(bench: &Bench) -> Result<Findings> {
    let ratio = force_per_displacement(&bench.base)?;
    let run = bench.run(|scene| {
        scene.analyses.backbone.amplitude_from = Length::from_si(1e-9 / ratio);
        scene.analyses.backbone.amplitude_to = Length::from_si(1e7 / ratio);
        scene.analyses.backbone.amplitudes = if bench.full { 17 } else { 9 };
    })?;
    let summary = Summary::new(&run, BTreeMap::new(), None);
    let mut findings = Findings::default();
    findings.sound_within("", &run, 1e-2)?;
    let linear = run.frequencies[0];
    let (mut stuck, mut silent) = (Vec::new(), 0);
    for (a, b) in run.amplitudes().iter().zip(&summary.backbone) {
        let (Ok(r), Some(f), Some(floor)) = (&a.point.result, b.frequency_hz, b.damping_floor) else {
            silent += usize::from(b.status != Status::NoEquilibrium || b.failure.is_none());
            continue;
        };
        // Below the first slip the frequency is the linear one, but for the residual.
        if a.point.modal_force < 1e-2 {
            stuck.push((f / linear - 1.0) / (1e-6 + r.residual));
        }
        let is_resolved = b.friction_damping_ratio.is_some_and(|zeta| zeta.abs() > floor);
        silent += usize::from(is_resolved != (b.status == Status::Resolved));
    }
    findings.within(
        "frequency of the stuck interface, of what residuals allow",
        worst(stuck),
        1.0,
    );
    findings.within("results without a word on what they are worth", silent as f64, 0.0);
    let mut found = summary.backbone.iter().rev().filter(|b| b.converged);
    let last = found.next().context("nothing converged")?;
    let (frequency, response) = (
        last.frequency_hz.unwrap_or(f64::NAN),
        last.response_displacement.unwrap_or(f64::NAN),
    );
    findings.between("frequency of the open interface (Hz)", frequency, 0.0, linear);
    findings.between("largest response (m)", response, 0.1, f64::MAX);
    findings.within(
        "found at the smallest force",
        summary.backbone[0].residual.unwrap_or(f64::NAN),
        1e-2,
    );
    let failed = summary.backbone.iter().filter(|b| !b.converged).count();
    findings.outcome = format!(
        "{linear:.3} Hz to {frequency:.3} Hz at {response:.2} m; {failed} of {} beyond what the bolts hold together",
        summary.backbone.len()
    );
    Ok(findings)
}

fn tiny_modal_forces(bench: &Bench) -> Result<Findings> {
    let run = bench.run(|scene| {
        scene.analyses.backbone.amplitude_from = Length::from_si(1e-24);
        scene.analyses.backbone.amplitude_to = Length::from_si(1e-12);
        scene.analyses.backbone.amplitudes = 13;
    })?;
    let summary = Summary::new(&run, BTreeMap::new(), None);
    let mut findings = Findings::default();
    findings.count(&run);
    let (mut below, mut told, mut error) = (0, 0, 0.0_f64);
    let mut ordered = true;
    for (a, b) in run.amplitudes().iter().zip(&summary.backbone) {
        match &a.point.result {
            Ok(r) => {
                told += 1;
                error = error
                    .max((r.omega / (std::f64::consts::TAU * run.frequencies[0]) - 1.0).abs() / (1e-6 + r.residual));
                findings.within(&format!("residual at {:.0e}", a.point.modal_force), r.residual, 1e-2);
            }
            Err(_) => {
                below += usize::from(b.status == Status::BelowRoundOff && b.frequency_hz.is_none());
                ordered &= told == 0;
            }
        }
    }
    findings.within(
        "failures of another kind",
        (run.amplitudes().len() - below - told) as f64,
        0.0,
    );
    findings.between("amplitudes below round-off", below as f64, 6.0, 10.0);
    findings.that("none of them above one that is not", ordered);
    findings.within("linear frequency above, of what residuals allow", error, 1.0);
    findings.outcome = format!("{below} of 13 amplitudes are called below round-off");
    Ok(findings)
}

fn stiffness(bench: &Bench, factor: f64) -> Result<Findings> {
    let stiffer = |scene: &mut Scene| {
        let material = scene.model.material.iter_mut();
        material.for_each(|material| material.youngs_modulus = material.youngs_modulus * factor);
    };
    let mut findings = Findings::default();
    // All forces are moduli times lengths squared: only load over modulus matters.
    let both = bench.run(|scene| {
        stiffer(scene);
        scene.bolts.load = scene.bolts.load * factor;
    })?;
    findings.sound("with the load, ", &both)?;
    findings.alike("with the load, ", &both, &bench.base, [factor.sqrt(), 1.0], 1e-6);
    let alone = bench.run(stiffer);
    let equivalent = bench.run(|scene| scene.bolts.load = scene.bolts.load / factor);
    match (alone, equivalent) {
        (Ok(alone), Ok(equivalent)) => {
            // A static load a million times larger leaves so much more round-off.
            findings.sound_within("alone, ", &alone, 1e-7)?;
            findings.alike("alone, ", &alone, &equivalent, [factor.sqrt(), 1.0], 1e-6);
            findings.outcome = format!(
                "converged, {:.4e} Hz, {:.4e} Hz with the load",
                alone.frequencies[0], both.frequencies[0]
            );
        }
        (Err(alone), Err(equivalent)) => {
            // The same reason, at closures that only the gap of the law limits.
            let prestress = |error: &Error| {
                matches!(
                    error,
                    Error::Prestress { .. } | Error::Joint(joints::Error::NoContact { .. })
                )
            };
            findings.that("refused alike", prestress(&alone) && prestress(&equivalent));
            findings.outcome = format!("{:.4e} Hz with the load; alone refused: {alone}", both.frequencies[0]);
        }
        (Err(error), Ok(_)) | (Ok(_), Err(error)) => {
            findings.that("the same with load and modulus exchanged", false);
            findings.outcome = format!("one of two equal scenes was refused: {error}");
        }
    }
    Ok(findings)
}

fn mass(bench: &Bench) -> Result<Findings> {
    let run = bench.run(|scene| {
        let material = scene.model.material.iter_mut();
        material.for_each(|material| material.density = material.density.map(|density| density * 1e6));
    })?;
    let mut findings = Findings::default();
    findings.sound("", &run)?;
    findings.alike("", &run, &bench.base, [1e-3, 1.0], 1e-6);
    findings.outcome = format!(
        "converged, {:.6} Hz instead of {:.3} Hz",
        run.frequencies[0], bench.base.frequencies[0]
    );
    Ok(findings)
}

fn units(bench: &Bench) -> Result<Findings> {
    let si = &bench.scene;
    let (material, c) = (*si.model.material()?, &si.analyses.backbone);
    let mut given = json!({ "length": "m", "mass": "kg", "time": "s" });
    let text = |length: f64, mass: f64, units: &serde_json::Value| {
        let (stress, force) = (mass / length, mass * length);
        json!({
            "units": units,
            "structure": si.structure,
            "model": {
                "element_order": si.model.element_order,
                "refinement": si.model.refinement,
                "material": {
                    "youngs_modulus": material.youngs_modulus.si() / stress,
                    "hardness": material.hardness.map(|hardness| hardness.si() / stress),
                    "density": material.density.map(|density| density.si() / mass * length.powi(3)),
                    "poisson_ratio": material.poisson_ratio,
                },
            },
            "interfaces": {
                "gap": si.interfaces.gap,
                "mu": si.interfaces.mu,
                "points_per_direction": si.interfaces.points_per_direction,
                "law": { "friction": si.interfaces.law.friction },
            },
            "bolts": { "load": si.bolts.load.si() / force },
            "analyses": { "backbone": {
                "amplitude_from": c.amplitude_from.si() / length,
                "amplitude_to": c.amplitude_to.si() / length,
                "amplitudes": c.amplitudes,
                "vertices_per_quarter": c.vertices_per_quarter,
            } },
        })
        .to_string()
    };
    let read = |text: &str| Scene::from_json(text, "the case", &si.name, &[&BrakeReussBenchmark]);
    let same = read(&text(1.0, 1.0, &given))?;
    given["length"] = json!("mm");
    given["mass"] = json!("t");
    let other = read(&text(1e-3, 1e3, &given))?;
    let mut findings = Findings::default();
    findings.that("the scene in SI is that of the bench", same == *si);
    let run = bench.run_scene(&other)?;
    findings.sound("", &run)?;
    findings.alike("", &run, &bench.base, [1.0; 2], 1e-9);
    let iterations = |run: &Run| {
        run.amplitudes()
            .iter()
            .map(|a| a.point.effort.iterations)
            .sum::<usize>()
    };
    findings.within(
        "iterations, difference",
        iterations(&run) as f64 - iterations(&bench.base) as f64,
        3.0,
    );
    findings.outcome = format!("converged, {:.6} Hz", run.frequencies[0]);
    Ok(findings)
}
