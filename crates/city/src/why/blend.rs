//! Which patterns were blended where a street grew, and with which weights.

use super::lineage::Placed;
use super::{Evidence, PatternSays};
use crate::stages::patterns::weight;
use geom::Vec2;
use script::{PatternPlan, Plan, StreetPlan};

/// The patterns of positive weight where a piece starts, the one that led first; none where a single one decides.
pub fn patterns(placed: &Placed, evidence: &Evidence) -> Vec<PatternSays> {
    let plan = evidence.sources.plan.in_quarter(placed.quarter);
    let Some(streets) = plan_of(placed.stage, &plan) else { return Vec::new() };
    let shares = shares(&streets.pattern, placed.accepted.start().metres(), evidence);
    if shares.len() < 2 {
        return Vec::new();
    }
    // A claim names the rule that led; of two parts with one rule it was the heavier.
    let origin = usize::from(placed.accepted.line.claim.origin);
    let led_by = evidence.built.city.origins.get(origin).map_or("", String::as_str);
    let is_led = |part: &usize| streets.pattern.parts()[*part].rule.name() == led_by;
    let lead = shares.iter().filter(|(part, _)| is_led(part)).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(part, _)| *part);
    let says = |&(part, share): &(usize, f64)| PatternSays {
        name: streets.pattern.parts()[part].name.clone(),
        share: (share * 1000.0).round() / 1000.0,
        leads: Some(part) == lead,
    };
    let mut patterns: Vec<PatternSays> = shares.iter().map(says).collect();
    patterns.sort_by(|a, b| b.leads.cmp(&a.leads).then(b.share.total_cmp(&a.share)));
    patterns
}

/// How streets of a stage grow.
pub fn plan_of<'a>(stage: &str, plan: &'a Plan) -> Option<&'a StreetPlan> {
    match stage {
        "highways" => plan.highways.as_ref(),
        "majors" => plan.majors.as_ref(),
        _ => plan.minors.as_ref(),
    }
}

/// The parts of positive weight at a place, with their shares of all weight.
pub fn shares(pattern: &PatternPlan, place: Vec2, evidence: &Evidence) -> Vec<(usize, f64)> {
    let weigh = |part: &script::PatternPart| weight(&evidence.sources.site, &part.weight).at(place);
    let weights = pattern.parts().iter().map(weigh).enumerate().filter(|(_, weight)| *weight > 0.0);
    let weights: Vec<(usize, f64)> = weights.collect();
    let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
    weights.into_iter().map(|(part, weight)| (part, weight / total)).collect()
}
