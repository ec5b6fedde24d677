//! The median, where a mean would follow outliers.

/// Upper median of at least one value, in linear time; the order of `values` is lost.
pub(crate) fn upper_median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
