//! The licences of all that is linked into the program.

use super::archive::File;
use super::process::{command, output};
use super::sources::Sources;
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Name, version, licence and repository of every package of others, with the texts in its sources. Many packages have the same text, which is
/// printed once.
///
/// # Errors
/// A text that cannot be read.
pub fn third_party(sources: &Sources) -> Result<String> {
    let mut list = format!(
        "Packages of others that are linked into microslip {}\n",
        sources.version
    );
    let mut texts: Vec<String> = Vec::new();
    for package in sources.packages.iter().filter(|package| !package.is_own()) {
        let mut numbers = Vec::new();
        for (file, text) in package.texts()? {
            let text = text.trim_end().replace("\r\n", "\n");
            let known = texts.iter().position(|known| *known == text);
            let number = known.unwrap_or_else(|| {
                texts.push(text);
                texts.len() - 1
            });
            numbers.push(format!("{} ({file})", number + 1));
        }
        let licence = package.licence().unwrap_or_else(|| "see the texts".into());
        let repository = package.repository.as_deref().unwrap_or("none");
        let numbers = match numbers.is_empty() {
            true => "none in the package".into(),
            false => numbers.join(", "),
        };
        // Writing to a string cannot fail.
        let _ = write!(
            list,
            "\n{} {}\n  licence: {licence}\n  repository: {repository}\n  texts: {numbers}\n",
            package.name, package.version
        );
    }
    for (index, text) in texts.iter().enumerate() {
        let _ = write!(list, "\n======== text {} ========\n\n{text}\n", index + 1);
    }
    Ok(list)
}

/// The notices of the libraries that are part of every static program, of Rust and of C.
///
/// # Errors
/// One of them is not on this computer.
pub fn of_libraries(sources: &Sources) -> Result<BTreeMap<String, File>> {
    let rust = output(&mut command("rustc --print sysroot", &sources.root))?;
    let rust = Path::new(rust.trim()).join("share/doc/rust/COPYRIGHT-library.html");
    let files = [
        ("rust-library.html", rust.as_path()),
        ("glibc.txt", Path::new("/usr/share/doc/libc6-dev/copyright")),
        ("LGPL-2.1.txt", Path::new("/usr/share/common-licenses/LGPL-2.1")),
    ];
    let read = |(name, path): (&str, &Path)| {
        let remedy = || {
            format!(
                "reading {}, which the licences of static programs ask for: install it",
                path.display()
            )
        };
        Ok((
            format!("licenses/{name}"),
            File::new(std::fs::read(path).with_context(remedy)?),
        ))
    };
    files.into_iter().map(read).collect()
}
