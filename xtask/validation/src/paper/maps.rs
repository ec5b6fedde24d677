//! Entries that show fields over the interface.

use super::backbones::extended;
use super::entry::{Entry, Figure, Findings, Picture, Plan, claim};
use super::inputs::{Inputs, per_element, uniform};
use super::runs::{Point, PointFields, Record};
use crate::elements::Representatives;
use analyses::results::trends::power_law;
use anyhow::{Result, bail};
use brake_reuss_beam::published;
use plotters::prelude::SeriesLabelPosition;
use reports::map::{Map, several};
use reports::plot::{BLUE, Curve, Marks, Numbers, Panel, RED, power, stack};
use scenes::Gap;
use zte_assembly::InterfaceMesh;

pub(super) const FIG_17: Entry = Entry {
    id: "fig17",
    title: "Figs. 17 and 18: pressure and tangential traction under prestress",
    inputs: "Prestress at mu = 0.6 with 25 points per element. The three cases of Table 1: gap of another pair with synthetic scans \
             per element, flat with them, flat with one of their elements for all; beside them the measured statistics of that other \
             pair with its gap.",
    plan: fig_17,
};

const CASES: [&str; 4] = [
    "topography, per element",
    "flat, per element",
    "flat, uniform",
    "topography, measured statistics",
];

/// Distance from the middle of the interface beyond which an element lies near its ends (m).
const NEAR_ENDS: f64 = 0.04;

