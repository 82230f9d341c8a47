use super::*;
use crate::{RecursiveSettings, buildable, subdivide};
use geom::point::units;
use geom::strip::{MITRE_LIMIT, Reach, strip, wedge};
use proptest::prelude::*;
use streets::faces::FaceKind;
use streets::graph::{Crowding, NewSegment};
use streets::{Claim, Class, Classes, NodeId, StreetId};

fn street(n: u64) -> StreetId {
    StreetId(Id::root("street", &[u128::from(n)]))
}

/// Draws a street through points in metres.
fn draw(graph: &mut StreetGraph, n: u64, class: Class, half_width: f64, points: &[(f64, f64)]) {
    let claim = Claim { street: street(n), class, half_width: units(half_width), origin: 0, forward: true };
    let node = |i: usize| NodeId(street(n).0.child(i as u64));
    for (i, pair) in points.windows(2).enumerate() {
        let [from, to] = [pair[0], pair[1]].map(|(x, y)| Point::new(units(x), units(y)));
        let new = NewSegment { from, to, from_id: node(i), to_id: node(i + 1), claim, level: 0 };
        // What is too crowded stays out.
        let _ = graph.insert(&new, Crowding::Refuse);
    }
}

/// A square of side 100 m of streets 1 to 4, of half width 5 m.
fn square(class: Class) -> StreetGraph {
    let mut graph = StreetGraph::new(Classes::default());
    draw(&mut graph, 1, class, 5.0, &[(0.0, 0.0), (100.0, 0.0)]);
    draw(&mut graph, 2, class, 5.0, &[(100.0, 0.0), (100.0, 100.0)]);
    draw(&mut graph, 3, class, 5.0, &[(100.0, 100.0), (0.0, 100.0)]);
    draw(&mut graph, 4, class, 5.0, &[(0.0, 100.0), (0.0, 0.0)]);
    graph
}

fn blocks_of(graph: &StreetGraph) -> Vec<Block> {
    blocks(graph, &Faces::of(graph, FaceKind::Block), &Faces::of(graph, FaceKind::Quarter))
}

fn streets_of(block: &Block) -> Vec<StreetId> {
    block.bodies.iter().map(|body| body.street).collect()
}

#[test]
fn a_square_of_minors_is_one_block_in_no_quarter() {
    let found = blocks_of(&square(Classes::MINOR));
    let [block] = &found[..] else { panic!("{found:?}") };
    assert_eq!((block.quarter, block.bodies.len(), block.streets.len()), (None, 4, 4));
    assert_eq!(block.polygon.area(), 10_000.0);
    assert!((buildable(block).regions[0].polygon.area() - 8_100.0).abs() < 1.0);
}

#[test]
fn blocks_know_their_quarter_even_off_its_rim() {
    let mut graph = square(Classes::MAJOR);
    // A hash of minors: the block in the middle touches no major.
    for (n, at) in [(5, 30.0), (6, 70.0)] {
        draw(&mut graph, n, Classes::MINOR, 3.0, &[(at, 0.0), (at, 100.0)]);
        draw(&mut graph, n + 2, Classes::MINOR, 3.0, &[(0.0, at), (100.0, at)]);
    }
    // And one outside.
    draw(&mut graph, 10, Classes::MINOR, 3.0, &[(100.0, 0.0), (150.0, 50.0), (100.0, 100.0)]);
    let quarter = Faces::of(&graph, FaceKind::Quarter).faces[0].id;
    let found = blocks_of(&graph);
    assert_eq!(found.len(), 10);
    assert_eq!(found.iter().filter(|block| block.quarter == Some(quarter)).count(), 9);
}

#[test]
fn a_street_from_outside_is_none_of_the_blocks_business_unless_it_reaches_in() {
    let alone = blocks_of(&square(Classes::MINOR)).remove(0);
    let mut graph = square(Classes::MINOR);
    draw(&mut graph, 5, Classes::MINOR, 9.0, &[(50.0, 0.0), (50.0, -80.0)]);
    assert_eq!(blocks_of(&graph), std::slice::from_ref(&alone));
    // At a slant, the square end of a wide street pokes through the narrow one that it meets.
    let mut graph = square(Classes::MINOR);
    draw(&mut graph, 5, Classes::MINOR, 9.0, &[(50.0, 0.0), (90.0, -40.0)]);
    let found = blocks_of(&graph);
    assert_eq!(found[0].bodies.len(), 5);
    assert_eq!((found[0].id, &found[0].streets, &found[0].polygon), (alone.id, &alone.streets, &alone.polygon));
}

