//! What the scripts of a page about a run read.

use super::bodies::Bodies;
use super::encode::{self, Sequences};
use crate::fields::{Placed, total_flux};
use crate::motions::PeriodicMotions;
use crate::names::table_file;
use crate::{Error, csv, styles};
use analyses::comparison::Point;
use analyses::ensemble::BandPoint;
use analyses::results::summary::{MeasuredSummary, MethodSummary, Summary};
use analyses::uncertainty;
use analyses::{ElementLoops, Fields, ModeBackbone, Run};
use contact_laws::Regime;
use serde::Serialize;

/// Most numbers that the loops of a page have; a number takes about half a byte.
const MOST_NUMBERS: usize = 6_000_000;

/// A run for the scripts of its page. Everything is in SI; arrays are little-endian and base64.
#[derive(Debug, Serialize)]
pub(crate) struct Document {
    name: String,
    /// The response point in words.
    response: String,
    /// In the order of the run.
    modes: Vec<Mode>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    forced: Vec<Level>,
    /// None of points of contact, which cover nothing that could be drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    interface: Option<Interface>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bodies: Option<Bodies>,
}

#[derive(Debug, Serialize)]
struct Mode {
    #[serde(flatten)]
    backbone: Backbone,
    /// The amplitudes whose fields are stored.
    stops: Vec<Stop>,
}

/// The backbones of a mode.
#[derive(Debug, Serialize)]
pub(super) struct Backbone {
    /// From 1 on.
    mode: usize,
    frequency_hz: f64,
    /// Name of the table of its backbone.
    file: String,
    /// That table, as it stands in the file.
    table: String,
    methods: Vec<Curve>,
    /// Measured backbones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    measured: Vec<Curve>,
    /// Percentiles of samples of uncertain inputs, or of an ensemble of the first mode.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bands: Vec<Band>,
}

/// The backbone of a method beside CQSMA, or a measured one; null where there is no value.
#[derive(Debug, Serialize)]
struct Curve {
    name: String,
    /// m
    response_displacement: Vec<Option<f64>>,
    /// sqrt(kg) m; of measurements it is not known.
    modal_amplitude: Vec<Option<f64>>,
    frequency_hz: Vec<Option<f64>>,
    damping_ratio: Vec<Option<f64>>,
}

#[derive(Debug, Serialize)]
struct Band {
    /// m
    response_displacement: f64,
    /// Lower edge, median and upper edge.
    frequency_hz: [f64; 3],
    /// The same.
    damping_ratio: [Option<f64>; 3],
}

/// The response to one level of force.
#[derive(Debug, Serialize)]
struct Level {
    level: f64,
    /// `N`, `m/s^2` of moving supports, `m` of responses that are held.
    unit: String,
    frequency_hz: Vec<f64>,
    /// m, or N where the response is held.
    amplitude: Vec<f64>,
    /// Degrees behind the force.
    phase: Vec<f64>,
    /// The response of the nonlinear mode alone: frequency (Hz), amplitude (m), phase (degrees).
    alone: Vec<[f64; 3]>,
}

/// An amplitude whose fields are stored.
#[derive(Debug, Serialize)]
struct Stop {
    /// Row of the table of the backbone, from 1 on.
    number: usize,
    /// m
    response_displacement: Option<f64>,
    fields: ElementFields,
    /// None where the run recorded none.
    #[serde(skip_serializing_if = "Option::is_none")]
    loops: Option<Loops>,
}

/// Hysteresis loops of elements.
#[derive(Debug, Serialize)]
struct Loops {
    /// The elements, four bytes each; none: all of them.
    elements: Option<String>,
    /// Vertices of each loop, its first point at its end again.
    vertices: usize,
    /// Smallest and largest value of each sequence, four bytes each.
    ranges: String,
    /// Per element: motion x, y, n since the prestress (m), traction x, y, n (Pa); see [`encode::Sequences`].
    sequences: String,
}

/// Means over the elements, one number of four bytes each.
#[derive(Debug, Serialize)]
struct ElementFields {
    /// Pa
    pressure: String,
    /// Pa
    traction_x: String,
    /// Pa
    traction_y: String,
    /// Negative where the faces are apart (m).
    interference: String,
    /// Tangential motion since the prestress (m).
    motion_x: String,
    /// The same along the second direction (m).
    motion_y: String,
    /// Dissipated energy per area and cycle (J/m^2).
    flux: String,
    /// Slipping share of the area.
    slip: String,
    /// Open share of the area.
    open: String,
}

