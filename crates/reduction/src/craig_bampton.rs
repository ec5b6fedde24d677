//! Craig-Bampton reduction that retains the jump and the first modes of the stuck structure.
//!
//! The basis is `[[I, 0], [X, Phi]]`: columns of `X` are static responses to a unit jump, made mass-orthogonal to the
//! zero-energy modes of the stuck structure; `Phi` are its lowest mass-normalised modes, on request joined by its
//! static responses to the loads (attachment modes). `X` is never formed: static condensation leaves the matrices over
//! the jump, and with `K_rr X = -K_rD` the few other products with it are solves.

use crate::Error;
use crate::full_modes::{LinearCheck, frequencies_with_springs};
use crate::interior::{Interior, Retained};
use crate::part_modes::{condense_with_modes, modes_of_parts};
use crate::relative::RelativeSystem;
use crate::symmetry::Parts;
use crate::zem::Supported;
use dense_algebra::{BlockMatrix, Limits, SystemMatrix, add_product_lower, mirror_lower, product};
use faer::{Mat, MatRef};
use finite_elements::eigen::Modes;
use finite_elements::factor::Condensed;
use finite_elements::groups::Groups;
use finite_elements::sparse::multiply;
use sprs::CsMat;
use std::borrow::Cow;

/// Columns of the condensed matrices that are found again by solves.
const N_COMPARED: usize = 8;

/// Largest difference of a quantity that a model recovers from the same quantity of displacements, relative to the terms of its sum.
const LARGEST_DEVIATION: f64 = 1e-6;

/// What bases may leave out of what acts on the jump, relative to it and to what they may leave out of the coupling of joints.
const SEEN: f64 = 1e-2;

/// Relative distance of eigenvalues whose modes are turned together.
const EQUAL: f64 = 2e-4;

/// Share of the time of a part that condensing and its modes take, and up to which frequencies are checked.
const MODES: f64 = 0.75;
const CHECKING: f64 = 0.95;

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
    /// For a structure of several interfaces: what may be left out of the coupling between one and all others, relative to the largest. The matrices are
    /// then blocks of the interfaces, coupled through few combinations of each ([`dense_algebra::BlockMatrix`]). None for dense ones.
    pub coupling_tolerance: Option<f64>,
    /// Whether blocks are made dense after all where they would take more numbers.
    pub blocks_if_smaller: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            n_modes: 20,
            n_reported: 20,
            expected_zem: 6,
            mode_tolerance: 1e-6,
            attachment_modes: false,
            coupling_tolerance: None,
            blocks_if_smaller: false,
        }
    }
}

/// A reduced model over `[jump; modal coordinates]`.
#[derive(Clone, Debug)]
pub struct ReducedModel {
    /// Mass (kg) (jump) and 1 (mass-normalised modes).
    pub mass: SystemMatrix,
    /// Stiffness (N/m) and `omega^2` (rad^2/s^2); no coupling between jump and modes.
    pub stiffness: SystemMatrix,
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
    /// Largest asymmetry between rows of the matrices over the jump, from condensation, and the same columns, from
    /// solves, for some jump coordinates and relative to the largest entry: a measure of round-off.
    pub asymmetry: f64,
}

impl ReducedModel {
    /// Stuck-interface modes, without attachment modes.
    pub fn n_modes(&self) -> usize {
        self.size() - self.n_relative - self.n_attachment
    }

    /// Coordinates.
    pub fn size(&self) -> usize {
        self.mass.as_ref().size()
    }

    /// Turns modes so that each moves with the jump as its counterpart in `other` does, the model of a structure that differs little. Modes
    /// whose frequencies are equal to a hundredth of a per cent are turned together.
    ///
    /// # Errors
    /// [`Error::OtherModel`] for other coordinates.
    pub fn align_with(&mut self, other: &Self) -> Result<(), Error> {
        let (nd, n) = (self.n_relative, self.size());
        if other.n_relative != nd || other.size() != n {
            return Err(Error::OtherModel { deviation: 1.0 });
        }
        let n_rest = n - nd;
        let values = self.stiffness.as_ref().diagonal();
        let (own, others) = (self.momentum_of_rest(), other.momentum_of_rest());
        let mut turn = Mat::<f64>::identity(n_rest, n_rest);
        let mut first = 0;
        while first < n_rest {
            let mut last = first + 1;
            while last < n_rest && values[nd + last] <= values[nd + last - 1] * (1.0 + EQUAL) {
                last += 1;
            }
            let count = last - first;
            let common = product(own.subcols(first, count).transpose(), others.subcols(first, count));
            let rotation = dense_algebra::nearest_rotation(common.as_ref())?;
            turn.submatrix_mut(first, first, count, count).copy_from(&rotation);
            first = last;
        }
        // The modes are the last coordinates of all.
        let of_last = |count: usize| {
            let mut whole = Mat::<f64>::identity(count, count);
            let first = count - n_rest;
            whole.submatrix_mut(first, first, n_rest, n_rest).copy_from(&turn);
            whole
        };
        let congruent = |a: &Mat<f64>| {
            let turn = of_last(a.nrows());
            product(product(turn.transpose(), a.as_ref()).as_ref(), turn.as_ref())
        };
        let turned = |matrix: &SystemMatrix| match matrix {
            SystemMatrix::Dense(matrix) => congruent(matrix).into(),
            SystemMatrix::Blocks(matrix) => SystemMatrix::Blocks(matrix.with_seen(congruent(&matrix.seen()))),
        };
        let (mass, stiffness) = (turned(&self.mass), turned(&self.stiffness));
        (self.mass, self.stiffness) = (mass, stiffness);
        let turn = of_last(n);
        self.recovery = product(self.recovery.as_ref(), turn.as_ref());
        for load in &mut self.loads {
            let row = Mat::from_fn(1, n, |_, j| load[j]);
            *load = product(row.as_ref(), turn.as_ref()).row(0).iter().copied().collect();
        }
        Ok(())
    }

