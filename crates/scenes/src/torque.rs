//! Torque in the place of bolt loads, and what it takes to turn one into the other.

use super::analysis::Bolts;
use super::json::Refusal;
use super::units::{Force, Length, Torque};
use super::validate::Check;
use super::{MeshBolt, Scene};
use crate::Error;
use crate::metric::{Friction, Metric, Thread};
use joint_model::significant;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Sizes of a thread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThreadSize {
    /// Nominal diameter (length).
    pub diameter: Length,
    /// Pitch (length).
    pub pitch: Length,
}

/// How torque and preload of the bolts belong together (VDI 2230-1, ISO 16047).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TorqueReport {
    /// Torque of each bolt (N m): the one given, or the one that its load would need.
    pub torques: Vec<f64>,
    /// Preload of each bolt (N).
    pub preloads: Vec<f64>,
    /// Whether the scene gives the torque; otherwise it gives the preload.
    pub is_given: bool,
    /// Nominal diameter of the thread (m).
    pub thread_diameter: f64,
    /// Pitch of the thread (m).
    pub pitch: f64,
    /// Coefficient of friction in the thread (-).
    pub thread_friction: f64,
    /// Coefficient of friction below the head or nut that turns (-).
    pub head_friction: f64,
    /// Inner and outer diameter of the face that turns (m).
    pub bearing_diameters: [f64; 2],
    /// Where these come from, in words.
    pub bearing_source: String,
    /// Torque over preload (m).
    pub lever: f64,
    /// Torque over preload and nominal diameter (-): the nut factor `k` of `M = k F d`.
    pub nut_factor: f64,
    /// Part of the torque that strains the bolt along the pitch (-).
    pub pitch_share: f64,
    /// Part of the torque that friction in the thread takes (-).
    pub thread_share: f64,
    /// Part of the torque that friction below the head takes (-).
    pub head_share: f64,
}

/// A thread with its friction while it is tightened.
struct Screw {
    thread: Thread,
    friction: Friction,
    bearing: [f64; 2],
    bearing_source: String,
}

/// Relative difference of loads that are the same but for the digits they are written with.
const ROUND_OFF: f64 = 1e-9;

