//! The words that a script may use, read back from its engine: for hints and for checks before a run.

use crate::rule::RuleKind;
use rhai::{AST, Engine, FuncInfo};
use std::any::TypeId;
use std::collections::{BTreeMap, BTreeSet};

/// Functions and properties by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Vocabulary {
    forms: BTreeMap<String, BTreeSet<String>>,
    properties: BTreeMap<String, BTreeSet<String>>,
    /// How many arguments native functions take, what they are called on included.
    native: BTreeMap<String, BTreeSet<usize>>,
    /// How many arguments functions of the script take.
    own: BTreeMap<String, BTreeSet<usize>>,
    /// What is called on a type, by the type and the name: its forms by how many arguments they take.
    methods: BTreeMap<String, BTreeMap<String, BTreeMap<usize, String>>>,
}

/// What can be called on anything.
const ON_ALL: [&str; 7] = ["type_of", "to_string", "to_debug", "is_shared", "call", "print", "debug"];

/// What Rhai itself provides without registration.
const BUILT_IN: [&str; 8] = ["type_of", "Fn", "call", "is_shared", "is_def_fn", "is_def_var", "print", "debug"];

impl Vocabulary {
    /// All words of an engine, and the functions of a script.
    pub fn of(engine: &Engine, ast: &AST) -> Self {
        let mut words = Self::default();
        for signature in engine.gen_fn_signatures(true) {
            words.read(&signature);
        }
        words.read_methods(engine);
        for function in ast.iter_functions() {
            let form = format!("{}({})", function.name, function.params.join(", "));
            words.forms.entry(function.name.to_owned()).or_default().insert(form);
            words.own.entry(function.name.to_owned()).or_default().insert(function.params.len());
        }
        words.forms.extend(BUILT_IN.map(|name| (name.to_owned(), BTreeSet::from([format!("{name}(…)")]))));
        words
    }

    /// Reads `name(a: type, …) -> type`, or `get$name(type)`.
    fn read(&mut self, signature: &str) {
        let Some((name, rest)) = signature.split_once('(') else { return };
        let arguments = rest.split(") ->").next().unwrap_or(rest);
        let arguments = arguments.strip_suffix(')').unwrap_or(arguments);
        let name = name.trim();
        if let Some(property) = name.strip_prefix("get$").or_else(|| name.strip_prefix("get ")) {
            let kind = kind_of(arguments);
            self.properties.entry(kind.to_owned()).or_default().insert(property.to_owned());
        } else if is_identifier(name) {
            let form = format!("{name}({})", plain_arguments(arguments));
            self.forms.entry(name.to_owned()).or_default().insert(form);
            let count = if arguments.trim().is_empty() { 0 } else { split(arguments, ',').len() };
            self.native.entry(name.to_owned()).or_default().insert(count);
        }
    }