fn fig_17(inputs: &Inputs) -> Result<Plan<'_>> {
    let mesh = &inputs.mesh;
    Ok(Plan {
        scenes: vec![
            per_element(inputs.prestress("prestress, per element", Gap::Measured)),
            per_element(inputs.prestress("prestress, per element", Gap::Flat)),
            uniform(
                inputs,
                "prestress, element drawn",
                Representatives::try_new(&inputs.scan()?.found.elements)?.drawn,
            ),
            inputs.prestress("prestress, measured statistics", Gap::Measured),
        ],
        evaluate: Box::new(move |results| {
            let runs = results.all()?;
            let mut figures = Vec::new();
            let paper = published::BOLT_STRAIN_TABLE[4];
            let areas = [
                Some(paper.topography_contact),
                Some(paper.flat_contact),
                None,
                Some(paper.topography_contact),
            ];
            let notes = [
                "synthetic scans, gap of another pair",
                "synthetic scans",
                "synthetic scans",
                "asperities and gap of another pair",
            ];
            for (((case, run), area), note) in CASES.iter().zip(&runs).zip(areas).zip(notes) {
                let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
                let tangential: Vec<f64> = tangential(run).collect();
                let lowest = run.nodal[2].iter().copied().fold(f64::INFINITY, f64::min);
                let rows = [
                    ("contact area by element centres", area, run.contact[2]),
                    (
                        "area with more than 1 % of the mean pressure",
                        None,
                        loaded_part(mesh, run),
                    ),
                    ("part of the area that slips", None, run.slipping),
                    ("spread of the pressure over its mean", None, spread(run)),
                    ("largest pressure (Pa)", None, largest(&run.central[2])),
                    ("largest tangential traction (Pa)", None, largest(&tangential)),
                    ("smallest nodal pressure by least squares (Pa)", None, lowest),
                ];
                figures
                    .extend(rows.map(|(name, area, value)| Figure::new(format!("{name}, {case}"), area, value, note)));
            }
            let [topography, flat, uniform, _] = runs[..] else {
                bail!("{} of four cases were run", runs.len());
            };
            let near_ends = |run: &Record| part(mesh, run, |x| x.abs() > NEAR_ENDS);
            let between = |run: &Record| part(mesh, run, |x| x.abs() <= NEAR_ENDS);
            figures.push(Figure::new(
                "loaded part of the area near the ends, topography, per element",
                None,
                near_ends(topography),
                "published: two large regions near the ends are out of contact",
            ));
            figures.push(Figure::new(
                "loaded part of the area between, topography, per element",
                None,
                between(topography),
                "",
            ));
            let gaps = [true, false].map(|near| mean_gap(mesh, |x| (x.abs() > NEAR_ENDS) == near));
            for (gap, place) in gaps.into_iter().zip(["near the ends", "between"]) {
                let name = format!("mean gap before the bolts are tightened, {place} (m)");
                figures.push(Figure::new(
                    name,
                    None,
                    gap,
                    "of another pair; published: large near the ends",
                ));
            }
            let differ = |a: &Record, b: &Record| {
                let (a, b) = (loaded(mesh, a), loaded(mesh, b));
                let areas = mesh.areas();
                let changed = (0..areas.len()).filter(|&e| a[e] != b[e]);
                changed.map(|e| areas[e]).sum::<f64>() / areas.iter().sum::<f64>()
            };
            let flattened = differ(topography, flat);
            let evened = differ(flat, uniform);
            figures.push(Figure::new(
                "area that loads or unloads where the topography is left out",
                None,
                flattened,
                "published: dramatic",
            ));
            figures.push(Figure::new(
                "area that loads or unloads where roughness is made uniform",
                None,
                evened,
                "published: similar",
            ));
            let three = &runs[..3];
            let slipping = three.iter().map(|run| run.slipping).fold(0.0, f64::max);
            let negative = topography.nodal[2].iter().any(|p| *p < 0.0);
            let claims = [
                claim(
                    near_ends(topography) < 0.5 * between(topography),
                    "large regions near the ends out of contact with topography",
                ),
                claim(
                    flattened > 0.1,
                    "on flat faces the regions of contact are dramatically others",
                ),
                claim(evened < 0.05, "both flat cases alike in what touches"),
                claim(
                    spread(uniform) < spread(flat),
                    "uniform roughness evens out the pressure",
                ),
                claim(slipping < 0.05, "hardly any slip under prestress"),
                claim(
                    negative,
                    "nodal pressure by least squares negative in places with topography",
                ),
            ];
            let judgement = format!(
                "Contact by element centres: {:.0} % with topography and {:.0} % flat (published {:.0} and {:.0} %); more than 1 % of the mean \
                 pressure is on {:.0} and {:.0} %. The gap of this pair is {:.0} um near the ends and {:.0} um between, {}. Claims: {}.",
                100.0 * topography.contact[2],
                100.0 * flat.contact[2],
                100.0 * paper.topography_contact,
                100.0 * paper.flat_contact,
                100.0 * loaded_part(mesh, topography),
                100.0 * loaded_part(mesh, flat),
                1e6 * gaps[0],
                1e6 * gaps[1],
                if gaps[0] < gaps[1] {
                    "the other way round than in the paper, so that the bolts close the ends first"
                } else {
                    "as in the paper"
                },
                claims.join("; "),
            );
            let maps = |run: &Record, case: &str| {
                let nodal = |component: usize, name: &str, sign: fn(f64) -> f64| Map {
                    label: format!("nodal {name}, {case} [MPa]"),
                    values: at_middles(mesh, &run.nodal[component], sign),
                };
                [
                    Map {
                        label: format!("pressure, {case} [MPa]"),
                        values: (run.central[2].iter())
                            .map(|p| if *p > 0.0 { 1e-6 * p } else { f64::NAN })
                            .collect(),
                    },
                    nodal(2, "pressure (absolute)", f64::abs),
                    nodal(0, "traction x", |t| t),
                    nodal(1, "traction y", |t| t),
                ]
            };
            let flats: Vec<Map> = [(flat, CASES[1]), (uniform, CASES[2])]
                .into_iter()
                .flat_map(|(run, case)| maps(run, case))
                .collect();
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![
                    Picture {
                        name: "fig17",
                        svg: several(mesh, &maps(topography, CASES[0]), 2),
                        caption: "Pressure at the centres of the elements (white: open), and nodal tractions by least squares interpolated to the \
                                  same places, with topography; seen from above, the beam's axis to the right."
                            .into(),
                    },
                    Picture {
                        name: "fig18",
                        svg: several(mesh, &flats, 2),
                        caption: "The same on flat faces: above with roughness per element, below with uniform roughness.".into(),
                    },
                ],
            })
        }),
    })
}

fn tangential(run: &Record) -> impl Iterator<Item = f64> {
    run.central[0].iter().zip(&run.central[1]).map(|(x, y)| x.hypot(*y))
}

/// Standard deviation over mean of the pressures at the closed centres.
fn spread(run: &Record) -> f64 {
    let closed: Vec<f64> = run.central[2].iter().copied().filter(|p| *p > 0.0).collect();
    let n = closed.len() as f64;
    let mean = closed.iter().sum::<f64>() / n;
    (closed.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / n).sqrt() / mean
}

