//! One self-contained page about a run.

use crate::analysis::Section;
use crate::answer::{self, Shown};
use crate::errors::{adaptation, errors};
use crate::fields::Placed;
use crate::html::{MISSING, Picture, Table, render};
use crate::interactive::{Document, Live};
use crate::phrases::{damping, tensions};
use crate::{Error, fields, map, plot, styles};
use analyses::mesh_error::{FrequencyEstimate, ModeEstimate};
use analyses::results::summary::{BackboneSummary, MethodSummary, Status, Summary};
use analyses::results::work::Work;
use analyses::warnings::Warning;
use analyses::{ModeBackbone, Run};
use askama::Template;
use joints::interface::AsperityReport;
use joints::structure::{Overview, choice_name};
use scenes::Scene;

/// Names with values.
type Facts = Vec<(String, String)>;

#[derive(Template)]
#[template(path = "run.html")]
struct Page<'a> {
    title: &'a str,
    answer: Vec<Shown>,
    introduction: String,
    warnings: &'a [Warning],
    overview: Vec<String>,
    modes: Vec<Mode<'a>>,
    sections: Vec<Section>,
    /// None of points of contact, which cover nothing that could be drawn.
    pressure: Option<Picture<'a>>,
    key_numbers: Facts,
    accuracy: Facts,
    mesh_estimates: Vec<(String, Table)>,
    asperities: Option<Facts>,
    skipped: Vec<&'a str>,
    effort: Facts,
    /// With all defaults, as JSON.
    scene: String,
    live: Live,
}

/// What the page says of one mode.
struct Mode<'a> {
    /// None where only one mode is followed.
    heading: Option<String>,
    failed: usize,
    amplitudes: usize,
    backbone: Picture<'a>,
    maps: Vec<Picture<'a>>,
    amplitude_table: Table,
    methods: Option<Table>,
    validity: Vec<String>,
}

/// The page; `pictures` are those of the backbones of the modes followed.
///
/// # Errors
/// [`Error::Page`], [`Error::Table`], [`Error::Summary`].
pub(crate) fn document(
    run: &Run,
    summary: &Summary,
    pictures: &[String],
    sections: Vec<Section>,
) -> Result<String, Error> {
    let modes: Vec<String> = run.backbones.iter().map(|of| of.mode.to_string()).collect();
    let of_modes = run.backbones.iter().zip(summary.by_mode()).zip(pictures);
    render(&Page {
        title: &run.scene.name,
        answer: answer::shown(summary),
        introduction: format!(
            "{}: frequency and damping of mode {} against amplitude. Surface: {}; gap: {}; friction \
             coefficient {}; {}.",
            summary.title,
            modes.join(", "),
            choice_name(&run.scene.interfaces.surface),
            choice_name(&run.scene.interfaces.gap),
            run.scene.interfaces.mu,
            match run.model.reduced.loads.len() {
                0 => "no bolts".to_owned(),
                bolts => format!("{bolts} bolts with {}", tensions(run)),
            },
        ),
        warnings: &summary.warnings,
        overview: overview(summary),
        modes: of_modes
            .map(|((backbone, (_, of_mode)), picture)| mode(run, backbone, &of_mode, picture))
            .collect(),
        sections,
        pressure: pressure(run),
        key_numbers: key_numbers(summary),
        accuracy: accuracy(summary, &run.scene),
        mesh_estimates: mesh_estimates(summary),
        asperities: summary.law.asperities.as_ref().map(asperity_numbers),
        skipped: summary.skipped.values().map(String::as_str).collect(),
        effort: effort(summary),
        scene: serde_json::to_string_pretty(&summary.scene).map_err(Error::Summary)?,
        live: Live::run(&Document::of(run, summary)?)?,
    })
}

