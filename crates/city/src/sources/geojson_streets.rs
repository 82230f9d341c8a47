//! Streets of a GeoJSON FeatureCollection: RFC 7946 longitude and latitude, or local metres as Plat writes them.

use super::error::{SourceError, read_bytes};
use super::imported::{ImportedStreet, StreetFile, Tags, bounds_of, osm_level, osm_width, sort_by_key};
use super::projection::{Frame, Projection};
use geom::Vec2;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;

/// What the coordinates of a GeoJSON file are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GeoJsonFrame {
    /// What the file says: local metres where its top level has `"plat": {"units": "m"}` as in Plat's own layouts, else
    /// degrees; a frame is chosen around them.
    #[default]
    Detect,
    /// As `Detect`, but degrees are laid into this frame.
    Onto(Frame),
    /// Local metres, whatever the file says.
    LocalMetres,
    /// Degrees, whatever the file says, laid into this frame if there is one.
    Degrees(Option<Frame>),
}

/// Reads the LineString and MultiLineString features of a file. A feature's key is its `id`, else its number; its class is
/// property `class`, else that of property `highway` (see [`super::class_of`]; what is no street is left out), else
/// `minor`. Property `width` is the full right-of-way with `class`, the carriageway with `highway`. Features of Plat's own
/// layouts that are not streets, points and polygons are left out and counted.
///
/// # Errors
/// [`SourceError`] for what is not a FeatureCollection, has no street at all, or has a position that is none.
pub fn read_geojson_streets(path: &Path, frame: GeoJsonFrame) -> Result<StreetFile, SourceError> {
    parse_geojson_streets(path, &read_bytes(path)?, frame)
}

/// [`read_geojson_streets`] of bytes at hand; `path` only names them in errors.
///
/// # Errors
/// See [`read_geojson_streets`].
pub fn parse_geojson_streets(path: &Path, bytes: &[u8], frame: GeoJsonFrame) -> Result<StreetFile, SourceError> {
    let collection: Value = serde_json::from_slice(bytes)
        .map_err(|e| SourceError::json(path, &e, "a street file is a GeoJSON FeatureCollection"))?;
    let features = features_of(path, &collection, "export the streets as a GeoJSON FeatureCollection of LineStrings")?;
    let mut reader = Reader { path, metres: is_metres(&collection, frame), lines: vec![], left_out: BTreeMap::new() };
    for (i, feature) in features.iter().enumerate() {
        reader.feature(i + 1, feature)?;
    }
    reader.finish(frame, &collection)
}

/// The features of a collection; `hint` says what a file of its kind is.
pub(super) fn features_of<'a>(path: &Path, collection: &'a Value, hint: &str) -> Result<&'a Vec<Value>, SourceError> {
    let kind = collection.get("type").and_then(Value::as_str);
    if kind != Some("FeatureCollection") {
        let found = kind.map_or("without a type".to_owned(), |kind| format!("of type {kind}"));
        return Err(SourceError::kind(path, format!("is {found}, not a FeatureCollection"), hint.to_owned()));
    }
    collection
        .get("features")
        .and_then(Value::as_array)
        .ok_or_else(|| SourceError::kind(path, "is a FeatureCollection without a list of features", hint.to_owned()))
}

fn is_metres(collection: &Value, frame: GeoJsonFrame) -> bool {
    match frame {
        GeoJsonFrame::LocalMetres => true,
        GeoJsonFrame::Degrees(_) => false,
        GeoJsonFrame::Detect | GeoJsonFrame::Onto(_) => says_metres(collection),
    }
}

/// Whether a file says that its coordinates are local metres.
pub(super) fn says_metres(collection: &Value) -> bool {
    collection.get("plat").and_then(|plat| plat.get("units")).and_then(Value::as_str) == Some("m")
}

/// A line before it is projected.
struct Line {
    street: ImportedStreet,
    feature: usize,
}

