//! What streets keep to: `constraints(p)` answers with a chain of named steps, or a map of the standard chain's values.

use super::numbers::{Differing, Numbers, Range};
use super::once::complaint;
use super::options::{Options, pair};
use crate::fault::{Complaint, Fault, Refusal};
use crate::host::kind_of;
use crate::plan::MapRef;
use crate::rule::{Rule, RuleKind};
use geom::{Angle, Point, Polygon};
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use streets::growth::{
    Area, BRIDGE_SPACING, Bridge, Chain, Constraints, Duplicate, Extend, Legal, Length, MOST_STEPS, Over, Own,
    Quantity, Slope, Step, TurnSearch, Varying,
};
use streets::{Districts, PerDistrict};

/// What a length of a constraint may be.
const METRES: Range = Range::of(0.0, 10_000.0, " m");
/// What an angle of a constraint may be.
const TURN: Range = Range::of(0.0, 180.0, "°");
/// What a slope may be.
const SLOPE: Range = Range::of(0.0, 100.0, "");
/// Within which multiple of its length a street may go on.
const FACTOR: Range = Range::of(1.0, 100.0, "");
const SHARE: Range = Range::of(0.0, 1.0, "");

/// A step as a rule names it.
#[derive(Clone, Debug)]
enum Link {
    /// One of the kernel's, with what of it differs by place.
    Native(&'static str, Step, Vec<Differing>),
    /// The rule's own `constrain(segment, p)`.
    Own,
}

impl Link {
    fn name(&self) -> &'static str {
        match self {
            Self::Native(name, ..) => name,
            Self::Own => "own",
        }
    }

    /// Whether a chain may hold several.
    fn repeats(&self) -> bool {
        matches!(self, Self::Native(_, Step::Mask(_), _))
    }
}

type Told = Result<Link, Refusal>;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Link>("a constraint");
    ground(engine);
    streets(engine);
    FuncRegistration::new("own")
        .with_comments(["/// The place of this file's own `constrain(segment, p)` in the chain."])
        .register_into_engine(engine, || Link::Own);
}

/// Steps that look at the ground.
fn ground(engine: &mut Engine) {
    FuncRegistration::new("legal")
        .with_params_info([
            "#{ prune, turn_step, turn_most, turn_first, bridge, bridge_spacing, bridge_over, bridge_first }",
        ])
        .with_comments(["/// Streets stay on legal ground: they are cut back, turn along its rim, or bridge over."])
        .register_into_engine(engine, |options: Map| -> Told { Ok(legal(options)?) });
    FuncRegistration::new("legal").register_into_engine(engine, || -> Told { Ok(legal(Map::new())?) });
    FuncRegistration::new("slope")
        .with_params_info(["most", "#{ turn_step, turn_most, hairpin, tunnel }"])
        .with_comments([
            "/// No street is steeper than `most` (rise over run): it turns, goes through the hill, or turns back.",
        ])
        .register_into_engine(engine, |most: Dynamic, options: Map| -> Told { Ok(slope(&most, options)?) });
    FuncRegistration::new("slope")
        .with_params_info(["most"])
        .register_into_engine(engine, |most: Dynamic| -> Told { Ok(slope(&most, Map::new())?) });
    FuncRegistration::new("mask")
        .with_params_info(["area"])
        .with_comments(["/// Streets are clipped to a map, or to a polygon [[x, y], …] in metres."])
        .register_into_engine(engine, |area: Dynamic| -> Told { Ok(mask(area)?) });
    FuncRegistration::new("length")
        .with_params_info(["least", "longest"])
        .with_comments(["/// Shortest and longest piece of street, in metres."])
        .register_into_engine(engine, |least: Dynamic, longest: Dynamic| -> Told { Ok(length(&least, &longest)?) });
}

