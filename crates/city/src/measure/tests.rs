use super::*;
use crate::export::geojson::write_layout;
use crate::export::layout_file::{Geometry, parse_layout};
use crate::export::samples::small_city;
use std::path::Path;

fn layout() -> LayoutFile {
    let mut bytes = Vec::new();
    write_layout(&small_city(), &mut bytes).unwrap();
    parse_layout(&bytes, Path::new("x.geojson")).unwrap()
}

/// A layout of streets alone: ends by name, places, whether on a bridge.
fn streets(lines: &[(&str, &str, &[[f64; 2]])]) -> LayoutFile {
    let features = lines.iter().enumerate().map(|(i, (from, to, line))| {
        serde_json::json!({
            "type": "Feature",
            "properties": { "kind": "street", "id": i.to_string(), "from": from, "to": to },
            "geometry": { "type": "LineString", "coordinates": line },
        })
    });
    let text = serde_json::json!({ "type": "FeatureCollection", "features": features.collect::<Vec<_>>() });
    parse_layout(text.to_string().as_bytes(), Path::new("x.geojson")).unwrap()
}

fn number(file: &LayoutFile, name: &str, window: Option<Window>) -> Option<f64> {
    match measure(file, &Maps::default(), window).unwrap().get(name) {
        Some(Figure::Number(number)) => Some(number),
        _ => None,
    }
}

#[test]
fn a_cross_of_four_streets_has_known_figures() {
    let arm = |at: [f64; 2]| [[0.0, 0.0], at];
    let ends = [[100.0, 0.0], [-100.0, 0.0], [0.0, 100.0], [0.0, -100.0]].map(arm);
    let cross: Vec<_> = ["e", "w", "n", "s"].into_iter().zip(&ends).map(|(to, line)| ("x", to, &line[..])).collect();
    let file = streets(&cross);
    let wanted = [
        ("km2", 0.04),
        ("segment_median", 100.0),
        ("segment_cv", 0.0),
        ("crossings_km2", 25.0),
        ("km_per_km2", 10.0),
        ("x_share", 0.2),
        ("t_share", 0.0),
        ("dead_end_share", 0.8),
        ("order", 1.0),
        ("largest_component", 1.0),
        ("bridge_share", 0.0),
    ];
    for (name, value) in wanted {
        let found = number(&file, name, None).unwrap();
        assert!((found - value).abs() < 1e-12, "{name} is {found}, not {value}");
    }
    let figures = measure(&file, &Maps::default(), None).unwrap();
    assert_eq!(figures.get("water_share"), None, "there is no map");
    assert_eq!(figures.get("block_median_ha"), None, "there is no block");
}

#[test]
fn chains_through_nodes_of_degree_two_are_one_segment() {
    let file = streets(&[
        ("a", "b", &[[0.0, 0.0], [30.0, 0.0]]),
        ("c", "b", &[[30.0, 40.0], [30.0, 0.0]]),
        ("ring", "ring", &[[500.0, 0.0], [510.0, 0.0], [510.0, 10.0], [500.0, 0.0]]),
    ]);
    assert_eq!(number(&file, "segment_median", None), Some(70.0));
    let share = number(&file, "largest_component", None).unwrap();
    assert!((share - 70.0 / (70.0 + 20.0 + 200f64.sqrt())).abs() < 1e-12, "{share}");
}

#[test]
fn a_window_takes_what_has_its_middle_inside() {
    let file = streets(&[("a", "b", &[[0.0, 0.0], [100.0, 0.0]]), ("b", "c", &[[100.0, 0.0], [200.0, 0.0]])]);
    let window = Window([0.0, -50.0, 100.0, 50.0]);
    assert_eq!(number(&file, "km_per_km2", Some(window)), Some(10.0));
    let nowhere = Window([900.0, 900.0, 901.0, 901.0]);
    assert!(measure(&file, &Maps::default(), Some(nowhere)).unwrap().is_empty());
}

#[test]
fn figures_do_not_depend_on_the_order_of_the_file() {
    let mut file = layout();
    let before = measure(&file, &Maps::default(), None).unwrap();
    file.features.reverse();
    let after = measure(&file, &Maps::default(), None).unwrap();
    for ((measure, a), (_, b)) in before.iter().zip(after.iter()) {
        match (a, b) {
            (Figure::Number(a), Figure::Number(b)) => assert!((a - b).abs() <= 1e-9 * a.abs(), "{}", measure.name),
            _ => assert_eq!(a, b),
        }
    }
    assert_eq!(before.iter().count(), after.iter().count());
}

#[test]
fn a_street_must_say_what_it_joins() {
    let mut file = layout();
    file.features[0].properties.to = None;
    let message = measure(&file, &Maps::default(), None).unwrap_err().to_string();
    assert!(message.contains("does not name the crossings") && message.contains("hint"), "{message}");
    let mut file = layout();
    file.features[0].geometry = Geometry::Nothing;
    assert!(measure(&file, &Maps::default(), None).unwrap_err().to_string().contains("not a LineString"));
}

#[test]
fn every_measure_has_a_name_of_its_own() {
    let mut names: Vec<_> = MEASURES.iter().map(|measure| measure.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), MEASURES.len());
}
