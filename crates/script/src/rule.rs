//! A rule: one loaded Rhai file with the values of its parameters.

use crate::account::Account;
use crate::fault::{Diagnosis, Fault, Severity, column_of, key_position, of_error, of_panic, plural};
use crate::host::{
    AskedMap, Closures, Limits, Modules, Reading, Resolver, Settling, Shelves, Source, Spending, Texts, Vocabulary,
    asked_maps, assigned_properties, declared_in, engine, first_call, imported_files, miscounted_calls,
    misplaced_params, properties, rebinds, refuse_captures, undeclared, unknown_imported, unknown_methods,
    unknown_options, unknown_properties, unknown_words,
};
use crate::names::{hint, nearest};
use crate::param::{Declared, Literal, ParamError, ParamSet, Params, register as register_params};
use crate::testing::{Coverage, is_test};
use crate::words;
use crate::words::Marked;
use crate::words::marks::{Marks, register as register_marks};
use geom::{Digest, Id, Vec2};
use rhai::{
    AST, ASTNode, Caches, Dynamic, Engine, EvalAltResult, EvalContext, Expr, Expression, GlobalRuntimeState,
    ImmutableString, Locked, Position, Scope, Shared, Stmt, StmtBlock,
};
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

/// What a rule decides: each kind is a function with a fixed name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RuleKind {
    /// `propose(tip, p)`: how streets grow.
    Streets,
    /// `goals(p)`: where streets want to be.
    Goals,
    /// `constraints(p)`: what a street must keep to.
    Constraints,
    /// `constrain(segment, p)`: whether one street may be laid, and how.
    Constrain,
    /// `subdivide(block, p)`: how a block becomes parcels.
    Parcels,
    /// `assign(parcel, p)`: what a parcel is for. A rule with `subdivide` may have it, too.
    Assign,
    /// `build(shape, p)`: what stands on a parcel.
    Buildings,
}

impl RuleKind {
    /// All kinds.
    pub const ALL: [Self; 7] =
        [Self::Streets, Self::Goals, Self::Constraints, Self::Constrain, Self::Parcels, Self::Assign, Self::Buildings];

    /// What it is called where a kind is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Streets => "streets",
            Self::Goals => "goals",
            Self::Constraints => "constraints",
            Self::Constrain => "constrain",
            Self::Parcels => "parcels",
            Self::Assign => "assign",
            Self::Buildings => "buildings",
        }
    }

    /// The folder of a library that such rules stand in.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Constrain => Self::Constraints.name(),
            Self::Assign => Self::Parcels.name(),
            kind => kind.name(),
        }
    }

    /// All folders of a library, each once: those of rules, and that of presets.
    pub fn folders() -> Vec<&'static str> {
        let mut folders: Vec<_> = Self::ALL.map(Self::folder).into();
        folders.dedup();
        folders.push(crate::preset::FOLDER);
        folders
    }

    /// The function that makes a file a rule of this kind.
    pub fn function(self) -> &'static str {
        match self {
            Self::Streets => "propose",
            Self::Goals => "goals",
            Self::Constraints => "constraints",
            Self::Constrain => "constrain",
            Self::Parcels => "subdivide",
            Self::Assign => "assign",
            Self::Buildings => "build",
        }
    }

    /// Its arguments.
    pub fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::Streets => &["tip", "p"],
            Self::Goals | Self::Constraints => &["p"],
            Self::Constrain => &["segment", "p"],
            Self::Parcels => &["block", "p"],
            Self::Assign => &["parcel", "p"],
            Self::Buildings => &["shape", "p"],
        }
    }

    /// How the function is written: `propose(tip, p)`.
    pub fn form(self) -> String {
        format!("{}({})", self.function(), self.arguments().join(", "))
    }
}

/// A loaded file: everything that rules made of it share.
struct RuleFile {
    name: String,
    path: String,
    about: String,
    engine: Engine,
    ast: AST,
    /// As it was when the top of the file had run: functions, imports, constants.
    state: GlobalRuntimeState,
    kinds: Vec<RuleKind>,
    /// What it was loaded among, to load it again.
    around: Surroundings,
    notes: Notes,
    marks: Marks,
    readings: BTreeSet<Reading>,
    vocabulary: Vocabulary,
}

/// What rules print, by text. Sorted: threads print in any order.
type Notes = Arc<Mutex<BTreeMap<String, Printed>>>;

/// How often something was printed, and where.
#[derive(Clone, Copy, Debug, Default)]
struct Printed {
    count: u64,
    place: Option<Vec2>,
}

impl Printed {
    /// Once more. Of all places the first stays, by x, then y: threads print in any order.
    fn again(&mut self, at: Option<Vec2>) {
        self.count += 1;
        let order = |at: Vec2| [at.x, at.y];
        let first = |known: Vec2| at.is_some_and(|at| order(at) < order(known));
        if self.place.is_none_or(first) {
            self.place = at;
        }
    }
}

