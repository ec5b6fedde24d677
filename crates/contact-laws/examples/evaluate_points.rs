//! Evaluates the fitted law with the published history rule at points given in a file:
//! `evaluate_points IN.json OUT.json`.
//!
//! IN holds lists over the points: `u` (jump x, y, n before the gap is subtracted, m), `prev` (jump x, y, n and
//! traction x, y, n of the state committed last), `mu`, `Zn` (gap, m), and the parameters of eq. (28) `N: {a, b, c,
//! d, e}` and of eq. (29) `Tx, Ty: {a, b, c, d}` with natural logarithms of metres. OUT holds the tractions `t` (x,
//! y, n; Pa) and the tangent `J` (xx, xy, xn, yx, yy, yn, nn; Pa/m) of every point. It is written whole or not at
//! all.

mod files;

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use contact_laws::*;
use serde_json::{Value, json};

fn main() -> ExitCode {
    files::main("evaluate_points", run)
}

/// Reads, evaluates, writes.
pub(crate) fn run(input: &Path, output: &Path) -> Result<(), Failure> {
    let failed = |defect| Failure {
        file: input.into(),
        defect,
    };
    let text = fs::read_to_string(input).map_err(|error| failed(Defect::Io(error)))?;
    let value = serde_json::from_str(&text).map_err(|error| failed(Defect::Json(error)))?;
    let answer = Points::read(&value).and_then(Points::evaluate).map_err(failed)?;
    files::write_whole(output, &answer.to_string()).map_err(|error| Failure {
        file: output.into(),
        defect: Defect::Io(error),
    })
}

/// What is wrong with a file.
#[derive(Debug)]
pub(crate) struct Failure {
    file: PathBuf,
    defect: Defect,
}

#[derive(Debug)]
enum Defect {
    Io(io::Error),
    Json(serde_json::Error),
    /// A field is absent.
    Missing(String),
    /// A field or entry is not what it should be.
    Kind {
        place: String,
        expected: &'static str,
    },
    /// A list has another length than it should have.
    Length {
        place: String,
        expected: usize,
        found: usize,
    },
    /// The parameters of a point make no law.
    Curves {
        point: usize,
        error: Error,
    },
    Law(Error),
    /// `u_n` or `prev` minus the gap is beyond the range of numbers.
    NotFinite {
        point: usize,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file.display())?;
        match &self.defect {
            Defect::Io(error) => error.fmt(f),
            Defect::Json(error) => error.fmt(f),
            Defect::Missing(field) => write!(f, "the field {field} is missing"),
            Defect::Kind { place, expected } => write!(f, "{place} is not {expected}"),
            Defect::Length { place, expected, found } => {
                write!(f, "{place} has {found} entries where {expected} are needed")
            }
            Defect::Curves { point, error } => write!(f, "N, Tx, Ty of point {point}: {error}"),
            Defect::Law(error) => error.fmt(f),
            Defect::NotFinite { point } => write!(f, "u or prev minus Zn of point {point} is not finite"),
        }
    }
}

/// The points of a file, component by component.
struct Points {
    jump: [Vec<f64>; 3],
    /// As `prev` in the file; the normal traction is not part of the law's state.
    begin: [Vec<f64>; 6],
    mu: Vec<f64>,
    curves: Vec<FittedCurves>,
}

impl Points {
    fn read(file: &Value) -> Result<Self, Defect> {
        let n = list(file, "u")?.len();
        let (mut jump, mut begin): ([_; 3], [_; 6]) = (vectors(file, "u", n)?, vectors(file, "prev", n)?);
        let mu = numbers(file, "mu", n)?;
        let gap = numbers(file, "Zn", n)?;
        for u_n in [&mut jump[2], &mut begin[2]] {
            u_n.iter_mut().zip(&gap).for_each(|(u_n, gap)| *u_n -= gap);
        }
        let normal = fields(file, "N", ["a", "b", "c", "d", "e"], n)?;
        let [x, y]: [[_; 4]; 2] = [
            fields(file, "Tx", ["a", "b", "c", "d"], n)?,
            fields(file, "Ty", ["a", "b", "c", "d"], n)?,
        ];
        let curves = (0..n).map(|i| {
            let [a, b, c, d, e] = normal.each_ref().map(|list| list[i]);
            let (u_ref, range) = (1.0, None);
            let normal = NormalFit {
                a,
                b,
                c,
                d,
                e,
                u_ref,
                t_ref: 1.0,
                range,
            };
            let tangential = [&x, &y].map(|fit| TangentialFit {
                a: fit[0][i],
                b: fit[1][i],
                c: fit[2][i],
                d: fit[3][i],
                u_ref,
                k_ref: 1.0,
                range,
                ends: TangentialEnds::Constant,
            });
            FittedCurves::try_new(normal, tangential).map_err(|error| Defect::Curves { point: i, error })
        });
        Ok(Self {
            curves: curves.collect::<Result<_, _>>()?,
            jump,
            begin,
            mu,
        })
    }

