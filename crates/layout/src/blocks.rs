//! Blocks from the faces of a street graph, each with the rights-of-way that reach it.

use crate::region::{Piece, body_pieces, land_between};
use crate::{Block, Body, Joint};
use geom::predicates::{dot, orient};
use geom::{Bounds, Id, Point, Polygon, boolean};
use streets::faces::{Face, Faces, Side};
use streets::{HalfKey, NodeKey, SegmentKey, StreetGraph};

/// No face.
const NONE: u32 = u32::MAX;

/// All blocks of a graph, in the order of `faces`. `faces` and `quarters` are the faces of `graph` of either kind.
pub fn blocks(graph: &StreetGraph, faces: &Faces, quarters: &Faces) -> Vec<Block> {
    let source = BlockSource::new(graph, faces, quarters);
    (0..faces.faces.len()).map(|face| source.block(face)).collect()
}

/// What blocks are made from. One block does not need another, so a caller may make them on many threads.
pub struct BlockSource<'a> {
    graph: &'a StreetGraph,
    faces: &'a Faces,
    /// By block face: the id of its quarter.
    quarter_of: Vec<Option<Id>>,
    onward: Onward,
    /// How far any right-of-way reaches from its centre line, mitres included, in LSB.
    reach: i32,
}

/// By half: the half that goes on straight over a crossing that a street of a quarter made on a rim, where there is one.
/// Whether a crossing is one takes a hash, and every block beside it asks.
struct Onward(Vec<Option<HalfKey>>);

impl Onward {
    fn of(graph: &StreetGraph) -> Self {
        let mut onward = vec![None; graph.half_capacity()];
        for (key, _) in graph.segments_unsorted() {
            for half in [key.forward(), key.backward()] {
                onward[half.index()] = next_of(graph, half);
            }
        }
        Self(onward)
    }

    fn next(&self, half: HalfKey) -> Option<HalfKey> {
        self.0.get(half.index()).copied().flatten()
    }
}

impl<'a> BlockSource<'a> {
    /// Prepares what all blocks share, in linear time.
    pub fn new(graph: &'a StreetGraph, faces: &'a Faces, quarters: &'a Faces) -> Self {
        let onward = Onward::of(graph);
        let on_ground = graph.segments_unsorted().filter(|(_, segment)| segment.level == 0);
        let reach = |(key, _)| reach_of(&segment_body(graph, &onward, key, &|_| true));
        let reach = on_ground.map(reach).max().unwrap_or(0);
        Self { graph, faces, quarter_of: quarters_of_blocks(faces, quarters), onward, reach }
    }

    /// The block of a face, by its position among the faces. Panics when there is no such face.
    pub fn block(&self, face: usize) -> Block {
        let found = &self.faces.faces[face];
        let polygon = polygon_of(found);
        let mut bodies = Vec::new();
        for sides in std::iter::once(&found.sides).chain(&found.hole_sides) {
            bodies.extend(side_bodies(&from_least(sides)));
        }
        let mut streets: Vec<_> = bodies.iter().map(|body: &Body| body.street).collect();
        streets.sort_unstable();
        streets.dedup();
        bodies.extend(
            self.by_id(found.antennas.clone()).map(|key| segment_body(self.graph, &self.onward, key, &|_| true)),
        );
        let mut block = Block { id: found.id, quarter: self.quarter_of[face], polygon, streets, bodies };
        let foreign = self.foreign_bodies(face as u32, &block);
        block.bodies.extend(foreign);
        block
    }

    /// Segments by stable id: keys depend on history.
    fn by_id(&self, mut keys: Vec<SegmentKey>) -> impl Iterator<Item = SegmentKey> {
        keys.sort_unstable_by_key(|key| self.graph.segment(*key).id);
        keys.into_iter()
    }

