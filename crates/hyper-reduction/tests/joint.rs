//! A small joint: few points that are all points change nothing, and what was learned gives the loops that it was learned from.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use contact_laws::{ElasticCurves, FrictionalLaw, HistoryRule, PointParameters, RegimeCounts, Sticking, TractionLaw};
use cqsma_solver::cqsma::{self, Settings as Loops};
use cqsma_solver::{HystereticForce, Linearisation, LoopResult, NewtonSettings, PatternView, modes, prestress};
use dense_algebra::scattered;
use faer::Mat;
use hyper_reduction::{
    Error, HyperReducedJoint, JudgedLoop, PointForce, Recorder, SelectedPoints, Settings, StaticState, Trained,
    TrainingMode, train,
};
use std::sync::Arc;
use zte_assembly::{Element, Interface, InterfaceMesh, Operators, State, Workspace};

const NODES: [usize; 2] = [7, 3];

/// Modal forces at which nothing, something and much slips (sqrt(kg) m/s^2).
const FORCES: [f64; 3] = [50.0, 6e2, 1.1e3];

struct Contact(Interface);

impl HystereticForce for Contact {
    type State = State;
    type Workspace = Workspace;

    fn n_dofs(&self) -> usize {
        self.0.n_dofs()
    }

    fn pattern(&self) -> PatternView<'_> {
        let pattern = self.0.pattern();
        PatternView {
            indptr: &pattern.indptr,
            indices: &pattern.indices,
        }
    }

    fn initial_state(&self) -> State {
        self.0.initial_state()
    }

    fn workspace(&self) -> Workspace {
        self.0.workspace()
    }

    fn evaluate(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &State,
        end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        self.0.evaluate(u, sticking, begin, end, workspace, force, tangent)
    }
}

/// A strip of quadrilaterals between two rows of springs, with one more coordinate that shears it.
struct Strip {
    contact: Contact,
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    load: Vec<f64>,
}

impl Strip {
    fn new(mu: f64) -> Self {
        let [nx, ny] = NODES;
        let nodes = (0..nx * ny).map(|k| [0.01 * (k % nx) as f64, 0.01 * (k / nx) as f64]);
        let corner = |i: usize, j: usize| (i + nx * j) as u32;
        let elements = (0..(nx - 1) * (ny - 1)).map(|k| {
            let (i, j) = (k % (nx - 1), k / (nx - 1));
            Element::quad4([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)])
        });
        let mesh = InterfaceMesh::flat(nodes.collect(), elements.collect());
        let operators = Arc::new(Operators::try_new(&mesh, 2).unwrap());
        let n = operators.n_points();
        let curves = PointParameters::uniform(ElasticCurves::try_new(3e11, [2e11, 1e11]).unwrap(), n);
        let law = FrictionalLaw::try_new(curves, PointParameters::uniform(mu, n), HistoryRule::Incremental).unwrap();
        let laws: Vec<(_, Arc<dyn TractionLaw>)> = vec![(0..n, Arc::new(law))];
        let contact = Contact(Interface::try_new(operators, laws, vec![0.0; n]).unwrap());
        // Neighbours are tied to each other, and the ends to the last coordinate.
        let size = 3 * nx * ny + 1;
        let mut stiffness = Mat::zeros(size, size);
        let mut tie = |a: usize, b: usize, k: f64| {
            for (i, j, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                stiffness[(i, j)] += sign * k;
            }
        };
        for k in 0..nx * ny {
            for c in 0..3 {
                if k % nx + 1 < nx {
                    tie(3 * k + c, 3 * (k + 1) + c, 4e7);
                }
                if k / nx + 1 < ny {
                    tie(3 * k + c, 3 * (k + nx) + c, 4e7);
                }
            }
            if k % nx == 0 {
                tie(3 * k, size - 1, 1e7);
            }
        }
        let mass = Mat::from_fn(size, size, |i, j| match (i == j, i + 1 == size) {
            (true, true) => 2.0,
            (true, false) => 1e-3,
            _ => 0.0,
        });
        let load = (0..size).map(|i| if i % 3 == 2 && i + 1 < size { 300.0 } else { 0.0 });
        Self {
            contact,
            stiffness,
            mass,
            load: load.collect(),
        }
    }

    fn linearised(&self) -> Linearisation<'_, State> {
        let start: Vec<f64> = (0..self.load.len())
            .map(|i| {
                if i % 3 == 2 && i + 1 < self.load.len() {
                    1e-5
                } else {
                    0.0
                }
            })
            .collect();
        let newton = NewtonSettings::default();
        let found = prestress::solve(self.stiffness.as_ref(), &self.contact, &self.load, &start, &newton);
        let found = found.unwrap().unwrap();
        let (stiffness, mass) = (self.stiffness.as_ref(), self.mass.as_ref());
        modes::linearise(stiffness, mass, &self.contact, found.displacement, found.state, 1).unwrap()
    }

    fn training_case(&self, forces: &[f64]) -> (Vec<LoopResult>, TrainingMode) {
        let line = self.linearised();
        let at_rest = StaticState::new(&self.contact.0, &line);
        let observer = |_| Recorder::new(&self.contact.0, &at_rest, Loops::default().vertices_per_quarter);
        let found = cqsma::run(&line, &self.contact, forces, &Loops::default(), observer).unwrap();
        let (mut results, mut records) = (Vec::new(), Vec::new());
        for (point, own) in found {
            let result = point.result.unwrap();
            if result.is_resolved() {
                records.push(own.finish());
            }
            results.push(result);
        }
        let quiet = results.len() - records.len();
        (
            results,
            TrainingMode::try_new(&line, at_rest.clone(), 0, records, quiet).unwrap(),
        )
    }

    fn train(&self, forces: &[f64], settings: &Settings) -> Result<Trained, Error> {
        train(
            &self.contact.0,
            self.stiffness.as_ref(),
            &[self.training_case(forces).1],
            settings,
        )
    }

    fn by_few(&self, trained: &Trained, forces: &[f64]) -> Vec<JudgedLoop> {
        let line = self.linearised();
        let joint = HyperReducedJoint::try_new(&self.contact.0, &line, 0, trained).unwrap();
        let mut response = vec![0.0; self.load.len()];
        response[self.load.len() - 1] = 1.0;
        joint.run(forces, &Loops::default(), &response).unwrap()
    }
}

