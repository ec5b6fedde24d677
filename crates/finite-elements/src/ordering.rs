//! Fill-reducing ordering by geometric nested dissection.
//!
//! A set of nodes is cut by a plane across one of the three axes; the nodes on one side that touch the other become the
//! separator and are eliminated after both halves. Of all planes and both sides the one is taken whose separator is
//! smallest, weighed against the balance of the halves: so a cut avoids the long rows of couplings, and runs along ties
//! and gaps. For bolted assemblies of slender parts this has less fill than minimum degree, and wide dense blocks.
//! Where no plane parts a set, distance in the graph takes the place of the coordinate.
//!
//! Halves of halves of a long part lie between two separators, and each cut across them leaves rows on both. Where it costs
//! less, a separator therefore changes places with one below it: then a long part is eliminated from its ends on, and
//! cuts leave rows on one side. The separator that goes down may be cut in two by the one that goes up: what of it does not
//! hang together becomes parts of its own, as rows of a part are treated alike, whatever each of them touches.

use crate::sets::DisjointSets;
use crate::sparse::entries;
use sprs::CsMat;
use std::ops::Range;

/// Sets of at most this many rows are not cut further.
const LEAF: usize = 96;

/// Rows of a node, at most.
const COMPONENTS: usize = 3;

/// Power of the product of two halves that a separator is weighed against. Of powers from 0.4 to 1.5 those about this one lead to the fewest operations on
/// the halves of five Brake-Reuss beams: from 5 % fewer to 3 % more than 1.
const BALANCE: f64 = 0.7;

/// Separators change places no deeper in the tree than this: a tree as deep as a chain is long would overflow the stack.
const DEEPEST: usize = 64;

/// What separators that change places must save, relative to what they cost.
const WORTH: f64 = 0.02;

/// An elimination order and its tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dissection {
    /// Position `k` holds the row that is eliminated as the `k`-th.
    pub order: Vec<usize>,
    /// Separators and uncut sets in the order of their elimination; children come before their parent.
    pub parts: Vec<Part>,
}

/// Rows eliminated together: their columns of the factor are treated as equally long.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Positions in the order.
    pub rows: Range<usize>,
    /// Numbers of the parts that must be eliminated before; no others reach this part.
    pub children: Vec<usize>,
}

/// A stiffness, and perhaps a mass, in the order of their elimination, kept rows last.
pub(crate) struct Ordered<'a> {
    pub(crate) matrices: Vec<&'a CsMat<f64>>,
    /// The row at each position, and the position of each row.
    pub(crate) order: Vec<usize>,
    position: Vec<usize>,
    /// Whether the stiffness couples a row to no others.
    is_held: Vec<bool>,
}

