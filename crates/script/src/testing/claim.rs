//! What tests claim: `assert(…)`, `assert_eq(…)`, `assert_near(…)`, `snapshot(…)`.

use super::answer;
use super::desk::Desk;
use super::town::TownHandle;
use crate::fault::{Complaint, Refusal};
use crate::host::{kind_of, numeric};
use crate::preset::Preset;
use crate::rule::Rule;
use rhai::{Array, Dynamic, Engine, FnPtr, FuncRegistration, NativeCallContext};

type Held = Result<(), Refusal>;

pub(super) fn register(engine: &mut Engine, desk: &Desk) {
    let own = desk.clone();
    FuncRegistration::new("assert")
        .with_params_info(["condition"])
        .with_comments(["/// The test fails unless this is true; it says what was measured for it."])
        .register_into_engine(engine, move |condition: Dynamic| -> Held { Ok(hold(&own, &condition, None)?) });
    let own = desk.clone();
    FuncRegistration::new("assert")
        .with_params_info(["condition", "what should be"])
        .register_into_engine(engine, move |condition: Dynamic, words: &str| -> Held {
            Ok(hold(&own, &condition, Some(words))?)
        });
    let own = desk.clone();
    FuncRegistration::new("assert_eq")
        .with_params_info(["found", "wanted"])
        .with_comments(["/// The test fails unless both are the same: numbers, texts, lists, maps."])
        .register_into_engine(engine, move |found: Dynamic, wanted: Dynamic| -> Held {
            let (found, wanted) = (answer::line(&found), answer::line(&wanted));
            let message = || format!("found {found}, wanted {wanted}");
            Ok(held(&own, found == wanted, message)?)
        });
    let own = desk.clone();
    FuncRegistration::new("assert_near")
        .with_params_info(["found", "wanted", "within"])
        .with_comments(["/// The test fails unless a number is as near as that to another."])
        .register_into_engine(engine, move |found: Dynamic, wanted: Dynamic, within: Dynamic| -> Held {
            let (found, wanted) = (numeric("what is found", &found)?, numeric("what is wanted", &wanted)?);
            let within = numeric("how near they must be", &within)?;
            let message = || format!("found {}, wanted {wanted} ± {within}", answer::number(found));
            Ok(held(&own, (found - wanted).abs() <= within, message)?)
        });
    let own = desk.clone();
    FuncRegistration::new("assert_all")
        .with_params_info(["list", "|element| condition"])
        .with_comments(["/// The test fails unless a condition holds of each element of a list; it tells the first of which it does not."])
        .register_into_engine(engine, move |context: NativeCallContext, list: Array, claim: FnPtr| -> Held {
            for element in list {
                let told = claim.call_within_context::<Dynamic>(&context, (element.clone(),))?;
                let wrong = || Complaint::new(format!("the condition is true or false, not {}", kind_of(&told)));
                let is_so = told.as_bool().map_err(|_| wrong())?;
                held(&own, is_so, || format!("this does not hold of {}", answer::line(&element)))?;
            }
            Ok(())
        });
    snapshots(engine, desk);
}

fn snapshots(engine: &mut Engine, desk: &Desk) {
    let own = desk.clone();
    FuncRegistration::new("snapshot")
        .with_params_info(["value"])
        .with_comments([
            "/// Compares a town, a rule's parameters, what a preset says, or any answer with what was accepted before, to the last digit.",
        ])
        .register_into_engine(engine, move |value: Dynamic| -> Held { Ok(snapshot(&own, &value, None)?) });
    let own = desk.clone();
    FuncRegistration::new("snapshot")
        .with_params_info(["value", "name"])
        .register_into_engine(engine, move |value: Dynamic, name: &str| -> Held {
            Ok(snapshot(&own, &value, Some(name))?)
        });
}

fn hold(desk: &Desk, condition: &Dynamic, words: Option<&str>) -> Result<(), Complaint> {
    let kind = || Complaint::new(format!("assert takes something true or false, not {}", kind_of(condition)));
    let is_so = condition.as_bool().map_err(|_| kind().hint("assert(town.order > 0.8)"))?;
    held(desk, is_so, || words.map_or("this does not hold".to_owned(), |words| format!("this does not hold: {words}")))
}

/// Goes on where a claim holds; else says what was read for it.
fn held(desk: &Desk, is_so: bool, message: impl Fn() -> String) -> Result<(), Complaint> {
    if is_so {
        desk.settle();
        return Ok(());
    }
    let (message, readings) = (message(), desk.readings());
    Err(Complaint::new(if readings.is_empty() { message } else { format!("{message}; {readings}") }))
}

fn snapshot(desk: &Desk, value: &Dynamic, name: Option<&str>) -> Result<(), Complaint> {
    if let Some(bad) =
        name.filter(|name| !name.chars().all(|c| c.is_alphanumeric() || "_- ".contains(c)) || name.is_empty())
    {
        let help = "letters, digits, spaces, - and _: it becomes part of a file's name";
        return Err(Complaint::new(format!("`{bad}` cannot be the name of a snapshot")).hint(help));
    }
    if let Some(town) = value.read_lock::<TownHandle>() {
        return desk.snapshot(name, town.digest(), Some(town.town()));
    }
    if let Some(rule) = value.read_lock::<Rule>() {
        return desk.snapshot(name, answer::parameters(&rule), None);
    }
    if let Some(preset) = value.read_lock::<Preset>() {
        return desk.snapshot(name, preset.listed(), None);
    }
    desk.snapshot(name, answer::text(value), None)
}
