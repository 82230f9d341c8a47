//! Engines, libraries, and everything else that runs scripts.

mod call;
mod check;
mod engine;
mod library;
mod maths;
mod places;
mod resolver;
mod settle;
mod spending;
mod texts;
mod vocabulary;

pub(crate) use call::{Caller, Handle, Located};
pub(crate) use check::{
    AskedMap, NamedRule, asked_maps, assigned_properties, declared_in, first_call, imported_files, miscounted_calls,
    misplaced_params, named_presets, named_rules, properties, rebinds, undeclared, unknown_imported, unknown_keys,
    unknown_methods, unknown_options, unknown_properties, unknown_words,
};
pub(crate) use engine::{Closures, Limits, compile, compile_within, engine, refuse_captures};
pub use library::{Embedded, LIBRARY, Library, Source, Texts};
pub(crate) use library::{Shelves, is_inside};
pub(crate) use maths::{number, numeric, register as register_maths};
pub(crate) use places::{Places, code_until, until};
pub(crate) use resolver::{Modules, Reading, Resolver};
pub(crate) use settle::Settling;
pub(crate) use spending::{Spending, spend};
pub(crate) use vocabulary::{Vocabulary, split};

use crate::fault::plain_type;
use rhai::Dynamic;

/// What a value is, in words.
pub(crate) fn kind_of(value: &Dynamic) -> String {
    plain_type(value.type_name().rsplit("::").next().unwrap_or_default().to_lowercase().as_str())
}
