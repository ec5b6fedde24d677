//! Numerical settings of a run, and what they make it miss.

use scenes::{Bins, Friction, Law, RadialRule, Scene};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A numerical setting that is finite where the model means an infinite one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Dial {
    /// The mesh of the bodies, see `model.error_bar`.
    Mesh,
    /// Modes that the reduction keeps.
    Modes,
    /// Quadrature points of an interface element.
    Points,
    /// Bins of asperities.
    Bins,
    /// Radii at which an asperity slips.
    Radii,
    /// Vertices of a loop.
    Vertices,
    /// Residuals of the equilibria, and loops that are not quite closed.
    Equilibrium,
}

/// What an error is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DialError {
    /// Relative, of the frequency; `null` where it is not known.
    pub frequency_relative: Option<f64>,
    /// Of the logarithm of the damping ratio of friction; `null` where it is not known, or the damping is below its floor.
    pub damping_ln: Option<f64>,
}

impl DialError {
    /// Takes the larger of two errors, each.
    pub(super) fn raise(&mut self, other: &Self) {
        let larger = |own: Option<f64>, other: Option<f64>| match (own, other) {
            (Some(own), Some(other)) => Some(own.max(other)),
            (own, other) => own.or(other),
        };
        self.frequency_relative = larger(self.frequency_relative, other.frequency_relative);
        self.damping_ln = larger(self.damping_ln, other.damping_ln);
    }
}

/// The error of an amplitude by numerical settings: the sum of the magnitudes of what each of them is estimated to miss. The physics has none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AmplitudeError {
    /// Relative, of the frequency; `null` where a part of it is not known.
    pub frequency_relative: Option<f64>,
    /// Of the logarithm of the damping ratio of friction; `null` where a part of it is not known, or the damping is below its floor.
    pub damping_ln: Option<f64>,
    /// Its parts.
    pub of: BTreeMap<Dial, DialError>,
}

impl Dial {
    /// What it counts, for readers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Modes => "modes",
            Self::Points => "points per direction",
            Self::Bins => "bins",
            Self::Radii => "radii",
            Self::Vertices => "vertices per quarter",
            Self::Equilibrium => "equilibrium",
        }
    }

    /// Estimated error of the present number over what the other number changes: with errors that fall with the square of the number twice as
    /// many leave a quarter of them and five points per direction for three 9/25, rounded up. Half as many vertices change more than all of them leave.
    pub(super) fn share(self) -> f64 {
        match self {
            Self::Vertices => 1.0,
            _ => 1.5,
        }
    }

    /// The largest number that a scene has of it; none where it has none of it, or it is not a number. `bins` is the largest number of bins at a
    /// point, two beyond their reach included.
    pub(super) fn number(self, scene: &Scene, bins: usize) -> Option<usize> {
        let interfaces = &scene.interfaces;
        let own = interfaces.each.iter().filter_map(|own| own.law.as_ref());
        let of_law = |law: &Law| match self {
            Self::Bins if law.friction() != Friction::Lumped => Some(match law.bins {
                Bins::Error(_) => 2 * (bins.saturating_sub(1) / 2).max(1),
                Bins::Gauss(n) | Bins::EquallySpaced(n) => n,
            }),
            Self::Radii if law.friction() == Friction::MindlinIwan => Some(match law.radii {
                RadialRule::Annuli(n) | RadialRule::EquallySpaced(n) => n,
            }),
            _ => None,
        };
        match self {
            Self::Points => {
                let has_own = scene.structure.matrices().is_some_and(|given| given.points.is_some());
                (!has_own).then_some(interfaces.points_per_direction)
            }
            Self::Vertices => Some(scene.analyses.backbone.vertices_per_quarter),
            Self::Bins | Self::Radii if bins > 0 => {
                std::iter::once(&interfaces.law).chain(own).filter_map(of_law).max()
            }
            _ => None,
        }
    }

    /// The scene with a number of it, in all laws that have it.
    pub(super) fn with(self, scene: &Scene, number: usize) -> Scene {
        let mut scene = scene.clone();
        let interfaces = &mut scene.interfaces;
        let own = interfaces.each.iter_mut().filter_map(|own| own.law.as_mut());
        match self {
            Self::Points => interfaces.points_per_direction = number,
            Self::Vertices => scene.analyses.backbone.vertices_per_quarter = number,
            Self::Bins => std::iter::once(&mut interfaces.law).chain(own).for_each(|law| {
                law.bins = match law.bins {
                    Bins::Error(_) | Bins::Gauss(_) => Bins::Gauss(number.next_multiple_of(2)),
                    Bins::EquallySpaced(_) => Bins::EquallySpaced(number),
                }
            }),
            Self::Radii => std::iter::once(&mut interfaces.law).chain(own).for_each(|law| {
                law.radii = match law.radii {
                    RadialRule::Annuli(_) => RadialRule::Annuli(number),
                    RadialRule::EquallySpaced(_) => RadialRule::EquallySpaced(number),
                }
            }),
            Self::Mesh | Self::Modes | Self::Equilibrium => {}
        }
        scene
    }
}
