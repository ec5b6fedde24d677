//! What is varied: every parameter with its settings, from coarse to fine.

use crate::elements::{Representatives, given};
use anyhow::Result;
use brake_reuss_beam::published;
use contact_laws::{AsperityLimit, Cone, HistoryRule, TangentialReading, YieldCurves};
use joint_model::benchmark::{ElementOrder, RefinementLevel, Symmetry};
use joints::interface::ScannedSurface;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::{
    Bins, Commit, EPMC, Epmc, Formulation, Friction, Gap, Law, LawKind, Length, Method, PRESETS, Preset, RadialRule,
    RingDown, Scene, Stress, StructureSource, Surface, SyntheticScan, Yield,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Response amplitudes at which settings are compared (m): at the onset of slip, in microslip, near macroslip.
pub(crate) const AMPLITUDES: [f64; 3] = [5e-5, 2e-4, 6e-4];

/// The parameter of laws from scans.
const SCAN_LAW: &str = "scan-law";

/// The parameter of physics beside the measured beam.
pub(crate) const MEASURED_GAP: &str = "measured-gap";

/// Bootstrap realisations that show what the sampling of the surface leaves open.
const REALISATIONS: u16 = 10;

/// A setting that is varied while all others stay.
pub(crate) struct Parameter {
    pub(crate) name: &'static str,
    /// In words.
    pub(crate) what: &'static str,
    /// The last is the reference.
    pub(crate) settings: Vec<Setting>,
    /// How the errors of the default enter its budget.
    pub(crate) share: Share,
}

/// What the difference of a parameter's default to its reference is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Share {
    /// A numerical error of the default scene.
    Error,
    /// A choice between models.
    Choice,
    /// What the samples of a surface leave open.
    Sampling,
    /// None of these: several settings at once, or another scene.
    None,
}

impl Share {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Choice => "choice",
            Self::Sampling => "sampling",
            Self::None => "none",
        }
    }
}

/// A value of a parameter.
pub(crate) struct Setting {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) source: Source,
    /// Size of the step, if the parameter is a discretisation that is refined: errors go with a power of it.
    pub(crate) size: Option<f64>,
}

/// Where the backbone of a setting comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The loops of CQSMA.
    Loops,
    /// Another method, by its name in the summary.
    Method(&'static str),
    /// A motion in time, identified.
    RingDown,
    /// The upper ends of the bands of an ensemble of this size.
    Ensemble(u16),
}

impl Setting {
    pub(crate) fn new(name: impl Into<String>, scene: Scene) -> Self {
        Self {
            name: name.into(),
            scene,
            source: Source::Loops,
            size: None,
        }
    }
}

/// A refined discretisation: `n` steps per unit.
fn refined<T: Copy + Into<f64> + ToString>(base: &Scene, counts: &[T], set: fn(&mut Scene, T)) -> Vec<Setting> {
    let setting = |&n: &T| {
        let mut scene = base.clone();
        set(&mut scene, n);
        Setting {
            size: Some(1.0 / n.into()),
            ..Setting::new(n.to_string(), scene)
        }
    };
    counts.iter().map(setting).collect()
}

fn named<T: Copy>(base: &Scene, values: &[(&str, T)], set: fn(&mut Scene, T)) -> Vec<Setting> {
    let setting = |&(name, value): &(&str, T)| {
        let mut scene = base.clone();
        set(&mut scene, value);
        Setting::new(name, scene)
    };
    values.iter().map(setting).collect()
}

/// Fits the amplitudes of a scene to the comparison, which is of the first mode that it follows.
pub(crate) fn base(mut scene: Scene, quick: bool) -> Scene {
    scene.analyses.modes.followed.truncate(1);
    scene.analyses.backbone.amplitude_from = Length::from_si(2e-5);
    scene.analyses.backbone.amplitude_to = Length::from_si(1.2e-3);
    scene.analyses.backbone.amplitudes = 10;
    scene.output.fields_at = Some(Vec::new());
    scene.analyses.backbone.methods.clear();
    if quick && scene.structure.benchmark().is_some() {
        scene.model.refinement = RefinementLevel::Quick;
    }
    scene
}

/// Parameters of the block mesh of a benchmark, and of its own scans.
const OF_BENCHMARK: [&str; 6] = ["formulation", "arms", "symmetry", SCAN_LAW, "bootstrap", "accuracy"];

