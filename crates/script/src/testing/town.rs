//! Towns that tests grow: `grow(rule(…))`, `city(#{ … })`, and what can be asked of them.

use super::desk::Desk;
use super::{answer, standard};
use crate::city::{plan_of, rule_named, street_plan};
use crate::fault::{Complaint, Fault, Refusal, Severity};
use crate::names::hint;
use crate::plan::{MapRef, Plan};
use crate::rule::{Rule, RuleKind, Surroundings};
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map};
use std::fmt::Debug;
use std::sync::Arc;

/// Builds towns for tests: a pure function of the plan.
pub trait Laboratory: Send + Sync + Debug {
    /// The town that a plan leads to.
    ///
    /// # Errors
    /// [`TownError`] when there is none.
    fn build(&self, plan: Plan) -> Result<Arc<dyn Town>, TownError>;
}

/// Why there is no town.
#[derive(Clone, Debug, PartialEq)]
pub struct TownError {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
    /// The fault of a rule that lies behind it.
    pub fault: Option<Box<Fault>>,
}

/// A finished town, as tests ask it.
pub trait Town: Send + Sync + Debug {
    /// What can be measured anywhere: names with their units and what they say.
    fn measures(&self) -> Vec<(&'static str, &'static str, &'static str)>;

    /// A measure; `None` where it cannot be taken, or there is none of that name.
    fn measure(&self, name: &str) -> Option<f64>;

    /// All features of a kind (`street`, `crossing`, `block`, `parcel`, `building`, `quarter`) with their properties.
    fn features(&self, kind: &str) -> Vec<Feature>;

    /// Least distance in metres of any street, or of those of a class, from what a map marks; `None` where the site has no
    /// such map.
    fn distance(&self, map: &str, class: Option<&str>) -> Option<f64>;

    /// All that can be compared from run to run, as text.
    fn digest(&self) -> String;

    /// A map, as SVG.
    fn drawing(&self) -> String;

    /// What went wrong while it grew, and what is doubtful.
    fn faults(&self) -> Vec<Fault>;
}

/// The properties of a street, parcel, …
pub type Feature = Vec<(String, Datum)>;

/// What a property may be.
#[derive(Clone, Debug, PartialEq)]
pub enum Datum {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// Yes or no.
    Flag(bool),
    /// Words.
    Text(String),
    /// Several.
    List(Vec<Datum>),
}

impl Datum {
    fn to_dynamic(&self) -> Dynamic {
        match self {
            Self::Number(number) => (*number).into(),
            Self::Whole(whole) => (*whole).into(),
            Self::Flag(flag) => (*flag).into(),
            Self::Text(text) => text.clone().into(),
            Self::List(list) => list.iter().map(Self::to_dynamic).collect::<Array>().into(),
        }
    }
}

/// A town as a script holds it.
#[derive(Clone, Debug)]
pub(super) struct TownHandle {
    town: Arc<dyn Town>,
    desk: Desk,
}

impl TownHandle {
    pub fn new(town: Arc<dyn Town>, desk: Desk) -> Self {
        Self { town, desk }
    }

    /// All that can be compared.
    pub fn digest(&self) -> String {
        self.town.digest()
    }

    /// The town.
    pub fn town(&self) -> Arc<dyn Town> {
        self.town.clone()
    }

    fn measure(&self, name: &str) -> Result<f64, Complaint> {
        if let Some(value) = self.town.measure(name) {
            self.desk.read(name, &answer::number(value));
            return Ok(value);
        }
        let known = self.town.measures();
        match known.iter().find(|(known, ..)| *known == name) {
            Some((.., about)) => {
                let message = format!("`{name}` cannot be measured here");
                Err(Complaint::new(message).hint(format!("it is the {about}; does the site have the maps for it?")))
            }
            None => {
                let near = hint(name, known.iter().map(|(known, ..)| *known));
                Err(Complaint::new(format!("a town has no measure `{name}`")).maybe_hint(near))
            }
        }
    }