/// Something that a rule printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// What it printed.
    pub text: String,
    /// How often.
    pub count: u64,
    /// Where it was asked when it did, metres: of several places the first, by x, then y.
    pub place: Option<Vec2>,
}

/// How many different notes of a rule are kept.
pub const MOST_NOTES: usize = 200;

/// A rule with parameter values. Cheap to clone; shared by threads.
#[derive(Clone)]
pub struct Rule {
    file: Arc<RuleFile>,
    params: ParamSet,
}

/// What is wrong in a script whatever it comes to when it runs: calls with the wrong number of arguments, options and properties
/// that do not exist.
fn without_running(ast: &AST, path: &str, texts: &Texts, vocabulary: &Vocabulary) -> Vec<Fault> {
    // What is known of a kind says more than what holds of all.
    let mut faults = misasked(ast, path, vocabulary);
    faults.extend(misplaced_params(ast, path));
    add_seen(&mut faults, miscounted_calls(ast, path, vocabulary));
    faults.extend(unknown_options(ast, path, &texts.get(path).unwrap_or_default(), vocabulary));
    faults.extend(misnamed_arguments(ast, path, texts));
    faults
}

/// Warnings of functions of a rule whose first argument is called as that of another kind: what is asked of it is looked for in
/// vain.
fn misnamed_arguments(ast: &AST, path: &str, texts: &Texts) -> Vec<Fault> {
    let text = texts.get(path).unwrap_or_default();
    let subjects: BTreeSet<&str> = RuleKind::ALL.map(|kind| kind.arguments()[0]).into();
    let mut faults = Vec::new();
    for kind in RuleKind::ALL {
        let Some(function) = ast.shared_lib().get_script_fn(kind.function(), kind.arguments().len()) else { continue };
        let (own, given) = (kind.arguments()[0], function.params[0].as_str());
        if given != own && subjects.contains(given) {
            let line = function.body.start_position().line().unwrap_or(0) as u32;
            let message = format!("`{}` is asked about a {own}, not about a {given}", kind.function());
            let fault = Fault::warning(path, message).with_hint(Some(format!("write fn {}", kind.form())));
            faults.push(Fault { line, column: column_of(&text, line, given), ..fault });
        }
    }
    faults
}

/// All that can be seen in a script that cannot be loaded, besides what keeps it from that.
fn seen(ast: &AST, path: &str, around: &Surroundings, vocabulary: &Vocabulary) -> Vec<Fault> {
    let mut faults = unknown_words(ast, path, vocabulary);
    faults.extend(without_running(ast, path, &around.texts, vocabulary));
    let declared = declared_in(ast, &around.texts.get(path).unwrap_or_default());
    faults.extend(undeclared_in(ast, &declared.iter().map(String::as_str).collect::<Vec<_>>(), path));
    faults.sort_by_key(|fault| (fault.line, fault.column));
    faults.into_iter().map(|fault| fault.measured(&around.texts)).collect()
}

/// Adds what was seen to what is known, each place once.
fn add_seen(faults: &mut Vec<Fault>, seen: Vec<Fault>) {
    for fault in seen {
        if faults.iter().all(|known| (known.line, known.column) != (fault.line, fault.column)) {
            faults.push(fault);
        }
    }
}

/// What is asked of `tip`, `block` and their like that they do not have: in the functions that rules consist of, and in others
/// with an argument of that name.
fn misasked(ast: &AST, path: &str, vocabulary: &Vocabulary) -> Vec<Fault> {
    let mut faults = Vec::new();
    let subjects: BTreeSet<&str> = RuleKind::ALL.map(|kind| kind.arguments()[0]).into();
    for Named { own, arguments, statements } in named_functions(ast) {
        let own = own.map(|kind| kind.arguments()[0]);
        for (position, variable) in arguments.into_iter().enumerate() {
            let certain = own.filter(|_| position == 0);
            // What `p` has is known by the rule, not by its type.
            let kind = certain.or_else(|| subjects.get(variable).copied()).filter(|kind| *kind != "p");
            let Some(kind) = kind else { continue };
            if rebinds(&statements, variable) {
                continue;
            }
            let known: BTreeSet<&str> = vocabulary.properties_of(kind).collect();
            let mut found = unknown_properties(&statements, variable, &known, path);
            found.extend(unknown_methods(&statements, (variable, kind), vocabulary, path));
            found.extend(assigned_properties(&statements, variable, path));
            faults.extend(found.into_iter().map(|fault| if certain.is_some() { fault } else { doubtful(fault) }));
        }
    }
    faults.sort_by_key(|fault| (fault.line, fault.column));
    faults.dedup();
    faults
}