/// Steps that look at other streets.
fn streets(engine: &mut Engine) {
    FuncRegistration::new("crossing")
        .with_comments(["/// A street that crosses another ends there."])
        .register_into_engine(engine, || Link::Native("crossing", Step::Crossing, Vec::new()));
    let one = |engine: &mut Engine,
               name: &'static str,
               doc: &'static str,
               argument: &'static str,
               make: fn(&Dynamic, &mut Numbers) -> Result<Step, Complaint>| {
        FuncRegistration::new(name).with_params_info([argument]).with_comments([doc]).register_into_engine(
            engine,
            move |value: Dynamic| -> Told {
                let mut numbers = Numbers::default();
                let step = make(&value, &mut numbers)?;
                Ok(Link::Native(name, step, numbers.0))
            },
        );
    };
    one(
        engine,
        "snap",
        "/// A street that ends, or passes a crossing, closer than this goes to it.",
        "metres",
        |value, numbers| Ok(Step::Snap(numbers.read("the snapping distance", value, METRES, &[Quantity::Snap])?)),
    );
    one(
        engine,
        "join",
        "/// A street that ends beside another, closer than this, goes to it.",
        "metres",
        |value, numbers| Ok(Step::Join(numbers.read("the joining distance", value, METRES, &[Quantity::Join])?)),
    );
    FuncRegistration::new("duplicate")
        .with_params_info(["metres"])
        .with_comments(["/// Near-parallel streets closer than this are one too many."])
        .register_into_engine(engine, |within: Dynamic| -> Told { Ok(duplicate(&within, Map::new())?) });
    FuncRegistration::new("duplicate")
        .with_params_info(["metres", "#{ whole }"])
        .register_into_engine(engine, |within: Dynamic, options: Map| -> Told { Ok(duplicate(&within, options)?) });
    one(engine, "angle", "/// Least angle between streets at a crossing.", "degrees", |value, numbers| {
        Ok(Step::Angle(Angle::degrees(numbers.read("the least angle", value, TURN, &[Quantity::Angle])?)))
    });
    one(engine, "arms", "/// Most streets that meet in a crossing.", "count", |value, numbers| {
        let range = Range::of(2.0, 100.0, "");
        Ok(Step::Arms(numbers.read("the most streets of a crossing", value, range, &[Quantity::Arms])? as u32))
    });
    FuncRegistration::new("extend")
        .with_params_info(["factor", "most"])
        .with_comments([
            "/// A street goes on to one it would meet within this multiple of its length, by `most` metres.",
        ])
        .register_into_engine(engine, |factor: Dynamic, most: Dynamic| -> Told { Ok(extend(&factor, &most)?) });
}

fn length(least: &Dynamic, longest: &Dynamic) -> Result<Link, Complaint> {
    let mut numbers = Numbers::default();
    let least = numbers.read("the least length", least, METRES, &[Quantity::LeastLength])?;
    let longest = numbers.read("the longest length", longest, METRES, &[Quantity::Longest])?;
    // Where they differ by place, nothing is laid where the least is the greater.
    if least > longest && numbers.0.is_empty() {
        return Err(Complaint::new(format!("the least length ({least} m) is greater than the longest ({longest} m)")));
    }
    Ok(Link::Native("length", Step::Length(Length { least, longest }), numbers.0))
}

fn extend(factor: &Dynamic, most: &Dynamic) -> Result<Link, Complaint> {
    let mut numbers = Numbers::default();
    let factor = numbers.read("the multiple of the length", factor, FACTOR, &[Quantity::Extend])?;
    let most = numbers.read("the longest extension", most, METRES, &[Quantity::ExtendMost])?;
    Ok(Link::Native("extend", Step::Extend(Extend { factor, most }), numbers.0))
}

fn duplicate(within: &Dynamic, options: Map) -> Result<Link, Complaint> {
    let (mut options, mut numbers) = (Options::new("duplicate", options, &["whole"])?, Numbers::default());
    let within = numbers.read("the distance of duplicates", within, METRES, &[Quantity::Duplicate])?;
    let is_whole = options.flag("whole")?.unwrap_or(false);
    Ok(Link::Native("duplicate", Step::Duplicate(Duplicate { within, is_whole }), numbers.0))
}

/// A search for a heading. How finely is looked for one holds everywhere.
fn turns(options: &mut Options, numbers: &mut Numbers, quantities: &[Quantity]) -> Result<TurnSearch, Complaint> {
    let default = Constraints::default();
    let most = numbers.option(options, "turn_most", TURN, quantities)?;
    Ok(TurnSearch {
        // A step of nothing would search without an end.
        step: options.within("turn_step", 0.1, 180.0, "°")?.map_or(default.turn_step, Angle::degrees),
        most: most.map_or(default.turn_most, Angle::degrees),
    })
}

