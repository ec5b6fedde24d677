//! The machine-readable account of a run: the contract that scripts rely on, all in SI.

pub use super::amplitudes::{BackboneSummary, JointSummary, Status};
use super::answer::{Answer, Found, answer};
use super::provenance::Provenance;
use super::work::{self, Work};
use crate::adaptation::Adaptation;
use crate::amplitude::JointLoop;
use crate::comparison::{self, Misfit};
use crate::ensemble::Ensemble;
use crate::error_bar::ErrorBar;
use crate::error_estimate::ErrorEstimate;
use crate::forced::ForcedSummary;
use crate::mesh_error::MeshEstimate;
use crate::methods::MethodPoint;
use crate::random::RandomSummary;
use crate::ring_down::RingDownSummary;
use crate::shock::ShockSummary;
use crate::uncertainty::Uncertainty;
use crate::validity::Validity;
use crate::warnings::Warning;
use crate::{AmplitudeResult, Connection, ModeBackbone, Run, Sensitivity, TighteningResult};
use cqsma_solver::{Failure, Reason};
use dense_algebra::SystemMatrix;
use harmonic_balance::backbone::Point;
use joint_model::MovedPairs;
use joint_model::benchmark::Symmetry;
use joint_model::quadratic::RaisedElements;
use joints::interface::{LawReport, PartReport};
use joints::structure::Overview;
use scenes::{BoltBehaviour, EPMC, PRESETS, Preset, Shock, StructureSource, TorqueReport};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Version of the layout of [`Summary`]; grows with every change that is not a mere addition.
pub const SCHEMA_VERSION: u32 = 2;

/// A run in numbers.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Summary {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// The scene with all defaults filled in, in SI.
    pub scene: serde_json::Value,
    /// The structure in words: the title of a benchmark, or the file it comes from.
    #[serde(default)]
    pub title: String,
    /// Where and in which direction amplitudes are measured, in words.
    #[serde(default)]
    pub response: String,
    /// What was computed with: sizes, materials, surface, bolts and units; missing in older summaries.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overview: Option<Overview>,
    /// What was found of each mode followed, in few numbers; missing in older summaries.
    #[serde(default)]
    pub answer: Vec<Answer>,
    /// What is implausible in the input or the results.
    #[serde(default)]
    pub warnings: Vec<Warning>,
    /// The structure.
    pub model: ModelSummary,
    /// The law; of the first interface where there are several.
    pub law: LawReport,
    /// Interfaces, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub interfaces: Vec<PartReport>,
    /// The gap.
    pub gap: GapSummary,
    /// The static state.
    pub prestress: PrestressSummary,
    /// Torque of the bolts; left out unless the scene knows their thread.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<TorqueReport>,
    /// How the bolts were tightened one after the other; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tightening: Option<TighteningResult>,
    /// Modes about it.
    pub modes: Vec<ModeSummary>,
    /// Parts of the interface by bolt, whose motions and forces the amplitudes have; missing in older summaries.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub connections: Vec<Connection>,
    /// Amplitudes in ascending order.
    pub backbone: Vec<BackboneSummary>,
    /// Backbones of the methods beside CQSMA, by the names that scenes use.
    pub methods: BTreeMap<String, Vec<MethodSummary>>,
    /// Where several modes are followed: each of them. `backbone`, `methods` and `validity` are those of the first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub backbones: Vec<ModeBackboneSummary>,
    /// Measured backbones of the first mode followed, and how far it lies from them; left out unless the scene names any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<MeasuredSummary>,
    /// Derivatives of all backbones with respect to the numbers that the scene's `sensitivities` name; left out unless asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensitivities: Vec<Sensitivity>,
    /// Backbones of bootstrap realisations; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ensemble: Option<Ensemble>,
    /// Bands from uncertain inputs; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
    /// The measured set of settings that the scene has; left out where it has none of them as a whole.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "preset_of_name"
    )]
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Value>"))]
    pub accuracy: Option<&'static Preset>,
    /// How the settings were adapted to the errors that the scene bears; left out unless it names any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adaptation: Option<Adaptation>,
    /// Differences to a run with finer settings; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_estimate: Option<ErrorEstimate>,
    /// The limit of the mesh, estimated by a run with the other formulation of the elements; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh_estimate: Option<MeshEstimate>,
    /// Forced responses, level by level; empty unless asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forced: Vec<ForcedSummary>,
    /// Stationary random vibration, level by level; empty unless asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub random: Vec<RandomSummary>,
    /// Why there is none although it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub random_failure: Option<String>,
    /// A shock in time; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shock: Option<ShockSummary>,
    /// Free decay in time; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ring_down: Option<RingDownSummary>,
    /// Limits of the model.
    pub validity: Validity,
    /// What the scene does not require and was left out, and why; empty if nothing was.
    pub skipped: BTreeMap<String, String>,
    /// Program, processor and inputs; left out of summaries that a library made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
    /// Seconds per stage, and in total.
    pub timings: BTreeMap<String, f64>,
    /// What the stages with loops and periodic motions did, by the names of `timings`; missing in older summaries.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub work: BTreeMap<String, Work>,
    /// Largest memory of the process (bytes), where the system tells.
    pub peak_memory: Option<u64>,
}

