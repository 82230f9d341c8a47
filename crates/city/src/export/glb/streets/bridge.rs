//! Bridges and tunnels: straight from the ground at one end to the ground at the other, lifted to their level between.
//! Where the ground rises above a bridge, the bridge rises with it.

use super::super::terrain::Terrain;
use super::super::{Corner, Group, Meshes, STREET_LIFT_M, Surface};
use super::Ribbon;
use crate::City;
use geom::{Mesh, Vec2, Vec3};
use streets::runs::Run;

/// Height of a level above the straight line between the ends, in metres.
pub const CLEARANCE_M: f64 = 6.0;

/// Steepest rise from an end that stands on the ground.
const RAMP: f64 = 0.08;

/// Longest straight piece of a deck in metres, so that ramps are round.
const STEP_M: f64 = 8.0;

/// Thickness of a deck in metres.
const DECK_M: f64 = 0.9;

/// Adds a run that is not on the ground.
pub fn add(model: &mut Meshes, city: &City, terrain: &Terrain, run: &Run, ribbon: &Ribbon) {
    let profile = Profile::of(city, terrain, run, ribbon);
    let fine = profile.stepped(ribbon);
    for (from, to, surface) in ribbon.strips() {
        let mesh = model.mesh(ribbon.tile, Group::Streets, surface);
        for piece in fine.windows(2) {
            push_quad(
                mesh,
                ribbon,
                [corner(&piece[0], from), corner(&piece[1], from), corner(&piece[1], to), corner(&piece[0], to)],
            );
        }
    }
    let body = model.mesh(ribbon.tile, Group::Streets, Surface::Deck);
    for piece in fine.windows(2) {
        let [a, b] = [&piece[0], &piece[1]];
        let low = |station: &Station, share: f64| {
            let (at, height) = corner(station, share);
            (at, height - DECK_M)
        };
        push_quad(body, ribbon, [low(a, -1.0), low(b, -1.0), corner(b, -1.0), corner(a, -1.0)]);
        push_quad(body, ribbon, [low(b, 1.0), low(a, 1.0), corner(a, 1.0), corner(b, 1.0)]);
        push_quad(body, ribbon, [low(b, -1.0), low(a, -1.0), low(a, 1.0), low(b, 1.0)]);
    }
}

/// A place along a deck.
struct Station {
    at: Vec2,
    left: Vec2,
    height: f64,
}

fn corner(station: &Station, share: f64) -> (Vec2, f64) {
    (station.at + station.left * share, station.height)
}

fn push_quad(mesh: &mut Mesh, ribbon: &Ribbon, corners: [(Vec2, f64); 4]) {
    let places = corners.map(|(at, height)| at.extend(height));
    let normal = (places[2] - places[0]).cross(places[3] - places[1]);
    let Some(normal) = normal.try_normalize() else { return };
    let flat = |(at, height): (Vec2, f64)| Corner { at, height, normal: Vec3::new(normal.x, normal.y, normal.z) };
    super::push_corners(mesh, &corners.map(flat), ribbon.tile.origin());
}

/// Height along a deck.
struct Profile<'a> {
    terrain: &'a Terrain,
    length: f64,
    /// Ground at both ends.
    ground: [f64; 2],
    /// Whether each end stands on the ground.
    stands: [bool; 2],
    /// What its level adds.
    lift: f64,
}

impl<'a> Profile<'a> {
    fn of(city: &City, terrain: &'a Terrain, run: &Run, ribbon: &Ribbon) -> Self {
        let ends = [run.nodes[0], run.nodes[run.nodes.len() - 1]];
        let ground = ends.map(|key| terrain.height(city.graph.at(key).metres()));
        let on_ground = |key| {
            let halves = city.graph.halves_ccw(key);
            halves.len() < 2 || halves.iter().any(|&half| city.graph.level(half) == 0)
        };
        let length = ribbon.line.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        Self { terrain, length, ground, stands: ends.map(on_ground), lift: f64::from(run.level) * CLEARANCE_M }
    }

    fn height(&self, along: f64) -> f64 {
        let share = if self.length > 0.0 { (along / self.length).clamp(0.0, 1.0) } else { 0.0 };
        let rise = |stands: bool, distance: f64| {
            let most = self.lift.abs().max(f64::MIN_POSITIVE);
            if stands { smooth((distance * RAMP / most).min(1.0)) } else { 1.0 }
        };
        let lifted = rise(self.stands[0], along).min(rise(self.stands[1], self.length - along));
        self.ground[0] + (self.ground[1] - self.ground[0]) * share + self.lift * lifted + STREET_LIFT_M
    }

    fn station(&self, at: Vec2, left: Vec2, along: f64) -> Station {
        let planned = self.height(along);
        let grounds = [-1.0, 0.0, 1.0].map(|share| self.terrain.height(at + left * share) + STREET_LIFT_M);
        let height = if self.lift > 0.0 { grounds.into_iter().fold(planned, f64::max) } else { planned };
        Station { at, left, height }
    }

    /// The ribbon in short steps with heights.
    fn stepped(&self, ribbon: &Ribbon) -> Vec<Station> {
        let mut stations = Vec::new();
        let mut along = 0.0;
        for (line, left) in ribbon.line.windows(2).zip(ribbon.left.windows(2)) {
            let length = line[0].distance(line[1]);
            let steps = (length / STEP_M).ceil().max(1.0);
            for i in 0..steps as usize {
                let share = i as f64 / steps;
                let (at, left) = (line[0].lerp(line[1], share), left[0].lerp(left[1], share));
                stations.push(self.station(at, left, along + share * length));
            }
            along += length;
        }
        if let (Some(&at), Some(&left)) = (ribbon.line.last(), ribbon.left.last()) {
            stations.push(self.station(at, left, along));
        }
        stations
    }
}

/// From 0 to 1 without a kink at either end.
fn smooth(share: f64) -> f64 {
    share * share * (3.0 - 2.0 * share)
}
