//! The words that a script may use, read back from its engine: for hints and for checks before a run.

use rhai::{AST, Engine};
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
}

/// What Rhai itself provides without registration.
const BUILT_IN: [&str; 8] = ["type_of", "Fn", "call", "is_shared", "is_def_fn", "is_def_var", "print", "debug"];

impl Vocabulary {
    /// All words of an engine, and the functions of a script.
    pub fn of(engine: &Engine, ast: &AST) -> Self {
        let mut words = Self::default();
        for signature in engine.gen_fn_signatures(true) {
            words.read(&signature);
        }
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
            let kind = arguments.rsplit(':').next().unwrap_or("").trim().trim_start_matches("&mut ");
            self.properties.entry(kind.to_owned()).or_default().insert(property.to_owned());
        } else if is_identifier(name) {
            let form = format!("{name}({})", plain_arguments(arguments));
            self.forms.entry(name.to_owned()).or_default().insert(form);
            let count = if arguments.trim().is_empty() { 0 } else { split(arguments, ',').len() };
            self.native.entry(name.to_owned()).or_default().insert(count);
        }
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

    /// How a function is written, at most three ways.
    pub fn forms_of(&self, name: &str) -> Vec<String> {
        self.forms.get(name).map(|forms| forms.iter().take(3).cloned().collect()).unwrap_or_default()
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

/// Argument names alone; for unnamed arguments their types.
fn plain_arguments(list: &str) -> String {
    let plain = |argument: &str| match split(argument, ':').last() {
        Some(kind) if argument.len() > kind.len() => {
            let name = argument[..argument.len() - kind.len()].trim_end_matches(':').trim();
            if name == "_" { kind.trim().to_owned() } else { name.to_owned() }
        }
        _ => argument.trim().to_owned(),
    };
    split(list, ',').into_iter().map(plain).filter(|name| name != "this").collect::<Vec<_>>().join(", ")
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
        assert_eq!(plain_arguments("_: int, this: &mut tip"), "int");
        assert_eq!(plain_arguments("place: script::plan::MapRef"), "place");
        assert_eq!(plain_arguments(""), "");
    }
}
