//! From the arrays of a VTK file to a mesh with fields.

use super::document::{Array, Grid, Reader, SECTIONS};
use super::field::{Field, MATERIAL};
use crate::Error;
use crate::elements::{self, Cell, ELEMENT_TYPES, ElementType, FACE_TYPES, FaceType, Sides};
use crate::formats::common::Kept;
use crate::mesh::{Element, Face, Material, Mesh};
use std::collections::BTreeSet;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Solids, with the materials that were passed in.
    pub mesh: Mesh,
    /// Fields at the nodes of the mesh.
    pub point_fields: Vec<Field>,
    /// Fields at its elements, but for [`MATERIAL`].
    pub cell_fields: Vec<Field>,
    /// Points that belong to no solid: they are dropped, since nothing would hold them.
    pub orphan_nodes: usize,
    /// Cells of dimension 0-2, which are dropped.
    pub ignored_cells: usize,
    /// Wedges whose first triangle was counter-clockwise seen from outside.
    pub reversed_wedges: usize,
    /// Arrays of points and cells that are not numbers.
    pub skipped_arrays: usize,
}

/// A surface with fields, as [`super::write_surface`] writes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Positions of all points of the file (m).
    pub nodes: Vec<[f64; 3]>,
    /// Faces; where the file holds solids, their outer faces.
    pub faces: Vec<Face>,
    /// Fields at the nodes.
    pub point_fields: Vec<Field>,
    /// Fields of the faces; those of solids are left out.
    pub face_fields: Vec<Field>,
}

/// Cell type and number of nodes of points and lines.
const POINTS_AND_LINES: [(u8, usize); 3] = [(1, 1), (3, 2), (21, 3)];

/// What a cell type of VTK is to this crate.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Solid(&'static ElementType),
    Face(&'static FaceType),
    /// A point or line with this number of nodes.
    Nodes(usize),
}

impl Kind {
    fn from_number(cell_type: f64) -> Option<Self> {
        let number = Some(cell_type as u8).filter(|whole| f64::from(*whole) == cell_type)?;
        let solid = ELEMENT_TYPES.into_iter().find(|row| row.vtk.number == number);
        let face = FACE_TYPES.into_iter().find(|row| row.vtk == number);
        let rest = POINTS_AND_LINES.into_iter().find(|(known, _)| *known == number);
        let nodes = rest.map(|(_, n_nodes)| Self::Nodes(n_nodes));
        solid.map(Self::Solid).or(face.map(Self::Face)).or(nodes)
    }

    fn n_nodes(self) -> usize {
        match self {
            Self::Solid(row) => row.n_nodes(),
            Self::Face(row) => row.n_nodes,
            Self::Nodes(n_nodes) => n_nodes,
        }
    }
}

/// A solid of the file.
struct Solid<'n> {
    /// Number of the cell.
    cell: usize,
    row: &'static ElementType,
    /// Points of the file, in its order.
    points: &'n [u32],
    material: u16,
}

impl<'a> Reader<'a> {
    pub(super) fn contents(&self, grid: &Grid<'a>, materials: &[Material]) -> Result<Contents, Error> {
        self.check_piece(grid)?;
        let coordinates = self.coordinates(grid)?;
        let connectivity = self.connectivity(grid, coordinates.len())?;
        let solids = self.solids(grid, &connectivity, materials)?;
        let used = solids.iter().flat_map(|solid| solid.points.iter().copied());
        let kept = Kept::new(coordinates.len(), used);
        let (mesh, reversed_wedges) = mesh(&coordinates, &kept, &solids, materials);
        let points = kept.old.iter().map(|old| *old as usize).collect::<Vec<_>>();
        let cells = solids.iter().map(|solid| solid.cell).collect::<Vec<_>>();
        let (point_fields, skipped_at_points) = self.fields(grid, 2, grid.n_points, &points)?;
        let (cell_fields, skipped_in_cells) = self.fields(grid, 3, grid.n_cells, &cells)?;
        Ok(Contents {
            orphan_nodes: coordinates.len() - mesh.nodes.len(),
            ignored_cells: grid.n_cells - solids.len(),
            reversed_wedges,
            skipped_arrays: skipped_at_points + skipped_in_cells,
            mesh,
            point_fields,
            cell_fields,
        })
    }

    /// Refuses files without a piece, and two arrays of one name in a section.
    pub(super) fn check_piece(&self, grid: &Grid<'a>) -> Result<(), Error> {
        if grid.at == 0 {
            return Err(self.syntax(self.end_of_file(), "the element Piece", "none"));
        }
        for (name, arrays) in SECTIONS.iter().zip(&grid.arrays) {
            let mut names = BTreeSet::new();
            if let Some(array) = arrays.iter().find(|array| !names.insert(&array.name)) {
                let problem = format!("`{name}` has two arrays `{}`", array.name);
                return Err(self.inconsistent(array.at, problem, "remove or rename one"));
            }
        }
        Ok(())
    }

