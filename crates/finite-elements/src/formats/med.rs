//! MED files (`.med`) of Salome and code_aster, in HDF5: one mesh and its groups.
//!
//! Groups of volumes, of faces on solids, and of edges, points and nodes have the names of the file. Results are not read.
//!
//! Format: MED file library, EDF and CEA, versions 3 and 4. Numbers stand coordinate by coordinate, and node by node of the elements
//! of one type; elements and nodes belong to families, and these to groups. The corners of solids go round the other way than
//! elsewhere.

use super::labelled::{Labelled, Shape};
use super::solid_mesh::SolidMesh;
use crate::Error;
use crate::elements::{ElementType, HEX8, HEX20, TET4, TET10, WEDGE6, WEDGE15};
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};
use std::collections::BTreeMap;

/// Bytes of the name of a group.
const NAME: usize = 80;

/// Name of a type of element, nodes of it, and what it is; for each of the crate's nodes of a solid its place in the file.
static TYPES: [(&str, usize, Kind); 15] = [
    ("TE4", 4, Kind::Solid(&TET4, &[0, 2, 1, 3])),
    ("T10", 10, Kind::Solid(&TET10, &[0, 2, 1, 3, 6, 5, 4, 7, 9, 8])),
    ("PE6", 6, Kind::Solid(&WEDGE6, &[0, 2, 1, 3, 5, 4])),
    (
        "P15",
        15,
        Kind::Solid(&WEDGE15, &[0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13]),
    ),
    ("HE8", 8, Kind::Solid(&HEX8, &[0, 3, 2, 1, 4, 7, 6, 5])),
    (
        "H20",
        20,
        Kind::Solid(
            &HEX20,
            &[0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17],
        ),
    ),
    ("TR3", 3, Kind::Facet(3)),
    ("TR6", 6, Kind::Facet(3)),
    ("TR7", 7, Kind::Facet(3)),
    ("QU4", 4, Kind::Facet(4)),
    ("QU8", 8, Kind::Facet(4)),
    ("QU9", 9, Kind::Facet(4)),
    ("SE2", 2, Kind::Nodes),
    ("SE3", 3, Kind::Nodes),
    ("PO1", 1, Kind::Nodes),
];

enum Kind {
    Solid(&'static ElementType, &'static [usize]),
    Facet(usize),
    Nodes,
}

/// The solids, facets and groups of a file.
pub(super) fn solid_mesh(file: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    let most = bytes.len().saturating_mul(64).saturating_add(1 << 20);
    let options = OpenOptions {
        max_chunk_bytes: most,
        max_read_bytes: most,
        ..OpenOptions::default()
    };
    let reader = Reader { file, most };
    let no_file = |reason: hdf5_reader::error::Error| reader.fails("it is no HDF5 file", &reason.to_string());
    let opened = Hdf5File::from_bytes_with_options(bytes, options).map_err(no_file)?;
    if opened.superblock().eof_address > bytes.len() as u64 {
        return Err(reader.fails("it is incomplete", "the file is shorter than it says"));
    }
    let root = opened.root_group().map_err(no_file)?;
    reader.read(&root)
}

struct Reader<'a> {
    file: &'a str,
    /// Most numbers that a data set may have in a file of this size.
    most: usize,
}

