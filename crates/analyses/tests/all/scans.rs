//! Surfaces from files of profilometers, and ensembles of their bootstrap realisations.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{BENCHMARKS, beam};
use analyses::ensemble::Ensemble;
use analyses::{Error, Run, run, run_ensemble};
use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::Benchmark;
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::interface::{ScannedSurface, synthetic};
use joints::progress::{Progress, Silent, Stage};
use joints::structure::Structure;
use scenes::{Gap, LawKind, Length, ScanFile, Scans, Scene, Surface, SyntheticScan};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use surface_characterisation::{ElementSurface, writers};

/// Folder with two faces as X3P files, of a coarser grid than the default, and the reduced model that all tests share.
fn folder() -> &'static Path {
    static READY: OnceLock<PathBuf> = OnceLock::new();
    READY.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scans");
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let mesh = structure().interface().clone();
        for (side, name) in [(0, "top.x3p"), (1, "bottom.x3p")] {
            let map = synthetic(&faces(), &mesh, side, |x| BrakeReussBenchmark.is_void(x)).unwrap();
            std::fs::write(folder.join(name), writers::x3p(&map).unwrap()).unwrap();
        }
        run(&scene(Surface::Measured), &options(&folder), &Silent).unwrap();
        folder
    })
}

fn structure() -> Structure {
    let scene = scene(Surface::Measured);
    Structure::try_new(&scene, &Silent).unwrap()
}

fn options(folder: &Path) -> Options {
    Options::cached(folder.join("cache"))
}

fn faces() -> SyntheticScan {
    SyntheticScan {
        seed: 7,
        step: [90e-6, 150e-6].map(Length::from_si),
        ..SyntheticScan::default()
    }
}

fn scene(surface: Surface) -> Scene {
    let mut scene = beam("scans");
    scene.model.refinement = RefinementLevel::Quick;
    scene.analyses.backbone.amplitudes = 3;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-6);
    scene.analyses.backbone.vertices_per_quarter = 4;
    if surface.is_scanned() {
        scene.interfaces.gap = Gap::Scan;
    }
    scene.interfaces.surface = surface;
    scene
}

fn file(name: &str) -> ScanFile {
    ScanFile {
        path: folder().join(name),
        height_step: Some(faces().height_step),
        ..ScanFile::default()
    }
}

/// The scans of the two files, as the synthetic scene characterises the same faces.
fn scans() -> Scans {
    Scans {
        seed: faces().seed,
        ..Scans::new(file("top.x3p"), file("bottom.x3p"))
    }
}

