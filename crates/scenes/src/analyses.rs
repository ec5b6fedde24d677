//! What a scene asks for.

use super::Parameter;
use super::check::Check;
use super::epmc::Epmc;
use super::excitation::{Driver, Excitation};
use super::forced::Forced;
use super::random::Random;
use super::ring_down::RingDown;
use super::shock::Shock;
use super::tightening::Tightening;
use super::units::Length;
use crate::Error;
use cqsma_solver::cqsma::Commit;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Name of the method of [`Analyses::epmc`] in outputs.
pub const EPMC: &str = "epmc";

/// The analyses that a scene asks for; of a scene without this block, the backbone of its first mode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Analyses {
    /// Linearised modes about the prestress, and which of them are followed.
    #[serde(default)]
    pub modes: Modes,
    /// Frequency and damping against amplitude; without it no hysteresis loops are computed.
    #[serde(default = "Backbone::none")]
    pub backbone: Backbone,
    /// Free periodic motions by the extended periodic motion concept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epmc: Option<Epmc>,
    /// Responses to harmonic forces, or to harmonic motion of the supports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forced: Option<Forced>,
    /// Stationary random vibration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub random: Option<Random>,
    /// A shock, followed in time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shock: Option<Shock>,
    /// Free decay in time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ring_down: Option<RingDown>,
    /// Bolts tightened one after the other; without it all at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tightening: Option<Tightening>,
    /// Numbers of the scene, by their paths, that frequency and damping are differentiated by along every backbone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensitivities: Vec<Parameter>,
}

impl Analyses {
    /// Excitations of all analyses apart from forces at the response point, each once.
    pub fn drivers(&self) -> Vec<Driver> {
        let named = |excitation: Excitation, [point, base]: [&'static str; 2]| Driver {
            field: match excitation {
                Excitation::Base(_) => base,
                _ => point,
            },
            excitation,
        };
        let forced = self.forced.iter().flat_map(|asked| {
            let point = asked.point_fields().node;
            let excitations = asked.excitations().into_iter();
            excitations.map(move |(excitation, _)| named(excitation, [point, "analyses.forced.base"]))
        });
        let random = self.random.iter();
        let random = random.map(|asked| {
            named(
                asked.excitation(),
                ["analyses.random.force.node", "analyses.random.base"],
            )
        });
        let shock = self.shock.iter();
        let shock = shock.map(|asked| named(asked.excitation(), ["analyses.shock.force.node", "analyses.shock.base"]));
        let mut found: Vec<Driver> = Vec::new();
        for driver in forced.chain(random).chain(shock) {
            let is_known = found.iter().any(|known| known.excitation == driver.excitation);
            if driver.excitation != Excitation::Response && !is_known {
                found.push(driver);
            }
        }
        found
    }

    /// Number of the recovered row that belongs to an excitation: 0 is the response, those of [`drivers`](Self::drivers) follow.
    pub fn recovered(&self, excitation: &Excitation) -> usize {
        let place = self.drivers().iter().position(|known| known.excitation == *excitation);
        place.map_or(0, |place| place + 1)
    }
}

/// Linearised modes about the prestress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Modes {
    /// How many are computed, 1 to 100.
    pub number: usize,
    /// Those followed, counted from 1, each with results of its own about the same prestress.
    pub followed: Vec<usize>,
}

impl Default for Modes {
    fn default() -> Self {
        Self {
            number: 10,
            followed: vec![1],
        }
    }
}

/// Methods beside CQSMA.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Loops with the contact linearised about the static state (eqs. 34-36).
    Qsma,
    /// Masing's rule on one initial loading curve: slip that shakes down counts as damping.
    Masing,
    /// Rayleigh-quotient nonlinear modal analysis, with Masing's rule: the same.
    Rqnma,
}

impl Method {
    /// Name as used in scenes and outputs.
    pub fn name(self) -> &'static str {
        match self {
            Method::Qsma => "qsma",
            Method::Masing => "masing",
            Method::Rqnma => "rqnma",
        }
    }
}

/// A place on the interface: `[x, y, z]` in the coordinates of the model, or `[x, y]` in the plane of the interface of matrices. The
/// element with the nearest centre is taken; a place farther from it than that element is long is refused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "a place [x, y, z] in the coordinates of the model, or [x, y] in the plane of an interface whose place is not known"
)]
pub enum InterfacePlace {
    /// In the coordinates of the model (length).
    Model([Length; 3]),
    /// In the plane of the interface, where its place in the model is not known (length).
    Plane([Length; 2]),
}

