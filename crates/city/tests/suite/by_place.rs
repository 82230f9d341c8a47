//! Districts and parameters that differ by place, from files on disk to the finished city.

use city::{Built, Cancel, City, LoadError, Settings, Silent, Until, build, load};
use geom::{Point, Vec2};
use image::{GrayImage, Luma, Rgb, RgbImage};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use streets::Classes;
use tempfile::TempDir;

/// A site of 32 × 22 pixels of 50 m with three quarters of 500 m × 1 km side by side.
const SCRIPT: &str = r##"
let site = site("maps");
let lines = [line([[50, 50], [1550, 50], [1550, 1050], [50, 1050], [50, 50]])];
for x in [550, 1050] { lines.push(line([[x, 50], [x, 1050]])); }
city(#{
    site: site,
    districts: DISTRICTS,
    given: lines,
    minors: streets(#{
        pattern: rule("streets/grid", #{ heading: 0, block_length: 125, block_width: site.map("width").between(60, 140) }),
        width: by_district(#{ west: 20, east: site.map("width").between(10, 11) }, 14),
    }),
    parcels: by_district(#{ west: rule("parcels/recursive", #{ most_area: 400 }) }, rule("parcels/recursive", #{ most_area: 2500 })),
    buildings: by_district(#{ east: rule("buildings/extruded", #{ low: 30, high: 30, spread: 0 }) }),
});
"##;

const LEGEND: &str = r##"site.districts("districts", #{ west: "#c0392b", east: "#2980b9", none: "#ffffff" })"##;
const SWAPPED: &str = r##"site.districts("districts", #{ east: "#c0392b", west: "#2980b9", none: "#ffffff" })"##;

struct Place(TempDir);

impl Place {
    fn new(districts: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("maps")).expect("a folder");
        fs::write(folder.path().join("city.rhai"), SCRIPT.replace("DISTRICTS", districts)).expect("a script");
        let place = Self(folder);
        // The western and the eastern quarter are districts; the one between is none.
        let colour = |x: u32| match x {
            0..11 => [0xc0, 0x39, 0x2b],
            11..21 => [255; 3],
            _ => [0x29, 0x80, 0xb9],
        };
        let picture = RgbImage::from_fn(32, 22, |x, _| Rgb(colour(x)));
        picture.save(place.0.path().join("maps/districts.png")).expect("a picture");
        place.sidecar("districts", "{\"pixel_size_m\": 50}");
        place.width(|_, _| 128);
        place
    }

    fn sidecar(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(format!("maps/{name}.json")), text).expect("a sidecar");
    }

    fn width(&self, grey: impl Fn(u32, u32) -> u8) {
        let picture = GrayImage::from_fn(32, 22, |x, y| Luma([grey(x, y)]));
        picture.save(self.0.path().join("maps/width.png")).expect("a picture");
        self.sidecar("width", "{\"pixel_size_m\": 50, \"value\": {\"scale\": 0.00392156862745098}}");
    }

    fn build(&self, set: &[&str]) -> Result<Built, LoadError> {
        let mut loaded = load(self.0.path(), None)?;
        set.iter().for_each(|assignment| loaded.set(assignment).expect("a parameter"));
        let settings = Settings { until: Until::Buildings, ..Settings::default() };
        Ok(build(&loaded.read()?, settings, &Silent, &Cancel::default()).expect("a city"))
    }

    fn city(&self) -> City {
        let built = self.build(&[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(!built.report.has_faults(), "{:?}", built.report.faults);
        (*built.city).clone()
    }
}

/// Widths in metres of minors, rounded, in the western, middle and eastern quarter.
fn widths(city: &City) -> [BTreeSet<i64>; 3] {
    let mut found: [BTreeSet<i64>; 3] = Default::default();
    for run in city.runs.iter().filter(|run| run.class == Classes::MINOR) {
        let ends = [run.nodes.first(), run.nodes.last()].map(|node| city.graph.at(*node.expect("an end")).metres());
        let x = (ends[0].x + ends[1].x) / 2.0;
        let part = if x < 550.0 {
            0
        } else if x < 1050.0 {
            1
        } else {
            2
        };
        found[part].insert((f64::from(run.half_width) * 2.0 / 1024.0).round() as i64);
    }
    found
}

/// Mean area of parcels in m², and number of buildings, in the western, middle and eastern quarter.
fn land(city: &City) -> [(f64, usize); 3] {
    let part = |x: f64| {
        if x < 550.0 {
            0
        } else if x < 1050.0 {
            1
        } else {
            2
        }
    };
    let mut sums = [(0.0, 0usize, 0usize); 3];
    for parcel in city.parcels.iter() {
        let own = &mut sums[part(parcel.polygon.centroid().x)];
        *own = (own.0 + parcel.polygon.area(), own.1 + 1, own.2);
    }
    for building in city.buildings.iter() {
        sums[part(building.footprint.centroid().x)].2 += 1;
    }
    sums.map(|(area, parcels, buildings)| (area / parcels.max(1) as f64, buildings))
}

#[test]
fn districts_have_their_own_widths_parcels_and_buildings() {
    let city = Place::new(LEGEND).city();
    assert_eq!(widths(&city), [BTreeSet::from([20]), BTreeSet::from([14]), BTreeSet::from([11])]);
    let [west, middle, east] = land(&city);
    assert!(west.0 < 400.0 && middle.0 > 600.0 && east.0 > 600.0, "{west:?} {middle:?} {east:?}");
    assert!(west.1 == 0 && middle.1 == 0 && east.1 > 100, "{west:?} {middle:?} {east:?}");
    assert!(city.buildings.iter().all(|building| building.height == 96.0));
}

#[test]
fn swapping_two_colours_swaps_the_districts() {
    let (one, other) = (Place::new(LEGEND).city(), Place::new(SWAPPED).city());
    let [west, middle, east] = widths(&one);
    assert_eq!(widths(&other), [east, middle, west]);
    let ([west, _, east], [now_west, _, now_east]) = (land(&one), land(&other));
    assert!(now_west.0 > 1.5 * west.0 && now_east.0 < east.0 / 1.5, "{west:?} {east:?} {now_west:?} {now_east:?}");
    assert!(now_west.1 > 100 && now_east.1 == 0);
}

#[test]
fn layouts_carry_districts_whose_areas_add_up() {
    let city = Place::new(LEGEND).city();
    let areas: BTreeMap<_, _> =
        city.districts.iter().map(|area| (area.name.clone().expect("a name"), area.polygon.area())).collect();
    assert_eq!(areas, BTreeMap::from([("east".to_owned(), 550.0 * 1100.0), ("west".to_owned(), 550.0 * 1100.0)]));
    let mut bytes = Vec::new();
    city::export::geojson::write_layout(&city, &mut bytes).expect("written");
    let text = String::from_utf8(bytes).expect("text");
    let districts: Vec<&str> = text.lines().filter(|line| line.contains("\"kind\":\"district\"")).collect();
    assert_eq!(districts.len(), 2);
    assert!(districts.iter().any(|line| line.contains("\"name\":\"west\"")), "{districts:?}");
}

/// Every parcel and minor street well west of the eastern quarter, as text: along the major between two quarters the
/// ends of streets of both sides are drawn together, so that the blocks on it may see the other side.
fn outside_the_east(city: &City) -> Vec<String> {
    let parcels = city.parcels.iter().filter(|parcel| parcel.polygon.centroid().x < 900.0);
    let mut all: Vec<String> = parcels.map(|parcel| format!("{parcel:?}")).collect();
    for run in city.runs.iter().filter(|run| run.class == Classes::MINOR) {
        let points: Vec<Point> = run.nodes.iter().map(|&node| city.graph.at(node)).collect();
        if points.iter().all(|point| point.metres().x <= 900.0) {
            all.push(format!("{:?} {points:?} {}", run.id, run.half_width));
        }
    }
    all
}

#[test]
fn a_changed_window_of_a_map_changes_only_the_quarter_that_sees_it() {
    let place = Place::new(LEGEND);
    let before = place.city();
    // 300 m × 500 m in the middle of the eastern quarter.
    place.width(|x, y| if (23..29).contains(&x) && (6..16).contains(&y) { 0 } else { 128 });
    let after = place.city();
    let (one, other) = (outside_the_east(&before), outside_the_east(&after));
    assert!(one.len() > 500, "{}", one.len());
    assert!(one == other, "the window is seen from the other quarters");
    let in_east = |city: &City| {
        let crossings = city.graph.nodes_unsorted().map(|(_, node)| node.at.metres());
        crossings.filter(|at| at.cmpgt(Vec2::new(1060.0, 60.0)).all() && at.x < 1540.0 && at.y < 1040.0).count()
    };
    assert!(in_east(&after) > in_east(&before) + 10, "{} {}", in_east(&after), in_east(&before));
}

#[test]
fn what_is_set_stands_above_maps_and_reaches_rules_of_districts() {
    let place = Place::new(LEGEND);
    let set = ["minors.pattern.block_width=100", "parcels.west.most_area=3000"];
    let city = place.build(&set).unwrap_or_else(|error| panic!("{error}")).city;
    place.width(|_, _| 0);
    let other = place.build(&["minors.pattern.block_width=100"]).unwrap_or_else(|error| panic!("{error}")).city;
    let nodes = |city: &City| city.graph.nodes_unsorted().map(|(_, node)| node.at).collect::<BTreeSet<Point>>();
    assert_eq!(nodes(&city), nodes(&other));
    assert!(land(&city)[0].0 > 2.0 * land(&other)[0].0);
}

#[test]
fn mistakes_are_told_before_anything_is_built() {
    let says = |districts: &str, change: &dyn Fn(&Place, &str)| {
        let place = Place::new(districts);
        change(&place, SCRIPT);
        place.build(&[]).map(|_| ()).expect_err("wrong").to_string()
    };
    let rewrite = |from: &'static str, to: &'static str| {
        move |place: &Place, script: &str| {
            let script = script.replace("DISTRICTS", LEGEND).replace(from, to);
            fs::write(place.0.path().join("city.rhai"), script).expect("a script");
        }
    };
    let error = says(LEGEND, &rewrite("between(60, 140)", "scale(10)"));
    assert!(error.contains("city.rhai: minors.pattern: `block_width` must be a number from 20 to 5000 m"), "{error}");
    let error = says(LEGEND, &rewrite("#{ west: 20,", "#{ wset: 20,"));
    assert!(error.contains("minors: `width` differs in `wset`") && error.contains("did you mean `west`?"), "{error}");
    let error = says(LEGEND, &rewrite("#{ west: rule", "#{ wset: rule"));
    assert!(error.contains("parcels differs in `wset`"), "{error}");
    let error = says(LEGEND, &rewrite("most_area: 2500", "most_area: site.map(\"wide\")"));
    assert!(error.contains("the site has no map `wide`"), "{error}");
    let error = says("districts_from(\"d.geojson\")", &|_, _| {});
    assert!(error.contains("d.geojson: cannot be read"), "{error}");
    let error = says("site.districts(\"districts\")", &|_, _| {});
    assert!(error.contains("districts.png: has no legend"), "{error}");
}

/// The share of minor street in a part of the site that runs within 1° of an axis.
fn axial_share(city: &City, part: impl Fn(f64) -> bool) -> f64 {
    let (mut all, mut axial) = (0.0, 0.0);
    for run in city.runs.iter().filter(|run| run.class == Classes::MINOR) {
        for pair in run.nodes.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|node| city.graph.at(node).metres());
            if part(a.x) && part(b.x) {
                let (length, least) = ((b - a).length(), (b - a).abs().min_element());
                all += length;
                axial += if least < 0.0175 * length { length } else { 0.0 };
            }
        }
    }
    axial / all
}