/// A nodal field (Pa) at the middles of the elements: what interpolation makes of it there (MPa).
fn at_middles(mesh: &InterfaceMesh, nodal: &[f64], sign: fn(f64) -> f64) -> Vec<f64> {
    let elements = mesh.elements.iter();
    elements
        .map(|element| {
            let nodes = element.nodes();
            let sum: f64 = nodes.iter().map(|&n| nodal[n as usize]).sum();
            sign(1e-6 * sum / nodes.len() as f64)
        })
        .collect()
}

/// Pressure, relative to the mean, above which an element counts as loaded.
const LOADED: f64 = 0.01;

/// Which elements carry more than [`LOADED`] of the mean pressure at their centres.
fn loaded(mesh: &InterfaceMesh, run: &Record) -> Vec<bool> {
    let areas = mesh.areas();
    let force: f64 = areas.iter().zip(&run.central[2]).map(|(area, p)| area * p).sum();
    let mean = force / areas.iter().sum::<f64>();
    run.central[2].iter().map(|p| *p > LOADED * mean).collect()
}

/// Part of the area of loaded elements.
pub(super) fn loaded_part(mesh: &InterfaceMesh, run: &Record) -> f64 {
    part(mesh, run, |_| true)
}

/// Part of the area of those elements whose centre's position along the beam (m) is `wanted` that are loaded.
fn part(mesh: &InterfaceMesh, run: &Record, wanted: impl Fn(f64) -> bool) -> f64 {
    let (areas, loaded, centres) = (mesh.areas(), loaded(mesh, run), centres(mesh));
    let among = || (0..areas.len()).filter(|&e| wanted(centres[e]));
    among().filter(|&e| loaded[e]).map(|e| areas[e]).sum::<f64>() / among().map(|e| areas[e]).sum::<f64>()
}

/// Mean over the area of the measured gap (m) at the middles of those elements whose position along the beam (m) is `wanted`.
fn mean_gap(mesh: &InterfaceMesh, wanted: impl Fn(f64) -> bool) -> f64 {
    let areas = mesh.areas();
    let (mut volume, mut area) = (0.0, 0.0);
    for (element, weight) in mesh.elements.iter().zip(areas) {
        let nodes = element.nodes();
        let [x, y] = [0, 1].map(|axis| {
            let sum: f64 = nodes.iter().map(|&n| mesh.nodes[n as usize][axis]).sum();
            sum / nodes.len() as f64
        });
        if wanted(x) {
            volume += weight * published::mesoscale_gap(x, y);
            area += weight;
        }
    }
    volume / area
}

/// Middles of the elements along the beam (m).
pub(super) fn centres(mesh: &InterfaceMesh) -> Vec<f64> {
    let middle = |nodes: &[u32]| nodes.iter().map(|&n| mesh.nodes[n as usize][0]).sum::<f64>() / nodes.len() as f64;
    mesh.elements.iter().map(|element| middle(element.nodes())).collect()
}

pub(super) const FIG_21: Entry = Entry {
    id: "fig21",
    title: "Figs. 21 and 22: backbone to unrealistic amplitudes, and where energy is dissipated",
    inputs: "Measured statistics of another pair with its gap and flat, mu = 0.2, displacement of 10 um to 10 mm by linear \
             estimate (the paper: about 1 m, where an amplitude takes minutes here). Point 1: the first amplitude at whose peak any \
             part of the area slips; 2: the last before the frequency has fallen by 1 %; 3: the largest damping; 4: the largest \
             amplitude. The paper shows measured curves, fluxes and its four points in pictures alone, without figures.",
    plan: fig_21,
};

/// Fall of the frequency up to point 2.
const DOWNTURN: f64 = 0.01;

/// The four marked points of a backbone, by the rules of the entry.
pub(super) fn marked(run: &Record) -> [Option<&Point>; 4] {
    let points = &run.backbone;
    let first = run.first();
    let damped = |p: &&Point| p.damping.is_some();
    [
        points.iter().find(|p| p.slip > 0.0),
        points
            .iter()
            .take_while(|p| p.frequency > (1.0 - DOWNTURN) * first)
            .last(),
        points
            .iter()
            .filter(damped)
            .max_by(|a, b| a.damping.partial_cmp(&b.damping).unwrap_or(std::cmp::Ordering::Equal)),
        points.last(),
    ]
}

