//! Ordering, factorisation and condensation of sparse matrices against dense ones.

use dense_algebra::{Limits, SystemMatrix, cholesky, product, solve_lower, solve_lower_transposed};
use faer::{Mat, MatRef};
use finite_elements::Error;
use finite_elements::eigen::lowest_modes_within;
use finite_elements::factor::{BLOCK, SparseCholesky};
use finite_elements::groups::Groups;
use finite_elements::ordering::nested_dissection;
use finite_elements::sets::DisjointSets;
use sprs::{CsMat, TriMat};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Points of a box, three rows each, and a matrix that couples neighbours; `seed` varies its values.
fn block(size: [usize; 3], seed: usize) -> (CsMat<f64>, Vec<[f64; 3]>) {
    let [nx, ny, nz] = size;
    let node = |i: usize, j: usize, k: usize| i + nx * (j + ny * k);
    let n = 3 * nx * ny * nz;
    let mut triplets = TriMat::new((n, n));
    let mut positions = Vec::new();
    let mut rigid = vec![0.0; n];
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                positions.extend([[i as f64, j as f64, k as f64]; 3]);
                for (di, dj, dk) in [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (1, 1, 1)] {
                    if i + di >= nx || j + dj >= ny || k + dk >= nz {
                        continue;
                    }
                    let (a, b) = (node(i, j, k), node(i + di, j + dj, k + dk));
                    for c in 0..3 {
                        for d in 0..3 {
                            let value = (1 + (a * 7 + b * 3 + c * 5 + d * 5 + seed) % 11) as f64;
                            triplets.add_triplet(3 * a + c, 3 * b + d, -value);
                            triplets.add_triplet(3 * b + d, 3 * a + c, -value);
                            rigid[3 * a + c] += value;
                            rigid[3 * b + d] += value;
                        }
                    }
                }
            }
        }
    }
    for (i, sum) in rigid.iter().enumerate() {
        triplets.add_triplet(i, i, sum + 1.0);
    }
    (triplets.to_csr(), positions)
}

fn dense(a: &CsMat<f64>) -> Mat<f64> {
    Mat::from_fn(a.rows(), a.cols(), |i, j| a.get(i, j).copied().unwrap_or(0.0))
}

fn difference(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    (a - b).norm_max() / b.norm_max()
}

/// Two boxes of which the second is far away: unconnected.
fn two_blocks() -> (CsMat<f64>, Vec<[f64; 3]>) {
    let (a, at_a) = block([5, 4, 3], 1);
    let (b, at_b) = block([4, 4, 4], 2);
    let n = a.rows() + b.rows();
    let mut triplets = TriMat::new((n, n));
    a.iter().for_each(|(v, (i, j))| triplets.add_triplet(i, j, *v));
    b.iter()
        .for_each(|(v, (i, j))| triplets.add_triplet(a.rows() + i, a.rows() + j, *v));
    let far = at_b.into_iter().map(|[x, y, z]| [x + 100.0, y, z]);
    (triplets.to_csr(), at_a.into_iter().chain(far).collect())
}

#[test]
fn every_row_is_eliminated_once_and_reaches_only_ancestors() {
    let (slender, positions) = block([40, 5, 4], 0);
    let flat = vec![[0.0; 3]; positions.len()];
    let undefined = vec![[f64::NAN; 3]; positions.len()];
    let (apart, apart_positions) = two_blocks();
    for (matrix, positions, n_kept) in [
        (&slender, &positions, 0),
        (&slender, &positions, 100),
        (&slender, &positions, slender.rows()),
        (&slender, &flat, 0),
        (&slender, &undefined, 0),
        (&apart, &apart_positions, 0),
        (&apart, &vec![[1.0; 3]; apart.rows()], 0),
        (&CsMat::eye(2000), &vec![[0.0; 3]; 2000], 0),
    ] {
        let n = matrix.rows();
        let dissection = nested_dissection(matrix, positions, n_kept);
        let mut sorted = dissection.order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(n_kept..n));
        let parts = &dissection.parts;
        let mut parent = vec![usize::MAX; parts.len()];
        let mut part_of = vec![usize::MAX; n];
        let mut next = 0;
        for (number, part) in parts.iter().enumerate() {
            assert_eq!(part.rows.start, next);
            next = part.rows.end;
            part.rows.clone().for_each(|k| part_of[dissection.order[k]] = number);
            for &child in &part.children {
                assert!(child < number && parent[child] == usize::MAX);
                parent[child] = number;
            }
        }
        assert_eq!(
            parent.iter().filter(|&&p| p == usize::MAX).count(),
            usize::from(n > n_kept)
        );
        for (_, (i, j)) in matrix {
            let (mut low, high) = (part_of[i].min(part_of[j]), part_of[i].max(part_of[j]));
            while low < high && high != usize::MAX {
                low = parent[low];
            }
            assert!(
                low == high || high == usize::MAX,
                "rows {i} and {j} meet before a separator"
            );
        }
    }
}

