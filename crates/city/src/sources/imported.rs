//! Streets as files give them, and what the tags of OpenStreetMap mean for Plat.

use super::error::SourceError;
use super::projection::Frame;
use geom::{Bounds, Point, Vec2};
use std::collections::BTreeMap;
use std::path::Path;

/// A street of a file: one unbroken line.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedStreet {
    /// The record's identity in its file, unique there: a way's or feature's id, else the record's ordinal; later parts
    /// of a record of several lines add `/1`, `/2`, ….
    pub key: String,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// `highway`, `major`, `minor`, or what the file itself calls the class.
    pub class: String,
    /// Full right-of-way including sidewalks in metres, where the file tells.
    pub width: Option<f64>,
    /// 0 on the ground, above it for bridges, below it for tunnels.
    pub level: i8,
    /// Two or more points in local metres, on the lattice; neighbours differ.
    pub points: Vec<Vec2>,
    /// The OpenStreetMap node of each point; empty where there are none.
    pub refs: Vec<i64>,
}

impl ImportedStreet {
    /// Lays points in degrees into a frame (metres stay) and onto the lattice, and drops those that fall on their
    /// predecessor there. `record` is blamed for a position that is none.
    pub(super) fn place(&mut self, path: &Path, record: &str, frame: Option<&Frame>) -> Result<(), SourceError> {
        let mut kept = Vec::with_capacity(self.points.len());
        let mut kept_refs = Vec::with_capacity(self.refs.len());
        for (i, &point) in self.points.iter().enumerate() {
            let blame = |what: String| SourceError::record(path, format!("{record}, position {}", i + 1), what);
            let metres = match frame {
                Some(frame) => frame.local(point.x, point.y).map_err(|e| blame(e.to_string()))?,
                None => point,
            };
            let on_lattice = Point::try_from_metres(metres)
                .ok_or_else(|| blame(format!("{metres} lies more than 524 km from the corner of the site")))?
                .metres();
            if kept.last() != Some(&on_lattice) {
                kept.push(on_lattice);
                kept_refs.extend(self.refs.get(i));
            }
        }
        (self.points, self.refs) = (kept, kept_refs);
        Ok(())
    }

    /// Length in metres.
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|ends| (ends[1] - ends[0]).length()).sum()
    }
}

/// The box of all points of some streets; a single point at (0, 0) when there are none.
pub(super) fn bounds_of(streets: &[ImportedStreet]) -> Bounds {
    let points = streets.iter().flat_map(|street| &street.points).map(|&point| Point::from_metres(point));
    Bounds::of(points).unwrap_or(Bounds { min: Point::default(), max: Point::default() })
}

/// The streets of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct StreetFile {
    /// How local metres lie on Earth; `None` when the file was in local metres already.
    pub frame: Option<Frame>,
    /// The rectangle that the file says it covers, else that of the streets; local metres. Streets may reach past it.
    pub bounds: Bounds,
    /// The streets, by key.
    pub streets: Vec<ImportedStreet>,
    /// Lines left out, by reason (e.g. `highway=footway`), counted.
    pub left_out: BTreeMap<String, usize>,
}

/// The identity of a file in the lineage of its streets: its name without folders, so that a city may move.
pub fn file_key(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// The class of a drivable `highway` tag: motorways and trunk roads are highways, primary and secondary ones majors, all
/// others minors. `None` for what is not a street to drive or stroll on: paths, steps, tracks, service lanes, building sites.
pub fn class_of(highway: &str) -> Option<&'static str> {
    Some(match highway.strip_suffix("_link").unwrap_or(highway) {
        "motorway" | "trunk" => "highway",
        "primary" | "secondary" => "major",
        "tertiary" | "unclassified" | "residential" | "living_street" | "pedestrian" | "road" => "minor",
        _ => return None,
    })
}

/// Right-of-way in metres of a class when nothing else is known: two carriageways for a highway, four lanes and
/// sidewalks for a major, two lanes, parking and sidewalks for a minor.
pub fn class_width(class: &str) -> f64 {
    match class {
        "highway" => 28.0,
        "major" => 20.0,
        _ => 14.0,
    }
}

