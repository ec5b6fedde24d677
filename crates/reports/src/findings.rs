//! A page of computed figures beside published ones, entry by entry.

use crate::Error;
use crate::cases::Cases;
use crate::html::{Picture, Table, render};
use crate::interactive::Live;
use askama::Template;

/// The page.
#[derive(Clone, Debug)]
pub struct FindingsPage<'a> {
    /// Heading.
    pub title: &'a str,
    /// What it is about.
    pub introduction: &'a str,
    /// What must be known before any number is read.
    pub warning: Option<&'a str>,
    /// Its entries.
    pub sections: Vec<Section<'a>>,
    /// Cases that its reader may look at one by one.
    pub cases: Option<Cases>,
}

#[derive(Template)]
#[template(path = "findings.html")]
struct Page<'a> {
    title: &'a str,
    introduction: &'a str,
    warning: Option<&'a str>,
    sections: &'a [Section<'a>],
    live: Option<Live>,
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
    /// What is to be made of the figures; may be empty.
    pub judgement: &'a str,
    /// Its pictures.
    pub pictures: Vec<Picture<'a>>,
    /// Its figures; each table has a heading, or none.
    pub tables: Vec<(String, Table)>,
    /// A sentence below the table.
    pub remark: String,
}

impl FindingsPage<'_> {
    /// The page, pictures included.
    ///
    /// # Errors
    /// [`Error::Page`]; [`Error::Summary`] for cases that have no JSON.
    pub fn html(&self) -> Result<String, Error> {
        render(&Page {
            title: self.title,
            introduction: self.introduction,
            warning: self.warning,
            sections: &self.sections,
            live: self.cases.as_ref().map(Live::cases).transpose()?,
        })
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
            tables: vec![(
                hostile.into(),
                Table {
                    headings: vec![hostile.into(), "value".into()],
                    rows: vec![vec![hostile.into(), "1".into()]],
                },
            )],
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
            cases: None,
        };
        let page = page.html().expect("a page");
        assert_eq!(markup::check(&page), Ok(()));
        assert!(page.contains("<svg/>") && !page.contains('\u{1}') && !page.contains("a < b"));
        assert_eq!(page.matches("<h2 id=\"one\">").count(), 2);
    }
}