#[test]
fn planes_and_distances_keep_the_fill_of_a_bar_linear_in_its_length() {
    let entries = |length: usize, geometry: bool| {
        let (matrix, mut positions) = block([length, 5, 4], 0);
        if !geometry {
            positions.fill([0.0; 3]);
        }
        SparseCholesky::try_new(&matrix, &positions, "bar").unwrap().entries() as f64
    };
    for geometry in [true, false] {
        let (short, long) = (entries(40, geometry), entries(80, geometry));
        println!("{short} {long}");
        assert!(long < 2.3 * short, "{short} {long}");
        // Rows of the factor are a few sections of 60 rows long.
        assert!(short < 40.0 * 60.0 * 180.0, "{short}");
    }
}

#[test]
fn a_long_bar_is_eliminated_from_its_ends() {
    // Rows left after each separator: on one side of it but for the one that is last, where halves of halves have some on both.
    let (matrix, positions) = block([160, 5, 4], 0);
    let dissection = nested_dissection(&matrix, &positions, 0);
    let section = 60;
    let mut part_of = vec![0; matrix.rows()];
    for (number, part) in dissection.parts.iter().enumerate() {
        part.rows.clone().for_each(|k| part_of[dissection.order[k]] = number);
    }
    let mut beyond = vec![BTreeSet::new(); dissection.parts.len()];
    for (number, part) in dissection.parts.iter().enumerate() {
        let rows = part.rows.clone().map(|k| dissection.order[k]);
        let own = rows.flat_map(|row| matrix.outer_view(row).unwrap().indices().to_vec());
        let children = part.children.iter().flat_map(|&child| beyond[child].iter().copied());
        beyond[number] = own.chain(children).filter(|&row| part_of[row] > number).collect();
    }
    let separators: Vec<usize> = (0..dissection.parts.len())
        .filter(|&number| !dissection.parts[number].children.is_empty())
        .filter(|&number| dissection.parts[number].rows.len() == section)
        .collect();
    let two_sided = separators
        .iter()
        .filter(|&&number| beyond[number].len() > section)
        .count();
    assert!(
        separators.len() > 20 && 4 * two_sided < separators.len(),
        "{two_sided} of {}",
        separators.len()
    );
    // As deep as the bar is long it must not become: eliminations are nested as deep as the tree.
    let (matrix, positions) = block([1500, 2, 2], 0);
    let dissection = nested_dissection(&matrix, &positions, 0);
    let mut height = vec![0; dissection.parts.len()];
    for (number, part) in dissection.parts.iter().enumerate() {
        height[number] = 1 + part.children.iter().map(|&child| height[child]).max().unwrap_or(0);
    }
    assert!(height.iter().max() < Some(&90), "{:?}", height.iter().max());
}

