//! The validity contract of the street graph: V1, V2, V3 and V13 (algorithms: validity contract), with witnesses.

use super::oracle;
use super::{Claim, HalfKey, NodeKey, Segment, SegmentKey, StreetGraph};
use crate::faces::Rims;
use crate::{NodeId, SegmentId};
use geom::{Angle, Bounds, Point, Vec2, predicates, tolerance};
use std::cmp::{Ordering, Reverse};

mod near;

#[cfg(test)]
mod tests;

/// How thoroughly to check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckLevel {
    /// Everything, in O(n log n).
    Sweep,
    /// Everything against everything, in exact rationals that share no code with the graph: O(n²).
    Brute,
}

/// A rule of the contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// Planarity: two segments of a level meet in nothing but one common end.
    V1,
    /// Separation: what does not meet keeps [`tolerance::SEPARATION`].
    V2,
    /// Map: rotations are sorted, complete and of genus 0; indices agree.
    V3,
    /// Identity: ids are unique, claims canonical.
    V13,
}

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, thiserror::Error)]
pub enum Breach {
    /// Two segments of a level meet elsewhere than in a common end, or overlap.
    #[error("two segments of a level meet elsewhere than in a common end")]
    Crossing,
    /// Both ends of a segment are one place.
    #[error("a segment has no length")]
    ZeroLength,
    /// Two segments of a level have the same ends.
    #[error("two segments of a level have the same ends")]
    Duplicate,
    /// Two nodes are closer than the separation. Measured: their distance in metres.
    #[error("two nodes are too close")]
    NodesClose,
    /// A node is closer to a segment than the separation. Measured: their distance in metres.
    #[error("a node is too close to a segment that does not end there")]
    NodeAtSegment,
    /// An end of a segment, or an arm of a node, is not in the graph or not where it says.
    #[error("a segment or an arm refers to something that is not there")]
    Dangling,
    /// A segment is not among the arms of its end.
    #[error("a segment is missing among the arms of its end")]
    ArmMissing,
    /// Arms are not in counter-clockwise order.
    #[error("arms are not in counter-clockwise order")]
    ArmOrder,
    /// V − E + F ≠ 1 + C on some level. Measured: the difference.
    #[error("nodes, segments and faces do not make a planar map")]
    Euler,
    /// A look-up does not find a node or a segment.
    #[error("an index does not find a node or a segment")]
    Index,
    /// Two nodes share an id.
    #[error("two nodes share an id")]
    NodeIdTwice,
    /// Two segments of a level share an id.
    #[error("two segments of a level share an id")]
    SegmentIdTwice,
    /// A segment carries no street.
    #[error("a segment carries no street")]
    NoClaim,
    /// Claims are not sorted by importance, or a street claims twice.
    #[error("claims are out of order, or a street claims twice")]
    ClaimOrder,
}

impl Breach {
    /// The rule that is broken.
    pub fn rule(self) -> Rule {
        match self {
            Self::Crossing | Self::ZeroLength | Self::Duplicate => Rule::V1,
            Self::NodesClose | Self::NodeAtSegment => Rule::V2,
            Self::Dangling | Self::ArmMissing | Self::ArmOrder | Self::Euler | Self::Index => Rule::V3,
            Self::NodeIdTwice | Self::SegmentIdTwice | Self::NoClaim | Self::ClaimOrder => Rule::V13,
        }
    }
}

/// One violation of the contract, with its witnesses.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// The rule that is broken.
    pub rule: Rule,
    /// How.
    pub breach: Breach,
    /// The nodes concerned, sorted.
    pub nodes: Vec<NodeId>,
    /// The segments concerned, with their level, sorted.
    pub segments: Vec<(SegmentId, i8)>,
    /// Where to look.
    pub points: Vec<Point>,
    /// The measured value where there is one (see [`Breach`]), else 0.
    pub measured: f64,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}: {} ({})", self.rule, self.breach, self.measured)?;
        self.points.iter().try_for_each(|p| write!(f, " at {:?}", p.metres()))?;
        self.nodes.iter().try_for_each(|id| write!(f, " node {id}"))?;
        self.segments.iter().try_for_each(|(id, level)| write!(f, " segment {id} level {level}"))
    }
}

