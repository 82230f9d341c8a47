//! The panels, driven through the names that screen readers hear.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use city::{Cancel, Changes, Settings, Silent, build, load, load_as_written};
use eframe::egui::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use geom::{Digest, Id};
use script::PresetTarget;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use viewer::app::App;
use viewer::scene::{Element, ElementKind};
use viewer::state::Command;

/// Longest that anything may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// A copy of a shipped city, to be changed.
fn copy_of(name: &str, into: &Path) -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts").join(name);
    let to = into.join(name);
    copy(&from, &to);
    to
}

fn copy(from: &Path, to: &Path) {
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

fn window() -> Harness<'static, App> {
    Harness::builder()
        .with_size([1500.0, 1800.0])
        .with_max_steps(64)
        .build_eframe(|context| App::new(context, None, None))
}

/// Goes on until everything that was asked for is done.
fn settle(window: &mut Harness<App>) {
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

fn open(window: &mut Harness<App>, city: &Path) {
    window.state_mut().state_mut().commands.push(Command::Open(city.to_path_buf()));
    settle(window);
    let state = window.state().state();
    assert!(state.ready.is_some(), "{:?} {:?}", state.message, state.failure);
}

fn click(window: &mut Harness<App>, label: &str) {
    window.get_by_label(label).click();
    settle(window);
}

fn type_into(window: &mut Harness<App>, field: &str, text: &str) {
    window.get_by_role_and_label(Role::TextInput, field).focus();
    window.run_steps(2);
    window.get_by_role_and_label(Role::TextInput, field).type_text(text);
    settle(window);
}

/// The digest of the layout that is shown, as the file would be.
fn shown(window: &Harness<App>) -> Id {
    let mut bytes = Vec::new();
    let ready = window.state().state().ready.clone().expect("a city");
    city::export::geojson::write_layout(&ready.built.city, &mut bytes).unwrap();
    Digest::new("layout").bytes(&bytes).finish()
}

/// That of the layout that a program without a window builds.
fn headless(city: &Path, arguments: &[String]) -> Id {
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

fn built(loaded: &city::Loaded) -> Id {
    let sources = loaded.read().unwrap();
    let built = build(&sources, Settings::default(), &Silent, &Cancel::default()).unwrap();
    let mut bytes = Vec::new();
    city::export::geojson::write_layout(&built.city, &mut bytes).unwrap();
    Digest::new("layout").bytes(&bytes).finish()
}

#[test]
fn a_city_is_changed_undone_saved_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    open(&mut window, &city);
    let at_first = shown(&window);
    assert_eq!(at_first, headless(&city, &[]));

    // A preset on one quarter, picked from the gallery.
    let quarter = window.state().state().ready.as_ref().unwrap().built.city.quarters[0].id;
    let element = Element { kind: ElementKind::Quarter, id: quarter };
    window.state_mut().state_mut().commands.push(Command::Select(Some(element)));
    settle(&mut window);
    click(&mut window, "Presets");
    type_into(&mut window, "Find a preset", "village");
    click(&mut window, "Lay Village");
    let with_preset = shown(&window);
    assert_ne!(with_preset, at_first);

    // A parameter, by its own widget.
    click(&mut window, "Parameters");
    let address = {
        let state = window.state().state();
        let plan = &state.ready.as_ref().unwrap().sources.plan;
        let parameters = plan.parameters();
        let found = parameters
            .iter()
            .find(|p| matches!(p.param.domain, script::Domain::Number { .. }) && p.address.starts_with("minors"));
        found.or(parameters.first()).expect("a parameter").address.clone()
    };
    let slider = window.get_by_role_and_label(Role::Slider, &address);
    slider.focus();
    window.run_steps(2);
    window.key_press(eframe::egui::Key::ArrowRight);
    settle(&mut window);
    let changed = shown(&window);
    let value = window.state().state().history.now().value(&address).map(str::to_owned);
    assert!(value.is_some(), "{address} was turned");
    assert_ne!(changed, with_preset);

    click(&mut window, &format!("Reset {address}"));
    assert_eq!(shown(&window), with_preset);
    window.key_press_modifiers(eframe::egui::Modifiers::COMMAND, eframe::egui::Key::Z);
    settle(&mut window);
    assert_eq!(shown(&window), changed);
    window.key_press_modifiers(
        eframe::egui::Modifiers::COMMAND.plus(eframe::egui::Modifiers::SHIFT),
        eframe::egui::Key::Z,
    );
    settle(&mut window);
    assert_eq!(shown(&window), with_preset);
    window.key_press_modifiers(eframe::egui::Modifiers::COMMAND, eframe::egui::Key::Z);
    settle(&mut window);

    window.key_press_modifiers(eframe::egui::Modifiers::COMMAND, eframe::egui::Key::S);
    settle(&mut window);
    assert!(window.state().state().history.is_saved());
    let script = city.join("city.rhai");
    let text = fs::read_to_string(Changes::file_of(&script)).unwrap();
    assert!(text.contains(&format!("preset quarter:{quarter}=village\n")), "{text}");
    assert!(text.contains(&format!("set {address}={}  # was ", value.unwrap())), "{text}");

    // What is saved builds the same city, as arguments and by itself.
    let arguments = Changes::saved(&script).unwrap().arguments();
    assert_eq!(headless(&city, &arguments), changed);
    assert_eq!(built(&load(&city, None).unwrap()), changed);
    let mut again = self::window();
    open(&mut again, &city);
    assert_eq!(shown(&again), changed);
}

#[test]
fn a_broken_rule_is_told_and_keeps_the_city() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    open(&mut window, &city);
    let before = shown(&window);
    let script = city.join("city.rhai");
    let text = fs::read_to_string(&script).unwrap();
    let wait_for = |window: &mut Harness<App>, until: &dyn Fn(&App) -> bool| {
        let begin = Instant::now();
        while !until(window.state()) {
            window.step();
            assert!(begin.elapsed() < PATIENCE, "the change was not heard of");
            std::thread::sleep(Duration::from_millis(5));
        }
        window.run_steps(3);
    };
    fs::write(&script, format!("{text}\nlet broken = ;\n")).unwrap();
    wait_for(&mut window, &|app| app.state().failure.is_some());
    assert_eq!(shown(&window), before);
    window.get_by_label("Problems (1)").click();
    window.run_steps(3);
    assert!(window.query_by_label_contains("The last change does not build").is_some());
    let line = text.lines().count() + 2;
    assert!(window.query_by_label_contains(&format!("city.rhai:{line}:")).is_some(), "the place is told");
    fs::write(&script, &text).unwrap();
    wait_for(&mut window, &|app| app.state().failure.is_none());
    assert_eq!(shown(&window), before);
}