fn mode<'a>(run: &Run, backbone: &ModeBackbone, summary: &Summary, picture: &'a str) -> Mode<'a> {
    let bands = summary.ensemble.as_ref().map_or_else(String::new, |all| {
        let n = all.realisations - all.failed;
        format!(" Shaded: 5 to 95 % of {n} bootstrap realisations of the laws.")
    });
    Mode {
        heading: (run.backbones.len() > 1)
            .then(|| format!("Mode {}, {:.2} Hz", backbone.mode, run.frequencies[backbone.mode - 1])),
        failed: summary.backbone.iter().filter(|b| !b.converged).count(),
        amplitudes: summary.backbone.len(),
        backbone: Picture {
            svg: picture.into(),
            caption: format!("Amplitude: {}.{bands}", plot::amplitude_label(&summary.response)),
        },
        maps: maps(run, backbone),
        amplitude_table: amplitude_table(summary),
        methods: (!summary.methods.values().all(Vec::is_empty)).then(|| methods_table(summary)),
        validity: validity(backbone, summary),
    }
}

fn facts<const N: usize>(rows: [(&str, String); N]) -> Facts {
    rows.map(|(name, value)| (name.into(), value)).into()
}

fn pressure(run: &Run) -> Option<Picture<'static>> {
    if run.joint.mesh.is_of_points() {
        return None;
    }
    let pressure = fields::pressure(run, &run.prestress.fields);
    Some(Picture {
        svg: map::svg(run.into(), &pressure, "pressure", "Pa").into(),
        caption: format!(
            "Pressure under prestress, means over the elements; {}.",
            Placed::from(run).view()
        ),
    })
}

/// Dissipation of the amplitudes whose fields are stored; nothing to draw of points of contact.
fn maps(run: &Run, backbone: &ModeBackbone) -> Vec<Picture<'static>> {
    let all = backbone.amplitudes.len();
    let mut maps = Vec::new();
    if run.joint.mesh.is_of_points() {
        return maps;
    }
    for (index, amplitude) in backbone.amplitudes.iter().enumerate() {
        let stored = amplitude.fields.as_ref().and_then(|f| f.fields.as_ref());
        let (Some(stored), Some(x)) = (stored, amplitude.response_displacement) else {
            continue;
        };
        let flux = fields::total_flux(run, stored);
        maps.push(Picture {
            svg: map::svg(run.into(), &flux, "dissipated energy per area and cycle", "J/m²").into(),
            caption: format!("Amplitude {} of {all}: {x:.3e} m.", index + 1),
        });
    }
    maps
}

pub(crate) fn frequencies<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    let texts: Vec<String> = values.into_iter().map(|f| format!("{f:.2}")).collect();
    texts.join(", ") + " Hz"
}

