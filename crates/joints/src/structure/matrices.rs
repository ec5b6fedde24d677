//! Structures that come as matrices of other programs.

use super::excited::require_held;
use super::matrix_contents::{Contents, File, ROUND_OFF};
use crate::Error;
use faer::Mat;
use finite_elements::sparse::{multiply_vector, submatrix};
use joint_model::fit::Fit;
use joint_model::{Bodies, ExcitedRow, ImportedBodies, Joint};
use matrix_files::value::Dof;
use reduction::{RelativeSystem, SystemMatrices};
use scenes::{
    BoltBehaviour, Bolts, ContactPoint, Coordinates, Excitation, Length, Matrices, MatrixVector, Scene, Sides,
};
use sprs::CsMat;
use std::borrow::Cow;
use std::collections::HashMap;
use zte_assembly::{Element, InterfaceMesh, PointContact};

/// Relative difference of the masses that a structure shows along the three axes, up to which it has one mass.
const SAME_MASS: f64 = 1e-3;

/// Most coordinates that a damping matrix may act on: its eigenpairs are found at once.
const MOST_DAMPED: usize = 2000;

/// Most bolts of a structure whose bolts the scene does not name: each load is a vector over all coordinates.
const MOST_BOLTS: usize = 1000;

/// Reads the matrices that a scene names, with the loads that its `bolts` need.
///
/// # Errors
/// Of the files; [`Error::Matrices`] for what does not fit together; of the change of coordinates.
pub(super) fn joint(source: &Matrices, scene: &Scene, notes: &mut dyn FnMut(&str)) -> Result<Joint, Error> {
    let file = File { path: &source.path };
    let mut contents = file.contents(notes)?;
    let (length, unit_mass) = (source.units.length_in_si(), source.units.mass_in_si());
    let place: HashMap<Dof, usize> = contents.dofs.iter().zip(0..).map(|(&dof, row)| (dof, row)).collect();
    if place.len() < contents.dofs.len() {
        return Err(file.fail("its map of degrees of freedom names one twice"));
    }
    // In coordinates of the dimension of length, matrices carry the unit of mass alone, and responses and loads of unit
    // tension none.
    let scaled = |matrix: Option<CsMat<f64>>, what| -> Result<CsMat<f64>, Error> {
        let matrix = matrix.ok_or_else(|| file.fail(&format!("it has no {what}")))?;
        Ok(file.symmetric(matrix, what)?.map(|value| value * unit_mass))
    };
    let (stiffness, mass) = (
        scaled(contents.stiffness.take(), "stiffness K")?,
        scaled(contents.mass.take(), "mass M")?,
    );
    let damping = contents.damping.take();
    let damping = damping.map(|damping| scaled(Some(damping), "damping C")).transpose()?;
    let n = stiffness.rows();
    file.check_sizes(&contents, n, mass.rows(), damping.as_ref().map(CsMat::rows))?;
    let vectors = Vectors {
        file: &file,
        contents: &contents,
        place: &place,
    };
    let interface = match &source.points {
        Some(points) => vectors.points(points, &source.coordinates)?,
        None => {
            let plane = source.interface.clone().or_else(|| contents.mesh.clone());
            let plane = plane.ok_or_else(|| {
                file.fail("it has no interface mesh: give structure.matrices.interface, or points of contact as structure.matrices.points")
            })?;
            plane
                .interface(length)
                .map_err(|error| file.fail(&format!("its interface mesh, counted from 0: {error}")))?
        }
    };
    let n_nodes = interface.nodes.len();
    let (loads, response) = (
        vectors.loads(source.bolts.as_deref(), &scene.bolts)?,
        vectors.response(&source.response)?,
    );
    let system = SystemMatrices {
        stiffness: &stiffness,
        mass: &mass,
        loads: &loads,
        positions: &vec![[0.0; 3]; n],
    };
    let rows_of = |labels: &mut dyn Iterator<Item = u64>| {
        labels
            .flat_map(|node| (1..=3).map(move |component| Dof::Nodal { node, component }))
            .map(|dof| vectors.row(dof))
            .collect::<Result<Vec<usize>, Error>>()
    };
    let (relative, frame) = match &source.coordinates {
        Coordinates::Jump => {
            let jump: Vec<Option<usize>> = match &source.points {
                Some(points) => vectors.jump_of(points),
                None => rows_of(&mut (1..=n_nodes as u64))?.into_iter().map(Some).collect(),
            };
            let relative = match &contents.lift {
                None => RelativeSystem::from_relative(system, &jump)?,
                Some(lift) => {
                    // Points that lack a component were refused.
                    let jump: Vec<usize> = jump.into_iter().flatten().collect();
                    let column: Vec<Option<usize>> = (0..n).map(Some).collect();
                    RelativeSystem::from_combinations(system, &submatrix(lift, &jump, &column, n))?
                }
            };
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            (relative, contents.frame.unwrap_or(axes))
        }
        Coordinates::BothSides(sides) => {
            let sides = match &source.points {
                Some(points) => Cow::Owned(vectors.sides_of(points, sides)?),
                None => Cow::Borrowed(sides),
            };
            if contents.lift.is_some() {
                return Err(file.fail("L is read with `coordinates: \"jump\"` only"));
            }
            for (side, labels) in [("top", &sides.top), ("bottom", &sides.bottom)] {
                if labels.len() != n_nodes {
                    let found = labels.len();
                    return Err(file.fail(&format!(
                        "the {side} side names {found} nodes, but the interface mesh has {n_nodes}"
                    )));
                }
            }
            let top = rows_of(&mut sides.top.iter().copied())?;
            let bottom = rows_of(&mut sides.bottom.iter().copied())?;
            (
                RelativeSystem::from_both_sides(system, &top, &bottom, sides.frame)?,
                sides.frame,
            )
        }
    };
    let is_reduced = source.coordinates == Coordinates::Jump;
    let zero_energy_modes = source.zero_energy_modes.unwrap_or(if is_reduced { 0 } else { 6 });
    let mut excitations = Vec::new();
    for driver in scene.analyses.drivers() {
        let force = |row: Vec<f64>| ExcitedRow {
            row: relative.row(&row),
            carried: None,
        };
        excitations.push(match driver.excitation {
            // Row 0, which is there already.
            Excitation::Response => continue,
            Excitation::Terms(terms) => force(vectors.terms(&terms)?),
            Excitation::Node { node, direction } => force(vectors.at_node(driver.field, &node, direction)?),
            Excitation::Base(base) => {
                require_held(scene, zero_energy_modes)?;
                let motion = match base.direction {
                    Some(direction) => vectors.translation(driver.field, direction, is_reduced)?,
                    None => vectors.coordinates(base.motion.as_deref().unwrap_or_default())?,
                };
                ExcitedRow {
                    row: relative.row(&multiply_vector(&mass, &motion)),
                    carried: Some(response.iter().zip(&motion).map(|(a, b)| a * b).sum()),
                }
            }
        });
    }
    let bodies = ImportedBodies {
        response: relative.row(&response),
        excitations,
        dampers: match &damping {
            Some(damping) => {
                let rows = dampers(&file, damping, &contents)?;
                rows.iter().map(|row| relative.row(row)).collect()
            }
            None => Vec::new(),
        },
        relative,
        is_reduced,
        zero_energy_modes,
        mass: if is_reduced {
            None
        } else {
            translated_mass(&contents.dofs, &mass)
        },
    };
    Ok(Joint {
        bodies: Bodies::Imported(bodies),
        interface,
        frame,
        node_frames: Vec::new(),
        parts: Vec::new(),
        positions: None,
        clearance: source.bolt_hole_clearance.map(Length::si),
        response: match &source.response {
            MatrixVector::Number(number) => format!("response {number} of the matrices"),
            MatrixVector::LoadCase(name) => format!("load case {name}"),
            MatrixVector::Terms(_) => "response by terms".into(),
        },
        fit: Fit::default(),
    })
}

