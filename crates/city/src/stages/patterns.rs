//! Patterns as growth asks them: a rule, or several blended by maps.

use super::Context;
use super::streets::Network;
use crate::Site;
use crate::trace::{Constrained, Drafts, Tips};
use geom::Id;
use script::{ConstraintPattern, PatternPart, PatternPlan, Rule, StreetPattern, WeightPlan};
use std::sync::Arc;
use streets::PerDistrict;
use streets::growth::{Blend, BlendPart, Constrain, Draft, Field, GrowthRules, Own, Tip, Weight};

/// What growth asks; where it is traced, tips are kept.
pub(super) fn pattern(
    context: &Context,
    network: &mut Network,
    plan: &PatternPlan,
    quarter: Option<Id>,
) -> Box<dyn GrowthRules + Send> {
    let rules = rules(context, network, plan);
    match &network.trace {
        Some(trace) => Box::new(Overheard { rules, tips: trace.tips().clone(), quarter }),
        None => rules,
    }
}

/// A single rule is asked as it is.
fn rules(context: &Context, network: &mut Network, plan: &PatternPlan) -> Box<dyn GrowthRules + Send> {
    let classes = Arc::new(network.graph.classes().clone());
    let part = |part: &PatternPart| {
        let origin = network.origins.of(part.rule.name());
        let rules = StreetPattern::new(part.rule.clone(), origin, classes.clone(), context.faults.clone());
        BlendPart { rules: Box::new(rules), weight: weight(&context.sources.site, &part.weight) }
    };
    let mut parts: Vec<BlendPart> = plan.parts().iter().map(part).collect();
    if parts.len() == 1 { parts.remove(0).rules } else { Box::new(Blend::of(parts)) }
}

/// Rules of which it is kept where they are asked.
struct Overheard {
    rules: Box<dyn GrowthRules + Send>,
    tips: Tips,
    quarter: Option<Id>,
}

impl GrowthRules for Overheard {
    fn propose(&self, tip: &mut Tip) {
        self.tips.keep(self.quarter, tip);
        self.rules.propose(tip);
    }

    fn origin(&self) -> u16 {
        self.rules.origin()
    }

    fn origin_of(&self, lead: Option<u16>) -> u16 {
        self.rules.origin_of(lead)
    }

    fn is_in_vain(&self) -> bool {
        self.rules.is_in_vain()
    }
}

/// What asks a rule about proposals; where growth is traced, what became of them is kept.
pub(super) fn overhearing(network: &Network) -> impl Fn(&Rule, ConstraintPattern) -> Own + use<> {
    let drafts = network.trace.as_ref().map(|trace| trace.drafts().clone());
    move |rule, pattern| match &drafts {
        Some(drafts) => Own(Arc::new(OverheardOwn { rule: rule.clone(), pattern, drafts: drafts.clone() })),
        None => Own(Arc::new(pattern)),
    }
}

/// A constraint of a rule's own of which it is kept what it makes of proposals.
#[derive(Debug)]
struct OverheardOwn {
    rule: Rule,
    pattern: ConstraintPattern,
    drafts: Drafts,
}

impl Constrain for OverheardOwn {
    fn constrain(&self, draft: &mut Draft) {
        let before = draft.clone();
        self.pattern.constrain(draft);
        self.drafts.keep(Constrained { rule: self.rule.clone(), draft: before, to: draft.to });
    }

    fn is_in_vain(&self) -> bool {
        self.pattern.is_in_vain()
    }

    fn has_agreed(&self) {
        self.pattern.has_agreed();
    }
}

/// How much a pattern counts on a site.
pub(crate) fn weight(site: &Site, plan: &WeightPlan) -> Weight {
    let all = |plans: &[WeightPlan]| plans.iter().map(|plan| weight(site, plan)).collect();
    match plan {
        WeightPlan::Number(number) => Weight::Number(*number),
        // The maps of a plan were read; one that is not there weighs nothing.
        WeightPlan::Map(map) => {
            site.map(&map.name).map_or(Weight::Number(0.0), |map| Weight::Map(Field::Map(map.clone())))
        }
        WeightPlan::Districts(names) => {
            let inside = |name: &str| names.iter().any(|own| own == name).then_some(Field::Constant(1.0));
            let districts = site.districts.clone();
            Weight::Map(Field::District(Arc::new(PerDistrict::new(districts, inside, Field::Constant(0.0)))))
        }
        WeightPlan::Inverse(other) => Weight::Inverse(Box::new(weight(site, other))),
        WeightPlan::Product(factors) => Weight::Product(all(factors)),
        WeightPlan::Sum(terms) => Weight::Sum(all(terms)),
    }
}
