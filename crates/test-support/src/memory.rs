//! Memory in use and blocks allocated, for tests that bound them.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The system's allocator with a count of the bytes in use, and one of the blocks that each thread allocated.
///
/// A test that asks for [`peak`] or [`blocks`] installs it: `#[global_allocator] static ALLOCATOR: Counting = Counting;`.
pub struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    static BLOCKS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: the system's allocator does the work.
#[expect(unsafe_code, reason = "allocators are unsafe to implement")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let in_use = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(in_use, Ordering::Relaxed);
        BLOCKS.set(BLOCKS.get() + 1);
        // SAFETY: passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: passed on.
        unsafe { System.dealloc(block, layout) }
    }
}

/// What `run` returns, and the most bytes in use meanwhile beyond those before. Other threads count too: a test file that
/// uses this has one test.
///
/// # Panics
/// If [`Counting`] is not the allocator.
pub fn peak<T>(run: impl FnOnce() -> T) -> (T, usize) {
    let before = IN_USE.load(Ordering::Relaxed);
    assert!(before > 0, "the counting allocator is not installed");
    PEAK.store(before, Ordering::Relaxed);
    let result = run();
    (result, PEAK.load(Ordering::Relaxed) - before)
}

/// What `run` returns, and the blocks that this thread allocated meanwhile. The thread of the test harness allocates when it likes, and is not
/// counted.
///
/// # Panics
/// If [`Counting`] is not the allocator.
pub fn blocks<T>(run: impl FnOnce() -> T) -> (T, usize) {
    assert!(
        IN_USE.load(Ordering::Relaxed) > 0,
        "the counting allocator is not installed"
    );
    let before = BLOCKS.get();
    let result = run();
    (result, BLOCKS.get() - before)
}
