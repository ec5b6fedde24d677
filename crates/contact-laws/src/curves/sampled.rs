//! Contact curves through a few points that were measured or computed elsewhere, such as by boundary elements.
//!
//! Between the points the stiffness is linear, from the middle of each interval to that of the next, where it is the secant's; so the traction rises
//! smoothly, and never softens where the points do not. It begins with no stiffness at the first point, where the traction is zero, and beyond the
//! last one the stiffness stays. Secants that fall are averaged with their neighbours.
//! <div>
//! $$ k\left(\tfrac{u_i + u_{i+1}}{2}\right) = \frac{p_{i+1} - p_i}{u_{i+1} - u_i}, \qquad t_n(u) = \int k \, \mathrm{d} u, \qquad
//! k_x = k_y = r k . $$
//! </div>
//!
//! # Parameters
//! | parameter | unit |
//! |---|---|
//! | `interferences`, rising | m |
//! | `tractions` there, rising from zero | Pa |
//! | `areas` of contact there per nominal area | 1 |
//! | ratio `r` of tangential to normal stiffness, of equal bodies `2 (1 - nu)/(2 - nu)` | 1 |
//!
//! Source of the ratio: R. D. Mindlin, J. Appl. Mech. 16 (1949) 259-268; that it is that of any contact: M. Ciavarella, Int. J. Solids Struct. 35
//! (1998) 2349-2362.
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! // A parabola.
//! let u: Vec<f64> = (0..20).map(|i| 1e-7 * f64::from(i)).collect();
//! let p = u.iter().map(|u| 1e18 * u * u).collect();
//! let area = u.iter().map(|u| 1e4 * u).collect();
//! let curves = SampledCurves::try_new(u, p, area, 0.8)?;
//! let (t_n, k) = curves.normal(1.234e-6);
//! assert!((t_n / (1e18 * 1.234e-6 * 1.234e-6) - 1.0).abs() < 1e-2 && (k / (2e18 * 1.234e-6) - 1.0).abs() < 1e-9);
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use crate::curves::{ContactCurves, CurvesInfo, Exponents};
use crate::error::{Error, Place, require};
use crate::jet::Jet;
use crate::parameters::{Bounds, Parameter};
use alloc::vec::Vec;

const RATIO: Parameter = Parameter::new("tangential_ratio", "1", Bounds::Positive);

pub(super) static INFO: CurvesInfo = CurvesInfo {
    name: "sampled curves",
    reference: "10.1016/S0020-7683(97)00154-6",
    page: "boundary-elements.md",
    parameters: &[
        Parameter::new("interferences", "m", Bounds::Other("rising")),
        Parameter::new("tractions", "Pa", Bounds::Other("rising from zero")),
        Parameter::new("areas", "1", Bounds::Other("from 0 to 1")),
        RATIO,
    ],
};

/// Curves through points.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledCurves {
    /// Where the stiffness has corners (m), with it (Pa/m) and the traction (Pa) there.
    at: Vec<f64>,
    stiffness: Vec<f64>,
    traction: Vec<f64>,
    /// The points, and the areas of contact there.
    interferences: Vec<f64>,
    areas: Vec<f64>,
    ratio: f64,
}

impl SampledCurves {
    /// From the interferences (m), the normal tractions (Pa) and the parts of the area in contact at the points.
    ///
    /// # Errors
    /// [`Error::Length`] for lists of different lengths or fewer than three points, [`Error::Parameter`] for entries out of order or out of bounds.
    pub fn try_new(interferences: Vec<f64>, tractions: Vec<f64>, areas: Vec<f64>, ratio: f64) -> Result<Self, Error> {
        RATIO.check(ratio)?;
        let n = interferences.len();
        for (list, found) in [
            ("interferences", n),
            ("tractions", tractions.len()),
            ("areas", areas.len()),
        ] {
            let expected = n.max(3);
            if found != expected {
                return Err(Error::Length { list, expected, found });
            }
        }
        for i in 0..n {
            let entry = |name, value: f64, unit, ok: bool, text| {
                require(ok && value.is_finite(), name, value, unit, Place::Entry(i), text)
            };
            let rises = |values: &[f64], first: f64| i == 0 && values[0] >= first || i > 0 && values[i] > values[i - 1];
            entry(
                "interferences",
                interferences[i],
                "m",
                rises(&interferences, f64::MIN),
                "above the entry before",
            )?;
            let zero = i > 0 || tractions[0] == 0.0;
            entry(
                "tractions",
                tractions[i],
                "Pa",
                zero && rises(&tractions, 0.0),
                "above the entry before, the first 0",
            )?;
            entry(
                "areas",
                areas[i],
                "(no unit)",
                (0.0..=1.0).contains(&areas[i]),
                "from 0 to 1",
            )?;
        }
        let secants: Vec<f64> = (1..n)
            .map(|i| (tractions[i] - tractions[i - 1]) / (interferences[i] - interferences[i - 1]))
            .collect();
        let widths: Vec<f64> = (1..n).map(|i| interferences[i] - interferences[i - 1]).collect();
        let secants = without_falls(&secants, &widths);
        let (mut at, mut stiffness, mut traction) = (alloc::vec![interferences[0]], alloc::vec![0.0], alloc::vec![0.0]);
        for (i, secant) in secants.into_iter().enumerate() {
            let middle = 0.5 * (interferences[i] + interferences[i + 1]);
            let last = at.len() - 1;
            let sum = traction[last] + 0.5 * (stiffness[last] + secant) * (middle - at[last]);
            at.push(middle);
            stiffness.push(secant);
            traction.push(sum);
        }
        Ok(Self {
            at,
            stiffness,
            traction,
            interferences,
            areas,
            ratio,
        })
    }

