//! Proves from Cargo's own data that the dependencies between the crates point one way only.

use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::process::Command;

/// Every crate of the workspace with the crates of the workspace it may use, also for its tests.
const ALLOWED: [(&str, &[&str]); 17] = [
    // For tests alone, see `FOR_TESTS`.
    (FOR_TESTS, &[]),
    // Dense kernels that must not depend on units or threads, shared by all that factorise.
    ("dense-algebra", &[]),
    ("contact-laws", &[]),
    ("contact-laws-c", &["contact-laws"]),
    // Scans come in NumPy files and ZIP archives too.
    ("surface-characterisation", &["contact-laws", "matrix-files"]),
    ("zte-assembly", &["contact-laws"]),
    ("substructure", &["dense-algebra"]),
    // The relative system is built from the assembled one, and the stuck modes use its eigensolver.
    ("reduction", &["dense-algebra", "substructure"]),
    // Formats only: what matrices mean is for those who ask for them.
    ("matrix-files", &[]),
    // It reads signals from files of arrays.
    ("modal-identification", &["matrix-files"]),
    // Forces with memory speak of sticking and count regimes in the words of the laws, which have no dependency themselves.
    ("cqsma-solver", &["contact-laws", "dense-algebra"]),
    ("brake-reuss-beam", &["substructure", "zte-assembly"]),
    (
        "joint-pipeline",
        &[
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "substructure",
            "reduction",
            "cqsma-solver",
            "brake-reuss-beam",
            "matrix-files",
            // Computed motions are identified like measured ones.
            "modal-identification",
        ],
    ),
    // Documents of what the pipeline, the identification and the characterisation give.
    (
        "reports",
        &[
            "joint-pipeline",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "modal-identification",
        ],
    ),
    (
        "studies",
        &[
            "reports",
            "joint-pipeline",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "substructure",
            "cqsma-solver",
            "brake-reuss-beam",
            "matrix-files",
        ],
    ),
    (
        "microslip",
        &[
            "reports",
            "joint-pipeline",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "substructure",
            "matrix-files",
            "modal-identification",
        ],
    ),
    // Arguments in, files out: what is computed is in the libraries. Its tests make scans and read back what was exported.
    ("xtask", &["microslip", "studies", "reports"]),
];

/// The crate that the tests of every crate may use, and nothing else may.
const FOR_TESTS: &str = "test-support";

/// Packages that must not be reached from a crate, except through those named last.
const KEPT_OUT: [(&str, &str, &[&str]); 6] = [
    ("contact-laws", "faer", &[]),
    ("contact-laws", "nalgebra", &[]),
    ("zte-assembly", "faer", &[]),
    ("zte-assembly", "nalgebra", &[]),
    ("surface-characterisation", "faer", &[]),
    ("brake-reuss-beam", "faer", &["substructure"]),
];

/// Crates whose default build needs no other package.
const ALONE: [&str; 1] = ["contact-laws"];

/// Runs the command.
pub(crate) fn run() -> Result<()> {
    let defects = defects(&metadata()?)?;
    if !defects.is_empty() {
        bail!("the layering is broken:\n  {}", defects.join("\n  "));
    }
    microslip::commands::print("the dependencies between the crates are as they should be\n")
}

fn metadata() -> Result<Value> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let ask = |offline: bool| {
        let mut command = Command::new(&cargo);
        command.args([
            "metadata",
            "--format-version",
            "1",
            "--all-features",
            "--manifest-path",
            manifest,
        ]);
        if offline {
            command.arg("--offline");
        }
        command.output().context("running `cargo metadata`")
    };
    let mut output = ask(true)?;
    if !output.status.success() {
        // Packages for other systems may not have been downloaded yet.
        output = ask(false)?;
    }
    if !output.status.success() {
        bail!(
            "`cargo metadata` failed: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    serde_json::from_slice(&output.stdout).context("reading the output of `cargo metadata`")
}

/// All violations, each naming the edge.
fn defects(metadata: &Value) -> Result<Vec<String>> {
    let members: BTreeSet<&str> = list(metadata, "workspace_members")?
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let packages = list(metadata, "packages")?;
    let name_of: BTreeMap<&str, &str> = packages
        .iter()
        .map(|p| Ok((text(p, "id")?, text(p, "name")?)))
        .collect::<Result<_>>()?;
    let workspace: BTreeSet<&str> = members.iter().filter_map(|id| name_of.get(id).copied()).collect();

    let mut defects = Vec::new();
    for package in packages
        .iter()
        .filter(|p| text(p, "id").is_ok_and(|id| members.contains(id)))
    {
        let name = text(package, "name")?;
        let dependencies = list(package, "dependencies")?;
        match ALLOWED.iter().find(|(known, _)| *known == name) {
            None => defects.push(format!("{name}: this crate has no place in the layering yet")),
            Some((_, allowed)) => {
                for dependency in dependencies {
                    let other = text(dependency, "name")?;
                    let in_tests = other == FOR_TESTS && dependency["kind"] == "dev";
                    if workspace.contains(other) && other != name && !in_tests && !allowed.contains(&other) {
                        defects.push(format!("{name} -> {other}: not allowed"));
                    }
                }
            }
        }
        if ALONE.contains(&name) {
            for dependency in dependencies {
                let needed = dependency["optional"] == Value::Bool(false) && dependency["kind"] != "dev";
                if needed {
                    defects.push(format!("{name} -> {}: must be optional", text(dependency, "name")?));
                }
            }
        }
    }
    let edges = edges(metadata, &name_of)?;
    for (from, unwanted, except) in KEPT_OUT {
        if let Some(path) = path(&edges, from, unwanted, except) {
            defects.push(format!("{}: {unwanted} must stay out of {from}", path.join(" -> ")));
        }
    }
    Ok(defects)
}

/// Resolved dependencies by package name, without those of tests.
fn edges<'a>(metadata: &'a Value, name_of: &BTreeMap<&str, &'a str>) -> Result<BTreeMap<&'a str, BTreeSet<&'a str>>> {
    let mut edges: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for node in list(&metadata["resolve"], "nodes")? {
        let name = |id: &str| {
            name_of
                .get(id)
                .copied()
                .with_context(|| format!("unknown package {id}"))
        };
        let targets = edges.entry(name(text(node, "id")?)?).or_default();
        for dependency in list(node, "deps")? {
            if list(dependency, "dep_kinds")?.iter().any(|kind| kind["kind"] != "dev") {
                targets.insert(name(text(dependency, "pkg")?)?);
            }
        }
    }
    Ok(edges)
}

