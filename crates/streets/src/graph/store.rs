//! Arenas, rotation systems and walking. Keys are internal to one graph; what is kept or compared is the stable id.

use super::index::SegmentIndex;
use super::transaction::Undo;
use crate::{Class, Classes, NodeId, SegmentId, StreetId};
use geom::{Id, Point, predicates};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// A node of one graph. Dead keys are reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NodeKey(pub(crate) u32);

/// A segment of one graph. Dead keys are reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SegmentKey(pub(crate) u32);

/// One of the two directions of a segment. The face of a half lies on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct HalfKey(pub(crate) u32);

impl SegmentKey {
    /// The half from start to end.
    pub fn forward(self) -> HalfKey {
        HalfKey(self.0 << 1)
    }

    /// The half from end to start.
    pub fn backward(self) -> HalfKey {
        HalfKey(self.0 << 1 | 1)
    }
}

impl HalfKey {
    /// The same segment in the other direction.
    #[must_use]
    pub fn twin(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// The segment this is a direction of.
    pub fn segment(self) -> SegmentKey {
        SegmentKey(self.0 >> 1)
    }

    /// Whether it runs from the segment's start to its end.
    pub fn is_forward(self) -> bool {
        self.0 & 1 == 0
    }

    /// A dense index, for tables over all halves (see [`StreetGraph::half_capacity`]).
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A street's hold on a segment it runs along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Claim {
    /// The street.
    pub street: StreetId,
    /// Its class here.
    pub class: Class,
    /// Half of its right-of-way including sidewalks, in LSB.
    pub half_width: i32,
    /// Which rule or input made it: an index into the table of whoever owns the graph.
    pub origin: u16,
    /// Whether the street runs from the segment's start to its end.
    pub forward: bool,
}

/// A place where segments end.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Node {
    /// Stable identity.
    pub id: NodeId,
    /// Position.
    pub at: Point,
    /// Outgoing halves, counter-clockwise from east; equal directions by level.
    pub(crate) arms: SmallVec<[HalfKey; 4]>,
}

/// What is asked of a node when streets come and go, not when places are: kept apart, so that what lies around a place
/// fits the cache.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct NodeStreets {
    /// Streets that turn or end here, sorted.
    pub pins: SmallVec<[StreetId; 2]>,
    /// The street whose insertion made the node.
    pub maker: StreetId,
}

/// A straight piece of street between two nodes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Segment {
    /// Stable identity.
    pub id: SegmentId,
    /// Start and end.
    pub ends: [NodeKey; 2],
    /// 0 on the ground, above it for bridges, below it for tunnels.
    pub level: i8,
    /// The streets that run here, the most important first (class, width, id).
    pub(crate) claims: SmallVec<[Claim; 1]>,
}

impl Segment {
    /// The claim that gives the segment its class, width and id.
    pub fn leading(&self) -> &Claim {
        &self.claims[0]
    }

    /// The streets that run here, the most important first; never empty.
    pub fn claims(&self) -> &[Claim] {
        &self.claims
    }

    /// The class of the most important street.
    pub fn class(&self) -> Class {
        self.leading().class
    }

    /// Half the right-of-way of the widest street that runs here, in LSB.
    pub fn half_width(&self) -> i32 {
        self.claims.iter().map(|claim| claim.half_width).max().unwrap_or(0)
    }
}

/// The planar street graph (see the module).
#[derive(Clone, Debug)]
pub struct StreetGraph {
    pub(crate) classes: Classes,
    pub(crate) nodes: Vec<Option<Node>>,
    /// By node key; of no meaning where there is no node.
    pub(crate) node_streets: Vec<NodeStreets>,
    pub(crate) segments: Vec<Option<Segment>>,
    pub(crate) free_nodes: Vec<u32>,
    pub(crate) free_segments: Vec<u32>,
    pub(crate) index: SegmentIndex,
    pub(crate) node_ids: FxHashMap<NodeId, NodeKey>,
    pub(crate) street_segments: FxHashMap<StreetId, SmallVec<[SegmentKey; 4]>>,
    pub(crate) log: Vec<Undo>,
    /// Attempts that the present operation is part of.
    pub(crate) attempts: u32,
}

impl StreetGraph {
    /// An empty graph.
    pub fn new(classes: Classes) -> Self {
        Self {
            classes,
            nodes: Vec::new(),
            node_streets: Vec::new(),
            segments: Vec::new(),
            free_nodes: Vec::new(),
            free_segments: Vec::new(),
            index: SegmentIndex::default(),
            node_ids: FxHashMap::default(),
            street_segments: FxHashMap::default(),
            log: Vec::new(),
            attempts: 0,
        }
    }

    /// The classes of its streets.
    pub fn classes(&self) -> &Classes {
        &self.classes
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len() - self.free_nodes.len()
    }

    /// Number of segments.
    pub fn segment_count(&self) -> usize {
        self.segments.len() - self.free_segments.len()
    }

    /// One more than the largest [`HalfKey::index`].
    pub fn half_capacity(&self) -> usize {
        self.segments.len() * 2
    }

    /// Whether a node is still there. A key that was reused counts as live: no removal makes nodes.
    pub fn is_live(&self, key: NodeKey) -> bool {
        self.nodes.get(key.0 as usize).is_some_and(Option::is_some)
    }

    /// The node of a live key. Panics for a dead one.
    pub fn node(&self, key: NodeKey) -> &Node {
        self.nodes[key.0 as usize].as_ref().expect("live node key")
    }

    /// The segment of a live key. Panics for a dead one.
    pub fn segment(&self, key: SegmentKey) -> &Segment {
        self.segments[key.0 as usize].as_ref().expect("live segment key")
    }

