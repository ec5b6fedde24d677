//! What the bodies of a mesh file look like, for those who choose parts of them.

use super::OuterSurface;
use super::survey::{Survey, read, smooth};
use crate::Error;
use finite_elements::mesh::Face;
use std::collections::HashMap;
use std::path::Path;

/// The outer surface of the bodies of a mesh file, and what its faces belong to. Lengths are in the unit of the file.
#[derive(Debug)]
pub struct Shape {
    /// The surface, with the faces that touch.
    pub surface: OuterSurface,
    /// Labels of its nodes in the file.
    pub labels: Vec<u64>,
    /// For each face the number of its body, from zero.
    pub bodies: Vec<u32>,
    /// For each face the number of the smooth surface that it is part of, from zero.
    pub patches: Vec<u32>,
    /// For each face its place in [`Survey::touching`], if it touches another body.
    pub touching: Vec<Option<u32>>,
    /// Surfaces with names, and the numbers of their faces.
    pub named: Vec<(String, Vec<u32>)>,
    /// For each solid the number of its body.
    pub body_of_cell: Vec<u32>,
}

impl Shape {
    /// That of a mesh file or of the mesh of an input deck, with its survey.
    ///
    /// # Errors
    /// Those of the file.
    pub fn of_file(path: &Path) -> Result<(Survey, Self), Error> {
        let mesh = read(path)?;
        let survey = Survey::of(&mesh);
        let body_of_cell = mesh.bodies();
        let (faces, cells): (Vec<Face>, Vec<u32>) = mesh.boundary().into_iter().unzip();
        let corners = |face: &Face| {
            let mut corners = face.corners().to_vec();
            corners.sort_unstable();
            corners
        };
        let number_of: HashMap<Vec<u32>, u32> = faces.iter().map(&corners).zip(0..).collect();
        let numbers = |faces: &[Face]| -> Vec<u32> {
            let known = faces.iter().filter_map(|face| number_of.get(&corners(face)));
            known.copied().collect()
        };
        let mut patches = vec![0; faces.len()];
        for (number, patch) in (0..).zip(smooth(&mesh.nodes, &faces)) {
            patch.into_iter().for_each(|face| patches[face] = number);
        }
        let mut touching = vec![None; faces.len()];
        for (number, pair) in (0..).zip(&survey.touching) {
            for face in numbers(&pair.on) {
                touching[face as usize] = Some(number);
            }
        }
        let named = mesh.surfaces.iter();
        let named = named
            .map(|group| (group.name.clone(), numbers(&group.members)))
            .collect();
        let surface = OuterSurface::from_faces(&mesh.nodes, &faces);
        let labels = surface.numbers.iter();
        let label = |node: &u32| mesh.labels.get(*node as usize).copied().unwrap_or_default();
        let shape = Self {
            labels: labels.map(label).collect(),
            surface,
            bodies: cells.iter().map(|cell| body_of_cell[*cell as usize]).collect(),
            patches,
            touching,
            named,
            body_of_cell,
        };
        Ok((survey, shape))
    }
}
