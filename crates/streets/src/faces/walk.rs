//! Walking all rims of a subgraph of one level.

use crate::{HalfKey, Segment, StreetGraph};
use geom::Point;

/// No rim, no half, no face.
pub(crate) const NONE: u32 = u32::MAX;

/// All rims of a subgraph: the cycles of "next half round the face at the left".
pub(crate) struct Rims {
    /// The halves of all rims, one rim after another, each from its least node on.
    halves: Vec<HalfKey>,
    /// Where each rim starts in `halves`, and where the last one ends.
    starts: Vec<u32>,
    /// Twice the signed area of each rim in LSB².
    areas: Vec<i128>,
    /// The rim of each half by [`HalfKey::index`]; [`NONE`] for halves that take no part.
    rim_of: Vec<u32>,
}

impl Rims {
    /// The rims of the segments that `keep` admits. These must be of one level, and the arms of every node in order.
    pub fn walk(graph: &StreetGraph, keep: impl Fn(&Segment) -> bool) -> Self {
        let next = successors(graph, keep);
        let mut rims = Self {
            halves: Vec::with_capacity(next.len()),
            starts: vec![0],
            areas: Vec::new(),
            rim_of: vec![NONE; next.len()],
        };
        for first in 0..next.len() {
            if next[first] != NONE && rims.rim_of[first] == NONE {
                rims.add(graph, &next, first as u32);
            }
        }
        rims
    }

    fn add(&mut self, graph: &StreetGraph, next: &[u32], first: u32) {
        let rim = self.areas.len() as u32;
        let start = self.halves.len();
        let mut area = 0_i128;
        let mut half = first;
        loop {
            self.rim_of[half as usize] = rim;
            self.halves.push(HalfKey(half));
            let (a, b) = graph.line(HalfKey(half));
            area += i128::from(cross(a, b));
            half = next[half as usize];
            if half == first {
                break;
            }
        }
        rotate_to_least(graph, &mut self.halves[start..]);
        self.starts.push(self.halves.len() as u32);
        self.areas.push(area);
    }

    /// How many rims there are.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// The halves of a rim.
    pub fn halves(&self, rim: usize) -> &[HalfKey] {
        &self.halves[self.starts[rim] as usize..self.starts[rim + 1] as usize]
    }

    /// Twice the signed area of a rim: positive for the outer rim of a bounded face.
    pub fn area(&self, rim: usize) -> i128 {
        self.areas[rim]
    }

    /// The rim that a half lies on, or [`NONE`].
    pub fn rim_of(&self, half: HalfKey) -> u32 {
        self.rim_of[half.index()]
    }

    /// The rims of halves by [`HalfKey::index`].
    pub fn by_half(&self) -> &[u32] {
        &self.rim_of
    }
}

/// For each half that takes part the one that follows it: the clockwise predecessor of its twin among the arms.
fn successors(graph: &StreetGraph, keep: impl Fn(&Segment) -> bool) -> Vec<u32> {
    let mut kept = vec![false; graph.half_capacity() / 2];
    for (key, segment) in graph.segments_unsorted() {
        kept[key.0 as usize] = keep(segment);
    }
    let mut next = vec![NONE; graph.half_capacity()];
    for (_, node) in graph.nodes_unsorted() {
        let mut arms = node.arms.iter().filter(|arm| kept[arm.segment().0 as usize]);
        let Some(first) = arms.next() else { continue };
        let mut before = first;
        for arm in arms {
            next[arm.twin().index()] = before.0;
            before = arm;
        }
        next[first.twin().index()] = before.0;
    }
    next
}

/// Starts a rim with its half of least node ids: where a walk began depends on keys.
fn rotate_to_least(graph: &StreetGraph, rim: &mut [HalfKey]) {
    let id = |i: usize| graph.node(graph.origin(rim[i])).id;
    let mut least = (0, id(0));
    for i in 1..rim.len() {
        let here = id(i);
        if here < least.1 || here == least.1 && id((i + 1) % rim.len()) < id((least.0 + 1) % rim.len()) {
            least = (i, here);
        }
    }
    rim.rotate_left(least.0);
}

/// Twice the signed area of the triangle with the origin of the lattice.
fn cross(a: Point, b: Point) -> i64 {
    i64::from(a.x) * i64::from(b.y) - i64::from(a.y) * i64::from(b.x)
}

/// Twice the signed area of a cycle of halves in LSB².
pub(crate) fn doubled_area(graph: &StreetGraph, cycle: &[HalfKey]) -> i128 {
    cycle.iter().map(|&half| graph.line(half)).map(|(a, b)| i128::from(cross(a, b))).sum()
}
