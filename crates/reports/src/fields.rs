//! Fields of the interface as means over its elements, for pictures and files.

use crate::{Error, csv};
use analyses::{Fields, Run};
use contact_laws::Regime;
use finite_elements::formats::vtu::{self, Encoding, Field};
use finite_elements::mesh::Face;
use zte_assembly::{InterfaceMesh, flux};

/// An interface and where it lies.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// In its plane (m).
    pub mesh: &'a InterfaceMesh,
    /// Unit vectors in the coordinates of the model as rows: two in the interface, and the normal from the top body into the bottom
    /// one.
    pub frame: [[f64; 3]; 3],
    /// The same at each node, where the interface is curved or has parts in different planes; otherwise empty.
    pub node_frames: &'a [[[f64; 3]; 3]],
    /// Position of each node in the coordinates of the model (m), where it is known.
    pub positions: Option<&'a [[f64; 3]]>,
}

impl<'a> From<&'a Run> for Placed<'a> {
    fn from(run: &'a Run) -> Self {
        Self {
            mesh: &run.joint.mesh,
            frame: run.joint.frame,
            node_frames: &run.joint.node_frames,
            positions: run.joint.positions.as_deref(),
        }
    }
}

impl Placed<'_> {
    /// A vector at an element, of components along the rows of its frame, in the coordinates of the model.
    pub(crate) fn turned(&self, element: usize, local: [f64; 3]) -> [f64; 3] {
        let along =
            |frame: &[[f64; 3]; 3]| [0, 1, 2].map(|c| (0..3).map(|axis| local[axis] * frame[axis][c]).sum::<f64>());
        if self.node_frames.is_empty() {
            return along(&self.frame);
        }
        let nodes = self.mesh.elements[element].nodes();
        let mut mean = [0.0; 3];
        for &node in nodes {
            let at_node = along(&self.node_frames[node as usize]);
            (0..3).for_each(|c| mean[c] += at_node[c] / nodes.len() as f64);
        }
        mean
    }

    /// From where a map sees the interface whose first direction is to the right and whose second is upwards.
    pub fn view(&self) -> String {
        if self.positions.is_none() {
            return "x of the interface to the right, y upwards".into();
        }
        let [right, up, normal] = self.frame;
        // Normal component of right x up, which points to the eye.
        let to_the_eye: f64 = (0..3)
            .map(|c| (c, (c + 1) % 3, (c + 2) % 3))
            .map(|(c, next, last)| (right[next] * up[last] - right[last] * up[next]) * normal[c])
            .sum();
        let side = if to_the_eye > 0.0 {
            "against the normal n = {}, from the bottom body"
        } else {
            "along the normal n = {}, from the top body"
        };
        let side = side.replace("{}", &components(normal));
        format!(
            "seen {side}; to the right is {}, upwards {}",
            components(right),
            components(up)
        )
    }

    /// What is said along the axes of a map: by which factor a coordinate in the plane (m) is multiplied to give what is named. Names are
    /// those of the model's axes where the directions are parallel to them.
    pub(crate) fn axes(&self) -> [(f64, String); 2] {
        const NAMES: [&str; 3] = ["x", "y", "z"];
        [0, 1].map(|direction| {
            let along = self.frame[direction];
            let parallel = (0..3).find(|&c| (along[c].abs() - 1.0).abs() < 1e-12);
            match (self.positions, parallel) {
                (None, _) => (1e3, format!("{} of the interface [mm]", NAMES[direction])),
                (Some(_), Some(axis)) => (1e3 * along[axis].signum(), format!("{} [mm]", NAMES[axis])),
                (Some(_), None) => (1e3, format!("along {} [mm]", components(along))),
            }
        })
    }
}

/// A direction in words.
fn components(direction: [f64; 3]) -> String {
    let text = direction.map(|x| {
        // Three digits suffice for the eye; adding zero turns -0 into 0.
        let rounded = (1e3 * x).round() / 1e3 + 0.0;
        rounded.to_string()
    });
    format!("({})", text.join(", "))
}

/// Numbers of each interface element.
pub struct CellField {
    name: &'static str,
    components: usize,
    values: Vec<f64>,
}

impl CellField {
    /// One number per element; the name has its unit in brackets.
    pub fn scalar(name: &'static str, values: Vec<f64>) -> Self {
        Self {
            name,
            components: 1,
            values,
        }
    }

    /// A vector per element, from its components along the rows of the frame to those along the axes of the model.
    fn vector(name: &'static str, place: &Placed<'_>, [x, y, n]: [&[f64]; 3]) -> Self {
        let local = x.iter().zip(y).zip(n);
        Self {
            name,
            components: 3,
            values: local
                .enumerate()
                .flat_map(|(element, ((&x, &y), &n))| place.turned(element, [x, y, n]))
                .collect(),
        }
    }
}

