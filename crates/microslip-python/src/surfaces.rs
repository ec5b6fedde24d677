//! Scans of faces, and what they are made of.

use crate::error::{Exception, input};
use crate::work::pool;
use contact_laws::{ElasticPair, TangentialReading};
use joints::interface::in_frame;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use scenes::Place;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use surface_characterisation::readers::{self, FirstRow, Format, LengthUnit};
use surface_characterisation::{
    AsperityCount, Bootstrap, BoundaryElements, Characterisation, Detrend, ElementOutlines, ElementSurface,
    FaceAsperities, HeightCombination, HeightMap, InterferenceRange, NoiseHandling, Options, PackingHeight, PairRadius,
    Pressed, RadiusStatistic, Registration, SyntheticFace, TallestPeak, Waviness, writers,
};
use zte_assembly::{Element, InterfaceMesh};

/// Heights, a row per line along x; steps along x and y; position of the first point; height step.
type Map<'py> = (Bound<'py, PyArray2<f64>>, [f64; 2], [f64; 2], Option<f64>);

/// The same as it comes from Python.
type GivenMap<'py> = (PyReadonlyArray2<'py, f64>, [f64; 2], [f64; 2], Option<f64>);

/// Mean gaps, parts of the area in contact and points that touch.
type Contacts<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Vec<usize>);

/// The scan in a file: the map, and as JSON what the file says about it.
#[pyfunction]
#[pyo3(signature = (
    path: "str",
    format: "str | None",
    lateral_unit: "str | None",
    height_unit: "str | None",
    lateral_step: "tuple[float, float] | None",
    first_row: "str | None",
    layer: "int | None",
    array: "str | None",
    header_lines: "int | None",
    accept_implausible: "bool"
) -> "tuple[tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None], str]")]
pub(crate) fn read_scan<'py>(
    py: Python<'py>,
    path: PathBuf,
    format: Option<&str>,
    lateral_unit: Option<&str>,
    height_unit: Option<&str>,
    lateral_step: Option<[f64; 2]>,
    first_row: Option<&str>,
    layer: Option<i64>,
    array: Option<String>,
    header_lines: Option<i64>,
    accept_implausible: bool,
) -> PyResult<(Map<'py>, String)> {
    let options = readers::Options {
        format: choice::<Format>("format", format)?,
        lateral_unit: choice::<LengthUnit>("lateral_unit", lateral_unit)?,
        height_unit: choice::<LengthUnit>("height_unit", height_unit)?,
        lateral_step,
        first_row: choice::<FirstRow>("first_row", first_row)?,
        layer: from_zero("layer", layer)?,
        array,
        header_lines: from_zero("header_lines", header_lines)?,
        accept_implausible,
    };
    let scan = py.detach(|| readers::read(&path, &options)).map_err(Exception::from)?;
    let about = json!({
        "format": scan.format,
        "lateral_unit": scan.lateral_unit.unit(),
        "height_unit": scan.height_unit.unit(),
        "smallest_step": scan.smallest_step,
        "distinct_heights": scan.distinct_heights,
        "notes": scan.notes,
    });
    let mut map = scan.map;
    if let Some(step) = scan.stated_step {
        map = map.with_height_step(step).map_err(Exception::from)?;
    }
    Ok((to_python(py, &map)?, about.to_string()))
}

/// Writes a map as X3P, or as text with a line of heights per line along x.
#[pyfunction]
#[pyo3(signature = (
    path: "str",
    map: "tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None]"
) -> "None")]
pub(crate) fn write_scan(py: Python<'_>, path: PathBuf, map: GivenMap<'_>) -> Result<(), Exception> {
    let map = from_python(&map)?;
    py.detach(|| {
        let bytes = match extension(&path).as_str() {
            "x3p" => writers::x3p(&map)?,
            "csv" => writers::csv(&map).into_bytes(),
            other => {
                let remedy = "it must end with .x3p or .csv";
                return Err(input(format!("scans are not written as `.{other}`; {remedy}")).of("path", remedy));
            }
        };
        Ok(file_io::durable::write(&path, &bytes)?)
    })
}