    /// Reads what is called on what rules are asked about.
    fn read_methods(&mut self, engine: &Engine) {
        let read = |info: FuncInfo<'_>| {
            let first = *info.metadata.param_types.first()?;
            Some((info.metadata.gen_signature(|name| name.to_owned().into()), first, info.metadata.param_types.len()))
        };
        let all = engine.collect_fn_metadata(None, read, false);
        let subjects = RuleKind::ALL.map(|kind| kind.arguments()[0]);
        let kinds: BTreeMap<TypeId, &str> =
            all.iter().filter_map(|(text, first, _)| Some((*first, kind_of_getter(text)?))).collect();
        for (signature, first, count) in &all {
            let Some((name, rest)) = signature.split_once('(') else { continue };
            let kind = kinds.get(first).filter(|kind| subjects.contains(kind));
            let (Some(kind), true) = (kind, is_identifier(name)) else { continue };
            let arguments = rest.rsplit_once(')').map_or(rest, |(arguments, _)| arguments);
            let form = format!("{kind}.{name}({})", plain_arguments(arguments));
            let forms = self.methods.entry((*kind).to_owned()).or_default().entry(name.to_owned()).or_default();
            forms.insert(count - 1, form);
        }
    }

    /// Whether something can be called on a type with so many arguments; true where there is no telling.
    pub fn is_method(&self, kind: &str, name: &str, arguments: usize) -> bool {
        let Some(methods) = self.methods.get(kind) else { return true };
        let is_own = self.own.contains_key(name) || ON_ALL.contains(&name);
        is_own || methods.get(name).is_some_and(|forms| forms.contains_key(&arguments))
    }

    /// How something that is called on a type is written; nothing where it has none of that name.
    pub fn methods_of(&self, kind: &str, name: &str) -> Vec<&str> {
        let forms = self.methods.get(kind).and_then(|methods| methods.get(name));
        forms.map_or_else(Vec::new, |forms| forms.values().map(String::as_str).collect())
    }

    /// Whether the script has a function of this name.
    pub fn is_own(&self, name: &str) -> bool {
        self.own.contains_key(name)
    }

    /// The names of all that is called on a type.
    pub fn names_of_methods(&self, kind: &str) -> impl Iterator<Item = &str> + Clone {
        self.methods.get(kind).into_iter().flat_map(|methods| methods.keys()).map(String::as_str)
    }

    /// The types that something of this name is called on.
    pub fn with_method(&self, name: &str) -> Vec<&str> {
        self.methods.iter().filter(|(_, methods)| methods.contains_key(name)).map(|(kind, _)| kind.as_str()).collect()
    }

    /// Whether something is called so.
    pub fn has_function(&self, name: &str) -> bool {
        self.forms.contains_key(name)
    }

    /// Whether a function can be called with so many arguments; true where there is no telling. As a method, what it is
    /// called on counts for native functions only.
    pub fn takes(&self, name: &str, arguments: usize, is_method: bool) -> bool {
        let (native, own) = (self.native.get(name), self.own.get(name));
        let is_told = !BUILT_IN.contains(&name) && (native.is_some() || own.is_some());
        !is_told
            || native.is_some_and(|counts| counts.contains(&(arguments + usize::from(is_method))))
            || own.is_some_and(|counts| counts.contains(&arguments))
    }

    /// All function names.
    pub fn functions(&self) -> impl Iterator<Item = &str> + Clone {
        self.forms.keys().map(String::as_str)
    }

    /// How a function is written, at most three ways. Letters are left out where numbers will do.
    pub fn forms_of(&self, name: &str) -> Vec<String> {
        let Some(forms) = self.forms.get(name) else { return Vec::new() };
        let of_letters = |form: &&String| form.contains("char");
        let others: Vec<&String> = forms.iter().filter(|form| !of_letters(form)).collect();
        let told = if others.is_empty() { forms.iter().collect() } else { others };
        told.into_iter().take(3).cloned().collect()
    }

    /// The options that a function takes, as its forms tell them: `rings(x, y, #{ inner, spacing })`; `None` where one of
    /// them does not tell all.
    pub fn options_of(&self, name: &str) -> Option<BTreeSet<&str>> {
        let forms = self.forms.get(name)?;
        let told = forms.iter().filter_map(|form| Some(form.split_once("#{")?.1.split_once('}')?.0));
        let keys: BTreeSet<&str> = told.flat_map(|keys| keys.split(',').map(str::trim)).collect();
        let is_whole = forms.iter().all(|form| !form.contains("options"));
        let is_plain = !keys.is_empty() && keys.iter().all(|key| is_identifier(key));
        (is_whole && is_plain).then_some(keys)
    }

    /// What can be asked of a type.
    pub fn properties_of(&self, kind: &str) -> impl Iterator<Item = &str> + Clone {
        self.properties.get(kind).into_iter().flatten().map(String::as_str)
    }
}

/// The type that a property is of, from the arguments of its getter.
fn kind_of(arguments: &str) -> &str {
    arguments.rsplit(':').next().unwrap_or("").trim().trim_start_matches("&mut ")
}

/// The same from its signature; `None` where it is none, or the type's name is no word.
fn kind_of_getter(signature: &str) -> Option<&str> {
    let kind = kind_of(signature.strip_prefix("get$")?.split_once('(')?.1.split_once(')')?.0);
    is_identifier(kind).then_some(kind)
}

/// Argument names alone; for unnamed arguments their types, numbers whatever their kind.
fn plain_arguments(list: &str) -> String {
    let plain = |argument: &str| match split(argument, ':').last() {
        Some(kind) if argument.len() > kind.len() => {
            let name = argument[..argument.len() - kind.len()].trim_end_matches(':').trim();
            if name == "_" { numbers(kind.trim()).to_owned() } else { name.to_owned() }
        }
        _ => numbers(argument.trim()).to_owned(),
    };
    split(list, ',').into_iter().map(plain).filter(|name| name != "this").collect::<Vec<_>>().join(", ")
}

fn numbers(kind: &str) -> &str {
    if matches!(kind, "i64" | "f64" | "int" | "float") { "number" } else { kind }
}

/// The parts of a text between marks that stand outside of brackets; `::` is no mark.
pub(crate) fn split(text: &str, mark: char) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (at, letter) in text.char_indices() {
        match letter {
            '{' | '(' | '[' | '<' => depth += 1,
            '}' | ')' | ']' | '>' => depth -= 1,
            _ if letter == mark && depth == 0 => {
                let is_path = mark == ':' && (text[at + 1..].starts_with(':') || text[..at].ends_with(':'));
                if !is_path {
                    parts.push(&text[start..at]);
                    start = at + 1;
                }
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_keep_their_maps_whole() {
        assert_eq!(plain_arguments("#{ name: parameter }: map"), "#{ name: parameter }");
        assert_eq!(plain_arguments("map: ?, #{ least, full, pace }: map"), "map, #{ least, full, pace }");
        assert_eq!(plain_arguments("_: int, this: &mut tip"), "number");
        assert_eq!(plain_arguments("place: script::plan::MapRef"), "place");
        assert_eq!(plain_arguments(""), "");
    }
}