#[derive(Debug, Serialize)]
struct Interface {
    /// Positions of the nodes in the plane (m), two numbers of four bytes each.
    plane: String,
    /// Positions of the nodes in the coordinates of the model (m), three numbers of four bytes each, where they are known.
    positions: Option<String>,
    /// Corners of each element.
    corners: String,
    /// Nodes around the elements, one element after another.
    nodes: String,
    /// Unit vectors of the directions x, y, n as rows, in the coordinates of the model: nine numbers for all elements together, or
    /// nine for each.
    frames: String,
    /// What multiplies coordinates in the plane (m), and the name of the result with its unit.
    axes: [(f64, String); 2],
    /// From where it is seen.
    view: String,
    /// Names and numbers of elements of its parts, in order.
    parts: Vec<(String, usize)>,
    prestress: ElementFields,
}

impl Document {
    /// What a run found.
    ///
    /// # Errors
    /// [`Error::Table`].
    pub(crate) fn of(found: &Run, summary: &Summary) -> Result<Self, Error> {
        let modes = found.backbones.iter().zip(summary.by_mode());
        let modes = modes.map(|(backbone, (further, of_mode))| mode(found, backbone, further, &of_mode));
        let alone = PeriodicMotions::of(found, summary).map(|motions| motions.single_mode);
        let alone = alone
            .unwrap_or_default()
            .into_iter()
            .chain(std::iter::repeat_with(Vec::new));
        let interface = (!found.joint.mesh.is_of_points()).then(|| interface(found));
        Ok(Self {
            name: found.scene.name.clone(),
            response: summary.response.clone(),
            modes: modes.collect::<Result<_, _>>()?,
            forced: summary
                .forced
                .iter()
                .zip(alone)
                .map(|(level, alone)| Level {
                    level: level.level,
                    unit: level.level_unit.clone(),
                    frequency_hz: level.frequency.clone(),
                    amplitude: level.ordinate().to_vec(),
                    phase: level.phase.clone(),
                    alone: alone.iter().map(|p| [p.frequency_hz, p.amplitude, p.phase]).collect(),
                })
                .collect(),
            bodies: interface
                .as_ref()
                .and(found.joint.surface.as_ref())
                .and_then(Bodies::of),
            interface,
        })
    }

    /// Whether there is something to show in space.
    pub(crate) fn is_in_space(&self) -> bool {
        self.interface
            .as_ref()
            .is_some_and(|interface| interface.positions.is_some())
    }
}

/// How many of the vertices of loops one stands for on the page, so that its loops have no more than [`MOST_NUMBERS`] numbers: a power
/// of two.
fn thinning(found: &Run) -> usize {
    let amplitudes = found.backbones.iter().flat_map(|of| &of.amplitudes);
    let loops = amplitudes.filter_map(|amplitude| amplitude.fields.as_ref()?.loops.as_ref());
    let numbers: usize = loops.map(|loops| 6 * loops.jump[0].len()).sum();
    numbers.div_ceil(MOST_NUMBERS).next_power_of_two()
}

fn loops(found: &Run, recorded: &ElementLoops, thinning: usize) -> Loops {
    let n = recorded.modal_force.len();
    // The last vertex is where the first one is.
    let kept: Vec<usize> = (0..n).filter(|k| k % thinning == 0 || k + 1 == n).collect();
    let operators = found.interface.operators();
    let before = &found.prestress.fields.jump;
    let mut sequences = Sequences::default();
    for (place, &element) in recorded.elements.iter().enumerate() {
        let value = |record: &[f64], vertex: usize| record[vertex * recorded.elements.len() + place];
        for (record, before) in recorded.jump.iter().zip(before) {
            let before = operators.element_mean(element, before);
            sequences.add(kept.iter().map(|&vertex| value(record, vertex) - before));
        }
        for record in &recorded.traction {
            sequences.add(kept.iter().map(|&vertex| value(record, vertex)));
        }
    }
    let all = recorded.elements.len() == operators.n_elements();
    Loops {
        elements: (!all).then(|| encode::integers(recorded.elements.iter().map(|&element| element as u32))),
        vertices: kept.len(),
        ranges: encode::singles(sequences.ranges.iter().copied()),
        sequences: sequences.text(),
    }
}

fn mode(found: &Run, backbone: &ModeBackbone, further: Option<usize>, summary: &Summary) -> Result<Mode, Error> {
    let thinning = thinning(found);
    let stops = backbone.amplitudes.iter().enumerate().filter_map(|(index, amplitude)| {
        let of_loop = amplitude.fields.as_ref()?;
        let fields = of_loop.fields.as_ref()?;
        let drawn = !found.joint.mesh.is_of_points();
        drawn.then(|| Stop {
            number: index + 1,
            response_displacement: amplitude.response_displacement,
            fields: element_fields(found, fields),
            loops: of_loop.loops.as_ref().map(|recorded| loops(found, recorded, thinning)),
        })
    });
    Ok(Mode {
        backbone: Backbone::of(backbone.mode, further, summary)?,
        stops: stops.collect(),
    })
}

