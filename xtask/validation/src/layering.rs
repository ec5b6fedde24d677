//! Proves from Cargo's own data that the dependencies between the crates point one way only, and those between the files of a crate too.

use crate::modules;
use anyhow::{Context, Result, bail, ensure};
use microslip::commands::print;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;
use std::process::Command;

/// Every crate of the workspace with the crates of the workspace it may use, also for its tests.
const ALLOWED: [(&str, &[&str]); 27] = [
    // For tests alone, see `FOR_TESTS`.
    (FOR_TESTS, &[]),
    // Dense kernels that must not depend on units or threads, shared by all that factorise.
    ("dense-algebra", &[]),
    ("contact-laws", &[]),
    // Files that users name, and files that others trust; whatever they hold.
    ("microslip-file-io", &[]),
    ("contact-laws-c", &["contact-laws"]),
    // Scans come in NumPy files and ZIP archives too.
    (
        "surface-characterisation",
        &["contact-laws", "microslip-file-io", "matrix-files"],
    ),
    ("zte-assembly", &["contact-laws"]),
    ("finite-elements", &["dense-algebra", "microslip-file-io"]),
    // The relative system is built from the assembled one, and the stuck modes use its eigensolver.
    ("reduction", &["dense-algebra", "finite-elements"]),
    // Formats only: what matrices mean is for those who ask for them.
    ("matrix-files", &["microslip-file-io"]),
    // It reads signals from files of arrays.
    ("modal-identification", &["microslip-file-io", "matrix-files"]),
    // Forces with memory speak of sticking and count regimes in the words of the laws, which have no dependency themselves.
    ("cqsma-solver", &["contact-laws", "dense-algebra"]),
    // It linearises nothing itself: static state, stuck structure and modes are those of the quasi-static solver.
    ("harmonic-balance", &["contact-laws", "cqsma-solver", "dense-algebra"]),
    // Loops of the quasi-static solver on an interface of which some points stand for all.
    (
        "hyper-reduction",
        &["contact-laws", "cqsma-solver", "dense-algebra", "zte-assembly"],
    ),
    // What is modelled, before contact; the seam of benchmarks.
    ("joint-model", &["finite-elements", "reduction", "zte-assembly"]),
    // Meshes and the text of scenes, for `new` and for tests.
    ("bolted-structures", &["finite-elements"]),
    ("brake-reuss-beam", &["joint-model", "finite-elements", "zte-assembly"]),
    // Types with their checks; of the crates below it has settings alone.
    (
        "scenes",
        &[
            "joint-model",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "finite-elements",
            "cqsma-solver",
            "microslip-file-io",
        ],
    ),
    (
        "microslip-joints",
        &[
            "scenes",
            "joint-model",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "finite-elements",
            "reduction",
            // Its interface is the force that both solvers see.
            "cqsma-solver",
            "harmonic-balance",
            "matrix-files",
            "microslip-file-io",
            // What is stored is keyed by the arithmetic of the processor.
            "dense-algebra",
        ],
    ),
    (
        "analyses",
        &[
            "bolted-structures",
            "microslip-joints",
            "scenes",
            "joint-model",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "finite-elements",
            "reduction",
            "cqsma-solver",
            "harmonic-balance",
            "hyper-reduction",
            "matrix-files",
            // Computed motions are identified like measured ones.
            "modal-identification",
            "microslip-file-io",
            "dense-algebra",
        ],
    ),
    // Documents of what the analyses, the identification and the characterisation give.
    (
        "reports",
        &[
            "analyses",
            "microslip-joints",
            "scenes",
            "joint-model",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            // It writes the fields of the interface.
            "finite-elements",
            // It writes arrays of periodic motions.
            "matrix-files",
            "modal-identification",
            "microslip-file-io",
        ],
    ),
    // Many scenes, and the tables and pictures of them.
    (
        "parameter-studies",
        &[
            "analyses",
            "microslip-joints",
            "scenes",
            "joint-model",
            "reports",
            "microslip-file-io",
        ],
    ),
    // What programs share and libraries do without: clock, commit, folders of the user, and the benchmarks that scenes may name.
    (
        "microslip-host",
        &[
            "analyses",
            "microslip-joints",
            "scenes",
            "joint-model",
            "brake-reuss-beam",
            "microslip-file-io",
        ],
    ),
    (
        "microslip",
        &[
            "bolted-structures",
            "reports",
            "parameter-studies",
            "analyses",
            "microslip-joints",
            "scenes",
            "joint-model",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "finite-elements",
            // What it shares with the Python package.
            "microslip-host",
            "microslip-file-io",
            "matrix-files",
            "modal-identification",
        ],
    ),
    // For Python users; it hands out what the crates below offer.
    (
        "microslip-python",
        &[
            "microslip-host",
            "reports",
            "analyses",
            "microslip-joints",
            "scenes",
            "joint-model",
            "contact-laws",
            "cqsma-solver",
            "dense-algebra",
            "microslip-file-io",
            "matrix-files",
            "modal-identification",
            "harmonic-balance",
            "reduction",
            "finite-elements",
            "surface-characterisation",
            "zte-assembly",
        ],
    ),
    // Arguments in, files out: what is computed is in the libraries. Its scenes are on the beam unless they say otherwise.
    ("xtask", &["microslip", "reports", "brake-reuss-beam"]),
    // A program of its own, so that `cargo xtask brb` need not compile it.
    (
        "validation",
        &[
            "xtask",
            "microslip",
            "microslip-host",
            "reports",
            "analyses",
            "microslip-joints",
            "scenes",
            "joint-model",
            "contact-laws",
            "surface-characterisation",
            "zte-assembly",
            "finite-elements",
            "cqsma-solver",
            "harmonic-balance",
            "brake-reuss-beam",
            "matrix-files",
            // Finished scenes are stored like reduced models.
            "microslip-file-io",
        ],
    ),
];

