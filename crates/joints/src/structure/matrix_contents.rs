//! What files of matrices hold, before it becomes a structure.

use crate::Error;
use finite_elements::sparse::symmetric_part;
use matrix_files::dmig::PointMatrices;
use matrix_files::value::{Array, Assembled, Collection, Dense, Dof, Skipped};
use matrix_files::{abaqus, ansys, calculix, dmig, mat, matrix_market, npz, op2, op4};
use scenes::PlaneMesh;
use sprs::{CsMat, TriMat};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Arrays that are read; all others are noted.
const ARRAYS: [&str; 10] = [
    "M",
    "K",
    "C",
    "dofs",
    "Fv",
    "R",
    "L",
    "frame",
    "interface_nodes",
    "interface_elements",
];

/// Names of arrays in files of Nastran, which allow eight characters and tell no capitals apart.
const SHORT_NAMES: [(&str, &str); 2] = [("interface_nodes", "INTNODES"), ("interface_elements", "INTELEMS")];

/// Names of stiffness, mass and damping among entries `DMIG`; the later ones are those that Nastran gives external superelements,
/// in text and in `OUTPUT2`.
const POINT_STIFFNESS: [&str; 3] = ["K", "KAAX", "MATK"];
const POINT_MASS: [&str; 3] = ["M", "MAAX", "MATM"];
const POINT_DAMPING: [&str; 3] = ["B", "BAAX", "MATB"];

/// Asymmetry relative to the diagonal that is taken for round-off.
pub(super) const ROUND_OFF: f64 = 1e-6;

/// What the files hold, as it stands.
#[derive(Default)]
pub(super) struct Contents {
    /// What the coordinates are, or the rows of `lift`.
    pub(super) dofs: Vec<Dof>,
    pub(super) stiffness: Option<CsMat<f64>>,
    pub(super) mass: Option<CsMat<f64>>,
    /// Viscous damping.
    pub(super) damping: Option<CsMat<f64>>,
    /// Loads of unit tension, one per row.
    pub(super) loads: Option<CsMat<f64>>,
    pub(super) load_cases: BTreeMap<String, Vec<f64>>,
    /// Displacements at which amplitudes may be measured, one per row.
    pub(super) recovery: Option<CsMat<f64>>,
    /// The coordinates of `dofs` from those of the matrices.
    pub(super) lift: Option<CsMat<f64>>,
    pub(super) frame: Option<[[f64; 3]; 3]>,
    pub(super) mesh: Option<PlaneMesh>,
}

impl Contents {
    fn assembled(mut found: Assembled) -> Self {
        let [stiffness, mass, damping] =
            [Assembled::STIFFNESS, Assembled::MASS, Assembled::DAMPING].map(|name| found.matrices.remove(name));
        Self {
            dofs: found.dofs,
            stiffness,
            mass,
            damping,
            ..Self::default()
        }
    }
}

/// The files that make up the matrices at a path: itself, or those of a folder or a job of CalculiX.
pub fn matrix_files_of(path: &Path) -> Vec<PathBuf> {
    if path.is_dir() {
        let files = ARRAYS.iter().map(|name| array_file(path, name));
        return files.filter(|file| file.exists()).collect();
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("sti" | "mas" | "dof") => calculix::files(path).into(),
        _ => vec![path.to_owned()],
    }
}

/// The file of an array in a folder of matrices.
fn array_file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.mtx"))
}

/// The name of an array in files of Nastran.
pub(super) fn short_name(name: &str) -> String {
    let short = SHORT_NAMES.iter().find(|(long, _)| *long == name);
    short.map_or_else(|| name.to_ascii_uppercase(), |(_, short)| (*short).to_owned())
}

/// Arrays of a file of Nastran by the names that they have elsewhere.
fn with_long_names(mut found: Collection) -> Collection {
    for name in ARRAYS {
        let short = short_name(name);
        let stored = found.arrays.keys().find(|stored| stored.eq_ignore_ascii_case(&short));
        if let Some(array) = stored.cloned().and_then(|stored| found.arrays.remove(&stored)) {
            found.arrays.insert(name.into(), array);
        }
    }
    found
}

/// The file or folder of a scene.
pub(super) struct File<'a> {
    pub(super) path: &'a Path,
}

