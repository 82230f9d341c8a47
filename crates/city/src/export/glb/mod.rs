//! `city.glb`: terrain, streets and buildings as glTF 2.0 in metres, x east, y up, z south.
//!
//! [`model`] makes the meshes, tile by tile; [`write`] packs them. What lies on the ground is cut along the terrain's
//! own triangles, so that no street sinks into a hill or floats over a hollow.

mod buildings;
mod pack;
mod streets;
mod terrain;

pub use pack::{GlbError, write};

use crate::{Cache, City};
use geom::{Digest, Id, Mesh, Vec2, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;
use terrain::Terrain;

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

impl TileKey {
    /// The tile that a place lies in.
    pub fn of(place: Vec2) -> Self {
        let cell = (place / TILE_M).floor();
        Self { column: cell.x as i32, row: cell.y as i32 }
    }

    /// Its south-west corner in metres.
    pub fn origin(self) -> Vec2 {
        Vec2::new(f64::from(self.column), f64::from(self.row)) * TILE_M
    }
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
    /// Takes in the meshes of some groups that it has none of.
    fn take(&mut self, meshes: &Meshes) {
        for (&(tile, group, surface), mesh) in &meshes.0 {
            if !mesh.is_empty() {
                self.tiles.entry(tile).or_default().insert((group, surface), mesh.clone());
            }
        }
    }
}

/// Meshes being made.
#[derive(Debug, Default)]
struct Meshes(BTreeMap<(TileKey, Group, Surface), Arc<Mesh>>);

impl Meshes {
    fn mesh(&mut self, tile: TileKey, group: Group, surface: Surface) -> &mut Mesh {
        Arc::make_mut(self.0.entry((tile, group, surface)).or_default())
    }
}

/// The meshes of a city. A thing belongs to the tile of its first point, the terrain to the tile it lies in. Those of
/// terrain and streets are kept in a cache, where it is known what they were made from.
pub fn model(city: &City, cache: &Cache) -> Model {
    let on_ground = || {
        let terrain = cache.part(terrain_key(city), || Terrain::of(city));
        let key = terrain_key(city).zip(city.digests.streets);
        let key = key.map(|(terrain, streets)| Digest::new("meshes").id(terrain).id(streets).finish());
        let fixed = cache.part(key, || {
            let mut meshes = Meshes::default();
            terrain.add_to(&mut meshes);
            streets::add_to(&mut meshes, city, &terrain);
            meshes
        });
        let mut green = Meshes::default();
        buildings::add_green(&mut green, city, &terrain);
        (fixed, green)
    };
    let ((fixed, green), built) = rayon::join(on_ground, || buildings::buildings(city));
    let mut model = Model { crs: city.site.crs.clone(), origin: city.site.origin, ..Model::default() };
    [&*fixed, &green, &built].into_iter().for_each(|meshes| model.take(meshes));
    model
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
