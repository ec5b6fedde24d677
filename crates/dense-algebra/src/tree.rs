//! Groups of coordinates and the combinations of them that others see, in a tree.

use crate::bases::extended_basis;
use crate::{product, tiles};
use faer::{Accum, Mat, MatMut, MatRef};

/// A group of coordinates, or what is seen of several nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The nodes whose combinations are its coordinates, one after the other; none for a group.
    pub children: Vec<usize>,
    /// A column per combination of its coordinates that is seen outside of it.
    pub basis: Mat<f64>,
}

/// Groups that follow one another, and above them nodes that unite the combinations of others.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    nodes: Vec<Node>,
    n_groups: usize,
    /// First coordinate of each node in a list of those of all, groups first, and the number of all.
    starts: Vec<usize>,
    /// Where the combinations of each node begin in that list, or behind it if no node unites them with others.
    places: Vec<usize>,
    /// Nodes that none unites with others.
    tops: Vec<usize>,
    /// Combinations of these.
    rank: usize,
}

impl Tree {
    /// The tree of these nodes: groups first, children before the node that unites them. None if they are no tree, or if a node has other coordinates
    /// than the combinations of its children.
    pub fn try_new(nodes: Vec<Node>) -> Option<Self> {
        are_tree(&nodes).then(|| Self::new(nodes))
    }

    /// The same for nodes that are known to be a tree.
    ///
    /// # Panics
    /// If they are none.
    pub fn new(nodes: Vec<Node>) -> Self {
        assert!(are_tree(&nodes), "nodes unite combinations of nodes before them");
        let mut starts = vec![0];
        nodes
            .iter()
            .for_each(|node| starts.push(starts[starts.len() - 1] + node.basis.nrows()));
        let end = starts[nodes.len()];
        let mut is_united = vec![false; nodes.len()];
        nodes
            .iter()
            .flat_map(|node| &node.children)
            .for_each(|&child| is_united[child] = true);
        let tops: Vec<usize> = (0..nodes.len()).filter(|&node| !is_united[node]).collect();
        let mut places = vec![0; nodes.len()];
        let mut put = |children: &[usize], mut place: usize| {
            for &child in children {
                places[child] = place;
                place += nodes[child].basis.ncols();
            }
            place
        };
        for (node, &start) in nodes.iter().zip(&starts) {
            put(&node.children, start);
        }
        let rank = put(&tops, end) - end;
        Self {
            n_groups: nodes.iter().take_while(|node| node.children.is_empty()).count(),
            nodes,
            starts,
            places,
            tops,
            rank,
        }
    }

    /// All nodes, groups first.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Number of groups.
    pub fn n_groups(&self) -> usize {
        self.n_groups
    }

    /// Coordinates of all groups.
    pub fn n_coordinates(&self) -> usize {
        self.starts[self.n_groups]
    }

    /// Combinations that are seen of all groups.
    pub fn combinations(&self) -> usize {
        self.nodes[..self.n_groups]
            .iter()
            .map(|group| group.basis.ncols())
            .sum()
    }

    /// Combinations that no node unites with others.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// First coordinate of each node in a list of those of all.
    pub(crate) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Nodes that none unites with others.
    pub(crate) fn tops(&self) -> &[usize] {
        &self.tops
    }

    /// Coordinates of all nodes for those of the groups, and behind them the combinations that no node unites with others.
    pub(crate) fn up(&self, x: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.starts[self.nodes.len()] + self.rank];
        all[..x.len()].copy_from_slice(x);
        for (number, node) in self.nodes.iter().enumerate() {
            let (before, after) = all.split_at_mut(self.places[number]);
            let own = &before[self.starts[number]..self.starts[number + 1]];
            let seen = &mut after[..node.basis.ncols()];
            add_product(seen, node.basis.transpose(), own);
        }
        all
    }

    /// The transpose of [`Self::up`], added to the coordinates of the groups, which come first.
    pub(crate) fn down(&self, all: &mut [f64]) {
        for (number, node) in self.nodes.iter().enumerate().rev() {
            let (before, after) = all.split_at_mut(self.places[number]);
            let own = &mut before[self.starts[number]..self.starts[number + 1]];
            add_product(own, node.basis.as_ref(), &after[..node.basis.ncols()]);
        }
    }

    /// The tree with more combinations of each node, so that their space contains that of `columns` over the coordinates of all groups, but for what is below
    /// `least` of each column.
    pub(crate) fn extended(&self, columns: MatRef<'_, f64>, least: &[f64]) -> Self {
        let mut nodes: Vec<Node> = Vec::with_capacity(self.nodes.len());
        let mut seen: Vec<Mat<f64>> = Vec::with_capacity(self.nodes.len());
        for (number, node) in self.nodes.iter().enumerate() {
            let (own, basis) = match node.children.as_slice() {
                [] => {
                    let own = columns.subrows(self.starts[number], node.basis.nrows());
                    (own.to_owned(), node.basis.clone())
                }
                children => {
                    let rows: Vec<_> = children.iter().flat_map(|&child| seen[child].row_iter()).collect();
                    let own = Mat::from_fn(rows.len(), columns.ncols(), |i, j| rows[i][j]);
                    let mut basis = Mat::zeros(rows.len(), node.basis.ncols());
                    let width = |child: usize| nodes[child].basis.ncols();
                    for (row, &place) in node.basis.row_iter().zip(&self.places_of(children, width)) {
                        basis.row_mut(place).copy_from(row);
                    }
                    (own, basis)
                }
            };
            let basis = extended_basis(&basis, own.as_ref(), least);
            seen.push(product(basis.transpose(), own.as_ref()));
            nodes.push(Node {
                children: node.children.clone(),
                basis,
            });
        }
        Self::new(nodes)
    }

    /// Where the combinations of these nodes stand, one node after the other, if each has the `width` given, which begin with those that it has here.
    pub(crate) fn places_of(&self, nodes: &[usize], width: impl Fn(usize) -> usize) -> Vec<usize> {
        let (mut places, mut first) = (Vec::new(), 0);
        for &node in nodes {
            places.extend(first..first + self.nodes[node].basis.ncols());
            first += width(node);
        }
        places
    }
}

fn are_tree(nodes: &[Node]) -> bool {
    let n_groups = nodes.iter().take_while(|node| node.children.is_empty()).count();
    let mut is_united = vec![false; nodes.len()];
    nodes.iter().enumerate().skip(n_groups).all(|(number, node)| {
        let is_new = |&child: &usize| child < number && !std::mem::replace(&mut is_united[child], true);
        let are_new = !node.children.is_empty() && node.children.iter().all(is_new);
        let combinations = |&child: &usize| nodes[child].basis.ncols();
        are_new && node.children.iter().map(combinations).sum::<usize>() == node.basis.nrows()
    })
}

/// `y += a x`.
pub(crate) fn add_product(y: &mut [f64], a: MatRef<'_, f64>, x: &[f64]) {
    let n = y.len();
    let y = MatMut::from_column_major_slice_mut(y, n, 1);
    let x = MatRef::from_column_major_slice(x, x.len(), 1);
    tiles::product(y, Accum::Add, a, x, 1.0);
}
