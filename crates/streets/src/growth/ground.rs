//! Whether a line stays on ground where streets may lie: in the legal area, inside the masks, and not too steep.

use super::chain::{Chain, Legal, Slope, Step, TurnSearch};
use super::mask::Cover;
use super::{Fields, grade};
use geom::{Angle, Raster, Vec2};
use std::sync::Arc;

/// Longest distance between two samples of a line, in metres, however coarse the maps are.
const COARSEST_STEP: f64 = 5.0;
/// Shortest distance between two samples of a line, in metres, however fine the maps are.
const FINEST_STEP: f64 = 1.0;

/// The maps that say where a street may lie, and how finely a line is held against them.
#[derive(Debug)]
pub(super) struct Ground<'a> {
    pub(super) fields: &'a Fields,
    step: f64,
    /// Whether the legal area counts.
    has_legal: bool,
    /// Whether masks of the site or zones restrict.
    has_masks: bool,
    covers: Vec<Cover<'a>>,
    max_slope: f64,
    /// Whether only the rim of the site restricts.
    is_open: bool,
    /// Turns to try, in that order.
    legal_turns: Vec<Turn>,
    slope_turns: Vec<Turn>,
    hairpins: Vec<Turn>,
}

/// A turn of a rotation search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub by: Angle,
    /// Unit vector of that angle.
    pub unit: Vec2,
}

impl<'a> Ground<'a> {
    pub fn new(fields: &'a Fields, chain: &'a Chain) -> Self {
        let has_legal = legal_of(chain).is_some();
        let areas = chain.steps().iter().filter_map(|step| if let Step::Mask(area) = step { Some(area) } else { None });
        let masks = fields.legal.iter().chain(&fields.barred);
        let cell = masks.map(|mask: &Arc<Raster>| mask.pixel_size()).fold(COARSEST_STEP, f64::min);
        let covers: Vec<_> = areas.map(|area| Cover::of(area, fields)).collect();
        // The cells of a mask may be finer, and the corners of a polygon anywhere.
        let cell = if covers.is_empty() { cell.min(fields.zones.cell(FINEST_STEP)) } else { FINEST_STEP };
        let has_masks =
            (has_legal && !(fields.legal.is_empty() && fields.barred.is_empty())) || !fields.zones.is_empty();
        let mut ground = Self {
            fields,
            step: cell.max(FINEST_STEP),
            has_legal,
            has_masks,
            is_open: false,
            covers,
            max_slope: f64::INFINITY,
            legal_turns: Vec::new(),
            slope_turns: Vec::new(),
            hairpins: Vec::new(),
        };
        ground.adopt(chain);
        ground
    }

    /// Takes over the numbers of a chain of the same steps.
    pub fn adopt(&mut self, chain: &Chain) {
        let (legal, slope) = (legal_of(chain), slope_of(chain));
        let least_angle = chain.least_angle().unwrap_or(Angle::ZERO);
        self.max_slope = slope.map_or(f64::INFINITY, |slope| slope.most);
        self.is_open = !self.has_masks && self.covers.is_empty() && self.max_slope.is_infinite();
        self.legal_turns = legal.map_or_else(Vec::new, |legal| turns(&legal.turns));
        self.slope_turns = slope.map_or_else(Vec::new, |slope| turns(&slope.turns));
        self.hairpins =
            slope.filter(|slope| slope.has_hairpins).map_or_else(Vec::new, |slope| hairpins(&slope, least_angle));
    }

    /// The turns of the search for legal area: by ascending size, counter-clockwise first.
    pub fn legal_turns(&self) -> &[Turn] {
        &self.legal_turns
    }

    /// The turns of the search for gentle ground, likewise.
    pub fn slope_turns(&self) -> &[Turn] {
        &self.slope_turns
    }

    /// The turns beyond these, up to the sharpest that the streets may make; none without hairpins.
    pub fn hairpins(&self) -> &[Turn] {
        &self.hairpins
    }

    /// Distance between two samples, in metres.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Whether a place lies in the site.
    pub fn is_in_site(&self, place: Vec2) -> bool {
        self.fields.is_in_site(place)
    }

    /// Whether a street may start at a place.
    pub fn is_legal(&self, place: Vec2) -> bool {
        self.is_legal_at(place) && self.covers.iter().all(|cover| cover.has(place))
    }

    fn is_legal_at(&self, place: Vec2) -> bool {
        if self.has_legal {
            return self.fields.is_legal(place);
        }
        self.fields.is_in_site(place) && self.fields.zones.allow(place)
    }

    /// Whether the whole line is fit: legal, inside the masks, and gentle enough.
    pub fn is_fit(&self, from: Vec2, to: Vec2) -> bool {
        self.legal_share(from, to) >= 1.0 && self.covered_share(from, to) >= 1.0 && self.is_gentle(from, to)
    }

    /// The share of the line from its start up to the last sample before it leaves the legal area; 1 when all of it is
    /// legal. The start itself is taken to be legal.
    pub fn legal_share(&self, from: Vec2, to: Vec2) -> f64 {
        // The site is convex, so a line from inside it stays inside when its end does.
        if self.is_open && self.fields.is_in_site(to) {
            return 1.0;
        }
        self.share_while(from, to, |place| self.is_legal_at(place))
    }

