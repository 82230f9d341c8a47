//! Tests of rules, written in Rhai beside them: `fn test_…()` in `grid.test.rhai`, or in the rule's own file.
//!
//! A test asks a rule about one street end, block or parcel, or grows a small town with it, and claims something of the
//! answer. Towns are built by whoever implements [`Laboratory`]; this crate builds nothing.

mod answer;
mod ask;
mod claim;
mod console;
mod coverage;
mod desk;
mod place;
mod standard;
mod town;
mod trial;

pub use console::{Console, Reply};
pub use coverage::{Branch, Coverage};
pub use desk::Snapshot;
pub(crate) use standard::{SIDE, features_of, standard_site};
pub use town::{Datum, Feature, Laboratory, Town, TownError};
pub use trial::Trial;

use crate::city::{SiteInfo, SiteRequest, Sites, missing_rule_at, register_words};
use crate::fault::{Diagnosis, Fault, column_of, of_error, of_panic};
use crate::host::{
    Closures, Limits, Resolver, Source, Spending, Vocabulary, compile, engine, miscounted_calls, named_rules,
    unknown_options, unknown_words,
};
use crate::param::{Declared, register as register_params};
use crate::plan::Plan;
use crate::rule::{Rule, Surroundings};
use crate::words;
use desk::Desk;
use rhai::{AST, CallFnOptions, Dynamic, Engine, EvalAltResult, Scope};
use std::any::TypeId;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// What the functions of tests begin with.
const PREFIX: &str = "test_";

/// How the names of files with nothing but tests end, before `.rhai`.
const BESIDE: &str = ".test";

/// The name of the rule that a file's tests are about: `streets/grid` for `streets/grid.test`.
pub fn rule_tested(name: &str) -> &str {
    name.strip_suffix(BESIDE).unwrap_or(name)
}

/// Whether a file of that name holds nothing but tests.
pub fn is_beside(name: &str) -> bool {
    name.ends_with(BESIDE)
}

/// What tests work with.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Builds towns.
    pub laboratory: Arc<dyn Laboratory>,
    /// Tells what folders of maps hold.
    pub sites: Arc<dyn Sites>,
}

impl Bench {
    /// Builds nothing, and knows no folder: enough to read tests.
    pub fn bare() -> Self {
        Self { laboratory: Arc::new(Nowhere), sites: Arc::new(Nowhere) }
    }
}

/// Where nothing is built and nothing lies.
#[derive(Debug)]
struct Nowhere;

impl Laboratory for Nowhere {
    fn build(&self, _: Plan) -> Result<Arc<dyn Town>, TownError> {
        Err(TownError { message: "nothing is built here".into(), hint: None, fault: None })
    }
}

impl Sites for Nowhere {
    fn site(&self, request: &SiteRequest) -> Result<SiteInfo, String> {
        Err(format!("there is no folder `{}`", request.folder))
    }
}

/// A file with tests.
#[derive(Clone, Debug)]
pub struct TestFile {
    source: Source,
    rule: String,
    ast: AST,
    bench: Bench,
    around: Surroundings,
    tests: Vec<Test>,
}

/// A test of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Test {
    /// Its function, without `test_`.
    pub name: String,
    /// The line it begins in.
    pub line: u32,
    /// Whether it takes a trial.
    pub is_random: bool,
}

/// What came of a test.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// What was wrong; none where every claim held.
    pub fault: Option<Fault>,
    /// What is to be compared with files, in the order of the test.
    pub snapshots: Vec<Snapshot>,
    /// What it printed.
    pub printed: Vec<String>,
    /// The numbers that the test drew from its trial, with where they began.
    pub drawn: Vec<(u64, f64, f64)>,
}

