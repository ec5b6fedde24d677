//! Hysteresis loops of the interface elements, and the elements that a scene asks for them.

use crate::Error;
use joint_model::significant;
use scenes::{Analyses, InterfacePlace, Length};
use serde::{Deserialize, Serialize};
use zte_assembly::{InterfaceMesh, Operators, Workspace};

/// Most bytes that the loops of all elements may take in a run. Above it those of the scene's `analyses.backbone.loops_at` alone are recorded.
pub const MOST_RECORDED: usize = 100_000_000;

/// Motion and traction of interface elements along a loop, as means over the area of each element.
///
/// Numbers are of double precision: jumps contain the prestress, beside which single precision would lose the motion of small
/// amplitudes. A vertex takes 48 bytes per element. An interface of 2352 elements with 16 vertices per quarter takes 7.3 MB per
/// amplitude, and 29 MB for the four amplitudes that are stored by default; [`MOST_RECORDED`] is the limit of a run. A checkpoint holds them as
/// text of about three times that size.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ElementLoops {
    /// The elements recorded, ascending: all of the interface, or those of `analyses.backbone.loops_at`.
    pub elements: Vec<usize>,
    /// Modal force (sqrt(kg) m/s^2) at each vertex of the loop, in the order of the motion. The first and the last vertex are at the
    /// positive peak.
    pub modal_force: Vec<f64>,
    /// Jump x, y, interference n (m): `[component][vertex * elements.len() + place in elements]`.
    pub jump: [Vec<f64>; 3],
    /// Traction x, y, n (Pa), in the same order.
    pub traction: [Vec<f64>; 3],
}

impl ElementLoops {
    /// A loop of these elements, ascending, without vertices.
    pub(super) fn new(elements: &[usize]) -> Self {
        Self {
            elements: elements.to_vec(),
            ..Self::default()
        }
    }

    /// Adds the vertex whose fields an evaluation has left in the workspace.
    pub(super) fn add(&mut self, operators: &Operators, modal_force: f64, workspace: &Workspace) {
        self.modal_force.push(modal_force);
        let records = self.jump.iter_mut().chain(&mut self.traction);
        for (record, field) in records.zip(workspace.jump.iter().chain(&workspace.traction)) {
            let means = self
                .elements
                .iter()
                .map(|&element| operators.element_mean(element, field));
            record.extend(means);
        }
    }

    /// Jump x, y, n (m) and traction x, y, n (Pa) of an element at each vertex; none of an element that is not recorded.
    pub fn of_element(&self, element: usize) -> Option<impl Iterator<Item = ([f64; 3], [f64; 3])>> {
        let place = self.elements.binary_search(&element).ok()?;
        let at = move |vertex: usize| {
            let index = vertex * self.elements.len() + place;
            let of = |record: &[Vec<f64>; 3]| record.each_ref().map(|component| component[index]);
            (of(&self.jump), of(&self.traction))
        };
        Some((0..self.modal_force.len()).map(at))
    }
}

/// The elements whose loops are recorded, ascending: all `n_elements` where a run has room for them at `stored` amplitudes of each
/// mode, otherwise those `asked_for`.
pub(super) fn recorded(analyses: &Analyses, stored: usize, n_elements: usize, asked_for: &[usize]) -> Vec<usize> {
    let vertices = 4 * analyses.backbone.vertices_per_quarter + 1;
    let loops = stored * analyses.modes.followed.len();
    let bytes = [vertices, loops, 6 * size_of::<f64>()].into_iter();
    if bytes.fold(n_elements, usize::saturating_mul) <= MOST_RECORDED {
        return (0..n_elements).collect();
    }
    let mut elements = asked_for.to_vec();
    elements.sort_unstable();
    elements
}

/// Centre of each element, the mean of its corners (m): in the coordinates of the model where the `positions` of nodes are known,
/// otherwise in the plane of the interface with the third coordinate zero.
pub fn element_centres(mesh: &InterfaceMesh, positions: Option<&[[f64; 3]]>) -> Vec<[f64; 3]> {
    let centre = |element: usize| {
        let sum = |sum: [f64; 3], x: [f64; 3]| [0, 1, 2].map(|c| sum[c] + x[c]);
        let count = mesh.elements[element].corners().len() as f64;
        corners(mesh, positions, element).fold([0.0; 3], sum).map(|x| x / count)
    };
    (0..mesh.elements.len()).map(centre).collect()
}

