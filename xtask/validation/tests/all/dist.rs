//! What is published, as far as it needs no compilation.
#![allow(clippy::unwrap_used)]
#![expect(clippy::print_stdout, reason = "tests say what they skip")]

use crate::common::{folder, succeeds};
use flate2::read::GzDecoder;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::Path;
use validation::dist::archive::{File, tar_gz};
use validation::dist::elf::{Linkage, linkage};
use validation::dist::sources::Sources;
use validation::dist::{sbom, text};

/// None of a copy without its history, which has no commit.
fn sources() -> Option<Sources> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    if !root.join(".git").exists() {
        println!("skipped: this is no checkout");
        return None;
    }
    Some(Sources::read(&root).unwrap())
}

/// Name, mode and time of the files in an archive, and what they hold.
fn unpacked(archive: &[u8]) -> BTreeMap<String, (u32, u64, Vec<u8>)> {
    let mut archive = tar::Archive::new(GzDecoder::new(archive));
    let entries = archive.entries().unwrap().map(|entry| {
        let (mut entry, mut contents) = (entry.unwrap(), Vec::new());
        entry.read_to_end(&mut contents).unwrap();
        let name = entry.path().unwrap().to_string_lossy().into_owned();
        let header = entry.header();
        assert_eq!((header.uid().unwrap(), header.gid().unwrap()), (0, 0), "{name}");
        (name, (header.mode().unwrap(), header.mtime().unwrap(), contents))
    });
    entries.collect()
}

/// A 64-bit ELF file with these program headers: their types, and the entries of the dynamic section.
fn elf(types: &[u32], dynamic: &[u64], strings: &[u8]) -> Vec<u8> {
    let mut file = b"\x7fELF\x02\x01".to_vec();
    file.resize(64, 0);
    file[32] = 64;
    file[54] = 56;
    file[56] = u8::try_from(types.len()).unwrap();
    let begin = 64 + 56 * types.len() as u64;
    for kind in types {
        let header = file.len();
        file.extend(kind.to_le_bytes());
        file.resize(header + 56, 0);
        file[header + 8..header + 16].copy_from_slice(&begin.to_le_bytes());
        file[header + 32..header + 40].copy_from_slice(&(16 * dynamic.len() as u64).to_le_bytes());
    }
    for tag in dynamic {
        file.extend(tag.to_le_bytes());
        file.extend([0; 8]);
    }
    file.extend(strings);
    file
}

#[test]
fn a_program_is_static_that_names_neither_an_interpreter_nor_a_library() {
    // A static program that can be moved has a dynamic section all the same.
    for sound in [elf(&[1], &[], b""), elf(&[1, 2], &[5, 0, 1], b"\0GLIBC_2.2.5\0")] {
        assert_eq!(linkage(&sound).unwrap(), Linkage::Static);
    }
    let versions = b"\0GLIBC_2.4\0GLIBC_2.34\0GLIBC_2.2.5\0GLIBC_PRIVATE\0";
    for dynamic in [elf(&[3, 1], &[], versions), elf(&[1, 2], &[5, 1, 0], versions)] {
        let found = linkage(&dynamic).unwrap();
        assert_eq!(found, Linkage::Dynamic(Some((2, 34))));
        assert!(found.to_string().contains("glibc 2.34 or later"));
    }
    assert!(linkage(b"#!/bin/sh").is_err());
    // Wherever it is cut off, and whatever its headers say.
    let whole = elf(&[1, 2], &[5, 7, 9], b"");
    for length in 0..whole.len() - 8 {
        assert!(linkage(&whole[..length]).is_err(), "{length}");
    }
    let mut far = whole;
    far[32..40].fill(0xff);
    assert!(linkage(&far).is_err());
}

#[test]
fn archives_are_the_same_bytes_with_fixed_times_modes_and_owners() {
    let program = File {
        contents: vec![7; 3000],
        is_program: true,
    };
    let files = BTreeMap::from([("b/text".to_owned(), File::new("b")), ("a".to_owned(), program)]);
    let archive = tar_gz("top", &files, 1_700_000_000).unwrap();
    assert_eq!(archive, tar_gz("top", &files, 1_700_000_000).unwrap());
    // No time and no name of the compressor's own.
    assert_eq!((archive[3], &archive[4..8]), (0, &[0; 4][..]));
    let expected = [
        ("top/a".to_owned(), (0o755, 1_700_000_000, vec![7; 3000])),
        ("top/b/text".to_owned(), (0o644, 1_700_000_000, b"b".to_vec())),
    ];
    assert_eq!(unpacked(&archive), BTreeMap::from(expected));
}

