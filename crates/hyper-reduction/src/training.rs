//! What loops of the whole joint teach: coordinates, and points.

use crate::error::Error;
use crate::force::{SelectedPoints, at_points, pattern_of};
use crate::quadrature::{Selection, select};
use contact_laws::Sticking;
use cqsma_solver::{Linearisation, LoopObserver, PatternView};
use dense_algebra::{SystemMatrixRef, product, symmetric_eigen};
use faer::{Mat, MatRef};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use zte_assembly::flux::LoopArea;
use zte_assembly::{Interface, State, Workspace};

/// Rows of a sketch per point that may be selected. Random sums of that many rows tell apart what so many columns span.
const SKETCH: usize = 3;

/// Rows of a sketch beside.
const MORE_ROWS: usize = 100;

/// Places of a sketch that a row is added to.
const COPIES: usize = 8;

/// Equal seeds give equal sketches.
const SEED: u64 = 1;

/// Most points that are selected: the sketch has three rows for each.
const MOST_POINTS: usize = 1000;

/// Most edges of a quarter of a loop that motions are learned from.
const EDGES: usize = 4;

/// How much is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Part of the motions beside the mode (energy norm, root mean square over all vertices) that the coordinates may leave out.
    pub motion_tolerance: f64,
    /// Error of the works that points may leave, relative.
    pub work_tolerance: f64,
    /// Largest part of the points that may be selected.
    pub most_points: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            motion_tolerance: 5e-3,
            work_tolerance: 1e-4,
            most_points: 1.0 / 3.0,
        }
    }
}

/// Share of a coordinate in the squares of all motions below which it is made of round-off.
const INDEPENDENT: f64 = 1e-12;

/// Part of the tolerance that is tried for; what is reached may be worse by as much.
const SLACK: f64 = 10.0;

/// The points of an interface in the static state that loops start from.
#[derive(Clone, Debug)]
pub struct StaticState {
    jump: [Vec<f64>; 3],
    traction: [Vec<f64>; 3],
    /// Symmetrised tangent entries of the stuck contact (Pa/m).
    tangent: [Vec<f64>; 9],
    displacement: Vec<f64>,
}

impl StaticState {
    /// That of a linearised structure.
    pub fn new(interface: &Interface, structure: &Linearisation<'_, State>) -> Self {
        let n = interface.n_dofs();
        let (jump, state) = (&structure.displacement()[..n], structure.state());
        let mut workspace = interface.workspace();
        let (mut force, mut end) = (vec![0.0; n], state.clone());
        let mut values = vec![0.0; interface.pattern().indices.len()];
        interface.evaluate(
            jump,
            Sticking::Full,
            state,
            &mut end,
            &mut workspace,
            &mut force,
            Some(&mut values),
        );
        let entries = workspace.tangent();
        let tangent = std::array::from_fn(|k| {
            let mirror = entries[3 * (k % 3) + k / 3];
            entries[k].iter().zip(mirror).map(|(a, b)| 0.5 * (a + b)).collect()
        });
        interface.evaluate(
            jump,
            Sticking::Coulomb,
            state,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        Self {
            jump: workspace.jump,
            traction: workspace.traction,
            tangent,
            displacement: structure.displacement().to_vec(),
        }
    }
}

/// A loop of the whole joint.
#[derive(Clone, Debug, Default)]
pub struct LoopRecord {
    /// Displacements from the static state at the vertices (m).
    increments: Vec<Vec<f64>>,
    /// What the tractions at the points depart by from those of the stuck interface (Pa).
    departures: Vec<[Vec<f64>; 3]>,
    /// Energy that each point takes (J).
    dissipation: Vec<f64>,
}

/// Records a loop: the work of all its vertices, and the motion at some of them.
pub struct Recorder<'a> {
    interface: &'a Interface,
    /// Vertices from one that is recorded to the next, and those seen so far.
    stride: usize,
    seen: usize,
    at_rest: &'a StaticState,
    area: LoopArea,
    record: LoopRecord,
}

