//! Joints of other sizes: two plates of a hundred micrometres, and of a hundred metres.

use super::bench::Bench;
use super::case::Case;
use super::findings::{Findings, worst};
use analyses::warnings::WarningKind;
use analyses::{Prepared, Run, run};
use anyhow::{Context, Result, bail};
use brake_reuss_beam::BrakeReussBenchmark;
use finite_elements::elements::{Cell, Formulation, HEX8};
use finite_elements::formats::gmsh;
use finite_elements::mesh::{Element, Face, GroundSpring, Group, Material, Mesh};
use joint_model::Bodies;
use joints::Options;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::{Length, Scene};
use serde_json::json;

pub(super) static CASES: &[Case] = &[
    Case {
        name: "joint-100-um-and-100-m",
        change: "two bolted plates of 100 um and of 100 m, with bolt load and contact in proportion",
        expected: "frequencies in inverse proportion to the size, the same damping",
        run: sizes,
    },
    Case {
        name: "units-um-and-km",
        change: "a mesh in micrometres, and in kilometres",
        expected: "the same results",
        run: units,
    },
    Case {
        name: "moduli-1-to-1e6",
        change: "the lower of two bolted plates ten thousand and a million times as stiff as the upper one",
        expected: "the same frequencies and damping with both: those of a plate on a rigid one",
        run: stiff_below,
    },
    Case {
        name: "twin-modes",
        change: "two square columns end to end, whose bending modes are twins, and the same with sides of 1 : 1.02",
        expected: "equal frequencies and a warning that shapes are mixed; two frequencies about them without it",
        run: twins,
    },
    Case {
        name: "soft-springs",
        change: "two bolted plates on springs of 1 N/m at three corners",
        expected: "converges; six motions of the plates below a fiftieth of the first elastic frequency, which is that of free plates, as is its backbone",
        run: soft_springs,
    },
    Case {
        name: "aspect-1-to-1e3",
        change: "two bolted plates a thousandth as wide as long, one element across",
        expected: "converges; frequencies of bending as of wide plates, in which no stress varies across",
        run: slender,
    },
];

/// Length of a plate (m).
const LENGTH: f64 = 0.12;

/// Elements of a plate along, across and through it.
const CELLS: [usize; 3] = [24, 4, 2];

