//! Polygons with holes on the lattice: measures, containment, validity. All that decides is exact; measures in metres
//! come from exact integer sums.

mod hull;
mod pole;
#[cfg(test)]
pub(crate) mod samples;
#[cfg(test)]
mod tests;
mod validity;

pub use hull::{OrientedBox, convex_hull, min_area_box, min_area_box_of_hull};
pub use validity::ring_is_simple;

use crate::predicates::{dot, on_segment, orient};
use crate::{Bounds, Point, Vec2};
use serde::{Deserialize, Serialize};

/// A polygon with holes: the outer ring counter-clockwise, holes clockwise, rings not closed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Polygon {
    /// Outer ring, counter-clockwise.
    pub outer: Vec<Point>,
    /// Holes, clockwise.
    pub holes: Vec<Vec<Point>>,
}

/// Where a point lies as seen from a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Location {
    /// In the interior.
    Inside,
    /// On an edge or a corner of any ring.
    OnRim,
    /// Outside, or in a hole.
    Outside,
}

impl Polygon {
    /// The polygon of these rings, in any orientation: the outer ring is turned counter-clockwise, holes clockwise.
    pub fn new(outer: Vec<Point>, holes: Vec<Vec<Point>>) -> Self {
        let holes = holes.into_iter().map(|hole| turned(hole, false)).collect();
        Self { outer: turned(outer, true), holes }
    }

    /// The rectangle of a box.
    pub fn rectangle(bounds: Bounds) -> Self {
        let (min, max) = (bounds.min, bounds.max);
        Self { outer: vec![min, Point::new(max.x, min.y), max, Point::new(min.x, max.y)], holes: Vec::new() }
    }

