//! Friction, gaps and surfaces far from the usual.

use super::bench::Bench;
use super::case::Case;
use super::findings::{Findings, Refusal, worst};

use analyses::Fields;
use anyhow::{Context, Result};
use brake_reuss_beam::BrakeReussBenchmark;
use contact_laws::{AsperityLimit, ElasticPair, YieldCurves};
use joint_model::Benchmark;
use joints::interface::{ScannedSurface, synthetic};
use scenes::{
    Assembly, Bins, ContactStiffness, Curves, Elastic, Fitted, Force, Friction, Gap, LawKind, Length, Method,
    ParameterSet, Parameters, Per, ScanFile, Scans, Scene, Stress, Surface, SyntheticScan, Yield,
};
use std::f64::consts::TAU;
use surface_characterisation::{AsperityCount, HeightMap, writers};

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
        expected: "frequency and response without friction; a damping in proportion to the coefficient",
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
        change: "a uniform gap of 1 mm, which bolts of given tension close without strain; no friction",
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
        change: "contact of 1 kPa/m without tangential stiffness under 10 mN per bolt",
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
        change: "one to five spheres on every element; then synthetic scans with as few peaks in some elements; then none",
        expected: "the closure of so many Hertz contacts; converges with every law, the simpler form of fits declared; then a \
                   refusal that names the element",
        run: few_asperities,
    },
    Case {
        name: "yield-strength",
        change: "friction of single asperities that yield at 1e-2, 1 and 1e3 times the usual strength, hardening hardly or nearly as the \
                 elastic material",
        expected: "at 1e3 the elastic asperities' results; at 1e-2 without hardening a warning that the contact formulas do not reach so far",
        run: yield_strength,
    },
    Case {
        name: "friction-by-strength",
        change: "the shear strength that pressure leaves in the place of a friction coefficient; then first yield under both forces",
        expected: "the linear frequency of Coulomb's limit in both; results with the first, with the second results or statuses",
        run: friction_by_strength,
    },
    Case {
        name: "elements-without-scan",
        change: "scans from files whose data end before the interface does",
        expected: "a refusal that names the element and how many points it has",
        run: missing_data,
    },
];

/// Friction of single asperities that yield.
fn resolved(scene: &mut Scene, strength: f64, tangent_modulus: f64) {
    scene.interfaces.law.friction = Some(Friction::Resolved);
    scene.interfaces.law.bins = Bins::Gauss(8);
    scene.interfaces.law.yielding = Some(Yield {
        strength: Stress::from_si(strength),
        tangent_modulus: Stress::from_si(tangent_modulus),
        curves: YieldCurves::default(),
    });
}

/// Of usual steel (Pa).
const STRENGTH: f64 = 331.7e6;
const TANGENT_MODULUS: f64 = 620e6;

fn yield_strength(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let elastic = bench.run(|scene| {
        resolved(scene, STRENGTH, TANGENT_MODULUS);
        scene.interfaces.law.yielding = None;
    })?;
    findings.sound("elastic: ", &elastic)?;
    let strong = bench.run(|scene| resolved(scene, 1e3 * STRENGTH, TANGENT_MODULUS))?;
    findings.sound("1e3: ", &strong)?;
    findings.alike("1e3: ", &strong, &elastic, [1.0; 2], 1e-9);
    let mut frequencies = vec![elastic.frequencies[0]];
    for (name, hardening) in [("no hardening: ", 0.0), ("nearly elastic: ", 0.99)] {
        let modulus = bench.scene.model.material()?.youngs_modulus.si();
        let run = bench.run(|scene| resolved(scene, STRENGTH, hardening * modulus))?;
        findings.sound(name, &run)?;
        findings.that(
            &format!("{name}contact formulas hold"),
            run.validity().beyond_contact_formulas().is_none(),
        );
        frequencies.push(run.frequencies[0]);
    }
    let soft = bench.run(|scene| {
        resolved(scene, 1e-2 * STRENGTH, 0.0);
        scene.analyses.backbone.amplitudes = 1;
    })?;
    findings.count(&soft);
    findings.that("1e-2: warned", soft.validity().beyond_contact_formulas().is_some());
    frequencies.push(soft.frequencies[0]);
    findings.outcome = format!("f1 elastic, without hardening, nearly elastic, 1e-2: {frequencies:.3?} Hz");
    Ok(findings)
}