/// The backbone of a mode.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModeBackboneSummary {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Its linearised frequency (Hz).
    pub frequency_hz: f64,
    /// Amplitudes in ascending order.
    pub backbone: Vec<BackboneSummary>,
    /// Backbones of the methods beside CQSMA, by the names that scenes use.
    pub methods: BTreeMap<String, Vec<MethodSummary>>,
    /// Measured backbones of the mode, and how far it lies from them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<MeasuredSummary>,
    /// Limits of the model.
    pub validity: Validity,
}

/// A measured backbone beside the computed one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeasuredSummary {
    /// Name, by its folder and file.
    pub name: String,
    /// Its points over amplitudes of displacement at the response point (m).
    pub points: Vec<comparison::Point>,
    /// Computed less measured over the amplitudes of displacement that both have, the computed ones by first harmonics; `null` where there are none.
    pub misfit: Option<Misfit>,
}

/// A preset as a summary has it, by its name.
fn preset_of_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<&'static Preset>, D::Error> {
    #[derive(Deserialize)]
    struct Named {
        name: String,
    }
    let Some(Named { name }) = Option::<Named>::deserialize(deserializer)? else {
        return Ok(None);
    };
    let found = PRESETS.iter().find(|preset| preset.name == name);
    found
        .map(Some)
        .ok_or_else(|| D::Error::custom(format!("there is no set of settings `{name}`")))
}

/// The structure.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModelSummary {
    /// Nodes of the solid mesh.
    pub n_nodes: Option<usize>,
    /// Its elements.
    pub n_elements: Option<usize>,
    /// Independent displacement components, or coordinates of imported matrices.
    pub n_dofs: usize,
    /// Mass (kg), if it is known.
    pub mass: Option<f64>,
    /// Area of the interface by quadrature (m^2).
    pub interface_area: f64,
    /// Interface elements.
    pub n_interface_elements: usize,
    /// Quadrature points.
    pub n_interface_points: usize,
    /// Jump coordinates.
    pub n_relative_dofs: usize,
    /// Retained stuck-interface modes, without the attachment modes of locked bolts.
    pub n_modes: usize,
    /// Zero-energy modes without contact.
    pub zem_unstressed: usize,
    /// Zero-energy modes with the interface stuck.
    pub zem_stuck: usize,
    /// Frequencies with the interface stuck (Hz).
    pub stuck_frequencies_hz: Vec<f64>,
    /// Frequencies without contact (Hz).
    pub unstressed_frequencies_hz: Vec<f64>,
    /// Full model with a uniform linear interface stiffness (Hz), and with the bolts locked in scenes that lock them.
    pub penalty_frequencies_hz: Vec<f64>,
    /// Largest relative difference of the reduced model to these.
    pub penalty_spectrum_error: f64,
    /// Difference between reduced matrices from condensation and from solves, relative to their largest entry.
    pub reduction_asymmetry: f64,
    /// The form of the reduced matrices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flexibility: Option<Flexibility>,
    /// Pairs of interface nodes of a deck that were moved to their midpoints; left out where all nodes coincide in pairs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moved_pairs: Option<MovedPairs>,
    /// Linear elements of a deck that were made quadratic; left out where the elements have the order that they were meshed in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raised: Option<RaisedElements>,
    /// How far results on this mesh are from the limit of the mesh.
    #[serde(default)]
    pub error_bar: ErrorBar,
}

