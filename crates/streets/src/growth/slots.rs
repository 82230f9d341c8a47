//! The places of a rim that streets of quarters may come to.
//!
//! Streets on both sides of a rim grow without knowing of each other, and must not: else a change on one side reached the
//! other. Where both should meet in one crossing, each has to find it alone. So streets come to slots of the rim only.
//! What follows a raster goes where the raster's own line cuts the rim, rounded to slots so close together that nobody
//! sees a street bend to one; what winds is led to slots as far apart as it snaps.

use super::Attachment;
use super::lineage::Proposal;
use crate::{SegmentKey, StreetGraph};
use geom::{Point, Vec2, predicates, tolerance};

/// Distance of slots in the coordinate that changes more along the rim, in LSB (25 cm): so that a street that comes to one
/// at the least angle of grown streets passes a crossing in the next by more than the laying distance, and is not led
/// through it.
pub(super) const SPACING: i32 = 4 * tolerance::SEPARATION;

/// A street follows its course as long as it cuts a rim this close (m) to where the course does: what rounding makes of
/// the ends of its pieces.
const OFF_COURSE: f64 = 0.02;

/// Where a street may come to rims.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimSlots<'a> {
    proposal: &'a Proposal,
    /// Distance of its slots: a multiple of [`SPACING`].
    spacing: i32,
}

impl<'a> RimSlots<'a> {
    /// Those of a street that snaps as far as `snap` LSB: what winds keeps that distance on the rim.
    pub fn new(proposal: &'a Proposal, snap: i32) -> Self {
        let times = if proposal.is_on_raster() { 1 } else { snap.div_euclid(SPACING).max(0) + 1 };
        Self { proposal, spacing: times.saturating_mul(SPACING) }
    }

    /// The slot for a street that meets the line from `a` to `b` at a place.
    pub fn slot(&self, a: Point, b: Point, at: Point) -> Point {
        let course = self.proposal.course().and_then(|course| cut(course, a, b));
        let at = course.filter(|&place| is_near(place, at)).map_or(at, Point::from_metres);
        let coarse = slot(a, b, at, self.spacing);
        // Near an end, what follows a street's own wish is better than the end.
        if coarse == a || coarse == b { slot(a, b, at, SPACING) } else { coarse }
    }
}

fn is_near(place: Vec2, at: Point) -> bool {
    (place - at.metres()).length() <= OFF_COURSE
}

/// Where the line through two places cuts the line from `a` to `b`, in metres.
fn cut([from, to]: [Vec2; 2], a: Point, b: Point) -> Option<Vec2> {
    // The same whichever way the two are seen.
    let (a, b) = (a.min(b).metres(), a.max(b).metres());
    let (along, rim) = (to - from, b - a);
    let share = (from - a).perp_dot(along) / rim.perp_dot(along);
    share.is_finite().then(|| a + rim * share)
}

/// How far a rim may lie from where a quarter saw it, in LSB: what its splits move it by.
const SEEN: i32 = 8;

/// The slot of the line from `a` to `b` nearest to a place on it; the nearer end where that is closer to one than slots
/// are.
fn slot(a: Point, b: Point, at: Point, spacing: i32) -> Point {
    let (dx, dy) = a.to(b);
    let place = if dx.abs() >= dy.abs() {
        let x = nearest(at.x, spacing);
        is_between(a.x, b.x, x).then(|| Point::new(x, a.y + across(x, a.x, dy, dx)))
    } else {
        let y = nearest(at.y, spacing);
        is_between(a.y, b.y, y).then(|| Point::new(a.x + across(y, a.y, dx, dy), y))
    };
    let end = |end: &Point| (at.distance_squared(*end), *end);
    place.unwrap_or(std::cmp::min_by_key(a, b, end))
}

fn nearest(coordinate: i32, spacing: i32) -> i32 {
    coordinate.saturating_add(spacing / 2).div_euclid(spacing) * spacing
}

/// Whether a slot keeps the distance of slots from both ends.
fn is_between(a: i32, b: i32, c: i32) -> bool {
    a.min(b).saturating_add(SPACING) <= c && c <= a.max(b).saturating_sub(SPACING)
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
        slot(a, b, stub.at, SPACING)
    };
    let found = graph.nearest_segment_where(stub.at, SEEN, is_rim).map(|(key, ..)| slot_on(key));
    // A street may have come to a crossing instead.
    found.filter(|&slot| slot.distance_squared(stub.at) <= 2 * i64::from(SEEN * SEEN)).unwrap_or(stub.at)
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
            let found = slot(a, b, at, SPACING);
            prop_assert!(predicates::within(a, b, found, 1));
            prop_assert_eq!(slot(a, b, found, SPACING), found);
            prop_assert_eq!(slot(b, a, found, SPACING), found, "whichever way the rim is seen");
            let is_end = found == a || found == b;
            let most = if is_end { 1.5 } else { 0.5 } * f64::from(SPACING) * std::f64::consts::SQRT_2 + 2.0;
            let distance = |p: Point| (found.distance_squared(p) as f64).sqrt();
            prop_assert!(distance(at) <= most, "{found:?}");
            prop_assert!(is_end || distance(a).min(distance(b)) >= f64::from(SPACING), "{found:?}");
            let greater = |p: Point| if dx.abs() >= dy.abs() { p.x } else { p.y };
            let border = (greater(at) + SPACING / 2).rem_euclid(SPACING);
            if !is_end && (3..SPACING - 3).contains(&border) {
                let beside = Point::new(at.x + off, at.y - off);
                prop_assert_eq!(slot(a, b, beside, SPACING), found);
            }
        }
    }
}
