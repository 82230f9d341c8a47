//! Why a command did nothing: told to people, and to programs that asked for JSON.

use super::Status;

/// What went wrong, with the status that the process ends with.
#[derive(Debug)]
pub struct Failure {
    status: Status,
    message: String,
}

impl Failure {
    /// A failure of that status; the message may have lines with hints.
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    /// Tells it: on standard error, and as one JSON object on standard output where `json` was asked for.
    pub fn tell(&self, json: bool) -> Status {
        eprintln!("plat: {}", self.message);
        if json {
            println!("{}", as_json(self.status, &self.message));
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
