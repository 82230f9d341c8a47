//! What can be set, as its author declared it: with unit, range and help, in the author's order.

use super::called;
use crate::inspect::target_name;
use crate::state::{Command, State};
use eframe::egui::{Button, Checkbox, ComboBox, DragValue, Response, RichText, Slider, TextEdit, Ui};
use script::{Domain, Literal, Plan, PresetTarget, RoleParam, Value};

/// Where a value comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The rule's author.
    Default,
    /// The city's script.
    Script,
    /// A preset that was laid.
    Preset,
    /// A change.
    Changed,
}

impl Source {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Script => "script",
            Self::Preset => "preset",
            Self::Changed => "changed",
        }
    }
}

/// Shows them.
pub fn ui(ui: &mut Ui, state: &mut State) {
    let Some(ready) = state.ready.clone() else {
        ui.weak("Parameters of a city are shown once it is open.");
        return;
    };
    let (changes, asked_for) = (state.history.now(), state.asked_for());
    let plan = asked_for.as_deref().unwrap_or(&ready.sources.plan);
    scope(ui, state, ready.built.city.districts.iter().filter_map(|area| area.name.clone()));
    let prefix = state.scope.as_ref().map_or(String::new(), |scope| format!("{scope}."));
    seed(ui, state, plan.seed);
    let has_changes = changes.values().next().is_some() || changes.seed.is_some();
    if ui.add_enabled(has_changes, Button::new("Reset all")).on_hover_text("Presets stay").clicked() {
        state.commands.push(Command::ResetAll);
    }
    let label = ui.label("Find a parameter");
    ui.add(TextEdit::singleline(&mut state.filters.parameters).desired_width(160.0)).labelled_by(label.id);
    // Sliders as wide as there is room beside their numbers.
    ui.spacing_mut().slider_width = (ui.available_width() - 80.0).clamp(60.0, 400.0);
    let maps: Vec<String> = ready.built.city.site.maps.keys().cloned().collect();
    let wanted = state.filters.parameters.to_lowercase();
    let as_written = ready.as_written.plan.parameters();
    let mut role = String::new();
    for param in in_force(plan, state.scope.as_ref()) {
        let about = param.param.about.to_lowercase();
        if !param.address.replace('_', " ").contains(&wanted) && !about.contains(&wanted) {
            continue;
        }
        let of_role = param.address.strip_suffix(&param.param.name).unwrap_or_default().trim_end_matches('.');
        if of_role != role {
            role = of_role.to_owned();
            ui.separator();
            ui.label(RichText::new(format!("{role}: {}", param.rule)).strong());
        }
        let address = format!("{prefix}{}", param.address);
        let source = source(&as_written, &param, changes.value(&address).is_some());
        row(ui, state, &param, &address, source, &maps);
    }
}

/// The parameters in force somewhere, with their values there.
pub fn in_force(plan: &Plan, scope: Option<&PresetTarget>) -> Vec<RoleParam> {
    let own = |param: &RoleParam| !param.address.starts_with("highways.") && !param.address.starts_with("majors.");
    match scope {
        Some(PresetTarget::Quarter(id)) => plan.in_quarter(Some(*id)).parameters().into_iter().filter(own).collect(),
        Some(PresetTarget::District(name)) => {
            let mut all = plan.parameters();
            for param in &mut all {
                if let Value::District(values) = &param.value {
                    param.value = values.named.get(name).unwrap_or(&values.other).clone();
                }
            }
            all
        }
        _ => plan.parameters(),
    }
}

/// Where the values are set.
fn scope(ui: &mut Ui, state: &mut State, districts: impl Iterator<Item = String>) {
    let mut scopes: Vec<Option<PresetTarget>> =
        std::iter::once(None).chain(districts.map(|name| Some(PresetTarget::District(name)))).collect();
    for quarter in [state.scope.clone(), Some(state.target.clone())] {
        if matches!(quarter, Some(PresetTarget::Quarter(_))) && !scopes.contains(&quarter) {
            scopes.push(quarter);
        }
    }
    let name = |scope: &Option<PresetTarget>| scope.as_ref().map_or("everywhere".into(), target_name);
    let label = ui.label("Set");
    let combo = ComboBox::from_id_salt("scope").selected_text(name(&state.scope)).width(180.0).show_ui(ui, |ui| {
        for scope in &scopes {
            ui.selectable_value(&mut state.scope, scope.clone(), name(scope));
        }
    });
    combo.response.labelled_by(label.id);
}

