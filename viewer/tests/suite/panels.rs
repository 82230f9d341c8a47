//! The panels, driven through the names that screen readers hear.

use crate::desk::*;
use city::{Changes, load};
use eframe::egui::{Key, Modifiers, Role};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use script::PresetTarget;
use std::fs;
use std::time::{Duration, Instant};
use viewer::app::App;
use viewer::panels::parameters::has_slider;
use viewer::scene::{Element, ElementKind, LayerKind};
use viewer::state::Command;

/// A copy of a shipped city, open in a window; the folder goes with what is returned first.
fn opened(name: &str) -> (tempfile::TempDir, std::path::PathBuf, Harness<'static, App>) {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of(name, folder.path());
    let mut window = window();
    open(&mut window, &city);
    (folder, city, window)
}

/// Breaks a city's script, and waits until that is told. Returns the script, and its text as it was.
fn break_script(window: &mut Harness<App>, city: &std::path::Path) -> (std::path::PathBuf, String) {
    let script = city.join("city.rhai");
    let text = fs::read_to_string(&script).unwrap();
    fs::write(&script, format!("{text}\nlet broken = ;\n")).unwrap();
    wait_for(window, "a broken script", |app| app.state().failure.is_some());
    (script, text)
}

#[test]
fn a_city_is_changed_undone_saved_and_opened_again() {
    let (_folder, city, mut window) = opened("lattice");
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
    window.key_press(Key::ArrowRight);
    settle(&mut window);
    let changed = shown(&window);
    let value = window.state().state().history.now().value(&address).map(str::to_owned);
    assert!(value.is_some(), "{address} was turned");
    assert_ne!(changed, with_preset);

    click(&mut window, &format!("Reset {address}"));
    assert_eq!(shown(&window), with_preset);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(shown(&window), changed);
    window.key_press_modifiers(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
    settle(&mut window);
    assert_eq!(shown(&window), with_preset);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);

    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
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
    let (_folder, city, mut window) = opened("lattice");
    let before = shown(&window);
    let (script, text) = break_script(&mut window, &city);
    assert_eq!(shown(&window), before);
    window.get_by_label("Problems (1)").click();
    window.run_steps(3);
    assert!(window.query_by_label_contains("The last change does not build").is_some());
    let line = text.lines().count() + 2;
    assert!(window.query_by_label_contains(&format!("city.rhai:{line}:")).is_some(), "the place is told");
    fs::write(&script, &text).unwrap();
    wait_for(&mut window, "a mended script", |app| app.state().failure.is_none());
    assert_eq!(shown(&window), before);
}

#[test]
fn what_is_picked_tells_its_measures_and_why_it_is_there() {
    let (_folder, _, mut window) = opened("lattice");
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
        let answer = window.state().state().asked.done.as_ref().expect("an answer");
        let text = answer.as_ref().unwrap_or_else(|error| panic!("{kind:?}: {error}")).to_string();
        assert!(text.contains(kind.name()), "{text}");
    }
    // A step of a rule leads to its line.
    let building = built.buildings.first().expect("one").id;
    let element = Element { kind: ElementKind::Building, id: building };
    window.state_mut().state_mut().commands.push(Command::Select(Some(element)));
    settle(&mut window);
    click(&mut window, "Why is this here?");
    let answer = window.state().state().asked.done.clone().expect("an answer").expect("it is there");
    let decision = answer.decisions.first().expect("its rule was asked");
    let step = &decision.steps[0];
    assert!(window.query_by_label_contains(&step.told).is_some() && step.text == "shape.area", "{step:?}");
    let link = format!("{}:{}", decision.file, step.line);
    window.query_all_by_label(&link).next().expect("a link").click();
    settle(&mut window);
    let shown = window.state().state().source.clone().expect("its text is shown");
    assert_eq!((shown.file, shown.line), (decision.file.clone(), step.line));
}

