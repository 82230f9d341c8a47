//! Properties of faces on random planar graphs.

use geom::{Id, Point, Seed, predicates};
use proptest::prelude::*;
use std::collections::BTreeSet;
use streets::faces::{FaceKind, Faces};
use streets::graph::{Crowding, NewSegment};
use streets::runs::runs;
use streets::{Claim, Class, Classes, NodeId, StreetGraph, StreetId};

/// A street of `points` in a graph, its ids from `name`.
fn draw(graph: &mut StreetGraph, name: u64, class: Class, points: &[Point]) {
    let id = Id::root("test", &[u128::from(name)]);
    for (i, pair) in points.windows(2).enumerate() {
        let claim = Claim { street: StreetId(id), class, half_width: 5000, origin: 0, forward: true };
        let new = NewSegment {
            from: pair[0],
            to: pair[1],
            from_id: NodeId(id.child(i as u64)),
            to_id: NodeId(id.child(i as u64 + 1)),
            claim,
            level: 0,
        };
        let _ = graph.insert(&new, Crowding::Refuse);
    }
}

/// Random streets of up to four points and all classes.
fn random_graph(seed: u64, streets: u64, reach: i64) -> StreetGraph {
    random_graph_of(0..3, seed, streets, reach, false)
}

/// The same of some classes; `turn` rotates the plane by quarters.
fn random_graph_of(classes: std::ops::Range<u8>, seed: u64, streets: u64, reach: i64, turn: bool) -> StreetGraph {
    let mut graph = StreetGraph::new(Classes::default());
    let draws = Seed(seed);
    for street in 0..streets {
        let of = draws.child(street);
        let coordinate = |i: u64| (of.child(i).0 % (2 * reach as u64)) as i64 - reach;
        let points: Vec<Point> = (0..2 + of.child(99).0 % 3)
            .map(|i| (coordinate(2 * i), coordinate(2 * i + 1)))
            .map(|(x, y)| if turn { Point::new(-y as i32, x as i32) } else { Point::new(x as i32, y as i32) })
            .collect();
        let class = classes.start + (of.child(98).0 % u64::from(classes.end - classes.start)) as u8;
        draw(&mut graph, street, Class(class), &points);
    }
    graph
}

fn components(graph: &StreetGraph) -> usize {
    let nodes = graph.nodes_by_id();
    let mut seen = BTreeSet::new();
    let mut count = 0;
    for &start in &nodes {
        if !seen.insert(start) {
            continue;
        }
        count += 1;
        let mut open = vec![start];
        while let Some(node) = open.pop() {
            open.extend(graph.halves_ccw(node).iter().map(|&arm| graph.target(arm)).filter(|&next| seen.insert(next)));
        }
    }
    count
}

