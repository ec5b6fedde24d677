//! Dissipation flux at the quadrature points: the area of each point's traction-jump loop (eq. 43), streamed.

use crate::interface::Workspace;

/// Loop areas per point and component, accumulated vertex by vertex without storing the loop.
///
/// The polygon is closed by [`LoopArea::close`]. Jumps and tractions are taken relative to the first vertex,
/// which changes nothing in exact arithmetic and keeps the prestress out of the round-off.
#[derive(Clone, Debug)]
pub struct LoopArea {
    /// The first vertex and the latest one.
    ends: Option<(Vertex, Vertex)>,
    area: [Vec<f64>; 3],
}

/// Jump and traction at all points.
#[derive(Clone, Debug)]
struct Vertex {
    jump: [Vec<f64>; 3],
    traction: [Vec<f64>; 3],
}

impl LoopArea {
    /// An empty loop over `n_points` points.
    pub fn new(n_points: usize) -> Self {
        Self {
            ends: None,
            area: std::array::from_fn(|_| vec![0.0; n_points]),
        }
    }

    /// Adds the vertex whose fields an evaluation has left in the workspace. Allocates at the first vertex only.
    pub fn add(&mut self, workspace: &Workspace) {
        let Workspace { jump, traction, .. } = workspace;
        match &mut self.ends {
            None => {
                let vertex = Vertex {
                    jump: jump.clone(),
                    traction: traction.clone(),
                };
                self.ends = Some((vertex.clone(), vertex));
            }
            Some((first, last)) => {
                add_edge(&mut self.area, first, last, jump, traction);
                last.jump.clone_from(jump);
                last.traction.clone_from(traction);
            }
        }
    }

    /// Closes the polygon and returns the energy dissipated per area and cycle (J/m^2): x, y, n, one value per point.
    pub fn close(mut self) -> [Vec<f64>; 3] {
        if let Some((first, last)) = &self.ends {
            add_edge(&mut self.area, first, last, &first.jump, &first.traction);
        }
        self.area
    }
}

/// Sum of a flux over its components, one value per point.
pub fn total([x, y, n]: &[Vec<f64>; 3]) -> Vec<f64> {
    x.iter().zip(y).zip(n).map(|((x, y), n)| x + y + n).collect()
}

/// Trapezoidal work `(t_a + t_b)/2 (u_b - u_a)` of the edge from `a` to the given jump and traction, tractions relative
/// to `origin`.
fn add_edge(area: &mut [Vec<f64>; 3], origin: &Vertex, a: &Vertex, jump: &[Vec<f64>; 3], traction: &[Vec<f64>; 3]) {
    for (c, sum) in area.iter_mut().enumerate() {
        let n = sum.len();
        let (jump, traction) = (&jump[c][..n], &traction[c][..n]);
        let (jump_a, traction_a, origin) = (&a.jump[c][..n], &a.traction[c][..n], &origin.traction[c][..n]);
        for p in 0..n {
            let mean = 0.5 * (traction_a[p] + traction[p]) - origin[p];
            sum[p] += mean * (jump[p] - jump_a[p]);
        }
    }
}
