//! What must hold of a scene before anything is computed, as far as the crates below do not check it themselves.

use crate::check::{Check, is_positive};
use crate::error::Error;
use crate::excitation::check_structure;
use crate::law::{Bins, RadialRule};
use crate::material::Material;
use crate::mesh::{MeshBolt, MeshFile};
use crate::random;
use crate::scale::Scale;
use crate::scene::Scene;
use crate::shock;
use crate::structure::{ContactPoint, Deck};
use crate::surface::{Gap, ParameterSet, Parameters, Per, Surface};
use crate::units::{Density, Length, Stress, SurfaceEnergy};
use joint_model::benchmark::{ElementOrder, Symmetry};

/// Largest slope between faces that are still taken for parallel (rad).
const STEEPEST: f64 = 0.1;

/// What scenes call it.
fn word(value: impl serde::Serialize) -> String {
    let value = serde_json::json!(value);
    value.as_str().unwrap_or_default().to_owned()
}

impl Scene {
    /// Checks what the crates below do not check themselves.
    ///
    /// # Errors
    /// [`Error::Value`], [`Error::Symmetry`], [`Error::NoMeasuredSurface`], [`Error::NoSuchFormulation`].
    pub fn validate(&self, place: &str) -> Result<(), Error> {
        let check = Check { place };
        self.validate_each(place)?;
        let interfaces = &self.interfaces;
        check.not_negative("interfaces.mu", interfaces.mu, "")?;
        for zone in &interfaces.friction_zones {
            check.not_negative("interfaces.friction_zones[].mu", zone.mu, "")?;
            for (field, range) in [
                ("interfaces.friction_zones[].x", zone.x),
                ("interfaces.friction_zones[].y", zone.y),
            ] {
                let [from, to] = range.map(Length::si);
                check.that(from.is_finite(), field, from, "m", "finite")?;
                check.that(to.is_finite() && to > from, field, to, "m", "above the first number")?;
            }
        }
        self.bolts.validate_torque(&check)?;
        if let Some(tightening) = &self.analyses.tightening {
            tightening.validate(&check)?;
        }
        for load in &self.bolts.loads {
            check.positive("bolts.loads", load.si(), "N")?;
        }
        let load = self.bolts.load.si();
        // Matrices may be in contact by preload alone; what else they may have is not known here.
        match (self.structure.matrices().is_some(), interfaces.surface.is_preloaded()) {
            (true, true) => check.not_negative("bolts.load", load, "N")?,
            (true, false) => check.that(
                is_positive(load),
                "bolts.load",
                load,
                "N",
                "positive and finite, or a set of interfaces.surface.parameters must have a preload: nothing would be in contact",
            )?,
            (false, _) => check.positive("bolts.load", load, "N")?,
        }
        let damping = self.background_damping;
        check.that(
            (0.0..1.0).contains(&damping),
            "background_damping",
            damping,
            "",
            "at least 0 and below 1",
        )?;
        self.validate_model(&check)?;
        self.validate_law(&check)?;
        self.validate_surface(&check)?;
        self.validate_scale(&check)?;
        self.analyses.modes.validate(&check)?;
        self.analyses.backbone.validate(&check)?;
        self.encoded()?;
        self.validate_requests(&check)?;
        self.validate_sensitivities()?;
        let Some(uncertain) = &self.uncertain else {
            return Ok(());
        };
        let known = Scene {
            uncertain: None,
            ..self.clone()
        };
        uncertain.validate(&known)
    }

    /// Interfaces with something of their own, which are like scenes of their own.
    fn validate_each(&self, place: &str) -> Result<(), Error> {
        let each = self.interfaces.each.len();
        let meshed = self.structure.mesh().map_or(0, |mesh| mesh.interfaces.len());
        Check { place }.that(
            each == 0 || each == meshed,
            "interfaces.each",
            each as f64,
            "(number)",
            "a list with one object for each of structure.mesh.interfaces, {} where one has nothing of its own",
        )?;
        (0..each).try_for_each(|number| {
            let mut own = self.of_interface(number);
            // Their paths lead into the whole scene.
            own.analyses.sensitivities.clear();
            own.uncertain = None;
            own.validate(&format!("{place}: interfaces.each, number {}", number + 1))
        })
    }