#[test]
fn the_rows_of_a_part_hang_together_by_what_is_eliminated_before() {
    // A bar with a slit from its middle third to its end: separators that change places are cut by one another.
    let (bar, positions) = block([90, 6, 8], 0);
    let mut slit = TriMat::new(bar.shape());
    for (value, (i, j)) in &bar {
        let ([x, _, z], [other, _, above]) = (positions[i], positions[j]);
        if x.max(other) < 30.0 || (z < 4.0) == (above < 4.0) {
            slit.add_triplet(i, j, *value);
        }
    }
    let matrix: CsMat<f64> = slit.to_csr();
    for n_kept in [0, 3 * 90 * 6] {
        let dissection = nested_dissection(&matrix, &positions, n_kept);
        let mut position: Vec<usize> = (dissection.order.len()..).take(matrix.rows()).collect();
        for (at, &row) in dissection.order.iter().enumerate() {
            position[row] = at;
        }
        let mut beyond: Vec<BTreeSet<usize>> = Vec::new();
        for part in &dissection.parts {
            let mut sets = DisjointSets::new(part.rows.len());
            let place = |at: &usize| part.rows.contains(at).then(|| (at - part.rows.start) as u32);
            let mut touched = BTreeSet::new();
            for (own, &row) in dissection.order[part.rows.clone()].iter().enumerate() {
                let others = matrix.outer_view(row).unwrap();
                let others = others.indices().iter().map(|&other| position[other]);
                touched.extend(others.clone());
                others
                    .filter_map(|at| place(&at))
                    .for_each(|other| sets.join(own as u32, other));
            }
            for &child in &part.children {
                let own: Vec<u32> = beyond[child].iter().filter_map(place).collect();
                assert!(!own.is_empty(), "a child touches its parent");
                own.iter().for_each(|&other| sets.join(own[0], other));
                touched.extend(&beyond[child]);
            }
            assert!((0..part.rows.len() as u32).all(|own| sets.root(own) == 0));
            beyond.push(touched.range(part.rows.end..).copied().collect());
        }
    }
}

#[test]
fn solutions_are_those_of_the_dense_factor_for_any_width() {
    for (matrix, positions) in [block([9, 5, 4], 3), two_blocks(), block([2, 1, 1], 4)] {
        let n = matrix.rows();
        let factor = SparseCholesky::try_new(&matrix, &positions, "test").unwrap();
        let lower = cholesky(dense(&matrix).as_ref()).unwrap();
        for width in [0, 1, 7, BLOCK + 3] {
            let rhs = Mat::from_fn(n, width, |i, j| ((i * 31 + j * 17) % 101) as f64 - 50.0);
            let (mut x, mut expected) = (rhs.clone(), rhs);
            factor.solve_in_place(x.as_mut());
            solve_lower(lower.as_ref(), expected.as_mut());
            solve_lower_transposed(lower.as_ref(), expected.as_mut());
            if width > 0 {
                assert!(difference(x.as_ref(), expected.as_ref()) < 1e-11);
            }
        }
    }
}

#[test]
fn condensation_is_the_dense_one() {
    for ((stiffness, positions), (mass, _)) in
        [(block([9, 5, 4], 3), block([9, 5, 4], 8)), (two_blocks(), two_blocks())]
    {
        let n = stiffness.rows();
        for n_kept in [0, 1, 50, n] {
            let (factor, condensed) = SparseCholesky::condense(
                &stiffness,
                &mass,
                &positions,
                &Groups::one(n_kept),
                &[],
                "test",
                Limits::default(),
            )
            .unwrap();
            let (k, m) = (dense(&stiffness), dense(&mass));
            let n_rest = n - n_kept;
            let lower = cholesky(k.submatrix(n_kept, n_kept, n_rest, n_rest)).unwrap();
            let mut x = k.submatrix(n_kept, 0, n_rest, n_kept).to_owned();
            solve_lower(lower.as_ref(), x.as_mut());
            solve_lower_transposed(lower.as_ref(), x.as_mut());
            let basis = Mat::from_fn(n, n_kept, |i, j| match i < n_kept {
                true => f64::from(u8::from(i == j)),
                false => -x[(i - n_kept, j)],
            });
            for (full, small) in [(&k, &condensed.stiffness), (&m, &condensed.mass)] {
                let small = &small.as_ref().to_dense();
                assert_eq!((small.nrows(), small.ncols()), (n_kept, n_kept));
                assert_eq!(small, &small.transpose().to_owned(), "exactly symmetric");
                let expected = product(basis.transpose(), product(full.as_ref(), basis.as_ref()).as_ref());
                if n_kept > 0 {
                    let error = difference(small.as_ref(), expected.as_ref());
                    assert!(error < 1e-12, "{n_kept} kept: {error:e}");
                }
            }
            // The factor is that of the rows that are not kept.
            let mut solved = k.submatrix(n_kept, 0, n_rest, n_kept).to_owned();
            factor.solve_in_place(solved.as_mut());
            if n_kept > 0 && n_rest > 0 {
                assert!(difference(solved.as_ref(), x.as_ref()) < 1e-11);
            }
        }
    }
}

