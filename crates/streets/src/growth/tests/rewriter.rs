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
    R,
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
        branches.chain(on.into_iter().flat_map(|(.., road)| [R, Query(road, State::Unassigned)])).collect()
    }

    /// One parallel derivation step: every module is rewritten by the first production that matches the old string.
    fn step(&mut self, string: &[Module], step: u32) -> Vec<Module> {
        let mut next = Vec::new();
        for (i, module) in string.iter().enumerate() {
            match (module, string.get(i + 1)) {
                (R, Some(Query(road, State::Succeed))) => {
                    let end = Point::from_metres(road.from + road.heading.unit() * road.length).metres();
                    let goals = self.goals(road.id, end, road.heading, road.age, false);
                    next.extend(Self::successors(goals)); // p2
                }
                // p3 and p7 never match on open ground, nor do p1 and p6 where absent slots make no module.
                (R, _) => next.push(R),
                (B(delay, road), _) if *delay > 0 => next.push(B(delay - 1, road.clone())), // p4
                (B(0, road), _) => next.extend([R, Query(road.clone(), State::Unassigned)]), // p5
                (B(..), _) => {}                                                            // p6
                (Query(road, State::Unassigned), _) => {
                    let end = Point::from_metres(road.from + road.heading.unit() * road.length);
                    self.accepted.insert((step, road.id, end));
                    next.push(Query(road.clone(), State::Succeed)); // p8, on open ground
                }
                (Query(..), _) => {} // p9
            }
        }
        next
    }
}

/// A tree that never meets itself: each piece is a quarter as long as the one before, which the lowest bit set in a
/// place tells. Which slots are filled, and their delays, are drawn by lineage.
fn tree(depth: u32) -> Rule<impl Fn(&mut Tip) + Send + Sync + 'static> {
    Rule(move |tip: &mut Tip| {
        let age = if tip.is_seed { 0 } else { 1 + (22 - (tip.at.x | tip.at.y).trailing_zeros()) / 2 };
        if age > depth {
            return;
        }
        let draw = |slot: u64| {
            let delay = (tip.seed.unit(slot) * 7.0) as i32;
            let drawn = Slot { length: 4096.0 / f64::from(1 << (2 * age)), turn: Angle::ZERO, delay, width: None };
            (tip.is_seed || tip.seed.unit(10 + slot) < 0.8).then_some(drawn)
        };
        let slots = [draw(0).map(|ahead| Slot { delay: 0, ..ahead }), draw(1), draw(2)];
        [tip.slots.ahead, tip.slots.left, tip.slots.right] = slots;
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn queue_equals_literal_rewriting(chance in any::<u64>(), depth in 1u32..5, steps in 4u32..30) {
        let rules = tree(depth);
        let fields = shared(site(20_000.0));
        let mut settings = minors();
        (settings.limits.steps, settings.seed) = (steps, Seed(chance));
        let standard = Constraints { longest: 1e5, ..Constraints::default() };
        // Open ground: nothing but the separation of the graph is asked for.
        settings.constraints = Constraints { snap: 0.1, extend: 1.0, duplicate: 0.1, ..standard }.into();
        let seed = settings.seed_point(at(0.0, 0.0), Angle::ZERO, 0);
        let mut graph = StreetGraph::new(Classes::default());
        let log = grow(&mut graph, &settings, &rules, &fields, &[seed], &never);
        prop_assert_eq!(log.refusals.total(), 0, "the oracle needs open ground");
        let queued: BTreeSet<_> = log.accepted.iter().map(|a| (a.lineage.time, a.lineage.id, a.end())).collect();

        let mut tip = Tip::new(settings.class, settings.seed, fields.clone());
        (tip.at, tip.heading) = (seed.at, seed.heading);
        let mut rewriter = Rewriter { tip, rules: &rules, settings_seed: settings.seed, accepted: BTreeSet::new() };
        let goals = rewriter.goals(seed.root, seed.at.metres(), seed.heading, 0, true);
        let mut string = Rewriter::successors(goals);
        for step in 1..=steps {
            string = rewriter.step(&string, step);
        }
        prop_assert!(rewriter.accepted.len() > 2);
        prop_assert_eq!(queued, rewriter.accepted);
    }
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
