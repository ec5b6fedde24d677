//! Scene files rewritten with their comments: those of former layouts, and those of which values change.

use super::former::{METHODS, MOVED, OF_INTERFACES, path};
use super::json::{parse, without_comments};
use serde_json::Value;

/// A value with the comments about it.
struct Member {
    /// Comments above.
    before: String,
    /// Its name; empty in lists.
    name: String,
    value: Node,
    /// Comment behind it on its line.
    after: String,
}

enum Node {
    /// As the file has it.
    Text(String),
    Object(Vec<Member>),
    List(Vec<Member>),
}

/// The text of a scene, or of a plan with a scene in it, in the present layout; none if it has that already.
///
/// # Errors
/// What is not JSON, in words.
pub fn upgraded(text: &str) -> Result<Option<String>, String> {
    let (begin, mut root, end) = opened(text)?;
    let is_moved = match root.at("scene").is_some_and(|scene| scene.opened().is_object()) {
        false => scene(&mut root),
        true => {
            let parts = ["parameters", "cases"].map(|name| root.at(name).is_some_and(rename_strings));
            root.at("scene").is_some_and(scene) | parts.contains(&true)
        }
    };
    Ok(is_moved.then(|| format!("{begin}{}{end}", root.written(0))))
}

/// The text of a scene with other values, where it has comments and order of its own: what has the value already stays as it is written.
///
/// # Errors
/// What is not JSON, in words.
pub fn rewritten(text: &str, wanted: &Value) -> Result<String, String> {
    let (begin, mut root, end) = opened(text)?;
    root.become_value(wanted);
    Ok(format!("{begin}{}{end}", root.written(0)))
}

/// What stands before the object of a text, the object and what stands behind it.
fn opened(text: &str) -> Result<(&str, Node, &str), String> {
    parse(text)?;
    let plain = without_comments(text)?;
    let begin = plain.find('{').ok_or("an object { ... } is expected")?;
    let end = plain.rfind('}').map_or(plain.len(), |end| end + 1);
    Ok((&text[..begin], Node::Text(text[begin..end].into()), &text[end..]))
}

/// Moves the fields of a scene; whether there were any to move.
fn scene(root: &mut Node) -> bool {
    let mut is_moved = false;
    let had_loops = root.at("cqsma").is_some();
    let had_analyses = root.at("analyses").is_some();
    for name in ["sensitivities", "uncertain"] {
        is_moved |= root.at(name).is_some_and(rename_strings);
    }
    if let Some(mut methods) = root.take(METHODS.0) {
        let text = methods.value.written(0);
        let names: Vec<String> = serde_json::from_str(&without_comments(&text).unwrap_or(text)).unwrap_or_default();
        let (epmc, others): (Vec<_>, Vec<_>) = names.into_iter().partition(|name| name == super::EPMC);
        if !epmc.is_empty() && root.at("epmc").is_none() {
            root.put("/analyses/epmc", Member::plain("{}"));
        }
        if !others.is_empty() {
            methods.value = Node::Text(serde_json::json!(others).to_string());
            root.put("/cqsma/methods", methods);
        }
        is_moved = true;
    }
    for (old, new) in MOVED {
        let Some(mut member) = root.take(old) else { continue };
        if old == "/cqsma/mode" {
            member.value = Node::Text(format!("[{}]", member.value.written(0)));
        }
        is_moved = true;
        root.put(new, member);
    }
    is_moved |= own_interfaces(root);
    if is_moved && !had_analyses && !had_loops && root.at("analyses").is_some() {
        let analyses = root.at("analyses");
        if analyses.is_some_and(|analyses| analyses.at("backbone").is_none()) {
            root.put("/analyses/backbone", Member::plain("{}"));
        }
    }
    is_moved
}

