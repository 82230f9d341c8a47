//! The whole in one call: plan and sources in, a city out. The same for any number of threads.

use crate::progress::{Cancel, Progress};
use crate::stages::buildings::Buildings;
use crate::stages::ground::CityGround;
use crate::stages::keep::Keys;
use crate::stages::land::{self, Land};
use crate::stages::streets::Network;
use crate::stages::{self, Context, Outlines};
use crate::{Area, Cache, City, Digests, Report, Sources, Trace};
use geom::Bounds;
use script::{Faults, Severity};
use std::sync::Arc;

/// The stage to stop after.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Until {
    /// Streets, quarters and blocks.
    Streets,
    /// And parcels.
    Parcels,
    /// And buildings.
    #[default]
    Buildings,
}

/// How to build; nothing here changes what comes out of the stages that run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// Threads to use; all processors when 0.
    pub threads: usize,
    /// The stage to stop after.
    pub until: Until,
    /// Whether to keep what growth did, with what it refused: [`Built::trace`].
    pub traces: bool,
    /// Only blocks that reach into these bounds, with what stands on them, where only a part is wanted first; all streets
    /// even so. What lies there is what the whole city has there, and is kept for it.
    pub within: Option<Bounds>,
}

/// Why there is no city.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The build was cancelled.
    #[error("stopped before the city was finished; nothing was written")]
    Cancelled,
    /// Nothing could grow.
    #[error("{}there is nothing to build: {reason}\n  hint: {hint}", listed(faults))]
    Nothing {
        /// What went wrong in rules meanwhile.
        faults: Vec<script::Fault>,
        /// What is missing.
        reason: String,
        /// What to do about it.
        hint: String,
    },
    /// A rule that is evaluated once failed.
    #[error("{0}")]
    Fault(Box<script::Fault>),
    /// No threads could be started.
    #[error("no threads could be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl From<script::Fault> for BuildError {
    fn from(fault: script::Fault) -> Self {
        Self::Fault(Box::new(fault))
    }
}

/// A city and what there is to say about how it came to be.
#[derive(Clone, Debug)]
pub struct Built {
    /// The city.
    pub city: Arc<City>,
    /// Counts, logs and faults.
    pub report: Report,
    /// What growth did, where the settings ask for it.
    pub trace: Option<Trace>,
}

/// Builds a city. Reads no file and no clock.
pub fn build(
    sources: &Sources,
    settings: Settings,
    progress: &dyn Progress,
    cancel: &Cancel,
) -> Result<Built, BuildError> {
    build_with(sources, settings, &Cache::none(), progress, cancel)
}

/// The same, using what earlier builds kept in a cache, and keeping what later ones may use: the same city in less time. A
/// build that is traced keeps nothing.
pub fn build_with(
    sources: &Sources,
    settings: Settings,
    cache: &Cache,
    progress: &dyn Progress,
    cancel: &Cancel,
) -> Result<Built, BuildError> {
    let built = with_threads(settings.threads, || run_stages(sources, settings, cache, progress, cancel))?;
    // A part of a city does not use all that the city will.
    if !cancel.is_cancelled() && settings.within.is_none() {
        cache.finish_build();
    }
    built
}

/// Does some work on so many threads; on as many as there are processors when 0.
///
/// # Errors
/// When they cannot be started.
pub fn with_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> T + Send,
) -> Result<T, rayon::ThreadPoolBuildError> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(work))
}