/// A function that a script calls by its name.
struct Named<'a> {
    /// What it decides, where it is one of a rule.
    own: Option<RuleKind>,
    arguments: Vec<&'a str>,
    statements: Vec<Stmt>,
}

fn named_functions(ast: &AST) -> impl Iterator<Item = Named<'_>> {
    let named = ast.iter_functions().filter(|function| !function.name.starts_with("anon$"));
    named.filter_map(|function| {
        let body = &ast.shared_lib().get_script_fn(function.name, function.params.len())?.body;
        let statements = statements_between(ast, body.start_position(), body.end_position());
        let is_it =
            |kind: &RuleKind| kind.function() == function.name && kind.arguments().len() == function.params.len();
        Some(Named { own: RuleKind::ALL.into_iter().find(is_it), arguments: function.params, statements })
    })
}

/// What is wrong only where an argument is what it is called.
fn doubtful(fault: Fault) -> Fault {
    Fault { severity: Severity::Warning, ..fault }
}

/// Parameters that functions ask for and that are not declared, of their last argument, or of one called `p`.
fn undeclared_in(ast: &AST, declared: &[&str], path: &str) -> Vec<Fault> {
    let mut faults = Vec::new();
    for Named { own, arguments, statements } in named_functions(ast) {
        let variable = if own.is_some() { arguments.last() } else { arguments.iter().find(|name| **name == "p") };
        let Some(variable) = variable.filter(|variable| !rebinds(&statements, variable)) else { continue };
        let found = undeclared(&statements, variable, declared, path);
        faults.extend(found.into_iter().map(|fault| if own.is_some() { fault } else { doubtful(fault) }));
    }
    faults
}

impl fmt::Debug for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What it does is told as a digest: texts are long.
        let (name, path) = (&self.file.name, &self.file.path);
        f.debug_struct("Rule").field("name", name).field("path", path).field("does", &self.fingerprint()).finish()
    }
}

impl Rule {
    /// Loads a rule: reads its parameters, and finds what is wrong without calling it.
    pub(crate) fn load(name: &str, source: &Source, around: &Surroundings) -> Result<Self, Fault> {
        Self::examine(name, source, around).map_err(|mut faults| faults.swap_remove(0))?.deciding()
    }

    /// The same, unless it has no function of a rule: others may import such a file, but nothing can ask it.
    pub(crate) fn deciding(self) -> Result<Self, Fault> {
        if !self.kinds().is_empty() {
            return Ok(self);
        }
        let forms = RuleKind::ALL.map(RuleKind::form).join(", ");
        Err(decides_nothing(self.path(), format!("a rule has one of the functions {forms}")))
    }

    /// Loads any script of a library, a rule or not, with everything that is wrong: at least one fault. What keeps it from being
    /// loaded comes first, in the order of the text.
    pub(crate) fn examine(name: &str, source: &Source, around: &Surroundings) -> Result<Self, Vec<Fault>> {
        around.texts.keep(source);
        let resolver = Resolver::new(around);
        let (declared, notes) = (Declared::default(), Notes::default());
        let limits = if around.account.is_some() { Limits::TELLING } else { Limits::RULE };
        let mut engine = engine(limits, resolver.clone());
        register_params(&mut engine, &source.path, declared.clone());
        words::register(&mut engine);
        listen(&mut engine, notes.clone());
        let marks = Marks::default();
        register_marks(&mut engine, &marks);
        let ast = match compile(&engine, source, around) {
            Ok(ast) => ast,
            Err(fault) => {
                // Where it is no more than a variable that nobody knows, the rest of the text can be looked at without it.
                engine.set_strict_variables(false);
                let Ok(ast) = compile(&engine, source, around) else { return Err(vec![fault]) };
                Params::register(&mut engine, &declared.seal());
                let vocabulary = Vocabulary::of(&engine, &ast);
                let mut faults = vec![fault];
                add_seen(&mut faults, seen(&ast, &source.path, around, &vocabulary));
                return Err(faults);
            }
        };
        let ast = instrumented(ast, &mut engine, source, around).map_err(|fault| vec![fault])?;
        let outcome = evaluate(&engine, &ast, source, around);
        let outcome = outcome.and_then(|state| Ok((state, kinds_of(&ast, source)?)));
        let params = declared.seal();
        Params::register(&mut engine, &params);
        let vocabulary = Vocabulary::of(&engine, &ast);
        let unknown = unknown_words(&ast, &source.path, &vocabulary).into_iter();
        let mut faults: Vec<Fault> = unknown.map(|fault| fault.measured(&around.texts)).collect();
        let (state, kinds) = match outcome {
            Ok(found) if faults.is_empty() => found,
            told => {
                if let Err(fault) = told {
                    faults.retain(|other| (other.line, other.column) != (fault.line, fault.column));
                    faults.push(fault);
                    faults.sort_by_key(|fault| (fault.line, fault.column));
                }
                add_seen(&mut faults, seen(&ast, &source.path, around, &vocabulary));
                return Err(faults);
            }
        };
        let mut readings = resolver.readings();
        readings.insert((source.path.clone(), Id::of_text("script", &source.text)));
        let file = RuleFile {
            name: name.to_owned(),
            path: source.path.clone(),
            about: headline(&source.text),
            kinds,
            engine,
            ast,
            state,
            around: around.unshared(),
            notes,
            marks,
            readings,
            vocabulary,
        };
        Ok(Self { file: Arc::new(file), params: ParamSet::new(params) })
    }