/// The scene with all settings fine at once, as far as time allows: single ones are varied beyond. `finest` is its finest mesh, if it comes as a file.
pub(crate) fn truth(base: &Scene, quick: bool, finest: Option<&Path>) -> Setting {
    let mut scene = base.clone();
    match finest {
        Some(path) => on_mesh(&mut scene, path),
        None if scene.structure.benchmark().is_some() => {
            let refinement = if quick {
                RefinementLevel::Coarse
            } else {
                RefinementLevel::Default
            };
            (scene.model.element_order, scene.model.refinement) = (Some(ElementOrder::Quadratic), refinement);
        }
        None => {}
    }
    scene.interfaces.points_per_direction = 4;
    scene.analyses.backbone.vertices_per_quarter = 16;
    let law = &mut scene.interfaces.law;
    match law.friction() {
        Friction::Lumped => {}
        Friction::Foundation => law.bins = Bins::Gauss(128),
        Friction::Resolved | Friction::MindlinIwan => law.bins = Bins::Gauss(32),
    }
    if law.friction() == Friction::MindlinIwan {
        law.radii = RadialRule::Annuli(16);
    }
    Setting::new("all settings fine", scene)
}

/// What a scene models, without what is numerical about it.
pub(crate) fn physics(scene: &Scene) -> Value {
    let mut interfaces = scene.interfaces.clone();
    let Law { bins, radii, .. } = Law::default();
    (interfaces.law.bins, interfaces.law.radii) = (bins, radii);
    interfaces.points_per_direction = 1;
    json!([interfaces, scene.bolts, scene.analyses.backbone.commit])
}

/// Puts a scene on another mesh file.
fn on_mesh(scene: &mut Scene, path: &Path) {
    if let StructureSource::Mesh(mesh) = &mut scene.structure.source {
        mesh.path = path.to_owned();
    }
}

