//! A single asperity that yields: normal force and contact radius at first loading, unloading and reloading.
//!
//! Two equal spheres with the effective radius `R`, in the interference `w` (m). `E* = E/(2 (1 - nu^2))`.
//!
//! # Elastic
//! Hertz: `F = 4/3 E* sqrt(R) w^(3/2)`, `a = sqrt(R w)`.
//!
//! # First loading beyond the onset of yield
//! With the yield strength `S`, the tangent modulus `H` of the hardening material and
//! <div>
//! $$ C = 1.295 \, e^{0.736 \nu}, \qquad \delta_y = 4 R \left(\frac{\pi C S}{4 E^*}\right)^2, \qquad
//! W = \frac{w}{\delta_y}, \qquad B = 0.14 \, e^{23 S / (2 E^*)}, \qquad
//! F_c = \frac{4}{3} \left(\frac{R}{E^*}\right)^2 \left(\frac{\pi C S}{2}\right)^3, $$
//! $$ a_p = \frac{\pi C S R}{2 E^*} \sqrt{W \left(\frac{W}{1.9}\right)^B}, \qquad
//! a = a_e + (a_p - a_e) \, e^Y, \qquad
//! Y = \frac{-2 \sqrt{E/S} \, (H/E)^{1 - (w - \delta_y)/(4 R)}}
//! {\left(4 - 3 \exp(-2 \sqrt{E/S} \, H/E)\right) (1 - H/E)}, $$
//! $$ \frac{P}{S} = 2.84 - 0.92 \left(1 - \cos \frac{\pi a}{2 R}\right), \qquad
//! F_p = F_c \left( e^{-W^{5/12}/4} \, W^{3/2} + \frac{4 P}{C S} \left(1 - e^{-W^{5/9}/25}\right) W \right), $$
//! $$ F = F_p + (F_e - F_p) \left(1 - e^{-3.3 H/E}\right) \qquad (w > 1.9 \, \delta_y) . $$
//! </div>
//!
//! `H = 0` means `Y = 0`. The angle of the cosine ends at `pi`. Beyond the onset force and radius rise at least up to
//! `w = R/2`.
//!
//! # Unloading and reloading
//! Below the largest past interference `d` with the force `F_d` contact is that of a flatter sphere in a dent:
//! <div>
//! $$ b = d \left(1 - \frac{F_d}{\tfrac{4}{3} E^* \sqrt{R} \, d^{3/2}}\right), \qquad
//! R_b = \frac{F_d^2}{(\tfrac{4}{3} E^*)^2 (d - b)^3}, \qquad
//! F = \tfrac{4}{3} E^* \sqrt{R_b} \, (w - b)^{3/2}, \qquad a = \sqrt{R_b (w - b)} . $$
//! </div>
//!
//! Where `F_d` is above the elastic force the residual depth `b` is zero.
//!
//! # Two jumps
//! - Just beyond `1.9 delta_y` the published force jumps, by a share that depends on Poisson's ratio most of all. With
//!   `S/E = 0.0017` and `H/E = 0.003` it is
//!
//!   | `nu` | 0 | 0.2 | 0.3 | 0.4 | 0.5 |
//!   |---|---|---|---|---|---|
//!   | jump of the force | +7.4 % | +2.6 % | +0.47 % | -1.5 % | -3.4 % |
//!
//!   For `nu = 0.3` it is 0.44 to 0.48 % for `S/E` from 0.0005 to 0.005 and `H/E` up to 0.015, and 0.09 % for `H/E = 0.5`.
//! - At `w = d` the force is continuous, the contact radius is not: unloading begins with `sqrt(R d)`, which is less than what
//!   first loading ends with: for `S/E = 0.0017` and `H/E = 0.003` by 3 % at 3, 11 % at 10 and 30 % at 100
//!   times `delta_y`. So the tangential stiffness depends on whether the load rises or falls.
//!
//! Across a jump there need not be an equilibrium. With [`YieldCurves::Continuous`] the radius never jumps, and the force does not jump
//! up: contact is elastic until the published plastic force falls below the elastic one. (Where it is below at `1.9 delta_y` already, for `nu`
//! of 0.4 and more, the jump down stays.) The radius of first loading is that with which unloading begins.
//!
//! Sources: loading H. Ghaednia et al., *Strain hardening from elastic-perfectly plastic to perfectly elastic
//! indentation single asperity contact*, Front. Mech. Eng. 5 (2019) 60; unloading M. R. W. Brake, *An analytical
//! elastic plastic contact model with strain hardening and frictional effects for normal and oblique impacts*, Int. J.
//! Solids Struct. 62 (2015) 104-123; both as in J. H. Porter and M. R. W. Brake, *Towards a predictive, physics-based
//! friction model for the dynamics of jointed structures*, Mech. Syst. Signal Process. 192 (2023) 110210, where `Y` has
//! the form above and not that of the printed equation.
#![doc = include_str!("../../katex.html")]

