//! Rough contact by boundary elements: the normal contact of a height field with an elastic half-space.
//!
//! Pressures `p >= 0` on the points of a grid press a surface of heights `h` against a flat half-space with the contact modulus `E*` of both bodies.
//! Their gap is zero where they touch. The field is mirrored at its edges, so that no step of height enters and cosines diagonalise the
//! compliance: to the wave number `q` belongs
//! <div>
//! $$ \hat u(q) = \frac{2}{E^* q} \, \hat p(q), \qquad q > 0 , $$
//! </div>
//!
//! and none to the mean, which is the deflection that a structure's mesh has already. The pressures are found by conjugate gradients on the points that
//! touch.
//!
//! Sources: I. A. Polonsky and L. M. Keer, Wear 231 (1999) 206-219; H. M. Stanley and T. Kato, J. Tribol. 119 (1997) 481-485; area of contact with a
//! part of the points on its edges: V. A. Yastrebov, G. Anciaux and J.-F. Molinari, J. Mech. Phys. Solids 107 (2017) 469-493.

use crate::characterise::Characterisation;
use crate::error::{SurfaceError, finite_samples, positive};
use crate::partition::ElementOutlines;
use crate::topography::{HeightMap, turn};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlannerScalar};
use std::f64::consts::{LN_2, PI};
use std::sync::Arc;

/// Fewest points that touch at a pressure that is resolved.
const LEAST_TOUCHING: usize = 30;

/// Largest rms gap where there is contact, and largest overlap elsewhere, over the rms of the deflections.
const TOLERANCE: f64 = 1e-5;

const MOST_ITERATIONS: usize = 3000;

/// A height field on a half-space.
pub struct BoundaryElements<'a> {
    heights: &'a [f64],
    n: [usize; 2],
    /// Of every pair of wave numbers.
    compliance: Vec<f64>,
    transforms: [Cosines; 2],
    turned: Vec<f64>,
}

/// What is found at a mean pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pressed {
    /// Mean pressure over the contact modulus.
    pub pressure: f64,
    /// Mean gap (m).
    pub separation: f64,
    /// Part of the area that touches.
    pub area: f64,
    /// Points that touch.
    pub touching: usize,
}

impl<'a> BoundaryElements<'a> {
    /// A field of `n` points along x (fastest) and y at the distances `step` (m), heights in m.
    ///
    /// # Errors
    /// Fewer than 2 points along an axis, another number of heights than points, heights that are not finite or all the same.
    pub fn try_new(heights: &'a [f64], n: [usize; 2], step: [f64; 2]) -> Result<Self, SurfaceError> {
        for step in step {
            positive("lateral step", step, "m")?;
        }
        let points = n[0] * n[1];
        if n.iter().any(|&n| n < 2) || heights.len() != points {
            return Err(SurfaceError::LengthMismatch {
                field: "heights",
                found: heights.len(),
                expected: points.max(4),
                remedy: "give a height for every point, and at least two points along each axis",
            });
        }
        finite_samples("heights", heights, "m")?;
        let mean = heights.iter().sum::<f64>() / points as f64;
        let rms = (heights.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / points as f64).sqrt();
        positive("rms of the heights", rms, "m")?;
        let wave = |k: usize, axis: usize| PI * k as f64 / (n[axis] as f64 * step[axis]);
        let compliance = (0..points).map(|k| {
            let q = wave(k % n[0], 0).hypot(wave(k / n[0], 1));
            if k == 0 { 0.0 } else { 2.0 / q }
        });
        Ok(Self {
            heights,
            n,
            compliance: compliance.collect(),
            transforms: n.map(Cosines::new),
            turned: vec![0.0; points],
        })
    }

    /// Deflections (m) under pressures over the contact modulus.
    fn deflect(&mut self, pressures: &[f64], into: &mut [f64]) {
        let [nx, ny] = self.n;
        into.copy_from_slice(pressures);
        let [along_x, along_y] = &mut self.transforms;
        along_x.forward(into);
        turn(into, [nx, ny], &mut self.turned);
        along_y.forward(&mut self.turned);
        for (k, value) in self.turned.iter_mut().enumerate() {
            *value *= self.compliance[k % ny * nx + k / ny];
        }
        along_y.back(&mut self.turned);
        turn(&self.turned, [ny, nx], into);
        along_x.back(into);
    }

