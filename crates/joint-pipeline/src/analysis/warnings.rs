//! What is implausible in the input or the results of a run: warnings, not errors.

use crate::structure::{Overview, significant};
use serde::{Deserialize, Serialize};

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
#[derive(Clone, Copy, Debug, PartialEq)]
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
    }
    warnings
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
    use crate::structure::{BoltOverview, MaterialOverview};

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
        };
        let findings = Findings {
            hardness: Some(9e9),
            peak_pressure: 3e7,
            share_above_hardness: 0.0,
            yielded_asperities: Some(0.02),
            in_contact: 0.9,
            first_frequency: Some(170.0),
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
            only(|_, f| f.first_frequency = Some(0.44)),
            (K::FirstFrequency, 0.44, 1.0)
        );
        assert_eq!(
            only(|_, f| f.first_frequency = Some(2e5)),
            (K::FirstFrequency, 2e5, 1e5)
        );
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
