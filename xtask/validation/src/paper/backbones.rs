//! Entries about frequency and damping against amplitude.

use super::entry::{Entry, Figure, Findings, Picture, Plan, claim};
use super::inputs::{Inputs, mesh_error, per_element};
use super::runs::{Point, Record};
use crate::elements::given;
use analyses::results::trends::{PowerLaw, at, power_law};
use anyhow::{Context, Result, bail};
use brake_reuss_beam::published::{self, BACKBONE_FLAT, BACKBONE_TOPOGRAPHY, BackbonePoint};
use contact_laws::{HistoryRule, TangentialReading};
use plotters::prelude::{RGBColor, SeriesLabelPosition};
use reports::map::rgb;
use reports::plot::{BLUE, Curve, Marks, Numbers, Panel, RED, power, stack};
use reports::styles::title;
use scenes::{Commit, Friction, Gap, Law, LawKind, Method, Scene};
use surface_characterisation::{
    AsperityCount, HeightCombination, Options, PackingHeight, PairRadius, RadiusStatistic, characterise,
};

/// Displacements of the families, by linear estimate (m).
pub(super) const SMALLEST: f64 = 5e-7;
pub(super) const LARGEST: f64 = 1e-3;

/// Displacements of the extended backbones, by linear estimate (m). The paper goes to about 1 m; from 30 mm on load steps need
/// factorisations, and an amplitude takes minutes.
pub(super) const EXTENDED: [f64; 2] = [1e-5, 1e-2];

/// Part of the slipping area between which power laws are fitted.
const PARTIAL_SLIP: [f64; 2] = [0.2, 0.9];

/// Colours from dark to light that stay apart for all eyes and in grey.
fn shades(n: usize) -> Vec<RGBColor> {
    // The light end of the map is hardly seen on white.
    let last = n.saturating_sub(1).max(1) as f64;
    let of = |i: usize| {
        let [r, g, b] = rgb(0.85 * i as f64 / last);
        RGBColor(r, g, b)
    };
    (0..n).map(of).collect()
}

/// Backbone with topography at a friction coefficient.
pub(super) fn family(inputs: &Inputs, mu: f64) -> Scene {
    let mut scene = inputs.backbone(&format!("topography, mu = {mu}"), 19, SMALLEST, LARGEST);
    scene.interfaces.mu = mu;
    scene.interfaces.gap = Gap::Measured;
    scene
}

/// Backbone to unrealistic amplitudes at mu = 0.2, with all fields.
pub(super) fn extended(inputs: &Inputs, gap: Gap) -> Scene {
    let mut scene = inputs.backbone("extended backbone", 19, EXTENDED[0], EXTENDED[1]);
    scene.interfaces.gap = gap;
    scene.output.fields_at = Some((1..=scene.analyses.backbone.amplitudes).collect());
    scene
}

/// A line of a record.
fn curve(name: String, colour: RGBColor, dashes: Option<(u32, u32)>, points: &[(f64, f64)]) -> Curve {
    Curve {
        name,
        colour,
        dashes,
        marks: Marks::None,
        points: points.iter().enumerate().map(|(i, &(x, y))| (i, x, y)).collect(),
    }
}

/// What a diagram of one quantity takes from an amplitude.
type Quantity = fn(&Point) -> Option<f64>;

const FREQUENCY: Quantity = |p| Some(p.frequency);
const DAMPING: Quantity = |p| p.damping;
const DISSIPATION: Quantity = |p| Some(p.dissipation);

