//! Bridges and tunnels: straight from the ground at one end to the ground at the other, lifted to their level between.
//! Where the ground rises above a bridge, the bridge rises with it.

use super::super::terrain::Terrain;
use super::super::tiles::Meshes;
use super::super::{Corner, Group, STREET_LIFT_M, Surface};
use super::Ribbon;
use crate::City;
use geom::{Mesh, Vec2, Vec3};
use serde::Serialize;
use streets::runs::Run;

/// Height of a level above the straight line between the ends, in metres.
pub const CLEARANCE_M: f64 = 6.0;

/// Steepest rise from an end that stands on the ground.
const RAMP: f64 = 0.08;

/// Longest straight piece of a deck in metres, so that ramps are round.
const STEP_M: f64 = 8.0;

/// Thickness of a deck in metres.
const DECK_M: f64 = 0.9;

/// A run that is not on the ground.
#[derive(Serialize)]
pub struct Deck {
    ribbon: Ribbon,
    /// Where it ends, in metres, before it was trimmed.
    ends: [Vec2; 2],
    /// Whether each end stands on the ground.
    stands: [bool; 2],
    /// What its level adds, in metres.
    lift: f64,
}

impl Deck {
    /// The deck of a run of at least two nodes.
    pub fn of(city: &City, run: &Run, ribbon: Ribbon) -> Self {
        let ends = [run.nodes[0], run.nodes[run.nodes.len() - 1]];
        let on_ground = |key| {
            let halves = city.graph.halves_ccw(key);
            halves.len() < 2 || halves.iter().any(|&half| city.graph.level(half) == 0)
        };
        Self {
            ribbon,
            ends: ends.map(|key| city.graph.at(key).metres()),
            stands: ends.map(on_ground),
            lift: f64::from(run.level) * CLEARANCE_M,
        }
    }

    /// Adds it to the meshes of its tile.
    pub fn add_to(&self, meshes: &mut Meshes, terrain: &Terrain) {
        let fine = Profile::of(self, terrain).stepped();
        let origin = meshes.origin;
        for (from, to, surface) in self.ribbon.strips() {
            let mesh = meshes.mesh(Group::Streets, surface);
            for piece in fine.windows(2) {
                let corners =
                    [corner(&piece[0], from), corner(&piece[1], from), corner(&piece[1], to), corner(&piece[0], to)];
                push_quad(mesh, corners, origin);
            }
        }
        let body = meshes.mesh(Group::Streets, Surface::Deck);
        for piece in fine.windows(2) {
            let [a, b] = [&piece[0], &piece[1]];
            let low = |station: &Station, share: f64| {
                let (at, height) = corner(station, share);
                (at, height - DECK_M)
            };
            push_quad(body, [low(a, -1.0), low(b, -1.0), corner(b, -1.0), corner(a, -1.0)], origin);
            push_quad(body, [low(b, 1.0), low(a, 1.0), corner(a, 1.0), corner(b, 1.0)], origin);
            push_quad(body, [low(b, -1.0), low(a, -1.0), low(a, 1.0), low(b, 1.0)], origin);
        }
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

fn push_quad(mesh: &mut Mesh, corners: [(Vec2, f64); 4], origin: Vec2) {
    let places = corners.map(|(at, height)| at.extend(height));
    let normal = (places[2] - places[0]).cross(places[3] - places[1]);
    let Some(normal) = normal.try_normalize() else { return };
    let flat = |(at, height): (Vec2, f64)| Corner { at, height, normal: Vec3::new(normal.x, normal.y, normal.z) };
    super::push_corners(mesh, &corners.map(flat), origin);
}

/// Height along a deck.
struct Profile<'a> {
    deck: &'a Deck,
    terrain: &'a Terrain,
    length: f64,
    /// Ground at both ends.
    ground: [f64; 2],
}

impl<'a> Profile<'a> {
    fn of(deck: &'a Deck, terrain: &'a Terrain) -> Self {
        let length = deck.ribbon.line.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        Self { deck, terrain, length, ground: deck.ends.map(|end| terrain.height(end)) }
    }

    fn height(&self, along: f64) -> f64 {
        let share = if self.length > 0.0 { (along / self.length).clamp(0.0, 1.0) } else { 0.0 };
        let rise = |stands: bool, distance: f64| {
            let most = self.deck.lift.abs().max(f64::MIN_POSITIVE);
            if stands { smooth((distance * RAMP / most).min(1.0)) } else { 1.0 }
        };
        let lifted = rise(self.deck.stands[0], along).min(rise(self.deck.stands[1], self.length - along));
        self.ground[0] + (self.ground[1] - self.ground[0]) * share + self.deck.lift * lifted + STREET_LIFT_M
    }

    fn station(&self, at: Vec2, left: Vec2, along: f64) -> Station {
        let planned = self.height(along);
        let grounds = [-1.0, 0.0, 1.0].map(|share| self.terrain.height(at + left * share) + STREET_LIFT_M);
        let height = if self.deck.lift > 0.0 { grounds.into_iter().fold(planned, f64::max) } else { planned };
        Station { at, left, height }
    }

    /// The ribbon in short steps with heights.
    fn stepped(&self) -> Vec<Station> {
        let ribbon = &self.deck.ribbon;
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
