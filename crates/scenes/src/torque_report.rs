//! How torque and preload of the bolts of a scene belong together.

use crate::scene::Scene;
use crate::torque::Screw;
use joint_model::significant;
use serde::{Deserialize, Serialize};

/// How torque and preload of the bolts belong together (VDI 2230-1, ISO 16047).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TorqueReport {
    /// Torque of each bolt (N m): the one given, or the one that its load would need.
    pub torques: Vec<f64>,
    /// Preload of each bolt (N).
    pub preloads: Vec<f64>,
    /// Whether the scene gives the torque; otherwise it gives the preload.
    pub is_given: bool,
    /// Nominal diameter of the thread (m).
    pub thread_diameter: f64,
    /// Pitch of the thread (m).
    pub pitch: f64,
    /// Coefficient of friction in the thread (-).
    pub thread_friction: f64,
    /// Coefficient of friction below the head or nut that turns (-).
    pub head_friction: f64,
    /// Inner and outer diameter of the face that turns (m).
    pub bearing_diameters: [f64; 2],
    /// Where these come from, in words.
    pub bearing_source: String,
    /// Torque over preload (m).
    pub lever: f64,
    /// Torque over preload and nominal diameter (-): the nut factor `k` of `M = k F d`.
    pub nut_factor: f64,
    /// Part of the torque that strains the bolt along the pitch (-).
    pub pitch_share: f64,
    /// Part of the torque that friction in the thread takes (-).
    pub thread_share: f64,
    /// Part of the torque that friction below the head takes (-).
    pub head_share: f64,
}

impl Scene {
    /// How torque and preload of the bolts belong together, where the scene knows their thread; of `bolts` bolts.
    pub fn torque_report(&self, bolts: usize) -> Option<TorqueReport> {
        let mesh = self.structure.mesh().map_or(&[][..], |mesh| &mesh.bolts);
        let Screw {
            thread,
            friction,
            bearing,
            bearing_source,
        } = self.bolts.screw(mesh).ok()??;
        let preloads: Vec<f64> = (0..bolts).map(|bolt| self.tension(bolt)).collect();
        let lever = thread.lever(friction, bearing);
        let [pitch_share, thread_share, head_share] = thread.lever_parts(friction, bearing).map(|part| part / lever);
        Some(TorqueReport {
            torques: preloads
                .iter()
                .map(|load| thread.torque(*load, friction, bearing))
                .collect(),
            preloads,
            is_given: self.bolts.has_torque(),
            thread_diameter: thread.diameter,
            pitch: thread.pitch,
            thread_friction: friction.thread,
            head_friction: friction.head,
            bearing_diameters: bearing,
            bearing_source,
            lever,
            nut_factor: lever / thread.diameter,
            pitch_share,
            thread_share,
            head_share,
        })
    }
}

impl TorqueReport {
    /// In one line.
    pub fn line(&self) -> String {
        let range = |values: &[f64], factor: f64| {
            let sizes = values.iter().map(|value| factor * value);
            let (low, high) = sizes.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
            match high > low * (1.0 + 1e-9) {
                true => format!("{} to {}", significant(low), significant(high)),
                false => significant(high),
            }
        };
        let (torque, preload) = (range(&self.torques, 1.0), range(&self.preloads, 1e-3));
        let first = match self.is_given {
            true => format!("torque: {torque} N m gives {preload} kN"),
            false => format!("torque: {preload} kN would need {torque} N m"),
        };
        format!(
            "{first} (k = {:.3}; pitch {:.0} %, thread {:.0} %, head {:.0} % of the torque; diameters of the turning face {:.2} and \
             {:.2} mm: {})",
            self.nut_factor,
            100.0 * self.pitch_share,
            100.0 * self.thread_share,
            100.0 * self.head_share,
            1e3 * self.bearing_diameters[0],
            1e3 * self.bearing_diameters[1],
            self.bearing_source
        )
    }
}
