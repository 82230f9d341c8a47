//! What street rules did: at the ends that pieces of street grew from, and with what was proposed there.

use super::blend::{plan_of, shares};
use super::decision::{DecisionSays, asked, number};
use super::lineage::Placed;
use super::{Answer, Evidence};
use crate::stages::patterns::weight;
use crate::trace::{AskedTip, Constrained, Trace};
use geom::{Id, Vec2};
use script::{ConstraintPattern, RuleKind, StreetPattern, StreetPlan};
use std::collections::BTreeSet;
use std::sync::Arc;
use streets::growth::{Blend, BlendPart, Constrain, Draft, GrowthRules, Slot, Slots, Tip};
use streets::{Class, Classes};

/// Street ends that are told of.
const MOST_ENDS: usize = 3;
/// Proposals that rules of their own were asked about and that are told of.
const MOST_DRAFTS: usize = 4;
/// Places are told to a tenth of a metre.
const HERE: f64 = 0.15;

/// Asks the rules once more at the ends that pieces grew from, the first ones, and about the pieces themselves.
pub fn tell_ends(pieces: &[Placed], trace: &Trace, evidence: &Evidence, answer: &mut Answer) {
    let mut known = BTreeSet::new();
    let ends = pieces.iter().filter(|piece| known.insert(piece.accepted.lineage.parent));
    let tips: Vec<AskedTip> = ends.filter_map(|piece| trace.tips().at(piece.accepted.lineage.parent)).collect();
    for tip in tips.iter().take(MOST_ENDS) {
        tell_end(tip, evidence, answer);
    }
    let drafts = pieces.iter().flat_map(|piece| trace.drafts().of(piece.accepted.lineage.id));
    tell_drafts(drafts, answer);
    if tips.len() > MOST_ENDS {
        answer.tell("told of", format!("the first {MOST_ENDS} of {} street ends that it grew from", tips.len()));
    }
}

/// Asks the rules once more at the end of a piece: how it goes on from there.
pub fn tell_next(piece: &Placed, trace: &Trace, evidence: &Evidence, answer: &mut Answer) {
    if let Some(tip) = trace.tips().at(piece.accepted.lineage.id) {
        tell_end(&tip, evidence, answer);
    }
}

/// Asks rules of their own once more about what they refused at the ends of pieces.
pub fn tell_refusals(pieces: &[Placed], trace: &Trace, answer: &mut Answer) {
    let own: BTreeSet<Id> = pieces.iter().map(|piece| piece.accepted.lineage.id).collect();
    let refused = super::lineage::logs(trace).into_iter().flat_map(|log| &log.log.refused);
    let refused = refused.filter(|refused| refused.why.is_some() && own.contains(&refused.lineage.parent));
    tell_drafts(refused.flat_map(|refused| trace.drafts().of(refused.lineage.id)), answer);
}

/// Asks the rules once more with which the growth of a quarter began.
pub fn tell_quarter(quarter: Id, trace: &Trace, evidence: &Evidence, answer: &mut Answer) {
    let Some(first) = trace.tips().first_in(quarter) else { return };
    tell_end(&first, evidence, answer);
    tell_drafts(trace.drafts().near(first.tip.place(), HERE).into_iter(), answer);
}

/// Asks all rules once more that were asked at a place.
pub fn tell_place(place: Vec2, evidence: &Evidence, answer: &mut Answer) {
    let Some(trace) = &evidence.built.trace else { return };
    for tip in trace.tips().near(place, HERE).iter().take(MOST_ENDS) {
        tell_end(tip, evidence, answer);
    }
    tell_drafts(trace.drafts().near(place, HERE).into_iter(), answer);
}

/// The rule of its own that moved the end of a piece last.
pub fn changed_by(piece: Id, evidence: &Evidence) -> Option<String> {
    let drafts = evidence.built.trace.as_ref()?.drafts().of(piece);
    let last = drafts.into_iter().rev().find(|constrained| constrained.to != constrained.draft.to)?;
    Some(last.rule.name().to_owned())
}

/// Tells a decision, unless it was told before.
fn tell(decision: DecisionSays, answer: &mut Answer) {
    if !answer.decisions.contains(&decision) {
        answer.decisions.push(decision);
    }
}

