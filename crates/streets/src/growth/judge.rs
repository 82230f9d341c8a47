//! The local constraints at work: a chain runs until each of its steps agrees to the same line, then what holds for
//! every street laid is tested on that line, in the order of the chain.

use super::chain::{Bridge, Chain, Step};
use super::ground::Ground;
use super::lineage::Proposal;
use super::near::{Met, Near, are_apart};
use super::slots::RimSlots;
use super::{Draft, Fields, Growth, Legal, Outcome, Own, Refused, Slope};
use crate::StreetGraph;
use geom::point::units;
use geom::{Angle, Bounds, Point, Vec2, tolerance};
use std::sync::Arc;

/// Changes by streets around, and changes by any other step, before a proposal is refused as unsettled.
const MOST_PASSES: u8 = 3;

/// Two ends this close (LSB) are the same end: the rounding of a cut, of a foot, and of the segment they lie on.
const SAME_END: i64 = 3;

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
    level: i8,
    /// Whether a street was met: then the end stays what that street asks for.
    is_met: bool,
}

impl Line {
    fn of(proposal: &Proposal) -> Self {
        let (to, heading) = (proposal.target, proposal.heading);
        Self { to, heading, outcome: Outcome::As, level: 0, is_met: false }
    }

    fn point(&self) -> Result<Point, Refused> {
        Point::try_from_metres(self.to).ok_or(Refused::OffLattice)
    }
}

/// What a step says to a line.
enum Answer {
    Agreed,
    Changed(Line),
}

/// What is known of the present line.
#[derive(Default)]
struct Pass {
    /// Steps that agreed to it, as bits.
    agreed: u32,
    /// Whether the streets around agreed to its end.
    is_settled: bool,
    /// What lies ahead, once it was looked for.
    ahead: Option<Option<Met>>,
    /// Where it ends, once it was tested, and how many steps it was held against.
    tested: Option<(Line, Point, usize)>,
}

/// The numbers of a chain that are asked for most. Lengths in LSB.
#[derive(Clone, Copy, Debug)]
struct Numbers {
    snap: i32,
    join: i32,
    least: i32,
    duplicate: i32,
    extend: Option<super::Extend>,
    arms: usize,
}

impl Numbers {
    fn of(chain: &Chain) -> Self {
        let metres = |pick: fn(&Step) -> Option<f64>| units(chain.find(pick).unwrap_or(0.0));
        Self {
            snap: units(chain.snap()),
            join: metres(|step| if let Step::Join(within) = step { Some(*within) } else { None }),
            // Nothing shorter can be laid, whatever is asked for.
            least: units(chain.length().least).max(tolerance::LAYING + 1),
            duplicate: metres(|step| if let Step::Duplicate(duplicate) = step { Some(duplicate.within) } else { None }),
            extend: chain.find(|step| if let Step::Extend(extend) = step { Some(*extend) } else { None }),
            arms: chain.most_arms(),
        }
    }
}

/// The chain, with what it needs of a growth.
#[derive(Debug)]
pub(super) struct Judge<'a> {
    settings: &'a Growth,
    /// The chain as it holds where the present proposal starts.
    chain: Arc<Chain>,
    pub ground: Ground<'a>,
    fields: &'a Arc<Fields>,
    near: Near,
    gathered: Option<Bounds>,
    /// Half of the widest right-of-way in the graph, in LSB.
    widest: i32,
    numbers: Numbers,
    has_crossing: bool,
    has_length: bool,
    /// Why a rule of its own refused the last proposal.
    pub why: Option<Arc<str>>,
}

impl<'a> Judge<'a> {
    pub fn new(graph: &StreetGraph, settings: &'a Growth, fields: &'a Arc<Fields>) -> Self {
        let chain = &settings.constraints;
        Self {
            settings,
            chain: Arc::new(chain.clone()),
            ground: Ground::new(fields, chain),
            fields,
            near: Near::of(settings.class),
            gathered: None,
            widest: graph.segments_unsorted().map(|(_, segment)| segment.half_width()).max().unwrap_or(0),
            numbers: Numbers::of(chain),
            has_crossing: chain.steps().contains(&Step::Crossing),
            has_length: chain.find(|step| matches!(step, Step::Length(_)).then_some(())).is_some(),
            why: None,
        }
    }

    /// The most streets that a crossing may have.
    pub fn most_arms(&self) -> usize {
        self.numbers.arms
    }

