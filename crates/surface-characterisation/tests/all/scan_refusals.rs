//! Dialects of text, and what is refused: every message names file, place and remedy.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::{Cursor, Read, Write};

use surface_characterisation::readers::{
    self, Declaration, FileError, FirstRow, Format, LengthUnit, Options, Scan, Source,
};
use surface_characterisation::{HeightMap, writers};

fn parse(bytes: &[u8], options: &Options) -> Result<Scan, FileError> {
    readers::parse(Source { name: "face", bytes }, options)
}

#[track_caller]
fn refused(bytes: &[u8], options: &Options, expected: &str) {
    let message = match parse(bytes, options) {
        Err(e) => e.to_string(),
        Ok(scan) => panic!(
            "read as {} x {} points, should say: {expected}",
            scan.map.nx(),
            scan.map.ny()
        ),
    };
    assert!(message.starts_with("face"), "{message}");
    assert!(message.contains(expected), "{message}\nshould say: {expected}");
}

fn grid() -> Options {
    Options {
        lateral_unit: Some(LengthUnit::Millimetre),
        height_unit: Some(LengthUnit::Micrometre),
        lateral_step: Some([0.1, 0.2]),
        ..Options::default()
    }
}

fn points() -> Options {
    Options {
        lateral_step: None,
        ..grid()
    }
}

/// Heights of the map in um, a row per line.
fn heights(scan: &Scan) -> Vec<Vec<Option<f64>>> {
    let row = |j| {
        (0..scan.map.nx())
            .map(|i| scan.map.height(i, j).map(|z| z * 1e6))
            .collect()
    };
    (0..scan.map.ny()).map(row).collect()
}

fn utf16(text: &str, big: bool) -> Vec<u8> {
    let units = std::iter::once(0xfeff).chain(text.encode_utf16());
    units
        .flat_map(|u| if big { u.to_be_bytes() } else { u.to_le_bytes() })
        .collect()
}

#[test]
fn dialects_of_grids() {
    let expected = [
        [Some(1.5), Some(2.0), Some(-3.25), Some(4.0)],
        [Some(0.5), None, Some(1.0), Some(2.0)],
        [Some(7.0), Some(8.0), Some(9.0), Some(10.5)],
    ]
    .map(|row| row.to_vec());
    let same = |bytes: &[u8]| {
        let scan = parse(bytes, &grid()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scan.format, Format::Grid);
        for (found, expected) in heights(&scan).concat().iter().zip(expected.concat()) {
            let close = match (found, expected) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-12,
                (a, b) => a.is_none() && b.is_none(),
            };
            assert!(close, "{}", String::from_utf8_lossy(bytes));
        }
        assert_eq!((scan.map.nx(), scan.map.ny()), (4, 3));
        assert_eq!(scan.map.step(), [0.1e-3, 0.2e-3]);
        scan
    };
    let comma = "1.5,2,-3.25,4\n0.5,NaN,1,2\n7,8,9,10.5\n";
    same(comma.as_bytes());
    same(comma.replace(',', ", ").as_bytes());
    same(comma.replace(',', "\t").as_bytes());
    same(comma.replace(',', "   ").as_bytes());
    same(comma.replace('\n', "\r\n").as_bytes());
    same(comma.replace('\n', "\r").as_bytes());
    same(comma.replace("NaN", "BAD").as_bytes());
    same(comma.replace("NaN", "***").as_bytes());
    same(comma.replace("NaN", "").as_bytes());
    same(comma.replace("NaN", "").replace(',', "\t").as_bytes());
    same(comma.replace("1.5,", "+1.5E+00,").as_bytes());
    same(format!("\u{feff}{comma}").as_bytes());
    same(&utf16(comma, false));
    same(&utf16(&comma.replace('\n', "\r\n"), true));
    // Decimal commas.
    let german = comma.replace(',', ";").replace('.', ",");
    same(german.as_bytes());
    same(german.replace(';', "\t").as_bytes());
    same(german.replace(';', " ").as_bytes());
    same(&utf16(&german, false));
    // Headers, comments, empty lines, open ends.
    let scan = same(format!("Profile of a face\nx to the right; y down\n\n# comment\n{comma}\n\n").as_bytes());
    assert!(
        scan.notes[0].starts_with("3 lines before the numbers"),
        "{:?}",
        scan.notes
    );
    let scan = same(comma.replace('\n', ",\n").as_bytes());
    assert!(scan.notes.iter().any(|n| n.contains("opens no column")));
    // Latin-1 in the header.
    same(&[b"# scale \xb5m\n", comma.as_bytes()].concat());
}

