//! Maps as rasters.

use crate::Vec2;
use thiserror::Error;

/// Why values do not make a [`Raster`].
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RasterError {
    /// No cells at all.
    #[error("a raster needs at least one cell, not {width} × {height}")]
    Empty {
        /// Cells from west to east.
        width: usize,
        /// Cells from north to south.
        height: usize,
    },
    /// More or fewer values than cells.
    #[error("{width} × {height} cells need as many values, not {values}")]
    ValueCount {
        /// Cells from west to east.
        width: usize,
        /// Cells from north to south.
        height: usize,
        /// Values given.
        values: usize,
    },
    /// The size of a cell is not a positive number.
    #[error("the pixel size must be a positive number of metres, not {0}")]
    PixelSize(f64),
    /// The south-west corner is not a place.
    #[error("the origin must be finite, not {0}")]
    Origin(Vec2),
    /// A value is not a number or infinite.
    #[error("the value in column {column}, row {row} is {value}, which is not finite")]
    Value {
        /// From the west, counted from 0.
        column: usize,
        /// From the north, counted from 0.
        row: usize,
        /// What stands there.
        value: f32,
    },
}

/// A regular grid of values over a rectangle. Row 0 is north, as in images; places are metres from the south-west corner
/// of the frame. Outside the rectangle the nearest cell answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    width: usize,
    height: usize,
    pixel_size: f64,
    origin: Vec2,
    values: Vec<f32>,
}

impl Raster {
    /// A raster of `width` × `height` square cells of `pixel_size` metres, whose south-west corner is `origin`. `values`
    /// are row-major, row 0 north.
    ///
    /// # Errors
    /// See [`RasterError`].
    pub fn new(
        width: usize,
        height: usize,
        pixel_size: f64,
        origin: Vec2,
        values: Vec<f32>,
    ) -> Result<Self, RasterError> {
        if width == 0 || height == 0 {
            return Err(RasterError::Empty { width, height });
        }
        if width.checked_mul(height) != Some(values.len()) {
            return Err(RasterError::ValueCount { width, height, values: values.len() });
        }
        if !pixel_size.is_finite() || pixel_size <= 0.0 {
            return Err(RasterError::PixelSize(pixel_size));
        }
        if !origin.is_finite() {
            return Err(RasterError::Origin(origin));
        }
        if let Some(cell) = values.iter().position(|v| !v.is_finite()) {
            return Err(RasterError::Value { column: cell % width, row: cell / width, value: values[cell] });
        }
        Ok(Self { width, height, pixel_size, origin, values })
    }

    /// Width and height in cells.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Metres per cell.
    pub fn pixel_size(&self) -> f64 {
        self.pixel_size
    }

    /// South-west corner.
    pub fn origin(&self) -> Vec2 {
        self.origin
    }

    /// Row-major values, row 0 north.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Width and height of the rectangle in metres.
    pub fn bounds_size(&self) -> Vec2 {
        Vec2::new(self.width as f64, self.height as f64) * self.pixel_size
    }

    /// South-west and north-east corner of the rectangle in metres.
    pub fn extent(&self) -> (Vec2, Vec2) {
        (self.origin, self.origin + self.bounds_size())
    }

    /// The same grid with every value changed by `change`.
    ///
    /// # Errors
    /// [`RasterError::Value`] where `change` gives a number that is not finite or beyond `f32`.
    pub fn map_values(&self, change: impl Fn(f64) -> f64) -> Result<Self, RasterError> {
        let values = self.values.iter().map(|&v| change(f64::from(v)) as f32).collect();
        Self::new(self.width, self.height, self.pixel_size, self.origin, values)
    }

    /// The value of the cell at a place in metres. Cells own their south and west rims; a coordinate that is not a
    /// number counts as the western or southern rim.
    #[inline]
    pub fn nearest(&self, place: Vec2) -> f64 {
        let at = (place - self.origin) / self.pixel_size;
        // The cast saturates: what is negative or not a number becomes 0.
        self.cell((at.x as usize).min(self.width - 1), (at.y as usize).min(self.height - 1))
    }

    /// Interpolated between the four cell centres around a place in metres; within half a cell of the rim and outside,
    /// between the nearest two or one.
    #[inline]
    pub fn bilinear(&self, place: Vec2) -> f64 {
        let at = (place - self.origin) / self.pixel_size - 0.5;
        let (west, east, x) = neighbours(at.x, self.width);
        let (south, north, y) = neighbours(at.y, self.height);
        let below = mix(self.cell(west, south), self.cell(east, south), x);
        let above = mix(self.cell(west, north), self.cell(east, north), x);
        mix(below, above, y)
    }

    /// Change per metre towards east and north: the mean over one cell's width around the place, so it is continuous
    /// where the bilinear surface has creases. Near the rim and outside, the outermost full width answers.
    #[inline]
    pub fn gradient(&self, place: Vec2) -> Vec2 {
        Vec2::new(
            self.slope(place, Vec2::X, place.x - self.origin.x, self.width),
            self.slope(place, Vec2::Y, place.y - self.origin.y, self.height),
        )
    }