fn legal(options: Map) -> Result<Link, Complaint> {
    let known =
        ["prune", "turn_step", "turn_most", "turn_first", "bridge", "bridge_spacing", "bridge_over", "bridge_first"];
    let (mut options, mut numbers) = (Options::new("legal", options, &known)?, Numbers::default());
    let longest = numbers.option(&mut options, "bridge", METRES, &[Quantity::Bridge])?.unwrap_or(0.0);
    let spacing = numbers.option(&mut options, "bridge_spacing", METRES, &[Quantity::BridgeSpacing])?;
    let bridge = Bridge {
        longest,
        spacing: spacing.unwrap_or(BRIDGE_SPACING),
        over: over(&mut options)?,
        is_first: options.flag("bridge_first")?.unwrap_or(false),
    };
    let prune = numbers.option(&mut options, "prune", SHARE, &[Quantity::Prune])?;
    let legal = Legal {
        prune: prune.unwrap_or(Constraints::default().prune),
        turns: turns(&mut options, &mut numbers, &[Quantity::LegalTurn])?,
        turns_first: options.flag("turn_first")?.unwrap_or(false),
        bridge: (longest > 0.0 || numbers.has(Quantity::Bridge)).then_some(bridge),
    };
    Ok(Link::Native("legal", Step::Legal(legal), numbers.0))
}

fn over(options: &mut Options) -> Result<Over, Complaint> {
    match options.text("bridge_over")?.as_deref() {
        None | Some("water") => Ok(Over::Water),
        Some("any") => Ok(Over::Any),
        Some(other) => {
            Err(Complaint::new(format!("`bridge_over` must be \"water\" or \"any\", not \"{other}\""))
                .key("bridge_over"))
        }
    }
}

fn slope(most: &Dynamic, options: Map) -> Result<Link, Complaint> {
    let mut numbers = Numbers::default();
    let most = numbers.read("the steepest slope", most, SLOPE, &[Quantity::Slope]).map_err(|wrong| {
        let hint = wrong.hint.clone().unwrap_or_else(|| "rise over run: 0.12 is 12 %".into());
        wrong.hint(hint)
    })?;
    let mut options = Options::new("slope", options, &["turn_step", "turn_most", "hairpin", "tunnel"])?;
    let slope = Slope {
        most,
        turns: turns(&mut options, &mut numbers, &[Quantity::SlopeTurn])?,
        has_hairpins: options.flag("hairpin")?.unwrap_or(false),
        tunnel: numbers.option(&mut options, "tunnel", METRES, &[Quantity::Tunnel])?.unwrap_or(0.0),
    };
    Ok(Link::Native("slope", Step::Slope(slope), numbers.0))
}

fn mask(area: Dynamic) -> Result<Link, Complaint> {
    let given = kind_of(&area);
    let native = |area| Ok(Link::Native("mask", Step::Mask(area), Vec::new()));
    if let Some(map) = area.clone().try_cast::<MapRef>() {
        return native(Area::Map(map.name.into()));
    }
    if let Ok(name) = area.clone().into_string() {
        return native(Area::Map(name.into()));
    }
    let wrong = || Complaint::new(format!("mask takes a map or a polygon, not {given}"));
    let points: Array =
        area.try_cast().ok_or_else(|| wrong().hint("mask(p.area) or mask([[0, 0], [900, 0], [400, 700]])"))?;
    native(Area::Polygon(Arc::new(polygon(points)?)))
}

fn polygon(points: Array) -> Result<Polygon, Complaint> {
    let far = || Complaint::new("a point lies more than 500 km away");
    let at = |point: Dynamic| Point::try_from_metres(pair(point)?).ok_or_else(far);
    let polygon = Polygon::new(points.into_iter().map(at).collect::<Result<_, _>>()?, Vec::new());
    if polygon.is_valid() {
        return Ok(polygon);
    }
    Err(Complaint::new("a mask needs at least three corners, and its rim must not cross itself"))
}

/// What a rule with `constraints(p)` tells.
fn links_of(rule: &Rule) -> Result<Vec<Link>, Fault> {
    let value = rule.evaluate(RuleKind::Constraints)?;
    let told = links(value, rule).map_err(|wrong| complaint(rule, RuleKind::Constraints, wrong))?;
    Ok(told)
}

