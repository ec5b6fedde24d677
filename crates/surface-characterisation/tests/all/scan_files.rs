//! Scans written by other programs, and by this crate.

use std::f64::consts::TAU;
use std::path::Path;

use surface_characterisation::readers::{self, Declaration, FirstRow, Format, LengthUnit, Options, Scan, Source};
use surface_characterisation::{HeightMap, writers};

fn micrometres() -> Options {
    Options {
        lateral_unit: Some(LengthUnit::Micrometre),
        height_unit: Some(LengthUnit::Micrometre),
        ..Options::default()
    }
}

fn scan(name: &str, options: &Options) -> Scan {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scans").join(name);
    readers::read(&path, options).unwrap_or_else(|e| panic!("{e}"))
}

/// Largest difference (m) between a map and a function of x and y (m), with the points where it says NaN missing.
fn error(map: &HeightMap, expected: impl Fn(f64, f64) -> f64) -> f64 {
    let mut worst = 0.0_f64;
    for j in 0..map.ny() {
        for i in 0..map.nx() {
            let [x, y] = map.position(i, j);
            let z = expected(x, y);
            match map.height(i, j) {
                Some(found) => {
                    assert!(!z.is_nan(), "({i}, {j}) should be missing");
                    worst = worst.max((found - z).abs());
                }
                None => assert!(z.is_nan(), "({i}, {j}) is missing"),
            }
        }
    }
    worst
}

/// The surface of the SDF, SUR and NumPy files.
fn bumps(x: f64, y: f64) -> f64 {
    1e-6 * ((TAU * x / 40e-6).cos() * (TAU * y / 36e-6).cos() + 0.3 * (TAU * x / 14e-6).sin())
}

/// The surface of the X3P files.
fn waves(x: f64, y: f64) -> f64 {
    1e-6 * ((TAU * x / 24e-6).cos() * (TAU * y / 16e-6).cos() + 0.3 * (TAU * x / 9e-6).sin())
}

/// `z`, missing in these columns and rows of a grid.
fn without(z: f64, at: [f64; 2], step: [f64; 2], columns: [f64; 2], rows: [f64; 2]) -> f64 {
    let [i, j] = [0, 1].map(|q| (at[q] / step[q]).round());
    let inside = i >= columns[0] && i < columns[1] && j >= rows[0] && j < rows[1];
    if inside { f64::NAN } else { z }
}

