//! Towns for tests, built like any city.

use super::town::GrownTown;
use crate::build::{Settings, build};
use crate::{BuildError, Built, Cancel, LoadError, Loaded, Silent};
use script::testing::{Laboratory, Town, TownError};
use script::{Host, Plan, Severity, Texts};
use std::path::PathBuf;
use std::sync::Arc;

/// Builds towns from plans; files that a plan names lie in a folder.
#[derive(Debug)]
pub(super) struct CityLaboratory {
    pub folder: PathBuf,
}

impl CityLaboratory {
    /// The city of a plan.
    pub fn city(&self, plan: Plan) -> Result<Built, TownError> {
        let loaded = Loaded {
            changes: crate::Changes::default(),
            name: "town".into(),
            folder: self.folder.clone(),
            script: self.folder.join("test"),
            plan,
            printed: Vec::new(),
            doubts: Vec::new(),
            texts: Texts::default(),
            host: Host::new(Vec::new()),
        };
        let sources = loaded.read().map_err(|error| match error {
            LoadError::Value { error, .. } => TownError { message: error.message, hint: error.hint, fault: None },
            other => told(&other.to_string()),
        })?;
        // Tests run side by side: one of them has one thread.
        let settings = Settings { threads: 1, ..Settings::default() };
        build(&sources, settings, &Silent, &Cancel::default()).map_err(|error| match error {
            BuildError::Nothing { reason, hint, faults } => TownError {
                message: format!("there is no town: {reason}"),
                hint: Some(hint),
                fault: faults.into_iter().find(|fault| fault.severity == Severity::Error).map(Box::new),
            },
            BuildError::Fault(fault) => {
                TownError { message: fault.message.clone(), hint: fault.hint.clone(), fault: Some(fault) }
            }
            other => told(&other.to_string()),
        })
    }
}

impl Laboratory for CityLaboratory {
    fn build(&self, plan: Plan) -> Result<Arc<dyn Town>, TownError> {
        Ok(Arc::new(GrownTown::new(&self.city(plan)?)))
    }
}

/// A message with its hint on a line of its own.
fn told(text: &str) -> TownError {
    match text.split_once("\n  hint: ") {
        Some((message, hint)) => TownError { message: message.into(), hint: Some(hint.into()), fault: None },
        None => TownError { message: text.into(), hint: None, fault: None },
    }
}
