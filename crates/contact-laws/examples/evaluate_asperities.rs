//! Evaluates single asperities and friction resolved over asperities along histories given in a file:
//! `evaluate_asperities IN.json OUT.json`. SI units.
//!
//! IN holds any of three parts. OUT is IN with the computed fields put in; it is written whole or not at all.
//!
//! - `normal_asperity`: lists over cases `E, nu, R, Et, Sys` (modulus, Poisson's ratio, radius, tangent modulus, yield
//!   strength; `null` never yields) and, per case, lists over steps `normal_disp, x_disp, y_disp`. Every step sticks from
//!   a state that was committed at the normal displacement before and at no tangential displacement. Computed: `normal_force,
//!   contact_radius, x_force, y_force`.
//! - `element_cycles`: `E, nu, R, Et, Sys, mu`, the bins `gap_values, gap_weights` (m, 1/m^2) and `uxyn`, by case, by
//!   component, by step. One pass with a commit at every step; the yield of the largest normal displacement is committed
//!   before. Each direction slips on its own. Computed: `txyn`.
//! - `mindlin_iwan_asperity`: `E, nu, R, Et, Sys, mu, asp_num_quad_points` and the histories `constant_normal` and
//!   `decreasing_normal` of `x_disp, normal_disp`. A commit at every step. Computed: `x_force, normal_force`.

mod files;

use contact_laws::*;
use serde_json::{Value, json};
use std::fmt;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    files::main("evaluate_asperities", run)
}

/// Reads, evaluates, writes.
pub(crate) fn run(input: &Path, output: &Path) -> Result<(), String> {
    let at = |path: &Path, error: &dyn fmt::Display| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(input).map_err(|error| at(input, &error))?;
    let mut file: Value = serde_json::from_str(&text).map_err(|error| at(input, &error))?;
    evaluate(&mut file).map_err(|defect| at(input, &defect))?;
    files::write_whole(output, &format!("{file:#}\n")).map_err(|error| at(output, &error))
}

/// What is wrong with a part of the file, and where.
enum Defect {
    Field {
        place: String,
        expected: &'static str,
    },
    Law {
        place: String,
        error: Error,
    },
    /// Numbers beyond what can be evaluated.
    NotFinite {
        place: String,
    },
    NoPart,
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field { place, expected } => write!(f, "{place} must be {expected}"),
            Self::Law { place, error } => write!(f, "{place}: {error}"),
            Self::NotFinite { place } => write!(f, "{place}: a displacement is not finite"),
            Self::NoPart => write!(f, "none of {} is there", PARTS.map(|(name, _)| name).join(", ")),
        }
    }
}

type Evaluate = fn(&mut Value, &str) -> Result<(), Defect>;

const PARTS: [(&str, Evaluate); 3] = [
    ("normal_asperity", normal_asperity),
    ("element_cycles", element_cycles),
    ("mindlin_iwan_asperity", mindlin_iwan_asperity),
];

/// Puts the computed fields into all parts that are there.
fn evaluate(file: &mut Value) -> Result<(), Defect> {
    let mut found = false;
    for (name, evaluate) in PARTS {
        if let Some(part) = file.get_mut(name) {
            evaluate(part, name)?;
            found = true;
        }
    }
    if found { Ok(()) } else { Err(Defect::NoPart) }
}

fn normal_asperity(part: &mut Value, place: &str) -> Result<(), Defect> {
    let cases = numbers(part, "E", place)?.len();
    let mut computed = [const { Vec::new() }; 4];
    for case in 0..cases {
        let asperity = asperity(part, place, Some(case))?;
        let [w, x, y] = ["normal_disp", "x_disp", "y_disp"].map(|name| {
            let place = format!("{place}.{name}[{case}]");
            list_of(&part[name][case], &place)
        });
        let (w, x, y) = (w?, x?, y?);
        same_length(&w, &[&x, &y], &format!("{place}.normal_disp[{case}], x_disp, y_disp"))?;
        let bins = law_error(place, AsperityBins::try_new(asperity, vec![0.0], vec![1.0]))?;
        let mut point = Point::new(bins, 1.0, stick_slip(), Cone::Circle, place)?;
        let mut dent = Dent::default();
        let mut of_case = [const { Vec::new() }; 4];
        for ((&w, &x), &y) in w.iter().zip(&x).zip(&y) {
            let [f_x, f_y, f_n] = point.evaluate(Sticking::Full, [x, y, w], place)?;
            point.step(Sticking::Full, [0.0, 0.0, w], place)?;
            let (contact, after) = asperity.contact(w, dent);
            dent = after;
            for (list, value) in of_case.iter_mut().zip([f_n, contact.radius.value, f_x, f_y]) {
                list.push(value);
            }
        }
        for (list, of_case) in computed.iter_mut().zip(of_case) {
            list.push(of_case);
        }
    }
    let names = ["normal_force", "contact_radius", "x_force", "y_force"];
    for (name, values) in names.into_iter().zip(computed) {
        part[name] = json!(values);
    }
    Ok(())
}

