//! Files of mode shapes: table, VTK file for ParaView, and a page with a picture per mode.

use crate::csv::{number, optional, table};
use crate::html::{Picture, Table, render};
use crate::interactive::bodies::{normal, sharp_edges};
use crate::interactive::{Live, Shapes};
use crate::map::rgb;
use crate::markup::escape;
use crate::styles::hex;
use crate::{Error, Output, bodies};
use askama::Template;
use finite_elements::mesh::{Face, Mesh};
use joints::structure::{Assurance, Contact, ModalModel, ModeShape, ModesOfContact};
use std::fmt::Write;

/// Name of the table.
pub const TABLE: &str = "modes.csv";

/// Name of the VTK file.
pub const SHAPES: &str = "modes.vtu";

/// Width of a picture.
pub(crate) const WIDTH: f64 = 800.0;

/// Largest displacement in a picture over the longest extent of the structure.
const DEFORMATION: f64 = 0.08;

/// Most faces that a picture fills; of finer meshes it shows edges only.
const MOST_FACES: usize = 3000;

/// Most edges of a picture.
const MOST_EDGES: usize = 6000;

/// Classes of colour: what is of one class shares a path.
const CLASSES: usize = 16;

/// Direction towards the eye along the principal axes, the longest first.
const EYE: [f64; 3] = [0.42, -0.72, 0.55];

/// Name of the displacements of a mode in the VTK file.
pub fn shape(contact: Contact, mode: usize) -> String {
    format!("{} {mode:02} [1/sqrt(kg)]", contact.name())
}

/// All files but the summary: table, VTK file, and the page, whose heading is `title` and which says `about` first.
///
/// # Errors
/// [`Error::Table`], [`Error::Shapes`], [`Error::Page`], [`Error::Summary`].
pub fn outputs(model: &ModalModel, mesh: &Mesh, title: &str, about: &str) -> Result<Vec<Output>, Error> {
    let surface = mesh.boundary();
    let all = model
        .contacts
        .iter()
        .flat_map(|of| of.modes.iter().map(|mode| (of.contact, mode)));
    let shapes = all.map(|(contact, mode)| bodies::displacement(shape(contact, mode.number), &mode.displacement));
    Ok(vec![
        Output::new(TABLE, modes_table(model)?),
        Output::new(
            SHAPES,
            bodies::vtu(mesh, &surface, shapes.collect()).map_err(Error::Shapes)?,
        ),
        Output::new("report.html", page(model, mesh, &surface, title, about)?),
    ])
}

/// One row per mode.
fn modes_table(model: &ModalModel) -> Result<String, Error> {
    let headings = [
        "kind",
        "number",
        "frequency [Hz]",
        "interface_energy [-]",
        "jump [-]",
        "effective_mass_x [kg]",
        "effective_mass_y [kg]",
        "effective_mass_z [kg]",
        "effective_inertia_x [kg m^2]",
        "effective_inertia_y [kg m^2]",
        "effective_inertia_z [kg m^2]",
        "name",
    ];
    let rows = model.contacts.iter().flat_map(|of| {
        of.modes.iter().map(move |mode| {
            let first = [
                of.contact.name().to_owned(),
                mode.number.to_string(),
                number(mode.frequency_hz),
                optional(mode.interface_energy),
                number(mode.jump),
            ];
            let effective = mode.effective_mass.iter().chain(&mode.effective_inertia);
            let effective = effective.map(|value| number(*value));
            let row = first.into_iter().chain(effective).chain([mode.name.clone()]);
            row.collect::<Vec<_>>()
        })
    });
    table(headings, rows)
}

#[derive(Template)]
#[template(path = "modes.html")]
struct Page<'a> {
    title: &'a str,
    about: &'a str,
    sections: Vec<Section>,
    assurance: Vec<Picture<'static>>,
    live: Live,
}

/// The modes with one contact.
struct Section {
    heading: String,
    remark: String,
    table: Table,
    pictures: Vec<Picture<'static>>,
}