fn links(value: Dynamic, rule: &Rule) -> Result<Vec<Link>, Complaint> {
    let given = kind_of(&value);
    if value.is_map() {
        let (standard, mut numbers) = standard(value.cast::<Map>())?;
        let steps = Chain::from(standard).steps().to_vec();
        // What differs by place is told of quantities: any step may carry it.
        return Ok(steps.into_iter().map(|step| Link::Native("", step, std::mem::take(&mut numbers.0))).collect());
    }
    let wrong = || {
        Complaint::new(format!("returns {given}"))
            .hint("return [legal(), crossing(), snap(p.snap), …] or #{ snap: p.snap, … }")
    };
    let list: Array = value.try_cast().ok_or_else(wrong)?;
    let links: Vec<Link> = list.into_iter().map(link).collect::<Result<_, _>>()?;
    if links.len() > MOST_STEPS {
        return Err(Complaint::new(format!("a chain holds at most {MOST_STEPS} constraints, not {}", links.len())));
    }
    let mut seen = BTreeSet::new();
    if let Some(twice) = links.iter().find(|link| !link.repeats() && !seen.insert(link.name())) {
        return Err(Complaint::new(format!("`{}` stands twice in the chain", twice.name())));
    }
    if links.iter().any(|link| matches!(link, Link::Own)) && !rule.kinds().contains(&RuleKind::Constrain) {
        let message = "own() needs a function of this file";
        return Err(Complaint::new(message).hint(format!("write `fn {}`", RuleKind::Constrain.form())));
    }
    Ok(links)
}

fn link(value: Dynamic) -> Result<Link, Complaint> {
    let given = kind_of(&value);
    let wrong = || Complaint::new(format!("a chain is a list of constraints, and {given} is none"));
    value.try_cast().ok_or_else(|| wrong().hint("such as legal(), slope(0.1), crossing(), snap(5), extend(1.25, 30)"))
}

/// The chain that rules make together, in their order: at most one tells a chain; the constraints of one's own stand
/// where `own()` says, else behind the steps of their file. Without a chain they follow the standard one. Each is asked once
/// for every district in which its parameters differ: its steps hold everywhere, what they are told may differ.
pub(crate) fn chain_of(rules: &[Rule], standard: Chain, own: &dyn Fn(&Rule) -> Own) -> Result<Chain, Fault> {
    let own_of = |rule: &Rule| rule.kinds().contains(&RuleKind::Constrain).then(|| own(rule));
    let owns: Vec<Option<Own>> = rules.iter().map(own_of).collect();
    let chain_in = |district| chain_in(district, rules, standard.clone(), &owns);
    let everywhere = chain_in(None)?;
    let names: BTreeSet<&str> = rules.iter().flat_map(|rule| rule.params().districts()).collect();
    let mut chains =
        names.iter().map(|&name| Ok((name, chain_in(Some(name))?))).collect::<Result<BTreeMap<_, _>, _>>()?;
    if chains.is_empty() {
        return Ok(everywhere);
    }
    // Before the plan is settled there are no districts; what is wrong in one is found all the same.
    let districts = rules.iter().find_map(|rule| rule.params().places()).map_or_else(
        || Arc::new(Districts::of_areas(names.iter().map(|&name| name.to_owned()).collect(), Vec::new())),
        |places| places.districts.clone(),
    );
    let districts = PerDistrict::new(districts, |name| chains.remove(name), everywhere.clone());
    everywhere.in_districts(districts).ok_or_else(|| {
        let wrong = Complaint::new("this tells other steps in one district than in another")
            .hint("what the steps are told may differ by district; which there are, and what masks clip to, may not");
        let telling = rules.iter().find(|rule| rule.kinds().contains(&RuleKind::Constraints));
        telling
            .map_or_else(|| Fault::new("", "no rule tells steps"), |rule| complaint(rule, RuleKind::Constraints, wrong))
    })
}

