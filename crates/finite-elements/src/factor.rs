//! Sparse multifrontal Cholesky factorisation, blocked solves, and static condensation.
//!
//! Every part of the dissection is eliminated in a dense front: its own rows and, below, the rows still to come that it
//! touches. What it leaves on those is added to the front of its parent. If some rows are kept to the end, what is left
//! there at last is the condensed (Schur) stiffness; and because condensing in steps equals condensing at once, a mass
//! matrix carried along with each step's static displacements leaves the condensed (Guyan) mass.
//!
//! Kept rows may come in groups that lie apart, such as those of the joints of a structure. As soon as all that touches a group is eliminated, what is left
//! of it couples to what is still to come through few combinations of its rows: these alone are carried on ([`crate::groups`]).

use crate::Error;
use crate::groups::{Completed, Grouping, Groups, joined};
use crate::ordering::{Dissection, Ordered, Part, nested_dissection};
use crate::sparse::{LANES, sum};
use dense_algebra::{
    Limits, SystemMatrix, add_product, add_product_lower, add_product_with_lower, cholesky_in_place, mirror_lower,
    product_into, solve_lower, solve_lower_transposed,
};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};
use rayon::prelude::*;
use sprs::CsMat;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Right-hand sides solved together: wide enough to run at the speed of dense products, small enough to stay in cache.
pub const BLOCK: usize = 64;

/// Columns of the factor that are stored together: what stands above the diagonal of a wider front would be stored as zeros.
const PANEL: usize = 256;

/// Operations of a factorisation that take as long as solving for one column with an entry of the factor.
const SOLVING: f64 = 20.0;

/// Subtrees of at most this part of the factor's entries are solved by one thread each.
const SUBTREE: usize = 16;

/// `L L^T` of a symmetric positive definite sparse matrix, or of the rows of one that are not kept.
pub struct SparseCholesky {
    n: usize,
    /// Subtrees of the elimination, which reach none of each other's rows.
    pieces: Vec<Piece>,
    /// What is eliminated after them.
    top: Piece,
}

/// A part of the elimination tree with positions of its own.
struct Piece {
    /// Row of the solution at each position.
    rows: Vec<usize>,
    /// Positions of the top that the piece touches. In the piece they follow its own positions.
    outside: Vec<usize>,
    fronts: Vec<Front>,
}

/// Columns of `L` that follow one another.
struct Front {
    first: usize,
    /// Triangular factor of the columns' own rows.
    lower: Mat<f64>,
    /// Positions after them that they touch, and the rows of `L` there.
    beyond: Vec<usize>,
    below: Mat<f64>,
}

impl Piece {
    /// `x = L^-1 x`; `x` has one column per position, so that the values to gather for a front lie together.
    fn solve_forward(&self, mut x: MatMut<'_, f64>) {
        let mut gathered = self.gathered(x.nrows());
        for front in &self.fronts {
            let mut own = x.rb_mut().subcols_mut(front.first, front.lower.nrows());
            solve_lower(front.lower.as_ref(), own.rb_mut().transpose_mut());
            let mut outer = gathered.subcols_mut(0, front.beyond.len());
            product_into(outer.rb_mut(), own.rb(), front.below.transpose());
            for (from, &to) in front.beyond.iter().enumerate() {
                let to = x.rb_mut().col_mut(to);
                to.iter_mut()
                    .zip(outer.rb().col(from).iter())
                    .for_each(|(a, b)| *a -= b);
            }
        }
    }

    /// `x = L^-T x`.
    fn solve_backward(&self, mut x: MatMut<'_, f64>) {
        let mut gathered = self.gathered(x.nrows());
        for front in self.fronts.iter().rev() {
            let mut outer = gathered.subcols_mut(0, front.beyond.len());
            for (to, &from) in front.beyond.iter().enumerate() {
                outer.rb_mut().col_mut(to).copy_from(x.rb().col(from));
            }
            let mut own = x.rb_mut().subcols_mut(front.first, front.lower.nrows());
            add_product(own.rb_mut(), outer.rb(), front.below.as_ref(), -1.0);
            solve_lower_transposed(front.lower.as_ref(), own.transpose_mut());
        }
    }

