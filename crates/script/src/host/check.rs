//! What can be found wrong in a script before it runs. Rhai itself finds it only when it is reached.

use super::vocabulary::split;
use super::{Closures, Vocabulary};
use crate::fault::{Complaint, Fault, function_like, key_position, no_method, plural};
use crate::names::hint;
use crate::param::{ParamSet, misplaced};
use rhai::{AST, ASTNode, Dynamic, Expr, FnCallExpr, GlobalRuntimeState, Map, Module, Position, Stmt};
use std::collections::BTreeSet;
use std::sync::PoisonError;

/// A call in a script.
struct Called<'a> {
    call: &'a FnCallExpr,
    at: Position,
    is_method: bool,
}

/// Calls of functions that do not exist, by position.
pub(crate) fn unknown_words(ast: &AST, file: &str, words: &Vocabulary) -> Vec<Fault> {
    faults_of_calls(ast, |called| {
        let name = &called.call.name;
        if !is_plain(called.call) || words.has_function(name) {
            return None;
        }
        let help = function_like(name, words);
        Some(at(called.at, Fault::new(file, format!("there is no function `{name}`")).with_hint(help)))
    })
}

/// Calls with more or fewer arguments than the function takes, by position.
pub(crate) fn miscounted_calls(ast: &AST, file: &str, words: &Vocabulary) -> Vec<Fault> {
    faults_of_calls(ast, |called| {
        let (name, count) = (&called.call.name, called.call.args.len());
        if !is_plain(called.call) || !words.has_function(name) || words.takes(name, count, called.is_method) {
            return None;
        }
        let message = format!("`{name}` does not take {}", plural(count, "argument"));
        let help = format!("it is written {}", words.forms_of(name).join(" or "));
        Some(at(called.at, Fault::new(file, message).with_hint(Some(help))))
    })
}

/// What is wrong with what is asked of a variable in these statements, by position; told what stands behind the point.
fn faults_of_asked(statements: &[Stmt], variable: &str, fault_of: impl Fn(&Expr) -> Option<Fault>) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut on_node = |path: &[ASTNode<'_>]| {
        if let Some(ASTNode::Expr(Expr::Dot(dot, ..))) = path.last()
            && is_variable(&dot.lhs, variable)
        {
            faults.extend(fault_of(&dot.rhs));
        }
        true
    };
    for statement in statements {
        statement.walk(&mut Vec::new(), &mut on_node);
    }
    in_order(faults)
}

/// Parameters that are asked for in these statements and not declared, by position; `variable` is what they are asked of.
pub(crate) fn undeclared(statements: &[Stmt], variable: &str, declared: &[&str], file: &str) -> Vec<Fault> {
    faults_of_asked(statements, variable, |asked| {
        let (name, place) = property_of(asked).filter(|(name, _)| !declared.contains(name))?;
        let help = hint(name, declared.iter().copied());
        let help = help.or_else(|| Some(format!("declare it: params(#{{ {name}: number(0) }})")));
        Some(at(place, Fault::new(file, format!("there is no parameter `{name}`")).with_hint(help)))
    })
}

/// Properties that are asked of a variable in these statements and that it does not have, by position.
pub(crate) fn unknown_properties(
    statements: &[Stmt],
    variable: &str,
    known: &BTreeSet<&str>,
    file: &str,
) -> Vec<Fault> {
    faults_of_asked(statements, variable, |asked| {
        let (name, place) = property_of(asked).filter(|(name, _)| !known.contains(name))?;
        let help = hint(name, known.iter().copied());
        Some(at(place, Fault::new(file, format!("{variable} has no `{name}`")).with_hint(help)))
    })
}

/// What is called in these statements on a variable of a kind, and cannot be: with so many arguments, or at all; by position.
pub(crate) fn unknown_methods(
    statements: &[Stmt],
    (variable, kind): (&str, &str),
    words: &Vocabulary,
    file: &str,
) -> Vec<Fault> {
    faults_of_asked(statements, variable, |asked| {
        let (call, place) = method_of(asked)?;
        let (name, count) = (call.name.as_str(), call.args.len());
        if !words.has_function(name) || words.is_method(kind, name, count) {
            return None;
        }
        let Complaint { message, hint, .. } = no_method(kind, name, count, words);
        Some(at(place, Fault::new(file, message).with_hint(hint)))
    })
}

