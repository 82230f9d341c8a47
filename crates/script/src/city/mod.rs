//! City scripts: a `city.rhai` is run once and tells a [`Plan`](crate::Plan).

mod build;
mod districts;
mod drawn;
mod landmarks;
mod mix;
mod site;
mod streets;
mod within;

pub(crate) use build::plan as plan_of;
pub(crate) use drawn::drawn_map;
pub(crate) use site::SiteHandle;
pub use site::{SiteInfo, SiteRequest, Sites};
pub(crate) use streets::{STREETS, rule_of, streets as street_plan};

use crate::fault::{Complaint, Diagnosis, Fault, Refusal, of_error, of_panic, place_in_script};
use crate::host::{
    Closures, LIBRARY, Limits, NamedRule, Resolver, Source, Spending, Vocabulary, engine, first_call, miscounted_calls,
    named_presets, named_rules, unknown_keys, unknown_words,
};
use crate::plan::Plan;
use crate::preset::{Preset, full_name};
use crate::rule::{Rule, Surroundings};
use rhai::{AST, Dynamic, Engine, EvalAltResult, FuncRegistration, Map, Scope};
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

/// What came of running a city script.
#[derive(Clone, Debug)]
pub struct Evaluated {
    /// What it asks for.
    pub plan: Plan,
    /// What it printed, in order.
    pub printed: Vec<String>,
}

/// Most lines of print that are kept.
const MOST_PRINTED: usize = 1000;

/// What words of a city script write to.
#[derive(Clone, Debug, Default)]
struct Desk {
    plan: Arc<Mutex<Option<Plan>>>,
    printed: Arc<Mutex<Vec<String>>>,
}

/// Runs a city script.
pub(crate) fn evaluate(source: &Source, around: &Surroundings, sites: Arc<dyn Sites>) -> Result<Evaluated, Fault> {
    let mut checked = check(source, around, sites, false);
    match checked.evaluated {
        Some(evaluated) => Ok(evaluated),
        None => Err(checked.faults.swap_remove(0)),
    }
}

/// What checking a city script found.
#[derive(Clone, Debug)]
pub struct Checked {
    /// What came of running it, where nothing was in the way.
    pub evaluated: Option<Evaluated>,
    /// What is wrong, and what is doubtful, in the script and in the rules it names: what stopped it comes first.
    pub faults: Vec<Fault>,
}

/// Runs a city script; with `all`, looks further than to the first fault: into the rest of it, and into all rules it names.
pub(crate) fn check(source: &Source, around: &Surroundings, sites: Arc<dyn Sites>, all: bool) -> Checked {
    around.texts.keep(source);
    let desk = Desk::default();
    let resolver = Resolver::new(around);
    let mut engine = engine(Limits::CITY, resolver);
    register(&mut engine, around, sites, &desk);
    let ast = match compile(&engine, source, around) {
        Ok(ast) => ast,
        Err(fault) => return Checked { evaluated: None, faults: vec![fault] },
    };
    let words = Vocabulary::of(&engine, &ast);
    let mut faults = unknown(&ast, source, around, &words);
    let mut evaluated = None;
    if faults.is_empty() {
        match run(&engine, &ast, source, around, &words, &desk) {
            Ok(done) => evaluated = Some(done),
            Err(fault) => faults.push(at_district(fault, &source.text)),
        }
    }
    if all {
        let mut others = further(&mut faults, &ast, source, around, &words);
        if evaluated.is_none() {
            others.extend(in_presets(&ast, source, around));
        }
        others.extend(around.shelves.pin().changes().map(|message| {
            let (line, column) = place_of_call(&ast, "library");
            let help = format!("library({LIBRARY}) takes them over");
            Fault { line, column, ..Fault::warning(&source.path, message).with_hint(Some(help)) }
        }));
        add_others(&mut faults, others);
    }
    Checked { evaluated, faults }
}

/// Where a script first calls a word: line and column, 0 where it does not.
fn place_of_call(ast: &AST, word: &str) -> (u32, u32) {
    first_call(ast, word).map_or((0, 0), |at| (at.line().unwrap_or(0) as u32, at.position().unwrap_or(0) as u32))
}

/// What is wrong with the name of a district is placed on it: the word that takes all districts together knows no place.
fn at_district(fault: Fault, text: &str) -> Fault {
    let place = Some(&fault.message).filter(|message| message.contains("differs in `"));
    match place.and_then(|message| place_in_script(text, message)) {
        Some((line, column, length)) => Fault { line, column, length, ..fault },
        None => fault,
    }
}