#[test]
fn all_points_with_their_own_areas_are_the_interface() {
    let strip = Strip::new(0.3);
    let (line, contact) = (strip.linearised(), &strip.contact);
    let (n, points) = (contact.n_dofs(), contact.0.operators().n_points());
    let basis = scattered(strip.load.len(), 9);
    let all = SelectedPoints {
        points: (0..points).collect(),
        factors: vec![1.0; points],
    };
    let at_rest = &line.displacement()[..n];
    let few = PointForce::new(
        &contact.0,
        &all,
        basis.as_ref(),
        at_rest,
        line.state(),
        line.stuck_tangent(),
    );
    // Far enough that points slip, and back.
    let (mut state, mut end) = (line.state().clone(), line.state().clone());
    let (mut own_state, mut own_end) = (few.state(), few.state());
    let mut slipped = 0;
    for size in [1e-5, -2e-5, 5e-6] {
        let y: Vec<f64> = (0..9).map(|k| size * f64::from(3 - k % 5)).collect();
        let u: Vec<f64> = (0..n)
            .map(|i| at_rest[i] + (0..9).map(|k| basis[(i, k)] * y[k]).sum::<f64>())
            .collect();
        let mut force = vec![0.0; n];
        let mut tangent = vec![0.0; contact.pattern().indices.len()];
        let counts = contact.evaluate(
            &u,
            Sticking::Coulomb,
            &state,
            &mut end,
            &mut contact.workspace(),
            &mut force,
            Some(&mut tangent),
        );
        let (mut own, mut own_tangent) = (vec![0.0; 9], vec![0.0; 81]);
        let own_counts = few.evaluate(
            &y,
            Sticking::Coulomb,
            &own_state,
            &mut own_end,
            &mut few.workspace(),
            &mut own,
            Some(&mut own_tangent),
        );
        assert_eq!(counts, own_counts);
        slipped += counts.slip;
        let column = |k: usize| -> Vec<f64> { (0..n).map(|i| basis[(i, k)]).collect() };
        let scale = force.iter().map(|f| f.abs()).sum::<f64>();
        for k in 0..9 {
            let expected: f64 = column(k).iter().zip(&force).map(|(w, f)| w * f).sum();
            assert!((own[k] - expected).abs() < 1e-12 * scale, "{k}: {} {expected}", own[k]);
            let mut image = vec![0.0; n];
            contact.pattern().add_product(&tangent, &column(k), &mut image);
            for j in 0..9 {
                let expected: f64 = column(j).iter().zip(&image).map(|(w, f)| w * f).sum();
                let largest = image.iter().map(|f| f.abs()).sum::<f64>();
                assert!((own_tangent[9 * j + k] - expected).abs() < 1e-12 * largest, "{j} {k}");
            }
        }
        std::mem::swap(&mut state, &mut end);
        std::mem::swap(&mut own_state, &mut own_end);
    }
    assert!(slipped > 10, "{slipped}");
}

