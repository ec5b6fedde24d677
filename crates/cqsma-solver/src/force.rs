//! What the solver needs to know of a hysteretic force.

use contact_laws::{RegimeCounts, Sticking};
use dense_algebra::Reflection;
use faer::{Mat, MatRef};

/// Sparse pattern of a force's tangent over its coordinates, compressed rows with ascending columns, as its owner keeps it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatternView<'a> {
    /// Row starts, one more than rows.
    pub indptr: &'a [usize],
    /// Columns.
    pub indices: &'a [usize],
}

impl PatternView<'_> {
    /// A stiffness plus the sparse tangent `values` on its leading block.
    pub fn added_to(self, stiffness: MatRef<'_, f64>, values: &[f64]) -> Mat<f64> {
        let mut sum = stiffness.to_owned();
        self.entries(values)
            .for_each(|(row, column, value)| sum[(row, column)] += value);
        sum
    }

    /// Rows, columns and values of a matrix of this pattern.
    pub fn entries(self, values: &[f64]) -> impl Iterator<Item = (usize, usize, f64)> + Clone {
        (0..self.indptr.len() - 1).flat_map(move |row| {
            (self.indptr[row]..self.indptr[row + 1]).map(move |k| (row, self.indices[k], values[k]))
        })
    }

    /// `y += matrix * x` over the leading coordinates.
    pub fn add_product(self, values: &[f64], x: &[f64], y: &mut [f64]) {
        for (row, y) in y.iter_mut().enumerate().take(self.indptr.len() - 1) {
            let range = self.indptr[row]..self.indptr[row + 1];
            *y += gathered(&self.indices[range.clone()], &values[range], x);
        }
    }
}

/// `sum values x[indices]`, in sums that need not wait for one another.
fn gathered(indices: &[usize], values: &[f64], x: &[f64]) -> f64 {
    let (indices, last) = indices.as_chunks::<4>();
    let (values, own) = values.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (indices, values) in indices.iter().zip(values) {
        for (sum, (&j, value)) in sums.iter_mut().zip(indices.iter().zip(values)) {
            *sum += value * x[j];
        }
    }
    let rest: f64 = last.iter().zip(own).map(|(&j, value)| value * x[j]).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

impl PatternView<'_> {
    /// `y += matrix^T * x` over the leading coordinates.
    pub(crate) fn add_transposed_product(self, values: &[f64], x: &[f64], y: &mut [f64]) {
        for (row, x) in x.iter().enumerate().take(self.indptr.len() - 1) {
            for k in self.indptr[row]..self.indptr[row + 1] {
                y[self.indices[k]] += values[k] * x;
            }
        }
    }
}

/// A force with memory acting on the leading coordinates of a structure.
///
/// Evaluation is pure in the `begin` state; the solver alone decides when an `end` state becomes the next `begin`.
pub trait HystereticForce: Sync {
    /// History of the force.
    type State: Clone + Send + Sync;
    /// Scratch memory of one evaluation, which observers may read.
    type Workspace: Clone + Send;

    /// Number of leading coordinates it acts on.
    fn n_dofs(&self) -> usize;
    /// Pattern of its tangent.
    fn pattern(&self) -> PatternView<'_>;
    /// History of the unloaded structure.
    fn initial_state(&self) -> Self::State;
    /// Scratch memory.
    fn workspace(&self) -> Self::Workspace;
    /// Reflections of its coordinates that may leave the structure and the tangent as they are, which is then of use; it is found out whether they do.
    fn reflections(&self) -> Vec<Reflection> {
        Vec::new()
    }
    /// Whether it can take energy. If not, forces with [`Sticking::Coulomb`] depend on the displacements alone, and the way back
    /// of a loop is not computed.
    fn dissipates(&self) -> bool {
        true
    }
    /// Whether parts of points slip that count as sticking, so that the counts do not tell whether anything slips.
    fn slips_in_parts(&self) -> bool {
        false
    }
    /// Force (N) and, on request, tangent values (N/m) at displacements `u` (m) over the leading coordinates.
    fn evaluate(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &Self::State,
        end: &mut Self::State,
        workspace: &mut Self::Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts;
}
