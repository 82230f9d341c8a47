//! Questions why something is there, answered on a thread of their own: the city is grown once more with a trace.

use crate::scene::Element;
use crate::worker::{Ready, Wake};
use city::export::geojson::write_layout;
use city::export::layout_file::{LayoutFile, parse_layout};
use city::why::{Answer, explain, find};
use city::{Built, Cancel, Settings, Silent, build};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, OnceLock};

/// What there is to answer from, made once for a city.
#[derive(Debug, Default)]
struct Evidence {
    layout: OnceLock<Result<LayoutFile, String>>,
    traced: OnceLock<Result<Built, String>>,
}

/// A question and its answer.
#[derive(Debug, Default)]
pub struct Asked {
    evidence: Arc<Evidence>,
    waiting: Option<Receiver<Result<Answer, String>>>,
    /// The answer, or why there is none.
    pub answer: Option<Result<Answer, String>>,
}

impl Asked {
    /// Asks about something.
    pub fn ask(&mut self, ready: Arc<Ready>, element: &Element, wake: Wake) {
        let (sender, receiver) = channel();
        let (evidence, id) = (self.evidence.clone(), element.id.to_string());
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

    /// What was asked is no longer of interest, and of another city from now on.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

fn answer(evidence: &Evidence, ready: &Ready, id: &str) -> Result<Answer, String> {
    let layout = evidence.layout.get_or_init(|| {
        let mut bytes = Vec::new();
        write_layout(&ready.built.city, &mut bytes).map_err(|error| error.to_string())?;
        parse_layout(&bytes, std::path::Path::new("layout.geojson")).map_err(|error| error.to_string())
    });
    let layout = layout.as_ref().map_err(String::clone)?;
    let traced = evidence.traced.get_or_init(|| {
        let settings = Settings { traces: true, ..Settings::default() };
        build(&ready.sources, settings, &Silent, &Cancel::default()).map_err(|error| error.to_string())
    });
    let traced = traced.as_ref().map_err(String::clone)?;
    let found = find(layout, id).map_err(|error| error.to_string())?;
    Ok(explain(&found, layout, &ready.sources, traced))
}
