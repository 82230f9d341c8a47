//! Insertion as a transaction (algorithms: planar street graph under insertion).
//!
//! A new line is *laid* between its end nodes: what it crosses is split, nodes closer than the separation become
//! via-points (hot-pixel routing with a pixel of that size), what coincides with an existing segment is covered by it
//! and adds a claim. A split moves the halves by less than one LSB, so these are laid again with the same test; at the
//! end every node made is held against all segments around. Each thing is examined when it is last changed, so the
//! result satisfies V1 and V2 whenever the operation does not refuse.

use super::{Claim, NodeKey, SegmentKey, StreetGraph};
use crate::{NodeId, StreetId};
use geom::{Bounds, Point, predicates, tolerance};
use smallvec::SmallVec;

/// Steps an insertion may take before it is refused as [`Refusal::Unsettled`]; a line that crosses `n` streets takes
/// about `4 n`.
const STEP_LIMIT: u32 = 20_000;

/// A place this close (LSB) to a segment counts as on it, and the segment is split just there: the rounding of the
/// place, plus that of the segment's own ends.
const ON_LINE: i32 = 2;

/// A straight piece of street to insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NewSegment {
    /// Start.
    pub from: Point,
    /// End.
    pub to: Point,
    /// Identity of the start node, should one be made there.
    pub from_id: NodeId,
    /// Identity of the end node, should one be made there.
    pub to_id: NodeId,
    /// The street that runs here; `forward` is ignored, it runs from start to end.
    pub claim: Claim,
    /// 0 on the ground.
    pub level: i8,
}

/// What to do where a new street would push an existing one onto an existing node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crowding {
    /// Refuse. Removing what was inserted then restores the graph exactly.
    Refuse,
    /// Join the two, moving the street by less than the separation: for imports, which must not lose streets.
    Join,
}

/// What an insertion made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Insertion {
    /// Nodes along the line, from start to end.
    pub path: SmallVec<[NodeKey; 4]>,
    /// How many new segments were laid; 0 when the whole line was covered by existing ones.
    pub laid: usize,
}

/// Why nothing was inserted. The graph is as before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Both ends come to lie on one node.
    #[error("too short: both ends come to lie on one crossing")]
    TooShort,
    /// An existing street would have to move onto a node that it does not belong to.
    #[error("too crowded: an existing street would have to move")]
    Crowded,
    /// No stable arrangement was found within the step limit.
    #[error("no stable arrangement found")]
    Unsettled,
    /// An end lies outside the lattice.
    #[error("an end lies outside the lattice (±524 km)")]
    OffLattice,
}

type Claims = SmallVec<[Claim; 1]>;

/// Where a line being laid must pass.
enum Via {
    Node(NodeKey),
    Split(SegmentKey, Point),
}

/// The state of one insertion.
struct Work {
    crowding: Crowding,
    street: StreetId,
    /// Whether that street closes quarters.
    closes: bool,
    steps: u32,
    /// Nodes made by this insertion: what lies too close is led through them.
    made: Vec<NodeKey>,
    /// Nodes to hold against the segments around: those made, and those that gained a level.
    unsettled: Vec<NodeKey>,
    laid: usize,
}

impl Work {
    fn spend(&mut self) -> Result<(), Refusal> {
        self.steps += 1;
        if self.steps > STEP_LIMIT { Err(Refusal::Unsettled) } else { Ok(()) }
    }

    fn may_join(&self, node: NodeKey) -> Result<(), Refusal> {
        if self.crowding == Crowding::Join || self.made.contains(&node) { Ok(()) } else { Err(Refusal::Crowded) }
    }
}

impl StreetGraph {
    /// Inserts a line so that the graph stays planar and separated, or refuses and changes nothing.
    pub fn insert(&mut self, new: &NewSegment, crowding: Crowding) -> Result<Insertion, Refusal> {
        let savepoint = self.log.len();
        let result = self.try_insert(new, crowding);
        match result {
            Ok(_) => self.commit(),
            Err(_) => self.rollback(savepoint),
        }
        result
    }