/// Names and properties that there are not.
fn unknown(ast: &AST, source: &Source, around: &Surroundings, words: &Vocabulary) -> Vec<Fault> {
    unknown_words(ast, &source.path, words).into_iter().map(|fault| fault.measured(&around.texts)).collect()
}

/// What else is wrong than the first of some faults: the others, further calls, rules that are named.
fn further(
    faults: &mut Vec<Fault>,
    ast: &AST,
    source: &Source,
    around: &Surroundings,
    words: &Vocabulary,
) -> Vec<Fault> {
    let mut others = faults.split_off(faults.len().min(1));
    let found = miscounted_calls(ast, &source.path, words).into_iter().chain(in_rules(ast, source, around));
    let found = found.chain(unknown_keys(ast, &source.path, &source.text, |word| match word {
        "city" => Some(build::KEYS.iter().copied().collect()),
        "streets" => Some(STREETS.iter().copied().chain(["preset"]).collect()),
        "preset" => Some(Preset::keys().collect()),
        _ => None,
    }));
    others.extend(found.map(|fault| fault.measured(&around.texts)));
    others
}

/// Adds faults by file and place. One place is told once; of whole files, each thing that is wrong.
fn add_others(faults: &mut Vec<Fault>, mut others: Vec<Fault>) {
    others.sort_by(|a, b| (&a.file, a.line, a.column).cmp(&(&b.file, b.line, b.column)));
    for other in others {
        let is_told = |known: &Fault| {
            (&known.file, known.line, known.column) == (&other.file, other.line, other.column)
                && (other.line > 0 || known.message == other.message)
        };
        if !faults.iter().any(is_told) {
            faults.push(other);
        }
    }
}

fn run(
    engine: &Engine,
    ast: &AST,
    source: &Source,
    around: &Surroundings,
    words: &Vocabulary,
    desk: &Desk,
) -> Result<Evaluated, Fault> {
    run_script(engine, ast, source, around, words)?;
    let printed = std::mem::take(&mut *desk.printed.lock().unwrap_or_else(PoisonError::into_inner));
    match desk.plan.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(plan) => Ok(Evaluated { plan, printed }),
        None => Err(Fault::new(&source.path, "the script ends without a city")
            .with_hint(Some("call city(#{ site: …, minors: … }) at its end".into()))),
    }
}

fn run_script(
    engine: &Engine,
    ast: &AST,
    source: &Source,
    around: &Surroundings,
    words: &Vocabulary,
) -> Result<(), Fault> {
    let _spending = Spending::start();
    let run = AssertUnwindSafe(|| engine.run_ast_with_scope(&mut Scope::new(), ast));
    let result = catch_unwind(run).map_err(|panic| of_panic(&source.path, &*panic))?;
    result.map_err(|error| fault_of(*error, source, around, words))
}

/// What is wrong in the rules that a script names, and with the names.
fn in_rules(ast: &AST, source: &Source, around: &Surroundings) -> Vec<Fault> {
    let mut seen = BTreeSet::new();
    let mut faults = Vec::new();
    for named in named_rules(ast, &source.text) {
        let Some(name) = &named.name else { continue };
        match around.shelves.read(name) {
            Err(fault) => faults.push(missing_rule_at(fault, &named, &source.path)),
            Ok(text) => {
                let is_new = seen.insert(text.path.clone());
                let rule = Rule::examine(name, &text, around);
                match rule.and_then(|rule| rule.deciding().map_err(|fault| vec![fault])) {
                    Ok(rule) => {
                        let known: Vec<&str> = rule.params().iter().map(|(param, _)| param.name.as_str()).collect();
                        faults.extend(named.unknown_parameters(&known, &source.path));
                        faults.extend(named.unsuited_values(rule.params(), &source.path));
                        faults.extend(if is_new { rule.doubts() } else { Vec::new() });
                    }
                    Err(found) => faults.extend(if is_new { found } else { Vec::new() }),
                }
            }
        }
    }
    faults
}

