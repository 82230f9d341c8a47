//! Blocks and quarters as faces, from scratch.
//!
//! All rims are walked ([`walk`]), each component is placed in the face around it ([`nest`]), and each face is peeled
//! to its core ([`peel`]), from which its sides and its identity come ([`sides`]).

mod nest;
mod peel;
mod sides;
mod walk;

#[cfg(test)]
pub(crate) mod samples;
#[cfg(test)]
mod tests;

use crate::{HalfKey, NodeKey, Segment, SegmentKey, StreetGraph, StreetId};
use geom::{Id, Point, Polygon};
use peel::{Core, Peeler};
use sides::{Corner, Outline};
pub(crate) use walk::{NONE, Rims};

/// Which segments close a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceKind {
    /// Closed by any streets of level 0.
    Block,
    /// Closed by level-0 streets whose class closes quarters (LSWW11 §3.1).
    Quarter,
}

impl FaceKind {
    fn name(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::Quarter => "quarter",
        }
    }

    /// Whether a segment takes part.
    fn admits(self, graph: &StreetGraph, segment: &Segment) -> bool {
        let closes = || segment.claims.iter().any(|claim| graph.classes().info(claim.class).closes_quarters);
        segment.level == 0 && (self == Self::Block || closes())
    }
}

/// One cyclic walk along the rim of a face, the face on its left. Dead ends are walked on both sides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rim {
    /// The halves in order, from the node of least id on.
    pub halves: Vec<HalfKey>,
    /// Twice the signed area in LSB²: positive for an outer rim, zero or negative for the rim of a hole.
    pub doubled_area: i128,
}

/// A side of a face: a maximal straight stretch of one street on its rim, foreign T crossings left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// The street: the most important one that runs there.
    pub street: StreetId,
    /// Half of the right-of-way there (of the widest street), in LSB.
    pub half_width: i32,
    /// From where, with the face on the left.
    pub from: Point,
    /// To where.
    pub to: Point,
    /// The node at `from`.
    pub from_node: NodeKey,
}

/// A bounded face.
#[derive(Clone, Debug)]
pub struct Face {
    /// Signature: hash of the cyclic sequence of (street, direction, corner) of its core rims. A T crossing
    /// from outside does not change it. No two faces of one kind in a graph share it.
    pub id: Id,
    /// The outer rim, antennas included, counter-clockwise.
    pub outer: Rim,
    /// Rims of the components inside it, antennas included, by the node of least id on each.
    pub holes: Vec<Rim>,
    /// Twice its area in LSB², holes subtracted.
    pub doubled_area: i128,
    /// The outer core rim as sides: antennas stripped, foreign T crossings and collinear crossings left out, so that
    /// an attachment from the other side changes nothing here. A simple ring of at least three sides; it starts at a
    /// corner that depends on ids alone.
    pub sides: Vec<Side>,
    /// The same for each hole that encloses area, clockwise, by signature. A hole may touch another ring in a node
    /// that both have as a corner.
    pub hole_sides: Vec<Vec<Side>>,
    /// Segments with the face on both sides, by id: dead ends, trees standing free in it, and links between rims.
    pub antennas: Vec<SegmentKey>,
}

impl Face {
    /// The core as a polygon of its sides: simple rings that touch in single points at most, so that it is valid in
    /// the sense of the OGC. Antennas are not part of it.
    pub fn polygon(&self) -> Polygon {
        let ring = |sides: &Vec<Side>| sides.iter().map(|side| side.from).collect();
        Polygon { outer: ring(&self.sides), holes: self.hole_sides.iter().map(ring).collect() }
    }

    /// What growth inside hangs on: the hash of the least (street, direction, corner) of the outer core rim. Neither
    /// a T crossing on the rim nor a change elsewhere on it renames what grows inside. `graph` must be the one that
    /// the face was made from.
    pub fn root(&self, graph: &StreetGraph) -> Id {
        let mut halves = self.outer.halves.clone();
        halves.sort_unstable();
        let mut core = Core::default();
        let is_bridge = |half: HalfKey| halves.binary_search(&half.twin()).is_ok();
        Peeler::new(graph).peel(&self.outer.halves, is_bridge, &mut core);
        let outer = core.cycles.into_iter().max_by_key(|cycle| walk::doubled_area(graph, cycle));
        let least = outer.and_then(|mut cycle| sides::least_corner(graph, &mut cycle));
        let parts = least.map(|Corner { street, forward, at }| [street.0.0, forward.into(), at.0.0]);
        parts.map_or(self.id, |parts| Id::root("face root", &parts))
    }
}

/// All bounded faces of a graph.
#[derive(Clone, Debug)]
pub struct Faces {
    /// By id.
    pub faces: Vec<Face>,
    /// For each [`HalfKey::index`], the position in `faces` of the face at its left; `u32::MAX` for the unbounded
    /// face and for halves that close no face of this kind.
    pub face_of: Vec<u32>,
}

impl Faces {
    /// The faces of a graph that satisfies V1 and V3, from scratch in O((n + h) log n).
    pub fn of(graph: &StreetGraph, kind: FaceKind) -> Self {
        let rims = Rims::walk(graph, |segment| kind.admits(graph, segment));
        let closing = nest::closing_rims(graph, &rims);
        let mut maker = FaceMaker { graph, rims: &rims, kind, peeler: Peeler::new(graph) };
        let holes = holes_by_closing(graph, &rims, &closing);
        let mut holes = holes.chunk_by(|a, b| a.0 == b.0).peekable();
        let mut faces = Vec::with_capacity(rims.len());
        for rim in (0..rims.len()).filter(|&rim| rims.area(rim) > 0) {
            let inside = holes.next_if(|holes| holes[0].0 as usize == rim).unwrap_or_default();
            faces.push((maker.face(rim, inside), rim));
        }
        Self::sorted(make_ids_distinct(graph, &mut faces), faces, &rims, &closing)
    }