    /// Memory for what lies beyond a front.
    fn gathered(&self, width: usize) -> Mat<f64> {
        let longest = self.fronts.iter().map(|front| front.beyond.len()).max();
        Mat::zeros(width, longest.unwrap_or(0))
    }

    /// The rows of `rhs` at the own positions, and zeros outside; as many lanes as fill vector registers, others take several times as long.
    fn gather(&self, rhs: MatRef<'_, f64>) -> Mat<f64> {
        let lanes = rhs.ncols().next_multiple_of(LANES);
        let mut x = Mat::zeros(lanes, self.rows.len() + self.outside.len());
        for (position, &row) in self.rows.iter().enumerate() {
            for lane in 0..rhs.ncols() {
                x[(lane, position)] = rhs[(row, lane)];
            }
        }
        x
    }

    fn scatter(&self, x: MatRef<'_, f64>, mut rhs: MatMut<'_, f64>) {
        for (position, &row) in self.rows.iter().enumerate() {
            for lane in 0..rhs.ncols() {
                rhs[(row, lane)] = x[(lane, position)];
            }
        }
    }
}

/// A symmetric pair that follows from a larger one when its other rows respond statically.
#[derive(Clone, Debug)]
pub struct Condensed {
    /// Stiffness over the kept rows, exactly symmetric.
    pub stiffness: SystemMatrix,
    /// Mass over the kept rows, exactly symmetric.
    pub mass: SystemMatrix,
}

