//! The whole characterisation at full size: two synthetic faces over the interface of the Brake-Reuss beam.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::time::Instant;

use contact_laws::{ContactCurves, ElasticPair, FittedCurves, TangentialEnds};
use surface_characterisation::{
    Characterisation, ElementOutlines, HeightCombination, HeightMap, NoiseHandling, Options, OutlierRule, Partition,
    SurfaceError, SyntheticFace, Waviness, characterise, fit_normal, fit_tangential,
};

const LENGTH: f64 = 120e-3;
const WIDTH: f64 = 25.4e-3;
const HOLES: [f64; 3] = [-30e-3, 0.0, 30e-3];
const HOLE_RADIUS: f64 = 4.25e-3;

fn steel() -> ElasticPair {
    ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    }
}

/// 588 quads: 10 across, 32 x 3 around each hole, 6 x 10 between the hole blocks and 9 x 10 at each end.
fn interface() -> ElementOutlines {
    let (mut nodes, mut quads) = (Vec::new(), Vec::new());
    let y = |k: usize| -0.5 * WIDTH + WIDTH * k as f64 / 10.0;
    let mut block = |x0: f64, x1: f64, n: usize| {
        let base = nodes.len() as u32;
        for k in 0..=10 {
            nodes.extend((0..=n).map(|i| [x0 + (x1 - x0) * i as f64 / n as f64, y(k)]));
        }
        let row = n as u32 + 1;
        for k in 0..10 {
            quads.extend((0..n as u32).map(|i| {
                let a = base + k * row + i;
                vec![a, a + 1, a + row + 1, a + row]
            }));
        }
    };
    block(-60e-3, -37.5e-3, 9);
    block(-22.5e-3, -7.5e-3, 6);
    block(7.5e-3, 22.5e-3, 6);
    block(37.5e-3, 60e-3, 9);
    for centre in HOLES {
        let base = nodes.len() as u32;
        let x = |k: usize| centre - 7.5e-3 + 15e-3 * k as f64 / 6.0;
        let mut outer: Vec<[f64; 2]> = (0..6).map(|k| [x(k), y(0)]).collect();
        outer.extend((0..10).map(|k| [x(6), y(k)]));
        outer.extend((0..6).map(|k| [x(6 - k), y(10)]));
        outer.extend((0..10).map(|k| [x(0), y(10 - k)]));
        for layer in 0..4 {
            let s = f64::from(layer) / 3.0;
            nodes.extend(outer.iter().map(|p| {
                let angle = p[1].atan2(p[0] - centre);
                let inner = [centre + HOLE_RADIUS * angle.cos(), HOLE_RADIUS * angle.sin()];
                [inner[0] + s * (p[0] - inner[0]), inner[1] + s * (p[1] - inner[1])]
            }));
        }
        for layer in 0..3 {
            for k in 0..32 {
                let (a, b) = (base + layer * 32 + k, base + layer * 32 + (k + 1) % 32);
                quads.push(vec![a, b, b + 32, a + 32]);
            }
        }
    }
    ElementOutlines::try_new(nodes, quads).unwrap()
}

fn in_hole(p: [f64; 2]) -> bool {
    HOLES.iter().any(|c| (p[0] - c).hypot(p[1]) < HOLE_RADIUS)
}

/// A face scanned at 30 um x 50 um with 0.5 um height steps, or `coarser` by a factor.
fn face(seed: u64, coarser: f64) -> HeightMap {
    let step = [30e-6 * coarser, 50e-6 * coarser];
    SyntheticFace {
        points: [(LENGTH / step[0]) as usize, (WIDTH / step[1]) as usize],
        step,
        origin: [-0.5 * LENGTH + 0.5 * step[0], -0.5 * WIDTH + 0.5 * step[1]],
        rms: 1.5e-6,
        correlation_length: [120e-6 * coarser, 150e-6 * coarser],
        waviness: vec![
            Waviness {
                amplitude: 4e-6,
                wavenumber: [1.0 / 90e-3, 0.0],
                phase: 0.4,
            },
            Waviness {
                amplitude: 1e-6,
                wavenumber: [1.0 / 8e-3, 1.0 / 30e-3],
                phase: 1.0,
            },
        ],
        tilt: [3e-4, -5e-4],
        height_step: Some(0.5e-6),
        seed,
    }
    .generate(in_hole)
    .unwrap()
}

