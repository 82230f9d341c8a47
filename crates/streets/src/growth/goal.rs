//! Global goals that growth itself sees to: demand for streets, and how fast it is met (PM01 §3.2.1). Directions and
//! lengths are the business of the rules.

use super::Field;
use geom::Vec2;

/// Density as a goal: streets end where nobody lives, and branch later where few do.
#[derive(Clone, Debug)]
pub struct Goal {
    /// People per km², or any measure of demand.
    pub density: Field,
    /// Demand below which a proposal is refused.
    pub least: Field,
    /// Demand at and above which nothing waits; the delay below it grows linearly.
    pub full: Field,
    /// Derivation steps that a branch waits for where the demand is zero.
    pub pace: Field,
    /// People that a kilometre of street serves: what it takes from the density around it, so that streets stop growing
    /// where everyone is served. 0 for none: demand then lasts for ever.
    pub consume: f64,
}

impl Goal {
    /// A goal whose `full` is the largest value of the density.
    pub fn of(density: Field, least: impl Into<Field>, pace: impl Into<Field>) -> Self {
        let full = match &density {
            Field::Constant(value) => *value,
            // At least 0.
            map => map.range().1.max(0.0),
        };
        Self { density, least: least.into(), full: full.into(), pace: pace.into(), consume: 0.0 }
    }

    /// Demand everywhere: refuses nothing, delays nothing.
    pub fn none() -> Self {
        Self { full: Field::Constant(1.0), ..Self::of(Field::Constant(1.0), 0.0, 0.0) }
    }

    /// Whether streets are wanted at a place in metres.
    pub fn is_met(&self, place: Vec2) -> bool {
        // Written so that a density that is not a number refuses.
        self.density.at(place) >= self.least.at(place)
    }

    /// Derivation steps that branches at a place wait for on top of their own delay: `pace · (1 - density / full)`,
    /// rounded; none where `full` or `pace` is not positive.
    pub fn delay(&self, place: Vec2) -> u32 {
        self.delay_of(place, self.density.at(place))
    }

    /// The same for another density there.
    pub(super) fn delay_of(&self, place: Vec2, density: f64) -> u32 {
        let (full, pace) = (self.full.at(place), self.pace.at(place));
        if full <= 0.0 || pace <= 0.0 {
            return 0;
        }
        let share = (density / full).clamp(0.0, 1.0);
        // The cast saturates, and a value that is not a number becomes 0.
        (pace * (1.0 - share)).round() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::Raster;
    use std::sync::Arc;

    #[test]
    fn branches_wait_in_proportion_to_missing_demand() {
        let map = Raster::new(4, 1, 100.0, Vec2::ZERO, vec![0.0, 250.0, 500.0, 1000.0]).unwrap();
        let goal = Goal::of(Field::Map(Arc::new(map)), 100.0, 8.0);
        let centre = |column: usize| Vec2::new(50.0 + 100.0 * column as f64, 50.0);
        assert_eq!([0, 1, 2, 3].map(|column| goal.delay(centre(column))), [8, 6, 4, 0]);
        assert_eq!([0, 1, 2, 3].map(|column| goal.is_met(centre(column))), [false, true, true, true]);
    }

    #[test]
    fn no_goal_refuses_and_delays_nothing() {
        let goal = Goal::none();
        assert!(goal.is_met(Vec2::new(1e6, -1e6)));
        assert_eq!(goal.delay(Vec2::ZERO), 0);
    }
}
