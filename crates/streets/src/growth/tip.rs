//! The growing street end, as a rule sees it.

use super::Fields;
use crate::Class;
use geom::{Angle, Point, Seed, Vec2};
use std::sync::Arc;

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
}

impl Steer {
    /// The heading to go on with.
    pub fn turn(&self, heading: Angle) -> Angle {
        match *self {
            Self::Cross { heading: cross, folds } => cross.nearest_of_cross(folds, heading),
            Self::Raster { heading: cross, .. } => cross.nearest_of_cross(4, heading),
        }
    }

    /// The place to end at: for a raster its crossing nearest to `target`, else `target` itself.
    pub fn settle(&self, target: Vec2) -> Vec2 {
        match *self {
            Self::Cross { .. } => target,
            Self::Raster { heading, along, across, origin } => {
                let (u, v) = (heading.unit(), heading.unit().perp());
                let from = target - origin;
                let (i, j) = ((from.dot(u) / along).round(), (from.dot(v) / across).round());
                origin + u * (i * along) + v * (j * across)
            }
        }
    }

    /// Metres from one crossing of a raster to the next in a direction (a unit vector); 0 for a mere cross.
    pub fn pitch(&self, direction: Vec2) -> f64 {
        match *self {
            Self::Cross { .. } => 0.0,
            Self::Raster { heading, along, across, .. } => {
                let u = heading.unit();
                (u.dot(direction) * along).abs() + (u.perp_dot(direction) * across).abs()
            }
        }
    }
}

/// What is proposed in one of the three slots of a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// Length in metres.
    pub length: f64,
    /// Turn away from the slot's own direction (ahead, left or right), counter-clockwise.
    pub turn: Angle,
    /// Delay in derivation steps (PM01 p4).
    pub delay: u32,
    /// Full right-of-way in metres; that of the tip's own street when none.
    pub width: Option<f64>,
}

/// What a rule proposes at a tip: the three successors of PM01 p2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slots {
    /// The headings to turn onto first.
    pub steer: Option<Steer>,
    /// The street goes on.
    pub ahead: Option<Slot>,
    /// A branch to the left.
    pub left: Option<Slot>,
    /// A branch to the right.
    pub right: Option<Slot>,
}

/// A growing street end: its getters say what a rule may know, its `slots` hold what the rule proposes.
#[derive(Clone, Debug)]
pub struct Tip {
    /// Where it is.
    pub at: Point,
    /// Where it is heading.
    pub heading: Angle,
    /// Class of its street.
    pub class: Class,
    /// Whether nothing has grown here yet: `at` and `heading` are the kernel's suggestion.
    pub is_seed: bool,
    /// Segments since its street began.
    pub age: u32,
    /// Chance for decisions at this tip, keyed by its lineage.
    pub seed: Seed,
    /// The maps.
    pub fields: Arc<Fields>,
    /// What is proposed.
    pub slots: Slots,
}

impl Tip {
    /// Turns onto the nearest heading of a field.
    pub fn steer(&mut self, steer: Steer) {
        self.slots.steer = Some(steer);
    }

    /// The heading after steering.
    pub fn steered(&self) -> Angle {
        self.slots.steer.map_or(self.heading, |steer| steer.turn(self.heading))
    }

    /// Whether it runs (either way) nearer to `heading` than to the direction across it, after steering.
    pub fn runs_along(&self, heading: Angle) -> bool {
        let (a, b) = (self.steered().unit(), heading.unit());
        a.dot(b).abs() >= a.perp_dot(b).abs()
    }

    /// Place in metres.
    pub fn place(&self) -> Vec2 {
        self.at.metres()
    }

    /// The heading, within `spread` to either side of the tip's own, along which a ray of `radius` metres sums up most
    /// density (PM01 §3.2.1); of equal ones the straightest, then the left one. Tries `rays` headings to either side,
    /// with a sample every 1/16 of the radius.
    pub fn seek_density(&self, radius: f64, spread: Angle, rays: u32) -> Angle {
        let turn = |k: i64| spread * (k as f64 / f64::from(rays.max(1)));
        let sides = (1..=i64::from(rays)).flat_map(|k| [k, -k]);
        let mut best = (self.heading, f64::NEG_INFINITY);
        for heading in std::iter::once(0).chain(sides).map(|k| self.heading + turn(k)) {
            let sum = self.fields.density_ahead(self.place(), heading.unit(), radius, 16);
            if sum > best.1 {
                best = (heading, sum);
            }
        }
        best.0
    }

    /// The name of its district; empty where there is none.
    pub fn district(&self) -> &str {
        self.fields.districts.name_at(self.place())
    }

    /// People per km² at the tip.
    pub fn density(&self) -> f64 {
        self.fields.density.at(self.place())
    }

    /// Metres above sea level at the tip.
    pub fn elevation(&self) -> f64 {
        self.fields.elevation.at(self.place())
    }
}

/// A street pattern: called once per growing tip.
pub trait GrowthRules: Sync {
    /// Fills `tip.slots`. What goes wrong is recorded by the implementer; the tip then ends (slots stay empty).
    fn propose(&self, tip: &mut Tip);

    /// What claims of streets grown by these rules carry as their origin.
    fn origin(&self) -> u16;
}
