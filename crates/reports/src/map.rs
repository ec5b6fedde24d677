//! Maps of the interface as SVG.

use crate::fields::Placed;
use crate::markup::escape;
use crate::styles::hex;
use std::collections::BTreeMap;
use std::fmt::Write;
use zte_assembly::InterfaceMesh;

/// Nine equally spaced colours of the viridis map, dark to light.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

const WIDTH: f64 = 800.0;
/// For a column of a paper of 85 mm, where the texts of 14 then have 8 pt.
pub(crate) const COLUMN: f64 = 421.65;
const MARGIN: f64 = 10.0;
/// Room for the labels of the upright axis.
const LEFT: f64 = 64.0;
/// Room for those of the other.
const BELOW: f64 = 46.0;
/// Length of the marks on the axes.
const MARK: f64 = 5.0;
const BAR_HEIGHT: f64 = 14.0;
/// Steps of colour of the bar.
const BAR_STEPS: u32 = 64;

/// Colour for `t` from 0 to 1.
pub fn rgb(t: f64) -> [u8; 3] {
    let position = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let low = (position as usize).min(VIRIDIS.len() - 2);
    let part = position - low as f64;
    [0, 1, 2].map(|c| (VIRIDIS[low][c] + part * (VIRIDIS[low + 1][c] - VIRIDIS[low][c])).round() as u8)
}

fn colour(t: f64) -> String {
    hex(rgb(t))
}

/// Multiples of 1, 2 or 5 times a power of ten from one value to another: about `n` of them, each with its text.
fn round_numbers(from: f64, to: f64, n: f64) -> Vec<(f64, String)> {
    let rough = (to - from).abs() / n;
    if !(rough > 0.0 && rough.is_finite()) {
        return Vec::new();
    }
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let step = step
        .into_iter()
        .find(|step| *step >= 0.999 * rough)
        .unwrap_or(10.0 * power);
    let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    let (low, high) = (from.min(to), from.max(to));
    let tolerance = 1e-6 * step;
    let (first, last) = (
        ((low - tolerance) / step).ceil() as i64,
        ((high + tolerance) / step).floor() as i64,
    );
    (first..=last)
        .map(|i| (i as f64 * step, format!("{:.decimals$}", i as f64 * step)))
        .collect()
}

/// The interface with its first direction to the right and its second upwards, one colour per element; with axes in mm and a colour bar
/// from the smallest to the largest value. Axes parallel to those of the model have their names and coordinates.
pub fn svg(place: Placed<'_>, values: &[f64], quantity: &str, unit: &str) -> String {
    let label = format!("{quantity} [{unit}]");
    let (body, height) = drawing(place, values, &label, bounds_of(values), WIDTH);
    document(&body, [WIDTH, height], &label)
}

/// Smallest and largest of the values.
pub(crate) fn bounds_of(values: &[f64]) -> [f64; 2] {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    [low, high]
}

/// What is drawn, as a document that says what it is.
pub(crate) fn document(body: &str, [width, height]: [f64; 2], label: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height:.1}\" role=\"img\" \
         aria-label=\"{}\" font-family=\"sans-serif\" font-size=\"14\">\n{body}</svg>\n",
        escape(label)
    )
}