/// What the schema of CycloneDX 1.5 asks for, and what readers of such lists look for.
#[test]
fn the_list_of_components_has_what_the_format_asks_for() {
    let Some(sources) = sources() else { return };
    let list = sbom::cyclonedx(&sources);
    assert_eq!(
        (&list["bomFormat"], &list["specVersion"]),
        (&"CycloneDX".into(), &"1.5".into())
    );
    assert_eq!(list["version"], 1);
    let program = &list["metadata"]["component"];
    assert_eq!(
        (&program["name"], &program["type"]),
        (&"microslip".into(), &"application".into())
    );
    let components = list["components"].as_array().unwrap();
    let mut refs = BTreeSet::from([program["bom-ref"].as_str().unwrap()]);
    for component in components {
        for field in ["type", "name", "version", "purl"] {
            assert!(!component[field].as_str().unwrap().is_empty(), "{component}");
        }
        assert!(
            refs.insert(component["bom-ref"].as_str().unwrap()),
            "twice: {component}"
        );
        assert!(component["licenses"][0]["expression"].is_string(), "{component}");
        if let Some(hashes) = component["hashes"].as_array() {
            let sum = hashes[0]["content"].as_str().unwrap();
            assert!(
                sum.len() == 64 && sum.bytes().all(|b| b.is_ascii_hexdigit()),
                "{component}"
            );
        }
    }
    let dependencies = list["dependencies"].as_array().unwrap();
    let of = |one: &Value| one["ref"].as_str().unwrap().to_owned();
    assert_eq!(dependencies.iter().map(of).collect::<BTreeSet<_>>().len(), refs.len());
    for dependency in dependencies {
        assert!(refs.contains(dependency["ref"].as_str().unwrap()), "{dependency}");
        for used in dependency["dependsOn"].as_array().into_iter().flatten() {
            assert!(refs.contains(used.as_str().unwrap()), "{dependency}");
        }
    }
    let one = |name: &str| components.iter().find(|component| component["name"] == name);
    let faer = one("faer").unwrap();
    assert!(faer["hashes"].is_array() && faer["purl"].as_str().unwrap().starts_with("pkg:cargo/faer@"));
    assert!(one("analyses").unwrap()["hashes"].is_null());
    // Macros, tests and tasks are no part of the program.
    for name in ["serde_derive", "proptest", "validation", "boon", "pyo3"] {
        assert!(one(name).is_none(), "{name}");
    }
}

#[test]
fn a_release_says_what_changed_and_names_every_file() {
    let Some(sources) = sources() else { return };
    let files = BTreeMap::from([("a.tar.gz".to_owned(), b"abc".to_vec())]);
    let changes = format!(
        "# Changelog\n\n## {} (unreleased)\n\n### New\n\n- Much.\n\n## 0.0.1\n\n- Little.\n",
        sources.version
    );
    let release = |changes: &str, linkage| text::release(&sources, changes, linkage, &files);
    let found = release(&changes, Some(Linkage::Static)).unwrap();
    for part in [
        "- Much.",
        "static",
        "LGPL",
        &sources.commit,
        "| `a.tar.gz` | 3 | `ba7816bf",
    ] {
        assert!(found.contains(part), "{part}: {found}");
    }
    assert!(!found.contains("Little") && !release(&changes, None).unwrap().contains("static"));
    let error = release("# Changelog\n\n## 0.0.1\n", None).unwrap_err().to_string();
    assert!(
        error.contains("CHANGELOG.md") && error.contains(&sources.version),
        "{error}"
    );
    assert!(text::checksums(&files).ends_with("f20015ad  a.tar.gz\n"));
}

#[test]
fn texts_are_whole_and_the_same_each_time() {
    if sources().is_none() {
        return;
    }
    let made = ["dist-1", "dist-2"].map(|name| {
        let folder = folder(name);
        succeeds(&folder, &["dist", "--only-text", "--out", "out"]);
        folder.join("out")
    });
    let sums = made
        .clone()
        .map(|out| std::fs::read_to_string(out.join("SHA256SUMS")).unwrap());
    assert_eq!(sums[0], sums[1]);
    let name = sums[0]
        .split_whitespace()
        .find(|word| word.ends_with("-text.tar.gz"))
        .unwrap();
    let files = unpacked(&std::fs::read(made[0].join(name)).unwrap());
    let text = |name: &str| {
        let found = files.iter().find(|(path, _)| path.ends_with(name));
        String::from_utf8(found.unwrap_or_else(|| panic!("no {name}")).1.2.clone()).unwrap()
    };
    for name in ["microslip.1", "microslip-run.1", "microslip-completions.1"] {
        assert!(text(name).contains(".SH SYNOPSIS"), "{name}");
    }
    for name in ["_microslip", "microslip.bash", "microslip.fish"] {
        assert!(text(name).contains("calibrate"), "{name}");
    }
    let licences = text("THIRD-PARTY-LICENSES.txt");
    for part in [
        "\nfaer 0.",
        "  licence: MIT\n",
        "======== text 1 ========",
        "THE SOFTWARE IS PROVIDED",
    ] {
        assert!(licences.contains(part), "{part}");
    }
    assert!(!licences.contains("\nanalyses "));
}
