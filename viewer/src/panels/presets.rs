//! Presets to pick from, with the pictures that they make of a standard site.

use super::called;
use crate::inspect::target_name;
use crate::state::{Command, State};
use eframe::egui::{Button, ComboBox, Image, RichText, TextEdit, Ui};
use script::PresetTarget;

/// Side of a picture in points.
const PICTURE: f32 = 96.0;

/// Shows them.
pub fn ui(ui: &mut Ui, state: &mut State) {
    let Some(ready) = state.ready.clone() else {
        ui.weak("Presets of a city are shown once it is open.");
        return;
    };
    target(ui, state, ready.built.city.districts.iter().filter_map(|area| area.name.clone()));
    let changes = state.history.now();
    for (target, name) in changes.presets() {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(format!("{} on {}", words(name), target_name(target))).strong());
            let text = format!("Take {} from {}", words(name), target_name(target));
            if called(ui.small_button("Take off"), &text).clicked() {
                state.commands.push(Command::Lift(target.clone()));
            }
        });
    }
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Save what is here as");
        ui.add(TextEdit::singleline(&mut state.filters.preset_name).desired_width(90.0)).labelled_by(label.id);
        let name = state.filters.preset_name.trim().to_owned();
        let button = ui.add_enabled(!name.is_empty(), Button::new("Save as preset"));
        let help = "Rules and values in force where presets are laid: of minors with parcels and buildings, or of the class that \
                    is chosen; into the city's folder";
        if button.on_hover_text(help).clicked() {
            state.commands.push(Command::SavePreset(name));
        }
    });
    ui.separator();
    let label = ui.label("Find a preset");
    ui.add(TextEdit::singleline(&mut state.filters.presets).desired_width(160.0)).labelled_by(label.id);
    kinds(ui, state);
    state.gallery.draw(ui.ctx());
    let wanted = state.filters.presets.to_lowercase();
    for (name, card) in &state.gallery.cards {
        if !words(name).to_lowercase().contains(&wanted) && !card.preset.about().to_lowercase().contains(&wanted) {
            continue;
        }
        if state.filters.kind.is_some_and(|kind| card.preset.rules().iter().all(|(key, _)| !key.starts_with(kind))) {
            continue;
        }
        ui.separator();
        ui.horizontal(|ui| {
            match &card.texture {
                Some(texture) => {
                    let text = format!("Picture of {}", words(name));
                    ui.add(Image::new(texture).max_size([PICTURE; 2].into()).alt_text(text));
                }
                None => drop(ui.allocate_space([PICTURE; 2].into())),
            }
            ui.vertical(|ui| {
                ui.label(RichText::new(words(name)).strong());
                ui.label(card.preset.about());
                let class = card.preset.class();
                let button = ui.add_enabled(suits(&state.target, class), Button::new("Lay"));
                let why = format!("It is made for {class}, which are the whole city's");
                if called(button.on_disabled_hover_text(why), &format!("Lay {}", words(name))).clicked() {
                    state.commands.push(Command::Lay(state.target.clone(), short(name).to_owned()));
                }
            });
        });
    }
}

/// The kinds of rules that a preset may have: what people call them, and their keys in it.
const KINDS: [(&str, Option<&str>); 4] =
    [("All", None), ("Streets", Some("pattern")), ("Parcels", Some("parcels")), ("Buildings", Some("buildings"))];

/// Which presets are shown, by the rules they have.
fn kinds(ui: &mut Ui, state: &mut State) {
    ui.horizontal_wrapped(|ui| {
        for (name, kind) in KINDS {
            let chosen = ui.selectable_label(state.filters.kind == kind, name);
            if called(chosen, &format!("Presets: {name}")).clicked() {
                state.filters.kind = kind;
            }
        }
    });
}

/// What presets are laid on.
fn target(ui: &mut Ui, state: &mut State, districts: impl Iterator<Item = String>) {
    let classes = ["highways", "majors", "minors"].map(PresetTarget::Class);
    let mut targets: Vec<PresetTarget> =
        std::iter::once(PresetTarget::City).chain(classes).chain(districts.map(PresetTarget::District)).collect();
    if matches!(state.target, PresetTarget::Quarter(_)) {
        targets.push(state.target.clone());
    }
    let label = ui.label("Lay on");
    let combo = ComboBox::from_id_salt("target").selected_text(target_name(&state.target)).width(180.0);
    let combo = combo.show_ui(ui, |ui| {
        for target in &targets {
            ui.selectable_value(&mut state.target, target.clone(), target_name(target));
        }
    });
    combo.response.labelled_by(label.id);
    ui.weak("For a quarter alone, click on it until the Inspector says quarter.");
}

/// Whether a preset made for a class of streets can be laid on something.
fn suits(target: &PresetTarget, class: &str) -> bool {
    match target {
        PresetTarget::City | PresetTarget::Class(_) => true,
        PresetTarget::District(_) | PresetTarget::Quarter(_) => class == "minors",
    }
}

fn short(name: &str) -> &str {
    name.strip_prefix("presets/").unwrap_or(name)
}

/// `presets/garden_city` as people say it.
fn words(name: &str) -> String {
    let name = short(name).replace('_', " ");
    let mut letters = name.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