    /// Adjusts a proposal to the streets of a graph and the ground, or refuses it.
    pub fn judge(&mut self, graph: &StreetGraph, proposal: &Proposal) -> Result<Judged, Refused> {
        let is_wanted = self.settings.goal.is_met(proposal.target);
        // Nobody lives on water: what leads over it is judged by its far end.
        if !is_wanted && self.ground.is_legal(proposal.target) {
            return Err(Refused::NoDemand);
        }
        self.gathered = None;
        if let Some(chain) = self.settings.constraints.at(proposal.from.metres()) {
            self.ground.adopt(&chain);
            (self.numbers, self.chain) = (Numbers::of(&chain), Arc::new(chain));
        }
        let (line, pass) = self.shaped(graph, proposal)?;
        if !is_wanted && (line.outcome != Outcome::Bridged || !self.settings.goal.is_met(line.to)) {
            return Err(Refused::NoDemand);
        }
        let to = self.tested(graph, proposal, &line, pass)?;
        Ok(Judged { to, heading: line.heading, outcome: line.outcome, level: line.level })
    }

    /// Asks the steps in order, from the first again after each change, until all agree.
    fn shaped(&mut self, graph: &StreetGraph, proposal: &Proposal) -> Result<(Line, Pass), Refused> {
        let chain = Arc::clone(&self.chain);
        let mut line = Line::of(proposal);
        let (mut pass, mut by_streets, mut by_step) = (Pass::default(), 0, [0; super::chain::MOST_STEPS]);
        let mut next = 0;
        while let Some(step) = chain.steps().get(next) {
            let bit = 1 << next;
            if pass.agreed & bit != 0 {
                next += 1;
                continue;
            }
            if matches!(step, Step::Own(_)) && pass.tested.is_none() {
                self.test_before_own(graph, proposal, &line, next, &mut pass)?;
            }
            match self.ask(graph, proposal, step, &mut line, &mut pass)? {
                Answer::Agreed => {
                    pass.agreed |= bit;
                    next += 1;
                }
                Answer::Changed(changed) => {
                    // What was moved by a street is asked of all streets once more, by this step too.
                    let agreed = if changed.is_met { 0 } else { bit };
                    let count = if changed.is_met { &mut by_streets } else { &mut by_step[next] };
                    *count += 1;
                    if *count >= MOST_PASSES {
                        return Err(Refused::Unsettled);
                    }
                    (line, next, pass) = (changed, 0, Pass { agreed, ..Pass::default() });
                }
            }
        }
        Ok((line, pass))
    }

    fn ask(
        &mut self,
        graph: &StreetGraph,
        proposal: &Proposal,
        step: &Step,
        line: &mut Line,
        pass: &mut Pass,
    ) -> Result<Answer, Refused> {
        let changed = match step {
            Step::Own(own) => self.own(own, proposal, line)?,
            // A bridge or a tunnel is held against what it needs when it is made.
            _ if line.level != 0 => None,
            // The ground under a line that a street has led away from where it was is tested, not adjusted to.
            Step::Legal(_) | Step::Slope(_) | Step::Mask(_) if line.is_met => None,
            Step::Legal(legal) => self.on_legal_ground(graph, legal, proposal, line)?,
            Step::Slope(slope) => self.on_gentle_ground(graph, slope, proposal, line)?,
            Step::Mask(_) => self.inside(proposal, line)?,
            Step::Crossing | Step::Snap(_) | Step::Extend(_) | Step::Join(_) => {
                return self.among_streets(graph, proposal, step, line, pass);
            }
            Step::Length(_) | Step::Duplicate(_) | Step::Angle(_) | Step::Arms(_) => None,
        };
        Ok(changed.map_or(Answer::Agreed, Answer::Changed))
    }

