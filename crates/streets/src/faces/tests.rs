//! Faces of drawn graphs, exactly; and of random ones, by what must hold of all.

use super::samples::{Sketch, street};
use super::*;
use crate::graph::{Crowding, NewSegment};
use crate::{Claim, Classes, NodeId};
use geom::polygon::{Location, ring_is_simple};
use geom::{Seed, predicates};
use proptest::prelude::*;
use std::collections::BTreeMap;

const SQUARE: &[(i32, i32)] = &[(0, 0), (9000, 0), (9000, 9000), (0, 9000), (0, 0)];

fn blocks(chains: &[&[(i32, i32)]]) -> (StreetGraph, Faces) {
    let graph = Sketch::of_chains(chains).build(Seed(1));
    let faces = Faces::of(&graph, FaceKind::Block);
    assert_sound(&graph, &faces);
    (graph, faces)
}

/// The face of that doubled area.
fn face_of_area(faces: &Faces, doubled_area: i128) -> &Face {
    let mut found = faces.faces.iter().filter(|face| face.doubled_area == doubled_area);
    let face = found.next().expect("a face of that area");
    assert!(found.next().is_none(), "only one");
    face
}

/// What holds of the faces of any graph.
fn assert_sound(graph: &StreetGraph, faces: &Faces) {
    assert!(faces.faces.windows(2).all(|pair| pair[0].id < pair[1].id), "ids ascend and differ");
    let mut seen = vec![0; graph.half_capacity()];
    for (slot, face) in faces.faces.iter().enumerate() {
        assert!(face.outer.doubled_area > 0 && face.holes.iter().all(|hole| hole.doubled_area <= 0));
        for half in std::iter::once(&face.outer).chain(&face.holes).flat_map(|rim| &rim.halves) {
            seen[half.index()] += 1;
            assert_eq!(faces.face_of[half.index()], slot as u32);
        }
        let is_inner = |key: &SegmentKey| {
            [key.forward(), key.backward()].map(|half| faces.face_of[half.index()]) == [slot as u32; 2]
        };
        assert!(face.antennas.iter().all(is_inner));
        let inner = graph.segments_unsorted().filter(|(key, _)| is_inner(key)).count();
        assert_eq!(face.antennas.len(), inner, "antennas are the segments with the face on both sides");
        assert_valid(&face.polygon());
    }
    for (half, &count) in seen.iter().enumerate() {
        assert_eq!(count, u32::from(faces.face_of[half] != NONE), "each half lies on one rim");
    }
}

/// Simple rings of the right orientation that touch in corners of both at most, none inside another hole.
fn assert_valid(polygon: &Polygon) {
    let rings: Vec<&[Point]> = polygon.rings().collect();
    for (i, ring) in rings.iter().enumerate() {
        assert!(ring.len() >= 3 && ring_is_simple(ring), "{ring:?}");
        let area = geom::polygon::ring_doubled_area(ring);
        assert_eq!(area > 0, i == 0, "orientation of ring {i}: {ring:?}");
        let inside = Polygon { outer: rings[0].to_vec(), holes: Vec::new() };
        assert!(ring.iter().all(|&p| inside.locate(p) != Location::Outside));
        for other in &rings[i + 1..] {
            for ((a, b), (c, d)) in edge_pairs(ring, other) {
                let touch = [a, b].iter().filter(|p| [c, d].contains(p)).count();
                assert!(touch < 2 && (touch == 1 || !predicates::meets(a, b, c, d)), "{a:?} {b:?} meets {c:?} {d:?}");
            }
        }
    }
}

fn edge_pairs<'a>(a: &'a [Point], b: &'a [Point]) -> impl Iterator<Item = ((Point, Point), (Point, Point))> + 'a {
    geom::polygon::ring_edges(a).flat_map(move |e| geom::polygon::ring_edges(b).map(move |f| (e, f)))
}

fn corners(sides: &[Side]) -> Vec<(i32, i32)> {
    let mut points: Vec<_> = sides.iter().map(|side| (side.from.x, side.from.y)).collect();
    let least = (0..points.len()).min_by_key(|&i| points[i]).unwrap();
    points.rotate_left(least);
    points
}

