//! Craig-Bampton reduction that retains the jump and the first modes of the stuck structure.
//!
//! The basis is `[[I, 0], [X, Phi]]`: columns of `X` are static responses to a unit jump, made mass-orthogonal to the
//! zero-energy modes of the stuck structure; `Phi` are its lowest mass-normalised modes, on request joined by its
//! static responses to the loads (attachment modes). `X` is never stored: with `K_rr X = -K_rD` every product with it is
//! one more solve, streamed block by block.

use crate::Error;
use crate::locked::Interior;
use crate::relative::RelativeSystem;
use crate::zem::Supported;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use sprs::CsMat;
use substructure::eigen::{Modes, lowest_modes};
use substructure::sparse::{multiply_into, multiply_vector};

/// Columns of the basis formed together.
const STREAM: usize = 2 * substructure::factor::BLOCK;

/// What to retain and what to expect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Stuck-interface modes retained.
    pub n_modes: usize,
    /// Stuck-interface modes reported (at least `n_modes`).
    pub n_reported: usize,
    /// Zero-energy modes the stuck structure must have: 6 for a free one.
    pub expected_zem: usize,
    /// Residual the modes must reach.
    pub mode_tolerance: f64,
    /// Whether the static response of the stuck structure to each load joins the modes, one coordinate per load, so
    /// that the flexibility at the loads is complete. [`ReducedModel::locked`] needs it.
    pub attachment_modes: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            n_modes: 20,
            n_reported: 20,
            expected_zem: 6,
            mode_tolerance: 1e-6,
            attachment_modes: false,
        }
    }
}

/// A reduced model over `[jump; modal coordinates]`.
#[derive(Clone, Debug)]
pub struct ReducedModel {
    /// Mass (kg) (jump) and 1 (mass-normalised modes).
    pub mass: Mat<f64>,
    /// Stiffness (N/m) and `omega^2` (rad^2/s^2); no coupling between jump and modes.
    pub stiffness: Mat<f64>,
    /// Loads.
    pub loads: Vec<Vec<f64>>,
    /// Number of leading jump coordinates.
    pub n_relative: usize,
    /// Number of modal coordinates, the last ones, that stand for the attachment modes: one per load, or none.
    pub n_attachment: usize,
    /// One row per recovered quantity: its value is the product with the reduced coordinates.
    pub recovery: Mat<f64>,
    /// Frequencies of the stuck structure, `n_reported` of them (Hz).
    pub stuck_frequencies: Vec<f64>,
    /// Zero-energy modes of the stuck structure.
    pub zem_stuck: usize,
    /// Largest asymmetry of the streamed matrices relative to their largest entry, before they were symmetrised.
    pub asymmetry: f64,
}

/// Parts of a reduction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Factorising, and the modes of the stuck structure.
    Factor,
    /// Streaming the static responses.
    Stream,
}

