//! A page of computed figures beside published ones, entry by entry.

use crate::Error;
use crate::html::{Picture, Table, render};
use askama::Template;

/// The page.
#[derive(Clone, Debug, Template)]
#[template(path = "findings.html")]
pub struct FindingsPage<'a> {
    /// Heading.
    pub title: &'a str,
    /// What it is about.
    pub introduction: &'a str,
    /// What must be known before any number is read.
    pub warning: Option<&'a str>,
    /// Its entries.
    pub sections: Vec<Section<'a>>,
}

/// An entry.
#[derive(Clone, Debug)]
pub struct Section<'a> {
    /// Name of its anchor.
    pub id: &'a str,
    /// Heading.
    pub title: &'a str,
    /// What was computed, on what inputs.
    pub inputs: &'a str,
    /// What came of it, or why nothing did.
    pub findings: Result<Findings<'a>, &'a str>,
}

/// What came of an entry.
#[derive(Clone, Debug)]
pub struct Findings<'a> {
    /// What is to be made of the figures.
    pub judgement: &'a str,
    /// Its pictures.
    pub pictures: Vec<Picture<'a>>,
    /// Its figures.
    pub table: Table,
    /// A sentence below the table.
    pub remark: String,
}

impl FindingsPage<'_> {
    /// The page, pictures included.
    ///
    /// # Errors
    /// [`Error::Page`].
    pub fn html(&self) -> Result<String, Error> {
        render(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::markup;

    #[test]
    fn texts_cannot_break_the_page() {
        let hostile = "a < b & \"c\" > d\u{1}";
        let found = Findings {
            judgement: hostile,
            pictures: vec![Picture {
                svg: "<svg/>\n".into(),
                caption: hostile.into(),
            }],
            table: Table {
                headings: vec![hostile.into(), "value".into()],
                rows: vec![vec![hostile.into(), "1".into()]],
            },
            remark: hostile.into(),
        };
        let section = |findings| Section {
            id: "one",
            title: hostile,
            inputs: hostile,
            findings,
        };
        let page = FindingsPage {
            title: hostile,
            introduction: hostile,
            warning: Some(hostile),
            sections: vec![section(Ok(found)), section(Err(hostile))],
        };
        let page = page.html().expect("a page");
        assert_eq!(markup::check(&page), Ok(()));
        assert!(page.contains("<svg/>") && !page.contains('\u{1}') && !page.contains("a < b"));
        assert_eq!(page.matches("<h2 id=\"one\">").count(), 2);
    }
}
