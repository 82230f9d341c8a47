//! How steep a line is on a map of elevations.
//!
//! The bilinear surface is quadratic along a line between two lines of cell centres, so its steepest place in such a
//! piece is at one of the piece's ends and can be told from three heights: the answer is that of the surface itself,
//! not of samples of it.

use super::Field;
use geom::{Raster, Vec2};

/// Pieces shorter than this many metres are not looked at: rounding would tell their slope.
const SHORTEST: f64 = 1e-3;

/// The distance from the start, in metres, of the first piece of a line that is somewhere steeper than `limit`, rise
/// over run; none when all of it is gentle enough.
pub(super) fn steep_from(elevation: &Field, from: Vec2, to: Vec2, limit: f64) -> Option<f64> {
    let Field::Map(raster) = elevation else { return None };
    let length = (to - from).length();
    pieces(raster, from, to)
        .find(|&(start, end)| {
            let run = (end - start) * length;
            run >= SHORTEST && steepness(raster, from.lerp(to, start), from.lerp(to, end)) > limit * run
        })
        .map(|(start, _)| start * length)
}

/// The greatest rise per piece, taken at its ends: the slope there times the length of the piece.
fn steepness(raster: &Raster, a: Vec2, b: Vec2) -> f64 {
    let [low, middle, high] = [a, (a + b) / 2.0, b].map(|place| raster.bilinear(place));
    let at_start = -3.0 * low + 4.0 * middle - high;
    let at_end = low - 4.0 * middle + 3.0 * high;
    at_start.abs().max(at_end.abs())
}

/// The pieces of a line between the lines of cell centres, as shares of it.
fn pieces(raster: &Raster, from: Vec2, to: Vec2) -> impl Iterator<Item = (f64, f64)> {
    let cell = raster.pixel_size();
    let (at, span) = ((from - raster.origin()) / cell - 0.5, (to - from) / cell);
    let (mut x, mut y) = (Knots::new(at.x, span.x), Knots::new(at.y, span.y));
    let mut start = 0.0;
    std::iter::from_fn(move || {
        if start >= 1.0 {
            return None;
        }
        let end = x.next.min(y.next).min(1.0);
        if x.next <= end {
            x.advance();
        }
        if y.next <= end {
            y.advance();
        }
        let piece = (start, end);
        start = end;
        Some(piece)
    })
}

/// The shares of a line at which one of its coordinates, counted in cells, is whole.
struct Knots {
    next: f64,
    first: f64,
    count: f64,
    span: f64,
}

impl Knots {
    fn new(at: f64, span: f64) -> Self {
        // Written so that a line that stays on one side, or a number that is none, has no knot.
        if !(span.abs() > 0.0 && span.is_finite() && at.is_finite()) {
            return Self { next: f64::INFINITY, first: 0.0, count: 0.0, span: 1.0 };
        }
        let first = if span > 0.0 { at.floor() + 1.0 - at } else { at - at.ceil() + 1.0 };
        Self { next: first / span.abs(), first, count: 0.0, span: span.abs() }
    }

    fn advance(&mut self) {
        self.count += 1.0;
        self.next = if self.next.is_finite() { (self.first + self.count) / self.span } else { f64::INFINITY };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::Arc;

    fn field(heights: Vec<f32>) -> Field {
        Field::Map(Arc::new(Raster::new(8, 8, 10.0, Vec2::ZERO, heights).unwrap()))
    }

    #[test]
    fn a_ridge_between_two_samples_is_seen() {
        let heights = (0..64).map(|cell| if cell % 8 == 3 { 10.0 } else { 0.0 }).collect();
        let ridge = field(heights);
        let (from, to) = (Vec2::new(30.0, 40.0), Vec2::new(40.0, 40.0));
        assert_eq!(ridge.at(from), ridge.at(to));
        assert_eq!(steep_from(&ridge, from, to, 0.99), Some(0.0));
        assert_eq!(steep_from(&ridge, from, to, 1.01), None);
        let along = (Vec2::new(35.0, 10.0), Vec2::new(35.0, 70.0));
        assert_eq!(steep_from(&ridge, along.0, along.1, 0.01), None);
    }

    #[test]
    fn flat_land_is_gentle() {
        assert_eq!(steep_from(&Field::Constant(3.0), Vec2::ZERO, Vec2::splat(100.0), 0.0), None);
        assert_eq!(steep_from(&field(vec![0.0; 64]), Vec2::ZERO, Vec2::ZERO, 0.0), None);
    }

    proptest! {
        #[test]
        fn agrees_with_very_fine_steps(heights in prop::collection::vec(0.0f32..8.0, 64), x in -5.0f64..85.0, y in -5.0f64..85.0,
                                       dx in -90.0f64..90.0, dy in -90.0f64..90.0, limit in 0.05f64..1.2) {
            let elevation = field(heights);
            let (from, to) = (Vec2::new(x, y), Vec2::new(x + dx, y + dy));
            let length = (to - from).length();
            let step = 0.01;
            let grade = |i: u32| {
                let [a, b] = [i, i + 1].map(|i| elevation.at(from.lerp(to, (f64::from(i) * step / length).min(1.0))));
                (b - a).abs() / step
            };
            let steps = (length / step) as u32;
            let first = (0..steps).find(|&i| grade(i) > limit + 1e-6);
            match (steep_from(&elevation, from, to, limit), first) {
                // Pieces are told by their start: nothing before it is steep.
                (Some(start), Some(i)) => prop_assert!(start <= f64::from(i + 1) * step + 1e-6),
                (None, Some(i)) => prop_assert!(false, "steep at step {}", i),
                // The steepest place of a piece is a single one: steps may miss it by a little.
                (Some(_), None) => prop_assert!((0..steps).any(|i| grade(i) > limit - 0.02), "not that steep"),
                (None, None) => {}
            }
        }
    }
}
