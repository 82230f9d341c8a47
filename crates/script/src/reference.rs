//! The reference of the rule language, read back from the words as they are registered: so it knows all of them, and
//! nothing else.

use crate::Host;
use crate::city::register_words;
use crate::host::split;
use crate::param::{Declaration, Declared, register as register_params};
use crate::rule::Rule;
use crate::testing::{Bench, word_engine};
use crate::words;
use rhai::{Dynamic, Engine, FuncRegistration};
use std::any::TypeId;
use std::collections::{BTreeMap, BTreeSet};

mod examples;

/// A part of the reference: the words of one thing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chapter {
    /// What its words are asked of, or where they may be used.
    pub title: String,
    /// One line about it.
    pub about: &'static str,
    /// Its words, in alphabetical order.
    pub words: Vec<Word>,
}

/// A word of the language.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// What it is called.
    pub name: String,
    /// How it is written, one form a line: `ahead(length)`, `x`.
    pub forms: Vec<String>,
    /// What it does or says, with units.
    pub about: String,
    /// A line that uses it.
    pub example: String,
}

/// Where a word may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Room {
    Rules,
    Cities,
    Tests,
}

/// A word as an engine knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Registered {
    room: Room,
    /// What it is asked of; empty for a function by itself.
    of: String,
    name: String,
    form: String,
    about: String,
}

/// Everything that scripts may say, chapter by chapter.
pub fn reference() -> Vec<Chapter> {
    let mut seen = BTreeSet::new();
    let mut all = Vec::new();
    for (room, engine) in [(Room::Rules, rules()), (Room::Cities, cities()), (Room::Tests, word_engine())] {
        let mut fresh = registered(&engine, room);
        // An engine hands out its words in any order; of equal ones the one that says something is taken.
        fresh.sort_by(|a, b| (&a.of, &a.form, &b.about).cmp(&(&b.of, &b.form, &a.about)));
        let fresh = fresh.into_iter();
        all.extend(fresh.filter(|word| seen.insert((word.of.clone(), word.form.clone()))));
    }
    let plan: [(&str, Room, &str, &str); 14] = [
        ("", Room::Rules, "In every script", "Functions that stand by themselves."),
        ("a parameter", Room::Rules, "A parameter", "What `params(#{ … })` declares; units stand in the constructor."),
        ("tip", Room::Rules, "`tip`", "The end of a street, in `fn propose(tip, p)`."),
        ("a peak", Room::Rules, "A peak", "A centre of population, as `tip.peak()` tells it."),
        ("segment", Room::Rules, "`segment`", "A proposed piece of street, in `fn constrain(segment, p)`."),
        ("block", Room::Rules, "`block`", "A block to be divided, in `fn subdivide(block, p)`."),
        ("parcel", Room::Rules, "`parcel`", "A parcel, in `fn assign(parcel, p)`."),
        ("shape", Room::Rules, "`shape`", "A parcel to build on, in `fn build(shape, p)`."),
        ("", Room::Cities, "In city scripts and tests", "Functions that stand by themselves."),
        ("site", Room::Cities, "A site", "What `site(…)` gives."),
        ("a map of the site", Room::Rules, "A map", "What `site.map(\"…\")` gives."),
        ("", Room::Tests, "In tests", "Functions that stand by themselves."),
        ("a rule", Room::Tests, "A rule, in tests", "What `rule()` gives: asked once by the name of its function."),
        (
            "a town",
            Room::Tests,
            "A town",
            "What `grow(…)` and, in tests, `city(…)` give. A measure is a property: `town.order`.",
        ),
    ];
    let mut chapters: Vec<Chapter> = plan
        .into_iter()
        .map(|(of, room, title, about)| {
            let own = all.iter().filter(|word| word.of == of && (!of.is_empty() || word.room == room));
            Chapter { title: title.to_owned(), about, words: words_of(own) }
        })
        .collect();
    let trial = all.iter().filter(|word| word.of == "a trial");
    chapters.push(Chapter { title: "A trial".into(), about: "What a random test is given.", words: words_of(trial) });
    chapters
}

