//! What builds keep changes nothing: a build with a cache gives the same files as one without, whatever was edited between.
//!
//! `PLAT_EDITS=200 PLAT_EDITS_OF=manhattan cargo test --release -p suite kept` edits a shipped city instead.

use city::export::{Format, MapOptions, Wanted, write_wanted};
use city::{Built, Cache, Cancel, Settings, Silent, build_with, load};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use suite::shipped;

const TOWN: &str = r##"
let site = site(#{
    size: [760, 640],
    density: |x, y| 9000 - hypot(x - 400, y - 300) * 12,
    parks: |x, y| x > 560 && y > 500,
    districts: |x, y| if x < 330 { "west" } else { "east" },
});
city(#{
    site: site,
    seed: 7,
    landmarks: [landmark(#{ name: "Hall", at: [400, 330], size: [60, 40], parcel: "built" })],
    majors: streets(#{
        pattern: rule("streets/main", #{ block_length: 300, block_width: 260 }),
        constraints: [rule("constraints/standard", #{ snap: 30 }), rule("constraints/shy")],
        width: 24,
    }),
    minors: streets(#{
        pattern: by_district(#{ west: rule("streets/lanes", #{ length: 70 }) }, rule("streets/main", #{ block_length: 90, block_width: 60 })),
        least_dead_end: 20,
        width: 12,
    }),
    parcels: rule("parcels/lots"),
    buildings: by_district(#{ west: rule("buildings/houses", #{ near: 40 }) }, rule("buildings/houses")),
    quarters: #{},
});
"##;

const SHY: &str = r#"//! Streets that keep off the far corner.
params(#{ far: metres(730).range(0, 5000).about("East of this no street") });
fn constrain(segment, p) { if segment.to_x > p.far { segment.refuse("too far east"); } }
"#;

const LOTS: &str = r#"//! Smaller lots near majors.
params(#{
    least: number(260).range(20, 5000).about("Area in m²"),
    near: metres(50).range(0, 500).about("Nearness"),
});
fn subdivide(block, p) {
    let least = if block.distance("major") < p.near { p.least } else { p.least * 1.5 };
    if block.density < 300 { return block.open(); }
    block.recursive(#{ least_area: least, most_area: least * 3, irregularity: 0.2 })
}
fn assign(parcel, p) { if parcel.area > 500 && parcel.chance(1) < 0.3 { parcel.tag("large"); } }
"#;

const HOUSES: &str = r#"//! Houses, higher near majors.
params(#{
    near: metres(60).range(0, 500).about("Nearness"),
    high: metres(18).range(3, 200).about("Height near majors"),
    setback: metres(1.5).range(0, 20).about("Kept free"),
});
fn build(shape, p) {
    if shape.area < 40 { return shape.none(); }
    let height = if shape.distance("major") < p.near { p.high } else { 7 };
    shape.extrude(height + shape.chance(2, 0, 3), #{ setback: p.setback })
}
"#;

/// Chance of a test: the same each time.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// A city in a folder of its own, and what its files were in the beginning.
struct Place {
    folder: tempfile::TempDir,
    texts: BTreeMap<PathBuf, String>,
    /// The ids of its quarters as they were last.
    quarters: Vec<geom::Id>,
}

impl Place {
    fn town() -> Self {
        let source = |name: &str| script::Host::new(Vec::new()).source(name).expect("a rule of the library").text;
        let files = [
            ("city.rhai", TOWN.to_owned()),
            ("streets/main.rhai", source("streets/grid")),
            ("streets/lanes.rhai", source("streets/organic")),
            ("constraints/standard.rhai", source("constraints/standard")),
            ("constraints/shy.rhai", SHY.to_owned()),
            ("parcels/lots.rhai", LOTS.to_owned()),
            ("buildings/houses.rhai", HOUSES.to_owned()),
        ];
        Self::with(&files.map(|(name, text)| (name.into(), text)))
    }

    /// A copy of a shipped city, with all rules of the library in it.
    fn copy_of(name: &str) -> Self {
        let mut files = Vec::new();
        let host = script::Host::new(Vec::new());
        for rule in host.names() {
            files.push((PathBuf::from(rule.clone() + ".rhai"), host.source(&rule).expect("a rule").text));
        }
        let mut folders = vec![shipped(name)];
        let folder = tempfile::tempdir().expect("a temporary folder");
        while let Some(from) = folders.pop() {
            for entry in fs::read_dir(from).expect("a folder") {
                let path = entry.expect("an entry").path();
                let inner = path.strip_prefix(shipped(name)).expect("inside").to_owned();
                match fs::read_to_string(&path) {
                    _ if path.is_dir() => folders.push(path),
                    Ok(text) => files.push((inner, text)),
                    Err(_) => {
                        fs::create_dir_all(folder.path().join(&inner).parent().expect("a parent")).expect("made");
                        fs::copy(&path, folder.path().join(inner)).expect("copied");
                    }
                }
            }
        }
        Self { folder, ..Self::with(&files) }.restored()
    }

    fn with(files: &[(PathBuf, String)]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        Self { folder, texts: files.iter().cloned().collect(), quarters: Vec::new() }.restored()
    }

    fn restored(self) -> Self {
        self.texts.iter().for_each(|(name, text)| self.write(name, text));
        self
    }

    fn write(&self, name: &Path, text: &str) {
        let path = self.folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("made");
        fs::write(path, text).expect("written");
    }

    /// Edits one of the files at random, as a person may; says how, and which.
    fn edit(&self, dice: &mut Dice) -> (&'static str, PathBuf) {
        let scripts: Vec<&PathBuf> =
            self.texts.keys().filter(|name| name.extension().is_some_and(|e| e == "rhai")).collect();
        let name = scripts[dice.below(scripts.len())];
        let text = fs::read_to_string(self.folder.path().join(name)).expect("read");
        let (what, text) = match dice.below(16) {
            0 => ("restored", self.texts[name].clone()),
            1 => ("comment", format!("{text}\n// {}", dice.below(1000))),
            2 => ("print", in_function(&text, "print(\"here\");", dice)),
            3 => ("mark", in_function(&text, "mark(10, 20);", dice)),
            4 => {
                ("fault", in_function(&text, "if p.least > 1e9 || 1 + 1 == 3 { throw \"no\"; } let _x = 3 % 7;", dice))
            }
            5 => ("throw", in_function(&text, "throw \"broken\";", dice)),
            6 => ("quarter", self.with_quarter(dice)),
            7 if !self.texts.contains_key(Path::new("maps/density.json")) => {
                ("seed", with_number(&self.texts[name], dice))
            }
            7 => {
                let name = Path::new("maps/density.json");
                let text = with_number(&self.texts[name], dice);
                self.write(name, &text);
                return ("number", name.to_owned());
            }
            _ => ("number", with_number(&text, dice)),
        };
        let name = if what == "quarter" { Path::new("city.rhai") } else { name.as_path() };
        self.write(name, &text);
        (what, name.to_owned())
    }

    /// The city's script with something else in one quarter.
    fn with_quarter(&self, dice: &mut Dice) -> String {
        let script = &self.texts[Path::new("city.rhai")];
        let Some(id) = self.quarters.get(dice.below(self.quarters.len())) else { return script.clone() };
        let own = match dice.below(4) {
            0 => format!("seed: {}", dice.below(100)),
            1 => format!("seed: {}, \"minors.width\": {}", dice.below(100), 8 + dice.below(8)),
            2 => "preset: preset(\"campus\")".to_owned(),
            _ => format!("preset: preset(\"village\"), seed: {}", dice.below(100)),
        };
        let quarters = format!("quarters: #{{ \"{id}\": #{{ {own} }} }},");
        let end = script.rfind("});").expect("a city");
        format!("{}    {quarters}\n{}", script[..end].replace("quarters: #{},\n", ""), &script[end..])
    }
}

/// Puts a statement at the start of a function that is asked of each element.
fn in_function(text: &str, statement: &str, dice: &mut Dice) -> String {
    let starts: Vec<usize> =
        text.match_indices("\nfn ").filter_map(|(at, _)| Some(at + text[at..].find('{')? + 1)).collect();
    let Some(&at) = starts.get(dice.below(starts.len())) else { return text.to_owned() };
    format!("{} {statement} {}", &text[..at], &text[at..])
}

/// Makes a number of a text larger or smaller.
fn with_number(text: &str, dice: &mut Dice) -> String {
    let starts_number = |at: usize| {
        let before = text[..at].chars().next_back().unwrap_or(' ');
        text[at..].starts_with(|c: char| c.is_ascii_digit()) && !(before.is_alphanumeric() || ".\"_".contains(before))
    };
    let starts: Vec<usize> = (0..text.len()).filter(|&at| text.is_char_boundary(at) && starts_number(at)).collect();
    let Some(&start) = starts.get(dice.below(starts.len())) else { return text.to_owned() };
    let length = text[start..].find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len() - start);
    let Ok(number) = text[start..start + length].trim_end_matches('.').parse::<f64>() else { return text.to_owned() };
    let factor = [0.8, 0.9, 1.1, 1.25][dice.below(4)];
    let changed =
        if number.fract() == 0.0 { (number * factor).round() } else { (number * factor * 1000.0).round() / 1000.0 };
    format!("{}{changed}{}", &text[..start], &text[start + length..])
}

/// Everything that is told and written of a city.
fn everything(built: &Built, cache: &Cache) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = serde_json::to_vec(&built.report).expect("JSON");
    let wanted = Wanted {
        map: &MapOptions { longest_side: 400, ..MapOptions::default() },
        formats: &Format::ALL,
        others: &[("report.json", &report)],
        cache,
        is_durable: false,
    };
    let files = write_wanted(&built.city, &wanted, folder.path(), &Cancel::default()).expect("written");
    let name = |path: &PathBuf| path.file_name().expect("a name").to_string_lossy().into_owned();
    files.iter().map(|path| (name(path), fs::read(path).expect("read"))).collect()
}

fn build(folder: &Path, cache: &Cache) -> Result<Built, String> {
    let sources = load(folder, None).and_then(|loaded| loaded.read_with(cache)).map_err(|error| error.to_string())?;
    build_with(&sources, Settings::default(), cache, &Silent, &Cancel::default()).map_err(|error| error.to_string())
}

#[test]
fn a_build_with_a_cache_is_as_one_without_after_any_edit() {
    let edits = std::env::var("PLAT_EDITS").ok().and_then(|edits| edits.parse().ok()).unwrap_or(16);
    let mut place = std::env::var("PLAT_EDITS_OF").map_or_else(|_| Place::town(), |name| Place::copy_of(&name));
    let kept = tempfile::tempdir().expect("a temporary folder");
    let open = || Cache::on_disk(kept.path(), 200 << 20).expect("a cache");
    let (mut cache, mut dice) = (open(), Dice(5));
    let mut cities = BTreeMap::<Vec<u8>, usize>::new();
    for edit in 0..=edits {
        let (how, file) = if edit == 0 { ("nothing yet", PathBuf::new()) } else { place.edit(&mut dice) };
        let how = format!("{how} in {}", file.display());
        if edit % 7 == 3 {
            // Another program takes over.
            cache.flush();
            cache = open();
        }
        match (build(place.folder.path(), &cache), build(place.folder.path(), &Cache::none())) {
            (Ok(kept), Ok(fresh)) => {
                place.quarters = fresh.city.quarters.iter().map(|quarter| quarter.id).collect();
                let (kept, fresh) = (everything(&kept, &cache), everything(&fresh, &Cache::none()));
                for (name, bytes) in &fresh {
                    assert!(kept.get(name) == Some(bytes), "edit {edit}: {how}: {name} is another one");
                }
                *cities.entry(fresh["layout.geojson"].clone()).or_default() += 1;
            }
            (Err(kept), Err(fresh)) => {
                assert_eq!(kept, fresh, "edit {edit}: {how}");
                // Mended before anything else is done.
                place.write(&file, &place.texts[&file]);
            }
            (kept, fresh) => {
                panic!(
                    "edit {edit}: {how}: with a cache {:?}, without {:?}",
                    kept.map(|_| "built"),
                    fresh.map(|_| "built")
                )
            }
        }
    }
    assert!(cities.len() * 4 > edits, "the edits changed something: {} cities", cities.len());
    assert_eq!(cache.problems(), Vec::<String>::new());
}

#[test]
fn rules_in_vain_are_warned_of_each_time() {
    let script = fs::read_to_string(shipped("lattice").join("city.rhai")).expect("read");
    let grid = "rule(\"streets/grid\", #{ heading: 0, block_length: 200, block_width: 100 })";
    assert!(script.contains(grid));
    for (name, pattern, text) in [
        ("streets/mine.rhai", "rule(\"streets/mine\")", "fn propose(tip, p) { let _x = tip.x; }\n"),
        (
            "constraints/mine.rhai",
            "rule(\"streets/grid\"), constraints: [rule(\"constraints/standard\"), rule(\"constraints/mine\")]",
            "fn constrain(segment, p) { segment.refuse(\"never\"); }\n",
        ),
    ] {
        let place = Place::copy_of("lattice");
        place.write(Path::new("city.rhai"), &script.replace(grid, pattern));
        place.write(Path::new(name), text);
        let (cache, parcels) = (Cache::in_memory(), Path::new("parcels/recursive.rhai"));
        for edit in 0..3 {
            place.write(parcels, &format!("{}// {edit}\n", place.texts[parcels]));
            let faults = |cache: &Cache| build(place.folder.path(), cache).expect("built").report.faults;
            let (kept, fresh) = (faults(&cache), faults(&Cache::none()));
            assert!(fresh.iter().any(|fault| fault.file.ends_with(name)), "{name}: {fresh:?}");
            assert_eq!(format!("{kept:?}"), format!("{fresh:?}"), "{name}");
        }
    }
}