    /// The same for all masks of the chain; a street that starts outside of one has no share.
    pub fn covered_share(&self, from: Vec2, to: Vec2) -> f64 {
        if self.covers.is_empty() {
            return 1.0;
        }
        let is_covered = |place| self.covers.iter().all(|cover| cover.has(place));
        if is_covered(from) { self.share_while(from, to, is_covered) } else { 0.0 }
    }

    fn share_while(&self, from: Vec2, to: Vec2, holds: impl Fn(Vec2) -> bool) -> f64 {
        let samples = ((to - from).length() / self.step).ceil().max(1.0) as u32;
        let place = |i: u32| from.lerp(to, f64::from(i) / f64::from(samples));
        let unfit = (1..=samples).find(|&i| !holds(place(i)));
        unfit.map_or(1.0, |i| f64::from(i - 1) / f64::from(samples))
    }

    /// Whether no part of the line is steeper than the limit.
    pub fn is_gentle(&self, from: Vec2, to: Vec2) -> bool {
        self.gentle_reach(from, to).is_infinite()
    }

    /// How far along the line, in metres, it is gentle enough; infinite when all of it is.
    pub fn gentle_reach(&self, from: Vec2, to: Vec2) -> f64 {
        if self.max_slope.is_infinite() {
            return f64::INFINITY;
        }
        grade::steep_from(&self.fields.elevation, from, to, self.max_slope).unwrap_or(f64::INFINITY)
    }

    /// Whether a straight line through the air or the hill is gentle enough.
    pub fn is_gentle_chord(&self, from: Vec2, to: Vec2) -> bool {
        let rise = self.fields.elevation.at(to) - self.fields.elevation.at(from);
        self.max_slope.is_infinite() || rise.abs() <= self.max_slope * (to - from).length()
    }
}

fn legal_of(chain: &Chain) -> Option<Legal> {
    chain.find(|step| if let Step::Legal(legal) = step { Some(*legal) } else { None })
}

fn slope_of(chain: &Chain) -> Option<Slope> {
    chain.find(|step| if let Step::Slope(slope) = step { Some(*slope) } else { None })
}

fn turns(search: &TurnSearch) -> Vec<Turn> {
    let (step, most) = (search.step.to_radians(), search.most.to_radians());
    // Written so that numbers that are no numbers give no turns.
    let count = if step > 0.0 && most < std::f64::consts::PI { (most / step + 1e-9).floor() } else { 0.0 };
    both_sides(step, 1..=count as u32)
}

/// The turns beyond those of the search, up to the one that leaves the least angle to where a street comes from.
fn hairpins(slope: &Slope, least_angle: Angle) -> Vec<Turn> {
    let step = slope.turns.step.to_radians();
    if step > 0.0 {
        let before = turns(&slope.turns).len() as u32 / 2;
        let most = (std::f64::consts::PI - least_angle.to_radians()) / step;
        both_sides(step, before + 1..=most.max(0.0) as u32)
    } else {
        Vec::new()
    }
}

fn both_sides(step: f64, counts: std::ops::RangeInclusive<u32>) -> Vec<Turn> {
    let turn = |radians: f64| Turn { by: Angle::radians(radians), unit: Angle::radians(radians).unit() };
    counts.flat_map(|k| [turn(step * f64::from(k)), turn(-step * f64::from(k))]).collect()
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

    fn search(step: f64, most: f64) -> TurnSearch {
        TurnSearch { step: Angle::degrees(step), most: Angle::degrees(most) }
    }

    #[test]
    fn finds_how_much_of_a_line_is_dry() {
        let fields = with_water(50..60);
        let chain = Chain::default();
        let ground = Ground::new(&fields, &chain);
        let at = |x: f64| Vec2::new(x, 500.0);
        assert!(ground.is_fit(at(400.0), at(499.0)));
        assert_eq!(ground.legal_share(at(450.0), at(550.0)), 0.45);
        // Both ends are dry, the middle is not.
        assert_eq!(ground.legal_share(at(450.0), at(650.0)), 45.0 / 200.0);
    }

    #[test]
    fn turns_ascend_and_alternate() {
        let degrees: Vec<_> = turns(&search(10.0, 30.0)).iter().map(|turn| turn.by.to_degrees().round()).collect();
        assert_eq!(degrees, [10.0, -10.0, 20.0, -20.0, 30.0, -30.0]);
        assert!(turns(&search(0.0, 90.0)).is_empty());
        assert!(turns(&search(f64::NAN, 90.0)).is_empty());
        let slope = Slope { most: 0.1, turns: search(10.0, 30.0), has_hairpins: true, tunnel: 0.0 };
        let beyond: Vec<_> =
            hairpins(&slope, Angle::degrees(145.0)).iter().map(|turn| turn.by.to_degrees().round()).collect();
        assert_eq!(beyond, []);
        let beyond = hairpins(&slope, Angle::degrees(125.0));
        assert_eq!(
            beyond.iter().map(|turn| turn.by.to_degrees().round()).collect::<Vec<_>>(),
            [40.0, -40.0, 50.0, -50.0]
        );
    }
}
