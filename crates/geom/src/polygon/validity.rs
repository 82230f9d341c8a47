//! Whether rings are simple and polygons valid; exact, by a sweep over edges sorted along the better axis.

use super::{Location, Polygon, ring_doubled_area, ring_edges};
use crate::predicates::{dot, meets, on_segment, orient};
use crate::{Bounds, Point};

/// An edge of a ring, with what tells whether two are neighbours.
#[derive(Clone, Copy)]
struct Edge {
    a: Point,
    b: Point,
    ring: u32,
    index: u32,
    bounds: Bounds,
}

impl Edge {
    /// Whether the two follow each other on their ring, which has `count` edges.
    fn is_neighbour(&self, other: &Self, count: u32) -> bool {
        let apart = self.index.abs_diff(other.index);
        self.ring == other.ring && (apart == 1 || apart == count - 1)
    }
}

/// Whether a ring has three or more corners and an area, repeats no point, and no two of its edges have a point in
/// common except neighbours their corner. Exact.
pub fn ring_is_simple(ring: &[Point]) -> bool {
    ring.len() >= 3 && ring_doubled_area(ring) != 0 && all_contacts(&[ring], &mut |_, _| false)
}

impl Polygon {
    /// Whether every ring is simple (see [`ring_is_simple`]) and no two rings have a point in common. Exact.
    pub fn is_simple(&self) -> bool {
        let rings: Vec<&[Point]> = self.rings().collect();
        rings.iter().all(|ring| ring.len() >= 3 && ring_doubled_area(ring) != 0)
            && all_contacts(&rings, &mut |_, _| false)
    }

    /// Whether the polygon is valid as the OGC's Simple Features define it, in this crate's orientation: rings are
    /// simple, outer counter-clockwise, holes clockwise, inside the outer ring and outside each other; rings touch in
    /// single points at most, and not so that the interior falls apart. Exact.
    pub fn is_valid(&self) -> bool {
        let rings: Vec<&[Point]> = self.rings().collect();
        let turned_well = |(i, ring): (usize, &&[Point])| {
            let doubled = ring_doubled_area(ring);
            if i == 0 { doubled > 0 } else { doubled < 0 }
        };
        if !rings.iter().enumerate().all(turned_well) {
            return false;
        }
        let mut touches = Vec::new();
        let only_touches = all_contacts(&rings, &mut |e, f| match single_touch(e, f) {
            Some(at) if e.ring != f.ring => {
                touches.push((at, e.ring));
                touches.push((at, f.ring));
                true
            }
            _ => false,
        });
        // In this order: rings that touch each other once at most cannot cross there, since closed curves cross an even
        // number of times; so one corner off the other's rim tells where a whole ring lies.
        only_touches && interior_is_connected(rings.len(), touches) && self.holes_lie_inside()
    }

    /// Whether each hole lies in the outer ring and in no other hole, given that rings touch pairwise once at most.
    fn holes_lie_inside(&self) -> bool {
        let apart =
            |i: usize, hole: &[Point]| self.holes.iter().enumerate().all(|(j, other)| i == j || !lies_in(hole, other));
        self.holes.iter().enumerate().all(|(i, hole)| lies_in(hole, &self.outer) && apart(i, hole))
    }
}

/// Whether a ring lies in another that it touches in one point at most.
fn lies_in(ring: &[Point], other: &[Point]) -> bool {
    let place = |&p: &Point| super::locate_by_parity(ring_edges(other), p);
    ring.iter().map(place).find(|&place| place != Location::OnRim) == Some(Location::Inside)
}

/// Whether rings with these touching points, given as (point, ring) with repeats, leave the interior in one piece: the
/// graph of rings and touching points must have no cycle.
fn interior_is_connected(rings: usize, mut touches: Vec<(Point, u32)>) -> bool {
    touches.sort_unstable();
    touches.dedup();
    let mut roots: Vec<usize> = (0..rings).collect();
    let mut last_point = None;
    for (at, ring) in touches {
        if last_point != Some(at) {
            last_point = Some(at);
            roots.push(roots.len());
        }
        let point = roots.len() - 1;
        let (of_point, of_ring) = (root(&mut roots, point), root(&mut roots, ring as usize));
        if of_point == of_ring {
            return false;
        }
        roots[of_point] = of_ring;
    }
    true
}

/// The representative of a set in a union–find forest, with path halving.
fn root(roots: &mut [usize], mut at: usize) -> usize {
    while roots[at] != at {
        roots[at] = roots[roots[at]];
        at = roots[at];
    }
    at
}

/// The one point that two edges have in common, `None` when they cross inside both or overlap along a stretch.
fn single_touch(e: &Edge, f: &Edge) -> Option<Point> {
    let mut common = [
        on_segment(f.a, f.b, e.a).then_some(e.a),
        on_segment(f.a, f.b, e.b).then_some(e.b),
        on_segment(e.a, e.b, f.a).then_some(f.a),
        on_segment(e.a, e.b, f.b).then_some(f.b),
    ]
    .into_iter()
    .flatten();
    let first = common.next()?;
    common.all(|p| p == first).then_some(first)
}

/// Finds all pairs of edges with a point in common, other than neighbours that share just their corner, and asks
/// `allowed` about each pair of edges that are no neighbours. Stops at the first contact that is not allowed.
fn all_contacts(rings: &[&[Point]], allowed: &mut impl FnMut(&Edge, &Edge) -> bool) -> bool {
    let mut order: Vec<Edge> = (0..).zip(rings).flat_map(|(ring, points)| ring_edges_of(ring, points)).collect();
    let by_x = sweeps_along_x(&order);
    let start = |e: &Edge| if by_x { e.bounds.min.x } else { e.bounds.min.y };
    let end = |e: &Edge| if by_x { e.bounds.max.x } else { e.bounds.max.y };
    order.sort_by_key(start);
    order.iter().enumerate().all(|(i, e)| {
        order[i + 1..].iter().take_while(|f| start(f) <= end(e)).filter(|f| e.bounds.overlaps(&f.bounds)).all(|f| {
            if e.is_neighbour(f, rings[e.ring as usize].len() as u32) {
                is_plain_corner(e, f)
            } else {
                !meets(e.a, e.b, f.a, f.b) || allowed(e, f)
            }
        })
    })
}

/// Whether two neighbours, neither without length, share no more than their corner. (In a triangle any two edges are
/// neighbours, whichever way round.)
fn is_plain_corner(e: &Edge, f: &Edge) -> bool {
    let (before, after) = if e.b == f.a { (e, f) } else { (f, e) };
    let has_length = before.a != before.b && after.a != after.b;
    let goes_back = orient(before.a, before.b, after.b) == 0 && dot(before.b, before.a, after.b) > 0;
    before.b == after.a && has_length && !goes_back
}

fn ring_edges_of(ring: u32, points: &[Point]) -> impl Iterator<Item = Edge> {
    ring_edges(points).zip(0..).map(move |((a, b), index)| Edge { a, b, ring, index, bounds: Bounds::between(a, b) })
}

/// Whether edges overlap each other less when projected on x than on y, measured by their mean share of the span.
fn sweeps_along_x(edges: &[Edge]) -> bool {
    let Some(whole) = Bounds::of(edges.iter().flat_map(|e| [e.a, e.b])) else { return true };
    let extents = edges.iter().fold((0i64, 0i64), |sum, e| {
        let (dx, dy) = e.bounds.min.to(e.bounds.max);
        (sum.0 + dx, sum.1 + dy)
    });
    let (width, height) = whole.min.to(whole.max);
    i128::from(extents.0) * i128::from(height) <= i128::from(extents.1) * i128::from(width)
}
