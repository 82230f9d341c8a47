//! Strips along lines and the wedges at their bends: small convex polygons that cover the exact body of a line of some
//! width. They are computed in floats and drawn out by [`COVER`], so that after rounding they still cover it.

use crate::{Point, Polygon, Vec2};

/// How far a strip is drawn out beyond its exact border, in LSB: rounding its corners takes at most 0.71 of it, which
/// leaves more than one for the rounding of a boolean's crossing points.
const COVER: f64 = 2.0;

/// How far the tip of a mitre may lie from the bend, in half widths; beyond it the tip is cut off square at that
/// distance (the rule of GEOS, which measures what we export).
pub const MITRE_LIMIT: f64 = 5.0;

/// How far a strip reaches from its centre line, in LSB: to the sides as seen from its start, and beyond its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reach {
    /// To the left.
    pub left: i32,
    /// To the right.
    pub right: i32,
    /// Beyond the start.
    pub before: i32,
    /// Beyond the end.
    pub after: i32,
}

/// The rectangle around the line from `from` to `to`, counter-clockwise from its start on the right, covering the exact
/// one by one to three LSB; `None` for a line without length. Corners are held within the lattice.
pub fn strip(from: Point, to: Point, reach: Reach) -> Option<[Point; 4]> {
    let along = direction(from, to)?;
    let left = along.perp();
    let out = |reach: i32| f64::from(reach) + COVER;
    let (start, end) = (along * -out(reach.before), along * out(reach.after));
    let (port, starboard) = (left * out(reach.left), left * -out(reach.right));
    Some([moved(from, start + starboard), moved(to, end + starboard), moved(to, end + port), moved(from, start + port)])
}

/// The wedge that fills the outer side of the bend `before`–`at`–`after` between a strip of half width `half_in` and
/// one of `half_out`: a mitre where their borders meet, cut off at [`MITRE_LIMIT`]; a bevel where they do not meet
/// ahead. Counter-clockwise; `None` where nothing bends.
pub fn wedge(before: Point, at: Point, after: Point, half_in: i32, half_out: i32) -> Option<Vec<Point>> {
    let turn = crate::predicates::orient(before, at, after);
    if turn == 0 {
        return None;
    }
    let outer = if turn > 0 { -1.0 } else { 1.0 };
    let arm = |d: Vec2, half: i32| Arm { along: d, normal: d.perp() * outer, reach: f64::from(half) + COVER };
    let (arm_in, arm_out) = (arm(direction(before, at)?, half_in), arm(direction(at, after)?, half_out));
    let limit = MITRE_LIMIT * f64::from(half_in.max(half_out)) + COVER;
    let mut ring = vec![at, moved(at, arm_in.normal * arm_in.reach)];
    ring.extend(tip(&arm_in, &arm_out, limit).into_iter().flatten().map(|offset| moved(at, offset)));
    ring.push(moved(at, arm_out.normal * arm_out.reach));
    if turn < 0 {
        ring.reverse();
    }
    Some(ring)
}

/// A polygon grown outwards by `by` LSB, with mitred corners: it covers everything nearer than that. Its holes are
/// filled; the largest part where growing leaves several.
pub fn grown(polygon: &Polygon, by: i32) -> Polygon {
    let ring = &polygon.outer;
    let (n, half) = (ring.len(), by.max(0));
    let at = |i: usize| ring[i % n];
    let side = Reach { left: half, right: half, before: 0, after: 0 };
    let strips = (0..n).filter_map(|i| strip(at(i), at(i + 1), side).map(Vec::from));
    let wedges = (0..n).filter_map(|i| wedge(at(i), at(i + 1), at(i + 2), half, half));
    let pieces = strips.chain(wedges).map(|ring| Polygon::new(ring, Vec::new()));
    let whole = std::iter::once(Polygon::new(ring.clone(), Vec::new())).chain(pieces).collect::<Vec<_>>();
    let parts = crate::boolean::union(&whole).into_iter().map(|part| Polygon::new(part.outer, Vec::new()));
    parts.max_by_key(Polygon::doubled_area).unwrap_or_else(|| polygon.clone())
}

/// One side of a bend: its direction of travel, the outer normal, and how far its border lies out.
struct Arm {
    along: Vec2,
    normal: Vec2,
    reach: f64,
}

/// The tip of a mitre as offsets from the bend: nothing for a bevel, one point, or two where it is cut off.
fn tip(arm_in: &Arm, arm_out: &Arm, limit: f64) -> [Option<Vec2>; 2] {
    let across = arm_in.normal.perp_dot(arm_out.normal);
    if across == 0.0 {
        return [None, None];
    }
    let meeting = (arm_out.normal.perp() * -arm_in.reach + arm_in.normal.perp() * arm_out.reach) / across;
    if !meeting.is_finite() || meeting.dot(arm_in.along) < 0.0 || meeting.dot(arm_out.along) > 0.0 {
        return [None, None];
    }
    let distance = meeting.length();
    if distance <= limit {
        return [Some(meeting), None];
    }
    let axis = meeting / distance;
    let clipped = |arm: &Arm| {
        let base = arm.normal * arm.reach;
        let slope = arm.along.dot(axis);
        (slope != 0.0).then(|| base + arm.along * ((limit - base.dot(axis)) / slope))
    };
    [clipped(arm_in), clipped(arm_out)]
}

