//! A scene, run from mesh to results.

use super::costs;
use super::deformed::Deformed;
use super::dials::AmplitudeError;
use super::ensemble::{self, Ensemble, Member};
use super::epmc::EpmcBackbone;
use super::error_bar::ErrorBar;
use super::finite_differences;
use super::mode_backbone::{ModeAnalysis, ModeBackbone};
use super::outcome::Analysis;
use super::prepared::{Prepared, prepare};
use super::prestress::PrestressResult;
use super::run::Run;
use super::sensitivities::Sensitivity;
use super::solver::{Solver, kept};
use super::validity::{self, LARGEST_CONTACT};
use super::variants::Variants;
use super::warnings::{self, ContactCircles, Findings};
use crate::Error;
use joints::progress::{Progress, Stage, Within, end_stage};
use joints::store::Options;
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use joints::structure::choice_name;
use scenes::{Friction, Law, Parameter, Scale, Scene, Stress, Surface};

/// Runs a scene and an ensemble of `realisations` bootstrap realisations of its laws, see [`Prepared::solve_ensemble`].
///
/// # Errors
/// As [`super::run`] and [`Prepared::solve_ensemble`].
pub fn run_ensemble(
    scene: &Scene,
    realisations: usize,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Run, Ensemble), Error> {
    if !scene.interfaces.surface.is_scanned() {
        return Err(joints::Error::NoSamples.into());
    }
    costs::expect_samples(realisations, progress);
    prepare(scene, options, progress)?.solve_ensemble(realisations, progress)
}

/// What is found of the bodies after the loops.
pub(super) struct OfBodies {
    deformed: Option<Deformed>,
    estimated_error: Option<ErrorBar>,
}

impl Prepared {
    /// Prestress, modes and backbone of the scene itself, with all its derivatives.
    ///
    /// # Errors
    /// As [`Solver::analyse`].
    pub(super) fn analyse_in_full(&self, progress: &dyn Progress) -> Result<Analysis, Error> {
        let beside = self.beside(progress)?;
        let mut analysis = self.analyse_itself(None, beside.as_deref(), progress)?;
        let Some(structure) = self
            .structure
            .as_ref()
            .filter(|_| !self.derivatives.differenced.is_empty())
        else {
            return Ok(analysis);
        };
        let parameters = self.derivatives.differenced.clone();
        let variants = Variants::new(&self.scene, parameters, structure, self, &self.options);
        let (found, checkpoints) = finite_differences::sensitivities(&variants, &analysis, progress)?;
        analysis.checkpoints.extend(checkpoints);
        let order = |one: &Sensitivity| {
            self.scene
                .analyses
                .sensitivities
                .iter()
                .position(|known| *known == one.parameter)
        };
        for (mode, found) in analysis.modes.iter_mut().zip(found) {
            mode.sensitivities.extend(found);
            mode.sensitivities.sort_by_key(order);
        }
        Ok(analysis)
    }

    /// Prestress, modes and backbone.
    ///
    /// # Errors
    /// [`Error::Prestress`] and defects of the linear structure.
    pub fn solve(self, progress: &dyn Progress) -> Result<Run, Error> {
        let analysis = self.analyse_in_full(progress)?;
        let bodies = self.bodies(&analysis, progress)?;
        Ok(self.finish(analysis, bodies, progress))
    }

    /// As [`Prepared::solve`], and then the backbones of `realisations` bootstrap realisations of all elements' laws on
    /// the same reduced structure. With a cache, realisations of an interrupted ensemble are taken from there.
    ///
    /// # Errors
    /// As [`Prepared::solve`]; [`joints::Error::NoSamples`] for surfaces that are not scanned; an interruption. Whatever else
    /// ends a realisation is part of the result.
    pub fn solve_ensemble(self, realisations: usize, progress: &dyn Progress) -> Result<(Run, Ensemble), Error> {
        let mut analysis = self.analyse_in_full(progress)?;
        let (ensemble, checkpoints) = self.ensemble(realisations, &analysis, progress)?;
        analysis.checkpoints.extend(checkpoints);
        let bodies = self.bodies(&analysis, progress)?;
        Ok((self.finish(analysis, bodies, progress), ensemble))
    }