/// Frequency and damping of several records above one another, and dissipation on request.
fn diagrams(inputs: &Inputs, records: &[(String, &Record)], dissipation: bool) -> Result<String> {
    let colours = shades(records.len());
    let lines = |of: Quantity, named: bool| -> Vec<Curve> {
        let each = records.iter().zip(&colours).enumerate();
        each.map(|(i, ((name, record), colour))| {
            let name = if named { name.clone() } else { String::new() };
            let dashes = (i % 2 == 1).then_some((9, 5));
            curve(name, *colour, dashes, &record.curve(of))
        })
        .collect()
    };
    let mut panels = vec![
        Panel {
            y_label: "frequency [Hz]",
            log: None,
            legend: SeriesLabelPosition::LowerLeft,
            curves: lines(FREQUENCY, true),
        },
        Panel {
            y_label: "damping ratio [-]",
            log: Some(power),
            legend: SeriesLabelPosition::LowerRight,
            curves: lines(DAMPING, false),
        },
    ];
    if dissipation {
        panels.push(Panel {
            y_label: "energy per cycle [J]",
            log: Some(power),
            legend: SeriesLabelPosition::LowerRight,
            curves: lines(DISSIPATION, false),
        });
    }
    Ok(stack(&inputs.amplitude_axis(), true, panels)?)
}

pub(super) const FIG_19: Entry = Entry {
    id: "fig19",
    title: "Fig. 19: frequency, damping and dissipation for friction coefficients from 0.05 to 0.99",
    inputs: "Measured statistics and gap of another pair, 12.845 kN per bolt, displacement of 0.5 um to 1 mm by linear estimate. \
             Power laws are fitted to the energy per cycle where 20 to 90 % of the area slips.",
    plan: fig_19,
};

pub(super) const MUS: [f64; 7] = [0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 0.99];

/// Displacement where damping is compared (m).
const COMPARED: f64 = 1e-4;

/// Power law of the energy per cycle in partial slip.
fn dissipation_law(record: &Record) -> Option<PowerLaw> {
    let partial = |p: &&Point| (PARTIAL_SLIP[0]..=PARTIAL_SLIP[1]).contains(&p.slip);
    let points: Vec<(f64, f64)> = record
        .backbone
        .iter()
        .filter(partial)
        .map(|p| (p.displacement, p.dissipation))
        .collect();
    power_law(&points, [0.0, f64::INFINITY])
}

fn fig_19(inputs: &Inputs) -> Result<Plan<'_>> {
    Ok(Plan {
        scenes: MUS.iter().map(|&mu| family(inputs, mu)).collect(),
        evaluate: Box::new(|results| {
            let runs = results.all()?;
            let note = "asperities and gap of another pair";
            let table = published::FIRST_FREQUENCY;
            let mut figures = vec![
                Figure::new(
                    "first frequency, nominally stuck (Hz)",
                    table.topography_per_element,
                    runs[0].first(),
                    note,
                ),
                Figure::new(
                    "offset of that from the measured frequency (Hz)",
                    None,
                    runs[0].first() - table.measured,
                    "published: -6.7 by Table 1, about 8 in words",
                ),
            ];
            let mut slopes = Vec::new();
            let mut damping = Vec::new();
            let mut onsets = Vec::new();
            for (mu, run) in MUS.iter().zip(&runs) {
                if let Some(point) = run.backbone.iter().find(|p| p.slip > 0.0) {
                    // By number: at one modal force displacements differ in their last digits.
                    onsets.push(point.index);
                    let name = format!("displacement from which any part slips, mu = {mu} (m)");
                    figures.push(Figure::new(
                        name,
                        None,
                        point.displacement,
                        "of the amplitudes computed",
                    ));
                }
                if let Some(law) = dissipation_law(run) {
                    slopes.push(law.slope);
                    figures.push(Figure::new(
                        format!("slope of dissipation, mu = {mu}"),
                        None,
                        law.slope,
                        "log-log",
                    ));
                    figures.push(Figure::new(
                        format!("fitted from, mu = {mu} (m)"),
                        None,
                        law.range[0],
                        "",
                    ));
                    figures.push(Figure::new(format!("fitted to, mu = {mu} (m)"), None, law.range[1], ""));
                    figures.push(Figure::new(
                        format!("rms of the fit, mu = {mu} (ln)"),
                        None,
                        law.rms,
                        "",
                    ));
                }
                if let Some(zeta) = at(&run.curve(DAMPING), COMPARED) {
                    damping.push(zeta);
                    figures.push(Figure::new(format!("damping at 0.1 mm, mu = {mu}"), None, zeta, ""));
                }
            }
            let (low, high) = (
                slopes.iter().copied().fold(f64::INFINITY, f64::min),
                slopes.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            );
            let stuck = runs.iter().map(|run| run.first());
            let stuck = (
                stuck.clone().fold(f64::INFINITY, f64::min),
                stuck.fold(f64::NEG_INFINITY, f64::max),
            );
            let claims = [
                claim(
                    onsets.len() == MUS.len() && onsets.is_sorted(),
                    "the smaller the coefficient the earlier the onset of slip",
                ),
                // Near mu = 1 nothing changes any more, but for the last digits.
                claim(
                    damping.windows(2).all(|w| w[1] <= 1.01 * w[0]),
                    "at a given amplitude a smaller coefficient dissipates more",
                ),
                claim(high < 1.25 * low, "slopes of dissipation do not vary much"),
                claim(
                    stuck.1 < 1.001 * stuck.0,
                    "one frequency without slip for all coefficients",
                ),
            ];
            let judgement = format!(
                "Claims: {}. The slopes lie between {low:.2} and {high:.2}; the frequency without slip is {:+.1} Hz from the measured one, the paper's \
                 {:+.1} Hz (about 8 Hz in its text): the surfaces differ.",
                claims.join("; "),
                runs[0].first() - table.measured,
                table.topography_per_element - table.measured,
            );
            let names = MUS.iter().map(|mu| format!("mu = {mu}"));
            let records: Vec<(String, &Record)> = names.zip(runs).collect();
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![Picture {
                    name: "fig19",
                    svg: diagrams(inputs, &records, true)?,
                    caption:
                        "Frequency, damping and energy per cycle of the first mode for seven friction coefficients."
                            .into(),
                }],
            })
        }),
    })
}

