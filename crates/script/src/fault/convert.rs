//! From Rhai's errors to faults: the innermost file and position, plain words, a hint.

use super::{Call, Complaint, Fault, foreign, plural, text};
use crate::host::{Texts, Vocabulary};
use crate::names::{hint, nearest};
use crate::rule::RuleKind;
use rhai::{Dynamic, EvalAltResult, LexError, ParseErrorType, Position};
use std::any::Any;

/// What turning an error into a fault needs to know.
pub(crate) struct Diagnosis<'a> {
    /// The script that was run.
    pub file: &'a str,
    /// The texts of all scripts read so far.
    pub texts: &'a Texts,
    /// The words that scripts may use.
    pub vocabulary: &'a Vocabulary,
    /// How many operations the script could take.
    pub operations: u64,
}

/// An error's file and position while its frames are peeled off.
struct Spot {
    file: String,
    position: Position,
    /// The calls passed, the outermost first.
    calls: Vec<Call>,
}

/// What a message says, what helps, and the options key it is about.
type Words = Complaint;

/// The fault of a Rhai error: placed where the innermost frame failed.
pub(crate) fn of_error(error: EvalAltResult, diagnosis: &Diagnosis<'_>) -> Fault {
    let mut spot = Spot { file: diagnosis.file.to_owned(), position: Position::NONE, calls: Vec::new() };
    let inner = innermost(error, &mut spot);
    if let EvalAltResult::ErrorRuntime(payload, _) = &inner
        && let Some(fault) = payload.read_lock::<Complaint>().and_then(|complaint| complaint.fault.clone())
    {
        // A rule that a city script loads has told its own fault already.
        return *fault;
    }
    let words = words_of(inner, diagnosis, &spot);
    let line = spot.position.line().unwrap_or(0) as u32;
    let column = if line == 0 { 0 } else { spot.position.position().unwrap_or(1) as u32 };
    let (line, column) = on_key(&words, diagnosis, &spot.file, (line, column));
    let (message, hint) = printable(words.message, words.hint);
    let calls = spot.calls.into_iter().rev().collect();
    Fault { line, column, hint, calls, ..Fault::new(spot.file, message) }.measured(diagnosis.texts)
}

/// A message without characters that a terminal would obey or hide.
fn printable(message: String, hint: Option<String>) -> (String, Option<String>) {
    let is_hidden = |letter: char| letter.is_control() && letter != '\n';
    if !message.contains(is_hidden) {
        return (message, hint);
    }
    let shown = |letter: char| if is_hidden(letter) { format!("U+{:04X}", u32::from(letter)) } else { letter.into() };
    let help = "a script is plain UTF-8 text: save it so, without control characters";
    (message.chars().map(shown).collect(), Some(help.to_owned()))
}

/// The fault of a panic in native code: a defect of the program, never of the script.
pub(crate) fn of_panic(file: &str, payload: &(dyn Any + Send)) -> Fault {
    let text = payload.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    let message = format!("the program failed inside: {}", text.as_deref().unwrap_or("no reason given"));
    Fault::new(file, message).with_hint(Some("this is a defect of the program, please report it".into()))
}

/// Peels off the frames of calls and modules; the outer position counts where the inner one is unknown.
fn innermost(mut error: EvalAltResult, spot: &mut Spot) -> EvalAltResult {
    loop {
        let own = error.position();
        if !own.is_none() {
            spot.position = own;
        }
        let (file, inner) = match error {
            EvalAltResult::ErrorInFunctionCall(function, file, inner, at) => {
                spot.calls.push(call(function, spot, at));
                (file, inner)
            }
            EvalAltResult::ErrorInModule(file, inner, _) => (file, inner),
            other => return other,
        };
        if !file.is_empty() && !inner_position(&inner).is_none() {
            spot.file = file;
        }
        error = *inner;
    }
}

/// A call that an error came through.
fn call(function: String, spot: &Spot, at: Position) -> Call {
    // Rhai names closures by a number.
    let function = if function.starts_with(ANONYMOUS) { "a closure".to_owned() } else { function };
    let (line, column) = (at.line().unwrap_or(0) as u32, at.position().unwrap_or(0) as u32);
    Call { function, file: spot.file.clone(), line, column }
}