fn key_numbers(summary: &Summary) -> Facts {
    let (model, law, gap, prestress) = (&summary.model, &summary.law, &summary.gap, &summary.prestress);
    let linearised: Vec<f64> = summary.modes.iter().map(|m| m.frequency_hz).collect();
    let mut structure = match (model.n_nodes, model.n_elements) {
        (Some(nodes), Some(elements)) => format!("{nodes} nodes, {elements} elements, {} unknowns", model.n_dofs),
        _ => format!("matrices over {} coordinates", model.n_dofs),
    };
    if let Some(raised) = model.raised {
        structure += &format!(
            "; the elements of the deck are linear and were made quadratic, which added {} nodes",
            raised.added_nodes
        );
    }
    let mass = model
        .mass
        .map_or_else(|| "not known".into(), |mass| format!("{mass:.4} kg"));
    facts([
        ("Structure", structure),
        ("Mass", mass),
        (
            "Interface",
            format!(
                "{} elements, {} points, {:.2} mm²",
                model.n_interface_elements,
                model.n_interface_points,
                1e6 * model.interface_area
            ),
        ),
        (
            "Reduced model",
            format!(
                "{} jump coordinates and {} modes; spectrum within {:.1e} of the full model",
                model.n_relative_dofs, model.n_modes, model.penalty_spectrum_error
            ),
        ),
        (
            "Zero-energy modes",
            format!(
                "{} with the interface stuck, {} without contact",
                model.zem_stuck, model.zem_unstressed
            ),
        ),
        ("Frequencies, interface stuck", frequencies(&model.stuck_frequencies_hz)),
        ("Frequencies about the prestress", frequencies(&linearised)),
        (
            "Frequencies without contact",
            frequencies(&model.unstressed_frequencies_hz),
        ),
        (
            "Traction law",
            format!("{}, history {}", law.kind, choice_name(&law.history)),
        ),
        (
            "Stiffness at mean pressure",
            format!(
                "{:.3e} Pa/m normal, {:.3e} Pa/m tangential at a closure of {:.2} µm and {:.2} MPa",
                law.normal_stiffness,
                law.tangential_stiffness,
                1e6 * law.mean_closure,
                1e-6 * law.mean_pressure
            ),
        ),
        (
            "Gap",
            format!(
                "{:.2} to {:.2} µm, {} negative value(s) set to zero",
                1e6 * gap.smallest,
                1e6 * gap.largest,
                gap.clipped_points
            ),
        ),
        (
            "Prestress",
            format!(
                "{:.3} kN per bolt; pressure up to {:.2} MPa, {:.2} MPa on average; {:.1} % of the area in contact",
                1e-3 * prestress.bolt_load,
                1e-6 * prestress.max_pressure,
                1e-6 * prestress.mean_pressure,
                100.0 * prestress.contact_area_fraction
            ),
        ),
        (
            "Solution of the prestress",
            format!(
                "{} iterations, residual ratio {:.1e}, error of equilibrium {:.1e}",
                prestress.iterations, prestress.residual_ratio, prestress.equilibrium_error
            ),
        ),
    ])
}

/// What is known of the errors of the results.
fn accuracy(summary: &Summary, scene: &Scene) -> Facts {
    let mut facts = facts([("Error of the mesh", summary.model.error_bar.sentence())]);
    let mut add = |name: &str, value: String| facts.push((name.into(), value));
    if let Some(places) = summary.model.error_bar.places() {
        add("The mesh errs most at", format!("{places} of the error"));
    }
    if let Some(preset) = summary.accuracy {
        add("Settings", format!("{}; {}", preset.name, preset.promise(scene)));
    }
    if let Some(found) = &summary.adaptation {
        add("Accuracy asked for", adaptation(found));
    }
    if let Some(errors) = errors(summary) {
        add("Errors of the settings", errors);
    }
    if let Some(estimate) = &summary.error_estimate {
        let largest = |value: Option<f64>| value.map_or_else(|| MISSING.into(), |v| format!("{v:.1e}"));
        add(
            &format!("Against the settings {}", estimate.finer),
            format!(
                "first frequency {:+.2e}, frequencies within {}, logarithm of damping within {}",
                estimate.linear_frequency,
                largest(estimate.frequency),
                largest(estimate.damping)
            ),
        );
    }
    if let Some(estimate) = &summary.mesh_estimate {
        add("Limit of the mesh", estimate.rule());
        add(
            "Elements with both formulations",
            format!("{:.1} %", 100.0 * estimate.share_of_elements),
        );
    }
    facts
}

