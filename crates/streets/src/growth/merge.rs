//! Putting what grew in quarters into the graph: sequential, in an order of its own, so that the result does not depend
//! on how the quarters were scheduled.
//!
//! Streets that come to the same stretch of rim from both sides, closer than they would snap, are led to one crossing:
//! to that of the street which got there first.

use super::near::Near;
use super::{Accepted, Attachment, Chain, Lineage, QuarterGrowth};
use crate::graph::{Crowding, NewSegment, Refusal};
use crate::{NodeId, StreetGraph, StreetId};
use geom::point::units;
use geom::{Bounds, Id, Point, tolerance};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

/// A street that found no room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dropped {
    /// The quarter it grew in.
    pub quarter: Id,
    /// Where it comes from.
    pub lineage: Lineage,
    /// Why it was dropped.
    pub refusal: Refusal,
}

/// What a merge did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MergeLog {
    /// Grown lines now in the graph.
    pub laid: usize,
    /// Those among them whose last piece was led to another crossing of the rim.
    pub moved: usize,
    /// Those left out.
    pub dropped: Vec<Dropped>,
}

/// Inserts grown quarters into the graph they were grown from, in the order of quarter ids. `constraints` are those of
/// the growth: its snapping distance and least angle hold across rims too.
pub fn attach(graph: &mut StreetGraph, growths: &[QuarterGrowth], constraints: &Chain) -> MergeLog {
    let mut order: Vec<_> = growths.iter().collect();
    order.sort_by_key(|growth| growth.quarter);
    let moves = Anchors::new(units(constraints.snap())).moves(graph, &order);
    // Where any angle will do, none is sharp.
    let cosine = constraints.least_angle().map_or(f64::INFINITY, |least| least.cos());
    let mut merge = Merge { graph, near: Near::default(), cosine, log: MergeLog::default() };
    for (growth, moves) in order.into_iter().zip(&moves) {
        merge.quarter(growth, moves);
    }
    merge.log
}

/// The crossing of a rim that a street is led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Anchor {
    at: Point,
    node: NodeId,
    /// Position of the quarter that made it, in order of ids.
    quarter: usize,
}

/// A stub and the crossing it is led to.
type Move<'a> = (&'a Attachment, Anchor);

/// The crossings that streets make with rims, found by street and place.
struct Anchors {
    snap: i32,
    cells: FxHashMap<(StreetId, i32, i32), SmallVec<[Anchor; 2]>>,
}

impl Anchors {
    fn new(snap: i32) -> Self {
        Self { snap: snap.max(tolerance::LAYING), cells: FxHashMap::default() }
    }

    /// For each quarter, the stubs that are led elsewhere: earlier ones (by growth time, then lineage) are anchors for
    /// later ones of other quarters.
    fn moves<'a>(mut self, graph: &StreetGraph, growths: &[&'a QuarterGrowth]) -> Vec<Vec<Move<'a>>> {
        let all = growths.iter().enumerate();
        let mut stubs: Vec<_> = all
            .flat_map(|(quarter, growth)| growth.attachments.iter().map(move |stub| (quarter, stub)))
            .map(|(quarter, stub)| (growths[quarter].log.accepted[stub.line].lineage, quarter, stub))
            .collect();
        stubs.sort_by_key(|(lineage, quarter, _)| (lineage.time, lineage.id, *quarter));
        let mut moves = vec![Vec::new(); growths.len()];
        for (_, quarter, stub) in stubs {
            let found = self.crossing_of_rim(graph, stub).or_else(|| self.nearest(stub, quarter));
            match found {
                Some(anchor) if anchor.at != stub.at => moves[quarter].push((stub, anchor)),
                Some(_) => {}
                None => self.add(stub, quarter),
            }
        }
        moves
    }

    /// A crossing of the rim with another rim, made from the other side: what grew here did not know of it.
    fn crossing_of_rim(&self, graph: &StreetGraph, stub: &Attachment) -> Option<Anchor> {
        let (key, _) = graph.nearest_node(stub.at, self.snap)?;
        let has_street = |claims: &[crate::Claim]| claims.iter().any(|claim| claim.street == stub.street);
        let on_street = graph.halves_ccw(key).iter().any(|arm| has_street(graph.segment(arm.segment()).claims()));
        on_street.then(|| Anchor { at: graph.at(key), node: graph.node(key).id, quarter: usize::MAX })
    }

    fn nearest(&self, stub: &Attachment, quarter: usize) -> Option<Anchor> {
        let (x, y) = self.cell(stub.at);
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (stub.street, x + dx, y + dy)));
        let anchors = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        let distance = |anchor: &Anchor| anchor.at.distance_squared(stub.at);
        let limit = i64::from(self.snap) * i64::from(self.snap);
        anchors
            .filter(|anchor| anchor.quarter != quarter && distance(anchor) < limit)
            .min_by_key(|anchor| (distance(anchor), anchor.node))
            .copied()
    }

    fn add(&mut self, stub: &Attachment, quarter: usize) {
        let (x, y) = self.cell(stub.at);
        let anchor = Anchor { at: stub.at, node: stub.node, quarter };
        self.cells.entry((stub.street, x, y)).or_default().push(anchor);
    }

    fn cell(&self, at: Point) -> (i32, i32) {
        (at.x.div_euclid(self.snap), at.y.div_euclid(self.snap))
    }
}

