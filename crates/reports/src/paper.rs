//! Pictures for a column of a paper: 85 mm wide, texts of 8 pt, curves told apart by colour and by dashes.

use crate::answer::percent;
use crate::fields::Placed;
use crate::map::{self, COLUMN};
use crate::markup::escape;
use crate::modes::{Scenery, WIDTH};
use crate::overlay::{Series, abscissa};
use crate::plot::{Band, Curve, Marks, Numbers, Panel, column, plain, power};
use crate::styles::COLOURS;
use crate::{Error, interactive};
use analyses::comparison::{Backbone, Point};
use analyses::results::summary::Summary;
use finite_elements::formats::vtu::Surface;
use finite_elements::mesh::Face;
use modal_identification::signal::Quantity;
use plotters::prelude::SeriesLabelPosition;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use zte_assembly::{Element, InterfaceMesh};

/// Width of a column (mm).
const MILLIMETRES: f64 = 85.0;

/// Dashes of curves one after another: those of one colour differ in grey as well.
const DASHES: [Option<(u32, u32)>; 6] = [
    None,
    Some((9, 4)),
    Some((3, 3)),
    Some((16, 4)),
    Some((6, 6)),
    Some((2, 6)),
];

/// Points of a curve beyond which they are not marked.
const MOST_MARKED: usize = 40;

/// The picture as wide as a column.
fn sized(svg: &str) -> String {
    let (tag, body) = svg.split_once('>').unwrap_or((svg, ""));
    let view = tag.split("viewBox=\"").nth(1).and_then(|rest| rest.split('"').next());
    let sizes: Vec<f64> = view
        .unwrap_or_default()
        .split(' ')
        .filter_map(|n| n.parse().ok())
        .collect();
    let [_, _, width, height] = sizes[..] else {
        return svg.into();
    };
    let tag: Vec<&str> = tag
        .split(' ')
        .filter(|word| !word.starts_with("width=") && !word.starts_with("height="))
        .collect();
    let [first, rest @ ..] = &tag[..] else {
        return svg.into();
    };
    format!(
        "{first} width=\"{MILLIMETRES}mm\" height=\"{:.2}mm\" {}>{body}",
        MILLIMETRES * height / width,
        rest.join(" ")
    )
}

