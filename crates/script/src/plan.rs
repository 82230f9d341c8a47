//! What a city script asks for, as plain data: the input of every stage.

use crate::fault::{Fault, Faults};
use crate::param::{Literal, Misfit, Param, ParamError, Places, Unit, Value, unknown_district};
use crate::pattern::PatternPlan;
use crate::preset::{Preset, PresetTarget, in_district};
use crate::rule::{Note, Rule, RuleKind};
use crate::words::{ConstraintPattern, Marked};
use geom::{Cells, Id, Point, Polygon, Raster, Vec2};
use layout::Use;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::growth::{Area, Chain, Field, Own, Step};
use streets::{Class, Classes, StreetId};

/// A map of the site, by name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MapRef {
    /// Its name, e.g. `density`: a file name without extension.
    pub name: String,
}

/// The place a city is to stand on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SitePlan {
    /// The folder of maps, relative to the city's own; none for a flat site without maps.
    pub folder: Option<String>,
    /// Width and height in metres, where the script says so.
    pub size: Option<Vec2>,
    /// What the script says about maps that have no sidecar, or instead of it.
    pub maps: BTreeMap<String, MapOptions>,
    /// Maps that the script draws itself, by name.
    pub drawn: BTreeMap<String, Arc<Raster>>,
    /// Districts that it draws itself.
    pub drawn_districts: Option<DrawnDistricts>,
}

/// Districts that a script draws: cells labelled with positions in the list of names.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnDistricts {
    /// In alphabetical order.
    pub names: Vec<String>,
    /// The ground.
    pub cells: Cells,
}

/// What a script says about a map: the fields of a sidecar; each stands above the sidecar's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapOptions {
    /// Width and height in metres.
    pub size: Option<Vec2>,
    /// Metres per pixel.
    pub pixel_size: Option<f64>,
    /// value = pixel × scale + offset.
    pub scale: Option<f64>,
    /// value = pixel × scale + offset.
    pub offset: Option<f64>,
    /// `mask` reads as 0 or 1.
    pub units: Option<String>,
}

/// Where the districts of a site are told.
#[derive(Clone, Debug, PartialEq)]
pub enum DistrictPlan {
    /// In a colour map of the site: each district has a colour.
    Map {
        /// The map.
        map: MapRef,
        /// Colours by name; [`NO_DISTRICT`] is no district. When empty, the map's sidecar tells them.
        legend: BTreeMap<String, [u8; 3]>,
    },
    /// In a GeoJSON file relative to the city's folder: polygons with a `name`.
    File(String),
}

/// The name under which a legend lists the colour of ground that belongs to no district.
pub const NO_DISTRICT: &str = "none";

impl DistrictPlan {
    /// The names that the script itself tells, in alphabetical order.
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Map { legend, .. } => legend.keys().map(String::as_str).filter(|name| *name != NO_DISTRICT).collect(),
            Self::File(_) => Vec::new(),
        }
    }
}

/// Where streets of one class grow.
#[derive(Clone, Debug, PartialEq)]
pub enum Within {
    /// Where a map of the site says more than one half.
    Map(MapRef),
    /// Inside a polygon.
    Polygon(Arc<Polygon>),
    /// In the quarters that contain one of these places, in metres.
    QuartersAt(Vec<Vec2>),
    /// In the quarters whose middle lies in one of these districts.
    QuartersIn(Vec<String>),
}

impl Within {
    /// Whether it chooses quarters, which are there only when highways and majors have grown.
    pub fn chooses_quarters(&self) -> bool {
        matches!(self, Self::QuartersAt(_) | Self::QuartersIn(_))
    }
}

/// The land outside all quarters that is filled: a rim around the city.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// How far it reaches at most from the streets that close quarters, metres.
    pub width: f64,
    /// The share of the width by which it differs from place to place.
    pub bulge: f64,
}

/// A place that stands out: its ground stays free of streets, becomes one parcel, and streets are led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// What it is called; no two are called alike.
    pub name: String,
    /// Its ground, counter-clockwise.
    pub ground: Polygon,
    /// How much it draws highways and majors: 1 as the densest place of the city; 0 for not at all.
    pub attract: f64,
    /// How far that is felt, metres.
    pub reach: f64,
    /// What its parcel is for.
    pub usage: Use,
    /// The class of a street that is laid around it.
    pub around: Option<Class>,
}

impl Landmark {
    /// Its identity: that of its name.
    pub fn id(&self) -> Id {
        Id::of_text("landmark", &self.name)
    }