/// A seeded Gaussian face.
#[pyfunction]
#[pyo3(signature = (
    points: "tuple[int, int]",
    step: "tuple[float, float]",
    origin: "tuple[float, float]",
    rms: "float",
    correlation_length: "tuple[float, float]",
    waviness: "collections.abc.Sequence[tuple[float, float, float, float]]",
    tilt: "tuple[float, float]",
    height_step: "float | None",
    seed: "int"
) -> "tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None]")]
pub(crate) fn synthetic_face<'py>(
    py: Python<'py>,
    points: [i64; 2],
    step: [f64; 2],
    origin: [f64; 2],
    rms: f64,
    correlation_length: [f64; 2],
    waviness: Vec<[f64; 4]>,
    tilt: [f64; 2],
    height_step: Option<f64>,
    seed: u64,
) -> PyResult<Map<'py>> {
    const RANGE: &str = "it must have numbers of points from 3 to 100000, and 200 million in all";
    let refused = || input(format!("points = {points:?} is not admissible; {RANGE}")).of("points", RANGE);
    let mut counts = [0; 2];
    for (count, given) in counts.iter_mut().zip(points) {
        *count = usize::try_from(given)
            .ok()
            .filter(|n| (3..=100_000).contains(n))
            .ok_or_else(refused)?;
    }
    if counts[0] * counts[1] > 200_000_000 {
        return Err(refused().into());
    }
    let face = SyntheticFace {
        points: counts,
        step,
        origin,
        rms,
        correlation_length,
        waviness: waviness
            .into_iter()
            .map(|[amplitude, x, y, phase]| Waviness {
                amplitude,
                wavenumber: [x, y],
                phase,
            })
            .collect(),
        tilt,
        height_step,
        seed,
    };
    let pool = pool(None)?;
    let map = py
        .detach(|| pool.install(|| face.generate(|_| false)))
        .map_err(Exception::from)?;
    to_python(py, &map)
}

/// Contact of heights on a half-space by boundary elements, at mean pressures over the contact modulus: mean gaps (m), parts of the area in contact, points that
/// touch.
#[pyfunction]
#[pyo3(signature = (
    map: "tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None]",
    pressures: "collections.abc.Sequence[float]"
) -> "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], list[int]]")]
pub(crate) fn press<'py>(py: Python<'py>, map: GivenMap<'_>, pressures: Vec<f64>) -> PyResult<Contacts<'py>> {
    let map = from_python(&map)?;
    let found = py.detach(|| -> Result<Vec<Pressed>, Exception> {
        let (nx, ny) = (map.nx(), map.ny());
        let points = (0..nx * ny).map(|k| map.height(k % nx, k / nx).unwrap_or(f64::NAN));
        let heights: Vec<f64> = points.collect();
        let mut elements = BoundaryElements::try_new(&heights, [nx, ny], map.step())?;
        Ok(elements.curve(&pressures)?)
    })?;
    let list = |of: fn(&Pressed) -> f64| PyArray1::from_iter(py, found.iter().map(of));
    let touching = found.iter().map(|pressed| pressed.touching).collect();
    Ok((
        list(|pressed| pressed.separation),
        list(|pressed| pressed.area),
        touching,
    ))
}

/// How faces are brought together and read; all in SI.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    material: ElasticPair,
    centred: bool,
    mirror_bottom: bool,
    align: Option<f64>,
    registration: Registration,
    noise: NoiseHandling,
    detrend: Detrend,
    radius: RadiusStatistic,
    pair_radius: PairRadius,
    packing_height: PackingHeight,
    packing_efficiency: f64,
    count: AsperityCount,
    heights: HeightCombination,
    tangential: TangentialReading,
    interference: [f64; 2],
    samples: usize,
    u_ref: f64,
    bootstrap: usize,
    seed: u64,
    tallest: TallestPeak,
    pruning: f64,
    least_peaks: usize,
}

