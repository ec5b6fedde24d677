//! Errors of this crate.

/// What can be wrong with a geometry, a refinement, a material or a load.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A quantity is outside its admissible range.
    #[error("{place}: {field} = {} is not admissible; it must be {requirement}", format!("{value} {unit}").trim_end())]
    Value {
        /// What the quantity belongs to.
        place: &'static str,
        /// Name of the quantity.
        field: &'static str,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// The material or the mesh is refused by the finite elements.
    #[error(transparent)]
    Material(#[from] finite_elements::Error),
    /// Two lengths do not fit together.
    #[error("{place}: {smaller} = {smaller_value} m must be less than {larger} = {larger_value} m; change one of them")]
    Misfit {
        /// What the lengths belong to.
        place: &'static str,
        /// The length that should be the smaller one.
        smaller: &'static str,
        /// Its value (m).
        smaller_value: f64,
        /// The length that should be the larger one.
        larger: &'static str,
        /// Its value (m).
        larger_value: f64,
    },
    /// A number of elements is outside its admissible range.
    #[error("refinement: {field} = {value} is not admissible; it must be {requirement}")]
    Count {
        /// Name of the count.
        field: &'static str,
        /// Its value.
        value: usize,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// No mild grading fills the length.
    #[error(
        "{place}: {layers} layers from {first} m cannot fill {length} m with a ratio between {least} and {greatest}; \
         change the number of layers or the first layer"
    )]
    Grading {
        /// What is graded.
        place: &'static str,
        /// Number of layers.
        layers: usize,
        /// Thickness of the first layer (m).
        first: f64,
        /// Length to fill (m).
        length: f64,
        /// Least ratio of neighbouring layers.
        least: f64,
        /// Greatest ratio of neighbouring layers.
        greatest: f64,
    },
    /// An element came out inverted or degenerate.
    #[error(
        "{part}, element {element}: least Jacobian determinant {determinant:e} m^3 is not positive; \
         the refinement is too coarse for this geometry"
    )]
    InvertedElement {
        /// Name of the part.
        part: String,
        /// Element number in the mesh.
        element: usize,
        /// Least determinant over corners and Gauss points (m^3).
        determinant: f64,
    },
    /// A beam that has no half.
    #[error(
        "node {node} at {position:?} m has no mirror image beyond the plane y = 0; mesh the beam symmetrically about it, or \
         take the whole beam"
    )]
    NotSymmetric {
        /// Node.
        node: u32,
        /// Its position (m).
        position: [f64; 3],
    },
}
