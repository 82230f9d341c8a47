//! Putting what grew in quarters into the graph: sequential, in an order of its own, so that the result does not depend
//! on how the quarters were scheduled.
//!
//! Streets that come to the same stretch of rim from both sides, closer than they would snap, are led to one crossing:
//! to that of the street which got there first. What the chain promises holds there, too: a street that may not be led so
//! keeps its own end, and one that may not end there either stops at the last crossing before.

use super::keeping::{Keeper, LaidBy};
use super::slots;
use super::{Accepted, Attachment, Lineage, QuarterGrowth, Refused};
use crate::graph::NewSegment;
use crate::{NodeId, StreetGraph, StreetId};
use geom::point::units;
use geom::{Id, Point, tolerance};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

/// A street that found no room, or would have broken what its growth keeps to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dropped {
    /// The quarter it grew in.
    pub quarter: Id,
    /// Where it comes from.
    pub lineage: Lineage,
    /// Why it was dropped.
    pub reason: Refused,
    /// Whether all up to the last crossing before the rim was laid.
    pub is_shortened: bool,
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

/// Inserts grown quarters into the graph they were grown from, in the order of quarter ids. What each keeps to holds across rims, too: least angle, length, duplicates, legal area, slope, masks and rules'
/// own constraints for what is led elsewhere, and the most streets of a crossing for all that is laid. When `cancel`
/// answers true, what is still to be laid is left out: the graph is then not to be used.
pub fn attach(graph: &mut StreetGraph, growths: &[QuarterGrowth], cancel: &dyn Fn() -> bool) -> MergeLog {
    let mut order: Vec<_> = growths.iter().collect();
    order.sort_by_key(|growth| growth.quarter);
    let stubs: Vec<_> = order.iter().map(|growth| stubs_of(graph, growth)).collect();
    let moves = Anchors::of(&order).moves(graph, &order, &stubs);
    let widest = widest(graph, &order);
    let mut merge = Merge { graph, laid_by: LaidBy::default(), log: MergeLog::default() };
    for (ordinal, growth) in order.into_iter().enumerate() {
        if cancel() {
            break;
        }
        let mut keeper = Keeper::new(ordinal, &growth.keeps, widest);
        merge.quarter(growth, &stubs[ordinal], &moves[ordinal], &mut keeper);
    }
    merge.log
}

/// Where the streets of a quarter meet its rim, as the rim is in the graph.
fn stubs_of(graph: &StreetGraph, growth: &QuarterGrowth) -> Vec<Attachment> {
    growth.attachments.iter().map(|stub| Attachment { at: slots::slot_of(graph, stub), ..*stub }).collect()
}

/// Half of the widest right-of-way in a graph and among what is to be laid, in LSB.
fn widest(graph: &StreetGraph, growths: &[&QuarterGrowth]) -> i32 {
    let there = graph.segments_unsorted().map(|(_, segment)| segment.half_width());
    let grown = growths.iter().flat_map(|growth| &growth.log.accepted).map(|accepted| accepted.line.claim.half_width);
    there.chain(grown).max().unwrap_or(0)
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
    /// The farthest that any of them snaps.
    snap: i32,
    cells: FxHashMap<(StreetId, i32, i32), SmallVec<[Anchor; 2]>>,
}

impl Anchors {
    fn of(growths: &[&QuarterGrowth]) -> Self {
        let farthest =
            growths.iter().flat_map(|growth| growth.attachments.iter().map(|stub| snap_of(growth, stub))).max();
        Self { snap: farthest.unwrap_or(tolerance::LAYING), cells: FxHashMap::default() }
    }

    /// For each quarter, the stubs that are led elsewhere: earlier ones (by growth time, then lineage) are anchors for
    /// later ones of other quarters.
    fn moves<'a>(
        mut self,
        graph: &StreetGraph,
        growths: &[&QuarterGrowth],
        stubs: &'a [Vec<Attachment>],
    ) -> Vec<Vec<Move<'a>>> {
        let all = stubs.iter().enumerate();
        let mut stubs: Vec<_> = all
            .flat_map(|(quarter, stubs)| stubs.iter().map(move |stub| (quarter, stub)))
            .map(|(quarter, stub)| (growths[quarter].log.accepted[stub.line].lineage, quarter, stub))
            .collect();
        stubs.sort_by_key(|(lineage, quarter, _)| (lineage.time, lineage.id, *quarter));
        let mut moves = vec![Vec::new(); growths.len()];
        for (_, quarter, stub) in stubs {
            let snap = snap_of(growths[quarter], stub);
            let found = self.crossing_of_rim(graph, stub, snap).or_else(|| self.nearest(stub, quarter, snap));
            match found {
                Some(anchor) if anchor.at != stub.at => moves[quarter].push((stub, anchor)),
                Some(_) => {}
                None => self.add(stub, quarter),
            }
        }
        moves
    }

    /// A crossing of the rim with another rim, made from the other side: what grew here did not know of it.
    fn crossing_of_rim(&self, graph: &StreetGraph, stub: &Attachment, snap: i32) -> Option<Anchor> {
        let (key, _) = graph.nearest_node(stub.at, snap)?;
        let has_street = |claims: &[crate::Claim]| claims.iter().any(|claim| claim.street == stub.street);
        let on_street = graph.halves_ccw(key).iter().any(|arm| has_street(graph.segment(arm.segment()).claims()));
        on_street.then(|| Anchor { at: graph.at(key), node: graph.node(key).id, quarter: usize::MAX })
    }

    fn nearest(&self, stub: &Attachment, quarter: usize, snap: i32) -> Option<Anchor> {
        let (x, y) = self.cell(stub.at);
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (stub.street, x + dx, y + dy)));
        let anchors = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        let distance = |anchor: &Anchor| anchor.at.distance_squared(stub.at);
        let limit = i64::from(snap) * i64::from(snap);
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