/// Shortest way `from` a package `to` another that does not pass `except`.
fn path<'a>(
    edges: &BTreeMap<&'a str, BTreeSet<&'a str>>,
    from: &'a str,
    to: &str,
    except: &[&str],
) -> Option<Vec<&'a str>> {
    let mut reached_from: BTreeMap<&str, &str> = BTreeMap::new();
    let mut queue = VecDeque::from([from]);
    while let Some(package) = queue.pop_front() {
        if package == to {
            let mut way = vec![package];
            while let Some(&before) = way.last().and_then(|last| reached_from.get(last)) {
                way.push(before);
            }
            way.reverse();
            return Some(way);
        }
        for &next in edges.get(package).into_iter().flatten() {
            if next != from && !except.contains(&next) && !reached_from.contains_key(next) {
                reached_from.insert(next, package);
                queue.push_back(next);
            }
        }
    }
    None
}

fn list<'a>(value: &'a Value, field: &str) -> Result<&'a Vec<Value>> {
    value[field]
        .as_array()
        .with_context(|| format!("`cargo metadata` gives no list `{field}`"))
}

fn text<'a>(value: &'a Value, field: &str) -> Result<&'a str> {
    value[field]
        .as_str()
        .with_context(|| format!("`cargo metadata` gives no text `{field}`"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A workspace as Cargo describes it: `(crate, dependency, kind, optional)`.
    fn workspace(edges: &[(&str, &str, Option<&str>, bool)]) -> Value {
        let members: Vec<&str> = ALLOWED.iter().map(|(name, _)| *name).collect();
        let mut names: BTreeSet<&str> = members.iter().copied().collect();
        names.extend(edges.iter().flat_map(|e| [e.0, e.1]));
        let of = |name: &&str| edges.iter().filter(move |e| e.0 == *name).collect::<Vec<_>>();
        json!({
            "workspace_members": members,
            "packages": names.iter().map(|n| json!({
                "id": n, "name": n,
                "dependencies": of(n).iter().map(|e| json!({ "name": e.1, "kind": e.2, "optional": e.3 }))
                    .collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
            "resolve": { "nodes": names.iter().map(|n| json!({
                "id": n,
                "deps": of(n).iter().map(|e| json!({ "pkg": e.1, "dep_kinds": [{ "kind": e.2 }] })).collect::<Vec<_>>(),
            })).collect::<Vec<_>>() },
        })
    }

    #[test]
    fn the_workspace_itself_is_layered() {
        assert_eq!(defects(&metadata().unwrap()).unwrap(), Vec::<String>::new());
    }

    #[test]
    fn every_forbidden_edge_is_named() {
        let sound = workspace(&[
            ("zte-assembly", "contact-laws", None, false),
            ("contact-laws", "serde", None, true),
            ("contact-laws", "nalgebra", Some("dev"), false),
            ("contact-laws", "test-support", Some("dev"), false),
            ("brake-reuss-beam", "substructure", None, false),
            ("substructure", "faer", None, false),
        ]);
        assert_eq!(defects(&sound).unwrap(), Vec::<String>::new());
        for (edges, expected) in [
            (
                vec![("contact-laws", "zte-assembly", Some("dev"), false)],
                "contact-laws -> zte-assembly: not allowed",
            ),
            (
                vec![("zte-assembly", "test-support", None, false)],
                "zte-assembly -> test-support: not allowed",
            ),
            (
                vec![("contact-laws", "libm", None, false)],
                "contact-laws -> libm: must be optional",
            ),
            (
                vec![
                    ("zte-assembly", "helper", None, false),
                    ("helper", "faer", Some("build"), false),
                ],
                "zte-assembly -> helper -> faer: faer must stay out of zte-assembly",
            ),
            (
                vec![("brake-reuss-beam", "faer", None, false)],
                "brake-reuss-beam -> faer: faer must stay out of brake-reuss-beam",
            ),
        ] {
            assert_eq!(defects(&workspace(&edges)).unwrap(), [expected]);
        }
        let mut unknown = workspace(&[("newcomer", "serde", None, false)]);
        unknown["workspace_members"]
            .as_array_mut()
            .unwrap()
            .push(json!("newcomer"));
        assert_eq!(
            defects(&unknown).unwrap(),
            ["newcomer: this crate has no place in the layering yet"]
        );
    }
}