#[test]
fn one_patch_in_five_formats_is_one_map() {
    let Some(folder) = test_support::reference_file("surface_formats") else {
        return;
    };
    let read = |name: &str, options: &Options| readers::read(&folder.join(name), options).unwrap();
    let grid = Options {
        lateral_step: Some([30.0, 50.0]),
        ..micrometres()
    };
    let points = read("patch_xyz_um.txt", &micrometres());
    let others = [
        ("matrix", read("patch_matrix_um.csv", &grid), Format::Grid, 0.0),
        ("X3P", read("patch.x3p", &Options::default()), Format::X3p, 0.0),
        // One rounding: micrometres divided by 10^6 here, multiplied by 10^-6 there.
        ("SDF", read("patch.sdf", &Options::default()), Format::Sdf, 2e-21),
        // Spacing and offset of heights are stored in single precision: 2^-24 of the range, and of the offset.
        ("SUR", read("patch.sur", &Options::default()), Format::Sur, 2e-12),
    ];
    let map = &points.map;
    assert_eq!(
        (points.format, map.nx(), map.ny(), map.missing()),
        (Format::Xyz, 83, 51, 4)
    );
    assert_eq!(map.step(), [30e-6, 50e-6]);
    assert_eq!(points.distinct_heights, 38);
    for (name, other, format, bound) in &others {
        assert_eq!(other.format, *format);
        for q in 0..2 {
            assert!((other.map.step()[q] / map.step()[q] - 1.0).abs() < 1e-15, "{name}");
        }
        assert_eq!(
            (other.map.nx(), other.map.ny(), other.map.missing()),
            (83, 51, 4),
            "{name}"
        );
        let mut worst = 0.0_f64;
        for k in 0..83 * 51 {
            let (a, b) = (map.height(k % 83, k / 83), other.map.height(k % 83, k / 83));
            assert_eq!(a.is_some(), b.is_some(), "{name}");
            worst = worst.max((a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs());
        }
        println!("{name} against x y z: at most {worst:.1e} m");
        assert!(worst <= *bound, "{name}: {worst}");
        // The instrument's half micrometre.
        assert!((other.smallest_step.unwrap() - 0.5e-6).abs() < 1e-13, "{name}");
    }
}

#[test]
fn sdf_of_others() {
    let expected = |x, y| without(bumps(x, y), [x, y], [2e-6, 3e-6], [20.0, 30.0], [10.0, 14.0]);
    for (name, bound, stated) in [
        ("iso1_surface_ascii.sdf", 0.5e-10, Some(1e-10)),
        ("iso1_surface_int32_binary.sdf", 0.5e-13, Some(1e-13)),
        ("iso2_surface_int8_ascii.sdf", 1e-8, Some(2e-8)),
        ("iso2_surface_binary64_binary.sdf", 0.0, None),
    ] {
        let scan = scan(name, &Options::default());
        assert_eq!((scan.map.nx(), scan.map.ny(), scan.map.missing()), (48, 32, 40));
        assert_eq!(scan.stated_step, stated);
        assert_eq!(scan.lateral_unit, Declaration::File(LengthUnit::Metre));
        let worst = error(&scan.map, expected);
        // Rounding to the nearest, and that of arithmetic.
        assert!(worst <= bound * (1.0 + 1e-5) + 1e-21, "{name}: {worst}");
    }
    let trailer = scan("iso1_surface_ascii.sdf", &Options::default()).notes;
    assert!(trailer[0].contains("a trailer of 2 lines"), "{trailer:?}");
}

#[test]
fn bcr_leaves_the_order_of_lines_open() {
    let expected = |x, y| without(bumps(x, y), [x, y], [2e-6, 3e-6], [20.0, 30.0], [10.0, 14.0]);
    let turned = Options {
        first_row: Some(FirstRow::HighestY),
        ..Options::default()
    };
    let worst = error(&scan("bcr1_surface_ascii.sdf", &turned).map, expected);
    assert!(worst <= 0.5e-10 * (1.0 + 1e-5), "{worst}");
    // The largest unsigned number is missing, zero is a height.
    let unsigned = scan("bcr1_surface_uint16_binary.sdf", &turned).map;
    let lowest = (0..48 * 32).map(|k| bumps((k % 48) as f64 * 2e-6, (k / 48) as f64 * 3e-6));
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    let worst = error(&unsigned, |x, y| expected(x, y) - lowest);
    assert!(worst <= 0.5e-10 * (1.0 + 1e-5), "{worst}");

    let open = scan("bcr1_surface_ascii.sdf", &Options::default());
    assert!(
        open.notes.iter().any(|note| note.contains("lowest y")),
        "{:?}",
        open.notes
    );
    let last = 31.0 * 3e-6;
    let worst = error(&open.map, |x, y| {
        without(
            bumps(x, last - y),
            [x, last - y],
            [2e-6, 3e-6],
            [20.0, 30.0],
            [10.0, 14.0],
        )
    });
    assert!(worst <= 0.5e-10 * (1.0 + 1e-5), "{worst}");
}

#[test]
fn x3p_of_others() {
    let unit = [1e-6, 1e-6];
    let holes = |x, y| without(waves(x, y), [x, y], unit, [70.0, 85.0], [40.0, 52.0]);
    let surface = scan("surface_binary.x3p", &Options::default());
    assert_eq!(
        (surface.map.nx(), surface.map.ny(), surface.map.missing()),
        (200, 150, 180)
    );
    let step = surface.stated_step.unwrap();
    assert!(error(&surface.map, holes) <= 0.5 * step * (1.0 + 1e-9));
    assert_eq!(surface.notes, Vec::<String>::new());

    let listed = scan("surface_int32_xml.x3p", &Options::default());
    let worst = error(&listed.map, |x, y| {
        without(waves(x, y), [x, y], unit, [40.0, 50.0], [30.0, 36.0])
    });
    assert!(worst <= 0.5 * listed.stated_step.unwrap() * (1.0 + 1e-5), "{worst}");

    let single = scan("surface_extensions_binary.x3p", &Options::default());
    assert!(error(&single.map, waves) < 1.3e-6 * 6e-8);
    assert_eq!(single.notes, ["3 other members of the archive ignored"]);

    // A rotation by 10 degrees is reported, not applied.
    let placed = scan("surface_placed_binary.x3p", &Options::default());
    assert!(error(&placed.map, waves) < 1e-21);
    assert!(placed.notes[0].starts_with("rotation and offsets [1e-6, 0.005, 1.0] m not applied"));

    let refused = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scans").join(name);
        readers::read(&path, &Options::default()).unwrap_err().to_string()
    };
    assert!(refused("profile_int16_binary.x3p").contains("a feature of type `PRF` is not supported"));
    assert!(refused("point_cloud_int16_binary.x3p").contains("have no regular x"));
    assert!(refused("iso2_profile_binary.sdf").contains("ny = 1 points"));
}

#[test]
fn sur_of_others() {
    let expected = |x, y| without(bumps(x, y), [x, y], [2e-6, 3e-6], [5.0, 10.0], [10.0, 14.0]);
    for name in ["surfalize.sur", "surfalize_compressed.sur"] {
        let scan = scan(name, &Options::default());
        assert_eq!((scan.map.nx(), scan.map.ny(), scan.map.missing()), (24, 20, 20));
        assert_eq!(scan.map.step(), [2e-6, 3e-6]);
        assert_eq!(scan.height_unit, Declaration::File(LengthUnit::Micrometre));
        // Spacing and offset in single precision.
        let worst = error(&scan.map, expected);
        assert!(worst < 2.6e-6 * 6e-8, "{name}: {worst}");
    }
    // 16 bits in nm; that program counts heights from the lowest.
    let scan = scan("rosettasciio_16.sur", &Options::default());
    assert_eq!(scan.stated_step, Some(1e-9));
    let lowest = (0..24 * 20).map(|k| bumps((k % 24) as f64 * 2e-6, (k / 24) as f64 * 3e-6));
    let lowest = (lowest.fold(f64::INFINITY, f64::min) * 1e9).round() * 1e-9;
    let worst = error(&scan.map, |x, y| bumps(x, y) + lowest);
    assert!(worst <= 0.5e-9 * (1.0 + 1e-5), "{worst}");
}