struct Merge<'a> {
    graph: &'a mut StreetGraph,
    near: Near,
    cosine: f64,
    log: MergeLog,
}

impl Merge<'_> {
    /// Lays all lines of a quarter in the order they grew; the last pieces of stubs that move come at the end, when all
    /// that they might run into is there.
    fn quarter(&mut self, growth: &QuarterGrowth, moves: &[Move]) {
        let mut moves: Vec<_> = moves.to_vec();
        moves.sort_by_key(|(stub, _)| stub.line);
        let mut next = moves.iter().peekable();
        for (line, accepted) in growth.log.accepted.iter().enumerate() {
            match next.next_if(|(stub, _)| stub.line == line) {
                Some((stub, _)) if stub.hinge == accepted.start() => {}
                Some((stub, _)) => {
                    let first_piece = piece(accepted, start_of(accepted), (stub.hinge, stub.hinge_node));
                    self.lay(growth, accepted, &first_piece);
                }
                None => {
                    if self.lay(growth, accepted, &accepted.line) {
                        self.log.laid += 1;
                    }
                }
            }
        }
        for (stub, anchor) in &moves {
            self.lay_stub(growth, stub, anchor);
        }
    }

    /// Lays the last piece of a stub to its anchor, or, where that would run into something, to its own end.
    fn lay_stub(&mut self, growth: &QuarterGrowth, stub: &Attachment, anchor: &Anchor) {
        let accepted = &growth.log.accepted[stub.line];
        let hinge = (stub.hinge, stub.hinge_node);
        if self.can_move(stub, anchor) {
            let moved = piece(accepted, hinge, (anchor.at, anchor.node));
            if self.graph.insert(&moved, Crowding::Refuse).is_ok() {
                self.log.laid += 1;
                self.log.moved += 1;
                return;
            }
        }
        let own = piece(accepted, hinge, (stub.at, stub.node));
        if self.lay(growth, accepted, &own) {
            self.log.laid += 1;
        }
    }

    fn can_move(&mut self, stub: &Attachment, anchor: &Anchor) -> bool {
        let laying = i64::from(tolerance::LAYING);
        let ahead = self.graph.first_crossing(stub.hinge, anchor.at, 0);
        if ahead.is_some_and(|met| met.at.distance_squared(anchor.at) > laying * laying) {
            return false;
        }
        self.near.gather(self.graph, Bounds::between(stub.hinge, anchor.at).grown(tolerance::LAYING));
        let is_sharp = |at, to| self.near.is_sharp(at, to, self.cosine);
        !is_sharp(stub.hinge, anchor.at) && !is_sharp(anchor.at, stub.hinge)
    }

    fn lay(&mut self, growth: &QuarterGrowth, accepted: &Accepted, line: &NewSegment) -> bool {
        let result = self.graph.insert(line, Crowding::Refuse);
        if let Err(refusal) = result {
            self.log.dropped.push(Dropped { quarter: growth.quarter, lineage: accepted.lineage, refusal });
        }
        result.is_ok()
    }
}

fn start_of(accepted: &Accepted) -> (Point, NodeId) {
    let line = &accepted.line;
    if accepted.is_reversed { (line.to, line.to_id) } else { (line.from, line.from_id) }
}

/// A piece of an accepted line, in the direction of its street.
fn piece(accepted: &Accepted, start: (Point, NodeId), end: (Point, NodeId)) -> NewSegment {
    let (from, to) = if accepted.is_reversed { (end, start) } else { (start, end) };
    NewSegment { from: from.0, to: to.0, from_id: from.1, to_id: to.1, ..accepted.line }
}