/// What a torque needs beside it: the field, and a line that gives it.
const LINES: [(&str, &str); 3] = [
    (
        "size",
        r#""size": "M8", or "thread": { "diameter": "8 mm", "pitch": "1.25 mm" }"#,
    ),
    ("thread_friction", r#""thread_friction": 0.12"#),
    ("head_friction", r#""head_friction": 0.12"#),
];

/// Brings the block `bolts` of a file into the form in which it is understood: a load is there, if only as a zero in the place of
/// the one that follows from torques ([`Bolts::follow_torque`]).
pub(super) fn prepare(given: &Value, filled: &mut Value) -> Result<(), Refusal> {
    let Some(bolts) = given.get("bolts").and_then(Value::as_object) else {
        return Ok(());
    };
    let has = |name: &str| bolts.contains_key(name);
    if has("torque") && has("torques") {
        return Err(both("torque", "torques"));
    }
    if has("torque") || has("torques") {
        if !has("load") {
            filled["bolts"]["load"] = json!(0.0);
        }
    } else if let Some(loads) = bolts.get("loads") {
        if has("load") {
            let message = "bolts.load is that of all bolts, and bolts.loads has one for each; leave one of them out";
            return Err(Refusal::of("bolts.load", message));
        }
        if let Some(first) = loads.get(0) {
            filled["bolts"]["load"] = first.clone();
        }
    }
    Ok(())
}

/// Two fields that differ in what they say of the same.
fn both(first: &str, second: &str) -> Refusal {
    let message = format!(
        "bolts.{first} and bolts.{second} both say how far the bolts are tightened; leave one of them out, so that there is for example \
         \"bolts\": {{ \"{second}\": ... }} alone"
    );
    Refusal::of(format!("bolts.{first}"), message)
}

impl Bolts {
    /// Whether a torque says how far the bolts are tightened.
    pub(super) fn has_torque(&self) -> bool {
        self.torque.is_some() || !self.torques.is_empty()
    }

    /// The thread and its friction, where the scene knows them; `mesh` are bolts that are described with the structure.
    fn screw(&self, mesh: &[MeshBolt]) -> Result<Option<Screw>, Refusal> {
        let missing = |of: usize, why: &str| {
            let (field, line) = LINES[of];
            Refusal::of(
                format!("bolts.{field}"),
                format!("bolts.{field} is missing, and {why}; add for example {line}"),
            )
        };
        let idle = [
            ("thread_friction", self.thread_friction.is_some()),
            ("head_friction", self.head_friction.is_some()),
            ("bearing_diameters", self.bearing_diameters.is_some()),
        ];
        let shared = shared_size(mesh);
        let own = match (&self.size, self.thread) {
            (Some(_), Some(_)) => {
                let message = "bolts.size and bolts.thread both say what the thread is; leave one of them out";
                return Err(Refusal::of("bolts.thread", message));
            }
            (Some(size), None) => Some(size),
            (None, Some(_)) => None,
            // The bolts of a mesh have sizes of their own.
            (None, None) if self.has_torque() || idle.iter().any(|(_, given)| *given) => shared,
            (None, None) => None,
        };
        let metric = own
            .map(|size| {
                Metric::from_name(size).map_err(|error| Refusal::of("bolts.size", format!("bolts.size: {error}")))
            })
            .transpose()?;
        if let (Some(metric), Some(shared)) = (&metric, shared)
            && Metric::from_name(shared).is_ok_and(|of_mesh| of_mesh.thread != metric.thread)
        {
            let message = format!(
                "bolts.size = {} is not the size {shared} of structure.mesh.bolts; correct one of them, or leave out bolts.size",
                self.size.as_deref().unwrap_or_default()
            );
            return Err(Refusal::of("bolts.size", message));
        }
        let given = self.thread.map(|thread| Thread {
            diameter: thread.diameter.si(),
            pitch: thread.pitch.si(),
        });
        let Some(thread) = metric.map(|metric| metric.thread).or(given) else {
            return match (self.has_torque(), idle.iter().find(|(_, given)| *given)) {
                (true, _) => Err(missing(0, "the preload of a torque depends on the thread")),
                (false, Some((field, _))) => Err(Refusal::of(
                    format!("bolts.{field}"),
                    format!(
                        "bolts.{field} belongs to a thread; leave it out, or add for example {}",
                        LINES[0].1
                    ),
                )),
                (false, None) => Ok(None),
            };
        };
        let why = match self.has_torque() {
            true => "the preload of a torque depends on it",
            false => {
                "the torque that the load of a thread needs depends on it; leave out bolts.size or bolts.thread if it is of no interest"
            }
        };
        let friction = Friction {
            thread: self.thread_friction.ok_or_else(|| missing(1, why))?,
            head: self.head_friction.ok_or_else(|| missing(2, why))?,
        };
        let (bearing, bearing_source) = match (self.bearing_diameters, metric) {
            (Some(diameters), _) => (diameters.map(Length::si), "scene".to_owned()),
            (None, Some(metric)) => (
                [metric.hole, metric.face],
                "clearance hole of the medium series (ISO 273) and face below a hexagon head (ISO 4014)".to_owned(),
            ),
            (None, None) => {
                let message = "bolts.bearing_diameters is missing, and a thread of given sizes has no standard head; add for example \
                               \"bearing_diameters\": [\"9 mm\", \"11.63 mm\"], the inner and the outer diameter of the face that turns";
                return Err(Refusal::of("bolts.bearing_diameters", message));
            }
        };
        Ok(Some(Screw {
            thread,
            friction,
            bearing,
            bearing_source,
        }))
    }

    /// Takes the torques as what says how far the bolts are tightened: the loads are to follow anew ([`Self::follow_torque`]).
    pub(super) fn forget_loads(&mut self) {
        if self.has_torque() {
            (self.load, self.loads) = (Force::from_si(0.0), Vec::new());
        }
    }

    /// Takes the loads as what says how far the bolts are tightened.
    pub(super) fn forget_torques(&mut self) {
        (self.torque, self.torques) = (None, Vec::new());
    }

    /// Turns torques into the loads that they give. Scenes that were written by this program have both, and then they agree.
    pub(super) fn follow_torque(&mut self, mesh: &[MeshBolt]) -> Result<(), Refusal> {
        let Some(screw) = self.screw(mesh)? else {
            return Ok(());
        };
        let preload =
            |torque: &Torque| Force::from_si(screw.thread.preload(torque.si(), screw.friction, screw.bearing));
        let (field, loads): (_, Vec<Force>) = match &self.torque {
            Some(torque) => ("torque", vec![preload(torque)]),
            None => ("torques", self.torques.iter().map(preload).collect()),
        };
        let Some(first) = loads.first().copied() else {
            return Ok(());
        };
        let differs = |given: &Force, own: &Force| (given.si() - own.si()).abs() > ROUND_OFF * own.si().abs();
        if self.load.si() != 0.0 && differs(&self.load, &first) {
            return Err(both("load", field));
        }
        let own = match self.torque {
            Some(_) => Vec::new(),
            None => loads,
        };
        let same = self.loads.len() == own.len() && !self.loads.iter().zip(&own).any(|(a, b)| differs(a, b));
        if !self.loads.is_empty() && !same {
            return Err(both("loads", field));
        }
        (self.load, self.loads) = (first, own);
        Ok(())
    }

    pub(super) fn validate_torque(&self, check: &Check<'_>) -> Result<(), Error> {
        if let Some(torque) = self.torque {
            check.positive("bolts.torque", torque.si(), "N m")?;
        }
        for torque in &self.torques {
            check.positive("bolts.torques", torque.si(), "N m")?;
        }
        for (field, friction) in [
            ("bolts.thread_friction", self.thread_friction),
            ("bolts.head_friction", self.head_friction),
        ] {
            check.not_negative(field, friction.unwrap_or_default(), "")?;
        }
        if let Some(ThreadSize { diameter, pitch }) = self.thread {
            let (diameter, pitch) = (diameter.si(), pitch.si());
            check.positive("bolts.thread.diameter", diameter, "m")?;
            check.positive("bolts.thread.pitch", pitch, "m")?;
            let has_core = Thread { diameter, pitch }.core_diameter() > 0.0;
            check.that(
                has_core,
                "bolts.thread.pitch",
                pitch,
                "m",
                "less than 0.8 of the diameter",
            )?;
        }
        if let Some([inner, outer]) = self.bearing_diameters.map(|ends| ends.map(Length::si)) {
            check.not_negative("bolts.bearing_diameters", inner, "m")?;
            let holds = outer.is_finite() && outer > inner;
            check.that(
                holds,
                "bolts.bearing_diameters",
                outer,
                "m",
                "finite and above the first, the inner diameter",
            )?;
        }
        Ok(())
    }
}

/// The size of the bolts of a mesh, where all have the same.
fn shared_size(mesh: &[MeshBolt]) -> Option<&String> {
    let first = mesh.first()?.size.as_ref()?;
    mesh.iter()
        .all(|bolt| bolt.size.as_ref() == Some(first))
        .then_some(first)
}

impl Scene {
    /// How torque and preload of the bolts belong together, where the scene knows their thread; of `bolts` bolts.
    pub fn torque_report(&self, bolts: usize) -> Option<TorqueReport> {
        let mesh = self.structure.mesh().map_or(&[][..], |mesh| &mesh.bolts);
        let Screw {
            thread,
            friction,
            bearing,
            bearing_source,
        } = self.bolts.screw(mesh).ok()??;
        let preloads: Vec<f64> = (0..bolts).map(|bolt| self.tension(bolt)).collect();
        let lever = thread.lever(friction, bearing);
        let [pitch_share, thread_share, head_share] = thread.lever_parts(friction, bearing).map(|part| part / lever);
        Some(TorqueReport {
            torques: preloads
                .iter()
                .map(|load| thread.torque(*load, friction, bearing))
                .collect(),
            preloads,
            is_given: self.bolts.has_torque(),
            thread_diameter: thread.diameter,
            pitch: thread.pitch,
            thread_friction: friction.thread,
            head_friction: friction.head,
            bearing_diameters: bearing,
            bearing_source,
            lever,
            nut_factor: lever / thread.diameter,
            pitch_share,
            thread_share,
            head_share,
        })
    }
}

impl TorqueReport {
    /// In one line.
    pub fn line(&self) -> String {
        let range = |values: &[f64], factor: f64| {
            let sizes = values.iter().map(|value| factor * value);
            let (low, high) = sizes.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
            match high > low * (1.0 + 1e-9) {
                true => format!("{} to {}", significant(low), significant(high)),
                false => significant(high),
            }
        };
        let (torque, preload) = (range(&self.torques, 1.0), range(&self.preloads, 1e-3));
        let first = match self.is_given {
            true => format!("torque: {torque} N m gives {preload} kN"),
            false => format!("torque: {preload} kN would need {torque} N m"),
        };
        format!(
            "{first} (k = {:.3}; pitch {:.0} %, thread {:.0} %, head {:.0} % of the torque; diameters of the turning face {:.2} and \
             {:.2} mm: {})",
            self.nut_factor,
            100.0 * self.pitch_share,
            100.0 * self.thread_share,
            100.0 * self.head_share,
            1e3 * self.bearing_diameters[0],
            1e3 * self.bearing_diameters[1],
            self.bearing_source
        )
    }
}