    /// All nodes in arena order, which depends on history: sort by id before anything observable.
    pub fn nodes_unsorted(&self) -> impl Iterator<Item = (NodeKey, &Node)> {
        self.nodes.iter().enumerate().filter_map(|(i, node)| Some((NodeKey(i as u32), node.as_ref()?)))
    }

    /// All segments in arena order, which depends on history: sort by id before anything observable.
    pub fn segments_unsorted(&self) -> impl Iterator<Item = (SegmentKey, &Segment)> {
        self.segments.iter().enumerate().filter_map(|(i, segment)| Some((SegmentKey(i as u32), segment.as_ref()?)))
    }

    /// All nodes by id.
    pub fn nodes_by_id(&self) -> Vec<NodeKey> {
        let mut keys: Vec<_> = self.nodes_unsorted().map(|(key, node)| (node.id, key)).collect();
        keys.sort_unstable();
        keys.into_iter().map(|(_, key)| key).collect()
    }

    /// All segments by id; segments of equal id (a street that runs between two nodes on two levels) by level.
    pub fn segments_by_id(&self) -> Vec<SegmentKey> {
        let mut keys: Vec<_> = self.segments_unsorted().map(|(key, s)| (s.id, s.level, key)).collect();
        keys.sort_unstable();
        keys.into_iter().map(|(.., key)| key).collect()
    }

    /// Where a node lies.
    pub fn at(&self, key: NodeKey) -> Point {
        self.node(key).at
    }

    /// The node a half starts from.
    pub fn origin(&self, half: HalfKey) -> NodeKey {
        self.segment(half.segment()).ends[usize::from(!half.is_forward())]
    }

    /// The node a half leads to.
    pub fn target(&self, half: HalfKey) -> NodeKey {
        self.segment(half.segment()).ends[usize::from(half.is_forward())]
    }

    /// Start and end position of a half.
    pub fn line(&self, half: HalfKey) -> (Point, Point) {
        (self.at(self.origin(half)), self.at(self.target(half)))
    }

    /// Outgoing halves of a node, counter-clockwise from east.
    pub fn halves_ccw(&self, node: NodeKey) -> &[HalfKey] {
        &self.node(node).arms
    }

    /// Number of segments at a node.
    pub fn degree(&self, node: NodeKey) -> usize {
        self.node(node).arms.len()
    }

    /// Streets that turn or end at the node, sorted by id.
    pub fn pins(&self, node: NodeKey) -> &[StreetId] {
        &self.node_streets[node.0 as usize].pins
    }

    /// The street whose insertion made the node.
    pub(crate) fn maker(&self, node: NodeKey) -> StreetId {
        self.node_streets[node.0 as usize].maker
    }

    /// The level of a half's segment.
    pub fn level(&self, half: HalfKey) -> i8 {
        self.segment(half.segment()).level
    }

    /// The half that follows on the rim of the face at the left of `half`, among the segments that `keep` admits
    /// (which must admit `half` itself): the clockwise predecessor of its twin (algorithms: faces).
    pub fn next_of(&self, half: HalfKey, keep: impl Fn(&Segment) -> bool) -> HalfKey {
        let twin = half.twin();
        let arms = self.halves_ccw(self.target(half));
        let at = arms.iter().position(|&arm| arm == twin).expect("a half is among the arms of its node");
        let mut i = at;
        loop {
            i = if i == 0 { arms.len() - 1 } else { i - 1 };
            if i == at || keep(self.segment(arms[i].segment())) {
                return arms[i];
            }
        }
    }

    /// The direction of a half as an exact vector in LSB.
    pub fn direction(&self, half: HalfKey) -> (i64, i64) {
        let (from, to) = self.line(half);
        from.to(to)
    }

    /// The box of all nodes, or `None` when the graph is empty.
    pub fn bounds(&self) -> Option<geom::Bounds> {
        geom::Bounds::of(self.nodes_unsorted().map(|(_, node)| node.at))
    }

    /// Total length of all segments in metres.
    pub fn total_length(&self) -> f64 {
        self.segments_by_id()
            .into_iter()
            .map(|key| {
                let (a, b) = self.line(key.forward());
                a.distance(b)
            })
            .fold(0.0, |sum, length| sum + length)
    }

    /// A canonical hash of everything that is kept of the graph, independent of history and keys.
    pub fn digest(&self) -> Id {
        let mut parts = Vec::new();
        for key in self.nodes_by_id() {
            let node = self.node(key);
            parts.extend([node.id.0.0, u128::from(node.at.x as u32) << 32 | u128::from(node.at.y as u32)]);
            parts.extend(self.pins(key).iter().map(|pin| pin.0.0));
        }
        for key in self.segments_by_id() {
            let segment = self.segment(key);
            let [a, b] = segment.ends.map(|end| self.node(end).id);
            parts.extend([segment.id.0.0, a.0.0.min(b.0.0), a.0.0.max(b.0.0), segment.level as u8 as u128]);
            for claim in &segment.claims {
                let start = if claim.forward { a } else { b };
                let attributes = u128::from(claim.class.0) << 64 | claim.half_width as u32 as u128;
                parts.extend([claim.street.0.0, start.0.0, attributes, u128::from(claim.origin)]);
            }
        }
        Id::root("street graph", &parts)
    }

    /// Position of a half with this direction and level among the arms of a node.
    pub(crate) fn arm_slot(&self, node: NodeKey, direction: (i64, i64), level: i8) -> usize {
        let arms = &self.node(node).arms;
        arms.iter()
            .position(|&arm| {
                predicates::by_angle(self.direction(arm), direction).then(self.level(arm).cmp(&level)).is_gt()
            })
            .unwrap_or(arms.len())
    }
}
