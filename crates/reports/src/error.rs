//! Errors of this crate.

use plotters::drawing::DrawingAreaErrorKind;

/// Why the drawing library refuses.
pub type Drawing = DrawingAreaErrorKind<std::io::Error>;

/// Why a document cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A picture could not be drawn.
    #[error("drawing {picture}")]
    Picture {
        /// What it shows.
        picture: &'static str,
        /// Why it failed.
        source: Drawing,
    },
    /// A picture could not be written as PDF.
    #[error("a PDF cannot show {what}")]
    Pdf {
        /// What it cannot show, and the remedy if there is one.
        what: String,
    },
    /// An interface covers itself seen along its mean normal.
    #[error(
        "the interface of {name} is so curved that it covers itself in a map; show its fields in ParaView (interface-*.vtu)"
    )]
    Folded {
        /// The run.
        name: String,
    },
    /// Fields of the interface could not be written as a VTK file.
    #[error("encoding the fields of the interface")]
    Fields(#[source] finite_elements::Error),
    /// Mode shapes could not be written as a VTK file.
    #[error("encoding mode shapes")]
    Shapes(#[source] finite_elements::Error),
    /// A page could not be made from its template.
    #[error("making the page")]
    Page(#[source] askama::Error),
    /// A table could not be written as comma-separated values.
    #[error("writing a table")]
    Table(#[source] csv::Error),
    /// Arrays could not be written as a NumPy archive.
    #[error("encoding arrays")]
    Arrays(#[source] Box<matrix_files::Error>),
    /// A summary could not be written as JSON.
    #[error("encoding the summary")]
    Summary(#[source] serde_json::Error),
}