/// Two plates that overlap, clamped together by a bolt in the middle of the overlap.
struct Plates {
    /// Times the usual size.
    scale: f64,
    /// What is not overlapped, over their length.
    shift: f64,
    /// Over its length.
    width: f64,
    /// Over its length.
    thickness: f64,
    cells: [usize; 3],
    poisson_ratio: f64,
    /// Young's modulus of the lower plate over that of the upper one.
    stiffer_below: f64,
    /// Unit of length of the file, and its size (m).
    unit: (&'static str, f64),
}

impl Default for Plates {
    fn default() -> Self {
        Self {
            scale: 1.0,
            shift: 1.0 / 3.0,
            width: 0.25,
            thickness: 1.0 / 12.0,
            cells: CELLS,
            poisson_ratio: 0.3,
            stiffer_below: 1.0,
            unit: ("m", 1.0),
        }
    }
}

impl Plates {
    /// A plate with its lowest corner at `(x, 0, z)` in plate lengths; gives the faces below and above it, of which `seat` is the
    /// middle of the overlap.
    fn add(&self, mesh: &mut Mesh, [x, z]: [f64; 2], material: u16) -> Result<[Vec<Face>; 2]> {
        let [nx, ny, nz] = self.cells;
        let first = mesh.nodes.len();
        let length = self.scale * LENGTH / self.unit.1;
        let node = |i: usize, j: usize, k: usize| (first + i + (nx + 1) * (j + (ny + 1) * k)) as u32;
        for k in 0..=nz {
            for j in 0..=ny {
                for i in 0..=nx {
                    let at = [
                        x + i as f64 / nx as f64,
                        self.width * j as f64 / ny as f64,
                        z + self.thickness * k as f64 / nz as f64,
                    ];
                    mesh.nodes.push(at.map(|c| length * c));
                }
            }
        }
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let corners = [
                        (0, 0, 0),
                        (1, 0, 0),
                        (1, 1, 0),
                        (0, 1, 0),
                        (0, 0, 1),
                        (1, 0, 1),
                        (1, 1, 1),
                        (0, 1, 1),
                    ];
                    let nodes = corners.map(|(a, b, c)| node(i + a, j + b, k + c));
                    let cell = Cell::try_new(&HEX8, Formulation::IncompatibleModes, &nodes).context("a hexahedron")?;
                    mesh.elements.push(Element { cell, material });
                }
            }
        }
        let face = |k: usize, order: [(usize, usize); 4]| -> Vec<Face> {
            let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
            cells
                .map(|(i, j)| Face::quad4(order.map(|(a, b)| node(i + a, j + b, k))))
                .collect()
        };
        Ok([
            face(0, [(0, 1), (1, 1), (1, 0), (0, 0)]),
            face(nz, [(0, 0), (1, 0), (1, 1), (0, 1)]),
        ])
    }

    /// The scene, with its mesh in a file of this name in the folder of the bench.
    fn scene(&self, bench: &Bench, name: &str) -> Result<Scene> {
        let material = |name: &str| Material {
            name: name.into(),
            youngs_modulus: 1.0,
            poisson_ratio: 0.0,
            density: 1.0,
        };
        let mut mesh = Mesh {
            materials: ["upper", "lower"].map(material).into(),
            ..Mesh::default()
        };
        let [contact_above, top] = self.add(&mut mesh, [self.shift, 0.0], 0)?;
        let [bottom, contact_below] = self.add(&mut mesh, [0.0, -self.thickness], 1)?;
        // Elements about the middle of the overlap, of each plate.
        let (nx, ny) = (self.cells[0], self.cells[1]);
        let seat = |faces: &[Face], from: usize| -> Vec<Face> {
            let inside = |number: &usize| (from..from + nx / 6).contains(&(number % nx));
            (0..nx * ny).filter(inside).map(|number| faces[number]).collect()
        };
        let group = |name: &str, members: Vec<Face>| Group {
            name: name.into(),
            members,
        };
        let beyond = (self.shift * nx as f64).round() as usize;
        let first = (nx - beyond) / 2 - nx / 12;
        let (head, nut) = (seat(&top, first), seat(&bottom, first + beyond));
        let faces = [
            group("upper face", contact_above),
            group("lower face", contact_below),
            group("head", head),
            group("nut", nut),
        ];
        let path = bench.folder.join(format!("{name}.msh"));
        std::fs::write(&path, gmsh::write(&mesh, &faces, &[])?)
            .with_context(|| format!("writing {}", path.display()))?;
        let (unit, size) = self.unit;
        let length = self.scale * LENGTH;
        let tip = [1.0 + self.shift, 0.0, self.thickness].map(|c| length * c / size);
        let newton = |force: f64| format!("{force:e} N");
        let metre = |length: f64| format!("{length:e} m");
        let stiffness = |k: f64| format!("{:e} Pa/m", k / self.scale);
        let elastic = |modulus: f64| {
            json!({
                "youngs_modulus": format!("{modulus:e} GPa"), "poisson_ratio": self.poisson_ratio, "density": "7800 kg/m^3",
            })
        };
        let scene = json!({
            "units": { "length": unit, "mass": "kg", "time": "s" },
            "structure": { "mesh": {
                "path": path,
                "materials": { "lower": elastic(200.0 * self.stiffer_below) },
                "interfaces": [{ "top": "upper face", "bottom": "lower face" }],
                "bolts": [{ "head": "head", "nut": "nut" }],
                "response": { "nearest": tip, "direction": [0.0, 0.6, 0.8] },
            } },
            "model": { "element_order": "linear", "material": elastic(200.0) },
            "interfaces": {
                "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": {
                    "normal_stiffness": stiffness(4e13), "tangential_stiffness": [stiffness(3e13), stiffness(3e13)],
                } } }] } },
                "mu": 0.15,
                "points_per_direction": 2,
            },
            "bolts": { "load": newton(8e3 * self.width / 0.25 * self.scale.powi(2)) },
            "analyses": { "backbone": {
                "amplitudes": 3, "vertices_per_quarter": 4,
                "amplitude_from": metre(2e-6 * self.scale), "amplitude_to": metre(6e-5 * self.scale),
            } },
        });
        Ok(Scene::from_json(
            &scene.to_string(),
            name,
            name,
            &[&BrakeReussBenchmark],
        )?)
    }

    fn run(&self, bench: &Bench, name: &str) -> Result<Run> {
        Ok(run(&self.scene(bench, name)?, &Options::default(), &Silent)?)
    }
}

