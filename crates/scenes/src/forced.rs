//! Responses to harmonic forces, and to harmonic motion of the supports.

use super::check::Check;
use super::epmc::sampling;
use super::excitation::{
    BaseMotion, Excitation, ExcitationFields, PointFields, PointForce, check_direction, check_excitation, check_point,
    excitation,
};
use super::units::{Acceleration, Force, Length, Unbalance};
use crate::Error;
use serde::{Deserialize, Serialize};

/// Damping in proportion to mass and stiffness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Rayleigh {
    /// Factor of the mass (1/s).
    pub mass: f64,
    /// Factor of the stiffness of the structure without contact (s).
    pub stiffness: f64,
}

/// Names of the fields of its excitation.
pub(super) static FIELDS: ExcitationFields = ExcitationFields {
    base: ["analyses.forced.base.direction", "analyses.forced.base.motion"],
    point: PointFields {
        node: "analyses.forced.node",
        direction: "analyses.forced.direction",
        terms: "analyses.forced.terms",
    },
};

/// The same of each of several forces.
static OF_SEVERAL: PointFields = PointFields {
    node: "analyses.forced.forces.node",
    direction: "analyses.forced.forces.direction",
    terms: "analyses.forced.forces.terms",
};

/// The same of an unbalance.
static OF_UNBALANCE: PointFields = PointFields {
    node: "analyses.forced.unbalance.node",
    direction: "analyses.forced.unbalance.directions",
    terms: "analyses.forced.unbalance",
};

/// Harmonic motion of all supports together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ForcedBase {
    /// Direction of the motion, a unit vector; either this or `motion` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// In matrices whose coordinates do not show it, how these move when everything moves by one: label, component, factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Vec<(i64, u32, f64)>>,
    /// Amplitudes of its acceleration (acceleration; texts: `m/s^2`, `g`).
    pub levels: Vec<Acceleration>,
}

/// One of several forces of the same frequency; at the response point in its direction, unless `node` and `direction` or `terms` say otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PhasedForce {
    /// Node that the force acts on: in a deck a label or a set of one node, in matrices a label. Not for benchmarks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Direction of the force at the node, a unit vector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// In matrices: factors of the coordinates that the force acts on, in the place of a node: label, component, factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terms: Option<Vec<(i64, u32, f64)>>,
    /// Its amplitude over the level.
    pub factor: f64,
    /// By how much it is ahead (degrees).
    #[serde(default)]
    pub phase_deg: f64,
}

/// A mass that turns about an axis with the frequency of the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RotatingUnbalance {
    /// Node on the axis: in a deck a label or a set of one node, in matrices a label.
    pub node: String,
    /// Directions of the force at the begin of a period and a quarter period later, unit vectors at right angles.
    pub directions: [[f64; 3]; 2],
    /// Masses times their distances from the axis (unbalance; texts: `kg m`, `g mm`).
    pub levels: Vec<Unbalance>,
}

/// A sweep of the frequency at a given rate; one of the two is given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Change of the frequency per second (Hz/s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hz_per_s: Option<f64>,
    /// Or the octaves that it passes per minute.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub octaves_per_minute: Option<f64>,
}

/// How the frequency of a sweep changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepRate {
    /// By so many Hz per second.
    Linear(f64),
    /// By so many octaves per second.
    Logarithmic(f64),
}

impl Sweep {
    /// How its frequency changes.
    pub fn rate(&self) -> SweepRate {
        match self.octaves_per_minute {
            Some(octaves) => SweepRate::Logarithmic(octaves / 60.0),
            None => SweepRate::Linear(self.hz_per_s.unwrap_or(f64::NAN)),
        }
    }

    fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        let fields = [
            ("analyses.forced.sweep.hz_per_s", self.hz_per_s, "Hz/s"),
            (
                "analyses.forced.sweep.octaves_per_minute",
                self.octaves_per_minute,
                "octaves/min",
            ),
        ];
        let given = fields.iter().filter(|(_, rate, _)| rate.is_some()).count();
        check.that(
            given == 1,
            "analyses.forced.sweep",
            given as f64,
            "(of hz_per_s and octaves_per_minute given)",
            "given by exactly one of the two",
        )?;
        for (field, rate, unit) in fields {
            if let Some(rate) = rate {
                check.positive(field, rate, unit)?;
            }
        }
        Ok(())
    }
}