fn page(model: &ModalModel, mesh: &Mesh, surface: &[Face], title: &str, about: &str) -> Result<String, Error> {
    let scenery = Scenery::new(model.axes, &mesh.nodes, surface);
    let sections = model.contacts.iter().map(|of| Section {
        heading: heading(of.contact).into(),
        remark: remark(model, of),
        table: numbers(of),
        pictures: of
            .modes
            .iter()
            .map(|mode| Picture {
                svg: scenery.svg(mode).into(),
                caption: format!("{}. {:.2} Hz: {}.", mode.number, mode.frequency_hz, mode.name),
            })
            .collect(),
    });
    let assurance = model.assurance.iter().map(|pair| Picture {
        svg: assurance_picture(pair).into(),
        caption: format!(
            "Modal assurance criterion in the norm of the mass: modes of the {} structure downwards, of the {} one to the right.",
            pair.rows.name(),
            pair.columns.name()
        ),
    });
    render(&Page {
        title,
        about,
        sections: sections.collect(),
        assurance: assurance.collect(),
        live: Live::shapes(&Shapes::of(model, mesh, surface))?,
    })
}

fn heading(contact: Contact) -> &'static str {
    match contact {
        Contact::Unstressed => "Unstressed: nothing holds the faces together",
        Contact::Stuck => "Stuck: the faces move together",
        Contact::Linear => "Linear interface",
        Contact::Prestressed => "Linearised about the prestress",
    }
}

fn remark(model: &ModalModel, of: &ModesOfContact) -> String {
    let mut remark = format!(
        "{} motions without energy. Residual of the modes {:.1e}, error of their orthonormality {:.1e}.",
        of.zero_energy_modes, of.residual, of.orthonormality_error
    );
    if of.contact == Contact::Linear {
        let _ = write!(
            remark,
            " Springs of {:.3e} Pa/m along the normal and {:.3e} Pa/m in the plane.",
            model.linear.normal_stiffness, model.linear.tangential_stiffness
        );
    }
    if model.contacts.last().is_some_and(|last| last.contact == of.contact) {
        let most: Vec<String> = model.joint_moved_most_by.iter().take(3).map(usize::to_string).collect();
        let _ = write!(
            remark,
            " Most of their energy in the interface have the modes {}.",
            most.join(", ")
        );
    }
    remark
}

fn numbers(of: &ModesOfContact) -> Table {
    let headings = [
        "no.",
        "frequency [Hz]",
        "shape",
        "energy in the interface [%]",
        "jump over motion [-]",
        "effective mass x, y, z [kg]",
        "effective inertia x, y, z [kg m²]",
    ];
    let three = |values: [f64; 3]| values.map(|v| format!("{v:.3}")).join(", ");
    let row = |mode: &ModeShape| {
        vec![
            mode.number.to_string(),
            format!("{:.3}", mode.frequency_hz),
            mode.name.clone(),
            mode.interface_energy
                .map_or_else(|| "–".into(), |share| format!("{:.2}", 100.0 * share)),
            format!("{:.2e}", mode.jump),
            three(mode.effective_mass),
            mode.effective_inertia.map(|v| format!("{v:.2e}")).join(", "),
        ]
    };
    Table {
        headings: headings.map(Into::into).into(),
        rows: of.modes.iter().map(row).collect(),
    }
}

/// The surface of a structure, seen from one side.
pub(crate) struct Scenery<'a> {
    surface: &'a [Face],
    nodes: &'a [[f64; 3]],
    /// To the right, upwards and to the eye.
    view: [[f64; 3]; 3],
    /// Edges between faces at an angle, and at holes of the surface.
    edges: Vec<[u32; 2]>,
    /// Corners of the box around the structure in the picture (m).
    bounds: [[f64; 2]; 2],
    longest: f64,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| if length > 0.0 { x / length } else { 0.0 })
}

