//! The standard chain of local constraints (PM01 §3.3) and its parameters.

use super::{Bridge, Chain, Duplicate, Extend, Legal, Length, Over, Slope, Step, TurnSearch};
use geom::{Angle, tolerance};

/// Parameters of the standard chain: length, legal area, slope, crossing, snap, extend, join, duplicate, angle. Lengths
/// in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraints {
    /// A street that ends, or passes a crossing, closer than this goes to it: 5 m for minors, 8 m for majors.
    pub snap: f64,
    /// A street that would meet another within this multiple of its length goes on to it; 1 for never. 1.25.
    pub extend: f64,
    /// Longest piece that a street goes on by: beyond it there is room for a block. On a raster it is the least
    /// length, so that no crossing of the raster is passed where the next piece can be laid. 30 m.
    pub extend_most: f64,
    /// Near-parallel streets closer than this, along more than half of the shorter one, are duplicates; so are those
    /// whose roadways would overlap. 6 m.
    pub duplicate: f64,
    /// Shortest street segment laid. 8 m.
    pub least_length: f64,
    /// Longest street segment proposed; longer proposals are cut. 1 km.
    pub longest: f64,
    /// Least angle between streets at a crossing. 25°.
    pub least_angle: Angle,
    /// Least share of its length that a proposal may be cut back to at the rim of the legal area. 0.5.
    pub prune: f64,
    /// Step of the search for a heading that stays in the legal area, or is gentle enough. 10°.
    pub turn_step: Angle,
    /// Largest turn of that search; 0 for none. 60°.
    pub turn_most: Angle,
    /// Longest stretch of water that a street may cross on a bridge; 0 for none. 0.
    pub bridge: f64,
    /// Steepest slope, rise over run; infinite for any. Infinite.
    pub max_slope: f64,
}

impl Default for Constraints {
    fn default() -> Self {
        Self {
            snap: 5.0,
            extend: 1.25,
            extend_most: 30.0,
            duplicate: 6.0,
            least_length: 8.0,
            longest: 1000.0,
            least_angle: Angle::degrees(tolerance::LEAST_GROWN_ANGLE_DEG),
            prune: 0.5,
            turn_step: Angle::degrees(10.0),
            turn_most: Angle::degrees(60.0),
            bridge: 0.0,
            max_slope: f64::INFINITY,
        }
    }
}

/// Least distance between the ends of two bridges, where nothing else is said, in metres.
pub const BRIDGE_SPACING: f64 = 300.0;

impl Constraints {
    /// The defaults for majors and highways: as the defaults, but snapping within 8 m.
    pub fn majors() -> Self {
        Self { snap: 8.0, ..Self::default() }
    }

    fn turns(&self) -> TurnSearch {
        TurnSearch { step: self.turn_step, most: self.turn_most }
    }

    fn legal(&self) -> Legal {
        let bridge = Bridge { longest: self.bridge, spacing: BRIDGE_SPACING, over: Over::Water, is_first: false };
        Legal {
            prune: self.prune,
            turns: self.turns(),
            turns_first: false,
            bridge: (self.bridge > 0.0).then_some(bridge),
        }
    }

    fn slope(&self) -> Slope {
        Slope { most: self.max_slope, turns: self.turns(), has_hairpins: false, tunnel: 0.0 }
    }
}

impl From<Constraints> for Chain {
    fn from(standard: Constraints) -> Self {
        Self::new(vec![
            Step::Length(Length { least: standard.least_length, longest: standard.longest }),
            Step::Legal(standard.legal()),
            Step::Slope(standard.slope()),
            Step::Crossing,
            Step::Snap(standard.snap),
            Step::Extend(Extend { factor: standard.extend, most: standard.extend_most }),
            Step::Join(standard.snap),
            Step::Duplicate(Duplicate { within: standard.duplicate, is_whole: false }),
            Step::Angle(standard.least_angle),
        ])
    }
}
