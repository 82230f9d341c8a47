//! Presets: rules with chosen values under a name, in files that people pick from (SCH10 §8.3).
//!
//! A file in `presets/` calls `preset(#{ … })` once. What it holds can be laid on a whole city, a class of streets, a
//! district or a quarter.

use crate::city::{STREETS, of_preset, street_plan};
use crate::fault::{Complaint, Fault};
use crate::host::Source;
use crate::names::{hint, nearest};
use crate::param::{DistrictValues, Literal, ParamError, ParamSet, Value};
use crate::pattern::PatternPlan;
use crate::plan::{GoalPlan, MINOR_WIDTH, Plan, StreetPlan};
use crate::rule::{Rule, Surroundings, headline};
use crate::testing::{SIDE, features_of, standard_site};
use crate::words::options::{Options, word};
use geom::{Digest, Id};
use rhai::{Dynamic, Map};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// The folder of a library that presets stand in.
pub(crate) const FOLDER: &str = "presets";

/// Rules with chosen values. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Preset(Arc<Contents>);

#[derive(Debug)]
struct Contents {
    name: String,
    path: String,
    about: String,
    /// Streets of a class, where it tells a pattern.
    streets: Option<StreetPlan>,
    parcels: Option<Rule>,
    buildings: Option<Rule>,
    /// The class of streets that it is made for.
    class: &'static str,
    /// What its picture shows.
    picture: Picture,
}

/// The place that a preset's picture shows.
#[derive(Clone, Debug)]
struct Picture {
    /// Features of a standard site.
    features: Vec<&'static str>,
    /// Its side in metres.
    side: f64,
}

/// What a preset is laid on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PresetTarget {
    /// Streets of the class that it is made for, minors if it does not say, parcels and buildings everywhere.
    City,
    /// The streets of a class: `highways`, `majors` or `minors`.
    Class(&'static str),
    /// Minors, parcels and buildings of a district.
    District(String),
    /// Those of a quarter.
    Quarter(Id),
}

/// What a preset says besides how its streets grow.
const OWN: [&str; 5] = ["parcels", "buildings", "class", "picture", "side"];

/// The classes of streets that presets can be laid on.
const CLASSES: [&str; 3] = ["highways", "majors", "minors"];

impl FromStr for PresetTarget {
    type Err = String;

    /// `city`, `minors`, `district:old town`, `quarter:` with an id.
    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(name) = text.strip_prefix("district:").filter(|name| !name.trim().is_empty()) {
            return Ok(Self::District(name.trim().to_owned()));
        }
        if let Some(id) = text.strip_prefix("quarter:") {
            let is_id = id.len() == 32 && id.bytes().all(|digit| digit.is_ascii_hexdigit());
            let id = id.parse().ok().filter(|_| is_id);
            return id.map(Self::Quarter).ok_or_else(|| {
                format!("`{text}` names no quarter: an id is 32 hexadecimal digits, as in layout.geojson")
            });
        }
        if text == "city" {
            return Ok(Self::City);
        }
        let class = CLASSES.into_iter().find(|class| *class == text);
        class.map(Self::Class).ok_or_else(|| {
            let near = nearest(text, CLASSES.into_iter().chain(["city"]));
            let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            format!(
                "`{text}` is nothing that a preset can be laid on: city, highways, majors, minors, district:NAME, \
                 quarter:ID{near}"
            )
        })
    }
}

impl fmt::Display for PresetTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::City => f.write_str("city"),
            Self::Class(class) => f.write_str(class),
            Self::District(name) => write!(f, "district:{name}"),
            Self::Quarter(id) => write!(f, "quarter:{id}"),
        }
    }
}

/// Whether a script of that name is a preset rather than a rule.
pub(crate) fn is_preset(name: &str) -> bool {
    name.strip_prefix(FOLDER).is_some_and(|rest| rest.starts_with('/'))
}

