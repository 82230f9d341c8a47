//! `import`: only inside the libraries, never in a circle, each file read once.

use super::engine::{Closures, compile};
use super::library::{Shelves, Source, Texts};
use super::spending::{spend, spent};
use crate::account::Account;
use crate::fault::{Complaint, Fault};
use crate::rule::Surroundings;
use geom::Id;
use rhai::{AST, Engine, EvalAltResult, GlobalRuntimeState, Module, ModuleResolver, Position, Scope, Shared};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// A file that was read: its name and the hash of its text.
pub(crate) type Reading = (String, Id);

/// A loaded module with all files that went into it.
#[derive(Clone, Debug)]
struct Loaded {
    module: Shared<Module>,
    readings: BTreeSet<Reading>,
    /// What loading it took, and takes whoever imports it, also when it is known already: limits do not hang on who came
    /// first.
    operations: u64,
}

/// Modules loaded so far, shared by all engines of a host.
pub(crate) type Modules = Arc<RwLock<BTreeMap<String, LoadedModule>>>;

/// Opaque to all but the resolver.
#[derive(Clone, Debug)]
pub(crate) struct LoadedModule(Loaded);

/// Imports deeper than this are refused: each level needs stack.
const DEEPEST: usize = 12;
/// What an import takes of the operations that a script has, also one that fails: finding a file takes time.
const OPERATIONS: u64 = 1_000;
/// Bytes of a file that take an operation to read.
const BYTES: u64 = 10;

thread_local! {
    /// The files being loaded on this thread, outermost first, each with what it has read so far.
    static OPEN: RefCell<Vec<(String, BTreeSet<Reading>)>> = const { RefCell::new(Vec::new()) };
}

/// Resolves imports for one script.
#[derive(Clone, Debug)]
pub(crate) struct Resolver {
    shelves: Shelves,
    texts: Texts,
    modules: Modules,
    /// Takes in what they do, where somebody asks.
    account: Option<Account>,
    /// What the script has imported, directly or not.
    readings: Arc<Mutex<BTreeSet<Reading>>>,
}

impl Resolver {
    /// A resolver over the libraries around a script, sharing what is loaded.
    pub fn new(around: &Surroundings) -> Self {
        let Surroundings { shelves, texts, modules, account, .. } = around.clone();
        Self { shelves, texts, modules, account, readings: Arc::default() }
    }

    /// Everything imported so far.
    pub fn readings(&self) -> BTreeSet<Reading> {
        self.readings.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn load(&self, engine: &Engine, level: usize, name: &str) -> Result<Loaded, Box<EvalAltResult>> {
        let known = self.modules.read().unwrap_or_else(PoisonError::into_inner).get(name).cloned();
        if let Some(LoadedModule(loaded)) = known {
            spend(loaded.operations);
            return Ok(loaded);
        }
        let _open = Opened::new(name)?;
        let loaded = self.read(engine, level, name)?;
        let mut modules = self.modules.write().unwrap_or_else(PoisonError::into_inner);
        modules.insert(name.to_owned(), LoadedModule(loaded.clone()));
        Ok(loaded)
    }

    fn read(&self, engine: &Engine, level: usize, name: &str) -> Result<Loaded, Box<EvalAltResult>> {
        let before = spent();
        spend(OPERATIONS);
        let source = self.shelves.read(name).map_err(complaint_of)?;
        spend(source.text.len() as u64 / BYTES);
        self.texts.keep(&source);
        let inside = |error| EvalAltResult::ErrorInModule(source.path.clone(), error, Position::NONE);
        let mut ast = compile(engine, &source.text, Closures::Closed).map_err(inside)?;
        ast = self.telling(engine, &source, ast);
        ast.set_source(source.path.as_str());
        let module = evaluated(engine, level, &ast).map_err(inside)?;
        let mut readings =
            OPEN.with_borrow_mut(|open| open.last_mut().map(|(_, r)| std::mem::take(r))).unwrap_or_default();
        readings.insert((name.to_owned(), Id::of_text("script", &source.text)));
        Ok(Loaded { module: module.into(), readings, operations: (spent() - before).unsigned_abs() })
    }
}

impl Resolver {
    /// The same script, telling what it does where somebody asks and it can be told.
    fn telling(&self, engine: &Engine, source: &Source, ast: AST) -> AST {
        let Some(account) = &self.account else { return ast };
        compile(engine, &account.telling(source, &ast), Closures::Closed).unwrap_or(ast)
    }
}

/// Runs a file on what is left of the call levels of the script that imports it.
fn evaluated(engine: &Engine, level: usize, ast: &AST) -> Result<Module, Box<EvalAltResult>> {
    let mut own = engine.new_global_runtime_state();
    own.level = level;
    Module::eval_ast_as_new_raw(engine, &mut Scope::new(), &mut own, ast)
}

impl ModuleResolver for Resolver {
    fn resolve(
        &self,
        engine: &Engine,
        _: Option<&str>,
        path: &str,
        at: Position,
    ) -> Result<Shared<Module>, Box<EvalAltResult>> {
        self.resolve_raw(engine, &mut engine.new_global_runtime_state(), &mut Scope::new(), path, at)
    }

    fn resolve_raw(
        &self,
        engine: &Engine,
        around: &mut GlobalRuntimeState,
        _: &mut Scope<'_>,
        path: &str,
        at: Position,
    ) -> Result<Shared<Module>, Box<EvalAltResult>> {
        let name = path.strip_suffix(".rhai").unwrap_or(path);
        let loaded = self.load(engine, around.level, name).map_err(|mut error| {
            if error.position().is_none() && !matches!(*error, EvalAltResult::ErrorInModule(..)) {
                error.set_position(at);
            }
            error
        })?;
        OPEN.with_borrow_mut(|open| {
            if let Some((_, readings)) = open.last_mut() {
                readings.extend(loaded.readings.iter().cloned());
            }
        });
        self.readings.lock().unwrap_or_else(PoisonError::into_inner).extend(loaded.readings);
        Ok(loaded.module)
    }
}

fn complaint_of(fault: Fault) -> Box<EvalAltResult> {
    Complaint::new(format!("cannot import `{}`: {}", fault.file, fault.message)).maybe_hint(fault.hint).into()
}

/// A file on the stack of those being loaded; leaves it when dropped.
struct Opened;

impl Opened {
    fn new(name: &str) -> Result<Self, Box<EvalAltResult>> {
        OPEN.with_borrow_mut(|open| {
            if let Some(start) = open.iter().position(|(file, _)| file == name) {
                let circle: Vec<&str> = open[start..].iter().map(|(file, _)| file.as_str()).chain([name]).collect();
                let help = "move what both need into a file that imports neither";
                return Err(Complaint::new(format!("imports go in a circle: {}", circle.join(" → ")))
                    .hint(help)
                    .into());
            }
            if open.len() >= DEEPEST {
                return Err(Complaint::new("imports are nested too deeply")
                    .hint("import fewer files from files")
                    .into());
            }
            open.push((name.to_owned(), BTreeSet::new()));
            Ok(Self)
        })
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        OPEN.with_borrow_mut(|open| drop(open.pop()));
    }
}
