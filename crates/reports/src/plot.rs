//! Pictures: the backbone, the response and the profiles of an element, and the cost of a load point.

use crate::answer::{length, percent};
use crate::styles::{COLOURS, Style, of_method, title};
use crate::{Drawing, Error};
use analyses::comparison::Point;
use analyses::ensemble::BandPoint;
use analyses::results::summary::{BackboneSummary, MethodSummary, Status, Summary};
use contact_laws::{ContactCurves, FittedCurves};
use joints::interface::Profile;
use plotters::coord::Shift;
use plotters::coord::combinators::{LogCoord, WithKeyPoints};
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::ops::Range;
use surface_characterisation::ElementSurface;

const SIZE: (u32, u32) = (800, 720);
/// Colour of frequencies.
pub const BLUE: RGBColor = RGBColor(31, 93, 153);
/// Colour of damping ratios.
pub const RED: RGBColor = RGBColor(178, 58, 46);
const GRID: RGBColor = RGBColor(222, 222, 222);

/// Length of the sample of a curve in the legend (pixels).
const SAMPLE: u32 = 40;

/// Name of amplitudes at the response point, which `response` tells in words, for axes and tables.
pub fn amplitude_label(response: &str) -> String {
    format!("displacement amplitude at {response}")
}

/// What is drawn on.
pub type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A picture of this size (pixels) on a white ground, as SVG; `name` says in errors what it shows.
///
/// # Errors
/// [`Error::Picture`] if `draw` fails.
pub fn picture(
    name: &'static str,
    size: (u32, u32),
    draw: impl FnOnce(&Canvas<'_>) -> Result<(), Drawing>,
) -> Result<String, Error> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let drawn = root
            .fill(&WHITE)
            .and_then(|()| draw(&root))
            .and_then(|()| root.present());
        drawn.map_err(|source| Error::Picture { picture: name, source })?;
    }
    // Units have raised digits in pictures and pages, and `^2` in text, tables and JSON.
    Ok(svg.replace("^2", "²").replace("^3", "³"))
}

/// Frequency above, damping below, over a shared logarithmic amplitude axis.
///
/// # Errors
/// [`Error::Picture`].
pub fn backbone(summary: &Summary, title: &str) -> Result<String, Error> {
    picture("the backbone", SIZE, |root| draw(summary, title, root))
}

/// What a load point costs (ms), logarithmic: above against the number of interface elements, below against the points per
/// element.
///
/// # Errors
/// [`Error::Picture`].
pub fn scaling(by_elements: &[(f64, f64)], by_points: &[(f64, f64)]) -> Result<String, Error> {
    picture("the cost of a load point", SIZE, |root| {
        let (upper, lower) = root.split_vertically(SIZE.1 / 2);
        for (area, label, colour, pairs) in [
            (upper, "interface elements, 4 points each", BLUE, by_elements),
            (lower, "points per element, 588 elements", RED, by_points),
        ] {
            let points: Points = pairs.iter().enumerate().map(|(i, &(x, y))| (i, x, y)).collect();
            let x = widen(&bounds(pairs.iter().map(|p| p.0)).unwrap_or(1.0..10.0), 1.3);
            let y = widen(&bounds(pairs.iter().map(|p| p.1)).unwrap_or(1.0..10.0), 2.0);
            let (x_ticks, y_ticks) = (ticks(&x), ticks(&y));
            let plain = |value: &f64| format!("{value}");
            panel(
                &area,
                log(&x, &x_ticks),
                log(&y, &y_ticks),
                "load point [ms]",
                label,
                [&plain, &plain],
                &[Curve {
                    name: String::new(),
                    colour,
                    dashes: None,
                    marks: Marks::Dots,
                    points,
                }],
                &[],
                SeriesLabelPosition::LowerRight,
            )?;
        }
        Ok(())
    })
}

