//! The words of land: blocks with the rights-of-way that reach them, parcels with their frontage.

use geom::polygon::ring_edges;
use geom::{Id, Point, Polygon};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::StreetId;

/// How a straight piece of right-of-way ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Joint {
    /// Square at its end point: a crossing, or a bend that a neighbouring body draws.
    #[default]
    Flat,
    /// The street goes on bent towards this point of its centre line: the mitre at the bend belongs to the body.
    Bend(Point),
    /// A dead end: half a width longer than its centre line, so that land keeps off all round.
    Capped,
}

/// A straight piece of right-of-way that reaches into a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Body {
    /// The street it belongs to.
    pub street: StreetId,
    /// Start of its centre line.
    pub from: Point,
    /// End of its centre line.
    pub to: Point,
    /// Half of the width, in LSB.
    pub half_width: i32,
    /// What lies before `from`.
    pub before: Joint,
    /// What lies after `to`.
    pub after: Joint,
}

/// A block and everything that its division needs; depends on nothing outside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// The signature of its face.
    pub id: Id,
    /// The quarter it lies in, if any.
    pub quarter: Option<Id>,
    /// Its core ring between centre lines, antennas and foreign T crossings left out, with holes.
    pub polygon: Polygon,
    /// Streets of its rim (id order, unique).
    pub streets: Vec<StreetId>,
    /// Rights-of-way that reach it: sides (from and to are an edge of the polygon), antennas, and wide streets beyond.
    pub bodies: Vec<Body>,
}

/// A piece of a block that no right-of-way reaches.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its block.
    pub block: Id,
    /// Its place among the regions of the block, by their least corner.
    pub ordinal: u32,
    /// Simple rings that touch nowhere, edges of at least [`geom::tolerance::PARCEL_EDGE`]. Holes where an antenna tree
    /// or an island stands free.
    pub polygon: Polygon,
    /// For each ring (the outer one first) and each of its edges, by the corner it starts at: the street whose border
    /// the edge lies on.
    pub frontage: Vec<Vec<Option<StreetId>>>,
}

impl Region {
    /// Streets that the region fronts, by id, with the length of frontage in metres.
    pub fn access(&self) -> Vec<(StreetId, f64)> {
        let mut access: BTreeMap<StreetId, f64> = BTreeMap::new();
        for (ring, streets) in self.polygon.rings().zip(&self.frontage) {
            for ((a, b), street) in ring_edges(ring).zip(streets) {
                if let Some(street) = street {
                    *access.entry(*street).or_default() += a.distance(b);
                }
            }
        }
        access.into_iter().collect()
    }
}

impl Parcel {
    /// Whether it lies behind others and may be built on all the same.
    pub fn is_inner(&self) -> bool {
        self.usage == Use::Built && self.access.is_empty()
    }
}

/// What a parcel is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Use {
    /// May carry a building.
    Built,
    /// Open land: too small, too thin, or without access.
    Open,
    /// A park.
    Park,
    /// A plaza.
    Plaza,
}

/// A lot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parcel {
    /// hash(block, region, path in the division).
    pub id: Id,
    /// Its block.
    pub block: Id,
    /// Simple, counter-clockwise, without holes where the division could avoid them.
    pub polygon: Polygon,
    /// Streets it fronts, by id, with the length of frontage in metres.
    pub access: Vec<(StreetId, f64)>,
    /// For each edge of the outer ring, by the corner it starts at: which entry of `access` it fronts.
    pub sides: Vec<Option<u16>>,
    /// What it is for.
    pub usage: Use,
    /// Words that rules put on it, in alphabetical order.
    pub tags: Vec<Arc<str>>,
}
