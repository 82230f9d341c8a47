//! A console that runs Rhai on the open city, on a thread of its own: what was typed, and what came of it.

use crate::evidence::Evidence;
use crate::scene::Element;
use crate::worker::{Ready, Wake};
use city::testing::{STACK, bench_in};
use city::{FaultReport, Loaded};
use script::testing::Console as Scripts;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Most answers that stay.
const MOST: usize = 500;

/// A text that was run.
#[derive(Clone, Debug, Default)]
pub struct Entry {
    /// What was typed.
    pub text: String,
    /// What it printed.
    pub printed: Vec<String>,
    /// Its value.
    pub value: Option<String>,
    /// What was wrong.
    pub fault: Option<FaultReport>,
}

/// What is asked of the thread.
struct Question {
    text: String,
    ready: Arc<Ready>,
    evidence: Arc<Evidence>,
    picked: Option<Element>,
}

/// What was typed so far, and what is being typed.
#[derive(Default)]
pub struct Console {
    /// What was run, the last one at the end.
    pub entries: Vec<Entry>,
    /// What is being typed.
    pub text: String,
    /// The place of what is shown among all that was typed, while people go through that.
    recalled: Option<usize>,
    /// Texts that are still to be answered.
    waiting: usize,
    thread: Option<(Sender<Question>, Receiver<Entry>)>,
}

impl Console {
    /// Runs what was typed on a city, and what is picked in it.
    pub fn run(&mut self, ready: &Arc<Ready>, evidence: &Arc<Evidence>, picked: Option<&Element>, wake: &Wake) {
        let text = std::mem::take(&mut self.text);
        self.recalled = None;
        if text.trim().is_empty() {
            return;
        }
        if self.thread.is_none() {
            self.thread = start(wake.clone());
        }
        let (ready, evidence) = (ready.clone(), evidence.clone());
        let question = Question { text: text.clone(), ready, evidence, picked: picked.cloned() };
        let is_sent = self.thread.as_ref().is_some_and(|(questions, _)| questions.send(question).is_ok());
        if is_sent {
            self.waiting += 1;
        } else {
            // Where it ended, the next text starts another.
            self.thread = None;
            let printed = vec!["the console could not be started: run this again".to_owned()];
            self.keep(Entry { text, printed, ..Entry::default() });
        }
    }

    /// Takes in answers that are there.
    pub fn catch_up(&mut self) {
        let answers: Vec<Entry> = self.thread.iter().flat_map(|(_, answers)| answers.try_iter()).collect();
        for entry in answers {
            self.waiting = self.waiting.saturating_sub(1);
            self.keep(entry);
        }
    }

    fn keep(&mut self, entry: Entry) {
        self.entries.push(entry);
        if self.entries.len() > MOST {
            self.entries.remove(0);
        }
    }

    /// Whether an answer is on its way.
    pub fn is_busy(&self) -> bool {
        self.waiting > 0
    }

    /// Shows what was typed before, or after, what is shown.
    pub fn recall(&mut self, back: bool) {
        let count = self.entries.len();
        let at = self.recalled.unwrap_or(count);
        let at = if back { at.saturating_sub(1) } else { (at + 1).min(count) };
        self.recalled = (at < count).then_some(at);
        self.text = self.entries.get(at).map(|entry| entry.text.clone()).unwrap_or_default();
    }
}

/// Starts the thread; `None` where there is none to be had.
fn start(wake: Wake) -> Option<(Sender<Question>, Receiver<Entry>)> {
    let (questions, asked) = channel::<Question>();
    let (sender, answers) = channel();
    let thread = std::thread::Builder::new().name("console".into()).stack_size(STACK);
    let spawned = thread.spawn(move || {
        let mut bench: Option<Bench> = None;
        for question in asked {
            let entry = Bench::of(&mut bench, &question).answer(&question);
            if sender.send(entry).is_err() {
                return;
            }
            wake();
        }
    });
    spawned.ok().map(|_| (questions, answers))
}

/// Where texts are run: on a city, until there is another.
struct Bench {
    round: u64,
    scripts: Scripts,
}

impl Bench {
    /// The bench of a city: the one there is, brought up to date.
    fn of<'a>(known: &'a mut Option<Self>, question: &Question) -> &'a mut Self {
        let Loaded { host, folder, .. } = &question.ready.as_written;
        let (round, bench) = (question.ready.round, bench_in(folder.clone()));
        let own = known.get_or_insert_with(|| Self { round, scripts: Scripts::new(host, &bench) });
        if own.round != round {
            own.scripts.renew(host, &bench);
            own.round = round;
        }
        own
    }

    fn answer(&mut self, question: &Question) -> Entry {
        let id = question.picked.as_ref().map(|element| (element.kind.name(), element.id.to_string()));
        let town = question.evidence.town(&question.ready);
        self.scripts.look_at(town, id.as_ref().map(|(kind, id)| (*kind, id.as_str())));
        let reply = self.scripts.run(&question.text);
        Entry {
            text: question.text.clone(),
            printed: reply.printed,
            value: reply.value,
            fault: reply.fault.as_ref().map(FaultReport::from),
        }
    }
}
