//! Quadrature on the reference tetrahedron and wedge.

/// A point of a quadrature rule.
pub(super) struct Point {
    /// Natural coordinates.
    pub(super) at: [f64; 3],
    pub(super) weight: f64,
}

const A: f64 = 0.585_410_196_624_968_5;
const B: f64 = 0.138_196_601_125_010_5;

/// Exact for polynomials of degree 2 on the tetrahedron: points at `(5 -+ sqrt 5) / 20` and `(5 + 3 sqrt 5) / 20`.
pub(super) const TETRAHEDRON_4: [Point; 4] = [
    Point {
        at: [B, B, B],
        weight: 1.0 / 24.0,
    },
    Point {
        at: [A, B, B],
        weight: 1.0 / 24.0,
    },
    Point {
        at: [B, A, B],
        weight: 1.0 / 24.0,
    },
    Point {
        at: [B, B, A],
        weight: 1.0 / 24.0,
    },
];

/// Gauss points and weights on (0, 1), exact for degree 7.
fn gauss_4() -> [(f64, f64); 4] {
    let root = (6.0_f64 / 5.0).sqrt();
    let [near, far] = [-1.0, 1.0].map(|sign| (3.0 / 7.0 + sign * 2.0 / 7.0 * root).sqrt());
    let [heavy, light] = [1.0, -1.0].map(|sign| (18.0 + sign * 30.0_f64.sqrt()) / 72.0);
    [(-far, light), (-near, heavy), (near, heavy), (far, light)].map(|(x, w)| (0.5 * (1.0 + x), w))
}

/// Exact for degree 5 on the tetrahedron: the cube collapsed onto it.
pub(super) fn tetrahedron_64() -> Vec<Point> {
    let line = gauss_4();
    let mut points = Vec::with_capacity(64);
    for (u, wu) in line {
        for (v, wv) in line {
            for (w, ww) in line {
                points.push(Point {
                    at: [u, (1.0 - u) * v, (1.0 - u) * (1.0 - v) * w],
                    weight: wu * wv * ww * (1.0 - u).powi(2) * (1.0 - v),
                });
            }
        }
    }
    points
}

/// Exact for degree 2 in the triangle and 3 along the wedge.
pub(super) fn wedge_6() -> Vec<Point> {
    let g = 1.0 / 3.0_f64.sqrt();
    let triangle = [[1.0 / 6.0, 1.0 / 6.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]];
    [-g, g]
        .into_iter()
        .flat_map(|t| {
            triangle.map(|[r, s]| Point {
                at: [r, s, t],
                weight: 1.0 / 6.0,
            })
        })
        .collect()
}