/// Narrowest and widest right-of-way taken from a tag, metres; beyond it the tag is a slip and the default is used.
const PLAUSIBLE_WIDTH: std::ops::RangeInclusive<f64> = 2.0..=120.0;
/// Width of a lane without a `width` tag, metres.
const LANE: f64 = 3.25;

/// Right-of-way in metres of an OpenStreetMap line: carriageway (tag `width`, else `lanes` × 3.25 m) and sidewalks, else a
/// default of its `highway` value. Where carriageways are mapped one by one, as on most motorways, it is that of one.
///
/// | highway | default | both sidewalks or shoulders |
/// |---|---|---|
/// | motorway | 14 | 5 |
/// | trunk | 16 | 5 |
/// | primary | 20 | 7 |
/// | secondary | 18 | 7 |
/// | tertiary | 16 | 6 |
/// | residential, unclassified, road | 14 | 5 |
/// | living_street | 10 | 2 |
/// | pedestrian | 8 | 0 |
/// | any `_link` | 9 | 3 |
pub(super) fn osm_width(tags: &Tags) -> f64 {
    let highway = tags.get("highway").unwrap_or_default();
    let (default, sides) = match highway {
        "motorway" => (14.0, 5.0),
        "trunk" => (16.0, 5.0),
        "primary" => (20.0, 7.0),
        "secondary" => (18.0, 7.0),
        "tertiary" => (16.0, 6.0),
        "living_street" => (10.0, 2.0),
        "pedestrian" => (8.0, 0.0),
        _ if highway.ends_with("_link") => (9.0, 3.0),
        _ => (14.0, 5.0),
    };
    let lanes = tags.get("lanes").and_then(|lanes| lanes.trim().parse::<f64>().ok()).map(|lanes| lanes * LANE);
    tags.get("width")
        .and_then(metres)
        .or(lanes)
        .map(|carriageway| carriageway + sides)
        .filter(|width| PLAUSIBLE_WIDTH.contains(width))
        .unwrap_or(default)
}

/// A width as OpenStreetMap writes it: metres by default, or `m`, `ft`, `'`.
pub(super) fn metres(text: &str) -> Option<f64> {
    let text = text.trim();
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let number: f64 = number.parse().ok()?;
    match unit.trim() {
        "" | "m" => Some(number),
        "ft" | "'" => Some(number * 0.3048),
        _ => None,
    }
}

/// The level of an OpenStreetMap line. Tag `layer` only orders bridges and tunnels; the ground is always level 0. A
/// bridge is at least at 1, a tunnel at most at −1; a passage through a building and a culvert are on the ground.
pub(super) fn osm_level(tags: &Tags) -> i8 {
    let layer = tags.get("layer").and_then(|layer| layer.trim().parse::<f64>().ok()).unwrap_or(0.0);
    let layer = layer.clamp(-100.0, 100.0) as i8;
    if is_yes(tags.get("tunnel"), &["building_passage", "culvert"]) {
        layer.min(-1)
    } else if is_yes(tags.get("bridge"), &[]) {
        layer.max(1)
    } else {
        0
    }
}

fn is_yes(tag: Option<&str>, except: &[&str]) -> bool {
    tag.is_some_and(|value| !matches!(value, "" | "no" | "false" | "0") && !except.contains(&value))
}

/// The tags of a record.
#[derive(Clone, Debug, Default)]
pub(super) struct Tags(Vec<(String, String)>);

impl Tags {
    /// Keys that are read; all others are dropped on entry.
    const KEYS: [&str; 8] = ["highway", "name", "width", "lanes", "layer", "bridge", "tunnel", "area"];

    pub fn push(&mut self, key: &str, value: &str) {
        if Self::KEYS.contains(&key) {
            self.0.push((key.to_owned(), value.to_owned()));
        }
    }

    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(other, _)| other == key).map(|(_, value)| value.as_str())
    }

    /// The class of the line, or why it is left out; `None` for what is no line of traffic at all.
    pub fn class(&self) -> Option<Result<&'static str, String>> {
        let highway = self.get("highway")?;
        if is_yes(self.get("area"), &[]) {
            return Some(Err("area=yes".to_owned()));
        }
        Some(class_of(highway).ok_or_else(|| format!("highway={highway}")))
    }
}