impl<'a> Recorder<'a> {
    /// Of an interface from its static state; loops have so many vertices per quarter.
    pub fn new(interface: &'a Interface, at_rest: &'a StaticState, vertices_per_quarter: usize) -> Self {
        Self {
            interface,
            stride: vertices_per_quarter.div_ceil(EDGES).max(1),
            seen: 0,
            at_rest,
            area: LoopArea::new(interface.operators().n_points()),
            record: LoopRecord::default(),
        }
    }

    /// What was recorded of a loop whose damping is resolved.
    pub fn finish(self) -> LoopRecord {
        LoopRecord {
            dissipation: dissipation(self.interface, self.area),
            ..self.record
        }
    }
}

/// Energy that each point takes in a closed loop (J).
pub(crate) fn dissipation(interface: &Interface, area: LoopArea) -> Vec<f64> {
    let [x, y, n] = area.close();
    let weights = &interface.operators().weights;
    (0..weights.len()).map(|p| weights[p] * (x[p] + y[p] + n[p])).collect()
}

impl LoopObserver<Workspace> for Recorder<'_> {
    fn begin(&mut self) {
        self.record = LoopRecord::default();
        self.seen = 0;
        self.area = LoopArea::new(self.interface.operators().n_points());
    }

    fn vertex(&mut self, _: f64, displacement: &[f64], workspace: &Workspace) {
        let at_rest = self.at_rest;
        self.area.add(workspace);
        self.seen += 1;
        if !(self.seen - 1).is_multiple_of(self.stride) {
            return;
        }
        let Workspace { jump, traction, .. } = workspace;
        let departure = |i: usize, p: usize| {
            let stuck: f64 = (0..3)
                .map(|j| at_rest.tangent[3 * i + j][p] * (jump[j][p] - at_rest.jump[j][p]))
                .sum();
            traction[i][p] - at_rest.traction[i][p] - stuck
        };
        let points = 0..jump[0].len();
        self.record.departures.push(std::array::from_fn(|i| {
            points.clone().map(|p| departure(i, p)).collect()
        }));
        let increment = displacement.iter().zip(&at_rest.displacement).map(|(u, u0)| u - u0);
        self.record.increments.push(increment.collect());
    }
}

/// A mode of a training case, and its loops.
#[derive(Clone, Debug)]
pub struct TrainingMode {
    /// Mass-normalised shape.
    shape: Vec<f64>,
    /// Mass times shape.
    inertia: Vec<f64>,
    /// Angular frequency (rad/s).
    omega: f64,
    /// Symmetrised tangent of the stuck interface over its pattern (N/m).
    stuck: Vec<f64>,
    at_rest: StaticState,
    loops: Vec<LoopRecord>,
    /// Loops of which the damping is not resolved.
    quiet: usize,
}

impl TrainingMode {
    /// Mode number `mode`, zero-based, with the loops whose damping is resolved, and the number of those where it is not.
    ///
    /// # Errors
    /// [`Error::Size`] for a mode that the structure does not have.
    pub fn try_new(
        structure: &Linearisation<'_, State>,
        at_rest: StaticState,
        mode: usize,
        loops: Vec<LoopRecord>,
        quiet: usize,
    ) -> Result<Self, Error> {
        let (shape, inertia, omega) = shape_of(structure, mode)?;
        Ok(Self {
            shape,
            inertia,
            omega,
            stuck: structure.stuck_tangent().to_vec(),
            at_rest,
            loops,
            quiet,
        })
    }

    /// The loops that dissipate, each with the mode.
    fn training_cases(&self) -> impl Iterator<Item = (&Self, &LoopRecord)> {
        let dissipate = self
            .loops
            .iter()
            .filter(|record| record.dissipation.iter().sum::<f64>() > 0.0);
        dissipate.map(move |record| (self, record))
    }

