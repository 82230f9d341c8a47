//! Identity by lineage, and stable hashing.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use xxhash_rust::xxh3::xxh3_128;

/// A stable identity: the hash of where a thing comes from, never of where it lies. Written as 32 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Id(pub u128);

impl Id {
    /// The root of a lineage: what kind of thing starts here, and what it starts from.
    pub fn root(purpose: &str, parts: &[u128]) -> Self {
        let mut bytes = Vec::with_capacity(purpose.len() + 1 + parts.len() * 16);
        bytes.extend_from_slice(purpose.as_bytes());
        bytes.push(0xff);
        for part in parts {
            bytes.extend_from_slice(&part.to_le_bytes());
        }
        Self(xxh3_128(&bytes))
    }

    /// The descendant of this identity in a slot, e.g. the third branch of a street.
    #[must_use]
    pub fn child(self, slot: u64) -> Self {
        self.with(&[u128::from(slot)])
    }

    /// The identity made of this one and others, in that order.
    #[must_use]
    pub fn with(self, parts: &[u128]) -> Self {
        let mut bytes = [0u8; 80];
        assert!(parts.len() <= 4, "an identity is made of at most five parts");
        bytes[..16].copy_from_slice(&self.0.to_le_bytes());
        for (slot, part) in bytes[16..].chunks_exact_mut(16).zip(parts) {
            slot.copy_from_slice(&part.to_le_bytes());
        }
        Self(xxh3_128(&bytes[..16 * (parts.len() + 1)]))
    }

    /// Its 32 hexadecimal digits, as it is displayed, for writing many.
    pub fn digits(self) -> [u8; 32] {
        let mut digits = [0; 32];
        for (pair, byte) in digits.chunks_exact_mut(2).zip(self.0.to_be_bytes()) {
            let digit = |value: u8| b"0123456789abcdef"[usize::from(value)];
            (pair[0], pair[1]) = (digit(byte >> 4), digit(byte & 15));
        }
        digits
    }

    /// The identity of a text, e.g. a layer's name or a record of an imported file.
    pub fn of_text(purpose: &str, text: &str) -> Self {
        Self::root(purpose, &[xxh3_128(text.as_bytes())])
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl fmt::Debug for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl std::str::FromStr for Id {
    type Err = std::num::ParseIntError;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        u128::from_str_radix(text, 16).map(Self)
    }
}

impl Serialize for Id {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // 16 bytes where nobody reads them.
        if serializer.is_human_readable() { serializer.collect_str(self) } else { self.0.serialize(serializer) }
    }
}

impl<'de> Deserialize<'de> for Id {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if !deserializer.is_human_readable() {
            return u128::deserialize(deserializer).map(Self);
        }
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn digits_are_those_shown(id: u128) {
            prop_assert_eq!(Id(id).digits().to_vec(), Id(id).to_string().into_bytes());
        }
    }
}
