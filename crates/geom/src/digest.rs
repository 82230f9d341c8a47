//! Digests of content: what a result was made from, as one number to look it up by.

use crate::{Id, Raster};
use std::fmt::{self, Debug, Write};
use xxhash_rust::xxh3::Xxh3;

/// A digest being made. What is added in another order, or parted otherwise, gives another one.
#[derive(Clone)]
pub struct Digest(Xxh3);

impl Digest {
    /// A digest of something of a kind.
    pub fn new(kind: &str) -> Self {
        let mut digest = Self(Xxh3::new());
        digest.text(kind);
        digest
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.0.update(text.as_bytes());
        // No text contains this byte.
        self.0.update(&[0xff]);
        self
    }

    /// Adds all that `Debug` shows of a value: of a type that derives it, every field, numbers in as many digits as tell
    /// them apart.
    pub fn value(&mut self, value: &(impl Debug + ?Sized)) -> &mut Self {
        // Nothing fails on the way but a `Debug` that gives up, and then what came before counts.
        let _ = write!(self, "{value:?}");
        self.0.update(&[0xff]);
        self
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Adds an identity.
    pub fn id(&mut self, id: Id) -> &mut Self {
        self.0.update(&id.0.to_le_bytes());
        self
    }

    /// Adds a raster with all its values.
    pub fn raster(&mut self, raster: &Raster) -> &mut Self {
        self.value(&(raster.size(), raster.pixel_size(), raster.origin()));
        let mut bytes = Vec::new();
        for row in raster.values().chunks(raster.size().0) {
            bytes.clear();
            bytes.extend(row.iter().flat_map(|value| value.to_bits().to_le_bytes()));
            self.0.update(&bytes);
        }
        self
    }

    /// The digest of all that was added.
    pub fn finish(&self) -> Id {
        Id(self.0.digest128())
    }
}

impl Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Digest({})", self.finish())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec2;

    fn of(parts: &[&str]) -> Id {
        let mut digest = Digest::new("test");
        parts.iter().for_each(|part| {
            digest.text(part);
        });
        digest.finish()
    }

    #[test]
    fn order_and_parting_count() {
        assert_eq!(of(&["a", "b"]), of(&["a", "b"]));
        assert_ne!(of(&["a", "b"]), of(&["b", "a"]));
        assert_ne!(of(&["a", "b"]), of(&["ab"]));
        assert_ne!(of(&["a", ""]), of(&["a"]));
        assert_ne!(Digest::new("test").finish(), Digest::new("other").finish());
    }

    #[test]
    fn numbers_that_differ_in_the_last_bit_differ() {
        let of = |number: f64| Digest::new("test").value(&number).finish();
        assert_ne!(of(0.1), of(f64::from_bits(0.1f64.to_bits() + 1)));
        assert_ne!(of(0.0), of(-0.0));
    }

    #[test]
    fn every_value_of_a_raster_counts() {
        let of = |values: &[f32], origin: f64| {
            let raster = Raster::new(2, 2, 5.0, Vec2::splat(origin), values.to_vec()).unwrap();
            Digest::new("test").raster(&raster).finish()
        };
        assert_eq!(of(&[1.0, 2.0, 3.0, 4.0], 0.0), of(&[1.0, 2.0, 3.0, 4.0], 0.0));
        assert_ne!(of(&[1.0, 2.0, 3.0, 4.0], 0.0), of(&[1.0, 2.0, 3.0, 4.5], 0.0));
        assert_ne!(of(&[1.0, 2.0, 3.0, 4.0], 0.0), of(&[1.0, 2.0, 3.0, 4.0], 1.0));
    }
}
