//! Work to time laws with: batches of points in chosen regimes, parameters that differ from point to point, and the
//! time that memory alone takes.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use crate::curves::asperity_sum::{AsperitySumCurves, TangentialReading};
use crate::curves::fitted::{FittedCurves, NormalFit, TangentialEnds, TangentialFit};
use crate::error::Error;
use crate::law::{
    Along, Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking,
    TangentMut, TractionLaw, evaluates_by,
};
use crate::parameters::PointParameters;
use crate::physics::hertz::ElasticPair;
use crate::physics::population::{AsperityPopulation, GapDistribution};
use crate::simd::{BLOCK, Lanes, Pass, run};

/// Jumps, begin states and room for all that a law returns.
#[derive(Debug, Clone)]
pub struct Batch {
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
    pub fn new(n: usize, mix: [usize; 3], n_state: usize) -> Self {
        let [stick, slip, open] = mix;
        let mut jump = core::array::from_fn(|_| vec![0.0; n]);
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
            traction: core::array::from_fn(|_| vec![0.0; n]),
            tangent: core::array::from_fn(|_| vec![0.0; n]),
        }
    }

    /// Presses all points further than their jumps do, without tangential displacement, and commits.
    pub fn press<L: TractionLaw + ?Sized>(&mut self, law: &L) {
        let deep: Vec<f64> = self.jump[2].iter().map(|n| 1.1 * n).collect();
        let [x, y] = [0, 1].map(|q| core::mem::replace(&mut self.jump[q], vec![0.0; deep.len()]));
        let n = core::mem::replace(&mut self.jump[2], deep);
        self.evaluate(law, false);
        core::mem::swap(&mut self.begin, &mut self.end);
        self.jump = [x, y, n];
    }

    /// Evaluates all points.
    pub fn evaluate<L: TractionLaw + ?Sized>(&mut self, law: &L, with_tangent: bool) -> RegimeCounts {
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
    pub fn derivative<L: TractionLaw + ?Sized>(&mut self, law: &L) -> RegimeCounts {
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

    /// Largest relative difference to what `other` holds: tractions relative to the point's largest traction, rows of
    /// the tangent relative to the point's largest entry.
    ///
    /// # Panics
    /// When the batches differ in size.
    pub fn difference(&self, other: &Self) -> f64 {
        let worst = |ours: &[Vec<f64>], theirs: &[Vec<f64>]| {
            (0..self.jump[0].len())
                .map(|i| {
                    let scale = theirs.iter().fold(0.0_f64, |m, v| m.max(v[i].abs()));
                    let most = ours
                        .iter()
                        .zip(theirs)
                        .fold(0.0_f64, |m, (a, b)| m.max((a[i] - b[i]).abs()));
                    if most == 0.0 { 0.0 } else { most / scale }
                })
                .fold(0.0, f64::max)
        };
        worst(&self.traction, &other.traction).max(worst(&self.tangent, &other.tangent))
    }
}

/// Fitted curves that differ from point to point about those of a ground steel surface, with a fitted range or without.
///
/// # Errors
/// Those of [`FittedCurves::try_new`]; there are none.
pub fn fitted_curves(n: usize, range: Option<[f64; 2]>) -> Result<PointParameters<FittedCurves>, Error> {
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
pub fn asperity_sums() -> Result<AsperitySumCurves, Error> {
    let probabilities: Vec<f64> = (0..=200).map(|i| f64::from(i) / 200.0).collect();
    let gaps: Vec<f64> = probabilities
        .iter()
        .map(|p| 28e-6 * (0.35 * p.powf(0.4) + 0.3 * p.powi(6)))
        .collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &gaps)?;
    let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.4e-3; 2])?;
    AsperitySumCurves::try_new(population, ElasticPair::new(192.85e9, 0.29), TangentialReading::Mindlin)
}

/// No law: reads every number that a friction law with `N` parameters per point reads, writes every number that it
/// writes, and does nothing between but add. No law with this interface can be faster.
#[derive(Debug, Clone)]
pub struct LoadStoreFloor<const N: usize> {
    columns: [Vec<f64>; N],
    info: LawInfo,
}