    /// Rights-of-way of streets that do not lie on the block's rims but reach into land that its own leave free: of those
    /// that close quarters in stretches that do not show what else meets them.
    fn foreign_bodies(&self, face: u32, block: &Block) -> Vec<Body> {
        let Some(bounds) = block.polygon.bounds() else { return Vec::new() };
        let is_foreign = |key: &SegmentKey| {
            let of = |half: HalfKey| self.faces.face_of.get(half.index()).copied().unwrap_or(NONE);
            self.graph.segment(*key).level == 0 && of(key.forward()) != face && of(key.backward()) != face
        };
        let mut near = self.graph.segments_near(bounds.grown(self.reach));
        near.retain(is_foreign);
        let is_corner = |at: Point| block.polygon.rings().any(|ring| ring.contains(&at));
        let mut bodies: Vec<Body> =
            near.into_iter().map(|key| segment_body(self.graph, &self.onward, key, &is_corner)).collect();
        bodies.sort_unstable_by_key(|body| (body.from, body.to, body.street));
        bodies.dedup();
        bodies.retain(|body| body_pieces(body).any(|piece| may_reach(&piece, block)));
        if bodies.is_empty() {
            return bodies;
        }
        let land = land_between(block);
        bodies.retain(|body| {
            !boolean::intersection(&body_pieces(body).map(Piece::polygon).collect::<Vec<_>>(), &land).is_empty()
        });
        bodies
    }
}

/// The outline of a face's core: its sides from corner to corner, each ring from its least corner on.
pub fn polygon_of(face: &Face) -> Polygon {
    let ring = |sides: &Vec<Side>| from_least(sides).iter().map(|side| side.from).collect();
    Polygon::new(ring(&face.sides), face.hole_sides.iter().map(ring).collect())
}

/// The sides of a rim, starting at its least corner: where a walk starts depends on keys.
fn from_least(sides: &[Side]) -> Vec<Side> {
    let mut sides = sides.to_vec();
    let least = sides.iter().enumerate().min_by_key(|(_, side)| side.from).map_or(0, |(i, _)| i);
    sides.rotate_left(least);
    sides
}

/// A rim's bodies. The mitre of a bend belongs to the side before it.
fn side_bodies(sides: &[Side]) -> impl Iterator<Item = Body> {
    sides.iter().enumerate().map(|(i, side)| {
        let next = &sides[(i + 1) % sides.len()];
        let goes_on = next.street == side.street && next.half_width == side.half_width;
        let after = if goes_on { Joint::Bend(next.to) } else { Joint::Flat };
        Body {
            street: side.street,
            from: side.from,
            to: side.to,
            half_width: side.half_width,
            before: Joint::Flat,
            after,
        }
    })
}

/// The body of a segment, from its lesser end to its greater; on a rim of quarters that of its whole stretch, up to the
/// places where it must end.
fn segment_body(graph: &StreetGraph, onward: &Onward, key: SegmentKey, must_end: &dyn Fn(Point) -> bool) -> Body {
    let forward = key.forward();
    let half = if graph.at(graph.origin(forward)) < graph.at(graph.target(forward)) { forward } else { forward.twin() };
    let (start, end) = (last_of(graph, onward, half.twin(), must_end).twin(), last_of(graph, onward, half, must_end));
    let segment = graph.segment(key);
    Body {
        street: segment.leading().street,
        from: graph.at(graph.origin(start)),
        to: graph.at(graph.target(end)),
        half_width: segment.half_width(),
        before: joint(graph, onward, graph.origin(start), start),
        after: joint(graph, onward, graph.target(end), end.twin()),
    }
}

/// The last half of the straight stretch of a rim that a half leads along: on over the crossings that streets of quarters
/// make with it. Their rounding would move land across the rim by a unit.
fn last_of(graph: &StreetGraph, onward: &Onward, half: HalfKey, must_end: &dyn Fn(Point) -> bool) -> HalfKey {
    let mut last = half;
    while let Some(next) = onward.next(last).filter(|_| !must_end(graph.at(graph.target(last)))) {
        last = next;
        if last == half {
            break;
        }
    }
    last
}

/// The half that goes on straight from a half over a crossing on a rim.
fn next_of(graph: &StreetGraph, half: HalfKey) -> Option<HalfKey> {
    let segment = graph.segment(half.segment());
    let (street, node) = (segment.leading().street, graph.node(graph.target(half)));
    if !node.id.is_on_rim(street, node.at) {
        return None;
    }
    let goes_on = |arm: HalfKey| {
        let other = graph.segment(arm.segment());
        let is_alike = other.level == segment.level && other.half_width() == segment.half_width();
        arm != half.twin() && is_alike && other.leading().street == street
    };
    graph.halves_ccw(graph.target(half)).iter().copied().find(|&arm| goes_on(arm))
}

