//! How a block was divided, and what stands on a parcel: the rules asked once more.

use super::decision::{DecisionSays, asked, in_city, number};
use super::{Answer, Evidence};
use crate::stages::buildings::{built_shape, limited, start_shape};
use crate::stages::ground::CityGround;
use crate::stages::land::{self, Cover, assigned_shape, block_context, divide_region, inner_place};
use crate::stages::{ByPlace, Context, landmarks};
use buildings::{Envelope, Setbacks, footprint, kept_setback};
use geom::{Id, Vec2};
use layout::{Block, DivisionStep, Looked, Parcel, Region, Use};
use script::{AssignPattern, Assigned, BuildingChoice, BuildingPattern, ParcelChoice, ParcelPattern, Rule, RuleKind};
use std::sync::Arc;

/// Cuts that are told one by one.
const MOST_CUTS: usize = 24;

/// Tells how all of a block was divided.
pub fn tell_block(block: &Block, evidence: &Evidence, answer: &mut Answer) {
    in_city(evidence, answer, |context, ground, answer| {
        let rules = rules_of(context, "parcels");
        for region in land::parted(block, &grounds(context)).rest {
            let divided = Divided::of(context, ground, &rules, block, region);
            if let Some(mut decision) = divided.decision.clone() {
                decision.outcome.push(divided.says());
                answer.decisions.push(decision);
            } else if let Some(why) = covered(divided.cover) {
                answer.tell("why", why);
            }
        }
    });
}

/// Tells how a parcel came to be: the cuts that led to it, what it is for, and what is built on it.
pub fn tell_parcel(parcel: &Parcel, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let Some(block) = city.blocks.iter().find(|block| block.id == parcel.block) else { return };
    in_city(evidence, answer, |context, ground, answer| {
        let rules = rules_of(context, "parcels");
        let regions = land::parted(block, &grounds(context)).rest;
        let divided = regions.into_iter().map(|region| Divided::of(context, ground, &rules, block, region));
        let own = divided.into_iter().find_map(|divided| {
            let before = divided.parcels.iter().find(|other| other.id == parcel.id)?.clone();
            Some((divided, before))
        });
        if let Some((divided, before)) = own {
            tell_divided(context, ground, (block, &before), divided, answer);
        }
        if parcel.usage == Use::Built {
            tell_building(context, ground, (block.quarter, parcel), evidence, answer);
        }
    });
}

/// Tells what is built on a parcel, and why nothing is.
pub fn tell_built(parcel: &Parcel, block: Option<&Block>, evidence: &Evidence, answer: &mut Answer) {
    let quarter = block.and_then(|block| block.quarter);
    in_city(evidence, answer, |context, ground, answer| {
        tell_building(context, ground, (quarter, parcel), evidence, answer);
    });
}

fn grounds(context: &Context) -> Vec<geom::Polygon> {
    landmarks::grounds(&context.sources.plan.landmarks)
}

fn rules_of(context: &Context, role: &str) -> ByPlace<Rule> {
    ByPlace::of(context, role, |rule| rule)
}

/// A region of a block as it was divided.
struct Divided {
    cover: Cover,
    choice: Option<ParcelChoice>,
    /// Before they were assigned what they are for.
    parcels: Vec<Parcel>,
    steps: Vec<DivisionStep>,
    rule: Option<Rule>,
    /// What the rule did, where it was asked.
    decision: Option<DecisionSays>,
}

impl Divided {
    fn of(context: &Context, ground: &Arc<CityGround>, rules: &ByPlace<Rule>, block: &Block, region: Region) -> Self {
        let rule = rules.at(block.quarter, &land::district_of(context, &region)).cloned();
        let mut steps = Vec::new();
        let pattern = rule.as_ref().map(|rule| ParcelPattern::new(rule.apart(), Arc::default()));
        let divided = divide_region(context, ground, pattern.as_ref(), block, &region, &mut |step| steps.push(step));
        let decision = rule.as_ref().filter(|_| divided.cover == Cover::Land).map(|rule| {
            let about = format!("{} m² of the block, without its streets", number(region.polygon.area()));
            let ask =
                |rule, faults| ParcelPattern::new(rule, faults).choose(block_context(context, ground, block, &region));
            asked(rule, RuleKind::Parcels, about, ask).1
        });
        Self { cover: divided.cover, choice: divided.choice, parcels: divided.parcels, steps, rule, decision }
    }