    /// The middle of its ground, in metres: the centroid, or the inner point farthest from the rim where that lies outside.
    pub fn middle(&self) -> Vec2 {
        let centroid = self.ground.centroid();
        let is_inside = Point::try_from_metres(centroid).is_some_and(|at| self.ground.contains(at));
        if is_inside { centroid } else { self.ground.pole(1.0).metres() }
    }
}

/// A street drawn in the script.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenLine {
    /// Its points in metres; at least two, on the lattice.
    pub points: Vec<Vec2>,
    /// Its class.
    pub class: Class,
    /// Full right-of-way in metres; that of its class when none.
    pub width: Option<f64>,
    /// Its name.
    pub name: Option<String>,
}

/// What the coordinates of a GeoJSON file count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StreetUnits {
    /// Metres in the site's frame.
    Metres,
    /// Degrees of longitude and latitude.
    Degrees,
}

/// Streets from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct StreetImport {
    /// The file, relative to the city's folder: `.geojson`, `.osm` or `.osm.pbf`.
    pub file: String,
    /// The unit of a GeoJSON file's coordinates; what the file says when none.
    pub units: Option<StreetUnits>,
    /// The class of streets that `classes` says nothing about; the importer's choice when none.
    pub class: Option<Class>,
    /// The width in metres of streets that say nothing themselves.
    pub width: Option<f64>,
    /// Our class for a value of the file's `highway` tag or `class` property.
    pub classes: BTreeMap<String, Class>,
    /// Whom maps must name for it; OpenStreetMap's contributors for its own formats when none.
    pub credit: Option<String>,
    /// The width in metres for such a value.
    pub widths: BTreeMap<String, f64>,
}

/// Density as a goal: streets end where nobody lives, and branch later where few do (PM01 §3.2.1).
#[derive(Clone, Debug, PartialEq)]
pub struct DensityGoal {
    /// The map of demand, e.g. people per km².
    pub map: MapRef,
    /// Demand below which no street grows.
    pub least: Value,
    /// Demand from which nothing waits; the map's greatest value when none.
    pub full: Option<Value>,
    /// Derivation steps that a branch waits for where the demand is zero.
    pub pace: Value,
    /// People that a kilometre of street serves, taken from the density around it; 0 for none.
    pub consume: f64,
}

impl DensityGoal {
    /// The maps that it reads its numbers from.
    fn maps(&self) -> Vec<&MapRef> {
        self.values().flat_map(|(_, value)| value.maps()).collect()
    }

    /// Its numbers by name.
    fn values(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        [("least", &self.least), ("pace", &self.pace)].into_iter().chain(self.full.iter().map(|full| ("full", full)))
    }

    /// Whether its numbers can be read on a site.
    fn check(&self, places: &Places) -> Result<(), ParamError> {
        self.values().try_for_each(|(name, value)| {
            let wrong = |(message, hint): Misfit| ParamError { message: format!("`{name}` {message}"), hint };
            places.check(&Param::plain(), value).map_err(wrong)
        })
    }
}

/// Where streets want to be: told by the script, or by a rule.
#[derive(Clone, Debug)]
pub enum GoalPlan {
    /// Told by the script.
    Fixed(DensityGoal),
    /// By a rule with `goals(p)`.
    Rule(Rule),
}

/// How streets of one class grow.
#[derive(Clone, Debug)]
pub struct StreetPlan {
    /// Where they want to be; everywhere when none.
    pub goals: Option<GoalPlan>,
    /// How they grow: rules with `propose(tip, p)`.
    pub pattern: PatternPlan,
    /// What they keep to: rules with `constraints(p)` or `constrain(segment, p)`, in order; the kernel's own standard
    /// chain when none has the former.
    pub constraints: Vec<Rule>,
    /// Full right-of-way in metres; that of the class when none.
    pub width: Option<Value>,
    /// The same where it differs by place, once it is read from a site: each piece of street takes that of its start.
    pub widths: Option<Field>,
    /// Where streets of this class grow, besides what holds for the city; everywhere when none.
    pub within: Option<Within>,
    /// How far from the streets that close quarters those outside all quarters grow, metres; as far as there is land when
    /// none (SCH10 §4.2.5).
    pub rim: Option<Rim>,
    /// Where growth starts, in metres; the kernel's own choice when empty.
    pub seeds: Vec<Vec2>,
    /// Further seeds are planted farther than this from every street, in metres; the stage's own distance when none.
    pub reseed: Option<f64>,
    /// Whether given streets of the class go on at their free ends, and streets sprout along them.
    pub sprout: bool,
    /// Whether curved streets are smoothed; highways only when none.
    pub smooth: Option<bool>,
    /// Dead ends shorter than this many metres are removed after growth.
    pub least_dead_end: f64,
    /// Streets of the class that lead to no others and are shorter than this many metres in all are removed after growth.
    pub least_network: f64,
}

