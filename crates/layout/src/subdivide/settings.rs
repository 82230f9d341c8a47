//! What a recursive division aims at.

use super::outline::Measure;
use geom::Seed;

/// What cuts are squared to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Squared {
    /// Whatever makes the best pieces: the smallest rectangle around them, their longest frontage, a reflex corner.
    #[default]
    Best,
    /// Their longest side, collinear edges counted as one (SCH10 §4.2.6).
    Side,
    /// Their longest side on a street; the longest side where none is.
    Street,
}

/// What becomes of parcels that lie behind others, without access.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inner {
    /// Open land, joined into courts (`deleteInnerLots` of SCH10 §4.2.6, but declared and not dropped).
    #[default]
    Open,
    /// Inner parcels that may carry buildings.
    Built,
}

/// What a recursive division aims at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecursiveSettings {
    /// Least area of a parcel, m²: no cut makes a smaller one.
    pub least_area: f64,
    /// Area up to which a piece is not cut any more, m².
    pub most_area: f64,
    /// How much that area differs from piece to piece: each draws its own between `1 - spread` times `most_area` and
    /// `most_area`. 0 to 0.9.
    pub spread: f64,
    /// Least length of frontage on one street that counts as access, metres.
    pub least_frontage: f64,
    /// How far cuts stray from the middle, as a share of the length they cut: 0 to 0.4.
    pub irregularity: f64,
    /// Share of the pieces that must keep access where they can: no cut takes it from them, and what lacks it joins a
    /// neighbour. For the others, access does not count.
    pub forced_access: f64,
    /// Least share of its convex hull that a parcel fills: cuts and joins keep to it where they can, and what stays
    /// below is open land (PM01 §4.1 forbids concave allotments). 0 asks for nothing.
    pub least_convexity: f64,
    /// What cuts are squared to.
    pub squared: Squared,
    /// Whether pieces that are too small, too thin or without access join a neighbour; they stay open land otherwise.
    pub join: bool,
    /// What parcels without access become.
    pub inner: Inner,
    /// Chance.
    pub seed: Seed,
}

impl Default for RecursiveSettings {
    fn default() -> Self {
        Self {
            least_area: 150.0,
            most_area: 900.0,
            spread: 0.0,
            least_frontage: 8.0,
            irregularity: 0.1,
            forced_access: 1.0,
            least_convexity: 0.0,
            squared: Squared::Best,
            join: true,
            inner: Inner::Open,
            seed: Seed(0),
        }
    }
}

/// Settings that make no sense.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// Not a number in its range.
    #[error("{name} is {value}; it must lie between {low} and {high} {unit}")]
    OutOfRange {
        /// Which setting.
        name: &'static str,
        /// What it was.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
        /// In what.
        unit: &'static str,
    },
    /// The least area is greater than the most.
    #[error("least_area ({least} m²) is greater than most_area ({most} m²)")]
    AreasCrossed {
        /// Least area, m².
        least: f64,
        /// Most area, m².
        most: f64,
    },
}

/// What a setting may be: name, value, least, greatest, unit.
type Bound = (&'static str, f64, f64, f64, &'static str);

/// Draws of a piece's chance: 0 to 2 shift cuts.
const SPREAD_DRAW: u64 = 16;
const ACCESS_DRAW: u64 = 17;

impl RecursiveSettings {
    /// Whether the settings make sense.
    pub fn check(&self) -> Result<(), SettingsError> {
        let bounds: [Bound; 7] = [
            ("least_area", self.least_area, 0.0, 1e9, "m²"),
            ("most_area", self.most_area, 4.0, 1e9, "m²"),
            ("spread", self.spread, 0.0, 0.9, "of most_area"),
            ("least_frontage", self.least_frontage, 0.0, 1e4, "m"),
            ("irregularity", self.irregularity, 0.0, 0.4, "of the length cut"),
            ("forced_access", self.forced_access, 0.0, 1.0, "of all pieces"),
            ("least_convexity", self.least_convexity, 0.0, 0.99, "of the convex hull"),
        ];
        for (name, value, low, high, unit) in bounds {
            if !(value >= low && value <= high) {
                return Err(SettingsError::OutOfRange { name, value, low, high, unit });
            }
        }
        if self.least_area > self.most_area {
            return Err(SettingsError::AreasCrossed { least: self.least_area, most: self.most_area });
        }
        Ok(())
    }

    pub(super) fn has_access(&self, measure: &Measure) -> bool {
        let longest = measure.longest_frontage();
        longest > 0.0 && longest >= self.least_frontage
    }

    /// Whether a piece is large and wide enough to be built on.
    pub(super) fn is_roomy(&self, measure: &Measure) -> bool {
        measure.area >= self.least_area && measure.width() * 2.0 >= self.least_frontage
    }

    /// Whether a piece can be built on: large and wide enough, and on a street.
    pub(super) fn is_sound(&self, measure: &Measure) -> bool {
        self.is_roomy(measure) && self.has_access(measure)
    }

    /// Whether the piece with this chance is one of those that must keep access.
    pub(super) fn forces_access(&self, seed: Seed) -> bool {
        self.forced_access >= 1.0 || seed.unit(ACCESS_DRAW) < self.forced_access
    }

    /// Area up to which the piece with this chance is not cut any more, m².
    pub(super) fn wanted_area(&self, seed: Seed) -> f64 {
        if self.spread > 0.0 { self.most_area * (1.0 - self.spread * seed.unit(SPREAD_DRAW)) } else { self.most_area }
    }
}
