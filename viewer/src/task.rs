//! Work on a thread of its own, and what came of it.

use crate::worker::Wake;
use std::sync::mpsc::{Receiver, channel};

/// Something that is being made, or was.
#[derive(Debug)]
pub struct Task<T> {
    waiting: Option<Receiver<Result<T, String>>>,
    /// What was made, or why not.
    pub done: Option<Result<T, String>>,
}

impl<T> Default for Task<T> {
    fn default() -> Self {
        Self { waiting: None, done: None }
    }
}

impl<T: Send + 'static> Task<T> {
    /// Begins to make something on a thread of a name; what was made before, or is being made, is forgotten.
    pub fn begin(&mut self, name: &str, wake: Wake, make: impl FnOnce() -> Result<T, String> + Send + 'static) {
        let (sender, receiver) = channel();
        (self.waiting, self.done) = (Some(receiver), None);
        let thread = std::thread::Builder::new().name(name.into()).spawn(move || {
            // Nobody waits for it where something else was asked meanwhile.
            let _ = sender.send(make());
            wake();
        });
        if let Err(error) = thread {
            (self.waiting, self.done) = (None, Some(Err(error.to_string())));
        }
    }

    /// Takes in what was made once it is there.
    pub fn catch_up(&mut self) {
        let Some(waiting) = &self.waiting else { return };
        match waiting.try_recv() {
            Ok(made) => (self.done, self.waiting) = (Some(made), None),
            Err(std::sync::mpsc::TryRecvError::Empty) => {}
            // The thread panicked.
            Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                (self.done, self.waiting) = (Some(Err("it could not be made: this is a bug in Plat".into())), None);
            }
        }
    }

    /// Whether it is being made.
    pub fn is_busy(&self) -> bool {
        self.waiting.is_some()
    }

    /// Neither what was made nor what is being made is of interest any more.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn done<T: Send + Clone + 'static>(task: &mut Task<T>) -> Result<T, String> {
        while task.is_busy() {
            task.catch_up();
            std::thread::yield_now();
        }
        task.done.clone().unwrap()
    }

    #[test]
    fn the_last_thing_asked_for_is_what_comes() {
        let mut task = Task::default();
        task.begin("one", Arc::new(|| {}), || Ok(1));
        task.begin("two", Arc::new(|| {}), || Ok(2));
        assert_eq!(done(&mut task), Ok(2));
        task.forget();
        assert!(task.done.is_none() && !task.is_busy());
    }

    #[test]
    fn a_panic_is_told_and_nobody_waits_for_ever() {
        let mut task: Task<u8> = Task::default();
        task.begin("three", Arc::new(|| {}), || panic!("on purpose"));
        assert!(done(&mut task).unwrap_err().contains("bug"));
    }
}
