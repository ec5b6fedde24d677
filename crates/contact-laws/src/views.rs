//! Views of batches of points.
//!
//! All batches are structures of arrays. The slices of one call have the length of the range of points that is
//! evaluated; entry `i` belongs to point `points.start + i`.

/// One vector per point: components along x, y and the normal n.
#[derive(Debug, Clone, Copy)]
pub struct Components<'a> {
    /// Along x.
    pub x: &'a [f64],
    /// Along y.
    pub y: &'a [f64],
    /// Along the normal.
    pub n: &'a [f64],
}

impl<'a> Components<'a> {
    /// From the components, which must have the same length.
    pub fn new(x: &'a [f64], y: &'a [f64], n: &'a [f64]) -> Self {
        Self { x, y, n }
    }

    /// From the values of the components one after the other, a third each.
    pub fn stacked(values: &'a [f64]) -> Self {
        let (x, others) = values.split_at(values.len() / 3);
        let (y, n) = others.split_at(x.len());
        Self { x, y, n }
    }
}

/// Like [`Components`], to be written.
#[derive(Debug)]
pub struct ComponentsMut<'a> {
    /// Along x.
    pub x: &'a mut [f64],
    /// Along y.
    pub y: &'a mut [f64],
    /// Along the normal.
    pub n: &'a mut [f64],
}

impl<'a> ComponentsMut<'a> {
    /// From the components, which must have the same length.
    pub fn new(x: &'a mut [f64], y: &'a mut [f64], n: &'a mut [f64]) -> Self {
        Self { x, y, n }
    }

    /// From the values of the components one after the other, a third each.
    pub fn stacked(values: &'a mut [f64]) -> Self {
        let (x, others) = values.split_at_mut(values.len() / 3);
        let (y, n) = others.split_at_mut(x.len());
        Self { x, y, n }
    }
}

/// Calls `step` with jump, begin state, end state and tractions of `n` points at each step of a path, each from the end state of the one before.
///
/// `path` and `traction` are `[step][component][point]`. `state` is that at the begin of the path, and becomes that at its end; `room` is as large.
///
/// # Panics
/// If there are no points, or `room` and `state` differ in length.
pub fn along_path(
    n: usize,
    path: &[f64],
    state: &mut [f64],
    room: &mut [f64],
    traction: &mut [f64],
    mut step: impl FnMut(Components<'_>, StateView<'_>, StateViewMut<'_>, ComponentsMut<'_>),
) {
    let (mut from, mut to) = (&mut *state, &mut *room);
    let (mut zeros, mut next) = (usize::MAX, usize::MAX);
    let (mut is_finite, mut is_swapped) = (false, false);
    for (jump, traction) in path.chunks_exact(3 * n).zip(traction.chunks_exact_mut(3 * n)) {
        let begin = StateView::new(from, n, 0)
            .known_finite(is_finite)
            .with_zeros_from(zeros);
        let end = StateViewMut::new(to, n, 0).with_zeros_from(&mut next);
        step(Components::stacked(jump), begin, end, ComponentsMut::stacked(traction));
        is_finite = traction.iter().all(|traction| traction.is_finite());
        (from, to) = (to, from);
        (zeros, next) = (next, zeros);
        is_swapped = !is_swapped;
    }
    if is_swapped {
        state.copy_from_slice(room);
    }
}

/// State of a batch of points inside a block stored as `[component][point]`.
///
/// Component `c` of the batch's point `i` is `data[c * stride + offset + i]`: `stride` is the number of points of the
/// whole block, `offset` the batch's first point in it.
#[derive(Debug, Clone, Copy)]
pub struct StateView<'a> {
    /// The whole block.
    pub data: &'a [f64],
    /// Points of the block.
    pub stride: usize,
    /// First point of the batch in the block.
    pub offset: usize,
    /// Whether all its numbers are known to be finite, so that a law need not look at those it does not need.
    pub is_finite: bool,
    /// Components from this one on are known to be zero at all points of the block.
    pub zero_from: usize,
}

