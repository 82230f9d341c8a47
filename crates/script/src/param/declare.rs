//! The words of `params(#{ … })`.

use super::literal::Misfit;
use super::{Domain, Literal, Param, Unit};
use crate::fault::{Complaint, Refusal};
use crate::host::{kind_of, numeric};
use crate::plan::MapRef;
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map, NativeCallContext};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A parameter while it is being declared.
#[derive(Clone, Debug)]
pub(crate) struct Declaration {
    /// Where it stands among its siblings: Rhai's maps forget the author's order, so each constructor draws a number.
    ordinal: u64,
    domain: Domain,
    default: Literal,
    about: String,
}

/// What a file has declared so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Declared(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    params: Option<Vec<Param>>,
    sealed: bool,
}

impl Declared {
    /// Ends declaring, and gives what was declared.
    pub fn seal(&self) -> Vec<Param> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.sealed = true;
        state.params.take().unwrap_or_default()
    }

    fn declare(&self, map: Map) -> Result<(), Complaint> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if state.sealed {
            return Err(misplaced());
        }
        if state.params.is_some() {
            return Err(Complaint::new("params(…) stands twice in this file").hint("put all parameters into one map"));
        }
        state.params = Some(in_order(map)?);
        Ok(())
    }
}

/// The parameters of a map in the author's order.
fn in_order(map: Map) -> Result<Vec<Param>, Complaint> {
    let mut found = Vec::with_capacity(map.len());
    for (name, value) in map {
        let kind = kind_of(&value);
        let Some(declaration) = value.try_cast::<Declaration>() else {
            let help =
                "write metres(…), degrees(…), ratio(…), number(…), whole(…), choice(…), flag(…), map(…) or colour(…)";
            return Err(Complaint::new(format!("`{name}` must be a parameter, not {kind}")).hint(help).key(name));
        };
        found.push((declaration.ordinal, name.to_string(), declaration));
    }
    found.sort_by_key(|(ordinal, ..)| *ordinal);
    found.into_iter().map(|(_, name, declaration)| declaration.finish(name)).collect()
}

impl Declaration {
    fn finish(self, name: String) -> Result<Param, Complaint> {
        match self.domain.check(self.default.clone()) {
            Ok(default) => Ok(Param { name, domain: self.domain, default, about: self.about }),
            Err((message, near)) => {
                Err(Complaint::new(format!("the default of `{name}` {message}")).maybe_hint(near).key(name))
            }
        }
    }

    fn range(mut self, low: &Dynamic, high: &Dynamic) -> Result<Self, Complaint> {
        let (low, high) = (numeric("the low end of a range", low)?, numeric("the high end of a range", high)?);
        if low > high {
            return Err(Complaint::new("the range runs from high to low").hint("write .range(low, high)"));
        }
        match &mut self.domain {
            Domain::Number { range, .. } => *range = (low, high),
            Domain::Whole { range } => *range = (low.ceil() as i64, high.floor() as i64),
            _ => return Err(Complaint::new("only numbers have a range").hint("take .range(…) away")),
        }
        Ok(self)
    }
}

/// Makes the constructors count, and `params` declare into `declared` when called by the file at `path` itself: a file
/// that imports another rule does not take over its parameters.
pub(crate) fn register(engine: &mut Engine, path: &str, declared: Declared) {
    let own = path.to_owned();
    let params = move |context: NativeCallContext, map: Map| -> Result<(), Refusal> {
        if context.call_source().is_some_and(|source| source != own) {
            return Ok(());
        }
        Ok(declared.declare(map)?)
    };
    FuncRegistration::new("params").with_params_info(["#{ name: parameter }"]).register_into_engine(engine, params);
    numbers(engine);
    others(engine);
    engine.register_type_with_name::<Declaration>("a parameter");
    method(engine, "range", ["this", "low", "high"], |d: &mut Declaration, low: Dynamic, high: Dynamic| {
        Ok::<_, Refusal>(d.clone().range(&low, &high)?)
    });
    let about = |d: &mut Declaration, about: &str| Declaration { about: about.to_owned(), ..d.clone() };
    FuncRegistration::new("about").with_params_info(["this", "text"]).register_into_engine(engine, about);
}

fn method<const N: usize, F>(engine: &mut Engine, name: &str, info: [&str; N], f: F)
where
    F: Fn(&mut Declaration, Dynamic, Dynamic) -> Result<Declaration, Refusal> + Send + Sync + 'static,
{
    FuncRegistration::new(name).with_params_info(info).register_into_engine(engine, f);
}

/// Counts constructors across all files: only the order within one map matters.
static NEXT: AtomicU64 = AtomicU64::new(0);

fn new(domain: Domain, default: Literal) -> Declaration {
    Declaration { ordinal: NEXT.fetch_add(1, Ordering::Relaxed), domain, default, about: String::new() }
}

fn numbers(engine: &mut Engine) {
    let endless = (f64::NEG_INFINITY, f64::INFINITY);
    let units = [
        ("metres", Unit::Metres, endless),
        ("degrees", Unit::Degrees, endless),
        ("ratio", Unit::Ratio, (0.0, 1.0)),
        ("number", Unit::Plain, endless),
    ];
    for (name, unit, range) in units {
        let make = move |default: Dynamic| -> Result<Declaration, Refusal> {
            let default = numeric("the default", &default)?;
            Ok(new(Domain::Number { unit, range }, Literal::Number(default)))
        };
        FuncRegistration::new(name).with_params_info(["default"]).register_into_engine(engine, make);
    }
    let whole = |default: i64| new(Domain::Whole { range: (i64::MIN, i64::MAX) }, Literal::Whole(default));
    FuncRegistration::new("whole").with_params_info(["default: i64"]).register_into_engine(engine, whole);
}

fn others(engine: &mut Engine) {
    let flag = |default: bool| new(Domain::Flag, Literal::Flag(default));
    FuncRegistration::new("flag").with_params_info(["default: bool"]).register_into_engine(engine, flag);
    let map = |name: &str| new(Domain::Map, Literal::Map(MapRef { name: name.to_owned() }));
    FuncRegistration::new("map").with_params_info(["name"]).register_into_engine(engine, map);
    let colour = |text: &str| -> Result<Declaration, Refusal> {
        let default = Domain::Colour.read_text(text).map_err(complaint)?;
        Ok(new(Domain::Colour, default))
    };
    FuncRegistration::new("colour").with_params_info(["\"#rrggbb\""]).register_into_engine(engine, colour);
    FuncRegistration::new("choice").with_params_info(["default", "[words]"]).register_into_engine(engine, choice);
}

/// `choice("a", ["a", "b"])`.
fn choice(default: &str, words: Array) -> Result<Declaration, Refusal> {
    let texts: Option<Vec<String>> = words.into_iter().map(|word| word.into_string().ok()).collect();
    let texts = texts.filter(|texts| !texts.is_empty());
    let texts =
        texts.ok_or_else(|| Complaint::new("a choice needs a list of texts").hint("choice(\"a\", [\"a\", \"b\"])"))?;
    Ok(new(Domain::Choice(texts), Literal::Choice(default.to_owned())))
}

fn complaint((message, near): Misfit) -> Complaint {
    Complaint::new(format!("the default {message}")).maybe_hint(near)
}

/// What is said where parameters are declared within a function.
pub(crate) fn misplaced() -> Complaint {
    Complaint::new("params(…) belongs at the top of the file, outside of functions")
        .hint("move it above the functions: it is read once, not at each call")
}
