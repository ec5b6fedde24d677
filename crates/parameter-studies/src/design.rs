//! From a plan to the values of every case.

use crate::Error;
use crate::plan::{Design as Kinds, Listed, Parameter, Plan, Spacing};
use analyses::unit_cube;
use scenes::SamplingMethod;
use serde_json::{Number, Value};

/// Most cases of a plan.
const MOST: usize = 10_000_000;

/// Significant digits after the first of values between the ends of a range, so that the same value has the same digits in every plan.
const DIGITS: usize = 11;

/// The values of all cases.
#[derive(Debug)]
pub(crate) struct Design {
    pub(crate) columns: Vec<Column>,
    source: Source,
    pub(crate) number: usize,
}

#[derive(Debug)]
enum Source {
    /// Values of each parameter; the last one varies fastest.
    Grid(Vec<Vec<Value>>),
    /// Values of each case.
    Rows(Vec<Vec<Option<Value>>>),
}

/// A parameter as a column of tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// JSON pointer into the scene.
    pub pointer: String,
    /// How its values are written.
    pub kind: Kind,
}

/// How the values of a column are written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Numbers, in the units of the scene where they have one.
    Number,
    /// Numbers in this unit.
    Quantity(String),
    /// Anything else, as text.
    Text,
}

impl Column {
    /// Its heading: the pointer, and the unit of quantities that name one.
    pub fn heading(&self) -> String {
        match &self.kind {
            Kind::Quantity(unit) => format!("{} [{unit}]", self.pointer),
            Kind::Number | Kind::Text => self.pointer.clone(),
        }
    }

    /// The number of a value, in the unit of the column; none of a column of texts.
    pub(crate) fn number(&self, value: &Value) -> Option<f64> {
        match self.kind {
            Kind::Text => None,
            Kind::Number | Kind::Quantity(_) => amount(value).map(|(number, _)| number),
        }
    }
}

/// A number with its unit, if it has one.
fn amount(value: &Value) -> Option<(f64, Option<&str>)> {
    match value {
        Value::Number(number) => Some((number.as_f64()?, None)),
        Value::String(text) => {
            let text = text.trim();
            let ends = text.char_indices().rev().map(|(at, _)| at);
            let cut = |at: usize| {
                let (number, unit) = text.split_at(at);
                let unit = unit.trim_start();
                let number: f64 = number.trim_end().parse().ok()?;
                (number.is_finite() && !unit.is_empty()).then_some((number, Some(unit)))
            };
            // The longest beginning that is a number: "1e3 N" is no 1 of "e3 N".
            ends.filter(|at| *at > 0).find_map(cut)
        }
        _ => None,
    }
}

/// How the values of a parameter are written.
///
/// # Errors
/// Values in several units, in words.
fn kind<'a>(values: impl Iterator<Item = &'a Value>) -> Result<Kind, String> {
    let mut unit: Option<Option<String>> = None;
    for value in values {
        let Some((_, own)) = amount(value) else {
            return Ok(Kind::Text);
        };
        match &unit {
            None => unit = Some(own.map(str::to_owned)),
            Some(first) if first.as_deref() != own => {
                let named = |unit: Option<&str>| unit.map_or_else(|| "no unit".to_owned(), |unit| format!("`{unit}`"));
                return Err(format!(
                    "its values are in {} and in {}; give all of them in one unit",
                    named(first.as_deref()),
                    named(own)
                ));
            }
            Some(_) => {}
        }
    }
    Ok(unit.flatten().map_or(Kind::Number, Kind::Quantity))
}

/// Where the values of a parameter come from.
enum Axis {
    Values(Vec<Value>),
    Range {
        ends: [f64; 2],
        unit: Option<String>,
        /// Whether both ends are whole numbers, so that whole values are written as such.
        whole: bool,
        spacing: Spacing,
    },
}

