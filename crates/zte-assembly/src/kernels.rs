//! Sums over the nodes and over the quadrature points of one element, compiled for each number of nodes.

/// Components x, y, n of a vector field at the points of an element.
pub(crate) type Fields<'a> = [&'a [f64]; 3];

/// Number of unordered pairs of `n` nodes, each with itself included.
pub(crate) const fn pairs(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Number of the pair of nodes `a` and `b`.
pub(crate) const fn pair(a: usize, b: usize) -> usize {
    if a < b { pairs(b) + a } else { pairs(a) + b }
}

/// Where the blocks of an element stand in the values of a sparse tangent.
pub(crate) struct Blocks<'a> {
    /// Nodes of the element.
    pub(crate) nodes: &'a [u32],
    /// Row starts of the pattern.
    pub(crate) indptr: &'a [usize],
    /// First value of the block of each ordered pair of nodes, node by node.
    pub(crate) starts: &'a [usize],
}

/// Rows, nodes, jumps of all nodes, which of them are held, jumps at the points.
type Interpolate = fn(&[f64], &[u32], &[f64], &[bool], [&mut [f64]; 3]);
/// Rows, weights, tractions at the points, nodes, forces on all nodes.
type Integrate = fn(&[f64], &[f64], Fields<'_>, &[u32], &mut [f64]);
/// Rows of products, weights, tangent entries at the points, blocks, values of the sparse tangent.
type IntegrateTangent = fn(&[f64], &[f64], [&[f64]; 9], Blocks<'_>, &mut [f64]);

/// The sums of elements with one number of nodes. Rows of shape functions stand one after the other, one per point.
#[derive(Clone, Copy)]
pub(crate) struct Kernels {
    /// `sum_a N_a u_a` at each point, from the jumps x, y, n of all nodes; those that are held count as zero.
    pub(crate) interpolate: Interpolate,
    /// Adds `sum_p N_pa w_p t_p` to the force at each node `a`, in the order of the points.
    pub(crate) integrate: Integrate,
    /// Adds `sum_p N_pa N_pb w_p d_p` to the block of each ordered pair of nodes; `rows` hold the products of all pairs.
    pub(crate) integrate_tangent: IntegrateTangent,
}

impl Kernels {
    /// For `N` nodes and their `P` unordered pairs.
    pub(crate) const fn of<const N: usize, const P: usize>() -> Self {
        Self {
            interpolate: interpolate::<N>,
            integrate: integrate_traction::<N>,
            integrate_tangent: integrate_tangent::<N, P>,
        }
    }
}

// The loops over nodes are inside, where their number is known: passing nodal values in and out costs more than the sums.

fn interpolate<const N: usize>(
    rows: &[f64],
    nodes: &[u32],
    jump: &[f64],
    is_held: &[bool],
    [x, y, n]: [&mut [f64]; 3],
) {
    let mut nodal = [[0.0; 3]; N];
    for (values, &node) in nodal.iter_mut().zip(nodes) {
        values.copy_from_slice(&jump[3 * node as usize..][..3]);
        if !is_held.is_empty() {
            let held = &is_held[3 * node as usize..][..3];
            for (value, _) in values.iter_mut().zip(held).filter(|(_, held)| **held) {
                *value = 0.0;
            }
        }
    }
    let (rows, _) = rows.as_chunks::<N>();
    for (((row, x), y), n) in rows.iter().zip(x).zip(y).zip(n) {
        let at = |c: usize| {
            let mut sum = row[0] * nodal[0][c];
            for a in 1..N {
                sum += row[a] * nodal[a][c];
            }
            sum
        };
        *x = at(0);
        *y = at(1);
        *n = at(2);
    }
}

fn integrate_traction<const N: usize>(
    rows: &[f64],
    weights: &[f64],
    fields: Fields<'_>,
    nodes: &[u32],
    force: &mut [f64],
) {
    let sums = integrate::<N, 3>(rows, weights, fields);
    for (a, &node) in nodes.iter().enumerate().take(N) {
        for (value, sum) in force[3 * node as usize..][..3].iter_mut().zip(&sums) {
            *value += sum[a];
        }
    }
}

fn integrate_tangent<const N: usize, const P: usize>(
    rows: &[f64],
    weights: &[f64],
    tangent: [&[f64]; 9],
    Blocks { nodes, indptr, starts }: Blocks<'_>,
    values: &mut [f64],
) {
    // `N_a N_b` is symmetric in the nodes, so one block serves both orders of a pair.
    let mut blocks = [[0.0; 9]; P];
    for (entry, field) in tangent.into_iter().enumerate() {
        // Common: sliding does not change t_n, and nothing couples x and y where all points stick.
        if field.iter().all(|v| *v == 0.0) {
            continue;
        }
        let [sums] = integrate::<P, 1>(rows, weights, [field]);
        for (block, sum) in blocks.iter_mut().zip(sums) {
            block[entry] = sum;
        }
    }
    let (starts, _) = starts.as_chunks::<N>();
    for a in 0..N {
        let row = 3 * nodes[a] as usize;
        let stride = indptr[row + 1] - indptr[row];
        for b in 0..N {
            let block = &blocks[pair(a, b)];
            for i in 0..3 {
                let entries = &mut values[starts[a][b] + i * stride..][..3];
                for j in 0..3 {
                    entries[j] += block[3 * i + j];
                }
            }
        }
    }
}

/// `sum_p B_pk w_p f_p` of each field `f` for all `k`, in the order of the points.
///
/// The sums run side by side: vectorised without a change to the order of any.
// Inlined into the loops over nodes, the sums would be vectorised less well.
#[inline(never)]
fn integrate<const K: usize, const M: usize>(rows: &[f64], weights: &[f64], fields: [&[f64]; M]) -> [[f64; K]; M] {
    let mut sums = [[0.0; K]; M];
    let (rows, _) = rows.as_chunks::<K>();
    let n = rows.len();
    let weights = &weights[..n];
    let fields = fields.map(|field| &field[..n]);
    for p in 0..n {
        for m in 0..M {
            let weighted = weights[p] * fields[m][p];
            for k in 0..K {
                sums[m][k] += weighted * rows[p][k];
            }
        }
    }
    sums
}