#[test]
fn numpy_of_others() {
    let expected = |x, y| without(bumps(x, y), [x, y], [2e-6, 3e-6], [5.0, 10.0], [10.0, 14.0]);
    let options = Options {
        lateral_step: Some([2.0, 3.0]),
        ..micrometres()
    };
    let double = scan("f8.npy", &options);
    assert_eq!((double.format, double.map.nx(), double.map.ny()), (Format::Npy, 24, 20));
    assert!(error(&double.map, expected) < 1e-20);
    assert_eq!(double.lateral_unit, Declaration::Caller(LengthUnit::Micrometre));
    // Big-endian single precision, by columns.
    assert!(error(&scan("columns.npy", &options).map, expected) < 1.3e-6 * 6e-8);

    let nanometres = |array: Option<&str>| Options {
        height_unit: Some(LengthUnit::Nanometre),
        array: array.map(str::to_owned),
        ..options.clone()
    };
    let archive = |options: &Options| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scans/maps.npz");
        readers::read(&path, options)
    };
    let message = archive(&nanometres(None)).unwrap_err().to_string();
    assert!(message.contains("`height`, `mask`, `pitch`; pass `array`"), "{message}");
    assert!(
        archive(&nanometres(Some("depth")))
            .unwrap_err()
            .to_string()
            .contains("`height`")
    );
    let chosen = archive(&nanometres(Some("height"))).unwrap();
    assert!(error(&chosen.map, bumps) <= 0.5e-9 * (1.0 + 1e-5));
    assert_eq!(chosen.notes[0], "arrays ignored: mask, pitch");
}

#[test]
fn what_is_written_is_read_to_the_last_bit() {
    let mut heights: Vec<f64> = (0..35).map(|k| (f64::from(k) * 0.7).sin() * 1e-6 / 3.0).collect();
    heights[3] = f64::NAN;
    heights[34] = f64::NAN;
    heights[5] = -0.0;
    heights[6] = f64::MIN_POSITIVE / 8.0;
    let map = HeightMap::try_new(7, 5, [1e-6 / 3.0, 1e-5 / 7.0], [-0.1, 1e-7 / 3.0], heights).unwrap();
    let x3p = writers::x3p(&map).unwrap();
    assert_eq!(x3p, writers::x3p(&map).unwrap());
    for (name, bytes) in [("a.x3p", x3p), ("a.csv", writers::csv(&map).into_bytes())] {
        let scan = readers::parse(Source { name, bytes: &bytes }, &Options::default()).unwrap();
        assert_eq!((scan.map.step(), scan.map.origin()), (map.step(), map.origin()));
        assert_eq!((scan.map.nx(), scan.map.ny(), scan.map.missing()), (7, 5, 2));
        for k in 0..35 {
            let bits = |map: &HeightMap| map.height(k % 7, k / 7).map(f64::to_bits);
            assert_eq!(bits(&scan.map), bits(&map), "{name}: {k}");
        }
        assert_eq!(scan.lateral_unit, Declaration::File(LengthUnit::Metre));
    }
}

mod random_maps {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn survive_writing_and_reading(
            (nx, heights) in (3usize..9, 3usize..9).prop_flat_map(|(nx, ny)| {
                let height = prop_oneof![9 => any::<f64>(), 1 => Just(f64::NAN)].prop_filter("finite", |z| !z.is_infinite());
                (Just(nx), prop::collection::vec(height, nx * ny))
            }),
            step in [1e-9f64..1e-2, 1e-9f64..1e-2],
            origin in [-1.0f64..1.0, -1.0f64..1.0],
        ) {
            let ny = heights.len() / nx;
            let map = HeightMap::try_new(nx, ny, step, origin, heights).unwrap();
            let options = Options {
                accept_implausible: true,
                ..Options::default()
            };
            // Three columns are points otherwise.
            let grid = Options { format: Some(Format::Grid), ..options.clone() };
            let written = [(writers::x3p(&map).unwrap(), &options), (writers::csv(&map).into_bytes(), &grid)];
            for (bytes, options) in &written {
                let read = readers::parse(Source { name: "written", bytes }, options).unwrap().map;
                prop_assert_eq!((read.nx(), read.ny(), read.step(), read.origin()), (nx, ny, step, origin));
                for k in 0..nx * ny {
                    let bits = |map: &HeightMap| map.height(k % nx, k / nx).map(f64::to_bits);
                    prop_assert_eq!(bits(&read), bits(&map));
                }
            }
        }
    }
}
