//! Points of the lattice, and boxes of them.

use crate::Vec2;
use serde::{Deserialize, Serialize};

/// A position on the lattice: 1 unit (LSB) is 2⁻¹⁰ m, about a millimetre. Equality is exact, order is by x, then y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Point {
    /// East, in LSB.
    pub x: i32,
    /// North, in LSB.
    pub y: i32,
}

impl Point {
    /// Lattice units to the metre.
    pub const UNITS_PER_METRE: f64 = 1024.0;
    /// Largest coordinate, in LSB (±524 km): within it `orient` fits i64 and constructed points fit i128.
    pub const LIMIT: i32 = 1 << 29;

    /// The point at lattice coordinates.
    pub const fn new(x: i32, y: i32) -> Self {
        Self { x, y }
    }

    /// The lattice point nearest to a position in metres; `None` outside the lattice or for a value that is not finite.
    pub fn try_from_metres(at: Vec2) -> Option<Self> {
        let scaled = (at * Self::UNITS_PER_METRE).round();
        let limit = f64::from(Self::LIMIT);
        (scaled.x.abs() <= limit && scaled.y.abs() <= limit).then(|| Self::new(scaled.x as i32, scaled.y as i32))
    }

    /// The lattice point nearest to a position in metres. Positions outside the lattice are moved to its rim, and a
    /// coordinate that is not a number becomes 0: input is checked where it enters (see [`Point::try_from_metres`]).
    pub fn from_metres(at: Vec2) -> Self {
        let limit = f64::from(Self::LIMIT);
        let scaled = (at * Self::UNITS_PER_METRE).round();
        Self::new(scaled.x.clamp(-limit, limit) as i32, scaled.y.clamp(-limit, limit) as i32)
    }

    /// This position in metres; exact.
    pub fn metres(self) -> Vec2 {
        Vec2::new(f64::from(self.x), f64::from(self.y)) / Self::UNITS_PER_METRE
    }

    /// Squared distance in LSB²; exact.
    pub fn distance_squared(self, other: Self) -> i64 {
        let (dx, dy) = self.to(other);
        dx * dx + dy * dy
    }

    /// Distance in metres.
    pub fn distance(self, other: Self) -> f64 {
        (self.distance_squared(other) as f64).sqrt() / Self::UNITS_PER_METRE
    }

    /// The exact difference `other - self` in LSB.
    pub fn to(self, other: Self) -> (i64, i64) {
        (i64::from(other.x) - i64::from(self.x), i64::from(other.y) - i64::from(self.y))
    }
}

/// A length in metres as whole lattice units, rounded.
pub fn units(metres: f64) -> i32 {
    (metres * Point::UNITS_PER_METRE).round().clamp(-f64::from(Point::LIMIT), f64::from(Point::LIMIT)) as i32
}

/// An axis-parallel box of lattice points, closed on all sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Bounds {
    /// South-west corner.
    pub min: Point,
    /// North-east corner.
    pub max: Point,
}

impl Bounds {
    /// The smallest box around the points, or `None` when there are none.
    pub fn of(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        Some(points.fold(Self { min: first, max: first }, Self::with))
    }

    /// The box of two corners, in any order.
    pub fn between(a: Point, b: Point) -> Self {
        Self { min: a, max: a }.with(b)
    }

    /// This box grown to hold a point.
    #[must_use]
    pub fn with(self, p: Point) -> Self {
        Self {
            min: Point::new(self.min.x.min(p.x), self.min.y.min(p.y)),
            max: Point::new(self.max.x.max(p.x), self.max.y.max(p.y)),
        }
    }

    /// This box grown by `margin` LSB on every side, within the lattice.
    #[must_use]
    pub fn grown(self, margin: i32) -> Self {
        Self {
            min: Point::new(self.min.x.saturating_sub(margin), self.min.y.saturating_sub(margin)),
            max: Point::new(self.max.x.saturating_add(margin), self.max.y.saturating_add(margin)),
        }
    }

    /// Whether the point lies inside or on the rim.
    pub fn contains(&self, p: Point) -> bool {
        self.min.x <= p.x && p.x <= self.max.x && self.min.y <= p.y && p.y <= self.max.y
    }

    /// Whether the two closed boxes have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x <= other.max.x && other.min.x <= self.max.x && self.min.y <= other.max.y && other.min.y <= self.max.y
    }

    /// Width and height in metres.
    pub fn size(&self) -> Vec2 {
        self.max.metres() - self.min.metres()
    }
}
