use super::*;
use crate::sources::Projection;
use geom::Vec2;
use proptest::prelude::*;
use serde_json::json;

fn bounds() -> Bounds {
    Bounds::between(Point::new(0, 0), Point::from_metres(Vec2::splat(1000.0)))
}

fn metres(features: Value) -> Result<DistrictFile, SourceError> {
    let file = json!({"type": "FeatureCollection", "plat": {"units": "m"}, "features": features});
    parse_districts(Path::new("d.geojson"), file.to_string().as_bytes(), None, bounds())
}

fn feature(name: &str, rings: Value) -> Value {
    json!({"type": "Feature", "properties": {"name": name}, "geometry": {"type": "Polygon", "coordinates": rings}})
}

fn square(x: f64, y: f64, side: f64) -> Value {
    json!([[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]])
}

fn areas(file: &DistrictFile) -> Vec<(String, f64)> {
    file.districts.areas().into_iter().map(|area| (area.name, area.polygon.area())).collect()
}

fn at(file: &DistrictFile, x: f64, y: f64) -> String {
    file.districts.name_at(Vec2::new(x, y)).to_owned()
}

#[test]
fn polygons_with_holes_are_districts() {
    let file = metres(json!([
        feature("b", json!([square(0.0, 0.0, 100.0), square(40.0, 40.0, 20.0)])),
        feature("a", json!([square(200.0, 0.0, 50.0)]))
    ]));
    let file = file.unwrap();
    assert_eq!(areas(&file), [("a".to_owned(), 2500.0), ("b".to_owned(), 9600.0)]);
    assert_eq!([at(&file, 10.0, 10.0), at(&file, 50.0, 50.0), at(&file, 210.0, 10.0)], ["b", "", "a"]);
    assert!(file.warnings.is_empty());
}

#[test]
fn the_first_keeps_shared_ground_and_it_is_told() {
    let file = metres(json!([
        feature("first", json!([square(0.0, 0.0, 100.0)])),
        feature("second", json!([square(50.0, 0.0, 100.0)]))
    ]))
    .unwrap();
    assert_eq!(areas(&file), [("first".to_owned(), 10_000.0), ("second".to_owned(), 5000.0)]);
    assert_eq!(file.warnings, ["feature 2, `second`, overlaps `first` on 5000 m²: the ground stays with `first`"]);
    assert_eq!(at(&file, 75.0, 50.0), "first");
}

#[test]
fn several_polygons_of_one_name_are_one_district() {
    let two = json!({"type": "Feature", "properties": {"name": "a"}, "geometry": {"type": "MultiPolygon",
        "coordinates": [[square(0.0, 0.0, 10.0)], [square(100.0, 0.0, 10.0)]]}});
    let file = metres(json!([two, feature("a", json!([square(10.0, 0.0, 10.0)]))])).unwrap();
    assert_eq!(areas(&file), [("a".to_owned(), 200.0), ("a".to_owned(), 100.0)]);
    assert!(file.warnings.is_empty());
}

#[test]
fn what_lies_outside_the_site_is_cut_off() {
    let file = metres(json!([
        feature("a", json!([square(900.0, 900.0, 300.0)])),
        feature("b", json!([square(5000.0, 0.0, 10.0)]))
    ]))
    .unwrap();
    assert_eq!(areas(&file), [("a".to_owned(), 10_000.0)]);
    assert_eq!(file.warnings, ["feature 2, `b`, lies outside the site"]);
    let error = metres(json!([feature("b", json!([square(5000.0, 0.0, 10.0)]))])).unwrap_err();
    assert!(error.to_string().contains("no district on the site; feature 1, `b`, lies outside"), "{error}");
}

#[test]
fn degrees_are_laid_into_the_frame_of_the_site() {
    let frame =
        Frame { projection: Projection::from_crs("EPSG:32618").unwrap(), origin: Vec2::new(585_000.0, 4_511_000.0) };
    let ring = json!([[-73.99, 40.75], [-73.985, 40.75], [-73.985, 40.755], [-73.99, 40.75]]);
    let file = json!({"type": "FeatureCollection", "features": [feature("a", json!([ring]))]}).to_string();
    let parse = |frame| parse_districts(Path::new("d.geojson"), file.as_bytes(), frame, bounds());
    let place = frame.local(-73.986, 40.751).unwrap();
    assert_eq!(parse(Some(frame)).unwrap().districts.name_at(place), "a");
    let error = parse(None).unwrap_err();
    assert!(error.to_string().contains("where the site lies on Earth is not known"), "{error}");
}

#[test]
fn wrong_files_are_told() {
    let says = |features: Value| metres(features).unwrap_err().to_string();
    assert!(says(json!([])).contains("no district on the site"));
    let nameless = json!({"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [square(0.0, 0.0, 9.0)]}});
    assert!(says(json!([nameless])).contains("feature 1: has no property `name`"));
    assert!(
        says(json!([feature("a", json!([[[0, "x"]]]))])).contains("feature 1, position 1: [0,\"x\"] is not a pair")
    );
    assert!(says(json!([feature("a", json!([]))])).contains("feature 1: has no ring"));
    assert!(says(json!([feature("a", json!([[[0, 0], [1e9, 0], [0, 1]]]))])).contains("more than 524 km"));
    let file = parse_districts(Path::new("d.geojson"), b"{\n \"type\": 3,", None, bounds()).unwrap_err();
    assert!(file.to_string().starts_with("d.geojson:2:"), "{file}");
    let line = json!({"type": "Feature", "properties": {"name": "a"}, "geometry": {"type": "LineString", "coordinates": [[0, 0], [1, 1]]}});
    let file = metres(json!([line, feature("b", json!([square(0.0, 0.0, 9.0)]))])).unwrap();
    assert_eq!(file.warnings, ["feature 1 is left out: its geometry is LineString, not a Polygon"]);
}

#[test]
fn a_crossed_ring_is_mended() {
    let bow = json!([[0, 0], [100, 100], [100, 0], [0, 100], [0, 0]]);
    let file = metres(json!([feature("a", json!([bow]))])).unwrap();
    assert!(file.warnings[0].contains("crosses itself"), "{:?}", file.warnings);
    assert!(file.districts.areas().iter().all(|area| area.polygon.is_valid()));
}

proptest! {
    #[test]
    fn any_squares_become_valid_ground_of_one_district_each(
        squares in prop::collection::vec((0u8..4, -100.0..1000.0f64, -100.0..1000.0f64, 1.0..600.0f64), 1..12),
    ) {
        let features: Vec<Value> = squares.iter()
            .map(|(name, x, y, side)| feature(&format!("d{name}"), json!([square(*x, *y, *side)])))
            .collect();
        let Ok(file) = metres(json!(features)) else { return Ok(()) };
        let areas = file.districts.areas();
        for (i, area) in areas.iter().enumerate() {
            prop_assert!(area.polygon.is_valid());
            for other in &areas[..i] {
                let shared = boolean::intersection(std::slice::from_ref(&area.polygon), std::slice::from_ref(&other.polygon));
                prop_assert!(shared.iter().map(Polygon::area).sum::<f64>() < 1.0);
            }
        }
    }
}
