//! Entries that show fields over the interface.

use super::backbones::extended;
use super::runs::{Point, Record};
use super::{Entry, Figure, Findings, Inputs, Picture, Plan, per_element};
use crate::map::{Map, several};
use crate::plot::{BLUE, Curve, Panel, RED, RESPONSE, stack};
use anyhow::Result;
use joint_pipeline::scene::Gap;
use plotters::prelude::SeriesLabelPosition;
use zte_assembly::InterfaceMesh;

pub(super) const FIG_17: Entry = Entry {
    id: "fig17",
    title: "Figs. 17 and 18: pressure and tangential traction under prestress",
    inputs: "Prestress at mu = 0.6 with 25 points per element; the cases of Table 1: gap of another pair with synthetic scans per \
             element, flat with them, flat with the measured statistics of another pair (uniform), and these with their gap.",
    plan: fig_17,
};

const CASES: [&str; 4] = [
    "topography, per element",
    "flat, per element",
    "flat, uniform",
    "topography, uniform",
];

fn fig_17(inputs: &Inputs) -> Result<Plan<'_>> {
    let mesh = &inputs.mesh;
    Ok(Plan {
        scenes: vec![
            per_element(inputs.prestress("prestress, per element", Gap::Measured)),
            per_element(inputs.prestress("prestress, per element", Gap::Flat)),
            inputs.prestress("prestress, measured statistics", Gap::Flat),
            inputs.prestress("prestress, measured statistics", Gap::Measured),
        ],
        evaluate: Box::new(move |results| {
            let runs = results.all()?;
            let mut figures = Vec::new();
            let paper = brake_reuss_beam::published::BOLT_STRAIN_TABLE[4];
            let areas = [
                paper.topography_contact,
                paper.flat_contact,
                f64::NAN,
                paper.topography_contact,
            ];
            let note = "another surface";
            for ((case, run), area) in CASES.iter().zip(&runs).zip(areas) {
                let area = area.is_finite().then_some(area);
                figures.push(Figure::new(
                    format!("contact area by element centres, {case}"),
                    area,
                    run.contact[2],
                    note,
                ));
                figures.push(Figure::new(
                    format!("area with more than 1 % of the mean pressure, {case}"),
                    None,
                    loaded(mesh, run),
                    note,
                ));
                let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
                figures.push(Figure::new(
                    format!("largest pressure, {case} (Pa)"),
                    None,
                    largest(&run.central[2]),
                    note,
                ));
                let tangential = run.central[0].iter().zip(&run.central[1]).map(|(x, y)| x.hypot(*y));
                let tangential: Vec<f64> = tangential.collect();
                figures.push(Figure::new(
                    format!("largest tangential traction, {case} (Pa)"),
                    None,
                    largest(&tangential),
                    note,
                ));
                let lowest = run.nodal[2].iter().copied().fold(f64::INFINITY, f64::min);
                figures.push(Figure::new(
                    format!("smallest nodal pressure by least squares, {case} (Pa)"),
                    None,
                    lowest,
                    "published: negative in some regions",
                ));
            }
            let pressure = |run: &Record, case: &str| Map {
                label: format!("pressure, {case} [MPa]"),
                values: (run.central[2].iter())
                    .map(|p| if *p > 0.0 { 1e-6 * p } else { f64::NAN })
                    .collect(),
            };
            // The nodal field at the middles of the elements: what interpolation makes of it there.
            let nodal = |run: &Record, component: usize, name: &str| Map {
                label: format!("nodal {name}, per element [MPa]"),
                values: (mesh.elements.iter())
                    .map(|element| {
                        let nodes = element.nodes();
                        let sum: f64 = nodes.iter().map(|&n| run.nodal[component][n as usize]).sum();
                        1e-6 * sum / nodes.len() as f64
                    })
                    .collect(),
            };
            let mut maps: Vec<Map> = CASES.iter().zip(&runs).map(|(case, run)| pressure(run, case)).collect();
            maps.push(nodal(runs[0], 2, "pressure"));
            maps.push(nodal(runs[0], 0, "traction x"));
            maps.push(nodal(runs[0], 1, "traction y"));
            let negative = runs.iter().all(|run| run.nodal[2].iter().any(|p| *p < 0.0));
            let spread = |run: &Record| {
                let closed: Vec<f64> = run.central[2].iter().copied().filter(|p| *p > 0.0).collect();
                let n = closed.len() as f64;
                let mean = closed.iter().sum::<f64>() / n;
                (closed.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / n).sqrt() / mean
            };
            let judgement = format!(
                "By the centres of elements {:.0} % of the area is in contact with topography and {:.0} % flat (published {:.0} and {:.0} %): a few tall \
                 asperities of this surface touch where the paper's does not, but only {:.0} % with topography, against {:.0} % flat, carries more \
                 than 1 % of the mean pressure; uniform roughness evens out the pressure as published (spread over mean {:.2} per element, \
                 {:.2} uniform); the nodal least-squares pressure is negative in places {}.",
                100.0 * runs[3].contact[2],
                100.0 * runs[2].contact[2],
                100.0 * paper.topography_contact,
                100.0 * paper.flat_contact,
                100.0 * loaded(mesh, runs[3]),
                100.0 * loaded(mesh, runs[2]),
                spread(runs[1]),
                spread(runs[2]),
                if negative {
                    "in every case, as in the paper"
                } else {
                    "with roughness per element, as in the paper, but NOT in every uniform case"
                },
            );
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![Picture {
                    name: "fig17",
                    svg: several(mesh, &maps, 2),
                    caption: "Pressure at the centres of the elements (white: open), and nodal values by least squares at the same places; seen \
                              from above, the beam's axis to the right."
                        .into(),
                }],
            })
        }),
    })
}