    /// Stiffness with its slope, and traction.
    fn evaluate(&self, u: f64) -> (Jet, f64) {
        let i = self.at.partition_point(|at| *at < u);
        let (value, slope, traction) = if i == 0 {
            (0.0, 0.0, 0.0)
        } else {
            let from = u - self.at[i - 1];
            let slope = match self.at.get(i) {
                Some(at) => (self.stiffness[i] - self.stiffness[i - 1]) / (at - self.at[i - 1]),
                None => 0.0,
            };
            let traction = self.traction[i - 1] + (self.stiffness[i - 1] + 0.5 * slope * from) * from;
            (self.stiffness[i - 1] + slope * from, slope, traction)
        };
        let stiffness = Jet {
            value,
            slope,
            curvature: 0.0,
        };
        (stiffness, traction)
    }
}

/// The rising values that are nearest to some in the square, with weights: neighbours that fall are averaged (pool adjacent violators).
fn without_falls(values: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut pools: Vec<(f64, f64, usize)> = Vec::with_capacity(values.len());
    for (&value, &weight) in values.iter().zip(weights) {
        let mut pool = (value, weight, 1);
        while let Some(&(before, of_before, count)) = pools.last()
            && before > pool.0
        {
            let sum = of_before + pool.1;
            pool = ((before * of_before + pool.0 * pool.1) / sum, sum, count + pool.2);
            pools.pop();
        }
        pools.push(pool);
    }
    pools
        .into_iter()
        .flat_map(|(value, _, count)| core::iter::repeat_n(value, count))
        .collect()
}

impl ContactCurves for SampledCurves {
    fn info(&self) -> &'static CurvesInfo {
        &INFO
    }

    fn normal(&self, u_n: f64) -> (f64, f64) {
        let (stiffness, traction) = self.evaluate(u_n);
        (traction, stiffness.value)
    }

    fn tangential(&self, u_n: f64) -> [Jet; 2] {
        let (stiffness, _) = self.evaluate(u_n);
        let tangential = Jet {
            value: self.ratio * stiffness.value,
            slope: self.ratio * stiffness.slope,
            curvature: 0.0,
        };
        [tangential; 2]
    }

    fn exponents(&self) -> Exponents {
        Exponents {
            normal: 2.0,
            tangential: [1.0; 2],
        }
    }

    fn contact_area_ratio(&self, u_n: f64) -> Option<f64> {
        let i = self.interferences.partition_point(|u| *u < u_n);
        let last = self.areas.len() - 1;
        Some(if i == 0 {
            self.areas[0]
        } else if i > last {
            self.areas[last]
        } else {
            let share = (u_n - self.interferences[i - 1]) / (self.interferences[i] - self.interferences[i - 1]);
            self.areas[i - 1] + share * (self.areas[i] - self.areas[i - 1])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(p: impl Fn(f64) -> f64, n: u32) -> SampledCurves {
        let u: Vec<f64> = (0..=n).map(|i| 1e-6 * f64::from(i) / f64::from(n)).collect();
        let (p, area) = (u.iter().map(|u| p(*u)).collect(), u.iter().map(|u| 1e5 * u).collect());
        SampledCurves::try_new(u, p, area, 0.8).unwrap()
    }

    #[test]
    fn curves_are_met_with_second_order() {
        let error = |n: u32| {
            let curves = of(|u| 1e24 * u.powi(3), n);
            let at = |i: u32| 1e-6 * (0.3 + 0.6 * f64::from(i) / 50.0);
            let of_traction = |u: f64| (curves.normal(u).0 / (1e24 * u.powi(3)) - 1.0).abs();
            (0..50).map(|i| of_traction(at(i))).fold(0.0, f64::max)
        };
        assert!(
            error(40) < 6e-3 && error(20) / error(40) > 3.0,
            "{} {}",
            error(20),
            error(40)
        );
    }

    #[test]
    fn what_falls_is_averaged_and_what_is_no_curve_refused() {
        let curves =
            SampledCurves::try_new(vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 3.0, 4.0, 9.0], vec![0.0; 4], 1.0).unwrap();
        assert_eq!(curves.stiffness, [0.0, 2.0, 2.0, 5.0]);
        assert_eq!(curves.normal(0.0).1, 0.0);
        // Beyond the last point.
        let (at_three, k) = curves.normal(3.0);
        assert_eq!(k, 5.0);
        assert!((curves.normal(5.0).0 - at_three - 10.0).abs() < 1e-12);
        let of =
            |u: [f64; 3], p: [f64; 3], a: [f64; 3]| SampledCurves::try_new(u.to_vec(), p.to_vec(), a.to_vec(), 0.8);
        let (u, p, a) = ([0.0, 1.0, 2.0], [0.0, 1.0, 3.0], [0.0, 0.1, 0.2]);
        assert!(of(u, p, a).is_ok());
        for made in [
            of([0.0, 0.0, 2.0], p, a),
            of(u, [1.0, 2.0, 3.0], a),
            of(u, [0.0, 1.0, 1.0], a),
            of(u, p, [0.0, 0.1, 1.2]),
        ] {
            assert!(made.is_err(), "{made:?}");
        }
        assert!(SampledCurves::try_new(vec![0.0, 1.0], vec![0.0, 1.0], vec![0.0; 2], 0.8).is_err());
        assert!(SampledCurves::try_new(u.to_vec(), p.to_vec(), vec![0.0; 2], 0.8).is_err());
    }

    #[test]
    fn areas_are_those_of_the_points() {
        let curves = of(|u| 1e18 * u * u, 10);
        for (u, expected) in [(-1.0, 0.0), (0.55e-6, 0.055), (2e-6, 0.1)] {
            assert!((curves.contact_area_ratio(u).unwrap() - expected).abs() < 1e-12);
        }
    }
}