    fn list(&self, kind: &str) -> Array {
        let features = self.town.features(kind);
        self.desk.read(&format!("the number of {kind}s"), &features.len().to_string());
        features.into_iter().map(of_feature).collect()
    }

    /// The feature of a kind with an id; `()` where there is none.
    pub fn feature(&self, kind: &str, id: &str) -> Dynamic {
        let is_it = |feature: &Feature| feature.contains(&("id".to_owned(), Datum::Text(id.to_owned())));
        self.town.features(kind).into_iter().find(is_it).map_or(Dynamic::UNIT, of_feature)
    }

    fn distance(&self, map: &Dynamic, class: Option<&str>) -> Result<f64, Complaint> {
        let name = map.read_lock::<MapRef>().map(|map| map.name.clone()).or_else(|| map.clone().into_string().ok());
        let name = name.ok_or_else(|| Complaint::new("a map is named: town.distance(\"parks\")"))?;
        let missing = || Complaint::new(format!("the site has no map `{name}`"));
        let metres = self.town.distance(&name, class).ok_or_else(missing)?;
        self.desk.read(&format!("the distance from {name}"), &format!("{} m", answer::number(metres)));
        Ok(metres)
    }
}

/// A feature as a map.
fn of_feature(feature: Feature) -> Dynamic {
    let map: Map = feature.into_iter().map(|(key, value)| (key.into(), value.to_dynamic())).collect();
    map.into()
}

pub(super) fn register(engine: &mut Engine, desk: &Desk, around: &Surroundings, laboratory: Arc<dyn Laboratory>) {
    engine.register_type_with_name::<TownHandle>("a town");
    let grower = Grower { desk: desk.clone(), around: around.clone(), laboratory };
    let own = grower.clone();
    FuncRegistration::new("city")
        .with_params_info(["#{ site, seed, majors, minors, parcels, buildings, … }"])
        .with_comments(["/// The town of a plan, told as in a city script."])
        .register_into_engine(engine, move |options: Map| Ok::<_, Refusal>(own.build(options)?));
    let own = grower.clone();
    FuncRegistration::new("grow")
        .with_params_info(["rule"])
        .with_comments([
            "/// A small town that a rule decides about, on a flat site of 600 m; what else it takes is of the library.",
        ])
        .register_into_engine(engine, move |rule: Rule| Ok::<_, Refusal>(own.grow(&rule, Map::new())?));
    FuncRegistration::new("grow")
        .with_params_info(["rule", "#{ site, seed, majors, minors, … }"])
        .with_comments(["/// The same, on another site or with other streets: what can be told of a city."])
        .register_into_engine(engine, move |rule: Rule, options: Map| Ok::<_, Refusal>(grower.grow(&rule, options)?));
    questions(engine);
}

fn questions(engine: &mut Engine) {
    engine.register_indexer_get(|town: &mut TownHandle, name: &str| Ok::<_, Refusal>(town.measure(name)?));
    const LISTS: [(&str, &str); 6] = [
        ("streets", "street"),
        ("crossings", "crossing"),
        ("blocks", "block"),
        ("quarters", "quarter"),
        ("parcels", "parcel"),
        ("buildings", "building"),
    ];
    for (name, kind) in LISTS {
        FuncRegistration::new(name)
            .with_params_info(["this"])
            .with_comments([format!("/// The {name} of a town: a list of maps with what layout.geojson says of each.")])
            .register_into_engine(engine, move |town: &mut TownHandle| town.list(kind));
    }
    FuncRegistration::new("distance")
        .with_params_info(["this", "map"])
        .with_comments(["/// Least metres from the middle of any street to what a map marks."])
        .register_into_engine(engine, |town: &mut TownHandle, map: Dynamic| {
            Ok::<_, Refusal>(town.distance(&map, None)?)
        });
    FuncRegistration::new("distance")
        .with_params_info(["this", "map", "class"])
        .with_comments(["/// The same of the streets of a class."])
        .register_into_engine(engine, |town: &mut TownHandle, map: Dynamic, class: &str| {
            Ok::<_, Refusal>(town.distance(&map, Some(class))?)
        });
    FuncRegistration::new("warnings")
        .with_params_info(["this"])
        .with_comments(["/// What is doubtful in the rules of a town, and shows only when it grows."])
        .register_into_engine(engine, |town: &mut TownHandle| -> Array {
            let warnings = town.town.faults().into_iter().filter(|fault| fault.severity == Severity::Warning);
            warnings.map(|fault| Dynamic::from(fault.message)).collect()
        });
}

/// Grows towns for one test.
#[derive(Clone)]
struct Grower {
    desk: Desk,
    around: Surroundings,
    laboratory: Arc<dyn Laboratory>,
}

impl Grower {
    fn build(&self, options: Map) -> Result<TownHandle, Complaint> {
        let plan = plan_of(options)?;
        let town = self.laboratory.build(plan);
        let town = town.map_err(|error| match error.fault {
            Some(fault) => Complaint::of(Fault { place: None, ..*fault }),
            None => Complaint::new(error.message).maybe_hint(error.hint),
        })?;
        // A rule that fails in the town fails its test, where the rule failed.
        match town.faults().into_iter().find(|fault| fault.severity == Severity::Error) {
            Some(fault) => Err(Complaint::of(fault)),
            None => Ok(TownHandle::new(town, self.desk.clone())),
        }
    }

