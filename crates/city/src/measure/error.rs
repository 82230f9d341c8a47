//! Why a layout could not be measured.

use crate::sources::SourceError;
use std::path::PathBuf;

/// Why a layout could not be measured, or its figures not be judged.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// A street does not say what a measure needs.
    #[error("street {id} {message}\n  hint: `plat validate` finds all that is wrong with a layout")]
    Street {
        /// Its id, or a word for its absence.
        id: String,
        /// What it lacks.
        message: String,
    },
    /// A map is missing or wrong.
    #[error("{source_error}\n  hint: {hint}", source_error = .0, hint = .0.hint())]
    Map(#[from] SourceError),
    /// The file of ranges is missing or wrong.
    #[error("{}: {message}\n  hint: {hint}", path.display())]
    Ranges {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
        /// What to do.
        hint: String,
    },
}