/// Frequency above damping, over amplitudes of this quantity.
///
/// # Errors
/// [`Error::Picture`].
pub fn backbones(series: &[Series<'_>], quantity: Quantity) -> Result<String, Error> {
    let bands = |value: fn(&Point) -> Option<f64>| {
        let of = |(series, colour): (&Series<'_>, _)| {
            let [low, high] = series.band?;
            let edges = low.points().iter().zip(high.points());
            let points = edges.filter_map(|(low, high)| Some((low.amplitude, value(low)?, value(high)?)));
            Some(Band {
                colour,
                points: points.collect(),
            })
        };
        series.iter().zip(COLOURS.into_iter().cycle()).filter_map(of).collect()
    };
    let curves = |value: fn(&Point) -> Option<f64>, named: bool| {
        let of = |(index, series): (usize, &Series<'_>)| Curve {
            name: if named { series.name.clone() } else { String::new() },
            points: points(series.backbone, value),
            ..style(index, series.backbone.points().len())
        };
        series.iter().enumerate().map(of).collect()
    };
    let frequency = |point: &Point| Some(point.frequency_hz);
    let damping = |point: &Point| point.damping_ratio;
    let panels = vec![
        (
            panel("frequency [Hz]", None, curves(frequency, false)),
            bands(frequency),
        ),
        (
            panel("damping ratio", Some(PERCENT), curves(damping, true)),
            bands(damping),
        ),
    ];
    let (label, amplitude) = abscissa(quantity);
    column(&label, &amplitude, panels).map(|svg| sized(&svg))
}

fn points(backbone: &Backbone, value: fn(&Point) -> Option<f64>) -> Vec<(usize, f64, f64)> {
    let points = backbone.points().iter().enumerate();
    points.filter_map(|(i, p)| Some((i, p.amplitude, value(p)?))).collect()
}

/// The look of a curve, by its number.
fn style(index: usize, n_points: usize) -> Curve {
    Curve {
        name: String::new(),
        colour: COLOURS[index % COLOURS.len()],
        dashes: DASHES[index % DASHES.len()],
        marks: if n_points > MOST_MARKED {
            Marks::None
        } else {
            Marks::Dots
        },
        points: Vec::new(),
    }
}

/// Numbers beside damping ratios.
const PERCENT: Numbers = |ratio| percent(*ratio);

fn panel(y_label: &'static str, log: Option<Numbers>, curves: Vec<Curve>) -> Panel {
    Panel {
        y_label,
        log,
        legend: if log.is_some() {
            SeriesLabelPosition::LowerRight
        } else {
            SeriesLabelPosition::LowerLeft
        },
        curves,
    }
}

/// What is known of a run beside its backbone.
pub struct Spread {
    name: String,
    points: Vec<SpreadPoint>,
}

/// Lower edge, median and upper edge at an amplitude (m).
struct SpreadPoint {
    amplitude: f64,
    frequency_hz: [Option<f64>; 3],
    damping_ratio: [Option<f64>; 3],
}

impl Spread {
    /// Bands of a mode from uncertain inputs, or else of realisations of the faces, which the summary of a mode has; none without either.
    pub fn of(name: &str, summary: &Summary, mode: usize) -> Option<Self> {
        let uncertain = summary.uncertainty.iter().flat_map(|found| &found.modes);
        let uncertain = uncertain.filter(|of| of.mode == mode).flat_map(|of| &of.bands);
        let mut points: Vec<SpreadPoint> = (uncertain.filter(|band| band.modal_amplitude > 0.0))
            .map(|band| SpreadPoint {
                amplitude: band.response_displacement,
                frequency_hz: band.frequency_hz.quantiles,
                damping_ratio: band.damping_ratio.quantiles,
            })
            .collect();
        if points.is_empty() {
            points.extend(
                summary
                    .ensemble
                    .iter()
                    .flat_map(|found| &found.bands)
                    .map(|band| SpreadPoint {
                        amplitude: band.response_displacement,
                        frequency_hz: band.frequency_hz.map(Some),
                        damping_ratio: band.damping_ratio,
                    }),
            );
        }
        let name = format!("{name}: 5, 50, 95 %");
        (!points.is_empty()).then_some(Self { name, points })
    }
}

/// Bands of frequency above and of damping below, each around its median.
///
/// # Errors
/// [`Error::Picture`].
pub fn bands(runs: &[Spread]) -> Result<String, Error> {
    let panel_of = |y_label, is_damping: bool| {
        let value = |point: &SpreadPoint| {
            if is_damping {
                point.damping_ratio
            } else {
                point.frequency_hz
            }
        };
        let is_drawn = |value: &f64| !is_damping || *value > 0.0;
        let mut bands = Vec::new();
        let mut curves = Vec::new();
        for (index, run) in runs.iter().enumerate() {
            let shade = run.points.iter().filter_map(|point| {
                let [low, _, high] = value(point);
                Some((point.amplitude, low.filter(is_drawn)?, high.filter(is_drawn)?))
            });
            let middle = run.points.iter().enumerate();
            let middle = middle.filter_map(|(i, point)| Some((i, point.amplitude, value(point)[1].filter(is_drawn)?)));
            let own = style(index, run.points.len());
            bands.push(Band {
                colour: own.colour,
                points: shade.collect(),
            });
            curves.push(Curve {
                name: if is_damping { run.name.clone() } else { String::new() },
                points: middle.collect(),
                ..own
            });
        }
        // One point has no area.
        bands.retain(|band| band.points.len() > 1);
        (panel(y_label, is_damping.then_some(PERCENT), curves), bands)
    };
    let panels = vec![
        panel_of("frequency, secant [Hz]", false),
        panel_of("damping ratio", true),
    ];
    let (label, amplitude) = abscissa(Quantity::Displacement);
    column(&label, &amplitude, panels).map(|svg| sized(&svg))
}

/// Times and errors of a setting.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// From nothing to the backbone (s).
    pub seconds: f64,
    /// Largest relative error of a frequency.
    pub frequency: f64,
    /// Largest error of the logarithm of a damping ratio.
    pub damping_ln: Option<f64>,
}

