//! Plane quadrilateral meshes: the sections that are extruded into hexahedra.
use super::refinement::{Refinement, Washers};
use crate::Result;
use crate::geometry::{Geometry, equal_area_radius, require_less};
use joint_model::benchmark::ElementOrder;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A plane mesh; quadrilaterals run counter-clockwise.
#[derive(Clone, Debug, Default)]
pub(crate) struct Section {
    pub(crate) nodes: Vec<[f64; 2]>,
    pub(crate) quads: Vec<[u32; 4]>,
    /// Middles of edges along rings, by the two ends; all other edges are straight.
    middles: BTreeMap<[u32; 2], [f64; 2]>,
}

/// A closed line of edges: where they meet, and the middle between each of these points and the next.
#[derive(Clone)]
struct Ring {
    points: Vec<[f64; 2]>,
    middles: Vec<[f64; 2]>,
}

impl Ring {
    fn straight(points: Vec<[f64; 2]>) -> Self {
        let n = points.len();
        let middles = (0..n).map(|k| mean(points[k], points[(k + 1) % n])).collect();
        Self { points, middles }
    }

    /// `at` maps node numbers to points of a circle; halves stand for middles.
    fn round(count: usize, order: ElementOrder, at: impl Fn(f64) -> [f64; 2]) -> Self {
        let points: Vec<_> = (0..count).map(|k| at(k as f64)).collect();
        match order {
            ElementOrder::Linear => Self::straight(points),
            ElementOrder::Quadratic => Self {
                points,
                middles: (0..count).map(|k| at(k as f64 + 0.5)).collect(),
            },
        }
    }

    /// The ring about the axis through `[centre, 0]`, beginning `nodes` nodes further back.
    fn placed(&self, centre: f64, nodes: usize) -> Self {
        let placed = |points: &[[f64; 2]]| {
            let mut points: Vec<_> = points.iter().map(|p| [centre + p[0], p[1]]).collect();
            points.rotate_right(nodes);
            points
        };
        Self {
            points: placed(&self.points),
            middles: placed(&self.middles),
        }
    }

    /// The ring between two others.
    fn between(inner: &Self, outer: &Self, t: f64) -> Self {
        Self {
            points: blend(&inner.points, &outer.points, t).collect(),
            middles: blend(&inner.middles, &outer.middles, t).collect(),
        }
    }
}

impl Section {
    /// Adds nodes and returns their numbers.
    fn add(&mut self, points: impl IntoIterator<Item = [f64; 2]>) -> Vec<u32> {
        let first = self.nodes.len();
        self.nodes.extend(points);
        (first..self.nodes.len()).map(|node| node as u32).collect()
    }

    fn add_ring(&mut self, ring: Ring) -> Vec<u32> {
        let nodes = self.add(ring.points);
        let edges = (0..nodes.len()).map(|k| sorted([nodes[k], nodes[(k + 1) % nodes.len()]]));
        self.middles.extend(edges.zip(ring.middles));
        nodes
    }

    /// The ring that was added as `nodes`.
    fn ring(&self, nodes: &[u32]) -> Ring {
        let n = nodes.len();
        Ring {
            points: self.points(nodes),
            middles: (0..n).map(|k| self.middle([nodes[k], nodes[(k + 1) % n]])).collect(),
        }
    }

    fn middle(&self, edge: [u32; 2]) -> [f64; 2] {
        let [a, b] = edge.map(|node| self.nodes[node as usize]);
        self.middles.get(&sorted(edge)).copied().unwrap_or_else(|| mean(a, b))
    }

    /// Edges whose middles are not the means of their ends by construction, with their middles.
    pub(crate) fn middles(&self) -> impl Iterator<Item = ([u32; 2], [f64; 2])> {
        self.middles.iter().map(|(edge, at)| (*edge, *at))
    }

    fn points(&self, nodes: &[u32]) -> Vec<[f64; 2]> {
        nodes.iter().map(|&node| self.nodes[node as usize]).collect()
    }