    /// What is wrong in a rule that can be loaded, found without calling it: calls with the wrong number of arguments,
    /// parameters that are asked for and not declared; as warnings, parameters that nothing asks for.
    pub(crate) fn doubts(&self) -> Vec<Fault> {
        let RuleFile { ast, path, vocabulary, state, around, .. } = &*self.file;
        let texts = &around.texts;
        let mut faults = without_running(ast, path, texts, vocabulary);
        faults.extend(unknown_imported(ast, path, state));
        for (name, at) in imported_files(ast) {
            if let Err(fault) = around.shelves.read(&name) {
                let (line, column) = (at.line().unwrap_or(0) as u32, at.position().unwrap_or(0) as u32);
                let message = format!("cannot import `{}`: {}", fault.file, fault.message);
                faults.push(Fault { line, column, ..Fault::new(path, message).with_hint(fault.hint) });
            }
        }
        let declared: Vec<&str> = self.params.iter().map(|(param, _)| param.name.as_str()).collect();
        faults.extend(undeclared_in(ast, &declared, path));
        faults.extend(self.unused());
        faults.sort_by_key(|fault| (fault.line, fault.column));
        faults.into_iter().map(|fault| fault.measured(texts)).collect()
    }

    /// Warnings of parameters that nothing asks for.
    fn unused(&self) -> Vec<Fault> {
        let RuleFile { ast, path, around, readings, .. } = &*self.file;
        let texts = &around.texts;
        let own = properties(ast);
        // What an imported file does with `p` is told from its words.
        let imported: Vec<Arc<str>> =
            readings.iter().filter(|(name, _)| name != path).filter_map(|(name, _)| texts.imported(name)).collect();
        let is_used = |name: &str| own.contains(name) || imported.iter().any(|text| text.contains(&format!(".{name}")));
        let head = first_call(ast, "params").and_then(|at| Some((at.line()? as u32, at.position()? as u32)));
        let text = texts.get(path);
        let place = |name: &str| {
            let (line, column) = head?;
            key_position(text.as_deref()?, line, column, name)
        };
        let unused = self.params.iter().map(|(param, _)| param.name.as_str()).filter(|name| !is_used(name));
        unused
            .map(|name| {
                let (line, column) = place(name).unwrap_or((0, 0));
                let help = format!("ask for it as `p.{name}`, or take it out of params(#{{ … }})");
                let fault = Fault::warning(path, format!("nothing reads the parameter `{name}`"));
                Fault { line, column, ..fault.with_hint(Some(help)) }
            })
            .collect()
    }

    /// The name it was asked for by, e.g. `streets/grid`.
    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// The file, as messages call it.
    pub fn path(&self) -> &str {
        &self.file.path
    }

    /// Its first line of documentation (`//! …`), empty where there is none.
    pub fn about(&self) -> &str {
        &self.file.about
    }

    /// What it decides.
    pub fn kinds(&self) -> &[RuleKind] {
        &self.file.kinds
    }

    /// Its parameters with their present values.
    pub fn params(&self) -> &ParamSet {
        &self.params
    }

    /// The same rule with other values of parameters.
    #[must_use]
    pub fn with(&self, params: ParamSet) -> Self {
        Self { file: self.file.clone(), params }
    }

    /// The same rule with one parameter read from text, as behind `--set`.
    pub fn with_text(&self, name: &str, text: &str) -> Result<Self, ParamError> {
        self.params.with_text(name, text).map(|params| self.with(params))
    }

    /// The same rule, read once more so that it tells what it does step by step: for asking it again about one element. It is
    /// slower, and what it prints and marks is its own.
    pub fn telling(&self) -> (Self, Account) {
        let account = Account::default();
        (self.again(Some(account.clone())), account)
    }

    /// The same rule, read once more: what it prints and marks is its own.
    #[must_use]
    pub fn apart(&self) -> Self {
        self.again(None)
    }

