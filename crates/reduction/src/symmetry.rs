//! Systems that a reflection leaves as they are: their symmetric and their antisymmetric motions do not act on one another.
//!
//! A reflection `P` with `P P = I`, `P^T K P = K` and `P^T M P = M` splits all motions into those with `P x = x` and those with `P x = -x`. In bases of
//! both, stiffness and mass fall into two parts, each with about half of the coordinates. What acts on the interface need not be
//! symmetric: the jump of the whole is the sum of those of both parts.

use crate::Error;
use crate::relative::{RelativeSystem, SystemMatrices};
use dense_algebra::{Limits, product};
use faer::Mat;
use finite_elements::reflection::Reflection;
use finite_elements::sparse::{congruence, is_kept_by, multiply, multiply_vector, numbering, sum};
use rayon::prelude::*;
use sprs::{CsMat, TriMat};
use std::borrow::Cow;

/// Fewest coordinates beside the jump for which parts are sought: in smaller systems they save nothing that could be noticed.
const LEAST_REST: usize = 1024;

/// Difference between an entry `ij` of a matrix and of its reflection, relative to the root of the product of the entries `ii` and `jj`, that is
/// round-off of the assembly.
const SAME_ENTRY: f64 = 1e-11;

/// Entry of a reflection that is none but for round-off.
const NO_ENTRY: f64 = 1e-12;

/// Share of a load that is none but for round-off.
const NO_LOAD: f64 = 1e-10;

/// Most coordinates that have no image because constraints eliminated it: their parts are found in full matrices.
const MOST_WITHOUT_IMAGE: usize = 512;

/// Most coordinates of a system whose parts are worked on side by side, which takes the memory of all at once.
const SIDE_BY_SIDE: usize = 100_000;

/// Memory beside which that of parts so small is little (bytes).
const PLENTY: u64 = 4 << 30;

/// The parts of a system, or the whole as the only one.
pub(crate) struct Parts<'a> {
    whole: Cow<'a, RelativeSystem>,
    /// The symmetric and the antisymmetric one; none where the whole is the only part.
    over: Vec<Over>,
}

/// Coordinates of a part.
struct Over {
    /// Those of the whole over those of the part, of which the jump is first.
    transform: CsMat<f64>,
    n_relative: usize,
    positions: Vec<[f64; 3]>,
    loads: Vec<Vec<f64>>,
    rigid_motions: Mat<f64>,
}

impl<'a> Parts<'a> {
    /// The whole alone.
    pub(crate) fn whole(whole: Cow<'a, RelativeSystem>) -> Self {
        Self {
            whole,
            over: Vec::new(),
        }
    }

    /// The parts of a system with springs across the interface.
    pub(crate) fn of(whole: Cow<'a, RelativeSystem>, springs: Option<&CsMat<f64>>) -> Self {
        let mut parts = Self::whole(whole);
        let whole = &*parts.whole;
        if whole.stiffness.rows() - whole.n_relative < LEAST_REST {
            return parts;
        }
        let found = whole.reflections.iter().find_map(|reflection| {
            let images = Images::try_new(reflection, whole.n_relative)?;
            images.keeps(whole, springs).then_some((reflection, images))
        });
        if let Some((reflection, images)) = found {
            let over = [1.0, -1.0].map(|sign| Over::try_new(whole, reflection, &images, sign));
            let size = |over: &Over| over.transform.cols();
            let over: Vec<Over> = over.into_iter().flatten().collect();
            if over.iter().map(size).sum::<usize>() == whole.stiffness.rows() {
                parts.over = over;
            }
        }
        parts
    }

    /// The parts of a system each load of which acts on one of them alone; the whole where one acts on both.
    pub(crate) fn with_loads_in_one(whole: Cow<'a, RelativeSystem>, springs: Option<&CsMat<f64>>) -> Self {
        let parts = Self::of(whole, springs);
        let acts_on = |load: usize| (0..parts.len()).filter(|&part| parts.acts(load, part)).count();
        match (0..parts.whole.loads.len()).all(|load| acts_on(load) == 1) {
            true => parts,
            false => Self::whole(parts.whole),
        }
    }

