//! Measures of where streets head.

use super::scene::{Piece, Scene};
use crate::sources::floor_of;
use geom::{Angle, Vec2};

/// Bins of the orientation order, 10° each, the first around east.
const BINS: usize = 36;
/// Bins of one degree in which the strongest headings are sought.
const DEGREES: usize = 180;
/// A heading counts with what lies this many degrees beside it.
const BESIDE: usize = 2;
/// The second heading lies more than this many degrees from the first.
const APART: usize = 30;

/// Orientation order by length (Boeing 2019): 1 where all streets follow one grid, 0 where every heading is alike.
pub fn order(scene: &Scene) -> Option<f64> {
    let mut bins = [0.0; BINS];
    for turn in [0.0, 180.0] {
        for piece in &scene.pieces {
            let heading = (bearing(piece) + turn + 5.0) % 360.0;
            bins[(floor_of(heading, 10.0) as usize).min(BINS - 1)] += piece.length;
        }
    }
    let all: f64 = bins.iter().sum();
    if all <= 0.0 {
        return None;
    }
    let shares = bins.iter().filter(|&&bin| bin > 0.0).map(|bin| bin / all);
    let entropy: f64 = -shares.map(|share| share * libm::log(share)).sum::<f64>();
    let (grid, even) = (libm::log(4.0), libm::log(BINS as f64));
    let share = (entropy - grid) / (even - grid);
    Some(1.0 - share * share)
}

/// The two strongest headings in degrees counter-clockwise from east, modulo 180, in the middle of their degree.
pub fn headings(scene: &Scene) -> Option<[f64; 2]> {
    let mut fine = [0.0; DEGREES];
    for piece in &scene.pieces {
        fine[(bearing(piece).floor() as usize).min(DEGREES - 1)] += piece.length;
    }
    let near = |i: usize| {
        // From the far side to the near one: of headings that are equally strong, the order of sums decides.
        let around = (0..=2 * BESIDE).map(|k| fine[(i + DEGREES + BESIDE - k) % DEGREES]);
        around.fold(0.0, |sum, length| sum + length)
    };
    let soft: Vec<f64> = (0..DEGREES).map(near).collect();
    let first = strongest(&soft, |_| true);
    let second = strongest(&soft, |i| {
        let apart = i.abs_diff(first);
        apart.min(DEGREES - apart) > APART
    });
    (!scene.pieces.is_empty()).then_some([first as f64 + 0.5, second as f64 + 0.5])
}

/// The first of the largest values where `counts`; other values count as nothing.
fn strongest(values: &[f64], counts: impl Fn(usize) -> bool) -> usize {
    let value = |i: usize| if counts(i) { values[i] } else { 0.0 };
    (1..values.len()).fold(0, |best, i| if value(i) > value(best) { i } else { best })
}

/// Degrees counter-clockwise from east, modulo 180.
fn bearing(piece: &Piece) -> f64 {
    let along = Vec2::from_array(piece.to) - Vec2::from_array(piece.from);
    Angle::of(along).to_degrees().rem_euclid(180.0)
}
