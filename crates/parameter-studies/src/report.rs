//! What a study writes: tables, the resolved plan, and a page with pictures.

use crate::Error;
use crate::design::{Column, Kind};
use crate::store::Store;
use crate::study::Study;
use crate::table::{CSV, PARQUET, Table};
use analyses::variants::{Curve, Reading, VariantPoint};
use reports::Output;
use reports::cases::{Amplitude, Cases, Factor, interactions, main_effects};
use reports::findings::{Findings, FindingsPage, Section};
use reports::html::{Picture, Table as HtmlTable};
use reports::parameters::{Axis, parallel, response_surface};
use serde_json::Value;

/// Name of the plan as it was understood.
const PLAN: &str = "plan.json";

/// Name of the page.
const REPORT: &str = "report.html";

/// Names of the pictures: backbones by parameter, main effects, frequency and damping against two parameters, and all parameters.
const PICTURES: [&str; 5] = [
    "backbones.svg",
    "effects.svg",
    "frequency.svg",
    "damping.svg",
    "parallel.svg",
];

/// Most cases that are better read from backbones than from parallel coordinates.
const FEW: usize = 10;

/// A case of the plan at the amplitude of the pictures.
struct Drawn {
    /// Its number in the plan, from 0 on.
    number: usize,
    parameters: Vec<Option<f64>>,
    frequency: f64,
    damping: Option<f64>,
}

/// The files of a study: tables, plan and page; `facts` are pairs of a name and a figure for the page.
///
/// # Errors
/// [`Error::Table`], [`Error::Parquet`], [`Error::Report`].
pub fn outputs(study: &Study<'_>, store: &Store, facts: &[(String, String)]) -> Result<Vec<Output>, Error> {
    let table = Table::new(study, store);
    let mut plan = serde_json::to_vec_pretty(&study.resolved()).map_err(|source| Error::Encoding {
        case: PLAN.into(),
        source,
    })?;
    plan.push(b'\n');
    let mut outputs = vec![
        Output::new(CSV, table.csv()?),
        Output::new(PLAN, plan),
        Output::new(PARQUET, table.parquet()?),
    ];
    drop(table);
    let facts = HtmlTable {
        headings: vec!["of the study".into(), "figure".into()],
        rows: facts
            .iter()
            .map(|(name, figure)| vec![name.clone(), figure.clone()])
            .collect(),
    };
    let mut sections = vec![Section {
        id: "study",
        title: "The study",
        inputs: "What was run, and what came of it.",
        findings: Ok(Findings {
            judgement: "The tables results.csv and results.parquet hold every case, mode and amplitude.",
            pictures: Vec::new(),
            tables: vec![(String::new(), facts)],
            remark: String::new(),
        }),
    }];
    let curves = curves(study, store);
    let cases = cases(study, &curves);
    let drawn = amplitude(study, &curves).map(|amplitude| (amplitude, drawn(study, &curves, amplitude)));
    let mut pictures = Vec::new();
    let of_cases;
    match &drawn {
        Some((amplitude, drawn)) if !drawn.is_empty() => {
            let mode = curves.iter().flatten().next().map_or(1, |curve| curve.mode);
            of_cases = format!(
                "Mode {mode} at a displacement amplitude of {amplitude:.4e} m at the response point: {} of {} cases reach it.",
                drawn.len(),
                study.of_plan.len()
            );
            pictures = self::pictures(study, drawn, &cases)?;
            let shown = pictures.iter().map(|(name, svg, caption)| {
                outputs.push(Output::new(*name, svg.as_bytes()));
                Picture {
                    svg: svg.as_str().into(),
                    caption: caption.clone(),
                }
            });
            sections.push(Section {
                id: "parameters",
                title: "Frequency and damping against the parameters",
                inputs: &of_cases,
                findings: Ok(Findings {
                    judgement: "",
                    pictures: shown.collect(),
                    tables: tables(study, drawn),
                    remark: "On the diagonal: from the lower to the upper half of a parameter's range. Beside it: how half of that effect grows from the lower \
                             to the upper half of another parameter's range (two-factor interaction). Damping below its floor is left out."
                        .into(),
                }),
            });
        }
        _ => sections.push(Section {
            id: "parameters",
            title: "Frequency and damping against the parameters",
            inputs: "Pictures compare cases at one displacement amplitude at the response point.",
            findings: Err("no case reaches the amplitude; give another `amplitude` in the plan"),
        }),
    }
    let title = format!("Study of {}", study.scene_name());
    let page = FindingsPage {
        title: &title,
        introduction: "Hysteresis loops of many variants of one scene.",
        warning: None,
        sections,
        cases: (!cases.parameters.is_empty()).then(|| cases.thinned()),
    };
    let page = page.html()?;
    drop(pictures);
    outputs.push(Output::new(REPORT, page));
    Ok(outputs)
}