/// Whether these statements make a name stand for something else somewhere: then little is known of it.
pub(crate) fn rebinds(statements: &[Stmt], name: &str) -> bool {
    let mut does = false;
    for statement in statements {
        statement.walk(&mut Vec::new(), &mut |path| {
            does |= match path.last() {
                Some(ASTNode::Stmt(Stmt::Var(parts, ..))) => parts.0.as_str() == name,
                Some(ASTNode::Stmt(Stmt::For(parts, ..))) => {
                    parts.0.as_str() == name || parts.1.as_ref().is_some_and(|count| count.as_str() == name)
                }
                Some(ASTNode::Stmt(Stmt::TryCatch(parts, ..))) => is_variable(&parts.expr, name),
                Some(ASTNode::Stmt(Stmt::Import(parts, ..))) => parts.1.as_str() == name,
                Some(ASTNode::Stmt(Stmt::Assignment(parts))) => is_variable(&parts.1.lhs, name),
                _ => false,
            };
            !does
        });
    }
    does
}

fn is_variable(expression: &Expr, name: &str) -> bool {
    matches!(expression, Expr::Variable(of, ..) if of.1 == name)
}

/// The names of the parameters that `params(#{ … })` declares, as they are written.
pub(crate) fn declared_in(ast: &AST, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let Some(called) = path.last().and_then(called).filter(|called| called.call.name == "params") {
            found.extend(called.call.args.first().into_iter().flat_map(|map| keys_of(map, text)).map(|key| key.name));
        }
        true
    });
    found
}

fn method_of(expression: &Expr) -> Option<(&FnCallExpr, Position)> {
    match expression {
        Expr::MethodCall(call, at) => Some((call, *at)),
        Expr::Dot(dot, ..) | Expr::Index(dot, ..) => method_of(&dot.lhs),
        _ => None,
    }
}

/// Calls of `params(…)` within functions: it is read once, at the top of a file.
pub(crate) fn misplaced_params(ast: &AST, file: &str) -> Vec<Fault> {
    let order = |at: Position| (at.line(), at.position());
    let bodies = ast.iter_functions().filter_map(|function| {
        let body = &ast.shared_lib().get_script_fn(function.name, function.params.len())?.body;
        Some(order(body.start_position())..order(body.end_position()))
    });
    let bodies: Vec<_> = bodies.collect();
    faults_of_calls(ast, |called| {
        let is_within = called.call.name == "params" && bodies.iter().any(|body| body.contains(&order(called.at)));
        let Complaint { message, hint, .. } = misplaced();
        is_within.then(|| at(called.at, Fault::new(file, message).with_hint(hint)))
    })
}

/// The maps that a script asks for of a tip, a block or their like, by a written name or a parameter's, with their places; none
/// of which it asks whether they are there.
pub(crate) fn asked_maps(ast: &AST) -> Vec<(AskedMap, Position)> {
    let (mut asked, mut looked_for) = (Vec::new(), BTreeSet::new());
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let Some(ASTNode::Expr(Expr::MethodCall(call, at))) = path.last()
            && let Some(map) = call.args.first().and_then(AskedMap::of)
        {
            match call.name.as_str() {
                "map" | "zone" => asked.push((map, *at)),
                "has_map" => drop(looked_for.insert(map)),
                _ => {}
            }
        }
        true
    });
    asked.retain(|(map, _)| !looked_for.contains(map));
    asked
}

/// A map as a script names it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum AskedMap {
    /// By its name.
    Named(String),
    /// By a parameter: `p.zones`.
    Parameter(String),
}

impl AskedMap {
    fn of(argument: &Expr) -> Option<Self> {
        match argument {
            Expr::StringConstant(name, _) => Some(Self::Named(name.to_string())),
            Expr::Dot(dot, ..) if matches!(&dot.lhs, Expr::Variable(of, ..) if of.1 == "p") => {
                property_of(&dot.rhs).map(|(name, _)| Self::Parameter(name.to_owned()))
            }
            _ => None,
        }
    }
}

/// What a script asks of what it imports at its top, or of its own constants, and is not there, by position: functions with so
/// many arguments, and `global::NAME`.
pub(crate) fn unknown_imported(ast: &AST, file: &str, state: &GlobalRuntimeState) -> Vec<Fault> {
    let mut faults = Vec::new();
    let constants = state.constants.as_ref().map(|constants| constants.read().unwrap_or_else(PoisonError::into_inner));
    let known: Vec<&str> = constants.iter().flat_map(|constants| constants.keys()).map(|name| name.as_str()).collect();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let Some(called) = path.last().and_then(called) {
            let module = called.call.namespace.to_string();
            let functions = state.find_import(&module).and_then(|index| state.get_shared_import(index));
            if let Some(functions) = functions {
                faults.extend(unknown_in(&called, &module, &functions, file));
            }
        }
        if let Some(ASTNode::Expr(Expr::Variable(variable, _, place))) = path.last()
            && variable.2.to_string() == "global"
            && !known.contains(&variable.1.as_str())
        {
            let name = variable.1.as_str();
            let help =
                hint(name, known.iter().copied()).unwrap_or_else(|| format!("write const {name} = …; at the top"));
            let message = format!("there is no constant `global::{name}`");
            faults.push(at(*place, Fault::new(file, message).with_hint(Some(help))));
        }
        true
    });
    in_order(faults)
}

