//! A parcel as rules see it.

use super::Context;
use super::ground::CityGround;
use super::land::inner_place;
use buildings::main_front;
use geom::polygon::min_area_box;
use geom::{Point, Polygon, Raster, Seed, Vec2};
use layout::Parcel;
use script::ShapeContext;
use std::sync::Arc;

/// What rules may know of a parcel; landmarks are told apart.
pub(super) fn of_parcel(context: &Context, ground: &Arc<CityGround>, parcel: &Parcel, seed: Seed) -> ShapeContext {
    let place = inner_place(&parcel.polygon);
    let max_height = context.sources.site.map("max_height").map_or(f64::INFINITY, |map| lowest(map, &parcel.polygon));
    ShapeContext {
        area: parcel.polygon.area(),
        extent: extent(&parcel.polygon, &fronts(parcel)),
        is_corner: is_corner(parcel),
        streets: ground.sides(&parcel.access),
        density: context.density(place),
        max_height,
        place,
        district: context.district(place),
        landmark: String::new(),
        tags: parcel.tags.clone(),
        ground: ground.clone(),
        seed,
    }
}

/// For each edge of a parcel's outline whether it lies on a street.
pub(super) fn fronts(parcel: &Parcel) -> Vec<bool> {
    parcel.sides.iter().map(Option::is_some).collect()
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
