//! Block matrices against the dense ones that they stand for.

use dense_algebra::{
    BlockMatrix, Node, Symmetric, SystemMatrix, SystemMatrixRef, Tree, leading_basis, product, scattered,
    symmetric_pair,
};
use faer::Mat;
use std::sync::Arc;

/// Largest difference relative to the largest entry.
fn difference(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (a - b).norm_max() / b.norm_max()
}

fn columns(size: usize, count: usize, from: usize) -> Mat<f64> {
    let all = scattered(size, count + from);
    all.subcols(from, count).to_owned()
}

/// Two matrices over groups of 7, 12 and 5 coordinates and 3 behind them, with the same tree: a stiffness and a mass in the scale of a structure.
///
/// Three combinations of each group are seen; of two of them, or of one, two nodes one above the other show four and five.
fn pair(is_nested: bool) -> [BlockMatrix; 2] {
    let node = |children: &[usize], n: usize, rank: usize| Node {
        children: children.to_vec(),
        basis: leading_basis(columns(n, rank, n), 1e-10),
    };
    let mut nodes = vec![node(&[], 7, 3), node(&[], 12, 3), node(&[], 5, 3)];
    if is_nested {
        nodes.extend([node(&[2, 0], 6, 4), node(&[1, 3], 7, 5)]);
    }
    let sizes: Vec<usize> = nodes.iter().map(|node| node.basis.nrows()).collect();
    let tree = Arc::new(Tree::new(nodes));
    let positive = |n: usize, from: usize| {
        let a = columns(n, n, from);
        product(a.as_ref(), a.transpose()) + Mat::<f64>::identity(n, n)
    };
    [(1e9, -0.02), (1e-3, 0.02)].map(|(scale, sign)| {
        // A coupling that leaves the whole positive.
        let of = |(at, &n): (usize, &usize)| {
            let factor = if at < 3 { scale } else { sign * scale };
            Arc::new(Symmetric::from_lower((positive(n, 3) * faer::Scale(factor)).as_ref()))
        };
        let local = sizes.iter().enumerate().map(of).collect();
        let rest = vec![2.0 * scale, 3.0 * scale, 5.0 * scale];
        let core = positive(tree.rank() + 3, 20) * faer::Scale(sign * scale);
        BlockMatrix::new(tree.clone(), local, rest, core)
    })
}

/// With groups alone, and with nodes above them.
fn pairs() -> [[BlockMatrix; 2]; 2] {
    [false, true].map(pair)
}