fn friction_by_strength(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let with = |limit: AsperityLimit| {
        bench.run(|scene| {
            resolved(scene, STRENGTH, TANGENT_MODULUS);
            scene.interfaces.law.limit = limit;
            // Else the faces slip differently while bolts are tightened.
            scene.bolts.assembly = Assembly::Frictionless;
        })
    };
    let coulomb = with(AsperityLimit::Coulomb)?;
    let shear = with(AsperityLimit::ShearStrength)?;
    let ceb = with(AsperityLimit::Ceb)?;
    findings.sound("coulomb: ", &coulomb)?;
    findings.sound("shear strength: ", &shear)?;
    findings.count(&ceb);
    let [a, b, c] = [&coulomb, &shear, &ceb].map(|run| run.frequencies[0]);
    findings.equal("frequency with the shear strength (Hz)", b, a, 1e-9);
    findings.equal("frequency with CEB (Hz)", c, a, 1e-9);
    let results = ceb
        .amplitudes()
        .iter()
        .filter_map(|amplitude| amplitude.point.result.as_ref().ok());
    let (n, all) = (results.clone().count(), ceb.amplitudes().len());
    let sound = results.filter(|r| r.omega.is_finite() && r.zeta >= -r.zeta_floor);
    findings.within("results with CEB that are none", (n - sound.count()) as f64, 0.0);
    findings.outcome = format!("shear strength converged; {n} of {all} amplitudes with CEB");
    Ok(findings)
}

fn frictionless(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let run = bench.run(|scene| {
        scene.interfaces.mu = 0.0;
        scene.output.fields_at = Some((1..=scene.analyses.backbone.amplitudes).collect());
    })?;
    findings.sound("", &run)?;
    let of_loops = run
        .amplitudes()
        .iter()
        .filter_map(|a| a.fields.as_ref()?.fields.as_ref());
    let all: Vec<&Fields> = std::iter::once(&run.prestress.fields).chain(of_loops).collect();
    let tangential = all.iter().flat_map(|fields| fields.traction[..2].iter().flatten());
    findings.within(
        "fields looked at, missing",
        (run.amplitudes().len() + 1 - all.len()) as f64,
        0.0,
    );
    findings.within("tangential traction (Pa)", worst(tangential.copied()), 0.0);
    let resolved = run
        .amplitudes()
        .iter()
        .filter(|a| a.point.result.as_ref().is_ok_and(|r| r.is_resolved()));
    findings.within(
        "amplitudes with a damping above its floor",
        resolved.count() as f64,
        0.0,
    );

    // Small enough for the contact to stay linear. RQNMA lets the mode's shape change to that of the sliding interface.
    let small = |tangential: f64, mu: f64| {
        bench.run(|scene| {
            scene.interfaces.surface = bench.elastic(tangential, &|_| 0.0);
            scene.interfaces.mu = mu;
            (
                scene.analyses.backbone.amplitude_from,
                scene.analyses.backbone.amplitude_to,
            ) = (Length::from_si(1e-8), Length::from_si(1e-8));
            scene.analyses.backbone.amplitudes = 1;
            scene.analyses.backbone.methods = vec![Method::Rqnma];
        })
    };
    let (sliding, free) = (small(0.5, 0.0)?, small(0.0, 0.2)?);
    let points = sliding.first().methods[0].points.first().context("no amplitude")?;
    let omega = points.result.as_ref().map_or(f64::NAN, |values| values.omega);
    findings.count(&sliding);
    findings.count(&free);
    findings.equal("frequency by RQNMA (Hz)", omega / TAU, free.frequencies[0], 1e-5);
    // A load of fixed shape is a constraint.
    let loops = sliding.amplitudes()[0]
        .point
        .result
        .as_ref()
        .map_or(f64::NAN, |r| r.omega / TAU);
    findings.between(
        "frequency by CQSMA (Hz)",
        loops,
        free.frequencies[0],
        sliding.frequencies[0],
    );
    findings.outcome = format!(
        "converged, no damping, {:.3} Hz without tangential stiffness, {:.3} Hz stuck",
        free.frequencies[0], sliding.frequencies[0]
    );
    Ok(findings)
}

