//! Chains: what each step does is gone when it is dropped, and constraints of a rule's own stand among the others.

use super::adjusting::{eastward, land, only, refused};
use super::support::{at, minors, site};
use crate::growth::{
    Area, Chain, Constrain, Constraints, Draft, Fields, Growth, GrowthLog, Length, Outcome, Own, Refused, Step,
};
use geom::{Angle, Point, Polygon, Vec2};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

fn with(chain: Chain) -> Growth {
    Growth { constraints: chain, ..minors() }
}

fn without(is_dropped: impl Fn(&Step) -> bool) -> Growth {
    with(Chain::default().without(is_dropped))
}

fn among(given: &[(Point, Point)], settings: &Growth) -> GrowthLog {
    eastward(given, 100.0, site(1000.0), settings).1
}

/// Where it ends, and how.
fn end(log: &GrowthLog) -> (Point, Outcome) {
    (only(log).0.end(), only(log).1)
}

#[test]
fn without_crossing_streets_go_on_over_others() {
    let across = [(at(50.0, -50.0), at(50.0, 50.0))];
    assert_eq!(end(&among(&across, &minors())), (at(50.0, 0.0), Outcome::Crossed));
    let settings = without(|step| *step == Step::Crossing);
    let (graph, log) = eastward(&across, 100.0, site(1000.0), &settings);
    assert_eq!(end(&log), (at(100.0, 0.0), Outcome::As));
    assert_eq!(graph.degree(graph.nearest_node(at(50.0, 0.0), 3).expect("a crossing").0), 4);
}

#[test]
fn without_crossing_angles_and_arms_hold_where_streets_cross() {
    let step = Angle::degrees(20.0).unit() * 100.0;
    let slanted = [(at(50.0 - step.x, -step.y), at(50.0 + step.x, step.y))];
    let settings = without(|step| matches!(step, Step::Crossing | Step::Duplicate(_)));
    assert_eq!(refused(&among(&slanted, &settings)), Refused::Sharp);
    let across = [(at(50.0, -50.0), at(50.0, 50.0))];
    let three = Growth { constraints: settings.constraints.with(Step::Arms(3)), ..minors() };
    assert_eq!(refused(&among(&across, &three)), Refused::Full);
}

#[test]
fn without_snap_and_join_ends_stay_where_they_are() {
    let corner = [(at(100.0, 4.0), at(100.0, 80.0)), (at(100.0, 4.0), at(180.0, 40.0))];
    let no_extension = |step: &Step| matches!(step, Step::Extend(_));
    let kept = without(no_extension);
    assert_eq!(end(&among(&corner, &kept)), (at(100.0, 4.0), Outcome::Snapped));
    let no_snap = without(|step| no_extension(step) || matches!(step, Step::Snap(_)));
    assert_eq!(end(&among(&corner, &no_snap)), (at(100.0, 4.0), Outcome::Snapped), "joined");
    let neither = without(|step| no_extension(step) || matches!(step, Step::Snap(_) | Step::Join(_)));
    assert_eq!(end(&among(&corner, &neither)), (at(100.0, 0.0), Outcome::As));
}

#[test]
fn without_extend_streets_end_before_others() {
    let ahead = [(at(120.0, -50.0), at(120.0, 50.0))];
    assert_eq!(end(&among(&ahead, &minors())), (at(120.0, 0.0), Outcome::Extended));
    let settings = without(|step| matches!(step, Step::Extend(_)));
    assert_eq!(end(&among(&ahead, &settings)), (at(100.0, 0.0), Outcome::As));
}

#[test]
fn the_order_decides_where_a_street_goes() {
    // A street beside the end that comes closer, and one across a little ahead.
    let given = [(at(40.0, 9.0), at(240.0, -11.0)), (at(110.0, -50.0), at(110.0, 50.0))];
    let steps = without(|step| matches!(step, Step::Duplicate(_) | Step::Angle(_))).constraints.steps().to_vec();
    assert!(matches!(steps[5..], [Step::Extend(_), Step::Join(_)]));
    let run = |steps: Vec<Step>| end(&among(&given, &with(Chain::new(steps))));
    assert_eq!(run(steps.clone()), (at(110.0, 2.0), Outcome::Extended));
    let swapped = [&steps[..5], &steps[6..], &steps[5..6]].concat();
    let (to, outcome) = run(swapped);
    // From (100.3, 3.0) to the next of the slots, 5.25 m apart: the multiple of 25 cm above the snapping distance.
    assert!(outcome == Outcome::Snapped && (to.metres() - Vec2::new(99.75, 3.025)).length() < 0.1, "{to:?}");
}

