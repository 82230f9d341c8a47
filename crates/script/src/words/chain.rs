//! What streets keep to: `constraints(p)` answers with a chain of named steps, or a map of the standard chain's values.

use super::once::complaint;
use super::options::{Options, pair};
use super::within;
use crate::fault::{Complaint, Fault, Refusal};
use crate::host::kind_of;
use crate::plan::MapRef;
use crate::rule::{Rule, RuleKind};
use geom::{Angle, Point, Polygon};
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map};
use std::collections::BTreeSet;
use std::sync::Arc;
use streets::growth::{
    Area, BRIDGE_SPACING, Bridge, Chain, Constraints, Duplicate, Extend, Legal, Length, MOST_STEPS, Over, Own, Slope,
    Step, TurnSearch,
};

/// Longest length that a constraint may name, in metres.
const FARTHEST: f64 = 10_000.0;

/// A step as a rule names it.
#[derive(Clone, Debug)]
enum Link {
    /// One of the kernel's.
    Native(&'static str, Step),
    /// The rule's own `constrain(segment, p)`.
    Own,
}

impl Link {
    fn name(&self) -> &'static str {
        match self {
            Self::Native(name, _) => name,
            Self::Own => "own",
        }
    }

    /// Whether a chain may hold several.
    fn repeats(&self) -> bool {
        matches!(self, Self::Native(_, Step::Mask(_)))
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
        .register_into_engine(engine, || Link::Native("crossing", Step::Crossing));
    let one = |engine: &mut Engine,
               name: &'static str,
               doc: &'static str,
               argument: &'static str,
               make: fn(&Dynamic) -> Result<Step, Complaint>| {
        FuncRegistration::new(name)
            .with_params_info([argument])
            .with_comments([doc])
            .register_into_engine(engine, move |value: Dynamic| -> Told { Ok(Link::Native(name, make(&value)?)) });
    };
    one(
        engine,
        "snap",
        "/// A street that ends, or passes a crossing, closer than this goes to it.",
        "metres",
        |value| Ok(Step::Snap(metres("the snapping distance", value)?)),
    );
    one(engine, "join", "/// A street that ends beside another, closer than this, goes to it.", "metres", |value| {
        Ok(Step::Join(metres("the joining distance", value)?))
    });
    FuncRegistration::new("duplicate")
        .with_params_info(["metres"])
        .with_comments(["/// Near-parallel streets closer than this are one too many."])
        .register_into_engine(engine, |within: Dynamic| -> Told { Ok(duplicate(&within, Map::new())?) });
    FuncRegistration::new("duplicate")
        .with_params_info(["metres", "#{ whole }"])
        .register_into_engine(engine, |within: Dynamic, options: Map| -> Told { Ok(duplicate(&within, options)?) });
    one(engine, "angle", "/// Least angle between streets at a crossing.", "degrees", |value| {
        Ok(Step::Angle(Angle::degrees(within("the least angle", value, 0.0, 180.0, "°")?)))
    });
    one(engine, "arms", "/// Most streets that meet in a crossing.", "count", |value| {
        Ok(Step::Arms(within("the most streets of a crossing", value, 2.0, 100.0, "")? as u32))
    });
    FuncRegistration::new("extend")
        .with_params_info(["factor", "most"])
        .with_comments([
            "/// A street goes on to one it would meet within this multiple of its length, by `most` metres.",
        ])
        .register_into_engine(engine, |factor: Dynamic, most: Dynamic| -> Told { Ok(extend(&factor, &most)?) });
}

fn metres(what: &str, value: &Dynamic) -> Result<f64, Complaint> {
    within(what, value, 0.0, FARTHEST, " m")
}

fn length(least: &Dynamic, longest: &Dynamic) -> Result<Link, Complaint> {
    let (least, longest) = (metres("the least length", least)?, metres("the longest length", longest)?);
    if least > longest {
        return Err(Complaint::new(format!("the least length ({least} m) is greater than the longest ({longest} m)")));
    }
    Ok(Link::Native("length", Step::Length(Length { least, longest })))
}

fn extend(factor: &Dynamic, most: &Dynamic) -> Result<Link, Complaint> {
    let factor = within("the multiple of the length", factor, 1.0, 100.0, "")?;
    Ok(Link::Native("extend", Step::Extend(Extend { factor, most: metres("the longest extension", most)? })))
}

fn duplicate(within: &Dynamic, options: Map) -> Result<Link, Complaint> {
    let mut options = Options::new("duplicate", options, &["whole"])?;
    let within = metres("the distance of duplicates", within)?;
    let is_whole = options.flag("whole")?.unwrap_or(false);
    Ok(Link::Native("duplicate", Step::Duplicate(Duplicate { within, is_whole })))
}

fn turns(options: &mut Options) -> Result<TurnSearch, Complaint> {
    let default = Constraints::default();
    Ok(TurnSearch {
        // A step of nothing would search without an end.
        step: options.within("turn_step", 0.1, 180.0, "°")?.map_or(default.turn_step, Angle::degrees),
        most: options.within("turn_most", 0.0, 180.0, "°")?.map_or(default.turn_most, Angle::degrees),
    })
}

fn legal(options: Map) -> Result<Link, Complaint> {
    let known =
        ["prune", "turn_step", "turn_most", "turn_first", "bridge", "bridge_spacing", "bridge_over", "bridge_first"];
    let mut options = Options::new("legal", options, &known)?;
    let longest = options.within("bridge", 0.0, FARTHEST, " m")?.unwrap_or(0.0);
    let bridge = Bridge {
        longest,
        spacing: options.within("bridge_spacing", 0.0, FARTHEST, " m")?.unwrap_or(BRIDGE_SPACING),
        over: over(&mut options)?,
        is_first: options.flag("bridge_first")?.unwrap_or(false),
    };
    let legal = Legal {
        prune: options.within("prune", 0.0, 1.0, "")?.unwrap_or(Constraints::default().prune),
        turns: turns(&mut options)?,
        turns_first: options.flag("turn_first")?.unwrap_or(false),
        bridge: (longest > 0.0).then_some(bridge),
    };
    Ok(Link::Native("legal", Step::Legal(legal)))
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
    let most = within("the steepest slope", most, 0.0, 100.0, "").map_err(|wrong| {
        let hint = wrong.hint.clone().unwrap_or_else(|| "rise over run: 0.12 is 12 %".into());
        wrong.hint(hint)
    })?;
    let mut options = Options::new("slope", options, &["turn_step", "turn_most", "hairpin", "tunnel"])?;
    let slope = Slope {
        most,
        turns: turns(&mut options)?,
        has_hairpins: options.flag("hairpin")?.unwrap_or(false),
        tunnel: options.within("tunnel", 0.0, FARTHEST, " m")?.unwrap_or(0.0),
    };
    Ok(Link::Native("slope", Step::Slope(slope)))
}

fn mask(area: Dynamic) -> Result<Link, Complaint> {
    let given = kind_of(&area);
    let native = |area| Ok(Link::Native("mask", Step::Mask(area)));
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
        let standard = Chain::from(standard(value.cast::<Map>())?);
        return Ok(standard.steps().iter().map(|step| Link::Native("", step.clone())).collect());
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
/// where `own()` says, else behind the steps of their file. Without a chain they follow the standard one.
pub(crate) fn chain_of(rules: &[Rule], standard: Chain, own: &dyn Fn(&Rule) -> Own) -> Result<Chain, Fault> {
    let has = |rule: &&Rule, kind| rule.kinds().contains(&kind);
    let mut chains = rules.iter().filter(|rule| has(rule, RuleKind::Constraints));
    let (first, second) = (chains.next(), chains.next());
    if let (Some(first), Some(second)) = (first, second) {
        let message = format!("`{}` tells a chain, and so does `{}`", second.name(), first.name());
        return Err(Fault::new(second.path(), message)
            .with_hint(Some("of several rules one may have `fn constraints(p)`".into())));
    }
    let mut steps = if first.is_none() { standard.steps().to_vec() } else { Vec::new() };
    for rule in rules {
        let links = if has(&rule, RuleKind::Constraints) { links_of(rule)? } else { Vec::new() };
        let is_placed = links.iter().any(|link| matches!(link, Link::Own));
        steps.extend(links.into_iter().map(|link| match link {
            Link::Native(_, step) => step,
            Link::Own => Step::Own(own(rule)),
        }));
        if !is_placed && has(&rule, RuleKind::Constrain) {
            steps.push(Step::Own(own(rule)));
        }
    }
    if steps.len() > MOST_STEPS {
        let message = format!("these constraints are {} steps together; at most {MOST_STEPS} are kept to", steps.len());
        return Err(Fault::new(rules.last().map_or("", Rule::path), message));
    }
    Ok(Chain::new(steps))
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
fn standard(map: Map) -> Result<Constraints, Complaint> {
    let mut options = Options::new("constraints", map, &FIELDS)?;
    let default = Constraints::default();
    let mut metres =
        |key: &str, default: f64| Ok::<_, Complaint>(options.within(key, 0.0, FARTHEST, " m")?.unwrap_or(default));
    let (snap, duplicate) = (metres("snap", default.snap)?, metres("duplicate", default.duplicate)?);
    let (least_length, longest) = (metres("least_length", default.least_length)?, metres("longest", default.longest)?);
    let (extend_most, bridge) = (metres("extend_most", default.extend_most)?, metres("bridge", default.bridge)?);
    let TurnSearch { step: turn_step, most: turn_most } = turns(&mut options)?;
    Ok(Constraints {
        snap,
        duplicate,
        least_length,
        longest,
        extend_most,
        bridge,
        turn_step,
        turn_most,
        least_angle: options.within("least_angle", 0.0, 180.0, "°")?.map_or(default.least_angle, Angle::degrees),
        extend: options.within("extend", 1.0, 100.0, "")?.unwrap_or(default.extend),
        prune: options.within("prune", 0.0, 1.0, "")?.unwrap_or(default.prune),
        max_slope: options.within("max_slope", 0.0, 100.0, "")?.unwrap_or(default.max_slope),
    })
}