/// Rows whose outer products sum to a damping matrix.
fn dampers(file: &File<'_>, damping: &CsMat<f64>, contents: &Contents) -> Result<Vec<Vec<f64>>, Error> {
    let damped: Vec<usize> = (damping.outer_iterator().enumerate())
        .filter(|(_, row)| row.iter().any(|(_, value)| *value != 0.0))
        .map(|(row, _)| row)
        .collect();
    if damped.len() > MOST_DAMPED {
        return Err(file.fail(&format!(
            "its damping C acts on {} coordinates, and at most {MOST_DAMPED} can be: leave out what is proportional to mass and stiffness, and give it as \
             analyses.forced.rayleigh or background_damping",
            damped.len()
        )));
    }
    let mut own = Mat::zeros(damped.len(), damped.len());
    for (i, &row) in damped.iter().enumerate() {
        for (column, &value) in damping.outer_view(row).iter().flat_map(|row| row.iter()) {
            if let Ok(j) = damped.binary_search(&column) {
                own[(i, j)] = value;
            }
        }
    }
    let factor = dense_algebra::semidefinite_factor(own.as_ref(), ROUND_OFF).map_err(|error| match error {
        dense_algebra::Error::NotSemidefinite { coordinate, .. } => {
            let row = damped[coordinate];
            let dof = contents.lift.is_none().then(|| contents.dofs.get(row)).flatten();
            let place = match dof {
                Some(dof) => format!("component {} of {}", dof.component(), dof.label()),
                None => format!("coordinate {}", row + 1),
            };
            file.fail(&format!(
                "its damping C is not positive semi-definite, so that some motions would gain energy; look at {place}"
            ))
        }
        other => file.fail(&format!("its damping C: {other}")),
    })?;
    let row = |column: usize| {
        let mut row = vec![0.0; damping.rows()];
        damped
            .iter()
            .enumerate()
            .for_each(|(i, &at)| row[at] = factor[(i, column)]);
        row
    };
    Ok((0..factor.ncols()).map(row).collect())
}