/// Pressure, relative to the mean, above which an element counts as loaded.
const LOADED: f64 = 0.01;

/// Part of the area whose elements carry more than [`LOADED`] of the mean pressure at their centres.
pub(super) fn loaded(mesh: &InterfaceMesh, run: &Record) -> f64 {
    let areas = mesh.areas();
    let total: f64 = areas.iter().sum();
    let pressures = || areas.iter().zip(&run.central[2]);
    let mean = pressures().map(|(area, p)| area * p).sum::<f64>() / total;
    let over = pressures().filter(|(_, p)| **p > LOADED * mean);
    over.map(|(area, _)| area).sum::<f64>() / total
}

pub(super) const FIG_21: Entry = Entry {
    id: "fig21",
    title: "Figs. 21 and 22: backbone to unrealistic amplitudes, and where energy is dissipated",
    inputs: "Measured statistics of another pair with its gap and flat, mu = 0.2, displacement of 0.1 um to 30 mm by linear \
             estimate (the paper: about 1 m, where an amplitude takes minutes here). Point 1: the first amplitude with resolved damping of 1e-5; 2: the last before the frequency has fallen by 1 %; \
             3: the largest damping; 4: the largest amplitude.",
    plan: fig_21,
};

/// Damping ratio of point 1: nominally stuck.
const STUCK_DAMPING: f64 = 1e-5;

/// Fall of the frequency up to point 2.
const DOWNTURN: f64 = 0.01;

