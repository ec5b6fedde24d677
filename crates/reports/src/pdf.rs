//! Pictures of this crate as PDF: one page, lines and areas as they are, texts in Helvetica, which every reader of PDF has.
//!
//! What maintained crates need for it (`svg2pdf`: 71 packages and a font on the computer) is more than what the pictures use of SVG: rectangles,
//! lines, polygons, circles, paths of straight lines, texts and groups. Anything else is refused.

use crate::Error;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use quick_xml::events::{BytesStart, Event};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::Write as _;

/// Widths of the characters from space to tilde in Helvetica (1/1000 of the size; Adobe's Core 14 metrics).
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833,
    722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556,
    556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334,
    260, 334, 584,
];

/// Raised characters, and what is raised.
const RAISED: [(char, u8); 11] = [
    ('⁻', b'-'),
    ('⁰', b'0'),
    ('¹', b'1'),
    ('²', b'2'),
    ('³', b'3'),
    ('⁴', b'4'),
    ('⁵', b'5'),
    ('⁶', b'6'),
    ('⁷', b'7'),
    ('⁸', b'8'),
    ('⁹', b'9'),
];

/// Size of raised characters, and their height above the line, over the size of the text.
const SMALLER: f64 = 0.7;
const RISE: f64 = 0.35;

/// Attributes that groups pass on.
const INHERITED: [&str; 6] = [
    "fill",
    "stroke",
    "stroke-width",
    "stroke-opacity",
    "font-size",
    "text-anchor",
];

/// Attributes of an element, with those that it has from the groups around it.
type Attributes = BTreeMap<String, String>;

fn refused(what: impl Into<String>) -> Error {
    Error::Pdf { what: what.into() }
}

/// The picture as a document of one page, as wide as the SVG says in mm. The same picture gives the same bytes.
///
/// # Errors
/// [`Error::Pdf`] for text that Helvetica has no characters for, and for what this crate does not draw.
pub fn from_svg(svg: &str) -> Result<Vec<u8>, Error> {
    let mut xml = quick_xml::Reader::from_str(svg);
    let mut page = Page::default();
    let mut around = vec![Attributes::new()];
    loop {
        match xml.read_event().map_err(|error| refused(error.to_string()))? {
            Event::Start(element) => {
                let own = attributes(&element, &around)?;
                page.begin(element.name().as_ref(), &own)?;
                page.text.clear();
                around.push(own);
            }
            Event::Empty(element) => {
                page.begin(element.name().as_ref(), &attributes(&element, &around)?)?;
                page.content += "Q\n";
            }
            Event::End(element) => {
                let own = around.pop().unwrap_or_default();
                if element.name().as_ref() == "text" {
                    page.write(&own)?;
                }
                page.content += "Q\n";
            }
            Event::Text(text) => page.text += &text.into_inner(),
            Event::GeneralRef(name) => match quick_xml::escape::resolve_xml_entity(&name.into_inner()) {
                Some(character) => page.text += character,
                None => return Err(refused("an entity that XML does not have")),
            },
            Event::Eof => break,
            _ => {}
        }
    }
    Ok(page.document())
}

fn attributes(element: &BytesStart<'_>, around: &[Attributes]) -> Result<Attributes, Error> {
    let mut all = around.last().cloned().unwrap_or_default();
    all.retain(|name, _| INHERITED.contains(&name.as_str()));
    for attribute in element.attributes() {
        let attribute = attribute.map_err(|error| refused(error.to_string()))?;
        let value = attribute.normalized_value(quick_xml::XmlVersion::Implicit1_0);
        let value = value.map_err(|error| refused(error.to_string()))?;
        all.insert(attribute.key.as_ref().into(), value.into_owned());
    }
    Ok(all)
}

/// The numbers of a list.
fn numbers(text: &str) -> Result<Vec<f64>, Error> {
    let words = text.split([' ', ',', '\n']).filter(|word| !word.is_empty());
    words
        .map(|word| word.parse().map_err(|_| refused(format!("the number `{word}`"))))
        .collect()
}

