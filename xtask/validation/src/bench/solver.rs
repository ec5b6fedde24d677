//! The solver at full size: interface, load points, backbone, reduction.

use super::instruments::Instruments;
use analyses::{Prepared, prepare};
use anyhow::{Result, anyhow};
use brake_reuss_beam::mesh::Refinement;
use brake_reuss_beam::{benchmark, published};
use cqsma_solver::cqsma::{Cycles, Settings};
use cqsma_solver::newton::Effort;
use cqsma_solver::{BackbonePoint, HystereticForce};
use cqsma_solver::{LinearSolver, Linearisation, NewtonSettings, NoObserver, Sticking, cqsma, modes, prestress};
use joint_model::benchmark::MeshSettings;
use joints::Options;
use joints::interface::InterfaceForce;
use joints::structure::Structure;
use serde_json::{Value, json};
use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;
use zte_assembly::State;

/// Vertices per quarter of the measured loops: 48 edges, as the method paper walks per amplitude.
const VERTICES: usize = 12;

/// Displacements at the response point of the single loops (m): stuck, first slip at the edges, almost all slipping.
const SINGLE: [(&str, f64); 3] = [("stuck", 1e-6), ("partial_slip", 1e-4), ("gross_slip", 1e-3)];

/// Times repeated operations are timed, the fastest counting.
const ROUNDS: usize = 25;