pub(super) const METHODS: Entry = Entry {
    id: "methods",
    title: "CQSMA against QSMA, Masing's rule and RQNMA",
    inputs: "Flat faces, and the measured gap, measured statistics of another pair, mu = 0.2, displacement of 1 um to 1.5 mm. QSMA has its \
             contact linearised about the static state and friction with the limit of that state; its loops are closed ones.",
    plan: methods,
};

/// Displacements where methods are compared: stuck, in partial slip and where contact opens (m).
const COMPARED_METHODS: [f64; 4] = [2e-6, 1e-4, 2.5e-4, 1e-3];

/// Displacement from which damping is compared (m).
const SLIPPING: f64 = 5e-5;

/// Frequency and damping over those of CQSMA, less one, by displacement.
type Changes = [[f64; 2]; COMPARED_METHODS.len()];

/// Compares the methods of a run on `faces` with its CQSMA.
fn compared(run: &Record, names: &[&str], faces: &str, figures: &mut Vec<Figure>) -> Result<Vec<Changes>> {
    let ours = [run.curve(FREQUENCY), run.curve(DAMPING)];
    let mut add = |what: &str, x: f64, value: f64| {
        let name = format!("{what}, {faces}, at {:.0} um", 1e6 * x);
        figures.push(Figure::new(name, None, value, "the paper prints no figures"));
    };
    for x in COMPARED_METHODS {
        for (what, curve) in ["frequency of CQSMA (Hz)", "damping of CQSMA"].into_iter().zip(&ours) {
            if let Some(value) = at(curve, x) {
                add(what, x, value);
            }
        }
    }
    let mut all = Vec::new();
    for name in names {
        let theirs = curves_of(run, name)?;
        let mut changes = [[f64::NAN; 2]; COMPARED_METHODS.len()];
        for (change, x) in changes.iter_mut().zip(COMPARED_METHODS) {
            for (k, what) in ["frequency", "damping"].into_iter().enumerate() {
                // Where nothing slips damping is that of round-off and history rules.
                if k == 1 && x < SLIPPING {
                    continue;
                }
                if let (Some(theirs), Some(ours)) = (at(&theirs[k], x), at(&ours[k], x)) {
                    change[k] = theirs / ours - 1.0;
                    add(
                        &format!("{what} of {} over that of CQSMA, less one", title(name)),
                        x,
                        change[k],
                    );
                }
            }
        }
        all.push(changes);
    }
    Ok(all)
}

