//! From boundary edges to OGC-valid polygons.
//!
//! i_overlay finds the boundary, exactly on the lattice; its own way to bind holes to shapes goes wrong where many rings
//! touch in points (a hole may end up in an island inside another hole), so the rings are traced here.

use crate::polygon::{Location, ring_doubled_area, ring_edges, without_collinear};
use crate::predicates::by_angle;
use crate::{Bounds, Point, Polygon};
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// The polygons that the directed edges of these rings bound, with their inside to the left. Edges meet at corners only,
/// and no edge is there twice. Canonical, as [`super`] says.
pub fn assemble<'a>(rings: impl Iterator<Item = &'a [Point]>) -> Vec<Polygon> {
    let mut edges: Vec<(Point, Point)> = rings.flat_map(ring_edges).collect();
    edges.sort_unstable();
    let mut polygons = Vec::new();
    let mut loose_holes = Vec::new();
    for walk in walks(&edges) {
        let (outers, mut holes): (Vec<_>, Vec<_>) =
            simple_cycles(walk).into_iter().partition(|ring| ring_doubled_area(ring) > 0);
        // A walk has one outer ring at most, and then its holes touch that ring or each other.
        let touching = if outers.len() == 1 { std::mem::take(&mut holes) } else { Vec::new() };
        loose_holes.append(&mut holes);
        polygons.extend(outers.into_iter().map(|outer| Polygon { outer, holes: Vec::new() }));
        if let Some(polygon) = polygons.last_mut() {
            polygon.holes.extend(touching);
        }
    }
    give_holes(&mut polygons, loose_holes);
    polygons.iter_mut().for_each(make_canonical);
    polygons.sort_unstable_by(|a, b| (&a.outer, &a.holes).cmp(&(&b.outer, &b.holes)));
    polygons
}

/// Closed walks along the sorted edges which keep to one wedge of the inside at every corner, so that each walk bounds
/// one connected piece of the interior. A walk may pass a corner more than once.
fn walks(edges: &[(Point, Point)]) -> Vec<Vec<Point>> {
    let mut used = vec![false; edges.len()];
    let mut walks = Vec::new();
    for start in 0..edges.len() {
        let mut walk = Vec::new();
        let mut at = start;
        while !used[at] {
            used[at] = true;
            walk.push(edges[at].0);
            at = next_edge(edges, edges[at]);
        }
        if !walk.is_empty() {
            walks.push(walk);
        }
    }
    walks
}

/// The edge that bounds the same wedge of the inside where an edge ends: the first one clockwise from looking back.
fn next_edge(edges: &[(Point, Point)], (from, at): (Point, Point)) -> usize {
    let first = edges.partition_point(|edge| edge.0 < at);
    let leaving = edges[first..].iter().take_while(|edge| edge.0 == at).count();
    let back = at.to(from);
    let nearer_clockwise = |&i: &usize, &j: &usize| {
        let (a, b) = (at.to(edges[i].1), at.to(edges[j].1));
        let wraps = |direction| by_angle(direction, back) == Ordering::Greater;
        // Going clockwise angles fall from that of `back`; those above it come after the turn through east.
        wraps(b).cmp(&wraps(a)).then(by_angle(a, b))
    };
    (first..first + leaving).max_by(nearer_clockwise).expect("a boundary goes on at every corner")
}

/// The walk cut into rings that pass no corner twice.
fn simple_cycles(walk: Vec<Point>) -> Vec<Vec<Point>> {
    let mut cycles = Vec::new();
    let mut path: Vec<Point> = Vec::with_capacity(walk.len());
    let mut place_on_path = BTreeMap::new();
    for corner in walk {
        if let Some(&place) = place_on_path.get(&corner) {
            let cycle = path.split_off(place);
            cycle.iter().for_each(|p| {
                place_on_path.remove(p);
            });
            cycles.push(cycle);
        }
        place_on_path.insert(corner, path.len());
        path.push(corner);
    }
    cycles.push(path);
    cycles
}

/// Puts each hole that touches no outer ring along its walk into the least polygon around it.
fn give_holes(polygons: &mut [Polygon], holes: Vec<Vec<Point>>) {
    if holes.is_empty() {
        return;
    }
    let mut outers: Vec<(i128, usize, Polygon)> = (0..)
        .zip(polygons.iter())
        .map(|(i, polygon)| {
            let outer = Polygon { outer: polygon.outer.clone(), holes: Vec::new() };
            (outer.doubled_area(), i, outer)
        })
        .collect();
    outers.sort_unstable_by_key(|(area, i, _)| (*area, *i));
    let bounds: Vec<Option<Bounds>> = outers.iter().map(|(_, _, outer)| outer.bounds()).collect();
    for hole in holes {
        let around = outers.iter().zip(&bounds).find(|((_, _, outer), bounds)| lies_in(&hole, outer, **bounds));
        if let Some(((_, i, _), _)) = around {
            polygons[*i].holes.push(hole);
        }
    }
}

/// Whether a hole lies in a polygon without holes. If all its corners are on the rim it does not, since it would cut the
/// inside into pieces, which walks keep apart.
fn lies_in(hole: &[Point], outer: &Polygon, bounds: Option<Bounds>) -> bool {
    bounds.is_some_and(|bounds| bounds.contains(hole[0]))
        && hole.iter().map(|&p| outer.locate(p)).find(|&place| place != Location::OnRim) == Some(Location::Inside)
}

/// Drops collinear corners, starts rings at their least corner and sorts the holes.
fn make_canonical(polygon: &mut Polygon) {
    for ring in std::iter::once(&mut polygon.outer).chain(&mut polygon.holes) {
        *ring = without_collinear(ring);
        let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
        ring.rotate_left(least);
    }
    polygon.holes.sort_unstable();
}
