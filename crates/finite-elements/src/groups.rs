//! Kept rows in groups that lie apart: what each couples to the others, in few combinations of its rows.
//!
//! Once all that touches a group `g` is eliminated, the rest of the elimination sees the group through the coupling `E` of its rows to those still to come,
//! in stiffness and mass. With an orthonormal basis `B` of the space of the rows of both, `E = E B B^T` up to a tolerance, and what comes later adds
//! `B X B^T` to the group, or `B X B_h^T` to it and another one: `B^T` times the rows is carried on in the place of the group.

use crate::ordering::Dissection;
use dense_algebra::{BlockMatrix, SystemMatrix, leading_basis, product, symmetric};
use faer::Mat;
use sprs::CsMat;
use std::sync::Arc;

/// Combinations of a group that are expected to be carried on, for an estimate of memory.
const EXPECTED_RANK: usize = 128;

/// Combinations of a group that are carried on without another look at whether fewer would do.
const FEW: usize = 64;

/// Rows that are kept to the end of an elimination, the first ones of a matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    /// Rows of each group.
    sizes: Vec<usize>,
    /// Part of the coupling of a group that may be left out, relative to the largest.
    tolerance: f64,
}

impl Groups {
    /// No rows.
    pub fn none() -> Self {
        Self::one(0)
    }

    /// Rows that belong together, of which nothing is left out.
    pub fn one(size: usize) -> Self {
        Self {
            sizes: vec![size],
            tolerance: 0.0,
        }
    }

    /// Groups that follow one another, and the part of the coupling of a group that may be left out, relative to the largest. Groups with entries of a
    /// matrix between them are one.
    pub fn new(sizes: &[usize], tolerance: f64, matrices: [&CsMat<f64>; 2]) -> Self {
        let ends: Vec<usize> = sizes
            .iter()
            .scan(0, |end, size| {
                *end += size;
                Some(*end)
            })
            .collect();
        let total = ends.last().copied().unwrap_or(0);
        let group = |row: usize| ends.partition_point(|&end| end <= row);
        // The last group that is one with each.
        let mut last: Vec<usize> = (0..sizes.len()).collect();
        for matrix in matrices {
            for (row, columns) in matrix.outer_iterator().enumerate().take(total) {
                for (column, value) in columns.iter() {
                    if column < total && *value != 0.0 {
                        let own = group(row);
                        last[own] = last[own].max(group(column));
                    }
                }
            }
        }
        let (mut merged, mut until) = (Vec::new(), None);
        for (number, size) in sizes.iter().enumerate() {
            match (until, merged.last_mut()) {
                (Some(end), Some(sum)) if number <= end => *sum += size,
                _ => merged.push(*size),
            }
            until = until.max(Some(last[number]));
        }
        Self {
            sizes: merged,
            tolerance,
        }
    }

    /// Rows of all groups.
    pub fn len(&self) -> usize {
        self.sizes.iter().sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Rows of each group.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }
}

/// Groups during an elimination.
pub(crate) struct Grouping {
    /// Position of the first kept row.
    first: usize,
    /// First row of each group, and the number of all.
    starts: Vec<usize>,
    tolerance: f64,
    /// The part after which nothing touches a group any more.
    complete: Vec<usize>,
}

/// A group of which combinations are carried on.
pub(crate) struct Completed {
    group: usize,
    /// Position that stands for the first of them.
    first: usize,
    /// Its rows that something touches.
    rows: Vec<usize>,
    /// A column per combination.
    basis: Mat<f64>,
    /// What the eliminated parts leave on these rows, one matrix for the stiffness and one for the mass.
    own: Vec<Mat<f64>>,
}

impl Grouping {
    /// None if there is one group.
    pub(crate) fn try_new(groups: &Groups, dissection: &Dissection, matrices: &[CsMat<f64>]) -> Option<Self> {
        if groups.sizes.len() < 2 {
            return None;
        }
        let first = dissection.order.len();
        let mut starts = vec![0];
        for size in &groups.sizes {
            starts.push(starts[starts.len() - 1] + size);
        }
        let mut found = Self {
            first,
            starts,
            tolerance: groups.tolerance,
            complete: Vec::new(),
        };
        // Parts that touch each group, and those of them in the subtree of each part.
        let n_parts = dissection.parts.len();
        let mut touching = vec![vec![0_u32; n_parts]; groups.sizes.len()];
        for (number, part) in dissection.parts.iter().enumerate() {
            for matrix in matrices {
                for row in part.rows.clone() {
                    for &position in &matrix.indices()[matrix.indptr().outer_inds_sz(row)] {
                        if position >= first {
                            touching[found.group(position)][number] = 1;
                        }
                    }
                }
            }
        }
        for counts in touching {
            let all: u32 = counts.iter().sum();
            let mut within = counts;
            for (number, part) in dissection.parts.iter().enumerate() {
                for &child in &part.children {
                    within[number] += within[child];
                }
            }
            found
                .complete
                .push(within.iter().position(|&count| count == all).unwrap_or(n_parts));
        }
        Some(found)
    }