use crate::choice::choices;
use crate::error::{Error, Place, require};
use crate::jet::Jet;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::require_positive;
use crate::physics::hertz::ElasticPair;
use crate::physics::sliding_yield::ceb_factor;
use core::f64::consts::PI;

choices! {
    /// What is made of the jumps in the published curves.
    pub enum YieldCurves, "YIELD", "Jumps in the published curves of yield" {
        Continuous = "continuous", 0, "They are taken out.";
        Published = "published", 1, "They stay.";
    }
}

/// Interference of the onset of yield in the force, over `delta_y`.
const ONSET: f64 = 1.9;

/// How a material yields.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Yield {
    /// Yield strength (Pa).
    pub strength: f64,
    /// Tangent modulus of the hardening material (Pa).
    pub tangent_modulus: f64,
    /// What is made of the jumps in the published curves.
    pub curves: YieldCurves,
}

/// What of the past an asperity remembers in the normal direction. Zeros: it has touched nothing yet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dent {
    /// Largest interference (m).
    pub interference: f64,
    /// Normal force there (N).
    pub force: f64,
}

/// A contact that unloads and reloads: a Hertz contact that begins at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unloading {
    /// Interference at which contact ends (m).
    pub residual_depth: f64,
    /// Normal force over the interference beyond it to the power 3/2 (N/m^(3/2)).
    pub stiffness: f64,
}

/// An asperity pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asperity {
    material: ElasticPair,
    radius: f64,
    /// `4/3 E* sqrt(R)` (N/m^(3/2)).
    hertz: f64,
    /// `8 G* sqrt(R)` (N/m^(3/2)): tangential stiffness over the root of the interference.
    mindlin: f64,
    plastic: Option<Plastic>,
}

/// Constants of loading beyond the onset of yield.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plastic {
    /// Interference of the onset of yield (m).
    onset: f64,
    curves: YieldCurves,
    delta_y: f64,
    /// `S` (Pa).
    strength: f64,
    /// `C`.
    yield_factor: f64,
    /// `B`.
    exponent: f64,
    /// Factor of the slip limit `Ceb`.
    ceb_factor: f64,
    /// `F_c` (N).
    critical_force: f64,
    /// `ln(H/E)`; none without hardening.
    hardening: Option<f64>,
    /// `1 - exp(-3.3 H/E)`.
    elastic_share: f64,
    /// `-2 sqrt(E/S) / ((4 - 3 exp(-2 sqrt(E/S) H/E)) (1 - H/E))`.
    blending: f64,
}

/// Normal force (N) and contact radius (m) as functions of the interference.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Contact {
    /// Normal force.
    pub force: Jet,
    /// Contact radius.
    pub radius: Jet,
}

impl Asperity {
    /// From the material, the effective radius (m) and how the material yields, if it does.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the material is not physical, when radius or yield strength are not above zero, or when
    /// the tangent modulus is not at least zero and below Young's modulus.
    pub fn try_new(material: ElasticPair, radius: f64, yielding: Option<Yield>) -> Result<Self, Error> {
        material.validate()?;
        require_positive("asperity_radius", radius, "m")?;
        let composite = material.composite_modulus();
        let plastic = match yielding {
            None => None,
            Some(yielding) => Some(Plastic::try_new(material, radius, yielding)?),
        };
        let mut asperity = Self {
            material,
            radius,
            hertz: 4.0 / 3.0 * composite * radius.sqrt(),
            mindlin: material.mindlin_modulus() * radius.sqrt(),
            plastic,
        };
        if let Some(plastic) = plastic.filter(|plastic| plastic.curves == YieldCurves::Continuous) {
            let onset = plastic.crossing(&asperity);
            asperity.plastic = Some(Plastic { onset, ..plastic });
        }
        Ok(asperity)
    }

    /// The material.
    pub fn material(&self) -> &ElasticPair {
        &self.material
    }

    /// Effective radius (m).
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Interference of the onset of yield (m), of published curves `1.9 delta_y`; infinite for an elastic asperity.
    pub fn onset_of_yield(&self) -> f64 {
        self.plastic.map_or(f64::INFINITY, |plastic| plastic.onset)
    }

    /// How the material yields, if it does.
    pub(super) fn yielding(&self) -> Option<&Plastic> {
        self.plastic.as_ref()
    }

    /// Normal force of the elastic contact over the interference to the power 3/2 (N/m^(3/2)).
    pub(crate) fn hertz_factor(&self) -> f64 {
        self.hertz
    }

