//! What is wrong in scripts and rules, each with its place.

use super::called;
use super::source::Place;
use crate::state::{Command, State};
use city::FaultReport;
use eframe::egui::{Label, RichText, Ui};
use script::Texts;

/// Shows it.
pub fn ui(ui: &mut Ui, state: &mut State) {
    if let Some(failure) = state.failure.clone() {
        let words = match (&state.held, &state.ready) {
            (Some(_), _) => "Rules fail since the last change; the city shown is the one before it.",
            (None, Some(_)) => "The last change does not build; the city shown is the one before it.",
            (None, None) => "It does not build.",
        };
        ui.colored_label(ui.visuals().error_fg_color, words);
        if state.held.is_some()
            && ui.button("Show it anyway").on_hover_text("With what stands in for the rules").clicked()
        {
            state.commands.push(Command::ShowAnyway);
        }
        if let Some(message) = failure.message.as_ref().filter(|_| failure.faults.is_empty()) {
            ui.label(message);
        }
        faults(ui, state, &failure.faults, failure.texts.as_ref());
        ui.separator();
    }
    if let Some(error) = state.misread.clone() {
        let words = "The file of saved changes cannot be read: it is left aside until it is mended.";
        ui.colored_label(ui.visuals().error_fg_color, words);
        faults(ui, state, &error, None);
        ui.separator();
    }
    let Some(ready) = state.ready.clone() else { return };
    let report = &ready.built.report;
    let is_well = state.failure.is_none() && state.misread.is_none() && ready.unsuited.is_empty();
    if report.faults.is_empty() && report.warnings.is_empty() && is_well {
        ui.weak("Nothing is wrong.");
    }
    unsuited(ui, state, &ready.unsuited, &ready.as_written.texts);
    faults(ui, state, &report.faults, Some(&ready.as_written.texts));
    for warning in &report.warnings {
        ui.label(format!("warning: {warning}"));
    }
    for print in &report.prints {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(print.to_string()).monospace());
            if let Some(at) = print.place
                && called(ui.small_button("Show on the map"), &format!("Show {} on the map", print.text)).clicked()
            {
                state.commands.push(Command::ShowPlace(at));
            }
        });
    }
}

/// Changes that the script knows nothing of any more.
fn unsuited(ui: &mut Ui, state: &mut State, wrong: &[FaultReport], texts: &Texts) {
    if wrong.is_empty() {
        return;
    }
    ui.colored_label(
        ui.visuals().error_fg_color,
        "Changes that do not suit the script: the city is shown without them.",
    );
    faults(ui, state, wrong, Some(texts));
    if ui.button("Take them back").on_hover_text("Removes these changes; the others stay").clicked() {
        state.commands.push(Command::DropUnsuited);
    }
    ui.separator();
}

/// Errors first: what only might be wrong can wait.
fn faults(ui: &mut Ui, state: &mut State, faults: &[FaultReport], texts: Option<&Texts>) {
    let (errors, others): (Vec<_>, Vec<_>) = faults.iter().partition(|fault| fault.is_error());
    for (index, fault) in errors.into_iter().chain(others).enumerate() {
        ui.push_id(index, |ui| one(ui, state, fault, texts));
    }
}

fn one(ui: &mut Ui, state: &mut State, fault: &FaultReport, texts: Option<&Texts>) {
    ui.separator();
    let colour = if fault.is_error() { ui.visuals().error_fg_color } else { ui.visuals().warn_fg_color };
    let times = if fault.count > 1 { format!(" ({} times)", fault.count) } else { String::new() };
    ui.colored_label(colour, format!("{}: {}{times}", fault.severity, fault.message));
    if fault.line > 0 {
        let place = format!("{}:{}:{}", fault.file, fault.line, fault.column);
        ui.horizontal(|ui| {
            if ui.link(RichText::new(&place).monospace()).on_hover_text("Shows the text there").clicked() {
                let place = Place { file: fault.file.clone(), line: fault.line, column: fault.column, is_new: true };
                state.commands.push(Command::ShowSource(place));
            }
            if let Some(at) = fault.place
                && ui.small_button("Show on the map").clicked()
            {
                state.commands.push(Command::ShowPlace(at));
            }
        });
        let text = texts.and_then(|texts| texts.get(&fault.file));
        if let Some(line) = text.as_ref().and_then(|text| text.lines().nth(fault.line as usize - 1)) {
            let before = " ".repeat(fault.column.saturating_sub(1) as usize);
            let under = "^".repeat(fault.length.max(1) as usize);
            ui.add(Label::new(RichText::new(format!("{line}\n{before}{under}")).monospace()).extend());
        }
    }
    if let Some(hint) = &fault.hint {
        ui.label(format!("hint: {hint}"));
    }
}
