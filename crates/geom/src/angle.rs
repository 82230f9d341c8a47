//! Angles and the only trigonometry: software `libm`, the same bits on every platform.

use crate::Vec2;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::ops::{Add, Mul, Neg, Sub};

/// An angle, counter-clockwise from east. Any number of turns; see [`Angle::wrapped`].
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Angle(f64);

impl Angle {
    /// East.
    pub const ZERO: Self = Self(0.0);
    /// A quarter turn.
    pub const RIGHT: Self = Self(PI / 2.0);
    /// Half a turn.
    pub const STRAIGHT: Self = Self(PI);

    /// From radians.
    pub const fn radians(radians: f64) -> Self {
        Self(radians)
    }

    /// From degrees.
    pub fn degrees(degrees: f64) -> Self {
        Self(degrees * (PI / 180.0))
    }

    /// The direction of a vector; east for the zero vector.
    pub fn of(v: Vec2) -> Self {
        Self(libm::atan2(v.y, v.x))
    }

    /// In radians.
    pub const fn to_radians(self) -> f64 {
        self.0
    }

    /// In degrees.
    pub fn to_degrees(self) -> f64 {
        self.0 * (180.0 / PI)
    }

    /// Sine.
    pub fn sin(self) -> f64 {
        libm::sin(self.0)
    }

    /// Cosine.
    pub fn cos(self) -> f64 {
        libm::cos(self.0)
    }

    /// The unit vector in this direction.
    pub fn unit(self) -> Vec2 {
        Vec2::new(self.cos(), self.sin())
    }

    /// The same direction in (-π, π].
    #[must_use]
    pub fn wrapped(self) -> Self {
        let turns = ((PI - self.0) / (2.0 * PI)).floor();
        Self(self.0 + turns * 2.0 * PI)
    }

    /// Magnitude.
    #[must_use]
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The member of the `k`-fold symmetric cross of headings through `self` that lies nearest to `heading`; an exact
    /// tie goes to the clockwise one.
    #[must_use]
    pub fn nearest_of_cross(self, k: u32, heading: Self) -> Self {
        let step = 2.0 * PI / f64::from(k.max(1));
        let turns = ((heading.0 - self.0) / step - 0.5).ceil();
        Self(self.0 + turns * step)
    }
}

impl Add for Angle {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Angle {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Neg for Angle {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Mul<f64> for Angle {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_into_half_open_turn() {
        assert!((Angle::degrees(350.0).wrapped().to_degrees() + 10.0).abs() < 1e-9);
        assert_eq!(Angle::STRAIGHT.wrapped(), Angle::STRAIGHT);
        assert_eq!((-Angle::STRAIGHT).wrapped(), Angle::STRAIGHT);
    }

    #[test]
    fn cross_gives_nearest_arm() {
        let cross = Angle::degrees(-29.0);
        let near = |deg: f64| cross.nearest_of_cross(4, Angle::degrees(deg)).wrapped().to_degrees().round();
        assert_eq!((near(-20.0), near(50.0), near(170.0), near(-120.0)), (-29.0, 61.0, 151.0, -119.0));
    }
}