    /// Contact at a mean pressure over the contact modulus, from pressures that are near; they are overwritten by those found.
    ///
    /// # Errors
    /// A pressure that is not above zero, and [`SurfaceError::NoContact`] where the iterations do not end.
    pub fn press(&mut self, pressure: f64, pressures: &mut Vec<f64>) -> Result<Pressed, SurfaceError> {
        positive("mean pressure over the contact modulus", pressure, "1")?;
        let points = self.heights.len();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / points as f64;
        let scale = |values: &mut [f64]| {
            let factor = pressure / mean(values);
            values.iter_mut().for_each(|p| *p *= factor);
        };
        pressures.resize(points, 0.0);
        if mean(pressures) > 0.0 {
            scale(pressures);
        } else {
            pressures.fill(pressure);
        }
        let [mut gap, mut moved, mut direction] = [0; 3].map(|_| vec![0.0; points]);
        let (mut last, mut keeps) = (1.0, false);
        let mut found = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            self.deflect(pressures, &mut gap);
            let deflected = (gap.iter().map(|u| u * u).sum::<f64>() / points as f64).sqrt();
            let (mut sum, mut touching) = (0.0, 0);
            for ((gap, z), p) in gap.iter_mut().zip(self.heights).zip(&*pressures) {
                *gap -= z;
                if *p > 0.0 {
                    sum += *gap;
                    touching += 1;
                }
            }
            let level = sum / touching as f64;
            let (mut square, mut overlap) = (0.0, 0.0_f64);
            for (gap, p) in gap.iter_mut().zip(&*pressures) {
                *gap -= level;
                if *p > 0.0 {
                    square += *gap * *gap;
                } else {
                    overlap = overlap.max(-*gap);
                }
            }
            found = (square / touching as f64).sqrt().max(overlap) / deflected;
            if found <= TOLERANCE {
                return Ok(Pressed {
                    pressure,
                    separation: mean(&gap),
                    area: self.area(pressures),
                    touching,
                });
            }
            let carried = if keeps { square / last } else { 0.0 };
            last = square;
            for ((t, gap), p) in direction.iter_mut().zip(&gap).zip(&*pressures) {
                *t = if *p > 0.0 { gap + carried * *t } else { 0.0 };
            }
            self.deflect(&direction, &mut moved);
            let of_touching =
                |of: &dyn Fn(usize) -> f64| -> f64 { (0..points).filter(|&i| pressures[i] > 0.0).map(of).sum() };
            let level = of_touching(&|i| moved[i]) / touching as f64;
            let step = of_touching(&|i| gap[i] * direction[i]) / of_touching(&|i| (moved[i] - level) * direction[i]);
            let step = if step.is_finite() { step } else { 0.0 };
            keeps = true;
            for ((p, t), gap) in pressures.iter_mut().zip(&direction).zip(&gap) {
                if *p > 0.0 {
                    *p = (*p - step * t).max(0.0);
                } else if *gap < 0.0 {
                    *p = -step * gap;
                    keeps = false;
                }
            }
            scale(pressures);
        }
        Err(SurfaceError::NoContact {
            pressure,
            residual: found,
            iterations: MOST_ITERATIONS,
        })
    }

    /// Contacts at rising mean pressures over the contact modulus.
    ///
    /// # Errors
    /// As [`Self::press`].
    pub fn curve(&mut self, pressures: &[f64]) -> Result<Vec<Pressed>, SurfaceError> {
        // From the largest on: fewer points touch from one to the next, which begins better than more.
        let mut found = Vec::with_capacity(pressures.len());
        let mut state = Vec::new();
        for &pressure in pressures.iter().rev() {
            found.push(self.press(pressure, &mut state)?);
        }
        found.reverse();
        Ok(found)
    }

    /// Part of the points that touch, less a part of those on the edges of contact.
    fn area(&self, pressures: &[f64]) -> f64 {
        let [nx, ny] = self.n;
        let touches = |i: usize| pressures[i] > 0.0;
        let (mut touching, mut edges) = (0, 0);
        for i in 0..nx * ny {
            touching += usize::from(touches(i));
            edges += usize::from(i % nx > 0 && touches(i) != touches(i - 1));
            edges += usize::from(i >= nx && touches(i) != touches(i - nx));
        }
        let part = touching as f64 - (PI - 1.0 + LN_2) / 24.0 * edges as f64;
        part.max(0.0) / (nx * ny) as f64
    }
}

