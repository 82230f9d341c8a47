//! Streets of files as a street graph.

use super::imported::{ImportedStreet, class_width};
use geom::{Id, Point, Vec2, point::units, tolerance};
use std::collections::BTreeMap;
use std::fmt;
use streets::graph::{Crowding, NewSegment, Refusal};
use streets::{Claim, Class, Classes, NodeId, NodeKey, StreetGraph, StreetId};

/// How to lay imported streets.
#[derive(Clone, Debug)]
pub struct ImportOptions<'a> {
    /// The file's identity (see [`super::file_key`]): the root of the lineage of its streets.
    pub file_key: &'a str,
    /// What claims name as their origin: an index into a table of the caller.
    pub origin: u16,
}

impl<'a> ImportOptions<'a> {
    /// Options for a file, with origin 0.
    pub fn new(file_key: &'a str) -> Self {
        Self { file_key, origin: 0 }
    }
}

/// A line of an imported street that could not be laid.
#[derive(Clone, Debug, PartialEq)]
pub struct RefusedStreet {
    /// The street's key in its file.
    pub key: String,
    /// Which of its lines, from 0.
    pub line: usize,
    /// From here …
    pub from: Point,
    /// … to there.
    pub to: Point,
    /// Why not.
    pub why: Refusal,
}

impl fmt::Display for RefusedStreet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (from, to) = (self.from.metres(), self.to.metres());
        write!(
            f,
            "street {}, line {} from ({:.2}, {:.2}) to ({:.2}, {:.2}) m was not laid: {}",
            self.key, self.line, from.x, from.y, to.x, to.y, self.why
        )
    }
}

/// What an import did. Lengths are in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportLog {
    /// Streets given.
    pub streets: usize,
    /// Length of the lines given.
    pub source_length: f64,
    /// Length of the paths that the lines took through the graph; they differ from the source by tolerances only.
    pub path_length: f64,
    /// Length that the graph gained; the rest of `path_length` runs along streets that lay there before.
    pub laid_length: f64,
    /// Points left out because they lie closer to their predecessor than streets can be laid (7 cm).
    pub merged_points: usize,
    /// Length of the lines that were refused.
    pub refused_length: f64,
    /// Lines that were refused.
    pub refused: Vec<RefusedStreet>,
    /// Classes that the graph does not know, counted; their streets became the least important class.
    pub unknown_classes: BTreeMap<String, usize>,
    /// Names of the streets that have one.
    pub names: BTreeMap<StreetId, String>,
}

impl ImportLog {
    /// Length of new lines that overlap what lay there before, in metres.
    pub fn overlapped_length(&self) -> f64 {
        (self.path_length - self.laid_length).max(0.0)
    }
}

/// A graph of nothing but imported streets. The same streets give the same graph in whatever order they are listed.
pub fn into_graph(streets: &[ImportedStreet], classes: Classes, options: &ImportOptions) -> (StreetGraph, ImportLog) {
    let mut graph = StreetGraph::new(classes);
    let log = lay_streets(&mut graph, streets, options);
    (graph, log)
}

/// Lays imported streets into a graph, in order of their keys. Nothing is lost silently: what cannot be laid is in the log.
///
/// A street's id is hash(file, key); a node's is hash(OpenStreetMap node) where there is one, else hash(street, ordinal
/// of the point in the street): never the position.
pub fn lay_streets(graph: &mut StreetGraph, streets: &[ImportedStreet], options: &ImportOptions) -> ImportLog {
    let mut ordered: Vec<&ImportedStreet> = streets.iter().collect();
    ordered.sort_by(|a, b| a.key.cmp(&b.key));
    let mut log = ImportLog { streets: streets.len(), ..ImportLog::default() };
    let file = Id::of_text("imported file", options.file_key);
    let before = graph.total_length();
    for street in ordered {
        Laying::new(graph, street, file, options.origin, &mut log).lay(graph, &mut log);
    }
    log.laid_length = graph.total_length() - before;
    log
}

/// The id of the street that a record of a file becomes.
pub(crate) fn import_id(file_key: &str, record: &str) -> StreetId {
    record_id(Id::of_text("imported file", file_key), record)
}

fn record_id(file: Id, record: &str) -> StreetId {
    StreetId(file.with(&[Id::of_text("record", record).0]))
}

/// One street while it is laid.
struct Laying<'a> {
    street: &'a ImportedStreet,
    claim: Claim,
}

impl<'a> Laying<'a> {
    fn new(graph: &StreetGraph, street: &'a ImportedStreet, file: Id, origin: u16, log: &mut ImportLog) -> Self {
        let id = record_id(file, &street.key);
        if let Some(name) = &street.name {
            log.names.insert(id, name.clone());
        }
        let class = class_in(graph.classes(), &street.class, log);
        let width = street.width.unwrap_or_else(|| class_width(&street.class));
        Self {
            street,
            claim: Claim { street: id, class, half_width: units(width / 2.0).max(1), origin, forward: true },
        }
    }

