//! Districts in city scripts and in rules.

use crate::common::{city, headline, rule, tip};
use buildings::{Envelope, Setbacks};
use geom::{Bounds, Point, Polygon, Seed, Vec2};
use script::{
    BlockContext, BuildingChoice, BuildingPattern, DistrictPlan, Faults, MapRef, ParcelChoice, ParcelPattern,
    ShapeContext, StreetPattern,
};
use std::sync::Arc;
use streets::growth::{Fields, GrowthRules};
use streets::{Classes, Districts};

fn plan(districts: &str) -> Result<Option<DistrictPlan>, script::Fault> {
    let text = format!("let site = site(\"maps\");\ncity(#{{\n  site: site,\n  districts: {districts}\n}});");
    city(&text).map(|evaluated| evaluated.plan.districts)
}

#[test]
fn colours_and_files_are_read() {
    let map = MapRef { name: "districts".into() };
    let told =
        plan("site.districts(\"districts.png\", #{ \"old town\": \"#c0392b\", none: \"#ffffff\" })").expect("fine");
    let legend = [("none".to_owned(), [255; 3]), ("old town".to_owned(), [0xc0, 0x39, 0x2b])].into();
    assert_eq!(told, Some(DistrictPlan::Map { map: map.clone(), legend }));
    assert_eq!(told.expect("told").names(), ["old town"]);
    let told = plan("site.districts(\"districts\")").expect("fine");
    assert_eq!(told, Some(DistrictPlan::Map { map, legend: Default::default() }));
    let told = plan("districts_from(\"areas/districts.geojson\")").expect("fine");
    assert_eq!(told, Some(DistrictPlan::File("areas/districts.geojson".into())));
}

#[test]
fn mistakes_are_placed() {
    let says = |districts: &str| headline(&plan(districts).expect_err("wrong"));
    assert_eq!(
        says("3"),
        "city.rhai:4:3: `districts` must be site.districts(…) or districts_from(…), not a whole number"
    );
    assert_eq!(says("site.districts(\"distrikts\")"), "city.rhai:4:19: the site has no map `distrikts`");
    assert_eq!(
        says("site.districts(\"districts\", #{ a: \"#ff0000\", b: \"red\" })"),
        "city.rhai:4:59: `b` must be a colour such as #c0ffee, not `red`"
    );
    assert_eq!(
        says("site.districts(\"districts\", #{ a: \"#ff0000\", b: \"#FF0000\" })"),
        "city.rhai:4:59: `a` and `b` have the same colour #FF0000"
    );
    assert_eq!(says("site.districts(\"districts\", #{})"), "city.rhai:4:19: the legend names no district");
    assert_eq!(says("districts_from(\"d.shp\")"), "city.rhai:4:14: `d.shp` is no file of districts");
    assert_eq!(
        says("districts_from(\"../d.json\")"),
        "city.rhai:4:14: `../d.json` is not a file below the script's folder"
    );
}

fn harbour() -> Arc<Districts> {
    let corner = |x, y| Point::from_metres(Vec2::new(x, y));
    let square = Polygon::rectangle(Bounds::between(corner(0.0, 0.0), corner(500.0, 500.0)));
    Arc::new(Districts::of_areas(vec!["harbour".into()], vec![(0, square)]))
}

#[test]
fn rules_know_the_district_of_their_place() {
    let faults = Arc::new(Faults::default());
    let streets = rule("fn propose(tip, p) { tip.ahead(if tip.district == \"harbour\" { 90 } else { 50 }); }");
    let streets = StreetPattern::new(streets.expect("loads"), 0, Arc::new(Classes::default()), faults.clone());
    let length_at = |x: f64| {
        let mut tip = tip(0.0);
        tip.fields = Arc::new(Fields { districts: harbour(), ..(*tip.fields).clone() });
        tip.at = Point::from_metres(Vec2::new(x, 100.0));
        streets.propose(&mut tip);
        tip.slots.ahead.map(|slot| slot.length)
    };
    assert_eq!([length_at(100.0), length_at(600.0)], [Some(90.0), Some(50.0)]);
    let (seed, place) = (Seed(1), Vec2::ZERO);
    let parcels =
        rule("fn subdivide(block, p) { if block.district == \"harbour\" { block.open() } else { block.whole() } }");
    let parcels = ParcelPattern::new(parcels.expect("loads"), faults.clone());
    let buildings = rule("fn build(shape, p) { if shape.district == \"\" { shape.none() } else { shape.extrude(9) } }");
    let buildings = BuildingPattern::new(buildings.expect("loads"), faults.clone());
    let choices = ["harbour", ""].map(|district| {
        let district = district.to_owned();
        let block = BlockContext { place, district: district.clone(), ..BlockContext::bare(900.0, seed) };
        let shape = ShapeContext { place, district, ..ShapeContext::bare(900.0, seed) };
        (parcels.choose(block), buildings.choose(shape))
    });
    let raised = BuildingChoice::Extrude(Envelope { height: 9.0, setbacks: Setbacks::Even(0.0), coverage: 1.0 });
    assert_eq!(choices, [(ParcelChoice::Open, raised), (ParcelChoice::Whole, BuildingChoice::None)]);
    assert!(faults.is_empty(), "{:?}", faults.sorted());
}
