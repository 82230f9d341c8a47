//! Each map acts: 500 m of it changed do there what they say, and change nothing in quarters that cannot sense it.
//!
//! The site is a row of four quarters of 800 m × 1 km, and the window lies inside the eastern one. What decides about a
//! street lies at most [`REACH`] from it, so the window is sensed by quarters within that distance; and what grows in one
//! quarter may move ends of streets across its rim, so their neighbours may differ too. No other quarter can.

use city::measure::{Figure, Maps, Window, measure};
use city::{Cancel, City, Settings, Silent, Until, build, load};
use geom::{Angle, Point, Vec2};
use image::{ImageBuffer, Luma, Rgb, RgbImage};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use streets::Classes;
use tempfile::TempDir;

const SCRIPT: &str = r##"
let site = site("maps");
let old = site.map("old");
let lines = [line([[50, 50], [3250, 50], [3250, 1050], [50, 1050], [50, 50]])];
for x in [850, 1650, 2450] { lines.push(line([[x, 50], [x, 1050]])); }
let grid = rule("streets/grid", #{ heading: 0, block_length: 125, block_width: 80, x: 50, y: 50 });
city(#{
    site: site,
    barred: site.map("parks"),
    districts: site.districts("districts", #{ town: "#c0392b", harbour: "#2980b9" }),
    seed: 7,
    given: lines,
    minors: streets(#{
        goals: density(site.map("density"), #{ least: 500 }),
        pattern: PATTERN,
        constraints: rule("constraints/standard", #{ max_slope: 0.12 }),
        width: by_district(#{ harbour: 20 }, 14),
    }),
    parcels: rule("parcels/recursive"),
    buildings: rule("buildings/extruded"),
});
"##;
const BY_AGE: &str = r#"grid * old.invert()
    + rule("streets/radial", #{ centre: "given", x: 2930, y: 550, inner: 60, ring: 80, arc: 100 }) * old"#;
const BY_SLOPE: &str = r#"rule("streets/contour", #{ flat: 0.01 })"#;

/// Metres of a cell, and cells of a map from west to east and from south to north.
const CELL: f64 = 10.0;
const CELLS: [u32; 2] = [330, 110];
/// South-western and north-eastern corner of the window.
const WINDOW: [Vec2; 2] = [Vec2::new(2680.0, 300.0), Vec2::new(3180.0, 800.0)];
/// Metres: the longest proposal (130), what it may be extended by (30), and half a step of looking ahead.
const REACH: f64 = 200.0;

fn is_inside(at: Vec2) -> bool {
    at.cmpgt(WINDOW[0] + 0.01).all() && at.cmplt(WINDOW[1] - 0.01).all()
}

struct Place(TempDir);

impl Place {
    /// Even land that rises gently to the east: no water, no parks, one pattern, people and one district everywhere.
    fn new(pattern: &str) -> Self {
        let place = Self(tempfile::tempdir().expect("a folder"));
        fs::create_dir(place.0.path().join("maps")).expect("a folder");
        fs::write(place.0.path().join("city.rhai"), SCRIPT.replace("PATTERN", pattern)).expect("a script");
        place.map("elevation", 0.01, |at| 0.03 * at.x);
        for (name, value) in [("land", 1.0), ("parks", 0.0), ("old", 0.0), ("density", 1.0)] {
            place.mark(name, value, value);
        }
        place.district("c0392b");
        place
    }

    /// A map of 16 bits: a pixel is worth `scale`.
    fn map(&self, name: &str, scale: f64, value: impl Fn(Vec2) -> f64) {
        let at = |x: u32, y: u32| Vec2::new(f64::from(x) + 0.5, f64::from(CELLS[1] - y) - 0.5) * CELL;
        let pixel = |x, y| Luma([(value(at(x, y)) / scale).round() as u16]);
        let picture: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_fn(CELLS[0], CELLS[1], pixel);
        picture.save(self.0.path().join(format!("maps/{name}.png"))).expect("a picture");
        self.sidecar(name, &format!("{{\"pixel_size_m\": {CELL}, \"value\": {{\"scale\": {scale}}}}}"));
    }

    /// A map of a value from 0 to 1 (of people, 10 000 per km²), and of another one in the window.
    fn mark(&self, name: &str, outside: f64, inside: f64) {
        let most = if name == "density" { 10_000.0 } else { 1.0 };
        self.map(name, most / 65_535.0, |at| most * if is_inside(at) { inside } else { outside });
    }

    /// A map of districts: town, a colour in the window, and the harbour along the site's rim.
    fn district(&self, inside: &str) {
        let colour = |text: &str| Rgb([0, 2, 4].map(|i| u8::from_str_radix(&text[i..i + 2], 16).expect("hex")));
        let at = |x: u32, y: u32| Vec2::new(f64::from(x) + 0.5, f64::from(CELLS[1] - y) - 0.5) * CELL;
        let pixel = |x, y| {
            colour(if is_inside(at(x, y)) {
                inside
            } else if x < 3 {
                "2980b9"
            } else {
                "c0392b"
            })
        };
        let picture = RgbImage::from_fn(CELLS[0], CELLS[1], pixel);
        picture.save(self.0.path().join("maps/districts.png")).expect("a picture");
        self.sidecar("districts", &format!("{{\"pixel_size_m\": {CELL}}}"));
    }

    fn sidecar(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(format!("maps/{name}.json")), text).expect("a sidecar");
    }

    fn city(&self) -> City {
        let sources = load(self.0.path(), None).and_then(|loaded| loaded.read());
        let sources = sources.unwrap_or_else(|error| panic!("{error}"));
        let built =
            build(&sources, Settings { until: Until::Buildings, ..Settings::default() }, &Silent, &Cancel::default());
        let built = built.unwrap_or_else(|error| panic!("{error}"));
        assert!(!built.report.has_faults(), "{:?}", built.report.faults);
        (*built.city).clone()
    }

    /// A figure of `plat stats` for the window.
    fn figure(&self, city: &City, name: &str) -> f64 {
        let file = city::export::layout_file::parse_layout(&layout(city), self.0.path()).expect("our own layout");
        let maps = Maps::read(&self.0.path().join("maps"), None).expect("our own maps");
        let window = Window([WINDOW[0].x, WINDOW[0].y, WINDOW[1].x, WINDOW[1].y]);
        match measure(&file, &maps, Some(window)).expect("our own layout").get(name) {
            Some(Figure::Number(number)) => number,
            other => panic!("{name} is {other:?}"),
        }
    }
}

fn layout(city: &City) -> Vec<u8> {
    let mut bytes = Vec::new();
    city::export::geojson::write_layout(city, &mut bytes).expect("writing to memory does not fail");
    bytes
}

/// All positions of a geometry.
fn positions(coordinates: &Value, found: &mut Vec<Vec2>) {
    let list = coordinates.as_array().expect("coordinates");
    match list[..] {
        [Value::Number(ref x), Value::Number(ref y), ..] => {
            found.push(Vec2::new(x.as_f64().expect("metres"), y.as_f64().expect("metres")));
        }
        _ => list.iter().for_each(|inner| positions(inner, found)),
    }
}

/// Every feature of the layout, as it is written, that lies in a quarter which cannot sense the window. Quarters are
/// rectangles here: their bounds are their ground.
fn beyond(city: &City) -> BTreeMap<(String, String), String> {
    let corners = |polygon: &geom::Polygon| {
        let bounds = polygon.bounds().expect("a quarter has ground");
        [bounds.min.metres(), bounds.max.metres()]
    };
    let touch = |a: [Vec2; 2], b: [Vec2; 2]| a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all();
    let sensed = [WINDOW[0] - REACH, WINDOW[1] + REACH];
    let quarters: Vec<_> = city.quarters.iter().map(|quarter| corners(&quarter.polygon)).collect();
    let (near, rest): (Vec<_>, Vec<_>) = quarters.into_iter().partition(|quarter| touch(*quarter, sensed));
    let (_, beyond): (Vec<_>, Vec<_>) =
        rest.into_iter().partition(|quarter| near.iter().any(|near| touch(*quarter, *near)));
    assert_eq!((near.len(), beyond.len()), (1, 2), "one quarter senses the window, two cannot");
    let lies_beyond = |feature: &Value| {
        let mut all = Vec::new();
        positions(&feature["geometry"]["coordinates"], &mut all);
        beyond.iter().any(|quarter| all.iter().all(|&at| touch([at, at], *quarter)))
    };
    let text = String::from_utf8(layout(city)).expect("GeoJSON is UTF-8");
    let lines = text.lines().filter(|line| line.contains("\"kind\":")).map(|line| line.trim_end_matches(','));
    let features = lines.map(|line| (serde_json::from_str::<Value>(line).expect("a feature a line"), line.to_owned()));
    let key = |feature: &Value| ["kind", "id"].map(|key| feature["properties"][key].as_str().expect("text").to_owned());
    features.filter(|(feature, _)| lies_beyond(feature)).map(|(feature, line)| (key(&feature).into(), line)).collect()
}

/// The cities before and after a change to a map; what lies beyond must be the same.
fn before_and_after(place: &Place, change: impl FnOnce(&Place)) -> [City; 2] {
    let before = place.city();
    change(place);
    let after = place.city();
    let (one, other) = (beyond(&before), beyond(&after));
    for kind in ["street", "crossing", "quarter", "block", "parcel", "building"] {
        assert!(one.keys().any(|key| key.0 == kind), "no {kind} lies beyond");
    }
    assert!(one.len() > 2000, "{}", one.len());
    assert!(one == other, "quarters that cannot sense the window have changed");
    [before, after]
}

/// Places along minors, about a metre apart, and the headings there.
fn walk(city: &City) -> Vec<(Vec2, Angle)> {
    let mut places = Vec::new();
    for run in city.runs.iter().filter(|run| run.class == Classes::MINOR) {
        for pair in run.nodes.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|node| city.graph.at(node).metres());
            let steps = (b - a).length().ceil().max(1.0) as u32;
            let step = |k: u32| a.lerp(b, (f64::from(k) + 0.5) / f64::from(steps));
            places.extend((0..steps).map(|k| (step(k), Angle::of(b - a))));
        }
    }
    places
}

/// Metres of minor street in the window.
fn metres_inside(city: &City) -> usize {
    walk(city).iter().filter(|(at, _)| is_inside(*at)).count()
}

/// What streets may not lie on: none does, nothing is built there, and no block lies in it alone.
fn assert_bare(city: &City) {
    // Streets are looked at twice a cell, so that they may cut a corner by half of one.
    let is_well_inside =
        |at: Vec2| [Vec2::splat(CELL / 2.0), Vec2::splat(-CELL / 2.0)].iter().all(|&by| is_inside(at + by));
    assert!(!walk(city).iter().any(|(at, _)| is_well_inside(*at)), "a street on it");
    assert!(metres_inside(city) < 20, "{} m on it", metres_inside(city));
    let inside = |points: &[Point]| points.iter().all(|point| is_inside(point.metres()));
    assert!(!city.blocks.iter().any(|block| inside(&block.polygon.outer)), "a block on it");
    let touches = |points: &[Point]| points.iter().any(|point| is_inside(point.metres()));
    assert!(!city.buildings.iter().any(|building| touches(&building.footprint.outer)), "a building on it");
}

#[test]
fn water_keeps_streets_and_blocks_off() {
    let [before, after] = before_and_after(&Place::new(BY_AGE), |place| place.mark("land", 1.0, 0.0));
    assert!(metres_inside(&before) > 4000, "{}", metres_inside(&before));
    assert_bare(&after);
}

#[test]
fn parks_keep_streets_out() {
    let [before, after] = before_and_after(&Place::new(BY_AGE), |place| place.mark("parks", 0.0, 1.0));
    assert!(metres_inside(&before) > 4000, "{}", metres_inside(&before));
    assert_bare(&after);
    let is_park = |parcel: &&layout::Parcel| parcel.usage == layout::Use::Park;
    let parks: f64 = after.parcels.iter().filter(is_park).map(|parcel| parcel.polygon.area()).sum();
    assert!(parks > 0.9 * 500.0 * 500.0 && !before.parcels.iter().any(|parcel| is_park(&parcel)), "{parks} m2 of park");
}

#[test]
fn streets_grow_where_people_live() {
    let [before, after] = before_and_after(&Place::new(BY_AGE), |place| place.mark("density", 1.0, 0.01));
    // Ends of streets are asked, so those that come in from around reach in by one piece.
    assert!(metres_inside(&before) > 4000 && metres_inside(&after) < 1500, "{}", metres_inside(&after));
    let core = |city: &City| {
        walk(city)
            .iter()
            .filter(|(at, _)| (*at - WINDOW[0]).min_element() > 130.0 && (WINDOW[1] - *at).min_element() > 130.0)
            .count()
    };
    assert!(core(&before) > 500, "{}", core(&before));
    assert_eq!(core(&after), 0);
}

#[test]
fn weights_decide_which_pattern_grows() {
    let place = Place::new(BY_AGE);
    let [before, after] = before_and_after(&place, |place| place.mark("old", 0.0, 1.0));
    assert!(place.figure(&before, "order") >= 0.95 && place.figure(&after, "order") <= 0.2);
    // Degrees off the rings and rays around the middle of the window: the grid's are anything from 0 to 45.
    let off = |city: &City| {
        let middle = (WINDOW[0] + WINDOW[1]) / 2.0;
        let mut all: Vec<f64> = walk(city)
            .into_iter()
            .filter(|(at, _)| is_inside(*at))
            .map(|(at, heading)| ((heading - Angle::of(at - middle)).to_degrees() + 45.0).rem_euclid(90.0) - 45.0)
            .map(f64::abs)
            .collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    assert!(off(&before) > 12.0 && off(&after) < 5.0, "{} {}", off(&before), off(&after));
    let named = |city: &City| {
        let text = String::from_utf8(layout(city)).expect("GeoJSON is UTF-8");
        text.lines().any(|line| line.contains("streets/radial"))
    };
    assert!(!named(&before) && named(&after));
}

#[test]
fn districts_decide_what_differs_by_them() {
    let [before, after] = before_and_after(&Place::new(BY_AGE), |place| place.district("2980b9"));
    let widths = |city: &City| -> Vec<f64> {
        let inside = |run: &&streets::runs::Run| run.nodes.iter().all(|&node| is_inside(city.graph.at(node).metres()));
        let mut widths: Vec<_> = city.runs.iter().filter(inside).map(|run| f64::from(run.half_width) / 512.0).collect();
        widths.sort_by(f64::total_cmp);
        widths.dedup();
        widths
    };
    assert_eq!(widths(&before), [14.0]);
    assert!(widths(&after).contains(&20.0), "{:?}", widths(&after));
}

/// A hill of 45 m in the window, on the land that rises to the east.
fn hill(at: Vec2) -> f64 {
    let far = (at - (WINDOW[0] + WINDOW[1]) / 2.0).length() / 250.0;
    let rise = (1.0 - far * far).max(0.0);
    0.03 * at.x + 45.0 * rise * rise
}

#[test]
fn elevation_turns_streets_and_keeps_them_gentle() {
    let place = Place::new(BY_SLOPE);
    let [before, after] = before_and_after(&place, |place| place.map("elevation", 0.01, hill));
    let sources = load(place.0.path(), None).and_then(|loaded| loaded.read()).expect("the maps");
    let ground = sources.site.map("elevation").expect("a map").clone();
    // Both cities on the ground with the hill: how much of what is laid where it is steep keeps to its height.
    let level = |city: &City| {
        let steep = walk(city).into_iter().filter(|(at, _)| is_inside(*at) && ground.gradient(*at).length() > 0.1);
        let turns: Vec<f64> =
            steep.map(|(at, heading)| Angle::of(ground.gradient(at)).unit().dot(heading.unit()).abs()).collect();
        assert!(turns.len() > 500, "{} m where it is steep", turns.len());
        turns.iter().filter(|turn| **turn < 0.5).count() as f64 / turns.len() as f64
    };
    let (flat, hilly) = (level(&before), level(&after));
    assert!(hilly > 0.6 && hilly > flat + 0.1, "{hilly} follows the hill, {flat} before");
    for run in &after.runs {
        for pair in run.nodes.windows(2).filter(|_| run.class == Classes::MINOR) {
            let [a, b] = [pair[0], pair[1]].map(|node| after.graph.at(node).metres());
            let (rise, length) = (ground.bilinear(b) - ground.bilinear(a), (b - a).length());
            assert!(rise.abs() <= 0.12 * length + 0.02, "{} % at {a}", 100.0 * rise.abs() / length);
        }
    }
}