    fn try_insert(&mut self, new: &NewSegment, crowding: Crowding) -> Result<Insertion, Refusal> {
        let on_lattice = |p: Point| p.x.abs() <= Point::LIMIT && p.y.abs() <= Point::LIMIT;
        if !on_lattice(new.from) || !on_lattice(new.to) {
            return Err(Refusal::OffLattice);
        }
        if new.from.distance_squared(new.to) < square(tolerance::LAYING) {
            return Err(Refusal::TooShort);
        }
        let street = new.claim.street;
        let closes = self.classes().info(new.claim.class).closes_quarters;
        let mut work = Work { crowding, street, closes, steps: 0, made: Vec::new(), unsettled: Vec::new(), laid: 0 };
        let from = self.place_end(new.from, new.from_id, new.level, &mut work)?;
        let to = self.place_end(new.to, new.to_id, new.level, &mut work)?;
        if from == to {
            return Err(Refusal::TooShort);
        }
        let claims: Claims = SmallVec::from_elem(Claim { forward: true, ..new.claim }, 1);
        let mut path = SmallVec::from_elem(from, 1);
        self.lay(from, to, new.level, &claims, tolerance::LAYING, &mut work, Some(&mut path))?;
        self.settle(&mut work)?;
        self.pin(from, street);
        self.pin(to, street);
        Ok(Insertion { path, laid: work.laid })
    }

    /// The node where an end of a new line comes to lie: a node or a segment within the laying distance, else a new one.
    fn place_end(&mut self, p: Point, id: NodeId, level: i8, work: &mut Work) -> Result<NodeKey, Refusal> {
        if let Some((node, _)) = self.nearest_node(p, tolerance::LAYING) {
            return Ok(node);
        }
        let admit = |key: SegmentKey| matches!(self.segment(key).level, 0) || self.segment(key).level == level;
        if let Some((segment, foot, _)) = self.nearest_segment_where(p, tolerance::LAYING, admit) {
            let (a, b) = self.line(segment.forward());
            let at = if predicates::within(a, b, p, ON_LINE) { p } else { foot };
            return self.split(segment, at, work);
        }
        Ok(self.make_node(id, p, work))
    }

    fn make_node(&mut self, id: NodeId, at: Point, work: &mut Work) -> NodeKey {
        let node = self.add_node(id, at, work.street);
        work.made.push(node);
        work.unsettled.push(node);
        node
    }

    /// Lays claims between two nodes, through whatever lies closer than `radius`. The nodes passed are added to `path`.
    #[allow(clippy::too_many_arguments)]
    fn lay(
        &mut self,
        from: NodeKey,
        to: NodeKey,
        level: i8,
        claims: &Claims,
        radius: i32,
        work: &mut Work,
        mut path: Option<&mut SmallVec<[NodeKey; 4]>>,
    ) -> Result<(), Refusal> {
        let is_new_line = path.is_some();
        let mut pieces: SmallVec<[(NodeKey, NodeKey); 8]> = SmallVec::from_elem((from, to), 1);
        while let Some((u, v)) = pieces.pop() {
            work.spend()?;
            if u == v {
                continue;
            }
            let vias = self.vias(u, v, level, radius);
            if vias.is_empty() {
                if !is_new_line && work.crowding == Crowding::Refuse && self.would_fold(u, v, level, claims) {
                    return Err(Refusal::Crowded);
                }
                work.laid += usize::from(self.add_or_cover(u, v, level, claims, work) && is_new_line);
                if let Some(path) = &mut path {
                    path.push(v);
                }
                continue;
            }
            // Without a stop the obstacle itself was moved out of the way; then this piece is examined again.
            let stops = self.resolve(vias, (u, v), is_new_line, work)?;
            push_pieces(&mut pieces, u, v, &stops);
        }
        Ok(())
    }

