//! Kept rows in groups that lie apart: what each couples to the others, in few combinations of its rows.
//!
//! Once all that touches a group `g` is eliminated, the rest of the elimination sees the group through the coupling `E` of its rows to those still to come,
//! in stiffness and mass. With an orthonormal basis `B` of the space of the rows of both, `E = E B B^T` up to a tolerance, and what comes later adds
//! `B X B^T` to the group, or `B X B_h^T` to it and another one: `B^T` times the rows is carried on in the place of the group. Where branches of the
//! elimination meet, what they carry is united in a node of a tree, of which fewer combinations are carried on in the same way.

use crate::ordering::{Dissection, Ordered};
use dense_algebra::{BlockMatrix, Node, Symmetric, SystemMatrix, Tree, leading_basis, product, symmetric};
use faer::Mat;
use sprs::CsMat;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Combinations of a group that are expected to be carried on, for an estimate of memory.
const EXPECTED_RANK: usize = 128;

/// Those of all groups behind a part that are expected to be carried on.
const EXPECTED_OF_ALL: usize = 4 * EXPECTED_RANK;

/// Tolerance of what is seen of several nodes, relative to that of a group: what is left out there of one level after another adds up.
const OF_NODES: f64 = 0.1;

/// Largest part of the combinations of nodes that is seen of all of them, where it pays to unite them.
const WORTH_UNITING: f64 = 0.75;

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

/// A group, or what is carried on of several nodes, of which combinations are carried on.
pub(crate) struct Completed {
    /// What its rows are.
    of: Rows,
    /// Position that stands for the first combination.
    first: usize,
    /// A column per combination.
    basis: Mat<f64>,
    /// What the eliminated parts leave on its rows, one matrix for the stiffness and one for the mass.
    own: Vec<Mat<f64>>,
}

enum Rows {
    /// Those of this group that something touches.
    Group(usize, Vec<usize>),
    /// The combinations of these nodes, one after the other.
    United(Vec<Completed>),
}

impl Grouping {
    /// None if there is one group.
    pub(crate) fn try_new(groups: &Groups, dissection: &Dissection, ordered: &Ordered<'_>) -> Option<Self> {
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
            let touched = part.rows.clone().flat_map(|row| ordered.touched(row));
            for position in touched.filter(|&position| position >= first) {
                touching[found.group(position)][number] = 1;
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
        // As many as there are rows in groups, and again in nodes.
        self.first + n + 2 * part * n + index
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
        let (mut touched, mut carried) = (0, 0);
        for (group, count) in counts.into_iter().enumerate() {
            match self.complete[group] < part {
                true => carried += count.min(EXPECTED_RANK),
                false => touched += count,
            }
        }
        kept + touched + carried.min(EXPECTED_OF_ALL)
    }

    /// Puts the combinations that the children of a part carry on in the place of the groups among `beyond`, the rows that the part touches by itself or
    /// through its children.
    pub(crate) fn replace<'a>(&self, part: usize, beyond: &mut Vec<usize>, children: impl Iterator<Item = &'a usize>) {
        beyond.retain(|&position| position < self.first || self.complete[self.group(position)] >= part);
        let carried = children.copied().filter(|&position| self.is_combination(position));
        beyond.extend(carried);
        beyond.sort_unstable();
    }

