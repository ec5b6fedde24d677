//! What is implausible in the input or the results of a run: warnings, not errors.

use joint_model::fit::{FacesFit, Neighbour, SeatFit};
use joint_model::significant;
use joints::structure::Overview;
use serde::{Deserialize, Serialize};

/// Damping ratio from which on derivatives with fixed bins are those of whole runs within a sixth (`docs/guide/sensitivities.md`).
const DIFFERENTIATED: f64 = 1e-2;

/// Relative distance of two frequencies below which the smallest asymmetry mixes the shapes of their modes.
const TWINS: f64 = 1e-3;

/// Least and largest extent of a structure that is believed (m).
const SIZES: [f64; 2] = [1e-3, 20.0];
/// First elastic frequencies that are believed (Hz).
const FREQUENCIES: [f64; 2] = [1.0, 1e5];
/// Densities that are believed (kg/m^3).
const DENSITIES: [f64; 2] = [500.0, 25e3];
/// Young's moduli that are believed (Pa).
const MODULI: [f64; 2] = [1e9, 1.5e12];
/// Fraction of the asperities that may yield.
const YIELDED: f64 = 0.1;
/// Fraction of the interface that must be in contact.
const IN_CONTACT: f64 = 0.5;

/// Poisson ratio up to which incompatible modes keep up with nearly constant volume: at 0.4999 they agree with B-bar on the
/// Brake-Reuss beam within 3 %, at 0.499999 they are 4 % too stiff.
const POISSON_RATIO: f64 = 0.4999;
/// Mean distance of faces that touch (m) that is believed. Coordinates of files are rounded far below it, and the flatness of machined faces,
/// which a scan brings into a mesh, is about as large; clearances of drawings, sheets and bodies that were moved are larger.
const FACES_APART: f64 = 20e-6;
/// Shares of both of two named faces without a partner that are no intention. Polygons around round holes leave less; whole faces of
/// plates that overlap in part leave more.
const WITHOUT_PARTNER: [f64; 2] = [0.01, 0.25];
/// Least share of a ring under a head that lies on the mesh. Coarse meshes of round seats cover 0.9 and more.
const COVERED: f64 = 0.8;
/// Distance of an axis from the middle of its hole over the diameter of the shank that is believed where the hole leaves no room: coordinates
/// that were rounded, and coarse polygons.
const OFF_HOLE: f64 = 0.05;
/// Least diameter of a hole over that of the shank: below those of tapped holes, 0.83 of coarse threads, in coarse polygons.
const HOLE: f64 = 0.75;
/// Overlap of two seats over their mean diameter that is round-off.
const OVERLAP: f64 = 1e-3;
/// Share of the load below which contact circles are the faces' doing: the load of a bolt is known to a factor of two even where its torque is
/// (tightening factors of VDI 2230).
const LOAD_KNOWN: f64 = 0.5;

/// What a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum WarningKind {
    /// The structure is too large or too small (m).
    Size,
    /// A density (kg/m^3).
    Density,
    /// A Young's modulus (Pa).
    YoungsModulus,
    /// A Poisson ratio that many elements are too stiff at (-).
    PoissonRatio,
    /// Nothing presses the faces together (Pa).
    NoPressure,
    /// The bolt loads over the area exceed the hardness (Pa).
    MeanPressure,
    /// The largest pressure exceeds the hardness (Pa).
    PeakPressure,
    /// Many asperities yield (-).
    YieldedAsperities,
    /// Most of the interface is open under the bolt loads; value and limit are fractions in contact (-).
    OpenInterface,
    /// The first elastic frequency is too low or too high (Hz).
    FirstFrequency,
    /// Faces that touch are apart in the mesh, or penetrate one another, where the value is negative (m).
    FacesApart,
    /// Parts of both of two faces that touch face nothing (-).
    WithoutPartner,
    /// The ring under a head or nut is not on the mesh (-).
    SeatBeyondFace,
    /// A bolt is beside its hole (m).
    BoltOffHole,
    /// A bolt is thicker than its hole; value and limit are the diameters of the shank and of the hole (m).
    HoleTooNarrow,
    /// Heads or nuts of two bolts are in one another's place; value and limit are the distance of the axes and what they need (m).
    SeatsOverlap,
    /// Contact circles of asperities are larger than the formulas of contact reach; value and limit are radii over the asperities' (-).
    ContactCircles,
    /// Derivatives of damping depend on single bins of asperities; value and limit are damping ratios (-).
    DerivativesOfBins,
    /// A mode that is followed has a twin; value and limit are relative distances of their frequencies (-).
    TwinModes,
}

