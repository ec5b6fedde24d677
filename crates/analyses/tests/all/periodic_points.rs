//! Periodic motions of a beam with 3-D friction at a point, whose pressure changes: against a motion in time and against a harmonic balance
//! of a few lines, both with a law of their own.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::points::{Slider, folder, scene, set, solve, try_run, write};
use analyses::Run;
use analyses::forced::ForcedPoint;
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Coordinates of the contact: displacements of the tip along x, the beam's axis y and the normal.
const TIP: [usize; 3] = [0, 1, 2];

/// Viscous damping ratio of all modes.
const BACKGROUND: f64 = 0.02;

/// Coordinates that the force acts on, with their factors: the beam's second node, askew.
const FORCE: [(i64, u32, f64); 2] = [(2, 1, 0.8), (2, 3, 0.6)];

/// Stiffness and mass of an element of length `l` in bending, per bending stiffness and mass per length: displacement and rotation of either end.
fn bending_element(l: f64) -> [[[f64; 4]; 4]; 2] {
    let k = [
        [12.0, 6.0 * l, -12.0, 6.0 * l],
        [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
        [-12.0, -6.0 * l, 12.0, -6.0 * l],
        [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
    ];
    let m = [
        [156.0, 22.0 * l, 54.0, -13.0 * l],
        [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
        [54.0, 13.0 * l, 156.0, -22.0 * l],
        [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
    ];
    [
        k.map(|row| row.map(|k| k / l.powi(3))),
        m.map(|row| row.map(|m| m * l / 420.0)),
    ]
}

/// A beam that is clamped at one end, and its tip's contact.
struct Beam {
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    dofs: Vec<(i64, u32)>,
    slider: Slider,
}

impl Beam {
    /// Three elements, whose principal axes are turned, so that x and the normal are coupled. The contact lies beside the beam's axis:
    /// rotations of the tip move it along y.
    fn new(slider: Slider) -> Self {
        let (length, mass, bending, axial, eccentricity) = (0.2_f64, 1.56, [350.0, 1400.0], 4.2e7, 0.01);
        let turn = 0.5_f64;
        let principal = [[turn.cos(), turn.sin()], [-turn.sin(), turn.cos()]];
        let l = length;
        let [k, m] = bending_element(l);
        // Of a node: displacements along x, y and the normal, rotations of the bending along x and the normal. The tip has the first ones.
        let row = |node: usize, kind: usize| node.checked_sub(1).map(|_| 5 * (3 - node) + kind);
        let mut stiffness = Mat::<f64>::zeros(15, 15);
        let mut inertia = Mat::<f64>::zeros(15, 15);
        for element in 0..3 {
            let at = |a: usize, direction: usize| row(element + a / 2, [[0, 3], [2, 4]][direction][a % 2]);
            for (a, b) in (0..4).flat_map(|a| (0..4).map(move |b| (a, b))) {
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let (Some(p), Some(q)) = (at(a, i), at(b, j)) else {
                        continue;
                    };
                    let flexural: f64 = (0..2).map(|c| bending[c] * principal[c][i] * principal[c][j]).sum();
                    stiffness[(p, q)] += flexural * k[a][b];
                    if i == j {
                        inertia[(p, q)] += m[a][b] * mass;
                    }
                }
            }
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let (Some(p), Some(q)) = (row(element + a, 1), row(element + b, 1)) else {
                    continue;
                };
                let equal = a == b;
                stiffness[(p, q)] += if equal { axial / l } else { -axial / l };
                inertia[(p, q)] += mass * l / if equal { 3.0 } else { 6.0 };
            }
        }
        // The displacement of the axis is that of the contact plus the rotation times the distance.
        let beside = Mat::from_fn(15, 15, |i, j| match (i, j) {
            (1, 4) => eccentricity,
            _ if i == j => 1.0,
            _ => 0.0,
        });
        let label = |i: usize| match (3 - i as i64 / 5, i % 5) {
            (node, kind @ 0..3) => (node, kind as u32 + 1),
            (node, kind) => (-node, kind as u32 - 2),
        };
        Self {
            stiffness: beside.transpose() * stiffness * &beside,
            mass: beside.transpose() * inertia * &beside,
            dofs: (0..15).map(label).collect(),
            slider,
        }
    }

    fn preloaded(preload: f64) -> Self {
        Self::new(Slider {
            first: 0,
            stiffness: [2e4, 3e4, 4e4],
            mu: 0.3,
            preload,
        })
    }

    /// The force's factor at each coordinate.
    fn load(&self) -> Vec<f64> {
        let factor = |&(label, component): &(i64, u32)| {
            let found = FORCE.iter().find(|f| (f.0, f.1) == (label, component));
            found.map_or(0.0, |f| f.2)
        };
        self.dofs.iter().map(factor).collect()
    }

    /// Modes of the stuck structure: squares of the angular frequencies, and products of the mass with the shapes.
    fn modes(&self) -> (Vec<f64>, Mat<f64>) {
        let mut stuck = self.stiffness.clone();
        TIP.iter().for_each(|&c| stuck[(c, c)] += self.slider.stiffness[c]);
        let (values, shapes) = dense_algebra::symmetric_pair(stuck.as_ref(), self.mass.as_ref()).unwrap();
        let values = (0..values.len()).map(|i| values[i]).collect();
        (values, &self.mass * shapes)
    }

    /// Damping matrix of equal ratios.
    fn damping(&self) -> Mat<f64> {
        let (values, momenta) = self.modes();
        let scaled = Mat::from_fn(15, 15, |i, k| 2.0 * BACKGROUND * values[k].sqrt() * momenta[(i, k)]);
        scaled * momenta.transpose()
    }

    fn force(&self, u: &[f64], before: &[f64], friction: [f64; 2]) -> [f64; 3] {
        self.slider.force(TIP.map(|c| u[c]), TIP.map(|c| before[c]), friction)
    }

    /// Displacements under the preload, and the friction there.
    fn rest(&self) -> (Vec<f64>, [f64; 2]) {
        let zero = vec![0.0; 15];
        let residual = |u: &[f64]| {
            let mut residual = product(&self.stiffness, u);
            let force = self.force(u, &zero, [0.0; 2]);
            TIP.iter().for_each(|&c| residual[c] += force[c]);
            residual
        };
        let u = newton(zero.clone(), &[1e-3; 15], 1e-12, &residual);
        let [x, y, _] = self.force(&u, &zero, [0.0; 2]);
        (u, [x, y])
    }

    /// What the program finds about this beam.
    fn run(&self, test: &str, analyses: &Value) -> Run {
        let folder = folder(test);
        let path = folder.join("beam.npz");
        write(&path, &self.stiffness, &self.mass, &self.dofs);
        let Slider {
            stiffness, mu, preload, ..
        } = self.slider;
        let mut given = scene(&path, &[3], &[set(stiffness, mu, preload)], &json!([[3, 1, 1.0]]));
        given["background_damping"] = json!(BACKGROUND);
        given["analyses"] = json!({ "modes": { "number": 15 } });
        for (name, value) in analyses.as_object().unwrap() {
            given["analyses"][name] = value.clone();
        }
        let found = try_run(&given).unwrap();
        std::fs::remove_dir_all(folder).unwrap();
        found
    }

    /// Points of a response from one frequency to another.
    fn response(&self, test: &str, level: f64, range: [f64; 2], harmonics: usize, samples: usize) -> Vec<ForcedPoint> {
        let found = self.run(
            test,
            &json!({ "forced": {
                "levels": [level], "from_hz": range[0], "to_hz": range[1], "terms": FORCE,
                "harmonics": harmonics, "samples": samples, "tolerance": 1e-11,
            } }),
        );
        let curve = &found.vibration.forced.as_ref().unwrap()[0];
        assert!(curve.failure.is_none(), "{:?}", curve.failure);
        curve.points.clone()
    }
}

fn product(a: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..a.nrows())
        .map(|i| x.iter().enumerate().map(|(j, x)| a[(i, j)] * x).sum())
        .collect()
}

fn size(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Newton's method with differences of 1e-7 of the scales, until the residual is `least`.
fn newton(mut z: Vec<f64>, scales: &[f64], least: f64, residual: &dyn Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let mut now = residual(&z);
    for _ in 0..60 {
        if size(&now) <= least {
            return z;
        }
        let columns: Vec<Vec<f64>> = (0..z.len())
            .map(|j| {
                let mut moved = z.clone();
                let h = 1e-7 * scales[j];
                moved[j] += h;
                residual(&moved).iter().zip(&now).map(|(a, b)| (a - b) / h).collect()
            })
            .collect();
        let rows = (0..z.len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect();
        let step = solve(rows, now.clone());
        let mut part = 1.0;
        (z, now) = loop {
            let next: Vec<f64> = z.iter().zip(&step).map(|(z, s)| z - part * s).collect();
            let then = residual(&next);
            if size(&then) < size(&now) || part < 1e-3 {
                break (next, then);
            }
            part *= 0.5;
        };
    }
    panic!("no solution: residual {:e}", size(&now));
}

/// What a point of contact did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct ContactHistory {
    sticks: bool,
    slips: bool,
    parts: bool,
}

impl ContactHistory {
    fn note(&mut self, force: [f64; 3], mu: f64) {
        let [x, y, n] = force;
        let slips = n > 0.0 && x.hypot(y) > (1.0 - 1e-9) * mu * n;
        self.parts |= n == 0.0;
        self.slips |= slips;
        self.sticks |= n > 0.0 && !slips;
    }
}

/// Cosine and sine of the first harmonic of the tip's motion along x, by Newmark's constant mean acceleration from rest, in the last period; and how
/// much they changed in it.
fn in_time(beam: &Beam, level: f64, hertz: f64, steps: usize, periods: usize) -> ([f64; 2], f64, ContactHistory) {
    let (rest, mut friction) = beam.rest();
    let (damping, load) = (beam.damping(), beam.load());
    let dt = 1.0 / (hertz * steps as f64);
    let dynamic = Mat::from_fn(15, 15, |i, j| {
        beam.stiffness[(i, j)] + 2.0 / dt * damping[(i, j)] + 4.0 / (dt * dt) * beam.mass[(i, j)]
    });
    let compliance = dynamic.partial_piv_lu().inverse();
    let (mut u, mut v, mut a) = (rest, vec![0.0; 15], vec![0.0; 15]);
    let mut seen = ContactHistory::default();
    let (mut last, mut before) = ([0.0; 2], [0.0; 2]);
    for _ in 0..periods {
        (before, last) = (last, [0.0; 2]);
        seen = ContactHistory::default();
        for step in 1..=steps {
            let angle = TAU * step as f64 / steps as f64;
            let inertia: Vec<f64> = (0..15)
                .map(|i| 4.0 / (dt * dt) * u[i] + 4.0 / dt * v[i] + a[i])
                .collect();
            let viscous: Vec<f64> = (0..15).map(|i| 2.0 / dt * u[i] + v[i]).collect();
            let (inertia, viscous) = (product(&beam.mass, &inertia), product(&damping, &viscous));
            let right: Vec<f64> = (0..15)
                .map(|i| level * load[i] * angle.cos() + inertia[i] + viscous[i])
                .collect();
            let free = product(&compliance, &right);
            // The contact is soft against the inertia of a step: its force converges by itself.
            let mut next = u.clone();
            let mut force = [0.0; 3];
            for _ in 0..100 {
                force = beam.force(&next, &u, friction);
                let earlier = TIP.map(|c| next[c]);
                for i in 0..15 {
                    next[i] = free[i] - TIP.iter().map(|&c| compliance[(i, c)] * force[c]).sum::<f64>();
                }
                if TIP.iter().all(|&c| (next[c] - earlier[c]).abs() <= 1e-17) {
                    break;
                }
            }
            for i in 0..15 {
                let (was, rate) = (a[i], v[i]);
                v[i] = 2.0 / dt * (next[i] - u[i]) - rate;
                a[i] = 4.0 / (dt * dt) * (next[i] - u[i]) - 4.0 / dt * rate - was;
            }
            u = next;
            friction = [force[0], force[1]];
            seen.note(force, beam.slider.mu);
            let factor = 2.0 / steps as f64 * u[0];
            last = [last[0] + factor * angle.cos(), last[1] + factor * angle.sin()];
        }
    }
    let change = (last[0] - before[0]).hypot(last[1] - before[1]);
    (last, change / last[0].hypot(last[1]), seen)
}

/// A harmonic balance of displacements, `[column][coordinate]` with the columns mean, cosine, sine, cosine, ...
struct Balance<'a> {
    beam: &'a Beam,
    rest: (Vec<f64>, [f64; 2]),
    harmonics: usize,
    /// Functions of the columns, sample by sample.
    basis: Vec<Vec<f64>>,
}

impl<'a> Balance<'a> {
    fn new(beam: &'a Beam, harmonics: usize, samples: usize) -> Self {
        let basis = |sample: usize| {
            let angle = TAU * sample as f64 / samples as f64;
            let of = |h: usize| [(h as f64 * angle).cos(), (h as f64 * angle).sin()];
            std::iter::once(1.0).chain((1..=harmonics).flat_map(of)).collect()
        };
        Self {
            beam,
            rest: beam.rest(),
            harmonics,
            basis: (0..samples).map(basis).collect(),
        }
    }

    /// At rest.
    fn start(&self) -> Vec<f64> {
        let mut x = self.rest.0.clone();
        x.resize(15 * (2 * self.harmonics + 1), 0.0);
        x
    }

    /// Harmonics of the contact force in the second period, `[column][component]`.
    fn contact(&self, x: &[f64]) -> (Vec<[f64; 3]>, ContactHistory) {
        let mut seen = ContactHistory::default();
        let mut coefficients = vec![[0.0; 3]; 2 * self.harmonics + 1];
        let (mut before, mut friction) = (TIP.map(|c| self.rest.0[c]), self.rest.1);
        for period in 0..2 {
            for basis in &self.basis {
                let u = TIP.map(|c| basis.iter().zip(x.chunks(15)).map(|(b, x)| b * x[c]).sum());
                let force = self.beam.slider.force(u, before, friction);
                (before, friction) = (u, [force[0], force[1]]);
                if period == 1 {
                    seen.note(force, self.beam.slider.mu);
                    for (column, (to, b)) in coefficients.iter_mut().zip(basis).enumerate() {
                        let factor = if column == 0 { 1.0 } else { 2.0 * b } / self.basis.len() as f64;
                        (0..3).for_each(|c| to[c] += factor * force[c]);
                    }
                }
            }
        }
        (coefficients, seen)
    }

    /// Residual of `M x'' + D x' + K x + F(x)` at the square `square` of the angular frequency, `rates` being `D` times that frequency.
    fn residual(&self, x: &[f64], square: f64, rates: &Mat<f64>) -> Vec<f64> {
        let mut all = Vec::with_capacity(x.len());
        for (column, part) in x.chunks(15).enumerate() {
            let mut residual = product(&self.beam.stiffness, part);
            if column > 0 {
                let h = column.div_ceil(2) as f64;
                let (partner, sign) = if column % 2 == 1 {
                    (column + 1, 1.0)
                } else {
                    (column - 1, -1.0)
                };
                let (inertia, rate) = (product(&self.beam.mass, part), product(rates, &x[15 * partner..][..15]));
                (0..15).for_each(|i| residual[i] += sign * h * rate[i] - h * h * square * inertia[i]);
            }
            all.extend(residual);
        }
        for (column, force) in self.contact(x).0.iter().enumerate() {
            TIP.iter().for_each(|&c| all[15 * column + c] += force[c]);
        }
        all
    }

    /// The response to a force, from the start `x`.
    fn forced(&self, x: Vec<f64>, level: f64, hertz: f64) -> Vec<f64> {
        let omega = TAU * hertz;
        let (damping, load) = (self.beam.damping(), self.beam.load());
        let rates = Mat::from_fn(15, 15, |i, j| omega * damping[(i, j)]);
        let residual = |x: &[f64]| {
            let mut residual = self.residual(x, omega * omega, &rates);
            (0..15).for_each(|i| residual[15 + i] -= level * load[i]);
            residual
        };
        let scales = vec![1e-3; x.len()];
        newton(x, &scales, 1e-9 * level, &residual)
    }
}

/// Amplitudes of the harmonics of the tip along x, with the mean from rest, and the first one's cosine and sine.
fn along_x(balance: &Balance<'_>, x: &[f64]) -> (f64, Vec<f64>, [f64; 2]) {
    let at = |column: usize| x[15 * column];
    let amplitudes = (1..=balance.harmonics).map(|h| at(2 * h - 1).hypot(at(2 * h)));
    (at(0) - balance.rest.0[0], amplitudes.collect(), [at(1), at(2)])
}

/// Distance of two first harmonics relative to the first one.
fn apart(point: &ForcedPoint, [c, s]: [f64; 2]) -> f64 {
    let amplitude = point.harmonics[0];
    let (sin, cos) = point.phase.sin_cos();
    (c - amplitude * cos).hypot(s - amplitude * sin) / amplitude
}

/// Distance of two first harmonics relative to the second.
fn change(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1]) / b[0].hypot(b[1])
}