fn hardly_any_friction(bench: &Bench) -> Result<Findings> {
    let (some, none) = (
        bench.run(|scene| scene.interfaces.mu = 1e-12)?,
        bench.run(|scene| scene.interfaces.mu = 0.0)?,
    );
    let more = bench.run(|scene| scene.interfaces.mu = 1e-9)?;
    let mut findings = Findings::default();
    findings.sound("", &some)?;
    let mut errors = [Vec::new(), Vec::new(), Vec::new()];
    for ((a, b), c) in some.amplitudes().iter().zip(none.amplitudes()).zip(more.amplitudes()) {
        let (Ok(r), Ok(s), Ok(t)) = (&a.point.result, &b.point.result, &c.point.result) else {
            errors[0].push(f64::NAN);
            continue;
        };
        errors[0].push(r.omega / s.omega - 1.0);
        errors[1].push(r.modal_amplitude / s.modal_amplitude - 1.0);
        // All points slide all the way, so that the friction force alone counts.
        errors[2].push((r.zeta - 1e-3 * t.zeta) / (r.zeta_floor + 1e-3 * t.zeta_floor));
    }
    let [omega, q, zeta] = errors.map(worst);
    findings.within("frequencies", omega, 1e-6);
    findings.within("response", q, 1e-6);
    findings.within("damping less a thousandth of that with 1e-9, of the floors", zeta, 1.0);
    let first = some.amplitudes().first().and_then(|a| a.point.result.as_ref().ok());
    findings.outcome = format!(
        "converged, damping {:.1e} at the first amplitude",
        first.map_or(f64::NAN, |r| r.zeta)
    );
    Ok(findings)
}

fn high_friction(bench: &Bench) -> Result<Findings> {
    let run = bench.run(|scene| scene.interfaces.mu = 10.0)?;
    let mut findings = Findings::default();
    findings.sound("", &run)?;
    let first = run.amplitudes().first().context("no amplitude")?;
    let fields = first.fields.as_ref().context("the first amplitude did not converge")?;
    let (omega, zeta) = first
        .point
        .result
        .as_ref()
        .map_or((f64::NAN, f64::NAN), |r| (r.omega, r.zeta));
    findings.within("slipping area", fields.slip_fraction, 0.0);
    findings.equal("frequency (Hz)", omega / TAU, run.frequencies[0], 1e-6);
    findings.within("damping", zeta, 1e-6);
    findings.outcome = format!(
        "converged, {:.4} Hz, damping {zeta:.1e} at the first amplitude",
        omega / TAU
    );
    Ok(findings)
}

fn closed_gap(bench: &Bench) -> Result<Findings> {
    let with = |gap: f64| {
        bench.run(|scene| {
            scene.interfaces.surface = bench.elastic(0.5, &|_| gap);
            // The sliding on the way to contact leaves friction behind, and depends on where it begins.
            scene.interfaces.mu = 0.0;
        })
    };
    let (open, closed) = (with(1e-3)?, with(0.0)?);
    let mut findings = Findings::default();
    findings.sound("", &open)?;
    findings.alike("", &open, &closed, [1.0; 2], 1e-6);
    findings.outcome = format!(
        "converged, {:.4} Hz, {:.4} Hz without a gap",
        open.frequencies[0], closed.frequencies[0]
    );
    Ok(findings)
}

/// Constant stiffnesses, the same everywhere.
fn uniform(normal_stiffness: ContactStiffness) -> Surface {
    Surface::Parameters(Parameters {
        per: Per::Interface,
        sets: vec![ParameterSet {
            curves: Curves::Elastic(Elastic {
                normal_stiffness,
                tangential_stiffness: [ContactStiffness::from_si(0.0); 2],
            }),
            mu: None,
            gap: Length::default(),
            preload: Stress::default(),
        }],
    })
}

fn no_contact(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let outcome = bench.run(|scene| scene.interfaces.surface = uniform(ContactStiffness::from_si(1e-3)));
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
        scene.interfaces.surface = uniform(ContactStiffness::from_si(1e3));
        scene.bolts.load = Force::from_si(1e-2);
        scene.analyses.backbone.amplitudes = 0;
        scene.analyses.modes.number = 6;
    })?;
    let mut findings = Findings::default();
    findings.count(&run);
    // Round-off of a closure of 13 mm in a structure 1e9 times as stiff as the contact.
    findings.within("equilibrium", run.prestress.equilibrium_error, 1e-4);
    findings.that(
        "all frequencies are finite",
        run.frequencies.iter().all(|f| f.is_finite()),
    );
    // The halves move against one another on the contact alone.
    findings.between("frequency of the approach (Hz)", run.frequencies[0], 0.0, 1.0);
    let known = &run.model.facts.unstressed_frequencies_hz;
    for (k, (f, known)) in run.frequencies[1..].iter().zip(known).enumerate() {
        findings.equal(&format!("unstressed frequency {} (Hz)", k + 1), *f, *known, 1e-4);
    }
    findings.outcome = format!(
        "converged, {:.3e} Hz, then {:.4} Hz",
        run.frequencies[0], run.frequencies[1]
    );
    Ok(findings)
}