    /// The usual town for a rule: what `options` do not tell comes from the library.
    fn grow(&self, rule: &Rule, options: Map) -> Result<TownHandle, Complaint> {
        let mut plan: Map = self.around_rule(rule)?;
        plan.insert("site".into(), Dynamic::from(standard::standard(standard::SIDE, &[])));
        plan.extend(options);
        // `minors: ()` leaves out what there would be.
        plan.retain(|_, value| !value.is_unit());
        self.build(plan)
    }

    fn around_rule(&self, rule: &Rule) -> Result<Map, Complaint> {
        let library = |name: &str, values: &[(&str, f64)]| {
            let values = values.iter().map(|(key, value)| ((*key).into(), Dynamic::from(*value))).collect();
            rule_named(name, values, &self.around)
        };
        let has = |kind: RuleKind| rule.kinds().contains(&kind);
        let mut minors = Map::new();
        let pattern = if has(RuleKind::Streets) {
            rule.clone()
        } else if has(RuleKind::Parcels) || has(RuleKind::Buildings) {
            library("streets/grid", &[("heading", 0.0), ("block_length", 140.0), ("block_width", 80.0)])?
        } else {
            library("streets/organic", &[])?
        };
        minors.insert("pattern".into(), Dynamic::from(pattern));
        if has(RuleKind::Goals) {
            minors.insert("goals".into(), Dynamic::from(rule.clone()));
        }
        if has(RuleKind::Constrain) && !has(RuleKind::Constraints) {
            let standard = library("constraints/standard", &[])?;
            let both: Array = vec![Dynamic::from(standard), Dynamic::from(rule.clone())];
            minors.insert("constraints".into(), both.into());
        } else if has(RuleKind::Constraints) {
            minors.insert("constraints".into(), Dynamic::from(rule.clone()));
        }
        let mut plan = Map::from([("minors".into(), Dynamic::from(street_plan(minors)?))]);
        if has(RuleKind::Parcels) {
            plan.insert("parcels".into(), Dynamic::from(rule.clone()));
        } else if has(RuleKind::Buildings) {
            plan.insert("parcels".into(), Dynamic::from(library("parcels/recursive", &[])?));
            plan.insert("buildings".into(), Dynamic::from(rule.clone()));
        }
        Ok(plan)
    }
}