#[test]
fn headers_that_state_units_and_steps() {
    let unknown = Options::default();
    let rows = "1 2 3 4\n2 3 4 5\n3 4 5 6\n";
    let gwyddion = format!("# Channel: Topography\n# Width: 0.4 mm\n# Height: 600 \u{b5}m\n# Value units: nm\n{rows}");
    refused(gwyddion.as_bytes(), &unknown, "line 3: found a second unit (um)");
    let gwyddion = gwyddion.replace("600 \u{b5}m", "0.6 mm");
    let scan = parse(gwyddion.as_bytes(), &unknown).unwrap();
    assert_eq!(scan.map.step().map(|d| (d * 1e9).round()), [1e5, 2e5]);
    assert_eq!(scan.height_unit, Declaration::File(LengthUnit::Nanometre));
    assert!((scan.map.height(3, 2).unwrap() - 6e-9).abs() < 1e-22);
    // The same said twice is no contradiction, another is.
    let same = Options {
        height_unit: Some(LengthUnit::Nanometre),
        lateral_step: Some([0.1, 0.2]),
        ..Options::default()
    };
    assert!(parse(gwyddion.as_bytes(), &same).is_ok());
    refused(
        gwyddion.as_bytes(),
        &grid(),
        "`height_unit` is given as um, but the file states nm; leave it out",
    );
    let other = Options {
        lateral_step: Some([0.1, 0.1]),
        ..Options::default()
    };
    refused(gwyddion.as_bytes(), &other, "`lateral_step` is given as [0.1, 0.1]");

    let table = "x [mm]\ty [mm]\tz [\u{b5}m]\n".to_owned() + &cloud();
    let scan = parse(table.as_bytes(), &unknown).unwrap();
    assert_eq!(scan.lateral_unit, Declaration::File(LengthUnit::Millimetre));
    assert_eq!(scan.height_unit, Declaration::File(LengthUnit::Micrometre));
    refused(
        b"# height_unit = furlong\n1 2 3 4\n",
        &unknown,
        "face, line 1: `furlong` is no unit of length; use m, cm, mm",
    );
}

/// 4 x 3 points in scan order, one without height.
fn cloud() -> String {
    let point = |k: usize| {
        let z = if k == 5 { "***".into() } else { k.to_string() };
        format!("{:.1} {:.1} {z}\n", 0.1 * (k % 4) as f64, 0.2 * (k / 4) as f64)
    };
    (0..12).map(point).collect()
}

#[test]
fn points_as_text() {
    let scan = parse(cloud().as_bytes(), &points()).unwrap();
    assert_eq!(
        (scan.format, scan.map.nx(), scan.map.ny(), scan.map.missing()),
        (Format::Xyz, 4, 3, 1)
    );
    assert!((scan.map.height(3, 2).unwrap() - 11e-6).abs() < 1e-18);
    // The order of lines and missing ones do not matter.
    let mut lines: Vec<_> = cloud().lines().map(str::to_owned).collect();
    lines.remove(5);
    lines.reverse();
    let shuffled = parse(lines.join("\n").as_bytes(), &points()).unwrap();
    assert_eq!(format!("{:?}", shuffled.map), format!("{:?}", scan.map));
    // Three columns are a grid on request.
    let as_grid = Options {
        format: Some(Format::Grid),
        ..grid()
    };
    let scan = parse(b"1 2 3\n4 5 6\n7 8 9\n", &as_grid).unwrap();
    assert_eq!((scan.map.nx(), scan.map.ny()), (3, 3));
    let as_points = Options {
        format: Some(Format::Xyz),
        ..points()
    };
    refused(b"1 2 3 4\n", &as_points, "line 1: found 4 columns, expected x, y and z");
    refused(
        cloud().replace("0.1 0.2", "0.13 0.2").as_bytes(),
        &points(),
        "line 6: x = 0.13 lies 0.30 steps of 1.0000e-1 beside the grid; resample",
    );
    refused(
        (cloud() + "0.1 0.2 5\n").as_bytes(),
        &points(),
        "line 13: a second point at x = 0.1, y = 0.2",
    );
    refused(
        cloud().replace("0.1 0.2", "*** 0.2").as_bytes(),
        &points(),
        "line 6: found a point without position",
    );
    // A line across a grid of a million places.
    let diagonal: String = (0..1000).map(|k| format!("{k} {k} 1\n")).collect();
    refused(
        diagonal.as_bytes(),
        &points(),
        "line 1: 1000 points from here on fill less than 1/16 of 1000 x 1000 places",
    );
}