/// Normal traction above, tangential stiffness along x and y below, against interference: sums over the heights, their
/// bands and their fits.
///
/// # Errors
/// [`Error::Picture`].
pub fn response(element: &ElementSurface, fits: &FittedCurves, title: &str) -> Result<String, Error> {
    let (curves, u) = (&element.curves, &element.curves.interference);
    let curve = |name: &str, colour, dashes, values: &mut dyn Iterator<Item = f64>| {
        let points = u.iter().zip(values).enumerate().map(|(i, (&u, v))| (i, u, v));
        Curve {
            name: name.into(),
            colour,
            dashes,
            marks: Marks::None,
            points: points.filter(|p| p.2 > 0.0).collect(),
        }
    };
    let (green, fit) = (RGBColor(34, 130, 60), Some((9, 5)));
    let normal = [
        curve("sum", BLUE, None, &mut curves.normal.iter().copied()),
        curve("fit (28)", RED, fit, &mut u.iter().map(|&u| fits.normal(u).0)),
    ];
    let along = |q: usize| curves.tangential[q].iter().copied();
    let mut tangential = vec![
        curve("sum", BLUE, None, &mut along(0)),
        curve(
            "fit (29)",
            RED,
            fit,
            &mut u.iter().map(|&u| fits.tangential(u)[0].value),
        ),
    ];
    if curves.tangential[0] != curves.tangential[1] {
        tangential[0].name += ", x";
        tangential[1].name += ", x";
        tangential.push(curve("sum, y", green, None, &mut along(1)));
        let y = &mut u.iter().map(|&u| fits.tangential(u)[1].value);
        tangential.push(curve("fit (29), y", RGBColor(122, 58, 150), fit, y));
    }
    picture("the response of an element", SIZE, |root| {
        let root = root.titled(title, ("sans-serif", 20))?;
        let (upper, lower) = root.split_vertically(SIZE.1 / 2 - 30);
        let bands = element.bands.as_ref();
        for (area, x_label, y_label, curves, band) in [
            (
                &upper,
                "",
                "normal traction [Pa]",
                &normal[..],
                bands.map(|b| &b.normal),
            ),
            (
                &lower,
                "interference [m]",
                "tangential stiffness [Pa/m]",
                &tangential,
                bands.map(|b| &b.tangential[0]),
            ),
        ] {
            let x = bounds(points(curves).map(|p| p.1)).unwrap_or(1e-7..1e-5);
            let y = widen(&bounds(points(curves).map(|p| p.2)).unwrap_or(1.0..10.0), 2.0);
            let (x_ticks, y_ticks) = (ticks(&x), ticks(&y));
            // Where a realisation does not touch yet, its zero lies below every logarithmic axis.
            let within = |v: f64| v.clamp(y.start, y.end);
            let band = band.map(|[low, high]| Band {
                colour: BLUE,
                points: (0..u.len()).map(|k| (u[k], within(low[k]), within(high[k]))).collect(),
            });
            panel(
                area,
                log(&x, &x_ticks),
                log(&y, &y_ticks),
                y_label,
                x_label,
                [&power, &power],
                curves,
                band.as_slice(),
                SeriesLabelPosition::LowerRight,
            )?;
        }
        Ok(())
    })
}

