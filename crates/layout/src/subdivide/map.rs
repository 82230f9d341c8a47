//! The planar map of one region under division: cuts add edges to it, so that pieces share borders and corners by
//! construction, no two overlap, and their areas add up exactly.

use crate::Region;
use geom::predicates::orient;
use geom::{Id, Point, Polygon};
use smallvec::{SmallVec, smallvec};
use streets::StreetId;

/// The face beyond the region's rim.
pub(super) const OUTSIDE: u32 = u32::MAX;

/// No street: the border of a cut, or of land that meets no street.
pub(super) const NO_STREET: u16 = u16::MAX;

/// One direction of an edge; its twin has the index with the last bit turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    /// Where it starts: an index into the map's points.
    pub origin: u32,
    /// The next half round its face. Meaningless outside the region.
    pub next: u32,
    /// The one before.
    pub prev: u32,
    /// The face on its left.
    pub face: u32,
    /// The street whose border it lies on: an index into the map's streets.
    pub street: u16,
}

/// A piece of the region.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// One half of each of its rims; none when the face was merged into another. A face has several rims only until the
    /// holes of the region are cut.
    pub rims: SmallVec<[u32; 1]>,
    /// Its place in the division: hash(block, region, sides taken at the cuts).
    pub path: Id,
}

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct LandMap {
    pub points: Vec<Point>,
    pub halves: Vec<Half>,
    pub faces: Vec<Face>,
    /// Sorted.
    pub streets: Vec<StreetId>,
    /// Twice the area that cut ends on the region's rim have taken off it: they are rounded inwards.
    pub trimmed: i128,
}

impl LandMap {
    /// The map with one face, the whole region.
    pub fn new(region: &Region) -> Self {
        let mut streets: Vec<StreetId> = region.frontage.iter().flatten().copied().flatten().collect();
        streets.sort_unstable();
        streets.dedup();
        streets.truncate(usize::from(NO_STREET));
        let path = Id::root("parcel", &[region.block.0, u128::from(region.ordinal)]);
        let faces = vec![Face { rims: SmallVec::new(), path }];
        let mut map = Self { points: Vec::new(), halves: Vec::new(), faces, streets, trimmed: 0 };
        for (i, ring) in region.polygon.rings().enumerate() {
            map.add_rim(ring, region.frontage.get(i).map_or(&[], Vec::as_slice));
        }
        map
    }

    /// Adds a rim of face 0.
    fn add_rim(&mut self, ring: &[Point], frontage: &[Option<StreetId>]) {
        let (corner, half, n) = (self.points.len() as u32, self.halves.len() as u32, ring.len() as u32);
        self.points.extend_from_slice(ring);
        for i in 0..n {
            let (after, before) = ((i + 1) % n, (i + n - 1) % n);
            let street = frontage.get(i as usize).copied().flatten();
            let street = street.and_then(|street| self.streets.binary_search(&street).ok());
            let street = street.map_or(NO_STREET, |index| index as u16);
            let (next, prev) = (half + 2 * after, half + 2 * before);
            self.halves.push(Half { origin: corner + i, next, prev, face: 0, street });
            self.halves.push(Half { origin: corner + after, next: 0, prev: 0, face: OUTSIDE, street });
        }
        self.faces[0].rims.push(half + 2 * first_corner(ring, frontage) as u32);
    }

    /// Where a half starts.
    pub fn start(&self, half: u32) -> Point {
        self.points[self.halves[half as usize].origin as usize]
    }

    /// Where a half ends.
    pub fn end(&self, half: u32) -> Point {
        self.start(half ^ 1)
    }

    pub fn half(&self, half: u32) -> &Half {
        &self.halves[half as usize]
    }

    /// Whether the half lies on the rim of the region.
    pub fn on_rim(&self, half: u32) -> bool {
        self.half(half ^ 1).face == OUTSIDE
    }

    /// The halves of a rim in order, from `first` on.
    pub fn rim(&self, first: u32) -> impl Iterator<Item = u32> {
        let following = move |&half: &u32| Some(self.half(half).next).filter(|&next| next != first);
        std::iter::successors(Some(first), following)
    }

    /// The halves of all rims of a face.
    pub fn halves_of(&self, face: u32) -> impl Iterator<Item = u32> {
        self.faces[face as usize].rims.iter().flat_map(|&first| self.rim(first))
    }