impl File<'_> {
    pub(super) fn fail(&self, reason: &str) -> Error {
        Error::Matrices {
            path: self.path.to_owned(),
            reason: reason.to_owned(),
        }
    }

    pub(super) fn contents(&self, notes: &mut dyn FnMut(&str)) -> Result<Contents, Error> {
        let path = self.path;
        if path.is_dir() {
            let mut found = Collection::default();
            for name in ARRAYS {
                let file = array_file(path, name);
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
            Some("op4") => self.named(with_long_names(op4::read(path)?), notes),
            Some("op2") => {
                let op2::Contents { arrays, points } = op2::read(path)?;
                if !POINT_STIFFNESS.iter().any(|name| points.matrices.contains_key(*name)) {
                    self.not_needed(points.matrices.keys().chain(points.numbered.keys()), notes);
                    return self.named(with_long_names(arrays), notes);
                }
                self.skipped(&arrays.skipped, notes);
                self.not_needed(arrays.arrays.keys(), notes);
                Ok(self.between_points(points, notes))
            }
            Some("pch" | "bdf" | "dat") => Ok(self.between_points(dmig::read(path)?, notes)),
            Some("mtx") => {
                let mut found = abaqus::read_substructure(path)?;
                self.skipped(&found.skipped, notes);
                let mut matrix = |name: &str| found.matrices.remove(name).map(|matrix| from_dense(&matrix));
                let [stiffness, mass] = ["STIFFNESS", "MASS"].map(&mut matrix);
                self.not_needed(found.matrices.keys(), notes);
                Ok(Contents {
                    stiffness,
                    mass,
                    dofs: found.dofs,
                    load_cases: found.loads,
                    recovery: found.recovery.map(|r| from_dense(&r.matrix)),
                    ..Contents::default()
                })
            }
            Some("sti" | "mas" | "dof") => Ok(Contents::assembled(calculix::read(path)?)),
            Some("full" | "sub") => Ok(Contents::assembled(ansys::read(path)?)),
            _ => Err(self.fail(
                "it is neither a folder nor a file with the extension npz, mat, mtx, sti, full, op2, op4, pch, bdf or dat",
            )),
        }
    }

    fn between_points(&self, found: PointMatrices, notes: &mut dyn FnMut(&str)) -> Contents {
        self.skipped(&found.skipped, notes);
        let [mut square, mut numbered] = [found.matrices, found.numbered];
        let mut first = |names: [&str; 3]| names.iter().find_map(|name| square.remove(*name));
        let [stiffness, mass, damping] = [POINT_STIFFNESS, POINT_MASS, POINT_DAMPING].map(&mut first);
        let mut by_rows = |name| numbered.remove(name).map(|m| m.transpose_view().to_csr());
        let (loads, recovery) = (by_rows("FV"), by_rows("R"));
        self.not_needed(square.keys().chain(numbered.keys()), notes);
        Contents {
            dofs: found.dofs,
            stiffness,
            mass,
            damping,
            loads,
            recovery,
            ..Contents::default()
        }
    }

    fn skipped(&self, skipped: &[Skipped], notes: &mut dyn FnMut(&str)) {
        for Skipped { name, reason } in skipped {
            notes(&format!("{}: {name} is not read: {reason}", self.path.display()));
        }
    }

    fn not_needed<'n>(&self, names: impl Iterator<Item = &'n String>, notes: &mut dyn FnMut(&str)) {
        let names: Vec<&str> = names.map(String::as_str).collect();
        if !names.is_empty() {
            notes(&format!("{}: not needed: {}", self.path.display(), names.join(", ")));
        }
    }

    /// From named arrays, or those of the one structure that has them as fields.
    fn named(&self, mut found: Collection, notes: &mut dyn FnMut(&str)) -> Result<Contents, Error> {
        self.skipped(&found.skipped, notes);
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
        let [stiffness, mass, damping, lift, frame] =
            ["K", "M", "C", "L", "frame"].map(|name| take(name).map(|array| (name, array)));
        let (loads, recovery) = (take("Fv"), take("R"));
        self.not_needed(found.arrays.keys(), notes);
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
            damping: matrix(damping)?,
            loads: matrix(loads.map(|loads| ("Fv", loads)))?.map(|loads| loads.transpose_view().to_csr()),
            recovery: matrix(recovery.map(|recovery| ("R", recovery)))?,
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
        if nodes.columns() != 2 || !(3..=9).contains(&elements.columns()) {
            return Err(self.fail("`interface_nodes` needs two columns, `interface_elements` three to nine"));
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

    pub(super) fn symmetric(&self, matrix: CsMat<f64>, what: &str) -> Result<CsMat<f64>, Error> {
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

    pub(super) fn check_sizes(
        &self,
        contents: &Contents,
        n: usize,
        mass: usize,
        damping: Option<usize>,
    ) -> Result<(), Error> {
        let lift = contents.lift.as_ref().map(CsMat::shape);
        let cases = contents.load_cases.values().map(|v| ("load cases", v.len()));
        let loads = contents.loads.iter().map(|m| ("loads Fv", m.cols()));
        let rows = contents.recovery.iter().map(|m| ("recovery R", m.cols()));
        let damping = damping.map(|rows| ("damping C", rows));
        let map = lift.map_or(("map of degrees of freedom", contents.dofs.len()), |(_, columns)| {
            ("L", columns)
        });
        for (what, found) in loads
            .chain(cases)
            .chain(rows)
            .chain(damping)
            .chain([("mass", mass), map])
        {
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

/// Without the zeros.
pub(super) fn from_dense(matrix: &Dense<f64>) -> CsMat<f64> {
    let mut entries = TriMat::new((matrix.rows(), matrix.columns()));
    for i in 0..matrix.rows() {
        for j in (0..matrix.columns()).filter(|&j| matrix[(i, j)] != 0.0) {
            entries.add_triplet(i, j, matrix[(i, j)]);
        }
    }
    entries.to_csr()
}