/// A line through an element: above the heights with the form that is taken off, below what remains with the parabolas of
/// its peaks (um over mm).
///
/// # Errors
/// [`Error::Picture`].
pub fn profile(profile: &Profile, title: &str) -> Result<String, Error> {
    let step = match profile.x[..] {
        [first, second, ..] => second - first,
        _ => 1.0,
    };
    let line = |name: &str, colour, dashes, values: &mut dyn Iterator<Item = f64>| {
        let points = profile.x.iter().zip(values).enumerate();
        let points = points
            .map(|(i, (x, z))| (i, 1e3 * x, 1e6 * z))
            .filter(|p| p.2.is_finite());
        Curve {
            name: name.into(),
            colour,
            dashes,
            marks: Marks::None,
            points: points.collect(),
        }
    };
    let raw = [
        line("heights", BLUE, None, &mut profile.height.iter().copied()),
        line("plane and form", RED, Some((9, 5)), &mut profile.form.iter().copied()),
    ];
    let residual = &mut profile.height.iter().zip(&profile.form).map(|(z, form)| z - form);
    let arcs = profile.peaks.iter().enumerate().flat_map(|(number, peak)| {
        // Nine points over two steps, with numbers that keep the arcs apart.
        (0..9_u8).map(move |k| {
            let s = step * (f64::from(k) / 4.0 - 1.0);
            let z = peak.height - 0.5 * peak.curvature * s * s;
            let x = profile.x[0] + peak.position + s;
            (10 * number + usize::from(k), 1e3 * x, 1e6 * z)
        })
    });
    let arcs = Curve {
        name: "parabolas of the peaks".into(),
        colour: RED,
        dashes: Some((SAMPLE, 1)),
        marks: Marks::None,
        points: arcs.collect(),
    };
    let flat = [line("heights above the form", BLUE, None, residual), arcs];
    picture("a profile", SIZE, |root| {
        let root = root.titled(title, ("sans-serif", 20))?;
        let (upper, lower) = root.split_vertically(SIZE.1 / 2 - 30);
        for (area, x_label, curves) in [(&upper, "", &raw), (&lower, "x [mm]", &flat)] {
            let x = bounds(points(&raw).map(|p| p.1)).unwrap_or(0.0..1.0);
            let Range { start, end } = bounds(points(curves).map(|p| p.2)).unwrap_or(0.0..1.0);
            let margin = 0.08 * (end - start) + f64::MIN_POSITIVE;
            panel(
                area,
                x,
                start - margin..end + margin,
                "height [um]",
                x_label,
                [&|x| format!("{x:.2}"), &|z| format!("{z:.1}")],
                curves,
                &[],
                SeriesLabelPosition::LowerRight,
            )?;
        }
        Ok(())
    })
}

/// Points of a curve with their numbers in the backbone, so that lines break where an amplitude is missing.
pub type Points = Vec<(usize, f64, f64)>;

/// How points are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// Not at all.
    None,
    /// Filled circles.
    Dots,
    /// Open circles without a line: bounds that the value lies below, or the points of a line that is drawn apart.
    Bounds,
    /// Filled triangles without a line.
    Triangles,
    /// Crosses without a line.
    Crosses,
}

impl Marks {
    fn has_line(self) -> bool {
        matches!(self, Self::None | Self::Dots)
    }
}

/// The curve of one method.
pub struct Curve {
    /// Name in the legend; empty: none.
    pub name: String,
    /// Colour of line and dots.
    pub colour: RGBColor,
    /// Length and spacing of its dashes (pixels); none: a solid line.
    pub dashes: Option<(u32, u32)>,
    /// How its points are marked.
    pub marks: Marks,
    /// Its points.
    pub points: Points,
}

/// A shaded band: position, lower and upper end.
pub struct Band {
    /// Colour.
    pub colour: RGBColor,
    /// Its points.
    pub points: Vec<(f64, f64, f64)>,
}

impl Curve {
    fn new(name: &str, main: RGBColor, points: Points) -> Self {
        let Style { colour, dashes } = of_method(name);
        let colour = if dashes.is_none() { main } else { colour };
        Self {
            name: title(name),
            colour,
            dashes,
            marks: if dashes.is_none() { Marks::Dots } else { Marks::None },
            points,
        }
    }
}

/// One curve per method, CQSMA last so that it lies on top: amplitude and the value asked for.
fn curves(
    summary: &Summary,
    main: RGBColor,
    cqsma: fn(&BackboneSummary) -> Option<f64>,
    other: fn(&MethodSummary) -> Option<f64>,
    measured: fn(&Point) -> Option<f64>,
) -> Vec<Curve> {
    let methods = summary.methods.iter().map(|(name, points)| {
        let points = points.iter().enumerate();
        let points = points.filter_map(|(i, m)| Some((i, m.response_displacement?, other(m)?)));
        Curve::new(name, main, points.collect())
    });
    let points = summary.backbone.iter().enumerate();
    let points = points.filter_map(|(i, b)| Some((i, b.response_displacement?, cqsma(b)?)));
    let cqsma = (!summary.backbone.is_empty()).then(|| Curve::new("cqsma", main, points.collect()));
    let tests = summary
        .measured
        .iter()
        .zip(COLOURS.into_iter().cycle().skip(1))
        .map(|(one, colour)| {
            let points = one.points.iter().enumerate();
            let points = points.filter_map(|(i, p)| Some((i, p.amplitude, measured(p)?)));
            Curve {
                name: one.name.clone(),
                colour,
                dashes: None,
                marks: Marks::Crosses,
                points: points.collect(),
            }
        });
    methods.chain(tests).chain(cqsma).collect()
}

