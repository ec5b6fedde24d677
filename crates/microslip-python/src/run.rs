//! Runs of scenes.

use crate::error::Exception;
use crate::scene::Scene;
use crate::work::{Monitor, pool, supervise, within};
use analyses::Fields;
use analyses::Run as LibraryRun;
use analyses::results::summary::Summary;
use contact_laws::Regime;
use file_io::durable::Folder;
use host::{GivenScene, free_memory, peak_memory, provenance, results_of, user_cache};
use joints::Options;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use reports::names::SUMMARY;
use reports::run::outputs;
use std::path::{Path, PathBuf};

/// Files that every run writes.
const FILES: [&str; 3] = [SUMMARY, "report.html", "backbone.csv"];

/// A finished run.
#[pyclass(frozen, module = "microslip._native")]
pub(crate) struct Run {
    run: LibraryRun,
    summary: Summary,
}

/// Numbers in rows of `N`.
type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// Geometry: positions of nodes in the plane and in the model, nodes of elements padded by -1, positions of points in the plane and in
/// the model, their areas, their elements, their gaps, the frame, and the frames of the nodes.
type Geometry<'py> = (
    Rows<'py>,
    Option<Rows<'py>>,
    Bound<'py, PyArray2<i64>>,
    Rows<'py>,
    Option<Rows<'py>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
    Option<Bound<'py, PyArray1<f64>>>,
    Rows<'py>,
    Option<Bound<'py, PyArray3<f64>>>,
);

/// At the points: jump, traction, regime and flux.
type PointFields<'py> = (Rows<'py>, Rows<'py>, Bound<'py, PyArray1<u8>>, Rows<'py>);

#[pymethods]
impl Run {
    /// The summary as JSON.
    fn summary(&self) -> Result<String, Exception> {
        Ok(serde_json::to_string(&self.summary)?)
    }

    /// The interface: nodes in its plane and in the model, nodes of elements, points in its plane and in the model, their areas, elements
    /// and gaps, the frame and the frames of the nodes.
    #[pyo3(signature = () -> "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None]")]
    fn geometry<'py>(&self, py: Python<'py>) -> PyResult<Geometry<'py>> {
        let (run, operators) = (&self.run, self.run.interface.operators());
        let longest = run
            .joint
            .mesh
            .elements
            .iter()
            .map(|e| e.nodes().len())
            .max()
            .unwrap_or(0);
        let mut elements = Vec::with_capacity(longest * run.joint.mesh.elements.len());
        for element in &run.joint.mesh.elements {
            let nodes = element.nodes().iter().map(|node| i64::from(*node));
            elements.extend(nodes.chain(std::iter::repeat(-1)).take(longest));
        }
        let mut of_point = Vec::with_capacity(operators.n_points());
        for element in 0..operators.n_elements() {
            let points = operators.first_point[element]..operators.first_point[element + 1];
            of_point.extend(points.map(|_| element as i64));
        }
        let frames = run.joint.node_frames.as_flattened().as_flattened();
        Ok((
            rows(py, &run.joint.mesh.nodes)?,
            run.joint.positions.as_deref().map(|all| rows(py, all)).transpose()?,
            PyArray1::from_vec(py, elements).reshape([run.joint.mesh.elements.len(), longest])?,
            rows(py, &operators.positions)?,
            reports::fields::point_positions(run)
                .map(|all| rows(py, &all))
                .transpose()?,
            PyArray1::from_slice(py, &operators.weights),
            PyArray1::from_vec(py, of_point),
            run.interface.gap().map(|gap| PyArray1::from_slice(py, gap)),
            rows(py, &run.joint.frame)?,
            match frames {
                [] => None,
                _ => Some(PyArray1::from_slice(py, frames).reshape([run.joint.node_frames.len(), 3, 3])?),
            },
        ))
    }

    /// Fields of the static state: jump, traction, regime, flux.
    #[pyo3(signature = () -> "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.float64]]")]
    fn prestress<'py>(&self, py: Python<'py>) -> PyResult<PointFields<'py>> {
        of_points(py, &self.run.prestress.fields)
    }

    /// Per mode followed, the amplitudes of which fields were stored: their numbers from 1, and the fields as in `prestress`.
    #[pyo3(signature = () -> "list[list[tuple[int, tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.float64]]]]]")]
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Vec<Vec<(usize, PointFields<'py>)>>> {
        let of_mode = |mode: &analyses::ModeBackbone| {
            let stored = (1..).zip(&mode.amplitudes).filter_map(|(number, amplitude)| {
                let fields = amplitude.fields.as_ref()?.fields.as_ref()?;
                Some((number, fields))
            });
            stored
                .map(|(number, fields)| Ok((number, of_points(py, fields)?)))
                .collect()
        };
        self.run.backbones.iter().map(of_mode).collect()
    }

    /// Writes the files of the run into a folder.
    #[pyo3(signature = (directory: "str", overwrite: "bool"))]
    fn save(&self, py: Python<'_>, directory: PathBuf, overwrite: bool) -> Result<(), Exception> {
        py.detach(|| publish(open(&directory, &self.run.scene, overwrite)?, &self.run, &self.summary))
    }
}

