//! What is computed with: sizes, materials, surface, bolts and units, told before anything is computed.

use super::Structure;
use crate::Error;
use finite_elements::mesh::Mesh;
use joint_model::fit::Fit;
use joint_model::{Bodies, significant};
use scenes::{Density, MaterialSource, Scene, StructureSource, Surface, Units};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use zte_assembly::InterfaceMesh;

/// A structure and what loads it, as read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Overview {
    /// Units of the file of the structure: length, mass or force, time; none of a benchmark.
    pub units: Option<String>,
    /// Extents of the structure along the axes of the model (m); none of matrices.
    pub size: Option<[f64; 3]>,
    /// Mass (kg), that of bolts and point masses included; none where it is not known.
    pub mass: Option<f64>,
    /// Nodes of the solid mesh.
    pub n_nodes: Option<usize>,
    /// Its elements.
    pub n_elements: Option<usize>,
    /// Names of the interfaces, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub interfaces: Vec<String>,
    /// Interface elements, or points of contact.
    pub n_interface_elements: usize,
    /// Area of the interface (m^2).
    pub interface_area: f64,
    /// Materials of the bodies.
    pub materials: Vec<MaterialOverview>,
    /// What the asperities and the gap follow from, in words.
    pub surface: String,
    /// Bolts.
    pub bolts: BoltOverview,
    /// Torque of the bolts, where the scene knows their thread, and the order in which they are tightened, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tightening: Vec<String>,
    /// Motions without energy that the structure with a stuck interface should have.
    pub rigid_motions: usize,
    /// How the geometry of a mesh fits what the scene says of it.
    #[serde(default)]
    pub fit: Fit,
}

/// A material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MaterialOverview {
    /// Its name.
    pub name: String,
    /// Where it comes from, in words.
    pub source: String,
    /// Young's modulus (Pa).
    pub youngs_modulus: f64,
    /// Poisson ratio (-).
    pub poisson_ratio: f64,
    /// Density (kg/m^3); none where nothing needs it.
    pub density: Option<f64>,
}

/// Bolts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BoltOverview {
    /// How many.
    pub count: usize,
    /// Tension of each (N); their mean where they differ.
    pub load_each: f64,
    /// Tension of all (N).
    pub total_load: f64,
    /// All tension over the area of the interface (Pa).
    pub nominal_pressure: f64,
}

impl Structure {
    /// What is known of a structure and of what a scene does with it before anything is computed.
    ///
    /// # Errors
    /// Of the quadrature of the interface; a shank without length.
    pub fn overview(&self, scene: &Scene) -> Result<Overview, Error> {
        let area = self.symmetry.operators(&self.joint.interface, 2)?.area();
        let count = self.n_bolts();
        let (mesh, mass) = match &self.joint.bodies {
            Bodies::Imported(bodies) => (None, bodies.mass),
            Bodies::Meshed(bodies) => {
                let assembly = &bodies.assembly;
                let points: f64 = assembly.masses.iter().map(|point| point.mass).sum();
                let all = mass(&assembly.mesh) + points + assembly.mass_at_references()?;
                (Some(&assembly.mesh), Some(all))
            }
        };
        let total_load: f64 = (0..count).map(|bolt| scene.tension(bolt)).sum();
        let load_each = match scene.bolts.loads.is_empty() || count == 0 {
            true => scene.bolts.load.si(),
            false => total_load / count as f64,
        };
        Ok(Overview {
            units: units(scene),
            size: mesh.map(size),
            mass,
            n_nodes: mesh.map(|mesh| mesh.nodes.len()),
            n_elements: mesh.map(|mesh| mesh.elements.len()),
            interfaces: match self.joint.parts.len() {
                0 | 1 => Vec::new(),
                _ => self.joint.parts.iter().map(|part| part.name.clone()).collect(),
            },
            n_interface_elements: self.joint.interface.elements.len(),
            interface_area: area,
            materials: materials(scene, mesh),
            surface: surface(scene),
            bolts: BoltOverview {
                count,
                load_each,
                total_load,
                nominal_pressure: total_load / area,
            },
            tightening: tightening(scene, count),
            rigid_motions: self.settings.expected_zem,
            fit: self.joint.fit.clone(),
        })
    }