    /// The systems of large parts in the place of the matrices of the whole, if that is no one else's: both would be in the way of the factors. None where
    /// the whole keeps them.
    pub(crate) fn separate(&mut self) -> Vec<RelativeSystem> {
        if self.are_small() || matches!(self.whole, Cow::Borrowed(_)) {
            return Vec::new();
        }
        let of_parts = (0..self.over.len()).map(|part| self.system(part).into_owned());
        let mut systems: Vec<RelativeSystem> = of_parts.collect();
        let whole = self.whole.to_mut();
        let none = CsMat::zero(whole.stiffness.shape());
        let stiffness = std::mem::replace(&mut whole.stiffness, none.clone());
        let mass = std::mem::replace(&mut whole.mass, none);
        if systems.is_empty() {
            systems.push(RelativeSystem {
                stiffness,
                mass,
                ..whole.clone()
            });
        }
        systems
    }

    /// The whole; without its matrices once it is separated.
    pub(crate) fn of_whole(&self) -> &RelativeSystem {
        &self.whole
    }

    pub(crate) fn len(&self) -> usize {
        self.over.len().max(1)
    }

    /// Whether they may be worked on side by side.
    pub(crate) fn are_small(&self) -> bool {
        self.whole.stiffness.rows() <= SIDE_BY_SIDE
    }

    /// What `of` finds of each part, from its system and within the limits for it. The systems may be `separate` ones, which are given away.
    pub(crate) fn each<'b, T: Send>(
        &'b self,
        separate: Vec<RelativeSystem>,
        limits: Limits<'_>,
        of: impl Fn(usize, Cow<'b, RelativeSystem>, Limits<'_>) -> Result<T, Error> + Sync,
    ) -> Result<Vec<T>, Error> {
        let of = |part: usize, own: Option<RelativeSystem>, limits: Limits<'_>| {
            let system = own.map_or_else(|| self.system(part), Cow::Owned);
            of(part, system, limits)
        };
        let mut separate = separate.into_iter();
        let parts = (0..self.len()).map(|part| (part, separate.next()));
        if self.are_small() && limits.memory().is_none_or(|memory| memory >= PLENTY) {
            // All are about as far as the whole.
            let found = parts
                .collect::<Vec<_>>()
                .into_par_iter()
                .map(|(part, own)| of(part, own, limits));
            return found.collect::<Vec<_>>().into_iter().collect();
        }
        parts
            .map(|(part, own)| of(part, own, limits.of_part(part, self.len())))
            .collect()
    }

    /// Whether a load acts on a part; all act on the whole.
    pub(crate) fn acts(&self, load: usize, part: usize) -> bool {
        let own = self.over.get(part).map(|over| &over.loads[load]);
        own.is_none_or(|load| load.iter().any(|force| *force != 0.0))
    }

    /// The loads over the coordinates of a part; zero where they do not act on it.
    pub(crate) fn loads(&self, part: usize) -> &[Vec<f64>] {
        self.over.get(part).map_or(&self.whole.loads, |over| &over.loads)
    }

    /// The system of a part.
    pub(crate) fn system(&self, part: usize) -> Cow<'_, RelativeSystem> {
        let Some(over) = self.over.get(part) else {
            return Cow::Borrowed(&self.whole);
        };
        let whole = SystemMatrices {
            stiffness: &self.whole.stiffness,
            mass: &self.whole.mass,
            loads: &[],
            positions: &self.whole.positions,
        };
        let (transform, positions) = (over.transform.clone(), over.positions.clone());
        let mut system = RelativeSystem::changed(whole, transform, over.n_relative, positions);
        system.loads.clone_from(&over.loads);
        system.rigid_motions.clone_from(&over.rigid_motions);
        Cow::Owned(system)
    }

    /// A symmetric matrix over the jump, over that of a part.
    pub(crate) fn springs<'b>(&self, part: usize, springs: &'b CsMat<f64>) -> Cow<'b, CsMat<f64>> {
        let Some(over) = self.over.get(part) else {
            return Cow::Borrowed(springs);
        };
        let mut jump = TriMat::new((springs.rows(), over.n_relative));
        for i in 0..springs.rows() {
            if let Some((column, weight)) = self.place(part, i) {
                jump.add_triplet(i, column, weight);
            }
        }
        Cow::Owned(congruence(&jump.to_csr(), springs))
    }

    /// Rows over the whole, over a part.
    pub(crate) fn onto<'b>(&self, part: usize, rows: &'b [Vec<f64>]) -> Cow<'b, [Vec<f64>]> {
        let Some(over) = self.over.get(part) else {
            return Cow::Borrowed(rows);
        };
        let transposed: CsMat<f64> = over.transform.transpose_view().to_csr();
        Cow::Owned(rows.iter().map(|row| multiply_vector(&transposed, row)).collect())
    }

    /// Motions of a part, over the whole.
    pub(crate) fn displacements(&self, part: usize, motions: Mat<f64>) -> Mat<f64> {
        let Some(over) = self.over.get(part) else {
            return motions;
        };
        multiply(&over.transform, motions.as_ref())
    }

    /// The jump coordinate of a part that moves one of the whole, and by how much.
    pub(crate) fn place(&self, part: usize, jump: usize) -> Option<(usize, f64)> {
        match self.over.get(part) {
            None => Some((jump, 1.0)),
            Some(over) => {
                let row = over.transform.outer_view(jump)?;
                row.iter().next().map(|(column, weight)| (column, *weight))
            }
        }
    }
}