    fn validate_scale(&self, check: &Check<'_>) -> Result<(), Error> {
        let Scale {
            asperity_radius,
            asperity_density,
            asperity_height,
            gap,
            gap_tilt,
            gap_crown,
        } = self.interfaces.scale;
        check.positive("interfaces.scale.asperity_radius", asperity_radius, "")?;
        check.positive("interfaces.scale.asperity_density", asperity_density, "")?;
        check.positive("interfaces.scale.asperity_height", asperity_height, "")?;
        check.not_negative("interfaces.scale.gap", gap, "")?;
        for slope in gap_tilt {
            check.that(
                slope.abs() <= STEEPEST,
                "interfaces.scale.gap_tilt",
                slope,
                "rad",
                "at most 0.1 in size: faces are nearly parallel",
            )?;
        }
        for rise in gap_crown {
            check.that(
                rise.si().is_finite(),
                "interfaces.scale.gap_crown",
                rise.si(),
                "m",
                "finite",
            )?;
        }
        let is_given = matches!(self.interfaces.surface, Surface::Parameters(_));
        check.that(
            !is_given || self.interfaces.scale.is_one(),
            "interfaces.scale",
            1.0,
            "(given)",
            "left out where interfaces.surface.parameters has the numbers themselves",
        )
    }

    /// What can only be asked of a scene that is right otherwise.
    fn validate_sensitivities(&self) -> Result<(), Error> {
        for (number, parameter) in self.analyses.sensitivities.iter().enumerate() {
            parameter.value(self)?;
            let refused = |reason: &str| Error::Parameter {
                path: parameter.path().into(),
                reason: reason.into(),
            };
            if parameter.is_drawn() {
                return Err(refused(
                    "results do not change smoothly with what peaks are found in; take interfaces.scale.asperity_radius, \
                     interfaces.scale.asperity_density and interfaces.scale.asperity_height",
                ));
            }
            if self.analyses.sensitivities[..number].contains(parameter) {
                return Err(refused("analyses.sensitivities names it twice; leave one out"));
            }
        }
        Ok(())
    }

    fn validate_model(&self, check: &Check<'_>) -> Result<(), Error> {
        let model = &self.model;
        if self.needs_material() {
            model.material()?;
        }
        if let Some(material) = &model.material {
            self.validate_material(material, check)?;
        }
        check.that(
            (1..=200).contains(&model.n_modes()),
            "model.modes",
            model.n_modes() as f64,
            "",
            "between 1 and 200",
        )?;
        let target = model.reduction_error.unwrap_or(1e-4);
        check.that(
            (1e-9..1.0).contains(&target),
            "model.reduction_error",
            target,
            "",
            "at least 1e-9 (the accuracy of the check) and below 1",
        )?;
        let tolerance = model.coupling_tolerance.unwrap_or(0.0);
        check.that(
            (0.0..=1e-6).contains(&tolerance),
            "model.coupling_tolerance",
            tolerance,
            "",
            "between 0 (dense matrices, nothing is left out) and 1e-6",
        )?;
        if let Some(deck) = self.structure.deck() {
            deck.validate(check)?;
        }
        if let Some(mesh) = self.structure.mesh() {
            mesh.validate(check)?;
        }
        if let Some(points) = self.structure.matrices().and_then(|matrices| matrices.points.as_ref()) {
            self.validate_points(points, check.place)?;
        }
        for point in &self.structure.point_masses {
            check.positive("structure.point_masses[].mass", point.mass.si(), "kg")?;
            let within = point.within.map_or(0.0, Length::si);
            check.not_negative("structure.point_masses[].within", within, "m")?;
        }
        let order = self.element_order();
        // Linear elements of a deck that do not have the formulation keep theirs.
        let is_uniform = self.structure.benchmark().is_some() || order == ElementOrder::Quadratic;
        if is_uniform && !order.formulations().any(|known| known == self.hexahedra()) {
            let offered: Vec<String> = order.formulations().map(word).collect();
            return Err(Error::NoSuchFormulation {
                place: check.place.into(),
                order: word(order),
                formulation: word(self.hexahedra()),
                offered: offered.join(", "),
            });
        }
        if model.symmetry == Symmetry::Half {
            self.validate_half(check.place)?;
        }
        Ok(())
    }

    fn validate_material(&self, material: &Material, check: &Check<'_>) -> Result<(), Error> {
        check.positive("model.material.youngs_modulus", material.youngs_modulus.si(), "Pa")?;
        let ratio = material.poisson_ratio;
        check.that(
            ratio > -1.0 && ratio < 0.5,
            "model.material.poisson_ratio",
            ratio,
            "",
            "above -1 and below 0.5",
        )?;
        if let Some(hardness) = material.hardness.map(Stress::si) {
            check.positive("model.material.hardness", hardness, "Pa")?;
        }
        if let Some(work) = material.work_of_adhesion.map(SurfaceEnergy::si) {
            check.not_negative("model.material.work_of_adhesion", work, "J/m^2")?;
        }
        if self.is_meshed_of_material() {
            let density = material.density.map_or(f64::NAN, Density::si);
            check.positive("model.material.density", density, "kg/m^3")?;
        }
        Ok(())
    }