fn seed(ui: &mut Ui, state: &mut State, seed: u64) {
    ui.horizontal(|ui| {
        let label = ui.label("Seed");
        let mut value = seed;
        let drag = ui.add(DragValue::new(&mut value)).labelled_by(label.id);
        if drag.changed() {
            state.commands.push(Command::Seed(Some(value)));
        }
        if ui.button("Another").on_hover_text("The next seed: the same rules, another city").clicked() {
            state.commands.extend([Command::Seed(Some(seed.wrapping_add(1))), Command::LetGo]);
        }
    });
}

/// Where the present value of a parameter comes from.
pub fn source(as_written: &[RoleParam], param: &RoleParam, is_changed: bool) -> Source {
    let written = as_written.iter().find(|other| other.address == param.address);
    match written {
        _ if is_changed => Source::Changed,
        Some(written) if written.value == param.value && written.rule == param.rule => {
            if param.value.constant() == Some(&param.param.default) { Source::Default } else { Source::Script }
        }
        _ => Source::Preset,
    }
}

fn row(ui: &mut Ui, state: &mut State, param: &RoleParam, address: &str, source: Source, maps: &[String]) {
    let name = param.param.name.replace('_', " ");
    ui.horizontal(|ui| {
        let words = RichText::new(&name);
        ui.label(if source == Source::Changed { words.strong() } else { words }).on_hover_text(&param.param.about);
        ui.weak(source.name());
        if source == Source::Changed {
            let reset = ui.small_button("Reset").on_hover_text("Back to what it is without this change");
            if called(reset, &format!("Reset {address}")).clicked() {
                state.commands.push(Command::Reset(address.to_owned()));
            }
        }
    });
    let set = |value: String, turning| Command::Set { address: address.to_owned(), value, turning };
    if let Some(value) = param.value.constant() {
        if let Some((text, turning)) = ui.push_id(address, |ui| widget(ui, address, param, value, maps)).inner {
            state.commands.push(set(text, turning));
        }
    } else {
        ui.horizontal(|ui| {
            let hint = "It differs from place to place; a value of your own holds everywhere";
            ui.label(param.value.to_string()).on_hover_text(hint);
            if called(ui.button("Set one value"), &format!("Set one value of {address}")).clicked() {
                state.commands.push(set(param.param.default.to_string(), false));
            }
        });
    }
    let about = [param.param.about.clone(), range(&param.param.domain)];
    let about: Vec<String> = about.into_iter().filter(|words| !words.is_empty()).collect();
    if !about.is_empty() {
        ui.weak(about.join("; "));
    }
}

/// Between which values a number may lie, as people say it; what is typed beyond is brought back.
fn range(domain: &Domain) -> String {
    let (low, high, unit) = match domain {
        Domain::Number { unit, range: (low, high) } => {
            (low.is_finite().then(|| low.to_string()), high.is_finite().then(|| high.to_string()), unit.suffix())
        }
        Domain::Whole { range: (low, high) } => {
            ((*low > i64::MIN).then(|| low.to_string()), (*high < i64::MAX).then(|| high.to_string()), "")
        }
        _ => return String::new(),
    };
    match (low, high) {
        (Some(low), Some(high)) => format!("from {low} to {high}{unit}"),
        (Some(low), None) => format!("at least {low}{unit}"),
        (None, Some(high)) => format!("at most {high}{unit}"),
        (None, None) => String::new(),
    }
}

/// Widest range that a slider can be set in by hand.
const WIDEST: f64 = 20_000.0;

/// Whether a number is set by a slider: its range is no wider than a hand can tell apart.
pub fn has_slider(domain: &Domain) -> bool {
    match domain {
        Domain::Number { range: (low, high), .. } => high - low <= WIDEST,
        Domain::Whole { range: (low, high) } => (*high as f64) - (*low as f64) <= WIDEST,
        _ => false,
    }
}

