//! Factors and eigenpairs against the equations that define them, at sizes on both sides of the block thresholds.

use dense_algebra::{
    Error, ReflectedInverse, Reflection, Symmetric, add_product, add_product_lower, add_product_with_lower, cholesky,
    cholesky_in_place, congruent, lowest_pairs, mirror_lower, product, rank, semidefinite_factor, solve_general,
    solve_lower, solve_lower_transposed, symmetric_eigen, symmetric_eigenvalues, symmetric_pair,
};
use faer::Mat;

/// Orthonormal columns from reflections, so that spectra can be chosen.
fn orthonormal(n: usize) -> Mat<f64> {
    let mut q = Mat::<f64>::identity(n, n);
    for k in 0..4 {
        let v: Vec<f64> = (0..n).map(|i| ((i * (7 + k) + 3 * k) as f64 * 0.37).sin()).collect();
        let square: f64 = v.iter().map(|x| x * x).sum();
        let vq: Vec<f64> = (0..n).map(|j| (0..n).map(|i| v[i] * q[(i, j)]).sum()).collect();
        for j in 0..n {
            for i in 0..n {
                q[(i, j)] -= 2.0 / square * v[i] * vq[j];
            }
        }
    }
    q
}

fn with_spectrum(values: &[f64]) -> Mat<f64> {
    let n = values.len();
    let q = orthonormal(n);
    let scaled = Mat::from_fn(n, n, |i, j| q[(i, j)] * values[j]);
    product(scaled.as_ref(), q.transpose())
}

#[test]
fn clustered_graded_spectra_are_found_at_any_scale() {
    // Repeated zeros, repeated large values and six decades between: what projected operators look like.
    for n in [20, 176, 300] {
        for size in [1e-9, 1.0, 1e12] {
            let values: Vec<f64> = (0..n)
                .map(|i| {
                    if i < 6 {
                        0.0
                    } else {
                        size * 1e-6_f64.powf(1.0 - (i / 3 * 3) as f64 / n as f64)
                    }
                })
                .collect();
            let a = with_spectrum(&values);
            let (found, vectors) = symmetric_eigen(a.as_ref()).unwrap();
            for (f, v) in found.iter().zip(&values) {
                assert!((f - v).abs() < 1e-13 * size, "{n} {size:e}: {f:e} {v:e}");
            }
            let image = product(a.as_ref(), vectors.as_ref());
            let residual = Mat::from_fn(n, n, |i, j| image[(i, j)] - found[j] * vectors[(i, j)]).norm_max();
            assert!(residual < 1e-13 * size, "{n} {size:e}: residual {residual:e}");
            let alone = symmetric_eigenvalues(a.as_ref()).unwrap();
            assert!(alone.iter().zip(&values).all(|(f, v)| (f - v).abs() < 1e-13 * size));
        }
    }
}

#[test]
fn a_factor_multiplies_back_and_an_indefinite_matrix_is_refused() {
    let values: Vec<f64> = (1..=150).map(f64::from).collect();
    let a = with_spectrum(&values);
    let lower = cholesky(a.as_ref()).unwrap();
    assert!((product(lower.as_ref(), lower.transpose()) - &a).norm_max() < 1e-10);
    let mut x = a.clone();
    solve_lower(lower.as_ref(), x.as_mut());
    solve_lower_transposed(lower.as_ref(), x.as_mut());
    assert!((x - Mat::<f64>::identity(150, 150)).norm_max() < 1e-11);
    assert!((congruent(lower.as_ref(), a.as_ref()) - Mat::<f64>::identity(150, 150)).norm_max() < 1e-11);
    let mut indefinite = values;
    indefinite[3] = -1.0;
    let error = cholesky(with_spectrum(&indefinite).as_ref()).unwrap_err();
    assert!(matches!(error, Error::NotPositiveDefinite { size: 150, .. }), "{error}");
}

