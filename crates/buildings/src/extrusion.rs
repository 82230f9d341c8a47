//! The plainest building: a parcel's outline, set back, raised to a height (PM01 §3.5 starts from the same box).

use crate::sides::{Side, sides};
use crate::{Building, Envelope, Setbacks, StartShape, convex, cover};
use geom::polygon::{ring_edges, without_collinear};
use geom::strip::{Reach, strip, wedge};
use geom::{Id, Point, Polygon, boolean, point::units};

/// Least height of a building in metres.
pub const LEAST_HEIGHT: f64 = 2.5;

/// Least area of a footprint in m².
pub const LEAST_FOOTPRINT: f64 = 20.0;

/// Least width of a footprint in metres, measured as that of the strip with its area and perimeter.
const LEAST_WIDTH: f64 = 2.0;

/// The building that fills its envelope on a parcel, at least [`LEAST_HEIGHT`] high. An even setback that leaves no useful
/// footprint is halved, then dropped; setbacks by side are kept or nothing is built. A parcel that is useless even so,
/// or a height that is not finite, gives no building. Of a footprint in several parts the largest is built. The footprint
/// lies in the outline exactly, and off the sides by what they ask for (V22).
pub fn extrude(shape: &StartShape, envelope: &Envelope) -> Option<Building> {
    raise(shape, envelope, footprint(shape, envelope)?)
}

/// The footprint of [`extrude`]: whatever the height and the ground, the same.
pub fn footprint(shape: &StartShape, envelope: &Envelope) -> Option<Polygon> {
    let footprint = set_back(shape, &envelope.setbacks)?;
    let limit = sane(envelope.coverage).min(1.0) * shape.outline.area();
    if footprint.area() > limit { cover::shortened(shape, footprint, limit) } else { Some(footprint) }
}

/// The building on a footprint that was found before.
pub fn raise(shape: &StartShape, envelope: &Envelope, footprint: Polygon) -> Option<Building> {
    envelope.height.is_finite().then(|| Building {
        id: shape.parcel.with(&[Id::root("building", &[]).0]),
        parcel: shape.parcel,
        footprint,
        height: envelope.height.max(LEAST_HEIGHT),
        ground: shape.ground,
        origin: 0,
    })
}

fn sane(length: f64) -> f64 {
    if length.is_finite() { length.max(0.0) } else { 0.0 }
}

fn set_back(shape: &StartShape, setbacks: &Setbacks) -> Option<Polygon> {
    match *setbacks {
        Setbacks::Even(setback) => Some(even_kept(shape, setback)?.1),
        Setbacks::Sides { front, side, rear } => {
            let distance = |kind: Side| match kind {
                Side::Front => units(sane(front)),
                Side::Side => units(sane(side)),
                Side::Rear => units(sane(rear)),
            };
            let sides = sides(&shape.outline.outer, &shape.fronts);
            largest(uneven(&shape.outline, &sides.into_iter().map(distance).collect::<Vec<_>>()))
        }
    }
}

/// The distance that is kept on all sides where `setback` is asked for: half of it, or none, where it leaves no room.
pub fn kept_setback(shape: &StartShape, setback: f64) -> Option<f64> {
    even_kept(shape, setback).map(|(kept, _)| kept)
}

/// The same with what that leaves.
fn even_kept(shape: &StartShape, setback: f64) -> Option<(f64, Polygon)> {
    let setback = sane(setback);
    [setback, setback / 2.0, 0.0].into_iter().find_map(|setback| Some((setback, even(&shape.outline, setback)?)))
}

/// The largest useful part of an outline that is at least `setback` metres from its border.
fn even(outline: &Polygon, setback: f64) -> Option<Polygon> {
    largest(match units(setback) {
        0 => vec![simplified(outline)],
        setback => inset(outline, setback),
    })
}

/// The largest useful part.
pub(crate) fn largest(parts: Vec<Polygon>) -> Option<Polygon> {
    parts.into_iter().filter(is_useful).max_by_key(Polygon::doubled_area)
}