/// The position of an error or, where it has none, of the error inside it.
fn inner_position(error: &EvalAltResult) -> Position {
    match error {
        EvalAltResult::ErrorInFunctionCall(_, _, inner, at) | EvalAltResult::ErrorInModule(_, inner, at)
            if at.is_none() =>
        {
            inner_position(inner)
        }
        other => other.position(),
    }
}

/// Moves the position onto the options key that is to blame.
fn on_key(words: &Words, diagnosis: &Diagnosis<'_>, file: &str, at: (u32, u32)) -> (u32, u32) {
    let Some(key) = &words.key else { return at };
    let Some(text) = diagnosis.texts.get(file) else { return at };
    text::key_position(&text, at.0, at.1, key).unwrap_or(at)
}

fn words_of(error: EvalAltResult, diagnosis: &Diagnosis<'_>, spot: &Spot) -> Words {
    use EvalAltResult as E;
    let file = spot.file.as_str();
    match error {
        E::ErrorRuntime(payload, _) => thrown(&payload),
        E::ErrorParsing(kind, _) => syntax(&kind, diagnosis, file, spot.position),
        E::ErrorFunctionNotFound(signature, _) => unknown_function(&signature, diagnosis.vocabulary),
        E::ErrorVariableNotFound(name, _) => unknown_variable(&name, diagnosis, file, spot.position),
        E::ErrorPropertyNotFound(name, _) => Complaint::new(format!("there is no `{name}` in this map")),
        E::ErrorDotExpr(message, _) => unknown_property(&message, diagnosis.vocabulary),
        E::ErrorTerminated(token, _) if token.is::<Complaint>() => token.cast(),
        E::ErrorTerminated(..) => {
            let limit = diagnosis.operations;
            Complaint::new(format!("stopped after {limit} operations")).hint("is there an endless loop?")
        }
        E::ErrorStackOverflow(_) => {
            Complaint::new("calls are nested too deeply").hint("does a function call itself without an end?")
        }
        E::ErrorDataTooLarge(kind, _) => too_large(&kind),
        E::ErrorMismatchOutputType(wanted, got, _) | E::ErrorMismatchDataType(wanted, got, _) => {
            mismatch(&plain_type(&wanted), &plain_type(&got))
        }
        E::ErrorArithmetic(message, _) => Complaint::new(lower_first(&message)).maybe_hint(of_arithmetic(&message)),
        E::ErrorArrayBounds(length, index, _) => out_of_list(length, index),
        E::ErrorIndexingType(what, _) => {
            let subject = plain_type(what.split(" [").next().unwrap_or_default());
            let help = "lists, maps and texts can; of other things one asks by a point: p.name, tip.x";
            Complaint::new(format!("{subject} cannot be asked with […]")).hint(help)
        }
        other => {
            let mut other = other;
            other.set_position(Position::NONE);
            Complaint::new(lower_first(&other.to_string()))
        }
    }
}

fn mismatch(wanted: &str, got: &str) -> Words {
    let help = match (wanted, got) {
        ("true or false", "a number" | "a whole number") => Some("compare it with something, such as `… > 0`"),
        ("true or false", _) => Some("compare it with something, such as `… == \"major\"`"),
        _ => None,
    };
    Complaint::new(format!("expected {wanted}, got {got}")).maybe_hint(help.map(str::to_owned))
}

fn of_arithmetic(message: &str) -> Option<String> {
    let help = if message.contains("by zero") {
        "was something divided by 0? Test for it first"
    } else if message.contains("overflow") {
        "whole numbers have an end: write one of them with a point, such as 2.0"
    } else {
        return None;
    };
    Some(help.into())
}

fn out_of_list(length: usize, index: i64) -> Words {
    let message = format!("there is no item {index}: the list has {}", plural(length, "item"));
    let help = match length {
        0 => "test `is_empty()` first".to_owned(),
        1 => "its only item is 0".to_owned(),
        _ => format!("items are counted from 0 to {}", length - 1),
    };
    Complaint::new(message).hint(help)
}