    /// All points in one batch.
    fn evaluate(self) -> Result<Value, Defect> {
        let n = self.mu.len();
        let (curves, mu) = (
            PointParameters::per_point(self.curves),
            PointParameters::per_point(self.mu),
        );
        let law = RoughLaw::try_new(FittedPoints::new(&curves), mu, HistoryRule::Paper).map_err(Defect::Law)?;

        let [u_x, u_y, u_n] = &self.jump;
        let begin = self.begin[..5].concat();
        let mut end = vec![0.0; begin.len()];
        let mut t: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; n]);
        let mut tangent: [Vec<f64>; 9] = std::array::from_fn(|_| vec![0.0; n]);
        let mut regimes = vec![Regime::Open; n];
        let [t_x, t_y, t_n] = &mut t;
        law.evaluate(
            0..n,
            Sticking::Coulomb,
            Components::new(u_x, u_y, u_n),
            StateView::new(&begin, n, 0),
            StateViewMut::new(&mut end, n, 0),
            ComponentsMut::new(t_x, t_y, t_n),
            Some(TangentMut::from_entries(tangent.each_mut().map(Vec::as_mut_slice))),
            Some(&mut regimes),
        );
        if let Some(point) = regimes.iter().position(|&regime| regime == Regime::Invalid) {
            return Err(Defect::NotFinite { point });
        }
        let [xx, xy, xn, yx, yy, yn, _, _, nn] = tangent;
        Ok(json!({ "t": by_point(&t, n), "J": by_point(&[xx, xy, xn, yx, yy, yn, nn], n) }))
    }
}

fn by_point(components: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    (0..n)
        .map(|i| components.iter().map(|list| list[i]).collect())
        .collect()
}

fn field<'a>(object: &'a Value, field: &str, place: &str) -> Result<&'a Value, Defect> {
    object.get(field).ok_or_else(|| Defect::Missing(place.into()))
}

fn list<'a>(file: &'a Value, name: &str) -> Result<&'a Vec<Value>, Defect> {
    as_list(field(file, name, name)?, name)
}

fn as_list<'a>(value: &'a Value, place: &str) -> Result<&'a Vec<Value>, Defect> {
    value.as_array().ok_or_else(|| Defect::Kind {
        place: place.into(),
        expected: "a list",
    })
}

fn require_length(list: &[Value], expected: usize, place: &str) -> Result<(), Defect> {
    if list.len() == expected {
        return Ok(());
    }
    Err(Defect::Length {
        place: place.into(),
        expected,
        found: list.len(),
    })
}

fn number(value: &Value, place: impl FnOnce() -> String) -> Result<f64, Defect> {
    value.as_f64().ok_or_else(|| Defect::Kind {
        place: place(),
        expected: "a number",
    })
}

fn numbers_of(list: &[Value], place: &str, n: usize) -> Result<Vec<f64>, Defect> {
    require_length(list, n, place)?;
    let entries = list.iter().enumerate();
    entries
        .map(|(i, v)| number(v, || format!("{place} of point {i}")))
        .collect()
}

/// One number per point.
fn numbers(file: &Value, name: &str, n: usize) -> Result<Vec<f64>, Defect> {
    numbers_of(list(file, name)?, name, n)
}

/// One number per point in each of the fields of an object.
fn fields<const M: usize>(file: &Value, name: &str, names: [&str; M], n: usize) -> Result<[Vec<f64>; M], Defect> {
    let object = field(file, name, name)?;
    let mut found = [const { Vec::new() }; M];
    for (found, inner) in found.iter_mut().zip(names) {
        let place = format!("{name}.{inner}");
        *found = numbers_of(as_list(field(object, inner, &place)?, &place)?, &place, n)?;
    }
    Ok(found)
}

/// `M` numbers per point, by component.
fn vectors<const M: usize>(file: &Value, name: &str, n: usize) -> Result<[Vec<f64>; M], Defect> {
    let points = list(file, name)?;
    require_length(points, n, name)?;
    let mut found = [const { Vec::new() }; M];
    for (i, point) in points.iter().enumerate() {
        let place = format!("{name} of point {i}");
        let point = as_list(point, &place)?;
        require_length(point, M, &place)?;
        for (c, (found, value)) in found.iter_mut().zip(point).enumerate() {
            found.push(number(value, || format!("{place}, entry {c},"))?);
        }
    }
    Ok(found)
}
