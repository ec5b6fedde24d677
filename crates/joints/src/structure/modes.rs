//! Mode shapes of a structure without contact, with the interface stuck, and with linear interfaces.

use super::meshed::Meshed;
use super::mode_names::{Shares, SliceMotions, named};
use super::{LinearInterface, Structure};
use crate::Error;
use crate::progress::{Progress, Stage, end_stage};
use dense_algebra::product;
use faer::Mat;
use finite_elements::assemble::System;
use finite_elements::eigen;
use finite_elements::sparse::multiply;
use joint_model::Bodies;
use reduction::{Limits, checks};
use serde::{Deserialize, Serialize};
use sprs::CsMat;

/// What holds the bodies together at the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Contact {
    /// Nothing.
    Unstressed,
    /// Both sides move together.
    Stuck,
    /// Uniform springs.
    Linear,
    /// The tangent of the contact under the bolt loads, with everything in contact stuck.
    Prestressed,
}

impl Contact {
    /// What it is, for those who compare frequencies of different states.
    pub fn words(self) -> &'static str {
        match self {
            Self::Unstressed => "unstressed, no contact",
            Self::Stuck => "stuck, both faces move together everywhere",
            Self::Linear => "linear interface, uniform springs in the place of the scene's law",
            Self::Prestressed => {
                "prestressed, the scene's law about the static state with everything in contact stuck, as in `run`"
            }
        }
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unstressed => "unstressed",
            Self::Stuck => "stuck",
            Self::Linear => "linear",
            Self::Prestressed => "prestressed",
        }
    }
}

/// A mode that stores energy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeShape {
    /// Counted from 1 in ascending order of the frequencies.
    pub number: usize,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// What it looks like, in words, with the share of the motion that says so.
    pub name: String,
    /// Shares of the motion of the cross-sections along the longest axis.
    pub shares: Shares,
    /// Strain energy in the interface over that of the structure with it; of an interface that stores energy.
    pub interface_energy: Option<f64>,
    /// Root mean square of the jump over the interface, over that of the motion of all masses; 0 of a stuck interface.
    pub jump: f64,
    /// Effective modal masses along the axes of the model (kg).
    pub effective_mass: [f64; 3],
    /// Effective modal moments of inertia about axes parallel to them through the centre of mass (kg m^2).
    pub effective_inertia: [f64; 3],
    /// Displacement of each node of the mesh in the mode of unit modal mass (1/sqrt(kg)).
    #[serde(skip)]
    pub displacement: Vec<[f64; 3]>,
}

/// The lowest modes with one contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModesOfContact {
    /// What holds the bodies together.
    pub contact: Contact,
    /// Motions without energy; they are not among the modes.
    pub zero_energy_modes: usize,
    /// Ascending.
    pub modes: Vec<ModeShape>,
    /// Largest residual of the modes relative to the elastic forces, in the norm of the inverse of the stiffness.
    pub residual: f64,
    /// Largest difference of a product of two shapes in the mass from one or zero.
    pub orthonormality_error: f64,
}

/// Modal assurance criteria in the norm of the mass: squares of the cosines between the modes of two contacts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assurance {
    /// Contact of the modes of the rows.
    pub rows: Contact,
    /// Contact of the modes of the columns.
    pub columns: Contact,
    /// Row by row.
    pub values: Vec<Vec<f64>>,
}

/// Modes of a structure with each contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModalModel {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass (m).
    pub centre: [f64; 3],
    /// Principal axes of inertia as rows, the longest extent first.
    pub axes: [[f64; 3]; 3],
    /// The linear interface.
    pub linear: LinearInterface,
    /// The modes.
    pub contacts: Vec<ModesOfContact>,
    /// Each pair of contacts.
    pub assurance: Vec<Assurance>,
    /// Modes with a linear interface, the prestressed one if it is there, by their share of energy in the interface, largest first.
    pub joint_moved_most_by: Vec<usize>,
}

/// Shapes of one contact over the independent components, and what the mass makes of them.
struct Shapes {
    shapes: Mat<f64>,
    momentum: Mat<f64>,
}

