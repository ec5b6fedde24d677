//! Values that deserialisation of nested types needs and that serde cannot hand down.

use std::cell::RefCell;
use std::mem;
use std::thread::LocalKey;

/// Runs `f` while `cell` of this thread holds `value`; what it held before comes back afterwards, also after a panic.
pub(crate) fn with<T: Default + 'static, R>(cell: &'static LocalKey<RefCell<T>>, value: T, f: impl FnOnce() -> R) -> R {
    struct Restore<T: Default + 'static>(&'static LocalKey<RefCell<T>>, T);
    impl<T: Default> Drop for Restore<T> {
        fn drop(&mut self) {
            self.0.set(mem::take(&mut self.1));
        }
    }
    let _restore = Restore(cell, cell.replace(value));
    f()
}