/// The chain in one district, or outside all of them.
fn chain_in(district: Option<&str>, rules: &[Rule], standard: Chain, owns: &[Option<Own>]) -> Result<Chain, Fault> {
    let has = |rule: &&Rule, kind| rule.kinds().contains(&kind);
    let mut chains = rules.iter().filter(|rule| has(rule, RuleKind::Constraints));
    let (first, second) = (chains.next(), chains.next());
    if let (Some(first), Some(second)) = (first, second) {
        let message = format!("`{}` tells a chain, and so does `{}`", second.name(), first.name());
        return Err(Fault::new(second.path(), message)
            .with_hint(Some("of several rules one may have `fn constraints(p)`".into())));
    }
    let mut steps = if first.is_none() { standard.steps().to_vec() } else { Vec::new() };
    let mut varying = Vec::new();
    for (rule, own) in rules.iter().zip(owns) {
        let there = rule.with(rule.params().in_district(district));
        let links = if has(&rule, RuleKind::Constraints) { links_of(&there)? } else { Vec::new() };
        varying.extend(varying_of(&links, &there)?);
        let is_placed = links.iter().any(|link| matches!(link, Link::Own));
        let own = || own.clone().map(Step::Own);
        steps.extend(links.into_iter().filter_map(|link| match link {
            Link::Native(_, step, _) => Some(step),
            Link::Own => own(),
        }));
        if !is_placed {
            steps.extend(own());
        }
    }
    if steps.len() > MOST_STEPS {
        let message = format!("these constraints are {} steps together; at most {MOST_STEPS} are kept to", steps.len());
        return Err(Fault::new(rules.last().map_or("", Rule::path), message));
    }
    Ok(Chain::new(steps).varied(varying))
}

/// What of the steps of a rule differs by place: none before the plan is settled on a site.
fn varying_of(links: &[Link], rule: &Rule) -> Result<Vec<Varying>, Fault> {
    let Some(places) = rule.params().places() else { return Ok(Vec::new()) };
    let differing = links.iter().flat_map(|link| match link {
        Link::Native(.., differing) => differing.as_slice(),
        Link::Own => &[],
    });
    let read = |differing: &Differing| differing.on(places);
    let varying: Result<Vec<Vec<Varying>>, Complaint> = differing.map(read).collect();
    let varying = varying.map_err(|wrong| complaint(rule, RuleKind::Constraints, wrong))?;
    Ok(varying.into_iter().flatten().collect())
}

/// Every value of the standard chain that a rule may set.
const FIELDS: [&str; 12] = [
    "snap",
    "extend",
    "extend_most",
    "duplicate",
    "least_length",
    "longest",
    "least_angle",
    "prune",
    "turn_step",
    "turn_most",
    "bridge",
    "max_slope",
];

/// The standard chain with values of a rule; what it leaves out keeps its default.
fn standard(map: Map) -> Result<(Constraints, Numbers), Complaint> {
    let (mut options, mut numbers) = (Options::new("constraints", map, &FIELDS)?, Numbers::default());
    let default = Constraints::default();
    let TurnSearch { step: turn_step, most: turn_most } =
        turns(&mut options, &mut numbers, &[Quantity::LegalTurn, Quantity::SlopeTurn])?;
    let mut number = |key: &str, range: Range, quantities: &[Quantity], default: f64| {
        Ok::<_, Complaint>(numbers.option(&mut options, key, range, quantities)?.unwrap_or(default))
    };
    let standard = Constraints {
        snap: number("snap", METRES, &[Quantity::Snap, Quantity::Join], default.snap)?,
        duplicate: number("duplicate", METRES, &[Quantity::Duplicate], default.duplicate)?,
        least_length: number("least_length", METRES, &[Quantity::LeastLength], default.least_length)?,
        longest: number("longest", METRES, &[Quantity::Longest], default.longest)?,
        extend_most: number("extend_most", METRES, &[Quantity::ExtendMost], default.extend_most)?,
        bridge: number("bridge", METRES, &[Quantity::Bridge], default.bridge)?,
        turn_step,
        turn_most,
        least_angle: Angle::degrees(number("least_angle", TURN, &[Quantity::Angle], default.least_angle.to_degrees())?),
        extend: number("extend", FACTOR, &[Quantity::Extend], default.extend)?,
        prune: number("prune", SHARE, &[Quantity::Prune], default.prune)?,
        max_slope: number("max_slope", SLOPE, &[Quantity::Slope], default.max_slope)?,
    };
    Ok((standard, numbers))
}