/// The range that begins with a frequency and is done after one step.
fn at(hertz: f64) -> [f64; 2] {
    [hertz, hertz * 1.0001]
}

/// Force (N) and frequencies below the resonance, at it, and above it, of motions that stick and slip.
const LEVEL: f64 = 10.0;
const FREQUENCIES: [f64; 3] = [28.0, 32.0, 45.0];

#[test]
fn forced_responses_are_those_of_the_motion_in_time() {
    let beam = Beam::preloaded(60.0);
    let mut phases = Vec::new();
    for hertz in FREQUENCIES {
        let (found, drift, seen) = in_time(&beam, LEVEL, hertz, 8000, 100);
        assert!(
            drift < 1e-8
                && seen
                    == ContactHistory {
                        sticks: true,
                        slips: true,
                        parts: false
                    }
        );
        let coarse = change(in_time(&beam, LEVEL, hertz, 4000, 100).0, found);
        // With few harmonics, and with so many that what is left is the error of the steps in time.
        for (harmonics, samples, bound) in [(9, 512, 2e-3), (25, 4096, 5e-5)] {
            let point = &beam.response("time", LEVEL, at(hertz), harmonics, samples)[0];
            let error = apart(point, found);
            println!("{hertz} Hz, H = {harmonics}, N = {samples}: {error:.1e}; half the steps: {coarse:.1e}");
            assert!(error < bound, "{hertz} Hz, H = {harmonics}: {error:e}");
            phases.push(point.phase.to_degrees());
        }
    }
    assert!(
        phases[0] < 60.0 && (70.0..110.0).contains(&phases[2]) && phases[4] > 130.0,
        "{phases:?}"
    );
}

