//! Keeping a footprint to a share of its parcel: what is too much is taken off the rear.

use crate::extrusion::largest;
use crate::sides::{longest, main_front};
use crate::{StartShape, convex};
use geom::polygon::ring_edges;
use geom::strip::{Reach, strip};
use geom::{Point, Polygon, Vec2, boolean};

/// Halvings of the depth: to less than a lattice unit for any parcel.
const HALVINGS: u32 = 40;

/// How often a depth is reduced after rounding made the footprint too large still, and by how many metres.
const TRIES: u32 = 8;
const STEP: f64 = 0.05;

/// The part of a footprint next to the main front that covers at most `limit` m²; none where that is too little to
/// build.
pub(crate) fn shortened(shape: &StartShape, footprint: Polygon, limit: f64) -> Option<Polygon> {
    let ring = &shape.outline.outer;
    let along = main_front(ring, &shape.fronts).or_else(|| longest(ring_edges(ring)))?;
    let base = footprint.outer.first()?.metres();
    let depth = |p: &Point| along.perp().dot(p.metres() - base);
    let (near, far) = footprint.outer.iter().map(depth).fold((f64::MAX, f64::MIN), |(l, h), d| (l.min(d), h.max(d)));
    let (mut low, mut high) = (near, far);
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        if area_before(&footprint, base, along, middle) > limit { high = middle } else { low = middle }
    }
    let cut = |k: u32| largest(cut_off(&footprint, base, along, low - STEP * f64::from(k), far - near));
    (0..TRIES).find_map(|k| cut(k).filter(|part| part.area() <= limit))
}

/// What lies less than `depth` metres behind a line.
fn cut_off(footprint: &Polygon, base: Vec2, along: Vec2, depth: f64, extent: f64) -> Vec<Polygon> {
    let middle = base + along.perp() * depth;
    // Turned round: what lies before the line is on its left.
    if let Some(part) = footprint.holes.is_empty().then(|| convex::left_of(&footprint.outer, middle, -along)).flatten()
    {
        return part.into_iter().collect();
    }
    let reach = footprint.perimeter() + extent;
    let (from, to) = (Point::from_metres(middle - along * reach), Point::from_metres(middle + along * reach));
    let behind = Reach { left: geom::point::units(extent + STEP * f64::from(TRIES) + 1.0), ..Reach::default() };
    let Some(rest) = strip(from, to, behind) else { return Vec::new() };
    boolean::difference(std::slice::from_ref(footprint), &[Polygon::new(rest.into(), Vec::new())])
}

/// The area in m² of what lies less than `depth` metres behind the line through `base`.
fn area_before(footprint: &Polygon, base: Vec2, along: Vec2, depth: f64) -> f64 {
    let of_ring = |ring: &[Point]| {
        let place = |p: Point| p.metres() - base;
        let mut sum = 0.0;
        // Beyond the line the border runs along it: in coordinates from the line, that adds nothing.
        let origin = along.perp() * depth;
        for (a, b) in ring_edges(ring) {
            let (a, b) = (place(a) - origin, place(b) - origin);
            let (da, db) = (along.perp().dot(a), along.perp().dot(b));
            let cut = |from: Vec2, to: Vec2, d: f64, e: f64| from + (to - from) * (d / (d - e));
            sum += match (da < 0.0, db < 0.0) {
                (true, true) => a.perp_dot(b),
                (true, false) => a.perp_dot(cut(a, b, da, db)),
                (false, true) => cut(b, a, db, da).perp_dot(b),
                (false, false) => 0.0,
            };
        }
        sum / 2.0
    };
    footprint.rings().map(of_ring).sum()
}
