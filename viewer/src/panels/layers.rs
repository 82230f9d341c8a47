//! What is shown, and how.

use super::{busy, called};
use crate::scene::LayerKind;
use crate::shown::MODEL_PARTS;
use crate::state::{Command, State};
use crate::viewport::View;
use eframe::egui::{Button, Color32, ComboBox, Sense, Slider, TextEdit, Ui, Vec2};

/// Shows them.
pub fn ui(ui: &mut Ui, state: &mut State) {
    // As wide as there is room beside their numbers.
    ui.spacing_mut().slider_width = (ui.available_width() - 80.0).clamp(60.0, 300.0);
    ui.strong("Map");
    let layers = &mut state.preferences.layers;
    ui.checkbox(&mut layers.ground, "Land");
    ui.add_enabled_ui(layers.ground, |ui| {
        ui.checkbox(&mut layers.water, "Water");
        ui.checkbox(&mut layers.parks, "Parks of the site");
    });
    for layer in LayerKind::ALL {
        let mut is_on = state.preferences.layers.map.contains(&layer);
        if ui.checkbox(&mut is_on, layer.name()).changed() {
            let layers = &mut state.preferences.layers.map;
            if is_on {
                layers.insert(layer)
            } else {
                layers.remove(&layer)
            };
        }
        if layer == LayerKind::Streets && is_on {
            classes(ui, state);
        }
    }
    ui.checkbox(&mut state.preferences.layers.marks, "Marks and faults of rules");
    colours(ui, state);
    growth(ui, state);
    ui.separator();
    ui.strong("Model");
    for (i, (_, name)) in MODEL_PARTS.iter().enumerate() {
        ui.checkbox(&mut state.preferences.layers.model[i], *name);
    }
    let look = &mut state.views.look;
    ui.checkbox(&mut look.shadows, "Shadows");
    slider(ui, "Silhouettes", Slider::new(&mut look.silhouettes, 0.0..=1.0));
    slider(ui, "Sun from", Slider::new(&mut look.sun.0, 0.0..=360.0).suffix("°"));
    slider(ui, "Sun height", Slider::new(&mut look.sun.1, 5.0..=85.0).suffix("°"));
    let detail = Slider::new(&mut look.detail, 200.0..=50_000.0).logarithmic(true).suffix(" m").max_decimals(0);
    slider(ui, "Full detail up to", detail);
    ui.separator();
    overlay(ui, state);
    ui.separator();
    bookmarks(ui, state);
    ui.separator();
    costs(ui, state);
}

/// The classes of streets, each on or off.
fn classes(ui: &mut Ui, state: &mut State) {
    let Some(ready) = &state.ready else { return };
    let off = &mut state.preferences.layers.classes_off;
    ui.indent("classes", |ui| {
        for (_, class) in ready.built.city.graph.classes().iter() {
            let mut is_on = !off.contains(&class.name);
            if ui.checkbox(&mut is_on, format!("{} streets", class.name)).changed() {
                if is_on {
                    off.remove(&class.name)
                } else {
                    off.insert(class.name.clone())
                };
            }
        }
    });
}

fn slider(ui: &mut Ui, name: &str, slider: Slider) {
    let label = ui.label(name);
    ui.add(slider).labelled_by(label.id);
}

fn colours(ui: &mut Ui, state: &mut State) {
    let all = state.colourings();
    let name = all.iter().find(|(by, _)| *by == state.colour_by).map_or("", |(_, name)| name);
    let label = ui.label("Colour streets");
    let mut chosen = state.colour_by;
    let combo = ComboBox::from_id_salt("colours").selected_text(name).show_ui(ui, |ui| {
        for (by, name) in &all {
            ui.selectable_value(&mut chosen, *by, *name);
        }
    });
    combo.response.labelled_by(label.id);
    if chosen != state.colour_by {
        state.commands.push(Command::ColourBy(chosen));
    }
    // Instead of it the order of growth may be shown.
    if let Some(scene) = state.ready.as_ref().and_then(|ready| ready.scene.as_ref()).filter(|_| !state.by_growth) {
        legend(ui, &scene.map.legend);
    }
}

fn legend(ui: &mut Ui, entries: &[(String, [u8; 3])]) {
    for (name, [r, g, b]) in entries {
        ui.horizontal(|ui| {
            let (rect, _) = ui.allocate_exact_size(Vec2::new(18.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(*r, *g, *b));
            ui.label(name);
        });
    }
}

/// The streets by when they grew: another map in place of the usual one.
fn growth(ui: &mut Ui, state: &mut State) {
    let help = "Colours the streets by the step in which they grew; the city is grown once more for it";
    ui.checkbox(&mut state.by_growth, "Growth order").on_hover_text(help);
    if !state.by_growth {
        return;
    }
    match &state.growth.done {
        Some(Ok(map)) => legend(ui, &map.legend),
        Some(Err(error)) => {
            ui.colored_label(ui.visuals().error_fg_color, error);
        }
        None => {
            busy(ui);
        }
    }
}

/// Views that were kept.
fn bookmarks(ui: &mut Ui, state: &mut State) {
    ui.strong("Views");
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Keep this view as");
        ui.add(TextEdit::singleline(&mut state.filters.view_name).desired_width(90.0)).labelled_by(label.id);
        let name = state.filters.view_name.trim().to_owned();
        if ui.add_enabled(!name.is_empty() && state.ready.is_some(), Button::new("Keep view")).clicked() {
            state.commands.push(Command::KeepView(name));
            state.filters.view_name.clear();
        }
    });
    let names: Vec<String> = state.bookmarks().iter().map(|kept| kept.name.clone()).collect();
    for (index, name) in names.iter().enumerate() {
        ui.horizontal(|ui| {
            let keys = if index < 9 { format!("Ctrl+{}", index + 1) } else { String::new() };
            if ui.add(Button::new(name).shortcut_text(keys)).clicked() {
                state.commands.push(Command::GoTo(index));
            }
            if called(ui.small_button("Forget"), &format!("Forget {name}")).clicked() {
                state.commands.push(Command::ForgetView(index));
            }
        });
    }
}

fn overlay(ui: &mut Ui, state: &mut State) {
    let maps: Vec<String> =
        state.ready.as_ref().map(|ready| ready.built.city.site.maps.keys().cloned().collect()).unwrap_or_default();
    ui.strong("Maps of the site");
    let label = ui.label("Lay a map over");
    let chosen = state.overlay.0.clone().unwrap_or_else(|| "nothing".into());
    let combo = ComboBox::from_id_salt("overlay").selected_text(chosen).show_ui(ui, |ui| {
        ui.selectable_value(&mut state.overlay.0, None, "nothing");
        for map in &maps {
            ui.selectable_value(&mut state.overlay.0, Some(map.clone()), map);
        }
    });
    combo.response.labelled_by(label.id);
    slider(ui, "Opacity", Slider::new(&mut state.overlay.1, 0.0..=1.0));
}

/// What the last frames cost.
fn costs(ui: &mut Ui, state: &State) {
    for which in [View::Map, View::Model] {
        let cost = state.views.cost(which);
        ui.weak(format!(
            "{}: {} parts in sight, {} draws, {} triangles, {} kB uploaded, {} parts out of sight, {} far off, {:.1} ms",
            which.name(),
            cost.seen,
            cost.draws,
            cost.primitives,
            cost.bytes.div_ceil(1024),
            cost.culled,
            cost.simplified,
            cost.cpu.as_secs_f64() * 1000.0
        ));
    }
}