/// Something implausible.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Warning {
    /// What it is about, with the unit of value and limit.
    pub kind: WarningKind,
    /// In words.
    pub message: String,
    /// What was found.
    pub value: f64,
    /// The limit that it is beyond.
    pub limit: f64,
}

/// Results that are judged.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Hardness (Pa), if it is known.
    pub hardness: Option<f64>,
    /// Largest pressure at a point under the bolt loads (Pa).
    pub peak_pressure: f64,
    /// Share of the area whose pressure exceeds the hardness.
    pub share_above_hardness: f64,
    /// Fraction of the loaded asperities that yield, if it is known.
    pub yielded_asperities: Option<f64>,
    /// Share of the area in contact.
    pub in_contact: f64,
    /// First linearised frequency (Hz).
    pub first_frequency: Option<f64>,
    /// Contact circles beyond the formulas of contact, if they are.
    pub contact_circles: Option<ContactCircles>,
    /// Smallest damping ratio that was differentiated by another number than a friction coefficient with friction of asperities.
    pub differentiated: Option<f64>,
    /// Of the modes followed the one that is nearest to a neighbour, and that neighbour: numbers from 1 and linearised frequencies (Hz).
    pub nearest: Option<[(usize, f64); 2]>,
}

/// Of the modes `followed` the one that is nearest to a neighbour, and that neighbour, among `frequencies` (Hz).
pub(super) fn nearest(frequencies: &[f64], followed: impl Iterator<Item = usize>) -> Option<[(usize, f64); 2]> {
    let of_mode = |mode: usize| Some((mode, *frequencies.get(mode.checked_sub(1)?)?));
    followed
        .flat_map(|mode| [[mode, mode + 1], [mode, mode - 1]])
        .filter_map(|[mode, other]| Some([of_mode(mode)?, of_mode(other)?]))
        .min_by(|a, b| apart(*a).total_cmp(&apart(*b)))
}

/// Relative distance of two frequencies.
fn apart([(_, a), (_, b)]: [(usize, f64); 2]) -> f64 {
    (b / a - 1.0).abs()
}

/// Contact circles beyond the formulas of contact, and what leads to them.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactCircles {
    /// Radius over that of the asperity (-).
    pub ratio: f64,
    /// Up to which the formulas hold (-).
    pub limit: f64,
    /// Share of the largest pressure at which the formulas hold (-), if it is known.
    pub share: Option<f64>,
    /// Field of the scene from which the asperities follow.
    pub surface: String,
    /// Field of the scene from which the bolt loads follow.
    pub load: &'static str,
}

fn warning(kind: WarningKind, value: f64, limit: f64, message: String) -> Warning {
    Warning {
        kind,
        message,
        value,
        limit,
    }
}

/// The end of a range that a value is beyond; NaN is beyond the upper one.
fn beyond(value: f64, [low, high]: [f64; 2]) -> Option<f64> {
    if value < low {
        Some(low)
    } else if value <= high {
        None
    } else {
        Some(high)
    }
}

