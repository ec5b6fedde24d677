//! Structures that come as matrices of other programs.

use crate::Error;
use crate::scene::{self, Coordinates, MatrixVector, PlaneMesh};
use matrix_files::value::{Array, Collection, Dense, Dof};
use matrix_files::{abaqus, calculix, mat, matrix_market, npz};
use reduction::{RelativeSystem, SystemMatrices};
use sprs::{CsMat, TriMat};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use substructure::sparse::{multiply_vector, submatrix, symmetric_part};
use zte_assembly::{Element, InterfaceMesh};

/// Arrays that are read; all others are noted.
const ARRAYS: [&str; 9] = [
    "M",
    "K",
    "dofs",
    "Fv",
    "R",
    "L",
    "frame",
    "interface_nodes",
    "interface_elements",
];

/// Asymmetry relative to the diagonal that is taken for round-off.
const ROUND_OFF: f64 = 1e-6;

/// Relative difference of the masses that a structure shows along the three axes, up to which it has one mass.
const SAME_MASS: f64 = 1e-3;

/// A structure over `[jump; rest]` in SI, with what the reduction needs besides.
#[derive(Clone, Debug)]
pub struct ImportedBodies {
    /// Matrices, and loads of unit tension.
    pub relative: RelativeSystem,
    /// Row of the response displacement.
    pub response: Vec<f64>,
    /// Whether the coordinates came over the jump, so that a reduction has been made already and all are retained.
    pub is_reduced: bool,
    /// Zero-energy modes that the structure with a stuck interface should have.
    pub zero_energy_modes: usize,
    /// Mass (kg), if the coordinates show it.
    pub mass: Option<f64>,
}

/// A structure from files, with its interface.
pub(crate) struct Imported {
    pub(crate) bodies: ImportedBodies,
    pub(crate) interface: InterfaceMesh,
    pub(crate) frame: [[f64; 3]; 3],
}

/// What the files hold, as it stands.
#[derive(Default)]
struct Contents {
    /// What the coordinates are, or the rows of `lift`.
    dofs: Vec<Dof>,
    stiffness: Option<CsMat<f64>>,
    mass: Option<CsMat<f64>>,
    loads: Vec<Vec<f64>>,
    load_cases: BTreeMap<String, Vec<f64>>,
    recovery: Vec<Vec<f64>>,
    /// The coordinates of `dofs` from those of the matrices.
    lift: Option<CsMat<f64>>,
    frame: Option<[[f64; 3]; 3]>,
    mesh: Option<PlaneMesh>,
}

