//! Meshes as they should not be, and materials that elements do not like.

use super::bench::{Bench, meshed};
use super::case::Case;
use super::findings::{Findings, Refusal};
use analyses::warnings::WarningKind;
use analyses::{Error, Prepared, Run};
use anyhow::{Context, Result, bail};
use finite_elements::mesh::{Cell, Element as Solid};
use joint_model::benchmark::{ElementOrder, RefinementLevel, Symmetry};
use joint_model::{MeshedBodies, Sides};
use joints::Options;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::Formulation;

pub(super) static CASES: &[Case] = &[
    Case {
        name: "needle-quads",
        change: "a column of interface elements a thousand times as long as wide, through both halves",
        expected: "converges; the first frequency of the sound mesh within its discretisation",
        run: |bench| pinched(bench, Pinch::Column(1e-3)),
    },
    Case {
        name: "sliver-quads",
        change: "interface elements with one edge a thousandth of the others",
        expected: "converges; the first frequency of the sound mesh within its discretisation",
        run: |bench| pinched(bench, Pinch::Line(1e-3)),
    },
    Case {
        name: "nearly-coincident-nodes",
        change: "nodes a billionth of an edge apart; then a pair of the interface 1e-9 m and 1e-4 m apart",
        expected: "converges as with slivers; the pair within its tolerance, then refused by its nodes",
        run: nearly_coincident,
    },
    Case {
        name: "inverted-interface-element",
        change: "one interface element numbered the other way round",
        expected: "a refusal that names the element, the point and the determinant",
        run: inverted_quad,
    },
    Case {
        name: "inverted-solid-element",
        change: "a line of nodes moved beyond its neighbour",
        expected: "a refusal that names the element, the point and the determinant",
        run: inverted_hexahedron,
    },
    Case {
        name: "quadratic-elements",
        change: "quadratic elements; a column of them a thousand times as long as wide, then one whose middle lies in its corner",
        expected: "converges; the first frequency of the sound mesh within its discretisation; then a refusal that names element and point",
        run: quadratic,
    },
    Case {
        name: "duplicate-nodes",
        change: "an interface pair twice; a solid node that no element has",
        expected: "refusals that name the nodes",
        run: duplicates,
    },
    Case {
        name: "unconnected-part",
        change: "a cube beside the beam that touches nothing",
        expected: "a refusal that gives 12 zero-energy modes where 6 are expected",
        run: unconnected,
    },
    Case {
        name: "poisson-0.499999",
        change: "Poisson ratios of 0.4999 and 0.499999",
        expected: "converges; incompatible modes and B-bar agree and change little from 0.49, full integration is stiffer; B-bar changes \
                   little to 0.499999, where a warning says that incompatible modes lock",
        run: incompressible,
    },
];

/// Where nodes are brought together, and to what part of their distance.
#[derive(Clone, Copy)]
enum Pinch {
    /// All nodes of a section of the lap.
    Column(f64),
    /// Those below one another at one place of the interface.
    Line(f64),
}

/// Positions of the first columns of nodes along the lap.
fn columns<const N: usize>(structure: &Structure) -> [f64; N] {
    let mut last = f64::NEG_INFINITY;
    [0; N].map(|_| {
        let places = structure.joint.interface.nodes.iter().map(|n| n[0]);
        last = places.filter(|x| *x > last + 1e-9).fold(f64::INFINITY, f64::min);
        last
    })
}

/// Moves nodes of the third column of the lap's end towards the second, in the interface and in the bodies.
fn pinch(structure: &mut Structure, how: Pinch) -> Result<()> {
    let [_, second, third] = columns(structure);
    let (part, middle) = match how {
        Pinch::Column(part) => (part, None),
        Pinch::Line(part) => (part, Some(0.0)),
    };
    move_column(structure, third, second + part * (third - second), middle)
}

/// Moves nodes of a column of the lap, in the interface and in the bodies: all, or those at one place across.
fn move_column(structure: &mut Structure, from: f64, to: f64, across: Option<f64>) -> Result<()> {
    let interface = &mut structure.joint.interface;
    let is_moved = |x: f64, y: f64| (x - from).abs() < 1e-9 && across.is_none_or(|at: f64| (y - at).abs() < 1e-9);
    let places: Vec<[f64; 2]> = interface
        .nodes
        .iter()
        .copied()
        .filter(|n| is_moved(n[0], n[1]))
        .collect();
    for node in interface.nodes.iter_mut().filter(|n| is_moved(n[0], n[1])) {
        node[0] = to;
    }
    // The bodies' coordinates along and across are those of the interface.
    for node in &mut meshed(structure)?.assembly.mesh.nodes {
        let moved = places
            .iter()
            .any(|p| (p[0] - node[0]).abs() < 1e-9 && (p[1] - node[1]).abs() < 1e-9);
        if moved {
            node[0] = to;
        }
    }
    Ok(())
}

