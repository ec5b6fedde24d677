//! The tests of the public interface, in one program: one file for each subject.

#[path = "../common/mod.rs"]
mod common;

mod answer;
mod bolt;
mod calibration;
mod dampers;
mod deck;
mod effects;
mod equivalent;
mod errors;
mod excitations;
mod finish;
mod friction;
mod full_size;
mod independent_epmc;
mod limits;
mod many_joints;
mod matrices;
mod meshes;
mod methods;
mod modes;
mod periodic;
mod periodic_points;
mod point_contacts;
mod quadratic;
mod quick_scene;
mod resolved_friction;
mod ring_down;
mod scans;
mod scenes;
mod sensitivities;
mod stiff_contact;
mod superelements;
mod sweeps;
mod symmetry;
mod tightening;
mod uncertainty;
mod work;