fn fig_21(inputs: &Inputs) -> Result<Plan<'_>> {
    let mesh = &inputs.mesh;
    Ok(Plan {
        scenes: vec![extended(inputs, Gap::Measured), extended(inputs, Gap::Flat)],
        evaluate: Box::new(move |results| {
            let runs = results.all()?;
            let cases = [("topography", "fig21-flux"), ("flat", "fig22-flux")];
            let mut figures = Vec::new();
            let mut pictures = vec![backbones(inputs, &runs)?];
            let mut found = Vec::new();
            for ((case, name), run) in cases.into_iter().zip(&runs) {
                let mut maps = Vec::new();
                let mut points = Vec::new();
                for (number, point) in marked(run).into_iter().enumerate() {
                    let Some((point, fields)) = point.and_then(|p| Some((p, p.fields.as_ref()?))) else {
                        bail!("no amplitude with {case} is point {}", number + 1);
                    };
                    let at = format!("{case}, point {}", number + 1);
                    let flux = Flux::new(mesh, fields);
                    let rows = [
                        ("displacement (m)", point.displacement),
                        ("frequency (Hz)", point.frequency),
                        ("damping", point.damping.unwrap_or(f64::NAN)),
                        ("part of the area that slips", point.slip),
                        ("normal over tangential dissipation", flux.normal),
                        ("dissipation along y over that along x", flux.across),
                        ("part of the dissipation near the ends", flux.near_ends),
                        ("spread of the flux over its mean", flux.spread),
                        ("part of the tangential flux that is negative", flux.negative),
                    ];
                    figures.extend(rows.map(|(what, value)| Figure::new(format!("{what}, {at}"), None, value, NOTE)));
                    maps.extend(["x", "y", "n"].into_iter().zip(&fields.flux).map(|(axis, flux)| Map {
                        label: format!("point {}, flux {axis} [J/m²]", number + 1),
                        values: flux.clone(),
                    }));
                    points.push((point, flux));
                }
                let dissipation = run.curve(|p| Some(p.dissipation));
                let peak = points[2].0.displacement;
                let slopes = [[points[0].0.displacement, peak], [peak, f64::INFINITY]]
                    .map(|range| power_law(&dissipation, range).map_or(f64::NAN, |law| law.slope));
                for (slope, side) in slopes.into_iter().zip(["from point 1 to 3", "from point 3 on"]) {
                    figures.push(Figure::new(
                        format!("slope of dissipation {side}, {case}"),
                        None,
                        slope,
                        "log-log",
                    ));
                }
                pictures.push(Picture {
                    name,
                    svg: several(mesh, &maps, 3),
                    caption: format!(
                        "Dissipated energy per area and cycle ({case}) along x, y and the normal at the four points; each map has its own \
                         range."
                    ),
                });
                found.push((points, slopes));
            }
            let points = || found.iter().map(|(points, _)| points);
            let steady = runs.iter().all(|run| {
                let frequencies: Vec<f64> = run.backbone.iter().map(|p| p.frequency).collect();
                frequencies.windows(2).all(|w| w[1] < w[0] * (1.0 + 1e-6))
            });
            let claims = [
                claim(
                    points().all(|p| p[..3].iter().all(|(_, flux)| flux.normal < 1e-2)),
                    "normal dissipation orders of magnitude below the tangential one up to point 3",
                ),
                claim(
                    points().all(|p| p[3].1.normal > 10.0 * p[2].1.normal),
                    "significant at point 4 (at a far smaller amplitude here)",
                ),
                claim(
                    points().all(|p| p.iter().all(|(_, flux)| flux.across < 1.0 && flux.across > 1e-3)),
                    "dissipation along y smaller than along x but considerable",
                ),
                claim(
                    found[0].0[0].1.near_ends > near_ends_area(mesh),
                    "dissipation at point 1 mostly towards the ends",
                ),
                claim(
                    points().all(|p| p[2].1.spread < p[0].1.spread && p[2].1.spread < p[3].1.spread),
                    "the interface takes part most evenly at the peak of damping",
                ),
                claim(steady, "the frequency falls steadily to the largest amplitude"),
                claim(
                    found.iter().all(|(_, slopes)| slopes[1] < slopes[0]),
                    "dissipation bends at the peak of damping",
                ),
            ];
            let last = |case: usize| found[case].0[3].0;
            let judgement = format!(
                "Claims, with topography and flat: {}. The largest amplitude is {:.0} mm (published: about 1 m), where {:.0} % of the motion is outside \
                 the mode that the method takes as fixed.",
                claims.join("; "),
                1e3 * last(0).displacement,
                100.0 * last(0).shape_deviation,
            );
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures,
            })
        }),
    })
}

