//! Convex outlines, as nearly all parcels are: what lies behind lines is cut off without a boolean of polygons, which took
//! longer than the rule that asked for it.

use geom::polygon::{convex_hull, ring_edges, without_collinear};
use geom::predicates::{orient, within as is_near};
use geom::{Point, Polygon, Vec2};

/// How much farther in than asked for the new sides lie, in LSB, as strips do: rounding a corner takes at most 0.71 of it.
const COVER: f64 = 2.0;

/// How far a corner may lie inside its neighbours' chord, in LSB: rounding puts corners there where parcels meet in a T. The
/// rest of [`COVER`] takes it in.
const DENT: i32 = 1;

/// The part of a convex ring (counter-clockwise) that lies at least `distance` LSB behind the line of each edge; the ring's
/// own border stays where that is 0. `Some(None)` when nothing is left; `None` when the ring is not convex but for dents
/// that rounding made, or what is left is so thin that its corners fall together when they are rounded.
pub(crate) fn within(ring: &[Point], distance: impl Fn(usize) -> i32) -> Option<Option<Polygon>> {
    let (hull, edges) = undented(ring)?;
    let mut distances = Vec::with_capacity(hull.len());
    for (i, &edge) in edges.iter().enumerate() {
        let (own, count) = (distance(edge), (edges[(i + 1) % edges.len()] + ring.len() - edge) % ring.len());
        let is_even = (1..count).all(|k| distance((edge + k) % ring.len()) == own);
        if count > 1 && !(is_even && own > 0) {
            return None;
        }
        distances.push(own);
    }
    let hull = Convex::of(&hull)?;
    let moved =
        |(line, &by): (Line, &i32)| (by > 0).then(|| Line { offset: line.offset + f64::from(by) + COVER, ..line });
    let kept: Vec<usize> = (0..distances.len()).filter(|&i| distances[i] <= 0).collect();
    hull.cut(hull.lines().zip(&distances).filter_map(moved), &kept)
}

/// The part of a convex ring that lies on the left of a line, less what rounding takes. As [`within`], but without dents.
pub(crate) fn left_of(ring: &[Point], from: Vec2, along: Vec2) -> Option<Option<Polygon>> {
    let ring = Convex::of(ring)?;
    let normal = along.perp();
    let offset = normal.dot(from * Point::UNITS_PER_METRE - ring.base()) + COVER;
    let all: Vec<usize> = (0..ring.0.len()).collect();
    ring.cut([Line { normal, offset }].into_iter(), &all)
}

/// The corners of a ring's hull in its order, each with its place in the ring, where all others lie on the hull but for
/// dents.
fn undented(ring: &[Point]) -> Option<(Vec<Point>, Vec<usize>)> {
    let mut corners = convex_hull(ring);
    corners.sort_unstable();
    let places: Vec<usize> = (0..ring.len()).filter(|&i| corners.binary_search(&ring[i]).is_ok()).collect();
    let n = ring.len();
    for (k, &from) in places.iter().enumerate() {
        let to = places[(k + 1) % places.len()];
        let between = (1..(to + n - from) % n).map(|step| ring[(from + step) % n]);
        if !between.into_iter().all(|p| is_near(ring[from], ring[to], p, DENT)) {
            return None;
        }
    }
    Some((places.iter().map(|&i| ring[i]).collect(), places))
}

/// What lies on the left of it is kept. In LSB from the ring's first corner.
#[derive(Clone, Copy, Debug)]
struct Line {
    normal: Vec2,
    offset: f64,
}

impl Line {
    fn depth(&self, at: Vec2) -> f64 {
        self.normal.dot(at) - self.offset
    }
}

/// A ring that turns left at every corner.
struct Convex<'a>(&'a [Point]);

impl<'a> Convex<'a> {
    fn of(ring: &'a [Point]) -> Option<Self> {
        let n = ring.len();
        let turns_left = |i: usize| orient(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) > 0;
        // A ring that turns left everywhere may still go round more than once.
        let sweeps = |(a, b): (Point, Point)| (b.y > a.y || (b.y == a.y && b.x > a.x)) as u8;
        let ups: Vec<u8> = ring_edges(ring).map(sweeps).collect();
        let changes = (0..n).filter(|&i| ups[i] != ups[(i + 1) % n]).count();
        (n >= 3 && changes == 2 && (0..n).all(turns_left)).then_some(Self(ring))
    }

    fn base(&self) -> Vec2 {
        Vec2::new(f64::from(self.0[0].x), f64::from(self.0[0].y))
    }

    fn place(&self, p: Point) -> Vec2 {
        Vec2::new(f64::from(p.x), f64::from(p.y)) - self.base()
    }

    fn lines(&self) -> impl Iterator<Item = Line> {
        ring_edges(self.0).map(|(a, b)| {
            let normal = (self.place(b) - self.place(a)).normalize().perp();
            Line { normal, offset: normal.dot(self.place(a)) }
        })
    }

    /// What is left of all lines. Corners are rounded so that they stay on the inner side of the `kept` edges.
    fn cut(&self, lines: impl Iterator<Item = Line>, kept: &[usize]) -> Option<Option<Polygon>> {
        let mut corners: Vec<Vec2> = self.0.iter().map(|&p| self.place(p)).collect();
        for line in lines {
            corners = clipped(&corners, &line);
        }
        if corners.len() < 3 {
            return Some(None);
        }
        let rounded: Option<Vec<Point>> = corners.into_iter().map(|at| self.rounded(at, kept)).collect();
        let mut ring = rounded?;
        ring.dedup();
        let mut ring = without_collinear(&ring);
        let least = ring.iter().enumerate().min_by_key(|(_, p)| **p).map_or(0, |(i, _)| i);
        ring.rotate_left(least);
        Convex::of(&ring)?;
        Some(Some(Polygon { outer: ring, holes: Vec::new() }))
    }

    /// The nearest lattice point on the inner side of some edges.
    fn rounded(&self, at: Vec2, kept: &[usize]) -> Option<Point> {
        let at = at + self.base();
        let middle = at.round();
        let is_inside = |p: Point| kept.iter().all(|&i| orient(self.0[i], self.0[(i + 1) % self.0.len()], p) >= 0);
        let steps = [0.0, 1.0, -1.0];
        let near = steps.into_iter().flat_map(|x| steps.map(|y| middle + Vec2::new(x, y)));
        let points = near.map(|place| (place.distance_squared(at), Point::new(place.x as i32, place.y as i32)));
        let inside = points.filter(|&(_, p)| is_inside(p));
        inside.min_by(|(a, p), (b, q)| a.total_cmp(b).then(p.cmp(q))).map(|(_, p)| p)
    }
}

/// The part of a convex ring left of a line (Sutherland & Hodgman 1974).
fn clipped(ring: &[Vec2], line: &Line) -> Vec<Vec2> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    for (i, &at) in ring.iter().enumerate() {
        let next = ring[(i + 1) % ring.len()];
        let (here, there) = (line.depth(at), line.depth(next));
        if here >= 0.0 {
            kept.push(at);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(at + (next - at) * (here / (here - there)));
        }
    }
    kept
}