impl StreetPlan {
    /// Where streets want to be, with the present parameters; everywhere alike when none.
    pub fn goal(&self) -> Result<Option<DensityGoal>, Fault> {
        match &self.goals {
            None => Ok(None),
            Some(GoalPlan::Fixed(goal)) => Ok(Some(goal.clone())),
            Some(GoalPlan::Rule(rule)) => crate::words::goal_of(rule).map(Some),
        }
    }

    /// Full right-of-way in metres, where the plan tells one for everywhere.
    pub fn constant_width(&self) -> Option<f64> {
        match self.width.as_ref()?.constant()? {
            Literal::Number(width) => Some(*width),
            _ => None,
        }
    }

    /// What streets keep to, with the present parameters; where no rule tells a chain, it is the standard one given. What
    /// goes wrong in constraints of one's own is reported to `faults`.
    pub fn chain(&self, standard: Chain, classes: &Arc<Classes>, faults: &Arc<Faults>) -> Result<Chain, Fault> {
        self.chain_with(standard, classes, faults, &|_, pattern| Own(Arc::new(pattern)))
    }

    /// The same with constraints of one's own made of the rule and of what asks it.
    pub fn chain_with(
        &self,
        standard: Chain,
        classes: &Arc<Classes>,
        faults: &Arc<Faults>,
        make: &dyn Fn(&Rule, ConstraintPattern) -> Own,
    ) -> Result<Chain, Fault> {
        let own = |rule: &Rule| {
            let (classes, faults) = (classes.clone(), faults.clone());
            make(rule, ConstraintPattern::new(rule.clone(), classes, faults))
        };
        crate::words::chain_of(&self.constraints, standard, &own)
    }

    /// The maps that its constraints clip streets to, by name.
    pub fn masks(&self) -> Result<Vec<String>, Fault> {
        let chain = self.chain(Chain::new(Vec::new()), &Arc::default(), &Arc::default())?;
        let name = |step: &Step| match step {
            Step::Mask(Area::Map(name)) => Some(name.to_string()),
            _ => None,
        };
        Ok(chain.steps().iter().filter_map(name).collect())
    }
}

/// How many rules may tell what streets of one class keep to.
pub(crate) const MOST_CONSTRAINTS: usize = 8;

/// The role of a class's constraints, by their place in the list.
fn constraint_role(class: &str, place: usize) -> String {
    if place == 0 { format!("{class}.constraints") } else { format!("{class}.constraints.{}", place + 1) }
}

/// What differs in one quarter.
#[derive(Clone, Debug, Default)]
pub struct QuarterPlan {
    /// A seed of its own.
    pub seed: Option<u64>,
    /// Other values of parameters, by role and name: `minors.pattern.block_width`.
    pub set: BTreeMap<String, Value>,
    /// Full right-of-way of its minors in metres, where it differs.
    pub width: Option<f64>,
    /// What is laid on it as a whole; the values above stand over it.
    pub preset: Option<Preset>,
}

/// Full right-of-way of minors in metres where nothing tells another.
pub const MINOR_WIDTH: f64 = 16.0;

/// What a city script asks for.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What maps call the city; its folder's name when none.
    pub name: Option<String>,
    /// The place.
    pub site: SitePlan,
    /// A mask outside of which nothing grows.
    pub within: Option<MapRef>,
    /// Masks on which nothing grows, such as parks.
    pub barred: Vec<MapRef>,
    /// Named areas of the site; none when nothing tells them.
    pub districts: Option<DistrictPlan>,
    /// What chance depends on.
    pub seed: u64,
    /// Places that stand out, in the script's order.
    pub landmarks: Vec<Landmark>,
    /// Streets drawn in the script, in its order.
    pub given: Vec<GivenLine>,
    /// Streets from files, in the script's order.
    pub imports: Vec<StreetImport>,
    /// How highways grow; none grow without.
    pub highways: Option<StreetPlan>,
    /// How majors grow; none grow without.
    pub majors: Option<StreetPlan>,
    /// How minors grow; none grow without.
    pub minors: Option<StreetPlan>,
    /// How blocks become parcels: a rule with `subdivide(block, p)`.
    pub parcels: Option<Rule>,
    /// What stands on parcels: a rule with `build(shape, p)`.
    pub buildings: Option<Rule>,
    /// Rules for parcels in districts that have their own, by the district's name.
    pub district_parcels: BTreeMap<String, Rule>,
    /// Rules for buildings in districts that have their own.
    pub district_buildings: BTreeMap<String, Rule>,
    /// What differs in single quarters.
    pub quarters: BTreeMap<Id, QuarterPlan>,
    /// Streets taken out by hand after growth, by id.
    pub removed: Vec<StreetId>,
}