/// All points of all curves.
fn points(curves: &[Curve]) -> impl Iterator<Item = &(usize, f64, f64)> {
    curves.iter().flat_map(|curve| &curve.points)
}

/// All values of curves and bands.
fn heights<'a>(curves: &'a [Curve], bands: &'a [Band]) -> impl Iterator<Item = f64> + 'a {
    let bands = bands.iter().flat_map(|b| b.points.iter().flat_map(|p| [p.1, p.2]));
    points(curves).map(|p| p.2).chain(bands)
}

fn draw(summary: &Summary, title: &str, root: &Canvas<'_>) -> Result<(), Drawing> {
    let frequency = curves(
        summary,
        BLUE,
        |b| b.frequency_first_harmonic_hz,
        |m| m.frequency_first_harmonic_hz,
        |p| Some(p.frequency_hz),
    );
    // EPMC tells what it found below its floor too, which would stretch a logarithmic axis down to round-off.
    let told = |m: &MethodSummary| {
        m.damping_ratio
            .filter(|zeta| m.damping_floor.is_none_or(|floor| zeta.abs() > floor))
    };
    let mut damping = curves(summary, RED, |b| b.damping_ratio, told, |p| p.damping_ratio);
    let all = points(&damping).count();
    for curve in &mut damping {
        curve.points.retain(|(_, _, zeta)| *zeta > 0.0);
    }
    let omitted = all - points(&damping).count();
    let ensemble = summary.ensemble.as_ref().map_or(&[][..], |ensemble| &ensemble.bands);
    let of = |colour, ends: &dyn Fn(&BandPoint) -> Option<[f64; 2]>| -> Vec<Band> {
        let points = ensemble
            .iter()
            .filter_map(|b| ends(b).map(|[l, h]| (b.response_displacement, l, h)));
        let points: Vec<_> = points.collect();
        // One point has no area.
        (points.len() > 1)
            .then_some(Band { colour, points })
            .into_iter()
            .collect()
    };
    let frequency_band = of(BLUE, &|b| {
        let [low, _, high] = b.frequency_first_harmonic_hz;
        Some([low, high])
    });
    let damping_band = of(RED, &|b| Some([b.damping_ratio[0]?, b.damping_ratio[2]?]));

    let root = root.titled(title, ("sans-serif", 20))?;
    let Some(amplitudes) = bounds(points(&frequency).map(|p| p.1)) else {
        let (x, y) = (SIZE.0 as i32 / 2 - 130, SIZE.1 as i32 / 2);
        let nothing = match summary.backbone.is_empty() && summary.methods.values().all(Vec::is_empty) {
            true => "no amplitude is asked for",
            false => "no amplitude converged",
        };
        root.draw(&Text::new(nothing, (x, y), ("sans-serif", 22)))?;
        return Ok(());
    };
    let x = widen(&amplitudes, 1.3);
    let x_ticks = ticks(&x);
    let (upper, lower) = root.split_vertically(SIZE.1 / 2 - 30);

    let Range { start, end } = bounds(heights(&frequency, &frequency_band)).unwrap_or(0.0..1.0);
    let margin = (0.08 * (end - start)).max(1e-3 * end);
    let y = start - margin..end + margin;
    panel(
        &upper,
        log(&x, &x_ticks),
        y,
        "frequency, first harmonic [Hz]",
        "",
        [&|x| length(*x), &|f| format!("{f:.2}")],
        &frequency,
        &frequency_band,
        SeriesLabelPosition::LowerLeft,
    )?;

    let y = bounds(heights(&damping, &damping_band)).map_or(1e-6..1.0, |range| widen(&range, 1.5));
    let y_ticks = ticks(&y);
    let bounds_below: Points = below_floor(summary, y.start);
    let below = bounds_below.len();
    damping.push(Curve {
        name: String::new(),
        colour: RED,
        dashes: None,
        marks: Marks::Bounds,
        points: bounds_below,
    });
    let label = format!("{}, by the linearised mode", amplitude_label(&summary.response));
    let chart_y = log(&y, &y_ticks);
    panel(
        &lower,
        log(&x, &x_ticks),
        chart_y,
        "damping ratio",
        &label,
        [&|x| length(*x), &|zeta| percent(*zeta)],
        &damping,
        &damping_band,
        SeriesLabelPosition::LowerRight,
    )?;
    let mut remarks = Vec::new();
    if omitted > 0 {
        remarks.push(format!("{omitted} of {all} points are not positive and left out"));
    }
    if below > 0 {
        remarks.push(format!(
            "open: {below} points below the floor, at background and floor or the lower edge"
        ));
    }
    if !remarks.is_empty() {
        lower.draw(&Text::new(remarks.join("; "), (110, 12), ("sans-serif", 14)))?;
    }
    Ok(())
}