    fn again(&self, account: Option<Account>) -> Self {
        let file = &self.file;
        let around = Surroundings { modules: Modules::default(), coverage: None, account, ..file.around.clone() };
        let again = file.around.texts.get(&file.path).and_then(|text| {
            let source = Source { text: text.to_string(), path: file.path.clone() };
            Self::examine(&file.name, &source, &around).ok()
        });
        again.map_or_else(|| self.clone(), |again| again.with(self.params.clone()))
    }

    /// What it printed, in alphabetical order.
    pub fn notes(&self) -> Vec<Note> {
        let notes = self.file.notes.lock().unwrap_or_else(PoisonError::into_inner);
        let note = |(text, printed): (&String, &Printed)| {
            let Printed { count, place } = *printed;
            Note { text: text.clone(), count, place }
        };
        notes.iter().map(note).collect()
    }

    /// Forgets where it printed and what it marked: the next city may have nothing there.
    pub(crate) fn forget_places(&self) {
        self.file.marks.forget();
        let mut notes = self.file.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.values_mut().for_each(|printed| printed.place = None);
    }

    /// The places that it marked, by x, then y.
    pub fn marks(&self) -> Vec<Marked> {
        self.file.marks.all()
    }

    /// The identity of what it does on a given site: its text, the texts it imports, the values of its parameters. For
    /// caches.
    pub fn fingerprint(&self) -> Id {
        let mut digest = Digest::new("rule");
        digest.value(&self.file.readings);
        self.params.iter().for_each(|(param, value)| {
            digest.text(&param.name).value(value);
        });
        digest.finish()
    }

    /// Calls a function that is evaluated once, such as `constraints(p)`.
    pub(crate) fn evaluate(&self, kind: RuleKind) -> Result<Dynamic, Fault> {
        let mut stage = self.stage();
        let call = AssertUnwindSafe(|| {
            self.run(&self.entry(kind), &mut stage, [Dynamic::from(self.params.ready().as_told())])
        });
        let result = catch_unwind(call).map_err(|panic| self.fault_of_panic(&*panic))?;
        result.map_err(|error| self.fault_of(*error))
    }

    /// The same with parameters that are the same everywhere written into it, for a function that is asked of each element.
    pub(crate) fn settled_entry(&self, kind: RuleKind) -> Entry {
        let (mut entry, params) = (self.entry(kind), self.params.ready());
        if self.file.around.is_watched() {
            // Branches that are never run must not be settled away, nor what is told.
            return entry;
        }
        let declared: Vec<&str> = self.params.iter().map(|(param, _)| param.name.as_str()).collect();
        let value = |name: &str| params.everywhere(declared.iter().position(|other| *other == name)?);
        let evaluate = |expression: &Expr| {
            let alone = Entry { arguments: Vec::new(), body: expression.clone() };
            catch_unwind(AssertUnwindSafe(|| self.run(&alone, &mut self.stage(), []))).ok()?.ok()
        };
        let is_own = |name: &str| self.file.ast.iter_functions().any(|function| function.name == name);
        if let (Expr::Stmt(body), Some(variable)) = (&mut entry.body, entry.arguments.last()) {
            Settling { variable, value: &value, evaluate: &evaluate, is_own: &is_own }.settle(body);
        }
        entry
    }

    /// The function of a kind that the rule has.
    pub(crate) fn entry(&self, kind: RuleKind) -> Entry {
        let function = self.file.ast.shared_lib().get_script_fn(kind.function(), kind.arguments().len());
        let function = function.expect("a rule is asked only for kinds that it has");
        let (from, to) = (function.body.start_position(), function.body.end_position());
        let statements = StmtBlock::new(statements_between(&self.file.ast, from, to), from, to);
        Entry { arguments: function.params.to_vec(), body: Expr::Stmt(Box::new(statements)) }
    }

    /// Warnings of maps that the rule asks for and the site does not have that the plan is settled on: it fails where it does,
    /// unless it looks whether they are there.
    pub(crate) fn missing_maps(&self) -> Vec<Fault> {
        let Some(places) = self.params.places() else { return Vec::new() };
        let of_param = |name: &str| match self.params.get(name)?.constant()? {
            Literal::Map(map) => Some(map.name.clone()),
            _ => None,
        };
        let missing = asked_maps(&self.file.ast).into_iter().filter_map(|(asked, place)| {
            let name = match asked {
                AskedMap::Named(name) => name,
                AskedMap::Parameter(name) => of_param(&name)?,
            };
            if places.maps.contains_key(&name) {
                return None;
            }
            let help = hint(&name, places.maps.keys().map(String::as_str));
            let help = help.or_else(|| Some("ask has_map first where a rule is to do without".into()));
            let fault = Fault::warning(self.path(), format!("the site has no map `{name}`")).with_hint(help);
            let (line, column) = (place.line().unwrap_or(0) as u32, place.position().unwrap_or(0) as u32);
            Some(Fault { line, column, ..fault }.measured(&self.file.around.texts))
        });
        missing.collect()
    }