    /// Carries combinations alone on of groups that nothing after this part touches, and fewer of what is carried on already, where branches have met and at
    /// the last part: what lay between two groups is eliminated then. Where branches have met they are united. `matrices` are lower triangles over the
    /// positions `beyond`.
    pub(crate) fn complete(
        &self,
        part: usize,
        n_branches: usize,
        beyond: &mut Vec<usize>,
        matrices: &mut [Mat<f64>],
        done: &mut Vec<Completed>,
    ) {
        let is_last = beyond.iter().all(|&position| position >= self.first);
        let mut left = Left {
            next: self.combination(part, 0),
            beyond,
            matrices,
        };
        for node in done.iter_mut() {
            if !(is_last || (n_branches > 1 && node.basis.ncols() > FEW)) {
                continue;
            }
            let positions = node.first..node.first + node.basis.ncols();
            let is_own = |position| positions.contains(&position);
            let Some(fewer) = left.carry_on(is_own, self.tolerance, 1.0) else {
                continue;
            };
            for (sum, local) in node.own.iter_mut().zip(fewer.own) {
                let half = product(node.basis.as_ref(), local.as_ref());
                *sum += symmetric(product(half.as_ref(), node.basis.transpose()).as_ref());
            }
            node.basis = product(node.basis.as_ref(), fewer.basis.as_ref());
            node.first = fewer.first;
        }
        for group in (0..self.complete.len()).filter(|&group| self.complete[group] == part) {
            let is_own =
                |position| position >= self.first && !self.is_combination(position) && self.group(position) == group;
            if let Some(Carried {
                rows,
                first,
                basis,
                own,
            }) = left.carry_on(is_own, self.tolerance, 1.0)
            {
                let row = |position| position - self.first - self.starts[group];
                done.push(Completed {
                    of: Rows::Group(group, rows.into_iter().map(row).collect()),
                    first,
                    basis,
                    own,
                });
            }
        }
        if n_branches < 2 || is_last {
            return;
        }
        let is_own = |position| self.is_combination(position);
        let tolerance = OF_NODES * self.tolerance;
        if let Some(Carried { first, basis, own, .. }) = left.carry_on(is_own, tolerance, WORTH_UNITING) {
            // In the order of their combinations.
            done.sort_by_key(|node| node.first);
            let of = Rows::United(std::mem::take(done));
            done.push(Completed { of, first, basis, own });
        }
    }
}

/// What eliminated parts leave while combinations take the place of some of it.
struct Left<'a> {
    /// Position that stands for the next combination.
    next: usize,
    beyond: &'a mut Vec<usize>,
    /// Lower triangles over the positions `beyond`.
    matrices: &'a mut [Mat<f64>],
}

/// What combinations have taken the place of.
struct Carried {
    /// The positions.
    rows: Vec<usize>,
    /// That of the first combination.
    first: usize,
    /// A column per combination.
    basis: Mat<f64>,
    /// What is left on the rows.
    own: Vec<Mat<f64>>,
}

impl Left<'_> {
    /// Carries combinations on in the place of some positions, behind all others; none, and nothing is done, if they are more than a part `worth` of these.
    fn carry_on(&mut self, is_own: impl Fn(usize) -> bool, tolerance: f64, worth: f64) -> Option<Carried> {
        let (own, others): (Vec<usize>, Vec<usize>) = (0..self.beyond.len()).partition(|&at| is_own(self.beyond[at]));
        let basis = seen(self.matrices, &own, &others, tolerance);
        let (n, rank, first) = (others.len(), basis.ncols(), self.next);
        if rank as f64 > worth * own.len() as f64 {
            return None;
        }
        let mut local = Vec::with_capacity(self.matrices.len());
        for matrix in self.matrices.iter_mut() {
            local.push(Mat::from_fn(own.len(), own.len(), |i, j| entry(matrix, own[i], own[j])));
            let across = Mat::from_fn(own.len(), n, |i, j| entry(matrix, own[i], others[j]));
            let across = product(basis.transpose(), across.as_ref());
            let mut left = Mat::zeros(n + rank, n + rank);
            for j in 0..n {
                for i in j..n {
                    left[(i, j)] = matrix[(others[i], others[j])];
                }
            }
            left.submatrix_mut(n, 0, rank, n).copy_from(across);
            *matrix = left;
        }
        let rows = own.iter().map(|&at| self.beyond[at]).collect();
        *self.beyond = others.iter().map(|&at| self.beyond[at]).collect();
        self.next += rank;
        self.beyond.extend(first..self.next);
        Some(Carried {
            rows,
            first,
            basis,
            own: local,
        })
    }
}

