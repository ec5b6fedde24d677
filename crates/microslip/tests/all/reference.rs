//! The pages that list every field of scenes and summaries, made from the doc comments behind their JSON schemas.
//!
//! With `MICROSLIP_WRITE=1` the pages are written instead of compared.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{folder, succeeds};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write;
use std::path::Path;

struct Pages<'s> {
    /// Head of the tables, and what stands for a field that must be there.
    columns: [&'s str; 2],
    definitions: &'s Map<String, Value>,
    /// Definitions that have their section, or will.
    done: BTreeSet<&'s str>,
    /// Those that will, the outer ones first.
    queue: VecDeque<(String, &'s Value)>,
    /// Sections by their paths.
    sections: BTreeMap<String, String>,
}

/// The name of the definition that a schema refers to, alone or beside `null`.
fn referred(schema: &Value) -> Option<&str> {
    let own = schema.get("$ref").and_then(Value::as_str);
    let any = schema.get("anyOf").and_then(Value::as_array);
    let found = own.or_else(|| any?.iter().find_map(|one| one.get("$ref")?.as_str()));
    found?.strip_prefix("#/$defs/")
}

/// A doc comment in one line of Markdown, without links into the program.
fn words(schema: &Value) -> String {
    let text = schema.get("description").and_then(Value::as_str).unwrap_or_default();
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('[') {
        out += before;
        let of_program = after.starts_with('`') || after.contains("](self)") || after.contains("](crate");
        match after.split_once(']').filter(|_| of_program) {
            Some((name, after)) => {
                out += name;
                let target = after.strip_prefix('(').and_then(|target| target.split_once(')'));
                rest = target.map_or(after, |(_, after)| after);
            }
            None => {
                out.push('[');
                rest = after;
            }
        }
    }
    (out + rest).replace('\n', " ").replace('|', "\\|")
}

/// What a field takes, in words.
fn takes(schema: &Value, definitions: &Map<String, Value>) -> String {
    if let Some(value) = schema.get("const") {
        return format!("`{value}`");
    }
    if let Some(name) = referred(schema) {
        return takes_of_definition(&definitions[name], definitions);
    }
    if let Some(items) = schema.get("items") {
        return format!("list of {}", takes(items, definitions));
    }
    match schema.get("type") {
        Some(Value::String(one)) if one == "object" => "block".into(),
        Some(Value::String(one)) => one.replace("string", "text").replace("boolean", "true or false"),
        Some(Value::Array(several)) => {
            let known = several.iter().filter_map(Value::as_str).filter(|one| *one != "null");
            let known = known.collect::<Vec<_>>().join(" or ");
            known
                .replace("number or string", "number or text with unit")
                .replace("string", "text")
        }
        _ => match schema.get("anyOf").and_then(Value::as_array) {
            Some(any) => any
                .iter()
                .map(|one| takes(one, definitions))
                .collect::<Vec<_>>()
                .join(" or "),
            None => "see below".into(),
        },
    }
}

fn takes_of_definition(definition: &Value, definitions: &Map<String, Value>) -> String {
    let one_of = definition.get("oneOf").and_then(Value::as_array);
    let constants: Option<Vec<String>> = one_of.map(|all| {
        all.iter()
            .filter_map(|one| Some(format!("`{}`", one.get("const")?)))
            .collect()
    });
    match (constants, definition.get("enum").and_then(Value::as_array)) {
        (Some(constants), _) if Some(constants.len()) == one_of.map(Vec::len) => constants.join(", "),
        (_, Some(values)) => values
            .iter()
            .map(|value| format!("`{value}`"))
            .collect::<Vec<_>>()
            .join(", "),
        _ if definition.get("properties").is_some() => "block".into(),
        _ => takes(definition, definitions),
    }
}

impl<'s> Pages<'s> {
    fn definition(&self, schema: &'s Value) -> &'s Value {
        referred(schema).map_or(schema, |name| &self.definitions[name])
    }

    /// The table of the fields of a block, whose own blocks come later.
    fn fields(&mut self, path: &str, block: &'s Value, text: &mut String) {
        let Some(fields) = block.get("properties").and_then(Value::as_object) else {
            return;
        };
        let required = block.get("required").and_then(Value::as_array);
        let is_required = |name: &str| required.is_some_and(|all| all.iter().any(|one| one == name));
        let [head, always] = self.columns;
        writeln!(text, "{head}\n|---|---|---|---|").unwrap();
        for (name, field) in fields {
            let default = match field.get("default") {
                _ if is_required(name) => always.to_owned(),
                Some(Value::Object(_)) | None => "-".into(),
                Some(Value::Null) => "none".into(),
                Some(value) => format!("`{value}`"),
            };
            let takes = takes(field, self.definitions);
            writeln!(text, "| `{name}` | {takes} | {default} | {} |", words(field)).unwrap();
            self.later(format!("{path}.{name}"), field);
        }
        text.push('\n');
    }

    /// The section of a block or of a choice.
    fn section(&mut self, path: &str, schema: &'s Value) {
        let definition = self.definition(schema);
        let mut text = String::new();
        if !path.is_empty() {
            writeln!(text, "## `{}`\n\n{}\n", path.trim_start_matches('.'), words(definition)).unwrap();
        }
        self.fields(path, definition, &mut text);
        let choices = ["oneOf", "anyOf"]
            .iter()
            .filter_map(|kind| definition.get(*kind)?.as_array());
        for choice in choices.flatten() {
            let fields = choice.get("properties").and_then(Value::as_object);
            let one = fields
                .filter(|fields| fields.len() == 1)
                .and_then(|fields| fields.iter().next());
            let value = match (one, choice.get("const")) {
                (Some((name, field)), _) => {
                    self.later(format!("{path}.{name}"), field);
                    format!("{{ \"{name}\": .. }}")
                }
                (None, Some(value)) => value.to_string(),
                (None, None) => takes(choice, self.definitions),
            };
            let value = if value.contains('`') {
                value
            } else {
                format!("`{value}`")
            };
            writeln!(text, "- {value}: {}", words(choice)).unwrap();
            if one.is_none() {
                let block = self.definition(choice);
                if block.get("properties").is_some() {
                    text.push('\n');
                    self.fields(path, block, &mut text);
                }
            }
        }
        self.sections.insert(path.to_owned(), text);
    }

    /// Asks for the section of a field that is a block or a choice, unless another field has it.
    fn later(&mut self, path: String, field: &'s Value) {
        if let Some(items) = field.get("items").filter(|items| items.is_object()) {
            return self.later(path + "[]", items);
        }
        if let Some(values) = field.get("additionalProperties").filter(|values| values.is_object()) {
            return self.later(path + ".NAME", values);
        }
        let Some(name) = referred(field) else { return };
        let definition = &self.definitions[name];
        let has_section = ["properties", "oneOf", "anyOf"]
            .iter()
            .any(|kind| definition.get(*kind).is_some());
        if has_section && self.done.insert(name) {
            self.queue.push_back((path, field));
        }
    }
}

const INPUT: ([&str; 2], &str) = (
    ["| field | takes | default | meaning |", "needed"],
    "Lengths, forces and other quantities are numbers in the units of the file, or texts with a unit such as `\"12 kN\"`.",
);

const OUTPUT: ([&str; 2], &str) = (
    ["| field | is | given | meaning |", "always"],
    "Quantities are in the SI units that their meaning names.",
);

fn page(subject: &str, title: &str, (columns, units): ([&str; 2], &str)) -> String {
    let schema: Value = serde_json::from_str(&succeeds(&folder("reference"), &["schema", subject])).unwrap();
    let mut pages = Pages {
        columns,
        definitions: schema["$defs"].as_object().unwrap(),
        done: BTreeSet::new(),
        queue: VecDeque::new(),
        sections: BTreeMap::new(),
    };
    pages.section("", &schema);
    while let Some((path, field)) = pages.queue.pop_front() {
        pages.section(&path, field);
    }
    let mut text = format!(
        "# {title}\n\nMade from the comments in the program by `MICROSLIP_WRITE=1 cargo test --release -p microslip --test all reference::`. {units}\n\n"
    );
    for section in pages.sections.values() {
        text += section;
        text.push('\n');
    }
    while text.contains("\n\n\n") {
        text = text.replace("\n\n\n", "\n\n");
    }
    text.trim_end().to_owned() + "\n"
}

#[test]
fn pages_list_every_field() {
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference");
    for (subject, title, kind) in [
        ("scene", "Every field of a scene", INPUT),
        ("summary", "Every field of `summary.json`", OUTPUT),
        ("plan", "Every field of a plan", INPUT),
    ] {
        let text = page(subject, title, kind);
        let path = reference.join(format!("{subject}.md"));
        if std::env::var_os("MICROSLIP_WRITE").is_some() {
            std::fs::create_dir_all(&reference).unwrap();
            std::fs::write(&path, text).unwrap();
            continue;
        }
        let known = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            known == text,
            "{} is not what the comments say; write it anew with MICROSLIP_WRITE=1",
            path.display()
        );
    }
}
