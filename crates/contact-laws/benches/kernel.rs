//! Time per batch of 15 000 points: kind of curves, with and without tangent, mix of regimes.

use std::hint::black_box;

use contact_laws::*;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

const N: usize = 15_000;

/// Points whose regime is stick, slip or open by turns in the given proportions.
struct Batch {
    jump: [Vec<f64>; 3],
    begin: Vec<f64>,
    end: Vec<f64>,
    traction: [Vec<f64>; 3],
    tangent: Vec<Vec<f64>>,
}

impl Batch {
    fn new(stick: usize, slip: usize, open: usize) -> Self {
        let (mut jump, mut begin) = ([vec![0.0; N], vec![0.0; N], vec![0.0; N]], vec![0.0; 5 * N]);
        for i in 0..N {
            // A multiplicative generator spreads the regimes so that branches cannot be predicted.
            let turn = (i * 7919) % (stick + slip + open);
            let wave = (i as f64 * 0.61).sin();
            let u_n = 5e-6 * (1.0 + 0.8 * wave);
            let (u_x, u_n) = if turn < stick {
                (1e-11, u_n)
            } else if turn < stick + slip {
                (1e-4, u_n)
            } else {
                (1e-6, -u_n)
            };
            (jump[0][i], jump[1][i], jump[2][i]) = (u_x, 0.3 * u_x, u_n);
            begin[2 * N + i] = 0.9 * u_n;
        }
        let column = || vec![0.0; N];
        Self {
            jump,
            begin,
            end: vec![0.0; 5 * N],
            traction: [column(), column(), column()],
            tangent: vec![column(); 9],
        }
    }

    fn evaluate(&mut self, law: &dyn TractionLaw, with_tangent: bool) -> RegimeCounts {
        let [x, y, n] = &mut self.traction;
        let tangent = match self.tangent.as_mut_slice() {
            [xx, xy, xn, yx, yy, yn, nx, ny, nn] if with_tangent => Some(TangentMut {
                xx,
                xy,
                xn,
                yx,
                yy,
                yn,
                nx,
                ny,
                nn,
            }),
            _ => None,
        };
        law.evaluate(
            0..N,
            Sticking::Coulomb,
            Components {
                x: &self.jump[0],
                y: &self.jump[1],
                n: &self.jump[2],
            },
            StateView {
                data: &self.begin,
                stride: N,
                offset: 0,
            },
            StateViewMut {
                data: &mut self.end,
                stride: N,
                offset: 0,
            },
            ComponentsMut { x, y, n },
            tangent,
            None,
        )
    }
}

fn curves() -> Result<(FittedCurves, AsperitySumCurves, Tabulated<AsperitySumCurves>), Error> {
    let range = Some([1e-8, 1e-4]);
    let normal = NormalFit {
        a: 15.0,
        b: 2.2,
        c: -0.9,
        d: 0.3,
        e: 0.9,
        u_ref: 1e-6,
        t_ref: 1.0,
        range,
    };
    let ends = TangentialEnds::Mindlin;
    let tangential = TangentialFit {
        a: 28.0,
        b: 1.4,
        c: 0.3,
        d: 0.6,
        u_ref: 1e-6,
        k_ref: 1.0,
        range,
        ends,
    };
    let fitted = FittedCurves::try_new(normal, [tangential, TangentialFit { a: 28.1, ..tangential }])?;

    let probabilities: Vec<f64> = (0..=200).map(|i| f64::from(i) / 200.0).collect();
    let gaps: Vec<f64> = probabilities
        .iter()
        .map(|p| 28e-6 * (0.35 * p.powf(0.4) + 0.3 * p.powi(6)))
        .collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &gaps)?;
    let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.4e-3; 2])?;
    let steel = ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    };
    let direct = AsperitySumCurves::try_new(population, steel, TangentialReading::Mindlin)?;
    let table = Tabulated::try_new(direct.clone(), [1e-8, 1e-4], TableOptions::default())?;
    Ok((fitted, direct, table))
}

fn law<C: ContactCurves + 'static>(curves: C) -> Result<Box<dyn TractionLaw>, Error> {
    let mu = PointParameters::uniform(0.2, N);
    Ok(Box::new(FrictionalLaw::try_new(
        PointParameters::uniform(curves, N),
        mu,
        HistoryRule::Incremental,
    )?))
}

fn kernel(criterion: &mut Criterion) {
    let laws = curves().and_then(|(fitted, direct, table)| {
        let elastic = ElasticCurves::try_new(2e12, [1.5e12; 2])?;
        Ok([
            ("fitted", law(fitted)?),
            ("table", law(table)?),
            ("direct", law(direct)?),
            ("elastic", law(elastic)?),
        ])
    });
    let laws = laws.unwrap_or_else(|error| panic!("{error}"));
    let mut group = criterion.benchmark_group("kernel");
    group.throughput(Throughput::Elements(N as u64)).sample_size(20);
    for (mix, [stick, slip, open]) in [
        ("stick", [1, 0, 0]),
        ("slip", [0, 1, 0]),
        ("mixed", [5, 3, 2]),
        ("open", [0, 0, 1]),
    ] {
        let mut batch = Batch::new(stick, slip, open);
        for (name, law) in &laws {
            let counts = batch.evaluate(&**law, true);
            let expected = [stick, slip, open].map(|n| n > 0);
            assert_eq!(
                [counts.stick, counts.slip, counts.open].map(|n| n > 0),
                expected,
                "{name} {mix}: {counts:?}"
            );
            for (label, tangent) in [("traction", false), ("tangent", true)] {
                group.bench_function(BenchmarkId::new(format!("{name}/{label}"), mix), |b| {
                    b.iter(|| black_box(batch.evaluate(&**law, tangent)));
                });
            }
        }
    }
    group.finish();
}

criterion_group!(benches, kernel);
criterion_main!(benches);
