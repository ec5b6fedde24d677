//! Solid meshes and the assemblies made of them: materials, ties, couplings, shanks, equations, supports, masses, superelements and loads.

use crate::Error;
use crate::elements::{Formulation, Sides};

pub use crate::elements::{Cell, Face};
pub use crate::material::Material;
pub use crate::shank::{RigidMass, Section, Shank};
pub use crate::superelement::Superelement;

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
    /// Gives one formulation to all elements whose type has it; the others stay as they are.
    pub fn set_formulation(&mut self, formulation: Formulation) {
        for element in &mut self.elements {
            element.cell.set_formulation(formulation);
        }
    }

    /// Faces that belong to one element only, outward, in the order of the elements.
    pub fn boundary(&self) -> Vec<Face> {
        let cells: Vec<Cell> = self.elements.iter().map(|element| element.cell).collect();
        let faces = Sides::of(&cells).boundary(&cells);
        faces.into_iter().map(|(face, _)| face).collect()
    }

    /// Checks references, coordinates and materials.
    ///
    /// # Errors
    /// The first defect found.
    pub fn validate(&self) -> Result<(), Error> {
        self.materials.iter().try_for_each(Material::validate)?;
        for (node, x) in self.nodes.iter().enumerate() {
            if let Some(&value) = x.iter().find(|v| !v.is_finite()) {
                return Err(Error::NotFinite {
                    place: format!("node {node}"),
                    value,
                });
            }
        }
        for (index, element) in self.elements.iter().enumerate() {
            let dangling = |what, index_of, count| Error::Dangling {
                place: format!("element {index}"),
                what,
                index: index_of,
                count,
            };
            if let Some(&node) = element
                .cell
                .nodes()
                .iter()
                .find(|&&node| node as usize >= self.nodes.len())
            {
                return Err(dangling("node", node as usize, self.nodes.len()));
            }
            if element.material as usize >= self.materials.len() {
                return Err(dangling("material", element.material as usize, self.materials.len()));
            }
        }
        Ok(())
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

/// A mass at a node, in all three directions and without inertia of rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMass {
    /// Node.
    pub node: u32,
    /// Mass (kg).
    pub mass: f64,
}

/// A cut through a bolt of solid elements, at which its two parts overlap: `u_second = u_first - overlap normal`. The overlap is
/// an unknown, and a unit load on it is unit tension.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// Name used in messages.
    pub name: String,
    /// Unit vector from the first part into the second.
    pub normal: [f64; 3],
    /// Nodes of the first and the second part at the same place.
    pub pairs: Vec<[u32; 2]>,
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
    /// Overlap at the cut through a bolt (m), which its tension does work on: first those of the shanks, then those of the cuts
    /// through solids.
    Pretension(u32),
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
    /// Shanks between reference points of couplings.
    pub shanks: Vec<Shank>,
    /// Cuts through bolts of solid elements.
    pub cuts: Vec<Cut>,
    /// Rigid bodies at reference points of couplings.
    pub rigid_masses: Vec<RigidMass>,
    /// Equations.
    pub equations: Vec<Equation>,
    /// Components that do not move.
    pub supports: Vec<Dof>,
    /// Springs to the ground.
    pub springs: Vec<GroundSpring>,
    /// Masses at nodes, beside those of the elements.
    pub masses: Vec<PointMass>,
    /// Bodies by their matrices.
    pub superelements: Vec<Superelement>,
    /// Load patterns.
    pub loads: Vec<LoadPattern>,
}

impl Assembly {
    /// Number of overlaps ([`Dof::Pretension`]).
    pub fn n_pretensions(&self) -> usize {
        self.shanks.len() + self.cuts.len()
    }

    /// Inner coordinates of all superelements.
    pub fn n_inner(&self) -> usize {
        self.superelements.iter().map(Superelement::n_inner).sum()
    }