#[test]
fn forced_responses_are_those_of_another_harmonic_balance() {
    let beam = Beam::preloaded(60.0);
    let balance = Balance::new(&beam, 9, 512);
    for hertz in FREQUENCIES {
        let point = &beam.response("balance", LEVEL, at(hertz), 9, 512)[0];
        let x = balance.forced(balance.start(), LEVEL, hertz);
        let (mean, amplitudes, first) = along_x(&balance, &x);
        let error = apart(point, first);
        println!("{hertz} Hz: {error:.1e}");
        assert!(error < 1e-8, "{hertz} Hz: {error:e}");
        assert!((point.mean - mean).abs() < 1e-8 * amplitudes[0]);
        for (a, b) in point.harmonics.iter().zip(&amplitudes) {
            assert!((a - b).abs() < 1e-8 * amplitudes[0], "{hertz} Hz: {a:e} {b:e}");
        }
    }
}

#[test]
fn free_motions_are_those_of_another_harmonic_balance() {
    let beam = Beam::preloaded(60.0);
    let balance = Balance::new(&beam, 9, 512);
    let modal_amplitudes = [3e-5, 1e-4, 3e-4, 1e-3];
    let found = beam.run(
        "epmc",
        &json!({ "epmc": {
            "modal_amplitudes": modal_amplitudes, "harmonics": 9, "samples": 512, "tolerance": 1e-11,
        } }),
    );
    let epmc = found.first().epmc.as_ref().unwrap();
    let (values, momenta) = beam.modes();
    let lambda = values[0];
    let momentum: Vec<f64> = (0..15).map(|i| momenta[(i, 0)]).collect();
    let n = balance.start().len();
    // A motion, the square of its angular frequency, and what sustains it.
    let mut z = [balance.start(), vec![lambda, 0.0]].concat();
    let mut zetas = Vec::new();
    for (index, &q) in modal_amplitudes.iter().enumerate() {
        let scale = lambda * q * size(&momentum);
        let norm = |column: &[f64]| {
            column
                .iter()
                .zip(product(&beam.mass, column))
                .map(|(a, b)| a * b)
                .sum::<f64>()
        };
        if index == 0 {
            // The linear mode, whose momentum is known: P phi = lambda M phi.
            let mut stuck = beam.stiffness.clone();
            TIP.iter().for_each(|&c| stuck[(c, c)] += beam.slider.stiffness[c]);
            let shape = stuck.partial_piv_lu().inverse() * Mat::from_fn(15, 1, |i, _| lambda * momentum[i]);
            (0..15).for_each(|i| z[15 + i] = q * shape[(i, 0)]);
        } else {
            let ratio = q / modal_amplitudes[index - 1];
            (15..n).for_each(|i| z[i] *= ratio);
        }
        let residual = |z: &[f64]| {
            let (x, square, sustained) = (&z[..n], z[n], z[n + 1]);
            let rates = Mat::from_fn(15, 15, |i, j| -sustained * beam.mass[(i, j)]);
            let mut residual = balance.residual(x, square, &rates);
            let (cosine, sine) = (&x[15..30], &x[30..45]);
            residual.push(scale * ((norm(cosine) + norm(sine)) / (q * q) - 1.0));
            residual.push(scale / q * sine.iter().zip(&momentum).map(|(s, m)| s * m).sum::<f64>());
            residual
        };
        let mut scales = vec![q; n];
        scales.extend([lambda, lambda]);
        z = newton(z, &scales, 1e-10 * scale, &residual);
        let (x, square, sustained) = (&z[..n], z[n], z[n + 1]);
        let (omega, zeta) = (square.sqrt(), 0.5 * sustained / square);
        let motion = epmc.points[index].result.as_ref().unwrap();
        let errors = [motion.omega / omega - 1.0, motion.zeta.unwrap() - zeta];
        println!("q = {q:e}: {:.3} Hz, zeta = {zeta:.4e}, errors {errors:?}", omega / TAU);
        assert!(
            errors[0].abs() < 1e-9 && errors[1].abs() < 1e-9,
            "q = {q:e}: {errors:?}"
        );
        let (_, amplitudes, _) = along_x(&balance, x);
        assert!((epmc.response_displacement[index].unwrap() / amplitudes[0] - 1.0).abs() < 1e-8);
        // What friction takes is what sustains the motion.
        let (forces, _) = balance.contact(x);
        let mut dissipation = 0.0;
        let mut supplied = 0.0;
        for h in 1..=balance.harmonics {
            let pair = [2 * h - 1, 2 * h].map(|column| &x[15 * column..][..15]);
            for (c, &row) in TIP.iter().enumerate() {
                let work = forces[2 * h - 1][c] * pair[1][row] - forces[2 * h][c] * pair[0][row];
                dissipation += 0.5 * TAU * h as f64 * work;
            }
            supplied += 0.5 * TAU * sustained * (h * h) as f64 * (norm(pair[0]) + norm(pair[1]));
        }
        let energy = square * q * q;
        assert!((dissipation - supplied).abs() < 1e-9 * energy);
        assert!((motion.dissipation - dissipation).abs() < 1e-9 * energy);
        assert!(motion.energy_error.abs() < 1e-10 && motion.residual < 1e-9);
        zetas.push(zeta);
    }
    assert!(zetas[0].abs() < 1e-9 && zetas[3] > 0.05, "{zetas:?}");
}