fn sizes(bench: &Bench) -> Result<Findings> {
    let usual = Plates::default().run(bench, "plates")?;
    let mut findings = Findings::default();
    findings.sound("usual, ", &usual)?;
    for (name, length) in [("100 um", 1e-4), ("100 m", 1e2)] {
        let scale = length / LENGTH;
        let plates = Plates {
            scale,
            ..Plates::default()
        };
        let found = plates.run(bench, name)?;
        findings.sound(&format!("{name}, "), &found)?;
        findings.alike(&format!("{name}, "), &found, &usual, [1.0 / scale, scale], 1e-6);
    }
    findings.outcome = format!("converged, {:.3} Hz of plates of 120 mm", usual.frequencies[0]);
    Ok(findings)
}

fn units(bench: &Bench) -> Result<Findings> {
    let usual = Plates::default().run(bench, "plates")?;
    let mut findings = Findings::default();
    for unit in [("um", 1e-6), ("km", 1e3)] {
        let plates = Plates {
            unit,
            ..Plates::default()
        };
        let found = plates.run(bench, unit.0)?;
        findings.sound(&format!("{}, ", unit.0), &found)?;
        findings.alike(&format!("{}, ", unit.0), &found, &usual, [1.0; 2], 1e-6);
    }
    findings.outcome = format!("converged, {:.6} Hz", usual.frequencies[0]);
    Ok(findings)
}

fn stiff_below(bench: &Bench) -> Result<Findings> {
    let below = |stiffer_below: f64, name: &str| {
        let plates = Plates {
            stiffer_below,
            ..Plates::default()
        };
        plates.run(bench, name)
    };
    let (less, more) = (below(1e4, "less")?, below(1e6, "more")?);
    let mut findings = Findings::default();
    findings.sound("1e4, ", &less)?;
    findings.count(&more);
    // Of bodies so unlike, round-off is more.
    findings.within("1e6, equilibrium", more.prestress.equilibrium_error, 1e-8);
    findings.alike("", &less, &more, [1.0; 2], 1e-3);
    findings.outcome = format!(
        "converged, {:.4} and {:.4} Hz",
        less.frequencies[0], more.frequencies[0]
    );
    Ok(findings)
}

fn twins(bench: &Bench) -> Result<Findings> {
    let of_width = |width: f64, name: &str| -> Result<Run> {
        let columns = Plates {
            shift: 0.0,
            width,
            thickness: 4.0,
            cells: [12; 3],
            ..Plates::default()
        };
        let mut scene = columns.scene(bench, name)?;
        // Far below what parts the columns.
        scene.analyses.backbone.amplitude_from = Length::from_si(1e-8);
        scene.analyses.backbone.amplitude_to = Length::from_si(1e-6);
        scene.analyses.modes.followed = vec![1, 2];
        Ok(run(&scene, &Options::default(), &Silent)?)
    };
    let (square, oblong) = (of_width(1.0, "square")?, of_width(1.02, "oblong")?);
    let mut findings = Findings::default();
    findings.sound("square, ", &square)?;
    findings.sound("oblong, ", &oblong)?;
    let is_warned = |run: &Run| {
        run.warnings
            .iter()
            .any(|warning| warning.kind == WarningKind::TwinModes)
    };
    findings.that(
        "a warning of the square ones alone",
        is_warned(&square) && !is_warned(&oblong),
    );
    let [first, second] = [0, 1].map(|mode| square.frequencies[mode]);
    findings.equal("frequencies of the twins (Hz)", second, first, 1e-6);
    findings.between(
        "first of the oblong ones over it",
        oblong.frequencies[0] / first,
        0.99,
        1.01,
    );
    findings.between(
        "their second over their first",
        oblong.frequencies[1] / oblong.frequencies[0],
        1.005,
        1.04,
    );
    findings.outcome = format!(
        "converged, {first:.4} Hz and {:.1e} more; {:.4} and {:.4} Hz of oblong ones",
        second / first - 1.0,
        oblong.frequencies[0],
        oblong.frequencies[1]
    );
    Ok(findings)
}