#[test]
fn a_grid_has_its_cells() {
    let (_, faces) = blocks(&[
        &[(0, 0), (2000, 0), (4000, 0)],
        &[(0, 1000), (2000, 1000), (4000, 1000)],
        &[(0, 0), (0, 1000)],
        &[(2000, 0), (2000, 1000)],
        &[(4000, 0), (4000, 1000)],
    ]);
    assert_eq!(faces.faces.iter().map(|face| face.doubled_area).collect::<Vec<_>>(), [4_000_000; 2]);
    assert!(faces.faces.iter().all(|face| face.sides.len() == 4 && face.holes.is_empty()));
}

#[test]
fn trees_are_antennas() {
    let tree: &[(i32, i32)] = &[(0, 0), (1000, 1000), (2000, 1000)];
    let (graph, faces) = blocks(&[
        SQUARE,
        tree,
        &[(1000, 1000), (1000, 2000)],
        &[(5000, 5000), (6000, 5000)],
        &[(0, 9000), (0, 12_000)],
    ]);
    let [face] = &faces.faces[..] else { panic!("one face") };
    assert_eq!((face.antennas.len(), face.holes.len(), face.hole_sides.len()), (4, 1, 0));
    assert_eq!(face.doubled_area, 162_000_000);
    assert_eq!(face.holes[0].doubled_area, 0);
    assert_eq!(corners(&face.sides), [(0, 0), (9000, 0), (9000, 9000), (0, 9000)]);
    let bare = Sketch::of_chains(&[SQUARE]).build(Seed(2));
    assert_eq!(Faces::of(&bare, FaceKind::Block).faces[0].id, face.id, "antennas are not part of the signature");
    assert_eq!(
        face.antennas
            .iter()
            .map(|&key| graph.segment(key).id)
            .collect::<Vec<_>>()
            .windows(2)
            .filter(|w| w[0] > w[1])
            .count(),
        0
    );
}

#[test]
fn a_dumbbell_inside_leaves_two_holes() {
    let (_, faces) = blocks(&[
        SQUARE,
        &[(1000, 1000), (2000, 1000), (2000, 2000), (1000, 1000)],
        &[(2000, 2000), (5000, 5000)],
        &[(5000, 5000), (6000, 5000), (6000, 7000), (5000, 5000)],
    ]);
    assert_eq!(faces.faces.len(), 3);
    let face = face_of_area(&faces, 162_000_000 - 1_000_000 - 2_000_000);
    assert_eq!((face.holes.len(), face.hole_sides.len(), face.antennas.len()), (1, 2, 1));
}

#[test]
fn a_loop_on_a_bridge_is_a_hole_of_the_core() {
    let (_, faces) =
        blocks(&[SQUARE, &[(0, 0), (1000, 1000)], &[(1000, 1000), (3000, 1000), (3000, 3000), (1000, 1000)]]);
    let face = face_of_area(&faces, 162_000_000 - 4_000_000);
    assert_eq!((face.holes.len(), face.hole_sides.len(), face.antennas.len()), (0, 1, 1));
    assert_eq!(corners(&face.hole_sides[0]), [(1000, 1000), (3000, 3000), (3000, 1000)]);
    assert_eq!(face.sides.len(), 4);
}

#[test]
fn a_pinch_is_a_touching_hole() {
    let (_, faces) = blocks(&[SQUARE, &[(0, 0), (3000, 1000), (1000, 3000), (0, 0)]]);
    let face = face_of_area(&faces, 162_000_000 - 8_000_000);
    assert_eq!((face.holes.len(), face.hole_sides.len(), face.antennas.len()), (0, 1, 0));
    assert_eq!(corners(&face.hole_sides[0]), [(0, 0), (1000, 3000), (3000, 1000)]);
    assert_eq!(face.polygon().doubled_area(), face.doubled_area);
}