/// Two neighbouring segments of a level that leave a crossing under a very small angle: flagged, not a violation.
#[derive(Clone, Debug, PartialEq)]
pub struct SharpAngle {
    /// The crossing.
    pub node: NodeId,
    /// The two segments, with their level, counter-clockwise.
    pub segments: [(SegmentId, i8); 2],
    /// The angle between them.
    pub degrees: f64,
}

impl StreetGraph {
    /// Checks the whole graph. An empty answer means that it is valid.
    pub fn check(&self, level: CheckLevel) -> Vec<Violation> {
        let mut check = Check::new(self, level);
        if check.references() {
            check.all_arms();
            check.all_claims();
            check.identity();
            match level {
                CheckLevel::Sweep => near::for_pairs(self, |a, b| check.pair(a, b)),
                CheckLevel::Brute => near::for_all_pairs(self, |a, b| check.pair(a, b)),
            }
            check.indices();
            check.euler();
        }
        check.sorted()
    }

    /// Checks what an operation touched against everything around: the nodes, the segments and their ends. Keys that
    /// are no longer in the graph are passed over. Takes time in proportion to what lies near.
    pub fn check_touched(&self, nodes: &[NodeKey], segments: &[SegmentKey]) -> Vec<Violation> {
        let mut check = Check::new(self, CheckLevel::Sweep);
        let segments: Vec<_> = segments.iter().copied().filter(|&key| self.live_segment(key).is_some()).collect();
        for &key in &segments {
            check.ends_of(key);
            check.claims_of(key);
        }
        if check.found.is_empty() {
            let ends = segments.iter().flat_map(|&key| self.segment(key).ends);
            let mut nodes: Vec<_> =
                nodes.iter().copied().chain(ends).filter(|&key| self.live_node(key).is_some()).collect();
            nodes.sort_unstable();
            nodes.dedup();
            check.touched(&nodes, &segments);
        }
        check.sorted()
    }

    /// Neighbouring segments of a level that leave a node under less than [`tolerance::LEAST_ANGLE_DEG`]; by node id.
    pub fn sharp_angles(&self) -> Vec<SharpAngle> {
        let mut found = Vec::new();
        for node in self.nodes_by_id() {
            let mut levels: Vec<i8> = self.halves_ccw(node).iter().map(|&arm| self.level(arm)).collect();
            levels.sort_unstable();
            levels.dedup();
            for level in levels {
                self.sharp_angles_at(node, level, &mut found);
            }
        }
        found
    }

    fn sharp_angles_at(&self, node: NodeKey, level: i8, found: &mut Vec<SharpAngle>) {
        let arms: Vec<HalfKey> =
            self.halves_ccw(node).iter().copied().filter(|&arm| self.level(arm) == level).collect();
        let pairs = if arms.len() < 2 { 0 } else { arms.len() };
        for i in 0..pairs {
            let (a, b) = (arms[i], arms[(i + 1) % arms.len()]);
            let turn = self.turn_between(a, b).to_degrees();
            if (0.0..tolerance::LEAST_ANGLE_DEG).contains(&turn) {
                let segments = [a, b].map(|arm| self.witness(arm.segment()));
                found.push(SharpAngle { node: self.node(node).id, segments, degrees: turn });
            }
        }
    }

    /// The angle from one arm of a node counter-clockwise to another, in (-180°, 180°].
    fn turn_between(&self, a: HalfKey, b: HalfKey) -> Angle {
        let vector = |half| {
            let (x, y) = self.direction(half);
            Vec2::new(x as f64, y as f64)
        };
        let (a, b) = (vector(a), vector(b));
        Angle::of(Vec2::new(a.dot(b), a.perp_dot(b)))
    }

    fn live_node(&self, key: NodeKey) -> Option<&super::Node> {
        self.nodes.get(key.0 as usize)?.as_ref()
    }