/// The form of reduced matrices.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Flexibility {
    /// `dense`, or `blocks`: one of each interface, coupled through few combinations of its jump.
    pub form: String,
    /// Blocks.
    pub blocks: usize,
    /// Combinations of all blocks together.
    pub rank: usize,
    /// What may be left out of the coupling, relative to the largest; 0 of dense matrices.
    pub tolerance: f64,
    /// What is left out, and round-off: difference between some columns of the matrices and those found by solves with the full structure, relative to
    /// their largest entry.
    pub measured_error: f64,
}

/// The gap.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GapSummary {
    /// Smallest at a point (m); negative where a preload presses the faces into one another.
    pub smallest: f64,
    /// Largest at a point (m).
    pub largest: f64,
    /// Points whose value came out negative and was set to zero.
    pub clipped_points: usize,
}

/// The static state.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PrestressSummary {
    /// Tension of each bolt (N); of the first where they differ.
    pub bolt_load: f64,
    /// Tension of each bolt where the scene gives them one by one (N), and the residual one where bolts are tightened one after the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bolt_loads: Vec<f64>,
    /// Newton iterations with everything stuck and with friction, together.
    pub iterations: usize,
    /// Sum of absolute residual forces over sum of absolute loads on the interface.
    pub residual_ratio: f64,
    /// Relative error of the integrated pressure against the bolt loads; with a preload, what is missing in the balance along the normal
    /// relative to bolt loads and preload.
    pub equilibrium_error: f64,
    /// Area in contact over nominal area, by points.
    pub contact_area_fraction: f64,
    /// Largest pressure at a point (Pa).
    pub max_pressure: f64,
    /// Bolt loads over nominal area (Pa).
    pub mean_pressure: f64,
    /// Always true here: a prestress that does not converge is an error.
    pub converged: bool,
}

/// A mode.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModeSummary {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Derivative of its logarithm with respect to that of the stiffness of each interface with everything in contact stuck, in the order of
    /// `interfaces` (-): half of what the interface has of the strain energy of the mode. Missing in older summaries.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dln_frequency_by_interface: Vec<f64>,
}

/// One amplitude of a method beside CQSMA; `null` where it did not converge.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MethodSummary {
    /// Displacement amplitude at the response point (m): of `rqnma` with the shape found, of `epmc` that of the first harmonic, else with
    /// the linearised mode.
    pub response_displacement: Option<f64>,
    /// Secant frequency (Hz); of `epmc` that of the motion, as the next.
    pub frequency_hz: Option<f64>,
    /// Frequency of the first harmonic (Hz); that of `masing` and `rqnma` belongs to the loop by Masing's rule.
    #[serde(default)]
    pub frequency_first_harmonic_hz: Option<f64>,
    /// Total damping ratio, friction plus background; `null` below the floor, but not of `epmc`. By Masing's rule it may be negative.
    pub damping_ratio: Option<f64>,
    /// What residuals, and of `qsma` an open loop, may make of the friction part.
    pub damping_floor: Option<f64>,
    /// Modal force `omega^2 q` (sqrt(kg) m/s^2).
    pub modal_force: Option<f64>,
    /// Modal amplitude (sqrt(kg) m).
    pub modal_amplitude: Option<f64>,
    /// Residual relative to the load (energy norm).
    pub residual: Option<f64>,
    /// Highest harmonic; of `epmc` alone, as all that follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<usize>,
    /// Samples per period.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<usize>,
    /// Amplitudes of the harmonics from the first on over that of the first, in the norm of the mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_of_harmonics: Option<Vec<f64>>,
    /// Energy that the contact takes per period (J).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dissipation: Option<f64>,
    /// What is missing in the balance of energies, as a damping ratio.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_error: Option<f64>,
    /// Periods that the history was followed for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub periods: Option<usize>,
    /// Change of the tractions from the last period to the one before, relative to their range: what creeps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<f64>,
    /// Estimated relative errors of the frequency by too few harmonics and by too few samples, where an accuracy is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_errors: Option<[f64; 2]>,
    /// Errors of the damping ratio by the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_errors: Option<[f64; 2]>,
    /// Newton iterations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iterations: Option<usize>,
    /// Residuals evaluated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluations: Option<usize>,
    /// Preconditioned Krylov steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub krylov_steps: Option<usize>,
    /// Whether it converged.
    pub converged: bool,
    /// If not: why.
    pub failure: Option<String>,
}