    /// Fills the space between neighbouring polylines; each lies to the right of the one before it, seen along it.
    fn fill(&mut self, lines: &[Vec<u32>], closed: bool) {
        for pair in lines.windows(2) {
            let n = pair[0].len();
            for k in 0..if closed { n } else { n - 1 } {
                let next = (k + 1) % n;
                self.quads.push([pair[0][k], pair[1][k], pair[1][next], pair[0][next]]);
            }
        }
    }

    /// Surrounds the closed ring `inner` with `count` rings of elements that end in `outer`; returns the last ring.
    fn surround(&mut self, inner: &[u32], outer: &Ring, count: usize) -> Vec<u32> {
        let from = self.ring(inner);
        let mut rings = vec![inner.to_vec()];
        for step in 1..=count {
            rings.push(self.add_ring(Ring::between(&from, outer, step as f64 / count as f64)));
        }
        self.fill(&rings, true);
        rings.swap_remove(count)
    }

    /// Continues a mesh from the line `start` along `x` up to `end` by columns of the given relative widths; returns the last line.
    fn advance(&mut self, start: &[u32], end: f64, widths: impl IntoIterator<Item = f64>) -> Vec<u32> {
        let from = self.points(start);
        let to: Vec<_> = from.iter().map(|p| [end, p[1]]).collect();
        let mut lines = vec![start.to_vec()];
        for at in &fractions(widths)[1..] {
            lines.push(self.add(blend(&from, &to, *at)));
        }
        self.fill(&lines, false);
        lines.swap_remove(lines.len() - 1)
    }
}

fn mean(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|c| 0.5 * (a[c] + b[c]))
}

/// The ends of an edge in increasing order.
pub(crate) fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Points between two polylines; the weights make both ends exact.
fn blend<'a>(from: &'a [[f64; 2]], to: &'a [[f64; 2]], t: f64) -> impl Iterator<Item = [f64; 2]> + 'a {
    from.iter()
        .zip(to)
        .map(move |(a, b)| [0, 1].map(|i| (1.0 - t) * a[i] + t * b[i]))
}

/// `count + 1` equidistant values over `extent`, exactly antisymmetric about zero.
pub(crate) fn centred(extent: f64, count: usize) -> impl Iterator<Item = f64> + Clone {
    let n = count as f64;
    (0..=count).map(move |i| extent * ((2.0 * i as f64 - n) / (2.0 * n)))
}

/// `count` relative lengths, each `growth` times the one before; the first is 1.
pub(crate) fn growing(count: usize, growth: f64) -> impl DoubleEndedIterator<Item = f64> {
    // Powers one by one: `powi` need not be exact where the growth is 1.
    let lengths = std::iter::successors(Some(1.0), move |length| Some(length * growth));
    lengths.take(count).collect::<Vec<_>>().into_iter()
}

/// Where pieces of these relative lengths meet on a line from 0 to 1, both ends included.
pub(crate) fn fractions(lengths: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut ends = vec![0.0];
    ends.extend(lengths.into_iter().scan(0.0, |sum, length| {
        *sum += length;
        Some(*sum)
    }));
    let total = ends[ends.len() - 1];
    ends.into_iter().map(|end| end / total).collect()
}

/// Heights from `-extent / 2` to `extent / 2`, symmetric about zero, with `count` layers in each half that grow away from zero.
pub(crate) fn symmetric(extent: f64, count: usize, growth: f64) -> Vec<f64> {
    let above: Vec<_> = fractions(growing(count, growth))
        .into_iter()
        .map(|at| 0.5 * extent * at)
        .collect();
    above
        .iter()
        .skip(1)
        .rev()
        .map(|height| -height)
        .chain(above.iter().copied())
        .collect()
}

/// Rectangular section of these coordinates; node `(i, j)` has number `i n_second + j`.
pub(crate) fn rectangle(
    first: impl IntoIterator<Item = f64>,
    second: impl IntoIterator<Item = f64> + Clone,
) -> Section {
    let mut section = Section::default();
    let line = |at: f64| section.add(second.clone().into_iter().map(|other| [at, other]));
    let lines: Vec<_> = first.into_iter().map(line).collect();
    section.fill(&lines, false);
    section
}

