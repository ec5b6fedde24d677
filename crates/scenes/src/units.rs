//! Units of scenes, and quantities that are converted to SI while they are read.
//!
//! A quantity of a scene is a number in the units of the scene, or a text with a unit of its own such as `"12.8 kN"`. Either
//! becomes SI when it is deserialised, so that a field cannot be read without being converted.

use crate::scoped;
use serde::de::{Error as _, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cell::RefCell;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Div, Mul};

/// A unit: its symbol, and its size in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As scenes write it.
    pub symbol: &'static str,
    /// One of it in SI.
    pub si: f64,
}

const fn unit(symbol: &'static str, si: f64) -> Unit {
    Unit { symbol, si }
}

/// Standard acceleration of gravity (m/s^2), which also defines the pound-force.
const GRAVITY: f64 = 9.80665;
/// Avoirdupois pound (kg).
const POUND: f64 = 0.453_592_37;
/// Inch (m).
const INCH: f64 = 0.0254;
/// Pound-force (N).
const POUND_FORCE: f64 = POUND * GRAVITY;
/// Mass that a pound-force accelerates by one inch per second squared (kg).
const SLINCH: f64 = POUND_FORCE / INCH;

const LENGTHS: [Unit; 10] = [
    unit("m", 1.0),
    unit("cm", 1e-2),
    unit("mm", 1e-3),
    unit("um", 1e-6),
    unit("µm", 1e-6),
    unit("nm", 1e-9),
    unit("in", INCH),
    unit("ft", 12.0 * INCH),
    unit("mil", 1e-3 * INCH),
    unit("km", 1e3),
];
const MASSES: [Unit; 7] = [
    unit("kg", 1.0),
    unit("g", 1e-3),
    unit("t", 1e3),
    unit("lb", POUND),
    unit("slinch", SLINCH),
    unit("lbf*s^2/in", SLINCH),
    unit("slug", 12.0 * SLINCH),
];
const TIMES: [Unit; 1] = [unit("s", 1.0)];
const FORCES: [Unit; 6] = [
    unit("N", 1.0),
    unit("mN", 1e-3),
    unit("kN", 1e3),
    unit("MN", 1e6),
    unit("lbf", POUND_FORCE),
    unit("kip", 1e3 * POUND_FORCE),
];
const TORQUES: [Unit; 9] = [
    unit("N m", 1.0),
    unit("Nm", 1.0),
    unit("N mm", 1e-3),
    unit("kN m", 1e3),
    unit("kN mm", 1.0),
    unit("lbf ft", 12.0 * INCH * POUND_FORCE),
    unit("ft lbf", 12.0 * INCH * POUND_FORCE),
    unit("lbf in", INCH * POUND_FORCE),
    unit("in lbf", INCH * POUND_FORCE),
];
const STRESSES: [Unit; 7] = [
    unit("Pa", 1.0),
    unit("kPa", 1e3),
    unit("MPa", 1e6),
    unit("GPa", 1e9),
    unit("N/mm^2", 1e6),
    unit("psi", POUND_FORCE / (INCH * INCH)),
    unit("ksi", 1e3 * POUND_FORCE / (INCH * INCH)),
];
const AREAS: [Unit; 4] = [
    unit("m^2", 1.0),
    unit("cm^2", 1e-4),
    unit("mm^2", 1e-6),
    unit("in^2", INCH * INCH),
];
const AREAL_DENSITIES: [Unit; 3] = [
    unit("1/m^2", 1.0),
    unit("1/mm^2", 1e6),
    unit("1/in^2", 1.0 / (INCH * INCH)),
];
const DENSITIES: [Unit; 5] = [
    unit("kg/m^3", 1.0),
    unit("g/cm^3", 1e3),
    unit("t/mm^3", 1e12),
    unit("lb/in^3", POUND / (INCH * INCH * INCH)),
    unit("slinch/in^3", SLINCH / (INCH * INCH * INCH)),
];
const CONTACT_STIFFNESSES: [Unit; 6] = [
    unit("Pa/m", 1.0),
    unit("MPa/m", 1e6),
    unit("GPa/m", 1e9),
    unit("N/mm^3", 1e9),
    unit("MPa/mm", 1e9),
    unit("psi/in", POUND_FORCE / (INCH * INCH * INCH)),
];

