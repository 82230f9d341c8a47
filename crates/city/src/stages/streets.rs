//! Streets: given and imported ones, then highways, then majors, then minors quarter by quarter, then what was removed
//! by hand.

mod chosen;
mod seeds;

use super::keep::Silence;
use super::patterns::{overhearing, pattern};
use super::{Context, Origins, landmarks};
use crate::report::StreetsReport;
use crate::sources::{ImportOptions, lay_streets};
use crate::trace::{Grown, Trace};
use crate::{BuildError, Stage};
use geom::point::units;
use geom::{Angle, Digest, Id, Point, Seed};
use rayon::prelude::*;
use script::{DensityGoal, GivenLine, MINOR_WIDTH, StreetPlan, Value, Within};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::faces::{Face, FaceKind, Faces};
use streets::graph::{Crowding, NewSegment, Refusal};
use streets::growth::{
    Attachment, Constraints, Distances, Field, Fields, Goal, Growth, GrowthLog, GrowthRules, Keeps, Own, Peaks,
    QuarterGrowth, QuarterSettings, SeedPoint, Smoothing, Step, Stopped, Zones, attach, grow, grow_from_streets,
    grow_outside, grow_quarter, prune_dead_ends, prune_networks, smooth,
};
use streets::runs::Run;
use streets::{Claim, Class, Classes, NodeId, StreetGraph, StreetId};

/// What a class of streets is when the plan says nothing.
struct ClassDefaults {
    stage: Stage,
    /// Full right-of-way in metres: six lanes with a median; four lanes with sidewalks; two with parking.
    width: f64,
    /// Further seeds are planted farther than this from every street, in metres, so that islands get theirs.
    reseed: f64,
}

fn defaults(class: Class) -> ClassDefaults {
    match class {
        Classes::HIGHWAY => ClassDefaults { stage: Stage::Highways, width: 36.0, reseed: 3000.0 },
        Classes::MAJOR => ClassDefaults { stage: Stage::Majors, width: 26.0, reseed: 900.0 },
        _ => ClassDefaults { stage: Stage::Minors, width: MINOR_WIDTH, reseed: 120.0 },
    }
}

/// The street network, finished or on the way.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Network {
    pub graph: Arc<StreetGraph>,
    pub origins: Origins,
    pub names: BTreeMap<StreetId, String>,
    /// Those that were there before growth, by id: they stay as drawn.
    given: Vec<StreetId>,
    /// What there is to say about it.
    pub report: StreetsReport,
    /// What growth did, where the build is to trace it.
    #[serde(skip)]
    pub trace: Option<Trace>,
}

impl Default for Network {
    /// Without streets.
    fn default() -> Self {
        Self {
            graph: Arc::new(StreetGraph::new(Classes::default())),
            origins: Origins::default(),
            names: BTreeMap::new(),
            given: Vec::new(),
            report: StreetsReport::default(),
            trace: None,
        }
    }
}

impl Network {
    /// Keeps what a stage of growth did, where the build traces it.
    fn traced(&mut self, name: &'static str, grown: Grown) {
        if let Some(trace) = &mut self.trace {
            trace.push(name, grown);
        }
    }
}

/// Derives the street network of a plan.
pub(crate) fn derive(context: &Context) -> Result<Arc<Network>, BuildError> {
    context.stage(
        |keys| keys.streets,
        |silence| {
            let arterials = context.stage(|keys| keys.arterials, |_| derive_arterials(context))?;
            let mut network = Arc::unwrap_or_clone(arterials);
            let fields = Arc::new(fields(context));
            let plan = &context.sources.plan;
            if let Some(minors) = &plan.minors {
                let fields = within(context, Classes::MINOR, minors, &fields);
                let growth = grow_minors(context, &mut network, minors, &fields, silence)?;
                finish(&mut network, &growth, minors, &fields);
                context.check()?;
            }
            for &street in &plan.removed {
                context.check()?;
                if !Arc::make_mut(&mut network.graph).remove_street(street) {
                    network.report.warn(format!("`remove` names street {street}, which is not there"));
                }
            }
            Ok(network)
        },
    )
}