    /// The mass between the jump and the other coordinates.
    fn momentum_of_rest(&self) -> Mat<f64> {
        let (nd, n) = (self.n_relative, self.size());
        match &self.mass {
            SystemMatrix::Dense(mass) => mass.submatrix(0, nd, nd, n - nd).to_owned(),
            SystemMatrix::Blocks(mass) => mass.from_core(mass.core().submatrix(0, mass.rank(), mass.rank(), n - nd)),
        }
    }

    /// Keeps the first `n_modes` of the stuck-interface modes and leaves out the others.
    pub fn truncate(&mut self, n_modes: usize) {
        let (first, n) = (self.n_relative + n_modes, self.size());
        let last = n - self.n_attachment;
        if first >= last {
            return;
        }
        let kept: Vec<usize> = (0..first).chain(last..n).collect();
        let square = |a: &SystemMatrix| match a {
            SystemMatrix::Dense(a) => Mat::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]).into(),
            SystemMatrix::Blocks(a) => {
                let seen = a.seen();
                // What lies behind the jump, behind the combinations.
                let shift = |i: usize| i + a.rank() - self.n_relative;
                let kept: Vec<usize> = (0..a.rank())
                    .chain(kept[self.n_relative..].iter().copied().map(shift))
                    .collect();
                SystemMatrix::Blocks(a.with_seen(Mat::from_fn(kept.len(), kept.len(), |i, j| seen[(kept[i], kept[j])])))
            }
        };
        let (mass, stiffness) = (square(&self.mass), square(&self.stiffness));
        (self.mass, self.stiffness) = (mass, stiffness);
        self.recovery = Mat::from_fn(self.recovery.nrows(), kept.len(), |i, j| self.recovery[(i, kept[j])]);
        self.loads = self
            .loads
            .iter()
            .map(|load| kept.iter().map(|&i| load[i]).collect())
            .collect();
    }
}

/// Reduces a system; `rows` are quantities to recover, each over `[jump; rest]`; `limits` are asked at each front and block of vectors.
///
/// # Errors
/// [`Error::ZeroEnergyModes`] with both numbers, [`Error::UnbalancedLoad`], [`Error::DependentLoad`] with attachment
/// modes, failures of the factorisations, the limits.
pub fn reduce(
    system: &RelativeSystem,
    rows: &[Vec<f64>],
    settings: Settings,
    limits: Limits<'_>,
) -> Result<ReducedModel, Error> {
    Ok(reduce_with_modes(Cow::Borrowed(system), rows, settings, None, limits)?.model)
}

/// A reduced model, and what else its factors found.
#[derive(Clone, Debug)]
pub struct Reduction {
    /// The model.
    pub model: ReducedModel,
    /// Modes of each part of the stuck structure that its basis is made of, which [`displacements`] needs.
    pub modes: Vec<Modes>,
    /// The lowest frequencies of the full system with the interface of the check (Hz); none without a check.
    pub frequencies: Vec<f64>,
}

/// The same with the modes that its basis is made of, and if asked for with frequencies of the full system to `check` it by. A system that is given
/// away is dropped as soon as it is in the way.
///
/// # Errors
/// As [`reduce`].
pub fn reduce_with_modes(
    system: Cow<'_, RelativeSystem>,
    rows: &[Vec<f64>],
    settings: Settings,
    check: Option<LinearCheck<'_>>,
    limits: Limits<'_>,
) -> Result<Reduction, Error> {
    let springs = check.map(|check| check.springs);
    reduce_parts(parts_of(system, springs, settings), rows, settings, check, limits)
}

