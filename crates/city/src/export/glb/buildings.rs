//! Buildings as walls and roofs; parks and plazas as coloured ground.

use super::terrain::{ERROR_M, Terrain};
use super::tiles::{ByTile, Meshes};
use super::{GREEN_LIFT_M, Group, Surface, TileKey, push_corners};
use crate::City;
use buildings::Building;
use geom::triangulate::triangulate;
use geom::{Point, Polygon, Vec2};
use layout::{Parcel, Use};

/// The buildings of a city.
pub fn buildings(city: &City) -> ByTile<&Building> {
    by_tile(city.buildings.iter(), |building| &building.footprint)
}

/// Its parks and plazas.
pub fn green(city: &City) -> ByTile<&Parcel> {
    by_tile(city.parcels.iter().filter(|parcel| surface_of(parcel).is_some()), |parcel| &parcel.polygon)
}

fn by_tile<'a, T>(things: impl IntoIterator<Item = &'a T>, ground: impl Fn(&T) -> &Polygon) -> ByTile<&'a T> {
    let mut tiles = ByTile::<&T>::new();
    for thing in things {
        if let Some(first) = ground(thing).outer.first() {
            tiles.entry(TileKey::of(first.metres())).or_default().push(thing);
        }
    }
    tiles
}

/// Adds a building: from the lowest ground, less what the terrain may lie below the map, up to its height above the highest
/// ground. One whose footprint has no triangles is left out.
pub fn add(meshes: &mut Meshes, building: &Building) {
    let Ok(roof) = triangulate(&building.footprint) else { return };
    let (base, top) = (building.ground.0 - ERROR_M, building.ground.1 + building.height);
    if !(base.is_finite() && top.is_finite() && base < top) {
        return;
    }
    let origin = meshes.origin;
    meshes.mesh(Group::Buildings, Surface::Wall).push_walls(&building.footprint, base, top, origin);
    meshes.mesh(Group::Buildings, Surface::Roof).push_polygon(&roof, top, origin);
}

fn surface_of(parcel: &Parcel) -> Option<Surface> {
    match parcel.usage {
        Use::Park => Some(Surface::Park),
        Use::Plaza => Some(Surface::Plaza),
        Use::Built | Use::Open => None,
    }
}

/// Adds a park or plaza, laid onto the terrain.
pub fn add_green(meshes: &mut Meshes, terrain: &Terrain, parcel: &Parcel) {
    let (Some(surface), Ok(ground)) = (surface_of(parcel), triangulate(&parcel.polygon)) else { return };
    let origin = meshes.origin;
    for &triangle in &ground.triangles {
        let corners: [Vec2; 3] = ground.corners(triangle).map(Point::metres);
        let mesh = meshes.mesh(Group::Green, surface);
        terrain.drape(&corners, GREEN_LIFT_M, &mut |piece| push_corners(mesh, piece, origin));
    }
}
