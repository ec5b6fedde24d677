//! Symmetric matrices over groups of coordinates that are coupled through few combinations of each: block low rank, in a tree.
//!
//! `A = sum_s T_s A_s T_s^T + diag(0, d) + T C T^T`. The nodes `s` of a [`Tree`] are groups, and above them nodes whose coordinates are the combinations that
//! are seen of other nodes, so that `T_s` is one for a group and `T_s = [.., T_c B_c, ..]` over the children `c` of others. `d` is a diagonal over the coordinates that
//! follow the groups, and the dense core `C` is over them and the combinations that no node unites with others. Memory and products cost the sum of the
//! squares of the nodes.

use crate::bases::DEPENDENT;
use crate::packed::Symmetric;
use crate::tree::{Node, Tree};
use crate::{Error, cholesky_in_place, product, solve_general_all, solve_lower, solve_lower_transposed, symmetric};
use faer::{Mat, MatRef};
use rayon::prelude::*;
use std::sync::Arc;

/// A symmetric matrix of groups of coordinates and a few more behind them. Its inverse has the same form.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockMatrix {
    tree: Arc<Tree>,
    /// `A_s`. Matrices that differ in their coupling share them.
    local: Vec<Arc<Symmetric>>,
    /// `d`.
    rest: Vec<f64>,
    /// `C` over the combinations that no node unites with others, and the rest.
    core: Mat<f64>,
}

/// What the inverse has of a node.
struct Inverted {
    local: Symmetric,
    /// How its coordinates follow what acts on its combinations.
    response: Mat<f64>,
    /// What of that its combinations see.
    compliance: Mat<f64>,
}

