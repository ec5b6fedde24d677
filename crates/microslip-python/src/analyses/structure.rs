//! A structure with points of contact, over its jump and the modes that go with it.

use super::matrices::{full, matrix, per_point, semi_definite, vectors};
use crate::arrays::{check_shape, list, rows};
use crate::error::{Exception, input, solver};
use crate::laws::Law;
use crate::work::{pool, supervise};
use cqsma_solver::prestress::{self, Prestress};
use cqsma_solver::{Failure, Linearisation, NewtonSettings, modes};
use dense_algebra::SystemMatrix;
use faer::{Mat, MatRef};
use finite_elements::sparse::{congruence, diagonal, multiply_vector};
use joints::interface::{InterfaceForce, uniform_closure};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use reduction::{ReducedModel, RelativeSystem, Settings, SystemMatrices, reduce};
use sprs::{CsMat, TriMat};
use std::collections::BTreeSet;
use std::sync::Arc;
use zte_assembly::{Element, Interface, InterfaceMesh, Operators, PointContact, State};

/// Most coordinates whose change to the jump is made with full matrices.
const MOST_FULL: usize = 5000;

/// A structure with points of contact. It never changes.
#[pyclass(frozen, module = "microslip._native")]
pub struct Structure {
    pub(super) reduced: ReducedModel,
    pub(super) interface: Interface,
    /// Of each component of each point, whether the jump along it is zero.
    held: Vec<bool>,
}

/// What a row of the jump is.
enum JumpRow {
    /// Nothing: the jump is zero.
    Held,
    /// One coordinate.
    Coordinate(usize),
    /// The difference of two: top and bottom.
    Pair(usize, usize),
    /// Anything else.
    Combination,
}

impl JumpRow {
    fn new(row: &[(usize, f64)]) -> Self {
        match *row {
            [] => Self::Held,
            [(column, 1.0)] => Self::Coordinate(column),
            [(top, 1.0), (bottom, -1.0)] | [(bottom, -1.0), (top, 1.0)] => Self::Pair(top, bottom),
            _ => Self::Combination,
        }
    }

    /// The coordinate that gives its place to the jump.
    fn coordinate(&self) -> Option<usize> {
        match self {
            Self::Coordinate(own) | Self::Pair(own, _) => Some(*own),
            Self::Held | Self::Combination => None,
        }
    }
}

/// Whether every row has a coordinate of its own that can give its place to the jump.
fn is_sparse(kinds: &[JumpRow]) -> bool {
    let mut own = BTreeSet::new();
    let is_own = |kind: &JumpRow| match kind {
        JumpRow::Combination => false,
        kind => kind.coordinate().is_none_or(|coordinate| own.insert(coordinate)),
    };
    let each = kinds.iter().all(is_own);
    let bottoms = kinds.iter().filter_map(|kind| match kind {
        JumpRow::Pair(_, bottom) => Some(bottom),
        _ => None,
    });
    each && !bottoms.into_iter().any(|bottom| own.contains(bottom))
}

/// Matrices and vectors over the coordinates of the caller.
struct CallerMatrices {
    stiffness: CsMat<f64>,
    mass: CsMat<f64>,
    jump: CsMat<f64>,
    loads: Vec<Vec<f64>>,
    recover: Vec<Vec<f64>>,
}

/// What is given, with the jump as coordinates.
struct Relative {
    system: RelativeSystem,
    recover: Vec<Vec<f64>>,
    /// Of each component of the jump, whether it is held.
    held: Vec<bool>,
}

impl CallerMatrices {
    fn system<'a>(&'a self, positions: &'a [[f64; 3]]) -> SystemMatrices<'a> {
        SystemMatrices {
            stiffness: &self.stiffness,
            mass: &self.mass,
            loads: &self.loads,
            positions,
        }
    }