    /// Area of each part of the interface (m^2), with the name of the part; one without a name where there are no parts.
    ///
    /// # Errors
    /// Of the quadrature of the interface.
    pub fn areas(&self) -> Result<Vec<(String, f64)>, Error> {
        let area = |mesh: &InterfaceMesh| Ok::<_, Error>(self.symmetry.operators(mesh, 2)?.area());
        let joint = &self.joint;
        match joint.parts.is_empty() {
            true => Ok(vec![(String::new(), area(&joint.interface)?)]),
            false => {
                let parts = joint.parts.iter();
                parts
                    .map(|part| Ok((part.name.clone(), area(&part.mesh(&joint.interface))?)))
                    .collect()
            }
        }
    }
}

impl Overview {
    /// In a few plain lines.
    pub fn lines(&self) -> Vec<String> {
        let size = self.size.map_or_else(
            || "size not known".to_owned(),
            |size| {
                let [x, y, z] = size.map(|extent| significant(1e3 * extent));
                format!("{x} x {y} x {z} mm")
            },
        );
        let mass = self.mass.map_or_else(
            || "mass not known".to_owned(),
            |mass| format!("{} kg", significant(mass)),
        );
        let mesh = match (self.n_nodes, self.n_elements) {
            (Some(nodes), Some(elements)) => format!("{nodes} nodes, {elements} elements"),
            _ => "matrices".to_owned(),
        };
        let read = self.units.as_ref().map(|units| format!("; read in {units}"));
        let mut lines = vec![
            format!("structure: {size}, {mass}; {mesh}{}", read.unwrap_or_default()),
            format!(
                "expected with a stuck interface: {} motions without energy",
                self.rigid_motions
            ),
        ];
        const MOST: usize = 3;
        lines.extend(self.materials.iter().take(MOST).map(MaterialOverview::line));
        if self.materials.len() > MOST {
            lines.push(format!("and {} more materials", self.materials.len() - MOST));
        }
        lines.push(format!("surface: {}", self.surface));
        let bolts = &self.bolts;
        lines.push(match bolts.count {
            0 => "no bolts".to_owned(),
            count => format!(
                "bolts: {count} with {} kN each, {} kN together",
                significant(1e-3 * bolts.load_each),
                significant(1e-3 * bolts.total_load)
            ),
        });
        lines.extend(self.tightening.iter().cloned());
        let name = match self.interfaces.len() {
            0 => "interface".to_owned(),
            count => format!("{count} interfaces ({})", self.interfaces.join(", ")),
        };
        lines.push(format!(
            "{name}: {} elements, {} mm^2, nominal pressure {} MPa",
            self.n_interface_elements,
            significant(1e6 * self.interface_area),
            significant(1e-6 * bolts.nominal_pressure)
        ));
        lines.extend(self.fit.lines());
        lines
    }
}

impl MaterialOverview {
    /// In one line.
    pub fn line(&self) -> String {
        let density = self.density.map_or_else(
            || "density not given".to_owned(),
            |density| format!("{} kg/m^3", significant(density)),
        );
        format!(
            "material {}: E {} GPa, nu {}, {density} ({})",
            self.name,
            significant(1e-9 * self.youngs_modulus),
            significant(self.poisson_ratio),
            self.source
        )
    }
}

/// The name by which scenes and summaries call a choice.
pub fn choice_name(choice: &impl Serialize) -> String {
    match serde_json::to_value(choice) {
        Ok(Value::String(text)) => text,
        // An option with parameters is written as an object with its name as the only key.
        Ok(Value::Object(map)) => map.keys().next().cloned().unwrap_or_default(),
        _ => String::new(),
    }
}