/// The modes of each part of the stuck structure that the basis of its reduction is made of; with a check, `springs` are those of it.
///
/// # Errors
/// As [`reduce`].
pub fn modes_of_basis(
    system: &RelativeSystem,
    settings: Settings,
    springs: Option<&CsMat<f64>>,
    limits: Limits<'_>,
) -> Result<Vec<Modes>, Error> {
    let parts = parts_of(Cow::Borrowed(system), springs, settings);
    Ok(reduce_parts(parts, &[], settings, None, limits)?.modes)
}

/// The parts of a reduction.
fn parts_of<'a>(system: Cow<'a, RelativeSystem>, springs: Option<&CsMat<f64>>, settings: Settings) -> Parts<'a> {
    match settings.attachment_modes {
        // Joints are no images of themselves, but of one another.
        _ if settings.coupling_tolerance.is_some() => Parts::whole(system),
        // The response to a load that acts on several would be that of each of them, in more coordinates than one.
        true => Parts::with_loads_in_one(system, springs),
        false => Parts::of(system, springs),
    }
}

fn reduce_parts(
    mut parts: Parts<'_>,
    rows: &[Vec<f64>],
    settings: Settings,
    check: Option<LinearCheck<'_>>,
    limits: Limits<'_>,
) -> Result<Reduction, Error> {
    let n = settings.n_reported.max(settings.n_modes);
    let separate = parts.separate();
    let parts = &parts;
    let of_part = |part, system: Cow<'_, RelativeSystem>, n, limits: Limits<'_>| {
        ReducedPart::try_new((parts, part), system, n, rows, settings, check, limits)
    };
    let mut reduced = modes_of_parts(parts, separate, n, limits, of_part, |part| &part.modes)?;
    let stuck: Vec<Modes> = (reduced.iter_mut())
        .map(|part| std::mem::replace(&mut part.modes, Modes::none(0)))
        .collect();
    check_zero_energy(parts, &stuck, settings)?;
    let retained = retained(&stuck, settings.n_modes);
    for (part, n_modes) in reduced.iter_mut().zip(retained) {
        part.retain(n_modes)?;
    }
    let zem_stuck = stuck.iter().map(|modes| modes.n_zero).sum();
    let mut stuck_frequencies: Vec<f64> = stuck.iter().flat_map(Modes::frequencies).collect();
    if parts.len() > 1 {
        stuck_frequencies.sort_by(f64::total_cmp);
        stuck_frequencies.truncate(n);
    }
    let mut frequencies: Vec<f64> = reduced.iter().flat_map(|part| part.checked.iter().copied()).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.truncate(check.map_or(0, |check| check.count));
    let nd = parts.of_whole().n_relative;
    let order = order(reduced.iter().map(|part| (part.eigenvalues.clone(), part.n_attachment)));
    let n = nd + order.len();
    let places: Vec<JumpPlaces> = (0..parts.len())
        .map(|part| (0..nd).map(|jump| parts.place(part, jump)).collect())
        .collect();
    let rows_of_whole = |of_part: fn(&ReducedPart) -> &Mat<f64>, count: usize| {
        let mut whole = Mat::<f64>::zeros(count, n);
        for (part, places) in reduced.iter().zip(&places) {
            for (j, place) in places.iter().enumerate() {
                if let Some((column, weight)) = place {
                    (0..count).for_each(|i| whole[(i, j)] += weight * of_part(part)[(i, *column)]);
                }
            }
        }
        for (j, &(part, mode)) in order.iter().enumerate() {
            let (part, own) = (&reduced[part], reduced[part].coupling.nrows());
            (0..count).for_each(|i| whole[(i, nd + j)] = of_part(part)[(i, own + mode)]);
        }
        whole
    };
    let loads = rows_of_whole(|part| &part.loads, parts.of_whole().loads.len());
    let recovery = rows_of_whole(|part| &part.recovery, rows.len());
    let loads: Vec<Vec<f64>> = loads.row_iter().map(|load| load.iter().copied().collect()).collect();
    let blocks = match reduced.as_slice() {
        [
            part @ ReducedPart {
                condensed:
                    Condensed {
                        stiffness: SystemMatrix::Blocks(stiffness),
                        mass: SystemMatrix::Blocks(mass),
                    },
                ..
            },
        ] => Some(part.joined([stiffness, mass], &order, &loads, settings)),
        _ => None,
    };
    let (stiffness, mass) = match blocks {
        Some(blocks) => blocks,
        None => {
            let mut whole = |of: fn(&mut ReducedPart) -> &mut SystemMatrix| {
                // Each is freed once it is part of the sum.
                let taken = reduced
                    .iter_mut()
                    .map(|part| std::mem::replace(of(part), Mat::new().into()).into_dense());
                sum_over_jump(taken.zip(&places), nd, n)
            };
            let mut stiffness = whole(|part| &mut part.condensed.stiffness);
            let mut mass = whole(|part| &mut part.condensed.mass);
            for (j, &(part, mode)) in order.iter().enumerate() {
                let (places, part) = (&places[part], &reduced[part]);
                for i in 0..nd {
                    let coupling = places[i].map_or(0.0, |(row, weight)| weight * part.coupling[(row, mode)]);
                    (mass[(i, nd + j)], mass[(nd + j, i)]) = (coupling, coupling);
                }
                mass[(nd + j, nd + j)] = 1.0;
                stiffness[(nd + j, nd + j)] = part.eigenvalues[mode];
            }
            (stiffness.into(), mass.into())
        }
    };
    limits.done(1.0);
    let model = ReducedModel {
        mass,
        stiffness,
        loads,
        n_relative: nd,
        n_attachment: reduced.iter().map(|part| part.n_attachment).sum(),
        recovery,
        stuck_frequencies,
        zem_stuck,
        asymmetry: reduced.iter().map(|part| part.asymmetry).fold(0.0, f64::max),
    };
    Ok(Reduction {
        model,
        modes: stuck,
        frequencies,
    })
}

