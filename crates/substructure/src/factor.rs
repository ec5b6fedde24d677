//! Sparse multifrontal Cholesky factorisation, blocked solves, and static condensation.
//!
//! Every part of the dissection is eliminated in a dense front: its own rows and, below, the rows still to come that it
//! touches. What it leaves on those is added to the front of its parent. If some rows are kept to the end, what is left
//! there at last is the condensed (Schur) stiffness; and because condensing in steps equals condensing at once, a mass
//! matrix carried along with each step's static displacements leaves the condensed (Guyan) mass.

use crate::Error;
use crate::ordering::{Dissection, nested_dissection};
use crate::sparse::{entries, from_unsorted_rows};
use dense_algebra::{add_product, add_product_lower, cholesky, product_into, solve_lower, solve_lower_transposed};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut};
use rayon::prelude::*;
use sprs::CsMat;
use std::ops::Range;

/// Right-hand sides solved together: wide enough to run at the speed of dense products, small enough to stay in cache.
pub const BLOCK: usize = 64;

/// `L L^T` of a symmetric positive definite sparse matrix, or of the rows of one that are not kept.
pub struct SparseCholesky {
    /// Row of the solution at each position of the elimination.
    order: Vec<usize>,
    fronts: Vec<Front>,
}

/// Columns of `L` that belong to one part.
struct Front {
    first: usize,
    /// Triangular factor of the part itself.
    lower: Mat<f64>,
    /// Positions after the part that it touches, and the rows of `L` there.
    beyond: Vec<usize>,
    below: Mat<f64>,
}

/// A symmetric pair that follows from a larger one when its other rows respond statically.
#[derive(Clone, Debug)]
pub struct Condensed {
    /// Stiffness over the kept rows, exactly symmetric.
    pub stiffness: Mat<f64>,
    /// Mass over the kept rows, exactly symmetric.
    pub mass: Mat<f64>,
}

impl std::fmt::Debug for SparseCholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SparseCholesky")
            .field("n", &self.order.len())
            .field("entries", &self.entries())
            .finish()
    }
}