const ACCELERATIONS: [Unit; 4] = [
    unit("m/s^2", 1.0),
    unit("mm/s^2", 1e-3),
    unit("g", GRAVITY),
    unit("in/s^2", INCH),
];
const ACCELERATION_DENSITIES: [Unit; 3] = [
    unit("(m/s^2)^2/Hz", 1.0),
    unit("(mm/s^2)^2/Hz", 1e-6),
    unit("g^2/Hz", GRAVITY * GRAVITY),
];
const FORCE_DENSITIES: [Unit; 2] = [unit("N^2/Hz", 1.0), unit("lbf^2/Hz", POUND_FORCE * POUND_FORCE)];
const MODAL_AMPLITUDES: [Unit; 2] = [unit("sqrt(kg) m", 1.0), unit("sqrt(t) mm", 0.031_622_776_601_683_79)];
const UNBALANCES: [Unit; 5] = [
    unit("kg m", 1.0),
    unit("kg mm", 1e-3),
    unit("g mm", 1e-6),
    unit("g cm", 1e-5),
    unit("lb in", POUND * INCH),
];
const SURFACE_ENERGIES: [Unit; 3] = [unit("J/m^2", 1.0), unit("mJ/m^2", 1e-3), unit("N/m", 1.0)];

/// What a quantity measures.
pub trait Dimension {
    /// In messages.
    const NAME: &'static str;
    /// Powers of length, mass and time.
    const POWERS: [i32; 3];
    /// Whether the square root of the mass is a further factor.
    const ROOT_OF_MASS: bool = false;
    /// Units that a text may name, the SI unit first.
    const UNITS: &'static [Unit];
}

/// Defines dimensions, each with the name of its quantity.
macro_rules! dimensions {
    ($($(#[$doc:meta])* $quantity:ident, $dimension:ident, $name:literal, $powers:expr, $units:expr $(, $item:ident = $value:expr)?;)*) => {
        /// The dimensions themselves, as parameters of [`Quantity`](super::Quantity).
        pub mod dimension {
            $($(#[$doc])* #[derive(Clone, Copy, Debug, PartialEq)] pub enum $dimension {})*
        }
        $(
            impl Dimension for dimension::$dimension {
                const NAME: &'static str = $name;
                const POWERS: [i32; 3] = $powers;
                const UNITS: &'static [Unit] = &$units;
                $(const $item: bool = $value;)?
            }
            $(#[$doc])*
            pub type $quantity = Quantity<dimension::$dimension>;
        )*

        /// The SI unit of each dimension.
        pub(super) const SI_SYMBOLS: &[&str] = &[$(<dimension::$dimension as Dimension>::UNITS[0].symbol),*];
    };
}

dimensions! {
    /// Length (m).
    Length, OfLength, "length", [1, 0, 0], LENGTHS;
    /// Area (m^2).
    Area, OfArea, "area", [2, 0, 0], AREAS;
    /// Mass (kg).
    Mass, OfMass, "mass", [0, 1, 0], MASSES;
    /// Force (N).
    Force, OfForce, "force", [1, 1, -2], FORCES;
    /// Torque (N m).
    Torque, OfTorque, "torque", [2, 1, -2], TORQUES;
    /// Stress, pressure or modulus (Pa).
    Stress, OfStress, "stress", [-1, 1, -2], STRESSES;
    /// Density (kg/m^3).
    Density, OfDensity, "density", [-3, 1, 0], DENSITIES;
    /// Stiffness per area (Pa/m).
    ContactStiffness, OfContactStiffness, "stiffness per area", [-2, 1, -2], CONTACT_STIFFNESSES;
    /// Number per area (1/m^2).
    ArealDensity, OfArealDensity, "number per area", [-2, 0, 0], AREAL_DENSITIES;
    /// Energy per area (J/m^2).
    SurfaceEnergy, OfSurfaceEnergy, "energy per area", [0, 1, -2], SURFACE_ENERGIES;
    /// Acceleration (m/s^2).
    Acceleration, OfAcceleration, "acceleration", [1, 0, -2], ACCELERATIONS;
    /// Power spectral density of an acceleration ((m/s^2)^2/Hz).
    AccelerationDensity, OfAccelerationDensity, "spectral density of acceleration", [2, 0, -3], ACCELERATION_DENSITIES;
    /// Power spectral density of a force (N^2/Hz).
    ForceDensity, OfForceDensity, "spectral density of force", [2, 2, -3], FORCE_DENSITIES;
    /// Unbalance: a mass times its distance from the axis that it turns about (kg m).
    Unbalance, OfUnbalance, "unbalance", [1, 1, 0], UNBALANCES;
    /// Amplitude of a mass-normalised mode (sqrt(kg) m).
    ModalAmplitude, OfModalAmplitude, "modal amplitude", [1, 0, 0], MODAL_AMPLITUDES, ROOT_OF_MASS = true;
}

/// A quantity of a scene, in SI.
pub struct Quantity<D>(f64, PhantomData<fn() -> D>);

impl<D> Quantity<D> {
    /// From its value in SI.
    pub const fn from_si(value: f64) -> Self {
        Self(value, PhantomData)
    }

    /// Its value in SI.
    pub const fn si(self) -> f64 {
        self.0
    }
}

impl<D: Dimension> Quantity<D> {
    /// Symbol of its SI unit.
    pub const SI_SYMBOL: &'static str = D::UNITS[0].symbol;

    /// From a number in the units of the file that is being read.
    pub fn in_units(number: f64) -> Self {
        let units = Units::in_use();
        let root = if D::ROOT_OF_MASS {
            units.mass_in_si().sqrt()
        } else {
            1.0
        };
        Self::from_si(number * units.size(D::POWERS) * root)
    }

    /// The text that scenes in any units read as this quantity, bit by bit.
    pub fn text(self) -> String {
        format!("{self:?}")
    }
}

// Derived implementations would ask the same of the dimension.
impl<D> Clone for Quantity<D> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D> Copy for Quantity<D> {}

impl<D> PartialEq for Quantity<D> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

impl<D> Mul<f64> for Quantity<D> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self::from_si(self.0 * factor)
    }
}

impl<D> Div<f64> for Quantity<D> {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        Self::from_si(self.0 / divisor)
    }
}

impl<D> Default for Quantity<D> {
    fn default() -> Self {
        Self::from_si(0.0)
    }
}

impl<D: Dimension> fmt::Debug for Quantity<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} {}", self.0, D::UNITS[0].symbol)
    }
}