/// A parameter of a rule in its role.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleParam {
    /// How it is addressed: `minors.pattern.block_width`.
    pub address: String,
    /// The rule, e.g. `streets/grid`.
    pub rule: String,
    /// The declaration.
    pub param: crate::param::Param,
    /// The present value.
    pub value: crate::param::Value,
}

impl Plan {
    /// A site on which nothing grows.
    pub(crate) fn on(site: SitePlan) -> Self {
        Self {
            name: None,
            site,
            within: None,
            barred: Vec::new(),
            districts: None,
            seed: 0,
            landmarks: Vec::new(),
            given: Vec::new(),
            imports: Vec::new(),
            highways: None,
            majors: None,
            minors: None,
            parcels: None,
            buildings: None,
            district_parcels: BTreeMap::new(),
            district_buildings: BTreeMap::new(),
            quarters: BTreeMap::new(),
            removed: Vec::new(),
        }
    }

    /// The roles that rules play in this plan, in the order of the stages. A district's own rule for parcels plays
    /// `parcels.` and the district's name; of several constraints the second is `majors.constraints.2`, and so on.
    pub fn roles(&self) -> Vec<(String, &Rule)> {
        let mut found = Vec::new();
        let classes = [(&self.highways, "highways"), (&self.majors, "majors"), (&self.minors, "minors")];
        for (plan, class) in classes {
            let Some(plan) = plan else { continue };
            if let Some(GoalPlan::Rule(rule)) = &plan.goals {
                found.push((format!("{class}.goals"), rule));
            }
            found.extend(plan.pattern.roles(&format!("{class}.pattern")));
            let constraints = plan.constraints.iter().enumerate();
            found.extend(constraints.map(|(i, rule)| (constraint_role(class, i), rule)));
        }
        for (role, whole, own) in [
            ("parcels", &self.parcels, &self.district_parcels),
            ("buildings", &self.buildings, &self.district_buildings),
        ] {
            found.extend(whole.iter().map(|rule| (role.to_owned(), rule)));
            found.extend(own.iter().map(|(district, rule)| (format!("{role}.{district}"), rule)));
        }
        found
    }

    /// The districts with a rule of their own in a role such as `parcels`.
    pub fn districts_of(&self, role: &str) -> impl Iterator<Item = &str> {
        let own = if role == "parcels" { &self.district_parcels } else { &self.district_buildings };
        own.keys().map(String::as_str)
    }

    /// The maps that weigh patterns, in the order of the stages.
    pub fn weight_maps(&self) -> Vec<&MapRef> {
        let patterns =
            [&self.highways, &self.majors, &self.minors].into_iter().flatten().flat_map(|plan| plan.pattern.parts());
        patterns.flat_map(|part| part.weight.maps()).collect()
    }

    /// Every parameter that `--set` reaches, in the order of the stages and of the authors.
    pub fn parameters(&self) -> Vec<RoleParam> {
        let of_rule = |(role, rule): (String, &Rule)| {
            let of_param = |(param, value): (&crate::param::Param, &crate::param::Value)| RoleParam {
                address: format!("{role}.{}", param.name),
                rule: rule.name().to_owned(),
                param: param.clone(),
                value: value.clone(),
            };
            rule.params().iter().map(of_param).collect::<Vec<_>>()
        };
        self.roles().into_iter().flat_map(of_rule).collect()
    }