/// Frequency and damping of a method against displacement.
fn curves_of(run: &Record, name: &str) -> Result<[Vec<(f64, f64)>; 2]> {
    let points = run.methods.get(name).with_context(|| format!("{name} gave nothing"))?;
    Ok([
        points.iter().map(|p| (p.0, p.1)).collect(),
        points.iter().filter_map(|p| Some((p.0, p.2?))).collect(),
    ])
}

fn methods(inputs: &Inputs) -> Result<Plan<'_>> {
    let mut flat = inputs.backbone("four methods", 17, 1e-6, 1.5e-3);
    flat.analyses.backbone.methods = vec![Method::Qsma, Method::Masing, Method::Rqnma];
    let names: Vec<&str> = flat
        .analyses
        .backbone
        .methods
        .iter()
        .map(|method| method.name())
        .collect();
    let mut rough = flat.clone();
    rough.name = "four methods, measured gap".into();
    rough.interfaces.gap = Gap::Measured;
    Ok(Plan {
        scenes: vec![flat, rough],
        evaluate: Box::new(move |results| {
            let run = results.of(0)?;
            let mut figures = Vec::new();
            let changes = compared(run, &names, "flat faces", &mut figures)?;
            compared(results.of(1)?, &names, "measured gap", &mut figures)?;
            let mut lines = [
                vec![curve("CQSMA".into(), RED, None, &run.curve(FREQUENCY))],
                vec![curve(String::new(), RED, None, &run.curve(DAMPING))],
            ];
            let dashes = [(9, 5), (14, 4), (2, 4), (5, 9)];
            for ((name, colour), dashes) in names.iter().zip(shades(names.len())).zip(dashes) {
                let [frequency, damping] = curves_of(run, name)?;
                lines[0].push(curve(title(name), colour, Some(dashes), &frequency));
                lines[1].push(curve(String::new(), colour, Some(dashes), &damping));
            }
            let [frequency, damping] = lines;
            let panels = [
                ("frequency [Hz]", false, frequency),
                ("damping ratio [-]", true, damping),
            ];
            let panels = panels.into_iter().map(|(y_label, log, curves)| Panel {
                y_label,
                log: bool::then_some(log, power as Numbers),
                legend: SeriesLabelPosition::LowerLeft,
                curves,
            });
            let [qsma, masing, rqnma] = changes[..] else {
                bail!("{} of three methods were run", changes.len());
            };
            let percent = |value: f64| format!("{:+.2} %", 100.0 * value);
            let judgement = format!(
                "QSMA with linear contact is off by {} in frequency without slip and by {} at 1 mm, {}. Damping at 0.1 mm differs from that of \
                 CQSMA by {} (QSMA), {} (Masing) and {} (RQNMA).",
                percent(qsma[0][0]),
                percent(qsma[3][0]),
                if qsma[3][0] > 1e-3 {
                    "too stiff where contact should open"
                } else {
                    "so that opening contact matters little"
                },
                percent(qsma[1][1]),
                percent(masing[1][1]),
                percent(rqnma[1][1]),
            );
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![Picture {
                    name: "methods",
                    svg: stack(&inputs.amplitude_axis(), true, panels.collect())?,
                    caption: "Four methods on the flat interface at mu = 0.2.".into(),
                }],
            })
        }),
    })
}

pub(super) const READINGS: Entry = Entry {
    id: "readings",
    title: "Readings of the paper: which choice matters",
    inputs: "Flat faces, mu = 0.2, displacement of 1 um to 1 mm. First the measured statistics of another pair with one choice changed \
             at a time, then two synthetic scans per element in the fitted form, likewise.",
    plan: readings,
};

