//! Streets of a city script: drawn, from files, grown.

use super::mix::pattern_of;
use super::within::{rim_of, within_of};
use crate::fault::{Complaint, Refusal};
use crate::host::{is_inside, kind_of};
use crate::names::hint;
use crate::param::{ByDistrict, Value};
use crate::plan::{
    DensityGoal, GivenLine, GoalPlan, MOST_CONSTRAINTS, StreetImport, StreetPlan, StreetUnits, WIDTHS, decides,
    width_param,
};
use crate::preset::presets_of;
use crate::rule::{Rule, RuleKind};
use crate::words::options::{Options, pair, text};
use geom::{Point, Vec2};
use rhai::{Array, Dynamic, Engine, FuncRegistration, ImmutableString, Map};
use std::collections::BTreeMap;
use streets::{Class, Classes};

pub(super) fn register(engine: &mut Engine) {
    engine
        .register_type_with_name::<GivenLine>("line(…)")
        .register_type_with_name::<StreetImport>("streets_from(…)")
        .register_type_with_name::<StreetPlan>("streets(…)")
        .register_type_with_name::<DensityGoal>("a goal");
    FuncRegistration::new("line")
        .with_params_info(["[[x, y], …]", "#{ class, width, name }"])
        .with_comments(["/// A street drawn through points, in metres."])
        .register_into_engine(engine, |points: Array, options: Map| Ok::<_, Refusal>(line(points, options)?));
    FuncRegistration::new("line")
        .with_params_info(["[[x, y], …]"])
        .register_into_engine(engine, |points: Array| Ok::<_, Refusal>(line(points, Map::new())?));
    FuncRegistration::new("streets_from")
        .with_params_info(["file", "#{ class, width, classes, widths, credit }"])
        .with_comments(["/// Streets from a .geojson, .osm or .osm.pbf file beside the script."])
        .register_into_engine(engine, |file: &str, options: Map| Ok::<_, Refusal>(import(file, options)?));
    FuncRegistration::new("streets_from")
        .with_params_info(["file"])
        .register_into_engine(engine, |file: &str| Ok::<_, Refusal>(import(file, Map::new())?));
    FuncRegistration::new("streets")
        .with_params_info([
            "#{ pattern, goals, constraints, width, within, rim, seeds, reseed, sprout, smooth, least_dead_end, \
             least_network }",
        ])
        .with_comments(["/// How streets of one class grow."])
        .register_into_engine(engine, |options: Map| Ok::<_, Refusal>(streets(options)?));
    FuncRegistration::new("density")
        .with_params_info(["map", "#{ least, full, pace, consume }"])
        .with_comments(["/// Streets where the map says so: none below `least`, later branches below `full`."])
        .register_into_engine(engine, |map: Dynamic, options: Map| {
            Ok::<_, Refusal>(crate::words::density(&map, options)?)
        });
    FuncRegistration::new("density")
        .with_params_info(["map"])
        .register_into_engine(engine, |map: Dynamic| Ok::<_, Refusal>(crate::words::density(&map, Map::new())?));
}

fn line(points: Array, options: Map) -> Result<GivenLine, Complaint> {
    let points: Vec<Vec2> = points.into_iter().map(on_lattice).collect::<Result<_, _>>()?;
    let differs = |pair: &[Vec2]| Point::from_metres(pair[0]) != Point::from_metres(pair[1]);
    if !points.windows(2).any(differs) {
        return Err(Complaint::new("a line needs two different points").hint("line([[0, 0], [100, 0]])"));
    }
    let mut options = Options::new("line", options, &["class", "width", "name"])?;
    let class = options.text("class")?.map_or(Ok(Classes::MAJOR), |name| class(&name, "class"))?;
    Ok(GivenLine { points, class, width: width(&mut options)?, name: options.text("name")? })
}

pub(super) fn on_lattice(point: Dynamic) -> Result<Vec2, Complaint> {
    let point = pair(point)?;
    let far = || Complaint::new("a point lies more than 500 km away");
    Point::try_from_metres(point).map(|_| point).ok_or_else(far)
}

fn width(options: &mut Options) -> Result<Option<f64>, Complaint> {
    options.within("width", WIDTHS.0, WIDTHS.1, " m")
}

/// A width, from a map or by district too.
pub(super) fn width_by_place(value: &Dynamic) -> Result<Value, Complaint> {
    if value.read_lock::<ByDistrict>().is_some_and(|values| values.other.is_none()) {
        let help = "by_district(#{ harbour: 20 }, 16): the last is the width on all other ground";
        return Err(Complaint::new("`width` by district needs a width for all other ground").hint(help).key("width"));
    }
    let param = width_param();
    let read = param.domain.read_value(value, &param.default);
    read.map_err(|(message, hint)| Complaint::new(format!("`width` {message}")).maybe_hint(hint).key("width"))
}

