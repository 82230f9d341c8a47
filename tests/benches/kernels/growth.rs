//! Growth: with rules in Rust and the same in Rhai, with a constraint of one's own, and quarters on two threads.

use super::{is_asked, table};
use geom::point::units;
use geom::{Angle, Bounds, Id, Point, Seed, Vec2};
use rayon::prelude::*;
use script::{ConstraintPattern, Faults, Host, Source, StreetPattern};
use std::sync::Arc;
use std::time::Instant;
use streets::faces::{FaceKind, Faces};
use streets::graph::{Crowding, NewSegment};
use streets::growth::{
    Chain, Constrain, Draft, Fields, Growth, GrowthRules, Own, QuarterSettings, Slot, Steer, Step, Tip, grow,
    grow_quarter,
};
use streets::{Claim, Classes, NodeId, StreetGraph, StreetId};

/// No street of the bench is as long: the constraint is asked of each and agrees.
const LONGEST: f64 = 400.0;

/// Quarters of the bench on threads, and the side of each in metres.
const QUARTERS: i32 = 16;
const QUARTER: f64 = 2000.0;

pub fn tables() {
    let faults = Arc::new(Faults::default());
    let rhai = grid_in_rhai(&faults);
    let (standard, none) = (Growth::new(Classes::MINOR, units(8.0), Seed(1), Id::root("bench", &[])), Vec::new());
    let with = |own: Vec<Step>| {
        let steps = standard.constraints.steps().iter().cloned().chain(own).collect();
        Growth { constraints: Chain::new(steps), ..standard.clone() }
    };
    let in_rust = Step::Own(Own(Arc::new(Short)));
    let in_rhai = Step::Own(Own(Arc::new(own_in_rhai(&faults))));
    table("growth, grid rule in Rust", "segments", |size| grown(size, &with(none.clone()), &Grid));
    table("growth, grid rule in Rhai", "segments", |size| grown(size, &with(none.clone()), &rhai));
    let own = [in_rust, in_rhai].map(|step| with(vec![step]));
    table("growth, grid rule and a constraint in Rust", "segments", |size| grown(size, &own[0], &Grid));
    table("growth, grid rule and a constraint in Rhai", "segments", |size| grown(size, &own[1], &rhai));
    quarters_on_threads(&own[1], &rhai);
    assert!(faults.is_empty());
}

fn grid_in_rhai(faults: &Arc<Faults>) -> StreetPattern {
    let rule = Host::new(Vec::new()).rule("streets/grid").expect("the library has a grid");
    let rule = rule.with_text("heading", "0").and_then(|rule| rule.with_text("block_length", "250"));
    let rule = rule.expect("the grid has these parameters");
    StreetPattern::new(rule, 0, Arc::new(Classes::default()), faults.clone())
}

fn own_in_rhai(faults: &Arc<Faults>) -> ConstraintPattern {
    let text = format!(
        "params(#{{ longest: metres({LONGEST}).range(0, 1000).about(\"Longest street\") }});
        fn constrain(segment, p) {{ if segment.length > p.longest {{ segment.refuse(\"too long\"); }} }}"
    );
    let source = Source { text, path: "short.rhai".into() };
    let rule = Host::new(Vec::new()).rule_of("short", &source).expect("a rule");
    ConstraintPattern::new(rule, Arc::default(), faults.clone())
}

/// The same in Rust.
#[derive(Debug)]
struct Short;

impl Constrain for Short {
    fn constrain(&self, draft: &mut Draft) {
        if (draft.to - draft.from).length() > LONGEST {
            draft.refused = Some("too long".into());
        }
    }
}

/// Grows about `size` segments on open land.
fn grown(size: usize, growth: &Growth, rules: &dyn GrowthRules) -> (usize, f64) {
    let side = (size as f64 / 2.0 * 250.0 * 80.0).sqrt();
    let fields = open_land(side);
    let seed = growth.seed_point(Point::from_metres(Vec2::splat(side / 2.0)), Angle::ZERO, 0);
    let mut graph = StreetGraph::new(Classes::default());
    let started = Instant::now();
    let log = grow(&mut graph, growth, rules, &fields, &[seed], &|| false);
    (log.accepted.len(), started.elapsed().as_secs_f64())
}

fn open_land(side: f64) -> Arc<Fields> {
    Arc::new(Fields::plain(Bounds { min: Point::new(0, 0), max: Point::from_metres(Vec2::splat(side)) }))
}

/// The same quarters filled on one thread and on two: best of five each, taken in turns.
fn quarters_on_threads(growth: &Growth, rules: &StreetPattern) {
    let name = "quarters on threads, rules in Rhai";
    if !is_asked(name) {
        return;
    }
    println!("{name}");
    let graph = lattice_of_majors();
    let (fields, settings) = (open_land(QUARTER * f64::from(QUARTERS)), QuarterSettings::new(growth.clone()));
    let faces = Faces::of(&graph, FaceKind::Quarter);
    let fill = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let started = Instant::now();
        let each = |face| grow_quarter(&graph, face, &settings, rules, &fields, &|| false).log.accepted.len();
        let count: usize = pool.install(|| faces.faces.par_iter().map(each).sum());
        (count, started.elapsed().as_secs_f64())
    };
    let runs: Vec<_> = (0..5).map(|_| [1, 2].map(fill)).collect();
    let best = [0, 1].map(|k| runs.iter().map(|run| run[k].1).fold(f64::INFINITY, f64::min));
    let count = runs[0][0].0;
    println!("  {count:>8} segments in {} quarters", faces.faces.len());
    println!(
        "  one thread {:.1} ms, two {:.1} ms: {:.2} times as fast",
        best[0] * 1e3,
        best[1] * 1e3,
        best[0] / best[1]
    );
}

fn lattice_of_majors() -> StreetGraph {
    let mut graph = StreetGraph::new(Classes::default());
    let side = QUARTER * f64::from(QUARTERS);
    let lines = (0..=QUARTERS).map(|k| 100.0 + f64::from(k) * (side - 200.0) / f64::from(QUARTERS)).flat_map(|at| {
        let [near, far] = [100.0, side - 100.0];
        [(Vec2::new(at, near), Vec2::new(at, far)), (Vec2::new(near, at), Vec2::new(far, at))]
    });
    for (k, (from, to)) in lines.enumerate() {
        let id = Id::root("majors", &[k as u128]);
        let street = StreetId(id);
        let claim = Claim { street, class: Classes::MAJOR, half_width: units(13.0), origin: 0, forward: true };
        let (from_id, to_id) = (NodeId(id.child(0)), NodeId(id.child(1)));
        let (from, to) = (Point::from_metres(from), Point::from_metres(to));
        let new = NewSegment { from, to, from_id, to_id, claim, level: 0 };
        graph.insert(&new, Crowding::Refuse).expect("majors fit");
    }
    graph
}

/// What `rules/streets/grid.rhai` says, in Rust.
struct Grid;

impl GrowthRules for Grid {
    fn propose(&self, tip: &mut Tip) {
        let heading = Angle::ZERO;
        tip.steer(Steer::Raster { heading, along: 250.0, across: 80.0, origin: Vec2::ZERO });
        let along = tip.runs_along(heading);
        let slot = |length: f64| Some(Slot { length, turn: Angle::ZERO, delay: 0, width: None });
        tip.slots.ahead = slot(if along { 250.0 } else { 80.0 });
        tip.slots.left = slot(if along { 80.0 } else { 250.0 });
        tip.slots.right = tip.slots.left;
    }

    fn origin(&self) -> u16 {
        0
    }
}