/// What is wrong in the presets that a script names, and with the names.
fn in_presets(ast: &AST, source: &Source, around: &Surroundings) -> Vec<Fault> {
    let named = named_presets(ast).into_iter().flat_map(|(name, (line, column))| {
        let at_name = |complaint: Complaint| Fault {
            line,
            column,
            ..Fault::new(&source.path, complaint.message).with_hint(complaint.hint)
        };
        match preset_text(&name, around) {
            Ok(text) => Preset::load(&full_name(&name), &text, around).err().unwrap_or_default(),
            Err(complaint) => vec![at_name(complaint).measured(&around.texts)],
        }
    });
    named.collect()
}

/// The fault of a rule that is named and not there.
pub(crate) fn missing_rule_at(fault: Fault, named: &NamedRule, file: &str) -> Fault {
    let (complaint, (line, column)) = (missing_rule(fault), named.place());
    Fault { line, column, ..Fault::new(file, complaint.message).with_hint(complaint.hint) }
}

fn missing_rule(fault: Fault) -> Complaint {
    Complaint::new(format!("rule \"{}\": {}", fault.file, fault.message)).maybe_hint(fault.hint)
}

fn compile(engine: &Engine, source: &Source, around: &Surroundings) -> Result<AST, Fault> {
    let words = || Vocabulary::of(engine, &AST::empty());
    let compiled = crate::host::compile(engine, &source.text, Closures::InPlace);
    let mut ast = compiled.map_err(|error| fault_of(*error, source, around, &words()))?;
    ast.set_source(source.path.as_str());
    Ok(ast)
}

fn fault_of(error: EvalAltResult, source: &Source, around: &Surroundings, words: &Vocabulary) -> Fault {
    let (file, texts) = (source.path.as_str(), &around.texts);
    of_error(error, &Diagnosis { file, texts, vocabulary: words, operations: Limits::CITY.operations })
}

fn register(engine: &mut Engine, around: &Surroundings, sites: Arc<dyn Sites>, desk: &Desk) {
    register_words(engine, around.clone(), sites);
    let plan = desk.plan.clone();
    FuncRegistration::new("city")
        .with_params_info(["#{ site, districts, seed, majors, minors, parcels, buildings, … }"])
        .with_comments(["/// Tells what the city is made of. Called once, at the end."])
        .register_into_engine(engine, move |options: Map| -> Result<(), Refusal> {
            let built = build::plan(options)?;
            let mut plan = plan.lock().unwrap_or_else(PoisonError::into_inner);
            if plan.is_some() {
                return Err(Complaint::new("city(…) is called twice").hint("one script, one city").into());
            }
            *plan = Some(built);
            Ok(())
        });
    listen(engine, desk.printed.clone());
}

/// The words of city scripts, but for `city` itself.
pub(crate) fn register_words(engine: &mut Engine, around: Surroundings, sites: Arc<dyn Sites>) {
    site::register(engine, sites);
    districts::register(engine);
    streets::register(engine);
    landmarks::register(engine);
    within::register(engine);
    crate::param::register_values(engine);
    mix::register(engine);
    rules(engine, around.clone());
    library(engine, around.clone());
    presets(engine, around);
}

/// `library(1)`.
fn library(engine: &mut Engine, around: Surroundings) {
    FuncRegistration::new("library")
        .with_params_info(["version"])
        .with_comments([
            "/// The version of the rule library that the script was made with: later ones change nothing in it.",
        ])
        .register_into_engine(engine, move |version: i64| Ok::<_, Refusal>(around.shelves.pin().choose(version)?));
}

/// `preset("village")`.
fn presets(engine: &mut Engine, around: Surroundings) {
    engine.register_type_with_name::<Preset>("a preset");
    FuncRegistration::new("preset")
        .with_params_info(["name"])
        .with_comments(["/// A preset of the city's folder or the library, by name: rules with chosen values."])
        .register_into_engine(engine, move |name: &str| Ok::<_, Refusal>(preset_named(name, &around)?));
}

/// A preset by its name, with or without its folder.
pub(crate) fn preset_named(name: &str, around: &Surroundings) -> Result<Preset, Complaint> {
    let source = preset_text(name, around)?;
    Preset::load(&full_name(name), &source, around).map_err(|mut faults| Complaint::of(faults.swap_remove(0)))
}

fn preset_text(name: &str, around: &Surroundings) -> Result<Source, Complaint> {
    around.shelves.read(&full_name(name)).map_err(|fault| {
        let message = fault.message.replace("rule", "preset");
        Complaint::new(format!("preset \"{}\": {message}", fault.file)).maybe_hint(fault.hint)
    })
}

