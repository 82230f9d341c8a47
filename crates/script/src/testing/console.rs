//! A console: lines of Rhai with the words of tests, about a town that is there already.

use super::desk::Desk;
use super::town::TownHandle;
use super::{Bench, Town, answer, engine_of};
use crate::Host;
use crate::fault::{Diagnosis, Fault, of_error, of_panic};
use crate::host::{Closures, Limits, Source, Spending, Vocabulary, compile_within};
use crate::rule::Surroundings;
use rhai::{AST, Dynamic, Engine, EvalAltResult, Scope};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// What faults call the text that was typed.
const FILE: &str = "console";

/// Longest value that is told, in characters.
const LONGEST: usize = 20_000;

/// What came of a text.
#[derive(Clone, Debug, Default)]
pub struct Reply {
    /// What it printed.
    pub printed: Vec<String>,
    /// Its value, as text; none where it has none.
    pub value: Option<String>,
    /// What was wrong with it.
    pub fault: Option<Fault>,
}

/// Runs text about a town, `city`, one piece after the other: variables and functions stay.
pub struct Console {
    engine: Engine,
    desk: Desk,
    around: Surroundings,
    scope: Scope<'static>,
    functions: AST,
}

impl fmt::Debug for Console {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Console").field("variables", &self.scope.len()).finish_non_exhaustive()
    }
}

impl Console {
    /// A console with the rules of a host.
    pub fn new(host: &Host, bench: &Bench) -> Self {
        let desk = Desk::new(FILE, None);
        let around = host.around.sharing();
        let engine = engine_of(&desk, &around, bench, FILE, "", Limits::CONSOLE);
        Self { engine, desk, around, scope: Scope::new(), functions: AST::empty() }
    }

    /// Takes the rules of another host, as they are now; variables and functions stay.
    pub fn renew(&mut self, host: &Host, bench: &Bench) {
        self.around = host.around.sharing();
        self.engine = engine_of(&self.desk, &self.around, bench, FILE, "", Limits::CONSOLE);
    }

    /// Lets `city` be a town, and `picked` one of its features, told by kind and id, where one is picked.
    pub fn look_at(&mut self, town: Arc<dyn Town>, picked: Option<(&str, &str)>) {
        let handle = TownHandle::new(town, self.desk.clone());
        let picked = picked.map_or(Dynamic::UNIT, |(kind, id)| handle.feature(kind, id));
        self.scope.set_value("city", handle);
        self.scope.set_value("picked", picked);
    }

    /// Runs a text, within limits.
    pub fn run(&mut self, text: &str) -> Reply {
        self.around.texts.keep(&Source { text: text.to_owned(), path: FILE.into() });
        let _spending = Spending::start();
        let ran = catch_unwind(AssertUnwindSafe(|| self.value(text)));
        let (value, fault) = match ran {
            Ok(Ok(value)) => ((!value.is_unit()).then(|| told(&value)), None),
            Ok(Err(error)) => (None, Some(self.fault_of(*error).measured(&self.around.texts))),
            Err(panic) => (None, Some(of_panic(FILE, &*panic))),
        };
        self.desk.settle();
        self.desk.print(self.around.notes());
        Reply { printed: self.desk.outcome(None).printed, value, fault }
    }

    fn value(&mut self, text: &str) -> Result<Dynamic, Box<EvalAltResult>> {
        let mut ast = compile_within(&self.engine, &self.scope, text, Closures::InPlace)?;
        ast.set_source(FILE);
        let whole = self.functions.merge(&ast);
        let before = self.scope.len();
        let value = self.engine.eval_ast_with_scope::<Dynamic>(&mut self.scope, &whole);
        match value {
            Ok(value) => {
                self.functions = self.functions.merge(&ast.clone_functions_only());
                Ok(value)
            }
            Err(error) => {
                // What failed leaves nothing behind.
                self.scope.rewind(before);
                Err(error)
            }
        }
    }

    fn fault_of(&self, error: EvalAltResult) -> Fault {
        let diagnosis = Diagnosis {
            file: FILE,
            texts: &self.around.texts,
            vocabulary: &Vocabulary::of(&self.engine, &self.functions),
            operations: Limits::CONSOLE.operations,
        };
        of_error(error, &diagnosis)
    }
}

/// A value as a console tells it: lists and maps by line.
fn told(value: &Dynamic) -> String {
    let text = answer::text(value);
    let text = text.trim_end_matches('\n');
    match text.char_indices().nth(LONGEST) {
        Some((at, _)) => format!("{}\n… ({} characters in all)", &text[..at], text.chars().count()),
        None => text.to_owned(),
    }
}