fn soft_springs(bench: &Bench) -> Result<Findings> {
    let mut scene = Plates::default().scene(bench, "free")?;
    let free = run(&scene, &Options::default(), &Silent)?;
    let mut joint = Structure::try_new(&scene, &Silent)?.joint;
    let Bodies::Meshed(bodies) = &mut joint.bodies else {
        bail!("plates without a mesh");
    };
    let nodes = &bodies.assembly.mesh.nodes;
    // Two ends of the upper plate, and a corner of the lower one: not on one line.
    let last = (nodes.len() - 1) as u32;
    let springs = [0, CELLS[0] as u32, last].into_iter().flat_map(|node| {
        (0..3).map(move |component| GroundSpring {
            node,
            component,
            stiffness: 1.0,
        })
    });
    bodies.assembly.springs.extend(springs);
    bodies.rigid_motions = 0;
    scene.analyses.modes.followed = vec![7];
    scene.analyses.modes.number = 10;
    let structure = Structure::from_joint(&scene.model, scene.bolts.behaviour, joint);
    let held = Prepared::try_new(&scene, &structure, &Options::default(), &Silent)?.solve(&Silent)?;
    let mut findings = Findings::default();
    findings.sound("free, ", &free)?;
    findings.count(&held);
    findings.within("residual of the prestress", held.prestress.residual_ratio, 1e-6);
    findings.within(
        "highest motion of the plates over the first elastic frequency",
        held.frequencies[5] / free.frequencies[0],
        0.02,
    );
    findings.equal(
        "first elastic frequency (Hz)",
        held.frequencies[6],
        free.frequencies[0],
        1e-5,
    );
    let pairs = held.amplitudes().iter().zip(free.amplitudes());
    let differences = pairs.map(|(a, b)| match (&a.point.result, &b.point.result) {
        (Ok(a), Ok(b)) => (a.omega / b.omega - 1.0).abs().max((a.zeta - b.zeta).abs()),
        _ => f64::NAN,
    });
    findings.within("frequencies and damping along the backbone", worst(differences), 1e-4);
    findings.outcome = format!(
        "converged, plates at {:.3} to {:.3} Hz, then {:.4} Hz; free {:.4} Hz",
        held.frequencies[0], held.frequencies[5], held.frequencies[6], free.frequencies[0]
    );
    Ok(findings)
}

fn slender(bench: &Bench) -> Result<Findings> {
    let of_width = |width: f64, name: &str| -> Result<Run> {
        let plates = Plates {
            width,
            cells: [CELLS[0], 1, CELLS[2]],
            // Without it bending of wide and of narrow plates is the same.
            poisson_ratio: 0.0,
            ..Plates::default()
        };
        let mut scene = plates.scene(bench, name)?;
        scene.analyses.backbone.amplitudes = 0;
        // The narrow ones have many modes sideways before the first across the interface.
        (scene.model.modes, scene.analyses.modes.number) = (Some(80), 60);
        Ok(run(&scene, &Options::default(), &Silent)?)
    };
    let mut findings = Findings::default();
    let (wide, narrow) = (of_width(0.25, "wide")?, of_width(1e-3, "narrow")?);
    findings.sound("a quarter, ", &wide)?;
    findings.sound("a thousandth, ", &narrow)?;
    let first = wide.frequencies[0];
    let distance = |f: &f64| (f / first - 1.0).abs();
    let nearest = narrow
        .frequencies
        .iter()
        .copied()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    findings.equal(
        "frequency of bending across the interface (Hz)",
        nearest.unwrap_or(f64::NAN),
        first,
        1e-5,
    );
    findings.outcome = format!("converged, {first:.4} Hz of both");
    Ok(findings)
}
