//! Polygons: validity (V4, V5, V22), overlap (V4, V6, V22), ownership (V8, V22), access (V10).

use super::ground::{Area, Ground};
use super::index::Grid;
use super::{SLIVER_M, ValidationReport};
use crate::Until;
use geom::boolean::{difference, intersection};
use geom::polygon::{ring_edges, ring_is_simple};
use geom::predicates::{crosses_properly, cut, meets, orient};
use geom::{Bounds, Point, Polygon, tolerance};
use std::collections::BTreeMap;

/// Rings up to this size are searched for the place where they are broken.
const SEARCHED_RING: usize = 2_000;

/// Checks that every polygon is valid and has an area, and that parcels have no edges that rounding could turn over.
pub fn check_shapes(ground: &Ground<'_>, report: &mut ValidationReport) {
    let kinds = [
        ("quarter", "V4", &ground.quarters),
        ("block", "V4", &ground.blocks),
        ("parcel", "V5", &ground.parcels),
        ("building", "V22", &ground.buildings),
    ];
    for (kind, rule, areas) in kinds {
        for area in areas.iter().filter(|area| !area.sound) {
            let (why, place) = fault_of(&area.polygon);
            report.add(rule, &[(kind, area.id)], place, format!("{kind} {}: {why}", area.id));
        }
    }
    let least = i64::from(tolerance::PARCEL_EDGE) * i64::from(tolerance::PARCEL_EDGE);
    for parcel in ground.parcels.iter().filter(|parcel| parcel.sound) {
        if let Some((a, b)) = parcel.polygon.edges().find(|(a, b)| a.distance_squared(*b) < least) {
            let message = format!("parcel {} has an edge of {:.4} m", parcel.id, a.distance(b));
            report.add("V5", &[("parcel", parcel.id)], Some(a), message);
        }
    }
}

/// Why a polygon is not sound, and where.
fn fault_of(polygon: &Polygon) -> (String, Option<Point>) {
    let first = polygon.outer.first().copied();
    let broken = polygon.rings().find(|ring| !ring_is_simple(ring));
    match broken {
        Some(ring) if ring.len() < 3 => ("a ring of fewer than three corners".into(), ring.first().copied().or(first)),
        Some(ring) => ("a ring crosses or touches itself".into(), self_contact(ring).or(first)),
        None if polygon.area() <= SLIVER_M => (format!("an area of {:.3} m²", polygon.area()), first),
        None => ("its rings overlap or do not bound one area".into(), first),
    }
}

/// A point where a ring meets itself, for rings that are not too long to try all pairs.
fn self_contact(ring: &[Point]) -> Option<Point> {
    let edges: Vec<_> = ring_edges(ring).collect();
    let n = edges.len();
    let pairs = (0..n.min(SEARCHED_RING)).flat_map(|i| (i + 2..n.min(SEARCHED_RING)).map(move |j| (i, j)));
    let contact = |(i, j): (usize, usize)| {
        let ((a, b), (c, d)) = (edges[i], edges[j]);
        let neighbours = i == 0 && j == n - 1;
        (!neighbours && meets(a, b, c, d)).then(|| cut(a, b, c, d).unwrap_or(a))
    };
    pairs.filter_map(contact).next()
}

/// Checks that blocks, parcels and buildings keep out of their like.
pub fn check_overlaps(ground: &Ground<'_>, report: &mut ValidationReport) {
    let kinds =
        [("block", "V4", &ground.blocks), ("parcel", "V6", &ground.parcels), ("building", "V22", &ground.buildings)];
    for (kind, rule, areas) in kinds {
        for (i, j, (overlap, place)) in overlapping(areas) {
            let (a, b) = (areas[i].id, areas[j].id);
            let message = format!("{kind}s {a} and {b} overlap by {overlap:.2} m²");
            report.add(rule, &[(kind, a), (kind, b)], Some(place), message);
        }
    }
}

