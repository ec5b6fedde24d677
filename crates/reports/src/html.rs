//! What pages are made of. The pages themselves are templates in the folder `templates`.

use crate::Error;
use crate::markup::printable;
use askama::Template;
use std::borrow::Cow;

/// Cell of a value that there is none of.
pub(crate) const MISSING: &str = "–";

/// A picture with what is said under it.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// The picture itself.
    pub svg: Cow<'a, str>,
    /// What it shows.
    pub caption: String,
}

/// A table of texts.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Headings of its columns.
    pub headings: Vec<String>,
    /// Its rows, each with a cell per column and perhaps a remark behind them.
    pub rows: Vec<Vec<String>>,
}

/// The page of a template, without characters that XML cannot hold.
pub(crate) fn render(page: &impl Template) -> Result<String, Error> {
    page.render().map(|text| printable(&text)).map_err(Error::Page)
}
