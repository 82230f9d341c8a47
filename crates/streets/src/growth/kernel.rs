//! The derivation loop (PM01 §3.1, p1–p9) over a priority queue, and growth in a graph shared by all its streets.

use super::demand::Demand;
use super::judge::{Judge, Judged};
use super::lineage::{Aim, Origin, Proposal, node_of, street_of_seed};
use super::queue::Queue;
use super::seat::{Seat, seats};
use super::{
    Accepted, Branch, Fields, Growth, GrowthLog, GrowthRules, Home, Outcome, Refused, RefusedProposal, SeedPoint, Slot,
    Slots, Steer, Stopped, Tip,
};
use crate::StreetGraph;
use crate::graph::{Claim, Crowding, Insertion, NewSegment, NodeKey};
use geom::{Angle, Id, Point};
use std::sync::Arc;

/// How many proposals are tested between two looks at the cancel handle.
const CANCEL_EVERY: u32 = 256;

/// Grows streets in a graph from seeds, all at once, in the order of a sequential derivation.
///
/// The result depends on nothing but the arguments; when `cancel` answers true, the log says
/// [`Stopped::Cancelled`] and what was grown is not to be used.
pub fn grow(
    graph: &mut StreetGraph,
    settings: &Growth,
    rules: &dyn GrowthRules,
    fields: &Arc<Fields>,
    seeds: &[SeedPoint],
    cancel: &dyn Fn() -> bool,
) -> GrowthLog {
    let home = seeds.first().map_or_else(Home::default, |seed| Home { at: seed.at.metres(), heading: seed.heading });
    let mut grower = Grower::new(graph, settings, rules, fields, cancel).at_home(home);
    for seed in seeds {
        if !grower.plant(seed, &|_, _| true) {
            grower.log.seeds_refused += 1;
        }
    }
    grower.run();
    grower.log
}

/// One derivation.
pub(super) struct Grower<'a> {
    pub graph: &'a mut StreetGraph,
    pub log: GrowthLog,
    pub settings: &'a Growth,
    rules: &'a dyn GrowthRules,
    judge: Judge<'a>,
    demand: Demand<'a>,
    pub tip: Tip,
    queue: Queue,
    cancel: &'a dyn Fn() -> bool,
    tested: u32,
}

impl<'a> Grower<'a> {
    pub fn new(
        graph: &'a mut StreetGraph,
        settings: &'a Growth,
        rules: &'a dyn GrowthRules,
        fields: &'a Arc<Fields>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let tip = Tip::new(settings.class, settings.seed, Arc::clone(fields));
        let judge = Judge::new(graph, settings, fields);
        Self {
            graph,
            log: GrowthLog::default(),
            settings,
            rules,
            judge,
            demand: Demand::new(&settings.goal),
            tip,
            queue: Queue::default(),
            cancel,
            tested: 0,
        }
    }

    /// Says where the growth is at home.
    pub fn at_home(mut self, home: Home) -> Self {
        self.tip.home = home;
        self
    }

    /// Starts a street at a seed, or at the place near it that the raster of its rule asks for. Whether there was a
    /// place: a legal one that `allowed` admits, where the rule proposes something.
    pub fn plant(&mut self, seed: &SeedPoint, allowed: &dyn Fn(&StreetGraph, Point) -> bool) -> bool {
        let Some(slots) = self.ask_seed(seed.root, seed.at, seed.heading) else { return false };
        let is_raster = slots.steer.is_some_and(|steer| steer.settles());
        let steer = slots.steer.unwrap_or(Steer::Cross { heading: seed.heading, folds: 1 });
        let seat = seats(steer, seed.at, seed.heading)
            .into_iter()
            .find(|seat| self.judge.ground.is_legal(seat.at.metres()) && allowed(self.graph, seat.at));
        let Some(seat) = seat else { return false };
        if is_raster && self.ask_seed(seed.root, seat.at, seat.heading).is_none() {
            return false;
        }
        self.sprout(seed.root, &seat);
        true
    }

    /// What the rule proposes at a seed; `None` when nothing.
    fn ask_seed(&mut self, root: Id, at: Point, heading: Angle) -> Option<Slots> {
        self.ask(&self.origin_of_seed(root, at, heading));
        (!self.tip.slots.is_empty()).then_some(self.tip.slots)
    }

