//! Rules, scripts and maps edited while a city is open: what is shown is always what a build from scratch gives, or the
//! right error beside the last good city.

use crate::desk::*;
use city::{LoadError, load};
use geom::{Digest, Id};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use viewer::state::{Command, State};

/// A rule of the city's own for its parcels, and one for its buildings.
const PARCELS: &str = "//! Parcels of an island.\nconst MOST = 700;\n\
                       fn subdivide(block, p) { block.recursive(#{ least_area: 100, most_area: global::MOST }); }\n";
const BUILDINGS: &str = "//! Plain boxes.\nfn build(shape, p) { shape.extrude(9.0 + shape.chance(1) * 6.0); }\n";

/// A small city with rules of its own, in a folder.
fn city(folder: &Path) -> PathBuf {
    let city = folder.join("town");
    for kind in ["parcels", "buildings"] {
        fs::create_dir_all(city.join(kind)).unwrap();
    }
    let script = r#"
        city(#{
            site: site(#{ size: [500, 400] }),
            seed: 3,
            given: [line([[40, 40], [460, 40], [460, 360], [40, 360], [40, 40]])],
            minors: streets(#{ pattern: rule("streets/grid", #{ block_width: 80 }) }),
            parcels: rule("parcels/mine"),
            buildings: rule("buildings/mine"),
        });
    "#;
    fs::write(city.join("city.rhai"), script).unwrap();
    fs::write(city.join("parcels/mine.rhai"), PARCELS).unwrap();
    fs::write(city.join("buildings/mine.rhai"), BUILDINGS).unwrap();
    city
}

/// A window's state without the window.
fn opened(city: &Path) -> State {
    let mut state = State::new(None, None, None, Arc::new(|| {}));
    state.carry_out(Command::Open(city.to_path_buf()));
    wait(&mut state, "the city", |state| state.ready.is_some());
    state
}

fn wait(state: &mut State, what: &str, until: impl Fn(&State) -> bool) {
    let begin = Instant::now();
    loop {
        let _ = state.catch_up();
        if until(state) {
            return;
        }
        assert!(begin.elapsed() < PATIENCE, "{what}: nothing came of it; {:?}", state.failure);
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn digest(city: &city::City) -> Id {
    let mut bytes = Vec::new();
    city::export::geojson::write_layout(city, &mut bytes).unwrap();
    Digest::new("layout").bytes(&bytes).finish()
}

/// What a program without a window makes of the files as they are: the city, or what is wrong first, be it while rules ran.
fn from_scratch(city: &Path) -> Result<Id, String> {
    let read = load(city, None).and_then(|loaded| loaded.read());
    let sources = read.map_err(|error| match error {
        LoadError::Scripts { faults, .. } => first(faults.iter().map(city::FaultReport::from).collect()),
        other => other.to_string(),
    })?;
    let built = city::build(&sources, city::Settings::default(), &city::Silent, &city::Cancel::default());
    let built = built.map_err(|error| error.to_string())?;
    if built.report.has_faults() { Err(first(built.report.faults)) } else { Ok(digest(&built.city)) }
}

fn first(faults: Vec<city::FaultReport>) -> String {
    faults.first().map_or_else(String::new, |fault| format!("{}:{}: {}", fault.file, fault.line, fault.message))
}

/// What is shown.
fn shown(state: &State) -> Result<Id, String> {
    match &state.failure {
        Some(failure) if failure.faults.is_empty() => Err(failure.message.clone().unwrap_or_default()),
        Some(failure) => Err(first(failure.faults.clone())),
        None => Ok(digest(&state.ready.as_ref().expect("a city").built.city)),
    }
}

/// An edit: a file, and what is put in place of what.
type Edit = (&'static str, &'static str, &'static str);

/// Edits of all kinds, each of the files as they were at first.
const EDITS: [Edit; 25] = [
    ("parcels/mine.rhai", "700", "900"),
    ("parcels/mine.rhai", "700", "350.5"),
    ("parcels/mine.rhai", "//! Parcels", "//! The parcels"),
    ("parcels/mine.rhai", "MOST })", "MOST )"),
    ("parcels/mine.rhai", "recursive", "recursiv"),
    ("parcels/mine.rhai", "fn subdivide", "fn divide"),
    ("parcels/mine.rhai", "most_area:", "mostarea:"),
    ("parcels/mine.rhai", "global::MOST", "\"much\""),
    ("parcels/mine.rhai", "const MOST", "params(#{ unused: number(3).range(1, 9).about(\"Nothing\") });\nconst MOST"),
    ("buildings/mine.rhai", "9.0", "30.0"),
    ("buildings/mine.rhai", "9.0 +", "9.0 -"),
    ("buildings/mine.rhai", "shape.chance", "shape.chanse"),
    ("buildings/mine.rhai", "{ shape", "{ if shape.area > 300.0 { return shape.none(); } shape"),
    ("buildings/mine.rhai", "extrude(", "extrude(("),
    ("buildings/mine.rhai", "{ shape", "{ if shape.chance(2) < 0.1 { throw \"no\"; } shape"),
    ("buildings/mine.rhai", "{ shape", "{ print(shape.is_corner); shape"),
    ("buildings/mine.rhai", "fn build(shape, p)", "fn build(shape)"),
    ("city.rhai", "seed: 3", "seed: 4"),
    ("city.rhai", "block_width: 80", "block_width: 120"),
    ("city.rhai", "block_width: 80", "block_width: -80"),
    ("city.rhai", "block_width", "block_wide"),
    ("city.rhai", "streets/grid", "streets/gird"),
    ("city.rhai", "[500, 400]", "[600, 500]"),
    ("city.rhai", "buildings: rule(\"buildings/mine\"),", ""),
    ("city.rhai", "city(#{", "city(#{ #{"),
];

/// Whether what is shown was made from a file as it now is.
fn has_seen(state: &State, path: &Path, text: &str) -> bool {
    let name = path.to_string_lossy();
    let is_idle = state.is_idle();
    let known = match &state.failure {
        Some(failure) => failure.texts.as_ref().and_then(|texts| texts.get(&name)),
        None => state.ready.as_ref().and_then(|ready| ready.as_written.texts.get(&name)),
    };
    is_idle && known.as_deref() == Some(text)
}

#[test]
fn fifty_edits_show_the_right_city_or_the_right_error() {
    let folder = tempfile::tempdir().unwrap();
    let city = city(folder.path());
    let mut state = opened(&city);
    let (mut good, mut bad) = (0, 0);
    for (i, (file, from, to)) in EDITS.iter().enumerate() {
        let path = city.join(file);
        let before = fs::read_to_string(&path).unwrap();
        assert!(before.contains(from), "{file}: {from}");
        // There, and back again: fifty edits.
        for text in [before.replacen(from, to, 1), before.clone()] {
            let last_good = state.ready.as_ref().map(|ready| ready.round);
            fs::write(&path, &text).unwrap();
            let expected = from_scratch(&city);
            let what = format!("edit {i}, {from} to {to} in {file}");
            wait(&mut state, &what, |state| has_seen(state, &path, &text) && shown(state) == expected);
            match expected {
                Ok(_) => good += 1,
                Err(_) => {
                    bad += 1;
                    assert_eq!(state.ready.as_ref().map(|ready| ready.round), last_good, "edit {i}: the city stays");
                }
            }
        }
    }
    assert!(good + bad == 50 && bad >= 8, "{good} good, {bad} bad");
}

#[test]
fn a_rule_that_fails_while_it_runs_leaves_the_last_good_city_until_people_want_to_see_it() {
    let folder = tempfile::tempdir().unwrap();
    let city = city(folder.path());
    let mut state = opened(&city);
    let good = shown(&state).unwrap();
    let path = city.join("buildings/mine.rhai");
    let write = |state: &mut State, text: &str| {
        fs::write(&path, text).unwrap();
        wait(state, text, |state| has_seen(state, &path, text));
    };
    let failing = BUILDINGS.replace("{ shape", "{ if shape.chance(2) < 0.1 { throw \"no\"; } shape");
    write(&mut state, &failing);
    assert_eq!(digest(&state.ready.as_ref().unwrap().built.city), good);
    let failure = state.failure.clone().unwrap();
    assert!(failure.faults[0].message.contains("no") && failure.faults[0].place.is_some(), "{failure:?}");
    // What is changed meanwhile fails, too.
    state.carry_out(Command::Seed(Some(77)));
    wait(&mut state, "another seed", |state| {
        state.is_idle() && state.held.as_ref().is_some_and(|held| held.order.changes.seed == Some(77))
    });
    state.carry_out(Command::ShowAnyway);
    let (ready, failure) = (state.ready.clone().unwrap(), state.failure.clone());
    assert!(failure.is_none() && ready.order.changes.seed == Some(77) && ready.built.report.has_faults());
    // Who has seen one is shown the next that is no worse, and a good one in any case.
    let longer = format!("{failing}// longer\n");
    write(&mut state, &longer);
    assert!(state.failure.is_none() && state.ready.as_ref().unwrap().built.report.has_faults());
    write(&mut state, &failing.replace("0.1", "0.9"));
    assert!(state.failure.is_some() && state.held.is_some(), "more fail");
    write(&mut state, &failing);
    assert!(state.failure.is_none());
    state.carry_out(Command::Undo);
    write(&mut state, BUILDINGS);
    assert_eq!(shown(&state), Ok(good));
    write(&mut state, &failing);
    assert!(state.failure.is_some());
    write(&mut state, BUILDINGS);
    assert_eq!(shown(&state), Ok(good));
}

#[test]
fn saved_changes_that_do_not_suit_are_left_out_and_can_be_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let city = city(folder.path());
    let file = city.join("city.changes");
    let text = "plat-changes 1\nseed 9\npreset minors=vilage\nset minors.pattern.block_wide=60\n\
                set minors.pattern.block_width=100\n";
    fs::write(&file, text).unwrap();
    let mut state = opened(&city);
    let ready = state.ready.clone().unwrap();
    let lines: Vec<u32> = ready.unsuited.iter().map(|error| error.line).collect();
    assert_eq!(lines, [3, 4], "{:?}", ready.unsuited);
    assert!(ready.unsuited[1].hint.as_ref().is_some_and(|hint| hint.contains("block_width")), "{:?}", ready.unsuited);
    assert!(state.history.is_saved(), "nothing is taken from anybody unasked");
    assert_eq!(state.history.now().len(), 4);
    fs::write(&file, "plat-changes 1\nseed 9\nset minors.pattern.block_width=100\n").unwrap();
    let expected = from_scratch(&city);
    assert_eq!(Ok(digest(&ready.built.city)), expected);
    fs::write(&file, text).unwrap();
    wait(&mut state, "the file as it was", |state| state.is_idle() && state.history.now().len() == 4);
    state.carry_out(Command::DropUnsuited);
    wait(&mut state, "what suits", |state| state.is_idle() && state.ready.as_ref().unwrap().unsuited.is_empty());
    assert_eq!(shown(&state), expected);
    assert_eq!(state.history.now().len(), 2);
    state.carry_out(Command::Undo);
    wait(&mut state, "all of them", |state| state.is_idle() && state.ready.as_ref().unwrap().unsuited.len() == 2);
    state.carry_out(Command::Redo);
    state.carry_out(Command::Save);
    assert!(!fs::read_to_string(&file).unwrap().contains("vilage"));
    assert!(from_scratch(&city).is_ok());
}

#[test]
fn a_rule_that_breaks_behind_a_preset_keeps_the_last_good_city() {
    let folder = tempfile::tempdir().unwrap();
    let city = city(folder.path());
    let rule = city.join("huts.rhai");
    let good = "//! Huts.\nfn build(shape, p) {\n    shape.extrude(5);\n}\n";
    fs::create_dir_all(city.join("presets")).unwrap();
    fs::write(city.join("presets/mine.rhai"), "//! Mine.\npreset(#{ buildings: rule(\"huts\") });\n").unwrap();
    fs::write(&rule, good).unwrap();
    fs::write(city.join("city.changes"), "plat-changes 1\npreset city=mine\n").unwrap();
    let mut state = opened(&city);
    let expected = from_scratch(&city);
    assert_eq!(shown(&state), expected);
    fs::write(&rule, good.replace("5)", "5")).unwrap();
    wait(&mut state, "the fault", |state| state.is_idle() && state.failure.is_some());
    let faults = &state.failure.as_ref().unwrap().faults;
    assert!(faults.len() == 1 && faults[0].line == 3 && Path::new(&faults[0].file) == rule, "{faults:?}");
    assert_eq!(Ok(digest(&state.ready.as_ref().unwrap().built.city)), expected, "the city with the preset");
    fs::write(&rule, good).unwrap();
    wait(&mut state, "the mended rule", |state| state.is_idle() && state.failure.is_none());
    assert_eq!(shown(&state), expected);
}

#[test]
fn changes_that_something_else_saved_are_followed_and_those_that_are_not_saved_stay() {
    let folder = tempfile::tempdir().unwrap();
    let city = city(folder.path());
    let file = city.join("city.changes");
    // One that nobody can read does not keep the city shut.
    fs::write(&file, "plat-changes 1\nsed 9\n").unwrap();
    let mut state = opened(&city);
    let misread = state.misread.clone().unwrap();
    assert!(misread[0].line == 2 && Path::new(&misread[0].file) == file, "{misread:?}");
    assert!(state.text_of(&file.to_string_lossy()).is_some_and(|text| text.contains("sed 9")));
    fs::write(&file, "plat-changes 1\nseed 9\n").unwrap();
    wait(&mut state, "the mended file", |state| {
        state.is_idle() && state.ready.as_ref().is_some_and(|ready| ready.order.changes.seed == Some(9))
    });
    assert_eq!(shown(&state), from_scratch(&city));
    assert!(state.history.is_saved() && state.misread.is_none());
    state.carry_out(Command::Undo);
    wait(&mut state, "without it", |state| state.is_idle() && state.ready.as_ref().unwrap().order.changes.is_empty());
    // Now there is something that is not saved: the file is not followed.
    state.message = None;
    state.carry_out(Command::Seed(Some(4)));
    fs::write(&file, "plat-changes 1\nseed 10\n").unwrap();
    wait(&mut state, "the own seed", |state| {
        state.is_idle() && state.ready.as_ref().is_some_and(|ready| ready.order.changes.seed == Some(4))
    });
    std::thread::sleep(Duration::from_millis(300));
    wait(&mut state, "nothing", State::is_idle);
    assert_eq!(state.history.now().seed, Some(4));
    assert!(state.message.take().unwrap().contains("Your own changes are not saved"), "told as soon as it is known");
    state.carry_out(Command::Save);
    assert!(state.message.clone().unwrap().contains("something else wrote city.changes"));
    assert_eq!(fs::read_to_string(&file).unwrap(), "plat-changes 1\nseed 10\n");
    state.carry_out(Command::Save);
    assert_eq!(
        (state.message.clone(), state.history.is_saved()),
        (None, true),
        "it is saved, and nothing else is said"
    );
    // Nor is a folder that was taken away what something else wrote.
    let away = folder.path().join("away");
    fs::rename(&city, &away).unwrap();
    state.carry_out(Command::Seed(Some(5)));
    state.carry_out(Command::Save);
    assert!(state.message.clone().unwrap().contains("is not there any more"));
    fs::rename(&away, &city).unwrap();
    state.carry_out(Command::Save);
    assert_eq!((state.message.clone(), state.history.is_saved()), (None, true));
}

#[test]
fn values_of_a_preset_go_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let city = city(folder.path());
    let mut state = opened(&city);
    let at_first = shown(&state).unwrap();
    let quarter = state.ready.as_ref().unwrap().built.city.quarters[0].id;
    let target: script::PresetTarget = format!("quarter:{quarter}").parse().unwrap();
    let done = |state: &mut State| wait(state, "the city", |state| state.is_idle() && state.commands.is_empty());
    let lay = |state: &mut State, name: &str| state.carry_out(Command::Lay(target.clone(), name.into()));
    let address = format!("quarter:{quarter}.minors.pattern.length");
    lay(&mut state, "curved_suburb");
    let set = Command::Set { address: address.clone(), value: "280".into(), turning: false };
    state.carry_out(set);
    done(&mut state);
    let turned = shown(&state).unwrap();
    assert_eq!(state.ready.as_ref().unwrap().unsuited.len(), 0);
    for name in [Some("boulevard_radial"), None] {
        match name {
            Some(name) => lay(&mut state, name),
            None => state.carry_out(Command::Lift(target.clone())),
        }
        assert!(state.message.take().unwrap().contains(&address));
        done(&mut state);
        assert_eq!(state.history.now().value(&address), None);
        assert!(state.ready.as_ref().unwrap().unsuited.is_empty());
        state.carry_out(Command::Save);
        assert_eq!(Ok(digest(&state.ready.as_ref().unwrap().built.city)), from_scratch(&city));
        state.carry_out(Command::Undo);
        done(&mut state);
        assert_eq!(shown(&state), Ok(turned), "one step brings all of it back");
    }
    state.carry_out(Command::Undo);
    state.carry_out(Command::Undo);
    done(&mut state);
    assert_eq!(shown(&state), Ok(at_first));
}

/// Bytes of memory that this program holds.
#[cfg(target_os = "linux")]
fn resident() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
}

#[test]
fn a_thousand_rapid_saves_leave_nothing_stale() {
    let folder = tempfile::tempdir().unwrap();
    let city = city(folder.path());
    let mut state = opened(&city);
    let path = city.join("buildings/mine.rhai");
    let save = |state: &mut State, i: usize| {
        // Every seventh is broken; some come half a save later.
        let text = match i % 7 {
            3 => BUILDINGS.replace("extrude(", "extrude(("),
            _ => BUILDINGS.replace("9.0", &format!("{}.0", 6 + i % 20)),
        };
        fs::write(&path, &text).unwrap();
        let _ = state.catch_up();
        std::thread::sleep(Duration::from_micros(300 * (i as u64 % 11)));
        text
    };
    for i in 0..200 {
        save(&mut state, i);
    }
    #[cfg(target_os = "linux")]
    let before = resident();
    let mut text = String::new();
    for i in 200..1000 {
        text = save(&mut state, i);
    }
    // A city that was read while the last save came is followed by another: what stays is what counts.
    let expected = from_scratch(&city);
    wait(&mut state, "the last save", |state| has_seen(state, &path, &text) && shown(state) == expected);
    let text = BUILDINGS.replace("9.0", "17.5");
    fs::write(&path, &text).unwrap();
    let expected = from_scratch(&city);
    wait(&mut state, "one more save", |state| has_seen(state, &path, &text) && shown(state) == expected);
    #[cfg(target_os = "linux")]
    {
        // Other tests run beside this one: what leaks with every save is more than this.
        let grown = resident().saturating_sub(before);
        assert!(grown < 400_000_000, "{} MB more after 800 saves", grown / 1_000_000);
    }
}
