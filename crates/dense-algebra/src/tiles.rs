//! Products and triangular solves in tiles that threads share.
//!
//! Where tiles begin and end depends on the sizes alone, and each is computed on one thread: the result does not depend on how many there are.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self as triangular_product, BlockStructure};
use faer::linalg::triangular_solve as triangular;
use faer::reborrow::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Columns or rows of a tile, at least.
pub(crate) const TILE: usize = 128;

/// Columns of a tile of so many: each tile packs the other factor anew, which costs the less the wider it is, as long as there are enough to share.
fn width_of_tile(columns: usize) -> usize {
    (columns / 8).next_multiple_of(TILE / 2).clamp(TILE, 4 * TILE)
}

/// Steps of a factorisation or a triangular solve that come one after another.
pub(crate) const PANEL: usize = 256;

/// Multiplications that are worth a tile.
const WORTH: usize = 1 << 21;

/// Numbers, read once from memory, that are worth a tile.
const WORTH_READING: usize = 1 << 16;

/// Pieces of a sum that is long.
const PIECES: usize = 16;

/// Rows of a product so few that reading the other factor takes longer than multiplying.
const FEW: usize = 64;

/// Rows of a factor that is read against its order are taken so many at once, each over so many columns of it: as many streams as are
/// fetched ahead.
const STREAMS: usize = 16;
const STREAM: usize = 1024;

/// Whether `multiplications` are too few to share.
fn is_small(multiplications: usize) -> bool {
    multiplications < 2 * WORTH
}

/// `c = a b` or `c += factor a b`.
pub(crate) fn product(c: MatMut<'_, f64>, accum: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    let (rows, inner, columns) = (c.nrows(), a.ncols(), c.ncols());
    assert_eq!((a.nrows(), b.nrows(), b.ncols()), (rows, inner, columns));
    if columns <= FEW && c.row_stride().abs() > c.col_stride().abs() {
        // What is said of few rows below holds for few columns too.
        return product(c.transpose_mut(), accum, b.transpose(), a.transpose(), factor);
    }
    if rows <= FEW && columns > rows {
        return few_rows(c, accum, a, b, factor);
    }
    let small = is_small(rows * columns * inner);
    if !small && columns >= 2 * TILE {
        let width = width_of_tile(columns);
        let tiles: Vec<_> = c.par_col_chunks_mut(width).collect();
        tiles.into_par_iter().enumerate().for_each(|(at, tile)| {
            let b = b.subcols(at * width, tile.ncols());
            matmul(tile, accum, a, b, factor, Par::Seq);
        });
    } else if !small && rows >= 2 * TILE {
        let tiles: Vec<_> = c.par_row_chunks_mut(TILE).collect();
        tiles.into_par_iter().enumerate().for_each(|(at, tile)| {
            let a = a.subrows(at * TILE, tile.nrows());
            matmul(tile, accum, a, b, factor, Par::Seq);
        });
    } else if !small && inner >= PIECES * 2 * TILE {
        in_pieces(c, accum, a, b, factor);
    } else {
        matmul(c, accum, a, b, factor, Par::Seq);
    }
}

/// [`product`] of long rows and long columns, which threads share.
fn in_pieces(mut c: MatMut<'_, f64>, accum: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    let (rows, inner, columns) = (c.nrows(), a.ncols(), c.ncols());
    let length = inner.div_ceil(PIECES);
    let piece = |first: usize| {
        let count = length.min(inner - first);
        let mut sum = Mat::zeros(rows, columns);
        let (a, b) = (a.subcols(first, count), b.subrows(first, count));
        matmul(sum.as_mut(), Accum::Replace, a, b, factor, Par::Seq);
        sum
    };
    let starts: Vec<usize> = (0..inner).step_by(length).collect();
    let sums: Vec<Mat<f64>> = starts.into_par_iter().map(piece).collect();
    if matches!(accum, Accum::Replace) {
        c.fill(0.0);
    }
    sums.iter().for_each(|sum| c += sum);
}

/// [`product`] of which reading `b` takes most of the time.
fn few_rows(c: MatMut<'_, f64>, accum: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    let (inner, columns) = (b.nrows(), b.ncols());
    let against_order = b.row_stride().abs() > b.col_stride().abs();
    let width = if against_order { STREAM } else { TILE };
    let tile = |c: MatMut<'_, f64>, b: MatRef<'_, f64>| match against_order {
        false => matmul(c, accum, a, b, factor, Par::Seq),
        true => in_streams(c, accum, a, b, factor),
    };
    if inner * columns < 2 * WORTH_READING || columns <= width {
        tile(c, b);
        return;
    }
    let tiles: Vec<_> = c.par_col_chunks_mut(width).collect();
    tiles.into_par_iter().enumerate().for_each(|(at, c)| {
        let b = b.subcols(at * width, c.ncols());
        tile(c, b);
    });
}