fn element_cycles(part: &mut Value, place: &str) -> Result<(), Defect> {
    let asperity = asperity(part, place, None)?;
    let mu = number(part, "mu", place)?;
    let (gaps, densities) = (
        numbers(part, "gap_values", place)?,
        numbers(part, "gap_weights", place)?,
    );
    let bins = law_error(place, AsperityBins::try_new(asperity, gaps, densities))?;
    let cases = part["uxyn"].as_array().cloned().ok_or_else(|| Defect::Field {
        place: format!("{place}.uxyn"),
        expected: "a list of cases",
    })?;
    let mut computed = Vec::new();
    for (case, history) in cases.iter().enumerate() {
        let place = format!("{place}.uxyn[{case}]");
        let [x, y, n] = [0, 1, 2].map(|q| list_of(&history[q], &format!("{place}[{q}]")));
        let (x, y, n) = (x?, y?, n?);
        same_length(&n, &[&x, &y], &place)?;
        let mut point = Point::new(bins.clone(), mu, stick_slip(), Cone::Box, &place)?;
        let deepest = n.iter().copied().fold(0.0, f64::max);
        point.step(Sticking::Coulomb, [0.0, 0.0, deepest], &place)?;
        let mut of_case = [const { Vec::new() }; 3];
        for i in 0..n.len() {
            let t = point.step(Sticking::Coulomb, [x[i], y[i], n[i]], &place)?;
            for (list, t) in of_case.iter_mut().zip(t) {
                list.push(t);
            }
        }
        computed.push(of_case);
    }
    part["txyn"] = json!(computed);
    Ok(())
}

fn mindlin_iwan_asperity(part: &mut Value, place: &str) -> Result<(), Defect> {
    let asperity = asperity(part, place, None)?;
    let mu = number(part, "mu", place)?;
    let n = part["asp_num_quad_points"].as_u64().ok_or_else(|| Defect::Field {
        place: format!("{place}.asp_num_quad_points"),
        expected: "a whole number",
    })?;
    let radii = law_error(place, Radii::equally_spaced(usize::try_from(n).unwrap_or(usize::MAX)))?;
    let bins = law_error(place, AsperityBins::try_new(asperity, vec![0.0], vec![1.0]))?;
    for name in ["constant_normal", "decreasing_normal"] {
        let Some(history) = part.get_mut(name) else {
            continue;
        };
        let place = format!("{place}.{name}");
        let (x, w) = (
            numbers(history, "x_disp", &place)?,
            numbers(history, "normal_disp", &place)?,
        );
        same_length(&w, &[&x], &place)?;
        let friction = AsperityFriction::MindlinIwan(radii.clone());
        let mut point = Point::new(bins.clone(), mu, friction, Cone::Circle, &place)?;
        let steps = x
            .iter()
            .zip(&w)
            .map(|(&x, &w)| point.step(Sticking::Coulomb, [x, 0.0, w], &place));
        let forces: Vec<[f64; 3]> = steps.collect::<Result<_, _>>()?;
        history["x_force"] = json!(forces.iter().map(|f| f[0]).collect::<Vec<_>>());
        // Of a constant displacement once, as in the field that it replaces.
        let once = w.iter().all(|&other| other == w[0]);
        let normal = forces.iter().map(|f| f[2]).take(if once { 1 } else { forces.len() });
        history["normal_force"] = json!(normal.collect::<Vec<_>>());
    }
    Ok(())
}

