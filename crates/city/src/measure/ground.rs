//! Measures of streets against maps: pieces of about ten metres, each by its middle.

use super::scene::{Piece, Scene};
use super::spread;
use crate::sources::{PixelMap, floor_of};
use std::collections::BTreeMap;

/// Metres of the pieces that are held against maps.
const STEP: f64 = 10.0;
/// Side in metres of the cells in which length and density are compared.
const CELL: f64 = 300.0;
/// Metres to each side over which the ground's slope is taken.
const REACH: f64 = 15.0;
/// Rise per metre above which ground is steep.
const STEEP: f64 = 0.10;
/// Sine and cosine of 30°.
const NEAR: (f64, f64) = (0.5, 0.866_025_403_784_438_6);
/// Fewer steep metres than this say nothing about how streets meet a slope.
const LEAST_STEEP: f64 = 1000.0;
/// Fewer cells than this say nothing about density.
const LEAST_CELLS: usize = 20;

/// What walking along all streets found.
#[derive(Default)]
pub struct Walk {
    total: f64,
    wet: Option<f64>,
    in_park: Option<f64>,
    grades: Vec<f64>,
    steep: f64,
    contour: f64,
    fall: f64,
    cells: BTreeMap<[i64; 2], f64>,
}

impl Walk {
    /// Walks all pieces.
    pub fn of(scene: &Scene) -> Self {
        let begin = |map: &Option<PixelMap>| map.as_ref().map(|_| 0.0);
        let mut walk = Self { wet: begin(&scene.maps.land), in_park: begin(&scene.maps.parks), ..Self::default() };
        for piece in &scene.pieces {
            walk.total += piece.length;
            walk.along(scene, piece);
        }
        walk
    }

    fn along(&mut self, scene: &Scene, piece: &Piece) {
        let steps = (floor_of(piece.length, STEP) as u32).max(1);
        let part = piece.length / f64::from(steps);
        for step in 0..steps {
            let share = (f64::from(step) + 0.5) / f64::from(steps);
            let at = [0, 1].map(|axis| piece.from[axis] + (piece.to[axis] - piece.from[axis]) * share);
            *self.cells.entry(cell_of(at)).or_default() += part;
            let is_off = |map: &Option<PixelMap>| map.as_ref().is_some_and(|map| !map.is_inside(at));
            if !piece.is_raised && is_off(&scene.maps.land) {
                self.wet = self.wet.map(|wet| wet + part);
            }
            if scene.maps.parks.as_ref().is_some_and(|parks| parks.is_inside(at)) {
                self.in_park = self.in_park.map(|in_park| in_park + part);
            }
            if let (Some(elevation), false) = (&scene.maps.elevation, piece.is_raised) {
                self.climb(elevation.gradient(at, REACH), piece, part);
            }
        }
    }

    /// Counts a part of a piece on ground of some slope.
    fn climb(&mut self, [east, north]: [f64; 2], piece: &Piece, part: f64) {
        let along = [0, 1].map(|axis| (piece.to[axis] - piece.from[axis]) / piece.length);
        let rise = (east * along[0] + north * along[1]).abs();
        let slope = (east * east + north * north).sqrt();
        self.grades.push(100.0 * rise);
        if slope > STEEP {
            self.steep += part;
            self.contour += if rise / slope < NEAR.0 { part } else { 0.0 };
            self.fall += if rise / slope > NEAR.1 { part } else { 0.0 };
        }
    }

    /// The share of length on water, bridges apart.
    pub fn water_share(&self) -> Option<f64> {
        self.share(self.wet)
    }

    /// The share of length in parks.
    pub fn park_share(&self) -> Option<f64> {
        self.share(self.in_park)
    }

    fn share(&self, part: Option<f64>) -> Option<f64> {
        part.filter(|_| self.total > 0.0).map(|part| part / self.total)
    }

    /// The 95th percentile of the grade, in percent.
    pub fn grade_p95(&self) -> Option<f64> {
        spread::quantile(&self.grades, 0.95)
    }

    /// Where the ground is steep: the share of length within 30° of the contour.
    pub fn contour_share(&self) -> Option<f64> {
        self.steep_km().map(|_| self.contour / self.steep)
    }

    /// Where the ground is steep: the share of length within 30° of the fall line.
    pub fn fall_share(&self) -> Option<f64> {
        self.steep_km().map(|_| self.fall / self.steep)
    }

    /// Kilometres on steep ground, where there are enough to speak of.
    pub fn steep_km(&self) -> Option<f64> {
        (self.steep > LEAST_STEEP).then_some(self.steep / 1000.0)
    }

    /// Spearman's correlation of street length and density over cells of 300 m whose middle is measured land.
    pub fn density_rank(&self, scene: &Scene) -> Option<f64> {
        let map = scene.maps.density.as_ref()?;
        let side = ((CELL / map.pixel_size()).floor() as usize).max(1);
        let (width, height) = map.size();
        let (mut people, mut lengths) = (Vec::new(), Vec::new());
        for row in (0..height.saturating_sub(side)).step_by(side) {
            for column in (0..width.saturating_sub(side)).step_by(side) {
                let half = side as f64 / 2.0;
                let middle =
                    [(column as f64 + half) * map.pixel_size(), (height as f64 - row as f64 - half) * map.pixel_size()];
                if scene.holds(middle) && scene.maps.land.as_ref().is_none_or(|land| land.is_inside(middle)) {
                    people.push(mean_grey(map, [column, row], side));
                    lengths.push(self.cells.get(&cell_of(middle)).copied().unwrap_or(0.0));
                }
            }
        }
        if people.len() > LEAST_CELLS { spread::rank_correlation(&people, &lengths) } else { None }
    }
}

fn cell_of(at: [f64; 2]) -> [i64; 2] {
    at.map(|metres| floor_of(metres, CELL) as i64)
}

fn mean_grey(map: &PixelMap, [column, row]: [usize; 2], side: usize) -> f64 {
    let pixels = (row..row + side).flat_map(|row| (column..column + side).map(move |column| (column, row)));
    let sum: u64 = pixels.map(|(column, row)| u64::from(map.grey(column, row))).sum();
    sum as f64 / (side * side) as f64
}
