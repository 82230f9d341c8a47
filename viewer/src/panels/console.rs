//! Rhai on the open city.

use super::busy;
use crate::state::{Command, State};
use eframe::egui::{Key, RichText, ScrollArea, TextEdit, Ui};

/// What people may try.
const HINT: &str =
    "city.km, city.order, city.parcels().len(), picked, rule(\"streets/grid\").propose(#{ heading: 10 }) …";

/// Shows it.
pub fn ui(ui: &mut Ui, state: &mut State) {
    if state.ready.is_none() {
        ui.weak("Questions about a city can be asked once it is open.");
        return;
    }
    let console = &mut state.console;
    let mut run = false;
    ui.horizontal(|ui| {
        let label = ui.label("Rhai");
        let width = (ui.available_width() - 60.0).max(120.0);
        let edit = TextEdit::singleline(&mut console.text).code_editor().desired_width(width).hint_text(HINT);
        let edit = ui.add(edit).labelled_by(label.id);
        if edit.has_focus() {
            let pressed = |key| ui.input(|input| input.key_pressed(key));
            if pressed(Key::ArrowUp) {
                console.recall(true);
            } else if pressed(Key::ArrowDown) {
                console.recall(false);
            }
        }
        run |= edit.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if run {
            edit.request_focus();
        }
        run |= ui.button("Run").clicked();
        if console.is_busy() {
            busy(ui);
        }
    });
    if run {
        state.commands.push(Command::Run);
    }
    if console.entries.is_empty() {
        ui.weak(
            "`city` is the open city, with the words of rule tests: measures, streets(), parcels(), distance(…); \
                 `picked` is what is picked. Values stay: let big = city.parcels().filter(|p| p.area > 900);",
        );
    }
    ScrollArea::vertical().id_salt("answers").auto_shrink(false).show(ui, |ui| {
        for entry in console.entries.iter().rev() {
            ui.label(RichText::new(format!("> {}", entry.text)).monospace().strong());
            for line in &entry.printed {
                ui.label(RichText::new(line).monospace());
            }
            if let Some(value) = &entry.value {
                ui.label(RichText::new(value).monospace());
            }
            if let Some(fault) = &entry.fault {
                let place = if fault.file == "console" { String::new() } else { format!("{}: ", fault.file) };
                let words = format!("{place}line {}, column {}: {}", fault.line, fault.column, fault.message);
                ui.colored_label(ui.visuals().error_fg_color, words);
                if let Some(hint) = &fault.hint {
                    ui.label(format!("hint: {hint}"));
                }
            }
        }
    });
}
