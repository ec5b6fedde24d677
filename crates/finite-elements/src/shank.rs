//! Shanks of bolts: beams between the reference points of two couplings, with a pretension; rigid bodies at reference points.
//!
//! A shank is a Timoshenko beam. With the elongation `e`, the twist `t`, the difference `k` and the mean `g` of the
//! end rotations against the chord in both planes, and the overlap `d` at an imaginary cut, it stores
//!
//! `2 U = k_ax (e + d)^2 + GJ/L t^2 + sum over planes: EI/L k^2 + 12 EI / (L (1 + phi)) g^2`, `phi = 12 EI / (kGA L^2)`,
//!
//! so that its tension `k_ax (e + d)` is the force that does work on `d`. Its mass matrix integrates the exact static shapes
//! of that beam (Friedman and Kosmatka 1993, DOI 10.1016/0045-7949(93)90243-7), with inertia of rotation. The overlap moves no
//! mass.

use crate::Error;
use crate::constraints::DofMap;
use crate::mesh::{Assembly, Coupling, Dof, Material};
use crate::sparse::congruence;
use nalgebra::{Matrix3, SMatrix, Vector3};
use sprs::{CsMat, TriMat};
use std::f64::consts::PI;

/// A beam between the reference points of two couplings, with a pretension.
///
/// Its pretension [`Dof::Pretension`] is the overlap at a cut through it (m), and a unit load on that is unit tension. As long as
/// the overlap is free, a load on it holds the tension and the axial stiffness does not act; where it is held, the axial stiffness
/// acts.
#[derive(Clone, Debug, PartialEq)]
pub struct Shank {
    /// Name used in messages.
    pub name: String,
    /// The couplings whose reference points it joins.
    pub ends: [u32; 2],
    /// Axial stiffness, `EA/L` of a uniform shank (N/m).
    pub axial: f64,
    /// Bending stiffness `EI` for deflection along `transverse`, and at a right angle to it (N m^2).
    pub bending: [f64; 2],
    /// Shear stiffness `kGA` for the same deflections (N).
    pub shear: [f64; 2],
    /// Torsional stiffness `GJ` (N m^2).
    pub torsion: f64,
    /// Mass per length (kg/m).
    pub mass: f64,
    /// Moments of inertia per length (kg m): of rotation about the axis, and of the tilt that goes with each deflection.
    pub inertia: [f64; 3],
    /// Direction of the first deflection: any that is not along the axis. What of it is along the axis does not count.
    pub transverse: [f64; 3],
}

/// A rigid body that moves with the reference point of a coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMass {
    /// The coupling.
    pub coupling: u32,
    /// Mass (kg), its centre at the reference point.
    pub mass: f64,
    /// Inertia about the reference point in global axes, symmetric and positive semidefinite (kg m^2).
    pub inertia: [[f64; 3]; 3],
}

/// Cross-section of a uniform shank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// Solid circle of this diameter (m).
    Circle(f64),
    /// Solid rectangle: sizes along the direction of the first deflection, and at a right angle to it (m).
    Rectangle([f64; 2]),
}

impl Section {
    /// Area (m^2).
    pub fn area(&self) -> f64 {
        match *self {
            Self::Circle(d) => PI * d * d / 4.0,
            Self::Rectangle([a, b]) => a * b,
        }
    }

    /// Second moments of area for both deflections (m^4).
    pub fn second_moments(&self) -> [f64; 2] {
        match *self {
            Self::Circle(d) => [PI * d.powi(4) / 64.0; 2],
            Self::Rectangle([a, b]) => [b * a.powi(3) / 12.0, a * b.powi(3) / 12.0],
        }
    }

    /// Torsion constant (m^4); of rectangles within 0.1 % (Roark's Formulas for Stress and Strain, table of torsion).
    fn torsion_constant(&self) -> f64 {
        match *self {
            Self::Circle(d) => PI * d.powi(4) / 32.0,
            Self::Rectangle(sides) => {
                let (a, b) = (sides[0].max(sides[1]), sides[0].min(sides[1]));
                a * b.powi(3) * (1.0 / 3.0 - 0.21 * b / a * (1.0 - (b / a).powi(4) / 12.0))
            }
        }
    }

    /// Shear coefficient (Cowper 1966, DOI 10.1115/1.3625046).
    fn shear_coefficient(&self, nu: f64) -> f64 {
        match self {
            Self::Circle(_) => 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu),
            Self::Rectangle(_) => 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu),
        }
    }
}