/// Written as a number in SI.
impl<D> Serialize for Quantity<D> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.0)
    }
}

impl<'de, D: Dimension> Deserialize<'de> for Quantity<D> {
    fn deserialize<R: Deserializer<'de>>(deserializer: R) -> Result<Self, R::Error> {
        deserializer.deserialize_any(NumberOrText(PhantomData))
    }
}

struct NumberOrText<D>(PhantomData<fn() -> D>);

impl<D: Dimension> Visitor<'_> for NumberOrText<D> {
    type Value = Quantity<D>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a {} as a number in the scene's units or as a text such as \"1 {}\"",
            D::NAME,
            D::UNITS[0].symbol
        )
    }

    fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Quantity<D>, E> {
        Ok(Quantity::in_units(number))
    }

    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Quantity<D>, E> {
        self.visit_f64(number as f64)
    }

    fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Quantity<D>, E> {
        self.visit_f64(number as f64)
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Quantity<D>, E> {
        let end = text.find(char::is_whitespace).unwrap_or(text.len());
        let (number, symbol) = (&text[..end], text[end..].trim());
        let refuse = || {
            let symbols: Vec<&str> = D::UNITS.iter().map(|unit| unit.symbol).collect();
            E::custom(format!(
                "`{text}` is not a {}; write a number, a space and one of the units {}",
                D::NAME,
                symbols.join(", ")
            ))
        };
        let number: f64 = number.parse().map_err(|_| refuse())?;
        let unit = D::UNITS.iter().find(|unit| unit.symbol == symbol).ok_or_else(refuse)?;
        Ok(Quantity::from_si(number * unit.si))
    }
}

/// Units of the numbers of a file: length, mass or force, and time. The unit that is not given follows: force is mass times
/// length per time squared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    length: Unit,
    inertia: Inertia,
    time: Unit,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Inertia {
    Mass(Unit),
    Force(Unit),
}