impl std::fmt::Debug for SparseCholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SparseCholesky")
            .field("n", &self.n)
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
        let (factor, _) = Elimination::new(&[matrix], positions, &Groups::none(), &[]).run(name, Limits::default())?;
        Ok(factor)
    }

    /// Factors `stiffness + sigma mass`, for work that takes memory `beside` it (bytes) and then solves for `solves` columns; its limits are given too.
    ///
    /// # Errors
    /// As [`Self::try_new`]; [`Error::Memory`], [`Error::Interrupted`].
    pub(crate) fn of_sum<'a>(
        stiffness: &CsMat<f64>,
        sigma: f64,
        mass: &CsMat<f64>,
        positions: &[[f64; 3]],
        name: &'static str,
        (beside, solves): (u64, usize),
        limits: Limits<'a>,
    ) -> Result<(Self, Limits<'a>), Error> {
        let sum = sum(stiffness, sigma, mass);
        let beside = beside + ((size_of::<f64>() + size_of::<usize>()) * sum.nnz()) as u64;
        let elimination = Elimination::new(&[&sum], positions, &Groups::none(), &[]);
        elimination.refuse_too_large(beside, name, limits)?;
        let (own, entries) = elimination.work();
        let share = own / (own + SOLVING * entries * solves as f64);
        let factor = elimination.run(name, limits.part(0.0, share))?.0;
        Ok((factor, limits.part(share, 1.0)))
    }

    /// Factors a matrix whose rows `held` are coupled to no others.
    ///
    /// # Errors
    /// As [`Self::try_new`]; [`Error::Memory`], [`Error::Interrupted`].
    pub fn holding(
        matrix: &CsMat<f64>,
        positions: &[[f64; 3]],
        held: &[usize],
        name: &'static str,
        limits: Limits<'_>,
    ) -> Result<Self, Error> {
        let elimination = Elimination::new(&[matrix], positions, &Groups::none(), held);
        elimination.refuse_too_large(0, name, limits)?;
        Ok(elimination.run(name, limits)?.0)
    }

    /// Factors all rows of `stiffness` but the first ones, which are `kept`, and condenses it and `mass` onto those. The rows `held` of the
    /// stiffness, none of them kept, are coupled to no others.
    ///
    /// Right-hand sides and solutions of the factor are over the other rows, in their order.
    ///
    /// # Errors
    /// As [`Self::try_new`]; [`Error::Memory`], [`Error::Interrupted`].
    pub fn condense(
        stiffness: &CsMat<f64>,
        mass: &CsMat<f64>,
        positions: &[[f64; 3]],
        kept: &Groups,
        held: &[usize],
        name: &'static str,
        limits: Limits<'_>,
    ) -> Result<(Self, Condensed), Error> {
        let elimination = Elimination::new(&[stiffness, mass], positions, kept, held);
        elimination.refuse_too_large(0, name, limits)?;
        let (factor, mut left) = elimination.run(name, limits)?;
        let rows = factor.n..positions.len();
        if let (Some(grouping), Some(left)) = (&elimination.grouping, &mut left) {
            let done = std::mem::take(&mut left.done);
            let [stiffness, mass] = joined(grouping, done, &left.matrices, |which| {
                let own = rows.clone().flat_map(|row| {
                    let later = elimination.ordered.row(which, row);
                    later.map(move |(column, value)| (row, column, value))
                });
                own.map(|(row, column, value)| (row - rows.start, column - rows.start, value))
                    .collect()
            });
            return Ok((factor, Condensed { stiffness, mass }));
        }
        let [stiffness, mass] = [0, 1].map(|which| {
            let mut own = elimination.assemble(which, &rows, &[], left.as_mut_slice()).own;
            mirror_lower(own.as_mut());
            SystemMatrix::Dense(own)
        });
        Ok((factor, Condensed { stiffness, mass }))
    }

    /// Number of stored entries of the factor.
    pub fn entries(&self) -> usize {
        let pieces = self.pieces.iter().chain(std::iter::once(&self.top));
        pieces.flat_map(|piece| &piece.fronts).map(Front::entries).sum()
    }

    /// Solves for all columns in place, in parallel over blocks of [`BLOCK`] columns and over subtrees of the elimination.
    ///
    /// # Panics
    /// If the number of rows differs from that of the factor.
    pub fn solve_in_place(&self, rhs: MatMut<'_, f64>) {
        assert_eq!(rhs.nrows(), self.n);
        if rhs.ncols() <= BLOCK {
            self.solve_block(rhs);
        } else {
            let blocks: Vec<_> = rhs.par_col_chunks_mut(BLOCK).collect();
            blocks.into_par_iter().for_each(|block| self.solve_block(block));
        }
    }

    fn solve_block(&self, mut rhs: MatMut<'_, f64>) {
        let known = rhs.as_ref();
        let forward = self.pieces.par_iter().with_max_len(1).map(|piece| {
            let mut x = piece.gather(known);
            piece.solve_forward(x.as_mut());
            x
        });
        let mut found: Vec<Mat<f64>> = forward.collect();
        let mut top = self.top.gather(known);
        for (piece, x) in self.pieces.iter().zip(&found) {
            for (at, &to) in (piece.rows.len()..).zip(&piece.outside) {
                let to = top.col_mut(to);
                to.iter_mut().zip(x.col(at).iter()).for_each(|(a, b)| *a += b);
            }
        }
        self.top.solve_forward(top.as_mut());
        self.top.solve_backward(top.as_mut());
        let backward = self.pieces.par_iter().zip(&mut found).with_max_len(1);
        backward.for_each(|(piece, x)| {
            for (at, &from) in (piece.rows.len()..).zip(&piece.outside) {
                x.col_mut(at).copy_from(top.col(from));
            }
            piece.solve_backward(x.as_mut());
        });
        self.top.scatter(top.as_ref(), rhs.rb_mut());
        for (piece, x) in self.pieces.iter().zip(&found) {
            piece.scatter(x.as_ref(), rhs.rb_mut());
        }
    }

    /// Sorts the fronts of each part of a dissection into subtrees. All positions are those of the elimination, of `n` rows.
    fn new(order: Vec<usize>, parts: &[Part], fronts: Vec<Vec<Front>>) -> Self {
        let entries: Vec<usize> = fronts
            .iter()
            .map(|fronts| fronts.iter().map(Front::entries).sum())
            .collect();
        let largest = entries.iter().sum::<usize>() / SUBTREE;
        // The number of the first part of each subtree, and its entries.
        let mut subtree: Vec<(usize, usize)> = Vec::with_capacity(parts.len());
        for (number, part) in parts.iter().enumerate() {
            let children = part.children.iter().map(|&child| subtree[child]);
            subtree.push(children.fold((number, entries[number]), |(first, sum), (other, more)| {
                (first.min(other), sum + more)
            }));
        }
        let mut roots: Vec<usize> = Vec::new();
        let mut open: Vec<usize> = parts.len().checked_sub(1).into_iter().collect();
        while let Some(part) = open.pop() {
            match subtree[part].1 <= largest {
                true => roots.push(part),
                false => open.extend(&parts[part].children),
            }
        }
        roots.sort_unstable();
        // The piece of each position, none for those of the top, and its number there.
        let mut place: Vec<(Option<usize>, usize)> = vec![(None, 0); order.len()];
        let piece = || Piece {
            rows: Vec::new(),
            outside: Vec::new(),
            fronts: Vec::new(),
        };
        let (mut top, mut pieces) = (piece(), Vec::with_capacity(roots.len()));
        let mut fronts = fronts.into_iter();
        let (mut next, mut position) = (0, 0);
        for (index, root) in roots.iter().copied().map(Some).chain(std::iter::once(None)).enumerate() {
            let first = root.map_or(parts.len(), |root| subtree[root].0);
            top.fronts.extend(fronts.by_ref().take(first - next).flatten());
            let start = parts.get(first).map_or(order.len(), |part| part.rows.start);
            for at in position..start {
                place[at] = (None, top.rows.len());
                top.rows.push(order[at]);
            }
            let Some(root) = root else { break };
            let mut own = piece();
            own.fronts.extend(fronts.by_ref().take(root + 1 - first).flatten());
            for at in start..parts[root].rows.end {
                place[at] = (Some(index), own.rows.len());
                own.rows.push(order[at]);
            }
            pieces.push(own);
            (next, position) = (root + 1, parts[root].rows.end);
        }
        for front in &mut top.fronts {
            front.first = place[front.first].1;
            front
                .beyond
                .iter_mut()
                .for_each(|position| *position = place[*position].1);
        }
        for (index, piece) in pieces.iter_mut().enumerate() {
            let is_outside = |position: &&usize| place[**position].0 != Some(index);
            let beyond = piece.fronts.iter().flat_map(|front| &front.beyond);
            let mut outside: Vec<usize> = beyond.filter(is_outside).map(|&position| place[position].1).collect();
            outside.sort_unstable();
            outside.dedup();
            for front in &mut piece.fronts {
                front.first = place[front.first].1;
                for position in &mut front.beyond {
                    *position = match place[*position] {
                        (Some(_), own) => own,
                        (None, of_top) => piece.rows.len() + outside.partition_point(|&other| other < of_top),
                    };
                }
            }
            piece.outside = outside;
        }
        Self {
            n: order.len(),
            pieces,
            top,
        }
    }
}

