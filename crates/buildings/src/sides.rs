//! Which edges of a parcel are its front, its sides and its rear.

use geom::polygon::ring_edges;
use geom::{Point, Vec2};

/// What an edge of a parcel is to the building on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// It lies on a street.
    Front,
    /// It runs back from the street.
    Side,
    /// It runs along the main front, behind the building.
    Rear,
}

/// How near to the opposite of the front an edge must run to be the rear: cosine of 45°.
const OPPOSITE: f64 = 0.707;

/// The kind of each edge of a counter-clockwise ring, by the corner it starts at, given which edges lie on streets. The
/// rear is what runs against the main front, to within 45°. A parcel without front has sides only.
pub fn sides(ring: &[Point], fronts: &[bool]) -> Vec<Side> {
    let main = main_front(ring, fronts);
    let kind = |(i, (from, to)): (usize, (Point, Point))| {
        let along = (to.metres() - from.metres()).normalize_or_zero();
        match main {
            _ if fronts.get(i).copied().unwrap_or(false) => Side::Front,
            Some(front) if along.dot(front) < -OPPOSITE => Side::Rear,
            _ => Side::Side,
        }
    };
    ring_edges(ring).enumerate().map(kind).collect()
}

/// The direction of the longest edge on a street, the street on its right; the first of equals.
pub fn main_front(ring: &[Point], fronts: &[bool]) -> Option<Vec2> {
    let edges = ring_edges(ring).zip(fronts).filter(|(_, front)| **front).map(|(edge, _)| edge);
    longest(edges)
}

/// The direction of the longest edge; the first of equals.
pub(crate) fn longest(edges: impl Iterator<Item = (Point, Point)>) -> Option<Vec2> {
    let mut best: Option<(i64, Vec2)> = None;
    for (from, to) in edges {
        let length = from.distance_squared(to);
        if best.is_none_or(|(longest, _)| length > longest) {
            best = Some((length, to.metres() - from.metres()));
        }
    }
    best.and_then(|(_, along)| along.try_normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::point::units;

    fn ring(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(units(x), units(y))).collect()
    }

    #[test]
    fn a_row_house_has_a_front_two_sides_and_a_rear() {
        let ring = ring(&[(0.0, 0.0), (8.0, 0.0), (8.0, 30.0), (0.0, 30.0)]);
        let found = sides(&ring, &[true, false, false, false]);
        assert_eq!(found, [Side::Front, Side::Side, Side::Rear, Side::Side]);
    }

    #[test]
    fn a_corner_house_has_two_fronts_and_a_through_parcel_no_rear() {
        let ring = ring(&[(0.0, 0.0), (18.0, 0.0), (18.0, 30.0), (0.0, 30.0)]);
        let corner = sides(&ring, &[true, true, false, false]);
        // The longer front is the main one, so the rear is opposite.
        assert_eq!(corner, [Side::Front, Side::Front, Side::Side, Side::Rear]);
        assert!(!sides(&ring, &[true, false, true, false]).contains(&Side::Rear));
        assert_eq!(sides(&ring, &[]), [Side::Side; 4]);
    }
}
