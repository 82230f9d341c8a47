//! Changes with undo and redo.

use city::Changes;
use std::sync::Arc;

/// Most steps that can be undone.
const MOST: usize = 500;

/// The changes of a city as they were and are.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Shared with whoever keeps it against a loss.
    states: Arc<Vec<(String, Changes)>>,
    /// The place of the present state among them.
    at: usize,
    /// As they are on disk.
    saved: Changes,
    /// What the last step changed, while it may go on.
    open: Option<String>,
}

impl History {
    /// Starts with what is on disk.
    pub fn of(saved: Changes) -> Self {
        Self { states: Arc::new(vec![(String::new(), saved.clone())]), at: 0, saved, open: None }
    }

    /// The present changes.
    pub fn now(&self) -> Changes {
        self.states.get(self.at).map(|(_, changes)| changes.clone()).unwrap_or_default()
    }

    /// Makes a step, called so that people know it. Steps that turn the same thing one after the other, until
    /// [`History::close`], are one. Returns whether anything is another.
    pub fn step(&mut self, name: &str, turns: Option<&str>, change: impl FnOnce(&mut Changes)) -> bool {
        let mut next = self.now();
        change(&mut next);
        if next == self.now() {
            return false;
        }
        let states = Arc::make_mut(&mut self.states);
        states.truncate(self.at + 1);
        let goes_on = turns.is_some() && self.open.as_deref() == turns && self.at > 0;
        if goes_on {
            states.pop();
        } else {
            self.at += 1;
        }
        states.push((name.to_owned(), next));
        if states.len() > MOST {
            states.remove(0);
            self.at -= 1;
        }
        self.open = turns.map(str::to_owned);
        true
    }

    /// What was being turned is let go.
    pub fn close(&mut self) {
        self.open = None;
    }

    /// What undoing would take back.
    pub fn to_undo(&self) -> Option<&str> {
        (self.at > 0).then(|| self.states[self.at].0.as_str())
    }

    /// What redoing would bring back.
    pub fn to_redo(&self) -> Option<&str> {
        self.states.get(self.at + 1).map(|(name, _)| name.as_str())
    }

    /// Takes the last step back; whether there was one.
    pub fn undo(&mut self) -> bool {
        self.close();
        let can = self.at > 0;
        self.at -= usize::from(can);
        can
    }

    /// Brings the step back that was taken back last; whether there was one.
    pub fn redo(&mut self) -> bool {
        self.close();
        let can = self.at + 1 < self.states.len();
        self.at += usize::from(can);
        can
    }

    /// The changes that are on disk, as far as is known.
    pub fn saved(&self) -> &Changes {
        &self.saved
    }

    /// Whether the present state is that on disk.
    pub fn is_saved(&self) -> bool {
        self.now() == self.saved
    }

    /// The present state is on disk now.
    pub fn mark_saved(&mut self) {
        self.saved = self.now();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_taken_back_and_brought_back() {
        let mut history = History::of(Changes::default());
        assert!(history.step("a", None, |changes| changes.set("a", "1")));
        assert!(history.step("b", None, |changes| changes.set("b", "2")));
        assert!(!history.step("b", None, |changes| changes.set("b", "2")), "nothing is another");
        assert_eq!((history.to_undo(), history.to_redo()), (Some("b"), None));
        assert!(history.undo());
        assert_eq!((history.now().value("a"), history.now().value("b")), (Some("1"), None));
        assert!(history.redo() && !history.redo());
        assert_eq!(history.now().value("b"), Some("2"));
        assert!(history.undo() && history.undo() && !history.undo());
        assert!(history.is_saved());
        assert!(history.step("c", None, |changes| changes.set("c", "3")));
        assert_eq!(history.to_redo(), None, "another way was taken");
    }

    #[test]
    fn turning_one_thing_is_one_step_until_it_is_let_go() {
        let mut history = History::of(Changes::default());
        for value in ["1", "2", "3"] {
            history.step("a", Some("a"), |changes| changes.set("a", value));
        }
        history.close();
        history.step("a", Some("a"), |changes| changes.set("a", "4"));
        assert!(history.undo());
        assert_eq!(history.now().value("a"), Some("3"));
        assert!(history.undo());
        assert_eq!(history.now().value("a"), None);
    }

    #[test]
    fn what_was_saved_is_known_again() {
        let mut history = History::of(Changes::default());
        history.step("a", None, |changes| changes.set("a", "1"));
        history.mark_saved();
        history.undo();
        assert!(!history.is_saved());
        history.redo();
        assert!(history.is_saved());
    }
}