/// Interface element whose middle is nearest to a point (m).
fn nearest(bench: &Bench, [x, y]: [f64; 2]) -> usize {
    let mesh = &bench.base.joint.mesh;
    let distance = |e: usize| {
        let nodes = mesh.elements[e].nodes();
        let mean = |axis: usize| nodes.iter().map(|&n| mesh.nodes[n as usize][axis]).sum::<f64>() / nodes.len() as f64;
        (mean(0) - x).hypot(mean(1) - y)
    };
    let numbers = 0..mesh.elements.len();
    numbers
        .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(0)
}

fn one_element(bench: &Bench) -> Result<Findings> {
    let holes = brake_reuss_beam::geometry::Geometry::default().hole_positions();
    let one = nearest(bench, [0.5 * (holes[0] + holes[1]), 0.0]);
    let run =
        bench.run(|scene| scene.interfaces.surface = bench.elastic(0.5, &|e| if e == one { 0.0 } else { 1e-2 }))?;
    let mut findings = Findings::default();
    findings.sound("", &run)?;
    let operators = run.interface.operators();
    let carried = |points: std::ops::Range<usize>| {
        points
            .map(|p| operators.weights[p] * run.prestress.fields.traction[2][p])
            .sum::<f64>()
    };
    let share = carried(operators.first_point[one]..operators.first_point[one + 1]) / carried(0..operators.n_points());
    findings.between("share of the element", share, 0.9, 1.0);
    findings.outcome = format!(
        "converged, {:.1} % of the load in one element, {:.3} Hz",
        100.0 * share,
        run.frequencies[0]
    );
    Ok(findings)
}

fn not_monotone(bench: &Bench) -> Result<Findings> {
    let pressure = bench.base.law().mean_pressure;
    // The third term is at its height at 5 um, the end of the range, and falls steeply beyond.
    let (end, slope, height) = (5e-6_f64, 2.0, 3.0);
    let with = |range: Option<[Length; 2]>| {
        bench.run(|scene| {
            scene.interfaces.surface = Surface::Parameters(Parameters {
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
                        tangential: [[bench.base.law().tangential_stiffness.ln(), 0.5, 1.0, 1.0]; 2],
                        u_ref: Length::from_si(1e-6),
                        t_ref: Stress::from_si(1.0),
                        k_ref: ContactStiffness::from_si(1.0),
                        range,
                    }),
                    mu: None,
                    gap: Length::default(),
                    preload: Stress::default(),
                }],
            });
        })
    };
    let run = with(Some([0.3e-6, end].map(Length::from_si)))?;
    let mut findings = Findings::default();
    findings.sound("", &run)?;
    findings.equal(
        "mean closure (m)",
        run.law().mean_closure,
        end * 10.0_f64.powf(1.0 / slope),
        1e-9,
    );
    let largest = run.prestress.fields.jump[2].iter().copied().fold(0.0, f64::max);
    findings.between(
        "largest interference over the end of the range",
        largest / end,
        3.0,
        f64::MAX,
    );
    let converged = format!("converged at {:.3} times the range", run.law().mean_closure / end);
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
    let size = (bench.base.interface.operators().area() / bench.base.joint.mesh.elements.len() as f64).sqrt();
    SyntheticScan {
        seed: 7,
        step: [Length::from_si(size / 40.0); 2],
        correlation_length: [Length::from_si(size / 20.0); 2],
        bootstrap: 2,
        ..SyntheticScan::default()
    }
}

