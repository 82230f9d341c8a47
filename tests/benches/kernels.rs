//! Speed of the kernels and how it grows with size: `cargo bench -p suite`, or some of it: `cargo bench -p suite -- insert`.
//!
//! Wall time on one thread. The same growth is timed with a rule in Rust and with `rules/streets/grid.rhai` in one run,
//! so that the price of scripting is a ratio; each table ends with the exponent from its smallest to its largest size.
#![allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

#[path = "kernels/growth.rs"]
mod growth;
#[path = "kernels/land.rs"]
mod land;
#[path = "kernels/watch.rs"]
mod watch;

use geom::point::units;
use geom::{Angle, Id, Point, Seed, Vec2};
use std::time::Instant;
use streets::faces::{FaceKind, Faces};
use streets::graph::{Crowding, NewSegment};
use streets::{Claim, Classes, NodeId, StreetGraph, StreetId};

const SIZES: [usize; 4] = [10_000, 30_000, 100_000, 300_000];

fn main() {
    for order in [Lines::Lattice, Lines::ByPlace, Lines::Shuffled] {
        let name = match order {
            Lines::Lattice => "insert, lattice",
            Lines::ByPlace => "insert, random lines, kilometre by kilometre",
            // What each insertion meets is out of the cache once the graph outgrows it: the same instructions take longer.
            Lines::Shuffled => "insert, the same lines in random order",
        };
        table(name, "segments", |size| {
            let lines = lines(size, order);
            let started = Instant::now();
            let graph = insert_all(&lines);
            (graph.segment_count(), started.elapsed().as_secs_f64())
        });
    }
    table("faces from scratch, lattice", "segments", |size| {
        let graph = insert_all(&lines(size, Lines::Lattice));
        let started = Instant::now();
        let faces = Faces::of(&graph, FaceKind::Block);
        assert!(!faces.faces.is_empty());
        (graph.segment_count(), started.elapsed().as_secs_f64())
    });
    growth::tables();
    table("recursive parcels, regions and cuts", "parcels", |size| {
        let blocks = land::blocks(size);
        let settings = layout::RecursiveSettings::default();
        let started = Instant::now();
        let divided = blocks.iter().map(|block| layout::subdivide(block, &settings).expect("good settings"));
        let count = divided.map(|division| division.parcels.len()).sum();
        (count, started.elapsed().as_secs_f64())
    });
    watch::tables();
}

/// Whether a table was asked for: all are when none is named.
fn is_asked(name: &str) -> bool {
    let mut words = std::env::args().skip(1).filter(|word| !word.starts_with("--")).peekable();
    words.peek().is_none() || words.any(|word| name.contains(&word))
}

/// Runs a measurement at all sizes, best of five, and prints rates and the exponent.
fn table(name: &str, unit: &str, measure: impl Fn(usize) -> (usize, f64)) {
    if !is_asked(name) {
        return;
    }
    println!("{name}");
    let mut rows = Vec::new();
    for size in SIZES {
        let (count, seconds) = (0..5).map(|_| measure(size)).min_by(|a, b| a.1.total_cmp(&b.1)).expect("five runs");
        println!("  {count:>8} {unit} {:>9.1} ms {:>10.0} /s", seconds * 1e3, count as f64 / seconds);
        rows.push((count as f64, seconds));
    }
    let ((small, fast), (large, slow)) = (rows[0], rows[rows.len() - 1]);
    println!("  exponent {:.2}", libm::log(slow / fast) / libm::log(large / small));
}

/// What is inserted, and in which order.
#[derive(Clone, Copy, PartialEq)]
enum Lines {
    /// A lattice of 80 m, row by row.
    Lattice,
    /// Lines of 20 to 120 m anywhere, one square kilometre after another, in random order within each.
    ByPlace,
    /// The same lines in random order.
    Shuffled,
}

/// About `size` segments.
fn lines(size: usize, order: Lines) -> Vec<(Point, Point)> {
    if order == Lines::Lattice {
        return lattice(size);
    }
    let seed = Seed(1);
    let side = (size as f64).sqrt() * 60.0;
    let line = |k: u64| {
        let draw = |n: u64, low: f64, high: f64| seed.range(4 * k + n, low, high);
        let from = Vec2::new(draw(0, 0.0, side), draw(1, 0.0, side));
        let to = from + Angle::degrees(draw(2, 0.0, 360.0)).unit() * draw(3, 20.0, 120.0);
        (Point::from_metres(from), Point::from_metres(to))
    };
    let mut lines: Vec<_> = (0..(size / 2) as u64).map(line).collect();
    if order == Lines::ByPlace {
        let kilometre = |p: Point| (p.x / units(1_000.0), p.y / units(1_000.0));
        lines.sort_by_key(|&(from, _)| kilometre(from));
    }
    lines
}

fn lattice(size: usize) -> Vec<(Point, Point)> {
    let side = ((size as f64 / 2.0).sqrt()) as i32;
    let place = |i: i32, j: i32| Point::new(units(80.0) * i - units(20_000.0), units(80.0) * j - units(20_000.0));
    let from = |n: i32| (n / side, n % side);
    let both = |(i, j): (i32, i32)| [(place(i, j), place(i + 1, j)), (place(i, j), place(i, j + 1))];
    (0..side * side).map(from).flat_map(both).collect()
}

fn insert_all(lines: &[(Point, Point)]) -> StreetGraph {
    let mut graph = StreetGraph::new(Classes::default());
    for (k, &(from, to)) in lines.iter().enumerate() {
        let id = Id::root("bench", &[k as u128]);
        let street = StreetId(id);
        let claim = Claim { street, class: Classes::MINOR, half_width: units(8.0), origin: 0, forward: true };
        let (from_id, to_id) = (NodeId(id.child(0)), NodeId(id.child(1)));
        let _ = graph.insert(&NewSegment { from, to, from_id, to_id, claim, level: 0 }, Crowding::Refuse);
    }
    graph
}
