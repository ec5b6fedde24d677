//! Quadrature rules on the reference square and triangle, and at a single point.

use crate::Error;
use crate::shape::{Domain, Shape};

/// One quadrature point of a reference element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Natural coordinates.
    pub xi: [f64; 2],
    /// Weight; weights sum to the area of the reference element (4 for the square, 1/2 for the triangle, 1 for a point).
    pub weight: f64,
}

/// Rules for all reference shapes at one level of accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct Quadrature {
    square: Vec<Point>,
    triangle: Vec<Point>,
    /// Abscissae and weights on -1 to 1.
    line: Vec<(f64, f64)>,
}

/// Rule of twelve points on the triangle, exact to degree 6.
const TWELVE_POINTS: [(f64, f64, f64); 3] = [
    (0.116_786_275_726_379, 0.501_426_509_658_179, 0.249_286_745_170_910),
    (0.050_844_906_370_207, 0.873_821_971_016_996, 0.063_089_014_491_502),
    (0.082_851_075_618_374, 0.053_145_049_844_817, 0.310_352_451_033_784),
];

impl Quadrature {
    /// Gauss-Legendre `n x n` on the square (`n` = 1 ... 5, exact to degree `2n - 1`); on the triangle 1, 3, 6 or 12
    /// points (n = 1, 2, 3, 4 and 5; exact to degree 1, 2, 4, 6; Dunavant 1985, DOI 10.1002/nme.1620210612).
    ///
    /// # Errors
    /// [`Error::Quadrature`] for other numbers.
    pub fn try_new(per_direction: usize) -> Result<Self, Error> {
        let orbits: &[(f64, f64, f64)] = match per_direction {
            1 => &[(1.0, 1.0 / 3.0, 1.0 / 3.0)],
            2 => &[(1.0 / 3.0, 2.0 / 3.0, 1.0 / 6.0)],
            3 => &[
                (0.223_381_589_678_011, 0.108_103_018_168_070, 0.445_948_490_915_965),
                (0.109_951_743_655_322, 0.816_847_572_980_459, 0.091_576_213_509_771),
            ],
            4 | 5 => &TWELVE_POINTS,
            _ => return Err(Error::Quadrature { per_direction }),
        };
        Ok(Self::new(per_direction, orbits))
    }

    /// The finest rules.
    pub(crate) fn finest() -> Self {
        Self::new(5, &TWELVE_POINTS)
    }

    /// `orbits` are weights, relative to the area, and area coordinates of the rule on the triangle.
    fn new(per_direction: usize, orbits: &[(f64, f64, f64)]) -> Self {
        let mut triangle = Vec::new();
        for &(weight, a, b) in orbits {
            let c = 1.0 - a - b;
            let same = |p: f64, q: f64| (p - q).abs() < 1e-9;
            // Area coordinates (a, b, c) and all their permutations that differ.
            let points = match (same(a, b), same(b, c)) {
                (true, true) => vec![[a, a]],
                (_, true) => vec![[a, b], [b, a], [b, b]],
                _ => vec![[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]],
            };
            triangle.extend(points.into_iter().map(|xi| Point {
                xi,
                weight: 0.5 * weight,
            }));
        }
        // The published weights have 15 digits; restore the area exactly.
        let sum: f64 = triangle.iter().map(|p| p.weight).sum();
        triangle.iter_mut().for_each(|p| p.weight *= 0.5 / sum);
        let line = gauss_legendre(per_direction);
        let square = line
            .iter()
            .flat_map(|&(eta, v)| {
                line.iter().map(move |&(xi, w)| Point {
                    xi: [xi, eta],
                    weight: v * w,
                })
            })
            .collect();
        Self { square, triangle, line }
    }

    /// Abscissae and weights on -1 to 1, whose sum is 2.
    pub(crate) fn line(&self) -> &[(f64, f64)] {
        &self.line
    }

    /// The rule on the triangle.
    pub(crate) fn triangle(&self) -> &[Point] {
        &self.triangle
    }

    /// The rule for a shape; a point has its one point at every level.
    pub fn points(&self, shape: &Shape) -> &[Point] {
        match shape.domain {
            Domain::Triangle => &self.triangle,
            Domain::Square => &self.square,
            Domain::Point => &[Point {
                xi: [0.0; 2],
                weight: 1.0,
            }],
        }
    }
}

/// Abscissae and weights on [-1, 1] by Newton's method on the Legendre polynomial.
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = -((i as f64 + 0.75) / (n as f64 + 0.5) * std::f64::consts::PI).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}
