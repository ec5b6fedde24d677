//! What long work may take.

use std::fmt;

/// What long work may take: by default all the time and memory it needs. Work that is stopped, or would need more memory, ends in an error or
/// a status and leaves nothing half done.
#[derive(Clone, Copy, Default)]
pub struct Limits<'a> {
    stop: Option<&'a (dyn Fn() -> bool + Sync)>,
    memory: Option<u64>,
}

impl<'a> Limits<'a> {
    /// The same work, which asks at its natural boundaries, from any of its threads, whether to end early.
    #[must_use]
    pub fn until(self, stop: &'a (dyn Fn() -> bool + Sync)) -> Self {
        let stop = Some(stop);
        Self { stop, ..self }
    }

    /// The same work within so much memory (bytes), if it is limited.
    #[must_use]
    pub fn within(self, memory: Option<u64>) -> Self {
        Self { memory, ..self }
    }

    /// Whether to end now.
    pub fn stops(&self) -> bool {
        self.stop.is_some_and(|stop| stop())
    }

    /// Memory that the work may take (bytes), if it is limited.
    pub fn memory(&self) -> Option<u64> {
        self.memory
    }
}

impl fmt::Debug for Limits<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Limits")
            .field("memory", &self.memory)
            .finish_non_exhaustive()
    }
}