/// Reduces a system; `rows` are quantities to recover, each over `[jump; rest]`; `progress` hears how much of a step is
/// done, from 0 to 1.
///
/// # Errors
/// [`Error::ZeroEnergyModes`] with both numbers, [`Error::UnbalancedLoad`], [`Error::DependentLoad`] with attachment
/// modes, failures of the factorisations.
pub fn reduce(
    system: &RelativeSystem,
    rows: &[Vec<f64>],
    settings: Settings,
    progress: &mut dyn FnMut(Step, f64),
) -> Result<ReducedModel, Error> {
    let nd = system.n_relative;
    let k = system.blocks(&system.stiffness);
    let m = system.blocks(&system.mass);
    let positions = &system.positions[nd..];
    let n_reported = settings.n_reported.max(settings.n_modes);
    let stuck = lowest_modes(&k.rest, &m.rest, positions, n_reported, settings.mode_tolerance)?;
    if stuck.n_zero != settings.expected_zem {
        return Err(Error::ZeroEnergyModes {
            found: stuck.n_zero,
            expected: settings.expected_zem,
        });
    }
    for (index, load) in system.loads.iter().enumerate() {
        check_equilibrium(index, &load[nd..], &stuck)?;
    }
    progress(Step::Factor, 0.5);
    let supported = Supported::try_new(&k.rest, &m.rest, positions, stuck.zero_energy())?;
    progress(Step::Factor, 1.0);
    let nr = k.rest.rows();
    let mut interior = Interior::modes(&stuck, settings.n_modes.min(stuck.elastic().ncols()));
    let n_attachment = if settings.attachment_modes {
        system.loads.len()
    } else {
        0
    };
    if n_attachment > 0 {
        let loads = Mat::from_fn(nr, n_attachment, |i, j| system.loads[j][nd + i]);
        let (responses, momentum) = static_responses(&loads, &m.rest, &supported);
        interior.attach(responses.as_ref(), momentum.as_ref(), loads.as_ref())?;
    }
    let phi = interior.shapes;
    let n_modes = phi.ncols();
    let n = nd + n_modes;
    let mut stiffness = Mat::<f64>::zeros(n, n);
    let mut mass = Mat::<f64>::zeros(n, n);
    let mut zero_energy_part = Mat::<f64>::zeros(stuck.n_zero, nd);
    let k_rest_jump: CsMat<f64> = k.jump_rest.transpose_view().to_csr();
    let m_rest_jump: CsMat<f64> = m.jump_rest.transpose_view().to_csr();
    for start in (0..nd).step_by(STREAM) {
        let width = STREAM.min(nd - start);
        let unit = Mat::from_fn(nd, width, |i, j| f64::from(u8::from(i == start + j)));
        // x = -K_rr^-1 K_rD, up to a zero-energy motion.
        let mut x = Mat::<f64>::zeros(nr, width);
        multiply_into(&k_rest_jump, unit.as_ref(), x.as_mut());
        faer::zip!(&mut x).for_each(|faer::unzip!(value)| *value = -*value);
        supported.solve_in_place(x.as_mut());
        // K_DD + K_Dr x; the zero-energy part carries no force.
        let mut product = Mat::<f64>::zeros(nd, width);
        let mut add = |target: &mut Mat<f64>, matrix: &CsMat<f64>, columns: &Mat<f64>, sign: f64| {
            multiply_into(matrix, columns.as_ref(), product.as_mut());
            for j in 0..width {
                for i in 0..nd {
                    target[(i, start + j)] += sign * product[(i, j)];
                }
            }
        };
        add(&mut stiffness, &k.jump, &unit, 1.0);
        add(&mut stiffness, &k.jump_rest, &x, 1.0);
        // Momentum of the unit jump, with the zero-energy motion taken out of it and of x.
        let mut momentum = Mat::<f64>::zeros(nr, width);
        let mut inertia = Mat::<f64>::zeros(nr, width);
        multiply_into(&m.rest, x.as_ref(), momentum.as_mut());
        multiply_into(&m_rest_jump, unit.as_ref(), inertia.as_mut());
        momentum += &inertia;
        let a = supported.remove_zero_energy(momentum.as_mut());
        matmul(
            x.as_mut(),
            Accum::Add,
            supported.modes.as_ref(),
            a.as_ref(),
            1.0,
            Par::Seq,
        );
        zero_energy_part.as_mut().subcols_mut(start, width).copy_from(&a);
        add(&mut mass, &m.jump, &unit, 1.0);
        add(&mut mass, &m.jump_rest, &x, 1.0);
        let mut modal = Mat::<f64>::zeros(n_modes, width);
        matmul(
            modal.as_mut(),
            Accum::Replace,
            phi.transpose(),
            momentum.as_ref(),
            1.0,
            Par::Seq,
        );
        for j in 0..width {
            for i in 0..n_modes {
                mass[(nd + i, start + j)] = modal[(i, j)];
                mass[(start + j, nd + i)] = modal[(i, j)];
            }
        }
        // x^T momentum = -K_Dr K_rr^-1 momentum, because the momentum is in equilibrium with the zero-energy modes.
        supported.solve_in_place(momentum.as_mut());
        add(&mut mass, &k.jump_rest, &momentum, -1.0);
        progress(Step::Stream, (start + width) as f64 / nd as f64);
    }
    for i in 0..n_modes {
        mass[(nd + i, nd + i)] = 1.0;
        stiffness[(nd + i, nd + i)] = interior.eigenvalues[i];
    }
    let asymmetry = symmetrise(&mut stiffness, "stiffness")?.max(symmetrise(&mut mass, "mass")?);
    let onto = |row: &[f64]| project(row, nd, &k.jump_rest, &supported, &zero_energy_part, &phi);
    let loads = system.loads.iter().map(|load| onto(load)).collect();
    let recovered: Vec<Vec<f64>> = rows.iter().map(|row| onto(row)).collect();
    Ok(ReducedModel {
        mass,
        stiffness,
        loads,
        n_relative: nd,
        n_attachment,
        recovery: Mat::from_fn(rows.len(), n, |i, j| recovered[i][j]),
        stuck_frequencies: stuck.frequencies(),
        zem_stuck: stuck.n_zero,
        asymmetry,
    })
}

