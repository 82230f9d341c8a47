//! PM01's productions p1–p9 as literal, parallel string rewriting: the oracle for the queue. On open ground without
//! conflicts both accept the same proposals at the same steps.

use super::support::{Rule, at, minors, never, shared, site, slot};
use crate::growth::{Branch, Constraints, GrowthRules, Slot, Slots, Tip, grow};
use crate::{Classes, StreetGraph};
use geom::{Angle, Id, Point, Seed, Vec2};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// `roadAttr`: what a road would be, and its place in the derivation.
#[derive(Clone, Debug)]
struct Road {
    id: Id,
    from: Vec2,
    heading: Angle,
    length: f64,
    age: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Unassigned,
    Succeed,
}

/// A module of the string. Brackets and turtle commands leave no trace in what is compared.
#[derive(Clone, Debug)]
enum Module {
    R(i64),
    B(i64, Road),
    Query(Road, State),
}
use Module::{B, Query, R};

struct Rewriter<'a> {
    tip: Tip,
    rules: &'a dyn GrowthRules,
    settings_seed: Seed,
    /// (step of p8, lineage, end) of all that succeeded.
    accepted: BTreeSet<(u32, Id, Point)>,
}

impl Rewriter<'_> {
    /// `globalGoals`: the slots at a road's end, as (delay, road) or nothing for a negative delay.
    fn goals(&mut self, id: Id, place: Vec2, heading: Angle, age: u32, is_seed: bool) -> Vec<(Branch, i64, Road)> {
        (self.tip.at, self.tip.heading, self.tip.age) = (Point::from_metres(place), heading, age);
        (self.tip.seed, self.tip.slots, self.tip.is_seed) = (self.settings_seed.of(id), Slots::default(), is_seed);
        self.rules.propose(&mut self.tip);
        let slots = self.tip.slots;
        let back = if is_seed { slots.ahead } else { None };
        let all = [
            (Branch::Ahead, slots.ahead),
            (Branch::Left, slots.left),
            (Branch::Right, slots.right),
            (Branch::Back, back),
        ];
        let road = |branch: Branch, length, turn| Road {
            id: id.child(branch.slot()),
            from: self.tip.place(),
            heading: (heading + branch.turn() + turn).wrapped(),
            length,
            age: if branch.goes_on() { age + 1 } else { 1 },
        };
        all.into_iter()
            .filter_map(|(branch, slot)| slot.map(|s| (branch, i64::from(s.delay), road(branch, s.length, s.turn))))
            .collect()
    }

    /// p2's successor string, without the F that is already laid.
    fn successors(goals: Vec<(Branch, i64, Road)>) -> Vec<Module> {
        let (on, branches): (Vec<_>, Vec<_>) = goals.into_iter().partition(|(branch, ..)| branch.goes_on());
        let branches = branches.into_iter().map(|(_, delay, road)| B(delay, road));
        let on = on.into_iter().flat_map(|(_, delay, road)| [R(delay), Query(road, State::Unassigned)]);
        branches.chain(on).collect()
    }

    /// One parallel derivation step: every module is rewritten by the first production that matches the old string.
    fn step(&mut self, string: &[Module], step: u32) -> Vec<Module> {
        let mut next = Vec::new();
        for (i, module) in string.iter().enumerate() {
            let before = i.checked_sub(1).and_then(|before| string.get(before));
            match (before, module, string.get(i + 1)) {
                (_, R(..=-1), _) => {} // p1
                (_, R(0), Some(Query(road, State::Succeed))) => {
                    let end = Point::from_metres(road.from + road.heading.unit() * road.length).metres();
                    let goals = self.goals(road.id, end, road.heading, road.age, false);
                    next.extend(Self::successors(goals)); // p2
                }
                // The delay of a tip runs down as that of a branch does, and its query waits for it.
                (_, R(delay @ 1..), _) => next.push(R(delay - 1)),
                // p3 never matches on open ground.
                (_, R(0), _) => next.push(R(0)),
                (_, B(delay @ 1.., road), _) => next.push(B(delay - 1, road.clone())), // p4
                (_, B(0, road), _) => next.extend([R(0), Query(road.clone(), State::Unassigned)]), // p5
                (_, B(..), _) => {}                                                    // p6
                (Some(R(..=-1)), Query(..), _) => {}                                   // p7
                (Some(R(1..)), Query(road, State::Unassigned), _) => next.push(Query(road.clone(), State::Unassigned)),
                (_, Query(road, State::Unassigned), _) => {
                    let end = Point::from_metres(road.from + road.heading.unit() * road.length);
                    self.accepted.insert((step, road.id, end));
                    next.push(Query(road.clone(), State::Succeed)); // p8, on open ground
                }
                (_, Query(..), _) => {} // p9
            }
        }
        next
    }
}

/// What is drawn for one slot of a rule: how often it is filled, and the delays it may have.
#[derive(Clone, Copy, Debug)]
struct Habit {
    chance: f64,
    delays: (i32, i32),
}

