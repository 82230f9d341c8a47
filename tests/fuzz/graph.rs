//! Mutation fuzz of the street graph: random insertions and removals of hard inputs, held against the contract.
//!
//! `PLAT_FUZZ_OPS=1000000 cargo test -p suite --release fuzz_graph` runs the long version.

use geom::Bounds;
use geom::{Id, Point, Seed, predicates, tolerance};
use streets::graph::{CheckLevel, Crowding, NewSegment};
use streets::{Claim, Class, Classes, NodeId, NodeKey, StreetGraph, StreetId};

/// Draws for one run, one after the other.
struct Draws {
    seed: Seed,
    next: u64,
}

impl Draws {
    fn below(&mut self, n: i64) -> i64 {
        self.next += 1;
        (self.seed.child(self.next).0 % n as u64) as i64
    }

    fn between(&mut self, low: i64, high: i64) -> i64 {
        low + self.below(high - low + 1)
    }
}

/// Where and how densely a run draws.
#[derive(Clone, Copy, Debug)]
enum Style {
    Scattered,
    Lattice,
    Stack,
    Star,
    NearMiss,
}

const STYLES: [Style; 5] = [Style::Scattered, Style::Lattice, Style::Stack, Style::Star, Style::NearMiss];

fn draw_point(draws: &mut Draws, style: Style, size: i64, graph: &StreetGraph) -> Point {
    let anywhere = |draws: &mut Draws| Point::new(draws.between(-size, size) as i32, draws.between(-size, size) as i32);
    match style {
        Style::Scattered => anywhere(draws),
        Style::Lattice => {
            let pitch = (size / 8).max(1);
            Point::new((draws.between(-8, 8) * pitch) as i32, (draws.between(-8, 8) * pitch) as i32)
        }
        Style::Stack => Point::new(draws.between(-size, size) as i32, (draws.between(-1, 1) * 70) as i32),
        Style::Star if draws.below(2) == 0 => Point::new(draws.between(-1, 1) as i32, draws.between(-1, 1) as i32),
        Style::Star => anywhere(draws),
        Style::NearMiss => match graph.nodes_unsorted().nth(draws.below(graph.node_count().max(1) as i64) as usize) {
            None => anywhere(draws),
            Some((_, near)) => {
                let near = near.at;
                Point::new(near.x + draws.between(-90, 90) as i32, near.y + draws.between(-90, 90) as i32)
            }
        },
    }
}

fn draw_segment(draws: &mut Draws, size: i64, graph: &StreetGraph) -> NewSegment {
    let style = STYLES[draws.below(STYLES.len() as i64) as usize];
    let other = STYLES[draws.below(STYLES.len() as i64) as usize];
    let end_style = if draws.below(2) == 0 { style } else { other };
    let id = Id::root("fuzz", &[u128::from(draws.seed.0), u128::from(draws.next)]);
    NewSegment {
        from: draw_point(draws, style, size, graph),
        to: draw_point(draws, end_style, size, graph),
        from_id: NodeId(id.child(1)),
        to_id: NodeId(id.child(2)),
        claim: Claim {
            street: StreetId(id),
            class: Class(draws.below(3) as u8),
            half_width: 1024 * draws.between(3, 9) as i32,
            origin: 0,
            forward: true,
        },
        level: if draws.below(8) == 0 { 1 } else { 0 },
    }
}

/// O(n²) check of V1 and V2 in exact integers.
fn brute_force(graph: &StreetGraph) -> Result<(), String> {
    let nodes: Vec<NodeKey> = graph.nodes_by_id();
    let segments = graph.segments_by_id();
    let apart = i64::from(tolerance::SEPARATION).pow(2);
    for (i, &a) in nodes.iter().enumerate() {
        if graph.degree(a) == 0 {
            return Err(format!("node {a:?} has no segment"));
        }
        for &b in &nodes[..i] {
            if graph.at(a).distance_squared(graph.at(b)) < apart {
                return Err(format!("nodes {:?} {:?} too close", graph.at(a), graph.at(b)));
            }
        }
        for &s in &segments {
            let segment = graph.segment(s);
            let (p, q) = graph.line(s.forward());
            let counts = segment.level == 0 || graph.has_level(a, segment.level);
            if counts && !segment.ends.contains(&a) && predicates::within(p, q, graph.at(a), tolerance::SEPARATION) {
                return Err(format!("node {:?} too close to {p:?} {q:?}", graph.at(a)));
            }
        }
    }
    for (i, &s) in segments.iter().enumerate() {
        let (a, b) = graph.line(s.forward());
        for &t in &segments[..i] {
            let (one, two) = (graph.segment(s), graph.segment(t));
            let (c, d) = graph.line(t.forward());
            let shared = one.ends.iter().filter(|end| two.ends.contains(end)).count();
            if one.level != two.level {
                continue;
            }
            if shared == 2 || (shared == 0 && predicates::meets(a, b, c, d)) {
                return Err(format!("segments {a:?} {b:?} and {c:?} {d:?} meet"));
            }
        }
    }
    Ok(())
}