#[test]
fn every_control_has_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut window = window();
    window.run_steps(2);
    open(&mut window, &city);
    for pane in viewer::panels::Pane::PANELS {
        let tab = pane.name();
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
    let (_folder, city, mut window) = opened("lattice");
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
    let (_folder, _, mut window) = opened("lattice");
    click(&mut window, "Timeline");
    window.state_mut().state_mut().timeline.go(0);
    settle(&mut window);
    let moment = |window: &Harness<App>| window.state().state().timeline.moment.clone().expect("a step");
    let start = moment(&window);
    assert_eq!(start.step, 0);
    let slider = window.get_by_role_and_label(Role::Slider, "Step");
    slider.focus();
    window.run_steps(2);
    window.key_press(Key::ArrowRight);
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
    let (_folder, _, mut window) = opened("lattice");
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

#[test]
fn layers_are_switched_on_and_off_and_views_are_kept() {
    let (_folder, _, mut window) = opened("lattice");
    click(&mut window, "Layers");
    for layer in LayerKind::ALL {
        let has = |window: &Harness<App>| window.state().state().preferences.layers.map.contains(&layer);
        let before = has(&window);
        window.get_by_role_and_label(Role::CheckBox, layer.name()).click();
        settle(&mut window);
        assert_ne!(has(&window), before, "{layer:?}");
    }
    for (i, (_, name)) in viewer::shown::MODEL_PARTS.iter().enumerate() {
        click(&mut window, name);
        assert!(!window.state().state().preferences.layers.model[i], "{name}");
    }
    click(&mut window, "Marks and faults of rules");
    assert!(!window.state().state().preferences.layers.marks);
    click(&mut window, "Streets");
    click(&mut window, "minor streets");
    click(&mut window, "Water");
    click(&mut window, "Parks of the site");
    click(&mut window, "Land");
    let layers = window.state().state().preferences.layers.clone();
    assert!(!layers.ground && !layers.water && !layers.parks && layers.classes_off.contains("minor"), "{layers:?}");
    click(&mut window, "Shadows");
    assert!(!window.state().state().views.look.shadows);

    // A view that was kept is where one looked from.
    let there = window.state().state().views.map.camera;
    type_into(&mut window, "Keep this view as", "Here");
    click(&mut window, "Keep view");
    window.state_mut().state_mut().views.map.camera.scale *= 3.0;
    window.key_press_modifiers(Modifiers::COMMAND, Key::Num1);
    settle(&mut window);
    assert_eq!(window.state().state().views.map.camera, there);
    window.key_press_modifiers(Modifiers::COMMAND, Key::K);
    settle(&mut window);
    assert_eq!(window.state().state().bookmarks().last().map(|view| &view.name[..]), Some("View 1"));
    click(&mut window, "Forget View 1");
    // Panels come up by keys.
    window.key_press(Key::F11);
    settle(&mut window);
    assert!(window.query_by_role_and_label(Role::Button, "Run").is_some());
    click(&mut window, "Forget Here");
    assert!(window.state().state().bookmarks().is_empty());
}

#[test]
fn streets_are_shown_in_the_order_they_grew() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let Ok(gpu) = viewer::render::Gpu::headless() else { return println!("SKIPPED: no graphics adapter") };
    let wake: viewer::worker::Wake = std::sync::Arc::new(|| {});
    let mut state = viewer::state::State::new(Some(gpu), None, None, wake);
    state.carry_out(Command::Open(city));
    let begin = Instant::now();
    state.by_growth = true;
    while state.growth.done.is_none() {
        let _ = state.catch_up();
        assert!(begin.elapsed() < PATIENCE, "{:?} {:?}", state.message, state.failure);
        std::thread::sleep(Duration::from_millis(5));
    }
    let map = state.growth.done.as_ref().unwrap().as_ref().unwrap();
    let names: Vec<&str> = map.legend.iter().map(|(name, _)| &name[..]).collect();
    assert_eq!(names.first().map(|name| name.starts_with("steps 1 – ")), Some(true), "{names:?}");
    assert_eq!(names.last(), Some(&"given"));
}