/// The backbone of the first mode of every case of the plan, where it has one.
fn curves(study: &Study<'_>, store: &Store) -> Vec<Option<Curve>> {
    let curve = |index: &usize| {
        let case = study.cases.get(*index)?;
        let modes = store.get(&case.address)?.outcome.as_ref().ok()?;
        Some(modes.first()?.curve())
    };
    study.of_plan.iter().map(curve).collect()
}

/// The amplitude of the plan, or the largest that all cases with a backbone reach.
fn amplitude(study: &Study<'_>, curves: &[Option<Curve>]) -> Option<f64> {
    if let Some(given) = study.plan.amplitude {
        return Some(given.si());
    }
    let last = curves.iter().flatten().filter_map(|curve| curve.points.last());
    last.map(|point| point.response_displacement).reduce(f64::min)
}

/// The backbones of all cases that have one, with what varies among them.
fn cases(study: &Study<'_>, curves: &[Option<Curve>]) -> Cases {
    let known: Vec<(usize, &Curve)> = curves
        .iter()
        .enumerate()
        .filter_map(|(number, curve)| Some((number, curve.as_ref()?)))
        .collect();
    let numbers: Vec<usize> = known.iter().map(|(number, _)| *number).collect();
    let amplitude = |point: &VariantPoint| Amplitude {
        amplitude_m: point.response_displacement,
        frequency_hz: point.frequency_hz,
        damping_ratio: point.damping_ratio,
    };
    Cases {
        parameters: factors(study, &numbers),
        backbones: known
            .iter()
            .map(|(_, curve)| curve.points.iter().map(amplitude).collect())
            .collect(),
        numbers: numbers.iter().map(|number| number + 1).collect(),
    }
}

/// What varies among cases of these numbers.
fn factors(study: &Study<'_>, numbers: &[usize]) -> Vec<Factor> {
    let values: Vec<Vec<Option<&Value>>> = numbers.iter().map(|number| study.design.values(*number)).collect();
    let factor = |(k, column): (usize, &Column)| {
        let of_case = |values: &Vec<Option<&Value>>| values.get(k).copied().flatten().cloned();
        let given: Vec<Option<Value>> = values.iter().map(of_case).collect();
        let mut labels: Vec<String> = Vec::new();
        let values = match column.kind {
            Kind::Text => {
                let mut place = |value: &Value| {
                    let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                    let known = labels.iter().position(|label| *label == text);
                    known.unwrap_or_else(|| {
                        labels.push(text);
                        labels.len() - 1
                    }) as f64
                };
                given.iter().map(|value| value.as_ref().map(&mut place)).collect()
            }
            Kind::Number | Kind::Quantity(_) => given
                .iter()
                .map(|value| column.number(value.as_ref()?))
                .collect::<Vec<_>>(),
        };
        let name = column.heading();
        Factor { name, values, labels }
    };
    let several = |factor: &Factor| {
        let mut known = factor.values.iter().flatten();
        let first = known.next();
        known.any(|value| Some(value) != first)
    };
    study.columns().iter().enumerate().map(factor).filter(several).collect()
}

/// Extremes of frequency and damping, and what pairs of parameters do to them.
fn tables(study: &Study<'_>, drawn: &[Drawn]) -> Vec<(String, HtmlTable)> {
    let numbers: Vec<usize> = drawn.iter().map(|case| case.number).collect();
    let factors = factors(study, &numbers);
    let mut tables = vec![(String::new(), extremes(drawn))];
    let values: [(&str, Vec<Option<f64>>); 2] = [
        ("frequency", drawn.iter().map(|case| Some(case.frequency)).collect()),
        ("damping", drawn.iter().map(|case| case.damping).collect()),
    ];
    for (name, values) in values.iter().filter(|_| !factors.is_empty()) {
        let heading = format!("Effects on the {name}, relative to its mean");
        tables.push((heading, interactions(&factors, values)));
    }
    tables
}

fn drawn(study: &Study<'_>, curves: &[Option<Curve>], amplitude: f64) -> Vec<Drawn> {
    let case = |(number, curve): (usize, &Option<Curve>)| {
        let [frequency, damping] = curve.as_ref()?.at(Reading::Secant, amplitude)?;
        let values = study.design.values(number);
        let parameters = study.columns().iter().zip(values);
        Some(Drawn {
            number,
            parameters: parameters.map(|(column, value)| column.number(value?)).collect(),
            frequency,
            damping: damping.is_finite().then_some(damping),
        })
    };
    curves.iter().enumerate().filter_map(case).collect()
}

/// Whether a parameter takes several numbers.
fn varies(drawn: &[Drawn], column: usize) -> bool {
    let mut values = drawn
        .iter()
        .filter_map(|case| case.parameters.get(column).copied().flatten());
    let first = values.next();
    values.any(|value| Some(value) != first)
}

