//! Exodus II (`.exo`, `.e`, `.g`) of Cubit, Sierra, MOOSE and ParaView, in netCDF 3 and 4: the mesh, its blocks and sets.
//!
//! Blocks of solids are volumes, blocks of shells and two-dimensional elements surfaces, where they lie on solids; other blocks are
//! groups of nodes. Sides of solids make surfaces, node sets groups of nodes. Names are those of the file, or else `BLOCK=N`,
//! `SIDESET=N` and `NODESET=N` with the file's numbers. Results and other variables are not read.
//!
//! Format: EXODUS II, A Finite Element Data Model (Sandia report SAND92-2137), with the present order of nodes and sides of the
//! SEACAS library.

use super::labelled::{GroupId, Labelled, Shape, Which};
use super::solid_mesh::SolidMesh;
use crate::Error;
use crate::elements::{ElementType, HEX8, HEX20, HEX27, TET4, TET10, WEDGE6, WEDGE15};
use netcdf_reader::{NcFile, NcOpenOptions};

/// Corners of a side of an element: three of them tell which one it is.
type SideCorners = [usize; 3];

/// A kind of solid: beginning of its name, type, for each of the crate's nodes its place in the file, and the sides.
struct Solid {
    name: &'static str,
    row: &'static ElementType,
    order: &'static [usize],
    sides: &'static [SideCorners],
}

const TET_SIDES: [SideCorners; 4] = [[0, 1, 3], [1, 2, 3], [0, 2, 3], [0, 1, 2]];
const WEDGE_SIDES: [SideCorners; 5] = [[0, 1, 4], [1, 2, 5], [0, 3, 5], [0, 1, 2], [3, 4, 5]];
const HEX_SIDES: [SideCorners; 6] = [[0, 1, 5], [1, 2, 6], [2, 3, 7], [0, 4, 7], [0, 1, 2], [4, 5, 6]];
const STRAIGHT: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];

static SOLIDS: [Solid; 7] = [
    Solid {
        name: "TET",
        row: &TET4,
        order: STRAIGHT.split_at(4).0,
        sides: &TET_SIDES,
    },
    Solid {
        name: "TET",
        row: &TET10,
        order: &STRAIGHT,
        sides: &TET_SIDES,
    },
    Solid {
        name: "WEDGE",
        row: &WEDGE6,
        order: STRAIGHT.split_at(6).0,
        sides: &WEDGE_SIDES,
    },
    Solid {
        name: "WEDGE",
        row: &WEDGE15,
        order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11],
        sides: &WEDGE_SIDES,
    },
    Solid {
        name: "HEX",
        row: &HEX8,
        order: STRAIGHT.split_at(8).0,
        sides: &HEX_SIDES,
    },
    Solid {
        name: "HEX",
        row: &HEX20,
        order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15],
        sides: &HEX_SIDES,
    },
    Solid {
        name: "HEX",
        row: &HEX27,
        // After the edges the centre, then the sides at low and high z, x and y.
        order: &[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15, 23, 24, 25, 26, 21, 22, 20,
        ],
        sides: &HEX_SIDES,
    },
];

/// The solids, blocks and sets of a file.
pub(super) fn solid_mesh(file: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    let most = most_numbers(bytes.len());
    let options = NcOpenOptions {
        max_read_bytes: most,
        max_chunk_bytes: most,
        ..NcOpenOptions::default()
    };
    let source = NcFile::from_bytes_with_options(bytes, options).map_err(|reason| Error::MeshFormat {
        file: file.into(),
        problem: format!("it is no netCDF file: {reason}"),
        remedy: "save the mesh again as Exodus II",
    })?;
    let bytes = bytes.len();
    Reader { file, source, bytes }.read()
}

/// Most numbers that a variable may have in a file of so many bytes, and most bytes that are decoded at once: as much larger than
/// the file as text that is packed well.
fn most_numbers(bytes: usize) -> usize {
    bytes.saturating_mul(64).saturating_add(1 << 20)
}

struct Reader<'a> {
    file: &'a str,
    source: NcFile,
    /// Size of the file.
    bytes: usize,
}

/// A solid by its number in the file: its label, its kind, and the labels of its nodes in the order of the file.
struct Known {
    label: u64,
    solid: Option<&'static Solid>,
    nodes: Vec<u64>,
}

