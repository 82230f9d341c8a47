//! What a native word says when it refuses its arguments.

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
}

/// What native words return instead of a value.
pub(crate) type Refusal = Box<EvalAltResult>;

impl Complaint {
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None, key: None }
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

impl From<Complaint> for Refusal {
    fn from(complaint: Complaint) -> Self {
        // The engine fills in the position of the call.
        Box::new(EvalAltResult::ErrorRuntime(Dynamic::from(complaint), Position::NONE))
    }
}