#[test]
fn without_duplicate_streets_may_run_side_by_side() {
    let beside = [(at(-10.0, 5.5), at(200.0, 5.5))];
    assert_eq!(refused(&among(&beside, &minors())), Refused::Duplicate);
    assert_eq!(end(&among(&beside, &without(|step| matches!(step, Step::Duplicate(_))))).1, Outcome::As);
}

#[test]
fn without_angle_streets_may_meet_sharply() {
    let step = Angle::degrees(23.0).unit() * 100.0;
    let slanted = [(at(70.0 - step.x, -step.y), at(70.0 + step.x, step.y))];
    assert_eq!(refused(&among(&slanted, &minors())), Refused::Sharp);
    assert_eq!(end(&among(&slanted, &without(|step| matches!(step, Step::Angle(_))))).1, Outcome::Crossed);
}

#[test]
fn without_length_only_the_separation_is_left() {
    let close = [(at(6.0, -50.0), at(6.0, 50.0))];
    assert_eq!(refused(&among(&close, &minors())), Refused::TooShort);
    let settings = without(|step| matches!(step, Step::Length(_) | Step::Snap(_) | Step::Join(_)));
    assert_eq!(end(&among(&close, &settings)), (at(6.0, 0.0), Outcome::Crossed));
    let short = Length { least: 8.0, longest: 40.0 };
    let settings = with(Chain::new(vec![Step::Length(short)]));
    assert_eq!(end(&among(&[], &settings)), (at(40.0, 0.0), Outcome::As), "cut to the longest");
}

#[test]
fn without_legal_streets_enter_the_water_but_never_leave_the_site() {
    let wet = || land(|x, _| x > 40.0);
    assert_eq!(refused(&eastward(&[], 100.0, wet(), &minors()).1), Refused::Illegal);
    let settings = without(|step| matches!(step, Step::Legal(_)));
    assert_eq!(end(&eastward(&[], 100.0, wet(), &settings).1), (at(100.0, 0.0), Outcome::As));
    assert_eq!(refused(&eastward(&[], 300.0, wet(), &settings).1), Refused::Illegal);
}

#[test]
fn masks_clip_to_polygons_and_maps() {
    let corners = [at(-50.0, -50.0), at(60.0, -50.0), at(60.0, 50.0), at(-50.0, 50.0)];
    let polygon = Step::Mask(Area::Polygon(Arc::new(Polygon::new(corners.to_vec(), Vec::new()))));
    let settings = with(Chain::default().with(polygon));
    let (to, outcome) = end(&among(&[], &settings));
    assert_eq!((to, outcome), (at(60.0, 0.0), Outcome::Shortened));
    assert_eq!(end(&among(&[], &minors())).1, Outcome::As, "dropped, it does nothing");
    let map = land(|x, _| x > 30.0).legal.remove(0);
    let named = |name: &str| with(Chain::default().with(Step::Mask(Area::Map(name.into()))));
    let fields = || Fields { maps: [("dry".to_owned(), crate::growth::Field::Map(map.clone()))].into(), ..site(200.0) };
    let to = end(&eastward(&[], 100.0, fields(), &named("dry")).1).0.metres().x;
    assert!((29.0..=30.0).contains(&to), "{to}");
    assert_eq!(end(&eastward(&[], 100.0, fields(), &named("other")).1).1, Outcome::As);
}

#[test]
fn what_a_street_leads_out_of_a_mask_is_refused() {
    let corners = [at(-50.0, -50.0), at(100.0, -50.0), at(100.0, 50.0), at(-50.0, 50.0)];
    let polygon = Step::Mask(Area::Polygon(Arc::new(Polygon::new(corners.to_vec(), Vec::new()))));
    // The street ahead is out of the mask: no extension; a crossing beside the end is out, too: no snapping.
    let settings = with(Chain::default().with(polygon));
    assert_eq!(end(&among(&[(at(110.0, -50.0), at(110.0, 50.0))], &settings)), (at(100.0, 0.0), Outcome::As));
    let outside = [(at(103.0, 2.0), at(150.0, 60.0))];
    assert_eq!(refused(&among(&outside, &settings)), Refused::Masked);
}

#[test]
fn arms_keep_crossings_small() {
    let corner =
        [(at(100.0, 0.0), at(100.0, 80.0)), (at(100.0, 0.0), at(180.0, 0.0)), (at(100.0, 0.0), at(100.0, -80.0))];
    let limited = |most| with(Chain::default().with(Step::Arms(most)));
    assert_eq!(refused(&among(&corner, &limited(3))), Refused::Full);
    assert_eq!(end(&among(&corner, &limited(4))), (at(100.0, 0.0), Outcome::Snapped));
    // A crossing in the middle of a street has three arms.
    let across = [(at(50.0, -50.0), at(50.0, 50.0))];
    assert_eq!(refused(&among(&across, &limited(2))), Refused::Full);
}