impl<'a> Scenery<'a> {
    /// The surface over the nodes; the principal axes of inertia are rows, the longest extent first.
    pub(crate) fn new([first, second, third]: [[f64; 3]; 3], nodes: &'a [[f64; 3]], surface: &'a [Face]) -> Self {
        let mixed = |weights: [f64; 3]| {
            [0, 1, 2].map(|c| weights[0] * first[c] + weights[1] * second[c] + weights[2] * third[c])
        };
        // A right-handed set, whatever the signs of the principal axes are.
        let sign = dot(cross(first, second), third).signum();
        let eye = unit(mixed([EYE[0], EYE[1] * sign, EYE[2]]));
        let right = unit(cross(third, eye));
        let view = [right, cross(eye, right), eye];
        let edges = sharp_edges(surface, nodes);
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let mut extents = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for face in surface {
            for &node in face.corners() {
                let x = nodes[node as usize];
                let seen = [dot(view[0], x), dot(view[1], x)];
                for (range, value) in bounds.iter_mut().zip(seen).chain(extents.iter_mut().zip(x)) {
                    *range = [range[0].min(value), range[1].max(value)];
                }
            }
        }
        Self {
            surface,
            nodes,
            view,
            // Evenly thinned, as a picture shows no more.
            edges: {
                let step = edges.len().div_ceil(MOST_EDGES).max(1);
                edges.into_iter().step_by(step).collect()
            },
            bounds,
            longest: extents.iter().map(|[low, high]| high - low).fold(0.0, f64::max),
        }
    }

    /// The picture of a mode.
    fn svg(&self, mode: &ModeShape) -> String {
        let label = escape(&format!(
            "mode {}, {:.2} Hz: {}",
            mode.number, mode.frequency_hz, mode.name
        ));
        let (body, height) = self.drawing(&mode.displacement, 1.0);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" role=\"img\" aria-label=\"{label}\">\n\
             {body}\n{}</svg>\n",
            self.tripod(height, 14.0)
        )
    }

    /// The deformed surface over the edges of the undeformed one, and its height; colours are magnitudes of the displacement. Lines are as many
    /// times as wide as told.
    pub(crate) fn drawing(&self, displacement: &[[f64; 3]], lines: f64) -> (String, f64) {
        let size = |u: &[f64; 3]| dot(*u, *u).sqrt();
        let largest = displacement.iter().map(size).fold(0.0, f64::max);
        let factor = if largest > 0.0 {
            DEFORMATION * self.longest / largest
        } else {
            0.0
        };
        let deformed: Vec<[f64; 3]> = (self.nodes.iter().zip(displacement))
            .map(|(x, u)| [0, 1, 2].map(|c| x[c] + factor * u[c]))
            .collect();
        let room = DEFORMATION * self.longest;
        let [[left, right], [bottom, top]] = self.bounds.map(|[low, high]| [low - room, high + room]);
        let scale = WIDTH / (right - left);
        let height = scale * (top - bottom);
        // Whole quarters of a pixel: the shortest text.
        let seen = |x: [f64; 3]| {
            let at = [dot(self.view[0], x) - left, top - dot(self.view[1], x)];
            at.map(|length| (4.0 * scale * length).round() as i64)
        };
        let class = |nodes: &[u32]| {
            let mean = nodes.iter().map(|&n| size(&displacement[n as usize])).sum::<f64>() / nodes.len() as f64;
            ((mean / largest * CLASSES as f64) as usize).min(CLASSES - 1)
        };
        let colour = |class: usize| hex(rgb((class as f64 + 0.5) / CLASSES as f64));
        let line = |path: &mut String, nodes: &[u32], x: &[[f64; 3]]| {
            let mut before: Option<[i64; 2]> = None;
            for &node in nodes {
                let at = seen(x[node as usize]);
                // Writing to a string cannot fail.
                let _ = match before {
                    None => write!(path, "M{} {}l", at[0], at[1]),
                    Some(last) => write!(path, "{} {} ", at[0] - last[0], at[1] - last[1]),
                };
                before = Some(at);
            }
        };
        let mut out = String::new();
        let _ = writeln!(out, "<g transform=\"scale(.25)\" stroke-linejoin=\"round\">");
        let mut resting = String::new();
        self.edges.iter().for_each(|edge| line(&mut resting, edge, self.nodes));
        let _ = writeln!(
            out,
            "<path d=\"{resting}\" fill=\"none\" stroke=\"#bbb\" stroke-width=\"{}\"/>",
            3.0 * lines
        );
        let facing: Vec<&Face> = self
            .surface
            .iter()
            .filter(|face| dot(normal(face, &deformed), self.view[2]) > 0.0)
            .collect();
        if facing.len() <= MOST_FACES {
            // The farthest first.
            let depth = |face: &Face| {
                let depths = face.corners().iter().map(|&n| dot(self.view[2], deformed[n as usize]));
                depths.sum::<f64>() / face.corners().len() as f64
            };
            let mut sorted: Vec<(f64, &Face)> = facing.into_iter().map(|face| (depth(face), face)).collect();
            sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut start = 0;
            while start < sorted.len() {
                // Neighbours in depth of one colour share a path.
                let own = class(sorted[start].1.corners());
                let mut path = String::new();
                let mut end = start;
                while end < sorted.len() && class(sorted[end].1.corners()) == own {
                    line(&mut path, sorted[end].1.corners(), &deformed);
                    path.push('z');
                    end += 1;
                }
                let _ = writeln!(
                    out,
                    "<path d=\"{path}\" fill=\"{}\" stroke=\"#333\" stroke-width=\"{lines}\" stroke-opacity=\".5\"/>",
                    colour(own)
                );
                start = end;
            }
        } else {
            let mut paths = vec![String::new(); CLASSES];
            self.edges
                .iter()
                .for_each(|edge| line(&mut paths[class(edge)], edge, &deformed));
            for (own, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
                let _ = writeln!(
                    out,
                    "<path d=\"{path}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>",
                    colour(own),
                    6.0 * lines
                );
            }
        }
        out += "</g>";
        (out, height)
    }

    /// The axes of the model in the lower left corner, with names of this size.
    pub(crate) fn tripod(&self, height: f64, text: f64) -> String {
        let length = 36.0 * text / 14.0;
        let (x0, y0) = (length + text, height - length - 6.0);
        let mut out = format!(
            "<g stroke=\"#444\" stroke-width=\"{:.1}\" font-family=\"sans-serif\" font-size=\"{text}\">\n",
            text / 14.0
        );
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let [dx, dy] = [self.view[0][axis], -self.view[1][axis]].map(|part| length * part);
            let _ = writeln!(
                out,
                "<path d=\"M{x0:.1} {y0:.1}l{dx:.1} {dy:.1}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" stroke=\"none\" \
                 fill=\"#444\">{name}</text>",
                x0 + 1.25 * dx,
                y0 + 1.25 * dy + 0.36 * text
            );
        }
        out + "</g>\n"
    }
}

