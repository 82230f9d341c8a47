//! What a growth is told: class, goal, constraints, limits, seeds.

use super::{Chain, Field, Goal};
use crate::Class;
use geom::{Angle, Id, Point, Seed};

/// Bounds on a growth, so that no rule runs away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most proposals accepted.
    pub segments: usize,
    /// Last derivation step at which a proposal is tested (PM01 figure 9 shows a city after 28 and after 142).
    pub steps: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { segments: 2_000_000, steps: u32::MAX }
    }
}

/// How streets of one class grow.
#[derive(Clone, Debug)]
pub struct Growth {
    /// Class of all streets grown.
    pub class: Class,
    /// Half of their right-of-way in LSB, where a rule says nothing else.
    pub half_width: i32,
    /// Full right-of-way in metres by place, instead: each piece of street takes that of its start.
    pub widths: Option<Field>,
    /// Demand for streets.
    pub goal: Goal,
    /// What adjusts or refuses proposals, in that order.
    pub constraints: Chain,
    /// When to stop at the latest.
    pub limits: Limits,
    /// Where chance comes from; each tip gets its own, keyed by lineage.
    pub seed: Seed,
    /// What the lineage of seeds without one of their own hangs on: hash(layer, stage).
    pub root: Id,
    /// Whether streets of this class that are there already go on at their free ends and sprout along their lines.
    pub sprouts: bool,
    /// Whether refused proposals are kept in the log, not only counted.
    pub records_refusals: bool,
}

impl Growth {
    /// Growth of a class with default constraints, no goal and no limits but the default ones.
    pub fn new(class: Class, half_width: i32, seed: Seed, root: Id) -> Self {
        Self {
            class,
            half_width,
            widths: None,
            goal: Goal::none(),
            constraints: Chain::default(),
            limits: Limits::default(),
            seed,
            root,
            sprouts: true,
            records_refusals: false,
        }
    }

    /// A seed whose lineage is the `ordinal`-th of this growth's root.
    pub fn seed_point(&self, at: Point, heading: Angle, ordinal: u64) -> SeedPoint {
        SeedPoint { at, heading, root: self.root.child(ordinal) }
    }
}

/// Where growth starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeedPoint {
    /// The place; a raster moves it onto its nearest crossing.
    pub at: Point,
    /// What the rule is told as heading.
    pub heading: Angle,
    /// Root of the lineage of all that grows from here; unique among seeds.
    pub root: Id,
}
