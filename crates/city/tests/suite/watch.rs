//! `plat build --watch`, beside `plat build` of the same files.

use crate::common::command::{place, plat, write};
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

const CITY: &str = r#"
city(#{
    site: site(#{ size: [420, 380] }),
    seed: 3,
    given: [line([[20, 20], [400, 20], [400, 360], [20, 360], [20, 20]], #{ class: "major" })],
    minors: streets(#{ pattern: rule("streets/lanes"), width: 12 }),
    parcels: rule("parcels/recursive"),
    buildings: rule("buildings/boxes"),
});
"#;

const LANES: &str = "fn propose(tip, p) { tip.fork(60, 90); }\n";
const BOXES: &str = "fn build(shape, p) { shape.extrude(9, #{ setback: 1 }) }\n";

/// A command that watches, and what it tells, line by line.
struct Watching {
    child: Child,
    lines: Receiver<String>,
}

impl Watching {
    fn start(folder: &Path, more: &[&str]) -> Self {
        let out: &[&str] = if more.contains(&"-o") { &[] } else { &["-o", "out"] };
        let arguments = ["build", "town", "--watch"];
        let mut child = Command::new(env!("CARGO_BIN_EXE_plat"))
            .current_dir(folder)
            .env("XDG_CACHE_HOME", folder.join("user cache"))
            .args(arguments)
            .args(out)
            .args(more)
            .stderr(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("plat runs");
        let (sender, lines) = channel();
        let told = BufReader::new(child.stderr.take().expect("piped"));
        std::thread::spawn(move || told.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Self { child, lines }
    }

    /// What it tells up to a line with one of some words.
    fn until(&self, words: &[&str]) -> Vec<String> {
        let mut told: Vec<String> = Vec::new();
        while !told.last().is_some_and(|line| words.iter().any(|word| line.contains(word))) {
            let next = self.lines.recv_timeout(Duration::from_secs(60));
            told.push(next.unwrap_or_else(|_| panic!("nothing more comes after {told:#?}")));
        }
        told
    }

    fn built(&self) -> Vec<String> {
        self.until(&["built  in"])
    }

    /// Ends it as Ctrl-C does, and gives its status and standard output.
    fn stop(mut self) -> (Option<i32>, String) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
        let status = self.child.wait().expect("it ends");
        let mut told = String::new();
        self.child.stdout.take().expect("piped").read_to_string(&mut told).expect("text");
        (status.code(), told)
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        // Gone already where it was stopped.
        let _ = self.child.kill();
    }
}

/// The files of a folder of results.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entry = |entry: std::io::Result<fs::DirEntry>| {
        let path = entry.expect("an entry").path();
        (path.file_name().expect("a name").to_string_lossy().into_owned(), fs::read(&path).expect("read"))
    };
    fs::read_dir(folder).expect("results").map(entry).collect()
}

fn fresh(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let output = plat(folder, &["build", "town", "-o", "fresh", "--quiet"]);
    assert!(output.status.code().is_some_and(|code| code < 2), "{}", String::from_utf8_lossy(&output.stderr));
    files(&folder.join("fresh"))
}

fn town() -> tempfile::TempDir {
    place(&[("town/city.rhai", CITY), ("town/streets/lanes.rhai", LANES), ("town/buildings/boxes.rhai", BOXES)])
}

#[test]
#[cfg(unix)]
fn files_follow_what_is_saved_and_stay_while_something_is_broken() {
    let folder = town();
    let save = |name: &str, text: &str| write(folder.path(), &format!("town/{name}"), text);
    let watching = Watching::start(folder.path(), &[]);
    watching.built();
    let first = files(&folder.path().join("out"));
    assert_eq!(first, fresh(folder.path()));

    save("buildings/boxes.rhai", &BOXES.replace('9', "15"));
    let told = watching.built().join("\n");
    assert!(told.contains("changed  boxes.rhai") && told.contains("buildings"), "{told}");
    assert!(!told.contains("minors") && !told.contains("parcels"), "streets and parcels are not made again: {told}");
    let second = files(&folder.path().join("out"));
    assert!(second != first && second == fresh(folder.path()));

    // It does not parse.
    save("buildings/boxes.rhai", "fn build(shape, p) { shape.extrude(9 }\n");
    let told = watching.until(&["nothing was written"]).join("\n");
    assert!(told.contains("boxes.rhai:1:"), "{told}");
    assert_eq!(files(&folder.path().join("out")), second);
    // It fails when it is asked.
    save("buildings/boxes.rhai", "fn build(shape, p) { throw \"no houses\" }\n");
    let told = watching.until(&["nothing was written"]).join("\n");
    assert!(told.contains("no houses"), "{told}");
    assert_eq!(files(&folder.path().join("out")), second);
    // As it is written.
    save("buildings/boxes.rhai", &BOXES.replace('9', "15"));
    watching.until(&["same  as what is written"]);
    save("city.rhai", "city(#{ site: 5 });");
    watching.until(&["nothing was written"]);
    save("city.rhai", &CITY.replace("seed: 3", "seed: 4"));
    watching.built();
    let third = files(&folder.path().join("out"));
    assert!(third != second && third == fresh(folder.path()));
    // Files that say nothing about the city, results among them, are no reason to build.
    save("buildings/boxes.test.rhai", "fn test_nothing() {}\n");
    watching.until(&["same  as what is written"]);
    assert_eq!(watching.stop(), (Some(0), String::new()));
}

#[test]
#[cfg(unix)]
fn the_newest_of_many_saves_wins_and_another_program_goes_on_with_the_cache() {
    let folder = town();
    let save = |text: &str| write(folder.path(), "town/streets/lanes.rhai", text);
    let watching = Watching::start(folder.path(), &["--cache", "kept", "--json"]);
    for round in 0..40 {
        save(&LANES.replace("60", &format!("{}", 55 + round % 11)));
        std::thread::sleep(Duration::from_millis(15 * (round % 4)));
    }
    save(&LANES.replace("60", "50"));
    let wanted = fresh(folder.path());
    let is_there = || fs::read_dir(folder.path().join("out")).is_ok() && files(&folder.path().join("out")) == wanted;
    for _ in 0..600 {
        if is_there() {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    assert!(is_there(), "the files are not those of the last save");
    let (status, told) = watching.stop();
    assert_eq!(status, Some(0));
    for line in told.lines() {
        let value: serde_json::Value = serde_json::from_str(line).expect("a line is a JSON object");
        // A file may be read while it is half saved, and is read again once it is whole.
        let is_built = value["report"]["counts"]["buildings"].as_u64().is_some_and(|count| count > 0);
        assert!(
            is_built || value["error"]["message"].as_str().is_some_and(|told| told.contains("lanes.rhai")),
            "{line}"
        );
    }
    // Streets, parcels and buildings come from the cache.
    let output = plat(folder.path(), &["build", "town", "-o", "again", "--cache", "kept"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("export") && !told.contains("minors") && !told.contains("buildings  "), "{told}");
    assert_eq!(files(&folder.path().join("again")), wanted);
}

#[test]
#[cfg(unix)]
fn what_no_save_mends_ends_the_watch() {
    let folder = town();
    for (arguments, words) in [
        (&["build", "nowhere", "--watch", "--no-cache"][..], "there is no such city"),
        (
            &["build", "town", "--watch", "--no-cache", "--set", "minors.pattern.nothing=1"],
            "there is no parameter `nothing`",
        ),
        (&["build", "town", "--watch", "--trace", "00"], "cannot be used with"),
        (&["build", "town", "--watch", "--cache", "town/city.rhai", "--quiet"], "--cache"),
    ] {
        let output = plat(folder.path(), arguments);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code().is_some_and(|code| code >= 2) && told.contains(words), "{arguments:?}: {told}");
        assert!(!folder.path().join("out").exists());
    }
}

/// Saves a boxes rule of a height where a city lies, and waits for files that are those of a fresh build.
fn follows(watching: &Watching, folder: &Path, height: u32, save: impl Fn(&str)) {
    save(&BOXES.replace('9', &height.to_string()));
    let told = watching.built();
    assert_eq!(files(&folder.join("out")), fresh(folder), "{told:#?}");
}

#[test]
#[cfg(unix)]
fn folders_that_are_replaced_linked_or_missing_for_a_while_are_followed() {
    let folder = town();
    let at = |name: &str| folder.path().join(name);
    // A rule that is linked, and a folder of rules of its own.
    fs::create_dir_all(at("lib")).expect("made");
    fs::rename(at("town/buildings/boxes.rhai"), at("lib/boxes.rhai")).expect("moved");
    std::os::unix::fs::symlink(at("lib/boxes.rhai"), at("town/buildings/boxes.rhai")).expect("linked");
    let watching = Watching::start(folder.path(), &["--no-cache"]);
    watching.built();
    follows(&watching, folder.path(), 12, |text| write(folder.path(), "lib/boxes.rhai", text));
    // Another folder of the same name in its place.
    fs::remove_file(at("town/buildings/boxes.rhai")).expect("removed");
    watching.until(&["nothing was written"]);
    write(folder.path(), "town/buildings/boxes.rhai", &BOXES.replace('9', "14"));
    watching.built();
    assert!(
        Command::new("cp").args(["-r", "town", "spare"]).current_dir(folder.path()).status().expect("cp").success()
    );
    let swap = "mv town before; mv spare town";
    assert!(Command::new("sh").args(["-c", swap]).current_dir(folder.path()).status().expect("sh").success());
    watching.until(&["same  as", "nothing was written"]);
    std::thread::sleep(Duration::from_millis(300));
    while watching.lines.try_recv().is_ok() {}
    follows(&watching, folder.path(), 16, |text| write(folder.path(), "town/buildings/boxes.rhai", text));
    // Results that somebody took away come back.
    fs::remove_dir_all(at("out")).expect("removed");
    write(folder.path(), "town/notes.txt", "nothing");
    watching.built();
    assert_eq!(files(&at("out")), fresh(folder.path()));
    assert_eq!(watching.stop().0, Some(0));
}

#[test]
#[cfg(unix)]
fn results_in_the_midst_of_the_city_start_no_build() {
    for out in ["town", "town/deep/er/out", "town/link"] {
        let folder = town();
        fs::create_dir_all(folder.path().join("elsewhere")).expect("made");
        std::os::unix::fs::symlink(folder.path().join("elsewhere"), folder.path().join("town/link")).expect("linked");
        let watching = Watching::start(folder.path(), &["--no-cache", "-o", out]);
        watching.built();
        // What lies around may be told once; then it is still.
        std::thread::sleep(Duration::from_millis(500));
        while watching.lines.try_recv().is_ok() {}
        assert!(watching.lines.recv_timeout(Duration::from_millis(700)).is_err(), "{out}: it goes on and on");
        write(folder.path(), "town/buildings/boxes.rhai", &BOXES.replace('9', "30"));
        watching.built();
        assert_eq!(watching.stop().0, Some(0));
    }
}

#[test]
#[cfg(unix)]
fn a_good_city_outlasts_a_start_with_a_broken_rule() {
    let folder = town();
    let good = fresh(folder.path());
    fs::rename(folder.path().join("fresh"), folder.path().join("out")).expect("moved");
    write(folder.path(), "town/buildings/boxes.rhai", "fn build(shape, p) { throw \"no houses\" }\n");
    let watching = Watching::start(folder.path(), &["--no-cache"]);
    watching.until(&["nothing was written"]);
    assert_eq!(files(&folder.path().join("out")), good);
    assert_eq!(watching.stop().0, Some(130), "nothing was written");
}