/// A number of an attribute, or what stands for one that is missing.
fn number(of: &Attributes, name: &str, missing: f64) -> f64 {
    of.get(name).and_then(|text| text.parse().ok()).unwrap_or(missing)
}

/// Red, green and blue (0 to 1) of `#rgb` or `#rrggbb`; none where nothing is to be painted.
fn colour(of: &Attributes, name: &str, missing: &str) -> Result<Option<[f64; 3]>, Error> {
    let text = of.get(name).map_or(missing, String::as_str);
    let digits: Option<Vec<u32>> = text
        .strip_prefix('#')
        .map(|hex| hex.chars().filter_map(|c| c.to_digit(16)).collect());
    match digits.as_deref() {
        None if text == "none" => Ok(None),
        Some(&[r, g, b]) => Ok(Some([r, g, b].map(|digit| f64::from(17 * digit) / 255.0))),
        Some(&[r, s, g, h, b, c]) => Ok(Some(
            [16 * r + s, 16 * g + h, 16 * b + c].map(|byte| f64::from(byte) / 255.0),
        )),
        _ => Err(refused(format!("the colour `{text}`"))),
    }
}

#[derive(Default)]
struct Page {
    /// Width and height (pt).
    size: [f64; 2],
    content: String,
    /// Opacities of strokes and areas, in thousandths.
    opacities: BTreeSet<[u32; 2]>,
    /// The text since the last tag.
    text: String,
}

impl Page {
    fn put(&mut self, values: &[f64], operator: &str) {
        for value in values {
            // Adding zero turns -0 into 0. Writing to a string cannot fail.
            let _ = write!(self.content, "{} ", (1e3 * value).round() / 1e3 + 0.0);
        }
        self.content += operator;
        self.content.push('\n');
    }

    fn line(&mut self, points: &[[f64; 2]]) {
        for (index, point) in points.iter().enumerate() {
            self.put(point, if index == 0 { "m" } else { "l" });
        }
    }

    /// What an element draws; `Q` ends what is said of it.
    fn begin(&mut self, name: &str, of: &Attributes) -> Result<(), Error> {
        let at = |name: &str| number(of, name, 0.0);
        self.content += "q\n";
        if name == "svg" {
            let [_, _, width, height] = numbers(of.get("viewBox").map_or("", String::as_str))?[..] else {
                return Err(refused("no viewBox"));
            };
            let millimetres = of
                .get("width")
                .and_then(|text| text.strip_suffix("mm")?.parse::<f64>().ok());
            let scale = millimetres.ok_or_else(|| refused("no width in mm"))? * 72.0 / 25.4 / width;
            self.size = [scale * width, scale * height];
            self.put(&[scale, 0.0, 0.0, -scale, 0.0, scale * height], "cm");
        }
        for one in of.get("transform").iter().flat_map(|text| text.split_terminator(')')) {
            let (what, values) = one.split_once('(').unwrap_or_default();
            match (what.trim(), &numbers(values)?[..]) {
                ("translate", &[x, y]) => self.put(&[1.0, 0.0, 0.0, 1.0, x, y], "cm"),
                ("scale", &[by]) => self.put(&[by, 0.0, 0.0, by, 0.0, 0.0], "cm"),
                ("rotate", &[angle, x, y]) => {
                    let (sine, cosine) = angle.to_radians().sin_cos();
                    let [to_x, to_y] = [x - cosine * x + sine * y, y - sine * x - cosine * y];
                    self.put(&[cosine, sine, -sine, cosine, to_x, to_y], "cm");
                }
                _ => return Err(refused(format!("the transformation `{one}`"))),
            }
        }
        if ["svg", "g", "text"].contains(&name) {
            return Ok(());
        }
        let paint = self.style(of)?;
        match name {
            "rect" => {
                self.put(&[at("x"), at("y"), at("width"), at("height")], "re");
            }
            "line" => self.line(&[[at("x1"), at("y1")], [at("x2"), at("y2")]]),
            "polyline" | "polygon" => {
                let points = numbers(of.get("points").map_or("", String::as_str))?;
                self.line(points.as_chunks().0);
                if name == "polygon" {
                    self.content += "h\n";
                }
            }
            "circle" => {
                let (x, y, r) = (at("cx"), at("cy"), at("r"));
                // Distance of the control points of a quarter of a circle.
                let c = 0.552_284_75 * r;
                self.put(&[x + r, y], "m");
                for [a, b, d, e, f, g] in [
                    [r, c, c, r, 0.0, r],
                    [-c, r, -r, c, -r, 0.0],
                    [-r, -c, -c, -r, 0.0, -r],
                    [c, -r, r, -c, r, 0.0],
                ] {
                    self.put(&[x + a, y + b, x + d, y + e, x + f, y + g], "c");
                }
                self.content += "h\n";
            }
            "path" => self.path(of.get("d").map_or("", String::as_str))?,
            other => return Err(refused(format!("the element `{other}`"))),
        }
        self.put(&[], paint);
        Ok(())
    }