    /// The same with the jump as coordinates.
    fn relative(mut self) -> Result<Relative, Exception> {
        let of_row = |row: usize| -> Vec<(usize, f64)> {
            let entries = self.jump.outer_view(row);
            let entries = entries
                .iter()
                .flat_map(|row| row.iter().map(|(column, value)| (column, *value)));
            entries.filter(|(_, value)| *value != 0.0).collect()
        };
        let kinds: Vec<JumpRow> = (0..self.jump.rows()).map(|row| JumpRow::new(&of_row(row))).collect();
        let held: Vec<bool> = kinds.iter().map(|kind| matches!(kind, JumpRow::Held)).collect();
        if held.iter().all(|held| *held) {
            return Err(input("jump is zero; at least one of its rows must have entries"));
        }
        let refused = |error: reduction::Error| input(format!("jump: {error}"));
        let relative = if is_sparse(&kinds) {
            self.replace_tops(&kinds);
            let coordinates: Vec<Option<usize>> = kinds.iter().map(JumpRow::coordinate).collect();
            let positions = vec![[0.0; 3]; self.stiffness.rows()];
            RelativeSystem::from_relative(self.system(&positions), &coordinates).map_err(refused)?
        } else {
            self.hold(&held);
            let n = self.stiffness.rows();
            if n > MOST_FULL {
                return Err(input(format!(
                    "jump combines coordinates, which takes full matrices: {n} coordinates are too many, at most {MOST_FULL} are \
                     taken; give rows that have one entry, 1, or two, 1 and -1, with a coordinate of its own for each 1"
                )));
            }
            RelativeSystem::from_combinations(self.system(&vec![[0.0; 3]; n]), &self.jump).map_err(refused)?
        };
        let recover = self.recover.iter().map(|row| relative.row(row)).collect();
        Ok(Relative {
            system: relative,
            recover,
            held,
        })
    }

    /// Puts the jump in the place of the top coordinate of each pair: `u_top = jump + u_bottom`.
    fn replace_tops(&mut self, kinds: &[JumpRow]) {
        let n = self.stiffness.rows();
        let mut change = TriMat::new((n, n));
        (0..n).for_each(|i| change.add_triplet(i, i, 1.0));
        for kind in kinds {
            if let JumpRow::Pair(top, bottom) = *kind {
                change.add_triplet(top, bottom, 1.0);
            }
        }
        let change: CsMat<f64> = change.to_csr();
        self.stiffness = congruence(&change, &self.stiffness);
        self.mass = congruence(&change, &self.mass);
        let transposed: CsMat<f64> = change.transpose_view().to_csr();
        for row in self.loads.iter_mut().chain(&mut self.recover) {
            *row = multiply_vector(&transposed, row);
        }
    }

    /// Adds a coordinate for each component of the jump that is held: stiff, without mass, and coupled to nothing.
    fn hold(&mut self, held: &[bool]) {
        let rows: Vec<usize> = (0..held.len()).filter(|&row| held[row]).collect();
        let n = self.stiffness.rows();
        let all = n + rows.len();
        let largest = diagonal(&self.stiffness).into_iter().fold(0.0, f64::max);
        let grown =
            |matrix: &CsMat<f64>, shape: (usize, usize), added: &mut dyn Iterator<Item = (usize, usize, f64)>| {
                let mut triplets = TriMat::new(shape);
                matrix
                    .iter()
                    .for_each(|(value, (i, j))| triplets.add_triplet(i, j, *value));
                added.for_each(|(i, j, value)| triplets.add_triplet(i, j, value));
                triplets.to_csr()
            };
        self.stiffness = grown(&self.stiffness, (all, all), &mut (n..all).map(|i| (i, i, largest)));
        self.mass = grown(&self.mass, (all, all), &mut std::iter::empty());
        let own = rows.iter().zip(n..).map(|(&row, column)| (row, column, 1.0));
        self.jump = grown(&self.jump, (held.len(), all), &mut { own });
        self.loads
            .iter_mut()
            .chain(&mut self.recover)
            .for_each(|row| row.resize(all, 0.0));
    }
}

/// What a reduction retains.
#[derive(Clone, Copy)]
struct Retained {
    /// All if it is not given.
    n_modes: Option<usize>,
    zero_energy_modes: usize,
    attachment_modes: bool,
}

