//! Benchmarks that scenes name.

use crate::scoped;
use joint_model::benchmark::{Benchmark, Benchmarks};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cell::RefCell;
use std::fmt;

/// A benchmark that a scene names.
#[derive(Clone, Copy)]
pub struct BenchmarkRef(pub &'static dyn Benchmark);

impl std::ops::Deref for BenchmarkRef {
    type Target = dyn Benchmark;

    fn deref(&self) -> &Self::Target {
        self.0
    }
}

impl fmt::Debug for BenchmarkRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl PartialEq for BenchmarkRef {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for BenchmarkRef {}

impl Serialize for BenchmarkRef {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for BenchmarkRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        KNOWN
            .with_borrow(|known| find(&name, known))
            .map(Self)
            .map_err(serde::de::Error::custom)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for BenchmarkRef {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Benchmark".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "description": "Name of a benchmark structure." })
    }
}

/// The benchmark of a name among `known`.
///
/// # Errors
/// A name that none of them has, in words.
pub fn find(name: &str, known: Benchmarks<'_>) -> Result<&'static dyn Benchmark, String> {
    known
        .iter()
        .find(|benchmark| benchmark.name() == name)
        .copied()
        .ok_or_else(|| {
            let names: Vec<&str> = known.iter().map(|benchmark| benchmark.name()).collect();
            match names.as_slice() {
                [] => format!("there is no benchmark `{name}`; this program knows none"),
                _ => format!("there is no benchmark `{name}`; there are {}", names.join(", ")),
            }
        })
}

thread_local! {
    /// Benchmarks that names are looked up in.
    static KNOWN: RefCell<Vec<&'static dyn Benchmark>> = const { RefCell::new(Vec::new()) };
}

/// Runs `read` with names looked up in `known`.
pub fn scope<T>(known: Benchmarks<'_>, read: impl FnOnce() -> T) -> T {
    scoped::with(&KNOWN, known.to_vec(), read)
}