    /// Sets colours, width and opacity; the operator that paints a path.
    fn style(&mut self, of: &Attributes) -> Result<&'static str, Error> {
        let (fill, stroke) = (colour(of, "fill", "#000")?, colour(of, "stroke", "none")?);
        let thousandths = |name: &str| (1e3 * number(of, name, 1.0)).round().clamp(0.0, 1e3) as u32;
        let both = thousandths("opacity");
        let opacities = [both * thousandths("stroke-opacity") / 1000, both];
        if opacities != [1000; 2] {
            self.opacities.insert(opacities);
            let _ = writeln!(self.content, "/O{}-{} gs", opacities[0], opacities[1]);
        }
        if let Some(rgb) = fill {
            self.put(&rgb, "rg");
        }
        if let Some(rgb) = stroke {
            self.put(&rgb, "RG");
            self.put(&[number(of, "stroke-width", 1.0)], "w");
            // Round joins.
            self.put(&[1.0], "j");
        }
        Ok(match (fill.is_some(), stroke.is_some()) {
            (true, true) => "B",
            (true, false) => "f",
            (false, true) => "S",
            (false, false) => "n",
        })
    }

    /// Straight lines, by the commands that this crate writes; numbers after those that a command needs go on with it.
    fn path(&mut self, d: &str) -> Result<(), Error> {
        let [mut x, mut y] = [0.0; 2];
        let commands: Vec<(usize, char)> = d.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()).collect();
        let ends = commands.iter().skip(1).map(|(at, _)| *at).chain([d.len()]);
        for ((at, command), end) in commands.iter().zip(ends) {
            let values = numbers(&d[at + 1..end])?;
            let is_relative = command.is_ascii_lowercase();
            let step = if "HVhvZz".contains(*command) { 1 } else { 2 };
            match command {
                'Z' | 'z' if values.is_empty() => self.content += "h\n",
                'M' | 'L' | 'l' | 'H' | 'h' | 'V' | 'v' if values.len() % step == 0 => {
                    for (number, to) in values.chunks(step).enumerate() {
                        let [from_x, from_y] = if is_relative { [x, y] } else { [0.0; 2] };
                        match (command.to_ascii_uppercase(), to) {
                            ('V', _) => y = from_y + to[0],
                            ('H', _) => x = from_x + to[0],
                            _ => [x, y] = [from_x + to[0], from_y + to[1]],
                        }
                        self.put(&[x, y], if *command == 'M' && number == 0 { "m" } else { "l" });
                    }
                }
                _ => return Err(refused(format!("`{command}` with {} numbers in a path", values.len()))),
            }
        }
        Ok(())
    }

    /// The text before its end tag.
    fn write(&mut self, of: &Attributes) -> Result<(), Error> {
        let size = number(of, "font-size", 16.0);
        // Runs of characters on the line and of raised ones.
        let mut runs: Vec<(bool, Vec<u8>)> = Vec::new();
        for character in self.text.trim().chars() {
            let raised = RAISED.iter().find(|(of, _)| *of == character).map(|(_, byte)| *byte);
            let byte = match (raised, character) {
                (Some(byte), _) => byte,
                (None, '–') => 0x96,
                // Where the encoding of Windows is Unicode.
                (None, ' '..='~' | '\u{a0}'..='ÿ') => character as u32 as u8,
                _ => {
                    return Err(refused(format!(
                        "text with `{character}`, which Helvetica does not have: give another name, or --out with .svg"
                    )));
                }
            };
            match runs.last_mut().filter(|(is_raised, _)| *is_raised == raised.is_some()) {
                Some((_, run)) => run.push(byte),
                None => runs.push((raised.is_some(), vec![byte])),
            }
        }
        // Beyond ASCII as wide as a digit: the dot between factors and dashes stand in short texts alone.
        let width =
            |byte: &u8| f64::from(WIDTHS.get(usize::from(*byte).wrapping_sub(32)).copied().unwrap_or(556)) / 1e3;
        let widths = runs.iter().map(|(is_raised, run)| {
            let factor = if *is_raised { SMALLER } else { 1.0 };
            factor * size * run.iter().map(width).sum::<f64>()
        });
        let anchor = match of.get("text-anchor").map(String::as_str) {
            Some("middle") => 0.5,
            Some("end") => 1.0,
            _ => 0.0,
        };
        let x = number(of, "x", 0.0) - anchor * widths.sum::<f64>();
        let down = match of.get("dy").map(String::as_str) {
            None => 0.0,
            Some("0.76em") => 0.76,
            Some("0.5ex") => 0.26,
            Some("-0.5ex") => -0.26,
            Some(other) => return Err(refused(format!("text that is lowered by `{other}`"))),
        };
        self.style(of)?;
        self.content += "BT\n";
        self.put(&[1.0, 0.0, 0.0, -1.0, x, number(of, "y", 0.0) + down * size], "Tm");
        for (is_raised, run) in runs {
            let (smaller, rise) = if is_raised { (SMALLER, RISE) } else { (1.0, 0.0) };
            self.content += "/F ";
            self.put(&[smaller * size], "Tf");
            self.put(&[rise * size], "Ts");
            let hex: String = run.iter().map(|byte| format!("{byte:02x}")).collect();
            let _ = writeln!(self.content, "<{hex}> Tj");
        }
        self.content += "ET\n";
        Ok(())
    }

    fn document(self) -> Vec<u8> {
        let mut deflated = ZlibEncoder::new(Vec::new(), Compression::default());
        // Writing to memory cannot fail.
        let _ = deflated.write_all(self.content.as_bytes());
        let stream = deflated.finish().unwrap_or_default();
        let states: String = (self.opacities.iter())
            .map(|[line, area]| {
                let [of_line, of_area] = [line, area].map(|thousandths| f64::from(*thousandths) / 1e3);
                format!("/O{line}-{area} << /CA {of_line} /ca {of_area} >> ")
            })
            .collect();
        let [width, height] = self.size;
        let objects = [
            "<< /Type /Catalog /Pages 2 0 R >>".into(),
            "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".into(),
            format!(
                "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width:.3} {height:.3}] /Contents 5 0 R /Resources << /Font << /F 4 0 R >> \
                 /ExtGState << {states}>> >> >>"
            ),
            "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>".into(),
            format!("<< /Length {} /Filter /FlateDecode >>\nstream\n", stream.len()),
        ];
        // The second line tells programs that the file is not text.
        let mut out = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n".to_vec();
        let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
        for (index, object) in objects.iter().enumerate() {
            let _ = writeln!(table, "{:010} 00000 n ", out.len());
            out.extend(format!("{} 0 obj\n{object}", index + 1).bytes());
            if index + 1 == objects.len() {
                out.extend_from_slice(&stream);
                out.extend_from_slice(b"\nendstream");
            }
            out.extend_from_slice(b"\nendobj\n");
        }
        let end = format!(
            "trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n",
            objects.len() + 1,
            out.len()
        );
        out.extend(table.bytes());
        out.extend(end.bytes());
        out
    }
}