    /// The group of a kept position.
    fn group(&self, position: usize) -> usize {
        self.starts.partition_point(|&start| start <= position - self.first) - 1
    }

    /// The position that stands for combination `index` of those that a part completes: after all rows, and after those of earlier parts.
    fn combination(&self, part: usize, index: usize) -> usize {
        let n = self.starts[self.starts.len() - 1];
        self.first + n + part * n + index
    }

    fn is_combination(&self, position: usize) -> bool {
        position >= self.combination(0, 0)
    }

    /// Whether the last position of an update is a combination, if it has any.
    pub(crate) fn carries(&self, last: Option<&usize>) -> bool {
        last.is_some_and(|&position| self.is_combination(position))
    }

    /// Rows and combinations that a part leaves something on, where `beyond` are the rows.
    pub(crate) fn expected(&self, part: usize, beyond: &[usize]) -> usize {
        let kept = beyond.partition_point(|&position| position < self.first);
        let mut counts = vec![0; self.complete.len()];
        for &position in &beyond[kept..] {
            counts[self.group(position)] += 1;
        }
        let of_group = |(group, count): (usize, usize)| match self.complete[group] < part {
            true => count.min(EXPECTED_RANK),
            false => count,
        };
        kept + counts.into_iter().enumerate().map(of_group).sum::<usize>()
    }

    /// Puts the combinations that the children of a part carry on in the place of the groups among `beyond`, the rows that the part touches by itself or
    /// through its children.
    pub(crate) fn replace<'a>(&self, part: usize, beyond: &mut Vec<usize>, children: impl Iterator<Item = &'a usize>) {
        beyond.retain(|&position| position < self.first || self.complete[self.group(position)] >= part);
        let carried = children.copied().filter(|&position| self.is_combination(position));
        beyond.extend(carried);
        beyond.sort_unstable();
    }

    /// Carries combinations alone on of groups that nothing after this part touches, and fewer of those carried on already, where branches have met and at
    /// the last part: what lay between two groups is eliminated then. `matrices` are lower triangles over the positions `beyond`.
    pub(crate) fn complete(
        &self,
        part: usize,
        n_branches: usize,
        beyond: &mut Vec<usize>,
        matrices: &mut [Mat<f64>],
        done: &mut Vec<Completed>,
    ) {
        let is_last = beyond.iter().all(|&position| position >= self.first);
        let mut index = 0;
        for group in 0..self.complete.len() {
            let known = done.iter().position(|completed| completed.group == group);
            let is_own = |position: usize| match known.map(|at| &done[at]) {
                None => position >= self.first && !self.is_combination(position) && self.group(position) == group,
                Some(known) => (known.first..known.first + known.basis.ncols()).contains(&position),
            };
            let is_due = match known {
                None => self.complete[group] == part,
                Some(at) => is_last || (n_branches > 1 && done[at].basis.ncols() > FEW),
            };
            if !is_due {
                continue;
            }
            let (own, others): (Vec<usize>, Vec<usize>) = (0..beyond.len()).partition(|&at| is_own(beyond[at]));
            let entry = |matrix: &Mat<f64>, i: usize, j: usize| matrix[(i.max(j), i.min(j))];
            let mut coupling = Mat::<f64>::zeros(own.len(), matrices.len() * others.len());
            for (which, matrix) in matrices.iter().enumerate() {
                let mut across = Mat::from_fn(own.len(), others.len(), |i, j| entry(matrix, own[i], others[j]));
                let longest = across.col_iter().map(|column| column.norm_l2()).fold(0.0, f64::max);
                // Stiffness and mass count alike.
                if longest > 0.0 {
                    across *= faer::Scale(longest.recip());
                }
                coupling
                    .subcols_mut(which * others.len(), others.len())
                    .copy_from(across);
            }
            let basis = leading_basis(coupling, self.tolerance);
            let rank = basis.ncols();
            let mut local = Vec::with_capacity(matrices.len());
            for matrix in matrices.iter_mut() {
                local.push(Mat::from_fn(own.len(), own.len(), |i, j| entry(matrix, own[i], own[j])));
                let across = Mat::from_fn(own.len(), others.len(), |i, j| entry(matrix, own[i], others[j]));
                let across = product(basis.transpose(), across.as_ref());
                let n = others.len();
                let mut left = Mat::zeros(n + rank, n + rank);
                for j in 0..n {
                    for i in j..n {
                        left[(i, j)] = matrix[(others[i], others[j])];
                    }
                }
                left.submatrix_mut(n, 0, rank, n).copy_from(across);
                *matrix = left;
            }
            let first = self.combination(part, index);
            match known.map(|at| &mut done[at]) {
                None => done.push(Completed {
                    group,
                    first,
                    rows: (own.iter())
                        .map(|&at| beyond[at] - self.first - self.starts[group])
                        .collect(),
                    basis,
                    own: local,
                }),
                Some(known) => {
                    for (sum, local) in known.own.iter_mut().zip(local) {
                        let half = product(known.basis.as_ref(), local.as_ref());
                        *sum += symmetric(product(half.as_ref(), known.basis.transpose()).as_ref());
                    }
                    known.basis = product(known.basis.as_ref(), basis.as_ref());
                    known.first = first;
                }
            }
            *beyond = others.iter().map(|&at| beyond[at]).collect();
            beyond.extend((index..index + rank).map(|index| self.combination(part, index)));
            index += rank;
        }
    }
}