fn readings(inputs: &Inputs) -> Result<Plan<'_>> {
    let base = |name: &str| inputs.backbone(name, 11, 1e-6, 1e-3);
    let changed = |name: &str, change: &dyn Fn(&mut Scene)| {
        let mut scene = base(name);
        change(&mut scene);
        scene
    };
    let mut scenes = vec![
        base("as by default"),
        changed("k_t: paper", &|s| {
            s.interfaces.law.tangential = TangentialReading::Paper
        }),
        changed("history: paper", &|s| s.interfaces.law.history = HistoryRule::Paper),
        changed("history: potential", &|s| {
            s.interfaces.law.history = HistoryRule::Potential
        }),
        changed("commit at reversals, as published", &|s| {
            s.analyses.backbone.commit = Commit::AtReversals
        }),
        changed("law: fitted, eqs. (28), (29)", &|s| {
            s.interfaces.law.kind = LawKind::Fitted
        }),
        per_element(base("scans, as by default")),
        per_element(changed("scans, k_t: paper", &|s| {
            s.interfaces.law.tangential = TangentialReading::Paper
        })),
    ];
    let pair = inputs.scan()?;
    let scan = |name: &str, change: &dyn Fn(&mut Options)| -> Result<Scene> {
        let mut options = pair.found.options;
        // Bands do not enter the law.
        options.bootstrap.realisations = 0;
        change(&mut options);
        let [top, bottom] = &pair.faces;
        let found = characterise(top, bottom, &pair.outlines, &options)?;
        let mut scene = base(name);
        scene.interfaces.surface = given(
            found
                .elements
                .iter()
                .map(joints::interface::curves_of_element)
                .collect(),
        );
        Ok(scene)
    };
    scenes.push(scan("scans, radius: mean", &|o| o.radius = RadiusStatistic::Mean)?);
    scenes.push(scan("scans, radius of the pair: eq. (6) literal", &|o| {
        o.pair_radius = PairRadius::Eq6Literal;
    })?);
    scenes.push(scan("scans, height in eq. (26): mean peak", &|o| {
        o.packing_height = PackingHeight::MeanPeak;
    })?);
    scenes.push(scan("scans, N: summits counted", &|o| {
        o.count = AsperityCount::Summits
    })?);
    scenes.push(scan("scans, heights: summed", &|o| {
        o.heights = HeightCombination::Summed
    })?);
    let names: Vec<String> = scenes.iter().map(|scene| scene.name.clone()).collect();
    Ok(Plan {
        scenes,
        evaluate: Box::new(move |results| {
            let mut figures = Vec::new();
            let mut drawn = Vec::new();
            let mut of_scans = Vec::new();
            let mut ratio = f64::NAN;
            let mut dampings = (f64::INFINITY, 0.0_f64);
            let (mut lowest, mut highest) = ((f64::INFINITY, ""), (f64::NEG_INFINITY, ""));
            for (index, name) in names.iter().enumerate() {
                let run = results.of(index)?;
                let note = if name.starts_with("scans") {
                    "synthetic scans"
                } else {
                    "asperities of another pair"
                };
                let flat = published::FIRST_FREQUENCY.flat_per_element;
                figures.push(Figure::new(format!("f1, {name} (Hz)"), flat, run.first(), note));
                if run.first() < lowest.0 {
                    lowest = (run.first(), name);
                }
                if run.first() > highest.0 {
                    highest = (run.first(), name);
                }
                let damping = at(&run.curve(DAMPING), COMPARED);
                if let Some(zeta) = damping {
                    figures.push(Figure::new(format!("damping at 0.1 mm, {name}"), None, zeta, note));
                    if !name.starts_with("scans") {
                        dampings = (dampings.0.min(zeta), dampings.1.max(zeta));
                    }
                }
                if index == 1 {
                    ratio =
                        damping.unwrap_or(f64::NAN) / at(&results.of(0)?.curve(DAMPING), COMPARED).unwrap_or(f64::NAN);
                }
                let list = if name.starts_with("scans") {
                    &mut of_scans
                } else {
                    &mut drawn
                };
                list.push((name.clone(), run));
            }
            let range = highest.0 / lowest.0 - 1.0;
            let judgement = format!(
                "The first frequency runs from {:.1} Hz ({}) to {:.1} Hz ({}); the reading of k_t alone multiplies damping at 0.1 mm by {ratio:.2}, all \
                 readings of the measured statistics together by {:.2}: agreement within {:.0} % {} unless the reading is named.",
                lowest.0,
                lowest.1,
                highest.0,
                highest.1,
                dampings.1 / dampings.0,
                100.0 * range,
                if range > 0.01 {
                    "says little"
                } else {
                    "says something even"
                },
            );
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![
                    Picture {
                        name: "readings",
                        svg: diagrams(inputs, &drawn, false)?,
                        caption: "One choice changed at a time, measured statistics.".into(),
                    },
                    Picture {
                        name: "readings-scans",
                        svg: diagrams(inputs, &of_scans, false)?,
                        caption: "One choice changed at a time, synthetic scans per element.".into(),
                    },
                ],
            })
        }),
    })
}

