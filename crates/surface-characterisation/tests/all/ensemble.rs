//! Realisations of a characterisation, and the settings that change what is characterised.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use contact_laws::{AsperitySumCurves, ContactCurves, ElasticPair};
use surface_characterisation::{
    Bootstrap, Characterisation, Detrend, ElementOutlines, HeightMap, NoiseHandling, Options, OutlierRule,
    PairAsperities, Registration, SyntheticFace, TallestPeak, characterise, realisation, traction_curves,
};

fn steel() -> ElasticPair {
    ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    }
}

/// 3 x 2 elements of 1.5 mm x 3 mm.
fn elements() -> ElementOutlines {
    let nodes = (0..12)
        .map(|k| [f64::from(k % 4) * 1.5e-3, f64::from(k / 4) * 3e-3])
        .collect();
    let quads = [0u32, 1, 2, 4, 5, 6]
        .into_iter()
        .map(|a| vec![a, a + 1, a + 5, a + 4])
        .collect();
    ElementOutlines::try_new(nodes, quads).unwrap()
}

fn face(seed: u64) -> HeightMap {
    SyntheticFace {
        points: [170, 130],
        step: [30e-6, 50e-6],
        origin: [-285e-6, -225e-6],
        rms: 1.5e-6,
        correlation_length: [120e-6, 150e-6],
        waviness: vec![],
        tilt: [0.0; 2],
        height_step: Some(0.1e-6),
        seed,
    }
    .generate(|_| false)
    .unwrap()
}

fn run(options: &Options) -> Characterisation {
    characterise(&face(5), &face(6), &elements(), options).unwrap()
}

#[test]
fn realisations_are_the_samples_behind_the_bands() {
    for tallest in [TallestPeak::Fixed, TallestPeak::MOutOfN { exponent: 0.8 }] {
        let mut options = Options::new(steel());
        options.bootstrap = Bootstrap {
            realisations: 41,
            seed: 9,
            tallest,
        };
        let found = run(&options);
        let drawn: Vec<_> = (0..41).map(|k| found.realisation(k).unwrap()).collect();
        for (e, element) in found.elements.iter().enumerate() {
            let u = &element.curves.interference;
            let curves: Vec<_> = drawn
                .iter()
                .map(|r| traction_curves(&r[e], steel(), options.tangential, u).unwrap())
                .collect();
            let bands = element.bands.as_ref().unwrap();
            for k in 0..u.len() {
                let mut values: Vec<f64> = curves.iter().map(|c| c.normal[k]).collect();
                values.sort_by(f64::total_cmp);
                // With 41 of them the 2.5 and 97.5 percentiles are the second and the last but one.
                for (band, value) in [(bands.normal[0][k], values[1]), (bands.normal[1][k], values[39])] {
                    assert!((band - value).abs() <= 1e-12 * value, "{band} {value}");
                }
            }
        }
        // What stays and what is drawn.
        let (measured, realisation) = (&found.elements[2].population, &drawn[3][2]);
        assert_eq!(
            (measured.count(), measured.radius(), measured.area()),
            (realisation.count(), realisation.radius(), realisation.area())
        );
        assert_ne!(measured.heights(), realisation.heights());
        assert!(realisation.heights().iter().all(|z| measured.heights().contains(z)));
        let fixed = tallest == TallestPeak::Fixed;
        assert_eq!(realisation.heights().len() == measured.heights().len(), fixed);
        for r in &drawn {
            let contact = if fixed {
                measured.contact_height()
            } else {
                r[2].heights()[0]
            };
            assert_eq!(r[2].contact_height(), contact);
            // The laws' sums see the same population, gaps and all.
            let law = AsperitySumCurves::try_new(r[2].law_population().unwrap(), steel(), options.tangential).unwrap();
            let own = traction_curves(&r[2], steel(), options.tangential, &[2e-6])
                .unwrap()
                .normal[0];
            assert!((law.normal(2e-6).0 - own).abs() <= 1e-12 * own);
        }
        let without = drawn
            .iter()
            .filter(|r| r[2].heights()[0] < measured.heights()[0])
            .count();
        println!("{tallest:?}: {without} of 41 realisations lack the tallest peak");
        // (1 - 1/n)^n = 0.37 of the ordinary draws, about 1 - n^(-0.2) of the smaller ones.
        assert!(without >= 6 && (!fixed || without <= 25), "{without}");
        assert_eq!(drawn[7], run(&options).realisation(7).unwrap());
        assert_ne!(drawn[7], drawn[8]);
    }
}

#[test]
fn a_registration_moves_the_gap_and_is_recorded() {
    let mut options = Options::new(steel());
    options.bootstrap.realisations = 0;
    let still = run(&options);
    options.registration.tilt = [1e-3, -5e-4];
    let tilted = run(&options);
    assert_eq!(tilted.options.registration, options.registration);
    for (a, b) in still.elements.iter().zip(&tilted.elements) {
        // Roughness, peaks and laws are measured from each element's own form, which takes the tilt along.
        assert!((a.faces[1].areal.sq / b.faces[1].areal.sq - 1.0).abs() < 1e-9);
        assert_eq!(a.faces[1].peaks, b.faces[1].peaks);
        for (q, tilt) in [1e-3, -5e-4].into_iter().enumerate() {
            let slope = |e: &surface_characterisation::ElementSurface| e.gap.coefficients[1 + q] / e.gap.half_width[q];
            assert!((slope(b) - slope(a) + tilt).abs() < 1e-9);
        }
    }
    // A shift by whole steps is the same as a scan that was moved.
    options.registration = Registration {
        shift: [60e-6, -100e-6],
        tilt: [0.0; 2],
    };
    let shifted = run(&options);
    let moved = face(6).shifted([60e-6, -100e-6]).unwrap();
    options.registration = Registration::default();
    let expected = characterise(&face(5), &moved, &elements(), &options).unwrap();
    assert_eq!(shifted.elements, expected.elements);
    options.registration.tilt[1] = f64::NAN;
    assert!(characterise(&face(5), &face(6), &elements(), &options).is_err());
}