/// Large and wide enough to be built, and in one piece with itself.
fn is_useful(footprint: &Polygon) -> bool {
    let (area, perimeter) = (footprint.area(), footprint.perimeter());
    area >= LEAST_FOOTPRINT && 2.0 * area >= LEAST_WIDTH * perimeter && footprint.is_simple()
}

/// The outline without the corners that only its neighbours need.
fn simplified(outline: &Polygon) -> Polygon {
    let holes = outline.holes.iter().map(|hole| without_collinear(hole)).filter(|hole| !hole.is_empty());
    Polygon { outer: without_collinear(&outline.outer), holes: holes.collect() }
}

/// What lies farther than `setback` LSB from the border: the outline minus a strip along each edge, mitred at the
/// corners that turn away from it.
fn inset(outline: &Polygon, setback: i32) -> Vec<Polygon> {
    let outline = simplified(outline);
    if let Some(within) = outline.holes.is_empty().then(|| convex::within(&outline.outer, |_| setback)).flatten() {
        return within.into_iter().collect();
    }
    let strips = outline.rings().flat_map(|ring| strips(ring, |_| setback)).collect();
    without(&outline, strips)
}

/// What lies farther from each edge of the outer ring than its distance in LSB; a hole keeps the greatest of them.
fn uneven(outline: &Polygon, distances: &[i32]) -> Vec<Polygon> {
    let (ring, distances) = straightened(&outline.outer, distances);
    let most = distances.iter().copied().max().unwrap_or(0);
    let holes: Vec<Vec<Point>> = simplified(outline).holes;
    if let Some(within) = holes.is_empty().then(|| convex::within(&ring, |edge| distances[edge])).flatten() {
        return within.into_iter().collect();
    }
    let mut removed = strips(&ring, |edge| distances[edge]);
    holes.iter().for_each(|hole| removed.extend(strips(hole, |_| most)));
    without(&Polygon { outer: ring, holes }, removed)
}

/// A ring without the corners on straight sides of one distance, which only neighbours need, and its distances.
fn straightened(ring: &[Point], distances: &[i32]) -> (Vec<Point>, Vec<i32>) {
    let n = ring.len();
    let bends = |&i: &usize| {
        let (before, after) = ((i + n - 1) % n, (i + 1) % n);
        distances[before] != distances[i] || geom::predicates::orient(ring[before], ring[i], ring[after]) != 0
    };
    (0..n).filter(bends).map(|i| (ring[i], distances[i])).unzip()
}

fn without(outline: &Polygon, removed: Vec<Polygon>) -> Vec<Polygon> {
    if removed.is_empty() {
        return vec![simplified(outline)];
    }
    boolean::difference(std::slice::from_ref(outline), &removed)
}

/// A strip along each edge of a ring, inwards, as wide as `distance` of the edge says, none where that is 0.
fn strips(ring: &[Point], distance: impl Fn(usize) -> i32) -> Vec<Polygon> {
    let edges: Vec<(Point, Point)> = ring_edges(ring).collect();
    let mut strips = Vec::with_capacity(2 * edges.len());
    for (i, &(from, to)) in edges.iter().enumerate() {
        let next = (i + 1) % edges.len();
        let (here, there) = (distance(i), distance(next));
        let turns_away = geom::predicates::orient(from, to, edges[next].1) < 0;
        let corner =
            (turns_away && here > 0 && there > 0).then(|| wedge(from, to, edges[next].1, here, there)).flatten();
        let along = strip(from, to, Reach { left: here, ..Reach::default() }).filter(|_| here > 0);
        // Round a corner that is blunt or turns away the greater distance reaches on, past the strip that ends there.
        let beyond = here != there && (turns_away || geom::predicates::dot(to, from, edges[next].1) < 0);
        strips.extend(along.map(|ring| Polygon::new(ring.into(), Vec::new())));
        strips.extend(corner.map(|ring| Polygon::new(ring, Vec::new())));
        strips.extend(beyond.then(|| square(to, here.max(there))));
    }
    strips
}

/// A square around a point.
fn square(at: Point, half: i32) -> Polygon {
    let corner = |x: i32, y: i32| Point::new(at.x + x * half, at.y + y * half);
    Polygon::new(vec![corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)], Vec::new())
}

#[cfg(test)]
mod tests;
