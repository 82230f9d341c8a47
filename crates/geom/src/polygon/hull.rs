//! Convex hull and the smallest rectangle around points.

use crate::predicates::{dot, orient};
use crate::{Point, Vec2};
use std::cmp::Ordering;

/// A rectangle at any angle, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// Middle.
    pub centre: Vec2,
    /// Unit vector along the longer side, pointing east, or north where exactly upright.
    pub axis: Vec2,
    /// Half the extent along the axis, and half the extent across it (counter-clockwise from the axis).
    pub half: Vec2,
}

impl OrientedBox {
    /// The four corners, counter-clockwise, in metres.
    pub fn corners(&self) -> [Vec2; 4] {
        let along = self.axis * self.half.x;
        let across = self.axis.perp() * self.half.y;
        [
            self.centre - along - across,
            self.centre + along - across,
            self.centre + along + across,
            self.centre - along + across,
        ]
    }

    /// Area in m².
    pub fn area(&self) -> f64 {
        4.0 * self.half.x * self.half.y
    }
}

/// The corners of the convex hull, counter-clockwise from the lexicographically least, none collinear; exact. One or
/// two points for a set that has no area.
pub fn convex_hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull = half_hull(sorted.iter().copied());
    let upper = half_hull(sorted.iter().rev().copied());
    // Each half ends where the other starts.
    hull.pop();
    hull.extend_from_slice(&upper[..upper.len() - 1]);
    hull
}

/// The chain that turns left all the way through points given in lexicographic order (Andrew's monotone chain).
fn half_hull(points: impl Iterator<Item = Point>) -> Vec<Point> {
    let mut chain: Vec<Point> = Vec::new();
    for p in points {
        while let [.., a, b] = chain[..]
            && orient(a, b, p) <= 0
        {
            chain.pop();
        }
        chain.push(p);
    }
    chain
}

/// The rectangle of least area around the points; one of its sides lies along a hull edge. Areas are compared exactly;
/// of equal ones, the first hull edge counter-clockwise from the lexicographically least corner wins. A set without
/// area gives a box without width; an empty one a box without size at the origin.
pub fn min_area_box(points: &[Point]) -> OrientedBox {
    min_area_box_of_hull(&convex_hull(points))
}

/// The same for corners that are their own convex hull, counter-clockwise; of equal rectangles that on the first edge
/// wins, so that a caller may say where a tie begins.
pub fn min_area_box_of_hull(hull: &[Point]) -> OrientedBox {
    match hull[..] {
        [] => OrientedBox { centre: Vec2::ZERO, axis: Vec2::X, half: Vec2::ZERO },
        [p] => OrientedBox { centre: p.metres(), axis: Vec2::X, half: Vec2::ZERO },
        [a, b] => Caliper::of(&[a, b], 0, &mut [1, 1, 0]).to_box(hull),
        _ => least_caliper(hull).to_box(hull),
    }
}

/// Rotating callipers over all edges of a hull of three or more corners.
fn least_caliper(hull: &[Point]) -> Caliper {
    let mut touching = [1, 1, 1];
    let mut least = Caliper::of(hull, 0, &mut touching);
    for edge in 1..hull.len() {
        let next = Caliper::of(hull, edge, &mut touching);
        if next.compare_area(&least) == Ordering::Less {
            least = next;
        }
    }
    least
}

/// The rectangle on one hull edge, in multiples of that edge: lengths are in LSB × the edge's length.
struct Caliper {
    edge: usize,
    /// Least and greatest dot product along the edge, from its first corner.
    along: (i64, i64),
    /// Greatest distance to the left of the edge; the least is 0.
    across: i64,
    length_squared: i64,
}

impl Caliper {
    /// `touching` are the corners farthest ahead, left and behind; they only ever move on, so a whole turn takes linear
    /// time.
    fn of(hull: &[Point], edge: usize, touching: &mut [usize; 3]) -> Self {
        let n = hull.len();
        let (a, b) = (hull[edge], hull[(edge + 1) % n]);
        let [ahead, left, behind] = touching;
        let along = |i: usize| dot(a, b, hull[i % n]);
        let across = |i: usize| orient(a, b, hull[i % n]);
        *ahead = (*ahead).max(edge + 1);
        *ahead = climb(*ahead, along);
        *left = climb((*left).max(*ahead), across);
        *behind = climb((*behind).max(*left), |i| -along(i));
        Self {
            edge,
            along: (along(*behind), along(*ahead)),
            across: across(*left),
            length_squared: a.distance_squared(b),
        }
    }

    /// Area times the squared length of the edge.
    fn scaled_area(&self) -> u128 {
        let extent = self.along.1.abs_diff(self.along.0);
        u128::from(extent) * u128::from(self.across.unsigned_abs())
    }

    fn compare_area(&self, other: &Self) -> Ordering {
        let ours = wide_product(self.scaled_area(), other.length_squared.unsigned_abs());
        ours.cmp(&wide_product(other.scaled_area(), self.length_squared.unsigned_abs()))
    }

    fn to_box(&self, hull: &[Point]) -> OrientedBox {
        let (a, b) = (hull[self.edge], hull[(self.edge + 1) % hull.len()]);
        let unit = (b.metres() - a.metres()).normalize_or(Vec2::X);
        // One division turns a product with the edge into metres.
        let scale = (self.length_squared as f64).sqrt() * Point::UNITS_PER_METRE;
        let (low, high, depth) = (self.along.0 as f64 / scale, self.along.1 as f64 / scale, self.across as f64 / scale);
        let half = Vec2::new(high - low, depth) / 2.0;
        let centre = a.metres() + unit * ((low + high) / 2.0) + unit.perp() * half.y;
        let upright = self.along.1.abs_diff(self.along.0) < self.across.unsigned_abs();
        let (axis, half) = if upright { (unit.perp(), Vec2::new(half.y, half.x)) } else { (unit, half) };
        let westward = axis.x < 0.0 || (axis.x == 0.0 && axis.y < 0.0);
        OrientedBox { centre, axis: if westward { -axis } else { axis }, half }
    }
}

/// Moves on from a corner while the measure grows.
fn climb(from: usize, measure: impl Fn(usize) -> i64) -> usize {
    let mut at = from;
    while measure(at + 1) > measure(at) {
        at += 1;
    }
    at
}

/// The 192-bit product, as its upper 128 and lower 64 bits.
fn wide_product(a: u128, b: u64) -> (u128, u64) {
    let low = (a & u128::from(u64::MAX)) * u128::from(b);
    let high = (a >> 64) * u128::from(b) + (low >> 64);
    (high, low as u64)
}