/// Reads the matrices that a scene names.
///
/// # Errors
/// Of the files; [`Error::Matrices`] for what does not fit together; of the change of coordinates.
pub(crate) fn read(source: &scene::Matrices, notes: &mut dyn FnMut(&str)) -> Result<Imported, Error> {
    let file = File { path: &source.path };
    let mut contents = file.contents(notes)?;
    let (length, unit_mass) = source.units.map_or((1.0, 1.0), |u| (u.length_in_si(), u.mass_in_si()));
    let plane = source.interface.clone().or_else(|| contents.mesh.take());
    let plane = plane.ok_or_else(|| file.fail("it has no interface mesh: give model.matrices.interface"))?;
    let interface = file.interface(&plane, length)?;
    let n_nodes = interface.nodes.len();
    let place: HashMap<Dof, usize> = contents.dofs.iter().zip(0..).map(|(&dof, row)| (dof, row)).collect();
    if place.len() < contents.dofs.len() {
        return Err(file.fail("its map of degrees of freedom names one twice"));
    }
    // In coordinates of the dimension of length, matrices carry the unit of mass alone, and responses and loads of unit
    // tension none.
    let scaled = |matrix: Option<CsMat<f64>>, what| -> Result<CsMat<f64>, Error> {
        let matrix = matrix.ok_or_else(|| file.fail(&format!("it has no {what}")))?;
        Ok(file.symmetric(matrix, what)?.map(|value| value * unit_mass))
    };
    let (stiffness, mass) = (
        scaled(contents.stiffness.take(), "stiffness K")?,
        scaled(contents.mass.take(), "mass M")?,
    );
    let n = stiffness.rows();
    file.check_sizes(&contents, n, mass.rows())?;
    let vectors = Vectors {
        file: &file,
        contents: &contents,
        place: &place,
    };
    let (loads, response) = (
        vectors.loads(source.bolts.as_deref())?,
        vectors.response(&source.response)?,
    );
    let system = SystemMatrices {
        stiffness: &stiffness,
        mass: &mass,
        loads: &loads,
        positions: &vec![[0.0; 3]; n],
    };
    let rows_of = |labels: &mut dyn Iterator<Item = u64>| {
        labels
            .flat_map(|node| (1..=3).map(move |component| Dof::Nodal { node, component }))
            .map(|dof| vectors.row(dof))
            .collect::<Result<Vec<usize>, Error>>()
    };
    let (relative, frame) = match &source.coordinates {
        Coordinates::Jump => {
            let jump = rows_of(&mut (1..=n_nodes as u64))?;
            let relative = match &contents.lift {
                None => RelativeSystem::from_relative(system, &jump)?,
                Some(lift) => {
                    let column: Vec<Option<usize>> = (0..n).map(Some).collect();
                    RelativeSystem::from_combinations(system, &submatrix(lift, &jump, &column, n))?
                }
            };
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            (relative, contents.frame.unwrap_or(axes))
        }
        Coordinates::BothSides(sides) => {
            if contents.lift.is_some() {
                return Err(file.fail("L is read with `coordinates: \"jump\"` only"));
            }
            for (side, labels) in [("top", &sides.top), ("bottom", &sides.bottom)] {
                if labels.len() != n_nodes {
                    let found = labels.len();
                    return Err(file.fail(&format!(
                        "the {side} side names {found} nodes, but the interface mesh has {n_nodes}"
                    )));
                }
            }
            let top = rows_of(&mut sides.top.iter().copied())?;
            let bottom = rows_of(&mut sides.bottom.iter().copied())?;
            (
                RelativeSystem::from_both_sides(system, &top, &bottom, sides.frame)?,
                sides.frame,
            )
        }
    };
    let is_reduced = source.coordinates == Coordinates::Jump;
    let bodies = ImportedBodies {
        response: relative.row(&response),
        relative,
        is_reduced,
        zero_energy_modes: source.zero_energy_modes.unwrap_or(if is_reduced { 0 } else { 6 }),
        mass: if is_reduced {
            None
        } else {
            translated_mass(&contents.dofs, &mass)
        },
    };
    Ok(Imported {
        bodies,
        interface,
        frame,
    })
}

/// Vectors over the coordinates of the matrices.
struct Vectors<'a> {
    file: &'a File<'a>,
    contents: &'a Contents,
    place: &'a HashMap<Dof, usize>,
}

impl Vectors<'_> {
    fn row(&self, dof: Dof) -> Result<usize, Error> {
        let (label, component) = (dof.label(), dof.component());
        self.place.get(&dof).copied().ok_or_else(|| {
            self.file.fail(&format!(
                "component {component} of {label} is not in its map of degrees of freedom; it must be free and retained"
            ))
        })
    }

    fn loads(&self, bolts: Option<&[MatrixVector]>) -> Result<Vec<Vec<f64>>, Error> {
        let contents = self.contents;
        let loads = match bolts {
            Some(bolts) => bolts
                .iter()
                .map(|bolt| match bolt {
                    MatrixVector::Number(number) => self.numbered("load", &contents.loads, *number),
                    MatrixVector::LoadCase(name) => contents.load_cases.get(name).cloned().ok_or_else(|| {
                        let known: Vec<&str> = contents.load_cases.keys().map(String::as_str).collect();
                        self.file
                            .fail(&format!("it has no load case `{name}`; it has: {}", known.join(", ")))
                    }),
                    MatrixVector::Terms(terms) => self.terms(terms),
                })
                .collect::<Result<Vec<_>, _>>()?,
            None => contents
                .loads
                .iter()
                .chain(contents.load_cases.values())
                .cloned()
                .collect(),
        };
        if loads.is_empty() {
            return Err(self
                .file
                .fail("it has no bolt loads: name them as model.matrices.bolts"));
        }
        Ok(loads)
    }

    fn response(&self, response: &MatrixVector) -> Result<Vec<f64>, Error> {
        match response {
            MatrixVector::Number(number) => self.numbered("row of the recovery R", &self.contents.recovery, *number),
            MatrixVector::Terms(terms) => self.terms(terms),
            MatrixVector::LoadCase(name) => Err(self.file.fail(&format!(
                "the response cannot be the load case `{name}`; give a number or terms as model.matrices.response"
            ))),
        }
    }

    fn numbered(&self, what: &str, of: &[Vec<f64>], number: usize) -> Result<Vec<f64>, Error> {
        let found = number.checked_sub(1).and_then(|index| of.get(index));
        found.cloned().ok_or_else(|| {
            let count = of.len();
            self.file.fail(&format!(
                "it has no {what} number {number} (there are {count}); give another number, or terms"
            ))
        })
    }

    fn terms(&self, terms: &[(i64, u32, f64)]) -> Result<Vec<f64>, Error> {
        let mut vector = vec![0.0; self.contents.dofs.len()];
        for &(label, component, factor) in terms {
            vector[self.row(Dof::new(label, component))?] += factor;
        }
        Ok(match &self.contents.lift {
            None => vector,
            Some(lift) => multiply_vector(&lift.transpose_view().to_csr(), &vector),
        })
    }
}