/// Moves what interfaces of a mesh have of their own.
fn own_interfaces(root: &mut Node) -> bool {
    let list = root
        .at("structure")
        .and_then(|structure| structure.at("mesh")?.at("interfaces"));
    let Some(Node::List(interfaces)) = list.map(Node::opened) else {
        return false;
    };
    let own = interfaces.iter_mut().map(|interface| {
        let taken = OF_INTERFACES.map(|name| interface.value.take(&format!("/{name}")));
        Member {
            value: Node::Object(taken.into_iter().flatten().collect()),
            ..Member::plain("")
        }
    });
    let own: Vec<Member> = own.collect();
    let is_moved = own
        .iter()
        .any(|own| matches!(&own.value, Node::Object(fields) if !fields.is_empty()));
    if is_moved {
        let value = Node::List(own);
        root.put(
            "/interfaces/each",
            Member {
                value,
                ..Member::plain("")
            },
        );
    }
    is_moved
}

/// Gives paths and pointers their present form, whose former one stands in quotes.
fn rename_strings(node: &mut Node) -> bool {
    let text = node.written(0);
    let plain = without_comments(&text).unwrap_or_else(|_| text.clone());
    let quotes: Vec<usize> = plain.match_indices('"').map(|(place, _)| place).collect();
    let (mut renamed, mut done, mut is_moved) = (String::new(), 0, false);
    for quoted in quotes.chunks_exact(2) {
        let former = &plain[quoted[0] + 1..quoted[1]];
        let present = match former.strip_prefix('/') {
            Some(pointer) => path(&pointer.replace('/', ".")).map(|path| format!("/{}", path.replace('.', "/"))),
            None => path(former),
        };
        if let Some(present) = present {
            renamed += &text[done..=quoted[0]];
            renamed += &present;
            (done, is_moved) = (quoted[1], true);
        }
    }
    *node = Node::Text(renamed + &text[done..]);
    is_moved
}

/// A name as it stands between its quotes.
fn escaped(name: &str) -> String {
    let quoted = Value::from(name).to_string();
    quoted[1..quoted.len() - 1].to_owned()
}

/// Whether two values are the same, however their numbers are written.
fn is_same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(name, a)| b.get(name).is_some_and(|b| is_same(a, b)))
        }
        _ => a == b,
    }
}

impl Member {
    /// A value without a name.
    fn of(value: &Value) -> Self {
        Self::plain(&serde_json::to_string_pretty(value).unwrap_or_default())
    }

    /// Without a name and comments.
    fn plain(value: &str) -> Self {
        Self {
            before: String::new(),
            name: String::new(),
            value: Node::Text(value.into()),
            after: String::new(),
        }
    }
}

impl Node {
    fn is_object(&self) -> bool {
        matches!(self, Self::Object(_))
    }

    /// With its members as such, if it has any.
    fn opened(&mut self) -> &mut Self {
        if let Self::Text(text) = self {
            match text.as_bytes().first() {
                Some(b'{') => *self = Self::Object(members(text)),
                Some(b'[') => *self = Self::List(members(text)),
                _ => {}
            }
        }
        self
    }

    /// The value of this name.
    fn at(&mut self, name: &str) -> Option<&mut Self> {
        match self.opened() {
            Self::Object(members) => members
                .iter_mut()
                .find(|one| one.name == name)
                .map(|one| &mut one.value),
            _ => None,
        }
    }

    /// Takes on a value, with the members and comments of what stays.
    fn become_value(&mut self, wanted: &Value) {
        let written = || serde_json::to_string_pretty(wanted).unwrap_or_default();
        if parse(&self.written(0)).is_ok_and(|own| is_same(&own, wanted)) {
            return;
        }
        match (self.opened(), wanted) {
            (Self::Object(members), Value::Object(wanted)) => {
                members.retain(|one| wanted.keys().any(|name| escaped(name) == one.name));
                for (name, value) in wanted {
                    let name = escaped(name);
                    match members.iter_mut().find(|one| one.name == name) {
                        Some(one) => one.value.become_value(value),
                        None => members.push(Member {
                            name,
                            ..Member::of(value)
                        }),
                    }
                }
            }
            (Self::List(members), Value::Array(wanted)) => {
                members.truncate(wanted.len());
                for (one, value) in members.iter_mut().zip(wanted) {
                    one.value.become_value(value);
                }
                members.extend(wanted[members.len()..].iter().map(Member::of));
            }
            (node, _) => *node = Self::Text(written()),
        }
    }

