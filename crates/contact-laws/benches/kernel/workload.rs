//! Work to time laws with: batches of points in chosen regimes, and parameters that differ from point to point.

use contact_laws::*;

/// Jumps, begin states and memory for all that a law returns.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    jump: [Vec<f64>; 3],
    begin: Vec<f64>,
    end: Vec<f64>,
    traction: [Vec<f64>; 3],
    tangent: [Vec<f64>; 9],
    d_jump: [Vec<f64>; 3],
    d_begin: Vec<f64>,
    d_end: Vec<f64>,
}

impl Batch {
    /// `n` points that stick, slip or are open by turns in the proportions of `mix`, in an order that cannot be
    /// foreseen, with interferences from 1 to 9 um, for a law with `n_state` state components of which the first three
    /// are the jump.
    ///
    /// # Panics
    /// When the proportions sum to zero.
    pub(crate) fn new(n: usize, mix: [usize; 3], n_state: usize) -> Self {
        let [stick, slip, open] = mix;
        let mut jump = std::array::from_fn(|_| vec![0.0; n]);
        let mut begin = vec![0.0; n_state * n];
        for i in 0..n {
            let turn = (i * 7919) % (stick + slip + open);
            let u_n = 5e-6 * (1.0 + 0.8 * (i as f64 * 0.61).sin());
            let (u_x, u_n) = if turn < stick {
                (1e-11, u_n)
            } else if turn < stick + slip {
                (1e-4, u_n)
            } else {
                (1e-6, -u_n)
            };
            [jump[0][i], jump[1][i], jump[2][i]] = [u_x, 0.3 * u_x, u_n];
            begin[2 * n + i] = 0.9 * u_n;
        }
        Self {
            d_jump: jump.clone(),
            d_begin: begin.clone(),
            d_end: vec![0.0; n_state * n],
            jump,
            begin,
            end: vec![0.0; n_state * n],
            traction: std::array::from_fn(|_| vec![0.0; n]),
            tangent: std::array::from_fn(|_| vec![0.0; n]),
        }
    }

    /// Presses all points further than their jumps do, without tangential displacement, and commits.
    pub(crate) fn press<L: TractionLaw + ?Sized>(&mut self, law: &L) {
        let deep: Vec<f64> = self.jump[2].iter().map(|n| 1.1 * n).collect();
        let [x, y] = [0, 1].map(|q| std::mem::replace(&mut self.jump[q], vec![0.0; deep.len()]));
        let n = std::mem::replace(&mut self.jump[2], deep);
        self.evaluate(law, false);
        std::mem::swap(&mut self.begin, &mut self.end);
        self.jump = [x, y, n];
    }

    /// Evaluates all points.
    pub(crate) fn evaluate<L: TractionLaw + ?Sized>(&mut self, law: &L, with_tangent: bool) -> RegimeCounts {
        let n = self.jump[0].len();
        let [x, y, normal] = &mut self.traction;
        let tangent = TangentMut::from_entries(self.tangent.each_mut().map(Vec::as_mut_slice));
        law.evaluate(
            0..n,
            Sticking::Coulomb,
            Components::new(&self.jump[0], &self.jump[1], &self.jump[2]),
            StateView::new(&self.begin, n, 0),
            StateViewMut::new(&mut self.end, n, 0),
            ComponentsMut::new(x, y, normal),
            with_tangent.then_some(tangent),
            None,
        )
    }

    /// [`TractionLaw::derivative`] at all points, along the jumps and begin states that the batch was made with.
    pub(crate) fn derivative<L: TractionLaw + ?Sized>(&mut self, law: &L) -> RegimeCounts {
        let n = self.jump[0].len();
        let [x, y, normal] = &mut self.traction;
        let [d_x, d_y, d_n, ..] = &mut self.tangent;
        law.derivative(
            0..n,
            Sticking::Coulomb,
            Components::new(&self.jump[0], &self.jump[1], &self.jump[2]),
            StateView::new(&self.begin, n, 0),
            Components::new(&self.d_jump[0], &self.d_jump[1], &self.d_jump[2]),
            StateView::new(&self.d_begin, n, 0),
            StateViewMut::new(&mut self.end, n, 0),
            StateViewMut::new(&mut self.d_end, n, 0),
            ComponentsMut::new(x, y, normal),
            ComponentsMut::new(d_x, d_y, d_n),
        )
    }
}