fn tightening(scene: &Scene, bolts: usize) -> Vec<String> {
    let torque = scene.torque_report(bolts).map(|report| report.line());
    let order = scene.analyses.tightening.as_ref().map(|plan| {
        let order: Vec<String> = plan.order.iter().map(usize::to_string).collect();
        let passes: Vec<String> = plan
            .passes
            .iter()
            .map(|share| format!("{} %", significant(100.0 * share)))
            .collect();
        format!(
            "tightened in the order {}, to {} of the load",
            order.join(", "),
            passes.join(", ")
        )
    });
    torque.into_iter().chain(order).collect()
}

fn units(scene: &Scene) -> Option<String> {
    let of: &Units = match &scene.structure.source {
        StructureSource::Benchmark(_) => return None,
        StructureSource::Deck(deck) => &deck.units,
        StructureSource::Mesh(mesh) => {
            // Only lengths are read from a mesh.
            let symbols = serde_json::to_value(mesh.units).unwrap_or_default();
            return symbols["length"].as_str().map(str::to_owned);
        }
        StructureSource::Matrices(matrices) => &matrices.units,
    };
    let symbols = serde_json::to_value(of).unwrap_or_default();
    let symbols = ["length", "mass", "force", "time"].map(|quantity| symbols[quantity].as_str().map(str::to_owned));
    Some(symbols.into_iter().flatten().collect::<Vec<_>>().join(", "))
}

fn surface(scene: &Scene) -> String {
    let source = match &scene.interfaces.surface {
        Surface::Benchmark(benchmark) => format!("measured statistics of {benchmark:?}"),
        Surface::Measured => "measured statistics of the benchmark".to_owned(),
        other => choice_name(other).replace('-', " "),
    };
    format!(
        "{source}; gap: {}; mu {}",
        choice_name(&scene.interfaces.gap),
        scene.interfaces.mu
    )
}

fn materials(scene: &Scene, mesh: Option<&Mesh>) -> Vec<MaterialOverview> {
    let Some(mesh) = mesh else {
        let of = |material: &scenes::Material| MaterialOverview {
            name: "of the contact".into(),
            source: "scene; the matrices know none".into(),
            youngs_modulus: material.youngs_modulus.si(),
            poisson_ratio: material.poisson_ratio,
            density: material.density.map(Density::si),
        };
        return scene.model.material.iter().map(of).collect();
    };
    let source = match &scene.structure.source {
        StructureSource::Deck(deck) if deck.materials != MaterialSource::Scene => "of the deck",
        _ => "of the scene",
    };
    let mut used = vec![false; mesh.materials.len()];
    mesh.elements
        .iter()
        .for_each(|element| used[usize::from(element.material)] = true);
    let mut found: Vec<MaterialOverview> = Vec::new();
    for (material, _) in mesh.materials.iter().zip(used).filter(|(_, used)| *used) {
        let own = MaterialOverview {
            name: material.name.clone(),
            source: source.into(),
            youngs_modulus: material.youngs_modulus,
            poisson_ratio: material.poisson_ratio,
            density: Some(material.density),
        };
        if !found.contains(&own) {
            found.push(own);
        }
    }
    found
}

/// Extents of the nodes of the elements.
fn size(mesh: &Mesh) -> [f64; 3] {
    let nodes = mesh.elements.iter().flat_map(|element| element.cell.nodes());
    let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for node in nodes {
        for ([low, high], x) in range.iter_mut().zip(mesh.nodes[*node as usize]) {
            (*low, *high) = (low.min(x), high.max(x));
        }
    }
    range.map(|[low, high]| high - low)
}

/// Mass of the solids (kg).
fn mass(mesh: &Mesh) -> f64 {
    let elements = mesh.elements.iter();
    elements
        .map(|element| mesh.materials[usize::from(element.material)].density * element.cell.volume(&mesh.nodes))
        .sum()
}
