//! Local constraints (PM01 §3.3): what adjusts a proposal to what is there, or refuses it.
//!
//! The chain is: demand, legal area and slope, first crossing and extension, snapping (these until they agree, see
//! [`MOST_PASSES`]), then least length, legal area again, duplicates, angles. That way no later adjustment leaves a
//! crossing, a coast or a near-parallel street untested.

use super::ground::Ground;
use super::lineage::Proposal;
use super::near::Near;
use super::{Fields, Goal, Outcome, Refused};
use crate::StreetGraph;
use geom::point::units;
use geom::{Angle, Bounds, Point, Vec2, tolerance};

/// Rounds of crossing and snapping before a proposal is refused as unsettled.
const MOST_PASSES: usize = 3;

/// Two ends this close (LSB) are the same end: the rounding of a cut, of a foot, and of the segment they lie on.
const SAME_END: i64 = 3;

/// Parameters of the local constraints. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraints {
    /// A street that ends, or passes a crossing, closer than this goes to it: 5 m for minors, 8 m for majors.
    pub snap: f64,
    /// A street that would meet another within this multiple of its length goes on to it; 1 for never. 1.25.
    pub extend: f64,
    /// Longest piece that a street goes on by: beyond it there is room for a block. On a raster it is the least
    /// length, so that no crossing of the raster is passed where the next piece can be laid. 30 m.
    pub extend_most: f64,
    /// Near-parallel streets closer than this, along more than half of the shorter one, are duplicates; so are those
    /// whose roadways would overlap. 6 m.
    pub duplicate: f64,
    /// Shortest street segment laid. 8 m.
    pub least_length: f64,
    /// Longest street segment proposed; longer proposals are cut. 1 km.
    pub longest: f64,
    /// Least angle between streets at a crossing. 25°.
    pub least_angle: Angle,
    /// Least share of its length that a proposal may be cut back to at the rim of the legal area. 0.5.
    pub prune: f64,
    /// Step of the search for a heading that stays in the legal area. 10°.
    pub turn_step: Angle,
    /// Largest turn of that search; 0 for none. 60°.
    pub turn_most: Angle,
    /// Longest stretch of illegal area that a street may cross on a bridge; 0 for none. 0.
    pub bridge: f64,
    /// Steepest slope, rise over run; infinite for any. Infinite.
    pub max_slope: f64,
}

impl Default for Constraints {
    fn default() -> Self {
        Self {
            snap: 5.0,
            extend: 1.25,
            extend_most: 30.0,
            duplicate: 6.0,
            least_length: 8.0,
            longest: 1000.0,
            least_angle: Angle::degrees(tolerance::LEAST_GROWN_ANGLE_DEG),
            prune: 0.5,
            turn_step: Angle::degrees(10.0),
            turn_most: Angle::degrees(60.0),
            bridge: 0.0,
            max_slope: f64::INFINITY,
        }
    }
}

impl Constraints {
    /// The defaults for majors and highways: as the defaults, but snapping within 8 m.
    pub fn majors() -> Self {
        Self { snap: 8.0, ..Self::default() }
    }
}

/// A proposal as the constraints leave it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Judged {
    pub to: Point,
    pub heading: Angle,
    pub outcome: Outcome,
    pub level: i8,
}

/// A proposal on its way through the chain, in metres.
#[derive(Clone, Copy, Debug)]
struct Line {
    to: Vec2,
    heading: Angle,
    outcome: Outcome,
}

/// The chain, with what it needs of a growth.
#[derive(Debug)]
pub(super) struct Judge<'a> {
    constraints: &'a Constraints,
    goal: &'a Goal,
    pub ground: Ground<'a>,
    near: Near,
    /// Half of the widest right-of-way in the graph, in LSB.
    widest: i32,
    snap: i32,
    least: i32,
    duplicate: i32,
    cosine: f64,
}

impl<'a> Judge<'a> {
    pub fn new(graph: &StreetGraph, constraints: &'a Constraints, goal: &'a Goal, fields: &'a Fields) -> Self {
        Self {
            constraints,
            goal,
            ground: Ground::new(fields, constraints),
            near: Near::default(),
            widest: graph.segments_unsorted().map(|(_, segment)| segment.half_width()).max().unwrap_or(0),
            snap: units(constraints.snap),
            // Nothing shorter can be laid, whatever is asked for.
            least: units(constraints.least_length).max(tolerance::LAYING + 1),
            duplicate: units(constraints.duplicate),
            cosine: constraints.least_angle.cos(),
        }
    }

    /// Adjusts a proposal to the streets of a graph and the ground, or refuses it.
    pub fn judge(&mut self, graph: &StreetGraph, proposal: &Proposal) -> Result<Judged, Refused> {
        if !self.goal.is_met(proposal.target) {
            return Err(Refused::NoDemand);
        }
        let line = self.on_legal_ground(proposal)?;
        let to = Point::try_from_metres(line.to).ok_or(Refused::OffLattice)?;
        if line.outcome == Outcome::Bridged {
            return self.over_bridge(graph, proposal, &line, to);
        }
        let reach = self.extended(proposal, to);
        self.widest = self.widest.max(proposal.half_width);
        let margin =
            self.snap.saturating_mul(2).max(self.duplicate).max(proposal.half_width.saturating_add(self.widest));
        self.near.gather(graph, Bounds::between(proposal.from, reach).grown(margin));
        if proposal.is_from_seed && self.is_beside_street(proposal.from) {
            return Err(Refused::Crowded);
        }
        let (to, outcome) = self.among_streets(proposal.from, to, reach, line.outcome)?;
        self.check(proposal, to, outcome)?;
        Ok(Judged { to, heading: line.heading, outcome, level: 0 })
    }

