//! Changed JSON documents.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Map, Value, json};

/// Changes documents at random, the same way for the same seed; what comes out is JSON again.
pub struct Changes {
    random: Pcg64Mcg,
}

impl Changes {
    /// Of a seed.
    pub fn new(seed: u64) -> Self {
        Self {
            random: Pcg64Mcg::seed_from_u64(seed),
        }
    }

    /// A copy with one to three changes: values of other sizes, signs, units and types, fields and elements that are missing,
    /// twice there or in the place of others, structs as lists.
    pub fn of(&mut self, document: &Value) -> Value {
        let mut changed = document.clone();
        for _ in 0..self.random.random_range(1..4) {
            let mut pointers = Vec::new();
            collect(&changed, String::new(), &mut pointers);
            let [pointer, from] = [(); 2].map(|()| self.chosen::<String>(&pointers));
            let other = changed.pointer(from).cloned().unwrap_or_default();
            if let Some(value) = changed.pointer_mut(pointer) {
                self.change(value, other);
            }
        }
        changed
    }

    fn chosen<'a, T>(&mut self, values: &'a [T]) -> &'a T {
        &values[self.random.random_range(0..values.len())]
    }

    fn change(&mut self, value: &mut Value, other: Value) {
        match self.random.random_range(0..9) {
            0 => *value = other,
            1 => *value = self.odd(),
            2 => *value = json!([value.take()]),
            _ => match value {
                Value::Number(number) => *value = self.number(number.as_f64().unwrap_or_default()),
                Value::String(text) => *value = self.text(text),
                Value::Array(elements) => self.list(elements, other),
                Value::Object(fields) => {
                    if self.random.random_range(0..4) == 0 {
                        *value = fields.values().cloned().collect();
                    } else {
                        self.fields(fields, other);
                    }
                }
                Value::Bool(_) | Value::Null => *value = self.odd(),
            },
        }
    }

    fn number(&mut self, number: f64) -> Value {
        let factors = [-1.0, 0.0, 0.5, 2.0, 1e-3, 1e3, 1e-9, 1e9, 1e-200, 1e200];
        match self.random.random_range(0..4) {
            0 => json!(number + 1.0),
            1 if number.fract() == 0.0 => json!((number as i64).wrapping_add(self.random.random_range(-3..4))),
            2 => self.odd(),
            _ => json!(number * self.chosen(&factors)),
        }
    }

    fn text(&mut self, text: &str) -> Value {
        let number = text.split(' ').next().unwrap_or_default();
        let cut = text
            .char_indices()
            .nth(text.chars().count() / 2)
            .map_or(0, |(at, _)| at);
        match self.random.random_range(0..5) {
            0 => json!(text[..cut]),
            1 => json!(format!("{text}{text}")),
            2 => json!(format!("-{text}")),
            3 => json!(format!(
                "{number} {}",
                self.chosen(&["mm", "N", "GPa", "1/0", "m^99999", "lbf"])
            )),
            _ => self.odd(),
        }
    }

    fn list(&mut self, elements: &mut Vec<Value>, other: Value) {
        let at = self.random.random_range(0..=elements.len());
        match elements.get(at).cloned() {
            Some(_) if self.random.random_range(0..2) == 0 => drop(elements.remove(at)),
            Some(twice) => elements.push(twice),
            None => elements.push(other),
        }
    }

    fn fields(&mut self, fields: &mut Map<String, Value>, other: Value) {
        let names: Vec<String> = fields.keys().cloned().collect();
        match names.is_empty() {
            false if self.random.random_range(0..4) > 0 => {
                let name = self.chosen(&names).clone();
                fields.remove(&name);
            }
            _ => drop(fields.insert("more".into(), other)),
        }
    }

    /// What is seldom meant.
    fn odd(&mut self) -> Value {
        let values = [
            json!(null),
            json!(true),
            json!({}),
            json!([]),
            json!(""),
            json!("1e999 m"),
            json!("nan"),
            json!(-0.0),
            json!(0),
            json!(-1),
            json!(1),
            json!(65_536),
            json!(u64::MAX),
            json!(i64::MIN),
            json!(f64::MAX),
            json!(f64::MIN_POSITIVE),
            json!(1e-18),
            json!(1e18),
            json!("/"),
            json!([[0, 1, 2]]),
        ];
        self.chosen(&values).clone()
    }
}

/// JSON pointers to all values of a document.
fn collect(value: &Value, pointer: String, pointers: &mut Vec<String>) {
    match value {
        Value::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                collect(element, format!("{pointer}/{index}"), pointers);
            }
        }
        Value::Object(fields) => {
            for (name, field) in fields {
                let name = name.replace('~', "~0").replace('/', "~1");
                collect(field, format!("{pointer}/{name}"), pointers);
            }
        }
        _ => {}
    }
    pointers.push(pointer);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_belong_to_their_seed() {
        let document = json!({ "a": [1, 2.5, { "b/c": "12.8 kN" }], "d": { "e": true, "f": null } });
        let copies = |seed| {
            let mut changes = Changes::new(seed);
            (0..500).map(|_| changes.of(&document)).collect::<Vec<_>>()
        };
        assert_eq!(copies(1), copies(1));
        assert_ne!(copies(1), copies(2));
        let changed = copies(1).iter().filter(|copy| **copy != document).count();
        assert!(changed > 450, "{changed}");
    }
}
