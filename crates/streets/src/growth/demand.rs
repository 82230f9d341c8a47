//! Demand that streets use up (PM01 §3.2.1): "the created street ends still lower the population density in their
//! environment", after the open L-systems of Měch and Prusinkiewicz.
//!
//! Each growth keeps a record of its own, so quarters stay independent of one another. It is kept in whole numbers, so it
//! does not depend on the order in which streets are laid.

use super::Goal;
use geom::Vec2;
use rustc_hash::FxHashMap;

/// Side of a cell of the record, in metres: about a narrow block, so that streets side by side share what is there.
const CELL: f64 = 50.0;
/// A street serves its own cell and this many around it: 125 m to either side, about the area of a block.
const AROUND: i32 = 2;
/// Longest piece of a street that is served from one place, in metres: half a cell, so none is left out.
const PIECE: f64 = CELL / 2.0;
/// Whole numbers per person per km².
const FINENESS: f64 = 1024.0;

/// What is left of a goal's demand.
#[derive(Debug)]
pub(super) struct Demand<'a> {
    goal: &'a Goal,
    /// What streets have used up, by cell. Only ever looked up.
    used: FxHashMap<(i32, i32), i64>,
}

impl<'a> Demand<'a> {
    pub fn new(goal: &'a Goal) -> Self {
        Self { goal, used: FxHashMap::default() }
    }

    /// Whether a street to a place in metres would still serve somebody.
    pub fn is_left_at(&self, place: Vec2) -> bool {
        if self.goal.consume <= 0.0 {
            return true;
        }
        let left = self.left_at(place);
        left > 0.0 && left >= self.goal.least.at(place)
    }

    /// Steps that branches at a place wait for: as the goal says of what is left.
    pub fn delay(&self, place: Vec2) -> u32 {
        if self.goal.consume <= 0.0 { self.goal.delay(place) } else { self.goal.delay_of(place, self.left_at(place)) }
    }

    /// Notes that a street was laid, in metres.
    pub fn serve(&mut self, from: Vec2, to: Vec2) {
        if self.goal.consume <= 0.0 {
            return;
        }
        let length = (to - from).length();
        let pieces = (length / PIECE).ceil().max(1.0);
        let side = f64::from(2 * AROUND + 1) * CELL / 1000.0;
        let people = self.goal.consume * length / 1000.0 / pieces;
        // The cast saturates.
        let each = (people / (side * side) * FINENESS).round() as i64;
        for piece in 0..pieces as u32 {
            self.use_up(from.lerp(to, (f64::from(piece) + 0.5) / pieces), each);
        }
    }

    fn use_up(&mut self, place: Vec2, each: i64) {
        let (x, y) = cell(place);
        for column in x - AROUND..=x + AROUND {
            for row in y - AROUND..=y + AROUND {
                let used = self.used.entry((column, row)).or_default();
                *used = used.saturating_add(each);
            }
        }
    }

    fn left_at(&self, place: Vec2) -> f64 {
        let used = self.used.get(&cell(place)).copied().unwrap_or(0);
        self.goal.density.at(place) - used as f64 / FINENESS
    }
}

/// The cell of a place. Far outside the lattice the casts saturate; nothing is laid there.
fn cell(place: Vec2) -> (i32, i32) {
    let at = (place / CELL).floor();
    let within = |x: f64| (x as i32).clamp(i32::MIN + AROUND, i32::MAX - AROUND);
    (within(at.x), within(at.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::growth::Field;

    #[test]
    fn streets_use_up_what_they_serve_in_any_order() {
        let goal = Goal { consume: 500.0, ..Goal::of(Field::Constant(10_000.0), 100.0, 0.0) };
        let streets: Vec<_> = (0..60).map(|i| (Vec2::new(0.0, f64::from(i)), Vec2::new(400.0, f64::from(i)))).collect();
        let (mut one, mut other) = (Demand::new(&goal), Demand::new(&goal));
        streets.iter().for_each(|&(a, b)| one.serve(a, b));
        streets.iter().rev().for_each(|&(a, b)| other.serve(a, b));
        assert_eq!(one.used, other.used);
        // 24 km of street for 500 people each serve 12,000, all within a band of some 0.14 km².
        assert!(!one.is_left_at(Vec2::new(200.0, 30.0)));
        assert!(one.is_left_at(Vec2::new(200.0, 400.0)));
        let (total, cells) = (one.used.values().sum::<i64>() as f64 / FINENESS, CELL * CELL / 1e6);
        assert!((total * cells - 12_000.0).abs() < 1.0, "{total}");
    }

    #[test]
    fn nothing_is_used_up_where_streets_consume_nothing() {
        let goal = Goal::of(Field::Constant(1.0), 0.0, 0.0);
        let mut demand = Demand::new(&goal);
        demand.serve(Vec2::ZERO, Vec2::splat(1e4));
        assert!(demand.used.is_empty() && demand.is_left_at(Vec2::ZERO));
    }
}