fn tell_end(AskedTip { quarter, tip }: &AskedTip, evidence: &Evidence, answer: &mut Answer) {
    let place = tip.place();
    let plan = evidence.sources.plan.in_quarter(*quarter);
    let Some(streets) = plan_of(stage_of(tip.class), &plan) else { return };
    let parts = shares(&streets.pattern, place, evidence);
    let classes = Arc::new(evidence.built.city.graph.classes().clone());
    let is_blend = parts.len() > 1;
    let end = format!("the street end at ({:.1}, {:.1})", place.x, place.y);
    // Where no pattern has weight, the first is asked.
    for (part, share) in if parts.is_empty() { vec![(0, 1.0)] } else { parts } {
        let Some(part) = streets.pattern.parts().get(part) else { continue };
        let of_blend = if is_blend { format!(", for {:.0} % of a blend", share * 100.0) } else { String::new() };
        let ask = |rule, faults| {
            let mut tip = tip.clone();
            StreetPattern::new(rule, 0, classes.clone(), faults).propose(&mut tip);
            tip.slots
        };
        let (slots, mut decision) = asked(&part.rule, RuleKind::Streets, format!("{end}{of_blend}"), ask);
        decision.outcome.extend(slots_say(&slots));
        tell(decision, answer);
    }
    if is_blend {
        tell(blended(tip, streets, &classes, end, evidence), answer);
    }
}

/// What patterns propose together.
fn blended(tip: &Tip, streets: &StreetPlan, classes: &Arc<Classes>, end: String, evidence: &Evidence) -> DecisionSays {
    let parts = streets.pattern.parts();
    let part = |part: &script::PatternPart| BlendPart {
        rules: Box::new(StreetPattern::new(part.rule.apart(), 0, classes.clone(), Arc::default())),
        weight: weight(&evidence.sources.site, &part.weight),
    };
    let mut tip = tip.clone();
    Blend::of(parts.iter().map(part).collect()).propose(&mut tip);
    let names: Vec<&str> = parts.iter().map(|part| &part.name[..]).collect();
    DecisionSays {
        about: end,
        rule: format!("the blend of {}", names.join(", ")),
        function: RuleKind::Streets.form(),
        outcome: slots_say(&tip.slots),
        ..DecisionSays::default()
    }
}

/// The stage in which streets of a class grow.
fn stage_of(class: Class) -> &'static str {
    match class {
        Classes::HIGHWAY => "highways",
        Classes::MAJOR => "majors",
        _ => "minors",
    }
}

/// Asks rules of their own once more about proposals, each once.
fn tell_drafts(drafts: impl Iterator<Item = Constrained>, answer: &mut Answer) {
    let mut told = 0;
    for constrained in drafts {
        if told == MOST_DRAFTS {
            break;
        }
        let before = answer.decisions.len();
        tell_draft(&constrained, answer);
        told += answer.decisions.len() - before;
    }
}

fn tell_draft(constrained: &Constrained, answer: &mut Answer) {
    let Constrained { rule, draft, .. } = constrained;
    let (from, to) = (draft.from, draft.to);
    let about = format!("the proposal from ({:.1}, {:.1}) to ({:.1}, {:.1})", from.x, from.y, to.x, to.y);
    let ask = |rule, faults| {
        let mut draft = draft.clone();
        ConstraintPattern::new(rule, Arc::default(), faults).constrain(&mut draft);
        draft
    };
    let (after, mut decision) = asked(rule, RuleKind::Constrain, about, ask);
    decision.outcome.push(draft_says(draft, &after));
    tell(decision, answer);
}

/// What became of a proposal.
fn draft_says(before: &Draft, after: &Draft) -> String {
    if let Some(why) = &after.refused {
        return format!("refused: {why}");
    }
    if before.to == after.to {
        return "it stays as it is".into();
    }
    let turn = (after.heading - before.heading).wrapped().to_degrees();
    let turned = if turn.abs() < 0.005 { String::new() } else { format!(", turned by {}°", number(turn)) };
    let (length, to) = (number(after.length()), after.to);
    format!("it is to end at ({:.1}, {:.1}), {length} m long{turned}", to.x, to.y)
}

/// What was proposed, a slot a line.
fn slots_say(slots: &Slots) -> Vec<String> {
    if slots.is_empty() {
        return vec!["nothing is proposed: the street ends".into()];
    }
    let named = [("ahead", slots.ahead), ("to the left", slots.left), ("to the right", slots.right)];
    named.into_iter().filter_map(|(name, slot)| Some(slot_says(name, &slot?.kept()?))).collect()
}

fn slot_says(name: &str, slot: &Slot) -> String {
    let turn = slot.turn.to_radians().to_degrees();
    let turned = if turn == 0.0 { String::new() } else { format!(", turned by {}°", number(turn)) };
    let delayed = match slot.delay {
        0 => String::new(),
        1 => ", after another step".into(),
        steps => format!(", after {steps} further steps"),
    };
    let wide = slot.width.map_or(String::new(), |width| format!(", {} m wide", number(width)));
    format!("{} m {name}{turned}{delayed}{wide}", number(slot.length))
}
