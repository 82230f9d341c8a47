//! Buildings: one parcel at a time.

use super::land::{Land, inner_place};
use super::{ByPlace, Context, Origins};
use crate::{BuildError, Stage};
use buildings::{Building, Envelope, LEAST_HEIGHT, StartShape, extrude, main_front};
use geom::polygon::min_area_box;
use geom::{Id, Point, Polygon, Raster, Vec2};
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
    let district = context.district(place);
    let (pattern, origin) = patterns.at(quarter, &district)?;
    let density = context.density(place);
    let max_height = context.sources.site.map("max_height").map_or(f64::INFINITY, |map| lowest(map, &parcel.polygon));
    let fronts: Vec<bool> = parcel.sides.iter().map(Option::is_some).collect();
    let choice = pattern.choose(ShapeContext {
        area: parcel.polygon.area(),
        extent: extent(&parcel.polygon, &fronts),
        is_corner: is_corner(parcel),
        streets: land.ground.sides(&parcel.access),
        density,
        max_height,
        place,
        district,
        landmark: land.landmark_of(parcel.id),
        ground: land.ground.clone(),
        seed: context.seed(quarter).purpose("buildings").of(parcel.id),
    });
    let BuildingChoice::Extrude(envelope) = choice else { return None };
    if max_height < LEAST_HEIGHT {
        return None;
    }
    let shape = StartShape {
        parcel: parcel.id,
        outline: parcel.polygon.clone(),
        fronts,
        density,
        ground: ground(context, &parcel.polygon),
    };
    // Whatever a rule asks for, the map of greatest heights holds.
    let envelope = Envelope { height: envelope.height.min(max_height), ..envelope };
    extrude(&shape, &envelope).map(|building| Building { origin: *origin, ..building })
}

/// How far an outline reaches along its longest front and square to it; the smallest rectangle where it has none.
fn extent(outline: &Polygon, fronts: &[bool]) -> Vec2 {
    let Some(along) = main_front(&outline.outer, fronts) else { return min_area_box(&outline.outer).half * 2.0 };
    let base = outline.outer.first().map_or(Vec2::ZERO, |p| p.metres());
    let reach = |axis: Vec2| {
        let of = outline.outer.iter().map(|p| axis.dot(p.metres() - base));
        let (low, high) = of.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
        high - low
    };
    Vec2::new(reach(along), reach(along.perp()))
}

/// Two fronts that meet at less than this cosine make a corner: they turn by more than 30°.
const CORNER: f64 = 0.866;

/// Whether two streets meet at a corner of the parcel.
fn is_corner(parcel: &Parcel) -> bool {
    let (ring, sides) = (&parcel.polygon.outer, &parcel.sides);
    let n = ring.len();
    let along = |i: usize| (ring[(i + 1) % n].metres() - ring[i % n].metres()).normalize_or_zero();
    let meet = |i: usize| match (sides.get(i), sides.get((i + 1) % n)) {
        (Some(Some(a)), Some(Some(b))) => a != b && along(i).dot(along(i + 1)) < CORNER,
        _ => false,
    };
    (0..n).any(meet)
}

/// The least value of a map's cells that lie under an outline.
fn lowest(map: &Raster, outline: &Polygon) -> f64 {
    let Some(bounds) = outline.bounds() else { return f64::INFINITY };
    let step = map.pixel_size();
    let (low, high) = (bounds.min.metres() - map.origin(), bounds.max.metres() - map.origin());
    let cells = |low: f64, high: f64| (low / step).floor() as i64..=(high / step).floor() as i64;
    let centre = |x: i64, y: i64| map.origin() + (Vec2::new(x as f64, y as f64) + 0.5) * step;
    let inner = cells(low.x, high.x).flat_map(|x| cells(low.y, high.y).map(move |y| centre(x, y)));
    let inner = inner.filter(|&place| outline.contains(Point::from_metres(place)));
    let rim = outline.edges().flat_map(|(a, b)| {
        let parts = (2.0 * a.distance(b) / step).ceil().max(1.0) as u32;
        (0..parts).map(move |k| a.metres().lerp(b.metres(), f64::from(k) / f64::from(parts)))
    });
    inner.chain(rim).map(|place| map.nearest(place)).fold(f64::INFINITY, f64::min)
}

/// Lowest and highest ground on an outline, metres.
fn ground(context: &Context, outline: &Polygon) -> (f64, f64) {
    let heights = outline.outer.iter().map(|corner| context.sources.site.elevation(corner.metres()));
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
}
