//! A tree of bounding boxes in the plane.

/// Most items of a leaf.
const LEAF: usize = 8;

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    const EMPTY: Self = Self {
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };

    /// The smallest one around points.
    pub(crate) fn around(points: &[[f64; 2]]) -> Self {
        let mut bounds = Self::EMPTY;
        for &point in points {
            bounds.include(&Self {
                low: point,
                high: point,
            });
        }
        bounds
    }

    fn include(&mut self, other: &Self) {
        for axis in 0..2 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    /// Boxes that only touch share nothing.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.low[axis] < other.high[axis] && other.low[axis] < self.high[axis])
    }
}

/// What has a bounding box.
pub(crate) trait Bounded {
    fn bounds(&self) -> &Bounds;
}

/// Items under the bounding boxes of halves, quarters, ... of them: the halves of box `i` are `2 i` and `2 i + 1`.
pub(crate) struct Tree<T> {
    boxes: Vec<Bounds>,
    items: Vec<T>,
}

impl<T: Bounded> Tree<T> {
    /// Sorts the items so that each box holds neighbours.
    pub(crate) fn new(items: Vec<T>) -> Self {
        let mut tree = Self {
            boxes: vec![Bounds::EMPTY; (2 * items.len().next_power_of_two()).max(2)],
            items,
        };
        build(&mut tree.boxes, 1, &mut tree.items);
        tree
    }

    /// The items, in the order of the tree.
    pub(crate) fn items(&self) -> &[T] {
        &self.items
    }

    /// Shows all items whose boxes overlap `bounds`.
    pub(crate) fn visit<'t>(&'t self, bounds: &Bounds, show: &mut impl FnMut(&'t T)) {
        self.visit_box(1, &self.items, bounds, show);
    }

    fn visit_box<'t>(&'t self, index: usize, items: &'t [T], bounds: &Bounds, show: &mut impl FnMut(&'t T)) {
        if !self.boxes[index].overlaps(bounds) {
            return;
        }
        if items.len() > LEAF {
            let (low, high) = items.split_at(items.len() / 2);
            self.visit_box(2 * index, low, bounds, show);
            self.visit_box(2 * index + 1, high, bounds, show);
            return;
        }
        items
            .iter()
            .filter(|item| item.bounds().overlaps(bounds))
            .for_each(show);
    }
}

fn build<T: Bounded>(boxes: &mut [Bounds], index: usize, items: &mut [T]) {
    let mut all = Bounds::EMPTY;
    items.iter().for_each(|item| all.include(item.bounds()));
    boxes[index] = all;
    if items.len() <= LEAF {
        return;
    }
    let axis = usize::from(all.high[1] - all.low[1] > all.high[0] - all.low[0]);
    let middle = items.len() / 2;
    let centre = |item: &T| item.bounds().low[axis] + item.bounds().high[axis];
    items.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
    let (low, high) = items.split_at_mut(middle);
    build(boxes, 2 * index, low);
    build(boxes, 2 * index + 1, high);
}
