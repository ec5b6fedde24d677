//! A plan with its cases, all of which have been understood and validated.

use crate::Error;
use crate::case::{Case, Part};
use crate::design::{Column, Design, Kind, put};
use crate::plan::{Base, Plan};
use crate::store::Store;
use crate::training::{self, Terms};
use analyses::cases::{CaseHasher, as_case, idle};
use analyses::results::provenance::{Input, inputs_of};
use joint_model::Benchmarks;
use rayon::prelude::*;
use scenes::{Parameter, Scene};
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

/// The scene of a plan before anything of it varies.
#[derive(Clone, Debug)]
pub struct BaseScene {
    /// As its file has it.
    pub value: Value,
    /// Its name, where it has none of its own.
    pub name: String,
    /// Folder that relative paths in it start from.
    pub folder: Option<PathBuf>,
}

/// A plan with its cases.
pub struct Study<'a> {
    name: String,
    base: BaseScene,
    benchmarks: Benchmarks<'a>,
    pub(crate) plan: Plan,
    pub(crate) design: Design,
    /// The distinct cases, those on one structure beside each other, and within it those with one surface.
    pub(crate) cases: Vec<Case>,
    /// For each number of the plan, the index of its case.
    pub(crate) of_plan: Vec<usize>,
    /// Keys of the structures.
    pub(crate) structures: Vec<String>,
    /// For each structure whose cases learn from some of them, these, in the order in which they teach.
    pub(crate) training: BTreeMap<usize, Vec<usize>>,
    inputs: Vec<Input>,
}

/// How far a study is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Cases of the plan.
    pub cases: usize,
    /// Those that differ.
    pub distinct: usize,
    /// Structures that differ.
    pub structures: usize,
    /// Distinct cases of which all amplitudes converged.
    pub converged: usize,
    /// Distinct cases of which some amplitudes did not converge.
    pub partly_converged: usize,
    /// Distinct cases without a backbone.
    pub failed: usize,
    /// Distinct cases that are not done.
    pub pending: usize,
}

impl<'a> Study<'a> {
    /// Understands and validates the scenes of all cases. `build` is that of the program, see [`joints::Options::build`].
    ///
    /// # Errors
    /// [`Error::Plan`], [`Error::Pointer`], [`Error::Case`] of the first case that is not admissible; a file that a scene names cannot be read.
    pub fn new(
        plan_path: &Path,
        plan: Plan,
        base: BaseScene,
        benchmarks: Benchmarks<'a>,
        build: Option<String>,
    ) -> Result<Self, Error> {
        let name = plan_path.display().to_string();
        let design = Design::new(&plan, &name)?;
        let mut study = Self {
            name,
            base,
            benchmarks,
            plan,
            design,
            cases: Vec::new(),
            of_plan: Vec::new(),
            structures: Vec::new(),
            training: BTreeMap::new(),
            inputs: Vec::new(),
        };
        training::check(&study.plan, &study.name)?;
        // The scene itself first: what is wrong with it is no fault of a value. What it leaves out, cases may give.
        let hasher = CaseHasher::new(build);
        let understood = |number: usize| {
            let whole = study.in_full(number)?;
            let terms = study.plan.hyper_reduction.map(|plan| Terms::of(&whole, &plan));
            let keys = hasher.keys(&as_case(&whole))?;
            Ok::<_, Error>((keys, terms))
        };
        let all: Vec<_> = (0..study.design.number).into_par_iter().map(understood).collect();
        let mut files = BTreeMap::new();
        let mut found = Vec::with_capacity(all.len());
        let mut terms = Vec::with_capacity(all.len());
        for understood in all {
            let (keys, own) = understood?;
            found.push(keys);
            terms.push(own);
        }
        let index = |keys: BTreeSet<&String>| -> (Vec<String>, HashMap<String, usize>) {
            let sorted: Vec<String> = keys.into_iter().cloned().collect();
            let places = sorted.iter().cloned().zip(0..).collect();
            (sorted, places)
        };
        let (structures, of_structure) = index(found.iter().map(|keys| &keys.structure).collect());
        let (_, of_surface) = index(found.iter().map(|keys| &keys.surface).collect());
        let mut first: HashMap<&String, usize> = HashMap::new();
        let mut cases = Vec::new();
        for (number, keys) in found.iter().enumerate() {
            first.entry(&keys.case).or_insert_with(|| {
                cases.push(Case {
                    address: keys.case.clone(),
                    number,
                    structure: of_structure.get(&keys.structure).copied().unwrap_or_default(),
                    surface: of_surface.get(&keys.surface).copied().unwrap_or_default(),
                    learns: None,
                });
                number
            });
        }
        cases.sort_by_key(|case| (case.structure, case.surface, case.number));
        let place: HashMap<&String, usize> = cases.iter().map(|case| &case.address).zip(0..).collect();
        let of_plan = found
            .iter()
            .map(|keys| place.get(&keys.case).copied().unwrap_or_default());
        study.of_plan = of_plan.collect();
        // One case of each structure and surface names all files.
        for case in &cases {
            if let std::collections::btree_map::Entry::Vacant(entry) = files.entry((case.structure, case.surface)) {
                entry.insert(inputs_of(&study.scene(case.number)?)?);
            }
        }
        for input in files.into_values().flatten() {
            if !study.inputs.contains(&input) {
                study.inputs.push(input);
            }
        }
        study.training = training::choose(&study.plan, &study.name, &study.design, &cases, &study.of_plan, &terms)?;
        for taught in study.training.values() {
            let own = taught.first().and_then(|index| cases.get(*index));
            let Some((structure, borne)) =
                own.and_then(|own| Some((own.structure, terms.get(own.number)?.as_ref()?.borne)))
            else {
                continue;
            };
            let teachers = taught.iter().filter_map(|index| cases.get(*index));
            let teachers: Vec<String> = teachers.map(|case| case.address.clone()).collect();
            for (index, case) in cases.iter_mut().enumerate() {
                if case.structure == structure && !taught.contains(&index) {
                    case.address = hasher.trained(&case.address, &teachers, borne);
                    case.learns = Some(borne);
                }
            }
        }
        (study.cases, study.structures) = (cases, structures);
        Ok(study)
    }