impl<'a> Ordered<'a> {
    pub(crate) fn new(matrices: &[&'a CsMat<f64>], order: Vec<usize>, held: &[usize]) -> Self {
        let n = order.len();
        let mut position = vec![0; n];
        for (at, &row) in order.iter().enumerate() {
            position[row] = at;
        }
        let mut is_held = vec![false; n];
        held.iter().for_each(|&row| is_held[row] = true);
        Self {
            matrices: matrices.to_vec(),
            order,
            position,
            is_held,
        }
    }

    /// The entries of a row of one of the matrices at its own and later positions.
    pub(crate) fn row(&self, which: usize, at: usize) -> impl Iterator<Item = (usize, f64)> {
        let row = self.order[at];
        let is_alone = move |row: usize| which == 0 && self.is_held[row];
        entries(self.matrices[which], row).filter_map(move |(column, value)| {
            let is_coupling = row != column && (is_alone(row) || is_alone(column));
            let value = if is_coupling { 0.0 } else { value };
            (self.position[column] >= at).then_some((self.position[column], value))
        })
    }

    /// Its own and later positions that a row touches in any of the matrices.
    pub(crate) fn touched(&self, at: usize) -> impl Iterator<Item = usize> {
        (0..self.matrices.len()).flat_map(move |which| self.row(which, at).map(|(position, _)| position))
    }
}

/// Dissects all rows but the first `n_kept`.
///
/// `pattern` is the symmetric matrix, `positions` one point per row (any length unit). Up to three successive rows
/// with the same position, the components of a node, stay together.
///
/// # Panics
/// If the number of positions is not the number of rows, or smaller than `n_kept`.
pub fn nested_dissection(pattern: &CsMat<f64>, positions: &[[f64; 3]], n_kept: usize) -> Dissection {
    assert_eq!(pattern.rows(), positions.len());
    let graph = Graph::new(pattern, positions, n_kept);
    let mut work = Work {
        member: vec![0; graph.rows.len()],
        stamp: 0,
        at: vec![0.0; graph.rows.len()],
    };
    let mut parts = Vec::new();
    if graph.first < graph.rows.len() {
        dissect(&graph, (graph.first..graph.rows.len()).collect(), &mut work, &mut parts);
    }
    Tree::new(&graph, parts).in_order()
}

/// The nodes that the rows belong to, and which touch.
struct Graph {
    rows: Vec<Range<usize>>,
    /// Nodes before this one are kept.
    first: usize,
    positions: Vec<[f64; 3]>,
    start: Vec<usize>,
    neighbours: Vec<usize>,
}

/// What is known of the nodes of the set at hand.
struct Work {
    /// The stamp of the set.
    member: Vec<u32>,
    stamp: u32,
    /// The coordinate that is to be cut.
    at: Vec<f64>,
}

impl Graph {
    fn new(pattern: &CsMat<f64>, positions: &[[f64; 3]], n_kept: usize) -> Self {
        let mut rows: Vec<Range<usize>> = Vec::new();
        let mut node = vec![usize::MAX; positions.len()];
        let mut first = 0;
        for row in 0..positions.len() {
            let joins = |last: &Range<usize>| last.len() < COMPONENTS && positions[last.start] == positions[row];
            match rows.last_mut() {
                Some(last) if row != n_kept && joins(last) => last.end = row + 1,
                _ => rows.push(row..row + 1),
            }
            node[row] = rows.len() - 1;
            first += usize::from(row < n_kept && rows[rows.len() - 1].len() == 1);
        }
        let (mut start, mut neighbours) = (vec![0], Vec::new());
        let mut seen = vec![usize::MAX; rows.len()];
        for (own, range) in rows.iter().enumerate() {
            seen[own] = own;
            for row in range.clone() {
                for &column in &pattern.indices()[pattern.indptr().outer_inds_sz(row)] {
                    if seen[node[column]] != own {
                        seen[node[column]] = own;
                        neighbours.push(node[column]);
                    }
                }
            }
            start.push(neighbours.len());
        }
        let positions = rows.iter().map(|range| positions[range.start]).collect();
        Self {
            rows,
            first,
            positions,
            start,
            neighbours,
        }
    }

    fn neighbours(&self, node: usize) -> &[usize] {
        &self.neighbours[self.start[node]..self.start[node + 1]]
    }

    fn size(&self, set: &[usize]) -> usize {
        set.iter().map(|&node| self.rows[node].len()).sum()
    }
}

/// A plane `at = plane`, and whether the nodes before or behind it give up those that touch the other side.
struct Cut {
    cost: f64,
    plane: f64,
    before: bool,
}

/// A separator, or a set that is not cut, and what is eliminated before it.
struct Branch {
    /// Ascending.
    nodes: Vec<usize>,
    children: Vec<usize>,
}

/// Appends the parts of a set; returns the number of the last of them.
fn dissect(graph: &Graph, set: Vec<usize>, work: &mut Work, out: &mut Vec<Branch>) -> usize {
    let branch = match halves(graph, &set, work) {
        None => Branch {
            nodes: set,
            children: Vec::new(),
        },
        Some((giving, whole)) => {
            work.mark(&whole);
            let touches = |node: &usize| graph.neighbours(*node).iter().any(|&other| work.contains(other));
            let (separator, rest): (Vec<usize>, Vec<usize>) = giving.into_iter().partition(touches);
            Branch {
                nodes: separator,
                children: [rest, whole].map(|half| dissect(graph, half, work, out)).to_vec(),
            }
        }
    };
    out.push(branch);
    out.len() - 1
}

/// The parts, and what each touches.
struct Tree<'a> {
    graph: &'a Graph,
    parts: Vec<Branch>,
    /// For each part, the nodes beyond its subtree that this touches, ascending.
    beyond: Vec<Vec<usize>>,
    /// The part of each node; none of those that are kept.
    part_of: Vec<Option<usize>>,
    /// The part that is eliminated last.
    root: Option<usize>,
}

/// Nodes that hang together where what lies below them is eliminated.
struct Piece {
    branch: Branch,
    /// Nodes beyond its subtree that this touches, ascending.
    beyond: Vec<usize>,
}

/// A part and one of its children with places changed.
struct Exchange {
    child: usize,
    /// What the part falls into where the child no longer lies below it.
    pieces: Vec<Piece>,
    /// What else becomes children of the child.
    others: Vec<usize>,
}