/// The streets that are there before minors.
fn derive_arterials(context: &Context) -> Result<Network, BuildError> {
    let mut network = Network::default();
    import(context, &mut network)?;
    let width = |class| width_of(plan_of(context, class), class);
    landmarks::lay(context, &mut network, width);
    network.trace = context.traces.then(|| Trace::new((*network.graph).clone()));
    network.given = network.graph.streets();
    let fields = Arc::new(fields(context));
    let plan = &context.sources.plan;
    for (class, plan) in [(Classes::HIGHWAY, &plan.highways), (Classes::MAJOR, &plan.majors)] {
        let Some(plan) = plan else { continue };
        let fields = within(context, class, plan, &fields);
        let growth = grow_arterials(context, &mut network, (class, plan), &fields)?;
        finish(&mut network, &growth, plan, &fields);
        context.check()?;
    }
    Ok(network)
}

/// What growth can know of the site.
fn fields(context: &Context) -> Fields {
    let (site, plan) = (&context.sources.site, &context.sources.plan);
    let map = |name: &str| site.map(name).cloned();
    let field = |name: &str, other: f64| map(name).map_or(Field::Constant(other), Field::Map);
    Fields {
        bounds: site.bounds,
        land: map("land"),
        legal: map("land").into_iter().chain(plan.within.as_ref().and_then(|within| map(&within.name))).collect(),
        barred: plan.barred.iter().filter_map(|barred| map(&barred.name)).collect(),
        density: field("density", 1.0),
        elevation: field("elevation", 0.0),
        distances: Distances::default(),
        maps: site.maps.iter().map(|(name, map)| (name.clone(), Field::Map(map.clone()))).collect(),
        districts: site.districts.clone(),
        peaks: Peaks::default(),
        zones: Zones::default(),
    }
}

/// What streets of a class can know of the site: the same, but for an area of their own, and landmarks, from which they
/// keep off by half of their width and which draw highways and majors.
fn within(context: &Context, class: Class, plan: &StreetPlan, fields: &Arc<Fields>) -> Arc<Fields> {
    let landmarks = &context.sources.plan.landmarks;
    if plan.within.is_none() && landmarks.is_empty() {
        return fields.clone();
    }
    let mut own = Fields::clone(fields);
    match &plan.within {
        Some(Within::Map(map)) => own.legal.extend(context.sources.site.map(&map.name).cloned()),
        Some(Within::Polygon(polygon)) => own.zones.hold_inside(polygon),
        // Quarters are chosen when they are there.
        Some(Within::QuartersAt(_) | Within::QuartersIn(_)) | None => {}
    }
    landmarks::mark(landmarks, &mut own, widest(plan, class), class <= Classes::MAJOR);
    Arc::new(own)
}

/// How the streets of a class grow, where they do.
fn plan_of<'a>(context: &Context<'a>, class: Class) -> Option<&'a StreetPlan> {
    let plan = &context.sources.plan;
    match class {
        Classes::HIGHWAY => plan.highways.as_ref(),
        Classes::MAJOR => plan.majors.as_ref(),
        _ => plan.minors.as_ref(),
    }
}

/// Full right-of-way of a class in metres, where nothing else is told.
fn width_of(plan: Option<&StreetPlan>, class: Class) -> f64 {
    plan.and_then(StreetPlan::constant_width).unwrap_or(defaults(class).width)
}

/// The same, the greatest where it differs by place.
fn widest(plan: &StreetPlan, class: Class) -> f64 {
    plan.widths.as_ref().map_or_else(|| width_of(Some(plan), class), |widths| widths.range().1)
}

/// Puts given and imported streets into the graph.
fn import(context: &Context, network: &mut Network) -> Result<(), BuildError> {
    let plan = &context.sources.plan;
    let total = plan.given.len() + context.sources.imports.len();
    if total == 0 {
        return Ok(());
    }
    context.progress.begin(Stage::Import, total as u64);
    for (ordinal, line) in plan.given.iter().enumerate() {
        context.check()?;
        lay_given(network, line, ordinal);
        context.progress.advance(1);
    }
    for file in &context.sources.imports {
        context.check()?;
        let origin = network.origins.of(&format!("import {}", file.key));
        let options = ImportOptions { origin, ..ImportOptions::new(&file.key) };
        let log = lay_streets(Arc::make_mut(&mut network.graph), &file.streets, &options);
        network.names.extend(log.names.iter().map(|(id, name)| (*id, name.clone())));
        network.report.imported(&file.key, &log, &file.left_out);
        context.progress.advance(1);
    }
    let outcome =
        format!("{} segments, {:.1} km", network.graph.segment_count(), network.graph.total_length() / 1000.0);
    context.progress.end(Stage::Import, &outcome);
    Ok(())
}