    /// Part of a motion that is mass-orthogonal to the mode, and the coordinate of the mode.
    fn beside(&self, motion: &[f64]) -> (Vec<f64>, f64) {
        let q: f64 = self.inertia.iter().zip(motion).map(|(a, b)| a * b).sum();
        let rest = motion.iter().zip(&self.shape).map(|(v, phi)| v - q * phi);
        (rest.collect(), q)
    }
}

/// Shape of a mode, mass times shape, and angular frequency.
pub(crate) fn shape_of(structure: &Linearisation<'_, State>, mode: usize) -> Result<(Vec<f64>, Vec<f64>, f64), Error> {
    let Some(eigenvalue) = structure.eigenvalues.get(mode) else {
        return Err(Error::Size {
            what: "the list of modes",
            found: structure.eigenvalues.len(),
            expected: mode + 1,
        });
    };
    let shape = structure.shapes.get(.., mode..mode + 1);
    let inertia = structure.mass().product(shape);
    let values = |column: MatRef<'_, f64>| column.col(0).iter().copied().collect();
    Ok((values(shape), values(inertia.as_ref()), eigenvalue.sqrt()))
}

/// What was learned: coordinates beside the mode, and points.
#[derive(Clone, Debug, PartialEq)]
pub struct Trained {
    /// Motions of the coordinates, orthonormal in the energy of the stuck structure, one per column.
    pub basis: Mat<f64>,
    /// Points of contact.
    pub points: SelectedPoints,
    /// Points that they stand for.
    pub of_points: usize,
    /// What the points leave of the works of the training, relative.
    pub residual: f64,
    /// Loops that were learned from.
    pub loops: usize,
}

/// Learns from modes of several cases on one structure with this stiffness, all of them the same mode. Round-off depends on their order.
///
/// # Errors
/// [`Error::NothingSlips`], [`Error::TooFewPoints`]; [`Error::Size`] for cases of another structure.
pub fn train<'a>(
    interface: &Interface,
    stiffness: impl Into<SystemMatrixRef<'a>>,
    modes: &[TrainingMode],
    settings: &Settings,
) -> Result<Trained, Error> {
    let stiffness = stiffness.into();
    let (n, of_points) = (stiffness.size(), interface.operators().n_points());
    for mode in modes {
        let sizes = [
            ("the mode shape of a training case", mode.shape.len(), n),
            (
                "the interface of a training case",
                mode.at_rest.jump[0].len(),
                of_points,
            ),
        ];
        if let Some((what, found, expected)) = sizes.into_iter().find(|(_, found, expected)| found != expected) {
            return Err(Error::Size { what, found, expected });
        }
    }
    let training_cases = || modes.iter().flat_map(TrainingMode::training_cases);
    let loops = training_cases().count();
    if loops == 0 {
        return Err(Error::NothingSlips {
            loops: modes.iter().map(|mode| mode.loops.len() + mode.quiet).sum(),
        });
    }
    let energy = Energy {
        stiffness,
        pattern: pattern_of(interface),
        stuck: &modes[0].stuck,
    };
    let coordinates = Coordinates::new(&energy, training_cases(), settings.motion_tolerance)?;
    let most = ((settings.most_points * of_points as f64) as usize).min(MOST_POINTS);
    let mut sketch = Sketch::new(SKETCH * most + MORE_ROWS, of_points);
    let columns = coordinates.basis.col_iter();
    let of_basis: Vec<_> = columns
        .map(|column| at_points(interface, &column.iter().copied().collect::<Vec<_>>()))
        .collect();
    let weights = &interface.operators().weights;
    for (mode, record) in training_cases() {
        works(
            &mut sketch,
            weights,
            mode,
            record,
            &coordinates,
            &of_basis,
            &at_points(interface, &mode.shape),
            loops,
        );
    }
    for mode in modes {
        stuck_works(
            &mut sketch,
            weights,
            mode,
            &of_basis,
            &at_points(interface, &mode.shape),
            modes.len(),
        );
    }
    let rows = sketch.rows;
    let target: Vec<f64> = (0..rows.nrows()).map(|i| rows.row(i).iter().sum()).collect();
    let Selection {
        columns: points,
        weights: factors,
        residual,
    } = select(rows.as_ref(), &target, most, settings.work_tolerance);
    // What is not a number is no small error.
    if !(residual <= SLACK * settings.work_tolerance) {
        return Err(Error::TooFewPoints {
            points: points.len(),
            of: of_points,
            reached: residual,
            wanted: SLACK * settings.work_tolerance,
        });
    }
    Ok(Trained {
        basis: coordinates.basis,
        points: SelectedPoints { points, factors },
        of_points,
        residual,
        loops,
    })
}

