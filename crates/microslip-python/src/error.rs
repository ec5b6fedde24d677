//! Errors of the libraries as exceptions of `microslip.errors`.

use analyses::Error as AnalysisError;
use host::with_causes;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::path::{Path, PathBuf};
use surface_characterisation::SurfaceError;

/// An exception to be raised.
#[derive(Debug)]
pub(crate) struct Exception(Box<Details>);

#[derive(Debug, Default)]
struct Details {
    /// Name of its class in `microslip.errors`.
    class: &'static str,
    message: String,
    field: Option<String>,
    value: Option<Value>,
    unit: Option<String>,
    remedy: Option<String>,
    path: Option<PathBuf>,
    history: Vec<f64>,
}

#[derive(Debug)]
enum Value {
    Number(f64),
    Text(String),
}

/// An argument that cannot be what it is meant for.
pub(crate) fn input(message: impl Into<String>) -> Exception {
    let details = Details {
        class: "InputError",
        message: message.into(),
        ..Details::default()
    };
    details.into()
}

/// Matrices that a solver cannot work on.
pub(crate) fn solver(message: impl Into<String>) -> Exception {
    let details = Details {
        class: "SolverError",
        message: message.into(),
        ..Details::default()
    };
    details.into()
}

impl Exception {
    /// With the argument that is wrong, and what would be accepted.
    pub(crate) fn of(mut self, argument: &str, remedy: &str) -> Self {
        (self.0.field, self.0.remedy) = (Some(argument.into()), Some(remedy.into()));
        self
    }

    /// What a library says of an argument.
    fn argument(error: &dyn std::error::Error) -> Self {
        let message = with_causes(error);
        let remedy = message.split_once("; ").map(|(_, remedy)| remedy.to_owned());
        let mut refusal = input(message);
        refusal.0.remedy = remedy;
        refusal
    }

    /// A number that is given for an argument, in a unit.
    fn number(mut self, value: f64, unit: &str) -> Self {
        self.0.value = Some(Value::Number(value));
        self.0.unit = (!unit.is_empty()).then(|| unit.into());
        self
    }

    fn file(error: &dyn std::error::Error, path: Option<&Path>) -> Self {
        // Messages are written for users of the program; here its options are arguments.
        let message = with_causes(error)
            .replace("pass --overwrite", "pass overwrite=True")
            .replace("with --overwrite", "with overwrite=True")
            .replace("with --out", "with `out`");
        let details = Details {
            class: "FileError",
            remedy: message.split_once("; ").map(|(_, remedy)| remedy.to_owned()),
            message,
            path: path.map(Path::to_owned),
            ..Details::default()
        };
        details.into()
    }
}

impl From<Details> for Exception {
    fn from(details: Details) -> Self {
        Self(Box::new(details))
    }
}

impl From<AnalysisError> for Exception {
    fn from(error: AnalysisError) -> Self {
        use AnalysisError as E;
        use joints::Error as J;
        let class = match &error {
            E::Scene(scenes::Error::InputFile(source)) => return source.into(),
            E::Store(source) | E::Joint(J::Store(source)) => return source.into(),
            E::Joint(J::File { path, .. }) | E::InputChanged { path, .. } => return Self::file(&error, Some(path)),
            E::Joint(J::MatrixFile(_) | J::ScanFile(_)) => return Self::file(&error, None),
            E::Prestress { .. } | E::Transient { .. } | E::Unbalanced { .. } | E::NothingInContact => {
                "ConvergenceError"
            }
            E::Joint(J::Reduction(_)) | E::Solver(_) | E::Periodic(_) => "SolverError",
            _ => "SceneError",
        };
        let value = error.value();
        let details = Details {
            class,
            message: with_causes(&error),
            field: error.field().map(str::to_owned),
            value: value.map(|(value, _)| Value::Number(value)),
            unit: value.and_then(|(_, unit)| (!unit.is_empty()).then(|| unit.to_owned())),
            remedy: error.remedy(),
            path: None,
            history: match error {
                E::Prestress { history, .. } | E::Transient { history, .. } => history,
                _ => Vec::new(),
            },
        };
        details.into()
    }
}

impl From<joints::Error> for Exception {
    fn from(error: joints::Error) -> Self {
        AnalysisError::from(error).into()
    }
}

impl From<scenes::Error> for Exception {
    fn from(error: scenes::Error) -> Self {
        AnalysisError::from(error).into()
    }
}

impl From<&file_io::input::Error> for Exception {
    fn from(error: &file_io::input::Error) -> Self {
        Self::file(error, Some(error.path()))
    }
}

impl From<&file_io::durable::Error> for Exception {
    fn from(error: &file_io::durable::Error) -> Self {
        Self::file(error, Some(error.path()))
    }
}

