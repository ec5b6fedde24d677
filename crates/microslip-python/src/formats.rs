//! Files of matrices and meshes.

use crate::error::{Exception, input};
use crate::run::Cache;
use crate::scene::Scene;
use crate::surfaces::extension;
use crate::work::{pool, supervise};
use file_io::Source;
use finite_elements::elements::{Cell, ELEMENT_TYPES};
use finite_elements::formats::gmsh;
use finite_elements::formats::solid_mesh::SolidMesh;
use finite_elements::formats::vtu::{self, Encoding, Field};
use finite_elements::mesh::{Element as Solid, Face, Group, Material, Mesh};
use joint_model::benchmark::Symmetry;
use joints::structure::Structure;
use joints::structure::export::arrays;
use matrix_files::dmig::PointMatrices;
use matrix_files::value::{Array, Assembled, Collection, Dense, Dof};
use matrix_files::{abaqus, ansys, calculix, dmig, mat, matrix_market, npz, op2, op4};
use numpy::npyffi::NPY_ORDER;
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use sprs::CsMat;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A name, and what belongs to it.
type Named<T> = (String, T);

/// Arrays by name.
type Arrays = Vec<Named<Py<PyAny>>>;

/// Name of the array of a file that holds one alone.
const MATRIX: &str = "matrix";

/// The arrays of a file by name, sparse matrices as shape, starts of rows, columns and entries; and what was not read.
#[pyfunction]
#[pyo3(signature = (path: "str") -> "tuple[list[tuple[str, object]], list[str]]")]
pub(crate) fn read_matrices(py: Python<'_>, path: PathBuf) -> PyResult<(Arrays, Vec<String>)> {
    let found = py.detach(|| collection(&path))?;
    let skipped = found.skipped.iter().map(|s| format!("{}: {}", s.name, s.reason));
    let skipped = skipped.collect();
    Ok((to_python(py, found.arrays)?, skipped))
}

fn collection(path: &Path) -> Result<Collection, Exception> {
    let with_dofs = |matrices: &mut dyn Iterator<Item = (String, CsMat<f64>)>, dofs: &[Dof], skipped| {
        let mut arrays: BTreeMap<String, Array> = matrices.map(|(name, m)| (name, Array::Sparse(m))).collect();
        arrays.insert("dofs".to_owned(), Dof::table(dofs));
        Collection { arrays, skipped }
    };
    let assembled = |found: Assembled| with_dofs(&mut found.matrices.into_iter(), &found.dofs, Vec::new());
    let between_points = |found: PointMatrices| {
        let matrices = &mut found.matrices.into_iter().chain(found.numbered);
        with_dofs(matrices, &found.dofs, found.skipped)
    };
    Ok(match extension(path).as_str() {
        "npz" => npz::read(path)?,
        "mat" => mat::read(path)?,
        "op4" => op4::read(path)?,
        "op2" => {
            let mut found = op2::read(path)?;
            if !found.points.dofs.is_empty() {
                for (name, array) in between_points(found.points).arrays {
                    let name = match found.arrays.arrays.contains_key(&name) {
                        true => format!("DMIG {name}"),
                        false => name,
                    };
                    found.arrays.arrays.insert(name, array);
                }
            }
            found.arrays
        }
        "pch" | "bdf" | "dat" => between_points(dmig::read(path)?),
        "sti" | "mas" | "dof" => assembled(calculix::read(path)?),
        "full" | "sub" => assembled(ansys::read(path)?),
        "mtx" | "mm" => {
            let bytes =
                file_io::input::read(path, file_io::input::Kind::Matrices).map_err(|error| Exception::from(&error))?;
            let name = path.to_string_lossy();
            let source = Source {
                name: &name,
                bytes: &bytes,
            };
            let start = bytes.trim_ascii_start();
            if start.starts_with(b"%%") {
                let array = matrix_market::parse(source)?;
                Collection {
                    arrays: [(MATRIX.to_owned(), array)].into(),
                    ..Collection::default()
                }
            } else if start.starts_with(b"*") {
                substructure(abaqus::parse_substructure(source)?)
            } else {
                assembled(abaqus::parse_assembled(&[(MATRIX, source)])?)
            }
        }
        other => {
            let remedy = "give a file that ends with .npz, .mat, .mtx, .sti, .full, .op2, .op4, .pch, .bdf or .dat";
            return Err(input(format!("matrices are not read from `.{other}`; {remedy}")).of("path", remedy));
        }
    })
}

