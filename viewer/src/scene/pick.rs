//! What lies under the pointer.

use city::City;
use geom::{Id, Point, Polygon, Vec2, Vec3};

/// Something of a city.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    /// What it is.
    pub kind: ElementKind,
    /// Its id in `layout.geojson`.
    pub id: Id,
}

/// The kinds of things that can be picked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ElementKind {
    /// A building.
    Building,
    /// A street between two crossings.
    Street,
    /// A parcel.
    Parcel,
    /// A block.
    Block,
    /// A quarter.
    Quarter,
}

impl ElementKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Building, Self::Street, Self::Parcel, Self::Block, Self::Quarter];

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Building => "building",
            Self::Street => "street",
            Self::Parcel => "parcel",
            Self::Block => "block",
            Self::Quarter => "quarter",
        }
    }
}

/// What lies at a place, from the smallest to the largest.
pub fn at(city: &City, place: Vec2) -> Vec<Element> {
    let Some(point) = Point::try_from_metres(place) else { return Vec::new() };
    let covers = |polygon: &Polygon| polygon.locate(point) != geom::polygon::Location::Outside;
    let element = |kind, id| Element { kind, id };
    let mut found = Vec::new();
    let building = city.buildings.iter().find(|building| covers(&building.footprint));
    found.extend(building.map(|building| element(ElementKind::Building, building.id)));
    let street =
        city.runs.iter().filter(|run| distance(city, run, place) <= f64::from(run.half_width) / Point::UNITS_PER_METRE);
    // What lies on top is what one sees.
    let street = street.max_by_key(|run| (run.level, std::cmp::Reverse(run.class)));
    found.extend(street.map(|run| element(ElementKind::Street, run.id)));
    let parcel = city.parcels.iter().find(|parcel| covers(&parcel.polygon));
    found.extend(parcel.map(|parcel| element(ElementKind::Parcel, parcel.id)));
    let block = city.blocks.iter().find(|block| covers(&block.polygon));
    found.extend(block.map(|block| element(ElementKind::Block, block.id)));
    let quarter = city.quarters.iter().find(|quarter| covers(&quarter.polygon));
    found.extend(quarter.map(|quarter| element(ElementKind::Quarter, quarter.id)));
    found
}

/// Metres from a place to the middle of a street.
fn distance(city: &City, run: &streets::runs::Run, place: Vec2) -> f64 {
    let pieces = run.nodes.windows(2).map(|pair| {
        let (a, b) = (city.graph.at(pair[0]).metres(), city.graph.at(pair[1]).metres());
        let along = b - a;
        let share = ((place - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        (a + along * share).distance(place)
    });
    pieces.fold(f64::INFINITY, f64::min)
}

/// Where a ray first meets a building or the ground.
pub fn near_ray(city: &City, from: Vec3, way: Vec3) -> Option<Vec2> {
    let roof = city.buildings.iter().filter_map(|building| {
        let top = building.ground.1 + building.height;
        let along = entry(building, from, way, (building.ground.0, top))?;
        Some(along)
    });
    let ground = on_ground(city, from, way);
    let along = roof.chain(ground).min_by(f64::total_cmp)?;
    let place = from + way * (along + 0.01);
    Some(place.truncate())
}

/// How far along a ray it enters a building.
fn entry(building: &buildings::Building, from: Vec3, way: Vec3, (low, high): (f64, f64)) -> Option<f64> {
    let heights = |z: f64| (z - from.z) / way.z;
    let (enter, leave) = if way.z.abs() < 1e-9 {
        ((low..=high).contains(&from.z)).then_some((0.0, f64::INFINITY))?
    } else {
        let (a, b) = (heights(high), heights(low));
        (a.min(b).max(0.0), a.max(b))
    };
    let corners = building.footprint.outer.iter().map(|p| p.metres());
    let (least, most) = corners.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, m), p| (l.min(p), m.max(p)));
    // Between the heights the ray runs over the plane: it meets the building where it first lies over its box.
    let (mut near, mut far) = (enter, leave);
    for (start, step, low, high) in [(from.x, way.x, least.x, most.x), (from.y, way.y, least.y, most.y)] {
        if step.abs() < 1e-12 {
            if !(low..=high).contains(&start) {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - start) / step, (high - start) / step);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    (near <= far).then_some(near)
}

/// Steps of the search for the ground.
const STEPS: u32 = 400;

/// How far along a ray it meets the ground.
fn on_ground(city: &City, from: Vec3, way: Vec3) -> Option<f64> {
    let above = |along: f64| {
        let place = from + way * along;
        place.z - city.site.elevation(place.truncate())
    };
    if way.z >= 0.0 || above(0.0) < 0.0 {
        return None;
    }
    let far = ((from.z + 500.0) / -way.z).min(400_000.0);
    let step = far / f64::from(STEPS);
    let hit = (1..=STEPS).map(|i| f64::from(i) * step).find(|&along| above(along) <= 0.0)?;
    let (mut low, mut high) = (hit - step, hit);
    for _ in 0..30 {
        let middle = (low + high) / 2.0;
        if above(middle) > 0.0 { low = middle } else { high = middle }
    }
    Some(high)
}