/// The bounds of dampings whose friction is not told from zero: the background damping, which is in all dampings of the
/// diagram, and the floor. Those below `lowest` are put there.
fn below_floor(summary: &Summary, lowest: f64) -> Points {
    let background = summary.scene["background_damping"].as_f64().unwrap_or_default();
    let points = summary.backbone.iter().enumerate();
    let points = points.filter(|(_, b)| b.status == Status::BelowFloor);
    points
        .filter_map(|(i, b)| Some((i, b.response_displacement?, (background + b.damping_floor?).max(lowest))))
        .collect()
}

/// Sizes in a diagram (pixels).
#[derive(Clone, Copy)]
struct Look {
    /// Of a picture, and of each of its diagrams.
    size: [u32; 2],
    /// By how much lines, dashes and marks are larger than on a screen.
    lines: u32,
    /// Numbers at the axes, their names, and the legend.
    texts: [u32; 3],
    /// Room beside the axes: on the left, below without a name and below with one.
    axes: [u32; 3],
    /// Room around, and more on the right.
    margins: [u32; 2],
    /// Most ticks of a logarithmic axis.
    ticks: usize,
}

const SCREEN: Look = Look {
    size: [SIZE.0, 300],
    lines: 1,
    texts: [15, 16, 14],
    axes: [78, 30, 56],
    margins: [8, 24],
    ticks: usize::MAX,
};

/// Pixels of 0.1 pt, so that a column is 85 mm wide and texts have 8 pt; the library divides their sizes by 1.24.
const COLUMN: Look = Look {
    size: [2409, 1250],
    lines: 5,
    texts: [99; 3],
    axes: [410, 150, 270],
    margins: [40, 90],
    ticks: 5,
};

/// One diagram with curves and bands over two axes.
///
/// # Errors
/// The drawing library refuses.
pub fn panel<X, Y>(
    area: &Canvas<'_>,
    x: X,
    y: Y,
    y_label: &str,
    x_label: &str,
    texts: [&dyn Fn(&f64) -> String; 2],
    curves: &[Curve],
    bands: &[Band],
    legend: SeriesLabelPosition,
) -> Result<(), Drawing>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    panel_with(&SCREEN, area, x, y, [x_label, y_label], texts, curves, bands, legend)
}