    /// The seed counts as a tip accepted one step before the axiom's query is tested, so that its street is tested at
    /// step 1.
    fn origin_of_seed(&self, root: Id, at: Point, heading: Angle) -> Origin {
        Origin {
            id: root,
            node: node_of(root),
            at,
            heading,
            street: street_of_seed(root),
            half_width: self.settings.half_width,
            age: 0,
            length: 0.0,
            generation: 0,
            lead: None,
            is_reversed: false,
            fired: 0,
        }
    }

    /// Queues what the rule has just proposed at a seed.
    fn sprout(&mut self, root: Id, seat: &Seat) {
        let origin = self.origin_of_seed(root, seat.at, seat.heading);
        if seat.is_between_crossings {
            (self.tip.slots.left, self.tip.slots.right) = (None, None);
        }
        self.queue_successors(&origin);
    }

    /// Runs the derivation to its end. A second call goes on after further seeds.
    pub fn run(&mut self) {
        while let Some(proposal) = self.queue.pop() {
            if let Some(stopped) = self.must_stop(&proposal) {
                self.log.stopped = Some(stopped);
                self.queue.clear();
                return;
            }
            match self.judge(&proposal).and_then(|judged| self.lay(&proposal, &judged)) {
                Ok(Some(end)) => self.succeed(&end),
                Ok(None) => {}
                Err(reason) => self.refuse(&proposal, reason),
            }
        }
    }

    fn judge(&mut self, proposal: &Proposal) -> Result<Judged, Refused> {
        let middle = proposal.from.metres().midpoint(proposal.target);
        if !self.demand.is_left_at(middle) || !self.demand.is_left_at(proposal.target) {
            return Err(Refused::NoDemand);
        }
        self.judge.judge(self.graph, proposal)
    }

    fn must_stop(&mut self, proposal: &Proposal) -> Option<Stopped> {
        self.tested = self.tested.wrapping_add(1);
        if self.tested % CANCEL_EVERY == 1 && (self.cancel)() {
            return Some(Stopped::Cancelled);
        }
        let limits = self.settings.limits;
        let is_over = self.log.accepted.len() >= limits.segments || proposal.lineage.time > limits.steps;
        is_over.then_some(Stopped::Limit)
    }

    /// Inserts an accepted proposal. The end to go on from, unless the street ends there.
    fn lay(&mut self, proposal: &Proposal, judged: &Judged) -> Result<Option<Origin>, Refused> {
        let line = self.line(proposal, judged);
        let insertion = self.insert(&line)?;
        let ends = (insertion.path.first(), insertion.path.last());
        let (Some(&first), Some(&last)) = ends else { return Err(Refused::TooShort) };
        let end = if proposal.is_reversed { first } else { last };
        self.record(proposal, judged, line, [first, last], end);
        let laid = [proposal.from.metres(), self.graph.at(end).metres()];
        self.demand.serve(laid[0], laid[1]);
        let ends_street = judged.outcome.ends_street() || self.graph.degree(end) > 1;
        Ok((!ends_street).then(|| Origin {
            id: proposal.lineage.id,
            node: self.graph.node(end).id,
            at: self.graph.at(end),
            heading: judged.heading,
            street: proposal.lineage.street,
            half_width: proposal.half_width,
            age: proposal.age + 1,
            length: proposal.length + (laid[1] - laid[0]).length(),
            generation: proposal.generation,
            lead: proposal.lead,
            is_reversed: proposal.is_reversed,
            fired: proposal.lineage.time.saturating_add(1),
        }))
    }

    /// Inserts a line, unless a crossing on it then has more streets than it may: insertion can lead several together.
    fn insert(&mut self, line: &NewSegment) -> Result<Insertion, Refused> {
        let most = self.judge.most_arms();
        let mut refused = Refused::Full;
        let inserted = self.graph.attempt(|graph| match graph.insert(line, Crowding::Refuse) {
            Ok(insertion) => insertion.path.iter().all(|&node| graph.degree(node) <= most).then_some(insertion),
            Err(refusal) => {
                refused = refusal.into();
                None
            }
        });
        inserted.ok_or(refused)
    }

