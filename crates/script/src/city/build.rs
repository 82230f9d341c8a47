//! From the options of `city(#{ … })` to a plan.

use super::landmarks::check_landmarks;
use super::site::site_of;
use super::streets::rules_of;
use crate::fault::Complaint;
use crate::host::kind_of;
use crate::param::{Literal, Value};
use crate::plan::{Landmark, MapRef, Plan, QuarterPlan, SitePlan, StreetPlan, no_arterials};
use crate::preset::{Preset, PresetTarget, presets_of};
use crate::rule::RuleKind;
use crate::words::options::{Options, cast};
use geom::Id;
use rhai::{Dynamic, Map};
use std::collections::BTreeMap;
use streets::StreetId;

/// Everything that `city(…)` knows.
pub(super) const KEYS: &[&str] = &[
    "name",
    "site",
    "districts",
    "within",
    "barred",
    "seed",
    "landmarks",
    "given",
    "imported",
    "highways",
    "majors",
    "minors",
    "parcels",
    "buildings",
    "preset",
    "quarters",
    "remove",
];

/// The plan of a city script.
pub(crate) fn plan(map: Map) -> Result<Plan, Complaint> {
    let mut options = Options::new("city", map, KEYS)?;
    let site = site(&mut options)?;
    let mut rules = |key: &str, kind: RuleKind| {
        options.take(key).map_or(Ok(Default::default()), |value| rules_of(value, key, kind))
    };
    let (parcels, district_parcels) = rules("parcels", RuleKind::Parcels)?;
    let (buildings, district_buildings) = rules("buildings", RuleKind::Buildings)?;
    let mut plan = Plan {
        name: options.text("name")?,
        within: options.of::<MapRef>("within", "a map, site.map(\"…\")")?,
        barred: maps(&mut options)?,
        districts: options.of("districts", "site.districts(…) or districts_from(…)")?,
        seed: options.seed()?.unwrap_or(0),
        landmarks: landmarks(&mut options)?,
        given: each(options.list("given")?, "given", "a list of line(…)")?,
        imports: imported(&mut options)?,
        highways: options.of::<StreetPlan>("highways", "streets(…)")?,
        majors: options.of::<StreetPlan>("majors", "streets(…)")?,
        minors: options.of::<StreetPlan>("minors", "streets(…)")?,
        parcels,
        buildings,
        district_parcels,
        district_buildings,
        removed: removed(&mut options)?,
        ..Plan::on(site)
    };
    if let Some(preset) = options.take("preset") {
        lay(presets_of(preset)?, &mut plan)?;
    }
    check_stages(&plan)?;
    plan.quarters = quarters(options.map("quarters")?, &plan)?;
    plan.check_districts().map_err(|error| Complaint::new(error.message).maybe_hint(error.hint).key("districts"))?;
    Ok(plan)
}

/// Lays presets on a plan: one on whatever the script says nothing of, others on districts.
fn lay((whole, named): (Option<Preset>, BTreeMap<String, Preset>), plan: &mut Plan) -> Result<(), Complaint> {
    if let Some(preset) = &whole {
        plan.fill(preset);
    }
    for (district, preset) in named {
        let laid = plan.apply(&preset, &PresetTarget::District(district));
        laid.map_err(|error| Complaint::new(error.message).maybe_hint(error.hint).key("preset"))?;
    }
    Ok(())
}

/// The site; imported streets say where they lie, so that a city of them needs none.
fn site(options: &mut Options) -> Result<SitePlan, Complaint> {
    match options.take("site") {
        Some(site) => site_of(&site),
        None if options.has("imported") => Ok(SitePlan::default()),
        None => site_of(&options.need("site")?),
    }
}

/// One value of a kind, or a list of them.
fn one_or_many(value: Option<Dynamic>) -> Vec<Dynamic> {
    match value {
        None => Vec::new(),
        Some(value) if value.is_array() => value.into_array().unwrap_or_default(),
        Some(value) => vec![value],
    }
}

fn each<T: rhai::Variant + Clone>(values: Vec<Dynamic>, key: &str, kind: &str) -> Result<Vec<T>, Complaint> {
    values.into_iter().map(|value| cast(value, key, kind)).collect()
}

fn maps(options: &mut Options) -> Result<Vec<MapRef>, Complaint> {
    each(one_or_many(options.take("barred")), "barred", "a map or a list of maps")
}

/// Landmarks one by one or by the list; lists may stand in lists, as files give them.
fn landmarks(options: &mut Options) -> Result<Vec<Landmark>, Complaint> {
    let mut found = Vec::new();
    for value in one_or_many(options.take("landmarks")) {
        found.extend(each(one_or_many(Some(value)), "landmarks", "a landmark(#{ … }) or a list of them")?);
    }
    check_landmarks(&found).map_err(|wrong| wrong.key("landmarks"))?;
    Ok(found)
}