/// The map without the document around it, and its height; colours run over the range.
pub(crate) fn drawing(
    place: Placed<'_>,
    values: &[f64],
    label: &str,
    [low, high]: [f64; 2],
    width: f64,
) -> (String, f64) {
    let mesh = place.mesh;
    let nodes = &mesh.nodes;
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| nodes.iter().map(|x| x[axis]).fold(from, pick);
    let (left, right) = (bound(0, f64::min, f64::INFINITY), bound(0, f64::max, f64::NEG_INFINITY));
    let (bottom, top) = (bound(1, f64::min, f64::INFINITY), bound(1, f64::max, f64::NEG_INFINITY));
    let scale = (width - LEFT - MARGIN) / (right - left);
    let floor = MARGIN + scale * (top - bottom);
    let (across, down) = (|x: f64| LEFT + scale * (x - left), |y: f64| MARGIN + scale * (top - y));
    let bar_top = floor + BELOW + 12.0;
    let height = bar_top + BAR_HEIGHT + 42.0;
    let range = if high > low { high - low } else { 1.0 };

    let mut out = String::new();
    let label = escape(label);
    for (element, &value) in mesh.elements.iter().zip(values) {
        let corners: Vec<String> = element
            .outline()
            .into_iter()
            .map(|n| nodes[n as usize])
            .map(|[x, y]| format!("{:.2},{:.2}", across(x), down(y)))
            .collect();
        // The stroke closes the hairline gaps that antialiasing leaves between neighbours.
        let fill = colour((value - low) / range);
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<polygon points=\"{}\" fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"1\"/>",
            corners.join(" ")
        );
    }
    let mut edge = String::new();
    for [a, b] in outer_edges(mesh) {
        let [[x, y], [to_x, to_y]] = [a, b].map(|n| nodes[n as usize]);
        let (x, y, to_x, to_y) = (across(x), down(y), across(to_x), down(to_y));
        let _ = write!(edge, "M{x:.2} {y:.2}L{to_x:.2} {to_y:.2}");
    }
    let _ = writeln!(
        out,
        "<path d=\"{edge}\" fill=\"none\" stroke=\"#000\" stroke-width=\".8\"/>"
    );
    let [(across_factor, across_name), (up_factor, up_name)] = place.axes();
    let mut axes = format!("M{LEFT} {MARGIN}V{floor:.1}H{:.1}", width - MARGIN);
    let mut texts = String::new();
    for (value, text) in round_numbers(across_factor * left, across_factor * right, width / 100.0) {
        let x = across(value / across_factor);
        let _ = write!(axes, "M{x:.1} {floor:.1}v{MARK}");
        let _ = writeln!(
            texts,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{text}</text>",
            floor + 20.0
        );
    }
    // As far apart as those of the other axis, but several at least.
    let upright = (width / 100.0 * (top - bottom) / (right - left)).max(4.0);
    for (value, text) in round_numbers(up_factor * bottom, up_factor * top, upright) {
        let y = down(value / up_factor);
        let _ = write!(axes, "M{LEFT} {y:.1}h-{MARK}");
        let _ = writeln!(
            texts,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
            LEFT - 8.0,
            y + 5.0
        );
    }
    let middle = 0.5 * (MARGIN + floor);
    let _ = writeln!(
        out,
        "<path d=\"{axes}\" fill=\"none\" stroke=\"#444\"/>\n{texts}\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n\
         <text x=\"16\" y=\"{middle:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 16 {middle:.1})\">{}</text>",
        0.5 * (LEFT + width - MARGIN),
        floor + 40.0,
        escape(&across_name),
        escape(&up_name)
    );
    let bar_width = width - LEFT - MARGIN;
    for step in 0..BAR_STEPS {
        let part = f64::from(step) / f64::from(BAR_STEPS);
        let _ = writeln!(
            out,
            "<rect x=\"{:.2}\" y=\"{bar_top:.1}\" width=\"{:.2}\" height=\"{BAR_HEIGHT}\" fill=\"{}\"/>",
            LEFT + bar_width * part,
            bar_width / f64::from(BAR_STEPS) + 0.5,
            colour(part + 0.5 / f64::from(BAR_STEPS))
        );
    }
    let baseline = bar_top + BAR_HEIGHT + 18.0;
    let numbers = if width < WIDTH { 2 } else { 4 };
    for number in 0..=numbers {
        let part = f64::from(number) / f64::from(numbers);
        let anchor = match number {
            0 => "start",
            last if last == numbers => "end",
            _ => "middle",
        };
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{baseline:.1}\" text-anchor=\"{anchor}\">{:.3e}</text>",
            LEFT + bar_width * part,
            low + part * (high - low)
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
        LEFT + 0.5 * bar_width,
        baseline + 18.0
    );
    (out, height)
}