/// How a segment ends at a node, given its half that leaves the node: what gap there is between it and its neighbours
/// is where two consecutive arms stand more than half a turn apart.
fn joint(graph: &StreetGraph, onward: &Onward, node: NodeKey, half: HalfKey) -> Joint {
    if graph.degree(node) == 1 {
        return Joint::Capped;
    }
    let arms: Vec<HalfKey> = graph.halves_ccw(node).iter().copied().filter(|&arm| graph.level(arm) == 0).collect();
    let Some(i) = arms.iter().position(|&arm| arm == half) else { return Joint::Flat };
    let (left, right) = (arms[(i + 1) % arms.len()], arms[(i + arms.len() - 1) % arms.len()]);
    let far = |arm: HalfKey| graph.at(graph.target(last_of(graph, onward, arm, &|_| false)));
    let (at, ahead) = (graph.at(node), far(half));
    // The next arm counter-clockwise lies right of this one, or the next clockwise one left of it: a reflex gap.
    if left != half && orient(at, ahead, far(left)) < 0 {
        Joint::Bend(far(left))
    } else if right != half && orient(at, ahead, far(right)) > 0 {
        Joint::Bend(far(right))
    } else {
        Joint::Flat
    }
}

/// How far a body reaches beyond the box of its centre line, in LSB.
fn reach_of(body: &Body) -> i32 {
    let line = Bounds::between(body.from, body.to);
    let beyond = |bounds: Bounds| {
        let sides = [
            line.min.x - bounds.min.x,
            line.min.y - bounds.min.y,
            bounds.max.x - line.max.x,
            bounds.max.y - line.max.y,
        ];
        sides.into_iter().max().unwrap_or(0)
    };
    body_pieces(body).map(|piece| beyond(piece.bounds)).max().unwrap_or(0)
}

/// Whether a piece may take land that the block's own rim does not: cheap, exact where it says no. A street that ends
/// on a straight side reaches no farther than that side does.
fn may_reach(piece: &Piece, block: &Block) -> bool {
    if !block.polygon.bounds().is_some_and(|bounds| bounds.overlaps(&piece.bounds)) {
        return false;
    }
    let mut met = block.polygon.edges().filter(|&(a, b)| piece.meets(a, b));
    match (met.next(), met.next()) {
        (None, _) => block.polygon.contains(piece.ring[0]),
        (Some((from, to)), None) => {
            let side = block.bodies.iter().find(|body| (body.from, body.to) == (from, to));
            let covered = |p: Point| side.is_some_and(|side| in_strip(side, p));
            piece.ring.iter().any(|&p| orient(from, to, p) > 0 && !covered(p))
        }
        _ => true,
    }
}

/// Whether a point lies in the closed exact strip of a body.
fn in_strip(body: &Body, p: Point) -> bool {
    let along = dot(body.from, body.to, p);
    let (across, length_squared) = (i128::from(orient(body.from, body.to, p)), body.from.distance_squared(body.to));
    let half = i128::from(body.half_width);
    (0..=length_squared).contains(&along) && across * across <= half * half * i128::from(length_squared)
}

/// The quarter of each block: that on the same side of a rim they share, and else that of a block next door, since what
/// lies between is no quarter's rim.
fn quarters_of_blocks(faces: &Faces, quarters: &Faces) -> Vec<Option<Id>> {
    let quarter_beside = |half: HalfKey| quarters.face_of.get(half.index()).copied().unwrap_or(NONE);
    let mut quarter_of = vec![NONE; faces.faces.len()];
    for (face, quarter) in faces.faces.iter().zip(&mut quarter_of) {
        *quarter = halves(face).map(quarter_beside).find(|&quarter| quarter != NONE).unwrap_or(NONE);
    }
    let mut open: Vec<usize> = (0..quarter_of.len()).filter(|&face| quarter_of[face] != NONE).collect();
    while let Some(face) = open.pop() {
        for half in halves(&faces.faces[face]).filter(|&half| quarter_beside(half) == NONE) {
            let next = faces.face_of.get(half.twin().index()).copied().unwrap_or(NONE) as usize;
            if quarter_of.get(next) == Some(&NONE) {
                quarter_of[next] = quarter_of[face];
                open.push(next);
            }
        }
    }
    quarter_of.into_iter().map(|quarter| quarters.faces.get(quarter as usize).map(|face| face.id)).collect()
}

/// The halves of all rims of a face.
fn halves(face: &Face) -> impl Iterator<Item = HalfKey> {
    std::iter::once(&face.outer).chain(&face.holes).flat_map(|rim| rim.halves.iter().copied())
}

#[cfg(test)]
mod tests;
