//! What is kept beyond the window: changes, copies, rules and presets of a city's own.

use super::{LIBRARY, State};
use crate::preset_file;
use city::{Changes, FaultReport};
use script::PresetTarget;
use std::path::Path;

impl State {
    /// Follows the file of changes where something else wrote it. Changes that are not saved here are not touched: whoever
    /// saves them is told.
    pub(super) fn look_at_saved(&mut self) {
        let file = Changes::file_of(&self.script);
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        match Changes::saved(&self.script) {
            Ok(there) => {
                self.misread = None;
                if there == *self.history.saved() {
                    return;
                }
                if !self.history.is_saved() {
                    if there != self.history.now() && self.told_of_other.as_ref() != Some(&there) {
                        self.told_of_other = Some(there);
                        self.message = Some(format!(
                            "Something else wrote {name}. Your own changes are not saved: they stay, and saving asks before it \
                             writes over the file."
                        ));
                    }
                    return;
                }
                self.history.step(&format!("{name} as something else wrote it"), None, |changes| *changes = there);
                self.history.mark_saved();
                self.message = Some(format!("Something else wrote {name}: the city follows it. Undo takes that back."));
                self.changed();
            }
            Err(faults) => self.misread = Some(faults.iter().map(FaultReport::from).collect()),
        }
    }

    /// Keeps changes that are not saved where they outlive the program.
    pub(super) fn guard(&mut self) {
        let Some(city) = &self.city else { return };
        let now = self.history.now();
        let kept = self.recovery.keep(city, (!self.history.is_saved()).then_some(&now));
        if let Err(error) = kept {
            self.message = Some(format!("Changes that are not saved are not kept against a crash: {error}"));
        }
    }

    /// Takes up changes of an earlier run, or forgets them.
    pub(super) fn recover(&mut self, wanted: bool) {
        let Some(lost) = self.recovery.found.pop() else { return };
        if wanted {
            self.change("changes that were not saved", None, |changes| *changes = lost);
        }
        self.guard();
    }

    /// The changes that are not saved are not to be saved: nothing of them is kept.
    pub fn give_up_changes(&mut self) {
        if let Some(city) = &self.city {
            // What cannot be removed is offered once more at the next start.
            let _ = self.recovery.keep(city, None);
        }
    }

    /// Saves the changes beside the script.
    pub(super) fn save(&mut self) {
        let told = self.try_to_save().err();
        // What was wrong before is not any more.
        if told.is_some() || self.message == self.told_of_saving {
            self.message.clone_from(&told);
        }
        self.told_of_saving = told;
    }

    fn try_to_save(&mut self) -> Result<(), String> {
        let Some(ready) = &self.ready else { return Ok(()) };
        if !self.script.exists() {
            return Err(format!(
                "Not saved: {} is not there any more. The changes are still here.",
                self.script.display()
            ));
        }
        let now = self.history.now();
        let there = match Changes::saved(&self.script) {
            Ok(there) if there == now || there == *self.history.saved() => None,
            // Whoever wrote them may be another program, or a person with an editor.
            Ok(there) => Some(there.plain()),
            Err(faults) => faults
                .iter()
                .any(|fault| fault.line > 0)
                .then(|| faults.iter().map(|fault| format!("{fault}\n")).collect()),
        };
        if there.is_some() && self.warned != there {
            self.warned = there;
            let file = Changes::file_of(&self.script);
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            return Err(format!(
                "Not saved: something else wrote {name} since it was read here. Save again to write over it, or keep a copy of \
                 the file first."
            ));
        }
        let saved = now.save(&ready.as_written);
        saved.map_err(|error| format!("The changes could not be saved; they are still here. {error}"))?;
        self.history.mark_saved();
        (self.warned, self.misread, self.told_of_other) = (None, None, None);
        self.guard();
        Ok(())
    }

    /// Saves the city with its changes as another one.
    pub(super) fn save_copy(&mut self, to: &Path) {
        let Some(ready) = self.ready.clone() else { return };
        let now = self.history.now();
        let text = (!now.is_empty()).then(|| now.text(&ready.as_written));
        let copy = match city::copy_city(&self.script, to, text.as_deref()) {
            Ok(copy) => copy,
            Err(error) => {
                return self.message = Some(format!("No copy was saved; the changes are still here. {error}"));
            }
        };
        // They lie in the copy now: what this city has on disk is as it was.
        self.give_up_changes();
        let (mut history, views) = (std::mem::take(&mut self.history), self.views.bookmark(""));
        history.mark_saved();
        self.open(&copy);
        (self.history, self.keeps_views) = (history, true);
        self.views.go_to(&views);
        self.message = Some(format!("Saved as {}; that city is open now.", copy.display()));
    }

    /// Copies a rule of the library into the city's folder.
    pub(super) fn adopt(&mut self, file: &str) {
        let (Some(ready), Some(name)) = (&self.ready, file.strip_prefix(LIBRARY)) else { return };
        let Some(text) = self.text_of(file) else { return };
        let path = ready.as_written.folder.join(name);
        if path.exists() {
            self.message = Some(format!("{} is there already", path.display()));
            return;
        }
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(|error| error.to_string());
        let written = made.and_then(|()| {
            let written = city::export::write_atomically(&path, |out| out.write_all(text.as_bytes()));
            written.map_err(|error| error.to_string())
        });
        self.message = Some(match written {
            Ok(()) => {
                if let Some(place) = &mut self.source {
                    place.file = path.display().to_string();
                }
                format!("The city has a rule of its own now: what is saved in {} shows at once.", path.display())
            }
            Err(error) => format!("{} could not be written: {error}", path.display()),
        });
    }

    /// Saves what is in force where presets are laid.
    pub(super) fn save_preset(&mut self, name: &str) {
        let Some(ready) = self.ready.clone() else { return };
        // As people say it.
        let name = &name.trim().to_lowercase().replace([' ', '-'], "_");
        let plan = &ready.sources.plan;
        let there = match &self.target {
            PresetTarget::Quarter(id) => plan.in_quarter(Some(*id)),
            _ => std::borrow::Cow::Borrowed(plan),
        };
        let folder = &ready.as_written.folder;
        let class = match &self.target {
            PresetTarget::Class(class) => class,
            _ => "minors",
        };
        self.message = Some(match preset_file::save(&there, class, folder, name, &ready.built.city.name) {
            Ok((path, left_out)) if left_out.is_empty() => format!("Saved as {}", path.display()),
            Ok((path, left_out)) => {
                format!(
                    "Saved as {}, without {}: they differ from place to place",
                    path.display(),
                    left_out.join(" and ")
                )
            }
            Err(error) => error,
        });
    }
}
