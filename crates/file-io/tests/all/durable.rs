//! Single files, sealed files, locks and manifests as their users meet them.
#![expect(clippy::unwrap_used, reason = "tests")]

use file_io::durable::{
    Defect, Error, Folder, Identity, MANIFEST, Manifest, read_sealed, seal, unseal, write, write_sealed,
};
use std::fs::File;
use std::path::{Path, PathBuf};
use test_support::TemporaryFolder;

const FILES: [(&str, &[u8]); 2] = [("table.csv", b"1,2\n3,4\n"), ("summary.json", b"{\"f\": 1.5}")];

fn identity() -> Identity {
    Identity::new("run", "scene")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn published(name: &str) -> TemporaryFolder {
    let directory = TemporaryFolder::new(name);
    Folder::open(&directory, &identity(), false)
        .unwrap()
        .publish(&FILES)
        .unwrap();
    directory
}

#[test]
fn a_failed_write_leaves_the_old_file_and_no_temporary_one() {
    let directory = TemporaryFolder::new("durable-failed");
    // A folder in the place of the file: all goes well but the last step.
    let target = directory.join("target");
    std::fs::create_dir_all(target.join("inside")).unwrap();
    let error = write(&target, b"contents").unwrap_err();
    assert!(matches!(&error, Error::File { path, .. } if *path == target), "{error}");
    assert_eq!(names(&directory), ["target"]);
}

#[test]
fn parts_of_killed_writers_are_removed_and_those_of_living_ones_are_not() {
    let directory = TemporaryFolder::new("durable-parts");
    let (dead, living) = (".microslip-aaaaaaaaaaaa.part", ".microslip-bbbbbbbbbbbb.part");
    let foreign = ".table.csv.part17";
    for name in [dead, living, foreign] {
        std::fs::write(directory.join(name), "half").unwrap();
    }
    let held = File::open(directory.join(living)).unwrap();
    held.lock().unwrap();
    write(&directory.join("table.csv"), b"1,2\n").unwrap();
    assert_eq!(names(&directory), [living, foreign, "table.csv"]);
    drop(held);
    write(&directory.join("table.csv"), b"1,3\n").unwrap();
    assert_eq!(names(&directory), [foreign, "table.csv"]);
    assert_eq!(std::fs::read(directory.join("table.csv")).unwrap(), b"1,3\n");
}

#[cfg(unix)]
#[test]
fn files_have_the_permissions_of_usual_files() {
    use std::os::unix::fs::PermissionsExt;
    let directory = published("durable-mode");
    write(&directory.join("new"), b"").unwrap();
    std::fs::write(directory.join("usual"), "").unwrap();
    let mode = |name: &str| std::fs::metadata(directory.join(name)).unwrap().permissions().mode();
    for name in ["new", "table.csv", MANIFEST] {
        assert_eq!(mode(name), mode("usual"), "{name}");
    }
}

#[test]
fn a_sealed_file_with_any_bit_flipped_or_byte_missing_is_absent() {
    let sealed = seal(b"header\n\x00\x01numbers");
    assert_eq!(unseal(&sealed).unwrap(), b"header\n\x00\x01numbers");
    for place in 0..sealed.len() {
        for bit in 0..8 {
            let mut damaged = sealed.clone();
            damaged[place] ^= 1 << bit;
            assert!(unseal(&damaged).is_none(), "byte {place}, bit {bit}");
        }
        assert!(unseal(&sealed[..place]).is_none(), "{place} bytes");
    }
    let directory = TemporaryFolder::new("durable-sealed");
    let path = directory.join("sealed");
    assert!(read_sealed(&path).is_none());
    write_sealed(&path, b"contents").unwrap();
    assert_eq!(read_sealed(&path).unwrap(), b"contents");
}

#[test]
fn a_folder_is_held_by_one_process_that_others_are_told() {
    let directory = TemporaryFolder::new("durable-lock");
    let held = Folder::open(&directory, &identity(), false).unwrap();
    assert!(held.is_locked());
    let error = Folder::open(&directory, &identity(), true).unwrap_err();
    assert!(matches!(error, Error::Busy { .. }), "{error}");
    let text = error.to_string();
    for part in [
        "`run` of scene",
        &format!("process {} on ", std::process::id()),
        "--out",
    ] {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    drop(held);
    assert_eq!(names(&directory), Vec::<String>::new());
    // What a killed process leaves is a file that nobody has locked.
    std::fs::write(directory.join(".microslip-lock"), "somebody\n").unwrap();
    Folder::open(&directory, &identity(), false).unwrap();
}

/// The holder removes the file of the lock: nobody may take a lock on a file that is no longer there.
#[test]
fn many_threads_hold_a_folder_one_after_the_other() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let directory = TemporaryFolder::new("durable-contended");
    let inside = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            // No limit on attempts: how many fail while another thread holds the folder is up to
            // the scheduler, and each holder lets go.
            scope.spawn(|| {
                let mut held = 0;
                while held < 25 {
                    match Folder::open(&directory, &identity(), false) {
                        Ok(folder) => {
                            assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0);
                            held += 1;
                            std::thread::yield_now();
                            inside.fetch_sub(1, Ordering::SeqCst);
                            drop(folder);
                        }
                        Err(Error::Busy { .. }) => std::thread::yield_now(),
                        Err(other) => panic!("{other}"),
                    }
                }
            });
        }
    });
    assert_eq!(inside.into_inner(), 0);
}