/// The arrays of a substructure of Abaqus.
fn substructure(found: abaqus::Substructure) -> Collection {
    let matrices = found.matrices.into_iter().map(|(name, m)| (name, Array::Dense(m)));
    let mut arrays: BTreeMap<String, Array> = matrices.collect();
    let n = found.dofs.len();
    let loads = found.loads.into_iter();
    arrays.extend(loads.filter_map(|(name, load)| {
        let load = Dense::try_new(n, 1, load).ok()?;
        Some((format!("load {name}"), Array::Dense(load)))
    }));
    arrays.extend(found.recovery.map(|r| ("recovery".to_owned(), Array::Dense(r.matrix))));
    arrays.insert("dofs".into(), Dof::table(&found.dofs));
    Collection {
        arrays,
        skipped: found.skipped,
    }
}

fn to_python(py: Python<'_>, arrays: BTreeMap<String, Array>) -> PyResult<Arrays> {
    let value = |array: Array| -> PyResult<Py<PyAny>> {
        match array {
            Array::Dense(m) => dense(py, m)?.into_py_any(py),
            Array::Integers(m) => dense(py, m)?.into_py_any(py),
            Array::Sparse(m) => {
                let shape = m.shape();
                let (starts, columns, values) = m.into_raw_storage();
                let whole = |values: Vec<usize>| PyArray1::from_iter(py, values.into_iter().map(|v| v as i64));
                (shape, whole(starts), whole(columns), PyArray1::from_vec(py, values)).into_py_any(py)
            }
            Array::Text(text) => text.into_py_any(py),
            _ => Ok(py.None()),
        }
    };
    arrays
        .into_iter()
        .map(|(name, array)| Ok((name, value(array)?)))
        .collect()
}

fn dense<T: Element>(py: Python<'_>, m: Dense<T>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let shape = [m.rows(), m.columns()];
    PyArray1::from_vec(py, m.into_data()).reshape_with_order(shape, NPY_ORDER::NPY_FORTRANORDER)
}

/// An array from Python.
#[derive(FromPyObject)]
pub(crate) enum GivenArray<'py> {
    /// Text.
    Text(String),
    /// Whole numbers.
    Integers(PyReadonlyArray2<'py, i64>),
    /// Numbers.
    Dense(PyReadonlyArray2<'py, f64>),
    /// Shape, starts of rows, columns and entries.
    Sparse(
        (
            (usize, usize),
            PyReadonlyArray1<'py, i64>,
            PyReadonlyArray1<'py, i64>,
            PyReadonlyArray1<'py, f64>,
        ),
    ),
}

impl GivenArray<'_> {
    fn array(&self, name: &str) -> Result<Array, Exception> {
        Ok(match self {
            Self::Text(text) => Array::Text(text.clone()),
            Self::Integers(m) => {
                let data = m.as_array().iter().copied().collect();
                Array::Integers(Dense::try_from_rows(m.shape()[0], m.shape()[1], data)?)
            }
            Self::Dense(m) => {
                let data = m.as_array().iter().copied().collect();
                Array::Dense(Dense::try_from_rows(m.shape()[0], m.shape()[1], data)?)
            }
            Self::Sparse((shape, starts, columns, values)) => {
                // A negative index becomes one that no matrix has.
                let whole = |array: &PyReadonlyArray1<'_, i64>| -> Vec<usize> {
                    let all = array.as_array();
                    all.iter().map(|v| usize::try_from(*v).unwrap_or(usize::MAX)).collect()
                };
                let values = values.as_array().to_vec();
                let made = CsMat::try_new(*shape, whole(starts), whole(columns), values);
                Array::Sparse(made.map_err(|(.., error)| {
                    input(format!("{name}: the sparse matrix is broken: {error}"))
                        .of("arrays", "give a matrix of SciPy")
                })?)
            }
        })
    }
}

/// Writes arrays into one file, of which the extension names the format.
#[pyfunction]
#[pyo3(signature = (path: "str", arrays: "list[tuple[str, object]]") -> "None")]
pub(crate) fn write_matrices(
    py: Python<'_>,
    path: PathBuf,
    arrays: Vec<Named<GivenArray<'_>>>,
) -> Result<(), Exception> {
    let arrays = arrays
        .iter()
        .map(|(name, array)| Ok((name.clone(), array.array(name)?)));
    let arrays: BTreeMap<String, Array> = arrays.collect::<Result<_, Exception>>()?;
    py.detach(|| {
        let bytes = match (extension(&path).as_str(), arrays.first_key_value()) {
            ("npz", _) => npz::to_bytes(&arrays)?,
            ("mat", _) => mat::to_bytes(&arrays)?,
            ("op4", _) => op4::to_bytes(&arrays)?,
            ("mtx", Some((_, only))) if arrays.len() == 1 => matrix_market::to_bytes(only)?,
            ("mtx", _) => {
                let remedy = "write each into a file of its own";
                let found = format!(
                    "a Matrix Market file holds one array, and there are {}; {remedy}",
                    arrays.len()
                );
                return Err(input(found).of("arrays", remedy));
            }
            (other, _) => {
                let remedy = "it must end with .npz, .mat, .mtx or .op4";
                return Err(input(format!("matrices are not written as `.{other}`; {remedy}")).of("path", remedy));
            }
        };
        Ok(file_io::durable::write(&path, &bytes)?)
    })
}