    /// The line in which the body of the function of a kind begins.
    pub fn line(&self, kind: RuleKind) -> Option<u32> {
        let function = self.file.ast.shared_lib().get_script_fn(kind.function(), kind.arguments().len())?;
        function.body.start_position().line().map(|line| line as u32)
    }

    /// A fault of the whole function of a kind, placed on its name.
    pub(crate) fn at_function(&self, kind: RuleKind, fault: Fault) -> Fault {
        let (line, text) = (self.line(kind).unwrap_or(0), self.file.around.texts.get(self.path()));
        let column = text.map_or(0, |text| column_of(&text, line, kind.function()));
        Fault { line, column, length: kind.function().len() as u32, ..fault }
    }

    /// A fault of what the function of a kind answers with, placed on a key of it where that is written there.
    pub(crate) fn at_key(&self, kind: RuleKind, key: Option<&str>, fault: Fault) -> Fault {
        let told = self.file.around.texts.get(self.path()).and_then(|text| {
            let body = self.file.ast.shared_lib().get_script_fn(kind.function(), kind.arguments().len())?.body.clone();
            let at = |place: Position| Some((place.line()? as u32, place.position()? as u32));
            let (from, to) = (at(body.start_position())?, at(body.end_position())?);
            let found = key_position(&text, from.0, from.1, key?).filter(|place| *place < to)?;
            Some((text, found))
        });
        match told {
            Some((_, (line, column))) => Fault { line, column, ..fault }.measured(&self.file.around.texts),
            None => self.at_function(kind, fault),
        }
    }

    /// A stage of one's own to run functions on. Constants are copied: Rhai locks them when they are read.
    pub(crate) fn stage(&self) -> Stage {
        let mut global = self.file.state.clone();
        global.constants = global.constants.map(|constants| {
            let copy = constants.read().unwrap_or_else(PoisonError::into_inner).clone();
            Shared::new(Locked::new(copy))
        });
        Stage { global, caches: Caches::new(), scope: Scope::new() }
    }

    /// Runs a function. Its statements run directly on the stage: a call would cost more, and Rhai forgets the line where
    /// a limit was hit when it leaves a call.
    pub(crate) fn run<const N: usize>(
        &self,
        entry: &Entry,
        stage: &mut Stage,
        arguments: [Dynamic; N],
    ) -> Result<Dynamic, Box<EvalAltResult>> {
        // The limit is per call.
        let _spending = Spending::start();
        stage.scope.clear();
        for (name, value) in entry.arguments.iter().zip(arguments) {
            stage.scope.push_dynamic(name.clone(), value);
        }
        let (global, caches, scope) = (&mut stage.global, &mut stage.caches, &mut stage.scope);
        let mut context = EvalContext::new(&self.file.engine, global, caches, scope, None);
        context.eval_expression_tree(&Expression::from(&entry.body)).or_else(|error| match *error {
            EvalAltResult::Return(value, _) => Ok(value),
            _ => Err(error),
        })
    }

    pub(crate) fn fault_of(&self, error: EvalAltResult) -> Fault {
        let diagnosis = Diagnosis {
            file: &self.file.path,
            texts: &self.file.around.texts,
            vocabulary: &self.file.vocabulary,
            operations: Limits::RULE.operations,
        };
        of_error(error, &diagnosis)
    }

    pub(crate) fn fault_of_panic(&self, payload: &(dyn Any + Send)) -> Fault {
        of_panic(&self.file.path, payload)
    }
}

/// A function of a rule, ready to run.
#[derive(Clone)]
pub(crate) struct Entry {
    arguments: Vec<ImmutableString>,
    body: Expr,
}

/// What a function runs on: what the file knows, what Rhai has looked up so far, and variables. One per thread.
pub(crate) struct Stage {
    global: GlobalRuntimeState,
    caches: Caches,
    scope: Scope<'static>,
}

/// What rules are loaded among: shared by all rules of a host.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    pub shelves: Shelves,
    pub texts: Texts,
    pub modules: Modules,
    /// Counts the branches that are run, where somebody asks.
    pub coverage: Option<Coverage>,
    /// Takes in what rules do, where somebody asks.
    pub account: Option<Account>,
    /// Rules loaded so far, by name, where they may be shared: a test asks for the same rule again and again.
    pub rules: Option<Arc<Mutex<BTreeMap<String, Rule>>>>,
}