#[test]
fn what_was_learned_gives_the_loops_that_it_was_learned_from() {
    let strip = Strip::new(0.3);
    let (whole, _) = strip.training_case(&FORCES);
    // The smallest loop sticks; the others slip here and there.
    assert!(!whole[0].is_resolved() && whole[1].zeta > 1e-3 && whole[2].zeta > whole[1].zeta);
    let points = strip.contact.0.operators().n_points();
    let exact = Settings {
        motion_tolerance: 1e-8,
        work_tolerance: 1e-7,
        most_points: 1.0,
    };
    let trained = strip.train(&FORCES, &exact).unwrap();
    assert_eq!((trained.loops, trained.of_points), (2, points));
    for (found, whole) in strip.by_few(&trained, &FORCES).iter().zip(&whole) {
        let result = found.point.result.as_ref().unwrap();
        assert!((result.omega / whole.omega - 1.0).abs() < 1e-7);
        assert!((found.response_motion / (whole.modal_amplitude * 0.5_f64.sqrt()) - 1.0).abs() < 0.1);
        let estimate = found.estimate.unwrap();
        // The floors.
        assert!((1e-4..2e-4).contains(&estimate.frequency), "{estimate:?}");
        assert_eq!(estimate.damping.is_some(), whole.is_resolved());
        if whole.is_resolved() {
            assert!(
                (result.zeta / whole.zeta - 1.0).abs() < 1e-6,
                "{} {}",
                result.zeta,
                whole.zeta
            );
            assert!(estimate.damping.unwrap() < 1e-2, "{estimate:?}");
        }
    }
}

#[test]
fn fewer_points_give_other_friction_within_the_estimates() {
    let taught = Strip::new(0.3);
    let settings = Settings {
        most_points: 1.0,
        ..Settings::default()
    };
    let trained = taught.train(&FORCES, &settings).unwrap();
    assert!(trained.points.points.len() < trained.of_points);
    let other = Strip::new(0.25);
    let (whole, _) = other.training_case(&FORCES);
    let mut worst = 0.0_f64;
    for (found, whole) in other.by_few(&trained, &FORCES).iter().zip(&whole) {
        let result = found.point.result.as_ref().unwrap();
        let estimate = found.estimate.unwrap();
        assert!((result.omega / whole.omega - 1.0).abs() <= estimate.frequency);
        if let Some(damping) = estimate.damping {
            let error = (result.zeta / whole.zeta - 1.0).abs();
            // Estimates are no bounds.
            assert!(error <= 2.0 * damping, "{error} {damping}");
            worst = worst.max(error);
        }
    }
    assert!(worst > 1e-6, "{worst}");
}

#[test]
fn what_teaches_nothing_or_belongs_to_another_joint_is_refused() {
    let strip = Strip::new(0.3);
    let nothing = strip.train(&FORCES[..1], &Settings::default());
    assert!(matches!(nothing, Err(Error::NothingSlips { loops: 1 })));
    let narrow = Settings {
        most_points: 0.02,
        ..Settings::default()
    };
    let few = strip.train(&FORCES, &narrow).unwrap_err();
    assert!(matches!(few, Error::TooFewPoints { points: 0, of: 48, .. }), "{few}");
    let settings = Settings {
        most_points: 1.0,
        ..Settings::default()
    };
    let trained = strip.train(&FORCES, &settings).unwrap();
    let line = strip.linearised();
    let other = Trained {
        of_points: 12,
        ..trained.clone()
    };
    let joint = HyperReducedJoint::try_new(&strip.contact.0, &line, 0, &other);
    assert!(matches!(
        joint.err(),
        Some(
            Error::Size {
                found: 48,
                expected: 12,
                ..
            } | Error::Size {
                found: 12,
                expected: 48,
                ..
            }
        )
    ));
    let joint = HyperReducedJoint::try_new(&strip.contact.0, &line, 1, &trained);
    assert!(matches!(
        joint.err(),
        Some(Error::Size {
            what: "the list of modes",
            ..
        })
    ));
}