const NOTE: &str = "another pair";

/// What a distribution of dissipation comes to.
struct Flux {
    /// Size of the normal dissipation over the tangential one.
    normal: f64,
    /// Dissipation along y over that along x.
    across: f64,
    /// Part of the tangential dissipation nearer to the ends than [`NEAR_ENDS`] allows.
    near_ends: f64,
    /// Size of the negative tangential flux over the whole: where pressure varies, tangential stiffness exchanges energy with
    /// it, which the incremental law does not balance in the normal direction.
    negative: f64,
    /// Standard deviation of the tangential flux over its mean, over the area.
    spread: f64,
}

impl Flux {
    fn new(mesh: &InterfaceMesh, fields: &PointFields) -> Self {
        let areas = mesh.areas();
        let integral =
            |values: &mut dyn Iterator<Item = f64>| areas.iter().zip(values).map(|(a, v)| a * v).sum::<f64>();
        let [x, y, n] = fields.flux.each_ref().map(|flux| integral(&mut flux.iter().copied()));
        let flux: Vec<f64> = fields.flux[0].iter().zip(&fields.flux[1]).map(|(x, y)| x + y).collect();
        let area: f64 = areas.iter().sum();
        let mean = (x + y) / area;
        let variance = integral(&mut flux.iter().map(|f| (f - mean).powi(2))) / area;
        let mut near = flux
            .iter()
            .zip(centres(mesh))
            .map(|(f, x)| if x.abs() > NEAR_ENDS { *f } else { 0.0 });
        Self {
            normal: n.abs() / (x + y),
            across: y / x,
            negative: integral(&mut flux.iter().map(|f| (-f).max(0.0))) / (x + y),
            near_ends: integral(&mut near) / (x + y),
            spread: variance.sqrt() / mean,
        }
    }
}

/// Part of the area near the ends.
fn near_ends_area(mesh: &InterfaceMesh) -> f64 {
    let areas = mesh.areas();
    let near = areas.iter().zip(centres(mesh)).filter(|(_, x)| x.abs() > NEAR_ENDS);
    near.map(|(area, _)| area).sum::<f64>() / areas.iter().sum::<f64>()
}

fn backbones(inputs: &Inputs, runs: &[&Record]) -> Result<Picture> {
    let curves = |of: fn(&Point) -> Option<f64>, named: bool| -> Vec<Curve> {
        let cases = [("topography", BLUE, None), ("flat", RED, Some((9, 5)))];
        let mut curves: Vec<Curve> = cases
            .into_iter()
            .zip(runs)
            .map(|((name, colour, dashes), run)| Curve {
                name: if named { name.to_owned() } else { String::new() },
                colour,
                dashes,
                marks: Marks::None,
                points: (run.backbone.iter())
                    .filter_map(|p| Some((p.index, p.displacement, of(p)?)))
                    .collect(),
            })
            .collect();
        // Points without lines: no two have neighbouring numbers.
        for ((_, colour, _), run) in cases.into_iter().zip(runs) {
            let points = marked(run).into_iter().flatten().enumerate();
            curves.push(Curve {
                name: String::new(),
                colour,
                dashes: None,
                marks: Marks::Dots,
                points: points
                    .filter_map(|(i, p)| Some((2 * i, p.displacement, of(p)?)))
                    .collect(),
            });
        }
        curves
    };
    let panel = |y_label, log, legend, of, named| Panel {
        y_label,
        log: bool::then_some(log, power as Numbers),
        legend,
        curves: curves(of, named),
    };
    Ok(Picture {
        name: "fig21",
        svg: stack(
            &inputs.amplitude_axis(),
            true,
            vec![
                panel(
                    "frequency [Hz]",
                    false,
                    SeriesLabelPosition::UpperRight,
                    |p| Some(p.frequency),
                    true,
                ),
                panel(
                    "damping ratio [-]",
                    true,
                    SeriesLabelPosition::UpperRight,
                    |p| p.damping,
                    false,
                ),
                panel(
                    "energy per cycle [J]",
                    true,
                    SeriesLabelPosition::UpperRight,
                    |p| Some(p.dissipation),
                    false,
                ),
            ],
        )?,
        caption: "Backbones to unrealistic amplitudes at mu = 0.2; dots are the four points.".into(),
    })
}