impl Shank {
    /// A uniform shank between the couplings `ends`, whose reference points are at `at` (m). The first deflection is along
    /// `transverse`.
    pub fn uniform(
        name: String,
        ends: [u32; 2],
        at: [[f64; 3]; 2],
        section: Section,
        material: &Material,
        transverse: [f64; 3],
    ) -> Self {
        let length = (Vector3::from(at[1]) - Vector3::from(at[0])).norm();
        let (e, nu, density) = (material.youngs_modulus, material.poisson_ratio, material.density);
        let shear = 0.5 * e / (1.0 + nu);
        let (area, [first, second]) = (section.area(), section.second_moments());
        Self {
            name,
            ends,
            axial: e * area / length,
            bending: [e * first, e * second],
            shear: [shear * area * section.shear_coefficient(nu); 2],
            torsion: shear * section.torsion_constant(),
            mass: density * area,
            inertia: [density * (first + second), density * first, density * second],
            transverse,
        }
    }

    pub(crate) fn convert_units(&mut self, length: f64, mass: f64) {
        self.axial *= mass;
        self.bending.iter_mut().for_each(|v| *v *= mass * length.powi(3));
        self.shear.iter_mut().for_each(|v| *v *= mass * length);
        self.torsion *= mass * length.powi(3);
        self.mass *= mass / length;
        self.inertia.iter_mut().for_each(|v| *v *= mass * length);
    }

    fn fail(&self, reason: &'static str) -> Error {
        Error::Shank {
            shank: self.name.clone(),
            reason,
        }
    }

    /// Its length, and its axes as rows: along it, then both deflections.
    ///
    /// # Errors
    /// [`Error::Dangling`], [`Error::Shank`].
    pub(crate) fn frame(&self, couplings: &[Coupling]) -> Result<(f64, Matrix3<f64>), Error> {
        let mut at = [Vector3::zeros(); 2];
        for (at, &end) in at.iter_mut().zip(&self.ends) {
            let coupling = couplings.get(end as usize).ok_or_else(|| Error::Dangling {
                place: format!("shank `{}`", self.name),
                what: "coupling",
                index: end as usize,
                count: couplings.len(),
            })?;
            *at = coupling.reference.into();
        }
        let span = at[1] - at[0];
        let scale = at[0].amax().max(at[1].amax());
        let axis = span
            .try_normalize(1e-9 * scale)
            .ok_or_else(|| self.fail("the reference points of its two couplings coincide, so that it has no axis; move one of them along the bolt"))?;
        let first = Vector3::from(self.transverse)
            .try_normalize(0.0)
            .filter(|given| given.iter().all(|v| v.is_finite()))
            .map(|given| given - axis * axis.dot(&given))
            .and_then(|across| across.try_normalize(1e-6))
            .ok_or_else(|| self.fail("the direction of its first deflection is along its axis, or no direction"))?;
        let second = axis.cross(&first);
        Ok((
            span.norm(),
            Matrix3::from_rows(&[axis.transpose(), first.transpose(), second.transpose()]),
        ))
    }

    fn validate(&self) -> Result<(), Error> {
        let stiffness = [
            self.axial,
            self.bending[0],
            self.bending[1],
            self.shear[0],
            self.shear[1],
            self.torsion,
        ];
        let inertia = [self.mass, self.inertia[0], self.inertia[1], self.inertia[2]];
        if !stiffness.iter().all(|v| v.is_finite() && *v > 0.0) {
            return Err(self.fail(
                "its stiffnesses (axial N/m, bending N m^2, shear N, torsion N m^2) must be positive and finite",
            ));
        }
        if !inertia.iter().all(|v| v.is_finite() && *v >= 0.0) {
            return Err(self.fail("its mass (kg/m) and inertia (kg m) per length must be finite and not negative"));
        }
        Ok(())
    }

    /// Stiffnesses that belong to [`deformations`].
    fn stiffnesses(&self, length: f64) -> [f64; DEFORMATIONS] {
        let [first, second] = [0, 1].map(|plane| {
            let (bending, phi) = (self.bending[plane], self.phi(plane, length));
            [bending / length, 12.0 * bending / (length * (1.0 + phi))]
        });
        [
            self.axial,
            self.torsion / length,
            first[0],
            first[1],
            second[0],
            second[1],
        ]
    }

    fn phi(&self, plane: usize, length: f64) -> f64 {
        12.0 * self.bending[plane] / (self.shear[plane] * length * length)
    }