/// The energy of the stuck structure of a case, in which all are measured.
struct Energy<'a> {
    stiffness: SystemMatrixRef<'a>,
    pattern: PatternView<'a>,
    stuck: &'a [f64],
}

impl Energy<'_> {
    /// Forces that hold motions, one per column.
    fn forces(&self, motions: MatRef<'_, f64>) -> Mat<f64> {
        let mut forces = self.stiffness.product(motions);
        for (motion, force) in motions.col_iter().zip(forces.col_iter_mut()) {
            let motion: Vec<f64> = motion.iter().copied().collect();
            let mut contact = vec![0.0; motion.len()];
            self.pattern.add_product(self.stuck, &motion, &mut contact);
            force.iter_mut().zip(contact).for_each(|(sum, own)| *sum += own);
        }
        forces
    }
}

/// Coordinates beside the mode, and the forces that hold their motions: `forces^T basis` is the identity.
struct Coordinates {
    basis: Mat<f64>,
    forces: Mat<f64>,
}

impl Coordinates {
    /// Proper orthogonal decomposition of the motions beside the modes, of which those of each loop count relative to the largest: slip at small
    /// amplitudes has a shape of its own, and damping at small amplitudes depends on that.
    fn new<'a>(
        energy: &Energy<'_>,
        training_cases: impl Iterator<Item = (&'a TrainingMode, &'a LoopRecord)>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (mode, record) in training_cases {
            let own: Vec<Vec<f64>> = record.increments.iter().map(|v| mode.beside(v).0).collect();
            let motions = Mat::from_fn(mode.shape.len(), own.len(), |i, j| own[j][i]);
            let forces = energy.forces(motions.as_ref());
            let energies = motions.col_iter().zip(forces.col_iter());
            let energies = energies.map(|(v, p)| v.iter().zip(p.iter()).map(|(v, p)| v * p).sum::<f64>());
            let largest = energies.fold(0.0, f64::max).sqrt();
            if largest > 0.0 {
                columns.extend(own.into_iter().map(|v| v.into_iter().map(|v| v / largest).collect()));
            }
        }
        let motions = Mat::from_fn(energy.stiffness.size(), columns.len(), |i, j| columns[j][i]);
        drop(columns);
        let forces = energy.forces(motions.as_ref());
        let (values, vectors) = symmetric_eigen(product(motions.transpose(), forces.as_ref()).as_ref())?;
        let total: f64 = values.iter().map(|value| value.max(0.0)).sum();
        let mut left = total;
        let mut kept = Vec::new();
        for (place, value) in values.iter().enumerate().rev() {
            if !(left > tolerance * tolerance * total && *value > INDEPENDENT * total) {
                break;
            }
            left -= value;
            kept.push((place, value.sqrt()));
        }
        let chosen = Mat::from_fn(values.len(), kept.len(), |i, k| vectors[(i, kept[k].0)] / kept[k].1);
        Ok(Self {
            basis: product(motions.as_ref(), chosen.as_ref()),
            forces: product(forces.as_ref(), chosen.as_ref()),
        })
    }
}