    /// Legal area: prunes, or turns by the smallest angle that stays inside, or bridges (PM01 §3.3).
    fn on_legal_ground(&self, proposal: &Proposal) -> Result<Line, Refused> {
        let (from, to) = (proposal.from.metres(), proposal.target);
        let whole = Line { to, heading: proposal.heading, outcome: Outcome::As };
        let share = self.ground.fit_share(from, to);
        if share >= 1.0 {
            return Ok(whole);
        }
        let span = to - from;
        if share >= self.constraints.prune && share * span.length() >= self.constraints.least_length {
            return Ok(Line { to: from + span * share, outcome: Outcome::Shortened, ..whole });
        }
        let turned = self.ground.turns().iter().find_map(|turn| {
            let to = from + span.rotate(turn.unit);
            let is_fit = self.ground.is_fit(from, to);
            is_fit.then(|| Line { to, heading: (whole.heading + turn.by).wrapped(), outcome: Outcome::Turned })
        });
        turned.or_else(|| self.bridged(from, span, &whole)).ok_or(Refused::Illegal)
    }

    fn bridged(&self, from: Vec2, span: Vec2, whole: &Line) -> Option<Line> {
        if self.constraints.bridge <= 0.0 {
            return None;
        }
        let (along, landing) = (span.normalize_or_zero(), self.constraints.least_length);
        let length = self.ground.far_shore(from, along, span.length(), self.constraints.bridge, landing)?;
        Some(Line { to: from + along * length, outcome: Outcome::Bridged, ..*whole })
    }

    /// A bridge passes over the streets below; it needs a free place to come down.
    fn over_bridge(
        &mut self,
        graph: &StreetGraph,
        proposal: &Proposal,
        line: &Line,
        to: Point,
    ) -> Result<Judged, Refused> {
        self.near.gather(graph, Bounds::between(to, to).grown(self.snap.max(tolerance::LAYING)));
        if self.near.has_street_within(to, self.snap.max(tolerance::LAYING)) {
            return Err(Refused::Crowded);
        }
        if graph.first_crossing(proposal.from, to, 1).is_some() {
            return Err(Refused::Duplicate);
        }
        Ok(Judged { to, heading: line.heading, outcome: Outcome::Bridged, level: 1 })
    }

    /// Whether a street passes a seed without touching it: nothing may start so close to it.
    fn is_beside_street(&self, seed: Point) -> bool {
        self.near.has_street_within(seed, self.snap)
            && !self.near.has_node_at(seed)
            && !self.near.has_street_within(seed, tolerance::LAYING)
    }

    /// The end of the forward search for a street to go on to.
    fn extended(&self, proposal: &Proposal, to: Point) -> Point {
        let line = to.metres() - proposal.from.metres();
        let length = line.length();
        let most = if proposal.is_on_raster { self.constraints.least_length } else { self.constraints.extend_most };
        let further = (length * (self.constraints.extend - 1.0)).min(most);
        // Written so that a factor that is not a number extends nothing.
        if further > 0.0 && length > 0.0 { Point::from_metres(to.metres() + line * (further / length)) } else { to }
    }

    /// Crossing, extension and snapping, until they agree.
    fn among_streets(
        &self,
        from: Point,
        to: Point,
        reach: Point,
        outcome: Outcome,
    ) -> Result<(Point, Outcome), Refused> {
        let (mut to, mut reach, mut outcome) = (to, reach, outcome);
        for _ in 0..MOST_PASSES {
            let Some((end, how)) = self.met(from, to, reach) else { return Ok((to, outcome)) };
            if end.distance_squared(to) <= SAME_END * SAME_END {
                let was_settled = outcome.ends_street();
                return Ok((end, if was_settled { outcome } else { how }));
            }
            (to, reach, outcome) = (end, end, how);
        }
        Err(Refused::Unsettled)
    }

    /// The end that the streets around ask for, and how.
    fn met(&self, from: Point, to: Point, reach: Point) -> Option<(Point, Outcome)> {
        let met = self.near.first_met(from, reach, self.snap, self.least);
        let is_ahead = |at: Point| from.distance_squared(at) > from.distance_squared(to);
        if let Some(met) = met.filter(|met| !is_ahead(met.at)) {
            let node = if met.is_node { Some(met.at) } else { self.near.node_within(met.at, self.snap, from) };
            return Some(node.map_or((met.at, Outcome::Crossed), |node| (node, Outcome::Snapped)));
        }
        if let Some(node) = self.near.node_within(to, self.snap, from) {
            return Some((node, Outcome::Snapped));
        }
        if let Some(met) = met {
            let end = self.near.node_within(met.at, self.snap, from).unwrap_or(met.at);
            if self.ground.is_fit(to.metres(), end.metres()) {
                return Some((end, Outcome::Extended));
            }
        }
        let end = self.near.foot_within(to, self.snap, from);
        end.map(|end| (end, Outcome::Snapped))
    }

    /// What holds for every street laid, whatever was adjusted.
    fn check(&self, proposal: &Proposal, to: Point, outcome: Outcome) -> Result<(), Refused> {
        let (from, least) = (proposal.from, i64::from(self.least));
        if from.distance_squared(to) < least * least {
            return Err(Refused::TooShort);
        }
        // Only streets adjusted to others left the line that was tested.
        if outcome.ends_street() && !self.ground.is_fit(from.metres(), to.metres()) {
            return Err(Refused::Illegal);
        }
        if self.near.is_duplicate(from, to, proposal.half_width, self.duplicate) {
            return Err(Refused::Duplicate);
        }
        if self.near.is_sharp(from, to, self.cosine) || self.near.is_sharp(to, from, self.cosine) {
            return Err(Refused::Sharp);
        }
        Ok(())
    }
}
