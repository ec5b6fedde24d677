//! JSON Schema of scene files.

use crate::scene::Scene;
use serde_json::Value;

/// JSON Schema of scene files: what [`Scene`] reads, where a benchmark may fill in what the physics depends on.
pub fn file_schema() -> schemars::Schema {
    let mut schema = schemars::schema_for!(Scene);
    let optional = |schema: &mut Value, fields: &[&str]| {
        if let Some(required) = schema.get_mut("required").and_then(Value::as_array_mut) {
            required.retain(|field| !fields.iter().any(|optional| field == optional));
        }
    };
    let value = schema.ensure_object();
    let mut whole = Value::Object(std::mem::take(value));
    optional(&mut whole, &["model", "interfaces", "bolts"]);
    for (definition, fields) in [
        ("Material", &["youngs_modulus", "poisson_ratio"][..]),
        ("Bolts", &["load"]),
        ("Interfaces", &["surface", "mu"]),
    ] {
        if let Some(definition) = whole.pointer_mut(&format!("/$defs/{definition}")) {
            optional(definition, fields);
        }
    }
    if let Value::Object(whole) = whole {
        *schema.ensure_object() = whole;
    }
    schema
}