    /// Tangential stiffness of the elastic contact over the root of the interference (N/m^(3/2)).
    pub(crate) fn mindlin_factor(&self) -> f64 {
        self.mindlin
    }

    /// Tangential stiffness `2 E a / ((2 - nu)(1 + nu))` over the contact radius (Pa).
    pub fn tangential_modulus(&self) -> f64 {
        self.material.mindlin_modulus()
    }

    /// First loading to the interference `w` (m); no contact for `w <= 0`.
    pub fn loading(&self, w: f64) -> Contact {
        match &self.plastic {
            _ if w <= 0.0 => Contact::default(),
            Some(plastic) if w > plastic.onset => match plastic.curves {
                YieldCurves::Published => plastic.loading(self, w),
                YieldCurves::Continuous => Contact {
                    force: plastic.loading(self, w).force,
                    radius: self.hertzian(w).radius,
                },
            },
            _ => self.hertzian(w),
        }
    }

    /// Contact radius (m) of [`Self::loading`] alone, which takes less.
    pub(crate) fn loading_radius(&self, w: f64) -> Jet {
        match &self.plastic {
            _ if w <= 0.0 => Jet::default(),
            Some(plastic) if w > plastic.onset && plastic.curves == YieldCurves::Published => plastic.radius(self, w),
            _ => self.hertzian(w).radius,
        }
    }

    /// Contact radius (m) at first loading to the interference `w` (m) by the published curves, whichever are in use.
    pub fn published_contact_radius(&self, w: f64) -> f64 {
        match &self.plastic {
            _ if w <= 0.0 => 0.0,
            Some(plastic) if w > ONSET * plastic.delta_y => plastic.radius(self, w).value,
            _ => (self.radius * w).sqrt(),
        }
    }

    fn hertzian(&self, w: f64) -> Contact {
        let w = Jet::variable(w);
        Contact {
            force: w.power(1.5) * self.hertz,
            radius: w.power(0.5) * self.radius.sqrt(),
        }
    }

    /// How contact unloads after the largest interference; none where nothing has yielded.
    pub fn unloading(&self, dent: Dent) -> Option<Unloading> {
        (dent.interference > self.onset_of_yield()).then(|| {
            let elastic = dent.interference.sqrt() * self.hertz;
            // As `d - b`, which has all its digits.
            let force = dent.force.max(0.0);
            let beyond = (force / elastic).min(dent.interference);
            Unloading {
                residual_depth: dent.interference - beyond,
                stiffness: force / (beyond * beyond.sqrt()).max(f64::MIN_POSITIVE),
            }
        })
    }

    /// Contact at the interference `w` (m) after a past, and what is remembered then. At the largest past interference
    /// the derivatives are those of unloading.
    pub fn contact(&self, w: f64, dent: Dent) -> (Contact, Dent) {
        let contact = match self.unloading(dent) {
            Some(_) if w > dent.interference => self.loading(w),
            Some(unloading) if w > unloading.residual_depth => {
                let beyond = Jet::variable(w - unloading.residual_depth);
                let root = unloading.stiffness / self.hertz * self.radius.sqrt();
                Contact {
                    force: beyond.power(1.5) * unloading.stiffness,
                    radius: beyond.power(0.5) * root,
                }
            }
            Some(_) => Contact::default(),
            None => self.loading(w),
        };
        let after = Dent {
            interference: w,
            force: contact.force.value,
        };
        (contact, if w > dent.interference { after } else { dent })
    }
}

impl Plastic {
    fn try_new(material: ElasticPair, radius: f64, yielding: Yield) -> Result<Self, Error> {
        let Yield {
            strength,
            tangent_modulus,
            curves,
        } = yielding;
        let modulus = material.youngs_modulus;
        require_positive("yield_strength", strength, "Pa")?;
        require(
            tangent_modulus >= 0.0 && tangent_modulus < modulus,
            "tangent_modulus",
            tangent_modulus,
            "Pa",
            Place::Whole,
            "at least 0 and below Young's modulus",
        )?;
        let composite = material.composite_modulus();
        let yield_factor = 1.295 * (0.736 * material.poisson_ratio).exp();
        let strain = PI * yield_factor * strength / (4.0 * composite);
        let delta_y = 4.0 * radius * strain * strain;
        let per_composite = radius / composite;
        let pressure = 0.5 * PI * yield_factor * strength;
        let critical_force = 4.0 / 3.0 * per_composite * per_composite * pressure * pressure * pressure;
        for (name, value, unit) in [("delta_y", delta_y, "m"), ("critical_force", critical_force, "N")] {
            let requirement = "a number that the floating-point format holds in full: check the yield strength";
            require(value.is_normal(), name, value, unit, Place::Whole, requirement)?;
        }
        let hardening = tangent_modulus / modulus;
        let slenderness = -2.0 * (modulus / strength).sqrt();
        Ok(Self {
            onset: ONSET * delta_y,
            curves,
            delta_y,
            strength,
            yield_factor,
            exponent: 0.14 * (11.5 * strength / composite).min(LARGEST_EXPONENT).exp(),
            ceb_factor: ceb_factor(material.poisson_ratio),
            critical_force,
            hardening: (hardening > 0.0).then(|| hardening.ln()),
            elastic_share: -(-3.3 * hardening).exp_m1(),
            blending: slenderness / ((4.0 - 3.0 * (slenderness * hardening).exp()) * (1.0 - hardening)),
        })
    }

