//! Every declared parameter of every shipped rule, as a widget.

use eframe::egui::{self, Key, Role};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use script::{Domain, Host, Literal, Param, RoleParam};
use std::cell::RefCell;
use std::rc::Rc;
use viewer::panels::parameters::{has_slider, widget};

/// Maps that a site may have.
const MAPS: [&str; 2] = ["density", "elevation"];

/// A parameter as it stands in a city.
fn in_role(rule: &str, param: &Param) -> RoleParam {
    let address = format!("role.{}", param.name);
    RoleParam { address, rule: rule.to_owned(), param: param.clone(), value: param.default.clone().into() }
}

/// What people turned the widget to, by what they do with it.
fn turned(param: &RoleParam, act: impl FnOnce(&mut Harness<'_>)) -> Option<String> {
    let told: Rc<RefCell<Option<String>>> = Rc::default();
    let (heard, shown) = (told.clone(), param.clone());
    let maps = MAPS.map(str::to_owned);
    let mut harness = Harness::builder().with_size([500.0, 400.0]).build_ui(move |ui: &mut egui::Ui| {
        if let Some((text, _)) = widget(ui, &shown.address, &shown, &shown.param.default, &maps) {
            *heard.borrow_mut() = Some(text);
        }
    });
    act(&mut harness);
    harness.run_steps(3);
    drop(harness);
    told.take()
}

fn press(harness: &mut Harness, role: Role, name: &str, key: Key) {
    harness.get_by_role_and_label(role, name).focus();
    harness.run_steps(2);
    harness.key_press(key);
    harness.run_steps(2);
}

/// Turns a parameter's widget by hand.
fn turn(param: &RoleParam) -> Option<String> {
    let name = param.address.as_str();
    match (&param.param.domain, &param.param.default) {
        (Domain::Number { range, .. }, Literal::Number(number)) => {
            let role = if has_slider(&param.param.domain) { Role::Slider } else { Role::SpinButton };
            let key = if *number < range.1 { Key::ArrowRight } else { Key::ArrowLeft };
            turned(param, |harness| match role {
                Role::Slider => press(harness, role, name, key),
                _ => type_number(harness, name, "7"),
            })
        }
        (Domain::Whole { range }, Literal::Whole(number)) => {
            let is_slider = has_slider(&param.param.domain);
            let key = if *number < range.1 { Key::ArrowRight } else { Key::ArrowLeft };
            turned(param, |harness| {
                if is_slider { press(harness, Role::Slider, name, key) } else { type_number(harness, name, "7") }
            })
        }
        (Domain::Choice(words), Literal::Choice(word)) => choose(param, words.iter().find(|other| *other != word)?),
        (Domain::Map, Literal::Map(map)) => choose(param, MAPS.iter().find(|other| **other != map.name)?),
        (Domain::Flag, Literal::Flag(_)) => {
            turned(param, |harness| harness.get_by_role_and_label(Role::CheckBox, name).click())
        }
        (Domain::Colour, Literal::Colour(_)) => {
            turned(param, |harness| assert!(harness.query_by_label(name).is_some(), "{name} has no name"));
            Some(param.param.default.to_string())
        }
        (domain, value) => panic!("{domain:?} with {value:?}"),
    }
}

fn type_number(harness: &mut Harness, name: &str, digits: &str) {
    harness.get_by_role_and_label(Role::SpinButton, name).focus();
    harness.run_steps(2);
    harness.get_by_role(Role::SpinButton).type_text(digits);
    harness.run_steps(2);
    harness.key_press(Key::Enter);
}

fn choose(param: &RoleParam, word: &str) -> Option<String> {
    turned(param, |harness| {
        harness.get_by_role_and_label(Role::ComboBox, &param.address).click();
        harness.run_steps(3);
        harness.get_by_label(word).click();
    })
}

#[test]
fn every_parameter_of_every_shipped_rule_can_be_turned() {
    let host = Host::new(Vec::new());
    let mut count = 0;
    for name in host.names() {
        let Ok(rule) = host.rule(&name) else { continue };
        for (param, _) in rule.params().iter() {
            let told = turn(&in_role(&name, param));
            let text = told.unwrap_or_else(|| panic!("{name}: {} does nothing", param.name));
            let read = rule.params().with_text(&param.name, &text);
            assert!(read.is_ok(), "{name}: {} = {text}: {read:?}", param.name);
            let is_colour = matches!(param.domain, Domain::Colour);
            assert!(is_colour || text != param.default.to_string(), "{name}: {} stays {text}", param.name);
            count += 1;
        }
    }
    assert!(count > 60, "only {count} parameters");
}
