//! Where most people live: the peaks of a density map (PM01 §3.2.1, figure 4).

use super::Field;
use geom::{Raster, Vec2};
use std::sync::OnceLock;

/// Longer side of the coarse map that peaks are looked for on, in cells: a peak is a place of the city, not a house.
const CELLS: f64 = 64.0;
/// Rounds of smoothing that map.
const ROUNDS: usize = 2;
/// A peak has less than this share of its density everywhere around it, before the ground rises to a higher one; so the
/// bumps of a noisy map are none.
const SADDLE: f64 = 0.9;
/// Peaks below this share of the highest are none.
const LEAST: f64 = 0.1;

/// A centre of population.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Where it is, in metres.
    pub at: Vec2,
    /// The density there, smoothed.
    pub density: f64,
}

/// The peaks of a density map, the densest first; found once, when they are first asked for.
#[derive(Clone, Debug, Default)]
pub struct Peaks(OnceLock<Vec<Peak>>);

impl Peaks {
    /// The peaks of a density map; none where no map tells it.
    pub fn of(&self, density: &Field) -> &[Peak] {
        self.0.get_or_init(|| found(density))
    }
}

/// The peaks of a map, and those that were put on it.
fn found(density: &Field) -> Vec<Peak> {
    match density {
        Field::Map(raster) => peaks(raster),
        Field::Raised(field, rises) => {
            let added = rises.iter().map(|rise| Peak { at: rise.at, density: density.at(rise.at) });
            let mut all: Vec<Peak> = found(field).into_iter().chain(added).collect();
            // Stable: of equals, those of the map first.
            all.sort_by(|a, b| b.density.total_cmp(&a.density));
            all
        }
        _ => Vec::new(),
    }
}

/// A coarse, smoothed copy of a map.
struct Coarse {
    columns: usize,
    rows: usize,
    cell: f64,
    origin: Vec2,
    /// From the south-west, row by row.
    values: Vec<f64>,
}

impl Coarse {
    fn of(raster: &Raster) -> Self {
        let size = raster.bounds_size();
        let cell = (size.max_element() / CELLS).max(raster.pixel_size());
        let count = |length: f64| ((length / cell).ceil() as usize).max(1);
        let (columns, rows) = (count(size.x), count(size.y));
        let mean = |i: usize| mean_of(raster, (i % columns, i / columns), cell);
        let values = (0..columns * rows).map(mean).collect();
        Self { columns, rows, cell, origin: raster.origin(), values }
    }

    fn smoothed(mut self) -> Self {
        self.values = (0..self.values.len())
            .map(|i| {
                let around = self.around(i);
                (4.0 * self.values[i] + around.iter().map(|&j| self.values[j]).sum::<f64>())
                    / (4.0 + around.len() as f64)
            })
            .collect();
        self
    }

    /// The cells around one, in the order of their places.
    fn around(&self, i: usize) -> Vec<usize> {
        let (x, y) = ((i % self.columns) as i64, (i / self.columns) as i64);
        let all = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let is_inside = |&(a, b): &(i64, i64)| {
            (a, b) != (x, y) && (0..self.columns as i64).contains(&a) && (0..self.rows as i64).contains(&b)
        };
        all.filter(is_inside).map(|(a, b)| (b * self.columns as i64 + a) as usize).collect()
    }

    fn place(&self, i: usize) -> Vec2 {
        self.origin + (Vec2::new((i % self.columns) as f64, (i / self.columns) as f64) + 0.5) * self.cell
    }
}

/// The mean of a map over a cell of the coarse one, by 4 × 4 samples.
fn mean_of(raster: &Raster, (column, row): (usize, usize), cell: f64) -> f64 {
    let low = raster.origin() + Vec2::new(column as f64, row as f64) * cell;
    let sample = |k: u32| raster.bilinear(low + (Vec2::new(f64::from(k % 4), f64::from(k / 4)) + 0.5) * (cell / 4.0));
    (0..16).map(sample).sum::<f64>() / 16.0
}

