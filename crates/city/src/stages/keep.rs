//! What stages keep for later builds, and by which digests.

use super::Context;
use crate::{BuildError, Cache, Sources};
use geom::{Digest, Id};
use script::{Plan, PlanDigests, heard};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::any::Any;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The digests of all that the results of each stage are made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Keys {
    /// The site with its maps.
    pub site: Id,
    /// Given and imported streets, highways and majors.
    pub arterials: Id,
    /// All streets.
    pub streets: Id,
    /// Blocks and parcels.
    pub land: Id,
    /// Buildings.
    pub buildings: Id,
}

impl Keys {
    /// Those of what was read.
    pub fn of(sources: &Sources, cache: &Cache) -> Self {
        let plan = sources.plan.digests();
        let after = |stage: &str, before: Id, own: Id| Digest::new(stage).id(before).id(own).finish();
        let site = sources.site.digest(cache);
        let imported = Digest::new("imports").value(&sources.imports).finish();
        let arterials = after("arterials", after("imports", site, imported), plan.arterials);
        let streets = after("streets", arterials, plan.minors);
        let land = after("land", streets, plan.parcels);
        Self { site, arterials, streets, land, buildings: after("buildings", land, plan.buildings) }
    }
}

/// The digests of the site, its landmarks and the rules of a role, by quarter.
#[derive(Debug)]
pub(crate) struct Rules {
    elsewhere: Id,
    quarters: BTreeMap<Id, Id>,
}

impl Rules {
    /// Those that `pick` takes of a plan's; none where nothing is kept.
    pub fn of(context: &Context, pick: impl Fn(&PlanDigests) -> Id) -> Option<Self> {
        let (site, plan) = (context.keys?.site, &context.sources.plan);
        let of = |plan: &Plan| {
            let mut digest = Digest::new("rules");
            digest.id(site).value(&plan.landmarks).id(pick(&plan.digests()));
            digest.finish()
        };
        let quarters = plan.quarters.keys().map(|&id| (id, of(&plan.in_quarter(Some(id))))).collect();
        Some(Self { elsewhere: of(plan), quarters })
    }

    /// That of a quarter.
    pub fn at(&self, quarter: Option<Id>) -> Id {
        quarter.and_then(|id| self.quarters.get(&id)).copied().unwrap_or(self.elsewhere)
    }
}

/// Whether all parts of a stage came without faults, prints and marks, on whatever threads they ran.
#[derive(Debug, Default)]
pub(crate) struct Silence(AtomicBool);

impl Silence {
    /// Does a part of the stage on this thread.
    pub fn over<T>(&self, work: impl FnOnce() -> T) -> T {
        let (result, is_silent) = heard(work);
        if !is_silent {
            self.0.store(true, Ordering::Relaxed);
        }
        result
    }

    fn is_broken(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Context<'_> {
    /// The result of a stage: one that was kept, or a new one. What the stage does on other threads goes through the
    /// [`Silence`] that it is given.
    pub fn stage<T: Any + Send + Sync + Serialize + DeserializeOwned>(
        &self,
        key: impl Fn(&Keys) -> Id,
        make: impl FnOnce(&Silence) -> Result<T, BuildError>,
    ) -> Result<Arc<T>, BuildError> {
        let key = self.keys.map(|keys| key(&keys));
        if let Some(kept) = key.and_then(|key| self.cache.get_stored(key)) {
            return Ok(kept);
        }
        let silence = Silence::default();
        let result = Arc::new(silence.over(|| make(&silence))?);
        if let Some(key) = key.filter(|_| !silence.is_broken()) {
            self.cache.keep_stored(key, &result);
        }
        Ok(result)
    }

    /// The same of a stage that is made block by block: where only some blocks are wanted, each of them is kept as its parts
    /// are, and the stage is not.
    pub fn stage_of_blocks<T: Any + Send + Sync + Serialize + DeserializeOwned>(
        &self,
        key: impl Fn(&Keys) -> Id,
        make: impl FnOnce(&Silence) -> Result<T, BuildError>,
    ) -> Result<Arc<T>, BuildError> {
        if self.within.is_some() { make(&Silence::default()).map(Arc::new) } else { self.stage(key, make) }
    }

    /// The same for a part of a stage that runs on one thread and is kept in memory only. `is_valid` tells whether what was
    /// kept still holds, and whether a new one may be kept.
    pub fn part<T: Any + Send + Sync>(
        &self,
        key: Option<Id>,
        is_valid: impl Fn(&T) -> bool,
        make: impl FnOnce() -> T,
    ) -> Arc<T> {
        if let Some(kept) = key.and_then(|key| self.cache.get(key)).filter(|kept| is_valid(kept)) {
            return kept;
        }
        let (result, is_silent) = heard(make);
        let result = Arc::new(result);
        if let Some(key) = key.filter(|_| is_silent && is_valid(&result)) {
            self.cache.keep(key, &result);
        }
        result
    }
}
