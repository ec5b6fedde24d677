//! Measured and computed figures of the beam, as facts with their sources. SI units: Hz, m, N, Pa.
//!
//! Sources:
//! - **Paper**: "Traction-based multi-scale nonlinear dynamic modeling of bolted joints: Formulation, application,
//!   and trends in micro-scale interface evolution", Mechanical Systems and Signal Processing (2020),
//!   DOI 10.1016/j.ymssp.2020.106615.
//! - **Surface**: Porter and Brake, Mechanical Systems and Signal Processing (2023), DOI 10.1016/j.ymssp.2023.110210;
//!   measured data and backbones in the examples of `tmd-lab/tmdsimpy` (MIT licence).
//! - **Tutorial**: `Nidish96/Abaqus4Joints`, a public Abaqus model of the beam.
//! - **Independent finite elements**: CalculiX on the tutorial's public mesh (40 657 nodes, 31 904 elements) with the
//!   paper's material; all ties closed.
use finite_elements::mesh::Material;

/// Steel of the beam and its hardware (paper, section 4.1).
pub fn steel() -> Material {
    Material {
        name: "steel".to_owned(),
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
        density: 7857.8,
    }
}

/// Tension of each bolt in the paper's simulations (N).
pub const BOLT_TENSION: f64 = 12_845.0;

/// Bolt tension per bolt strain (paper, eq. 46) (N).
///
/// The paper's 2050 microstrain give 12 850 N by this figure, not quite [`BOLT_TENSION`].
pub const BOLT_TENSION_PER_STRAIN: f64 = 6_268_300.0;

/// Tension of a bolt (N) at a strain (-) of its gauge (paper, eq. 46).
pub fn bolt_tension(strain: f64) -> f64 {
    BOLT_TENSION_PER_STRAIN * strain
}

/// Tension that a torque of 20 N m gives (paper, section 3.3) (N), and the bolt strain stated for it (-).
pub const TORQUE_BOLT_TENSION: (f64, f64) = (11_580.0, 1847e-6);

/// Mean bolt strain of the experiment (paper, section 3.3) (-).
pub const BOLT_STRAIN: f64 = 2050e-6;

/// Pendulum stiffness (N/m) of one of two cords that carry a mass (kg) at a length (m) in a gravity (m/s^2) (paper,
/// eq. 48).
pub fn pendulum_stiffness(mass: f64, length: f64, gravity: f64) -> f64 {
    0.5 * mass * gravity / length
}

/// The figure that the paper gives for [`pendulum_stiffness`] (N/m), of [`PAPER_MASS`] at [`CORD_LENGTH`].
pub const PENDULUM_STIFFNESS: f64 = 30.0;

/// Length of the bungee cords (paper, appendix A) (m).
pub const CORD_LENGTH: f64 = 0.6096;

/// What the paper needs to judge adhesion (section 3.2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdhesionFigures {
    /// Hardness coefficient `K` of eq. (45) (-).
    pub hardness_coefficient: f64,
    /// Composite modulus `E*` (Pa).
    pub composite_modulus: f64,
    /// Hardness (Pa).
    pub hardness: f64,
    /// Intermolecular distance (m).
    pub intermolecular_distance: f64,
    /// Work of adhesion of low-carbon steel on itself (J/m^2).
    pub work_of_adhesion: f64,
    /// What the intermolecular distance over the critical interference stays below in all elements (-).
    pub relative_distance_bound: f64,
    /// What the adhesive traction over the elastic one stays below at working interferences (-).
    pub traction_ratio_bound: f64,
}

/// Paper, section 3.2.1.
pub const ADHESION: AdhesionFigures = AdhesionFigures {
    hardness_coefficient: 0.5729,
    composite_modulus: 105.28e9,
    hardness: 9.47e9,
    intermolecular_distance: 0.4e-9,
    work_of_adhesion: 2.5,
    relative_distance_bound: 1e-3,
    traction_ratio_bound: 0.1,
};