    /// What became of the region, in a line.
    fn says(&self) -> String {
        match self.choice {
            Some(ParcelChoice::Recursive(_)) => {
                let count = |is: fn(&DivisionStep) -> bool| self.steps.iter().filter(|step| is(step)).count();
                let cuts = count(|step| matches!(step, DivisionStep::Look { outcome: Looked::Cut { .. }, .. }));
                let joins = count(|step| matches!(step, DivisionStep::Join { .. }));
                let open = self.parcels.iter().filter(|parcel| parcel.usage != Use::Built).count();
                format!(
                    "{cuts} cuts, {joins} pieces joined to others, {} parcels, {open} of them open",
                    self.parcels.len()
                )
            }
            Some(ParcelChoice::Open) => "one parcel that stays open".into(),
            Some(ParcelChoice::Whole) | None => "one parcel that may carry a building".into(),
        }
    }

    /// The steps that led to a parcel, in words.
    fn led_to(&self, parcel: Id) -> Vec<String> {
        let mut said: Vec<String> = Vec::new();
        let mut piece = parcel;
        let cut_to = |piece: Id| {
            self.steps.iter().find_map(|step| match *step {
                DivisionStep::Look { piece: whole, area, wanted, outcome: Looked::Cut { ends, parts } }
                    if parts.contains(&piece) =>
                {
                    let [from, to] = ends.map(|end| place_says(end.metres()));
                    let (area, wanted) = (number(area), number(wanted));
                    let side = if parts[0] == piece { "left" } else { "right" };
                    Some((
                        whole,
                        format!("cut {area} m² (more than {wanted}) from {from} to {to}; it lies {side} of that"),
                    ))
                }
                _ => None,
            })
        };
        while let Some((whole, cut)) = cut_to(piece)
            && said.len() < MOST_CUTS
        {
            said.push(cut);
            piece = whole;
        }
        said.reverse();
        said.extend(self.steps.iter().filter_map(|step| after_cuts(step, parcel)));
        said
    }
}

/// What was done to a piece once it was not cut any more.
fn after_cuts(step: &DivisionStep, parcel: Id) -> Option<String> {
    match *step {
        DivisionStep::Look { piece, area, wanted, outcome: Looked::Kept } if piece == parcel => {
            Some(format!("kept as it is: {} m², at most {} wanted", number(area), number(wanted)))
        }
        DivisionStep::Look { piece, area, wanted, outcome: Looked::NoCut } if piece == parcel => Some(format!(
            "not cut, though {} m² are more than {} or it is too concave: no cut leaves pieces that are large, compact and \
             accessible enough",
            number(area),
            number(wanted)
        )),
        DivisionStep::Join { to, area, is_court, .. } if to == parcel => {
            let why = if is_court { "that lies behind others, too" } else { "too small, too thin or without access" };
            Some(format!("took in a neighbour of {} m², {why}", number(area)))
        }
        DivisionStep::Open { piece, why } if piece == parcel => Some(format!("open: {why}")),
        _ => None,
    }
}

/// Why no rule is asked.
fn covered(cover: Cover) -> Option<&'static str> {
    match cover {
        Cover::Land => None,
        Cover::Park => Some("most of its land is park on the map `parks`, so no rule is asked"),
        Cover::Water => Some("most of its land is water on the map `land`, so no rule is asked"),
    }
}

fn place_says(at: Vec2) -> String {
    format!("({:.1}, {:.1})", at.x, at.y)
}

