//! What a script has taken of the operations it may take.
//!
//! Rhai counts as well, but forgets what callbacks took: `list.map(|x| …)` within `list.map(…)` is a handful of operations to
//! it, however long it runs.

use rhai::{Dynamic, Engine};
use std::cell::Cell;

thread_local! {
    /// Operations of the script that runs on this thread.
    static SPENT: Cell<i64> = const { Cell::new(0) };
}

/// While it lives a script runs, which begins with none spent; then the one around it goes on, if there is one: a city
/// script loads rules.
pub(crate) struct Spending {
    around: i64,
}

impl Spending {
    pub fn start() -> Self {
        Self { around: SPENT.replace(0) }
    }

    /// The same for a part of a script that may take so many operations more than the script itself.
    pub fn start_with(further: u64) -> Self {
        Self { around: SPENT.replace(-(further as i64)) }
    }
}

impl Drop for Spending {
    fn drop(&mut self) {
        SPENT.set(self.around);
    }
}

/// Operations spent so far.
pub(super) fn spent() -> i64 {
    SPENT.get()
}

/// Takes operations for what is none to Rhai.
pub(crate) fn spend(operations: u64) {
    SPENT.set(SPENT.get().saturating_add(operations as i64));
}

/// Ends scripts of an engine that have spent all; nothing in a script catches that.
pub(super) fn limit(engine: &mut Engine, operations: u64) {
    engine.on_progress(move |_| {
        spend(1);
        (spent() > operations as i64).then_some(Dynamic::UNIT)
    });
}