/// The lap seen along `z`.
pub(crate) struct Lap {
    pub(crate) section: Section,
    /// Nodes along the edge at the least `x`, by increasing `y`.
    pub(crate) left: Vec<u32>,
    /// Nodes along the edge at the greatest `x`, by increasing `y`.
    pub(crate) right: Vec<u32>,
    /// Width of the columns along both edges (m).
    pub(crate) edge_column: f64,
}

/// Blocks along the lap: end, hole, between, hole, between, hole, end. Where the mesh follows the washers, the blocks of the holes
/// meet.
pub(crate) fn lap(geometry: &Geometry, refinement: &Refinement, order: ElementOrder) -> Result<Lap> {
    let half_block = match refinement.washers {
        Washers::Independent => 0.25 * geometry.hole_pitch,
        Washers::Followed => 0.5 * geometry.hole_pitch,
    };
    let hole_radius = equal_area_radius(0.5 * geometry.hole_diameter, refinement.hole_ring(), order);
    let (place, radius) = match refinement.washers {
        Washers::Independent => ("hole polygon radius", hole_radius),
        Washers::Followed => (
            "washer rim polygon radius",
            equal_area_radius(0.5 * geometry.washer_outer_diameter, refinement.sectors, order),
        ),
    };
    require_less("interface mesh", (place, radius), ("half block length", half_block))?;
    require_less("interface mesh", (place, radius), ("half width", 0.5 * geometry.width))?;
    let washer = match refinement.washers {
        Washers::Independent => Vec::new(),
        // The bore is a little wider than the hole: a ring between the two would be of slivers.
        Washers::Followed => Seat::new(geometry, refinement, order).washer(refinement).split_off(1),
    };

    let mut section = Section::default();
    let edge = 0.5 * geometry.lap_length;
    let left = section.add(centred(geometry.width, refinement.across).map(|y| [-edge, y]));
    let end = || growing(refinement.end, refinement.end_growth);
    let first_block = geometry.hole_positions()[0] - half_block;
    let mut line = section.advance(&left, first_block, end());
    for (hole, centre) in geometry.hole_positions().into_iter().enumerate() {
        if hole > 0 && refinement.washers == Washers::Independent {
            line = section.advance(&line, centre - half_block, growing(refinement.per_block, 1.0));
        }
        let hole = Ring::round(refinement.hole_ring(), order, |k| {
            // The middle of the right edge faces the angle 0.
            let (sin, cos) = (PI * (2.0 * k - refinement.across as f64) / refinement.hole_ring() as f64).sin_cos();
            [centre + hole_radius * cos, hole_radius * sin]
        });
        let mut rings = vec![hole];
        rings.extend(washer.iter().map(|ring| ring.placed(centre, refinement.across / 2)));
        line = hole_block(&mut section, &line, centre, half_block, rings, refinement);
    }
    let right = section.advance(&line, edge, end().rev());
    let edge_column = (first_block + edge) / end().sum::<f64>();
    Ok(Lap {
        section,
        left,
        right,
        edge_column,
    })
}

/// O-grid round one hole, from the line `left` on; returns the block's right line. `inner` are rings from the hole outwards that
/// the grid has, beside those between the last of them and the block's perimeter.
fn hole_block(
    section: &mut Section,
    left: &[u32],
    centre: f64,
    half_block: f64,
    mut inner: Vec<Ring>,
    refinement: &Refinement,
) -> Vec<u32> {
    let (across, along) = (refinement.across, refinement.per_block);
    let lines = section.points(left);
    let right = section.add(lines.iter().map(|p| [centre + half_block, p[1]]));
    let between_ends = |y: f64| {
        centred(2.0 * half_block, along)
            .skip(1)
            .take(along - 1)
            .map(move |x| [centre + x, y])
    };
    let bottom = section.add(between_ends(lines[0][1]));
    let top = section.add(between_ends(lines[across][1]));

    // Counter-clockwise from the bottom right corner, once round.
    let perimeter: Vec<u32> = (right.iter())
        .chain(top.iter().rev())
        .chain(left.iter().rev())
        .chain(&bottom)
        .copied()
        .collect();
    let outer = section.ring(&perimeter);
    if let Some(last) = inner.pop() {
        let between = |ring| Ring::between(&last, &outer, ring as f64 / refinement.hole_rings as f64);
        inner.extend((0..refinement.hole_rings).map(between).collect::<Vec<_>>());
    }
    let mut rings: Vec<_> = inner.into_iter().map(|ring| section.add_ring(ring)).collect();
    rings.push(perimeter);
    section.fill(&rings, true);
    right
}