/// Elements of the paper's interface, as the p of its Table 2 imply.
pub const INTERFACE_ELEMENTS: usize = 588;

/// Fields of a run that the paper correlates with changes of the surface (Table 2): pressure under prestress, and
/// dissipated flux at its points 1 and 2, with topography and flat.
pub const EVOLUTION_FIELDS: [&str; 6] = ["T_n", "D_1", "D_2", "T_n flat", "D_1 flat", "D_2 flat"];

/// Changes of the surface that it correlates them with: total roughness, radii along x and y, number of asperities.
pub const EVOLUTION_CHANGES: [&str; 4] = ["dR_t", "dbeta_x", "dbeta_y", "dN"];

/// Spearman's rho of [`EVOLUTION_FIELDS`] (rows) with [`EVOLUTION_CHANGES`] (columns) (paper, Table 2a).
pub const EVOLUTION_RHO: [[f64; 4]; 6] = [
    [0.0822, -0.0578, 0.0393, -0.1534],
    [-0.067, 0.0615, -0.0253, 0.0533],
    [-0.0829, 0.0507, -0.0361, 0.0322],
    [0.1528, -0.0462, 0.0345, -0.0408],
    [-0.0365, -0.081, -0.0411, 0.0156],
    [-0.0862, 0.0036, -0.0261, 0.0502],
];

/// The p of [`EVOLUTION_RHO`] (paper, Table 2b).
pub const EVOLUTION_P: [[f64; 4]; 6] = [
    [0.0463, 0.1616, 0.3411, 0.0002],
    [0.1046, 0.1364, 0.5395, 0.1969],
    [0.0445, 0.2197, 0.3819, 0.435],
    [0.0002, 0.2632, 0.4041, 0.3236],
    [0.3767, 0.0497, 0.3202, 0.7051],
    [0.0368, 0.9315, 0.5282, 0.2244],
];

/// Mass of the assembled beam as the paper states it (kg).
pub const PAPER_MASS: f64 = 3.68;

/// Measured damping ratio of the first mode at low amplitude, roughly (paper) (-).
pub const LOW_AMPLITUDE_DAMPING: f64 = 0.001;

/// First bending frequency at low amplitude (paper, Table 1) (Hz).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstFrequency {
    /// Computed with the measured topography, parameters per element.
    pub topography_per_element: f64,
    /// Computed with a flat interface, parameters per element.
    pub flat_per_element: f64,
    /// Computed with a flat interface and uniform parameters.
    pub flat_uniform: f64,
    /// Measured.
    pub measured: f64,
}

/// Paper, Table 1.
pub const FIRST_FREQUENCY: FirstFrequency = FirstFrequency {
    topography_per_element: 174.21,
    flat_per_element: 168.91,
    flat_uniform: 172.76,
    measured: 180.92,
};

/// Linearised frequencies of the free beam (paper, Table 3) (Hz). Suspended by bungees they are the same to these
/// digits.
pub const LINEARISED_FREQUENCIES: [f64; 10] = [
    167.42, 227.31, 585.22, 666.1, 1194.7, 1272.5, 1608.0, 1685.1, 2030.8, 2862.6,
];

/// A row of the paper's Table 4: first frequency and contact area against bolt strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoltStrainRow {
    /// Bolt strain (-).
    pub bolt_strain: f64,
    /// First frequency with the measured topography (Hz).
    pub topography_frequency: f64,
    /// Area of the elements in contact over the whole area, with the measured topography (-).
    pub topography_contact: f64,
    /// First frequency with a flat interface (Hz).
    pub flat_frequency: f64,
    /// Area of the elements in contact over the whole area, with a flat interface (-).
    pub flat_contact: f64,
}

