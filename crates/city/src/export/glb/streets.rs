//! Streets as ribbons between crossings, crossings as covers of what lies between the ribbons, bridges as decks.
//!
//! At a crossing the borders of neighbouring arms meet in a corner; each arm is trimmed square behind its farthest
//! corner, and the cover joins arm ends and corners (Scharl 2010 §5; algorithms: junction tessellation).

mod bridge;
mod crossing;

use super::terrain::Terrain;
use super::tiles::{ByTile, Meshes};
use super::{Corner, Group, STREET_LIFT_M, Surface, TileKey, push_corners};
use crate::City;
use bridge::Deck;
use crossing::{Cover, Trims};
use geom::{Point, Vec2};
use serde::Serialize;
use streets::Class;
use streets::runs::Run;

/// Share of the right-of-way that is carriageway; sidewalks share the rest.
const CARRIAGEWAY: f64 = 0.68;

/// How far a mitre may reach, in half widths; sharper bends are drawn square.
const MITRE: f64 = 2.5;

/// A piece of the streets, drawn from itself and the terrain alone.
#[derive(Serialize)]
pub enum Piece {
    /// A run on the ground.
    Ribbon(Ribbon),
    /// A bridge or tunnel.
    Deck(Deck),
    /// What lies between the ribbons of a crossing.
    Cover(Cover),
}

impl Piece {
    /// Adds it to the meshes of its tile.
    pub fn add_to(&self, meshes: &mut Meshes, terrain: &Terrain) {
        match self {
            Self::Ribbon(ribbon) => ribbon.add_to(meshes, terrain),
            Self::Deck(deck) => deck.add_to(meshes, terrain),
            Self::Cover(cover) => cover.add_to(meshes, terrain),
        }
    }
}

/// All pieces of the streets of a city, by the tile of their first point.
pub fn pieces(city: &City) -> ByTile<Piece> {
    let trims = Trims::of(city);
    let mut tiles = ByTile::<Piece>::new();
    for (index, run) in city.runs.iter().enumerate() {
        let Some(ribbon) = Ribbon::of(city, run, trims.of_run(index)) else { continue };
        let pieces = tiles.entry(TileKey::of(city.graph.at(run.nodes[0]).metres())).or_default();
        pieces.push(if run.level == 0 { Piece::Ribbon(ribbon) } else { Piece::Deck(Deck::of(city, run, ribbon)) });
    }
    for cover in trims.covers(city) {
        tiles.entry(TileKey::of(cover.at)).or_default().push(Piece::Cover(cover));
    }
    tiles
}

/// What a class's carriageway is made of.
fn surface_of(city: &City, class: Class) -> Surface {
    let info = city.graph.classes().info(class);
    match (info.name.as_str(), info.closes_quarters) {
        ("highway", _) => Surface::Highway,
        ("major", _) | (_, true) => Surface::Major,
        _ => Surface::Minor,
    }
}

/// A run as it is drawn.
#[derive(Serialize)]
pub struct Ribbon {
    surface: Surface,
    half_width: f64,
    /// Its centre line in metres, trimmed at both ends.
    line: Vec<Vec2>,
    /// At each point of the line: the way to its left border, of the length that makes the borders parallel.
    left: Vec<Vec2>,
}

impl Ribbon {
    /// `trims` are the metres taken off at start and end; negative ones draw the run out.
    fn of(city: &City, run: &Run, trims: [f64; 2]) -> Option<Self> {
        let mut line: Vec<Vec2> = run.nodes.iter().map(|&key| city.graph.at(key).metres()).collect();
        line.dedup();
        let half_width = f64::from(run.half_width) / Point::UNITS_PER_METRE;
        let n = line.len();
        if n < 2 || half_width <= 0.0 {
            return None;
        }
        let (start, end) = ((line[1] - line[0]).normalize(), (line[n - 2] - line[n - 1]).normalize());
        line[0] += start * trims[0];
        line[n - 1] += end * trims[1];
        let left = lefts(&line, half_width);
        Some(Self { surface: surface_of(city, run.class), half_width, line, left })
    }

    /// The straight pieces between two shares of the way to the left border (-1 is the right border), counter-clockwise
    /// from the right at the start.
    fn quads(&self, from: f64, to: f64) -> impl Iterator<Item = [Vec2; 4]> {
        self.line.windows(2).zip(self.left.windows(2)).map(move |(line, left)| {
            let quad = quad([line[0], line[1]], [left[0], left[1]], from, to);
            if is_convex(&quad) { quad } else { self.square(line[0], line[1], from, to) }
        })
    }

    /// A piece without mitres: for bends so tight that the inner borders would pass each other.
    fn square(&self, a: Vec2, b: Vec2, from: f64, to: f64) -> [Vec2; 4] {
        let left = (b - a).normalize_or_zero().perp() * self.half_width;
        quad([a, b], [left, left], from, to)
    }

    /// The strips across: where each starts and ends, and what it is made of.
    fn strips(&self) -> [(f64, f64, Surface); 3] {
        let kerb = CARRIAGEWAY;
        [(-1.0, -kerb, Surface::Sidewalk), (-kerb, kerb, self.surface), (kerb, 1.0, Surface::Sidewalk)]
    }

    fn add_to(&self, meshes: &mut Meshes, terrain: &Terrain) {
        for (from, to, surface) in self.strips() {
            self.quads(from, to).for_each(|quad| lay(meshes, terrain, surface, &quad, STREET_LIFT_M));
        }
    }
}

fn quad(line: [Vec2; 2], left: [Vec2; 2], from: f64, to: f64) -> [Vec2; 4] {
    [line[0] + left[0] * from, line[1] + left[1] * from, line[1] + left[1] * to, line[0] + left[0] * to]
}

fn is_convex(quad: &[Vec2; 4]) -> bool {
    (0..4).all(|i| (quad[(i + 1) % 4] - quad[i]).perp_dot(quad[(i + 2) % 4] - quad[(i + 1) % 4]) > 0.0)
}

/// The ways to the left border at each point of a line.
fn lefts(line: &[Vec2], half_width: f64) -> Vec<Vec2> {
    let normals: Vec<Vec2> = line.windows(2).map(|pair| (pair[1] - pair[0]).normalize_or_zero().perp()).collect();
    let at = |i: usize| {
        let before = normals[i.saturating_sub(1)];
        let after = normals[i.min(normals.len() - 1)];
        let middle = (before + after).normalize_or(after);
        // 1 / cos of half the turn makes the borders parallel to the line.
        let reach = (1.0 / middle.dot(after).max(1e-6)).min(MITRE);
        middle * (half_width * reach)
    };
    (0..line.len()).map(at).collect()
}

/// Lays a convex polygon onto the terrain.
fn lay(meshes: &mut Meshes, terrain: &Terrain, surface: Surface, polygon: &[Vec2], lift: f64) {
    let origin = meshes.origin;
    let mesh = meshes.mesh(Group::Streets, surface);
    terrain.drape(polygon, lift, &mut |piece: &[Corner]| push_corners(mesh, piece, origin));
}