    /// Sets what `--set` names: `seed=7`, `minors.pattern.block_width=90`, or the same in one place,
    /// `district:old town.minors.pattern.block_width=60` and `quarter:ID.seed=3`.
    pub fn set(&mut self, assignment: &str) -> Result<(), ParamError> {
        let Some((address, text)) = assignment.split_once('=') else {
            let hint = Some("write minors.pattern.block_width=90".to_owned());
            return Err(ParamError { message: format!("`{assignment}` sets nothing: it has no `=`"), hint });
        };
        let address = address.trim();
        if let Some(place) = address.strip_prefix("quarter:") {
            return self.set_in_quarter(place, text);
        }
        if let Some(place) = address.strip_prefix("district:") {
            return self.set_in_district(place, text);
        }
        if address == "seed" {
            self.seed = parse_seed(text)?;
            return Ok(());
        }
        let (role, name) = self.address(address)?;
        let changed = self.rule(&role).with_text(&name, text)?;
        *self.rule_mut(&role) = changed;
        Ok(())
    }

    /// Sets `ID.seed` or `ID.minors.pattern.block_width`.
    fn set_in_quarter(&mut self, address: &str, text: &str) -> Result<(), ParamError> {
        let (id, address) = address.split_once('.').unwrap_or((address, ""));
        let target = format!("quarter:{id}").parse();
        let Ok(PresetTarget::Quarter(id)) = target else {
            let hint = Some("write quarter:ID.minors.pattern.block_width=90".to_owned());
            return Err(ParamError { message: target.err().unwrap_or_default(), hint });
        };
        if address == "seed" {
            self.quarters.entry(id).or_default().seed = Some(parse_seed(text)?);
            return Ok(());
        }
        let there = self.in_quarter(Some(id));
        let (role, name) = there.address(address)?;
        no_arterials(&role)?;
        let value = there.rule(&role).params().with_text(&name, text)?.get(&name).cloned();
        if let Some(value) = value {
            self.quarters.entry(id).or_default().set.insert(address.to_owned(), value);
        }
        Ok(())
    }

    /// Sets `old town.minors.pattern.block_width`: elsewhere the value stays what it is.
    fn set_in_district(&mut self, address: &str, text: &str) -> Result<(), ParamError> {
        // Names of districts may hold dots, too.
        let parted = address.match_indices('.').map(|(at, _)| (&address[..at], &address[at + 1..]));
        let mut first = None;
        let found = parted.into_iter().find_map(|(district, rest)| {
            let found = self.address(rest).map_err(|error| first.get_or_insert(error).clone()).ok()?;
            Some((district.trim().to_owned(), found))
        });
        let Some((district, (role, name))) = found else {
            let hint = Some("write district:NAME.minors.pattern.block_width=90".to_owned());
            let nothing = ParamError { message: format!("`district:{address}` names no parameter"), hint };
            return Err(first.unwrap_or(nothing));
        };
        let rule = self.rule(&role);
        let params = rule.params();
        let value = params.with_text(&name, text)?.get(&name).cloned();
        let (Some(value), Some(other)) = (value, params.get(&name).cloned()) else { return Ok(()) };
        let params = params.with_value(&name, in_district(other, &district, value))?;
        *self.rule_mut(&role) = rule.with(params);
        Ok(())
    }

    /// The present value of what [`Plan::set`] names, as people read it; `None` where there is no such thing.
    pub fn value(&self, address: &str) -> Option<String> {
        if let Some(place) = address.strip_prefix("quarter:") {
            let (id, address) = place.split_once('.')?;
            let id: Id = id.parse().ok()?;
            let seed = || self.seed_in(id).map_or("the city's".to_owned(), |seed| seed.to_string());
            return if address == "seed" { Some(seed()) } else { self.in_quarter(Some(id)).value(address) };
        }
        if let Some(place) = address.strip_prefix("district:") {
            return place.match_indices('.').find_map(|(at, _)| self.value(&place[at + 1..]));
        }
        if address == "seed" {
            return Some(self.seed.to_string());
        }
        let (role, name) = self.address(address).ok()?;
        self.rule(&role).params().get(&name).map(ToString::to_string)
    }

    /// The maps that parameters are read from or name, by name.
    pub fn param_maps(&self) -> Vec<&MapRef> {
        let of_rules = self.rules().flat_map(|rule| rule.params().iter().map(|(_, value)| value));
        let of_quarters = self.quarters.values().flat_map(|quarter| quarter.set.values());
        let streets = [&self.highways, &self.majors, &self.minors].into_iter().flatten();
        let widths = streets.clone().filter_map(|plan| plan.width.as_ref());
        let goals = streets.clone().filter_map(|plan| match &plan.goals {
            Some(GoalPlan::Fixed(goal)) => Some(goal.maps()),
            _ => None,
        });
        let values = of_rules.chain(of_quarters).chain(widths);
        let mut maps: Vec<&MapRef> = values.flat_map(Value::maps).chain(goals.flatten()).collect();
        maps.sort();
        maps.dedup();
        maps
    }