    /// Legal area: prunes, or turns by the smallest angle that stays inside, or bridges (PM01 §3.3).
    fn on_legal_ground(
        &self,
        graph: &StreetGraph,
        legal: &Legal,
        proposal: &Proposal,
        line: &Line,
    ) -> Result<Option<Line>, Refused> {
        let from = proposal.from.metres();
        let share = self.ground.legal_share(from, line.to);
        if share >= 1.0 {
            return Ok(None);
        }
        let bridged = || self.bridged(graph, legal.bridge.as_ref()?, from, line);
        if legal.bridge.is_some_and(|bridge| bridge.is_first)
            && let Some(bridged) = bridged()
        {
            return Ok(Some(bridged));
        }
        let span = line.to - from;
        let is_long = share >= legal.prune && share * span.length() >= self.chain.length().least;
        let pruned = || is_long.then(|| Line { to: from + span * share, outcome: Outcome::Shortened, ..*line });
        let turned = || self.turned(self.ground.legal_turns(), from, line);
        let found = if legal.turns_first { turned().or_else(pruned) } else { pruned().or_else(turned) };
        found.or_else(bridged).ok_or(Refused::Illegal).map(Some)
    }

    /// The first of some turns that brings a line onto fit ground.
    fn turned(&self, turns: &[super::ground::Turn], from: Vec2, line: &Line) -> Option<Line> {
        let span = line.to - from;
        turns.iter().find_map(|turn| {
            let to = from + span.rotate(turn.unit);
            let heading = (line.heading + turn.by).wrapped();
            self.ground.is_fit(from, to).then_some(Line { to, heading, outcome: Outcome::Turned, ..*line })
        })
    }

    /// A bridge, or the way to the shore where one can start.
    fn bridged(&self, graph: &StreetGraph, bridge: &Bridge, from: Vec2, line: &Line) -> Option<Line> {
        let span = line.to - from;
        let (along, landing) = (span.normalize_or_zero(), self.chain.length().least);
        let found = self.ground.far_shore(from, along, span.length(), bridge, landing)?;
        let (head, foot) = (from + along * found.start, from + along * found.end);
        if self.is_near_raised(graph, head, bridge.spacing) || self.is_near_raised(graph, foot, bridge.spacing) {
            return None;
        }
        if found.start >= landing.max(self.ground.step()) {
            return Some(Line { to: head, outcome: Outcome::Shortened, ..*line });
        }
        Some(Line { to: foot, outcome: Outcome::Bridged, level: 1, ..*line })
    }

    /// Whether a bridge or a tunnel begins or ends within a distance, in metres, of a place.
    fn is_near_raised(&self, graph: &StreetGraph, place: Vec2, distance: f64) -> bool {
        let (at, reach) = (Point::from_metres(place), units(distance));
        let squared = i64::from(reach) * i64::from(reach);
        let mut is_near = false;
        graph.for_segments_near(Bounds::between(at, at).grown(reach), |key| {
            let (a, b) = graph.line(key.forward());
            is_near |= graph.segment(key).level != 0 && [a, b].iter().any(|end| end.distance_squared(at) < squared);
        });
        is_near
    }

    /// Slope: turns by the smallest angle that is gentle enough, or goes through the hill, or turns back (SCH10 §4.2.3).
    fn on_gentle_ground(
        &self,
        graph: &StreetGraph,
        slope: &Slope,
        proposal: &Proposal,
        line: &Line,
    ) -> Result<Option<Line>, Refused> {
        let from = proposal.from.metres();
        if self.ground.is_gentle(from, line.to) {
            return Ok(None);
        }
        let turned = self.turned(self.ground.slope_turns(), from, line);
        let through = turned.or_else(|| self.tunnelled(graph, slope, from, line));
        through.or_else(|| self.turned(self.ground.hairpins(), from, line)).ok_or(Refused::Steep).map(Some)
    }

    /// A tunnel, or the way to the foot of the hill where one can start.
    fn tunnelled(&self, graph: &StreetGraph, slope: &Slope, from: Vec2, line: &Line) -> Option<Line> {
        let span = line.to - from;
        let (along, least) = (span.normalize_or_zero(), self.chain.length().least);
        let foot = self.ground.gentle_reach(from, line.to);
        let start = if foot >= least.max(self.ground.step()) { from + along * foot } else { from };
        let length = self.ground.way_through(start, along, span.length(), slope.tunnel)?;
        let end = start + along * length;
        if self.is_near_raised(graph, start, least) || self.is_near_raised(graph, end, least) {
            return None;
        }
        Some(match start == from {
            true => Line { to: end, outcome: Outcome::Tunnelled, level: -1, ..*line },
            false => Line { to: start, outcome: Outcome::Shortened, ..*line },
        })
    }

