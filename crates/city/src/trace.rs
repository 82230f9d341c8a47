//! What growth did, step by step: kept on request, to draw a city as it was and to say why a street is there.

use geom::{Id, Vec2};
use script::Rule;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use streets::StreetGraph;
use streets::graph::Crowding;
use streets::growth::{Accepted, Draft, GrowthLog, MergeLog, QuarterGrowth, Tip, attach};

/// What the growth of a city did, stage by stage.
///
/// Derivation steps are counted through: the first stage starts with step 1, each further one after the last step of
/// the stage before in which a street was laid.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The streets that were there before anything grew: given and imported ones.
    given: StreetGraph,
    stages: Vec<StageTrace>,
    tips: Tips,
    drafts: Drafts,
}

/// The street ends at which rules were asked, by lineage. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tips(Arc<Mutex<BTreeMap<Id, AskedTip>>>);

/// A street end with the quarter that it grew in.
#[derive(Clone, Debug)]
pub(crate) struct AskedTip {
    pub quarter: Option<Id>,
    pub tip: Tip,
}

impl Tips {
    /// Keeps one as it is asked.
    pub fn keep(&self, quarter: Option<Id>, tip: &Tip) {
        let asked = AskedTip { quarter, tip: tip.clone() };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(tip.id, asked);
    }

    /// Those at a place, by lineage.
    pub fn near(&self, place: Vec2, within: f64) -> Vec<AskedTip> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.values().filter(|asked| asked.tip.place().distance(place) <= within).cloned().collect()
    }

    /// The first that was asked in a quarter.
    pub fn first_in(&self, quarter: Id) -> Option<AskedTip> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let own = known.values().filter(|asked| asked.quarter == Some(quarter));
        own.min_by_key(|asked| (asked.tip.step, asked.tip.id)).cloned()
    }

    /// The one at the end of a proposal, or at a seed.
    pub fn at(&self, lineage: Id) -> Option<AskedTip> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&lineage).cloned()
    }
}

/// What rules of their own made of proposals, by the lineage of these. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drafts(Arc<Mutex<BTreeMap<Id, Vec<Constrained>>>>);

/// A proposal that a rule was asked about.
#[derive(Clone, Debug)]
pub(crate) struct Constrained {
    pub rule: Rule,
    /// As the rule was asked.
    pub draft: Draft,
    /// Where it then ended, metres.
    pub to: Vec2,
}

impl Drafts {
    /// Keeps one with what became of it.
    pub fn keep(&self, constrained: Constrained) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.entry(constrained.draft.id).or_default().push(constrained);
    }

    /// What was asked about a proposal, in that order.
    pub fn of(&self, lineage: Id) -> Vec<Constrained> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&lineage).cloned().unwrap_or_default()
    }

    /// What was asked about proposals from or to a place.
    pub fn near(&self, place: Vec2, within: f64) -> Vec<Constrained> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let all = known.values().flatten();
        let is_near = |draft: &Draft| draft.from.distance(place) <= within || draft.to.distance(place) <= within;
        all.filter(|constrained| is_near(&constrained.draft)).cloned().collect()
    }
}

/// What one stage of growth did.
#[derive(Clone, Debug)]
pub struct StageTrace {
    /// `majors`, `minors`, …
    pub name: &'static str,
    /// Its logs.
    pub grown: Grown,
    /// The streets once the stage was over: dead ends pruned, curves smoothed.
    finished: Option<StreetGraph>,
}

/// How a stage grew.
#[derive(Clone, Debug)]
pub enum Grown {
    /// In the city's graph, one derivation after the other.
    InCity(Vec<GrowthLog>),
    /// In each quarter by itself, then attached.
    InQuarters {
        /// Quarter by quarter, what lies outside all of them last.
        growths: Vec<QuarterGrowth>,
        /// What the attachment did.
        merge: MergeLog,
    },
}

impl StageTrace {
    /// The logs of the stage, in its order.
    pub fn logs(&self) -> Vec<&GrowthLog> {
        match &self.grown {
            Grown::InCity(logs) => logs.iter().collect(),
            Grown::InQuarters { growths, .. } => growths.iter().map(|growth| &growth.log).collect(),
        }
    }

