//! Zones and greatest heights on a whole city: they act where their maps say, and nowhere else.

use city::{City, Settings, Silent, Site, Until, build, load};
use geom::{Bounds, Point, Raster, Vec2};
use layout::Use;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use suite::{features, shipped};

/// Metres of a map's cell.
const CELL: f64 = 10.0;

/// The middle of the lattice: 500 m by 500 m that hold blocks wholly and in part.
const WINDOW: (Vec2, Vec2) = (Vec2::new(1000.0, 1000.0), Vec2::new(1500.0, 1500.0));

/// A map of one value, with another in the window.
fn map(value: f32, inside: f32) -> Raster {
    let cell = |k: usize| Vec2::new((k % 300) as f64 + 0.5, 299.5 - (k / 300) as f64) * CELL;
    let is_inside = |at: Vec2| at.cmpge(WINDOW.0).all() && at.cmple(WINDOW.1).all();
    let values = (0..300 * 300).map(|k| if is_inside(cell(k)) { inside } else { value }).collect();
    Raster::new(300, 300, CELL, Vec2::ZERO, values).expect("a sound raster")
}

/// The lattice with rules by zone and more maps.
fn zoned(maps: Vec<(&str, Raster)>) -> City {
    let mut loaded = load(&shipped("lattice"), None).unwrap_or_else(|error| panic!("{error}"));
    let host = script::Host::new(Vec::new());
    loaded.plan.parcels = Some(host.rule("parcels/zoned").expect("the library has it"));
    loaded.plan.buildings = Some(host.rule("buildings/zoned").expect("the library has it"));
    let mut sources = loaded.read().unwrap_or_else(|error| panic!("{error}"));
    let mut site = Site::clone(&sources.site);
    site.maps.extend(maps.into_iter().map(|(name, map)| (name.to_owned(), Arc::new(map))));
    sources.site = Arc::new(site);
    let settings = Settings { threads: 2, until: Until::Buildings, ..Settings::default() };
    let built = build(&sources, settings, &Silent, &Default::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(!built.report.has_faults(), "{:?}", built.report.faults);
    (*built.city).clone()
}

fn window() -> Bounds {
    Bounds::between(Point::from_metres(WINDOW.0), Point::from_metres(WINDOW.1))
}

/// The parcels and buildings, as they are written, of blocks that lie wholly in the window, and of those that lie wholly
/// outside.
fn inside_and_outside(city: &City) -> [BTreeMap<(String, String), String>; 2] {
    let blocks = |counts: &dyn Fn(Bounds) -> bool| -> BTreeSet<geom::Id> {
        let counts = |block: &&layout::Block| block.polygon.bounds().is_some_and(counts);
        city.blocks.iter().filter(counts).map(|block| block.id).collect()
    };
    let lines = features(city);
    [
        blocks(&|bounds| window().contains(bounds.min) && window().contains(bounds.max)),
        blocks(&|bounds| !bounds.overlaps(&window())),
    ]
    .map(|blocks| {
        let parcels: BTreeSet<geom::Id> =
            city.parcels.iter().filter(|p| blocks.contains(&p.block)).map(|p| p.id).collect();
        let buildings = city.buildings.iter().filter(|b| parcels.contains(&b.parcel)).map(|b| b.id);
        let ids: BTreeSet<String> = parcels.iter().copied().chain(buildings).map(|id| id.to_string()).collect();
        let of_those = |((kind, id), _): &(&(String, String), &String)| {
            ["parcel", "building"].contains(&kind.as_str()) && ids.contains(id)
        };
        lines.iter().filter(of_those).map(|(key, line)| (key.clone(), line.clone())).collect()
    })
}

/// V5–V10 and V22, as the file shows them.
fn assert_valid(city: &City) {
    let mut bytes = Vec::new();
    city::export::geojson::write_layout(city, &mut bytes).expect("writing to memory does not fail");
    let layout =
        city::export::layout_file::parse_layout(&bytes, "memory".as_ref()).expect("our own layout is readable");
    let report = city::validate::check(&layout, Until::Buildings);
    assert!(report.is_valid(), "{report}");
    let built: BTreeSet<_> = city.parcels.iter().filter(|p| p.usage == Use::Built).map(|p| p.id).collect();
    assert!(city.buildings.iter().all(|building| built.contains(&building.parcel)), "a building on open land");
}

#[test]
fn zones_act_in_their_window_and_nowhere_else() {
    let before = zoned(vec![("zones", map(1.0, 1.0))]);
    let after = zoned(vec![("zones", map(1.0, 3.0))]);
    assert_valid(&after);
    let ([inside, outside], [new_inside, new_outside]) = (inside_and_outside(&before), inside_and_outside(&after));
    assert!(outside.len() > 5000 && outside == new_outside, "land outside the window has changed");
    assert!(
        inside.len() > 3 * new_inside.len(),
        "towers stand on larger parcels: {} {}",
        inside.len(),
        new_inside.len()
    );
    let highest = |city: &City| city.buildings.iter().map(|b| b.height).fold(0.0, f64::max);
    assert!(highest(&before) < 45.0 && highest(&after) > 60.0, "{} {}", highest(&before), highest(&after));
}

#[test]
fn no_building_is_higher_than_its_map_allows() {
    let zones = || ("zones", map(2.0, 2.0));
    let before = zoned(vec![zones(), ("max_height", map(26.5, 26.5))]);
    let limits = map(26.5, 9.25);
    let after = zoned(vec![zones(), ("max_height", limits.clone())]);
    assert_valid(&after);
    let ([inside, outside], [new_inside, new_outside]) = (inside_and_outside(&before), inside_and_outside(&after));
    assert!(outside.len() > 3000 && outside == new_outside, "land outside the window has changed");
    assert_eq!(inside.len(), new_inside.len());
    assert_ne!(inside, new_inside);
    for building in after.buildings.iter() {
        for (a, b) in building.footprint.edges() {
            let places = (0..40).map(|k| a.metres().lerp(b.metres(), f64::from(k) / 40.0));
            let least = places.map(|place| limits.nearest(place)).fold(f64::INFINITY, f64::min);
            assert!(building.height <= least, "{} m where {least} m are allowed", building.height);
        }
    }
}

#[test]
fn where_nothing_may_rise_nothing_is_built() {
    let city = zoned(vec![("zones", map(2.0, 2.0)), ("max_height", map(30.0, 0.0))]);
    let inner = Bounds { min: window().min, max: window().max }.grown(-1024 * CELL as i32);
    let stands_inside = |p: &Point| inner.contains(*p);
    assert!(city.buildings.len() > 1000);
    assert!(!city.buildings.iter().any(|building| building.footprint.outer.iter().any(stands_inside)));
}