    /// The faces in the given order; each comes with its outer rim.
    fn sorted(order: Vec<(Id, usize)>, faces: Vec<(Face, usize)>, rims: &Rims, closing: &[u32]) -> Self {
        let mut slot_of = vec![NONE; rims.len()];
        for (slot, &(_, place)) in order.iter().enumerate() {
            slot_of[faces[place].1] = slot as u32;
        }
        let at = |table: &[u32], i: u32| table.get(i as usize).copied().unwrap_or(NONE);
        let face_of = rims.by_half().iter().map(|&rim| at(&slot_of, at(closing, rim))).collect();
        let mut faces: Vec<Option<Face>> = faces.into_iter().map(|(face, _)| Some(face)).collect();
        let faces = order.into_iter().filter_map(|(_, place)| faces[place].take()).collect();
        Self { faces, face_of }
    }
}

/// (closing rim, rim) of all holes of bounded faces: by closing rim, then by the node of least id.
fn holes_by_closing(graph: &StreetGraph, rims: &Rims, closing: &[u32]) -> Vec<(u32, u32)> {
    let least = |rim: u32| graph.node(graph.origin(rims.halves(rim as usize)[0])).id;
    let is_hole = |&(around, rim): &(u32, u32)| around != NONE && around != rim;
    let mut holes: Vec<(u32, u32)> =
        (0..rims.len() as u32).map(|rim| (closing[rim as usize], rim)).filter(is_hole).collect();
    holes.sort_unstable_by_key(|&(around, rim)| (around, least(rim)));
    holes
}

/// Makes faces from their rims.
struct FaceMaker<'a> {
    graph: &'a StreetGraph,
    rims: &'a Rims,
    kind: FaceKind,
    peeler: Peeler<'a>,
}

impl FaceMaker<'_> {
    /// The face inside a rim, with its holes as (rim around, rim).
    fn face(&mut self, outer: usize, holes: &[(u32, u32)]) -> Face {
        let holes: Vec<Rim> = holes.iter().map(|&(_, rim)| self.rim(rim as usize)).collect();
        let outer = self.rim(outer);
        let core = self.core(&outer, &holes);
        let (sides, hole_sides, id) = self.outlines(core.cycles, &core.pinches);
        Face {
            id,
            doubled_area: outer.doubled_area + holes.iter().map(|hole| hole.doubled_area).sum::<i128>(),
            outer,
            holes,
            sides,
            hole_sides,
            antennas: core.bridges,
        }
    }

    fn rim(&self, rim: usize) -> Rim {
        Rim { halves: self.rims.halves(rim).to_vec(), doubled_area: self.rims.area(rim) }
    }

    fn core(&mut self, outer: &Rim, holes: &[Rim]) -> Core {
        let mut core = Core::default();
        let is_bridge = |half: HalfKey| self.rims.rim_of(half) == self.rims.rim_of(half.twin());
        for rim in std::iter::once(outer).chain(holes) {
            self.peeler.peel(&rim.halves, is_bridge, &mut core);
        }
        core.bridges.sort_unstable_by_key(|&key| self.graph.segment(key).id);
        core
    }

    /// Sides of the outer cycle, sides of the others, and the signature of all.
    fn outlines(&self, cycles: Vec<Vec<HalfKey>>, pinches: &[NodeKey]) -> (Vec<Side>, Vec<Vec<Side>>, Id) {
        // Only the cycle that encloses the face has a positive area.
        let area = |cycle: &Vec<HalfKey>| if cycles.len() == 1 { 1 } else { walk::doubled_area(self.graph, cycle) };
        let outer_place = (0..cycles.len()).max_by_key(|&i| area(&cycles[i])).expect("a face has a core");
        let mut outlines: Vec<_> = cycles.into_iter().map(|cycle| Outline::of(self.graph, cycle, pinches)).collect();
        let outer = outlines.swap_remove(outer_place);
        let mut holes: Vec<_> = outlines.into_iter().map(|hole| (hole.signature(), hole.sides)).collect();
        holes.sort_unstable_by_key(|(id, sides)| (*id, self.graph.node(sides[0].from_node).id));
        let parts: Vec<u128> =
            std::iter::once(outer.signature()).chain(holes.iter().map(|hole| hole.0)).map(|id| id.0).collect();
        let holes = holes.into_iter().map(|(_, sides)| sides).collect();
        (outer.sides, holes, Id::root(self.kind.name(), &parts))
    }
}

/// Tells apart what a signature cannot: faces between the same streets in the same order, where two of them meet more
/// than once. They get the nodes of their own sides into their id (not those of foreign crossings on them). Returns the
/// ids, ascending, with their places in `faces`.
fn make_ids_distinct(graph: &StreetGraph, faces: &mut [(Face, usize)]) -> Vec<(Id, usize)> {
    let mut order: Vec<(Id, usize)> = faces.iter().enumerate().map(|(place, (face, _))| (face.id, place)).collect();
    order.sort_unstable();
    for alike in order.chunk_by_mut(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
        for (id, place) in alike {
            let face = &mut faces[*place].0;
            let sides = face.sides.iter().chain(face.hole_sides.iter().flatten());
            let mut nodes: Vec<u128> = sides.map(|side| graph.node(side.from_node).id.0.0).collect();
            nodes.sort_unstable();
            nodes.insert(0, id.0);
            *id = Id::root("face of equal signature", &nodes);
            face.id = *id;
        }
    }
    order.sort_unstable();
    order
}
