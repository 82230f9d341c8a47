//! A rule asked once more about one element, step by step.

use super::{Answer, Evidence};
use crate::Cache;
use crate::progress::{Cancel, Silent};
use crate::stages::Context;
use crate::stages::ground::CityGround;
use script::{Fault, Faults, Rule, RuleKind, Severity, Step, StepKind};
use serde::Serialize;
use std::sync::Arc;

/// What a rule did when it was asked about an element, and what came of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DecisionSays {
    /// What it was asked about, e.g. `the parcel` or `the street end at (100.0, 250.0)`.
    pub about: String,
    /// The rule, e.g. `buildings/zoned`.
    pub rule: String,
    /// Its file.
    pub file: String,
    /// The function that was asked.
    pub function: String,
    /// What it did, in that order.
    pub steps: Vec<StepSays>,
    /// How many further steps are left out, and behind how many of those above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out: Option<LeftOut>,
    /// What came of it, and what limits took off.
    pub outcome: Vec<String>,
}

/// Steps that are not told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// How many.
    pub count: usize,
    /// How many are told before them.
    pub behind: usize,
}

/// One thing that a rule did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepSays {
    /// The file, where it is another than the rule's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The line, from 1.
    pub line: u32,
    /// `value` of what was read, asked, computed or decided; `test` of a condition; `print`.
    pub kind: &'static str,
    /// As it is written in the rule, on one line.
    pub text: String,
    /// What came of it; `true` or `false` of a test.
    pub value: Option<String>,
    /// Both as people read them.
    #[serde(skip)]
    pub told: String,
}

impl DecisionSays {
    /// What it is called: `build(shape, p) of houses was asked about the parcel`.
    pub fn heading(&self) -> String {
        format!("{} of {} was asked about {}", self.function, self.rule, self.about)
    }
}

impl StepSays {
    fn of(step: &Step, file: &str) -> Self {
        let kind = match step.kind {
            StepKind::Value => "value",
            StepKind::Test => "test",
            StepKind::Print => "print",
        };
        let other = (*step.file != *file).then(|| step.file.to_string());
        let (line, text, value) = (step.line, step.text.clone(), step.value.clone());
        Self { file: other, line, kind, text, value, told: step.to_string() }
    }
}

/// Asks a rule once more, and once so that it tells what it does. What it prints and marks meanwhile is not the city's.
pub fn asked<D>(
    rule: &Rule,
    kind: RuleKind,
    about: impl Into<String>,
    ask: impl Fn(Rule, Arc<Faults>) -> D,
) -> (D, DecisionSays) {
    let faults = Arc::new(Faults::default());
    let decided = ask(rule.apart(), faults.clone());
    let (telling, account) = rule.telling();
    ask(telling, Arc::default());
    let told = account.take();
    let left_out = LeftOut { count: told.left_out, behind: told.first.len() };
    // Warnings are of rules that do nothing anywhere.
    let failed = faults.sorted().into_iter().filter(|fault| fault.severity == Severity::Error);
    let outcome = failed.map(|fault| {
        let Fault { file, line, column, message, .. } = fault;
        format!("the rule failed: {file}:{line}:{column}: {message}")
    });
    let says = DecisionSays {
        about: about.into(),
        rule: rule.name().to_owned(),
        file: rule.path().to_owned(),
        function: kind.form(),
        steps: told.steps().map(|step| StepSays::of(step, rule.path())).collect(),
        left_out: (told.left_out > 0).then_some(left_out),
        outcome: outcome.collect(),
    };
    (decided, says)
}

/// Does something with what the stages of a build are given.
pub fn in_city(evidence: &Evidence, answer: &mut Answer, tell: impl FnOnce(&Context, &Arc<CityGround>, &mut Answer)) {
    let (faults, cache, cancel) = (Arc::new(Faults::default()), Cache::none(), Cancel::default());
    let context = Context {
        sources: evidence.sources,
        faults: &faults,
        progress: &Silent,
        cancel: &cancel,
        traces: false,
        cache: &cache,
        keys: None,
        within: None,
    };
    let ground = Arc::new(CityGround::new(&context, &evidence.built.city.graph));
    tell(&context, &ground, answer);
}

/// A length, an area or a share as people read it.
pub fn number(value: f64) -> String {
    let factor = if value.abs() >= 100.0 { 1.0 } else { 100.0 };
    format!("{}", (value * factor).round() / factor)
}