    fn lay(&self, graph: &mut StreetGraph, log: &mut ImportLog) {
        log.source_length += self.street.length();
        let points = spaced(&self.street.points);
        log.merged_points += self.street.points.len() - points.len();
        for (line, ends) in points.windows(2).enumerate() {
            let [from, to] = [ends[0], ends[1]];
            let new = NewSegment {
                from: from.1,
                to: to.1,
                from_id: self.node_id(from.0),
                to_id: self.node_id(to.0),
                claim: self.claim,
                level: self.street.level,
            };
            match graph.insert(&new, Crowding::Join) {
                Ok(insertion) => log.path_length += length_of(graph, &insertion.path),
                Err(why) => {
                    log.refused_length += from.1.distance(to.1);
                    let key = self.street.key.clone();
                    log.refused.push(RefusedStreet { key, line, from: from.1, to: to.1, why });
                }
            }
        }
    }

    fn node_id(&self, ordinal: usize) -> NodeId {
        match self.street.refs.get(ordinal) {
            Some(&node) => NodeId(Id::root("osm node", &[node as u64 as u128])),
            None => NodeId(self.claim.street.0.child(ordinal as u64)),
        }
    }
}

fn length_of(graph: &StreetGraph, path: &[NodeKey]) -> f64 {
    path.windows(2).map(|ends| graph.at(ends[0]).distance(graph.at(ends[1]))).sum()
}

/// The points at least [`tolerance::LAYING`] from their predecessor, with their ordinals. First and last stay, since
/// other streets may meet there; what lies too close before the last goes.
fn spaced(points: &[Vec2]) -> Vec<(usize, Point)> {
    let least = i64::from(tolerance::LAYING) * i64::from(tolerance::LAYING);
    let is_close = |kept: &[(usize, Point)], p: Point| kept.last().is_some_and(|k| k.1.distance_squared(p) < least);
    let mut kept: Vec<(usize, Point)> = Vec::with_capacity(points.len());
    let on_lattice = points.iter().map(|&point| Point::from_metres(point)).enumerate();
    for (i, point) in on_lattice {
        let is_last = i + 1 == points.len();
        while is_last && kept.len() > 1 && is_close(&kept, point) {
            kept.pop();
        }
        if is_last || !is_close(&kept, point) {
            kept.push((i, point));
        }
    }
    kept
}

