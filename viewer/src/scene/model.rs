//! The model of a city as chunks: one for each tile and group.

use crate::render::{Chunk, ChunkRef, Drawing, Gpu, Solid, linear};
use crate::sight::Sight;
use city::export::glb::{Group, Model, Surface, TileKey, colour};
use geom::Mesh;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A city in space.
#[derive(Debug, Default)]
pub struct ModelScene {
    squares: BTreeMap<(TileKey, Group), Part>,
}

#[derive(Clone, Debug)]
struct Part {
    /// What the chunk was made of.
    meshes: Meshes,
    chunk: ChunkRef,
}

/// The meshes of a square's group, with the tiles they lie in.
type Meshes = Vec<(TileKey, Surface, Arc<Mesh>)>;

/// Tiles along a side of the square of a chunk: a call to draw costs as much as the thousand triangles of one.
const TILES: i32 = 2;

/// The least tile of the square that a tile lies in.
fn square_of(tile: TileKey) -> TileKey {
    let least = |at: i32| at.div_euclid(TILES) * TILES;
    TileKey { column: least(tile.column), row: least(tile.row) }
}

impl ModelScene {
    /// The scene of a model; chunks of the same meshes are taken from `before`.
    pub fn of(gpu: &Gpu, model: &Model, before: Option<&Self>) -> Self {
        Self::of_part(gpu, model, before, None)
    }

    /// The same of what is in sight; elsewhere all stays as it was before.
    pub(super) fn of_part(gpu: &Gpu, model: &Model, before: Option<&Self>, sight: Option<Sight>) -> Self {
        let is_wanted = |tile: TileKey| sight.is_none_or(|sight| sight.contains(tile));
        let mut parts: BTreeMap<(TileKey, Group), Meshes> = BTreeMap::new();
        let mut add = |tile: TileKey, group: Group, surface: Surface, mesh: &Arc<Mesh>| {
            parts.entry((square_of(tile), group)).or_default().push((tile, surface, mesh.clone()));
        };
        for (&tile, meshes) in model.tiles.iter().filter(|(tile, _)| is_wanted(**tile)) {
            meshes.iter().for_each(|(&(group, surface), mesh)| add(tile, group, surface, mesh));
        }
        for ((_, group), part) in before.into_iter().flat_map(|before| &before.squares) {
            let elsewhere = part.meshes.iter().filter(|(tile, ..)| !is_wanted(*tile));
            elsewhere.for_each(|(tile, surface, mesh)| add(*tile, *group, *surface, mesh));
        }
        let made = parts.into_par_iter().filter_map(|(place, mut meshes)| {
            meshes.sort_by_key(|(tile, surface, _)| (*tile, *surface));
            let kept =
                before.and_then(|before| before.squares.get(&place)).filter(|part| are_same(&part.meshes, &meshes));
            let chunk = match kept {
                Some(part) => part.chunk.clone(),
                None => Arc::new(Chunk::of(gpu, &drawing(place, &meshes))?),
            };
            Some((place, Part { meshes, chunk }))
        });
        Self { squares: made.collect() }
    }

    /// The chunks of a group.
    pub fn chunks(&self, group: Group) -> impl Iterator<Item = &ChunkRef> {
        self.squares.iter().filter(move |((_, of), _)| *of == group).map(|(_, part)| &part.chunk)
    }

    /// How many chunks are the very ones of another scene.
    pub fn shared(&self, other: &Self) -> usize {
        let is_same = |place: &(TileKey, Group), part: &Part| {
            other.squares.get(place).is_some_and(|theirs| Arc::ptr_eq(&theirs.chunk, &part.chunk))
        };
        self.squares.iter().filter(|(place, part)| is_same(place, part)).count()
    }

    /// How many chunks there are.
    pub fn len(&self) -> usize {
        self.squares.len()
    }

    /// Whether there is nothing to see.
    pub fn is_empty(&self) -> bool {
        self.squares.is_empty()
    }
}

fn are_same(a: &Meshes, b: &Meshes) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|((i, s, m), (j, t, n))| (i, s) == (j, t) && Arc::ptr_eq(m, n))
}

/// Meshes in glTF's axes as one drawing in ours.
fn drawing((square, group): (TileKey, Group), meshes: &Meshes) -> Drawing<Solid> {
    let mut drawing = Drawing::at(square.origin());
    // What lies flat on the ground throws none.
    drawing.casts = matches!(group, Group::Terrain | Group::Buildings);
    let is_fine = |surface: Surface| surface == Surface::Sidewalk;
    let (coarse, fine): (Vec<_>, Vec<_>) = meshes.iter().partition(|(_, surface, _)| !is_fine(*surface));
    let from_far = coarse.iter().map(|(.., mesh)| mesh.indices.len()).sum();
    drawing.from_far = Some(from_far);
    for (tile, surface, mesh) in coarse.into_iter().chain(fine) {
        let off = (tile.origin() - square.origin()).as_vec2();
        let [r, g, b] = linear(colour(*surface));
        let first = drawing.vertices.len() as u32;
        drawing.vertices.extend(mesh.positions.iter().zip(&mesh.normals).map(|(&[x, y, z], &[nx, ny, nz])| Solid {
            position: [x + off.x, off.y - z, y],
            normal: [nx, -nz, ny, 0.0].map(|n| (n * 127.0).round() as i8),
            colour: [r, g, b, 255],
        }));
        drawing.indices.extend(mesh.indices.iter().map(|index| first + index));
    }
    drawing
}
