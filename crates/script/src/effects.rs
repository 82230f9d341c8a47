//! What rules did besides giving a result: reported a fault, printed, marked a place. What had none of these can be kept
//! and used again in place of another call.

use std::cell::Cell;

thread_local! {
    static EFFECTS: Cell<u64> = const { Cell::new(0) };
}

/// Counts one on this thread.
pub(crate) fn noted() {
    EFFECTS.set(EFFECTS.get() + 1);
}

/// Does some work on this thread, and tells whether it came without faults, prints and marks. What the work leaves to other
/// threads is not heard.
pub fn heard<T>(work: impl FnOnce() -> T) -> (T, bool) {
    let before = EFFECTS.get();
    let result = work();
    (result, EFFECTS.get() == before)
}