/// Errors against time, one curve for the settings of each parameter, by its name.
///
/// # Errors
/// [`Error::Picture`].
pub fn trade(parameters: &[(String, Vec<Cost>)]) -> Result<String, Error> {
    // Half of the names stand in either diagram, where they leave room for the curves.
    let half = parameters.len().div_ceil(2);
    let panel_of = |y_label, error: fn(&Cost) -> Option<f64>, named: Range<usize>| {
        let of = |(index, (name, settings)): (usize, &(String, Vec<Cost>))| Curve {
            name: if named.contains(&index) {
                name.clone()
            } else {
                String::new()
            },
            points: (settings.iter().enumerate())
                .filter_map(|(i, cost)| Some((i, cost.seconds, error(cost)?)))
                .collect(),
            ..style(index, settings.len())
        };
        let mut panel = panel(y_label, Some(power), parameters.iter().enumerate().map(of).collect());
        panel.legend = SeriesLabelPosition::UpperRight;
        (panel, Vec::new())
    };
    let panels = vec![
        panel_of("error of frequency [-]", |cost| Some(cost.frequency), 0..half),
        panel_of(
            "error of ln(damping) [-]",
            |cost| cost.damping_ln,
            half..parameters.len(),
        ),
    ];
    column("time [s]", &plain, panels).map(|svg| sized(&svg))
}

/// A field of the elements of interfaces in the coordinates of the model.
pub struct Flux<'a> {
    /// What stands above its maps.
    pub name: String,
    /// The interfaces.
    pub surface: &'a Surface,
    /// One value per face.
    pub values: &'a [f64],
}

/// Maps of dissipation, one for each plane in which interfaces lie, all with one range of colours.
///
/// # Errors
/// [`Error::Folded`] for an interface that covers itself in every view along a normal.
pub fn flux(fields: &[Flux<'_>]) -> Result<String, Error> {
    const LABEL: &str = "dissipated energy per area and cycle [J/m²]";
    let ends = fields.iter().map(|field| map::bounds_of(field.values));
    let range = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| {
        [low.min(a), high.max(b)]
    });
    let (mut body, mut height) = (String::new(), 6.0);
    for field in fields {
        for plane in planes(field)? {
            let place = Placed {
                mesh: &plane.mesh,
                frame: plane.frame,
                node_frames: &[],
                positions: Some(&field.surface.nodes),
            };
            let (drawn, below) = map::drawing(place, &plane.values, LABEL, range, COLUMN);
            // Writing to a string cannot fail.
            let _ = writeln!(
                body,
                "<text x=\"64\" y=\"{:.1}\">{}</text>\n<g transform=\"translate(0 {:.1})\">\n{drawn}</g>",
                height + 12.0,
                escape(&field.name),
                height + 16.0
            );
            height += below + 24.0;
        }
    }
    Ok(sized(&map::document(&body, [COLUMN, height], LABEL)))
}

/// Interfaces in one plane.
struct Plane {
    mesh: InterfaceMesh,
    values: Vec<f64>,
    frame: [[f64; 3]; 3],
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3])
}

/// The interfaces by the planes in which they lie; a curved one is seen along its mean normal.
fn planes(field: &Flux<'_>) -> Result<Vec<Plane>, Error> {
    let (faces, nodes) = (&field.surface.faces, &field.surface.nodes);
    let extent = |c: usize| {
        let [low, high] = map::bounds_of(&nodes.iter().map(|x| x[c]).collect::<Vec<_>>());
        high - low
    };
    let size = (0..3).map(extent).fold(0.0, f64::max);
    let mut found: Vec<([f64; 3], f64, Vec<usize>)> = Vec::new();
    for members in patches(faces, nodes.len()) {
        let normals: Vec<[f64; 3]> = members
            .iter()
            .map(|&face| interactive::bodies::normal(&faces[face], nodes))
            .collect();
        let sum = [0, 1, 2].map(|c| normals.iter().map(|n| n[c]).sum::<f64>());
        let length = dot(sum, sum).sqrt();
        let normal = sum.map(|x| x / length);
        // NaN of a closed surface is refused too.
        if !normals.iter().all(|n| dot(*n, normal) > 0.1) {
            return Err(Error::Folded {
                name: field.name.clone(),
            });
        }
        let first = faces[members[0]].nodes()[0];
        let height = dot(nodes[first as usize], normal);
        let same = found.iter_mut().find(|(other, at, _)| {
            let cosine = dot(*other, normal);
            cosine.abs() > 1.0 - 1e-9 && (at.abs() - (cosine.signum() * height).abs()).abs() < 1e-6 * size
        });
        match same {
            Some((.., all)) => all.extend(members),
            None => found.push((normal, height, members)),
        }
    }
    let plane = |(normal, _, members): ([f64; 3], f64, Vec<usize>)| {
        // Along the axis of the model that the plane contains and along which it is longest; else along the longest that is near to it.
        let tangential = |axis: usize| {
            let unit = [0, 1, 2].map(|c| f64::from(u8::from(c == axis)));
            let along = [0, 1, 2].map(|c| unit[c] - normal[axis] * normal[c]);
            let length = dot(along, along).sqrt();
            (length, along.map(|x| x / length))
        };
        let extent = |along: [f64; 3]| {
            let at = members.iter().flat_map(|&face| faces[face].nodes());
            let [low, high] = map::bounds_of(&at.map(|&n| dot(nodes[n as usize], along)).collect::<Vec<_>>());
            high - low
        };
        let axes = (0..3).map(tangential).filter(|(length, _)| *length > 0.5);
        let right = axes.map(|(length, along)| (length * extent(along), along));
        let right = right
            .fold(
                (0.0, [1.0, 0.0, 0.0]),
                |best, next| if next.0 > best.0 { next } else { best },
            )
            .1;
        let frame = [right, cross(normal, right), normal];
        let in_plane = nodes.iter().map(|x| [dot(*x, frame[0]), dot(*x, frame[1])]);
        let mut numbers = BTreeMap::new();
        let (mut mesh_nodes, all): (Vec<[f64; 2]>, Vec<[f64; 2]>) = (Vec::new(), in_plane.collect());
        let mut elements = Vec::new();
        for &face in &members {
            let mut of = |node: &u32| {
                *numbers.entry(*node).or_insert_with(|| {
                    mesh_nodes.push(all[*node as usize]);
                    mesh_nodes.len() as u32 - 1
                })
            };
            let own: Vec<u32> = faces[face].nodes().iter().map(&mut of).collect();
            elements.extend(Element::from_nodes(&own));
        }
        Plane {
            mesh: InterfaceMesh::flat(mesh_nodes, elements),
            values: members.iter().map(|&face| field.values[face]).collect(),
            frame,
        }
    };
    Ok(found.into_iter().map(plane).collect())
}