impl Front {
    fn entries(&self) -> usize {
        self.lower.nrows() * (self.lower.ncols() + self.below.nrows())
    }

    /// The fronts of the columns from `first` on, whose triangular factor is `lower` and whose rows of `L` at the positions `beyond` are `below`.
    fn panels(first: usize, lower: Mat<f64>, beyond: &[usize], below: MatRef<'_, f64>) -> Vec<Self> {
        let n = lower.nrows();
        let panel = |start: usize| {
            let (end, n_beyond) = (n.min(start + PANEL), beyond.len());
            let mut rows = Mat::zeros(n - end + n_beyond, end - start);
            let own = lower.submatrix(end, start, n - end, end - start);
            rows.subrows_mut(0, n - end).copy_from(own);
            let others = below.submatrix(0, start, n_beyond, end - start);
            rows.subrows_mut(n - end, n_beyond).copy_from(others);
            Self {
                first: first + start,
                lower: lower.submatrix(start, start, end - start, end - start).to_owned(),
                beyond: (first + end..first + n).chain(beyond.iter().copied()).collect(),
                below: rows,
            }
        };
        (0..n).step_by(PANEL).map(panel).collect()
    }
}

/// An elimination that is laid out.
struct Elimination<'a> {
    dissection: Dissection,
    ordered: Ordered<'a>,
    /// For each part the later positions that it touches by itself or through its children.
    beyond: Vec<Vec<usize>>,
    /// How kept rows are grouped, if they are.
    grouping: Option<Grouping>,
}

