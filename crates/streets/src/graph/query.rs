//! What lies near a place or ahead of a line. All answers are exact and independent of the graph's history.

use super::{NodeKey, SegmentKey, StreetGraph};
use crate::StreetId;
use geom::{Bounds, Point, predicates, tolerance};
use smallvec::SmallVec;
use std::cmp::Ordering;

/// The first thing a line runs into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CrossingAhead {
    /// The segment that is met.
    pub segment: SegmentKey,
    /// Where, rounded to the lattice.
    pub at: Point,
    /// The end of that segment, when the meeting place comes within the laying distance of it.
    pub node: Option<NodeKey>,
}

impl StreetGraph {
    /// Segments of any level whose box overlaps the box, by key.
    pub fn segments_near(&self, bounds: Bounds) -> Vec<SegmentKey> {
        let mut found = Vec::new();
        self.for_segments_near(bounds, |key| found.push(key));
        found
    }

    /// Calls `f` for each segment of any level whose box overlaps the box, by key, each once.
    pub fn for_segments_near(&self, bounds: Bounds, f: impl FnMut(SegmentKey)) {
        self.index.near(bounds).into_iter().for_each(f);
    }

    /// Whether a node has a segment of that level.
    pub fn has_level(&self, node: NodeKey, level: i8) -> bool {
        self.halves_ccw(node).iter().any(|&arm| self.level(arm) == level)
    }

    /// The node nearest to `p` closer than `reach` LSB, with its squared distance in LSB²; ties go to the lower id.
    pub fn nearest_node(&self, p: Point, reach: i32) -> Option<(NodeKey, i64)> {
        let mut best: Option<(i64, crate::NodeId, NodeKey)> = None;
        let limit = i64::from(reach) * i64::from(reach);
        for key in self.index.near(Bounds::between(p, p).grown(reach)) {
            for end in self.segment(key).ends {
                let node = self.node(end);
                let distance = node.at.distance_squared(p);
                if distance < limit && best.is_none_or(|(d, id, _)| (distance, node.id) < (d, id)) {
                    best = Some((distance, node.id, end));
                }
            }
        }
        best.map(|(distance, _, key)| (key, distance))
    }

    /// The segment of a level nearest to `p` closer than `reach` LSB, the foot of `p` on it (rounded), and the foot's
    /// squared distance in LSB²; ties go to the lower id.
    pub fn nearest_segment(&self, p: Point, reach: i32, level: i8) -> Option<(SegmentKey, Point, i64)> {
        self.nearest_segment_where(p, reach, |key| self.segment(key).level == level)
    }

    pub(crate) fn nearest_segment_where(
        &self,
        p: Point,
        reach: i32,
        admit: impl Fn(SegmentKey) -> bool,
    ) -> Option<(SegmentKey, Point, i64)> {
        let mut best: Option<(i64, crate::SegmentId, SegmentKey, Point)> = None;
        for key in self.index.near(Bounds::between(p, p).grown(reach)) {
            let (a, b) = self.line(key.forward());
            if !predicates::within(a, b, p, reach) || !admit(key) {
                continue;
            }
            let foot = predicates::foot(a, b, p);
            let (distance, id) = (foot.distance_squared(p), self.segment(key).id);
            if best.is_none_or(|(d, best_id, ..)| (distance, id) < (d, best_id)) {
                best = Some((distance, id, key, foot));
            }
        }
        best.map(|(distance, _, key, foot)| (key, foot, distance))
    }

    /// What the line from `from` to `to` meets first on a level; what touches it only at `from` is passed over.
    pub fn first_crossing(&self, from: Point, to: Point, level: i8) -> Option<CrossingAhead> {
        let mut best: Option<(Fraction, SegmentKey)> = None;
        for key in self.index.near(Bounds::between(from, to)) {
            if self.segment(key).level != level {
                continue;
            }
            let (c, d) = self.line(key.forward());
            let Some(t) = meeting_parameter(from, to, c, d) else { continue };
            let nearer = best.is_none_or(|(best_t, best_key)| {
                t.compare(best_t).then_with(|| self.segment(key).id.cmp(&self.segment(best_key).id)).is_lt()
            });
            if nearer {
                best = Some((t, key));
            }
        }
        best.map(|(t, segment)| {
            let at = t.point_on(from, to);
            let near = |end: &NodeKey| self.at(*end).distance_squared(at) < i64::from(tolerance::LAYING).pow(2);
            let node = self.segment(segment).ends.into_iter().filter(near).min_by_key(|end| {
                let node = self.node(*end);
                (node.at.distance_squared(at), node.id)
            });
            CrossingAhead { segment, at, node }
        })
    }