    /// Takes out what a pointer names.
    fn take(&mut self, pointer: &str) -> Option<Member> {
        let (blocks, name) = pointer.rsplit_once('/')?;
        let block = blocks.split('/').skip(1).try_fold(self, |node, block| node.at(block))?;
        let Self::Object(members) = block.opened() else {
            return None;
        };
        let place = members.iter().position(|one| one.name == name)?;
        Some(members.remove(place))
    }

    /// Puts a member where a pointer says, into blocks that are made for it.
    fn put(&mut self, pointer: &str, mut member: Member) {
        let mut names = pointer.split('/').skip(1).peekable();
        let mut node = self;
        while let Some(name) = names.next() {
            let Self::Object(members) = node.opened() else { return };
            if names.peek().is_none() {
                member.name = name.into();
                members.push(member);
                return;
            }
            let place = members.iter().position(|one| one.name == name).unwrap_or_else(|| {
                let value = Self::Object(Vec::new());
                let name = name.into();
                members.push(Member {
                    name,
                    value,
                    ..Member::plain("")
                });
                members.len() - 1
            });
            node = &mut members[place].value;
        }
    }

    /// As text, `depth` blocks deep.
    fn written(&self, depth: usize) -> String {
        let (members, [open, close]) = match self {
            Self::Text(text) => return text.clone(),
            Self::Object(members) => (members, ["{", "}"]),
            Self::List(members) => (members, ["[", "]"]),
        };
        if members.is_empty() {
            return format!("{open}{close}");
        }
        let indent = "  ".repeat(depth + 1);
        let mut out = format!("{open}\n");
        for (number, member) in (1..).zip(members) {
            for line in member.before.lines().map(str::trim) {
                out += &format!("{indent}{line}\n");
            }
            let name = match member.name.as_str() {
                "" => String::new(),
                name => format!("\"{name}\": "),
            };
            let comma = if number < members.len() { "," } else { "" };
            let gap = if member.after.is_empty() { "" } else { " " };
            let value = member.value.written(depth + 1);
            out += &format!(
                "{indent}{name}{}{comma}{gap}{}\n",
                indented(&value, &indent),
                member.after
            );
        }
        out + &"  ".repeat(depth) + close
    }
}

/// The lines of a value below its first one, beginning at `indent` and as far within it as they were within one another.
fn indented(value: &str, indent: &str) -> String {
    let width = |line: &str| line.len() - line.trim_start().len();
    let rest = || value.lines().skip(1).filter(|line| !line.trim().is_empty());
    let least = rest().map(width).min().unwrap_or_default();
    let mut lines = value.lines();
    let first = lines.next().unwrap_or_default().to_owned();
    lines.fold(first, |text, line| match line.trim() {
        "" => text + "\n",
        _ => text + "\n" + indent + &line[least.min(width(line))..],
    })
}