    /// Reads values by place from a site, from now on.
    ///
    /// # Errors
    /// [`ParamError`] for the first value that names a map or a district that the site does not have, or lies outside its
    /// range somewhere.
    pub fn settle(&mut self, places: Places) -> Result<(), ParamError> {
        let roles: Vec<_> = self.roles().into_iter().map(|(role, rule)| (role, rule.clone())).collect();
        let places = Arc::new(places);
        self.settle_quarters(&places)?;
        for (role, rule) in roles {
            rule.params().check(&places).map_err(|error| within(&role, error))?;
            *self.rule_mut(&role) = rule.with(rule.params().on(&places));
        }
        let known: Vec<&str> = places.districts.names().iter().map(String::as_str).collect();
        self.check_rules_of_districts(&known)?;
        let classes = [(&mut self.highways, "highways"), (&mut self.majors, "majors"), (&mut self.minors, "minors")];
        for (plan, class) in classes {
            let Some(plan) = plan else { continue };
            plan.settle_width(&places).map_err(|error| within(class, error))?;
            // A goal that cannot be told is a fault of the build.
            if plan.constraints.iter().any(|rule| rule.params().iter().any(|(_, value)| value.constant().is_none())) {
                plan.masks().map_err(|fault| {
                    let error = ParamError { message: fault.message, hint: fault.hint };
                    within(&format!("{class}.constraints"), error)
                })?;
            }
            let goal = plan.goal().ok().flatten();
            goal.map_or(Ok(()), |goal| goal.check(&places))
                .map_err(|error| within(&format!("{class}.goals"), error))?;
        }
        Ok(())
    }

    /// Reads what differs in quarters from a site, and checks it there.
    fn settle_quarters(&mut self, places: &Arc<Places>) -> Result<(), ParamError> {
        for id in self.quarters.keys().copied().collect::<Vec<_>>() {
            for (role, rule) in self.in_quarter(Some(id)).roles() {
                rule.params().check(places).map_err(|error| within(&role, error))?;
            }
            let own = self.quarters.get_mut(&id).and_then(|own| own.preset.as_mut());
            if let Some(preset) = own {
                *preset = preset.map_rules(|rule| rule.with(rule.params().on(places)));
            }
        }
        Ok(())
    }