impl<const N: usize> LoadStoreFloor<N> {
    /// A floor for `n_points` points.
    pub fn new(n_points: usize) -> Self {
        Self {
            columns: core::array::from_fn(|_| vec![1.0; n_points]),
            info: LawInfo {
                name: "load and store",
                reference: "",
                state: (0..5).map(|_| Quantity::new("number", "1")).collect(),
                parameters: vec![],
            },
        }
    }
}

impl<const N: usize> LoadStoreFloor<N> {
    fn touch(
        &self,
        points: Range<usize>,
        _sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
        _regimes: Option<&mut [Regime]>,
        along: Option<Along<'_>>,
    ) -> RegimeCounts {
        let n = points.len();
        run(Touch::<N> {
            jump: [jump.x, jump.y, jump.n],
            begin: begin.components::<5>(n),
            columns: core::array::from_fn(|c| &self.columns[c][points.clone()]),
            end: end.components::<5>(n),
            traction: [traction.x, traction.y, traction.n],
            tangent: tangent.map(TangentMut::into_entries),
        });
        if let Some(along) = along {
            run(Touch::<0> {
                jump: [along.d_jump.x, along.d_jump.y, along.d_jump.n],
                begin: along.d_begin.components::<5>(n),
                columns: [],
                end: along.d_end.components::<5>(n),
                traction: [along.d_traction.x, along.d_traction.y, along.d_traction.n],
                tangent: None,
            });
        }
        RegimeCounts::default()
    }
}

impl<const N: usize> TractionLaw for LoadStoreFloor<N> {
    fn info(&self) -> &LawInfo {
        &self.info
    }

    fn len(&self) -> usize {
        self.columns[0].len()
    }

    evaluates_by!(touch);
}

/// Block by block, the inputs are added up and the sum, a little changed for each, is written to all outputs.
struct Touch<'a, const N: usize> {
    jump: [&'a [f64]; 3],
    begin: [&'a [f64]; 5],
    columns: [&'a [f64]; N],
    end: [&'a mut [f64]; 5],
    traction: [&'a mut [f64]; 3],
    tangent: Option<[&'a mut [f64]; 9]>,
}

impl<const N: usize> Pass for Touch<'_, N> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            jump,
            begin,
            columns,
            mut end,
            mut traction,
            mut tangent,
        } = self;
        let n = jump[0].len();
        let mut start = 0;
        while start < n {
            let block = start..n.min(start + BLOCK);
            let mut sum = Lanes([0.0; BLOCK]);
            add(&jump, &block, &mut sum);
            add(&begin, &block, &mut sum);
            add(&columns, &block, &mut sum);
            store(&mut end, &block, &sum);
            store(&mut traction, &block, &sum);
            if let Some(tangent) = &mut tangent {
                store(tangent, &block, &sum);
            }
            start = block.end;
        }
    }
}

#[inline(always)]
fn add<const N: usize>(inputs: &[&[f64]; N], block: &Range<usize>, sum: &mut Lanes<f64, BLOCK>) {
    let n = block.len().min(BLOCK);
    let mut of_block: [&[f64]; N] = [&[]; N];
    let mut k = 0;
    while k < N {
        of_block[k] = &inputs[k][block.clone()][..n];
        k += 1;
    }
    for i in 0..n {
        let mut total = sum.0[i];
        let mut k = 0;
        while k < N {
            total += of_block[k][i];
            k += 1;
        }
        sum.0[i] = total;
    }
}

#[inline(always)]
fn store<const N: usize>(outputs: &mut [&mut [f64]; N], block: &Range<usize>, sum: &Lanes<f64, BLOCK>) {
    let n = block.len().min(BLOCK);
    let mut k = 0;
    while k < N {
        let output = &mut outputs[k][block.clone()][..n];
        for i in 0..n {
            output[i] = sum.0[i] + k as f64;
        }
        k += 1;
    }
}