/// What is held from point to point of a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// The amplitude of a force.
    Force,
    /// That of the acceleration of the supports.
    Acceleration,
    /// The unbalance.
    Unbalance,
    /// The amplitude of the response.
    Response,
}

/// Responses to a harmonic force, or to harmonic motion of the supports. A force acts at the response point in its direction, unless `node` and `direction` or `terms` say otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Forced {
    /// Node that the force acts on: in a deck a label or a set of one node, in matrices a label. Not for benchmarks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Direction of the force at the node, a unit vector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// In matrices: factors of the coordinates that the force acts on, in the place of a node: label, component, factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terms: Option<Vec<(i64, u32, f64)>>,
    /// Several forces of the same frequency, in the place of one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forces: Vec<PhasedForce>,
    /// A rotating unbalance, in the place of a force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unbalance: Option<RotatingUnbalance>,
    /// Proportional damping beside `background_damping`: factors of the mass (1/s) and of the stiffness without contact (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rayleigh: Option<Rayleigh>,
    /// All supports move alike, in the place of a force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<ForcedBase>,
    /// Amplitudes of the force (force).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<Force>,
    /// In their place, amplitudes of the first harmonic of the response that are held (length): a controlled test, of which the force is found.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub response_levels: Vec<Length>,
    /// First frequency (Hz).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_hz: Option<f64>,
    /// Last frequency (Hz); above or below the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_hz: Option<f64>,
    /// In their place, frequencies (Hz), ascending or descending, at which the responses are wanted; the curve goes from the first to the last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frequencies_hz: Vec<f64>,
    /// Also what a sweep from the first frequency to the last finds, which does not wait for a steady motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
    /// Whether the stability of the motions is judged, by Floquet multipliers.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stability: bool,
    /// Highest harmonic, 1 to 100.
    #[serde(default = "three")]
    pub harmonics: usize,
    /// Samples per period, 8 to 65536 and more than twice the harmonics.
    #[serde(default = "samples")]
    pub samples: usize,
    /// Residual relative to the elastic forces of the first harmonic, in the energy norm.
    #[serde(default = "tolerance")]
    pub tolerance: f64,
    /// Largest relative change of the motion from one point of a curve to the next.
    #[serde(default = "amplitude_step")]
    pub amplitude_step: f64,
    /// Largest relative change of the frequency from one point of a curve to the next.
    #[serde(default = "frequency_step")]
    pub frequency_step: f64,
}

impl Held {
    /// Unit of its levels.
    pub fn unit(self) -> &'static str {
        match self {
            Held::Force => Force::SI_SYMBOL,
            Held::Acceleration => Acceleration::SI_SYMBOL,
            Held::Unbalance => Unbalance::SI_SYMBOL,
            Held::Response => Length::SI_SYMBOL,
        }
    }
}

impl PhasedForce {
    fn point(&self) -> PointForce {
        PointForce {
            node: self.node.clone(),
            direction: self.direction,
            terms: self.terms.clone(),
        }
    }
}

impl Forced {
    /// These levels between these frequencies (Hz), with defaults for all else.
    pub fn new(levels: Vec<Force>, from_hz: f64, to_hz: f64) -> Self {
        Self {
            node: None,
            direction: None,
            terms: None,
            forces: Vec::new(),
            unbalance: None,
            rayleigh: None,
            base: None,
            levels,
            response_levels: Vec::new(),
            from_hz: Some(from_hz),
            to_hz: Some(to_hz),
            frequencies_hz: Vec::new(),
            sweep: None,
            stability: false,
            harmonics: three(),
            samples: samples(),
            tolerance: tolerance(),
            amplitude_step: amplitude_step(),
            frequency_step: frequency_step(),
        }
    }
}

fn three() -> usize {
    3
}

fn samples() -> usize {
    128
}

fn tolerance() -> f64 {
    1e-9
}

fn amplitude_step() -> f64 {
    0.2
}

fn frequency_step() -> f64 {
    0.02
}