/// For each jump coordinate of the whole that of a part which moves it, and by how much.
type JumpPlaces = Vec<Option<(usize, f64)>>;

/// A symmetric matrix over all `n` coordinates, zero beyond the `nd` of the jump, from the lower triangles over the jumps of parts. These are independent of one another.
fn sum_over_jump<'a>(parts: impl Iterator<Item = (Mat<f64>, &'a JumpPlaces)>, nd: usize, n: usize) -> Mat<f64> {
    let mut whole = Mat::<f64>::zeros(n, n);
    for (lower, places) in parts {
        for j in 0..nd {
            let Some((column, factor)) = places[j] else { continue };
            for i in j..nd {
                let Some((row, weight)) = places[i] else { continue };
                whole[(i, j)] += weight * factor * lower[(row.max(column), row.min(column))];
            }
        }
    }
    mirror_lower(whole.as_mut());
    whole
}

/// Refuses parts that have not as many modes without energy as expected, or are not in equilibrium with all loads.
fn check_zero_energy(parts: &Parts<'_>, stuck: &[Modes], settings: Settings) -> Result<(), Error> {
    let found = stuck.iter().map(|modes| modes.n_zero).sum();
    if found != settings.expected_zem {
        return Err(Error::ZeroEnergyModes {
            found,
            expected: settings.expected_zem,
        });
    }
    for (part, modes) in stuck.iter().enumerate() {
        for (index, load) in parts.loads(part).iter().enumerate() {
            check_equilibrium(index, &load[load.len() - modes.shapes.nrows()..], modes)?;
        }
    }
    Ok(())
}

/// The jump, in the groups that become blocks.
fn kept(system: &RelativeSystem, settings: Settings) -> Groups {
    match settings.coupling_tolerance {
        Some(tolerance) => Groups::new(&system.groups, tolerance, [&system.stiffness, &system.mass]),
        None => Groups::one(system.n_relative),
    }
}

/// How many modes of each part are among the `n_modes` lowest of all.
fn retained(stuck: &[Modes], n_modes: usize) -> Vec<usize> {
    let of_part = |(part, modes): (usize, &Modes)| {
        let elastic = modes.eigenvalues[modes.n_zero..].to_vec();
        elastic.into_iter().map(move |value| (value, part))
    };
    let mut all: Vec<(f64, usize)> = stuck.iter().enumerate().flat_map(of_part).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.truncate(n_modes);
    let mut counts = vec![0; stuck.len()];
    all.iter().for_each(|(_, part)| counts[*part] += 1);
    counts
}

/// The loads whose static responses join the modes of a part.
fn acting_loads(parts: &Parts<'_>, part: usize, settings: Settings) -> Vec<usize> {
    let acts = |&load: &usize| settings.attachment_modes && parts.acts(load, part);
    (0..parts.of_whole().loads.len()).filter(acts).collect()
}

/// Part and number of each mode of a model, from the eigenvalues of each part and the number of attachment modes among them: modes in the
/// order of their frequencies, and then all attachment modes.
fn order(parts: impl Iterator<Item = (Vec<f64>, usize)>) -> Vec<(usize, usize)> {
    let (mut modes, mut attached) = (Vec::new(), Vec::new());
    for (part, (eigenvalues, n_attachment)) in parts.enumerate() {
        let n_modes = eigenvalues.len() - n_attachment;
        modes.extend((0..n_modes).map(|mode| (eigenvalues[mode], (part, mode))));
        attached.extend((n_modes..eigenvalues.len()).map(|mode| (part, mode)));
    }
    modes.sort_by(|a, b| a.0.total_cmp(&b.0));
    modes.into_iter().map(|(_, place)| place).chain(attached).collect()
}