#[test]
fn what_is_picked_tells_its_measures_and_why_it_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    open(&mut window, &city);
    let built = window.state().state().ready.as_ref().unwrap().built.city.clone();
    let elements = [
        (ElementKind::Street, built.runs.iter().find(|run| run.class.0 > 0).map(|run| run.id)),
        (ElementKind::Building, built.buildings.first().map(|building| building.id)),
        (ElementKind::Parcel, built.parcels.first().map(|parcel| parcel.id)),
        (ElementKind::Block, built.blocks.first().map(|block| block.id)),
        (ElementKind::Quarter, built.quarters.first().map(|quarter| quarter.id)),
    ];
    for (kind, id) in elements {
        let id = id.expect("one of each");
        window.state_mut().state_mut().commands.push(Command::Select(Some(Element { kind, id })));
        settle(&mut window);
        assert!(window.query_by_label(&id.to_string()).is_some(), "{kind:?}");
        click(&mut window, "Why is this here?");
        let answer = window.state().state().asked.answer.as_ref().expect("an answer");
        let text = answer.as_ref().unwrap_or_else(|error| panic!("{kind:?}: {error}")).to_string();
        assert!(text.contains(kind.name()), "{text}");
    }
}

#[test]
fn every_control_has_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    window.run_steps(2);
    open(&mut window, &city);
    for tab in ["Presets", "Parameters", "Layers", "Inspector", "Statistics", "Problems"] {
        click(&mut window, tab);
        let controls = [Role::Button, Role::CheckBox, Role::Slider, Role::ComboBox, Role::TextInput, Role::SpinButton];
        for role in controls {
            for node in window.query_all_by_role(role) {
                let node = node.accesskit_node();
                let name = node.label().or_else(|| node.value()).unwrap_or_default();
                assert!(!name.trim().is_empty(), "a {role:?} in {tab} has no name");
            }
        }
    }
}

