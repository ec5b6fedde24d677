//! A scene, and how it is read from a file, a text or a summary.

use crate::accuracy::{Accuracy, GivenSettings};
use crate::analyses::{Analyses, Output};
use crate::benchmark::{self, BenchmarkRef};
use crate::bolts::Bolts;
use crate::error::Error;
use crate::former;
use crate::interfaces::Interfaces;
use crate::json::{self, Refusal};
use crate::law::{Friction, Law, LawKind, RadialRule};
use crate::mesh::MeshFile;
use crate::scans::Readings;
use crate::structure::{Coordinates, MaterialSource, Model, StructureBlock, StructureSource};
use crate::surface::{Gap, Surface};
use crate::torque;
use crate::uncertain::Uncertain;
use crate::units::Units;
use contact_laws::AsperityLimit;
use finite_elements::elements::Formulation;
use joint_model::benchmark::{
    Benchmark, Benchmarks, ElementOrder, MeasuredSurface, MeshAccuracy, MeshError, RefinementLevel,
};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::Path;

/// A scene: what is modelled, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Units of the file.
    pub units: Units,
    /// Name of the scene; the file's name by default.
    #[serde(default)]
    pub name: String,
    /// How exact the result shall be: settings that the scene does not give are those of the cheapest set that is; of `standard` by
    /// default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// The structure.
    pub structure: StructureBlock,
    /// How it is meshed and reduced.
    #[serde(default)]
    pub model: Model,
    /// The interfaces.
    pub interfaces: Interfaces,
    /// Bolts.
    pub bolts: Bolts,
    /// Viscous modal damping ratio that is added to the total, apart from friction (-).
    #[serde(default)]
    pub background_damping: f64,
    /// Numbers of the scene that are not known exactly; samples of them give bands of frequency and damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertain: Option<Uncertain>,
    /// What is asked for.
    #[serde(default)]
    pub analyses: Analyses,
    /// Which results are stored as fields.
    #[serde(default)]
    pub output: Output,
}

/// A line that gives a material.
const MATERIAL_LINE: &str = r#""model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3 } }"#;