/// The full name of a preset: `presets/village` for `village`.
pub(crate) fn full_name(name: &str) -> String {
    if name.contains('/') { name.to_owned() } else { format!("{FOLDER}/{name}") }
}

impl Preset {
    /// All that it lays on a plan, for caches.
    pub(crate) fn digest(&self) -> Id {
        let Contents { name, path, about: _, streets, parcels, buildings, class, picture: _ } = &*self.0;
        let mut digest = Digest::new("preset");
        digest.value(&(name, path, streets.as_ref().map(StreetPlan::digest), parcels, buildings, class));
        digest.finish()
    }

    /// Reads a preset.
    ///
    /// # Errors
    /// All that is wrong in it and in the rules it names, what stopped it first: at least one fault.
    pub(crate) fn load(name: &str, source: &Source, around: &Surroundings) -> Result<Self, Vec<Fault>> {
        of_preset(source, around, |told| Self::of(name, &source.path, headline(&source.text), told))
    }

    /// What a preset may say.
    pub(crate) fn keys() -> impl Iterator<Item = &'static str> {
        OWN.iter().chain(STREETS).copied()
    }

    fn of(name: &str, path: &str, about: String, options: Map) -> Result<Self, Complaint> {
        let mut own = Map::new();
        let mut streets = Map::new();
        let known: Vec<&str> = Self::keys().collect();
        if let Some(key) = options.keys().find(|key| !known.contains(&key.as_str())) {
            let wrong = Complaint::new(format!("a preset has no `{key}`"));
            return Err(wrong.maybe_hint(hint(key, known.iter().copied())).key(key.as_str()));
        }
        for (key, value) in options {
            if OWN.contains(&key.as_str()) {
                own.insert(key, value)
            } else {
                streets.insert(key, value)
            };
        }
        let mut own = Options::new("preset", own, &OWN)?;
        let mut rule = |key: &str, kind| own.take(key).map(|value| crate::city::rule_of(value, key, kind)).transpose();
        let parcels = rule("parcels", crate::RuleKind::Parcels)?;
        let buildings = rule("buildings", crate::RuleKind::Buildings)?;
        let class = word(&mut own, "class", &CLASSES.map(|class| (class, class)))?.unwrap_or("minors");
        let features = own.take("picture").map_or(Ok(Vec::new()), |features| features_of(&features));
        let picture = Picture {
            features: features.map_err(|wrong| wrong.key("picture"))?,
            side: own.within("side", 100.0, 10_000.0, " m")?.unwrap_or(SIDE),
        };
        if streets.is_empty() && parcels.is_none() && buildings.is_none() {
            let help = "preset(#{ pattern: rule(\"streets/organic\", #{ length: 50 }), width: 9 })";
            return Err(Complaint::new("this preset holds nothing").hint(help));
        }
        let streets = if streets.is_empty() { None } else { Some(street_plan(streets)?) };
        Ok(Self(Arc::new(Contents {
            name: name.to_owned(),
            path: path.to_owned(),
            about,
            streets,
            parcels,
            buildings,
            class,
            picture,
        })))
    }

    /// What it is asked for by: `presets/village`.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The file, as messages call it.
    pub fn path(&self) -> &str {
        &self.0.path
    }

    /// Its first line of documentation.
    pub fn about(&self) -> &str {
        &self.0.about
    }

    /// How streets grow, where it says so.
    pub fn streets(&self) -> Option<&StreetPlan> {
        self.0.streets.as_ref()
    }

    /// The class of streets that it is made for: `highways`, `majors` or `minors`.
    pub fn class(&self) -> &'static str {
        self.0.class
    }

    /// A small city that shows it, on a standard site: what it says, and nothing else.
    pub fn shown(&self) -> Plan {
        let Picture { features, side } = &self.0.picture;
        let mut plan = Plan::on(standard_site(*side, features));
        self.lay_on(&mut plan);
        plan
    }

    /// Its rules with the roles they play: `pattern`, `goals`, `constraints`, `parcels`, `buildings`.
    pub fn rules(&self) -> Vec<(String, &Rule)> {
        let contents = &*self.0;
        let mut found = Vec::new();
        if let Some(streets) = &contents.streets {
            found.extend(streets.pattern.roles("pattern"));
            if let Some(GoalPlan::Rule(rule)) = &streets.goals {
                found.push(("goals".into(), rule));
            }
            found.extend(streets.constraints.iter().map(|rule| ("constraints".into(), rule)));
        }
        found.extend(contents.parcels.iter().map(|rule| ("parcels".into(), rule)));
        found.extend(contents.buildings.iter().map(|rule| ("buildings".into(), rule)));
        found
    }

    /// All that it says, a line each: how its streets grow, its rules, the values of their parameters.
    pub(crate) fn listed(&self) -> String {
        let mut lines = vec![format!("class = {}", self.0.class)];
        if let Some(streets) = &self.0.streets {
            let StreetPlan {
                goals,
                width,
                within,
                rim,
                seeds,
                reseed,
                sprout,
                smooth,
                least_dead_end,
                least_network,
                // Rules are told below; widths are those of a site.
                pattern: _,
                constraints: _,
                widths: _,
            } = streets;
            let told = |value: Option<String>| value.unwrap_or_else(|| "as usual".into());
            let fixed =
                goals.as_ref().and_then(|goals| if let GoalPlan::Fixed(goal) = goals { Some(goal) } else { None });
            lines.extend([
                format!("width = {}", told(width.as_ref().map(ToString::to_string))),
                format!("goal = {}", told(fixed.map(|goal| format!("{goal:?}")))),
                format!("within = {}", told(within.as_ref().map(|within| format!("{within:?}")))),
                format!("rim = {}", told(rim.map(|rim| format!("{} m, bulge {}", rim.width, rim.bulge)))),
                format!("seeds = {}", seeds.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")),
                format!("reseed = {}", told(reseed.map(|metres| format!("{metres} m")))),
                format!("sprout = {sprout}"),
                format!("smooth = {}", told(smooth.map(|is_smooth| is_smooth.to_string()))),
                format!("least_dead_end = {least_dead_end} m"),
                format!("least_network = {least_network} m"),
            ]);
            let parts = streets.pattern.parts().iter().filter(|_| streets.pattern.parts().len() > 1);
            lines.extend(parts.map(|part| format!("pattern.{} counts {:?}", part.name, part.weight)));
        }
        let Picture { features, side } = &self.0.picture;
        let features = if features.is_empty() { "bare land".into() } else { features.join(", ") };
        lines.push(format!("picture = {features} on {side} m"));
        for (role, rule) in self.rules() {
            lines.push(format!("{role} = {}", rule.name()));
            lines.extend(rule.params().iter().map(|(param, value)| format!("{role}.{} = {value}", param.name)));
        }
        lines.into_iter().map(|line| line.trim_end().to_owned() + "\n").collect()
    }

    /// The streets of a class with what the preset says in place of what was said before.
    fn on_streets(&self, before: Option<&StreetPlan>) -> Option<StreetPlan> {
        let own = self.0.streets.as_ref()?;
        let Some(before) = before else { return Some(own.clone()) };
        Some(StreetPlan {
            goals: own.goals.clone().or_else(|| before.goals.clone()),
            constraints: if own.constraints.is_empty() { before.constraints.clone() } else { own.constraints.clone() },
            width: own.width.clone().or_else(|| before.width.clone()),
            within: before.within.clone(),
            rim: before.rim,
            seeds: before.seeds.clone(),
            reseed: own.reseed.or(before.reseed),
            least_dead_end: own.least_dead_end.max(before.least_dead_end),
            least_network: own.least_network.max(before.least_network),
            ..own.clone()
        })
    }

    /// Says what it says of a whole plan.
    fn lay_on(&self, plan: &mut Plan) {
        let slot = plan.streets_mut(self.class());
        if let Some(streets) = self.on_streets(slot.as_ref()) {
            *slot = Some(streets);
        }
        if let Some(parcels) = &self.0.parcels {
            plan.parcels = Some(parcels.clone());
            plan.district_parcels.clear();
        }
        if let Some(buildings) = &self.0.buildings {
            plan.buildings = Some(buildings.clone());
            plan.district_buildings.clear();
        }
    }

    /// The same with each rule changed.
    pub(crate) fn map_rules(&self, change: impl Fn(&Rule) -> Rule) -> Self {
        let contents = &*self.0;
        let streets = contents.streets.as_ref().map(|streets| StreetPlan {
            pattern: streets.pattern.map_rules("pattern", |_, rule| change(rule)),
            constraints: streets.constraints.iter().map(&change).collect(),
            goals: streets.goals.as_ref().map(|goals| match goals {
                GoalPlan::Rule(rule) => GoalPlan::Rule(change(rule)),
                fixed => fixed.clone(),
            }),
            ..streets.clone()
        });
        Self(Arc::new(Contents {
            name: contents.name.clone(),
            path: contents.path.clone(),
            about: contents.about.clone(),
            streets,
            parcels: contents.parcels.as_ref().map(&change),
            buildings: contents.buildings.as_ref().map(&change),
            class: contents.class,
            picture: contents.picture.clone(),
        }))
    }
}

