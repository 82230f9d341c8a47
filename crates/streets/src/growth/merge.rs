//! Putting what grew in quarters into the graph: sequential, in an order of its own, so that the result does not depend
//! on how the quarters were scheduled.
//!
//! Nor does one quarter's result depend on another's: a change in one leaves all streets of the others as they were (V16,
//! with nothing but the quarter itself around the change). Streets of both sides share a crossing where both came to
//! the same slot of the rim ([`slots`](super::slots)), and the most streets that a crossing may have are dealt out
//! between the sides beforehand. Only rules that let streets cross or bridge the rim reach farther.
//!
//! What the chain promises holds there, too: a street that may not be led to a crossing of rims keeps its own end, and
//! one that may not end there either stops at the last crossing before.

use super::keeping::{Keeper, Laid};
use super::near::Near;
use super::slots;
use super::{Accepted, Attachment, Lineage, QuarterGrowth, Refused};
use crate::graph::NewSegment;
use crate::{NodeId, StreetGraph};
use geom::point::units;
use geom::{Id, Point};

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
    /// Those among them whose last piece was led to a crossing of rims.
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
    let widest = widest(graph, &order);
    let mut keepers: Vec<_> =
        order.iter().enumerate().map(|(ordinal, growth)| Keeper::new(ordinal, &growth.keeps, widest)).collect();
    let with_keepers = order.iter().zip(&stubs).zip(&mut keepers);
    let moves: Vec<_> = with_keepers.map(|((growth, stubs), keeper)| moves_of(graph, growth, stubs, keeper)).collect();
    let laid = Laid::before(graph);
    let mut merge = Merge { graph, laid, log: MergeLog::default() };
    for (ordinal, growth) in order.into_iter().enumerate() {
        if cancel() {
            break;
        }
        merge.quarter(growth, &stubs[ordinal], &moves[ordinal], &mut keepers[ordinal]);
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
}

/// A stub and the crossing it is led to.
struct Move<'a> {
    stub: &'a Attachment,
    anchor: Anchor,
    /// What lay around before anything was attached.
    near: Near,
}

/// The stubs of a quarter that are led elsewhere.
fn moves_of<'a>(
    graph: &StreetGraph,
    growth: &QuarterGrowth,
    stubs: &'a [Attachment],
    keeper: &mut Keeper,
) -> Vec<Move<'a>> {
    let found = stubs.iter().map(|stub| (stub, crossing_of_rim(graph, stub, snap_of(growth, stub))));
    let moves = found.filter_map(|(stub, anchor)| Some((stub, anchor.filter(|anchor| anchor.at != stub.at)?)));
    moves
        .map(|(stub, anchor)| {
            keeper.stand_at(growth.log.accepted[stub.line].start());
            Move { stub, anchor, near: keeper.look_around(graph, stub, anchor.at) }
        })
        .collect()
}

/// A crossing of the rim with another rim, made from the other side: what grew here did not know of it.
fn crossing_of_rim(graph: &StreetGraph, stub: &Attachment, snap: i32) -> Option<Anchor> {
    let (key, _) = graph.nearest_node(stub.at, snap)?;
    let has_street = |claims: &[crate::Claim]| claims.iter().any(|claim| claim.street == stub.street);
    let on_street = graph.halves_ccw(key).iter().any(|arm| has_street(graph.segment(arm.segment()).claims()));
    on_street.then(|| Anchor { at: graph.at(key), node: graph.node(key).id })
}

/// How far a stub snaps at the rim, in LSB; as far as slots keep from crossings of the rim at least.
fn snap_of(growth: &QuarterGrowth, stub: &Attachment) -> i32 {
    let start = growth.log.accepted[stub.line].start();
    units(growth.keeps.constraints.snap_at(start.metres())).max(slots::SPACING)
}

struct Merge<'a> {
    graph: &'a mut StreetGraph,
    laid: Laid,
    log: MergeLog,
}

impl Merge<'_> {
    /// Lays all lines of a quarter in the order they grew; the last pieces of stubs that move come at the end, when all
    /// that they might run into is there.
    fn quarter(&mut self, growth: &QuarterGrowth, stubs: &[Attachment], moves: &[Move], keeper: &mut Keeper) {
        let mut moves: Vec<_> = moves.iter().collect();
        moves.sort_by_key(|moving| moving.stub.line);
        let mut next = moves.into_iter().peekable();
        let mut stubs = stubs.iter().peekable();
        let mut to_end = Vec::new();
        for (line, accepted) in growth.log.accepted.iter().enumerate() {
            keeper.stand_at(accepted.start());
            let stub = stubs.next_if(|stub| stub.line == line);
            match next.next_if(|moving| moving.stub.line == line) {
                Some(moving) if self.lay_first(growth, accepted, moving.stub, keeper) => to_end.push(moving),
                Some(_) => {}
                None => self.lay_whole(growth, accepted, stub, keeper),
            }
        }
        for moving in to_end {
            self.lay_stub(growth, moving, keeper);
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
        let laid = keeper.lay(self.graph, &mut self.laid, &first);
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
        let Err(reason) = keeper.lay(self.graph, &mut self.laid, &whole) else {
            self.log.laid += 1;
            return;
        };
        let stub = stub.filter(|stub| stub.hinge != accepted.start());
        let shorter = stub.map(|stub| piece(accepted, start_of(accepted), (stub.hinge, stub.hinge_node)));
        let is_shortened = shorter.is_some_and(|line| keeper.lay(self.graph, &mut self.laid, &line).is_ok());
        self.log.laid += usize::from(is_shortened);
        self.drop(growth, accepted, reason, is_shortened);
    }

    /// Lays the last piece of a stub to its anchor, or, where that would run into something or break what its growth
    /// keeps to, to its own end.
    fn lay_stub(&mut self, growth: &QuarterGrowth, moving: &Move, keeper: &mut Keeper) {
        let Move { stub, anchor, near } = moving;
        let accepted = &growth.log.accepted[stub.line];
        keeper.stand_at(accepted.start());
        let hinge = (stub.hinge, stub.hinge_node);
        let moved = piece(accepted, hinge, (anchor.at, anchor.node));
        let may_lead = keeper.may_lead(self.graph, &self.laid, near, accepted, stub, anchor.at).is_ok();
        if may_lead && keeper.lay(self.graph, &mut self.laid, &moved).is_ok() {
            self.log.laid += 1;
            self.log.moved += 1;
            return;
        }
        let own = piece(accepted, hinge, (stub.at, stub.node));
        match keeper.lay(self.graph, &mut self.laid, &own) {
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
