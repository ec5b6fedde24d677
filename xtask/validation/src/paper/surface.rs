//! Entries about the surface itself.

use super::entry::{Entry, Figure, Findings, Picture, Plan};
use super::inputs::{Inputs, per_element, synthetic};
use crate::elements::Representatives;
use analyses::results::trends::histogram;
use anyhow::{Context, Result};
use brake_reuss_beam::published;
use contact_laws::adhesion::{Adhesion, critical_interference};
use contact_laws::{AsperitySumCurves, ContactCurves, ElasticPair, TangentialReading};
use plotters::prelude::SeriesLabelPosition;
use reports::plot::{BLUE, Curve, Marks, Numbers, Panel, RED, power, stack};
use scenes::{Gap, SyntheticScan};
use surface_characterisation::{CorrelationOptions, ElementField, benjamini_hochberg, changes, correlate, p_as89};

pub(super) const FIG_12: Entry = Entry {
    id: "fig12",
    title: "Fig. 12: is adhesion negligible?",
    inputs: "Two synthetic scans on the paper's grid, characterised element by element; hardness 9.47 GPa, intermolecular distance \
             0.4 nm, work of adhesion 2.5 J/m^2 as in the paper. The curves are those of the median element, from the asperity sums.",
    plan: fig_12,
};

/// Classes of the histogram.
const BINS: usize = 24;

fn fig_12(inputs: &Inputs) -> Result<Plan<'_>> {
    Ok(Plan {
        scenes: Vec::new(),
        evaluate: Box::new(|_| {
            let figures_of = published::ADHESION;
            let steel = published::steel();
            let pair = ElasticPair::new(steel.youngs_modulus, steel.poisson_ratio);
            let ratios: Vec<f64> = (inputs.scan()?.found.elements.iter())
                .map(|element| {
                    let radius = element.population.effective_radius();
                    figures_of.intermolecular_distance / critical_interference(&pair, figures_of.hardness, radius)
                })
                .collect();
            let largest = ratios.iter().copied().fold(0.0, f64::max);
            let counts = histogram(&ratios, BINS).context("the scan has no elements")?;
            let width = counts.get(1).map_or(0.0, |c| c.0 - counts[0].0);
            let steps: Vec<(f64, f64)> = counts
                .iter()
                .flat_map(|&(x, n)| [(x, n as f64), (x + width, n as f64)])
                .collect();

            let median = Representatives::try_new(&inputs.scan()?.found.elements)?.median;
            let population = median.population.law_population()?;
            let adhesion = Adhesion::try_new(figures_of.work_of_adhesion, figures_of.intermolecular_distance)?;
            let elastic = AsperitySumCurves::try_new(population.clone(), pair, TangentialReading::Mindlin)?;
            let interferences = (0..=120).map(|i| 1e-9 * 10_f64.powf(f64::from(i) / 28.0));
            let curves: Vec<(f64, f64, f64)> = interferences
                .map(|u| (u, elastic.normal(u).0, adhesion.mean_traction(&population, u)))
                .collect();
            let threshold = curves.iter().rev().find(|(_, e, a)| a > e).map(|(u, ..)| *u);
            let mut figures = vec![Figure::new(
                "largest epsilon over critical interference (published: the bound)",
                figures_of.relative_distance_bound,
                largest,
                "synthetic scans",
            )];
            for u in [1e-6, 3e-6, 5e-6, 1e-5] {
                let ratio = adhesion.mean_traction(&population, u) / elastic.normal(u).0;
                figures.push(Figure::new(
                    format!(
                        "adhesive over elastic traction at {:.0} um (published: the bound)",
                        1e6 * u
                    ),
                    figures_of.traction_ratio_bound,
                    ratio,
                    "synthetic scans",
                ));
            }
            if let Some(threshold) = threshold {
                let name = "interference below which adhesion exceeds the elastic traction (m)";
                figures.push(Figure::new(name, None, threshold, "published: there is one"));
            }
            let at_a_micron = adhesion.mean_traction(&population, 1e-6) / elastic.normal(1e-6).0;
            let judgement = format!(
                "epsilon over the critical interference stays {} the 0.1 % of the paper in all elements (largest {largest:.1e}); at the micron or more \
                 that the paper works at, adhesion is {:.1} % of the elastic traction, {} an order of magnitude less as published.",
                if largest < figures_of.relative_distance_bound {
                    "below"
                } else {
                    "NOT below"
                },
                100.0 * at_a_micron,
                if at_a_micron < figures_of.traction_ratio_bound {
                    "more than"
                } else {
                    "NOT"
                },
            );
            let line = |name: &str, colour, dashes, points: Vec<(f64, f64)>| Curve {
                name: name.to_owned(),
                colour,
                dashes,
                marks: Marks::None,
                points: points.into_iter().enumerate().map(|(i, (x, y))| (i, x, y)).collect(),
            };
            let panel = |y_label, log, curves| Panel {
                y_label,
                log: bool::then_some(log, power as Numbers),
                legend: SeriesLabelPosition::UpperLeft,
                curves,
            };
            let scaled: Vec<(f64, f64)> = steps.into_iter().map(|(x, n)| (1e3 * x, n)).collect();
            let tractions = vec![
                line("elastic", BLUE, None, curves.iter().map(|c| (c.0, c.1)).collect()),
                line(
                    "adhesive",
                    RED,
                    Some((9, 5)),
                    curves.iter().map(|c| (c.0, c.2)).collect(),
                ),
            ];
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![
                    Picture {
                        name: "fig12a",
                        svg: stack(
                            "epsilon over critical interference [1e-3]",
                            false,
                            vec![panel("elements [-]", false, vec![line("", BLUE, None, scaled)])],
                        )?,
                        caption: "Dimensionless intermolecular distance over the elements of the synthetic pair."
                            .into(),
                    },
                    Picture {
                        name: "fig12b",
                        svg: stack("interference [m]", true, vec![panel("traction [Pa]", true, tractions)])?,
                        caption: "Elastic and adhesive traction of the median element.".into(),
                    },
                ],
            })
        }),
    })
}