impl Units {
    /// Metre, kilogram, second.
    pub const SI: Self = Self {
        length: LENGTHS[0],
        inertia: Inertia::Mass(MASSES[0]),
        time: TIMES[0],
    };

    /// Unit of length (m).
    pub fn length_in_si(&self) -> f64 {
        self.length.si
    }

    /// Unit of mass (kg).
    pub fn mass_in_si(&self) -> f64 {
        match self.inertia {
            Inertia::Mass(unit) => unit.si,
            Inertia::Force(unit) => unit.si * self.time.si * self.time.si / self.length.si,
        }
    }

    /// Size in SI of the unit with these powers of length, mass and time.
    fn size(&self, [length, mass, time]: [i32; 3]) -> f64 {
        // Powers of 1 are exact, so that SI stays as it is written.
        self.length.si.powi(length) * self.mass_in_si().powi(mass) * self.time.si.powi(time)
    }

    /// Runs `read` with numbers of quantities in these units.
    pub fn scope<T>(self, read: impl FnOnce() -> T) -> T {
        scoped::with(&IN_USE, self, read)
    }

    /// The units of the innermost [`Units::scope`] on this thread; SI outside of any.
    pub fn in_use() -> Self {
        IN_USE.with_borrow(|units| *units)
    }
}

thread_local! {
    static IN_USE: RefCell<Units> = const { RefCell::new(Units::SI) };
}

impl Default for Units {
    /// SI.
    fn default() -> Self {
        Self::SI
    }
}

/// The fields of [`Units`] as they stand in a file.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct Symbols {
    /// Unit of length.
    length: String,
    /// Unit of mass; either this or `force` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mass: Option<String>,
    /// Unit of force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    force: Option<String>,
    /// Unit of time.
    time: String,
}

impl Serialize for Units {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (mass, force) = match self.inertia {
            Inertia::Mass(unit) => (Some(unit.symbol.to_owned()), None),
            Inertia::Force(unit) => (None, Some(unit.symbol.to_owned())),
        };
        Symbols {
            length: self.length.symbol.to_owned(),
            mass,
            force,
            time: self.time.symbol.to_owned(),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Units {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let symbols = Symbols::deserialize(deserializer)?;
        let find = |what: &str, symbol: &str, known: &[Unit]| {
            known.iter().find(|unit| unit.symbol == symbol).copied().ok_or_else(|| {
                let all: Vec<&str> = known.iter().map(|unit| unit.symbol).collect();
                D::Error::custom(format!(
                    "`{symbol}` is not a unit of {what}; there are {}",
                    all.join(", ")
                ))
            })
        };
        let inertia = match (&symbols.mass, &symbols.force) {
            (Some(mass), None) => Inertia::Mass(find("mass", mass, &MASSES)?),
            (None, Some(force)) => Inertia::Force(find("force", force, &FORCES)?),
            (None, None) => return Err(D::Error::missing_field("mass")),
            (Some(_), Some(_)) => {
                return Err(D::Error::custom(
                    "units of mass and of force are both given; leave one of them out, it follows from the other",
                ));
            }
        };
        Ok(Self {
            length: find("length", &symbols.length, &LENGTHS)?,
            inertia,
            time: find("time", &symbols.time, &TIMES)?,
        })
    }
}

#[cfg(feature = "schema")]
mod schema {
    use super::{Dimension, Quantity, Symbols, Units};
    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
    use std::borrow::Cow;

    impl<D: Dimension> JsonSchema for Quantity<D> {
        fn inline_schema() -> bool {
            true
        }

        fn schema_name() -> Cow<'static, str> {
            D::NAME.into()
        }

        fn json_schema(_: &mut SchemaGenerator) -> Schema {
            let symbols: Vec<&str> = D::UNITS.iter().map(|unit| unit.symbol).collect();
            json_schema!({
                "type": ["number", "string"],
                "description": format!(
                    "A {} in the scene's units, or a text with a number and one of the units {}.",
                    D::NAME,
                    symbols.join(", ")
                ),
            })
        }
    }

    impl JsonSchema for Units {
        fn schema_name() -> Cow<'static, str> {
            "Units".into()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            Symbols::json_schema(generator)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<T: for<'de> Deserialize<'de>>(units: &str, value: &str) -> Result<T, String> {
        let units: Units = serde_json::from_str(units).map_err(|e| e.to_string())?;
        units.scope(|| serde_json::from_str(value).map_err(|e| e.to_string()))
    }

