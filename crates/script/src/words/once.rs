//! What rules decide once for a whole city: `constraints(p)` and `goals(p)`.

use super::options::Options;
use crate::fault::{Complaint, Fault, Refusal};
use crate::host::kind_of;
use crate::param::{Literal, Value};
use crate::plan::{DensityGoal, MapRef};
use crate::rule::{Rule, RuleKind};
use geom::Angle;
use rhai::{Dynamic, Engine, FuncRegistration, Map};
use streets::growth::Constraints;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<DensityGoal>("a goal");
    FuncRegistration::new("density")
        .with_params_info(["map", "#{ least, full, pace, consume }"])
        .with_comments(["/// Streets where the map says so: none below `least`, later branches below `full`, fewer as streets `consume`."])
        .register_into_engine(engine, |map: Dynamic, options: Map| Ok::<_, Refusal>(density(&map, options)?));
    FuncRegistration::new("density")
        .with_params_info(["map"])
        .register_into_engine(engine, |map: Dynamic| Ok::<_, Refusal>(density(&map, Map::new())?));
}

/// `density(map, #{ least, full, pace, consume })`.
pub(crate) fn density(map: &Dynamic, options: Map) -> Result<DensityGoal, Complaint> {
    let given = kind_of(map);
    let map = map.clone().try_cast::<MapRef>();
    let map = map.ok_or_else(|| Complaint::new(format!("density takes a map, site.map(\"…\"), not {given}")))?;
    let mut options = Options::new("density", options, &["least", "full", "pace", "consume"])?;
    Ok(DensityGoal {
        map,
        least: options.by_place("least", f64::NEG_INFINITY, f64::INFINITY)?.unwrap_or_else(nothing),
        full: options.by_place("full", f64::NEG_INFINITY, f64::INFINITY)?,
        pace: options.by_place("pace", 0.0, 1e6)?.unwrap_or_else(nothing),
        consume: options.within("consume", 0.0, 1e9, " people per km")?.unwrap_or(0.0),
    })
}

fn nothing() -> Value {
    Literal::Number(0.0).into()
}

/// The goal that a rule tells.
pub(crate) fn goal_of(rule: &Rule) -> Result<DensityGoal, Fault> {
    let value = rule.evaluate(RuleKind::Goals)?;
    let given = kind_of(&value);
    let wrong = || {
        complaint(
            rule,
            RuleKind::Goals,
            Complaint::new(format!("returns {given}")).hint("return density(p.map, #{ … })"),
        )
    };
    value.try_cast().ok_or_else(wrong)
}

/// The constraints that a rule tells: a map with the fields of [`Constraints`]; what it leaves out keeps its default.
pub(crate) fn constraints_of(rule: &Rule) -> Result<Constraints, Fault> {
    let value = rule.evaluate(RuleKind::Constraints)?;
    let given = kind_of(&value);
    let map = value.try_cast::<Map>();
    let map = map.ok_or_else(|| Complaint::new(format!("returns {given}")).hint("return #{ snap: p.snap, … }"));
    map.and_then(constraints).map_err(|wrong| complaint(rule, RuleKind::Constraints, wrong))
}

fn complaint(rule: &Rule, kind: RuleKind, wrong: Complaint) -> Fault {
    Fault::new(rule.path(), format!("{}: {}", kind.form(), wrong.message)).with_hint(wrong.hint)
}

/// Every field that a rule may set.
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

fn constraints(map: Map) -> Result<Constraints, Complaint> {
    let mut options = Options::new("constraints", map, &FIELDS)?;
    let default = Constraints::default();
    let mut metres =
        |key: &str, default: f64| Ok::<_, Complaint>(options.within(key, 0.0, 10_000.0, " m")?.unwrap_or(default));
    let (snap, duplicate) = (metres("snap", default.snap)?, metres("duplicate", default.duplicate)?);
    let (least_length, longest) = (metres("least_length", default.least_length)?, metres("longest", default.longest)?);
    let (extend_most, bridge) = (metres("extend_most", default.extend_most)?, metres("bridge", default.bridge)?);
    let mut degrees = |key: &str, low: f64, default: Angle| {
        Ok::<_, Complaint>(options.within(key, low, 180.0, "°")?.map_or(default, Angle::degrees))
    };
    Ok(Constraints {
        snap,
        duplicate,
        least_length,
        longest,
        extend_most,
        bridge,
        least_angle: degrees("least_angle", 0.0, default.least_angle)?,
        // A step of nothing would search without an end.
        turn_step: degrees("turn_step", 0.1, default.turn_step)?,
        turn_most: degrees("turn_most", 0.0, default.turn_most)?,
        extend: options.within("extend", 1.0, 100.0, "")?.unwrap_or(default.extend),
        prune: options.within("prune", 0.0, 1.0, "")?.unwrap_or(default.prune),
        max_slope: options.within("max_slope", 0.0, 100.0, "")?.unwrap_or(default.max_slope),
    })
}