impl Axis {
    /// # Errors
    /// In words.
    fn new(parameter: &Parameter) -> Result<Self, String> {
        let Parameter {
            values,
            from,
            to,
            number,
            spacing,
        } = parameter;
        match (values, from, to) {
            (Some(values), None, None) => {
                if values.is_empty() {
                    return Err("`values` is empty; give at least one value".into());
                }
                if number.is_some() || spacing.is_some() {
                    return Err(
                        "`number` and `spacing` belong to a range `from`, `to`, and `values` are given; leave them out"
                            .into(),
                    );
                }
                Ok(Self::Values(values.clone()))
            }
            (None, Some(from), Some(to)) => {
                let end = |name: &str, value: &Value| {
                    amount(value)
                        .map(|(number, unit)| (number, unit.map(str::to_owned)))
                        .ok_or_else(|| {
                            format!("`{name}` = {value} is neither a number nor a text with a unit such as \"10 kN\"")
                        })
                };
                let ((first, unit), (last, other)) = (end("from", from)?, end("to", to)?);
                if unit != other {
                    return Err(format!(
                        "`from` = {from} and `to` = {to} have different units; give both in one unit"
                    ));
                }
                let spacing = spacing.unwrap_or_default();
                if spacing == Spacing::Logarithmic && !(first > 0.0 && last > 0.0) {
                    return Err(format!(
                        "`spacing` is logarithmic from {from} to {to}; both ends must be positive, or the spacing linear"
                    ));
                }
                let is_whole = |value: &Value| value.is_i64() || value.is_u64();
                Ok(Self::Range {
                    ends: [first, last],
                    unit,
                    whole: is_whole(from) && is_whole(to),
                    spacing,
                })
            }
            _ => Err("give either `values`, or `from` and `to`".into()),
        }
    }

    /// The value at a place from 0 to 1.
    fn at(&self, place: f64) -> Value {
        match self {
            Self::Values(values) => {
                let index = (place * values.len() as f64) as usize;
                values.get(index).or(values.last()).cloned().unwrap_or_default()
            }
            &Self::Range {
                ends: [from, to],
                ref unit,
                whole,
                spacing,
            } => {
                let between = match spacing {
                    Spacing::Linear => from + place * (to - from),
                    Spacing::Logarithmic => from * (place * (to / from).ln()).exp(),
                };
                let rounded: f64 = format!("{between:.DIGITS$e}").parse().unwrap_or(between);
                let value = match place {
                    0.0 => from,
                    1.0 => to,
                    _ => rounded,
                };
                match unit {
                    Some(unit) => Value::String(format!("{value} {unit}")),
                    None if whole && value.fract() == 0.0 && value.abs() < 1e15 => Value::from(value as i64),
                    None => Number::from_f64(value).map_or(Value::Null, Value::Number),
                }
            }
        }
    }

    /// Its values in a grid.
    ///
    /// # Errors
    /// In words.
    fn grid(self, number: Option<usize>) -> Result<Vec<Value>, String> {
        match (self, number) {
            (Self::Values(values), _) => Ok(values),
            (Self::Range { .. }, None | Some(0)) => {
                Err("`number` is missing, or zero; say how many values the grid takes, such as \"number\": 10".into())
            }
            (Self::Range { .. }, Some(number)) if number > MOST => Err(format!(
                "`number` = {number} is too large; at most {MOST} cases make a study"
            )),
            (range, Some(1)) => Ok(vec![range.at(0.0)]),
            (range, Some(number)) => {
                let last = (number - 1) as f64;
                Ok((0..number).map(|k| range.at(k as f64 / last)).collect())
            }
        }
    }
}