    #[test]
    fn numbers_are_in_the_units_of_the_file() {
        let millimetres = r#"{"length": "mm", "mass": "t", "time": "s"}"#;
        assert_eq!(read::<Length>(millimetres, "2.5").unwrap().si(), 2.5e-3);
        assert_eq!(read::<Force>(millimetres, "3").unwrap().si(), 3.0);
        assert!((read::<Stress>(millimetres, "192850").unwrap().si() / 192.85e9 - 1.0).abs() < 1e-15);
        assert!((read::<Density>(millimetres, "7.8578e-9").unwrap().si() / 7857.8 - 1.0).abs() < 1e-15);
        let si = r#"{"length": "m", "mass": "kg", "time": "s"}"#;
        assert_eq!(read::<ContactStiffness>(si, "1e13").unwrap().si(), 1e13);
    }

    #[test]
    fn inches_and_pounds_force_are_consistent() {
        let by_force = r#"{"length": "in", "force": "lbf", "time": "s"}"#;
        let by_mass = r#"{"length": "in", "mass": "lbf*s^2/in", "time": "s"}"#;
        for units in [by_force, by_mass] {
            // 28 Mpsi and 0.283 lb/in^3 are common figures of steel.
            let modulus: Stress = read(units, "28e6").unwrap();
            assert!((modulus.si() / 193.053e9 - 1.0).abs() < 1e-5, "{modulus:?}");
            let density: Density = read(units, "7.324e-4").unwrap();
            assert!((density.si() / 7827.0 - 1.0).abs() < 1e-3, "{density:?}");
            let load: Force = read(units, "1000").unwrap();
            assert!((load.si() / 4_448.221_615_260_5 - 1.0).abs() < 1e-14, "{load:?}");
        }
    }

    #[test]
    fn texts_have_units_of_their_own() {
        let inches = r#"{"length": "in", "force": "lbf", "time": "s"}"#;
        assert_eq!(read::<Force>(inches, r#""12.5 kN""#).unwrap().si(), 12_500.0);
        assert_eq!(read::<Length>(inches, r#""3 um""#).unwrap().si(), 3e-6);
        let wrong = read::<Force>(inches, r#""12.5 mm""#).unwrap_err();
        assert!(wrong.contains("not a force") && wrong.contains("kN"), "{wrong}");
        let torque: Torque = read(inches, r#""15 lbf ft""#).unwrap();
        assert!((torque.si() / 20.337_269 - 1.0).abs() < 1e-7, "{torque:?}");
        assert_eq!(read::<Torque>(inches, r#""20 N m""#).unwrap().si(), 20.0);
        // Numbers are lbf in.
        assert!((read::<Torque>(inches, "180").unwrap().si() / torque.si() - 1.0).abs() < 1e-14);
        assert!(read::<Torque>(inches, r#""20 N""#).unwrap_err().contains("lbf ft"));
        assert!(read::<Length>(inches, r#""twelve mm""#).is_err());
        assert!(read::<Length>(inches, r#""12""#).is_err(), "a text without a unit");
    }

    #[test]
    fn units_are_known_and_complete() {
        let refused = |units: &str| read::<Length>(units, "1").unwrap_err();
        assert!(refused(r#"{"length": "parsec", "mass": "kg", "time": "s"}"#).contains("parsec"));
        assert!(refused(r#"{"length": "m", "time": "s"}"#).contains("mass"));
        assert!(refused(r#"{"length": "m", "mass": "kg", "force": "N", "time": "s"}"#).contains("both"));
    }

    #[test]
    fn what_is_written_is_si_and_reads_back() {
        let length = Length::from_si(0.1 + 0.2);
        let text = serde_json::to_string(&length).unwrap();
        assert_eq!(serde_json::from_str::<Length>(&text).unwrap(), length);
        let units: Units = serde_json::from_str(r#"{"length": "in", "force": "lbf", "time": "s"}"#).unwrap();
        let again: Units = serde_json::from_str(&serde_json::to_string(&units).unwrap()).unwrap();
        assert_eq!(again, units);
    }
}
