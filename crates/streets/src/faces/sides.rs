//! From a core cycle to its sides and its signature.
//!
//! At a node the rim either goes on along its street or turns a *corner*. What ends or crosses at a node that the rim
//! merely passes is not seen from this face, so it changes neither the sides nor the signature.

use super::Side;
use crate::{Claim, HalfKey, NodeKey, StreetGraph, StreetId};
use geom::{Id, Point, predicates};
use smallvec::SmallVec;

/// How far (LSB) a node may lie off the line of a side that passes it: what rounding leaves of a few splits. A node
/// farther off is a shape point, even if no street pins it. Far below [`geom::tolerance::SEPARATION`], so that
/// straightening a side carries it over no other node.
const ON_LINE: i32 = 4;

/// Where the rim goes over to another street, or to another direction or passage of the same one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Corner {
    /// The street that starts to bound the face.
    pub street: StreetId,
    /// Whether the rim runs along the street in its own direction.
    pub forward: bool,
    /// What the corner hangs on: the two streets that meet there, not the node, whose name may come from a street on
    /// its other side; the node itself where a street meets itself or closes the face alone.
    pub at: crate::NodeId,
}

/// A core cycle as seen from its face.
pub(crate) struct Outline {
    /// The corners, from the least rotation on; never empty.
    pub corners: Corners,
    /// The sides, from the first of the corners on.
    pub sides: Vec<Side>,
}

/// Corners in their order round the face.
pub(crate) type Corners = SmallVec<[Corner; 6]>;

/// For each place on a cycle, whether the rim goes on along its street there.
type Passing = SmallVec<[bool; 32]>;

impl Outline {
    /// The outline of a simple cycle that touches others of its face at some nodes.
    pub fn of(graph: &StreetGraph, mut cycle: Vec<HalfKey>, pinches: &[NodeKey]) -> Self {
        let mut passing = passing(graph, &cycle);
        let corners = rotate_to_corners(graph, &mut cycle, &mut passing);
        let sides = sides(graph, &cycle, &passing, pinches);
        Self { corners, sides }
    }

    /// The hash of the cyclic sequence of corners.
    pub fn signature(&self) -> Id {
        let parts = self.corners.iter().flat_map(|corner| [corner.street.0.0, corner.forward.into(), corner.at.0.0]);
        let parts: SmallVec<[u128; 24]> = parts.collect();
        Id::root("rim", &parts)
    }
}

/// The least corner of a cycle.
pub(crate) fn least_corner(graph: &StreetGraph, cycle: &mut [HalfKey]) -> Option<Corner> {
    let mut passing = passing(graph, cycle);
    rotate_to_corners(graph, cycle, &mut passing).into_iter().min()
}

fn passing(graph: &StreetGraph, cycle: &[HalfKey]) -> Passing {
    let before = cycle.iter().cycle().skip(cycle.len() - 1);
    before.zip(cycle).map(|(&before, &half)| goes_on(graph, before, half)).collect()
}

/// Turns a cycle so that its corners are in least rotation, the first of them in front, and returns them. A cycle
/// without corners gets one that stands in for them.
fn rotate_to_corners(graph: &StreetGraph, cycle: &mut [HalfKey], passing: &mut [bool]) -> Corners {
    let mut places: SmallVec<[usize; 6]> = (0..cycle.len()).filter(|&i| !passing[i]).collect();
    if places.is_empty() {
        places.push(least_pinned(graph, cycle));
    }
    let before = |i: usize| cycle[if i == 0 { cycle.len() - 1 } else { i - 1 }];
    let mut corners: Corners = places.iter().map(|&i| corner_at(graph, before(i), cycle[i])).collect();
    let first = least_rotation(&corners);
    corners.rotate_left(first);
    cycle.rotate_left(places[first]);
    passing.rotate_left(places[first]);
    corners
}

fn corner_at(graph: &StreetGraph, before: HalfKey, half: HalfKey) -> Corner {
    let claim = graph.segment(half.segment()).leading();
    let from = graph.segment(before.segment()).leading().street;
    let at = if from == claim.street {
        graph.node(graph.origin(half)).id
    } else {
        crate::NodeId::crossing(from, claim.street, 0)
    };
    Corner { street: claim.street, forward: claim.forward == half.is_forward(), at }
}

/// Where the corner of a rim that has none is put: its street has the same claim to every node, but it is tied to
/// those that it pins.
fn least_pinned(graph: &StreetGraph, cycle: &[HalfKey]) -> usize {
    let rank = |&i: &usize| {
        let (node, street) = (graph.origin(cycle[i]), graph.segment(cycle[i].segment()).leading().street);
        (!graph.pins(node).contains(&street), graph.node(node).id)
    };
    (0..cycle.len()).min_by_key(rank).expect("a cycle has a half")
}