/// A constraint as a function, with how often it was asked.
struct Asked<F>(F, AtomicUsize);

impl<F> std::fmt::Debug for Asked<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a rule")
    }
}

impl<F: Fn(&mut Draft) + Send + Sync> Constrain for Asked<F> {
    fn constrain(&self, draft: &mut Draft) {
        self.1.fetch_add(1, Ordering::Relaxed);
        (self.0)(draft);
    }
}

fn own(rule: fn(&mut Draft)) -> Step {
    Step::Own(Own(Arc::new(Asked(rule, AtomicUsize::new(0)))))
}

#[test]
fn a_rule_of_its_own_accepts_changes_and_refuses() {
    let run = |rule: fn(&mut Draft)| among(&[], &with(Chain::default().with(own(rule))));
    assert_eq!(end(&run(|_| {})), (at(100.0, 0.0), Outcome::As));
    assert_eq!(end(&run(|draft| draft.cut_to(30.0_f64.min(draft.length())))), (at(30.0, 0.0), Outcome::Shortened));
    let turned = run(|draft| {
        if draft.heading.abs().to_degrees() < 1.0 {
            draft.turn(Angle::degrees(90.0));
        }
    });
    assert_eq!(end(&turned), (at(0.0, 100.0), Outcome::Turned));
    assert_eq!(end(&run(|draft| draft.end_at(Vec2::new(80.0, 10.0)))), (at(80.0, 10.0), Outcome::Turned));
    let log = run(|draft| draft.refuse("no".into()));
    assert_eq!(refused(&log), Refused::ByRule);
    assert_eq!(log.reasons.iter().map(|(why, count)| (&**why, *count)).collect::<Vec<_>>(), [("no", 1)]);
}

#[test]
fn what_a_rule_moves_is_tested_like_anything_else() {
    let run = |given: &[(Point, Point)], fields: Fields, rule: fn(&mut Draft)| {
        eastward(given, 100.0, fields, &with(Chain::default().with(own(rule)))).1
    };
    // Into the water: pruned by the legal area, to which the rule then agrees.
    let log = run(&[], land(|x, _| x > 120.0), |draft| {
        if draft.length() < 101.0 && draft.to.x > 99.0 {
            draft.cut_to(150.0);
        }
    });
    let (to, outcome) = end(&log);
    assert!(outcome == Outcome::Shortened && (119.0..=120.0).contains(&to.metres().x), "{to:?}");
    // Across a street: it ends there.
    let log = run(&[(at(-50.0, 40.0), at(50.0, 40.0))], site(500.0), |draft| {
        if !draft.meets_street {
            draft.end_at(Vec2::new(0.0, 90.0));
        }
    });
    assert_eq!(end(&log), (at(0.0, 40.0), Outcome::Crossed));
    // A rule that never agrees to its own answer is not asked for ever.
    let log = run(&[(at(50.0, -50.0), at(50.0, 50.0))], site(500.0), |draft| {
        draft.end_at(Vec2::new(90.0, if draft.to.y < 1.0 { 20.0 } else { -20.0 }));
    });
    assert_eq!(refused(&log), Refused::Unsettled);
    assert_eq!(refused(&run(&[], site(500.0), |draft| draft.end_at(Vec2::new(f64::NAN, 0.0)))), Refused::Unsettled);
}

#[test]
fn a_rule_is_asked_once_for_what_nobody_changes() {
    let rule = Arc::new(Asked(|_: &mut Draft| {}, AtomicUsize::new(0)));
    let settings = with(Chain::default().with(Step::Own(Own(rule.clone()))));
    among(&[], &settings);
    assert_eq!(rule.1.load(Ordering::Relaxed), 1);
    among(&[(at(50.0, -50.0), at(50.0, 50.0))], &settings);
    assert_eq!(rule.1.load(Ordering::Relaxed), 2, "asked of the street as it was cut");
}

#[test]
fn chains_have_an_end_and_say_what_they_hold() {
    let chain = Chain::new(vec![Step::Crossing; 100]);
    assert_eq!(chain.steps().len(), crate::growth::MOST_STEPS);
    let empty = Chain::new(Vec::new());
    assert_eq!((empty.snap(), empty.least_angle(), empty.length().least), (0.0, None, 0.0));
    let standard = Chain::from(Constraints { snap: 7.0, ..Constraints::default() });
    assert_eq!((standard.snap(), standard.length()), (7.0, Length { least: 8.0, longest: 1000.0 }));
    assert_eq!(end(&among(&[], &with(empty))), (at(100.0, 0.0), Outcome::As));
}