fn stick_slip() -> AsperityFriction {
    AsperityFriction::StickSlip(HistoryRule::EndPoint)
}

/// A law at one point, with the state committed last.
struct Point {
    law: ResolvedLaw,
    state: Vec<f64>,
    end: Vec<f64>,
}

impl Point {
    fn new(bins: AsperityBins, mu: f64, friction: AsperityFriction, cone: Cone, place: &str) -> Result<Self, Defect> {
        let (bins, mu) = (PointParameters::uniform(bins, 1), PointParameters::uniform(mu, 1));
        let law = law_error(place, ResolvedLaw::try_new(bins, mu, friction, cone))?;
        let state = vec![0.0; law.info().n_state()];
        Ok(Self {
            end: state.clone(),
            law,
            state,
        })
    }

    /// Tractions; nothing is committed.
    fn evaluate(&mut self, sticking: Sticking, u: [f64; 3], place: &str) -> Result<[f64; 3], Defect> {
        let [mut x, mut y, mut n] = [[0.0]; 3];
        let counts = self.law.evaluate(
            0..1,
            sticking,
            Components::new(&u[..1], &u[1..2], &u[2..]),
            StateView::new(&self.state, 1, 0),
            StateViewMut::new(&mut self.end, 1, 0),
            ComponentsMut::new(&mut x, &mut y, &mut n),
            None,
            None,
        );
        match counts.invalid {
            0 => Ok([x[0], y[0], n[0]]),
            _ => Err(Defect::NotFinite { place: place.into() }),
        }
    }

    /// As [`Point::evaluate`], and commits.
    fn step(&mut self, sticking: Sticking, u: [f64; 3], place: &str) -> Result<[f64; 3], Defect> {
        let t = self.evaluate(sticking, u, place)?;
        self.state.copy_from_slice(&self.end);
        Ok(t)
    }
}

fn law_error<T>(place: &str, result: Result<T, Error>) -> Result<T, Defect> {
    result.map_err(|error| Defect::Law {
        place: place.into(),
        error,
    })
}

/// The asperity of a part, or of one of its cases.
fn asperity(part: &Value, place: &str, case: Option<usize>) -> Result<Asperity, Defect> {
    let at = |name: &str| match case {
        None => (&part[name], format!("{place}.{name}")),
        Some(i) => (&part[name][i], format!("{place}.{name}[{i}]")),
    };
    let read = |name: &str| -> Result<Option<f64>, Defect> {
        let (value, place) = at(name);
        match value {
            Value::Null => Ok(None),
            value => value.as_f64().map(Some).ok_or(Defect::Field {
                place,
                expected: "a number",
            }),
        }
    };
    let required = |name: &'static str| {
        read(name)?.ok_or_else(|| Defect::Field {
            place: at(name).1,
            expected: "there",
        })
    };
    let material = ElasticPair::new(required("E")?, required("nu")?);
    let yielding = match read("Sys")? {
        None => None,
        Some(strength) => Some(Yield {
            strength,
            tangent_modulus: required("Et")?,
            curves: YieldCurves::Published,
        }),
    };
    law_error(place, Asperity::try_new(material, required("R")?, yielding))
}

fn number(part: &Value, name: &str, place: &str) -> Result<f64, Defect> {
    part[name].as_f64().ok_or_else(|| Defect::Field {
        place: format!("{place}.{name}"),
        expected: "a number",
    })
}

fn numbers(part: &Value, name: &str, place: &str) -> Result<Vec<f64>, Defect> {
    list_of(&part[name], &format!("{place}.{name}"))
}

fn list_of(value: &Value, place: &str) -> Result<Vec<f64>, Defect> {
    let list = value
        .as_array()
        .and_then(|list| list.iter().map(Value::as_f64).collect());
    list.ok_or_else(|| Defect::Field {
        place: place.into(),
        expected: "a list of numbers",
    })
}

fn same_length(first: &[f64], others: &[&Vec<f64>], place: &str) -> Result<(), Defect> {
    match !first.is_empty() && others.iter().all(|other| other.len() == first.len()) {
        true => Ok(()),
        false => Err(Defect::Field {
            place: place.into(),
            expected: "lists of one length, not empty",
        }),
    }
}
