//! What each reading of the method does to one synthetic pair, as ratios to the default readings, and what the
//! registration of its faces does to their gap.
#![allow(clippy::print_stdout)]

use contact_laws::{AsperitySumCurves, ContactCurves, ElasticPair, GreenwoodWilliamsonCurves, TangentialReading};
use surface_characterisation::{
    AsperityCount, Characterisation, ElementOutlines, HeightCombination, HeightFamily, Options, PackingHeight,
    PairAsperities, PairRadius, RadiusStatistic, Registration, SurfaceError, SyntheticFace, Waviness, characterise,
    registration_study, traction_curves,
};

/// One reading that differs from the default.
type Reading = (&'static str, fn(&mut Options));

const READINGS: [Reading; 8] = [
    ("defaults", |_| {}),
    ("radius: mean", |o| o.radius = RadiusStatistic::Mean),
    ("pair radius: eq. (6) literal", |o| {
        o.pair_radius = PairRadius::Eq6Literal
    }),
    ("height in w_q: mean peak", |o| {
        o.packing_height = PackingHeight::MeanPeak
    }),
    ("count: summits", |o| o.count = AsperityCount::Summits),
    ("heights: summed", |o| o.heights = HeightCombination::Summed),
    ("k_t: paper", |o| o.tangential = TangentialReading::Paper),
    ("mean, eq. (6) literal, k_t: paper", |o| {
        o.radius = RadiusStatistic::Mean;
        o.tangential = TangentialReading::Paper;
        o.pair_radius = PairRadius::Eq6Literal;
    }),
];

/// Geometric mean over the elements.
fn mean(c: &Characterisation, of: impl Fn(&surface_characterisation::ElementSurface) -> f64) -> f64 {
    (c.elements.iter().map(|e| of(e).ln()).sum::<f64>() / c.elements.len() as f64).exp()
}

fn main() -> Result<(), SurfaceError> {
    let face = |seed| {
        SyntheticFace {
            points: [1000, 508],
            step: [30e-6, 50e-6],
            origin: [15e-6, 25e-6],
            rms: 1.5e-6,
            correlation_length: [120e-6, 150e-6],
            waviness: vec![
                Waviness {
                    amplitude: 4e-6,
                    wavenumber: [1.0 / 60e-3, 0.0],
                    phase: 0.4,
                },
                Waviness {
                    amplitude: 1e-6,
                    wavenumber: [1.0 / 8e-3, 1.0 / 30e-3],
                    phase: 1.0,
                },
            ],
            tilt: [1e-4, -2e-4],
            height_step: Some(0.5e-6),
            seed,
        }
        .generate(|_| false)
    };
    let (top, bottom) = (face(1)?, face(2)?);
    // 12 x 10 elements of 2.5 mm x 2.54 mm.
    let nodes = (0..143)
        .map(|k| [f64::from(k % 13) * 2.5e-3, f64::from(k / 13) * 2.54e-3])
        .collect();
    let quads = (0..120u32)
        .map(|e| {
            let a = e / 12 * 13 + e % 12;
            vec![a, a + 1, a + 14, a + 13]
        })
        .collect();
    let elements = ElementOutlines::try_new(nodes, quads)?;
    let steel = ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    };

    // Normal traction and tangential stiffness at 5 um of interference; normal stiffness there by its log-slope.
    let mut default = None;
    println!("reading | N | R x | R y | R eff | t_n | k_n | k_t x | k_t y");
    for (name, change) in READINGS {
        let mut options = Options::new(steel);
        options.bootstrap.realisations = 0;
        change(&mut options);
        let c = characterise(&top, &bottom, &elements, &options)?;
        let u = &c.elements[0].curves.interference;
        let at = u.partition_point(|u| *u < 5e-6);
        let figures = [
            mean(&c, |e| e.population.count()),
            mean(&c, |e| e.population.radius()[0]),
            mean(&c, |e| e.population.radius()[1]),
            mean(&c, |e| e.population.effective_radius()),
            mean(&c, |e| e.curves.normal[at]),
            mean(&c, |e| {
                (e.curves.normal[at + 1] - e.curves.normal[at - 1]) / (u[at + 1] - u[at - 1])
            }),
            mean(&c, |e| e.curves.tangential[0][at]),
            mean(&c, |e| e.curves.tangential[1][at]),
        ];
        let base = *default.get_or_insert(figures);
        if name == "defaults" {
            println!("{name} | {}", figures.map(|f| format!("{f:.3e}")).join(" | "));
        } else {
            let ratios: Vec<String> = (0..8).map(|k| format!("{:.2}", figures[k] / base[k])).collect();
            println!("{name} | {}", ratios.join(" | "));
        }
    }

    println!("\nnormal traction by other forms of the heights, over that of the samples: 1 um | 5 um");
    let c = characterise(&top, &bottom, &elements, &Options::new(steel))?;
    let reading = TangentialReading::Mindlin;
    let over_sums = |of: &dyn Fn(&PairAsperities, f64) -> f64| {
        [1e-6, 5e-6].map(|u| {
            mean(&c, |e| {
                let sums = traction_curves(&e.population, steel, reading, &[u]);
                of(&e.population, u) / sums.map_or(f64::NAN, |c| c.normal[0])
            })
        })
    };
    for (name, family) in [
        ("exponential", HeightFamily::Exponential),
        ("Gaussian", HeightFamily::Gaussian),
    ] {
        let closed = |p: &PairAsperities, u: f64| {
            let curves = p
                .closed_form(family)
                .map(|s| GreenwoodWilliamsonCurves::try_new(s, steel, reading));
            curves.and_then(Result::ok).map_or(f64::NAN, |c| c.normal(u).0)
        };
        println!("{name} | {:.3?}", over_sums(&closed));
    }
    for levels in [10, 50, 200] {
        let quantiles = |p: &PairAsperities, u: f64| {
            let curves = p
                .quantile_population(levels)
                .and_then(|p| AsperitySumCurves::try_new(p, steel, reading));
            curves.map_or(f64::NAN, |c| c.normal(u).0)
        };
        println!("{levels} quantiles | {:.3?}", over_sums(&quantiles));
    }

    let shift = |x: f64, y: f64| Registration {
        shift: [x, y],
        ..Registration::default()
    };
    let tilt = |x: f64, y: f64| Registration {
        tilt: [x, y],
        ..Registration::default()
    };
    let cases = [
        shift(30e-6, 0.0),
        shift(0.0, 50e-6),
        shift(300e-6, 0.0),
        shift(0.0, 300e-6),
        shift(-600e-6, 0.0),
        tilt(1e-4, 0.0),
        tilt(0.0, 1e-4),
    ];
    println!("\nshift (um) | tilt (1e-4) | change of the gap: mean | rms about it | largest (um)");
    for change in registration_study(&top, &bottom, &elements, &Options::new(steel), &cases)? {
        let Registration { shift, tilt } = change.registration;
        println!(
            "{:.0}, {:.0} | {:.0}, {:.0} | {:+.2} | {:.2} | {:.2}",
            shift[0] * 1e6,
            shift[1] * 1e6,
            tilt[0] * 1e4,
            tilt[1] * 1e4,
            change.mean * 1e6,
            change.rms * 1e6,
            change.largest * 1e6
        );
    }
    Ok(())
}