/// Smallest of the mean pressures over the contact modulus of [`Characterisation::pressed`], how many there are in a decade, and in how many
/// decades: for steel, from 0.1 to 1000 MPa.
const SMALLEST: f64 = 1e-6;
const PER_DECADE: u32 = 10;
const DECADES: u32 = 4;

/// Most points of an element along an axis.
const MOST_POINTS: usize = 256;

/// A curve of an element by boundary elements.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PressedElement {
    /// Index of the element.
    pub element: usize,
    /// Points along x and y.
    pub points: [usize; 2],
    /// Every how many points of the top face along x and y they are.
    pub stride: [usize; 2],
    /// Part of the points without data on a face, which cannot touch.
    pub missing: f64,
    /// Interferences (m) as those of the element's asperities count: zero where the tallest peaks of both faces would meet. The first is where the
    /// faces touch.
    pub interferences: Vec<f64>,
    /// Mean pressures over the contact modulus there, the first 0.
    pub pressures: Vec<f64>,
    /// Parts of the area in contact.
    pub areas: Vec<f64>,
    /// Smallest mean pressure over the contact modulus at which 30 points or more touch.
    pub resolved_from: f64,
}

impl Characterisation {
    /// Contact of some elements by boundary elements: of each its bounding box, with the heights of both faces above their forms, at up to 256
    /// points along an axis; of more points of the top face every second, third and so on, and of numbers with prime factors above 7 the next
    /// smaller one without. `maps` are those that were characterised.
    ///
    /// # Errors
    /// [`SurfaceError::Interrupted`] where `stop` says so, [`SurfaceError::NoContact`], [`SurfaceError::LengthMismatch`] for an element with so
    /// few points that no pressure is resolved.
    pub fn pressed(
        &self,
        stop: &(dyn Fn() -> bool + Sync),
        maps: [&HeightMap; 2],
        outlines: &ElementOutlines,
        elements: &[usize],
    ) -> Result<Vec<PressedElement>, SurfaceError> {
        let [top, bottom] = maps;
        let (top, _) = self.options.noise.apply(top)?;
        let (bottom, _) = self.options.noise.apply(bottom)?;
        let bottom = bottom.into_owned().shifted(self.options.registration.shift)?;
        let found = elements.par_iter().map(|&element| match stop() {
            true => Err(SurfaceError::Interrupted),
            false => self.pressed_element([&top, &bottom], outlines, element),
        });
        // In order, so that of several errors the first element's is reported on any number of threads.
        found.collect::<Vec<_>>().into_iter().collect()
    }

