//! OpenStreetMap extracts: what XML and PBF files have in common.

use super::error::{SourceError, read_bytes};
use super::imported::{ImportedStreet, StreetFile, Tags, bounds_of, osm_level, osm_width, sort_by_key};
use super::projection::Frame;
use super::{osm_pbf, osm_xml};
use geom::{Bounds, Point, Vec2};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads the drivable and pedestrian streets of an `.osm` or `.osm.pbf` file (told apart by content). A street's key is the
/// id of its way; its class, width and level come from tags `highway`, `width`, `lanes`, `bridge`, `tunnel`, `layer`.
/// Ways that refer to nodes outside the file give the parts that are inside. Positions are laid into `frame`, or into
/// one chosen around the file.
///
/// # Errors
/// [`SourceError`] for what is no OpenStreetMap file, is cut off or damaged, or has no street at all.
pub fn read_osm(path: &Path, frame: Option<Frame>) -> Result<StreetFile, SourceError> {
    let bytes = read_bytes(path)?;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    if text.trim_ascii_start().starts_with(b"<") {
        return parse_osm_xml(path, &bytes, frame);
    }
    if text.trim_ascii().is_empty() {
        return Err(SourceError::kind(path, "is empty", "fetch or export the file again".to_owned()));
    }
    if bytes.starts_with(b"\x1f\x8b") || bytes.starts_with(b"BZh") {
        return Err(SourceError::kind(path, "is compressed", "unpack it first: `gunzip` or `bunzip2`".to_owned()));
    }
    parse_osm_pbf(path, &bytes, frame)
}

/// [`read_osm`] of XML at hand; `path` only names it in errors.
///
/// # Errors
/// See [`read_osm`].
pub fn parse_osm_xml(path: &Path, bytes: &[u8], frame: Option<Frame>) -> Result<StreetFile, SourceError> {
    osm_xml::parse(path, bytes)?.into_streets(path, frame)
}

/// [`read_osm`] of a PBF file at hand; `path` only names it in errors.
///
/// # Errors
/// See [`read_osm`].
pub fn parse_osm_pbf(path: &Path, bytes: &[u8], frame: Option<Frame>) -> Result<StreetFile, SourceError> {
    osm_pbf::parse(path, bytes)?.into_streets(path, frame)
}

/// A way that is a street, before its nodes are looked up.
pub(super) struct Way {
    id: i64,
    pattern: ImportedStreet,
    refs: Vec<i64>,
}

/// What is read of a file before anything is projected.
#[derive(Default)]
pub(super) struct OsmData {
    /// Streets, in the file's order.
    pub ways: Vec<Way>,
    /// Longitude and latitude by id.
    pub nodes: FxHashMap<i64, Vec2>,
    /// South-west and north-east corner that the file states, degrees.
    pub bounds: Option<(Vec2, Vec2)>,
    left_out: BTreeMap<String, usize>,
}

impl OsmData {
    /// Keeps a way if it is a street.
    pub fn way(&mut self, id: i64, tags: &Tags, refs: Vec<i64>) {
        match tags.class() {
            None => {}
            Some(Err(reason)) => self.leave_out(reason),
            Some(Ok(class)) => self.ways.push(Way { id, pattern: pattern_of(id, class, tags), refs }),
        }
    }

    /// States the corners, unless they are none.
    pub fn set_bounds(&mut self, min: Vec2, max: Vec2) {
        if min.cmplt(max).all() && min.is_finite() && max.is_finite() {
            self.bounds = Some((min, max));
        }
    }

    fn leave_out(&mut self, reason: impl Into<String>) {
        *self.left_out.entry(reason.into()).or_default() += 1;
    }

    fn into_streets(mut self, path: &Path, frame: Option<Frame>) -> Result<StreetFile, SourceError> {
        let mut streets = Vec::new();
        for way in std::mem::take(&mut self.ways) {
            self.parts_of(&way, &mut streets);
        }
        if streets.is_empty() {
            let hint = "extract the ways with tag `highway` together with their nodes (`osmium extract`)";
            return Err(SourceError::kind(path, "has no street in it", hint.to_owned()));
        }
        let frame = match frame {
            Some(frame) => frame,
            None => self.frame_around(path, &streets)?,
        };
        for street in &mut streets {
            let record = format!("way {}", street.key);
            street.place(path, &record, Some(&frame))?;
        }
        let all = streets.len();
        streets.retain(|street| street.points.len() > 1);
        (streets.len()..all).for_each(|_| self.leave_out("no length"));
        sort_by_key(&mut streets);
        let bounds = self.stated_bounds(&frame).unwrap_or_else(|| bounds_of(&streets));
        Ok(StreetFile { frame: Some(frame), bounds, streets, left_out: self.left_out })
    }

    /// The unbroken parts of a way whose nodes the file has; points in degrees.
    fn parts_of(&mut self, way: &Way, streets: &mut Vec<ImportedStreet>) {
        let mut parts = 0;
        for run in way.refs.split(|id| !self.nodes.contains_key(id)).filter(|run| run.len() > 1) {
            let key = if parts == 0 { way.id.to_string() } else { format!("{}/{parts}", way.id) };
            let points = run.iter().map(|id| self.nodes[id]).collect();
            streets.push(ImportedStreet { key, points, refs: run.to_vec(), ..way.pattern.clone() });
            parts += 1;
        }
        if parts == 0 {
            self.leave_out("fewer than two nodes in the file");
        }
    }

    fn frame_around(&self, path: &Path, streets: &[ImportedStreet]) -> Result<Frame, SourceError> {
        let points = || streets.iter().flat_map(|street| &street.points);
        let (min, max) = self.bounds.unwrap_or_else(|| {
            (points().fold(Vec2::INFINITY, |m, &p| m.min(p)), points().fold(Vec2::NEG_INFINITY, |m, &p| m.max(p)))
        });
        Frame::around(min, max).map_err(|e| SourceError::record(path, "the whole file", e.to_string()))
    }

    fn stated_bounds(&self, frame: &Frame) -> Option<Bounds> {
        let (min, max) = self.bounds?;
        let corners = [(min.x, min.y), (max.x, min.y), (min.x, max.y), (max.x, max.y)];
        let corners = corners.map(|(lon, lat)| Point::try_from_metres(frame.local(lon, lat).ok()?));
        Bounds::of(corners.into_iter().collect::<Option<Vec<_>>>()?)
    }
}

fn pattern_of(id: i64, class: &str, tags: &Tags) -> ImportedStreet {
    ImportedStreet {
        key: id.to_string(),
        name: tags.get("name").map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned),
        class: class.to_owned(),
        width: Some(osm_width(tags)),
        level: osm_level(tags),
        points: Vec::new(),
        refs: Vec::new(),
    }
}