/// Runs the file of a preset, and makes something of what it hands to `preset(#{ … })`.
///
/// # Errors
/// All that is wrong in it and in the rules it names, what stopped it first.
pub(crate) fn of_preset<T>(
    source: &Source,
    around: &Surroundings,
    make: impl FnOnce(Map) -> Result<T, Complaint>,
) -> Result<T, Vec<Fault>> {
    around.texts.keep(source);
    let resolver = Resolver::new(around);
    let mut engine = engine(Limits::CITY, resolver);
    crate::param::register_values(&mut engine);
    mix::register(&mut engine);
    streets::register(&mut engine);
    rules(&mut engine, around.clone());
    let told: Arc<Mutex<Vec<Map>>> = Arc::default();
    let own = told.clone();
    FuncRegistration::new("preset")
        .with_params_info(["#{ pattern, goals, constraints, width, parcels, buildings }"])
        .with_comments(["/// Tells what the preset is made of. Called once, at the end."])
        .register_into_engine(&mut engine, move |map: Map| {
            own.lock().unwrap_or_else(PoisonError::into_inner).push(map)
        });
    let ast = compile(&engine, source, around).map_err(|fault| vec![fault])?;
    let words = Vocabulary::of(&engine, &ast);
    let run = || {
        run_script(&engine, &ast, source, around, &words)?;
        let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
        let help = "call preset(#{ pattern: rule(\"…\"), … }) once, at its end";
        let (line, column) = place_of_call(&ast, "preset");
        let wrong = |message: &str| {
            let fault = Fault::new(&source.path, message).with_hint(Some(help.into()));
            Fault { line, column, ..fault }.measured(&around.texts)
        };
        match told.len() {
            1 => make(told.remove(0)).map_err(|complaint| complaint.in_call("preset", source)),
            0 => Err(wrong("this file tells no preset")),
            _ => Err(wrong("this file tells several presets")),
        }
    };
    let mut faults = unknown(&ast, source, around, &words);
    if faults.is_empty() {
        match run() {
            Ok(made) => return Ok(made),
            Err(fault) => faults.push(fault),
        }
    }
    let others = further(&mut faults, &ast, source, around, &words);
    add_others(&mut faults, others);
    Err(faults)
}

fn listen(engine: &mut Engine, printed: Arc<Mutex<Vec<String>>>) {
    let write = move |text: String| {
        let mut printed = printed.lock().unwrap_or_else(PoisonError::into_inner);
        if printed.len() < MOST_PRINTED {
            printed.push(text);
        }
    };
    let debug = write.clone();
    engine.on_print(move |text| write(text.to_owned()));
    engine.on_debug(move |text, _, at| debug(format!("{at:?}: {text}")));
}

/// `rule("streets/grid")` and `rule("streets/grid", #{ heading: 10 })`.
fn rules(engine: &mut Engine, around: Surroundings) {
    engine.register_type_with_name::<Rule>("a rule");
    let plain = around.clone();
    FuncRegistration::new("rule")
        .with_params_info(["name"])
        .with_comments(["/// A rule of the city's folder or the library, by name."])
        .register_into_engine(engine, move |name: &str| Ok::<_, Refusal>(rule_named(name, Map::new(), &plain)?));
    FuncRegistration::new("rule")
        .with_params_info(["name", "#{ parameter: value }"])
        .register_into_engine(engine, move |name: &str, values: Map| {
            Ok::<_, Refusal>(rule_named(name, values, &around)?)
        });
}

/// A rule by its name, with values of parameters.
pub(crate) fn rule_named(name: &str, values: Map, around: &Surroundings) -> Result<Rule, Complaint> {
    let loaded = match around.loaded(name) {
        Some(rule) => rule,
        None => {
            let source = around.shelves.read(name).map_err(missing_rule)?;
            around.keep(name, Rule::load(name, &source, around).map_err(Complaint::of)?)
        }
    };
    let params = values.iter().try_fold(loaded.params().clone(), |params, (name, value)| with(params, name, value))?;
    Ok(loaded.with(params))
}

fn with(params: crate::ParamSet, name: &str, value: &Dynamic) -> Result<crate::ParamSet, Complaint> {
    params.with_dynamic(name, value).map_err(|error| Complaint::new(error.message).maybe_hint(error.hint).key(name))
}