impl Reader<'_> {
    fn fails(&self, what: &str, reason: &str) -> Error {
        Error::MeshFormat {
            file: self.file.into(),
            problem: format!("{what}: {reason}"),
            remedy: "save the mesh again as MED 3 or 4",
        }
    }

    fn read(&self, root: &Group) -> Result<SolidMesh, Error> {
        let meshes = self.groups(root, "ENS_MAA")?;
        let [mesh] = &meshes[..] else {
            return Err(Error::MeshFormat {
                file: self.file.into(),
                problem: format!("the file holds {} meshes", meshes.len()),
                remedy: "save one mesh in a file of its own",
            });
        };
        let name = mesh.name().to_owned();
        let steps = mesh.groups().map_err(|reason| self.fails(&name, &reason.to_string()))?;
        let step = steps.first().ok_or_else(|| self.fails(&name, "the mesh is empty"))?;
        let families = root.group("FAS").and_then(|families| families.group(&name)).ok();
        let of_elements = self.families(families.as_ref(), "ELEME")?;
        let of_nodes = self.families(families.as_ref(), "NOEUD")?;

        let mut read = Labelled::default();
        let refuse = |_, problem: String, remedy| Error::MeshFormat {
            file: self.file.into(),
            problem,
            remedy,
        };
        let nodes = step
            .group("NOE")
            .map_err(|reason| self.fails("NOE", &reason.to_string()))?;
        let coordinates = self.reals(&nodes, "COO")?;
        let (count, rest) = (coordinates.len() / 3, coordinates.len() % 3);
        if rest > 0 {
            return Err(self.fails("NOE/COO", "nodes in space have three coordinates each"));
        }
        for node in 0..count {
            let position = [0, 1, 2].map(|axis| coordinates[axis * count + node]);
            read.node(0, node as u64 + 1, position, &refuse)?;
        }
        let mut members: BTreeMap<String, [Vec<u64>; 2]> = BTreeMap::new();
        for (node, family) in (1..).zip(self.optional(&nodes, "FAM")?) {
            for group in of_nodes.get(&family).into_iter().flatten() {
                members.entry(group.clone()).or_default()[0].push(node);
            }
        }
        let (mut label, mut solids) = (0, 0);
        for elements in self.groups(step, "MAI")? {
            let name = elements.name();
            let Some((_, size, kind)) = TYPES.iter().find(|(known, ..)| *known == name) else {
                return Err(Error::MeshFormat {
                    file: self.file.into(),
                    problem: format!("elements of type {name} cannot be read"),
                    remedy: "mesh solids as tetrahedra, wedges or hexahedra of first or second order (20 nodes)",
                });
            };
            let nodes = self.integers(&elements, "NOD")?;
            let count = nodes.len() / size;
            let families = self.optional(&elements, "FAM")?;
            let mut own = Vec::with_capacity(*size);
            for element in 0..count {
                label += 1;
                own.clear();
                for place in 0..*size {
                    let node = u64::try_from(nodes[place * count + element]);
                    own.push(node.map_err(|_| self.fails(name, "a node has a negative number"))?);
                }
                match kind {
                    Kind::Solid(row, order) => {
                        let ours: Vec<u64> = order.iter().map(|place| own[*place]).collect();
                        read.element(0, label, Shape::Solid(row), &ours, [None; 2]);
                        solids += 1;
                    }
                    Kind::Facet(corners) => read.element(0, label, Shape::Facet(*corners), &own[..*corners], [None; 2]),
                    Kind::Nodes => read.element(0, label, Shape::Nodes, &own, [None; 2]),
                }
                let family = families.get(element).copied().unwrap_or(0);
                for group in of_elements.get(&family).into_iter().flatten() {
                    members.entry(group.clone()).or_default()[1].push(label);
                }
            }
        }
        if solids == 0 {
            return Err(refuse(
                0,
                "the file holds no solids".into(),
                "mesh in three dimensions, and save the volumes too",
            ));
        }
        for (name, [nodes, elements]) in members {
            let group = read.group(name);
            if !nodes.is_empty() {
                read.node_set(group, nodes);
            }
            if !elements.is_empty() {
                read.set(group, elements);
            }
        }
        read.finish(&refuse)?.finish(self.file)
    }

    /// The groups in a group.
    fn groups(&self, parent: &Group, name: &str) -> Result<Vec<Group>, Error> {
        let found = parent.group(name).and_then(|group| group.groups());
        found.map_err(|reason| self.fails(name, &reason.to_string()))
    }

    /// Names of the groups of each family.
    fn families(&self, mesh: Option<&Group>, kind: &str) -> Result<BTreeMap<i64, Vec<String>>, Error> {
        let mut families = BTreeMap::new();
        let Some(all) = mesh.and_then(|mesh| mesh.group(kind).ok()) else {
            return Ok(families);
        };
        for family in all.groups().map_err(|reason| self.fails(kind, &reason.to_string()))? {
            let name = family.name().to_owned();
            let number = family.attribute("NUM").and_then(|number| number.read_as_f64());
            let number = number.map_err(|reason| self.fails(&name, &reason.to_string()))?;
            let Some(names) = family.group("GRO").and_then(|groups| groups.dataset("NOM")).ok() else {
                continue;
            };
            let bytes = names.read_raw_bytes();
            let bytes = bytes.map_err(|reason| self.fails(&name, &reason.to_string()))?;
            let names = bytes.chunks(NAME).map(|name| {
                let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
                String::from_utf8_lossy(&name[..end]).trim().to_owned()
            });
            families.insert(number as i64, names.filter(|name| !name.is_empty()).collect());
        }
        Ok(families)
    }

    fn dataset(&self, group: &Group, name: &str) -> Result<Dataset, Error> {
        let set = group.dataset(name);
        let set = set.map_err(|reason| self.fails(&format!("{}/{name}", group.name()), &reason.to_string()))?;
        match set.num_elements() {
            Ok(count) if count <= self.most as u64 => Ok(set),
            _ => Err(self.fails(name, "it is larger than the file")),
        }
    }

    fn reals(&self, group: &Group, name: &str) -> Result<Vec<f64>, Error> {
        let read = self.dataset(group, name)?.read_array::<f64>();
        let read = read.map_err(|reason| self.fails(name, &reason.to_string()))?;
        Ok(read.into_iter().collect())
    }

    fn integers(&self, group: &Group, name: &str) -> Result<Vec<i64>, Error> {
        let set = self.dataset(group, name)?;
        let read = match set.dtype() {
            Datatype::FixedPoint { size: 4, .. } => set
                .read_array::<i32>()
                .map(|all| all.into_iter().map(i64::from).collect()),
            _ => set.read_array::<i64>().map(|all| all.into_iter().collect()),
        };
        read.map_err(|reason| self.fails(name, &reason.to_string()))
    }

    /// None where there are none.
    fn optional(&self, group: &Group, name: &str) -> Result<Vec<i64>, Error> {
        match group.dataset(name) {
            Ok(_) => self.integers(group, name),
            Err(_) => Ok(Vec::new()),
        }
    }
}