fn panel_with<X, Y>(
    look: &Look,
    area: &Canvas<'_>,
    x: X,
    y: Y,
    [x_label, y_label]: [&str; 2],
    [x_text, y_text]: [&dyn Fn(&f64) -> String; 2],
    curves: &[Curve],
    bands: &[Band],
    legend: SeriesLabelPosition,
) -> Result<(), Drawing>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .margin(look.margins[0])
        .margin_right(look.margins[1])
        .set_label_area_size(LabelAreaPosition::Left, look.axes[0])
        .set_label_area_size(
            LabelAreaPosition::Bottom,
            look.axes[if x_label.is_empty() { 1 } else { 2 }],
        )
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(look.lines))
        .axis_style(BLACK.stroke_width(look.lines))
        .set_all_tick_mark_size(5 * look.lines)
        .label_style(("sans-serif", look.texts[0]))
        .axis_desc_style(("sans-serif", look.texts[1]))
        .x_label_formatter(x_text)
        .y_label_formatter(y_text)
        .y_labels(7)
        .x_desc(x_label)
        .y_desc(y_label)
        .draw()?;
    let lines = curves.iter().filter(|curve| curve.marks.has_line()).count();
    // One solid line is what the title says; a dashed one stands beside it, or in its place.
    let several = lines > 1 || curves.iter().any(|curve| curve.dashes.is_some());
    let legend_wanted = several && curves.iter().any(|curve| !curve.name.is_empty());
    for band in bands {
        let lower = band.points.iter().map(|&(x, low, _)| (x, low));
        let outline: Vec<(f64, f64)> = lower
            .chain(band.points.iter().rev().map(|&(x, _, high)| (x, high)))
            .collect();
        chart.draw_series([Polygon::new(outline, band.colour.mix(0.2).filled())])?;
    }
    for curve in curves {
        let style = curve.colour.stroke_width(2 * look.lines);
        let dashes = curve.dashes.map(|of| (look.lines * of.0, look.lines * of.1));
        let has_line = curve.marks.has_line();
        for run in curve.points.chunk_by(|a, b| a.0 + 1 == b.0).filter(|_| has_line) {
            let line = run.iter().map(|p| (p.1, p.2));
            match dashes {
                None => chart.draw_series(LineSeries::new(line, style))?,
                Some((length, spacing)) => chart.draw_series(DashedLineSeries::new(line, length, spacing, style))?,
            };
        }
        let (filled, outline) = (curve.colour.filled(), curve.colour.stroke_width(look.lines));
        let [circle, triangle, cross] = [3, 6, 5].map(|size| size * look.lines as i32);
        let marked = curve.points.iter().map(|p| (p.1, p.2));
        let drawn = match curve.marks {
            Marks::None => chart.draw_series(std::iter::empty::<Circle<_, i32>>())?,
            Marks::Dots => chart.draw_series(marked.map(|p| Circle::new(p, circle, filled)))?,
            Marks::Bounds => chart.draw_series(marked.map(|p| Circle::new(p, circle, outline)))?,
            Marks::Triangles => chart.draw_series(marked.map(|p| TriangleMarker::new(p, triangle, filled)))?,
            Marks::Crosses => chart.draw_series(marked.map(|p| Cross::new(p, cross, style)))?,
        };
        if !legend_wanted || curve.name.is_empty() {
            continue;
        }
        let named = drawn.label(&curve.name);
        let sample = SAMPLE * look.lines;
        let middle = sample as i32 / 2;
        match curve.marks {
            Marks::None | Marks::Dots => {
                let (length, spacing) = dashes.unwrap_or((sample, 1));
                named.legend(move |(x, y)| {
                    let ends = [(x, y), (x + sample as i32, y)];
                    DashedPathElement::new(ends, length, spacing, style)
                })
            }
            Marks::Bounds => named.legend(move |(x, y)| Circle::new((x + middle, y), circle, outline)),
            Marks::Triangles => named.legend(move |(x, y)| TriangleMarker::new((x + middle, y), triangle, filled)),
            Marks::Crosses => named.legend(move |(x, y)| Cross::new((x + middle, y), cross, style)),
        };
    }
    if legend_wanted {
        chart
            .configure_series_labels()
            .position(legend)
            .legend_area_size((SAMPLE + 6) * look.lines)
            .margin(10 * look.lines)
            .label_font(("sans-serif", look.texts[2]))
            .background_style(WHITE.mix(0.8))
            .draw()?;
    }
    Ok(())
}

/// How the numbers of an axis are written.
pub type Numbers = fn(&f64) -> String;

/// One diagram among several over the same abscissa.
pub struct Panel {
    /// Text beside the ordinate.
    pub y_label: &'static str,
    /// How the numbers of a logarithmic ordinate, where points that are not positive are left out, are written; none for a linear one.
    pub log: Option<Numbers>,
    /// Corner of the legend.
    pub legend: SeriesLabelPosition,
    /// What is drawn.
    pub curves: Vec<Curve>,
}

