//! Where segments lie: a uniform grid in tiles, so that what lies near one place lies near in memory too, and the table
//! of tiles fits the cache however large the graph.

use super::SegmentKey;
use geom::{Bounds, Point};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;
use std::array;

/// log2 of the cell size in LSB: 128 m, about the length of a street segment.
const CELL_SHIFT: u32 = 17;

/// log2 of the cells along a side of a tile: 8 cells, 1 km.
const TILE_SHIFT: u32 = 3;

/// Cells of a tile.
const TILE_CELLS: usize = 1 << (2 * TILE_SHIFT);

/// Segments by grid cell, each with its box: most of a cell is told from what is asked for without a look at the arenas.
/// The tiles are looked up, never iterated.
#[derive(Clone, Debug, Default)]
pub(crate) struct SegmentIndex {
    tiles: FxHashMap<(i32, i32), Box<[Cell; TILE_CELLS]>>,
}

type Cell = SmallVec<[Entry; 6]>;

#[derive(Clone, Copy, Debug)]
struct Entry {
    bounds: Bounds,
    key: SegmentKey,
}

impl SegmentIndex {
    pub(crate) fn insert(&mut self, key: SegmentKey, a: Point, b: Point) {
        let entry = Entry { bounds: Bounds::between(a, b), key };
        for_cells_along(a, b, |cell| {
            let tile = self.tiles.entry(tile_of(cell)).or_insert_with(|| Box::new(array::from_fn(|_| Cell::new())));
            tile[slot_of(cell)].push(entry);
        });
    }

    pub(crate) fn remove(&mut self, key: SegmentKey, a: Point, b: Point) {
        for_cells_along(a, b, |cell| {
            if let Some(tile) = self.tiles.get_mut(&tile_of(cell)) {
                let entries = &mut tile[slot_of(cell)];
                if let Some(at) = entries.iter().position(|entry| entry.key == key) {
                    entries.swap_remove(at);
                }
            }
        });
    }

    /// Keys of all segments whose box overlaps the box, sorted, each once.
    pub(crate) fn near(&self, bounds: Bounds) -> SmallVec<[SegmentKey; 32]> {
        let mut found = SmallVec::new();
        for cx in bounds.min.x >> CELL_SHIFT..=bounds.max.x >> CELL_SHIFT {
            for cy in bounds.min.y >> CELL_SHIFT..=bounds.max.y >> CELL_SHIFT {
                let Some(tile) = self.tiles.get(&tile_of((cx, cy))) else { continue };
                for entry in &tile[slot_of((cx, cy))] {
                    if entry.bounds.overlaps(&bounds) {
                        found.push(entry.key);
                    }
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn tile_of((cx, cy): (i32, i32)) -> (i32, i32) {
    (cx >> TILE_SHIFT, cy >> TILE_SHIFT)
}

/// Where in its tile a cell lies: column by column.
fn slot_of((cx, cy): (i32, i32)) -> usize {
    let mask = (1 << TILE_SHIFT) - 1;
    ((cx & mask) << TILE_SHIFT | (cy & mask)) as usize
}

/// Calls `f` once for each cell that the segment touches (and at most a few more).
fn for_cells_along(a: Point, b: Point, mut f: impl FnMut((i32, i32))) {
    let (west, east) = if a.x <= b.x { (a, b) } else { (b, a) };
    for cx in west.x >> CELL_SHIFT..=east.x >> CELL_SHIFT {
        let x0 = (i64::from(cx) << CELL_SHIFT).max(i64::from(west.x));
        let x1 = ((i64::from(cx) + 1) << CELL_SHIFT).min(i64::from(east.x));
        let (low, high) = heights(west, east, x0, x1);
        for cy in low >> CELL_SHIFT..=high >> CELL_SHIFT {
            f((cx, cy as i32));
        }
    }
}

/// Bounds of y on the segment for x in `x0..=x1`, rounded outwards.
fn heights(west: Point, east: Point, x0: i64, x1: i64) -> (i64, i64) {
    let (dx, dy) = west.to(east);
    let west_y = i64::from(west.y);
    if dx == 0 {
        return (west_y.min(i64::from(east.y)), west_y.max(i64::from(east.y)));
    }
    let floor = |x: i64| west_y + ((x - i64::from(west.x)) * dy).div_euclid(dx);
    (floor(x0).min(floor(x1)), floor(x0).max(floor(x1)) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_point_of_a_segment_finds_it(ax in -900_000..900_000, ay in -900_000..900_000, bx in -900_000..900_000,
                                             by in -900_000..900_000, t in 0.0f64..=1.0) {
            let (a, b) = (Point::new(ax, ay), Point::new(bx, by));
            let mut index = SegmentIndex::default();
            index.insert(SegmentKey(7), a, b);
            let on = Point::from_metres(a.metres().lerp(b.metres(), t));
            let found = index.near(Bounds::between(on, on).grown(1));
            prop_assert_eq!(found.as_slice(), &[SegmentKey(7)]);
            index.remove(SegmentKey(7), b, a);
            prop_assert!(index.near(Bounds::between(a, b)).is_empty());
        }
    }
}
