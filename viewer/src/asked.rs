//! Questions why something is there, answered on a thread of their own: the city is grown once more with a trace.

use crate::evidence::Evidence;
use crate::scene::Element;
use crate::worker::{Ready, Wake};
use city::why::{Answer, explain, find};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};

/// A question and its answer.
#[derive(Debug, Default)]
pub struct Asked {
    waiting: Option<Receiver<Result<Answer, String>>>,
    /// The answer, or why there is none.
    pub answer: Option<Result<Answer, String>>,
}

impl Asked {
    /// Asks about something.
    pub fn ask(&mut self, ready: Arc<Ready>, evidence: Arc<Evidence>, element: &Element, wake: Wake) {
        let (sender, receiver) = channel();
        let id = element.id.to_string();
        (self.waiting, self.answer) = (Some(receiver), None);
        let answer = move || {
            // Nobody waits for it where something else was asked meanwhile.
            let _ = sender.send(answer(&evidence, &ready, &id));
            wake();
        };
        let thread = std::thread::Builder::new().name("why".into()).spawn(answer);
        if let Err(error) = thread {
            (self.waiting, self.answer) = (None, Some(Err(error.to_string())));
        }
    }

    /// Takes the answer in once it is there.
    pub fn catch_up(&mut self) {
        if let Some(answer) = self.waiting.as_ref().and_then(|waiting| waiting.try_recv().ok()) {
            (self.answer, self.waiting) = (Some(answer), None);
        }
    }

    /// Whether an answer is on its way.
    pub fn is_asking(&self) -> bool {
        self.waiting.is_some()
    }

    /// What was asked is no longer of interest.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

fn answer(evidence: &Evidence, ready: &Ready, id: &str) -> Result<Answer, String> {
    let (layout, traced) = (evidence.layout(ready)?, evidence.traced(ready)?);
    let found = find(layout, id).map_err(|error| error.to_string())?;
    Ok(explain(&found, layout, &ready.sources, traced))
}
