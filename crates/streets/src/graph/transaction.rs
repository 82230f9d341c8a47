//! The low-level changes and their undo log: an operation either commits whole or leaves nothing behind.

use super::store::NodeStreets;
use super::{Claim, Node, NodeKey, Segment, SegmentKey, StreetGraph};
use crate::{NodeId, SegmentId, StreetId};
use geom::Point;
use smallvec::SmallVec;

/// One change, and what takes it back.
#[derive(Clone, Debug)]
pub(crate) enum Undo {
    AddedNode(NodeKey),
    KilledNode(NodeKey, Box<(Node, NodeStreets)>),
    AddedSegment(SegmentKey),
    KilledSegment(SegmentKey, Box<Segment>),
    Claims(SegmentKey, SegmentId, SmallVec<[Claim; 1]>),
    Pins(NodeKey, SmallVec<[StreetId; 2]>),
}

impl StreetGraph {
    /// Several operations as one: when `work` gives nothing, the graph is as it was before.
    pub fn attempt<R>(&mut self, work: impl FnOnce(&mut Self) -> Option<R>) -> Option<R> {
        let savepoint = self.log.len();
        self.attempts += 1;
        let result = work(self);
        self.attempts -= 1;
        if result.is_none() {
            self.rollback(savepoint);
        }
        self.commit();
        result
    }

    /// Keeps everything done since the operation began, unless it is part of an attempt that may still fail.
    pub(crate) fn commit(&mut self) {
        if self.attempts == 0 {
            self.log.clear();
        }
    }

    /// Takes back everything done since the log had this length.
    pub(crate) fn rollback(&mut self, length: usize) {
        while self.log.len() > length {
            let Some(change) = self.log.pop() else { return };
            match change {
                Undo::AddedNode(key) => {
                    self.unplace_node(key);
                }
                Undo::KilledNode(key, node) => self.place_node(key, node.0, node.1),
                Undo::AddedSegment(key) => {
                    self.unplace_segment(key);
                }
                Undo::KilledSegment(key, segment) => self.place_segment(key, *segment),
                Undo::Claims(key, id, claims) => {
                    self.exchange_claims(key, id, claims);
                }
                Undo::Pins(key, pins) => self.node_streets[key.0 as usize].pins = pins,
            }
        }
    }

    /// Adds a node without segments. A taken id is replaced by a descendant of it.
    pub(crate) fn add_node(&mut self, id: NodeId, at: Point, maker: StreetId) -> NodeKey {
        let mut free = id;
        for slot in 0.. {
            if !self.node_ids.contains_key(&free) {
                break;
            }
            free = NodeId(id.0.child(slot));
        }
        let key = match self.free_nodes.last() {
            Some(&slot) => NodeKey(slot),
            None => NodeKey(self.nodes.len() as u32),
        };
        self.place_node(
            key,
            Node { id: free, at, arms: SmallVec::new() },
            NodeStreets { pins: SmallVec::new(), maker },
        );
        self.log.push(Undo::AddedNode(key));
        key
    }

    /// Removes a node without segments.
    pub(crate) fn kill_node(&mut self, key: NodeKey) {
        debug_assert!(self.halves_ccw(key).is_empty());
        let node = self.unplace_node(key);
        let streets = self.node_streets[key.0 as usize].clone();
        self.log.push(Undo::KilledNode(key, Box::new((node, streets))));
    }

    /// Adds a segment whose claims run from `ends[0]` to `ends[1]` where `forward`; claims are sorted here.
    pub(crate) fn add_segment(
        &mut self,
        ends: [NodeKey; 2],
        level: i8,
        mut claims: SmallVec<[Claim; 1]>,
    ) -> SegmentKey {
        sort_claims(&mut claims);
        let id = self.segment_id(ends, level, &claims[0]);
        let key = match self.free_segments.last() {
            Some(&slot) => SegmentKey(slot),
            None => SegmentKey(self.segments.len() as u32),
        };
        self.place_segment(key, Segment { id, ends, level, claims });
        self.log.push(Undo::AddedSegment(key));
        key
    }

    /// Removes a segment and returns what it was.
    pub(crate) fn kill_segment(&mut self, key: SegmentKey) -> Segment {
        let segment = self.unplace_segment(key);
        self.log.push(Undo::KilledSegment(key, Box::new(segment.clone())));
        segment
    }

    /// Replaces the claims of a segment; at least one must remain.
    pub(crate) fn set_claims(&mut self, key: SegmentKey, mut claims: SmallVec<[Claim; 1]>) {
        sort_claims(&mut claims);
        let segment = self.segment(key);
        let id = self.segment_id(segment.ends, segment.level, &claims[0]);
        let (old_id, old_claims) = self.exchange_claims(key, id, claims);
        self.log.push(Undo::Claims(key, old_id, old_claims));
    }

