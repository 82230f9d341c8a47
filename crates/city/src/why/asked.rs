//! What street rules did at the ends that pieces of street grew from.

use super::blend::{plan_of, shares};
use super::decision::{asked, number};
use super::lineage::Placed;
use super::{Answer, Evidence};
use crate::trace::Trace;
use script::{RuleKind, StreetPattern};
use std::collections::BTreeSet;
use std::sync::Arc;
use streets::growth::{GrowthRules, Slot, Slots, Tip};

/// Street ends that are told of.
const MOST_ENDS: usize = 3;

/// Asks the rules once more at the ends that pieces grew from, the first ones.
pub fn tell_ends(pieces: &[Placed], trace: &Trace, evidence: &Evidence, answer: &mut Answer) {
    let mut known = BTreeSet::new();
    let ends = pieces.iter().filter(|piece| known.insert(piece.accepted.lineage.parent));
    let tips: Vec<(&Placed, Tip)> =
        ends.filter_map(|piece| Some((piece, trace.tips().at(piece.accepted.lineage.parent)?))).collect();
    for (piece, tip) in tips.iter().take(MOST_ENDS) {
        tell_end(piece, tip, evidence, answer);
    }
    if tips.len() > MOST_ENDS {
        answer.tell("told of", format!("the first {MOST_ENDS} of {} street ends that it grew from", tips.len()));
    }
}

fn tell_end(piece: &Placed, tip: &Tip, evidence: &Evidence, answer: &mut Answer) {
    let plan = evidence.sources.plan.in_quarter(piece.quarter);
    let Some(streets) = plan_of(piece.stage, &plan) else { return };
    let parts = shares(&streets.pattern, tip.place(), evidence);
    let classes = Arc::new(evidence.built.city.graph.classes().clone());
    let is_blend = parts.len() > 1;
    // Where no pattern has weight, the first is asked.
    for (part, share) in if parts.is_empty() { vec![(0, 1.0)] } else { parts } {
        let Some(part) = streets.pattern.parts().get(part) else { continue };
        let place = tip.place();
        let of_blend = if is_blend { format!(", for {:.0} % of a blend", share * 100.0) } else { String::new() };
        let about = format!("the street end at ({:.1}, {:.1}){of_blend}", place.x, place.y);
        let ask = |rule, faults| {
            let mut tip = tip.clone();
            StreetPattern::new(rule, 0, classes.clone(), faults).propose(&mut tip);
            tip.slots
        };
        let (slots, mut decision) = asked(&part.rule, RuleKind::Streets, about, ask);
        decision.outcome.extend(slots_say(&slots));
        answer.decisions.push(decision);
    }
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
    let delayed = if slot.delay == 0 { String::new() } else { format!(", after {} further steps", slot.delay) };
    let wide = slot.width.map_or(String::new(), |width| format!(", {} m wide", number(width)));
    format!("{} m {name}{turned}{delayed}{wide}", number(slot.length))
}