    fn pressed_element(
        &self,
        maps: [&HeightMap; 2],
        outlines: &ElementOutlines,
        element: usize,
    ) -> Result<PressedElement, SurfaceError> {
        let of_element = &self.elements[element];
        let grid = maps[0];
        let (low, high) = outlines.element_bounds(element);
        let windows = [0, 1].map(|axis| grid.indices_within(axis, low[axis], high[axis]));
        let stride = windows.map(|(first, end)| (end - first).div_ceil(MOST_POINTS).max(1));
        let points = [0, 1].map(|axis| quick((windows[axis].1 - windows[axis].0).div_ceil(stride[axis])));
        let step = [0, 1].map(|axis| grid.step()[axis] * stride[axis] as f64);
        let residual = |side: usize, at: [f64; 2]| {
            let form = self.faces[side].trend.at(at) + of_element.faces[side].plane.at(at);
            maps[side].interpolated(at).map(|z| z - form)
        };
        let mut heights = Vec::with_capacity(points[0] * points[1]);
        for j in 0..points[1] {
            for i in 0..points[0] {
                let at = grid.position(windows[0].0 + i * stride[0], windows[1].0 + j * stride[1]);
                heights.push(residual(0, at).zip(residual(1, at)).map(|(top, bottom)| top + bottom));
            }
        }
        // What is not known cannot touch.
        let lowest = heights.iter().flatten().copied().reduce(f64::min).unwrap_or(0.0);
        let missing = heights.iter().filter(|height| height.is_none()).count();
        let heights: Vec<f64> = heights.into_iter().map(|height| height.unwrap_or(lowest)).collect();
        let count = heights.len();
        let curve = match heights.len() {
            0 => Vec::new(),
            _ => {
                let pressure = |i: u32| SMALLEST * 10f64.powf(f64::from(i) / f64::from(PER_DECADE));
                let pressures = (0..=DECADES * PER_DECADE).map(pressure);
                BoundaryElements::try_new(&heights, points, step)?.curve(&pressures.collect::<Vec<_>>())?
            }
        };
        let mean = heights.iter().sum::<f64>() / count.max(1) as f64;
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // Faces touch no earlier than tallest peaks could.
        let datum = (of_element.faces[0].tallest + of_element.faces[1].tallest).max(highest);
        let mut found = PressedElement {
            element,
            points,
            stride,
            missing: missing as f64 / count.max(1) as f64,
            interferences: vec![datum - highest],
            pressures: vec![0.0],
            areas: vec![0.0],
            resolved_from: f64::INFINITY,
        };
        for pressed in curve {
            if pressed.touching >= LEAST_TOUCHING {
                found.resolved_from = found.resolved_from.min(pressed.pressure);
            }
            let interference = datum - (pressed.separation + mean);
            if interference > found.interferences[found.interferences.len() - 1] {
                found.interferences.push(interference);
                found.pressures.push(pressed.pressure);
                found.areas.push(pressed.area.min(1.0));
            }
        }
        if found.pressures.len() < 4 || found.resolved_from.is_infinite() {
            return Err(SurfaceError::LengthMismatch {
                field: "points of a patch for boundary elements",
                found: count,
                expected: 1000.max(count + 1),
                remedy: "scan with more points, coarsen the interface mesh, or take another law",
            });
        }
        Ok(found)
    }
}

