//! Fields of headings that a tip turns onto, and the rasters that ends of segments come to lie on.

use super::rings::Rings;
use geom::{Angle, Vec2};

/// A field of headings that a tip turns onto.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steer {
    /// `folds` headings evenly spread from `heading`; the nearest is taken.
    Cross {
        /// One of the headings.
        heading: Angle,
        /// How many there are.
        folds: u32,
    },
    /// A rectangular raster with absolute origin and phase: headings as a 4-fold cross, and ends of segments come to
    /// lie on raster crossings, so that quarters line up through majors.
    Raster {
        /// Direction of the long side of a block.
        heading: Angle,
        /// Pitch along `heading`, in metres.
        along: f64,
        /// Pitch across it, in metres.
        across: f64,
        /// A crossing of the raster, in metres.
        origin: Vec2,
    },
    /// Rings and rays around a centre: the raster of the plane in polar coordinates.
    Rings(Rings),
}

impl Steer {
    /// The heading to go on with at a place in metres.
    pub fn turn(&self, heading: Angle, place: Vec2) -> Angle {
        let (cross, folds) = self.cross(place);
        cross.nearest_of_cross(folds, heading)
    }

    /// The headings at a place in metres: one of them, and how many there are.
    pub fn cross(&self, place: Vec2) -> (Angle, u32) {
        match *self {
            Self::Cross { heading, folds } => (heading, folds),
            Self::Raster { heading, .. } => (heading, 4),
            Self::Rings(rings) => (rings.outward(place), 4),
        }
    }

    /// Whether ends come to lie on crossings.
    pub fn settles(&self) -> bool {
        !matches!(self, Self::Cross { .. })
    }

    /// The place to end at: the crossing nearest to `target`, else `target` itself.
    pub fn settle(&self, target: Vec2) -> Vec2 {
        match *self {
            Self::Cross { .. } => target,
            Self::Raster { heading, along, across, origin } => {
                let (u, v) = (heading.unit(), heading.unit().perp());
                let from = target - origin;
                let (i, j) = ((from.dot(u) / along).round(), (from.dot(v) / across).round());
                origin + u * (i * along) + v * (j * across)
            }
            Self::Rings(rings) => rings.settle(target),
        }
    }

    /// Metres from one crossing of a raster to the next in a direction (a unit vector); 0 for others.
    pub fn pitch(&self, direction: Vec2) -> f64 {
        match *self {
            Self::Raster { heading, along, across, .. } => {
                let u = heading.unit();
                (u.dot(direction) * along).abs() + (u.perp_dot(direction) * across).abs()
            }
            Self::Cross { .. } | Self::Rings(_) => 0.0,
        }
    }
}