#[test]
fn figures_stand_beside_those_of_the_real_place() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let ranges = r#"{ "lattice": { "whole": { "order": [0, 1], "segment_median": [1, 2] } } }"#;
    fs::write(city.join("ranges.json"), ranges).unwrap();
    let mut window = window();
    open(&mut window, &city);
    click(&mut window, "Statistics");
    wait_for(&mut window, "measures", |app| app.state().statistics.done.is_some());
    let statistics = window.state().state().statistics.done.clone().unwrap().unwrap();
    let order = match statistics.figures.get("order").unwrap() {
        city::measure::Figure::Number(number) => format!("{number:.3}"),
        other => panic!("{other:?}"),
    };
    assert!(window.query_all_by_label(&order).next().is_some(), "{order}");
    assert!(window.query_by_label("1 of 2 as in lattice").is_some());
    assert!(window.query_by_label("1 to 2, off").is_some() && window.query_by_label("0 to 1").is_some());

    // A broken file of ranges is told, and the counts stay.
    fs::write(city.join("ranges.json"), "{").unwrap();
    window.state_mut().state_mut().commands.push(Command::Measure);
    settle(&mut window);
    // The file lies in a folder that is watched, so that the city may just be built, and measured, once more.
    let begin = Instant::now();
    while window.query_by_label_contains("ranges.json").is_none() {
        assert!(begin.elapsed() < PATIENCE, "nothing is told");
        settle(&mut window);
    }
    assert!(window.query_by_label("buildings").is_some());
}

#[test]
fn the_console_answers_about_the_open_city_and_what_is_picked() {
    let (_folder, _, mut window) = opened("lattice");
    let parcel = window.state().state().ready.as_ref().unwrap().built.city.parcels[0].clone();
    let picked = Element { kind: ElementKind::Parcel, id: parcel.id };
    window.state_mut().state_mut().commands.push(Command::Select(Some(picked)));
    settle(&mut window);
    click(&mut window, "Console");
    let mut ask = |text: &str| {
        type_into(&mut window, "Rhai", text);
        click(&mut window, "Run");
        window.state().state().console.entries.last().cloned().expect("an answer")
    };
    let value = |entry: &viewer::console::Entry| entry.value.clone().unwrap_or_else(|| panic!("{:?}", entry.fault));
    let parcels = window_count(&value(&ask("city.parcels().len()")));
    assert!(parcels > 1, "{parcels}");
    let area: f64 = value(&ask("picked.area")).parse().unwrap();
    assert!((area - parcel.polygon.area()).abs() < 0.1, "{area}");
    // Values and functions stay; what is wrong has its place and leaves nothing behind.
    assert_eq!(ask("let big = city.parcels().filter(|p| p.area > 1.0)").value, None);
    assert_eq!(value(&ask("big.len()")), parcels.to_string());
    assert_eq!(ask("fn twice(x) { x * 2 }").value, None);
    assert_eq!(value(&ask("print(\"said\"); twice(21)")), "42");
    let wrong = ask("let x = 1; nonsense(x)").fault.expect("a fault");
    assert_eq!((wrong.line, wrong.column), (1, 12), "{wrong:?}");
    assert!(ask("city.oder").fault.is_some_and(|fault| fault.hint.is_some_and(|hint| hint.contains("order"))));
    assert!(ask("let n = 0; while true { n += 1 }").fault.is_some(), "it ends");
    assert_eq!(value(&ask("rule(\"streets/grid\").propose(#{ heading: 0 }).len() > 0")), "true");
}

fn window_count(text: &str) -> usize {
    text.parse().unwrap()
}

#[test]
fn the_place_of_a_fault_is_shown_in_the_text() {
    let (_folder, city, mut window) = opened("lattice");
    let (_, text) = break_script(&mut window, &city);
    window.get_by_label("Problems (1)").click();
    window.run_steps(3);
    let line = text.lines().count() + 2;
    window.get_by_label_contains(&format!("city.rhai:{line}:")).click();
    settle(&mut window);
    click(&mut window, "Source");
    assert!(window.query_by_label_contains("let broken = ;").is_some());
    // Where no editor can be started, that is told.
    window.state_mut().state_mut().preferences.editor = "no-such-editor".into();
    click(&mut window, "Open in editor");
    assert!(window.query_by_label_contains("no-such-editor").is_some());
}