/// Frequency and damping of a mode against amplitude, by coupled quasi-static modal analysis (CQSMA).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Backbone {
    /// Smallest displacement at the response point, by linear estimate (length).
    pub amplitude_from: Length,
    /// Largest displacement at the response point, by linear estimate (length).
    pub amplitude_to: Length,
    /// Amplitudes, spaced in log, at most 10000; 0 for none.
    pub amplitudes: usize,
    /// Vertices per quarter loop, 1 to 4096. Unless `cycles` is given it is the least number: a loop is computed anew with twice as many, up to four times,
    /// where its damping ratio is another by more than 5 % without every second vertex.
    pub vertices_per_quarter: usize,
    /// Cycles walked, the last of which is measured, 1 to 1000; by default as many as it takes until one closes,
    /// at most 20.
    pub cycles: Option<usize>,
    /// Part of the damping ratio that the gap between the ends of a loop may make up for the loop to count as closed, 1e-12 to 1; 2e-3 by
    /// default. Not together with `cycles`.
    pub until_closed: Option<f64>,
    /// When the friction history is committed.
    pub commit: Commit,
    /// Residual relative to the load, in the energy norm, 1e-13 to 1e-2.
    pub tolerance: f64,
    /// Places on the interface (length). The hysteresis loops of the elements there are written as a table, at the amplitudes whose
    /// fields are stored.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub loops_at: Vec<InterfacePlace>,
    /// Methods beside CQSMA, at the same amplitudes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub methods: Vec<Method>,
    /// Measured backbones, each a table as `identify` writes them: columns `amplitude [unit]`, `frequency_hz` and `damping_ratio`, measured at the
    /// response point. The answer says how far the result lies from them. Each is of the mode followed that is nearest in frequency.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<PathBuf>,
}

impl Default for Backbone {
    fn default() -> Self {
        Self {
            amplitude_from: Length::from_si(1e-7),
            amplitude_to: Length::from_si(1e-3),
            amplitudes: 20,
            vertices_per_quarter: 4,
            cycles: None,
            until_closed: None,
            commit: Commit::AtEveryVertex,
            tolerance: 1e-9,
            loops_at: Vec::new(),
            methods: Vec::new(),
            measured: Vec::new(),
        }
    }
}

impl Backbone {
    /// No loops.
    fn none() -> Self {
        Self {
            amplitudes: 0,
            ..Self::default()
        }
    }
}

/// Stored fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Output {
    /// Numbers of the amplitudes (from 1) whose interface fields are stored; by default the first, the last and two
    /// between. The prestress is always stored.
    pub fields_at: Option<Vec<usize>>,
    /// Whether the bodies are written deformed beside the interface, under the bolt loads and at these amplitudes. The structure is factored
    /// a second time for it. Matrices have no bodies.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub deformed: bool,
}

impl Backbone {
    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        let [from, to] = [self.amplitude_from, self.amplitude_to].map(Length::si);
        check.positive("analyses.backbone.amplitude_from", from, "m")?;
        check.that(
            to.is_finite() && to >= from,
            "analyses.backbone.amplitude_to",
            to,
            "m",
            "finite and not below amplitude_from",
        )?;
        check.that(
            self.amplitudes <= 10_000,
            "analyses.backbone.amplitudes",
            self.amplitudes as f64,
            "",
            "at most 10000",
        )?;
        check.that(
            (1..=4096).contains(&self.vertices_per_quarter),
            "analyses.backbone.vertices_per_quarter",
            self.vertices_per_quarter as f64,
            "",
            "between 1 and 4096",
        )?;
        if let Some(cycles) = self.cycles {
            check.that(
                (1..=1000).contains(&cycles),
                "analyses.backbone.cycles",
                cycles as f64,
                "",
                "between 1 and 1000",
            )?;
        }
        if let Some(tolerance) = self.until_closed {
            check.that(
                (1e-12..=1.0).contains(&tolerance),
                "analyses.backbone.until_closed",
                tolerance,
                "",
                "between 1e-12 (round-off) and 1",
            )?;
            check.that(
                self.cycles.is_none(),
                "analyses.backbone.until_closed",
                tolerance,
                "",
                "left out where analyses.backbone.cycles is given",
            )?;
        }
        check.that(
            (1e-13..=1e-2).contains(&self.tolerance),
            "analyses.backbone.tolerance",
            self.tolerance,
            "",
            "between 1e-13 (round-off) and 1e-2",
        )
    }
}

impl Modes {
    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        check.that(
            (1..=100).contains(&self.number),
            "analyses.modes.number",
            self.number as f64,
            "",
            "between 1 and 100",
        )?;
        let field = "analyses.modes.followed";
        check.that(!self.followed.is_empty(), field, 0.0, "(modes)", "at least one")?;
        for (index, mode) in self.followed.iter().enumerate() {
            let value = *mode as f64;
            let is_computed = (1..=self.number).contains(mode);
            check.that(is_computed, field, value, "", "between 1 and analyses.modes.number")?;
            let is_new = !self.followed[..index].contains(mode);
            check.that(is_new, field, value, "", "different from the modes before it")?;
        }
        Ok(())
    }
}