    fn live_segment(&self, key: SegmentKey) -> Option<&Segment> {
        self.segments.get(key.0 as usize)?.as_ref()
    }

    fn witness(&self, key: SegmentKey) -> (SegmentId, i8) {
        (self.segment(key).id, self.segment(key).level)
    }
}

/// Something with a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Thing {
    Node(NodeKey),
    Segment(SegmentKey),
}

/// The geometric tests of a level; each has its own (see [`predicates`] for what they answer).
struct Exact {
    meets: fn(Point, Point, Point, Point) -> bool,
    lies_on: fn(Point, Point, Point) -> bool,
    within: fn(Point, Point, Point, i32) -> bool,
}

/// A running check.
struct Check<'a> {
    graph: &'a StreetGraph,
    found: Vec<Violation>,
    exact: Exact,
}

impl<'a> Check<'a> {
    fn new(graph: &'a StreetGraph, level: CheckLevel) -> Self {
        let exact = match level {
            CheckLevel::Sweep => {
                Exact { meets: predicates::meets, lies_on: predicates::on_segment, within: predicates::within }
            }
            CheckLevel::Brute => Exact { meets: oracle::meets, lies_on: oracle::lies_on, within: oracle::within },
        };
        Self { graph, found: Vec::new(), exact }
    }

    fn sorted(mut self) -> Vec<Violation> {
        let key = |v: &Violation| (v.breach, v.nodes.clone(), v.segments.clone());
        self.found.sort_by_cached_key(key);
        self.found.dedup_by(|a, b| key(a) == key(b));
        self.found
    }

    fn report(&mut self, breach: Breach, nodes: &[NodeKey], segments: &[SegmentKey], measured: f64) {
        let mut points: Vec<Point> = nodes.iter().filter_map(|&key| Some(self.graph.live_node(key)?.at)).collect();
        if nodes.is_empty() {
            let ends = segments.iter().flat_map(|&key| self.graph.segment(key).ends);
            points.extend(ends.filter_map(|key| Some(self.graph.live_node(key)?.at)));
        }
        let mut nodes: Vec<_> = nodes.iter().filter_map(|&key| Some(self.graph.live_node(key)?.id)).collect();
        let mut segments: Vec<_> = segments.iter().map(|&key| self.graph.witness(key)).collect();
        nodes.sort_unstable();
        segments.sort_unstable();
        self.found.push(Violation { rule: breach.rule(), breach, nodes, segments, points, measured });
    }

    /// Whether all that is referred to is there; without that nothing else can be checked.
    fn references(&mut self) -> bool {
        for (key, _) in self.graph.segments_unsorted() {
            self.ends_of(key);
        }
        for (key, _) in self.graph.nodes_unsorted() {
            self.arms_exist(key);
        }
        self.found.is_empty()
    }

    fn ends_of(&mut self, key: SegmentKey) {
        let ends = self.graph.segment(key).ends;
        if ends.iter().any(|&end| self.graph.live_node(end).is_none()) {
            self.report(Breach::Dangling, &[], &[key], 0.0);
        }
    }

    fn arms_exist(&mut self, key: NodeKey) {
        let starts_here = |arm: &HalfKey| {
            let segment = self.graph.live_segment(arm.segment());
            segment.is_some_and(|segment| segment.ends[usize::from(!arm.is_forward())] == key)
        };
        if !self.graph.halves_ccw(key).iter().all(starts_here) {
            self.report(Breach::Dangling, &[key], &[], 0.0);
        }
    }

    fn all_arms(&mut self) {
        for (key, _) in self.graph.nodes_unsorted() {
            self.arms_sorted(key);
        }
        for (key, _) in self.graph.segments_unsorted() {
            self.segment_registered(key);
        }
    }

    fn arms_sorted(&mut self, key: NodeKey) {
        let order = |a: HalfKey, b: HalfKey| {
            let by_angle = predicates::by_angle(self.graph.direction(a), self.graph.direction(b));
            by_angle.then(self.graph.level(a).cmp(&self.graph.level(b)))
        };
        if !self.graph.halves_ccw(key).windows(2).all(|pair| order(pair[0], pair[1]) == Ordering::Less) {
            self.report(Breach::ArmOrder, &[key], &[], 0.0);
        }
    }