/// Paper, Table 4. Its flat frequency at 2050 microstrain differs from Table 1 by 0.07 Hz.
pub const BOLT_STRAIN_TABLE: [BoltStrainRow; 9] = [
    BoltStrainRow {
        bolt_strain: 1050e-6,
        topography_frequency: 172.62,
        topography_contact: 0.6216,
        flat_frequency: 165.34,
        flat_contact: 0.867904,
    },
    BoltStrainRow {
        bolt_strain: 1250e-6,
        topography_frequency: 170.13,
        topography_contact: 0.6741,
        flat_frequency: 167.17,
        flat_contact: 0.867904,
    },
    BoltStrainRow {
        bolt_strain: 1550e-6,
        topography_frequency: 173.39,
        topography_contact: 0.7227,
        flat_frequency: 166.46,
        flat_contact: 0.878913,
    },
    BoltStrainRow {
        bolt_strain: 1750e-6,
        topography_frequency: 174.36,
        topography_contact: 0.7435,
        flat_frequency: 167.72,
        flat_contact: 0.885517,
    },
    BoltStrainRow {
        bolt_strain: 2050e-6,
        topography_frequency: 174.21,
        topography_contact: 0.7759,
        flat_frequency: 168.98,
        flat_contact: 0.898727,
    },
    BoltStrainRow {
        bolt_strain: 2250e-6,
        topography_frequency: 174.07,
        topography_contact: 0.7945,
        flat_frequency: 168.57,
        flat_contact: 0.90313,
    },
    BoltStrainRow {
        bolt_strain: 2500e-6,
        topography_frequency: 173.33,
        topography_contact: 0.8105,
        flat_frequency: 168.77,
        flat_contact: 0.911936,
    },
    BoltStrainRow {
        bolt_strain: 2750e-6,
        topography_frequency: 173.44,
        topography_contact: 0.8172,
        flat_frequency: 169.1,
        flat_contact: 0.911936,
    },
    BoltStrainRow {
        bolt_strain: 3000e-6,
        topography_frequency: 172.54,
        topography_contact: 0.8247,
        flat_frequency: 170.12,
        flat_contact: 0.911936,
    },
];

/// Frequencies of the tutorial's Abaqus model: reduced-integration bricks (C3D8R), E = 200 GPa, nu = 0.29,
/// 7800 kg/m^3, 12 kN per bolt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TutorialFrequencies {
    /// Without contact and bolt load: the first flexible modes (Hz).
    pub unstressed: [f64; 3],
    /// Hard frictionless contact under the bolt load (Hz).
    pub frictionless_contact: [f64; 4],
    /// Bonded by a penalty stiffness of 5e6 N/m per element (Hz).
    pub bonded: [f64; 10],
}

/// Tutorial.
pub const TUTORIAL_FREQUENCIES: TutorialFrequencies = TutorialFrequencies {
    unstressed: [70.323, 151.26, 609.25],
    frictionless_contact: [141.1, 152.42, 570.33, 643.49],
    bonded: [
        143.74, 151.3, 575.08, 642.81, 870.59, 945.37, 1130.3, 1476.4, 1701.3, 1893.6,
    ],
};

/// Independent finite elements: free half-beam, incompatible modes (C3D8I) (Hz).
pub const HALF_BEAM_FREQUENCIES: [f64; 7] = [633.77, 787.63, 1453.35, 1920.5, 3065.1, 3618.0, 3766.5];

/// Independent finite elements: the ten lowest flexible modes with a stuck interface, incompatible modes (C3D8I)
/// (Hz).
pub const STUCK_FREQUENCIES: [f64; 10] = [
    201.43, 233.66, 624.97, 665.12, 1238.4, 1280.3, 1825.4, 1899.3, 2055.3, 3032.9,
];

/// As [`STUCK_FREQUENCIES`], with reduced integration and hourglass control (C3D8R) (Hz).
pub const STUCK_FREQUENCIES_REDUCED_INTEGRATION: [f64; 10] = [
    197.58, 232.16, 618.09, 661.45, 1228.74, 1274.12, 1797.16, 1861.96, 2041.73, 3007.11,
];

/// Independent finite elements: springs on the part of the interface that touches under hard contact (Hz).
pub const HARD_CONTACT_FREQUENCIES: [f64; 10] = [
    167.08, 223.64, 579.85, 654.47, 1175.7, 1250.3, 1596.7, 1670.8, 1997.4, 2815.9,
];

