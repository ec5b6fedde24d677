//! `cargo xtask dist`: what people without Rust need.

use anyhow::{Context, Result};
use file_io::durable::Identity;
use microslip::commands::print;
use microslip::files::publish;
use reports::Output;
use std::collections::BTreeMap;
use std::path::Path;
use validation::dist::archive::{File, tar_gz};
use validation::dist::elf::Linkage;
use validation::dist::sources::Sources;
use validation::dist::{build, licences, sbom, text, trial};
use xtask::arguments;

/// Runs the command.
pub(crate) fn run(arguments: &arguments::Dist) -> Result<()> {
    let sources = Sources::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")))?;
    if !arguments.only_text {
        sources.ensure_clean()?;
    }
    let results = arguments
        .overwrite
        .open(&arguments.out, &Identity::new("dist", ""), &[])?;
    if arguments.packages {
        build::packages(&sources)?;
    }
    let changes = sources.file("CHANGELOG.md")?;
    let mut contents = text::of_the_command_line()?;
    for name in ["README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        contents.insert(name.into(), File::new(sources.file(name)?));
    }
    contents.insert("CHANGELOG.md".into(), File::new(changes.clone()));
    contents.insert(
        "THIRD-PARTY-LICENSES.txt".into(),
        File::new(licences::third_party(&sources)?),
    );
    let components = format!("{:#}\n", sbom::cyclonedx(&sources)).into_bytes();
    contents.insert("microslip.cdx.json".into(), File::new(components.clone()));
    let mut files = BTreeMap::from([(format!("microslip-{}.cdx.json", sources.version), components)]);
    let linkage = match arguments.only_text {
        true => {
            let folder = format!("microslip-{}-text", sources.version);
            files.insert(format!("{folder}.tar.gz"), tar_gz(&folder, &contents, sources.seconds)?);
            None
        }
        false => Some(built(&sources, contents, &mut files)?),
    };
    let release = text::release(&sources, &changes, linkage, &files)?;
    files.insert("RELEASE.md".into(), release.into_bytes());
    files.insert("SHA256SUMS".into(), text::checksums(&files).into_bytes());
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    let names = names.join(", ");
    let outputs: Vec<Output> = files
        .into_iter()
        .map(|(name, contents)| Output::new(name, contents))
        .collect();
    publish(results, &outputs)?;
    print(&format!("written to {}: {names}\n", arguments.out.display()))
}

/// Builds and tries what is compiled, and adds it to the files.
fn built(
    sources: &Sources,
    mut contents: BTreeMap<String, File>,
    files: &mut BTreeMap<String, Vec<u8>>,
) -> Result<Linkage> {
    let scratch = tempfile::tempdir_in(&sources.target)
        .with_context(|| format!("making a folder in {}", sources.target.display()))?;
    print("the program is compiled: minutes\n")?;
    let (program, linkage) = build::program(sources, &print)?;
    print(&format!("the program is {linkage}; {} bytes\n", program.len()))?;
    let is_program = true;
    contents.insert(
        "microslip".into(),
        File {
            contents: program,
            is_program,
        },
    );
    if linkage == Linkage::Static {
        contents.extend(licences::of_libraries(sources)?);
    }
    let folder = format!("microslip-{}-x86_64-linux", sources.version);
    let (name, archive) = (format!("{folder}.tar.gz"), tar_gz(&folder, &contents, sources.seconds)?);
    trial::program(sources, &archive, &folder, linkage, scratch.path(), &print)?;
    files.insert(
        "Containerfile".into(),
        text::containerfile(&name, &folder, linkage).into_bytes(),
    );
    files.insert(
        "meta.yaml".into(),
        text::recipe(&sources.version, &name, &archive).into_bytes(),
    );
    files.insert(name, archive);
    print("the Python package is compiled: minutes\n")?;
    let package = build::python_package(sources, scratch.path(), &print)?;
    for (name, contents) in package.iter().filter(|(name, _)| name.ends_with(".whl")) {
        trial::wheel(name, contents, scratch.path(), &print)?;
    }
    files.extend(package);
    Ok(linkage)
}