/// Figures under their names, and a table of them.
type Figures = (Vec<(&'static str, Value)>, String);

pub(super) fn figures(instruments: &Instruments<'_>) -> Result<Figures> {
    let mut scene = crate::paper_scene("bench")?;
    scene.interfaces.points_per_direction = 5;
    let prepared = prepare(&scene, &Options::default(), instruments.progress)?;
    let stages = (instruments.stages)();
    let seconds = |stage: &str| stages.get(stage).copied().unwrap_or_default();
    let reduction = json!({
        "assemble_s": seconds("assemble"),
        "factor_s": seconds("factor"),
        "reduce_s": seconds("reduce"),
        "peak_memory": (instruments.peak_memory)(),
    });
    let memory_is_known = (instruments.forget_peak_memory)();

    let bench = Bench::try_new(&prepared)?;
    let began = Instant::now();
    let line = bench.linearise()?;
    let start_s = began.elapsed().as_secs_f64();
    let began = Instant::now();
    let points = bench.backbone(&line, &amplitudes(20), bench.settings(LinearSolver::Krylov))?;
    let loops_s = began.elapsed().as_secs_f64();
    let stage_memory = memory_is_known.then(instruments.peak_memory).flatten();
    let effort = total(&points)?;
    let per_point = |count: usize| count as f64 / effort.solves as f64;

    let mut single = serde_json::Map::new();
    for (name, x) in SINGLE {
        single.insert(
            name.into(),
            json!(bench.load_point_ms(&line, x, bench.settings(LinearSolver::Krylov))?),
        );
    }
    // A few load points will do: each costs several factorisations.
    let few = |solver| Settings {
        vertices_per_quarter: 1,
        cycles: Cycles::Fixed(1),
        ..bench.settings(solver)
    };
    let (_, slipping) = SINGLE[1];
    let baseline = bench.load_point_ms(&line, slipping, few(LinearSolver::Direct))?;
    let same = bench.load_point_ms(&line, slipping, few(LinearSolver::Krylov))?;

    let matvec = bench.matvec_ms();
    let stuck = bench.stuck_response_ms(&line);
    let [evaluate, with_tangent] = bench.evaluate_ms(&line);
    let wall = 1e3 * loops_s / effort.solves as f64;
    let interface = json!({ "points": bench.n_points(), "evaluate_ms": evaluate, "evaluate_tangent_ms": with_tangent });
    let solver = json!({
        "size": bench.size(),
        "matvec_ms": matvec,
        "stuck_solve_ms": stuck,
        "load_point_ms": wall,
        "load_point_one_thread_ms": single,
        "baseline_load_point_ms": baseline,
        "baseline_ratio": baseline / same,
        "prestress_and_modes_s": start_s,
        "backbone_s": start_s + loops_s,
        "load_points": effort.solves,
        "residuals_per_point": per_point(effort.evaluations),
        "newton_per_point": per_point(effort.iterations),
        "krylov_per_point": per_point(effort.krylov_steps),
        "factorisations": effort.factorisations,
        "peak_memory": stage_memory,
    });
    let megabytes = |bytes: Option<u64>| bytes.map_or_else(|| "-".into(), |b| format!("{:.0} MB", b as f64 / 1e6));
    let mut text = format!(
        "\n{} coordinates, {} points\n  {:34} {evaluate:8.3} ms, with tangent {with_tangent:.3} ms\n",
        bench.size(),
        bench.n_points(),
        "interface",
    );
    text += &format!("  {:34} {matvec:8.3} ms\n", "dense matrix times vector");
    text += &format!("  {:34} {stuck:8.3} ms\n", "stuck structure solved");
    text += &format!(
        "  {:34} {wall:8.3} ms of the backbone, all threads; {:.2} residuals, {:.2} Krylov steps\n",
        "load point",
        per_point(effort.evaluations),
        per_point(effort.krylov_steps)
    );
    for (name, milliseconds) in &single {
        text += &format!(
            "  {:34} {:8.3} ms on one thread\n",
            format!("load point, {name}"),
            number(milliseconds)
        );
    }
    text += &format!(
        "  {:34} {baseline:8.1} ms, {:.1} times as long for the same points\n",
        "load point by factorisations",
        baseline / same
    );
    text += &format!(
        "  {:34} {:8.2} s with prestress and modes ({start_s:.2} s), {} load points, {}\n",
        "backbone of 20 amplitudes",
        start_s + loops_s,
        effort.solves,
        megabytes(stage_memory)
    );
    text += &format!(
        "  {:34} {:8.2} s assembling, {:.2} s first factor, {:.1} s reducing, {}\n",
        "reduction",
        seconds("assemble"),
        seconds("factor"),
        seconds("reduce"),
        megabytes(reduction["peak_memory"].as_u64())
    );
    Ok((
        vec![("interface", interface), ("solver", solver), ("reduction", reduction)],
        text,
    ))
}

/// How the cost of a load point grows.
pub struct Scaling {
    /// Every row, and the exponents.
    pub figures: Value,
    /// The same for the terminal.
    pub table: String,
    /// SVG.
    pub picture: String,
}

pub(super) fn scaling(cache: PathBuf, instruments: &Instruments<'_>) -> Result<Scaling> {
    let mesh = |across, per_block, hole_rings, end| Refinement {
        across,
        per_block,
        hole_rings,
        end,
        ..Refinement::quick()
    };
    // Counts near those of published models.
    let meshes = [
        mesh(4, 1, 1, 2),
        mesh(6, 3, 1, 3),
        mesh(6, 4, 2, 5),
        Refinement::default(),
        Refinement::fine(),
    ];
    let options = Options::cached(cache);
    let mut text = format!(
        "\n{:>9} {:>7} {:>7} {:>6} {:>12} {:>14} {:>14} {:>10} {:>10}\n",
        "elements", "points", "size", "f1", "evaluate ms", "stuck solve ms", "load point ms", "residuals", "Krylov"
    );
    let mut rows = Vec::new();
    let mut measure = |refinement: &Refinement, points_per_direction: usize| -> Result<Row> {
        let mut scene = crate::paper_scene("scaling")?;
        scene.interfaces.points_per_direction = points_per_direction;
        let settings = MeshSettings {
            refinement: scene.model.refinement,
            arm_layers: scene.model.arm_layers,
            symmetry: scene.model.symmetry,
            element_order: scene.element_order(),
            hexahedra: scene.hexahedra(),
            material: published::steel(),
        };
        let joint = benchmark::joint(refinement, &settings)?;
        let structure = Structure::from_joint(&scene.model, scene.bolts.behaviour, joint);
        let prepared = Prepared::try_new(&scene, &structure, &options, instruments.progress)?;
        let bench = Bench::try_new(&prepared)?;
        let line = bench.linearise()?;
        let settings = bench.settings(LinearSolver::Krylov);
        let began = Instant::now();
        let found = bench.backbone(&line, &amplitudes(10), settings)?;
        let effort = total(&found)?;
        let points = effort.solves as f64;
        let row = Row {
            elements: structure.interface().elements.len(),
            points_per_element: points_per_direction * points_per_direction,
            load_point_ms: 1e3 * began.elapsed().as_secs_f64() / points,
        };
        let evaluate_ms = bench.evaluate_ms(&line)[1];
        let stuck_ms = bench.stuck_response_ms(&line);
        let (residuals, krylov) = (effort.evaluations as f64 / points, effort.krylov_steps as f64 / points);
        text += &format!(
            "{:9} {:7} {:7} {:6.2} {evaluate_ms:12.3} {stuck_ms:14.3} {:14.3} {residuals:10.2} {krylov:10.2}\n",
            row.elements,
            bench.n_points(),
            bench.size(),
            line.frequencies()[0],
            row.load_point_ms,
        );
        rows.push(json!({
            "elements": row.elements,
            "points": bench.n_points(),
            "size": bench.size(),
            "frequency_hz": line.frequencies()[0],
            "evaluate_tangent_ms": evaluate_ms,
            "stuck_solve_ms": stuck_ms,
            "load_point_ms": row.load_point_ms,
            "residuals_per_point": residuals,
            "krylov_per_point": krylov,
        }));
        Ok(row)
    };
    let by_elements = meshes.iter().map(|m| measure(m, 2)).collect::<Result<Vec<_>>>()?;
    let by_points = [1, 2, 3, 4, 5]
        .iter()
        .map(|&n| measure(&Refinement::default(), n))
        .collect::<Result<Vec<_>>>()?;
    (instruments.stages)();
    let pairs = |rows: &[Row], count: fn(&Row) -> usize| -> Vec<(f64, f64)> {
        rows.iter().map(|row| (count(row) as f64, row.load_point_ms)).collect()
    };
    let by_elements = pairs(&by_elements, |row| row.elements);
    let by_points = pairs(&by_points, |row| row.points_per_element);
    let exponents = [exponent(&by_elements), exponent(&by_points)];
    text += &format!(
        "a load point costs as elements^{:.2}, as points per element^{:.2}\n",
        exponents[0], exponents[1]
    );
    let figures = json!({ "rows": rows, "exponent_elements": exponents[0], "exponent_points": exponents[1] });
    let picture = reports::plot::scaling(&by_elements, &by_points)?;
    Ok(Scaling {
        figures,
        table: text,
        picture,
    })
}

struct Row {
    elements: usize,
    points_per_element: usize,
    load_point_ms: f64,
}

/// Slope of the least-squares line through the logarithms.
fn exponent(pairs: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = pairs.iter().map(|(n, t)| (n.ln(), t.ln())).collect();
    let count = logs.len() as f64;
    let (x, y) = logs
        .iter()
        .fold((0.0, 0.0), |m, p| (m.0 + p.0 / count, m.1 + p.1 / count));
    let (up, down) = logs.iter().fold((0.0, 0.0), |s, p| {
        (s.0 + (p.0 - x) * (p.1 - y), s.1 + (p.0 - x).powi(2))
    });
    up / down
}

/// Displacements at the response point, spaced in log (m).
fn amplitudes(count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| 1e-7 * 1e4_f64.powf(i as f64 / (count - 1) as f64))
        .collect()
}

fn total(points: &[BackbonePoint]) -> Result<Effort> {
    let mut sum = Effort::default();
    for point in points {
        if let Err(failure) = &point.result {
            return Err(anyhow!("a loop did not converge: {}", failure.reason));
        }
        sum += point.effort;
    }
    Ok(sum)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// Fastest of several rounds (ms).
pub(super) fn fastest(mut operation: impl FnMut()) -> f64 {
    (0..ROUNDS)
        .map(|_| {
            let began = Instant::now();
            operation();
            1e3 * began.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// A prepared scene seen by the solver.
pub(super) struct Bench<'a> {
    prepared: &'a Prepared,
    pub(super) force: InterfaceForce<'a>,
}

impl<'a> Bench<'a> {
    pub(super) fn try_new(prepared: &'a Prepared) -> Result<Self> {
        Ok(Self {
            prepared,
            force: InterfaceForce::new(&prepared.interface().interface),
        })
    }

    fn n_points(&self) -> usize {
        self.prepared.interface().interface.operators().n_points()
    }

    fn size(&self) -> usize {
        self.prepared.model().reduced.size()
    }

    fn settings(&self, solver: LinearSolver) -> Settings {
        Settings {
            vertices_per_quarter: VERTICES,
            solver,
            ..Settings::default()
        }
    }

    pub(super) fn linearise(&self) -> Result<Linearisation<'a, State>> {
        let reduced = &self.prepared.model().reduced;
        let (stiffness, mass) = (reduced.stiffness.as_ref(), reduced.mass.as_ref());
        let (load, start) = (self.prepared.static_load(), self.prepared.start());
        let rest = prestress::solve(stiffness, &self.force, &load, &start, &NewtonSettings::default())?
            .map_err(|failure| anyhow!("the prestress did not converge: {}", failure.reason))?;
        let mut line = modes::linearise(stiffness, mass, &self.force, rest.displacement, rest.state, 10)?;
        line.orient(&self.response())?;
        Ok(line)
    }

    pub(super) fn response(&self) -> Vec<f64> {
        self.prepared.model().reduced.recovery.row(0).iter().copied().collect()
    }

    /// Loops whose linear estimate at the response point is `displacements` (m).
    fn backbone(
        &self,
        line: &Linearisation<'_, State>,
        displacements: &[f64],
        settings: Settings,
    ) -> Result<Vec<BackbonePoint>> {
        let shape = line.shapes.col(0);
        let phi: f64 = shape.iter().zip(self.response()).map(|(a, b)| a * b).sum();
        let forces: Vec<f64> = displacements.iter().map(|x| line.eigenvalues[0] * x / phi).collect();
        let points = cqsma::run(line, &self.force, &forces, &settings, |_| NoObserver)?;
        Ok(points.into_iter().map(|(point, _)| point).collect())
    }

    /// Time per load point of one loop, on one thread.
    fn load_point_ms(&self, line: &Linearisation<'_, State>, displacement: f64, settings: Settings) -> Result<f64> {
        let began = Instant::now();
        let points = self.backbone(line, &[displacement], settings)?;
        Ok(1e3 * began.elapsed().as_secs_f64() / total(&points)?.solves as f64)
    }

    /// The unit of memory traffic: the reduced stiffness, read once.
    fn matvec_ms(&self) -> f64 {
        let stiffness = &self.prepared.model().reduced.stiffness;
        let n = self.size();
        let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut y = vec![0.0; n];
        fastest(|| {
            stiffness.as_ref().multiply(&x, &mut y);
            black_box(&y);
        })
    }

    fn stuck_response_ms(&self, line: &Linearisation<'_, State>) -> f64 {
        let load = self.prepared.static_load();
        let mut response = vec![0.0; load.len()];
        fastest(|| line.preconditioner_solve_into(&load, black_box(&mut response)))
    }

    /// One evaluation of the interface at the static state, moved a little: without and with its tangent.
    fn evaluate_ms(&self, line: &Linearisation<'_, State>) -> [f64; 2] {
        let force = &self.force;
        let begin = force.initial_state();
        let (mut end, mut workspace) = (begin.clone(), force.workspace());
        let mut values = vec![0.0; force.n_dofs()];
        let mut tangent = vec![0.0; force.pattern().indices.len()];
        let scale = self.prepared.interface().closure;
        let u: Vec<f64> = line.displacement()[..force.n_dofs()]
            .iter()
            .enumerate()
            .map(|(i, u)| u + 0.1 * scale * (i as f64).sin())
            .collect();
        [false, true].map(|with| {
            fastest(|| {
                let tangent = with.then_some(&mut tangent[..]);
                black_box(force.evaluate(
                    &u,
                    Sticking::Coulomb,
                    &begin,
                    &mut end,
                    &mut workspace,
                    &mut values,
                    tangent,
                ));
            })
        })
    }
}
