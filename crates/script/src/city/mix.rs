//! Patterns that add and weigh like images: `rule("a") * site.map("old") + rule("b") * site.map("old").invert()`.

use super::streets::rule_of;
use crate::fault::{Complaint, Refusal};
use crate::host::{kind_of, number};
use crate::param::ByDistrict;
use crate::pattern::{PatternPlan, WeightPlan};
use crate::plan::MapRef;
use crate::rule::{Rule, RuleKind};
use rhai::{Dynamic, Engine, FuncRegistration};

/// The largest number that a pattern may be weighed with: weights only compare.
const HEAVIEST: f64 = 1e6;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<PatternPlan>("a mix of rules").register_type_with_name::<WeightPlan>("a weight");
    operators::<Rule>(engine);
    operators::<PatternPlan>(engine);
    operators::<MapRef>(engine);
    operators::<WeightPlan>(engine);
    FuncRegistration::new("invert")
        .with_params_info(["this"])
        .with_comments(["/// The weight where the map has none: 1 minus it."])
        .register_into_engine(engine, |map: &mut MapRef| inverse(WeightPlan::Map(map.clone())));
    FuncRegistration::new("invert")
        .with_params_info(["this"])
        .register_into_engine(engine, |weight: &mut WeightPlan| inverse(weight.clone()));
}

fn inverse(weight: WeightPlan) -> WeightPlan {
    WeightPlan::Inverse(Box::new(weight))
}

/// The operators of a type with anything on the other side, so that what makes no sense is told in words.
fn operators<T: rhai::Variant + Clone>(engine: &mut Engine) {
    engine
        .register_fn("*", |a: T, b: Dynamic| times(Dynamic::from(a), b))
        .register_fn("*", |a: Dynamic, b: T| times(a, Dynamic::from(b)))
        .register_fn("+", |a: T, b: Dynamic| plus(Dynamic::from(a), b))
        .register_fn("+", |a: Dynamic, b: T| plus(a, Dynamic::from(b)))
        .register_fn("-", |a: T, b: Dynamic| minus(Dynamic::from(a), b))
        .register_fn("-", |a: Dynamic, b: T| minus(a, Dynamic::from(b)));
}

/// What stands on one side of an operator.
enum Term {
    Pattern(PatternPlan),
    Weight(WeightPlan),
    Other(String),
}

impl Term {
    fn of(value: Dynamic) -> Result<Self, Complaint> {
        if value.is::<Rule>() {
            return rule_of(value, "a pattern", RuleKind::Streets).map(|rule| Self::Pattern(PatternPlan::of(rule)));
        }
        if let Some(number) = number(&value) {
            return weight(number).map(Self::Weight);
        }
        let kind = kind_of(&value);
        let pattern = value.clone().try_cast::<PatternPlan>().map(Self::Pattern);
        let map = || value.clone().try_cast::<MapRef>().map(|map| Self::Weight(WeightPlan::Map(map)));
        let weight = || value.clone().try_cast::<WeightPlan>().map(Self::Weight);
        Ok(pattern.or_else(map).or_else(weight).unwrap_or(Self::Other(kind)))
    }

    fn kind(&self) -> String {
        match self {
            Self::Pattern(_) => "a rule".into(),
            Self::Weight(WeightPlan::Number(_)) => "a number".into(),
            Self::Weight(_) => "a map".into(),
            Self::Other(kind) => kind.clone(),
        }
    }
}

fn weight(number: f64) -> Result<WeightPlan, Complaint> {
    if (0.0..=HEAVIEST).contains(&number) {
        return Ok(WeightPlan::Number(number));
    }
    Err(Complaint::new("a weight must lie between 0 and 1000000").hint(format!("it was {number}")))
}

fn times(a: Dynamic, b: Dynamic) -> Result<Dynamic, Refusal> {
    Ok(match (Term::of(a)?, Term::of(b)?) {
        (Term::Pattern(pattern), Term::Weight(weight)) | (Term::Weight(weight), Term::Pattern(pattern)) => {
            Dynamic::from(pattern.times(&weight))
        }
        (Term::Weight(a), Term::Weight(b)) => Dynamic::from(WeightPlan::Product(vec![a, b])),
        (a, b) => {
            let message = format!("{} cannot be weighed with {}", a.kind(), b.kind());
            return Err(Complaint::new(message)
                .hint("a rule is weighed with maps and numbers: rule(…) * site.map(…)")
                .into());
        }
    })
}

fn plus(a: Dynamic, b: Dynamic) -> Result<Dynamic, Refusal> {
    Ok(match (Term::of(a)?, Term::of(b)?) {
        (Term::Pattern(a), Term::Pattern(b)) => Dynamic::from(a.plus(b)),
        (Term::Weight(a), Term::Weight(b)) => Dynamic::from(WeightPlan::Sum(vec![a, b])),
        (a, b) => {
            let message = format!("{} and {} cannot be added", a.kind(), b.kind());
            let help = "rules are added to rules, each weighed by itself: rule(…) * site.map(…) + rule(…) * 0.2";
            return Err(Complaint::new(message).hint(help).into());
        }
    })
}

fn minus(a: Dynamic, b: Dynamic) -> Result<Dynamic, Refusal> {
    let (a, b) = (Term::of(a)?, Term::of(b)?);
    let message = format!("{} cannot be taken from {}", b.kind(), a.kind());
    Err(Complaint::new(message).hint("1 minus a map is written site.map(…).invert()").into())
}

/// A pattern: a rule, or a mix of rules.
pub(super) fn pattern_of(value: Dynamic) -> Result<PatternPlan, Complaint> {
    if let Some(mix) = value.clone().try_cast::<PatternPlan>() {
        return Ok(mix);
    }
    let by_district = value.read_lock::<ByDistrict>().map(|rules| rules.clone());
    let Some(rules) = by_district else { return rule_of(value, "pattern", RuleKind::Streets).map(PatternPlan::of) };
    let missing = || {
        let help = "by_district(#{ \"old town\": rule(\"streets/organic\") }, rule(\"streets/grid\"))";
        Complaint::new("`pattern` by district needs a rule for all other ground").hint(help).key("pattern")
    };
    let other = pattern_of(rules.other.ok_or_else(missing)?)?;
    let named = rules.named.into_iter().map(|(name, rule)| Ok((name, pattern_of(rule)?)));
    Ok(PatternPlan::by_district(named.collect::<Result<_, Complaint>>()?, other))
}