/// The interface as a VTK file with the fields of its elements. Nodes are where they are in the model; where that is not known, in the
/// plane of the interface with the third coordinate zero. Points of contact are nodes with the fields, and there are no cells.
///
/// # Errors
/// [`Error::Fields`].
pub fn vtu(place: Placed<'_>, cells: Vec<CellField>) -> Result<String, Error> {
    let mesh = place.mesh;
    let in_plane = || mesh.nodes.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let nodes: Vec<[f64; 3]> = place.positions.map_or_else(in_plane, <[_]>::to_vec);
    // Every shape of an interface element is the shape of a face.
    let faces: Vec<Face> = mesh
        .elements
        .iter()
        .filter_map(|element| Face::from_nodes(element.nodes()))
        .collect();
    let cells: Vec<Field> = cells
        .into_iter()
        .map(|cell| Field {
            name: cell.name.to_owned(),
            components: cell.components,
            values: cell.values,
        })
        .collect();
    // Text cannot carry the sign of infinities.
    let infinite = cells.iter().flat_map(|cell| &cell.values).any(|v| v.is_infinite());
    let encoding = if infinite { Encoding::Base64 } else { Encoding::Ascii };
    let (of_nodes, of_faces) = match mesh.is_of_points() {
        // Each element is the node of its number.
        true => (cells, Vec::new()),
        false => (Vec::new(), cells),
    };
    vtu::write_surface(&nodes, &faces, &of_nodes, &of_faces, encoding).map_err(Error::Fields)
}

/// A list of VTK files for ParaView, each with its time; files of one time are its parts.
pub fn collection(files: &[(f64, String)]) -> String {
    let mut before: Option<(f64, usize)> = None;
    let sets = files.iter().map(|(time, file)| {
        let part = before.filter(|(last, _)| last == time).map_or(0, |(_, part)| part + 1);
        before = Some((*time, part));
        format!(
            "<DataSet timestep=\"{}\" part=\"{part}\" file=\"{file}\"/>\n",
            csv::number(*time)
        )
    });
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n{}\
         </Collection>\n</VTKFile>\n",
        sets.collect::<String>()
    )
}

/// Dissipation per area and cycle over all directions (J/m^2), per element.
pub fn total_flux(run: &Run, fields: &Fields) -> Vec<f64> {
    run.interface.operators().element_means(&flux::total(&fields.flux))
}

/// Pressure (Pa), per element.
pub fn pressure(run: &Run, fields: &Fields) -> Vec<f64> {
    run.interface.operators().element_means(&fields.traction[2])
}

/// Positions of the quadrature points in the coordinates of the model (m), where those of the nodes are known.
pub fn point_positions(run: &Run) -> Option<Vec<[f64; 3]>> {
    let nodes = run.joint.positions.as_ref()?;
    Some(analyses::point_positions(run.interface.operators(), nodes))
}

/// All fields that are stored. Tractions are those that the top body exerts on the bottom one, jumps the motion of the top body less that
/// of the bottom one; names of components along the directions of the interface begin with `local`.
pub fn cell_fields(run: &Run, fields: &Fields) -> Vec<CellField> {
    let operators = run.interface.operators();
    let mean = |name, values: &[f64]| CellField::scalar(name, operators.element_means(values));
    let fraction = |name, regime: Regime| {
        let indicator: Vec<f64> = fields
            .regime
            .iter()
            .map(|r| if *r == regime { 1.0 } else { 0.0 })
            .collect();
        mean(name, &indicator)
    };
    let mut cells = vec![
        mean("pressure [Pa]", &fields.traction[2]),
        mean("local_traction_x [Pa]", &fields.traction[0]),
        mean("local_traction_y [Pa]", &fields.traction[1]),
        mean("interference [m]", &fields.jump[2]),
        mean("local_jump_x [m]", &fields.jump[0]),
        mean("local_jump_y [m]", &fields.jump[1]),
        mean("local_flux_x [J/m^2]", &fields.flux[0]),
        mean("local_flux_y [J/m^2]", &fields.flux[1]),
        mean("flux_n [J/m^2]", &fields.flux[2]),
        CellField::scalar("flux_total [J/m^2]", total_flux(run, fields)),
        fraction("slip_area_fraction [-]", Regime::Slip),
        fraction("open_area_fraction [-]", Regime::Open),
    ];
    let place = Placed::from(run);
    if place.positions.is_some() {
        let [tractions, jumps] =
            [&fields.traction, &fields.jump].map(|of| of.each_ref().map(|v| operators.element_means(v)));
        let [x, y, n] = tractions.each_ref().map(Vec::as_slice);
        cells.push(CellField::vector("traction [Pa]", &place, [x, y, n]));
        let [x, y, n] = jumps.each_ref().map(Vec::as_slice);
        // Its normal part is the interference, from which the gap is subtracted.
        let none = vec![0.0; n.len()];
        cells.push(CellField::vector("tangential_jump [m]", &place, [x, y, &none]));
    }
    cells
}
