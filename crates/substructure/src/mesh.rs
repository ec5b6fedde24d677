//! Hexahedral meshes and the assemblies made of them: materials, ties, couplings, equations and point loads.

/// Linear isotropic elastic material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name used in messages.
    pub name: String,
    /// Young's modulus (Pa).
    pub youngs_modulus: f64,
    /// Poisson ratio (-).
    pub poisson_ratio: f64,
    /// Mass density (kg/m^3).
    pub density: f64,
}

/// Eight-node hexahedron. Nodes 0-3 run counter-clockwise round one face seen from outside of the opposite face
/// (the usual order of FE codes: bottom face, then top face), so that the Jacobian determinant is positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hex8 {
    /// Node numbers, zero based.
    pub nodes: [u32; 8],
    /// Index into [`Mesh::materials`].
    pub material: u16,
}

/// A solid mesh of hexahedra.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Node coordinates (m).
    pub nodes: Vec<[f64; 3]>,
    /// Elements.
    pub elements: Vec<Hex8>,
    /// Materials the elements refer to.
    pub materials: Vec<Material>,
}

/// Slave nodes glued to the faces they lie on: `u_slave = sum_i N_i u_master,i` at the projection of the slave.
/// A slave is moved onto its face (strain-free adjustment), so that rigid motion of the pair costs no energy.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Name used in messages.
    pub name: String,
    /// Nodes that follow.
    pub slave_nodes: Vec<u32>,
    /// Quadrilateral faces of the master surface, as node numbers in cyclic order.
    pub master_faces: Vec<[u32; 4]>,
    /// Slaves farther than this from every master face are refused (m).
    pub position_tolerance: f64,
}

/// A reference point whose six motions are the weighted mean motion of a cloud of nodes (distributing coupling).
#[derive(Clone, Debug, PartialEq)]
pub struct DistributingCoupling {
    /// Name used in messages.
    pub name: String,
    /// Position of the reference point (m).
    pub reference: [f64; 3],
    /// Nodes of the cloud.
    pub nodes: Vec<u32>,
    /// One positive weight per node; any scale.
    pub weights: Vec<f64>,
}

/// One displacement or rotation component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dof {
    /// Displacement component 0..3 of a mesh node (m).
    Node(u32, u8),
    /// Component of a coupling's reference point: displacements 0..3 (m), rotations 3..6 (rad).
    Reference(u32, u8),
}

/// Homogeneous linear equation `sum coefficient * dof = 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Name used in messages.
    pub name: String,
    /// Terms.
    pub terms: Vec<(Dof, f64)>,
}

/// A named load pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadPattern {
    /// Name.
    pub name: String,
    /// Forces (N) (or moments (N m) on rotations) at components.
    pub terms: Vec<(Dof, f64)>,
}

/// A mesh with everything that connects and loads it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assembly {
    /// The solid mesh.
    pub mesh: Mesh,
    /// Ties.
    pub ties: Vec<Tie>,
    /// Distributing couplings.
    pub couplings: Vec<DistributingCoupling>,
    /// Equations.
    pub equations: Vec<Equation>,
    /// Load patterns.
    pub loads: Vec<LoadPattern>,
}
