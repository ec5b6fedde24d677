//! Does adhesion matter, and where does yield begin (section 3.2.1 of the method paper)?
//!
//! # Critical interference, eq. (45)
//! An asperity of effective radius `R` begins to yield at the interference
//!
//! <div>
//! $$ \omega_c = \left( \frac{\pi K H}{2 E^*} \right)^2 R, \qquad K = 0.454 + 0.41 \nu, $$
//! </div>
//!
//! `H` the hardness. Its ratio to the intermolecular distance, `epsilon/omega_c`, is the paper's first measure of
//! adhesion. Source: W. R. Chang, I. Etsion and D. B. Bogy, *An elastic-plastic model for the contact of rough
//! surfaces*, J. Tribol. 109, 1987.
//!
//! # Adhesive traction
//! [`Adhesion`] attracts surfaces at the separation `Z` with the traction of the Lennard-Jones potential, which is zero
//! at the intermolecular distance `epsilon` and whose integral from there is the work of adhesion `w`. An asperity
//! pair not yet in contact, `Z_0 = epsilon - omega` apart at interference `omega <= 0`, is attracted by the sum over a
//! paraboloid; a pair in contact keeps the shape that Hertz pressure gives it, stands at `epsilon` within the contact
//! circle of radius `a = sqrt(R omega)` and is attracted around it:
//!
//! <div>
//! $$ p(Z) = \frac{8 w}{3 \epsilon} \left[ \left( \frac{\epsilon}{Z} \right)^3 - \left( \frac{\epsilon}{Z} \right)^9
//! \right], \qquad
//! F = 2 \pi R w \cdot \frac{4}{3} \left[ \left( \frac{\epsilon}{Z_0} \right)^2
//! - \frac{1}{4} \left( \frac{\epsilon}{Z_0} \right)^8 \right] \quad (\omega \le 0), $$
//! </div>
//! <div>
//! $$ F = 2 \pi \int_a^{\infty} p(\epsilon + z(r)) \, r \, dr, \qquad
//! z = \frac{1}{\pi R} \left[ a \sqrt{r^2 - a^2} + (r^2 - 2 a^2) \arccos \frac{a}{r} \right] \quad (\omega > 0). $$
//! </div>
//!
//! At `omega = 0` both are the pull-off force `2 pi R w` of a point contact. `F / (2 pi R w)` depends on
//! `omega/epsilon` alone and grows as `0.743 (omega/epsilon)^(1/3)` when that is large. The integral is evaluated here
//! to 1e-12; no empirical fit is used. Sources: B. V. Derjaguin, V. M. Muller and Y. P. Toporov, *Effect of contact
//! deformations on the adhesion of particles*, J. Colloid Interface Sci. 53, 1975; for rough metal surfaces
//! W. R. Chang, I. Etsion and D. B. Bogy, *Adhesion model for metallic rough surfaces*, J. Tribol. 110, 1988. The
//! method paper takes its curve from L. Kogut and I. Etsion, *Adhesion in elastic-plastic spherical microcontact*,
//! J. Colloid Interface Sci. 261, 2003, with the profile by finite elements in place of Hertz's.
//!
//! # Validity
//! Elastic asperities (`omega < omega_c`), and a profile that adhesion does not change: [`Adhesion::tabor_parameter`]
//! small. Where it is large the solution of Johnson, Kendall and Roberts (1971) holds, whose adhesive part at the same
//! interference `omega >= 0` is between `pi R w` and `(4/3) pi R w`: less. The traction computed here is then an upper
//! estimate, and what it finds negligible is negligible.
//!
//! # Parameters
//! | parameter | unit | method paper |
//! |---|---|---|
//! | work of adhesion `w` | J/m^2 | 2.5 |
//! | intermolecular distance `epsilon` | m | 0.4e-9 |
//! | hardness `H` | Pa | 9.47e9 |
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! let gaps = GapDistribution::try_from_quantiles(&[0.0, 0.1, 0.5, 1.0], &[0.0, 8e-6, 14e-6, 28e-6])?;
//! let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.4e-3; 2])?;
//! let adhesion = Adhesion::try_new(2.5, 0.4e-9)?;
//! let adhesive = adhesion.mean_traction(&population, 5e-6);
//! let curves = AsperitySumCurves::try_new(population, ElasticPair::new(192.85e9, 0.29), TangentialReading::Mindlin)?;
//! let elastic = curves.normal(5e-6).0;
//! assert!(10.0 * adhesive < elastic);
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use core::f64::consts::PI;