impl Plan {
    /// Lays a preset on something: what it says stands in place of what the plan said.
    ///
    /// # Errors
    /// [`ParamError`] where the preset says nothing of such a thing, or what it says cannot hold there alone.
    pub fn apply(&mut self, preset: &Preset, target: &PresetTarget) -> Result<(), ParamError> {
        match target {
            PresetTarget::City => preset.lay_on(self),
            PresetTarget::Class(class) => {
                let slot = self.streets_mut(class);
                let nothing = || ParamError {
                    message: format!("preset `{}` says nothing of streets", preset.name()),
                    hint: Some("its file has no `pattern`".into()),
                };
                *slot = Some(preset.on_streets(slot.as_ref()).ok_or_else(nothing)?);
            }
            PresetTarget::District(_) | PresetTarget::Quarter(_) if preset.class() != "minors" => {
                return Err(ParamError {
                    message: format!(
                        "preset `{}` is made for {}, which are the whole city's",
                        preset.name(),
                        preset.class()
                    ),
                    hint: Some(format!("lay it on all of them: {}={}", preset.class(), preset.name())),
                });
            }
            PresetTarget::District(name) => return self.apply_in_district(preset, name),
            PresetTarget::Quarter(id) => {
                self.quarters.entry(*id).or_default().preset = Some(preset.clone());
            }
        }
        Ok(())
    }

