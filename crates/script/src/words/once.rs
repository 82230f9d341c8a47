//! What rules decide once for a whole city: `goals(p)`; see [`chain`](super::chain) for `constraints(p)`.

use super::options::Options;
use crate::fault::{Complaint, Fault, Refusal};
use crate::host::kind_of;
use crate::param::{Literal, Value};
use crate::plan::{DensityGoal, MapRef};
use crate::rule::{Rule, RuleKind};
use rhai::{Dynamic, Engine, FuncRegistration, Map};

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
    let help =
        "in a city script site.map(\"density\"); in a rule a parameter: params(#{ map: map(\"density\") }), then p.map";
    let map = map.ok_or_else(|| Complaint::new(format!("density takes a map, not {given}")).hint(help))?;
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

pub(super) fn complaint(rule: &Rule, kind: RuleKind, wrong: Complaint) -> Fault {
    let fault = Fault::new(rule.path(), format!("{}: {}", kind.form(), wrong.message)).with_hint(wrong.hint);
    rule.at_key(kind, wrong.key.as_deref(), fault)
}