impl Structure {
    /// The `count` lowest modes with each contact; with `tangent`, a stiffness over the jump (N/m), also those of the prestressed
    /// structure.
    ///
    /// # Errors
    /// [`Error::NoMesh`] of matrices; of assembly and eigensolver.
    pub fn modes(
        &self,
        count: usize,
        linear: Option<LinearInterface>,
        tangent: Option<&CsMat<f64>>,
        progress: &dyn Progress,
    ) -> Result<ModalModel, Error> {
        let Bodies::Meshed(bodies) = &self.joint.bodies else {
            return Err(Error::NoMesh);
        };
        progress.begin(Stage::Assemble);
        let Meshed { system, relative } = Meshed::try_new(&self.joint, bodies)?;
        end_stage(progress, Stage::Assemble)?;
        progress.begin(Stage::Factor);
        let linear = linear.unwrap_or_else(|| self.check_interface());
        let springs = self.springs(linear, |_| true)?;
        // Shape functions integrated over the area: squares of jumps from it.
        let unit = self.springs(
            LinearInterface {
                normal_stiffness: 1.0,
                tangential_stiffness: 1.0,
                ..linear
            },
            |_| true,
        )?;
        let area = self.symmetry.operators(&self.joint.interface, 2)?.area();
        let slices = SliceMotions::new(&system.dofs.coordinates, &system.nodal_mass);
        let rigid = system.dofs.rigid_motions(slices.centre);
        let tolerance = self.settings.mode_tolerance;
        let stop = || progress.interrupted();
        let limits = Limits::default().until(&stop);
        let all = [
            (Contact::Unstressed, None),
            (Contact::Stuck, None),
            (Contact::Linear, Some(&springs)),
        ];
        let all = all
            .into_iter()
            .chain(tangent.map(|tangent| (Contact::Prestressed, Some(tangent))));
        let (mut contacts, mut shapes) = (Vec::new(), Vec::new());
        for (place, (contact, interface)) in all.enumerate() {
            progress.fraction(Stage::Factor, place as f64 / 4.0);
            let locked = match contact == Contact::Prestressed && self.locks {
                true => Some(relative.locked()?),
                false => None,
            };
            let relative = locked.as_ref().unwrap_or(&relative);
            let found = match contact {
                Contact::Stuck => checks::stuck_modes(relative, count, tolerance, limits)?,
                _ => checks::full_modes(relative, interface, count, tolerance, limits)?,
            };
            let over = relative.displacements(found.elastic());
            let momentum = multiply(&system.mass, over.as_ref());
            let of = Shapes { shapes: over, momentum };
            let jumps = found.elastic().subrows(0, relative.n_relative).to_owned();
            let energy = |stiffness: &CsMat<f64>, mode: usize| energy(stiffness, &jumps, mode);
            let modes = self.described(&system, &of, &found, &slices, &rigid, &|mode, w2| {
                let jump = (energy(&unit, mode).max(0.0) / area * system.total_mass).sqrt();
                (interface.map(|springs| energy(springs, mode) / w2), jump)
            });
            contacts.push(ModesOfContact {
                contact,
                zero_energy_modes: found.n_zero,
                modes,
                residual: found.residual,
                orthonormality_error: of.orthonormality_error(),
            });
            shapes.push(of);
        }
        progress.end(Stage::Factor);
        let assurance = pairs(contacts.len())
            .map(|(i, j)| Assurance {
                rows: contacts[i].contact,
                columns: contacts[j].contact,
                values: shapes[i].assurance(&shapes[j]),
            })
            .collect();
        let softest = contacts.last().map_or(&[][..], |last| last.modes.as_slice());
        let share = |number: &usize| softest[number - 1].interface_energy.unwrap_or(0.0);
        let mut joint_moved_most_by: Vec<usize> = (1..=softest.len()).collect();
        joint_moved_most_by.sort_by(|a, b| share(b).total_cmp(&share(a)));
        Ok(ModalModel {
            mass: system.total_mass,
            centre: slices.centre,
            axes: slices.axes,
            linear,
            assurance,
            joint_moved_most_by,
            contacts,
        })
    }

    /// `of_interface` gives the share of energy in the interface and the jump of a mode.
    fn described(
        &self,
        system: &System,
        shapes: &Shapes,
        found: &eigen::Modes,
        slices: &SliceMotions,
        rigid: &Mat<f64>,
        of_interface: &dyn Fn(usize, f64) -> (Option<f64>, f64),
    ) -> Vec<ModeShape> {
        let nodal = multiply(&system.dofs.transform, shapes.shapes.as_ref());
        let participation = product(rigid.transpose(), shapes.momentum.as_ref());
        let frequencies = found.frequencies();
        let mut modes: Vec<ModeShape> = (0..frequencies.len())
            .map(|mode| {
                let column: Vec<f64> = nodal.col(mode).iter().copied().collect();
                let displacement: Vec<[f64; 3]> = column.as_chunks().0.to_vec();
                let (interface_energy, jump) = of_interface(mode, found.eigenvalues[found.n_zero + mode]);
                let effective = |k: usize| participation[(k, mode)].powi(2);
                ModeShape {
                    number: mode + 1,
                    frequency_hz: frequencies[mode],
                    name: String::new(),
                    shares: slices.shares(&displacement),
                    interface_energy,
                    jump,
                    effective_mass: [0, 1, 2].map(effective),
                    effective_inertia: [3, 4, 5].map(effective),
                    displacement,
                }
            })
            .collect();
        let names = named(modes.iter().map(|mode| &mode.shares), &slices.labels());
        for (mode, name) in modes.iter_mut().zip(names) {
            mode.name = name;
        }
        modes
    }
}

/// Each pair of numbers below `n`, the smaller one first.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
}

/// `x^T K x` of a column over the jump.
fn energy(stiffness: &CsMat<f64>, jumps: &Mat<f64>, column: usize) -> f64 {
    stiffness
        .iter()
        .map(|(value, (i, j))| value * jumps[(i, column)] * jumps[(j, column)])
        .sum()
}

impl Shapes {
    fn orthonormality_error(&self) -> f64 {
        let products = product(self.shapes.transpose(), self.momentum.as_ref());
        let unit = Mat::<f64>::identity(products.nrows(), products.ncols());
        (products - unit).norm_max()
    }

    fn assurance(&self, other: &Self) -> Vec<Vec<f64>> {
        let products = product(self.shapes.transpose(), other.momentum.as_ref());
        let rows = products.row_iter();
        rows.map(|row| row.iter().map(|p| p * p).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assurance_of_modes_with_themselves_is_one_or_zero() {
        // Two modes of masses 4 and 1 that move alone.
        let shapes = Mat::from_fn(2, 2, |i, j| if i == j { [0.5, 1.0][i] } else { 0.0 });
        let momentum = Mat::from_fn(2, 2, |i, j| if i == j { [2.0, 1.0][i] } else { 0.0 });
        let of = Shapes { shapes, momentum };
        assert_eq!(of.assurance(&of), [[1.0, 0.0], [0.0, 1.0]]);
        assert!(of.orthonormality_error() < 1e-15);
    }
}
