//! The validity contract, checked on a `layout.geojson`: only what the file says counts, not how it was built.
//!
//! What decides is exact on the lattice where the contract is exact (V1, V2, V5), and a sliver of [`SLIVER_M`] wide
//! where rounded borders may meet (V4, V6, V7, V8, V22).

mod areas;
mod described;
mod ground;
mod index;
mod roadways;
mod streets;

use crate::Until;
use crate::export::{LayoutFile, ReadError, read_layout};
use geom::{Point, Vec2};
use ground::Ground;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// Below this width (m) two areas touch, above it they overlap.
pub const SLIVER_M: f64 = 0.01;

/// Witnesses kept for each rule; the rest is counted.
const WITNESSES: usize = 100;

/// A rule that does not hold, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// The rule: `ids`, `S` (described), or a number of the contract such as `V1`.
    pub rule: &'static str,
    /// The features concerned, as `kind id`.
    pub ids: Vec<String>,
    /// Where, in metres, when there is one place.
    pub place: Option<Vec2>,
    /// What is wrong, with the measure.
    pub message: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        match self.place {
            Some(at) => write!(f, " at ({:.3}, {:.3})", at.x, at.y),
            None => Ok(()),
        }
    }
}

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ValidationReport {
    /// Features of each kind.
    pub features: BTreeMap<String, usize>,
    /// Length of all streets in kilometres.
    pub street_km: f64,
    /// How often each rule is violated.
    pub counts: BTreeMap<&'static str, usize>,
    /// Witnesses by rule, then in the order of the file; a hundred a rule at most.
    pub violations: Vec<Violation>,
    /// What is worth knowing but violates nothing.
    pub notes: Vec<String>,
}

impl ValidationReport {
    /// Whether every rule holds.
    pub fn is_valid(&self) -> bool {
        self.counts.is_empty()
    }

    /// The report as one JSON object: `violations` (witnesses by rule), `violation_count`, `counts`, `street_km`,
    /// `notes`.
    pub fn to_json(&self) -> serde_json::Value {
        let of_rule = |rule: &&str| {
            let such = self.violations.iter().filter(|violation| violation.rule == *rule);
            let witness = |violation: &Violation| {
                let place = violation.place.map(|at| [at.x, at.y]);
                serde_json::json!({ "ids": violation.ids, "place": place, "message": violation.message })
            };
            ((*rule).to_owned(), such.map(witness).collect::<serde_json::Value>())
        };
        let violations: serde_json::Map<_, _> = self.counts.keys().map(of_rule).collect();
        serde_json::json!({
            "violations": violations,
            "violation_count": self.counts,
            "counts": self.features,
            "street_km": self.street_km,
            "notes": self.notes,
        })
    }

    /// Records a violation of `rule` by features given as (kind, id).
    fn add(&mut self, rule: &'static str, who: &[(&str, &str)], place: Option<Point>, message: String) {
        let count = self.counts.entry(rule).or_default();
        *count += 1;
        if *count <= WITNESSES {
            let ids = who.iter().map(|(kind, id)| format!("{kind} {id}")).collect();
            self.violations.push(Violation { rule, ids, place: place.map(Point::metres), message });
        }
    }
}

impl fmt::Display for ValidationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (kind, count) in &self.features {
            writeln!(f, "{kind}: {count}")?;
        }
        // An empty sum is -0.
        writeln!(f, "street_km: {:.2}", self.street_km + 0.0)?;
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        for (rule, count) in &self.counts {
            writeln!(f, "{rule}: {count} violated")?;
            for violation in self.violations.iter().filter(|violation| violation.rule == *rule).take(5) {
                writeln!(f, "   {violation}")?;
            }
        }
        write!(f, "violations: {}", self.counts.values().sum::<usize>())
    }
}

/// Checks a layout file against the contract.
///
/// # Errors
/// When the file can't be read as a layout; what is wrong with a layout that can be read is in the report.
pub fn validate(path: &Path, until: Until) -> Result<ValidationReport, ReadError> {
    Ok(check(&read_layout(path)?, until))
}

/// Checks a layout that was read against the contract.
pub fn check(file: &LayoutFile, until: Until) -> ValidationReport {
    let mut report = ValidationReport::default();
    described::check(file, until, &mut report);
    let ground = Ground::of(file, &mut report);
    streets::check(&ground, &mut report);
    areas::check_shapes(&ground, &mut report);
    areas::check_overlaps(&ground, &mut report);
    areas::check_owners(&ground, &mut report);
    roadways::check(&ground, &mut report);
    areas::check_access(&ground, until, &mut report);
    report.violations.sort_by_key(|violation| violation.rule);
    report
}

#[cfg(test)]
mod tests;