/// A number as people type it: with a decimal comma or point, with its unit or without, metres in kilometres, too. `None` for
/// what is none: it changes nothing.
fn typed(text: &str, suffix: &str) -> Option<f64> {
    let bare: String = text.chars().filter(|c| !c.is_whitespace()).map(|c| if c == '−' { '-' } else { c }).collect();
    let unit: String = suffix.chars().filter(|c| !c.is_whitespace()).collect();
    let (digits, times) = match bare.strip_suffix("km") {
        Some(digits) if unit == "m" => (digits, 1000.0),
        _ => (bare.strip_suffix(&unit).unwrap_or(&bare), 1.0),
    };
    let value: f64 = digits.replace(',', ".").parse().ok()?;
    value.is_finite().then_some(value * times)
}

/// The widget of a parameter. The new value as behind `--set`, where there is one, and whether it is still being turned.
pub fn widget(ui: &mut Ui, name: &str, param: &RoleParam, value: &Literal, maps: &[String]) -> Option<(String, bool)> {
    let turned = |response: Response, text: String| {
        let response = called(response, name);
        // The last movement comes as it is let go.
        response.changed().then(|| (text, response.dragged() || response.drag_stopped()))
    };
    match (&param.param.domain, value) {
        (Domain::Number { unit, range: (low, high) }, Literal::Number(number)) => {
            let mut value = *number;
            let suffix = unit.suffix();
            let response = if has_slider(&param.param.domain) {
                let slider = Slider::new(&mut value, *low..=*high).suffix(suffix).max_decimals(3);
                ui.add(slider.update_while_editing(false).custom_parser(|text| typed(text, suffix)))
            } else {
                let drag = DragValue::new(&mut value).range(*low..=*high).suffix(suffix).max_decimals(3);
                ui.add(drag.update_while_editing(false).custom_parser(|text| typed(text, suffix)))
            };
            let rounded = ((value * 1000.0).round() / 1000.0).clamp(*low, *high);
            turned(response, rounded.to_string())
        }
        (Domain::Whole { range: (low, high) }, Literal::Whole(number)) => {
            let mut value = *number;
            let response = if has_slider(&param.param.domain) {
                ui.add(Slider::new(&mut value, *low..=*high).update_while_editing(false))
            } else {
                ui.add(DragValue::new(&mut value).range(*low..=*high).update_while_editing(false))
            };
            turned(response, value.to_string())
        }
        (Domain::Choice(words), Literal::Choice(word)) => choice(ui, name, word, words),
        (Domain::Map, Literal::Map(map)) => choice(ui, name, &map.name, maps),
        (Domain::Flag, Literal::Flag(flag)) => {
            let mut value = *flag;
            let response = ui.add(Checkbox::new(&mut value, param.param.name.replace('_', " ")));
            turned(response, value.to_string())
        }
        (Domain::Colour, Literal::Colour(colour)) => {
            let mut value = *colour;
            let response = ui.color_edit_button_srgb(&mut value);
            turned(response, Literal::Colour(value).to_string())
        }
        // Values are of their parameters' kinds.
        _ => None,
    }
}

fn choice(ui: &mut Ui, name: &str, present: &str, words: &[String]) -> Option<(String, bool)> {
    let mut chosen = present.to_owned();
    let combo = ComboBox::from_id_salt(name).selected_text(present).show_ui(ui, |ui| {
        for word in words {
            ui.selectable_value(&mut chosen, word.clone(), word);
        }
    });
    called(combo.response, name);
    (chosen != present).then_some((chosen, false))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_people_type_them_and_nothing_else_is_one() {
        for (text, suffix, value) in [
            ("280", " m", 280.0),
            (" 1 280.5 m", " m", 1280.5),
            ("1,5km", " m", 1500.0),
            ("−3°", "°", -3.0),
            ("2,25", "", 2.25),
            ("1e3", " m", 1000.0),
        ] {
            assert_eq!(typed(text, suffix), Some(value), "{text}");
        }
        for text in ["", "m", "1,5 miles", "1.000,5", "wide", "inf", "NaN", "1 km2"] {
            assert_eq!(typed(text, " m"), None, "{text}");
        }
        assert_eq!(typed("2 km", "°"), None);
    }
}
