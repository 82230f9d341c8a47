use super::*;
use crate::growth::tests::support::{Rule, at, grid, minors, never, shared, site, slot, winding};
use crate::growth::{Field, grow};
use crate::{Classes, StreetGraph};
use geom::{Point, Raster, Seed};
use proptest::prelude::*;
use std::sync::Arc;

fn part(rules: impl GrowthRules + Send + 'static, weight: Weight) -> BlendPart {
    BlendPart { rules: Box::new(rules), weight }
}

fn number(weight: f64) -> Weight {
    Weight::Number(weight)
}

fn field(heading: f64, folds: u32) -> Rule<impl Fn(&mut Tip) + Sync + Send + 'static> {
    Rule(move |tip: &mut Tip| {
        tip.steer(Steer::Cross { heading: Angle::degrees(heading), folds });
        tip.slots.ahead = slot(50.0);
    })
}

/// A pattern with these slots and no field of its own.
fn fixed(slots: Slots) -> Rule<impl Fn(&mut Tip) + Sync + Send + 'static> {
    Rule(move |tip: &mut Tip| tip.slots = slots)
}

fn tip(heading: f64) -> Tip {
    let mut tip = Tip::new(Classes::MINOR, Seed(1), shared(site(1000.0)));
    (tip.heading, tip.width) = (Angle::degrees(heading), 16.0);
    tip
}

fn proposed(parts: Vec<BlendPart>, heading: f64) -> Tip {
    let mut tip = tip(heading);
    Blend::of(parts).propose(&mut tip);
    tip
}

fn steered(parts: Vec<BlendPart>, heading: f64) -> f64 {
    proposed(parts, heading).steered().wrapped().to_degrees().round()
}

#[test]
fn a_pattern_of_all_the_weight_answers_alone() {
    let alone = |rules: &dyn GrowthRules| {
        let settings = minors();
        let seed = settings.seed_point(at(3.0, -2.0), Angle::degrees(20.0), 0);
        let mut graph = StreetGraph::new(Classes::default());
        let log = grow(&mut graph, &settings, rules, &shared(site(500.0)), &[seed], &never);
        (graph.digest(), log)
    };
    let raster = || grid(Angle::degrees(-29.0), 200.0, 80.0);
    let blend = Blend::of;
    let nothing = || Weight::Map(Field::Constant(0.0));
    assert!(alone(&blend(vec![part(raster(), number(0.3)), part(winding(), nothing())])) == alone(&raster()));
    assert!(alone(&blend(vec![part(raster(), nothing()), part(winding(), number(2.0))])) == alone(&winding()));
    // Nothing has weight: the basic rule, which is the first.
    assert!(alone(&blend(vec![part(winding(), nothing()), part(raster(), nothing())])) == alone(&winding()));
}

#[test]
fn headings_blend_as_fields_not_as_angles() {
    let halves =
        |a: (f64, u32), b: (f64, u32)| vec![part(field(a.0, a.1), number(0.5)), part(field(b.0, b.1), number(0.5))];
    assert_eq!(steered(halves((350.0, 1), (10.0, 1)), 200.0), 0.0);
    assert_eq!(steered(halves((80.0, 4), (20.0, 4)), 1.0), 5.0);
    assert_eq!(steered(halves((0.0, 4), (20.0, 1)), 10.0), 10.0);
    // A raster acts as its cross.
    let raster = grid(Angle::degrees(10.0), 100.0, 100.0);
    assert_eq!(steered(vec![part(raster, number(1.0)), part(field(30.0, 4), number(1.0))], 95.0), 110.0);
}

#[test]
fn what_cancels_out_is_led_by_one() {
    let parts = |a, b| vec![part(field(0.0, 1), number(a)), part(field(180.0, 1), number(b))];
    assert_eq!(steered(parts(0.55, 0.45), 90.0), 0.0);
    assert_eq!(steered(parts(0.45, 0.55), 90.0), 180.0);
    let mut later = tip(90.0);
    later.lead = Some(0);
    let blend = Blend::of(parts(0.45, 0.55));
    blend.propose(&mut later);
    assert_eq!((later.steered().to_degrees().round(), later.slots.lead), (0.0, Some(0)), "it keeps its lead");
    later.lead = Some(0);
    Blend::of(parts(0.4, 0.6)).propose(&mut later);
    assert_eq!(later.slots.lead, Some(1), "but not against much more weight");
}

#[test]
fn slots_are_weighted_means_of_those_who_propose_them() {
    let with = |length, delay, width| Some(Slot { length, turn: Angle::ZERO, delay, width });
    let one = Slots { ahead: with(100.0, 2, Some(20.0)), left: with(60.0, 0, None), ..Slots::default() };
    let other = Slots { ahead: with(40.0, 6, None), right: with(70.0, 0, None), ..Slots::default() };
    let tip = proposed(vec![part(fixed(one), number(3.0)), part(fixed(other), number(1.0))], 10.0);
    let ahead = tip.slots.ahead.unwrap();
    assert_eq!((ahead.length, ahead.delay, ahead.width), (85.0, 3, Some(19.0)));
    assert_eq!(tip.slots.left.map(|slot| slot.length), Some(60.0), "three quarters want it");
    assert_eq!(tip.slots.right, None, "one quarter does not");
    let deleted = Slots { left: with(60.0, -1, None), ..one };
    let tip = proposed(vec![part(fixed(deleted), number(3.0)), part(fixed(other), number(1.0))], 10.0);
    assert_eq!(tip.slots.left, None);
}