impl<'a> Tree<'a> {
    fn new(graph: &'a Graph, parts: Vec<Branch>) -> Self {
        let mut part_of = vec![None; graph.rows.len()];
        for (number, part) in parts.iter().enumerate() {
            part.nodes.iter().for_each(|&node| part_of[node] = Some(number));
        }
        let mut tree = Self {
            graph,
            parts: Vec::with_capacity(parts.len()),
            beyond: Vec::with_capacity(parts.len()),
            part_of: Vec::new(),
            root: None,
        };
        // What has taken the place of each part.
        let mut put: Vec<Vec<usize>> = Vec::with_capacity(parts.len());
        for (number, Branch { nodes, children }) in parts.into_iter().enumerate() {
            let children: Vec<usize> = children.iter().flat_map(|&child| &put[child]).copied().collect();
            // Parts that come later are ancestors, as no others are touched.
            let is_above = |node: usize| part_of[node].is_none_or(|part| part > number);
            let (pieces, mut roots) = tree.pieces(&nodes, &children, is_above);
            roots.extend(pieces.into_iter().map(|piece| tree.push(piece)));
            put.push(roots);
        }
        tree.root = match put.pop().as_deref() {
            None => None,
            Some(&[root]) => Some(root),
            // What does not hang together is eliminated before a part without nodes.
            Some(roots) => {
                let mut beyond: Vec<usize> = roots.iter().flat_map(|&root| &tree.beyond[root]).copied().collect();
                beyond.sort_unstable();
                beyond.dedup();
                let branch = Branch {
                    nodes: Vec::new(),
                    children: roots.to_vec(),
                };
                Some(tree.push(Piece { branch, beyond }))
            }
        };
        tree.part_of = part_of;
        for number in 0..tree.parts.len() {
            tree.claim(number);
        }
        let mut open: Vec<(usize, usize)> = tree.root.map(|root| (root, 0)).into_iter().collect();
        while let Some((part, depth)) = open.pop() {
            let exchange = if depth < DEEPEST { tree.exchange(part) } else { None };
            match exchange {
                Some(exchange) => {
                    // The child takes the number of the part, by which its parent knows it.
                    tree.apply(part, exchange);
                    open.push((part, depth));
                }
                None => open.extend(tree.parts[part].children.iter().map(|&child| (child, depth + 1))),
            }
        }
        tree
    }

    /// Adds a part; gives its number.
    fn push(&mut self, Piece { branch, beyond }: Piece) -> usize {
        self.parts.push(branch);
        self.beyond.push(beyond);
        self.parts.len() - 1
    }

    /// Notes the part of its nodes.
    fn claim(&mut self, number: usize) {
        for &node in &self.parts[number].nodes {
            self.part_of[node] = Some(number);
        }
    }

    /// What `nodes` (ascending) fall into after the given children, each piece with those of them that touch it; and the children that touch none.
    /// Neighbours of the nodes among those that are `above` are eliminated later.
    fn pieces(
        &self,
        nodes: &[usize],
        children: &[usize],
        is_above: impl Fn(usize) -> bool,
    ) -> (Vec<Piece>, Vec<usize>) {
        let place = |node: &usize| nodes.binary_search(node).ok().map(|place| place as u32);
        let mut sets = DisjointSets::new(nodes.len());
        for (own, &node) in nodes.iter().enumerate() {
            let others = self.graph.neighbours(node).iter().filter_map(place);
            others.for_each(|other| sets.join(own as u32, other));
        }
        let (mut touching, mut free) = (Vec::with_capacity(children.len()), Vec::new());
        for &child in children {
            let mut touched = self.beyond[child].iter().filter_map(place);
            match touched.next() {
                Some(first) => {
                    touched.for_each(|other| sets.join(first, other));
                    touching.push((child, first));
                }
                None => free.push(child),
            }
        }
        // Each set is known by its first member, which therefore comes before the others.
        let mut number = vec![0; nodes.len()];
        let mut pieces: Vec<Piece> = Vec::new();
        for (own, &node) in nodes.iter().enumerate() {
            let root = sets.root(own as u32) as usize;
            if root == own {
                number[own] = pieces.len();
                pieces.push(Piece {
                    branch: Branch {
                        nodes: Vec::new(),
                        children: Vec::new(),
                    },
                    beyond: Vec::new(),
                });
            }
            let piece = &mut pieces[number[root]];
            piece.branch.nodes.push(node);
            let beyond = self.graph.neighbours(node).iter().copied();
            piece
                .beyond
                .extend(beyond.filter(|node| is_above(*node) && place(node).is_none()));
        }
        for (child, first) in touching {
            let piece = &mut pieces[number[sets.root(first) as usize]];
            piece.branch.children.push(child);
            let beyond = self.beyond[child].iter().copied();
            piece.beyond.extend(beyond.filter(|node| place(node).is_none()));
        }
        for piece in &mut pieces {
            piece.beyond.sort_unstable();
            piece.beyond.dedup();
        }
        (pieces, free)
    }

