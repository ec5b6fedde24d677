//! What a loop is made of, on the quick mesh with 25 points per element, and the same loop with a factorisation at every
//! iteration. The full size is timed by `cargo xtask bench`.
#![expect(clippy::unwrap_used, reason = "bench")]

use analyses::prepare;
use brake_reuss_beam::BrakeReussBenchmark;
use cqsma_solver::cqsma::{Cycles, Settings, run};
use cqsma_solver::{HystereticForce, LinearSolver, NewtonSettings, NoObserver, Sticking, modes, prestress};
use criterion::{Criterion, criterion_group, criterion_main};
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::interface::InterfaceForce;
use joints::progress::Silent;
use scenes::Scene;
use std::hint::black_box;

fn loops(c: &mut Criterion) {
    let mut scene = Scene::of(&BrakeReussBenchmark, "bench").unwrap();
    scene.model.refinement = RefinementLevel::Quick;
    scene.interfaces.points_per_direction = 5;
    let prepared = prepare(&scene, &Options::default(), &Silent).unwrap();
    let reduced = &prepared.model().reduced;
    let (stiffness, mass) = (reduced.stiffness.as_ref(), reduced.mass.as_ref());
    let force = InterfaceForce::new(&prepared.interface().interface);
    let (load, start) = (prepared.static_load(), prepared.start());
    let newton = NewtonSettings::default();
    let rest = prestress::solve(stiffness, &force, &load, &start, &newton)
        .unwrap()
        .unwrap();
    let line = modes::linearise(stiffness, mass, &force, rest.displacement, rest.state, 1).unwrap();

    let begin = force.initial_state();
    let (mut end, mut workspace) = (begin.clone(), force.workspace());
    let mut values = vec![0.0; force.n_dofs()];
    let mut tangent = vec![0.0; force.pattern().indices.len()];
    let jump = line.displacement()[..force.n_dofs()].to_vec();
    c.bench_function("forces_and_tangent", |b| {
        b.iter(|| {
            let tangent = Some(&mut tangent[..]);
            black_box(force.evaluate(
                &jump,
                Sticking::Coulomb,
                &begin,
                &mut end,
                &mut workspace,
                &mut values,
                tangent,
            ))
        });
    });
    c.bench_function("stuck_solve", |b| {
        b.iter(|| black_box(line.stuck_response(&load).unwrap()))
    });

    let phi: f64 = line
        .shapes
        .col(0)
        .iter()
        .zip(reduced.recovery.row(0).iter())
        .map(|(a, b)| a * b)
        .sum();
    // A tenth of a millimetre at the beam's end: the edges of the interface slip.
    let modal_force = 1e-4 * line.eigenvalues[0] / phi.abs();
    let walk = |settings: &Settings| run(&line, &force, &[modal_force], settings, |_| NoObserver).unwrap();
    let shortest = |solver| Settings {
        vertices_per_quarter: 1,
        cycles: Cycles::Fixed(1),
        solver,
        ..Settings::default()
    };
    // One loading and four edges.
    c.bench_function("five_load_points", |b| {
        b.iter(|| black_box(walk(&shortest(LinearSolver::Krylov))))
    });
    c.bench_function("five_load_points_by_factorisations", |b| {
        b.iter(|| black_box(walk(&shortest(LinearSolver::Direct))));
    });
    c.bench_function("loop", |b| b.iter(|| black_box(walk(&Settings::default()))));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = loops
}
criterion_main!(benches);
