//! What the solver needs to know of a hysteretic force.

/// Sparse pattern of a force's tangent over its coordinates: compressed rows with ascending columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// Row starts.
    pub indptr: Vec<usize>,
    /// Columns.
    pub indices: Vec<usize>,
}

impl Pattern {
    /// `y += matrix * x` over the leading coordinates.
    pub(crate) fn add_product(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        for (row, y) in y.iter_mut().enumerate().take(self.indptr.len() - 1) {
            let range = self.indptr[row]..self.indptr[row + 1];
            *y += self.indices[range.clone()]
                .iter()
                .zip(&values[range])
                .map(|(&j, v)| v * x[j])
                .sum::<f64>();
        }
    }
}

/// Whether friction may limit the tangential forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sliding {
    /// Friction acts.
    Allowed,
    /// Everything in contact sticks: for first guesses and for the stuck tangent.
    Prevented,
}

/// How many points are in which regime.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PointCounts {
    /// Sticking.
    pub stick: usize,
    /// Slipping.
    pub slip: usize,
    /// Open.
    pub open: usize,
}

/// A force with memory acting on the leading coordinates of a structure.
///
/// Evaluation is pure in the `begin` state; the solver alone decides when an `end` state becomes the next `begin`.
pub trait HystereticForce: Sync {
    /// History of the force.
    type State: Clone + Send + Sync;
    /// Scratch memory of one evaluation.
    type Workspace: Send;

    /// Number of leading coordinates it acts on.
    fn n_dofs(&self) -> usize;
    /// Pattern of its tangent.
    fn pattern(&self) -> &Pattern;
    /// History of the unloaded structure.
    fn initial_state(&self) -> Self::State;
    /// Scratch memory.
    fn workspace(&self) -> Self::Workspace;
    /// Whether it can take energy. If not, forces with [`Sliding::Allowed`] depend on the displacements alone, and the way back
    /// of a loop is not walked.
    fn dissipates(&self) -> bool {
        true
    }
    /// Force (N) and, on request, tangent values (N/m) at displacements `u` (m) over the leading coordinates.
    fn evaluate(
        &self,
        u: &[f64],
        sliding: Sliding,
        begin: &Self::State,
        end: &mut Self::State,
        workspace: &mut Self::Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> PointCounts;
}