    fn ensemble(
        &self,
        realisations: usize,
        analysis: &Analysis,
        progress: &dyn Progress,
    ) -> Result<(Ensemble, Checkpoints), Error> {
        progress.begin(Stage::Ensemble);
        // Fields, other methods and other modes are left to the measured law.
        let scene = ensemble::loops_alone(&self.scene, false);
        let checkpoint = match kept(&scene, &self.options)? {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                // Whatever else the realisations depend on has left its mark in the measured backbone.
                key.numbers(analysis.prestress.solution.displacement.iter().copied());
                key.numbers(analysis.frequencies.iter().copied());
                Checkpoint::open(directory, "ensemble", &key.finish())
            }
        };
        let realisations = ensemble::Batch {
            name: "realisations",
            number: realisations,
            loops: scene.analyses.backbone.amplitudes.max(1),
            progress,
        };
        let solver = Solver {
            neighbours: &[],
            ..self.solver()
        };
        let analyse = |k, progress: &dyn Progress| {
            let (interface, closure) = self.interface.realisation(k)?;
            solver.analyse(&scene, &interface, closure, None, progress)
        };
        let (members, checkpoints) = realisations.run(checkpoint, analyse, Member::new)?;
        progress.end(Stage::Ensemble);
        Ok((Ensemble::new(members, &analysis.modes[0].amplitudes), checkpoints))
    }

    /// What is found of the bodies after the loops.
    ///
    /// # Errors
    /// An interruption; of the displacements.
    pub(super) fn bodies(&self, analysis: &Analysis, progress: &dyn Progress) -> Result<OfBodies, Error> {
        let is_asked = self.structure.is_some() && (self.scene.output.deformed || ErrorBar::is_estimated(&self.scene));
        if !is_asked {
            return Ok(OfBodies {
                deformed: None,
                estimated_error: None,
            });
        }
        progress.begin(Stage::Bodies);
        let middle = match (self.scene.output.deformed, ErrorBar::is_estimated(&self.scene)) {
            (true, true) => 0.4,
            (true, false) => 1.0,
            (false, _) => 0.0,
        };
        let found = OfBodies {
            deformed: self.deformed(analysis, &Within::new(progress, Stage::Bodies, [0.0, middle]))?,
            estimated_error: self.estimated_error(analysis, &Within::new(progress, Stage::Bodies, [middle, 1.0]))?,
        };
        end_stage(progress, Stage::Bodies)?;
        Ok(found)
    }

    /// Gives each amplitude its error, of which `estimated` is that of the mesh where no table has it.
    pub(super) fn estimate_errors(&self, modes: &mut [ModeAnalysis], estimated: Option<&ErrorBar>) {
        let is_meshed = self.scene.structure.matrices().is_none();
        let bar = is_meshed.then(|| estimated.cloned().unwrap_or_else(|| ErrorBar::of(&self.scene)));
        for mode in modes {
            for at in 0..mode.amplitudes.len() {
                mode.amplitudes[at].error = AmplitudeError::of(&mode.amplitudes, at, bar.as_ref(), mode.truncation);
            }
        }
    }

    pub(super) fn finish(mut self, mut analysis: Analysis, bodies: OfBodies, progress: &dyn Progress) -> Run {
        self.estimate_errors(&mut analysis.modes, bodies.estimated_error.as_ref());
        self.scene.analyses.sensitivities.truncate(self.derivatives.shown);
        let Analysis {
            prestress,
            tightening,
            frequencies,
            by_interface,
            flexibility_bytes,
            modes,
            vibration,
            checkpoints,
        } = analysis;
        let asperities = self.interface.asperities();
        let shown = |mut all: Vec<Sensitivity>| {
            all.truncate(self.derivatives.shown);
            all
        };
        let judge = |found: ModeAnalysis| ModeBackbone {
            validity: validity::assess(
                &self.interface.interface,
                asperities.as_ref(),
                self.scene.model.material.as_ref(),
                self.reports[0].law.resolved.as_ref().and_then(|law| law.onset_of_yield),
                self.scene.interfaces.law.yielding(),
                &prestress.fields,
                self.joint.clearance,
                found.separation,
                &found.amplitudes,
            ),
            mode: found.mode,
            background: found.background,
            amplitudes: found.amplitudes,
            methods: found.methods,
            epmc: found.epmc.map(|epmc| EpmcBackbone {
                sensitivities: shown(epmc.sensitivities),
                ..epmc
            }),
            sensitivities: shown(found.sensitivities),
        };
        let backbones: Vec<ModeBackbone> = modes.into_iter().map(judge).collect();
        let found = self.findings(&prestress, &frequencies, &backbones);
        let of_results = warnings::of_results(&self.joint.overview, &found);
        of_results.iter().for_each(|warning| progress.warn(&warning.message));
        let mut warnings = warnings::of_input(&self.joint.overview);
        warnings.extend(of_results);
        Run {
            backbones,
            warnings,
            joint: self.joint,
            frequencies,
            by_interface,
            flexibility_bytes,
            vibration,
            prestress,
            tightening,
            parts: self.reports,
            clipped_gaps: self.interface.clipped_gaps,
            interface: self.interface.interface,
            model: self.model,
            deformed: bodies.deformed,
            estimated_error: bodies.estimated_error,
            loop_elements: self.loop_elements,
            connections: self.connections,
            measured: self.measured,
            adaptation: None,
            scene: self.scene,
            checkpoints,
        }
    }

    /// Smallest damping ratio that is differentiated by another number than a friction coefficient, with friction of asperities.
    fn differentiated(&self, backbones: &[ModeBackbone]) -> Option<f64> {
        let interfaces = &self.scene.interfaces;
        let own = interfaces.each.iter().filter_map(|own| own.law.as_ref());
        let is_resolved = |law: &Law| law.friction() != Friction::Lumped;
        let has_asperities = interfaces
            .surfaces()
            .any(|surface| !matches!(surface, Surface::Parameters(_)));
        let by_others = self
            .scene
            .analyses
            .sensitivities
            .iter()
            .any(|number| !is_friction(number));
        if !(by_others && has_asperities && std::iter::once(&interfaces.law).chain(own).any(is_resolved)) {
            return None;
        }
        let amplitudes = backbones.iter().flat_map(|backbone| &backbone.amplitudes);
        let damping = amplitudes.filter_map(|amplitude| amplitude.point.result.as_ref().ok());
        let damping = damping.filter(|found| found.is_resolved()).map(|found| found.zeta);
        damping.reduce(f64::min)
    }

    /// What warnings judge.
    fn findings(&self, prestress: &PrestressResult, frequencies: &[f64], backbones: &[ModeBackbone]) -> Findings {
        let validity = backbones.first().map(|first| &first.validity);
        let pressures = &prestress.fields.traction[2];
        let hardness = self
            .scene
            .model
            .material
            .and_then(|material| material.hardness)
            .map(Stress::si);
        let operators = self.interface.interface.operators();
        let above = pressures.iter().zip(&operators.weights);
        let above = above.filter(|(pressure, _)| hardness.is_some_and(|hardness| **pressure > hardness));
        Findings {
            hardness,
            peak_pressure: pressures.iter().copied().fold(0.0, f64::max),
            share_above_hardness: above.map(|(_, weight)| weight).sum::<f64>() / operators.area(),
            yielded_asperities: validity.and_then(|validity| validity.yielded_asperity_fraction),
            in_contact: validity.map_or(1.0, |validity| validity.contact_area_fraction_by_points),
            first_frequency: frequencies.first().copied(),
            contact_circles: validity.and_then(|validity| {
                Some(ContactCircles {
                    ratio: validity.beyond_contact_formulas()?,
                    limit: LARGEST_CONTACT,
                    share: validity.pressure_share_within_formulas,
                    surface: asperities_from(&self.scene),
                    load: loads_from(&self.scene),
                })
            }),
            differentiated: self.differentiated(backbones),
            nearest: warnings::nearest(frequencies, backbones.iter().map(|backbone| backbone.mode)),
        }
    }
}