/// Fraction of the interface that touches under hard contact (independent finite elements) (-).
pub const HARD_CONTACT_AREA: f64 = 0.758;

/// Mass of the independent finite element model (kg).
pub const MODEL_MASS: f64 = 3.7011;

/// Mass of one half-beam of the independent finite element model (kg).
pub const HALF_BEAM_MASS: f64 = 1.8082;

/// A point of a published backbone of the first bending mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackbonePoint {
    /// Modal amplitude with mass-normalised mode (kg^1/2 m).
    pub modal_amplitude: f64,
    /// Frequency (Hz).
    pub frequency: f64,
    /// Damping ratio, viscous background included (-).
    pub damping_ratio: f64,
    /// Displacement amplitude of the source's response point (m).
    pub displacement_amplitude: f64,
}

/// Viscous damping ratio that the published backbones include in the first mode (-).
pub const BACKBONE_VISCOUS_DAMPING: f64 = 0.00087;

/// Backbone by the extended periodic motion concept, rough contact with plasticity, friction coefficient 0.03, flat
/// interface (surface source).
pub const BACKBONE_FLAT: [BackbonePoint; 23] = [
    backbone_point(1e-07, 168.50232640285543, 0.0008727689736895, 9.734289991825e-08),
    backbone_point(
        1.139117517188e-07,
        168.50219746506983,
        0.0008732870859046,
        1.108849756219e-07,
    ),
    backbone_point(
        1.297588734799e-07,
        168.50208273281783,
        0.0008735542566158,
        1.263109894751e-07,
    ),
    backbone_point(
        1.79704268928e-07,
        168.5010644881398,
        0.0008812800046608,
        1.749289572034e-07,
    ),
    backbone_point(
        2.488741398295e-07,
        168.49832599052138,
        0.0008932501125568,
        2.422598626711e-07,
    ),
    backbone_point(
        3.446682759862e-07,
        168.49444200480283,
        0.0009059929278331,
        3.355066083952e-07,
    ),
    backbone_point(
        4.773345669485e-07,
        168.48824639428096,
        0.0009287933461828,
        4.646458264993e-07,
    ),
    backbone_point(
        6.610650599266e-07,
        168.47958103470006,
        0.0009554487935893,
        6.434897083202e-07,
    ),
    backbone_point(
        9.155226769916e-07,
        168.46350318293204,
        0.001027003457761,
        8.911704910326e-07,
    ),
    backbone_point(
        1.267921561682e-06,
        168.43178765247134,
        0.001147980404492,
        1.234170582254e-06,
    ),
    backbone_point(
        1.755970750827e-06,
        168.38091273563023,
        0.001327735962943,
        1.709168987128e-06,
    ),
    backbone_point(
        2.431874594338e-06,
        168.29292006487958,
        0.001635971466463,
        2.366921993254e-06,
    ),
    backbone_point(
        3.367943667119e-06,
        168.15255894438354,
        0.002113747709562,
        3.277674526475e-06,
    ),
    backbone_point(
        4.66404702102e-06,
        167.92473821460746,
        0.002881696426072,
        4.538327608325e-06,
    ),
    backbone_point(
        6.458187557759e-06,
        167.53936279726412,
        0.004260809958107,
        6.28242390197e-06,
    ),
    backbone_point(
        8.94111706518e-06,
        166.91833843506024,
        0.006150950790678,
        8.69404065829e-06,
    ),
    backbone_point(
        1.237641470511e-05,
        166.1464883076323,
        0.007900038193436,
        1.202787312011e-05,
    ),
    backbone_point(
        1.712294586826e-05,
        165.18621083561413,
        0.009863038501688,
        1.662928799377e-05,
    ),
    backbone_point(
        2.365419425541e-05,
        164.03429331127666,
        0.01219734288679,
        2.295289481603e-05,
    ),
    backbone_point(
        3.252804720569e-05,
        162.621837649837,
        0.01525278866711,
        3.153035464416e-05,
    ),
    backbone_point(
        4.363704143422e-05,
        160.7781810060065,
        0.02073831367593,
        4.223843202779e-05,
    ),
    backbone_point(
        5.638837185921e-05,
        158.66745496207685,
        0.02630725269762,
        5.448957296022e-05,
    ),
    backbone_point(
        6.986102386213e-05,
        156.67389218867163,
        0.03063040217434,
        6.739969435255e-05,
    ),
];

