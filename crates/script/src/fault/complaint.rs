//! What a native word says when it refuses its arguments.

use super::{Fault, key_position};
use crate::host::Source;
use rhai::{Dynamic, EvalAltResult, Position};

/// A native word's refusal: travels through Rhai as the payload of a run-time error.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Complaint {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
    /// The key of an options map that is to blame; the fault is then placed on it.
    pub key: Option<String>,
    /// The fault of a rule that lies behind it, which is told instead: it knows its own place.
    pub fault: Option<Box<Fault>>,
}

/// What native words return instead of a value.
pub(crate) type Refusal = Box<EvalAltResult>;

impl Complaint {
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None, key: None, fault: None }
    }

    /// Tells a fault as it stands.
    pub fn of(fault: Fault) -> Self {
        Self { fault: Some(Box::new(fault)), ..Self::new("") }
    }

    /// Tells the fault of a rule, in words of its own where the fault knows no line: where the rule is asked for says more.
    pub fn of_rule(fault: Fault) -> Self {
        if fault.line > 0 {
            return Self::of(fault);
        }
        Self::new(format!("{}: {}", fault.file, fault.message)).maybe_hint(fault.hint)
    }

    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    pub fn maybe_hint(mut self, hint: Option<String>) -> Self {
        self.hint = hint;
        self
    }

    pub fn key(mut self, key: impl Into<String>) -> Self {
        self.key = Some(key.into());
        self
    }
}

impl Complaint {
    /// The fault of what a word of a script was given, once the script has run: placed on the option, or on the word.
    pub fn in_call(self, word: &str, source: &Source) -> Fault {
        if let Some(fault) = self.fault {
            return *fault;
        }
        let lines = source.text.lines().zip(1..);
        let is_call = |line: &str| line.trim_start().starts_with(&format!("{word}("));
        let call = lines.clone().find(|(line, _)| is_call(line)).map_or(0, |(_, number)| number);
        let key = self.key.as_deref().unwrap_or_default();
        let place = key_position(&source.text, call, 1, key).filter(|_| !key.is_empty());
        let (line, column) = place.unwrap_or((call, u32::from(call > 0)));
        Fault { line, column, ..Fault::new(&source.path, self.message).with_hint(self.hint) }
    }
}

impl From<Complaint> for Refusal {
    fn from(complaint: Complaint) -> Self {
        // The engine fills in the position of the call.
        Box::new(EvalAltResult::ErrorRuntime(Dynamic::from(complaint), Position::NONE))
    }
}