    /// How the streets of a class grow.
    fn streets_mut(&mut self, class: &str) -> &mut Option<StreetPlan> {
        match class {
            "highways" => &mut self.highways,
            "majors" => &mut self.majors,
            _ => &mut self.minors,
        }
    }

    /// Lays a preset on whatever the plan says nothing of.
    pub(crate) fn fill(&mut self, preset: &Preset) {
        let streets = self.streets_mut(preset.class());
        if streets.is_none() {
            *streets = preset.on_streets(None);
        }
        if self.parcels.is_none() && self.district_parcels.is_empty() {
            self.parcels = preset.0.parcels.clone();
        }
        if self.buildings.is_none() && self.district_buildings.is_empty() {
            self.buildings = preset.0.buildings.clone();
        }
    }

    fn apply_in_district(&mut self, preset: &Preset, district: &str) -> Result<(), ParamError> {
        if let Some(own) = preset.streets() {
            let missing = || ParamError {
                message: format!("preset `{}` cannot be laid on a district: the city has no minors", preset.name()),
                hint: Some("lay a preset on the whole city first, or write `minors: streets(#{ … })`".into()),
            };
            let minors = self.minors.as_mut().ok_or_else(missing)?;
            let named = BTreeMap::from([(district.to_owned(), own.pattern.clone())]);
            minors.pattern = PatternPlan::by_district(named, minors.pattern.clone());
            if let Some(width) = &own.width {
                let other = minors.width.clone().unwrap_or(Value::Constant(Literal::Number(MINOR_WIDTH)));
                minors.width = Some(in_district(other, district, width.clone()));
            }
            for rule in &own.constraints {
                merge_constraint(&mut minors.constraints, rule, district, preset)?;
            }
            if let Some(GoalPlan::Rule(rule)) = &own.goals {
                let Some(GoalPlan::Rule(known)) = &minors.goals else { return Err(not_alone(preset, "goals", rule)) };
                let merged = merged(known, rule, district).ok_or_else(|| not_alone(preset, "goals", rule))?;
                minors.goals = Some(GoalPlan::Rule(merged));
            }
        }
        let rules =
            [(&preset.0.parcels, &mut self.district_parcels), (&preset.0.buildings, &mut self.district_buildings)];
        for (rule, districts) in rules {
            if let Some(rule) = rule {
                districts.insert(district.to_owned(), rule.clone());
            }
        }
        Ok(())
    }
}

