//! Growth on the land that no quarter encloses, e.g. between the outermost majors and a shore.
//!
//! Like a quarter it grows in a graph of its own, which holds the streets that close quarters and nothing that grew in
//! any; so it is independent of the quarters, and they of it.

use super::kernel::Grower;
use super::quarter::candidates;
use super::{Attachment, Fields, GrowthLog, GrowthRules, Home, Keeps, QuarterGrowth, QuarterSettings, SeedPoint};
use crate::faces::Faces;
use crate::{HalfKey, StreetGraph};
use geom::point::units;
use geom::polygon::Location;
use geom::{Angle, Bounds, Id, Point, Polygon};
use std::sync::Arc;

/// Grows streets outside all quarters of a graph that has no streets grown inside them yet; a pure function of both.
/// `quarters` must be the quarter faces of `graph`.
pub fn grow_outside(
    graph: &StreetGraph,
    quarters: &Faces,
    settings: &QuarterSettings,
    rules: &dyn GrowthRules,
    fields: &Arc<Fields>,
    cancel: &dyn Fn() -> bool,
) -> QuarterGrowth {
    let mut private = graph.clone();
    let enclosed = Enclosed::by(quarters);
    let home = Home { at: fields.middle(), heading: Angle::ZERO };
    let mut grower = Grower::new(&mut private, &settings.growth, rules, fields, cancel).at_home(home);
    fill(&mut grower, settings, fields, &enclosed);
    let log = grower.log;
    let attachments = attachments(&private, &log);
    let keeps = Keeps::of(&settings.growth, fields);
    QuarterGrowth { quarter: Id::root("outside all quarters", &[]), log, attachments, keeps, fault: None }
}

/// The land inside quarters.
struct Enclosed(Vec<(Bounds, Polygon)>);

impl Enclosed {
    fn by(quarters: &Faces) -> Self {
        let ring = |sides: &[crate::faces::Side]| sides.iter().map(|side| side.from).collect::<Vec<Point>>();
        let polygon = |face: &crate::faces::Face| Polygon { outer: ring(&face.sides), holes: Vec::new() };
        let with_bounds = |polygon: Polygon| Some((polygon.bounds()?, polygon));
        Self(quarters.faces.iter().map(polygon).filter_map(with_bounds).collect())
    }

    fn has(&self, p: Point) -> bool {
        self.0.iter().any(|(bounds, polygon)| bounds.contains(p) && polygon.locate(p) != Location::Outside)
    }
}

/// How far away a street that closes quarters still says how streets outside them run, in metres.
const NEARBY: f64 = 2000.0;

/// Direction of the nearest street that closes quarters; east where there is none.
fn heading_nearby(graph: &StreetGraph, at: Point) -> Angle {
    let closes =
        |key| graph.segment(key).level == 0 && graph.classes().info(graph.segment(key).class()).closes_quarters;
    let nearest = graph.nearest_segment_where(at, units(NEARBY), closes);
    nearest.map_or(Angle::ZERO, |(key, ..)| {
        let half = if graph.segment(key).leading().forward { key.forward() } else { key.backward() };
        let (from, to) = graph.line(half);
        Angle::of(to.metres() - from.metres())
    })
}

/// Plants seeds wherever legal land that streets are wanted on lies far from all of them, and lets them grow.
fn fill(grower: &mut Grower, settings: &QuarterSettings, fields: &Fields, enclosed: &Enclosed) {
    let root = settings.growth.root.with(&[Id::root("outside growth", &[]).0]);
    let (reseed, clearance) = (units(settings.reseed), units(settings.clearance));
    let is_free = |graph: &StreetGraph, p: Point, distance: i32| {
        graph.nearest_segment(p, distance, 0).is_none() && !enclosed.has(p)
    };
    grower.take_up_all(root, &|p| !enclosed.has(p));
    let mut ordinal = 0;
    for at in candidates(fields.bounds, settings.reseed) {
        if grower.log.stopped.is_some() {
            return;
        }
        let place = at.metres();
        let is_wanted = fields.is_legal(place) && settings.growth.goal.is_met(place);
        if !is_wanted || !is_free(grower.graph, at, reseed.max(clearance)) {
            continue;
        }
        let heading = heading_nearby(grower.graph, at);
        grower.tip.home = Home { at: place, heading };
        let seed = SeedPoint { at, heading, root: root.child(ordinal) };
        if grower.plant(&seed, &|graph, p| is_free(graph, p, clearance)) {
            ordinal += 1;
            grower.run();
        }
    }
}

/// Where grown streets meet those that close quarters, corners left out.
fn attachments(private: &StreetGraph, log: &GrowthLog) -> Vec<Attachment> {
    let closes = |half: HalfKey| {
        let claims = private.segment(half.segment()).claims();
        claims.iter().find(|claim| private.classes().info(claim.class).closes_quarters)
    };
    let ends = log.accepted.iter().enumerate().filter(|(_, accepted)| accepted.outcome.ends_street());
    ends.filter_map(|(line, accepted)| {
        let key = private.find_node(accepted.end_id())?;
        let arms = private.halves_ccw(key);
        let mut rims: Vec<_> = arms.iter().filter_map(|&arm| closes(arm)).map(|claim| claim.street).collect();
        rims.sort_unstable();
        rims.dedup();
        // Where several such streets meet there is a crossing already.
        let [street] = rims.as_slice() else { return None };
        let own = |arm: &HalfKey| {
            let claims = private.segment(arm.segment()).claims();
            claims.iter().any(|claim| claim.street == accepted.lineage.street)
        };
        let hinge = private.target(arms.iter().copied().find(own)?);
        Some(Attachment {
            line,
            street: *street,
            side: 0,
            at: private.at(key),
            node: private.node(key).id,
            hinge: private.at(hinge),
            hinge_node: private.node(hinge).id,
        })
    })
    .collect()
}
