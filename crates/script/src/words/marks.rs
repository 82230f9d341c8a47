//! `mark(x, y)`: places that a rule points at while it is being written.

use crate::fault::{Complaint, Refusal};
use crate::host::numeric;
use geom::Vec2;
use rhai::{Dynamic, Engine, FuncRegistration};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use streets::growth::Peak;

/// Most places that a rule may mark.
const MOST: usize = 500;
/// Parts of a metre that places are told apart by.
const PARTS: f64 = 100.0;

/// The places marked so far. Sorted: threads mark in any order. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Marks(Arc<Mutex<BTreeSet<(i64, i64)>>>);

impl Marks {
    /// All places in metres, by x, then y.
    pub fn all(&self) -> Vec<Vec2> {
        let marks = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        marks.iter().map(|&(x, y)| Vec2::new(x as f64, y as f64) / PARTS).collect()
    }

    /// Forgets them.
    pub fn forget(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    fn take(&self, at: Vec2) -> Result<(), Complaint> {
        if !at.is_finite() || at.abs().max_element() > 1e6 {
            return Err(Complaint::new("a mark cannot lie more than 1000 km away"));
        }
        crate::effects::noted();
        let key = ((at.x * PARTS).round() as i64, (at.y * PARTS).round() as i64);
        let mut marks = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        marks.insert(key);
        // The first in order stay, whatever came first.
        if marks.len() > MOST {
            marks.pop_last();
        }
        Ok(())
    }
}

/// Registers the word, which writes to `marks`.
pub(crate) fn register(engine: &mut Engine, marks: &Marks) {
    let own = marks.clone();
    FuncRegistration::new("mark")
        .with_params_info(["x", "y"])
        .with_comments(["/// Marks a place, in metres, on the map and in the report: for looking at what a rule does."])
        .register_into_engine(engine, move |x: Dynamic, y: Dynamic| {
            Ok::<_, Refusal>(own.take(Vec2::new(numeric("x", &x)?, numeric("y", &y)?))?)
        });
    let own = marks.clone();
    FuncRegistration::new("mark")
        .with_params_info(["peak"])
        .register_into_engine(engine, move |peak: Peak| Ok::<_, Refusal>(own.take(peak.at)?));
}