    /// Points of contact have no faces that could be scanned.
    fn validate_points(&self, points: &[ContactPoint], place: &str) -> Result<(), Error> {
        for (number, point) in (1..).zip(points) {
            let at = format!("{place}: structure.matrices.points, number {number}");
            let check = Check { place: &at };
            check.positive("area", point.area.si(), "m^2")?;
            for x in point.position.map(Length::si) {
                check.that(x.is_finite(), "position", x, "m", "finite")?;
            }
        }
        match self.interfaces.surface {
            Surface::Parameters(_) => Ok(()),
            _ => Err(Error::PointsWithoutParameters { place: place.into() }),
        }
    }

    fn validate_law(&self, check: &Check<'_>) -> Result<(), Error> {
        let law = &self.interfaces.law;
        if let Some(yielding) = law.yielding {
            let (strength, modulus) = (yielding.strength.si(), yielding.tangent_modulus.si());
            check.positive("interfaces.law.yield.strength", strength, "Pa")?;
            check.that(
                modulus >= 0.0 && self.model.material.is_none_or(|of| modulus < of.youngs_modulus.si()),
                "interfaces.law.yield.tangent_modulus",
                modulus,
                "Pa",
                "at least 0 and below model.material.youngs_modulus",
            )?;
        }
        match law.bins {
            Bins::Error(error) => check.that(
                (1e-8..1.0).contains(&error),
                "interfaces.law.bins.error",
                error,
                "",
                "at least 1e-8 and below 1",
            )?,
            Bins::Gauss(n) => check.that(
                n.is_multiple_of(2) && (2..=128).contains(&n),
                "interfaces.law.bins.gauss",
                n as f64,
                "",
                "an even number from 2 to 128",
            )?,
            Bins::EquallySpaced(n) => check.that(
                (2..=1024).contains(&n),
                "interfaces.law.bins.equally-spaced",
                n as f64,
                "",
                "from 2 to 1024",
            )?,
        }
        let (RadialRule::Annuli(n) | RadialRule::EquallySpaced(n)) = law.radii;
        check.that(
            (2..=256).contains(&n),
            "interfaces.law.radii",
            n as f64,
            "",
            "from 2 to 256",
        )
    }

    /// Half of a scene stands for the whole only where all of it is symmetric.
    fn validate_half(&self, place: &str) -> Result<(), Error> {
        let of_parts = match &self.interfaces.surface {
            Surface::Measured | Surface::Benchmark(_) => false,
            Surface::SyntheticScan(_) | Surface::Scans(_) => true,
            Surface::Finish(finish) => finish.is_random(),
            Surface::Parameters(parameters) => parameters.per != Per::Interface,
        };
        let asymmetric = [
            (self.structure.deck().is_some(), "a deck"),
            (self.structure.mesh().is_some(), "a mesh"),
            (self.structure.matrices().is_some(), "a structure of matrices"),
            (!self.structure.point_masses.is_empty(), "structure.point_masses"),
            (of_parts, "the surface"),
            (self.interfaces.gap != Gap::Flat, "the gap"),
            (!self.interfaces.friction_zones.is_empty(), "interfaces.friction_zones"),
        ];
        match asymmetric.into_iter().find(|(found, _)| *found) {
            Some((_, what)) => Err(Error::Symmetry {
                place: place.into(),
                what,
            }),
            None => Ok(()),
        }
    }

    fn validate_surface(&self, check: &Check<'_>) -> Result<(), Error> {
        match &self.interfaces.surface {
            Surface::Parameters(parameters) => parameters.validate(check.place)?,
            Surface::Scans(scans) => {
                for (field, value, unit, requirement, ok) in scans.requirements() {
                    check.that(ok, field, value, unit, requirement)?;
                }
            }
            Surface::Finish(finish) => {
                for (field, value, unit, requirement, ok) in finish.requirements() {
                    check.that(ok, field, value, unit, requirement)?;
                }
                finish.faces(check.place)?;
                check.that(
                    finish.flatness.is_none() || self.interfaces.gap == Gap::Flat,
                    "interfaces.surface.finish.flatness",
                    finish.flatness.map_or(f64::NAN, Length::si),
                    "m",
                    "left out where `interfaces.gap` says what the gap is",
                )?;
            }
            Surface::Measured | Surface::Benchmark(_) if self.measured_surface().is_none() => {
                return Err(Error::NoMeasuredSurface {
                    place: check.place.into(),
                    field: "interfaces.surface",
                });
            }
            Surface::Measured | Surface::Benchmark(_) | Surface::SyntheticScan(_) => {}
        }
        if matches!(self.interfaces.gap, Gap::Measured | Gap::Benchmark(_)) && self.measured_gap().is_none() {
            return Err(Error::NoMeasuredSurface {
                place: check.place.into(),
                field: "interfaces.gap",
            });
        }
        check.that(
            self.interfaces.surface.is_scanned() || self.interfaces.gap != Gap::Scan,
            "interfaces.gap",
            f64::NAN,
            "(scan)",
            "`flat` or `measured` unless the surface is scanned",
        )
    }