/// The same on this thread, for a `b` whose rows are contiguous.
fn in_streams(mut c: MatMut<'_, f64>, mut accum: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    let inner = b.nrows();
    for first in (0..inner.max(1)).step_by(STREAMS) {
        let count = STREAMS.min(inner - first);
        let (a, b) = (a.subcols(first, count), b.subrows(first, count));
        matmul(c.rb_mut(), accum, a, b, factor, Par::Seq);
        accum = Accum::Add;
    }
}

/// The lower triangle of `c += factor a b`.
pub(crate) fn add_lower(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    let size = c.nrows();
    assert_eq!(
        (c.ncols(), a.nrows(), b.nrows(), b.ncols()),
        (size, size, a.ncols(), size)
    );
    let whole = BlockStructure::Rectangular;
    let diagonal = |tile: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>| {
        let lower = BlockStructure::TriangularLower;
        triangular_product::matmul(tile, lower, Accum::Add, a, whole, b, whole, factor, Par::Seq);
    };
    if size < 2 * TILE || is_small(size * size / 2 * a.ncols()) {
        diagonal(c, a, b);
        return;
    }
    let step = width_of_tile(size);
    let tiles: Vec<_> = c.par_col_chunks_mut(step).collect();
    // One by one: the first are the longest.
    tiles
        .into_par_iter()
        .enumerate()
        .with_max_len(1)
        .for_each(|(at, tile)| {
            let (first, width) = (at * step, tile.ncols());
            let b = b.subcols(first, width);
            let (own, below) = tile.split_at_row_mut(first).1.split_at_row_mut(width);
            diagonal(own, a.subrows(first, width), b);
            let a = a.subrows(first + width, size - first - width);
            matmul(below, Accum::Add, a, b, factor, Par::Seq);
        });
}

/// `c += factor a L` of a lower triangle `L`, with zeros above.
pub(crate) fn add_with_lower(c: MatMut<'_, f64>, a: MatRef<'_, f64>, lower: MatRef<'_, f64>, factor: f64) {
    let size = lower.nrows();
    assert_eq!(
        (c.ncols(), a.nrows(), a.ncols(), lower.ncols()),
        (size, c.nrows(), size, size)
    );
    let part = |tile: MatMut<'_, f64>, first: usize| {
        let rows = size - first;
        let lower = lower.submatrix(first, first, rows, tile.ncols());
        matmul(tile, Accum::Add, a.subcols(first, rows), lower, factor, Par::Seq);
    };
    if is_small(c.nrows() * size / 2 * size) {
        part(c, 0);
        return;
    }
    let tiles: Vec<_> = c.par_col_chunks_mut(TILE).collect();
    // One by one: the first are the longest.
    let tiles = tiles.into_par_iter().enumerate().with_max_len(1);
    tiles.for_each(|(at, tile)| part(tile, at * TILE));
}

/// `x = L^-1 x` or, `transposed`, `x = L^-T x`.
pub(crate) fn solve(lower: MatRef<'_, f64>, x: MatMut<'_, f64>, transposed: bool) {
    let size = lower.nrows();
    assert_eq!((lower.ncols(), x.nrows()), (size, size));
    if is_small(size * size / 2 * x.ncols()) {
        solve_here(lower, x, transposed);
    } else if x.ncols() >= 2 * TILE {
        let tiles: Vec<_> = x.par_col_chunks_mut(TILE).collect();
        tiles
            .into_par_iter()
            .for_each(|tile| solve_here(lower, tile, transposed));
    } else if transposed {
        solve_backward(lower, x);
    } else {
        solve_forward(lower, x);
    }
}

/// On this thread.
pub(crate) fn solve_here(lower: MatRef<'_, f64>, x: MatMut<'_, f64>, transposed: bool) {
    match transposed {
        true => triangular::solve_upper_triangular_in_place(lower.transpose(), x, Par::Seq),
        false => triangular::solve_lower_triangular_in_place(lower, x, Par::Seq),
    }
}

/// Few columns: rows that are known are taken out of those below, which threads share.
fn solve_forward(lower: MatRef<'_, f64>, mut x: MatMut<'_, f64>) {
    let size = lower.nrows();
    for first in (0..size).step_by(PANEL) {
        let width = PANEL.min(size - first);
        let last = first + width;
        let (mut known, below) = x.rb_mut().split_at_row_mut(first).1.split_at_row_mut(width);
        solve_here(lower.submatrix(first, first, width, width), known.rb_mut(), false);
        let factor = lower.submatrix(last, first, size - last, width);
        product(below, Accum::Add, factor, known.as_ref(), -1.0);
    }
}

/// As [`solve_forward`], from the last rows to the first.
fn solve_backward(lower: MatRef<'_, f64>, mut x: MatMut<'_, f64>) {
    let size = lower.nrows();
    for first in (0..size).step_by(PANEL).rev() {
        let width = PANEL.min(size - first);
        let (above, mut known) = x.rb_mut().subrows_mut(0, first + width).split_at_row_mut(first);
        solve_here(lower.submatrix(first, first, width, width), known.rb_mut(), true);
        let factor = lower.submatrix(first, 0, width, first).transpose();
        product(above, Accum::Add, factor, known.as_ref(), -1.0);
    }
}