#[test]
fn what_cannot_be_opened_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window();
    window.state_mut().state_mut().commands.push(Command::Open(folder.path().join("nowhere")));
    settle(&mut window);
    assert!(window.query_by_label_contains("there is no city.rhai here").is_some());
    fs::write(folder.path().join("city.rhai"), "city(#{").unwrap();
    window.state_mut().state_mut().commands.push(Command::Open(folder.path().to_path_buf()));
    settle(&mut window);
    let state = window.state().state();
    assert!(state.ready.is_none() && state.failure.as_ref().is_some_and(|failure| failure.faults.len() == 1));
}

#[test]
fn changes_that_cannot_be_saved_stay() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    open(&mut window, &city);
    window.state_mut().state_mut().commands.push(Command::Seed(Some(77)));
    settle(&mut window);
    // A folder in the way, which holds for root, too.
    fs::create_dir_all(Changes::file_of(&city.join("city.rhai")).join("in the way")).unwrap();
    window.state_mut().state_mut().commands.push(Command::Save);
    settle(&mut window);
    let state = window.state().state();
    assert!(!state.history.is_saved() && state.history.now().seed == Some(77));
    assert!(state.message.as_ref().is_some_and(|message| message.contains("still here")), "{:?}", state.message);
    let target = PresetTarget::City;
    assert_eq!(state.target, target);
}

#[test]
fn growth_is_shown_step_by_step() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    open(&mut window, &city);
    click(&mut window, "Timeline");
    window.state_mut().state_mut().timeline.go(0);
    settle(&mut window);
    let moment = |window: &Harness<App>| window.state().state().timeline.moment.clone().expect("a step");
    let start = moment(&window);
    assert_eq!(start.step, 0);
    let slider = window.get_by_role_and_label(Role::Slider, "Step");
    slider.focus();
    window.run_steps(2);
    window.key_press(eframe::egui::Key::ArrowRight);
    settle(&mut window);
    let next = moment(&window);
    assert!(next.step > 0 && next.kilometres > start.kilometres, "{} {}", next.step, next.kilometres);
    window.state_mut().state_mut().timeline.go(next.last);
    settle(&mut window);
    let metres: f64 = window.state().state().ready.as_ref().unwrap().built.report.street_metres.values().sum();
    assert!((moment(&window).kilometres - metres / 1000.0).abs() < 1e-6, "all of it has grown");
    click(&mut window, "Finished city");
    assert!(window.state().state().timeline.moment.is_none());
}

#[test]
fn what_is_in_force_is_saved_as_a_preset() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    open(&mut window, &city);
    click(&mut window, "Presets");
    assert!(window.query_by_label("Lay My own").is_none());
    type_into(&mut window, "Find a preset", "my own");
    type_into(&mut window, "Save what is here as", "my_own");
    click(&mut window, "Save as preset");
    let begin = Instant::now();
    while window.query_by_label("Lay My own").is_none() {
        assert!(begin.elapsed() < PATIENCE, "{:?}", window.state().state().message);
        window.step();
        std::thread::sleep(Duration::from_millis(5));
    }
    let before = shown(&window);
    click(&mut window, "Lay My own");
    assert_eq!(shown(&window), before, "it says what was in force");
}

#[test]
fn windows_of_any_size_show_all_panels() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("krems", folder.path());
    for (size, scale) in
        [([120.0, 90.0], 1.0), ([3840.0, 2160.0], 1.0), ([1920.0, 1080.0], 2.0), ([400.0, 2000.0], 0.5)]
    {
        let builder = Harness::builder().with_size(size).with_pixels_per_point(scale);
        let mut window: Harness<App> = builder.build_eframe(|context| App::new(context, None, None));
        open(&mut window, &city);
        for pane in viewer::panels::Pane::PANELS {
            window.state_mut().bring_up(pane);
            settle(&mut window);
        }
    }
}
