//! What the tests have in common: windows without a screen, driven through the names that screen readers hear.

use city::{Cancel, Settings, Silent, build, load_as_written};
use eframe::egui::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use geom::{Digest, Id};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use viewer::app::App;
use viewer::state::Command;

/// Longest that anything may take.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// A copy of a shipped city, to be changed.
pub fn copy_of(name: &str, into: &Path) -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts").join(name);
    let to = into.join(name);
    copy(&from, &to);
    to
}

pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

pub fn window() -> Harness<'static, App> {
    window_of(None)
}

/// A window with preferences in a file.
pub fn window_of(preferences: Option<PathBuf>) -> Harness<'static, App> {
    Harness::builder()
        .with_size([1500.0, 1800.0])
        .with_max_steps(64)
        .build_eframe(|context| App::new(context, preferences, None))
}

/// Goes on until everything that was asked for is done.
pub fn settle(window: &mut Harness<App>) {
    let begin = Instant::now();
    loop {
        window.step();
        if window.state().state().is_idle() && window.state().state().commands.is_empty() {
            break;
        }
        assert!(begin.elapsed() < PATIENCE, "nothing came of it");
        std::thread::sleep(Duration::from_millis(5));
    }
    window.run_steps(3);
}

pub fn open(window: &mut Harness<App>, city: &Path) {
    window.state_mut().state_mut().commands.push(Command::Open(city.to_path_buf()));
    settle(window);
    let state = window.state().state();
    assert!(state.ready.is_some(), "{:?} {:?}", state.message, state.failure);
    // Presets are read on a thread of their own.
    wait_for(window, "presets", |app| !app.state().gallery.cards.is_empty());
}

pub fn click(window: &mut Harness<App>, label: &str) {
    window.get_by_label(label).click();
    settle(window);
}

pub fn type_into(window: &mut Harness<App>, field: &str, text: &str) {
    window.get_by_role_and_label(Role::TextInput, field).focus();
    window.run_steps(2);
    window.get_by_role_and_label(Role::TextInput, field).type_text(text);
    settle(window);
}

/// The digest of the layout that is shown, as the file would be.
pub fn shown(window: &Harness<App>) -> Id {
    let mut bytes = Vec::new();
    let ready = window.state().state().ready.clone().expect("a city");
    city::export::geojson::write_layout(&ready.built.city, &mut bytes).unwrap();
    Digest::new("layout").bytes(&bytes).finish()
}

/// That of the layout that a program without a window builds.
pub fn headless(city: &Path, arguments: &[String]) -> Id {
    let mut loaded = load_as_written(city, None).unwrap();
    for pair in arguments.chunks(2) {
        match (pair[0].as_str(), &pair[1]) {
            ("--preset", assignment) => loaded.lay(assignment).unwrap(),
            ("--set", assignment) => loaded.set(assignment).unwrap(),
            (_, seed) => loaded.plan.seed = seed.parse().unwrap(),
        }
    }
    built(&loaded)
}

pub fn built(loaded: &city::Loaded) -> Id {
    let sources = loaded.read().unwrap();
    let built = build(&sources, Settings::default(), &Silent, &Cancel::default()).unwrap();
    let mut bytes = Vec::new();
    city::export::geojson::write_layout(&built.city, &mut bytes).unwrap();
    Digest::new("layout").bytes(&bytes).finish()
}

/// Goes on until something holds.
pub fn wait_for(window: &mut Harness<App>, what: &str, until: impl Fn(&App) -> bool) {
    let begin = Instant::now();
    while !until(window.state()) {
        window.step();
        assert!(begin.elapsed() < PATIENCE, "{what}: nothing came of it");
        std::thread::sleep(Duration::from_millis(5));
    }
    window.run_steps(3);
}

/// Shows a pane, by its tab.
pub fn tab(window: &mut Harness<App>, name: &str) {
    window.get_all_by_label_contains(name).next().expect("a tab").click();
    settle(window);
}