/// A street class by name.
pub(super) fn class(name: &str, key: &str) -> Result<Class, Complaint> {
    let classes = Classes::default();
    let unknown = || {
        let near = hint(name, classes.iter().map(|(_, info)| info.name.as_str()));
        Complaint::new(format!("there is no street class `{name}`")).maybe_hint(near).key(key)
    };
    classes.named(name).ok_or_else(unknown)
}

/// What files of streets are called.
const IMPORTABLE: [&str; 5] = [".geojson", ".json", ".osm", ".osm.pbf", ".pbf"];

fn import(file: &str, options: Map) -> Result<StreetImport, Complaint> {
    if !is_inside(file) {
        return Err(Complaint::new(format!("`{file}` is not a file below the script's folder")));
    }
    if !IMPORTABLE.iter().any(|ending| file.ends_with(ending)) {
        let help = "streets come from .geojson, .osm and .osm.pbf files";
        return Err(Complaint::new(format!("`{file}` is no file of streets")).hint(help));
    }
    let mut options =
        Options::new("streets_from", options, &["class", "width", "classes", "widths", "credit", "units"])?;
    let named = |(value, name): (_, Dynamic)| Ok((String::from(value), class(&text(name, "classes")?, "classes")?));
    let wide = |(value, metres): (_, Dynamic)| {
        let metres =
            crate::words::within("`widths`", &metres, WIDTHS.0, WIDTHS.1, " m").map_err(|c| c.key("widths"))?;
        Ok::<_, Complaint>((String::from(value), metres))
    };
    Ok(StreetImport {
        file: file.to_owned(),
        units: options.text("units")?.map(|units| street_units(file, &units)).transpose()?,
        class: options.text("class")?.map(|name| class(&name, "class")).transpose()?,
        width: width(&mut options)?,
        classes: options.map("classes")?.into_iter().map(named).collect::<Result<BTreeMap<_, _>, Complaint>>()?,
        credit: options.text("credit")?,
        widths: options.map("widths")?.into_iter().map(wide).collect::<Result<BTreeMap<_, _>, _>>()?,
    })
}

/// What the coordinates of a file count, as `units: "m"` says.
fn street_units(file: &str, units: &str) -> Result<StreetUnits, Complaint> {
    if !file.ends_with(".geojson") {
        let help = "leave it out: OpenStreetMap's own files are always in degrees";
        return Err(Complaint::new("`units` is for .geojson files").hint(help).key("units"));
    }
    match units {
        "m" => Ok(StreetUnits::Metres),
        "degrees" => Ok(StreetUnits::Degrees),
        other => {
            let help = "metres count from the south-west corner of the site, degrees are longitude and latitude";
            Err(Complaint::new(format!("`units` must be \"m\" or \"degrees\", not \"{other}\""))
                .hint(help)
                .key("units"))
        }
    }
}

/// Everything that `streets(…)` knows.
pub(crate) const STREETS: &[&str] = &[
    "pattern",
    "goals",
    "constraints",
    "width",
    "within",
    "rim",
    "seeds",
    "reseed",
    "sprout",
    "smooth",
    "least_dead_end",
    "least_network",
];

/// How far from every street further seeds may be asked for, metres.
const RESEED: (f64, f64) = (10.0, 100_000.0);
/// Longest dead end or loose network that may be asked to go, metres.
const LONGEST_NEEDLESS: f64 = 100_000.0;

/// `streets(#{ … })`.
pub(crate) fn streets(options: Map) -> Result<StreetPlan, Complaint> {
    let options = with_preset(options)?;
    let mut options = Options::new("streets", options, STREETS)?;
    let pattern = options.need("pattern")?;
    let plan = StreetPlan {
        pattern: pattern_of(pattern)?,
        goals: options.take("goals").map(goals).transpose()?,
        constraints: options.take("constraints").map_or(Ok(Vec::new()), constraints)?,
        width: options.take("width").map(|value| width_by_place(&value)).transpose()?,
        widths: None,
        within: options.take("within").map(within_of).transpose()?,
        rim: options.take("rim").map(rim_of).transpose()?,
        seeds: options
            .list("seeds")?
            .into_iter()
            .map(on_lattice)
            .collect::<Result<_, _>>()
            .map_err(|c| c.key("seeds"))?,
        reseed: options.within("reseed", RESEED.0, RESEED.1, " m")?,
        sprout: options.of("sprout", "true or false")?.unwrap_or(true),
        smooth: options.of("smooth", "true or false")?,
        least_dead_end: options.within("least_dead_end", 0.0, LONGEST_NEEDLESS, " m")?.unwrap_or(0.0),
        least_network: options.within("least_network", 0.0, LONGEST_NEEDLESS, " m")?.unwrap_or(0.0),
    };
    // What is told once is asked for here already: its faults are the script's.
    plan.goal().and_then(|_| plan.masks()).map_err(Complaint::of_rule)?;
    Ok(plan)
}