/// Lays a street drawn in the script, point by point.
fn lay_given(network: &mut Network, line: &GivenLine, ordinal: usize) {
    let id = Id::root("given street", &[ordinal as u128]);
    let street = StreetId(id);
    let width = line.width.unwrap_or(defaults(line.class).width);
    let origin = network.origins.of("given");
    let claim = Claim { street, class: line.class, half_width: units(width / 2.0), origin, forward: true };
    for (i, pair) in line.points.windows(2).enumerate() {
        let new = NewSegment {
            from: Point::from_metres(pair[0]),
            to: Point::from_metres(pair[1]),
            from_id: NodeId(id.child(i as u64)),
            to_id: NodeId(id.child(i as u64 + 1)),
            claim,
            level: 0,
        };
        if let Err(refusal) = Arc::make_mut(&mut network.graph).insert(&new, Crowding::Join) {
            network.report.warn(format!("given street {}, piece {}: {refusal}", ordinal + 1, i + 1));
        }
    }
    if let Some(name) = &line.name {
        network.names.insert(street, name.clone());
    }
}

/// How streets of a plan grow, with its parameters as they are.
fn growth_of(
    context: &Context,
    network: &Network,
    plan: &StreetPlan,
    class: Class,
    seed: Seed,
) -> Result<Growth, BuildError> {
    let is_major = class <= Classes::MAJOR;
    let width = width_of(Some(plan), class);
    let root = Id::root(defaults(class).stage.name(), &[]);
    let mut growth = Growth::new(class, units(width / 2.0), seed, root);
    growth.widths = plan.widths.clone();
    growth.sprouts = plan.sprout;
    growth.records_refusals = context.traces;
    let standard = if is_major { Constraints::majors() } else { Constraints::default() };
    let own = overhearing(network);
    growth.constraints = plan.chain_with(standard.into(), &Arc::default(), context.faults, &own)?;
    if let Some(goal) = plan.goal()? {
        growth.goal = goal_of(context, &goal);
    }
    if is_major {
        growth.goal.density = landmarks::raised(&context.sources.plan.landmarks, &growth.goal.density);
    }
    Ok(growth)
}

fn goal_of(context: &Context, goal: &DensityGoal) -> Goal {
    match context.sources.site.map(&goal.map.name) {
        Some(map) => {
            let places = context.sources.site.places();
            let number = |value: &Value| places.number(value);
            let fitted = Goal::of(Field::Map(map.clone()), number(&goal.least), number(&goal.pace));
            let full = goal.full.as_ref().map_or(fitted.full, number);
            Goal { full, consume: goal.consume, ..fitted }
        }
        None => Goal::none(),
    }
}