#[test]
fn pairs_are_normalised_in_their_metric() {
    let n = 40;
    let k = with_spectrum(&(0..n).map(|i| f64::from(i) * 1e9).collect::<Vec<_>>());
    let base = with_spectrum(&(1..=n).map(|i| 1.0 + 0.1 * f64::from(i)).collect::<Vec<_>>());
    // Coordinates in very different units.
    let unit = |i: usize| if i.is_multiple_of(2) { 1e-4 } else { 1e3 };
    let scaled = |a: &Mat<f64>| Mat::from_fn(n as usize, n as usize, |i, j| a[(i, j)] * unit(i) * unit(j));
    let (k, g) = (scaled(&k), scaled(&base));
    let (values, y) = symmetric_pair(k.as_ref(), g.as_ref()).unwrap();
    let metric = product(y.transpose(), product(g.as_ref(), y.as_ref()).as_ref());
    assert!((metric - Mat::<f64>::identity(n as usize, n as usize)).norm_max() < 1e-11);
    let energy = product(y.transpose(), product(k.as_ref(), y.as_ref()).as_ref());
    for (i, value) in values.iter().enumerate() {
        assert!((energy[(i, i)] - value).abs() < 1e-11 * values[n as usize - 1]);
    }
}

#[test]
fn general_systems_are_solved_and_singular_ones_noticed() {
    let n = 90;
    let a = Mat::from_fn(n, n, |i, j| {
        ((i * 31 + j * 17 + i * j) % 23) as f64 - 11.0 + if i == j { 40.0 } else { 0.0 }
    });
    let expected: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
    let b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[(i, j)] * expected[j]).sum()).collect();
    let x = solve_general(a, &b).unwrap();
    assert!(x.iter().zip(&expected).all(|(x, e)| (x - e).abs() < 1e-12));
    assert!(solve_general(Mat::zeros(3, 3), &[1.0, 2.0, 3.0]).is_none());
}

#[test]
fn packed_products_and_inverses_fit_the_dense_ones() {
    for n in [1, 2, 3, 4, 5, 7, 8, 9, 33, 150, 263] {
        // The reflections behind `with_spectrum` need a few rows.
        let a = if n < 5 {
            Mat::from_fn(n, n, |i, j| if i == j { 3.0 } else { 0.1 * (i + j) as f64 })
        } else {
            let decades = (1..=n).map(|i| 10.0_f64.powf(-6.0 * i as f64 / n as f64));
            with_spectrum(&decades.collect::<Vec<f64>>())
        };
        let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).cos()).collect();
        let mut y = vec![f64::NAN; n];
        let packed = Symmetric::from_lower(a.as_ref());
        packed.product_into(&x, &mut y);
        assert!(packed.diagonal().eq((0..n).map(|i| a[(i, i)])), "{n}");
        let size = a.norm_max();
        for i in 0..n {
            // Only the lower triangle counts.
            let dense: f64 = (0..n).map(|j| a[(i.max(j), i.min(j))] * x[j]).sum();
            assert!(
                (y[i] - dense).abs() < 1e-15 * n as f64 * size,
                "{n} {i}: {} {dense}",
                y[i]
            );
        }
        let inverse = Symmetric::inverse_of_factor(cholesky(a.as_ref()).unwrap().as_ref());
        assert_eq!(inverse.size(), n);
        let mut back = vec![0.0; n];
        inverse.product_into(&y, &mut back);
        for (back, x) in back.iter().zip(&x) {
            assert!((back - x).abs() < 1e-9, "{n}: {back} {x}");
        }
    }
}