#[test]
fn a_pinch_on_a_straight_street_stays_a_corner_of_both_rings() {
    let base: &[(i32, i32)] = &[(0, 0), (4000, 0), (9000, 0)];
    let (_, faces) = blocks(&[
        base,
        &[(9000, 0), (9000, 9000), (0, 9000), (0, 0)],
        &[(4000, 0), (5000, 2000), (3000, 2000), (4000, 0)],
    ]);
    let face = face_of_area(&faces, 162_000_000 - 4_000_000);
    assert_eq!(corners(&face.sides), [(0, 0), (4000, 0), (9000, 0), (9000, 9000), (0, 9000)]);
    assert_eq!(corners(&face.hole_sides[0]), [(3000, 2000), (5000, 2000), (4000, 0)]);
}

#[test]
fn holes_that_touch_are_separate_rings() {
    let (_, faces) = blocks(&[
        SQUARE,
        &[(2000, 3000), (4000, 3000), (6000, 3000)],
        &[(2000, 3000), (3000, 1000), (4000, 3000), (5000, 1000), (6000, 3000)],
    ]);
    let face = face_of_area(&faces, 162_000_000 - 8_000_000);
    assert_eq!((face.holes.len(), face.hole_sides.len()), (1, 2));
}

#[test]
fn a_face_that_bites_its_tail_has_a_touching_hole() {
    let ring: &[(i32, i32)] = &[(4000, 0), (9000, 0), (9000, 9000), (0, 9000), (0, 0), (4000, 0)];
    let (_, faces) = blocks(&[ring, &[(4000, 0), (6000, 6000), (2000, 6000), (4000, 0)]]);
    assert_eq!(faces.faces.len(), 2);
    assert_eq!(face_of_area(&faces, 162_000_000 - 24_000_000).hole_sides.len(), 1);
}

#[test]
fn rays_through_nodes_and_along_segments_find_the_face_around() {
    // Nested squares whose corners and sides share heights with those of others, and a zigzag to their left.
    let inner: &[(i32, i32)] = &[(7000, 3000), (8000, 3000), (8000, 6000), (7000, 6000), (7000, 3000)];
    let left: &[(i32, i32)] = &[(1000, 3000), (2000, 2000), (3000, 3000), (2000, 4000), (1000, 3000)];
    let flat: &[(i32, i32)] = &[(4000, 3000), (5000, 3000)];
    let peak: &[(i32, i32)] = &[(4000, 1000), (5500, 3000), (4500, 1000)];
    let islet: &[(i32, i32)] = &[(7200, 4000), (7800, 4000), (7800, 5000), (7200, 4000)];
    let (_, faces) = blocks(&[SQUARE, inner, left, flat, peak, islet]);
    assert_eq!(faces.faces.len(), 4);
    let outer = face_of_area(&faces, 162_000_000 - 6_000_000 - 4_000_000);
    assert_eq!((outer.holes.len(), outer.hole_sides.len(), outer.antennas.len()), (4, 2, 3));
    assert_eq!(face_of_area(&faces, 6_000_000 - 600_000).holes.len(), 1);
}

#[test]
fn a_closed_street_alone_is_known_by_its_least_pin() {
    let (graph, faces) = blocks(&[SQUARE]);
    let mut shifted = Sketch::of_chains(&[SQUARE]);
    shifted.nodes.iter_mut().for_each(|p| p.x += 500);
    let other = Faces::of(&shifted.build(Seed(9)), FaceKind::Block);
    assert_eq!(faces.faces[0].id, other.faces[0].id, "geometry does not matter");
    assert_eq!(faces.faces[0].sides.len(), 4);
    assert_ne!(faces.faces[0].root(&graph), Id::default());
}

#[test]
fn passages_of_one_street_through_one_node_make_different_faces() {
    // Three petals round the origin, all of street 0 and all counter-clockwise.
    let petals: &[(i32, i32)] = &[
        (0, 0),
        (4000, -1000),
        (4000, 1000),
        (0, 0),
        (-1000, 4000),
        (-3000, 3000),
        (0, 0),
        (-3000, -3000),
        (-1000, -4000),
        (0, 0),
    ];
    let (_, faces) = blocks(&[petals]);
    assert_eq!(faces.faces.len(), 3);
}