#[test]
fn districts_have_street_patterns_of_their_own() {
    let place = Place::new(LEGEND);
    let own = "pattern: by_district(#{ west: rule(\"streets/grid\", #{ heading: 30 }) }, rule(\"streets/grid\", #{ heading: 0";
    let script = SCRIPT.replace("DISTRICTS", LEGEND).replace("pattern: rule(\"streets/grid\", #{ heading: 0", own);
    let script = script.replace("between(60, 140) }),", "between(60, 140) })),");
    fs::write(place.0.path().join("city.rhai"), script).expect("a script");
    let city = place.city();
    let (west, rest) = (axial_share(&city, |x| x < 540.0), axial_share(&city, |x| x > 560.0));
    assert!(west < 0.1 && rest > 0.95, "{west} {rest}");
}

#[test]
fn polygons_of_a_file_are_districts_too() {
    let place = Place::new("districts_from(\"d.geojson\")");
    let square = |name: &str, x: i32| {
        let far = x + 500;
        format!(
            r#"{{"type": "Feature", "properties": {{"name": "{name}"}}, "geometry": {{"type": "Polygon",
            "coordinates": [[[{x}, 0], [{far}, 0], [{far}, 1100], [{x}, 1100], [{x}, 0]]]}}}}"#
        )
    };
    let (west, east) = (square("west", 50), square("east", 1050));
    let file = format!(r#"{{"type": "FeatureCollection", "plat": {{"units": "m"}}, "features": [{west}, {east}]}}"#);
    fs::write(place.0.path().join("d.geojson"), file).expect("a file");
    let city = place.city();
    assert_eq!(widths(&city), [BTreeSet::from([20]), BTreeSet::from([14]), BTreeSet::from([11])]);
    assert_eq!(city.districts.len(), 2);
}