/// All parameters about the scene `base`; `quick` leaves out what takes more than seconds on its coarse mesh. Settings that cost work to
/// describe are left out of parameters that are not `wanted`.
///
/// # Errors
/// Of the mesh and of the characterisation of the synthetic scans.
pub(crate) fn all(
    base: &Scene,
    quick: bool,
    files: &[PathBuf],
    wanted: impl Fn(&str) -> bool,
) -> Result<Vec<Parameter>> {
    let is_benchmark = base.structure.benchmark().is_some();
    let error = |name, what, settings| Parameter {
        name,
        what,
        settings,
        share: Share::Error,
    };
    let meshes = [
        ("quick", RefinementLevel::Quick),
        ("coarse", RefinementLevel::Coarse),
        ("default", RefinementLevel::Default),
    ];
    let finest = meshes[meshes.len() - 1];
    let linear = |scene: &mut Scene, refinement| {
        (scene.model.element_order, scene.model.refinement) = (Some(ElementOrder::Linear), refinement);
    };
    let mut mesh = named(base, &meshes, linear);
    // The finest of these is nearest to the limit of all, and that of `truth`.
    let quadratic = [
        ("quadratic quick", RefinementLevel::Quick),
        ("quadratic coarse", RefinementLevel::Coarse),
        ("quadratic default", RefinementLevel::Default),
    ];
    mesh.extend(named(
        base,
        &quadratic[..if quick { 2 } else { 3 }],
        |scene, refinement| {
            (scene.model.element_order, scene.model.refinement) = (Some(ElementOrder::Quadratic), refinement);
        },
    ));
    if !is_benchmark {
        let of_file = |path: &PathBuf| {
            let mut scene = base.clone();
            on_mesh(&mut scene, path);
            let stem = path.file_stem().unwrap_or(path.as_os_str());
            Setting::new(stem.to_string_lossy(), scene)
        };
        mesh = files.iter().map(of_file).collect();
    }
    let mut formulations = named(
        base,
        &[
            ("reduced", Formulation::Reduced),
            ("full", Formulation::Full),
            ("b-bar", Formulation::BBar),
            ("incompatible-modes", Formulation::IncompatibleModes),
        ],
        |scene, formulation| scene.model.formulation = Some(formulation),
    );
    formulations
        .iter_mut()
        .for_each(|setting| setting.scene.model.element_order = Some(ElementOrder::Linear));
    let reference = named(base, &[finest], linear);
    formulations.extend(reference.into_iter().map(|setting| Setting {
        name: format!("incompatible-modes, {} mesh", setting.name),
        ..setting
    }));
    let mut parameters = vec![
        error(
            "mesh",
            if is_benchmark {
                "block mesh: order of the elements and refinement, interface and bodies"
            } else {
                "mesh file"
            },
            mesh,
        ),
        Parameter {
            share: Share::None,
            ..error(
                "formulation",
                "formulation of the hexahedra, on the scene's mesh",
                formulations,
            )
        },
        error(
            "arms",
            "layers of elements along each arm",
            refined(base, &[25_u16, 50, 100, 200], |scene, n| {
                scene.model.arm_layers = Some(n.into());
            }),
        ),
        error(
            "points",
            "quadrature points per direction of an interface element",
            refined(base, &[1_u8, 2, 3, 4, 5], |scene, n| {
                scene.interfaces.points_per_direction = n.into()
            }),
        ),
        error(
            "modes",
            "stuck-interface modes retained",
            named(
                base,
                &[("4", 4), ("10", 10), ("20", 20), ("40", 40), ("80", 80)],
                |scene, n| scene.model.modes = Some(n),
            ),
        ),
        error(
            "vertices",
            "vertices per quarter loop",
            refined(base, &[2_u8, 4, 8, 16, 32, 64], |scene, n| {
                scene.analyses.backbone.vertices_per_quarter = n.into();
            }),
        ),
        Parameter {
            share: Share::Choice,
            ..error(
                "commit",
                "when the friction history is committed, and vertices per quarter",
                named(
                    base,
                    &[
                        ("at reversals, 8", (Commit::AtReversals, 8)),
                        ("at every vertex, 8", (Commit::AtEveryVertex, 8)),
                        ("at every vertex, 32", (Commit::AtEveryVertex, 32)),
                    ],
                    |scene, (commit, vertices)| {
                        scene.analyses.backbone.commit = commit;
                        scene.analyses.backbone.vertices_per_quarter = vertices;
                    },
                ),
            )
        },
        error(
            "tolerance",
            "residual of every vertex relative to the load",
            named(
                base,
                &[
                    ("1e-3", 1e-3),
                    ("1e-5", 1e-5),
                    ("1e-7", 1e-7),
                    ("1e-9", 1e-9),
                    ("1e-11", 1e-11),
                ],
                |scene, tolerance| scene.analyses.backbone.tolerance = tolerance,
            ),
        ),
        Parameter {
            share: Share::Choice,
            ..error("method", "quasi-static method", methods(base))
        },
        error("symmetry", "half of the structure, or the whole", symmetry(base)),
        error(
            "law",
            "how the asperity sums are evaluated, one population, one friction limit per point",
            laws(&lumped(base)),
        ),
        Parameter {
            share: Share::Choice,
            ..error(
                "reading",
                "tangential stiffness and history of the published law, one friction limit per point",
                readings(&lumped(base)),
            )
        },
        Parameter {
            share: Share::Choice,
            ..error(
                "friction",
                "what sticks or slips as a whole, and whether asperities yield",
                frictions(base),
            )
        },
        Parameter {
            share: Share::None,
            ..error(
                "bins",
                "bins of asperities per point, friction of single asperities",
                bins(base),
            )
        },
        Parameter {
            share: Share::None,
            ..error("radii", "annuli per asperity, friction of annuli", radii(base))
        },
        Parameter {
            share: Share::Choice,
            ..error("cone", "shape of the slip limit", cones(base))
        },
        Parameter {
            share: Share::Choice,
            ..error("limit", "slip limit of asperities that yield", limits(base))
        },
    ];
    let scan = {
        let mut scene = lumped(base);
        scene.interfaces.surface = Surface::SyntheticScan(SyntheticScan::default());
        scene.interfaces.gap = Gap::Scan;
        scene.interfaces.law.kind = LawKind::Fitted;
        scene
    };
    let none = |name, what, settings| Parameter {
        share: Share::None,
        ..error(name, what, settings)
    };
    let mut flat = scan.clone();
    flat.interfaces.gap = Gap::Flat;
    let mut laws = scan_laws(&flat);
    if is_benchmark && wanted(SCAN_LAW) {
        laws.insert(0, uniform(&flat)?);
    }
    parameters.push(none(
        SCAN_LAW,
        "law of every element from its own samples (synthetic scans), or that of the median element everywhere",
        laws,
    ));
    parameters.push(Parameter {
        share: Share::Sampling,
        ..error(
            "bootstrap",
            "95 % end of bootstrap realisations against the samples themselves",
            bootstrap(&scan),
        )
    });
    if !quick {
        parameters.push(none("accuracy", "whole sets of settings", sets(base)));
    }
    if is_benchmark {
        let mut measured = base.clone();
        measured.interfaces.gap = Gap::Measured;
        parameters.push(none(
            MEASURED_GAP,
            "what sticks or slips as a whole, and whether asperities yield, with the measured gap",
            frictions(&measured),
        ));
    } else {
        parameters.retain(|parameter| !OF_BENCHMARK.contains(&parameter.name) && !parameter.settings.is_empty());
    }
    Ok(parameters)
}