#[test]
fn a_point_that_parts_converges_with_harmonics_and_samples() {
    let beam = Beam::preloaded(10.0);
    let (level, hertz) = (3.0, 25.0);
    let (found, drift, seen) = in_time(&beam, level, hertz, 8000, 100);
    assert!(
        drift < 1e-8
            && seen
                == ContactHistory {
                    sticks: true,
                    slips: true,
                    parts: true
                }
    );
    let mut errors = Vec::new();
    for (harmonics, samples) in [(3, 64), (9, 512), (25, 4096)] {
        let point = &beam.response("parts", level, at(hertz), harmonics, samples)[0];
        errors.push(apart(point, found));
    }
    println!("{errors:?}");
    assert!(
        errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1] && errors[2] < 1e-4,
        "{errors:?}"
    );
    let balance = Balance::new(&beam, 9, 512);
    let x = balance.forced(balance.start(), level, hertz);
    assert!(balance.contact(&x).1.parts);
    let point = &beam.response("parts", level, at(hertz), 9, 512)[0];
    let error = apart(point, along_x(&balance, &x).2);
    println!("{error:.1e}");
    assert!(error < 1e-8, "{error:e}");
}

#[test]
fn a_curve_goes_through_the_resonance_of_a_point_that_is_mostly_apart() {
    let points = Beam::preloaded(0.5).response("apart", 2.0, [15.0, 60.0], 5, 128);
    let peak = points.iter().map(|p| p.harmonics[0]).fold(0.0, f64::max);
    println!("{} points, {peak:.3e} m", points.len());
    assert!(points.len() > 50 && points.iter().all(|p| p.residual < 1e-10));
    assert!(peak > 2.0 * points[0].harmonics[0]);
    assert!((points.last().unwrap().frequency_hz / 60.0 - 1.0).abs() < 1e-12);
}

