//! Displacements of the bodies in motions of the reduced structure.

use super::meshed::Meshed;
use super::{StructuralModel, Structure};
use crate::Error;
use dense_algebra::Limits;
use faer::{Mat, MatRef};
use finite_elements::sparse::multiply_into;
use joint_model::Bodies;

impl Structure {
    /// Displacement of each node of the mesh (m), motion by motion; motions of the reduced model are columns.
    ///
    /// The structure is assembled and factored again, as the reduced model does not keep its basis.
    ///
    /// # Errors
    /// [`Error::NoMesh`] of matrices; of assembly and reduction.
    pub fn displacements(
        &self,
        model: &StructuralModel,
        motions: MatRef<'_, f64>,
        limits: Limits<'_>,
    ) -> Result<Vec<Vec<[f64; 3]>>, Error> {
        let Bodies::Meshed(bodies) = &self.joint.bodies else {
            return Err(Error::NoMesh);
        };
        let meshed = Meshed::try_new(&self.joint, bodies)?;
        let rows = meshed.rows(bodies)?;
        let over = reduction::displacements(&meshed.relative, &rows, self.settings, &model.reduced, motions, limits)?;
        let independent = meshed.relative.displacements(over.as_ref());
        let transform = &meshed.system.dofs.transform;
        let mut all = Mat::zeros(transform.rows(), motions.ncols());
        multiply_into(transform, independent.as_ref(), all.as_mut());
        let n_nodes = bodies.assembly.mesh.nodes.len();
        let of_motion = |column: usize| {
            let values: Vec<f64> = all.col(column).iter().copied().collect();
            let mut nodes = values.as_chunks().0.to_vec();
            // Rotations of reference points follow the nodes.
            nodes.truncate(n_nodes);
            nodes
        };
        Ok((0..motions.ncols()).map(of_motion).collect())
    }
}