/// The reduced model of a scene as arrays by name.
#[pyfunction]
#[pyo3(signature = (
    scene: "Scene",
    progress: "collections.abc.Callable[[str, float], object] | None",
    threads: "int | None",
    cache: "bool | str"
) -> "list[tuple[str, object]]")]
pub(crate) fn reduced_model(
    py: Python<'_>,
    scene: Py<Scene>,
    progress: Option<Py<PyAny>>,
    threads: Option<i64>,
    cache: Cache,
) -> PyResult<Arrays> {
    let scene = &scene.get().0.scene;
    let options = cache.options();
    if scene.model.symmetry == Symmetry::Half {
        let remedy = "leave out model.symmetry";
        let found = format!(
            "the half of the scene {} stands for the whole only here; {remedy}",
            scene.name
        );
        return Err(input(found).of("scene", remedy).into());
    }
    let pool = pool(threads)?;
    let arrays = supervise(py, &pool, progress.as_ref(), |monitor| {
        let structure = Structure::try_new(scene, monitor)?;
        let joint = &structure.joint;
        if !joint.node_frames.is_empty() || !joint.interface.covered.is_empty() {
            let remedy = "take a scene with one plane interface";
            let found = format!(
                "the interface of the scene {} is curved, faced in part or in several planes, which the matrices of one plane cannot \
                 tell; {remedy}",
                scene.name
            );
            return Err(input(found).of("scene", remedy));
        }
        let model = structure.reduce(&options, monitor)?;
        Ok::<_, Exception>(arrays(&model, &structure.joint)?)
    })??;
    to_python(py, arrays)
}

/// Whole numbers of a group.
type Numbers<'py> = Bound<'py, PyArray1<i64>>;

/// Lists of nodes of one length, and where in the file's order they stand.
type Cells<'py> = (String, Numbers<'py>, Bound<'py, PyArray2<i64>>);

/// A mesh: nodes, their labels, cells by type, groups of cells, of faces (rows end with -1) and of nodes, the body of each cell, notes.
type PyMesh<'py> = (
    Bound<'py, PyArray2<f64>>,
    Numbers<'py>,
    Vec<Cells<'py>>,
    Vec<Named<Numbers<'py>>>,
    Vec<Named<Bound<'py, PyArray2<i64>>>>,
    Vec<Named<Numbers<'py>>>,
    Numbers<'py>,
    Vec<String>,
);

/// The solids in a file and its named groups.
#[pyfunction]
#[pyo3(signature = (path: "str") -> "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int64], list[tuple[str, numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.int64]]], list[tuple[str, numpy.typing.NDArray[numpy.int64]]], list[tuple[str, numpy.typing.NDArray[numpy.int64]]], list[tuple[str, numpy.typing.NDArray[numpy.int64]]], numpy.typing.NDArray[numpy.int64], list[str]]")]
pub(crate) fn read_mesh(py: Python<'_>, path: PathBuf) -> PyResult<PyMesh<'_>> {
    let work = || {
        let mesh = SolidMesh::read(&path)?;
        let bodies = mesh.bodies();
        Ok::<_, Exception>((mesh, bodies))
    };
    let pool = pool(None)?;
    let (mesh, bodies) = py.detach(|| pool.install(work))?;
    let whole = |numbers: &[u32]| PyArray1::from_iter(py, numbers.iter().map(|n| i64::from(*n)));
    let table = |lists: &[&[u32]], columns: usize| {
        let rows = lists.iter().flat_map(|list| {
            let nodes = list.iter().map(|node| i64::from(*node));
            nodes.chain(std::iter::repeat(-1)).take(columns)
        });
        PyArray1::from_vec(py, rows.collect()).reshape([lists.len(), columns])
    };
    let mut cells = Vec::new();
    for row in ELEMENT_TYPES {
        let of_type = (0..).zip(&mesh.cells).filter(|(_, cell)| cell.element_type() == row);
        let (numbers, lists): (Vec<u32>, Vec<&[u32]>) = of_type.map(|(number, cell)| (number, cell.nodes())).unzip();
        if !numbers.is_empty() {
            let nodes = table(&lists, row.n_nodes())?;
            cells.push((row.name.to_ascii_lowercase(), whole(&numbers), nodes));
        }
    }
    let surfaces = mesh.surfaces.iter().map(|group| {
        let lists: Vec<&[u32]> = group.members.iter().map(Face::nodes).collect();
        let columns = lists.iter().map(|list| list.len()).max().unwrap_or(0);
        Ok((group.name.clone(), table(&lists, columns)?))
    });
    let groups = |groups: &[Group<u32>]| -> Vec<Named<Numbers<'_>>> {
        let named = groups.iter().map(|group| (group.name.clone(), whole(&group.members)));
        named.collect()
    };
    Ok((
        PyArray1::from_slice(py, mesh.nodes.as_flattened()).reshape([mesh.nodes.len(), 3])?,
        PyArray1::from_iter(py, mesh.labels.iter().map(|label| *label as i64)),
        cells,
        groups(&mesh.volumes),
        surfaces.collect::<PyResult<_>>()?,
        groups(&mesh.points),
        whole(&bodies),
        mesh.notes,
    ))
}