/// What is implausible before anything is computed.
pub fn of_input(overview: &Overview) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let largest = overview.size.map(|size| size.into_iter().fold(0.0, f64::max));
    if let Some((size, limit)) = largest.and_then(|size| Some((size, beyond(size, SIZES)?))) {
        let which = if size < limit { "only " } else { "" };
        let read = overview.units.as_ref().map(|units| format!(" It is read in {units}"));
        let message = format!(
            "the structure is {which}{} m long (plausible: {} to {} m); is the unit right?{}",
            significant(size),
            SIZES[0],
            SIZES[1],
            read.unwrap_or_default()
        );
        warnings.push(warning(WarningKind::Size, size, limit, message));
    }
    for material in &overview.materials {
        if let Some((density, limit)) = material
            .density
            .and_then(|density| Some((density, beyond(density, DENSITIES)?)))
        {
            let message = format!(
                "the density of {} is {} kg/m^3 (plausible: {} to {}); is the unit right?",
                material.name,
                significant(density),
                DENSITIES[0],
                DENSITIES[1]
            );
            warnings.push(warning(WarningKind::Density, density, limit, message));
        }
        if let Some(limit) = beyond(material.youngs_modulus, MODULI) {
            let message = format!(
                "Young's modulus of {} is {} GPa (plausible: {} to {} GPa); is the unit right?",
                material.name,
                significant(1e-9 * material.youngs_modulus),
                1e-9 * MODULI[0],
                1e-9 * MODULI[1]
            );
            warnings.push(warning(
                WarningKind::YoungsModulus,
                material.youngs_modulus,
                limit,
                message,
            ));
        }
        let ratio = material.poisson_ratio;
        if ratio > POISSON_RATIO {
            let message = format!(
                "the Poisson ratio of {} is {ratio}: above {POISSON_RATIO} elements of first order are too stiff, except for \
                 \"model\": {{ \"formulation\": \"b-bar\" }}; so are quadratic ones with full integration",
                material.name
            );
            warnings.push(warning(WarningKind::PoissonRatio, ratio, POISSON_RATIO, message));
        }
    }
    let fit = &overview.fit;
    warnings.extend(fit.faces.iter().flat_map(|faces| of_faces(overview, faces)));
    warnings.extend(fit.seats.iter().flat_map(of_seat));
    warnings
}

/// Where faces do not lie upon one another as a scene says.
fn of_faces(overview: &Overview, faces: &FacesFit) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let name = match overview.interfaces.len() {
        0 => "the interface".to_owned(),
        _ => format!("interface {}", faces.interface),
    };
    let mm = |length: f64| significant(1e3 * length);
    let distance = faces.representative();
    if distance.abs() > FACES_APART {
        let [low, high] = faces.distance_range.map(mm);
        let (what, how) = match distance < 0.0 {
            true => ("penetrate one another", "deep"),
            false => ("stand apart", "wide"),
        };
        let message = format!(
            "the faces of {name} {what} in the mesh, {} mm {how} in the mean (distances of {low} to {high} mm; plausible: up to {} mm). This \
             distance is left out, and the scene's `gap` alone counts; correct the places of the bodies, or say by `gap` what is meant",
            mm(distance.abs()),
            mm(FACES_APART)
        );
        warnings.push(warning(WarningKind::FacesApart, distance, FACES_APART, message));
    }
    let share = faces.without_partner.into_iter().fold(f64::INFINITY, f64::min);
    if faces.named && share > WITHOUT_PARTNER[0] && share < WITHOUT_PARTNER[1] {
        let [top, bottom] = faces.without_partner.map(percent);
        let message = format!(
            "{top} % of the top face and {bottom} % of the bottom face of {name} face nothing (plausible: up to {} % of either), as \
             where a body is shifted; correct the places of the bodies, or name the faces that touch alone",
            percent(WITHOUT_PARTNER[0])
        );
        warnings.push(warning(WarningKind::WithoutPartner, share, WITHOUT_PARTNER[0], message));
    }
    warnings
}

