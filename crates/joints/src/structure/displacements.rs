//! Displacements of the bodies in motions of the reduced structure.

use super::meshed::Meshed;
use super::{StructuralModel, Structure};
use crate::Error;
use crate::store::{Options, cache};
use dense_algebra::Limits;
use faer::MatRef;
use finite_elements::sparse::multiply;
use joint_model::Bodies;

/// Share of the time of finding displacements that the modes of the stuck structure take where they are not known.
const MODES: f64 = 0.7;

impl Structure {
    /// Displacement of each node of the mesh (m), motion by motion; motions of the reduced model are columns.
    ///
    /// The structure is assembled and factored again, as the reduced model does not keep its basis; modes that the cache of the `options` holds are not
    /// found again.
    ///
    /// # Errors
    /// [`Error::NoMesh`] of matrices; of assembly and reduction.
    pub fn displacements(
        &self,
        model: &StructuralModel,
        motions: MatRef<'_, f64>,
        options: &Options,
        limits: Limits<'_>,
    ) -> Result<Vec<Vec<[f64; 3]>>, Error> {
        let Bodies::Meshed(bodies) = &self.joint.bodies else {
            return Err(Error::NoMesh);
        };
        let meshed = Meshed::try_new(&self.joint, bodies)?;
        let rows = meshed.rows(bodies)?;
        let (relative, settings) = (&meshed.relative, self.settings);
        let springs = self.springs(self.check_interface(), |_| true)?;
        let (cache, key) = (options.cache.as_deref(), self.key(options.build.as_deref()));
        let (modes, limits) = match cache.and_then(|directory| cache::load_modes(directory, &key)) {
            Some(modes) => (modes, limits),
            None => {
                let modes = reduction::modes_of_basis(relative, settings, Some(&springs), limits.part(0.0, MODES))?;
                (modes, limits.part(MODES, 1.0))
            }
        };
        let settings = (settings, Some(&springs));
        let over = reduction::displacements(relative, &rows, settings, &model.reduced, &modes, motions, limits)?;
        let independent = meshed.relative.displacements(over.as_ref());
        let all = multiply(&meshed.system.dofs.transform, independent.as_ref());
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
