//! Values of parameters: what a scene has at their paths, and the scene with another value.

use crate::benchmark;
use crate::error::Error;
use crate::json::Refusal;
use crate::parameter::Parameter;
use crate::scene::{Scene, refused};
use crate::structure::StructureSource;
use crate::units::{SI_SYMBOLS, Units};
use serde_json::{Value, json};

/// Blocks and fields with numbers that the physics depends on, as against settings of the numerics.
const PHYSICAL: [&str; 9] = [
    "interfaces.mu",
    "interfaces.friction_zones",
    "interfaces.law.yield",
    "interfaces.surface",
    "interfaces.scale",
    "interfaces.each",
    "bolts",
    "model.material",
    "structure",
];

impl Parameter {
    /// Refuses parameters that cannot vary at the same time, as one of them says what another follows from; in words.
    pub fn refuse_together<'p>(all: impl Iterator<Item = &'p Self> + Clone, scene: &Scene) -> Result<(), String> {
        let find = |which: &dyn Fn(&Self) -> bool| all.clone().find(|one| which(one));
        let loads = find(&|one| one.path() == "bolts.load");
        if let (Some(loads), Some(one)) = (loads, find(&|one| one.is_bolt_load() && one.path() != "bolts.load")) {
            return Err(format!(
                "{loads} is the load of all bolts, and {one} that of one of them; leave one of them out"
            ));
        }
        if let (true, Some(load), Some(of)) = (
            scene.bolts.has_torque(),
            find(&Self::is_bolt_load),
            find(&Self::is_of_torque),
        ) {
            return Err(format!(
                "{load} follows from {of}, and would take its place; leave one of them out"
            ));
        }
        Ok(())
    }

    /// Its value in a scene (SI).
    ///
    /// # Errors
    /// [`Error::Parameter`] where the scene has no such number.
    pub fn value(&self, scene: &Scene) -> Result<f64, Error> {
        self.check_kind()?;
        let value = scene.encoded()?;
        let found = value.pointer(&self.pointer()).and_then(Value::as_f64);
        let is_whole = |value: &Value| value.is_u64() || value.is_i64();
        match found {
            Some(_) if value.pointer(&self.pointer()).is_some_and(is_whole) => {
                Err(self.refused("it counts something and has no values between whole numbers"))
            }
            Some(number) => Ok(number),
            None => Err(self.refused(&self.what_is_there(&value))),
        }
    }

    /// The scene with another value of the parameter (SI).
    ///
    /// # Errors
    /// As [`Self::value`], and whatever the scene refuses the value for.
    pub fn with(&self, scene: &Scene, number: f64) -> Result<Scene, Error> {
        let before = self.value(scene)?;
        let mut value = scene.encoded()?;
        let pointers: Vec<String> = match (self.path(), scene.bolts.loads.len()) {
            ("bolts.load", bolts) if bolts > 0 => (0..bolts).map(|bolt| format!("/bolts/loads/{bolt}")).collect(),
            _ => Vec::new(),
        };
        for pointer in &pointers {
            if let Some(load) = value.pointer_mut(pointer) {
                *load = json!(load.as_f64().unwrap_or(0.0) * (number / before));
            }
        }
        if let Some(field) = value.pointer_mut(&self.pointer()) {
            *field = json!(number);
        }
        if self.path() == "bolts.loads.0" {
            // That of all bolts is the first of them.
            value["bolts"]["load"] = json!(number);
        }
        let mut varied = understood(scene, value)?;
        match self.is_bolt_load() {
            true => varied.bolts.forget_torques(),
            false => varied.bolts.forget_loads(),
        }
        varied.derive().map_err(|refusal| refused(&scene.name, refusal))?;
        varied.validate(&scene.name)?;
        Ok(varied)
    }

    /// The SI unit of its value; empty for pure numbers.
    ///
    /// # Errors
    /// As [`Self::value`].
    pub fn unit(&self, scene: &Scene) -> Result<&'static str, Error> {
        self.value(scene)?;
        let mut value = scene.encoded()?;
        // A quantity takes a text with a unit of its dimension; pure numbers take none.
        let takes = |symbol: &&&'static str| {
            if let Some(field) = value.pointer_mut(&self.pointer()) {
                *field = json!(format!("1 {symbol}"));
            }
            understood(scene, value.clone()).is_ok()
        };
        Ok(SI_SYMBOLS.iter().find(takes).copied().unwrap_or(""))
    }

    /// A value of it (SI), as a scene file in these units gives it: a number or a text with a unit.
    pub(super) fn read(&self, scene: &Scene, given: Value, units: Units) -> Result<f64, Refusal> {
        let mut value = scene.encoded().map_err(|error| Refusal::from(error.to_string()))?;
        if let Some(field) = value.pointer_mut(&self.pointer()) {
            *field = given;
        }
        let read = units.scope(|| understood(scene, value));
        // Whole numbers of the file are numbers like others once they are understood.
        let read = read.and_then(|read| self.value(&read));
        read.map_err(|error| Refusal::from(error.to_string()))
    }

    fn pointer(&self) -> String {
        self.path().split('.').flat_map(|field| ["/", field]).collect()
    }

    fn check_kind(&self) -> Result<(), Error> {
        let is_within = |block: &&str| {
            let rest = self.path().strip_prefix(*block);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        match PHYSICAL.iter().any(is_within) {
            true => Ok(()),
            false => Err(self.refused(&format!(
                "it is no number that the physics depends on; those are in {}",
                PHYSICAL.join(", ")
            ))),
        }
    }

    /// In words, what the scene has at the deepest place of the path that it has.
    fn what_is_there(&self, scene: &Value) -> String {
        let mut place = scene;
        let mut path = Vec::new();
        for field in self.path().split('.') {
            let within = match place {
                Value::Array(list) => field.parse().ok().and_then(|place: usize| list.get(place)),
                other => other.get(field),
            };
            let Some(within) = within else { break };
            place = within;
            path.push(field);
        }
        let path = path.join(".");
        match place {
            Value::Null => format!("the scene does not give {path}; give it a value"),
            Value::Object(fields) => {
                let names: Vec<&str> = fields.keys().map(String::as_str).collect();
                let place = if path.is_empty() { "it" } else { &path };
                format!("the scene has no such number; {place} has {}", names.join(", "))
            }
            Value::Array(list) => format!(
                "the scene has no such number; {path} has {} elements, counted from 0",
                list.len()
            ),
            _ => "the scene has no number there; name one that it gives".into(),
        }
    }

    fn refused(&self, reason: &str) -> Error {
        Error::Parameter {
            path: self.path().to_owned(),
            reason: reason.into(),
        }
    }
}

/// A scene from its numbers in SI, with what files do not say taken from `scene`.
pub(super) fn understood(scene: &Scene, value: Value) -> Result<Scene, Error> {
    let known: Vec<_> = scene.benchmarks().collect();
    let read = benchmark::scope(&known, || Scene::understand(value));
    let mut read = read.map_err(|refusal| refused(&scene.name, refusal))?;
    if let (StructureSource::Deck(own), StructureSource::Deck(given)) =
        (&mut read.structure.source, &scene.structure.source)
    {
        own.includes = given.includes;
    }
    Ok(read)
}