/// Cells of a type with their places in the order of all, and their nodes.
type GivenCells<'py> = (String, PyReadonlyArray1<'py, i64>, PyReadonlyArray2<'py, i64>);

/// Writes a mesh for Gmsh or VTK. Fields go with VTK, groups of faces and nodes with Gmsh; groups of cells are disjoint.
#[pyfunction]
#[pyo3(signature = (
    path: "str",
    nodes: "numpy.typing.NDArray[numpy.float64]",
    cells: "list[tuple[str, numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.int64]]]",
    volumes: "list[tuple[str, numpy.typing.NDArray[numpy.int64]]]",
    surfaces: "list[tuple[str, numpy.typing.NDArray[numpy.int64]]]",
    points: "list[tuple[str, numpy.typing.NDArray[numpy.int64]]]",
    point_fields: "list[tuple[str, numpy.typing.NDArray[numpy.float64]]]",
    cell_fields: "list[tuple[str, numpy.typing.NDArray[numpy.float64]]]"
) -> "None")]
pub(crate) fn write_mesh(
    py: Python<'_>,
    path: PathBuf,
    nodes: PyReadonlyArray2<'_, f64>,
    cells: Vec<GivenCells<'_>>,
    volumes: Vec<Named<PyReadonlyArray1<'_, i64>>>,
    surfaces: Vec<Named<PyReadonlyArray2<'_, i64>>>,
    points: Vec<Named<PyReadonlyArray1<'_, i64>>>,
    point_fields: Vec<Named<PyReadonlyArray2<'_, f64>>>,
    cell_fields: Vec<Named<PyReadonlyArray2<'_, f64>>>,
) -> Result<(), Exception> {
    let mesh = solids(&nodes, &cells, &volumes)?;
    let faces = surfaces
        .iter()
        .map(|(name, rows)| faces(name, rows))
        .collect::<Result<Vec<_>, _>>()?;
    let points = points.iter().map(|(name, numbers)| Group {
        name: name.clone(),
        members: numbers.as_array().iter().copied().map(node).collect(),
    });
    let points: Vec<Group<u32>> = points.collect();
    let fields = |given: &[Named<PyReadonlyArray2<'_, f64>>]| -> Vec<Field> {
        let field = |(name, values): &Named<PyReadonlyArray2<'_, f64>>| Field {
            name: name.clone(),
            components: values.shape()[1],
            values: values.as_array().iter().copied().collect(),
        };
        given.iter().map(field).collect()
    };
    let (point_fields, cell_fields) = (fields(&point_fields), fields(&cell_fields));
    py.detach(|| {
        let text = match extension(&path).as_str() {
            "msh" if point_fields.is_empty() && cell_fields.is_empty() => gmsh::write(&mesh, &faces, &points)?,
            "msh" => {
                let remedy = "write them into a .vtu file";
                return Err(input(format!("fields do not go into files for Gmsh; {remedy}")).of("point_fields", remedy));
            }
            "vtu" => vtu::write(&mesh, &point_fields, &cell_fields, Encoding::Base64)?,
            other => {
                let remedy = "it must end with .msh or .vtu";
                return Err(input(format!("meshes are not written as `.{other}`; {remedy}")).of("path", remedy));
            }
        };
        Ok(file_io::durable::write(&path, text.as_bytes())?)
    })
}

