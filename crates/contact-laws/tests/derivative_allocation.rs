//! The derivative along a direction allocates nothing.
#![expect(clippy::unwrap_used, reason = "parameters are valid")]

use contact_laws::*;
use test_support::memory::{self, Counting};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const N: usize = 100;

fn laws() -> Vec<Box<dyn TractionLaw>> {
    let mu = || PointParameters::uniform(0.2, N);
    let curves = || PointParameters::uniform(ElasticCurves::try_new(2e12, [1.5e12; 2]).unwrap(), N);
    let steel = Yield {
        strength: 330e6,
        tangent_modulus: 620e6,
        curves: YieldCurves::Continuous,
    };
    let asperity = Asperity::try_new(ElasticPair::new(192e9, 0.3), 1e-3, Some(steel)).unwrap();
    let bins = AsperityBins::try_new(asperity, vec![0.0, 1e-6], vec![1e6; 2]).unwrap();
    let resolved = |friction, cone| {
        let bins = PointParameters::uniform(bins.clone(), N);
        ResolvedLaw::try_new(bins, mu(), friction, cone).unwrap()
    };
    let static_point = StaticPoint {
        jump: [0.0, 0.0, 1e-6],
        traction: [0.0, 0.0, 2e6],
        stiffness: [1.5e12, 1.5e12, 2e12],
        slip_limit: 4e5,
    };
    let friction = FrictionalLaw::try_new(curves(), mu(), HistoryRule::Potential).unwrap();
    vec![
        Box::new(friction.clone()),
        Box::new(friction.with_cone(Cone::Box)),
        Box::new(FoundationLaw::of_curves(curves(), mu(), 0.8, 8, 1e-5).unwrap()),
        Box::new(LinearisedContact::try_new(vec![Some(static_point); N]).unwrap()),
        Box::new(resolved(
            AsperityFriction::StickSlip(HistoryRule::Incremental),
            Cone::Box,
        )),
        Box::new(resolved(
            AsperityFriction::Annuli(HistoryRule::EndPoint, 3),
            Cone::Circle,
        )),
        Box::new(resolved(
            AsperityFriction::MindlinIwan(Radii::equally_spaced(9).unwrap()),
            Cone::Circle,
        )),
    ]
}

#[test]
fn derivatives_do_not_allocate() {
    let (laws, made) = memory::blocks(laws);
    assert!(made > laws.len(), "the count counts");
    for law in &laws {
        let n_state = law.info().n_state();
        let (jump, begin) = (vec![2e-6; N], vec![1e-7; n_state * N]);
        let [mut end, mut d_end] = [vec![0.0; n_state * N], vec![0.0; n_state * N]];
        let mut out = vec![0.0; 6 * N];
        let ((), allocated) = memory::blocks(|| {
            for n in [N, 1] {
                let mut rows = out.chunks_exact_mut(N).map(|row| &mut row[..n]);
                let [x, y, z, d_x, d_y, d_z] = std::array::from_fn(|_| rows.next().unwrap());
                let components = || Components::new(&jump[..n], &jump[..n], &jump[..n]);
                let counts = law.derivative(
                    0..n,
                    Sticking::Coulomb,
                    components(),
                    StateView::new(&begin, N, 0),
                    components(),
                    StateView::new(&begin, N, 0),
                    StateViewMut::new(&mut end, N, 0),
                    StateViewMut::new(&mut d_end, N, 0),
                    ComponentsMut::new(x, y, z),
                    ComponentsMut::new(d_x, d_y, d_z),
                );
                assert_eq!(counts.stick + counts.slip, n);
            }
        });
        assert_eq!(allocated, 0, "{}", law.info().name);
    }
}
