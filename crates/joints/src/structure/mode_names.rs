//! Names of modes, from the rigid motions of cross-sections along the longest axis.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use serde::Serialize;

/// Most cross-sections that the longest axis is divided into.
const SLICES: usize = 40;

/// Nodes that a cross-section should have on average.
const NODES_PER_SLICE: usize = 12;

/// Share of the motion from which on it gives a mode its name.
const DOMINANT: f64 = 0.7;

/// Least share that is told of a mixed mode.
const TOLD: f64 = 0.1;

/// Share of the motion of the whole as a rigid body from which on a mode is one of its supports.
const RIGID: f64 = 0.995;

/// Least cosine between a principal axis and an axis of the model for it to have its name.
const PARALLEL: f64 = 0.99;

/// Shares of the mass-weighted square of the motion. Cross-sections are slices normal to the longest axis that move rigidly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shares {
    /// Cross-sections move along the longest axis.
    pub axial: f64,
    /// They turn about it.
    pub torsion: f64,
    /// They move normal to the second axis and turn about it.
    pub bending_about_second: f64,
    /// They move normal to the third axis and turn about it.
    pub bending_about_third: f64,
    /// They do not stay as they are.
    pub other: f64,
    /// All masses move as one rigid body; this is part of the others.
    pub rigid: f64,
}

/// Cross-sections of a structure along its longest axis.
pub(super) struct SliceMotions {
    pub(super) centre: [f64; 3],
    /// Principal axes of inertia as rows, that of the least moment first.
    pub(super) axes: [[f64; 3]; 3],
    slices: Vec<Body>,
    whole: Body,
}

/// Nodes that may move as a rigid body.
struct Body {
    /// Node, mass (kg), and position from the centre of their masses along the principal axes (m).
    nodes: Vec<(usize, f64, Vector3<f64>)>,
    mass: f64,
    /// Inverse of the moments of inertia about the centre, zero where there is none.
    compliance: Matrix3<f64>,
}

/// Squares of the motion of a rigid body by its components, weighted by the mass.
struct RigidMotion {
    translation: [f64; 3],
    rotation: [f64; 3],
}

impl Body {
    fn new(mut nodes: Vec<(usize, f64, Vector3<f64>)>) -> Self {
        let mass: f64 = nodes.iter().map(|(_, mass, _)| mass).sum();
        let centre: Vector3<f64> = nodes.iter().map(|(_, mass, x)| *mass * x).sum::<Vector3<f64>>() / mass;
        nodes.iter_mut().for_each(|(_, _, x)| *x -= centre);
        let inertia = inertia(nodes.iter().map(|(_, mass, x)| (*mass, *x)));
        let eigen = SymmetricEigen::new(inertia);
        let least = 1e-9 * eigen.eigenvalues.max();
        let inverse = eigen
            .eigenvalues
            .map(|value| if value > least { 1.0 / value } else { 0.0 });
        let compliance = eigen.eigenvectors * Matrix3::from_diagonal(&inverse) * eigen.eigenvectors.transpose();
        Self {
            nodes,
            mass,
            compliance,
        }
    }

    fn motion(&self, displacement: &[Vector3<f64>]) -> RigidMotion {
        let (mut momentum, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for &(node, mass, x) in &self.nodes {
            momentum += mass * displacement[node];
            moment += mass * x.cross(&displacement[node]);
        }
        let rotation = self.compliance * moment;
        RigidMotion {
            translation: [0, 1, 2].map(|k| momentum[k] * momentum[k] / self.mass),
            rotation: [0, 1, 2].map(|k| (rotation[k] * moment[k]).max(0.0)),
        }
    }
}

/// Moments of inertia of points about the origin.
fn inertia(points: impl Iterator<Item = (f64, Vector3<f64>)>) -> Matrix3<f64> {
    points
        .map(|(mass, x)| mass * (Matrix3::from_diagonal_element(x.norm_squared()) - x * x.transpose()))
        .sum()
}

impl SliceMotions {
    /// `masses` (kg) lie at the `nodes` (m).
    pub(super) fn new(nodes: &[[f64; 3]], masses: &[f64]) -> Self {
        let total: f64 = masses.iter().sum();
        let at = |node: usize| Vector3::from(nodes[node]);
        let centre = (0..nodes.len()).map(|n| masses[n] * at(n)).sum::<Vector3<f64>>() / total;
        let about = inertia((0..nodes.len()).map(|n| (masses[n], at(n) - centre)));
        let eigen = SymmetricEigen::new(about);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let axes = order.map(|k| {
            let axis: Vector3<f64> = eigen.eigenvectors.column(k).into();
            // The sign of an axis is free: that of its largest component is positive.
            axis * axis[axis.iamax()].signum()
        });
        let along = |x: Vector3<f64>| Vector3::new(axes[0].dot(&x), axes[1].dot(&x), axes[2].dot(&x));
        let whole: Vec<_> = (0..nodes.len())
            .map(|n| (n, masses[n], along(at(n) - centre)))
            .collect();
        let count = (nodes.len() / NODES_PER_SLICE).clamp(1, SLICES);
        let ends = whole.iter().map(|(_, _, x)| x[0]);
        let (low, high) = (
            ends.clone().fold(f64::INFINITY, f64::min),
            ends.fold(f64::NEG_INFINITY, f64::max),
        );
        let mut slices = vec![Vec::new(); count];
        for &node in whole.iter().filter(|(_, mass, _)| *mass > 0.0) {
            let part = (node.2[0] - low) / (high - low) * count as f64;
            slices[(part as usize).min(count - 1)].push(node);
        }
        Self {
            centre: centre.into(),
            axes: axes.map(Into::into),
            slices: slices
                .into_iter()
                .filter(|nodes| !nodes.is_empty())
                .map(Body::new)
                .collect(),
            whole: Body::new(whole),
        }
    }