#[test]
fn a_street_that_crosses_itself_turns_a_corner_there() {
    let knot: &[(i32, i32)] = &[(-4000, 0), (0, 0), (4000, 0), (0, 4000), (0, 0), (0, -4000)];
    let (graph, faces) = blocks(&[knot]);
    let [face] = &faces.faces[..] else { panic!("one loop") };
    assert!(
        graph.pins(face.sides[0].from_node).is_empty(),
        "the crossing is where the face starts, and no shape point"
    );
    assert_eq!(corners(&face.sides), [(0, 0), (4000, 0), (0, 4000)]);
}

#[test]
fn minors_and_bridges_close_no_quarter() {
    let mut sketch = Sketch::of_chains(&[SQUARE, &[(0, 0), (9000, 9000)]]);
    sketch.lines[4].class = Classes::MINOR;
    let graph = sketch.build(Seed(3));
    let quarters = Faces::of(&graph, FaceKind::Quarter);
    assert_eq!((quarters.faces.len(), Faces::of(&graph, FaceKind::Block).faces.len()), (1, 2));
    assert_eq!(quarters.faces[0].antennas, []);
    assert_eq!(quarters.face_of.iter().filter(|&&face| face == NONE).count(), 6);
    sketch.lines[4].level = 1;
    assert_eq!(Faces::of(&sketch.build(Seed(3)), FaceKind::Block).faces.len(), 1);
}

fn lay(graph: &mut StreetGraph, name: u128, from: Point, to: Point) {
    let claim = Claim { street: street(name), class: Classes::MAJOR, half_width: 4096, origin: 0, forward: true };
    let id = |p: Point| NodeId(Id::root("end", &[name, p.x as u32 as u128, p.y as u32 as u128]));
    let new = NewSegment { from, to, from_id: id(from), to_id: id(to), claim, level: 0 };
    graph.insert(&new, Crowding::Refuse).expect("room");
}

/// A skew four-sided block.
fn skew_block() -> StreetGraph {
    let mut graph = StreetGraph::new(Classes::default());
    let corners = [(0, 0), (701_003, 13_007), (690_011, 502_001), (-20_011, 480_003)].map(|(x, y)| Point::new(x, y));
    for i in 0..4 {
        lay(&mut graph, i as u128, corners[i], corners[(i + 1) % 4]);
    }
    graph
}

fn seen_from_inside(graph: &StreetGraph, kind: FaceKind) -> (Id, Id, Vec<(StreetId, Point, Point)>) {
    let faces = Faces::of(graph, kind);
    let inside = |face: &&Face| face.polygon().locate(Point::new(300_000, 240_000)) == Location::Inside;
    let face = faces.faces.iter().find(inside).expect("the block");
    (face.id, face.root(graph), face.sides.iter().map(|side| (side.street, side.from, side.to)).collect())
}

/// Which part of the lattice is kept: often so little that islands, trees and pinches lie in large faces.
fn keeps() -> impl Strategy<Value = f64> {
    prop_oneof![0.15f64..0.45, 0.45f64..1.0]
}

/// How far lattice nodes are moved: often not at all, so that streets run straight through crossings.
fn jitters() -> impl Strategy<Value = i32> {
    prop_oneof![Just(0), 1i32..900]
}