/// A long block of solids and the rows of three cross-sections of it, which come first in its matrices: what three joints are to a structure.
fn with_sections_first(seed: usize, sections: [usize; 3]) -> (CsMat<f64>, Vec<[f64; 3]>, Vec<usize>) {
    let (matrix, positions) = block([40, 3, 3], seed);
    let is_in = |at: usize, x: f64| (x - at as f64).abs() < 0.5;
    let mut order: Vec<usize> = Vec::new();
    let mut sizes = Vec::new();
    for at in sections {
        let own: Vec<usize> = (0..positions.len())
            .filter(|&row| is_in(at, positions[row][0]))
            .collect();
        sizes.push(own.len());
        order.extend(own);
    }
    let kept = order.len();
    let rest: Vec<usize> = (0..positions.len())
        .filter(|row| !order[..kept].contains(row))
        .collect();
    order.extend(rest);
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, &row)| place[row] = at);
    let mut moved = sprs::TriMat::new(matrix.shape());
    for (value, (i, j)) in &matrix {
        moved.add_triplet(place[i], place[j], *value);
    }
    (moved.to_csr(), order.iter().map(|&row| positions[row]).collect(), sizes)
}

#[test]
fn groups_of_kept_rows_are_blocks_whose_coupling_is_as_near_as_it_is_asked_to_be() {
    let ((stiffness, positions, sizes), (mass, ..)) =
        (with_sections_first(3, [8, 19, 31]), with_sections_first(8, [8, 19, 31]));
    let condense = |kept: &Groups| {
        let (_, found) =
            SparseCholesky::condense(&stiffness, &mass, &positions, kept, &[], "test", Limits::default()).unwrap();
        [found.stiffness, found.mass]
    };
    let dense = condense(&Groups::one(sizes.iter().sum()));
    let mut last = f64::INFINITY;
    for tolerance in [1e-1_f64, 1e-2, 1e-3, 1e-4, 1e-12] {
        let found = condense(&Groups::new(&sizes, tolerance, [&stiffness, &mass]));
        let mut worst = 0.0_f64;
        for (found, dense) in found.iter().zip(&dense) {
            let SystemMatrix::Blocks(blocks) = found else {
                panic!("three groups are three blocks");
            };
            assert_eq!(blocks.tree().n_groups(), 3);
            worst = worst.max(difference(
                blocks.to_dense().as_ref(),
                dense.as_ref().to_dense().as_ref(),
            ));
        }
        assert!(worst <= 2.0 * tolerance.max(1e-12), "{tolerance:e}: {worst:e}");
        assert!(worst <= last, "{tolerance:e}: {worst:e} {last:e}");
        last = worst;
    }
    // Neighbours that matrices couple are one group: all three here.
    let touching = with_sections_first(3, [8, 9, 10]);
    let one = Groups::new(&touching.2, 1e-3, [&touching.0, &touching.0]);
    assert_eq!(
        one,
        Groups::new(&[touching.2.iter().sum()], 1e-3, [&touching.0, &touching.0])
    );
    // Threads change no bit.
    let groups = Groups::new(&sizes, 1e-3, [&stiffness, &mass]);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| condense(&groups))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}

