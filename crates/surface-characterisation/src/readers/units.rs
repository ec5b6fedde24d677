//! Units of length, and who states them.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A unit of length that files or users state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "String", into = "&str")
)]
pub enum LengthUnit {
    /// m.
    Metre,
    /// cm.
    Centimetre,
    /// mm.
    Millimetre,
    /// um.
    Micrometre,
    /// nm.
    Nanometre,
    /// pm.
    Picometre,
    /// Angstrom, 0.1 nm.
    Angstrom,
    /// in.
    Inch,
}

impl LengthUnit {
    /// Its symbol, in ASCII.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Micrometre => "um",
            Self::Nanometre => "nm",
            Self::Picometre => "pm",
            Self::Angstrom => "angstrom",
            Self::Inch => "in",
        }
    }

    /// `value` of this unit in metres. Powers of ten divide, since they are exact and their inverses are not.
    pub fn metres(self, value: f64) -> f64 {
        match self {
            Self::Metre => value,
            Self::Centimetre => value / 1e2,
            Self::Millimetre => value / 1e3,
            Self::Micrometre => value / 1e6,
            Self::Nanometre => value / 1e9,
            Self::Picometre => value / 1e12,
            Self::Angstrom => value / 1e10,
            Self::Inch => value * 0.0254,
        }
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

#[cfg(feature = "serde")]
impl TryFrom<String> for LengthUnit {
    type Error = UnknownUnit;

    fn try_from(text: String) -> Result<Self, UnknownUnit> {
        text.parse()
    }
}

#[cfg(feature = "serde")]
impl From<LengthUnit> for &str {
    fn from(unit: LengthUnit) -> Self {
        unit.symbol()
    }
}

impl FromStr for LengthUnit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        Ok(match text.trim_matches(|c: char| c.is_whitespace() || c == '\0') {
            "m" | "metre" | "metres" | "meter" | "meters" => Self::Metre,
            "cm" => Self::Centimetre,
            "mm" => Self::Millimetre,
            // The micro sign, the Greek letter, and the micro sign of code page 850 taken for Latin-1.
            "um" | "\u{b5}m" | "\u{3bc}m" | "\u{e6}m" | "micron" | "microns" => Self::Micrometre,
            "nm" => Self::Nanometre,
            "pm" => Self::Picometre,
            "angstrom" | "\u{c5}" | "\u{212b}" => Self::Angstrom,
            "in" | "inch" | "inches" => Self::Inch,
            _ => return Err(UnknownUnit { found: text.into() }),
        })
    }
}

/// Text that names no unit of length.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("`{}` is no unit of length; use m, cm, mm, um, nm, pm, angstrom or in", found.escape_debug())]
pub struct UnknownUnit {
    /// The text.
    pub found: String,
}

/// A unit, and who stated it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Declaration {
    /// The file, or its format.
    File(LengthUnit),
    /// The caller.
    Caller(LengthUnit),
}

impl Declaration {
    /// The unit.
    pub fn unit(self) -> LengthUnit {
        match self {
            Self::File(unit) | Self::Caller(unit) => unit,
        }
    }
}

impl fmt::Display for Declaration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(unit) => write!(f, "{unit} (by the file)"),
            Self::Caller(unit) => write!(f, "{unit} (as passed)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_their_spellings() {
        for unit in [
            LengthUnit::Metre,
            LengthUnit::Centimetre,
            LengthUnit::Millimetre,
            LengthUnit::Micrometre,
            LengthUnit::Nanometre,
            LengthUnit::Picometre,
            LengthUnit::Angstrom,
            LengthUnit::Inch,
        ] {
            assert_eq!(unit.symbol().parse(), Ok(unit));
        }
        assert_eq!(" \u{b5}m\0".parse(), Ok(LengthUnit::Micrometre));
        assert!("M".parse::<LengthUnit>().unwrap_err().to_string().contains("`M`"));
        // The double next to the decimal number, which a product with 1e-6 misses.
        assert_eq!(LengthUnit::Micrometre.metres(1.1), 1.1e-6);
        assert_eq!(LengthUnit::Inch.metres(1.0), 0.0254);
    }
}