/// Random sums of rows, which stand for the rows themselves in least squares: each row is added to a few places with random signs.
struct Sketch {
    rows: Mat<f64>,
    random: Pcg64,
}

impl Sketch {
    fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows: Mat::zeros(rows, columns),
            random: Pcg64::seed_from_u64(SEED),
        }
    }

    fn add(&mut self, row: &[f64]) {
        for _ in 0..COPIES {
            let bits = self.random.next_u64();
            let place = ((bits >> 1) % self.rows.nrows() as u64) as usize;
            let size = (COPIES as f64).sqrt().recip();
            let sign = if bits & 1 == 0 { size } else { -size };
            let places = self.rows.row_mut(place);
            places.iter_mut().zip(row).for_each(|(sum, value)| *sum += sign * value);
        }
    }
}

/// Fields at all points, component by component.
type Field = [Vec<f64>; 3];

/// Adds what departures of the tractions do along each coordinate as far as that goes in the loop, and what the points dissipate, all
/// relative to the dissipation of the loop: errors of these are errors of the damping ratio.
fn works(
    sketch: &mut Sketch,
    weights: &[f64],
    mode: &TrainingMode,
    record: &LoopRecord,
    coordinates: &Coordinates,
    of_basis: &[Field],
    of_shape: &Field,
    loops: usize,
) {
    let mut sizes = vec![0.0_f64; of_basis.len()];
    let mut of_mode = 0.0_f64;
    for increment in &record.increments {
        let (beside, q) = mode.beside(increment);
        of_mode = of_mode.max(q.abs());
        for (size, force) in sizes.iter_mut().zip(coordinates.forces.col_iter()) {
            let along: f64 = force.iter().zip(&beside).map(|(p, v)| p * v).sum();
            *size = size.max(along.abs());
        }
    }
    let dissipation: f64 = record.dissipation.iter().sum();
    let share = 1.0 / (dissipation * (loops as f64).sqrt());
    let per_vertex = share / (record.increments.len() as f64).sqrt();
    let mut row = vec![0.0; weights.len()];
    for departure in &record.departures {
        for (field, size) in std::iter::once((of_shape, of_mode)).chain(of_basis.iter().zip(sizes.iter().copied())) {
            for (p, value) in row.iter_mut().enumerate() {
                let work: f64 = (0..3).map(|c| field[c][p] * departure[c][p]).sum();
                *value = per_vertex * size * weights[p] * work;
            }
            sketch.add(&row);
        }
    }
    row.iter_mut()
        .zip(&record.dissipation)
        .for_each(|(value, own)| *value = share * own);
    sketch.add(&row);
}

/// Adds the works of the stuck tractions along pairs of coordinates of unit energy. They are corrected anyway; the less there is to correct,
/// the farther the joint may slip before what is left of the contact has no stiffness.
fn stuck_works(
    sketch: &mut Sketch,
    weights: &[f64],
    mode: &TrainingMode,
    of_basis: &[Field],
    of_shape: &Field,
    cases: usize,
) {
    let of_unit = of_shape
        .each_ref()
        .map(|field| field.iter().map(|v| v / mode.omega).collect());
    let fields: Vec<&Field> = std::iter::once(&of_unit).chain(of_basis).collect();
    let share = 1.0 / ((cases * fields.len()) as f64).sqrt();
    let tangent = &mode.at_rest.tangent;
    let mut row = vec![0.0; weights.len()];
    for (k, a) in fields.iter().enumerate() {
        for b in &fields[..=k] {
            for (p, value) in row.iter_mut().enumerate() {
                let traction = |i: usize| (0..3).map(|j| tangent[3 * i + j][p] * b[j][p]).sum::<f64>();
                let work: f64 = (0..3).map(|i| a[i][p] * traction(i)).sum();
                *value = share * weights[p] * work;
            }
            sketch.add(&row);
        }
    }
}
