//! Blocks to divide.

use geom::point::units;
use geom::{Angle, Id, Point, Polygon, Seed, Vec2};
use layout::{Block, Body, Joint};
use streets::StreetId;

/// Parcels that a block gives, about.
const PARCELS_PER_BLOCK: usize = 24;

/// Blocks as cities have them, for about so many parcels: 120 to 280 m by 70 to 130 m, turned and skewed, some with a
/// side that is bent.
pub fn blocks(parcels: usize) -> Vec<Block> {
    let count = parcels / PARCELS_PER_BLOCK;
    let side = (count as f64).sqrt().ceil() as usize;
    (0..count).map(|k| block(k as u64, Vec2::new((k % side) as f64, (k / side) as f64) * 300.0)).collect()
}

fn block(k: u64, at: Vec2) -> Block {
    let draw = |n: u64, low: f64, high: f64| Seed(7).child(k).range(n, low, high);
    let (half, along) =
        (Vec2::new(draw(0, 60.0, 140.0), draw(1, 35.0, 65.0)), Angle::degrees(draw(2, 0.0, 360.0)).unit());
    let skew = |n: u64| draw(n, -0.12, 0.12);
    let corner = |(n, (x, y)): (u64, (f64, f64))| Vec2::new(x + skew(2 * n), y + skew(2 * n + 1));
    let mut corners: Vec<Vec2> = (5..).zip([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]).map(corner).collect();
    if draw(3, 0.0, 1.0) < 0.4 {
        corners.insert(1, Vec2::new(skew(20), -1.0 + 2.0 * skew(21)));
    }
    if draw(4, 0.0, 1.0) < 0.4 {
        corners.push(Vec2::new(-1.0 + skew(22), skew(23)));
    }
    let place = |c: &Vec2| Point::from_metres(at + along * (c.x * half.x) + along.perp() * (c.y * half.y));
    let polygon = Polygon::new(corners.iter().map(place).collect(), Vec::new());
    let id = Id::root("bench block", &[u128::from(k)]);
    let body = |(i, (from, to)): (usize, (Point, Point))| Body {
        street: StreetId(id.child(i as u64)),
        from,
        to,
        half_width: units(if i % 2 == 0 { 9.0 } else { 6.0 }),
        before: Joint::Flat,
        after: Joint::Flat,
    };
    let bodies: Vec<Body> = polygon.edges().enumerate().map(body).collect();
    let mut streets: Vec<StreetId> = bodies.iter().map(|body| body.street).collect();
    streets.sort_unstable();
    Block { id, quarter: None, polygon, streets, bodies }
}
