//! Rings and rays around a centre (PM01 §3.2.2, the Paris rule; SCH10 §4.2.2): a raster in polar coordinates, with
//! absolute centre and phase, so that what grows in different quarters lines up.
//!
//! Rings are circles, laid as polylines whose every point lies on the circle. Between one ring and the next run rays;
//! their number doubles outwards wherever they would otherwise be too far apart, so that every ray starts on a ring.
//! (SCH10 intersects two circles and calls the chord a tangent: it leaves the circle it should keep to.)

use geom::{Angle, Vec2};

/// Most doublings of the number of rays.
const MOST_DOUBLINGS: u32 = 24;
/// What counts as lying on a ring or a ray: this share of the distance to the next.
const NEAR: f64 = 0.02;
const TURN: f64 = 2.0 * std::f64::consts::PI;

/// Rings and rays around a centre. Lengths in metres, all positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rings {
    /// Where they are centred.
    pub centre: Vec2,
    /// Radius of the innermost ring; within it nothing is laid.
    pub inner: f64,
    /// From ring to ring.
    pub spacing: f64,
    /// Rays that leave the innermost ring; at least 5.
    pub rays: u32,
    /// Wanted distance between rays: they lie from 0.7 to 1.4 times as far apart, but for the innermost ones.
    pub arc: f64,
    /// Longest straight piece of a ring.
    pub chord: f64,
}

/// A place in polar coordinates.
#[derive(Clone, Copy, Debug)]
struct Polar {
    radius: f64,
    /// Radians, counter-clockwise from east.
    angle: f64,
}

impl Rings {
    /// Direction away from the centre; east at the centre itself.
    pub fn outward(&self, place: Vec2) -> Angle {
        Angle::of(place - self.centre)
    }

    /// The point of a ring, where a ray or a piece of the ring ends, that lies nearest to a place.
    pub fn settle(&self, place: Vec2) -> Vec2 {
        let at = self.polar(place);
        let ring = self.nearest_ring(at.radius);
        let step = TURN / self.points(ring);
        self.place(self.radius(ring), (at.angle / step).round() * step)
    }

    /// The places on the lines around a place, with the heading of the line: on the nearest ring, on the nearest ray.
    pub fn lines(&self, place: Vec2) -> [Option<(Vec2, Angle)>; 2] {
        let at = self.polar(place);
        let ring = self.place(self.radius(self.nearest_ring(at.radius)), at.angle);
        let step = TURN / self.rays_beyond(self.ring_below(at.radius));
        let ray = (at.angle / step).round() * step;
        let has_ray = at.radius >= self.inner;
        [
            Some((ring, Angle::radians(at.angle) + Angle::RIGHT)),
            has_ray.then(|| (self.place(at.radius, ray), Angle::radians(ray))),
        ]
    }

    /// Whether a street may leave a place in a direction (a unit vector): rays leave rings where they belong, and none
    /// goes on within the innermost ring. A side street of one that was cut short between two rings (at water, at the rim)
    /// is no ring, and a ray only where one belongs.
    pub fn leads(&self, from: Vec2, along: Vec2, is_side: bool) -> bool {
        let at = self.polar(from);
        let outward = Angle::radians(at.angle).unit();
        let is_on_ray = along.dot(outward).abs() >= outward.perp_dot(along).abs();
        let ring = self.nearest_ring(at.radius);
        if (at.radius - self.radius(ring)).abs() > NEAR * self.spacing {
            return !is_side || (is_on_ray && self.has_ray_at(from, outward.perp()));
        }
        if !is_on_ray {
            return true;
        }
        let goes_out = along.dot(outward) > 0.0;
        if !goes_out && ring == 0 {
            return false;
        }
        let rays = self.rays_beyond(if goes_out { ring } else { ring - 1 });
        !is_multiple(at.angle, TURN / self.points(ring)) || is_multiple(at.angle, TURN / rays)
    }