    /// Names of the principal axes: those of the model where they are nearly parallel.
    pub(super) fn labels(&self) -> [String; 3] {
        self.axes.map(|axis| {
            let parallel = (0..3).find(|&k| axis[k].abs() > PARALLEL);
            match parallel {
                Some(k) => ["x", "y", "z"][k].to_owned(),
                None => {
                    // Adding zero turns -0 into 0.
                    let [x, y, z] = axis.map(|c| (1e2 * c).round() / 1e2 + 0.0);
                    format!("({x:.2}, {y:.2}, {z:.2})")
                }
            }
        })
    }

    /// Shares of a motion, by the displacement of each node.
    pub(super) fn shares(&self, displacement: &[[f64; 3]]) -> Shares {
        let axes = self.axes.map(Vector3::from);
        let turned: Vec<Vector3<f64>> = displacement
            .iter()
            .map(|u| {
                let u = Vector3::from(*u);
                Vector3::new(axes[0].dot(&u), axes[1].dot(&u), axes[2].dot(&u))
            })
            .collect();
        let total: f64 = self
            .whole
            .nodes
            .iter()
            .map(|&(n, mass, _)| mass * turned[n].norm_squared())
            .sum();
        let share = |value: f64| if total > 0.0 { value / total } else { 0.0 };
        let motions: Vec<RigidMotion> = self.slices.iter().map(|slice| slice.motion(&turned)).collect();
        let sum = |of: &dyn Fn(&RigidMotion) -> f64| share(motions.iter().map(of).sum());
        let [axial, torsion] = [sum(&|m| m.translation[0]), sum(&|m| m.rotation[0])];
        let bending_about_second = sum(&|m| m.translation[2] + m.rotation[1]);
        let bending_about_third = sum(&|m| m.translation[1] + m.rotation[2]);
        let rigid = self.whole.motion(&turned);
        Shares {
            axial,
            torsion,
            bending_about_second,
            bending_about_third,
            other: (1.0 - axial - torsion - bending_about_second - bending_about_third).max(0.0),
            rigid: share(rigid.translation.iter().chain(&rigid.rotation).sum()),
        }
    }
}

/// Names of modes in ascending order of their frequencies; those of a family are counted.
pub(super) fn named<'a>(modes: impl Iterator<Item = &'a Shares>, axes: &[String; 3]) -> Vec<String> {
    let families = [
        format!("bending about {}", axes[1]),
        format!("bending about {}", axes[2]),
        format!("torsion about {}", axes[0]),
        format!("axial motion along {}", axes[0]),
        "motion within cross-sections".to_owned(),
    ];
    let mut counts = [0_usize; 5];
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    modes
        .map(|of| {
            if of.rigid > RIGID {
                return format!("rigid body on its supports ({})", percent(of.rigid));
            }
            let shares = [
                of.bending_about_second,
                of.bending_about_third,
                of.torsion,
                of.axial,
                of.other,
            ];
            // What happens within cross-sections is no family of its own.
            let dominant = (0..4).find(|&family| shares[family] > DOMINANT);
            if let Some(family) = dominant {
                counts[family] += 1;
                return format!(
                    "{} {} ({})",
                    ordinal(counts[family]),
                    families[family],
                    percent(shares[family])
                );
            }
            let mut order = [0, 1, 2, 3, 4];
            order.sort_by(|&a, &b| shares[b].total_cmp(&shares[a]));
            let told = order.into_iter().filter(|&family| shares[family] > TOLD);
            let told: Vec<String> = told
                .map(|f| format!("{} {}", families[f], percent(shares[f])))
                .collect();
            format!("mixed ({})", told.join(", "))
        })
        .collect()
}

/// A number in words.
fn ordinal(number: usize) -> String {
    const WORDS: [&str; 10] = [
        "first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth",
    ];
    WORDS
        .get(number - 1)
        .map_or_else(|| format!("no. {number}"), |word| (*word).to_owned())
}