    /// Holds the districts that have rules of their own against those there are.
    fn check_rules_of_districts(&self, known: &[&str]) -> Result<(), ParamError> {
        let patterns = [(&self.highways, "highways"), (&self.majors, "majors"), (&self.minors, "minors")];
        for (plan, class) in patterns {
            let parts = plan.iter().flat_map(|plan| plan.pattern.parts());
            if let Some(unknown) = parts.flat_map(|part| part.weight.districts()).find(|name| !known.contains(name)) {
                let (message, hint) = unknown_district(unknown, known);
                return Err(ParamError { message: format!("{class}.pattern {message}"), hint });
            }
        }
        for (plan, class) in [(&self.highways, "highways"), (&self.majors, "majors"), (&self.minors, "minors")] {
            let Some(Within::QuartersIn(names)) = plan.as_ref().and_then(|plan| plan.within.as_ref()) else { continue };
            if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
                let (message, hint) = unknown_district(unknown, known);
                return Err(ParamError { message: format!("{class}.within {message}"), hint });
            }
        }
        for role in ["parcels", "buildings"] {
            if let Some(unknown) = self.districts_of(role).find(|name| !known.contains(name)) {
                let (message, hint) = unknown_district(unknown, known);
                return Err(ParamError { message: format!("{role} {message}"), hint });
            }
        }
        Ok(())
    }

    /// Holds the districts that parameters name against those that the script tells; others are known when files are read.
    pub(crate) fn check_districts(&self) -> Result<(), ParamError> {
        let known = self.districts.as_ref().map(DistrictPlan::names).unwrap_or_default();
        if known.is_empty() {
            return Ok(());
        }
        self.check_rules_of_districts(&known)?;
        let of_rule = |(role, rule): (String, &Rule)| {
            let named = rule
                .params()
                .iter()
                .flat_map(|(param, value)| value.districts().into_iter().map(|name| (&param.name, name)));
            let unknown = named.into_iter().find(|(_, name)| !known.contains(name));
            unknown.map(|(param, name)| {
                let (message, hint) = unknown_district(name, &known);
                within(&role, ParamError { message: format!("`{param}` {message}"), hint })
            })
        };
        self.roles().into_iter().find_map(of_rule).map_or(Ok(()), Err)
    }

    /// The plan as it is in a quarter: with the preset that is laid on it, and the values that differ there.
    pub fn in_quarter(&self, quarter: Option<Id>) -> Cow<'_, Self> {
        let Some(own) = quarter.and_then(|id| self.quarters.get(&id)) else { return Cow::Borrowed(self) };
        let mut plan = self.clone();
        if let Some(preset) = &own.preset {
            // On a whole plan nothing stands in the way of a preset.
            let _ = plan.apply(preset, &PresetTarget::City);
        }
        for (address, value) in &own.set {
            // Values were checked when the script was read; what a rule no longer declares is left out.
            let Ok((role, name)) = plan.address(address) else { continue };
            let rule = plan.rule(&role);
            if let Ok(params) = rule.params().with_value(&name, value.clone()) {
                *plan.rule_mut(&role) = rule.with(params);
            }
        }
        if let (Some(width), Some(minors)) = (own.width, &mut plan.minors) {
            minors.width = Some(Value::Constant(Literal::Number(width)));
            minors.widths = None;
        }
        Cow::Owned(plan)
    }

    /// The rule that plays a role.
    pub fn rule_of(&self, role: &str) -> Option<&Rule> {
        self.roles().into_iter().find(|(name, _)| *name == role).map(|(_, rule)| rule)
    }

    /// The seed of a quarter's own, where it has one.
    pub fn seed_in(&self, quarter: Id) -> Option<u64> {
        self.quarters.get(&quarter).and_then(|plan| plan.seed)
    }

    /// Every rule of the plan: those that play roles, and those of presets of quarters.
    fn rules(&self) -> impl Iterator<Item = &Rule> {
        let presets = self.quarters.values().filter_map(|quarter| quarter.preset.as_ref());
        let of_presets = presets.flat_map(Preset::rules).map(|(_, rule)| rule);
        self.roles().into_iter().map(|(_, rule)| rule).chain(of_presets)
    }

    /// Warnings of maps that rules ask for and that the site does not have that the plan is settled on, each once.
    pub fn missing_maps(&self) -> Vec<Fault> {
        let mut found: Vec<Fault> = Vec::new();
        for fault in self.rules().flat_map(Rule::missing_maps) {
            if !found.contains(&fault) {
                found.push(fault);
            }
        }
        found
    }

    /// The places that rules marked, with the file of the rule, in order, each once.
    pub fn marks(&self) -> Vec<(String, Marked)> {
        let marks = |rule: &Rule| rule.marks().into_iter().map(|at| (rule.path().to_owned(), at)).collect::<Vec<_>>();
        let mut found: Vec<_> = self.rules().flat_map(marks).collect();
        let order = |mark: &Marked| mark.place.to_array();
        found.sort_by(|(a, p), (b, q)| {
            a.cmp(b).then(order(p)[0].total_cmp(&order(q)[0])).then(order(p)[1].total_cmp(&order(q)[1]))
        });
        found.dedup();
        found
    }

    /// What all rules printed, with the file of the rule, in alphabetical order.
    pub fn notes(&self) -> Vec<(String, Note)> {
        let of_rule = |rule: &Rule| {
            let path = rule.path().to_owned();
            rule.notes().into_iter().map(move |note| (path.clone(), note)).collect::<Vec<_>>()
        };
        let mut notes: Vec<_> = self.rules().flat_map(of_rule).collect();
        notes.sort_by(|(a, p), (b, q)| (a, &p.text).cmp(&(b, &q.text)));
        notes.dedup();
        notes
    }

    /// Forgets where rules printed and what they marked, before a city is built anew: rules live longer than one.
    pub fn forget_places(&self) {
        self.rules().for_each(Rule::forget_places);
    }

    /// Splits `minors.pattern.block_width` into a role of this plan and a name.
    pub(crate) fn address(&self, address: &str) -> Result<(String, String), ParamError> {
        let roles = self.roles();
        let split = |role: &str| {
            let name = address.strip_prefix(role)?.strip_prefix('.')?;
            Some((role.to_owned(), name.to_owned()))
        };
        // `parcels.harbour` begins like `parcels`.
        let found = roles.iter().filter_map(|(role, _)| split(role)).max_by_key(|(role, _)| role.len());
        if let Some(found) = found {
            return Ok(found);
        }
        let all: Vec<String> = self.parameters().into_iter().map(|parameter| parameter.address).collect();
        let names = all.iter().map(String::as_str).chain(["seed"]);
        let near = crate::names::nearest(address, names).map(|name| format!("did you mean `{name}`?"));
        let known: Vec<&str> = roles.iter().map(|(role, _)| role.as_str()).collect();
        let listed = || Some(format!("the roles of this city are {}", crate::names::listed(&known)));
        let message = format!("nothing in this city is called `{address}`");
        Err(ParamError { message, hint: near.or_else(listed) })
    }

    fn rule(&self, role: &str) -> Rule {
        let found = self.roles().into_iter().find(|(name, _)| *name == role);
        found.map(|(_, rule)| rule.clone()).expect("`address` gives roles of this plan only")
    }

    fn rule_mut(&mut self, role: &str) -> &mut Rule {
        let (part, slot) = role.split_once('.').unwrap_or((role, ""));
        let rule = match (part, slot) {
            ("parcels", "") => self.parcels.as_mut(),
            ("parcels", district) => self.district_parcels.get_mut(district),
            ("buildings", "") => self.buildings.as_mut(),
            ("buildings", district) => self.district_buildings.get_mut(district),
            ("highways", _) => self.highways.as_mut().and_then(|plan| plan.rule_mut(slot)),
            ("majors", _) => self.majors.as_mut().and_then(|plan| plan.rule_mut(slot)),
            _ => self.minors.as_mut().and_then(|plan| plan.rule_mut(slot)),
        };
        rule.expect("`address` gives roles of this plan only")
    }
}

