//! What can be wrong with a file.

use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file that cannot be used: which one, what is wrong, and (see [`SourceError::hint`]) what to do about it.
#[derive(Debug, Error)]
pub enum SourceError {
    /// A folder or file is missing or cannot be read.
    #[error("{}: cannot be read: {cause}", path.display())]
    Unreadable {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// A map that a plan asks for is not in the folder.
    #[error("{}: there is no map `{name}` ({name}.png)", path.display())]
    MissingMap {
        /// The maps folder.
        path: PathBuf,
        /// The map asked for.
        name: String,
        /// Which maps there are, the likely one named.
        hint: String,
    },
    /// A text file does not parse.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What is wrong there.
        message: String,
        /// What to do.
        hint: String,
    },
    /// A binary file is truncated or damaged.
    #[error("{}: damaged at byte {offset}: {message}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where, in bytes from the start of the file.
        offset: u64,
        /// What is wrong there.
        message: String,
    },
    /// A picture that cannot be a map.
    #[error("{}: {message}", path.display())]
    Picture {
        /// The picture.
        path: PathBuf,
        /// What is wrong.
        message: String,
        /// What to do.
        hint: String,
    },
    /// A value that makes no sense, e.g. a pixel size of zero.
    #[error("{}: {what} is {value}: {rule}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Which value.
        what: String,
        /// What it is.
        value: String,
        /// What it must be.
        rule: String,
    },
    /// Two maps of one site that do not cover the same rectangle.
    #[error(
        "{} and {} do not cover the same rectangle: {first_bounds}, but {second_bounds}",
        path.display(), second.display()
    )]
    BoundsDiffer {
        /// One map.
        path: PathBuf,
        /// Its bounds.
        first_bounds: String,
        /// The other map.
        second: PathBuf,
        /// Its bounds.
        second_bounds: String,
    },
    /// A record of a street file that cannot be read.
    #[error("{}: {record}: {message}", path.display())]
    Record {
        /// The file.
        path: PathBuf,
        /// Which record, e.g. `feature 17`.
        record: String,
        /// What is wrong with it.
        message: String,
    },
    /// A file of another kind, or one with nothing in it.
    #[error("{}: {message}", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
        /// What it is not.
        message: String,
        /// What to do.
        hint: String,
    },
}

impl SourceError {
    /// The file that is wrong.
    pub fn path(&self) -> &Path {
        match self {
            Self::Unreadable { path, .. }
            | Self::MissingMap { path, .. }
            | Self::Syntax { path, .. }
            | Self::Damaged { path, .. }
            | Self::Picture { path, .. }
            | Self::Value { path, .. }
            | Self::BoundsDiffer { path, .. }
            | Self::Record { path, .. }
            | Self::Kind { path, .. } => path,
        }
    }

    /// What a person can do about it.
    pub fn hint(&self) -> String {
        match self {
            Self::Unreadable { cause, .. } => unreadable_hint(cause.kind()).to_owned(),
            Self::MissingMap { hint, .. }
            | Self::Syntax { hint, .. }
            | Self::Picture { hint, .. }
            | Self::Kind { hint, .. } => hint.clone(),
            Self::Damaged { .. } => "fetch or export the file again: it is cut off or altered".to_owned(),
            Self::Value { what, .. } => format!("correct {what}"),
            Self::BoundsDiffer { .. } => {
                "maps of one site may differ in resolution, not in bounds: cut or pad one of them".to_owned()
            }
            Self::Record { record, .. } => format!("correct or remove {record}"),
        }
    }

    pub(super) fn unreadable(path: &Path, cause: io::Error) -> Self {
        Self::Unreadable { path: path.to_owned(), cause }
    }

    pub(super) fn value(path: &Path, what: &str, value: impl ToString, rule: &str) -> Self {
        Self::Value { path: path.to_owned(), what: what.to_owned(), value: value.to_string(), rule: rule.to_owned() }
    }

    pub(super) fn json(path: &Path, error: &serde_json::Error, hint: &str) -> Self {
        let full = error.to_string();
        let message = full.split(" at line ").next().unwrap_or(&full).to_owned();
        Self::Syntax {
            path: path.to_owned(),
            line: error.line(),
            column: error.column(),
            message,
            hint: hint.to_owned(),
        }
    }

    pub(super) fn picture(path: &Path, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Picture { path: path.to_owned(), message: message.into(), hint: hint.into() }
    }

    pub(super) fn record(path: &Path, record: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Record { path: path.to_owned(), record: record.into(), message: message.into() }
    }

    pub(crate) fn kind(path: &Path, message: impl Into<String>, hint: String) -> Self {
        Self::Kind { path: path.to_owned(), message: message.into(), hint }
    }

    pub(super) fn damaged(path: &Path, offset: u64, message: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), offset, message: message.into() }
    }
}

fn unreadable_hint(kind: io::ErrorKind) -> &'static str {
    match kind {
        io::ErrorKind::NotFound => "check the spelling; paths are relative to the city's folder",
        io::ErrorKind::PermissionDenied => "allow reading it",
        _ => "check that it is an ordinary file",
    }
}

/// Reads a whole file.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, SourceError> {
    std::fs::read(path).map_err(|cause| SourceError::unreadable(path, cause))
}