/// Name, picture and caption.
type Named = (&'static str, String, String);

fn pictures(study: &Study<'_>, drawn: &[Drawn], cases: &Cases) -> Result<Vec<Named>, Error> {
    let columns: Vec<(usize, &Column)> = study
        .columns()
        .iter()
        .enumerate()
        .filter(|(k, _)| varies(drawn, *k))
        .collect();
    let axis = |name: String, values: &dyn Fn(&Drawn) -> Option<f64>| Axis {
        name,
        values: drawn.iter().map(values).collect(),
    };
    let of_parameter =
        |&(k, column): &(usize, &Column)| axis(column.heading(), &|case| case.parameters.get(k).copied().flatten());
    let frequency = || axis("frequency [Hz]".into(), &|case| Some(case.frequency));
    let damping = || axis("damping ratio [-]".into(), &|case| case.damping);
    let [backbones, effects, of_frequency, of_damping, all] = PICTURES;
    let mut pictures = Vec::new();
    if !cases.parameters.is_empty() {
        let mut caption = "Backbones of the cases, once for each parameter, whose value is the colour.".to_owned();
        let stride = cases.stride();
        if stride > 1 {
            let all = cases.backbones.len();
            caption += &format!(" Of {all} cases, one of {stride} is drawn, here and in the curves to turn through.");
        }
        pictures.push((backbones, cases.backbones()?, caption));
        let numbers: Vec<usize> = drawn.iter().map(|case| case.number).collect();
        let quantities = [
            drawn.iter().map(|case| Some(case.frequency)).collect(),
            drawn.iter().map(|case| case.damping).collect(),
        ];
        let factors = factors(study, &numbers);
        if !factors.is_empty() {
            let caption = "Main effects: means over the cases at each value of a parameter.".to_owned();
            pictures.push((effects, main_effects(&factors, &quantities)?, caption));
        }
    }
    if let [first, second, others @ ..] = columns.as_slice() {
        // Of further parameters, the middle one of their values.
        let middle: Vec<(usize, f64, String)> = others
            .iter()
            .filter_map(|(k, column)| Some((*k, middle(drawn, *k)?, column.heading())))
            .collect();
        let is_grid = study.design.grid().is_some();
        let is_shown = |case: &Drawn| {
            let at = |(k, value, _): &(usize, f64, String)| case.parameters.get(*k).copied().flatten() == Some(*value);
            !is_grid || middle.iter().all(at)
        };
        let shown = |axis: Axis| Axis {
            name: axis.name,
            values: drawn
                .iter()
                .zip(axis.values)
                .filter(|(case, _)| is_shown(case))
                .map(|(_, v)| v)
                .collect(),
        };
        let at: Vec<String> = middle
            .iter()
            .map(|(_, value, heading)| format!("{heading} = {value}"))
            .collect();
        let caption = |what: &str| match (is_grid, at.is_empty()) {
            (_, true) => format!("{what} against {} and {}.", first.1.heading(), second.1.heading()),
            (true, false) => format!(
                "{what} against {} and {}, at {}.",
                first.1.heading(),
                second.1.heading(),
                at.join(", ")
            ),
            (false, false) => format!(
                "{what} against {} and {}; other parameters vary too.",
                first.1.heading(),
                second.1.heading()
            ),
        };
        for (name, of, what) in [
            (of_frequency, frequency(), "Frequency"),
            (of_damping, damping(), "Damping ratio"),
        ] {
            let svg = response_surface(&shown(of_parameter(first)), &shown(of_parameter(second)), &shown(of))?;
            pictures.push((name, svg, caption(what)));
        }
    }
    if drawn.len() > FEW {
        let mut axes: Vec<Axis> = columns.iter().map(of_parameter).collect();
        axes.extend([damping(), frequency()]);
        let (svg, lines) = parallel(&axes)?;
        let count = drawn.len();
        let caption = format!("Each line is a case ({lines} of {count}); its colour is its frequency.");
        pictures.push((all, svg, caption));
    }
    Ok(pictures)
}

/// The middle one of the values of a parameter.
fn middle(drawn: &[Drawn], column: usize) -> Option<f64> {
    let values = drawn
        .iter()
        .filter_map(|case| case.parameters.get(column).copied().flatten());
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values.get((values.len().max(1) - 1) / 2).copied()
}

/// Smallest and largest frequency and damping.
fn extremes(drawn: &[Drawn]) -> HtmlTable {
    let row = |name: &str, values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let cell = |value: f64| {
            if value.is_finite() {
                format!("{value:.5e}")
            } else {
                "-".into()
            }
        };
        vec![name.to_owned(), cell(low), cell(high)]
    };
    HtmlTable {
        headings: ["at the amplitude", "smallest", "largest"].map(str::to_owned).to_vec(),
        rows: vec![
            row("frequency [Hz]", &mut drawn.iter().map(|case| case.frequency)),
            row("damping ratio [-]", &mut drawn.iter().filter_map(|case| case.damping)),
        ],
    }
}