    /// Makes nodes of all vias, in their order along the line from `u` to `v`.
    fn resolve(
        &mut self,
        vias: SmallVec<[Via; 4]>,
        (u, v): (NodeKey, NodeKey),
        is_new_line: bool,
        work: &mut Work,
    ) -> Result<SmallVec<[NodeKey; 4]>, Refusal> {
        let mut stops: SmallVec<[NodeKey; 4]> = SmallVec::new();
        for via in vias {
            let node = match via {
                Via::Node(node) => {
                    if !is_new_line {
                        work.may_join(node)?;
                    }
                    node
                }
                Via::Split(segment, at) if self.runs_at(segment, at) => self.split(segment, at, work)?,
                // Replaced by an earlier split of this pass: the pieces are examined again, and find what runs there.
                Via::Split(..) => continue,
            };
            if node != u && node != v && !stops.contains(&node) {
                stops.push(node);
            }
        }
        let (a, b) = (self.at(u), self.at(v));
        stops.sort_by_key(|&stop| (predicates::dot(a, b, self.at(stop)), self.node(stop).id));
        Ok(stops)
    }

    /// What the line from `u` to `v` must pass: foreign nodes closer than `radius`, and segments of its level that it
    /// crosses where neither of their ends is such a node.
    fn vias(&self, u: NodeKey, v: NodeKey, level: i8, radius: i32) -> SmallVec<[Via; 4]> {
        let (a, b) = (self.at(u), self.at(v));
        let mut vias = SmallVec::new();
        let mut seen: SmallVec<[NodeKey; 8]> = SmallVec::new();
        let mut crossed: SmallVec<[SegmentKey; 8]> = SmallVec::new();
        let bounds = Bounds::between(a, b).grown(radius);
        for key in self.index.near(bounds) {
            let segment = self.segment(key);
            let ends = segment.ends;
            let mut passes_end = false;
            for end in ends {
                let at = self.at(end);
                if end == u || end == v {
                    passes_end = true;
                } else if bounds.contains(at)
                    && predicates::within(a, b, at, radius)
                    && (level == 0 || self.has_level(end, level))
                {
                    passes_end = true;
                    if !seen.contains(&end) {
                        seen.push(end);
                        vias.push(Via::Node(end));
                    }
                }
            }
            if !passes_end && segment.level == level {
                let [c, d] = ends.map(|end| self.at(end));
                if predicates::crosses_properly(a, b, c, d) {
                    crossed.push(key);
                }
            }
        }
        for key in crossed {
            let (c, d) = self.line(key.forward());
            if let Some(at) = predicates::cut(a, b, c, d) {
                vias.push(Via::Split(key, at));
            }
        }
        vias
    }

    /// Whether a segment between two nodes would meet nothing and keep `radius` from every foreign node.
    pub(crate) fn is_clear(&self, u: NodeKey, v: NodeKey, level: i8, radius: i32) -> bool {
        self.vias(u, v, level, radius).is_empty()
    }

    fn runs_at(&self, segment: SegmentKey, at: Point) -> bool {
        self.segments[segment.0 as usize].is_some() && {
            let (a, b) = self.line(segment.forward());
            predicates::within(a, b, at, ON_LINE)
        }
    }

    /// Splits a segment at a place on it and returns the node there: one of its ends, a node closer than the
    /// separation (the segment is then led through it), or a new crossing.
    fn split(&mut self, segment: SegmentKey, at: Point, work: &mut Work) -> Result<NodeKey, Refusal> {
        work.spend()?;
        let [start, end] = self.segment(segment).ends;
        let node = match self.nearest_node(at, tolerance::SEPARATION) {
            Some((near, _)) if near == start || near == end => return Ok(near),
            Some((near, _)) => {
                work.may_join(near)?;
                near
            }
            None => {
                let id = self.crossing_id(segment, at, work);
                self.make_node(id, at, work)
            }
        };
        self.lead_through(segment, node, work)?;
        Ok(node)
    }

    /// Replaces a segment by two that meet in a node.
    fn lead_through(&mut self, segment: SegmentKey, node: NodeKey, work: &mut Work) -> Result<(), Refusal> {
        let old = self.kill_segment(segment);
        let [start, end] = old.ends;
        self.lay(start, node, old.level, &old.claims, tolerance::SEPARATION, work, None)?;
        self.lay(node, end, old.level, &old.claims, tolerance::SEPARATION, work, None)
    }

