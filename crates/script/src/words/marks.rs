//! `mark(x, y)`: places that a rule points at while it is being written.

use crate::fault::{Complaint, Refusal};
use crate::host::numeric;
use geom::Vec2;
use rhai::{Dynamic, Engine, FuncRegistration};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use streets::growth::Peak;

/// Most places that a rule may mark.
const MOST: usize = 500;
/// Parts of a metre that places are told apart by.
const PARTS: f64 = 100.0;

/// The places marked so far. Sorted: threads mark in any order. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Marks(Arc<Mutex<BTreeMap<Key, Option<Key>>>>);

/// A place in parts of a metre.
type Key = (i64, i64);

fn key(at: Vec2) -> Key {
    ((at.x * PARTS).round() as i64, (at.y * PARTS).round() as i64)
}

fn place((x, y): Key) -> Vec2 {
    Vec2::new(x as f64, y as f64) / PARTS
}

/// A place that a rule marked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marked {
    /// The place, metres.
    pub place: Vec2,
    /// Where the rule was asked when it did, metres: of several places the first, by x, then y.
    pub asked: Option<Vec2>,
}

impl Marks {
    /// All of them, by x, then y.
    pub fn all(&self) -> Vec<Marked> {
        let marks = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        marks.iter().map(|(at, asked)| Marked { place: place(*at), asked: asked.map(place) }).collect()
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
        let asked = crate::effects::place().map(key);
        let mut marks = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = marks.entry(key(at)).or_insert(asked);
        *known = match (*known, asked) {
            (Some(known), Some(asked)) => Some(known.min(asked)),
            (known, asked) => known.or(asked),
        };
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
