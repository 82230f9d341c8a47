//! Which face a component of the graph lies in.
//!
//! A component has one rim without positive area, that of the face around it. From its leftmost, then lowest node a
//! ray runs to the left, an infinitesimal above the node; the first segment it meets belongs to another component and
//! bounds the face. Segments span the heights from their lower end up to below their upper end, so a ray through a node
//! or along a horizontal segment needs no special case. All rays are answered together from a tree over their heights:
//! segments kept in one tree node span all its heights, and so lie in order from left to right there.

use super::walk::{NONE, Rims};
use crate::{HalfKey, SegmentKey, StreetGraph};
use geom::{Point, predicates::orient};
use std::cmp::Ordering;

/// For each rim the rim that closes its face outside: itself where it has positive area, [`NONE`] for rims that
/// bound the unbounded face. The segments of the rims must not cross.
pub(crate) fn closing_rims(graph: &StreetGraph, rims: &Rims) -> Vec<u32> {
    let mut closing: Vec<u32> = (0..rims.len()).map(|rim| if rims.area(rim) > 0 { rim as u32 } else { NONE }).collect();
    let mut holes: Vec<(Point, usize)> = (0..rims.len())
        .filter(|&rim| rims.area(rim) <= 0)
        .map(|rim| (least_point(graph, rims.halves(rim)), rim))
        .collect();
    if holes.len() < 2 {
        return closing;
    }
    holes.sort_unstable();
    let rays = Rays::new(graph, rims, &holes);
    // What a ray meets reaches farther left than its start, so its own face is known already.
    for &(start, rim) in &holes {
        if let Some(half) = rays.first_met(start) {
            closing[rim] = closing[rims.rim_of(half) as usize];
        }
    }
    closing
}

/// The leftmost, then lowest node of a rim.
fn least_point(graph: &StreetGraph, rim: &[HalfKey]) -> Point {
    rim.iter().map(|&half| graph.at(graph.origin(half))).min().expect("a rim has a half")
}

/// A segment that is not horizontal, from its lower to its upper end.
#[derive(Clone, Copy)]
struct Riser {
    low: Point,
    high: Point,
    key: SegmentKey,
}

impl Riser {
    fn new(graph: &StreetGraph, key: SegmentKey) -> Option<Self> {
        let (a, b) = graph.line(key.forward());
        match a.y.cmp(&b.y) {
            Ordering::Less => Some(Self { low: a, high: b, key }),
            Ordering::Greater => Some(Self { low: b, high: a, key }),
            Ordering::Equal => None,
        }
    }

    /// Order from left to right of two risers that share a height and do not cross.
    fn left_to_right(&self, other: &Self) -> Ordering {
        let side_of = |riser: &Self, p: Point, q: Point| match orient(riser.low, riser.high, p) {
            0 => orient(riser.low, riser.high, q),
            side => side,
        };
        // A point right of a line that runs upwards has a negative side.
        if self.low.y >= other.low.y {
            0.cmp(&side_of(other, self.low, self.high))
        } else {
            side_of(self, other.low, other.high).cmp(&0)
        }
    }

    /// The half that has the face to the east on its left: the one that runs downwards.
    fn facing_east(&self, graph: &StreetGraph) -> HalfKey {
        let forward = self.key.forward();
        if graph.at(graph.origin(forward)) == self.high { forward } else { forward.twin() }
    }
}

/// A static tree over the heights of all rays.
struct Rays<'a> {
    graph: &'a StreetGraph,
    heights: Vec<i32>,
    /// Risers by tree node, from left to right in each.
    risers: Vec<Riser>,
    /// Where the risers of each tree node start, and where the last ones end. Node 1 is the root, `i` has the
    /// children `2 i` and `2 i + 1`, and the heights are the leaves.
    starts: Vec<u32>,
}

impl<'a> Rays<'a> {
    fn new(graph: &'a StreetGraph, rims: &Rims, holes: &[(Point, usize)]) -> Self {
        let mut heights: Vec<i32> = holes.iter().map(|(start, _)| start.y).collect();
        heights.sort_unstable();
        heights.dedup();
        let mut placed = Vec::new();
        for (key, _) in graph.segments_unsorted().filter(|(key, _)| rims.rim_of(key.forward()) != NONE) {
            if let Some(riser) = Riser::new(graph, key) {
                let spanned = |y: i32| heights.partition_point(|&height| height < y);
                for_tree_nodes(spanned(riser.low.y), spanned(riser.high.y), heights.len(), |node| {
                    placed.push((node as u32, riser));
                });
            }
        }
        placed.sort_unstable_by(|(i, a), (j, b)| i.cmp(j).then_with(|| a.left_to_right(b)));
        let mut starts = vec![0; 2 * heights.len() + 1];
        for (node, _) in &placed {
            starts[*node as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        Self { graph, heights, risers: placed.into_iter().map(|(_, riser)| riser).collect(), starts }
    }

    /// The half that bounds, from the left, the face just left of a point at one of the heights.
    fn first_met(&self, start: Point) -> Option<HalfKey> {
        let mut node =
            self.heights.binary_search(&start.y).expect("heights of all rays are known") + self.heights.len();
        let mut best: Option<&Riser> = None;
        while node > 0 {
            let here = &self.risers[self.starts[node] as usize..self.starts[node + 1] as usize];
            let left = here.partition_point(|riser| orient(riser.low, riser.high, start) < 0);
            if let Some(nearest) = here[..left].last()
                && best.is_none_or(|best| best.left_to_right(nearest).is_lt())
            {
                best = Some(nearest);
            }
            node /= 2;
        }
        best.map(|riser| riser.facing_east(self.graph))
    }
}

/// Calls `f` for the tree nodes that together cover the leaves `from..to` out of `leaves`.
fn for_tree_nodes(from: usize, to: usize, leaves: usize, mut f: impl FnMut(usize)) {
    let (mut from, mut to) = (from + leaves, to + leaves);
    while from < to {
        if from & 1 == 1 {
            f(from);
            from += 1;
        }
        if to & 1 == 1 {
            to -= 1;
            f(to);
        }
        from /= 2;
        to /= 2;
    }
}
