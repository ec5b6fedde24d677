//! Solid meshes and the assemblies made of them: materials, ties, couplings, equations, supports and point loads.

use crate::elements::Formulation;

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

/// Nodes of an element, zero based, in the order that Abaqus and CalculiX share: the corners of one face
/// counter-clockwise seen from within the element, then those of the opposite one (or its apex), so that the Jacobian
/// determinant is positive; after the corners the middles of the edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Eight-node hexahedron.
    Hex8([u32; 8], Formulation),
    /// Six-node wedge.
    Wedge6([u32; 6]),
    /// Four-node tetrahedron.
    Tet4([u32; 4]),
    /// Ten-node tetrahedron; nodes 4-9 lie between corners 01, 12, 20, 03, 13, 23.
    Tet10([u32; 10]),
}

impl Cell {
    /// All nodes.
    pub fn nodes(&self) -> &[u32] {
        match self {
            Self::Hex8(nodes, _) => nodes,
            Self::Wedge6(nodes) => nodes,
            Self::Tet4(nodes) => nodes,
            Self::Tet10(nodes) => nodes,
        }
    }

    /// The faces, counter-clockwise seen from outside, in the numbering of Abaqus and CalculiX (`S1` comes first).
    pub fn faces(&self) -> Vec<Face> {
        match self {
            Self::Hex8(n, _) => [
                [0, 3, 2, 1],
                [4, 5, 6, 7],
                [0, 1, 5, 4],
                [1, 2, 6, 5],
                [2, 3, 7, 6],
                [3, 0, 4, 7],
            ]
            .map(|face| Face::Quad4(face.map(|i| n[i])))
            .to_vec(),
            Self::Wedge6(n) => {
                let triangles = [[0, 2, 1], [3, 4, 5]].map(|face| Face::Tri3(face.map(|i| n[i])));
                let quads = [[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]].map(|face| Face::Quad4(face.map(|i| n[i])));
                triangles.into_iter().chain(quads).collect()
            }
            Self::Tet4(n) => [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
                .map(|face| Face::Tri3(face.map(|i| n[i])))
                .to_vec(),
            Self::Tet10(n) => [
                [0, 2, 1, 6, 5, 4],
                [0, 1, 3, 4, 8, 7],
                [1, 2, 3, 5, 9, 8],
                [2, 0, 3, 6, 7, 9],
            ]
            .map(|face| Face::Tri6(face.map(|i| n[i])))
            .to_vec(),
        }
    }
}

/// Nodes of an element's face, counter-clockwise seen from outside: the corners, then the middles of the edges between
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Triangle.
    Tri3([u32; 3]),
    /// Bilinear quadrilateral.
    Quad4([u32; 4]),
    /// Quadratic triangle; nodes 3-5 lie between corners 01, 12, 20.
    Tri6([u32; 6]),
}

impl Face {
    /// All nodes.
    pub fn nodes(&self) -> &[u32] {
        match self {
            Self::Tri3(nodes) => nodes,
            Self::Quad4(nodes) => nodes,
            Self::Tri6(nodes) => nodes,
        }
    }
}

/// A solid element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    /// Shape and nodes.
    pub cell: Cell,
    /// Index into [`Mesh::materials`].
    pub material: u16,
}

/// A solid mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Node coordinates (m).
    pub nodes: Vec<[f64; 3]>,
    /// Elements.
    pub elements: Vec<Element>,
    /// Materials the elements refer to.
    pub materials: Vec<Material>,
}

impl Mesh {
    /// Gives all hexahedra one formulation.
    pub fn set_formulation(&mut self, formulation: Formulation) {
        for element in &mut self.elements {
            if let Cell::Hex8(_, old) = &mut element.cell {
                *old = formulation;
            }
        }
    }
}

/// Slave nodes glued to the faces they lie on: `u_slave = sum_i N_i u_master,i` at the projection of the slave, so that
/// rigid motion of the pair costs no energy.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Name used in messages.
    pub name: String,
    /// Nodes that follow.
    pub slave_nodes: Vec<u32>,
    /// Faces of the master surface.
    pub master_faces: Vec<Face>,
    /// How far slaves may be from the nearest master face (m).
    pub position_tolerance: f64,
    /// What becomes of slaves that are farther.
    pub beyond: BeyondTolerance,
    /// Whether a slave is moved onto its face without strain. One that is not keeps its distance, as if a rigid arm
    /// stood on the face.
    pub adjust: bool,
}

/// What becomes of slaves beyond a tie's tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeyondTolerance {
    /// They are an error.
    Refuse,
    /// They stay free and are listed in [`DofMap::untied`](crate::constraints::DofMap::untied), as in Abaqus.
    LeaveFree,
}

/// A reference point that moves with a cloud of nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupling {
    /// Name used in messages.
    pub name: String,
    /// Position of the reference point (m).
    pub reference: [f64; 3],
    /// Nodes of the cloud.
    pub nodes: Vec<u32>,
    /// Who follows whom.
    pub kind: CouplingKind,
}

/// Who follows whom in a coupling.
#[derive(Clone, Debug, PartialEq)]
pub enum CouplingKind {
    /// The six motions of the reference point are the weighted mean motion of the cloud; one positive weight per node, of
    /// any scale.
    Distributing(Vec<f64>),
    /// The displacement components of the cloud that are `true` follow the reference point rigidly; its six motions become
    /// unknowns.
    Kinematic([bool; 3]),
}

/// A spring from a displacement component to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundSpring {
    /// Node.
    pub node: u32,
    /// Displacement component 0..3.
    pub component: u8,
    /// Stiffness (N/m).
    pub stiffness: f64,
}

/// A named list of nodes or faces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group<T> {
    /// Name.
    pub name: String,
    /// Members.
    pub members: Vec<T>,
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
    /// Couplings.
    pub couplings: Vec<Coupling>,
    /// Equations.
    pub equations: Vec<Equation>,
    /// Components that do not move.
    pub supports: Vec<Dof>,
    /// Springs to the ground.
    pub springs: Vec<GroundSpring>,
    /// Load patterns.
    pub loads: Vec<LoadPattern>,
}

impl Assembly {
    /// Turns all quantities from units of `length` (m), `mass` (kg) and seconds into SI.
    pub fn convert_units(&mut self, length: f64, mass: f64) {
        let scale = |x: &mut [f64; 3]| x.iter_mut().for_each(|x| *x *= length);
        self.mesh.nodes.iter_mut().for_each(scale);
        for material in &mut self.mesh.materials {
            material.youngs_modulus *= mass / length;
            material.density *= mass / length.powi(3);
        }
        for tie in &mut self.ties {
            tie.position_tolerance *= length;
        }
        for coupling in &mut self.couplings {
            scale(&mut coupling.reference);
        }
        // Rotations have no unit; in an equation they are multiplied by lengths, in a load by moments.
        let arm = |dof: &Dof| {
            if matches!(dof, Dof::Reference(_, 3..)) {
                length
            } else {
                1.0
            }
        };
        for (dof, coefficient) in self.equations.iter_mut().flat_map(|equation| &mut equation.terms) {
            *coefficient *= arm(dof);
        }
        for (dof, value) in self.loads.iter_mut().flat_map(|load| &mut load.terms) {
            *value *= mass * length * arm(dof);
        }
        for spring in &mut self.springs {
            spring.stiffness *= mass;
        }
    }
}