/// What is left of a part once its basis is dropped. Columns beyond the jump are those of its interior, and of what is retained of it once that is known.
struct ReducedPart {
    /// Of the stuck part.
    modes: Modes,
    /// Its lowest frequencies with the interface of the check (Hz).
    checked: Vec<f64>,
    /// Over the jump: lower triangles, or blocks without the momentum along zero-energy modes.
    condensed: Condensed,
    /// That momentum.
    momentum: Mat<f64>,
    interior: Interior,
    /// The mass between jump and interior.
    coupling: Mat<f64>,
    /// Of what is retained.
    eigenvalues: Vec<f64>,
    n_attachment: usize,
    loads: Mat<f64>,
    recovery: Mat<f64>,
    asymmetry: f64,
}

impl ReducedPart {
    /// Of the part with this number and its system, with its `n` lowest modes.
    fn try_new(
        (parts, part): (&Parts<'_>, usize),
        system: Cow<'_, RelativeSystem>,
        n: usize,
        rows: &[Vec<f64>],
        settings: Settings,
        check: Option<LinearCheck<'_>>,
        limits: Limits<'_>,
    ) -> Result<Self, Error> {
        let kept = kept(&system, settings);
        let (supported, mut condensed, modes) = condense_with_modes(
            &system,
            &kept,
            n,
            (settings.mode_tolerance, settings.expected_zem),
            limits.part(0.0, MODES),
        )?;
        let checked = match check {
            Some(check) => {
                let springs = parts.springs(part, check.springs);
                let check = LinearCheck {
                    springs: &springs,
                    ..check
                };
                let limits = limits.part(MODES, CHECKING);
                frequencies_with_springs(&system, check, &supported, &condensed.stiffness, limits)?
            }
            None => Vec::new(),
        };
        let acting = acting_loads(parts, part, settings);
        let basis = Basis::new(system, supported, &modes, &acting);
        let asymmetry = basis.static_part.asymmetry(&condensed)?;
        let loads = basis.onto(&basis.static_part.system.loads);
        let recovery = basis.onto(&parts.onto(part, rows));
        let Basis {
            static_part,
            shapes,
            interior,
            momentum,
        } = basis;
        let overlap = product(static_part.supported.mass_modes.transpose(), shapes.as_ref());
        let coupling = static_part.momentum(shapes.as_ref()) - product(momentum.as_ref(), overlap.as_ref());
        // System and factor take more memory than all that follows.
        drop(static_part);
        if let SystemMatrix::Dense(mass) = &mut condensed.mass {
            add_product_lower(mass.as_mut(), momentum.as_ref(), momentum.transpose(), -1.0);
        }
        limits.done(1.0);
        Ok(Self {
            modes,
            checked,
            condensed,
            momentum,
            interior,
            coupling,
            eigenvalues: Vec::new(),
            n_attachment: 0,
            loads,
            recovery,
            asymmetry,
        })
    }

    /// Leaves out all modes but the first ones.
    fn retain(&mut self, n_modes: usize) -> Result<(), Error> {
        let retained = self.interior.retained(n_modes)?;
        let turn = retained.turn.as_ref();
        let nd = self.momentum.nrows();
        let turned = |rows: &Mat<f64>| {
            let mut all = Mat::zeros(rows.nrows(), nd + turn.ncols());
            all.subcols_mut(0, nd).copy_from(rows.subcols(0, nd));
            all.subcols_mut(nd, turn.ncols())
                .copy_from(product(rows.subcols(nd, turn.nrows()), turn));
            all
        };
        (self.loads, self.recovery) = (turned(&self.loads), turned(&self.recovery));
        self.coupling = product(self.coupling.as_ref(), turn);
        (self.eigenvalues, self.n_attachment) = (retained.eigenvalues, retained.n_attachment);
        Ok(())
    }

    /// Stiffness and mass over all coordinates, from those over the jump, of which modes come in this `order`, as blocks, if wanted only where these are smaller than dense matrices;
    /// `loads` are over the same coordinates.
    fn joined(
        &self,
        [stiffness, mass]: [&BlockMatrix; 2],
        order: &[(usize, usize)],
        loads: &[Vec<f64>],
        settings: Settings,
    ) -> (SystemMatrix, SystemMatrix) {
        let nd = self.momentum.nrows();
        let (n_momenta, n_modes) = (self.momentum.ncols(), order.len());
        // All that acts on the jump beside the blocks is seen by their combinations.
        let columns = Mat::from_fn(nd, n_momenta + n_modes + loads.len(), |i, j| {
            match (j.checked_sub(n_momenta), j.checked_sub(n_momenta + n_modes)) {
                (None, _) => self.momentum[(i, j)],
                (Some(mode), None) => self.coupling[(i, order[mode].1)],
                (_, Some(load)) => loads[load][i],
            }
        });
        let tree = stiffness.extended_tree(columns.as_ref(), SEEN * settings.coupling_tolerance.unwrap_or(0.0));
        let (stiffness, mass) = (stiffness.over_tree(&tree), mass.over_tree(&tree));
        let rank = mass.rank();
        let seen = mass.onto_core(columns.subcols(0, n_momenta + n_modes));
        let (momentum, coupling) = seen.split_at_col(n_momenta);
        let with_modes = |matrix: &BlockMatrix, mode: &dyn Fn(usize) -> f64| {
            let mut whole = Mat::zeros(rank + n_modes, rank + n_modes);
            whole.submatrix_mut(0, 0, rank, rank).copy_from(matrix.core());
            (0..n_modes).for_each(|k| whole[(rank + k, rank + k)] = mode(k));
            whole
        };
        let stiff = with_modes(&stiffness, &|k| self.eigenvalues[order[k].1]);
        let mut heavy = with_modes(&mass, &|_| 1.0);
        let lost = dense_algebra::symmetric(product(momentum, momentum.transpose()).as_ref());
        let own = heavy.submatrix(0, 0, rank, rank) - lost;
        heavy.submatrix_mut(0, 0, rank, rank).copy_from(own);
        heavy.submatrix_mut(0, rank, rank, n_modes).copy_from(coupling);
        heavy
            .submatrix_mut(rank, 0, n_modes, rank)
            .copy_from(coupling.transpose());
        // Joints that lie so near that their coupling has nearly full rank are better off dense.
        let matrix = |blocks: BlockMatrix| match blocks.is_smaller_than_dense() {
            false if settings.blocks_if_smaller => SystemMatrix::Dense(blocks.to_dense()),
            _ => SystemMatrix::Blocks(blocks),
        };
        (matrix(stiffness.with_seen(stiff)), matrix(mass.with_seen(heavy)))
    }
}

/// Displacements over `[jump; rest]` in motions of a reduced model, which are the columns of `motions`.
///
/// The basis is not part of the model: what of it are solves is factored again. `system`, `rows` and `settings` are those that `model` was made of, and `modes`
/// those that came with it ([`reduce_with_modes`], [`modes_of_basis`]), with a check by `springs`; it may have been truncated since. The `limits` are asked, and hear how much is done.
///
/// # Errors
/// As [`reduce`]; [`Error::OtherModel`] if what `rows` recover from the displacements is not what the model recovers.
pub fn displacements(
    system: &RelativeSystem,
    rows: &[Vec<f64>],
    (settings, springs): (Settings, Option<&CsMat<f64>>),
    model: &ReducedModel,
    modes: &[Modes],
    motions: MatRef<'_, f64>,
    limits: Limits<'_>,
) -> Result<Mat<f64>, Error> {
    let parts = parts_of(Cow::Borrowed(system), springs, settings);
    let found = displacements_of_parts(&parts, settings, model, modes, motions, limits)?;
    let recovered = product(model.recovery.as_ref(), motions);
    for (i, row) in rows.iter().enumerate() {
        for (j, motion) in found.col_iter().enumerate() {
            let (mut again, mut size) = (0.0_f64, 0.0_f64);
            for (factor, u) in row.iter().zip(motion.iter()) {
                again += factor * u;
                size += (factor * u).abs();
            }
            let deviation = (again - recovered[(i, j)]).abs();
            // `!(a <= b)` also catches NaN.
            if !(deviation <= LARGEST_DEVIATION * size) {
                return Err(Error::OtherModel {
                    deviation: deviation / size,
                });
            }
        }
    }
    Ok(found)
}

fn displacements_of_parts(
    parts: &Parts<'_>,
    settings: Settings,
    model: &ReducedModel,
    stuck: &[Modes],
    motions: MatRef<'_, f64>,
    limits: Limits<'_>,
) -> Result<Mat<f64>, Error> {
    if stuck.len() != parts.len() {
        return Err(Error::OtherModel { deviation: 1.0 });
    }
    let bases = parts.each(Vec::new(), limits, |part, system, limits| {
        if stuck[part].shapes.nrows() != system.n_rest() {
            return Err(Error::OtherModel { deviation: 1.0 });
        }
        let acting = acting_loads(parts, part, settings);
        let zero_energy = stuck[part].zero_energy();
        let supported = match acting.is_empty() {
            true => Supported::try_new(&system, zero_energy, limits)?,
            // Signs of attachment modes follow from static responses, which must be those of the reduction to the last bit.
            false => Supported::condense(&system, zero_energy, &kept(&system, settings), limits)?.0,
        };
        Ok(Basis::new(system, supported, &stuck[part], &acting))
    })?;
    let retained = bases.iter().zip(retained(stuck, settings.n_modes));
    let retained = retained.map(|(basis, n_modes)| basis.interior.retained(n_modes));
    let retained: Vec<Retained> = retained.collect::<Result<_, _>>()?;
    let order = order(retained.iter().map(|of| (of.eigenvalues.clone(), of.n_attachment)));
    let nd = parts.of_whole().n_relative;
    let n_attachment: usize = retained.iter().map(|of| of.n_attachment).sum();
    let left_out = order.len().checked_sub(model.n_modes() + model.n_attachment);
    let Some(left_out) = left_out.filter(|_| model.n_relative == nd && model.n_attachment == n_attachment) else {
        return Err(Error::OtherModel { deviation: 1.0 });
    };
    // A model may lack the highest modes.
    let last = order.len() - n_attachment;
    let kept = order[..last - left_out].iter().chain(&order[last..]);
    let mut whole = Mat::zeros(parts.of_whole().stiffness.rows(), motions.ncols());
    for (part, (basis, retained)) in bases.iter().zip(&retained).enumerate() {
        let mut jump = Mat::zeros(basis.momentum.nrows(), motions.ncols());
        for i in 0..nd {
            if let Some((row, weight)) = parts.place(part, i) {
                (0..motions.ncols()).for_each(|j| jump[(row, j)] += weight * motions[(i, j)]);
            }
        }
        let mut modal = Mat::zeros(retained.eigenvalues.len(), motions.ncols());
        for (i, &(_, mode)) in kept.clone().enumerate().filter(|(_, (of, _))| *of == part) {
            (0..motions.ncols()).for_each(|j| modal[(mode, j)] = motions[(nd + i, j)]);
        }
        let modal = product(retained.turn.as_ref(), modal.as_ref());
        whole += parts.displacements(part, basis.displacements(jump.as_ref(), modal.as_ref()));
    }
    // The sum over the parts is that but for round-off.
    whole.subrows_mut(0, nd).copy_from(motions.subrows(0, nd));
    Ok(whole)
}

/// The basis of a part, in the form in which it is applied: by solves.
struct Basis<'a> {
    static_part: StaticPart<'a>,
    /// Modes with a stuck interface, and behind them static responses to loads.
    shapes: Mat<f64>,
    interior: Interior,
    /// The held rest follows the jump with this momentum along the zero-energy modes, which is taken out.
    momentum: Mat<f64>,
}