    /// The last step of its own at which it laid a street; 0 when it laid none.
    pub fn last_step(&self) -> u32 {
        let times = self.logs().into_iter().flat_map(|log| &log.accepted).map(|accepted| accepted.lineage.time);
        times.max().unwrap_or(0)
    }
}

impl Trace {
    /// A trace of growth that starts from these streets.
    pub(crate) fn new(given: StreetGraph) -> Self {
        Self { given, stages: Vec::new(), tips: Tips::default(), drafts: Drafts::default() }
    }

    /// What rules of their own made of proposals.
    pub(crate) fn drafts(&self) -> &Drafts {
        &self.drafts
    }

    /// The street ends at which rules were asked.
    pub(crate) fn tips(&self) -> &Tips {
        &self.tips
    }

    /// The streets that were there before anything grew.
    pub fn given(&self) -> &StreetGraph {
        &self.given
    }

    /// Adds a stage.
    pub(crate) fn push(&mut self, name: &'static str, grown: Grown) {
        self.stages.push(StageTrace { name, grown, finished: None });
    }

    /// Keeps the streets as they are after what is done to them once all of the last stage have grown.
    pub(crate) fn finish(&mut self, graph: &StreetGraph) {
        if let Some(stage) = self.stages.last_mut() {
            stage.finished = Some(graph.clone());
        }
    }

    /// The stages with the step after which each begins.
    pub fn stages(&self) -> impl Iterator<Item = (u32, &StageTrace)> {
        self.stages.iter().scan(0u32, |before, stage| {
            let start = *before;
            *before = start.saturating_add(stage.last_step());
            Some((start, stage))
        })
    }

    /// The last step at which a street was laid.
    pub fn last_step(&self) -> u32 {
        self.stages.iter().fold(0, |sum, stage| sum.saturating_add(stage.last_step()))
    }

    /// The streets after a derivation step: those given, stages that were over by then with all that was done to them,
    /// and of the stage under way what was accepted up to the step (PM01 figure 9).
    pub fn after(&self, step: u32) -> StreetGraph {
        let mut graph = &self.given;
        for (start, stage) in self.stages() {
            if step >= start.saturating_add(stage.last_step()) {
                graph = stage.finished.as_ref().unwrap_or(graph);
            } else {
                let mut graph = graph.clone();
                lay(&mut graph, &stage.grown, step.saturating_sub(start));
                return graph;
            }
        }
        graph.clone()
    }
}

/// Lays what a stage had accepted by a step of its own, as the stage laid it.
fn lay(graph: &mut StreetGraph, grown: &Grown, step: u32) {
    match grown {
        Grown::InCity(logs) => {
            for accepted in logs.iter().flat_map(|log| &log.accepted).filter(|accepted| is_by(accepted, step)) {
                // A line that ended on one from a later step of an earlier derivation joins what else is there.
                let _ = graph
                    .insert(&accepted.line, Crowding::Refuse)
                    .or_else(|_| graph.insert(&accepted.line, Crowding::Join));
            }
        }
        Grown::InQuarters { growths, .. } => {
            let growths: Vec<QuarterGrowth> = growths.iter().map(|growth| up_to(growth, step)).collect();
            attach(graph, &growths, &|| false);
        }
    }
}

fn is_by(accepted: &Accepted, step: u32) -> bool {
    accepted.lineage.time <= step
}

/// What a quarter had accepted by a step.
fn up_to(growth: &QuarterGrowth, step: u32) -> QuarterGrowth {
    let mut kept = QuarterGrowth { log: GrowthLog::default(), attachments: Vec::new(), ..growth.clone() };
    let mut places = Vec::with_capacity(growth.log.accepted.len());
    for accepted in &growth.log.accepted {
        places.push(is_by(accepted, step).then_some(kept.log.accepted.len()));
        kept.log.accepted.extend(is_by(accepted, step).then(|| accepted.clone()));
    }
    let moved = |attachment: &streets::growth::Attachment| {
        Some(streets::growth::Attachment { line: places[attachment.line]?, ..*attachment })
    };
    kept.attachments = growth.attachments.iter().filter_map(moved).collect();
    kept
}
