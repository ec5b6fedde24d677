//! Runs a scene from Rust and prints its backbone:
//! `cargo run --release -p analyses --example run_scene [SCENE.json [CACHE_DIR]]`.
#![allow(clippy::print_stdout)]

use analyses::run;
use brake_reuss_beam::BrakeReussBenchmark;
use joints::Options;
use joints::progress::{Progress, Stage};
use scenes::Scene;

struct Stages;

impl Progress for Stages {
    fn begin(&self, stage: Stage) {
        println!("{}", stage.name());
    }

    fn end(&self, stage: Stage) {
        println!("{} done", stage.name());
    }
}

fn main() -> Result<(), analyses::Error> {
    let scene = match std::env::args().nth(1) {
        Some(path) => Scene::read(path.as_ref(), &[&BrakeReussBenchmark])?,
        None => Scene::of(&BrakeReussBenchmark, "brb-flat")?,
    };
    let options = std::env::args().nth(2).map(Options::cached).unwrap_or_default();
    let run = run(&scene, &options, &Stages)?;
    println!("stuck modes [Hz]: {:.2?}", &run.model.reduced.stuck_frequencies[..10]);
    println!("linearised modes [Hz]: {:.2?}", run.frequencies);
    println!(
        "{:>12} {:>12} {:>12} {:>12} {:>12} {:>10} {:>10} {:>10} {:>10}",
        "alpha", "x [m]", "f [Hz]", "zeta [-]", "floor [-]", "newton", "forces", "krylov", "lu"
    );
    for amplitude in run.amplitudes() {
        match (&amplitude.point.result, amplitude.response_displacement) {
            (Ok(r), Some(x)) => {
                let e = amplitude.point.effort;
                println!(
                    "{:12.4e} {x:12.4e} {:12.4} {:12.4e} {:12.2e} {:10} {:10} {:10} {:10}",
                    amplitude.point.modal_force,
                    r.omega / std::f64::consts::TAU,
                    r.zeta,
                    r.zeta_floor,
                    e.iterations,
                    e.evaluations,
                    e.krylov_steps,
                    e.factorisations
                );
            }
            (Err(failure), _) => println!("not converged: {}", failure.reason),
            _ => {}
        }
    }
    for method in &run.first().methods {
        println!("{}", method.method.name());
        for point in &method.points {
            match &point.result {
                Ok(r) => println!(
                    "{:12.4e} {:12.4} {:12.4e} {:10} {:10} {:10} {:10}",
                    r.response_displacement,
                    r.omega / std::f64::consts::TAU,
                    r.zeta.unwrap_or(f64::NAN),
                    point.effort.iterations,
                    point.effort.evaluations,
                    point.effort.krylov_steps,
                    point.effort.factorisations
                ),
                Err(failure) => println!("not converged: {}", failure.reason),
            }
        }
    }
    // The results are where they shall be: the run need not be resumed any more.
    run.checkpoints.remove();
    Ok(())
}
