//! One face of the map, laid out for trying cuts on it.

use super::chord::End;
use super::map::{LandMap, NO_STREET};
use geom::polygon::{OrientedBox, convex_hull, min_area_box_of_hull};
use geom::{Point, Vec2};
use smallvec::SmallVec;

/// Share of a rectangle's size by which a corner may miss its middle and still stand beside it.
const BESIDE: f64 = 1e-9;

/// The rim of a face in order. Corner `i` starts edge `i`.
#[derive(Default)]
pub(super) struct Outline {
    pub halves: Vec<u32>,
    pub points: Vec<Point>,
    /// Corners in metres from the first corner.
    pub places: Vec<Vec2>,
    pub streets: Vec<u16>,
}

/// What a piece of land measures.
#[derive(Clone, Debug, Default)]
pub(super) struct Measure {
    /// In m².
    pub area: f64,
    /// In metres.
    pub perimeter: f64,
    /// Streets it fronts with the length of frontage in metres, in order of appearance.
    pub frontage: SmallVec<[(u16, f64); 4]>,
}

impl Measure {
    /// Of a face of the map with all its rims; nothing for one that was merged away.
    pub fn of_face(map: &LandMap, face: u32) -> Self {
        let mut measure = Self::default();
        let Some(&first) = map.faces[face as usize].rims.first() else { return measure };
        let base = map.start(first).metres();
        for half in map.halves_of(face) {
            let (from, to) = (map.start(half).metres() - base, map.end(half).metres() - base);
            measure.add_edge(from, to, map.half(half).street);
        }
        measure
    }

    /// The longest frontage on one street, in metres.
    pub fn longest_frontage(&self) -> f64 {
        self.frontage.iter().map(|&(_, length)| length).fold(0.0, f64::max)
    }

    /// How far the outline exceeds a square's of equal area: 1 for a square, (1 + r)² / 4r for a rectangle of sides 1
    /// : r.
    pub fn stretch(&self) -> f64 {
        self.perimeter * self.perimeter / (16.0 * self.area)
    }

    /// A width in metres: that of the strip, long against its width, that has this area and perimeter.
    pub fn width(&self) -> f64 {
        2.0 * self.area / self.perimeter
    }

    fn add_edge(&mut self, from: Vec2, to: Vec2, street: u16) {
        let length = from.distance(to);
        self.area += from.perp_dot(to) / 2.0;
        self.perimeter += length;
        if street == NO_STREET {
            return;
        }
        match self.frontage.iter_mut().find(|(known, _)| *known == street) {
            Some((_, sum)) => *sum += length,
            None => self.frontage.push((street, length)),
        }
    }
}

impl Outline {
    /// Takes up the only rim of a face, in the place of what was there.
    pub fn load(&mut self, map: &LandMap, face: u32) {
        self.halves.clear();
        self.halves.extend(map.halves_of(face));
        self.points.clear();
        self.points.extend(self.halves.iter().map(|&half| map.start(half)));
        self.streets.clear();
        self.streets.extend(self.halves.iter().map(|&half| map.half(half).street));
        let base = self.points[0].metres();
        self.places.clear();
        self.places.extend(self.points.iter().map(|p| p.metres() - base));
    }

    /// A position as a place: in metres from the first corner, exact.
    pub fn place(&self, p: Point) -> Vec2 {
        p.metres() - self.points[0].metres()
    }

    /// The smallest rectangle around it, in places. Of equal ones, that on the first side; its axis points so that the
    /// first corner lies behind the middle, or, where that one stands beside it, the way its edge runs: a turned outline
    /// has its rectangle turned with it.
    pub fn smallest_box(&self) -> OrientedBox {
        let base = self.points[0];
        let offset = |p: &Point| Point::new(p.x.saturating_sub(base.x), p.y.saturating_sub(base.y));
        let offsets: SmallVec<[Point; 16]> = self.points.iter().map(offset).collect();
        let mut hull = convex_hull(&offsets);
        let first = offsets.iter().find_map(|p| hull.iter().position(|corner| corner == p));
        hull.rotate_left(first.unwrap_or(0));
        let mut around = min_area_box_of_hull(&hull);
        let ahead = around.axis.dot(around.centre);
        // Beside the middle the sign would be that of the rounding.
        let is_beside = ahead.abs() <= BESIDE * around.half.x.max(around.half.y);
        if (if is_beside { around.axis.dot(self.arms(0).1) } else { ahead }) < 0.0 {
            around.axis = -around.axis;
        }
        around
    }

    /// The corners of the part that runs from one end of a chord along the rim to the other.
    pub fn corners_of_part(&self, first: &End, last: &End) -> SmallVec<[Point; 16]> {
        let mut corners: SmallVec<[Point; 16]> = smallvec::smallvec![first.at];
        let mut edge = first.edge;
        while edge != last.edge {
            edge = self.next(edge);
            corners.push(self.points[edge]);
        }
        corners.push(last.at);
        corners
    }

    pub fn len(&self) -> usize {
        self.points.len()
    }

    pub fn next(&self, i: usize) -> usize {
        if i + 1 == self.points.len() { 0 } else { i + 1 }
    }

    pub fn prev(&self, i: usize) -> usize {
        if i == 0 { self.points.len() - 1 } else { i - 1 }
    }

    /// What the part measures that runs from place `from` on edge `first` along the rim to place `to` on edge `last`,
    /// and straight back. A place on a corner belongs to the edge that starts there.
    pub fn measure_part(&self, from: (usize, Vec2), to: (usize, Vec2)) -> Measure {
        let mut measure = Measure::default();
        let (mut edge, mut place) = from;
        while edge != to.0 {
            let next = self.next(edge);
            measure.add_edge(place, self.places[next], self.streets[edge]);
            (edge, place) = (next, self.places[next]);
        }
        measure.add_edge(place, to.1, self.streets[edge]);
        measure.add_edge(to.1, from.1, NO_STREET);
        measure
    }

    /// Whether the corner turns right by more than some degrees: a mere T of a neighbour does not.
    pub fn is_reflex(&self, i: usize) -> bool {
        let (before, after) = self.arms(i);
        before.perp_dot(after) < -0.1 * before.length() * after.length()
    }

    /// The edge vectors that lead to a corner and away from it.
    pub fn arms(&self, i: usize) -> (Vec2, Vec2) {
        (self.places[i] - self.places[self.prev(i)], self.places[self.next(i)] - self.places[i])
    }
}
