//! What is read, what is refused, and how much memory a refusal takes.

use file_io::input::{Error, Kind, read, read_at_most, read_text};
use std::fs::File;
use test_support::TemporaryFolder;

#[test]
fn regular_files_are_read_whole() {
    let folder = TemporaryFolder::new("input-files-whole");
    let path = folder.join("table.csv");
    std::fs::write(&path, "a,b\n").unwrap();
    for kind in Kind::ALL {
        assert_eq!(read(&path, kind).unwrap(), b"a,b\n");
        assert_eq!(read_text(&path, kind).unwrap(), "a,b\n");
    }
    assert_eq!(read_at_most(&path, Kind::Table, 4).unwrap().len(), 4);
    std::fs::write(&path, b"a\xff").unwrap();
    assert!(matches!(
        read_text(&path, Kind::Table),
        Err(Error::NotText { byte: 1, .. })
    ));
    let absent = read(&folder.join("none"), Kind::Table).unwrap_err();
    assert!(
        matches!(absent, Error::Unreadable { .. }) && absent.to_string().contains("none"),
        "{absent}"
    );
}

#[test]
fn large_files_are_refused_before_they_are_read() {
    let folder = TemporaryFolder::new("input-files-large");
    let path = folder.join("zeros.npz");
    // Without blocks on the disk.
    let limit = Kind::Matrices.limit();
    File::create(&path).unwrap().set_len(limit + 1).unwrap();
    let error = read(&path, Kind::Matrices).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, Error::TooLarge { exact: true, .. }));
    for part in [
        "zeros.npz",
        "4294967297",
        "at most 4294967296",
        "store the matrices sparse",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let small = folder.join("small");
    std::fs::write(&small, "12345").unwrap();
    assert!(matches!(
        read_at_most(&small, Kind::Deck, 4),
        Err(Error::TooLarge { size: 5, limit: 4, .. })
    ));
}

#[cfg(target_os = "linux")]
#[test]
fn what_has_no_end_is_refused() {
    use std::process::Command;
    use std::time::{Duration, Instant};

    let folder = TemporaryFolder::new("input-files-endless");
    let begin = Instant::now();
    let pipe = folder.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let link = folder.join("link");
    std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
    let _socket = std::os::unix::net::UnixListener::bind(folder.join("socket")).unwrap();
    for (path, expected) in [
        (pipe, "a pipe"),
        (link, "a device"),
        ("/dev/zero".into(), "a device"),
        (folder.join("socket"), "a socket"),
        ("/proc".into(), "a folder"),
    ] {
        let error = read(&path, Kind::Scan).unwrap_err();
        assert!(
            matches!(error, Error::NotRegular { found, .. } if found == expected),
            "{error}"
        );
    }
    // A regular file by its type, of size zero by its metadata.
    let error = read_at_most("/proc/cpuinfo".as_ref(), Kind::Table, 10).unwrap_err();
    assert!(
        matches!(
            error,
            Error::TooLarge {
                exact: false,
                limit: 10,
                ..
            }
        ),
        "{error}"
    );
    assert!(begin.elapsed() < Duration::from_secs(10));
}