/// Sections of a bar, three by four nodes of three rows each, of which five follow one another again and again.
struct Periodic {
    seed: usize,
}

impl Periodic {
    const NODES: [usize; 2] = [3, 4];
    const ROWS: usize = 36;
    const SECTIONS: usize = 5;

    /// Entries `(row, column)` of a section, and of its rows with those of the next one.
    fn section(&self, at: usize) -> [Mat<f64>; 2] {
        let [nj, _] = Self::NODES;
        let within = |i: usize| (i % 3, i / 3 % nj, i / 3 / nj);
        let behind = (at + Self::SECTIONS - 1) % Self::SECTIONS;
        let value = |a: usize, b: usize, with: usize| {
            let ((_, ja, ka), (_, jb, kb)) = (within(a), within(b));
            let is_near = ja.abs_diff(jb) < 2 && ka.abs_diff(kb) < 2;
            if is_near {
                (1 + (a * 7 + b * 3 + 5 * with + self.seed) % 11) as f64
            } else {
                0.0
            }
        };
        // Little more than all that couples a row to others: what acts on one is felt far away.
        let own = |i: usize, j: usize| match i == j {
            true => {
                let of = |j: usize| match i == j {
                    true => 0.05,
                    false => value(i.max(j), i.min(j), at),
                };
                let across = |j: usize| value(i, j, at + 100) + value(j, i, behind + 100);
                (0..Self::ROWS).map(|j| of(j) + across(j)).sum()
            }
            false => -value(i.max(j), i.min(j), at),
        };
        let of = |entry: &dyn Fn(usize, usize) -> f64| Mat::from_fn(Self::ROWS, Self::ROWS, entry);
        [of(&own), of(&|i, j| -value(i, j, at + 100))]
    }

    /// Rows of a section that are kept: on one side of the bar, in the first two sections of five.
    fn is_kept(section: usize, row: usize) -> bool {
        section % Self::SECTIONS < 2 && (row / 3).is_multiple_of(Self::NODES[0])
    }

    /// Section and row at each place where kept rows come first, and the place of each.
    fn order(sections: usize) -> (Vec<(usize, usize)>, Vec<Vec<usize>>) {
        let all = (0..sections).flat_map(|section| (0..Self::ROWS).map(move |row| (section, row)));
        let (mut order, rest): (Vec<_>, Vec<_>) = all.partition(|&(section, row)| Self::is_kept(section, row));
        order.extend(rest);
        let mut place = vec![vec![0; Self::ROWS]; sections];
        order
            .iter()
            .enumerate()
            .for_each(|(at, &(section, row))| place[section][row] = at);
        (order, place)
    }

    /// A ring or chain of so many times five sections, kept rows first, with the rows of each group.
    fn assembled(&self, count: usize, is_ring: bool) -> (CsMat<f64>, Vec<[f64; 3]>, Vec<usize>) {
        let sections = count * Self::SECTIONS;
        let (order, place) = Self::order(sections);
        let is_kept = |&&(section, row): &&(usize, usize)| Self::is_kept(section, row);
        let group = order.iter().filter(is_kept).count() / count;
        let mut entries = TriMat::new((order.len(), order.len()));
        for section in 0..sections {
            let [own, next] = self.section(section % Self::SECTIONS);
            let (here, there) = (&place[section], &place[(section + 1) % sections]);
            for j in 0..Self::ROWS {
                for i in 0..Self::ROWS {
                    entries.add_triplet(here[i], here[j], own[(i, j)]);
                    if is_ring || section + 1 < sections {
                        entries.add_triplet(here[i], there[j], next[(i, j)]);
                        entries.add_triplet(there[j], here[i], next[(i, j)]);
                    }
                }
            }
        }
        let position = |&(section, row): &(usize, usize)| {
            let angle = std::f64::consts::TAU * section as f64 / sections as f64;
            let radius = sections as f64 + (row / 3 % Self::NODES[0]) as f64;
            [radius * angle.cos(), radius * angle.sin(), (row / 9) as f64]
        };
        (
            entries.to_csr(),
            order.iter().map(position).collect(),
            vec![group; count],
        )
    }