impl Summary {
    /// Summarises a run without an ensemble; times and memory are the caller's to know.
    pub fn new(run: &Run, timings: BTreeMap<String, f64>, peak_memory: Option<u64>) -> Self {
        let (reduced, facts) = (&run.model.reduced, &run.model.facts);
        let operators = run.interface.operators();
        let prestress = &run.prestress;
        let residual = run.tightening.is_some().then_some(&prestress.tensions);
        let all = residual
            .and_then(|tensions| tensions.first().copied())
            .unwrap_or_else(|| run.scene.bolts.load.si());
        let bolts = all * prestress.tensions.iter().map(|tension| tension / all).sum::<f64>();
        let gaps = || run.interface.gap().unwrap_or(&[0.0]).iter().copied();
        let mut summary = Self {
            schema_version: SCHEMA_VERSION,
            scene: serde_json::to_value(&run.scene).unwrap_or(serde_json::Value::Null),
            title: match &run.scene.structure.source {
                StructureSource::Benchmark(benchmark) => benchmark.title().to_owned(),
                StructureSource::Deck(deck) => deck.path.display().to_string(),
                StructureSource::Mesh(mesh) => mesh.path.display().to_string(),
                StructureSource::Matrices(matrices) => matrices.path.display().to_string(),
            },
            response: run.joint.response.clone(),
            overview: Some(Overview {
                mass: facts.mass.or(run.joint.overview.mass),
                ..run.joint.overview.clone()
            }),
            answer: Vec::new(),
            warnings: run.warnings.clone(),
            model: ModelSummary {
                n_nodes: facts.n_nodes,
                n_elements: facts.n_elements,
                n_dofs: facts.n_dofs,
                mass: facts.mass,
                interface_area: operators.area(),
                n_interface_elements: operators.n_elements(),
                n_interface_points: operators.n_points(),
                n_relative_dofs: reduced.n_relative,
                n_modes: reduced.n_modes(),
                zem_unstressed: facts.zem_unstressed,
                zem_stuck: reduced.zem_stuck,
                stuck_frequencies_hz: reduced.stuck_frequencies.iter().take(10).copied().collect(),
                unstressed_frequencies_hz: facts.unstressed_frequencies_hz.clone(),
                penalty_frequencies_hz: facts.penalty_frequencies_hz.clone(),
                penalty_spectrum_error: facts.penalty_error,
                reduction_asymmetry: reduced.asymmetry,
                flexibility: Some(match &reduced.stiffness {
                    SystemMatrix::Dense(_) => Flexibility {
                        form: "dense".to_owned(),
                        blocks: 1,
                        rank: 0,
                        tolerance: 0.0,
                        measured_error: reduced.asymmetry,
                    },
                    SystemMatrix::Blocks(stiffness) => Flexibility {
                        form: "blocks".to_owned(),
                        blocks: stiffness.tree().n_groups(),
                        rank: stiffness.tree().combinations(),
                        tolerance: facts.coupling_tolerance.unwrap_or(0.0),
                        measured_error: reduced.asymmetry,
                    },
                }),
                moved_pairs: run.joint.moved_pairs,
                raised: run.joint.raised,
                error_bar: run.estimated_error.clone().unwrap_or_else(|| ErrorBar::of(&run.scene)),
            },
            law: run.law().clone(),
            interfaces: match run.parts.len() {
                1 => Vec::new(),
                _ => run.parts.clone(),
            },
            gap: GapSummary {
                smallest: gaps().fold(f64::INFINITY, f64::min),
                largest: gaps().fold(0.0, f64::max),
                clipped_points: run.clipped_gaps,
            },
            prestress: PrestressSummary {
                bolt_load: all,
                bolt_loads: match residual {
                    Some(tensions) => tensions.clone(),
                    None => run.scene.bolts.loads.iter().map(|load| load.si()).collect(),
                },
                iterations: prestress.solution.iterations.iter().sum(),
                residual_ratio: prestress.residual_ratio,
                equilibrium_error: prestress.equilibrium_error,
                contact_area_fraction: run.validity().contact_area_fraction_by_points,
                max_pressure: prestress.fields.traction[2].iter().copied().fold(0.0, f64::max),
                mean_pressure: bolts / operators.area(),
                converged: true,
            },
            torque: run.scene.torque_report(reduced.loads.len()),
            tightening: run.tightening.clone(),
            modes: (run.frequencies.iter().zip(&run.by_interface))
                .map(|(&frequency_hz, by_interface)| ModeSummary {
                    frequency_hz,
                    dln_frequency_by_interface: by_interface.clone(),
                })
                .collect(),
            connections: run.connections.clone(),
            backbone: backbone(run.first(), run),
            measured: measured(run.first(), run),
            methods: methods(run.first()),
            backbones: match run.backbones.as_slice() {
                [_] => Vec::new(),
                several => several.iter().map(|of| mode_backbone(of, run)).collect(),
            },
            sensitivities: run.backbones.iter().flat_map(sensitivities).cloned().collect(),
            ensemble: None,
            uncertainty: None,
            accuracy: Preset::of(&run.scene),
            adaptation: run.adaptation.clone(),
            error_estimate: None,
            mesh_estimate: None,
            forced: run
                .vibration
                .forced
                .iter()
                .flatten()
                .map(|level| {
                    ForcedSummary::of(
                        level,
                        run.scene
                            .analyses
                            .forced
                            .as_ref()
                            .map_or("N", |asked| asked.held().unit()),
                    )
                })
                .collect(),
            random: random(run),
            random_failure: run
                .vibration
                .random
                .as_ref()
                .and_then(|found| found.as_ref().err().map(ToString::to_string)),
            shock: run.vibration.shock.as_ref().map(|found| {
                let unit = run.scene.analyses.shock.as_ref().map_or("N", Shock::load_unit);
                ShockSummary::of(found, unit)
            }),
            ring_down: run.vibration.ring_down.as_ref().map(RingDownSummary::of),
            validity: run.validity().clone(),
            skipped: skipped(run),
            provenance: None,
            timings,
            work: work::of(run),
            peak_memory,
        };
        summary.answer = summary.answers();
        summary
    }