struct Reader<'a> {
    path: &'a Path,
    metres: bool,
    lines: Vec<Line>,
    left_out: BTreeMap<String, usize>,
}

impl Reader<'_> {
    fn feature(&mut self, number: usize, feature: &Value) -> Result<(), SourceError> {
        let record = || format!("feature {number}");
        if feature.get("type").and_then(Value::as_str) != Some("Feature") {
            return Err(SourceError::record(self.path, record(), "is not a Feature"));
        }
        let empty = Map::new();
        let properties = feature.get("properties").and_then(Value::as_object).unwrap_or(&empty);
        let pattern = match pattern_of(properties) {
            Ok(pattern) => pattern,
            Err(reason) => return self.leave_out(reason),
        };
        let geometry = feature.get("geometry").unwrap_or(&Value::Null);
        let coordinates = geometry.get("coordinates").unwrap_or(&Value::Null);
        let key = key_of(number, feature);
        match geometry.get("type").and_then(Value::as_str) {
            Some("LineString") => self.line(number, key, &pattern, coordinates),
            Some("MultiLineString") => {
                let parts = coordinates
                    .as_array()
                    .ok_or_else(|| SourceError::record(self.path, record(), "is a MultiLineString without lines"))?;
                for (i, part) in parts.iter().enumerate() {
                    let key = if i == 0 { key.clone() } else { format!("{key}/{i}") };
                    self.line(number, key, &pattern, part)?;
                }
                Ok(())
            }
            Some(other) => self.leave_out(format!("geometry {other}")),
            None => self.leave_out("no geometry".to_owned()),
        }
    }

    fn line(
        &mut self,
        number: usize,
        key: String,
        pattern: &ImportedStreet,
        positions: &Value,
    ) -> Result<(), SourceError> {
        let positions = positions
            .as_array()
            .ok_or_else(|| SourceError::record(self.path, format!("feature {number}"), "has no list of positions"))?;
        let points = (positions.iter().enumerate())
            .map(|(i, position)| position_of(self.path, self.metres, number, i + 1, position))
            .collect::<Result<Vec<_>, _>>()?;
        if points.len() < 2 {
            return self.leave_out("fewer than two positions".to_owned());
        }
        self.lines.push(Line { street: ImportedStreet { key, points, ..pattern.clone() }, feature: number });
        Ok(())
    }

    fn leave_out(&mut self, reason: String) -> Result<(), SourceError> {
        *self.left_out.entry(reason).or_default() += 1;
        Ok(())
    }

    fn finish(self, frame: GeoJsonFrame, collection: &Value) -> Result<StreetFile, SourceError> {
        let Self { path, metres, mut lines, mut left_out } = self;
        if lines.is_empty() {
            let hint = "streets are LineString features with a property `highway` or `class`";
            return Err(SourceError::kind(path, "has no street in it", hint.to_owned()));
        }
        let frame = match frame {
            _ if metres => stated_frame(collection),
            GeoJsonFrame::Onto(frame) | GeoJsonFrame::Degrees(Some(frame)) => Some(frame),
            _ => Some(frame_around(path, &lines)?),
        };
        for line in &mut lines {
            let record = format!("feature {}", line.feature);
            line.street.place(path, &record, frame.filter(|_| !metres).as_ref())?;
        }
        let all = lines.len();
        let mut streets: Vec<_> = lines.into_iter().map(|line| line.street).filter(|s| s.points.len() > 1).collect();
        if streets.len() < all {
            left_out.insert("no length".to_owned(), all - streets.len());
        }
        sort_by_key(&mut streets);
        Ok(StreetFile { frame, bounds: bounds_of(&streets), streets, left_out })
    }
}