    /// Mass over the motions of both ends in the shank's axes: displacements and rotations of the first, then of the second.
    fn mass_matrix(&self, length: f64) -> SMatrix<f64, 12, 12> {
        // Exact for polynomials of degree 7.
        let (a, b) = (
            (3.0_f64 / 7.0 - 2.0 / 7.0 * 1.2_f64.sqrt()).sqrt(),
            (3.0_f64 / 7.0 + 2.0 / 7.0 * 1.2_f64.sqrt()).sqrt(),
        );
        let (of_a, of_b) = ((18.0 + 30.0_f64.sqrt()) / 36.0, (18.0 - 30.0_f64.sqrt()) / 36.0);
        let mut matrix = SMatrix::<f64, 12, 12>::zeros();
        for (point, weight) in [(-a, of_a), (a, of_a), (-b, of_b), (b, of_b)] {
            let (s, weight) = (0.5 * (1.0 + point), 0.5 * weight * length);
            let mut add =
                |row: SMatrix<f64, 1, 12>, per_length: f64| matrix += row.transpose() * row * (weight * per_length);
            let linear = |component: usize| {
                let mut row = SMatrix::<f64, 1, 12>::zeros();
                (row[component], row[6 + component]) = (1.0 - s, s);
                row
            };
            add(linear(0), self.mass);
            add(linear(3), self.inertia[0]);
            for plane in 0..2 {
                let phi = self.phi(plane, length);
                let deflection = [
                    2.0 * s.powi(3) - 3.0 * s * s - phi * s + 1.0 + phi,
                    length * (s.powi(3) - (2.0 + 0.5 * phi) * s * s + (1.0 + 0.5 * phi) * s),
                    -2.0 * s.powi(3) + 3.0 * s * s + phi * s,
                    length * (s.powi(3) - (1.0 - 0.5 * phi) * s * s - 0.5 * phi * s),
                ];
                let tilt = [
                    6.0 / length * (s * s - s),
                    3.0 * s * s - (4.0 + phi) * s + 1.0 + phi,
                    -6.0 / length * (s * s - s),
                    3.0 * s * s - (2.0 - phi) * s,
                ];
                // A positive tilt is a rotation about the second transverse axis, or against the first.
                let (rotation, sign) = [(5, 1.0), (4, -1.0)][plane];
                let spread = |of: [f64; 4]| {
                    let mut row = SMatrix::<f64, 1, 12>::zeros();
                    for end in 0..2 {
                        row[6 * end + 1 + plane] = of[2 * end] / (1.0 + phi);
                        row[6 * end + rotation] = sign * of[2 * end + 1] / (1.0 + phi);
                    }
                    row
                };
                add(spread(deflection), self.mass);
                add(spread(tilt), self.inertia[1 + plane]);
            }
        }
        matrix
    }
}

/// Deformations of a shank.
pub(crate) const DEFORMATIONS: usize = 6;

/// Elongation (m), twist, and for both planes difference and mean of the end rotations against the chord, each over the motions
/// of both ends in global axes.
pub(crate) fn deformations(length: f64, axes: &Matrix3<f64>) -> SMatrix<f64, DEFORMATIONS, 12> {
    let mut rows = SMatrix::<f64, DEFORMATIONS, 12>::zeros();
    let mut set = |row: usize, first: usize, along: usize, factor: f64| {
        for component in 0..3 {
            rows[(row, first + component)] += factor * axes[(along, component)];
        }
    };
    for (end, sign) in [(0, -1.0), (6, 1.0)] {
        set(0, end, 0, sign);
        set(1, end + 3, 0, sign);
        for plane in 0..2 {
            let (about, turn) = [(2, 1.0), (1, -1.0)][plane];
            let row = 2 + 2 * plane;
            set(row, end + 3, about, sign * turn);
            set(row + 1, end + 3, about, 0.5 * turn);
            set(row + 1, end, 1 + plane, -sign / length);
        }
    }
    rows
}

/// Stiffness and mass over the independent components of what is at reference points.
pub(crate) struct AtReferences {
    pub(crate) stiffness: CsMat<f64>,
    pub(crate) mass: CsMat<f64>,
    /// kg
    pub(crate) total_mass: f64,
}

/// Motions of reference points, and how much they store.
struct Rows {
    motions: TriMat<f64>,
    between: TriMat<f64>,
}

impl Rows {
    fn new(count: usize, n: usize) -> Self {
        Self {
            motions: TriMat::new((count, n)),
            between: TriMat::new((count, count)),
        }
    }

    fn matrix(&self) -> CsMat<f64> {
        congruence(&self.motions.to_csr(), &self.between.to_csr())
    }
}