#[test]
fn changes_that_were_not_saved_are_taken_up_again() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let preferences = folder.path().join("config/viewer.json");
    let start = || {
        let file = preferences.clone();
        Harness::builder().with_size([1500.0, 1800.0]).build_eframe(move |context| App::new(context, Some(file), None))
    };
    let mut first = start();
    open(&mut first, &city);
    first.state_mut().state_mut().commands.push(Command::Seed(Some(77)));
    settle(&mut first);
    let changed = shown(&first);
    // The program ends without a word.
    drop(first);
    let mut second = start();
    open(&mut second, &city);
    assert_ne!(shown(&second), changed);
    click(&mut second, "Take them up");
    assert_eq!(shown(&second), changed);
    second.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut second);
    drop(second);
    // What is saved is not offered again.
    let mut third = start();
    open(&mut third, &city);
    assert_eq!(shown(&third), changed);
    assert!(third.query_by_label("Take them up").is_none());
    third.state_mut().state_mut().commands.push(Command::Seed(Some(78)));
    settle(&mut third);
    drop(third);
    let mut fourth = start();
    open(&mut fourth, &city);
    click(&mut fourth, "Forget them");
    assert_eq!(shown(&fourth), changed);
    drop(fourth);
    let mut fifth = start();
    open(&mut fifth, &city);
    assert!(fifth.query_by_label("Take them up").is_none());
}

#[test]
fn another_window_goes_on_where_one_ended() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let mut first = window();
    open(&mut first, &city);
    first.state_mut().state_mut().commands.push(Command::Seed(Some(5)));
    settle(&mut first);
    first.state_mut().state_mut().views.map.camera.scale *= 0.5;
    let (changed, history) = (shown(&first), first.state().state().history.clone());
    let views = first.state().state().views.bookmark("");
    drop(first);
    let mut second = window();
    second.state_mut().state_mut().take_over(&city, history, views.clone());
    settle(&mut second);
    assert_eq!(shown(&second), changed);
    assert_eq!(second.state().state().views.map.camera, views.map);
    assert_eq!(second.state().state().history.to_undo(), Some("seed"), "what was done can be undone");
}

#[test]
fn what_somebody_else_saved_is_not_written_over_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let file = city.join("city.changes");
    let mut window = window();
    open(&mut window, &city);
    window.state_mut().state_mut().commands.push(Command::Seed(Some(7)));
    settle(&mut window);
    let mut other = Changes::default();
    other.seed = Some(55);
    fs::write(&file, other.plain()).unwrap();
    let save = |window: &mut Harness<App>| {
        window.state_mut().state_mut().commands.push(Command::Save);
        settle(window);
        Changes::read(&file).unwrap().unwrap().seed
    };
    assert_eq!(save(&mut window), Some(55));
    let told = window.state().state().message.clone().unwrap_or_default();
    assert!(told.contains("something else wrote city.changes"), "{told}");
    assert!(!window.state().state().history.is_saved());
    fs::write(&file, "seed of another kind").unwrap();
    window.state_mut().state_mut().commands.push(Command::Save);
    settle(&mut window);
    assert_eq!(fs::read_to_string(&file).unwrap(), "seed of another kind", "it changed again");
    assert_eq!(save(&mut window), Some(7), "told once, it is written over");
    assert!(window.state().state().history.is_saved());
}

#[test]
fn panels_stay_where_they_were_put() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let file = folder.path().join("viewer.json");
    let is_shown = |window: &Harness<App>| window.query_by_role_and_label(Role::Button, "Run").is_some();
    let mut first = window_of(Some(file.clone()));
    open(&mut first, &city);
    assert!(!is_shown(&first));
    click(&mut first, "Console");
    assert!(is_shown(&first));
    drop(first);
    let mut second = window_of(Some(file.clone()));
    open(&mut second, &city);
    assert!(is_shown(&second), "{}", fs::read_to_string(&file).unwrap());
    second.key_press_modifiers(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::P);
    settle(&mut second);
    type_into(&mut second, "All that can be done", "panels back");
    second.key_press(Key::Enter);
    settle(&mut second);
    assert!(!is_shown(&second));
    drop(second);
    let mut third = window_of(Some(file));
    open(&mut third, &city);
    assert!(!is_shown(&third));
}