proptest! {
    #[test]
    fn attachments_from_outside_change_nothing(places in prop::collection::vec((0usize..4, 0.02f64..0.98), 1..40)) {
        let mut graph = skew_block();
        let before = seen_from_inside(&graph, FaceKind::Block);
        prop_assert_eq!(before.2.len(), 4);
        for (name, (side, t)) in places.into_iter().enumerate() {
            let (from, to) = (before.2[side].1, before.2[side].2);
            let (from_m, to_m) = (from.metres(), to.metres());
            let foot = Point::from_metres(from_m.lerp(to_m, t));
            let out = Point::from_metres(foot.metres() + (to_m - from_m).perp() * -0.3);
            let claim = Claim { street: street(100 + name as u128), class: Classes::MINOR, half_width: 2048, origin: 0, forward: true };
            let id = |slot| NodeId(Id::root("t", &[name as u128, slot]));
            let new = NewSegment { from: out, to: foot, from_id: id(0), to_id: id(1), claim, level: 0 };
            let _ = graph.insert(&new, Crowding::Refuse);
        }
        prop_assert!(graph.node_count() > 4, "some were laid");
        prop_assert_eq!(seen_from_inside(&graph, FaceKind::Block), before);
    }

    #[test]
    fn faces_of_random_graphs_are_sound(seed: u64, size in 2usize..9, keep in keeps(), jitter in jitters(), names in 0usize..5) {
        let graph = Sketch::random(Seed(seed), size, keep, jitter, names).build(Seed(seed));
        let faces = Faces::of(&graph, FaceKind::Block);
        assert_sound(&graph, &faces);
        let rims = Rims::walk(&graph, |_| true);
        let closing = nest::closing_rims(&graph, &rims);
        let enclosed: i128 = (0..rims.len()).filter(|&rim| closing[rim] == NONE).map(|rim| -rims.area(rim)).sum();
        prop_assert_eq!(faces.faces.iter().map(|face| face.doubled_area).sum::<i128>(), enclosed);
        for face in &faces.faces {
            prop_assert_eq!(face.polygon().doubled_area(), face.doubled_area, "what a side passes lies on it here");
        }
    }

    #[test]
    fn nesting_agrees_with_brute_force(seed: u64, size in 2usize..9, keep in 0.2f64..0.6, jitter in jitters()) {
        let graph = Sketch::random(Seed(seed), size, keep, jitter, 0).build(Seed(seed));
        let rims = Rims::walk(&graph, |_| true);
        let closing = nest::closing_rims(&graph, &rims);
        let points = |rim: usize| rims.halves(rim).iter().map(|&half| graph.at(graph.origin(half))).collect::<Vec<_>>();
        let bounded: Vec<usize> = (0..rims.len()).filter(|&rim| rims.area(rim) > 0).collect();
        for rim in (0..rims.len()).filter(|&rim| rims.area(rim) <= 0) {
            let start = points(rim).into_iter().min().unwrap();
            let around = bounded.iter().filter(|&&outer| {
                Polygon { outer: points(outer), holes: Vec::new() }.locate(start) == Location::Inside
            });
            let nearest = around.min_by_key(|&&outer| rims.area(outer)).map_or(NONE, |&outer| outer as u32);
            prop_assert_eq!(closing[rim], nearest);
        }
    }

    #[test]
    fn faces_do_not_depend_on_keys_or_orientation(seed: u64, size in 2usize..8, keep in keeps(), jitter in jitters(), names in 0usize..4) {
        let sketch = Sketch::random(Seed(seed), size, keep, jitter, names);
        let told = |sketch: &Sketch, order: u64, turn: bool| {
            let graph = sketch.build(Seed(order));
            let place = |p: Point| if turn { Point::new(p.y, -p.x) } else { p };
            let rim = |rim: &Rim| rim.halves.iter().map(|&half| graph.node(graph.origin(half)).id).collect::<Vec<_>>();
            let ring = |sides: &Vec<Side>| sides.iter().map(|s| (s.street, place(s.from), place(s.to))).collect::<Vec<_>>();
            let faces = Faces::of(&graph, FaceKind::Quarter).faces;
            let tell = |face: &Face| (
                (face.id, face.doubled_area, face.root(&graph)),
                (rim(&face.outer), face.holes.iter().map(rim).collect::<Vec<_>>()),
                (ring(&face.sides), face.hole_sides.iter().map(ring).collect::<Vec<_>>()),
                face.antennas.iter().map(|&key| graph.segment(key).id).collect::<Vec<_>>(),
            );
            faces.iter().map(tell).collect::<Vec<_>>()
        };
        let here = told(&sketch, 1, false);
        prop_assert_eq!(&here, &told(&sketch, 2, false));
        prop_assert_eq!(&here, &told(&sketch.turned(), 3, true));
    }

    #[test]
    fn roots_differ_between_faces_of_distinct_streets(seed: u64, size in 2usize..8, keep in keeps()) {
        let graph = Sketch::random(Seed(seed), size, keep, 700, 0).build(Seed(seed));
        let faces = Faces::of(&graph, FaceKind::Quarter).faces;
        let roots: BTreeMap<Id, usize> = faces.iter().enumerate().map(|(i, face)| (face.root(&graph), i)).collect();
        prop_assert_eq!(roots.len(), faces.len());
    }
}