/// Runs a scene.
///
/// `cache` is a folder, `True` for that of the user, or `False` for none.
#[pyfunction]
#[pyo3(signature = (
    scene: "Scene",
    progress: "collections.abc.Callable[[str, float], object] | None",
    threads: "int | None",
    cache: "bool | str",
    ensemble: "int | None",
    out: "str | None",
    overwrite: "bool"
) -> "Run")]
pub(crate) fn run(
    py: Python<'_>,
    scene: Py<Scene>,
    progress: Option<Py<PyAny>>,
    threads: Option<i64>,
    cache: Cache,
    ensemble: Option<i64>,
    out: Option<PathBuf>,
    overwrite: bool,
) -> PyResult<Run> {
    let range = "it must be from 1 to 10000, or None for no ensemble";
    let ensemble = within("ensemble", ensemble, 10_000, range)?;
    let given = &scene.get().0;
    let options = cache.options();
    let pool = pool(threads)?;
    // Before the computation: it would be a pity to find out only afterwards.
    let folder = match &out {
        Some(directory) => Some(open(directory, &given.scene, overwrite)?),
        None => None,
    };
    let done = supervise(py, &pool, progress.as_ref(), |monitor| {
        compute(given, &options, ensemble, folder, monitor)
    })?;
    let run = done?;
    run.run.checkpoints.remove();
    Ok(run)
}

/// Where reduced models and finished amplitudes are kept.
#[derive(FromPyObject)]
pub(crate) enum Cache {
    /// The user's, or none.
    OfUser(bool),
    /// A folder.
    Folder(PathBuf),
}

impl Cache {
    pub(crate) fn options(self) -> Options {
        Options {
            cache: match self {
                Self::OfUser(true) => user_cache(),
                Self::OfUser(false) => None,
                Self::Folder(folder) => Some(folder),
            },
            build: provenance::commit(),
            memory: free_memory(),
        }
    }
}

fn compute(
    given: &GivenScene,
    options: &Options,
    ensemble: Option<usize>,
    folder: Option<Folder>,
    monitor: &Monitor<'_>,
) -> Result<Run, Exception> {
    let provenance = provenance::of(given.inputs()?)?;
    let (run, ensemble) = match ensemble {
        None => (analyses::run(&given.scene, options, monitor)?, None),
        Some(k) => {
            let (run, ensemble) = analyses::run_ensemble(&given.scene, k, options, monitor)?;
            (run, Some(ensemble))
        }
    };
    let mut summary = Summary::new(&run, monitor.times.seconds(), peak_memory());
    summary.ensemble = ensemble;
    // What was hashed before must be what was read since.
    let here = Path::new(&provenance.working_directory);
    provenance.inputs.iter().try_for_each(|input| input.check(here))?;
    summary.provenance = Some(provenance);
    let run = run.without_matrices();
    if let Some(folder) = folder {
        publish(folder, &run, &summary)?;
    }
    Ok(Run { run, summary })
}

/// Takes hold of a folder for the results of a scene.
fn open(directory: &Path, scene: &scenes::Scene, overwrite: bool) -> Result<Folder, Exception> {
    let folder = Folder::open(directory, &results_of("run", scene), overwrite)?;
    folder.expect(FILES)?;
    Ok(folder)
}

fn publish(folder: Folder, run: &LibraryRun, summary: &Summary) -> Result<(), Exception> {
    let outputs = outputs(run, summary)?;
    let files: Vec<(&str, &[u8])> = outputs.iter().map(|o| (o.name.as_str(), &o.contents[..])).collect();
    Ok(folder.publish(&files)?)
}

/// An array of rows.
fn rows<'py, const N: usize>(py: Python<'py>, rows: &[[f64; N]]) -> PyResult<Rows<'py>> {
    PyArray1::from_slice(py, rows.as_flattened()).reshape([rows.len(), N])
}

fn of_points<'py>(py: Python<'py>, fields: &Fields) -> PyResult<PointFields<'py>> {
    let together = |[x, y, n]: &[Vec<f64>; 3]| {
        let values: Vec<f64> = x.iter().zip(y).zip(n).flat_map(|((x, y), n)| [*x, *y, *n]).collect();
        PyArray1::from_vec(py, values).reshape([x.len(), 3])
    };
    let regime = fields.regime.iter().map(|regime| match regime {
        Regime::Stick => 0,
        Regime::Slip => 1,
        Regime::Open => 2,
        Regime::Invalid => 3,
    });
    Ok((
        together(&fields.jump)?,
        together(&fields.traction)?,
        PyArray1::from_vec(py, regime.collect()),
        together(&fields.flux)?,
    ))
}