/// One table per mode followed of what two formulations of the elements say.
fn mesh_estimates(summary: &Summary) -> Vec<(String, Table)> {
    let Some(estimate) = &summary.mesh_estimate else {
        return Vec::new();
    };
    let [own, other] = estimate.formulations();
    let headings = [
        "displacement [m]".to_owned(),
        format!("frequency, {own} [Hz]"),
        format!("frequency, {other} [Hz]"),
        "difference [%]".to_owned(),
        "limit of the mesh [Hz]".to_owned(),
        format!("damping ratio, {own} [-]"),
        format!("damping ratio, {other} [-]"),
        "difference [ln]".to_owned(),
    ];
    let table = |mode: &ModeEstimate| {
        let cell = |value: Option<String>| value.unwrap_or_else(|| MISSING.into());
        let row = |amplitude: Option<f64>, frequency: &FrequencyEstimate, damping: [Option<f64>; 3]| {
            let limit = frequency.limit_hz.zip(frequency.uncertainty_hz);
            let [own, other, difference] = damping;
            vec![
                amplitude.map_or_else(|| "linearised".into(), |a| format!("{a:.4e}")),
                format!("{:.4}", frequency.own_hz),
                format!("{:.4}", frequency.other_hz),
                format!("{:+.3}", 100.0 * frequency.relative_difference),
                cell(limit.map(|(limit, uncertainty)| format!("{limit:.3} ± {uncertainty:.3}"))),
                cell(own.map(|v| format!("{v:.4e}"))),
                cell(other.map(|v| format!("{v:.4e}"))),
                cell(difference.map(|v| format!("{v:+.3}"))),
            ]
        };
        let linear = row(None, &mode.linear_frequency, [None; 3]);
        let amplitudes = mode.amplitudes.iter().map(|a| {
            let damping = [a.damping_ratio, a.other_damping_ratio, a.damping_ln_difference];
            row(Some(a.response_displacement), &a.frequency, damping)
        });
        Table {
            headings: headings.to_vec(),
            rows: std::iter::once(linear).chain(amplitudes).collect(),
        }
    };
    let modes = estimate.modes.iter();
    modes
        .map(|mode| {
            (
                format!("Two formulations on the same mesh: mode {}", mode.mode),
                table(mode),
            )
        })
        .collect()
}

fn asperity_numbers(law: &AsperityReport) -> Facts {
    let table_error = match (law.table_error_normal, law.table_error_tangential) {
        (Some(n), Some(t)) => format!("{n:.1e} normal, {t:.1e} tangential"),
        _ => "no table in use".into(),
    };
    facts([
        (
            "Asperities",
            format!(
                "{} population(s), tangential stiffness {}",
                law.n_populations,
                choice_name(&law.tangential)
            ),
        ),
        ("Largest relative error of the tables", table_error),
        (
            "Fits to the asperity sums, rms in ln",
            format!(
                "{:.4} normal, {:.4} tangential, {} fallback(s)",
                law.fit_rms_normal, law.fit_rms_tangential, law.fit_fallbacks
            ),
        ),
        (
            "Other choices of tangential stiffness",
            format!(
                "fitted over summed {:.3}; paper over Mindlin reading {:.3}",
                law.fitted_to_summed, law.paper_to_mindlin
            ),
        ),
    ])
}