impl Backbone {
    /// Those of a mode, counted from 1, which the summary is of; `further` is none for the first mode followed.
    pub(super) fn of(mode: usize, further: Option<usize>, summary: &Summary) -> Result<Self, Error> {
        let frequency = mode.checked_sub(1).and_then(|index| summary.modes.get(index));
        Ok(Self {
            mode,
            frequency_hz: frequency.map_or(0.0, |mode| mode.frequency_hz),
            file: table_file(further),
            table: csv::backbone(summary)?,
            methods: summary
                .methods
                .iter()
                .map(|(name, points)| curve(&styles::title(name), points))
                .collect(),
            measured: summary.measured.iter().map(measured).collect(),
            bands: bands(mode, summary),
        })
    }
}

fn measured(of: &MeasuredSummary) -> Curve {
    let value = |value: fn(&Point) -> Option<f64>| of.points.iter().map(value).collect();
    Curve {
        name: of.name.clone(),
        response_displacement: value(|p| Some(p.amplitude)),
        modal_amplitude: value(|_| None),
        frequency_hz: value(|p| Some(p.frequency_hz)),
        damping_ratio: value(|p| p.damping_ratio),
    }
}

/// Bands of a mode: of uncertain inputs, or of the ensemble of a run; empty without either.
fn bands(mode: usize, summary: &Summary) -> Vec<Band> {
    if let Some(found) = &summary.uncertainty {
        let own = found.modes.iter().filter(|of| of.mode == mode);
        // The first is that of the linearised mode.
        let amplitudes = own.flat_map(|of| of.bands.iter().skip(1));
        let band = |band: &uncertainty::Band| match band.frequency_hz.quantiles {
            [Some(low), Some(median), Some(high)] => Some(Band {
                response_displacement: band.response_displacement,
                frequency_hz: [low, median, high],
                damping_ratio: band.damping_ratio.quantiles,
            }),
            _ => None,
        };
        return amplitudes.filter_map(band).collect();
    }
    let bands = summary.ensemble.iter().flat_map(|ensemble| &ensemble.bands);
    let band = |band: &BandPoint| Band {
        response_displacement: band.response_displacement,
        frequency_hz: band.frequency_hz,
        damping_ratio: band.damping_ratio,
    };
    bands.map(band).collect()
}

fn curve(name: &str, points: &[MethodSummary]) -> Curve {
    let values = |of: fn(&MethodSummary) -> Option<f64>| points.iter().map(of).collect();
    Curve {
        name: name.into(),
        response_displacement: values(|p| p.response_displacement),
        modal_amplitude: values(|p| p.modal_amplitude),
        frequency_hz: values(|p| p.frequency_hz),
        damping_ratio: values(|p| p.damping_ratio),
    }
}

fn element_fields(found: &Run, fields: &Fields) -> ElementFields {
    let operators = found.interface.operators();
    let mean = |values: &[f64]| encode::singles(operators.element_means(values));
    let share = |regime: Regime| {
        let shares = fields.regime.iter().map(|r| if *r == regime { 1.0 } else { 0.0 });
        mean(&shares.collect::<Vec<f64>>())
    };
    let motion = |axis: usize| {
        let before = &found.prestress.fields.jump[axis];
        let motion = fields.jump[axis].iter().zip(before).map(|(jump, before)| jump - before);
        mean(&motion.collect::<Vec<f64>>())
    };
    ElementFields {
        pressure: mean(&fields.traction[2]),
        traction_x: mean(&fields.traction[0]),
        traction_y: mean(&fields.traction[1]),
        interference: mean(&fields.jump[2]),
        motion_x: motion(0),
        motion_y: motion(1),
        flux: encode::singles(total_flux(found, fields)),
        slip: share(Regime::Slip),
        open: share(Regime::Open),
    }
}

fn interface(found: &Run) -> Interface {
    let place = Placed::from(found);
    let mesh = place.mesh;
    let outlines: Vec<Vec<u32>> = mesh.elements.iter().map(zte_assembly::Element::outline).collect();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // One element stands for all where all have the same directions.
    let turned = match place.node_frames.is_empty() {
        true => 0..1,
        false => 0..mesh.elements.len(),
    };
    let frames = turned.flat_map(|element| axes.into_iter().flat_map(move |axis| place.turned(element, axis)));
    let parts = match found.parts.len() {
        1 => Vec::new(),
        _ => found
            .parts
            .iter()
            .map(|part| (part.name.clone(), part.elements))
            .collect(),
    };
    Interface {
        plane: encode::singles(mesh.nodes.iter().flatten().copied()),
        positions: place
            .positions
            .map(|all| encode::singles(all.iter().flatten().copied())),
        corners: encode::integers(outlines.iter().map(|outline| outline.len() as u32)),
        nodes: encode::integers(outlines.iter().flatten().copied()),
        frames: encode::singles(frames),
        axes: place.axes(),
        view: place.view(),
        parts,
        prestress: element_fields(found, &found.prestress.fields),
    }
}