#[test]
fn the_loss_of_a_device_is_heard_and_ends_nothing() {
    let Ok(gpu) = viewer::render::Gpu::headless() else { return println!("SKIPPED: no graphics adapter") };
    let lost = viewer::lost::Lost::of(&gpu, std::sync::Arc::new(|| {}));
    assert!(!lost.is_lost());
    gpu.device.destroy();
    // What is asked of it now fails without ending the program.
    let target = viewer::render::Target::new(&gpu, [64, 64]);
    drop(target);
    assert!(lost.is_lost() && lost.told().is_some());
}

#[test]
fn presets_are_found_by_the_kinds_of_rules_they_have() {
    let (_folder, city, mut window) = opened("lattice");
    click(&mut window, "Presets");
    fs::create_dir_all(city.join("presets")).unwrap();
    let only_streets = "//! Streets alone.\npreset(#{ pattern: rule(\"streets/grid\") });\n";
    fs::write(city.join("presets/only_streets.rhai"), only_streets).unwrap();
    wait_for(&mut window, "another preset", |app| app.state().gallery.cards.contains_key("presets/only_streets"));
    settle(&mut window);
    let buildings = window.get_by_label("Presets: Buildings");
    buildings.click();
    settle(&mut window);
    type_into(&mut window, "Find a preset", "only");
    assert!(window.query_by_label("Lay Only streets").is_none());
    click(&mut window, "Presets: Streets");
    assert!(window.query_by_label("Lay Only streets").is_some());
}

/// The number a slider stands at.
fn standing(window: &Harness<App>, address: &str) -> f64 {
    let slider = window.get_by_role_and_label(Role::Slider, address);
    slider.accesskit_node().numeric_value().expect("a number")
}

/// The first parameter of streets that is a number, and its slider.
fn a_number(window: &Harness<App>) -> String {
    let plan = &window.state().state().ready.as_ref().unwrap().sources.plan;
    let is_number =
        |p: &script::RoleParam| matches!(p.param.domain, script::Domain::Number { .. }) && has_slider(&p.param.domain);
    plan.parameters().into_iter().find(is_number).expect("a number").address
}

#[test]
fn a_slider_that_is_dragged_is_one_step_to_undo() {
    let (_folder, _, mut window) = opened("lattice");
    let at_first = shown(&window);
    click(&mut window, "Parameters");
    let address = a_number(&window);
    let (before, rect) = (standing(&window, &address), window.get_by_role_and_label(Role::Slider, &address).rect());
    let at = |share: f32| eframe::egui::pos2(rect.left() + rect.width() * share, rect.center().y);
    window.drag_at(at(0.3));
    window.run_steps(2);
    for i in 0..6 {
        window.hover_at(at(0.35 + 0.05 * i as f32));
        settle(&mut window);
    }
    window.drop_at(at(0.62));
    settle(&mut window);
    let after = standing(&window, &address);
    let state = window.state().state();
    assert!(after != before && state.history.now().value(&address).is_some(), "{before} {after}");
    assert!(shown(&window) != at_first);
    click(&mut window, &format!("Reset {address}"));
    for expected in [after, before] {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut window);
        assert_eq!(standing(&window, &address), expected);
    }
    assert_eq!(window.state().state().history.to_undo(), None);
    assert_eq!(shown(&window), at_first);
}

#[test]
fn parameters_show_what_is_asked_for_while_nothing_can_be_built() {
    let (_folder, city, mut window) = opened("lattice");
    let at_first = shown(&window);
    click(&mut window, "Parameters");
    let address = a_number(&window);
    let before = standing(&window, &address);
    let (script, text) = break_script(&mut window, &city);
    let set = Command::Set { address: address.clone(), value: (before + 1.5).to_string(), turning: false };
    window.state_mut().state_mut().commands.push(set);
    settle(&mut window);
    assert_eq!(standing(&window, &address), before + 1.5);
    assert!(window.query_by_label(&format!("Reset {address}")).is_some());
    assert_eq!(shown(&window), at_first, "the last good city stays");
    fs::write(&script, &text).unwrap();
    wait_for(&mut window, "a mended script", |app| app.state().failure.is_none());
    settle(&mut window);
    assert_eq!((standing(&window, &address), shown(&window) != at_first), (before + 1.5, true));
}