impl Surroundings {
    /// The same, sharing rules once they are loaded.
    #[must_use]
    pub fn sharing(&self) -> Self {
        Self { rules: Some(Arc::default()), ..self.clone() }
    }

    /// The same for one that loads by itself.
    fn unshared(&self) -> Self {
        Self { rules: None, ..self.clone() }
    }

    /// Whether somebody watches what rules do.
    fn is_watched(&self) -> bool {
        self.coverage.is_some() || self.account.is_some()
    }

    /// A rule that was loaded before.
    pub fn loaded(&self, name: &str) -> Option<Rule> {
        self.rules.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
    }

    /// What the rules that are shared printed, with how often where that was more than once.
    pub fn notes(&self) -> Vec<String> {
        let told = |note: Note| match note.count {
            count if count > 1 => format!("{} ({count} times)", note.text),
            _ => note.text,
        };
        let rules = self.rules.iter().flat_map(|rules| {
            rules.lock().unwrap_or_else(PoisonError::into_inner).values().cloned().collect::<Vec<_>>()
        });
        rules.flat_map(|rule| rule.notes()).map(told).collect()
    }

    /// Keeps a rule for others, where they share.
    pub fn keep(&self, name: &str, rule: Rule) -> Rule {
        if let Some(rules) = &self.rules {
            rules.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), rule.clone());
        }
        rule
    }
}

/// Collects what scripts print.
fn listen(engine: &mut Engine, notes: Notes) {
    let write = move |text: String| {
        crate::effects::noted();
        let mut notes = notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.entry(text).or_default().again(crate::effects::place());
        if notes.len() > MOST_NOTES {
            notes.pop_last();
        }
    };
    let debug = write.clone();
    engine.on_print(move |text| write(text.to_owned()));
    engine.on_debug(move |text, source, at| debug(format!("{}:{at:?}: {text}", source.unwrap_or(""))));
}

fn compile(engine: &Engine, source: &Source, around: &Surroundings) -> Result<AST, Fault> {
    let compiled = crate::host::compile(engine, &source.text, Closures::Any);
    let mut ast = compiled.map_err(|error| early_fault(engine, source, around, *error))?;
    ast.set_source(source.path.as_str());
    leave_out_tests(&mut ast);
    // Tests may see more.
    let refused = refuse_captures(&ast, Closures::Closed);
    refused.map_err(|error| early_fault(engine, source, around, *error))?;
    Ok(ast)
}

/// The same with a call that counts in each branch, where coverage is asked for, or that tells what is done.
fn instrumented(ast: AST, engine: &mut Engine, source: &Source, around: &Surroundings) -> Result<AST, Fault> {
    if let Some(account) = &around.account {
        account.register(engine);
        let text = account.telling(source, &ast);
        // What it cannot be told from is run as it is.
        return Ok(compile(engine, &Source { text, ..source.clone() }, around).unwrap_or(ast));
    }
    let Some(coverage) = &around.coverage else { return Ok(ast) };
    let text = coverage.counted(source, &ast, engine);
    compile(engine, &Source { text, ..source.clone() }, around)
}

/// Takes the tests out of a rule, with the closures in them: they use words that rules do not have.
fn leave_out_tests(ast: &mut AST) {
    let order = |at: Position| (at.line(), at.position());
    let body_of = |name: &str, arguments: usize| {
        let body = &ast.shared_lib().get_script_fn(name, arguments)?.body;
        Some((order(body.start_position()), order(body.end_position())))
    };
    let bodies = |wanted: fn(&str, usize) -> bool| {
        let functions = ast.iter_functions().filter(move |function| wanted(function.name, function.params.len()));
        functions.filter_map(|f| Some((f.name.to_owned(), body_of(f.name, f.params.len())?)))
    };
    // What is called like a test is no part of the rule, whatever it takes.
    let tests: Vec<_> = bodies(|name, _| is_test(name, 0)).map(|(_, body)| body).collect();
    if tests.is_empty() {
        return;
    }
    let is_inside = |start: &_| tests.iter().any(|(from, to)| from <= start && start <= to);
    let inner: BTreeSet<String> =
        bodies(|_, _| true).filter(|(_, (start, _))| is_inside(start)).map(|(name, _)| name).collect();
    ast.retain_functions(|_, _, name, _| !is_test(name, 0) && !inner.contains(name));
}

/// Runs the top of the file once: parameters are declared, constants made, imports loaded.
fn evaluate(engine: &Engine, ast: &AST, source: &Source, around: &Surroundings) -> Result<GlobalRuntimeState, Fault> {
    let _spending = Spending::start();
    let mut state = engine.new_global_runtime_state();
    state.lib.push(ast.shared_lib().clone());
    state.source = Some(source.path.as_str().into());
    #[expect(deprecated, reason = "the only public way to keep imports and constants for later calls")]
    let run = || engine.eval_statements_raw(&mut state, &mut Caches::new(), &mut Scope::new(), ast.statements());
    let result = catch_unwind(AssertUnwindSafe(run)).map_err(|panic| of_panic(&source.path, &*panic))?;
    let _ = result.map_err(|error| early_fault(engine, source, around, *error))?;
    Ok(state)
}

