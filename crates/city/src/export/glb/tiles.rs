//! Meshes tile by tile: all tiles at the same time, and those that earlier exports made of the same things not again.

use super::{Group, Surface, TILE_M, Tile, TileKey};
use crate::Cache;
use crate::cache::bytes_of;
use geom::{Digest, Id, Mesh, Vec2};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

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

/// The meshes of a tile being made.
#[derive(Debug)]
pub(super) struct Meshes {
    /// The corner of the tile, around which they lie.
    pub origin: Vec2,
    meshes: BTreeMap<(Group, Surface), Mesh>,
}

impl Meshes {
    pub fn of(tile: TileKey) -> Self {
        Self { origin: tile.origin(), meshes: BTreeMap::new() }
    }

    pub fn mesh(&mut self, group: Group, surface: Surface) -> &mut Mesh {
        self.meshes.entry((group, surface)).or_default()
    }

    /// Those in which there is something to see.
    pub fn finish(self) -> Tile {
        let seen = self.meshes.into_iter().filter(|(_, mesh)| !mesh.is_empty());
        seen.map(|(place, mesh)| (place, Arc::new(mesh))).collect()
    }
}

/// Things by the tile they are drawn in.
pub(super) type ByTile<T> = BTreeMap<TileKey, Vec<T>>;

/// Tiles that are being put together.
pub(super) type Tiles = BTreeMap<TileKey, Arc<Tile>>;

/// The tiles that `add` makes of things, which draw nothing but themselves and what `base` is the digest of.
pub(super) fn tiles<T: Serialize + Sync>(
    things: &ByTile<T>,
    base: Option<Id>,
    cache: &Cache,
    add: impl Fn(&mut Meshes, &T) + Sync,
) -> Tiles {
    let tile = |(&tile, things): (&TileKey, &Vec<T>)| {
        let made = cache.part(base.and_then(|base| key(base, tile, things)), || {
            let mut meshes = Meshes::of(tile);
            things.iter().for_each(|thing| add(&mut meshes, thing));
            meshes.finish()
        });
        (tile, made)
    };
    things.par_iter().map(tile).collect()
}

/// What the meshes of a tile are kept by.
fn key<T: Serialize>(base: Id, tile: TileKey, things: &[T]) -> Option<Id> {
    Some(Digest::new("tile").id(base).value(&tile).bytes(&bytes_of(&things)?).finish())
}