/// Refuses roles that cannot differ in a quarter.
pub(crate) fn no_arterials(role: &str) -> Result<(), ParamError> {
    if !["highways", "majors"].iter().any(|class| role.starts_with(&format!("{class}."))) {
        return Ok(());
    }
    let message = format!("`{role}` cannot differ in a quarter: quarters are there only when these streets have grown");
    let hint = Some("in a quarter `minors.…`, `parcels.…` and `buildings.…` can differ".to_owned());
    Err(ParamError { message, hint })
}

/// The width of streets as a parameter: what it may be.
pub(crate) fn width_param() -> Param {
    Param::number("width", Unit::Metres, WIDTHS)
}

/// Narrowest and widest right-of-way that a script may ask for, metres.
pub(crate) const WIDTHS: (f64, f64) = (0.5, 200.0);

impl StreetPlan {
    /// Reads widths by place from a site.
    fn settle_width(&mut self, places: &Places) -> Result<(), ParamError> {
        let Some(value) = self.width.as_ref().filter(|width| width.constant().is_none()) else { return Ok(()) };
        let param = width_param();
        let wrong = |(message, hint): Misfit| ParamError { message: format!("`width` {message}"), hint };
        places.check(&param, value).map_err(wrong)?;
        self.widths = Some(places.field(&param, value));
        Ok(())
    }

    fn rule_mut(&mut self, slot: &str) -> Option<&mut Rule> {
        let (slot, part) = slot.split_once('.').map_or((slot, None), |(slot, part)| (slot, Some(part)));
        match slot {
            "pattern" => self.pattern.rule_mut(part),
            "constraints" => {
                let ordinal = part.map_or(Some(1), |ordinal| ordinal.parse::<usize>().ok())?;
                self.constraints.get_mut(ordinal.checked_sub(1)?)
            }
            _ => match &mut self.goals {
                Some(GoalPlan::Rule(rule)) => Some(rule),
                _ => None,
            },
        }
    }
}

/// An error of a parameter, with the role of its rule.
fn within(role: &str, error: ParamError) -> ParamError {
    ParamError { message: format!("{role}: {}", error.message), ..error }
}

fn parse_seed(text: &str) -> Result<u64, ParamError> {
    let message = || format!("`seed` must be a whole number from 0, not `{}`", text.trim());
    text.trim().parse().map_err(|_| ParamError { message: message(), hint: None })
}

/// Whether a rule decides what a role needs.
pub(crate) fn decides(rule: &Rule, kind: RuleKind) -> Result<(), (String, Option<String>)> {
    if rule.kinds().contains(&kind) {
        return Ok(());
    }
    let message = format!("rule `{}` has no `fn {}`", rule.name(), kind.form());
    let has: Vec<String> = rule.kinds().iter().map(|kind| kind.form()).collect();
    Err((message, Some(format!("it has {}", has.join(", ")))))
}