pub(super) const TABLE_2: Entry = Entry {
    id: "table2",
    title: "Table 2: do changes of the surface go with pressure and dissipation?",
    inputs: "The 24 published p recomputed from the published rho (n = 588, AS 89). The test itself on a synthetic pair scanned twice \
             with another tilt of the faces, so that nothing but the height steps differs: pressure under prestress and flux at two \
             amplitudes, with the gap of another pair and flat, against the changes.",
    plan: table_2,
};

/// Half of the last digit that the paper prints of rho and p.
const PRINTED: f64 = 0.5e-4;

/// Level of significance, as in the paper.
const LEVEL: f64 = 0.05;

fn table_2(inputs: &Inputs) -> Result<Plan<'_>> {
    let scenes = [Gap::Measured, Gap::Flat].map(|gap| {
        let mut scene = per_element(inputs.backbone("flux for Table 2", 2, 1e-6, 1e-4));
        scene.interfaces.gap = gap;
        scene.output.fields_at = Some(vec![1, 2]);
        scene
    });
    Ok(Plan {
        scenes: scenes.into(),
        evaluate: Box::new(move |results| {
            let n = published::INTERFACE_ELEMENTS;
            let (mut outside, mut worst) = (0, 0.0_f64);
            for (rho, p) in published::EVOLUTION_RHO
                .iter()
                .flatten()
                .zip(published::EVOLUTION_P.iter().flatten())
            {
                worst = worst.max((p_as89(*rho, n)? - p).abs());
                let ends = [p_as89(rho.abs() + PRINTED, n)?, p_as89(rho.abs() - PRINTED, n)?];
                if !(ends[0] - PRINTED..=ends[1] + PRINTED).contains(p) {
                    outside += 1;
                }
            }
            let adjusted = benjamini_hochberg(published::EVOLUTION_P.as_flattened());
            let surviving = adjusted.iter().filter(|p| **p <= LEVEL).count();
            let significant = published::EVOLUTION_P.iter().flatten().filter(|p| **p < LEVEL).count();

            // The same faces, tilted otherwise, so that they are rounded to other height steps.
            let again = inputs.scanned(SyntheticScan {
                tilt: [-0.7e-4, 1.3e-4],
                ..synthetic()
            })?;
            let pair = inputs.scan()?;
            let changes = changes(&pair.found, &again.found)?;
            let mut fields = Vec::new();
            for (index, case) in ["", " flat"].into_iter().enumerate() {
                let run = results.of(index)?;
                let field = |name: &str, unit: &str, values: Vec<f64>| ElementField {
                    name: format!("{name}{case}"),
                    unit: unit.to_owned(),
                    values,
                };
                fields.push(field("T_n", "Pa", run.central[2].clone()));
                for (number, point) in run.backbone.iter().enumerate() {
                    let flux = &point.fields.as_ref().context("no flux was stored")?.flux;
                    let total = (0..flux[0].len()).map(|e| flux.iter().map(|f| f[e]).sum()).collect();
                    fields.push(field(&format!("D_{}", number + 1), "J/m^2", total));
                }
            }
            let found = correlate(&changes, &fields, &pair.outlines, CorrelationOptions::default())?.correlations;
            let plain = found.iter().filter(|c| c.p_as89 <= LEVEL).count();
            let kept = found.iter().filter(|c| c.p_adjusted <= LEVEL).count();
            let spatial = found.iter().filter(|c| c.p_spatial.is_some_and(|p| p <= LEVEL)).count();
            let spatial_kept = found
                .iter()
                .filter(|c| c.p_spatial_adjusted.is_some_and(|p| p <= LEVEL))
                .count();
            let null = "synthetic, nothing to be found";
            let mut figures = vec![
                Figure::new(
                    "p outside the rounding of the published rho",
                    0.0,
                    f64::from(outside),
                    "of 24",
                ),
                Figure::new(
                    "largest difference of p from the published rho",
                    0.0,
                    worst,
                    "rho is printed to four digits",
                ),
                Figure::new("significant at 0.05 as published", 6.0, significant as f64, "of 24"),
                Figure::new(
                    "of these after adjustment for 24 tests (Benjamini-Hochberg)",
                    None,
                    surviving as f64,
                    "",
                ),
                Figure::new("rescan: significant at 0.05", None, plain as f64, null),
                Figure::new("rescan: after adjustment", None, kept as f64, null),
                Figure::new("rescan: significant by the spatial test", None, spatial as f64, null),
                Figure::new(
                    "rescan: by the spatial test after adjustment",
                    None,
                    spatial_kept as f64,
                    null,
                ),
            ];
            figures.extend(found.iter().map(|c| {
                Figure::new(
                    format!("rescan: rho of {} with {}", c.change, c.field),
                    None,
                    c.rho,
                    null,
                )
            }));
            let judgement = format!(
                "{} of the 24 published p follow from their rho within rounding; of the {significant} that the paper calls significant {surviving} remain \
                 once 24 tests are allowed for; on scans between which nothing happened {plain} of 24 look significant and {kept} after \
                 adjustment ({spatial_kept} by the test that keeps neighbours alike).",
                24 - outside
            );
            Ok(Findings {
                figures,
                comparable: true,
                judgement,
                pictures: Vec::new(),
            })
        }),
    })
}
