//! Rules with bugs planted in them, each found with nothing but the window.

use crate::desk::*;
use city::City;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::Path;
use viewer::app::App;
use viewer::scene::{By, Element, ElementKind};
use viewer::state::Command;

const CITY: &str = r#"
    city(#{
        site: site(#{ size: [600, 500] }),
        seed: 3,
        given: [line([[40, 40], [560, 40], [560, 460], [40, 460], [40, 40]])],
        minors: streets(#{
            pattern: rule("streets/mine"),
            constraints: rule("constraints/mine"),
        }),
        parcels: rule("parcels/mine"),
        buildings: rule("buildings/mine"),
    });
"#;
const STREETS: &str = r#"//! A raster, square to the site.
params(#{ step: metres(90).range(20, 200).about("Distance of its streets") });
fn propose(tip, p) {
    tip.ahead(p.step);
    tip.branch_left(p.step);
    tip.branch_right(p.step);
}
"#;
const CONSTRAINTS: &str = r#"//! The usual ones, and none close to the rim.
fn constraints(p) {
    [length(8, 1000), legal(#{}), crossing(), snap(12), join(12), duplicate(12), angle(25), arms(4), own()]
}
fn constrain(segment, p) {
    if segment.to_x < -99 { segment.refuse("too near the rim"); }
}
"#;
const PARCELS: &str = r#"//! Usual parcels.
fn subdivide(block, p) {
    block.recursive(#{ least_area: 150, most_area: 800, least_frontage: 8 });
}
"#;
const BUILDINGS: &str = r#"//! Houses of two to four floors.
params(#{ floor: metres(3.2).range(2, 6).about("Height of a floor") });
fn build(shape, p) {
    if shape.area < 60 { return shape.none(); }
    shape.extrude(round(shape.chance(1, 2, 4)) * p.floor, #{ setback: 2 });
}
"#;

/// What in the window gives a bug away.
enum Found {
    /// A fault in Problems, by its place in a file and words of it.
    Told(&'static str, &'static str),
    /// Words of the answer why something is there.
    Why(ElementKind, &'static str),
    /// What the console says to something.
    Console(&'static str, fn(&str) -> bool),
    /// The legend of streets by rule, which lacks this rule.
    NotColoured(&'static str),
    /// Words that a rule printed for this, in Problems.
    Printed(&'static str),
    /// A place that the rule marked for this, on the map.
    Marked,
}

/// A bug: the file, what is put in place of what, and how it is found.
struct Bug(&'static str, &'static str, &'static str, Found);

fn number(text: &str) -> f64 {
    text.parse().unwrap_or(f64::NAN)
}

fn bugs() -> Vec<Bug> {
    use Found::{Console, Marked, NotColoured, Printed, Told, Why};
    vec![
        Bug("streets/mine.rhai", "tip.ahead(p.step);", "tip.ahead(p.step)", Told("streets/mine.rhai:5:", "';'")),
        Bug("streets/mine.rhai", "tip.ahead", "tip.ahed", Told("streets/mine.rhai:4:", "ahed")),
        Bug(
            "streets/mine.rhai",
            "p.step);\n    tip.branch_left",
            "p.stepp);\n    tip.branch_left",
            Told("streets/mine.rhai:4:", "stepp"),
        ),
        Bug("streets/mine.rhai", "metres(90)", "metres(900)", Told("streets/mine.rhai:2:", "900")),
        Bug("streets/mine.rhai", "tip.ahead", "while true { } tip.ahead", Told("streets/mine.rhai:4:", "operations")),
        Bug(
            "city.rhai",
            "rule(\"streets/mine\")",
            "rule(\"streets/mine\", #{ stride: 40 })",
            Told("city.rhai:7:", "stride"),
        ),
        Bug("parcels/mine.rhai", "most_area: 800", "most_area: \"800\"", Told("parcels/mine.rhai:3:", "most_area")),
        Bug(
            "buildings/mine.rhai",
            "shape.extrude",
            "let heights = [6, 9]; heights[round(shape.chance(2, 0, 3))]; shape.extrude",
            Told("buildings/mine.rhai:5:", "heights"),
        ),
        Bug(
            "buildings/mine.rhai",
            "if shape.area < 60",
            "if shape.is_corner { throw \"no way in\"; } if shape.area < 60",
            Told("buildings/mine.rhai:4:", "no way in"),
        ),
        Bug(
            "parcels/mine.rhai",
            "fn subdivide",
            "import \"parcels/helpers\" as helpers;\nfn subdivide",
            Told("parcels/mine.rhai:2:", "helpers"),
        ),
        // A warning: the author forgot to use it.
        Bug("buildings/mine.rhai", "* p.floor", "* 3.2", Told("buildings/mine.rhai:2:", "floor")),
        // Everything is refused.
        Bug(
            "constraints/mine.rhai",
            "if segment.to_x < -99 { segment.refuse(\"too near the rim\"); }",
            "segment.refuse(\"too near the rim\");",
            Told("constraints/mine.rhai", "refuse"),
        ),
        // The comparison is the wrong way round for half of the site: ends of streets tell who refused what.
        Bug(
            "constraints/mine.rhai",
            "segment.to_x < -99",
            "segment.to_x > 300",
            Why(ElementKind::Street, "too near the rim"),
        ),
        // Somebody else's rule has the part of this one.
        Bug("city.rhai", "rule(\"streets/mine\")", "rule(\"streets/organic\")", NotColoured("streets/mine")),
        // Feet for metres.
        Bug(
            "buildings/mine.rhai",
            "* p.floor,",
            "* p.floor * 3.28,",
            Console("city.height_median", |told| number(told) > 20.0),
        ),
        // A naught too many.
        Bug(
            "parcels/mine.rhai",
            "most_area: 800",
            "most_area: 8000",
            Console("city.parcel_median", |told| number(told) > 900.0),
        ),
        // Degrees given for a turn, so that nothing is square any more.
        Bug(
            "streets/mine.rhai",
            "tip.ahead(p.step);",
            "tip.ahead(p.step, #{ turn: 7 });",
            Console("city.order", |told| number(told) < 0.9),
        ),
        // A street's parameter in force that nobody meant.
        Bug(
            "city.rhai",
            "rule(\"streets/mine\")",
            "rule(\"streets/mine\", #{ step: 190 })",
            Why(ElementKind::Street, "minors.pattern.step  190"),
        ),
        // What a rule thinks is asked of itself.
        Bug(
            "buildings/mine.rhai",
            "if shape.area < 60",
            "print(`front ${shape.fronts(\"major\")}`); if shape.area < 60",
            Printed("front 0"),
        ),
        Bug(
            "parcels/mine.rhai",
            "block.recursive",
            "if block.rectangularity < 2 { mark(block.x, block.y); } block.recursive",
            Marked,
        ),
    ]
}

/// Something of a kind; of streets one that ends where others were refused, as far as one can tell.
fn some(city: &City, kind: ElementKind) -> Vec<Element> {
    let ids: Vec<geom::Id> = match kind {
        ElementKind::Street => {
            city.runs.iter().filter(|run| run.class == streets::Classes::MINOR).map(|run| run.id).collect()
        }
        ElementKind::Building => city.buildings.iter().map(|building| building.id).collect(),
        _ => city.parcels.iter().map(|parcel| parcel.id).collect(),
    };
    ids.into_iter().map(|id| Element { kind, id }).collect()
}

fn plant(city: &Path) {
    for kind in ["streets", "constraints", "parcels", "buildings"] {
        fs::create_dir_all(city.join(kind)).unwrap();
    }
    let files = [
        ("city.rhai", CITY),
        ("streets/mine.rhai", STREETS),
        ("constraints/mine.rhai", CONSTRAINTS),
        ("parcels/mine.rhai", PARCELS),
        ("buildings/mine.rhai", BUILDINGS),
    ];
    files.into_iter().for_each(|(file, text)| fs::write(city.join(file), text).unwrap());
}

/// Looks for a bug in the window; what was seen instead where it is not found.
fn look(window: &mut Harness<App>, found: &Found) -> Result<(), String> {
    let seen = |is_found: bool, instead: String| if is_found { Ok(()) } else { Err(instead) };
    match found {
        Found::Told(place, words) => {
            tab(window, "Problems");
            let state = window.state().state();
            let failed = state.failure.iter().flat_map(|failure| failure.faults.clone());
            let built = state.ready.iter().flat_map(|ready| ready.built.report.faults.clone());
            let all = format!("{:#?}", failed.chain(built).collect::<Vec<_>>());
            let is_told = window.query_all_by_label_contains(words).next().is_some();
            seen(is_told && window.query_all_by_label_contains(place).next().is_some(), all)
        }
        Found::Why(kind, words) => {
            let city = window.state().state().ready.as_ref().unwrap().built.city.clone();
            let mut last = String::new();
            for element in some(&city, *kind) {
                window.state_mut().state_mut().commands.push(Command::Select(Some(element)));
                settle(window);
                click(window, "Why is this here?");
                if window.query_all_by_label_contains(words).next().is_some() {
                    return Ok(());
                }
                last = format!(
                    "{:?}",
                    window.state().state().asked.done.as_ref().map(|answer| answer.as_ref().map(ToString::to_string))
                );
            }
            Err(last)
        }
        Found::Console(text, is_odd) => {
            click(window, "Console");
            type_into(window, "Rhai", text);
            click(window, "Run");
            let entry = window.state().state().console.entries.last().cloned().unwrap();
            seen(entry.value.as_deref().is_some_and(is_odd), format!("{entry:?}"))
        }
        Found::NotColoured(rule) => {
            let Ok(gpu) = viewer::render::Gpu::headless() else {
                println!("SKIPPED one: no graphics adapter");
                return Ok(());
            };
            let city = window.state().state().ready.as_ref().unwrap().built.city.clone();
            let map = viewer::scene::MapScene::of(&gpu, &city, Some(By::Rule), None);
            let names: Vec<&str> = map.legend.iter().map(|(name, _)| &name[..]).collect();
            seen(!names.is_empty() && !names.contains(rule), format!("{names:?}"))
        }
        Found::Printed(words) => {
            tab(window, "Problems");
            let report = &window.state().state().ready.as_ref().unwrap().built.report;
            let instead = format!("{:?} {:?}", report.prints, report.faults);
            seen(window.query_all_by_label_contains(words).next().is_some(), instead)
        }
        Found::Marked => {
            let report = &window.state().state().ready.as_ref().unwrap().built.report;
            seen(!report.marks.is_empty(), format!("{:?}", report.faults))
        }
    }
}

#[test]
fn twenty_planted_bugs_are_found_from_the_window_alone() {
    let folder = tempfile::tempdir().unwrap();
    let bugs = bugs();
    assert_eq!(bugs.len(), 20);
    // Without a bug nothing of all that is seen.
    let good = folder.path().join("good");
    plant(&good);
    let mut window = window();
    open(&mut window, &good);
    let clean = |window: &Harness<App>| {
        let state = window.state().state();
        let report = &state.ready.as_ref().unwrap().built.report;
        assert!(report.faults.is_empty() && state.failure.is_none(), "{:?} {:?}", report.faults, state.failure);
    };
    clean(&window);
    for (i, Bug(_, _, to, found)) in bugs.iter().enumerate() {
        assert!(look(&mut window, found).is_err(), "a good city looks as if it had bug {i}, {to}");
    }
    let mut missed = Vec::new();
    for (i, Bug(file, from, to, found)) in bugs.iter().enumerate() {
        let city = folder.path().join(format!("bug{i}"));
        plant(&city);
        let mut window = self::window();
        open(&mut window, &city);
        let path = city.join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file}: {from}");
        let planted = text.replacen(from, to, 1);
        fs::write(&path, &planted).unwrap();
        let name = path.to_string_lossy().into_owned();
        wait_for(&mut window, &format!("bug {i}"), |app| {
            app.state().is_idle() && app.state().text_of(&name).as_deref() == Some(&planted[..])
        });
        if let Err(instead) = look(&mut window, found) {
            missed.push(format!("bug {i}, {to}: {instead}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