/// A position in metres or degrees; `feature` and `ordinal` (from 1) are blamed for what is none.
pub(super) fn position_of(
    path: &Path,
    metres: bool,
    feature: usize,
    ordinal: usize,
    position: &Value,
) -> Result<Vec2, SourceError> {
    let number = |i: usize| position.get(i).and_then(Value::as_f64).filter(|value| value.is_finite());
    let blame = |what: String| SourceError::record(path, format!("feature {feature}, position {ordinal}"), what);
    let (Some(x), Some(y)) = (number(0), number(1)) else {
        return Err(blame(format!("{position} is not a pair of numbers")));
    };
    let on_earth = x.abs() <= 180.0 && y.abs() <= 90.0;
    if !metres && !on_earth {
        let what = format!(
            "{x}, {y} is not longitude and latitude in degrees; coordinates in metres need \"plat\": {{\"units\": \
             \"m\"}} at the top of the file, or streets `units: \"m\"` where the script names them"
        );
        return Err(blame(what));
    }
    Ok(Vec2::new(x, y))
}

/// Everything of a street but its line; or why it is none.
fn pattern_of(properties: &Map<String, Value>) -> Result<ImportedStreet, String> {
    let text = |key: &str| properties.get(key).and_then(first_text);
    if let Some(kind) = text("kind").filter(|kind| kind != "street") {
        return Err(format!("kind={kind}"));
    }
    let mut tags = Tags::default();
    for key in ["highway", "width", "lanes", "layer", "bridge", "tunnel", "area"] {
        if let Some(value) = text(key) {
            tags.push(key, &value);
        }
    }
    let (class, width) = match (text("class"), tags.class()) {
        (Some(class), _) => (class, text("width").and_then(|width| super::imported::metres(&width))),
        (None, Some(class)) => (class?.to_owned(), Some(osm_width(&tags))),
        (None, None) => ("minor".to_owned(), None),
    };
    let stated = properties.get("level").and_then(Value::as_i64).and_then(|level| i8::try_from(level).ok());
    Ok(ImportedStreet {
        key: String::new(),
        name: text("name").filter(|name| !name.trim().is_empty()),
        class,
        width: width.filter(|width| width.is_finite() && *width > 0.0),
        level: stated.unwrap_or_else(|| osm_level(&tags)),
        points: Vec::new(),
        refs: Vec::new(),
    })
}

/// A property as text. Of a list (as OSMnx writes for merged streets) the first.
fn first_text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(true) => Some("yes".to_owned()),
        Value::Array(list) => list.first().and_then(first_text),
        _ => None,
    }
}

/// The feature's id, else `n` and its number, so that a file with ids here and there has no key twice.
fn key_of(number: usize, feature: &Value) -> String {
    feature.get("id").and_then(first_text).unwrap_or_else(|| format!("n{number}"))
}

/// Where a layout of Plat says that its (0, 0) lies.
fn stated_frame(collection: &Value) -> Option<Frame> {
    let plat = collection.get("plat")?;
    let projection = Projection::from_crs(plat.get("crs")?.as_str()?).ok()?;
    let origin = plat.get("origin")?;
    Some(Frame { projection, origin: Vec2::new(origin.get(0)?.as_f64()?, origin.get(1)?.as_f64()?) })
}