/// Faces that hang together by common nodes.
fn patches(faces: &[Face], n_nodes: usize) -> Vec<Vec<usize>> {
    // The smallest number of a node that each node hangs together with, found by halving paths.
    let mut root: Vec<usize> = (0..n_nodes).collect();
    let find = |root: &mut Vec<usize>, mut node: usize| {
        while root[node] != node {
            root[node] = root[root[node]];
            node = root[node];
        }
        node
    };
    for face in faces {
        let first = find(&mut root, face.nodes()[0] as usize);
        for &node in face.nodes() {
            let other = find(&mut root, node as usize);
            let (low, high) = (first.min(other), first.max(other));
            let low_root = find(&mut root, low);
            root[high] = low_root;
        }
    }
    let mut patches: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (number, face) in faces.iter().enumerate() {
        let patch = find(&mut root, face.nodes()[0] as usize);
        patches.entry(patch).or_default().push(number);
    }
    patches.into_values().collect()
}

/// A mode shape with its caption.
pub struct Shape {
    /// What stands above it.
    pub caption: String,
    /// Displacement of each node.
    pub displacement: Vec<[f64; 3]>,
}

/// Mode shapes on the surface of a structure in two columns; the principal axes of inertia are rows, the longest extent first.
pub fn modes(surface: &Surface, axes: [[f64; 3]; 3], shapes: &[Shape]) -> String {
    const GAP: f64 = 8.0;
    let scenery = Scenery::new(axes, &surface.nodes, &surface.faces);
    let columns = shapes.len().clamp(1, 2);
    let width = (COLUMN - GAP * (columns as f64 - 1.0)) / columns as f64;
    let scale = width / WIDTH;
    let (mut body, mut bottom) = (String::new(), 0.0_f64);
    for (index, shape) in shapes.iter().enumerate() {
        let (drawn, height) = scenery.drawing(&shape.displacement, 0.5 / scale);
        let (x, y) = (
            (index % columns) as f64 * (width + GAP),
            (index / columns) as f64 * (scale * height + 24.0),
        );
        // Writing to a string cannot fail.
        let _ = writeln!(
            body,
            "<text x=\"{x:.1}\" y=\"{:.1}\">{}</text>\n<g transform=\"translate({x:.1} {:.1})scale({scale:.4})\">\n{drawn}\n</g>",
            y + 14.0,
            escape(&shape.caption),
            y + 18.0
        );
        bottom = bottom.max(y + 18.0 + scale * height);
    }
    let height = bottom + 80.0;
    body += &scenery.tripod(height, 14.0);
    sized(&map::document(&body, [COLUMN, height], "mode shapes"))
}