    /// The segments of a street, by id.
    pub fn segments_of(&self, street: StreetId) -> Vec<SegmentKey> {
        let mut keys: Vec<_> = self.street_segments.get(&street).into_iter().flatten().copied().collect();
        keys.sort_unstable_by_key(|key| self.segment(*key).id);
        keys
    }

    /// All streets, by id.
    pub fn streets(&self) -> Vec<StreetId> {
        let claims = self.segments_unsorted().flat_map(|(_, segment)| segment.claims().iter());
        let mut streets: Vec<_> = claims.map(|claim| claim.street).collect();
        streets.sort_unstable();
        streets.dedup();
        streets
    }

    /// The live node of an id.
    pub fn find_node(&self, id: crate::NodeId) -> Option<NodeKey> {
        self.node_ids.get(&id).copied()
    }

    /// The segment between two nodes on a level.
    pub fn segment_between(&self, a: NodeKey, b: NodeKey, level: i8) -> Option<SegmentKey> {
        let arms = self.halves_ccw(a).iter();
        arms.copied().find(|&arm| self.target(arm) == b && self.level(arm) == level).map(|arm| arm.segment())
    }

    /// The neighbours of a node along one street: the other ends of its segments there, with their level.
    pub(crate) fn neighbours_along(&self, node: NodeKey, street: StreetId) -> SmallVec<[(NodeKey, i8); 2]> {
        let arms = self.halves_ccw(node).iter();
        arms.filter(|arm| self.segment(arm.segment()).claims.iter().any(|claim| claim.street == street))
            .map(|&arm| (self.target(arm), self.level(arm)))
            .collect()
    }
}

/// A parameter along a line, in [0, 1]; the denominator is positive.
#[derive(Clone, Copy)]
struct Fraction {
    numerator: i128,
    denominator: i128,
}

impl Fraction {
    fn compare(self, other: Self) -> Ordering {
        (self.numerator * other.denominator).cmp(&(other.numerator * self.denominator))
    }

    fn point_on(self, a: Point, b: Point) -> Point {
        let (dx, dy) = a.to(b);
        let place = |from: i32, d: i64| {
            let moved = predicates::round_div(i128::from(d) * self.numerator, self.denominator);
            (i128::from(from) + moved) as i32
        };
        Point::new(place(a.x, dx), place(a.y, dy))
    }
}

/// Where on `a b`, past `a`, the closed segment `c d` is met first.
fn meeting_parameter(a: Point, b: Point, c: Point, d: Point) -> Option<Fraction> {
    let (sc, sd) = (predicates::orient(a, b, c), predicates::orient(a, b, d));
    if sc == 0 && sd == 0 {
        return collinear_parameter(a, b, c, d);
    }
    if (sc > 0 && sd > 0) || (sc < 0 && sd < 0) {
        return None;
    }
    let (sa, sb) = (predicates::orient(c, d, a), predicates::orient(c, d, b));
    if sa == 0 || (sa > 0 && sb > 0) || (sa < 0 && sb < 0) {
        return None;
    }
    let (numerator, denominator) = (i128::from(sa), i128::from(sa) - i128::from(sb));
    Some(Fraction { numerator: numerator.abs(), denominator: denominator.abs() })
}

fn collinear_parameter(a: Point, b: Point, c: Point, d: Point) -> Option<Fraction> {
    let length_squared = a.distance_squared(b);
    let (tc, td) = (predicates::dot(a, b, c), predicates::dot(a, b, d));
    let (low, high) = (tc.min(td), tc.max(td));
    let first = if low > 0 { low } else { high.min(length_squared) };
    let meets = low < length_squared + 1 && high > 0 && first <= length_squared;
    meets.then_some(Fraction { numerator: i128::from(first), denominator: i128::from(length_squared) })
}
