//! Sides of a ring: runs of edges that hardly turn.

use geom::{Point, Vec2};

/// How far an edge may turn from the first of a side and still belong to it: sine of 5°.
const STRAIGHT: f64 = 0.087;

/// The longest side of a ring in metres, edges that hardly turn counted as one (SCH10 §4.2.6).
pub fn longest_side(ring: &[Point]) -> f64 {
    let base = ring.first().map_or(Vec2::ZERO, |p| p.metres());
    let places: Vec<Vec2> = ring.iter().map(|p| p.metres() - base).collect();
    longest_run(&places, |_| true).map_or(0.0, |(from, to)| from.distance(to))
}

/// The ends of the longest run of edges that count and hardly turn; the first of equals.
pub(crate) fn longest_run(places: &[Vec2], counts: impl Fn(usize) -> bool) -> Option<(Vec2, Vec2)> {
    let n = places.len();
    let step = |edge: usize| places[(edge + 1) % n] - places[edge];
    let mut best: Option<(f64, (Vec2, Vec2))> = None;
    for first in (0..n).filter(|&edge| counts(edge)) {
        let direction = step(first).normalize_or_zero();
        let goes_on = |edge: &usize| {
            let step = step(*edge);
            counts(*edge) && direction.perp_dot(step).abs() <= STRAIGHT * step.length() && direction.dot(step) > 0.0
        };
        let last = (1..n).map(|k| (first + k) % n).take_while(goes_on).last().unwrap_or(first);
        let ends = (places[first], places[(last + 1) % n]);
        let length = ends.0.distance_squared(ends.1);
        if best.is_none_or(|(longest, _)| length > longest) {
            best = Some((length, ends));
        }
    }
    best.map(|(_, ends)| ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::ring;

    #[test]
    fn collinear_edges_are_one_side() {
        let bent = ring(&[(0.0, 0.0), (40.0, 0.0), (90.0, 1.0), (90.0, 60.0), (0.0, 60.0)]);
        assert!((longest_side(&bent) - 90.0).abs() < 0.1, "{}", longest_side(&bent));
        assert_eq!(longest_side(&[]), 0.0);
    }
}
