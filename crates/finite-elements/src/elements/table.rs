//! The table of element types, and how to find a row in it.

use super::cell::{ElementType, Formulation, MAX_NODES};
use super::hex8::HEX8;
use super::hex20::HEX20;
use super::hex27::HEX27;
use super::tet4::TET4;
use super::tet10::TET10;
use super::wedge6::WEDGE6;
use super::wedge15::WEDGE15;

/// All element types, in the order in which messages list them.
pub static ELEMENT_TYPES: [&ElementType; 7] = [&HEX8, &HEX20, &HEX27, &TET4, &TET10, &WEDGE6, &WEDGE15];

const _: () = {
    let mut row = 0;
    while row < ELEMENT_TYPES.len() {
        assert!(ELEMENT_TYPES[row].nodes.len() <= MAX_NODES, "raise MAX_NODES");
        row += 1;
    }
};

/// The type and formulation that Abaqus and CalculiX call `name` (in capitals).
pub(crate) fn from_abaqus(name: &str) -> Option<(&'static ElementType, Formulation)> {
    ELEMENT_TYPES.into_iter().find_map(|row| {
        let known = row.formulations.iter().find(|(_, known)| *known == Some(name));
        known.map(|(formulation, _)| (row, *formulation))
    })
}

/// What Abaqus and CalculiX call a type and formulation.
pub(crate) fn to_abaqus(row: &ElementType, formulation: Formulation) -> Option<&'static str> {
    let found = row.formulations.iter().find(|(known, _)| *known == formulation);
    found.and_then(|(_, name)| *name)
}

/// All names of Abaqus and CalculiX, for messages.
pub(crate) fn abaqus_names() -> String {
    let names = ELEMENT_TYPES.into_iter().flat_map(|row| row.formulations);
    let names: Vec<&str> = names.filter_map(|(_, name)| *name).collect();
    names.join(", ")
}

/// What messages call the elements of all types.
pub(crate) fn descriptions() -> String {
    let all: Vec<&str> = ELEMENT_TYPES.into_iter().map(|row| row.description).collect();
    all.join(", ")
}
