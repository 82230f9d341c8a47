//! The growing street end, as a rule sees it.

use super::{Fields, Steer};
use crate::Class;
use geom::{Angle, Id, Point, Seed, Vec2};
use std::sync::Arc;

/// What is proposed in one of the three slots of a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// Length in metres.
    pub length: f64,
    /// Turn away from the slot's own direction (ahead, left or right), counter-clockwise.
    pub turn: Angle,
    /// Delay in derivation steps (PM01 p4); below 0 the slot is deleted (p1, p6, p7).
    pub delay: i32,
    /// Full right-of-way in metres; that of the tip's own street when none.
    pub width: Option<f64>,
}

impl Slot {
    /// The slot, unless its delay deletes it.
    pub fn kept(self) -> Option<Self> {
        (self.delay >= 0).then_some(self)
    }
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
    /// Of several patterns the one that leads here: see [`Blend`](super::Blend).
    pub lead: Option<u16>,
}

impl Slots {
    /// Whether nothing is proposed: the tip ends.
    pub fn is_empty(&self) -> bool {
        [self.ahead, self.left, self.right].iter().all(|slot| slot.and_then(Slot::kept).is_none())
    }
}

/// Where a growth is at home: the same for all its tips.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Home {
    /// In a quarter its pole, the place farthest from its rim; outside quarters the middle of the site; else the first
    /// seed. In metres.
    pub at: Vec2,
    /// In a quarter the direction of its longest side; outside quarters east; else that of the first seed.
    pub heading: Angle,
}

/// A growing street end: its getters say what a rule may know, its `slots` hold what the rule proposes.
#[derive(Clone, Debug)]
pub struct Tip {
    /// Lineage of what ends here: the parent of what is proposed.
    pub id: Id,
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
    /// Metres since its street began.
    pub length: f64,
    /// Branchings since the seed: 0 on the seed's own street.
    pub generation: u32,
    /// Derivation step at which it is asked; 0 at a seed.
    pub step: u32,
    /// Full right-of-way of its street in metres.
    pub width: f64,
    /// Where its growth is at home.
    pub home: Home,
    /// Of several patterns the one that led its street so far.
    pub lead: Option<u16>,
    /// Chance for decisions at this tip, keyed by its lineage.
    pub seed: Seed,
    /// The maps.
    pub fields: Arc<Fields>,
    /// What is proposed.
    pub slots: Slots,
}

impl Tip {
    /// A tip where nothing has grown yet, at the origin, heading east.
    pub fn new(class: Class, seed: Seed, fields: Arc<Fields>) -> Self {
        Self {
            id: Id::default(),
            at: Point::default(),
            heading: Angle::ZERO,
            class,
            is_seed: true,
            age: 0,
            length: 0.0,
            generation: 0,
            step: 0,
            width: 0.0,
            home: Home::default(),
            lead: None,
            seed,
            fields,
            slots: Slots::default(),
        }
    }

    /// Turns onto the nearest heading of a field.
    pub fn steer(&mut self, steer: Steer) {
        self.slots.steer = Some(steer);
    }

    /// The heading after steering.
    pub fn steered(&self) -> Angle {
        self.slots.steer.map_or(self.heading, |steer| steer.turn(self.heading, self.place()))
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

    /// The origin where one of several patterns leads.
    fn origin_of(&self, _lead: Option<u16>) -> u16 {
        self.origin()
    }

    /// Whether a rule was asked, and has proposed nothing so far.
    fn is_in_vain(&self) -> bool {
        false
    }
}
