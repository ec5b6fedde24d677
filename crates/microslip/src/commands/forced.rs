//! `forced`: the response of a scene to harmonic forces, level by level.

use super::run::{Request, conclude};
use super::{Cache, Defaults, Outcome, SceneArguments, Threads, default_directory, scene};
use crate::files::{self, Overwrite};
use analyses::results::summary::{ForcedSummary, ResonanceSummary, Summary};
use anyhow::Result;
use host::{provenance, results_of};
use reports::run::{FORCED, SUMMARY, outputs};
use scenes::{Error, Force, Forced, Method, Scene};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Options of `forced`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The scene [default of the tasks of the workspace: the coarse one of the benchmark]. Its amplitudes are not computed, and of its
    /// methods `epmc` alone.
    #[command(flatten)]
    scene: SceneArguments,
    /// Amplitudes of the force (N), in the place of `forced.levels` of the scene.
    #[arg(long, value_name = "N,N,..", value_delimiter = ',')]
    levels: Option<Vec<f64>>,
    /// First frequency (Hz), in the place of `forced.from_hz`.
    #[arg(long, value_name = "F")]
    from_hz: Option<f64>,
    /// Last frequency (Hz), above or below the first, in the place of `forced.to_hz`.
    #[arg(long, value_name = "F")]
    to_hz: Option<f64>,
    /// Folder for the results, made if missing [default: a folder in results, named like the scene with `-forced`].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    cache: Cache,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    let mut given = match defaults.benchmark {
        Some(benchmark) if !arguments.scene.is_given() => scene::coarse(benchmark)?,
        _ => arguments.scene.read(defaults)?,
    };
    given.scene = arguments.scene_of(given.scene)?;
    let scene = &given.scene;
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}-forced", scene.name))?,
    };
    let names = [SUMMARY, "report.html", FORCED];
    let folder = (arguments.overwrite).open(&directory, &results_of("forced", scene), &names)?;
    arguments.threads.start()?;
    let provenance = provenance::of(given.inputs()?)?;
    let request = Request {
        ensemble: None,
        samples: None,
        estimate_error: None,
    };
    let (run, mut summary) = request.compute(scene, &arguments.cache.options(defaults))?;
    let here = Path::new(&provenance.working_directory);
    provenance.inputs.iter().try_for_each(|input| input.check(here))?;
    summary.provenance = Some(provenance);
    files::publish(folder, &outputs(&run, &summary)?)?;
    run.checkpoints.remove();
    conclude(account(&summary, &scene.name, &directory), scene, &summary)
}

impl Arguments {
    /// The scene with its block `forced` as the arguments have it, without loops and other methods.
    ///
    /// # Errors
    /// [`Error::Syntax`] if neither the scene nor the arguments have all of the block, [`Error::Value`].
    fn scene_of(&self, mut scene: Scene) -> Result<Scene, Error> {
        let levels = self.levels.as_ref();
        let levels = levels.map(|levels| levels.iter().copied().map(Force::from_si).collect::<Vec<_>>());
        scene.forced = Some(match (scene.forced, levels, self.from_hz, self.to_hz) {
            (None, Some(levels), Some(from), Some(to)) => Forced::new(levels, from, to),
            (None, levels, from, to) => {
                let wanted = [
                    ("--levels", levels.is_none()),
                    ("--from-hz", from.is_none()),
                    ("--to-hz", to.is_none()),
                ];
                let missing: Vec<&str> = wanted.iter().filter(|(_, is)| *is).map(|(name, _)| *name).collect();
                return Err(Error::Syntax {
                    place: scene.name,
                    field: Some("forced".into()),
                    message: format!(
                        "the block `forced` is missing; pass {}, or add \"forced\": {{ \"levels\": [1.0], \"from_hz\": 140, \"to_hz\": \
                         190 }} with the forces and frequencies wanted",
                        missing.join(", ")
                    ),
                });
            }
            (Some(block), levels, from, to) => Forced {
                levels: levels.unwrap_or(block.levels),
                from_hz: from.unwrap_or(block.from_hz),
                to_hz: to.unwrap_or(block.to_hz),
                ..block
            },
        });
        scene.cqsma.amplitudes = 0;
        scene.output.fields_at = None;
        scene.methods.retain(|method| *method == Method::Epmc);
        scene.validate(&scene.name)?;
        Ok(scene)
    }
}

/// A resonance as two cells: frequency and amplitude.
fn cells(resonance: Option<&ResonanceSummary>) -> [String; 2] {
    let [f, a] = [
        resonance.and_then(|r| r.frequency_hz),
        resonance.and_then(|r| r.amplitude),
    ];
    [
        f.map_or_else(|| "-".into(), |f| format!("{f:.4}")),
        a.map_or_else(|| "-".into(), |a| format!("{a:.4e}")),
    ]
}

fn percent(value: f64) -> String {
    format!("{:+.2} %", 100.0 * value)
}

/// One line about a level, for the end of a run.
pub(super) fn line(level: &ForcedSummary) -> String {
    let mut out = format!("force {} N: ", level.level);
    for resonance in &level.resonances {
        let [frequency, amplitude] = cells(Some(resonance));
        let _ = write!(out, "resonance {frequency} Hz, {amplitude} m; ");
    }
    if let Some([frequency, amplitude]) = level.peak {
        let _ = write!(out, "peak {amplitude:.4e} m at {frequency:.4} Hz; ");
    }
    if let Some(error) = level.single_mode_error {
        let [frequency, amplitude] = error.map(percent);
        let _ = write!(
            out,
            "nonlinear mode alone {frequency} in frequency, {amplitude} in amplitude; "
        );
    }
    let _ = write!(out, "{}", points(level));
    out
}

