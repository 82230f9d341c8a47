//! The pole of inaccessibility: the inner point farthest from the rim, by quadtree (Agafonkin's polylabel, on the
//! lattice).

use super::{Location, Polygon, distance_squared_to_segment};
use crate::Point;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Most root cells along the longer side, so that a needle does not start with thousands.
const MOST_ROOTS: i32 = 64;

/// Most cells looked at: what needs more is a sliver thinner than the lattice, where no better point is to be found.
const MOST_CELLS: usize = 20_000;

/// Directions of the corners of a square, then of its sides.
const AROUND: [(i32, i32); 8] = [(-1, -1), (1, -1), (-1, 1), (1, 1), (-1, 0), (1, 0), (0, -1), (0, 1)];

impl Polygon {
    /// The inner point farthest from the rim, to within `precision` metres of that distance (one lattice unit at
    /// least). Lies inside when the polygon is somewhere wider than a few LSB; where a sliver has no inner lattice
    /// point, on the rim. For a polygon without corners, the origin.
    pub fn pole(&self, precision: f64) -> Point {
        let Some(bounds) = self.bounds() else { return Point::default() };
        let precision = (precision * Point::UNITS_PER_METRE).max(1.0);
        let centroid = Point::from_metres(self.centroid());
        let mut best = Cell::new(self, centroid, 0);
        if best.distance < 0.0 {
            best = Cell::new(self, self.outer[0], 0);
        }
        let mut queue: BinaryHeap<Cell> = root_cells(bounds).map(|(at, half)| Cell::new(self, at, half)).collect();
        for _ in 0..MOST_CELLS {
            let Some(cell) = queue.pop() else { break };
            if cell.distance > best.distance {
                best = cell;
            }
            // Without an inner point yet, go on to the last lattice unit.
            let enough = if best.distance > 0.0 { precision } else { 0.0 };
            if cell.reach <= best.distance + enough {
                break;
            }
            queue.extend(cell.parts(self));
        }
        best.centre
    }

    /// Distance to the rim in LSB, negative outside.
    fn signed_distance(&self, p: Point) -> f64 {
        let squared = self.edges().map(|(a, b)| distance_squared_to_segment(a, b, p)).fold(f64::INFINITY, f64::min);
        match self.locate(p) {
            Location::Inside => squared.sqrt(),
            Location::OnRim => 0.0,
            Location::Outside => -squared.sqrt(),
        }
    }
}

/// Centres and half size of square cells that cover the box. The half size is a power of two, so quarters of cells have
/// lattice centres down to half a unit.
fn root_cells(bounds: crate::Bounds) -> impl Iterator<Item = (Point, i32)> {
    let (width, height) = (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y);
    let side = width.min(height).max(width.max(height) / MOST_ROOTS).max(2);
    let half = 1 << (side / 2).ilog2();
    let centres = move |from: i32, length: i32| (0..=length / (2 * half)).map(move |i| from + half + 2 * half * i);
    centres(bounds.min.x, width).flat_map(move |x| centres(bounds.min.y, height).map(move |y| (Point::new(x, y), half)))
}

/// A square of the search.
#[derive(Clone, Copy)]
struct Cell {
    centre: Point,
    half: i32,
    /// Signed distance of the centre from the rim, in LSB.
    distance: f64,
    /// No point of the cell lies farther inside than this.
    reach: f64,
}

impl Cell {
    fn new(polygon: &Polygon, centre: Point, half: i32) -> Self {
        let distance = polygon.signed_distance(centre);
        Self { centre, half, distance, reach: distance + f64::from(half) * std::f64::consts::SQRT_2 }
    }

    /// The four cells of half the size; of a cell of half size 1, the eight lattice points around its centre, which
    /// have no size of their own.
    fn parts(self, polygon: &Polygon) -> impl Iterator<Item = Cell> {
        let (step, half, count) = match self.half {
            0 => (0, 0, 0),
            1 => (1, 0, 8),
            half => (half / 2, half / 2, 4),
        };
        AROUND.into_iter().take(count).map(move |(x, y)| {
            let centre = Point::new(self.centre.x + x * step, self.centre.y + y * step);
            Cell::new(polygon, centre, half)
        })
    }
}

/// By reach, then by place, so that the order of the search is total.
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.reach.total_cmp(&other.reach).then_with(|| other.centre.cmp(&self.centre)).then(self.half.cmp(&other.half))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}
