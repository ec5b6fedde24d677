//! The sources: their commit, and the packages that are linked into the program.

use super::process::{command, output};
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What the program is built for.
pub const TARGET: &str = "x86_64-unknown-linux-gnu";

/// A package, as `cargo metadata` describes it.
#[derive(Clone, Debug, Deserialize)]
pub struct Package {
    id: String,
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    license: Option<String>,
    license_file: Option<PathBuf>,
    /// Where its sources are developed.
    pub repository: Option<String>,
    manifest_path: PathBuf,
    source: Option<String>,
    /// SHA-256 of its archive; none of a crate of the workspace.
    #[serde(skip)]
    pub checksum: Option<String>,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    target_directory: PathBuf,
    resolve: Value,
}

impl Package {
    /// Whether it is a crate of the workspace.
    pub fn is_own(&self) -> bool {
        self.source.is_none()
    }

    /// Its licence as an SPDX expression; packages of old separate names by strokes.
    pub fn licence(&self) -> Option<String> {
        self.license.as_ref().map(|text| text.replace('/', " OR "))
    }

    /// Its package URL.
    pub fn purl(&self) -> String {
        format!("pkg:cargo/{}@{}", self.name, self.version.replace('+', "%2B"))
    }

    /// The licences and notices in its sources, with the names of their files.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn texts(&self) -> Result<Vec<(String, String)>> {
        const NAMES: [&str; 6] = ["LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE"];
        let folder = self.folder();
        let listing = || format!("listing {}", folder.display());
        let mut found = Vec::new();
        for entry in folder.read_dir().with_context(listing)? {
            let path = entry.with_context(listing)?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let is_named = self.license_file.as_deref() == Some(Path::new(&name));
            if path.is_file() && (is_named || NAMES.iter().any(|known| name.to_uppercase().starts_with(known))) {
                let text = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
                found.push((name, String::from_utf8_lossy(&text).into_owned()));
            }
        }
        found.sort();
        Ok(found)
    }

    fn folder(&self) -> &Path {
        self.manifest_path.parent().unwrap_or(&self.manifest_path)
    }
}

/// A checkout.
#[derive(Debug)]
pub struct Sources {
    /// Its folder.
    pub root: PathBuf,
    /// Cargo's folder for what it builds.
    pub target: PathBuf,
    /// Version of the program.
    pub version: String,
    /// Its commit.
    pub commit: String,
    /// Seconds from 1970 to the commit: the time of all files, so that they are the same whenever they are made.
    pub seconds: u64,
    /// The same as a date.
    pub date: String,
    /// Version of the compiler, and so of the standard library.
    pub rust: String,
    /// Version of the C library.
    pub glibc: String,
    /// The packages that are linked into the program, by name; it is one of them.
    pub packages: Vec<Package>,
    /// Package URLs of those that each uses.
    pub uses: BTreeMap<String, BTreeSet<String>>,
}

impl Sources {
    /// Reads the checkout in a folder.
    ///
    /// # Errors
    /// Git or Cargo fails, or says something unknown.
    pub fn read(root: &Path) -> Result<Self> {
        let root = root
            .canonicalize()
            .with_context(|| format!("finding {}", root.display()))?;
        let ask = |words: &str| output(command(words, &root).env("TZ", "UTC"));
        let log = ask("git log -1 --format=%H%n%ct%n%cd --date=format-local:%Y-%m-%dT%H:%M:%SZ")?;
        let [commit, seconds, date] = log.split_whitespace().collect::<Vec<_>>()[..] else {
            bail!("{}: `git log` says `{log}`", root.display());
        };
        let metadata = ask(&format!(
            "cargo metadata --locked --format-version=1 --filter-platform {TARGET}"
        ))?;
        let metadata: Metadata = serde_json::from_str(&metadata).context("reading what `cargo metadata` printed")?;
        let rust = ask("rustc --version")?;
        // Only texts are made on other systems.
        let glibc = ask("getconf GNU_LIBC_VERSION").unwrap_or_default();
        let second = |text: &str| text.split_whitespace().nth(1).unwrap_or("unknown").to_owned();
        let lock = root.join("Cargo.lock");
        let lock = std::fs::read_to_string(&lock).with_context(|| format!("reading {}", lock.display()))?;
        // `cargo metadata` also has packages that other members ask for, and what only build scripts and macros use.
        let tree = "--edges normal,no-proc-macro --prefix none --package microslip";
        let tree = ask(&format!("cargo tree --locked --target {TARGET} {tree}"))?;
        let target = metadata.target_directory.clone();
        let (packages, uses) = linked(metadata, &tree, &lock);
        let program = packages.iter().find(|package| package.name == "microslip");
        Ok(Self {
            version: program.context("the workspace has no program")?.version.clone(),
            commit: commit.to_owned(),
            seconds: seconds
                .parse()
                .with_context(|| format!("the time of the commit: `{seconds}`"))?,
            date: date.to_owned(),
            rust: second(&rust),
            glibc: second(&glibc),
            target,
            packages,
            uses,
            root,
        })
    }

