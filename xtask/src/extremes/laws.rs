//! Friction, gaps and surfaces far from the usual.

use super::Case;
use super::bench::Bench;
use super::findings::{Findings, Refusal};
use anyhow::{Context, Result};
use joint_pipeline::progress::Silent;
use joint_pipeline::run::Fields;
use joint_pipeline::scene::{
    Curves, Elastic, Fitted, Gap, LawKind, Method, ParameterSet, Parameters, Per, ScanFile, Scans, Surface, SyntheticScan,
};
use joint_pipeline::surface::{ScannedSurface, synthetic};
use joint_pipeline::{Options, Run, Scene, run};
use std::f64::consts::TAU;
use surface_characterisation::{HeightMap, writers};

pub(super) static CASES: &[Case] = &[
    Case {
        name: "mu-0",
        change: "no friction; also with constant stiffnesses at 10 nm",
        expected: "no tangential traction anywhere, no damping; the mode is that of an interface without tangential stiffness",
        run: frictionless,
    },
    Case {
        name: "mu-1e-12",
        change: "a friction coefficient of 1e-12",
        expected: "the results without friction",
        run: hardly_any_friction,
    },
    Case {
        name: "mu-10",
        change: "a friction coefficient of 10",
        expected: "no slip and the linear frequency at 1e-6 m; no damping there but the remainder of the history rule",
        run: high_friction,
    },
    Case {
        name: "gap-closed-by-approach",
        change: "a uniform gap of 1 mm, which bolts of given tension close without strain",
        expected: "the results without a gap",
        run: closed_gap,
    },
    Case {
        name: "gap-beyond-all-closure",
        change: "an interface so soft that even a closure of 1 m carries nothing of the bolt load",
        expected: "a refusal that gives load, closure and what is carried",
        run: no_contact,
    },
    Case {
        name: "vanishing-contact",
        change: "contact of 100 Pa/m without tangential stiffness under 1 mN per bolt",
        expected: "the unstressed frequencies of the full model, above that of the halves against one another",
        run: vanishing_contact,
    },
    Case {
        name: "one-element-carries-all",
        change: "a gap of 10 mm everywhere but in one element between two bolts",
        expected: "converges; that element carries nearly all of the load",
        run: one_element,
    },
    Case {
        name: "fit-not-monotone-beyond",
        change: "a fit of eq. (28) that falls beyond its range, loaded to three times the range; then without a range",
        expected: "a closure on the continuation of constant log-slope; then a refusal that names the interference",
        run: not_monotone,
    },
    Case {
        name: "surface-30-nm",
        change: "synthetic scans of 30 nm from mean to highest peak, with load and amplitudes scaled alike",
        expected: "frequency and damping of the usual scans: the equations are the same in scaled heights",
        run: |bench| scaled_heights(bench, 30e-9),
    },
    Case {
        name: "surface-300-um",
        change: "synthetic scans of 300 um from mean to highest peak, with load and amplitudes scaled alike",
        expected: "frequency and damping of the usual scans: the equations are the same in scaled heights",
        run: |bench| scaled_heights(bench, 300e-6),
    },
    Case {
        name: "asperities-1-to-5",
        change: "synthetic scans so smooth that an element has few peaks",
        expected: "converges with every law, the simpler form of fits declared; or a refusal that names an element without peaks",
        run: few_asperities,
    },
    Case {
        name: "elements-without-scan",
        change: "scans from files whose data end before the interface does",
        expected: "a refusal that names the element and how many points it has",
        run: missing_data,
    },
];