    /// Whether a segment is among the arms of both ends, and has a length.
    fn segment_registered(&mut self, key: SegmentKey) {
        let ends = self.graph.segment(key).ends;
        for (end, half) in [(ends[0], key.forward()), (ends[1], key.backward())] {
            if !self.graph.halves_ccw(end).contains(&half) {
                self.report(Breach::ArmMissing, &[end], &[key], 0.0);
            }
        }
        if self.graph.at(ends[0]) == self.graph.at(ends[1]) {
            self.report(Breach::ZeroLength, &[], &[key], 0.0);
        }
    }

    fn all_claims(&mut self) {
        for (key, _) in self.graph.segments_unsorted() {
            self.claims_of(key);
        }
    }

    fn claims_of(&mut self, key: SegmentKey) {
        let claims = self.graph.segment(key).claims();
        let order = |claim: &Claim| (claim.class, Reverse(claim.half_width), claim.street);
        let mut streets: Vec<_> = claims.iter().map(|claim| claim.street).collect();
        streets.sort_unstable();
        streets.dedup();
        if claims.is_empty() {
            self.report(Breach::NoClaim, &[], &[key], 0.0);
        } else if streets.len() < claims.len() || !claims.is_sorted_by_key(order) {
            self.report(Breach::ClaimOrder, &[], &[key], claims.len() as f64);
        }
    }

    fn identity(&mut self) {
        let nodes = self.graph.nodes_by_id();
        for pair in nodes.windows(2).filter(|pair| self.graph.node(pair[0]).id == self.graph.node(pair[1]).id) {
            self.report(Breach::NodeIdTwice, pair, &[], 0.0);
        }
        let segments = self.graph.segments_by_id();
        for pair in segments.windows(2).filter(|pair| self.graph.witness(pair[0]) == self.graph.witness(pair[1])) {
            self.report(Breach::SegmentIdTwice, &[], pair, 0.0);
        }
    }

    fn indices(&mut self) {
        for (key, node) in self.graph.nodes_unsorted() {
            if self.graph.find_node(node.id) != Some(key) {
                self.report(Breach::Index, &[key], &[], 0.0);
            }
        }
        for (key, _) in self.graph.segments_unsorted() {
            let (a, b) = self.graph.line(key.forward());
            let is_found = |p: Point| {
                let mut is_found = false;
                self.graph.for_segments_near(Bounds::between(p, p), |near| is_found |= near == key);
                is_found
            };
            if !is_found(a) || !is_found(b) {
                self.report(Breach::Index, &[], &[key], 0.0);
            }
        }
    }

    /// Two things that may lie close.
    fn pair(&mut self, a: Thing, b: Thing) {
        match (a, b) {
            (Thing::Node(a), Thing::Node(b)) => self.nodes_apart(a, b),
            (Thing::Node(node), Thing::Segment(segment)) | (Thing::Segment(segment), Thing::Node(node)) => {
                self.node_off_segment(node, segment);
            }
            (Thing::Segment(a), Thing::Segment(b)) => self.segments_apart(a, b),
        }
    }

    fn nodes_apart(&mut self, a: NodeKey, b: NodeKey) {
        let (p, q) = (self.graph.at(a), self.graph.at(b));
        if p.distance_squared(q) < i64::from(tolerance::SEPARATION) * i64::from(tolerance::SEPARATION) {
            self.report(Breach::NodesClose, &[a, b], &[], p.distance(q));
        }
    }

    fn node_off_segment(&mut self, node: NodeKey, key: SegmentKey) {
        let segment = self.graph.segment(key);
        let concerns = segment.level == 0 || self.graph.has_level(node, segment.level);
        let (p, (a, b)) = (self.graph.at(node), self.graph.line(key.forward()));
        if concerns && !segment.ends.contains(&node) && (self.exact.within)(a, b, p, tolerance::SEPARATION) {
            self.report(Breach::NodeAtSegment, &[node], &[key], predicates::foot(a, b, p).distance(p));
        }
    }