/// A native word's complaint, or what a script itself threw.
fn thrown(payload: &Dynamic) -> Words {
    let text = || {
        let text = match payload.to_string() {
            text if text.trim().is_empty() => "the script throws an empty text".to_owned(),
            // Rhai shows a native value as its Rust type.
            text if text.contains("::") && !payload.is_string() => "the script throws a value without words".to_owned(),
            text => text,
        };
        Complaint::new(text).hint("the script itself throws this")
    };
    payload.read_lock::<Complaint>().map_or_else(text, |complaint| complaint.clone())
}

fn too_large(kind: &str) -> Words {
    let what = match kind {
        k if k.contains("rray") => "a list",
        k if k.contains("tring") => "a text",
        k if k.contains("ap") => "a map",
        _ => "a value",
    };
    Complaint::new(format!("{what} grew too large")).hint("does a loop collect more than it should?")
}

fn syntax(kind: &ParseErrorType, diagnosis: &Diagnosis<'_>, file: &str, at: Position) -> Words {
    match kind {
        ParseErrorType::VariableUndefined(name) => unknown_variable(name, diagnosis, file, at),
        ParseErrorType::ModuleUndefined(name) => {
            Complaint::new(format!("no module is imported as `{name}`")).hint(format!("import \"…\" as {name};"))
        }
        ParseErrorType::Reserved(symbol) if symbol.starts_with("**") => powers_are_a_function(),
        ParseErrorType::Reserved(word) if text::identifiers(word).any(|own| own == word) => {
            let help = format!(
                "the language keeps this word: choose another name; as a key of a map it stands in quotes, \"{word}\""
            );
            let help = foreign::instead(word).map_or(help, str::to_owned);
            Complaint::new(format!("there is no `{word}`")).hint(help)
        }
        ParseErrorType::Reserved(symbol) | ParseErrorType::UnknownOperator(symbol)
            if let Some((message, help)) = foreign::symbol(symbol) =>
        {
            Complaint::new(message).hint(help)
        }
        ParseErrorType::PropertyExpected => match not_a_name(diagnosis, file, at, "a property") {
            words if words.hint.as_ref().is_some_and(|hint| hint.starts_with("`import`")) => {
                words.hint("keywords are no names: city(#{ … }) takes `imported`, not `import`")
            }
            words => words,
        },
        ParseErrorType::UnknownOperator(symbol) if symbol.starts_with("**") => powers_are_a_function(),
        ParseErrorType::VariableExpected => not_a_name(diagnosis, file, at, "a variable"),
        ParseErrorType::FnMissingName => not_a_name(diagnosis, file, at, "a function"),
        ParseErrorType::MissingToken(wanted, _) => missing_token(wanted, kind, diagnosis, file, at),
        ParseErrorType::FnDuplicatedDefinition(name, count) => {
            let message = format!("there are two functions `{name}` with {}", plural(*count, "argument"));
            Complaint::new(message).hint("give one of them another name")
        }
        ParseErrorType::FnDuplicatedParam(function, name) => {
            Complaint::new(format!("two arguments of `{function}` are called `{name}`"))
                .hint("give one of them another name")
        }
        ParseErrorType::FnMissingParams(name) => {
            Complaint::new(format!("`fn {name}` tells no arguments")).hint(format!("write fn {name}() {{ … }}"))
        }
        ParseErrorType::FnMissingBody(name) => {
            Complaint::new(format!("`fn {name}` has no body")).hint(format!("write fn {name}(…) {{ … }}"))
        }
        ParseErrorType::WrongFnDefinition => Complaint::new("a function stands within another, or within a block")
            .hint("move it out, to where the other functions are: it sees its own arguments alone in any case"),
        ParseErrorType::WrongDocComment => Complaint::new("`///` says what a function does, and none follows")
            .hint("is `fn` before its name missing? A remark begins with `//`"),
        ParseErrorType::DuplicatedProperty(name) => {
            Complaint::new(format!("there are two `{name}` in this map")).hint("keep one of them")
        }
        ParseErrorType::LoopBreak => {
            Complaint::new("`break` and `continue` stand in loops alone").hint("leave a function with `return`")
        }
        ParseErrorType::AssignmentToInvalidLHS(_) => Complaint::new("what stands left of `=` cannot be given a value")
            .hint("a variable can, an element of a list or a map; `==` compares"),
        ParseErrorType::DuplicatedVariable(name) => {
            Complaint::new(format!("there are two `{name}` here")).hint("give one of them another name")
        }
        ParseErrorType::AssignmentToConstant(name) if !name.is_empty() => {
            Complaint::new(format!("`{name}` is a constant")).hint(format!("make it a variable: let {name} = …;"))
        }
        ParseErrorType::WrongSwitchIntegerCase => {
            Complaint::new("a case of one number cannot follow one of a range").hint("put the ranges behind it")
        }
        ParseErrorType::WrongSwitchDefaultCase => {
            Complaint::new("`_` must be the last case").hint("put the other cases before it")
        }
        ParseErrorType::ExprTooDeep => Complaint::new("this expression is too deep or too long")
            .hint("give a part of it a name on a line before, let part = …;, or a function of its own"),
        ParseErrorType::BadInput(LexError::UnexpectedInput(word)) if word == "else" => {
            Complaint::new("this `else` has no `if`")
                .hint("it stands behind the `}` of an `if`, with nothing in between")
        }
        ParseErrorType::BadInput(LexError::UnexpectedInput(letters))
            if letters.chars().all(|letter| letter.is_alphabetic() && !letter.is_ascii()) =>
        {
            Complaint::new(format!("a name cannot have `{letters}`"))
                .hint("names are made of the letters a to z, digits and `_`; texts may have all letters")
        }
        ParseErrorType::BadInput(LexError::MalformedChar(_)) => {
            Complaint::new("this is neither one letter nor a text").hint("texts stand in double quotes: \"old town\"")
        }
        ParseErrorType::BadInput(LexError::ImproperSymbol(symbol, _))
            if let Some((message, help)) = foreign::symbol(symbol) =>
        {
            Complaint::new(message).hint(help)
        }
        ParseErrorType::BadInput(LexError::UnterminatedString) => {
            Complaint::new("this text has no end").hint("close it with the same quote in the same line")
        }
        other => {
            let message = lower_first(&other.to_string());
            if message.contains("'eval' is disabled") {
                return Complaint::new("there is no `eval`")
                    .hint("what a rule does stands in its file: write a function");
            }
            if message.contains("typo of '=='") {
                return Complaint::new("`=` gives a variable a value").hint("write `==` to compare");
            }
            Complaint::new(message).hint("is a bracket, a comma or a `;` missing before this place?")
        }
    }
}

