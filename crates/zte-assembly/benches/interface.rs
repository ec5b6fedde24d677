//! Time of one interface evaluation against that of its traction law alone on the same jumps and history.
#![expect(clippy::unwrap_used, reason = "bench")]

use std::hint::black_box;
use std::sync::Arc;

use contact_laws::{
    Components, ComponentsMut, FittedCurves, FittedPoints, FrictionalLaw, HistoryRule, NormalFit, PointParameters,
    RegimeCounts, StateView, StateViewMut, Sticking, TangentMut, TangentialEnds, TangentialFit, TractionLaw,
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use zte_assembly::{Element, Interface, InterfaceMesh, Operators};

/// As many elements as the interface of the Brake-Reuss beam has.
const ELEMENTS: [u32; 2] = [49, 12];

fn mesh() -> InterfaceMesh {
    let [nx, ny] = ELEMENTS;
    let node = |i: u32, j: u32| i + (nx + 1) * j;
    let place = |i: u32, n: u32, length: f64| length * f64::from(i) / f64::from(n);
    InterfaceMesh::flat(
        (0..=ny)
            .flat_map(|j| (0..=nx).map(move |i| [place(i, nx, 0.12), place(j, ny, 0.0254)]))
            .collect(),
        (0..ny)
            .flat_map(|j| (0..nx).map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]))
            .map(Element::quad4)
            .collect(),
    )
}

/// Fitted curves that differ from point to point, Coulomb friction.
fn law(n: usize) -> Arc<dyn TractionLaw> {
    let curves = (0..n).map(|i| {
        let vary = 1.0 + 0.1 * (0.37 * i as f64).sin();
        let range = Some([1e-7, 1e-4]);
        let normal = NormalFit {
            a: 15.2,
            b: 2.2 * vary,
            c: -0.4,
            d: 0.3,
            e: 1.1,
            u_ref: 1e-6,
            t_ref: 1.0,
            range,
        };
        let tangential = TangentialFit {
            a: 28.0,
            b: 1.4 * vary,
            c: 0.3,
            d: 0.6,
            u_ref: 1e-6,
            k_ref: 1.0,
            range,
            ends: TangentialEnds::Mindlin,
        };
        FittedCurves::try_new(normal, [tangential; 2]).unwrap()
    });
    let curves = FittedPoints::<f64>::new(&PointParameters::per_point(curves.collect()));
    Arc::new(FrictionalLaw::try_new(curves, PointParameters::uniform(0.2, n), HistoryRule::Incremental).unwrap())
}

/// Nodal jumps with interferences of 1 to 9 um and tangential motion up to `amplitude` (m).
fn jumps(n_dofs: usize, amplitude: f64) -> Vec<f64> {
    (0..n_dofs)
        .map(|i| {
            let node = (i / 3) as f64;
            match i % 3 {
                0 => amplitude * (0.37 * node).sin(),
                1 => 0.3 * amplitude * (0.23 * node).sin(),
                _ => 5e-6 * (1.0 + 0.8 * (0.61 * node).sin()),
            }
        })
        .collect()
}

/// The law without an interface around it.
struct Alone {
    law: Arc<dyn TractionLaw>,
    begin: Vec<f64>,
    end: Vec<f64>,
    traction: [Vec<f64>; 3],
    tangent: [Vec<f64>; 9],
}

impl Alone {
    fn new(law: Arc<dyn TractionLaw>) -> Self {
        let n = law.len();
        let state = vec![0.0; n * law.info().n_state()];
        Self {
            law,
            begin: state.clone(),
            end: state,
            traction: std::array::from_fn(|_| vec![0.0; n]),
            tangent: std::array::from_fn(|_| vec![0.0; n]),
        }
    }

    fn evaluate(&mut self, [x, y, n]: &[Vec<f64>; 3], with_tangent: bool) -> RegimeCounts {
        let points = self.law.len();
        let [tx, ty, tn] = &mut self.traction;
        let tangent = TangentMut::from_entries(self.tangent.each_mut().map(Vec::as_mut_slice));
        self.law.evaluate(
            0..points,
            Sticking::Coulomb,
            Components::new(x, y, n),
            StateView::new(&self.begin, points, 0),
            StateViewMut::new(&mut self.end, points, 0),
            ComponentsMut::new(tx, ty, tn),
            with_tangent.then_some(tangent),
            None,
        )
    }
}

fn evaluations(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("interface");
    for per_direction in [2, 5] {
        let operators = Arc::new(Operators::try_new(&mesh(), per_direction).unwrap());
        let n = operators.n_points();
        let law = law(n);
        let interface = Interface::try_new(operators, vec![(0..n, law.clone())], vec![0.0; n]).unwrap();
        let mut points = interface.workspace();
        let mut force = vec![0.0; interface.n_dofs()];
        let mut values = vec![0.0; interface.pattern().indices.len()];
        let mut alone = Alone::new(law);

        // History of a closed joint, then a motion in which some points slip.
        let closed = jumps(interface.n_dofs(), 0.0);
        let moved = jumps(interface.n_dofs(), 4e-6);
        let rest = interface.initial_state();
        let (mut begin, mut end) = (rest.clone(), rest.clone());
        let coulomb = Sticking::Coulomb;
        interface.evaluate(&closed, coulomb, &rest, &mut begin, &mut points, &mut force, None);
        alone.evaluate(&points.jump, false);
        alone.begin.copy_from_slice(&alone.end);
        let counts = interface.evaluate(&moved, coulomb, &begin, &mut end, &mut points, &mut force, None);
        assert_eq!(alone.evaluate(&points.jump, false), counts);
        assert!(counts.stick > n / 10 && counts.slip > n / 10, "{counts:?}");

        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::new("law", n), |b| {
            b.iter(|| black_box(alone.evaluate(&points.jump, false)));
        });
        group.bench_function(BenchmarkId::new("evaluate", n), |b| {
            b.iter(|| {
                black_box(interface.evaluate(&moved, coulomb, &begin, &mut end, &mut points, &mut force, None));
            });
        });
        group.bench_function(BenchmarkId::new("law+tangent", n), |b| {
            b.iter(|| black_box(alone.evaluate(&points.jump, true)));
        });
        group.bench_function(BenchmarkId::new("evaluate+tangent", n), |b| {
            b.iter(|| {
                let tangent = Some(&mut values[..]);
                black_box(interface.evaluate(&moved, coulomb, &begin, &mut end, &mut points, &mut force, tangent));
            });
        });
    }
    group.finish();
}

criterion_group!(benches, evaluations);
criterion_main!(benches);