/// Condenses onto the jump and the modes of the stuck structure.
fn condense(relative: &RelativeSystem, recover: &[Vec<f64>], retained: Retained) -> Result<ReducedModel, Exception> {
    let (n, nd) = (relative.stiffness.rows(), relative.n_relative);
    if n == nd {
        // Nothing to reduce.
        return Ok(ReducedModel {
            mass: full(&relative.mass).into(),
            stiffness: full(&relative.stiffness).into(),
            loads: relative.loads.clone(),
            n_relative: nd,
            n_attachment: 0,
            recovery: Mat::from_fn(recover.len(), n, |i, j| recover[i][j]),
            stuck_frequencies: Vec::new(),
            zem_stuck: 0,
            asymmetry: 0.0,
        });
    }
    let n_modes = match retained.n_modes {
        Some(n_modes) => n_modes,
        None if n - nd > MOST_FULL => {
            return Err(input(format!(
                "n_modes is not given, but the stuck structure has {} coordinates; give the number of modes to retain",
                n - nd
            )));
        }
        None => n - nd,
    };
    let settings = Settings {
        n_modes,
        n_reported: n_modes,
        expected_zem: retained.zero_energy_modes,
        attachment_modes: retained.attachment_modes,
        ..Settings::default()
    };
    reduce(relative, recover, settings, reduction::Limits::default()).map_err(|error| match error {
        reduction::Error::ZeroEnergyModes { .. } => input(format!("zero_energy_modes: {error}")),
        reduction::Error::UnbalancedLoad { .. } | reduction::Error::DependentLoad { .. } => {
            input(format!("load: {error}"))
        }
        error => solver(error.to_string()),
    })
}

#[pymethods]
impl Structure {
    #[new]
    fn new(
        py: Python<'_>,
        stiffness: &Bound<'_, PyAny>,
        mass: &Bound<'_, PyAny>,
        jump: &Bound<'_, PyAny>,
        areas: &Bound<'_, PyAny>,
        law: &Law,
        gap: &Bound<'_, PyAny>,
        interference: &Bound<'_, PyAny>,
        loads: &Bound<'_, PyAny>,
        recover: &Bound<'_, PyAny>,
        n_modes: Option<usize>,
        zero_energy_modes: usize,
        attachment_modes: Option<bool>,
        threads: Option<i64>,
    ) -> PyResult<Self> {
        let stiffness = semi_definite("stiffness", stiffness, None)?;
        let n = stiffness.rows();
        let mass = semi_definite("mass", mass, Some(n))?;
        let law = Arc::clone(&law.law);
        let n_points = law.len();
        let jump = matrix("jump", jump)?;
        check_shape("jump", &[jump.rows(), jump.cols()], &[3 * n_points, n])?;
        let given = CallerMatrices {
            loads: vectors("load", loads, n)?,
            recover: vectors("recover", recover, n)?,
            stiffness,
            mass,
            jump,
        };
        let (areas, gap, interference) = (
            per_point("areas", areas, n_points)?,
            per_point("gap", gap, n_points)?,
            per_point("interference", interference, n_points)?,
        );
        let pool = pool(threads)?;
        let made = supervise(py, &pool, None, |_| -> Result<Self, Exception> {
            let Relative {
                system: relative,
                recover,
                held,
            } = given.relative()?;
            let nd = relative.n_relative;
            // A load on the jump alone needs none.
            let bends = |load: &Vec<f64>| load[nd..].iter().any(|force| *force != 0.0);
            let attachment_modes =
                attachment_modes.unwrap_or_else(|| !relative.loads.is_empty() && relative.loads.iter().all(bends));
            let retained = Retained {
                n_modes,
                zero_energy_modes,
                attachment_modes,
            };
            let reduced = condense(&relative, &recover, retained)?;
            let contact = |point: usize| PointContact {
                area: areas[point],
                held: std::array::from_fn(|component| held[3 * point + component]),
            };
            let elements = (0..n_points).map(|point| Element::point(point as u32, contact(point)));
            let mesh = InterfaceMesh::flat(
                (0..n_points).map(|point| [point as f64, 0.0]).collect(),
                elements.collect(),
            );
            let interface = Operators::try_new(&mesh, 1)
                .and_then(|operators| Interface::try_new(Arc::new(operators), vec![(0..n_points, law)], gap))
                .and_then(|interface| interface.with_interference(interference))
                .map_err(|error| input(error.to_string()))?;
            Ok(Self {
                reduced,
                interface,
                held,
            })
        })?;
        Ok(made?)
    }

