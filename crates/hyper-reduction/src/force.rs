//! The contact over few coordinates, from few of its points.

use contact_laws::{Components, ComponentsMut, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut};
use cqsma_solver::{HystereticForce, PatternView};
use dense_algebra::product_into;
use faer::{Mat, MatRef};
use zte_assembly::{Batches, Interface, State};

/// The points that stand for an interface.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectedPoints {
    /// Their numbers, ascending.
    pub points: Vec<usize>,
    /// What the area of each counts by (-).
    pub factors: Vec<f64>,
}

/// Pattern of the tangent of an interface.
pub(crate) fn pattern_of(interface: &Interface) -> PatternView<'_> {
    let pattern = interface.pattern();
    PatternView {
        indptr: &pattern.indptr,
        indices: &pattern.indices,
    }
}

/// Jumps at all points, component by component and without the gap, of a motion whose leading numbers are nodal jumps.
pub(crate) fn at_points(interface: &Interface, motion: &[f64]) -> [Vec<f64>; 3] {
    let mut all: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; interface.operators().n_points()]);
    let nodal = &motion[..interface.n_dofs()];
    interface.interpolate(nodal, all.each_mut().map(Vec::as_mut_slice));
    all
}

/// The forces of an interface over the coordinates of a basis, about a static state: those of the stuck interface from all points, and what
/// the forces depart from them by from some.
pub struct PointForce<'a> {
    interface: &'a Interface,
    batches: Batches,
    /// Where the history of each batch begins.
    states: Vec<usize>,
    /// Area that each point stands for (m^2).
    areas: Vec<f64>,
    /// Jumps at the points in the static state, the gap subtracted (m): x of all points, then y, then n.
    at_rest: Vec<f64>,
    /// Change of these per coordinate, `3 points x coordinates`.
    jumps: Mat<f64>,
    /// What the stuck interface is stiffer by than its points make it (N/m).
    rest: Mat<f64>,
    indptr: Vec<usize>,
    indices: Vec<usize>,
    state: Vec<f64>,
}

/// Scratch memory of an evaluation.
#[derive(Clone)]
pub struct Scratch {
    jump: Vec<f64>,
    traction: Vec<f64>,
    tangent: [Vec<f64>; 9],
    rows: Mat<f64>,
    product: Mat<f64>,
}

impl<'a> PointForce<'a> {
    /// About the static state with the nodal `jump` (m) and the history `state`. The leading rows of `basis` are the nodal jumps of each
    /// coordinate; `stuck` is the symmetrised tangent of the stuck interface over its pattern (N/m).
    ///
    /// # Panics
    /// If the basis has fewer rows than the interface has coordinates, or a slice another length; if a point is not one of the interface.
    pub fn new(
        interface: &'a Interface,
        selected: &SelectedPoints,
        basis: MatRef<'_, f64>,
        jump: &[f64],
        state: &State,
        stuck: &[f64],
    ) -> Self {
        let (n, coordinates) = (interface.n_dofs(), basis.ncols());
        let operators = interface.operators();
        let at_selected = |nodal: &[f64]| -> Vec<f64> {
            let fields = at_points(interface, nodal);
            let of_field = |field: &Vec<f64>| selected.points.iter().map(|&p| field[p]).collect::<Vec<_>>();
            fields.iter().flat_map(of_field).collect()
        };
        let mut at_rest = at_selected(jump);
        if let Some(gap) = interface.gap() {
            let normals = &mut at_rest[2 * selected.points.len()..];
            normals
                .iter_mut()
                .zip(&selected.points)
                .for_each(|(n, &p)| *n -= gap[p]);
        }
        let columns: Vec<Vec<f64>> = basis
            .col_iter()
            .map(|column| column.iter().take(n).copied().collect())
            .collect();
        let of_columns: Vec<Vec<f64>> = columns.iter().map(|column| at_selected(column)).collect();
        let batches = interface.batches_of(&selected.points);
        let (mut states, mut history) = (Vec::new(), Vec::new());
        for (batch, points) in batches.points().iter().enumerate() {
            states.push(history.len());
            let mut own = vec![0.0; points.len() * interface.batch_states(&batches, batch)];
            interface.copy_state(&batches, batch, state, &mut own);
            history.append(&mut own);
        }
        let areas = selected.points.iter().zip(&selected.factors);
        let mut force = Self {
            interface,
            batches,
            states,
            areas: areas.map(|(&p, factor)| factor * operators.weights[p]).collect(),
            at_rest,
            jumps: Mat::from_fn(3 * selected.points.len(), coordinates, |i, k| of_columns[k][i]),
            rest: Mat::zeros(coordinates, coordinates),
            indptr: (0..=coordinates).map(|row| row * coordinates).collect(),
            indices: (0..coordinates * coordinates).map(|k| k % coordinates).collect(),
            state: history,
        };
        force.rest = force.missing(&columns, stuck);
        force
    }

