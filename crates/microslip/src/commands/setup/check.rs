//! What the program says of a scene while it is set up.

use analyses::warnings;
use finite_elements::mesh::Mesh;
use host::{BENCHMARKS, with_causes};
use joint_model::Bodies;
use joints::progress::Progress;
use joints::structure::Structure;
use scenes::{Scene, Surface, Units};
use serde_json::{Value, json};
use std::path::{Component, Path, PathBuf};
use std::sync::Mutex;

/// Judges scenes on a mesh.
pub(super) struct Checker {
    /// Folder of the scene: what it names lies in it.
    pub(super) folder: PathBuf,
    /// The mesh, which may lie elsewhere.
    pub(super) mesh: PathBuf,
    /// Name of its file, for messages.
    pub(super) place: String,
    /// Name of scenes without one.
    pub(super) name: String,
    /// For each solid of the mesh the number of its body.
    pub(super) body_of_cell: Vec<u32>,
    /// Whose turn it is to read the mesh, which may be large.
    pub(super) turn: Mutex<()>,
}

/// How far a scene is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// Its fields alone, at once.
    Fields,
    /// With the mesh.
    Structure,
}

/// What is wrong, and with which field of the scene.
struct Fault {
    field: Option<String>,
    message: String,
}

impl From<scenes::Error> for Fault {
    fn from(error: scenes::Error) -> Self {
        analyses::Error::from(error).into()
    }
}

impl From<joints::Error> for Fault {
    fn from(error: joints::Error) -> Self {
        analyses::Error::from(error).into()
    }
}

impl From<analyses::Error> for Fault {
    fn from(error: analyses::Error) -> Self {
        Self {
            field: error.field().map(str::to_owned),
            message: with_causes(&error),
        }
    }
}

/// What a scene is, as far as it is known.
#[derive(Default)]
pub(super) struct Verdict {
    faults: Vec<Fault>,
    /// What a run says of the structure before it computes.
    echo: Value,
}

impl Verdict {
    /// Whether a run can begin.
    pub(super) fn is_complete(&self) -> bool {
        self.faults.is_empty()
    }

    /// For the page.
    pub(super) fn json(&self) -> Value {
        let faults = self.faults.iter();
        let errors = faults.map(|fault| json!({ "field": fault.field, "message": fault.message }));
        json!({ "complete": self.is_complete(), "errors": errors.collect::<Vec<_>>(), "echo": self.echo })
    }
}

/// Keeps notes.
#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Progress for Notes {
    fn note(&self, text: &str) {
        if let Ok(mut notes) = self.0.lock() {
            notes.push(text.to_owned());
        }
    }
}

impl Checker {
    /// Reads the text of a scene as `run` does, up to the structure that it describes. While something that the physics depends on is missing, any
    /// value stands for it, and nothing is told that depends on it.
    pub(super) fn verdict(&self, text: &str, depth: Depth) -> Verdict {
        let mut verdict = Verdict::default();
        let found = self.look(text, depth, &mut verdict);
        if let Err(fault) = found
            && !verdict
                .faults
                .iter()
                .any(|known| known.field.is_some() && known.field == fault.field)
        {
            verdict.faults.push(fault);
        }
        verdict
    }

    fn look(&self, text: &str, depth: Depth, verdict: &mut Verdict) -> Result<(), Fault> {
        let mut given = scenes::parse_json(text).map_err(|message| Fault { field: None, message })?;
        let missing = Scene::missing(&given);
        let has_units = given.get("units").is_some();
        if !has_units {
            verdict.faults.extend(self.read(given.clone()).err());
            set(&mut given, "units", json!(Units::SI));
        }
        let lacks = |block: &str| missing.iter().any(|(field, _)| field.starts_with(block));
        let lacks_material = lacks("model.material");
        for (field, _) in &missing {
            set(&mut given, field, stand_in(field));
        }
        let faults = missing.into_iter();
        let faults = faults.map(|(field, message)| Fault {
            field: Some(field),
            message,
        });
        verdict.faults.extend(faults);
        let scene = self.read(given)?;
        self.require_files(&scene)?;
        if !has_units || depth == Depth::Fields {
            return Ok(());
        }
        let _turn = self.turn.lock();
        let notes = Notes::default();
        let structure = Structure::as_read(&scene, &notes)?;
        let overview = structure.overview(&scene)?;
        let areas = structure.areas()?;
        let areas = areas.iter().map(|(name, area)| json!({ "name": name, "area": area }));
        let seats = overview.fit.seats.iter();
        let seats = seats.map(|seat| json!({ "bolt": seat.bolt, "side": seat.side, "covered": seat.covered }));
        let masses = match &structure.joint.bodies {
            Bodies::Meshed(bodies) if !lacks_material => self.masses(&bodies.assembly.mesh),
            _ => Vec::new(),
        };
        let is_complete = verdict.is_complete();
        let warnings = match is_complete {
            true => warnings::of_input(&overview),
            false => Vec::new(),
        };
        verdict.echo = json!({
            "lines": if is_complete { overview.lines() } else { overview.fit.lines() },
            "areas": areas.collect::<Vec<_>>(),
            "seats": seats.collect::<Vec<_>>(),
            "masses": masses,
            "warnings": warnings.into_iter().map(|warning| warning.message).collect::<Vec<_>>(),
            "notes": notes.0.into_inner().unwrap_or_default(),
        });
        Ok(())
    }