#[test]
fn a_curve_turns_corners_where_a_point_begins_to_slip() {
    let folder = folder("corner");
    let path = folder.join("beam.npz");
    // Ten elements with friction at the middle and at the tip; around 35 Hz the tip begins to slip in the third harmonic.
    let [k, m] = bending_element(0.06);
    let (mut stiffness, mut mass) = (Mat::<f64>::zeros(40, 40), Mat::<f64>::zeros(40, 40));
    let mut dofs = Vec::new();
    for (plane, (component, bending)) in [(1, 350.0), (3, 14e3)].into_iter().enumerate() {
        for (element, a, b) in (0..10).flat_map(|e| (0..16).map(move |i| (e, i / 4, i % 4))) {
            let row = |a: usize| (2 * element + a).checked_sub(2).map(|row| 20 * plane + row);
            if let (Some(p), Some(q)) = (row(a), row(b)) {
                stiffness[(p, q)] += bending * k[a][b];
                mass[(p, q)] += 1.56 * m[a][b];
            }
        }
        dofs.extend((1..=10).flat_map(|node: i64| [(node, component), (-node, component)]));
    }
    write(&path, &stiffness, &mass, &dofs);
    let sets = [set([1e5, 1e5, 2e5], 0.3, 50.0), set([5e4, 5e4, 1e5], 0.2, 20.0)];
    let mut given = scene(&path, &[5, 10], &sets, &json!([[10, 1, 1.0]]));
    given["background_damping"] = json!(5e-3);
    given["analyses"] = json!({ "forced": {
        "levels": [5.0], "from_hz": 15.0, "to_hz": 36.0, "terms": [[7, 1, 0.8], [7, 3, 0.6]], "harmonics": 9, "samples": 256,
    } });
    let found = try_run(&given).unwrap();
    let curve = &found.vibration.forced.as_ref().unwrap()[0];
    assert!(curve.failure.is_none(), "{:?}", curve.failure);
    // From the other side the curve is the same.
    let last = curve.points.last().unwrap();
    given["analyses"]["forced"]["from_hz"] = json!(36.0);
    given["analyses"]["forced"]["to_hz"] = json!(34.0);
    let back = try_run(&given).unwrap();
    let first = &back.vibration.forced.as_ref().unwrap()[0].points[0];
    assert!((last.harmonics[0] / first.harmonics[0] - 1.0).abs() < 1e-6);
    std::fs::remove_dir_all(folder).unwrap();
}