fn on_threads<R: Send>(n: usize, run: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new()
        .num_threads(n)
        .build()
        .unwrap()
        .install(run)
}

/// Every element ends with an accepted fit or a declared fallback, and what the reports say is so: the contact laws
/// take the parameters, their curve rises over the fitted range, and its residuals are the reported ones.
fn every_element_is_accounted_for(c: &Characterisation) {
    for e in &c.elements {
        assert!(e.total_roughness() > 0.0 && !e.population.heights().is_empty());
        let law = FittedCurves::try_new(e.normal.parameters, e.tangential.map(|t| t.parameters)).unwrap();
        let residuals = |values: &[f64], of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let loaded = e.curves.interference.iter().zip(values).filter(|(_, t)| **t > 0.0);
            loaded.map(|(u, t)| of(*u).ln() - t.ln()).collect()
        };
        let rms = |r: &[f64]| (r.iter().map(|r| r * r).sum::<f64>() / r.len() as f64).sqrt();
        let normal = residuals(&e.curves.normal, &|u| law.normal(u).0);
        assert_eq!(normal.len(), e.normal.samples);
        assert!(
            (rms(&normal) - e.normal.rms).abs() < 1e-9,
            "element {}: {:?}",
            e.element,
            e.normal
        );
        let fitted: Vec<f64> = e.curves.interference.iter().map(|u| law.normal(*u).0).collect();
        assert!(fitted.windows(2).all(|w| w[0] < w[1]), "element {}", e.element);
        if e.normal.fallback.is_none() {
            let p = e.normal.parameters;
            assert!(
                (0.5..=8.0).contains(&p.b) && (0.15..=5.0).contains(&p.e),
                "element {}: {p:?}",
                e.element
            );
        }
        for q in 0..2 {
            let tangential = residuals(&e.curves.tangential[q], &|u| law.tangential(u)[q].value);
            assert!(
                (rms(&tangential) - e.tangential[q].rms).abs() < 1e-9,
                "element {}",
                e.element
            );
        }
    }
}

