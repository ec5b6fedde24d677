//! Entries that frequencies and static states are enough for.

use super::entry::{Entry, Figure, Findings, Picture, Plan, claim};
use super::inputs::{Inputs, mesh_error, per_element, uniform};
use crate::elements::{Representatives, given};
use anyhow::{Context, Result, bail};
use brake_reuss_beam::geometry::Geometry;
use brake_reuss_beam::identification::material_of_half_beam;
use brake_reuss_beam::mesh::Refinement;
use brake_reuss_beam::published::{self, BOLT_STRAIN_TABLE, BoltStrainRow, FIRST_FREQUENCY, LINEARISED_FREQUENCIES};
use contact_laws::ElasticPair;
use contact_laws::adhesion::{critical_interference, hardness_coefficient};
use joints::structure::{LinearInterface, Structure};
use plotters::prelude::SeriesLabelPosition;
use reports::plot::{BLUE, Curve, Marks, Panel, RED, stack};
use scenes::{ContactStiffness, Curves, Elastic, Force, Gap, Scene};

/// Standard gravity (m/s^2).
const GRAVITY: f64 = 9.80665;

pub(super) const TABLE_1: Entry = Entry {
    id: "table1",
    title: "Table 1: first frequency about the prestress",
    inputs: "Prestress at mu = 0.6 with 25 points per element. Topography: the measured gap of another pair of the same beam. \
             Roughness per element: two synthetic scans on the paper's grid (30 um x 50 um x 0.5 um) with the paper's fits; \
             uniform: the fit of one of their elements. Measured statistics: one population of asperities of that other pair.",
    plan: table_1,
};

fn table_1(inputs: &Inputs) -> Result<Plan<'_>> {
    let Representatives {
        drawn,
        soft,
        median,
        stiff,
    } = Representatives::try_new(&inputs.scan()?.found.elements)?;
    let cases = [Gap::Measured, Gap::Flat];
    let mut scenes: Vec<Scene> = cases
        .map(|gap| per_element(inputs.prestress("prestress, per element", gap)))
        .into();
    scenes.extend(cases.map(|gap| inputs.prestress("prestress, measured statistics", gap)));
    let error = mesh_error(&scenes[2]);
    scenes.push(uniform(inputs, "prestress, element drawn", drawn));
    scenes.push(uniform(inputs, "prestress, median element", median));
    scenes.push(uniform(inputs, "prestress, soft element", soft));
    scenes.push(uniform(inputs, "prestress, stiff element", stiff));
    Ok(Plan {
        scenes,
        evaluate: Box::new(move |results| {
            let found: Vec<f64> = results.all()?.iter().map(|run| run.first()).collect();
            let [
                topography,
                flat,
                topography_measured,
                flat_measured,
                drawn,
                median,
                soft,
                stiff,
            ] = found[..]
            else {
                bail!("{} of eight cases were run", found.len());
            };
            let table = FIRST_FREQUENCY;
            let (scans, other) = ("synthetic scans", "asperities and gap of another pair");
            let rows = [
                (
                    "topography, per element",
                    table.topography_per_element,
                    topography,
                    "synthetic scans, gap of another pair",
                ),
                ("flat, per element", table.flat_per_element, flat, scans),
                ("flat, uniform: element drawn", table.flat_uniform, drawn, scans),
                ("flat, uniform: median element", table.flat_uniform, median, scans),
                (
                    "flat, uniform: tenth percentile of traction at 5 um",
                    table.flat_uniform,
                    soft,
                    scans,
                ),
                (
                    "flat, uniform: ninetieth percentile of traction at 5 um",
                    table.flat_uniform,
                    stiff,
                    scans,
                ),
                (
                    "topography, measured statistics",
                    table.topography_per_element,
                    topography_measured,
                    other,
                ),
                (
                    "flat, measured statistics",
                    table.flat_per_element,
                    flat_measured,
                    "asperities of another pair",
                ),
                (
                    "topography, measured statistics, against the experiment",
                    table.measured,
                    topography_measured,
                    other,
                ),
            ];
            let figures =
                rows.map(|(name, paper, value, note)| Figure::new(format!("{name} (Hz)"), paper, value, note));
            let ends = [drawn, median, soft, stiff];
            let (least, most) = (
                ends.into_iter().fold(f64::INFINITY, f64::min),
                ends.into_iter().fold(f64::NEG_INFINITY, f64::max),
            );
            let rises = [topography - flat, topography_measured - flat_measured];
            let published = table.topography_per_element - table.flat_per_element;
            let by_chance = table.flat_uniform - table.flat_per_element;
            let judgement = format!(
                "Topography changes the frequency by {:+.1} Hz with scans and {:+.1} Hz with measured statistics, {} as the paper's {published:+.1} Hz; \
                 uniform roughness gives {least:.1} to {most:.1} Hz by four elements of very different stiffness, so the paper's {by_chance:+.1} Hz for one drawn {}; \
                 with measured statistics and gap the experiment is met to {:+.2} % (the paper: {:+.2} %), and the error of the mesh is {error}.",
                rises[0],
                rises[1],
                if rises.iter().all(|rise| *rise * published > 0.0) {
                    "of the same sign"
                } else {
                    "NOT all of the same sign"
                },
                if most - least > by_chance.abs() {
                    "can be chance, as it says"
                } else {
                    "is more than the chance of the draw here"
                },
                100.0 * (topography_measured / table.measured - 1.0),
                100.0 * (table.topography_per_element / table.measured - 1.0),
            );
            Ok(Findings {
                figures: figures.into(),
                comparable: false,
                judgement,
                pictures: Vec::new(),
            })
        }),
    })
}