/// What is wrong with a call of a function of a module.
fn unknown_in(called: &Called<'_>, module: &str, functions: &Module, file: &str) -> Option<Fault> {
    let (name, count) = (called.call.name.as_str(), called.call.args.len());
    let read = |signature: String| {
        let (name, rest) = signature.split_once('(')?;
        let arguments = rest.rsplit_once(')').map_or(rest, |(arguments, _)| arguments);
        let count = if arguments.trim().is_empty() { 0 } else { split(arguments, ',').len() };
        Some((name.trim().to_owned(), count))
    };
    let all: Vec<(String, usize)> =
        functions.gen_fn_signatures_with_mapper(|name| name.into()).filter_map(read).collect();
    let counts: Vec<usize> = all.iter().filter(|(own, _)| own == name).map(|(_, count)| *count).collect();
    if counts.contains(&count) {
        return None;
    }
    let (message, help) = match counts.first() {
        Some(wanted) => {
            let message = format!("`{module}::{name}` does not take {}", plural(count, "argument"));
            (message, Some(format!("it takes {}", plural(*wanted, "argument"))))
        }
        None => {
            let help = hint(name, all.iter().map(|(own, _)| own.as_str()));
            (format!("there is no function `{module}::{name}`"), help)
        }
    };
    Some(at(called.at, Fault::new(file, message).with_hint(help)))
}

/// Files that a script imports by a written name, with where.
pub(crate) fn imported_files(ast: &AST) -> Vec<(String, Position)> {
    let mut found = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let Some(ASTNode::Stmt(Stmt::Import(parts, _))) = path.last()
            && let Expr::StringConstant(name, place) = &parts.0
        {
            found.push((name.to_string(), *place));
        }
        true
    });
    found
}

/// Properties of a variable that are given values in these statements, which only can be read, by position.
pub(crate) fn assigned_properties(statements: &[Stmt], variable: &str, file: &str) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut on_node = |path: &[ASTNode<'_>]| {
        if let Some(ASTNode::Stmt(Stmt::Assignment(parts))) = path.last()
            && let Expr::Dot(dot, ..) = &parts.1.lhs
            && is_variable(&dot.lhs, variable)
            && let Some((name, place)) = property_of(&dot.rhs)
        {
            let message = format!("`{variable}.{name}` can be read, but not changed");
            let help = format!("plat words lists what a {variable} can be told");
            faults.push(at(place, Fault::new(file, message).with_hint(Some(help))));
        }
        true
    };
    for statement in statements {
        statement.walk(&mut Vec::new(), &mut on_node);
    }
    in_order(faults)
}

/// Options in maps written where a function takes options, that it does not know, by position.
pub(crate) fn unknown_options(ast: &AST, file: &str, text: &str, words: &Vocabulary) -> Vec<Fault> {
    unknown_keys(ast, file, text, |name| words.options_of(name))
}

/// The same of words whose options are known from elsewhere.
pub(crate) fn unknown_keys<'a>(
    ast: &AST,
    file: &str,
    text: &str,
    options_of: impl Fn(&str) -> Option<BTreeSet<&'a str>>,
) -> Vec<Fault> {
    let mut faults = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        let Some(called) = path.last().and_then(called).filter(|called| is_plain(called.call)) else { return true };
        let name = called.call.name.as_str();
        let Some(known) = options_of(name) else { return true };
        for Key { name: key, place, .. } in called.call.args.iter().flat_map(|argument| keys_of(argument, text)) {
            if !known.contains(key.as_str()) {
                let near = hint(&key, known.iter().copied());
                let fault = Fault::new(file, format!("`{name}` has no option `{key}`")).with_hint(near);
                faults.push(Fault { line: place.0, column: place.1, ..fault });
            }
        }
        true
    });
    in_order(faults)
}