/// Total mass as seen by translations along the three axes; `None` if they disagree.
fn translated_mass(dofs: &[Dof], mass: &CsMat<f64>) -> Option<f64> {
    let masses = [1, 2, 3].map(|along| {
        let moves = |row: usize| matches!(dofs[row], Dof::Nodal { component, .. } if component == along);
        let terms = mass.iter().filter(|(_, (i, j))| moves(*i) && moves(*j));
        terms.map(|(value, _)| *value).sum::<f64>()
    });
    let mean = masses.iter().sum::<f64>() / 3.0;
    let same = |m: &f64| (m - mean).abs() <= SAME_MASS * mean;
    masses.iter().all(same).then_some(mean)
}

/// The file or folder of a scene.
struct File<'a> {
    path: &'a Path,
}

impl File<'_> {
    fn fail(&self, reason: &str) -> Error {
        Error::Matrices {
            path: self.path.to_owned(),
            reason: reason.to_owned(),
        }
    }

    fn contents(&self, notes: &mut dyn FnMut(&str)) -> Result<Contents, Error> {
        let path = self.path;
        if path.is_dir() {
            let mut found = Collection::default();
            for name in ARRAYS {
                let file = path.join(format!("{name}.mtx"));
                if file.exists() {
                    found.arrays.insert(name.into(), matrix_market::read(&file)?);
                }
            }
            return self.named(found, notes);
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("npz") => self.named(npz::read(path)?, notes),
            Some("mat") => self.named(mat::read(path)?, notes),
            Some("mtx") => {
                let mut found = abaqus::read_substructure(path)?;
                for skipped in &found.skipped {
                    notes(&format!(
                        "{}: {} is not read: {}",
                        path.display(),
                        skipped.name,
                        skipped.reason
                    ));
                }
                let mut matrix = |name: &str| found.matrices.remove(name).map(|matrix| from_dense(&matrix));
                Ok(Contents {
                    stiffness: matrix("STIFFNESS"),
                    mass: matrix("MASS"),
                    dofs: found.dofs,
                    load_cases: found.loads,
                    recovery: found.recovery.map(|r| rows(&r.matrix)).unwrap_or_default(),
                    ..Contents::default()
                })
            }
            Some("sti" | "mas" | "dof") => {
                let mut found = calculix::read(path)?;
                Ok(Contents {
                    stiffness: found.matrices.remove(calculix::STIFFNESS),
                    mass: found.matrices.remove(calculix::MASS),
                    dofs: found.dofs,
                    ..Contents::default()
                })
            }
            _ => Err(self.fail("it is neither a folder nor a file with the extension npz, mat, mtx or sti")),
        }
    }

    /// From named arrays, or those of the one structure that has them as fields.
    fn named(&self, mut found: Collection, notes: &mut dyn FnMut(&str)) -> Result<Contents, Error> {
        for skipped in &found.skipped {
            notes(&format!(
                "{}: {} is not read: {}",
                self.path.display(),
                skipped.name,
                skipped.reason
            ));
        }
        let owners: Vec<String> = found
            .arrays
            .keys()
            .filter_map(|name| Some(name.strip_suffix('K')?.to_owned()))
            .filter(|owner| owner.is_empty() || owner.ends_with('.'))
            .collect();
        let owner = match owners.as_slice() {
            [] => return Err(self.fail("it has no stiffness K")),
            [owner] => owner.clone(),
            several if several.contains(&String::new()) => String::new(),
            several => return Err(self.fail(&format!("K is in several structures: {}", several.join(", ")))),
        };
        let mut take = |name: &str| found.arrays.remove(&format!("{owner}{name}"));
        let (dofs, mesh) = (take("dofs"), (take("interface_nodes"), take("interface_elements")));
        let [stiffness, mass, lift, frame] = ["K", "M", "L", "frame"].map(|name| take(name).map(|array| (name, array)));
        let (loads, recovery) = (take("Fv"), take("R"));
        if !found.arrays.is_empty() {
            let names: Vec<&str> = found.arrays.keys().map(String::as_str).collect();
            notes(&format!("{}: not needed: {}", self.path.display(), names.join(", ")));
        }
        let dofs = dofs.ok_or_else(|| {
            self.fail(
                "it has no map of degrees of freedom: add an array `dofs` with a row `label, component` for each coordinate (or \
                 for each row of L)",
            )
        })?;
        let dofs = Dof::from_table(&self.integers("dofs", dofs)?)
            .ok_or_else(|| self.fail("`dofs` needs two columns, label and component"))?;
        let matrix = |given: Option<(&str, Array)>| given.map(|(name, array)| self.matrix(name, array)).transpose();
        let frame = matrix(frame)?.map(|frame| {
            let mut axes = [[0.0; 3]; 3];
            let known = frame.shape() == (3, 3);
            for (value, (i, j)) in frame.iter().filter(|_| known) {
                axes[i][j] = *value;
            }
            known.then_some(axes).ok_or_else(|| self.fail("`frame` is not 3 x 3"))
        });
        Ok(Contents {
            dofs,
            stiffness: matrix(stiffness)?,
            mass: matrix(mass)?,
            loads: match loads {
                Some(loads) => rows_of(&self.matrix("Fv", loads)?.transpose_view().to_csr()),
                None => Vec::new(),
            },
            recovery: match recovery {
                Some(recovery) => rows_of(&self.matrix("R", recovery)?),
                None => Vec::new(),
            },
            lift: matrix(lift)?,
            frame: frame.transpose()?,
            mesh: match mesh {
                (Some(nodes), Some(elements)) => Some(self.mesh(nodes, elements)?),
                _ => None,
            },
            load_cases: BTreeMap::new(),
        })
    }

    fn matrix(&self, name: &str, array: Array) -> Result<CsMat<f64>, Error> {
        match array {
            Array::Dense(dense) => Ok(from_dense(&dense)),
            Array::Sparse(sparse) => Ok(sparse),
            Array::Integers(integers) => {
                let data = integers.data().iter().map(|&v| v as f64).collect();
                Ok(from_dense(&Dense::try_new(integers.rows(), integers.columns(), data)?))
            }
            _ => Err(self.fail(&format!("`{name}` is not a matrix of numbers"))),
        }
    }

    /// Whole numbers, also those that MATLAB stores as reals.
    fn integers(&self, name: &str, array: Array) -> Result<Dense<i64>, Error> {
        match array {
            Array::Integers(integers) => Ok(integers),
            Array::Dense(reals) if reals.data().iter().all(|v| v.fract() == 0.0 && v.abs() < 1e15) => {
                let data = reals.data().iter().map(|&v| v as i64).collect();
                Ok(Dense::try_new(reals.rows(), reals.columns(), data)?)
            }
            _ => Err(self.fail(&format!("`{name}` is not a full matrix of whole numbers"))),
        }
    }

    fn mesh(&self, nodes: Array, elements: Array) -> Result<PlaneMesh, Error> {
        let Array::Dense(nodes) = nodes else {
            return Err(self.fail("`interface_nodes` is not a full matrix of real numbers"));
        };
        let elements = self.integers("interface_elements", elements)?;
        if nodes.columns() != 2 || !(3..=4).contains(&elements.columns()) {
            return Err(self.fail("`interface_nodes` needs two columns, `interface_elements` three or four"));
        }
        let corner = |i: usize, j: usize| u32::try_from(elements[(i, j)]).unwrap_or(u32::MAX);
        Ok(PlaneMesh {
            nodes: (0..nodes.rows()).map(|i| [nodes[(i, 0)], nodes[(i, 1)]]).collect(),
            elements: (0..elements.rows())
                .map(|i| {
                    let corners = (0..elements.columns()).map(|j| corner(i, j));
                    corners
                        .enumerate()
                        .filter(|(j, node)| *j < 3 || *node != 0)
                        .map(|(_, node)| node)
                        .collect()
                })
                .collect(),
        })
    }

    fn interface(&self, plane: &PlaneMesh, length: f64) -> Result<InterfaceMesh, Error> {
        let elements = plane.elements.iter().zip(1..).map(|(corners, number)| {
            let index = |node: &u32| {
                let known = (1..=plane.nodes.len()).contains(&(*node as usize));
                known.then(|| node - 1).ok_or_else(|| {
                    let last = plane.nodes.len();
                    self.fail(&format!(
                        "interface element {number} has the node {node}, but the nodes are 1 to {last}"
                    ))
                })
            };
            let corners = corners.iter().map(index).collect::<Result<Vec<u32>, Error>>()?;
            match corners.as_slice() {
                &[a, b, c] => Ok(Element::Tri3([a, b, c])),
                &[a, b, c, d] => Ok(Element::Quad4([a, b, c, d])),
                other => {
                    let found = other.len();
                    Err(self.fail(&format!(
                        "interface element {number} has {found} nodes instead of three or four"
                    )))
                }
            }
        });
        Ok(InterfaceMesh {
            elements: elements.collect::<Result<_, _>>()?,
            nodes: plane.nodes.iter().map(|x| x.map(|x| x * length)).collect(),
        })
    }

    fn symmetric(&self, matrix: CsMat<f64>, what: &str) -> Result<CsMat<f64>, Error> {
        let (rows, columns) = matrix.shape();
        if rows != columns {
            return Err(self.fail(&format!("its {what} is {rows} x {columns} instead of square")));
        }
        let transposed: CsMat<f64> = matrix.transpose_view().to_csr();
        let difference = &matrix - &transposed;
        let own = |i: usize| matrix.get(i, i).map_or(0.0, |v| v.abs());
        // Entries differ in unit; their diagonal tells what is small.
        let defect = difference
            .iter()
            .find(|(v, (i, j))| !(v.abs() <= ROUND_OFF * (own(*i) * own(*j)).sqrt()));
        if let Some((value, (i, j))) = defect {
            return Err(self.fail(&format!(
                "its {what} is unsymmetric: the entries ({}, {}) and ({1}, {0}) differ by {value:.3e}",
                i + 1,
                j + 1
            )));
        }
        Ok(symmetric_part(matrix))
    }

    fn check_sizes(&self, contents: &Contents, n: usize, mass: usize) -> Result<(), Error> {
        let lift = contents.lift.as_ref().map(CsMat::shape);
        let vectors = contents
            .loads
            .iter()
            .chain(contents.load_cases.values())
            .map(|v| ("loads", v.len()));
        let rows = contents.recovery.iter().map(|v| ("recovery", v.len()));
        let map = lift.map_or(("map of degrees of freedom", contents.dofs.len()), |(_, columns)| {
            ("L", columns)
        });
        for (what, found) in vectors.chain(rows).chain([("mass", mass), map]) {
            if found != n {
                return Err(self.fail(&format!(
                    "its stiffness is over {n} coordinates, but its {what} over {found}"
                )));
            }
        }
        match lift {
            Some((rows, _)) if rows != contents.dofs.len() => {
                let found = contents.dofs.len();
                Err(self.fail(&format!("L has {rows} rows, but the map of degrees of freedom {found}")))
            }
            _ => Ok(()),
        }
    }
}

/// Rows of a full matrix.
fn rows(matrix: &Dense<f64>) -> Vec<Vec<f64>> {
    let row = |i| (0..matrix.columns()).map(|j| matrix[(i, j)]).collect();
    (0..matrix.rows()).map(row).collect()
}

/// Rows of a sparse matrix, in full.
fn rows_of(matrix: &CsMat<f64>) -> Vec<Vec<f64>> {
    matrix.outer_iterator().map(|row| row.to_dense().to_vec()).collect()
}

/// Without the zeros.
fn from_dense(matrix: &Dense<f64>) -> CsMat<f64> {
    let mut entries = TriMat::new((matrix.rows(), matrix.columns()));
    for i in 0..matrix.rows() {
        for j in (0..matrix.columns()).filter(|&j| matrix[(i, j)] != 0.0) {
            entries.add_triplet(i, j, matrix[(i, j)]);
        }
    }
    entries.to_csr()
}
