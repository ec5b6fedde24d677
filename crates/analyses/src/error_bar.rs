//! The error bar of a mesh: measured in advance on a benchmark, or estimated from the run.

use joint_model::benchmark::MeshAccuracy;
use scenes::{Scene, StructureSource};
use serde::{Deserialize, Serialize};

/// The error bar of a mesh: the largest differences to the limit of the mesh that were measured on one like it, or an estimate from the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorBar {
    /// Relative, of frequencies; `null` where nothing was measured.
    pub frequency_relative: Option<f64>,
    /// Of the logarithm of damping ratios; `null` where nothing was measured.
    pub damping_ln: Option<f64>,
    /// What was measured or estimated, or why there is no figure.
    pub source: String,
    /// Where the mesh errs most in the first mode followed, as far as it was estimated: there it should be finer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub worst: Vec<Place>,
    /// Share of each element of the mesh in the estimated error of the first mode followed; none where it was not estimated. On the best
    /// mesh of a size all are alike.
    #[serde(skip)]
    pub shares: Vec<f64>,
}

/// An element whose strains are among the worst.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Place {
    /// Its number in the order of the mesh, from 1.
    pub element: usize,
    /// Mean of its nodes (m).
    pub at: [f64; 3],
    /// Its share of the estimated error.
    pub share: f64,
}

impl Default for ErrorBar {
    /// Of summaries that were written without one.
    fn default() -> Self {
        Self::unknown("the summary was written without an error bar of the mesh")
    }
}

impl ErrorBar {
    /// From the table of the scene's benchmark, if its mesh is in there.
    pub fn of(scene: &Scene) -> Self {
        Self::measured(scene).unwrap_or_else(Self::unknown)
    }

    /// From the table of the scene's benchmark; if it is not in there, why.
    pub(super) fn measured(scene: &Scene) -> Result<Self, &'static str> {
        let accuracy = accuracy(scene)?;
        let row = accuracy
            .of(scene.element_order(), scene.hexahedra())
            .find(|row| row.refinement == scene.model.refinement);
        let row = row.ok_or("this refinement was not measured with this formulation of the elements")?;
        Ok(Self {
            frequency_relative: Some(row.frequency),
            damping_ln: Some(row.damping),
            source: accuracy.source.to_owned(),
            worst: Vec::new(),
            shares: Vec::new(),
        })
    }

    /// Whether it is estimated from the run, because no table has it.
    pub(super) fn is_estimated(scene: &Scene) -> bool {
        scene.structure.matrices().is_none() && Self::measured(scene).is_err()
    }

    pub(super) fn unknown(reason: &str) -> Self {
        Self {
            frequency_relative: None,
            damping_ln: None,
            source: reason.to_owned(),
            worst: Vec::new(),
            shares: Vec::new(),
        }
    }

    /// One sentence for readers.
    pub fn sentence(&self) -> String {
        match (self.frequency_relative, self.damping_ln) {
            (Some(frequency), Some(damping)) => format!(
                "{:.2} % of frequency and {damping:.3} of the logarithm of damping; {}",
                100.0 * frequency,
                self.source
            ),
            (Some(frequency), None) => format!("{:.2} % of frequency; {}", 100.0 * frequency, self.source),
            _ => format!("not known: {}", self.source),
        }
    }

    /// Where the mesh errs most, for readers; none where it is not known.
    pub fn places(&self) -> Option<String> {
        let place = |place: &Place| {
            let [x, y, z] = place.at.map(|x| 1e3 * x);
            format!("({x:.1}, {y:.1}, {z:.1}) mm {:.1} %", 100.0 * place.share)
        };
        let places: Vec<String> = self.worst.iter().map(place).collect();
        (!places.is_empty()).then(|| places.join(", "))
    }
}

/// What was measured of meshes like the scene's; if nothing was, why.
pub(super) fn accuracy(scene: &Scene) -> Result<MeshAccuracy, &'static str> {
    let accuracy = match &scene.structure.source {
        StructureSource::Benchmark(benchmark) => benchmark.mesh_accuracy(),
        StructureSource::Deck(_) => {
            return Err(
                "the mesh is the deck's own, and no refinements of it were measured; refine the deck, or bracket \
                        the limit with --estimate-error mesh",
            );
        }
        StructureSource::Mesh(_) => {
            return Err(
                "the mesh is the file's own, and no refinements of it were measured; refine it, or bracket the limit with --estimate-error \
                 mesh",
            );
        }
        StructureSource::Matrices(_) => return Err("matrices do not show their mesh"),
    };
    let accuracy = accuracy.ok_or("no refinements of this benchmark were measured")?;
    if scene.model.arm_layers.is_some() {
        return Err("model.arm_layers replaces what the refinement had when it was measured");
    }
    if scene.analyses.modes.followed != [accuracy.mode] {
        return Err("refinements were measured for the first mode alone, and the scene follows another one");
    }
    Ok(accuracy)
}