#[test]
fn a_mode_far_below_the_others_does_not_keep_them_from_being_found() {
    // One soft direction, as of parts that hardly touch: round-off of its inverse is 1e-9 of the others'.
    for soft in [1e-2, 1e-6] {
        let n = 120;
        let values: Vec<f64> = (0..n)
            .map(|i| if i == 0 { soft } else { 1.0 + f64::from(i).powi(2) })
            .collect();
        let lower = cholesky(with_spectrum(&values).as_ref()).unwrap();
        let (found, shapes) = lowest_pairs(lower.as_ref(), Mat::identity(n as usize, n as usize).as_ref(), 6).unwrap();
        for (f, v) in found.iter().zip(&values) {
            // Round-off of the largest eigenvalue (1.4e4) and of the largest inverse.
            let allowed = 1e-9 + 1e-10 / v + 1e-14 * v / soft;
            assert!((f / v - 1.0).abs() < allowed, "{soft:e}: {f:e} {v:e}");
        }
        let gram = product(shapes.transpose(), shapes.as_ref());
        assert!((gram - Mat::<f64>::identity(6, 6)).norm_max() < 1e-7);
    }
    // The others drown: they are found about a shift, the lowest as far as the matrix has it.
    let values: Vec<f64> = (0..120)
        .map(|i| match i {
            0 | 1 => 1e-4 * f64::from(1 + i),
            _ => 1e4 * f64::from(i).powi(2),
        })
        .collect();
    let lower = cholesky(with_spectrum(&values).as_ref()).unwrap();
    let (found, _) = lowest_pairs(lower.as_ref(), Mat::identity(120, 120).as_ref(), 6).unwrap();
    for (i, (f, v)) in found.iter().zip(&values).enumerate() {
        assert!((f / v - 1.0).abs() < if i < 2 { 1e-2 } else { 1e-8 }, "{f:e} {v:e}");
    }
    // Where it has nothing of it, that is said.
    let values: Vec<f64> = (0..120)
        .map(|i| if i == 0 { 1e-12 } else { 1e3 + f64::from(i) })
        .collect();
    if let Ok(lower) = cholesky(with_spectrum(&values).as_ref()) {
        let error = lowest_pairs(lower.as_ref(), Mat::identity(120, 120).as_ref(), 6).unwrap_err();
        assert!(
            matches!(error, Error::NoConvergence { size: 120 } | Error::Rank { .. }),
            "{error}"
        );
    }
}

#[test]
fn the_rank_does_not_depend_on_units_and_bounds_the_eigenpairs_there_are() {
    // Two masses, of which one is seen by three coordinates.
    let seen = [[1.0, 0.0], [1e-3, 1e3], [0.0, 2.0], [0.0, 0.0], [3e4, 3e4]];
    let mass = Mat::from_fn(5, 5, |i, j| (0..2).map(|k| seen[i][k] * seen[j][k]).sum::<f64>());
    assert_eq!(rank(mass.as_ref()).unwrap(), 2);
    assert_eq!(rank(Mat::<f64>::identity(4, 4).as_ref()).unwrap(), 4);
    assert_eq!(rank(Mat::<f64>::zeros(3, 3).as_ref()).unwrap(), 0);
    let identity = Mat::<f64>::identity(5, 5);
    let (values, _) = lowest_pairs(identity.as_ref(), mass.as_ref(), 2).unwrap();
    assert!(values.iter().all(|value| *value > 0.0));
    let error = lowest_pairs(identity.as_ref(), mass.as_ref(), 3).unwrap_err();
    assert!(matches!(error, Error::Rank { size: 5, count: 3 }), "{error}");
}

#[test]
fn a_semidefinite_matrix_is_the_square_of_its_factor_in_any_units() {
    let units = [1.0, 1e-6, 1e3, 1.0, 1e8];
    let seen = [[1.0, 0.0], [1.0, 1.0], [0.0, 2.0], [0.0, 0.0], [3.0, -3.0]];
    let matrix = |other: f64| {
        let of = |i: usize, j: usize| seen[i][0] * seen[j][0] + other * seen[i][1] * seen[j][1];
        Mat::from_fn(5, 5, |i, j| units[i] * units[j] * of(i, j))
    };
    let factor = semidefinite_factor(matrix(1.0).as_ref(), 1e-9).unwrap();
    assert_eq!((factor.nrows(), factor.ncols()), (5, 2));
    let (again, given) = (product(factor.as_ref(), factor.transpose()), matrix(1.0));
    for i in 0..5 {
        for j in 0..5 {
            assert!((again[(i, j)] - given[(i, j)]).abs() < 1e-13 * 9.0 * units[i] * units[j]);
        }
    }
    assert_eq!(
        semidefinite_factor(Mat::<f64>::zeros(3, 3).as_ref(), 1e-9)
            .unwrap()
            .ncols(),
        0
    );
    // A second direction that gives energy, and a coordinate without a diagonal beside which something stands.
    for wrong in [
        Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 1.5 }),
        Mat::from_fn(2, 2, |i, j| if i + j == 0 { 1.0 } else { f64::from(u8::from(i != j)) }),
        Mat::from_fn(1, 1, |_, _| -1.0),
    ] {
        let error = semidefinite_factor(wrong.as_ref(), 1e-9).unwrap_err();
        assert!(matches!(error, Error::NotSemidefinite { .. }), "{error}");
    }
}

