//! How the city grew, step by step.

use super::busy;
use crate::state::State;
use eframe::egui::{Slider, Ui};

/// Shows it.
pub fn ui(ui: &mut Ui, state: &mut State) {
    if state.ready.is_none() {
        ui.weak("How a city grew is shown once it is open.");
        return;
    }
    let timeline = &mut state.timeline;
    ui.horizontal_wrapped(|ui| {
        let words = if timeline.plays() { "Pause" } else { "Play" };
        // As wide for both words: what stands beside it is not to move under the hand.
        let button = eframe::egui::Button::new(words).min_size([56.0, 0.0].into());
        if ui.add(button).on_hover_text("Shows on the map how the streets grew").clicked() {
            timeline.play(!timeline.plays());
        }
        let is_left = timeline.moment.is_none() && !timeline.is_busy();
        if ui.add_enabled(!is_left, eframe::egui::Button::new("Finished city")).clicked() {
            timeline.leave();
        }
        if timeline.is_busy() && timeline.moment.is_none() {
            busy(ui);
            ui.label("The city is grown once more, to see how");
        }
    });
    if let Some(problem) = &timeline.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    let Some(moment) = timeline.moment.clone() else { return };
    let mut step = moment.step;
    let label = ui.label("Step");
    ui.spacing_mut().slider_width = (ui.available_width() - 80.0).max(80.0);
    if ui.add(Slider::new(&mut step, 0..=moment.last)).labelled_by(label.id).changed() {
        timeline.play(false);
        timeline.go(step);
    }
    // A sum that comes back to nothing may lie a little below it.
    ui.label(format!("{:.1} km of streets", moment.kilometres.max(0.0) + 0.0));
    for (name, first, last) in &moment.stages {
        let now = (*first..=*last).contains(&moment.step);
        let words = format!("{name}: steps {first} to {last}");
        if now {
            ui.strong(words)
        } else {
            ui.weak(words)
        };
    }
}
