//! The solids, facets and groups of bulk data.

use super::cards::{Card, Source};
use super::systems::{Given, Systems};
use crate::Error;
use crate::elements::{ElementType, HEX8, HEX20, TET4, TET10, WEDGE6, WEDGE15};
use crate::formats::labelled::{Labelled, Shape, Which};
use crate::formats::solid_mesh::SolidMesh;
use std::collections::BTreeMap;

/// A kind of solid: its card, its type without and with nodes in the middles of edges, and the order of the latter in the file.
struct Solid {
    card: &'static str,
    linear: &'static ElementType,
    quadratic: &'static ElementType,
    /// For each of the crate's nodes its place in the file.
    order: &'static [usize],
}

static SOLIDS: [Solid; 3] = [
    Solid {
        card: "CTETRA",
        linear: &TET4,
        quadratic: &TET10,
        order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
    },
    Solid {
        card: "CPENTA",
        linear: &WEDGE6,
        quadratic: &WEDGE15,
        order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11],
    },
    Solid {
        card: "CHEXA",
        linear: &HEX8,
        quadratic: &HEX20,
        order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15],
    },
];

struct Reader<'s> {
    source: &'s Source,
    mesh: Labelled,
    nodes: Vec<Given>,
    systems: Systems,
    /// The system of nodes that name none.
    default_system: u64,
    /// Cards that are not read, and how many of each.
    others: BTreeMap<String, usize>,
    /// Material of each property of solids.
    material_of: BTreeMap<u64, u64>,
    /// Young's modulus, shear modulus, Poisson's ratio and density of materials, as they are written.
    materials: BTreeMap<u64, [String; 4]>,
    solids: usize,
}

pub(super) fn read(source: &Source) -> Result<SolidMesh, Error> {
    let mut reader = Reader {
        source,
        mesh: Labelled::default(),
        nodes: Vec::new(),
        systems: Systems::default(),
        default_system: 0,
        others: BTreeMap::new(),
        material_of: BTreeMap::new(),
        materials: BTreeMap::new(),
        solids: 0,
    };
    let mut names = BTreeMap::new();
    source.cards(
        |card| reader.card(&card),
        |comment| {
            if let Some((property, name)) = named_property(comment) {
                names.insert(property, name);
            }
        },
    )?;
    let Reader {
        mut mesh,
        nodes,
        systems,
        default_system,
        others,
        material_of,
        materials,
        solids,
        ..
    } = reader;
    if solids == 0 {
        return Err(source.contents(
            source.last(),
            "the file holds no solids".into(),
            "mesh in three dimensions, and save CTETRA, CPENTA or CHEXA",
        ));
    }
    let mut nodes = nodes;
    for node in nodes.iter_mut().filter(|node| node.system == u64::MAX) {
        node.system = default_system;
    }
    systems.place(source, &nodes, &mut mesh)?;
    for (property, material) in &material_of {
        if let Some([e, g, nu, density]) = materials.get(material) {
            mesh.notes.push(format!(
                "the file gives for `PSOLID={property}`, in its units, E {e}, G {g}, NU {nu}, RHO {density}; materials are those of the scene"
            ));
        }
    }
    for (property, name) in names {
        mesh.rename(&format!("PSOLID={property}"), name);
        mesh.rename(&format!("PSHELL={property}"), name);
    }
    if !others.is_empty() {
        let counts: Vec<String> = others.iter().map(|(name, count)| format!("{count} {name}")).collect();
        mesh.notes.push(format!(
            "not read from a mesh: {}; bolts, masses, springs and supports are given by the scene",
            counts.join(", ")
        ));
    }
    mesh.finish(&|at, problem, remedy| source.contents(at, problem, remedy))?
        .finish(source.name())
}

