//! Buildings: one parcel at a time.

use super::land::{Land, inner_place};
use super::{ByPlace, Context, Origins, shape};
use crate::{BuildError, Stage};
use buildings::{Building, Envelope, LEAST_HEIGHT, StartShape, extrude};
use geom::{Id, Polygon};
use layout::{Parcel, Use};
use rayon::prelude::*;
use script::{BuildingChoice, BuildingPattern, Plan, Rule, ShapeContext};
use std::collections::BTreeMap;

/// Derives the buildings of all parcels that may carry one, by id.
pub(crate) fn derive(context: &Context, land: &Land, origins: &mut Origins) -> Result<Vec<Building>, BuildError> {
    let plan = &context.sources.plan;
    let own: Vec<Plan> = plan.quarters.keys().map(|&id| plan.in_quarter(Some(id)).into_owned()).collect();
    let plans = std::iter::once(plan).chain(&own);
    let rules: Vec<&Rule> =
        plans.flat_map(|plan| plan.buildings.iter().chain(plan.district_buildings.values())).collect();
    if rules.is_empty() {
        origins.of("plain");
        return Ok(Vec::new());
    }
    let numbers: BTreeMap<&str, u16> = rules.into_iter().map(|rule| (rule.name(), origins.of(rule.name()))).collect();
    let patterns = ByPlace::of(context, "buildings", |rule| {
        let origin = numbers.get(rule.name()).copied().unwrap_or_default();
        (BuildingPattern::new(rule, context.faults.clone()), origin)
    });
    let quarter_of: BTreeMap<Id, Option<Id>> = land.blocks.iter().map(|block| (block.id, block.quarter)).collect();
    context.progress.begin(Stage::Buildings, land.parcels.len() as u64);
    let mut all: Vec<Building> = land
        .parcels
        .par_iter()
        .filter_map(|parcel| {
            context.progress.advance(1);
            if parcel.usage != Use::Built || context.cancel.is_cancelled() {
                return None;
            }
            let quarter = quarter_of.get(&parcel.block).copied().flatten();
            raise(context, land, &patterns, parcel, quarter)
        })
        .collect();
    context.check()?;
    all.sort_by_key(|building| building.id);
    context.progress.end(Stage::Buildings, &format!("{} buildings", all.len()));
    Ok(all)
}

fn raise(
    context: &Context,
    land: &Land,
    patterns: &ByPlace<(BuildingPattern, u16)>,
    parcel: &Parcel,
    quarter: Option<Id>,
) -> Option<Building> {
    let place = inner_place(&parcel.polygon);
    let (pattern, origin) = patterns.at(quarter, &context.district(place))?;
    let seed = context.seed(quarter).purpose("buildings").of(parcel.id);
    let shape = shape::of_parcel(context, &land.ground, parcel, seed);
    let (density, max_height) = (shape.density, shape.max_height);
    let choice = pattern.choose(ShapeContext { landmark: land.landmark_of(parcel.id), ..shape });
    let BuildingChoice::Extrude(envelope) = choice else { return None };
    if max_height < LEAST_HEIGHT {
        return None;
    }
    let shape = StartShape {
        parcel: parcel.id,
        outline: parcel.polygon.clone(),
        fronts: shape::fronts(parcel),
        density,
        ground: ground(context, &parcel.polygon),
    };
    // Whatever a rule asks for, the map of greatest heights holds.
    let envelope = Envelope { height: envelope.height.min(max_height), ..envelope };
    extrude(&shape, &envelope).map(|building| Building { origin: *origin, ..building })
}

/// Lowest and highest ground on an outline, metres.
fn ground(context: &Context, outline: &Polygon) -> (f64, f64) {
    let heights = outline.outer.iter().map(|corner| context.sources.site.elevation(corner.metres()));
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
}
