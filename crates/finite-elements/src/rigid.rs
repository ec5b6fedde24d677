//! How many rigid motions the connections and supports of an assembly leave.

use crate::Error;
use crate::constraints::{DofMap, expand};
use crate::mesh::{Assembly, CouplingKind, Dof, Superelement};
use crate::sets::DisjointSets;
use crate::shank::deformations;
use nalgebra::{DVector, Vector3};
use std::collections::BTreeMap;

/// Part of a constraint that must be left after those before it are taken out, for it to hold a motion of its own.
const INDEPENDENT: f64 = 1e-8;

impl Assembly {
    /// Number of rigid motions that cost no energy: six of each free structure, fewer where supports and springs to the ground
    /// hold it. Mechanisms count too: of two bodies on a hinge one motion more is left.
    ///
    /// A body is what elements and superelements that share nodes form. Ties, couplings, equations, shanks and cuts connect bodies; shanks and cuts
    /// with their overlap held.
    ///
    /// # Errors
    /// As [`Mesh::validate`](crate::mesh::Mesh::validate) and [`DofMap::try_new`]; of shanks without axis.
    pub fn rigid_motions(&self) -> Result<usize, Error> {
        self.mesh.validate()?;
        (self.superelements.iter()).try_for_each(|body| body.validate(self.mesh.nodes.len()))?;
        let dofs = DofMap::try_new(self)?;
        let motions = Motions::new(self, &dofs);
        let mut held = Held::new(motions.count);
        let n_nodal = 3 * dofs.coordinates.len();
        let all = n_nodal + 6 * self.couplings.len();
        for full in (0..all).filter(|full| dofs.independent.binary_search(full).is_err()) {
            if full >= n_nodal && !matches!(self.couplings[(full - n_nodal) / 6].kind, CouplingKind::Kinematic(_)) {
                continue;
            }
            let mut terms = vec![(full, -1.0)];
            terms.extend(dofs.row(full).map(|(column, &value)| (dofs.independent[column], value)));
            held.insert(&motions, &terms);
        }
        for spring in &self.springs {
            let at = Dof::Node(spring.node, spring.component);
            held.insert(&motions, &expand(self, &dofs.coordinates, "a ground spring", at)?);
        }
        for body in &self.superelements {
            let Some(&first) = body.nodes().first() else {
                continue;
            };
            let at = motions.of[3 * first as usize][0].0;
            let amounts = |node: u32, component: u8| {
                let mut amounts = [0.0; 6];
                for &(motion, value) in &motions.of[3 * node as usize + usize::from(component)] {
                    amounts[motion - at] = value;
                }
                amounts
            };
            for row in body.in_rigid_motions(dofs.coordinates.len(), amounts)?.resisted {
                let scale = row.iter().fold(0.0, |m: f64, value| m.max(value.abs()));
                held.insert_row((at..).zip(row).collect(), scale);
            }
        }
        for shank in &self.shanks {
            let (length, axes) = shank.frame(&self.couplings)?;
            let rows = deformations(length, &axes);
            for row in rows.row_iter() {
                let mut terms = Vec::new();
                for (end, &coupling) in shank.ends.iter().enumerate() {
                    for component in 0..6_u8 {
                        let factor = row[6 * end + usize::from(component)];
                        let motion = expand(
                            self,
                            &dofs.coordinates,
                            &shank.name,
                            Dof::Reference(coupling, component),
                        )?;
                        terms.extend(motion.into_iter().map(|(full, value)| (full, factor * value)));
                    }
                }
                held.insert(&motions, &terms);
            }
        }
        Ok(motions.count - held.number())
    }
}

/// Rigid motions of the bodies and of the reference points of kinematic couplings.
struct Motions {
    /// Of each component: its motions and how much they move it, or nothing.
    of: Vec<Vec<(usize, f64)>>,
    count: usize,
}