    /// Whether a street that comes along in a direction (a unit vector) is to be left here: along a ray always, along a
    /// ring by about as many rays as the next ring outside gets. For streets that lie on no ring.
    pub fn has_ray_at(&self, from: Vec2, along: Vec2) -> bool {
        let at = self.polar(from);
        let outward = Angle::radians(at.angle).unit();
        let ring = self.ring_below(at.radius);
        let (points, rays) = (self.points(ring), self.rays_beyond(ring));
        let nearest = (at.angle / TURN * points).round();
        along.dot(outward).abs() >= outward.perp_dot(along).abs() || nearest.rem_euclid(points / rays) < 0.5
    }

    /// Where a street from a place ends that goes about `length` metres in a direction (a unit vector): outwards or
    /// inwards on a ring, along a ring on one of its points. `None` within the innermost ring. `least` metres are gone at
    /// least. A start that lies on no ring or ray stays on its own circle or line.
    pub fn target(&self, from: Vec2, along: Vec2, length: f64, least: f64) -> Option<Vec2> {
        let at = self.polar(from);
        let outward = Angle::radians(at.angle).unit();
        let (out, aside) = (along.dot(outward), outward.perp_dot(along));
        if out.abs() >= aside.abs() {
            let radius = self.ring_towards(at.radius, out.signum(), length, least)?;
            return Some(self.place(radius, at.angle));
        }
        let ring = self.nearest_ring(at.radius);
        let is_on_ring = (at.radius - self.radius(ring)).abs() <= NEAR * self.spacing;
        let radius = if is_on_ring { self.radius(ring) } else { at.radius };
        let step = TURN / self.points(if is_on_ring { ring } else { self.ring_below(at.radius) });
        let turn = aside.signum();
        // One piece of a ring, however long the street wants to be: a longer one would leave the circle.
        let piece = length.min(step * radius);
        let mut angle = ((at.angle + turn * piece / radius) / step).round() * step;
        if (angle - at.angle) * turn * radius < least / 2.0 {
            angle += turn * step;
        }
        Some(self.place(radius, angle))
    }

    /// The radius of the ring to end on, going out (1) or in (-1).
    fn ring_towards(&self, radius: f64, way: f64, length: f64, least: f64) -> Option<f64> {
        let mut ring = ((radius + way * length - self.inner) / self.spacing).round();
        if (self.inner + ring * self.spacing - radius) * way < least / 2.0 {
            ring += way;
        }
        // Written so that what is no number ends here.
        (ring >= 0.0).then_some(self.inner + ring * self.spacing)
    }

    fn polar(&self, place: Vec2) -> Polar {
        let from = place - self.centre;
        Polar { radius: from.length(), angle: Angle::of(from).to_radians() }
    }

    fn place(&self, radius: f64, angle: f64) -> Vec2 {
        self.centre + Angle::radians(angle).unit() * radius
    }

    fn radius(&self, ring: u32) -> f64 {
        self.inner + f64::from(ring) * self.spacing
    }

    // The casts saturate: what is negative or no number becomes 0.
    fn nearest_ring(&self, radius: f64) -> u32 {
        ((radius - self.inner) / self.spacing).round() as u32
    }

    fn ring_below(&self, radius: f64) -> u32 {
        ((radius - self.inner) / self.spacing + NEAR).floor() as u32
    }

    /// How many rays run from a ring to the next one.
    fn rays_beyond(&self, ring: u32) -> f64 {
        let round = TURN * self.radius(ring);
        let least = self.arc * std::f64::consts::FRAC_1_SQRT_2;
        doubled(f64::from(self.rays), |rays| round / (2.0 * rays) >= least)
    }

    /// How many points a ring has.
    fn points(&self, ring: u32) -> f64 {
        let round = TURN * self.radius(ring);
        doubled(self.rays_beyond(ring), |points| round / points > self.chord)
    }
}

/// A count, doubled as long as there is room.
fn doubled(count: f64, has_room: impl Fn(f64) -> bool) -> f64 {
    let mut count = count.max(1.0);
    for _ in 0..MOST_DOUBLINGS {
        if !has_room(count) {
            break;
        }
        count *= 2.0;
    }
    count
}

