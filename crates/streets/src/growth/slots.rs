//! The places of a rim that streets of quarters may come to.
//!
//! Streets on both sides of a rim grow without knowing of each other, and lines that should meet there in one place miss it
//! by what rounding makes of each. So such places are rounded once more, to slots so far apart that both sides find the
//! same one, and so close together that nobody sees a street bend to it.

use super::Attachment;
use crate::{SegmentKey, StreetGraph};
use geom::{Point, predicates, tolerance};

/// Distance of slots in the coordinate that changes more along the rim, in LSB: above the separation, so that streets
/// in neighbouring slots keep it; twice that, so that rounding seldom sets the two sides astride the border of two.
pub(super) const SPACING: i32 = 2 * tolerance::SEPARATION;

/// How far a rim may lie from where a quarter saw it, in LSB: what its splits move it by.
const SEEN: i32 = 8;

/// The slot of the line from `a` to `b` nearest to a place on it; the place itself where that is beyond an end.
pub(super) fn slot(a: Point, b: Point, at: Point) -> Point {
    let (dx, dy) = a.to(b);
    if dx.abs() >= dy.abs() {
        let x = nearest(at.x);
        if is_between(a.x, b.x, x) { Point::new(x, a.y + across(x, a.x, dy, dx)) } else { at }
    } else {
        let y = nearest(at.y);
        if is_between(a.y, b.y, y) { Point::new(a.x + across(y, a.y, dx, dy), y) } else { at }
    }
}

fn nearest(coordinate: i32) -> i32 {
    (coordinate + SPACING / 2).div_euclid(SPACING) * SPACING
}

fn is_between(a: i32, b: i32, c: i32) -> bool {
    a.min(b) < c && c < a.max(b)
}

/// What the lesser coordinate has changed by where the greater one is `coordinate`.
fn across(coordinate: i32, start: i32, lesser: i64, greater: i64) -> i32 {
    predicates::round_div(i128::from(lesser) * i128::from(coordinate - start), i128::from(greater)) as i32
}

/// The slot of a stub on the rim as it is in the graph that quarters are attached to: a quarter sees its sides straight,
/// whatever a few splits made of them.
pub(super) fn slot_of(graph: &StreetGraph, stub: &Attachment) -> Point {
    let is_rim =
        |key| graph.segment(key).level == 0 && graph.segment(key).claims().iter().any(|c| c.street == stub.street);
    let slot_on = |key: SegmentKey| {
        let (a, b) = graph.line(key.forward());
        slot(a, b, stub.at)
    };
    let found = graph.nearest_segment_where(stub.at, SEEN, is_rim).map(|(key, ..)| slot_on(key));
    // A street may have come to a crossing instead.
    found.filter(|&slot| slot.distance(stub.at) <= f64::from(SEEN)).unwrap_or(stub.at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A place and what rounding makes of it from the other side have one slot, unless they lie astride the border
        /// of two; a slot is its own slot, lies on the line, and is close.
        #[test]
        fn a_slot_is_near_and_kept(ax in -900_000i32..900_000, ay in -900_000i32..900_000, dx in -900_000i32..900_000,
                                   dy in -900_000i32..900_000, share in 0.0f64..1.0, off in -2i32..=2) {
            let (a, b) = (Point::new(ax, ay), Point::new(ax + dx, ay + dy));
            prop_assume!(a.distance_squared(b) > 4 * i64::from(SPACING) * i64::from(SPACING));
            let on = |share: f64| Point::new(ax + (f64::from(dx) * share).round() as i32, ay + (f64::from(dy) * share).round() as i32);
            let at = on(share);
            let found = slot(a, b, at);
            prop_assert!(predicates::within(a, b, found, 1));
            prop_assert_eq!(slot(a, b, found), found);
            prop_assert_eq!(slot(b, a, found), found, "whichever way the rim is seen");
            prop_assert!(found.distance(at) <= f64::from(SPACING / 2) * std::f64::consts::SQRT_2 + 2.0);
            let greater = |p: Point| if dx.abs() >= dy.abs() { p.x } else { p.y };
            let border = (greater(at) + SPACING / 2).rem_euclid(SPACING);
            if found != at && (3..SPACING - 3).contains(&border) {
                let beside = Point::new(at.x + off, at.y - off);
                prop_assert_eq!(slot(a, b, beside), found);
            }
        }
    }
}