/// Backbone by the extended periodic motion concept, rough contact with plasticity, friction coefficient 0.03,
/// measured topography (surface source).
pub const BACKBONE_TOPOGRAPHY: [BackbonePoint; 22] = [
    backbone_point(1e-07, 180.62742780181412, 0.0008779562039979, 9.838957954002e-08),
    backbone_point(
        1.139120173676e-07,
        180.62702489136723,
        0.0008797140401396,
        1.120774819748e-07,
    ),
    backbone_point(
        1.297584271287e-07,
        180.62638118235623,
        0.00088223469301,
        1.276685378902e-07,
    ),
    backbone_point(
        1.831468666955e-07,
        180.6247518430165,
        0.000884689668569,
        1.801965504705e-07,
    ),
    backbone_point(
        3.512731334532e-07,
        180.62224377645,
        0.0008890647985611,
        3.456136939089e-07,
    ),
    backbone_point(
        6.737099871579e-07,
        180.60684155158015,
        0.0009564389105676,
        6.628771707511e-07,
    ),
    backbone_point(
        1.292366140926e-06,
        180.57339887756578,
        0.001074547211145,
        1.2715866434e-06,
    ),
    backbone_point(
        2.476722761926e-06,
        180.4468677236793,
        0.001538052284778,
        2.436863319912e-06,
    ),
    backbone_point(
        4.731423826712e-06,
        180.03155272667954,
        0.003078124796678,
        4.654695005924e-06,
    ),
    backbone_point(
        8.999039557189e-06,
        178.60338804725393,
        0.008386452963274,
        8.84965687582e-06,
    ),
    backbone_point(
        1.403360582272e-05,
        176.23319933533054,
        0.01611454625048,
        1.378110907058e-05,
    ),
    backbone_point(
        1.834842185081e-05,
        174.22215729069092,
        0.02104501215886,
        1.798557277669e-05,
    ),
    backbone_point(
        2.343649383948e-05,
        172.2149043236984,
        0.02456079742182,
        2.292752575288e-05,
    ),
    backbone_point(
        3.121103201887e-05,
        169.768269568802,
        0.02798795721181,
        3.046053842426e-05,
    ),
    backbone_point(
        3.400638593612e-05,
        168.9853969181451,
        0.02924151353427,
        3.316388291487e-05,
    ),
    backbone_point(
        3.838418782175e-05,
        167.8186443317423,
        0.03113625322953,
        3.739250280915e-05,
    ),
    backbone_point(
        4.428798880212e-05,
        166.38042519030236,
        0.03330270955559,
        4.308711763366e-05,
    ),
    backbone_point(
        4.813998374932e-05,
        165.51703123345035,
        0.03454347985576,
        4.679816040502e-05,
    ),
    backbone_point(
        5.126247123756e-05,
        164.85591001580087,
        0.03545773203813,
        4.980426438155e-05,
    ),
    backbone_point(
        5.524488511047e-05,
        164.0584761395033,
        0.03655423995987,
        5.363553069025e-05,
    ),
    backbone_point(
        5.983365659963e-05,
        163.19060197991598,
        0.03776980082351,
        5.804618124059e-05,
    ),
    backbone_point(
        6.612842430906e-05,
        162.0733924062975,
        0.03939926377489,
        6.408999343544e-05,
    ),
];

