//! What is picked: its measures, and why it is there.

use super::source::Place;
use super::{busy, called};
use crate::inspect::facts;
use crate::state::{Command, State};
use eframe::egui::{Grid, Label, RichText, Ui};

/// Shows it.
pub fn ui(ui: &mut Ui, state: &mut State) {
    let (Some(ready), Some(element)) = (state.ready.clone(), state.selected.clone()) else {
        ui.weak("Click something on the map or in the model; click again for what lies around it.");
        return;
    };
    ui.heading(element.kind.name());
    Grid::new("facts").num_columns(2).show(ui, |ui| {
        for (name, value) in facts(&ready.built.city, &element) {
            ui.weak(name);
            ui.add(Label::new(&value).truncate()).on_hover_text(&value);
            ui.end_row();
        }
    });
    ui.horizontal_wrapped(|ui| {
        if ui.button("Look at it").clicked() {
            state.commands.push(Command::Fit);
        }
        if ui.button("Why is this here?").clicked() {
            state.commands.push(Command::Ask);
        }
        if ui.button("Let go").on_hover_text("Picks nothing").clicked() {
            state.commands.push(Command::Select(None));
        }
    });
    if state.asked.is_busy() {
        ui.horizontal(|ui| {
            busy(ui);
            ui.label("The city is grown once more, to see why");
        });
    }
    match &state.asked.done {
        Some(Ok(answer)) => {
            for rule in &answer.rules {
                let Some(line) = rule.line else { continue };
                let link = ui.link(format!("{}: {}", rule.role, rule.name));
                if called(link, &format!("Text of {}", rule.name)).on_hover_text("Shows the text").clicked() {
                    let place = Place { file: rule.file.clone(), line, column: 1, is_new: true };
                    state.commands.push(Command::ShowSource(place));
                }
            }
            ui.label(RichText::new(answer.to_string()).monospace().size(11.0));
        }
        Some(Err(error)) => {
            ui.colored_label(ui.visuals().error_fg_color, error);
        }
        None => {}
    }
}