#[test]
fn text_that_is_no_scan() {
    refused(b"", &grid(), "empty; give a scan as X3P, SDF");
    refused(
        b"hello\n",
        &grid(),
        "line 2: found the end of the file, expected a line of numbers",
    );
    refused(
        b"1,2,3,4\n1,2,3\n",
        &grid(),
        "line 2: found 3 columns, expected 4, as in line 1",
    );
    refused(
        b"1,2,3,4\n1,2,3,4\n1,2,x,4\n",
        &grid(),
        "line 3: found `x`, expected a number",
    );
    refused(
        b"1,2,3,4\n1,2,3,4\n1,2,3,4\ntrailing garbage\n",
        &grid(),
        "line 4: found `trailing garbage`",
    );
    refused(
        b"1;2;3;4\n1.5;2,5;3;4\n",
        &grid(),
        "line 2: found numbers with points and others with commas",
    );
    refused(b"1,2,3,4\n1,2,inf,4\n", &grid(), "line 2: found `inf`");
    refused(b"1,2,3,1e999\n", &grid(), "line 1: found `1e999`");
    refused(b"1,2\n3,4\n5,6\n", &grid(), "nx = 2 points: must be at least 3");
    refused(b"\xff\xfe1\x002", &grid(), "byte 4: found an odd byte");
    refused(b"\xff\xfe1\x00\x00\xd8", &grid(), "byte 4: found half a character");
    refused(b"\x01\x02\x00\x03", &grid(), "binary and of no known format");
    let named = readers::parse(
        Source {
            name: "face.x3p",
            bytes: b"1,2,3,4\n",
        },
        &grid(),
    );
    assert!(named.unwrap_err().to_string().contains("not those of `.x3p`"));
    // Lines that look like numbers before the first of them.
    let numbered = b"4 3\n1 2 3 4\n2 3 4 5\n3 4 5 6\n";
    refused(numbered, &grid(), "line 2: found 4 columns, expected 2");
    let told = Options {
        header_lines: Some(1),
        ..grid()
    };
    assert_eq!(parse(numbered, &told).unwrap().map.ny(), 3);
}

#[test]
fn units_and_steps_are_never_guessed() {
    let rows = b"1 2 3 4\n2 3 4 5\n3 4 5 6\n";
    let without = |change: fn(&mut Options)| {
        let mut options = grid();
        change(&mut options);
        options
    };
    refused(
        rows,
        &without(|o| o.height_unit = None),
        "does not state the unit of its heights; pass `height_unit` (m, mm, um",
    );
    refused(
        rows,
        &without(|o| o.lateral_unit = None),
        "the unit of its positions; pass `lateral_unit`",
    );
    refused(rows, &without(|o| o.lateral_step = None), "pass `lateral_step`");
    refused(rows, &without(|o| o.lateral_step = Some([0.1, 0.0])), "dy = 0 m");
    refused(
        rows,
        &without(|o| o.layer = Some(0)),
        "`layer` has no meaning for this grid of text; leave it out",
    );
    refused(rows, &without(|o| o.array = Some("z".into())), "`array` has no meaning");
    refused(
        cloud().as_bytes(),
        &Options {
            first_row: Some(FirstRow::HighestY),
            ..points()
        },
        "`first_row` has no meaning for this text of x, y, z",
    );
    let flipped = parse(
        rows,
        &Options {
            first_row: Some(FirstRow::HighestY),
            ..grid()
        },
    );
    assert!((flipped.unwrap().map.height(0, 0).unwrap() - 3e-6).abs() < 1e-18);
}

#[test]
fn wrong_units_are_implausible() {
    // 25 mm by 10 mm, a few um high.
    let rows: String = (0..51)
        .map(|j| {
            let z = |i: usize| format!("{:.3}", (0.3 * i as f64).sin() + (0.7 * j as f64).cos());
            (0..101).map(z).collect::<Vec<_>>().join(" ") + "\n"
        })
        .collect();
    let with = |lateral, height, step| Options {
        lateral_unit: Some(lateral),
        height_unit: Some(height),
        lateral_step: Some([step; 2]),
        ..Options::default()
    };
    use LengthUnit::{Metre, Micrometre, Millimetre, Nanometre};
    assert!(parse(rows.as_bytes(), &with(Millimetre, Micrometre, 0.25)).is_ok());
    // A polished face, as far as anyone can tell.
    assert!(parse(rows.as_bytes(), &with(Millimetre, Nanometre, 0.25)).is_ok());
    refused(
        rows.as_bytes(),
        &with(Metre, Micrometre, 0.25),
        "the lateral extent is 2.500e1 m, expected 1e-6 to 1e0 m",
    );
    refused(
        rows.as_bytes(),
        &with(Nanometre, Nanometre, 0.0025),
        "lateral extent is 2.500e-10 m",
    );
    refused(
        rows.as_bytes(),
        &with(Micrometre, Millimetre, 1.0),
        "the range of heights over lateral extent is 3.9",
    );
    let comb = "0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50 0 50\n".repeat(60);
    refused(
        comb.as_bytes(),
        &with(Micrometre, Micrometre, 1.0),
        "the mean slope between neighbours is 2.481e1, expected 0e0 to 1e1, since",
    );
    let message = parse(rows.as_bytes(), &with(Metre, Micrometre, 0.25))
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("positions were taken in m (as passed), heights in um (as passed)"),
        "{message}"
    );
    let anyway = Options {
        accept_implausible: true,
        ..with(Metre, Micrometre, 0.25)
    };
    assert!(parse(rows.as_bytes(), &anyway).is_ok());
    // Nothing wrong with a perfect plane.
    assert!(parse(b"1 1 1 1\n1 1 1 1\n1 1 1 1\n", &grid()).is_ok());
}

