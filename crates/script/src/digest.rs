//! What the stages of a build hang on, as digests: a plan is parted so that a change shows in the stages that it matters to,
//! and in those alone. Every part is taken apart field by field, so that a new one is not forgotten.
//!
//! What is read from files is not part of it: whoever builds has the digests of the maps and streets.

use crate::plan::{Plan, QuarterPlan, StreetPlan};
use crate::rule::Rule;
use geom::{Digest, Id};
use std::collections::BTreeMap;

impl StreetPlan {
    /// All that it says. Widths by place are told by `width` and the site.
    pub fn digest(&self) -> Id {
        let Self {
            goals,
            pattern,
            constraints,
            width,
            widths: _,
            within,
            rim,
            seeds,
            reseed,
            sprout,
            smooth,
            least_dead_end,
            least_network,
        } = self;
        let mut digest = Digest::new("streets");
        digest.value(&(goals, pattern, constraints, width, within, rim, seeds));
        digest.value(&(reseed, sprout, smooth, least_dead_end, least_network));
        digest.finish()
    }
}

/// The parts of a plan that stages read, each as a digest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanDigests {
    /// What highways and majors hang on, and what is there before them.
    pub arterials: Id,
    /// What minors hang on besides, and what is taken out in the end.
    pub minors: Id,
    /// What parcels hang on besides.
    pub parcels: Id,
    /// What buildings hang on besides.
    pub buildings: Id,
}

impl Plan {
    /// What its stages hang on. Of the site and of street files it holds the names only.
    pub fn digests(&self) -> PlanDigests {
        let Self {
            name: _,
            site: _,
            within,
            barred,
            districts: _,
            seed,
            landmarks,
            given,
            imports: _,
            highways,
            majors,
            minors,
            parcels,
            buildings,
            district_parcels,
            district_buildings,
            quarters,
            removed,
        } = self;
        let of = |plan: &Option<StreetPlan>| plan.as_ref().map(StreetPlan::digest);
        let mut arterials = Digest::new("arterials");
        arterials.value(&(within, barred, seed, landmarks, given));
        // A minor street may run around a landmark.
        let minor_width = minors.as_ref().map(|minors| &minors.width);
        arterials.value(&(of(highways), of(majors), minor_width));
        let mut rest = Digest::new("minors");
        rest.value(&of(minors)).value(removed);
        quarters.iter().for_each(|(id, own)| {
            rest.id(*id).id(own.digest());
        });
        PlanDigests {
            arterials: arterials.finish(),
            minors: rest.finish(),
            parcels: of_rules(parcels.as_ref(), district_parcels),
            buildings: of_rules(buildings.as_ref(), district_buildings),
        }
    }
}

fn of_rules(rule: Option<&Rule>, of_districts: &BTreeMap<String, Rule>) -> Id {
    Digest::new("rules").value(&rule).value(of_districts).finish()
}

impl QuarterPlan {
    fn digest(&self) -> Id {
        let Self { seed, set, width, preset } = self;
        let mut digest = Digest::new("quarter");
        digest.value(&(seed, set, width));
        digest.value(&preset.as_ref().map(crate::preset::Preset::digest));
        digest.finish()
    }
}