/// A square per pair of modes, with its value in per cent.
fn assurance_picture(pair: &Assurance) -> String {
    const CELL: f64 = 44.0;
    const LEFT: f64 = 40.0;
    let columns = pair.values.first().map_or(0, Vec::len);
    let (width, height) = (LEFT + CELL * columns as f64, LEFT + CELL * pair.values.len() as f64);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"modal assurance criterion\" \
         style=\"max-width:{width}px\" font-family=\"sans-serif\" font-size=\"14\" text-anchor=\"middle\">"
    );
    for column in 0..columns {
        let x = LEFT + CELL * (column as f64 + 0.5);
        let _ = writeln!(out, "<text x=\"{x}\" y=\"{}\">{}</text>", LEFT - 10.0, column + 1);
    }
    for (row, values) in pair.values.iter().enumerate() {
        let y = LEFT + CELL * row as f64;
        let middle = y + 0.5 * CELL + 5.0;
        let _ = writeln!(out, "<text x=\"{}\" y=\"{middle}\">{}</text>", 0.5 * LEFT, row + 1);
        for (column, value) in values.iter().enumerate() {
            let x = LEFT + CELL * column as f64;
            let ink = if *value > 0.5 { "#000" } else { "#fff" };
            let _ = writeln!(
                out,
                "<rect x=\"{x}\" y=\"{y}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"{}\"/><text x=\"{}\" \
                 y=\"{middle}\" fill=\"{ink}\">{:.0}</text>",
                hex(rgb(*value)),
                x + 0.5 * CELL,
                100.0 * value
            );
        }
    }
    out + "</svg>\n"
}