use crate::error::Error;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::require_positive;
use crate::physics::hertz::ElasticPair;
use crate::physics::population::AsperityPopulation;

/// Hardness coefficient `K = 0.454 + 0.41 nu`.
pub fn hardness_coefficient(poisson_ratio: f64) -> f64 {
    0.454 + 0.41 * poisson_ratio
}

/// Critical interference `omega_c = (pi K H / (2 E*))^2 R` (m) at which an asperity begins to yield, from the hardness
/// `H` (Pa) and the effective radius `R` (m).
pub fn critical_interference(material: &ElasticPair, hardness: f64, radius: f64) -> f64 {
    let k = hardness_coefficient(material.poisson_ratio);
    let strain = PI * k * hardness / (2.0 * material.composite_modulus());
    strain * strain * radius
}

/// Attraction between the surfaces of two bodies; see the [module](self).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adhesion {
    work: f64,
    distance: f64,
}

impl Adhesion {
    /// From the work of adhesion `w` (J/m^2) and the intermolecular distance `epsilon` (m).
    ///
    /// # Errors
    /// [`Error::Parameter`] for a value that is not finite and above zero.
    pub fn try_new(work_of_adhesion: f64, intermolecular_distance: f64) -> Result<Self, Error> {
        require_positive("work_of_adhesion", work_of_adhesion, "J/m^2")?;
        require_positive("intermolecular_distance", intermolecular_distance, "m")?;
        Ok(Self {
            work: work_of_adhesion,
            distance: intermolecular_distance,
        })
    }

    /// Work of adhesion `w` (J/m^2).
    pub fn work(&self) -> f64 {
        self.work
    }

    /// Intermolecular distance `epsilon` (m).
    pub fn intermolecular_distance(&self) -> f64 {
        self.distance
    }

    /// Dimensionless intermolecular distance `epsilon/omega_c`, with `omega_c` (m) from [`critical_interference`].
    pub fn relative_distance(&self, omega_c: f64) -> f64 {
        self.distance / omega_c
    }

    /// Tabor's parameter `(R w^2 / (E*^2 epsilon^3))^(1/3)` of an asperity pair of effective radius `R` (m): the
    /// deformation that adhesion causes over the distance at which it acts. D. Tabor, *Surface forces and surface
    /// interactions*, J. Colloid Interface Sci. 58, 1977.
    pub fn tabor_parameter(&self, material: &ElasticPair, radius: f64) -> f64 {
        let strain = self.work / (material.composite_modulus() * self.distance);
        (radius / self.distance * strain * strain).powf(1.0 / 3.0)
    }

    /// Attraction `p(Z)` (Pa) of two planes at the separation `Z` (m); negative below `epsilon`.
    pub fn traction(&self, separation: f64) -> f64 {
        let cube = (self.distance / separation).powi(3);
        8.0 / 3.0 * self.work / self.distance * cube * (1.0 - cube * cube)
    }

    /// Attraction (N) of an asperity pair of effective radius `radius` (m) at the interference `omega` (m) (negative:
    /// the gap still open).
    pub fn asperity_force(&self, radius: f64, interference: f64) -> f64 {
        2.0 * PI * radius * self.work * shape(interference / self.distance)
    }

    /// Attraction per nominal area (Pa) of the asperities of `population`, loaded and not yet touching, under the
    /// interference `u_n` (m) of any sign: `n_A` times the mean of [`asperity_force`](Self::asperity_force) at
    /// `u_n - s`.
    ///
    /// Costs some microseconds per quantile or sample: a companion for reports, not for evaluation at points.
    pub fn mean_traction(&self, population: &AsperityPopulation, u_n: f64) -> f64 {
        let mean: f64 = population
            .gaps()
            .pieces()
            .map(|(start, width, probability)| {
                let upper = (u_n - start) / self.distance;
                probability * mean_shape(upper, width / self.distance)
            })
            .sum();
        population.density() * 2.0 * PI * population.effective_radius() * self.work * mean
    }
}