#[test]
fn a_full_size_pair_in_seconds() {
    let elements = interface();
    assert_eq!(elements.len(), 588);
    let start = Instant::now();
    let (top, bottom) = (face(1, 1.0), face(2, 1.0));
    let made = start.elapsed();
    assert!(top.nx() * top.ny() >= 2_000_000);
    let start = Instant::now();
    let c = characterise(&top, &bottom, &elements, &Options::new(steel())).unwrap();
    let taken = start.elapsed();
    every_element_is_accounted_for(&c);
    let summary = c.summary();

    // The operating range of the joint, fitted on its own.
    let operating = |normal: bool| {
        let rms = c.elements.iter().map(|e| {
            let u = &e.curves.interference;
            let within: Vec<usize> = (0..u.len()).filter(|&k| (0.3e-6..=15e-6).contains(&u[k])).collect();
            let pick = |v: &[f64]| within.iter().map(|&k| v[k]).collect::<Vec<f64>>();
            if normal {
                fit_normal(&pick(u), &pick(&e.curves.normal), 1e-6).unwrap().rms
            } else {
                fit_tangential(&pick(u), &pick(&e.curves.tangential[0]), 1e-6, TangentialEnds::Mindlin)
                    .unwrap()
                    .rms
            }
        });
        let mut rms: Vec<f64> = rms.collect();
        rms.sort_by(f64::total_cmp);
        [rms[294], rms[587]]
    };
    let (normal, tangential) = (operating(true), operating(false));
    println!(
        "two faces made in {made:?}, characterised in {taken:?} on {} threads",
        rayon::current_num_threads()
    );
    println!("{summary:?}");
    println!("rms of fits over 0.3 to 15 um, median and largest: (28) {normal:.4?}, (29) {tangential:.4?}");
    for f in &c.faces {
        println!("{f:?}");
    }
    let e = &c.elements[45];
    println!(
        "element 45: {} + {} points, peaks {:?}, summits {}, R_t {:.2e}, N {:.1}, radius {:.3e}, {:?}",
        e.faces[0].points,
        e.faces[1].points,
        e.faces[0].peaks,
        e.faces[0].summits,
        e.total_roughness(),
        e.population.count(),
        e.population.effective_radius(),
        e.normal
    );

    assert_eq!(summary.elements, 588);
    assert!(normal[0] <= 0.05, "{normal:?}");
    assert_eq!((summary.power_law, summary.constant), (0, 0));
    assert!(summary.median_rms_normal < 0.1, "{summary:?}");
    // The tilt is removed to the slope of the waviness along the edges.
    for f in &c.faces {
        assert!(
            (f.trend.slope[0] - 3e-4).abs() < 3e-4 && (f.trend.slope[1] + 5e-4).abs() < 1e-4,
            "{f:?}"
        );
        assert_eq!(f.outside, 0);
    }
    // Forms tilted against their own tallest peak make the gap negative, but only by a little.
    assert!(
        summary.gap_range[0] > -2e-6 && summary.gap_range[1] < 60e-6,
        "{summary:?}"
    );
    assert!(taken.as_secs() < 60, "{taken:?}");
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_bitwise_the_same_on_any_number_of_threads() {
    let elements = interface();
    let (top, bottom) = (face(1, 2.0), face(2, 2.0));
    let mut options = Options::new(steel());
    options.heights = HeightCombination::Summed;
    let one = on_threads(1, || characterise(&top, &bottom, &elements, &options).unwrap());
    every_element_is_accounted_for(&one);
    let other = on_threads(2, || characterise(&top, &bottom, &elements, &options).unwrap());
    assert!(one == other);
    options.noise = NoiseHandling {
        outliers: Some(OutlierRule::default()),
        s_filter: Some(300e-6),
    };
    let smooth = || characterise(&top, &bottom, &elements, &options).unwrap();
    let smoothed = on_threads(1, smooth);
    assert!(smoothed == on_threads(2, smooth) && smoothed != one);
    options.noise = NoiseHandling::default();
    options.bootstrap.seed += 1;
    assert!(one != characterise(&top, &bottom, &elements, &options).unwrap());
}

#[test]
fn holes_are_dropped_and_counted_and_empty_elements_refused() {
    let elements = interface();
    let step = [120e-6, 200e-6];
    let (nx, ny) = (1000, 127);
    let rough = SyntheticFace {
        points: [nx, ny],
        step,
        origin: [-0.5 * LENGTH + 0.5 * step[0], -0.5 * WIDTH + 0.5 * step[1]],
        rms: 1.5e-6,
        correlation_length: [300e-6, 500e-6],
        waviness: vec![],
        tilt: [0.0; 2],
        height_step: None,
        seed: 9,
    };
    let whole = rough.generate(|_| false).unwrap();
    let partition = Partition::new(&whole, &elements);
    assert_eq!(partition.points.iter().sum::<usize>() + partition.outside, nx * ny);
    // The holes of the mesh are 32-sided polygons: their points are fewer than those of the circles.
    let circles = 3.0 * std::f64::consts::PI * HOLE_RADIUS.powi(2);
    let share = partition.outside as f64 * step[0] * step[1] / circles;
    assert!((0.95..1.0).contains(&share), "{share}");

    let options = Options::new(steel());
    let masked = rough.generate(|p| p[0] > 57e-3 && p[1] > 9e-3).unwrap();
    let error = characterise(&whole, &masked, &elements, &options).unwrap_err();
    assert!(
        matches!(
            error,
            SurfaceError::TooFewPoints {
                face: "bottom",
                points: 0,
                ..
            }
        ),
        "{error}"
    );
    let flat = HeightMap::try_new(nx, ny, step, whole.origin(), vec![0.0f32; nx * ny]).unwrap();
    let error = characterise(&flat, &flat, &elements, &options).unwrap_err();
    assert!(matches!(error, SurfaceError::NoPeaks { element: 0, .. }), "{error}");
    // A flat face against a rough one is an ordinary pair.
    let mixed = characterise(&flat, &whole, &elements, &options).unwrap();
    every_element_is_accounted_for(&mixed);
    assert_eq!(mixed.faces[0].outside, partition.outside);
}
