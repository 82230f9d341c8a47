//! What there is to say about a build: counts, logs and faults.

use crate::sources::ImportLog;
use crate::{City, Sources};
use script::{Call, Fault, Faults, Marked, Note, Plan, Severity, StreetPlan};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use streets::growth::{GrowthLog, MergeLog, Refused};
use streets::runs::Run;

/// The report of one build; `report.json` holds it. The same for the same city: no times, no paths but how one
/// gets from the report to the city.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// The city's name.
    pub city: String,
    /// Its seed, as text: JSON readers lose digits of large numbers.
    pub seed: String,
    /// What it was built from, where a command built it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub built_from: Option<BuiltFrom>,
    /// How many there are of each kind.
    pub counts: BTreeMap<&'static str, usize>,
    /// Lengths of streets by class, metres.
    pub street_metres: BTreeMap<String, f64>,
    /// By stage of growth: accepted proposals, and refused ones by reason.
    pub growth: BTreeMap<String, GrowthReport>,
    /// By file: what was imported.
    pub imports: BTreeMap<String, ImportReport>,
    /// Land in slivers that became neither parcel nor right-of-way, m².
    pub sliver_m2: f64,
    /// What is odd but did no harm.
    pub warnings: Vec<String>,
    /// What rules printed, by rule and text.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub prints: Vec<Print>,
    /// Places that rules marked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<MarkReport>,
    /// What went wrong in rules, and what is surely a mistake there, each kind once with a count.
    pub faults: Vec<FaultReport>,
}

/// A place that a rule marked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarkReport {
    /// The rule's file.
    pub rule: String,
    /// The place, metres.
    pub place: [f64; 2],
    /// Where the rule was asked when it did, metres: of several places the first, by x, then y.
    pub asked: Option<[f64; 2]>,
}

/// A line that a rule printed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Print {
    /// The rule's file.
    pub rule: String,
    /// What it printed.
    pub text: String,
    /// How often.
    pub count: u64,
    /// Where the rule was asked when it did, metres: of several places the first, by x, then y. None where it is asked once for
    /// a whole city.
    pub place: Option<[f64; 2]>,
}

impl std::fmt::Display for Print {
    /// `file: text (3 times, first at (x, y))`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.rule, self.text)?;
        let place = self.place.map(|[x, y]| format!("at ({x:.1}, {y:.1})"));
        match (self.count, place) {
            (1, None) => Ok(()),
            (1, Some(place)) => write!(f, " ({place})"),
            (count, None) => write!(f, " ({count} times)"),
            (count, Some(place)) => write!(f, " ({count} times, first {place})"),
        }
    }
}

/// What a command built a city from, so that another can build it again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BuiltFrom {
    /// The city's folder or script as it was named: where it was written to leaves no trace.
    pub city: String,
    /// The folder of further rules, likewise.
    #[serde(default)]
    pub rules: Option<String>,
    /// The presets laid on it on the command line.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub presets: Vec<String>,
    /// The parameters set on the command line.
    #[serde(default)]
    pub set: Vec<String>,
}

/// What there is to say about streets alone: it is kept with them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct StreetsReport {
    growth: BTreeMap<String, GrowthReport>,
    imports: BTreeMap<String, ImportReport>,
    warnings: Vec<String>,
}

/// Growth in numbers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct GrowthReport {
    /// Accepted proposals.
    pub accepted: usize,
    /// Refused proposals by reason.
    pub refused: BTreeMap<String, usize>,
    /// Lines that grew in a quarter but found no room in the city.
    pub dropped: usize,
}

/// An import in numbers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ImportReport {
    /// Streets laid.
    pub streets: usize,
    /// Length in the file, metres.
    pub source_metres: f64,
    /// Length laid on ground that no street of the file had, metres.
    pub laid_metres: f64,
    /// Pieces refused.
    pub refused: usize,
    /// Lines left out, by reason.
    pub left_out: BTreeMap<String, usize>,
}

/// A fault as it is written.
#[derive(Clone, Debug, Serialize)]
pub struct FaultReport {
    /// `error` or `warning`.
    pub severity: &'static str,
    /// Script file.
    pub file: String,
    /// Line, from 1; 0 when unknown.
    pub line: u32,
    /// Column in characters, from 1; 0 when unknown.
    pub column: u32,
    /// Characters of the word that is to blame; 0 when unknown.
    pub length: u32,
    /// What went wrong.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
    /// The calls that led there, the innermost first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub calls: Vec<CallReport>,
    /// Where it first happened, metres.
    pub place: Option<[f64; 2]>,
    /// How often.
    pub count: u64,
}