    /// Five sections, kept rows first, if those before and behind move alike but for a phase: real parts and then imaginary ones.
    fn sector(&self, phase: f64) -> [Mat<f64>; 2] {
        let (order, place) = Self::order(Self::SECTIONS);
        let n = order.len();
        let (mut real, mut imaginary) = (Mat::zeros(n, n), Mat::zeros(n, n));
        for section in 0..Self::SECTIONS {
            let [own, next] = self.section(section);
            let behind = (section + 1) % Self::SECTIONS;
            let (cos, sin) = if behind == 0 {
                (phase.cos(), phase.sin())
            } else {
                (1.0, 0.0)
            };
            for i in 0..Self::ROWS {
                for j in 0..Self::ROWS {
                    let (here, there) = (place[section][i], place[behind][j]);
                    real[(here, place[section][j])] += own[(i, j)];
                    real[(here, there)] += cos * next[(i, j)];
                    real[(there, here)] += cos * next[(i, j)];
                    imaginary[(here, there)] += sin * next[(i, j)];
                    imaginary[(there, here)] -= sin * next[(i, j)];
                }
            }
        }
        [real, imaginary]
    }
}

/// `[a -b; b a]` for `a + i b`, kept rows first.
fn doubled([a, b]: &[Mat<f64>; 2], kept: usize) -> Mat<f64> {
    let n = a.nrows();
    let of = |i: usize| match i {
        i if i < kept => (false, i),
        i if i < 2 * kept => (true, i - kept),
        i if i < n + kept => (false, i - kept),
        i => (true, i - n),
    };
    Mat::from_fn(2 * n, 2 * n, |i, j| match (of(i), of(j)) {
        ((false, i), (true, j)) => -b[(i, j)],
        ((true, i), (false, j)) => b[(i, j)],
        ((_, i), (_, j)) => a[(i, j)],
    })
}

#[test]
fn a_ring_of_equal_sectors_is_one_sector_with_cyclic_conditions() {
    const COUNT: usize = 12;
    let tolerance = 1e-6;
    let parts = [Periodic { seed: 2 }, Periodic { seed: 9 }];
    let [(stiffness, positions, sizes), (mass, ..)] = parts.each_ref().map(|part| part.assembled(COUNT, true));
    let kept = sizes[0];
    let groups = Groups::new(&sizes, tolerance, [&stiffness, &mass]);
    let (_, found) =
        SparseCholesky::condense(&stiffness, &mass, &positions, &groups, &[], "test", Limits::default()).unwrap();
    let SystemMatrix::Blocks(blocks) = &found.stiffness else {
        panic!("a group per sector is a block per sector");
    };
    let tree = blocks.tree();
    assert_eq!(tree.n_groups(), COUNT);
    assert!(tree.nodes().len() > COUNT, "groups are united");
    let of_ring = [&found.stiffness, &found.mass].map(|matrix| matrix.as_ref().to_dense());
    let mut squares = Vec::new();
    for wave in 0..COUNT {
        let phase = std::f64::consts::TAU * wave as f64 / COUNT as f64;
        let [k, m] = parts.each_ref().map(|part| doubled(&part.sector(phase), kept));
        let (first, rest) = (2 * kept, k.nrows() - 2 * kept);
        let lower = cholesky(k.submatrix(first, first, rest, rest)).unwrap();
        let mut follow = k.submatrix(first, 0, rest, first) * faer::Scale(-1.0);
        solve_lower(lower.as_ref(), follow.as_mut());
        solve_lower_transposed(lower.as_ref(), follow.as_mut());
        let mut basis = Mat::<f64>::identity(k.nrows(), first);
        basis.subrows_mut(first, rest).copy_from(&follow);
        let condensed = [k, m].map(|a| product(basis.transpose(), product(a.as_ref(), basis.as_ref()).as_ref()));
        for (ring, sector) in of_ring.iter().zip(&condensed) {
            // What moves with this phase from sector to sector is answered by as much.
            let sum = |part: &dyn Fn(f64) -> f64| {
                Mat::from_fn(kept, kept, |i, j| {
                    let term = |k: usize| part(phase * k as f64) * ring[(i, k * kept + j)];
                    (0..COUNT).map(term).sum::<f64>()
                })
            };
            let symbol = doubled(&[sum(&f64::cos), sum(&f64::sin)], kept);
            let error = difference(symbol.as_ref(), sector.as_ref());
            assert!(error < tolerance, "wave {wave}: {error:e}");
        }
        let (own, _) = dense_algebra::symmetric_pair(condensed[0].as_ref(), condensed[1].as_ref()).unwrap();
        // Real and imaginary parts have the same values, and are not two motions.
        squares.extend(own.into_iter().step_by(2));
    }
    squares.sort_by(f64::total_cmp);
    let factor = found.stiffness.clone().factor_plus(std::iter::empty()).unwrap();
    let (lowest, _) = factor.lowest_pairs(found.mass.as_ref(), 2 * COUNT).unwrap();
    for (ring, sector) in lowest.iter().zip(&squares) {
        assert!((ring / sector - 1.0).abs() < tolerance, "{ring} {sector}");
    }
}