/// What a reflection does to coordinates.
struct Images {
    /// Its columns: row `j` is the reflected unit motion of coordinate `j`.
    columns: CsMat<f64>,
    /// For each coordinate its image, which may be itself, and the sign; none where constraints eliminated it.
    other: Vec<Option<(usize, f64)>>,
    /// Coordinates without an image.
    without: Vec<usize>,
}

impl Images {
    /// None where jumps do not become jumps, or a coordinate with an image moves others with images too.
    fn try_new(reflection: &Reflection, n_relative: usize) -> Option<Self> {
        let matrix = &reflection.matrix;
        let n = matrix.rows();
        let mut entries = TriMat::with_capacity((n, n), matrix.nnz());
        for (&value, (i, j)) in matrix {
            if value.abs() > NO_ENTRY {
                entries.add_triplet(i, j, value);
            }
        }
        let rows: CsMat<f64> = entries.to_csr();
        let alone = |i: usize| {
            let row = rows.outer_view(i)?;
            let mut entries = row.iter();
            let (column, value) = entries.next()?;
            let is_unit = (value.abs() - 1.0).abs() <= NO_ENTRY;
            (is_unit && entries.next().is_none()).then_some((column, value.signum()))
        };
        let other: Vec<_> = (0..n)
            .map(|i| alone(i).filter(|&(j, sign)| alone(j) == Some((i, sign))))
            .collect();
        let without: Vec<usize> = (0..n).filter(|&i| other[i].is_none()).collect();
        let are_jumps = |i: usize| other[i].is_some_and(|(j, _)| j < n_relative);
        if without.len() > MOST_WITHOUT_IMAGE || !(0..n_relative).all(are_jumps) {
            return None;
        }
        let columns: CsMat<f64> = entries.to_csc().transpose_into();
        let is_sound = |j: usize| {
            let column = columns.outer_view(j);
            let mut reached = column.iter().flat_map(|column| column.indices());
            reached.all(|&i| match other[j] {
                Some((image, _)) => i == image || (j >= n_relative && other[i].is_none()),
                None => other[i].is_none(),
            })
        };
        let twice: CsMat<f64> = &columns * &columns;
        let mut difference = sum(&twice, -1.0, &CsMat::eye(n)).into_raw_storage().2.into_iter();
        let returns = difference.all(|value| value.abs() <= SAME_ENTRY);
        (returns && (0..n).all(is_sound)).then_some(Self {
            columns,
            other,
            without,
        })
    }

    /// Whether stiffness, mass and springs across the interface are the same after reflection.
    fn keeps(&self, system: &RelativeSystem, springs: Option<&CsMat<f64>>) -> bool {
        let matrix: CsMat<f64> = self.columns.transpose_view().to_csr();
        let mut all = [&system.stiffness, &system.mass].into_iter();
        let nd = system.n_relative;
        all.all(|of| is_kept_by(&matrix, of, SAME_ENTRY))
            && springs.is_none_or(|springs| {
                let mut jump = TriMat::new((nd, nd));
                for j in 0..nd {
                    if let Some((i, sign)) = self.other[j] {
                        jump.add_triplet(i, j, sign);
                    }
                }
                is_kept_by(&jump.to_csr(), springs, SAME_ENTRY)
            })
    }
}

