//! Whether a rule ever does anything.

use crate::fault::{Fault, Faults};
use crate::rule::{Rule, RuleKind};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// How often a rule must have been asked in vain before that is told.
const ENOUGH: u32 = 20;

/// Counts how often a rule was asked, until it has done something.
#[derive(Debug, Default)]
pub(super) struct Tally {
    asked: AtomicU32,
    acted: AtomicBool,
}

impl Tally {
    /// Takes in a call: whether it did something, or failed and told so.
    pub fn count(&self, acted: bool) {
        // Nothing is counted once it has: threads would fight over the number.
        if self.acted.load(Ordering::Relaxed) {
            return;
        }
        if acted {
            self.acted.store(true, Ordering::Relaxed);
        } else {
            self.asked.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Whether it was asked, and has done nothing so far.
    pub fn is_in_vain(&self) -> bool {
        !self.acted.load(Ordering::Relaxed) && self.asked.load(Ordering::Relaxed) > 0
    }

    /// Warns when it was asked often and did nothing.
    pub fn warn(&self, rule: &Rule, kind: RuleKind, message: &str, hint: &str, faults: &Faults) {
        if !self.acted.load(Ordering::Relaxed) && self.asked.load(Ordering::Relaxed) >= ENOUGH {
            let fault = Fault::warning(rule.path(), message).with_hint(Some(hint.to_owned()));
            faults.report(rule.at_function(kind, fault));
        }
    }
}