impl TestFile {
    /// Reads the tests of a file, which may have none.
    ///
    /// # Errors
    /// What is wrong in it, found without running a test: at least one fault.
    pub(crate) fn load(name: &str, source: &Source, around: &Surroundings, bench: Bench) -> Result<Self, Vec<Fault>> {
        around.texts.keep(source);
        let mut file = Self {
            source: source.clone(),
            rule: rule_tested(name).to_owned(),
            ast: AST::empty(),
            bench,
            around: around.clone(),
            tests: Vec::new(),
        };
        let engine = file.engine(&Desk::default(), around);
        let compiled = compile(&engine, &source.text, Closures::InPlace);
        let early = |error: EvalAltResult| file.fault_of(error, &engine);
        let mut ast = compiled.map_err(|error| vec![early(*error)])?;
        ast.set_source(source.path.as_str());
        file.tests = tests_of(&ast);
        file.ast = ast;
        if file.tests.is_empty() && !is_beside(name) {
            return Ok(file);
        }
        let words = Vocabulary::of(&engine, &file.ast);
        let mut faults = unknown_words(&file.ast, &source.path, &words);
        faults.extend(miscounted_calls(&file.ast, &source.path, &words));
        if !faults.is_empty() {
            return Err(faults.into_iter().map(|fault| fault.measured(&around.texts)).collect());
        }
        if file.tests.is_empty() {
            let help = "write `fn test_…() { assert(…); }`, or with a trial `fn test_…(trial)`";
            return Err(vec![Fault::new(&source.path, "there is no test in this file").with_hint(Some(help.into()))]);
        }
        Ok(file)
    }

    /// Rules that tests ask for and that are not there, and parameters that they do not have.
    pub(crate) fn misnamed_rules(&self) -> Vec<Fault> {
        let words = Vocabulary::of(&self.engine(&Desk::default(), &self.around), &self.ast);
        let mut faults = unknown_options(&self.ast, &self.source.path, &self.source.text, &words);
        faults.extend(self.unasked());
        for named in named_rules(&self.ast, &self.source.text) {
            let own = named.name.as_deref().unwrap_or(&self.rule);
            match self.around.shelves.read(own) {
                Err(fault) => faults.push(missing_rule_at(fault, &named, &self.source.path)),
                // What is wrong in the rule is told of its own file.
                Ok(source) => faults.extend(Rule::load(own, &source, &self.around).into_iter().flat_map(|rule| {
                    let known: Vec<&str> = rule.params().iter().map(|(param, _)| param.name.as_str()).collect();
                    let unknown = named.unknown_parameters(&known, &self.source.path);
                    let unsuited = named.unsuited_values(rule.params(), &self.source.path);
                    unknown.into_iter().chain(unsuited).collect::<Vec<_>>()
                })),
            }
        }
        faults.into_iter().map(|fault| fault.measured(&self.around.texts)).collect()
    }