/// A positive definite matrix that is cheap to make.
fn graded(n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| {
        let near = 1.0 / (1.0 + i.abs_diff(j) as f64).powi(2);
        if i == j { 4.0 + (i % 7) as f64 } else { near }
    })
}

#[test]
fn what_is_cut_into_tiles_is_what_it_is_in_one_piece() {
    // Beyond the sizes at which panels and tiles begin, and no multiple of them.
    let (n, wide, narrow) = (613, 300, 9);
    let a = graded(n);
    let x = |columns: usize| Mat::from_fn(n, columns, |i, j| ((i * 5 + j * 11) as f64 * 0.3).sin());
    let by_sums =
        |a: &Mat<f64>, b: &Mat<f64>, i: usize, j: usize| -> f64 { (0..n).map(|k| a[(i, k)] * b[(k, j)]).sum() };
    let lower = cholesky(a.as_ref()).unwrap();
    assert!((0..n).all(|j| (0..j).all(|i| lower[(i, j)] == 0.0)));
    assert_eq!(cholesky_in_place(a.clone()).unwrap(), lower);
    for columns in [wide, narrow] {
        let right = product(a.as_ref(), x(columns).as_ref());
        for (i, j) in [(0, 0), (n - 1, columns - 1), (255, 3), (256, 5), (400, columns / 2)] {
            assert!(
                (right[(i, j)] - by_sums(&a, &x(columns), i, j)).abs() < 1e-12,
                "{columns} {i} {j}"
            );
        }
        let mut found = right.clone();
        solve_lower(lower.as_ref(), found.as_mut());
        let half = found.clone();
        assert!((product(lower.as_ref(), half.as_ref()) - &right).norm_max() < 1e-12);
        solve_lower_transposed(lower.as_ref(), found.as_mut());
        assert!((found - x(columns)).norm_max() < 1e-12);
    }
    let tall = x(wide);
    let mut sum = a.clone();
    add_product_lower(sum.as_mut(), tall.as_ref(), tall.transpose(), -0.5);
    let square = product(tall.as_ref(), tall.transpose());
    for j in 0..n {
        for i in 0..n {
            let expected = if i < j {
                a[(i, j)]
            } else {
                a[(i, j)] - 0.5 * square[(i, j)]
            };
            assert!((sum[(i, j)] - expected).abs() < 1e-11, "{i} {j}");
        }
    }
    for columns in [7, n] {
        let triangle = lower.submatrix(0, 0, columns, columns);
        let left = a.subcols(n - columns, columns);
        let mut sum = a.subcols(0, columns).to_owned();
        add_product_with_lower(sum.as_mut(), left, triangle, -0.5);
        let expected = a.subcols(0, columns) - faer::Scale(0.5) * product(left, triangle);
        assert!((sum - expected).norm_max() < 1e-11, "{columns}");
    }
    // Each column of the inverse, of all tiles.
    let inverse = Symmetric::inverse_of_factor(lower.as_ref());
    for j in [0, 3, 127, 128, 300, n - 1] {
        let unit: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == j))).collect();
        let mut column = vec![0.0; n];
        inverse.product_into(&unit, &mut column);
        for i in 0..n {
            let back: f64 = (0..n).map(|k| a[(i, k)] * column[k]).sum();
            assert!((back - unit[i]).abs() < 1e-13, "{i} {j}");
        }
    }
}