/// With one friction limit per point, as in the method paper.
fn lumped(base: &Scene) -> Scene {
    let mut scene = base.clone();
    scene.interfaces.law.friction = Some(Friction::Lumped);
    scene
}

fn methods(base: &Scene) -> Vec<Setting> {
    let method = |method: Method| {
        let mut scene = base.clone();
        scene.analyses.backbone.methods = vec![method];
        Setting {
            source: Source::Method(method.name()),
            ..Setting::new(method.name(), scene)
        }
    };
    let mut settings: Vec<Setting> = [Method::Rqnma, Method::Masing, Method::Qsma].map(method).into();
    let mut periodic = base.clone();
    periodic.analyses.epmc = Some(Epmc::default());
    settings.push(Setting {
        source: Source::Method(EPMC),
        ..Setting::new(EPMC, periodic)
    });
    let mut in_time = base.clone();
    in_time.analyses.ring_down = Some(RingDown {
        release: Some(base.analyses.backbone.amplitude_to),
        other_damping: 0.05,
        ..RingDown::default()
    });
    settings.push(Setting {
        source: Source::RingDown,
        ..Setting::new("ring-down", in_time)
    });
    settings.push(Setting::new("cqsma", base.clone()));
    settings
}

fn symmetry(base: &Scene) -> Vec<Setting> {
    named(
        base,
        &[("half", Symmetry::Half), ("whole", Symmetry::None)],
        |scene, symmetry| {
            scene.model.symmetry = symmetry;
        },
    )
}

fn laws(base: &Scene) -> Vec<Setting> {
    named(
        base,
        &[
            ("fitted", LawKind::Fitted),
            ("tabulated", LawKind::Tabulated),
            ("asperity-sum", LawKind::AsperitySum),
        ],
        |scene, kind| scene.interfaces.law.kind = kind,
    )
}

fn readings(base: &Scene) -> Vec<Setting> {
    named(
        base,
        &[
            (
                "paper's stiffness, paper's history",
                (TangentialReading::Paper, HistoryRule::Paper),
            ),
            (
                "paper's stiffness",
                (TangentialReading::Paper, HistoryRule::Incremental),
            ),
            ("paper's history", (TangentialReading::Mindlin, HistoryRule::Paper)),
            (
                "history from a potential",
                (TangentialReading::Mindlin, HistoryRule::Potential),
            ),
            ("default", (TangentialReading::Mindlin, HistoryRule::Incremental)),
        ],
        |scene, (tangential, history)| {
            scene.interfaces.law.tangential = tangential;
            scene.interfaces.law.history = history;
        },
    )
}

/// Steel as published with the measured asperities.
fn yielding() -> Yield {
    let source = published::SURFACE_SOURCE_MODEL;
    Yield {
        strength: Stress::from_si(source.yield_strength),
        tangent_modulus: Stress::from_si(source.tangent_modulus),
        curves: YieldCurves::Continuous,
    }
}

fn frictions(base: &Scene) -> Vec<Setting> {
    let lumped = (Friction::Lumped, None);
    named(
        base,
        &[
            ("lumped", lumped),
            ("foundation", (Friction::Foundation, None)),
            ("resolved", (Friction::Resolved, None)),
            ("mindlin-iwan", (Friction::MindlinIwan, None)),
            ("resolved, yield", (Friction::Resolved, Some(yielding()))),
            ("mindlin-iwan, yield", (Friction::MindlinIwan, Some(yielding()))),
        ],
        |scene, (friction, yielding)| {
            scene.interfaces.law.friction = Some(friction);
            scene.interfaces.law.yielding = yielding;
        },
    )
}

