//! What is asked and told over the panels or below them.

use super::action::Action;
use super::{App, Asking, Leaving};
use crate::state::Command;
use eframe::egui::{self, Button, Key, Modifiers, Panel, ScrollArea, TextEdit, Ui};
use std::path::PathBuf;

impl App {
    /// All that can be done, to be found by typing.
    pub(super) fn show_palette(&mut self, ui: &Ui) {
        if !self.palette {
            return;
        }
        let mut done = None;
        let width = wide(ui, 420.0);
        let modal = egui::Modal::new(egui::Id::unique("palette")).show(ui.ctx(), |ui| {
            ui.set_width(width);
            let label = ui.label("All that can be done");
            // Before the field takes them for itself.
            let step = ui.input_mut(|input| {
                let mut pressed = |key| input.count_and_consume_key(Modifiers::NONE, key);
                (pressed(Key::ArrowDown), pressed(Key::ArrowUp))
            });
            let edit = ui
                .add(TextEdit::singleline(&mut self.state.filters.palette).desired_width(width - 20.0))
                .labelled_by(label.id);
            edit.request_focus();
            if edit.changed() {
                self.palette_at = 0;
            }
            let wanted = self.state.filters.palette.to_lowercase();
            let found = Action::all().filter(|action| {
                action.name().to_lowercase().contains(&wanted)
                    && action.is_possible(&self.state)
                    && *action != Action::Palette
            });
            let found: Vec<Action> = found.collect();
            let last = found.len().saturating_sub(1);
            self.palette_at = (self.palette_at + step.0).saturating_sub(step.1).min(last);
            let enter = ui.input(|input| input.key_pressed(Key::Enter));
            let height = (ui.ctx().content_rect().height() * 0.6).min(400.0);
            let list = ScrollArea::vertical().max_height(height).min_scrolled_height(height).auto_shrink(false);
            list.show(ui, |ui| {
                if found.is_empty() {
                    ui.weak("Nothing of that name can be done now.");
                }
                for (i, action) in found.into_iter().enumerate() {
                    let keys = action.shortcut().map(|keys| ui.ctx().format_shortcut(&keys)).unwrap_or_default();
                    let is_chosen = i == self.palette_at;
                    let button = Button::new(action.name()).shortcut_text(keys).min_size([width - 20.0, 0.0].into());
                    let button = ui.add(button.selected(is_chosen));
                    if is_chosen && step != (0, 0) {
                        button.scroll_to_me(None);
                    }
                    if button.clicked() || (is_chosen && enter) {
                        done = Some(action);
                    }
                }
            });
        });
        if modal.should_close() || done.is_some() {
            self.palette = false;
        }
        if let Some(action) = done {
            self.act(ui, action);
        }
    }

    /// A path to type, where the system has no dialogs.
    pub(super) fn show_path(&mut self, ui: &Ui) {
        let Some((asking, path)) = &mut self.path else { return };
        let asking = *asking;
        let mut named = None;
        let (words, button) = match asking {
            Asking::Open => ("Folder of the city, or its script", "Open"),
            Asking::Copy => ("A new folder for a copy of the city with its changes", "Save the copy"),
        };
        let width = wide(ui, 480.0);
        let modal = egui::Modal::new(egui::Id::unique("path")).show(ui.ctx(), |ui| {
            ui.set_width(width);
            let label = ui.label(words);
            let edit = ui.add(TextEdit::singleline(path).desired_width(width - 20.0)).labelled_by(label.id);
            if path.is_empty() {
                edit.request_focus();
            }
            let enter = edit.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let is_named = !path.trim().is_empty();
            if (ui.add_enabled(is_named, Button::new(button)).clicked() || enter) && is_named {
                named = Some(PathBuf::from(path.trim()));
            }
        });
        if modal.should_close() || named.is_some() {
            self.path = None;
        }
        self.state.commands.extend(named.map(|path| asking.command(path)));
    }

    /// What went wrong, until it is read.
    pub(super) fn show_message(&mut self, ui: &mut Ui) {
        let Some(message) = self.state.message.clone() else { return };
        Panel::bottom("message").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                if ui.button("Dismiss").clicked() {
                    self.state.commands.push(Command::Dismiss);
                }
                ui.strong(message);
            });
        });
    }

    /// Changes that an earlier run left unsaved, until people say what becomes of them.
    pub(super) fn show_recovery(&mut self, ui: &mut Ui) {
        if self.state.recovery.found.is_empty() {
            return;
        }
        Panel::bottom("recovery").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.strong("The program ended before changes of this city were saved.");
                for (words, wanted) in [("Take them up", true), ("Forget them", false)] {
                    if ui.button(words).clicked() {
                        self.state.commands.push(Command::Recover(wanted));
                    }
                }
            });
        });
    }

    /// What would leave a city with changes that are not saved waits until people say what becomes of them.
    pub(super) fn ask_before_leaving(&mut self) {
        let leaves = |command: &Command| matches!(command, Command::Open(_) | Command::Close);
        if self.state.history.is_saved() || !self.state.commands.iter().any(leaves) {
            return;
        }
        let (leaving, others) = std::mem::take(&mut self.state.commands).into_iter().partition::<Vec<_>, _>(leaves);
        self.state.commands = others;
        self.leaving = leaving.into_iter().next_back().map(Leaving::City);
    }

    /// Before a city with changes is left people are asked what becomes of them.
    pub(super) fn show_leaving(&mut self, ui: &Ui) {
        let wants_to_close = ui.ctx().input(|input| input.viewport().close_requested());
        // Where another window takes this one's place, nothing is lost.
        let is_closing = self.leaving == Some(Leaving::Window);
        if wants_to_close && !self.state.history.is_saved() && !is_closing && !self.lost.is_lost() {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.leaving = Some(Leaving::Window);
        }
        let Some(leaving) = self.leaving.clone() else { return };
        let (save, give_up) = match &leaving {
            Leaving::Window => ("Save and close", "Close without saving"),
            Leaving::City(_) => ("Save and go on", "Go on without saving"),
        };
        let (mut goes, mut stays) = (false, false);
        let modal = egui::Modal::new(egui::Id::unique("leaving")).show(ui.ctx(), |ui| {
            ui.label("The changes of the city are not saved.");
            ui.horizontal_wrapped(|ui| {
                if ui.button(save).clicked() {
                    self.state.carry_out(Command::Save);
                    // What cannot be saved is told, and stays.
                    goes = self.state.history.is_saved();
                    stays = !goes;
                }
                if ui.button(give_up).clicked() {
                    self.state.give_up_changes();
                    goes = true;
                }
                stays |= ui.button("Stay").clicked();
            });
        });
        if goes {
            match leaving {
                Leaving::Window => ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close),
                Leaving::City(command) => {
                    self.state.forget_changes();
                    self.state.commands.push(command);
                    self.leaving = None;
                }
            }
        } else if stays || modal.should_close() {
            self.leaving = None;
        }
    }
}

/// As wide as something is to be, or as there is room.
fn wide(ui: &Ui, width: f32) -> f32 {
    width.min(ui.ctx().content_rect().width() - 40.0).max(60.0)
}