    /// Mask: clips what leads out (SCH10 §4.2.3).
    fn inside(&self, proposal: &Proposal, line: &Line) -> Result<Option<Line>, Refused> {
        let from = proposal.from.metres();
        let share = self.ground.covered_share(from, line.to);
        if share >= 1.0 {
            return Ok(None);
        }
        let to = from + (line.to - from) * share;
        let is_long = share > 0.0 && (to - from).length() >= self.chain.length().least;
        is_long.then_some(Some(Line { to, outcome: Outcome::Shortened, ..*line })).ok_or(Refused::Masked)
    }

    /// Asks a rule.
    fn own(&mut self, own: &Own, proposal: &Proposal, line: &Line) -> Result<Option<Line>, Refused> {
        let mut draft = Draft {
            id: proposal.lineage.id,
            from: proposal.from.metres(),
            to: line.to,
            heading: line.heading,
            class: self.settings.class,
            level: line.level,
            meets_street: line.is_met,
            seed: self.settings.seed.of(proposal.lineage.id),
            fields: Arc::clone(self.fields),
            refused: None,
        };
        own.0.constrain(&mut draft);
        if draft.refused.is_some() {
            self.why = draft.refused;
            return Err(Refused::ByRule);
        }
        if draft.to == line.to {
            return Ok(None);
        }
        // What a bridge or a tunnel was made for would no longer hold.
        if line.level != 0 || !draft.to.is_finite() {
            return Err(Refused::Unsettled);
        }
        let is_turned = draft.heading != line.heading;
        let outcome = if is_turned { Outcome::Turned } else { Outcome::Shortened };
        Ok(Some(Line { to: draft.to, heading: draft.heading, outcome, level: 0, is_met: false }))
    }

    /// Crossing, snapping, extension, joining: the first of them with an answer decides.
    fn among_streets(
        &mut self,
        graph: &StreetGraph,
        proposal: &Proposal,
        step: &Step,
        line: &mut Line,
        pass: &mut Pass,
    ) -> Result<Answer, Refused> {
        // Whatever else asks for an end: a street that is crossed on the way is asked, too.
        if pass.is_settled && *step != Step::Crossing {
            return Ok(Answer::Agreed);
        }
        let (from, to) = (proposal.from, line.point()?);
        let reach = if line.is_met { to } else { self.extended(proposal, to) };
        self.gather(graph, proposal, reach)?;
        let found = match step {
            Step::Crossing => self.crossed(proposal, to, reach, pass),
            Step::Snap(_) => self.near.node_within(to, self.numbers.snap, from).map(|node| (node, Outcome::Snapped)),
            Step::Extend(_) => self.gone_on(proposal, to, reach, pass),
            _ => {
                let foot = self.near.foot_within(to, self.numbers.join, from, &self.slots(proposal));
                foot.map(|foot| (foot, Outcome::Snapped))
            }
        };
        let Some((end, how)) = found else { return Ok(Answer::Agreed) };
        let outcome = if line.is_met { line.outcome } else { how };
        let met = Line { to: end.metres(), outcome, is_met: true, ..*line };
        if end.distance_squared(to) <= SAME_END * SAME_END {
            (*line, pass.is_settled, pass.tested) = (met, true, None);
            return Ok(Answer::Agreed);
        }
        Ok(Answer::Changed(Line { outcome: how, ..met }))
    }

    /// The streets around a line; a seed beside a street is refused. Once for each box.
    fn gather(&mut self, graph: &StreetGraph, proposal: &Proposal, reach: Point) -> Result<(), Refused> {
        self.widest = self.widest.max(proposal.half_width);
        let margin = self.numbers.snap.max(self.numbers.join).max(tolerance::LAYING);
        let apart = self.numbers.duplicate.max(proposal.half_width.saturating_add(self.widest));
        let around = Bounds::between(proposal.from, reach);
        if self.gathered.is_some_and(|known| known.contains(around.min) && known.contains(around.max)) {
            return Ok(());
        }
        let is_first = self.gathered.is_none();
        self.gathered = Some(around.grown(margin));
        self.near.gather(graph, around.grown(margin.saturating_add(margin.max(apart))));
        if is_first && proposal.is_from_seed && self.is_beside_street(proposal.from) {
            return Err(Refused::Crowded);
        }
        Ok(())
    }

    /// Whether a street passes a seed without touching it: nothing may start so close to it.
    fn is_beside_street(&self, seed: Point) -> bool {
        self.near.has_street_within(seed, self.numbers.snap)
            && !self.near.has_node_at(seed)
            && !self.near.has_street_within(seed, tolerance::LAYING)
    }

