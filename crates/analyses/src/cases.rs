//! Backbones of many scenes, of which those on equal structures share a reduction, and those with equal surfaces what was measured of them.

use super::effects::Effects;
use super::ensemble::loops_alone;
use super::mode_backbone::ModeAnalysis;
use super::prepared::check_bolts;
use super::prestress::closing_force;
use super::solver::Solver;
use super::variants::{Curve, VariantPoint};
use crate::Error;
use crate::results::provenance::{Input, InputRole, inputs_of};
use hyper_reduction::ErrorEstimate;
use joints::interface::SceneInterface;
use joints::progress::{Progress, Silent};
use joints::store::Options;
use joints::store::key::KeyBuilder;
use joints::structure::{StructuralModel, Structure};
use scenes::{Parameter, Scene, Units};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Changes whenever what a case holds means something else.
const LAYOUT: u64 = 1;

/// Name of a scene as a case, so that neither its address nor its messages depend on what it is called.
const NAME: &str = "the case";

/// Hashes (SHA-256 as hexadecimal text) of what a case depends on, program and arithmetic of the processor included.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaseKeys {
    /// Of all of it: equal cases have equal results, bit by bit.
    pub case: String,
    /// Of what its reduced structure follows from.
    pub structure: String,
    /// Of what its asperities follow from.
    pub surface: String,
}

/// Largest relative errors of results that are borne.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBounds {
    /// Of the frequency.
    pub frequency: f64,
    /// Of the damping ratio.
    pub damping: f64,
}

/// Makes the keys of cases. Files are read once per combination of structure and surfaces that names them.
#[derive(Debug, Default)]
pub struct CaseHasher {
    build: Option<String>,
    files: Mutex<BTreeMap<String, Arc<[Input]>>>,
}

/// The scene as a case: its hysteresis loops alone, for all modes of interest. Other methods, fields and what else it asks for do not change
/// them and are left out.
pub fn as_case(scene: &Scene) -> Scene {
    let mut case = loops_alone(scene, true);
    case.name = NAME.into();
    // Its settings are in the scene by now.
    case.accuracy = None;
    case.units = Units::SI;
    case
}

/// Those of some numbers of a case that its results do not depend on, with what is said of them. Paths that name no number of it are left out, as
/// are cases that have no interface: what is wrong with them is found when they run.
pub fn idle(case: &Scene, parameters: impl IntoIterator<Item = Parameter>) -> Vec<(Parameter, Error)> {
    let has_value = |parameter: &Parameter| parameter.value(case).is_ok();
    let mut numbers = parameters.into_iter().filter(has_value).peekable();
    if numbers.peek().is_none() {
        return Vec::new();
    }
    let Ok(structure) = Structure::try_new(case, &Silent) else {
        return Vec::new();
    };
    let Ok(effects) = Effects::try_new(case, &structure, None) else {
        return Vec::new();
    };
    let require = |parameter| effects.require(&parameter).err().map(|error| (parameter, error));
    numbers.filter_map(require).collect()
}

impl CaseHasher {
    /// For a build of the program, see [`Options::build`].
    pub fn new(build: Option<String>) -> Self {
        Self {
            build,
            files: Mutex::default(),
        }
    }

    /// The keys of a case that [`as_case`] made.
    ///
    /// # Errors
    /// A file that the scene names cannot be read.
    pub fn keys(&self, case: &Scene) -> Result<CaseKeys, Error> {
        let whole = case.encoded()?;
        let interfaces = &whole["interfaces"];
        let surfaces = json!([
            interfaces["surface"],
            interfaces["law"],
            interfaces["each"],
            whole["structure"]
        ])
        .to_string();
        let files = self.files(&surfaces, case)?;
        let mut model = whole["model"].clone();
        if let Some(material) = model.pointer_mut("/material").and_then(Value::as_object_mut) {
            // Judgements of results, which no matrix depends on.
            material.remove("hardness");
            material.remove("work_of_adhesion");
        }
        let bolts = &case.bolts;
        // Matrices without bolts need no loads.
        let is_idle = bolts.load.si() == 0.0;
        let structure = json!([
            whole["structure"],
            model,
            whole["bolts"]["behaviour"],
            case.analyses.tightening.is_some(),
            is_idle,
        ])
        .to_string();
        let of_surface = |input: &&Input| matches!(input.role, InputRole::TopScan | InputRole::BottomScan);
        let sums = |key: &mut KeyBuilder, of: &dyn Fn(&&Input) -> bool| {
            files.iter().filter(of).for_each(|input| key.text(&input.sha256));
        };
        let key = |text: &str, of: &dyn Fn(&&Input) -> bool| {
            let mut key = KeyBuilder::new(self.build.as_deref());
            key.integers([LAYOUT]);
            key.text(text);
            sums(&mut key, of);
            key.finish().0
        };
        Ok(CaseKeys {
            case: key(&whole.to_string(), &|_| true),
            structure: key(&structure, &|input| !of_surface(input)),
            surface: key(&surfaces, &|_| true),
        })
    }