impl Settings {
    fn parse(json: &str) -> Result<Self, Exception> {
        let mut text = serde_json::Deserializer::from_str(json);
        let settings: Self = serde_path_to_error::deserialize(&mut text).map_err(|error| {
            let field = error.path().to_string();
            let reason = error.into_inner();
            let reason = reason.to_string();
            // The place in the text means nothing to who has not written it.
            let reason = reason.split(" at line ").next().unwrap_or_default();
            input(format!("{field}: {reason}")).of(&field, reason)
        })?;
        // What is allocated at once must not be a matter of a slip in an exponent.
        for (field, given, most) in [
            ("bootstrap", settings.bootstrap, 100_000),
            ("samples", settings.samples, 10_000),
        ] {
            if given > most {
                let remedy = format!("it must be at most {most}");
                return Err(input(format!("{field} = {given} is not admissible; {remedy}")).of(field, &remedy));
            }
        }
        Ok(settings)
    }

    fn options(&self) -> Options {
        Options {
            noise: self.noise,
            registration: self.registration,
            detrend: self.detrend,
            radius: self.radius,
            pair_radius: self.pair_radius,
            packing_height: self.packing_height,
            packing_efficiency: self.packing_efficiency,
            count: self.count,
            heights: self.heights,
            tangential: self.tangential,
            interference: InterferenceRange {
                from: self.interference[0],
                to: self.interference[1],
                points: self.samples,
            },
            u_ref: self.u_ref,
            bootstrap: Bootstrap {
                realisations: self.bootstrap,
                seed: self.seed,
                tallest: self.tallest,
            },
            pruning: self.pruning,
            least_peaks: self.least_peaks,
            ..Options::new(self.material)
        }
    }
}

/// Characterises two maps over the elements of a plane mesh, whose rows may end with -1.
///
/// Per element: arrays by name, those of the top and of the bottom face, heights of the peaks, fallbacks of the fits; and as JSON
/// the whole faces.
#[pyfunction]
#[pyo3(signature = (
    top: "tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None]",
    bottom: "tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None]",
    nodes: "numpy.typing.NDArray[numpy.float64]",
    elements: "numpy.typing.NDArray[numpy.int64]",
    settings: "str"
) -> "tuple[dict[str, numpy.typing.NDArray[numpy.float64]], dict[str, numpy.typing.NDArray[numpy.float64]], dict[str, numpy.typing.NDArray[numpy.float64]], list[numpy.typing.NDArray[numpy.float64]], str]")]
pub(crate) fn characterise<'py>(
    py: Python<'py>,
    top: GivenMap<'py>,
    bottom: GivenMap<'py>,
    nodes: PyReadonlyArray2<'py, f64>,
    elements: PyReadonlyArray2<'py, i64>,
    settings: &str,
) -> PyResult<Characterised<'py>> {
    let settings = Settings::parse(settings)?;
    let outlines = outlines(&nodes, &elements)?;
    let maps = [from_python(&top)?, from_python(&bottom)?];
    let work = || {
        let place = if settings.centred {
            Place::Centred
        } else {
            Place::AsStated
        };
        let [top, bottom] = maps;
        let (top, of_top) = in_frame(top, &outlines, false, place, settings.align)?;
        let (bottom, of_bottom) = in_frame(bottom, &outlines, settings.mirror_bottom, place, settings.align)?;
        let found = surface_characterisation::characterise(&top, &bottom, &outlines, &settings.options())?;
        Ok::<_, Exception>((found, [of_top, of_bottom]))
    };
    let pool = pool(None)?;
    let (found, alignments) = py.detach(|| pool.install(work))?;
    let about = json!({
        "summary": found.summary(),
        "faces": found.faces,
        "options": found.options,
        "alignments": alignments,
        "fallbacks": found
            .elements
            .iter()
            .map(|e| [e.normal.fallback, e.tangential[0].fallback, e.tangential[1].fallback])
            .collect::<Vec<_>>(),
    });
    let heights = found
        .elements
        .iter()
        .map(|e| PyArray1::from_slice(py, e.population.heights()));
    Ok((
        of_elements(py, &found, &outlines)?,
        of_face(py, &found, 0)?,
        of_face(py, &found, 1)?,
        heights.collect(),
        about.to_string(),
    ))
}

