//! Faces from drawings: what is synthesised, what theory expects of it, and how far the interval of the law holds.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use contact_laws::{AsperitySumCurves, ContactCurves, ElasticPair, TangentialReading};
use surface_characterisation::finish::{FaceFinish, LawInterval, PairFinish, Spectrum, Theory};
use surface_characterisation::{AsperityCount, InterferenceRange, Options};

fn steel() -> ElasticPair {
    ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    }
}

fn gaussian(rms: f64, lengths: [f64; 2], lay: f64, skewness: f64, kurtosis: f64) -> FaceFinish {
    FaceFinish::try_new(rms, skewness, kurtosis, Spectrum::Gaussian { lengths, lay }).unwrap()
}

fn pair(faces: [FaceFinish; 2], window: f64) -> PairFinish {
    PairFinish::try_new(faces, None, Some([window; 2]), 1.0).unwrap().0
}

/// Interferences from a tenth to five times an rms height.
fn interferences(rms: f64) -> Vec<f64> {
    InterferenceRange {
        from: 0.1 * rms,
        to: 5.0 * rms,
        points: 24,
    }
    .samples()
    .unwrap()
}

fn explore(name: &str, pair: &PairFinish, options: &Options) {
    let rms = pair.faces().iter().map(|f| f.rms()).fold(0.0, f64::max);
    let u = interferences(rms);
    let t0 = std::time::Instant::now();
    let elements = pair.characterised(1024, 1, options).unwrap();
    let t1 = t0.elapsed();
    let populations: Vec<_> = elements.iter().map(|e| e.population.law_population().unwrap()).collect();
    let median = LawInterval::try_new(&populations, steel(), TangentialReading::Mindlin, u.clone()).unwrap();
    let t0 = std::time::Instant::now();
    let theory = Theory::try_new(pair, options).unwrap();
    let t2 = t0.elapsed();
    let law = AsperitySumCurves::try_new(theory.population().unwrap(), steel(), TangentialReading::Mindlin).unwrap();
    let drawn = theory.realisations(1024, 1).unwrap();
    let fast = LawInterval::try_new(&drawn, steel(), TangentialReading::Mindlin, u.clone()).unwrap();
    let mean = |of: &dyn Fn(&surface_characterisation::ElementSurface) -> f64| elements.iter().map(of).sum::<f64>() / elements.len() as f64;
    println!("{name}: points {:?} ensemble {t1:?} theory {t2:?}", pair.window());
    println!("  Rt {:.3e} {:.3e}; density {:.4e} {:.4e}; rx {:.4e} {:.4e}; ry {:.4e} {:.4e}; zp {:.4e} {:.4e}; summits {:.1} {:.1}",
        mean(&|e| e.faces[0].total_roughness()), theory.total_roughness()[0],
        mean(&|e| e.population.asperity_density()), theory.asperity_density().unwrap(),
        mean(&|e| e.population.radius()[0]), theory.radii()[0],
        mean(&|e| e.population.radius()[1]), theory.radii()[1],
        mean(&|e| e.population.contact_height()), theory.contact_height(),
        mean(&|e| (e.faces[0].summits + e.faces[1].summits) as f64), theory.summits().iter().sum::<f64>());
    for (k, u) in u.iter().enumerate().step_by(3) {
        println!("  u/rms {:.2}: law/median tn {:.3} kn {:.3}; ens [{:.3} {:.3}] fast [{:.3} {:.3} {:.3}]", u / rms,
            law.normal(*u).0 / median.normal[1][k], law.normal(*u).1 / median.normal_stiffness[1][k],
            median.normal[0][k] / median.normal[1][k], median.normal[2][k] / median.normal[1][k],
            fast.normal[0][k] / median.normal[1][k], fast.normal[1][k] / median.normal[1][k], fast.normal[2][k] / median.normal[1][k]);
    }
}

#[test]
fn exploration() {
    let base = Options::new(steel());
    let iso = gaussian(1e-6, [1e-4; 2], 0.0, 0.0, 3.0);
    explore("isotropic", &pair([iso.clone(), iso.clone()], 2.4e-3), &base);
    explore("isotropic, summits", &pair([iso.clone(), iso.clone()], 2.4e-3), &Options { count: AsperityCount::Summits, ..base });
    explore("small window", &pair([iso.clone(), iso.clone()], 1.0e-3), &base);
    let rough = gaussian(2.5e-6, [1.5e-4; 2], 0.0, 0.0, 3.0);
    explore("unequal", &pair([iso.clone(), rough.clone()], 2.4e-3), &base);
    let lay = gaussian(1e-6, [3e-4, 0.6e-4], 0.0, 0.0, 3.0);
    explore("lay", &pair([lay.clone(), lay.clone()], 2.4e-3), &base);
    let skew = gaussian(1e-6, [1e-4; 2], 0.0, -0.8, 4.0);
    explore("skew", &pair([skew.clone(), skew.clone()], 2.4e-3), &base);
    let power = FaceFinish::try_new(1e-6, 0.0, 3.0, Spectrum::PowerLaw { hurst: 0.8, rolloff: 4e-4, cutoff: 6e-5 }).unwrap();
    explore("power law", &pair([power.clone(), power.clone()], 2.4e-3), &base);
}