/// Takes what a preset's constraint says into those of a class, in one district.
fn merge_constraint(known: &mut Vec<Rule>, rule: &Rule, district: &str, preset: &Preset) -> Result<(), ParamError> {
    if known.is_empty() && rule.name() == "constraints/standard" {
        // Without any, streets keep to this rule as it stands.
        known.push(rule.with(ParamSet::new(rule.params().iter().map(|(param, _)| param.clone()).collect())));
    }
    for other in known {
        if let Some(merged) = merged(other, rule, district) {
            *other = merged;
            return Ok(());
        }
    }
    Err(not_alone(preset, "constraints", rule))
}

fn not_alone(preset: &Preset, slot: &str, rule: &Rule) -> ParamError {
    ParamError {
        message: format!(
            "preset `{}` cannot be laid on a district: its {slot} are of `{}`, those of the city are not",
            preset.name(),
            rule.name()
        ),
        hint: Some(format!(
            "let the city's minors have `{slot}: rule(\"{}\")`, too: numbers may differ by district",
            rule.name()
        )),
    }
}

/// A rule with the values of another of the same file in a district; `None` where the files differ.
fn merged(known: &Rule, own: &Rule, district: &str) -> Option<Rule> {
    if known.path() != own.path() {
        return None;
    }
    let mut params = known.params().clone();
    for (param, value) in own.params().iter() {
        let before = known.params().get(&param.name)?.clone();
        if before != *value {
            params = params.with_value(&param.name, in_district(before, district, value.clone())).ok()?;
        }
    }
    Some(known.with(params))
}

/// A value that is another in a district.
pub(crate) fn in_district(before: Value, district: &str, own: Value) -> Value {
    let mut values = match before {
        Value::District(values) => (*values).clone(),
        other => DistrictValues { named: BTreeMap::new(), other },
    };
    values.named.insert(district.to_owned(), own);
    Value::District(Arc::new(values))
}

/// A preset, or one for each district, as `preset: …` of a city takes them.
pub(crate) fn presets_of(value: Dynamic) -> Result<(Option<Preset>, BTreeMap<String, Preset>), Complaint> {
    let one = |value: Dynamic| {
        let given = crate::host::kind_of(&value);
        let wrong = || {
            Complaint::new(format!("`preset` must be preset(\"…\"), not {given}"))
                .hint("preset(\"village\")")
                .key("preset")
        };
        value.try_cast::<Preset>().ok_or_else(wrong)
    };
    let Some(presets) = value.read_lock::<crate::param::ByDistrict>().map(|presets| presets.clone()) else {
        return Ok((Some(one(value)?), BTreeMap::new()));
    };
    let named = presets.named.into_iter().map(|(name, preset)| Ok((name, one(preset)?)));
    Ok((presets.other.map(one).transpose()?, named.collect::<Result<_, Complaint>>()?))
}