impl Design {
    /// The cases of a plan, which is called `plan` in messages.
    ///
    /// # Errors
    /// [`Error::Plan`].
    pub(crate) fn new(plan: &Plan, name: &str) -> Result<Self, Error> {
        let refused = |field: &str, reason: String| Error::Plan {
            plan: name.into(),
            field: field.into(),
            reason,
        };
        let of_parameter = |pointer: &str| format!("parameters.{pointer}");
        let (pointers, source) = match &plan.cases {
            Some(cases) => {
                if !plan.parameters.0.is_empty() || plan.design.is_some() {
                    return Err(refused(
                        "cases",
                        "the cases are listed, and `parameters` or `design` are given too; leave one of them out"
                            .into(),
                    ));
                }
                listed(cases)
            }
            None => {
                let given = &plan.parameters.0;
                if given.is_empty() {
                    return Err(refused(
                        "parameters",
                        "nothing varies; give for example \"/mu\": { \"values\": [0.1, 0.2] }, or `cases`".into(),
                    ));
                }
                let axis = |(pointer, parameter): &(String, Parameter)| {
                    Axis::new(parameter).map_err(|reason| refused(&of_parameter(pointer), reason))
                };
                let axes = given.iter().map(axis).collect::<Result<Vec<_>, _>>()?;
                let pointers = given.iter().map(|(pointer, _)| pointer.clone()).collect();
                let sampled = |method, samples: usize, seed| {
                    if let Some((pointer, _)) = given.iter().find(|(_, parameter)| parameter.number.is_some()) {
                        let reason = "`number` belongs to grids, and the design has samples; leave it out";
                        return Err(refused(&of_parameter(pointer), reason.into()));
                    }
                    if samples > MOST {
                        let reason = format!("{samples} samples are too many; at most {MOST} cases make a study");
                        return Err(refused("design", reason));
                    }
                    let cube = unit_cube(method, seed, samples, axes.len());
                    let cube = cube.map_err(|reason| refused("design", reason))?;
                    let row = |point: &Vec<f64>| {
                        let values = axes.iter().zip(point);
                        values.map(|(axis, place)| Some(axis.at(*place))).collect()
                    };
                    Ok(Source::Rows(cube.iter().map(row).collect()))
                };
                let source = match plan.design.unwrap_or_default() {
                    Kinds::LatinHypercube(of) => sampled(SamplingMethod::LatinHypercube, of.samples, of.seed)?,
                    Kinds::Sobol(of) => sampled(SamplingMethod::Sobol, of.samples, of.seed)?,
                    Kinds::Grid => {
                        let values = axes.into_iter().zip(given).map(|(axis, (pointer, parameter))| {
                            let values = axis.grid(parameter.number);
                            values.map_err(|reason| refused(&of_parameter(pointer), reason))
                        });
                        Source::Grid(values.collect::<Result<_, _>>()?)
                    }
                };
                (pointers, source)
            }
        };
        refuse_overlaps(&pointers).map_err(|(pointer, reason)| refused(&of_parameter(pointer), reason))?;
        let number = match &source {
            Source::Rows(rows) => Some(rows.len()),
            Source::Grid(values) => values
                .iter()
                .try_fold(1_usize, |product, values| product.checked_mul(values.len())),
        };
        let number = number.filter(|number| *number <= MOST).ok_or_else(|| {
            let reason = format!("the grid has more than {MOST} cases; take fewer values, or samples");
            refused("parameters", reason)
        })?;
        if number == 0 {
            return Err(refused("cases", "there are none; give at least one".into()));
        }
        let column = |(index, pointer): (usize, &String)| {
            let kind = match &source {
                Source::Grid(values) => kind(values.get(index).into_iter().flatten()),
                Source::Rows(rows) => kind(rows.iter().filter_map(|row| row.get(index)?.as_ref())),
            };
            Ok(Column {
                pointer: pointer.clone(),
                kind: kind.map_err(|reason| refused(&of_parameter(pointer), reason))?,
            })
        };
        Ok(Self {
            columns: pointers.iter().enumerate().map(column).collect::<Result<_, Error>>()?,
            source,
            number,
        })
    }

    /// The values of a case, one per column; none where it keeps what the scene has.
    pub(crate) fn values(&self, case: usize) -> Vec<Option<&Value>> {
        match &self.source {
            Source::Rows(rows) => rows.get(case).into_iter().flatten().map(Option::as_ref).collect(),
            Source::Grid(values) => {
                let mut rest = case;
                let mut row: Vec<Option<&Value>> = Vec::with_capacity(values.len());
                for of_parameter in values.iter().rev() {
                    let n = of_parameter.len().max(1);
                    row.push(of_parameter.get(rest % n));
                    rest /= n;
                }
                row.reverse();
                row
            }
        }
    }

    /// The values of each parameter of a grid; none of other designs.
    pub(crate) fn grid(&self) -> Option<&[Vec<Value>]> {
        match &self.source {
            Source::Grid(values) => Some(values),
            Source::Rows(_) => None,
        }
    }
}

/// All pointers of listed cases in the order in which they first occur, and the values of each case.
fn listed(cases: &[Listed<Value>]) -> (Vec<String>, Source) {
    let mut pointers: Vec<String> = Vec::new();
    for (pointer, _) in cases.iter().flat_map(|case| &case.0) {
        if !pointers.contains(pointer) {
            pointers.push(pointer.clone());
        }
    }
    let row = |case: &Listed<Value>| {
        let value = |pointer: &String| {
            let own = case.0.iter().find(|(name, _)| name == pointer);
            own.map(|(_, value)| value.clone())
        };
        pointers.iter().map(value).collect()
    };
    let rows = cases.iter().map(row).collect();
    (pointers, Source::Rows(rows))
}

/// Refuses what is no pointer, and pointers of which one lies within another.
fn refuse_overlaps(pointers: &[String]) -> Result<(), (&str, String)> {
    for pointer in pointers {
        if !pointer.starts_with('/') {
            let reason =
                "it is no JSON pointer; pointers begin with `/` and have one between names, such as /bolts/load";
            return Err((pointer, reason.into()));
        }
        let within = |other: &&String| {
            let rest = other.strip_prefix(pointer.as_str());
            rest.is_some_and(|rest| rest.starts_with('/'))
        };
        if let Some(other) = pointers.iter().find(within) {
            return Err((pointer, format!("{other} lies within it; leave one of the two out")));
        }
    }
    Ok(())
}