impl Over {
    /// Motions that a reflection multiplies by `sign`; none where they are not as many as they must be.
    fn try_new(whole: &RelativeSystem, reflection: &Reflection, images: &Images, sign: f64) -> Option<Self> {
        let n = whole.stiffness.rows();
        let (mut entries, mut positions, mut n_relative) = (Vec::with_capacity(n), Vec::new(), 0);
        for j in 0..n {
            let Some((image, factor)) = images.other[j].filter(|&(image, _)| j <= image) else {
                continue;
            };
            // `x + sign P x` of the coordinate's unit motion.
            let scale = match image == j {
                true if factor != sign => continue,
                true => 0.5,
                false => 0.5_f64.sqrt(),
            };
            let column = positions.len();
            entries.push((j, column, scale));
            for (i, value) in images.columns.outer_view(j)?.iter() {
                entries.push((i, column, sign * value * scale));
            }
            n_relative += usize::from(j < whole.n_relative);
            positions.push(on_one_side(whole.positions[j], reflection));
        }
        let without = numbering(&images.without, n);
        let m = images.without.len();
        let mut projector = Mat::<f64>::identity(m, m);
        for (j, &of) in images.without.iter().enumerate() {
            for (i, value) in images.columns.outer_view(of)?.iter() {
                if let Some(i) = without[i] {
                    projector[(i, j)] += sign * value;
                }
            }
        }
        let n_with_images = positions.len();
        for (member, motion) in basis(projector * faer::Scale(0.5))? {
            let column = positions.len();
            entries.extend(images.without.iter().zip(motion).map(|(&i, value)| (i, column, value)));
            positions.push(on_one_side(whole.positions[images.without[member]], reflection));
        }
        if n_relative == 0 || positions.len() == n_relative {
            return None;
        }
        let mut transform = TriMat::with_capacity((n, positions.len()), entries.len());
        entries
            .into_iter()
            .filter(|(_, _, value)| *value != 0.0)
            .for_each(|(i, j, value)| transform.add_triplet(i, j, value));
        let transform: CsMat<f64> = transform.to_csr();
        let transposed: CsMat<f64> = transform.transpose_view().to_csr();
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let load = |whole: &Vec<f64>| {
            let own = multiply_vector(&transposed, whole);
            match norm(&own) <= NO_LOAD * norm(whole) {
                true => vec![0.0; own.len()],
                false => own,
            }
        };
        // What is left of rigid motions in this part: first at coordinates with images, then what that leaves at those without.
        let mut own = multiply(&reflection.matrix, whole.rigid_motions.as_ref()) * faer::Scale(sign);
        own += &whole.rigid_motions;
        own *= faer::Scale(0.5);
        let at_images = Mat::from_fn(
            n,
            own.ncols(),
            |i, j| if without[i].is_none() { own[(i, j)] } else { 0.0 },
        );
        let mut rigid_motions = multiply(&transposed, at_images.as_ref());
        own -= multiply(&transform, rigid_motions.as_ref());
        let left = multiply(&transposed, own.as_ref());
        for i in n_with_images..positions.len() {
            rigid_motions.row_mut(i).copy_from(left.row(i));
        }
        Some(Self {
            loads: whole.loads.iter().map(load).collect(),
            rigid_motions,
            transform,
            n_relative,
            positions,
        })
    }
}

/// A place or its image, whichever lies beyond the plane.
fn on_one_side(mut position: [f64; 3], reflection: &Reflection) -> [f64; 3] {
    let x = &mut position[reflection.axis];
    *x = reflection.centre + (*x - reflection.centre).abs();
    position
}

/// An orthonormal basis of the range of a projector, each vector with the component that it moves most; none if the matrix is no projector.
fn basis(projector: Mat<f64>) -> Option<Vec<(usize, Vec<f64>)>> {
    let m = projector.nrows();
    let again = product(projector.as_ref(), projector.as_ref());
    // `!(a <= b)` also catches NaN.
    if !((again - &projector).norm_max() <= NO_ENTRY * (1.0 + projector.norm_max()) * m as f64) {
        return None;
    }
    let rank = (0..m).map(|i| projector[(i, i)]).sum::<f64>().round() as usize;
    let mut rest = projector;
    let mut found = Vec::with_capacity(rank);
    for _ in 0..rank {
        let squared = |j: usize| rest.col(j).iter().map(|v| v * v).sum::<f64>();
        let best = (0..m).max_by(|&a, &b| squared(a).total_cmp(&squared(b)))?;
        let norm = squared(best).sqrt();
        let motion: Vec<f64> = rest.col(best).iter().map(|v| v / norm).collect();
        for j in 0..m {
            let along: f64 = rest.col(j).iter().zip(&motion).map(|(a, b)| a * b).sum();
            (0..m).for_each(|i| rest[(i, j)] -= along * motion[i]);
        }
        let most = (0..m).max_by(|&a, &b| motion[a].abs().total_cmp(&motion[b].abs()))?;
        found.push((most, motion));
    }
    Some(found)
}
