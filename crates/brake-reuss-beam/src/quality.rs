//! Measures of meshes of hexahedra: volume, mass, Jacobian determinants, connected components.
use finite_elements::elements::CORNERS;
use finite_elements::mesh::{Element, Mesh};

/// Determinant of the map from the reference cube (edge 2) at the local coordinates `xi`.
fn jacobian_determinant(mesh: &Mesh, element: &Element, xi: [f64; 3]) -> f64 {
    let row = element.cell.element_type();
    assert!(row.nodes.starts_with(&CORNERS), "not a hexahedron");
    let (_, derivatives) = row.shape_functions(xi);
    let mut jacobian = [[0.0; 3]; 3];
    for (derivative, &node) in derivatives.iter().zip(element.cell.nodes()) {
        let point = mesh.nodes[node as usize];
        for a in 0..3 {
            for b in 0..3 {
                jacobian[a][b] += derivative[a] * point[b];
            }
        }
    }
    let [r, s, t] = jacobian;
    r[0] * (s[1] * t[2] - s[2] * t[1]) - r[1] * (s[0] * t[2] - s[2] * t[0]) + r[2] * (s[0] * t[1] - s[1] * t[0])
}

/// Gauss points with their weights: two per direction for linear elements, three for quadratic ones.
fn gauss_points(element: &Element) -> impl Iterator<Item = ([f64; 3], f64)> {
    let line: &'static [(f64, f64)] = match element.cell.element_type().middles {
        [] => &[(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)],
        _ => &[
            (-0.774_596_669_241_483_4, 5.0 / 9.0),
            (0.0, 8.0 / 9.0),
            (0.774_596_669_241_483_4, 5.0 / 9.0),
        ],
    };
    let pairs = line.iter().flat_map(move |a| line.iter().map(move |b| (a, b)));
    pairs.flat_map(move |(a, b)| line.iter().map(move |c| ([a.0, b.0, c.0], a.1 * b.1 * c.1)))
}

/// Volume of one element (m^3). The points integrate the map exactly: the determinant is of degree 2 along each coordinate in linear
/// elements, of degree 5 in quadratic ones.
///
/// # Panics
/// If the element is no hexahedron or refers to nodes that the mesh does not have.
pub fn element_volume(mesh: &Mesh, element: &Element) -> f64 {
    gauss_points(element)
        .map(|(xi, weight)| weight * jacobian_determinant(mesh, element, xi))
        .sum()
}

/// Volume of a set of elements of the mesh (m^3).
///
/// # Panics
/// If an element is no hexahedron or refers to nodes that the mesh does not have.
pub fn volume(mesh: &Mesh, elements: &[Element]) -> f64 {
    elements.iter().map(|element| element_volume(mesh, element)).sum()
}

/// Mass of the mesh (kg).
///
/// # Panics
/// If an element is no hexahedron or refers to nodes or materials that the mesh does not have.
pub fn mass(mesh: &Mesh) -> f64 {
    let density = |element: &Element| mesh.materials[usize::from(element.material)].density;
    mesh.elements
        .iter()
        .map(|element| density(element) * element_volume(mesh, element))
        .sum()
}

/// Least Jacobian determinant of an element over its nodes and its Gauss points (2 x 2 x 2, or 3 x 3 x 3 of quadratic elements) (m^3),
/// for a reference cube of edge 2.
///
/// # Panics
/// If the element is no hexahedron or refers to nodes that the mesh does not have.
pub fn least_jacobian_determinant(mesh: &Mesh, element: &Element) -> f64 {
    let nodes = element.cell.element_type().nodes.iter().copied();
    nodes
        .chain(gauss_points(element).map(|(xi, _)| xi))
        .map(|xi| jacobian_determinant(mesh, element, xi))
        // Unlike `f64::min`, this keeps NaN.
        .fold(f64::INFINITY, |least, value| {
            if value < least || value.is_nan() { value } else { least }
        })
}

/// Least scaled Jacobian of an element over its corners: the triple product of the unit edges that meet there, 1 for
/// a brick and 0 for a degenerate corner (-).
///
/// # Panics
/// If the element is no hexahedron or refers to nodes that the mesh does not have.
pub fn scaled_jacobian(mesh: &Mesh, element: &Element) -> f64 {
    let at = |local: usize| mesh.nodes[element.cell.nodes()[local] as usize];
    CORNERS
        .iter()
        .enumerate()
        .map(|(corner, xi)| {
            let top = corner / 4 * 4;
            let place = corner % 4;
            // Neighbours along the three local axes: mirrored in xi, eta and zeta.
            let neighbours = [top + [1, 0, 3, 2][place], top + [3, 2, 1, 0][place], (corner + 4) % 8];
            let edges = neighbours.map(|n| [0, 1, 2].map(|c| at(n)[c] - at(corner)[c]));
            let lengths = edges.map(|e| e.iter().map(|c| c * c).sum::<f64>().sqrt());
            let [r, s, t] = edges;
            let triple = r[0] * (s[1] * t[2] - s[2] * t[1]) - r[1] * (s[0] * t[2] - s[2] * t[0])
                + r[2] * (s[0] * t[1] - s[1] * t[0]);
            // Each edge that points towards negative local coordinates turns the sign once.
            -triple * xi.iter().product::<f64>() / lengths.iter().product::<f64>()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Number of the connected component of each node, from 0 on in the order of the nodes, and the number of components.
/// Nodes of one element are connected; ties and couplings are not looked at.
///
/// # Panics
/// If an element refers to nodes that the mesh does not have.
pub fn connected_components(mesh: &Mesh) -> (Vec<usize>, usize) {
    let mut parent: Vec<usize> = (0..mesh.nodes.len()).collect();
    fn root(parent: &mut [usize], mut node: usize) -> usize {
        while parent[node] != node {
            parent[node] = parent[parent[node]];
            node = parent[node];
        }
        node
    }
    for element in &mesh.elements {
        let nodes = element.cell.nodes();
        let first = root(&mut parent, nodes[0] as usize);
        for &node in &nodes[1..] {
            let other = root(&mut parent, node as usize);
            parent[other] = first;
        }
    }
    let mut number = vec![usize::MAX; parent.len()];
    let mut count = 0;
    let components = (0..parent.len())
        .map(|node| {
            let root = root(&mut parent, node);
            if number[root] == usize::MAX {
                number[root] = count;
                count += 1;
            }
            number[root]
        })
        .collect();
    (components, count)
}
