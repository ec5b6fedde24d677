//! The committed header is the one that cbindgen makes from the sources.

use std::fs;
use std::path::Path;

use contact_laws::{
    AsperityLimit, Choice, Cone, HistoryRule, Sticking, TangentialEnds, TangentialReading, YieldCurves,
};
use contact_laws_c::Constant;

/// The constants of everything that callers choose.
fn constants() -> String {
    fn of<T: Choice>() -> String {
        let define = |&value: &T| {
            let (comment, number) = (value.summary().replace('`', ""), value.number());
            format!(
                "/*\n {}. {comment}\n */\n#define {} {number}\n",
                T::TITLE,
                Constant(value)
            )
        };
        T::ALL.iter().map(define).collect::<Vec<_>>().join("\n")
    }
    let all = [
        of::<HistoryRule>(),
        of::<Cone>(),
        of::<AsperityLimit>(),
        of::<YieldCurves>(),
        of::<Sticking>(),
        of::<TangentialEnds>(),
        of::<TangentialReading>(),
    ];
    format!("\n{}", all.join("\n").trim_end())
}

#[test]
fn the_header_belongs_to_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    config.after_includes = Some(constants());
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
    if std::env::var_os("CONTACT_LAWS_WRITE").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == made,
        "{} is out of date: set CONTACT_LAWS_WRITE=1 and run this test again",
        path.display()
    );
}
