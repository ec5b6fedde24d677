//! Damaged files: whatever the bytes, every reader answers, and memory stays within a multiple of the file's size.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::{Cursor, Write};

use surface_characterisation::readers::{self, LengthUnit, Options, Source};
use surface_characterisation::{HeightMap, writers};
use test_support::memory::Counting;
use test_support::{Damage, Sample, Tally};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn file(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/scans/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// An X3P archive with this document and this data, without checksums, so that damage to either is not caught by them.
fn x3p_around(main: &[u8], data: &[u8]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in [("main.xml", main), ("data.bin", data), ("valid.bin", &[0x7f; 8])] {
        let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        archive.start_file(name, stored).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// Heights of 8 x 8 points, below 1 um.
fn heights() -> impl Iterator<Item = i32> {
    (0..64).map(|k| k * 37 % 101)
}

/// A document for 8 x 8 heights as 32-bit integers in a member, or listed with absolute positions.
fn document(listed: bool) -> Vec<u8> {
    let axis = |name, kind, step| {
        format!(
            "<{name}><AxisType>{kind}</AxisType><DataType>L</DataType><Increment>{step}</Increment>\
             <Offset>0</Offset></{name}>"
        )
    };
    let kind = if listed { 'A' } else { 'I' };
    let axes = axis("CX", kind, "1e-5") + &axis("CY", kind, "-2e-5") + &axis("CZ", 'A', "1e-8");
    let data = if listed {
        let datum = |(k, z): (usize, i32)| format!("<Datum>{};{};{z}</Datum>", k % 8, k / 8);
        let datums: String = heights().enumerate().map(datum).collect();
        format!("<DataList>{datums}</DataList>").replacen("<Datum>3;0;10</Datum>", "<Datum/>", 1)
    } else {
        "<DataLink><PointDataLink>data.bin</PointDataLink><ValidPointsLink>valid.bin</ValidPointsLink></DataLink>"
            .into()
    };
    format!(
        "<?xml version=\"1.0\"?><p:ISO5436_2 xmlns:p=\"urn:p\"><Record1><FeatureType>SUR</FeatureType>\
         <Axes>{axes}<Rotation><r11>1</r11></Rotation></Axes></Record1><Record3><MatrixDimension><SizeX>8</SizeX>\
         <SizeY>8</SizeY><SizeZ>1</SizeZ></MatrixDimension>{data}</Record3></p:ISO5436_2>"
    )
    .into_bytes()
}

fn text_options() -> Options {
    Options {
        lateral_unit: Some(LengthUnit::Micrometre),
        height_unit: Some(LengthUnit::Micrometre),
        accept_implausible: true,
        ..Options::default()
    }
}

fn grid_options() -> Options {
    Options {
        lateral_step: Some([1.0, 1.0]),
        ..text_options()
    }
}

fn lenient() -> Options {
    Options {
        accept_implausible: true,
        ..Options::default()
    }
}

/// How what is damaged becomes a file.
type Packed = fn(&[u8]) -> Vec<u8>;
/// What is damaged, bytes of memory per byte of the file and on top, how it is read and packed.
type Case = (&'static str, Vec<u8>, usize, usize, Options, Packed);

#[test]
fn damaged_files_are_answered_within_bounds() {
    let map = HeightMap::try_new(
        8,
        8,
        [1e-5, 2e-5],
        [0.0, 0.0],
        heights().map(|z| f64::from(z) * 1e-8).collect::<Vec<_>>(),
    )
    .unwrap();
    let numbers: Vec<u8> = heights().flat_map(i32::to_le_bytes).collect();
    let points: String = heights()
        .enumerate()
        .map(|(k, z)| format!("{};{};{z}\n", k % 8, k / 8))
        .collect();
    let rows: String = heights()
        .enumerate()
        .map(|(k, z)| format!("{z},5{}", if k % 8 == 7 { '\n' } else { ';' }))
        .collect();
    let utf16 = |text: &str| -> Vec<u8> {
        let units = std::iter::once(0xfeff).chain(text.encode_utf16());
        units.flat_map(u16::to_le_bytes).collect()
    };
    // What a byte of the file may become: compressed files hold up to 1032 bytes in one; a point of text takes six bytes
    // and may have sixteen places of a grid.
    const PLAIN: usize = 64;
    const COMPRESSED: usize = 64 * 1032;
    // What may come on top: messages and vectors at their smallest; buffers for unpacking.
    const LITTLE: usize = 1 << 13;
    const UNPACKING: usize = 1 << 18;
    let whole: Packed = <[u8]>::to_vec;
    let files: [Case; 22] = [
        (
            "written.x3p",
            writers::x3p(&map).unwrap(),
            COMPRESSED,
            UNPACKING,
            lenient(),
            whole,
        ),
        (
            "surface_binary.x3p",
            file("surface_binary.x3p"),
            COMPRESSED,
            UNPACKING,
            lenient(),
            whole,
        ),
        ("main.xml", document(false), PLAIN, UNPACKING, lenient(), |main| {
            let numbers: Vec<u8> = heights().flat_map(i32::to_le_bytes).collect();
            x3p_around(main, &numbers)
        }),
        (
            "main.xml, listed",
            document(true),
            PLAIN,
            UNPACKING,
            lenient(),
            |main| x3p_around(main, &[]),
        ),
        ("data.bin", numbers, PLAIN, UNPACKING, lenient(), |data| {
            x3p_around(&document(false), data)
        }),
        (
            "iso1 binary",
            file("iso1_surface_int32_binary.sdf"),
            PLAIN,
            LITTLE,
            lenient(),
            whole,
        ),
        (
            "iso2 binary",
            file("iso2_surface_binary64_binary.sdf"),
            PLAIN,
            LITTLE,
            lenient(),
            whole,
        ),
        (
            "bcr binary",
            file("bcr1_surface_uint16_binary.sdf"),
            PLAIN,
            LITTLE,
            lenient(),
            whole,
        ),
        (
            "iso2 binary, header",
            file("iso2_surface_binary64_binary.sdf")[..149].to_vec(),
            PLAIN,
            LITTLE,
            lenient(),
            |head| [head, &file("iso2_surface_binary64_binary.sdf")[149..]].concat(),
        ),
        (
            "iso1 text",
            file("iso1_surface_ascii.sdf"),
            PLAIN,
            LITTLE,
            lenient(),
            whole,
        ),
        (
            "bcr text",
            file("bcr1_surface_ascii.sdf"),
            PLAIN,
            LITTLE,
            lenient(),
            whole,
        ),
        (
            "iso2 text, header",
            file("iso2_surface_int8_ascii.sdf")[..300].to_vec(),
            PLAIN,
            LITTLE,
            lenient(),
            |head| [head, &file("iso2_surface_int8_ascii.sdf")[300..]].concat(),
        ),
        ("plain.sur", file("surfalize.sur"), PLAIN, LITTLE, lenient(), whole),
        (
            "header of sur",
            file("surfalize.sur")[..512].to_vec(),
            PLAIN,
            LITTLE,
            lenient(),
            |head| [head, &file("surfalize.sur")[512..]].concat(),
        ),
        (
            "compressed.sur",
            file("surfalize_compressed.sur"),
            COMPRESSED,
            UNPACKING,
            lenient(),
            whole,
        ),
        (
            "streams of sur",
            file("surfalize_compressed.sur")[512..].to_vec(),
            COMPRESSED,
            UNPACKING,
            lenient(),
            |rest| [&file("surfalize_compressed.sur")[..512], rest].concat(),
        ),
        (
            "points",
            points.clone().into_bytes(),
            PLAIN,
            LITTLE,
            text_options(),
            whole,
        ),
        ("rows", rows.clone().into_bytes(), PLAIN, LITTLE, grid_options(), whole),
        ("rows in UTF-16", utf16(&rows), PLAIN, LITTLE, grid_options(), whole),
        (
            "written.csv",
            writers::csv(&map).into_bytes(),
            PLAIN,
            LITTLE,
            lenient(),
            whole,
        ),
        ("f8.npy", file("f8.npy"), PLAIN, LITTLE, grid_options(), whole),
        (
            "maps.npz",
            file("maps.npz"),
            COMPRESSED,
            UNPACKING,
            Options {
                array: Some("height".into()),
                ..grid_options()
            },
            whole,
        ),
    ];
    let mut damage = Damage::new(71, &[b"*\r\n", b";", b",", b"<SizeX>", b"<![CDATA[", b"&#0;&a;"]);
    for (name, sound, factor, base, options, packed) in files {
        let sample = Sample {
            name,
            sound: &sound,
            memory: [factor, base],
            copies: 2000,
        };
        let read = |bytes: &[u8]| readers::parse(Source { name: "", bytes }, &options);
        let Tally { refused, accepted } = damage.trial(&sample, packed, read, |scan, bytes| {
            let points = scan.map.nx() * scan.map.ny();
            assert!(points <= factor * bytes.len(), "{name}: {points} points");
            assert!(scan.map.missing() <= points);
        });
        // The damage is neither always fatal nor never.
        assert!(
            refused > 200 && accepted > 0,
            "{name}: {refused} refused, {accepted} read"
        );
    }
}
