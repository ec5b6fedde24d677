#![doc = include_str!("../README.md")]

mod accuracy;
mod analyses;
mod asked;
pub mod benchmark;
mod bolts;
mod check;
pub mod distribution;
mod epmc;
mod error;
mod excitation;
mod finish;
mod forced;
mod former;
mod interfaces;
mod json;
mod law;
mod material;
mod mesh;
pub mod metric;
mod parameter;
mod parameter_values;
mod random;
mod refinement;
mod ring_down;
mod scale;
mod scans;
mod scene;
#[cfg(feature = "schema")]
mod schema;
mod scoped;
mod shock;
mod structure;
mod surface;
mod tightening;
mod torque;
mod torque_report;
pub mod uncertain;
mod uncertain_values;
mod units;
mod upgrade;
mod validate;

pub use accuracy::{Accuracy, GivenSettings, Level, PRESETS, Preset, Target};
pub use analyses::{Analyses, Backbone, EPMC, InterfacePlace, Method, Modes, Output};
pub use benchmark::BenchmarkRef;
pub use bolts::{Assembly, BoltBehaviour, Bolts, ThreadSize};
pub use distribution::{Marginal, Shape};
pub use epmc::{AmplitudeRange, Amplitudes, Epmc, SamplingAccuracy};
pub use error::{Error, behind_semicolon, quantity};
pub use excitation::{BaseMotion, Driver, Excitation, PointForce};
pub use finish::{Finish, FinishFace, Lengths, PowerLaw, Route};
pub use forced::{Forced, ForcedBase, Held, PhasedForce, Rayleigh, RotatingUnbalance, Sweep, SweepRate};
pub use interfaces::{Interfaces, OwnInterface};
pub use json::{parse as parse_json, read as read_json, without_comments};
pub use law::{Bins, Friction, FrictionZone, Law, LawKind, RadialRule, Yield};
pub use material::Material;
pub use mesh::{
    BoltSeat, MeshBolt, MeshFile, MeshInterface, MeshResponse, MeshSuperelement, MeshSupport, MeshTie, Repeat,
};
pub use parameter::{Influence, Parameter};
pub use random::{Random, RandomInTime};
pub use refinement::refined;
pub use ring_down::{RingDown, Strike};
pub use scale::Scale;
pub use scans::{Noise, Place, Readings, Registration, ScanFile, Scans};
pub use scene::Scene;
#[cfg(feature = "schema")]
pub use schema::file_schema;
pub use shock::{Pulse, PulseShape, Record, Shock};
pub use structure::{
    ContactPoint, Coordinates, Deck, DeckBolt, DeckResponse, MaterialSource, Matrices, MatrixVector, Model, PlaneMesh,
    PointMass, Sides, StructureBlock, StructureSource, Untied,
};
pub use surface::{
    Curves, Elastic, Fitted, Gap, GreenwoodWilliamson, Heights, ParameterSet, Parameters, Per, Surface, SyntheticScan,
};
pub use tightening::Tightening;
pub use torque_report::TorqueReport;
pub use uncertain::{
    Distribution, Lognormal, Normal, NumberOrText, SamplingMethod, TIGHTENING_SIGMAS, TighteningMethod, Uncertain,
};
pub use units::{
    Acceleration, AccelerationDensity, Area, ArealDensity, ContactStiffness, Density, Dimension, Force, ForceDensity,
    Length, Mass, ModalAmplitude, Quantity, Stress, SurfaceEnergy, Torque, Unbalance, Unit, Units, dimension,
};
pub use upgrade::{rewritten, upgraded};

pub use cqsma_solver::cqsma::Commit;
pub use finite_elements::elements::Formulation;
pub use joint_model::benchmark::{ElementOrder, RefinementLevel, Symmetry};