/// The crate that the tests of every crate may use, and nothing else may.
const FOR_TESTS: &str = "test-support";

/// Further edges that only tests may have.
const IN_TESTS: [(&str, &str); 5] = [
    // The analyses know no benchmark; their tests run scenes on one.
    ("analyses", "brake-reuss-beam"),
    ("parameter-studies", "brake-reuss-beam"),
    // A benchmark knows no scenes; its tests read and run its own.
    ("brake-reuss-beam", "scenes"),
    ("brake-reuss-beam", "microslip-joints"),
    ("brake-reuss-beam", "analyses"),
];

/// Packages that must not be reached from a crate, except through those named last.
const KEPT_OUT: [(&str, &str, &[&str]); 6] = [
    ("contact-laws", "faer", &[]),
    ("contact-laws", "nalgebra", &[]),
    ("zte-assembly", "faer", &[]),
    ("zte-assembly", "nalgebra", &[]),
    ("surface-characterisation", "faer", &[]),
    ("brake-reuss-beam", "faer", &["joint-model", "finite-elements"]),
];

/// Crates whose default build needs no other package.
const ALONE: [&str; 1] = ["contact-laws"];

/// Checks the workspace.
pub(crate) fn check() -> Result<()> {
    let metadata = metadata()?;
    let mut defects = defects(&metadata)?;
    defects.extend(circles(&metadata)?);
    if !defects.is_empty() {
        bail!("the layering is broken:\n  {}", defects.join("\n  "));
    }
    print("the dependencies between the crates, and between the files of each, point one way only\n")
}

/// What `cargo metadata` says of the workspace and its packages, as far as it matters here.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    workspace_members: BTreeSet<String>,
    resolve: Option<Resolve>,
}

#[derive(Deserialize)]
struct Package {
    id: String,
    name: String,
    manifest_path: PathBuf,
    dependencies: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    name: String,
    kind: Option<String>,
    optional: bool,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<NodeDependency>,
}

#[derive(Deserialize)]
struct NodeDependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

#[derive(Deserialize)]
struct Kind {
    kind: Option<String>,
}

/// Whether a dependency is of tests alone.
fn of_tests(kind: Option<&str>) -> bool {
    kind == Some("dev")
}

fn metadata() -> Result<Metadata> {
    let ask = |more: &[&str]| -> Result<Metadata> {
        let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
            .args(["metadata", "--format-version", "1", "--all-features", "--manifest-path"])
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml"))
            .args(more)
            .output()?;
        ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Ok(serde_json::from_slice(&output.stdout)?)
    };
    // Packages for other systems may not have been downloaded yet.
    ask(&["--locked", "--offline"])
        .or_else(|_| ask(&["--locked"]))
        .context("running `cargo metadata`")
}

/// Files of the members that use one another in a circle.
fn circles(metadata: &Metadata) -> Result<Vec<String>> {
    let mut found = Vec::new();
    for package in metadata
        .packages
        .iter()
        .filter(|p| metadata.workspace_members.contains(&p.id))
    {
        let sources = package.manifest_path.with_file_name("src");
        let own = modules::circles(&sources)?.into_iter();
        found.extend(own.map(|circle| format!("{}: these files use one another in a circle: {circle}", package.name)));
    }
    Ok(found)
}