    fn read(&self, given: Value) -> Result<Scene, Fault> {
        let mut scene = Scene::from_value(given, &self.place, &self.name, &BENCHMARKS)?;
        scene.resolve(&self.folder);
        Ok(scene)
    }

    /// Refuses files that are elsewhere than the scene, or cannot be read.
    fn require_files(&self, scene: &Scene) -> Result<(), Fault> {
        let mut named: Vec<(&str, &Path)> = Vec::new();
        named.extend(scene.structure.mesh().map(|mesh| ("structure.mesh.path", &*mesh.path)));
        let superelements = scene.structure.mesh().map_or(&[][..], |mesh| &mesh.superelements);
        named.extend(
            superelements
                .iter()
                .map(|body| ("structure.mesh.superelements", &*body.path)),
        );
        for surface in scene.interfaces.surfaces() {
            if let Surface::Scans(scans) = surface {
                named.push(("interfaces.surface.scans.0", &scans.top.path));
                named.push(("interfaces.surface.scans.1", &scans.bottom.path));
            }
        }
        let record = scene.analyses.shock.as_ref().and_then(|shock| shock.record.as_ref());
        named.extend(record.map(|record| ("analyses.shock.record", &*record.path)));
        let measured = scene.analyses.backbone.measured.iter();
        named.extend(measured.map(|path| ("analyses.backbone.measured", &**path)));
        for (field, path) in named {
            let fault = |message: String| Fault {
                field: Some(field.to_owned()),
                message,
            };
            if !self.is_inside(path) {
                return Err(fault(format!(
                    "{field}: {} is not in the folder {}, beyond which no file of a set-up may be; copy it there",
                    path.display(),
                    self.folder.display()
                )));
            }
            let kind = match field {
                "structure.mesh.path" => file_io::input::Kind::Mesh,
                "analyses.shock.record" => file_io::input::Kind::Record,
                "analyses.backbone.measured" => file_io::input::Kind::Table,
                _ => file_io::input::Kind::Scan,
            };
            file_io::input::check(path, kind).map_err(|error| fault(with_causes(&error)))?;
        }
        match scene.structure.mesh().is_some() {
            true => Ok(()),
            false => Err(Fault {
                field: Some("structure".into()),
                message: "structure: a set-up is of a mesh; give structure.mesh".into(),
            }),
        }
    }

    /// Whether a file is the mesh, or in the folder by its name and, where it exists, in truth.
    fn is_inside(&self, path: &Path) -> bool {
        let is_plain = |path: &Path| {
            let below = path.strip_prefix(&self.folder);
            below.is_ok_and(|below| below.components().all(|part| matches!(part, Component::Normal(_))))
        };
        match path.canonicalize() {
            Ok(found) => found == self.mesh || (is_plain(path) && found.starts_with(&self.folder)),
            Err(_) => is_plain(path),
        }
    }

    /// Masses of the bodies (kg); none where the elements are not those of the file.
    fn masses(&self, mesh: &Mesh) -> Vec<f64> {
        if mesh.elements.len() != self.body_of_cell.len() {
            return Vec::new();
        }
        let count = self.body_of_cell.iter().max().map_or(0, |last| *last as usize + 1);
        let mut masses = vec![0.0; count];
        for (element, body) in mesh.elements.iter().zip(&self.body_of_cell) {
            let density = mesh.materials[usize::from(element.material)].density;
            masses[*body as usize] += density * element.cell.volume(&mesh.nodes);
        }
        masses
    }
}

/// A value that a scene may have in the place of one that is missing.
fn stand_in(field: &str) -> Value {
    match field {
        "interfaces.surface" => json!({ "benchmark": BENCHMARKS[0].name() }),
        "model.material.youngs_modulus" => json!("200 GPa"),
        "model.material.density" => json!("8000 kg/m^3"),
        "bolts.load" => json!("1 kN"),
        _ => json!(0.3),
    }
}

/// Writes a value into a scene, with the blocks about it; where something else stands in their place, it stays.
fn set(scene: &mut Value, field: &str, value: Value) {
    let mut place = scene;
    for name in field.split('.') {
        if place.is_null() {
            *place = json!({});
        }
        let Some(block) = place.as_object_mut() else { return };
        place = block.entry(name).or_insert(Value::Null);
    }
    *place = value;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_set_with_their_blocks_and_replace_nothing_else() {
        let mut scene = json!({ "bolts": 3, "model": { "material": null } });
        set(&mut scene, "model.material.density", json!(1));
        set(&mut scene, "bolts.load", json!(2));
        set(&mut scene, "interfaces.mu", json!(0.2));
        let expected = json!({ "bolts": 3, "model": { "material": { "density": 1 } }, "interfaces": { "mu": 0.2 } });
        assert_eq!(scene, expected);
    }
}