/// The members of an object or a list.
fn members(text: &str) -> Vec<Member> {
    let plain = without_comments(text).unwrap_or_else(|_| text.into());
    let inner = 1..plain.len() - 1;
    // Ends of members: commas outside of brackets and quotes.
    let (mut depth, mut quoted, mut escaped) = (0_usize, false, false);
    let mut ends = Vec::new();
    for (place, byte) in plain.bytes().enumerate().take(inner.end).skip(inner.start) {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if quoted => escaped = true,
            b'"' => quoted = !quoted,
            _ if quoted => {}
            b'{' | b'[' => depth += 1,
            b'}' | b']' => depth = depth.saturating_sub(1),
            b',' if depth == 0 => ends.push(place),
            _ => {}
        }
    }
    ends.push(inner.end);
    let mut found = Vec::new();
    let mut begin = inner.start;
    for end in ends {
        let own = &plain[begin..end];
        if own.trim().is_empty() {
            break;
        }
        let first = begin + own.len() - own.trim_start().len();
        let last = begin + own.trim_end().len();
        let (name, value) = match text.starts_with('{') {
            true => named(&text[first..last], &plain[first..last]),
            false => (String::new(), &text[first..last]),
        };
        // What stands behind on the line is about this member.
        let line = text[end..inner.end].find('\n').map_or(inner.end, |at| end + at);
        let rest = (end + 1).min(line);
        let is_comment = plain[rest..line].trim().is_empty();
        let after = match is_comment {
            true => format!("{} {}", text[last..end].trim(), text[rest..line].trim()),
            false => text[last..end].trim().to_owned(),
        };
        found.push(Member {
            before: text[begin..first].trim().into(),
            name,
            value: Node::Text(value.into()),
            after: after.trim().into(),
        });
        begin = if is_comment { line } else { rest };
    }
    found
}

/// Name and value of a member.
fn named<'t>(text: &'t str, plain: &str) -> (String, &'t str) {
    let end = plain[1..].find('"').map_or(plain.len(), |at| at + 1);
    let colon = plain[end..].find(':').map_or(plain.len(), |at| end + at + 1);
    let value = colon + plain[colon..].len() - plain[colon..].trim_start().len();
    (plain[1..end].to_owned(), &text[value..])
}

#[cfg(test)]
mod tests {
    use super::{rewritten, upgraded};
    use crate::json::parse;
    use serde_json::json;

    const FORMER: &str = r#"// A joint.
{
  "units": { "length": "m", "mass": "kg", "time": "s" },
  "structure": { "mesh": {
    "path": "a.msh",
    "interfaces": [
      { "top": "A", "bottom": "B", "mu": 0.3 }, // steel
      { "top": "C", "bottom": "D" }
    ],
    "response": { "node": "TIP" }
  } },
  // The faces: "measured".
  "surface": "measured", "gap": "flat",
  "mu": 0.2, // dry
  "law": {
    "friction": "resolved", // single asperities
    "bins": { "gauss": 8 }
  },
  "bolts": { "load": 12e3, "tightening": { "order": [1, 2] } },
  "cqsma": {
    "mode": 2,
    // Few.
    "amplitudes": 8
  },
  "methods": ["rqnma", "epmc"],
  "uncertain": { "parameters": { "mu": { "normal": { "sd": 0.02 } }, "structure.mesh.interfaces.0.mu": {} } },
  "sensitivities": ["mu", "bolts.load", "law.yield.strength"]
  // The end.
}
"#;

    #[test]
    fn a_former_scene_moves_to_its_new_places_with_its_comments() {
        let text = upgraded(FORMER).unwrap().unwrap();
        let own = json!([{ "mu": 0.3 }, {}]);
        assert_eq!(
            parse(&text).unwrap(),
            json!({
                "units": { "length": "m", "mass": "kg", "time": "s" },
                "structure": { "mesh": {
                    "path": "a.msh",
                    "interfaces": [{ "top": "A", "bottom": "B" }, { "top": "C", "bottom": "D" }],
                    "response": { "node": "TIP" }
                } },
                "interfaces": {
                    "surface": "measured", "gap": "flat", "mu": 0.2,
                    "law": { "friction": "resolved", "bins": { "gauss": 8 } },
                    "each": own,
                },
                "bolts": { "load": 12e3 },
                "analyses": {
                    "modes": { "followed": [2] },
                    "backbone": { "amplitudes": 8, "methods": ["rqnma"] },
                    "epmc": {},
                    "tightening": { "order": [1, 2] },
                    "sensitivities": ["interfaces.mu", "bolts.load", "interfaces.law.yield.strength"],
                },
                "uncertain": { "parameters": {
                    "interfaces.mu": { "normal": { "sd": 0.02 } }, "interfaces.each.0.mu": {}
                } },
            }),
            "{text}"
        );
        for comment in [
            "// A joint.\n{\n",
            "// steel\n",
            "    // The faces: \"measured\".\n    \"surface\"",
            "\"mu\": 0.2, // dry\n",
            "\n      \"friction\": \"resolved\", // single asperities\n",
            "// Few.\n",
            "// The end.",
        ] {
            assert!(text.contains(comment), "`{comment}` is not in:\n{text}");
        }
        // Once is enough.
        assert_eq!(upgraded(&text).unwrap(), None);
    }

