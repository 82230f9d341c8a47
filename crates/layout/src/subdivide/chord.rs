//! Chords: straight cuts through a face from border to border. A line is laid through the face in floats; its ends are
//! put on the lattice; and exact predicates then certify that both parts, and the neighbours that share the new
//! corners, are simple. A chord without its certificate is not cut.

use super::map::LandMap;
use super::outline::Outline;
use geom::predicates::{meets, orient};
use geom::tolerance::PARCEL_EDGE;
use geom::{Point, Vec2};

/// Where a chord ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct End {
    /// The edge of the outline it lies on; the edge that starts at a corner for a corner.
    pub edge: usize,
    /// Position.
    pub at: Point,
    /// Whether it is a corner of the outline.
    pub corner: bool,
}

/// A certified cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    pub from: End,
    pub to: End,
}

/// A line to cut along, in the outline's metres.
#[derive(Clone, Copy, Debug)]
pub(super) enum Line {
    /// Through a place; where it crosses the face several times, the stretch with the place on it, else the longest.
    Through(Vec2, Vec2),
    /// From a corner on in a direction, to where it first leaves the face.
    From(usize, Vec2),
}

/// The chord that a line cuts out of an outline, from the end that comes first on it; `None` when it misses the face.
/// Not certified yet: that takes longer than to see that another is better.
pub(super) fn placed(map: &LandMap, outline: &Outline, line: Line) -> Option<Chord> {
    let (a, b) = match line {
        Line::Through(place, direction) => {
            let (a, b) = stretch(outline, place, direction)?;
            (put(map, outline, a), put(map, outline, b))
        }
        Line::From(corner, direction) => {
            let end = put(map, outline, first_exit(outline, corner, direction)?);
            (End { edge: corner, at: outline.points[corner], corner: true }, end)
        }
    };
    Some(if a.edge <= b.edge { Chord { from: a, to: b } } else { Chord { from: b, to: a } })
}

/// The crossings of a line with the outline: (how far along the line in metres, edge, place).
type Crossing = (f64, usize, Vec2);