impl Assembly {
    /// Mass of the shanks and of the rigid bodies at their ends (kg).
    ///
    /// # Errors
    /// [`Error::Shank`] for one without length.
    pub fn mass_at_references(&self) -> Result<f64, Error> {
        let mut mass = 0.0;
        for shank in &self.shanks {
            mass += shank.mass * shank.frame(&self.couplings)?.0;
        }
        for body in &self.rigid_masses {
            mass += body.mass;
        }
        Ok(mass)
    }
}

impl AtReferences {
    /// `None` if there is nothing.
    ///
    /// # Errors
    /// [`Error::Dangling`], [`Error::Shank`], [`Error::RigidMass`], couplings that define no motion.
    pub(crate) fn try_new(assembly: &Assembly, dofs: &DofMap) -> Result<Option<Self>, Error> {
        let (shanks, bodies) = (&assembly.shanks, &assembly.rigid_masses);
        if shanks.is_empty() && bodies.is_empty() {
            return Ok(None);
        }
        let n = dofs.independent.len();
        let mut stiffness = Rows::new(DEFORMATIONS * shanks.len(), n);
        let mut mass = Rows::new(12 * shanks.len() + 6 * bodies.len(), n);
        for (index, shank) in shanks.iter().enumerate() {
            shank.validate()?;
            let (length, axes) = shank.frame(&assembly.couplings)?;
            let mut ends = Vec::with_capacity(12);
            for end in shank.ends {
                for component in 0..6 {
                    ends.push(dofs.combination(assembly, &shank.name, Dof::Reference(end, component))?);
                }
            }
            let deformation = deformations(length, &axes);
            for (row, value) in shank.stiffnesses(length).into_iter().enumerate() {
                let at = DEFORMATIONS * index + row;
                for (end, motion) in ends.iter().enumerate() {
                    add_row(&mut stiffness.motions, at, deformation[(row, end)], motion);
                }
                stiffness.between.add_triplet(at, at, value);
            }
            let overlap = dofs.combination(assembly, &shank.name, Dof::Pretension(index as u32))?;
            add_row(&mut stiffness.motions, DEFORMATIONS * index, 1.0, &overlap);
            let first = 12 * index;
            for block in 0..4 {
                for along in 0..3 {
                    for component in 0..3 {
                        let row = first + 3 * block + along;
                        add_row(
                            &mut mass.motions,
                            row,
                            axes[(along, component)],
                            &ends[3 * block + component],
                        );
                    }
                }
            }
            add_block(&mut mass.between, first, &shank.mass_matrix(length));
        }
        for (index, body) in bodies.iter().enumerate() {
            let fail = |reason| Error::RigidMass { mass: index, reason };
            let inertia = Matrix3::from_fn(|i, j| body.inertia[i][j]);
            if !(body.mass.is_finite() && body.mass >= 0.0 && inertia.iter().all(|v| v.is_finite())) {
                return Err(fail(
                    "its mass (kg) must be finite and not negative, and its inertia (kg m^2) finite",
                ));
            }
            let size = inertia.amax();
            if (inertia - inertia.transpose()).amax() > 1e-9 * size
                || inertia.symmetric_eigenvalues().min() < -1e-9 * size
            {
                return Err(fail(
                    "its inertia must be a symmetric matrix without negative principal values",
                ));
            }
            let first = 12 * shanks.len() + 6 * index;
            for component in 0..6 {
                let place = format!("rigid mass {index}");
                let motion = dofs.combination(assembly, &place, Dof::Reference(body.coupling, component))?;
                add_row(&mut mass.motions, first + usize::from(component), 1.0, &motion);
            }
            let mut block = SMatrix::<f64, 6, 6>::zeros();
            block.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(body.mass);
            block
                .fixed_view_mut::<3, 3>(3, 3)
                .copy_from(&(0.5 * (inertia + inertia.transpose())));
            add_block(&mut mass.between, first, &block);
        }
        Ok(Some(Self {
            stiffness: stiffness.matrix(),
            mass: mass.matrix(),
            total_mass: assembly.mass_at_references()?,
        }))
    }
}

fn add_row(to: &mut TriMat<f64>, row: usize, factor: f64, combination: &[(usize, f64)]) {
    if factor != 0.0 {
        for &(column, value) in combination {
            to.add_triplet(row, column, factor * value);
        }
    }
}

fn add_block<const N: usize>(to: &mut TriMat<f64>, first: usize, block: &SMatrix<f64, N, N>) {
    for i in 0..N {
        for j in 0..N {
            if block[(i, j)] != 0.0 {
                to.add_triplet(first + i, first + j, block[(i, j)]);
            }
        }
    }
}