impl BlockMatrix {
    /// The matrix of these parts; `core` is over the combinations that no node of the tree unites with others, and the rest.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn new(tree: Arc<Tree>, local: Vec<Arc<Symmetric>>, rest: Vec<f64>, core: Mat<f64>) -> Self {
        assert_eq!(tree.nodes().len(), local.len());
        for (node, block) in tree.nodes().iter().zip(&local) {
            assert_eq!(node.basis.nrows(), block.size());
        }
        let size = tree.rank() + rest.len();
        assert_eq!(core.shape(), (size, size));
        Self {
            tree,
            local,
            rest,
            core,
        }
    }

    /// Rows and columns.
    pub fn size(&self) -> usize {
        self.tree.n_coordinates() + self.rest.len()
    }

    /// Whether a product with its inverse takes fewer numbers than one with a dense inverse, both symmetric.
    pub fn is_smaller_than_dense(&self) -> bool {
        let square = |n: usize| n * n;
        let of_node = |node: &Node| square(node.basis.nrows()) / 2 + 2 * node.basis.nrows() * node.basis.ncols();
        let nodes: usize = self.tree.nodes().iter().map(of_node).sum();
        nodes + square(self.core.nrows()) < square(self.size()) / 2
    }

    /// Groups and combinations, which matrices of one structure share.
    pub fn tree(&self) -> &Arc<Tree> {
        &self.tree
    }

    /// The matrix of each node of the tree.
    pub fn local(&self) -> &[Arc<Symmetric>] {
        &self.local
    }

    /// The diagonal behind the groups.
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// The core.
    pub fn core(&self) -> MatRef<'_, f64> {
        self.core.as_ref()
    }

    /// Combinations of the groups that the core is over, before the rest.
    pub fn rank(&self) -> usize {
        self.tree.rank()
    }

    /// The core with the diagonal behind the groups on its own: what is left of the matrix without its nodes.
    pub fn seen(&self) -> Mat<f64> {
        let mut seen = self.core.clone();
        let first = self.rank();
        for (k, d) in self.rest.iter().enumerate() {
            seen[(first + k, first + k)] += d;
        }
        seen
    }

    /// The matrix with the same nodes and another such core, over any number of coordinates behind the groups.
    ///
    /// # Panics
    /// If it is smaller than the rank.
    #[must_use]
    pub fn with_seen(&self, mut seen: Mat<f64>) -> Self {
        let rest = (self.rank()..seen.nrows())
            .map(|k| std::mem::take(&mut seen[(k, k)]))
            .collect();
        Self::new(self.tree.clone(), self.local.clone(), rest, seen)
    }

    /// The tree with more combinations, so that their space contains those of `columns` over all coordinates, but for what is below `least` of a whole column.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn extended_tree(&self, columns: MatRef<'_, f64>, least: f64) -> Arc<Tree> {
        let least: Vec<f64> = columns.col_iter().map(|column| least * column.norm_l2()).collect();
        Arc::new(self.tree.extended(columns, &least))
    }

    /// The same matrix over a tree whose combinations begin with its own.
    ///
    /// # Panics
    /// If the shapes do not fit.
    #[must_use]
    pub fn over_tree(&self, tree: &Arc<Tree>) -> Self {
        let places = |nodes: &[usize]| self.tree.places_of(nodes, |node| tree.nodes()[node].basis.ncols());
        let spread = |matrix: MatRef<'_, f64>, places: &[usize], size: usize| {
            let mut wider = Mat::zeros(size, size);
            for (j, &column) in places.iter().enumerate() {
                for (i, &row) in places.iter().enumerate() {
                    wider[(row, column)] = matrix[(i, j)];
                }
            }
            wider
        };
        let local = tree.nodes().iter().zip(&self.local).map(|(node, own)| {
            let size = node.basis.nrows();
            match size == own.size() {
                true => own.clone(),
                false => {
                    let wider = spread(own.to_dense().as_ref(), &places(&node.children), size);
                    Arc::new(Symmetric::from_lower(wider.as_ref()))
                }
            }
        });
        let mut of_core = places(self.tree.tops());
        of_core.extend(tree.rank()..tree.rank() + self.rest.len());
        let core = spread(self.core(), &of_core, tree.rank() + self.rest.len());
        Self::new(tree.clone(), local.collect(), self.rest.clone(), core)
    }

    /// This matrix and a factor times another one over the same tree.
    ///
    /// # Panics
    /// If the shapes do not fit.
    #[must_use]
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let local = self.local.iter().zip(&other.local);
        let (a, b) = (&self.core, &other.core);
        Self {
            tree: self.tree.clone(),
            local: local.map(|(a, b)| Arc::new(a.plus(factor, b))).collect(),
            rest: self.rest.iter().zip(&other.rest).map(|(a, b)| a + factor * b).collect(),
            core: Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] + factor * b[(i, j)]),
        }
    }

    /// The matrix and `weight u u^T` for each of the vectors `u` given; its combinations contain them.
    ///
    /// # Panics
    /// If the lengths do not fit.
    #[must_use]
    pub fn plus_outer(&self, given: &[(f64, &[f64])]) -> Self {
        let columns = Mat::from_fn(self.size(), given.len(), |i, j| given[j].1[i]);
        let mut sum = self.over_tree(&self.extended_tree(columns.as_ref(), DEPENDENT));
        let seen = sum.onto_core(columns.as_ref());
        let weighted = Mat::from_fn(seen.nrows(), seen.ncols(), |i, j| given[j].0 * seen[(i, j)]);
        sum.core += symmetric(product(weighted.as_ref(), seen.transpose()).as_ref());
        sum
    }

    /// The groups alone, without what lies behind them.
    #[must_use]
    pub fn groups_alone(&self) -> Self {
        let rank = self.rank();
        let core = self.core.submatrix(0, 0, rank, rank).to_owned();
        Self::new(self.tree.clone(), self.local.clone(), Vec::new(), core)
    }

    /// A factor times the matrix.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            tree: self.tree.clone(),
            local: self.local.iter().map(|a| Arc::new(a.scaled(factor))).collect(),
            rest: self.rest.iter().map(|d| factor * d).collect(),
            core: &self.core * faer::Scale(factor),
        }
    }

    /// `T^T x`.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn onto_core(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let (n, rank) = (self.tree.n_coordinates(), self.rank());
        let mut seen = Mat::zeros(self.core.nrows(), x.ncols());
        for (seen, x) in seen.col_iter_mut().zip(x.col_iter()) {
            let x: Vec<f64> = x.iter().copied().collect();
            let all = self.tree.up(&x[..n]);
            let found = all[all.len() - rank..].iter().chain(&x[n..]);
            seen.iter_mut().zip(found).for_each(|(seen, found)| *seen = *found);
        }
        seen
    }

    /// `T x` over the groups alone: rows over the combinations as rows over the coordinates of the groups.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn from_core(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(self.tree.n_coordinates(), x.ncols());
        for (out, x) in out.col_iter_mut().zip(x.col_iter()) {
            let mut all = vec![0.0; self.tree.starts()[self.local.len()]];
            all.extend(x.iter());
            self.tree.down(&mut all);
            out.iter_mut().zip(all).for_each(|(out, found)| *out = found);
        }
        out
    }

    /// `y = A x`.
    ///
    /// # Panics
    /// If the lengths do not fit.
    pub fn product_into(&self, x: &[f64], y: &mut [f64]) {
        assert_eq!((x.len(), y.len()), (self.size(), self.size()));
        let (n, starts) = (self.tree.n_coordinates(), self.tree.starts());
        let mut given = self.tree.up(&x[..n]);
        let first = starts[self.local.len()];
        given.extend(&x[n..]);
        let mut found = vec![0.0; given.len()];
        for (block, start) in self.local.iter().zip(starts) {
            let own = *start..start + block.size();
            block.product_into(&given[own.clone()], &mut found[own]);
        }
        crate::tree::add_product(&mut found[first..], self.core(), &given[first..]);
        self.tree.down(&mut found[..first + self.rank()]);
        y[..n].copy_from_slice(&found[..n]);
        for (k, d) in self.rest.iter().enumerate() {
            y[n + k] = d * x[n + k] + found[first + self.rank() + k];
        }
    }

    /// `y = A x` for all columns.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let columns: Vec<Vec<f64>> = (0..x.ncols())
            .into_par_iter()
            .map(|j| {
                let x: Vec<f64> = x.col(j).iter().copied().collect();
                let mut y = vec![0.0; self.size()];
                self.product_into(&x, &mut y);
                y
            })
            .collect();
        Mat::from_fn(self.size(), columns.len(), |i, j| columns[j][i])
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        let (rank, nodes) = (self.rank(), self.tree.nodes());
        // What lies above each node, seen through its combinations.
        let mut above = vec![Mat::new(); nodes.len()];
        let share = |total: MatRef<'_, f64>, children: &[usize], above: &mut [Mat<f64>]| {
            let mut first = 0;
            for &child in children {
                let own = nodes[child].basis.ncols();
                above[child] = total.submatrix(first, first, own, own).to_owned();
                first += own;
            }
        };
        share(self.core.submatrix(0, 0, rank, rank), self.tree.tops(), &mut above);
        for (number, node) in nodes.iter().enumerate().skip(self.tree.n_groups()).rev() {
            let half = product(node.basis.as_ref(), above[number].as_ref());
            let total = self.local[number].to_dense() + product(half.as_ref(), node.basis.transpose());
            share(total.as_ref(), &node.children, &mut above);
        }
        let mut out = Vec::with_capacity(self.size());
        for ((node, block), above) in nodes.iter().zip(&self.local).zip(&above).take(self.tree.n_groups()) {
            let seen = product(node.basis.as_ref(), above.as_ref());
            let of_row = |i: usize| {
                (0..seen.ncols())
                    .map(|j| seen[(i, j)] * node.basis[(i, j)])
                    .sum::<f64>()
            };
            out.extend(block.diagonal().enumerate().map(|(i, value)| value + of_row(i)));
        }
        out.extend((0..self.rest.len()).map(|k| self.rest[k] + self.core[(rank + k, rank + k)]));
        out
    }

    /// All entries.
    pub fn to_dense(&self) -> Mat<f64> {
        symmetric(
            self.product(Mat::<f64>::identity(self.size(), self.size()).as_ref())
                .as_ref(),
        )
    }

    /// Memory of the entries, which a product reads.
    pub fn bytes(&self) -> usize {
        let dense = self.tree.nodes().iter().map(|node| &node.basis).chain([&self.core]);
        let entries: usize = dense.map(|matrix| matrix.nrows() * matrix.ncols()).sum();
        let local: usize = self.local.iter().map(|block| block.bytes()).sum();
        local + (self.rest.len() + entries) * size_of::<f64>()
    }

    /// The inverse of the matrix plus a symmetric one with these entries, `(row, column, value)`, none of which couples two groups or lies behind them.
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`] for the groups of a node, beside which all else is held; [`Error::NoConvergence`] where the coupling is singular.
    ///
    /// # Panics
    /// If an entry couples two groups or lies behind them.
    pub fn inverse_plus(&self, entries: impl Iterator<Item = (usize, usize, f64)>) -> Result<Self, Error> {
        let (nodes, starts, n_groups) = (self.tree.nodes(), self.tree.starts(), self.tree.n_groups());
        let mut added = vec![Vec::new(); n_groups];
        for (row, column, value) in entries {
            let group = starts.partition_point(|&start| start <= row) - 1;
            let own = starts[group]..starts[group + 1];
            assert!(
                group < n_groups && own.contains(&column),
                "entries must not couple groups"
            );
            added[group].push((row - own.start, column - own.start, value));
        }
        let of_group = |(group, added): (usize, Vec<(usize, usize, f64)>)| {
            let basis = &nodes[group].basis;
            let mut block = self.local[group].to_dense();
            added.into_iter().for_each(|(i, j, value)| block[(i, j)] += value);
            let lower = cholesky_in_place(block).map_err(|error| match error {
                Error::NotPositiveDefinite { pivot, .. } => Error::NotPositiveDefinite {
                    pivot: starts[group] + pivot,
                    size: self.size(),
                },
                other => other,
            })?;
            let mut response = basis.clone();
            solve_lower(lower.as_ref(), response.as_mut());
            solve_lower_transposed(lower.as_ref(), response.as_mut());
            Ok(Inverted {
                local: Symmetric::inverse_of_factor(lower.as_ref()),
                compliance: symmetric(product(basis.transpose(), response.as_ref()).as_ref()),
                response,
            })
        };
        let found: Vec<Result<Inverted, Error>> = added.into_par_iter().enumerate().map(of_group).collect();
        let mut found = found.into_iter().collect::<Result<Vec<_>, _>>()?;
        for number in n_groups..nodes.len() {
            let node = self.inverted(number, &found)?;
            found.push(node);
        }
        // What the combinations of the core see one another by, without it.
        let (rank, size) = (self.rank(), self.core.nrows());
        let mut compliance = compliances(&found, self.tree.tops(), size);
        let rest: Vec<f64> = self.rest.iter().map(|d| 1.0 / d).collect();
        (rest.iter().enumerate()).for_each(|(k, value)| compliance[(rank + k, rank + k)] = *value);
        // (1 + C G)^-1 C.
        let mut system = product(self.core(), compliance.as_ref());
        (0..size).for_each(|i| system[(i, i)] += 1.0);
        let right: Vec<&[f64]> = (0..size).map(|j| self.core.col_as_slice(j)).collect();
        let columns = solve_general_all(system, &right).ok_or(Error::NoConvergence { size })?;
        let follows = |i: usize| i.checked_sub(rank).map_or(1.0, |k| rest[k]);
        let core = Mat::from_fn(size, size, |i, j| {
            -0.5 * follows(i) * follows(j) * (columns[j][i] + columns[i][j])
        });
        let (mut inverse, mut local) = (Vec::with_capacity(nodes.len()), Vec::with_capacity(nodes.len()));
        for (node, inverted) in nodes.iter().zip(found) {
            inverse.push(Node {
                children: node.children.clone(),
                basis: inverted.response,
            });
            local.push(Arc::new(inverted.local));
        }
        Ok(Self::new(Arc::new(Tree::new(inverse)), local, rest, core))
    }

    /// A node of the inverse that unites others, which are known.
    ///
    /// With what its coordinates see one another by, `G = L L^T`, and `S = 1 + L^T A_s L`, it takes `L^-T (1 - S^-1) L^-1` away, its coordinates follow
    /// its combinations by `L^-T S^-1 L^T B_s`, and these see `B_s^T L S^-1 L^T B_s`.
    fn inverted(&self, number: usize, known: &[Inverted]) -> Result<Inverted, Error> {
        let node = &self.tree.nodes()[number];
        let size = node.basis.nrows();
        let lower = cholesky_in_place(compliances(known, &node.children, size))?;
        let half = product(self.local[number].to_dense().as_ref(), lower.as_ref());
        let coupling = symmetric(product(lower.transpose(), half.as_ref()).as_ref());
        let mut system = coupling.clone();
        (0..size).for_each(|i| system[(i, i)] += 1.0);
        let system = cholesky_in_place(system)?;
        let solved = |mut x: Mat<f64>| {
            solve_lower(system.as_ref(), x.as_mut());
            solve_lower_transposed(system.as_ref(), x.as_mut());
            x
        };
        // 1 - S^-1 = S^-1 (S - 1), without cancellation.
        let mut taken = solved(coupling);
        solve_lower_transposed(lower.as_ref(), taken.as_mut());
        let mut taken = taken.transpose().to_owned();
        solve_lower_transposed(lower.as_ref(), taken.as_mut());
        let seen = product(lower.transpose(), node.basis.as_ref());
        let mut response = solved(seen.clone());
        let compliance = symmetric(product(seen.transpose(), response.as_ref()).as_ref());
        solve_lower_transposed(lower.as_ref(), response.as_mut());
        let local = symmetric((taken * faer::Scale(-1.0)).as_ref());
        Ok(Inverted {
            local: Symmetric::from_lower(local.as_ref()),
            response,
            compliance,
        })
    }
}

/// What the combinations of these nodes see, node after node, the first ones of a matrix of this size.
fn compliances(of: &[Inverted], nodes: &[usize], size: usize) -> Mat<f64> {
    let mut all = Mat::zeros(size, size);
    let mut first = 0;
    for &node in nodes {
        let own = &of[node].compliance;
        all.submatrix_mut(first, first, own.nrows(), own.nrows()).copy_from(own);
        first += own.nrows();
    }
    all
}
