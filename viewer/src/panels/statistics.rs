//! Counts and lengths of the city.

use crate::state::State;
use eframe::egui::{Grid, Ui};

/// Shows them.
pub fn ui(ui: &mut Ui, state: &mut State) {
    let Some(ready) = &state.ready else {
        ui.weak("Figures of a city are shown once it is open.");
        return;
    };
    let report = &ready.built.report;
    Grid::new("counts").num_columns(2).striped(true).show(ui, |ui| {
        for (name, count) in &report.counts {
            ui.label(*name);
            ui.label(count.to_string());
            ui.end_row();
        }
        for (class, metres) in &report.street_metres {
            ui.label(format!("{class} streets"));
            ui.label(format!("{:.1} km", metres / 1000.0));
            ui.end_row();
        }
        ui.label("made in");
        ui.label(format!("{:.2} s", ready.took.as_secs_f64()));
        ui.end_row();
    });
}
