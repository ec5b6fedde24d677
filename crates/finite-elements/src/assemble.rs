//! From an assembly to sparse mass and stiffness over the independent displacement components.

use crate::Error;
use crate::constraints::DofMap;
use crate::elements;
use crate::mesh::{Assembly, Mesh};
use crate::reflection::Reflection;
use crate::shank::AtReferences;
use crate::sparse::{congruence, diagonal, multiply_vector, sum};
use rayon::prelude::*;
use sprs::CsMat;

/// Elements whose matrices are formed in parallel before they are added: few enough to stay in cache.
const GROUP: usize = 128;

/// Mass, stiffness and loads over the independent displacement components of an assembly.
#[derive(Clone, Debug)]
pub struct System {
    /// Stiffness, symmetric, `n x n` (N/m).
    pub stiffness: CsMat<f64>,
    /// Mass, symmetric, `n x n` (kg).
    pub mass: CsMat<f64>,
    /// One force vector of length `n` (N) per load pattern of the assembly.
    pub loads: Vec<Vec<f64>>,
    /// The independent components and what depends on them.
    pub dofs: DofMap,
    /// Position of each independent component's node (m).
    pub positions: Vec<[f64; 3]>,
    /// Total mass of the elements, the shanks and all other masses (kg).
    pub total_mass: f64,
    /// Momentum of the whole, those of what is held included, per velocity of a translation along each axis, over the independent components (kg):
    /// minus its product with the acceleration of the supports is the load that they put on what moves against them.
    pub momenta: [Vec<f64>; 3],
    /// Mass lumped at each node (kg), in proportion to the diagonal of the consistent mass, so that it is positive for all elements.
    pub nodal_mass: Vec<f64>,
    /// Reflections that take the mesh to itself; whether they keep stiffness and mass is not known.
    pub reflections: Vec<Reflection>,
}

impl System {
    /// Assembles all elements and inserts all constraints.
    ///
    /// # Errors
    /// Invalid meshes, materials and constraints; see [`Error`].
    pub fn try_new(assembly: &Assembly) -> Result<Self, Error> {
        assembly.mesh.validate()?;
        let dofs = DofMap::try_new(assembly)?;
        let (mut stiffness, mut mass) = element_matrices(&assembly.mesh, &dofs.coordinates)?;
        for (index, spring) in assembly.springs.iter().enumerate() {
            let fail = |reason| Error::Spring { spring: index, reason };
            let row = 3 * spring.node as usize + usize::from(spring.component);
            if spring.component > 2 || row >= stiffness.rows() {
                return Err(fail("it is not at a displacement component of a node"));
            }
            if !(spring.stiffness.is_finite() && spring.stiffness > 0.0) {
                return Err(fail("its stiffness must be positive and finite"));
            }
            match stiffness.get_mut(row, row) {
                Some(entry) => *entry += spring.stiffness,
                None => return Err(fail("no element holds its node")),
            }
        }
        for (index, point) in assembly.masses.iter().enumerate() {
            let fail = |reason| Error::PointMass { mass: index, reason };
            if !(point.mass.is_finite() && point.mass > 0.0) {
                return Err(fail("it must be positive and finite"));
            }
            let node = point.node as usize;
            if node >= mass.rows() {
                return Err(fail("its node does not exist"));
            }
            match mass.get_mut(node, node) {
                Some(entry) => *entry += point.mass,
                None => return Err(fail("no element holds its node")),
            }
        }
        let mut total_mass: f64 = mass.data().iter().sum();
        let mut nodal_mass = diagonal(&mass);
        let scale = total_mass / nodal_mass.iter().sum::<f64>();
        nodal_mass.iter_mut().for_each(|mass| *mass *= scale);
        let mut momenta = translation_momenta(&dofs, &mass);
        let mut stiffness = congruence(&dofs.transform, &stiffness);
        let mut mass = congruence(&dofs.transform, &for_three_components(&mass));
        if let Some(of) = AtReferences::try_new(assembly, &dofs)? {
            stiffness = sum(&stiffness, 1.0, &of.stiffness);
            mass = sum(&mass, 1.0, &of.mass);
            total_mass += of.total_mass;
            for (axis, momentum) in momenta.iter_mut().enumerate() {
                let own = multiply_vector(&of.mass, &translation(assembly, &dofs, axis));
                momentum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
        }
        let mut first_inner = 3 * assembly.mesh.nodes.len() + 6 * assembly.couplings.len() + assembly.n_pretensions();
        for body in &assembly.superelements {
            let rigid = body.in_rigid_motions(dofs.coordinates.len(), body.motions(&dofs.coordinates))?;
            let transform = body.transform(&dofs, first_inner);
            first_inner += body.n_inner();
            stiffness = sum(&stiffness, 1.0, &congruence(&transform, &body.stiffness));
            mass = sum(&mass, 1.0, &congruence(&transform, &body.mass));
            total_mass += rigid.mass.iter().sum::<f64>() / 3.0;
            for (momentum, own) in momenta.iter_mut().zip(&rigid.momenta) {
                let own = multiply_vector(&transform.transpose_view().to_csr(), own);
                momentum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
        }
        refuse_loose(assembly, &dofs, &stiffness)?;
        let loads = assembly
            .loads
            .iter()
            .map(|load| dofs.force(assembly, &load.name, &load.terms))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            stiffness,
            mass,
            loads,
            reflections: Reflection::of(&assembly.mesh, &dofs),
            positions: dofs.positions.clone(),
            dofs,
            total_mass,
            momenta,
            nodal_mass,
        })
    }