/// Diagrams above one another; their abscissa is logarithmic on request.
///
/// # Errors
/// [`Error::Picture`].
pub fn stack(x_label: &str, x_log: bool, panels: Vec<Panel>) -> Result<String, Error> {
    let panels = panels.into_iter().map(|panel| (panel, Vec::new())).collect();
    let x_text: &dyn Fn(&f64) -> String = if x_log { &power } else { &plain };
    stack_with(&SCREEN, x_label, x_log, x_text, panels)
}

/// Diagrams of curves and bands above one another, over a logarithmic abscissa with these numbers, for a column of a paper: 85 mm wide, texts of
/// 8 pt.
///
/// # Errors
/// [`Error::Picture`].
pub(crate) fn column(
    x_label: &str,
    x_text: &dyn Fn(&f64) -> String,
    panels: Vec<(Panel, Vec<Band>)>,
) -> Result<String, Error> {
    stack_with(&COLUMN, x_label, true, x_text, panels)
}

fn stack_with(
    look: &Look,
    x_label: &str,
    x_log: bool,
    x_text: &dyn Fn(&f64) -> String,
    panels: Vec<(Panel, Vec<Band>)>,
) -> Result<String, Error> {
    let size = (look.size[0], look.size[1] * panels.len() as u32 + 20);
    picture("diagrams", size, |root| {
        let of_bands = panels.iter().flat_map(|panel| &panel.1).flat_map(|band| &band.points);
        let of_curves = panels.iter().flat_map(|panel| points(&panel.0.curves));
        let all = of_curves.map(|p| p.1).chain(of_bands.map(|p| p.0));
        let all = bounds(all.filter(|x| x.is_finite() && (!x_log || *x > 0.0))).unwrap_or(1.0..10.0);
        let x = if x_log { widen(&all, 1.3) } else { margin(&all) };
        let x_ticks = few(ticks(&x), look.ticks);
        let last = panels.len().saturating_sub(1);
        for ((index, (mut diagram, bands)), area) in
            panels.into_iter().enumerate().zip(root.split_evenly((last + 1, 1)))
        {
            let label = if index == last { x_label } else { "" };
            for curve in &mut diagram.curves {
                let drawable = |x: f64, y: f64| x.is_finite() && y.is_finite() && (!x_log || x > 0.0);
                curve
                    .points
                    .retain(|(_, x, y)| drawable(*x, *y) && (diagram.log.is_none() || *y > 0.0));
            }
            let range = bounds(heights(&diagram.curves, &bands)).unwrap_or(1.0..10.0);
            let (curves, legend, name) = (&diagram.curves, diagram.legend, diagram.y_label);
            let y = if diagram.log.is_some() {
                widen(&range, 1.5)
            } else {
                margin(&range)
            };
            let y_ticks = few(ticks(&y), look.ticks);
            let (linear_text, log_text) = (decimals(&y), diagram.log.unwrap_or(power));
            let axis = [x_text, &log_text as &dyn Fn(&f64) -> String];
            let linear = [x_text, &linear_text as &dyn Fn(&f64) -> String];
            let (labels, log_x) = ([label, name], log(&x, &x_ticks));
            match (x_log, diagram.log.is_some()) {
                (true, true) => {
                    let y = log(&y, &y_ticks);
                    panel_with(look, &area, log_x, y, labels, axis, curves, &bands, legend)
                }
                (true, false) => panel_with(look, &area, log_x, y, labels, linear, curves, &bands, legend),
                (false, true) => {
                    let y = log(&y, &y_ticks);
                    panel_with(look, &area, x.clone(), y, labels, axis, curves, &bands, legend)
                }
                (false, false) => panel_with(look, &area, x.clone(), y, labels, linear, curves, &bands, legend),
            }?;
        }
        Ok(())
    })
}

/// A number of a linear axis with six decimals at most: those computed in floating point are off by a unit in the last place.
pub(crate) fn plain(value: &f64) -> String {
    // The sum turns a negative zero into a positive one. Multiplying by 1e-6 would be off again.
    format!("{}", (1e6 * value).round() / 1e6 + 0.0)
}

/// The range with some air at both ends.
pub(crate) fn margin(range: &Range<f64>) -> Range<f64> {
    let air = (0.08 * (range.end - range.start)).max(1e-3 * range.end.abs());
    range.start - air..range.end + air
}