impl<'a> Basis<'a> {
    fn new(system: Cow<'a, RelativeSystem>, supported: Supported, stuck: &Modes, attached: &[usize]) -> Self {
        let (nd, n_rest) = (system.n_relative, system.n_rest());
        let loads = Mat::from_fn(n_rest, attached.len(), |i, j| system.loads[attached[j]][nd + i]);
        let (responses, momentum) = static_responses(&loads, &system, &supported);
        let modes = stuck.elastic();
        let n_modes = modes.ncols();
        let shapes = Mat::from_fn(n_rest, n_modes + attached.len(), |i, j| match j.checked_sub(n_modes) {
            None => modes[(i, j)],
            Some(load) => responses[(i, load)],
        });
        let interior = Interior::new(
            (&stuck.eigenvalues[stuck.n_zero..], n_rest - stuck.n_zero),
            shapes.as_ref(),
            attached,
            loads.as_ref(),
            momentum.as_ref(),
        );
        let static_part = StaticPart {
            jump_rest: system.jump_rest(&system.stiffness),
            system,
            supported,
        };
        let momentum = static_part.momentum(static_part.supported.modes.as_ref());
        Self {
            static_part,
            shapes,
            interior,
            momentum,
        }
    }

    /// Rows over `[jump; rest]` times the basis.
    fn onto(&self, rows: &[Vec<f64>]) -> Mat<f64> {
        let (nd, phi) = (self.momentum.nrows(), &self.shapes);
        let rest = over_rest(nd, self.static_part.jump_rest.cols(), rows);
        let own = Mat::from_fn(nd, rows.len(), |i, j| rows[j][i]);
        let rigid = product(self.static_part.supported.modes.transpose(), rest.as_ref());
        let jump = own + self.static_part.work(rest.clone()) - product(self.momentum.as_ref(), rigid.as_ref());
        let modal = product(phi.transpose(), rest.as_ref());
        Mat::from_fn(rows.len(), nd + phi.ncols(), |i, j| {
            if j < nd { jump[(j, i)] } else { modal[(j - nd, i)] }
        })
    }