    /// The first mode followed, counted from 1.
    pub fn first_mode(&self) -> usize {
        let first = self.backbones.first().map(|of| of.mode);
        let followed = self.scene.pointer("/analyses/modes/followed/0");
        first.or_else(|| followed?.as_u64()?.try_into().ok()).unwrap_or(1)
    }

    /// The answers of all modes followed.
    pub fn answers(&self) -> Vec<Answer> {
        let first = self.first_mode();
        let of_mode = |(mode, summary): (Option<usize>, Cow<'_, Self>)| {
            let mode = mode.unwrap_or(first);
            let bands = self
                .uncertainty
                .iter()
                .flat_map(|found| &found.modes)
                .find(|of| of.mode == mode);
            Some(answer(&Found {
                mode,
                frequency_hz: self.modes.get(mode - 1)?.frequency_hz,
                backbone: &summary.backbone,
                error_bar: &self.model.error_bar,
                bands: bands.map_or(&[], |of| &of.bands),
                warnings: &self.warnings,
                validity: &summary.validity,
            }))
        };
        self.by_mode().filter_map(of_mode).collect()
    }

    /// With bands from uncertain inputs.
    pub fn with_uncertainty(mut self, uncertainty: Option<Uncertainty>) -> Self {
        self.uncertainty = uncertainty;
        self.answer = self.answers();
        self
    }
}

impl Summary {
    /// One summary per mode followed, with the backbone, the methods and the validity of that mode. The first is the summary
    /// itself; the others go with their mode, counted from 1.
    pub fn by_mode(&self) -> impl Iterator<Item = (Option<usize>, Cow<'_, Self>)> {
        let further = self.backbones.iter().skip(1);
        let further = further.map(|of| (Some(of.mode), Cow::Owned(self.of_mode(of))));
        std::iter::once((None, Cow::Borrowed(self))).chain(further)
    }

    fn of_mode(&self, mode: &ModeBackboneSummary) -> Self {
        Self {
            backbone: mode.backbone.clone(),
            methods: mode.methods.clone(),
            measured: mode.measured.clone(),
            validity: mode.validity.clone(),
            backbones: Vec::new(),
            sensitivities: Vec::new(),
            ensemble: None,
            error_estimate: None,
            mesh_estimate: None,
            forced: Vec::new(),
            random: Vec::new(),
            random_failure: None,
            shock: None,
            ring_down: None,
            work: BTreeMap::new(),
            ..self.clone()
        }
    }
}