fn bins(base: &Scene) -> Vec<Setting> {
    named(
        base,
        &[
            ("101 equally spaced", Bins::EquallySpaced(101)),
            ("4", Bins::Gauss(4)),
            ("8", Bins::Gauss(8)),
            ("16", Bins::Gauss(16)),
            ("32", Bins::Gauss(32)),
            ("64", Bins::Gauss(64)),
        ],
        |scene, bins| {
            if scene.interfaces.law.friction() == Friction::Lumped {
                scene.interfaces.law.friction = Some(Friction::Resolved);
            }
            scene.interfaces.law.bins = bins;
        },
    )
}

fn radii(base: &Scene) -> Vec<Setting> {
    named(
        base,
        &[("2", 2), ("4", 4), ("8", 8), ("16", 16), ("32", 32)],
        |scene, radii| {
            scene.interfaces.law.friction = Some(Friction::MindlinIwan);
            scene.interfaces.law.radii = RadialRule::Annuli(radii);
        },
    )
}

fn cones(base: &Scene) -> Vec<Setting> {
    named(base, &[("box", Cone::Box), ("circle", Cone::Circle)], |scene, cone| {
        scene.interfaces.law.friction = Some(Friction::Resolved);
        scene.interfaces.law.cone = cone;
    })
}

fn limits(base: &Scene) -> Vec<Setting> {
    let limits = [
        ("shear-strength", AsperityLimit::ShearStrength),
        ("coulomb", AsperityLimit::Coulomb),
    ];
    named(base, &limits, |scene, limit| {
        scene.interfaces.law.friction = Some(Friction::Resolved);
        scene.interfaces.law.yielding = Some(yielding());
        scene.interfaces.law.limit = limit;
        if limit != AsperityLimit::Coulomb {
            scene.interfaces.mu = 0.0;
        }
    })
}

/// The fitted law of one element everywhere.
fn uniform(scan: &Scene) -> Result<Setting> {
    let structure = Structure::try_new(scan, &Silent)?;
    let surface = ScannedSurface::try_new(scan, structure.interface())?;
    let median = Representatives::try_new(&surface.found.elements)?.median;
    let mut scene = scan.clone();
    scene.interfaces.surface = given(vec![joints::interface::curves_of_element(median)]);
    // The curves say what they are, and are of one friction limit per point.
    let law = Law::default();
    (scene.interfaces.law.kind, scene.interfaces.law.friction) = (law.kind, law.friction);
    Ok(Setting::new("fitted, uniform", scene))
}

fn scan_laws(scan: &Scene) -> Vec<Setting> {
    named(
        scan,
        &[
            ("fitted per element", LawKind::Fitted),
            ("tabulated per element", LawKind::Tabulated),
            ("asperity-sum per element", LawKind::AsperitySum),
        ],
        |scene, kind| scene.interfaces.law.kind = kind,
    )
}

fn bootstrap(scan: &Scene) -> Vec<Setting> {
    vec![
        Setting {
            source: Source::Ensemble(REALISATIONS),
            ..Setting::new(format!("{REALISATIONS} realisations"), scan.clone())
        },
        Setting::new("samples", scan.clone()),
    ]
}

/// The sets that scenes can ask for, against the mesh after that of the finest set with its other settings.
fn sets(base: &Scene) -> Vec<Setting> {
    let scene = |preset: &Preset, refinement| {
        let mut scene = base.clone();
        (scene.model.element_order, scene.model.refinement) = (Some(preset.element_order), refinement);
        scene.model.modes = Some(preset.modes);
        scene.interfaces.points_per_direction = preset.points_per_direction;
        scene.analyses.backbone.vertices_per_quarter = preset.vertices_per_quarter;
        scene.analyses.backbone.tolerance = preset.tolerance;
        scene
    };
    let sets = PRESETS
        .iter()
        .map(|preset| Setting::new(preset.name, scene(preset, preset.refinement)));
    let [.., finest] = &PRESETS;
    let beyond = Setting::new("reference, fine mesh", scene(finest, RefinementLevel::Fine));
    sets.chain([beyond]).collect()
}
