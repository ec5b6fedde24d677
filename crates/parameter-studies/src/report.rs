//! What a study writes: tables, the resolved plan, and a page with pictures.

use crate::Error;
use crate::design::Column;
use crate::store::Store;
use crate::study::Study;
use crate::table::{CSV, Table};
use analyses::variants::{Curve, Reading};
use reports::Output;
use reports::findings::{Findings, FindingsPage, Section};
use reports::html::{Picture, Table as HtmlTable};
use reports::parameters::{Axis, parallel, response_surface};

/// Name of the plan as it was understood.
const PLAN: &str = "plan.json";

/// Name of the page.
const REPORT: &str = "report.html";

/// Names of the pictures: all parameters, then frequency and damping against two of them.
const PICTURES: [&str; 3] = ["parallel.svg", "frequency.svg", "damping.svg"];

/// A case of the plan at the amplitude of the pictures.
struct Drawn {
    parameters: Vec<Option<f64>>,
    frequency: f64,
    damping: Option<f64>,
}

/// The files of a study: tables, plan and page; `facts` are pairs of a name and a figure for the page.
///
/// # Errors
/// [`Error::Table`], [`Error::Report`]; one of Parquet, where it is built in.
pub fn outputs(study: &Study<'_>, store: &Store, facts: &[(String, String)]) -> Result<Vec<Output>, Error> {
    let table = Table::new(study, store);
    let mut plan = serde_json::to_vec_pretty(&study.resolved()).map_err(|source| Error::Encoding {
        case: PLAN.into(),
        source,
    })?;
    plan.push(b'\n');
    let mut outputs = vec![Output::new(CSV, table.csv()?), Output::new(PLAN, plan)];
    #[cfg(feature = "parquet")]
    outputs.push(Output::new(crate::table::PARQUET, table.parquet()?));
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
            judgement: match cfg!(feature = "parquet") {
                true => "The tables results.csv and results.parquet hold every case, mode and amplitude.",
                false => "The table results.csv holds every case, mode and amplitude.",
            },
            pictures: Vec::new(),
            table: facts,
            remark: String::new(),
        }),
    }];
    let curves = curves(study, store);
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
            pictures = self::pictures(study, drawn)?;
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
                    judgement: "Lines and fields are cases; their colour is the quantity that the bar names.",
                    pictures: shown.collect(),
                    table: extremes(drawn),
                    remark: "Damping below its floor is left out.".into(),
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

fn drawn(study: &Study<'_>, curves: &[Option<Curve>], amplitude: f64) -> Vec<Drawn> {
    let case = |(number, curve): (usize, &Option<Curve>)| {
        let [frequency, damping] = curve.as_ref()?.at(Reading::Secant, amplitude)?;
        let values = study.design.values(number);
        let parameters = study.columns().iter().zip(values);
        Some(Drawn {
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

fn pictures(study: &Study<'_>, drawn: &[Drawn]) -> Result<Vec<Named>, Error> {
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
    let [all, of_frequency, of_damping] = PICTURES;
    let mut axes: Vec<Axis> = columns.iter().map(of_parameter).collect();
    axes.extend([damping(), frequency()]);
    let (svg, lines) = parallel(&axes)?;
    let mut pictures = vec![(
        all,
        svg,
        format!(
            "Each line is a case ({lines} of {}); its colour is its frequency.",
            drawn.len()
        ),
    )];
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