/// Pairs that overlap by more than a sliver, with the common area and a place in it.
fn overlapping(areas: &[Area<'_>]) -> Vec<(usize, usize, (f64, Point))> {
    let sound: Vec<usize> = (0..areas.len()).filter(|&i| areas[i].sound).collect();
    let grid = Grid::new(sound.iter().map(|&i| areas[i].bounds).collect());
    let mut found = Vec::new();
    grid.for_pairs(|i, j| {
        let (i, j) = (sound[i], sound[j]);
        let (a, b) = (&areas[i].polygon, &areas[j].polygon);
        if !separable(&a.outer, &b.outer) {
            found.extend(overlap(a, b).map(|overlap| (i, j, overlap)));
        }
    });
    found.sort_unstable_by_key(|&(i, j, _)| (i, j));
    found
}

/// Whether the line along an edge of either ring parts them: a quick and exact "no" for most neighbours.
pub fn separable(a: &[Point], b: &[Point]) -> bool {
    let parts = |ring: &[Point], other: &[Point]| {
        ring_edges(ring).any(|(p, q)| {
            ring.iter().all(|&corner| orient(p, q, corner) >= 0)
                && other.iter().all(|&corner| orient(p, q, corner) <= 0)
        })
    };
    parts(a, b) || parts(b, a)
}

/// The common area of two polygons with a place in it, when it is more than a sliver.
fn overlap(a: &Polygon, b: &Polygon) -> Option<(f64, Point)> {
    let common = intersection(std::slice::from_ref(a), std::slice::from_ref(b));
    let area: f64 = common.iter().map(Polygon::area).sum();
    let sliver = SLIVER_M * a.perimeter().min(b.perimeter()) / 2.0;
    if area <= sliver.max(SLIVER_M) {
        return None;
    }
    common.iter().find(|piece| is_deep(piece)).map(|piece| (area, piece.pole(SLIVER_M)))
}

/// Whether a disc of the sliver's width as radius fits in.
fn is_deep(piece: &Polygon) -> bool {
    // A disc of radius area / perimeter always fits: no need to look for it.
    piece.area() > SLIVER_M * piece.perimeter() || piece.distance_to_rim(piece.pole(SLIVER_M / 8.0).metres()) > SLIVER_M
}

/// Checks that parcels lie in the block and buildings in the parcel that they name.
pub fn check_owners(ground: &Ground<'_>, report: &mut ValidationReport) {
    let blocks = by_id(&ground.blocks);
    let parcels = by_id(&ground.parcels);
    let owned = [
        ("parcel", "V8", &ground.parcels, "block", &blocks, &ground.blocks),
        ("building", "V22", &ground.buildings, "parcel", &parcels, &ground.parcels),
    ];
    for (kind, rule, areas, owner_kind, owners, owner_areas) in owned {
        for area in areas {
            let named = if kind == "parcel" { &area.says.block } else { &area.says.parcel };
            let Some(name) = named.as_deref() else { continue };
            let who = [(kind, area.id), (owner_kind, name)];
            let Some(&owner) = owners.get(name) else {
                report.add(rule, &who[..1], None, format!("{kind} {} names unknown {owner_kind} {name}", area.id));
                continue;
            };
            if let Some(place) = leaves(area, &owner_areas[owner]) {
                report.add(rule, &who, Some(place), format!("{kind} {} leaves its {owner_kind} {name}", area.id));
            }
        }
    }
}

fn by_id<'a>(areas: &[Area<'a>]) -> BTreeMap<&'a str, usize> {
    areas.iter().enumerate().map(|(i, area)| (area.id, i)).collect()
}

/// Where an area leaves another by more than a sliver along the border; `None` also for what is not sound.
fn leaves(area: &Area<'_>, owner: &Area<'_>) -> Option<Point> {
    if !area.sound || !owner.sound || surely_inside(area, owner) {
        return None;
    }
    let rest = difference(std::slice::from_ref(&area.polygon), std::slice::from_ref(&owner.polygon));
    // What a border of the sliver's width along the owner would take away.
    let beyond = |piece: &Polygon| (piece.area() - SLIVER_M * piece.perimeter() / 2.0).max(0.0);
    let outside: f64 = rest.iter().map(beyond).sum();
    if outside <= SLIVER_M {
        return None;
    }
    rest.iter().max_by(|a, b| a.area().total_cmp(&b.area())).map(|piece| piece.pole(SLIVER_M))
}

/// Whether no edge leaves the owner: a quick and exact "yes" for most. Owners with holes are left to the slow way.
fn surely_inside(area: &Area<'_>, owner: &Area<'_>) -> bool {
    if !owner.polygon.holes.is_empty() || !area.polygon.outer.iter().all(|&p| owner.polygon.contains(p)) {
        return false;
    }
    // An edge between two points of the rim can pass outside without crossing properly only where a corner of the
    // owner lies on it.
    owner.polygon.edges().filter(|&(c, d)| Bounds::between(c, d).overlaps(&area.bounds)).all(|(c, d)| {
        ring_edges(&area.polygon.outer).all(|(a, b)| {
            let passes = orient(a, b, c) == 0 && c != a && c != b && Bounds::between(a, b).contains(c);
            !passes && !crosses_properly(a, b, c, d)
        })
    }) && !outlines_a_notch(&area.polygon, &owner.polygon)
}

/// Whether an edge of the area joins two corners of the owner that are no neighbours: it may bridge a notch.
fn outlines_a_notch(area: &Polygon, owner: &Polygon) -> bool {
    let ring = &owner.outer;
    if ring.len() <= 3 || is_convex(ring) {
        return false;
    }
    let on_rim = |p: Point| ring_edges(ring).any(|(c, d)| geom::predicates::on_segment(c, d, p));
    let along = |a: Point, b: Point| ring_edges(ring).any(|(c, d)| orient(c, d, a) == 0 && orient(c, d, b) == 0);
    ring_edges(&area.outer).any(|(a, b)| on_rim(a) && on_rim(b) && !along(a, b))
}

fn is_convex(ring: &[Point]) -> bool {
    let n = ring.len();
    (0..n).all(|i| orient(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) >= 0)
}

/// Checks that what is built can be reached from a street that is there.
pub fn check_access(ground: &Ground<'_>, until: Until, report: &mut ValidationReport) {
    if until == Until::Streets {
        return;
    }
    for parcel in &ground.parcels {
        let Some(access) = &parcel.says.access else { continue };
        let who = [("parcel", parcel.id)];
        if access.is_empty() && parcel.says.usage.as_deref() == Some("built") && !parcel.says.inner {
            let message = format!("parcel {} is built but has no access", parcel.id);
            report.add("V10", &who, parcel.polygon.outer.first().copied(), message);
        }
        if let Some(name) = access.iter().find(|name| !ground.street_names.contains(name.as_str())) {
            report.add("V10", &who, None, format!("parcel {} names unknown street {name}", parcel.id));
        }
    }
}