fn bits(run: &Run) -> Vec<[u64; 3]> {
    let results = run.amplitudes().iter().map(|a| a.point.result.as_ref().unwrap());
    results
        .map(|r| [r.omega, r.zeta, r.modal_amplitude].map(f64::to_bits))
        .collect()
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_scans_from_files_give_the_backbone_of_the_same_faces_to_the_last_bit() {
    for kind in [LawKind::Tabulated, LawKind::Fitted] {
        let go = |surface| {
            let mut scene = scene(surface);
            scene.interfaces.law.kind = kind;
            run(&scene, &options(folder()), &Silent).unwrap()
        };
        let read = go(Surface::Scans(Box::new(scans())));
        let made = go(Surface::SyntheticScan(faces()));
        assert_eq!(bits(&read), bits(&made), "{kind:?}");
        assert_eq!(read.interface.gap(), made.interface.gap());
        assert!(read.interface.gap().unwrap().iter().any(|g| *g > 1e-7));
        // The account of the run says where it comes from, and is a scene again.
        let report = read.law().asperities.as_ref().unwrap();
        assert_eq!(report.scans[0].path, folder().join("top.x3p"));
        assert_eq!(report.scans[1].height_step, Some(faces().height_step.si()));
        assert!(made.law().asperities.as_ref().unwrap().scans.is_empty());
        let text = serde_json::to_string(&read.scene).unwrap();
        assert_eq!(Scene::from_json(&text, "again", "", &BENCHMARKS).unwrap(), read.scene);
    }
}

#[test]
fn scenes_name_scans_by_paths_lists_and_blocks_in_their_own_units() {
    let folder = folder().join("named");
    std::fs::create_dir_all(&folder).unwrap();
    let read = |surface: &str| {
        let text = format!(
            r#"{{ "units": {{ "length": "mm", "mass": "t", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
                "interfaces": {{ "gap": "scan", "surface": {{ "scans": {surface} }} }} }}"#
        );
        std::fs::write(folder.join("scene.json"), text).unwrap();
        Scene::read(&folder.join("scene.json"), &BENCHMARKS)
    };
    let scans = |surface: &str| match read(surface).unwrap().interfaces.surface {
        Surface::Scans(scans) => *scans,
        other => panic!("{other:?}"),
    };
    let list = scans(r#"["a.x3p", { "path": "../b.csv", "height_unit": "µm", "height_step": 5e-4 }]"#);
    assert_eq!(list.top.path, folder.join("a.x3p"));
    assert_eq!(list.bottom.path, folder.join("../b.csv"));
    assert_eq!(list.bottom.height_step, Some(Length::from_si(5e-4 * 1e-3)));
    let block = scans(
        r#"{ "top": "a.x3p", "bottom": { "path": "b.npy", "place": { "origin": [-60, -12.7] }, "mirrored": true },
             "align": 0.5, "registration": { "shift": [0.1, 0], "tilt": [1e-4, 0] },
             "noise": { "outliers": { "threshold": 8 }, "s_filter": 0.08 },
             "readings": { "radius": "mean", "pair_radius": "eq6-literal", "packing_height": "mean-peak",
                           "count": "summits", "heights": "summed" },
             "detrend": { "free-edges": { "width": 0.1 } }, "bootstrap": 5, "seed": 3,
             "tallest": { "m-out-of-n": { "exponent": 0.8 } } }"#,
    );
    assert_eq!(block.registration.shift, [0.1 * 1e-3, 0.0].map(Length::from_si));
    assert_eq!(
        (block.align, block.noise.s_filter),
        (Some(Length::from_si(0.5 * 1e-3)), Some(Length::from_si(0.08 * 1e-3)))
    );
    assert_eq!(block.noise.outliers.unwrap().reach, 2);
    for (surface, expected) in [
        (r#"["a.x3p"]"#, "expected an array of length 2"),
        (r#"{ "top": "a.x3p" }"#, "missing field `bottom`"),
        (
            r#"{ "top": "a.x3p", "bottom": { "path": "b", "unit": "mm" } }"#,
            "unknown field `unit`",
        ),
        (
            r#"{ "top": "a", "bottom": "b", "readings": { "radius": "median" } }"#,
            "unknown variant `median`",
        ),
        (
            r#"["a", { "path": "b", "height_unit": "parsec" }]"#,
            "`parsec` is no unit of length",
        ),
        (
            r#"{ "top": "a", "bottom": "b", "align": -1 }"#,
            "interfaces.surface.scans.align = -0.001 m",
        ),
        (
            r#"["a", { "path": "b", "height_step": 0 }]"#,
            "height_step of a file = 0 m",
        ),
        (
            r#"{ "top": "a", "bottom": "b", "tallest": { "m-out-of-n": { "exponent": 1 } } }"#,
            "interfaces.surface.scans.tallest.m-out-of-n.exponent = 1",
        ),
    ] {
        let message = read(surface).unwrap_err().to_string();
        assert!(message.contains(expected), "{surface}: {message}");
    }
}

/// A face scanned from its own side, by an instrument that knows nothing of the interface, is brought back.
#[test]
fn mirrored_and_misplaced_faces_are_brought_back() {
    let mesh = structure().interface().clone();
    let base = scene(Surface::Scans(Box::new(scans())));
    let expected = ScannedSurface::try_new(&base, &mesh).unwrap();
    let [_, bottom] = &expected.faces;
    // The geometry is symmetric, so the middle of the interface is at x = 0.
    let displaced = bottom.mirrored_x(0.0).shifted([0.35, -0.02]).unwrap();
    let path = folder().join("displaced.csv");
    std::fs::write(&path, writers::csv(&displaced)).unwrap();
    let mut moved = scans();
    moved.bottom = ScanFile {
        path,
        mirrored: true,
        place: serde_json::from_value(serde_json::json!({ "origin": bottom.origin() })).unwrap(),
        ..file("bottom.x3p")
    };
    let found = ScannedSurface::try_new(&scene(Surface::Scans(Box::new(moved.clone()))), &mesh).unwrap();
    // Positions are off by their rounding, so that points on the border of two elements may change sides, and with them, here
    // and there, the tallest peak.
    let pairs = || expected.found.elements.iter().zip(&found.found.elements);
    let near = |(a, b): &(&ElementSurface, &ElementSurface)| (a.gap_range[0] - b.gap_range[0]).abs() < 0.1e-6;
    let (same, all) = (pairs().filter(near).count(), pairs().count());
    assert!(10 * same > 9 * all, "{same} of {all}");
    for (a, b) in pairs() {
        assert!((b.faces[1].areal.sq / a.faces[1].areal.sq - 1.0).abs() < 0.02);
    }
    // Its holes fix its place when it is displaced by less than the reach.
    moved.bottom.place = serde_json::from_value(serde_json::json!("centred")).unwrap();
    moved.align = Some(Length::from_si(0.4e-3));
    let aligned = ScannedSurface::try_new(&scene(Surface::Scans(Box::new(moved))), &mesh);
    let shift = aligned.unwrap().files[1].alignment.unwrap().shift;
    assert!(shift[0].abs() <= 61e-6 && shift[1].abs() <= 101e-6, "{shift:?}");
}

#[test]
fn errors_name_the_file_and_surfaces_without_samples_have_no_ensemble() {
    let mut missing = scans();
    missing.bottom.path = folder().join("no-such.x3p");
    let error = run(&scene(Surface::Scans(Box::new(missing))), &options(folder()), &Silent).unwrap_err();
    assert!(
        matches!(error, Error::Joint(joints::Error::ScanFile(_))) && error.to_string().contains("no-such.x3p"),
        "{error}"
    );
    let parameters: Surface = serde_json::from_value(serde_json::json!({ "parameters": { "per": "interface", "sets": [
        { "curves": { "elastic": { "normal_stiffness": 1e13, "tangential_stiffness": [7e12, 7e12] } } } ] } }))
    .unwrap();
    for surface in [Surface::Measured, parameters] {
        let error = run_ensemble(&scene(surface), 3, &options(folder()), &Silent).unwrap_err();
        assert!(matches!(error, Error::Joint(joints::Error::NoSamples)), "{error}");
    }
}

/// Stops after a number of loops.
struct StopAfter(AtomicUsize);

impl Progress for StopAfter {
    fn fraction(&self, stage: Stage, _: f64) {
        if matches!(stage, Stage::Backbone | Stage::Ensemble) {
            let _ = self
                .0
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        }
    }

    fn interrupted(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

fn go(scene: &Scene, options: &Options, threads: usize) -> (Run, Ensemble) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (run, ensemble) = pool.install(|| run_ensemble(scene, 3, options, &Silent)).unwrap();
    // The next one shall compute it again.
    run.checkpoints.remove();
    (run, ensemble)
}

#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_ensembles_depend_on_the_seed_alone_and_go_on_where_they_stopped() {
    let scene = scene(Surface::SyntheticScan(faces()));
    let (measured, one) = go(&scene, &options(folder()), 1);
    let (_, two) = go(&scene, &options(folder()), 2);
    assert_eq!(one, two);
    assert_eq!((one.realisations, one.failed, one.members.len()), (3, 0, 3), "{one:?}");
    assert!(one.members.iter().all(|m| m.points.len() == 3 && m.not_converged == 0));
    assert!(one.members[0].points != one.members[1].points);
    assert_eq!(one.bands.len(), 3);
    for (band, point) in one.bands.iter().zip(measured.amplitudes()) {
        let [low, middle, high] = band.frequency_hz;
        assert!(low <= middle && middle <= high && low < high, "{band:?}");
        // The realisations scatter about the measured backbone, by far less than its frequency.
        let frequency = point.point.result.as_ref().unwrap().omega / (2.0 * std::f64::consts::PI);
        assert!((middle / frequency - 1.0).abs() < 0.02, "{middle} {frequency}");
        assert!((high - low) / middle < 0.02);
    }

    // Interrupted in the second realisation or so, then finished.
    let cache = folder().join("interrupted");
    let _ = std::fs::remove_dir_all(&cache);
    std::fs::create_dir_all(&cache).unwrap();
    for entry in std::fs::read_dir(folder().join("cache")).unwrap() {
        let from = entry.unwrap().path();
        std::fs::copy(&from, cache.join(from.file_name().unwrap())).unwrap();
    }
    let options = Options::cached(cache.clone());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let stopped = pool.install(|| run_ensemble(&scene, 3, &options, &StopAfter(AtomicUsize::new(7))));
    assert!(stopped.is_err());
    let text = std::fs::read_dir(&cache)
        .unwrap()
        .map(|e| e.unwrap().path())
        .find(|p| p.file_name().unwrap().to_str().unwrap().starts_with("ensemble-"))
        .map(|p| std::fs::read_to_string(p).unwrap())
        .unwrap();
    assert!((1..3).contains(&text.lines().count()), "{text}");
    assert_eq!(go(&scene, &options, 2).1, one);
    let left = std::fs::read_dir(&cache).unwrap().map(|e| e.unwrap().file_name());
    assert!(
        left.into_iter()
            .all(|name| !name.to_str().unwrap().starts_with("ensemble-"))
    );
}

#[test]
fn realisations_without_the_tallest_peak_begin_later_and_agree_with_their_sums() {
    use analyses::prepare;
    use surface_characterisation::traction_curves;
    let scene = scene(Surface::SyntheticScan(faces()));
    let prepared = prepare(&scene, &options(folder()), &Silent).unwrap();
    let mesh = structure().interface().clone();
    let found = ScannedSurface::try_new(&scene, &mesh).unwrap().found;
    let interface = prepared.interface();
    let (realisation, closure) = interface.realisation(1).unwrap();
    assert!(closure > 0.0);
    let drawn = found.realisation(1).unwrap();
    let operators = realisation.operators();
    let u: Vec<f64> = (1..40).map(|k| 0.5e-6 * f64::from(k)).collect();
    let mut later = 0;
    for (e, pair) in drawn.iter().enumerate() {
        let exact = traction_curves(pair, found.options.material, scene.interfaces.law.tangential, &u).unwrap();
        let point = operators.first_point[e];
        let depth = realisation.gap().unwrap()[point] - interface.interface.gap().unwrap()[point];
        assert!(depth >= 0.0);
        later += usize::from(depth > 0.0);
        // Interference of the measured law, traction of the realisation's; single draws against interpolated ones.
        let scale = exact.normal[38];
        let state = law_traction(&realisation, point, &u, depth);
        for k in [9, 19, 38] {
            assert!(
                (state[k] - exact.normal[k]).abs() < 0.12 * scale,
                "element {e}: {} {}",
                state[k],
                exact.normal[k]
            );
        }
    }
    // The tallest is missing in (1 - 1/n)^n of the draws, 37 %.
    let share = later as f64 / drawn.len() as f64;
    assert!(
        (share - 0.37).abs() < 4.0 * (0.37 * 0.63 / drawn.len() as f64).sqrt(),
        "{share}"
    );
}

/// Normal traction at a point of an interface for uniform closures that give the interferences `u - depth` there.
fn law_traction(interface: &zte_assembly::Interface, point: usize, u: &[f64], depth: f64) -> Vec<f64> {
    use contact_laws::Sticking;
    let state = interface.initial_state();
    let (mut end, mut workspace) = (state.clone(), interface.workspace());
    let mut force = vec![0.0; interface.n_dofs()];
    let gap = interface.gap().unwrap()[point];
    u.iter()
        .map(|u| {
            let closure = u - depth + gap;
            let jump: Vec<f64> = (0..interface.n_dofs())
                .map(|i| if i % 3 == 2 { closure } else { 0.0 })
                .collect();
            interface.evaluate(
                &jump,
                Sticking::Coulomb,
                &state,
                &mut end,
                &mut workspace,
                &mut force,
                None,
            );
            workspace.traction[2][point]
        })
        .collect()
}