/// Stationary random vibration of a run.
fn random(run: &Run) -> Vec<RandomSummary> {
    let (Some(Ok(levels)), Some(asked)) = (&run.vibration.random, &run.scene.analyses.random) else {
        return Vec::new();
    };
    let names: Vec<String> = run.parts.iter().map(|part| part.name.clone()).collect();
    let area = run.interface.operators().area();
    let unit = asked.load_unit();
    levels
        .iter()
        .map(|level| RandomSummary::of(level, unit, &names, area, &run.connections))
        .collect()
}

/// What the scene does not require, and is therefore not computed, not stored or not modelled.
fn skipped(run: &Run) -> BTreeMap<String, String> {
    let scene = &run.scene;
    let mut skipped = BTreeMap::new();
    if run.interface.gap().is_none() {
        let reason = "the faces touch everywhere before the bolts are tightened: no gap is kept or subtracted";
        skipped.insert("gap".to_owned(), reason.to_owned());
    }
    let (open, points) = (run.prestress.solution.counts.open, run.interface.operators().n_points());
    if open > 0 {
        let reason = format!(
            "{open} of {points} points are open under the bolt loads; where neighbours are open as well, only their closure is \
             computed, at every vertex anew"
        );
        skipped.insert("laws_of_open_points".to_owned(), reason);
    }
    if scene.analyses.backbone.amplitudes > 0 && !run.interface.dissipates() {
        let reason = "mu is zero: the history of friction cannot change what follows; no cycle is computed before the measured one, \
                      and that only one way, as the way back passes the same vertices";
        skipped.insert("way_back_of_loops".to_owned(), reason.to_owned());
    }
    if scene.model.symmetry == Symmetry::Half {
        let reason = "model.symmetry is half: only modes symmetric about y = 0 are in the results, numbered among themselves; \
                      mass, energies, forces and areas are those of the whole structure, while nodes, elements, points, \
                      coordinates and fields are those of its half y >= 0";
        skipped.insert("half_of_the_structure".to_owned(), reason.to_owned());
    }
    if scene.bolts.behaviour == BoltBehaviour::DeadLoad && scene.analyses.tightening.is_none() {
        let reason = "bolts.behaviour is dead-load: no static responses to the bolt loads join the modes";
        skipped.insert("attachment_modes".to_owned(), reason.to_owned());
    }
    let efforts = || run.amplitudes().iter().map(|amplitude| amplitude.point.effort);
    let (solves, factorisations): (usize, usize) = efforts()
        .map(|e| (e.solves, e.factorisations))
        .fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    if solves > factorisations {
        let reason = format!(
            "the structure with everything in contact stuck is inverted once: of {solves} equilibria of the loops {factorisations} \
             needed a factorisation, the others iterate about it on what slips, opens or changes its stiffness"
        );
        skipped.insert("factorisations".to_owned(), reason);
    }
    let (amplitudes, stored) = (scene.analyses.backbone.amplitudes, scene.fields_at().len());
    if stored < amplitudes {
        let reason = format!(
            "output.fields_at asks for the fields of {stored} of {amplitudes} amplitudes; the others keep sums over the interface"
        );
        skipped.insert("fields".to_owned(), reason);
    }
    let quiet = run
        .amplitudes()
        .iter()
        .filter(|a| a.point.result.as_ref().is_ok_and(|r| r.one_way));
    let quiet = quiet.count();
    if quiet > 0 && run.interface.dissipates() {
        let reason = format!(
            "of {amplitudes} loops {quiet} were computed one way only: the closed cycle before them dissipated nothing that can be \
             told from the residuals, so that the way back passes the same vertices"
        );
        skipped.insert("way_back_of_loops".to_owned(), reason);
    }
    skipped
}

fn hertz(omega: f64) -> f64 {
    omega / (2.0 * std::f64::consts::PI)
}

fn method(point: &MethodPoint, background: f64) -> MethodSummary {
    match &point.result {
        Ok(values) => MethodSummary {
            response_displacement: Some(values.response_displacement),
            frequency_hz: Some(hertz(values.omega)),
            frequency_first_harmonic_hz: Some(hertz(values.harmonic_omega)),
            damping_ratio: values.zeta.map(|zeta| zeta + background),
            damping_floor: Some(values.zeta_floor),
            modal_force: Some(values.modal_force),
            modal_amplitude: Some(values.modal_amplitude),
            residual: Some(values.residual),
            converged: true,
            failure: None,
            ..MethodSummary::default()
        },
        Err(failure) => MethodSummary {
            failure: Some(failure.reason.to_string()),
            ..MethodSummary::default()
        },
    }
}