    /// Number of independent displacement components.
    pub fn n_dofs(&self) -> usize {
        self.positions.len()
    }
}

/// `T^T M r` of a nodal mass over all displacement components, held ones included, for translations `r` along the three axes.
fn translation_momenta(dofs: &DofMap, nodal: &CsMat<f64>) -> [Vec<f64>; 3] {
    let of_node: Vec<f64> = nodal.outer_iterator().map(|row| row.data().iter().sum()).collect();
    [0, 1, 2].map(|axis| {
        let mut momentum = vec![0.0; dofs.independent.len()];
        for (node, mass) in of_node.iter().enumerate() {
            for (column, share) in dofs.row(3 * node + axis) {
                momentum[column] += share * mass;
            }
        }
        momentum
    })
}

/// A translation along an axis over the independent components.
fn translation(assembly: &Assembly, dofs: &DofMap, axis: usize) -> Vec<f64> {
    let nodal = 3 * assembly.mesh.nodes.len();
    let moves = |full: &usize| match full.checked_sub(nodal) {
        None => full % 3 == axis,
        // Of the motions of reference points; overlaps, which follow them, are none.
        Some(motion) => motion < 6 * assembly.couplings.len() && motion % 6 == axis,
    };
    dofs.independent
        .iter()
        .map(|full| f64::from(u8::from(moves(full))))
        .collect()
}

/// Refuses nodes without elements, and motions of reference points, that nothing brings into the stiffness.
fn refuse_loose(assembly: &Assembly, dofs: &DofMap, stiffness: &CsMat<f64>) -> Result<(), Error> {
    let mesh = &assembly.mesh;
    let mut used = vec![false; mesh.nodes.len()];
    for &node in mesh.elements.iter().flat_map(|element| element.cell.nodes()) {
        used[node as usize] = true;
    }
    for node in (0..used.len()).filter(|&node| !used[node]) {
        for component in 0..3_u8 {
            let row = dofs.independent_index(node as u32, component);
            if row.is_some_and(|row| stiffness.outer_view(row).is_none_or(|entries| entries.nnz() == 0)) {
                return Err(Error::LooseNode { node, component });
            }
        }
    }
    let n_nodal = 3 * mesh.nodes.len();
    for (row, full) in dofs.independent.iter().enumerate() {
        let motion = full.checked_sub(n_nodal);
        let Some(coupling) = motion.and_then(|motion| assembly.couplings.get(motion / 6)) else {
            continue;
        };
        if !stiffness.get(row, row).is_some_and(|entry| *entry > 0.0) {
            return Err(Error::Coupling {
                coupling: coupling.name.clone(),
                reason: "some motion of its reference point moves no node of the cloud and no shank, and would be undetermined",
            });
        }
    }
    Ok(())
}