    /// The outer ring, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &[Point]> {
        std::iter::once(self.outer.as_slice()).chain(self.holes.iter().map(Vec::as_slice))
    }

    /// The edges of all rings, from corner to next corner.
    pub fn edges(&self) -> impl Iterator<Item = (Point, Point)> {
        self.rings().flat_map(ring_edges)
    }

    /// Twice the area in LSB², holes subtracted; exact.
    pub fn doubled_area(&self) -> i128 {
        let holes: i128 = self.holes.iter().map(|hole| ring_doubled_area(hole).abs()).sum();
        ring_doubled_area(&self.outer).abs() - holes
    }

    /// Area in m², holes subtracted.
    pub fn area(&self) -> f64 {
        self.doubled_area() as f64 / (2.0 * Point::UNITS_PER_METRE * Point::UNITS_PER_METRE)
    }

    /// Length of all rings in metres.
    pub fn perimeter(&self) -> f64 {
        self.edges().map(|(a, b)| a.distance(b)).sum()
    }

    /// The smallest box around the outer ring; `None` when it has no points.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.outer.iter().copied())
    }

    /// Where a point lies, by parity over all rings; exact.
    pub fn locate(&self, p: Point) -> Location {
        locate_by_parity(self.edges(), p)
    }

    /// Whether a point lies inside or on the rim; exact.
    pub fn contains(&self, p: Point) -> bool {
        self.locate(p) != Location::Outside
    }

    /// Centre of gravity in metres, holes subtracted. For a polygon without area, the mean of its outer corners; for
    /// one without corners, the origin.
    pub fn centroid(&self) -> Vec2 {
        let Some(&base) = self.outer.first() else { return Vec2::ZERO };
        let (mut area, mut x, mut y) = (0i128, 0i128, 0i128);
        for ring in self.rings() {
            let moment = ring_moments(ring, base);
            area += moment.0;
            x += moment.1;
            y += moment.2;
        }
        if area == 0 {
            let sum: Vec2 = self.outer.iter().map(|p| p.metres() - base.metres()).sum();
            return base.metres() + sum / self.outer.len() as f64;
        }
        let scale = 3.0 * area as f64 * Point::UNITS_PER_METRE;
        base.metres() + Vec2::new(x as f64, y as f64) / scale
    }

    /// Distance from a place in metres to the nearest point of any ring, in metres; infinite without rings.
    pub fn distance_to_rim(&self, place: Vec2) -> f64 {
        let squared = |(a, b): (Point, Point)| {
            let (from, along) = (a.metres(), b.metres() - a.metres());
            let length_squared = along.length_squared();
            let share =
                if length_squared > 0.0 { ((place - from).dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
            (place - from - along * share).length_squared()
        };
        self.edges().map(squared).fold(f64::INFINITY, f64::min).sqrt()
    }
}

/// Where a point lies among closed rings, by the parity of edges east of it. Exact.
fn locate_by_parity(edges: impl Iterator<Item = (Point, Point)>, p: Point) -> Location {
    let mut inside = false;
    for (a, b) in edges {
        if (a.y > p.y) == (b.y > p.y) {
            // Level with the point or clear of it: can only touch.
            if a.y.max(b.y) == p.y && on_segment(a, b, p) {
                return Location::OnRim;
            }
            continue;
        }
        match orient(a, b, p).signum() {
            0 => return Location::OnRim,
            side => inside ^= (side > 0) == (b.y > a.y),
        }
    }
    if inside { Location::Inside } else { Location::Outside }
}

/// The edges of a ring, the last one closing it; none for fewer than two points.
pub fn ring_edges(ring: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    let closing = if ring.len() > 1 { Some((ring[ring.len() - 1], ring[0])) } else { None };
    ring.windows(2).map(|pair| (pair[0], pair[1])).chain(closing)
}

/// Twice the signed area of a ring in LSB², positive when counter-clockwise; exact.
pub fn ring_doubled_area(ring: &[Point]) -> i128 {
    let Some(&base) = ring.first() else { return 0 };
    ring.windows(2).map(|pair| i128::from(orient(base, pair[0], pair[1]))).sum()
}

/// The ring without repeated points, points between collinear neighbours, and spikes (where the ring goes back along
/// the way it came); the shape enclosed stays exactly the same. Starts where the ring started if that point stays.
/// Empty when nothing with an area is left.
pub fn without_collinear(ring: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::with_capacity(ring.len());
    for &p in ring {
        push_reduced(&mut kept, p);
    }
    // The same across the seam: the ends may be collinear with, or equal to, what lies at the start.
    let mut first = 0;
    while kept.len() - first >= 3 {
        let (last, before, start, next) = (kept[kept.len() - 1], kept[kept.len() - 2], kept[first], kept[first + 1]);
        if last == start || orient(before, last, start) == 0 {
            kept.pop();
        } else if orient(last, start, next) == 0 {
            first += 1;
        } else {
            return kept.split_off(first);
        }
    }
    Vec::new()
}

/// Appends a point to an open chain that has no three consecutive collinear points, keeping it so.
fn push_reduced(chain: &mut Vec<Point>, p: Point) {
    while let Some(&last) = chain.last() {
        if last == p {
            return;
        }
        match chain.len().checked_sub(2).map(|i| chain[i]) {
            Some(before) if orient(before, last, p) == 0 => chain.pop(),
            _ => break,
        };
    }
    chain.push(p);
}

/// The ring in the asked orientation; its first point stays first.
fn turned(mut ring: Vec<Point>, counter_clockwise: bool) -> Vec<Point> {
    let doubled = ring_doubled_area(&ring);
    if doubled != 0 && (doubled > 0) != counter_clockwise {
        ring[1..].reverse();
    }
    ring
}

/// Twice the signed area of a ring and six times its first moments about `base`, all in LSB; exact.
fn ring_moments(ring: &[Point], base: Point) -> (i128, i128, i128) {
    ring_edges(ring).fold((0, 0, 0), |(area, mx, my), (a, b)| {
        let cross = i128::from(orient(base, a, b));
        let ((ax, ay), (bx, by)) = (base.to(a), base.to(b));
        (area + cross, mx + cross * i128::from(ax + bx), my + cross * i128::from(ay + by))
    })
}

/// Squared distance from a lattice point to a closed segment, in LSB².
fn distance_squared_to_segment(a: Point, b: Point, p: Point) -> f64 {
    let along = dot(a, b, p);
    let length_squared = a.distance_squared(b);
    if along <= 0 {
        return a.distance_squared(p) as f64;
    }
    if along >= length_squared {
        return b.distance_squared(p) as f64;
    }
    let across = orient(a, b, p) as f64;
    across * across / length_squared as f64
}