fn frictionless(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let run = bench.run(|scene| {
        scene.mu = 0.0;
        scene.output.fields_at = Some((1..=scene.cqsma.amplitudes).collect());
    })?;
    findings.sound("", &run);
    let of_loops = run.amplitudes.iter().filter_map(|a| a.fields.as_ref()?.fields.as_ref());
    let all: Vec<&Fields> = std::iter::once(&run.prestress.fields).chain(of_loops).collect();
    let largest = |c: usize| {
        let values = all.iter().flat_map(|fields| &fields.traction[c]);
        values.fold(0.0_f64, |m, t| if t.abs() <= m { m } else { t.abs() })
    };
    findings.within("fields looked at, missing", (run.amplitudes.len() + 1 - all.len()) as f64, 0.0);
    findings.within("tangential traction (Pa)", largest(0).max(largest(1)), 0.0);
    findings.within("damping", damping(&run), 1e-9);

    // Small enough for the contact to stay linear. RQNMA lets the mode's shape change to that of the sliding interface.
    let small = |tangential: f64, mu: f64| {
        bench.run(|scene| {
            scene.surface = bench.elastic(tangential, &|_| 0.0);
            scene.mu = mu;
            (scene.cqsma.amplitude_from, scene.cqsma.amplitude_to) = (1e-8, 1e-8);
            scene.cqsma.amplitudes = 1;
            scene.methods = vec![Method::Rqnma];
        })
    };
    let (sliding, free) = (small(0.5, 0.0)?, small(0.0, 0.2)?);
    let points = sliding.methods[0].points.first().context("no amplitude")?;
    let omega = points.result.as_ref().map_or(f64::NAN, |values| values.omega);
    findings.count(&sliding);
    findings.count(&free);
    findings.equal("frequency by RQNMA (Hz)", omega / TAU, free.frequencies[0], 1e-5);
    // A load of fixed shape is a constraint.
    let loops = sliding.amplitudes[0].point.result.as_ref().map_or(f64::NAN, |r| r.omega / TAU);
    findings.between("frequency by CQSMA (Hz)", loops, free.frequencies[0], sliding.frequencies[0]);
    findings.outcome = format!(
        "converged, no damping, {:.3} Hz without tangential stiffness, {:.3} Hz stuck",
        free.frequencies[0], sliding.frequencies[0]
    );
    Ok(findings)
}

/// Largest damping of all amplitudes.
fn damping(run: &Run) -> f64 {
    let results = run.amplitudes.iter().map(|a| a.point.result.as_ref().map_or(f64::NAN, |r| r.zeta.abs()));
    results.fold(0.0, |m, zeta| if zeta <= m { m } else { zeta })
}

fn hardly_any_friction(bench: &Bench) -> Result<Findings> {
    let (some, none) = (bench.run(|scene| scene.mu = 1e-12)?, bench.run(|scene| scene.mu = 0.0)?);
    let mut findings = Findings::default();
    findings.sound("", &some);
    findings.alike("", &some, &none, [1.0; 2], 1e-6);
    findings.within("damping", damping(&some), 1e-9);
    findings.outcome = format!("converged, damping {:.1e}", damping(&some));
    Ok(findings)
}

fn high_friction(bench: &Bench) -> Result<Findings> {
    let run = bench.run(|scene| scene.mu = 10.0)?;
    let mut findings = Findings::default();
    findings.sound("", &run);
    let first = run.amplitudes.first().context("no amplitude")?;
    let fields = first.fields.as_ref().context("the first amplitude did not converge")?;
    let (omega, zeta) = first.point.result.as_ref().map_or((f64::NAN, f64::NAN), |r| (r.omega, r.zeta));
    findings.within("slipping area", fields.slip_fraction, 0.0);
    findings.equal("frequency (Hz)", omega / TAU, run.frequencies[0], 1e-6);
    findings.within("damping", zeta, 1e-6);
    findings.outcome = format!("converged, {:.4} Hz, damping {zeta:.1e} at the first amplitude", omega / TAU);
    Ok(findings)
}

fn closed_gap(bench: &Bench) -> Result<Findings> {
    let with = |gap: f64| bench.run(|scene| scene.surface = bench.elastic(0.5, &|_| gap));
    let (open, closed) = (with(1e-3)?, with(0.0)?);
    let mut findings = Findings::default();
    findings.sound("", &open);
    findings.alike("", &open, &closed, [1.0; 2], 1e-6);
    findings.outcome = format!("converged, {:.4} Hz, {:.4} Hz without a gap", open.frequencies[0], closed.frequencies[0]);
    Ok(findings)
}

/// Constant stiffnesses (Pa/m), the same everywhere.
fn uniform(normal_stiffness: f64) -> Surface {
    Surface::Parameters(Parameters {
        per: Per::Interface,
        sets: vec![ParameterSet {
            curves: Curves::Elastic(Elastic {
                normal_stiffness,
                tangential_stiffness: [0.0; 2],
            }),
            mu: None,
            gap: 0.0,
        }],
    })
}

fn no_contact(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let outcome = bench.run(|scene| scene.surface = uniform(1e-3));
    let refusal = Refusal {
        place: "the bolt load of",
        value: "carries only",
        remedy: "check the gap, the law and the units",
    };
    findings.refused("", outcome, &refusal);
    Ok(findings)
}