/// Options with those of the preset among them that are not given: `streets(#{ preset: preset("village"), width: 9 })`.
fn with_preset(mut options: Map) -> Result<Map, Complaint> {
    let Some(preset) = options.remove("preset") else { return Ok(options) };
    let (whole, named) = presets_of(preset)?;
    let one = whole.filter(|_| named.is_empty());
    let one = one.ok_or_else(|| {
        let help = "the city has a `preset` by district; streets of a class have one";
        Complaint::new("streets have one preset").hint(help).key("preset")
    })?;
    let nothing = || Complaint::new(format!("`{}` says nothing of streets", one.name())).key("preset");
    let own = one.streets().ok_or_else(nothing)?;
    let mut fill = |key: &str, value: Option<Dynamic>| {
        if let (false, Some(value)) = (options.contains_key(key), value) {
            options.insert(key.into(), value);
        }
    };
    fill("pattern", Some(Dynamic::from(own.pattern.clone())));
    fill(
        "goals",
        own.goals.clone().map(|goals| match goals {
            GoalPlan::Rule(rule) => Dynamic::from(rule),
            GoalPlan::Fixed(goal) => Dynamic::from(goal),
        }),
    );
    let constraints: Array = own.constraints.iter().cloned().map(Dynamic::from).collect();
    fill("constraints", (!constraints.is_empty()).then(|| constraints.into()));
    fill("width", own.constant_width().map(Dynamic::from));
    fill("smooth", own.smooth.map(Dynamic::from));
    fill("reseed", own.reseed.map(Dynamic::from));
    fill("least_dead_end", Some(own.least_dead_end.into()));
    fill("least_network", Some(own.least_network.into()));
    Ok(options)
}

/// A rule that tells what streets keep to, or a list of such rules.
fn constraints(value: Dynamic) -> Result<Vec<Rule>, Complaint> {
    let rules = if value.is_array() { value.into_array().unwrap_or_default() } else { vec![value] };
    if rules.len() > MOST_CONSTRAINTS {
        let message = format!("`constraints` takes at most {MOST_CONSTRAINTS} rules, not {}", rules.len());
        return Err(Complaint::new(message).key("constraints"));
    }
    rules.into_iter().map(constraint).collect()
}

/// A rule that tells a chain, or decides on single streets.
fn constraint(value: Dynamic) -> Result<Rule, Complaint> {
    let is_own = value.read_lock::<Rule>().is_some_and(|rule| rule.kinds().contains(&RuleKind::Constrain));
    rule_of(value, "constraints", if is_own { RuleKind::Constrain } else { RuleKind::Constraints })
}

fn goals(value: Dynamic) -> Result<GoalPlan, Complaint> {
    if value.is::<Rule>() {
        return rule_of(value, "goals", RuleKind::Goals).map(GoalPlan::Rule);
    }
    let given = kind_of(&value);
    let wrong = || Complaint::new(format!("`goals` must be density(…) or a rule, not {given}")).key("goals");
    value.try_cast().map(GoalPlan::Fixed).ok_or_else(wrong)
}

/// Rules that decide what a role needs: one everywhere, or one for each district.
pub(super) fn rules_of(
    value: Dynamic,
    key: &str,
    kind: RuleKind,
) -> Result<(Option<Rule>, BTreeMap<String, Rule>), Complaint> {
    let Some(rules) = value.read_lock::<ByDistrict>().map(|rules| rules.clone()) else {
        return Ok((Some(rule_of(value, key, kind)?), BTreeMap::new()));
    };
    let named = rules.named.into_iter().map(|(name, rule)| Ok((name, rule_of(rule, key, kind)?)));
    Ok((rules.other.map(|rule| rule_of(rule, key, kind)).transpose()?, named.collect::<Result<_, Complaint>>()?))
}

/// A rule that decides what a role needs.
pub(crate) fn rule_of(value: Dynamic, key: &str, kind: RuleKind) -> Result<Rule, Complaint> {
    let given = kind_of(&value);
    let named = value.read_lock::<ImmutableString>().map(|name| format!("write rule(\"{}\")", *name));
    let help = named.unwrap_or_else(|| "write rule(\"folder/name\")".into());
    let wrong = || Complaint::new(format!("`{key}` must be rule(\"…\"), not {given}")).hint(help).key(key);
    let rule: Rule = value.try_cast().ok_or_else(wrong)?;
    decides(&rule, kind).map_err(|(message, help)| Complaint::new(message).maybe_hint(help).key(key))?;
    Ok(rule)
}
