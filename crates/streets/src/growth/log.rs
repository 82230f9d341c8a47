//! What a growth did and why: lineage of what was accepted, reasons of what was refused.

use super::Branch;
use crate::graph::{NewSegment, Refusal};
use crate::{NodeId, StreetId};
use geom::{Id, Point};
use std::collections::BTreeMap;
use std::ops::Index;
use std::sync::Arc;

/// How local constraints left an accepted proposal (PM01 §3.3, figure 8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// As proposed.
    As,
    /// Cut back to the legal area.
    Shortened,
    /// Turned into the legal area.
    Turned,
    /// Led over illegal area on a level of its own.
    Bridged,
    /// Led through a hill on a level of its own.
    Tunnelled,
    /// Cut at the first street it crossed; it ends there.
    Crossed,
    /// Led to a crossing or street close to its end; it ends there.
    Snapped,
    /// Led on to a street a little ahead; it ends there.
    Extended,
}

impl Outcome {
    /// Whether the street ends here ("after a crossing is generated, a road stops growing", PM01 §3.3.1).
    pub fn ends_street(self) -> bool {
        matches!(self, Self::Crossed | Self::Snapped | Self::Extended)
    }
}

/// Why a proposal was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Refused {
    /// The rule proposed a length, turn or raster that is no usable number.
    #[error("the proposed length or turn is not a usable number")]
    Malformed,
    /// Its end lies outside the lattice.
    #[error("the end lies outside the lattice (±524 km)")]
    OffLattice,
    /// The goal wants no streets at its end.
    #[error("no demand for streets at the end")]
    NoDemand,
    /// No length or turn within the limits keeps it in the legal area.
    #[error("no way to stay in the legal area")]
    Illegal,
    /// Shorter than the least length after adjustment.
    #[error("too short after adjustment")]
    TooShort,
    /// Runs along an existing street.
    #[error("runs along an existing street")]
    Duplicate,
    /// Meets a street at too sharp an angle.
    #[error("meets a street at too sharp an angle")]
    Sharp,
    /// Constraints kept undoing each other.
    #[error("the constraints did not settle")]
    Unsettled,
    /// There is no room to lay it without moving an existing street.
    #[error("no room without moving an existing street")]
    Crowded,
    /// No turn, tunnel or hairpin within the limits is gentle enough.
    #[error("too steep")]
    Steep,
    /// It starts outside an area that streets are clipped to, or too little of it is inside.
    #[error("outside the mask")]
    Masked,
    /// A crossing has as many streets as it may have.
    #[error("a crossing has no room for another street")]
    Full,
    /// A rule's own constraint refused it: [`GrowthLog::reasons`] says why.
    #[error("refused by a rule")]
    ByRule,
}

impl Refused {
    /// All reasons.
    pub const ALL: [Self; 13] = [
        Self::Malformed,
        Self::OffLattice,
        Self::NoDemand,
        Self::Illegal,
        Self::TooShort,
        Self::Duplicate,
        Self::Sharp,
        Self::Unsettled,
        Self::Crowded,
        Self::Steep,
        Self::Masked,
        Self::Full,
        Self::ByRule,
    ];
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::TooShort => Self::TooShort,
            Refusal::Crowded => Self::Crowded,
            Refusal::Unsettled => Self::Unsettled,
            Refusal::OffLattice => Self::OffLattice,
        }
    }
}

/// Lineage of a proposal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lineage {
    /// Identity: child of `parent` in the slot of `branch`.
    pub id: Id,
    /// The proposal at whose end it was made, or the root of its seed.
    pub parent: Id,
    /// Its slot.
    pub branch: Branch,
    /// Its street.
    pub street: StreetId,
    /// Derivation step at which it is tested (PM01 p8).
    pub time: u32,
}

/// A proposal that became street.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Accepted {
    /// Where it comes from.
    pub lineage: Lineage,
    /// What was laid, in the direction of its street.
    pub line: NewSegment,
    /// Whether it grew from the end of `line` to its start (the back half of a seed's street).
    pub is_reversed: bool,
    /// How it was adjusted.
    pub outcome: Outcome,
    /// Where it should have ended before it was adjusted.
    pub proposed: Point,
}

impl Accepted {
    /// Where it grew from.
    pub fn start(&self) -> Point {
        if self.is_reversed { self.line.to } else { self.line.from }
    }

    /// Where it grew to.
    pub fn end(&self) -> Point {
        if self.is_reversed { self.line.from } else { self.line.to }
    }

    /// The node it grew to.
    pub fn end_id(&self) -> NodeId {
        if self.is_reversed { self.line.from_id } else { self.line.to_id }
    }
}

/// A proposal that was refused, as it was proposed.
#[derive(Clone, Debug, PartialEq)]
pub struct RefusedProposal {
    /// Where it comes from.
    pub lineage: Lineage,
    /// Where it would have started.
    pub from: Point,
    /// Where it should have ended; `from` when it was no place.
    pub to: Point,
    /// Why not.
    pub reason: Refused,
    /// What the rule said that refused it.
    pub why: Option<Arc<str>>,
}

/// How many proposals were refused for each reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refusals([usize; Refused::ALL.len()]);

impl Refusals {
    pub(super) fn count(&mut self, reason: Refused) {
        self.0[reason as usize] += 1;
    }

    /// All reasons together.
    pub fn total(&self) -> usize {
        self.0.iter().sum()
    }

    /// Reasons that occurred, with their counts.
    pub fn iter(&self) -> impl Iterator<Item = (Refused, usize)> {
        Refused::ALL.into_iter().map(|reason| (reason, self[reason])).filter(|(_, count)| *count > 0)
    }
}

impl Index<Refused> for Refusals {
    type Output = usize;
    fn index(&self, reason: Refused) -> &usize {
        &self.0[reason as usize]
    }
}

/// How many different reasons of rules are kept.
pub const MOST_REASONS: usize = 1000;

/// Why a growth stopped with proposals left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// A limit was reached.
    Limit,
    /// It was cancelled: the result is not to be used.
    Cancelled,
}

/// What a growth did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GrowthLog {
    /// What was laid, in that order.
    pub accepted: Vec<Accepted>,
    /// How many proposals were refused, by reason.
    pub refusals: Refusals,
    /// What rules said that refused proposals, with how often: the first [`MOST_REASONS`] in alphabetical order.
    pub reasons: BTreeMap<Arc<str>, usize>,
    /// The refused proposals, where the growth was told to record them.
    pub refused: Vec<RefusedProposal>,
    /// Seeds that found no place.
    pub seeds_refused: usize,
    /// Whether it was stopped before its time.
    pub stopped: Option<Stopped>,
}

impl GrowthLog {
    /// Counts a refusal, and what a rule said about it.
    pub(super) fn count(&mut self, reason: Refused, why: Option<&Arc<str>>) {
        self.refusals.count(reason);
        if let Some(why) = why {
            *self.reasons.entry(Arc::clone(why)).or_default() += 1;
            if self.reasons.len() > MOST_REASONS {
                self.reasons.pop_last();
            }
        }
    }
}
