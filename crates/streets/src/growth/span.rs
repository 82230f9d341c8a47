//! Ways over and under what a street cannot cross: bridges and tunnels (PM01 §3.3).

use super::chain::{Bridge, Over};
use super::ground::Ground;
use geom::Vec2;

/// Lengths that are tried for a tunnel, evenly spread up to the longest.
const TUNNEL_LENGTHS: u32 = 32;

/// Where a tunnel may lie above the ground at most, in metres: a bank this high is no viaduct.
const BANK: f64 = 2.0;

/// A stretch of a line: where it starts and ends, in metres along the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub start: f64,
    pub end: f64,
}

impl Ground<'_> {
    /// For a line that leaves the legal area within `reach` metres: the bridge along the unit vector `along`, from the
    /// last legal sample to `landing` metres beyond the far shore, straight on.
    pub fn far_shore(&self, from: Vec2, along: Vec2, reach: f64, bridge: &Bridge, landing: f64) -> Option<Stretch> {
        let place = |metres: f64| from + along * metres;
        let is_legal = |metres: f64| self.is_legal(place(metres));
        let (step, longest) = (self.step(), bridge.longest);
        let samples = |from: f64, length: f64| (0..=(length / step) as u32).map(move |i| from + f64::from(i) * step);
        let shore = samples(0.0, reach).find(|&metres| !is_legal(metres))?;
        let far = samples(shore, longest).find(|&metres| is_legal(metres))?;
        let spans = |metres: f64| match bridge.over {
            Over::Any => !self.fields.zones.is_kept_free(place(metres)),
            Over::Water => self.fields.is_water(place(metres)) && !self.fields.zones.is_kept_free(place(metres)),
        };
        if !samples(shore, far - shore - step / 2.0).all(spans) || !samples(far, landing + step).all(is_legal) {
            return None;
        }
        let start = (shore - step).max(0.0);
        let end = far + landing;
        self.is_gentle_chord(place(start), place(end)).then_some(Stretch { start, end })
    }

    /// The length in metres of the shortest tunnel from a place along the unit vector `along`, of at least `least` and
    /// at most `longest` metres: below legal ground all the way, gentle from end to end, and through a hill rather than
    /// over a valley.
    pub fn way_through(&self, from: Vec2, along: Vec2, least: f64, longest: f64) -> Option<f64> {
        if least > longest {
            return None;
        }
        let length = |k: u32| least + (longest - least) * f64::from(k) / f64::from(TUNNEL_LENGTHS);
        (0..=TUNNEL_LENGTHS).map(length).find(|length| self.is_tunnel(from, from + along * *length))
    }

    fn is_tunnel(&self, from: Vec2, to: Vec2) -> bool {
        if !self.is_gentle_chord(from, to) || self.legal_share(from, to) < 1.0 || self.covered_share(from, to) < 1.0 {
            return false;
        }
        let [low, high] = [from, to].map(|end| self.fields.elevation.at(end));
        let samples = ((to - from).length() / self.step()).ceil().max(1.0) as u32;
        (1..samples).map(|i| f64::from(i) / f64::from(samples)).all(|share| {
            let chord = low + (high - low) * share;
            self.fields.elevation.at(from.lerp(to, share)) >= chord - BANK
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Chain, Field, Fields};
    use super::*;
    use geom::{Bounds, Point, Raster};
    use std::sync::Arc;

    /// 1 km² of 10 m cells that are as `value` says for the middle of their column.
    fn columns(value: impl Fn(f64) -> f32) -> Arc<Raster> {
        let values = (0..10_000).map(|cell| value(f64::from(cell % 100) * 10.0 + 5.0)).collect();
        Arc::new(Raster::new(100, 100, 10.0, Vec2::ZERO, values).unwrap())
    }

    fn site() -> Fields {
        Fields::plain(Bounds::between(Point::new(0, 0), Point::from_metres(Vec2::splat(1000.0))))
    }

    fn bridge(longest: f64) -> Bridge {
        Bridge { longest, spacing: 0.0, over: Over::Water, is_first: false }
    }

    #[test]
    fn bridges_span_no_more_than_allowed() {
        let land = columns(|x| if (500.0..600.0).contains(&x) { 0.0 } else { 1.0 });
        let (fields, chain) = (Fields { legal: vec![land], ..site() }, Chain::default());
        let ground = Ground::new(&fields, &chain);
        let shore = |x: f64, reach: f64, longest: f64| {
            ground.far_shore(Vec2::new(x, 500.0), Vec2::X, reach, &bridge(longest), 20.0)
        };
        assert_eq!(shore(480.0, 100.0, 100.0), Some(Stretch { start: 15.0, end: 140.0 }));
        assert_eq!(shore(480.0, 100.0, 95.0), None);
        assert_eq!(shore(380.0, 100.0, 500.0), None);
    }

    #[test]
    fn bridges_lead_over_parks_only_when_asked() {
        let park = columns(|x| if (500.0..560.0).contains(&x) { 1.0 } else { 0.0 });
        let (fields, chain) = (Fields { barred: vec![park], ..site() }, Chain::default());
        let ground = Ground::new(&fields, &chain);
        let over =
            |over| ground.far_shore(Vec2::new(495.0, 500.0), Vec2::X, 50.0, &Bridge { over, ..bridge(100.0) }, 20.0);
        assert_eq!(over(Over::Water), None);
        assert_eq!(over(Over::Any), Some(Stretch { start: 0.0, end: 85.0 }));
    }

    #[test]
    fn tunnels_go_through_hills_not_over_valleys() {
        let ridge = |sign: f32| columns(move |x| sign * (60.0 - (x - 500.0).abs() * 0.5).max(0.0) as f32);
        let chain: Chain = super::super::Constraints { max_slope: 0.08, ..Default::default() }.into();
        let way = |sign: f32, from: f64| {
            let fields = Fields { elevation: Field::Map(ridge(sign)), ..site() };
            Ground::new(&fields, &chain).way_through(Vec2::new(from, 500.0), Vec2::X, 60.0, 380.0)
        };
        // The foot is at 380 and 620.
        let length = way(1.0, 375.0).expect("a tunnel");
        assert!((200.0..270.0).contains(&length), "{length}");
        assert_eq!(way(-1.0, 375.0), None);
    }
}