/// A map of 5 x 4 points.
fn map() -> HeightMap {
    let heights: Vec<f64> = (0..20).map(|k| 1e-6 * f64::from(k)).collect();
    HeightMap::try_new(5, 4, [1e-3, 2e-3], [0.0, 0.0], heights).unwrap()
}

/// The X3P archive of [`map`] with its document and data altered, checksums of both restored.
fn x3p(edit: impl Fn(String) -> String, data: impl Fn(Vec<u8>) -> Vec<u8>) -> Vec<u8> {
    let bytes = writers::x3p(&map()).unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut member = |name: &str| {
        let mut bytes = Vec::new();
        archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
        bytes
    };
    let points = data(member("bindata/data.bin"));
    let main = String::from_utf8(member("main.xml")).unwrap();
    let stated = main
        .split("PointData>")
        .nth(1)
        .unwrap()
        .split('<')
        .next()
        .unwrap()
        .to_owned();
    let main = edit(main.replace(&stated, &md5(&points)));
    pack(&[
        ("main.xml", main.as_bytes()),
        ("bindata/data.bin", &points),
        ("bindata/valid.bin", &[0xff, 0xfe, 0x0f]),
        ("md5checksum.hex", md5(main.as_bytes()).as_bytes()),
    ])
}

fn md5(bytes: &[u8]) -> String {
    use md5::{Digest, Md5};
    Md5::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

fn pack(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in members {
        archive
            .start_file(*name, zip::write::SimpleFileOptions::default())
            .unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn edited(from: &str, to: &str) -> Vec<u8> {
    x3p(
        |main| {
            assert!(main.contains(from), "{main}");
            main.replacen(from, to, 1)
        },
        |data| data,
    )
}

#[test]
fn documents_of_x3p() {
    let read = |bytes: &[u8]| parse(bytes, &Options::default()).unwrap_or_else(|e| panic!("{e}")).map;
    assert_eq!(read(&edited("1", "1")), map());
    // Entities, CDATA, comments, other prefixes, other records, a byte order mark, UTF-16 aside: the same document.
    assert_eq!(read(&edited("<SizeX>5<", "<SizeX><!-- five --> &#53; <")), map());
    assert_eq!(read(&edited("<SizeX>5<", "<SizeX><![CDATA[5]]><")), map());
    assert_eq!(
        read(&edited("<SizeX>5</SizeX>", "<q:SizeX xmlns:q=\"urn:q\">5</q:SizeX>")),
        map()
    );
    assert_eq!(
        read(&edited(
            "<Record3>",
            "<Record2><Comment>&#181;&own;</Comment></Record2><Record3>"
        )),
        map()
    );
    assert_eq!(read(&x3p(|main| format!("\u{feff}{main}"), |data| data)), map());
    assert_eq!(read(&edited("bindata/data.bin", "bindata\\data.bin")), map());
    // A folder around everything.
    let bytes = writers::x3p(&map()).unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let members: Vec<(String, Vec<u8>)> = (0..archive.len())
        .map(|i| {
            let mut file = archive.by_index(i).unwrap();
            let name = format!("scan/{}", file.name().unwrap());
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes).unwrap();
            (name, bytes)
        })
        .collect();
    let members: Vec<_> = members
        .iter()
        .map(|(name, bytes)| (name.as_str(), &bytes[..]))
        .collect();
    assert_eq!(read(&pack(&members)), map());

    // A mask: bits 0 to 7 of the first byte, then 9 to 15, then 16 to 19 are points.
    let masked = read(&edited(
        "</MD5ChecksumPointData>",
        "</MD5ChecksumPointData><ValidPointsLink>bindata/valid.bin</ValidPointsLink>",
    ));
    assert_eq!((masked.missing(), masked.height(3, 1)), (1, None));
    // An axis that runs backwards turns points and positions.
    let turned = read(&edited("1e-3", "-1e-3"));
    assert_eq!((turned.step(), turned.height(0, 0)), ([1e-3, 2e-3], map().height(4, 0)));
    assert!((turned.position(0, 0)[0] + 4e-3).abs() < 1e-18);
    let turned = read(&edited("2e-3", "-2e-3"));
    assert_eq!(
        (turned.height(1, 0), turned.height(0, 3)),
        (map().height(1, 3), map().height(0, 0))
    );
    // Integers with increment and offset.
    let integers = x3p(
        |main| {
            let (head, z) = main.split_once("<CZ>").unwrap();
            let z = z
                .replacen(">D<", ">I<", 1)
                .replacen(">1<", ">-2e-6<", 1)
                .replacen(">0<", ">1e-3<", 1);
            format!("{head}<CZ>{z}")
        },
        |_| (0..20i16).flat_map(i16::to_le_bytes).collect(),
    );
    let scan = parse(&integers, &Options::default()).unwrap();
    assert_eq!(scan.stated_step, Some(2e-6));
    assert!((scan.map.height(3, 0).unwrap() - (1e-3 - 6e-6)).abs() < 1e-18);
    // Absolute positions of each point, in single precision.
    let absolute = x3p(
        |main| {
            main.replacen(
                "<AxisType>I</AxisType>\n        <DataType>D<",
                "<AxisType>A</AxisType>\n        <DataType>F<",
                1,
            )
            .replacen("<Increment>1e-3<", "<Increment>1<", 1)
        },
        |data| {
            let points = data.as_chunks::<8>().0.iter().enumerate();
            points
                .flat_map(|(k, z)| [&((k % 5) as f32 * 1e-3).to_le_bytes()[..], z].concat())
                .collect()
        },
    );
    let found = read(&absolute);
    assert!((found.step()[0] - 1e-3).abs() < 1e-10 && found.step()[1] == 2e-3);
    assert_eq!(found.height(3, 2), map().height(3, 2));
    // Layers.
    let layered = x3p(
        |main| main.replace("<SizeZ>1<", "<SizeZ>2<"),
        |data| [data.clone(), data.iter().map(|_| 0).collect()].concat(),
    );
    refused(
        &layered,
        &Options::default(),
        "the file holds 2 layers, numbered from 0; pass `layer`",
    );
    let layer = |layer| Options {
        layer: Some(layer),
        ..Options::default()
    };
    assert_eq!(parse(&layered, &layer(0)).unwrap().map, map());
    assert_eq!(parse(&layered, &layer(1)).unwrap().map.height(4, 3), Some(0.0));
    refused(&layered, &layer(2), "2 layers");
}

#[test]
fn broken_x3p() {
    let plain = Options::default();
    for (from, to, expected) in [
        ("<SizeX>5<", "<SizeX>&own;<", "of `main.xml`: found the entity `own`"),
        (
            "<SizeX>5<",
            "<SizeX>1000000000<",
            "the number of points is stated as 4000000000, but this file can hold no more than 20",
        ),
        ("<SizeX>5<", "<SizeX>18446744073709551615<", "is stated as"),
        (
            "<SizeX>5<",
            "<SizeX>99999999999999999999<",
            "expected a whole number as `Record3/MatrixDimension/SizeX`",
        ),
        ("<SizeX>5<", "<SizeX>-5<", "expected a whole number"),
        (
            "<SizeX>5<",
            "<SizeX>4<",
            "byte 128 of `bindata/data.bin`: found data of 20 points or more, expected 16 points",
        ),
        ("<SizeZ>1<", "<SizeZ>0<", "expected 0 points"),
        (
            "<SizeX>5</SizeX>",
            "",
            "expected the element `Record3/MatrixDimension/SizeX`",
        ),
        (
            "<SizeX>5<",
            "<SizeX>5</SizeX><SizeX>5<",
            "a second element `Record3/MatrixDimension/SizeX`",
        ),
        ("<DataType>D<", "<DataType>Q<", "expected I, L, F or D"),
        (">A<", ">I<", "found an incremental axis z"),
        (">A<", ">B<", "expected I or A"),
        ("1e-3", "0", "expected a number that is not zero"),
        ("1e-3", "", "expected the length of a step"),
        ("1e-3", "nan", "expected a number as `Record1/Axes/CX/Increment`"),
        ("SUR", "PRF", "a feature of type `PRF`"),
        ("p:ISO5436_2 xmlns", "p:html xmlns", "expected the element `ISO5436_2`"),
        ("</Axes>", "", "expected well-formed XML"),
        ("bindata/data.bin", "data.bin", "found no member `data.bin`"),
        ("<DataLink>", "<DataLunk>", "expected well-formed XML"),
    ] {
        let bytes = if from == "<DataType>D<" {
            // That of heights; those of axes that are counted do not matter.
            let edit = |main: String| {
                let (head, z) = main.split_once("<CZ>").unwrap();
                format!("{head}<CZ>{}", z.replacen(from, to, 1))
            };
            x3p(edit, |data| data)
        } else {
            edited(from, to)
        };
        refused(&bytes, &plain, expected);
    }
    // Data or document changed without their checksums.
    let mut bytes = writers::x3p(&map()).unwrap();
    let data = map().height(1, 0).unwrap().to_le_bytes();
    let at = bytes.windows(8).position(|w| w == data).unwrap();
    bytes[at] ^= 1;
    refused(&bytes, &plain, "checksum");
    let text = String::from_utf8(vec![b'0'; 32]).unwrap();
    let other = x3p(
        |main| {
            let stated = main
                .split("PointData>")
                .nth(1)
                .unwrap()
                .split('<')
                .next()
                .unwrap()
                .to_owned();
            main.replace(&stated, &text)
        },
        |data| data,
    );
    refused(&other, &plain, "`bindata/data.bin` has the MD5 checksum");
    let members = [
        ("main.xml", &b"<p:ISO5436_2/>"[..]),
        ("md5checksum.hex", text.as_bytes()),
    ];
    refused(&pack(&members), &plain, "`main.xml` has the MD5 checksum");
    let found = parse(&edited("MD5ChecksumPointData", "MD5ChecksumPointDate"), &plain);
    assert!(found.is_err(), "the closing tag differs");
    let unchecked = x3p(
        |main| main.replace("ChecksumPointData", "ChecksumOfNothing"),
        |data| data,
    );
    assert_eq!(
        parse(&unchecked, &plain).unwrap().notes[0],
        "no checksum of `bindata/data.bin` to verify"
    );
    refused(
        &pack(&[("readme.txt", b"")]),
        &plain,
        "neither `main.xml` nor NumPy arrays",
    );
    let half = &writers::x3p(&map()).unwrap()[..600];
    refused(half, &plain, "expected a ZIP archive");
    refused(
        &writers::x3p(&map()).unwrap(),
        &grid(),
        "`lateral_unit` is given as mm, but the file states m; leave it out",
    );
}

/// A binary SDF file of 4 x 3 points.
fn sdf(revision: &str, data_type: u8, size: [u32; 2], heights: &[u8]) -> Vec<u8> {
    let mut bytes = format!("b{revision}maker     201120260300201120260300").into_bytes();
    for n in size {
        if revision == "ISO-2.0" {
            bytes.extend(n.to_le_bytes());
        } else {
            bytes.extend((n as u16).to_le_bytes());
        }
    }
    for scale in [1e-4, 2e-4, 1e-6, -1.0_f64] {
        bytes.extend(scale.to_le_bytes());
    }
    bytes.extend([0, data_type, 0]);
    bytes.extend(heights);
    bytes
}

#[test]
fn missing_points_of_sdf() {
    let floats = |revision, marker: f64| {
        let heights = (0..12).map(|k| if k == 5 { marker } else { f64::from(k) });
        let heights: Vec<u8> = heights.flat_map(f64::to_le_bytes).collect();
        parse(&sdf(revision, 7, [4, 3], &heights), &Options::default())
            .unwrap()
            .map
    };
    for revision in ["ISO-1.0", "ISO-2.0", "BCR-1.0"] {
        for marker in [1.797e308, f64::MAX, f64::MIN, f64::NAN, f64::INFINITY] {
            assert_eq!(floats(revision, marker).missing(), 1, "{revision} {marker}");
        }
    }
    let integers = |revision, marker: i16| {
        let heights = (0..12).map(|k| if k == 5 { marker } else { k });
        let heights: Vec<u8> = heights.flat_map(i16::to_le_bytes).collect();
        // Kept, they are 33 mm high.
        let options = Options {
            accept_implausible: true,
            ..Options::default()
        };
        parse(&sdf(revision, 5, [4, 3], &heights), &options).unwrap()
    };
    assert_eq!(integers("ISO-1.0", i16::MIN).map.missing(), 1);
    assert_eq!(integers("BCR-1.0", i16::MAX).map.missing(), 1);
    for (revision, other) in [("ISO-1.0", i16::MAX), ("BCR-1.0", i16::MIN)] {
        let scan = integers(revision, other);
        assert_eq!(scan.map.missing(), 0);
        assert!(
            scan.notes[0].contains("1 heights at the end of the number range"),
            "{:?}",
            scan.notes
        );
    }
}

#[test]
fn broken_sdf() {
    let plain = Options::default();
    let heights: Vec<u8> = (0..12i16).flat_map(i16::to_le_bytes).collect();
    let sound = sdf("ISO-1.0", 5, [4, 3], &heights);
    assert_eq!(parse(&sound, &plain).unwrap().map.height(3, 2), Some(11.0 * 1e-6));
    refused(
        &sound[..60],
        &plain,
        "face, byte 60: found the end of the file, expected the rest of the header",
    );
    refused(
        &sound[..100],
        &plain,
        "face, byte 42: the number of points is stated as 12, but this file can hold no more than 9",
    );
    refused(
        &sdf("ISO-2.0", 5, [1_000_000_000; 2], &heights),
        &plain,
        "byte 42: the number of points is stated as 1000000000000000000",
    );
    refused(&[&sound[..], b"\xde\xad\xbe\xef"].concat(), &plain, "byte 105: found");
    assert!(parse(&[&sound[..], b"\r\n\0\0"].concat(), &plain).unwrap().notes[0].contains("4 bytes of filling"));
    let with = |at: usize, byte: u8| {
        let mut bytes = sound.clone();
        bytes[at] = byte;
        bytes
    };
    refused(
        &with(5, b'7'),
        &plain,
        "the revision `ISO-7.0` is not supported; save the scan as ISO-1.0",
    );
    refused(
        &with(78, 1),
        &plain,
        "byte 78: compression 1 is not supported; save the scan without compression",
    );
    refused(&with(79, 9), &plain, "byte 79: found the data type 9, expected 0 to 7");
    refused(&with(80, 1), &plain, "byte 80: check type 1 is not supported");
    refused(&with(53, 0xff), &plain, "byte 46: found Xscale = -");

    let text = "aISO-1.0\r\nManufacID = maker\r\nCreateDate = 201120260300\r\nModDate = 201120260300\r\nNumPoints = 4\r\n\
                NumProfiles = 3\r\nXscale = 1e-4\r\nYscale = 2e-4\r\nZscale = 1e-6\r\nZresolution = 2e-6\r\n\
                Compression = 0\r\nDataType = 5\r\nCheckType = 0\r\n*\r\n1 2 3 4\r\n5 BAD 7 8\r\n9 10 11 12\r\n*\r\n";
    let scan = parse(text.as_bytes(), &plain).unwrap();
    assert_eq!((scan.map.missing(), scan.stated_step), (1, Some(2e-6)));
    for (from, to, expected) in [
        (
            "9 10 11 12",
            "9 10 11",
            "line 18: found the end of the heights after 11, expected 12 heights",
        ),
        (
            "9 10 11 12",
            "9 10 11 12 13",
            "line 17: found height 13, expected `*` after 12 heights",
        ),
        (
            "9 10 11 12",
            "9 10 11 1.5",
            "line 17: found `1.5`, expected a number of the data type",
        ),
        ("9 10 11 12", "9 10 11 99999", "line 17: found `99999`"),
        (
            "NumPoints = 4",
            "NumPoints = 1000000000",
            "line 5: the number of points is stated as 3000000000",
        ),
        ("NumPoints = 4", "NumPoints = four", "line 5: found `four`"),
        ("NumPoints = 4\r\n", "", "line 1: found a header without `NumPoints`"),
        (
            "NumPoints = 4",
            "NumPoints = 4\r\nnumpoints = 4",
            "line 6: found a second `NumPoints`",
        ),
        (
            "Zscale = 1e-6",
            "Zscale = 0",
            "found Zscale = 0, expected a positive number of metres",
        ),
        (
            "Compression = 0",
            "Compression = 1",
            "line 11: compression 1 is not supported",
        ),
        ("DataType = 5", "DataType = INTEGER", "line 12: found `INTEGER`"),
        (
            "CheckType = 0\r\n*",
            "CheckType = 0\r\n",
            "line 15: found `1 2 3 4`, expected `name = value`",
        ),
    ] {
        assert!(text.contains(from));
        refused(text.replacen(from, to, 1).as_bytes(), &plain, expected);
    }
    refused(
        text.split('*').next().unwrap().as_bytes(),
        &plain,
        "expected `*` after the header",
    );
    // BCR knows names and comments.
    let bcr = text
        .replace("aISO", "aBCR")
        .replace("DataType = 5", "DataType = INTEGER ; 16 bits")
        .replace("BAD", "32767");
    assert_eq!(parse(bcr.as_bytes(), &plain).unwrap().map.missing(), 1);
    let cut = text.trim_end().trim_end_matches('*');
    assert!(parse(cut.as_bytes(), &plain).unwrap().notes[0].contains("end without `*`"));
}

#[test]
fn broken_sur() {
    let plain = Options::default();
    let file = |name: &str| std::fs::read(format!("{}/tests/scans/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let (sound, compressed) = (file("surfalize.sur"), file("surfalize_compressed.sur"));
    let with = |at: usize, bytes: &[u8]| {
        let mut file = sound.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    refused(
        &sound[..500],
        &plain,
        "byte 500: found the end of the file, expected the rest of the header",
    );
    refused(
        &sound[..2000],
        &plain,
        "byte 108: the number of points is stated as 480, but this file can hold no more than 372",
    );
    refused(
        &with(
            108,
            &[1_000_000_000_i32.to_le_bytes(), 1_000_000_000_i32.to_le_bytes()].concat(),
        ),
        &plain,
        "stated as 1000000000000000000",
    );
    refused(
        &with(108, &(-24_i32).to_le_bytes()),
        &plain,
        "byte 108: found -24 x 20 points",
    );
    refused(
        &with(116, &[1, 0, 0, 0]),
        &plain,
        "byte 116: found 1 points, expected 24 x 20",
    );
    refused(&with(12, &[1]), &plain, "byte 12: the byte order 1 is not supported");
    refused(&with(14, &[2]), &plain, "byte 14: a file of 2 objects is not supported");
    refused(&with(16, &[9]), &plain, "byte 16: the version 9 is not supported");
    refused(
        &with(18, &[5]),
        &plain,
        "byte 18: an object of type 5 is not supported; save the surface alone",
    );
    refused(&with(290, &[1]), &plain, "byte 290: the inversion 1 is not supported");
    refused(&with(94, &[3]), &plain, "byte 94: 3 numbers per point");
    refused(
        &with(98, &[8]),
        &plain,
        "byte 98: found points of 8 bits, expected 16 or 32",
    );
    refused(&with(180, b"ells"), &plain, "byte 180: `ells");
    refused(
        &with(120, &0_f32.to_le_bytes()),
        &plain,
        "byte 120: found a spacing of 0 m",
    );
    refused(
        &with(474, &f32::NAN.to_le_bytes()),
        &plain,
        "byte 474: found an offset of NaN",
    );
    refused(&with(334, &[0xff, 0xff]), &plain, "expected the rest of the comment");
    refused(
        &[&sound[..], b"garbage"].concat(),
        &plain,
        "byte 2432: found `garbage` and 7 bytes more",
    );
    let mm = Options {
        height_unit: Some(LengthUnit::Millimetre),
        ..Options::default()
    };
    refused(&sound, &mm, "`height_unit` is given as mm, but the file states um");
    // A surface that Gwyddion calls a profile, and one that images follow.
    assert!(parse(&with(18, &[1]), &plain).unwrap().notes[0].contains("read as a surface"));
    assert!(parse(&[&with(18, &[16])[..], &sound].concat(), &plain).unwrap().notes[0].contains("images"));

    let with = |at: usize, bytes: &[u8]| {
        let mut file = compressed.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    refused(
        &compressed[..900],
        &plain,
        "byte 900: found the end of the file, expected the rest of stream 0",
    );
    refused(&with(512, &[0xff; 4]), &plain, "byte 512: found 4294967295 streams");
    refused(
        &with(512, &[0; 4]),
        &plain,
        "found 0 bytes in all streams, expected 1920",
    );
    refused(
        &with(516, &[0xff; 4]),
        &plain,
        "byte 516: found 4294967295 bytes more, expected 1920 in all",
    );
    refused(
        &with(516, &1000_u32.to_le_bytes()),
        &plain,
        "byte 524: found 1001 bytes unpacked",
    );
    refused(&with(560, &[0; 40]), &plain, "byte 524: found");
    refused(
        &with(108, &[100_000_i32.to_le_bytes(), 100_000_i32.to_le_bytes()].concat()),
        &plain,
        "stated as 10000000000",
    );
}

#[test]
fn broken_numpy() {
    let file = |name: &str| std::fs::read(format!("{}/tests/scans/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let (array, archive) = (file("f8.npy"), file("maps.npz"));
    refused(
        &array,
        &Options::default(),
        "the unit of its positions; pass `lateral_unit`",
    );
    refused(
        &array,
        &points(),
        "NumPy array without positions of its points; pass `lateral_step`",
    );
    refused(
        &array[..3000],
        &grid(),
        "byte 128: the number of bytes of the entries is stated as 3840",
    );
    refused(
        &[&array[..], b"\0"].concat(),
        &grid(),
        "byte 128: found 3841 bytes of entries, expected 3840",
    );
    refused(&archive[..700], &grid(), "expected a ZIP archive");
    let header = |shape: &str, kind: &str| {
        let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n");
        [
            b"\x93NUMPY\x01\0",
            &(header.len() as u16).to_le_bytes()[..],
            header.as_bytes(),
        ]
        .concat()
    };
    refused(
        &header("(1000000000, 1000000000)", "<f8"),
        &grid(),
        "stated as 8000000000000000000",
    );
    refused(&header("(99999999999999999, 0)", "<f8"), &grid(), "nx = 0 points");
    refused(
        &header("(2, 2, 2)", "<f8"),
        &grid(),
        "an array of 3 dimensions is not supported",
    );
    refused(
        &header("(4, 4)", "<c16"),
        &grid(),
        "entries of the type `<c16` is not supported",
    );
    refused(
        &[header("(4, 3)", "<i1"), vec![1; 12]].concat(),
        &grid(),
        "a matrix of three columns",
    );
    refused(
        &[header("(4, 4)", "<i8"), vec![0x7f; 128]].concat(),
        &grid(),
        "an integer beyond 2^53",
    );
    let infinite: Vec<u8> = (0..16).flat_map(|_| f64::INFINITY.to_le_bytes()).collect();
    refused(
        &[header("(4, 4)", "<f8"), infinite].concat(),
        &grid(),
        "height of point (0, 0) is inf m",
    );
    let text = header("()", "<U1");
    refused(
        &[&text[..], b"a\0\0\0"].concat(),
        &grid(),
        "an array that is no matrix of numbers",
    );
}

#[test]
fn files_that_cannot_be_opened() {
    let e = readers::read("no/such/face.x3p".as_ref(), &Options::default()).unwrap_err();
    assert!(e.to_string().starts_with("no/such/face.x3p: "), "{e}");
}
