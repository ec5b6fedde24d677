//! Torque in the place of bolt loads, and what it takes to turn one into the other.

use crate::bolts::{Bolts, ThreadSize};
use crate::check::Check;
use crate::error::Error;
use crate::json::Refusal;
use crate::mesh::MeshBolt;
use crate::metric::{Friction, Metric, Thread};
use crate::units::{Force, Length, Torque};
use serde_json::{Value, json};

/// A thread with its friction while it is tightened.
pub(super) struct Screw {
    pub(super) thread: Thread,
    pub(super) friction: Friction,
    pub(super) bearing: [f64; 2],
    pub(super) bearing_source: String,
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
    pub(super) fn screw(&self, mesh: &[MeshBolt]) -> Result<Option<Screw>, Refusal> {
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
