//! Buildings: one parcel at a time.

use super::land::Land;
use super::{Context, Origins};
use crate::{BuildError, Stage};
use buildings::{Building, StartShape, extrude};
use geom::{Polygon, Seed};
use layout::{Parcel, Use};
use rayon::prelude::*;
use script::{BuildingChoice, BuildingPattern, ShapeContext};

/// Derives the buildings of all parcels that may carry one, by id.
pub(crate) fn derive(context: &Context, land: &Land, origins: &mut Origins) -> Result<Vec<Building>, BuildError> {
    let rule = context.sources.plan.buildings.clone();
    let origin = origins.of(rule.as_ref().map_or("plain", |rule| rule.name()));
    let Some(rule) = rule else { return Ok(Vec::new()) };
    let pattern = BuildingPattern::new(rule, context.faults.clone());
    context.progress.begin(Stage::Buildings, land.parcels.len() as u64);
    let mut all: Vec<Building> = land
        .parcels
        .par_iter()
        .filter_map(|parcel| {
            context.progress.advance(1);
            if parcel.usage != Use::Built || context.cancel.is_cancelled() {
                return None;
            }
            raise(context, &pattern, parcel, origin)
        })
        .collect();
    context.check()?;
    all.sort_by_key(|building| building.id);
    context.progress.end(Stage::Buildings, &format!("{} buildings", all.len()));
    Ok(all)
}

fn raise(context: &Context, pattern: &BuildingPattern, parcel: &Parcel, origin: u16) -> Option<Building> {
    let place = parcel.polygon.centroid();
    let site = &context.sources.site;
    let density = context.density(place);
    let choice = pattern.choose(ShapeContext {
        area: parcel.polygon.area(),
        frontage: parcel.access.iter().map(|(_, length)| length).sum(),
        density,
        max_height: site.map("max_height").map_or(f64::INFINITY, |map| map.nearest(place)),
        place,
        seed: Seed(context.sources.plan.seed).purpose("buildings").of(parcel.id),
    });
    let BuildingChoice::Extrude { height, setback } = choice else { return None };
    let shape = StartShape { parcel: parcel.id, outline: parcel.polygon.clone(), density, ground: ground(context, &parcel.polygon) };
    extrude(&shape, height, setback).map(|building| Building { origin, ..building })
}

/// Lowest and highest ground on an outline, metres.
fn ground(context: &Context, outline: &Polygon) -> (f64, f64) {
    let heights = outline.outer.iter().map(|corner| context.sources.site.elevation(corner.metres()));
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
}
