//! A built city as tests ask it.

use crate::export::geojson::write_layout;
use crate::export::layout_file::{self, parse_layout};
use crate::export::map::{MapOptions, write_svg};
use crate::measure::{Figure, Figures, MEASURES, Maps, measure, place_inside, ring_area};
use crate::{Built, Cache, City};
use geom::{Id, Point, Polygon, Vec2};
use layout::Use;
use script::Fault;
use script::testing::{Datum, Feature, Town};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::{self, Write};
use std::path::Path;
use std::sync::{Arc, OnceLock};
use streets::growth::{Field, Fields};

/// What can be measured of a town besides [`MEASURES`]: name, unit, what it says.
const FURTHER: [(&str, &str, &str); 13] = [
    ("km", "km", "length of streets"),
    ("heading", "°", "strongest heading, counter-clockwise from east, modulo 180"),
    ("shortest", "m", "shortest piece of street between two crossings"),
    ("longest", "m", "longest piece of street between two crossings"),
    ("sharpest", "°", "least angle between two streets at a crossing"),
    ("most_arms", "", "most streets that meet in a crossing"),
    ("steepest", "%", "steepest street on the ground (map `elevation`)"),
    ("parcel_median", "m²", "median area of parcels that may be built on"),
    ("built_share", "", "share of the area of parcels that may be built on"),
    ("no_access_share", "", "share of parcels that front no street"),
    ("cover_share", "", "share of the area of parcels that buildings cover"),
    ("height_median", "m", "median height of buildings"),
    ("highest", "m", "height of the highest building"),
];

/// A city with what was measured of it so far.
pub(super) struct GrownTown {
    city: Arc<City>,
    faults: Vec<Fault>,
    layout: OnceLock<(Vec<u8>, Figures)>,
    fields: OnceLock<Fields>,
}

impl fmt::Debug for GrownTown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GrownTown").field("city", &self.city.name).finish_non_exhaustive()
    }
}

impl GrownTown {
    pub fn new(built: &Built) -> Self {
        let faults = built.report.faults.iter().map(Fault::from).collect();
        Self { city: built.city.clone(), faults, layout: OnceLock::new(), fields: OnceLock::new() }
    }

    /// The layout as it is written, and what was measured in it.
    fn layout(&self) -> &(Vec<u8>, Figures) {
        self.layout.get_or_init(|| {
            let mut bytes = Vec::new();
            write_layout(&self.city, &mut bytes).expect("memory takes everything");
            let file = parse_layout(&bytes, Path::new("layout.geojson")).expect("what was written can be read");
            let figures = measure(&file, &Maps::of_site(&self.city.site), None)
                .expect("a layout of our own says what measures need");
            (bytes, figures)
        })
    }

    /// The maps of the site as growth asks them.
    fn fields(&self) -> &Fields {
        self.fields.get_or_init(|| {
            let site = &self.city.site;
            let maps = site.maps.iter().map(|(name, map)| (name.clone(), Field::Map(map.clone()))).collect();
            Fields { maps, ..Fields::plain(site.bounds) }
        })
    }

    fn further(&self, name: &str) -> Option<f64> {
        let city = &*self.city;
        match name {
            "km" => Some(self.run_lengths().iter().sum::<f64>() / 1000.0),
            "heading" => match self.layout().1.get("headings")? {
                Figure::Headings([first, _]) => Some(first),
                Figure::Number(number) => Some(number),
            },
            "shortest" => least(self.run_lengths()),
            "longest" => most(self.run_lengths()),
            "sharpest" => least(self.angles()),
            "most_arms" => {
                most(streets::runs::crossings(&city.runs).iter().map(|&node| city.graph.degree(node) as f64))
            }
            "steepest" => city.site.map("elevation").and(most(self.grades())),
            "parcel_median" => median(self.parcel_areas(true)),
            "built_share" => share(self.parcel_areas(true), self.parcel_areas(false)),
            "no_access_share" => {
                let without = city.parcels.iter().filter(|parcel| parcel.access.is_empty()).count();
                (!city.parcels.is_empty()).then(|| without as f64 / city.parcels.len() as f64)
            }
            "cover_share" => {
                let covered = city.buildings.iter().map(|building| building.footprint.area()).collect();
                share(covered, self.parcel_areas(false))
            }
            "height_median" => median(city.buildings.iter().map(|building| building.height).collect()),
            "highest" => most(city.buildings.iter().map(|building| building.height)),
            _ => None,
        }
    }