/// Vectors over the coordinates of the matrices.
struct Vectors<'a> {
    file: &'a File<'a>,
    contents: &'a Contents,
    place: &'a HashMap<Dof, usize>,
}

impl Vectors<'_> {
    fn row(&self, dof: Dof) -> Result<usize, Error> {
        let (label, component) = (dof.label(), dof.component());
        self.place.get(&dof).copied().ok_or_else(|| {
            self.file.fail(&format!(
                "component {component} of {label} is not in its map of degrees of freedom; it must be free and retained"
            ))
        })
    }

    /// Mesh of points of contact, in their order. Over the jump, components that the matrices lack are held.
    fn points(&self, points: &[ContactPoint], coordinates: &Coordinates) -> Result<InterfaceMesh, Error> {
        let mut number_of = HashMap::with_capacity(points.len());
        let mut elements = Vec::with_capacity(points.len());
        for (index, point) in points.iter().enumerate() {
            let number = index + 1;
            if let Some(first) = number_of.insert(point.node, number) {
                return Err(self.file.fail(&format!(
                    "points of contact {first} and {number} are both at node {}; give one point per node, with the area of both",
                    point.node
                )));
            }
            let held = match coordinates {
                Coordinates::Jump => self.components(point).map(|row| row.is_none()),
                Coordinates::BothSides(_) => [false; 3],
            };
            if held == [true; 3] {
                return Err(self.file.fail(&format!(
                    "point of contact {number} is at node {}, which is not in its map of degrees of freedom",
                    point.node
                )));
            }
            if held != [false; 3] && self.contents.lift.is_some() {
                return Err(self.file.fail(&format!(
                    "node {} of point of contact {number} lacks a component among the rows of L; add it",
                    point.node
                )));
            }
            let area = point.area.si();
            elements.push(Element::point(index as u32, PointContact { area, held }));
        }
        let mesh = InterfaceMesh::flat(
            points.iter().map(|point| point.position.map(Length::si)).collect(),
            elements,
        );
        mesh.validate().map_err(|error| {
            self.file
                .fail(&format!("its points of contact, counted from 0: {error}"))
        })?;
        Ok(mesh)
    }

    /// Rows of the components at the node of a point of contact; none for one that the matrices do not have.
    fn components(&self, point: &ContactPoint) -> [Option<usize>; 3] {
        let row = |component| {
            let dof = Dof::Nodal {
                node: point.node,
                component,
            };
            self.place.get(&dof).copied()
        };
        [1, 2, 3].map(row)
    }

    /// The jump at points of contact: three rows each.
    fn jump_of(&self, points: &[ContactPoint]) -> Vec<Option<usize>> {
        points.iter().flat_map(|point| self.components(point)).collect()
    }

    /// The sides in the order of the points of contact, which name the nodes of the top one.
    fn sides_of(&self, points: &[ContactPoint], sides: &Sides) -> Result<Sides, Error> {
        let mut bottom_of: HashMap<u64, u64> = sides.top.iter().copied().zip(sides.bottom.iter().copied()).collect();
        let found = [sides.top.len(), sides.bottom.len()];
        if found != [bottom_of.len(); 2] {
            return Err(self.file.fail(&format!(
                "the top side names {} nodes, of which {} differ, and the bottom side {}; give pairs of nodes, each once",
                found[0],
                bottom_of.len(),
                found[1]
            )));
        }
        let top: Vec<u64> = points.iter().map(|point| point.node).collect();
        let other = |(number, node): (usize, &u64)| {
            bottom_of.remove(node).ok_or_else(|| {
                self.file.fail(&format!(
                    "point of contact {number} is at node {node}, which faces no other: name it among the top nodes, and the one \
                     that faces it among the bottom nodes"
                ))
            })
        };
        let bottom = (1..).zip(&top).map(other).collect::<Result<Vec<u64>, Error>>()?;
        if let Some(node) = bottom_of.keys().min() {
            return Err(self.file.fail(&format!(
                "top node {node} has no point of contact; add one, or leave the node out of the sides"
            )));
        }
        let frame = sides.frame;
        Ok(Sides { top, bottom, frame })
    }

    /// Loads of unit tension: those that are named, or all of the file unless bolts without tension do nothing.
    fn loads(&self, named: Option<&[MatrixVector]>, bolts: &Bolts) -> Result<Vec<Vec<f64>>, Error> {
        let contents = self.contents;
        let is_idle = bolts.load.si() == 0.0 && bolts.behaviour == BoltBehaviour::DeadLoad;
        if is_idle && named.is_none() {
            return Ok(Vec::new());
        }
        let loads = match named {
            Some(bolts) => bolts
                .iter()
                .map(|bolt| match bolt {
                    MatrixVector::Number(number) => self.numbered("load", contents.loads.as_ref(), *number),
                    MatrixVector::LoadCase(name) => contents.load_cases.get(name).cloned().ok_or_else(|| {
                        let known: Vec<&str> = contents.load_cases.keys().map(String::as_str).collect();
                        self.file
                            .fail(&format!("it has no load case `{name}`; it has: {}", known.join(", ")))
                    }),
                    MatrixVector::Terms(terms) => self.terms(terms),
                })
                .collect::<Result<Vec<_>, _>>()?,
            None => {
                let numbered = contents.loads.as_ref().map_or(0, CsMat::rows);
                let found = numbered + contents.load_cases.len();
                if found > MOST_BOLTS {
                    return Err(self.file.fail(&format!(
                        "it has {found} loads, and at most {MOST_BOLTS} are taken for bolts: name those of the bolts as \
                         structure.matrices.bolts"
                    )));
                }
                let rows = contents.loads.iter().flat_map(|loads| loads.outer_iterator());
                let cases = contents.load_cases.values().cloned();
                rows.map(|row| row.to_dense().to_vec()).chain(cases).collect()
            }
        };
        if loads.is_empty() {
            return Err(self
                .file
                .fail("it has no bolt loads: name them as structure.matrices.bolts"));
        }
        Ok(loads)
    }

    fn response(&self, response: &MatrixVector) -> Result<Vec<f64>, Error> {
        match response {
            MatrixVector::Number(number) => {
                self.numbered("row of the recovery R", self.contents.recovery.as_ref(), *number)
            }
            MatrixVector::Terms(terms) => self.terms(terms),
            MatrixVector::LoadCase(name) => Err(self.file.fail(&format!(
                "the response cannot be the load case `{name}`; give a number or terms as structure.matrices.response"
            ))),
        }
    }

    /// What a force at a node that `field` names acts on.
    fn at_node(&self, field: &str, node: &str, direction: [f64; 3]) -> Result<Vec<f64>, Error> {
        let label: i64 = node.parse().map_err(|_| {
            self.file.fail(&format!(
                "{field} = \"{node}\" is no label of a node; give a whole number as text"
            ))
        })?;
        let terms: Vec<(i64, u32, f64)> = (1..)
            .zip(direction)
            .filter(|(_, d)| *d != 0.0)
            .map(|(c, d)| (label, c, d))
            .collect();
        self.terms(&terms)
    }

    /// A translation of everything that the coordinates show.
    fn translation(&self, field: &str, direction: [f64; 3], over_jump: bool) -> Result<Vec<f64>, Error> {
        if over_jump || self.contents.lift.is_some() {
            return Err(self.file.fail(&format!(
                "{field} needs to know how its coordinates move when everything moves by one, and coordinates over the jump do not show it; give that as \
                 `motion` in the place of `direction`, or the matrices over both sides"
            )));
        }
        let along = |dof: &Dof| {
            match (*dof, dof.component()) {
            (Dof::Nodal { .. }, component @ 1..=3) => Ok(direction[component as usize - 1]),
            (Dof::Nodal { .. }, 4..=6) => Ok(0.0),
            (_, component) => Err(self.file.fail(&format!(
                "{field} needs to know how its coordinates move when everything moves by one, and {} component {component} is no displacement or \
                 rotation of a node; give that as `motion` in the place of `direction`",
                dof.label()
            ))),
        }
        };
        self.contents.dofs.iter().map(along).collect()
    }

    /// One row of a matrix whose columns were compared with the coordinates.
    fn numbered(&self, what: &str, of: Option<&CsMat<f64>>, number: usize) -> Result<Vec<f64>, Error> {
        let found = of.and_then(|of| of.outer_view(number.checked_sub(1)?));
        found.map(|row| row.to_dense().to_vec()).ok_or_else(|| {
            let count = of.map_or(0, CsMat::rows);
            self.file.fail(&format!(
                "it has no {what} number {number} (there are {count}); give another number, or terms"
            ))
        })
    }

    /// A motion of the coordinates.
    fn coordinates(&self, terms: &[(i64, u32, f64)]) -> Result<Vec<f64>, Error> {
        if self.contents.lift.is_some() {
            return Err(self
                .file
                .fail("a motion of the base is not read with L; give the load as terms of a force"));
        }
        self.of_terms(terms)
    }

    /// A vector over `dofs`.
    fn of_terms(&self, terms: &[(i64, u32, f64)]) -> Result<Vec<f64>, Error> {
        let mut vector = vec![0.0; self.contents.dofs.len()];
        for &(label, component, factor) in terms {
            vector[self.row(Dof::new(label, component))?] += factor;
        }
        Ok(vector)
    }

    /// A row over the coordinates.
    fn terms(&self, terms: &[(i64, u32, f64)]) -> Result<Vec<f64>, Error> {
        let vector = self.of_terms(terms)?;
        Ok(match &self.contents.lift {
            None => vector,
            Some(lift) => multiply_vector(&lift.transpose_view().to_csr(), &vector),
        })
    }
}

/// Total mass as seen by translations along the three axes; `None` if they disagree.
fn translated_mass(dofs: &[Dof], mass: &CsMat<f64>) -> Option<f64> {
    let masses = [1, 2, 3].map(|along| {
        let moves = |row: usize| matches!(dofs[row], Dof::Nodal { component, .. } if component == along);
        let terms = mass.iter().filter(|(_, (i, j))| moves(*i) && moves(*j));
        terms.map(|(value, _)| *value).sum::<f64>()
    });
    let mean = masses.iter().sum::<f64>() / 3.0;
    let same = |m: &f64| (m - mean).abs() <= SAME_MASS * mean;
    masses.iter().all(same).then_some(mean)
}
