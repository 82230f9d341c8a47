//! Blocks for tests: plain ones and awkward ones.

use crate::{Block, Body, Joint};
use geom::{Id, Point, Polygon, point::units};
use proptest::prelude::*;
use streets::StreetId;

pub(crate) fn street(n: u64) -> StreetId {
    StreetId(Id::root("test street", &[u128::from(n)]))
}

pub(crate) fn ring(corners: &[(f64, f64)]) -> Vec<Point> {
    corners.iter().map(|&(x, y)| Point::new(units(x), units(y))).collect()
}

/// A block with a street of its own along each edge, of half the width given for it (cycled), in metres.
pub(crate) fn block(polygon: Polygon, half_widths: &[f64]) -> Block {
    let mut bodies = Vec::new();
    for (i, (from, to)) in polygon.edges().enumerate() {
        let half_width = units(half_widths[i % half_widths.len()]);
        let street = street(i as u64);
        bodies.push(Body { street, from, to, half_width, before: Joint::Flat, after: Joint::Flat });
    }
    let mut streets: Vec<_> = bodies.iter().map(|body| body.street).collect();
    streets.sort_unstable();
    Block { id: Id::root("test block", &[polygon.outer.len() as u128]), quarter: None, polygon, streets, bodies }
}

pub(crate) fn rectangle(width: f64, height: f64) -> Polygon {
    Polygon::new(ring(&[(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]), Vec::new())
}

pub(crate) fn antenna(from: (f64, f64), to: (f64, f64), half_width: f64) -> Body {
    let [from, to] = [from, to].map(|(x, y)| Point::new(units(x), units(y)));
    Body { street: street(1000), from, to, half_width: units(half_width), before: Joint::Flat, after: Joint::Capped }
}

/// A star-shaped polygon: radii in metres at equal angles, centred anywhere near.
fn star(radii: Vec<f64>, turn: f64, centre: (f64, f64)) -> Polygon {
    let n = radii.len() as f64;
    let corner = |(i, r): (usize, f64)| {
        let direction = geom::Angle::radians(turn + std::f64::consts::TAU * i as f64 / n).unit();
        (centre.0 + r * direction.x, centre.1 + r * direction.y)
    };
    let corners: Vec<_> = radii.into_iter().enumerate().map(corner).collect();
    Polygon::new(ring(&corners), Vec::new())
}

pub(crate) fn stars() -> impl Strategy<Value = Polygon> {
    (prop::collection::vec(15.0..200.0f64, 3..14), 0.0..6.3f64, (-9000.0..9000.0f64, -9000.0..9000.0f64))
        .prop_map(|(radii, turn, centre)| star(radii, turn, centre))
}

/// Near-rectangles as cities have them, at any angle.
pub(crate) fn quads() -> impl Strategy<Value = Polygon> {
    (prop::array::uniform4(0.85..1.15f64), 0.0..6.3f64, 30.0..250.0f64)
        .prop_map(|(radii, turn, size)| star(radii.iter().map(|r| r * size).collect(), turn, (0.0, 0.0)))
}

pub(crate) fn needles() -> impl Strategy<Value = Polygon> {
    (100.0..800.0f64, 0.05..40.0f64, -0.2..1.2f64).prop_map(|(length, height, apex)| {
        Polygon::new(ring(&[(0.0, 0.0), (length, 0.0), (length * apex, height)]), Vec::new())
    })
}

/// A big star with a small one inside as a hole, and dead ends that stand in it.
fn busy() -> impl Strategy<Value = Block> {
    let holes = prop::collection::vec((prop::collection::vec(8.0..25.0f64, 3..7), 0.0..6.3f64), 0..3);
    let outer = prop::collection::vec(120.0..250.0f64, 4..9);
    let antennas = prop::collection::vec(
        ((-250.0..250.0f64, -250.0..250.0f64), (-100.0..100.0f64, -100.0..100.0f64), 2.0..9.0f64),
        0..4,
    );
    (outer, holes, antennas, 2.0..12.0f64, 3.0..9.0f64).prop_map(|(outer, holes, antennas, wide, narrow)| {
        let centre = |i: usize| [(-55.0, 3.0), (50.0, 41.0), (8.0, -60.0)][i];
        let holes = holes.into_iter().enumerate().map(|(i, (radii, turn))| star(radii, turn, centre(i)).outer);
        let polygon = Polygon::new(star(outer, 0.3, (0.0, 0.0)).outer, holes.collect());
        let mut block = block(polygon, &[wide, narrow, 4.0]);
        block.bodies.extend(antennas.into_iter().map(|(from, to, half)| antenna(from, to, half)));
        block
    })
}

pub(crate) fn blocks() -> impl Strategy<Value = Block> {
    let widths = prop::collection::vec(2.0..14.0f64, 1..4);
    let plain = prop_oneof![3 => quads(), 3 => stars(), 1 => needles()];
    prop_oneof![3 => (plain, widths).prop_map(|(polygon, widths)| block(polygon, &widths)), 1 => busy()]
}

/// Anything: a few lattice points close together, rings that cut into themselves, widths from nothing to everything.
pub(crate) fn nasty() -> impl Strategy<Value = Block> {
    let near = prop_oneof![-40..40i32, -4000..4000i32, -50_000..50_000i32];
    let corner = (near.clone(), near).prop_map(|(x, y)| Point::new(x, y));
    let rings = prop::collection::vec(prop::collection::vec(corner, 0..9), 1..3);
    (rings, prop::collection::vec(-5i32..20_000, 1..3)).prop_map(|(mut rings, widths)| {
        let outer = rings.remove(0);
        let mut block = block(Polygon::new(outer, rings), &[1.0]);
        for (i, body) in block.bodies.iter_mut().enumerate() {
            body.half_width = widths[i % widths.len()];
            body.after = [Joint::Flat, Joint::Capped, Joint::Bend(Point::new(7, i as i32))][i % 3];
        }
        block
    })
}