#[test]
fn products_diagonals_and_inverses_are_those_of_the_dense_matrix() {
    for blocks in pairs().into_iter().flatten() {
        let dense = blocks.to_dense();
        let n = blocks.size();
        assert_eq!(dense.shape(), (n, n));
        assert!(difference(&dense, &dense.transpose().to_owned()) < 1e-15);
        let x = columns(n, 4, 9);
        assert!(difference(&blocks.product(x.as_ref()), &product(dense.as_ref(), x.as_ref())) < 1e-14);
        for (found, i) in blocks.diagonal().into_iter().zip(0..) {
            assert!((found / dense[(i, i)] - 1.0).abs() < 1e-13);
        }
        // With a matrix on the blocks, also off their diagonals.
        let size = dense[(0, 0)];
        let entries = [(0, 0, size), (8, 8, 3.0 * size), (8, 9, 0.2 * size), (9, 8, 0.2 * size)];
        let mut sum = dense.clone();
        entries.iter().for_each(|&(i, j, value)| sum[(i, j)] += value);
        let inverse = blocks.inverse_plus(entries.into_iter()).unwrap();
        let identity = Mat::<f64>::identity(n, n);
        let mut found = Mat::<f64>::zeros(n, n);
        for j in 0..n {
            inverse.product_into(identity.col_as_slice(j), found.col_as_slice_mut(j));
        }
        assert!(difference(&product(sum.as_ref(), found.as_ref()), &identity) < 1e-12);
        for (value, i) in inverse.diagonal().into_iter().zip(0..) {
            assert!((value / found[(i, i)] - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn sums_scales_and_other_combinations_are_those_of_the_dense_matrix() {
    pairs().iter().for_each(sums_scales_and_other_combinations);
}

fn sums_scales_and_other_combinations([stiffness, mass]: &[BlockMatrix; 2]) {
    let (k, m) = (stiffness.to_dense(), mass.to_dense());
    assert!(difference(&stiffness.plus(1e11, mass).to_dense(), &(&k + &m * faer::Scale(1e11))) < 1e-14);
    assert!(difference(&stiffness.scaled(0.3).to_dense(), &(&k * faer::Scale(0.3))) < 1e-15);
    let n = stiffness.size();
    let u = columns(n, 2, 30);
    let given = [(2e8, u.col_as_slice(0)), (-1e7, u.col_as_slice(1))];
    let added = SystemMatrix::Blocks(stiffness.clone()).plus_outer(&given);
    let dense = SystemMatrix::Dense(k.clone()).plus_outer(&given);
    assert!(difference(&added.as_ref().to_dense(), &dense.into_dense()) < 1e-13);
    let wider = stiffness.over_tree(&stiffness.extended_tree(u.as_ref(), 1e-12));
    assert!(wider.rank() > stiffness.rank());
    assert!(difference(&wider.to_dense(), &k) < 1e-15);
    // What acts on the coordinates in the space of the combinations is seen by the core.
    let seen = wider.onto_core(u.as_ref());
    let back = wider.from_core(seen.subrows(0, wider.rank()));
    assert!(difference(&back, &u.subrows(0, back.nrows()).to_owned()) < 1e-13);
    assert!(difference(&wider.with_seen(wider.seen()).to_dense(), &k) < 1e-15);
    let alone = stiffness.groups_alone().to_dense();
    assert!(difference(&alone, &k.submatrix(0, 0, 24, 24).to_owned()) < 1e-15);
}

#[test]
fn pairs_are_those_of_the_dense_matrices_also_where_they_are_equal() {
    let check = |stiffness: &BlockMatrix, mass: &BlockMatrix, count: usize| {
        let (k, m) = (stiffness.to_dense(), mass.to_dense());
        let (expected, _) = symmetric_pair(k.as_ref(), m.as_ref()).unwrap();
        let factor = SystemMatrix::Blocks(stiffness.clone())
            .factor_plus(std::iter::empty())
            .unwrap();
        let (found, shapes) = factor.lowest_pairs(SystemMatrixRef::Blocks(mass), count).unwrap();
        for (a, b) in found.iter().zip(&expected) {
            assert!((a / b - 1.0).abs() < 1e-10, "{found:?} {expected:?}");
        }
        let own = product(shapes.transpose(), product(m.as_ref(), shapes.as_ref()).as_ref());
        assert!(difference(&own, &Mat::<f64>::identity(count, count)) < 1e-10);
        let left = product(k.as_ref(), shapes.as_ref());
        let right = product(m.as_ref(), shapes.as_ref());
        for j in 0..count {
            let residual = left.col(j) - right.col(j) * faer::Scale(found[j]);
            assert!(residual.norm_l2() < 1e-6 * left.col(j).norm_l2());
        }
    };
    for [stiffness, mass] in &pairs() {
        for count in [1, 6, 20] {
            check(stiffness, mass, count);
        }
    }
    // Equal groups that nothing couples: each pair occurs five times.
    let node = Node {
        children: Vec::new(),
        basis: Mat::zeros(6, 0),
    };
    let tree = Arc::new(Tree::try_new(vec![node; 5]).unwrap());
    let a = columns(6, 6, 2);
    let local = product(a.as_ref(), a.transpose()) + Mat::<f64>::identity(6, 6);
    let of = |block: Mat<f64>| {
        let block = Arc::new(Symmetric::from_lower(block.as_ref()));
        BlockMatrix::new(tree.clone(), vec![block; 5], Vec::new(), Mat::new())
    };
    check(&of(local), &of(Mat::identity(6, 6)), 12);
}

#[test]
fn what_is_no_tree_is_none() {
    let node = |children: &[usize], rows: usize, columns: usize| Node {
        children: children.to_vec(),
        basis: Mat::zeros(rows, columns),
    };
    let with = |above: &[Node]| Tree::try_new([&[node(&[], 4, 2), node(&[], 3, 1)], above].concat());
    let tree = with(&[node(&[1, 0], 3, 2)]).unwrap();
    assert_eq!((tree.n_groups(), tree.n_coordinates(), tree.rank()), (2, 7, 2));
    assert_eq!(with(&[node(&[0], 2, 1)]).unwrap().rank(), 2);
    for wrong in [
        vec![node(&[1, 0], 4, 2)],
        vec![node(&[1, 1], 2, 2)],
        vec![node(&[0], 2, 1), node(&[0], 2, 1)],
        vec![node(&[2], 1, 1)],
        vec![node(&[9], 1, 1)],
        vec![node(&[0], 2, 1), node(&[], 5, 1)],
    ] {
        assert_eq!(with(&wrong), None, "{wrong:?}");
    }
}

#[test]
fn a_basis_has_what_is_above_its_threshold() {
    // Two directions of size one, one of 1e-5, one of 1e-9.
    let directions = leading_basis(columns(30, 4, 0), 0.0);
    let sizes = [1.0, 1.0, 1e-5, 1e-9];
    let mixed = Mat::from_fn(30, 4, |i, j| sizes[j] * directions[(i, j)]);
    let mixed = product(mixed.as_ref(), columns(4, 9, 1).as_ref());
    for (least, expected) in [(1e-2, 2), (1e-7, 3), (1e-11, 4)] {
        let basis = leading_basis(mixed.clone(), least);
        assert_eq!(basis.ncols(), expected);
        let own = product(basis.transpose(), basis.as_ref());
        assert!(difference(&own, &Mat::<f64>::identity(expected, expected)) < 1e-13);
    }
    assert_eq!(leading_basis(Mat::zeros(5, 3), 1e-3).ncols(), 0);
    assert_eq!(leading_basis(Mat::from_fn(5, 3, |_, _| f64::NAN), 1e-3).ncols(), 0);
}
