//! What the paper claims in words.

use super::backbones::{EXTENDED, LARGEST, MUS, SMALLEST, extended, family};
use super::entry::{Entry, Figure, Findings, Picture, Plan, claim};
use super::inputs::Inputs;
use analyses::results::trends;
use anyhow::{Context, Result};
use plotters::prelude::SeriesLabelPosition;
use reports::plot::{BLUE, Curve, Marks, Panel, RED, stack};
use scenes::{Gap, Scene};

pub(super) const CLAIMS: Entry = Entry {
    id: "claims",
    title: "Claims in words around Figs. 17 to 22, and Fig. 20",
    inputs: "Measured statistics and gap of another pair. Prestress at mu = 0.05 to 0.99; backbones of Figs. 19 and 21; prestress \
             with 1, 4, 9 and 25 points per element; one slider at two friction coefficients in closed form (Fig. 20).",
    plan: claims,
};

/// Friction coefficients of the prestress.
const STATIC_MUS: [f64; 4] = [0.05, 0.2, 0.6, 0.99];

/// Displacements between which the bend of the damping curve is judged (m), and where they are divided.
const REGIME: [f64; 3] = [3e-5, 1e-4, 3e-4];

fn claims(inputs: &Inputs) -> Result<Plan<'_>> {
    let mut scenes: Vec<Scene> = STATIC_MUS
        .map(|mu| {
            let mut scene = inputs.prestress(&format!("prestress, mu = {mu}"), Gap::Measured);
            scene.interfaces.mu = mu;
            scene
        })
        .into();
    scenes.extend([1, 2, 3, 5].map(|points| {
        let mut scene = inputs.prestress(&format!("prestress, {} points", points * points), Gap::Measured);
        scene.interfaces.points_per_direction = points;
        scene
    }));
    scenes.extend(MUS.map(|mu| family(inputs, mu)));
    scenes.push(extended(inputs, Gap::Measured));
    let mesh = &inputs.mesh;
    Ok(Plan {
        scenes,
        evaluate: Box::new(move |results| {
            let mut figures = Vec::new();
            let reference = results.of(2)?;
            let (mut pressure_change, mut frequency_change) = (0.0_f64, 0.0_f64);
            let largest = reference.central[2].iter().copied().fold(0.0, f64::max);
            for index in 0..STATIC_MUS.len() {
                let run = results.of(index)?;
                let pairs = run.central[2].iter().zip(&reference.central[2]);
                let change = pairs.fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
                pressure_change = pressure_change.max(change / largest);
                frequency_change = frequency_change.max((run.first() / reference.first() - 1.0).abs());
            }
            figures.push(Figure::new(
                "largest change of pressure for mu 0.05 to 0.99, over the largest pressure",
                None,
                pressure_change,
                "published: little to no appreciable change",
            ));
            figures.push(Figure::new("the same of f1", None, frequency_change, ""));

            let (mut fewest, mut by_points) = (None, 0.0_f64);
            for (k, points) in [1_usize, 4, 9, 25].into_iter().enumerate() {
                let Ok(run) = results.of(STATIC_MUS.len() + k) else {
                    continue;
                };
                fewest.get_or_insert(points);
                by_points = by_points.max((run.first() / reference.first() - 1.0).abs());
                figures.push(Figure::new(
                    format!("f1 with {points} points per element (Hz)"),
                    None,
                    run.first(),
                    "",
                ));
            }

            let backbones = STATIC_MUS.len() + 4;
            let run = |index: usize| results.of(backbones + index);
            let damping = |index: usize| -> Result<Vec<(f64, f64)>> { Ok(run(index)?.curve(|p| p.damping)) };
            // None where damping is below its floor up to the middle of the regime.
            let mut bends: Vec<Option<f64>> = Vec::new();
            for (index, mu) in MUS.into_iter().enumerate() {
                let curve = damping(index)?;
                let [low, middle, high] = REGIME.map(|x| Some((x, trends::at(&curve, x)?)));
                // Or from the first damping above its floor.
                let first = || curve.iter().copied().find(|(x, _)| (REGIME[0]..REGIME[1]).contains(x));
                let slope = |from: Option<(f64, f64)>, to: Option<(f64, f64)>| {
                    let ((x0, z0), (x1, z1)) = (from?, to?);
                    Some((z1 / z0).ln() / (x1 / x0).ln())
                };
                let bend = slope(low.or_else(first), middle).zip(slope(middle, high));
                let bend = bend.map(|(below, above)| above - below);
                bends.push(bend);
                let Some(bend) = bend else { continue };
                figures.push(Figure::new(
                    format!("bend of damping at mu = {mu}: slope above less slope below 1e-4 m (log-log)"),
                    None,
                    bend,
                    "published: concave (negative) below mu = 0.2",
                ));
            }
            // The largest difference of two curves of damping (ln) above the smallest amplitude of the regime.
            let apart = |a: usize, b: usize| -> Result<f64> {
                let (a, b) = (damping(a)?, damping(b)?);
                let common = b.iter().filter(|(x, zeta)| *x > REGIME[0] && *zeta > 0.0);
                let differences = common.filter_map(|(x, zeta)| Some((trends::at(&a, *x)? / zeta).ln().abs()));
                Ok(differences.fold(0.0, f64::max))
            };
            let (near_one, small) = (apart(MUS.len() - 2, MUS.len() - 1)?, apart(0, 2)?);
            figures.push(Figure::new(
                "largest difference of damping above 3e-5 m, mu = 0.75 against 0.99 (ln)",
                None,
                near_one,
                "published: one curve",
            ));
            figures.push(Figure::new(
                "largest difference of damping above 3e-5 m, mu = 0.05 against 0.2 (ln)",
                None,
                small,
                "",
            ));
            let unslipped = run(MUS.len() - 1)?.backbone.iter().filter(|p| p.slip == 0.0);
            let spurious = unslipped.filter_map(|p| p.damping).fold(0.0, f64::max);
            figures.push(Figure::new(
                "largest damping without any slip at the peak, mu = 0.99",
                None,
                spurious,
                "none, if history is followed from vertex to vertex",
            ));

            let long = results.of(backbones + MUS.len())?;
            let peak = super::maps::marked(long)[2];
            let fields = peak
                .and_then(|p| p.fields.as_ref())
                .context("no field at the peak of damping")?;
            let (areas, centres) = (mesh.areas(), super::maps::centres(mesh));
            let mean = |from: f64, to: f64| {
                let inside = (0..areas.len()).filter(|&e| (from..to).contains(&centres[e]));
                let (moved, area) = inside.fold((0.0, 0.0), |(sum, area), e| {
                    (sum + areas[e] * fields.sliding[e], area + areas[e])
                });
                moved / area
            };
            let parts = [mean(-0.06, -0.02), mean(-0.02, 0.02), mean(0.02, 0.06)];
            for (name, value) in ["left", "middle", "right"].into_iter().zip(parts) {
                figures.push(Figure::new(
                    format!("mean relative motion along the beam at point 3, {name} third (m)"),
                    None,
                    value,
                    "published: the ends move apart, the middle stays",
                ));
            }
            let expands = parts[0] * parts[2] < 0.0 && parts[1].abs() < 0.5 * parts[0].abs().min(parts[2].abs());
            let (crossing, svg) = sliders()?;
            figures.push(Figure::new(
                "Fig. 20: amplitude over that of first slip at mu = 0.2, from where mu = 0.6 dissipates more",
                None,
                crossing,
                "closed form",
            ));
            let insensitive = pressure_change < 0.1 && frequency_change < 1e-2;
            let turn = MUS
                .iter()
                .zip(&bends)
                .find(|(_, bend)| bend.is_some_and(|bend| bend >= 0.0))
                .map(|(mu, _)| *mu);
            let bent = bends[0].is_some_and(|bend| bend < 0.0) && turn.is_some_and(|mu| mu <= 0.35);
            let claims = [
                claim(insensitive, "prestress hardly depends on mu"),
                claim(
                    fewest.is_some_and(|n| n > 1),
                    "a number of points per element below which the solver does not converge",
                ),
                claim(bent, "damping bends down at small mu and up from about 0.2 on"),
                claim(near_one < 0.5 * small, "near mu = 1 damping converges to one curve"),
                claim(
                    expands,
                    "at point 3 the ends of the interface move apart while its middle stays",
                ),
            ];
            let turn = turn.map_or_else(|| "at no coefficient".into(), |mu| format!("from mu = {mu} on"));
            let untold = bends.iter().filter(|bend| bend.is_none()).count();
            let fewest = fewest.map_or_else(|| "no number of points".into(), |n: usize| format!("{n} per element"));
            let judgement = format!(
                "Claims: {}. Fewest points that converge: {fewest}; with more f1 changes by at most {:.3} %. Damping bends up {turn}, between {:.0} \
                 um, or where it begins, and {:.0} um, a range that the paper does not print; with {untold} of the coefficients it begins above \
                 {:.0} um. At mu = 0.99 damping reaches {spurious:.1e} before anything slips{}.",
                claims.join("; "),
                100.0 * by_points,
                1e6 * REGIME[0],
                1e6 * REGIME[2],
                1e6 * REGIME[1],
                if spurious > 1e-4 {
                    ": the curves near mu = 1 share what the history rule makes of varying pressure, not friction"
                } else {
                    ""
                },
            );
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![Picture {
                    name: "fig20",
                    svg,
                    caption: "One slider with a low and a high friction coefficient: energy per cycle against amplitude. Between the first slip of \
                              the one and the crossing the low coefficient dissipates more."
                        .into(),
                }],
            })
        }),
    })
}

