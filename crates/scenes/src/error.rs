//! Errors of this crate.

/// Why a scene cannot be read, or asks for what cannot be.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, is not a regular file, or is too large.
    #[error(transparent)]
    InputFile(#[from] file_io::input::Error),
    /// A scene is not valid JSON, misses a mandatory block or has an unknown field.
    #[error("{place}: {message}")]
    Syntax {
        /// File name of the scene.
        place: String,
        /// Field with its path, where it is one that is wrong.
        field: Option<String>,
        /// Message with line and column, naming the field.
        message: String,
    },
    /// A value of a scene is outside its range.
    #[error("{place}: {field} = {} is not admissible; it must be {requirement}", quantity(*value, unit))]
    Value {
        /// File name of the scene.
        place: String,
        /// Field with its path.
        field: &'static str,
        /// Value as given.
        value: f64,
        /// Unit.
        unit: &'static str,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// A path that is asked for as a parameter is no number of the scene that can be varied.
    #[error("{path} is not a parameter of this scene: {reason}")]
    Parameter {
        /// The path.
        path: String,
        /// Why, and what can be done.
        reason: String,
    },
    /// Uncertain inputs that cannot be sampled.
    #[error("uncertain.{field}: {reason}")]
    Uncertain {
        /// Field within `uncertain`.
        field: String,
        /// Why, and what can be done.
        reason: String,
    },
    /// Bodies or asperities of a material that nothing says anything about.
    #[error(
        "model.material is missing, and bodies or asperities are made of it; add for example \"model\": {{ \"material\": {{ \
         \"youngs_modulus\": \"200 GPa\", \"poisson_ratio\": 0.3, \"density\": \"7850 kg/m^3\" }} }}"
    )]
    NoMaterial,
    /// The scene is as fine as the finest measured settings.
    #[error(
        "no measured set of settings is finer than the scene's, so that its error cannot be estimated; choose a coarser mesh, fewer \
         modes or fewer vertices"
    )]
    NothingFiner,
    /// A formulation that the hexahedra of an order do not have.
    #[error(
        "{place}: model.formulation = {formulation} is none of hexahedra with model.element_order = {order}; choose one of {offered}, \
         leave it out, or give the other model.element_order"
    )]
    NoSuchFormulation {
        /// File name of the scene.
        place: String,
        /// Order of the elements.
        order: String,
        /// Formulation asked for.
        formulation: String,
        /// Formulations on offer.
        offered: String,
    },
    /// Points of contact whose law would follow from faces.
    #[error(
        "{place}: points of contact have no faces whose asperities could be known; give the parameters of their law as \
         interfaces.surface.parameters"
    )]
    PointsWithoutParameters {
        /// Scene.
        place: String,
    },
    /// Half of a scene that need not be symmetric.
    #[error(
        "{place}: {what} need not be symmetric about y = 0, so that the half cannot stand for the whole; leave out \
         model.symmetry = half, or take the block mesh with flat faces and one law everywhere"
    )]
    Symmetry {
        /// File name of the scene.
        place: String,
        /// What need not be symmetric.
        what: &'static str,
    },
    /// A measured surface is asked for where none is known.
    #[error(
        "{place}: {field} asks for a measured surface, and the structure has none; name the benchmark whose surface is meant, \
         {{ \"benchmark\": NAME }}, or describe the faces by scans or parameters"
    )]
    NoMeasuredSurface {
        /// File name of the scene.
        place: String,
        /// Field of the scene.
        field: &'static str,
    },
    /// Roughness parameters that describe no face, or a pair of faces of which no patch can be made.
    #[error("{place}: {field}: {source}")]
    Finish {
        /// File name of the scene.
        place: String,
        /// Face, or the pair.
        field: String,
        /// What is wrong with it.
        source: Box<surface_characterisation::finish::FinishError>,
    },
    /// Bolts of a sequence that are not those of the structure.
    #[error("analyses.tightening.order {reason}; the structure has {bolts} bolts, so write for example \"order\": {}", in_turn(*bolts))]
    TighteningOrder {
        /// What is wrong.
        reason: String,
        /// Bolts there are.
        bolts: usize,
    },
    /// An analysis that the scene does not ask for.
    #[error("the scene does not ask for `{name}`; name some of {asked}, or add `{name}` to its block `analyses`")]
    NotAsked {
        /// Its name.
        name: String,
        /// Those that it asks for.
        asked: String,
    },
    /// A size of bolts that is not in the table.
    #[error("`{name}` is no size of metric bolts: {reason}")]
    BoltSize {
        /// What was given.
        name: String,
        /// What would be accepted.
        reason: String,
    },
}

impl Error {
    /// The field of the scene that is wrong, with its path, where it is one.
    pub fn field(&self) -> Option<&str> {
        match self {
            Self::Syntax { field, .. } => field.as_deref(),
            Self::Parameter { path, .. } => Some(path),
            Self::Uncertain { field, .. } => Some(field),
            Self::Value { field, .. } | Self::NoMeasuredSurface { field, .. } => Some(field),
            Self::NoSuchFormulation { .. } => Some("model.formulation"),
            Self::Symmetry { .. } => Some("model.symmetry"),
            Self::PointsWithoutParameters { .. } => Some("interfaces.surface.parameters"),
            Self::TighteningOrder { .. } => Some("analyses.tightening.order"),
            Self::NotAsked { .. } => Some("analyses"),
            Self::NoMaterial => Some("model.material"),
            Self::Finish { field, .. } => Some(field),
            _ => None,
        }
    }

    /// The value that is not admissible, with its unit, where it is a number.
    pub fn value(&self) -> Option<(f64, &'static str)> {
        match *self {
            Self::Value { value, unit, .. } => Some((value, unit)),
            _ => None,
        }
    }

    /// What can be done about it, where the message says so: what would be accepted, or the part behind the semicolon.
    pub fn remedy(&self) -> Option<String> {
        match self {
            Self::Value { requirement, .. } => Some(format!("it must be {requirement}")),
            _ => behind_semicolon(&self.to_string()),
        }
    }
}

/// The part of a message that says what can be done.
pub fn behind_semicolon(message: &str) -> Option<String> {
    message.split_once("; ").map(|(_, remedy)| remedy.to_owned())
}

/// The numbers of all bolts.
fn in_turn(bolts: usize) -> String {
    format!("{:?}", (1..=bolts).collect::<Vec<_>>())
}

/// A value with its unit, if it has one, in a few digits.
pub fn quantity(value: f64, unit: &str) -> String {
    let number = match value.abs() {
        size if size >= 1e12 && size.is_finite() => format!("{value:e}"),
        _ => value.to_string(),
    };
    format!("{number} {unit}").trim_end().to_owned()
}