    fn segments_apart(&mut self, first: SegmentKey, second: SegmentKey) {
        let (s, t) = (self.graph.segment(first), self.graph.segment(second));
        if s.level != t.level {
            return;
        }
        let ((a, b), (c, d)) = (self.graph.line(first.forward()), self.graph.line(second.forward()));
        if a == b || c == d {
            return;
        }
        let shared = s.ends.iter().filter(|end| t.ends.contains(end)).count();
        let is_overlap = || {
            // With one common end the two meet elsewhere exactly where one far end lies on the other segment.
            let far = |of: &Segment, other: &Segment| of.ends.into_iter().find(|end| !other.ends.contains(end));
            let lies_on =
                |end: Option<NodeKey>, a, b| end.is_some_and(|end| (self.exact.lies_on)(a, b, self.graph.at(end)));
            lies_on(far(s, t), c, d) || lies_on(far(t, s), a, b)
        };
        match shared {
            2 => self.report(Breach::Duplicate, &[], &[first, second], 0.0),
            1 if is_overlap() => self.report(Breach::Crossing, &[], &[first, second], 0.0),
            0 if (self.exact.meets)(a, b, c, d) => self.report(Breach::Crossing, &[], &[first, second], 0.0),
            _ => {}
        }
    }

    fn touched(&mut self, nodes: &[NodeKey], segments: &[SegmentKey]) {
        for &node in nodes {
            self.arms_exist(node);
        }
        if !self.found.is_empty() {
            return;
        }
        for &node in nodes {
            self.arms_sorted(node);
            let at = self.graph.at(node);
            for near in self.graph.segments_near(Bounds::between(at, at).grown(tolerance::SEPARATION)) {
                self.node_off_segment(node, near);
                for end in self.graph.segment(near).ends.into_iter().filter(|&end| end != node) {
                    self.nodes_apart(node, end);
                }
            }
        }
        for &segment in segments {
            self.segment_registered(segment);
            let (a, b) = self.graph.line(segment.forward());
            for near in self.graph.segments_near(Bounds::between(a, b).grown(tolerance::SEPARATION)) {
                if near != segment {
                    self.segments_apart(segment, near);
                }
                for end in self.graph.segment(near).ends {
                    self.node_off_segment(end, segment);
                }
            }
        }
    }

    /// V − E + F = 1 + C for each level. With R rims, of which each component has one that is no face of its own, the
    /// faces are R − C + 1.
    fn euler(&mut self) {
        if self.found.iter().any(|violation| violation.rule == Rule::V3) {
            return;
        }
        let mut levels: Vec<i8> = self.graph.segments_unsorted().map(|(_, segment)| segment.level).collect();
        levels.sort_unstable();
        levels.dedup();
        for level in levels {
            let rims = Rims::walk(self.graph, |segment| segment.level == level);
            let (nodes, segments, components) = self.counts(level);
            let outside = (0..rims.len()).filter(|&rim| rims.area(rim) <= 0).count();
            let excess = nodes as i64 - segments as i64 + rims.len() as i64 - 2 * components as i64;
            if excess != 0 || outside != components {
                self.report(Breach::Euler, &[], &[], excess as f64);
            }
        }
    }

    /// Nodes, segments and components of a level.
    fn counts(&self, level: i8) -> (usize, usize, usize) {
        let mut sets = oracle::Sets::new(self.graph.nodes.len());
        let (mut segments, mut joins) = (0, 0);
        for (_, segment) in self.graph.segments_unsorted().filter(|(_, segment)| segment.level == level) {
            segments += 1;
            joins += usize::from(sets.join(segment.ends[0].0 as usize, segment.ends[1].0 as usize));
        }
        let nodes = self.graph.nodes_unsorted().filter(|&(key, _)| self.graph.has_level(key, level)).count();
        (nodes, segments, nodes - joins)
    }
}
