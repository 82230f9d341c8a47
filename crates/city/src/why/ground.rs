//! Rules, parameters and maps at a place.

use super::{Answer, MapSays, ParameterSays, RuleSays};
use crate::Sources;
use geom::{Id, Vec2};
use script::{Domain, Param, Rule, RuleKind, Value};

/// The maps of the site at a place, with the slope and the district.
pub fn maps_at(sources: &Sources, place: Vec2) -> Vec<MapSays> {
    let site = &sources.site;
    let say = |name: &str, value: String| MapSays { name: name.to_owned(), value };
    let mut said: Vec<MapSays> =
        site.maps.iter().map(|(name, map)| say(name, told(map.bilinear(place)) + unit_of(name))).collect();
    if let Some(map) = site.map("elevation") {
        said.push(say("slope", told(100.0 * map.gradient(place).length()) + " %"));
    }
    let district = site.districts.name_at(place);
    if !district.is_empty() {
        said.push(say("district", district.to_owned()));
    }
    said
}

/// The unit of a map that every city has one for.
fn unit_of(name: &str) -> &'static str {
    match name {
        "density" => " people per km²",
        "elevation" | "max_height" => " m",
        _ => "",
    }
}

/// A number without digits that say nothing.
fn told(number: f64) -> String {
    let rounded = if number.abs() >= 100.0 { number.round() } else { (number * 100.0).round() / 100.0 };
    format!("{rounded}")
}

/// The rules whose roles begin so, and their parameters, as they are at a place and in a quarter.
pub fn tell_rules(answer: &mut Answer, sources: &Sources, part: &str, quarter: Option<Id>) {
    let plan = sources.plan.in_quarter(quarter);
    let place = Vec2::from_array(answer.place);
    let roles = plan.roles();
    // Parcels and buildings may have a rule of the district's own in place of the city's.
    let of_district = format!("{part}.{}", sources.site.districts.name_at(place));
    let is_own = roles.iter().any(|(role, _)| *role == of_district);
    let is_meant = |role: &str| match part {
        "parcels" | "buildings" => role == if is_own { &of_district } else { part },
        _ => role.strip_prefix(part).is_some_and(|slot| slot.starts_with('.')),
    };
    for (role, rule) in roles {
        if !is_meant(&role) {
            continue;
        }
        answer.rules.push(says(&role, rule));
        for (param, value) in rule.params().iter() {
            answer.parameters.push(ParameterSays {
                address: format!("{role}.{}", param.name),
                value: with_unit(param, value.to_string()),
                here: value_at(sources, param, value, place),
                about: param.about.clone(),
            });
        }
    }
}

fn says(role: &str, rule: &Rule) -> RuleSays {
    let kind = kind_of(role).filter(|kind| rule.kinds().contains(kind)).or_else(|| rule.kinds().first().copied());
    RuleSays {
        role: role.to_owned(),
        name: rule.name().to_owned(),
        file: rule.path().to_owned(),
        line: kind.and_then(|kind| rule.line(kind)),
        function: kind.map_or_else(String::new, RuleKind::form),
    }
}

/// What the rule of a role decides.
fn kind_of(role: &str) -> Option<RuleKind> {
    let slot = role.split('.').nth(1).unwrap_or(role);
    match slot {
        "goals" => Some(RuleKind::Goals),
        "constraints" => Some(RuleKind::Constraints),
        "parcels" => Some(RuleKind::Parcels),
        "buildings" => Some(RuleKind::Buildings),
        _ => Some(RuleKind::Streets),
    }
}

fn with_unit(param: &Param, value: String) -> String {
    match &param.domain {
        Domain::Number { unit, .. } => value + unit.suffix(),
        _ => value,
    }
}

/// The value at a place, where it is not the same everywhere.
fn value_at(sources: &Sources, param: &Param, value: &Value, place: Vec2) -> Option<String> {
    match value {
        Value::Map(map) => {
            let at = sources.site.map(&map.map.name)?.bilinear(place);
            let fitted = (at * map.fit.scale + map.fit.offset).max(map.fit.low).min(map.fit.high);
            Some(with_unit(param, told(fitted)))
        }
        Value::District(values) => {
            let own = values.named.get(sources.site.districts.name_at(place)).unwrap_or(&values.other);
            value_at(sources, param, own, place).or_else(|| Some(with_unit(param, own.to_string())))
        }
        _ => None,
    }
}