#[test]
fn the_palette_is_gone_through_by_keys() {
    let (_folder, _, mut window) = opened("lattice");
    let is_shown = |window: &Harness<App>| window.query_by_role_and_label(Role::Button, "Run").is_some();
    let open_palette = |window: &mut Harness<App>| {
        window.key_press_modifiers(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::P);
        settle(window);
        // All actions whose names hold these letters; Console is the second.
        type_into(window, "All that can be done", "so");
    };
    open_palette(&mut window);
    window.key_press(Key::ArrowDown);
    window.key_press(Key::ArrowDown);
    window.key_press(Key::ArrowUp);
    settle(&mut window);
    assert!(!is_shown(&window));
    window.key_press(Key::Enter);
    settle(&mut window);
    assert!(is_shown(&window));
    assert!(window.query_by_label("All that can be done").is_none(), "it is closed");
    // Below the last there is nothing, and what does not exist cannot be done.
    open_palette(&mut window);
    for _ in 0..40 {
        window.key_press(Key::ArrowDown);
    }
    type_into(&mut window, "All that can be done", "nothing of the kind");
    assert!(window.query_by_label_contains("Nothing of that name").is_some());
    window.key_press(Key::Enter);
    window.key_press(Key::Escape);
    settle(&mut window);
    assert!(window.query_by_label("All that can be done").is_none());
}

#[test]
fn a_copy_of_the_city_takes_the_changes_along_and_can_be_undone_there() {
    let folder = tempfile::tempdir().unwrap();
    let city = copy_of("lattice", folder.path());
    let preferences = folder.path().join("config/viewer.json");
    let mut window = window_of(Some(preferences.clone()));
    open(&mut window, &city);
    let at_first = shown(&window);
    window.state_mut().state_mut().commands.push(Command::Seed(Some(77)));
    settle(&mut window);
    let changed = shown(&window);
    let taken = Command::SaveCopy(city.join("inside"));
    window.state_mut().state_mut().commands.push(taken);
    settle(&mut window);
    assert!(window.query_by_label_contains("in the city itself").is_some());
    assert!(!window.state().state().history.is_saved());
    let copy = folder.path().join("copies/mine");
    window.state_mut().state_mut().commands.push(Command::SaveCopy(copy.clone()));
    settle(&mut window);
    assert!(window.query_by_label_contains("that city is open now").is_some());
    let state = window.state().state();
    assert!(state.history.is_saved() && state.city.as_ref() == Some(&copy));
    assert_eq!((shown(&window), built(&load(&copy, None).unwrap())), (changed, changed));
    assert_eq!(built(&load(&city, None).unwrap()), at_first, "the city itself is as it was");
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(shown(&window), at_first);
    drop(window);
    let mut again = window_of(Some(preferences));
    open(&mut again, &city);
    assert!(again.query_by_label("Take them up").is_none(), "they are saved in the copy");
}

#[test]
fn a_rule_of_the_library_becomes_the_citys_own_to_be_changed() {
    let (_folder, city, mut window) = opened("lattice");
    let at_first = shown(&window);
    let building = window.state().state().ready.as_ref().unwrap().built.city.buildings[0].id;
    let element = Element { kind: ElementKind::Building, id: building };
    window.state_mut().state_mut().commands.extend([Command::Select(Some(element)), Command::Ask]);
    settle(&mut window);
    tab(&mut window, "Inspector");
    click(&mut window, "Text of buildings/extruded");
    tab(&mut window, "Source");
    click(&mut window, "Change it for this city");
    let own = city.join("buildings/extruded.rhai");
    assert!(window.query_by_label_contains("a rule of its own now").is_some());
    wait_for(&mut window, "the own rule", |app| {
        app.state().ready.as_ref().is_some_and(|ready| ready.as_written.texts.get(&own.to_string_lossy()).is_some())
    });
    settle(&mut window);
    assert_eq!(shown(&window), at_first, "it says the same");
    assert!(window.query_by_label("Change it for this city").is_none());
    let text = fs::read_to_string(&own).unwrap();
    fs::write(
        &own,
        text.replacen(
            "fn build(shape, p) {",
            "fn build(shape, p) { if shape.chance(9) < 0.5 { return shape.none(); }",
            1,
        ),
    )
    .unwrap();
    wait_for(&mut window, "another city", |app| {
        let ready = app.state().ready.as_ref().unwrap();
        app.state().failure.is_some()
            || ready.as_written.texts.get(&own.to_string_lossy()).is_some_and(|now| *now != *text)
    });
    settle(&mut window);
    assert!(window.state().state().failure.is_none(), "{:?}", window.state().state().failure);
    assert_ne!(shown(&window), at_first);
}