    /// Positions of all points (m).
    pub(super) fn coordinates(&self, grid: &Grid<'a>) -> Result<Vec<[f64; 3]>, Error> {
        let points = grid.arrays[0].first();
        let points = points.ok_or_else(|| self.syntax(grid.at, "an array in `Points`", "none"))?;
        if points.components != 3 {
            let found = points.components.to_string();
            return Err(self.syntax(points.at, "3 components of `Points`", found));
        }
        let coordinates = self.exactly(grid, points, grid.n_points.checked_mul(3))?;
        if let Some(&value) = coordinates.iter().find(|x| !x.is_finite()) {
            let place = format!("{}: coordinates", self.place(points.at));
            return Err(Error::NotFinite { place, value });
        }
        let coordinates: Vec<[f64; 3]> = coordinates.as_chunks().0.to_vec();
        u32::try_from(coordinates.len()).map_err(|_| {
            self.unsupported(
                points.at,
                "a mesh of more than 4294967295 nodes".into(),
                "use a coarser mesh",
            )
        })?;
        Ok(coordinates)
    }

    /// Points of all cells, cell by cell.
    pub(super) fn connectivity(&self, grid: &Grid<'a>, n_points: usize) -> Result<Vec<u32>, Error> {
        let connectivity = self.cells_array(grid, "connectivity")?;
        let nodes = self.numbers(grid, connectivity)?;
        // NaN and negative numbers fail too.
        if let Some(node) = nodes
            .iter()
            .find(|&&node| !(node >= 0.0 && node < n_points as f64 && node.fract() == 0.0))
        {
            let problem = format!("a cell refers to point {node}, but there are only {n_points}");
            return Err(self.inconsistent(connectivity.at, problem, "the file is damaged: save it again"));
        }
        Ok(nodes.into_iter().map(|node| node as u32).collect())
    }

    /// Number of the material of each cell, not checked yet.
    fn material_numbers(&self, grid: &Grid<'a>, materials: &[Material]) -> Result<Vec<f64>, Error> {
        match material_array(grid) {
            Some(array) => self.exactly(grid, array, Some(grid.n_cells)),
            None if materials.len() == 1 => Ok(vec![0.0; grid.n_cells]),
            None => Err(self.inconsistent(
                grid.at,
                format!(
                    "the cells have no array `{MATERIAL}`, and there are {} materials",
                    materials.len()
                ),
                "add the array with the number of each cell's material, or pass one material for all",
            )),
        }
    }

