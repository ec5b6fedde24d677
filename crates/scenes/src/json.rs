//! JSON as scene files have it: with comments, and without names that occur twice.

use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::error::Category;
use serde_json::{Map, Number, Value};
use std::fmt;
use std::io::Read;

/// Why a scene is not understood.
pub(super) struct Refusal {
    /// Field with its path, where it is one that is wrong.
    pub(super) field: Option<String>,
    /// In words, with the field.
    pub(super) message: String,
}

impl Refusal {
    /// Of a field.
    pub(super) fn of(field: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            field: Some(field.into()),
            message: message.into(),
        }
    }
}

impl From<String> for Refusal {
    fn from(message: String) -> Self {
        Self { field: None, message }
    }
}

impl From<&serde_path_to_error::Error<serde_json::Error>> for Refusal {
    fn from(error: &serde_path_to_error::Error<serde_json::Error>) -> Self {
        Self {
            field: error.path().iter().next().map(|_| error.path().to_string()),
            message: in_words(error),
        }
    }
}

/// Parses a scene file; lines and columns in messages are those of the file.
///
/// # Errors
/// What is not JSON, or names a field twice, in words.
pub fn parse(text: &str) -> Result<Value, String> {
    let plain = without_comments(text)?;
    let mut reader = serde_json::Deserializer::from_str(&plain);
    let read = Unique
        .deserialize(&mut reader)
        .and_then(|value| reader.end().map(|()| value));
    read.map_err(|error| located(&plain, &error))
}

/// The text with spaces in the place of comments, so that lines and columns stay.
///
/// # Errors
/// A comment that does not end, in words.
pub fn without_comments(text: &str) -> Result<String, String> {
    let mut plain = String::with_capacity(text.len());
    let mut stripped = json_comments::StripComments::new(text.as_bytes());
    stripped.read_to_string(&mut plain).map_err(|e| e.to_string())?;
    Ok(plain)
}

/// Reads JSON as a type. Messages name the field, its value and the line.
///
/// # Errors
/// What is not JSON or not of the type, in words.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let mut reader = serde_json::Deserializer::from_str(text);
    let read = serde_path_to_error::deserialize(&mut reader);
    let value = read.map_err(|error| match error.inner().classify() {
        Category::Data => in_words(&error),
        Category::Syntax | Category::Eof | Category::Io => located(text, error.inner()),
    })?;
    reader.end().map_err(|error| located(text, &error))?;
    Ok(value)
}

/// Where a text stops being JSON, with what stands there.
fn located(text: &str, error: &serde_json::Error) -> String {
    const SHOWN: usize = 24;
    if text.trim().is_empty() {
        return "the file is empty, and JSON is expected, which begins with `{`".into();
    }
    let (line, column) = (error.line(), error.column());
    let there = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    // Columns count bytes, from one; the byte that cannot be read is the last.
    let mut start = column.saturating_sub(1).min(there.len());
    while !there.is_char_boundary(start) {
        start -= 1;
    }
    let found: String = there[start..].chars().take(SHOWN).collect();
    match (error.classify(), found.is_empty()) {
        (Category::Eof, _) => {
            format!("the file ends too early, at line {line} column {column}; close all brackets, braces and quotes")
        }
        (_, true) => format!("{error}; correct the JSON there"),
        (_, false) => format!(
            "{error}, before `{}`; correct the JSON there: numbers are finite, and texts stand in quotes",
            found.trim_end()
        ),
    }
}

/// The field and what is wrong with it, without names of types in the program.
pub(super) fn in_words(error: &serde_path_to_error::Error<serde_json::Error>) -> String {
    let message = error.inner().to_string();
    let (message, place) = match message.rfind(" at line ") {
        Some(at) => message.split_at(at),
        None => (&message[..], ""),
    };
    let message = match message.rsplit_once(", expected ") {
        Some((found, expected)) => format!("{found}, expected {}", plain(expected)),
        None => message.into(),
    };
    match error.path().iter().next() {
        Some(_) => format!("{}: {message}{place}", error.path()),
        None => format!("{message}{place}"),
    }
}

/// What is expected of a value, for people who write JSON.
fn plain(expected: &str) -> &str {
    match expected {
        "f64" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number that is not negative",
        "i8" | "i16" | "i32" | "i64" => "a whole number",
        "a sequence" => "a list [ ... ]",
        "a map" => "an object { ... }",
        "a string" => "a text in quotes",
        "path string" => "a path in quotes",
        "a boolean" => "true or false",
        other if other.starts_with("struct ") => "an object { ... }",
        other => other,
    }
}

/// Any value; objects with a name that occurs twice are refused, of which a [`Value`] keeps the last.
struct Unique;

impl<'de> DeserializeSeed<'de> for Unique {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Unique {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        let number = Number::from_f64(value).ok_or_else(|| E::custom("a number is not finite"))?;
        Ok(number.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = list.next_element_seed(Unique)? {
            values.push(value);
        }
        Ok(values.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut object: A) -> Result<Value, A::Error> {
        let mut fields = Map::new();
        while let Some(name) = object.next_key::<String>()? {
            if fields.contains_key(&name) {
                return Err(A::Error::custom(format!("duplicate field `{name}`")));
            }
            fields.insert(name, object.next_value_seed(Unique)?);
        }
        Ok(fields.into())
    }
}

#[cfg(test)]
mod tests {
    use super::{parse, read};
    use serde_json::json;
    use std::collections::BTreeMap;

    #[test]
    fn comments_are_spaces_and_names_are_unique() {
        let text = "{ // why\n \"a\": 1e-3, /* and */ \"b\": [true, null, \"// not one\"] }";
        assert_eq!(
            parse(text).unwrap(),
            json!({"a": 1e-3, "b": [true, null, "// not one"]})
        );
        let twice = parse("{\"a\": {\"b\": 1,\n \"b\": 2}}").unwrap_err();
        assert!(
            twice.contains("duplicate field `b`") && twice.contains("line 2"),
            "{twice}"
        );
        assert!(parse("{} {}").is_err());
        assert!(parse("{\"a\": 1e999}").is_err());
    }
    #[test]
    fn messages_say_where_and_what_in_words() {
        let message = parse("{ \"mu\": NaN }").unwrap_err();
        assert!(
            message.contains("line 1 column 9, before `NaN }`; correct") && message.contains("finite"),
            "{message}"
        );
        assert!(parse(" \n").unwrap_err().contains("empty"));
        assert!(parse("{ \"mu\": 1").unwrap_err().contains("ends too early"));
        assert!(
            parse("{ \"a\": \u{e9}\u{1b}[2J }")
                .unwrap_err()
                .contains("before `\u{e9}\u{1b}[2J }`;")
        );
        let lists = |text: &str| read::<BTreeMap<String, Vec<usize>>>(text).unwrap_err();
        assert_eq!(
            lists("{\n \"a\": [1, \"two\"] }"),
            "a[1]: invalid type: string \"two\", expected a whole number that is not negative at line 2 column 15"
        );
        assert!(lists("{ \"a\": 1 }").contains("a: invalid type: integer `1`, expected a list [ ... ]"));
        assert!(lists("{ \"a\": [1 }").contains("before `}`"));
        assert!(lists("[]").starts_with("invalid type: sequence, expected an object { ... }"));
    }
}