impl Motions {
    fn new(assembly: &Assembly, dofs: &DofMap) -> Self {
        let nodes = &dofs.coordinates;
        let by_matrices: Vec<Vec<u32>> = assembly.superelements.iter().map(Superelement::nodes).collect();
        let cells = assembly.mesh.elements.iter().map(|element| element.cell.nodes());
        let cells = cells.chain(by_matrices.iter().map(Vec::as_slice));
        let mut bodies = DisjointSets::of_groups(nodes.len(), cells.clone());
        let mut used = vec![false; nodes.len()];
        cells.flatten().for_each(|&node| used[node as usize] = true);
        let references = assembly.couplings.iter().map(|coupling| &coupling.reference);
        let extent = (0..3).map(|axis| {
            let along = nodes.iter().chain(references.clone()).map(|x| x[axis]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            (0.5 * (low + high), high - low)
        });
        let extent: Vec<(f64, f64)> = extent.collect();
        let centre = Vector3::new(extent[0].0, extent[1].0, extent[2].0);
        let size = extent.iter().map(|(_, size)| *size).fold(0.0, f64::max);
        let scale = if size > 0.0 && size.is_finite() { size } else { 1.0 };

        let mut first: BTreeMap<u32, usize> = BTreeMap::new();
        let mut count = 0;
        let mut of = Vec::with_capacity(3 * nodes.len() + 6 * assembly.couplings.len() + assembly.n_pretensions());
        for (node, x) in nodes.iter().enumerate() {
            if !used[node] {
                // A node alone does not turn.
                of.extend((0..3).map(|c| vec![(count + c, 1.0)]));
                count += 3;
                continue;
            }
            let at = *first.entry(bodies.root(node as u32)).or_insert_with(|| {
                count += 6;
                count - 6
            });
            let turn = -((Vector3::from(*x) - centre) / scale).cross_matrix();
            of.extend((0..3).map(|c| {
                let mut row = vec![(at + c, 1.0)];
                row.extend((0..3).map(|axis| (at + 3 + axis, turn[(c, axis)])));
                row
            }));
        }
        for coupling in &assembly.couplings {
            match coupling.kind {
                CouplingKind::Distributing(_) => of.extend(std::iter::repeat_n(Vec::new(), 6)),
                CouplingKind::Kinematic(_) => {
                    // Rotations are multiplied by lengths in whatever they are part of.
                    of.extend((0..6).map(|c| vec![(count + c, if c < 3 { 1.0 } else { 1.0 / scale })]));
                    count += 6;
                }
            }
        }
        // Overlaps are held, and inner coordinates follow.
        of.extend(std::iter::repeat_n(
            Vec::new(),
            assembly.n_pretensions() + assembly.n_inner(),
        ));
        Self { of, count }
    }
}

/// The motions that constraints hold.
struct Held {
    /// Of constraints that act on the same motions, those that are independent of one another: most are on two bodies, and few of them independent.
    groups: BTreeMap<Vec<usize>, Vec<DVector<f64>>>,
    count: usize,
}

impl Held {
    fn new(count: usize) -> Self {
        Self {
            groups: BTreeMap::new(),
            count,
        }
    }

    /// `sum coefficient * component = 0` for all rigid motions.
    fn insert(&mut self, motions: &Motions, terms: &[(usize, f64)]) {
        let mut row: BTreeMap<usize, f64> = BTreeMap::new();
        let mut scale = 0.0_f64;
        for &(full, coefficient) in terms {
            for &(motion, value) in &motions.of[full] {
                *row.entry(motion).or_default() += coefficient * value;
                scale = scale.max((coefficient * value).abs());
            }
        }
        self.insert_row(row, scale);
    }

    /// `sum coefficient * motion = 0`, whose terms had magnitudes up to `scale`.
    fn insert_row(&mut self, row: BTreeMap<usize, f64>, scale: f64) {
        if scale > 0.0 {
            let (on, values): (Vec<usize>, Vec<f64>) = row.into_iter().unzip();
            let basis = self.groups.entry(on).or_default();
            extend(basis, DVector::from_vec(values) / scale);
        }
    }

    /// How many.
    fn number(&self) -> usize {
        let mut basis = Vec::new();
        for (on, rows) in &self.groups {
            for row in rows.iter().take(self.count - basis.len()) {
                let mut whole = DVector::zeros(self.count);
                on.iter().zip(row).for_each(|(&motion, value)| whole[motion] = *value);
                extend(&mut basis, whole);
            }
        }
        basis.len()
    }
}

/// Adds what is left of a row to an orthonormal basis, if the basis has not got it.
fn extend(basis: &mut Vec<DVector<f64>>, mut row: DVector<f64>) {
    if basis.len() == row.len() {
        return;
    }
    // Once more for what round-off leaves.
    for _ in 0..2 {
        for held in &*basis {
            let part = held.dot(&row);
            row.axpy(-part, held, 1.0);
        }
    }
    let left = row.norm();
    if left > INDEPENDENT {
        basis.push(row / left);
    }
}