/// A small set of rules: habits of the three slots, by turns for tips of even and odd depth.
type RuleSet = [[Habit; 3]; 2];

/// A tree that never meets itself: each piece is a quarter as long as the one before, which the lowest bit set in a
/// place tells. Which slots are filled, and their delays, are drawn by lineage; below 0 they delete the slot.
fn tree(depth: u32, set: RuleSet) -> Rule<impl Fn(&mut Tip) + Send + Sync + 'static> {
    Rule(move |tip: &mut Tip| {
        let age = if tip.is_seed { 0 } else { 1 + (22 - (tip.at.x | tip.at.y).trailing_zeros()) / 2 };
        if age > depth {
            return;
        }
        let draw = |slot: u64| {
            let Habit { chance, delays: (low, high) } = set[age as usize % 2][slot as usize];
            let delay = low + (tip.seed.unit(slot) * f64::from(high - low + 1)) as i32;
            let drawn = Slot { length: 4096.0 / f64::from(1 << (2 * age)), turn: Angle::ZERO, delay, width: None };
            (tip.seed.unit(10 + slot) < chance).then_some(drawn)
        };
        [tip.slots.ahead, tip.slots.left, tip.slots.right] = [0, 1, 2].map(draw);
    })
}

fn habit() -> impl Strategy<Value = Habit> {
    (0.2..1.0, -2..1, 0..8).prop_map(|(chance, low, more)| Habit { chance, delays: (low, low + more) })
}

/// Times, lineages and ends of what the queue accepts, and of what the string does.
type Derived = BTreeSet<(u32, Id, Point)>;

fn derived(rules: &dyn GrowthRules, steps: u32, chance: u64) -> (Derived, Derived, usize) {
    let fields = shared(site(20_000.0));
    let mut settings = minors();
    (settings.limits.steps, settings.seed) = (steps, Seed(chance));
    let standard = Constraints { longest: 1e5, ..Constraints::default() };
    // Open ground: nothing but the separation of the graph is asked for.
    settings.constraints = Constraints { snap: 0.1, extend: 1.0, duplicate: 0.1, ..standard }.into();
    let seed = settings.seed_point(at(0.0, 0.0), Angle::ZERO, 0);
    let mut graph = StreetGraph::new(Classes::default());
    let log = grow(&mut graph, &settings, rules, &fields, &[seed], &never);
    let queued = log.accepted.iter().map(|a| (a.lineage.time, a.lineage.id, a.end())).collect();

    let mut tip = Tip::new(settings.class, settings.seed, fields);
    (tip.at, tip.heading) = (seed.at, seed.heading);
    let mut rewriter = Rewriter { tip, rules, settings_seed: settings.seed, accepted: BTreeSet::new() };
    let goals = rewriter.goals(seed.root, seed.at.metres(), seed.heading, 0, true);
    let mut string = Rewriter::successors(goals);
    for step in 1..=steps {
        string = rewriter.step(&string, step);
    }
    (queued, rewriter.accepted, log.refusals.total())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]
    #[test]
    fn queue_equals_literal_rewriting(
        chance in any::<u64>(), depth in 1u32..5, steps in 4u32..40,
        habits in prop::collection::vec(habit(), 6),
    ) {
        let set = [[habits[0], habits[1], habits[2]], [habits[3], habits[4], habits[5]]];
        let (queued, rewritten, refused) = derived(&tree(depth, set), steps, chance);
        prop_assert_eq!(refused, 0, "the oracle needs open ground");
        prop_assert_eq!(queued, rewritten);
    }
}

#[test]
fn the_oracle_is_asked_for_more_than_nothing() {
    let all = Habit { chance: 1.0, delays: (-1, 5) };
    let sizes = (0..20).map(|chance| derived(&tree(4, [[all; 3]; 2]), 60, chance).1.len());
    assert!(sizes.sum::<usize>() > 500);
}

#[test]
fn steps_are_those_of_the_string() {
    // A street is tested at 1, 3, 5 ..; a branch with delay d of the tip tested at 1, at 4 + d.
    let rules = Rule(|tip: &mut Tip| {
        if tip.age < 3 && tip.heading == Angle::ZERO {
            tip.slots.ahead = slot(100.0);
            tip.slots.left = (tip.age == 1).then(|| Slot { delay: 7, ..slot(50.0).unwrap() });
        }
    });
    let settings = minors();
    let seed = settings.seed_point(at(0.0, 0.0), Angle::ZERO, 0);
    let mut graph = StreetGraph::new(Classes::default());
    let log = grow(&mut graph, &settings, &rules, &shared(site(5000.0)), &[seed], &never);
    let mut times: Vec<_> = log.accepted.iter().map(|a| (a.lineage.branch, a.lineage.time)).collect();
    times.sort_unstable();
    let ahead = Branch::Ahead;
    assert_eq!(times, [(ahead, 1), (ahead, 3), (ahead, 5), (Branch::Left, 11), (Branch::Back, 1)]);
}