impl From<file_io::durable::Error> for Exception {
    fn from(error: file_io::durable::Error) -> Self {
        Self::from(&error)
    }
}

impl From<matrix_files::Error> for Exception {
    fn from(error: matrix_files::Error) -> Self {
        use matrix_files::Error as E;
        match &error {
            E::File(source) => source.into(),
            E::Shape { .. } | E::Unwritable { .. } => Self::argument(&error),
            _ => Self::file(&error, None),
        }
    }
}

impl From<surface_characterisation::FileError> for Exception {
    fn from(error: surface_characterisation::FileError) -> Self {
        match error {
            surface_characterisation::FileError::Layout(source) => source.into(),
            _ => Self::file(&error, None),
        }
    }
}

impl From<SurfaceError> for Exception {
    fn from(error: SurfaceError) -> Self {
        match &error {
            SurfaceError::InvalidValue {
                field,
                value,
                unit,
                requirement,
            } => input(error.to_string())
                .of(field, &format!("it must be {requirement}"))
                .number(*value, if *unit == "1" { "" } else { unit }),
            _ => Self::argument(&error),
        }
    }
}

impl From<modal_identification::Error> for Exception {
    fn from(error: modal_identification::Error) -> Self {
        use modal_identification::Error as E;
        match error {
            E::File(source) => source.into(),
            E::NoChannels { .. } => Self::file(&error, None),
            E::Setting(setting) => {
                let remedy = format!("it must be {}", setting.allowed);
                let unit = if setting.unit == "(1)" { "" } else { setting.unit };
                // Arguments are called as settings are, but for this one.
                let name = setting.name.strip_suffix(" window").unwrap_or(setting.name);
                let (field, value) = (name.replace(' ', "_"), setting.value);
                input(E::Setting(setting).to_string())
                    .of(&field, &remedy)
                    .number(value, unit)
            }
            _ => Self::argument(&error),
        }
    }
}

impl From<finite_elements::Error> for Exception {
    fn from(error: finite_elements::Error) -> Self {
        use finite_elements::Error as E;
        match &error {
            E::InputFile(source) => source.into(),
            E::MeshUnwritable { .. } | E::Dangling { .. } | E::NotFinite { .. } => Self::argument(&error),
            _ => Self::file(&error, None),
        }
    }
}

impl From<zte_assembly::Error> for Exception {
    fn from(error: zte_assembly::Error) -> Self {
        Self::argument(&error)
    }
}

impl From<host::Error> for Exception {
    fn from(error: host::Error) -> Self {
        use host::Error as E;
        let message = with_causes(&error);
        match error {
            E::Scene(source) => source.into(),
            E::NoBenchmark { name, known } | E::NoScene { name, known, .. } => {
                let details = Details {
                    class: "SceneError",
                    message,
                    field: Some("structure.benchmark".into()),
                    value: Some(Value::Text(name)),
                    remedy: Some(format!("it must be one of {known}")),
                    ..Details::default()
                };
                details.into()
            }
            E::Date { text, .. } => {
                let mut refusal =
                    input(message).of("SOURCE_DATE_EPOCH", "it must be whole seconds since 1970, or unset");
                refusal.0.value = Some(Value::Text(text));
                refusal
            }
            _ => Self::file(&error, None),
        }
    }
}

impl From<reports::Error> for Exception {
    fn from(error: reports::Error) -> Self {
        Self::file(&error, None)
    }
}

impl From<serde_json::Error> for Exception {
    fn from(error: serde_json::Error) -> Self {
        input(error.to_string())
    }
}

impl From<Exception> for PyErr {
    fn from(exception: Exception) -> Self {
        Python::attach(|py| exception.0.raised(py).map_or_else(|error| error, PyErr::from_value))
    }
}

impl Details {
    fn raised(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let class = py.import("microslip.errors")?.getattr(self.class)?;
        let value = match self.value {
            None => None,
            Some(Value::Number(number)) => Some(number.into_bound_py_any(py)?),
            Some(Value::Text(text)) => Some(text.into_bound_py_any(py)?),
        };
        let path = self.path.map(|path| path.display().to_string());
        let attributes: Bound<'_, PyDict> = [
            ("field", self.field.into_bound_py_any(py)?),
            ("value", value.into_bound_py_any(py)?),
            ("unit", self.unit.into_bound_py_any(py)?),
            ("remedy", self.remedy.into_bound_py_any(py)?),
            ("path", path.into_bound_py_any(py)?),
            ("history", self.history.into_bound_py_any(py)?),
        ]
        .into_py_dict(py)?;
        class.call((self.message,), Some(&attributes))
    }
}