/// The number of a node; one that no mesh has if it is none.
fn node(number: i64) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

fn faces(name: &str, rows: &PyReadonlyArray2<'_, i64>) -> Result<Group<Face>, Exception> {
    let rows = rows.as_array();
    let face = |row: numpy::ndarray::ArrayView1<'_, i64>| {
        let list: Vec<u32> = row.iter().copied().take_while(|n| *n != -1).map(node).collect();
        Face::from_nodes(&list).ok_or_else(|| {
            let remedy = "faces have 3, 4, 6, 8 or 9 nodes";
            input(format!("surface `{name}`: a face has {} nodes; {remedy}", list.len())).of("surfaces", remedy)
        })
    };
    Ok(Group {
        name: name.to_owned(),
        members: rows.rows().into_iter().map(face).collect::<Result<_, _>>()?,
    })
}

fn solids(
    nodes: &PyReadonlyArray2<'_, f64>,
    cells: &[GivenCells<'_>],
    volumes: &[Named<PyReadonlyArray1<'_, i64>>],
) -> Result<Mesh, Exception> {
    let count: usize = cells.iter().map(|(_, numbers, _)| numbers.len()).sum();
    let mut all: Vec<Option<Cell>> = vec![None; count];
    let outside = |argument: &str, number: i64| {
        let remedy = format!("number all cells from 0 to {}, each once", count.saturating_sub(1));
        input(format!("there is no cell {number}, or it is given twice; {remedy}")).of(argument, &remedy)
    };
    for (name, numbers, lists) in cells {
        let known = ELEMENT_TYPES
            .into_iter()
            .find(|row| row.name.eq_ignore_ascii_case(name));
        let Some(row) = known else {
            let names: Vec<String> = ELEMENT_TYPES.iter().map(|row| row.name.to_ascii_lowercase()).collect();
            let remedy = format!("it must be one of {}", names.join(", "));
            return Err(input(format!("there is no type of cells {name:?}; {remedy}")).of("cells", &remedy));
        };
        let lists = lists.as_array();
        if lists.nrows() != numbers.len() {
            return Err(outside("cells", numbers.len() as i64));
        }
        for (number, list) in numbers.as_array().iter().zip(lists.rows()) {
            let list: Vec<u32> = list.iter().copied().map(node).collect();
            let Some(cell) = Cell::try_new(row, row.default_formulation(), &list) else {
                let remedy = format!("{name} has {}", row.n_nodes());
                return Err(input(format!("a cell has {} nodes; {remedy}", list.len())).of("cells", &remedy));
            };
            let place = usize::try_from(*number).ok().and_then(|k| all.get_mut(k));
            let place = place.filter(|place| place.is_none());
            *place.ok_or_else(|| outside("cells", *number))? = Some(cell);
        }
    }
    // Files keep names of materials alone.
    let material = |name: &str| Material {
        name: name.to_owned(),
        youngs_modulus: 1.0,
        poisson_ratio: 0.0,
        density: 1.0,
    };
    let mut materials: Vec<Material> = volumes.iter().map(|(name, _)| material(name)).collect();
    let mut of_cell: Vec<Option<u16>> = vec![None; count];
    if volumes.len() >= usize::from(u16::MAX) {
        let remedy = "merge some";
        return Err(input(format!("there are {} volumes; {remedy}", volumes.len())).of("volumes", remedy));
    }
    for (index, (name, numbers)) in (0..).zip(volumes) {
        for number in numbers.as_array().iter() {
            let place = usize::try_from(*number).ok().and_then(|k| of_cell.get_mut(k));
            let place = place.ok_or_else(|| outside("volumes", *number))?;
            if place.replace(index).is_some() {
                let remedy = "a cell can be in one volume; leave the other one out";
                return Err(input(format!(
                    "volume `{name}`: cell {number} is in another one too; {remedy}"
                ))
                .of("volumes", remedy));
            }
        }
    }
    let rest = materials.len() as u16;
    if of_cell.contains(&None) {
        materials.push(material("rest"));
    }
    let nodes = nodes.as_array();
    let elements = all.into_iter().zip(of_cell).filter_map(|(cell, material)| {
        let material = material.unwrap_or(rest);
        Some(Solid { cell: cell?, material })
    });
    Ok(Mesh {
        nodes: nodes.rows().into_iter().map(|x| [x[0], x[1], x[2]]).collect(),
        elements: elements.collect(),
        materials,
    })
}