    /// The faces that have not been merged into others.
    pub fn live_faces(&self) -> impl Iterator<Item = u32> {
        (0..self.faces.len() as u32).filter(|&face| !self.faces[face as usize].rims.is_empty())
    }

    /// The outline of a face; further rims become holes.
    pub fn polygon(&self, face: u32) -> Polygon {
        let ring = |&first: &u32| self.rim(first).map(|half| self.start(half)).collect();
        let mut rings = self.faces[face as usize].rims.iter().map(ring);
        Polygon { outer: rings.next().unwrap_or_default(), holes: rings.collect() }
    }

    /// For each edge of a face's outer rim, which of its streets it fronts, as `index` numbers them.
    pub fn sides(&self, face: u32, index: impl Fn(u16) -> Option<usize>) -> Vec<Option<u16>> {
        let first = self.faces[face as usize].rims.first();
        let side = |half: u32| index(self.half(half).street).map(|index| index as u16);
        first.map(|&first| self.rim(first).map(side).collect()).unwrap_or_default()
    }

    /// Puts a corner on the edge of a half, for the faces on both of its sides, and returns the half that starts there.
    /// On the rim of the region the corner must not lie outside of it.
    pub fn insert_corner(&mut self, half: u32, at: Point) -> u32 {
        if self.on_rim(half) {
            self.trimmed += i128::from(orient(self.start(half), self.end(half), at));
        }
        let (ahead, back, twin) = (self.halves.len() as u32, self.halves.len() as u32 + 1, half ^ 1);
        let corner = self.points.len() as u32;
        self.points.push(at);
        let (front, rear) = (*self.half(half), *self.half(twin));
        self.halves.push(Half { origin: corner, prev: half, ..front });
        self.halves.push(Half { next: twin, ..rear });
        self.halves[twin as usize].origin = corner;
        self.halves[half as usize].next = ahead;
        self.halves[front.next as usize].prev = ahead;
        if rear.face != OUTSIDE {
            self.halves[twin as usize].prev = back;
            self.halves[rear.prev as usize].next = back;
        }
        ahead
    }

    /// Adds the edge between the starts of two halves of one face and returns its two halves. Joins two rims, or leaves
    /// two in the place of one: the caller says what faces they make.
    pub fn connect(&mut self, from: u32, to: u32) -> (u32, u32) {
        let (there, back) = (self.halves.len() as u32, self.halves.len() as u32 + 1);
        let (before_from, before_to) = (self.half(from).prev, self.half(to).prev);
        let face = self.half(from).face;
        let new = |origin, next, prev| Half { origin, next, prev, face, street: NO_STREET };
        let (start, end) = (self.half(from).origin, self.half(to).origin);
        self.halves.push(new(start, to, before_from));
        self.halves.push(new(end, from, before_to));
        self.halves[before_from as usize].next = there;
        self.halves[to as usize].prev = there;
        self.halves[before_to as usize].next = back;
        self.halves[from as usize].prev = back;
        (there, back)
    }

    /// Cuts a face with one rim between the starts of two of its halves. What lies left of the cut keeps the face's
    /// index; what lies right of it becomes the face returned.
    pub fn split(&mut self, from: u32, to: u32) -> u32 {
        let face = self.half(from).face;
        let (left, right) = self.connect(from, to);
        let path = self.faces[face as usize].path;
        let other = self.faces.len() as u32;
        self.faces[face as usize] = Face { rims: smallvec![left], path: path.child(0) };
        self.faces.push(Face { rims: smallvec![right], path: path.child(1) });
        self.assign(right, other);
        other
    }

    /// Gives all halves of a rim to a face.
    pub fn assign(&mut self, first: u32, face: u32) {
        let mut half = first;
        loop {
            self.halves[half as usize].face = face;
            half = self.half(half).next;
            if half == first {
                return;
            }
        }
    }
}

/// The corner that a rim is read from: where its first street by id begins, so that a turned region is divided in the
/// same way, turned; the longest such edge, or the first corner of a rim along one street.
fn first_corner(ring: &[Point], frontage: &[Option<StreetId>]) -> usize {
    let n = ring.len();
    let street = |i: usize| frontage.get(i % n).copied().flatten();
    let begins = |&i: &usize| street(i).is_some() && street(i) != street(i + n - 1);
    let length = |i: usize| ring[i].distance_squared(ring[(i + 1) % n]);
    (0..n).filter(begins).min_by_key(|&i| (street(i), std::cmp::Reverse(length(i)))).unwrap_or(0)
}
