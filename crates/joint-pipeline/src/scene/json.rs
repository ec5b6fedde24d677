//! JSON as scene files have it: with comments, and without names that occur twice.

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};
use std::fmt;
use std::io::Read;

/// Parses a scene file; lines and columns in messages are those of the file.
///
/// # Errors
/// What is not JSON, or names a field twice, in words.
pub(super) fn parse(text: &str) -> Result<Value, String> {
    // Comments become spaces.
    let mut plain = String::with_capacity(text.len());
    let mut stripped = json_comments::StripComments::new(text.as_bytes());
    stripped.read_to_string(&mut plain).map_err(|e| e.to_string())?;
    let mut reader = serde_json::Deserializer::from_str(&plain);
    let value = Unique.deserialize(&mut reader).map_err(|e| e.to_string())?;
    reader.end().map_err(|e| e.to_string())?;
    Ok(value)
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
    use super::parse;
    use serde_json::json;

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
}
