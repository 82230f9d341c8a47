//! `layout.geojson`: the whole city as one feature collection in local metres, one feature a line.
//!
//! Written as a stream: a million parcels take little more memory than a thousand. Every coordinate is the exact decimal of a
//! lattice point (k / 1024 has at most ten decimals), so reading the file back gives the same lattice points.

use crate::{Area, City, Landmark};
use buildings::Building;
use geom::{Id, Point, Polygon};
use layout::{Block, Parcel, Use};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::LazyLock;
use streets::runs::Run;
use streets::{NodeId, NodeKey};

/// The version of the format that [`write_layout`] writes.
pub const FORMAT: u32 = 1;

/// Writes a city as `layout.geojson` (see the module); features by kind (street, crossing, quarter, block, district,
/// parcel, building, landmark), then by id.
///
/// # Errors
/// Those of the writer.
pub fn write_layout(city: &City, mut out: impl Write) -> io::Result<()> {
    let mut head = Features::default();
    head.head(city);
    out.write_all(&head.out)?;
    let mut stream = Stream { out, is_first: true };
    stream.write(&sorted(&city.runs, |run| run.id), |features, run| features.street(city, run))?;
    let crossings: Vec<_> = crossings(city).into_iter().collect();
    stream.write(&crossings, |features, &(id, key)| features.crossing(city, id, key))?;
    stream.write(&sorted(&city.quarters, |area| area.id), |features, area| features.area("quarter", area))?;
    stream.write(&sorted(&city.blocks, |block| block.id), |features, block| features.block(block))?;
    stream.write(&sorted(&city.districts, |area| area.id), |features, area| features.area("district", area))?;
    let landmark_of = landmarks_by_parcel(city);
    stream.write(&sorted(&city.parcels, |parcel| parcel.id), |features, parcel| {
        features.parcel(parcel, landmark_of.get(&parcel.id).copied());
    })?;
    stream.write(&sorted(&city.buildings, |building| building.id), |features, building| {
        features.building(city, building);
    })?;
    stream.write(&sorted(&city.landmarks, |landmark| landmark.id), |features, landmark| features.landmark(landmark))?;
    stream.out.write_all(b"\n]}\n")?;
    stream.out.flush()
}

/// The landmark of each parcel that belongs to one.
fn landmarks_by_parcel(city: &City) -> BTreeMap<Id, &Landmark> {
    city.landmarks.iter().flat_map(|landmark| landmark.parcels.iter().map(move |&id| (id, landmark))).collect()
}

/// The crossings of a city: the ends of its runs, by id.
pub fn crossings(city: &City) -> BTreeMap<NodeId, NodeKey> {
    let ends = city.runs.iter().flat_map(|run| [run.nodes.first(), run.nodes.last()]).flatten();
    ends.map(|&key| (city.graph.node(key).id, key)).collect()
}

/// What a parcel's use is called in files.
pub fn use_name(usage: Use) -> &'static str {
    match usage {
        Use::Built => "built",
        Use::Open => "open",
        Use::Park => "park",
        Use::Plaza => "plaza",
    }
}

/// References to the items in the order of their keys.
fn sorted<T, K: Ord>(items: &[T], key: impl Fn(&T) -> K) -> Vec<&T> {
    let mut refs: Vec<&T> = items.iter().collect();
    refs.sort_by_key(|item| key(item));
    refs
}

/// Features put into text at once by a thread.
const BATCH: usize = 1024;

/// Batches in memory at once: some for each thread, few enough for any city.
const MOST_BATCHES: usize = 32;

/// The stream of features.
struct Stream<W> {
    out: W,
    is_first: bool,
}