fn vanishing_contact(bench: &Bench) -> Result<Findings> {
    let run = bench.run(|scene| {
        scene.surface = uniform(100.0);
        scene.bolts.load = 1e-3;
        scene.cqsma.amplitudes = 0;
        scene.cqsma.modes = 6;
    })?;
    let mut findings = Findings::default();
    findings.sound("", &run);
    // The halves move against one another on the contact alone.
    findings.between("frequency of the approach (Hz)", run.frequencies[0], 0.0, 1.0);
    let known = &run.model.facts.unstressed_frequencies_hz;
    for (k, (f, known)) in run.frequencies[1..].iter().zip(known).enumerate() {
        findings.equal(&format!("unstressed frequency {} (Hz)", k + 1), *f, *known, 1e-4);
    }
    findings.outcome = format!("converged, {:.3e} Hz, then {:.4} Hz", run.frequencies[0], run.frequencies[1]);
    Ok(findings)
}

/// Interface element whose middle is nearest to a point (m).
fn nearest(bench: &Bench, [x, y]: [f64; 2]) -> usize {
    let mesh = &bench.base.mesh;
    let distance = |e: usize| {
        let nodes = mesh.elements[e].nodes();
        let mean = |axis: usize| nodes.iter().map(|&n| mesh.nodes[n as usize][axis]).sum::<f64>() / nodes.len() as f64;
        (mean(0) - x).hypot(mean(1) - y)
    };
    let numbers = 0..mesh.elements.len();
    numbers.min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

fn one_element(bench: &Bench) -> Result<Findings> {
    let holes = brake_reuss_beam::geometry::Geometry::default().hole_positions();
    let one = nearest(bench, [0.5 * (holes[0] + holes[1]), 0.0]);
    let run = bench.run(|scene| scene.surface = bench.elastic(0.5, &|e| if e == one { 0.0 } else { 1e-2 }))?;
    let mut findings = Findings::default();
    findings.sound("", &run);
    let operators = run.interface.operators();
    let carried = |points: std::ops::Range<usize>| {
        points.map(|p| operators.weights[p] * run.prestress.fields.traction[2][p]).sum::<f64>()
    };
    let share = carried(operators.first_point[one]..operators.first_point[one + 1]) / carried(0..operators.n_points());
    findings.between("share of the element", share, 0.9, 1.0);
    findings.outcome = format!("converged, {:.1} % of the load in one element, {:.3} Hz", 100.0 * share, run.frequencies[0]);
    Ok(findings)
}

fn not_monotone(bench: &Bench) -> Result<Findings> {
    let pressure = bench.base.law.mean_pressure;
    // The third term is at its height at 5 um, the end of the range, and falls steeply beyond.
    let (end, slope, height) = (5e-6_f64, 2.0, 3.0);
    let with = |range: Option<[f64; 2]>| {
        bench.run(|scene| {
            scene.surface = Surface::Parameters(Parameters {
                per: Per::Interface,
                sets: vec![ParameterSet {
                    curves: Curves::Fitted(Fitted {
                        normal: [
                            (0.1 * pressure).ln() - slope * (end / 1e-6).ln() - height,
                            slope,
                            height,
                            -(end / 1e-6).ln(),
                            0.5,
                        ],
                        tangential: [[bench.base.law.tangential_stiffness.ln(), 0.5, 1.0, 1.0]; 2],
                        u_ref: 1e-6,
                        t_ref: 1.0,
                        k_ref: 1.0,
                        range,
                    }),
                    mu: None,
                    gap: 0.0,
                }],
            });
        })
    };
    let run = with(Some([0.3e-6, end]))?;
    let mut findings = Findings::default();
    findings.sound("", &run);
    findings.equal("mean closure (m)", run.law.mean_closure, end * 10.0_f64.powf(1.0 / slope), 1e-9);
    let largest = run.prestress.fields.jump[2].iter().copied().fold(0.0, f64::max);
    findings.between("largest interference over the end of the range", largest / end, 3.0, f64::MAX);
    let converged = format!("converged at {:.3} times the range", run.law.mean_closure / end);
    let refusal = Refusal {
        place: "eq. (28)",
        value: "m",
        remedy: "range",
    };
    findings.refused("without a range, ", with(None), &refusal);
    findings.outcome = format!("{converged}; without a range {}", findings.outcome);
    Ok(findings)
}

/// Two faces on a grid that suits the elements of the bench.
fn faces(bench: &Bench) -> SyntheticScan {
    let size = (bench.base.interface.operators().area() / bench.base.mesh.elements.len() as f64).sqrt();
    SyntheticScan {
        seed: 7,
        step: [size / 60.0; 2],
        correlation_length: [size / 25.0; 2],
        bootstrap: 2,
        ..SyntheticScan::default()
    }
}

/// The scene on two faces.
fn on_faces(scene: &mut Scene, scan: SyntheticScan) {
    scene.surface = Surface::SyntheticScan(scan);
    scene.gap = Gap::Scan;
}

fn scaled_heights(bench: &Bench, highest: f64) -> Result<Findings> {
    let usual = faces(bench);
    let scene = bench.changed(|scene| on_faces(scene, usual));
    let found = ScannedSurface::try_new(&scene, &bench.base.mesh)?.found;
    let peaks = found.elements.iter().flat_map(|e| e.faces.iter().map(|f| f.tallest));
    let factor = highest / peaks.fold(0.0, f64::max);
    let mut findings = Findings::default();
    let mut outcome = Vec::new();
    for (kind, tolerance) in [(LawKind::AsperitySum, 1e-6), (LawKind::Tabulated, 2e-3), (LawKind::Fitted, 0.1)] {
        let with = |factor: f64| {
            bench.run(|scene| {
                scene.law.kind = kind;
                let scaled = SyntheticScan {
                    rms: usual.rms * factor,
                    waviness: usual.waviness * factor,
                    height_step: usual.height_step * factor,
                    tilt: usual.tilt.map(|t| t * factor),
                    ..usual
                };
                on_faces(scene, scaled);
                scene.bolts.load *= factor;
                scene.cqsma.amplitude_from *= factor;
                scene.cqsma.amplitude_to *= factor;
            })
        };
        let (scaled, usual) = (with(factor)?, with(1.0)?);
        let name = scaled.law.kind;
        findings.sound(&format!("{name}, "), &scaled);
        findings.alike(&format!("{name}, "), &scaled, &usual, [1.0, factor], tolerance);
        outcome.push(format!("{:.3} Hz for {:.3} Hz ({name})", scaled.frequencies[0], usual.frequencies[0]));
    }
    findings.outcome = format!("converged, {}", outcome.join(", "));
    Ok(findings)
}

fn few_asperities(bench: &Bench) -> Result<Findings> {
    let usual = faces(bench);
    let mut findings = Findings::default();
    let smooth = |part: f64| SyntheticScan {
        correlation_length: usual.correlation_length.map(|l| l * part),
        ..usual
    };
    let scene = bench.changed(|scene| on_faces(scene, smooth(6.0)));
    let found = ScannedSurface::try_new(&scene, &bench.base.mesh)?.found;
    let mut counts: Vec<usize> = found.elements.iter().map(|e| e.population.heights().len()).collect();
    counts.sort_unstable();
    for kind in [LawKind::AsperitySum, LawKind::Tabulated, LawKind::Fitted] {
        let run = bench.run(|scene| {
            scene.law.kind = kind;
            on_faces(scene, smooth(6.0));
        })?;
        let report = run.law.asperities.as_ref().context("no asperities")?;
        findings.sound(&format!("{}, ", run.law.kind), &run);
        findings.within("fallbacks not declared", counts.len() as f64 - report.fit_fallbacks as f64, 0.0);
    }
    Ok(findings)
}

fn missing_data(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let scan = faces(bench);
    let mut files = Vec::new();
    for (side, name) in [(0, "top.x3p"), (1, "bottom.x3p")] {
        let map = synthetic(&scan, &bench.base.mesh, side)?;
        let path = bench.folder.join(name);
        let bytes = writers::x3p(&without_end(&map)?)?;
        std::fs::write(&path, bytes).with_context(|| format!("writing {}", path.display()))?;
        files.push(ScanFile {
            path,
            height_step: Some(scan.height_step),
            ..ScanFile::default()
        });
    }
    let (Some(bottom), Some(top)) = (files.pop(), files.pop()) else {
        unreachable!("two files were written");
    };
    let scene = bench.changed(|scene| {
        scene.surface = Surface::Scans(Box::new(Scans::new(top, bottom)));
        scene.gap = Gap::Scan;
    });
    let refusal = Refusal {
        place: "element ",
        value: "points with data",
        remedy: "check pose and mask of the height map",
    };
    findings.refused("", run(&scene, &Options { cache: bench.options().cache }, &Silent), &refusal);
    Ok(findings)
}

/// A map without data over its last tenth.
fn without_end(map: &HeightMap) -> Result<HeightMap> {
    let last = 9 * map.nx() / 10;
    let points = (0..map.ny()).flat_map(|j| (0..map.nx()).map(move |i| (i, j)));
    let height = |(i, j)| map.height(i, j).filter(|_| i < last).unwrap_or(f64::NAN);
    let heights: Vec<f64> = points.map(height).collect();
    Ok(HeightMap::try_new(map.nx(), map.ny(), map.step(), map.origin(), heights)?)
}