impl Forced {
    /// The base, and where a force acts.
    fn parts(&self) -> (Option<BaseMotion>, PointForce) {
        let base = self.base.as_ref().map(|base| BaseMotion {
            direction: base.direction,
            motion: base.motion.clone(),
        });
        let force = PointForce {
            node: self.node.clone(),
            direction: self.direction,
            terms: self.terms.clone(),
        };
        (base, force)
    }

    /// What drives the structure, each with its part at the begin of a period and that a quarter period later, per unit of the level.
    pub fn excitations(&self) -> Vec<(Excitation, [f64; 2])> {
        if let Some(unbalance) = &self.unbalance {
            let at = |direction| Excitation::Node {
                node: unbalance.node.clone(),
                direction,
            };
            let [first, second] = unbalance.directions.map(at);
            return vec![(first, [1.0, 0.0]), (second, [0.0, 1.0])];
        }
        if self.forces.is_empty() {
            let (base, force) = self.parts();
            return vec![(excitation(base.as_ref(), Some(&force)), [1.0, 0.0])];
        }
        let of = |force: &PhasedForce| {
            let (sine, cosine) = force.phase_deg.to_radians().sin_cos();
            let parts = [force.factor * cosine, -force.factor * sine];
            (excitation(None, Some(&force.point())), parts)
        };
        self.forces.iter().map(of).collect()
    }