/// Highways or majors: one derivation after another in the city's graph. First the given streets of the class go on,
/// then growth starts from the seeds, as long as they lie far from all streets.
fn grow_arterials(
    context: &Context,
    network: &mut Network,
    (class, plan): (Class, &StreetPlan),
    fields: &Arc<Fields>,
) -> Result<Growth, BuildError> {
    let ClassDefaults { stage, reseed, .. } = defaults(class);
    context.progress.begin(stage, 0);
    let seed = Seed(context.sources.plan.seed).purpose(stage.name());
    let growth = growth_of(context, network, plan, class, seed)?;
    let rules = pattern(context, network, &plan.pattern, None);
    let cancel = || context.cancel.is_cancelled();
    let log = grow_from_streets(Arc::make_mut(&mut network.graph), &growth, &*rules, fields, &cancel);
    network.report.grown(stage.name(), &log);
    let mut logs: Vec<_> = context.traces.then_some(log).into_iter().collect();
    let reseed = plan.reseed.unwrap_or(reseed);
    let mut ordinal = 0;
    for place in seeds::of(context, class, plan, fields, &growth.goal, reseed) {
        context.check()?;
        if network.graph.nearest_segment(place, units(reseed), 0).is_some() {
            continue;
        }
        let point = SeedPoint { at: place, heading: Angle::ZERO, root: growth.root.child(ordinal) };
        let log = grow(Arc::make_mut(&mut network.graph), &growth, &*rules, fields, &[point], &cancel);
        ordinal += u64::from(!log.accepted.is_empty());
        network.report.grown(stage.name(), &log);
        logs.extend(context.traces.then_some(log));
    }
    // Where no street was drawn to a landmark by itself, one starts there, in the last of these stages.
    let is_last = class == Classes::MAJOR || context.sources.plan.majors.is_none();
    for landmark in landmarks::drawing(&context.sources.plan.landmarks).into_iter().filter(|_| is_last) {
        for gate in landmarks::gates(landmark, widest(plan, class), growth.root) {
            context.check()?;
            if landmarks::is_reached(landmark, &network.graph) {
                break;
            }
            let log = grow(Arc::make_mut(&mut network.graph), &growth, &*rules, fields, &[gate], &cancel);
            network.report.grown(stage.name(), &log);
            logs.extend(context.traces.then_some(log));
        }
    }
    network.traced(stage.name(), Grown::InCity(logs));
    context.check()?;
    let outcome =
        format!("{} segments, {:.1} km", network.graph.segment_count(), network.graph.total_length() / 1000.0);
    context.progress.end(stage, &outcome);
    Ok(growth)
}

/// What is done to the streets of a class once all have grown.
fn finish(network: &mut Network, growth: &Growth, plan: &StreetPlan, fields: &Fields) {
    let class = growth.class;
    let (graph, given) = (Arc::make_mut(&mut network.graph), &network.given);
    let is_given = |graph: &StreetGraph, run: &Run| {
        let claims = run.nodes.windows(2).filter_map(|pair| graph.segment_between(pair[0], pair[1], run.level));
        let mut streets = claims.flat_map(|key| graph.segment(key).claims()).map(|claim| claim.street);
        streets.any(|street| given.binary_search(&street).is_ok())
    };
    if plan.least_dead_end > 0.0 {
        prune_dead_ends(graph, class, plan.least_dead_end, &is_given);
    }
    if plan.least_network > 0.0 {
        prune_networks(graph, class, plan.least_network, &is_given);
    }
    if plan.smooth.unwrap_or(class == Classes::HIGHWAY) {
        smooth(graph, growth, fields, &Smoothing::default(), &|graph, run| !is_given(graph, run));
    }
    if let Some(trace) = &mut network.trace {
        trace.finish(&network.graph);
    }
}

/// Minors: every quarter by itself, many at once; then what lies outside all quarters; attached in the order of ids.
fn grow_minors(
    context: &Context,
    network: &mut Network,
    plan: &StreetPlan,
    fields: &Arc<Fields>,
    silence: &Silence,
) -> Result<Growth, BuildError> {
    let quarters = Faces::of(&network.graph, FaceKind::Quarter);
    context.progress.begin(Stage::Minors, quarters.faces.len() as u64 + 1);
    let is_there = |id: &Id| quarters.faces.binary_search_by_key(id, |face| face.id).is_ok();
    for id in context.sources.plan.quarters.keys().filter(|id| !is_there(id)) {
        network.report.warn(format!("`quarters` names quarter {id}, which is not there"));
    }
    let outside = Quarter::new(context, network, plan, None)?;
    let choice = chosen::of(context, plan, &quarters, &mut network.report);
    let outskirts = chosen::outside(context, &network.graph, plan, fields, &mut network.report);
    let faces: Vec<(&Face, Quarter)> = choice
        .into_iter()
        .map(|face| Ok((face, Quarter::new(context, network, plan, Some(face.id))?)))
        .collect::<Result<_, BuildError>>()?;
    let graph = &network.graph;
    let cancel = || context.cancel.is_cancelled();
    let fill = |(face, quarter): &(&Face, Quarter)| {
        let grow = || grow_quarter(graph, face, &quarter.settings, &*quarter.rules, fields, &cancel);
        let grown = silence.over(|| quarter.grown(context, fields, grow));
        context.progress.advance(1);
        grown
    };
    let fill_outside = |fields: &Arc<Fields>| {
        let grow = || grow_outside(graph, &quarters, &outside.settings, &*outside.rules, fields, &cancel);
        silence.over(|| outside.grown(context, fields, grow))
    };
    let (mut grown, rim): (Vec<QuarterGrowth>, Option<QuarterGrowth>) =
        rayon::join(|| faces.par_iter().map(fill).collect(), || outskirts.as_ref().map(fill_outside));
    context.check()?;
    grown.extend(rim);
    let merge = attach(Arc::make_mut(&mut network.graph), &grown, &cancel);
    context.check()?;
    for growth in &grown {
        network.report.grown("minors", &growth.log);
    }
    network.report.merged(&merge);
    let outcome = format!(
        "{} segments in {} quarters and outside them, {:.1} km in all",
        merge.laid,
        faces.len(),
        network.graph.total_length() / 1000.0
    );
    context.progress.end(Stage::Minors, &outcome);
    network.traced(Stage::Minors.name(), Grown::InQuarters { growths: grown, merge });
    Ok(outside.settings.growth)
}