#[test]
fn a_chain_of_equal_parts_follows_its_transfer_matrices() {
    const COUNT: usize = 12;
    let tolerance = 1e-6;
    let part = Periodic { seed: 2 };
    let (stiffness, positions, sizes) = part.assembled(COUNT, false);
    let groups = Groups::new(&sizes, tolerance, [&stiffness, &stiffness]);
    let (_, found) = SparseCholesky::condense(
        &stiffness,
        &stiffness,
        &positions,
        &groups,
        &[],
        "test",
        Limits::default(),
    )
    .unwrap();
    let kept = groups.len();
    let mut force = vec![0.0; kept];
    force[0] = 1.0;
    let mut moved = vec![0.0; kept];
    let factor = found.stiffness.factor_plus(std::iter::empty()).unwrap();
    factor.into_inverse().product_into(&force, &mut moved);
    // Each section with all that follows it, from the last one on, and how it moves with the one before it.
    let solved = |matrix: &Mat<f64>, right: Mat<f64>| {
        let (lower, mut x) = (cholesky(matrix.as_ref()).unwrap(), right);
        solve_lower(lower.as_ref(), x.as_mut());
        solve_lower_transposed(lower.as_ref(), x.as_mut());
        x
    };
    let sections = COUNT * Periodic::SECTIONS;
    let mut transfers = Vec::new();
    let mut whole = part.section((sections - 1) % Periodic::SECTIONS)[0].clone();
    for section in (0..sections - 1).rev() {
        let [own, next] = part.section(section % Periodic::SECTIONS);
        let transfer = solved(&whole, next.transpose() * faer::Scale(-1.0));
        whole = own + product(next.as_ref(), transfer.as_ref());
        transfers.push(transfer);
    }
    let unit = Mat::from_fn(Periodic::ROWS, 1, |i, _| f64::from(u8::from(i == 0)));
    let mut u = solved(&whole, unit);
    let mut expected = Vec::new();
    for section in 0..sections {
        expected.extend(
            (0..Periodic::ROWS)
                .filter(|&row| Periodic::is_kept(section, row))
                .map(|row| u[(row, 0)]),
        );
        if let Some(transfer) = transfers.pop() {
            u = product(transfer.as_ref(), u.as_ref());
        }
    }
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (group, (found, expected)) in moved.chunks(sizes[0]).zip(expected.chunks(sizes[0])).enumerate() {
        let difference: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
        let error = largest(&difference) / largest(expected);
        // What the far end feels is a thirtieth of what its load does to the near one.
        assert!(error < 4.0 * tolerance, "{group}: {error:e}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let ((stiffness, positions), (mass, _)) = (block([20, 6, 5], 3), block([20, 6, 5], 8));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (factor, condensed) = SparseCholesky::condense(
                &stiffness,
                &mass,
                &positions,
                &Groups::one(60),
                &[],
                "test",
                Limits::default(),
            )
            .unwrap();
            let mut x = Mat::from_fn(positions.len() - 60, 3 * BLOCK, |i, j| ((i + 3 * j) % 13) as f64);
            factor.solve_in_place(x.as_mut());
            (condensed.stiffness, condensed.mass, x)
        })
    };
    let one = run(1);
    assert!(one == run(2) && one == run(5));
}