    /// The first interference beyond `1.9 delta_y` at which the plastic force is not above the elastic one (m). It exists: the
    /// one grows linearly at last, the other with the power 3/2.
    fn crossing(&self, asperity: &Asperity) -> f64 {
        let is_above = |w: f64| self.loading(asperity, w).force.value > asperity.hertzian(w).force.value;
        let (mut low, mut high) = (self.onset, self.onset);
        while is_above(high) && high < LARGEST_RATIO * self.delta_y {
            low = high;
            high *= 1.02;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_above(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// `delta_y`.
    pub(super) fn first_yield(&self) -> f64 {
        self.delta_y
    }

    /// `P` at a contact radius (Pa).
    pub(super) fn hardness(&self, radius: f64, contact_radius: Jet) -> Jet {
        pressure(radius, contact_radius) * self.strength
    }

    /// Factor of [`AsperityLimit::Ceb`](crate::AsperityLimit::Ceb).
    pub(super) fn ceb_factor(&self) -> f64 {
        self.ceb_factor
    }

    /// Interference up to where the formulas stay within the numbers, over `delta_y`, and the logarithm of that.
    fn ratio(&self, w: f64) -> [Jet; 2] {
        let ratio = Jet::variable(w.min(LARGEST_RATIO * self.delta_y)) * (1.0 / self.delta_y);
        [ratio, ratio.ln()]
    }

    /// Published contact radius of first loading.
    pub(super) fn radius(&self, asperity: &Asperity, w: f64) -> Jet {
        self.radius_at(asperity, w, self.ratio(w))
    }

    fn radius_at(&self, asperity: &Asperity, w: f64, [ratio, log]: [Jet; 2]) -> Jet {
        let (elastic, radius) = (asperity.hertzian(w).radius, asperity.radius);
        let w = Jet::variable(w.min(LARGEST_RATIO * self.delta_y));
        let growth = ((log - Jet::constant(ONSET.ln())) * (0.5 * self.exponent)).at_most(LARGEST_EXPONENT);
        // `pi C S R/(2 E*) = sqrt(R delta_y)`.
        let plastic_radius = ratio.power(0.5) * growth.exp() * (radius * self.delta_y).sqrt();
        let share = match self.hardening {
            Some(hardening) => {
                let power = Jet::constant(1.0) - (w - Jet::constant(self.delta_y)) * (0.25 / radius);
                let power = (power * hardening).at_most(LARGEST_EXPONENT);
                (power.exp() * self.blending).exp()
            }
            None => Jet::constant(1.0),
        };
        elastic + (plastic_radius - elastic) * share
    }

    /// Published curves of first loading.
    pub(super) fn loading(&self, asperity: &Asperity, w: f64) -> Contact {
        let elastic = asperity.hertzian(w);
        // Of all powers: that of a logarithm costs half as much as the power itself.
        let [ratio, log] = self.ratio(w);
        let contact_radius = self.radius_at(asperity, w, [ratio, log]);
        let pressure = pressure(asperity.radius, contact_radius);
        let contained = ((log * (5.0 / 12.0)).exp() * -0.25).exp() * ratio.power(1.5);
        let full = Jet::constant(1.0) - ((log * (5.0 / 9.0)).exp() * (-1.0 / 25.0)).exp();
        let plastic = (contained + pressure * full * ratio * (4.0 / self.yield_factor)) * self.critical_force;
        Contact {
            force: plastic + (elastic.force - plastic) * self.elastic_share,
            radius: contact_radius,
        }
    }
}

/// `P/S` at a contact radius.
fn pressure(radius: f64, contact_radius: Jet) -> Jet {
    let angle = (contact_radius * (0.5 * PI / radius)).at_most(PI);
    Jet::constant(2.84 - 0.92) + angle.cos() * 0.92
}

/// Exponents, and interferences over `delta_y`, beyond which the formulas leave the numbers: far outside their validity.
const LARGEST_EXPONENT: f64 = 100.0;
const LARGEST_RATIO: f64 = 1e30;
