//! Colours and dashes of curves, in pictures and on pages.

use plotters::style::RGBColor;
use serde_json::{Map, Value, json};

/// Colours of what is compared, in order, told apart by readers who confuse red and green as well (Okabe and Ito, 2008).
pub const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(140, 140, 140),
];

/// How the curve of a method is drawn.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    pub(crate) colour: RGBColor,
    /// Length and spacing of its dashes (pixels); none: a solid line with marked points.
    pub(crate) dashes: Option<(u32, u32)>,
}

/// By the names of scenes and summaries; the colours differ in lightness too.
const METHODS: [(&str, Style); 5] = [
    ("cqsma", style(RGBColor(31, 93, 153), None)),
    ("qsma", style(RGBColor(214, 126, 0), Some((9, 5)))),
    ("masing", style(RGBColor(34, 130, 60), Some((2, 4)))),
    ("rqnma", style(RGBColor(122, 58, 150), Some((14, 4)))),
    ("epmc", style(RGBColor(0, 122, 135), Some((7, 3)))),
];

const fn style(colour: RGBColor, dashes: Option<(u32, u32)>) -> Style {
    Style { colour, dashes }
}

/// The style of a method; of what has none, that of CQSMA.
pub(crate) fn of_method(name: &str) -> Style {
    let found = METHODS.iter().find(|(known, _)| *known == name);
    found.map_or(METHODS[0].1, |(_, style)| *style)
}

/// Name of a method as it is written.
pub fn title(method: &str) -> String {
    match method {
        "masing" => "Masing".into(),
        acronym => acronym.to_uppercase(),
    }
}

/// A colour as pages have it.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Both tables for the scripts of pages: `STYLES` by the written names of methods, and `COLOURS`.
pub(crate) fn script() -> String {
    let hex = |RGBColor(r, g, b)| hex([r, g, b]);
    let styles = METHODS.iter().map(|(name, style)| {
        let mut fields = Map::new();
        fields.insert("colour".into(), json!(hex(style.colour)));
        match style.dashes {
            Some((length, space)) => fields.insert("dash".into(), json!([length, space])),
            None => fields.insert("marks".into(), json!(true)),
        };
        (title(name), Value::Object(fields))
    });
    let styles: Map<String, Value> = styles.collect();
    format!(
        "const STYLES = {};\nconst COLOURS = {};\n",
        Value::Object(styles),
        json!(COLOURS.map(hex))
    )
}
