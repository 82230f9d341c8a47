//! Cutting a region through its holes, so that no parcel has one: from the easternmost corner of a hole east to the
//! rim, and from its westernmost corner west, through whatever holes lie there.

use super::chord::{in_triangle, is_between, on_edge};
use super::map::{Face, LandMap};
use geom::polygon::{Location, ring_is_simple};
use geom::predicates::{dot, meets, orient};
use geom::tolerance::PARCEL_EDGE;
use geom::{Point, Polygon, Vec2};
use smallvec::SmallVec;

const EDGE_SQUARED: i64 = PARCEL_EDGE as i64 * PARCEL_EDGE as i64;

/// Cuts until no face has a hole. Where that fails (holes within rounding of each other), the map stays as it was.
pub(super) fn cut_holes(map: &mut LandMap) {
    if map.faces[0].rims.len() < 2 {
        return;
    }
    let mut cut = map.clone();
    let mut face = 0;
    while face < cut.faces.len() as u32 {
        if cut.faces[face as usize].rims.len() < 2 {
            face += 1;
        } else if cut_through(&mut cut, face).is_none() {
            return;
        }
    }
    if cut.live_faces().all(|face| ring_is_simple(&cut.polygon(face).outer)) {
        *map = cut;
    }
}

/// Which way a ray goes.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    East,
    West,
}

/// Splits a face by a line of cuts through one of its holes or more.
fn cut_through(map: &mut LandMap, face: u32) -> Option<()> {
    let holes = map.faces[face as usize].rims[1..].to_vec();
    let outermost = holes.into_iter().max_by_key(|&hole| map.rim(hole).map(|half| map.start(half)).max())?;
    let mut hole: Vec<u32> = map.rim(outermost).collect();
    let east = hole.iter().copied().max_by_key(|&half| map.start(half))?;
    let rim = target(map, face, east, Way::East)?;
    map.connect(east, rim);
    forget_hole(map, face, &hole)?;
    loop {
        let west = hole.iter().copied().min_by_key(|&half| map.start(half))?;
        let rim = target(map, face, west, Way::West)?;
        let next: Vec<u32> = map.rim(rim).collect();
        if !next.contains(&west) {
            map.connect(west, rim);
            forget_hole(map, face, &next)?;
            hole = next;
            continue;
        }
        let (left, right) = map.connect(west, rim);
        part(map, face, left, right);
        return Some(());
    }
}

/// Takes the hole that has become part of another rim off a face's list.
fn forget_hole(map: &mut LandMap, face: u32, hole: &[u32]) -> Option<()> {
    let rims = &mut map.faces[face as usize].rims;
    let listed = rims.iter().skip(1).position(|rim| hole.contains(rim))?;
    rims.remove(listed + 1);
    Some(())
}

/// Makes two faces of one whose outer rim has been cut in two, each with the holes that lie in it.
fn part(map: &mut LandMap, face: u32, left: u32, right: u32) {
    let (path, other) = (map.faces[face as usize].path, map.faces.len() as u32);
    let outer: Vec<Point> = map.rim(right).map(|half| map.start(half)).collect();
    let right_side = Polygon { outer, holes: Vec::new() };
    let in_right = |hole: &u32| right_side.locate(map.start(*hole)) == Location::Inside;
    let holes: Vec<u32> = map.faces[face as usize].rims[1..].to_vec();
    let (to_right, to_left): (Vec<u32>, Vec<u32>) = holes.into_iter().partition(in_right);
    let rims = |first: u32, holes: &[u32]| -> SmallVec<[u32; 1]> {
        std::iter::once(first).chain(holes.iter().copied()).collect()
    };
    map.faces[face as usize] = Face { rims: rims(left, &to_left), path: path.child(0) };
    map.faces.push(Face { rims: rims(right, &to_right), path: path.child(1) });
    map.assign(right, other);
    to_right.into_iter().for_each(|hole| map.assign(hole, other));
}

/// The half to whose start a cut from the start of `from` may go: straight ahead, or else at the nearest corner that
/// can be seen on that side.
fn target(map: &mut LandMap, face: u32, from: u32, way: Way) -> Option<u32> {
    if let Some(ahead) = straight_ahead(map, face, from, way)
        && sees(map, face, from, ahead)
    {
        return Some(ahead);
    }
    let origin = map.start(from);
    let beyond = |p: Point| if way == Way::East { p > origin } else { p < origin };
    let mut corners: Vec<u32> = map.halves_of(face).filter(|&half| beyond(map.start(half))).collect();
    corners.sort_by_key(|&half| (map.start(half).distance_squared(origin), half));
    corners.into_iter().find(|&half| sees(map, face, from, half))
}

/// The half that starts where the ray from the start of `from` first meets a rim; a corner is put there if none is
/// near.
fn straight_ahead(map: &mut LandMap, face: u32, from: u32, way: Way) -> Option<u32> {
    let origin = map.start(from);
    let sign = if way == Way::East { 1.0 } else { -1.0 };
    let distance = |half: &u32| {
        let (a, b) = (map.start(*half), map.end(*half));
        if (a.y > origin.y) == (b.y > origin.y) {
            return None;
        }
        let share = (f64::from(origin.y) - f64::from(a.y)) / (f64::from(b.y) - f64::from(a.y));
        let along = (f64::from(a.x) + (f64::from(b.x) - f64::from(a.x)) * share - f64::from(origin.x)) * sign;
        (along > 0.0).then_some((along, *half))
    };
    let hit = map.halves_of(face).filter_map(|half| distance(&half));
    let (along, half) = hit.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    let ahead = Vec2::new(sign * along / Point::UNITS_PER_METRE, 0.0);
    let (a, b, at) = (map.start(half), map.end(half), on_edge(map, half, origin, ahead));
    if at.distance_squared(a) < EDGE_SQUARED {
        return Some(half);
    }
    if at.distance_squared(b) < EDGE_SQUARED {
        return Some(map.half(half).next);
    }
    let passed_over = |other: u32| {
        let p = map.start(other);
        p != a && p != b && orient(a, at, b) != 0 && in_triangle(a, at, b, p)
    };
    let neighbour = map.half(half ^ 1).face;
    let beyond = (!map.on_rim(half)).then(|| map.halves_of(neighbour)).into_iter().flatten();
    let harmless = !map.halves_of(face).chain(beyond).any(passed_over);
    harmless.then(|| map.insert_corner(half, at))
}

/// Whether the line between the starts of two halves of a face runs inside it and meets nothing between.
fn sees(map: &LandMap, face: u32, from: u32, to: u32) -> bool {
    let (s, t) = (map.start(from), map.start(to));
    let leads_inside =
        |half: u32, p: Point| is_between(map.start(map.half(half).prev), map.start(half), map.end(half), p);
    s.distance_squared(t) >= EDGE_SQUARED
        && leads_inside(from, t)
        && leads_inside(to, s)
        && !map.halves_of(face).any(|half| obstructs(map.start(half), map.end(half), s, t))
}

/// Whether an edge stands in the line between `s` and `t`; one that starts there does only if it runs along it.
fn obstructs(a: Point, b: Point, s: Point, t: Point) -> bool {
    let along = |at: Point, other: Point, ahead: Point| orient(at, ahead, other) == 0 && dot(at, ahead, other) > 0;
    match (a == s || b == s, a == t || b == t) {
        (true, true) => true,
        (true, false) => along(s, if a == s { b } else { a }, t),
        (false, true) => along(t, if a == t { b } else { a }, s),
        (false, false) => meets(a, b, s, t),
    }
}