#[test]
fn noise_is_left_alone_unless_asked_for() {
    let clean = face(5);
    let mut heights: Vec<f64> = (0..170 * 130)
        .map(|k| clean.height(k % 170, k / 170).unwrap())
        .collect();
    for k in [3000, 9050, 15_000] {
        heights[k] += 40e-6;
    }
    let dusty = HeightMap::try_new(170, 130, clean.step(), clean.origin(), heights)
        .unwrap()
        .with_height_step(0.1e-6)
        .unwrap();
    let mut options = Options {
        detrend: Detrend::WholeFace,
        ..Options::new(steel())
    };
    let run = |top: &HeightMap, options: &Options| characterise(top, &face(6), &elements(), options).unwrap();
    let raw = run(&dusty, &options);
    assert_eq!(
        (raw.faces[0].outliers, raw.options.noise),
        (0, NoiseHandling::default())
    );
    assert!(raw.faces[0].areal.sz > 40e-6);
    options.noise.outliers = Some(OutlierRule::default());
    let cleaned = run(&dusty, &options);
    assert_eq!(cleaned.faces[0].outliers, 3);
    assert_eq!(cleaned.options.noise, options.noise);
    assert_eq!(cleaned.faces[0].points + 3, raw.faces[0].points);
    assert!((cleaned.faces[0].areal.sq / run(&clean, &options).faces[0].areal.sq - 1.0).abs() < 1e-3);
    // Short waves gone: lower, smoother, fewer and blunter peaks.
    options.noise.s_filter = Some(200e-6);
    let smooth = run(&dusty, &options);
    for (s, c) in smooth.elements.iter().zip(&cleaned.elements) {
        assert!(s.faces[0].areal.sdq < c.faces[0].areal.sdq);
        assert!(s.faces[0].peaks[0] < c.faces[0].peaks[0]);
        assert!(s.population.effective_radius() > c.population.effective_radius());
    }
}

/// For tables, heights between which the ranks differ little count as one piece: what that costs, on 4000 heights, of
/// which a realisation draws some repeatedly.
#[test]
fn interpolated_heights_carry_what_their_samples_do() {
    let element = &run(&Options::new(steel())).elements[1];
    let base = element.population.heights();
    // The heights of an element between one another's, until there are enough of them.
    let heights: Vec<f64> = (0..4000)
        .map(|k| {
            let position = (base.len() - 1) as f64 * f64::from(k) / 3999.0;
            let below = (position as usize).min(base.len() - 2);
            base[below] + (position - below as f64) * (base[below + 1] - base[below])
        })
        .collect();
    let many = PairAsperities::try_new(1e-6, 100.0, [1e-3; 2], 1e-3, heights).unwrap();
    let redrawn = realisation(&many, Bootstrap::default(), 0, 3).unwrap();
    let curves = |population| AsperitySumCurves::try_new(population, steel(), Default::default()).unwrap();
    let worst = |a: &AsperitySumCurves, b: &AsperitySumCurves, from: usize| {
        (from..40).fold(0.0_f64, |worst, k| {
            let u = 0.5e-6 * k as f64;
            let normal = (a.normal(u).0 / b.normal(u).0 - 1.0).abs();
            let tangential = a.tangential(u)[0].value / b.tangential(u)[0].value;
            worst.max(normal).max((tangential - 1.0).abs())
        })
    };
    let smooth = |pair: &PairAsperities| curves(pair.interpolated_population().unwrap());
    let all = curves(many.quantile_population(3999).unwrap());
    let left_out = worst(&smooth(&many), &all, 1);
    println!("against every order statistic: {left_out:.1e}");
    assert!(left_out < 1e-3, "{left_out}");
    for (name, pair) in [("sample", &many), ("realisation", &redrawn)] {
        let (pair, _) = pair.from_own_tallest();
        let found = worst(&smooth(&pair), &curves(pair.law_population().unwrap()), 6);
        println!("{name} against its single heights from 3 um: {found:.1e}");
        assert!(found < 2e-2, "{name}: {found:?}");
    }
    let again = many.interpolated_population().unwrap();
    assert_eq!(again, many.from_own_tallest().0.interpolated_population().unwrap());
}

#[test]
fn a_realisation_begins_at_its_own_tallest_height() {
    let found = run(&Options::new(steel()));
    let mut later = 0;
    for k in 0..20 {
        for pair in found.realisation(k).unwrap() {
            let (own, depth) = pair.from_own_tallest();
            assert_eq!(own.contact_height(), pair.heights()[0]);
            assert_eq!(depth, pair.contact_height() - pair.heights()[0]);
            assert_eq!(own.law_population().unwrap().gaps().smallest(), 0.0);
            later += usize::from(depth > 0.0);
        }
    }
    // 120 draws that miss the tallest with probability 0.37; four standard deviations.
    assert!((later as f64 - 44.0).abs() < 21.0, "{later}");
}