/// Words by name, with all their forms.
fn words_of<'a>(registered: impl Iterator<Item = &'a Registered>) -> Vec<Word> {
    let mut by_name: BTreeMap<(&str, bool), Vec<&Registered>> = BTreeMap::new();
    for word in registered {
        by_name.entry((&word.name, word.form.contains('('))).or_default().push(word);
    }
    let word = |((name, _), mut forms): ((&str, bool), Vec<&Registered>)| {
        forms.sort_by_key(|word| (word.form.len(), &word.form));
        let abouts: BTreeSet<&str> =
            forms.iter().map(|word| word.about.as_str()).filter(|about| !about.is_empty()).collect();
        let first = forms.iter().map(|word| word.about.as_str()).find(|about| !about.is_empty()).unwrap_or_default();
        let plain = examples::PLAIN.iter().find(|(word, _)| *word == name).map_or("", |(_, about)| about);
        let first = if first.is_empty() { plain } else { first };
        let about = std::iter::once(first).chain(abouts.into_iter().filter(|about| *about != first));
        Word {
            name: name.to_owned(),
            forms: forms.iter().map(|word| word.form.clone()).collect(),
            about: about.collect::<Vec<_>>().join(" "),
            example: examples::of(&forms[0].of, name, forms[0].form.contains('(')),
        }
    };
    by_name.into_iter().map(word).collect()
}

fn rules() -> Engine {
    let mut engine = Engine::new_raw();
    register_params(&mut engine, "", Declared::default());
    words::register(&mut engine);
    crate::host::register_maths(&mut engine);
    words::marks::register(&mut engine, &words::marks::Marks::default());
    // Rhai's own word, which the owner of an engine listens to.
    FuncRegistration::new("print")
        .with_params_info(["value"])
        .with_comments(["/// Writes a value into the report, with where and how often, and on the terminal."])
        .register_into_engine(&mut engine, |_: Dynamic| {});
    engine
}

fn cities() -> Engine {
    let mut engine = rules();
    register_words(&mut engine, Host::new(Vec::new()).around, Bench::bare().sites);
    engine
}

/// Words for tests of the program alone, and one of Rhai's own that is watched here.
const HIDDEN: [&str; 2] = ["fail_inside", "replace"];

fn registered(engine: &Engine, room: Room) -> Vec<Registered> {
    let read = |info: rhai::FuncInfo<'_>| {
        let comments = info.metadata.comments.iter();
        let about: Vec<String> = comments.map(|line| line.trim_start_matches('/').trim().to_owned()).collect();
        let signature = info.metadata.gen_signature(|name| name.to_owned().into());
        Some((signature, info.metadata.param_types.first().copied(), about.join(" ")))
    };
    let all = engine.collect_fn_metadata(None, read, false);
    let types = names_of_types(&all);
    let mut found = Vec::new();
    for (signature, first, about) in &all {
        let Some((name, rest)) = signature.split_once('(') else { continue };
        let arguments = rest.rsplit_once(')').map_or(rest, |(arguments, _)| arguments);
        let is_property = name.starts_with("get$");
        let is_method = arguments == "this" || arguments.starts_with("this,");
        let of = if is_property || is_method {
            first.and_then(|first| types.get(&first).cloned())
        } else {
            Some(String::new())
        };
        let name = name.trim_start_matches("get$");
        let is_word = name.chars().all(|c| c.is_alphanumeric() || c == '_') && !HIDDEN.contains(&name);
        let (Some(of), true) = (of, is_word) else { continue };
        let plain = arguments.trim_start_matches("this").trim_start_matches(',').trim();
        let form = if is_property { name.to_owned() } else { format!("{name}({})", without_types(plain)) };
        found.push(Registered { room, of, name: name.to_owned(), form, about: about.clone() });
    }
    found
}

/// Argument names without the types that Rhai puts behind them.
fn without_types(arguments: &str) -> String {
    let names = split(arguments, ',').into_iter().filter_map(|argument| Some(split(argument, ':').first()?.trim()));
    names.collect::<Vec<_>>().join(", ")
}