    /// Multiplications and additions of nodes that are eliminated together, given what they touch.
    fn cost(&self, nodes: &[usize], beyond: &[usize]) -> f64 {
        let own = self.graph.size(nodes) as f64;
        let beyond = self.graph.size(beyond) as f64;
        own * (own * own / 3.0 + own * beyond + beyond * beyond)
    }

    /// The exchange of a part with one of its children that saves most, if any is worth it.
    fn exchange(&self, part: usize) -> Option<Exchange> {
        let outer = &self.beyond[part];
        let Branch { nodes, children } = &self.parts[part];
        let mut best = None;
        for &child in children {
            let own = &self.parts[child];
            let before = self.cost(nodes, outer) + self.cost(&own.nodes, &self.beyond[child]);
            let touches = |other: &usize| self.beyond[*other].iter().any(|&node| self.part_of[node] == Some(part));
            let (moved, mut others): (Vec<usize>, Vec<usize>) = own.children.iter().copied().partition(touches);
            let under_part: Vec<usize> = children
                .iter()
                .copied()
                .filter(|&other| other != child)
                .chain(moved)
                .collect();
            let is_above = |node: usize| self.part_of[node] == Some(child) || outer.binary_search(&node).is_ok();
            let (pieces, free) = self.pieces(nodes, &under_part, is_above);
            others.extend(free);
            // The child then touches what the part did, as both have the same below them.
            let after = pieces.iter().map(|piece| self.cost(&piece.branch.nodes, &piece.beyond));
            let saved = before - after.sum::<f64>() - self.cost(&own.nodes, outer);
            if saved > WORTH * before && best.as_ref().is_none_or(|(most, _)| saved > *most) {
                best = Some((saved, Exchange { child, pieces, others }));
            }
        }
        best.map(|(_, exchange)| exchange)
    }

    /// Exchanges a part with its child, which takes its number.
    fn apply(&mut self, part: usize, Exchange { child, pieces, others }: Exchange) {
        let nodes = std::mem::take(&mut self.parts[child].nodes);
        self.parts[part] = Branch {
            nodes,
            children: others,
        };
        self.claim(part);
        // The first piece takes the number of the child.
        let mut free = Some(child);
        for piece in pieces {
            let number = match free.take() {
                Some(number) => {
                    self.parts[number] = piece.branch;
                    self.beyond[number] = piece.beyond;
                    number
                }
                None => self.push(piece),
            };
            self.claim(number);
            self.parts[part].children.push(number);
        }
    }

    /// The parts one after another, children before their parent.
    fn in_order(&self) -> Dissection {
        let n_kept = self.graph.rows.get(self.graph.first).map_or(0, |first| first.start);
        let mut dissection = Dissection {
            order: Vec::with_capacity(self.graph.rows.last().map_or(0, |last| last.end) - n_kept),
            parts: Vec::with_capacity(self.parts.len()),
        };
        // Children stand behind their parent here.
        let mut reversed = Vec::with_capacity(self.parts.len());
        let mut open: Vec<usize> = self.root.into_iter().collect();
        while let Some(part) = open.pop() {
            reversed.push(part);
            open.extend(&self.parts[part].children);
        }
        let mut number = vec![0; self.parts.len()];
        for &part in reversed.iter().rev() {
            let Branch { nodes, children } = &self.parts[part];
            let first = dissection.order.len();
            let rows = nodes.iter().flat_map(|&node| self.graph.rows[node].clone());
            dissection.order.extend(rows);
            number[part] = dissection.parts.len();
            dissection.parts.push(Part {
                rows: first..dissection.order.len(),
                children: children.iter().map(|&child| number[child]).collect(),
            });
        }
        dissection
    }
}