impl<W: Write> Stream<W> {
    /// Writes a feature of each item, in their order.
    fn write<T: Sync>(&mut self, items: &[T], feature: impl Fn(&mut Features, &T) + Sync) -> io::Result<()> {
        for some in items.chunks(BATCH * MOST_BATCHES) {
            let text = |batch: &[T]| {
                let mut features = Features::default();
                batch.iter().for_each(|item| feature(&mut features, item));
                features.out
            };
            let batches: Vec<Vec<u8>> = some.par_chunks(BATCH).map(text).collect();
            for batch in batches {
                // Each feature begins with what parts it from the one before.
                let parted = if std::mem::take(&mut self.is_first) { batch.strip_prefix(b",") } else { None };
                self.out.write_all(parted.unwrap_or(&batch))?;
            }
        }
        Ok(())
    }
}

/// Features as text.
#[derive(Default)]
struct Features {
    out: Vec<u8>,
}

impl Features {
    fn head(&mut self, city: &City) {
        self.text(&format!(
            "{{\"type\":\"FeatureCollection\",\"plat\":{{\"format\":{FORMAT},\"seed\":\"{}\"",
            city.seed
        ));
        self.text(",\"units\":\"m\",\"crs\":");
        self.json(&city.site.crs);
        match city.site.origin {
            Some(at) => self.text(&format!(",\"origin\":[{},{}]", at.x, at.y)),
            None => self.text(",\"origin\":null"),
        }
        self.text("},\"features\":[");
    }

    fn street(&mut self, city: &City, run: &Run) {
        let graph = &city.graph;
        self.begin("street", run.id);
        self.id_field("street", run.street.0);
        self.field("class", &graph.classes().info(run.class).name);
        self.key("width");
        self.lattice(run.half_width.saturating_mul(2));
        let id_of = |key: Option<&NodeKey>| key.map(|&key| graph.node(key).id);
        self.field("from", &id_of(run.nodes.first()));
        self.field("to", &id_of(run.nodes.last()));
        self.field("level", &run.level);
        match run.level {
            0 => {}
            1.. => self.field("bridge", &true),
            _ => self.field("tunnel", &true),
        }
        self.optional("rule", city.origins.get(usize::from(run.origin)));
        self.optional("name", city.street_names.get(&run.street));
        // What rules put on streets; nothing so far.
        self.text(",\"tags\":{}");
        self.geometry("LineString");
        self.points(run.nodes.iter().map(|&key| graph.at(key)));
        self.end();
    }

    fn crossing(&mut self, city: &City, id: NodeId, key: NodeKey) {
        self.begin("crossing", id.0);
        self.field("degree", &city.graph.degree(key));
        self.geometry("Point");
        self.point(city.graph.at(key));
        self.end();
    }

    fn area(&mut self, kind: &str, area: &Area) {
        self.begin(kind, area.id);
        self.optional("name", area.name.as_ref());
        self.polygon(&area.polygon);
    }

    fn block(&mut self, block: &Block) {
        self.begin("block", block.id);
        self.field("quarter", &block.quarter);
        self.field("streets", &block.streets);
        self.polygon(&block.polygon);
    }

    fn parcel(&mut self, parcel: &Parcel, landmark: Option<&Landmark>) {
        self.begin("parcel", parcel.id);
        self.id_field("block", parcel.block);
        self.key("access");
        self.text("[");
        for (i, (street, _)) in parcel.access.iter().enumerate() {
            self.text(if i > 0 { "," } else { "" });
            self.id(street.0);
        }
        self.text("]");
        self.field("use", use_name(parcel.usage));
        if let Some(landmark) = landmark {
            self.field("name", &landmark.name);
            self.id_field("landmark", landmark.id);
        }
        // An inner parcel lies behind others: no access is asked of it.
        let own = parcel.is_inner().then_some("inner");
        let tags: BTreeMap<&str, bool> =
            own.into_iter().chain(parcel.tags.iter().map(|tag| &**tag)).map(|tag| (tag, true)).collect();
        self.field("tags", &tags);
        self.polygon(&parcel.polygon);
    }

    fn building(&mut self, city: &City, building: &Building) {
        self.begin("building", building.id);
        self.id_field("parcel", building.parcel);
        self.field("height", &building.height);
        self.optional("rule", city.origins.get(usize::from(building.origin)));
        self.polygon(&building.footprint);
    }

