//! How much a pattern counts at a place: a formula of maps (PM01 §3.2.2, figure 7).

use super::Field;
use geom::Vec2;

/// A weight over the plane, from 0 to 1, or above for numbers that only compare.
#[derive(Clone, Debug)]
pub enum Weight {
    /// The same everywhere.
    Number(f64),
    /// Read from a map, clamped to 0 … 1.
    Map(Field),
    /// 1 minus another, clamped to 0 … 1.
    Inverse(Box<Self>),
    /// All of them multiplied; 1 for none.
    Product(Vec<Self>),
    /// All of them added.
    Sum(Vec<Self>),
}

impl Weight {
    /// The weight at a place in metres: at least 0, and 0 for what is no number.
    pub fn at(&self, place: Vec2) -> f64 {
        let weight = match self {
            Self::Number(number) => *number,
            Self::Map(field) => field.at(place).clamp(0.0, 1.0),
            Self::Inverse(other) => (1.0 - other.at(place)).clamp(0.0, 1.0),
            Self::Product(factors) => factors.iter().map(|factor| factor.at(place)).product(),
            Self::Sum(terms) => terms.iter().map(|term| term.at(place)).sum(),
        };
        // `max` passes over what is no number.
        if weight.is_finite() { weight.max(0.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_clamped_and_never_negative() {
        let map = |value| Weight::Map(Field::Constant(value));
        let at = |weight: Weight| weight.at(Vec2::ZERO);
        assert_eq!((at(map(3.0)), at(map(-1.0)), at(map(0.25))), (1.0, 0.0, 0.25));
        assert_eq!(at(Weight::Inverse(Box::new(map(0.25)))), 0.75);
        assert_eq!(at(Weight::Product(vec![map(0.5), Weight::Number(4.0)])), 2.0);
        assert_eq!(at(Weight::Sum(vec![map(0.5), Weight::Number(0.25)])), 0.75);
        assert_eq!((at(Weight::Number(f64::NAN)), at(Weight::Number(-2.0))), (0.0, 0.0));
    }
}