    /// Types and points of all cells, of which some are solids.
    pub(super) fn cells<'n>(&self, grid: &Grid<'a>, connectivity: &'n [u32]) -> Result<Vec<(Kind, &'n [u32])>, Error> {
        let cells = self.all_cells(grid, connectivity)?;
        if !cells.iter().any(|(kind, _)| matches!(kind, Kind::Solid(_))) {
            return Err(self.inconsistent(
                grid.at,
                "the file holds no solids".into(),
                "save a mesh of hexahedra, wedges or tetrahedra",
            ));
        }
        Ok(cells)
    }

    /// The outer faces of the solids; where there are none, all faces with their fields.
    pub(super) fn surface(&self, grid: &Grid<'a>) -> Result<Surface, Error> {
        self.check_piece(grid)?;
        let nodes = self.coordinates(grid)?;
        let connectivity = self.connectivity(grid, nodes.len())?;
        let (mut solids, mut rows, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        for (number, (kind, points)) in self.all_cells(grid, &connectivity)?.into_iter().enumerate() {
            match kind {
                Kind::Solid(row) => solids.push(Cell::of_type(row, &ours(row, points, &nodes).0)),
                Kind::Face(_) => {
                    faces.extend(Face::from_nodes(points));
                    rows.push(number);
                }
                Kind::Nodes(_) => {}
            }
        }
        if !solids.is_empty() {
            rows.clear();
            faces = Sides::of(&solids)
                .boundary(&solids)
                .into_iter()
                .map(|(face, _)| face)
                .collect();
        }
        let points: Vec<usize> = (0..nodes.len()).collect();
        let (point_fields, _) = self.fields(grid, 2, grid.n_points, &points)?;
        let (face_fields, _) = self.fields(grid, 3, grid.n_cells, &rows)?;
        Ok(Surface {
            nodes,
            faces,
            point_fields,
            face_fields,
        })
    }

    /// Types and points of all cells.
    fn all_cells<'n>(&self, grid: &Grid<'a>, connectivity: &'n [u32]) -> Result<Vec<(Kind, &'n [u32])>, Error> {
        let [offsets, types] = [self.cells_array(grid, "offsets")?, self.cells_array(grid, "types")?];
        let ends = self.exactly(grid, offsets, Some(grid.n_cells))?;
        let cell_types = self.exactly(grid, types, Some(grid.n_cells))?;
        let mut cells = Vec::with_capacity(cell_types.len());
        let mut start = 0;
        for (cell, (cell_type, end)) in cell_types.iter().zip(&ends).enumerate() {
            let Some(kind) = Kind::from_number(*cell_type) else {
                return Err(self.unsupported(
                    types.at,
                    format!("VTK cell type {cell_type} of cell {cell}"),
                    format!("save {}", elements::descriptions()),
                ));
            };
            let next = start + kind.n_nodes();
            let (Some(points), true) = (connectivity.get(start..next), *end == next as f64) else {
                let expected = format!("offset {next} after cell {cell} of {} nodes", kind.n_nodes());
                return Err(self.syntax(offsets.at, expected, format!("{end} of {} indices", connectivity.len())));
            };
            start = next;
            cells.push((kind, points));
        }
        if start != connectivity.len() {
            let found = format!("{} indices", connectivity.len());
            let connectivity = self.cells_array(grid, "connectivity")?;
            return Err(self.syntax(connectivity.at, format!("{start} indices of nodes"), found));
        }
        Ok(cells)
    }

    /// The solids among the cells.
    fn solids<'n>(
        &self,
        grid: &Grid<'a>,
        connectivity: &'n [u32],
        materials: &[Material],
    ) -> Result<Vec<Solid<'n>>, Error> {
        let cells = self.cells(grid, connectivity)?;
        let numbers = self.material_numbers(grid, materials)?;
        let mut solids = Vec::new();
        for (cell, (kind, points)) in cells.into_iter().enumerate() {
            let Kind::Solid(row) = kind else { continue };
            let material = numbers[cell];
            let known = materials.len().min(usize::from(u16::MAX) + 1);
            if !(material >= 0.0 && material < known as f64 && material.fract() == 0.0) {
                return Err(self.inconsistent(
                    material_array(grid).map_or(grid.at, |array| array.at),
                    format!("cell {cell} has material {material}, but there are only {known}"),
                    "pass as many materials as the file refers to; numbers begin with 0",
                ));
            }
            let material = material as u16;
            solids.push(Solid {
                cell,
                row,
                points,
                material,
            });
        }
        Ok(solids)
    }

    /// The fields of a section of [`SECTIONS`] at the given rows of `count`, and the number of arrays without numbers.
    fn fields(
        &self,
        grid: &Grid<'a>,
        section: usize,
        count: usize,
        rows: &[usize],
    ) -> Result<(Vec<Field>, usize), Error> {
        let (mut fields, mut skipped) = (Vec::new(), 0);
        for array in &grid.arrays[section] {
            if array.name == MATERIAL && section == 3 {
                continue;
            }
            if array.kind == "String" || array.kind == "Bit" {
                skipped += 1;
                continue;
            }
            let components = array.components;
            let all = self.exactly(grid, array, count.checked_mul(components))?;
            let values = rows
                .iter()
                .flat_map(|row| &all[row * components..(row + 1) * components]);
            fields.push(Field {
                name: array.name.clone(),
                components,
                values: values.copied().collect(),
            });
        }
        Ok((fields, skipped))
    }
}

fn material_array<'g, 'a>(grid: &'g Grid<'a>) -> Option<&'g Array<'a>> {
    grid.arrays[3].iter().find(|array| array.name == MATERIAL)
}

/// Nodes in this crate's order from those in the order of the file, and whether this was the second order of the type.
pub(super) fn ours(row: &ElementType, file: &[u32], positions: &[[f64; 3]]) -> (Vec<u32>, bool) {
    let nodes = row.vtk.ours(file);
    if let Some(alternative) = &row.vtk.alternative {
        let x: Vec<[f64; 3]> = nodes.iter().map(|node| positions[*node as usize]).collect();
        if (alternative.applies)(&x) {
            return (alternative.ours(file), true);
        }
    }
    (nodes, false)
}

/// The mesh of the solids, and how many of them were in the second order of their type.
fn mesh(coordinates: &[[f64; 3]], kept: &Kept, solids: &[Solid<'_>], materials: &[Material]) -> (Mesh, usize) {
    let mut mesh = Mesh {
        nodes: kept.old.iter().map(|old| coordinates[*old as usize]).collect(),
        materials: materials.to_vec(),
        ..Mesh::default()
    };
    let mut reversed = 0;
    for solid in solids {
        let Solid { row, material, .. } = *solid;
        let file: Vec<u32> = solid.points.iter().filter_map(|node| kept.number(*node)).collect();
        let (nodes, is_reversed) = ours(row, &file, &mesh.nodes);
        reversed += usize::from(is_reversed);
        let cell = Cell::try_new(row, row.default_formulation(), &nodes);
        mesh.elements.extend(cell.map(|cell| Element { cell, material }));
    }
    (mesh, reversed)
}
