//! The window.

mod action;
mod dialogs;

use crate::command::Arguments;
use crate::history::History;
use crate::lost::Lost;
use crate::panels::{self, Docks, Pane, busy, usual};
use crate::pictures::Pictures;
use crate::preferences::{Bookmark, Preferences, Theme};
use crate::render::Gpu;
use crate::state::{Command, State};
use crate::worker::Wake;
use action::{Action, DIGITS};
use eframe::egui::{self, Button, CentralPanel, Image, Panel, ScrollArea, Ui};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The window's contents.
pub struct App {
    state: State,
    docks: egui_tiles::Tree<Pane>,
    /// Whether panels were laid out otherwise since that was remembered.
    docked: bool,
    /// Whether what can be done is listed.
    palette: bool,
    /// A path being typed, where the system has no dialogs, and what for.
    path: Option<(Asking, String)>,
    /// Which of the things listed is chosen.
    palette_at: usize,
    /// What waits until people say what becomes of changes.
    leaving: Option<Leaving>,
    /// What the window is called.
    title: String,
    /// Pictures of cities to choose from.
    pictures: Pictures,
    /// Whether the graphics device was lost, and why.
    lost: Lost,
    /// Where what is open is left for the next window, once the device is lost.
    carried: Option<Arc<Mutex<Option<Carried>>>>,
}

/// What is to be done once the open city is left.
#[derive(Clone, Debug, PartialEq)]
enum Leaving {
    /// The window closes.
    Window,
    /// Something else is shown.
    City(Command),
}

/// What a path is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asking {
    /// A city to open.
    Open,
    /// Where a copy of the open city is to be.
    Copy,
}

/// What a window leaves to the one that takes its place.
struct Carried {
    history: History,
    city: Option<PathBuf>,
    views: Bookmark,
    docks: egui_tiles::Tree<Pane>,
    /// Tells whether the window's device was lost.
    lost: Lost,
    /// Ends the window's worker, where the window did not.
    end: Box<dyn Fn() + Send>,
}

/// Times that a window is opened again after its device was lost.
const TRIES: u32 = 5;

/// Opens a window.
///
/// # Errors
/// When the system has none, or nothing to draw with.
pub fn open(arguments: &Arguments) -> Result<(), String> {
    let viewport =
        egui::ViewportBuilder::default().with_inner_size([1500.0, 900.0]).with_min_inner_size([320.0, 240.0]);
    let options = eframe::NativeOptions { viewport: viewport.with_title("Plat"), ..eframe::NativeOptions::default() };
    let carried = Arc::<Mutex<Option<Carried>>>::default();
    let mut tries = 0;
    loop {
        let (city, rules, left) = (arguments.city.clone(), arguments.rules.clone(), carried.clone());
        let create: eframe::AppCreator = Box::new(move |context| {
            let mut app = App::new(context, Preferences::file(), rules);
            let before = lock(&left).take();
            app.carried = Some(left);
            match before {
                Some(before) => {
                    (before.end)();
                    app.take_over(before);
                }
                None => app.state.commands.extend(city.map(Command::Open)),
            }
            Ok(Box::new(app))
        });
        // Where the device is lost in the middle of a frame, what paints the window panics: what was open is left even so.
        let shown = catch_unwind(AssertUnwindSafe(|| eframe::run_native("plat-view", options.clone(), create)));
        let is_lost = lock(&carried).as_ref().is_some_and(|left| left.lost.is_lost());
        match shown {
            Ok(Ok(())) => {}
            Err(panic) if !is_lost => resume_unwind(panic),
            Ok(Err(error)) if !is_lost => {
                let hint = "plat build CITY -o FOLDER draws a map without a screen or a graphics adapter";
                return Err(format!("no window could be opened: {}\n  hint: {hint}", in_words(&error)));
            }
            Ok(Err(_)) | Err(_) => {}
        }
        tries += 1;
        if !is_lost || tries > TRIES {
            return if is_lost { Err("the graphics device was lost again and again".into()) } else { Ok(()) };
        }
    }
}