/// An orthonormal basis of what the `others` see of positions in stiffness and mass, up to a tolerance.
fn seen(matrices: &[Mat<f64>], own: &[usize], others: &[usize], tolerance: f64) -> Mat<f64> {
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
    leading_basis(coupling, tolerance)
}

/// Of a lower triangle.
fn entry(matrix: &Mat<f64>, i: usize, j: usize) -> f64 {
    matrix[(i.max(j), i.min(j))]
}

/// Stiffness and mass over all groups, from what is left of each, from lower triangles `left` over the combinations that are carried on to the end, and from
/// the entries among kept rows, of which the upper triangle is `given` for each matrix.
pub(crate) fn joined(
    grouping: &Grouping,
    mut done: Vec<Completed>,
    left: &[Mat<f64>],
    given: impl Fn(usize) -> Vec<(usize, usize, f64)>,
) -> [SystemMatrix; 2] {
    let n_groups = grouping.complete.len();
    let size = |group: usize| grouping.starts[group + 1] - grouping.starts[group];
    done.sort_by_key(|node| node.first);
    // Groups first, in their order.
    let untouched = |group: usize| Node {
        children: Vec::new(),
        basis: Mat::zeros(size(group), 0),
    };
    let mut found = Joined {
        nodes: (0..n_groups).map(untouched).collect(),
        local: [0, 1].map(|_| {
            (0..n_groups)
                .map(|group| Mat::zeros(size(group), size(group)))
                .collect()
        }),
    };
    // What is left of each of the last nodes, by its number.
    let (mut columns, mut column) = (BTreeMap::new(), 0);
    for last in done {
        let own = column..column + last.basis.ncols();
        column = own.end;
        columns.insert(found.put(last), own);
    }
    let places: Vec<usize> = columns.into_values().flatten().collect();
    let tree = Arc::new(Tree::new(found.nodes));
    let mut local = found.local.into_iter();
    [0, 1].map(|which| {
        let mut local = local.next().unwrap_or_default();
        for (row, column, value) in given(which) {
            let group = grouping.group(grouping.first + row);
            let (row, column) = (row - grouping.starts[group], column - grouping.starts[group]);
            // The lower triangle is read.
            local[group][(column, row)] += value;
        }
        let pack = |block: Mat<f64>| Arc::new(Symmetric::from_lower(block.as_ref()));
        let local = local.into_iter().map(pack).collect();
        let core = Mat::from_fn(places.len(), places.len(), |i, j| {
            entry(&left[which], places[i], places[j])
        });
        SystemMatrix::Blocks(BlockMatrix::new(tree.clone(), local, Vec::new(), core))
    })
}

/// The nodes of a tree and the matrices of each.
struct Joined {
    nodes: Vec<Node>,
    local: [Vec<Mat<f64>>; 2],
}

impl Joined {
    /// Puts a node and all that it unites; gives its number.
    fn put(&mut self, completed: Completed) -> usize {
        match completed.of {
            Rows::Group(group, rows) => {
                let size = self.nodes[group].basis.nrows();
                let mut basis = Mat::zeros(size, completed.basis.ncols());
                for (row, &to) in completed.basis.row_iter().zip(&rows) {
                    basis.row_mut(to).copy_from(row);
                }
                self.nodes[group].basis = basis;
                for (local, own) in self.local.iter_mut().zip(&completed.own) {
                    for (j, &column) in rows.iter().enumerate() {
                        for (i, &row) in rows.iter().enumerate() {
                            local[group][(row, column)] = own[(i, j)];
                        }
                    }
                }
                group
            }
            Rows::United(nodes) => {
                let children = nodes.into_iter().map(|node| self.put(node)).collect();
                self.nodes.push(Node {
                    children,
                    basis: completed.basis,
                });
                for (local, own) in self.local.iter_mut().zip(completed.own) {
                    local.push(own);
                }
                self.nodes.len() - 1
            }
        }
    }
}
