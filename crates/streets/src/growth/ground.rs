//! Whether a line stays on ground where streets may lie: in the legal area, and not too steep.

use super::{Constraints, Fields};
use geom::{Angle, Raster, Vec2};
use std::sync::Arc;

/// Longest distance between two samples of a line, in metres, however coarse the maps are.
const COARSEST_STEP: f64 = 5.0;
/// Shortest distance between two samples of a line, in metres, however fine the maps are.
const FINEST_STEP: f64 = 1.0;

/// The maps that say where a street may lie, and how finely a line is held against them.
#[derive(Debug)]
pub(super) struct Ground<'a> {
    fields: &'a Fields,
    step: f64,
    max_slope: f64,
    /// Whether only the rim of the site restricts.
    is_open: bool,
    /// Turns to try, in that order.
    turns: Vec<Turn>,
}

/// A turn of the rotation search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub by: Angle,
    /// Unit vector of that angle.
    pub unit: Vec2,
}

impl<'a> Ground<'a> {
    pub fn new(fields: &'a Fields, constraints: &Constraints) -> Self {
        let masks = fields.legal.iter().chain(&fields.barred);
        let cell = masks.map(|mask: &Arc<Raster>| mask.pixel_size()).fold(COARSEST_STEP, f64::min);
        let is_open = fields.legal.is_empty() && fields.barred.is_empty() && constraints.max_slope.is_infinite();
        Self {
            fields,
            step: cell.max(FINEST_STEP),
            max_slope: constraints.max_slope,
            is_open,
            turns: turns(constraints.turn_step, constraints.turn_most),
        }
    }

    /// The turns of the rotation search: by ascending size, counter-clockwise first.
    pub fn turns(&self) -> &[Turn] {
        &self.turns
    }

    pub fn is_legal(&self, place: Vec2) -> bool {
        self.fields.is_legal(place)
    }

    /// Whether the whole line is fit.
    pub fn is_fit(&self, from: Vec2, to: Vec2) -> bool {
        self.fit_share(from, to) >= 1.0
    }

    /// The share of the line from its start up to the last sample before it becomes unfit; 1 when all of it is fit. The
    /// start itself is taken to be fit.
    pub fn fit_share(&self, from: Vec2, to: Vec2) -> f64 {
        // The site is convex, so a line from inside it stays inside when its end does.
        if self.is_open && self.fields.is_legal(to) {
            return 1.0;
        }
        let samples = ((to - from).length() / self.step).ceil().max(1.0) as u32;
        let unfit = (1..=samples).find(|&i| !self.is_fit_at(from, to, i, samples));
        unfit.map_or(1.0, |i| f64::from(i - 1) / f64::from(samples))
    }

    fn is_fit_at(&self, from: Vec2, to: Vec2, i: u32, samples: u32) -> bool {
        let place = |i: u32| from.lerp(to, f64::from(i) / f64::from(samples));
        self.fields.is_legal(place(i)) && (self.max_slope.is_infinite() || self.is_gentle(place(i - 1), place(i)))
    }

    fn is_gentle(&self, a: Vec2, b: Vec2) -> bool {
        let rise = self.fields.elevation.at(b) - self.fields.elevation.at(a);
        rise.abs() <= self.max_slope * (b - a).length()
    }

    /// For a line that leaves the legal area: how far along the unit vector `along` it has to go, in metres, to come
    /// down `landing` metres beyond the far shore. `None` when the illegal stretch is longer than `span`, or begins
    /// farther than `reach` from the start.
    pub fn far_shore(&self, from: Vec2, along: Vec2, reach: f64, span: f64, landing: f64) -> Option<f64> {
        let is_legal = |metres: f64| self.fields.is_legal(from + along * metres);
        let samples =
            |from: f64, length: f64| (0..=(length / self.step) as u32).map(move |i| from + f64::from(i) * self.step);
        let shore = samples(0.0, reach).find(|&metres| !is_legal(metres))?;
        let far = samples(shore, span).find(|&metres| is_legal(metres))?;
        samples(far, landing + self.step).all(is_legal).then_some(far + landing)
    }
}

fn turns(step: Angle, most: Angle) -> Vec<Turn> {
    let (step, most) = (step.to_radians(), most.to_radians());
    // Written so that numbers that are no numbers give no turns.
    let count = if step > 0.0 && most < std::f64::consts::PI { (most / step + 1e-9).floor() } else { 0.0 };
    let turn = |radians: f64| Turn { by: Angle::radians(radians), unit: Angle::radians(radians).unit() };
    (1..=count as u32).flat_map(|k| [turn(step * f64::from(k)), turn(-step * f64::from(k))]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::{Bounds, Point};

    /// 1 km², with water where x is within `wet`.
    fn with_water(wet: std::ops::Range<usize>) -> Fields {
        let values = (0..10_000).map(|cell| if wet.contains(&(cell % 100)) { 0.0 } else { 1.0 }).collect();
        let land = Raster::new(100, 100, 10.0, Vec2::ZERO, values).unwrap();
        let bounds = Bounds::between(Point::new(0, 0), Point::from_metres(Vec2::splat(1000.0)));
        Fields { legal: vec![Arc::new(land)], ..Fields::plain(bounds) }
    }

    #[test]
    fn finds_how_much_of_a_line_is_dry() {
        let fields = with_water(50..60);
        let ground = Ground::new(&fields, &Constraints::default());
        let at = |x: f64| Vec2::new(x, 500.0);
        assert!(ground.is_fit(at(400.0), at(499.0)));
        assert_eq!(ground.fit_share(at(450.0), at(550.0)), 0.45);
        // Both ends are dry, the middle is not.
        assert_eq!(ground.fit_share(at(450.0), at(650.0)), 45.0 / 200.0);
    }

    #[test]
    fn bridges_span_no_more_than_allowed() {
        let fields = with_water(50..60);
        let ground = Ground::new(&fields, &Constraints::default());
        let shore = |span| ground.far_shore(Vec2::new(480.0, 500.0), Vec2::X, 100.0, span, 20.0);
        assert_eq!(shore(100.0), Some(140.0));
        assert_eq!(shore(95.0), None);
        assert_eq!(ground.far_shore(Vec2::new(380.0, 500.0), Vec2::X, 100.0, 500.0, 20.0), None);
    }

    #[test]
    fn turns_ascend_and_alternate() {
        let degrees: Vec<_> =
            turns(Angle::degrees(10.0), Angle::degrees(30.0)).iter().map(|turn| turn.by.to_degrees().round()).collect();
        assert_eq!(degrees, [10.0, -10.0, 20.0, -20.0, 30.0, -30.0]);
        assert!(turns(Angle::ZERO, Angle::RIGHT).is_empty());
        assert!(turns(Angle::radians(f64::NAN), Angle::RIGHT).is_empty());
    }
}
