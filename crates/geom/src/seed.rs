//! Chance as a value derived from identity: counter-based and keyed, no generator that two things share.

use crate::Id;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// Where chance comes from. Two draws with equal keys are equal; a draw changes no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Seed(pub u64);

impl Seed {
    /// The seed of one thing: `hash(seed, stable id)`.
    #[must_use]
    pub fn of(self, id: Id) -> Self {
        Self(xxh3_64_with_seed(&id.0.to_le_bytes(), self.0))
    }

    /// The seed for one purpose.
    #[must_use]
    pub fn purpose(self, purpose: &str) -> Self {
        Self(xxh3_64_with_seed(purpose.as_bytes(), self.0 ^ 0x9e37_79b9_7f4a_7c15))
    }

    /// The seed of a numbered part.
    #[must_use]
    pub fn child(self, ordinal: u64) -> Self {
        Self(xxh3_64_with_seed(&ordinal.to_le_bytes(), self.0))
    }

    /// A number in [0, 1) drawn for the ordinal; 53 random bits.
    pub fn unit(self, ordinal: u64) -> f64 {
        (self.child(ordinal).0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number in [low, high) drawn for the ordinal.
    pub fn range(self, ordinal: u64, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit(ordinal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_keyed_and_spread() {
        let seed = Seed(1).purpose("test");
        assert_eq!(seed.unit(7), seed.unit(7));
        assert_ne!(seed.unit(7), Seed(2).purpose("test").unit(7));
        let mean = (0..10_000).map(|i| seed.unit(i)).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01, "mean {mean}");
    }
}