impl SparseCholesky {
    /// Factors `matrix` (full symmetric storage); `positions` (one per row) guide the ordering, `name` is for messages.
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`] with the row at which the factorisation stopped.
    pub fn try_new(matrix: &CsMat<f64>, positions: &[[f64; 3]], name: &'static str) -> Result<Self, Error> {
        let (factor, _) = Elimination::new(&[matrix], positions, 0, &[]).run(name)?;
        Ok(factor)
    }

    /// Factors all rows of `stiffness` but the first `n_kept`, and condenses it and `mass` onto those. The rows `held` of the
    /// stiffness, none of them kept, are coupled to no others.
    ///
    /// Right-hand sides and solutions of the factor are over the other rows, in their order.
    ///
    /// # Errors
    /// As [`Self::try_new`].
    pub fn condense(
        stiffness: &CsMat<f64>,
        mass: &CsMat<f64>,
        positions: &[[f64; 3]],
        n_kept: usize,
        held: &[usize],
        name: &'static str,
    ) -> Result<(Self, Condensed), Error> {
        let elimination = Elimination::new(&[stiffness, mass], positions, n_kept, held);
        let (factor, left) = elimination.run(name)?;
        let kept = factor.order.len()..positions.len();
        let [stiffness, mass] = [0, 1].map(|which| {
            let mut own = elimination.assemble(which, &kept, &[], left.as_slice()).own;
            mirror(&mut own);
            own
        });
        Ok((factor, Condensed { stiffness, mass }))
    }

    /// Number of stored entries of the factor.
    pub fn entries(&self) -> usize {
        let stored = |mat: &Mat<f64>| mat.nrows() * mat.ncols();
        self.fronts
            .iter()
            .map(|front| stored(&front.lower) + stored(&front.below))
            .sum()
    }

    /// Solves for all columns in place, in parallel over blocks of [`BLOCK`] columns.
    ///
    /// # Panics
    /// If the number of rows differs from that of the factor.
    pub fn solve_in_place(&self, rhs: MatMut<'_, f64>) {
        assert_eq!(rhs.nrows(), self.order.len());
        if rhs.ncols() <= BLOCK {
            self.solve_block(rhs);
        } else {
            let blocks: Vec<_> = rhs.par_col_chunks_mut(BLOCK).collect();
            blocks.into_par_iter().for_each(|block| self.solve_block(block));
        }
    }

    fn solve_block(&self, mut rhs: MatMut<'_, f64>) {
        let width = rhs.ncols();
        // One column per position, so that the values to gather for a front lie together.
        let mut x = Mat::zeros(width, self.order.len());
        for (position, &row) in self.order.iter().enumerate() {
            for lane in 0..width {
                x[(lane, position)] = rhs[(row, lane)];
            }
        }
        let longest = self.fronts.iter().map(|front| front.beyond.len()).max().unwrap_or(0);
        let mut gathered = Mat::zeros(width, longest);
        for front in &self.fronts {
            let mut own = x.subcols_mut(front.first, front.lower.nrows());
            solve_lower(front.lower.as_ref(), own.rb_mut().transpose_mut());
            let mut outer = gathered.subcols_mut(0, front.beyond.len());
            product_into(outer.rb_mut(), own.rb(), front.below.transpose());
            for (from, &to) in front.beyond.iter().enumerate() {
                x.col_mut(to)
                    .iter_mut()
                    .zip(outer.rb().col(from).iter())
                    .for_each(|(a, b)| *a -= b);
            }
        }
        for front in self.fronts.iter().rev() {
            let mut outer = gathered.subcols_mut(0, front.beyond.len());
            for (to, &from) in front.beyond.iter().enumerate() {
                outer.rb_mut().col_mut(to).copy_from(x.col(from));
            }
            let mut own = x.subcols_mut(front.first, front.lower.nrows());
            add_product(own.rb_mut(), outer.rb(), front.below.as_ref(), -1.0);
            solve_lower_transposed(front.lower.as_ref(), own.transpose_mut());
        }
        for (position, &row) in self.order.iter().enumerate() {
            for lane in 0..width {
                rhs[(row, lane)] = x[(lane, position)];
            }
        }
    }
}

/// A stiffness, and perhaps a mass, in the order of their elimination, kept rows last.
struct Elimination {
    dissection: Dissection,
    /// Their upper triangles: row `k` is column `k` of the lower ones.
    matrices: Vec<CsMat<f64>>,
    /// For each part the later positions that it touches by itself or through its children.
    beyond: Vec<Vec<usize>>,
}

/// What eliminated parts leave on later rows: lower triangles over the positions `beyond`, one per matrix.
struct Update<'a> {
    beyond: &'a [usize],
    matrices: Vec<Mat<f64>>,
}

/// A symmetric matrix over the rows of a part (`own`) and those beyond; only lower triangles are set.
struct Blocks {
    own: Mat<f64>,
    below: Mat<f64>,
    update: Mat<f64>,
}

impl Elimination {
    fn new(matrices: &[&CsMat<f64>], positions: &[[f64; 3]], n_kept: usize, held: &[usize]) -> Self {
        let n = positions.len();
        let dissection = nested_dissection(matrices[0], positions, n_kept);
        let order: Vec<usize> = dissection.order.iter().copied().chain(0..n_kept).collect();
        let mut position = vec![0; n];
        for (at, &row) in order.iter().enumerate() {
            position[row] = at;
        }
        let mut is_held = vec![false; n];
        held.iter().for_each(|&row| is_held[row] = true);
        let none_is_held = vec![false; n];
        let matrices: Vec<_> = matrices
            .iter()
            .zip([&is_held, &none_is_held])
            .map(|(matrix, alone)| upper_triangle(matrix, &order, &position, alone))
            .collect();
        let beyond = positions_beyond(&dissection, &matrices);
        Self {
            dissection,
            matrices,
            beyond,
        }
    }

    /// The factor, and what is left on the kept rows.
    fn run(&self, name: &'static str) -> Result<(SparseCholesky, Option<Update<'_>>), Error> {
        let n_kept = self.matrices[0].rows() - self.dissection.order.len();
        let order = self.dissection.order.iter().map(|row| row - n_kept).collect();
        let (fronts, left) = match self.dissection.parts.len() {
            0 => (Vec::new(), None),
            n_parts => {
                let (fronts, left) = self.eliminate(n_parts - 1, name)?;
                (fronts, Some(left))
            }
        };
        Ok((SparseCholesky { order, fronts }, left))
    }

    /// Eliminates a part after its children; fronts come in the order of the dissection.
    fn eliminate(&self, number: usize, name: &'static str) -> Result<(Vec<Front>, Update<'_>), Error> {
        let part = &self.dissection.parts[number];
        let rows = part.rows.clone();
        let done: Vec<_> = part
            .children
            .par_iter()
            .map(|&child| self.eliminate(child, name))
            .collect();
        let (mut fronts, mut children) = (Vec::new(), Vec::with_capacity(done.len()));
        for child in done {
            let (before, update) = child?;
            fronts.extend(before);
            children.push(update);
        }
        let beyond = &self.beyond[number];
        let n = self.dissection.order.len();
        let Blocks {
            own,
            mut below,
            mut update,
        } = self.assemble(0, &rows, beyond, &children);
        let mass = (self.matrices.len() > 1).then(|| self.assemble(1, &rows, beyond, &children));
        drop(children);
        let lower = cholesky(own.as_ref()).map_err(|error| match error {
            dense_algebra::Error::NotPositiveDefinite { pivot, .. } => Error::NotPositiveDefinite {
                matrix: name,
                pivot: self.dissection.order[rows.start + pivot],
                size: self.matrices[0].rows(),
            },
            other => other.into(),
        })?;
        solve_lower(lower.as_ref(), below.transpose_mut());
        add_product_lower(update.as_mut(), below.as_ref(), below.transpose(), -1.0);
        let mut matrices = vec![update];
        if let Some(mut mass) = mass {
            mirror(&mut mass.own);
            // The rows follow those beyond by follow^T: their momentum, and that of the rows beyond, is felt there.
            let mut follow = below.clone();
            solve_lower_transposed(lower.as_ref(), follow.transpose_mut());
            add_product(mass.below.as_mut(), follow.as_ref(), mass.own.as_ref(), -0.5);
            add_product_lower(mass.update.as_mut(), follow.as_ref(), mass.below.transpose(), -1.0);
            add_product_lower(mass.update.as_mut(), mass.below.as_ref(), follow.transpose(), -1.0);
            matrices.push(mass.update);
        }
        // Right-hand sides do not reach the kept rows.
        let n_beyond = beyond.partition_point(|&position| position < n);
        fronts.push(Front {
            first: rows.start,
            lower,
            beyond: beyond[..n_beyond].to_vec(),
            below: match n_beyond == below.nrows() {
                true => below,
                false => below.subrows(0, n_beyond).to_owned(),
            },
        });
        Ok((fronts, Update { beyond, matrices }))
    }

    /// A matrix over a part and the positions beyond it, with what the part's children left there.
    fn assemble(&self, which: usize, rows: &Range<usize>, beyond: &[usize], children: &[Update<'_>]) -> Blocks {
        let (n_own, n_beyond) = (rows.len(), beyond.len());
        let mut own = Mat::zeros(n_own, n_own);
        let mut below = Mat::zeros(n_beyond, n_own);
        let mut update = Mat::zeros(n_beyond, n_beyond);
        let local = |position: usize| match position < rows.end {
            true => position - rows.start,
            false => n_own + beyond.partition_point(|&other| other < position),
        };
        for (column, row) in rows.clone().enumerate() {
            let matrix = &self.matrices[which];
            let range = matrix.indptr().outer_inds_sz(row);
            for (&position, &value) in matrix.indices()[range.clone()].iter().zip(&matrix.data()[range]) {
                match local(position) {
                    i if i < n_own => own[(i, column)] = value,
                    i => below[(i - n_own, column)] = value,
                }
            }
        }
        for child in children {
            let places: Vec<usize> = child.beyond.iter().map(|&position| local(position)).collect();
            let n_inside = places.partition_point(|&place| place < n_own);
            let (inside, outside) = places.split_at(n_inside);
            for (j, &column) in places.iter().enumerate() {
                let left = child.matrices[which].col(j);
                if j < n_inside {
                    for (i, &row) in inside.iter().enumerate().skip(j) {
                        own[(row, column)] += left[i];
                    }
                    for (i, &row) in outside.iter().enumerate() {
                        below[(row - n_own, column)] += left[n_inside + i];
                    }
                } else {
                    for (i, &row) in outside.iter().enumerate().skip(j - n_inside) {
                        update[(row - n_own, column - n_own)] += left[n_inside + i];
                    }
                }
            }
        }
        Blocks { own, below, update }
    }
}

/// Copies the lower triangle to the upper one.
fn mirror(matrix: &mut Mat<f64>) {
    for j in 0..matrix.ncols() {
        for i in 0..j {
            matrix[(i, j)] = matrix[(j, i)];
        }
    }
}

/// The upper triangle of a symmetric matrix in the given order: row `k` holds the entries of the row `order[k]` at its own and
/// later positions. What couples a row that is `alone` is zero.
fn upper_triangle(matrix: &CsMat<f64>, order: &[usize], position: &[usize], alone: &[bool]) -> CsMat<f64> {
    from_unsorted_rows(matrix.shape(), |at| {
        let row = order[at];
        entries(matrix, row).filter_map(move |(column, value)| {
            let is_coupling = row != column && (alone[row] || alone[column]);
            let value = if is_coupling { 0.0 } else { value };
            (position[column] >= at).then_some((position[column], value))
        })
    })
}

/// For each part the positions after it that it touches by itself or through its children, ascending.
fn positions_beyond(dissection: &Dissection, matrices: &[CsMat<f64>]) -> Vec<Vec<usize>> {
    let mut beyond: Vec<Vec<usize>> = Vec::with_capacity(dissection.parts.len());
    let mut seen = vec![usize::MAX; matrices[0].rows()];
    for (number, part) in dissection.parts.iter().enumerate() {
        let own = matrices.iter().flat_map(|matrix| {
            let touched = |row| &matrix.indices()[matrix.indptr().outer_inds_sz(row)];
            part.rows.clone().flat_map(touched)
        });
        let mut found = Vec::new();
        for &position in own.chain(part.children.iter().flat_map(|&child| &beyond[child])) {
            if position >= part.rows.end && seen[position] != number {
                seen[position] = number;
                found.push(position);
            }
        }
        found.sort_unstable();
        beyond.push(found);
    }
    beyond
}