fn frame_around(path: &Path, lines: &[Line]) -> Result<Frame, SourceError> {
    let points = || lines.iter().flat_map(|line| &line.street.points);
    let min = points().fold(Vec2::INFINITY, |min, &p| min.min(p));
    let max = points().fold(Vec2::NEG_INFINITY, |max, &p| max.max(p));
    Frame::around(min, max).map_err(|e| SourceError::record(path, "the whole file", e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::{Bounds, Point};
    use serde_json::json;

    fn parse(collection: &Value, frame: GeoJsonFrame) -> Result<StreetFile, SourceError> {
        parse_geojson_streets(Path::new("streets.geojson"), collection.to_string().as_bytes(), frame)
    }

    fn metres(features: Value) -> Result<StreetFile, SourceError> {
        parse(&json!({"type": "FeatureCollection", "features": features}), GeoJsonFrame::LocalMetres)
    }

    fn feature(properties: Value, coordinates: Value) -> Value {
        json!({"type": "Feature", "properties": properties, "geometry": {"type": "LineString", "coordinates": coordinates}})
    }

    #[test]
    fn degrees_are_laid_into_the_frame_of_a_site() {
        let frame = Frame {
            projection: Projection::from_crs("EPSG:32618").unwrap(),
            origin: Vec2::new(579_660.0, 4_503_410.0),
        };
        let line = feature(
            json!({"highway": "primary", "name": "5th Avenue"}),
            json!([[-73.985656, 40.748433, 12.0], [-73.9106, 40.8777]]),
        );
        let collection = json!({"type": "FeatureCollection", "features": [line]});
        let file = parse(&collection, GeoJsonFrame::Onto(frame)).unwrap();
        let street = &file.streets[0];
        assert_eq!(
            (street.class.as_str(), street.name.as_deref(), street.width),
            ("major", Some("5th Avenue"), Some(20.0))
        );
        let expected = [Vec2::new(5972.081342, 7916.153664), Vec2::new(12130.156575, 22341.874010)];
        for (point, expected) in street.points.iter().zip(expected) {
            // Within half a lattice unit.
            assert!((*point - expected).abs().max_element() <= 0.5 / 1024.0 + 1e-6, "{point}");
        }
        let detected = parse(&collection, GeoJsonFrame::Detect).unwrap();
        assert_eq!(detected.frame.unwrap().projection, frame.projection);
        assert!(detected.bounds.min.x >= 0 && detected.bounds.min.y >= 0);
    }

    #[test]
    fn layouts_of_plat_are_read_back_in_metres() {
        let collection = json!({
            "type": "FeatureCollection",
            "plat": {"format": 1, "units": "m", "crs": "EPSG:32633", "origin": [540000.0, 5360000.0]},
            "features": [
                {"type": "Feature", "id": "b7", "properties": {"kind": "street", "class": "highway", "width": 28.5, "level": 1},
                 "geometry": {"type": "LineString", "coordinates": [[100, 200], [1500.5, 200]]}},
                {"type": "Feature", "id": "c1", "properties": {"kind": "crossing"}, "geometry": {"type": "Point", "coordinates": [1, 2]}},
                {"type": "Feature", "id": "b1", "properties": {"kind": "street", "class": "minor", "width": 12},
                 "geometry": {"type": "LineString", "coordinates": [[0, 0], [0, 90]]}},
            ],
        });
        let file = parse(&collection, GeoJsonFrame::Detect).unwrap();
        let got: Vec<_> = file.streets.iter().map(|s| (s.key.as_str(), s.class.as_str(), s.width, s.level)).collect();
        assert_eq!(got, [("b1", "minor", Some(12.0), 0), ("b7", "highway", Some(28.5), 1)]);
        assert_eq!(file.streets[1].points, [Vec2::new(100.0, 200.0), Vec2::new(1500.5, 200.0)]);
        assert_eq!(file.left_out, BTreeMap::from([("kind=crossing".to_owned(), 1)]));
        assert_eq!(file.bounds, Bounds::between(Point::new(0, 0), Point::new(1_536_512, 204_800)));
        assert_eq!(file.frame.unwrap().origin, Vec2::new(540_000.0, 5_360_000.0));
    }

    #[test]
    fn keys_levels_and_lists_of_osmnx() {
        let two = json!([[[0, 0], [5, 0]], [[9, 0], [20, 0]], [[50, 50]]]);
        let file = metres(json!([
            feature(json!({}), json!([[0, 0], [10, 0], [10, 0], [20, 5]])),
            {"type": "Feature", "id": 42, "properties": {"highway": ["residential", "service"], "bridge": true},
             "geometry": {"type": "MultiLineString", "coordinates": two}},
            feature(json!({"highway": "footway"}), json!([[0, 0], [10, 0]])),
            feature(json!(null), json!([[3, 3], [3, 3]])),
            {"type": "Feature", "properties": null, "geometry": null},
        ]))
        .unwrap();
        let got: Vec<_> =
            file.streets.iter().map(|s| (s.key.as_str(), s.points.len(), s.level, s.class.as_str())).collect();
        assert_eq!(got, [("42", 2, 1, "minor"), ("42/1", 2, 1, "minor"), ("n1", 3, 0, "minor")]);
        let left_out = [("fewer than two positions", 1), ("highway=footway", 1), ("no geometry", 1), ("no length", 1)];
        assert_eq!(file.left_out, left_out.map(|(why, n)| (why.to_owned(), n)).into());
    }

    #[test]
    fn wrong_files_are_refused_with_the_feature() {
        let good = || feature(json!({}), json!([[0, 0], [1, 1]]));
        let degrees =
            |coordinates| json!({"type": "FeatureCollection", "features": [good(), feature(json!({}), coordinates)]});
        for (collection, wrong) in [
            (json!({"type": "Feature"}), "is of type Feature, not a FeatureCollection"),
            (json!([1, 2]), "is without a type, not a FeatureCollection"),
            (json!({"type": "FeatureCollection"}), "without a list of features"),
            (json!({"type": "FeatureCollection", "features": []}), "has no street in it"),
            (json!({"type": "FeatureCollection", "features": [good(), 5]}), "feature 2: is not a Feature"),
            (degrees(json!(7)), "feature 2: has no list of positions"),
            (degrees(json!([[0, 0], [null, 1]])), "feature 2, position 2: [null,1] is not a pair of numbers"),
            (degrees(json!([[0, 0], ["1", 1]])), "feature 2, position 2"),
            (degrees(json!([[0], [1, 1]])), "feature 2, position 1: [0] is not a pair"),
            (degrees(json!([[0, 0], [585_632.0, 4_511_326.0]])), "coordinates in metres need"),
            (degrees(json!([[0, 91], [0, 0]])), "not longitude and latitude"),
            (degrees(json!([[0, 0], [120, 0]])), "too far from EPSG"),
        ] {
            let error = parse(&collection, GeoJsonFrame::Detect).unwrap_err();
            assert!(error.to_string().contains(wrong), "{collection}: {error}");
            assert!(error.to_string().starts_with("streets.geojson: ") && !error.hint().is_empty());
        }
        let error = metres(json!([feature(json!({}), json!([[0, 0], [1e7, 0]]))])).unwrap_err();
        assert!(error.to_string().contains("feature 1, position 2") && error.to_string().contains("524 km"), "{error}");
        let text = b"{\"type\": \"FeatureCollection\",\n \"features\": [NaN]}";
        let error = parse_geojson_streets(Path::new("s.json"), text, GeoJsonFrame::Detect).unwrap_err();
        assert!(error.to_string().starts_with("s.json:2:15: expected value"), "{error}");
    }

    #[test]
    fn a_cut_off_or_damaged_file_never_panics() {
        let text = json!({"type": "FeatureCollection", "features": [feature(json!({"highway": "primary"}), json!([[1, 2], [1.5, 2.5]]))]}).to_string();
        let path = Path::new("s.geojson");
        for at in 0..text.len() {
            assert!(parse_geojson_streets(path, &text.as_bytes()[..at], GeoJsonFrame::Detect).is_err());
            let mut bytes = text.clone().into_bytes();
            bytes[at] ^= 1 << (at % 8);
            let _ = parse_geojson_streets(path, &bytes, GeoJsonFrame::Detect);
        }
    }

    #[test]
    fn manhattans_streets_have_their_length() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/manhattan_real/streets_osm.geojson");
        let file = read_geojson_streets(&path, GeoJsonFrame::Detect).unwrap();
        let length: f64 = file.streets.iter().map(ImportedStreet::length).sum();
        assert_eq!((file.streets.len(), file.left_out.len()), (7124, 0));
        assert!((length / 1000.0 - 809.0).abs() < 1.0, "{length}");
        assert_eq!(file.frame.unwrap().projection.crs(), "EPSG:32618");
    }
}