/// A call on the way to a fault.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CallReport {
    /// The function.
    pub function: String,
    /// Script file it was called in.
    pub file: String,
    /// Line, from 1; 0 when unknown.
    pub line: u32,
    /// Column, from 1; 0 when unknown.
    pub column: u32,
}

impl From<&FaultReport> for Fault {
    fn from(report: &FaultReport) -> Self {
        let severity = if report.is_error() { Severity::Error } else { Severity::Warning };
        let call = |call: &CallReport| Call {
            function: call.function.clone(),
            file: call.file.clone(),
            line: call.line,
            column: call.column,
        };
        Self {
            severity,
            line: report.line,
            column: report.column,
            length: report.length,
            calls: report.calls.iter().map(call).collect(),
            place: report.place.map(geom::Vec2::from_array),
            count: report.count,
            ..Self::new(&report.file, &report.message).with_hint(report.hint.clone())
        }
    }
}

impl FaultReport {
    /// Whether it is more than a warning.
    pub fn is_error(&self) -> bool {
        self.severity == ERROR
    }
}

const ERROR: &str = "error";

impl std::fmt::Display for FaultReport {
    /// `file:line:column: message`, and a line with the hint.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.file)?;
        if self.line > 0 {
            write!(f, ":{}:{}", self.line, self.column)?;
        }
        write!(f, ": {}", self.message)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, "\n  hint: {hint}"))
    }
}

impl From<&Fault> for FaultReport {
    fn from(fault: &Fault) -> Self {
        let call = |call: &Call| CallReport {
            function: call.function.clone(),
            file: call.file.clone(),
            line: call.line,
            column: call.column,
        };
        Self {
            severity: if fault.severity == Severity::Error { ERROR } else { "warning" },
            length: fault.length,
            calls: fault.calls.iter().map(call).collect(),
            file: fault.file.clone(),
            line: fault.line,
            column: fault.column,
            message: fault.message.clone(),
            hint: fault.hint.clone(),
            place: fault.place.map(|place| place.to_array()),
            count: fault.count,
        }
    }
}

impl Report {
    pub(crate) fn new(sources: &Sources) -> Self {
        // What is wrong there, and not only doubtful, tells itself when it is reached.
        let doubts = sources.doubts.iter().filter(|fault| fault.severity == Severity::Warning);
        let faults = doubts.map(FaultReport::from).collect();
        Self { city: sources.name.clone(), seed: sources.plan.seed.to_string(), faults, ..Self::default() }
    }

    /// Whether rules failed anywhere.
    pub fn has_faults(&self) -> bool {
        self.faults.iter().any(FaultReport::is_error)
    }

