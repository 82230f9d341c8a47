//! Proposals: where they come from and what they want.

use super::{Lineage, Slot, Steer};
use crate::{NodeId, StreetId};
use geom::{Angle, Id, Point, Vec2};

/// What a node id is derived with, so that it differs from the ids of proposals.
const NODE: u128 = 0x6e6f_6465;
/// What the id of a seed's street is derived with.
const STREET: u128 = 0x7374_7265_6574;

/// How close (m) to a crossing of a raster a place is that crossing, rounded.
const ON_CROSSING: f64 = 0.01;

/// Most raster crossings a target is moved on by, where the nearest one is the start itself.
const MOST_PITCHES: usize = 2;

/// The slot of a proposal at its tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Branch {
    /// The street goes on.
    Ahead,
    /// A branch to the left.
    Left,
    /// A branch to the right.
    Right,
    /// The other half of a seed's street: `ahead` in the opposite direction.
    Back,
}

impl Branch {
    /// The number that lineage is counted with.
    pub fn slot(self) -> u64 {
        self as u64
    }

    /// Turn from the heading of the tip.
    pub fn turn(self) -> Angle {
        match self {
            Self::Ahead => Angle::ZERO,
            Self::Left => Angle::RIGHT,
            Self::Right => -Angle::RIGHT,
            Self::Back => Angle::STRAIGHT,
        }
    }

    /// Whether it goes on with the street of its tip.
    pub fn goes_on(self) -> bool {
        matches!(self, Self::Ahead | Self::Back)
    }

    /// Derivation steps from the one at which the tip proposes to the one at which the successor is tested: p2 emits
    /// `?I` for the street itself, which p8 tests in the next step, and a `B` for a branch, which p5 turns into `?I`
    /// one step after its delay has run down (PM01 §3.1).
    pub fn steps(self) -> u32 {
        if self.goes_on() { 1 } else { 2 }
    }
}

/// The node at the end of a proposal, or of a seed.
pub(super) fn node_of(lineage: Id) -> NodeId {
    NodeId(lineage.with(&[NODE]))
}

/// The street through a seed.
pub(super) fn street_of_seed(root: Id) -> StreetId {
    StreetId(root.with(&[STREET]))
}

/// The end at which successors are proposed: of an accepted proposal, or a seed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub id: Id,
    pub node: NodeId,
    pub at: Point,
    pub heading: Angle,
    pub street: StreetId,
    pub half_width: i32,
    pub age: u32,
    /// Metres since its street began.
    pub length: f64,
    /// Branchings since the seed.
    pub generation: u32,
    /// Of several patterns the one that led here.
    pub lead: Option<u16>,
    /// Whether the street's own direction is against the growth.
    pub is_reversed: bool,
    /// The derivation step at which p2 fires.
    pub fired: u32,
}

/// A proposed piece of street (a `?I` of PM01, with its attributes).
#[derive(Clone, Copy, Debug)]
pub(super) struct Proposal {
    pub lineage: Lineage,
    pub from: Point,
    pub from_id: NodeId,
    /// Where it should end, in metres; finite.
    pub target: Vec2,
    pub heading: Angle,
    pub half_width: i32,
    pub age: u32,
    /// Metres of its street before it.
    pub length: f64,
    pub generation: u32,
    pub lead: Option<u16>,
    pub is_reversed: bool,
    /// The raster, or the rings and rays, that its end was moved onto.
    pub raster: Option<Steer>,
    /// Whether it starts at a seed, where there may be no node yet.
    pub is_from_seed: bool,
}