#[test]
fn a_wide_street_beyond_the_rim_reaches_in() {
    let mut graph = square(Classes::MINOR);
    draw(&mut graph, 5, Classes::MAJOR, 20.0, &[(-50.0, -10.0), (150.0, -10.0)]);
    let block = blocks_of(&graph).remove(0);
    assert!(streets_of(&block).contains(&street(5)));
    let south = buildable(&block).regions[0].polygon.bounds().unwrap().min.y;
    assert_eq!(south, 10 * 1024 + 2);
}

#[test]
fn dead_ends_are_capped_and_their_bends_filled() {
    let mut graph = square(Classes::MINOR);
    draw(&mut graph, 5, Classes::MINOR, 3.0, &[(50.0, 0.0), (50.0, 40.0), (70.0, 60.0)]);
    let block = blocks_of(&graph).remove(0);
    let antennas: Vec<&Body> = block.bodies.iter().filter(|body| body.street == street(5)).collect();
    assert_eq!(antennas.len(), 2);
    let joints: Vec<Joint> = antennas.iter().flat_map(|body| [body.before, body.after]).collect();
    let count = |wanted: fn(&Joint) -> bool| joints.iter().filter(|joint| wanted(joint)).count();
    assert_eq!(count(|joint| *joint == Joint::Capped), 1);
    assert_eq!(count(|joint| matches!(joint, Joint::Bend(_))), 2);
    assert!(!block.streets.contains(&street(5)));
}

/// How far (LSB) the rounding of a crossing next to a bend may shift the tip of its mitre: one unit at the crossing,
/// carried from there to the tip.
fn carried_rounding(graph: &StreetGraph, arms: [HalfKey; 2], half: i32) -> i32 {
    let length = |arm: HalfKey| graph.line(arm).0.distance(graph.line(arm).1) * Point::UNITS_PER_METRE;
    let shortest = arms.map(length).into_iter().fold(f64::INFINITY, f64::min);
    (MITRE_LIMIT * f64::from(half) / shortest).ceil() as i32
}

/// The exact bodies of a graph, three units within what the external checker takes for them.
fn exact_bodies(graph: &StreetGraph) -> Vec<Polygon> {
    let mut bodies = Vec::new();
    for (key, segment) in graph.segments_unsorted() {
        let (from, to) = graph.line(key.forward());
        let half = segment.half_width() - 3;
        bodies.extend(strip(from, to, Reach { left: half, right: half, before: -3, after: -3 }));
    }
    let mut bodies: Vec<Polygon> = bodies.into_iter().map(|ring| Polygon::new(ring.into(), vec![])).collect();
    for (node, _) in graph.nodes_unsorted() {
        if let [a, b] = *graph.halves_ccw(node) {
            let half = graph.segment(a.segment()).half_width().min(graph.segment(b.segment()).half_width()) - 3;
            let half = half - carried_rounding(graph, [a, b], half);
            let ring = wedge(graph.line(a).1, graph.at(node), graph.line(b).1, half, half);
            bodies.extend(ring.map(|ring| Polygon::new(ring, vec![])));
        }
    }
    bodies
}

fn graphs() -> impl Strategy<Value = StreetGraph> {
    let place = (0.0..300.0f64, 0.0..300.0f64);
    let streets = prop::collection::vec((prop::collection::vec(place, 2..5), 2.0..16.0f64), 3..14);
    streets.prop_map(|streets| {
        let mut graph = square(Classes::MAJOR);
        for (n, (points, half_width)) in streets.iter().enumerate() {
            draw(&mut graph, 10 + n as u64, Classes::MINOR, *half_width, points);
        }
        graph
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn no_region_overlaps_any_street(graph in graphs()) {
        let bodies = exact_bodies(&graph);
        for block in blocks_of(&graph) {
            let land: Vec<Polygon> = buildable(&block).regions.into_iter().map(|region| region.polygon).collect();
            let bounds = block.polygon.bounds().unwrap();
            let near = bodies.iter().filter(|body| body.bounds().is_some_and(|other| other.overlaps(&bounds)));
            let common = boolean::intersection(&land, &near.cloned().collect::<Vec<_>>());
            prop_assert!(common.is_empty(), "{common:?} of block {block:?}");
        }
    }

    #[test]
    fn parcels_of_blocks_lie_in_their_block_and_nowhere_twice(graph in graphs()) {
        let settings = RecursiveSettings::default();
        let mut parcels: Vec<Polygon> = Vec::new();
        for block in blocks_of(&graph) {
            let own: Vec<_> = subdivide(&block, &settings).unwrap().parcels.into_iter().map(|p| p.polygon).collect();
            prop_assert!(boolean::difference(&own, std::slice::from_ref(&block.polygon)).is_empty());
            parcels.extend(own);
        }
        let sum: i128 = parcels.iter().map(Polygon::doubled_area).sum();
        let united: i128 = boolean::union(&parcels).iter().map(Polygon::doubled_area).sum();
        prop_assert_eq!(sum, united);
    }
}