const fn backbone_point(
    modal_amplitude: f64,
    frequency: f64,
    damping_ratio: f64,
    displacement_amplitude: f64,
) -> BackbonePoint {
    BackbonePoint {
        modal_amplitude,
        frequency,
        damping_ratio,
        displacement_amplitude,
    }
}

/// What the surface source assumes about material and load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourceModel {
    /// Young's modulus (Pa).
    pub youngs_modulus: f64,
    /// Poisson ratio (-).
    pub poisson_ratio: f64,
    /// Friction coefficient (-).
    pub friction_coefficient: f64,
    /// Yield strength beyond which its asperities are plastic (Pa).
    pub yield_strength: f64,
    /// Tangent modulus of the hardening material (Pa).
    pub tangent_modulus: f64,
    /// Tension of each bolt (N).
    pub bolt_tension: f64,
}

/// Surface source.
pub const SURFACE_SOURCE_MODEL: SourceModel = SourceModel {
    youngs_modulus: 192.31e9,
    poisson_ratio: 0.3,
    friction_coefficient: 0.03,
    yield_strength: 331.7e6,
    tangent_modulus: 620e6,
    bolt_tension: 12_249.0,
};

/// Effective radius of the asperity pairs of a real interface (surface source) (m).
pub const EFFECTIVE_RADIUS: f64 = 0.0013649327743177684;

/// Asperity pairs per area of a real interface (surface source) (1/m^2). Counts all pairs of the distribution
/// [`ASPERITY_GAP_QUANTILES`].
pub const ASPERITIES_PER_AREA: f64 = 1371333.5027107028;

/// Greatest initial gap of an asperity pair (surface source) (m); the distribution is normalised from 0 to here.
pub const ASPERITY_GAP_MAX: f64 = 2.8047835136056204e-05;