fn mode_backbone(of: &ModeBackbone, run: &Run) -> ModeBackboneSummary {
    ModeBackboneSummary {
        mode: of.mode,
        frequency_hz: run.frequencies[of.mode - 1],
        backbone: backbone(of, run),
        methods: methods(of),
        measured: measured(of, run),
        validity: of.validity.clone(),
    }
}

/// Measured backbones of a mode: those to which no other mode followed is nearer in frequency.
fn measured(of: &ModeBackbone, run: &Run) -> Vec<MeasuredSummary> {
    let computed = backbone(of, run);
    let computed = computed.iter().filter_map(|point| {
        Some(comparison::Point {
            amplitude: point.response_motion?,
            frequency_hz: point.frequency_first_harmonic_hz?,
            damping_ratio: point.damping_ratio_first_harmonic,
        })
    });
    // Of fewer than two amplitudes there is no backbone to compare.
    let computed = comparison::Backbone::try_new("the run", computed.collect()).ok();
    let mine = run.measured.iter().filter(|one| {
        let frequency = one.backbone.points()[0].frequency_hz;
        let distance = |of: &&ModeBackbone| (run.frequencies[of.mode - 1] / frequency).ln().abs();
        let nearest = run.backbones.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.is_some_and(|nearest| nearest.mode == of.mode)
    });
    mine.map(|one| MeasuredSummary {
        name: one.name.clone(),
        points: one.backbone.points().to_vec(),
        misfit: computed.as_ref().and_then(|computed| computed.misfit(&one.backbone)),
    })
    .collect()
}

/// Those of the loops, then those of free motions.
fn sensitivities(of: &ModeBackbone) -> impl Iterator<Item = &Sensitivity> {
    let free = of.epmc.iter().flat_map(|found| &found.sensitivities);
    of.sensitivities.iter().chain(free)
}

fn methods(of: &ModeBackbone) -> BTreeMap<String, Vec<MethodSummary>> {
    let points = |points: &[MethodPoint]| points.iter().map(|p| method(p, of.background)).collect();
    let methods = of.methods.iter();
    let periodic = of.epmc.iter().map(|found| {
        let points = found.points.iter().zip(&found.response_displacement);
        let points = points.map(|(point, displacement)| periodic(point, *displacement, of.background));
        (EPMC.to_owned(), points.collect())
    });
    methods
        .map(|m| (m.method.name().to_owned(), points(&m.points)))
        .chain(periodic)
        .collect()
}

fn periodic(point: &Point, response_displacement: Option<f64>, background: f64) -> MethodSummary {
    let effort = point.effort;
    let work = MethodSummary {
        iterations: Some(effort.iterations),
        evaluations: Some(effort.evaluations),
        krylov_steps: Some(effort.krylov_steps),
        ..MethodSummary::default()
    };
    match &point.result {
        Ok(motion) => MethodSummary {
            response_displacement,
            frequency_hz: Some(hertz(motion.omega)),
            frequency_first_harmonic_hz: Some(hertz(motion.omega)),
            damping_ratio: motion.zeta.map(|zeta| zeta + background),
            damping_floor: Some(motion.energy_error.max(motion.residual)),
            modal_force: Some(motion.omega * motion.omega * motion.modal_amplitude),
            modal_amplitude: Some(motion.modal_amplitude),
            residual: Some(motion.residual),
            harmonics: Some(motion.sampling.harmonics),
            samples: Some(motion.sampling.samples),
            periods: Some(motion.sampling.periods),
            drift: Some(motion.drift),
            share_of_harmonics: Some(motion.share_of_harmonics.clone()),
            dissipation: Some(motion.dissipation),
            energy_error: Some(motion.energy_error),
            frequency_errors: motion.errors.map(|errors| errors.frequency),
            damping_errors: motion.errors.map(|errors| errors.damping),
            converged: true,
            ..work
        },
        Err(failure) => MethodSummary {
            modal_amplitude: Some(point.modal_amplitude),
            failure: Some(failure.reason.to_string()),
            ..work
        },
    }
}

