//! `layout.geojson`: the whole city as one feature collection in local metres, one feature a line.
//!
//! Written as a stream: a million parcels take no more memory than one. Every coordinate is the exact decimal of a
//! lattice point (k / 1024 has at most ten decimals), so reading the file back gives the same lattice points.

use crate::{Area, City, Landmark};
use buildings::Building;
use geom::{Id, Point, Polygon};
use layout::{Block, Parcel, Use};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};
use streets::runs::Run;
use streets::{NodeId, NodeKey};

/// The version of the format that [`write_layout`] writes.
pub const FORMAT: u32 = 1;

/// Writes a city as `layout.geojson` (see the module); features by kind (street, crossing, quarter, block, district,
/// parcel, building, landmark), then by id.
///
/// # Errors
/// Those of the writer.
pub fn write_layout(city: &City, out: impl Write) -> io::Result<()> {
    let mut features = Features { out, first: true };
    features.head(city)?;
    for run in sorted(&city.runs, |run| run.id) {
        features.street(city, run)?;
    }
    for (id, key) in crossings(city) {
        features.crossing(city, id, key)?;
    }
    features.quarters(&city.quarters)?;
    for block in sorted(&city.blocks, |block| block.id) {
        features.block(block)?;
    }
    features.districts(&city.districts)?;
    let landmark_of = landmarks_by_parcel(city);
    for parcel in sorted(&city.parcels, |parcel| parcel.id) {
        features.parcel(parcel, landmark_of.get(&parcel.id).copied())?;
    }
    for building in sorted(&city.buildings, |building| building.id) {
        features.building(city, building)?;
    }
    features.landmarks(&city.landmarks)?;
    features.foot()
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

/// The stream of features.
struct Features<W> {
    out: W,
    first: bool,
}

impl<W: Write> Features<W> {
    fn head(&mut self, city: &City) -> io::Result<()> {
        write!(self.out, "{{\"type\":\"FeatureCollection\",\"plat\":{{\"format\":{FORMAT},\"seed\":\"{}\"", city.seed)?;
        write!(self.out, ",\"units\":\"m\",\"crs\":")?;
        self.json(&city.site.crs)?;
        match city.site.origin {
            Some(at) => write!(self.out, ",\"origin\":[{},{}]", at.x, at.y)?,
            None => write!(self.out, ",\"origin\":null")?,
        }
        write!(self.out, "}},\"features\":[")
    }

    fn foot(&mut self) -> io::Result<()> {
        self.out.write_all(b"\n]}\n")?;
        self.out.flush()
    }

    fn street(&mut self, city: &City, run: &Run) -> io::Result<()> {
        let graph = &city.graph;
        self.begin("street", run.id)?;
        self.field("street", &run.street)?;
        self.field("class", &graph.classes().info(run.class).name)?;
        self.key("width")?;
        self.lattice(run.half_width.saturating_mul(2))?;
        let id_of = |key: Option<&NodeKey>| key.map(|&key| graph.node(key).id);
        self.field("from", &id_of(run.nodes.first()))?;
        self.field("to", &id_of(run.nodes.last()))?;
        self.field("level", &run.level)?;
        match run.level {
            0 => {}
            1.. => self.field("bridge", &true)?,
            _ => self.field("tunnel", &true)?,
        }
        self.optional("rule", city.origins.get(usize::from(run.origin)))?;
        self.optional("name", city.street_names.get(&run.street))?;
        self.no_tags()?;
        self.geometry("LineString")?;
        self.points(run.nodes.iter().map(|&key| graph.at(key)))?;
        self.end()
    }

    fn crossing(&mut self, city: &City, id: NodeId, key: NodeKey) -> io::Result<()> {
        self.begin("crossing", id)?;
        self.field("degree", &city.graph.degree(key))?;
        self.geometry("Point")?;
        self.point(city.graph.at(key))?;
        self.end()
    }

    fn quarters(&mut self, areas: &[Area]) -> io::Result<()> {
        for area in sorted(areas, |area| area.id) {
            self.begin("quarter", area.id)?;
            self.polygon(&area.polygon)?;
        }
        Ok(())
    }

    fn districts(&mut self, areas: &[Area]) -> io::Result<()> {
        for area in sorted(areas, |area| area.id) {
            self.begin("district", area.id)?;
            self.optional("name", area.name.as_ref())?;
            self.polygon(&area.polygon)?;
        }
        Ok(())
    }

    fn block(&mut self, block: &Block) -> io::Result<()> {
        self.begin("block", block.id)?;
        self.field("quarter", &block.quarter)?;
        self.field("streets", &block.streets)?;
        self.polygon(&block.polygon)
    }

    fn parcel(&mut self, parcel: &Parcel, landmark: Option<&Landmark>) -> io::Result<()> {
        self.begin("parcel", parcel.id)?;
        self.field("block", &parcel.block)?;
        let access: Vec<_> = parcel.access.iter().map(|(street, _)| street).collect();
        self.field("access", &access)?;
        self.field("use", use_name(parcel.usage))?;
        if let Some(landmark) = landmark {
            self.field("name", &landmark.name)?;
            self.field("landmark", &landmark.id)?;
        }
        // An inner parcel lies behind others: no access is asked of it.
        let own = parcel.is_inner().then_some("inner");
        let tags: BTreeMap<&str, bool> =
            own.into_iter().chain(parcel.tags.iter().map(|tag| &**tag)).map(|tag| (tag, true)).collect();
        self.field("tags", &tags)?;
        self.polygon(&parcel.polygon)
    }

    /// The grounds of landmarks, as they were asked for, with the parcels they became.
    fn landmarks(&mut self, landmarks: &[Landmark]) -> io::Result<()> {
        for landmark in sorted(landmarks, |landmark| landmark.id) {
            self.begin("landmark", landmark.id)?;
            self.field("name", &landmark.name)?;
            self.field("parcels", &landmark.parcels)?;
            self.polygon(&landmark.ground)?;
        }
        Ok(())
    }

    fn building(&mut self, city: &City, building: &Building) -> io::Result<()> {
        self.begin("building", building.id)?;
        self.field("parcel", &building.parcel)?;
        self.field("height", &building.height)?;
        self.optional("rule", city.origins.get(usize::from(building.origin)))?;
        self.polygon(&building.footprint)
    }

    /// Opens a feature with its kind and id.
    fn begin(&mut self, kind: &str, id: impl std::fmt::Display) -> io::Result<()> {
        let comma = if std::mem::take(&mut self.first) { "" } else { "," };
        write!(self.out, "{comma}\n{{\"type\":\"Feature\",\"properties\":{{\"kind\":\"{kind}\",\"id\":\"{id}\"")
    }

    fn key(&mut self, name: &str) -> io::Result<()> {
        write!(self.out, ",\"{name}\":")
    }

    fn field(&mut self, name: &str, value: &(impl Serialize + ?Sized)) -> io::Result<()> {
        self.key(name)?;
        self.json(value)
    }

    fn optional(&mut self, name: &str, value: Option<&String>) -> io::Result<()> {
        value.map_or(Ok(()), |value| self.field(name, value))
    }

    /// What rules put on streets; nothing so far.
    fn no_tags(&mut self) -> io::Result<()> {
        self.out.write_all(b",\"tags\":{}")
    }

    fn json(&mut self, value: &(impl Serialize + ?Sized)) -> io::Result<()> {
        serde_json::to_writer(&mut self.out, value).map_err(io::Error::from)
    }

    /// Closes the properties and opens the coordinates.
    fn geometry(&mut self, name: &str) -> io::Result<()> {
        write!(self.out, "}},\"geometry\":{{\"type\":\"{name}\",\"coordinates\":")
    }

    fn end(&mut self) -> io::Result<()> {
        self.out.write_all(b"}}")
    }

    fn polygon(&mut self, polygon: &Polygon) -> io::Result<()> {
        self.geometry("Polygon")?;
        self.out.write_all(b"[")?;
        self.ring(&polygon.outer)?;
        for hole in &polygon.holes {
            self.out.write_all(b",")?;
            self.ring(hole)?;
        }
        self.out.write_all(b"]")?;
        self.end()
    }

    /// A ring, closed as GeoJSON asks.
    fn ring(&mut self, ring: &[Point]) -> io::Result<()> {
        self.points(ring.iter().chain(ring.first()).copied())
    }

    fn points(&mut self, points: impl Iterator<Item = Point>) -> io::Result<()> {
        let mut before: &[u8] = b"[";
        for point in points {
            self.out.write_all(before)?;
            self.point(point)?;
            before = b",";
        }
        self.out.write_all(if before == b"[" { b"[]" } else { b"]" })
    }

    fn point(&mut self, point: Point) -> io::Result<()> {
        self.out.write_all(b"[")?;
        self.lattice(point.x)?;
        self.out.write_all(b",")?;
        self.lattice(point.y)?;
        self.out.write_all(b"]")
    }

    /// A lattice length in metres, as the exact decimal without trailing zeros.
    fn lattice(&mut self, units: i32) -> io::Result<()> {
        let size = units.unsigned_abs();
        let sign = if units < 0 { "-" } else { "" };
        write!(self.out, "{sign}{}", size / 1024)?;
        let mut decimals = u64::from(size % 1024) * 9_765_625;
        if decimals == 0 {
            return Ok(());
        }
        let mut digits = 10;
        while decimals.is_multiple_of(10) {
            decimals /= 10;
            digits -= 1;
        }
        write!(self.out, ".{decimals:0digits$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decimal(units: i32) -> String {
        let mut features = Features { out: Vec::new(), first: true };
        features.lattice(units).unwrap();
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
