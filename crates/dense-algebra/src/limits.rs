//! What long work may take.

use std::fmt;

/// What long work may take, by default all the time and memory it needs, and who hears how far it is. Work that is stopped, or would need more
/// memory, ends in an error or a status and leaves nothing half done.
#[derive(Clone, Copy, Default)]
pub struct Limits<'a> {
    stop: Option<&'a (dyn Fn() -> bool + Sync)>,
    memory: Option<u64>,
    heard: Option<Heard<'a>>,
}

/// Who hears of work that is a part of all.
#[derive(Clone, Copy)]
struct Heard<'a> {
    by: &'a (dyn Fn(f64) + Sync),
    /// What is done before it, and its share.
    before: f64,
    share: f64,
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

    /// The same work, which tells from any of its threads what part of it is done, from 0 to 1.
    #[must_use]
    pub fn heard_by(self, by: &'a (dyn Fn(f64) + Sync)) -> Self {
        let heard = Heard {
            by,
            before: 0.0,
            share: 1.0,
        };
        Self {
            heard: Some(heard),
            ..self
        }
    }

    /// For work that takes the whole from the part `begin` that is done to the part `end`.
    #[must_use]
    pub fn part(self, begin: f64, end: f64) -> Self {
        let part = |heard: Heard<'a>| Heard {
            before: heard.before + heard.share * begin,
            share: heard.share * (end - begin),
            ..heard
        };
        Self {
            heard: self.heard.map(part),
            ..self
        }
    }

    /// For one of `count` equal parts, which follow one another.
    #[must_use]
    pub fn of_part(self, number: usize, count: usize) -> Self {
        let place = |number: usize| number as f64 / count.max(1) as f64;
        self.part(place(number), place(number + 1))
    }

    /// Tells that a part of the work is done, from 0 to 1.
    pub fn done(&self, part: f64) {
        if let Some(heard) = &self.heard {
            (heard.by)(heard.before + heard.share * part.clamp(0.0, 1.0));
        }
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

#[cfg(test)]
mod tests {
    use super::Limits;
    use std::sync::Mutex;

    #[test]
    fn parts_of_parts_are_told_as_parts_of_all() {
        let told = Mutex::new(Vec::new());
        let hear = |done: f64| told.lock().unwrap().push(done);
        let all = Limits::default().heard_by(&hear);
        let second = all.part(0.5, 1.0);
        second.done(0.5);
        second.part(0.0, 0.5).done(0.5);
        second.done(7.0);
        assert_eq!(*told.lock().unwrap(), [0.75, 0.625, 1.0]);
        Limits::default().part(0.5, 1.0).done(0.5);
    }
}