/// A fault before there is a rule.
fn early_fault(engine: &Engine, source: &Source, around: &Surroundings, error: EvalAltResult) -> Fault {
    let diagnosis = Diagnosis {
        file: &source.path,
        texts: &around.texts,
        vocabulary: &Vocabulary::of(engine, &AST::empty()),
        operations: Limits::RULE.operations,
    };
    of_error(error, &diagnosis)
}

/// What the functions of a file make it; nothing where none comes near to that of a rule.
fn kinds_of(ast: &AST, source: &Source) -> Result<Vec<RuleKind>, Fault> {
    let functions: Vec<(&str, usize)> = ast.iter_functions().map(|f| (f.name, f.params.len())).collect();
    let has = |kind: &RuleKind| functions.contains(&(kind.function(), kind.arguments().len()));
    let kinds: Vec<RuleKind> = RuleKind::ALL.into_iter().filter(has).collect();
    if !kinds.is_empty() {
        return Ok(kinds);
    }
    if let Some(fault) = miscounted(ast, source, &functions) {
        return Err(fault);
    }
    let near = functions.iter().find_map(|&(name, count)| {
        let kind = RuleKind::ALL.into_iter().find(|kind| kind.function() == name);
        let near = nearest(name, RuleKind::ALL.map(RuleKind::function));
        let kind = kind.or_else(|| RuleKind::ALL.into_iter().find(|kind| Some(kind.function()) == near))?;
        Some((kind, name, count))
    });
    let meant = |(kind, name, count): (RuleKind, &str, usize)| {
        let fault = decides_nothing(&source.path, format!("did you mean `fn {}`?", kind.form()));
        let function = ast.shared_lib().get_script_fn(name, count);
        let line = function.and_then(|function| function.body.start_position().line()).unwrap_or(0) as u32;
        Fault { line, column: column_of(&source.text, line, name), length: name.len() as u32, ..fault }
    };
    near.map_or(Ok(kinds), |near| Err(meant(near)))
}

fn decides_nothing(path: &str, help: String) -> Fault {
    Fault::new(path, "this file decides nothing").with_hint(Some(help))
}

/// What is wrong with a function that has a rule's name, but takes more or fewer arguments.
fn miscounted(ast: &AST, source: &Source, functions: &[(&str, usize)]) -> Option<Fault> {
    let Source { text, path } = source;
    let of = |name: &str| RuleKind::ALL.into_iter().find(|kind| kind.function() == name);
    let (kind, count) = functions.iter().find_map(|&(name, count)| Some((of(name)?, count)))?;
    let line = ast.shared_lib().get_script_fn(kind.function(), count)?.body.start_position().line().unwrap_or(0);
    let (name, takes) = (kind.function(), kind.arguments().len());
    let column = column_of(text, line as u32, name);
    let message = format!("`fn {name}` has {}, but is called with {takes}", plural(count, "argument"));
    let fault = Fault::new(path, message).with_hint(Some(format!("write `fn {}`", kind.form())));
    Some(Fault { line: line as u32, column, length: name.len() as u32, ..fault })
}

/// The statements of the function whose braces stand at two positions: Rhai does not hand them out by function. Closures
/// in it are functions of their own.
fn statements_between(ast: &AST, from: Position, to: Position) -> Vec<Stmt> {
    let order = |at: Position| (at.line(), at.position());
    let body_of = |name: &str, arguments: usize| {
        let body = &ast.shared_lib().get_script_fn(name, arguments)?.body;
        let start = order(body.start_position());
        // A body without braces has no end.
        Some((start, order(body.end_position()).max(start)))
    };
    let bodies = ast.iter_functions().filter_map(|function| body_of(function.name, function.params.len()));
    let inner: Vec<_> = bodies.filter(|(start, _)| *start > order(from) && *start < order(to)).collect();
    let is_of_closure = |at| inner.iter().any(|&(start, end)| start <= at && at <= end);
    let mut found = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let [ASTNode::Stmt(statement)] = path
            && (order(from)..order(to)).contains(&order(statement.position()))
            && !is_of_closure(order(statement.position()))
        {
            found.push((*statement).clone());
        }
        true
    });
    found
}

/// The first line of documentation.
pub(crate) fn headline(text: &str) -> String {
    text.lines().find_map(|line| line.trim().strip_prefix("//!")).map(|line| line.trim().to_owned()).unwrap_or_default()
}