/// Number of points, turning points, and why the curve ends early if it does.
fn points(level: &ForcedSummary) -> String {
    let turning = match level.turning_points.len() {
        0 => String::new(),
        n => format!(", {n} turning"),
    };
    let early = level.failure.iter().map(|reason| format!("  ENDS EARLY: {reason}"));
    let unfound = level.resonances.iter().filter_map(|r| r.failure.as_ref());
    let unfound = unfound.map(|reason| format!("  resonance not found: {reason}"));
    let failures: String = early.chain(unfound).collect();
    format!("{} points{turning}{failures}", level.frequency.len())
}

/// What is printed at the end.
fn account(summary: &Summary, name: &str, directory: &Path) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "\n{:>10} {:>15} {:>14} {:>12} {:>14} {:>22}  curve",
        "force [N]", "resonance [Hz]", "amplitude [m]", "peak [Hz]", "peak [m]", "nonlinear mode alone"
    );
    for level in &summary.forced {
        let [frequency, amplitude] = cells(level.resonances.first());
        let peak = level.peak.map(|[f, a]| [format!("{f:.4}"), format!("{a:.4e}")]);
        let [peak_frequency, peak] = peak.unwrap_or_else(|| ["-", "-"].map(String::from));
        let error = level.single_mode_error.map(|error| error.map(percent).join(", "));
        let _ = writeln!(
            out,
            "{:>10} {frequency:>15} {amplitude:>14} {peak_frequency:>12} {peak:>14} {:>22}  {}",
            level.level,
            error.unwrap_or_else(|| "-".into()),
            points(level)
        );
        for resonance in level.resonances.iter().skip(1) {
            let [frequency, amplitude] = cells(Some(resonance));
            let _ = writeln!(out, "{:>10} {frequency:>15} {amplitude:>14}", "");
        }
    }
    let elsewhere = ["node", "terms"]
        .iter()
        .any(|field| !summary.scene["forced"][field].is_null());
    let what = if elsewhere {
        "force: where `forced` says; amplitude"
    } else {
        "force and amplitude"
    };
    let _ = writeln!(
        out,
        "\n{what}: {}; nonlinear mode alone: differences of its peak in frequency and amplitude",
        summary.response
    );
    let mut said: Vec<&str> = summary.forced.iter().map(|level| level.stability.as_str()).collect();
    said.dedup();
    for stability in said {
        let _ = writeln!(out, "stability: {stability}");
    }
    let total = summary.timings.get("total").copied().unwrap_or_default();
    let _ = writeln!(
        out,
        "{name}: {total:.1} s; results, with report.html to begin with, in {}",
        directory.display()
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use host::benchmarks;

    fn arguments(levels: Option<&[f64]>, from_hz: Option<f64>, to_hz: Option<f64>) -> Arguments {
        let mut arguments = parsed();
        arguments.levels = levels.map(<[f64]>::to_vec);
        (arguments.from_hz, arguments.to_hz) = (from_hz, to_hz);
        arguments
    }

    fn parsed() -> Arguments {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            arguments: Arguments,
        }
        <Line as clap::Parser>::parse_from(["forced"]).arguments
    }

    fn scene(more: &str) -> Scene {
        let text = format!(
            r#"{{ "units": {{ "length": "mm", "mass": "t", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
                "methods": ["rqnma", "epmc"], "output": {{ "fields_at": [2] }} {more} }}"#
        );
        benchmarks::read("joint", &text).expect("a scene")
    }

    #[test]
    fn arguments_supply_the_block_or_override_it() {
        let all = arguments(Some(&[1.0, 2.0]), Some(140.0), Some(190.0));
        let without = all.scene_of(scene("")).expect("all is given");
        let expected = Forced::new([1.0, 2.0].map(Force::from_si).to_vec(), 140.0, 190.0);
        assert_eq!(without.forced, Some(expected));
        // Loops, their fields and other methods are left out.
        assert_eq!((without.cqsma.amplitudes, without.fields_at().len()), (0, 0));
        assert_eq!(without.methods, [Method::Epmc]);

        let block = r#", "forced": { "levels": [3.0], "from_hz": 100, "to_hz": 200, "harmonics": 5 }"#;
        let overridden = arguments(None, None, Some(150.0))
            .scene_of(scene(block))
            .expect("a block");
        let expected = Forced {
            harmonics: 5,
            ..Forced::new(vec![Force::from_si(3.0)], 100.0, 150.0)
        };
        assert_eq!(overridden.forced, Some(expected));
    }

    #[test]
    fn what_is_missing_of_the_block_is_named() {
        for (given, named, silent) in [
            (
                arguments(None, None, None),
                &["--levels", "--from-hz", "--to-hz"][..],
                &[][..],
            ),
            (
                arguments(Some(&[1.0]), Some(140.0), None),
                &["--to-hz"],
                &["--levels", "--from-hz"],
            ),
        ] {
            let error = given.scene_of(scene("")).expect_err("not all is given");
            assert!(matches!(error, Error::Syntax { .. }));
            let text = error.to_string();
            assert!(
                text.starts_with("joint: the block `forced` is missing; pass "),
                "{text}"
            );
            assert!(named.iter().all(|flag| text.contains(flag)), "{text}");
            assert!(!silent.iter().any(|flag| text.contains(flag)), "{text}");
        }
        let error = arguments(Some(&[-1.0]), Some(140.0), Some(190.0)).scene_of(scene(""));
        let text = error.expect_err("a negative force").to_string();
        assert!(text.contains("forced.levels = -1 N"), "{text}");
    }
}
