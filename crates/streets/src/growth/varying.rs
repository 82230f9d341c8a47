//! Numbers of a chain that differ by place: each is read where a proposal starts.

use super::Field;
use super::chain::{Chain, Step};
use geom::{Angle, Vec2};

/// A number of a step. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Shortest piece of street.
    LeastLength,
    /// Longest piece of street.
    Longest,
    /// Least share that a proposal may be cut back to at the rim of the legal area.
    Prune,
    /// Largest turn of the search for legal area, in degrees.
    LegalTurn,
    /// Longest stretch that a bridge leads over; none at 0.
    Bridge,
    /// Least distance between the ends of two bridges.
    BridgeSpacing,
    /// Steepest slope, rise over run.
    Slope,
    /// Largest turn of the search for gentle ground, in degrees.
    SlopeTurn,
    /// Longest way through a hill.
    Tunnel,
    /// Snapping distance.
    Snap,
    /// Within which multiple of its length a street goes on.
    Extend,
    /// Longest piece that it goes on by.
    ExtendMost,
    /// Joining distance.
    Join,
    /// Distance of duplicates.
    Duplicate,
    /// Least angle between streets, in degrees.
    Angle,
    /// Most streets of a crossing, rounded.
    Arms,
}

impl Quantity {
    /// Sets it in a step that has it.
    fn set(self, step: &mut Step, value: f64) {
        match (self, step) {
            (Self::LeastLength, Step::Length(length)) => length.least = value,
            (Self::Longest, Step::Length(length)) => length.longest = value,
            (Self::Prune, Step::Legal(legal)) => legal.prune = value,
            (Self::LegalTurn, Step::Legal(legal)) => legal.turns.most = Angle::degrees(value),
            (Self::Bridge, Step::Legal(legal)) => {
                legal.bridge = legal.bridge.filter(|_| value > 0.0);
                legal.bridge.iter_mut().for_each(|bridge| bridge.longest = value);
            }
            (Self::BridgeSpacing, Step::Legal(legal)) => {
                legal.bridge.iter_mut().for_each(|bridge| bridge.spacing = value);
            }
            (Self::Slope, Step::Slope(slope)) => slope.most = value,
            (Self::SlopeTurn, Step::Slope(slope)) => slope.turns.most = Angle::degrees(value),
            (Self::Tunnel, Step::Slope(slope)) => slope.tunnel = value,
            (Self::Snap, Step::Snap(metres)) | (Self::Join, Step::Join(metres)) => *metres = value,
            (Self::Extend, Step::Extend(extend)) => extend.factor = value,
            (Self::ExtendMost, Step::Extend(extend)) => extend.most = value,
            (Self::Duplicate, Step::Duplicate(duplicate)) => duplicate.within = value,
            (Self::Angle, Step::Angle(least)) => *least = Angle::degrees(value),
            // The cast saturates.
            (Self::Arms, Step::Arms(most)) => *most = value.round() as u32,
            _ => {}
        }
    }
}

/// A number that differs by place.
#[derive(Clone, Debug)]
pub struct Varying {
    /// Which.
    pub quantity: Quantity,
    /// Its values.
    pub values: Field,
}

impl Chain {
    /// The chain as it holds for a proposal that starts at a place in metres; none where it is the same everywhere, so
    /// that nothing is read or copied then.
    pub fn at(&self, place: Vec2) -> Option<Self> {
        if let Some(districts) = self.districts() {
            let own = districts.at(place);
            return Some(own.at(place).unwrap_or_else(|| own.clone()));
        }
        if self.varying().is_empty() {
            return None;
        }
        let mut steps = self.steps().to_vec();
        for Varying { quantity, values } in self.varying() {
            let value = values.at(place);
            steps.iter_mut().for_each(|step| quantity.set(step, value));
        }
        Some(Self::new(steps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::growth::{Constraints, Length};
    use geom::Raster;
    use std::sync::Arc;

    #[test]
    fn a_chain_differs_where_its_numbers_do() {
        let ramp = Raster::new(2, 1, 100.0, Vec2::ZERO, vec![10.0, 30.0]).unwrap();
        let plain: Chain = Constraints { bridge: 50.0, ..Constraints::default() }.into();
        assert!(plain.at(Vec2::ZERO).is_none());
        let varying = [
            Varying { quantity: Quantity::Snap, values: Field::Map(Arc::new(ramp.clone())) },
            Varying { quantity: Quantity::Longest, values: Field::Map(Arc::new(ramp)) },
            Varying { quantity: Quantity::Bridge, values: Field::Constant(0.0) },
        ];
        let chain = plain.varied(varying.to_vec());
        let at = |x: f64| chain.at(Vec2::new(x, 50.0)).expect("it differs");
        assert_eq!([at(0.0).snap(), at(100.0).snap(), at(200.0).snap()], [10.0, 20.0, 30.0]);
        assert_eq!(at(200.0).length(), Length { least: 8.0, longest: 30.0 });
        let has_bridge =
            |chain: &Chain| chain.steps().iter().any(|s| matches!(s, Step::Legal(l) if l.bridge.is_some()));
        assert!(has_bridge(&chain) && !has_bridge(&at(0.0)), "none where its length is 0");
    }
}