    /// Names of the fields that say where forces act.
    pub(super) fn point_fields(&self) -> &'static PointFields {
        match (&self.unbalance, self.forces.is_empty()) {
            (Some(_), _) => &OF_UNBALANCE,
            (None, false) => &OF_SEVERAL,
            (None, true) => &FIELDS.point,
        }
    }

    /// What is held.
    pub fn held(&self) -> Held {
        if self.base.is_some() {
            Held::Acceleration
        } else if self.unbalance.is_some() {
            Held::Unbalance
        } else if !self.response_levels.is_empty() {
            Held::Response
        } else {
            Held::Force
        }
    }

    /// Amplitudes of what is held, in SI.
    pub fn levels(&self) -> Vec<f64> {
        match (&self.base, &self.unbalance) {
            (Some(base), _) => base.levels.iter().map(|level| level.si()).collect(),
            (None, Some(unbalance)) => unbalance.levels.iter().map(|level| level.si()).collect(),
            (None, None) if !self.response_levels.is_empty() => {
                self.response_levels.iter().map(|level| level.si()).collect()
            }
            (None, None) => self.levels.iter().map(|level| level.si()).collect(),
        }
    }

    /// First and last frequency (Hz).
    pub fn range_hz(&self) -> [f64; 2] {
        match (self.frequencies_hz.first(), self.frequencies_hz.last()) {
            (Some(first), Some(last)) => [*first, *last],
            _ => [self.from_hz.unwrap_or(f64::NAN), self.to_hz.unwrap_or(f64::NAN)],
        }
    }

    /// Refuses more than one load.
    fn check_loads(&self, check: &Check<'_>) -> Result<(), Error> {
        let (base, force) = self.parts();
        let has_levels = !self.levels.is_empty() || !self.response_levels.is_empty();
        let loads = [
            ("analyses.forced.base", base.is_some(), false),
            ("analyses.forced.unbalance", self.unbalance.is_some(), false),
            ("analyses.forced.forces", !self.forces.is_empty(), true),
        ];
        let is_single = force != PointForce::default();
        let given = loads.iter().filter(|load| load.1).count() + usize::from(is_single);
        for (field, is_there, allows_levels) in loads {
            check.that(
                !is_there || (given == 1 && (allows_levels || !has_levels)),
                field,
                1.0,
                "(given)",
                "given without another load; base and unbalance have levels of their own",
            )?;
        }
        for force in &self.forces {
            check_point(check, &OF_SEVERAL, &force.point())?;
            let finite = force.factor.is_finite() && force.factor != 0.0;
            let factor = "analyses.forced.forces.factor";
            check.that(finite, factor, force.factor, "", "finite and not zero")?;
            let phase = "analyses.forced.forces.phase_deg";
            check.that(force.phase_deg.is_finite(), phase, force.phase_deg, "degrees", "finite")?;
        }
        let Some(unbalance) = &self.unbalance else {
            return Ok(());
        };
        let field = "analyses.forced.unbalance.directions";
        let [first, second] = unbalance.directions;
        for direction in [first, second] {
            check_direction(check, field, direction)?;
        }
        let cosine: f64 = first.iter().zip(second).map(|(a, b)| a * b).sum();
        check.that(
            cosine.abs() < 1e-6,
            field,
            cosine,
            "(cosine of their angle)",
            "at right angles",
        )
    }

    /// Refuses frequencies that are none, or not in order.
    fn check_frequencies(&self, check: &Check<'_>) -> Result<(), Error> {
        let listed = !self.frequencies_hz.is_empty();
        let given = [self.from_hz, self.to_hz].into_iter().flatten().count();
        check.that(
            given == if listed { 0 } else { 2 },
            "analyses.forced.from_hz",
            given as f64,
            "(of from_hz and to_hz given)",
            "given together with analyses.forced.to_hz, or both left out where analyses.forced.frequencies_hz are given",
        )?;
        for frequency in &self.frequencies_hz {
            check.positive("analyses.forced.frequencies_hz", *frequency, "Hz")?;
        }
        let ordered = |before: fn(&f64, &f64) -> bool| self.frequencies_hz.is_sorted_by(before);
        check.that(
            !listed || (self.frequencies_hz.len() > 1 && (ordered(|a, b| a < b) || ordered(|a, b| a > b))),
            "analyses.forced.frequencies_hz",
            self.frequencies_hz.len() as f64,
            "(frequencies)",
            "at least two, ascending or descending, each once",
        )?;
        let [from, to] = self.range_hz();
        check.positive("analyses.forced.from_hz", from, "Hz")?;
        check.positive("analyses.forced.to_hz", to, "Hz")?;
        check.that(
            from != to,
            "analyses.forced.to_hz",
            to,
            "Hz",
            "another frequency than analyses.forced.from_hz",
        )
    }

    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>, is_matrices: bool) -> Result<(), Error> {
        sampling(
            check,
            ["analyses.forced.harmonics", "analyses.forced.samples"],
            self.harmonics,
            self.samples,
        )?;
        let (base, force) = self.parts();
        check_excitation(check, &FIELDS, base.as_ref(), Some(&force), is_matrices)?;
        self.check_loads(check)?;
        if let Some(sweep) = &self.sweep {
            let one = self.forces.is_empty() && matches!(self.held(), Held::Force | Held::Acceleration);
            check.that(
                one && self.rayleigh.is_none(),
                "analyses.forced.sweep",
                1.0,
                "(given)",
                "given with one force or a moving base of given levels, and with background_damping or a damping matrix in the place of rayleigh",
            )?;
            sweep.validate(check)?;
        }
        if let Some(rayleigh) = self.rayleigh {
            check.not_negative("analyses.forced.rayleigh.mass", rayleigh.mass, "1/s")?;
            check.not_negative("analyses.forced.rayleigh.stiffness", rayleigh.stiffness, "s")?;
        }
        check.that(
            self.levels.is_empty() || self.response_levels.is_empty(),
            "analyses.forced.response_levels",
            self.response_levels.len() as f64,
            "(levels)",
            "left out where levels of the force are given",
        )?;
        let levels = self.levels();
        check.that(
            !levels.is_empty(),
            "analyses.forced.levels",
            0.0,
            "(levels)",
            "at least one",
        )?;
        for level in levels {
            check.positive("analyses.forced.levels", level, self.held().unit())?;
        }
        self.check_frequencies(check)?;
        for (field, step) in [
            ("analyses.forced.amplitude_step", self.amplitude_step),
            ("analyses.forced.frequency_step", self.frequency_step),
        ] {
            check.that(step > 0.0 && step <= 1.0, field, step, "", "above 0 and at most 1")?;
        }
        check.that(
            self.tolerance >= 1e-13 && self.tolerance <= 1e-3,
            "analyses.forced.tolerance",
            self.tolerance,
            "",
            "between 1e-13 and 1e-3",
        )
    }
}
