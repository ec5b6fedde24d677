//! The seam through which results of analyses become files, sections of the page, and lines on the terminal.

use crate::html::{Picture, Table};
use crate::{Error, Output};
use analyses::Run;
use analyses::results::summary::Summary;

/// How the results of an analysis are shown; what a run does not have is left out.
pub struct Analysis {
    /// Whether it may write a file of this name.
    pub writes: fn(&str) -> bool,
    /// Its files and its section of the page.
    pub(crate) document: fn(&Run, &Summary) -> Result<Option<Document>, Error>,
    /// What the terminal says of it.
    pub(crate) lines: fn(&Summary) -> String,
    /// Whether all of it converged.
    pub(crate) is_complete: fn(&Summary) -> bool,
}

/// Files, and what the page says.
pub(crate) struct Document {
    pub(crate) outputs: Vec<Output>,
    pub(crate) section: Option<Section>,
}

/// A section of the page.
#[derive(Default)]
pub(crate) struct Section {
    pub(crate) heading: &'static str,
    pub(crate) warnings: Vec<String>,
    /// Identifier of the block that scripts draw in, in the place of the first picture where they run.
    pub(crate) live: Option<&'static str>,
    pub(crate) pictures: Vec<Picture<'static>>,
    /// Tables with their headings, which may be empty.
    pub(crate) tables: Vec<(String, Table)>,
    pub(crate) remarks: Vec<String>,
}