/// Numbers of a linear axis with as many decimals as its range asks for.
pub(crate) fn decimals(range: &Range<f64>) -> impl Fn(&f64) -> String + use<> {
    let places = (1.0 - (range.end - range.start).log10().floor()).clamp(0.0, 6.0) as usize;
    move |v| format!("{v:.places$}")
}

/// Smallest and largest of the values; none without values.
pub fn bounds(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let range = values.fold(f64::INFINITY..f64::NEG_INFINITY, |r, v| r.start.min(v)..r.end.max(v));
    (range.start <= range.end).then_some(range)
}

/// The range widened by a factor at both ends, for logarithmic axes.
pub fn widen(range: &Range<f64>, factor: f64) -> Range<f64> {
    range.start / factor..range.end * factor
}

/// A logarithmic axis with these ticks.
pub fn log(range: &Range<f64>, ticks: &[f64]) -> WithKeyPoints<LogCoord<f64>> {
    range.clone().log_scale().with_key_points(ticks.to_vec())
}

/// At most about ten ticks of a logarithmic axis: powers of ten, or 1, 2 and 5 times them on short axes.
pub fn ticks(range: &Range<f64>) -> Vec<f64> {
    let (first, last) = (range.start.log10().floor() as i32, range.end.log10().ceil() as i32);
    let (stride, factors): (usize, &[f64]) = match last - first {
        0..=3 => (1, &[1.0, 2.0, 5.0]),
        span => ((span as usize).div_ceil(10), &[1.0]),
    };
    let decades = (first..=last).step_by(stride);
    decades
        .flat_map(|n| factors.iter().map(move |f| f * 10_f64.powi(n)))
        .filter(|t| range.contains(t))
        .collect()
}

/// The ticks, or if they are too many the powers of ten among them, or some of these.
fn few(ticks: Vec<f64>, most: usize) -> Vec<f64> {
    if ticks.len() <= most {
        return ticks;
    }
    let is_power = |tick: &f64| (tick.log10() - tick.log10().round()).abs() < 1e-9;
    let powers: Vec<f64> = ticks.into_iter().filter(is_power).collect();
    let step = powers.len().div_ceil(most).max(1);
    powers.into_iter().step_by(step).collect()
}

/// `m x 10^n`, without `m` where it is one.
pub fn power(value: &f64) -> String {
    let text = format!("{value:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa: f64 = mantissa.parse().unwrap_or(f64::NAN);
    let superscript: String = exponent
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            c => c
                .to_digit(10)
                .map_or(c, |d| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][d as usize]),
        })
        .collect();
    // Powers computed in floating point are off by a unit in the last place.
    if (mantissa - 1.0).abs() < 1e-9 {
        format!("10{superscript}")
    } else {
        format!("{mantissa:.0}·10{superscript}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_a_readable_number_of_ticks() {
        for (start, end) in [(1e-7, 1e-3), (3e-8, 4e-8), (1e-20, 1.0), (0.9, 1.1), (2e-3, 7e-1)] {
            let found = ticks(&(start..end));
            assert!(found.len() <= 12, "{start} to {end}: {found:?}");
            assert!(found.iter().all(|t| (start..end).contains(t)));
        }
        assert_eq!(ticks(&(0.5e-7..2e-3)).len(), 5);
    }

    #[test]
    fn numbers_of_linear_axes_are_short() {
        for (start, step) in [(0.0, 0.05), (-0.3, 0.1), (0.0, 0.25), (1.0, 0.002), (-70.0, 0.7)] {
            for i in 0..200 {
                let text = plain(&(start + f64::from(i) * step));
                assert!(text.len() <= 7 && text != "-0", "{start} + {i} {step}: {text}");
            }
        }
        assert_eq!(plain(&0.05), "0.05");
    }

    #[test]
    fn powers_of_ten_are_written_as_such() {
        assert_eq!(power(&1e-6), "10⁻⁶");
        assert_eq!(power(&10_f64.powi(-11)), "10⁻¹¹");
        assert_eq!(power(&2e-3), "2·10⁻³");
        assert_eq!(power(&1.0), "10⁰");
    }
}