/// What types are called, told from their properties, and those without any.
fn names_of_types(all: &[(String, Option<TypeId>, String)]) -> BTreeMap<TypeId, String> {
    let mut names = BTreeMap::from([
        (TypeId::of::<Rule>(), "a rule".to_owned()),
        (TypeId::of::<Declaration>(), "a parameter".to_owned()),
        (TypeId::of::<crate::MapValue>(), "a map of the site".to_owned()),
        (crate::testing::town_type(), "a town".to_owned()),
    ]);
    for (signature, first, _) in all {
        let told = signature.strip_prefix("get$").and_then(|rest| rest.split_once("&mut ")?.1.split_once(')'));
        if let (Some((name, _)), Some(first)) = (told, first) {
            let name = match name {
                "apeak" => "a peak",
                "amapofthesite" => "a map of the site",
                "atrial" => "a trial",
                other => other,
            };
            names.entry(*first).or_insert_with(|| name.to_owned());
        }
    }
    names
}

/// The reference as Markdown.
pub fn markdown() -> String {
    let mut text = "# The words of the rule language\n\nMade by `plat words`, from the words themselves. A tour is in \
                    [README.md](README.md).\n"
        .to_owned();
    for chapter in reference() {
        text += &format!(
            "\n## {}\n\n{}\n\n| word | what it does | for example |\n|---|---|---|\n",
            chapter.title, chapter.about
        );
        for word in &chapter.words {
            // A bar would end the cell.
            let cell = |text: &str| text.replace('|', "\\|");
            let forms: Vec<String> = word.forms.iter().map(|form| format!("`{}`", cell(form))).collect();
            text += &format!("| {} | {} | `{}` |\n", forms.join("<br>"), cell(&word.about), cell(&word.example));
        }
    }
    text
}

/// The words as definitions for editors: the text of `plat.d.rhai`. Rhai's own words are not among them.
pub fn definitions() -> String {
    let mut text = "// Made by `plat words --definitions`, for editors that know Rhai.\nmodule static;\n".to_owned();
    for chapter in reference() {
        let object = chapter.title.split('`').nth(1).filter(|_| chapter.title.starts_with('`'));
        text += &format!("\n// {}: {}\n", chapter.title, chapter.about);
        for word in &chapter.words {
            for form in &word.forms {
                text += &definition(object, &word.name, form, &word.about);
            }
        }
    }
    text
}

/// A word as a definition: arguments that are maps or lists are named by what they are.
fn definition(object: Option<&str>, name: &str, form: &str, about: &str) -> String {
    let Some((_, arguments)) = form.split_once('(') else {
        return format!("\n/// {about}\nfn get {name}({}: ?) -> ?;\n", object.unwrap_or("this"));
    };
    let plain = |argument: &str| match argument.chars().next() {
        Some('#') => "options".to_owned(),
        Some('[') => "list".to_owned(),
        Some('|') => "closure".to_owned(),
        _ => argument.chars().filter(|c| c.is_alphanumeric() || *c == '_').collect(),
    };
    let arguments = split(arguments.trim_end_matches(')'), ',').into_iter().map(str::trim);
    let names: Vec<String> =
        arguments.filter(|argument| !argument.is_empty()).map(|argument| format!("{}: ?", plain(argument))).collect();
    format!("\n/// {about}\n///\n/// `{form}`\nfn {name}({}) -> ?;\n", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_says_what_it_does_and_how() {
        let chapters = reference();
        assert!(chapters.iter().all(|chapter| !chapter.words.is_empty()), "{chapters:?}");
        let silent: Vec<String> = chapters
            .iter()
            .flat_map(|chapter| chapter.words.iter().map(move |word| (chapter, word)))
            .filter(|(_, word)| word.about.is_empty() || word.example.is_empty())
            .map(|(chapter, word)| format!("{}: {}", chapter.title, word.forms.join(" ")))
            .collect();
        assert!(silent.is_empty(), "{silent:#?}");
    }
}