pub(super) const EXPERIMENT: Entry = Entry {
    id: "experiment",
    title: "Against the experiment, and against an independent theory on the same measured surface",
    inputs: "Experiment: measured statistics and gap, mu = 0.2, 12.845 kN. Independent theory: published backbones by the extended \
             periodic motion concept (EPMC) with friction resolved over asperities that yield, mu = 0.03, 12.249 kN, E = 192.31 GPa, \
             nu = 0.3, 7784.3 kg/m^3, assembled without friction, 0.087 % background damping, 101 bins, one point per element: the scenes \
             `published-epmc-flat` and `-topography`. Asperities and gap are the same; the mesh is not.",
    plan: experiment,
};

fn experiment(inputs: &Inputs) -> Result<Plan<'_>> {
    let [flat, topography] = ["published-epmc-flat", "published-epmc-topography"].map(|name| inputs.benchmark(name));
    let [flat, topography] = [flat?, topography?];
    let lumped = |scene: &Scene| {
        let mut lumped = scene.clone();
        lumped.name = format!("{}, one limit per point", scene.name);
        lumped.interfaces.law = Law {
            friction: Some(Friction::Lumped),
            ..Law::default()
        };
        lumped
    };
    let ours = family(inputs, 0.2);
    let [error, error_of_published] = [&ours, &flat].map(mesh_error);
    Ok(Plan {
        scenes: vec![
            ours,
            flat.clone(),
            topography.clone(),
            lumped(&flat),
            lumped(&topography),
        ],
        evaluate: Box::new(move |results| {
            let ours = results.of(0)?;
            let measured = published::FIRST_FREQUENCY.measured;
            let damping = ours.curve(DAMPING);
            let largest = damping.iter().fold(0.0_f64, |most, p| most.max(p.1));
            let other = "asperities and gap of another pair";
            let mut figures = vec![
                Figure::new("f1 against the measured one (Hz)", measured, ours.first(), other),
                Figure::new(
                    "friction damping at 1 um",
                    None,
                    // None is resolved where there is next to none.
                    at(&damping, 1e-6).unwrap_or(0.0),
                    "measured: about 0.001, with all other damping of beam and suspension",
                ),
                Figure::new(
                    "largest friction damping up to 1 mm",
                    None,
                    largest,
                    "measured: rises many-fold",
                ),
            ];
            let mut frequencies = Vec::new();
            let mut dampings = Vec::new();
            let cases: [(&str, &[BackbonePoint], RGBColor); 2] = [
                ("flat", &BACKBONE_FLAT, RED),
                ("topography", &BACKBONE_TOPOGRAPHY, BLUE),
            ];
            // Of frequency relative to that at the smallest amplitude, and of damping.
            let mut apart = [[0.0_f64; 2]; 2];
            let mut offset = [0.0; 2];
            for (case, (name, table, colour)) in cases.into_iter().enumerate() {
                let (run, of_points) = (results.of(case + 1)?, results.of(case + 3)?);
                let against_amplitude = |run: &Record, of: Quantity| -> Vec<(f64, f64)> {
                    (run.backbone.iter())
                        .filter_map(|p| Some((p.modal_amplitude, of(p)?)))
                        .collect()
                };
                let here = |of: Quantity| against_amplitude(run, of);
                let there = |of: fn(&BackbonePoint) -> f64| -> Vec<(f64, f64)> {
                    table.iter().map(|p| (p.modal_amplitude, of(p))).collect()
                };
                let pairs = [
                    ("frequency", " (Hz)", here(FREQUENCY), there(|p| p.frequency)),
                    ("damping", "", here(DAMPING), there(|p| p.damping_ratio)),
                ];
                for (k, (what, unit, here, there)) in pairs.iter().enumerate() {
                    let mut first = None;
                    for &(q, b) in there {
                        if let Some(a) = at(here, q) {
                            let label = format!("{what}, {name}, at q = {q:.3e} sqrt(kg) m{unit}");
                            figures.push(Figure::new(label, b, a, "published: EPMC"));
                            // An offset of the frequency is the mesh's.
                            let offset = if k == 0 { *first.get_or_insert(a / b) } else { 1.0 };
                            apart[case][k] = apart[case][k].max((a / b / offset - 1.0).abs());
                        }
                    }
                    if let Some(first) = first {
                        offset[case] = first - 1.0;
                    }
                }
                let [(.., here_f, there_f), (.., here_d, there_d)] = pairs;
                frequencies.push(curve(format!("{name}, here"), colour, None, &here_f));
                frequencies.push(curve(format!("{name}, EPMC"), colour, Some((9, 5)), &there_f));
                dampings.push(curve(String::new(), colour, None, &here_d));
                dampings.push(curve(String::new(), colour, Some((9, 5)), &there_d));
                let (lumped_f, lumped_d) = (
                    against_amplitude(of_points, FREQUENCY),
                    against_amplitude(of_points, DAMPING),
                );
                frequencies.push(curve(
                    format!("{name}, one limit per point"),
                    colour,
                    Some((2, 4)),
                    &lumped_f,
                ));
                dampings.push(curve(String::new(), colour, Some((2, 4)), &lumped_d));
            }
            let line: Vec<(f64, f64)> = [1e-7, 1e-4].map(|q| (q, measured)).into();
            frequencies.push(curve(
                "measured, low amplitude".into(),
                RGBColor(0, 0, 0),
                Some((2, 4)),
                &line,
            ));
            let panels = [
                ("frequency [Hz]", false, frequencies),
                ("damping ratio [-]", true, dampings),
            ];
            let panels = panels.into_iter().map(|(y_label, log, curves)| Panel {
                y_label,
                log: bool::then_some(log, power as Numbers),
                legend: if log {
                    SeriesLabelPosition::UpperLeft
                } else {
                    SeriesLabelPosition::LowerLeft
                },
                curves,
            });
            let friction = at(&damping, 1e-6).unwrap_or(0.0);
            let rise = largest / published::LOW_AMPLITUDE_DAMPING;
            let judgement = format!(
                "The measured first frequency is met to {:+.2} %, and the error of the mesh is {error}. Claim: {}, up to {:.1} % by friction, {rise:.0} times the measured low-amplitude 0.1 %, of which \
                 friction explains {}. Against EPMC on the same surface damping differs by at most {:.1} % flat and {:.1} % with topography over three decades of amplitude; frequencies are \
                 {:+.2} % and {:+.2} % off at the smallest amplitude, where the error of the mesh is {error_of_published}, and their change with amplitude brings at most {:.2} % and {:.2} % more.",
                100.0 * (ours.first() / measured - 1.0),
                claim(rise > 3.0, "damping rises many-fold with amplitude"),
                100.0 * largest,
                if friction < 0.1 * published::LOW_AMPLITUDE_DAMPING {
                    "next to nothing: it is that of beam and suspension"
                } else {
                    "a part that counts"
                },
                100.0 * apart[0][1],
                100.0 * apart[1][1],
                100.0 * offset[0],
                100.0 * offset[1],
                100.0 * apart[0][0],
                100.0 * apart[1][0],
            );
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![Picture {
                    name: "epmc",
                    svg: stack("modal amplitude q [sqrt(kg) m]", true, panels.collect())?,
                    caption: "Here (solid), published EPMC backbones (dashed), and here with elastic asperities and one limit per point (dotted), mu = 0.03."
                        .into(),
                }],
            })
        }),
    })
}