fn backbone(of: &ModeBackbone, run: &Run) -> Vec<BackboneSummary> {
    let holds = of.validity.separation_modal_force.unwrap_or(f64::INFINITY);
    (of.amplitudes.iter())
        .map(|amplitude| backbone_point(amplitude, run, [of.background, holds]))
        .collect()
}

/// `background` is the damping ratio apart from friction, `holds` the modal force up to which bolts can hold the structure together.
fn backbone_point(amplitude: &AmplitudeResult, run: &Run, [background, holds]: [f64; 2]) -> BackboneSummary {
    let (scene, parts) = (&run.scene, &run.parts);
    let point = &amplitude.point;
    let result = point.result.as_ref().ok();
    let fields = amplitude.fields.as_ref();
    let zeta = result.filter(|r| r.is_resolved()).map(|r| r.zeta);
    BackboneSummary {
        status: match (&point.result, zeta) {
            (Err(failure), _) if failure.reason == Reason::BelowRoundOff => Status::BelowRoundOff,
            (Err(_), _) if point.modal_force > holds => Status::NoEquilibrium,
            (Err(_), _) => Status::NotConverged,
            (Ok(_), None) => Status::BelowFloor,
            _ => Status::Resolved,
        },
        modal_force: point.modal_force,
        modal_amplitude: result.map(|r| r.modal_amplitude),
        frequency_hz: result.map(|r| hertz(r.omega)),
        frequency_first_harmonic_hz: result.map(|r| hertz(r.harmonic_omega)),
        half_frequencies_hz: result.map(|r| r.half_omegas.map(hertz)),
        damping_ratio: zeta.map(|zeta| zeta + background),
        friction_damping_ratio: zeta,
        damping_ratio_first_harmonic: result
            .filter(|r| r.is_resolved())
            .map(|r| r.harmonic_zeta() + background),
        damping_floor: result.map(|r| r.zeta_floor),
        dissipation: fields.map(|f| f.dissipation),
        loop_area: result.map(|r| r.loop_area),
        coarse_loop_area: result.and_then(|r| r.coarse_loop_area),
        response_acceleration: amplitude.response_acceleration,
        response_displacement: amplitude.response_displacement,
        response_motion: fields.map(|f| f.response_motion),
        slip_fraction: fields.map(|f| f.slip_fraction),
        open_fraction: fields.map(|f| f.open_fraction),
        connections: fields.map_or_else(Vec::new, |fields| fields.connections.clone()),
        joints: fields.map_or_else(Vec::new, |fields| {
            let of_joint = |(part, joint): (&PartReport, &JointLoop)| JointSummary {
                name: part.name.clone(),
                slip_fraction: joint.slip_fraction,
                contact_area_fraction: 1.0 - joint.open_fraction,
                dissipation: joint.dissipation,
                dissipation_share: (fields.dissipation > 0.0).then(|| joint.dissipation / fields.dissipation),
            };
            parts.iter().zip(&fields.joints).map(of_joint).collect()
        }),
        load_points: point.effort.solves,
        iterations: point.effort.iterations,
        evaluations: point.effort.evaluations,
        krylov_steps: point.effort.krylov_steps,
        factorisations: point.effort.factorisations,
        shape_deviation: result.map(|r| r.shape_deviation),
        cycles: result.map(|r| r.cycles),
        vertices_per_quarter: result.map(|r| r.vertices_per_quarter()),
        one_way: result.map(|r| r.one_way),
        closed: result
            .filter(|_| scene.analyses.backbone.cycles.is_none())
            .map(|r| r.closed),
        loop_closure: result.map(|r| r.closure),
        residual: result.map(|r| r.residual),
        error: amplitude.error.clone(),
        converged: result.is_some(),
        failure: point.result.as_ref().err().map(|failure| told(failure, run)),
    }
}

/// Why an amplitude did not converge, and of several interfaces at which one the most is out of balance.
fn told(failure: &Failure, run: &Run) -> String {
    let operators = run.interface.operators();
    let is_at = |points, coordinate: usize| operators.nodes_of(points).contains(&(coordinate / 3));
    let part = failure
        .coordinate
        .filter(|_| run.parts.len() > 1)
        .and_then(|coordinate| {
            let mut points = run.interface.points_of_laws();
            run.parts.get(points.position(|points| is_at(points, coordinate))?)
        });
    match part {
        Some(part) => format!(
            "{}; most of what is out of balance is at interface `{}`",
            failure.reason, part.name
        ),
        None => failure.reason.to_string(),
    }
}