    /// Adds a shank and returns its overlap. Overlaps of cuts count after those of shanks: what refers to them in supports, equations and
    /// loads is numbered anew.
    pub fn add_shank(&mut self, shank: Shank) -> Dof {
        let index = self.shanks.len() as u32;
        let equations = self.equations.iter_mut().flat_map(|equation| &mut equation.terms);
        let loads = self.loads.iter_mut().flat_map(|load| &mut load.terms);
        let terms = equations.chain(loads).map(|(dof, _)| dof);
        for dof in self.supports.iter_mut().chain(terms) {
            if let Dof::Pretension(of_cut) = dof
                && *of_cut >= index
            {
                *of_cut += 1;
            }
        }
        self.shanks.push(shank);
        Dof::Pretension(index)
    }

    /// Factors of stiffness and mass, if the matrices of this assembly are those of `known` times them and all else is the same: constraints, loads
    /// and positions. Nothing is assembled for it.
    pub fn multiple_of(&self, known: &Self) -> Option<[f64; 2]> {
        // With the numbers of the other one where a factor may be between them: nothing else may differ.
        let mut same = self.clone();
        let (mut stiffness, mut mass) = (Factor::default(), Factor::default());
        for (own, known) in same.mesh.materials.iter_mut().zip(&known.mesh.materials) {
            stiffness.take(&mut own.youngs_modulus, known.youngs_modulus);
            mass.take(&mut own.density, known.density);
        }
        for (own, known) in same.shanks.iter_mut().zip(&known.shanks) {
            stiffness.take(&mut own.axial, known.axial);
            stiffness.take_all(&mut own.bending, known.bending);
            stiffness.take_all(&mut own.shear, known.shear);
            stiffness.take(&mut own.torsion, known.torsion);
            mass.take(&mut own.mass, known.mass);
            mass.take_all(&mut own.inertia, known.inertia);
        }
        if !(self.springs.is_empty() && self.superelements.is_empty()) {
            stiffness.stays();
        }
        if !(self.rigid_masses.is_empty() && self.masses.is_empty() && self.superelements.is_empty()) {
            mass.stays();
        }
        let factors = stiffness.found().zip(mass.found());
        factors.filter(|_| same == *known).map(Into::into)
    }

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
        for point in &mut self.masses {
            point.mass *= mass;
        }
        for body in &mut self.superelements {
            let matrices = [&mut body.stiffness, &mut body.mass].into_iter();
            matrices
                .flat_map(|matrix| matrix.data_mut())
                .for_each(|value| *value *= mass);
        }
        for shank in &mut self.shanks {
            shank.convert_units(length, mass);
        }
        for body in &mut self.rigid_masses {
            body.mass *= mass;
            let inertia = body.inertia.iter_mut().flatten();
            inertia.for_each(|entry| *entry *= mass * length * length);
        }
    }
}

/// The one factor between pairs of numbers, so far.
#[derive(Default)]
struct Factor {
    of: Option<f64>,
    fails: bool,
}

impl Factor {
    /// Difference of factors, relative to them, that is round-off of what the numbers were made from.
    const SAME: f64 = 1e-12;

    /// Replaces `own` by `known`, and keeps the factor that is between them.
    fn take(&mut self, own: &mut f64, known: f64) {
        let factor = *own / known;
        match self.of {
            // Of nothing in both any factor is true.
            _ if *own == 0.0 && known == 0.0 => {}
            None => self.of = Some(factor),
            // Also catches NaN.
            Some(of) => self.fails |= !((factor - of).abs() <= Self::SAME * of),
        }
        *own = known;
    }

    fn take_all<const N: usize>(&mut self, own: &mut [f64; N], known: [f64; N]) {
        own.iter_mut().zip(known).for_each(|(own, known)| self.take(own, known));
    }

    /// Notes that some numbers are the same in both.
    fn stays(&mut self) {
        self.take(&mut 1.0, 1.0);
    }

    fn found(self) -> Option<f64> {
        let factor = self.of.unwrap_or(1.0);
        (!self.fails && factor.is_finite() && factor > 0.0).then_some(factor)
    }
}