#[derive(Default, Debug)]
struct Tally {
    inserted: usize,
    refused: usize,
    removed: usize,
    restored: usize,
}

fn fuzz(seed: u64, operations: usize, size: i64, most: usize, tally: &mut Tally) {
    let mut draws = Draws { seed: Seed(seed), next: 0 };
    let mut graph = StreetGraph::new(Classes::default());
    for step in 0..operations {
        let context = || format!("seed {seed} size {size} step {step}");
        let streets = graph.streets();
        if !streets.is_empty() && (draws.below(4) == 0 || graph.segment_count() > most) {
            graph.remove_street(streets[draws.below(streets.len() as i64) as usize]);
            tally.removed += 1;
        } else {
            let new = draw_segment(&mut draws, size, &graph);
            let is_trial = draws.below(3) == 0;
            let crowding = if is_trial || draws.below(2) == 0 { Crowding::Refuse } else { Crowding::Join };
            let before = graph.digest();
            match graph.insert(&new, crowding) {
                Ok(_) => tally.inserted += 1,
                Err(_) => {
                    tally.refused += 1;
                    assert_eq!(graph.digest(), before, "a refusal changed the graph: {}", context());
                }
            }
            if is_trial {
                brute_force(&graph).unwrap_or_else(|e| panic!("{e}: {} (trial)", context()));
                graph.remove_street(new.claim.street);
                assert_eq!(graph.digest(), before, "insert, then remove: {}", context());
                tally.restored += 1;
            }
        }
        brute_force(&graph).unwrap_or_else(|e| panic!("{e}: {}", context()));
        // The contract's own check, all of it; the one above knows nothing of it, and so guards it.
        assert_eq!(graph.check(CheckLevel::Brute), Vec::new(), "{}", context());
    }
}

fn operations() -> usize {
    std::env::var("PLAT_FUZZ_OPS").ok().and_then(|n| n.parse().ok()).unwrap_or(20_000)
}

/// What an operation between two places may have touched, checked.
fn check_around(graph: &StreetGraph, from: Point, to: Point, context: &dyn Fn() -> String) {
    let segments = graph.segments_near(Bounds::between(from, to).grown(1_000));
    let mut nodes: Vec<NodeKey> = segments.iter().flat_map(|&key| graph.segment(key).ends).collect();
    nodes.sort_unstable();
    nodes.dedup();
    assert_eq!(graph.check_touched(&nodes, &segments), Vec::new(), "{}", context());
}

/// Operations on one large graph. Near misses are drawn near what is there, so its clusters grow with its history:
/// many graphs show more than one that ends as a single knot.
const LARGE_RUN: usize = 20_000;

fn fuzz_large(seed: u64, operations: usize) {
    let mut draws = Draws { seed: Seed(seed).child(77), next: 0 };
    let mut graph = StreetGraph::new(Classes::default());
    let mut streets = Vec::new();
    let size = 3_000_000;
    for step in 0..operations {
        let context = || format!("seed {seed} step {step}");
        if streets.len() > 1_000 || (!streets.is_empty() && draws.below(4) == 0) {
            let (street, from, to) = streets.swap_remove(draws.below(streets.len() as i64) as usize);
            graph.remove_street(street);
            check_around(&graph, from, to, &context);
        } else {
            let mut new = draw_segment(&mut draws, size, &graph);
            // As long as streets are, so that many operations are local.
            let (dx, dy) = new.from.to(new.to);
            new.to = Point::new(new.from.x + (dx / 16) as i32, new.from.y + (dy / 16) as i32);
            let crowding = if draws.below(2) == 0 { Crowding::Refuse } else { Crowding::Join };
            if graph.insert(&new, crowding).is_ok() {
                streets.push((new.claim.street, new.from, new.to));
            }
            check_around(&graph, new.from, new.to, &context);
        }
        if step % 1_000 == 0 {
            assert_eq!(graph.check(CheckLevel::Sweep), Vec::new(), "{}", context());
        }
    }
    assert_eq!(graph.check(CheckLevel::Sweep), Vec::new(), "seed {seed}, at the end");
}

#[test]
fn large_graphs_keep_the_contract() {
    let operations = operations();
    let (runs, rest) = (operations / LARGE_RUN, operations % LARGE_RUN);
    for run in 0..runs {
        fuzz_large(run as u64, LARGE_RUN);
    }
    fuzz_large(runs as u64, rest);
}

#[test]
fn random_operations_keep_the_contract() {
    let operations = operations();
    let mut tally = Tally::default();
    let sizes = [500, 3_000, 30_000, 1_000_000];
    let per_run = 200;
    for run in 0..operations / per_run {
        fuzz(run as u64, per_run, sizes[run % sizes.len()], 40, &mut tally);
    }
    println!("{tally:?}");
    assert!(tally.inserted > tally.refused / 4, "{tally:?}");
}