/// All violations, each naming the edge.
fn defects(metadata: &Metadata) -> Result<Vec<String>> {
    let packages = metadata.packages.iter();
    let members: Vec<&Package> = packages
        .filter(|p| metadata.workspace_members.contains(&p.id))
        .collect();
    let workspace: BTreeSet<&str> = members.iter().map(|package| package.name.as_str()).collect();
    let mut defects = Vec::new();
    for package in members {
        let name = package.name.as_str();
        match ALLOWED.iter().find(|(known, _)| *known == name) {
            None => defects.push(format!("{name}: this crate has no place in the layering yet")),
            Some((_, allowed)) => {
                for dependency in &package.dependencies {
                    let other = dependency.name.as_str();
                    let in_tests = of_tests(dependency.kind.as_deref())
                        && (other == FOR_TESTS || IN_TESTS.contains(&(name, other)));
                    if workspace.contains(other) && other != name && !in_tests && !allowed.contains(&other) {
                        defects.push(format!("{name} -> {other}: not allowed"));
                    }
                }
            }
        }
        if ALONE.contains(&name) {
            for dependency in &package.dependencies {
                if !dependency.optional && !of_tests(dependency.kind.as_deref()) {
                    defects.push(format!("{name} -> {}: must be optional", dependency.name));
                }
            }
        }
    }
    let edges = edges(metadata)?;
    for (from, unwanted, except) in KEPT_OUT {
        if let Some(path) = path(&edges, from, unwanted, except) {
            defects.push(format!("{}: {unwanted} must stay out of {from}", path.join(" -> ")));
        }
    }
    Ok(defects)
}

/// Resolved dependencies by package name, without those of tests.
fn edges(metadata: &Metadata) -> Result<BTreeMap<&str, BTreeSet<&str>>> {
    let names: BTreeMap<&str, &str> = metadata
        .packages
        .iter()
        .map(|p| (p.id.as_str(), p.name.as_str()))
        .collect();
    let name = |id: &str| names.get(id).copied().with_context(|| format!("unknown package {id}"));
    let resolve = metadata
        .resolve
        .as_ref()
        .context("`cargo metadata` resolves no dependencies")?;
    let mut edges: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for node in &resolve.nodes {
        let targets = edges.entry(name(&node.id)?).or_default();
        for dependency in &node.deps {
            let kinds = &dependency.dep_kinds;
            if kinds.iter().any(|info| !of_tests(info.kind.as_deref())) {
                targets.insert(name(&dependency.pkg)?);
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A workspace as Cargo describes it: `(crate, dependency, kind, optional)`; its members are those of the layering and `more`.
    fn workspace(edges: &[(&str, &str, Option<&str>, bool)], more: &[&str]) -> Metadata {
        let members: Vec<&str> = ALLOWED
            .iter()
            .map(|(name, _)| *name)
            .chain(more.iter().copied())
            .collect();
        let mut names: BTreeSet<&str> = members.iter().copied().collect();
        names.extend(edges.iter().flat_map(|e| [e.0, e.1]));
        let of = |name: &&str| edges.iter().filter(move |e| e.0 == *name).collect::<Vec<_>>();
        let described = json!({
            "workspace_members": members,
            "packages": names.iter().map(|n| json!({
                "id": n, "name": n, "manifest_path": "Cargo.toml",
                "dependencies": of(n).iter().map(|e| json!({
                    "name": e.1, "kind": e.2, "optional": e.3,
                })).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
            "resolve": { "nodes": names.iter().map(|n| json!({
                "id": n,
                "deps": of(n).iter().map(|e| json!({ "name": e.1, "pkg": e.1, "dep_kinds": [{ "kind": e.2 }] }))
                    .collect::<Vec<_>>(),
            })).collect::<Vec<_>>() },
        });
        serde_json::from_value(described).unwrap()
    }

    #[test]
    fn the_workspace_itself_is_layered() {
        let metadata = metadata().unwrap();
        assert_eq!(defects(&metadata).unwrap(), Vec::<String>::new());
        assert_eq!(circles(&metadata).unwrap(), Vec::<String>::new());
    }

    #[test]
    fn every_forbidden_edge_is_named() {
        let sound = workspace(
            &[
                ("zte-assembly", "contact-laws", None, false),
                ("contact-laws", "serde", None, true),
                ("contact-laws", "nalgebra", Some("dev"), false),
                ("contact-laws", "test-support", Some("dev"), false),
                ("brake-reuss-beam", "finite-elements", None, false),
                ("finite-elements", "faer", None, false),
            ],
            &[],
        );
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
            assert_eq!(defects(&workspace(&edges, &[])).unwrap(), [expected]);
        }
        let unknown = workspace(&[("newcomer", "serde", None, false)], &["newcomer"]);
        assert_eq!(
            defects(&unknown).unwrap(),
            ["newcomer: this crate has no place in the layering yet"]
        );
    }
}
