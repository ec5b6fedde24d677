//! Readings, symmetries and options of the whole characterisation on a small pair.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use contact_laws::{ElasticPair, FittedCurves, TangentialReading};
use surface_characterisation::{
    AsperityCount, Bootstrap, Detrend, ElementOutlines, ElementSurface, FitFallback, HeightCombination, HeightMap,
    Options, PackingHeight, PairRadius, RadiusStatistic, SurfaceError, SyntheticFace, TallestPeak, characterise,
};

const NX: usize = 150;
const NY: usize = 120;

fn steel() -> ElasticPair {
    ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    }
}

/// A rough patch whose lengths are given in units of `1/per_metre` m.
fn patch(seed: u64, tilt: [f64; 2], per_metre: f64) -> HeightMap {
    let map = SyntheticFace {
        points: [NX, NY],
        step: [30e-6, 50e-6],
        origin: [15e-6, 25e-6],
        rms: 1.5e-6,
        correlation_length: [120e-6, 150e-6],
        waviness: vec![],
        tilt,
        height_step: Some(0.5e-6),
        seed,
    }
    .generate(|_| false)
    .unwrap();
    let heights: Vec<f64> = (0..NX * NY)
        .map(|k| map.height(k % NX, k / NX).unwrap() * per_metre)
        .collect();
    let scaled = |v: [f64; 2]| v.map(|x| x * per_metre);
    HeightMap::try_new(NX, NY, scaled(map.step()), scaled(map.origin()), heights)
        .unwrap()
        .with_height_step(0.5e-6 * per_metre)
        .unwrap()
}

/// 3 x 2 elements of 1.5 mm x 3 mm.
fn elements(per_metre: f64) -> ElementOutlines {
    let nodes = (0..12)
        .map(|k| [f64::from(k % 4) * 1.5e-3, f64::from(k / 4) * 3e-3].map(|x| x * per_metre))
        .collect();
    let quads = [0u32, 1, 2, 4, 5, 6]
        .into_iter()
        .map(|a| vec![a, a + 1, a + 5, a + 4])
        .collect();
    ElementOutlines::try_new(nodes, quads).unwrap()
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs())
}

#[test]
fn the_order_of_the_faces_does_not_matter() {
    let (a, b) = (patch(5, [0.0; 2], 1.0), patch(6, [0.0; 2], 1.0));
    let run = |top: &HeightMap, bottom: &HeightMap| {
        characterise(top, bottom, &elements(1.0), &Options::new(steel())).unwrap()
    };
    for (x, y) in run(&a, &b).elements.iter().zip(&run(&b, &a).elements) {
        assert_eq!(
            (&x.curves, &x.bands, &x.gap, &x.normal),
            (&y.curves, &y.bands, &y.gap, &y.normal)
        );
    }
}

#[test]
fn metres_and_millimetres_give_the_same_surface() {
    let run = |per_metre: f64| {
        let mut options = Options::new(steel());
        options.material.youngs_modulus /= per_metre * per_metre;
        options.u_ref *= per_metre;
        options.interference.from *= per_metre;
        options.interference.to *= per_metre;
        let (top, bottom) = (patch(5, [1e-3, 2e-3], per_metre), patch(6, [0.0; 2], per_metre));
        characterise(&top, &bottom, &elements(per_metre), &options).unwrap()
    };
    for (a, b) in run(1.0).elements.iter().zip(&run(1e3).elements) {
        for f in 0..2 {
            assert_eq!(
                (a.faces[f].peaks, a.faces[f].summits),
                (b.faces[f].peaks, b.faces[f].summits)
            );
        }
        assert!(close(a.population.count(), b.population.count(), 1e-9));
        assert!(close(
            a.population.effective_radius() * 1e3,
            b.population.effective_radius(),
            1e-9
        ));
        for (t, s) in a.curves.normal.iter().zip(&b.curves.normal) {
            assert!(close(t * 1e-6, *s, 1e-9));
        }
        let (p, q) = (a.normal.parameters, b.normal.parameters);
        assert!(
            close(p.b, q.b, 1e-9) && close(p.c, q.c, 1e-9) && close(p.e, q.e, 1e-9),
            "{p:?} {q:?}"
        );
        for g in 0..2 {
            assert!((a.gap_range[g] * 1e3 - b.gap_range[g]).abs() < 1e-9 * 1e-3);
        }
    }
}

#[test]
fn swapping_x_and_y_swaps_the_radii_only() {
    let swap = |map: &HeightMap| {
        let heights: Vec<f64> = (0..NX * NY).map(|k| map.height(k / NY, k % NY).unwrap()).collect();
        let ([dx, dy], [x, y]) = (map.step(), map.origin());
        HeightMap::try_new(NY, NX, [dy, dx], [y, x], heights)
            .unwrap()
            .with_height_step(0.5e-6)
            .unwrap()
    };
    let (a, b) = (patch(5, [0.0; 2], 1.0), patch(6, [0.0; 2], 1.0));
    let corners = [[0.0, 0.0], [4.4e-3, 0.3e-3], [4.1e-3, 5.9e-3], [0.2e-3, 5.2e-3]];
    let run = |a: &HeightMap, b: &HeightMap, corners: Vec<[f64; 2]>| {
        let element = ElementOutlines::try_new(corners, vec![vec![0, 1, 2, 3]]).unwrap();
        characterise(a, b, &element, &Options::new(steel()))
            .unwrap()
            .elements
            .remove(0)
    };
    let plain = run(&a, &b, corners.to_vec());
    let swapped = run(&swap(&a), &swap(&b), corners.iter().map(|p| [p[1], p[0]]).collect());
    for (p, s) in plain.faces.iter().zip(&swapped.faces) {
        assert_eq!(
            (p.points, p.summits, p.peaks),
            (s.points, s.summits, [s.peaks[1], s.peaks[0]])
        );
        assert!(close(p.radius[0].unwrap(), s.radius[1].unwrap(), 1e-9));
        assert!(close(p.total_roughness(), s.total_roughness(), 1e-9));
    }
    for (t, s) in plain.curves.normal.iter().zip(&swapped.curves.normal) {
        assert!(close(*t, *s, 1e-8));
    }
}