    fn line(&self, proposal: &Proposal, judged: &Judged) -> NewSegment {
        let start = (proposal.from, proposal.from_id);
        let end = (judged.to, node_of(proposal.lineage.id));
        let (from, to) = if proposal.is_reversed { (end, start) } else { (start, end) };
        NewSegment {
            from: from.0,
            to: to.0,
            from_id: from.1,
            to_id: to.1,
            claim: Claim {
                street: proposal.lineage.street,
                class: self.settings.class,
                half_width: proposal.half_width,
                origin: self.rules.origin_of(proposal.lead),
                forward: true,
            },
            level: judged.level,
        }
    }

    /// Notes what was laid, with the ends it really has.
    fn record(&mut self, proposal: &Proposal, judged: &Judged, line: NewSegment, ends: [NodeKey; 2], end: NodeKey) {
        let [from, to] = ends.map(|end| self.graph.node(end));
        let line = NewSegment { from: from.at, to: to.at, from_id: from.id, to_id: to.id, ..line };
        let met_unforeseen = !judged.outcome.ends_street() && self.graph.degree(end) > 1;
        let outcome = if met_unforeseen { Outcome::Snapped } else { judged.outcome };
        let is_reversed = proposal.is_reversed;
        let proposed = Point::try_from_metres(proposal.target).unwrap_or(judged.to);
        self.log.accepted.push(Accepted { lineage: proposal.lineage, line, is_reversed, outcome, proposed });
    }

    fn refuse(&mut self, proposal: &Proposal, reason: Refused) {
        let why = self.judge.why.take();
        self.log.count(reason, why.as_ref());
        if self.settings.records_refusals {
            let (lineage, from) = (proposal.lineage, proposal.from);
            let to = Point::try_from_metres(proposal.target).unwrap_or(from);
            self.log.refused.push(RefusedProposal { lineage, from, to, reason, why });
        }
    }

    /// Asks the rule at the end of an accepted proposal.
    pub fn succeed(&mut self, origin: &Origin) {
        self.ask(origin);
        self.queue_successors(origin);
    }

    /// Asks the rule at a tip; it is a seed where nothing was derived before.
    pub fn ask(&mut self, origin: &Origin) {
        let tip = &mut self.tip;
        tip.id = origin.id;
        (tip.at, tip.heading, tip.age, tip.is_seed) = (origin.at, origin.heading, origin.age, origin.fired == 0);
        (tip.length, tip.generation, tip.step) = (origin.length, origin.generation, origin.fired);
        (tip.width, tip.lead) = (2.0 * f64::from(origin.half_width) / Point::UNITS_PER_METRE, origin.lead);
        tip.seed = self.settings.seed.of(origin.id);
        tip.slots = Slots::default();
        self.rules.propose(tip);
    }

    /// Queues what the rule has proposed at a tip.
    pub fn queue_successors(&mut self, origin: &Origin) {
        let (slots, steered) = (self.tip.slots, self.tip.steered());
        let length = self.settings.constraints.length_at(origin.at.metres());
        let aim = Aim { steer: slots.steer, longest: length.longest, least: length.least, lead: slots.lead };
        let back = if self.tip.is_seed { slots.ahead } else { None };
        let successors = [
            (Branch::Ahead, slots.ahead),
            (Branch::Left, slots.left),
            (Branch::Right, slots.right),
            (Branch::Back, back),
        ];
        let mut wait = None;
        for (branch, slot) in successors {
            let Some(mut slot) = slot.and_then(Slot::kept) else { continue };
            // What leaves a seed or a given street starts a street of its own.
            let is_side = !branch.goes_on() && origin.fired > 0;
            if !aim.leads(origin.at.metres(), steered + branch.turn() + slot.turn, is_side) {
                continue;
            }
            let width = || self.settings.widths.as_ref().map(|widths| widths.at(origin.at.metres()));
            slot.width = slot.width.or_else(width);
            if !branch.goes_on() {
                let wait = *wait.get_or_insert_with(|| self.demand.delay(origin.at.metres()));
                slot.delay = slot.delay.saturating_add_unsigned(wait);
            }
            match Proposal::new(origin, steered, branch, &slot, &aim) {
                Some(proposal) => self.queue.push(proposal),
                None => self.log.refusals.count(Refused::Malformed),
            }
        }
    }
}