    #[test]
    fn other_values_leave_the_comments_of_what_stays() {
        let text = r#"// A joint.
{
  "units": { "length": "m", "time": "s" }, // SI
  // Dry.
  "interfaces": { "mu": 2e-1, "gap": "flat" },
  "bolts": [
    { "load": 1.2e4 }, // the first
    { "load": 5.0 }
  ]
}
// The end.
"#;
        let mut wanted = parse(text).unwrap();
        assert_eq!(rewritten(text, &json!(wanted)).unwrap(), text);
        wanted["interfaces"]["mu"] = json!(0.3);
        wanted["interfaces"]["name \"x\""] = json!({ "a": [1] });
        wanted["bolts"] = json!([{ "load": 12000 }, { "load": 7 }, { "load": 9 }]);
        let changed = rewritten(text, &wanted).unwrap();
        assert_eq!(parse(&changed).unwrap()["bolts"][0]["load"].as_f64(), Some(12e3));
        wanted["bolts"][0]["load"] = json!(1.2e4);
        assert_eq!(parse(&changed).unwrap(), wanted, "{changed}");
        for part in [
            "// A joint.\n",
            "\"units\": { \"length\": \"m\", \"time\": \"s\" }, // SI\n",
            "  // Dry.\n  \"interfaces\"",
            "{ \"load\": 1.2e4 }, // the first\n",
            "// The end.",
        ] {
            assert!(changed.contains(part), "`{part}` is not in:\n{changed}");
        }
        let without = rewritten(text, &json!({ "bolts": 1 })).unwrap();
        assert_eq!(without, "// A joint.\n{\n  \"bolts\": 1\n}\n// The end.\n");
    }

    #[test]
    fn a_scene_that_had_loops_by_default_keeps_them() {
        let text = upgraded(r#"{ "mu": 0.1, "forced": { "levels": [1] } }"#)
            .unwrap()
            .unwrap();
        assert_eq!(
            parse(&text).unwrap(),
            json!({ "interfaces": { "mu": 0.1 }, "analyses": { "forced": { "levels": [1] }, "backbone": {} } })
        );
        let text = upgraded(r#"{ "mu": 0.1 }"#).unwrap().unwrap();
        assert_eq!(parse(&text).unwrap(), json!({ "interfaces": { "mu": 0.1 } }));
    }

    #[test]
    fn plans_are_rewritten_with_their_scene() {
        let plan = r#"{ "scene": { "mu": 0.1, "cqsma": {} }, "parameters": { "/mu": { "values": [1] }, "/cqsma/modes": {} },
            "cases": [{ "/gap": "flat", "/bolts/load": 1 }] }"#;
        let text = upgraded(plan).unwrap().unwrap();
        assert_eq!(
            parse(&text).unwrap(),
            json!({
                "scene": { "interfaces": { "mu": 0.1 }, "analyses": { "backbone": {} } },
                "parameters": { "/interfaces/mu": { "values": [1] }, "/analyses/modes/number": {} },
                "cases": [{ "/interfaces/gap": "flat", "/bolts/load": 1 }],
            })
        );
        assert!(upgraded("[1]").is_err() && upgraded("{ mu }").is_err());
    }
}