/// Floods the map from its top: a cell that touches no flooded ground starts a summit, and where two floods meet above
/// the saddle's share of the lower summit, that summit was only a shoulder of the higher one.
fn peaks(raster: &Raster) -> Vec<Peak> {
    let map = (0..ROUNDS).fold(Coarse::of(raster), |map, _| map.smoothed());
    let mut order: Vec<usize> = (0..map.values.len()).collect();
    order.sort_by(|&a, &b| map.values[b].total_cmp(&map.values[a]).then(a.cmp(&b)));
    let highest = order.first().map_or(0.0, |&top| map.values[top]);
    // For each flooded cell the cell it drains to; a summit drains to itself.
    let mut up: Vec<Option<usize>> = vec![None; map.values.len()];
    let mut shoulders = vec![false; map.values.len()];
    for &cell in order.iter().take_while(|&&cell| map.values[cell] > LEAST * highest) {
        up[cell] = Some(cell);
        for next in map.around(cell) {
            if up[next].is_some() {
                join(&map, &mut up, &mut shoulders, cell, next);
            }
        }
    }
    let is_summit = |&cell: &usize| up[cell].is_some() && started(&map, cell) && !shoulders[cell];
    order.into_iter().filter(is_summit).map(|cell| Peak { at: map.place(cell), density: map.values[cell] }).collect()
}

/// Whether nothing around a cell is higher, or as high and before it: then a flood started there.
fn started(map: &Coarse, cell: usize) -> bool {
    let own = map.values[cell];
    map.around(cell).into_iter().all(|next| map.values[next] < own || (map.values[next] == own && next > cell))
}

/// Lets the lower of two floods drain into the higher one.
fn join(map: &Coarse, up: &mut [Option<usize>], shoulders: &mut [bool], cell: usize, next: usize) {
    let (a, b) = (summit(up, cell), summit(up, next));
    if a == b {
        return;
    }
    let rank = |summit: usize| (map.values[summit], std::cmp::Reverse(summit));
    let (low, high) = if rank(a) < rank(b) { (a, b) } else { (b, a) };
    shoulders[low] |= map.values[cell] >= SADDLE * map.values[low];
    up[low] = Some(high);
}

/// The summit that a flooded cell drains to; the way there is shortened.
fn summit(up: &mut [Option<usize>], cell: usize) -> usize {
    let mut at = cell;
    while let Some(next) = up[at].filter(|&next| next != at) {
        up[at] = up[next];
        at = next;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn hills(tops: &[(f64, f64, f64)], noise: f64) -> Field {
        let height = |i: usize| {
            let at = Vec2::new((i % 200) as f64 + 0.5, 199.5 - (i / 200) as f64) * 20.0;
            let hill = |&(x, y, top): &(f64, f64, f64)| top / (1.0 + (at - Vec2::new(x, y)).length_squared() / 3e5);
            let bump = noise * geom::Seed(3).unit(i as u64);
            (tops.iter().map(hill).sum::<f64>() + bump) as f32
        };
        Field::Map(Arc::new(Raster::new(200, 200, 20.0, Vec2::ZERO, (0..40_000).map(height).collect()).unwrap()))
    }

    #[test]
    fn peaks_are_found_densest_first() {
        for noise in [0.0, 300.0] {
            let density = hills(&[(800.0, 900.0, 5000.0), (3100.0, 2600.0, 9000.0)], noise);
            let peaks = Peaks::default();
            let found = peaks.of(&density);
            assert_eq!(found.len(), 2, "{found:?}");
            for (peak, wanted) in found.iter().zip([Vec2::new(3100.0, 2600.0), Vec2::new(800.0, 900.0)]) {
                assert!((peak.at - wanted).length() < 100.0, "{found:?}");
            }
        }
    }

    #[test]
    fn rises_are_peaks_too() {
        let rise = crate::growth::Rise { at: Vec2::new(2000.0, 500.0), height: 7000.0, reach: 800.0 };
        let density = Field::Raised(Box::new(hills(&[(800.0, 900.0, 5000.0)], 0.0)), [rise].into());
        let peaks = Peaks::default();
        let found = peaks.of(&density);
        assert_eq!((found.len(), found[0].at), (2, rise.at), "{found:?}");
    }

    #[test]
    fn even_ground_has_no_peak() {
        assert!(Peaks::default().of(&Field::Constant(9.0)).is_empty());
        let flat = Raster::new(30, 10, 10.0, Vec2::ZERO, vec![0.0; 300]).unwrap();
        assert!(Peaks::default().of(&Field::Map(Arc::new(flat))).is_empty());
    }
}