#[test]
fn work_beyond_its_limits_is_refused_before_it_is_done() {
    let ((stiffness, positions), (mass, _)) = (block([20, 6, 5], 3), block([20, 6, 5], 8));
    let condense = |limits: Limits<'_>| {
        SparseCholesky::condense(&stiffness, &mass, &positions, &Groups::one(60), &[], "test", limits)
    };
    let Err(Error::Memory { needed, limit: 1, .. }) = condense(Limits::default().within(Some(1))) else {
        panic!("one byte is not enough");
    };
    // No less than the factor that comes of it.
    let (factor, _) = condense(Limits::default().within(Some(needed))).unwrap();
    assert!(needed > 8 * factor.entries() as u64, "{needed} {}", factor.entries());
    assert!(condense(Limits::default().within(Some(needed - 1))).is_err());
    let asked = AtomicUsize::new(0);
    let parts = nested_dissection(&stiffness, &positions, 60).parts.len();
    for last in [0, 1, parts, 2 * parts] {
        asked.store(0, Ordering::Relaxed);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= last;
        let stopped = condense(Limits::default().until(&stop));
        assert!(matches!(stopped, Err(Error::Interrupted)), "{last}");
    }
    let modes = |limits: Limits<'_>| lowest_modes_within(limits, &stiffness, &mass, &positions, 3, 1e-6);
    let stopped = modes(Limits::default().until(&|| true));
    assert!(matches!(stopped, Err(Error::Interrupted)));
    assert!(matches!(
        modes(Limits::default().within(Some(1))),
        Err(Error::Memory { .. })
    ));
}

#[test]
fn what_is_done_is_told_and_changes_no_bit() {
    let ((stiffness, positions), (mass, _)) = (block([20, 6, 5], 3), block([20, 6, 5], 8));
    let told = Mutex::new(Vec::new());
    let hear = |done: f64| told.lock().unwrap().push(done);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let heard = |work: &(dyn Fn(Limits<'_>) + Sync)| -> Vec<f64> {
        one_thread.install(|| work(Limits::default().heard_by(&hear)));
        std::mem::take(&mut *told.lock().unwrap())
    };
    let condense = |limits: Limits<'_>| {
        SparseCholesky::condense(&stiffness, &mass, &positions, &Groups::one(60), &[], "test", limits)
            .unwrap()
            .1
    };
    let silent = condense(Limits::default());
    let done = heard(&|limits| {
        let found = condense(limits);
        assert!(found.stiffness == silent.stiffness && found.mass == silent.mass);
    });
    assert!(done.is_sorted() && done.len() > 30, "{}", done.len());
    assert!((done.last().unwrap() - 1.0).abs() < 1e-3, "{:?}", done.last());
    // Modes are a factorisation and solves.
    let mass = CsMat::eye(positions.len());
    let done = heard(&|limits| {
        lowest_modes_within(limits, &stiffness, &mass, &positions, 3, 1e-6).unwrap();
    });
    assert!(done.is_sorted(), "{done:?}");
    assert!((0.5..=1.0).contains(done.last().unwrap()), "{done:?}");
}

#[test]
fn an_indefinite_matrix_is_refused_with_its_row() {
    let (mut matrix, positions) = block([9, 5, 4], 3);
    *matrix.get_mut(77, 77).unwrap() = -1.0;
    let error = SparseCholesky::try_new(&matrix, &positions, "test matrix").unwrap_err();
    assert!(
        matches!(
            error,
            Error::NotPositiveDefinite {
                matrix: "test matrix",
                pivot: 77,
                size: 540
            }
        ),
        "{error}"
    );
}