    /// What is computed besides, and stored.
    fn validate_requests(&self, check: &Check<'_>) -> Result<(), Error> {
        for (index, method) in self.analyses.backbone.methods.iter().enumerate() {
            check.that(
                !self.analyses.backbone.methods[..index].contains(method),
                "analyses.backbone.methods",
                (index + 1) as f64,
                "(number in the list)",
                "different from the methods before it",
            )?;
        }
        if let Some(epmc) = &self.analyses.epmc {
            epmc.validate(check)?;
        }
        if let Some(ring_down) = &self.analyses.ring_down {
            ring_down.validate(check)?;
        }
        let source = [
            self.structure.benchmark().is_some(),
            self.structure.matrices().is_some(),
        ];
        if let Some(asked) = &self.analyses.forced {
            asked.validate(check, source[1])?;
            for (excitation, _) in asked.excitations() {
                check_structure(check, asked.point_fields(), &excitation, source)?;
            }
        }
        if let Some(asked) = &self.analyses.random {
            asked.validate(check, self.analyses.backbone.amplitudes, source[1])?;
            check_structure(check, &random::FIELDS.point, &asked.excitation(), source)?;
        }
        if let Some(asked) = &self.analyses.shock {
            asked.validate(check, source[1])?;
            check_structure(check, &shock::FIELDS.point, &asked.excitation(), source)?;
        }
        for number in self.fields_at() {
            check.that(
                (1..=self.analyses.backbone.amplitudes).contains(&number),
                "output.fields_at",
                number as f64,
                "",
                "numbers of amplitudes, between 1 and analyses.backbone.amplitudes",
            )?;
        }
        Ok(())
    }
}

impl Deck {
    fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        let tolerance = self.tie_tolerance.map_or(0.0, Length::si);
        check.not_negative("structure.deck.tie_tolerance", tolerance, "m")?;
        let tolerance = self.pair_tolerance.map_or(0.0, Length::si);
        check.not_negative("structure.deck.pair_tolerance", tolerance, "m")?;
        let size = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        check.positive("structure.deck.along", size(&self.along), "(length of the vector)")?;
        let direction = size(&self.response.direction);
        check.that(
            (direction - 1.0).abs() < 1e-6,
            "structure.deck.response.direction",
            direction,
            "(length of the vector)",
            "a unit vector",
        )?;
        check.that(
            !self.bolts.is_empty(),
            "structure.deck.bolts",
            0.0,
            "(number of bolts)",
            "at least one",
        )
    }
}

/// Coordinates beyond this are no place on a structure, and their squares may overflow (m).
const FARTHEST: f64 = 1e9;

/// Bolts of a pattern: ten times as many as any structure here is known to have.
const MOST_REPEATED: usize = 10_000;

impl MeshBolt {
    fn validate_pattern(&self, place: &str) -> Result<(), Error> {
        let refuse = |message: &str| {
            Err(Error::Syntax {
                place: place.into(),
                field: Some("structure.mesh.bolts".into()),
                message: format!("repeat: {message}"),
            })
        };
        if self.axis.is_none() && !self.repeat.is_empty() {
            return refuse("a bolt between two surfaces has no place to be moved from; give it an `axis` and a `size`");
        }
        let check = Check { place };
        let mut count = 1_usize;
        for repeat in &self.repeat {
            count = count.saturating_mul(repeat.times);
            check.that(
                (1..=MOST_REPEATED).contains(&count),
                "repeat.times",
                count as f64,
                "(bolts of the pattern)",
                "from 1 to 10 000 in all",
            )?;
            let finite = |at: &[Length; 3]| at.iter().all(|x| x.si().abs() < FARTHEST);
            let far = "positions and steps must be less than 1e9 m in size";
            match (&repeat.step, &repeat.about, repeat.angle_deg) {
                (Some(step), None, None) if !finite(step) => return refuse(far),
                (None, Some(points), _) if !points.iter().all(finite) => return refuse(far),
                (None, Some([from, to]), _) if from == to => {
                    return refuse("`about` has the same point twice; give two points on the axis");
                }
                (None, Some(_), angle) => check.that(
                    angle.is_none_or(f64::is_finite),
                    "repeat.angle_deg",
                    angle.unwrap_or_default(),
                    "degrees",
                    "finite",
                )?,
                (Some(_), None, None) => {}
                _ => return refuse("give either `step`, or `about` with or without `angle_deg`"),
            }
        }
        Ok(())
    }
}

