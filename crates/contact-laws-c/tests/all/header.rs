//! The committed header is the one that cbindgen makes from the sources.

use std::fs;
use std::path::Path;

#[test]
fn the_header_belongs_to_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let builder = cbindgen::Builder::new().with_config(config);
    let mut made = Vec::new();
    builder
        .with_src(folder.join("src/lib.rs"))
        .generate()
        .unwrap()
        .write(&mut made);
    let made = String::from_utf8(made).unwrap();

    // An empty header would belong to no source.
    for entry in fs::read_dir(folder.join("src")).unwrap() {
        for line in fs::read_to_string(entry.unwrap().path()).unwrap().lines() {
            if let Some(rest) = line.strip_prefix("pub unsafe extern \"C\" fn ") {
                let declared = format!("{}(", rest.split('(').next().unwrap());
                let n = made
                    .lines()
                    .filter(|line| !line.starts_with(' ') && line.contains(&declared))
                    .count();
                assert_eq!(n, 1, "{declared}");
            }
        }
    }

    let path = folder.join("include/contact_laws.h");
    let committed = fs::read_to_string(&path).unwrap_or_default();
    if committed != made {
        let new = Path::new(env!("CARGO_TARGET_TMPDIR")).join("contact_laws.h");
        fs::write(&new, made).unwrap();
        panic!("{} is out of date: replace it with {}", path.display(), new.display());
    }
}
