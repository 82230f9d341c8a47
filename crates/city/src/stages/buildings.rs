//! Buildings: one parcel at a time.

use super::land::Land;
use super::{ByPlace, Context, Origins};
use crate::{BuildError, Stage};
use buildings::{Building, StartShape, extrude};
use geom::{Id, Polygon};
use layout::{Parcel, Use};
use rayon::prelude::*;
use script::{BuildingChoice, BuildingPattern, Rule, ShapeContext};
use std::collections::BTreeMap;

/// Derives the buildings of all parcels that may carry one, by id.
pub(crate) fn derive(context: &Context, land: &Land, origins: &mut Origins) -> Result<Vec<Building>, BuildError> {
    let plan = &context.sources.plan;
    let rules: Vec<&Rule> = plan.buildings.iter().chain(plan.district_buildings.values()).collect();
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
            raise(context, &patterns, parcel, quarter)
        })
        .collect();
    context.check()?;
    all.sort_by_key(|building| building.id);
    context.progress.end(Stage::Buildings, &format!("{} buildings", all.len()));
    Ok(all)
}

fn raise(
    context: &Context,
    patterns: &ByPlace<(BuildingPattern, u16)>,
    parcel: &Parcel,
    quarter: Option<Id>,
) -> Option<Building> {
    let place = parcel.polygon.centroid();
    let district = context.district(place);
    let (pattern, origin) = patterns.at(quarter, &district)?;
    let site = &context.sources.site;
    let density = context.density(place);
    let choice = pattern.choose(ShapeContext {
        area: parcel.polygon.area(),
        frontage: parcel.access.iter().map(|(_, length)| length).sum(),
        density,
        max_height: site.map("max_height").map_or(f64::INFINITY, |map| map.nearest(place)),
        place,
        district,
        seed: context.seed(quarter).purpose("buildings").of(parcel.id),
    });
    let BuildingChoice::Extrude { height, setback } = choice else { return None };
    let shape = StartShape {
        parcel: parcel.id,
        outline: parcel.polygon.clone(),
        density,
        ground: ground(context, &parcel.polygon),
    };
    extrude(&shape, height, setback).map(|building| Building { origin: *origin, ..building })
}

/// Lowest and highest ground on an outline, metres.
fn ground(context: &Context, outline: &Polygon) -> (f64, f64) {
    let heights = outline.outer.iter().map(|corner| context.sources.site.elevation(corner.metres()));
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
}
