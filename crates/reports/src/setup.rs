//! The page in which a joint is set up from its mesh.

use crate::Error;
use crate::html::render;
use crate::interactive::{Live, Setup};
use askama::Template;
use joints::structure::Shape;
use serde_json::Value;

/// A page with the content security policy that it is to be served with.
#[derive(Debug)]
pub struct Page {
    /// The document.
    pub html: String,
    /// The policy: its own scripts, connections to where it is from, and nothing else.
    pub policy: String,
}

#[derive(Template)]
#[template(path = "setup.html")]
struct Document {
    title: String,
    live: Live,
}

/// The page for a mesh of a shape; `facts` are what the scripts in `interactive/setup.js` need to know of it.
///
/// # Errors
/// [`Error::Summary`], [`Error::Page`].
pub fn document(title: &str, shape: &Shape, facts: &Value) -> Result<Page, Error> {
    let live = Live::setup(&Setup::of(shape, facts))?;
    let policy = format!("{}; connect-src 'self'; frame-ancestors 'none'", live.policy);
    let title = title.to_owned();
    Ok(Page {
        html: render(&Document { title, live })?,
        policy,
    })
}
