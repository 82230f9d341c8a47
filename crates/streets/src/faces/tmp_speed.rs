use super::samples::Sketch;
use super::*;
use crate::graph::{CheckLevel, Crowding, NewSegment};
use crate::{Claim, Classes, NodeId};
use geom::Seed;
#[allow(clippy::disallowed_methods)]
fn time<T>(what: &str, f: impl Fn() -> T) -> T {
    let mut best = f64::MAX;
    let mut r = None;
    for _ in 0..5 {
        r = None; let t = cpu();
        r = Some(f());
        best = best.min(cpu() - t);
    }
    println!("{what}: {:.1} ms", best * 1e3);
    r.unwrap()
}
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}
#[test]
fn speed() {
    let mut graph = StreetGraph::new(Classes::default());
    let n = 224;
    for i in 0..n {
        for swap in [false, true] {
            let (a, b) = (Point::new(0, i * 100_000), Point::new((n - 1) * 100_000, i * 100_000));
            let f = |p: Point| if swap { Point::new(p.y, p.x) } else { p };
            let s = StreetId(Id::root("s", &[i as u128, swap as u128]));
            let claim = Claim { street: s, class: Classes::MAJOR, half_width: 4096, origin: 0, forward: true };
            let new = NewSegment {
                from: f(a),
                to: f(b),
                from_id: NodeId(s.0.child(0)),
                to_id: NodeId(s.0.child(1)),
                claim,
                level: 0,
            };
            graph.insert(&new, Crowding::Refuse).unwrap();
        }
    }
    println!("grid {} {}", graph.node_count(), graph.segment_count());
    let f = time("grid faces", || Faces::of(&graph, FaceKind::Block));
    println!("{}", f.faces.len());
    time("grid walk", || Rims::walk(&graph, |_| true));
    time("grid runs", || crate::runs::runs(&graph));
    time("grid check", || graph.check(CheckLevel::Sweep));
    for keep in [0.3, 0.45, 0.8] {
        let graph = Sketch::random(Seed(5), 220, keep, 700, 0).build(Seed(6));
        let f = time("random faces", || Faces::of(&graph, FaceKind::Block));
        let rims = time("random walk", || Rims::walk(&graph, |_| true));
        time("random nest", || nest::closing_rims(&graph, &rims));
        println!(
            "{} segments, {} faces, {} holes",
            graph.segment_count(),
            f.faces.len(),
            (0..rims.len()).filter(|&r| rims.area(r) <= 0).count()
        );
    }
    let mut out = String::new();
    for seed in 0..400 {
        let graph = Sketch::random(
            Seed(seed),
            9,
            0.2 + (seed % 7) as f64 * 0.06,
            if seed % 2 == 0 { 0 } else { 700 },
            (seed % 3) as usize,
        )
        .build(Seed(6));
        for face in Faces::of(&graph, FaceKind::Block).faces {
            let p = face.polygon();
            let rings: Vec<Vec<(i32, i32)>> = p.rings().map(|r| r.iter().map(|p| (p.x, p.y)).collect()).collect();
            out += &format!("{:?}\n", rings).replace('(', "[").replace(')', "]");
        }
    }
    std::fs::write("/tmp/faces_rings.txt", out).unwrap();
}