fn not_a_name(diagnosis: &Diagnosis<'_>, file: &str, at: Position, what: &str) -> Words {
    let text = diagnosis.texts.get(file).unwrap_or_default();
    let from = text::from_place(&text, at.line().unwrap_or(0), at.position().unwrap_or(0));
    let complaint = Complaint::new(format!("expecting the name of {what}"));
    match text::identifiers(from).next().filter(|word| from.starts_with(word)) {
        // As in C: for (let i = 0; …).
        _ if what == "a variable" && is_in_brackets_of_for(&text, at) => {
            complaint.hint("a loop is written for i in 0..3 { … }")
        }
        Some(word) => complaint.hint(
            foreign::instead(word)
                .map_or_else(|| format!("`{word}` is a word of the language: choose another name"), str::to_owned),
        ),
        None => complaint.hint("a name is made of letters, digits and `_`, and begins with a letter"),
    }
}

/// Whether a place stands in a line that begins with `for (`.
fn is_in_brackets_of_for(text: &str, at: Position) -> bool {
    let row = text::from_place(text, at.line().unwrap_or(0), 1).trim_start();
    row.strip_prefix("for").is_some_and(|rest| rest.trim_start().starts_with('('))
}

fn missing_token(wanted: &str, kind: &ParseErrorType, diagnosis: &Diagnosis<'_>, file: &str, at: Position) -> Words {
    let complaint = Complaint::new(lower_first(&kind.to_string()));
    let text = diagnosis.texts.get(file).unwrap_or_default();
    let rest = text::from_place(&text, at.line().unwrap_or(0), at.position().unwrap_or(0));
    let word = text::identifiers(rest).next().filter(|word| rest.starts_with(word));
    if let Some(help) = word.and_then(foreign::instead) {
        return complaint.hint(help);
    }
    if kind.to_string().contains("iteration variable") {
        return complaint.hint("a loop is written for i in 0..3 { … }");
    }
    let opens = match wanted {
        ";" => return complaint.hint("end the statement before this place with `;`"),
        "}" => '{',
        ")" => '(',
        "]" => '[',
        other => return complaint.hint(format!("is a `{other}` missing before this place?")),
    };
    let open = diagnosis.texts.get(file).and_then(|text| text::unclosed(&text, opens));
    match open {
        Some((line, column)) => complaint.hint(format!("the `{opens}` at {line}:{column} is not closed")),
        None => complaint.hint(format!("is a `{wanted}` missing before this place?")),
    }
}

