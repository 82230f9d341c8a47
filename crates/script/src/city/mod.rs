//! City scripts: a `city.rhai` is run once and tells a [`Plan`](crate::Plan).

mod build;
mod districts;
mod landmarks;
mod mix;
mod site;
mod streets;
mod within;

pub use site::{SiteInfo, SiteRequest, Sites};

use crate::fault::{Complaint, Diagnosis, Fault, Refusal, of_error, of_panic};
use crate::host::{Limits, Resolver, Source, Vocabulary, engine, unknown_words};
use crate::plan::Plan;
use crate::rule::{Rule, Surroundings};
use rhai::{AST, Dynamic, Engine, EvalAltResult, FuncRegistration, Map, Scope};
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
    around.texts.keep(source);
    let desk = Desk::default();
    let resolver = Resolver::new(around.shelves.clone(), around.texts.clone(), around.modules.clone());
    let mut engine = engine(Limits::CITY, resolver);
    register(&mut engine, around, sites, &desk);
    let ast = compile(&engine, source, around)?;
    let words = Vocabulary::of(&engine, &ast);
    if let Some(fault) = unknown_words(&ast, &source.path, &words).into_iter().next() {
        return Err(fault);
    }
    let run = AssertUnwindSafe(|| engine.run_ast_with_scope(&mut Scope::new(), &ast));
    let result = catch_unwind(run).map_err(|panic| of_panic(&source.path, &*panic))?;
    result.map_err(|error| fault_of(*error, source, around, &words))?;
    let printed = std::mem::take(&mut *desk.printed.lock().unwrap_or_else(PoisonError::into_inner));
    match desk.plan.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(plan) => Ok(Evaluated { plan, printed }),
        None => Err(Fault::new(&source.path, "the script ends without a city")
            .with_hint(Some("call city(#{ site: …, minors: … }) at its end".into()))),
    }
}

fn compile(engine: &Engine, source: &Source, around: &Surroundings) -> Result<AST, Fault> {
    let words = || Vocabulary::of(engine, &AST::empty());
    let compiled = engine.compile(&source.text);
    let mut ast = compiled.map_err(|error| fault_of(*Box::<EvalAltResult>::from(error), source, around, &words()))?;
    ast.set_source(source.path.as_str());
    Ok(ast)
}

fn fault_of(error: EvalAltResult, source: &Source, around: &Surroundings, words: &Vocabulary) -> Fault {
    let (file, texts) = (source.path.as_str(), &around.texts);
    of_error(error, &Diagnosis { file, texts, vocabulary: words, operations: Limits::CITY.operations })
}

fn register(engine: &mut Engine, around: &Surroundings, sites: Arc<dyn Sites>, desk: &Desk) {
    site::register(engine, sites);
    districts::register(engine);
    streets::register(engine);
    landmarks::register(engine);
    within::register(engine);
    crate::param::register_values(engine);
    mix::register(engine);
    rules(engine, around.clone());
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
        .register_into_engine(engine, move |name: &str| rule(name, Map::new(), &plain));
    FuncRegistration::new("rule")
        .with_params_info(["name", "#{ parameter: value }"])
        .register_into_engine(engine, move |name: &str, values: Map| rule(name, values, &around));
}

fn rule(name: &str, values: Map, around: &Surroundings) -> Result<Rule, Refusal> {
    let source = around.shelves.read(name).map_err(|fault| {
        Complaint::new(format!("rule \"{}\": {}", fault.file, fault.message)).maybe_hint(fault.hint)
    })?;
    let loaded = Rule::load(name, &source, around).map_err(within_rule)?;
    let params = values.iter().try_fold(loaded.params().clone(), |params, (name, value)| with(params, name, value))?;
    Ok(loaded.with(params))
}

fn with(params: crate::ParamSet, name: &str, value: &Dynamic) -> Result<crate::ParamSet, Complaint> {
    params.with_dynamic(name, value).map_err(|error| Complaint::new(error.message).maybe_hint(error.hint).key(name))
}

/// A fault inside a rule stays where it is: it travels through the city script as it stands.
fn within_rule(fault: Fault) -> Refusal {
    Box::new(EvalAltResult::ErrorRuntime(Dynamic::from(fault), rhai::Position::NONE))
}
