//! Fields of points and cells, and how they are written.

/// Name of the cell array with the material numbers.
pub const MATERIAL: &str = "material";

/// Numbers at points or cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name.
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    /// `values[components * i + c]` at point or cell `i`.
    pub values: Vec<f64>,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As text, with as many digits as it takes to read the same numbers.
    Ascii,
    /// As base64.
    Base64,
}