/// Tells how a region was divided into a parcel and others, and what that one is for. The parcel is as it was before that.
fn tell_divided(
    context: &Context,
    ground: &Arc<CityGround>,
    (block, parcel): (&Block, &Parcel),
    divided: Divided,
    answer: &mut Answer,
) {
    if let Some(why) = covered(divided.cover) {
        answer.tell("why", why);
    }
    let led_to = divided.led_to(parcel.id);
    let (choice, rule) = (divided.says(), divided.rule);
    if let Some(mut decision) = divided.decision {
        decision.outcome.push(choice);
        decision.outcome.extend(led_to);
        answer.decisions.push(decision);
    }
    let is_asked = divided.cover == Cover::Land && parcel.usage == Use::Built;
    let Some(rule) = rule.filter(|rule| is_asked && rule.kinds().contains(&RuleKind::Assign)) else { return };
    let ask =
        |rule, faults| AssignPattern::new(rule, faults).assign(assigned_shape(context, ground, block.quarter, parcel));
    let (Assigned { usage, tags }, mut decision) = asked(&rule, RuleKind::Assign, "the parcel", ask);
    let usage = usage.map_or("built on, as divided", crate::export::geojson::use_name);
    let tags = if tags.is_empty() { String::new() } else { format!(", with the tags {}", tags.join(", ")) };
    decision.outcome.push(format!("it is {usage}{tags}"));
    answer.decisions.push(decision);
}

/// Tells what a building rule says of a parcel, and what limits make of that.
fn tell_building(
    context: &Context,
    ground: &Arc<CityGround>,
    (quarter, parcel): (Option<Id>, &Parcel),
    evidence: &Evidence,
    answer: &mut Answer,
) {
    let rules = rules_of(context, "buildings");
    let Some(rule) = rules.at(quarter, &context.district(inner_place(&parcel.polygon))) else { return };
    let about = built_shape(context, &evidence.built.city.landmarks, ground, parcel, quarter);
    let ask = |rule, faults| BuildingPattern::new(rule, faults).choose(about.clone());
    let (choice, mut decision) = asked(rule, RuleKind::Buildings, "the parcel", ask);
    match choice {
        BuildingChoice::None => decision.outcome.push("nothing is built".into()),
        BuildingChoice::Extrude(envelope) => {
            let is_stand_in = !decision.outcome.is_empty();
            let stand_in = || format!("a plain box of {} m stands in for it", number(envelope.height));
            decision.outcome.push(if is_stand_in { stand_in() } else { envelope_says(&envelope) });
            decision.outcome.extend(limits_say(context, parcel, (about.density, about.max_height), envelope));
        }
    }
    answer.decisions.push(decision);
}

/// What a rule asked for.
fn envelope_says(envelope: &Envelope) -> String {
    let height = number(envelope.height);
    let distances = match envelope.setbacks {
        Setbacks::Even(0.0) => String::new(),
        Setbacks::Even(setback) => format!(", {} m from its rim", number(setback)),
        Setbacks::Sides { front, side, rear } => {
            let [front, side, rear] = [front, side, rear].map(number);
            format!(", {front} m from the street, {side} m from neighbours, {rear} m from what lies behind")
        }
    };
    let coverage = match envelope.coverage {
        share if share < 1.0 => format!(", on at most {} % of the parcel", number(share * 100.0)),
        _ => String::new(),
    };
    format!("asked for {height} m of height{distances}{coverage}")
}

/// What limits made of it.
fn limits_say(
    context: &Context,
    parcel: &Parcel,
    (density, max_height): (f64, f64),
    envelope: Envelope,
) -> Vec<String> {
    let Some(limited) = limited(envelope, max_height) else {
        return vec![format!("nothing is built: the map `max_height` allows {} m here", number(max_height))];
    };
    let mut said = Vec::new();
    if limited.height < envelope.height {
        said.push(format!("the map `max_height` cuts that to {} m", number(limited.height)));
    }
    let (shape, whole) = (start_shape(context, parcel, density), number(parcel.polygon.area()));
    let Some(within) = footprint(&shape, &Envelope { coverage: 1.0, ..limited }) else {
        said.push(format!("nothing is built: the distances leave no room on {whole} m²"));
        return said;
    };
    if let Setbacks::Even(asked) = limited.setbacks
        && let Some(kept) = kept_setback(&shape, asked).filter(|kept| *kept < asked)
    {
        let (asked, kept) = (number(asked), number(kept));
        said.push(format!("{asked} m from its rim leave no room: it keeps {kept} m"));
    }
    said.push(format!("the distances leave {} of {whole} m²", number(within.area())));
    match footprint(&shape, &limited) {
        Some(covering) if covering.area() < within.area() => {
            said.push(format!("the coverage takes that down to {} m²", number(covering.area())));
        }
        Some(_) => {}
        None => said.push("nothing is built: the coverage leaves no room".into()),
    }
    said
}