/// The circles and the hexagon of which washers, head and nut are made, about their axis, with equally many nodes.
struct Seat {
    bore: Ring,
    hexagon: Ring,
    rim: Ring,
}

impl Seat {
    fn new(geometry: &Geometry, refinement: &Refinement, order: ElementOrder) -> Self {
        let n = refinement.sectors;
        // Corners at 30, 90, ... degrees, which are multiples of 360/12.
        let hexagon = (0..n).map(|k| {
            let from_flat = sector_angle(((k + n / 12) % (n / 6)) as f64, n) - PI / 6.0;
            let radius = 0.5 * geometry.across_flats / from_flat.cos();
            let angle = sector_angle(k as f64, n);
            [radius * angle.cos(), radius * angle.sin()]
        });
        Self {
            bore: circle(geometry.washer_inner_diameter, n, order),
            hexagon: Ring::straight(hexagon.collect()),
            rim: circle(geometry.washer_outer_diameter, n, order),
        }
    }

    /// The rings of a washer from its bore to its rim.
    fn washer(&self, refinement: &Refinement) -> Vec<Ring> {
        let between = |from: &Ring, to: &Ring, count: usize| -> Vec<Ring> {
            let at = |step| Ring::between(from, to, step as f64 / count as f64);
            (1..=count).map(at).collect()
        };
        let mut rings = vec![self.bore.clone()];
        rings.extend(between(&self.bore, &self.hexagon, refinement.seat_rings));
        rings.extend(between(&self.hexagon, &self.rim, refinement.rim_rings));
        rings
    }
}

fn sector_angle(k: f64, n: usize) -> f64 {
    2.0 * PI * k / n as f64
}

/// Circle about the origin with its first node at the angle 0.
fn circle(diameter: f64, n: usize, order: ElementOrder) -> Ring {
    let radius = equal_area_radius(0.5 * diameter, n, order);
    Ring::round(n, order, |k| {
        let angle = sector_angle(k, n);
        [radius * angle.cos(), radius * angle.sin()]
    })
}

/// Sections of the fastening hardware about its axis, with rings of `sectors` nodes in common: the seat, from the
/// washer's bore to the hexagon, is where head, nut and washers meet.
pub(crate) struct Hardware {
    /// Disc with a square core; its last ring is the shank's surface.
    pub(crate) shank: Section,
    /// The shank's section continued to the hexagon; begins with the nodes of `shank`, then those of the seat.
    pub(crate) head: Section,
    /// Begins with the nodes of the seat.
    pub(crate) washer: Section,
    /// Begins with one ring on the bore, then the nodes of the seat.
    pub(crate) nut: Section,
    /// Number of nodes on the seat.
    pub(crate) seat: usize,
}