    /// Pins a node by a street.
    pub(crate) fn pin(&mut self, key: NodeKey, street: StreetId) {
        if let Err(slot) = self.pins(key).binary_search(&street) {
            let mut pins = self.node_streets[key.0 as usize].pins.clone();
            pins.insert(slot, street);
            self.exchange_pins(key, pins);
        }
    }

    /// Takes a street's pin from a node.
    pub(crate) fn unpin(&mut self, key: NodeKey, street: StreetId) {
        if let Ok(slot) = self.pins(key).binary_search(&street) {
            let mut pins = self.node_streets[key.0 as usize].pins.clone();
            pins.remove(slot);
            self.exchange_pins(key, pins);
        }
    }

    fn exchange_pins(&mut self, key: NodeKey, pins: SmallVec<[StreetId; 2]>) {
        let old = std::mem::replace(&mut self.node_streets[key.0 as usize].pins, pins);
        self.log.push(Undo::Pins(key, old));
    }

    fn segment_id(&self, ends: [NodeKey; 2], level: i8, leading: &Claim) -> SegmentId {
        let [a, b] = ends.map(|end| self.node(end).id);
        let (start, end) = if leading.forward { (a, b) } else { (b, a) };
        SegmentId::between(leading.street, start, end, level)
    }

    fn place_node(&mut self, key: NodeKey, node: Node, streets: NodeStreets) {
        self.node_ids.insert(node.id, key);
        match self.node_streets.get_mut(key.0 as usize) {
            Some(slot) => *slot = streets,
            None => self.node_streets.push(streets),
        }
        take_slot(&mut self.nodes, &mut self.free_nodes, key.0, node);
    }

    fn unplace_node(&mut self, key: NodeKey) -> Node {
        let node = self.nodes[key.0 as usize].take().expect("live node key");
        self.free_nodes.push(key.0);
        self.node_ids.remove(&node.id);
        node
    }

    fn place_segment(&mut self, key: SegmentKey, segment: Segment) {
        let ([start, end], level) = (segment.ends, segment.level);
        let (a, b) = (self.at(start), self.at(end));
        for claim in &segment.claims {
            self.street_segments.entry(claim.street).or_default().push(key);
        }
        take_slot(&mut self.segments, &mut self.free_segments, key.0, segment);
        self.index.insert(key, a, b);
        for (node, half, direction) in [(start, key.forward(), a.to(b)), (end, key.backward(), b.to(a))] {
            let slot = self.arm_slot(node, direction, level);
            if let Some(node) = &mut self.nodes[node.0 as usize] {
                node.arms.insert(slot, half);
            }
        }
    }

    fn unplace_segment(&mut self, key: SegmentKey) -> Segment {
        let segment = self.segments[key.0 as usize].take().expect("live segment key");
        self.free_segments.push(key.0);
        let [a, b] = segment.ends.map(|end| self.at(end));
        self.index.remove(key, a, b);
        for (end, half) in [(segment.ends[0], key.forward()), (segment.ends[1], key.backward())] {
            if let Some(node) = &mut self.nodes[end.0 as usize] {
                node.arms.retain(|arm| *arm != half);
            }
        }
        for claim in &segment.claims {
            self.forget_street_segment(claim.street, key);
        }
        segment
    }

    fn exchange_claims(
        &mut self,
        key: SegmentKey,
        id: SegmentId,
        claims: SmallVec<[Claim; 1]>,
    ) -> (SegmentId, SmallVec<[Claim; 1]>) {
        for claim in &claims {
            self.street_segments.entry(claim.street).or_default().push(key);
        }
        let segment = self.segments[key.0 as usize].as_mut().expect("live segment key");
        let old = (std::mem::replace(&mut segment.id, id), std::mem::replace(&mut segment.claims, claims));
        for claim in &old.1 {
            self.forget_street_segment(claim.street, key);
        }
        old
    }

    fn forget_street_segment(&mut self, street: StreetId, key: SegmentKey) {
        if let Some(keys) = self.street_segments.get_mut(&street) {
            if let Some(at) = keys.iter().position(|&k| k == key) {
                keys.swap_remove(at);
            }
            if keys.is_empty() {
                self.street_segments.remove(&street);
            }
        }
    }
}

/// Puts a value into a slot that is new, or the last freed, or (on undo) anywhere on the free list.
fn take_slot<T>(slots: &mut Vec<Option<T>>, free: &mut Vec<u32>, slot: u32, value: T) {
    if slot as usize == slots.len() {
        slots.push(Some(value));
        return;
    }
    if let Some(at) = free.iter().rposition(|&s| s == slot) {
        free.remove(at);
    }
    slots[slot as usize] = Some(value);
}

/// Most important first: by class, then the wider, then by id.
fn sort_claims(claims: &mut [Claim]) {
    claims.sort_by_key(|claim| (claim.class, -claim.half_width, claim.street));
}