/// Sorts streets by key, after making keys unique: the second record with a key gets `#2`.
pub(super) fn sort_by_key(streets: &mut [ImportedStreet]) {
    streets.sort_by(|a, b| a.key.cmp(&b.key));
    let mut i = 0;
    while i < streets.len() {
        let end = i + streets[i..].iter().take_while(|street| street.key == streets[i].key).count();
        for (ordinal, street) in streets[i..end].iter_mut().enumerate().skip(1) {
            street.key = format!("{}#{}", street.key, ordinal + 1);
        }
        i = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(list: &[(&str, &str)]) -> Tags {
        let mut tags = Tags::default();
        list.iter().for_each(|(key, value)| tags.push(key, value));
        tags
    }

    #[test]
    fn classes_of_highways() {
        for (highway, class) in [
            ("motorway", Some("highway")),
            ("motorway_link", Some("highway")),
            ("trunk_link", Some("highway")),
            ("primary", Some("major")),
            ("secondary_link", Some("major")),
            ("tertiary", Some("minor")),
            ("pedestrian", Some("minor")),
            ("living_street", Some("minor")),
            ("service", None),
            ("footway", None),
            ("steps", None),
            ("construction", None),
            ("", None),
        ] {
            assert_eq!(class_of(highway), class, "{highway}");
        }
    }

    #[test]
    fn levels_follow_bridge_and_tunnel_not_layer_alone() {
        for (list, level) in [
            (&[][..], 0),
            (&[("layer", "2")], 0),
            (&[("layer", "-1")], 0),
            (&[("bridge", "yes")], 1),
            (&[("bridge", "viaduct"), ("layer", "3")], 3),
            (&[("bridge", "yes"), ("layer", "-1")], 1),
            (&[("bridge", "no"), ("layer", "2")], 0),
            (&[("tunnel", "yes")], -1),
            (&[("tunnel", "yes"), ("layer", "-2")], -2),
            (&[("tunnel", "yes"), ("layer", "1")], -1),
            (&[("tunnel", "building_passage"), ("layer", "-1")], 0),
            (&[("tunnel", "culvert")], 0),
            (&[("bridge", "yes"), ("layer", "1e9")], 100),
            (&[("bridge", "yes"), ("layer", "nonsense")], 1),
        ] {
            assert_eq!(osm_level(&tags(list)), level, "{list:?}");
        }
    }

    #[test]
    fn widths_come_from_width_then_lanes_then_class() {
        for (list, width) in [
            (&[("highway", "residential")][..], 14.0),
            (&[("highway", "residential"), ("width", "7.5 m"), ("lanes", "9")], 12.5),
            (&[("highway", "primary"), ("lanes", "4")], 20.0),
            (&[("highway", "motorway_link"), ("width", "20'")], 9.096),
            (&[("highway", "residential"), ("width", "wide")], 14.0),
            (&[("highway", "residential"), ("width", "9000")], 14.0),
            (&[("highway", "residential"), ("lanes", "NaN")], 14.0),
            (&[("highway", "pedestrian"), ("width", "0.1")], 8.0),
        ] {
            let got = osm_width(&tags(list));
            assert!((got - width).abs() < 1e-12, "{list:?}: {got}");
        }
    }

    #[test]
    fn keys_are_made_unique_in_order() {
        let street = |key: &str, x: f64| ImportedStreet {
            key: key.to_owned(),
            name: None,
            class: "minor".to_owned(),
            width: None,
            level: 0,
            points: vec![Vec2::ZERO, Vec2::new(x, 0.0)],
            refs: vec![],
        };
        let mut streets = vec![street("b", 1.0), street("a", 2.0), street("b", 3.0), street("b", 4.0)];
        sort_by_key(&mut streets);
        let got: Vec<_> = streets.iter().map(|s| (s.key.as_str(), s.points[1].x)).collect();
        assert_eq!(got, [("a", 2.0), ("b", 1.0), ("b#2", 3.0), ("b#3", 4.0)]);
    }
}