/// How one quarter is filled: the plan, with what differs there.
struct Quarter {
    settings: QuarterSettings,
    rules: Box<dyn GrowthRules + Send>,
    /// What its streets are kept by.
    key: Option<Id>,
}

/// What grew in a quarter, without what it keeps to: that holds rules, which are new ones in each build.
#[derive(Clone)]
struct KeptGrowth {
    quarter: Id,
    log: GrowthLog,
    attachments: Vec<Attachment>,
    fault: Option<Refusal>,
}

impl Quarter {
    fn new(context: &Context, network: &mut Network, plan: &StreetPlan, id: Option<Id>) -> Result<Self, BuildError> {
        let whole = &context.sources.plan;
        let here = whole.in_quarter(id);
        let own = here.minors.as_ref().unwrap_or(plan);
        let seed = id.and_then(|id| whole.seed_in(id)).unwrap_or(whole.seed);
        let seed = Seed(seed).purpose("minors");
        let seed = id.map_or(seed, |id| seed.of(id));
        let growth = growth_of(context, network, own, Classes::MINOR, seed)?;
        let reseed = plan.reseed.unwrap_or(defaults(Classes::MINOR).reseed);
        let settings = QuarterSettings { reseed, ..QuarterSettings::new(growth) };
        let rules = pattern(context, network, &own.pattern, id);
        let key = context.keys.map(|keys| {
            // Streets name their rules by number.
            let origins = own.pattern.parts().iter().map(|part| network.origins.of(part.rule.name()));
            let mut digest = Digest::new("quarter");
            digest.id(keys.arterials).id(plan.digest()).id(own.digest());
            digest.value(&(id, seed, origins.collect::<Vec<_>>()));
            digest.finish()
        });
        Ok(Self { settings, rules, key })
    }

    /// The constraints that rules decide.
    fn own(&self) -> impl Iterator<Item = &Own> {
        self.settings.growth.constraints.steps().iter().filter_map(|step| match step {
            Step::Own(own) => Some(own),
            _ => None,
        })
    }

    /// What grew there, from an earlier build or `grow`.
    fn grown(&self, context: &Context, fields: &Arc<Fields>, grow: impl FnOnce() -> QuarterGrowth) -> QuarterGrowth {
        let make = || {
            let QuarterGrowth { quarter, log, attachments, keeps: _, fault } = grow();
            KeptGrowth { quarter, log, attachments, fault }
        };
        // A rule that did nothing is warned of when all is grown: it must be asked again.
        let is_in_vain = || self.rules.is_in_vain() || self.own().any(|own| own.0.is_in_vain());
        let is_whole = |kept: &KeptGrowth| kept.log.stopped != Some(Stopped::Cancelled) && !is_in_vain();
        let kept = context.part(self.key, is_whole, make);
        if !is_in_vain() {
            self.own().for_each(|own| own.0.has_agreed());
        }
        let KeptGrowth { quarter, log, attachments, fault } = Arc::unwrap_or_clone(kept);
        QuarterGrowth { quarter, log, attachments, keeps: Keeps::of(&self.settings.growth, fields), fault }
    }
}