    /// Functions that are called like tests, but are none.
    fn unasked(&self) -> Vec<Fault> {
        let is_none = |function: &rhai::ScriptFnMetadata<'_>| {
            function.name.starts_with(PREFIX) && !is_test(function.name, function.params.len())
        };
        let fault = |function: rhai::ScriptFnMetadata<'_>| {
            let body = &self.ast.shared_lib().get_script_fn(function.name, function.params.len())?.body;
            let line = body.start_position().line().unwrap_or(0) as u32;
            let fault = Fault::new(&self.source.path, format!("`{}` is never run", function.name));
            let help = format!("a test takes nothing, fn {0}(), or a trial, fn {0}(trial)", function.name);
            let column = column_of(&self.source.text, line, function.name);
            Some(Fault { line, column, ..fault.with_hint(Some(help)) })
        };
        self.ast.iter_functions().filter(is_none).filter_map(fault).collect()
    }

    /// Its tests, in the order of the text.
    pub fn tests(&self) -> &[Test] {
        &self.tests
    }

    /// The texts of it and of all that its tests have read so far.
    pub fn texts(&self) -> &crate::Texts {
        &self.around.texts
    }

    /// The rule they are about, as city scripts name it.
    pub fn rule(&self) -> &str {
        &self.rule
    }

    /// Runs a test, for a trial where it takes one. The same for any thread.
    pub fn run(&self, test: &Test, trial: Option<&Trial>) -> Outcome {
        let desk = Desk::new(&test.name, trial);
        let around = self.around.sharing();
        let engine = self.engine(&desk, &around);
        let call = || {
            let function = format!("{PREFIX}{}", test.name);
            let mut scope = Scope::new();
            let options = CallFnOptions::new();
            let argument = desk.trial_handle();
            match test.is_random {
                true => engine.call_fn_with_options::<Dynamic>(options, &mut scope, &self.ast, &function, (argument,)),
                false => engine.call_fn_with_options::<Dynamic>(options, &mut scope, &self.ast, &function, ()),
            }
        };
        let _spending = Spending::start();
        let fault = match catch_unwind(AssertUnwindSafe(call)) {
            Ok(Ok(_)) => None,
            Ok(Err(error)) => Some(self.in_test(self.fault_of(*error, &engine), test)),
            Err(panic) => Some(of_panic(&self.source.path, &*panic)),
        };
        desk.print(around.notes());
        desk.outcome(fault)
    }

    /// A fault told in the test itself: its own call says nothing.
    fn in_test(&self, mut fault: Fault, test: &Test) -> Fault {
        let own = format!("{PREFIX}{}", test.name);
        fault.calls.retain(|call| call.function != own);
        // Rhai forgets where a limit was hit.
        if fault.line == 0 {
            fault.line = test.line;
        }
        fault
    }

    fn engine(&self, desk: &Desk, around: &Surroundings) -> Engine {
        engine_of(desk, around, &self.bench, &self.source.path, &self.rule, Limits::TEST)
    }

    fn fault_of(&self, error: EvalAltResult, engine: &Engine) -> Fault {
        let diagnosis = Diagnosis {
            file: &self.source.path,
            texts: &self.around.texts,
            vocabulary: &Vocabulary::of(engine, &self.ast),
            operations: Limits::TEST.operations,
        };
        of_error(error, &diagnosis)
    }
}

/// An engine with the words of tests, for a script about a rule.
fn engine_of(desk: &Desk, around: &Surroundings, bench: &Bench, path: &str, rule: &str, limits: Limits) -> Engine {
    let resolver = Resolver::new(around);
    let mut engine = engine(limits, resolver);
    // A rule's own file declares parameters: here nobody asks for them.
    register_params(&mut engine, path, Declared::default());
    words::register(&mut engine);
    words::marks::register(&mut engine, &words::marks::Marks::default());
    register_words(&mut engine, around.clone(), bench.sites.clone());
    ask::register(&mut engine, desk, around, rule);
    town::register(&mut engine, desk, around, bench.laboratory.clone());
    standard::register(&mut engine);
    claim::register(&mut engine, desk);
    trial::register(&mut engine);
    desk.listen(&mut engine);
    engine
}

/// An engine with all words of tests: for the reference.
pub(crate) fn word_engine() -> Engine {
    engine_of(&Desk::default(), &crate::Host::new(Vec::new()).around, &Bench::bare(), "", "", Limits::TEST)
}

/// The type of towns in tests.
pub(crate) fn town_type() -> TypeId {
    TypeId::of::<town::TownHandle>()
}

/// The tests among the functions of a script, in the order of the text.
fn tests_of(ast: &AST) -> Vec<Test> {
    let line = |name: &str, arguments: usize| {
        let function = ast.shared_lib().get_script_fn(name, arguments)?;
        function.body.start_position().line().map(|line| line as u32)
    };
    let test = |function: rhai::ScriptFnMetadata<'_>| {
        let name = function.name.strip_prefix(PREFIX).filter(|_| is_test(function.name, function.params.len()))?;
        let line = line(function.name, function.params.len()).unwrap_or(0);
        Some(Test { name: name.to_owned(), line, is_random: !function.params.is_empty() })
    };
    let mut tests: Vec<Test> = ast.iter_functions().filter_map(test).collect();
    tests.sort_by_key(|test| test.line);
    tests
}

/// Whether a function is a test rather than a part of a rule.
pub(crate) fn is_test(name: &str, arguments: usize) -> bool {
    name.starts_with(PREFIX) && name.len() > PREFIX.len() && arguments <= 1
}