/// Start of the least rotation of a cyclic sequence, in linear time.
fn least_rotation(corners: &[Corner]) -> usize {
    let count = corners.len();
    let (mut best, mut other, mut same) = (0, 1, 0);
    while best < count && other < count && same < count {
        let (a, b) = (corners[(best + same) % count], corners[(other + same) % count]);
        if a == b {
            same += 1;
            continue;
        }
        if a > b {
            best = (best + same + 1).max(other);
            other = best + 1;
        } else {
            other += same + 1;
        }
        same = 0;
    }
    best.min(count - 1)
}

/// Whether the rim goes on along one passage of one street from `before` to `after`, which meet in a node.
fn goes_on(graph: &StreetGraph, before: HalfKey, after: HalfKey) -> bool {
    let (from, to) = (graph.segment(before.segment()).leading(), graph.segment(after.segment()).leading());
    let runs_forward = |claim: &Claim, half: HalfKey| claim.forward == half.is_forward();
    if from.street != to.street || runs_forward(from, before) != runs_forward(to, after) {
        return false;
    }
    let node = graph.origin(after);
    let arms = arms_of(graph, node, from.street);
    match arms.len() {
        2 => true,
        // A street that crosses itself goes straight on.
        count if count % 2 == 0 && !graph.pins(node).contains(&from.street) => {
            let at = arms.iter().position(|&arm| arm == after);
            at.is_some_and(|at| arms[(at + count / 2) % count] == before.twin())
        }
        _ => false,
    }
}

/// The arms on the ground along which a street runs.
fn arms_of(graph: &StreetGraph, node: NodeKey, street: StreetId) -> SmallVec<[HalfKey; 4]> {
    let runs_here = |arm: &HalfKey| {
        let segment = graph.segment(arm.segment());
        segment.level == 0 && segment.claims.iter().any(|claim| claim.street == street)
    };
    graph.halves_ccw(node).iter().copied().filter(runs_here).collect()
}

/// The sides of a cycle: what the rim passes straight on is left out.
fn sides(graph: &StreetGraph, cycle: &[HalfKey], passing: &[bool], pinches: &[NodeKey]) -> Vec<Side> {
    let mut kept = kept_places(graph, cycle, passing, pinches);
    if kept.len() < 3 {
        kept = (0..cycle.len()).collect();
    }
    let side = |slot: usize| {
        let (half, next) = (cycle[kept[slot]], cycle[kept[(slot + 1) % kept.len()]]);
        let segment = graph.segment(half.segment());
        let (from_node, to_node) = (graph.origin(half), graph.origin(next));
        Side {
            street: segment.leading().street,
            half_width: segment.half_width(),
            from: graph.at(from_node),
            to: graph.at(to_node),
            from_node,
        }
    };
    (0..kept.len()).map(side).collect()
}

/// Places on a cycle.
type Places = SmallVec<[usize; 16]>;

/// The places where a side starts, ascending.
fn kept_places(graph: &StreetGraph, cycle: &[HalfKey], passing: &[bool], pinches: &[NodeKey]) -> Places {
    let may_pass =
        |i: usize| passing[i] && may_be_left_out(graph, cycle[(i + cycle.len() - 1) % cycle.len()], cycle[i], pinches);
    let mut kept: Places = (0..cycle.len()).filter(|&i| !may_pass(i)).collect();
    if kept.is_empty() || kept.len() == cycle.len() {
        return kept;
    }
    let points: Vec<Point> = cycle.iter().map(|&half| graph.at(graph.origin(half))).collect();
    let fixed = kept.clone();
    for (slot, &from) in fixed.iter().enumerate() {
        let to = fixed.get(slot + 1).copied().unwrap_or(fixed[0] + cycle.len());
        keep_bends(&points, from, to, &mut kept);
    }
    kept.sort_unstable();
    kept
}

/// Whether a side could do without the node between two halves of one street.
fn may_be_left_out(graph: &StreetGraph, before: HalfKey, after: HalfKey, pinches: &[NodeKey]) -> bool {
    let node = graph.origin(after);
    let (from, to) = (graph.segment(before.segment()), graph.segment(after.segment()));
    from.half_width() == to.half_width() && !graph.pins(node).contains(&to.leading().street) && !pinches.contains(&node)
}

/// Adds to `kept` the places strictly between two cyclic ones that lie off the line: the farthest, then those off
/// the two lines it makes, and so on.
fn keep_bends(points: &[Point], from: usize, to: usize, kept: &mut Places) {
    let mut spans: SmallVec<[(usize, usize); 8]> = SmallVec::from_slice(&[(from, to)]);
    while let Some((from, to)) = spans.pop() {
        let (a, b) = (points[from % points.len()], points[to % points.len()]);
        let off = |i: &usize| !predicates::within(a, b, points[i % points.len()], ON_LINE);
        let distance = |i: &usize| {
            let p = points[i % points.len()];
            (predicates::orient(a, b, p).abs(), a.distance_squared(p), std::cmp::Reverse(*i))
        };
        if let Some(bend) = (from + 1..to).filter(off).max_by_key(distance) {
            kept.push(bend % points.len());
            spans.extend([(from, bend), (bend, to)]);
        }
    }
}
