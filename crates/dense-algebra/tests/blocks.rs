//! Block matrices against the dense ones that they stand for.

use dense_algebra::{BlockMatrix, SystemMatrix, SystemMatrixRef, leading_basis, product, scattered, symmetric_pair};
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

/// Two matrices over groups of 7, 12 and 5 coordinates and 3 behind them, with the same bases: a stiffness and a mass in the scale of a structure.
fn pair() -> [BlockMatrix; 2] {
    let sizes = [7, 12, 5];
    let bases: Vec<Mat<f64>> = sizes.iter().map(|&n| leading_basis(columns(n, 3, n), 1e-10)).collect();
    let bases = Arc::new(bases);
    let positive = |n: usize, from: usize| {
        let a = columns(n, n, from);
        product(a.as_ref(), a.transpose()) + Mat::<f64>::identity(n, n)
    };
    [(1e9, -0.02), (1e-3, 0.02)].map(|(scale, sign)| {
        let local = sizes.iter().map(|&n| positive(n, 3) * faer::Scale(scale)).collect();
        let rest = vec![2.0 * scale, 3.0 * scale, 5.0 * scale];
        // A coupling that leaves the whole positive.
        let core = positive(12, 20) * faer::Scale(sign * scale);
        BlockMatrix::new(bases.clone(), Arc::new(local), rest, core)
    })
}

#[test]
fn products_diagonals_and_inverses_are_those_of_the_dense_matrix() {
    for blocks in pair() {
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
fn sums_scales_and_other_bases_are_those_of_the_dense_matrix() {
    let [stiffness, mass] = pair();
    let (k, m) = (stiffness.to_dense(), mass.to_dense());
    assert!(difference(&stiffness.plus(1e11, &mass).to_dense(), &(&k + &m * faer::Scale(1e11))) < 1e-14);
    assert!(difference(&stiffness.scaled(0.3).to_dense(), &(&k * faer::Scale(0.3))) < 1e-15);
    let n = stiffness.size();
    let u = columns(n, 2, 30);
    let given = [(2e8, u.col_as_slice(0)), (-1e7, u.col_as_slice(1))];
    let added = SystemMatrix::Blocks(stiffness.clone()).plus_outer(&given);
    let dense = SystemMatrix::Dense(k.clone()).plus_outer(&given);
    assert!(difference(&added.as_ref().to_dense(), &dense.into_dense()) < 1e-13);
    let bases = stiffness.extended_bases(u.as_ref(), 1e-12);
    let wider = stiffness.over_bases(&bases);
    assert!(wider.rank() > stiffness.rank());
    assert!(difference(&wider.to_dense(), &k) < 1e-15);
    // What acts on the coordinates in the space of the bases is seen by the core.
    let seen = wider.onto_core(u.as_ref());
    let back = wider.from_core(seen.subrows(0, wider.rank()));
    assert!(difference(&back, &u.subrows(0, back.nrows()).to_owned()) < 1e-13);
    assert!(difference(&wider.with_seen(wider.seen()).to_dense(), &k) < 1e-15);
    let alone = stiffness.groups_alone().to_dense();
    assert!(difference(&alone, &k.submatrix(0, 0, 24, 24).to_owned()) < 1e-15);
}

#[test]
fn pairs_are_those_of_the_dense_matrices_also_where_they_are_equal() {
    let [stiffness, mass] = pair();
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
    for count in [1, 6, 20] {
        check(&stiffness, &mass, count);
    }
    // Equal groups that nothing couples: each pair occurs five times.
    let bases = Arc::new(vec![Mat::<f64>::zeros(6, 0); 5]);
    let a = columns(6, 6, 2);
    let local = product(a.as_ref(), a.transpose()) + Mat::<f64>::identity(6, 6);
    let of = |block: Mat<f64>| BlockMatrix::new(bases.clone(), Arc::new(vec![block; 5]), Vec::new(), Mat::new());
    check(&of(local), &of(Mat::identity(6, 6)), 12);
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