/// Cosine transforms of rows, `X_k = sum_j x_j cos(pi k (j + 1/2)/n)`, and back: those of two rows by one Fourier transform of as many points
/// (J. Makhoul, IEEE Trans. Acoust. Speech Signal Process. 28 (1980) 27-34).
struct Cosines {
    n: usize,
    transforms: [Arc<dyn Fft<f64>>; 2],
    /// `exp(-i pi k/(2 n))`.
    turns: Vec<Complex64>,
    values: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Cosines {
    fn new(n: usize) -> Self {
        let mut planner = FftPlannerScalar::new();
        let transforms = [planner.plan_fft_forward(n), planner.plan_fft_inverse(n)];
        let scratch = transforms
            .iter()
            .map(|of| of.get_inplace_scratch_len())
            .max()
            .unwrap_or(0);
        Self {
            n,
            transforms,
            turns: (0..n)
                .map(|k| Complex64::from_polar(1.0, -PI * k as f64 / (2 * n) as f64))
                .collect(),
            values: vec![Complex64::default(); n],
            scratch: vec![Complex64::default(); scratch],
        }
    }

    /// Where the point `j` of a row stands: even ones from the front, odd ones from the back.
    fn place(&self, j: usize) -> usize {
        if j.is_multiple_of(2) { j / 2 } else { self.n - 1 - j / 2 }
    }

    fn forward(&mut self, rows: &mut [f64]) {
        let n = self.n;
        for pair in rows.chunks_mut(2 * n) {
            let second = |pair: &[f64], j: usize| pair.get(n + j).copied().unwrap_or(0.0);
            for j in 0..n {
                let place = self.place(j);
                self.values[place] = Complex64::new(pair[j], second(pair, j));
            }
            self.transforms[0].process_with_scratch(&mut self.values, &mut self.scratch);
            for k in 0..n {
                let (here, there) = (self.values[k], self.values[(n - k) % n].conj());
                pair[k] = (self.turns[k] * 0.5 * (here + there)).re;
                if let Some(value) = pair.get_mut(n + k) {
                    *value = (self.turns[k] * 0.5 * (here - there)).im;
                }
            }
        }
    }

    fn back(&mut self, rows: &mut [f64]) {
        let n = self.n;
        for pair in rows.chunks_mut(2 * n) {
            let at = |row: usize, k: usize| match k {
                k if k == n => 0.0,
                k => pair.get(row * n + k).copied().unwrap_or(0.0),
            };
            for k in 0..n {
                let spectrum = |row| self.turns[k].conj() * Complex64::new(at(row, k), -at(row, n - k));
                self.values[k] = (spectrum(0) + Complex64::i() * spectrum(1)) / n as f64;
            }
            self.transforms[1].process_with_scratch(&mut self.values, &mut self.scratch);
            for j in 0..n {
                let value = self.values[self.place(j)];
                pair[j] = value.re;
                if let Some(second) = pair.get_mut(n + j) {
                    *second = value.im;
                }
            }
        }
    }
}

/// The largest number up to `n` without prime factors above 7, of which transforms are quick.
fn quick(n: usize) -> usize {
    let is_quick = |n: &usize| {
        let mut rest = *n;
        for factor in [2, 3, 5, 7] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (1..=n).rev().find(is_quick).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave: at the mean pressure `P sin^2(psi)` the part `2 psi/pi` touches, with `P = pi E* a/wavelength` for heights `a cos` (Westergaard 1939).
    #[test]
    fn a_wave_touches_as_westergaard_found() {
        let n = 256;
        let heights: Vec<f64> = (0..4 * n)
            .map(|k| 1e-6 * (2.0 * PI * ((k % n) as f64 + 0.5) / n as f64).cos())
            .collect();
        let mut solver = BoundaryElements::try_new(&heights, [n, 4], [1e-3 / n as f64; 2]).unwrap();
        let complete = PI * 1e-6 / 1e-3;
        for share in [0.1, 0.3, 0.6] {
            let mut pressures = vec![];
            let found = solver.press(share * complete, &mut pressures).unwrap();
            let touching = pressures.iter().filter(|p| **p > 0.0).count() as f64 / heights.len() as f64;
            let exact = 2.0 / PI * f64::asin(share.sqrt());
            assert!((touching - exact).abs() <= 1.0 / n as f64, "{share} {touching} {exact}");
            // Johnson, Greenwood and Higginson, Int. J. Mech. Sci. 27 (1985) 383-396: the mean gap.
            let sine = share;
            let gap = 1e-6 * (1.0 - sine + sine * sine.ln());
            assert!(
                (found.separation - gap).abs() < 2e-3 * 1e-6,
                "{share} {} {gap}",
                found.separation
            );
        }
    }

    /// Pressure and area of Hertz's sphere, in the corner of the mirrored field.
    #[test]
    fn a_sphere_touches_as_hertz_found() {
        let (n, edge, radius) = (256, 1e-3, 1e-3);
        let at = |k: usize| (k as f64 + 0.5) * edge / n as f64;
        let heights: Vec<f64> = (0..n * n)
            .map(|k| -(at(k % n).powi(2) + at(k / n).powi(2)) / (2.0 * radius))
            .collect();
        let mut solver = BoundaryElements::try_new(&heights, [n, n], [edge / n as f64; 2]).unwrap();
        let contact = 0.06 * edge;
        let force = 4.0 / 3.0 * contact.powi(3) / radius;
        let mut pressures = vec![];
        let found = solver.press(0.25 * force / (edge * edge), &mut pressures).unwrap();
        let peak = pressures.iter().copied().fold(0.0, f64::max) / (1.5 * force / (PI * contact * contact));
        let area = found.area / (0.25 * PI * (contact / edge).powi(2));
        assert!((peak - 1.0).abs() < 0.01 && (area - 1.0).abs() < 0.03, "{peak} {area}");
    }

    /// Against Tamaas 2.9 (Frerot et al., J. Open Source Softw. 5 (2020) 2121), its solver of Polonsky, Keer and Rey on the field and its images.
    #[test]
    fn another_program_finds_the_same_contact() {
        let (nx, ny) = (64, 48);
        let heights: Vec<f64> = (0..nx * ny)
            .map(|k| {
                let (i, j) = ((k % nx) as f64, (k / nx) as f64);
                let waves = (0.9 * i).sin() * (0.7 * j).cos() + (0.31 * (i + 2.0 * j)).sin();
                1e-6 * (waves + 0.6 * (0.23 * i - 0.4 * j + 1.0).sin())
            })
            .collect();
        let mut solver = BoundaryElements::try_new(&heights, [nx, ny], [10e-6, 12e-6]).unwrap();
        for (pressure, separation, touching) in [
            (1e-5, 2.3430779527e-6, 0.0013020833),
            (1e-4, 2.0772863299e-6, 0.0087890625),
            (1e-3, 1.4748616272e-6, 0.0481770833),
            (5e-3, 8.3138085268e-7, 0.1858723958),
        ] {
            let mut pressures = vec![];
            let found = solver.press(pressure, &mut pressures).unwrap();
            assert!(
                (found.separation / separation - 1.0).abs() < 1e-5,
                "{found:?} {separation:e}"
            );
            assert!(
                (found.touching as f64 / heights.len() as f64 - touching).abs() < 1e-9,
                "{found:?} {touching}"
            );
        }
    }

    #[test]
    fn cosines_are_what_their_sums_say_and_come_back() {
        for (n, rows) in [(1, 1), (2, 3), (7, 2), (12, 5)] {
            let value = |k: usize| (0.7 * k as f64).sin() + 0.1 * k as f64;
            let given: Vec<f64> = (0..n * rows).map(value).collect();
            let (mut cosines, mut found) = (Cosines::new(n), given.clone());
            cosines.forward(&mut found);
            for (row, found) in given.chunks(n).zip(found.chunks(n)) {
                for (k, found) in found.iter().enumerate() {
                    let term = |(j, x): (usize, &f64)| x * (PI * k as f64 * (j as f64 + 0.5) / n as f64).cos();
                    let expected: f64 = row.iter().enumerate().map(term).sum();
                    assert!((found - expected).abs() < 1e-12, "{n} {k}: {found} {expected}");
                }
            }
            cosines.back(&mut found);
            assert!(found.iter().zip(&given).all(|(a, b)| (a - b).abs() < 1e-13));
        }
    }

    #[test]
    fn numbers_of_points_have_small_factors() {
        assert_eq!(
            [0, 1, 11, 61, 83, 127, 128, 254].map(quick),
            [0, 1, 10, 60, 81, 126, 128, 252]
        );
    }

    #[test]
    fn what_is_no_field_is_refused() {
        assert!(BoundaryElements::try_new(&[1.0; 4], [2, 2], [1.0; 2]).is_err_and(|e| e.to_string().contains("rms")));
        assert!(BoundaryElements::try_new(&[1.0; 4], [2, 3], [1.0; 2]).is_err());
        assert!(BoundaryElements::try_new(&[0.0, 1.0, f64::NAN, 0.0], [2, 2], [1.0; 2]).is_err());
        let mut solver = BoundaryElements::try_new(&[0.0, 1.0, 2.0, 0.0], [2, 2], [1.0; 2]).unwrap();
        assert!(solver.press(0.0, &mut vec![]).is_err());
    }

    /// Turned by 90 degrees and in other units, the contact is the same.
    #[test]
    fn units_and_axes_do_not_matter() {
        let (nx, ny) = (48, 40);
        let height = |i: usize, j: usize| {
            1e-6 * ((0.9 * i as f64).sin() * (0.7 * j as f64).cos() + (0.31 * (i + 2 * j) as f64).sin())
        };
        let heights: Vec<f64> = (0..nx * ny).map(|k| height(k % nx, k / nx)).collect();
        let turned: Vec<f64> = (0..nx * ny).map(|k| 1e3 * height(k / ny, k % ny)).collect();
        let steps = [10e-6, 14e-6];
        let mut first = BoundaryElements::try_new(&heights, [nx, ny], steps).unwrap();
        let mut second = BoundaryElements::try_new(&turned, [ny, nx], [1e3 * steps[1], 1e3 * steps[0]]).unwrap();
        for pressure in [1e-4, 1e-3, 1e-2] {
            let a = first.press(pressure, &mut vec![]).unwrap();
            let b = second.press(pressure, &mut vec![]).unwrap();
            assert!(
                (b.separation / a.separation / 1e3 - 1.0).abs() < 1e-3 && (a.area - b.area).abs() < 1e-3,
                "{a:?} {b:?}"
            );
        }
    }
}