    /// Lengths from crossing to crossing, metres.
    fn run_lengths(&self) -> Vec<f64> {
        let at = |node| self.city.graph.at(node).metres();
        let length =
            |run: &streets::runs::Run| run.nodes.windows(2).map(|pair| at(pair[0]).distance(at(pair[1]))).sum();
        self.city.runs.iter().map(length).collect()
    }

    /// Angles between neighbouring streets at crossings, in degrees.
    fn angles(&self) -> Vec<f64> {
        let graph = &self.city.graph;
        let mut found = Vec::new();
        for node in streets::runs::crossings(&self.city.runs) {
            let mut headings: Vec<f64> = Vec::new();
            for run in &self.city.runs {
                let ends =
                    [(run.nodes[0], run.nodes[1]), (run.nodes[run.nodes.len() - 1], run.nodes[run.nodes.len() - 2])];
                let away =
                    |&(end, next): &(_, _)| (end == node).then(|| graph.at(next).metres() - graph.at(end).metres());
                headings.extend(
                    ends.iter().filter_map(away).map(|along| geom::Angle::of(along).to_degrees().rem_euclid(360.0)),
                );
            }
            headings.sort_by(f64::total_cmp);
            if headings.len() > 1 {
                let first = headings[0] + 360.0;
                found.extend(headings.iter().zip(headings.iter().skip(1).chain([&first])).map(|(a, b)| b - a));
            }
        }
        found
    }

    /// Grades of pieces of street on the ground, in percent.
    fn grades(&self) -> Vec<f64> {
        const STEP: f64 = 10.0;
        let (graph, site) = (&self.city.graph, &self.city.site);
        let mut found = Vec::new();
        for run in self.city.runs.iter().filter(|run| run.level == 0) {
            for pair in run.nodes.windows(2) {
                let (a, b) = (graph.at(pair[0]).metres(), graph.at(pair[1]).metres());
                let steps = (a.distance(b) / STEP).ceil().max(1.0);
                let at = |k: f64| a.lerp(b, k / steps);
                let grade = |k: f64| {
                    let (from, to) = (at(k), at(k + 1.0));
                    100.0 * (site.elevation(to) - site.elevation(from)).abs() / from.distance(to).max(1e-9)
                };
                found.extend((0..steps as u32).map(|k| grade(f64::from(k))));
            }
        }
        found
    }

    fn parcel_areas(&self, built: bool) -> Vec<f64> {
        let counted = self.city.parcels.iter().filter(|parcel| !built || parcel.usage == Use::Built);
        counted.map(|parcel| parcel.polygon.area()).collect()
    }

    /// Identity of all that lies in the town, whatever it is called.
    fn hash(&self) -> Id {
        let city = &*self.city;
        let mut lines: Vec<String> = Vec::new();
        for run in &city.runs {
            let mut at: Vec<Point> = run.nodes.iter().map(|&node| city.graph.at(node)).collect();
            if at.last() < at.first() {
                at.reverse();
            }
            lines.push(format!("street {} {} {} {at:?}", run.class.0, run.half_width, run.level));
        }
        let ring = |polygon: &Polygon| format!("{:?} {:?}", turned(&polygon.outer), polygon.holes);
        lines.extend(city.blocks.iter().map(|block| format!("block {}", ring(&block.polygon))));
        lines.extend(city.parcels.iter().map(|parcel| format!("parcel {:?} {}", parcel.usage, ring(&parcel.polygon))));
        let building = |b: &buildings::Building| format!("building {:.3} {}", b.height, ring(&b.footprint));
        lines.extend(city.buildings.iter().map(building));
        lines.sort();
        Id::of_text("layout", &lines.join("\n"))
    }
}

