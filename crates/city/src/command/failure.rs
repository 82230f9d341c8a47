//! Why a command did nothing: told to people, and to programs that asked for JSON.

use super::{Status, faults};
use city::FaultReport;
use script::Texts;

/// What went wrong, with the status that the process ends with.
#[derive(Debug)]
pub struct Failure {
    status: Status,
    message: String,
    /// Faults of scripts, where these are what went wrong, with the texts they lie in.
    faults: Vec<FaultReport>,
    texts: Texts,
}

impl Failure {
    /// A failure of that status; the message may have lines with hints.
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into(), faults: Vec::new(), texts: Texts::default() }
    }

    /// A failure for faults of scripts, at least one.
    pub fn of_scripts(status: Status, faults: Vec<FaultReport>, texts: Texts) -> Self {
        Self { status, message: faults.first().map(ToString::to_string).unwrap_or_default(), faults, texts }
    }

    /// The status that the process ends with.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Tells it: on standard error, and as one JSON object on standard output where `json` was asked for.
    pub fn tell(&self, json: bool) -> Status {
        if self.faults.is_empty() {
            eprintln!("plat: {}", self.message);
        } else {
            faults::tell(&self.faults, &self.texts);
            eprintln!("plat: {}, nothing was written", faults::summary(&self.faults));
        }
        if json {
            let mut value = as_json(self.status, &self.message);
            if !self.faults.is_empty() {
                value["error"]["faults"] = serde_json::json!(self.faults);
            }
            println!("{value}");
        }
        self.status
    }
}

/// `error` with `status`, `message` and, where there is one, `hint`.
pub fn as_json(status: Status, message: &str) -> serde_json::Value {
    let (message, hint) = match message.split_once("\n  hint: ") {
        Some((message, hint)) => (message, Some(hint)),
        None => (message, None),
    };
    serde_json::json!({ "error": { "status": status as u8, "message": message.trim_end(), "hint": hint } })
}