    /// The scene of a case of the plan, as its loops alone.
    pub(crate) fn scene(&self, number: usize) -> Result<Scene, Error> {
        Ok(as_case(&self.in_full(number)?))
    }

    /// The distinct cases of the plan: addresses, and scenes with all that they ask for.
    pub fn cases_in_full(&self) -> impl Iterator<Item = Result<(&str, Scene), Error>> {
        let scenes = self.cases.iter().map(|case| (case, self.in_full(case.number)));
        scenes.map(|(case, scene)| Ok((case.address.as_str(), scene?)))
    }

    /// The scene of a case of the plan, with all that it asks for.
    fn in_full(&self, number: usize) -> Result<Scene, Error> {
        let mut value = self.base.value.clone();
        let mut place = format!("{}: case {}", self.name, number + 1);
        let mut separator = " (";
        for (column, own) in self.design.columns.iter().zip(self.design.values(number)) {
            let Some(own) = own else { continue };
            place += &format!("{separator}{} = {own}", column.pointer);
            separator = ", ";
            put(&mut value, &column.pointer, own.clone()).map_err(|reason| Error::Pointer {
                plan: self.name.clone(),
                pointer: column.pointer.clone(),
                value: own.to_string(),
                reason,
            })?;
        }
        if separator == ", " {
            place.push(')');
        }
        let scene = Scene::from_value(value, &place, &self.base.name, self.benchmarks);
        let mut scene = scene.map_err(|error| Error::Case(error.into()))?;
        if let Some(folder) = &self.base.folder {
            scene.resolve(folder);
        }
        Ok(scene)
    }

    /// Refuses a parameter that no result depends on. It builds the structure and the contact of the first case, and of each other case whose
    /// settings that are no numbers differ, for as long as a parameter is left.
    ///
    /// # Errors
    /// [`Error::Plan`]; those of [`Study::new`].
    pub fn refuse_idle(&self) -> Result<(), Error> {
        let columns = &self.design.columns;
        let path = |column: &Column| Parameter::new(column.pointer.trim_start_matches('/').replace('/', "."));
        let mut left: Vec<Parameter> = columns.iter().map(path).collect();
        let mut refused = None;
        let mut seen = HashSet::new();
        for number in 0..self.design.number {
            let own = columns.iter().zip(self.design.values(number));
            let settings = own.filter(|(column, _)| column.kind == Kind::Text);
            if !seen.insert(settings.map(|(_, value)| value).collect::<Vec<_>>()) {
                continue;
            }
            let idle = idle(&self.scene(number)?, left);
            if idle.is_empty() {
                return Ok(());
            }
            let (parameters, errors): (_, Vec<_>) = idle.into_iter().unzip();
            left = parameters;
            refused = errors.into_iter().next();
        }
        refused.map_or(Ok(()), |error| {
            Err(Error::Plan {
                plan: self.name.clone(),
                field: "parameters".into(),
                reason: error.to_string(),
            })
        })
    }