/// Which face holds a point that lies on no street, by brute force: the smallest outer rim around it.
fn face_at(graph: &StreetGraph, faces: &Faces, p: Point) -> Option<usize> {
    let winds = |i: &usize| {
        let mut inside = false;
        for &half in &faces.faces[*i].outer.halves {
            let (a, b) = graph.line(half);
            if (a.y > p.y) != (b.y > p.y) && ((predicates::orient(a, b, p) > 0) == (b.y > a.y)) {
                inside = !inside;
            }
        }
        inside
    };
    (0..faces.faces.len()).filter(winds).min_by_key(|&i| faces.faces[i].outer.doubled_area)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn euler_and_rims(seed in any::<u64>(), streets in 1u64..40, reach in prop::sample::select(vec![2_000i64, 50_000, 2_000_000])) {
        let graph = random_graph(seed, streets, reach);
        let faces = Faces::of(&graph, FaceKind::Block);
        let (v, e, c) = (graph.node_count(), graph.segment_count(), components(&graph));
        prop_assert_eq!(v + faces.faces.len() + 1, e + 1 + c, "V - E + F = 1 + C");
        let mut walked = vec![0; graph.half_capacity()];
        for face in &faces.faces {
            for half in std::iter::once(&face.outer).chain(&face.holes).flat_map(|rim| &rim.halves) {
                walked[half.index()] += 1;
            }
        }
        for (key, _) in graph.segments_unsorted() {
            for half in [key.forward(), key.backward()] {
                let is_bounded = faces.face_of[half.index()] != u32::MAX;
                prop_assert_eq!(walked[half.index()], usize::from(is_bounded));
            }
        }
        let ids: BTreeSet<Id> = faces.faces.iter().map(|face| face.id).collect();
        prop_assert_eq!(ids.len(), faces.faces.len(), "ids are unique");
        let run_ids: BTreeSet<Id> = runs(&graph).iter().map(|run| run.id).collect();
        prop_assert_eq!(run_ids.len(), runs(&graph).len(), "run ids are unique");
    }

    #[test]
    fn areas_add_up(seed in any::<u64>(), streets in 1u64..40, reach in prop::sample::select(vec![2_000i64, 50_000])) {
        let graph = random_graph(seed, streets, reach);
        let faces = Faces::of(&graph, FaceKind::Block);
        let bounded: i128 = faces.faces.iter().map(|face| face.doubled_area).sum();
        // Each half of the unbounded face's rims, negated, sums to what the outermost components enclose.
        let outside: i128 = graph.segments_unsorted().flat_map(|(key, _)| [key.forward(), key.backward()])
            .filter(|half| faces.face_of[half.index()] == u32::MAX)
            .map(|half| { let (a, b) = graph.line(half); i128::from(a.x) * i128::from(b.y) - i128::from(a.y) * i128::from(b.x) })
            .sum();
        prop_assert_eq!(bounded, -outside);
        prop_assert!(faces.faces.iter().all(|face| face.doubled_area > 0));
    }

    #[test]
    fn holes_lie_in_the_face_that_names_them(seed in any::<u64>(), streets in 4u64..60) {
        let graph = random_graph(seed, streets, 300_000);
        let faces = Faces::of(&graph, FaceKind::Block);
        for (i, face) in faces.faces.iter().enumerate() {
            for hole in &face.holes {
                let (a, _) = graph.line(hole.halves[0]);
                // Step off the rim to where no street can be: less than the separation away, sideways.
                let free = hole.halves.iter().find_map(|&half| {
                    let (p, q) = graph.line(half);
                    let middle = Point::new((p.x + q.x) / 2, (p.y + q.y) / 2);
                    let (dx, dy) = p.to(q);
                    let left = Point::new(middle.x - (dy.signum() * 2) as i32, middle.y + (dx.signum() * 2) as i32);
                    (predicates::orient(p, q, left) > 0 && graph.nearest_segment(left, 6, 0).is_some()
                        && graph.segments_near(geom::Bounds::between(left, left).grown(6)).len() == 1).then_some(left)
                });
                if let Some(free) = free {
                    prop_assert_eq!(face_at(&graph, &faces, free), Some(i), "hole at {:?}", a);
                }
            }
        }
    }

    #[test]
    fn a_quarter_turn_changes_no_id(seed in any::<u64>(), streets in 1u64..30) {
        // Multiples of a coarse pitch, so that no crossing is rounded differently.
        // Streets that close quarters, or none that do: crossings of the two sorts hold their place.
        for classes in [0..2, 2..3] {
            let graph = |turn| random_graph_of(classes.clone(), seed, streets, 4_000_000, turn);
            let (graph, turned) = (graph(false), graph(true));
            if graph.node_count() != turned.node_count() {
                continue;
            }
            let ids = |graph: &StreetGraph, kind| Faces::of(graph, kind).faces.iter().map(|face| face.id).collect::<Vec<_>>();
            prop_assert_eq!(ids(&graph, FaceKind::Block), ids(&turned, FaceKind::Block));
            prop_assert_eq!(ids(&graph, FaceKind::Quarter), ids(&turned, FaceKind::Quarter));
        }
    }

    #[test]
    fn blocks_do_not_depend_on_the_order_of_building(seed in any::<u64>(), streets in 2u64..25) {
        let build = |reverse: bool| {
            let mut graph = StreetGraph::new(Classes::default());
            let mut order: Vec<u64> = (0..streets).collect();
            if reverse { order.reverse(); }
            for street in order {
                // Full-length lines of a lattice: their crossings are exact, so nothing conflicts.
                let at = ((street / 2 + 1) * 100_000) as i32;
                let (a, b) = if street % 2 == 0 { (Point::new(at, 0), Point::new(at, 3_000_000)) } else { (Point::new(0, at), Point::new(3_000_000, at)) };
                draw(&mut graph, street ^ seed, Classes::MINOR, &[a, b]);
            }
            graph
        };
        let (one, two) = (build(false), build(true));
        prop_assert_eq!(one.digest(), two.digest());
    }
}