/// What went wrong, without the places in libraries where it was noticed.
fn in_words(error: &eframe::Error) -> String {
    match error {
        eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => {
            "there is no screen: neither X11 nor Wayland answers (DISPLAY, WAYLAND_DISPLAY)".into()
        }
        eframe::Error::Wgpu(_) => {
            "no graphics adapter was found: install a driver; in software, Debian's mesa-vulkan-drivers and libvulkan1 do".into()
        }
        other => other.to_string(),
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl App {
    /// The contents of a window; preferences are kept in a file, where there is one.
    pub fn new(context: &eframe::CreationContext, preferences: Option<PathBuf>, rules: Option<PathBuf>) -> Self {
        let render = context.wgpu_render_state.as_ref();
        let gpu = render.map(|render| {
            let info = render.adapter.get_info();
            let about = format!("{} ({:?})", info.name, info.backend);
            Gpu { device: render.device.clone(), queue: render.queue.clone(), about }
        });
        let wake: Wake = {
            let context = context.egui_ctx.clone();
            Arc::new(move || context.request_repaint())
        };
        let lost = gpu.as_ref().map(|gpu| Lost::of(gpu, wake.clone())).unwrap_or_default();
        let state = State::new(gpu, preferences, rules, wake);
        chosen(&context.egui_ctx, &state.preferences);
        Self {
            docks: panels::read(state.preferences.docks.as_ref()),
            docked: false,
            state,
            palette: false,
            path: None,
            palette_at: 0,
            leaving: None,
            title: String::new(),
            pictures: Pictures::default(),
            lost,
            carried: None,
        }
    }

    /// Goes on where a window ended whose device was lost.
    fn take_over(&mut self, before: Carried) {
        self.docks = before.docks;
        if let Some(city) = before.city {
            self.state.take_over(&city, before.history, before.views);
        }
        let message = "The graphics device was lost; the window was opened anew, and nothing is lost.";
        self.state.message = Some(message.into());
    }

    /// Leaves what is open for a next window, should this one's device be lost: what paints may panic then, and nothing of the
    /// window is left.
    fn leave(&self) {
        if let Some(carried) = &self.carried {
            *lock(carried) = Some(Carried {
                history: self.state.history.clone(),
                city: self.state.city.clone(),
                views: self.state.views.bookmark(""),
                docks: self.docks.clone(),
                lost: self.lost.clone(),
                end: self.state.ender(),
            });
        }
    }

    /// Where the device is lost nothing can be drawn any more: another window takes this one's place. Errors of drawing
    /// that leave the device alone are told.
    fn look_after_device(&mut self, ui: &Ui) {
        let Some(message) = self.lost.told() else { return };
        if !self.lost.is_lost() {
            self.state.message = Some(format!("Graphics: {message}"));
            return;
        }
        if self.carried.is_some() {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
        }
    }

    /// What there is to know.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The same, to be changed by tests.
    pub fn state_mut(&mut self) -> &mut State {
        &mut self.state
    }

    /// Remembers how panels are laid out, once nothing is held any more.
    fn remember_docks(&mut self, ui: &Ui) {
        if self.docked && !ui.ctx().input(|input| input.pointer.any_down()) {
            self.docked = false;
            self.state.preferences.docks = panels::written(&self.docks);
            self.state.remember();
        }
    }

    /// Shows a pane.
    pub fn bring_up(&mut self, pane: Pane) {
        self.docks.make_active(|_, tile| matches!(tile, egui_tiles::Tile::Pane(other) if *other == pane));
    }
}

/// Makes everything look as people chose.
fn chosen(context: &egui::Context, preferences: &Preferences) {
    context.set_theme(match preferences.theme {
        Theme::System => egui::ThemePreference::System,
        Theme::Light => egui::ThemePreference::Light,
        Theme::Dark => egui::ThemePreference::Dark,
    });
    context.set_zoom_factor(preferences.scale);
    // Paler on white than can be read, as egui has them.
    context.style_mut_of(egui::Theme::Light, |style| {
        let visuals = &mut style.visuals;
        visuals.text_edit_bg_color = Some(egui::Color32::from_gray(226));
        visuals.weak_text_color = Some(egui::Color32::from_gray(95));
        visuals.warn_fg_color = egui::Color32::from_rgb(0xa8, 0x4a, 0x00);
        visuals.error_fg_color = egui::Color32::from_rgb(0xb7, 0x1c, 0x1c);
    });
    context.style_mut_of(egui::Theme::Dark, |style| {
        style.visuals.weak_text_color = Some(egui::Color32::from_gray(135));
        style.visuals.text_edit_bg_color = Some(egui::Color32::from_gray(6));
    });
}

impl Asking {
    /// What is done with the path.
    fn command(self, path: PathBuf) -> Command {
        match self {
            Self::Open => Command::Open(path),
            Self::Copy => Command::SaveCopy(path),
        }
    }
}

impl App {
    fn act(&mut self, ui: &Ui, action: Action) {
        let commands = &mut self.state.commands;
        match action {
            Action::Open => self.ask_for_path(Asking::Open),
            Action::SaveAs => self.ask_for_path(Asking::Copy),
            Action::Start => commands.push(Command::Close),
            Action::Quit => ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close),
            Action::Save => commands.push(Command::Save),
            Action::Undo => commands.push(Command::Undo),
            Action::Redo => commands.push(Command::Redo),
            Action::ResetAll => commands.push(Command::ResetAll),
            Action::Build => commands.push(Command::Build),
            Action::Cancel => commands.push(Command::Cancel),
            Action::Fit => commands.push(Command::Fit),
            Action::FitAll => commands.push(Command::FitAll),
            Action::Keep => {
                let taken = self.state.bookmarks().iter().map(|view| view.name.clone()).collect::<Vec<_>>();
                let free = (1..).map(|number| format!("View {number}")).find(|name| !taken.contains(name));
                self.state.commands.extend(free.map(Command::KeepView));
            }
            Action::Why => {
                commands.push(Command::Ask);
                self.bring_up(Pane::Inspector);
            }
            Action::Palette => {
                self.state.filters.palette.clear();
                (self.palette, self.palette_at) = (true, 0);
            }
            Action::Larger | Action::Smaller => {
                let by = if action == Action::Larger { 1.1 } else { 1.0 / 1.1 };
                self.state.preferences.scale = (self.state.preferences.scale * by).clamp(0.5, 4.0);
                chosen(ui.ctx(), &self.state.preferences);
                self.state.remember();
            }
            Action::GoTo(index) => commands.push(Command::GoTo(index)),
            Action::Restart => {
                if let Some(gpu) = self.state.gpu() {
                    gpu.device.destroy();
                }
            }
            Action::Usual => {
                self.docks = usual();
                self.docked = true;
            }
            Action::Show(pane) => self.bring_up(pane),
        }
    }

    /// By the system's own dialog, or by typing where there is none.
    fn ask_for_path(&mut self, asking: Asking) {
        let has_dialogs = std::env::var_os("DBUS_SESSION_BUS_ADDRESS").is_some() || !cfg!(target_os = "linux");
        let dialog = rfd::FileDialog::new();
        let picked = has_dialogs.then(|| match asking {
            Asking::Open => dialog.set_title("Open a city").pick_folder(),
            Asking::Copy => dialog.set_title("A new folder for a copy of the city").save_file(),
        });
        match picked {
            Some(path) => self.state.commands.extend(path.map(|path| asking.command(path))),
            None => self.path = Some((asking, String::new())),
        }
    }

    fn menus(&mut self, ui: &mut Ui) {
        let mut done = None;
        egui::MenuBar::new().ui(ui, |ui| {
            for (name, actions) in Action::MENUS {
                ui.menu_button(name, |ui| {
                    for &action in actions {
                        let keys = action.shortcut().map(|keys| ui.ctx().format_shortcut(&keys)).unwrap_or_default();
                        let button = Button::new(action.name()).shortcut_text(keys);
                        if ui.add_enabled(action.is_possible(&self.state), button).clicked() {
                            done = Some(action);
                            ui.close();
                        }
                    }
                    match name {
                        "File" => self.recent(ui),
                        "View" => self.themes(ui),
                        _ => {}
                    }
                });
            }
            self.status(ui);
        });
        if let Some(action) = done {
            self.act(ui, action);
        }
    }

    fn recent(&mut self, ui: &mut Ui) {
        ui.separator();
        for city in self.state.preferences.recent.clone() {
            if ui.button(city.display().to_string()).clicked() {
                self.state.commands.push(Command::Open(city));
                ui.close();
            }
        }
    }

    fn themes(&mut self, ui: &mut Ui) {
        ui.separator();
        for theme in Theme::ALL {
            if ui.radio_value(&mut self.state.preferences.theme, theme, theme.name()).clicked() {
                chosen(ui.ctx(), &self.state.preferences);
                self.state.remember();
            }
        }
    }

    /// What is going on, on the right of the menus.
    fn status(&mut self, ui: &mut Ui) {
        ui.separator();
        if let Some((stage, share)) = self.state.under {
            busy(ui);
            let percent = share.map_or(String::new(), |share| format!(" {:.0} %", share * 100.0));
            ui.label(format!("{stage}{percent}"));
            if ui.small_button("Give up").clicked() {
                self.state.commands.push(Command::Cancel);
            }
        } else if self.state.held.is_some() {
            ui.colored_label(ui.visuals().error_fg_color, "rules fail: see Problems");
            if ui.small_button("Show anyway").clicked() {
                self.state.commands.push(Command::ShowAnyway);
            }
        } else if self.state.failure.is_some() {
            ui.colored_label(ui.visuals().error_fg_color, "does not build: see Problems");
        } else if let Some(ready) = &self.state.ready {
            if ready.built.report.has_faults() {
                ui.colored_label(ui.visuals().error_fg_color, "rules failed: see Problems");
            } else if self.state.misread.is_some() {
                ui.colored_label(ui.visuals().error_fg_color, "saved changes cannot be read: see Problems");
            } else if !ready.unsuited.is_empty() {
                ui.colored_label(ui.visuals().error_fg_color, "changes do not suit: see Problems");
            } else if !ready.built.report.warnings.is_empty() {
                ui.colored_label(ui.visuals().warn_fg_color, "warnings: see Problems");
            }
            let buildings = ready.built.city.buildings.len();
            ui.weak(format!("{}: {buildings} buildings, {:.2} s", ready.built.city.name, ready.took.as_secs_f64()));
        }
        if !self.state.history.is_saved() {
            ui.label("changed");
            if ui.small_button("Save").clicked() {
                self.state.commands.push(Command::Save);
            }
        } else if !self.state.history.saved().is_empty() {
            ui.weak("saved").on_hover_text("The changes of the city lie beside its script");
        }
    }

    fn shortcuts(&mut self, ui: &Ui) {
        // Longer combinations first: without Shift they would be others.
        let mut all: Vec<Action> = Action::all().chain((0..DIGITS.len()).map(Action::GoTo)).collect();
        all.sort_by_key(|action| std::cmp::Reverse(action.shortcut().is_some_and(|keys| keys.modifiers.shift)));
        for action in all {
            let Some(keys) = action.shortcut() else { continue };
            // Several times where frames are slow.
            let count = |input: &mut egui::InputState| input.count_and_consume_key(keys.modifiers, keys.logical_key);
            for _ in 0..ui.ctx().input_mut(count) {
                if action.is_possible(&self.state) {
                    self.act(ui, action);
                }
            }
        }
    }

    /// Cities to choose from at the first start.
    fn start(&mut self, ui: &mut Ui) {
        ui.heading("Plat");
        ui.label("Grow, edit and build cities from rules. Drop a city's folder here, or choose one.");
        let shipped = shipped();
        if shipped.is_empty() {
            ui.label("The cities that come with Plat are not beside the program; `plat new city NAME` writes one to begin with.");
        }
        if ui.button("Open a city…").clicked() {
            self.ask_for_path(Asking::Open);
        }
        let recent = self.state.preferences.recent.clone();
        let name_of = |city: &Path| {
            let name = city.file_name().unwrap_or_default().to_string_lossy().replace('_', " ");
            let is_alone = recent.iter().filter(|other| other.file_name() == city.file_name()).count() < 2;
            let folder =
                city.parent().and_then(Path::file_name).filter(|_| !is_alone && recent.iter().any(|c| c == city));
            folder.map_or(name.clone(), |folder| format!("{name} in {}", folder.to_string_lossy()))
        };
        for (heading, cities) in [("Opened before", recent.clone()), ("Shipped with Plat", shipped)] {
            if !cities.is_empty() {
                ui.add_space(12.0);
                ui.strong(heading);
            }
            ui.horizontal_wrapped(|ui| {
                for city in cities {
                    let name = name_of(&city);
                    let button = match self.pictures.of(ui.ctx(), &city) {
                        Some(picture) => {
                            Button::image_and_text(Image::new(&picture).max_size([180.0, 120.0].into()), &name)
                        }
                        None => Button::new(&name),
                    };
                    let button = button.min_size([140.0, 44.0].into());
                    if ui.add(button).on_hover_text(city.display().to_string()).clicked() {
                        self.state.commands.push(Command::Open(city));
                    }
                }
            });
        }
    }
}

/// The cities that come with the program, where they lie beside it.
fn shipped() -> Vec<PathBuf> {
    let beside = std::env::current_exe().ok();
    let places = beside.iter().flat_map(|path| path.ancestors().map(Path::to_path_buf)).chain([PathBuf::from(".")]);
    let folder = places.map(|place| place.join("scripts")).find(|folder| folder.is_dir());
    let entries = folder.and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten().flatten();
    let mut cities: Vec<PathBuf> =
        entries.map(|entry| entry.path()).filter(|path| path.join("city.rhai").is_file()).collect();
    cities.sort();
    cities
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.ask_before_leaving();
        if let Some(soon) = self.state.catch_up() {
            ui.ctx().request_repaint_after(soon);
        }
        self.look_after_device(ui);
        self.shortcuts(ui);
        let dropped =
            ui.ctx().input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).next());
        self.state.commands.extend(dropped.map(Command::Open));
        let before = self.state.preferences.layers.clone();
        Panel::top("menus").show(ui, |ui| self.menus(ui));
        self.show_message(ui);
        self.show_recovery(ui);
        if self.state.city.is_none() {
            CentralPanel::default().show(ui, |ui| ScrollArea::vertical().show(ui, |ui| self.start(ui)));
        } else {
            let render = frame.wgpu_render_state();
            let mut docks = Docks { state: &mut self.state, render, changed: &mut self.docked };
            CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.docks.ui(&mut docks, ui));
        }
        self.remember_docks(ui);
        if ui.ctx().input(|input| input.pointer.any_released()) {
            self.state.commands.push(Command::LetGo);
        }
        self.state.tell_sight();
        self.show_palette(ui);
        self.show_path(ui);
        self.show_leaving(ui);
        if self.state.preferences.layers != before {
            self.state.remember();
        }
        let title = self.state.title();
        if title != self.title {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if self.state.commands.iter().any(|command| matches!(command, Command::ShowSource(_))) {
            self.bring_up(Pane::Source);
        }
        self.ask_before_leaving();
        if !self.state.commands.is_empty() {
            // Carried out at once, shown in the next frame.
            let _ = self.state.catch_up();
            ui.ctx().request_repaint();
        }
        self.leave();
    }
}