impl Reader<'_> {
    fn card(&mut self, card: &Card<'_>) -> Result<(), Error> {
        let source = self.source;
        match card.name.as_str() {
            "GRID" => {
                self.nodes.push(Given {
                    at: card.at,
                    label: card.integer(source, 0)?,
                    // Nodes that name no system have that of GRDSET, which may come later.
                    system: match card.field(1) {
                        "" => u64::MAX,
                        _ => card.integer(source, 1)?,
                    },
                    position: card.triple(source, 2)?,
                });
            }
            "GRDSET" => self.default_system = card.integer_or_zero(source, 1)?,
            "CORD1R" | "CORD1C" | "CORD1S" | "CORD2R" | "CORD2C" | "CORD2S" => self.systems.define(source, card)?,
            "CTETRA" | "CPENTA" | "CHEXA" => self.solid(card)?,
            "CTRIA3" | "CTRIA6" | "CTRIAR" => self.facet(card, 3)?,
            "CQUAD4" | "CQUAD8" | "CQUADR" => self.facet(card, 4)?,
            "CPYRAM" => {
                return Err(source.unsupported(
                    card.at,
                    "a pyramid".into(),
                    "mesh solids as tetrahedra, wedges or hexahedra",
                ));
            }
            "CBAR" | "CBEAM" | "CROD" | "CBUSH" => {
                let nodes = [card.integer(source, 2)?, card.integer_or_zero(source, 3)?];
                let nodes = &nodes[..1 + usize::from(nodes[1] > 0)];
                let group = self.mesh.group(format!("{}={}", card.name, card.field(1)));
                let label = card.integer(source, 0)?;
                self.mesh
                    .element(card.at, label, Shape::Nodes, nodes, [Some(group), None]);
                self.count(card);
            }
            "RBE2" => {
                // The coefficient of expansion at the end is a real number.
                let all = (3..card.fields.len()).map(|number| card.field(number));
                let nodes = all.filter_map(|field| field.parse().ok()).collect();
                let group = self.mesh.group(format!("RBE2={}", card.field(0)));
                self.mesh.node_set(group, nodes);
                self.count(card);
            }
            "SPC1" => {
                let nodes = card.list(source, 2, source.last() as usize)?;
                self.nodes_of("SPC", card.field(0), nodes);
            }
            "SPC" => {
                for first in [1, 4] {
                    if !card.field(first).is_empty() {
                        let node = card.integer(source, first)?;
                        self.nodes_of("SPC", card.field(0), vec![node]);
                    }
                }
            }
            // A set may also be of elements, or of what the file does not have.
            "SET1" => match card.list(source, 1, source.last() as usize) {
                Ok(nodes) => self.nodes_of("SET", card.field(0), nodes),
                Err(_) => self.count(card),
            },
            "PLOAD4" => self.face(card)?,
            "BSURFS" => {
                let group = self.mesh.group(format!("BSURFS={}", card.field(0)));
                let mut first = 4;
                while !card.field(first).is_empty() {
                    let corners = [1, 2, 3].map(|place| card.integer(source, first + place));
                    let [a, b, c] = corners;
                    let which = Which::Through([a?, b?, c?]);
                    self.mesh.face(card.at, group, card.integer(source, first)?, which);
                    first += 4;
                }
            }
            "PSOLID" => {
                self.material_of
                    .insert(card.integer(source, 0)?, card.integer_or_zero(source, 1)?);
            }
            "MAT1" => {
                let values = [1, 2, 3, 4].map(|number| match card.field(number) {
                    "" => "-".to_owned(),
                    text => text.to_owned(),
                });
                self.materials.insert(card.integer(source, 0)?, values);
            }
            // Replication of the card before, with steps.
            name if name.starts_with('=') => {
                return Err(source.unsupported(
                    card.at,
                    "a card that repeats the one before it".into(),
                    "write all cards out",
                ));
            }
            _ => self.count(card),
        }
        Ok(())
    }

    fn count(&mut self, card: &Card<'_>) {
        const MOST: usize = 200;
        let name = match self.others.len() < MOST || self.others.contains_key(&card.name) {
            true => card.name.clone(),
            false => "others".to_owned(),
        };
        *self.others.entry(name).or_default() += 1;
    }

    fn nodes_of(&mut self, kind: &str, number: &str, nodes: Vec<u64>) {
        let group = self.mesh.group(format!("{kind}={number}"));
        self.mesh.node_set(group, nodes);
    }

    fn solid(&mut self, card: &Card<'_>) -> Result<(), Error> {
        let source = self.source;
        let Some(kind) = SOLIDS.iter().find(|kind| kind.card == card.name) else {
            return Ok(());
        };
        let label = card.integer(source, 0)?;
        let corners = kind.linear.n_nodes();
        let middles = 2 + corners..2 + kind.quadratic.n_nodes();
        let given = middles
            .clone()
            .filter(|number| !matches!(card.field(*number), "" | "0"))
            .count();
        let (row, count) = match given {
            0 => (kind.linear, corners),
            all if all == middles.len() => (kind.quadratic, kind.quadratic.n_nodes()),
            _ => {
                return Err(source.unsupported(
                    card.at,
                    format!("element {label} without some of its middle nodes"),
                    "mesh solids with all middle nodes or none",
                ));
            }
        };
        let mut nodes = Vec::with_capacity(count);
        for place in &kind.order[..count] {
            nodes.push(card.integer(source, 2 + place)?);
        }
        let group = self.mesh.group(format!("PSOLID={}", card.field(1)));
        self.mesh
            .element(card.at, label, Shape::Solid(row), &nodes, [Some(group), None]);
        self.solids += 1;
        Ok(())
    }

    fn facet(&mut self, card: &Card<'_>, corners: usize) -> Result<(), Error> {
        let source = self.source;
        let mut nodes = Vec::with_capacity(corners);
        for number in 0..corners {
            nodes.push(card.integer(source, 2 + number)?);
        }
        let group = self.mesh.group(format!("PSHELL={}", card.field(1)));
        let label = card.integer(source, 0)?;
        self.mesh
            .element(card.at, label, Shape::Facet(corners), &nodes, [Some(group), None]);
        Ok(())
    }

    /// A pressure on the face of a solid; those on shells name no nodes.
    fn face(&mut self, card: &Card<'_>) -> Result<(), Error> {
        let source = self.source;
        let (a, b) = (card.integer_or_zero(source, 6).unwrap_or(0), card.field(7));
        if a == 0 {
            self.count(card);
            return Ok(());
        }
        let which = match b {
            "" => Which::Triangle(a),
            _ => Which::Diagonal(a, card.integer(source, 7)?),
        };
        let group = self.mesh.group(format!("PLOAD4={}", card.field(0)));
        self.mesh.face(card.at, group, card.integer(source, 1)?, which);
        Ok(())
    }
}

/// Number and name of a property in a comment of HyperMesh, `$HMNAME PROP 1"name" 4`, or of Femap,
/// `$ Femap Property 1 : name`.
fn named_property(comment: &str) -> Option<(u64, &str)> {
    if let Some(rest) = comment.strip_prefix("$HMNAME PROP") {
        let (number, rest) = rest.split_once('"')?;
        let (name, _) = rest.split_once('"')?;
        return Some((number.trim().parse().ok()?, name.trim())).filter(|(_, name)| !name.is_empty());
    }
    let rest = comment.strip_prefix("$ Femap")?;
    let (_, rest) = rest.split_once("Property ")?;
    let (number, name) = rest.split_once(':')?;
    Some((number.trim().parse().ok()?, name.trim())).filter(|(_, name)| !name.is_empty())
}
