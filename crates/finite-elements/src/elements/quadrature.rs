//! Quadrature on the reference tetrahedron, wedge and cube.

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

/// Gauss points and weights on (-1, 1), exact for degree 3.
fn line_2() -> [(f64, f64); 2] {
    let g = 1.0 / 3.0_f64.sqrt();
    [(-g, 1.0), (g, 1.0)]
}

/// Gauss points and weights on (-1, 1), exact for degree 5.
fn line_3() -> [(f64, f64); 3] {
    let g = 0.6_f64.sqrt();
    [(-g, 5.0 / 9.0), (0.0, 8.0 / 9.0), (g, 5.0 / 9.0)]
}

/// Gauss points and weights on (-1, 1), exact for degree 7.
fn line_4() -> [(f64, f64); 4] {
    gauss_4().map(|(x, w)| (2.0 * x - 1.0, 2.0 * w))
}

/// Exact for degree 2 in the triangle and 3 along the wedge.
pub(super) fn wedge_6() -> Vec<Point> {
    wedge(&TRIANGLE_3, &line_2())
}

/// Exact for degree 2 in the triangle and 5 along the wedge.
pub(super) fn wedge_9() -> Vec<Point> {
    wedge(&TRIANGLE_3, &line_3())
}

/// Exact for degree 6 in the triangle, the square collapsed onto it, and 7 along the wedge.
pub(super) fn wedge_64() -> Vec<Point> {
    let line = gauss_4();
    let mut triangle = Vec::with_capacity(16);
    for (u, wu) in line {
        triangle.extend(line.map(|(v, wv)| ([u, (1.0 - u) * v], wu * wv * (1.0 - u))));
    }
    wedge(&triangle, &line_4())
}

/// Exact for degree 2.
const TRIANGLE_3: [([f64; 2], f64); 3] = [
    ([1.0 / 6.0, 1.0 / 6.0], 1.0 / 6.0),
    ([2.0 / 3.0, 1.0 / 6.0], 1.0 / 6.0),
    ([1.0 / 6.0, 2.0 / 3.0], 1.0 / 6.0),
];

/// The points of the triangle at each point of the line.
fn wedge(triangle: &[([f64; 2], f64)], line: &[(f64, f64)]) -> Vec<Point> {
    let level = |&(t, along): &(f64, f64)| {
        triangle.iter().map(move |&([r, s], weight)| Point {
            at: [r, s, t],
            weight: weight * along,
        })
    };
    line.iter().flat_map(level).collect()
}

/// Exact for degree 3 along each coordinate of the cube; points as those of 27.
pub(super) fn hexahedron_8() -> Vec<Point> {
    hexahedron(&line_2())
}

/// Exact for degree 5 along each coordinate of the cube; the first coordinate runs fastest.
pub(super) fn hexahedron_27() -> Vec<Point> {
    hexahedron(&line_3())
}

/// Exact for degree 7 along each coordinate of the cube; points as those of 27.
pub(super) fn hexahedron_64() -> Vec<Point> {
    hexahedron(&line_4())
}

fn hexahedron(line: &[(f64, f64)]) -> Vec<Point> {
    let mut points = Vec::with_capacity(line.len().pow(3));
    for &(t, wt) in line {
        for &(s, ws) in line {
            points.extend(line.iter().map(|&(r, wr)| Point {
                at: [r, s, t],
                weight: wr * ws * wt,
            }));
        }
    }
    points
}
