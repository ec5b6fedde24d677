//! Cache, memory and threads of a command.

use super::defaults::Defaults;
use anyhow::{Context, Result};
use host::{free_memory, provenance};
use joints::Options;
use std::path::PathBuf;

/// Where reduced models and finished amplitudes are kept, and how much memory there is for what is computed.
#[derive(clap::Args)]
pub struct Cache {
    /// Folder for reduced models and finished amplitudes, made if missing [default: the one that the help of the program names].
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    cache: Option<PathBuf>,
    /// Neither read nor store reduced models and finished amplitudes.
    #[arg(long)]
    no_cache: bool,
    /// Memory that may be taken, such as 8 or 8GB, or 500MB; what needs more is refused before it is computed [default: what is free, where
    /// the system tells].
    #[arg(long, value_name = "GB", value_parser = bytes)]
    pub(super) memory: Option<u64>,
}

/// A size with its unit as a number of bytes; GB where there is none.
fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let (number, unit) = match (text.strip_suffix("GB"), text.strip_suffix("MB")) {
        (Some(number), _) => (number, 1e9),
        (_, Some(number)) => (number, 1e6),
        _ => (text, 1e9),
    };
    match number.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok((unit * number) as u64),
        _ => Err("give a positive number of GB, such as 8 or 8GB, or of MB, such as 500MB".into()),
    }
}

impl Cache {
    /// Whether it asks for anything.
    pub(super) fn is_given(&self) -> bool {
        self.cache.is_some() || self.no_cache || self.memory.is_some()
    }

    pub(super) fn options(&self, defaults: &Defaults) -> Options {
        let cache = match (self.no_cache, &self.cache) {
            (true, _) => None,
            (false, Some(folder)) => Some(folder.clone()),
            (false, None) => defaults.cache.clone(),
        };
        Options {
            cache,
            build: provenance::commit(),
            memory: self.memory.or_else(free_memory),
        }
    }
}

/// How many threads a command uses.
#[derive(clap::Args)]
pub struct Threads {
    /// Number of threads [default: one per processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Threads {
    /// These, or another number where none is given.
    pub(super) fn or(&self, other: Option<u16>) -> Self {
        Self {
            threads: self.threads.or(other),
        }
    }

    /// Starts them.
    pub(super) fn start(&self) -> Result<()> {
        let Some(threads) = self.threads else {
            return Ok(());
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global()
            .with_context(|| format!("starting {threads} threads"))
    }
}
