//! What one call of a rule costs: `cargo bench -p script`. Prints nanoseconds of processor time, the median of several rounds.
#![allow(missing_docs, clippy::disallowed_methods, clippy::unwrap_used)]

#[path = "../tests/suite/common.rs"]
mod common;

use common::{rule, tip};
use script::{BlockContext, BuildingPattern, Faults, Host, ParcelPattern, Rule, ShapeContext, StreetPattern};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;
use streets::Classes;
use streets::growth::GrowthRules;

const ROUNDS: usize = 5;
/// Many: the system counts processor time in steps of some milliseconds.
const CALLS: u32 = 200_000;

/// Nanoseconds that this thread has spent on a processor (Linux): other programs do not count.
fn on_processor() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

fn round(work: &mut impl FnMut()) -> f64 {
    let (start, spent) = (Instant::now(), on_processor());
    (0..CALLS).for_each(|_| work());
    let elapsed = start.elapsed().as_nanos() as f64;
    on_processor().zip(spent).map_or(elapsed, |(end, start)| end - start) / f64::from(CALLS)
}

fn median(mut work: impl FnMut()) -> f64 {
    let mut rounds: Vec<f64> = (0..ROUNDS).map(|_| round(&mut work)).collect();
    rounds.sort_by(f64::total_cmp);
    rounds[ROUNDS / 2]
}

fn streets(name: &str, rule: Rule) {
    let pattern = pattern(rule);
    let mut tip = tip(10.0);
    let nanoseconds = median(|| {
        pattern.propose(&mut tip);
        black_box(&tip.slots);
    });
    println!("{name:<40} {nanoseconds:>8.0} ns");
}

fn pattern(rule: Rule) -> StreetPattern {
    StreetPattern::new(rule, 0, Arc::new(Classes::default()), Arc::new(Faults::default()))
}

fn two_threads(rule: Rule) {
    let pattern = pattern(rule);
    let run = |threads: usize| {
        let start = Instant::now();
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    let mut tip = tip(10.0);
                    (0..CALLS).for_each(|_| pattern.propose(&mut tip));
                });
            }
        });
        threads as f64 / start.elapsed().as_secs_f64()
    };
    println!("{:<40} {:>8.2} ×", "two threads against one", run(2) / run(1));
}

fn main() {
    let host = Host::new(vec![]);
    let grid = host.rule("streets/grid").unwrap();
    streets("streets/grid: propose", grid.clone());
    streets("nothing", rule("fn propose(tip, p) { }").unwrap());
    streets("tip.ahead(100)", rule("fn propose(tip, p) { tip.ahead(100); }").unwrap());
    streets("p.a, a parameter", rule("params(#{ a: metres(3) }); fn propose(tip, p) { p.a; }").unwrap());
    streets("global::X, a constant", rule("const X = 3; fn propose(tip, p) { global::X; }").unwrap());
    two_threads(grid);
    let faults = Arc::new(Faults::default());
    let seed = geom::Seed(1);
    let place = geom::Vec2::ZERO;
    let parcels = ParcelPattern::new(host.rule("parcels/recursive").unwrap(), faults.clone());
    let block = BlockContext { density: 1000.0, place, ..BlockContext::bare(9000.0, seed) };
    println!("{:<40} {:>8.0} ns", "parcels/recursive", median(|| _ = black_box(parcels.choose(block.clone()))));
    let buildings = BuildingPattern::new(host.rule("buildings/extruded").unwrap(), faults.clone());
    let shape = ShapeContext { density: 9000.0, place, ..ShapeContext::bare(500.0, seed) };
    println!("{:<40} {:>8.0} ns", "buildings/extruded", median(|| _ = black_box(buildings.choose(shape.clone()))));
    assert!(faults.is_empty(), "{:?}", faults.sorted());
}