/// A square of four streets, with corners shared.
fn square(graph: &mut StreetGraph, name: u64, class: Class, low: i32, high: i32) {
    let corners = [Point::new(low, low), Point::new(high, low), Point::new(high, high), Point::new(low, high)];
    for i in 0..4 {
        draw(graph, name + i as u64, class, &[corners[i], corners[(i + 1) % 4]]);
    }
}

#[test]
fn a_t_from_outside_changes_no_side_and_no_id() {
    let mut graph = StreetGraph::new(Classes::default());
    square(&mut graph, 0, Classes::MAJOR, 0, 1_000_003);
    let before = Faces::of(&graph, FaceKind::Block);
    // Slanted, so that its crossing is rounded off the line.
    draw(&mut graph, 10, Classes::MINOR, &[Point::new(1_700_000, 1_234_567), Point::new(1_000_003, 400_001)]);
    let after = Faces::of(&graph, FaceKind::Block);
    assert_eq!(before.faces[0].id, after.faces[0].id);
    assert_eq!(before.faces[0].sides.len(), 4);
    let lines = |faces: &Faces| faces.faces[0].sides.iter().map(|s| (s.street, s.from, s.to)).collect::<Vec<_>>();
    assert_eq!(lines(&before), lines(&after));
}

#[test]
fn dead_ends_islands_and_bridges_are_stripped() {
    let mut graph = StreetGraph::new(Classes::default());
    square(&mut graph, 0, Classes::MAJOR, 0, 1_000_000);
    square(&mut graph, 10, Classes::MINOR, 400_000, 600_000);
    // A dead end from the rim, and a street that ties the island to the rim.
    draw(&mut graph, 20, Classes::MINOR, &[Point::new(0, 100_000), Point::new(200_000, 100_000)]);
    let island = Faces::of(&graph, FaceKind::Block);
    let outer = island.faces.iter().find(|face| !face.hole_sides.is_empty()).expect("the block around the island");
    assert_eq!((island.faces.len(), outer.sides.len(), outer.hole_sides[0].len(), outer.antennas.len()), (2, 4, 4, 1));
    draw(&mut graph, 21, Classes::MINOR, &[Point::new(600_000, 500_000), Point::new(1_000_000, 500_000)]);
    let tied = Faces::of(&graph, FaceKind::Block);
    let outer = tied.faces.iter().find(|face| !face.hole_sides.is_empty()).expect("the block around the island");
    assert_eq!((tied.faces.len(), outer.holes.len(), outer.hole_sides.len(), outer.antennas.len()), (2, 0, 1, 2));
    assert_eq!(Faces::of(&graph, FaceKind::Quarter).faces.len(), 1);
}

#[test]
fn a_closed_street_is_a_block_and_one_run() {
    let mut graph = StreetGraph::new(Classes::default());
    let ring = [Point::new(0, 0), Point::new(900_000, 0), Point::new(900_000, 800_000), Point::new(0, 0)];
    draw(&mut graph, 1, Classes::MINOR, &ring);
    let faces = Faces::of(&graph, FaceKind::Block);
    assert_eq!((faces.faces.len(), faces.faces[0].sides.len()), (1, 3));
    let runs = runs(&graph);
    assert_eq!((runs.len(), runs[0].nodes.len(), runs[0].nodes[0] == runs[0].nodes[3]), (1, 4, true));
}
