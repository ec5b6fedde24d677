//! Fields that scenes had at another place.

use super::json::Refusal;
use serde_json::Value;

/// Where they were and where they are now; what is within another of them comes first.
pub(super) const MOVED: [(&str, &str); 17] = [
    ("/model/deck", "/structure/deck"),
    ("/model/matrices", "/structure/matrices"),
    ("/surface", "/interfaces/surface"),
    ("/gap", "/interfaces/gap"),
    ("/scale", "/interfaces/scale"),
    ("/law", "/interfaces/law"),
    ("/mu", "/interfaces/mu"),
    ("/friction_zones", "/interfaces/friction_zones"),
    ("/points_per_direction", "/interfaces/points_per_direction"),
    ("/cqsma/modes_of_interest", "/analyses/modes/followed"),
    ("/cqsma/mode", "/analyses/modes/followed"),
    ("/cqsma/modes", "/analyses/modes/number"),
    ("/cqsma", "/analyses/backbone"),
    ("/epmc", "/analyses/epmc"),
    ("/forced", "/analyses/forced"),
    ("/sensitivities", "/analyses/sensitivities"),
    ("/bolts/tightening", "/analyses/tightening"),
];

/// Methods beside CQSMA, of which the one by the name of `epmc` is now an analysis of its own.
pub(super) const METHODS: (&str, &str) = ("/methods", "/analyses/backbone/methods");

/// What an interface of a mesh had of its own, in `structure.mesh.interfaces`.
pub(super) const OF_INTERFACES: [&str; 4] = ["surface", "gap", "law", "mu"];

/// Refuses them, with their place.
pub(super) fn refuse(given: &Value) -> Result<(), Refusal> {
    let refused = |old: &str, new: &str| {
        let message = format!("{old} is now {new}; move it there, or let `microslip upgrade FILE` rewrite the file");
        Err(Refusal::of(old, message))
    };
    let dotted = |pointer: &str| pointer[1..].replace('/', ".");
    let moved = MOVED.iter().chain([&METHODS]);
    if let Some((old, new)) = moved.into_iter().find(|(old, _)| given.pointer(old).is_some()) {
        return refused(&dotted(old), &dotted(new));
    }
    let interfaces = given.pointer("/structure/mesh/interfaces").and_then(Value::as_array);
    for (number, interface) in interfaces.into_iter().flatten().enumerate() {
        if let Some(name) = OF_INTERFACES.iter().find(|name| interface.get(name).is_some()) {
            return refused(
                &format!("structure.mesh.interfaces[{number}].{name}"),
                &format!("interfaces.each[{number}].{name}"),
            );
        }
    }
    Ok(())
}

/// The present path of a number of the scene, by its former one.
pub(super) fn path(former: &str) -> Option<String> {
    let pointer = format!("/{}", former.replace('.', "/"));
    if let Some(rest) = pointer.strip_prefix("/structure/mesh/interfaces/") {
        let (_, field) = rest.split_once('/')?;
        let is_own = OF_INTERFACES.iter().any(|own| field.split('/').next() == Some(own));
        return is_own.then(|| format!("interfaces.each.{}", rest.replace('/', ".")));
    }
    let moved = MOVED.iter().find_map(|(old, new)| {
        let rest = pointer.strip_prefix(old)?;
        (rest.is_empty() || rest.starts_with('/')).then(|| format!("{new}{rest}"))
    });
    moved.map(|pointer| pointer[1..].replace('/', "."))
}