/// Whether a number is a friction coefficient.
fn is_friction(parameter: &Parameter) -> bool {
    let path = parameter.path();
    path == "mu" || path.ends_with(".mu")
}

/// Fields of a scene that its asperities follow from.
fn asperities_from(scene: &Scene) -> String {
    let surface = match &scene.interfaces.surface {
        _ if scene.interfaces.each.iter().any(|own| own.surface.is_some()) => "interfaces.each[].surface".to_owned(),
        Surface::Measured => "interfaces.surface".to_owned(),
        Surface::Finish(_) => "interfaces.surface.finish (ra and rsm)".to_owned(),
        surface => format!("interfaces.surface.{}", choice_name(surface)),
    };
    match scene.interfaces.scale == Scale::default() {
        true => surface,
        false => format!("{surface} with interfaces.scale"),
    }
}

/// The field of a scene that its bolt loads follow from.
fn loads_from(scene: &Scene) -> &'static str {
    let bolts = &scene.bolts;
    match (&bolts.torque, bolts.torques.as_slice(), bolts.loads.as_slice()) {
        (Some(_), ..) => "bolts.torque",
        (None, [_, ..], _) => "bolts.torques",
        (None, [], [_, ..]) => "bolts.loads",
        (None, [], []) => "bolts.load",
    }
}