/// A ring from its least corner on.
fn turned(ring: &[Point]) -> Vec<Point> {
    let mut ring = ring.to_vec();
    let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
    ring.rotate_left(least);
    ring
}

fn least(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().min_by(f64::total_cmp)
}

fn most(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().max_by(f64::total_cmp)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn share(part: Vec<f64>, whole: Vec<f64>) -> Option<f64> {
    let (part, whole): (f64, f64) = (part.iter().sum(), whole.iter().sum());
    (whole > 0.0).then(|| part / whole)
}

impl Town for GrownTown {
    fn measures(&self) -> Vec<(&'static str, &'static str, &'static str)> {
        let known = MEASURES.iter().filter(|measure| measure.name != "headings");
        known.map(|measure| (measure.name, measure.unit, measure.about)).chain(FURTHER).collect()
    }

    fn measure(&self, name: &str) -> Option<f64> {
        if FURTHER.iter().any(|(known, ..)| *known == name) {
            return self.further(name);
        }
        match self.layout().1.get(name)? {
            Figure::Number(number) => Some(number),
            Figure::Headings(_) => None,
        }
    }

    fn features(&self, kind: &str) -> Vec<Feature> {
        let text = std::str::from_utf8(&self.layout().0).expect("GeoJSON is UTF-8");
        let marker = format!("\"kind\":\"{kind}\"");
        let lines = text.lines().filter(|line| line.contains(&marker));
        let features = lines.filter_map(|line| serde_json::from_str::<Value>(line.trim_end_matches(',')).ok());
        let classes: BTreeMap<String, &str> = self
            .city
            .runs
            .iter()
            .map(|run| (run.street.to_string(), self.city.graph.classes().info(run.class).name.as_str()))
            .collect();
        features.map(|feature| feature_of(&feature, &classes)).collect()
    }

    fn distance(&self, map: &str, class: Option<&str>) -> Option<f64> {
        let graph = &self.city.graph;
        let counts =
            |run: &&streets::runs::Run| class.is_none_or(|class| graph.classes().info(run.class).name == class);
        let mut nearest = f64::INFINITY;
        self.city.site.map(map)?;
        for pair in self.city.runs.iter().filter(counts).flat_map(|run| run.nodes.windows(2)) {
            let (from, to) = (graph.at(pair[0]).metres(), graph.at(pair[1]).metres());
            nearest = nearest.min(self.fields().distance_to(map, from, to)?);
        }
        Some(nearest)
    }

    fn digest(&self) -> String {
        let city = &*self.city;
        let mut text = String::new();
        let counts = [
            ("streets", city.runs.len()),
            ("crossings", streets::runs::crossings(&city.runs).len()),
            ("quarters", city.quarters.len()),
            ("blocks", city.blocks.len()),
            ("parcels", city.parcels.len()),
            ("buildings", city.buildings.len()),
        ];
        let mut line = |name: &str, value: String| writeln!(text, "{name} {value}").expect("text takes everything");
        for (name, count) in counts {
            line(name, count.to_string());
        }
        let of_class = |class: streets::Class| city.runs.iter().filter(|run| run.class == class).count();
        for (class, info) in city.graph.classes().iter().filter(|(class, _)| of_class(*class) > 0) {
            line(&format!("{}s", info.name), of_class(class).to_string());
        }
        for (name, unit, _) in self.measures() {
            if let Some(value) = self.measure(name) {
                let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
                line(name, format!("{}{unit}", rounded(value)));
            }
        }
        line("layout", self.hash().to_string());
        text
    }

    fn drawing(&self) -> String {
        let options = MapOptions { longest_side: 480, ..MapOptions::default() };
        let mut bytes = Vec::new();
        write_svg(&self.city, &options, &Cache::none(), &mut bytes).expect("memory takes everything");
        String::from_utf8(bytes).expect("SVG is UTF-8")
    }

    fn faults(&self) -> Vec<Fault> {
        self.faults.clone()
    }
}

/// Four digits that count.
fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.abs().to_string();
    }
    let digits = 3 - libm::floor(libm::log10(value.abs())) as i32;
    let text = format!("{value:.*}", digits.clamp(0, 6) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The properties of a feature, and what follows from where it lies.
fn feature_of(feature: &Value, classes: &BTreeMap<String, &str>) -> Feature {
    let mut found: Feature = Vec::new();
    for (key, value) in feature["properties"].as_object().into_iter().flatten() {
        // `use` is a word that Rhai keeps for itself.
        let key = if key == "use" { "usage" } else { key };
        found.extend(datum(value).map(|value| (key.to_owned(), value)));
    }
    if let Some(access) = feature["properties"]["access"].as_array() {
        let mut fronted: Vec<&str> =
            access.iter().filter_map(|street| classes.get(street.as_str()?).copied()).collect();
        fronted.sort_unstable();
        fronted.dedup();
        let names = fronted.into_iter().map(|name| Datum::Text(name.to_owned())).collect();
        found.push(("classes".into(), Datum::List(names)));
    }
    let mut number = |key: &str, value: f64| found.push((key.to_owned(), Datum::Number(value)));
    let geometry = serde_json::from_value::<layout_file::Geometry>(feature["geometry"].clone()).unwrap_or_default();
    match geometry {
        layout_file::Geometry::Point([x, y]) => {
            number("x", x);
            number("y", y);
        }
        layout_file::Geometry::LineString(line) => {
            let at = |place: &[f64; 2]| Vec2::from_array(*place);
            let pairs = || line.windows(2).map(|pair| (at(&pair[0]), at(&pair[1])));
            let middle = line.first().zip(line.last()).map_or(Vec2::ZERO, |(a, b)| (at(a) + at(b)) / 2.0);
            let along = line.first().zip(line.last()).map_or(Vec2::X, |(a, b)| at(b) - at(a));
            number("length", pairs().map(|(a, b)| a.distance(b)).sum());
            number("heading", geom::Angle::of(along).to_degrees().rem_euclid(180.0));
            number("x", middle.x);
            number("y", middle.y);
        }
        layout_file::Geometry::Polygon(rings) => {
            let areas: Vec<f64> = rings.iter().map(|ring| ring_area(ring)).collect();
            number("area", areas.first().copied().unwrap_or(0.0) - areas.iter().skip(1).sum::<f64>());
            let [x, y] = place_inside(&rings).unwrap_or_default();
            number("x", x);
            number("y", y);
        }
        _ => {}
    }
    found
}

fn datum(value: &Value) -> Option<Datum> {
    match value {
        Value::Bool(flag) => Some(Datum::Flag(*flag)),
        Value::Number(number) => match number.as_i64() {
            Some(whole) => Some(Datum::Whole(whole)),
            None => number.as_f64().map(Datum::Number),
        },
        Value::String(text) => Some(Datum::Text(text.clone())),
        Value::Array(list) => Some(Datum::List(list.iter().filter_map(datum).collect())),
        // Tags are told by their names.
        Value::Object(map) => Some(Datum::List(map.keys().map(|key| Datum::Text(key.clone())).collect())),
        Value::Null => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_four_digits_that_count() {
        let told = [0.0, 1.0, 0.123_456, 12_345.6, 99.996, 0.000_012_3].map(rounded);
        assert_eq!(told, ["0", "1", "0.1235", "12346", "100", "0.000012"]);
    }
}
