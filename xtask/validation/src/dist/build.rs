//! Builds that give the same bytes in any folder.

use super::elf::{Linkage, linkage};
use super::process::{self, output};
use super::sources::{Sources, TARGET};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Tells somebody what is going on.
pub type Say<'a> = &'a dyn Fn(&str) -> Result<()>;

/// The program, and what it needs.
///
/// The C library is linked in where that can be done; the mathematical functions are then the same as in an ordinary build, which they would not be in
/// another C library.
///
/// # Errors
/// It does not compile.
pub fn program(sources: &Sources, say: Say<'_>) -> Result<(Vec<u8>, Linkage)> {
    if let Err(why) = compile(sources, &["-Ctarget-feature=+crt-static"]) {
        say(&format!("not static: {why:#}\n"))?;
        compile(sources, &[])?;
    }
    let path = sources.target.join(TARGET).join("release/microslip");
    let program = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
    let linkage = linkage(&program).with_context(|| format!("reading {}", path.display()))?;
    Ok((program, linkage))
}

fn compile(sources: &Sources, more: &[&str]) -> Result<()> {
    let build = format!("cargo build --locked --release --package microslip --target {TARGET}");
    let mut command = process::command(&build, &sources.root);
    output(reproducible(&mut command, sources, more)?).map(drop)
}

/// A command that compiles without a trace of folders and clocks of this computer.
fn reproducible<'c>(command: &'c mut Command, sources: &Sources, more: &[&str]) -> Result<&'c mut Command> {
    let compiler = |words: &str| output(&mut process::command(words, &sources.root));
    let version = compiler("rustc -vV")?;
    let hash = version.lines().find_map(|line| line.strip_prefix("commit-hash: "));
    let library = Path::new(compiler("rustc --print sysroot")?.trim()).join("lib/rustlib/src/rust");
    let mut flags: Vec<String> = more.iter().map(ToString::to_string).collect();
    let mut name = |folder: &Path, name: &str| flags.push(format!("--remap-path-prefix={}={name}", folder.display()));
    name(&sources.root, "/microslip");
    name(&sources.target, "/target");
    // As the library that comes with the compiler names its own sources.
    name(&library, &format!("/rustc/{}", hash.unwrap_or("unknown")));
    for folder in sources.downloaded() {
        name(folder, "/packages");
    }
    Ok(command
        .env_remove("RUSTFLAGS")
        // Flags may hold blanks.
        .env("CARGO_ENCODED_RUSTFLAGS", flags.join("\u{1f}"))
        .env("SOURCE_DATE_EPOCH", sources.seconds.to_string()))
}

/// A Python of its own in a folder, with packages; none, with the reason said, where there is no Python or no packages can be had.
///
/// # Errors
/// The reason cannot be said.
pub fn python(folder: &Path, packages: &[&str], say: Say<'_>) -> Result<Option<PathBuf>> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let programs = folder.join("bin");
    let install = || output(pip(&programs).args(packages));
    let made = output(Command::new(python).args(["-m", "venv"]).arg(folder)).and_then(|_| install());
    match made {
        Ok(_) => Ok(Some(programs)),
        Err(why) => say(&format!("skipped: {}: {why:#}\n", packages.join(", "))).map(|()| None),
    }
}

/// The installer of such a Python.
pub fn pip(programs: &Path) -> Command {
    let mut pip = Command::new(programs.join("pip"));
    pip.args(["install", "--quiet"]);
    pip
}

/// The Python package, as a wheel for all versions of Python and as sources; none where maturin cannot be had.
///
/// # Errors
/// It does not compile, or is not what it says.
pub fn python_package(sources: &Sources, scratch: &Path, say: Say<'_>) -> Result<BTreeMap<String, Vec<u8>>> {
    let Some(programs) = python(&scratch.join("maturin"), &["maturin>=1.11,<2"], say)? else {
        return Ok(BTreeMap::new());
    };
    let out = scratch.join("wheels");
    let maturin = |words: &str| {
        let mut command = Command::new(programs.join("maturin"));
        command.args(words.split_whitespace()).current_dir(&sources.root);
        command
            .args(["-m", "crates/microslip-python/Cargo.toml", "-o"])
            .arg(&out);
        output(reproducible(&mut command, sources, &[])?)
    };
    maturin(&format!("build --release --locked --target {TARGET}"))?;
    maturin("sdist")?;
    let mut files = BTreeMap::new();
    for entry in out.read_dir().with_context(|| format!("listing {}", out.display()))? {
        let path = entry.with_context(|| format!("listing {}", out.display()))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.ends_with(".whl") {
            audit(&path, scratch, say)?;
        }
        let contents = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
        files.insert(name, contents);
    }
    Ok(files)
}

/// Whether a wheel asks for no more of system and Python than its name says.
fn audit(wheel: &Path, scratch: &Path, say: Say<'_>) -> Result<()> {
    let Some(programs) = python(&scratch.join("audit"), &["auditwheel", "abi3audit"], say)? else {
        return Ok(());
    };
    let shown = output(Command::new(programs.join("auditwheel")).arg("show").arg(wheel))?;
    output(Command::new(programs.join("abi3audit")).arg("--strict").arg(wheel))?;
    say(&format!(
        "{}\nits calls of Python are those of its stable interface\n",
        shown.trim()
    ))
}

/// Packages every crate that is published and compiles it as others will.
///
/// # Errors
/// One of them could not be published.
pub fn packages(sources: &Sources) -> Result<()> {
    output(&mut process::command(
        "cargo publish --workspace --dry-run --locked",
        &sources.root,
    ))
    .map(drop)
}
