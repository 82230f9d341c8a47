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

/// What a program without a window makes of the files as they are: the city, or what is wrong first.
fn from_scratch(city: &Path) -> Result<Id, String> {
    let read = load(city, None).and_then(|loaded| loaded.read());
    let sources = read.map_err(|error| match error {
        LoadError::Scripts { faults, .. } => first(faults.iter().map(city::FaultReport::from).collect()),
        other => other.to_string(),
    })?;
    let built = city::build(&sources, city::Settings::default(), &city::Silent, &city::Cancel::default());
    built.map(|built| digest(&built.city)).map_err(|error| error.to_string())
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