fn crossings(outline: &Outline, place: Vec2, direction: Vec2) -> smallvec::SmallVec<[Crossing; 8]> {
    let side = |i: usize| direction.perp_dot(outline.places[i] - place);
    let mut found = smallvec::SmallVec::new();
    let mut here = side(0);
    for i in 0..outline.len() {
        let there = side(outline.next(i));
        // Half open, so that the number of crossings is even even through corners.
        if (here >= 0.0) != (there >= 0.0) {
            let (p, q) = (outline.places[i], outline.places[outline.next(i)]);
            let at = p + (q - p) * (here / (here - there));
            found.push(((at - place).dot(direction), i, at));
        }
        here = there;
    }
    found.sort_by(|a: &Crossing, b: &Crossing| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found
}

/// The inner stretch of a line that has the place on it, or else the longest.
fn stretch(outline: &Outline, place: Vec2, direction: Vec2) -> Option<((usize, Vec2), (usize, Vec2))> {
    let found = crossings(outline, place, direction);
    let mut best: Option<(f64, &[Crossing])> = None;
    for pair in found.chunks_exact(2) {
        let holds_place = pair[0].0 <= 0.0 && pair[1].0 >= 0.0;
        let length = if holds_place { f64::INFINITY } else { pair[1].0 - pair[0].0 };
        if best.is_none_or(|(longest, _)| length > longest) {
            best = Some((length, pair));
        }
    }
    best.map(|(_, pair)| ((pair[0].1, pair[0].2), (pair[1].1, pair[1].2)))
}

/// Where a ray from a corner first meets an edge that does not start or end there.
fn first_exit(outline: &Outline, corner: usize, direction: Vec2) -> Option<(usize, Vec2)> {
    let beside = |edge: usize| edge == corner || outline.next(edge) == corner;
    let found = crossings(outline, outline.places[corner], direction);
    found.into_iter().find(|&(along, edge, _)| along > 0.0 && !beside(edge)).map(|(_, edge, at)| (edge, at))
}

/// The lattice point for a chord's end on an edge: a corner that lies within [`PARCEL_EDGE`], else a new point.
fn put(map: &LandMap, outline: &Outline, (edge, place): (usize, Vec2)) -> End {
    let next = outline.next(edge);
    let (a, b) = (outline.points[edge], outline.points[next]);
    let at = on_edge(map, outline.halves[edge], outline.points[0], place);
    let limit = i64::from(PARCEL_EDGE) * i64::from(PARCEL_EDGE);
    let (to_a, to_b) = (at.distance_squared(a), at.distance_squared(b));
    if to_a.min(to_b) >= limit {
        End { edge, at, corner: false }
    } else if to_a <= to_b {
        End { edge, at: a, corner: true }
    } else {
        End { edge: next, at: b, corner: true }
    }
}

/// The lattice point for a place on the edge of a half, `offset` metres from `base`: the nearest, or the nearest that
/// is not outside where the edge is on the region's rim.
pub(super) fn on_edge(map: &LandMap, half: u32, base: Point, offset: Vec2) -> Point {
    let exact = offset * Point::UNITS_PER_METRE;
    if map.on_rim(half) {
        nearest_inside(map.start(half), map.end(half), base, exact)
    } else {
        lattice(base, exact.round())
    }
}

/// The corner of the lattice cell around `exact` (LSB from `base`) that is nearest to it among those not right of `a
/// b`.
fn nearest_inside(a: Point, b: Point, base: Point, exact: Vec2) -> Point {
    let (low, high) = (exact.floor(), exact.ceil());
    let cell = [low, high, Vec2::new(low.x, high.y), Vec2::new(high.x, low.y)];
    let mut best = ((f64::INFINITY, 0), a);
    for corner in cell {
        let at = lattice(base, corner);
        // Of two equally near the one nearer to `a`, whichever way the edge runs.
        let off = (corner.distance_squared(exact), a.distance_squared(at));
        if off < best.0 && orient(a, b, at) >= 0 {
            best = (off, at);
        }
    }
    best.1
}

fn lattice(base: Point, offset: Vec2) -> Point {
    let limit = f64::from(Point::LIMIT);
    let place = |c: i32, d: f64| (f64::from(c) + d).clamp(-limit, limit) as i32;
    Point::new(place(base.x, offset.x), place(base.y, offset.y))
}

/// Whether cutting here leaves every piece simple, with no short edge; exact.
pub(super) fn is_certified(map: &LandMap, outline: &Outline, chord: &Chord) -> bool {
    let (s, t) = (chord.from, chord.to);
    s.at.distance_squared(t.at) >= i64::from(PARCEL_EDGE) * i64::from(PARCEL_EDGE)
        && leads_inside(outline, &s, t.at)
        && leads_inside(outline, &t, s.at)
        && is_clear(outline, &s, &t)
        && is_harmless(map, outline, &s, &t)
        && is_harmless(map, outline, &t, &s)
}

/// Whether the direction from an end to the other lies strictly inside the angle of the land there.
fn leads_inside(outline: &Outline, end: &End, other: Point) -> bool {
    let before = if end.corner { outline.points[outline.prev(end.edge)] } else { outline.points[end.edge] };
    let after = outline.points[outline.next(end.edge)];
    is_between(before, end.at, after, other)
}

/// Whether `p` as seen from `at` lies strictly inside the angle that is on the left of the path `before`–`at`–`after`.
pub(super) fn is_between(before: Point, at: Point, after: Point, p: Point) -> bool {
    if orient(before, at, after) >= 0 {
        orient(before, at, p) > 0 && orient(at, after, p) > 0
    } else {
        orient(before, at, p) > 0 || orient(at, after, p) > 0
    }
}

/// Whether the line between the ends meets no edge but those it ends on.
fn is_clear(outline: &Outline, s: &End, t: &End) -> bool {
    let ends_on = |end: &End, edge: usize| edge == end.edge || (end.corner && outline.next(edge) == end.edge);
    let mut here = orient(s.at, t.at, outline.points[0]).signum();
    for i in 0..outline.len() {
        let next = outline.next(i);
        let there = orient(s.at, t.at, outline.points[next]).signum();
        let may_meet = here * there <= 0 && !ends_on(s, i) && !ends_on(t, i);
        if may_meet && meets(s.at, t.at, outline.points[i], outline.points[next]) {
            return false;
        }
        here = there;
    }
    true
}

/// Whether a new corner, by lying beside its edge, passes over no corner of either side, nor over the other new one.
fn is_harmless(map: &LandMap, outline: &Outline, end: &End, other: &End) -> bool {
    let half = outline.halves[end.edge];
    let (a, b) = (outline.points[end.edge], outline.points[outline.next(end.edge)]);
    if end.corner || orient(a, end.at, b) == 0 {
        return true;
    }
    let passes_over = |p: Point| p != a && p != b && in_triangle(a, end.at, b, p);
    if passes_over(other.at) || outline.points.iter().any(|&p| passes_over(p)) {
        return false;
    }
    map.on_rim(half) || !map.rim(half ^ 1).any(|half| passes_over(map.start(half)))
}

/// Whether `p` lies in the closed triangle.
pub(super) fn in_triangle(a: Point, b: Point, c: Point, p: Point) -> bool {
    let sides = [orient(a, b, p), orient(b, c, p), orient(c, a, p)];
    sides.iter().all(|&side| side >= 0) || sides.iter().all(|&side| side <= 0)
}
