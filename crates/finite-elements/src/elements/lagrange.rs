//! Quadratic Lagrange polynomials on the line from -1 to 1.

/// Value and slope at `x` of the polynomial that is one at `node` (-1, 0 or 1) and zero at the two others.
pub(super) fn lagrange(node: f64, x: f64) -> [f64; 2] {
    if node == 0.0 {
        [1.0 - x * x, -2.0 * x]
    } else {
        [0.5 * x * (x + node), x + 0.5 * node]
    }
}