/// The unit vector from one point to another.
fn direction(from: Point, to: Point) -> Option<Vec2> {
    let (dx, dy) = from.to(to);
    Vec2::new(dx as f64, dy as f64).try_normalize()
}

/// A point moved by an offset in LSB, rounded, held within the lattice.
fn moved(from: Point, offset: Vec2) -> Point {
    let limit = f64::from(Point::LIMIT);
    let place = |c: i32, d: f64| (f64::from(c) + d).round().clamp(-limit, limit) as i32;
    Point::new(place(from.x, offset.x), place(from.y, offset.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicates::orient;
    use proptest::prelude::*;

    fn p(x: i32, y: i32) -> Point {
        Point::new(x, y)
    }

    #[test]
    fn a_strip_is_the_rectangle_drawn_out() {
        let reach = Reach { left: 10, right: 20, before: 0, after: 5 };
        assert_eq!(strip(p(0, 0), p(100, 0), reach), Some([p(-2, -22), p(107, -22), p(107, 12), p(-2, 12)]));
        assert_eq!(strip(p(3, 3), p(3, 3), reach), None);
    }

    #[test]
    fn a_right_angle_has_a_square_tip_on_its_outer_side() {
        assert_eq!(wedge(p(-100, 0), p(0, 0), p(0, 100), 8, 8), Some(vec![p(0, 0), p(0, -10), p(10, -10), p(10, 0)]));
        assert_eq!(wedge(p(-100, 0), p(0, 0), p(0, -100), 8, 8), Some(vec![p(10, 0), p(10, 10), p(0, 10), p(0, 0)]));
        assert_eq!(wedge(p(-100, 0), p(0, 0), p(100, 0), 8, 8), None);
    }

    #[test]
    fn a_hairpin_is_cut_off_at_the_limit() {
        let ring = wedge(p(-100_000, 0), p(0, 0), p(-100_000, 5_000), 1000, 1000).unwrap();
        let farthest = ring.iter().map(|q| q.distance_squared(p(0, 0))).max().unwrap() as f64;
        assert_eq!(ring.len(), 5);
        assert!(farthest.sqrt() > 5000.0 && farthest.sqrt() < 5200.0, "{}", farthest.sqrt());
    }

    #[test]
    fn unequal_widths_on_a_slight_bend_are_bevelled() {
        let ring = wedge(p(-10_000, 0), p(0, 0), p(10_000, 10), 1000, 4000).unwrap();
        assert_eq!(ring.len(), 3);
    }

    fn any_point() -> impl Strategy<Value = Point> {
        (-100_000..100_000, -100_000..100_000).prop_map(|(x, y)| Point::new(x, y))
    }

    proptest! {
        #[test]
        fn a_strip_covers_the_exact_rectangle(
            a in any_point(), b in any_point(), half in 0i32..20_000, across in -1.0..1.0, along in 0.0..1.0,
        ) {
            prop_assume!(a.distance_squared(b) > 100);
            let ring = strip(a, b, Reach { left: half, right: half, ..Reach::default() }).unwrap();
            let (dx, dy) = a.to(b);
            let d = Vec2::new(dx as f64, dy as f64);
            let offset = d * along + d.normalize().perp() * (f64::from(half) * across);
            let q = Vec2::new(f64::from(a.x), f64::from(a.y)) + offset;
            for (i, corner) in ring.iter().enumerate() {
                let next = ring[(i + 1) % 4];
                let side = Vec2::new(f64::from(next.x - corner.x), f64::from(next.y - corner.y));
                let inward = side.normalize().perp().dot(q - Vec2::new(f64::from(corner.x), f64::from(corner.y)));
                prop_assert!(inward > 0.9, "only {inward} inside");
            }
        }

        #[test]
        fn a_wedge_is_counter_clockwise_and_convex(
            a in any_point(), b in any_point(), c in any_point(), half in 100i32..20_000, other in 100i32..20_000,
        ) {
            prop_assume!(a.distance_squared(b) > 10_000 && b.distance_squared(c) > 10_000);
            let Some(ring) = wedge(a, b, c, half, other) else { return Ok(()) };
            let n = ring.len();
            let doubled: i64 = (1..n - 1).map(|i| orient(ring[0], ring[i], ring[i + 1])).sum();
            let perimeter: f64 = (0..n).map(|i| ring[i].distance(ring[(i + 1) % n])).sum();
            prop_assert!(doubled as f64 > -2.0 * 1024.0 * perimeter);
        }
    }

    #[test]
    fn a_polygon_grows_by_as_much_everywhere() {
        let square = Polygon::new(vec![p(0, 0), p(1000, 0), p(1000, 1000), p(0, 1000)], Vec::new());
        let far = grown(&square, 100);
        assert_eq!(far.outer, [p(-102, -102), p(1102, -102), p(1102, 1102), p(-102, 1102)]);
        // The notch of a C is filled when it grows together.
        let ring = [(0, 0), (900, 0), (900, 300), (300, 300), (300, 400), (900, 400), (900, 900), (0, 900)];
        let c = Polygon::new(ring.map(|(x, y)| p(x, y)).to_vec(), Vec::new());
        let far = grown(&c, 100);
        assert!(far.holes.is_empty() && c.outer.iter().all(|&corner| far.contains(corner)));
        assert!(far.contains(p(600, 350)) && far.edges().all(|(a, _)| c.distance_to_rim(a.metres()) * 1024.0 >= 99.0));
    }
}