    /// The reduced matrices without the components of the jump that are held, and what goes with them.
    fn reduced<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let reduced = &self.reduced;
        let n = reduced.size();
        let kept: Vec<usize> = (0..n)
            .filter(|&i| !self.held.get(i).is_some_and(|held| *held))
            .collect();
        let square = |matrix: &SystemMatrix| {
            let matrix = matrix.as_ref().to_dense();
            let at = |i: usize, j: usize| matrix[(i, j)];
            let values = kept.iter().flat_map(|&i| kept.iter().map(move |&j| at(i, j)));
            rows(py, values.collect(), kept.len())
        };
        let found = PyDict::new(py);
        found.set_item("stiffness", square(&reduced.stiffness)?)?;
        found.set_item("mass", square(&reduced.mass)?)?;
        let over = |count: usize, value: &dyn Fn(usize, usize) -> f64| {
            let values: Vec<f64> = (0..count)
                .flat_map(|i| kept.iter().map(move |&j| value(i, j)))
                .collect();
            PyArray1::from_vec(py, values).reshape([count, kept.len()])
        };
        found.set_item("loads", over(reduced.loads.len(), &|i, j| reduced.loads[i][j])?)?;
        found.set_item(
            "recovery",
            over(reduced.recovery.nrows(), &|i, j| reduced.recovery[(i, j)])?,
        )?;
        // The rows of the jump that are not held, in the order of the coordinates.
        let jump_rows: Vec<usize> = kept.iter().copied().filter(|&i| i < reduced.n_relative).collect();
        found.set_item("jump_rows", jump_rows)?;
        found.set_item("n_modes", reduced.n_modes())?;
        found.set_item("n_attachment_modes", reduced.n_attachment)?;
        found.set_item("stuck_frequency_hz", list(py, reduced.stuck_frequencies.clone()))?;
        found.set_item("zero_energy_modes", reduced.zem_stuck)?;
        found.set_item("asymmetry", reduced.asymmetry)?;
        Ok(found)
    }
}

/// What analyses begin with.
pub(super) struct Begin {
    /// Guess of the closure under the static load (m).
    pub(super) closure: Option<f64>,
    pub(super) newton: NewtonSettings,
    /// Linear modes.
    pub(super) n_modes: usize,
}

/// A static state, with what happens at the points.
pub(super) struct StaticState {
    pub(super) solution: Prestress<State>,
    jump: [Vec<f64>; 3],
    traction: [Vec<f64>; 3],
    regimes: Vec<u8>,
}