/// Distribution of the initial gaps of the asperity pairs (surface source) (m): value `i` is the gap at the
/// probability
/// `i / 200`. A gap of 0 is the first pair to touch, at zero interference.
pub const ASPERITY_GAP_QUANTILES: [f64; 201] = [
    0.0,
    2.813837e-06,
    4.632132e-06,
    5.958576e-06,
    6.768679e-06,
    7.302775e-06,
    7.700328e-06,
    8.01984e-06,
    8.288732e-06,
    8.522042e-06,
    8.728642e-06,
    8.914274e-06,
    9.082978e-06,
    9.237748e-06,
    9.380885e-06,
    9.514166e-06,
    9.638917e-06,
    9.756323e-06,
    9.867278e-06,
    9.97256e-06,
    1.007286e-05,
    1.016863e-05,
    1.026042e-05,
    1.03486e-05,
    1.043348e-05,
    1.051537e-05,
    1.059455e-05,
    1.067125e-05,
    1.07457e-05,
    1.081801e-05,
    1.088843e-05,
    1.095703e-05,
    1.102399e-05,
    1.108936e-05,
    1.11533e-05,
    1.121591e-05,
    1.127725e-05,
    1.133739e-05,
    1.139642e-05,
    1.145441e-05,
    1.151141e-05,
    1.156748e-05,
    1.162267e-05,
    1.167703e-05,
    1.17306e-05,
    1.178343e-05,
    1.183554e-05,
    1.188695e-05,
    1.193772e-05,
    1.198787e-05,
    1.203745e-05,
    1.208646e-05,
    1.21349e-05,
    1.218285e-05,
    1.223032e-05,
    1.227729e-05,
    1.232382e-05,
    1.236992e-05,
    1.241557e-05,
    1.246083e-05,
    1.250571e-05,
    1.255019e-05,
    1.259434e-05,
    1.263812e-05,
    1.268157e-05,
    1.272469e-05,
    1.27675e-05,
    1.281001e-05,
    1.285222e-05,
    1.289415e-05,
    1.293581e-05,
    1.297719e-05,
    1.301834e-05,
    1.305922e-05,
    1.309989e-05,
    1.31403e-05,
    1.318052e-05,
    1.32205e-05,
    1.326029e-05,
    1.329988e-05,
    1.333928e-05,
    1.337851e-05,
    1.341754e-05,
    1.345642e-05,
    1.349513e-05,
    1.353369e-05,
    1.357211e-05,
    1.361038e-05,
    1.364852e-05,
    1.368654e-05,
    1.372443e-05,
    1.376221e-05,
    1.379988e-05,
    1.383745e-05,
    1.387493e-05,
    1.391232e-05,
    1.394963e-05,
    1.398687e-05,
    1.402404e-05,
    1.406115e-05,
    1.409821e-05,
    1.413523e-05,
    1.41722e-05,
    1.420913e-05,
    1.424604e-05,
    1.428293e-05,
    1.431981e-05,
    1.435668e-05,
    1.439356e-05,
    1.443043e-05,
    1.446733e-05,
    1.450424e-05,
    1.454118e-05,
    1.457815e-05,
    1.461517e-05,
    1.465224e-05,
    1.468937e-05,
    1.472655e-05,
    1.476382e-05,
    1.480116e-05,
    1.483858e-05,
    1.48761e-05,
    1.491372e-05,
    1.495145e-05,
    1.498931e-05,
    1.502729e-05,
    1.50654e-05,
    1.510367e-05,
    1.514207e-05,
    1.518065e-05,
    1.521941e-05,
    1.525833e-05,
    1.529746e-05,
    1.533678e-05,
    1.537632e-05,
    1.541608e-05,
    1.545607e-05,
    1.549632e-05,
    1.553681e-05,
    1.557759e-05,
    1.561864e-05,
    1.566e-05,
    1.570166e-05,
    1.574366e-05,
    1.578599e-05,
    1.582869e-05,
    1.587175e-05,
    1.591523e-05,
    1.595908e-05,
    1.600341e-05,
    1.604817e-05,
    1.609342e-05,
    1.613916e-05,
    1.618541e-05,
    1.623223e-05,
    1.627962e-05,
    1.63276e-05,
    1.637623e-05,
    1.642554e-05,
    1.647555e-05,
    1.652629e-05,
    1.657781e-05,
    1.663018e-05,
    1.668343e-05,
    1.67376e-05,
    1.679276e-05,
    1.684894e-05,
    1.690623e-05,
    1.696468e-05,
    1.702436e-05,
    1.708541e-05,
    1.714787e-05,
    1.721181e-05,
    1.727734e-05,
    1.734468e-05,
    1.741382e-05,
    1.748501e-05,
    1.755831e-05,
    1.763402e-05,
    1.771224e-05,
    1.779322e-05,
    1.787722e-05,
    1.796454e-05,
    1.805552e-05,
    1.815057e-05,
    1.825022e-05,
    1.8355e-05,
    1.846565e-05,
    1.858303e-05,
    1.87082e-05,
    1.884273e-05,
    1.898834e-05,
    1.914773e-05,
    1.932428e-05,
    1.952334e-05,
    1.975288e-05,
    2.002576e-05,
    2.03661e-05,
    2.082761e-05,
    2.158237e-05,
    2.804784e-05,
];

/// Half lengths that scale x and y in [`mesoscale_gap`] (m).
pub const MESOSCALE_GAP_EXTENT: [f64; 2] = [0.0625, 0.0127];