fn like_the_sound_mesh(findings: &mut Findings, prefix: &str, bench: &Bench, run: &Run, tolerance: f64) -> Result<()> {
    findings.sound(prefix, run)?;
    findings.equal(
        &format!("{prefix}first frequency (Hz)"),
        run.frequencies[0],
        bench.base.frequencies[0],
        tolerance,
    );
    findings.within(
        &format!("{prefix}reduced against full model"),
        run.model.facts.penalty_error,
        1e-4,
    );
    Ok(())
}

fn pinched(bench: &Bench, how: Pinch) -> Result<Findings> {
    let run = bench.run_on_changed(|structure, _| pinch(structure, how))??;
    let mut findings = Findings::default();
    like_the_sound_mesh(&mut findings, "", bench, &run, 2e-3)?;
    findings.outcome = format!(
        "converged, {:.4} Hz instead of {:.4} Hz",
        run.frequencies[0], bench.base.frequencies[0]
    );
    Ok(findings)
}

/// The nodes of the pairs of a beam, of its top and of its bottom body.
fn pairs(bodies: &mut MeshedBodies) -> Result<[&mut Vec<u32>; 2]> {
    match &mut bodies.sides {
        Sides::Pairs { top, bottom } => Ok([top, bottom]),
        Sides::Projected(_) => bail!("the meshes of a beam's sides match"),
    }
}

fn nearly_coincident(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let close = bench.run_on_changed(|structure, _| pinch(structure, Pinch::Line(1e-9)))??;
    like_the_sound_mesh(&mut findings, "a billionth, ", bench, &close, 2e-3)?;
    let apart = |distance: f64| {
        bench.run_on_changed(|structure, _| {
            let bodies = meshed(structure)?;
            let [_, bottom] = pairs(bodies)?;
            let node = bottom[0] as usize;
            bodies.assembly.mesh.nodes[node][2] -= distance;
            Ok(())
        })
    };
    let within = apart(1e-9)??;
    like_the_sound_mesh(&mut findings, "pair 1e-9 m apart, ", bench, &within, 1e-6)?;
    let refusal = Refusal {
        place: "interface pair 0",
        value: "1.000e-4 m apart",
        remedy: "pair coinciding nodes",
    };
    findings.refused("pair 1e-4 m apart, ", apart(1e-4)?, &refusal);
    findings.outcome = format!("converged, {:.4} Hz; then {}", close.frequencies[0], findings.outcome);
    Ok(findings)
}

fn inverted_quad(bench: &Bench) -> Result<Findings> {
    let outcome = bench.run_on_changed(|structure, _| {
        if let Some(element) = structure.joint.interface.elements.get_mut(3) {
            element.nodes_mut().reverse();
        }
        Ok(())
    })?;
    let mut findings = Findings::default();
    let refusal = Refusal {
        place: "interface element 3",
        value: "m^2 at point",
        remedy: "order its nodes counter-clockwise",
    };
    findings.refused("", outcome, &refusal);
    Ok(findings)
}

fn inverted_hexahedron(bench: &Bench) -> Result<Findings> {
    let outcome = bench.run_on_changed(|structure, _| pinch(structure, Pinch::Line(-0.5)))?;
    let mut findings = Findings::default();
    let refusal = Refusal {
        place: "element ",
        value: "m^3 at integration point",
        remedy: "check the node order",
    };
    findings.refused("", outcome, &refusal);
    Ok(findings)
}

fn quadratic(bench: &Bench) -> Result<Findings> {
    let scene = bench.changed(|scene| {
        (scene.model.element_order, scene.model.refinement) = (Some(ElementOrder::Quadratic), RefinementLevel::Quick);
        scene.model.symmetry = Symmetry::Half;
        scene.interfaces.points_per_direction = 3;
    });
    let sound = bench.run_scene(&scene)?;
    let run = |structure: &Structure| {
        let prepared = Prepared::try_new(&scene, structure, &Options::default(), &Silent);
        prepared.and_then(|prepared| prepared.solve(&Silent))
    };
    let mut findings = Findings::default();

    // Middles of edges keep the middle.
    let mut needles = Structure::try_new(&scene, &Silent)?;
    let [edge, middle, corner, next_middle, beyond] = columns(&needles);
    let narrow = edge + 1e-3 * (corner - edge);
    move_column(&mut needles, middle, 0.5 * (edge + narrow), None)?;
    move_column(&mut needles, corner, narrow, None)?;
    move_column(&mut needles, next_middle, 0.5 * (narrow + beyond), None)?;
    let found = run(&needles)?;
    findings.sound("", &found)?;
    let name = "first frequency (Hz)";
    findings.equal(name, found.frequencies[0], sound.frequencies[0], 2e-3);

    let mut folded = Structure::try_new(&scene, &Silent)?;
    move_column(&mut folded, middle, corner, None)?;
    let refusal = Refusal {
        place: "element ",
        value: "m^3 at integration point",
        remedy: "check the node order",
    };
    findings.refused("middle in a corner: ", run(&folded), &refusal);
    findings.outcome = format!(
        "converged, {:.4} Hz instead of {:.4} Hz; refused",
        found.frequencies[0], sound.frequencies[0]
    );
    Ok(findings)
}

