//! Dissipation flux at the quadrature points: the area of each point's traction-jump loop (eq. 43), streamed.

use crate::interface::Workspace;

/// Loop areas per point and component, accumulated vertex by vertex without storing the loop.
///
/// The loop is closed by [`LoopArea::close`]. Where the number of its edges is a multiple of four, which are two branches of pairs, the area is
/// Simpson's, from that of the polygon and that of the polygon of every second vertex; otherwise that of the polygon. Jumps and tractions are taken
/// relative to the first vertex, which changes nothing in exact arithmetic and keeps the prestress out of the round-off.
#[derive(Clone, Debug)]
pub struct LoopArea {
    first: Option<Vertex>,
    /// Vertices added.
    count: usize,
    /// That of all vertices and that of every second one.
    polygons: [Polygon; 2],
}

/// Jump and traction at all points.
#[derive(Clone, Debug)]
struct Vertex {
    jump: [Vec<f64>; 3],
    traction: [Vec<f64>; 3],
}

/// A polygon up to its latest vertex.
#[derive(Clone, Debug)]
struct Polygon {
    last: Option<Vertex>,
    area: [Vec<f64>; 3],
}

impl LoopArea {
    /// An empty loop over `n_points` points.
    pub fn new(n_points: usize) -> Self {
        let polygon = Polygon {
            last: None,
            area: std::array::from_fn(|_| vec![0.0; n_points]),
        };
        Self {
            first: None,
            count: 0,
            polygons: [polygon.clone(), polygon],
        }
    }

    /// Adds the vertex whose fields an evaluation has left in the workspace. Allocates at the first vertex only.
    pub fn add(&mut self, workspace: &Workspace) {
        let Workspace { jump, traction, .. } = workspace;
        let first = self.first.get_or_insert_with(|| Vertex {
            jump: jump.clone(),
            traction: traction.clone(),
        });
        for (polygon, stride) in self.polygons.iter_mut().zip([1, 2]) {
            if self.count.is_multiple_of(stride) {
                polygon.add(first, jump, traction);
            }
        }
        self.count += 1;
    }

    /// Closes the loop and returns the energy dissipated per area and cycle (J/m^2): x, y, n, one value per point.
    pub fn close(mut self) -> [Vec<f64>; 3] {
        if let Some(first) = &self.first {
            for polygon in &mut self.polygons {
                polygon.add(first, &first.jump, &first.traction);
            }
        }
        let [mut fine, coarse] = self.polygons.map(|polygon| polygon.area);
        if self.count > 1 && self.count % 4 == 1 {
            for (fine, coarse) in fine.iter_mut().flatten().zip(coarse.iter().flatten()) {
                *fine += (*fine - coarse) / 3.0;
            }
        }
        fine
    }
}

impl Polygon {
    /// Adds the trapezoidal work `(t_a + t_b)/2 (u_b - u_a)` of the edge from the latest vertex `a` to the given jump and traction, tractions relative to
    /// the `first`.
    fn add(&mut self, first: &Vertex, jump: &[Vec<f64>; 3], traction: &[Vec<f64>; 3]) {
        let Some(last) = &mut self.last else {
            self.last = Some(first.clone());
            return;
        };
        for (c, sum) in self.area.iter_mut().enumerate() {
            let n = sum.len();
            let (jump, traction) = (&jump[c][..n], &traction[c][..n]);
            let (jump_a, traction_a, origin) = (&last.jump[c][..n], &last.traction[c][..n], &first.traction[c][..n]);
            for p in 0..n {
                let mean = 0.5 * (traction_a[p] + traction[p]) - origin[p];
                sum[p] += mean * (jump[p] - jump_a[p]);
            }
        }
        last.jump.clone_from(jump);
        last.traction.clone_from(traction);
    }
}

/// Sum of a flux over its components, one value per point.
pub fn total([x, y, n]: &[Vec<f64>; 3]) -> Vec<f64> {
    x.iter().zip(y).zip(n).map(|((x, y), n)| x + y + n).collect()
}