/// Static responses of the stuck structure to balanced loads, mass-orthogonal to its zero-energy modes, and the mass
/// times them.
fn static_responses(loads: &Mat<f64>, mass: &CsMat<f64>, supported: &Supported) -> (Mat<f64>, Mat<f64>) {
    let mut responses = loads.clone();
    supported.solve_in_place(responses.as_mut());
    let mut momentum = Mat::zeros(loads.nrows(), loads.ncols());
    multiply_into(mass, responses.as_ref(), momentum.as_mut());
    let rigid = supported.remove_zero_energy(momentum.as_mut());
    responses += dense_algebra::product(supported.modes.as_ref(), rigid.as_ref());
    (responses, momentum)
}

/// `row * basis` for a row over `[jump; rest]`.
fn project(
    row: &[f64],
    nd: usize,
    k_jump_rest: &CsMat<f64>,
    supported: &Supported,
    zero_energy_part: &Mat<f64>,
    phi: &Mat<f64>,
) -> Vec<f64> {
    let rest = Mat::from_fn(row.len() - nd, 1, |i, _| row[nd + i]);
    let mut solved = rest.clone();
    supported.solve_in_place(solved.as_mut());
    let solved: Vec<f64> = solved.col(0).iter().copied().collect();
    let along = |modes: &Mat<f64>, j: usize| modes.col(j).iter().zip(&row[nd..]).map(|(a, b)| a * b).sum::<f64>();
    let rigid: Vec<f64> = (0..supported.modes.ncols())
        .map(|j| along(&supported.modes, j))
        .collect();
    let mut out: Vec<f64> = multiply_vector(k_jump_rest, &solved)
        .iter()
        .enumerate()
        .map(|(j, v)| {
            row[j] - v
                + rigid
                    .iter()
                    .enumerate()
                    .map(|(z, r)| r * zero_energy_part[(z, j)])
                    .sum::<f64>()
        })
        .collect();
    out.extend((0..phi.ncols()).map(|j| along(phi, j)));
    out
}

fn check_equilibrium(index: usize, load: &[f64], stuck: &Modes) -> Result<(), Error> {
    for mode in stuck.zero_energy().col_iter() {
        let (sum, size) = mode
            .iter()
            .zip(load)
            .fold((0.0_f64, 0.0_f64), |(s, a), (z, f)| (s + z * f, a + (z * f).abs()));
        if sum.abs() > 1e-6 * size {
            return Err(Error::UnbalancedLoad {
                load: index.to_string(),
                fraction: sum.abs() / size,
            });
        }
    }
    Ok(())
}

fn symmetrise(matrix: &mut Mat<f64>, name: &'static str) -> Result<f64, Error> {
    let n = matrix.nrows();
    let (mut largest, mut difference) = (0.0_f64, 0.0_f64);
    for j in 0..n {
        for i in 0..=j {
            let (a, b) = (matrix[(i, j)], matrix[(j, i)]);
            largest = largest.max(a.abs());
            difference = difference.max((a - b).abs());
            let mean = 0.5 * (a + b);
            matrix[(i, j)] = mean;
            matrix[(j, i)] = mean;
        }
    }
    let asymmetry = difference / largest;
    // `!(a <= b)` also catches NaN.
    if !(asymmetry <= 1e-6) {
        return Err(Error::Asymmetry {
            matrix: name,
            asymmetry,
        });
    }
    Ok(asymmetry)
}