#[cfg(test)]
mod tests {
    use super::from_svg;
    use flate2::read::ZlibDecoder;
    use std::io::Read;

    fn picture(body: &str) -> String {
        format!("<svg width=\"25.4mm\" viewBox=\"0 0 36 18\" xmlns=\"http://www.w3.org/2000/svg\">{body}</svg>")
    }

    /// The operators of a picture.
    fn content(body: &str) -> String {
        let bytes = from_svg(&picture(body)).unwrap();
        let start = bytes.windows(7).position(|window| window == b"stream\n").unwrap() + 7;
        let mut text = String::new();
        ZlibDecoder::new(&bytes[start..]).read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn what_is_drawn_keeps_its_place() {
        let pdf = from_svg(&picture("")).unwrap();
        // An inch wide; a unit of the picture is two points, and y runs downwards.
        assert!(String::from_utf8_lossy(&pdf).contains("/MediaBox [0 0 72.000 36.000]"));
        assert!(content("").contains("2 0 0 -2 0 36 cm"));
        let path = content("<path d=\"M1 2l3 4 5 -1H2v-1z\" fill=\"none\" stroke=\"#f00\" stroke-width=\".5\"/>");
        assert!(path.contains("1 0 0 RG\n0.5 w\n") && path.contains("1 2 m\n4 6 l\n9 5 l\n2 5 l\n2 4 l\nh\nS\nQ"));
        let nested = content(
            "<g transform=\"translate(3 4)scale(.5)\" fill=\"#00ff00\"><rect x=\"1\" y=\"1\" width=\"2\" height=\"3\"/></g>",
        );
        assert!(nested.contains("1 0 0 1 3 4 cm\n0.5 0 0 0.5 0 0 cm\nq\n0 1 0 rg\n1 1 2 3 re\nf\nQ"));
        let faint = content("<polygon points=\"0,0 1,0 1,1\" fill=\"#000\" opacity=\"0.2\"/>");
        assert!(faint.contains("/O200-200 gs"));
        let turned =
            content("<line x1=\"0\" y1=\"0\" x2=\"1\" y2=\"0\" stroke=\"#000\" transform=\"rotate(90, 2, 3)\"/>");
        assert!(turned.contains("0 1 -1 0 5 1 cm"), "{turned}");
    }

    #[test]
    fn texts_have_raised_digits_and_widths_of_helvetica() {
        // `10` and `-7` raised: (2 556 + 0.7 (333 + 556)) / 1000 of the size, half of it to the left of the middle.
        let text = content("<text x=\"20\" y=\"5\" font-size=\"10\" text-anchor=\"middle\">10⁻⁷ </text>");
        assert!(text.contains("1 0 0 -1 11.329 5 Tm"), "{text}");
        assert!(text.contains("<3130> Tj\n/F 7 Tf\n3.5 Ts\n<2d37> Tj"), "{text}");
        assert!(content("<text x=\"1\" y=\"1\">a &lt; b</text>").contains("<61203c2062> Tj"));
    }

    #[test]
    fn what_is_not_drawn_is_refused() {
        for (body, part) in [
            ("<ellipse/>", "the element `ellipse`"),
            ("<path d=\"M0 0C1 1 2 2 3 3\"/>", "`C` with 6 numbers"),
            ("<path d=\"M0 0L1\"/>", "`L` with 1 numbers"),
            ("<path d=\"M0 0L1 0.0.1\"/>", "`0.0.1`"),
            ("<g transform=\"skewX(3)\"/>", "skewX"),
            ("<rect fill=\"red\"/>", "the colour `red`"),
            ("<text>\u{03bc}</text>", "Helvetica does not have"),
            ("<g>", "PDF"),
        ] {
            let error = from_svg(&picture(body)).unwrap_err().to_string();
            assert!(error.contains(part), "{body}: {error}");
        }
        assert!(
            from_svg("<svg width=\"85mm\"></svg>")
                .unwrap_err()
                .to_string()
                .contains("no viewBox")
        );
        assert!(
            from_svg("<svg viewBox=\"0 0 1 1\"></svg>")
                .unwrap_err()
                .to_string()
                .contains("no width in mm")
        );
    }
}