/// Where the seat of a bolt is not where the mesh has room for it.
fn of_seat(seat: &SeatFit) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mm = |length: f64| significant((1e7 * length).round() / 1e4);
    let of_scene = format!("structure.mesh.bolts, number {}", seat.bolt);
    if seat.covered < COVERED {
        let message = format!(
            "{of_scene}: {} % of the ring under the {} of bolt {}, {} mm wide, lie on the mesh (plausible: {} % and more); correct its \
             `size` or its `axis`",
            percent(seat.covered),
            seat.side,
            seat.bolt,
            mm(seat.outer),
            percent(COVERED)
        );
        warnings.push(warning(WarningKind::SeatBeyondFace, seat.covered, COVERED, message));
    }
    if let Some(hole) = seat.hole {
        let room = (0.5 * (hole.diameter - seat.shank)).max(OFF_HOLE * seat.shank);
        if hole.offset > room {
            let message = format!(
                "{of_scene}: the axis of bolt {} is {} mm beside the middle of the hole of {} mm under its {} (plausible for a shank of {} mm: up to \
                 {} mm); correct its `axis`",
                seat.bolt,
                mm(hole.offset),
                mm(hole.diameter),
                seat.side,
                mm(seat.shank),
                mm(room)
            );
            warnings.push(warning(WarningKind::BoltOffHole, hole.offset, room, message));
        }
        if hole.diameter < HOLE * seat.shank {
            let message = format!(
                "{of_scene}: bolt {} has a shank of {} mm, and the hole under its {} is {} mm wide; correct its `size`",
                seat.bolt,
                mm(seat.shank),
                seat.side,
                mm(hole.diameter)
            );
            warnings.push(warning(WarningKind::HoleTooNarrow, seat.shank, hole.diameter, message));
        }
    }
    // Once for both.
    let overlapping = |other: &Neighbour| other.bolt < seat.bolt && other.room() < -OVERLAP * other.least;
    if let Some(other) = seat.neighbour.filter(overlapping) {
        let message = format!(
            "{of_scene}: the {} of bolt {} is in the place of that of bolt {}: their axes are {} mm apart, and heads, nuts or washers need {} mm; \
             correct `axis`, `size` or `washers` of either",
            seat.side,
            seat.bolt,
            other.bolt,
            mm(other.distance),
            mm(other.least)
        );
        warnings.push(warning(WarningKind::SeatsOverlap, other.distance, other.least, message));
    }
    warnings
}

fn percent(share: f64) -> String {
    significant((1e3 * share).round() / 10.0)
}