impl Structure {
    pub(super) fn force(&self) -> InterfaceForce<'_> {
        InterfaceForce::new(&self.interface)
    }

    pub(super) fn row(&self, number: usize) -> Option<Vec<f64>> {
        let recovery = &self.reduced.recovery;
        (number < recovery.nrows()).then(|| recovery.row(number).iter().copied().collect())
    }

    /// Equilibrium under the static load.
    pub(super) fn rest(&self, begin: &Begin) -> Result<Result<StaticState, Failure>, Exception> {
        let (reduced, nd) = (&self.reduced, self.reduced.n_relative);
        let n = reduced.size();
        let mut load = vec![0.0; n];
        for own in &reduced.loads {
            load.iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
        }
        let pressing: f64 = load[..nd].iter().skip(2).step_by(3).sum();
        let closure = match begin.closure {
            Some(closure) if !closure.is_finite() => {
                return Err(input(format!("closure is {closure}; it must be finite")));
            }
            Some(closure) => closure,
            None if pressing > 0.0 => {
                uniform_closure(&self.interface, pressing).map_err(|error| input(format!("load: {error}")))?
            }
            None => 0.0,
        };
        let mut start = vec![0.0; n];
        start[..nd].iter_mut().skip(2).step_by(3).for_each(|u| *u = closure);
        let force = self.force();
        let solved = prestress::solve(reduced.stiffness.as_ref(), &force, &load, &start, &begin.newton);
        Ok(solved.map_err(of_solver)?.map(|solution| self.describe(solution)))
    }

    fn describe(&self, solution: Prestress<State>) -> StaticState {
        let interface = &self.interface;
        let mut workspace = interface.workspace();
        let (mut end, mut contact) = (solution.state.clone(), vec![0.0; interface.n_dofs()]);
        interface.evaluate(
            &solution.displacement[..interface.n_dofs()],
            cqsma_solver::Sticking::Coulomb,
            &solution.state,
            &mut end,
            &mut workspace,
            &mut contact,
            None,
        );
        StaticState {
            solution,
            jump: workspace.jump,
            traction: workspace.traction,
            regimes: workspace.regime.into_iter().map(crate::laws::regime_number).collect(),
        }
    }

    /// The structure linearised about a static state, with as many modes as are asked for or as have mass.
    pub(super) fn linearise(&self, begin: &Begin, rest: &StaticState) -> Result<Linearisation<'_, State>, Exception> {
        let (stiffness, mass) = (self.reduced.stiffness.as_ref(), self.reduced.mass.as_ref());
        let rank = dense_algebra::rank(mass.to_dense().as_ref()).map_err(|error| solver(error.to_string()))?;
        let solution = &rest.solution;
        let mut line = modes::linearise(
            stiffness,
            mass,
            &self.force(),
            solution.displacement.clone(),
            solution.state.clone(),
            begin.n_modes.clamp(1, rank.max(1)),
        )
        .map_err(|error| match error {
            // There are as many modes: what fails is the stiffness.
            cqsma_solver::Error::Setting { .. } => solver(
                "the modes of the structure with all that is in contact stuck cannot be computed: it can move freely, or nearly so",
            ),
            error => of_solver(error),
        })?;
        if let Some(response) = self.row(0) {
            line.orient(&response).map_err(of_solver)?;
        }
        Ok(line)
    }
}

/// An error of cqsma-solver: settings are arguments.
pub(super) fn of_solver(error: cqsma_solver::Error) -> Exception {
    match error {
        cqsma_solver::Error::Setting { .. } => input(error.to_string()),
        error => solver(error.to_string()),
    }
}

impl StaticState {
    /// As arrays.
    pub(super) fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        let points = self.regimes.len();
        let field = |of: &[Vec<f64>; 3]| rows(py, of.concat(), points);
        found.set_item("jump", field(&self.jump)?)?;
        found.set_item("traction", field(&self.traction)?)?;
        found.set_item("regime", PyArray1::from_slice(py, &self.regimes))?;
        found.set_item("residual", self.solution.residual)?;
        found.set_item("iterations", self.solution.iterations.iter().sum::<usize>())?;
        Ok(found)
    }
}

/// Frequencies of linear modes, and what they do at the rows that are recovered.
pub(super) fn linear_modes<'py>(
    py: Python<'py>,
    recovery: MatRef<'_, f64>,
    frequencies: Vec<f64>,
    shapes: MatRef<'_, f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    let count = frequencies.len();
    found.set_item("frequency_hz", list(py, frequencies))?;
    let along = dense_algebra::product(recovery, shapes);
    let values: Vec<f64> = along
        .row_iter()
        .flat_map(|row| row.iter().copied().collect::<Vec<f64>>())
        .collect();
    found.set_item(
        "shapes",
        PyArray1::from_vec(py, values).reshape([recovery.nrows(), count])?,
    )?;
    Ok(found)
}
