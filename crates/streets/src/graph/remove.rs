//! Removal, and the dissolving of crossings that nothing needs any more.
//!
//! Inserting a street and removing it again restores the graph exactly: crossings that it made on other streets are
//! unpinned, so they dissolve and the split street is one straight segment again.

use super::{Claim, NodeKey, SegmentKey, StreetGraph};
use crate::StreetId;
use geom::tolerance;
use smallvec::SmallVec;

/// A straight stretch of one street between two kept nodes, in place of its pieces.
struct Straightened {
    from: NodeKey,
    to: NodeKey,
    level: i8,
    claim: Claim,
}

impl StreetGraph {
    /// Removes a street wherever it runs. Whether there was such a street.
    pub fn remove_street(&mut self, street: StreetId) -> bool {
        let segments = self.segments_of(street);
        self.remove_pieces(street, &segments)
    }

    /// Removes one street from some of its segments (others on them stay); what remains of it ends there.
    /// Whether there was anything to remove.
    pub fn remove_pieces(&mut self, street: StreetId, segments: &[SegmentKey]) -> bool {
        let mut touched = Vec::new();
        for &key in segments {
            let segment = self.segment(key);
            let mut claims = segment.claims.clone();
            claims.retain(|claim| claim.street != street);
            if claims.len() == segment.claims.len() {
                continue;
            }
            touched.extend(segment.ends);
            if claims.is_empty() {
                self.kill_segment(key);
            } else {
                self.set_claims(key, claims);
            }
        }
        self.tidy(street, &mut touched);
        self.commit();
        !touched.is_empty()
    }

    /// Settles the pins of a removed street's nodes, drops nodes without segments, dissolves needless crossings.
    fn tidy(&mut self, street: StreetId, touched: &mut Vec<NodeKey>) {
        touched.sort_unstable();
        touched.dedup();
        self.add_made_nearby(street, touched);
        for &node in touched.iter() {
            match self.neighbours_along(node, street).len() {
                0 => self.unpin(node, street),
                1 => self.pin(node, street),
                _ => {}
            }
            if self.degree(node) == 0 {
                self.kill_node(node);
            }
        }
        let mut needless: Vec<NodeKey> =
            touched.iter().copied().filter(|&node| self.is_needless(node, street)).collect();
        needless.sort_unstable_by_key(|&node| self.node(node).id);
        self.dissolve(needless, street);
    }

    /// Adds the nodes around that the street's insertion made on other streets, when it led those through its own.
    fn add_made_nearby(&self, street: StreetId, touched: &mut Vec<NodeKey>) {
        let mut next = 0;
        while next < touched.len() {
            for &arm in self.halves_ccw(touched[next]) {
                let node = self.target(arm);
                if self.maker(node) == street && !touched.contains(&node) {
                    touched.push(node);
                }
            }
            next += 1;
        }
    }

    /// Whether no street turns, ends or crosses here, now that `removed` is gone: a node which that street made, or one
    /// with a single street left. Others were there before it came, and stay.
    fn is_needless(&self, node: NodeKey, removed: StreetId) -> bool {
        if self.nodes[node.0 as usize].is_none() || !self.pins(node).is_empty() {
            return false;
        }
        let streets = self.streets_at(node);
        if streets.len() > 1 && self.maker(node) != removed {
            return false;
        }
        let mut through: SmallVec<[([NodeKey; 2], i8); 2]> = SmallVec::new();
        for street in streets {
            match self.neighbours_along(node, street).as_slice() {
                [(a, a_level), (b, b_level)] if a_level == b_level && a != b => through.push(([*a, *b], *a_level)),
                _ => return false,
            }
        }
        let pairs = through.iter().enumerate().flat_map(|(i, p)| through[..i].iter().map(move |q| (p, q)));
        !pairs
            .into_iter()
            .any(|((p, p_level), (q, q_level))| p_level == q_level && self.alternate(node, *p, *q, *p_level))
    }

    fn streets_at(&self, node: NodeKey) -> SmallVec<[StreetId; 2]> {
        let arms = self.halves_ccw(node).iter();
        let mut streets: SmallVec<[StreetId; 2]> =
            arms.flat_map(|arm| self.segment(arm.segment()).claims.iter().map(|claim| claim.street)).collect();
        streets.sort_unstable();
        streets.dedup();
        streets
    }

    /// Whether two passages through a node cross there: four distinct neighbours that alternate around it.
    fn alternate(&self, node: NodeKey, p: [NodeKey; 2], q: [NodeKey; 2], level: i8) -> bool {
        if p.iter().any(|n| q.contains(n)) {
            return false;
        }
        let around = self.halves_ccw(node).iter().filter(|arm| self.level(**arm) == level).map(|&arm| self.target(arm));
        let marks: SmallVec<[bool; 8]> =
            around.filter(|n| p.contains(n) || q.contains(n)).map(|n| p.contains(&n)).collect();
        marks.len() == 4 && marks[0] != marks[1] && marks[1] != marks[2]
    }

