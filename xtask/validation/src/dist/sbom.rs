//! The list of the components of the program, in the format CycloneDX.

use super::sources::{Package, Sources};
use serde_json::{Value, json};

/// CycloneDX 1.5.
pub fn cyclonedx(sources: &Sources) -> Value {
    let is_program = |package: &&Package| package.is_own() && package.name == "microslip";
    let (program, others): (Vec<_>, Vec<_>) = sources.packages.iter().partition(is_program);
    let libraries = [
        ("rust-std", &sources.rust, "MIT OR Apache-2.0"),
        ("glibc", &sources.glibc, "LGPL-2.1-or-later"),
    ];
    let mut components: Vec<Value> = others
        .into_iter()
        .map(|package| component(package, "library"))
        .collect();
    let mut dependencies: Vec<Value> = Vec::new();
    for (user, used) in &sources.uses {
        dependencies.push(json!({ "ref": user, "dependsOn": used }));
    }
    for (name, version, licence) in libraries {
        let purl = format!("pkg:generic/{name}@{version}");
        dependencies.push(json!({ "ref": purl }));
        components.push(json!({
            "type": "library", "bom-ref": purl, "purl": purl, "name": name, "version": version,
            "licenses": [{ "expression": licence }],
        }));
    }
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "timestamp": sources.date,
            "component": program.first().map(|program| component(program, "application")),
        },
        "components": components,
        "dependencies": dependencies,
    })
}

fn component(package: &Package, kind: &str) -> Value {
    let mut component = json!({
        "type": kind,
        "bom-ref": package.purl(),
        "purl": package.purl(),
        "name": package.name,
        "version": package.version,
    });
    if let Some(licence) = package.licence() {
        component["licenses"] = json!([{ "expression": licence }]);
    }
    if let Some(checksum) = &package.checksum {
        component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
    }
    if let Some(repository) = &package.repository {
        component["externalReferences"] = json!([{ "type": "vcs", "url": repository }]);
    }
    component
}