impl<'a> StateView<'a> {
    /// A batch that begins at `offset` of a block of `stride` points.
    pub fn new(data: &'a [f64], stride: usize, offset: usize) -> Self {
        Self {
            data,
            stride,
            offset,
            is_finite: false,
            zero_from: usize::MAX,
        }
    }

    /// The same batch, whose numbers are known to be finite if `is_finite`. An end state is finite where tractions came out finite.
    #[must_use]
    pub fn known_finite(self, is_finite: bool) -> Self {
        Self { is_finite, ..self }
    }

    /// The same batch, in a block whose components from one on are known to be zero.
    #[must_use]
    pub fn with_zeros_from(self, component: usize) -> Self {
        Self {
            zero_from: component,
            ..self
        }
    }

    /// The first `n` points' values of the first `N` components.
    ///
    /// # Panics
    /// When the block is too short.
    #[inline]
    pub fn components<const N: usize>(&self, n: usize) -> [&'a [f64]; N] {
        core::array::from_fn(|c| self.component(c, n))
    }

    /// The first `n` points' values of component `c`.
    ///
    /// # Panics
    /// When the block is too short.
    #[inline]
    pub fn component(&self, c: usize, n: usize) -> &'a [f64] {
        &self.data[c * self.stride + self.offset..][..n]
    }
}

/// Like [`StateView`], to be written.
#[derive(Debug)]
pub struct StateViewMut<'a> {
    /// The whole block.
    pub data: &'a mut [f64],
    /// Points of the block.
    pub stride: usize,
    /// First point of the batch in the block.
    pub offset: usize,
    /// Components from this one on are known to be zero at all points of the block before it is written, so that zeros need not be written there.
    pub zero_from: usize,
    /// Where a law says from which component on it leaves zeros, if it knows.
    pub leaves_zeros_from: Option<&'a mut usize>,
}

impl<'a> StateViewMut<'a> {
    /// A batch that begins at `offset` of a block of `stride` points.
    pub fn new(data: &'a mut [f64], stride: usize, offset: usize) -> Self {
        Self {
            data,
            stride,
            offset,
            zero_from: usize::MAX,
            leaves_zeros_from: None,
        }
    }

    /// The same batch, which is a whole block whose components from one on are zero. It becomes the number of the component from which on zeros are
    /// left, or [`usize::MAX`] where the law does not know.
    #[must_use]
    pub fn with_zeros_from(self, component: &'a mut usize) -> Self {
        Self {
            zero_from: core::mem::replace(component, usize::MAX),
            leaves_zeros_from: Some(component),
            ..self
        }
    }

    /// The same, to be read.
    pub fn as_view(&self) -> StateView<'_> {
        StateView::new(self.data, self.stride, self.offset)
    }

    /// The first `n` points' values of the first `N` components.
    ///
    /// # Panics
    /// When the block is too short.
    #[inline]
    pub fn components<const N: usize>(self, n: usize) -> [&'a mut [f64]; N] {
        let mut rest = self.data;
        core::array::from_fn(|_| {
            let block = core::mem::take(&mut rest);
            // The last component may end before its stride.
            let (component, after) = block.split_at_mut(self.stride.min(block.len()));
            rest = after;
            &mut component[self.offset..][..n]
        })
    }
}

/// A direction of a law's derivative, and where the derivatives go.
pub(crate) struct Along<'a> {
    pub(crate) d_jump: Components<'a>,
    pub(crate) d_begin: StateView<'a>,
    pub(crate) d_end: StateViewMut<'a>,
    pub(crate) d_traction: ComponentsMut<'a>,
    /// Changes of the tractions part by part, `[part][x, y, n][point]` without holes, zero before.
    pub(crate) parts: Option<&'a mut [f64]>,
}