    /// What the stuck tangent of all points has more than that of the selected ones; `columns` are the nodal jumps of the coordinates.
    fn missing(&self, columns: &[Vec<f64>], stuck: &[f64]) -> Mat<f64> {
        let (n, coordinates) = (self.interface.n_dofs(), columns.len());
        let pattern = pattern_of(self.interface);
        let image = |column: &Vec<f64>| {
            let mut image = vec![0.0; n];
            pattern.add_product(stuck, column, &mut image);
            image
        };
        let images: Vec<Vec<f64>> = columns.iter().map(image).collect();
        let mut end = self.state.clone();
        let mut tangent = vec![0.0; coordinates * coordinates];
        self.evaluate(
            &vec![0.0; coordinates],
            Sticking::Full,
            &self.state,
            &mut end,
            &mut self.workspace(),
            &mut vec![0.0; coordinates],
            Some(&mut tangent),
        );
        Mat::from_fn(coordinates, coordinates, |i, j| {
            let whole: f64 = columns[i].iter().zip(&images[j]).map(|(a, b)| a * b).sum();
            whole - 0.5 * (tangent[i * coordinates + j] + tangent[j * coordinates + i])
        })
    }

    /// History of the points in the static state.
    pub fn state(&self) -> Vec<f64> {
        self.state.clone()
    }

    fn coordinates(&self) -> usize {
        self.jumps.ncols()
    }

    /// Tractions, and on request tangents, of all points at the jumps in the scratch memory.
    fn evaluate_points(
        &self,
        sticking: Sticking,
        begin: &[f64],
        end: &mut [f64],
        scratch: &mut Scratch,
        with_tangent: bool,
    ) -> RegimeCounts {
        let jump = Components::stacked(&scratch.jump);
        let traction = ComponentsMut::stacked(&mut scratch.traction);
        let mut counts = RegimeCounts::default();
        let mut first = 0;
        for (batch, points) in self.batches.points().iter().enumerate() {
            let own = first..first + points.len();
            first = own.end;
            let size = points.len() * self.interface.batch_states(&self.batches, batch);
            let states = self.states[batch]..self.states[batch] + size;
            let entries = scratch.tangent.each_mut().map(|entry| &mut entry[own.clone()]);
            counts += self.interface.evaluate_batch(
                &self.batches,
                batch,
                sticking,
                Components::new(&jump.x[own.clone()], &jump.y[own.clone()], &jump.n[own.clone()]),
                StateView::new(&begin[states.clone()], points.len(), 0),
                StateViewMut::new(&mut end[states], points.len(), 0),
                ComponentsMut::new(
                    &mut traction.x[own.clone()],
                    &mut traction.y[own.clone()],
                    &mut traction.n[own],
                ),
                with_tangent.then(|| TangentMut::from_entries(entries)),
            );
        }
        counts
    }

    /// Sum over the points of the tangents in the scratch memory, and the rest.
    fn assemble(&self, scratch: &mut Scratch, tangent: &mut [f64]) {
        let (n, coordinates) = (self.areas.len(), self.coordinates());
        for (from, mut to) in self.jumps.col_iter().zip(scratch.rows.col_iter_mut()) {
            for (row, entries) in scratch.tangent.chunks_exact(3).enumerate() {
                for (p, area) in self.areas.iter().enumerate() {
                    let sum: f64 = (0..3).map(|c| entries[c][p] * from[c * n + p]).sum();
                    to[row * n + p] = area * sum;
                }
            }
        }
        product_into(scratch.product.as_mut(), self.jumps.transpose(), scratch.rows.as_ref());
        for (i, row) in tangent.chunks_exact_mut(coordinates).enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value = scratch.product[(i, j)] + self.rest[(i, j)];
            }
        }
    }
}

impl HystereticForce for PointForce<'_> {
    type State = Vec<f64>;
    type Workspace = Scratch;

    fn n_dofs(&self) -> usize {
        self.coordinates()
    }

    fn pattern(&self) -> PatternView<'_> {
        PatternView {
            indptr: &self.indptr,
            indices: &self.indices,
        }
    }

    fn initial_state(&self) -> Vec<f64> {
        self.state()
    }

    fn workspace(&self) -> Scratch {
        let (n, coordinates) = (self.areas.len(), self.coordinates());
        Scratch {
            jump: vec![0.0; 3 * n],
            traction: vec![0.0; 3 * n],
            tangent: std::array::from_fn(|_| vec![0.0; n]),
            rows: Mat::zeros(3 * n, coordinates),
            product: Mat::zeros(coordinates, coordinates),
        }
    }

    fn slips_in_parts(&self) -> bool {
        self.interface.slips_in_parts()
    }

    fn dissipates(&self) -> bool {
        self.interface.dissipates()
    }

    fn evaluate(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &Vec<f64>,
        end: &mut Vec<f64>,
        workspace: &mut Scratch,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        workspace.jump.copy_from_slice(&self.at_rest);
        for (column, u) in self.jumps.col_iter().zip(u) {
            let pairs = workspace.jump.iter_mut().zip(column.iter());
            pairs.for_each(|(jump, per_coordinate)| *jump += per_coordinate * u);
        }
        let counts = self.evaluate_points(sticking, begin, end, workspace, tangent.is_some());
        for component in workspace.traction.chunks_exact_mut(self.areas.len().max(1)) {
            component.iter_mut().zip(&self.areas).for_each(|(t, area)| *t *= area);
        }
        for (k, force) in force.iter_mut().enumerate() {
            let of_points = self.jumps.col(k).iter().zip(&workspace.traction);
            let of_rest = self.rest.col(k).iter().zip(u);
            *force = of_points.chain(of_rest).map(|(a, b)| a * b).sum();
        }
        if let Some(tangent) = tangent {
            self.assemble(workspace, tangent);
        }
        counts
    }
}