#[test]
fn views_are_worked_by_keys() {
    let (_folder, _, mut window) = opened("lattice");
    let cameras = |window: &Harness<App>| {
        let views = &window.state().state().views;
        (views.map.camera, views.model.camera)
    };
    window.get_by_label("Model view").focus();
    window.run_steps(3);
    let (map, mut model) = cameras(&window);
    for _ in 0..3 {
        window.key_press(Key::ArrowLeft);
        window.run_steps(2);
        let now = cameras(&window);
        assert!(now.1.target != model.target && now.1.heading == model.heading, "{now:?}");
        model = now.1;
    }
    window.key_press_modifiers(Modifiers::SHIFT, Key::ArrowLeft);
    window.run_steps(2);
    let (map_now, turned) = cameras(&window);
    assert!(turned.heading != model.heading && turned.target == model.target && map_now == map);
    window.get_by_label("Map view").focus();
    window.run_steps(3);
    window.key_press(Key::ArrowUp);
    window.key_press(Key::Plus);
    window.run_steps(2);
    let (moved, model) = cameras(&window);
    assert!(moved.centre != map.centre && moved.scale < map.scale && model == turned);
    // What lies in the middle is picked, then what lies around it.
    let mut picked = Vec::new();
    for _ in 0..6 {
        window.key_press(Key::Enter);
        settle(&mut window);
        picked.extend(window.state().state().selected.clone());
    }
    assert!(picked.iter().any(|element| element.kind == ElementKind::Quarter), "{picked:?}");
    assert!(picked.iter().any(|element| element.kind != ElementKind::Quarter), "{picked:?}");
}

#[test]
fn who_leaves_a_changed_city_is_asked() {
    let folder = tempfile::tempdir().unwrap();
    let (city, other) = (copy_of("lattice", folder.path()), copy_of("krems", folder.path()));
    let mut window = window();
    open(&mut window, &city);
    let at_first = shown(&window);
    let go = |window: &mut Harness<App>, command: Command| {
        window.state_mut().state_mut().commands.push(command);
        settle(window);
    };
    go(&mut window, Command::Seed(Some(77)));
    go(&mut window, Command::Open(other.clone()));
    assert_eq!(window.state().state().city.as_ref(), Some(&city));
    click(&mut window, "Stay");
    assert!(!window.state().state().history.is_saved());
    go(&mut window, Command::Open(other.clone()));
    click(&mut window, "Go on without saving");
    assert_eq!(window.state().state().city.as_ref(), Some(&other));
    assert!(!Changes::file_of(&city.join("city.rhai")).exists());
    open(&mut window, &city);
    assert_eq!(shown(&window), at_first, "nothing is offered of what was given up");
    go(&mut window, Command::Seed(Some(78)));
    go(&mut window, Command::Close);
    click(&mut window, "Save and go on");
    assert!(window.state().state().city.is_none() && window.query_by_label("Open a city…").is_some());
    assert_eq!(Changes::saved(&city.join("city.rhai")).unwrap().seed, Some(78));
    // What is left is not watched any more.
    fs::write(city.join("city.rhai"), "city(#{").unwrap();
    std::thread::sleep(Duration::from_millis(300));
    settle(&mut window);
    assert!(window.state().state().failure.is_none());
    open(&mut window, &other);
    assert!(window.state().state().failure.is_none());
}
