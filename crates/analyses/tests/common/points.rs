//! Scenes on matrices with contact at single nodes, and an independent law of such a contact.

use super::{BENCHMARKS, material};
use analyses::{Error, Run, run};
use faer::Mat;
use joints::Options;
use joints::progress::Silent;
use matrix_files::npz;
use matrix_files::value::{Array, Dense, Dof};
use scenes::Scene;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A folder of the test's own.
pub(crate) fn folder(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("analyses-points-{test}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes matrices over coordinates of which `dofs` has label and component.
pub(crate) fn write(path: &Path, stiffness: &Mat<f64>, mass: &Mat<f64>, dofs: &[(i64, u32)]) {
    let n = dofs.len();
    let dense = |matrix: &Mat<f64>| {
        let entries = (0..n).flat_map(|j| (0..n).map(move |i| matrix[(i, j)]));
        Array::Dense(Dense::try_new(n, n, entries.collect()).unwrap())
    };
    let dofs: Vec<Dof> = dofs
        .iter()
        .map(|&(label, component)| Dof::new(label, component))
        .collect();
    let arrays = [("K", dense(stiffness)), ("M", dense(mass)), ("dofs", Dof::table(&dofs))];
    let arrays = arrays.map(|(name, array)| (name.to_owned(), array)).into();
    std::fs::write(path, npz::to_bytes(&arrays).unwrap()).unwrap();
}

/// A set of parameters of one point.
pub(crate) fn set(stiffness: [f64; 3], mu: f64, preload: f64) -> Value {
    let [x, y, n] = stiffness;
    json!({
        "curves": { "elastic": { "normal_stiffness": n, "tangential_stiffness": [x, y] } },
        "mu": mu,
        "preload": preload,
    })
}

pub(crate) fn scene(path: &Path, nodes: &[u64], sets: &[Value], response: &Value) -> Value {
    let points: Vec<Value> = nodes.iter().map(|node| json!({ "node": node })).collect();
    json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "matrices": {
            "path": path,
            "coordinates": "jump",
            "points": points,
            "response": { "terms": response },
        } },
        "model": { "material": material() },
        "interfaces": { "mu": 0.0, "surface": { "parameters": { "per": "point", "sets": sets } } },
    })
}

pub(crate) fn read(scene: &Value) -> Result<Scene, scenes::Error> {
    Scene::from_json(&scene.to_string(), "the test's scene", "points", &BENCHMARKS)
}

pub(crate) fn try_run(scene: &Value) -> Result<Run, Error> {
    run(&read(scene)?, &Options::default(), &Silent)
}

/// `x` of `a x = b`, by elimination.
pub(crate) fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        b[k] = (b[k] - (k + 1..n).map(|j| a[k][j] * b[j]).sum::<f64>()) / a[k][k];
    }
    b
}

/// A point of the independent computation: its first coordinate, stiffnesses, friction coefficient, preload.
#[derive(Clone, Copy)]
pub(crate) struct Slider {
    pub(crate) first: usize,
    pub(crate) stiffness: [f64; 3],
    pub(crate) mu: f64,
    pub(crate) preload: f64,
}

impl Slider {
    /// Forces after a step from where the point was, with the friction that it had.
    pub(crate) fn force(&self, u: [f64; 3], before: [f64; 3], friction: [f64; 2]) -> [f64; 3] {
        let [_, _, k_n] = self.stiffness;
        let [now, was] = [u, before].map(|u| k_n * u[2] + self.preload);
        if now <= 0.0 {
            return [0.0; 3];
        }
        // Of a point that closes on the way, what is left of it.
        let closed = if was < 0.0 { now / (now - was) } else { 1.0 };
        let trial = [0, 1].map(|i| friction[i] + self.stiffness[i] * closed * (u[i] - before[i]));
        let scale = (self.mu * now / trial[0].hypot(trial[1])).min(1.0);
        [scale * trial[0], scale * trial[1], now]
    }
}