/// Few rows, few columns and long sums, with factors stored by columns and by rows, as they are and transposed.
fn slender_products() -> Vec<Mat<f64>> {
    let sizes = [
        (8, 300, 2600),
        (24, 256, 3000),
        (3, 40, 1100),
        (2600, 300, 8),
        (90, 70_000, 8),
        (8, 70_000, 8),
        (7, 0, 1500),
    ];
    let mut found = Vec::new();
    for (rows, inner, columns) in sizes {
        let a = Mat::from_fn(rows, inner, |i, k| ((i * 7 + k * 3) % 17) as f64 - 8.0);
        let b = Mat::from_fn(inner, columns, |k, j| ((k * 5 + j * 11) % 13) as f64 - 6.0);
        let (a_by_rows, b_by_rows) = (a.transpose().to_owned(), b.transpose().to_owned());
        for a in [a.as_ref(), a_by_rows.transpose()] {
            for b in [b.as_ref(), b_by_rows.transpose()] {
                let mut c = product(a, b);
                add_product(c.as_mut(), a, b, 2.0);
                let mut by_rows = Mat::from_fn(columns, rows, |_, _| 1.0);
                add_product(by_rows.as_mut().transpose_mut(), a, b, 1.0);
                found.extend([c, by_rows]);
            }
        }
        // Sums of whole numbers have no round-off.
        let at = |i: usize, j: usize| -> f64 { (0..inner).map(|k| a[(i, k)] * b[(k, j)]).sum() };
        for pair in found[found.len() - 8..].chunks(2) {
            for (i, j) in [(0, 0), (rows - 1, columns - 1), (rows / 2, columns / 3), (rows - 1, 0)] {
                assert_eq!(
                    (pair[0][(i, j)], pair[1][(j, i)]),
                    (3.0 * at(i, j), 1.0 + at(i, j)),
                    "{rows} {inner} {columns}"
                );
            }
            assert_eq!(pair[0], found[found.len() - 8]);
            assert_eq!(pair[1], found[found.len() - 7]);
        }
    }
    found
}

#[test]
fn products_of_few_rows_or_columns_are_those_of_any_size() {
    let here = slender_products();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert!(pool.install(slender_products) == here);
}

#[test]
fn the_lower_triangle_is_copied_to_the_upper_one() {
    for n in [0, 1, 31, 32, 33, 100] {
        let value = |i: usize, j: usize| (i * 1000 + j) as f64;
        let mut a = Mat::from_fn(n, n, |i, j| if i < j { f64::NAN } else { value(i, j) });
        mirror_lower(a.as_mut());
        assert_eq!(a, Mat::from_fn(n, n, |i, j| value(i.max(j), i.min(j))));
    }
}

