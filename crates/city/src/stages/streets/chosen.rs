//! Which quarters a stage fills, and which land outside them.

use super::Context;
use crate::report::StreetsReport;
use geom::{Point, Seed, Vec2};
use script::{StreetPlan, Within};
use std::sync::Arc;
use streets::StreetGraph;
use streets::faces::{Face, Faces};
use streets::growth::{Fields, rim_mask};

/// The quarters that a plan fills, in their order: all, unless it chooses.
pub(super) fn of<'a>(
    context: &Context,
    plan: &StreetPlan,
    quarters: &'a Faces,
    report: &mut StreetsReport,
) -> Vec<&'a Face> {
    match &plan.within {
        Some(Within::QuartersAt(places)) => at(places, quarters, report),
        Some(Within::QuartersIn(names)) => inside(context, names, quarters, report),
        Some(Within::Map(_) | Within::Polygon(_)) | None => quarters.faces.iter().collect(),
    }
}

/// The quarters that contain one of some places.
fn at<'a>(places: &[Vec2], quarters: &'a Faces, report: &mut StreetsReport) -> Vec<&'a Face> {
    let polygons: Vec<_> = quarters.faces.iter().map(Face::polygon).collect();
    let mut is_chosen = vec![false; polygons.len()];
    for &place in places {
        let found = polygons.iter().position(|polygon| polygon.contains(Point::from_metres(place)));
        match found {
            Some(quarter) => is_chosen[quarter] = true,
            None => report.warn(format!("`minors.within`: no quarter lies at [{}, {}]", place.x, place.y)),
        }
    }
    quarters.faces.iter().zip(is_chosen).filter_map(|(face, is_chosen)| is_chosen.then_some(face)).collect()
}

/// The quarters whose middle lies in one of some districts.
fn inside<'a>(context: &Context, names: &[String], quarters: &'a Faces, report: &mut StreetsReport) -> Vec<&'a Face> {
    let district = |face: &Face| context.district(super::super::land::inner_place(&face.polygon()));
    let districts: Vec<String> = quarters.faces.iter().map(district).collect();
    for name in names.iter().filter(|name| !districts.contains(name)) {
        report.warn(format!("`minors.within`: no quarter has its middle in the district `{name}`"));
    }
    let all = quarters.faces.iter().zip(&districts);
    all.filter(|(_, district)| names.contains(district)).map(|(face, _)| face).collect()
}

/// What streets outside all quarters can know of the site: the same, but for the rim that holds them. `None` where none
/// shall grow there.
pub(super) fn outside(
    context: &Context,
    graph: &StreetGraph,
    plan: &StreetPlan,
    fields: &Arc<Fields>,
    report: &mut StreetsReport,
) -> Option<Arc<Fields>> {
    if plan.within.as_ref().is_some_and(Within::chooses_quarters) {
        return None;
    }
    let Some(rim) = plan.rim else { return Some(fields.clone()) };
    if rim.width <= 0.0 {
        return None;
    }
    let seed = Seed(context.sources.plan.seed).purpose("rim");
    let Some(mask) = rim_mask(graph, fields, rim.width, rim.bulge, seed) else {
        report.warn("`minors.rim` has no effect: no highway or major is there to lie around".into());
        return Some(fields.clone());
    };
    let mut own = Fields::clone(fields);
    own.zones.hold_inside_mask(Arc::new(mask));
    Some(Arc::new(own))
}