    /// Dissolves all the nodes at once, or, should that not hold, as many as do one by one; a node that must stay on
    /// a single street is pinned by it: it is a shape point now.
    fn dissolve(&mut self, mut needless: Vec<NodeKey>, removed: StreetId) {
        if needless.is_empty() || self.try_dissolve(&needless) {
            return;
        }
        loop {
            let before = needless.len();
            needless.retain(|&node| !self.is_needless(node, removed) || !self.try_dissolve(&[node]));
            if needless.len() == before {
                break;
            }
        }
        for node in needless {
            if let [street] = self.streets_at(node).as_slice() {
                self.pin(node, *street);
            }
        }
    }

    /// Replaces the pieces of every street through the nodes by straight stretches, if all of them keep the separation.
    fn try_dissolve(&mut self, nodes: &[NodeKey]) -> bool {
        let savepoint = self.log.len();
        let Some(stretches) = self.straightened(nodes) else { return false };
        let mut pieces: Vec<SegmentKey> =
            nodes.iter().flat_map(|&node| self.halves_ccw(node).iter().map(|arm| arm.segment())).collect();
        pieces.sort_unstable();
        pieces.dedup();
        for piece in pieces {
            self.kill_segment(piece);
        }
        for &node in nodes {
            self.kill_node(node);
        }
        for stretch in &stretches {
            self.lay_straight(stretch);
        }
        // Only now that all are laid does every node have segments, and is seen by the others.
        let holds = stretches.iter().all(|s| self.is_clear(s.from, s.to, s.level, tolerance::SEPARATION));
        if !holds {
            self.rollback(savepoint);
        }
        holds
    }

    fn lay_straight(&mut self, stretch: &Straightened) {
        match self.segment_between(stretch.from, stretch.to, stretch.level) {
            Some(key) => self.cover(key, stretch.from, &[stretch.claim]),
            None => {
                let claims = SmallVec::from_elem(stretch.claim, 1);
                self.add_segment([stretch.from, stretch.to], stretch.level, claims);
            }
        }
    }

    /// The straight stretches that would replace the pieces at the nodes, one a street and chain; `None` where a chain
    /// closes on itself or its ends fall together.
    fn straightened(&self, nodes: &[NodeKey]) -> Option<Vec<Straightened>> {
        let mut stretches = Vec::new();
        for &node in nodes {
            for street in self.streets_at(node) {
                let stretch = self.stretch_through(node, street, nodes)?;
                // Each chain is found from each of its nodes; it counts at the first.
                if stretch.1 == node {
                    stretches.push(stretch.0);
                }
            }
        }
        Some(stretches)
    }

    /// The stretch of a street through a node, and which of `nodes` along it comes first in their order.
    fn stretch_through(&self, node: NodeKey, street: StreetId, nodes: &[NodeKey]) -> Option<(Straightened, NodeKey)> {
        let neighbours = self.neighbours_along(node, street);
        let &[(a, level), (b, _)] = neighbours.as_slice() else { return None };
        let mut along: SmallVec<[NodeKey; 4]> = SmallVec::from_elem(node, 1);
        let from = self.walk(node, a, street, nodes, &mut along)?;
        let to = self.walk(node, b, street, nodes, &mut along)?;
        if from == to {
            return None;
        }
        let first = nodes.iter().copied().find(|n| along.contains(n))?;
        let mut claim = self.claim_between(node, b, level, street)?;
        for &n in &along {
            for (other, level) in self.neighbours_along(n, street) {
                let piece = self.claim_between(n, other, level, street)?;
                claim.class = claim.class.min(piece.class);
                claim.half_width = claim.half_width.max(piece.half_width);
            }
        }
        Some((Straightened { from, to, level, claim }, first))
    }

    /// Walks along a street from `node` over `next` while it passes `nodes`; returns the first node beyond them.
    fn walk(
        &self,
        mut node: NodeKey,
        mut next: NodeKey,
        street: StreetId,
        nodes: &[NodeKey],
        along: &mut SmallVec<[NodeKey; 4]>,
    ) -> Option<NodeKey> {
        while nodes.contains(&next) {
            if along.contains(&next) {
                return None;
            }
            along.push(next);
            let neighbours = self.neighbours_along(next, street);
            let &[(a, _), (b, _)] = neighbours.as_slice() else { return None };
            (node, next) = (next, if a == node { b } else { a });
        }
        Some(next)
    }

    /// A street's claim on the segment between two nodes, `forward` from `from` to `to`.
    fn claim_between(&self, from: NodeKey, to: NodeKey, level: i8, street: StreetId) -> Option<Claim> {
        let segment = self.segment(self.segment_between(from, to, level)?);
        let claim = segment.claims.iter().find(|claim| claim.street == street)?;
        Some(Claim { forward: claim.forward == (segment.ends[0] == from), ..*claim })
    }
}
