//! `plat build --steps` and `--colour-by`: further pictures of a city that they do not change.

use city::{Built, Cancel, Settings, Silent, Until, build, load};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts").join(name)
}

fn traced(name: &str) -> Built {
    let sources = load(&shipped(name), None).expect("a city").read().expect("its maps");
    let settings = Settings { until: Until::Streets, traces: true, ..Settings::default() };
    build(&sources, settings, &Silent, &Cancel::default()).expect("it builds")
}

fn plat(city: &Path, out: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plat"));
    command.arg("build").arg(city).arg("-o").arg(out).args(more).output().expect("plat runs")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn after_the_last_step_the_city_is_as_it_is() {
    for name in ["lattice", "manhattan"] {
        let Built { city, trace, .. } = traced(name);
        let trace = trace.expect("asked for");
        let last = trace.last_step();
        assert!(last > 20, "{name} grows for {last} steps");
        assert_eq!(trace.after(last).digest(), city.graph.digest(), "{name}");
        assert_eq!(trace.after(u32::MAX).digest(), city.graph.digest(), "{name}");
        if name == "manhattan" {
            // It takes dead ends back once all has grown.
            continue;
        }
        // One step before, what is laid from the log differs from that by the last step alone.
        let (start, minors) = trace.stages().last().expect("a stage");
        let of_last = |time: u32| start + time == last;
        let lasts = minors.logs().into_iter().flat_map(|log| &log.accepted).filter(|a| of_last(a.lineage.time));
        let laid: f64 = lasts.map(|accepted| accepted.start().distance(accepted.end())).sum();
        let missing = city.graph.total_length() - trace.after(last - 1).total_length();
        assert!((missing - laid).abs() < 20.0, "{name}: {missing} m, not {laid} m");
    }
}

#[test]
fn a_step_shows_what_was_accepted_by_then() {
    let trace = traced("manhattan").trace.expect("asked for");
    let stages: Vec<_> = trace.stages().collect();
    assert_eq!(stages.iter().map(|(_, stage)| stage.name).collect::<Vec<_>>(), ["highways", "majors", "minors"]);
    // What a finished stage takes back or smooths is not to be seen before its end.
    let (first_end, _) = stages[1];
    let first = || stages[0].1.logs().into_iter().flat_map(|log| &log.accepted);
    for step in [0, 1, first_end / 3, first_end - 1] {
        let graph = trace.after(step);
        let laid: f64 = first().filter(|a| a.lineage.time <= step).map(|a| a.start().distance(a.end())).sum();
        assert!((graph.total_length() - laid).abs() < 1.0, "{step}: {} m, not {laid} m", graph.total_length());
        let streets = |time: u32| first().filter(move |a| a.lineage.time <= time).map(|a| a.lineage.street);
        let mut wanted: Vec<_> = streets(step).collect();
        wanted.sort_unstable();
        wanted.dedup();
        assert_eq!(graph.streets(), wanted, "{step}");
    }
    let lengths: Vec<f64> = (0..6).map(|i| trace.after(trace.last_step() * i / 5).total_length()).collect();
    assert!(lengths.windows(2).all(|pair| pair[0] < pair[1]), "{lengths:?}");
}

#[test]
fn steps_add_pictures_and_change_nothing_else() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (plain, stepped) = (folder.path().join("plain"), folder.path().join("stepped"));
    assert_eq!(plat(&shipped("lattice"), &plain, &["--quiet"]).status.code(), Some(0));
    let output = plat(&shipped("lattice"), &stepped, &["--steps", "5,12,12,9999"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert!(told(&output).contains("step 9999 shows all that grew"), "{}", told(&output));
    for name in ["layout.geojson", "map.svg", "map.png", "city.glb"] {
        assert!(fs::read(plain.join(name)).expect(name) == fs::read(stepped.join(name)).expect(name), "{name}");
    }
    let svg = |step: u32| fs::read_to_string(stepped.join(format!("map-step-{step}.svg"))).expect("a map");
    assert!(svg(5).contains("Lattice, after 5 steps") && svg(12).contains("after 12 steps"));
    assert!(svg(5).len() < svg(12).len() && svg(12).len() < svg(9999).len());
    assert!(stepped.join("map-step-5.png").is_file());
    let page = |text: &str| text.lines().next().expect("a line").to_owned();
    assert_eq!(page(&svg(5)), page(&svg(9999)), "all steps show the same ground");
}

#[test]
fn bad_steps_and_colours_are_refused() {
    let out = tempfile::tempdir().expect("a temporary folder");
    for (arguments, word) in [
        (["--steps", "soon"], "soon"),
        (["--steps", "-3"], "whole number from 0"),
        (["--seed", "-5"], "a seed is a whole number from 0"),
        (["--colour-by", "mood"], "rule"),
        (["--colour-by", "grade"], "no map `elevation`"),
        (["--colour-by", "density"], "no map `density`"),
    ] {
        let output = plat(&shipped("lattice"), out.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{}", told(&output));
        assert!(told(&output).contains(word), "{}", told(&output));
    }
    assert_eq!(fs::read_dir(out.path()).expect("a folder").count(), 0);
}

#[test]
fn colours_are_explained_on_the_map() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (by, words) in [
        ("rule", &["streets by rule", "streets/grid"][..]),
        ("class", &["streets by class", "minor"]),
        ("district", &["streets by district", "none"]),
    ] {
        let out = folder.path().join(by);
        let output = plat(&shipped("lattice"), &out, &["--until", "streets", "--colour-by", by]);
        assert_eq!(output.status.code(), Some(0), "{}", told(&output));
        assert_eq!(told(&output).contains("no districts"), by == "district");
        let svg = fs::read_to_string(out.join("map.svg")).expect("a map");
        for word in words {
            assert!(svg.contains(word), "{by}: {word}");
        }
    }
}