/// The two sides of the best cut, first the one that gives up a separator; `None` for small sets and those where every
/// node touches every other.
fn halves(graph: &Graph, set: &[usize], work: &mut Work) -> Option<(Vec<usize>, Vec<usize>)> {
    if graph.size(set) <= LEAF {
        return None;
    }
    work.mark(set);
    let mut best: Option<(usize, Cut)> = None;
    for axis in 0..3 {
        work.use_axis(graph, set, axis);
        let cut = best_cut(graph, set, work);
        if let Some(cut) = cut.filter(|cut| best.as_ref().is_none_or(|(_, least)| cut.cost < least.cost)) {
            best = Some((axis, cut));
        }
    }
    let cut = match best {
        Some((axis, cut)) => {
            work.use_axis(graph, set, axis);
            cut
        }
        None => {
            work.use_distance(graph, set);
            best_cut(graph, set, work)?
        }
    };
    let gives = |node: &usize| work.at[*node].total_cmp(&cut.plane).is_lt() == cut.before;
    Some(set.iter().copied().partition(gives))
}

impl Work {
    fn mark(&mut self, set: &[usize]) {
        self.stamp += 1;
        for &node in set {
            self.member[node] = self.stamp;
        }
    }

    fn contains(&self, node: usize) -> bool {
        self.member[node] == self.stamp
    }

    fn use_axis(&mut self, graph: &Graph, set: &[usize], axis: usize) {
        for &node in set {
            self.at[node] = graph.positions[node][axis];
        }
    }

    /// Uses the number of edges from a node as far as possible from the first one, unconnected parts one after another.
    fn use_distance(&mut self, graph: &Graph, set: &[usize]) {
        let mut first = set[0];
        for _ in 0..2 {
            for &node in set {
                self.at[node] = -1.0;
            }
            let mut reached: Vec<usize> = Vec::with_capacity(set.len());
            for &start in std::iter::once(&first).chain(set) {
                if self.at[start] >= 0.0 {
                    continue;
                }
                self.at[start] = reached.last().map_or(0.0, |&last| self.at[last] + 1.0);
                let mut next = reached.len();
                reached.push(start);
                while let Some(&node) = reached.get(next) {
                    next += 1;
                    for &other in graph.neighbours(node) {
                        if self.contains(other) && self.at[other] < 0.0 {
                            self.at[other] = self.at[node] + 1.0;
                            reached.push(other);
                        }
                    }
                }
            }
            first = reached[reached.len() - 1];
        }
    }
}

/// The plane with the least `separator / (half * half)^BALANCE`; `None` if none leaves two halves.
fn best_cut(graph: &Graph, set: &[usize], work: &Work) -> Option<Cut> {
    let mut planes: Vec<f64> = set.iter().map(|&node| work.at[node]).collect();
    planes.sort_unstable_by(f64::total_cmp);
    planes.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let number = |x: f64| planes.partition_point(|plane| plane.total_cmp(&x).is_lt());
    // Plane `p` parts the nodes before it from those in and behind it. A node in plane `own` whose neighbours reach
    // from plane `low` to plane `high` touches the other side of the planes own < p <= high and low < p <= own.
    // Rows that come and go at each plane: before it, before it and touching, behind it and touching.
    let mut change = vec![[0_i64; 3]; planes.len() + 1];
    for &node in set {
        let own = work.at[node];
        let (mut low, mut high) = (own, own);
        for &other in graph.neighbours(node) {
            if work.contains(other) {
                low = low.min(work.at[other]);
                high = high.max(work.at[other]);
            }
        }
        let (low, own, high) = (number(low), number(own), number(high));
        let size = graph.rows[node].len() as i64;
        change[own + 1][0] += size;
        change[own + 1][1] += size;
        change[high + 1][1] -= size;
        change[low + 1][2] += size;
        change[own + 1][2] -= size;
    }
    let total = graph.size(set) as i64;
    let mut count = [0_i64; 3];
    let mut best: Option<Cut> = None;
    for (&plane, change) in planes.iter().zip(&change) {
        count
            .iter_mut()
            .zip(change)
            .for_each(|(count, change)| *count += change);
        let [n_before, touching_before, touching_behind] = count;
        for (giving, separator, before) in [
            (n_before, touching_before, true),
            (total - n_before, touching_behind, false),
        ] {
            let halves = (giving - separator) * (total - giving);
            // One row more than there are, so that balance counts where nothing touches.
            let cost = (separator + 1) as f64 / (halves as f64).powf(BALANCE);
            if giving > 0 && halves > 0 && best.as_ref().is_none_or(|least| cost < least.cost) {
                best = Some(Cut { cost, plane, before });
            }
        }
    }
    best
}