/// Heading of a column and its cell for an amplitude.
type Column = (&'static str, fn(&BackboneSummary) -> Option<String>);

const COLUMNS: [Column; 12] = [
    ("displacement [m]", |b| {
        b.response_displacement.map(|v| format!("{v:.4e}"))
    }),
    ("displacement as it moved [m]", |b| {
        b.response_motion.map(|v| format!("{v:.4e}"))
    }),
    ("acceleration [m/s²]", |b| {
        b.response_acceleration.map(|v| format!("{v:.4e}"))
    }),
    ("frequency, first harmonic [Hz]", |b| {
        b.frequency_first_harmonic_hz.map(|v| format!("{v:.4}"))
    }),
    ("frequency, secant [Hz]", |b| b.frequency_hz.map(|v| format!("{v:.4}"))),
    ("damping ratio [-]", |b| b.frequency_hz.map(|_| damping(b))),
    ("of it friction [-]", |b| {
        b.friction_damping_ratio.map(|v| format!("{v:.4e}"))
    }),
    ("dissipation [J]", |b| b.dissipation.map(|v| format!("{v:.4e}"))),
    ("slipping area [%]", |b| {
        b.slip_fraction.map(|v| format!("{:.2}", 100.0 * v))
    }),
    ("open area [%]", |b| {
        b.open_fraction.map(|v| format!("{:.2}", 100.0 * v))
    }),
    ("shape deviation [-]", |b| b.shape_deviation.map(|v| format!("{v:.2e}"))),
    ("iterations", |b| Some(b.iterations.to_string())),
];

fn amplitude_table(summary: &Summary) -> Table {
    let headings = ["no."].into_iter().chain(COLUMNS.map(|(heading, _)| heading));
    let row = |(index, point): (usize, &BackboneSummary)| {
        let cells = COLUMNS.map(|(_, cell)| cell(point).unwrap_or_else(|| MISSING.into()));
        let reason = point.failure.iter().map(|reason| format!("not converged: {reason}"));
        [(index + 1).to_string()]
            .into_iter()
            .chain(cells)
            .chain(reason)
            .collect()
    };
    Table {
        headings: headings.map(Into::into).collect(),
        rows: summary.backbone.iter().enumerate().map(row).collect(),
    }
}

/// Displacement, frequency and damping ratio of the other methods, side by side.
fn methods_table(summary: &Summary) -> Table {
    let mut headings = vec!["no.".to_owned()];
    for name in summary.methods.keys() {
        for heading in [
            "displacement [m]",
            "frequency, first harmonic [Hz]",
            "damping ratio [-]",
        ] {
            headings.push(format!("{}: {heading}", styles::title(name)));
        }
    }
    let row = |index: usize| {
        let mut row = vec![(index + 1).to_string()];
        for point in summary.methods.values().map(|points| points.get(index)) {
            let number = |value: fn(&MethodSummary) -> Option<f64>| point.and_then(value);
            let below = number(|p| p.damping_floor).map(|floor| format!("< {floor:.1e}"));
            let cells = [
                number(|p| p.response_displacement).map(|v| format!("{v:.4e}")),
                number(|p| p.frequency_first_harmonic_hz).map(|v| format!("{v:.4}")),
                number(|p| p.damping_ratio).map(|v| format!("{v:.4e}")).or(below),
            ];
            row.extend(cells.map(|text| text.unwrap_or_else(|| MISSING.into())));
        }
        row
    };
    // EPMC may have amplitudes of its own.
    let longest = summary.methods.values().map(Vec::len).max();
    Table {
        headings,
        rows: (0..longest.unwrap_or(0)).map(row).collect(),
    }
}

/// What the run says about its own validity, in sentences.
fn validity(backbone: &ModeBackbone, summary: &Summary) -> Vec<String> {
    let v = &summary.validity;
    let percent = |fraction: f64| format!("{:.2} %", 100.0 * fraction);
    let unknown = || "not known for this law".to_owned();
    let yields = summary
        .law
        .resolved
        .as_ref()
        .is_some_and(|law| law.onset_of_yield.is_some());
    let at = |number: usize| {
        let x = backbone
            .amplitudes
            .get(number.saturating_sub(1))
            .and_then(|a| a.response_displacement);
        x.map_or_else(
            || format!("amplitude {number}"),
            |x| format!("amplitude {number} ({x:.3e} m)"),
        )
    };
    let mut sentences = vec![
        format!(
            "Under prestress {} of the nominal area is in contact by points, {} by whole elements; the real contact area \
             of the asperities is {} of the nominal area.",
            percent(v.contact_area_fraction_by_points),
            percent(v.contact_area_fraction_by_elements),
            v.real_contact_area_fraction
                .map_or_else(unknown, |f| format!("{:.4} %", 100.0 * f)),
        ),
        format!(
            "An asperity begins to yield at an interference of {}; the share of the loaded asperities beyond it is \
             {}. {}",
            v.yield_onset_interference
                .map_or_else(unknown, |omega| format!("{omega:.3e} m")),
            v.yielded_asperity_fraction.map_or_else(unknown, percent),
            if yields {
                "The law follows their yield."
            } else {
                "The law is elastic: where that share is large, its stiffness is an elastic prediction and no more."
            },
        ),
        match (v.contact_over_asperity_radius, v.beyond_contact_formulas()) {
            (None, _) => "How large contact circles are is not known.".into(),
            (Some(ratio), None) => format!(
                "Contact circles have at most {} of the asperities' radius.",
                percent(ratio)
            ),
            (Some(ratio), Some(_)) => format!(
                "Contact circles have up to {} of the asperities' radius, where the contact formulas do not hold.",
                percent(ratio)
            ),
        },
        format!(
            "The adhesive traction is at most {} of the elastic pressure under prestress; adhesion is not modelled.",
            v.adhesive_to_elastic_traction.map_or_else(unknown, percent),
        ),
    ];
    if summary.backbone.is_empty() {
        return sentences;
    }
    sentences.extend([
        match (v.bolt_hole_clearance, v.first_beyond_clearance) {
            (None, _) => "The clearance of the bolt holes is not known, and pinning is not modelled.".into(),
            (Some(clearance), Some(number)) => format!(
                "From {} on the faces move tangentially by more than the clearance of the bolt holes, {:.2} mm: shanks \
                 would touch, which is not modelled.",
                at(number),
                1e3 * clearance
            ),
            (Some(clearance), None) => format!(
                "The tangential motion stays below the clearance of the bolt holes, {:.2} mm, at all amplitudes.",
                1e3 * clearance
            ),
        },
        match v.first_beyond_shape_deviation {
            Some(number) => format!(
                "From {} on more than {} of the motion at the peak is outside the linearised mode: frequency and damping, \
                 which assume its shape, are doubtful there.",
                at(number),
                percent(v.shape_deviation_limit)
            ),
            None => format!(
                "At all amplitudes less than {} of the motion at the peak is outside the linearised mode, whose shape \
                 the formulas of frequency and damping assume.",
                percent(v.shape_deviation_limit)
            ),
        },
    ]);
    let open = summary.backbone.iter().filter(|b| b.closed == Some(false)).count();
    sentences.push(match (v.first_not_converged, open) {
        (Some(number), _) => format!("Amplitude {number} is the first that did not converge."),
        (None, 0) => "All amplitudes converged.".into(),
        (None, _) => "The equations of all amplitudes were solved, but not all loops closed.".into(),
    });
    if open > 0 {
        sentences.push(format!(
            "{open} of {} loops did not close within the cycles allowed, so that their frequency and damping still depend on the number \
             of cycles: loop_closure in summary.json says how far their ends are apart; a larger analyses.backbone.until_closed accepts them.",
            summary.backbone.len()
        ));
    }
    if let Some(force) = v.separation_modal_force
        && summary.backbone.iter().any(|b| b.modal_force > force)
    {
        sentences.push(format!(
            "Beyond a modal force of {force:.3e} sqrt(kg) m/s² the inertia of the mode exceeds what the bolts' constant tension holds \
             together: there is no equilibrium. Bolts that are locked would take up the difference."
        ));
    }
    let below = summary
        .backbone
        .iter()
        .filter(|b| b.status == Status::BelowFloor)
        .count();
    if below > 0 {
        sentences.push(format!(
            "At {below} amplitudes the damping is smaller than what residuals and the ends of the loop could make of it: only \
             that bound is given."
        ));
    }
    sentences
}

fn effort(summary: &Summary) -> Facts {
    let times = summary
        .timings
        .iter()
        .map(|(stage, seconds)| (stage.clone(), format!("{seconds:.1} s")));
    let memory = summary
        .peak_memory
        .map(|bytes| ("largest memory".into(), format!("{:.0} MB", bytes as f64 / 1e6)));
    let work = summary.work.iter().map(|(stage, work)| {
        let Work {
            law_evaluations,
            products,
            bytes_read,
            ..
        } = work;
        let read = *bytes_read as f64 / 1e9;
        let text = format!(
            "{law_evaluations} evaluations of the law, {products} products with the flexibility that read {read:.2} GB"
        );
        (format!("work: {stage}"), text)
    });
    times.chain(memory).chain(work).collect()
}

/// The overview as on the terminal, with raised digits as in pictures.
fn overview(summary: &Summary) -> Vec<String> {
    let lines = summary.overview.as_ref().map(Overview::lines).unwrap_or_default();
    let raised = |line: String| line.replace("^2", "²").replace("^3", "³");
    lines.into_iter().map(raised).collect()
}
