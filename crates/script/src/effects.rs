//! What rules did besides giving a result: reported a fault, printed, marked a place. What had none of these can be kept
//! and used again in place of another call.

use geom::Vec2;
use std::cell::Cell;

thread_local! {
    static EFFECTS: Cell<u64> = const { Cell::new(0) };
    /// Where the rule is asked that runs on this thread.
    static PLACE: Cell<Option<Vec2>> = const { Cell::new(None) };
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

/// While it lives a rule is asked about something at a place.
pub(crate) struct AskedAt(Option<Vec2>);

impl AskedAt {
    /// From now on.
    pub fn place(at: Vec2) -> Self {
        Self(PLACE.replace(Some(at)))
    }
}

impl Drop for AskedAt {
    fn drop(&mut self) {
        PLACE.set(self.0);
    }
}

/// Where the rule is asked that runs on this thread, metres; nowhere for one that decides once for a whole city.
pub(crate) fn place() -> Option<Vec2> {
    PLACE.get()
}