    /// The basis times columns over the jump and over the interior.
    fn displacements(&self, jump: MatRef<'_, f64>, modal: MatRef<'_, f64>) -> Mat<f64> {
        let nd = jump.nrows();
        let mut rest = self.static_part.follow(jump);
        let rigid = product(self.momentum.transpose(), jump);
        rest -= product(self.static_part.supported.modes.as_ref(), rigid.as_ref());
        rest += product(self.shapes.as_ref(), modal);
        let mut all = Mat::zeros(nd + rest.nrows(), jump.ncols());
        all.subrows_mut(0, nd).copy_from(jump);
        all.subrows_mut(nd, rest.nrows()).copy_from(&rest);
        all
    }
}

/// The part of rows beyond the first `nd` entries, as columns.
fn over_rest(nd: usize, n_rest: usize, rows: &[Vec<f64>]) -> Mat<f64> {
    Mat::from_fn(n_rest, rows.len(), |i, j| rows[j][nd + i])
}

/// Products with the static responses `x` of the held rest to the jump.
struct StaticPart<'a> {
    system: Cow<'a, RelativeSystem>,
    /// The stiffness that couples the jump to the rest.
    jump_rest: CsMat<f64>,
    supported: Supported,
}

impl StaticPart<'_> {
    /// `x^T f` for forces on the rest.
    fn work(&self, mut forces: Mat<f64>) -> Mat<f64> {
        self.supported.solve_in_place(forces.as_mut());
        -multiply(&self.jump_rest, forces.as_ref())
    }

    /// `[I; x]^T M [0; c]` for columns `c` over the rest.
    fn momentum(&self, columns: MatRef<'_, f64>) -> Mat<f64> {
        let [jump, rest] = self.system.momentum(None, columns);
        jump + self.work(rest)
    }

    /// `x d` for jumps `d`.
    fn follow(&self, jump: MatRef<'_, f64>) -> Mat<f64> {
        let mut rest = multiply(&self.jump_rest.transpose_view().to_csr(), jump);
        self.supported.solve_in_place(rest.as_mut());
        rest *= faer::Scale(-1.0);
        rest
    }

    /// Compares some of the condensed rows with columns found by solves.
    fn asymmetry(&self, condensed: &Condensed) -> Result<f64, Error> {
        let nd = self.system.n_relative;
        let count = N_COMPARED.min(nd);
        let chosen: Vec<usize> = (0..count).map(|j| (2 * j + 1) * nd / (2 * count)).collect();
        let unit = Mat::from_fn(nd, count, |i, j| f64::from(u8::from(i == chosen[j])));
        let x = self.follow(unit.as_ref());
        let mut stiffness = multiply(&self.jump_rest, x.as_ref());
        for (j, &row) in chosen.iter().enumerate() {
            for (i, value) in self.system.stiffness.outer_view(row).iter().flat_map(|row| row.iter()) {
                if i < nd {
                    stiffness[(i, j)] += value;
                }
            }
        }
        let [jump, rest] = self.system.momentum(Some(unit.as_ref()), x.as_ref());
        let mass = jump + self.work(rest);
        let compare = |matrix, condensed: &SystemMatrix, columns: &Mat<f64>| {
            let condensed = condensed.as_ref();
            let deviation = (condensed.product(unit.as_ref()) - columns).norm_max();
            // Masses that contact alone holds have no stiffness.
            let asymmetry = if deviation == 0.0 {
                0.0
            } else {
                // Of a matrix that is not negative the largest entry is on the diagonal.
                deviation / condensed.diagonal().into_iter().fold(0.0, f64::max)
            };
            // `!(a <= b)` also catches NaN.
            if !(asymmetry <= 1e-6) {
                return Err(Error::Asymmetry { matrix, asymmetry });
            }
            Ok(asymmetry)
        };
        let stiffness = compare("stiffness", &condensed.stiffness, &stiffness)?;
        Ok(stiffness.max(compare("mass", &condensed.mass, &mass)?))
    }
}

