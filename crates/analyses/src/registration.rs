//! What the position of one face on the other does to a backbone.

use super::ensemble::{Member, MemberPoint};
use super::prepared::Prepared;
use crate::Error;
use joints::progress::{Progress, Silent};
use joints::store::Options;
use joints::store::checkpoint::Checkpoints;
use joints::structure::Structure;
use scenes::{Length, Registration, Scene};
use serde::Serialize;

/// A backbone with the bottom face moved.
#[derive(Clone, Debug, Serialize)]
pub struct Moved {
    /// Where the bottom face is.
    pub registration: Registration,
    /// First linearised frequency (Hz).
    pub first_frequency_hz: f64,
    /// The amplitudes that converged, ascending.
    pub points: Vec<MemberPoint>,
    /// Amplitudes that did not.
    pub not_converged: usize,
    /// Largest change of the frequency against the scene as it is, at amplitudes that both reach (Hz).
    pub frequency_change_hz: f64,
    /// Largest change of the logarithm of the damping ratio there, where both are above their floor.
    pub damping_change: f64,
}

/// The scene as it is, and with its bottom face moved by `shift` (m) and tilted by `tilt` (1) to either side along x and y;
/// all on one reduced structure. Beside the backbones it gives what lets the study resume until they are safe.
///
/// # Errors
/// [`joints::Error::NoSamples`] for a surface that is not scanned; of [`Prepared::solve`].
pub fn study(
    scene: &Scene,
    [shift, tilt]: [f64; 2],
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Vec<Moved>, Checkpoints), Error> {
    let mut scene = scene.clone();
    let base = *scene
        .interfaces
        .surface
        .registration()
        .ok_or(joints::Error::NoSamples)?;
    let mut all = vec![base];
    for axis in 0..2 {
        for sign in [-1.0, 1.0] {
            let (mut shifted, mut tilted) = (base, base);
            shifted.shift[axis] = Length::from_si(base.shift[axis].si() + sign * shift);
            tilted.tilt[axis] += sign * tilt;
            all.extend([shifted, tilted]);
        }
    }
    scene.validate(&scene.name)?;
    let structure = Structure::try_new(&scene, progress)?;
    let mut moved: Vec<Moved> = Vec::with_capacity(all.len());
    let mut first: Option<Member> = None;
    let mut checkpoints = Checkpoints::default();
    for (index, &registration) in all.iter().enumerate() {
        progress.note(&format!("registration {} of {}", index + 1, all.len()));
        if let Some(place) = scene.interfaces.surface.registration() {
            *place = registration;
        }
        // The first run shows its stages, and reduces the structure for all.
        let quiet: &dyn Progress = if index == 0 { progress } else { &Silent };
        let run = Prepared::try_new(&scene, &structure, options, quiet)?.solve(quiet)?;
        let member = Member::of(index, run.amplitudes(), run.first().background);
        let [frequency_change_hz, damping_change] = match &first {
            None => [0.0; 2],
            Some(first) => differences(first, &member),
        };
        moved.push(Moved {
            registration,
            first_frequency_hz: run.frequencies[run.first().mode - 1],
            points: member.points.clone(),
            not_converged: member.not_converged,
            frequency_change_hz,
            damping_change,
        });
        first.get_or_insert(member);
        checkpoints.extend(run.checkpoints);
    }
    Ok((moved, checkpoints))
}

/// Largest differences of frequency (Hz) and of the logarithm of damping at the amplitudes of `base` that both reach.
fn differences(base: &Member, other: &Member) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    for point in &base.points {
        let Some([frequency, damping, _]) = other.at(point.response_displacement) else {
            continue;
        };
        largest[0] = largest[0].max((frequency - point.frequency_hz).abs());
        if let Some(own) = point.damping_ratio.filter(|own| *own > 0.0 && damping > 0.0) {
            largest[1] = largest[1].max((damping / own).ln().abs());
        }
    }
    largest
}