/// Mean of [`shape`] from `upper - width` to `upper`.
fn mean_shape(upper: f64, width: f64) -> f64 {
    let middle = upper - 0.5 * width;
    // At zero the force begins to rise as the power 3/2.
    let near_contact = upper > 0.0 && upper < 5.0 * width && width > 1e-6;
    if width > 0.1 * (1.0 + middle.abs()) || near_contact {
        return (primitive(upper) - primitive(upper - width)) / width;
    }
    // A difference of primitives would cancel; three Gauss points are good for 1e-9 over so short a piece.
    let at = 0.5 * width * 0.6_f64.sqrt();
    (5.0 * (shape(middle - at) + shape(middle + at)) + 8.0 * shape(middle)) / 18.0
}

/// `F / (2 pi R w)` at `l = omega/epsilon`.
fn shape(l: f64) -> f64 {
    if l <= 0.0 {
        let q = 1.0 / (1.0 - l);
        4.0 / 3.0 * q * q * (1.0 - 0.25 * q.powi(6))
    } else if l < TOUCHING {
        1.0
    } else {
        let l = l.min(LARGEST);
        // q^3 - q^9.
        let p = |q: f64, rest: f64| q * q * q * rest * (1.0 + q * (1.0 + q * (1.0 + q * (1.0 + q * (1.0 + q)))));
        8.0 / 3.0 * l * outside_contact(l, p)
    }
}

/// Integral of [`shape`] from minus infinity to `l`.
fn primitive(l: f64) -> f64 {
    let open = |q: f64| 4.0 / 3.0 * q * (1.0 - q.powi(6) / 28.0);
    if l <= 0.0 {
        open(1.0 / (1.0 - l))
    } else if l < TOUCHING {
        open(1.0) + l
    } else {
        let l = l.min(LARGEST);
        // The integral over l of l (q^3 - q^9), q = 1/(1 + l h), is l^2 q^2 (28 - sum_k (k + 1) q^k)/56, k = 0..6;
        // 1 - q divided out of the difference.
        let p = |q: f64, rest: f64| {
            let factor = 27.0 + q * (25.0 + q * (22.0 + q * (18.0 + q * (13.0 + q * 7.0))));
            q * q * rest * factor / 56.0
        };
        open(1.0) + 8.0 / 3.0 * l * l * outside_contact(l, p)
    }
}

/// Below this `omega/epsilon` the force is that of a point contact: it deviates as the power 3/2.
const TOUCHING: f64 = 1e-11;
/// Where interferences are cut off to keep powers of them finite.
const LARGEST: f64 = 1e60;

/// `integral of p(q, 1 - q) x dx` over `x = r/a` from 1 to infinity, `q = epsilon/Z = 1/(1 + l h(x))`.
///
/// With `x^2 = 1 + s^2`, `x dx = s ds` and `pi h = s + (s^2 - 1) arctan s`. The trapezoidal rule in `ln s` converges
/// exponentially: the integrand decays as powers of `s` on both sides of `l h = 1`.
fn outside_contact(l: f64, p: impl Fn(f64, f64) -> f64) -> f64 {
    const STEP: f64 = 0.15;
    // l h is 1 near here, as h is 4 s^3/(3 pi) for small s and s^2/2 for large s.
    let middle = (2.0 / l).sqrt().max((0.75 * PI / l).powf(1.0 / 3.0));
    let mut sum = 0.0;
    for k in -64..=124 {
        let s = middle * (STEP * f64::from(k)).exp();
        let lh = l * s * hertz_gap_over_s(s);
        sum += s * s * p(1.0 / (1.0 + lh), lh / (1.0 + lh));
    }
    STEP * sum
}

/// `(s + (s^2 - 1) arctan s)/(pi s)`.
fn hertz_gap_over_s(s: f64) -> f64 {
    let ss = s * s;
    if s > 0.25 {
        return (1.0 + (s - 1.0 / s) * s.atan()) / PI;
    }
    // The terms cancel down to s^2: series with (1/(2k - 1) + 1/(2k + 1)) (-1)^(k + 1) s^(2k).
    let (mut sum, mut power) = (0.0, ss);
    for k in 1..15 {
        let k = f64::from(k);
        sum += power * (1.0 / (2.0 * k - 1.0) + 1.0 / (2.0 * k + 1.0));
        power *= -ss;
    }
    sum / PI
}