/// Static responses of the stuck structure to balanced loads, mass-orthogonal to its zero-energy modes, and the mass
/// times them.
fn static_responses(loads: &Mat<f64>, system: &RelativeSystem, supported: &Supported) -> (Mat<f64>, Mat<f64>) {
    let mut responses = loads.clone();
    supported.solve_in_place(responses.as_mut());
    let [_, mut momentum] = system.momentum(None, responses.as_ref());
    let rigid = supported.remove_zero_energy(momentum.as_mut());
    responses += dense_algebra::product(supported.modes.as_ref(), rigid.as_ref());
    (responses, momentum)
}

fn check_equilibrium(index: usize, load: &[f64], stuck: &Modes) -> Result<(), Error> {
    let largest_force = load.iter().fold(0.0_f64, |largest, f| largest.max(f.abs()));
    for mode in stuck.zero_energy().col_iter() {
        let (sum, size) = mode
            .iter()
            .zip(load)
            .fold((0.0_f64, 0.0_f64), |(s, a), (z, f)| (s + z * f, a + (z * f).abs()));
        // A load on a component that rigid motion does not move, as the overlap of a bolt, works on round-off alone.
        let size = size.max(mode.norm_max() * largest_force);
        if sum.abs() > 1e-6 * size {
            return Err(Error::UnbalancedLoad {
                load: index.to_string(),
                fraction: sum.abs() / size,
            });
        }
    }
    Ok(())
}