/// Stiffness over all displacement components and mass over all nodes, before constraints.
fn element_matrices(mesh: &Mesh, coordinates: &[[f64; 3]]) -> Result<(CsMat<f64>, CsMat<f64>), Error> {
    let n = coordinates.len();
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); n];
    for element in &mesh.elements {
        for &node in element.cell.nodes() {
            neighbours[node as usize].extend(element.cell.nodes());
        }
    }
    let mut start = Vec::with_capacity(n + 1);
    start.push(0_usize);
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
        start.push(start[start.len() - 1] + list.len());
    }
    let blocks = start[n];
    let mut stiffness = vec![0.0; 9 * blocks];
    let mut mass = vec![0.0; blocks];
    for (group, members) in mesh.elements.chunks(GROUP).enumerate() {
        let found: Vec<_> = members
            .par_iter()
            .enumerate()
            .map(|(at, element)| {
                let nodes = element.cell.nodes().iter();
                let x: Vec<_> = nodes.map(|&node| coordinates[node as usize]).collect();
                let material = &mesh.materials[element.material as usize];
                elements::matrices(group * GROUP + at, &element.cell, &x, material)
            })
            .collect();
        for (element, of_element) in members.iter().zip(found) {
            let (nodes, of_element) = (element.cell.nodes(), of_element?);
            let count = nodes.len();
            for (a, &row) in nodes.iter().enumerate() {
                let row = row as usize;
                let list = &neighbours[row];
                for (b, column) in nodes.iter().enumerate() {
                    let Ok(place) = list.binary_search(column) else {
                        continue;
                    };
                    mass[start[row] + place] += of_element.mass[a * count + b];
                    for i in 0..3 {
                        // Row 3 row + i starts at 9 start + 3 i len.
                        let at = 9 * start[row] + 3 * (i * list.len() + place);
                        for j in 0..3 {
                            stiffness[at + j] += of_element.stiffness[(3 * a + i) * 3 * count + 3 * b + j];
                        }
                    }
                }
            }
        }
    }
    let mut indptr = Vec::with_capacity(3 * n + 1);
    let mut indices = Vec::with_capacity(9 * blocks);
    indptr.push(0);
    for list in &neighbours {
        for _ in 0..3 {
            indices.extend(list.iter().flat_map(|&node| (0..3).map(move |j| 3 * node as usize + j)));
            indptr.push(indices.len());
        }
    }
    let columns = neighbours.iter().flatten().map(|&node| node as usize).collect();
    Ok((
        CsMat::new((3 * n, 3 * n), indptr, indices, stiffness),
        CsMat::new((n, n), start, columns, mass),
    ))
}

/// The nodal matrix repeated for the three displacement components.
fn for_three_components(nodal: &CsMat<f64>) -> CsMat<f64> {
    let n = nodal.rows();
    let mut indptr = vec![0];
    let (mut indices, mut data) = (Vec::with_capacity(3 * nodal.nnz()), Vec::with_capacity(3 * nodal.nnz()));
    for row in nodal.outer_iterator() {
        for component in 0..3 {
            indices.extend(row.indices().iter().map(|column| 3 * column + component));
            data.extend_from_slice(row.data());
            indptr.push(indices.len());
        }
    }
    CsMat::new((3 * n, 3 * n), indptr, indices, data)
}