/// See [`characterise`].
type Characterised<'py> = (
    Bound<'py, PyDict>,
    Bound<'py, PyDict>,
    Bound<'py, PyDict>,
    Vec<Bound<'py, PyArray1<f64>>>,
    String,
);

fn of_elements<'py>(
    py: Python<'py>,
    found: &Characterisation,
    outlines: &ElementOutlines,
) -> PyResult<Bound<'py, PyDict>> {
    let all = &found.elements;
    let out = PyDict::new(py);
    let column = |name: &str, of: &dyn Fn(&ElementSurface) -> f64| {
        out.set_item(name, PyArray1::from_vec(py, all.iter().map(of).collect()))
    };
    column("area", &|e| outlines.area(e.element))?;
    column("gap", &|e| e.gap.at(e.gap.centre))?;
    column("total_roughness", &ElementSurface::total_roughness)?;
    column("count", &|e| e.population.count())?;
    column("density", &|e| e.population.asperity_density())?;
    column("effective_radius", &|e| e.population.effective_radius())?;
    column("contact_height", &|e| e.population.contact_height())?;
    column("normal_fit_rms", &|e| e.normal.rms)?;
    let rows = |name: &str, columns: usize, of: &dyn Fn(&ElementSurface) -> Vec<f64>| {
        let values: Vec<f64> = all.iter().flat_map(of).collect();
        out.set_item(name, PyArray1::from_vec(py, values).reshape([all.len(), columns])?)
    };
    rows("gap_range", 2, &|e| e.gap_range.into())?;
    rows("gap_centre", 2, &|e| e.gap.centre.into())?;
    rows("gap_half_width", 2, &|e| e.gap.half_width.into())?;
    rows("gap_coefficients", 4, &|e| e.gap.coefficients.into())?;
    rows("radius", 2, &|e| e.population.radius().into())?;
    rows("tangential_fit_rms", 2, &|e| e.tangential.map(|t| t.rms).into())?;
    rows("normal_fit", 5, &|e| {
        let p = &e.normal.parameters;
        vec![p.a, p.b, p.c, p.d, p.e]
    })?;
    // All curves have the samples that the options name.
    let samples = found.options.interference.points;
    rows("normal_traction", samples, &|e| e.curves.normal.clone())?;
    let interference = all.first().map(|e| e.curves.interference.clone());
    out.set_item("interference", PyArray1::from_vec(py, interference.unwrap_or_default()))?;
    let layers = |name: &str, shape: [usize; 2], of: &dyn Fn(&ElementSurface) -> Vec<f64>| {
        let values: Vec<f64> = all.iter().flat_map(of).collect();
        let array: Bound<'_, PyArray3<f64>> =
            PyArray1::from_vec(py, values).reshape([all.len(), shape[0], shape[1]])?;
        out.set_item(name, array)
    };
    layers("tangential_fit", [2, 4], &|e| {
        e.tangential
            .iter()
            .flat_map(|t| [t.parameters.a, t.parameters.b, t.parameters.c, t.parameters.d])
            .collect()
    })?;
    layers("tangential_stiffness", [2, samples], &|e| e.curves.tangential.concat())?;
    if all.iter().all(|e| e.bands.is_some()) {
        let normal = |e: &ElementSurface| e.bands.as_ref().map_or_else(Vec::new, |b| b.normal.concat());
        layers("normal_band", [2, samples], &normal)?;
    }
    Ok(out)
}

