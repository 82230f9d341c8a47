//! Smoothing of curved streets by corner cutting (PM01 §3.3.1): growth lays straight segments only.

use super::ground::Ground;
use super::near::are_apart;
use super::{Chain, Fields, Growth};
use crate::graph::{Claim, Crowding, NewSegment};
use crate::runs::{Run, runs};
use crate::{NodeId, NodeKey, StreetGraph};
use geom::{Angle, Bounds, Point, Vec2, predicates, tolerance};

/// How streets are smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// Rounds of corner cutting; each replaces a bend by two of half the angle.
    pub rounds: u32,
    /// Bends by less than this stay.
    pub least_turn: Angle,
    /// Bends by more than this are corners, not curves, and stay.
    pub most_turn: Angle,
}

impl Default for Smoothing {
    /// Two rounds for bends from 3° to 60°.
    fn default() -> Self {
        Self { rounds: 2, least_turn: Angle::degrees(3.0), most_turn: Angle::degrees(60.0) }
    }
}

/// What a smoothing did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smoothed {
    /// Streets between crossings whose line was replaced.
    pub runs: usize,
    /// Those with bends that stay: there was no room, or their curve left the ground where streets may lie.
    pub kept: usize,
}

/// Smooths the streets of a class between their crossings that `admit` admits, in the order of their ids. Crossings and ends stay where
/// they are; a curve stays inside the corners that it cuts. A run stays as it is where the ground that the growth keeps to
/// (legal area, masks, slope) does not carry its curve, or the curve would come to lie on anything.
pub fn smooth(
    graph: &mut StreetGraph,
    growth: &Growth,
    fields: &Fields,
    smoothing: &Smoothing,
    admit: &dyn Fn(&StreetGraph, &Run) -> bool,
) -> Smoothed {
    let mut result = Smoothed::default();
    let mut ground = Ground::new(fields, &growth.constraints);
    for run in runs(graph).into_iter().filter(|run| run.class == growth.class && run.level == 0) {
        if !admit(graph, &run) {
            continue;
        }
        let Some(curve) = Curve::through(graph, &run.nodes, smoothing) else { continue };
        if curve.has_room(graph) && curve.is_fit(&growth.constraints, &mut ground) && curve.lay(graph) {
            result.runs += 1;
        } else {
            result.kept += 1;
        }
    }
    result
}

/// A run and the curve that is to replace it.
struct Curve {
    nodes: Vec<NodeKey>,
    claim: Claim,
    points: Vec<(Point, NodeId)>,
}

impl Curve {
    /// The curve of a run with a bend to smooth that a single street uses alone.
    fn through(graph: &StreetGraph, nodes: &[NodeKey], smoothing: &Smoothing) -> Option<Self> {
        if nodes.len() < 3 || nodes.first() == nodes.last() {
            return None;
        }
        let claim = sole_claim(graph, nodes)?;
        let corners: Vec<Vec2> = nodes.iter().map(|&node| graph.at(node).metres()).collect();
        let (low, high) = (smoothing.least_turn.to_radians(), smoothing.most_turn.to_radians());
        let bends = corners.windows(3).any(|w| (low..=high).contains(&turn(w[0], w[1], w[2])));
        if !bends {
            return None;
        }
        let mut line = corners;
        for _ in 0..smoothing.rounds {
            line = cut_corners(&line, low, high);
        }
        let ends = [nodes[0], nodes[nodes.len() - 1]].map(|end| graph.node(end).id);
        let last = line.len() - 1;
        let lineage = claim.street.0.with(&[ends[0].0.0, ends[1].0.0]);
        let id = |i: usize| match i {
            0 => ends[0],
            i if i == last => ends[1],
            i => NodeId(lineage.child(i as u64)),
        };
        let points = line.iter().enumerate().map(|(i, &p)| (Point::from_metres(p), id(i))).collect();
        Some(Self { nodes: nodes.to_vec(), claim, points })
    }

    fn pieces(&self) -> impl Iterator<Item = [(Point, NodeId); 2]> {
        self.points.windows(2).map(|pair| [pair[0], pair[1]])
    }

    fn is_fit(&self, chain: &Chain, ground: &mut Ground) -> bool {
        self.pieces().all(|[(a, _), (b, _)]| {
            chain.at(a.metres()).iter().for_each(|chain| ground.adopt(chain));
            ground.is_fit(a.metres(), b.metres())
        })
    }

    /// Whether the curve meets nothing but the run itself and what ends at its own ends.
    fn has_room(&self, graph: &StreetGraph) -> bool {
        let own = |key| {
            let ends: [NodeKey; 2] = graph.segment(key).ends;
            ends.iter().all(|end| self.nodes.contains(end)) && is_along(&self.nodes, ends)
        };
        let first = graph.at(self.nodes[0]);
        let last = graph.at(self.nodes[self.nodes.len() - 1]);
        self.pieces().all(|[(a, _), (b, _)]| {
            let around = Bounds::between(a, b).grown(tolerance::LAYING);
            a.distance_squared(b) > i64::from(tolerance::LAYING).pow(2)
                && graph.segments_near(around).into_iter().all(|key| {
                    let (c, d) = graph.line(key.forward());
                    let shares_end = [a, b].iter().any(|p| (*p == first || *p == last) && (*p == c || *p == d));
                    own(key) || if shares_end { !overlaps(a, b, c, d) } else { are_apart((a, b), (c, d)) }
                })
        })
    }