/// Names what only minors, or only highways and majors, may be asked for.
fn check_stages(plan: &Plan) -> Result<(), Complaint> {
    if plan.minors.as_ref().is_some_and(|minors| !minors.seeds.is_empty()) {
        let message =
            "`seeds` of `minors` would do nothing: they start in the middle of each quarter, and along given streets";
        let help = "`seeds` is for highways and majors; a line(…) that is given says where minors begin";
        return Err(Complaint::new(message).hint(help).key("minors"));
    }
    for (streets, class) in [(&plan.highways, "highways"), (&plan.majors, "majors")] {
        let Some(streets) = streets else { continue };
        if streets.within.as_ref().is_some_and(crate::plan::Within::chooses_quarters) {
            let message = format!("`{class}` cannot keep to quarters: highways and majors are what makes them");
            let help = "choose quarters for `minors`; here a map or polygon([…]) serves";
            return Err(Complaint::new(message).hint(help).key(class));
        }
        if streets.rim.is_some() {
            let message = format!("`{class}` have no rim: it lies around them");
            return Err(Complaint::new(message).hint("`rim` is for `minors`").key(class));
        }
    }
    Ok(())
}

fn imported<T: rhai::Variant + Clone>(options: &mut Options) -> Result<Vec<T>, Complaint> {
    each(one_or_many(options.take("imported")), "imported", "streets_from(…) or a list of them")
}

fn removed(options: &mut Options) -> Result<Vec<StreetId>, Complaint> {
    let texts: Vec<rhai::ImmutableString> = each(options.list("remove")?, "remove", "a list of street ids")?;
    texts.iter().map(|text| id(text, "remove").map(StreetId)).collect()
}

/// An identity as files write it: 32 hexadecimal digits.
fn id(text: &str, key: &str) -> Result<Id, Complaint> {
    let whole = text.len() == 32 && text.bytes().all(|digit| digit.is_ascii_hexdigit());
    let wrong = || {
        let message = format!("`{text}` is no id");
        Complaint::new(message).hint("an id is 32 hexadecimal digits, as in layout.geojson").key(key)
    };
    if whole { text.parse().map_err(|_| wrong()) } else { Err(wrong()) }
}

fn quarters(map: Map, plan: &Plan) -> Result<BTreeMap<Id, QuarterPlan>, Complaint> {
    map.into_iter().map(|(name, value)| Ok((id(&name, "quarters")?, quarter(value, plan)?))).collect()
}

/// `#{ seed: 7, block_width: 90, "parcels.least_area": 200 }`: a bare name is a parameter of the minors' pattern.
fn quarter(value: Dynamic, plan: &Plan) -> Result<QuarterPlan, Complaint> {
    let given = kind_of(&value);
    let wrong = || Complaint::new(format!("a quarter is told by a map #{{ … }}, not {given}")).key("quarters");
    let mut map: Map = value.try_cast().ok_or_else(wrong)?;
    let seed = map.remove("seed").map(|seed| Map::from([("seed".into(), seed)]));
    let seed = seed.map(|map| Options::new("a quarter", map, &["seed"])?.seed()).transpose()?.flatten();
    let width = map.remove("minors.width").map(|value| width(&value)).transpose()?;
    let preset = map.remove("preset").map(presets_of).transpose()?;
    let preset = match preset {
        Some((Some(preset), named)) if named.is_empty() && preset.class() == "minors" => Some(preset),
        Some(_) => {
            return Err(Complaint::new("a quarter has one preset, made for minors")
                .hint("preset: preset(\"village\")")
                .key("preset"));
        }
        None => None,
    };
    let set = map.into_iter().map(|(name, value)| setting(&name, &value, plan)).collect::<Result<_, _>>()?;
    Ok(QuarterPlan { seed, set, width, preset })
}

/// How wide the minors of a quarter are.
fn width(value: &Dynamic) -> Result<f64, Complaint> {
    match super::streets::width_by_place(value).map_err(|complaint| complaint.key("quarters"))?.constant() {
        Some(Literal::Number(width)) => Ok(*width),
        _ => {
            let help = "a quarter has one width; `width` of `minors` takes a map or by_district(…)";
            Err(Complaint::new("`minors.width` of a quarter must be a number").hint(help).key("quarters"))
        }
    }
}

fn setting(name: &str, value: &Dynamic, plan: &Plan) -> Result<(String, Value), Complaint> {
    let address = if name.contains('.') { name.to_owned() } else { bare_address(name, plan)? };
    let complain = |error: crate::ParamError| Complaint::new(error.message).maybe_hint(error.hint).key("quarters");
    let (role, name) = plan.address(&address).map_err(complain)?;
    no_arterials(&role).map_err(complain)?;
    let rule = plan.rule_of(&role).ok_or_else(|| Complaint::new(format!("nothing plays the role {role}")))?;
    let params = rule.params().with_dynamic(&name, value).map_err(complain)?;
    let value = params.get(&name).cloned();
    let value = value.ok_or_else(|| Complaint::new(format!("there is no parameter `{name}`")))?;
    Ok((address, value))
}

/// The address of a parameter of the minors' pattern; of several patterns that of the one that has it.
fn bare_address(name: &str, plan: &Plan) -> Result<String, Complaint> {
    let patterns = plan.minors.iter().flat_map(|minors| minors.pattern.roles("minors.pattern"));
    let having: Vec<String> = patterns
        .filter(|(_, rule)| rule.params().get(name).is_some())
        .map(|(role, _)| format!("{role}.{name}"))
        .collect();
    match having.as_slice() {
        [] => Ok(format!("minors.pattern.{name}")),
        [one] => Ok(one.clone()),
        several => {
            let message = format!("several patterns of the minors have a parameter `{name}`");
            let quoted: Vec<String> = several.iter().map(|address| format!("\"{address}\"")).collect();
            Err(Complaint::new(message).hint(format!("write {}", quoted.join(" or "))).key("quarters"))
        }
    }
}
