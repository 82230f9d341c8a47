//! What is picked: its measures, and why it is there.

use super::source::Place;
use super::{busy, called};
use crate::inspect::facts;
use crate::state::{Command, State};
use city::why::{Answer, DecisionSays};
use eframe::egui::{CollapsingHeader, Grid, Label, RichText, Ui};

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
            told(ui, &mut state.commands, answer);
        }
        Some(Err(error)) => {
            ui.colored_label(ui.visuals().error_fg_color, error);
        }
        None => {}
    }
}

/// Size of what is told, in points.
const SIZE: f32 = 11.0;

fn line(ui: &mut Ui, text: &str) {
    ui.add(Label::new(RichText::new(text).monospace().size(SIZE)).extend());
}

/// An answer part by part; steps of rules lead to their lines.
fn told(ui: &mut Ui, commands: &mut Vec<Command>, answer: &Answer) {
    let text = answer.to_string();
    for (number, part) in text.trim_end().split("\n\n").enumerate() {
        let (heading, rest) = part.split_once('\n').unwrap_or((part, ""));
        if number == 0 {
            line(ui, part);
            continue;
        }
        let decision = answer.decisions.iter().find(|decision| decision.heading() == heading);
        let header = CollapsingHeader::new(heading).id_salt(number).default_open(true);
        header.show(ui, |ui| match decision {
            Some(decision) => steps(ui, commands, decision, rest),
            None => line(ui, rest),
        });
    }
}

/// What a rule did, each step with a link to its line, and then what came of it.
fn steps(ui: &mut Ui, commands: &mut Vec<Command>, decision: &DecisionSays, text: &str) {
    // Rows as high as lines of text, not as buttons.
    ui.spacing_mut().interact_size.y = 0.0;
    for (number, step) in decision.steps.iter().enumerate() {
        if let Some(left_out) = decision.left_out.filter(|left_out| left_out.behind == number) {
            line(ui, &format!("… {} further steps", left_out.count));
        }
        ui.horizontal(|ui| {
            let link = ui.link(RichText::new(format!("{:>4}", step.line)).monospace().size(SIZE));
            let file = step.file.as_ref().unwrap_or(&decision.file);
            if called(link, &format!("{file}:{}", step.line)).on_hover_text("Shows the text there").clicked() {
                let place = Place { file: file.clone(), line: step.line, column: 1, is_new: true };
                commands.push(Command::ShowSource(place));
            }
            line(ui, &step.told);
        });
    }
    // Behind the steps stands what came of them.
    let told = decision.steps.len() + usize::from(decision.left_out.is_some());
    let rest: Vec<&str> = text.lines().skip(told).collect();
    line(ui, &rest.join("\n"));
}