/// What one face shows over the elements, with NaN where there is no value.
fn of_face<'py>(py: Python<'py>, found: &Characterisation, side: usize) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let column = |name: &str, of: &dyn Fn(&FaceAsperities) -> f64| {
        let values = found.elements.iter().map(|e| of(&e.faces[side]));
        out.set_item(name, PyArray1::from_vec(py, values.collect()))
    };
    column("points", &|f| f.points as f64)?;
    column("missing", &|f| f.missing as f64)?;
    column("sa", &|f| f.areal.sa)?;
    column("sq", &|f| f.areal.sq)?;
    column("sz", &|f| f.areal.sz)?;
    column("ssk", &|f| f.areal.ssk.unwrap_or(f64::NAN))?;
    column("sku", &|f| f.areal.sku.unwrap_or(f64::NAN))?;
    column("sdq", &|f| f.areal.sdq.unwrap_or(f64::NAN))?;
    column("spd", &|f| f.areal.spd)?;
    column("spc", &|f| f.areal.spc.unwrap_or(f64::NAN))?;
    column("summits", &|f| f.summits as f64)?;
    column("count", &|f| f.asperity_count.unwrap_or(f64::NAN))?;
    let pairs = |name: &str, of: &dyn Fn(&FaceAsperities) -> [f64; 2]| {
        let values = found.elements.iter().flat_map(|e| of(&e.faces[side]));
        let array = PyArray1::from_vec(py, values.collect()).reshape([found.elements.len(), 2])?;
        out.set_item(name, array)
    };
    pairs("peaks", &|f| f.peaks.map(|n| n as f64))?;
    pairs("radius", &|f| f.radius.map(|r| r.unwrap_or(f64::NAN)))?;
    Ok(out)
}

/// The outlines of plane elements.
fn outlines(
    nodes: &PyReadonlyArray2<'_, f64>,
    elements: &PyReadonlyArray2<'_, i64>,
) -> Result<ElementOutlines, Exception> {
    let nodes = nodes.as_array();
    let nodes = nodes.rows().into_iter().map(|row| [row[0], row[1]]).collect();
    let elements = elements.as_array();
    let lists = elements.rows().into_iter().map(|row| {
        let kept: Vec<u32> = row
            .iter()
            .take_while(|node| **node != -1)
            // What is no number of a node becomes one that no mesh has.
            .map(|node| u32::try_from(*node).unwrap_or(u32::MAX))
            .collect();
        kept
    });
    let mesh = InterfaceMesh::try_from_lists(nodes, lists)?;
    let outlines = mesh.elements.iter().map(Element::outline).collect();
    Ok(ElementOutlines::try_new(mesh.nodes, outlines)?)
}

fn from_python((heights, step, origin, height_step): &GivenMap<'_>) -> Result<HeightMap, Exception> {
    let [ny, nx] = [heights.shape()[0], heights.shape()[1]];
    let heights: Vec<f64> = heights.as_array().iter().copied().collect();
    let map = HeightMap::try_new(nx, ny, *step, *origin, heights)?;
    Ok(match height_step {
        Some(step) => map.with_height_step(*step)?,
        None => map,
    })
}

fn to_python<'py>(py: Python<'py>, map: &HeightMap) -> PyResult<Map<'py>> {
    let (nx, ny) = (map.nx(), map.ny());
    let heights = (0..nx * ny).map(|k| map.height(k % nx, k / nx).unwrap_or(f64::NAN));
    let heights = PyArray1::from_vec(py, heights.collect()).reshape([ny, nx])?;
    Ok((heights, map.step(), map.origin(), map.height_step()))
}

/// The extension of a path in small letters.
pub(crate) fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    extension.to_string_lossy().to_ascii_lowercase()
}

/// One of the words that a type has.
pub(crate) fn choice<T: DeserializeOwned>(argument: &str, word: Option<&str>) -> Result<Option<T>, Exception> {
    let Some(word) = word else { return Ok(None) };
    serde_json::from_value(Value::String(word.into()))
        .map(Some)
        .map_err(|error| {
            let reason = error.to_string();
            input(format!("{argument} = {word:?} is not admissible: {reason}")).of(argument, &reason)
        })
}

/// A number that counts from zero.
fn from_zero(argument: &str, given: Option<i64>) -> Result<Option<usize>, Exception> {
    const RANGE: &str = "it must not be negative";
    let Some(given) = given else { return Ok(None) };
    match usize::try_from(given) {
        Ok(number) => Ok(Some(number)),
        Err(_) => Err(input(format!("{argument} = {given} is not admissible; {RANGE}")).of(argument, RANGE)),
    }
}