/// What is implausible in the prestressed state and in the modes about it.
pub fn of_results(overview: &Overview, found: &Findings) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut add = |kind, value, limit, message| warnings.push(warning(kind, value, limit, message));
    let pascals = |pressure: f64| format!("{} MPa", significant(1e-6 * pressure));
    if found.peak_pressure <= 0.0 {
        let message =
            "nothing presses the faces together: the pressure is zero everywhere; give the bolts a load".to_owned();
        add(WarningKind::NoPressure, found.peak_pressure, 0.0, message);
    }
    if let Some(hardness) = found.hardness {
        let mean = overview.bolts.nominal_pressure;
        if mean > hardness {
            let message = format!(
                "the bolt loads over the area, {}, exceed the hardness, {}; is the load right?",
                pascals(mean),
                pascals(hardness)
            );
            add(WarningKind::MeanPressure, mean, hardness, message);
        }
        if found.peak_pressure > hardness {
            let message = format!(
                "the pressure is up to {} and exceeds the hardness, {}, on {} % of the area; is the load right?",
                pascals(found.peak_pressure),
                pascals(hardness),
                significant((1e3 * found.share_above_hardness).round() / 10.0)
            );
            add(WarningKind::PeakPressure, found.peak_pressure, hardness, message);
        }
    }
    if let Some(yielded) = found.yielded_asperities.filter(|yielded| *yielded > YIELDED) {
        let message = format!(
            "{} % of the loaded asperities are beyond the onset of yield (limit {} %)",
            significant((1e3 * yielded).round() / 10.0),
            100.0 * YIELDED
        );
        add(WarningKind::YieldedAsperities, yielded, YIELDED, message);
    }
    if found.in_contact < IN_CONTACT {
        let message = format!(
            "only {} % of the interface is in contact under the bolt loads; is the gap right?",
            significant((1e3 * found.in_contact).round() / 10.0)
        );
        add(WarningKind::OpenInterface, found.in_contact, IN_CONTACT, message);
    }
    if let Some(circles) = &found.contact_circles {
        let ContactCircles {
            ratio,
            limit,
            share,
            surface,
            load,
        } = circles;
        let sharp = format!(
            "{surface} makes asperities too sharp, which would need {} times their radii",
            significant((10.0 * (ratio / limit).powi(2)).ceil() / 10.0)
        );
        let cause = match share {
            None => format!("check {surface} and {load}"),
            Some(share) if *share < LOAD_KNOWN => format!(
                "{sharp}; {load} alone does not lead to it, as the formulas hold up to {} % of the pressure",
                percent(*share)
            ),
            Some(share) => format!(
                "{load} is too large for these faces: the formulas hold up to {} % of the pressure; or else {sharp}",
                percent(*share)
            ),
        };
        let message = format!(
            "contact circles of asperities have up to {} of the asperities' radius under a pressure of up to {}, and the contact formulas \
             hold up to {limit}: {cause}",
            significant((100.0 * ratio).round() / 100.0),
            pascals(found.peak_pressure)
        );
        add(WarningKind::ContactCircles, *ratio, *limit, message);
    }
    if let Some(damping) = found.differentiated.filter(|damping| *damping < DIFFERENTIATED) {
        let message = format!(
            "derivatives of damping by other numbers than friction coefficients depend on single bins of asperities below a damping ratio of \
             {DIFFERENTIATED}, and the smallest here is {damping:.1e}; compare runs at two values, or differentiate with \
             interfaces.law.friction = \"lumped\""
        );
        add(WarningKind::DerivativesOfBins, damping, DIFFERENTIATED, message);
    }
    if let Some(twins) = found.nearest.filter(|twins| apart(*twins) < TWINS) {
        let [(mode, frequency), (other, _)] = twins;
        let message = format!(
            "modes {mode} and {other} are twins: their frequencies, {} Hz, differ by {:.0e} of it, so that any mix of their shapes is a mode as well, \
             and damping is that of the mix found; follow both and compare, or model what makes the structure unsymmetric",
            significant(frequency),
            apart(twins)
        );
        add(WarningKind::TwinModes, apart(twins), TWINS, message);
    }
    if let Some((frequency, limit)) = found.first_frequency.and_then(|f| Some((f, beyond(f, FREQUENCIES)?))) {
        let message = format!(
            "the first elastic frequency is {} Hz (plausible: {} to {} Hz); are the units right?",
            significant(frequency),
            FREQUENCIES[0],
            FREQUENCIES[1]
        );
        add(WarningKind::FirstFrequency, frequency, limit, message);
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use joint_model::fit::Fit;
    use joint_model::fit::Hole;
    use joints::structure::{BoltOverview, MaterialOverview};

    fn sound() -> (Overview, Findings) {
        let overview = Overview {
            units: Some("mm, t, s".into()),
            size: Some([0.7, 0.03, 0.03]),
            mass: Some(3.7),
            n_nodes: Some(100),
            n_elements: Some(50),
            interfaces: Vec::new(),
            n_interface_elements: 10,
            interface_area: 3e-3,
            materials: vec![MaterialOverview {
                name: "steel".into(),
                source: "of the scene".into(),
                youngs_modulus: 2e11,
                poisson_ratio: 0.3,
                density: Some(7800.0),
            }],
            surface: "measured".into(),
            bolts: BoltOverview {
                count: 3,
                load_each: 1e4,
                total_load: 3e4,
                nominal_pressure: 1e7,
            },
            tightening: Vec::new(),
            rigid_motions: 6,
            fit: Fit::default(),
        };
        let findings = Findings {
            hardness: Some(9e9),
            peak_pressure: 3e7,
            share_above_hardness: 0.0,
            yielded_asperities: Some(0.02),
            in_contact: 0.9,
            first_frequency: Some(170.0),
            contact_circles: None,
            differentiated: None,
            nearest: Some([(1, 170.0), (2, 210.0)]),
        };
        (overview, findings)
    }

    /// Kind, value and limit of the only warning of a case.
    fn only(change: impl Fn(&mut Overview, &mut Findings)) -> (WarningKind, f64, f64) {
        let (mut overview, mut findings) = sound();
        change(&mut overview, &mut findings);
        let mut all = of_input(&overview);
        all.extend(of_results(&overview, &findings));
        let [warning] = all.as_slice() else {
            panic!("{all:?}");
        };
        (warning.kind, warning.value, warning.limit)
    }

    #[test]
    fn each_implausible_figure_has_its_warning_and_sound_ones_have_none() {
        use WarningKind as K;
        let (overview, findings) = sound();
        assert!(of_input(&overview).is_empty() && of_results(&overview, &findings).is_empty());
        assert_eq!(only(|o, _| o.size = Some([700.0, 30.0, 30.0])), (K::Size, 700.0, 20.0));
        assert_eq!(only(|o, _| o.size = Some([7e-4, 3e-5, 3e-5])), (K::Size, 7e-4, 1e-3));
        assert_eq!(
            only(|o, _| o.materials[0].density = Some(7.8e-9)),
            (K::Density, 7.8e-9, 500.0)
        );
        assert_eq!(
            only(|o, _| o.materials[0].density = Some(7.8e6)),
            (K::Density, 7.8e6, 25e3)
        );
        assert_eq!(
            only(|o, _| o.materials[0].youngs_modulus = 2e5),
            (K::YoungsModulus, 2e5, 1e9)
        );
        assert_eq!(
            only(|o, _| o.materials[0].youngs_modulus = 2e14),
            (K::YoungsModulus, 2e14, 1.5e12)
        );
        assert_eq!(
            only(|o, _| o.materials[0].poisson_ratio = 0.499_99),
            (K::PoissonRatio, 0.499_99, 0.4999)
        );
        assert_eq!(only(|_, f| f.peak_pressure = 0.0), (K::NoPressure, 0.0, 0.0));
        assert_eq!(
            only(|o, _| o.bolts.nominal_pressure = 1e10),
            (K::MeanPressure, 1e10, 9e9)
        );
        assert_eq!(only(|_, f| f.peak_pressure = 2.7e10), (K::PeakPressure, 2.7e10, 9e9));
        assert_eq!(
            only(|_, f| f.yielded_asperities = Some(0.2)),
            (K::YieldedAsperities, 0.2, 0.1)
        );
        assert_eq!(only(|_, f| f.in_contact = 0.4), (K::OpenInterface, 0.4, 0.5));
        assert_eq!(
            only(|_, f| f.differentiated = Some(1e-4)),
            (K::DerivativesOfBins, 1e-4, 1e-2)
        );
        let (kind, value, limit) = only(|_, f| f.nearest = Some([(3, 200.0), (2, 199.9)]));
        assert_eq!((kind, limit), (K::TwinModes, 1e-3));
        assert!((value - 5e-4).abs() < 1e-12);
        assert_eq!(
            only(|_, f| f.first_frequency = Some(0.44)),
            (K::FirstFrequency, 0.44, 1.0)
        );
        assert_eq!(
            only(|_, f| f.first_frequency = Some(2e5)),
            (K::FirstFrequency, 2e5, 1e5)
        );
    }

    #[test]
    fn the_nearest_neighbour_of_the_modes_followed_is_found() {
        let frequencies = [100.0, 150.0, 151.0, 300.0];
        let nearest = |followed: &[usize]| nearest(&frequencies, followed.iter().copied());
        assert_eq!(nearest(&[1]), Some([(1, 100.0), (2, 150.0)]));
        assert_eq!(nearest(&[1, 3]), Some([(3, 151.0), (2, 150.0)]));
        assert_eq!(nearest(&[4]), Some([(4, 300.0), (3, 151.0)]));
        assert_eq!(nearest(&[]), None);
    }

    #[test]
    fn geometry_that_contradicts_the_scene_has_its_warning() {
        use WarningKind as K;
        let faces = |change: fn(&mut FacesFit)| {
            only(|o, _| {
                let mut faces = FacesFit {
                    named: true,
                    ..FacesFit::default()
                };
                change(&mut faces);
                o.fit.faces.push(faces);
            })
        };
        assert_eq!(
            faces(|f| (f.distance, f.distance_size) = (1e-4, 1e-4)),
            (K::FacesApart, 1e-4, 20e-6)
        );
        // Half of it deep, half of it wide: no mean, and yet not upon one another.
        assert_eq!(
            faces(|f| (f.distance, f.distance_size) = (-1e-6, 1e-4)),
            (K::FacesApart, -1e-4, 20e-6)
        );
        assert_eq!(
            faces(|f| (f.curved, f.distance, f.distance_size) = (true, -1e-4, 1e-4)),
            (K::FacesApart, -1e-4, 20e-6)
        );
        assert_eq!(
            faces(|f| f.without_partner = [0.5, 0.04]),
            (K::WithoutPartner, 0.04, 0.01)
        );
        let seat = |change: fn(&mut SeatFit)| {
            only(|o, _| {
                let mut seat = sound_seat();
                change(&mut seat);
                o.fit.seats.push(seat);
            })
        };
        assert_eq!(seat(|s| s.covered = 0.7), (K::SeatBeyondFace, 0.7, 0.8));
        let hole = |diameter, offset| Some(Hole { diameter, offset });
        let off = seat(|s| {
            s.hole = Some(Hole {
                diameter: 9e-3,
                offset: 2e-3,
            })
        });
        assert!(
            off.0 == K::BoltOffHole && off.1 == 2e-3 && (off.2 - 0.5e-3).abs() < 1e-12,
            "{off:?}"
        );
        assert_eq!(
            seat(|s| s.hole = Some(Hole {
                diameter: 5e-3,
                offset: 0.0
            })),
            (K::HoleTooNarrow, 8e-3, 5e-3)
        );
        let neighbour = |bolt, distance| {
            Some(Neighbour {
                bolt,
                distance,
                least: 16e-3,
            })
        };
        assert_eq!(
            only(|o, _| o.fit.seats.push(SeatFit {
                neighbour: neighbour(1, 15e-3),
                ..sound_seat()
            })),
            (K::SeatsOverlap, 15e-3, 16e-3)
        );
        // What is sound: arcs of curved faces, whole faces of plates that overlap in part, a small face on a large one, faces that were
        // found, round-off of a hole without play, and the other of two seats.
        let (mut overview, _) = sound();
        let sound_faces = [
            (true, true, [0.0, 0.0], [1e-6, 1e-4]),
            (true, false, [0.33, 0.33], [0.0, 0.0]),
            (true, false, [0.0, 0.9], [0.0, 0.0]),
            (false, false, [0.04, 0.04], [0.0, 0.0]),
        ];
        overview.fit.faces = sound_faces
            .map(|(named, curved, without_partner, [distance, distance_size])| FacesFit {
                named,
                curved,
                without_partner,
                distance,
                distance_size,
                ..FacesFit::default()
            })
            .into();
        let holes = [
            (hole(8e-3, 0.1e-3), None),
            (hole(9e-3, 0.4e-3), neighbour(3, 15e-3)),
            (None, neighbour(1, 16e-3)),
        ];
        overview.fit.seats = holes
            .map(|(hole, neighbour)| SeatFit {
                hole,
                neighbour,
                ..sound_seat()
            })
            .into();
        assert_eq!(of_input(&overview), []);
    }

    fn sound_seat() -> SeatFit {
        SeatFit {
            bolt: 2,
            side: "head".into(),
            outer: 16e-3,
            shank: 8e-3,
            covered: 0.95,
            hole: None,
            neighbour: None,
        }
    }

    #[test]
    fn contact_circles_are_put_down_to_the_input_that_leads_to_them() {
        let message = |share| {
            let (overview, mut findings) = sound();
            findings.contact_circles = Some(ContactCircles {
                ratio: 0.82,
                limit: 0.41,
                share,
                surface: "interfaces.surface.finish".into(),
                load: "bolts.torque",
            });
            let [warning] = &of_results(&overview, &findings)[..] else {
                panic!("one warning");
            };
            assert_eq!(
                (warning.kind, warning.value, warning.limit),
                (WarningKind::ContactCircles, 0.82, 0.41)
            );
            warning.message.clone()
        };
        let sharp = message(Some(0.2));
        assert!(
            sharp.contains("0.41: interfaces.surface.finish makes asperities too sharp, which would need 4 times")
                && sharp.contains("20 %")
        );
        let heavy = message(Some(0.7));
        assert!(
            heavy.contains("0.41: bolts.torque is too large") && heavy.contains("70 %"),
            "{heavy}"
        );
        assert!(message(None).contains("check interfaces.surface.finish and bolts.torque"));
    }

    #[test]
    fn numbers_have_five_digits_and_no_idle_zeros() {
        let texts = [0.0, 12.0, 3.701_94, 1.0 / 3.0, 7.857_812e3, 2e-9, 1.5e12, -0.25].map(significant);
        assert_eq!(
            texts,
            ["0", "12", "3.7019", "0.33333", "7857.8", "2e-9", "1.5e12", "-0.25"]
        );
    }
}