fn is_multiple(angle: f64, step: f64) -> bool {
    let turns = angle / step;
    (turns - turns.round()).abs() <= NEAR
}

#[cfg(test)]
mod tests {
    use super::*;

    const RINGS: Rings =
        Rings { centre: Vec2::new(30.0, -20.0), inner: 60.0, spacing: 100.0, rays: 8, arc: 120.0, chord: 60.0 };

    fn on(radius: f64, degrees: f64) -> Vec2 {
        RINGS.centre + Angle::degrees(degrees).unit() * radius
    }

    #[test]
    fn rays_double_outwards_and_stay_in_bounds() {
        let rays: Vec<f64> = (0..12).map(|ring| RINGS.rays_beyond(ring)).collect();
        assert!(rays.windows(2).all(|pair| pair[1] == pair[0] || pair[1] == 2.0 * pair[0]), "{rays:?}");
        for (ring, rays) in rays.iter().enumerate().skip(2) {
            let arc = TURN * RINGS.radius(ring as u32) / rays;
            assert!((0.7 * 120.0..1.45 * 120.0).contains(&arc), "ring {ring}: {arc}");
        }
        assert!((0..12).all(|ring| TURN * RINGS.radius(ring) / RINGS.points(ring) <= 60.0));
    }

    #[test]
    fn rings_keep_their_radius_and_close() {
        let mut at = on(260.0, 0.0);
        let points = RINGS.points(2) as usize;
        for _ in 0..points {
            let along = (RINGS.outward(at) + Angle::RIGHT).unit();
            at = RINGS.target(at, along, 500.0, 8.0).unwrap();
            assert!(((at - RINGS.centre).length() - 260.0).abs() < 1e-9);
        }
        assert!((at - on(260.0, 0.0)).length() < 1e-6);
    }

    #[test]
    fn rays_run_from_ring_to_ring() {
        let go = |from, degrees| RINGS.target(from, Angle::degrees(degrees).unit(), 80.0, 8.0);
        assert!((go(on(160.0, 45.0), 45.0).unwrap() - on(260.0, 45.0)).length() < 1e-9);
        assert!((go(on(160.0, 45.0), 225.0).unwrap() - on(60.0, 45.0)).length() < 1e-9);
        assert_eq!(go(on(60.0, 45.0), 225.0), None);
        // Off the rings it keeps to its own ray.
        assert!((go(on(190.0, 7.0), 7.0).unwrap() - on(260.0, 7.0)).length() < 1e-9);
    }

    #[test]
    fn rays_leave_rings_only_where_they_belong() {
        let leads = |radius, degrees: f64, heading: f64| {
            RINGS.leads(on(radius, degrees), Angle::degrees(degrees + heading).unit(), false)
        };
        assert!(leads(60.0, 45.0, 0.0) && leads(60.0, 45.0, 90.0) && !leads(60.0, 45.0, 180.0));
        // Ring 1 has 8 rays within it and 8 beyond, 16 points; ring 2 has 16 rays beyond it.
        assert_eq!((RINGS.rays_beyond(0), RINGS.rays_beyond(1), RINGS.rays_beyond(2)), (8.0, 8.0, 16.0));
        assert!(!leads(160.0, 22.5, 0.0) && leads(160.0, 22.5, 90.0));
        assert!(leads(260.0, 22.5, 0.0) && !leads(260.0, 22.5, 180.0));
        // Between rings a street goes on, and is left by rays alone, where these belong.
        let side = |degrees: f64, heading: f64| {
            RINGS.leads(on(210.0, degrees), Angle::degrees(degrees + heading).unit(), true)
        };
        assert!(leads(210.0, 40.0, 0.0) && leads(210.0, 40.0, 90.0));
        assert!(side(45.0, 0.0) && side(45.0, 180.0) && !side(45.0, 90.0) && !side(22.5, 0.0));
    }
}
