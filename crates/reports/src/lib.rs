#![doc = include_str!("../README.md")]

pub mod account;
mod analysis;
mod answer;
pub mod bodies;
pub mod cases;
pub mod csv;
pub mod elements;
pub mod ensemble;
mod error;
mod errors;
pub mod fields;
pub mod findings;
pub mod html;
pub mod identification;
mod interactive;
pub mod joints;
pub mod map;
pub mod markup;
pub mod modes;
mod motions;
pub mod names;
pub mod overlay;
mod page;
pub mod paper;
pub mod parameters;
pub mod pdf;
pub mod periodic;
mod phrases;
pub mod plot;
pub mod random;
pub mod registry;
pub mod ring_down;
pub mod run;
pub mod sensitivity;
pub mod setup;
pub mod several;
pub mod shock;
pub mod styles;
mod sweep;
pub mod tightening;
pub mod uncertainty;

pub use answer::lines as answer_lines;
pub use error::{Drawing, Error};

/// A file to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Name within its folder.
    pub name: String,
    /// Its bytes.
    pub contents: Vec<u8>,
}

impl Output {
    /// A file of this name with these contents.
    pub fn new(name: impl Into<String>, contents: impl Into<Vec<u8>>) -> Self {
        Self {
            name: name.into(),
            contents: contents.into(),
        }
    }
}
