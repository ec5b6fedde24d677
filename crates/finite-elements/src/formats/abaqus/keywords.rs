//! What each keyword is for.

/// When a block is read: a deck may name things before it defines them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Phase {
    /// Nodes and elements.
    Geometry,
    /// Node and element sets.
    Sets,
    /// Surfaces.
    Surfaces,
    /// Materials.
    Materials,
    /// Sections, springs and point masses.
    Properties,
    /// Ties, couplings, equations.
    Constraints,
    /// Supports, loads and steps.
    History,
}

/// What becomes of a keyword.
pub(super) enum Fate {
    /// It is read.
    Read(Phase),
    /// It only asks for output, or concerns what the model does not have.
    Ignored,
    /// It does not act, since something else stands in its place: what.
    Replaced(&'static str),
    /// It says which analysis a step runs.
    Procedure,
    /// It is refused, with a remedy.
    Refused(&'static str),
}

/// What is read of a deck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// All of it.
    Structure,
    /// Nodes, elements, sets and surfaces.
    Mesh,
}

impl Extent {
    /// Whether a keyword is only counted. What makes nodes and elements never is.
    pub(super) fn leaves_out(self, key: &str) -> bool {
        self == Self::Mesh
            && match fate(key) {
                Fate::Read(phase) => phase > Phase::Surfaces,
                Fate::Ignored | Fate::Replaced(_) | Fate::Procedure => true,
                Fate::Refused(_) => !(makes_mesh(key) || opens_scope(key)),
            }
    }
}

/// Whether nodes, elements or names come from a keyword that is not read.
fn makes_mesh(key: &str) -> bool {
    ["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "PARAMETER"].contains(&key)
}

/// Whether a keyword begins or ends a part, an instance or the assembly.
fn opens_scope(key: &str) -> bool {
    let name = key.strip_prefix("END").unwrap_or(key);
    ["PART", "INSTANCE", "ASSEMBLY"].contains(&name)
}

/// What becomes of a keyword (capitals, without blanks).
pub(super) fn fate(key: &str) -> Fate {
    use Fate::{Ignored, Procedure, Read, Refused, Replaced};
    match key {
        "SYSTEM" | "NODE" | "ELEMENT" => Read(Phase::Geometry),
        "NSET" | "ELSET" => Read(Phase::Sets),
        "SURFACE" => Read(Phase::Surfaces),
        "MATERIAL" | "ELASTIC" | "DENSITY" => Read(Phase::Materials),
        "SOLIDSECTION" | "BEAMSECTION" | "SPRING" | "MASS" | "ROTARYINERTIA" => Read(Phase::Properties),
        "TIE" | "COUPLING" | "DISTRIBUTING" | "KINEMATIC" | "DISTRIBUTINGCOUPLING" | "KINEMATICCOUPLING"
        | "EQUATION" | "MPC" | "RIGIDBODY" | "PRE-TENSIONSECTION" => Read(Phase::Constraints),
        "BOUNDARY" | "CLOAD" | "STEP" | "ENDSTEP" | "SUBSTRUCTURELOADCASE" | "LOADCASE" | "ENDLOADCASE" => {
            Read(Phase::History)
        }
        "HEADING" | "PREPRINT" | "RESTART" | "OUTPUT" | "NODEOUTPUT" | "ELEMENTOUTPUT" | "ENERGYOUTPUT"
        | "CONTACTOUTPUT" | "INCREMENTATIONOUTPUT" | "INTEGRATEDOUTPUT" | "INTEGRATEDOUTPUTSECTION" | "MODALOUTPUT"
        | "NODEFILE" | "ELFILE" | "ENERGYFILE" | "CONTACTFILE" | "MODALFILE" | "FILEFORMAT" | "FILEOUTPUT"
        | "NODEPRINT" | "ELPRINT" | "ENERGYPRINT" | "CONTACTPRINT" | "MODALPRINT" | "SECTIONPRINT" | "SECTIONFILE"
        | "FACEPRINT" | "PRINT" | "MONITOR" | "DIAGNOSTICS" | "TIMEPOINTS"
        // Without temperatures, gravity or a section that names an orientation these act on nothing.
        | "EXPANSION" | "CONDUCTIVITY" | "SPECIFICHEAT" | "PHYSICALCONSTANTS" | "ORIENTATION" => Ignored,
        "STATIC" | "FREQUENCY" | "BUCKLE" | "DYNAMIC" | "STEADYSTATEDYNAMICS" | "MODALDYNAMIC" | "MODALDAMPING"
        | "COMPLEXFREQUENCY" | "SELECTEIGENMODES" | "SUBSTRUCTUREGENERATE" | "RETAINEDNODALDOFS"
        | "SUBSTRUCTUREMATRIXOUTPUT" | "SUBSTRUCTUREOUTPUT" | "DAMPINGCONTROLS" | "MATRIXGENERATE" | "MATRIXOUTPUT"
        | "CONTROLS" | "SOLVERCONTROLS" => Procedure,
        "AMPLITUDE" | "DLOAD" | "DSLOAD" => {
            Replaced("steps are not run, and only the tension of the bolts and the loads of the scene act")
        }
        "CONTACTPAIR" | "CONTACT" | "CONTACTINCLUSIONS" | "CONTACTPROPERTYASSIGNMENT" | "SURFACEINTERACTION"
        | "SURFACEBEHAVIOR" | "FRICTION" | "CONTACTDAMPING" | "CONTACTCONTROLS" | "CLEARANCE" => {
            Replaced("faces touch where the scene says so, by its law, and nowhere else")
        }
        "GAP" => Refused("remove it, and give the joint analysis the names of the two surfaces"),
        "POINTMASS" | "NONSTRUCTURALMASS" => {
            Refused("model the mass by solid elements with a density, or by *MASS of elements of type MASS")
        }
        "TRANSFORM" => Refused("give supports, loads and equations in global axes"),
        "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" | "PARAMETER" => {
            Refused("let the preprocessor write all nodes and elements out")
        }
        "TEMPERATURE" | "INITIALCONDITIONS" => {
            Refused("only concentrated loads (*CLOAD) are read; remove it, or load a coupling's reference node")
        }
        "SHELLSECTION" | "BEAMGENERALSECTION" | "MEMBRANESECTION" | "COHESIVESECTION" => {
            Refused("only solids with *SOLID SECTION and beams with *BEAM SECTION (CIRC or RECT) are supported")
        }
        "NORMAL" | "TRANSVERSESHEARSTIFFNESS" => {
            Refused("the direction of a beam is that of its *BEAM SECTION, and its shear stiffness that of its section; remove it")
        }
        "DASHPOT" | "DAMPING" => Refused("the model is undamped; damping comes from the joint analysis"),
        "SECTIONCONTROLS" | "HOURGLASSSTIFFNESS" => {
            Refused("the element formulation is chosen by the element type alone; remove it")
        }
        "PLASTIC" | "HYPERELASTIC" | "VISCOELASTIC" | "CREEP" | "USERMATERIAL" => {
            Refused("materials are linear elastic: keep *ELASTIC and *DENSITY only")
        }
        _ => Refused("it may change the mechanics; remove it, or express it by supported keywords"),
    }
}