#[test]
fn results_of_something_else_are_kept_unless_told_otherwise() {
    let directory = published("durable-other");
    let other = Identity::new("run", "another");
    let error = Folder::open(&directory, &other, false).unwrap_err();
    assert!(matches!(error, Error::OtherResults { .. }), "{error}");
    let text = error.to_string();
    for part in ["`run` of scene", "`run` of another", "--out", "--overwrite"] {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    let replace = Folder::open(&directory, &other, true).unwrap();
    replace.publish(&[("summary.json", b"other")]).unwrap();
    assert_eq!(names(&directory), [MANIFEST, "summary.json"]);
    assert_eq!(Manifest::read(&directory).unwrap().identity, other);
}

#[test]
fn files_of_no_set_are_kept_unless_told_otherwise() {
    let directory = TemporaryFolder::new("durable-unlisted");
    std::fs::write(directory.join("table.csv"), "mine").unwrap();
    let open = |overwrite| Folder::open(&directory, &identity(), overwrite).unwrap();
    let error = open(false).expect(["summary.json", "table.csv"]).unwrap_err();
    assert!(
        matches!(&error, Error::Unlisted { path, .. } if path.ends_with("table.csv")),
        "{error}"
    );
    assert!(matches!(open(false).publish(&FILES), Err(Error::Unlisted { .. })));
    assert_eq!(std::fs::read(directory.join("table.csv")).unwrap(), b"mine");
    open(true).publish(&FILES).unwrap();
    assert_eq!(std::fs::read(directory.join("table.csv")).unwrap(), FILES[0].1);
    // A folder in the way is not removed, whatever is told.
    std::fs::create_dir(directory.join("page.html")).unwrap();
    let obstructed = open(true).publish(&[("page.html", b"page")]);
    assert!(matches!(obstructed, Err(Error::Obstructed { .. })));
    assert!(
        Manifest::read(&directory)
            .unwrap()
            .defects(&directory)
            .unwrap()
            .is_empty()
    );
}

#[test]
fn any_changed_byte_of_any_file_of_a_set_is_named() {
    let directory = published("durable-changed");
    for (name, contents) in FILES {
        let path = directory.join(name);
        for place in 0..contents.len() {
            let mut damaged = contents.to_vec();
            damaged[place] ^= 1;
            std::fs::write(&path, damaged).unwrap();
            let defects = Manifest::read(&directory).unwrap().defects(&directory).unwrap();
            assert!(
                matches!(&defects[..], [Defect::Changed { name: found, .. }] if found == name),
                "{defects:?}"
            );
        }
        std::fs::write(&path, contents).unwrap();
    }
    std::fs::remove_file(directory.join("table.csv")).unwrap();
    let defects = Manifest::read(&directory).unwrap().defects(&directory).unwrap();
    assert_eq!(
        defects,
        [Defect::Missing {
            name: "table.csv".into()
        }]
    );
}

#[test]
fn any_changed_byte_of_a_manifest_is_noticed() {
    let directory = published("durable-manifest");
    let path = directory.join(MANIFEST);
    let intact = std::fs::read(&path).unwrap();
    for place in 0..intact.len() {
        let mut damaged = intact.clone();
        damaged[place] ^= 1;
        std::fs::write(&path, &damaged).unwrap();
        let read = Manifest::read(&directory);
        assert!(
            matches!(read, Err(Error::DamagedManifest { .. })),
            "byte {place}: {read:?}"
        );
    }
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(Manifest::read(&directory), Err(Error::NoManifest { .. })));
}

/// A manifest of others may be consistent and yet name files elsewhere, which a later run would remove.
#[test]
fn a_manifest_names_files_of_its_own_folder_only() {
    let outside = TemporaryFolder::new("durable-outside");
    let victim: PathBuf = outside.join("victim");
    std::fs::write(&victim, "mine").unwrap();
    let directory = published("durable-escape");
    let text = std::fs::read_to_string(directory.join(MANIFEST)).unwrap();
    let text = text.replace("table.csv", "../victim");
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    value["sha256"] = "".into();
    std::fs::write(
        directory.join(MANIFEST),
        serde_json::to_string_pretty(&value).unwrap() + "\n",
    )
    .unwrap();
    let error = Manifest::read(&directory).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("`../victim` is no file of the folder itself"),
        "{error}"
    );
}
