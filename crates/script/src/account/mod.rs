//! What a rule does when it is asked, step by step: for saying how one element of a city came to be.
//!
//! Rhai does not say what it runs. So a rule that is to tell it is read once more from a text in which each place worth telling
//! hands on its value ([`sites`]); what is read, asked for and computed there is the same.

mod sites;

use crate::host::{Source, kind_of};
use geom::Vec2;
use rhai::{AST, Array, Dynamic, Engine, Map};
use sites::{Site, with_calls};
use std::collections::{BTreeSet, VecDeque};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The word that tells. No identifier that a person writes.
const TELL: &str = "told__";
/// The same behind a statement: it has no value, as what it stands behind may be the last of its block.
const TELL_BEHIND: &str = "told_behind__";
/// Steps that are kept from the first on, of those behind that did something or printed, and up to the last.
const FIRST_STEPS: usize = 200;
const DOING_STEPS: usize = 100;
const LAST_STEPS: usize = 100;
/// Letters of a value that are told.
const LONGEST: usize = 80;
/// Values of a list that are told one by one.
const MOST_VALUES: usize = 6;

/// What a step was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// Something was read, asked, computed or decided.
    Value,
    /// A condition was tested.
    Test,
    /// The rule printed something.
    Print,
}

/// One thing that a rule did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// The file, as messages call it.
    pub file: Arc<str>,
    /// The line, from 1.
    pub line: u32,
    /// What it was.
    pub kind: StepKind,
    /// As it is written in the rule, on one line.
    pub text: String,
    /// What came of it; nothing where that has no value.
    pub value: Option<String>,
}

impl Step {
    /// Whether it printed, marked a place or told what is to be done: such a call has no value.
    fn does_something(&self) -> bool {
        self.kind == StepKind::Print || self.value.is_none()
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.value, self.kind) {
            (None, _) => f.write_str(&self.text),
            (Some(value), StepKind::Value) => write!(f, "{} = {value}", self.text),
            (Some(value), StepKind::Test) => {
                write!(f, "{}: {}", self.text, if value == "true" { "yes" } else { "no" })
            }
            (Some(value), StepKind::Print) => write!(f, "{}: {value}", self.text),
        }
    }
}

/// What a rule tells. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Account(Arc<Mutex<Told>>);

#[derive(Debug, Default)]
struct Told {
    sites: Vec<(Arc<str>, Site)>,
    told: Telling,
    /// What is told once only.
    once: BTreeSet<(String, String)>,
}

/// What a rule told of one call, or of several.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Telling {
    /// The first steps.
    pub first: Vec<Step>,
    /// How many steps after them were left out.
    pub left_out: usize,
    /// Steps from among those that printed, marked a place or told what is to be done.
    pub doing: Vec<Step>,
    /// The last steps.
    pub last: VecDeque<Step>,
}

impl Telling {
    /// All steps that there are.
    pub fn steps(&self) -> impl Iterator<Item = &Step> {
        self.first.iter().chain(&self.doing).chain(&self.last)
    }

    fn add(&mut self, step: Step) {
        if self.first.len() < FIRST_STEPS {
            return self.first.push(step);
        }
        self.last.push_back(step);
        if self.last.len() > LAST_STEPS {
            match self.last.pop_front() {
                Some(step) if step.does_something() && self.doing.len() < DOING_STEPS => self.doing.push(step),
                _ => self.left_out += 1,
            }
        }
    }
}

impl Account {
    /// What was told since this was asked last.
    pub fn take(&self) -> Telling {
        let mut told = self.lock();
        told.once.clear();
        std::mem::take(&mut told.told)
    }

    /// Gives an engine the word that tells.
    pub(crate) fn register(&self, engine: &mut Engine) {
        let account = self.clone();
        engine.register_fn(TELL, move |site: i64, value: Dynamic| {
            account.tell(site, &value);
            value
        });
        let account = self.clone();
        engine.register_fn(TELL_BEHIND, move |site: i64, value: Dynamic| account.tell(site, &value));
    }

    /// The text of a script that tells what it does. Lines stay where they are.
    pub(crate) fn telling(&self, source: &Source, ast: &AST) -> String {
        let path: Arc<str> = source.path.as_str().into();
        let mut told = self.lock();
        let (text, sites) = with_calls(&source.text, ast, told.sites.len());
        told.sites.extend(sites.into_iter().map(|site| (path.clone(), site)));
        text
    }

    fn tell(&self, site: i64, value: &Dynamic) {
        let mut told = self.lock();
        let Some((file, site)) = usize::try_from(site).ok().and_then(|site| told.sites.get(site)).cloned() else {
            return;
        };
        let value = site.shows.then(|| value_says(value, site.kind)).flatten();
        let is_read = site.kind == StepKind::Value && site.is_read;
        if is_read && !told.once.insert((site.text.clone(), value.clone().unwrap_or_default())) {
            return;
        }
        told.told.add(Step { file, line: site.line, kind: site.kind, text: site.text, value });
    }

    fn lock(&self) -> MutexGuard<'_, Told> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A value as people read it; nothing for what has none.
fn value_says(value: &Dynamic, kind: StepKind) -> Option<String> {
    if value.is_unit() {
        return None;
    }
    let text = value.read_lock::<rhai::ImmutableString>().map(|text| text.to_string());
    let said = match text {
        Some(text) if kind == StepKind::Print => text,
        Some(text) => format!("{text:?}"),
        None => plain(value),
    };
    Some(cut(&said, LONGEST))
}

/// A value that is no text.
fn plain(value: &Dynamic) -> String {
    if let Ok(number) = value.as_float() {
        return number_says(number);
    }
    if let Some(list) = value.read_lock::<Array>() {
        let said: Vec<String> = list.iter().take(MOST_VALUES).map(element).collect();
        let more = if list.len() > MOST_VALUES { format!(", … {} in all", list.len()) } else { String::new() };
        return format!("[{}{more}]", said.join(", "));
    }
    if let Some(map) = value.read_lock::<Map>() {
        let said: Vec<String> =
            map.iter().take(MOST_VALUES).map(|(key, value)| format!("{key}: {}", element(value))).collect();
        return format!("#{{ {} }}", said.join(", "));
    }
    if value.is_int() || value.is_bool() || value.is_char() {
        return value.to_string();
    }
    if let Some(map) = value.read_lock::<crate::plan::MapRef>() {
        return format!("map `{}`", map.name);
    }
    if let Some(peak) = value.read_lock::<streets::growth::Peak>() {
        return place_says(peak.at);
    }
    kind_of(value)
}

/// A value within another.
fn element(value: &Dynamic) -> String {
    value_says(value, StepKind::Value).unwrap_or_else(|| "()".into())
}

fn place_says(at: Vec2) -> String {
    format!("({}, {})", number_says(at.x), number_says(at.y))
}

/// A number with a point, and six digits that count.
fn number_says(number: f64) -> String {
    if !number.is_finite() {
        return if number.is_nan() {
            "not a number".into()
        } else {
            format!("{}endless", if number < 0.0 { "-" } else { "" })
        };
    }
    let digits = if number == 0.0 { 0 } else { libm::log10(number.abs()).floor() as i32 };
    let decimals = usize::try_from(5 - digits).unwrap_or(0).clamp(1, 12);
    let said = format!("{number:.decimals$}");
    let plain = said.trim_end_matches('0');
    // It is no whole number, even where it looks like one: a `switch` tells them apart.
    if plain.ends_with('.') { format!("{plain}0") } else { plain.to_owned() }
}

/// At most so many letters of a text.
fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests;