fn duplicates(bench: &Bench) -> Result<Findings> {
    let mut findings = Findings::default();
    let twice = bench.run_on_changed(|structure, _| {
        let interface = &mut structure.joint.interface;
        // One element gets a node of its own in the place of one that it shared.
        let copy = interface.nodes.len() as u32;
        let Some(element) = interface.elements.get_mut(3) else {
            return Ok(());
        };
        let original = std::mem::replace(&mut element.nodes_mut()[0], copy) as usize;
        let place = interface.nodes[original];
        interface.nodes.push(place);
        let bodies = meshed(structure)?;
        for side in pairs(bodies)? {
            side.push(side[original]);
        }
        Ok(())
    })?;
    let refusal = Refusal {
        place: "interface pair ",
        value: "stands in an earlier pair",
        remedy: "merge coinciding nodes",
    };
    findings.refused("a pair twice, ", twice, &refusal);
    let first = std::mem::take(&mut findings.outcome);
    let mut copy = 0;
    let loose = bench.run_on_changed(|structure, _| {
        let mesh = &mut meshed(structure)?.assembly.mesh;
        copy = mesh.nodes.len();
        mesh.nodes.push(mesh.nodes[0]);
        Ok(())
    })?;
    let refusal = Refusal {
        place: &format!("node {copy}"),
        value: "belongs to no element",
        remedy: "remove it from the mesh",
    };
    findings.refused("a loose node, ", loose, &refusal);
    findings.outcome = format!("{first}; then {}", findings.outcome);
    Ok(findings)
}

fn unconnected(bench: &Bench) -> Result<Findings> {
    let outcome = bench.run_on_changed(|structure, _| {
        let mesh = &mut meshed(structure)?.assembly.mesh;
        let first = mesh.nodes.len() as u32;
        let formulation = mesh.elements.first().context("no elements")?.cell.formulation();
        for z in [0.0, 0.01] {
            for [x, y] in [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]] {
                mesh.nodes.push([x, y + 0.2, z]);
            }
        }
        mesh.elements.push(Solid {
            cell: Cell::hex8(std::array::from_fn(|i| first + i as u32), formulation),
            material: 0,
        });
        Ok(())
    })?;
    let mut findings = Findings::default();
    let refusal = Refusal {
        place: "with the interface stuck",
        value: "12 zero-energy modes, but 6",
        remedy: "unconnected part",
    };
    findings.refused("", outcome, &refusal);
    Ok(findings)
}

fn incompressible(bench: &Bench) -> Result<Findings> {
    let with = |ratio: f64, formulation: Formulation| -> Result<Run, Error> {
        bench.run(|scene| {
            let material = scene.model.material.iter_mut();
            material.for_each(|material| material.poisson_ratio = ratio);
            scene.model.formulation = Some(formulation);
        })
    };
    let mut findings = Findings::default();
    let modes = with(0.4999, Formulation::IncompatibleModes)?;
    findings.sound("", &modes)?;
    let (near, b_bar) = (
        with(0.49, Formulation::IncompatibleModes)?,
        with(0.4999, Formulation::BBar)?,
    );
    let full = with(0.4999, Formulation::Full)?;
    let first = |run: &Run| run.frequencies[0];
    findings.equal("as with 0.49", first(&modes), first(&near), 0.03);
    findings.equal("as with B-bar", first(&modes), first(&b_bar), 0.03);
    let nearer = with(0.499_999, Formulation::BBar)?;
    findings.sound("0.499999, ", &nearer)?;
    findings.equal(
        "0.499999, as with 0.4999, both by B-bar",
        first(&nearer),
        first(&b_bar),
        0.01,
    );
    // Incompatible modes are too stiff there, and the run says so.
    let locked = with(0.499_999, Formulation::IncompatibleModes)?;
    findings.between(
        "0.499999, incompatible modes over B-bar",
        first(&locked) / first(&nearer),
        1.0,
        1.1,
    );
    let is_warned = |run: &Run| {
        run.warnings
            .iter()
            .any(|warning| warning.kind == WarningKind::PoissonRatio)
    };
    findings.that(
        "a warning with 0.499999, none with 0.4999",
        is_warned(&locked) && !is_warned(&modes),
    );
    findings.between(
        "full integration over incompatible modes",
        first(&full) / first(&modes),
        1.02,
        10.0,
    );
    findings.outcome = format!(
        "converged, {:.3} Hz ({:.3} Hz with 0.49, {:.3} Hz by B-bar, {:.3} Hz by full integration)",
        first(&modes),
        first(&near),
        first(&b_bar),
        first(&full)
    );
    Ok(findings)
}