pub(crate) fn hardware(geometry: &Geometry, refinement: &Refinement, order: ElementOrder) -> Result<Hardware> {
    let n = refinement.sectors;
    let seat = Seat::new(geometry, refinement, order);
    let bore_radius = equal_area_radius(0.5 * geometry.washer_inner_diameter, n, order);
    let hole_radius = equal_area_radius(0.5 * geometry.hole_diameter, refinement.hole_ring(), order);
    // A washer's nodes must lie on the beam's face, and its seat must stay under the hexagon.
    require_less(
        "hardware mesh",
        ("hole polygon radius", hole_radius),
        ("washer bore polygon radius", bore_radius),
    )?;
    require_less(
        "hardware mesh",
        ("washer bore polygon radius", bore_radius),
        ("half across_flats", 0.5 * geometry.across_flats),
    )?;
    let (shank, surface) = disc(&circle(geometry.shank_diameter, n, order), refinement.shank_rings);
    let mut head = shank.clone();
    let ring = head.surround(&surface, &seat.bore, 1);
    head.surround(&ring, &seat.hexagon, refinement.seat_rings);

    let mut washer = Section::default();
    let rings: Vec<_> = seat
        .washer(refinement)
        .into_iter()
        .map(|ring| washer.add_ring(ring))
        .collect();
    washer.fill(&rings, true);

    let mut nut = Section::default();
    let ring = nut.add_ring(circle(geometry.nut_bore_diameter, n, order));
    let ring = nut.surround(&ring, &seat.bore, 1);
    nut.surround(&ring, &seat.hexagon, refinement.seat_rings);

    Ok(Hardware {
        shank,
        head,
        washer,
        nut,
        seat: n * (refinement.seat_rings + 1),
    })
}

/// Butterfly mesh of a disc: a rounded square core inside of rings; returns the outermost ring too.
fn disc(surface: &Ring, rings: usize) -> (Section, Vec<u32>) {
    // Size and roundness of the core (least scaled Jacobian 0.82 or more at every preset; 0.62 at a roundness of 0.6).
    const CORE: f64 = 0.62;
    const ROUNDNESS: f64 = 0.4;
    let n = surface.points.len();
    let side = n / 4;
    // Corners lie on the axes, where every multiple of 12 sectors has nodes.
    let towards_chord = |k: usize, within: f64, at: [f64; 2]| {
        let (from, to) = (
            surface.points[k / side * side],
            surface.points[(k / side + 1) % 4 * side],
        );
        let t = ((k % side) as f64 + within) / side as f64;
        [0, 1].map(|i| {
            let chord = (1.0 - t) * from[i] + t * to[i];
            CORE * (ROUNDNESS * at[i] + (1.0 - ROUNDNESS) * chord)
        })
    };
    let boundary: Vec<[f64; 2]> = (0..n).map(|k| towards_chord(k, 0.0, surface.points[k])).collect();
    let middles = (0..n).map(|k| towards_chord(k, 0.5, surface.middles[k])).collect();

    let mut section = Section::default();
    let ring = section.add_ring(Ring {
        points: boundary.clone(),
        middles,
    });
    // The ring's four sides, as seen from the core's local coordinates u (first index) and v (second).
    let v_least = |i: usize| i;
    let u_greatest = |j: usize| side + j;
    let v_greatest = |i: usize| 3 * side - i;
    let u_least = |j: usize| (4 * side - j) % n;
    let mut lines = Vec::new();
    for i in 0..=side {
        let mut line = Vec::new();
        for j in 0..=side {
            let (u, v) = (i as f64 / side as f64, j as f64 / side as f64);
            line.push(match (i, j) {
                (i, 0) => ring[v_least(i)],
                (i, j) if j == side => ring[v_greatest(i)],
                (0, j) => ring[u_least(j)],
                (i, j) if i == side => ring[u_greatest(j)],
                _ => {
                    // Transfinite interpolation between the four sides.
                    let point = [0, 1].map(|c| {
                        let at = |k: usize| boundary[k][c];
                        let along_v = (1.0 - v) * at(v_least(i)) + v * at(v_greatest(i));
                        let along_u = (1.0 - u) * at(u_least(j)) + u * at(u_greatest(j));
                        let corners = (1.0 - u) * ((1.0 - v) * at(0) + v * at(3 * side))
                            + u * ((1.0 - v) * at(side) + v * at(2 * side));
                        along_u + along_v - corners
                    });
                    section.add([point])[0]
                }
            });
        }
        lines.push(line);
    }
    section.fill(&lines, false);
    let outer = section.surround(&ring, surface, rings);
    (section, outer)
}
