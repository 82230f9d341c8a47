//! The stages of a build, each a function of what comes before.

pub(crate) mod buildings;
pub(crate) mod ground;
pub(crate) mod keep;
pub(crate) mod land;
pub(crate) mod landmarks;
pub(crate) mod patterns;
pub(crate) mod shape;
pub(crate) mod streets;

use crate::progress::{Cancel, Progress};
use crate::{BuildError, Cache, Sources};
use ::streets::StreetGraph;
use ::streets::faces::{FaceKind, Faces};
use ::streets::runs::{Run, runs};
use geom::{Bounds, Digest, Id, Seed, Vec2};
use keep::Keys;
use script::{Faults, Plan, Rule};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What every stage is given.
pub(crate) struct Context<'a> {
    pub sources: &'a Sources,
    pub faults: &'a Arc<Faults>,
    pub progress: &'a dyn Progress,
    pub cancel: &'a Cancel,
    /// Whether growth is to be traced, with what it refused.
    pub traces: bool,
    /// What earlier builds kept.
    pub cache: &'a Cache,
    /// By which digests this one keeps and looks up; none where it keeps nothing.
    pub keys: Option<Keys>,
    /// What blocks must reach into; all are wanted when none.
    pub within: Option<Bounds>,
}

impl Context<'_> {
    /// Fails when the build is to stop.
    pub fn check(&self) -> Result<(), BuildError> {
        if self.cancel.is_cancelled() { Err(BuildError::Cancelled) } else { Ok(()) }
    }

    /// What chance depends on in a quarter: a seed of its own, else the city's.
    pub fn seed(&self, quarter: Option<Id>) -> Seed {
        let plan = &self.sources.plan;
        Seed(quarter.and_then(|quarter| plan.seed_in(quarter)).unwrap_or(plan.seed))
    }

    /// The name of the district at a place, empty where there is none.
    pub fn district(&self, place: Vec2) -> String {
        self.sources.site.districts.name_at(place).to_owned()
    }

    /// People per km² at a place, 0 where no map tells.
    pub fn density(&self, place: Vec2) -> f64 {
        self.sources.site.map("density").map_or(0.0, |map| map.bilinear(place))
    }
}

/// What is found of the streets of a city once they are all there.
pub(crate) struct Outlines {
    pub quarters: Faces,
    pub blocks: Faces,
    pub runs: Vec<Run>,
}

impl Outlines {
    /// Those of a graph.
    pub fn of(context: &Context, graph: &StreetGraph) -> Result<Arc<Self>, BuildError> {
        let key = context.keys.map(|keys| Digest::new("outlines").id(keys.streets).finish());
        let find = || Self {
            quarters: Faces::of(graph, FaceKind::Quarter),
            blocks: Faces::of(graph, FaceKind::Block),
            runs: runs(graph),
        };
        let found = context.part(key, |_| true, find);
        context.check().map(|()| found)
    }
}

/// The names that claims, parcels and buildings refer to by number.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Origins(Vec<String>);

impl Origins {
    /// The number of a name, added if new.
    pub fn of(&mut self, name: &str) -> u16 {
        if let Some(at) = self.0.iter().position(|known| known == name) {
            return at as u16;
        }
        self.0.push(name.to_owned());
        (self.0.len() - 1) as u16
    }

    /// All names by number.
    pub fn into_names(self) -> Vec<String> {
        self.0
    }
}

/// What a role's rules are made into: one thing for the city, one for each district with a rule of its own, and each
/// of them again for every quarter where the plan differs.
pub(crate) struct ByPlace<T> {
    whole: Option<T>,
    districts: BTreeMap<String, T>,
    quarters: BTreeMap<Id, (Option<T>, BTreeMap<String, T>)>,
}

impl<T> ByPlace<T> {
    /// Makes something of the rules that play `role`.
    pub fn of(context: &Context, role: &str, make: impl Fn(Rule) -> T) -> Self {
        let plan = &context.sources.plan;
        let of = |plan: &Plan| -> (Option<T>, BTreeMap<String, T>) {
            let rule = |role: &str| plan.rule_of(role).cloned().map(&make);
            let named =
                plan.districts_of(role).filter_map(|name| Some((name.to_owned(), rule(&format!("{role}.{name}"))?)));
            (rule(role), named.collect())
        };
        let (whole, districts) = of(plan);
        let quarters = plan.quarters.keys().map(|&id| (id, of(&plan.in_quarter(Some(id))))).collect();
        Self { whole, districts, quarters }
    }

    /// What holds in a quarter and a district (an empty name is none).
    pub fn at(&self, quarter: Option<Id>, district: &str) -> Option<&T> {
        let own = quarter.and_then(|quarter| self.quarters.get(&quarter));
        let (whole, districts) = own.map_or((&self.whole, &self.districts), |(whole, districts)| (whole, districts));
        districts.get(district).or(whole.as_ref())
    }
}
