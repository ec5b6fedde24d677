//! Clocks and memory of the process, as the program has them.

use joints::progress::Progress;
use std::collections::BTreeMap;

/// What measures the stages of a run and the memory of this process.
pub struct Instruments<'a> {
    /// Receives the progress.
    pub progress: &'a dyn Progress,
    /// Ends the display and gives the seconds of every stage, by name.
    pub stages: Box<dyn Fn() -> BTreeMap<String, f64> + 'a>,
    /// Largest resident memory so far (bytes), where the system tells.
    pub peak_memory: fn() -> Option<u64>,
    /// Makes `peak_memory` count from now on; false where the system cannot.
    pub forget_peak_memory: fn() -> bool,
}