    /// The ground of a landmark, as it was asked for, with the parcels it became.
    fn landmark(&mut self, landmark: &Landmark) {
        self.begin("landmark", landmark.id);
        self.field("name", &landmark.name);
        self.field("parcels", &landmark.parcels);
        self.polygon(&landmark.ground);
    }

    fn text(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
    }

    /// Opens a feature with its kind and id.
    fn begin(&mut self, kind: &str, id: Id) {
        self.text(",\n{\"type\":\"Feature\",\"properties\":{\"kind\":\"");
        self.text(kind);
        self.text("\",\"id\":");
        self.id(id);
    }

    fn key(&mut self, name: &str) {
        self.text(",\"");
        self.text(name);
        self.text("\":");
    }

    fn field(&mut self, name: &str, value: &(impl Serialize + ?Sized)) {
        self.key(name);
        self.json(value);
    }

    fn optional(&mut self, name: &str, value: Option<&String>) {
        if let Some(value) = value {
            self.field(name, value);
        }
    }

    fn id_field(&mut self, name: &str, id: Id) {
        self.key(name);
        self.id(id);
    }

    fn id(&mut self, id: Id) {
        self.text("\"");
        self.out.extend_from_slice(&id.digits());
        self.text("\"");
    }

    fn json(&mut self, value: &(impl Serialize + ?Sized)) {
        // Names, numbers and lists of them have a text, and memory takes it.
        let _ = serde_json::to_writer(&mut self.out, value);
    }

    /// Closes the properties and opens the coordinates.
    fn geometry(&mut self, name: &str) {
        self.text("},\"geometry\":{\"type\":\"");
        self.text(name);
        self.text("\",\"coordinates\":");
    }

    fn end(&mut self) {
        self.text("}}");
    }

    fn polygon(&mut self, polygon: &Polygon) {
        self.geometry("Polygon");
        for (i, ring) in polygon.rings().enumerate() {
            self.text(if i > 0 { "," } else { "[" });
            // Closed, as GeoJSON asks.
            self.points(ring.iter().chain(ring.first()).copied());
        }
        self.text("]");
        self.end();
    }

    fn points(&mut self, points: impl Iterator<Item = Point>) {
        self.text("[");
        for (i, point) in points.enumerate() {
            self.text(if i > 0 { "," } else { "" });
            self.point(point);
        }
        self.text("]");
    }

    fn point(&mut self, point: Point) {
        self.text("[");
        self.lattice(point.x);
        self.text(",");
        self.lattice(point.y);
        self.text("]");
    }

    /// A lattice length in metres, as the exact decimal without trailing zeros.
    fn lattice(&mut self, units: i32) {
        let size = units.unsigned_abs();
        self.text(if units < 0 { "-" } else { "" });
        self.text(itoa::Buffer::new().format(size / 1024));
        self.text(&decimals()[size as usize % 1024]);
    }
}

/// The decimals of each number of 1024ths, with the point before them.
fn decimals() -> &'static [String] {
    static DECIMALS: LazyLock<Vec<String>> = LazyLock::new(|| {
        let exact = |units: u64| format!(".{:010}", units * 9_765_625);
        (0..1024).map(|units| exact(units).trim_end_matches('0').trim_end_matches('.').to_owned()).collect()
    });
    &DECIMALS
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decimal(units: i32) -> String {
        let mut features = Features::default();
        features.lattice(units);
        String::from_utf8(features.out).unwrap()
    }

    #[test]
    fn decimals_are_exact() {
        assert_eq!(decimal(0), "0");
        assert_eq!(decimal(-1), "-0.0009765625");
        assert_eq!(decimal(1536), "1.5");
        assert_eq!(decimal(-2048), "-2");
    }

    proptest! {
        #[test]
        fn decimals_are_the_shortest_that_round_trip(units in -Point::LIMIT..=Point::LIMIT) {
            let metres = f64::from(units) / 1024.0;
            prop_assert_eq!(decimal(units).parse::<f64>().unwrap(), metres);
            prop_assert_eq!(decimal(units).parse::<f64>().unwrap() * 1024.0, f64::from(units));
        }
    }
}
