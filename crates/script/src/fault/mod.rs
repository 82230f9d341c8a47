//! What goes wrong in a script: one type for all of it, and a collector that any thread may report to.

mod complaint;
mod convert;
mod foreign;
mod text;

pub(crate) use complaint::{Complaint, Refusal};
pub(crate) use convert::{Diagnosis, function_like, no_method, of_error, of_panic, plain_type};
pub use text::place_in_script;
pub(crate) use text::{column_of, key_position, open_comment};

use crate::host::Texts;
use geom::Vec2;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How bad a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// It did not do what it says.
    Error,
    /// It did, but surely not what was meant.
    Warning,
}

/// A call on the way to a fault.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Call {
    /// The function that was called.
    pub function: String,
    /// Where it was called: the script.
    pub file: String,
    /// The line, from 1; 0 when unknown.
    pub line: u32,
    /// The column, from 1; 0 when unknown.
    pub column: u32,
}

/// Something wrong in a rule or a city script, at its line.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// How bad it is.
    pub severity: Severity,
    /// The script, as its library names it.
    pub file: String,
    /// Line from 1; 0 when the fault concerns the whole file.
    pub line: u32,
    /// Column from 1, counted in characters; 0 when unknown.
    pub column: u32,
    /// Characters of the word it is about; 0 when unknown.
    pub length: u32,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
    /// The calls that led there, the innermost first; none where the fault lies in what was asked itself.
    pub calls: Vec<Call>,
    /// Where in the city it happened, in metres: of several places the least by x, then y.
    pub place: Option<Vec2>,
    /// How often it happened.
    pub count: u64,
}

impl Fault {
    /// A fault of a whole file.
    pub fn new(file: impl Into<String>, message: impl Into<String>) -> Self {
        let (file, message) = (file.into(), message.into());
        let (severity, calls) = (Severity::Error, Vec::new());
        Self { severity, file, line: 0, column: 0, length: 0, message, hint: None, calls, place: None, count: 1 }
    }

    /// What is surely a mistake, but stops nothing.
    pub fn warning(file: impl Into<String>, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::new(file, message) }
    }

    /// The same with its length: that of the word that stands there in the text.
    #[must_use]
    pub(crate) fn measured(mut self, texts: &Texts) -> Self {
        if let Some(text) = texts.get(&self.file) {
            self.length = text::word_length(&text, self.line, self.column);
        }
        self
    }

    /// The same with a hint.
    #[must_use]
    pub fn with_hint(mut self, hint: Option<String>) -> Self {
        self.hint = hint;
        self
    }

    /// The same at a place of the city.
    #[must_use]
    pub fn at(mut self, place: Vec2) -> Self {
        self.place = Some(place);
        self
    }

    /// Takes in another report of the same fault.
    fn merge(&mut self, other: Self) {
        self.count += other.count;
        self.hint = least(self.hint.take(), other.hint, |a, b| a <= b);
        // Of several ways there, the same one whatever came first.
        self.calls = std::mem::take(&mut self.calls).min(other.calls);
        self.place = least(self.place, other.place, |a, b| (a.x, a.y) <= (b.x, b.y));
    }
}

/// The lesser of two values of which either may be missing.
fn least<T>(a: Option<T>, b: Option<T>, in_order: impl Fn(&T, &T) -> bool) -> Option<T> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if in_order(&a, &b) { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// `1 argument`, `2 arguments`.
pub(crate) fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

impl fmt::Display for Fault {
    /// `file:line:column: message`, then how often and where, and a line with the hint.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if self.line > 0 {
            write!(f, ":{}:{}", self.line, self.column)?;
        }
        let warning = if self.severity == Severity::Warning { "warning: " } else { "" };
        write!(f, ": {warning}{}", self.message)?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)?;
        }
        if let Some(place) = self.place {
            write!(f, " at ({:.0}, {:.0})", place.x, place.y)?;
        }
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, "\n  hint: {hint}"))
    }
}

impl std::error::Error for Fault {}

/// File, line, column, message: what makes two faults equal.
type Key = (String, u32, u32, String);

/// How many different faults are kept: the first in order, whatever the order of arrival.
const MOST_FAULTS: usize = 1000;

/// Collects faults from any number of threads. Equal ones (file, line, column, message) become one with a count; what
/// comes out depends on what was reported only, not on the order.
#[derive(Debug, Default)]
pub struct Faults(Mutex<BTreeMap<Key, Fault>>);

impl Faults {
    /// Takes a fault in.
    pub fn report(&self, fault: Fault) {
        crate::effects::noted();
        let key = (fault.file.clone(), fault.line, fault.column, fault.message.clone());
        let mut known = self.lock();
        match known.entry(key) {
            std::collections::btree_map::Entry::Occupied(mut same) => same.get_mut().merge(fault),
            std::collections::btree_map::Entry::Vacant(new) => {
                new.insert(fault);
            }
        }
        if known.len() > MOST_FAULTS {
            known.pop_last();
        }
    }

    /// All faults by file, line, column, message.
    pub fn sorted(&self) -> Vec<Fault> {
        self.lock().values().cloned().collect()
    }

    /// Whether nothing went wrong.
    pub fn is_empty(&self) -> bool {
        self.lock().is_empty()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<Key, Fault>> {
        // A thread that panicked while it held the lock left whole entries behind.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(line: u32, x: f64) -> Fault {
        Fault { line, column: 2, ..Fault::new("a.rhai", "no") }.at(Vec2::new(x, 0.0))
    }

    #[test]
    fn equal_faults_merge_in_any_order() {
        let (one, other) = (Faults::default(), Faults::default());
        let reports = [fault(3, 5.0), fault(1, 9.0), fault(3, -2.0), fault(3, 7.0)];
        reports.iter().for_each(|f| one.report(f.clone()));
        reports.iter().rev().for_each(|f| other.report(f.clone()));
        assert_eq!(one.sorted(), other.sorted());
        let sorted = one.sorted();
        assert_eq!(sorted.iter().map(|f| (f.line, f.count)).collect::<Vec<_>>(), [(1, 1), (3, 3)]);
        assert_eq!(sorted[1].place, Some(Vec2::new(-2.0, 0.0)));
    }

    #[test]
    fn a_flood_keeps_the_first_in_order() {
        let faults = Faults::default();
        (0..3000).rev().for_each(|line| faults.report(fault(line, 0.0)));
        let lines: Vec<u32> = faults.sorted().iter().map(|f| f.line).collect();
        assert_eq!(lines, (0..1000).collect::<Vec<_>>());
    }

    #[test]
    fn reads_like_a_compiler_message() {
        let fault = Fault { count: 2, ..fault(3, 5.0) }.with_hint(Some("try yes".into()));
        assert_eq!(fault.to_string(), "a.rhai:3:2: no (2 times) at (5, 0)\n  hint: try yes");
        assert_eq!(Fault::new("a.rhai", "not found").to_string(), "a.rhai: not found");
    }
}