    /// Refuses files that are not those of the commit.
    ///
    /// # Errors
    /// There are some.
    pub fn ensure_clean(&self) -> Result<()> {
        let changes = output(&mut command("git status --porcelain --untracked-files=no", &self.root))?;
        ensure!(
            changes.is_empty(),
            "what is published must be of a commit; commit or undo these changes first:\n{changes}"
        );
        Ok(())
    }

    /// A file of the checkout.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn file(&self, name: &str) -> Result<String> {
        let path = self.root.join(name);
        std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))
    }

    /// The folders of the sources of other packages.
    pub fn downloaded(&self) -> BTreeSet<&Path> {
        let others = self.packages.iter().filter(|package| !package.is_own());
        others.filter_map(|package| package.folder().parent()).collect()
    }
}

/// The packages that Cargo lists in its tree of the program, and what they use of one another.
fn linked(metadata: Metadata, tree: &str, lock: &str) -> (Vec<Package>, BTreeMap<String, BTreeSet<String>>) {
    let checksums = checksums(lock);
    let listed: BTreeSet<(&str, &str)> = tree.lines().filter_map(name_and_version).collect();
    let mut packages = metadata.packages;
    packages.retain(|package| listed.contains(&(package.name.as_str(), package.version.as_str())));
    packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    for package in &mut packages {
        let checksum = checksums.get(&(package.name.as_str(), package.version.as_str()));
        package.checksum = checksum.map(|checksum| (*checksum).to_owned());
    }
    let purls: BTreeMap<&str, String> = packages.iter().map(|p| (p.id.as_str(), p.purl())).collect();
    let array = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let purl = |id: &Value| id.as_str().and_then(|id| purls.get(id)).cloned();
    let mut uses = BTreeMap::new();
    for node in array(&metadata.resolve["nodes"]) {
        if let Some(user) = purl(&node["id"]) {
            let mut edges = array(&node["deps"]);
            // The others are of build scripts and tests.
            edges.retain(|edge| array(&edge["dep_kinds"]).iter().any(|kind| kind["kind"].is_null()));
            uses.insert(user, edges.iter().filter_map(|edge| purl(&edge["pkg"])).collect());
        }
    }
    (packages, uses)
}

/// Of a line such as `serde v1.0.228`.
fn name_and_version(line: &str) -> Option<(&str, &str)> {
    let (name, rest) = line.split_once(" v")?;
    Some((name, rest.split(' ').next()?))
}

/// Checksums in a `Cargo.lock`, by name and version.
fn checksums<'l>(lock: &'l str) -> BTreeMap<(&'l str, &'l str), &'l str> {
    let of = |package: &'l str| {
        let mut fields = package.lines().filter_map(|line| line.split_once(" = "));
        let mut field = |name: &str| Some(fields.find(|(key, _)| *key == name)?.1.trim_matches('"'));
        // In the order of the file.
        Some(((field("name")?, field("version")?), field("checksum")?))
    };
    lock.split("[[package]]").filter_map(of).collect()
}