#[test]
fn streets_carry_the_rule_that_leads() {
    struct Named(u16);
    impl GrowthRules for Named {
        fn propose(&self, tip: &mut Tip) {
            tip.slots.ahead = slot(50.0);
        }
        fn origin(&self) -> u16 {
            self.0
        }
    }
    let west = (0..200).map(|cell| if cell % 20 < 10 { 1.0 } else { 0.0 }).collect();
    let west = Raster::new(20, 10, 100.0, Vec2::splat(-1000.0), west).unwrap();
    let west = Weight::Map(Field::Map(Arc::new(west)));
    let blend = Blend::of(vec![part(Named(5), west.clone()), part(Named(6), Weight::Inverse(Box::new(west)))]);
    let settings = minors();
    let seed = settings.seed_point(at(0.0, 0.0), Angle::ZERO, 0);
    let mut graph = StreetGraph::new(Classes::default());
    let log = grow(&mut graph, &settings, &blend, &shared(site(900.0)), &[seed], &never);
    for accepted in &log.accepted {
        let (x, origin) = (accepted.start().x, accepted.line.claim.origin);
        assert!(x.abs() < 200 * 1024 || origin == if x < 0 { 5 } else { 6 }, "{accepted:?}");
    }
}

/// Weights that swing over a kilometre and more.
fn swinging(phase: f64) -> Weight {
    let value = |i: usize| {
        let at = Vec2::new((i % 100) as f64, (i / 100) as f64) * 40.0;
        (0.5 + 0.5 * Angle::radians((at.x + 0.5 * at.y) / 900.0 + phase).sin()) as f32
    };
    let raster = Raster::new(100, 100, 40.0, Vec2::splat(-2000.0), (0..10_000).map(value).collect()).unwrap();
    Weight::Map(Field::Map(Arc::new(raster)))
}

/// What may jump: which arm of each symmetry is nearest, and whether the fields agree.
fn symmetry(blend: &Blend, tip: &Tip) -> (Vec<i64>, bool) {
    let mut tip = tip.clone();
    let weighed = blend.weighed(tip.place());
    let voices: Voices = weighed.into_iter().map(|(part, weight)| blend.voice(part, weight, &mut tip)).collect();
    let proposing = proposing(&voices, |slots| slots.ahead);
    let groups = groups(&proposing, Angle::ZERO);
    let near: Vec<Angle> = groups.iter().map(|group| group.nearest(tip.heading)).collect();
    let sum: Vec2 = groups.iter().zip(&near).map(|(group, near)| near.unit() * group.sum.length()).sum();
    // A symmetry of its own that cancels out points anywhere.
    let agrees = |group: &Group| {
        let all = voices.iter().filter(|voice| voice.folds == group.folds).map(|voice| voice.weight).sum::<f64>();
        group.sum.length() >= LEAST_AGREEMENT * all
    };
    (
        near.iter().map(|angle| (angle.to_degrees() / 15.0).round() as i64).collect(),
        sum.length() >= LEAST_AGREEMENT && groups.iter().all(agrees),
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Along any street the blended heading turns by less than 15° in 50 m, but where a symmetry must jump: where the
    /// fields cancel out (the sum is short: no continuous choice exists between two crosses 45° apart), and where the
    /// nearest arm of one symmetry becomes another arm.
    #[test]
    fn blended_headings_are_continuous(
        headings in [0.0..360.0, 0.0..360.0], folds in prop::sample::select(vec![(1, 1), (2, 2), (4, 4), (1, 4), (2, 4)]),
        phase in 0.0..6.3, start in 0.0..360.0,
    ) {
        let weight = swinging(phase);
        let inverse = Weight::Inverse(Box::new(weight.clone()));
        let parts = vec![part(field(headings[0], folds.0), weight), part(field(headings[1], folds.1), inverse)];
        let blend = Blend::of(parts);
        let mut tip = tip(start);
        // A start of any heading: the street first turns onto the field.
        for _ in 0..8 {
            blend.propose(&mut tip);
            (tip.heading, tip.lead) = (tip.steered(), tip.slots.lead);
        }
        let mut before = symmetry(&blend, &tip);
        for _ in 0..200 {
            let mut next = tip.clone();
            next.at = Point::from_metres(tip.place() + tip.heading.unit() * 10.0);
            blend.propose(&mut next);
            let turn = (next.steered() - tip.heading).wrapped().abs().to_degrees();
            let after = symmetry(&blend, &next);
            let jumps = !before.1 || !after.1 || before.0.iter().zip(&after.0).any(|(a, b)| (a - b).abs() > 1);
            prop_assert!(turn < 3.0 || jumps, "{turn}° in 10 m at {:?}: {before:?} {after:?}", tip.place());
            let heading = next.steered();
            (tip, before) = (next, after);
            (tip.heading, tip.lead) = (heading, tip.slots.lead);
            if tip.place().abs().max_element() > 1900.0 {
                break;
            }
        }
    }
}