    /// The end of the forward search for a street to go on to.
    fn extended(&self, proposal: &Proposal, to: Point) -> Point {
        let Some(extend) = self.numbers.extend else { return to };
        let line = to.metres() - proposal.from.metres();
        let length = line.length();
        let most = if proposal.is_on_raster() { self.chain.length().least } else { extend.most };
        let further = (length * (extend.factor - 1.0)).min(most);
        // Written so that a factor that is not a number extends nothing.
        if further > 0.0 && length > 0.0 { Point::from_metres(to.metres() + line * (further / length)) } else { to }
    }

    fn ahead(&self, proposal: &Proposal, reach: Point, pass: &mut Pass) -> Option<Met> {
        let snap = self.numbers.snap.max(tolerance::LAYING);
        let (line, least) = ((proposal.from, reach), self.numbers.least);
        *pass.ahead.get_or_insert_with(|| self.near.first_met(line, snap, least, &self.slots(proposal)))
    }

    fn slots<'p>(&self, proposal: &'p Proposal) -> RimSlots<'p> {
        RimSlots::new(proposal, self.numbers.snap)
    }

    /// The first street on the way, or the crossing close to it.
    fn crossed(&self, proposal: &Proposal, to: Point, reach: Point, pass: &mut Pass) -> Option<(Point, Outcome)> {
        let (from, met) = (proposal.from, self.ahead(proposal, reach, pass)?);
        if met.away > from.distance_squared(to) {
            return None;
        }
        let close = || self.near.node_within(met.at, self.numbers.snap, from);
        let node = if met.is_node { Some(met.at) } else { close() };
        // Not to a crossing on the far side of the street that is met.
        let node = node.filter(|&node| !self.near.is_crossed(from, node));
        Some(node.map_or((met.at, Outcome::Crossed), |node| (node, Outcome::Snapped)))
    }

    /// The first street a little beyond the end.
    fn gone_on(&self, proposal: &Proposal, to: Point, reach: Point, pass: &mut Pass) -> Option<(Point, Outcome)> {
        let (from, met) = (proposal.from, self.ahead(proposal, reach, pass)?);
        if met.away <= from.distance_squared(to) {
            return None;
        }
        let end = self.near.node_within(met.at, self.numbers.snap, from).unwrap_or(met.at);
        self.ground.is_fit(to.metres(), end.metres()).then_some((end, Outcome::Extended))
    }

    /// Holds a line against the steps before a rule's own: most that are refused need no rule to say so.
    fn test_before_own(
        &mut self,
        graph: &StreetGraph,
        proposal: &Proposal,
        line: &Line,
        own: usize,
        pass: &mut Pass,
    ) -> Result<(), Refused> {
        let is_test =
            |step: &Step| matches!(step, Step::Length(_) | Step::Duplicate(_) | Step::Angle(_) | Step::Arms(_));
        let chain = Arc::clone(&self.chain);
        let before = &chain.steps()[..own];
        if before.iter().any(is_test) {
            let (line, to) = self.landed(graph, proposal, line)?;
            before.iter().try_for_each(|step| self.check(step, proposal, &line, to))?;
            pass.tested = Some((line, to, own));
        }
        Ok(())
    }

    /// What holds for every street laid, whatever was adjusted. The end, on a street that it would touch otherwise.
    fn tested(&mut self, graph: &StreetGraph, proposal: &Proposal, line: &Line, pass: Pass) -> Result<Point, Refused> {
        let (line, to, done) = match pass.tested {
            Some(tested) => tested,
            None => {
                let (line, to) = self.landed(graph, proposal, line)?;
                (line, to, 0)
            }
        };
        if !self.has_length {
            self.check_length(proposal.from, to)?;
        }
        let chain = Arc::clone(&self.chain);
        for step in &chain.steps()[done..] {
            self.check(step, proposal, &line, to)?;
        }
        if self.ground.is_in_site(to.metres()) { Ok(to) } else { Err(Refused::Illegal) }
    }

    /// A line with its end where the insertion will find it.
    fn landed(&mut self, graph: &StreetGraph, proposal: &Proposal, line: &Line) -> Result<(Line, Point), Refused> {
        let (mut line, mut to) = (*line, line.point()?);
        if line.level != 0 {
            self.is_free_to_land(graph, proposal, to, line.level)?;
        } else {
            self.gather(graph, proposal, to)?;
            let end = self.touching(proposal, to);
            line.is_met |= end != to;
            to = end;
        }
        Ok((line, to))
    }

    /// A bridge passes over the streets below; it needs a free place to come down. A tunnel likewise.
    fn is_free_to_land(
        &mut self,
        graph: &StreetGraph,
        proposal: &Proposal,
        to: Point,
        level: i8,
    ) -> Result<(), Refused> {
        // A tip may have come to lie a sample's width off the legal area: no bridge begins there.
        if !self.ground.is_legal(proposal.from.metres()) || !self.ground.is_legal(to.metres()) {
            return Err(Refused::Illegal);
        }
        let apart = self.numbers.snap.max(tolerance::LAYING);
        self.near.gather(graph, Bounds::between(proposal.from, to).grown(apart));
        if self.near.has_street_within(to, apart) {
            return Err(Refused::Crowded);
        }
        if self.meets_level(graph, proposal.from, to, level) { Err(Refused::Duplicate) } else { Ok(()) }
    }

    /// Whether a line would touch one of its level other than at its start: it would be given a crossing in the air, or
    /// in the hill.
    fn meets_level(&self, graph: &StreetGraph, from: Point, to: Point, level: i8) -> bool {
        let mut meets = false;
        graph.for_segments_near(Bounds::between(from, to).grown(tolerance::LAYING), |key| {
            let (a, b) = graph.line(key.forward());
            let goes_on = a == from || b == from;
            meets |= graph.segment(key).level == level && !goes_on && !are_apart((from, to), (a, b));
        });
        meets
    }

    /// The end that the insertion would give a line: on whatever lies closer than the laying distance.
    fn touching(&self, proposal: &Proposal, to: Point) -> Point {
        let (from, reach) = (proposal.from, tolerance::LAYING);
        if self.numbers.snap >= reach && self.numbers.join >= reach {
            return to;
        }
        let node = self.near.node_within(to, reach, from);
        node.or_else(|| self.near.foot_within(to, reach, from, &self.slots(proposal))).unwrap_or(to)
    }

    fn check_length(&self, from: Point, to: Point) -> Result<(), Refused> {
        let least = i64::from(self.numbers.least);
        if from.distance_squared(to) < least * least { Err(Refused::TooShort) } else { Ok(()) }
    }

    fn check(&self, step: &Step, proposal: &Proposal, line: &Line, to: Point) -> Result<(), Refused> {
        let (from, is_on_ground) = (proposal.from, line.level == 0);
        let (start, end) = (from.metres(), to.metres());
        // Only a line that streets were adjusted to has left what its ground agreed to.
        let has_left = line.is_met && is_on_ground;
        let (is_kept, reason) = match step {
            Step::Length(_) => return self.check_length(from, to),
            Step::Legal(_) => (!has_left || self.ground.legal_share(start, end) >= 1.0, Refused::Illegal),
            Step::Slope(_) => (!has_left || self.ground.is_gentle(start, end), Refused::Steep),
            Step::Mask(_) => (!has_left || self.ground.covered_share(start, end) >= 1.0, Refused::Masked),
            Step::Duplicate(duplicate) => {
                let near = &self.near;
                let runs_along = || near.runs_along(from, to, proposal.half_width, self.numbers.duplicate);
                let is_one_too_many = || {
                    near.is_duplicate(from, to, proposal.half_width, self.numbers.duplicate)
                        || (duplicate.is_whole && runs_along())
                };
                (!is_on_ground || !is_one_too_many(), Refused::Duplicate)
            }
            Step::Angle(least) => (!self.is_sharp(from, to, least.cos(), is_on_ground), Refused::Sharp),
            Step::Arms(most) => (self.near.has_room(from, to, *most, is_on_ground), Refused::Full),
            Step::Crossing | Step::Snap(_) | Step::Extend(_) | Step::Join(_) | Step::Own(_) => return Ok(()),
        };
        if is_kept { Ok(()) } else { Err(reason) }
    }

    fn is_sharp(&self, from: Point, to: Point, cosine: f64, is_on_ground: bool) -> bool {
        self.near.is_sharp(from, to, cosine)
            || self.near.is_sharp(to, from, cosine)
            || (is_on_ground && self.near.is_sharp_between(from, to, cosine, !self.has_crossing))
    }
}
