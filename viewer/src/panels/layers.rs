//! What is shown, and how.

use crate::scene::LayerKind;
use crate::shown::MODEL_PARTS;
use crate::state::{Command, State};
use crate::viewport::View;
use eframe::egui::{Color32, ComboBox, Sense, Slider, Ui, Vec2};

/// Shows them.
pub fn ui(ui: &mut Ui, state: &mut State) {
    ui.strong("Map");
    ui.checkbox(&mut state.preferences.layers.ground, "Land and water");
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
    }
    colours(ui, state);
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
    ui.separator();
    overlay(ui, state);
    ui.separator();
    costs(ui, state);
}

fn slider(ui: &mut Ui, name: &str, slider: Slider) {
    ui.horizontal(|ui| {
        let label = ui.label(name);
        ui.add(slider).labelled_by(label.id);
    });
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
    let legend = state.ready.as_ref().and_then(|ready| ready.scene.as_ref()).map(|scene| scene.map.legend.clone());
    for (name, [r, g, b]) in legend.into_iter().flatten() {
        ui.horizontal(|ui| {
            let (rect, _) = ui.allocate_exact_size(Vec2::new(18.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
            ui.label(name);
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
            "{}: {} draws, {} triangles, {} kB uploaded, {} parts out of sight, {:.1} ms",
            which.name(),
            cost.draws,
            cost.primitives,
            cost.bytes.div_ceil(1024),
            cost.culled,
            cost.cpu.as_secs_f64() * 1000.0
        ));
    }
}