    /// The address of a case with results that others taught it, from its own address, theirs and what its results may be off by.
    pub fn trained(&self, case: &str, teachers: &[String], borne: ErrorBounds) -> String {
        let mut key = KeyBuilder::new(self.build.as_deref());
        key.integers([LAYOUT]);
        key.text(case);
        teachers.iter().for_each(|teacher| key.text(teacher));
        key.numbers([borne.frequency, borne.damping]);
        key.finish().0
    }

    fn files(&self, named: &str, case: &Scene) -> Result<Arc<[Input]>, Error> {
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = files.get(named) {
            return Ok(known.clone());
        }
        let found: Arc<[Input]> = inputs_of(case)?.into();
        files.insert(named.to_owned(), found.clone());
        Ok(found)
    }
}

/// The backbone of a mode of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseMode {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Its linearised frequency (Hz).
    pub linear_frequency_hz: f64,
    /// Its damping ratio apart from friction.
    pub background: f64,
    /// Its amplitudes, ascending, or why one did not converge.
    pub amplitudes: Vec<Result<CasePoint, String>>,
}

/// An amplitude of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasePoint {
    /// What was found.
    pub point: VariantPoint,
    /// Estimated errors where it was found with few coordinates and few points; none of the whole joint.
    pub estimate: Option<ErrorEstimate>,
}

impl CaseMode {
    fn new(found: &ModeAnalysis, frequencies: &[f64]) -> Self {
        let amplitudes = found.amplitudes.iter().map(|amplitude| {
            let result = amplitude.point.result.as_ref();
            result.map_err(|failure| failure.reason.to_string())?;
            let point =
                VariantPoint::new(amplitude, found.background).ok_or_else(|| "its loop has no fields".to_owned())?;
            Ok(CasePoint { point, estimate: None })
        });
        Self {
            mode: found.mode,
            linear_frequency_hz: frequencies.get(found.mode - 1).copied().unwrap_or(f64::NAN),
            background: found.background,
            amplitudes: amplitudes.collect(),
        }
    }

    /// The amplitudes that converged, for interpolation.
    pub fn curve(&self) -> Curve {
        Curve {
            mode: self.mode,
            linear_frequency_hz: self.linear_frequency_hz,
            background: self.background,
            points: self
                .amplitudes
                .iter()
                .filter_map(|found| found.as_ref().ok().map(|found| found.point))
                .collect(),
            sensitivities: Vec::new(),
        }
    }
}

/// A structure that is reduced once, for all cases with the same [`CaseKeys::structure`].
#[derive(Debug)]
pub struct CaseStructure {
    structure: Structure,
    model: StructuralModel,
    options: Options,
}

impl CaseStructure {
    /// Builds and reduces the structure of a case, or takes the reduced model from the cache.
    ///
    /// # Errors
    /// Of the mesher, the files, the finite elements and the reduction.
    pub fn try_new(case: &Scene, options: &Options, progress: &dyn Progress) -> Result<Self, Error> {
        let structure = Structure::try_new(case, progress)?;
        let model = structure.reduce(options, progress)?;
        Ok(Self {
            structure,
            model,
            // Cases are the parts of a study that are kept; their loops are not kept one by one.
            options: Options {
                cache: None,
                ..options.clone()
            },
        })
    }

    /// Memory of the matrices of the reduced model, with symmetric entries once, as the cache has them (bytes).
    pub fn bytes(&self) -> usize {
        let reduced = &self.model.reduced;
        [&reduced.stiffness, &reduced.mass]
            .map(|matrix| matrix.as_ref().bytes())
            .iter()
            .sum()
    }

    pub(super) fn model(&self) -> &StructuralModel {
        &self.model
    }

    pub(super) fn solver(&self) -> Solver<'_> {
        Solver::of(&self.model, &self.options)
    }

    /// The interface of a case. Asperities are those of `known`, an interface with the same [`CaseKeys::surface`]; the result is the same
    /// without it.
    ///
    /// # Errors
    /// Of the surface and the law; bolts that the structure does not have.
    pub fn interface(&self, case: &Scene, known: Option<&SceneInterface>) -> Result<SceneInterface, Error> {
        check_bolts(case, self.model.reduced.loads.len())?;
        let (mesh, parts) = (self.structure.interface(), &self.structure.joint.parts);
        let load = closing_force(case, &self.model);
        let interface = SceneInterface::knowing(known, case, mesh, parts, load)?;
        self.solver().settled(case, interface, &Silent)
    }

    /// The backbones of a case with its interface, mode by mode.
    ///
    /// # Errors
    /// [`Error::Prestress`] and defects of the linear structure. Amplitudes that do not converge are results.
    pub fn backbones(
        &self,
        case: &Scene,
        interface: &SceneInterface,
        progress: &dyn Progress,
    ) -> Result<Vec<CaseMode>, Error> {
        let found = self
            .solver()
            .analyse(case, &interface.interface, interface.closure, None, progress)?;
        let modes = found.modes.iter();
        Ok(modes.map(|mode| CaseMode::new(mode, &found.frequencies)).collect())
    }
}