/// Energy per cycle of one slider at two friction coefficients, in units of `mu t_n d` of the lower one, against the
/// amplitude over its slip limit `d`: where the higher one overtakes, and the picture.
fn sliders() -> Result<(f64, String)> {
    let (low, high) = (0.2, 0.6);
    let ratio: f64 = high / low;
    // D = 4 mu t_n (u - d), d = mu t_n / k.
    let energy = |ratio: f64, u: f64| 4.0 * ratio * (u - ratio).max(0.0);
    let crossing = ratio + 1.0;
    let curve = |mu: f64, colour, dashes| Curve {
        name: format!("mu = {mu}"),
        colour,
        dashes,
        marks: Marks::None,
        points: (0..=120)
            .map(|i| 0.05 * f64::from(i))
            .enumerate()
            .map(|(i, u)| (i, u, energy(mu / low, u)))
            .collect(),
    };
    let panel = Panel {
        y_label: "energy per cycle / (mu t d) [-]",
        log: None,
        legend: SeriesLabelPosition::UpperLeft,
        curves: vec![curve(low, RED, None), curve(high, BLUE, Some((9, 5)))],
    };
    let svg = stack(
        "amplitude over the slip limit of the lower coefficient [-]",
        false,
        vec![panel],
    )?;
    Ok((crossing, svg))
}

/// The range of the families and that of the extended backbones overlap, so that claims may use either.
const _: () = assert!(SMALLEST < REGIME[0] && REGIME[2] < LARGEST && LARGEST < EXTENDED[1]);