/// The four marked points of a backbone, by the rules of the entry.
pub(super) fn marked(run: &Record) -> [Option<&Point>; 4] {
    let points = &run.backbone;
    let first = run.first();
    let damped = |p: &&Point| p.damping.is_some();
    [
        points
            .iter()
            .find(|p| p.damping.is_some_and(|zeta| zeta >= STUCK_DAMPING)),
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
            let mut figures = Vec::new();
            let mut pictures = Vec::new();
            let (mut normal_shares, mut peak_slips) = (Vec::new(), Vec::new());
            for ((case, name), run) in [("topography", "fig21-flux"), ("flat", "fig22-flux")]
                .into_iter()
                .zip(&runs)
            {
                let mut maps = Vec::new();
                for (number, point) in marked(run).into_iter().enumerate() {
                    let Some((point, fields)) = point.and_then(|p| Some((p, p.fields.as_ref()?))) else {
                        continue;
                    };
                    let at = format!("{case}, point {}", number + 1);
                    figures.push(Figure::new(
                        format!("displacement, {at} (m)"),
                        None,
                        point.displacement,
                        "",
                    ));
                    figures.push(Figure::new(format!("frequency, {at} (Hz)"), None, point.frequency, ""));
                    figures.push(Figure::new(
                        format!("damping, {at}"),
                        None,
                        point.damping.unwrap_or(f64::NAN),
                        "",
                    ));
                    let areas = mesh.areas();
                    let total = |flux: &[f64]| flux.iter().zip(&areas).map(|(f, a)| f * a).sum::<f64>();
                    let [x, y, n] = fields.flux.each_ref().map(|flux| total(flux));
                    let share = n.abs() / (x + y);
                    figures.push(Figure::new(
                        format!("normal over tangential dissipation, {at}"),
                        None,
                        share,
                        "",
                    ));
                    if number < 3 {
                        normal_shares.push(share);
                    }
                    if number == 2 {
                        peak_slips.push(point.slip);
                        figures.push(Figure::new(
                            format!("part of the area that slips, {at}"),
                            None,
                            point.slip,
                            "",
                        ));
                    }
                    maps.extend(["x", "y", "n"].into_iter().zip(&fields.flux).map(|(axis, flux)| Map {
                        label: format!("point {}, flux {axis} [J/m²]", number + 1),
                        values: flux.clone(),
                    }));
                }
                pictures.push(Picture {
                    name,
                    svg: several(mesh, &maps, 3),
                    caption: format!(
                        "Dissipated energy per area and cycle ({case}) along x, y and the normal at the four points; each map has its own \
                         range."
                    ),
                });
            }
            pictures.insert(0, backbones(&runs)?);
            let most = normal_shares.iter().copied().fold(0.0, f64::max);
            let steady = runs.iter().all(|run| {
                let frequencies: Vec<f64> = run.backbone.iter().map(|p| p.frequency).collect();
                frequencies.windows(2).all(|w| w[1] < w[0] * (1.0 + 1e-6))
            });
            let judgement = format!(
                "Up to point 3 the normal dissipation is at most {most:.1e} of the tangential one (published: several orders of magnitude less); \
                 at the peak of damping {:.0} % of the area slips with topography and {:.0} % flat, almost all of what is closed; the frequency \
                 falls {} up to the largest amplitude, as published, where the assumption of a fixed mode shape has long failed.",
                100.0 * peak_slips.first().copied().unwrap_or(f64::NAN),
                100.0 * peak_slips.get(1).copied().unwrap_or(f64::NAN),
                if steady { "steadily" } else { "NOT steadily" },
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

fn backbones(runs: &[&Record]) -> Result<Picture> {
    let curves = |of: fn(&Point) -> Option<f64>, named: bool| -> Vec<Curve> {
        let cases = [("topography", BLUE, None), ("flat", RED, Some((9, 5)))];
        let mut curves: Vec<Curve> = cases
            .into_iter()
            .zip(runs)
            .map(|((name, colour, dashes), run)| Curve {
                name: if named { name.to_owned() } else { String::new() },
                colour,
                dashes,
                dots: false,
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
                dots: true,
                points: points
                    .filter_map(|(i, p)| Some((2 * i, p.displacement, of(p)?)))
                    .collect(),
            });
        }
        curves
    };
    let panel = |y_label, log, legend, of, named| Panel {
        y_label,
        log,
        legend,
        curves: curves(of, named),
    };
    Ok(Picture {
        name: "fig21",
        svg: stack(
            &format!("{RESPONSE} [m]"),
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