pub(super) const TABLE_3: Entry = Entry {
    id: "table3",
    title: "Table 3: modes with hard contact, free and on bungee cords",
    inputs: "Contact as a penalty of 1e15 Pa/m along the normal and the faces, friction that always sticks; the elements that the \
             bolt load closes on flat faces stay closed. Modes of the full finite-element model, free and with springs of 30 N/m \
             along each axis at both ends of the beam (the paper: spread over parts of the surface that it shows in a picture). The \
             paper has another mesh and reduced-integration elements.",
    plan: table_3,
};

/// Stiffness of hard contact (Pa/m).
const PENALTY: f64 = 1e15;

fn table_3(inputs: &Inputs) -> Result<Plan<'_>> {
    let scene = |name: &str, mu: f64, along: f64| {
        let mut scene = inputs.scene(name);
        scene.interfaces.mu = mu;
        scene.interfaces.surface = given(vec![Curves::Elastic(Elastic {
            normal_stiffness: ContactStiffness::from_si(PENALTY),
            tangential_stiffness: [ContactStiffness::from_si(along); 2],
        })]);
        scene
    };
    Ok(Plan {
        scenes: vec![
            scene("hard contact that sticks", 1e3, PENALTY),
            scene("hard contact without friction", 0.0, 0.0),
        ],
        evaluate: Box::new(move |results| {
            let sticks = results.of(0)?;
            let slides = results.of(1)?;
            let modes = LINEARISED_FREQUENCIES.len();
            let closed: Vec<bool> = sticks.central[2].iter().map(|p| *p > 0.0).collect();
            let contact = LinearInterface {
                normal_stiffness: PENALTY,
                tangential_stiffness: PENALTY,
                points_per_direction: 2,
            };
            let [free, hung] = inputs.kept(&(contact, &closed, modes), || {
                let free = &inputs.structure;
                let hung = free
                    .hung(published::PENDULUM_STIFFNESS)
                    .context("only a mesh can be hung")?;
                let spectrum = |structure: &Structure| structure.frequencies(contact, |e| closed[e], modes);
                Ok([spectrum(free)?.frequencies_hz, spectrum(&hung)?.frequencies_hz])
            })?;
            let note = "another mesh";
            let mut figures = Vec::new();
            let (mut worst, mut against, mut shift) = (0.0_f64, 0.0_f64, 0.0_f64);
            for (mode, paper) in LINEARISED_FREQUENCIES.into_iter().enumerate() {
                let (Some(&free), Some(&hung)) = (free.get(mode), hung.get(mode)) else {
                    bail!("mode {} was not found", mode + 1);
                };
                let number = mode + 1;
                figures.push(Figure::new(format!("mode {number}, free (Hz)"), paper, free, note));
                figures.push(Figure::new(format!("mode {number}, on cords (Hz)"), paper, hung, note));
                let name = format!("shift of mode {number} by the cords (Hz)");
                figures.push(Figure::new(name, 0.0, hung - free, "the paper prints two decimals"));
                worst = worst.max((free / paper - 1.0).abs());
                against = against.max((free / published::HARD_CONTACT_FREQUENCIES[mode] - 1.0).abs());
                shift = shift.max((hung - free).abs());
            }
            figures.extend([
                Figure::new(
                    "area closed by the bolts",
                    published::HARD_CONTACT_AREA,
                    sticks.contact[2],
                    "published: an independent finite-element model",
                ),
                Figure::new(
                    "mode 1, free, by the reduced model about the prestress (Hz)",
                    LINEARISED_FREQUENCIES[0],
                    sticks.first(),
                    note,
                ),
                Figure::new("mode 1 without friction (Hz)", None, slides.first(), ""),
            ]);
            let offset = FIRST_FREQUENCY.measured - FIRST_FREQUENCY.topography_per_element;
            let judgement = format!(
                "The ten modes differ from the published ones by at most {:.1} %, from an independent emulation of hard contact by at most {:.1} %: \
                 mesh, elements and perhaps the material are others. The cords shift the modes by at most {shift:.4} Hz, {}; they {} explain the paper's offset of {offset:.1} Hz \
                 from the experiment.",
                100.0 * worst,
                100.0 * against,
                if shift < 0.005 {
                    "nothing in the two decimals printed, as published"
                } else {
                    "which would show in the two decimals printed, where the paper sees nothing"
                },
                if shift < 0.1 * offset {
                    "do NOT, as it concludes,"
                } else {
                    "would help to"
                },
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

pub(super) const TABLE_4: Entry = Entry {
    id: "table4",
    title: "Table 4 and Fig. 24: first frequency and contact area against bolt strain",
    inputs: "Bolt loads by eq. (46) at nine strains, mu = 0.6, 25 points per element, measured statistics of another pair, with its \
             measured gap and flat. Area by whole elements, an element counting if its centre is in contact, as in the paper.",
    plan: table_4,
};

fn table_4(inputs: &Inputs) -> Result<Plan<'_>> {
    let mesh = &inputs.mesh;
    let scene = |row: &BoltStrainRow, gap| {
        let microstrain = 1e6 * row.bolt_strain;
        let mut scene = inputs.prestress(&format!("bolt strain {microstrain:.0} um/m"), gap);
        scene.bolts.load = Force::from_si(published::bolt_tension(row.bolt_strain));
        scene
    };
    let rows = BOLT_STRAIN_TABLE.iter();
    Ok(Plan {
        scenes: rows
            .flat_map(|row| [Gap::Measured, Gap::Flat].map(|gap| scene(row, gap)))
            .collect(),
        evaluate: Box::new(move |results| {
            let runs = results.all()?;
            let mut figures = Vec::new();
            let mut curves: [Vec<[f64; 6]>; 2] = Default::default();
            for (row, pair) in BOLT_STRAIN_TABLE.iter().zip(runs.chunks_exact(2)) {
                let at = format!("at {:.0} um/m", 1e6 * row.bolt_strain);
                let load = published::bolt_tension(row.bolt_strain);
                let cases = [
                    (
                        "topography",
                        row.topography_frequency,
                        row.topography_contact,
                        "asperities and gap of another pair",
                    ),
                    (
                        "flat",
                        row.flat_frequency,
                        row.flat_contact,
                        "asperities of another pair",
                    ),
                ];
                for (k, ((case, frequency, contact, note), run)) in cases.into_iter().zip(pair).enumerate() {
                    let area = run.contact[2];
                    figures.push(Figure::new(
                        format!("f1, {case}, {at} (Hz)"),
                        frequency,
                        run.first(),
                        note,
                    ));
                    figures.push(Figure::new(format!("contact area, {case}, {at}"), contact, area, note));
                    let name = format!("area with more than 1 % of the mean pressure, {case}, {at}");
                    let loaded = super::maps::loaded_part(mesh, run);
                    figures.push(Figure::new(name, None, loaded, note));
                    curves[k].push([load, run.first(), frequency, area, contact, loaded]);
                }
            }
            let pick = |case: usize, column: usize| {
                let rows = curves[case].iter().enumerate();
                rows.map(|(i, row)| (i, 1e-3 * row[0], row[column])).collect::<Vec<_>>()
            };
            let panel = |y_label, [ours, theirs]: [usize; 2], named: bool| Panel {
                y_label,
                log: None,
                legend: SeriesLabelPosition::LowerRight,
                curves: [("topography", BLUE), ("flat", RED)]
                    .into_iter()
                    .enumerate()
                    .flat_map(|(case, (name, colour))| {
                        let label = |what: &str| {
                            if named {
                                format!("{name}, {what}")
                            } else {
                                String::new()
                            }
                        };
                        [
                            Curve {
                                name: label("here"),
                                colour,
                                dashes: None,
                                marks: Marks::Dots,
                                points: pick(case, ours),
                            },
                            Curve {
                                name: label("published"),
                                colour,
                                dashes: Some((6, 4)),
                                marks: Marks::None,
                                points: pick(case, theirs),
                            },
                        ]
                    })
                    .collect(),
            };
            let svg = stack(
                "load of each bolt [kN]",
                false,
                vec![
                    panel("f1 [Hz]", [1, 2], false),
                    panel("area in contact [-]", [3, 4], true),
                ],
            )?;
            let grows = |case: usize, column: usize| curves[case].windows(2).all(|w| w[1][column] >= w[0][column]);
            let change = |case: usize, column: usize| {
                let ends = [curves[case].first(), curves[case].last()].map(|row| row.map_or(f64::NAN, |r| r[column]));
                ends[1] - ends[0]
            };
            // Table 4's columns of topography lie below those of flat faces at every strain.
            let smaller = |column: usize| curves[0].iter().zip(&curves[1]).all(|(a, b)| a[column] < b[column]);
            let touching = curves[0].iter().all(|row| row[3] > row[4]);
            let end = |case: usize, last: bool, column: usize| {
                let row = if last {
                    curves[case].last()
                } else {
                    curves[case].first()
                };
                row.map_or(f64::NAN, |row| row[column])
            };
            let claims = [
                claim(smaller(5), "less of the area loaded with topography at every strain"),
                claim(grows(0, 5) && grows(1, 5), "loaded area grows with load"),
                claim(
                    grows(1, 1),
                    "flat frequency rises with every step (the printed column does not)",
                ),
                claim(!grows(0, 1), "frequency with topography not monotonic"),
            ];
            let judgement = format!(
                "{} ({:.0} % with topography at the lowest load, published {:.0} %; more than 1 % of the mean pressure is on {:.0} %, at the highest load \
                 {:.0} %; its gap is another, see fig17). From the lowest load to the highest the frequency changes by {:+.2} Hz flat (published {:+.2}) and {:+.2} Hz with topography \
                 ({:+.2}). Claims: {}.",
                if touching {
                    "More of this surface touches than of the paper's at every strain"
                } else {
                    "The area in contact is not always larger than the published one"
                },
                100.0 * end(0, false, 3),
                100.0 * end(0, false, 4),
                100.0 * end(0, false, 5),
                100.0 * end(0, true, 5),
                change(1, 1),
                change(1, 2),
                change(0, 1),
                change(0, 2),
                claims.join("; "),
            );
            Ok(Findings {
                figures,
                comparable: false,
                judgement,
                pictures: vec![Picture {
                    name: "fig24",
                    svg,
                    caption: "First frequency and area in contact against bolt load: here (solid) and published (dashed), with topography \
                              and flat; the surfaces are not the same."
                        .into(),
                }],
            })
        }),
    })
}

pub(super) const NUMBERS: Entry = Entry {
    id: "numbers",
    title: "Equations (46) and (48), K, E*, critical interference, and E and rho of a half-beam (section 4.1)",
    inputs: "Formulas of the paper with its numbers: eq. (46) (bolt load from strain), K and E* and the critical interference of eq. (45), eq. (48) (pendulum stiffness of a cord). Effective radius: that of another measured pair. The half-beam is identified \
             from mass and first frequency of an independent finite-element half-beam (its modulus and density being the \
             paper's), since the paper prints neither.",
    plan: numbers,
};

fn numbers(_: &Inputs) -> Result<Plan<'_>> {
    Ok(Plan {
        scenes: Vec::new(),
        evaluate: Box::new(|_| {
            let steel = published::steel();
            let pair = ElasticPair::new(steel.youngs_modulus, steel.poisson_ratio);
            let adhesion = published::ADHESION;
            let onset = critical_interference(&pair, adhesion.hardness, published::EFFECTIVE_RADIUS);
            let found = material_of_half_beam(
                &Geometry::default(),
                &Refinement::default(),
                steel.poisson_ratio,
                published::HALF_BEAM_MASS,
                published::HALF_BEAM_FREQUENCIES[0],
            )?;
            let (torque_load, torque_strain) = published::TORQUE_BOLT_TENSION;
            let cord = published::pendulum_stiffness(published::PAPER_MASS, published::CORD_LENGTH, GRAVITY);
            let ratio = adhesion.intermolecular_distance / onset;
            // By how much the figures that are printed may be off: half of their last digit, carried through where they are inputs.
            let strain_digit = published::bolt_tension(0.5e-6);
            let printed = [
                (
                    "K",
                    adhesion.hardness_coefficient,
                    hardness_coefficient(steel.poisson_ratio),
                    0.5e-4,
                ),
                ("E*", adhesion.composite_modulus, pair.composite_modulus(), 0.5e7),
                (
                    "the load at 1847 um/m",
                    torque_load,
                    published::bolt_tension(torque_strain),
                    strain_digit,
                ),
                (
                    "the load at 2050 um/m",
                    published::BOLT_TENSION,
                    published::bolt_tension(published::BOLT_STRAIN),
                    strain_digit,
                ),
                ("the stiffness of a cord", published::PENDULUM_STIFFNESS, cord, 0.5),
            ];
            let agree = |wanted: bool| {
                let named = printed
                    .iter()
                    .filter(|(_, paper, here, slack)| ((paper - here).abs() <= *slack) == wanted);
                named.map(|(name, ..)| *name).collect::<Vec<_>>()
            };
            let (met, missed) = (agree(true), agree(false));
            let list = |names: &[&str]| match names {
                [] => "none".to_owned(),
                names => names.join(", "),
            };
            let judgement = format!(
                "Met within the rounding of what is printed: {}; not met: {} ({:+.0} N at 2050 um/m). epsilon over the critical interference is \
                 {ratio:.1e}, {} the published bound. The half-beam gives back the modulus behind the data to {:+.2} % and its density to {:+.2} %.",
                list(&met),
                list(&missed),
                published::bolt_tension(published::BOLT_STRAIN) - published::BOLT_TENSION,
                if ratio < adhesion.relative_distance_bound {
                    "below"
                } else {
                    "NOT below"
                },
                100.0 * (found.youngs_modulus / steel.youngs_modulus - 1.0),
                100.0 * (found.density / steel.density - 1.0),
            );
            let other = "radius of another pair";
            let model = "from an independent model, not from the experiment";
            Ok(Findings {
                figures: vec![
                    Figure::new(
                        "bolt load at 2050 um/m, eq. (46) (N)",
                        published::BOLT_TENSION,
                        published::bolt_tension(published::BOLT_STRAIN),
                        "the paper's strain is a rounded mean",
                    ),
                    Figure::new(
                        "bolt load at 1847 um/m, eq. (46) (N)",
                        torque_load,
                        published::bolt_tension(torque_strain),
                        "",
                    ),
                    Figure::new(
                        "hardness coefficient K",
                        adhesion.hardness_coefficient,
                        hardness_coefficient(steel.poisson_ratio),
                        "",
                    ),
                    Figure::new("E* (Pa)", adhesion.composite_modulus, pair.composite_modulus(), ""),
                    Figure::new("critical interference, eq. (45) (m)", None, onset, other),
                    Figure::new(
                        "epsilon over critical interference (published: the bound)",
                        adhesion.relative_distance_bound,
                        ratio,
                        other,
                    ),
                    Figure::new(
                        "stiffness of a cord, eq. (48) (N/m)",
                        published::PENDULUM_STIFFNESS,
                        cord,
                        "published rounded",
                    ),
                    Figure::new("density of the half-beam (kg/m^3)", steel.density, found.density, model),
                    Figure::new(
                        "Young's modulus of the half-beam (Pa)",
                        steel.youngs_modulus,
                        found.youngs_modulus,
                        model,
                    ),
                ],
                comparable: true,
                judgement,
                pictures: Vec::new(),
            })
        }),
    })
}