/// A period of motion along the surface of some points, and memory for what a law answers.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    n: usize,
    jumps: Vec<f64>,
    state: Vec<f64>,
    room: Vec<f64>,
    traction: Vec<f64>,
}

impl Path {
    /// `n` points under interferences from 3 to 7 um that vary a little, moved by a sine of `steps` samples and `share` of what gross slip takes at a
    /// friction coefficient of 0.2.
    pub(crate) fn new<L: TractionLaw + ?Sized>(law: &L, n: usize, steps: usize, share: f64) -> Self {
        let u_n = |i: usize| 5e-6 * (1.0 + 0.4 * (i as f64 * 0.061).sin());
        let jumps = (0..steps).flat_map(|step| {
            let phase = std::f64::consts::TAU * step as f64 / steps as f64;
            let of = move |q: usize, i: usize| match q {
                0 => 0.25 * share * u_n(i) * phase.sin(),
                1 => 0.05 * share * u_n(i) * (2.0 * phase).cos(),
                _ => u_n(i) * (1.0 + 1e-3 * share * phase.cos()),
            };
            (0..3).flat_map(move |q| (0..n).map(move |i| of(q, i)))
        });
        let mut state = vec![0.0; law.info().n_state() * n];
        for i in 0..n {
            state[2 * n + i] = u_n(i);
        }
        let mut path = Self {
            n,
            jumps: jumps.collect(),
            room: state.clone(),
            state,
            traction: vec![0.0; 3 * n * steps],
        };
        // The cycle that repeats, not the first.
        path.follow(law);
        path
    }

    /// Follows the period at once.
    pub(crate) fn follow<L: TractionLaw + ?Sized>(&mut self, law: &L) -> f64 {
        let Self {
            n,
            jumps,
            state,
            room,
            traction,
        } = self;
        law.follow(0..*n, Sticking::Coulomb, jumps, state, room, traction);
        traction[0]
    }

    /// Follows the period by its steps.
    pub(crate) fn step_by_step<L: TractionLaw + ?Sized>(&mut self, law: &L) -> f64 {
        let Self {
            n,
            jumps,
            state,
            room,
            traction,
        } = self;
        along_path(*n, jumps, state, room, traction, |jump, begin, end, traction| {
            law.evaluate(0..*n, Sticking::Coulomb, jump, begin, end, traction, None, None);
        });
        traction[0]
    }
}

/// Fitted curves that differ from point to point about those of a ground steel surface, with a fitted range or without.
///
/// # Errors
/// Those of [`FittedCurves::try_new`]; there are none.
pub(crate) fn fitted_curves(n: usize, range: Option<[f64; 2]>) -> Result<PointParameters<FittedCurves>, Error> {
    let curves = (0..n).map(|i| {
        let vary = |by: f64, phase: f64| 1.0 + by * (i as f64 * 0.37 + phase).sin();
        let normal = NormalFit {
            a: 15.2 * vary(0.01, 0.0),
            b: 2.2 * vary(0.1, 1.0),
            c: -0.4 * vary(0.5, 2.0),
            d: 0.3 * vary(0.5, 3.0),
            e: 1.1 * vary(0.2, 4.0),
            u_ref: 1e-6,
            t_ref: 1.0,
            range,
        };
        let tangential = |phase: f64| TangentialFit {
            a: 28.0 * vary(0.01, phase),
            b: 1.4 * vary(0.2, phase + 1.0),
            c: 0.3 * vary(0.5, phase + 2.0),
            d: 0.6 * vary(0.2, phase + 3.0),
            u_ref: 1e-6,
            k_ref: 1.0,
            range,
            ends: TangentialEnds::Mindlin,
        };
        FittedCurves::try_new(normal, [tangential(5.0), tangential(6.0)])
    });
    Ok(PointParameters::per_point(curves.collect::<Result<_, _>>()?))
}

/// Direct sums over the asperities of a ground steel surface with quantiles like those of a measured one.
///
/// # Errors
/// Those of the constructors; there are none.
pub(crate) fn asperity_sums() -> Result<AsperitySumCurves, Error> {
    let probabilities: Vec<f64> = (0..=200).map(|i| f64::from(i) / 200.0).collect();
    let gaps: Vec<f64> = probabilities
        .iter()
        .map(|p| 28e-6 * (0.35 * p.powf(0.4) + 0.3 * p.powi(6)))
        .collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &gaps)?;
    let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.4e-3; 2])?;
    AsperitySumCurves::try_new(population, ElasticPair::new(192.85e9, 0.29), TangentialReading::Mindlin)
}