#[test]
fn a_pivot_that_is_not_positive_is_found_in_every_panel() {
    let n = 600;
    for bad in [0, 200, 300, 599] {
        let mut a = graded(n);
        a[(bad, bad)] = -1.0;
        let error = cholesky(a.as_ref()).unwrap_err();
        assert_eq!(error, Error::NotPositiveDefinite { pivot: bad, size: n });
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let a = graded(700);
    let right = Mat::from_fn(700, 20, |i, j| ((i + 3 * j) as f64).cos());
    let work = || {
        let lower = cholesky(a.as_ref()).unwrap();
        let mut x = right.clone();
        solve_lower(lower.as_ref(), x.as_mut());
        solve_lower_transposed(lower.as_ref(), x.as_mut());
        let (values, shapes) = lowest_pairs(lower.as_ref(), graded(700).as_ref(), 4).unwrap();
        (x, values, shapes, Symmetric::inverse_of_factor(lower.as_ref()))
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(work)
    };
    let one = on(1);
    for threads in [2, 5] {
        assert!(on(threads) == one, "{threads}");
    }
}

/// A positive definite matrix that a reflection with pairs and fixed coordinates of both signs leaves as it is.
fn reflected(n: usize) -> (Mat<f64>, Option<Reflection>) {
    let images: Vec<(usize, f64)> = (0..n)
        .map(|i| match i % 7 {
            // Apart from each other, with one sign or the other.
            0 if i + 3 < n => (i + 3, 1.0),
            3 => (i - 3, 1.0),
            1 if i + 1 < n => (i + 1, -1.0),
            2 => (i - 1, -1.0),
            4 => (i, -1.0),
            _ => (i, 1.0),
        })
        .collect();
    let any = Mat::from_fn(n, n, |i, j| ((1 + 3 * i + 7 * j + i * j) as f64).sin());
    let gram = product(any.as_ref(), any.transpose());
    let matrix = Mat::from_fn(n, n, |i, j| {
        let ((k, a), (l, b)) = (images[i], images[j]);
        gram[(i, j)] + a * b * gram[(k, l)] + if i == j { n as f64 } else { 0.0 }
    });
    (matrix, Reflection::try_new(images))
}

#[test]
fn the_inverse_by_reflected_parts_is_the_inverse() {
    for n in [1, 5, 40, 133, 300] {
        let (matrix, reflection) = reflected(n);
        let reflection = reflection.unwrap();
        let lower = cholesky(matrix.as_ref()).unwrap();
        let whole = Symmetric::inverse_of_factor(lower.as_ref());
        // The diagonal in two parts.
        let rest = Mat::from_fn(n, n, |i, j| matrix[(i, j)] - if i == j { 0.5 * n as f64 } else { 0.0 });
        let entries = (0..n).map(|i| (i, i, 0.5 * n as f64));
        let found = ReflectedInverse::try_new(rest.as_ref(), entries, &reflection, 1e-12)
            .unwrap()
            .unwrap();
        let x: Vec<f64> = (0..n).map(|i| (1.0 + i as f64).cos()).collect();
        let (mut a, mut b) = (vec![0.0; n], vec![f64::NAN; n]);
        whole.product_into(&x, &mut a);
        found.product_into(&x, &mut b);
        let largest = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() <= 1e-12 * largest, "{n}: {a} {b}");
        }
        for (a, b) in whole.diagonal().zip(found.diagonal()) {
            assert!((a - b).abs() <= 1e-12 * a, "{n}: {a} {b}");
        }
    }
}

#[test]
fn a_matrix_that_the_reflection_changes_has_no_inverse_by_parts() {
    let (mut matrix, reflection) = reflected(40);
    let reflection = reflection.unwrap();
    let none = std::iter::empty;
    let inverse = |matrix: &Mat<f64>| ReflectedInverse::try_new(matrix.as_ref(), none(), &reflection, 1e-12).unwrap();
    assert!(inverse(&matrix).is_some());
    let size = (matrix[(0, 0)] * matrix[(12, 12)]).sqrt();
    for (i, j) in [(0, 12), (12, 0)] {
        matrix[(i, j)] += 1e-10 * size;
    }
    assert!(inverse(&matrix).is_none());
    matrix[(0, 0)] = f64::NAN;
    assert!(inverse(&matrix).is_none());
    // Neither an image without its coordinate as image, nor one of another sign, nor one beyond, nor a factor.
    for images in [
        vec![(1, 1.0), (1, 1.0)],
        vec![(1, 1.0), (0, -1.0)],
        vec![(2, 1.0)],
        vec![(0, 2.0)],
        vec![(0, f64::NAN)],
    ] {
        assert_eq!(Reflection::try_new(images), None);
    }
}

#[test]
fn what_is_not_definite_is_refused_by_parts_too() {
    let matrix = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 2.0 });
    let reflection = Reflection::try_new(vec![(1, 1.0), (0, 1.0)]).unwrap();
    let refused = ReflectedInverse::try_new(matrix.as_ref(), std::iter::empty(), &reflection, 1e-12);
    assert!(matches!(refused, Err(Error::NotPositiveDefinite { .. })), "{refused:?}");
}
