//! Texts that come with the program.

use super::archive::File;
use super::elf::Linkage;
use super::sources::Sources;
use anyhow::{Context, Result, ensure};
use clap::CommandFactory;
use clap_complete::Shell;
use clap_mangen::Man;
use file_io::durable::sha256;
use microslip::cli::{Cli, completions};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Manual pages of the program and of its commands, and completions for shells.
///
/// # Errors
/// A page that cannot be made.
pub fn of_the_command_line() -> Result<BTreeMap<String, File>> {
    let mut files = BTreeMap::new();
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    for command in std::iter::once(&program).chain(program.get_subcommands()) {
        let (manual, mut page) = (Man::new(command.clone()), Vec::new());
        let name = manual.get_filename();
        manual
            .render(&mut page)
            .with_context(|| format!("making the manual page {name}"))?;
        files.insert(format!("man/{name}"), File::new(page));
    }
    for (shell, name) in [
        (Shell::Bash, "microslip.bash"),
        (Shell::Zsh, "_microslip"),
        (Shell::Fish, "microslip.fish"),
    ] {
        files.insert(format!("completions/{name}"), File::new(completions(shell)));
    }
    Ok(files)
}

/// The text of a release: what changed, as the first section of the change log says, and the files.
///
/// # Errors
/// That section is of another version.
pub fn release(
    sources: &Sources,
    changes: &str,
    linkage: Option<Linkage>,
    files: &BTreeMap<String, Vec<u8>>,
) -> Result<String> {
    let section = changes.split("\n## ").nth(1).unwrap_or_default();
    let (title, section) = section.split_once('\n').unwrap_or_default();
    let of_version = title.split_whitespace().next() == Some(sources.version.as_str());
    ensure!(
        of_version,
        "the first section of CHANGELOG.md, `{title}`, is not of version {}: add one",
        sources.version
    );
    let mut text = format!(
        "# Microslip {}\n\nOf commit {}, {}.\n\n{}\n\n## Files\n\n",
        sources.version,
        sources.commit,
        sources.date,
        section.trim()
    );
    // Writing to a string cannot fail.
    if let Some(linkage) = linkage {
        let _ = write!(text, "The program is {linkage}. ");
        if linkage == Linkage::Static {
            let _ = write!(
                text,
                "glibc {}, under LGPL-2.1-or-later, is linked in: `cargo build` at this commit links the program with any other. ",
                sources.glibc
            );
        }
        text += "`Containerfile` and `meta.yaml`, a recipe for conda, were not built here.\n\n";
    }
    text += "| file | bytes | SHA-256 |\n|---|---|---|\n";
    for (name, contents) in files {
        let _ = writeln!(text, "| `{name}` | {} | `{}` |", contents.len(), sha256(contents));
    }
    Ok(text)
}

/// Checksums, as `sha256sum --check` reads them.
pub fn checksums(files: &BTreeMap<String, Vec<u8>>) -> String {
    files
        .iter()
        .map(|(name, contents)| format!("{}  {name}\n", sha256(contents)))
        .collect()
}

/// How a container is made of an archive beside it. `folder` is that in the archive.
pub fn containerfile(archive: &str, folder: &str, linkage: Linkage) -> String {
    // A program that needs libraries needs a system that has them.
    let base = match linkage {
        Linkage::Static => "scratch",
        Linkage::Dynamic(_) => "debian:stable-slim",
    };
    format!(
        "# Not built here.\n# podman build -t microslip .   then: podman run -v \"$PWD\":/work microslip run --benchmark brake-reuss-beam\n\
         FROM {base}\nADD {archive} /\nWORKDIR /work\nENTRYPOINT [\"/{folder}/microslip\"]\n"
    )
}

/// A recipe for conda, of an archive beside it.
pub fn recipe(version: &str, archive: &str, contents: &[u8]) -> String {
    format!(
        r#"# Not built here.
# conda build .
package:
  name: microslip
  version: "{version}"
source:
  url: {archive}
  sha256: {sum}
build:
  number: 0
  skip: true  # [not (linux and x86_64)]
  binary_relocation: false
  script:
    - mkdir -p "$PREFIX/bin" "$PREFIX/share/man/man1" "$PREFIX/share/bash-completion/completions"
    - cp microslip "$PREFIX/bin/"
    - cp man/*.1 "$PREFIX/share/man/man1/"
    - cp completions/microslip.bash "$PREFIX/share/bash-completion/completions/microslip"
test:
  commands:
    - microslip --version
about:
  summary: Frequency and damping of bolted joints against amplitude
  license: MIT OR Apache-2.0
  license_file:
    - LICENSE-MIT
    - LICENSE-APACHE
    - THIRD-PARTY-LICENSES.txt
"#,
        sum = sha256(contents)
    )
}