/// Puts a value at a place of a scene, with the blocks above it that are missing.
///
/// # Errors
/// What is there instead, in words.
pub(crate) fn put(scene: &mut Value, pointer: &str, value: Value) -> Result<(), String> {
    let mut place = scene;
    let mut path = String::new();
    for token in pointer.split('/').skip(1) {
        let name = token.replace("~1", "/").replace("~0", "~");
        place = match place {
            Value::Object(fields) => fields
                .entry(name)
                .or_insert_with(|| Value::Object(serde_json::Map::new())),
            Value::Array(list) => {
                let length = list.len();
                let index = name.parse::<usize>().ok().filter(|index| index.to_string() == name);
                index.and_then(|index| list.get_mut(index)).ok_or_else(|| {
                    format!("{path} has {length} elements, counted from 0, and none is `{name}`; correct the pointer")
                })?
            }
            other => {
                return Err(format!(
                    "{path} is {other}, which has no `{name}`; correct the pointer, or give {path} as {{ ... }} in the scene"
                ));
            }
        };
        path += "/";
        path += token;
    }
    *place = value;
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use serde_json::json;

    fn design(plan: &Value) -> Result<Design, String> {
        let plan: Plan = serde_json::from_str(&plan.to_string()).map_err(|error| error.to_string())?;
        Design::new(&plan, "plan.json").map_err(|error| error.to_string())
    }

    fn row(design: &Design, case: usize) -> Vec<Value> {
        design
            .values(case)
            .into_iter()
            .map(|value| value.unwrap().clone())
            .collect()
    }

    #[test]
    fn grids_are_in_order_and_keep_units() {
        // `serde_json::Value` sorts names, so the plan is text.
        let text = r#"{ "scene": "s", "parameters": { "/interfaces/mu": { "from": 0.1, "to": 0.5, "number": 5 },
            "/bolts/load": { "values": ["8 kN", "10 kN"] }, "/interfaces/gap": { "values": ["flat"] },
            "/n": { "from": 4, "to": 16, "number": 4 } } }"#;
        let plan: Plan = serde_json::from_str(text).unwrap();
        let found = Design::new(&plan, "plan.json").unwrap();
        assert_eq!(found.number, 40);
        assert_eq!(row(&found, 0), [json!(0.1), json!("8 kN"), json!("flat"), json!(4)]);
        assert_eq!(row(&found, 1), [json!(0.1), json!("8 kN"), json!("flat"), json!(8)]);
        assert_eq!(row(&found, 4)[1], json!("10 kN"));
        // Not 0.30000000000000004.
        assert_eq!(row(&found, 16)[0], json!(0.3));
        assert_eq!(row(&found, 39), [json!(0.5), json!("10 kN"), json!("flat"), json!(16)]);
        let headings: Vec<String> = found.columns.iter().map(Column::heading).collect();
        assert_eq!(
            headings,
            ["/interfaces/mu", "/bolts/load [kN]", "/interfaces/gap", "/n"]
        );
        assert_eq!(found.columns[1].number(&json!("8 kN")), Some(8.0));
        assert_eq!(amount(&json!("1e3 N m")), Some((1e3, Some("N m"))));
        assert_eq!(amount(&json!("7")), None);
    }

    #[test]
    fn ranges_are_logarithmic_on_request_and_samples_stay_within_them() {
        let found = design(&json!({ "scene": "s", "parameters": {
            "/bolts/load": { "from": "1 kN", "to": "100 kN", "number": 3, "spacing": "logarithmic" } } }))
        .unwrap();
        assert_eq!(
            [0, 1, 2].map(|k| row(&found, k)[0].clone()),
            [json!("1 kN"), json!("10 kN"), json!("100 kN")]
        );
        for method in ["latin-hypercube", "sobol"] {
            let plan = |seed| {
                json!({ "scene": "s", "design": { method: { "samples": 64, "seed": seed } }, "parameters": {
                    "/a": { "from": 0.1, "to": 10.0, "spacing": "logarithmic" }, "/b": { "values": [1, 2, 3, 4] } } })
            };
            let (found, other) = (design(&plan(1)).unwrap(), design(&plan(2)).unwrap());
            assert_eq!(found.number, 64);
            let of = |design: &Design, column: usize| -> Vec<f64> {
                (0..64).map(|k| row(design, k)[column].as_f64().unwrap()).collect()
            };
            let values = of(&found, 0);
            // Half of them lie below the geometric mean.
            assert_eq!(values.iter().filter(|value| **value < 1.0).count(), 32, "{method}");
            assert!(values.iter().all(|value| (0.1..=10.0).contains(value)));
            assert_eq!(of(&found, 1).iter().filter(|value| **value == 3.0).count(), 16);
            assert_ne!(values, of(&other, 0));
        }
    }

    #[test]
    fn what_cannot_be_varied_is_refused_with_its_place_and_a_remedy() {
        let of = |parameters: Value| json!({ "scene": "s", "parameters": parameters });
        for (plan, words) in [
            (of(json!({})), ["parameters", "nothing varies"]),
            (
                of(json!({ "/interfaces/mu": { "values": [] } })),
                ["parameters./interfaces/mu", "at least one"],
            ),
            (
                of(json!({ "/interfaces/mu": { "values": [1], "number": 2 } })),
                ["parameters./interfaces/mu", "leave them out"],
            ),
            (
                of(json!({ "/interfaces/mu": { "from": 1 } })),
                ["parameters./interfaces/mu", "`from` and `to`"],
            ),
            (
                of(json!({ "/interfaces/mu": { "from": 1, "to": 2 } })),
                ["parameters./interfaces/mu", "\"number\": 10"],
            ),
            (
                of(json!({ "/interfaces/mu": { "from": "1 N", "to": "2 kN", "number": 2 } })),
                ["parameters./interfaces/mu", "one unit"],
            ),
            (
                of(json!({ "/interfaces/mu": { "values": ["1 N", "2 kN"] } })),
                ["parameters./interfaces/mu", "one unit"],
            ),
            (
                of(json!({ "/interfaces/mu": { "from": 0, "to": 2, "number": 2, "spacing": "logarithmic" } })),
                ["parameters./interfaces/mu", "positive"],
            ),
            (
                of(json!({ "mu": { "values": [1] } })),
                ["parameters.mu", "begin with `/`"],
            ),
            (
                of(json!({ "/a": { "values": [{}] }, "/a/b": { "values": [1] } })),
                ["parameters./a", "lies within"],
            ),
            (
                of(json!({ "/a": { "from": 1, "to": 2, "number": 99_999_999 } })),
                ["parameters./a", "too large"],
            ),
            (json!({ "scene": "s", "cases": [] }), ["cases", "at least one"]),
            (
                json!({ "scene": "s", "cases": [{ "/a": 1 }], "design": "grid" }),
                ["cases", "leave one of them out"],
            ),
            (
                json!({ "scene": "s", "parametres": {} }),
                ["parametres", "unknown field"],
            ),
            (
                json!({ "scene": "s", "design": { "sobol": { "samples": 100_000, "seed": 1 } }, "parameters": { "/a": { "from": 1, "to": 2 } } }),
                ["design", "latin-hypercube"],
            ),
            (
                json!({ "scene": "s", "design": { "sobol": { "samples": 4, "seed": 1 } }, "parameters": { "/a": { "from": 1, "to": 2, "number": 3 } } }),
                ["parameters./a", "belongs to grids"],
            ),
        ] {
            let message = design(&plan).unwrap_err();
            assert!(words.iter().all(|word| message.contains(word)), "{plan}: {message}");
        }
    }

    #[test]
    fn pointers_follow_rfc_6901_and_make_the_blocks_that_are_missing() {
        let mut scene = json!({ "a/b": { "m~n": 1 }, "list": [1, 2], "interfaces": { "gap": "flat" } });
        put(&mut scene, "/a~1b/m~0n", json!(2)).unwrap();
        put(&mut scene, "/list/1", json!(3)).unwrap();
        put(&mut scene, "/interfaces/scale/gap", json!(0.5)).unwrap();
        assert_eq!(
            scene,
            json!({ "a/b": { "m~n": 2 }, "list": [1, 3], "interfaces": { "gap": "flat", "scale": { "gap": 0.5 } } })
        );
        assert!(put(&mut scene, "/list/2", json!(3)).unwrap_err().contains("2 elements"));
        assert!(put(&mut scene, "/list/01", json!(3)).is_err());
        let message = put(&mut scene, "/interfaces/gap/flat", json!(3)).unwrap_err();
        assert!(
            message.contains("/interfaces/gap is \"flat\"") && message.contains("correct"),
            "{message}"
        );
    }
}