/// Stiffness and mass over all groups, from what is left of each, from lower triangles `left` over all combinations, in the order in which the groups were
/// completed, and from the entries among kept rows, of which the upper triangle is `given` for each matrix.
pub(crate) fn joined(
    grouping: &Grouping,
    done: Vec<Completed>,
    left: &[Mat<f64>],
    given: impl Fn(usize) -> Vec<(usize, usize, f64)>,
) -> [SystemMatrix; 2] {
    let n_groups = grouping.complete.len();
    let size = |group: usize| grouping.starts[group + 1] - grouping.starts[group];
    // Columns of what is left, group by group.
    let mut order: Vec<usize> = (0..done.len()).collect();
    order.sort_by_key(|&at| done[at].first);
    let mut columns = vec![0..0; n_groups];
    let mut column = 0;
    for &at in &order {
        let rank = done[at].basis.ncols();
        columns[done[at].group] = column..column + rank;
        column += rank;
    }
    let mut bases: Vec<Mat<f64>> = (0..n_groups).map(|group| Mat::zeros(size(group), 0)).collect();
    for completed in &done {
        let (n, rank) = (size(completed.group), completed.basis.ncols());
        let mut basis = Mat::zeros(n, rank);
        for (i, &row) in completed.rows.iter().enumerate() {
            basis.row_mut(row).copy_from(completed.basis.row(i));
        }
        bases[completed.group] = basis;
    }
    let bases = Arc::new(bases);
    let places: Vec<usize> = columns.iter().cloned().flatten().collect();
    [0, 1].map(|which| {
        let mut local: Vec<Mat<f64>> = (0..n_groups)
            .map(|group| Mat::zeros(size(group), size(group)))
            .collect();
        for completed in &done {
            let (block, own) = (&mut local[completed.group], &completed.own[which]);
            for (j, &column) in completed.rows.iter().enumerate() {
                for (i, &row) in completed.rows.iter().enumerate() {
                    block[(row, column)] = own[(i, j)];
                }
            }
        }
        for (row, column, value) in given(which) {
            let group = grouping.group(grouping.first + row);
            let (row, column) = (row - grouping.starts[group], column - grouping.starts[group]);
            local[group][(row, column)] += value;
            if row != column {
                local[group][(column, row)] += value;
            }
        }
        let left = &left[which];
        let core = Mat::from_fn(places.len(), places.len(), |i, j| {
            left[(places[i].max(places[j]), places[i].min(places[j]))]
        });
        SystemMatrix::Blocks(BlockMatrix::new(bases.clone(), Arc::new(local), Vec::new(), core))
    })
}