    /// The identity of a new crossing on a segment: of its place on a rim, where one of the two streets closes quarters
    /// and the other does not, else of the two streets.
    fn crossing_id(&self, segment: SegmentKey, at: Point, work: &Work) -> NodeId {
        let leading = self.segment(segment).leading();
        let id = |ordinal| match (self.classes().info(leading.class).closes_quarters, work.closes) {
            (true, false) => NodeId::on_rim(leading.street, at, ordinal),
            (false, true) => NodeId::on_rim(work.street, at, ordinal),
            _ => NodeId::crossing(leading.street, work.street, ordinal),
        };
        let mut ordinal = 0;
        while self.node_ids.contains_key(&id(ordinal)) {
            ordinal += 1;
        }
        id(ordinal)
    }

    /// Whether an existing street would come to lie on itself: its two passages would become one.
    fn would_fold(&self, u: NodeKey, v: NodeKey, level: i8, claims: &Claims) -> bool {
        self.segment_between(u, v, level).is_some_and(|key| {
            let there = &self.segment(key).claims;
            claims.iter().any(|claim| there.iter().any(|other| other.street == claim.street))
        })
    }

    /// Adds a segment, or its claims to the one that is there. Whether it is new.
    fn add_or_cover(&mut self, u: NodeKey, v: NodeKey, level: i8, claims: &Claims, work: &mut Work) -> bool {
        if let Some(key) = self.segment_between(u, v, level) {
            self.cover(key, u, claims);
            return false;
        }
        for end in [u, v] {
            if level != 0 && !self.has_level(end, level) {
                work.unsettled.push(end);
            }
        }
        self.add_segment([u, v], level, claims.clone());
        true
    }

    /// Adds claims that run from `start` to an existing segment; a street that is there already keeps its claim, made
    /// wider where the new one is.
    pub(crate) fn cover(&mut self, key: SegmentKey, start: NodeKey, claims: &[Claim]) {
        let segment = self.segment(key);
        let is_reversed = segment.ends[0] != start;
        let mut merged = segment.claims.clone();
        for claim in claims {
            let claim = Claim { forward: claim.forward != is_reversed, ..*claim };
            match merged.iter_mut().find(|old| old.street == claim.street) {
                None => merged.push(claim),
                Some(old) => {
                    old.class = old.class.min(claim.class);
                    old.half_width = old.half_width.max(claim.half_width);
                }
            }
        }
        if merged != segment.claims {
            self.set_claims(key, merged);
        }
    }

    /// Holds every node made against the segments around it, leading through it what comes too close.
    fn settle(&mut self, work: &mut Work) -> Result<(), Refusal> {
        while let Some(&node) = work.unsettled.last() {
            work.spend()?;
            match self.segment_too_close(node) {
                Some(segment) => {
                    work.may_join(node)?;
                    self.lead_through(segment, node, work)?;
                }
                None => {
                    work.unsettled.retain(|other| *other != node);
                }
            }
        }
        Ok(())
    }

    fn segment_too_close(&self, node: NodeKey) -> Option<SegmentKey> {
        let at = self.at(node);
        self.nearest_segment_where(at, tolerance::SEPARATION, |key| {
            let segment = self.segment(key);
            !segment.ends.contains(&node) && (segment.level == 0 || self.has_level(node, segment.level))
        })
        .map(|(key, ..)| key)
    }
}

/// Pushes the pieces between consecutive stops, the first on top.
fn push_pieces(pieces: &mut SmallVec<[(NodeKey, NodeKey); 8]>, u: NodeKey, v: NodeKey, stops: &[NodeKey]) {
    let mut end = v;
    for &stop in stops.iter().rev() {
        pieces.push((stop, end));
        end = stop;
    }
    pieces.push((u, end));
}

fn square(length: i32) -> i64 {
    i64::from(length) * i64::from(length)
}