fn powers_are_a_function() -> Words {
    Complaint::new("there is no operator `**`").hint("write pow(x, y): it gives the same digits on every computer")
}

/// What Rhai calls closures by.
const ANONYMOUS: &str = "anon$";

fn unknown_function(signature: &str, vocabulary: &Vocabulary) -> Words {
    let (name, arguments) = signature.split_once(" (").unwrap_or((signature, ""));
    let given = arguments.trim_end_matches(')');
    if name.contains(' ') {
        // Some words of Rhai tell what is wrong in the place of a name.
        return Complaint::new(name);
    }
    let forms = vocabulary.forms_of(name);
    if !name.starts_with(|c: char| c.is_alphabetic() || c == '_') {
        let sides = split_types(given).map(plain_type).collect::<Vec<_>>().join(" and ");
        let help = if name == "+" { "both must be numbers, texts or lists" } else { "both must be numbers" };
        return Complaint::new(format!("there is no `{name}` of {sides}")).hint(help);
    }
    if name.starts_with(ANONYMOUS) {
        return Complaint::new("a closure of another file cannot be called here")
            .hint("let that file call it, or hand on what it gives");
    }
    if forms.is_empty() {
        return Complaint::new(format!("there is no function `{name}`")).maybe_hint(function_like(name, vocabulary));
    }
    let first = split_types(given).next().unwrap_or_default();
    let methods = vocabulary.methods_of(first, name);
    if methods.is_empty() && vocabulary.names_of_methods(first).next().is_some() && !vocabulary.is_own(name) {
        return no_method(first, name, 0, vocabulary);
    }
    let forms = if methods.is_empty() { forms.join(" or ") } else { methods.join(" or ") };
    Complaint::new(format!("`{name}` does not take ({})", plain_types(given))).hint(format!("it is written {forms}"))
}

/// What is said where a kind has no function of a name, or none that takes so many arguments.
pub(crate) fn no_method(kind: &str, name: &str, count: usize, vocabulary: &Vocabulary) -> Complaint {
    let forms = vocabulary.methods_of(kind, name);
    if !forms.is_empty() {
        let message = format!("`{name}` does not take {}", plural(count, "argument"));
        return Complaint::new(message).hint(format!("it is written {}", forms.join(" or ")));
    }
    let names = vocabulary.names_of_methods(kind);
    let near = nearest(name, names.clone()).map(|near| format!("did you mean `{near}`?"));
    let of = vocabulary.with_method(name);
    let rules = RuleKind::ALL
        .into_iter()
        .filter(|rule| of.contains(&rule.arguments()[0]))
        .map(|rule| format!("fn {}", rule.form()));
    let rules: Vec<String> = rules.collect();
    let elsewhere =
        (!rules.is_empty()).then(|| format!("it is a word of {}, in {}", of.join(" and "), rules.join(" and ")));
    Complaint::new(format!("{kind} has no `{name}`")).maybe_hint(near.or(elsewhere).or_else(|| hint(name, names)))
}

/// What a function may be called that is not there.
pub(crate) fn function_like(name: &str, vocabulary: &Vocabulary) -> Option<String> {
    let near = || nearest(name, vocabulary.functions()).map(|name| format!("did you mean `{name}`?"));
    foreign::instead(name).map(str::to_owned).or_else(near)
}

/// Whether a name at a place stands before a `:`, as a key of a map does.
fn is_key(text: Option<&str>, at: Position, name: &str) -> bool {
    let rest = text::from_place(text.unwrap_or_default(), at.line().unwrap_or(0), at.position().unwrap_or(0));
    rest.strip_prefix(name)
        .is_some_and(|rest| rest.trim_start().starts_with(':') && !rest.trim_start().starts_with("::"))
}

