//! Dissipation flux at the quadrature points: the area of each point's traction-jump loop (eq. 43), streamed.

use crate::interface::Workspace;

/// Loop areas per point and component, accumulated vertex by vertex without storing the loop.
///
/// The polygon is closed by [`LoopArea::close`]. Jumps and tractions are taken relative to the first vertex,
/// which changes nothing in exact arithmetic and keeps the prestress out of the round-off.
#[derive(Clone, Debug)]
pub struct LoopArea {
    first: Option<Vertex>,
    last: Option<Vertex>,
    area: [Vec<f64>; 3],
}

/// Jump and traction at all points.
type Vertex = ([Vec<f64>; 3], [Vec<f64>; 3]);

impl LoopArea {
    /// An empty loop over `n_points` points.
    pub fn new(n_points: usize) -> Self {
        Self {
            first: None,
            last: None,
            area: std::array::from_fn(|_| vec![0.0; n_points]),
        }
    }

    /// Adds the vertex whose fields an evaluation has left in the workspace.
    pub fn add(&mut self, workspace: &Workspace) {
        let vertex = (workspace.jump.clone(), workspace.traction.clone());
        match &mut self.last {
            None => {
                self.first = Some(vertex.clone());
                self.last = Some(vertex);
            }
            Some(last) => {
                if let Some(first) = &self.first {
                    add_edge(&mut self.area, first, last, &vertex);
                }
                *last = vertex;
            }
        }
    }

    /// Closes the polygon and returns the energy dissipated per area and cycle (J/m^2): x, y, n, one value per point.
    pub fn close(mut self) -> [Vec<f64>; 3] {
        if let (Some(first), Some(last)) = (&self.first, &self.last) {
            add_edge(&mut self.area, first, last, first);
        }
        self.area
    }
}

/// Trapezoidal work `(t_a + t_b)/2 (u_b - u_a)` of one edge, tractions relative to `origin`.
fn add_edge(area: &mut [Vec<f64>; 3], origin: &Vertex, a: &Vertex, b: &Vertex) {
    for (c, sum) in area.iter_mut().enumerate() {
        for (p, sum) in sum.iter_mut().enumerate() {
            let traction = 0.5 * (a.1[c][p] + b.1[c][p]) - origin.1[c][p];
            *sum += traction * (b.0[c][p] - a.0[c][p]);
        }
    }
}