/// The keys of a map that is written as an argument, each with its line and column.
fn keys_of(argument: &Expr, text: &str) -> Vec<Key> {
    let place = |at: Position| (at.line().unwrap_or(0) as u32, at.position().unwrap_or(0) as u32);
    match argument {
        Expr::Map(map, _) => {
            let key = |(key, value): &(rhai::Ident, Expr)| Key {
                name: key.name.to_string(),
                place: place(key.pos),
                value: value.get_literal_value(None),
            };
            map.0.iter().map(key).collect()
        }
        // A map of nothing but constants is one itself, and forgets where its keys stand.
        Expr::DynamicConstant(value, at) => {
            let (line, column) = place(*at);
            let found = |(name, value): (&rhai::Identifier, &Dynamic)| Key {
                name: name.to_string(),
                place: key_position(text, line, column, name).unwrap_or((line, column)),
                value: Some(value.clone()),
            };
            value.read_lock::<Map>().map_or_else(Vec::new, |map| map.iter().map(found).collect())
        }
        _ => Vec::new(),
    }
}

/// A closure that uses a variable from around it where it may not, by the variable: refused, before anything runs. What a
/// closure holds is shared, and so could hold itself, which is never freed; could hold a closure in a closure without an end,
/// which overflows the stack when it is dropped; and could be asked for what is being changed, where each try waits. Where
/// it is handed on at once to a word that does not keep it, and does not change what it holds, none of that can be.
pub(super) fn captured(ast: &AST, closures: Closures) -> Option<(String, Position)> {
    let mut found = None;
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let [around @ .., ASTNode::Expr(Expr::Stmt(_)), ASTNode::Stmt(Stmt::Share(names))] = path {
            let names: Vec<&str> = names.iter().map(|(name, _)| name.name.as_str()).collect();
            let is_kept = closures == Closures::Closed || !is_handed_on(around, &names);
            found = found.take().or_else(|| is_kept.then(|| shared(path)).flatten());
        } else if let Some(ASTNode::Stmt(Stmt::Share(_))) = path.last() {
            found = found.take().or_else(|| shared(path));
        }
        found.is_none()
    });
    found
}

/// The first variable that a closure takes.
fn shared(path: &[ASTNode<'_>]) -> Option<(String, Position)> {
    match path.last() {
        Some(ASTNode::Stmt(Stmt::Share(names))) => names.first().map(|(name, _)| (name.name.to_string(), name.pos)),
        _ => None,
    }
}

/// Words of lists that ask a closure and forget it.
const ASKING: [&str; 7] = ["all", "filter", "find", "map", "reduce", "some", "index_of"];

/// Whether a closure below these nodes, which takes variables, is an argument of a word that does not keep it: of `site`, or
/// of a list that is none of these variables.
fn is_handed_on(around: &[ASTNode<'_>], names: &[&str]) -> bool {
    match around {
        [.., ASTNode::Expr(Expr::FnCall(call, _)), ASTNode::Expr(Expr::Map(..))]
        | [.., ASTNode::Stmt(Stmt::FnCall(call, _)), ASTNode::Expr(Expr::Map(..))] => call.name == "site",
        [.., ASTNode::Expr(Expr::FnCall(call, _)) | ASTNode::Stmt(Stmt::FnCall(call, _))] => {
            let is_of = |argument: &Expr| matches!(argument, Expr::Variable(of, ..) if names.contains(&of.1.as_str()));
            call.name == "assert_all" && !call.args.iter().any(is_of)
        }
        [before @ .., ASTNode::Expr(Expr::MethodCall(call, _))] => {
            let is_of = |node: &ASTNode<'_>| match node {
                ASTNode::Expr(Expr::Dot(parts, ..) | Expr::Index(parts, ..)) => {
                    matches!(&parts.lhs, Expr::Variable(of, ..) if names.contains(&of.1.as_str()))
                }
                _ => false,
            };
            ASKING.contains(&&*call.name) && !before.iter().rev().take(4).any(is_of)
        }
        _ => false,
    }
}

/// The names of all properties that a script asks for, of whatever.
pub(crate) fn properties(ast: &AST) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let Some(ASTNode::Expr(expression)) = path.last()
            && let Some((name, _)) = property_of(expression)
        {
            found.insert(name.to_owned());
        }
        true
    });
    found
}

/// Where a function is called for the first time.
pub(crate) fn first_call(ast: &AST, name: &str) -> Option<Position> {
    let mut found = None;
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        found =
            found.or_else(|| called(path.last()?).filter(|called| called.call.name == name).map(|called| called.at));
        found.is_none()
    });
    found
}

/// A rule that a script loads by a written name, or a test as its own.
pub(crate) struct NamedRule {
    /// None for a test's own.
    pub name: Option<String>,
    /// Where.
    pub at: Position,
    /// The parameters that are written with it.
    pub keys: Vec<Key>,
}

/// A key of a map as it is written.
pub(crate) struct Key {
    pub name: String,
    /// Its line and column.
    pub place: (u32, u32),
    /// What it is set to, where that is a plain value.
    pub value: Option<Dynamic>,
}

