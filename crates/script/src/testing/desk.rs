//! What the words of a test write to while it runs.

use super::trial::{Trial, TrialHandle};
use super::{Outcome, Town};
use crate::fault::{Complaint, Fault};
use rhai::{Dynamic, Engine};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most lines of print that are kept.
const MOST_PRINTED: usize = 200;
/// Most readings that a failed claim tells.
const MOST_READINGS: usize = 6;
/// Longest reading, in characters.
const LONGEST_READING: usize = 200;

/// Something to be compared with a file.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// What its file is called after the test's own file: `raster` or `raster.second`.
    pub name: String,
    /// What is compared.
    pub text: String,
    /// The town that it is of, where it is of one: its map is for people, and not compared.
    pub town: Option<Arc<dyn Town>>,
}

/// What a test has done so far. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub(super) struct Desk {
    test: Arc<str>,
    trial: TrialHandle,
    state: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    /// What was measured or answered since the last claim that held: what it was called, and what it was.
    readings: Vec<(String, String)>,
    /// Those of the claim before, which the next one may be about as well.
    before: Vec<(String, String)>,
    snapshots: Vec<Snapshot>,
    printed: Vec<String>,
}

impl Desk {
    pub fn new(test: &str, trial: Option<&Trial>) -> Self {
        Self { test: test.into(), trial: TrialHandle::new(trial.cloned().unwrap_or_default()), state: Arc::default() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The trial as the test receives it.
    pub fn trial_handle(&self) -> Dynamic {
        Dynamic::from(self.trial.clone())
    }

    /// Takes in what was measured or answered, for the claim that follows.
    pub fn read(&self, what: &str, value: &str) {
        let mut state = self.lock();
        let value: String = match value.char_indices().nth(LONGEST_READING) {
            Some((at, _)) => format!("{}…", &value[..at]),
            None => value.to_owned(),
        };
        let reading = (what.to_owned(), value);
        if !state.readings.contains(&reading) {
            state.readings.push(reading);
        }
        if state.readings.len() > MOST_READINGS {
            state.readings.remove(0);
        }
    }

    /// Forgets the readings: the claim about them held.
    pub fn settle(&self) {
        let mut state = self.lock();
        let readings = std::mem::take(&mut state.readings);
        if !readings.is_empty() {
            state.before = readings;
        }
    }

    /// What was read since the last claim, in words: `order was 0.83, x_share was 0.2`.
    pub fn readings(&self) -> String {
        let state = self.lock();
        let readings = if state.readings.is_empty() { &state.before } else { &state.readings };
        let each: Vec<String> = readings.iter().map(|(what, value)| format!("{what} was {value}")).collect();
        each.join(", ")
    }

    /// Takes a snapshot, called after the test, and after `name` where one is given.
    pub fn snapshot(&self, name: Option<&str>, text: String, town: Option<Arc<dyn Town>>) -> Result<(), Complaint> {
        let mut state = self.lock();
        let name = match name {
            Some(name) => format!("{}.{name}", self.test),
            None => self.test.to_string(),
        };
        if state.snapshots.iter().any(|known| known.name == name) {
            let help = "call them apart: snapshot(town, \"by night\")";
            return Err(Complaint::new("this test takes two snapshots of one name").hint(help));
        }
        state.snapshots.push(Snapshot { name, text, town });
        Ok(())
    }

    /// Takes in what rules printed.
    pub fn print(&self, notes: impl IntoIterator<Item = String>) {
        let mut state = self.lock();
        let room = MOST_PRINTED.saturating_sub(state.printed.len());
        state.printed.extend(notes.into_iter().take(room));
    }

    /// Lets the engine print here.
    pub fn listen(&self, engine: &mut Engine) {
        let own = self.clone();
        let write = move |text: String| {
            let mut state = own.lock();
            if state.printed.len() < MOST_PRINTED {
                state.printed.push(text);
            }
        };
        let debug = write.clone();
        engine.on_print(move |text| write(text.to_owned()));
        engine.on_debug(move |text, _, at| debug(format!("{at:?}: {text}")));
    }

    /// What came of the test.
    pub fn outcome(&self, fault: Option<Fault>) -> Outcome {
        let mut state = self.lock();
        Outcome {
            fault,
            snapshots: std::mem::take(&mut state.snapshots),
            printed: std::mem::take(&mut state.printed),
            drawn: self.trial.drawn(),
        }
    }
}