/// What a scene must say unless its benchmark does: the field, and a line that gives it.
const PHYSICS: [(&str, &str); 5] = [
    ("/interfaces/mu", r#""interfaces": { "mu": 0.2 }"#),
    ("/bolts/load", r#""bolts": { "load": "12 kN" }"#),
    ("/model/material/youngs_modulus", MATERIAL_LINE),
    ("/model/material/poisson_ratio", MATERIAL_LINE),
    (
        "/interfaces/surface",
        r#""interfaces": { "surface": { "scans": ["top.x3p", "bottom.x3p"] } }, or "interfaces": { "surface": { "benchmark": NAME } } for the measured surface of a benchmark"#,
    ),
];

/// What bodies need beside it.
const DENSITY: (&str, &str) = (
    "/model/material/density",
    r#""model": { "material": { "density": "7850 kg/m^3" } }"#,
);

/// Blocks whose fields a benchmark may fill in one by one.
const BLOCKS: [&str; 4] = ["model", "material", "bolts", "interfaces"];

impl Scene {
    /// Reads a scene file and converts it to SI; `benchmarks` are those it may name. Paths in it are relative to its folder.
    ///
    /// # Errors
    /// [`Error::InputFile`], or those of [`Scene::from_json`].
    pub fn read(path: &Path, benchmarks: Benchmarks<'_>) -> Result<Self, Error> {
        Self::read_filled(path, benchmarks, &|_| {})
    }

    /// As [`Scene::read`], for programs that fill in what a file leaves out: `fill` sees the file before it is understood.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn read_filled(path: &Path, benchmarks: Benchmarks<'_>, fill: &dyn Fn(&mut Value)) -> Result<Self, Error> {
        let text = file_io::input::read_text(path, file_io::input::Kind::Scene)?;
        let place = path.display().to_string();
        let mut value = json::parse(&text).map_err(|message| refused(&place, message.into()))?;
        fill(&mut value);
        let stem = path
            .file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let mut scene = Self::from_value(value, &place, &stem, benchmarks)?;
        if let Some(folder) = path.parent() {
            scene.resolve(folder);
        }
        Ok(scene)
    }

    /// All that the physics depends on and a scene on a mesh of one's own leaves out: fields with messages, in the order in which [`Scene::from_value`]
    /// asks for them one by one.
    pub fn missing(given: &Value) -> Vec<(String, String)> {
        let mut filled = given.clone();
        // What is wrong with torques is no lack of a load.
        drop(imply(given, &mut filled));
        let is_missing = |path: &&(&str, &str)| filled.pointer(path.0).is_none_or(Value::is_null);
        let all = PHYSICS.iter().chain([&DENSITY]).filter(is_missing);
        let refusals = all.map(|(path, line)| (path[1..].replace('/', "."), missing(path, line).message));
        refusals.collect()
    }

    /// Makes relative paths start from a folder.
    pub fn resolve(&mut self, folder: &Path) {
        self.paths().for_each(|path| *path = folder.join(&*path));
    }

    /// Parses and validates a scene; `place` is named in errors, `name` is used if the scene has none.
    ///
    /// # Errors
    /// [`Error::Syntax`] for malformed JSON, unknown and missing fields, [`Error::Value`] for values outside their range.
    pub fn from_json(text: &str, place: &str, name: &str, benchmarks: Benchmarks<'_>) -> Result<Self, Error> {
        let value = json::parse(text).map_err(|message| refused(place, message.into()))?;
        Self::from_value(value, place, name, benchmarks)
    }

    /// As [`Scene::from_json`], of a scene that is parsed already.
    ///
    /// # Errors
    /// As [`Scene::from_json`].
    pub fn from_value(given: Value, place: &str, name: &str, benchmarks: Benchmarks<'_>) -> Result<Self, Error> {
        let syntax = |refusal: Refusal| refused(place, refusal);
        let units = given.get("units").ok_or_else(|| {
            syntax(Refusal::of(
                "units",
                "`units` is missing, such as \"units\": { \"length\": \"m\", \"mass\": \"kg\", \"time\": \"s\" }",
            ))
        })?;
        let units: Units = serde_path_to_error::deserialize(units).map_err(|e| {
            let Refusal { field, message } = Refusal::from(&e);
            let within = field
                .as_ref()
                .map_or_else(|| "units".into(), |field| format!("units.{field}"));
            let separator = if field.is_some() { "." } else { ": " };
            syntax(Refusal::of(within, format!("units{separator}{message}")))
        })?;
        former::refuse(&given).map_err(syntax)?;
        let source = given.get("structure").ok_or_else(|| {
            let name = benchmarks.first().map_or("NAME", |known| known.name());
            let message = format!(
                "`structure` is missing: say where the structure comes from, such as \"structure\": {{ \"benchmark\": \
                 \"{name}\" }}, {{ \"deck\": {{ ... }} }}, {{ \"mesh\": {{ ... }} }} or {{ \"matrices\": {{ ... }} }}"
            );
            syntax(Refusal::of("structure", message))
        })?;
        let mut filled = given.clone();
        if let Some(name) = source.get("benchmark").and_then(Value::as_str) {
            let known = benchmark::find(name, benchmarks);
            let known = known.map_err(|message| syntax(Refusal::of("structure.benchmark", message)))?;
            fill(&mut filled, known.defaults());
        }
        imply(&given, &mut filled).map_err(syntax)?;
        require_physics(&filled).map_err(syntax)?;
        let read = |value: Value| {
            let read = || Self::understand(value);
            benchmark::scope(benchmarks, || units.scope(read)).map_err(syntax)
        };
        let mut scene = read(filled.clone())?;
        if scene.needs_material() && scene.model.material.is_none() {
            return Err(syntax(missing("/model/material/youngs_modulus", MATERIAL_LINE)));
        }
        let own = scene.encoded()?;
        refuse_lists(&given, &own, "").map_err(syntax)?;
        scene.refuse_idle(&given).map_err(syntax)?;
        let preset = scene.accuracy.unwrap_or_default().preset();
        preset
            .map_err(|message| syntax(Refusal::of("accuracy", message)))?
            .fill(&mut filled);
        scene = read(filled)?;
        if let Some(Accuracy::Target(target)) = &mut scene.accuracy {
            target.given = GivenSettings::of(&given);
        }
        scene.refuse_beyond_all_meshes().map_err(syntax)?;
        scene.derive().map_err(syntax)?;
        if let Some(mut uncertain) = scene.uncertain.take() {
            uncertain.convert(&scene, units)?;
            scene.uncertain = Some(uncertain);
        }
        scene.units = Units::SI;
        if scene.name.is_empty() {
            scene.name = name.into();
        }
        scene.validate(place)?;
        Ok(scene)
    }

    /// Refuses an accuracy that none of the measured meshes of a benchmark has, unless the scene gives its mesh.
    fn refuse_beyond_all_meshes(&self) -> Result<(), Refusal> {
        let Some(Accuracy::Target(target)) = self.accuracy else {
            return Ok(());
        };
        let measured = self
            .structure
            .benchmark()
            .and_then(|benchmark| benchmark.mesh_accuracy());
        // They were measured for one mode.
        let applies = |measured: &MeshAccuracy| !target.given.mesh && self.analyses.modes.followed == [measured.mode];
        let Some(accuracy) = measured.filter(applies) else {
            return Ok(());
        };
        let rows = || accuracy.of(self.element_order(), self.hexahedra());
        let is_borne = |error: f64, borne: Option<f64>| borne.is_none_or(|borne| error <= borne);
        if rows().any(|row| is_borne(row.frequency, target.frequency) && is_borne(row.damping, target.damping)) {
            return Ok(());
        }
        let least = |of: fn(&MeshError) -> f64| rows().map(of).fold(f64::INFINITY, f64::min);
        let message = format!(
            "no measured mesh of the benchmark is within the accuracy asked for; the best miss {} of frequency and {} of the logarithm of \
             damping. Ask for less, or give model.refinement",
            least(|row| row.frequency),
            least(|row| row.damping)
        );
        Err(Refusal::of("accuracy", message))
    }

    /// Finds what follows from other numbers of the scene and is kept beside them.
    pub(super) fn derive(&mut self) -> Result<(), Refusal> {
        let mesh = self.structure.mesh().map_or(&[][..], |mesh| &mesh.bolts);
        self.bolts.follow_torque(mesh)
    }

    /// The one place where scenes are deserialised, as every further one would be compiled anew; messages name the field.
    pub(super) fn understand(value: Value) -> Result<Self, Refusal> {
        serde_path_to_error::deserialize(value).map_err(|e| Refusal::from(&e))
    }

    /// Reads a scene as [`Serialize`] writes it, such as the one in a summary.
    ///
    /// # Errors
    /// [`Error::Syntax`].
    pub fn from_summary(value: &Value, benchmarks: Benchmarks<'_>) -> Result<Self, Error> {
        let read = || Self::understand(value.clone());
        benchmark::scope(benchmarks, read).map_err(|refusal| refused("the scene of a summary", refusal))
    }

    /// The scene as [`Serialize`] writes it: what keys of stored results are made of, and what summaries hold.
    ///
    /// # Errors
    /// [`Error::Syntax`] for a path that is no Unicode text, of which neither would know the difference from another.
    pub fn encoded(&self) -> Result<Value, Error> {
        serde_json::to_value(self).map_err(|error| {
            let mut own = self.clone();
            let path = own.paths().find(|path| path.to_str().is_none());
            let message = match path {
                Some(path) => format!(
                    "the path {} is no Unicode text, so that results could not name it; give file and folders other names",
                    path.display()
                ),
                None => error.to_string(),
            };
            refused(&self.name, message.into())
        })
    }

    /// The default scene on a benchmark, in SI.
    ///
    /// # Errors
    /// [`Error::Syntax`] if the benchmark's own defaults leave something out.
    pub fn of(benchmark: &'static dyn Benchmark, name: &str) -> Result<Self, Error> {
        let mut value = json!({
            "units": Units::SI,
            "name": name,
            "structure": StructureSource::Benchmark(BenchmarkRef(benchmark)),
        });
        fill(&mut value, benchmark.defaults());
        if let Ok(preset) = Accuracy::default().preset() {
            preset.fill(&mut value);
        }
        let read = || Self::understand(value);
        let scene = benchmark::scope(&[benchmark], read);
        let mut scene = scene.map_err(|refusal| refused(&format!("the defaults of {}", benchmark.name()), refusal))?;
        scene.units = Units::SI;
        Ok(scene)
    }

    /// Tension of a bolt (N), counted from zero in the order of the structure's bolts.
    pub fn tension(&self, bolt: usize) -> f64 {
        self.bolts.loads.get(bolt).unwrap_or(&self.bolts.load).si()
    }

    /// The scene of one of its interfaces, counted from zero, alone.
    #[must_use]
    pub fn of_interface(&self, number: usize) -> Self {
        Self {
            interfaces: self.interfaces.of(number),
            ..self.clone()
        }
    }

    /// The benchmarks that it names.
    pub fn benchmarks(&self) -> impl Iterator<Item = &'static dyn Benchmark> {
        let surfaces = self.interfaces.surfaces().map(|surface| match surface {
            Surface::Benchmark(benchmark) => Some(*benchmark),
            _ => None,
        });
        let own = self.interfaces.each.iter().map(|own| own.gap);
        let gaps = std::iter::once(Some(self.interfaces.gap)).chain(own);
        let gaps = gaps.map(|gap| match gap {
            Some(Gap::Benchmark(benchmark)) => Some(benchmark),
            _ => None,
        });
        let all = surfaces.chain(gaps).chain([self.structure.benchmark()]);
        all.flatten().map(|benchmark| benchmark.0)
    }

    /// Order of the elements that are made: of a benchmark, and of linear ones of a mesh or a deck.
    pub fn element_order(&self) -> ElementOrder {
        let default = match self.structure.source {
            StructureSource::Benchmark(_) | StructureSource::Mesh(_) => ElementOrder::Quadratic,
            StructureSource::Deck(_) | StructureSource::Matrices(_) => ElementOrder::Linear,
        };
        self.model.element_order.unwrap_or(default)
    }

    /// Formulation of the hexahedra of a benchmark, and of those that are made quadratic.
    pub fn hexahedra(&self) -> Formulation {
        let default = self.element_order().formulations().next();
        self.model.formulation.or(default).unwrap_or_default()
    }

    /// Whether bodies are made of the scene's material.
    pub(super) fn is_meshed_of_material(&self) -> bool {
        match &self.structure.source {
            StructureSource::Benchmark(_) | StructureSource::Mesh(_) => true,
            StructureSource::Deck(deck) => deck.materials == MaterialSource::Scene,
            StructureSource::Matrices(_) => false,
        }
    }

    /// Whether anything depends on the scene's material: bodies, or asperities.
    pub fn needs_material(&self) -> bool {
        self.is_meshed_of_material() || self.interfaces.surfaces().any(Surface::needs_material)
    }

    /// All paths in the scene.
    fn paths(&mut self) -> impl Iterator<Item = &mut std::path::PathBuf> {
        let structure: Vec<&mut std::path::PathBuf> = match &mut self.structure.source {
            StructureSource::Deck(deck) => vec![&mut deck.path],
            StructureSource::Mesh(mesh) => {
                let superelements = mesh.superelements.iter_mut().map(|body| &mut body.path);
                std::iter::once(&mut mesh.path).chain(superelements).collect()
            }
            StructureSource::Matrices(matrices) => vec![&mut matrices.path],
            StructureSource::Benchmark(_) => Vec::new(),
        };
        let Interfaces { surface, each, .. } = &mut self.interfaces;
        let own = each.iter_mut().filter_map(|own| own.surface.as_mut());
        let scans = std::iter::once(surface).chain(own).filter_map(|surface| match surface {
            Surface::Scans(scans) => Some([&mut scans.top.path, &mut scans.bottom.path]),
            _ => None,
        });
        let record = self.analyses.shock.as_mut().and_then(|shock| shock.record.as_mut());
        let record = record.map(|record| &mut record.path);
        let measured = &mut self.analyses.backbone.measured;
        structure
            .into_iter()
            .chain(scans.flatten())
            .chain(record)
            .chain(measured)
    }

    /// The measured surface that the scene's `surface` stands for; none for scans and given parameters.
    pub fn measured_surface(&self) -> Option<MeasuredSurface> {
        match &self.interfaces.surface {
            Surface::Measured => self.structure.benchmark()?.surface(),
            Surface::Benchmark(benchmark) => benchmark.surface(),
            Surface::SyntheticScan(_) | Surface::Scans(_) | Surface::Finish(_) | Surface::Parameters(_) => None,
        }
    }

    /// The measured surface whose gap the scene's `gap` stands for; none for flat faces and scans.
    pub fn measured_gap(&self) -> Option<MeasuredSurface> {
        match self.interfaces.gap {
            Gap::Measured => self.structure.benchmark()?.surface(),
            Gap::Benchmark(benchmark) => benchmark.surface(),
            Gap::Flat | Gap::Scan => None,
        }
    }

    /// Numbers of the amplitudes (from 1) whose fields are stored, ascending.
    pub fn fields_at(&self) -> Vec<usize> {
        let last = self.analyses.backbone.amplitudes;
        let mut numbers = self.output.fields_at.clone().unwrap_or_else(|| match last {
            0 => Vec::new(),
            _ => vec![1, last.div_ceil(2), (3 * last).div_ceil(4), last],
        });
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Refuses what is given but would be without effect.
    fn refuse_idle(&self, given: &Value) -> Result<(), Refusal> {
        let (deck, matrices) = (self.structure.deck(), self.structure.matrices());
        let over_jump = matrices.is_some_and(|matrices| matrices.coordinates == Coordinates::Jump);
        let other = self.structure.benchmark().is_none();
        let own_material = deck.is_some_and(|deck| deck.materials == MaterialSource::Deck);
        let Interfaces { surface, law, .. } = &self.interfaces;
        let default = Law::default();
        let parameters = matches!(surface, Surface::Parameters(_));
        let meshes = "meshes of a benchmark, and structure names another source";
        let reductions = "reductions, and matrices over the jump are reduced";
        let asperities = "asperities, which interfaces.surface.parameters replaces";
        let resolved = law.friction() != Friction::Lumped && !parameters;
        let lumped = "interfaces.law.friction = \"lumped\", which must be named; other friction sums over its bins, with Mindlin's stiffness";
        let foundation = resolved && law.friction() == Friction::Foundation;
        let of_parts = "interfaces.law.friction = \"foundation\", \"resolved\" or \"mindlin-iwan\"";
        let of_asperities = "interfaces.law.friction = \"resolved\" or \"mindlin-iwan\"";
        let not_foundation = "interfaces.law.friction = \"mindlin-iwan\", \"resolved\" or \"lumped\", which must be named; springs of a foundation slip on a circle and remember their stretch";
        let reads_asperities = match surface {
            Surface::Scans(scans) => scans.readings != Readings::default(),
            _ => false,
        };
        let by_strength = law.limit != default.limit;
        let coulomb = "interfaces.law.limit = \"coulomb\"; with others friction follows from the strength";
        let published_radii = matches!(law.radii, RadialRule::EquallySpaced(_));
        let points = matrices.is_some_and(|matrices| matrices.points.is_some());
        let meshed = "interface meshes, and structure.matrices.points has points of contact instead";
        // What makes a field idle, the field, what its default is, and what it belongs to.
        let idle = [
            (other, "/model/refinement", json!(RefinementLevel::default()), meshes),
            (other, "/model/arm_layers", Value::Null, meshes),
            (other, "/model/symmetry", json!("none"), meshes),
            (
                matrices.is_some(),
                "/model/element_order",
                Value::Null,
                "meshes, and structure.matrices has none",
            ),
            (
                matrices.is_some(),
                "/model/formulation",
                Value::Null,
                "meshes, and structure.matrices has none",
            ),
            (
                matrices.is_some(),
                "/model/material/density",
                Value::Null,
                "meshes, and structure.matrices has none",
            ),
            (
                own_material,
                "/model/material/density",
                Value::Null,
                "bodies of the scene's material, and these have the deck's; for the scene's give structure.deck.materials = \"scene\"",
            ),
            (
                matrices.is_some(),
                "/output/deformed",
                json!(false),
                "meshes, and structure.matrices has none",
            ),
            (
                self.structure.mesh().is_none(),
                "/interfaces/each",
                json!([]),
                "meshes, and structure names another source",
            ),
            (points, "/structure/matrices/interface", Value::Null, meshed),
            (
                points,
                "/interfaces/points_per_direction",
                json!(Interfaces::default_points()),
                meshed,
            ),
            (
                !self.structure.mesh().is_some_and(MeshFile::may_have_several_interfaces),
                "/model/coupling_tolerance",
                Value::Null,
                "meshes of several interfaces, and structure has one",
            ),
            (over_jump, "/model/modes", Value::Null, reductions),
            (over_jump, "/model/reduction_error", Value::Null, reductions),
            (parameters, "/interfaces/law/kind", json!(default.kind), asperities),
            (
                parameters,
                "/interfaces/law/tangential",
                json!(default.tangential),
                asperities,
            ),
            (
                parameters,
                "/interfaces/law/friction",
                json!(default.friction),
                asperities,
            ),
            (
                resolved && !(foundation && law.kind == LawKind::BoundaryElements),
                "/interfaces/law/kind",
                json!(default.kind),
                lumped,
            ),
            (
                resolved,
                "/interfaces/law/tangential",
                json!(default.tangential),
                lumped,
            ),
            (
                !resolved || foundation,
                "/interfaces/law/yield",
                Value::Null,
                of_asperities,
            ),
            (!resolved, "/interfaces/law/bins", json!(default.bins), of_parts),
            (
                foundation,
                "/interfaces/law/history",
                json!(default.history),
                not_foundation,
            ),
            (foundation, "/interfaces/law/cone", json!(default.cone), not_foundation),
            (
                law.kind == LawKind::BoundaryElements && reads_asperities,
                "/interfaces/surface/scans/readings",
                Value::Null,
                "asperities, and interfaces.law.kind = \"boundary-elements\" presses the scans themselves",
            ),
            (
                law.yielding.is_none(),
                "/interfaces/law/limit",
                json!(default.limit),
                "interfaces.law.yield; a limit that follows from the strength needs one",
            ),
            (by_strength, "/interfaces/mu", json!(0.0), coulomb),
            (by_strength, "/interfaces/friction_zones", json!([]), coulomb),
            (
                law.friction() != Friction::MindlinIwan || parameters,
                "/interfaces/law/radii",
                json!(default.radii),
                "interfaces.law.friction = \"mindlin-iwan\"",
            ),
            (
                published_radii,
                "/interfaces/law/history",
                json!(default.history),
                "other friction; equally spaced radii stick with the stiffness at the end point",
            ),
            (
                parameters,
                "/interfaces/gap",
                json!("flat"),
                "surfaces; interfaces.surface.parameters has a gap in each of its sets",
            ),
            (
                self.fields_at().is_empty(),
                "/analyses/backbone/loops_at",
                json!([]),
                "amplitudes whose fields are stored, and output.fields_at or analyses.backbone.amplitudes leaves none",
            ),
        ];
        let differs = |path, default: &Value| given.pointer(path).is_some_and(|value| value != default);
        match idle
            .iter()
            .find(|(idle, path, default, _)| *idle && differs(path, default))
        {
            Some((_, path, _, owner)) => {
                let field = path[1..].replace('/', ".");
                let message = format!("{field} belongs to {owner}; leave one of them out");
                Err(Refusal::of(field, message))
            }
            None => Ok(()),
        }
    }
}

pub(super) fn refused(place: &str, Refusal { field, message }: Refusal) -> Error {
    Error::Syntax {
        place: place.into(),
        field,
        message,
    }
}

fn listed(path: &str) -> Refusal {
    let message = format!("{path} is a list, but its fields have names; write it as {{ \"NAME\": VALUE, ... }}");
    Refusal::of(path, message)
}

/// Refuses lists in the place of blocks: which field a value belongs to, and in which unit it is, would depend on its place.
/// `own` is the scene as it was understood, with all fields by name.
fn refuse_lists(given: &Value, own: &Value, path: &str) -> Result<(), Refusal> {
    let within = |name: &str| match path {
        "" => name.to_owned(),
        _ => format!("{path}.{name}"),
    };
    match (given, own) {
        // Two files with all defaults.
        (Value::Array(files), Value::Object(fields)) if path == "interfaces.surface.scans" => {
            let faces = ["top", "bottom"].iter().filter_map(|name| fields.get(*name));
            files
                .iter()
                .zip(faces)
                .try_for_each(|(file, face)| refuse_lists(file, face, path))
        }
        (Value::Array(_), Value::Object(_)) => Err(listed(path)),
        (Value::Array(given), Value::Array(own)) => {
            let mut pairs = given.iter().zip(own);
            pairs.try_for_each(|(given, own)| refuse_lists(given, own, path))
        }
        (Value::Object(given), Value::Object(own)) => {
            let mut pairs = given
                .iter()
                .filter_map(|(name, value)| Some((name, value, own.get(name)?)));
            pairs.try_for_each(|(name, given, own)| refuse_lists(given, own, &within(name)))
        }
        _ => Ok(()),
    }
}

/// Fills in what other fields of a scene stand for.
fn imply(given: &Value, filled: &mut Value) -> Result<(), Refusal> {
    let limit = filled.pointer("/interfaces/law/limit");
    if limit.is_some_and(|limit| *limit != json!(AsperityLimit::Coulomb)) && given.pointer("/interfaces/mu").is_none() {
        // Friction follows from the strength.
        filled["interfaces"]["mu"] = json!(0.0);
    }
    if is_preloaded(filled) {
        fill(filled, json!({ "bolts": { "load": 0.0 } }));
    }
    torque::prepare(given, filled)
}

/// Whether the contact of matrices is preloaded without bolts, which then need no load.
fn is_preloaded(scene: &Value) -> bool {
    let sets = scene
        .pointer("/interfaces/surface/parameters/sets")
        .and_then(Value::as_array);
    let preloaded = |set: &Value| set.get("preload").is_some_and(|preload| !preload.is_null());
    scene.pointer("/structure/matrices").is_some() && sets.is_some_and(|sets| sets.iter().any(preloaded))
}

/// Names the first thing that the physics depends on and that nothing says.
fn require_physics(scene: &Value) -> Result<(), Refusal> {
    for (path, _) in PHYSICS {
        let parents = path.match_indices('/').skip(1).map(|(end, _)| &path[..end]);
        if let Some(block) = parents
            .into_iter()
            .find(|block| scene.pointer(block).is_some_and(Value::is_array))
        {
            return Err(listed(&block[1..].replace('/', ".")));
        }
    }
    // Whether a material that is not there at all is needed is known once the scene is understood.
    let has_material = scene
        .pointer("/model/material")
        .is_some_and(|material| !material.is_null());
    let is_idle = |path: &str| path.starts_with("/model/material/") && !has_material;
    let is_missing = |path: &str| scene.pointer(path).is_none_or(Value::is_null) && !is_idle(path);
    match PHYSICS.iter().find(|(path, _)| is_missing(path)) {
        Some((path, line)) => Err(missing(path, line)),
        None => Ok(()),
    }
}

/// What the physics depends on and nothing says; `line` gives it.
fn missing(path: &str, line: &str) -> Refusal {
    let field = path[1..].replace('/', ".");
    let message = format!("{field} is missing, and the structure has no default for it; add for example {line}");
    Refusal::of(field, message)
}

/// Writes `defaults` into a scene where it says nothing.
fn fill(scene: &mut Value, defaults: Value) {
    let (Some(scene), Value::Object(defaults)) = (scene.as_object_mut(), defaults) else {
        return;
    };
    for (name, default) in defaults {
        match scene.get_mut(&name) {
            None | Some(Value::Null) => {
                scene.insert(name, default);
            }
            Some(own) if BLOCKS.contains(&name.as_str()) => fill(own, default),
            Some(_) => {}
        }
    }
}
