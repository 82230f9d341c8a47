//! From a saved rule to finished files, on Manhattan: what `plat build --watch` does, beside a build from scratch in the same
//! run.

use super::is_asked;
use city::export::{Format, MapOptions, Wanted, write_wanted};
use city::{Cache, Cancel, Settings, Silent, build_with, load};
use std::fs;
use std::path::Path;
use std::time::Instant;
use suite::shipped;

/// How often each edit is made; the least and the greatest time are told.
const ROUNDS: usize = 5;

pub fn tables() {
    if !is_asked("watch") {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let city = folder.path().join("manhattan");
    copy(&shipped("manhattan"), &city);
    let host = script::Host::new(Vec::new());
    let source = |name: &str| host.source(name).expect("a rule of the library").text;
    for name in ["buildings/extruded", "streets/grid"] {
        write(&city.join(name.to_owned() + ".rhai"), &source(name));
    }
    write(&city.join("streets/mine.rhai"), &source("streets/organic"));
    write(
        &city.join("presets/mine.rhai"),
        "//! Mine.\npreset(#{ pattern: rule(\"streets/mine\", #{ length: 90 }) });\n",
    );
    let cache = Cache::in_memory();
    let quarter = largest_quarter(&city);
    let script = fs::read_to_string(city.join("city.rhai")).expect("read");
    let end = script.rfind("});").expect("a city");
    let own = format!("    quarters: #{{ \"{quarter}\": #{{ preset: preset(\"mine\") }} }},\n");
    write(&city.join("city.rhai"), &format!("{}{own}{}", &script[..end], &script[end..]));
    println!("\nwatch, Manhattan, seconds from saving to finished files, {ROUNDS} rounds");
    made(&city, &cache, folder.path());
    let told = |name: &str, cache: &Cache, edit: &dyn Fn(usize)| {
        let times: Vec<f64> = (0..ROUNDS)
            .map(|round| {
                edit(round);
                let started = Instant::now();
                made(&city, cache, folder.path());
                started.elapsed().as_secs_f64()
            })
            .collect();
        let (least, most) =
            times.iter().fold((f64::MAX, 0f64), |(least, most), &time| (least.min(time), most.max(time)));
        println!("  {name:<32} {least:.2} to {most:.2}");
    };
    let change = |name: &str, from: &str, to: String| {
        let path = city.join(name);
        let text = source_of(&path);
        let changed = text.lines().map(|line| if line.trim_start().starts_with(from) { to.as_str() } else { line });
        write(&path, &changed.collect::<Vec<_>>().join("\n"));
    };
    told("all from scratch", &Cache::none(), &|_| {});
    told("a rule of buildings", &cache, &|round| {
        change(
            "buildings/extruded.rhai",
            "setback:",
            format!("setback: metres({}).range(0, 50).about(\"Kept free\"),", 2.1 + 0.1 * round as f64),
        );
    });
    told("a rule of parcels", &cache, &|round| {
        let path = city.join("parcels/island.rhai");
        write(&path, &format!("{}\n// {round}", source_of(&path)));
    });
    told("a street rule of one quarter", &cache, &|round| {
        change("streets/mine.rhai", "branching:", format!("branching: ratio(0.{}).about(\"Branching\"),", 50 + round));
    });
    told("a street rule of all", &cache, &|round| {
        let path = city.join("streets/grid.rhai");
        write(&path, &format!("{}\n// {round}", source_of(&path)));
    });
}

fn source_of(path: &Path) -> String {
    fs::read_to_string(path).expect("read")
}

fn write(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().expect("a parent")).expect("made");
    fs::write(path, text).expect("written");
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("made");
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).expect("copied");
        }
    }
}

fn largest_quarter(city: &Path) -> geom::Id {
    let sources = load(city, None).and_then(|loaded| loaded.read()).expect("read");
    let built = city::build(&sources, Settings::default(), &Silent, &Cancel::default()).expect("built");
    let largest = built.city.quarters.iter().max_by_key(|quarter| quarter.polygon.doubled_area());
    largest.expect("a quarter").id
}

/// Reads, builds and writes once.
fn made(city: &Path, cache: &Cache, folder: &Path) {
    let sources = load(city, None).and_then(|loaded| loaded.read_with(cache)).expect("read");
    let built = build_with(&sources, Settings::default(), cache, &Silent, &Cancel::default()).expect("built");
    assert!(!built.report.has_faults(), "{:?}", built.report.faults);
    let wanted = Wanted { map: &MapOptions::default(), formats: &Format::ALL, others: &[], cache, is_durable: false };
    write_wanted(&built.city, &wanted, &folder.join("out"), &Cancel::default()).expect("written");
}