impl Reader<'_> {
    fn fails(&self, variable: &str, problem: impl Into<String>) -> Error {
        Error::MeshFormat {
            file: self.file.into(),
            problem: format!("the variable `{variable}`: {}", problem.into()),
            remedy: "save the mesh again as Exodus II",
        }
    }

    fn read(&self) -> Result<SolidMesh, Error> {
        let mut mesh = Labelled::default();
        // Numbers of places are those of blocks and sets; messages name these by themselves.
        let refuse = |_, problem: String, remedy| Error::MeshFormat {
            file: self.file.into(),
            problem,
            remedy,
        };
        let count = self.size("num_nodes")?.unwrap_or(0);
        let positions = self.positions(count)?;
        let labels = self.labels(&["node_num_map", "node_id_map"], count)?;
        let labels = labels.unwrap_or_else(|| (1..=count as u64).collect());
        for (label, position) in labels.iter().zip(positions) {
            mesh.node(0, *label, position, &refuse)?;
        }
        let known = self.blocks(&mut mesh, &labels)?;
        let solids = known.iter().filter(|known| known.solid.is_some()).count();
        if solids == 0 {
            return Err(refuse(
                0,
                "the file holds no solids".into(),
                "mesh in three dimensions, and save blocks of HEX, TET or WEDGE",
            ));
        }
        self.side_sets(&mut mesh, &known)?;
        let sets = self.size("num_node_sets")?.unwrap_or(0);
        let names = self.names("ns_names", "ns_prop1", "NODESET", sets)?;
        for (number, name) in (1..).zip(names) {
            let variable = format!("node_ns{number}");
            if let Some(members) = self.integers(&variable)? {
                let nodes = members.iter().map(|index| at(&labels, *index));
                let nodes: Option<Vec<u64>> = nodes.map(|node| node.copied()).collect();
                let nodes = nodes.ok_or_else(|| self.fails(&variable, "a node is not in the file"))?;
                let group = mesh.group(name);
                mesh.node_set(group, nodes);
            }
        }
        mesh.finish(&refuse)?.finish(self.file)
    }

    fn positions(&self, count: usize) -> Result<Vec<[f64; 3]>, Error> {
        if let Some(all) = self.numbers("coord")? {
            if all.len() != 3 * count {
                return Err(self.fails("coord", "there must be three coordinates of each node"));
            }
            let position = |number: usize| [0, 1, 2].map(|axis| all[axis * count + number]);
            return Ok((0..count).map(position).collect());
        }
        // No room is made for a number of nodes that the coordinates do not have.
        let mut positions = Vec::new();
        for (axis, variable) in ["coordx", "coordy", "coordz"].into_iter().enumerate() {
            let along = self.numbers(variable)?.unwrap_or_default();
            if along.len() != count {
                return Err(self.fails(variable, format!("there are {} numbers for {count} nodes", along.len())));
            }
            positions.resize(count, [0.0; 3]);
            for (position, x) in positions.iter_mut().zip(along) {
                position[axis] = x;
            }
        }
        Ok(positions)
    }

    /// Numbers by which the file calls its nodes or elements; none where it counts them from one.
    fn labels(&self, variables: &[&str], count: usize) -> Result<Option<Vec<u64>>, Error> {
        for variable in variables {
            if let Some(labels) = self.integers(variable)? {
                if labels.len() != count {
                    return Err(self.fails(variable, format!("there are {} numbers for {count}", labels.len())));
                }
                return Ok(Some(labels));
            }
        }
        Ok(None)
    }

    /// Adds the elements of all blocks.
    fn blocks(&self, mesh: &mut Labelled, labels: &[u64]) -> Result<Vec<Known>, Error> {
        let blocks = self.size("num_el_blk")?.unwrap_or(0);
        let names = self.names("eb_names", "eb_prop1", "BLOCK", blocks)?;
        let elements = self.size("num_elem")?.unwrap_or(0);
        let numbers = self.labels(&["elem_num_map", "elem_id_map"], elements)?;
        let mut known: Vec<Known> = Vec::new();
        for (block, name) in (1..).zip(names) {
            let variable = format!("connect{block}");
            let Some(connectivity) = self.integers(&variable)? else {
                continue;
            };
            let found = self.source.variable(&variable);
            let found = found.map_err(|reason| self.fails(&variable, reason.to_string()))?;
            let per_element = found.shape().get(1).map_or(1, |size| *size as usize).max(1);
            let kind = found
                .attribute("elem_type")
                .and_then(|attribute| attribute.value.as_string());
            let kind = kind.unwrap_or_default().trim_matches(['\0', ' ']).to_ascii_uppercase();
            let solid = SOLIDS
                .iter()
                .find(|solid| kind.starts_with(solid.name) && solid.order.len() == per_element);
            let shape = match (solid, kind.as_str(), per_element) {
                (Some(solid), ..) => Shape::Solid(solid.row),
                (None, kind, 3 | 6 | 7) if kind.starts_with("TRI") || kind.starts_with("SHELL") => Shape::Facet(3),
                (None, kind, 4 | 8 | 9) if kind.starts_with("QUAD") || kind.starts_with("SHELL") => Shape::Facet(4),
                (None, kind, _)
                    if ["BAR", "BEAM", "TRUSS", "SPHERE", "ROD", "SPRING", "EDGE"]
                        .iter()
                        .any(|name| kind.starts_with(name)) =>
                {
                    Shape::Nodes
                }
                _ => {
                    return Err(Error::MeshFormat {
                        file: self.file.into(),
                        problem: format!(
                            "the block `{name}` of elements `{kind}` with {per_element} nodes cannot be read"
                        ),
                        remedy: "mesh solids as tetrahedra, wedges or hexahedra, and other parts as shells or beams",
                    });
                }
            };
            let group = Some(mesh.group(name));
            for element in connectivity.chunks_exact(per_element) {
                let nodes = element.iter().map(|index| at(labels, *index).copied());
                let nodes: Option<Vec<u64>> = nodes.collect();
                let nodes = nodes.ok_or_else(|| self.fails(&variable, "a node is not in the file"))?;
                if known.len() == elements {
                    return Err(self.fails(&variable, format!("there are more elements than {elements}")));
                }
                let label = numbers.as_ref().map_or(known.len() as u64 + 1, |own| own[known.len()]);
                match solid {
                    Some(solid) => {
                        let ours: Vec<u64> = solid.order.iter().map(|place| nodes[*place]).collect();
                        mesh.element(0, label, shape, &ours, [group, None]);
                    }
                    None => mesh.element(0, label, shape, &nodes, [group, None]),
                }
                known.push(Known { label, solid, nodes });
            }
        }
        Ok(known)
    }

    fn side_sets(&self, mesh: &mut Labelled, known: &[Known]) -> Result<(), Error> {
        let sets = self.size("num_side_sets")?.unwrap_or(0);
        let names = self.names("ss_names", "ss_prop1", "SIDESET", sets)?;
        for (number, name) in (1..).zip(names) {
            let (elements, sides) = (format!("elem_ss{number}"), format!("side_ss{number}"));
            let Some(of) = self.integers(&elements)? else {
                continue;
            };
            let which = self.integers(&sides)?.unwrap_or_default();
            if which.len() != of.len() {
                return Err(self.fails(&sides, "there must be as many sides as elements"));
            }
            let group: GroupId = mesh.group(name);
            for (element, side) in of.iter().zip(which) {
                let element =
                    at(known, *element).ok_or_else(|| self.fails(&elements, "an element is not in the file"))?;
                let Some(solid) = element.solid else {
                    // A side of a shell: the shell itself, or one of its edges.
                    if side <= 2 {
                        mesh.set(group, vec![element.label]);
                    }
                    continue;
                };
                let corners = at(solid.sides, side);
                let corners = corners.ok_or_else(|| self.fails(&sides, format!("there is no side {side}")))?;
                mesh.face(
                    0,
                    group,
                    element.label,
                    Which::Through(corners.map(|corner| element.nodes[corner])),
                );
            }
        }
        Ok(())
    }

    /// The size of a dimension, if the file has it.
    fn size(&self, dimension: &str) -> Result<Option<usize>, Error> {
        match self.source.dimension(dimension) {
            Ok(found) if found.size > most_numbers(self.bytes) as u64 => {
                Err(self.fails(dimension, "it is larger than the file"))
            }
            Ok(found) => Ok(Some(found.size as usize)),
            Err(_) => Ok(None),
        }
    }

    /// The numbers of a variable, if the file has it.
    fn numbers(&self, variable: &str) -> Result<Option<Vec<f64>>, Error> {
        let Ok(found) = self.source.variable(variable) else {
            return Ok(None);
        };
        match found.num_elements() {
            Ok(count) if count <= most_numbers(self.bytes) as u64 => {}
            _ => return Err(self.fails(variable, "it is larger than the file")),
        }
        let read = self.source.read_variable_as_f64(variable);
        let read = read.map_err(|reason| self.fails(variable, reason.to_string()))?;
        Ok(Some(read.iter().copied().collect()))
    }

    /// The whole numbers of a variable, none of them negative.
    fn integers(&self, variable: &str) -> Result<Option<Vec<u64>>, Error> {
        let Some(numbers) = self.numbers(variable)? else {
            return Ok(None);
        };
        let whole = numbers
            .iter()
            .map(|&x| (x >= 0.0 && x.fract() == 0.0 && x < 1e15).then_some(x as u64));
        let whole: Option<Vec<u64>> = whole.collect();
        whole
            .ok_or_else(|| self.fails(variable, "there must be whole numbers that are not negative"))
            .map(Some)
    }

    /// Names of blocks or sets: those of the file, or else their numbers.
    fn names(&self, names: &str, numbers: &str, kind: &str, count: usize) -> Result<Vec<String>, Error> {
        // Each has a variable of its own.
        if count > self.bytes {
            return Err(self.fails(numbers, format!("the file has no room for {count} of them")));
        }
        let numbers = self.integers(numbers)?.unwrap_or_default();
        let given = match self.source.variable(names) {
            Ok(_) => self.source.read_variable_as_strings(names).unwrap_or_default(),
            Err(_) => Vec::new(),
        };
        let name = |place: usize| {
            let given = given.get(place).map(|name| name.trim_matches(['\0', ' ']));
            match given {
                Some(name) if !name.is_empty() => name.to_owned(),
                _ => format!("{kind}={}", numbers.get(place).copied().unwrap_or(place as u64 + 1)),
            }
        };
        Ok((0..count).map(name).collect())
    }
}

/// The member with a number counted from one.
fn at<T>(all: &[T], number: u64) -> Option<&T> {
    all.get(usize::try_from(number.checked_sub(1)?).ok()?)
}