/// How far a stub snaps at the rim, in LSB.
fn snap_of(growth: &QuarterGrowth, stub: &Attachment) -> i32 {
    let start = growth.log.accepted[stub.line].start();
    units(growth.keeps.constraints.snap_at(start.metres())).max(tolerance::LAYING)
}

struct Merge<'a> {
    graph: &'a mut StreetGraph,
    laid_by: LaidBy,
    log: MergeLog,
}

impl Merge<'_> {
    /// Lays all lines of a quarter in the order they grew; the last pieces of stubs that move come at the end, when all
    /// that they might run into is there.
    fn quarter(&mut self, growth: &QuarterGrowth, stubs: &[Attachment], moves: &[Move], keeper: &mut Keeper) {
        let mut moves: Vec<_> = moves.iter().collect();
        moves.sort_by_key(|(stub, _)| stub.line);
        let mut next = moves.into_iter().peekable();
        let mut stubs = stubs.iter().peekable();
        let mut to_end = Vec::new();
        for (line, accepted) in growth.log.accepted.iter().enumerate() {
            keeper.stand_at(accepted.start());
            let stub = stubs.next_if(|stub| stub.line == line);
            match next.next_if(|(stub, _)| stub.line == line) {
                Some(moving) if self.lay_first(growth, accepted, moving.0, keeper) => to_end.push(moving),
                Some(_) => {}
                None => self.lay_whole(growth, accepted, stub, keeper),
            }
        }
        for (stub, anchor) in to_end {
            self.lay_stub(growth, stub, anchor, keeper);
        }
    }

    /// Lays what lies before the last piece of a stub that moves.
    fn lay_first(
        &mut self,
        growth: &QuarterGrowth,
        accepted: &Accepted,
        stub: &Attachment,
        keeper: &mut Keeper,
    ) -> bool {
        if stub.hinge == accepted.start() {
            return true;
        }
        let first = piece(accepted, start_of(accepted), (stub.hinge, stub.hinge_node));
        let laid = keeper.lay(self.graph, &mut self.laid_by, &first);
        laid.map_err(|reason| self.drop(growth, accepted, reason, false)).is_ok()
    }

    /// Lays a line where it grew, or so much of it as the rim allows.
    fn lay_whole(
        &mut self,
        growth: &QuarterGrowth,
        accepted: &Accepted,
        stub: Option<&Attachment>,
        keeper: &mut Keeper,
    ) {
        let end = stub.map_or(end_of(accepted), |stub| (stub.at, stub.node));
        let whole = piece(accepted, start_of(accepted), end);
        let Err(reason) = keeper.lay(self.graph, &mut self.laid_by, &whole) else {
            self.log.laid += 1;
            return;
        };
        let stub = stub.filter(|stub| stub.hinge != accepted.start());
        let shorter = stub.map(|stub| piece(accepted, start_of(accepted), (stub.hinge, stub.hinge_node)));
        let is_shortened = shorter.is_some_and(|line| keeper.lay(self.graph, &mut self.laid_by, &line).is_ok());
        self.log.laid += usize::from(is_shortened);
        self.drop(growth, accepted, reason, is_shortened);
    }

    /// Lays the last piece of a stub to its anchor, or, where that would run into something or break what its growth
    /// keeps to, to its own end.
    fn lay_stub(&mut self, growth: &QuarterGrowth, stub: &Attachment, anchor: &Anchor, keeper: &mut Keeper) {
        let accepted = &growth.log.accepted[stub.line];
        keeper.stand_at(accepted.start());
        let hinge = (stub.hinge, stub.hinge_node);
        let moved = piece(accepted, hinge, (anchor.at, anchor.node));
        let may_lead = keeper.may_lead(self.graph, accepted, stub, anchor.at).is_ok();
        if may_lead && keeper.lay(self.graph, &mut self.laid_by, &moved).is_ok() {
            self.log.laid += 1;
            self.log.moved += 1;
            return;
        }
        let own = piece(accepted, hinge, (stub.at, stub.node));
        match keeper.lay(self.graph, &mut self.laid_by, &own) {
            Ok(()) => self.log.laid += 1,
            Err(reason) => {
                let is_shortened = stub.hinge != accepted.start();
                self.log.laid += usize::from(is_shortened);
                self.drop(growth, accepted, reason, is_shortened);
            }
        }
    }

    fn drop(&mut self, growth: &QuarterGrowth, accepted: &Accepted, reason: Refused, is_shortened: bool) {
        let (quarter, lineage) = (growth.quarter, accepted.lineage);
        self.log.dropped.push(Dropped { quarter, lineage, reason, is_shortened });
    }
}

fn start_of(accepted: &Accepted) -> (Point, NodeId) {
    let line = &accepted.line;
    if accepted.is_reversed { (line.to, line.to_id) } else { (line.from, line.from_id) }
}

fn end_of(accepted: &Accepted) -> (Point, NodeId) {
    let line = &accepted.line;
    if accepted.is_reversed { (line.from, line.from_id) } else { (line.to, line.to_id) }
}

/// A piece of an accepted line, in the direction of its street.
fn piece(accepted: &Accepted, start: (Point, NodeId), end: (Point, NodeId)) -> NewSegment {
    let (from, to) = if accepted.is_reversed { (end, start) } else { (start, end) };
    NewSegment { from: from.0, to: to.0, from_id: from.1, to_id: to.1, ..accepted.line }
}