#[test]
fn tilt_between_registered_faces_opens_the_gap() {
    let slope = [2e-3, -1e-3];
    let run = |detrend: Detrend| {
        let options = Options {
            detrend,
            ..Options::new(steel())
        };
        characterise(&patch(5, slope, 1.0), &patch(6, slope, 1.0), &elements(1.0), &options).unwrap()
    };
    // With the registration trusted, tilt is gap: its slope is minus the sum of the two faces' slopes.
    let registered = run(Detrend::Registered);
    for e in &registered.elements {
        for k in 0..2 {
            let found = e.gap.coefficients[1 + k] / e.gap.half_width[k];
            // Roughness of 1.5 um leaves the slopes of forms over millimetres uncertain by about 2e-4.
            assert!((found + 2.0 * slope[k]).abs() < 8e-4, "{k}: {found}");
        }
    }
    // 4.5 mm and 6 mm at these slopes.
    let drop = 2.0 * (2e-3 * 4.5e-3 + 1e-3 * 6e-3);
    let [low, high] = registered.summary().gap_range;
    assert!(low > -8e-6 && (high / drop - 1.0).abs() < 0.2, "{low} {high} {drop}");
    assert!(run(Detrend::WholeFace).summary().gap_range[1] < 8e-6);
    assert!(run(Detrend::default()).summary().gap_range[1] < 12e-6);
}

#[test]
fn every_reading_ends_in_accepted_laws() {
    let (a, b) = (patch(5, [0.0; 2], 1.0), patch(6, [0.0; 2], 1.0));
    let run = |change: &dyn Fn(&mut Options)| -> ElementSurface {
        let mut options = Options::new(steel());
        change(&mut options);
        let mut c = characterise(&a, &b, &elements(1.0), &options).unwrap();
        for e in &c.elements {
            FittedCurves::try_new(e.normal.parameters, e.tangential.map(|t| t.parameters)).unwrap();
        }
        c.elements.remove(0)
    };
    let base = run(&|_| {});
    assert_eq!(base.normal.fallback, None);
    let mean = run(&|o| o.radius = RadiusStatistic::Mean);
    assert!(mean.population.effective_radius() > base.population.effective_radius());
    let literal = run(&|o| o.pair_radius = PairRadius::Eq6Literal);
    assert!(literal.population.effective_radius() < 0.6 * base.population.effective_radius());
    let peak = run(&|o| o.packing_height = PackingHeight::MeanPeak);
    assert!(peak.population.count() > base.population.count());
    let summits = run(&|o| o.count = AsperityCount::Summits);
    let expected = 0.5 * (base.faces[0].summits + base.faces[1].summits) as f64;
    assert_eq!(summits.population.count(), expected);
    let summed = run(&|o| o.heights = HeightCombination::Summed);
    assert!(summed.population.heights().len() < base.population.heights().len());
    let paper = run(&|o| o.tangential = TangentialReading::Paper);
    assert!(paper.curves.tangential[0][0] > base.curves.tangential[0][0]);
    assert_ne!(paper.curves.tangential[0], paper.curves.tangential[1]);
    let tallest = TallestPeak::MOutOfN { exponent: 0.7 };
    let subsampled = run(&|o| {
        o.bootstrap = Bootstrap {
            tallest,
            ..Bootstrap::default()
        }
    });
    assert_eq!(subsampled.curves, base.curves);
    assert_ne!(subsampled.bands, base.bands);

    let single = run(&|o| o.least_peaks = usize::MAX);
    assert_eq!(single.normal.fallback, Some(FitFallback::SingleAsperity));
    assert!(
        single
            .tangential
            .iter()
            .all(|t| t.fallback == Some(FitFallback::SingleAsperity))
    );
    assert!(single.normal.max_residual < 1e-12 && single.normal.parameters.b == 1.5);
    assert_eq!(single.population.heights().len(), 1);
}

#[test]
fn options_outside_their_range_are_named() {
    let (a, b) = (patch(5, [0.0; 2], 1.0), patch(6, [0.0; 2], 1.0));
    let error = |change: &dyn Fn(&mut Options)| {
        let mut options = Options::new(steel());
        change(&mut options);
        match characterise(&a, &b, &elements(1.0), &options).unwrap_err() {
            SurfaceError::InvalidValue { field, .. } => field,
            other => panic!("{other}"),
        }
    };
    assert_eq!(error(&|o| o.material.poisson_ratio = 0.6), "poisson_ratio");
    assert_eq!(error(&|o| o.material.youngs_modulus = f64::NAN), "youngs_modulus");
    assert_eq!(error(&|o| o.u_ref = 0.0), "u_ref");
    assert_eq!(error(&|o| o.packing_efficiency = -0.5), "packing efficiency");
    assert_eq!(
        error(&|o| o.interference.to = o.interference.from),
        "greatest interference"
    );
    assert_eq!(error(&|o| o.interference.points = 3), "interference samples");
    assert_eq!(
        error(&|o| o.detrend = Detrend::FreeEdges { width: 0.0 }),
        "detrend width"
    );
}