fn corners<'a>(
    mesh: &'a InterfaceMesh,
    positions: Option<&'a [[f64; 3]]>,
    element: usize,
) -> impl Iterator<Item = [f64; 3]> + 'a {
    mesh.elements[element].corners().iter().map(move |&node| {
        let [x, y] = mesh.nodes[node as usize];
        positions.map_or([x, y, 0.0], |of| of[node as usize])
    })
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

fn in_words(place: [f64; 3]) -> String {
    format!("[{}]", place.map(significant).join(", "))
}

/// The elements whose centres are nearest to the places, each once, in the order of the places. A centre is no farther than the size of
/// its element: the longest distance between two corners, and for a point of contact the side of a square of its area.
///
/// # Errors
/// [`Error::LoopPlace`] for coordinates of the wrong kind, and for a place that is farther from every element.
pub(super) fn elements_at(
    places: &[InterfacePlace],
    mesh: &InterfaceMesh,
    positions: Option<&[[f64; 3]]>,
) -> Result<Vec<usize>, Error> {
    // Also because a mesh may still turn out to be unsound.
    if places.is_empty() {
        return Ok(Vec::new());
    }
    let centres = element_centres(mesh, positions);
    let size = |element: usize| match mesh.elements[element].contact() {
        Some(contact) => contact.area.sqrt(),
        None => corners(mesh, positions, element)
            .flat_map(|a| corners(mesh, positions, element).map(move |b| distance(a, b)))
            .fold(0.0, f64::max),
    };
    let sizes: Vec<f64> = (0..centres.len()).map(size).collect();
    let mut found = Vec::with_capacity(places.len());
    for (number, place) in (1..).zip(places) {
        let refused = |reason: String| Error::LoopPlace { number, reason };
        let at = match (place, positions) {
            (InterfacePlace::Model(at), Some(_)) => at.map(Length::si),
            (InterfacePlace::Plane([x, y]), None) => [x.si(), y.si(), 0.0],
            (InterfacePlace::Plane(_), Some(_)) => {
                let reason =
                    "the place of the interface in the model is known; give [x, y, z] in the coordinates of the model";
                return Err(refused(reason.into()));
            }
            (InterfacePlace::Model(_), None) => {
                let reason = "the place of the interface in the model is not known; give [x, y] in its plane, as the nodes of the \
                              interface are given";
                return Err(refused(reason.into()));
            }
        };
        let from = |element: &usize| distance(centres[*element], at);
        let nearest = |elements: &mut dyn Iterator<Item = usize>| elements.min_by(|a, b| from(a).total_cmp(&from(b)));
        // A small element may be the nearest to a place on its large neighbour, and too small to reach it.
        let reaching = nearest(&mut (0..centres.len()).filter(|element| from(element) <= sizes[*element]));
        if let Some(element) = reaching {
            if !found.contains(&element) {
                found.push(element);
            }
        } else if let Some(nearest) = nearest(&mut (0..centres.len())) {
            let (away, size) = (from(&nearest), sizes[nearest]);
            return Err(refused(format!(
                "the element nearest to {} m is number {} with its centre at {} m, {away:.3e} m away and not within its size of \
                 {size:.3e} m; give a place on the interface",
                in_words(at),
                nearest + 1,
                in_words(centres[nearest])
            )));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zte_assembly::{Element, PointContact};

    fn plane(at: [f64; 2]) -> InterfacePlace {
        InterfacePlace::Plane(at.map(Length::from_si))
    }

    fn model(at: [f64; 3]) -> InterfacePlace {
        InterfacePlace::Model(at.map(Length::from_si))
    }

    /// Two elements of 20 mm by 10 mm side by side.
    fn mesh() -> InterfaceMesh {
        let nodes = (0..6).map(|i| [0.02 * f64::from(i % 3), 0.01 * f64::from(i / 3)]);
        InterfaceMesh::try_from_lists(nodes.collect(), [[0, 1, 4, 3], [1, 2, 5, 4]]).unwrap()
    }

    #[test]
    fn a_run_records_all_elements_up_to_the_limit_and_those_asked_for_beyond() {
        let asked = |vertices_per_quarter: usize, modes: usize| {
            let mut asked = Analyses::default();
            asked.backbone.vertices_per_quarter = vertices_per_quarter;
            asked.modes.followed = (1..=modes).collect();
            asked
        };
        // 2352 elements with 16 vertices per quarter take 7.3 MB per amplitude.
        for (stored, modes, all) in [(4, 1, true), (13, 1, true), (4, 3, true), (14, 1, false), (7, 2, false)] {
            let found = recorded(&asked(16, modes), stored, 2352, &[7, 3]);
            assert_eq!(found.len() == 2352, all, "{stored} of {modes} modes");
            assert!(all || found == [3, 7]);
        }
        assert!(recorded(&asked(4096, 1), usize::MAX / 2, 2352, &[]).is_empty());
    }

    #[test]
    fn places_name_the_nearest_element_and_those_beside_the_interface_are_refused() {
        let mesh = mesh();
        let found = elements_at(
            &[plane([0.025, 0.001]), plane([0.0, 0.0]), plane([0.039, 0.01])],
            &mesh,
            None,
        );
        assert_eq!(found.unwrap(), [1, 0]);
        // In the model it stands upright at x = 1 m.
        let positions: Vec<[f64; 3]> = mesh.nodes.iter().map(|&[x, y]| [1.0, x, y]).collect();
        let at = |place| elements_at(&[model([1.0, 0.01, 0.0]), place], &mesh, Some(&positions));
        assert_eq!(at(model([1.01, 0.03, 0.005])).unwrap(), [0, 1]);
        let centre = element_centres(&mesh, Some(&positions))[1];
        assert!(distance(centre, [1.0, 0.03, 0.005]) < 1e-15);
        let refusal = |place| at(place).unwrap_err().to_string();
        let beside = refusal(model([1.03, 0.03, 0.005]));
        for part in [
            "analyses.backbone.loops_at, number 2",
            "[1.03, 0.03, 0.005] m",
            "number 2",
            "[1, 0.03, 0.005] m",
            "3.000e-2 m away",
            "2.236e-2 m",
        ] {
            assert!(beside.contains(part), "{part} is not in {beside}");
        }
        assert!(refusal(plane([0.0, 0.0])).contains("give [x, y, z]"));
        let unplaced = elements_at(&[model([0.0; 3])], &mesh, None).unwrap_err();
        assert!(unplaced.to_string().contains("give [x, y] in its plane"));
        assert!(elements_at(&[plane([f64::NAN, 0.0])], &mesh, None).is_err());
    }

    #[test]
    fn a_place_on_a_large_element_beside_a_small_one_is_found() {
        // 1 mm wide and 20 mm wide.
        let nodes = [
            [0.0, 0.0],
            [0.001, 0.0],
            [0.021, 0.0],
            [0.0, 0.001],
            [0.001, 0.001],
            [0.021, 0.001],
        ];
        let mesh = InterfaceMesh::try_from_lists(nodes.to_vec(), [[0, 1, 4, 3], [1, 2, 5, 4]]).unwrap();
        assert_eq!(elements_at(&[plane([0.004, 0.0005])], &mesh, None).unwrap(), [1]);
    }

    #[test]
    fn points_of_contact_reach_as_far_as_a_square_of_their_area() {
        let contact = PointContact {
            area: 1e-4,
            held: [false; 3],
        };
        let points = InterfaceMesh::flat(vec![[0.0, 0.0]], vec![Element::point(0, contact)]);
        assert_eq!(elements_at(&[plane([0.0, 0.0099])], &points, None).unwrap(), [0]);
        assert!(elements_at(&[plane([0.0, 0.0101])], &points, None).is_err());
    }
}