    pub(crate) fn warn(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    /// Keeps what rules printed since an earlier time: rules live longer than one build.
    pub(crate) fn printed(&mut self, plan: &Plan, before: &[(String, Note)]) {
        let earlier: BTreeMap<_, _> = before.iter().map(|(rule, note)| ((rule, &note.text), note.count)).collect();
        for (rule, Note { text, count, place }) in plan.notes() {
            let count = count - earlier.get(&(&rule, &text)).copied().unwrap_or(0);
            let place = place.map(|at| at.to_array().map(round));
            self.prints.extend((count > 0).then_some(Print { rule, text, count, place }));
        }
        let mut by_rule: BTreeMap<&str, usize> = BTreeMap::new();
        self.prints.iter().for_each(|print| *by_rule.entry(&print.rule).or_default() += 1);
        let full = by_rule.into_iter().filter(|(_, count)| *count >= script::MOST_NOTES);
        let told = |(rule, count): (&str, usize)| {
            format!("{rule} prints more texts than are kept: the first {count} in alphabetical order")
        };
        let warnings: Vec<String> = full.map(told).collect();
        self.warnings.extend(warnings);
    }

    /// Keeps what rules marked.
    pub(crate) fn marked(&mut self, plan: &Plan) {
        let mark = |(rule, Marked { place, asked }): (String, Marked)| {
            let asked = asked.map(|at| at.to_array());
            MarkReport { rule, place: place.to_array(), asked }
        };
        self.marks = plan.marks().into_iter().map(mark).collect();
    }

    /// Takes over what was said about streets.
    pub(crate) fn take(&mut self, streets: &StreetsReport) {
        let StreetsReport { growth, imports, warnings } = streets.clone();
        self.growth = growth;
        self.imports = imports;
        self.warnings.extend(warnings);
    }

    pub(crate) fn finish(&mut self, city: &City, plan: &Plan, faults: &Faults, trimmed: i128, open: usize) {
        self.counts = BTreeMap::from([
            ("nodes", city.graph.node_count()),
            ("segments", city.graph.segment_count()),
            ("streets", city.runs.len()),
            ("quarters", city.quarters.len()),
            ("blocks", city.blocks.len()),
            ("parcels", city.parcels.len()),
            ("open parcels", open),
            ("buildings", city.buildings.len()),
        ]);
        for key in city.graph.segments_by_id() {
            let (a, b) = city.graph.line(key.forward());
            let class = city.graph.classes().info(city.graph.segment(key).class()).name.clone();
            *self.street_metres.entry(class).or_default() += a.distance(b);
        }
        self.street_metres.values_mut().for_each(|metres| *metres = round(*metres));
        self.sliver_m2 = round(trimmed as f64 / 2.0 / (1024.0 * 1024.0));
        if city.blocks.is_empty() {
            self.warn("no streets close a block, so there is no land to divide".into());
        }
        let sorted = faults.sorted();
        let told = sorted.iter().filter(|fault| !is_in_place(city, fault) && !self.agrees_elsewhere(plan, fault));
        let told: Vec<&Fault> = told.collect();
        self.faults.extend(told.into_iter().map(FaultReport::from));
    }

    /// Whether a warning that a constraint refuses every street is of some quarters alone: in others minors grew that it agreed
    /// to. Each quarter asks for itself.
    fn agrees_elsewhere(&self, plan: &Plan, fault: &Fault) -> bool {
        let is_among = |streets: &Option<StreetPlan>| {
            streets.iter().flat_map(|streets| &streets.constraints).any(|rule| rule.path() == fault.file)
        };
        // Which class it was asked about is not told: of another one it may be true.
        let is_of_minors = is_among(&plan.minors) && !is_among(&plan.majors) && !is_among(&plan.highways);
        let grew = self.growth.get("minors").is_some_and(|growth| growth.accepted > 0);
        // A quarter with a preset of its own may do without the rule.
        let is_everywhere = plan.quarters.values().all(|quarter| quarter.preset.is_none());
        fault.message == script::REFUSES_EVERYTHING && grew && is_everywhere && is_of_minors
    }
}

/// Whether a warning that a rule proposes nothing was meant of some quarters alone: in others it grew streets. Each quarter is
/// asked for by itself and knows nothing of the others.
fn is_in_place(city: &City, fault: &Fault) -> bool {
    let has_file = |rule: &String| {
        let file = format!("{rule}.rhai");
        fault.file == file || fault.file.ends_with(&format!("/{file}"))
    };
    let grew = |run: &Run| city.origins.get(usize::from(run.origin)).is_some_and(has_file);
    fault.message == script::PROPOSES_NOTHING && city.runs.iter().any(grew)
}

impl StreetsReport {
    pub(crate) fn warn(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    pub(crate) fn grown(&mut self, stage: &'static str, log: &GrowthLog) {
        let report = self.growth.entry(stage.to_owned()).or_default();
        report.accepted += log.accepted.len();
        let told: usize = log.reasons.values().sum();
        for (reason, count) in log.refusals.iter() {
            // What rules said stands for their refusals.
            let count = if reason == Refused::ByRule { count - told.min(count) } else { count };
            if count > 0 {
                *report.refused.entry(reason.to_string()).or_default() += count;
            }
        }
        for (why, count) in &log.reasons {
            *report.refused.entry(why.to_string()).or_default() += count;
        }
    }

    pub(crate) fn merged(&mut self, log: &MergeLog) {
        self.growth.entry("minors".into()).or_default().dropped += log.dropped.len();
    }

    pub(crate) fn imported(&mut self, file: &str, log: &ImportLog, left_out: &BTreeMap<String, usize>) {
        let report = ImportReport {
            streets: log.streets,
            source_metres: round(log.source_length),
            laid_metres: round(log.laid_length),
            refused: log.refused.len(),
            left_out: left_out.clone(),
        };
        for refused in &log.refused {
            self.warnings.push(format!("{file}: {refused}"));
        }
        self.imports.insert(file.to_owned(), report);
    }
}

/// To the millimetre: what is written should not wobble with the order of sums.
fn round(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}