fn run_stages(
    sources: &Sources,
    settings: Settings,
    cache: &Cache,
    progress: &dyn Progress,
    cancel: &Cancel,
) -> Result<Built, BuildError> {
    let faults = Arc::new(Faults::default());
    let keys = (cache.is_on() && !settings.traces).then(|| Keys::of(sources, cache));
    let Settings { traces, within, .. } = settings;
    let context = stages::Context { sources, faults: &faults, progress, cancel, traces, cache, keys, within };
    let mut report = Report::new(sources);
    let printed = sources.plan.notes();
    sources.plan.forget_places();
    sources.warnings.iter().for_each(|warning| report.warn(warning.clone()));
    let network = stages::streets::derive(&context)?;
    report.take(&network.report);
    if network.graph.segment_count() == 0 {
        return Err(nothing(sources, &faults));
    }
    let outlines = stages::Outlines::of(&context, &network.graph)?;
    let (land, buildings) = derive_land(&context, &network, &outlines, settings.until)?;
    if settings.until > Until::Streets {
        stages::landmarks::tell(&land.landmarks, &mut report);
    }
    let (land, network) = (Arc::unwrap_or_clone(land), Arc::unwrap_or_clone(network));
    let city = City {
        name: sources.name.clone(),
        seed: sources.plan.seed,
        credits: sources.credits(),
        site: sources.site.clone(),
        runs: outlines.runs.clone(),
        quarters: outlines.quarters.faces.iter().filter_map(quarter_area).collect(),
        districts: sources.site.districts.areas().into_iter().map(district_area).collect(),
        landmarks: land.landmarks,
        graph: network.graph,
        origins: buildings.origins.into_names(),
        street_names: network.names,
        blocks: land.blocks,
        parcels: land.parcels,
        buildings: buildings.all,
        digests: keys.map_or_else(Digests::default, |keys| Digests {
            site: Some(keys.site),
            streets: Some(keys.streets),
            land: Some(keys.land).filter(|_| settings.until > Until::Streets && within.is_none()),
        }),
    };
    report.finish(&city, &sources.plan, &faults, land.trimmed, land.open);
    report.printed(&sources.plan, &printed);
    report.marked(&sources.plan);
    Ok(Built { city: Arc::new(city), report, trace: network.trace })
}

/// What lies between the streets, up to the stage asked for.
fn derive_land(
    context: &Context,
    network: &Network,
    outlines: &Outlines,
    until: Until,
) -> Result<(Arc<Land>, Buildings), BuildError> {
    let graph = &network.graph;
    let none = || Buildings { all: Arc::default(), origins: network.origins.clone() };
    if until == Until::Streets {
        return Ok((Arc::new(land::derive_blocks(context, graph, outlines)?), none()));
    }
    let ground = Arc::new(CityGround::new(context, graph));
    let land = land::derive(context, graph, outlines, &ground)?;
    if until == Until::Parcels {
        return Ok((land, none()));
    }
    let buildings = stages::buildings::derive(context, &land, &ground, &network.origins)?;
    Ok((land, Arc::unwrap_or_clone(buildings)))
}

fn quarter_area(face: &::streets::faces::Face) -> Option<Area> {
    let polygon = layout::blocks::polygon_of(face);
    (polygon.outer.len() >= 3).then_some(Area { id: face.id, name: None, polygon })
}

fn district_area(area: ::streets::DistrictArea) -> Area {
    Area { id: area.id, name: Some(area.name), polygon: area.polygon }
}

/// Faults one a line, before what they led to.
fn listed(faults: &[script::Fault]) -> String {
    faults.iter().map(|fault| format!("{fault}\n")).collect()
}

fn nothing(sources: &Sources, faults: &Faults) -> BuildError {
    let has_land = sources.has_legal_land();
    let reason = if has_land { "no street could grow or be imported" } else { "the site has no land to build on" };
    let faults = faults.sorted();
    let hint = if faults.iter().any(|fault| fault.severity == Severity::Error) {
        "mend the rule first: where it fails, streets end"
    } else if !faults.is_empty() {
        "the warnings say why: streets grow where a rule proposes them and all constraints agree"
    } else if has_land {
        "check that the city has `given`, `imported`, `highways`, `majors` or `minors`, and that goals ask for streets somewhere"
    } else {
        "check the `land` map and the `within` mask: white is land, black is water"
    };
    BuildError::Nothing { faults, reason: reason.into(), hint: hint.into() }
}