/// Files of the two faces after a change of the maps. Asperities are counted as summits: packed ones depend on the shape of
/// their caps.
fn files(
    bench: &Bench,
    scan: &SyntheticScan,
    change: &dyn Fn(&HeightMap) -> Result<HeightMap>,
    height_step: Length,
) -> Result<Scans> {
    let file = |side: u64| -> Result<ScanFile> {
        let map = change(&synthetic(scan, &bench.base.joint.mesh, side, |position| {
            BrakeReussBenchmark.is_void(position)
        })?)?;
        let path = bench.folder.join(format!("face-{side}-{:e}.x3p", height_step.si()));
        std::fs::write(&path, writers::x3p(&map)?).with_context(|| format!("writing {}", path.display()))?;
        Ok(ScanFile {
            path,
            height_step: Some(height_step),
            ..ScanFile::default()
        })
    };
    let mut scans = Scans::new(file(0)?, file(1)?);
    scans.readings.count = AsperityCount::Summits;
    scans.bootstrap = scan.bootstrap;
    Ok(scans)
}

/// A map of other heights at the same points; NaN for no data.
fn mapped(map: &HeightMap, height: impl Fn(usize, f64) -> f64) -> Result<HeightMap> {
    let points = (0..map.ny()).flat_map(|j| (0..map.nx()).map(move |i| (i, j)));
    let heights: Vec<f64> = points
        .map(|(i, j)| map.height(i, j).map_or(f64::NAN, |z| height(i, z)))
        .collect();
    Ok(HeightMap::try_new(
        map.nx(),
        map.ny(),
        map.step(),
        map.origin(),
        heights,
    )?)
}

fn scaled_heights(bench: &Bench, highest: f64) -> Result<Findings> {
    let scan = faces(bench);
    let with = |factor: f64| -> Result<Surface> {
        let scaled = |map: &HeightMap| mapped(map, |_, z| factor * z);
        let files = files(bench, &scan, &scaled, scan.height_step * factor)?;
        Ok(Surface::Scans(Box::new(files)))
    };
    let usual = with(1.0)?;
    let scene = bench.changed(|scene| scene.interfaces.surface = usual.clone());
    let found = ScannedSurface::try_new(&scene, &bench.base.joint.mesh)?.found;
    let peaks = found.elements.iter().flat_map(|e| e.faces.iter().map(|f| f.tallest));
    // Powers of two change no digit of the heights.
    let factor = (highest / peaks.fold(0.0, f64::max)).log2().round().exp2();
    let scaled = with(factor)?;
    let mut findings = Findings::default();
    let mut outcome = Vec::new();
    // Tables cover a fixed range and have an error of their own.
    for (kind, tolerance, amplitudes) in [(LawKind::AsperitySum, 1e-6, 1), (LawKind::Tabulated, 2e-3, 3)] {
        let go = |surface: &Surface, factor: f64| {
            bench.run(|scene| {
                scene.interfaces.surface = surface.clone();
                scene.interfaces.gap = Gap::Scan;
                scene.interfaces.law.kind = kind;
                scene.bolts.load = scene.bolts.load * factor;
                scene.analyses.backbone.amplitudes = amplitudes;
                scene.analyses.backbone.amplitude_from = Length::from_si(1e-5 * factor);
                scene.analyses.backbone.amplitude_to = Length::from_si(1e-4 * factor);
            })
        };
        let (scaled, usual) = (go(&scaled, factor)?, go(&usual, 1.0)?);
        let name = &scaled.law().kind;
        findings.sound(&format!("{name}, "), &scaled)?;
        findings.alike(&format!("{name}, "), &scaled, &usual, [1.0, factor], tolerance);
        let closure = factor * usual.law().mean_closure;
        findings.equal(
            &format!("{name}, closure (m)"),
            scaled.law().mean_closure,
            closure,
            tolerance,
        );
        outcome.push(format!(
            "{:.4} Hz for {:.4} Hz ({name})",
            scaled.frequencies[0], usual.frequencies[0]
        ));
    }
    findings.outcome = format!("converged, heights times {factor}: {}", outcome.join(", "));
    Ok(findings)
}

