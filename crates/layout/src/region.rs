//! Buildable regions: a block minus the rights-of-way that reach it (algorithms: subtract, do not offset).
//!
//! One integer boolean takes the bodies out of the block. Each body is drawn out by two LSB before it is rounded
//! ([`geom::strip`]), so that a region keeps off the exact body even after its own corners are rounded: V7 holds
//! without a tolerance. Regions are then cleaned, always inwards: short edges are collapsed, touching rings are
//! parted.

mod clean;
mod keep;
mod label;

pub use keep::{Parted, part_grounds};

use crate::{Block, Body, Joint, Region};
use geom::polygon::ring_edges;
use geom::predicates::{meets, orient};
use geom::strip::{Reach, strip, wedge};
use geom::{Bounds, Point, Polygon, boolean};
use streets::StreetId;

/// Twice the least area of a region or parcel: 1 m² in LSB². What is smaller is lost land, counted but not kept.
pub(crate) const LEAST_DOUBLED_AREA: i128 = 2 << 20;

/// What a block leaves for parcels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Buildable {
    /// By least corner.
    pub regions: Vec<Region>,
    /// Twice the area of the land that lies in no right-of-way but was cleaned away, in LSB²: pieces under 1 m², and
    /// slivers at collapsed edges.
    pub dropped: i128,
}

/// A convex piece of a right-of-way, as it is taken out of the block.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub street: StreetId,
    pub ring: Vec<Point>,
    pub bounds: Bounds,
}

impl Piece {
    fn new(street: StreetId, ring: Vec<Point>) -> Option<Self> {
        Bounds::of(ring.iter().copied()).map(|bounds| Self { street, ring, bounds })
    }

    pub fn polygon(self) -> Polygon {
        Polygon::new(self.ring, Vec::new())
    }

    /// Whether the closed line has a point in common with the piece's border, or lies in it.
    pub fn meets(&self, a: Point, b: Point) -> bool {
        let inside = |p: Point| ring_edges(&self.ring).all(|(c, d)| orient(c, d, p) >= 0);
        self.bounds.overlaps(&Bounds::between(a, b))
            && (inside(a) || ring_edges(&self.ring).any(|(c, d)| meets(a, b, c, d)))
    }
}

/// The parts of a block that no right-of-way reaches. A block without area, or wholly covered, leaves none.
pub fn buildable(block: &Block) -> Buildable {
    let pieces = pieces_in(block);
    let land = subtract(block, &pieces);
    let found: i128 = land.iter().map(Polygon::doubled_area).sum();
    let mut kept: Vec<Polygon> = land.into_iter().flat_map(clean::cleaned).collect();
    kept.sort_unstable_by(|a, b| (&a.outer, &a.holes).cmp(&(&b.outer, &b.holes)));
    let dropped = found - kept.iter().map(Polygon::doubled_area).sum::<i128>();
    let region = |(i, polygon): (usize, Polygon)| Region {
        block: block.id,
        ordinal: i as u32,
        frontage: polygon.rings().map(|ring| label::streets_of_edges(ring, &pieces)).collect(),
        polygon,
    };
    Buildable { regions: kept.into_iter().enumerate().map(region).collect(), dropped }
}

/// What the bodies of a block leave of it, not cleaned.
pub(crate) fn land_between(block: &Block) -> Vec<Polygon> {
    subtract(block, &pieces_in(block))
}

fn subtract(block: &Block, pieces: &[Piece]) -> Vec<Polygon> {
    let removed: Vec<Polygon> = pieces.iter().cloned().map(Piece::polygon).collect();
    boolean::difference(std::slice::from_ref(&block.polygon), &removed)
}

/// The pieces of all rights-of-way whose box reaches the block's.
fn pieces_in(block: &Block) -> Vec<Piece> {
    let Some(bounds) = block.polygon.bounds() else { return Vec::new() };
    let mut pieces = corner_pieces(block);
    pieces.extend(block.bodies.iter().flat_map(body_pieces));
    pieces.retain(|piece| piece.bounds.overlaps(&bounds));
    pieces
}

/// The strip of a body, its caps, and the mitres at its bends.
pub(crate) fn body_pieces(body: &Body) -> impl Iterator<Item = Piece> {
    let half = body.half_width.max(0);
    let cap = |joint: Joint| if joint == Joint::Capped { half } else { 0 };
    let reach = Reach { left: half, right: half, before: cap(body.before), after: cap(body.after) };
    let bend_before = match body.before {
        Joint::Bend(before) => wedge(before, body.from, body.to, half, half),
        _ => None,
    };
    let bend_after = match body.after {
        Joint::Bend(after) => wedge(body.from, body.to, after, half, half),
        _ => None,
    };
    let quad = strip(body.from, body.to, reach).map(Vec::from);
    let street = body.street;
    [quad, bend_before, bend_after].into_iter().flatten().filter_map(move |ring| Piece::new(street, ring))
}

/// Covers for the corners where the block's rim turns away from the block and so leaves a gap between two bodies.
fn corner_pieces(block: &Block) -> Vec<Piece> {
    let mut sides: Vec<&Body> = block.bodies.iter().collect();
    sides.sort_by_key(|body| (body.from, body.to));
    let side = |from: Point, to: Point| {
        let first = sides.partition_point(|body| (body.from, body.to) < (from, to));
        sides.get(first).filter(|body| (body.from, body.to) == (from, to))
    };
    let mut pieces = Vec::new();
    for ring in block.polygon.rings() {
        for i in 0..ring.len() {
            let (before, at, after) = (ring[(i + ring.len() - 1) % ring.len()], ring[i], ring[(i + 1) % ring.len()]);
            if orient(before, at, after) >= 0 {
                continue;
            }
            if let (Some(a), Some(b)) = (side(before, at), side(at, after)) {
                let ring = wedge(before, at, after, a.half_width.max(0), b.half_width.max(0));
                let street = if a.half_width >= b.half_width { a.street } else { b.street };
                pieces.extend(ring.and_then(|ring| Piece::new(street, ring)));
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests;