/// Legendre coefficients `c[i][j]` of the gap between the two real faces (surface source) (m), a least-squares fit
/// of the measured 0.5 mm grid (12 688 points, least value 0).
pub const MESOSCALE_GAP_COEFFICIENTS: [[f64; 7]; 13] = [
    [
        6.966289e-05,
        -1.365781e-06,
        -1.342607e-07,
        -1.381819e-06,
        1.359256e-07,
        4.531548e-07,
        -1.629511e-08,
    ],
    [
        -2.103297e-06,
        2.942025e-07,
        1.139122e-06,
        -3.152768e-07,
        -9.07483e-08,
        3.903461e-08,
        -1.5828e-08,
    ],
    [
        -6.570809e-05,
        1.418481e-06,
        2.955963e-07,
        4.539719e-07,
        -1.143942e-07,
        -1.576362e-07,
        -1.932471e-08,
    ],
    [
        -8.51287e-06,
        -2.235127e-06,
        -3.765939e-07,
        4.21755e-07,
        7.029211e-08,
        -1.25195e-07,
        5.239863e-09,
    ],
    [
        -1.051229e-06,
        -1.38338e-06,
        1.726603e-06,
        -2.149632e-07,
        -1.281434e-08,
        -8.086247e-08,
        -6.695059e-08,
    ],
    [
        1.308905e-06,
        -4.922936e-07,
        -5.85174e-08,
        1.204884e-07,
        1.658977e-08,
        -5.060441e-08,
        -1.05144e-08,
    ],
    [
        9.205314e-07,
        1.14023e-06,
        -2.250009e-06,
        4.478415e-07,
        -6.82888e-08,
        -8.415986e-08,
        9.884686e-08,
    ],
    [
        1.197707e-06,
        4.808135e-07,
        -4.950041e-07,
        3.926901e-07,
        1.027498e-07,
        -1.007378e-07,
        -2.423659e-08,
    ],
    [
        3.295191e-06,
        -5.400668e-07,
        2.171081e-07,
        -1.825572e-07,
        -4.00455e-08,
        4.15841e-08,
        3.142568e-09,
    ],
    [
        1.231935e-07,
        -8.458689e-07,
        -2.041605e-07,
        5.566046e-11,
        -6.66731e-08,
        -4.976873e-09,
        3.218249e-08,
    ],
    [
        3.774214e-07,
        8.836661e-07,
        -1.041849e-07,
        2.785554e-08,
        6.843115e-09,
        -2.593062e-08,
        -7.407264e-09,
    ],
    [
        -5.899967e-07,
        6.557567e-07,
        -3.513922e-07,
        1.680525e-07,
        3.523799e-08,
        -3.181455e-08,
        3.462714e-09,
    ],
    [
        -2.919083e-08,
        -2.986122e-07,
        -4.367453e-07,
        1.871476e-07,
        2.34873e-08,
        -6.768987e-08,
        1.276746e-08,
    ],
];

/// Root mean square difference between the fit and the measured grid (m).
pub const MESOSCALE_GAP_RMS_RESIDUAL: f64 = 1.1043062054835136e-07;

/// Greatest difference between the fit and the measured grid (m).
pub const MESOSCALE_GAP_MAX_RESIDUAL: f64 = 5.72088644091532e-07;

/// Gap between the unloaded faces at a point of the interface (m), never negative:
/// `max(0, sum_ij c[i][j] P_i(x / 0.0625) P_j(y / 0.0127))`, `x` along the beam and `y` across from the interface's
/// centre (m). Points outside of [`MESOSCALE_GAP_EXTENT`] get the value at its nearest edge.
pub fn mesoscale_gap(x: f64, y: f64) -> f64 {
    let [half_length, half_width] = MESOSCALE_GAP_EXTENT;
    let along = legendre::<13>((x / half_length).clamp(-1.0, 1.0));
    let across = legendre::<7>((y / half_width).clamp(-1.0, 1.0));
    let gap: f64 = (MESOSCALE_GAP_COEFFICIENTS.iter().zip(along))
        .map(|(row, p)| p * row.iter().zip(across).map(|(c, q)| c * q).sum::<f64>())
        .sum();
    // Not `max`, which would turn a NaN coordinate into a closed gap.
    if gap < 0.0 { 0.0 } else { gap }
}

/// Legendre polynomials of the degrees 0 to `N - 1` by Bonnet's recurrence, stable on [-1, 1].
fn legendre<const N: usize>(x: f64) -> [f64; N] {
    let mut values = [1.0; N];
    if N > 1 {
        values[1] = x;
    }
    for n in 2..N {
        let k = n as f64;
        values[n] = ((2.0 * k - 1.0) * x * values[n - 1] - (k - 1.0) * values[n - 2]) / k;
    }
    values
}