fn few_asperities(bench: &Bench) -> Result<Findings> {
    let radius = 5e-3_f64;
    let areas = bench.base.joint.mesh.areas();
    let material = bench.scene.model.material()?;
    let pair = ElasticPair {
        youngs_modulus: material.youngs_modulus.si(),
        poisson_ratio: material.poisson_ratio,
    };
    // Force of one asperity at 1 um.
    let force = 4.0 / 3.0 * pair.composite_modulus() * radius.sqrt() * 1e-9;
    let count = |e: usize| (1 + e % 5) as f64;
    let set = |(e, area): (usize, &f64)| {
        let pressure = count(e) * force / area;
        ParameterSet {
            curves: Curves::Fitted(Fitted {
                normal: [pressure.ln(), 1.5, 0.0, 0.0, 1.0],
                // Of the size of the normal stiffness, with its slope.
                tangential: [[(1.2 * pressure / 1e-6).ln(), 2.0, 0.0, 0.25]; 2],
                u_ref: Length::from_si(1e-6),
                t_ref: Stress::from_si(1.0),
                k_ref: ContactStiffness::from_si(1.0),
                range: None,
            }),
            mu: None,
            gap: Length::default(),
            preload: Stress::default(),
        }
    };
    let sets = areas.iter().enumerate().map(set).collect();
    let run = bench.run(|scene| {
        scene.interfaces.surface = Surface::Parameters(Parameters {
            per: Per::Element,
            sets,
        });
    })?;
    let mut findings = Findings::default();
    findings.sound("one to five spheres, ", &run)?;
    let all = (0..areas.len()).map(count).sum::<f64>();
    let load = run.law().mean_pressure * run.interface.operators().area();
    let known = 1e-6 * (load / (all * force)).powf(2.0 / 3.0);
    findings.equal("one to five spheres, closure (m)", run.law().mean_closure, known, 1e-9);

    // Scans as coarse as the smallest element bears, on which heights change slowly.
    let smallest = areas.iter().copied().fold(f64::INFINITY, f64::min);
    let smooth = |part: f64| SyntheticScan {
        step: [Length::from_si((smallest / 30.0).sqrt()); 2],
        correlation_length: [Length::from_si(part * smallest.sqrt()); 2],
        ..faces(bench)
    };
    let on = |scan: SyntheticScan, kind: LawKind| {
        bench.changed(|scene| {
            scene.interfaces.law.kind = kind;
            scene.interfaces.surface = Surface::SyntheticScan(scan);
            scene.interfaces.gap = Gap::Scan;
        })
    };
    // The smoothest of them on which every element has a peak.
    let characterised = |part: f64| ScannedSurface::try_new(&on(smooth(part), LawKind::Fitted), &bench.base.joint.mesh);
    let (mut part, mut next) = (0.5, characterised(0.5));
    let mut found = Err(joints::Error::NoSamples);
    while next.is_ok() {
        found = next;
        part += 0.1;
        next = characterised(part);
    }
    let (rough_enough, found) = (smooth(part - 0.1), found?.found);
    let counts = found.elements.iter().map(|e| e.population.heights().len());
    findings.between(
        "scans, fewest peaks in an element",
        counts.min().unwrap_or(0) as f64,
        1.0,
        5.0,
    );
    let mut frequencies = Vec::new();
    for kind in [LawKind::AsperitySum, LawKind::Tabulated, LawKind::Fitted] {
        let run = bench.run_scene(&on(rough_enough, kind))?;
        let report = run.law().asperities.as_ref().context("no asperities")?;
        let name = &run.law().kind;
        findings.sound(&format!("scans, {name}, "), &run)?;
        let single = found.summary().single_asperity;
        findings.that(
            &format!("scans, {name}, simpler fits declared"),
            single > 0 && report.fit_fallbacks >= single,
        );
        frequencies.push(format!("{:.3} Hz ({name})", run.frequencies[0]));
    }
    let refusal = Refusal {
        place: "element ",
        value: "no peak on either face",
        remedy: "coarsen the interface mesh",
    };
    let smoothest = bench.run_scene(&on(smooth(part), LawKind::Tabulated));
    findings.refused("smoother scans, ", smoothest, &refusal);
    findings.outcome = format!(
        "converged, scans {}; smoother ones {}",
        frequencies.join(", "),
        findings.outcome
    );
    Ok(findings)
}

fn missing_data(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let scan = faces(bench);
    // The last tenth of the interface was not scanned.
    let cut = |map: &HeightMap| {
        let last = 9 * map.nx() / 10;
        mapped(map, |i, z| if i < last { z } else { f64::NAN })
    };
    let scans = files(bench, &scan, &cut, scan.height_step)?;
    let outcome = bench.run(|scene| {
        scene.interfaces.surface = Surface::Scans(Box::new(scans));
        scene.interfaces.gap = Gap::Scan;
    });
    let refusal = Refusal {
        place: "element ",
        value: "points with data",
        remedy: "check pose and mask of the height map",
    };
    findings.refused("", outcome, &refusal);
    Ok(findings)
}
