//! Fields of the interface as means over its elements, for pictures and files.

use crate::Error;
use contact_laws::Regime;
use joint_pipeline::Run;
use joint_pipeline::analysis::Fields;
use substructure::formats::vtu::{self, Encoding, Field};
use substructure::mesh::Face;
use zte_assembly::InterfaceMesh;

/// One value per interface element.
pub struct CellField {
    /// Name with its unit in brackets.
    pub name: &'static str,
    /// In the order of the elements.
    pub values: Vec<f64>,
}

/// The interface as a VTK file with one value per element of each field; nodes have the third coordinate zero. Points of contact are
/// nodes with the fields, and there are no cells.
///
/// # Errors
/// [`Error::Fields`].
pub fn vtu(mesh: &InterfaceMesh, cells: Vec<CellField>) -> Result<String, Error> {
    let nodes: Vec<[f64; 3]> = mesh.nodes.iter().map(|&[x, y]| [x, y, 0.0]).collect();
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
            components: 1,
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

/// Dissipation per area and cycle over all directions (J/m^2), per element.
pub fn total_flux(run: &Run, fields: &Fields) -> Vec<f64> {
    let [x, y, n] = &fields.flux;
    let total: Vec<f64> = x.iter().zip(y).zip(n).map(|((x, y), n)| x + y + n).collect();
    run.interface.operators().element_means(&total)
}

/// Pressure (Pa), per element.
pub fn pressure(run: &Run, fields: &Fields) -> Vec<f64> {
    run.interface.operators().element_means(&fields.traction[2])
}

/// All fields that are stored.
pub fn cell_fields(run: &Run, fields: &Fields) -> Vec<CellField> {
    let mean = |name, values: &[f64]| CellField {
        name,
        values: run.interface.operators().element_means(values),
    };
    let fraction = |name, regime: Regime| {
        let indicator: Vec<f64> = fields
            .regime
            .iter()
            .map(|r| if *r == regime { 1.0 } else { 0.0 })
            .collect();
        mean(name, &indicator)
    };
    vec![
        mean("pressure [Pa]", &fields.traction[2]),
        mean("traction_x [Pa]", &fields.traction[0]),
        mean("traction_y [Pa]", &fields.traction[1]),
        mean("interference [m]", &fields.jump[2]),
        mean("flux_x [J/m^2]", &fields.flux[0]),
        mean("flux_y [J/m^2]", &fields.flux[1]),
        mean("flux_n [J/m^2]", &fields.flux[2]),
        CellField {
            name: "flux_total [J/m^2]",
            values: total_flux(run, fields),
        },
        fraction("slip_area_fraction [-]", Regime::Slip),
        fraction("open_area_fraction [-]", Regime::Open),
    ]
}