    /// Amplitudes of some cases that converged, and how many of them were found with few coordinates and points; none where no case learns.
    pub fn found_with_few(&self, range: std::ops::Range<usize>, store: &Store) -> Option<[usize; 2]> {
        self.plan.hyper_reduction?;
        let cases = self.cases.get(range).unwrap_or_default();
        let records = cases.iter().filter_map(|case| store.get(&case.address));
        let modes = records.flat_map(|record| record.outcome.iter().flatten());
        let points = modes.flat_map(|mode| mode.amplitudes.iter().flatten());
        Some(points.fold([0; 2], |[all, few], point| {
            [all + 1, few + usize::from(point.estimate.is_some())]
        }))
    }

    /// Rows that a case has in tables, if it converges.
    ///
    /// # Errors
    /// Those of [`Study::new`].
    pub fn rows_per_case(&self) -> Result<usize, Error> {
        let scene = self.scene(0)?;
        Ok(scene.analyses.backbone.amplitudes * scene.analyses.modes.followed.len())
    }

    /// Name of the scene.
    pub fn scene_name(&self) -> &str {
        let own = self.base.value.get("name").and_then(Value::as_str);
        own.unwrap_or(&self.base.name)
    }

    /// Files that the scenes name.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// Parameters as columns of tables.
    pub fn columns(&self) -> &[Column] {
        &self.design.columns
    }

    /// Analyses of the scene beside CQSMA, which studies leave out, by the paths of their blocks.
    pub fn left_out(&self) -> Vec<String> {
        let asks = |value: &Value| match value {
            Value::Array(list) => !list.is_empty(),
            other => !other.is_null(),
        };
        let scene = &self.base.value;
        let methods = scene.pointer("/analyses/backbone/methods");
        let methods = methods.map(|value| ("analyses.backbone.methods".to_owned(), value));
        let analyses = scene.get("analyses").and_then(Value::as_object).into_iter().flatten();
        let others = analyses.filter(|(name, _)| !["modes", "backbone", "tightening"].contains(&name.as_str()));
        let others = others.map(|(name, value)| (format!("analyses.{name}"), value));
        let uncertain = scene.get("uncertain").map(|value| ("uncertain".to_owned(), value));
        let all = methods.into_iter().chain(others).chain(uncertain);
        all.filter(|(_, value)| asks(value)).map(|(path, _)| path).collect()
    }

    /// The distinct cases of a part, or all, by index.
    pub fn part(&self, part: Option<Part>) -> std::ops::Range<usize> {
        part.map_or(0..self.cases.len(), |part| part.range(self.cases.len()))
    }

    /// Those of some cases that are not in the store, and with `retry` also those that failed.
    pub fn pending(&self, cases: std::ops::Range<usize>, store: &Store, retry: bool) -> Vec<usize> {
        let is_pending = |index: &usize| {
            let found = self.cases.get(*index).and_then(|case| store.get(&case.address));
            found.is_none_or(|record| retry && !record.is_converged())
        };
        cases.filter(is_pending).collect()
    }

    /// How far some cases are.
    pub fn counts(&self, range: std::ops::Range<usize>, store: &Store) -> Counts {
        let cases = self.cases.get(range.clone()).unwrap_or_default();
        let structures: BTreeSet<usize> = cases.iter().map(|case| case.structure).collect();
        let mut counts = Counts {
            cases: self.of_plan.iter().filter(|index| range.contains(index)).count(),
            distinct: cases.len(),
            structures: structures.len(),
            converged: 0,
            partly_converged: 0,
            failed: 0,
            pending: 0,
        };
        for case in cases {
            let count = match store.get(&case.address) {
                None => &mut counts.pending,
                Some(record) if record.is_converged() => &mut counts.converged,
                Some(record) if record.outcome.is_ok() => &mut counts.partly_converged,
                Some(_) => &mut counts.failed,
            };
            *count += 1;
        }
        counts
    }

    /// The store in a folder, as far as it concerns some cases.
    ///
    /// # Errors
    /// [`Error::Store`].
    pub fn store(&self, root: &Path, cases: std::ops::Range<usize>) -> Result<Store, Error> {
        let cases = self.cases.get(cases).unwrap_or_default();
        let structures: BTreeSet<usize> = cases.iter().map(|case| case.structure).collect();
        let keys = structures.into_iter().filter_map(|index| self.structures.get(index));
        Store::open(root, keys, cases.iter().map(|case| case.address.clone()))
    }

    /// The plan with the scene in it, unless that names files, and the values of grids written out: a plan of the same cases.
    pub fn resolved(&self) -> Plan {
        let mut plan = self.plan.clone();
        if self.inputs.is_empty() {
            plan.scene = Base::Inline(self.base.value.clone());
        }
        if let Some(grid) = self.design.grid() {
            for ((_, parameter), values) in plan.parameters.0.iter_mut().zip(grid) {
                *parameter = crate::plan::Parameter {
                    values: Some(values.clone()),
                    ..Default::default()
                };
            }
        }
        plan
    }
}
