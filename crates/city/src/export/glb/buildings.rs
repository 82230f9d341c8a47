//! Buildings as walls and roofs; parks and plazas as coloured ground.

use super::terrain::{ERROR_M, Terrain};
use super::{GREEN_LIFT_M, Group, Meshes, Surface, TileKey, push_corners};
use crate::City;
use buildings::Building;
use geom::triangulate::triangulate;
use geom::{Point, Vec2};
use layout::Use;

/// The meshes of all buildings: from the lowest ground, less what the terrain may lie below the map, up to their height above
/// the highest ground. One whose footprint has no triangles is left out.
pub fn buildings(city: &City) -> Meshes {
    let mut model = Meshes::default();
    city.buildings.iter().for_each(|building| add_building(&mut model, building));
    model
}

fn add_building(model: &mut Meshes, building: &Building) {
    let Some(first) = building.footprint.outer.first() else { return };
    let Ok(roof) = triangulate(&building.footprint) else { return };
    let tile = TileKey::of(first.metres());
    let (base, top) = (building.ground.0 - ERROR_M, building.ground.1 + building.height);
    if !(base.is_finite() && top.is_finite() && base < top) {
        return;
    }
    model.mesh(tile, Group::Buildings, Surface::Wall).push_walls(&building.footprint, base, top, tile.origin());
    model.mesh(tile, Group::Buildings, Surface::Roof).push_polygon(&roof, top, tile.origin());
}

/// Adds parcels that are parks or plazas, laid onto the terrain.
pub fn add_green(model: &mut Meshes, city: &City, terrain: &Terrain) {
    for parcel in &city.parcels {
        let surface = match parcel.usage {
            Use::Park => Surface::Park,
            Use::Plaza => Surface::Plaza,
            Use::Built | Use::Open => continue,
        };
        let (Some(first), Ok(ground)) = (parcel.polygon.outer.first(), triangulate(&parcel.polygon)) else { continue };
        let tile = TileKey::of(first.metres());
        for &triangle in &ground.triangles {
            let corners: [Vec2; 3] = ground.corners(triangle).map(Point::metres);
            let mesh = model.mesh(tile, Group::Green, surface);
            terrain.drape(&corners, GREEN_LIFT_M, &mut |piece| push_corners(mesh, piece, tile.origin()));
        }
    }
}