fn class_in(classes: &Classes, name: &str, log: &mut ImportLog) -> Class {
    classes.named(name).unwrap_or_else(|| {
        *log.unknown_classes.entry(name.to_owned()).or_default() += 1;
        Class((classes.iter().count() - 1) as u8)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sources::read_osm;
    use proptest::prelude::*;
    use std::path::Path;

    fn street(key: &str, points: &[(f64, f64)]) -> ImportedStreet {
        ImportedStreet {
            key: key.to_owned(),
            name: None,
            class: "minor".to_owned(),
            width: Some(12.0),
            level: 0,
            points: points.iter().map(|&(x, y)| Vec2::new(x, y)).collect(),
            refs: Vec::new(),
        }
    }

    fn laid(streets: &[ImportedStreet]) -> (StreetGraph, ImportLog) {
        into_graph(streets, Classes::default(), &ImportOptions::new("test.osm"))
    }

    #[test]
    fn a_cross_has_one_crossing_and_all_its_length() {
        let (graph, log) =
            laid(&[street("a", &[(0.0, 50.0), (100.0, 50.0)]), street("b", &[(50.0, 0.0), (50.0, 100.0)])]);
        assert_eq!((graph.node_count(), graph.segment_count()), (5, 4));
        assert_eq!((log.streets, log.source_length, log.path_length), (2, 200.0, 200.0));
        assert_eq!((log.laid_length, log.overlapped_length()), (200.0, 0.0));
        assert!(log.refused.is_empty());
        let (crossing, _) = graph.nearest_node(Point::from_metres(Vec2::new(50.0, 50.0)), 2).unwrap();
        assert_eq!(graph.degree(crossing), 4);
    }

    #[test]
    fn a_bridge_passes_over_and_ends_on_the_ground() {
        let mut bridge = street("b", &[(50.0, 0.0), (50.0, 100.0)]);
        bridge.level = 1;
        let (graph, _) =
            laid(&[street("a", &[(0.0, 50.0), (100.0, 50.0)]), bridge, street("c", &[(50.0, 100.0), (90.0, 100.0)])]);
        assert_eq!((graph.node_count(), graph.segment_count()), (5, 3));
        let (end, _) = graph.nearest_node(Point::from_metres(Vec2::new(50.0, 100.0)), 2).unwrap();
        assert_eq!(graph.degree(end), 2);
    }

    #[test]
    fn attributes_come_along() {
        let mut named = street("a", &[(0.0, 0.0), (100.0, 0.0)]);
        (named.class, named.width, named.name) = ("major".to_owned(), None, Some("Broadway".to_owned()));
        let (graph, log) = laid(&[named]);
        let key = graph.segments_by_id()[0];
        let claim = graph.segment(key).leading();
        assert_eq!((claim.class, claim.half_width), (Classes::MAJOR, 10 * 1024));
        assert_eq!(log.names.get(&claim.street).map(String::as_str), Some("Broadway"));
    }

    #[test]
    fn an_unknown_class_is_the_least_important_and_counted() {
        let mut odd = street("a", &[(0.0, 0.0), (100.0, 0.0)]);
        odd.class = "canal".to_owned();
        let (graph, log) = laid(&[odd]);
        assert_eq!(graph.segment(graph.segments_by_id()[0]).class(), Classes::MINOR);
        assert_eq!(log.unknown_classes, BTreeMap::from([("canal".to_owned(), 1)]));
    }

    #[test]
    fn overlap_is_told_from_new_length() {
        let (graph, log) = laid(&[street("a", &[(0.0, 0.0), (100.0, 0.0)]), street("b", &[(40.0, 0.0), (140.0, 0.0)])]);
        assert_eq!((log.laid_length, log.path_length, log.overlapped_length()), (140.0, 200.0, 60.0));
        assert_eq!(graph.segment_count(), 3);
    }

    #[test]
    fn points_too_close_are_merged_but_ends_stay() {
        let (graph, log) = laid(&[street("a", &[(0.0, 0.0), (0.05, 0.0), (10.0, 0.0), (19.96, 0.0), (20.0, 0.0)])]);
        assert_eq!((log.merged_points, graph.node_count(), log.path_length), (2, 3, 20.0));
        assert!(log.refused.is_empty());
    }

    #[test]
    fn a_street_without_room_is_refused_and_said() {
        let (graph, log) = laid(&[street("speck", &[(0.0, 0.0), (0.05, 0.0)])]);
        assert_eq!(graph.segment_count(), 0);
        assert_eq!(log.refused.len(), 1);
        assert_eq!((log.refused[0].key.as_str(), log.refused[0].why), ("speck", Refusal::TooShort));
        assert!(log.refused[0].to_string().starts_with("street speck, line 0 from (0.00, 0.00)"), "{}", log.refused[0]);
    }

    #[test]
    fn ids_come_from_records_not_from_places() {
        let mut a = street("7", &[(0.0, 0.0), (100.0, 0.0)]);
        a.refs = vec![70, 71];
        let mut moved = a.clone();
        moved.points.iter_mut().for_each(|point| *point += Vec2::new(3.0, 4.0));
        let ids = |graph: &StreetGraph| {
            (graph.nodes_by_id().into_iter().map(|k| graph.node(k).id).collect::<Vec<_>>(), graph.streets())
        };
        let (first, _) = laid(&[a.clone()]);
        assert_eq!(ids(&first), ids(&laid(&[moved]).0));
        assert_ne!(ids(&first).1, into_graph(&[a], Classes::default(), &ImportOptions::new("other.osm")).0.streets());
        assert!(first.find_node(NodeId(Id::root("osm node", &[70]))).is_some());
    }

    #[test]
    fn krems_is_imported_whole() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/krems/krems.osm.pbf");
        let file = read_osm(&path, None).unwrap();
        let (graph, log) = laid(&file.streets);
        assert!(log.refused.is_empty(), "{:?}", log.refused);
        assert!((log.path_length / log.source_length - 1.0).abs() < 1e-4);
        assert!((log.source_length / 1000.0 - 94.87).abs() < 0.01, "{}", log.source_length);
        assert!(log.overlapped_length() < 10.0);
        let mut listed = file.streets.clone();
        listed.reverse();
        assert_eq!(laid(&listed).0.digest(), graph.digest());
    }

    proptest! {
        #[test]
        fn order_does_not_matter_and_nothing_is_lost(
            lines in proptest::collection::vec(proptest::collection::vec((0.0..300.0f64, 0.0..300.0f64), 2..5), 1..12),
            turn in 0usize..12,
        ) {
            let streets: Vec<_> = lines.iter().enumerate().map(|(i, line)| street(&format!("{i}"), line)).collect();
            let (graph, log) = laid(&streets);
            let mut turned = streets.clone();
            turned.rotate_left(turn % streets.len());
            let (again, log_again) = laid(&turned);
            prop_assert_eq!(graph.digest(), again.digest());
            // Each line is there or refused; each may bend by the laying distance at both ends and at what it passes.
            prop_assert!((log.path_length + log.refused_length - log.source_length).abs() < 0.15 * 12.0 * 4.0);
            prop_assert_eq!(log, log_again);
        }
    }
}
