//! Constraints that a rule decides: what such a rule knows of a proposal, and what it may do with it.

use super::Fields;
use crate::Class;
use geom::{Angle, Id, Seed, Vec2};
use std::fmt::Debug;
use std::sync::Arc;

/// A proposed piece of street as a rule's own constraint sees and changes it. Places in metres.
#[derive(Clone, Debug)]
pub struct Draft {
    /// Lineage of the proposal.
    pub id: Id,
    /// Where it starts. It stays there.
    pub from: Vec2,
    /// Where it is to end.
    pub to: Vec2,
    /// The heading that the street goes on with.
    pub heading: Angle,
    /// Class of its street.
    pub class: Class,
    /// 0 on the ground, above it on a bridge, below it in a tunnel.
    pub level: i8,
    /// Whether it ends on another street.
    pub meets_street: bool,
    /// Chance for decisions about it, keyed by its lineage.
    pub seed: Seed,
    /// The maps.
    pub fields: Arc<Fields>,
    /// Why it is refused, once it is.
    pub refused: Option<Arc<str>>,
}

impl Draft {
    /// Length in metres.
    pub fn length(&self) -> f64 {
        (self.to - self.from).length()
    }

    /// The place at a share of its length, from 0 at its start to 1 at its end.
    pub fn at_share(&self, share: f64) -> Vec2 {
        self.from.lerp(self.to, share)
    }

    /// Turns it about its start, counter-clockwise.
    pub fn turn(&mut self, by: Angle) {
        self.to = self.from + (self.to - self.from).rotate(by.unit());
        self.heading = (self.heading + by).wrapped();
    }

    /// Lets it end at a length in metres.
    pub fn cut_to(&mut self, length: f64) {
        self.to = self.from + (self.to - self.from).normalize_or_zero() * length;
    }

    /// Lets it end at a place.
    pub fn end_at(&mut self, place: Vec2) {
        self.to = place;
        if place != self.from {
            self.heading = Angle::of(place - self.from);
        }
    }

    /// Refuses it.
    pub fn refuse(&mut self, why: Arc<str>) {
        self.refused = Some(why);
    }

    /// Rise over run from its start to its end.
    pub fn grade(&self) -> f64 {
        let rise = self.fields.elevation.at(self.to) - self.fields.elevation.at(self.from);
        let length = self.length();
        if length > 0.0 { rise / length } else { 0.0 }
    }
}

/// A local constraint that a rule decides: asked at its place in the chain of what the tests before it let pass, and again
/// when what it agreed to was changed by another step.
pub trait Constrain: Debug + Send + Sync {
    /// Leaves a draft as it is, changes it, or refuses it. What goes wrong is recorded by the implementer, and refuses.
    fn constrain(&self, draft: &mut Draft);

    /// Whether it was asked, and has refused everything so far.
    fn is_in_vain(&self) -> bool {
        false
    }

    /// Takes in that it agreed to something in a growth that is used again.
    fn has_agreed(&self) {}
}

/// A constraint of a rule in a chain. Equal to itself only.
#[derive(Clone, Debug)]
pub struct Own(pub Arc<dyn Constrain>);

impl PartialEq for Own {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