    /// Replaces the run by its curve, or changes nothing should a piece find no room after all.
    fn lay(&self, graph: &mut StreetGraph) -> bool {
        let Some(around) = self.reach(graph) else { return false };
        let before = crossings_in(graph, around);
        let replaced = |graph: &mut StreetGraph| {
            self.replace(graph)?;
            // Streets that nearly lie on the run or the curve may have been led elsewhere by either.
            (crossings_in(graph, around) == before).then_some(())
        };
        graph.attempt(replaced).is_some()
    }

    /// The box of the curve and of all that meets the run.
    fn reach(&self, graph: &StreetGraph) -> Option<Bounds> {
        let arms = self.nodes.iter().flat_map(|&node| graph.halves_ccw(node));
        let ends = arms.flat_map(|&arm| <[Point; 2]>::from(graph.line(arm)));
        Bounds::of(ends.chain(self.points.iter().map(|point| point.0)))
    }

    fn replace(&self, graph: &mut StreetGraph) -> Option<()> {
        let segments: Vec<_> =
            self.nodes.windows(2).filter_map(|pair| graph.segment_between(pair[0], pair[1], 0)).collect();
        graph.remove_pieces(self.claim.street, &segments);
        for [(from, from_id), (to, to_id)] in self.pieces() {
            let new = NewSegment { from, to, from_id, to_id, claim: self.claim, level: 0 };
            let insertion = graph.insert(&new, Crowding::Refuse).ok()?;
            // Whatever else the piece met, it is not the curve.
            let [start, end] = insertion.path[..] else { return None };
            (graph.at(start) == from && graph.at(end) == to).then_some(())?;
        }
        Some(())
    }
}

/// The crossings and dead ends in a box, with how many streets meet there, by id.
fn crossings_in(graph: &StreetGraph, bounds: Bounds) -> Vec<(NodeId, Point, usize)> {
    let mut nodes = Vec::new();
    graph.for_segments_near(bounds, |key| nodes.extend(graph.segment(key).ends));
    nodes.sort_unstable();
    nodes.dedup();
    let crossings = nodes.into_iter().filter(|&node| graph.degree(node) != 2 && bounds.contains(graph.at(node)));
    let mut crossings: Vec<_> =
        crossings.map(|node| (graph.node(node).id, graph.at(node), graph.degree(node))).collect();
    crossings.sort_unstable();
    crossings
}

/// The claim on all segments of a run, directed along it, where no other street runs there.
fn sole_claim(graph: &StreetGraph, nodes: &[NodeKey]) -> Option<Claim> {
    let mut sole: Option<Claim> = None;
    for pair in nodes.windows(2) {
        let segment = graph.segment(graph.segment_between(pair[0], pair[1], 0)?);
        let [claim] = segment.claims() else { return None };
        let claim = Claim { forward: claim.forward == (segment.ends[0] == pair[0]), ..*claim };
        if *sole.get_or_insert(claim) != claim {
            return None;
        }
    }
    sole
}

fn is_along(nodes: &[NodeKey], ends: [NodeKey; 2]) -> bool {
    nodes
        .windows(2)
        .any(|pair| (pair[0] == ends[0] && pair[1] == ends[1]) || (pair[0] == ends[1] && pair[1] == ends[0]))
}

/// Whether two lines with a common end come back together beyond it.
fn overlaps(a: Point, b: Point, c: Point, d: Point) -> bool {
    let far = |p: Point, x: Point, y: Point| p != x && p != y && predicates::within(x, y, p, tolerance::LAYING);
    far(a, c, d) || far(b, c, d) || far(c, a, b) || far(d, a, b)
}

/// Absolute turn at `b`, in radians.
fn turn(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (Angle::of(c - b) - Angle::of(b - a)).wrapped().to_radians().abs()
}

/// Chaikin's corner cutting: a bend becomes two at the quarters of its arms, or where the arms are long, so far from
/// it that the curve keeps near the bend.
fn cut_corners(line: &[Vec2], low: f64, high: f64) -> Vec<Vec2> {
    let mut cut = vec![line[0]];
    for w in line.windows(3) {
        if (low..=high).contains(&turn(w[0], w[1], w[2])) {
            cut.push(w[1].lerp(w[0], 0.25));
            cut.push(w[1].lerp(w[2], 0.25));
        } else {
            cut.push(w[1]);
        }
    }
    cut.push(line[line.len() - 1]);
    cut
}
