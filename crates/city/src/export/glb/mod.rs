//! `city.glb`: terrain, streets and buildings as glTF 2.0 in metres, x east, y up, z south.
//!
//! [`model`] makes the meshes, tile by tile; [`write`] packs them. What lies on the ground is cut along the terrain's
//! own triangles, so that no street sinks into a hill or floats over a hollow.

mod buildings;
mod pack;
mod streets;
mod terrain;
mod tiles;

pub use pack::{GlbError, colour, linear, write};

use crate::{Cache, City};
use geom::{Digest, Id, Mesh, Vec2, Vec3};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;
use terrain::Terrain;
use tiles::Tiles;

/// Side of a tile in metres.
pub const TILE_M: f64 = 1000.0;

/// How far streets lie above the terrain, in metres.
pub const STREET_LIFT_M: f64 = 0.10;

/// How far the cover of a crossing lies above the streets that end there, in metres: it hides how they overlap.
pub const CROSSING_LIFT_M: f64 = 0.02;

/// How far parks and plazas lie above the terrain, in metres.
pub const GREEN_LIFT_M: f64 = 0.05;

/// A tile: column from the west and row from the south of the frame's origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileKey {
    /// From the west.
    pub column: i32,
    /// From the south.
    pub row: i32,
}

/// The kinds of things below a tile, each a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// Ground and water.
    Terrain,
    /// Streets, crossings, bridges.
    Streets,
    /// Parks and plazas.
    Green,
    /// Buildings.
    Buildings,
}

/// What a surface is made of: one material each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Surface {
    /// Bare land.
    Ground,
    /// Water.
    Water,
    /// Parks.
    Park,
    /// Plazas.
    Plaza,
    /// Carriageway of a highway.
    Highway,
    /// Carriageway of a major.
    Major,
    /// Carriageway of a minor.
    Minor,
    /// Sidewalks.
    Sidewalk,
    /// The body of bridges.
    Deck,
    /// Walls.
    Wall,
    /// Roofs.
    Roof,
}

/// The meshes of a tile, around its origin at height 0. Those of one city and the next may be the same ones.
pub type Tile = BTreeMap<(Group, Surface), Arc<Mesh>>;

/// A city as meshes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Its tiles.
    pub tiles: BTreeMap<TileKey, Tile>,
    /// Coordinate reference system of the local frame, and where (0, 0) lies in it, where known.
    pub crs: Option<String>,
    /// See `crs`.
    pub origin: Option<Vec2>,
}

impl Model {
    /// Takes in the meshes of groups that it has none of.
    fn take(&mut self, tiles: &Tiles) {
        for (&key, tile) in tiles.iter().filter(|(_, tile)| !tile.is_empty()) {
            self.tiles.entry(key).or_default().extend(tile.iter().map(|(&place, mesh)| (place, mesh.clone())));
        }
    }
}

/// The meshes of a city. A thing belongs to the tile of its first point, the terrain to the tile it lies in. Where the cache
/// keeps anything, tiles of which nothing changed are not made again.
pub fn model(city: &City, cache: &Cache) -> Model {
    let key = cache.is_on().then(|| terrain_key(city)).flatten();
    let on_ground = || {
        let terrain = cache.part(key, || Terrain::of(city));
        let ground = cache.part(part_key("ground", key), || terrain.tiles());
        let streets = tiles::tiles(&streets::pieces(city), part_key("streets", key), cache, |meshes, piece| {
            piece.add_to(meshes, &terrain);
        });
        let green = tiles::tiles(&buildings::green(city), part_key("green", key), cache, |meshes, parcel| {
            buildings::add_green(meshes, &terrain, parcel);
        });
        [ground, Arc::new(streets), Arc::new(green)]
    };
    let built = || {
        // Buildings know the ground they stand on.
        let base = cache.is_on().then(|| Digest::new("buildings").finish());
        tiles::tiles(&buildings::buildings(city), base, cache, |meshes, building| buildings::add(meshes, building))
    };
    let (on_ground, built) = rayon::join(on_ground, built);
    let mut model = Model { crs: city.site.crs.clone(), origin: city.site.origin, ..Model::default() };
    on_ground.iter().for_each(|tiles| model.take(tiles));
    model.take(&built);
    model
}

/// What tiles of a kind that lie on a terrain are kept by.
fn part_key(kind: &str, terrain: Option<Id>) -> Option<Id> {
    Some(Digest::new(kind).id(terrain?).finish())
}

/// What the terrain under a city is kept by.
fn terrain_key(city: &City) -> Option<Id> {
    let mut digest = Digest::new("terrain");
    digest.id(city.digests.site?).value(&city.graph.bounds());
    Some(digest.finish())
}

/// A corner of a surface: place in metres, height, and the normal there in (east, north, up).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    at: Vec2,
    height: f64,
    normal: Vec3,
}

/// Adds a convex polygon, counter-clockwise seen from above (or from outside), to a mesh around `origin`.
fn push_corners(mesh: &mut Mesh, corners: &[Corner], origin: Vec2) {
    let first = mesh.positions.len() as u32;
    for corner in corners {
        mesh.positions.push(geom::mesh::position(corner.at, corner.height, origin).to_array().map(|x| x as f32));
        let normal = Vec3::new(corner.normal.x, corner.normal.z, -corner.normal.y).normalize_or(Vec3::Y);
        mesh.normals.push(normal.to_array().map(|x| x as f32));
    }
    for i in 2..corners.len() as u32 {
        mesh.indices.extend([first, first + i - 1, first + i]);
    }
}

#[cfg(test)]
mod tests;