fn unknown_variable(name: &str, diagnosis: &Diagnosis<'_>, file: &str, at: Position) -> Words {
    let text = diagnosis.texts.get(file);
    let near = text.as_deref().and_then(|text| nearest(name, declared(text)).map(str::to_owned));
    // Whoever writes `fn propose()` knows what it is asked about, and not that it is an argument.
    let lacks = |text: &str, kind: &RuleKind| {
        text.contains(&format!("fn {}(", kind.function())) && !text.contains(&format!("fn {}", kind.form()))
    };
    let is_asked =
        |kind: &RuleKind| kind.arguments().contains(&name) && text.as_deref().is_some_and(|text| lacks(text, kind));
    let asked = RuleKind::ALL.into_iter().find(is_asked);
    let help = match (asked, near) {
        (Some(kind), _) => format!("it is an argument: write `fn {}`", kind.form()),
        (None, Some(near)) => format!("did you mean `{near}`?"),
        (None, None) if let Some(help) = foreign::instead(name) => help.into(),
        (None, None) if is_key(text.as_deref(), at, name) => "a map begins with `#{`: #{ turn: 3 }".into(),
        (None, None) => "a function sees only its arguments and, as `global::NAME`, the constants of its file".into(),
    };
    Complaint::new(format!("there is no variable `{name}` here")).hint(help)
}

/// Names that a script declares: what follows `let`, `const` and `for`, and what stands in the brackets of `fn`.
fn declared(text: &str) -> Vec<&str> {
    let heads = text.lines().filter_map(|line| line.trim_start().strip_prefix("fn ").and_then(|l| l.split('(').nth(1)));
    let parameters = heads.flat_map(|list| text::identifiers(list.split(')').next().unwrap_or("")));
    let words: Vec<&str> = text::identifiers(text).collect();
    let named = words.windows(2).filter(|pair| ["let", "const", "for"].contains(&pair[0])).map(|pair| pair[1]);
    named.chain(parameters).collect()
}

/// Rhai says: Unknown property 'x' - a getter is not registered for type 'T'.
fn unknown_property(message: &str, vocabulary: &Vocabulary) -> Words {
    let mut quoted = message.split('\'').skip(1).step_by(2);
    let (Some(property), Some(kind)) = (quoted.next(), quoted.next()) else {
        return Complaint::new(lower_first(message));
    };
    let verb = if message.starts_with("No writable") { "cannot be given" } else { "has no" };
    let help = hint(property, vocabulary.properties_of(kind));
    Complaint::new(format!("{} {verb} `{property}`", plain_type(kind))).maybe_hint(help)
}

fn split_types(list: &str) -> impl Iterator<Item = &str> {
    list.split(", ")
}

fn plain_types(list: &str) -> String {
    split_types(list).map(plain_type).collect::<Vec<_>>().join(", ")
}

/// A Rhai type, or one of ours in lower case, in the words of a rule writer.
pub(crate) fn plain_type(name: &str) -> String {
    match name.trim() {
        "" => String::new(),
        "i64" => "a whole number".into(),
        "f64" => "a number".into(),
        "bool" => "true or false".into(),
        "()" => "nothing".into(),
        "array" => "a list".into(),
        "map" => "a map #{ … }".into(),
        "Fn" => "a function".into(),
        "rule" => "a rule".into(),
        "mapref" => "a map of the site".into(),
        "districtplan" => "districts".into(),
        "bydistrict" => "by_district(…)".into(),
        "mapvalue" => "a fitted map".into(),
        "value" => "a value that differs by place".into(),
        "sitehandle" => "a site".into(),
        "streetplan" => "streets(…)".into(),
        "streetimport" => "streets_from(…)".into(),
        "givenline" => "line(…)".into(),
        "densitygoal" => "density(…)".into(),
        "steer" => "a field of headings".into(),
        "patternplan" => "a mix of rules".into(),
        "weightplan" => "a weight".into(),
        "peak" => "a peak".into(),
        "link" => "one step of a chain".into(),
        "declaration" => "a parameter".into(),
        name if name.contains("tring") || name.contains("str") => "a text".into(),
        name => name.into(),
    }
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}