impl NamedRule {
    /// The line and the column, from 1; 0 where that is unknown.
    pub fn place(&self) -> (u32, u32) {
        (self.at.line().unwrap_or(0) as u32, self.at.position().unwrap_or(0) as u32)
    }

    /// Parameters that are written with it and that the rule does not have, of those that it has.
    pub fn unknown_parameters(&self, known: &[&str], file: &str) -> Vec<Fault> {
        let is_unknown = |key: &&Key| !known.contains(&key.name.as_str());
        let fault = |key: &Key| {
            let help = hint(&key.name, known.iter().copied()).unwrap_or_else(|| "the rule declares none".into());
            key.fault(file, format!("there is no parameter `{}`", key.name), Some(help))
        };
        self.keys.iter().filter(is_unknown).map(fault).collect()
    }

    /// Plain values that are written with it and that do not suit the parameters of the rule.
    pub fn unsuited_values(&self, params: &ParamSet, file: &str) -> Vec<Fault> {
        let wrong = |key: &Key| {
            let value = key.value.as_ref().filter(|_| params.get(&key.name).is_some())?;
            let error = params.with_dynamic(&key.name, value).err()?;
            Some(key.fault(file, error.message, error.hint))
        };
        self.keys.iter().filter_map(wrong).collect()
    }
}

/// The presets that a script names, each with its line and column, from 1.
pub(crate) fn named_presets(ast: &AST) -> Vec<(String, (u32, u32))> {
    let mut found = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        let called = path.last().and_then(called).filter(|called| called.call.name == "preset");
        if let Some((Expr::StringConstant(name, _), at)) =
            called.and_then(|called| Some((called.call.args.first()?, called.at)))
        {
            let place = (at.line().unwrap_or(0) as u32, at.position().unwrap_or(0) as u32);
            found.push((name.to_string(), place));
        }
        true
    });
    found
}

impl Key {
    fn fault(&self, file: &str, message: String, hint: Option<String>) -> Fault {
        let (line, column) = self.place;
        Fault { line, column, ..Fault::new(file, message).with_hint(hint) }
    }
}

/// The rules that a script loads.
pub(crate) fn named_rules(ast: &AST, text: &str) -> Vec<NamedRule> {
    let mut found = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        let Some(called) = path.last().and_then(called).filter(|called| called.call.name == "rule") else {
            return true;
        };
        let (name, values) = match &called.call.args[..] {
            [Expr::StringConstant(name, _), values @ ..] => (Some(name.to_string()), values),
            [Expr::Map(..) | Expr::DynamicConstant(..)] | [] => (None, &called.call.args[..]),
            _ => return true,
        };
        let keys = values.first().map_or_else(Vec::new, |values| keys_of(values, text));
        found.push(NamedRule { name, at: called.at, keys });
        true
    });
    found
}

fn property_of(expression: &Expr) -> Option<(&str, Position)> {
    match expression {
        Expr::Property(property, at) => Some((property.2.as_str(), *at)),
        // In `p.a.b` what stands behind the first dot is `a.b`.
        Expr::Dot(dot, ..) | Expr::Index(dot, ..) => property_of(&dot.lhs),
        _ => None,
    }
}

fn faults_of_calls(ast: &AST, fault_of: impl Fn(&Called<'_>) -> Option<Fault>) -> Vec<Fault> {
    let mut faults = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        faults.extend(path.last().and_then(called).and_then(|called| fault_of(&called)));
        true
    });
    in_order(faults)
}

fn called<'a>(node: &ASTNode<'a>) -> Option<Called<'a>> {
    match node {
        ASTNode::Expr(Expr::FnCall(call, at)) | ASTNode::Stmt(Stmt::FnCall(call, at)) => {
            Some(Called { call, at: *at, is_method: false })
        }
        ASTNode::Expr(Expr::MethodCall(call, at)) => Some(Called { call, at: *at, is_method: true }),
        _ => None,
    }
}

/// Whether a call names a function of this file or a word, and is no operator, nor what Rhai makes of a closure that takes
/// variables.
fn is_plain(call: &FnCallExpr) -> bool {
    let plain = call.namespace.is_empty() && call.op_token.is_none() && call.name != "curry";
    plain && call.name.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

fn at(place: Position, fault: Fault) -> Fault {
    Fault { line: place.line().unwrap_or(0) as u32, column: place.position().unwrap_or(0) as u32, ..fault }
}

fn in_order(mut faults: Vec<Fault>) -> Vec<Fault> {
    faults.sort_by_key(|fault| (fault.line, fault.column));
    faults.dedup();
    faults
}
