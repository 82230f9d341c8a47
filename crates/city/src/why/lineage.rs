//! All that growth accepted, found by lineage.

use super::{LineageSays, place};
use crate::trace::{Grown, Trace};
use geom::{Id, Point, Vec2};
use std::collections::BTreeMap;
use streets::growth::{Accepted, Branch, GrowthLog, Outcome};
use streets::{StreetGraph, StreetId};

/// Streets back to which a lineage is told.
const MOST_ANCESTORS: usize = 12;

/// An accepted proposal with where it grew.
#[derive(Clone, Copy)]
pub struct Placed<'a> {
    /// The stage.
    pub stage: &'static str,
    /// The step after which the stage began.
    pub start: u32,
    /// The quarter, for what grew in one.
    pub quarter: Option<Id>,
    /// The proposal.
    pub accepted: &'a Accepted,
}

impl Placed<'_> {
    /// The step, counted through all stages.
    pub fn step(&self) -> u32 {
        self.start.saturating_add(self.accepted.lineage.time)
    }
}

/// The log of one growth with where it grew.
pub struct PlacedLog<'a> {
    pub stage: &'static str,
    pub start: u32,
    pub quarter: Option<Id>,
    pub log: &'a GrowthLog,
}

/// All logs of a trace.
pub fn logs(trace: &Trace) -> Vec<PlacedLog<'_>> {
    let mut all = Vec::new();
    for (start, stage) in trace.stages() {
        let stage_name = stage.name;
        let place = |log, quarter| PlacedLog { stage: stage_name, start, quarter, log };
        match &stage.grown {
            Grown::InCity(logs) => all.extend(logs.iter().map(|log| place(log, None))),
            Grown::InQuarters { growths, .. } => {
                all.extend(growths.iter().map(|growth| place(&growth.log, Some(growth.quarter))));
            }
        }
    }
    all
}

/// All that was accepted, by lineage.
pub struct Family<'a> {
    by_id: BTreeMap<Id, Placed<'a>>,
    given: &'a StreetGraph,
}

impl<'a> Family<'a> {
    pub fn of(trace: &'a Trace) -> Self {
        let placed = |log: PlacedLog<'a>| {
            let PlacedLog { stage, start, quarter, log } = log;
            log.accepted.iter().map(move |accepted| (accepted.lineage.id, Placed { stage, start, quarter, accepted }))
        };
        Self { by_id: logs(trace).into_iter().flat_map(placed).collect(), given: trace.given() }
    }

    /// All pieces of a street, in the order of growth.
    pub fn of_street(&self, street: StreetId) -> Vec<Placed<'a>> {
        let mut pieces: Vec<Placed<'a>> =
            self.by_id.values().filter(|placed| placed.accepted.lineage.street == street).copied().collect();
        pieces.sort_by_key(|placed| (placed.accepted.lineage.time, placed.accepted.lineage.id));
        pieces
    }

    /// Everything that was accepted.
    pub fn all(&self) -> impl Iterator<Item = &Placed<'a>> {
        self.by_id.values()
    }

    /// From what a piece grew: its street, the street that it branched off, and so on.
    pub fn ancestry(&self, piece: Placed<'a>) -> Vec<LineageSays> {
        let mut said = Vec::new();
        let mut at = piece;
        while said.len() < MOST_ANCESTORS {
            at = self.first_of_street(at);
            let parent = self.by_id.get(&at.accepted.lineage.parent).copied();
            said.push(LineageSays {
                street: at.accepted.lineage.street.to_string(),
                stage: at.stage,
                step: at.step(),
                at: place(at.accepted.start().metres()),
                how: self.how(&at, parent.as_ref()),
            });
            let Some(parent) = parent else { break };
            at = parent;
        }
        said
    }

    /// The piece with which the street of a piece began.
    fn first_of_street(&self, piece: Placed<'a>) -> Placed<'a> {
        let mut at = piece;
        while at.accepted.lineage.branch.goes_on()
            && let Some(&before) = self.by_id.get(&at.accepted.lineage.parent)
        {
            at = before;
        }
        at
    }

    fn how(&self, piece: &Placed, parent: Option<&Placed>) -> String {
        let lineage = &piece.accepted.lineage;
        let side = branch_name(lineage.branch);
        match parent {
            Some(parent) => format!("branched off to the {side} of street {}", parent.accepted.lineage.street),
            None if !self.given.segments_of(lineage.street).is_empty() => "goes on where a given street ended".into(),
            None if !lineage.branch.goes_on() => format!("first branch to the {side}, of a seed or of a given street"),
            None if piece.quarter.is_some() => "began at a seed in its quarter".into(),
            None => "began at a seed".into(),
        }
    }
}

/// What a slot is called.
pub fn branch_name(branch: Branch) -> &'static str {
    match branch {
        Branch::Ahead => "ahead",
        Branch::Left => "left",
        Branch::Right => "right",
        Branch::Back => "back",
    }
}

/// How constraints left a proposal, in words; `by` is the rule that changed it, where one did.
pub fn outcome_says(outcome: Outcome, by: Option<String>) -> String {
    match (outcome, by) {
        (Outcome::Shortened, Some(rule)) => return format!("shortened by {rule}"),
        (Outcome::Turned, Some(rule)) => return format!("turned by {rule}"),
        _ => {}
    }
    match outcome {
        Outcome::As => "as proposed".into(),
        Outcome::Shortened => "shortened: cut back to legal ground, to a mask, or to where it is less steep".into(),
        Outcome::Turned => "turned: to stay on legal ground, or to be less steep".into(),
        Outcome::Crossed => "crossed: cut at the first street it met, where it ends".into(),
        Outcome::Snapped => "snapped: led to a crossing or street close to its end, where it ends".into(),
        Outcome::Extended => "extended: led on to a street a little ahead, where it ends".into(),
        other => format!("{other:?}").to_lowercase(),
    }
}

/// Metres from a place to a line.
pub fn distance_to(at: Vec2, (from, to): (Point, Point)) -> f64 {
    metres_to(at, (from.metres(), to.metres()))
}

/// The same of a line in metres.
pub fn metres_to(at: Vec2, (from, to): (Vec2, Vec2)) -> f64 {
    let along = to - from;
    let share =
        if along == Vec2::ZERO { 0.0 } else { ((at - from).dot(along) / along.length_squared()).clamp(0.0, 1.0) };
    (from + along * share).distance(at)
}