/// The edges of one element alone: the outline of the interface and of its holes.
fn outer_edges(mesh: &InterfaceMesh) -> Vec<[u32; 2]> {
    let mut elements_of: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for element in &mesh.elements {
        let outline = element.outline();
        for (&a, &b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
            *elements_of.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let alone = elements_of.into_iter().filter(|(_, elements)| *elements == 1);
    alone.map(|(edge, _)| edge).collect()
}

/// A map among several.
pub struct Map {
    /// What is drawn, with its unit.
    pub label: String,
    /// One value per element; elements whose value is NaN stay white.
    pub values: Vec<f64>,
}

/// Classes of colour: elements of one class share a path, which keeps the files small.
const CLASSES: usize = 24;

/// Several maps of one interface in rows of `columns`, each with its own range of colours.
pub fn several(mesh: &InterfaceMesh, maps: &[Map], columns: usize) -> String {
    const TILE: f64 = 420.0;
    const GAP: f64 = 16.0;
    const LABEL: f64 = 8.0;
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| mesh.nodes.iter().map(|x| x[axis]).fold(from, pick);
    let (left, right) = (bound(0, f64::min, f64::INFINITY), bound(0, f64::max, f64::NEG_INFINITY));
    let (bottom, top) = (bound(1, f64::min, f64::INFINITY), bound(1, f64::max, f64::NEG_INFINITY));
    let scale = TILE / (right - left);
    let map_height = scale * (top - bottom);
    let row = map_height + 62.0;
    let (width, height) = (
        columns as f64 * (TILE + GAP) + GAP,
        maps.len().div_ceil(columns) as f64 * row + GAP + LABEL,
    );
    let mut out = String::new();
    let labels: Vec<&str> = maps.iter().map(|map| map.label.as_str()).collect();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>",
        escape(&labels.join("; "))
    );
    for (index, map) in maps.iter().enumerate() {
        let (x0, y0) = (
            GAP + (index % columns) as f64 * (TILE + GAP),
            GAP + LABEL + (index / columns) as f64 * row,
        );
        let finite = || map.values.iter().copied().filter(|v| v.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        let range = if high > low { high - low } else { 1.0 };
        let mut paths = vec![String::new(); CLASSES];
        for (element, value) in mesh.elements.iter().zip(&map.values).filter(|(_, v)| v.is_finite()) {
            let class = (((value - low) / range * CLASSES as f64) as usize).min(CLASSES - 1);
            // Whole quarters of a pixel, all corners but the first as steps: the shortest text for a polygon.
            let mut before: Option<[i32; 2]> = None;
            for node in element.outline() {
                let [x, y] = mesh.nodes[node as usize];
                let at = [x - left, top - y].map(|length| (4.0 * scale * length).round() as i32);
                let _ = match before {
                    None => write!(paths[class], "M{} {}l", at[0], at[1]),
                    Some([x, y]) => write!(paths[class], "{} {} ", at[0] - x, at[1] - y),
                };
                before = Some(at);
            }
            paths[class].push('z');
        }
        let _ = writeln!(
            out,
            "<g transform=\"translate({x0:.0} {y0:.0})\" stroke-width=\"3\">\n<rect width=\"{TILE}\" \
             height=\"{map_height:.1}\" fill=\"none\" stroke=\"#bbb\" stroke-width=\".7\"/>"
        );
        for (class, path) in paths.iter().enumerate() {
            let fill = colour((class as f64 + 0.5) / CLASSES as f64);
            if !path.is_empty() {
                let _ = writeln!(
                    out,
                    "<path transform=\"scale(.25)\" fill=\"{fill}\" stroke=\"{fill}\" d=\"{path}\"/>"
                );
            }
            let _ = writeln!(
                out,
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"8\" fill=\"{fill}\"/>",
                TILE * class as f64 / CLASSES as f64,
                map_height + 6.0,
                TILE / CLASSES as f64 + 0.5
            );
        }
        let ends = [("start", 0.0, low), ("end", TILE, high)];
        for (anchor, x, value) in ends.into_iter().filter(|(_, _, v)| v.is_finite()) {
            let _ = writeln!(
                out,
                "<text x=\"{x:.0}\" y=\"{:.0}\" text-anchor=\"{anchor}\">{value:.2e}</text>",
                map_height + 28.0
            );
        }
        let _ = writeln!(
            out,
            "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>\n</g>",
            0.5 * TILE,
            -6.0,
            escape(&map.label)
        );
    }
    out += "</svg>\n";
    out
}

#[cfg(test)]
mod tests {
    use super::{Map, colour, round_numbers, several, svg};
    use crate::fields::Placed;
    use zte_assembly::{Element, InterfaceMesh};

    /// Twice the area within a closed line.
    fn shoelace(points: &[[f64; 2]]) -> f64 {
        let next = points.iter().cycle().skip(1);
        points
            .iter()
            .zip(next)
            .map(|(a, b)| a[0] * b[1] - b[0] * a[1])
            .sum::<f64>()
            .abs()
    }

    #[test]
    fn quadratic_elements_are_drawn_around_their_middles() {
        let nodes = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]];
        let mesh = InterfaceMesh::flat(
            nodes.map(|x| x.map(f64::from)).to_vec(),
            vec![Element::quad9([0, 1, 2, 3, 4, 5, 6, 7, 8])],
        );
        let place = Placed {
            mesh: &mesh,
            frame: [[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.0, 0.8, 0.6]],
            node_frames: &[],
            positions: Some(&[[0.0; 3]; 9]),
        };
        let one = svg(place, &[1.0], "pressure", "Pa");
        assert!(
            one.contains(">x [mm]<") && one.contains(">along (0, -0.6, 0.8) [mm]<"),
            "{one}"
        );
        let (_, points) = one.split_once("<polygon points=\"").unwrap();
        let numbers = |text: &str| text.split(',').map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
        let points = points.split('"').next().unwrap().split(' ').map(numbers);
        let points: Vec<[f64; 2]> = points.map(|p| p.try_into().unwrap()).collect();
        let width = points.iter().map(|p| p[0]).fold(0.0, f64::max) - points[0][0];
        assert_eq!(points.len(), 8);
        assert!((shoelace(&points) / (2.0 * width * width) - 1.0).abs() < 1e-3);
        let map = Map {
            label: "pressure".into(),
            values: vec![1.0],
        };
        let many = several(&mesh, &[map], 1);
        let (_, path) = many.split_once(" d=\"M").unwrap();
        let (start, steps) = path
            .split('"')
            .next()
            .unwrap()
            .trim_end_matches('z')
            .split_once('l')
            .unwrap();
        let pair = |text: &str| -> Vec<f64> { text.split_whitespace().map(|n| n.parse().unwrap()).collect() };
        let mut at: [f64; 2] = pair(start).try_into().unwrap();
        let mut points = vec![at];
        for step in pair(steps).chunks(2) {
            at = [at[0] + step[0], at[1] + step[1]];
            points.push(at);
        }
        let width = points.iter().map(|p| p[0]).fold(0.0, f64::max);
        assert!((shoelace(&points) / (2.0 * width * width) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn axes_have_round_numbers() {
        let texts =
            |from, to| -> Vec<String> { round_numbers(from, to, 8.0).into_iter().map(|(_, text)| text).collect() };
        assert_eq!(texts(-13.0, 27.0), ["-10", "-5", "0", "5", "10", "15", "20", "25"]);
        assert_eq!(
            texts(0.3, 0.0),
            ["0.00", "0.05", "0.10", "0.15", "0.20", "0.25", "0.30"]
        );
        assert!(texts(1.0, 1.0).is_empty() && texts(f64::NAN, 1.0).is_empty());
    }

    #[test]
    fn colours_run_from_dark_to_light_and_stay_in_range() {
        assert_eq!(colour(0.0), "#440154");
        assert_eq!(colour(0.5), "#21918c");
        assert_eq!(colour(1.0), "#fde725");
        assert_eq!(colour(-3.0), colour(0.0));
        assert_eq!(colour(7.0), colour(1.0));
    }
}