/// What eliminated parts leave on later rows: lower triangles over the positions `beyond`, one per matrix.
struct Update {
    beyond: Vec<usize>,
    matrices: Vec<Mat<f64>>,
    /// Groups of kept rows of which combinations alone are carried on.
    done: Vec<Completed>,
}

/// A symmetric matrix over the rows of a part (`own`) and those beyond; only lower triangles are set.
struct Blocks {
    own: Mat<f64>,
    below: Mat<f64>,
    update: Mat<f64>,
}

impl<'a> Elimination<'a> {
    fn new(matrices: &[&'a CsMat<f64>], positions: &[[f64; 3]], kept: &Groups, held: &[usize]) -> Self {
        let n_kept = kept.len();
        let dissection = nested_dissection(matrices[0], positions, n_kept);
        let order: Vec<usize> = dissection.order.iter().copied().chain(0..n_kept).collect();
        let ordered = Ordered::new(matrices, order, held);
        let beyond = positions_beyond(&dissection, &ordered);
        let grouping = Grouping::try_new(kept, &dissection, &ordered);
        Self {
            dissection,
            ordered,
            beyond,
            grouping,
        }
    }

    /// Refuses more work than there is memory for, with `beside` for what is needed at the same time (bytes).
    fn refuse_too_large(&self, beside: u64, matrix: &'static str, limits: Limits<'_>) -> Result<(), Error> {
        refuse_beyond(self.memory() + beside, matrix, limits)
    }

    /// Memory that it takes at its peak (bytes), where parts are eliminated one after the other: fronts in work, what waits for their parents,
    /// and the factor. Threads that work on several small parts at once take little more.
    fn memory(&self) -> u64 {
        let n = self.dissection.order.len();
        let (mut factor, mut peak) = (0, 0);
        // Of each part: what it leaves, and the most that it and its children take.
        let mut found: Vec<[usize; 2]> = Vec::with_capacity(self.beyond.len());
        for (part, beyond) in self.dissection.parts.iter().zip(&self.beyond) {
            let own = part.rows.len();
            let below = match &self.grouping {
                Some(grouping) => grouping.expected(found.len(), beyond),
                None => beyond.len(),
            };
            let n_matrices = self.n_matrices();
            let (mut waiting, mut most) = (0, 0);
            for &child in &part.children {
                most = most.max(waiting + found[child][1]);
                waiting += found[child][0];
            }
            let front = own * (own + 2 * below) + n_matrices * below * below;
            most = most.max(waiting + front);
            factor += own * (own.min(PANEL) + own) / 2 + own * beyond.partition_point(|&position| position < n);
            peak = peak.max(factor + most);
            found.push([n_matrices * below * below, most]);
        }
        (size_of::<f64>() * peak) as u64
    }

    fn n_matrices(&self) -> usize {
        self.ordered.matrices.len()
    }

    /// All rows, of which some are kept.
    fn n_rows(&self) -> usize {
        self.ordered.order.len()
    }

    /// Rows of a part and, as far as is expected, rows beyond it.
    fn sizes(&self, number: usize) -> [f64; 2] {
        let beyond = &self.beyond[number];
        let below = match &self.grouping {
            Some(grouping) => grouping.expected(number, beyond),
            None => beyond.len(),
        };
        [self.dissection.parts[number].rows.len() as f64, below as f64]
    }

    /// Floating-point operations that it takes, and entries of the factor.
    fn work(&self) -> (f64, f64) {
        let sizes = (0..self.beyond.len()).map(|number| self.sizes(number));
        sizes.fold((0.0, 0.0), |(work, entries), sizes| {
            let [own, below] = sizes;
            (
                work + operations(sizes, self.n_matrices()).iter().sum::<f64>(),
                entries + own * (0.5 * own + below),
            )
        })
    }

    /// The factor, and what is left on the kept rows.
    fn run(&self, name: &'static str, limits: Limits<'_>) -> Result<(SparseCholesky, Option<Update>), Error> {
        let tally = Tally {
            limits,
            all: self.work().0,
            done: AtomicU64::new(0),
        };
        let parts = &self.dissection.parts;
        let n_kept = self.n_rows() - self.dissection.order.len();
        let order = self.dissection.order.iter().map(|row| row - n_kept).collect();
        let (fronts, left) = match parts.len() {
            0 => (Vec::new(), None),
            n_parts => {
                let (fronts, left) = self.eliminate(n_parts - 1, name, &tally)?;
                (fronts, Some(left))
            }
        };
        Ok((SparseCholesky::new(order, parts, fronts), left))
    }

    /// Eliminates a part after its children; the fronts of each part come in the order of the dissection.
    fn eliminate(
        &self,
        number: usize,
        name: &'static str,
        tally: &Tally<'_>,
    ) -> Result<(Vec<Vec<Front>>, Update), Error> {
        tally.add(0.0)?;
        let part = &self.dissection.parts[number];
        let rows = part.rows.clone();
        let eliminated: Vec<_> = part
            .children
            .par_iter()
            .map(|&child| self.eliminate(child, name, tally))
            .collect();
        let (mut fronts, mut children, mut done) = (Vec::new(), Vec::with_capacity(eliminated.len()), Vec::new());
        for child in eliminated {
            let (before, mut update) = child?;
            fronts.extend(before);
            done.append(&mut update.done);
            children.push(update);
        }
        let mut beyond = self.beyond[number].clone();
        if let Some(grouping) = &self.grouping {
            grouping.replace(number, &mut beyond, children.iter().flat_map(|child| &child.beyond));
        }
        if self.grouping.is_some() {
            // Joints may see more of one another than was expected.
            let (own, below) = (rows.len(), beyond.len());
            let needed = (size_of::<f64>() * self.n_matrices() * (own + below) * (own + below)) as u64;
            refuse_beyond(needed, name, tally.limits)?;
        }
        let [factor, solve, product, follow_up, momentum, twice] =
            operations([rows.len() as f64, beyond.len() as f64], self.n_matrices());
        let n = self.dissection.order.len();
        let Blocks {
            own,
            mut below,
            mut update,
        } = self.assemble(0, &rows, &beyond, &mut children);
        let lower = cholesky_in_place(own).map_err(|error| match error {
            dense_algebra::Error::NotPositiveDefinite { pivot, .. } => Error::NotPositiveDefinite {
                matrix: name,
                pivot: self.dissection.order[rows.start + pivot],
                size: self.n_rows(),
            },
            other => other.into(),
        })?;
        // Between the large products of a front too, as the last fronts are most of the work.
        tally.add(factor)?;
        solve_lower(lower.as_ref(), below.transpose_mut());
        tally.add(solve)?;
        add_product_lower(update.as_mut(), below.as_ref(), below.transpose(), -1.0);
        tally.add(product)?;
        let mut matrices = vec![update];
        if self.n_matrices() > 1 {
            let mut mass = self.assemble(1, &rows, &beyond, &mut children);
            // Half of the own mass: a triangle that makes it up with its transpose.
            for row in 0..rows.len() {
                mass.own[(row, row)] *= 0.5;
            }
            // The rows follow those beyond by follow^T: their momentum, and that of the rows beyond, is felt there.
            let mut follow = below.clone();
            solve_lower_transposed(lower.as_ref(), follow.transpose_mut());
            tally.add(follow_up)?;
            add_product_with_lower(mass.below.as_mut(), follow.as_ref(), mass.own.as_ref(), -1.0);
            tally.add(momentum)?;
            add_product_lower(mass.update.as_mut(), follow.as_ref(), mass.below.transpose(), -1.0);
            tally.add(0.5 * twice)?;
            add_product_lower(mass.update.as_mut(), mass.below.as_ref(), follow.transpose(), -1.0);
            tally.add(0.5 * twice)?;
            matrices.push(mass.update);
        }
        // Right-hand sides do not reach the kept rows.
        let n_beyond = beyond.partition_point(|&position| position < n);
        let below = below.subrows(0, n_beyond);
        fronts.push(Front::panels(rows.start, lower, &beyond[..n_beyond], below));
        if let Some(grouping) = &self.grouping {
            let n_branches = children
                .iter()
                .filter(|child| grouping.carries(child.beyond.last()))
                .count();
            grouping.complete(number, n_branches, &mut beyond, &mut matrices, &mut done);
        }
        let left = Update { beyond, matrices, done };
        Ok((fronts, left))
    }

    /// A matrix over a part and the positions beyond it, with what the part's children left there, which is freed.
    fn assemble(&self, which: usize, rows: &Range<usize>, beyond: &[usize], children: &mut [Update]) -> Blocks {
        let (n_own, n_beyond) = (rows.len(), beyond.len());
        let mut own = Mat::zeros(n_own, n_own);
        let mut below = Mat::zeros(n_beyond, n_own);
        let mut update = Mat::zeros(n_beyond, n_beyond);
        let local = |position: usize| match position < rows.end {
            true => position - rows.start,
            false => n_own + beyond.partition_point(|&other| other < position),
        };
        for (column, row) in rows.clone().enumerate() {
            for (position, value) in self.ordered.row(which, row) {
                match local(position) {
                    i if i < n_own => own[(i, column)] = value,
                    i => below[(i - n_own, column)] = value,
                }
            }
        }
        for child in children {
            let left = std::mem::replace(&mut child.matrices[which], Mat::new());
            let places: Vec<usize> = child.beyond.iter().map(|&position| local(position)).collect();
            let n_inside = places.partition_point(|&place| place < n_own);
            let (inside, outside) = places.split_at(n_inside);
            for (j, &column) in places.iter().enumerate() {
                let left = left.col(j);
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

/// Floating-point operations of a front with `own` rows and `below` them others: factor, the rows below, what is left there; with a mass also its static
/// displacements, their momentum, and what that leaves.
fn operations([own, below]: [f64; 2], n_matrices: usize) -> [f64; 6] {
    let solve = own * own * below;
    let product = own * below * below;
    let mass = if n_matrices > 1 { 1.0 } else { 0.0 };
    [
        own * own * own / 3.0,
        solve,
        product,
        mass * solve,
        mass * solve,
        mass * 2.0 * product,
    ]
}

/// Operations of an elimination that are done.
struct Tally<'a> {
    limits: Limits<'a>,
    all: f64,
    done: AtomicU64,
}

impl Tally<'_> {
    /// Tells that so many more are, and whether to go on.
    fn add(&self, operations: f64) -> Result<(), Error> {
        let more = operations as u64;
        let done = more + self.done.fetch_add(more, Ordering::Relaxed);
        self.limits.done(done as f64 / self.all.max(1.0));
        match self.limits.stops() {
            true => Err(Error::Interrupted),
            false => Ok(()),
        }
    }
}

/// Refuses what needs more memory than there is (bytes).
fn refuse_beyond(needed: u64, matrix: &'static str, limits: Limits<'_>) -> Result<(), Error> {
    match limits.memory() {
        Some(limit) if needed > limit => Err(Error::Memory { matrix, needed, limit }),
        _ => Ok(()),
    }
}

/// For each part the positions after it that it touches by itself or through its children, ascending.
fn positions_beyond(dissection: &Dissection, ordered: &Ordered<'_>) -> Vec<Vec<usize>> {
    let mut beyond: Vec<Vec<usize>> = Vec::with_capacity(dissection.parts.len());
    let mut seen = vec![usize::MAX; ordered.order.len()];
    for (number, part) in dissection.parts.iter().enumerate() {
        let own = part.rows.clone().flat_map(|row| ordered.touched(row));
        let mut found = Vec::new();
        let of_children = part.children.iter().flat_map(|&child| beyond[child].iter().copied());
        for position in own.chain(of_children) {
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