impl Proposal {
    /// What is proposed in one slot of a tip, or `None` when a number of the rule is unusable. `longest` cuts its
    /// length; `least` is the length below which a raster crossing counts as the start itself.
    pub fn new(origin: &Origin, steered: Angle, branch: Branch, slot: &Slot, aim: &Aim) -> Option<Self> {
        let wanted = (steered + branch.turn() + slot.turn).wrapped();
        let (target, heading) = aim.target(origin.at.metres(), wanted, slot.length)?;
        let delay = u32::try_from(slot.delay).ok()?;
        let width = slot.width.filter(|width| width.is_finite() && *width > 0.0);
        let id = origin.id.child(branch.slot());
        let street = if branch.goes_on() { origin.street } else { StreetId(id) };
        let time = origin.fired.saturating_add(branch.steps()).saturating_add(delay);
        Some(Self {
            lineage: Lineage { id, parent: origin.id, branch, street, time },
            from: origin.at,
            from_id: origin.node,
            target,
            heading,
            half_width: width.map_or(origin.half_width, |width| geom::point::units(width / 2.0).max(1)),
            age: if branch.goes_on() { origin.age } else { 0 },
            length: if branch.goes_on() { origin.length } else { 0.0 },
            generation: origin.generation.saturating_add(u32::from(!branch.goes_on())),
            lead: aim.lead,
            raster: aim.steer.filter(Steer::settles),
            is_from_seed: origin.fired == 0,
            is_reversed: match branch {
                Branch::Back => !origin.is_reversed,
                Branch::Ahead => origin.is_reversed,
                Branch::Left | Branch::Right => false,
            },
        })
    }

    /// Whether its end was moved onto a raster, or onto rings and rays.
    pub fn is_on_raster(&self) -> bool {
        self.raster.is_some()
    }

    /// Two places in metres on the line of the raster that it follows: crossings of the raster themselves, where its ends
    /// are such, so that the rounding of its start does not show in them.
    pub fn course(&self) -> Option<[Vec2; 2]> {
        let raster = self.raster?;
        Some([self.from.metres(), self.target].map(|place| {
            let settled = raster.settle(place);
            if (settled - place).length() <= ON_CROSSING { settled } else { place }
        }))
    }
}

/// How the end of a proposal is found from its heading and length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    pub steer: Option<Steer>,
    pub longest: f64,
    pub least: f64,
    /// Of several patterns the one that leads.
    pub lead: Option<u16>,
}

impl Aim {
    /// Whether the pattern lets a street leave a place in a direction, by itself or as a side street.
    pub fn leads(&self, from: Vec2, heading: Angle, is_side: bool) -> bool {
        match self.steer {
            Some(Steer::Rings(rings)) => rings.leads(from, heading.unit(), is_side),
            _ => true,
        }
    }

    /// The end in metres and the heading there, or `None` for numbers that give none.
    pub fn target(&self, from: Vec2, heading: Angle, length: f64) -> Option<(Vec2, Angle)> {
        if !(length > 0.0 && length.is_finite() && heading.to_radians().is_finite()) {
            return None;
        }
        let (along, length) = (heading.unit(), length.min(self.longest));
        let target = from + along * length;
        let (settled, heading) = match self.steer {
            Some(steer @ Steer::Raster { .. }) => (self.settled(&steer, from, along, target), heading),
            Some(Steer::Rings(rings)) => {
                let settled = rings.target(from, along, length, self.least)?;
                (settled, Angle::of(settled - from))
            }
            _ => (target, heading),
        };
        settled.is_finite().then_some((settled, heading))
    }

    /// The raster crossing to end at. A start that is off phase stays on its own line, so that the street keeps the
    /// raster's heading; only the phase along the line is taken on.
    fn settled(&self, steer: &Steer, from: Vec2, along: Vec2, target: Vec2) -> Vec2 {
        let mut target = target;
        for _ in 0..=MOST_PITCHES {
            let settled = steer.settle(target) - from;
            let (ahead, aside) = (settled.dot(along), along.perp_dot(settled));
            if ahead >= self.least / 2.0 {
                let is_in_phase = aside.abs() <= ahead * 0.05;
                return from + if is_in_phase { settled } else { along * ahead };
            }
            target += along * steer.pitch(along);
        }
        target
    }
}
