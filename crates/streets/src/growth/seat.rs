//! Where a seed may sit so that what grows from it lies on the raster its rule asks for.

use super::Steer;
use geom::{Angle, Point, Vec2};
use smallvec::SmallVec;

/// A place for a seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seat {
    pub at: Point,
    pub heading: Angle,
    /// Whether it lies between two crossings of a line of the raster, where no branch may leave.
    pub is_between_crossings: bool,
}

/// The seats near a place, best first: the nearest crossing of the raster, then the nearest places on its lines. So a
/// quarter without a crossing of the raster still gets the streets that run through it.
pub(super) fn seats(steer: Steer, at: Point, seed_heading: Angle) -> SmallVec<[Seat; 3]> {
    let place = at.metres();
    let to_crossing = steer.settle(place) - place;
    let mut lines = match steer {
        Steer::Cross { .. } => {
            return SmallVec::from_elem(Seat { at, heading: seed_heading, is_between_crossings: false }, 1);
        }
        Steer::Raster { heading, .. } => {
            let (u, v) = (heading.unit(), heading.unit().perp());
            [Some((v * to_crossing.dot(v), heading)), Some((u * to_crossing.dot(u), heading + Angle::RIGHT))]
        }
        Steer::Rings(rings) => rings.lines(place).map(|line| line.map(|(at, heading)| (at - place, heading))),
    };
    let mut seats = SmallVec::new();
    let mut offer = |step: Vec2, heading: Angle, is_between_crossings: bool| {
        if let Some(at) = Point::try_from_metres(place + step) {
            seats.push(Seat { at, heading, is_between_crossings });
        }
    };
    offer(to_crossing, seed_heading, false);
    let far = |line: &Option<(Vec2, Angle)>| line.map_or(f64::INFINITY, |(step, _)| step.length_squared());
    // The sort is stable: of equally near lines the first stays first.
    lines.sort_by(|a, b| far(a).total_cmp(&far(b)));
    for (step, heading) in lines.into_iter().flatten() {
        offer(step, heading, true);
    }
    seats
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offers_the_crossing_then_the_nearer_line() {
        let steer = Steer::Raster { heading: Angle::ZERO, along: 200.0, across: 80.0, origin: Vec2::new(10.0, 0.0) };
        let at = Point::from_metres(Vec2::new(190.0, 30.0));
        let seats = seats(steer, at, Angle::STRAIGHT);
        let places: Vec<_> = seats.iter().map(|seat| seat.at.metres().round()).collect();
        assert_eq!(places, [Vec2::new(210.0, 0.0), Vec2::new(210.0, 30.0), Vec2::new(190.0, 0.0)]);
        assert_eq!(seats[1].heading, Angle::RIGHT);
        assert_eq!(seats.iter().map(|seat| seat.is_between_crossings).collect::<Vec<_>>(), [false, true, true]);
    }
}