    /// The distance in metres from each cell to the nearest one that is set (more than one half): 0 in it, else from
    /// centre to centre less half a cell, so at most half a cell from the truth. `None` where no cell is set.
    pub fn distances(&self) -> Option<Self> {
        let far = (self.width + self.height) as f64;
        let mut squared: Vec<f64> = Vec::with_capacity(self.values.len());
        for row in self.values.chunks_exact(self.width) {
            squared.extend(distances_in_row(row, far).into_iter().map(|cells| cells * cells));
        }
        if !self.values.iter().any(|&value| value > 0.5) {
            return None;
        }
        let mut values = vec![0.0f32; self.values.len()];
        for column in 0..self.width {
            let along: Vec<f64> = squared.iter().skip(column).step_by(self.width).copied().collect();
            for (row, nearest) in lower_envelope(&along).into_iter().enumerate() {
                values[row * self.width + column] = ((nearest.sqrt() - 0.5).max(0.0) * self.pixel_size) as f32;
            }
        }
        Self::new(self.width, self.height, self.pixel_size, self.origin, values).ok()
    }

    /// Whether the cell at a place is set (more than one half, for masks of 0 and 1).
    #[inline]
    pub fn mask(&self, place: Vec2) -> bool {
        self.nearest(place) > 0.5
    }

    /// Mean change per metre along an axis; `along` is the place's distance from the origin on it, `cells` the count.
    #[inline]
    fn slope(&self, place: Vec2, axis: Vec2, along: f64, cells: usize) -> f64 {
        if cells < 2 {
            return 0.0;
        }
        // The window of one cell's width has to stay between the first and the last centre.
        let centre = along.max(self.pixel_size).min((cells - 1) as f64 * self.pixel_size);
        let at = place + axis * (centre - along);
        let half = axis * (self.pixel_size / 2.0);
        (self.bilinear(at + half) - self.bilinear(at - half)) / self.pixel_size
    }

    /// The value in a column counted from the west and a row counted from the south, both within the grid.
    #[inline]
    fn cell(&self, column: usize, row_from_south: usize) -> f64 {
        f64::from(self.values[(self.height - 1 - row_from_south) * self.width + column])
    }
}

/// The distance of each cell of a row to the nearest one that is set, in cells; `far` where none is.
fn distances_in_row(row: &[f32], far: f64) -> Vec<f64> {
    let mut distances = vec![far; row.len()];
    let mut last = far;
    for (cell, &value) in row.iter().enumerate() {
        last = if value > 0.5 { 0.0 } else { (last + 1.0).min(far) };
        distances[cell] = last;
    }
    last = far;
    for (cell, &value) in row.iter().enumerate().rev() {
        last = if value > 0.5 { 0.0 } else { (last + 1.0).min(far) };
        distances[cell] = distances[cell].min(last);
    }
    distances
}

/// For each place the least of `(place - other)² + squared[other]` over all others (Felzenszwalb and Huttenlocher,
/// "Distance transforms of sampled functions"): the parabolas that are lowest somewhere, then each place's one.
fn lower_envelope(squared: &[f64]) -> Vec<f64> {
    let mut lowest: Vec<(usize, f64)> = Vec::with_capacity(squared.len());
    for (at, &height) in squared.iter().enumerate() {
        let meets = |other: usize| {
            let (p, q) = (at as f64, other as f64);
            ((height + p * p) - (squared[other] + q * q)) / (2.0 * (p - q))
        };
        while lowest.last().is_some_and(|&(other, from)| meets(other) <= from) {
            lowest.pop();
        }
        let from = lowest.last().map_or(f64::NEG_INFINITY, |&(other, _)| meets(other));
        lowest.push((at, from));
    }
    let mut next = 0;
    let value = |place: usize| {
        while lowest.get(next + 1).is_some_and(|&(_, from)| from <= place as f64) {
            next += 1;
        }
        let apart = place as f64 - lowest[next].0 as f64;
        apart * apart + squared[lowest[next].0]
    };
    (0..squared.len()).map(value).collect()
}

/// The two cells whose centres enclose `at` (counted in cells from the first centre), and the share of the second.
#[inline]
fn neighbours(at: f64, cells: usize) -> (usize, usize, f64) {
    // In this order a coordinate that is not a number becomes 0.
    let at = at.max(0.0).min((cells - 1) as f64);
    let first = at as usize;
    (first, (first + 1).min(cells - 1), at - first as f64)
}