impl MeshFile {
    fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        let size = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        if let Some(direction) = &self.response.direction {
            let length = size(direction);
            check.that(
                (length - 1.0).abs() < 1e-6,
                "structure.mesh.response.direction",
                length,
                "(length of the vector)",
                "a unit vector",
            )?;
        }
        if let Some(mode) = self.response.mode {
            check.that(
                (1..=50).contains(&mode),
                "structure.mesh.response.mode",
                mode as f64,
                "",
                "a number from 1 to 50",
            )?;
        }
        let count = self.interfaces.len() as f64;
        check.that(
            count > 0.0,
            "structure.mesh.interfaces",
            count,
            "(number)",
            "at least one",
        )?;
        let at = |list: &str, number: usize| format!("{}: structure.mesh.{list}, number {number}", check.place);
        for (number, interface) in (1..).zip(&self.interfaces) {
            let place = at("interfaces", number);
            let check = Check { place: &place };
            check.positive("along", size(&interface.along), "(length of the vector)")?;
            if let Some(within) = interface.within {
                check.positive("within", within.si(), "m")?;
            }
        }
        for (number, bolt) in (1..).zip(&self.bolts) {
            let place = at("bolts", number);
            bolt.validate_pattern(&place)?;
        }
        for (number, tie) in (1..).zip(&self.ties) {
            let place = at("ties", number);
            let within = tie.within.map_or(0.0, Length::si);
            Check { place: &place }.not_negative("within", within, "m")?;
        }
        for (number, support) in (1..).zip(&self.supports) {
            let place = at("supports", number);
            let check = Check { place: &place };
            if let Some(stiffness) = support.stiffness {
                check.positive("stiffness", stiffness.si(), "Pa/m")?;
            }
            for x in support.face.iter().flatten().map(|x| x.si()) {
                check.that(x.abs() < FARTHEST, "face", x, "m", "less than 1e9 m in size")?;
            }
            check.that(
                support.components.contains(&true),
                "components",
                0.0,
                "(number of components held)",
                "at least one; remove the support if it holds nothing",
            )?;
        }
        if let Some(nearest) = self.response.nearest {
            for x in nearest.map(Length::si) {
                let field = "structure.mesh.response.nearest";
                check.that(x.abs() < FARTHEST, field, x, "m", "less than 1e9 m in size")?;
            }
        }
        for (name, material) in &self.materials {
            let place = format!("{}: structure.mesh.materials.{name}", check.place);
            let check = Check { place: &place };
            let Some(density) = material.density else {
                return Err(Error::Syntax {
                    place,
                    field: Some(format!("structure.mesh.materials.{name}.density")),
                    message: "missing field `density`; give it, such as \"density\": \"7800 kg/m^3\"".into(),
                });
            };
            check.positive("density", density.si(), "kg/m^3")?;
            check.positive("youngs_modulus", material.youngs_modulus.si(), "Pa")?;
            check.that(
                material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5,
                "poisson_ratio",
                material.poisson_ratio,
                "",
                "above -1 and below 0.5",
            )?;
        }
        Ok(())
    }
}

impl Parameters {
    fn validate(&self, place: &str) -> Result<(), Error> {
        for (number, set) in (1..).zip(&self.sets) {
            let ParameterSet { mu, gap, preload, .. } = set;
            let at = format!("{place}: interfaces.surface.parameters.sets, number {number}");
            let check = Check { place: &at };
            check.not_negative("mu", mu.unwrap_or(0.0), "")?;
            check.not_negative("gap", gap.si(), "m")?;
            check.not_negative("preload", preload.si(), "Pa")?;
            check.that(
                gap.si() == 0.0 || preload.si() == 0.0,
                "preload",
                preload.si(),
                "Pa",
                "left out where the set has a gap",
            )?;
        }
        Ok(())
    }
}
