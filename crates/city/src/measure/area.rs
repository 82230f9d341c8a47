//! Measures of blocks, and what polygons need for them.

use super::scene::Scene;
use super::spread;

/// Median area of blocks in hectares.
pub fn block_median_ha(scene: &Scene) -> Option<f64> {
    spread::quantile(&scene.blocks, 0.5)
}

/// The 90th over the 10th percentile of the areas of blocks.
pub fn block_spread(scene: &Scene) -> Option<f64> {
    let (low, high) = (spread::quantile(&scene.blocks, 0.1)?, spread::quantile(&scene.blocks, 0.9)?);
    Some(high / low.max(1e-9))
}

/// Area of a closed ring in m².
pub fn ring_area(ring: &[[f64; 2]]) -> f64 {
    let Some(&[x0, y0]) = ring.first() else { return 0.0 };
    let twice: f64 =
        ring.windows(2).map(|pair| (pair[0][0] - x0) * (pair[1][1] - y0) - (pair[1][0] - x0) * (pair[0][1] - y0)).sum();
    (twice / 2.0).abs()
}

/// A place inside a polygon of closed rings: the middle of the widest stretch inside, on a level half way between the
/// corners just below and above the polygon's middle. So geometry libraries choose a polygon's representative point.
pub fn place_inside(rings: &[Vec<[f64; 2]>]) -> Option<[f64; 2]> {
    let outer = rings.first()?;
    let y = level(rings, outer)?;
    let mut cuts: Vec<f64> = rings.iter().flat_map(|ring| ring.windows(2)).filter_map(|side| cut(side, y)).collect();
    cuts.sort_by(f64::total_cmp);
    let mut widest: Option<[f64; 2]> = None;
    for pair in cuts.chunks_exact(2) {
        if widest.is_none_or(|[west, east]| pair[1] - pair[0] > east - west) {
            widest = Some([pair[0], pair[1]]);
        }
    }
    match widest {
        Some([west, east]) if east > west => Some([(west + east) / 2.0, y]),
        _ => outer.first().copied(),
    }
}

/// Whether a place lies in a polygon of closed rings.
pub fn holds(rings: &[Vec<[f64; 2]>], [x, y]: [f64; 2]) -> bool {
    let cuts = rings.iter().flat_map(|ring| ring.windows(2)).filter_map(|side| cut(side, y));
    cuts.filter(|cut| *cut > x).count() % 2 == 1
}

/// Half way between the corners next to the polygon's middle height.
fn level(rings: &[Vec<[f64; 2]>], outer: &[[f64; 2]]) -> Option<f64> {
    let heights = || outer.iter().map(|at| at[1]);
    let (bottom, top) = (heights().min_by(f64::total_cmp)?, heights().max_by(f64::total_cmp)?);
    let middle = (bottom + top) / 2.0;
    let (mut below, mut above) = (bottom, top);
    for y in rings.iter().flatten().map(|at| at[1]) {
        if y <= middle {
            below = below.max(y);
        } else {
            above = above.min(y);
        }
    }
    Some((below + above) / 2.0)
}

/// Where a side passes a level; a corner on the level belongs to the side above it.
fn cut(side: &[[f64; 2]], y: f64) -> Option<f64> {
    let ([x0, y0], [x1, y1]) = (side[0], side[1]);
    let passes = (y0 < y) != (y1 < y);
    passes.then(|| if x0 == x1 { x0 } else { x0 + (y - y0) / ((y1 - y0) / (x1 - x0)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_is_in_the_widest_stretch_beside_a_hole() {
        let outer = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]];
        let hole = vec![[1.0, 2.0], [3.0, 2.0], [3.0, 8.0], [1.0, 8.0], [1.0, 2.0]];
        assert_eq!(place_inside(&[outer.clone(), hole]), Some([6.5, 5.0]));
        assert_eq!((ring_area(&outer), place_inside(&[])), (100.0, None));
        let rings = [outer, vec![[1.0, 2.0], [3.0, 2.0], [3.0, 8.0], [1.0, 8.0], [1.0, 2.0]]];
        let inside = [[0.5, 5.0], [6.5, 5.0], [2.0, 1.0], [2.0, 9.0]];
        assert!(inside.iter().all(|at| holds(&rings, *at)));
        assert!([[2.0, 5.0], [-1.0, 5.0], [11.0, 5.0], [5.0, 11.0]].iter().all(|at| !holds(&rings, *at)));
    }

    #[test]
    fn a_flat_ring_gives_its_first_corner() {
        assert_eq!(place_inside(&[vec![[1.0, 2.0], [5.0, 2.0], [1.0, 2.0]]]), Some([1.0, 2.0]));
    }
}