/// Linear interpolation that hits both ends exactly.
#[inline]
fn mix(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// 4 × 3 cells of 10 m from (100, 200), the value at a cell's centre being `2 x - 3 y`.
    fn ramp() -> Raster {
        let value = |i: usize| {
            let (column, row_from_south) = (i % 4, 2 - i / 4);
            2.0 * (105.0 + 10.0 * column as f32) - 3.0 * (205.0 + 10.0 * row_from_south as f32)
        };
        Raster::new(4, 3, 10.0, Vec2::new(100.0, 200.0), (0..12).map(value).collect()).unwrap()
    }

    #[test]
    fn bad_values_are_refused() {
        let new = |w, h, pixel, values: &[f32]| Raster::new(w, h, pixel, Vec2::ZERO, values.to_vec()).unwrap_err();
        assert_eq!(new(0, 3, 1.0, &[]), RasterError::Empty { width: 0, height: 3 });
        assert_eq!(new(2, 1, 1.0, &[0.0]), RasterError::ValueCount { width: 2, height: 1, values: 1 });
        assert!(matches!(new(usize::MAX, 2, 1.0, &[0.0]), RasterError::ValueCount { .. }));
        assert_eq!(new(1, 1, -1.0, &[0.0]), RasterError::PixelSize(-1.0));
        assert!(matches!(new(1, 1, f64::NAN, &[0.0]), RasterError::PixelSize(_)));
        let infinite = new(2, 2, 1.0, &[0.0, 0.0, 0.0, f32::INFINITY]);
        assert_eq!(infinite, RasterError::Value { column: 1, row: 1, value: f32::INFINITY });
        assert!(matches!(Raster::new(1, 1, 1.0, Vec2::NAN, vec![0.0]), Err(RasterError::Origin(_))));
    }

    #[test]
    fn rows_run_from_north() {
        let raster = Raster::new(2, 2, 1.0, Vec2::ZERO, vec![1.0, 2.0, 3.0, 4.0]).unwrap();
        let at = |x, y| raster.nearest(Vec2::new(x, y));
        assert_eq!([at(0.5, 1.5), at(1.5, 1.5), at(0.5, 0.5), at(1.5, 0.5)], [1.0, 2.0, 3.0, 4.0]);
        assert_eq!([at(1.0, 1.0), at(0.0, 0.0), at(2.0, 2.0)], [2.0, 3.0, 2.0], "cells own south and west rims");
        assert_eq!([at(-9.0, 9.0), at(9.0, -9.0), at(f64::NAN, f64::INFINITY)], [1.0, 4.0, 1.0]);
        assert_eq!(raster.bilinear(Vec2::new(1.0, 1.0)), 2.5);
        assert_eq!(raster.bilinear(Vec2::new(-5.0, f64::NAN)), 3.0);
        assert_eq!((raster.bounds_size(), raster.extent()), (Vec2::splat(2.0), (Vec2::ZERO, Vec2::splat(2.0))));
    }

    #[test]
    fn one_cell_answers_everywhere() {
        let raster = Raster::new(1, 1, 5.0, Vec2::ZERO, vec![7.0]).unwrap();
        for place in [Vec2::ZERO, Vec2::splat(2.5), Vec2::splat(-100.0), Vec2::splat(100.0)] {
            assert_eq!((raster.nearest(place), raster.bilinear(place)), (7.0, 7.0));
            assert_eq!(raster.gradient(place), Vec2::ZERO);
        }
    }

    #[test]
    fn masks_and_changed_values() {
        let raster = Raster::new(2, 1, 1.0, Vec2::ZERO, vec![0.0, 1.0]).unwrap();
        let inverse = raster.map_values(|v| 1.0 - v).unwrap();
        let west = Vec2::new(0.5, 0.5);
        assert!(!raster.mask(west) && inverse.mask(west));
        assert!(matches!(raster.map_values(|v| 1.0 / v), Err(RasterError::Value { column: 0, row: 0, .. })));
    }

    proptest! {
        #[test]
        fn a_ramp_is_followed_between_centres(x in 105.0f64..135.0, y in 205.0f64..225.0) {
            prop_assert!((ramp().bilinear(Vec2::new(x, y)) - (2.0 * x - 3.0 * y)).abs() < 1e-9);
        }

        #[test]
        fn a_ramp_has_one_gradient(x in 0.0f64..300.0, y in 100.0f64..300.0) {
            prop_assert!((ramp().gradient(Vec2::new(x, y)) - Vec2::new(2.0, -3.0)).length() < 1e-9);
        }

        #[test]
        fn bilinear_stays_between_its_cells_and_is_continuous(
            values in prop::collection::vec(-1000.0f32..1000.0, 30),
            x in -1.0f64..7.0,
            y in -1.0f64..6.0,
        ) {
            let raster = Raster::new(6, 5, 1.0, Vec2::ZERO, values).unwrap();
            let at = Vec2::new(x, y);
            let around: Vec<f64> = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)]
                .map(|(dx, dy)| raster.nearest(at + Vec2::new(dx, dy)))
                .to_vec();
            let (low, high) = around.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
            let value = raster.bilinear(at);
            prop_assert!(low - 1e-9 <= value && value <= high + 1e-9);
            prop_assert!((raster.bilinear(at + Vec2::splat(1e-7)) - value).abs() < 1e-3);
            prop_assert!((raster.gradient(at + Vec2::splat(1e-7)) - raster.gradient(at)).length() < 2e-3);
        }
    }
}
