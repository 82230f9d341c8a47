//! The text of a script, at the place that a fault or an answer tells.

use crate::editor;
use crate::state::{Command, LIBRARY, State};
use eframe::egui::{Align, RichText, ScrollArea, TextEdit, TextStyle, Ui};

/// A place in a script.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The column, from 1.
    pub column: u32,
    /// Whether it is still to be scrolled to.
    pub is_new: bool,
}

/// Shows it.
pub fn ui(ui: &mut Ui, state: &mut State) {
    let Some(place) = state.source.clone() else {
        ui.weak("Where a fault or an answer names a place in a script, a click on it shows the text here.");
        return;
    };
    let text = state.text_of(&place.file);
    ui.horizontal_wrapped(|ui| {
        ui.strong(format!("{}:{}:{}", place.file, place.line, place.column));
        if ui.button("Open in editor").on_hover_text("By the command below").clicked() {
            let opened = editor::open(&state.preferences.editor, &place.file, place.line, place.column);
            state.message = opened.err().or(state.message.take());
        }
        if place.file.starts_with(LIBRARY) && state.ready.is_some() {
            let help = "The rule comes with the program; one of its name in the city's folder takes its place";
            if ui.button("Change it for this city").on_hover_text(help).clicked() {
                state.commands.push(Command::Adopt(place.file.clone()));
            }
        }
        if ui.small_button("Copy place").clicked() {
            ui.ctx().copy_text(format!("{}:{}:{}", place.file, place.line, place.column));
        }
        let label = ui.label("Editor");
        let edit = TextEdit::singleline(&mut state.preferences.editor).desired_width(260.0).code_editor();
        let edit = ui.add(edit).labelled_by(label.id);
        if edit.on_hover_text("{file}, {line} and {column} stand for the place").lost_focus() {
            state.remember();
        }
    });
    let Some(text) = text else {
        ui.label("The text of this file is not known any more.");
        return;
    };
    let lines: Vec<&str> = text.lines().collect();
    let height = ui.text_style_height(&TextStyle::Monospace);
    let mut area = ScrollArea::both().id_salt("source").auto_shrink(false);
    if place.is_new {
        let above = f32::max(0.0, (place.line as f32 - 4.0) * (height + ui.spacing().item_spacing.y));
        area = area.vertical_scroll_offset(above);
        state.source = Some(Place { is_new: false, ..place.clone() });
    }
    area.show_rows(ui, height, lines.len(), |ui, rows| {
        ui.with_layout(eframe::egui::Layout::top_down(Align::Min), |ui| {
            for row in rows {
                let words = RichText::new(format!("{:>4}  {}", row + 1, lines[row])).monospace();
                if row + 1 == place.line as usize {
                    ui.label(words.strong().background_color(ui.visuals().selection.bg_fill));
                } else {
                    ui.label(words);
                }
            }
        });
    });
}
