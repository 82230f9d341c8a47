//! The model of a city as chunks: one for each tile and group.

use crate::render::{Chunk, ChunkRef, Drawing, Gpu, Solid, linear};
use crate::sight::Sight;
use city::export::glb::{Group, Model, Surface, Tile, TileKey, colour};
use geom::Mesh;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A city in space.
#[derive(Debug, Default)]
pub struct ModelScene {
    tiles: BTreeMap<(TileKey, Group), Part>,
}

#[derive(Clone, Debug)]
struct Part {
    /// What the chunk was made of.
    meshes: Meshes,
    chunk: ChunkRef,
}

/// The meshes of a tile's group.
type Meshes = Vec<(Surface, Arc<Mesh>)>;

impl ModelScene {
    /// The scene of a model; chunks of the same meshes are taken from `before`.
    pub fn of(gpu: &Gpu, model: &Model, before: Option<&Self>) -> Self {
        Self::of_part(gpu, model, before, None)
    }

    /// The same of what is in sight; elsewhere all stays as it was before.
    pub(super) fn of_part(gpu: &Gpu, model: &Model, before: Option<&Self>, sight: Option<Sight>) -> Self {
        let is_wanted = |tile: TileKey| sight.is_none_or(|sight| sight.contains(tile));
        let parts: Vec<((TileKey, Group), Meshes)> = model
            .tiles
            .iter()
            .filter(|(tile, _)| is_wanted(**tile))
            .flat_map(|(&key, tile)| groups(tile).into_iter().map(move |(g, m)| ((key, g), m)))
            .collect();
        let made = parts.into_par_iter().filter_map(|(place, meshes)| {
            let kept =
                before.and_then(|before| before.tiles.get(&place)).filter(|part| are_same(&part.meshes, &meshes));
            let chunk = match kept {
                Some(part) => part.chunk.clone(),
                None => Arc::new(Chunk::of(gpu, &drawing(place, &meshes))?),
            };
            Some((place, Part { meshes, chunk }))
        });
        let mut tiles: BTreeMap<(TileKey, Group), Part> = made.collect();
        let elsewhere = before.into_iter().flat_map(|before| &before.tiles).filter(|((tile, _), _)| !is_wanted(*tile));
        tiles.extend(elsewhere.map(|(place, part)| (*place, part.clone())));
        Self { tiles }
    }

    /// The chunks of a group.
    pub fn chunks(&self, group: Group) -> impl Iterator<Item = &ChunkRef> {
        self.tiles.iter().filter(move |((_, of), _)| *of == group).map(|(_, part)| &part.chunk)
    }

    /// How many chunks are the very ones of another scene.
    pub fn shared(&self, other: &Self) -> usize {
        let is_same = |place: &(TileKey, Group), part: &Part| {
            other.tiles.get(place).is_some_and(|theirs| Arc::ptr_eq(&theirs.chunk, &part.chunk))
        };
        self.tiles.iter().filter(|(place, part)| is_same(place, part)).count()
    }

    /// How many chunks there are.
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Whether there is nothing to see.
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }
}

/// The meshes of a tile by group.
fn groups(tile: &Tile) -> BTreeMap<Group, Meshes> {
    let mut groups: BTreeMap<Group, Meshes> = BTreeMap::new();
    for (&(group, surface), mesh) in tile {
        groups.entry(group).or_default().push((surface, mesh.clone()));
    }
    groups
}

fn are_same(a: &[(Surface, Arc<Mesh>)], b: &[(Surface, Arc<Mesh>)]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|((s, m), (t, n))| s == t && Arc::ptr_eq(m, n))
}

/// Meshes in glTF's axes as one drawing in ours.
fn drawing((tile, group): (TileKey, Group), meshes: &[(Surface, Arc<Mesh>)]) -> Drawing<Solid> {
    let mut drawing = Drawing::at(tile.origin());
    // What lies flat on the ground throws none.
    drawing.casts = matches!(group, Group::Terrain | Group::Buildings);
    let is_fine = |surface: Surface| surface == Surface::Sidewalk;
    let (coarse, fine): (Vec<_>, Vec<_>) = meshes.iter().partition(|(surface, _)| !is_fine(*surface));
    let from_far = coarse.iter().map(|(_, mesh)| mesh.indices.len()).sum();
    drawing.from_far = Some(from_far);
    for (surface, mesh) in coarse.into_iter().chain(fine) {
        let [r, g, b] = linear(colour(*surface));
        let first = drawing.vertices.len() as u32;
        drawing.vertices.extend(mesh.positions.iter().zip(&mesh.normals).map(|(&[x, y, z], &[nx, ny, nz])| Solid {
            position: [x, -z, y],
            normal: [nx, -nz, ny, 0.0].map(|n| (n * 127.0).round() as i8),
            colour: [r, g, b, 255],
        }));
        drawing.indices.extend(mesh.indices.iter().map(|index| first + index));
    }
    drawing
}
