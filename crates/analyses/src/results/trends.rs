//! What is read off curves: power laws, values between points, counts, limits of refinements.

use serde::Serialize;

/// A power law `y = factor x^slope`, fitted by least squares to the logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Exponent (-).
    pub slope: f64,
    /// Value at `x = 1` (unit of y).
    pub factor: f64,
    /// Rms difference of the points from the law (ln).
    pub rms: f64,
    /// Smallest and largest x that were fitted (unit of x).
    pub range: [f64; 2],
    /// Points that were fitted.
    pub points: usize,
}

/// The power law through the points `(x, y)` with `x` in `range`, both ends included; points that are not positive and
/// finite have no logarithm and are left out. None with fewer than three points or only one x.
pub fn power_law(points: &[(f64, f64)], range: [f64; 2]) -> Option<PowerLaw> {
    let usable = |v: f64| v.is_finite() && v > 0.0;
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| usable(*x) && usable(*y) && (range[0]..=range[1]).contains(x))
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    if logs.len() < 3 {
        return None;
    }
    let n = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let square: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let slope = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / square;
    let rest: f64 = logs.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sum();
    let ends = logs.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
        [low.min(p.0), high.max(p.0)]
    });
    slope.is_finite().then(|| PowerLaw {
        slope,
        factor: (y - slope * x).exp(),
        rms: (rest / n).sqrt(),
        range: ends.map(f64::exp),
        points: logs.len(),
    })
}

/// The value at `x` of a curve through points `(x, y)` with ascending positive `x`, straight in `ln x` between them.
/// None outside of the points.
pub fn at(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let pair = points.windows(2).find(|pair| pair[0].0 <= x && x <= pair[1].0)?;
    let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
    if x0 == x1 {
        return Some(y0);
    }
    Some(y0 + (y1 - y0) * (x / x0).ln() / (x1 / x0).ln())
}

/// How many of the values lie in each of `bins` classes of equal width between the smallest and the largest of them, and
/// the lower ends of the classes; values that are not finite are left out. None without values or classes.
pub fn histogram(values: &[f64], bins: usize) -> Option<Vec<(f64, usize)>> {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = (
        finite().fold(f64::INFINITY, f64::min),
        finite().fold(f64::NEG_INFINITY, f64::max),
    );
    if bins == 0 || low > high {
        return None;
    }
    let width = (high - low) / bins as f64;
    let mut counts: Vec<(f64, usize)> = (0..bins).map(|i| (low + width * i as f64, 0)).collect();
    for value in finite() {
        // All values in the first class where there is only one.
        let class = ((value - low) / width) as usize;
        counts[class.min(bins - 1)].1 += 1;
    }
    Some(counts)
}

/// What a refinement converges to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extrapolation {
    /// Power of the step that the error goes with.
    pub order: f64,
    /// Value at step zero.
    pub limit: f64,
}

/// Richardson's extrapolation from three descending step sizes that need not have a constant ratio: `value = limit +
/// constant * size^order`. None where the values do not approach a limit monotonically with an order between 0.1 and 12.
pub fn extrapolate(sizes: [f64; 3], values: [f64; 3]) -> Option<Extrapolation> {
    let [a, b, c] = sizes;
    if !(a > b && b > c && c > 0.0) {
        return None;
    }
    let wanted = (values[0] - values[1]) / (values[1] - values[2]);
    // Grows with the order, from ln(a/b) / ln(b/c) without bounds.
    let ratio = |p: f64| ((a / b).powf(p) - 1.0) / (1.0 - (c / b).powf(p));
    let (mut low, mut high) = (0.1, 12.0);
    if !(ratio(low) <= wanted && wanted <= ratio(high)) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    let order = 0.5 * (low + high);
    let constant = (values[1] - values[2]) / (b.powf(order) - c.powf(order));
    Some(Extrapolation {
        order,
        limit: values[2] - constant * c.powf(order),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_refinements_are_found() {
        let sizes = [1.0 / 12.0, 1.0 / 24.0, 1.0 / 34.0];
        for order in [0.5, 1.0, 2.0, 3.7] {
            let found = extrapolate(sizes, sizes.map(|h| 168.0 + 3.0 * h.powf(order))).unwrap();
            assert!(
                (found.order - order).abs() < 1e-6 && (found.limit - 168.0).abs() < 1e-8,
                "{found:?}"
            );
        }
        assert!(extrapolate(sizes, [1.0, 2.0, 1.5]).is_none(), "not monotone");
        assert!(extrapolate(sizes, [1.0, 2.0, 4.0]).is_none(), "not converging");
        assert!(extrapolate(sizes, [1.0; 3]).is_none());
        assert!(extrapolate([1.0, 2.0, 3.0], [1.0, 2.0, 2.5]).is_none());
    }

    #[test]
    fn a_power_law_is_recovered_from_its_range_alone() {
        let of = |x: f64| if x < 1e-3 { 7.0 * x.powf(2.4) } else { 1.0 };
        let points: Vec<(f64, f64)> = (0..60).map(|i| 1e-6 * 1.2_f64.powi(i)).map(|x| (x, of(x))).collect();
        let law = power_law(&points, [1e-5, 9e-4]).expect("enough points");
        assert!((law.slope - 2.4).abs() < 1e-12 && (law.factor / 7.0 - 1.0).abs() < 1e-10);
        assert!(law.rms < 1e-12 && law.range[0] >= 1e-5 && law.range[1] <= 9e-4);
        let bent = power_law(&points, [1e-5, 1.0]).expect("enough points");
        assert!(bent.rms > 0.1 && bent.slope != law.slope);
        assert_eq!(power_law(&points[..2], [0.0, 1.0]), None);
        assert_eq!(power_law(&[(1.0, 1.0); 5], [0.0, 2.0]), None);
        assert_eq!(
            power_law(&[(1.0, 0.0), (2.0, -1.0), (3.0, 1.0), (4.0, f64::NAN)], [0.0, 9.0]),
            None
        );
    }

    #[test]
    fn values_between_points_are_straight_in_the_logarithm() {
        let points = [(1e-3, 2.0), (1e-1, 4.0), (1.0, 4.5)];
        assert!((at(&points, 1e-2).expect("inside") - 3.0).abs() < 1e-12);
        assert_eq!(at(&points, 1.0), Some(4.5));
        assert_eq!(at(&points, 2.0), None);
        assert_eq!(at(&points, f64::NAN), None);
    }

    #[test]
    fn a_histogram_counts_every_finite_value_once() {
        let values = [0.0, 0.1, 0.5, 0.99, 1.0, f64::NAN];
        let counts = histogram(&values, 2).expect("values");
        assert_eq!(counts, [(0.0, 2), (0.5, 3)]);
        assert_eq!(histogram(&[3.0, 3.0], 4).expect("values")[0], (3.0, 2));
        assert_eq!(histogram(&[], 4), None);
    }
}
