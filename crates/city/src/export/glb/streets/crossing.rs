//! Where ribbons end, and what lies between their ends.

use super::super::terrain::Terrain;
use super::super::tiles::Meshes;
use super::super::{CROSSING_LIFT_M, STREET_LIFT_M, Surface};
use super::{CARRIAGEWAY, lay, surface_of};
use crate::City;
use geom::predicates::by_angle;
use geom::{Point, Vec2};
use serde::Serialize;
use std::collections::BTreeMap;
use streets::{Class, NodeKey};

/// Trims take no more than this share of the first straight piece, so that something is left between two crossings.
const MOST_OF_PIECE: f64 = 0.45;

/// Trims are no longer than this many of the widest half widths: arms at acute angles overlap beyond.
const MOST_HALF_WIDTHS: f64 = 4.0;

/// An end of a run at a crossing.
struct Arm {
    run: usize,
    /// Whether the run starts here.
    starts: bool,
    /// Exact direction away from the crossing.
    way: (i64, i64),
    direction: Vec2,
    half_width: f64,
    /// Length of the first straight piece in metres.
    piece: f64,
    class: Class,
    level: i8,
    trim: f64,
}

/// A crossing with its arms, counter-clockwise.
struct Crossing {
    at: Vec2,
    arms: Vec<Arm>,
}

/// The crossings of a city and how far each run is trimmed.
pub struct Trims {
    crossings: Vec<Crossing>,
    /// By run: metres at its start and end.
    trims: Vec<[f64; 2]>,
}

impl Trims {
    /// Trims every end of every run.
    pub fn of(city: &City) -> Self {
        let mut by_node: BTreeMap<NodeKey, Vec<Arm>> = BTreeMap::new();
        for run in 0..city.runs.len() {
            for starts in [true, false] {
                if let Some((node, arm)) = arm(city, run, starts) {
                    by_node.entry(node).or_default().push(arm);
                }
            }
        }
        let mut trims = vec![[0.0; 2]; city.runs.len()];
        let mut crossings = Vec::with_capacity(by_node.len());
        for (node, mut arms) in by_node {
            arms.sort_by(|a, b| by_angle(a.way, b.way).then(a.level.cmp(&b.level)).then(a.run.cmp(&b.run)));
            trim(&mut arms);
            for arm in &arms {
                trims[arm.run][usize::from(!arm.starts)] = arm.trim;
            }
            crossings.push(Crossing { at: city.graph.at(node).metres(), arms });
        }
        Self { crossings, trims }
    }

    /// The metres that a run, by its place in the city's list, is trimmed at start and end.
    pub fn of_run(&self, run: usize) -> [f64; 2] {
        self.trims[run]
    }

    /// What covers the crossings.
    pub fn covers(&self, city: &City) -> impl Iterator<Item = Cover> {
        self.crossings.iter().filter_map(|crossing| Cover::of(city, crossing))
    }
}

fn arm(city: &City, index: usize, starts: bool) -> Option<(NodeKey, Arm)> {
    let run = &city.runs[index];
    let (&node, &next) = match run.nodes.as_slice() {
        [a, b, ..] if starts => (a, b),
        [.., b, a] if !starts => (a, b),
        _ => return None,
    };
    let (from, to) = (city.graph.at(node), city.graph.at(next));
    let along = to.metres() - from.metres();
    let arm = Arm {
        run: index,
        starts,
        way: from.to(to),
        direction: along.try_normalize()?,
        half_width: f64::from(run.half_width) / Point::UNITS_PER_METRE,
        piece: along.length(),
        class: run.class,
        level: run.level,
        trim: 0.0,
    };
    Some((node, arm))
}

/// Trims arms behind their farthest corner; a dead end is drawn out by half its width instead.
fn trim(arms: &mut [Arm]) {
    let n = arms.len();
    if let [only] = arms {
        only.trim = -only.half_width;
        return;
    }
    let most = MOST_HALF_WIDTHS * arms.iter().map(|arm| arm.half_width).fold(0.0, f64::max);
    for i in 0..n {
        let j = (i + 1) % n;
        if let Some([along, across]) = corner(&arms[i], &arms[j]) {
            for (k, distance) in [(i, along), (j, across)] {
                let limit = most.min(MOST_OF_PIECE * arms[k].piece);
                arms[k].trim = arms[k].trim.max(distance.min(limit));
            }
        }
    }
}

/// Where the left border of an arm meets the right border of the next: metres along each. `None` where they are
/// parallel. Negative behind the crossing, where the gap is wider than a straight angle.
fn corner(arm: &Arm, next: &Arm) -> Option<[f64; 2]> {
    let (sin, cos) = (arm.direction.perp_dot(next.direction), arm.direction.dot(next.direction));
    if sin.abs() < 1e-3 {
        return None;
    }
    let along = (next.half_width + arm.half_width * cos) / sin;
    let across = (arm.half_width + next.half_width * cos) / sin;
    // Of unequal widths one distance can come out positive across a wide gap, where there is no corner.
    let opens = sin > 0.0;
    (opens || (along < 0.0 && across < 0.0)).then_some([along, across])
}

/// What covers a crossing.
#[derive(Serialize)]
pub struct Cover {
    /// Where the crossing is, in metres.
    pub at: Vec2,
    /// From below: what each part is made of, how far it lies above the streets, and its rim, seen from `at`.
    parts: [(Surface, f64, Vec<Vec2>); 2],
}

impl Cover {
    /// `None` where nothing is to be covered.
    fn of(city: &City, crossing: &Crossing) -> Option<Self> {
        let leading = crossing.arms.iter().map(|arm| arm.class).min()?;
        // Above or below the ground decks simply meet.
        if crossing.arms.len() < 2 || crossing.arms.iter().all(|arm| arm.level != 0) {
            return None;
        }
        // Sidewalks turn the corners; the carriageways meet on top of them.
        let covers = [(1.0, Surface::Sidewalk, 0.5), (CARRIAGEWAY, surface_of(city, leading), 1.0)];
        let part = |(share, surface, lift)| (surface, CROSSING_LIFT_M * lift, rim(crossing, share));
        Some(Self { at: crossing.at, parts: covers.map(part) })
    }

    /// Adds it to the meshes of its tile.
    pub fn add_to(&self, meshes: &mut Meshes, terrain: &Terrain) {
        for (surface, lift, rim) in &self.parts {
            for (i, &p) in rim.iter().enumerate() {
                let q = rim[(i + 1) % rim.len()];
                if (p - self.at).perp_dot(q - self.at) > 0.0 {
                    lay(meshes, terrain, *surface, &[self.at, p, q], STREET_LIFT_M + lift);
                }
            }
        }
    }
}

/// Arm ends and the corners between them, counter-clockwise around the crossing, for a share of the arms' width.
fn rim(crossing: &Crossing, share: f64) -> Vec<Vec2> {
    let arms = &crossing.arms;
    let mut rim = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let end = crossing.at + arm.direction * arm.trim;
        let left = arm.direction.perp() * (arm.half_width * share);
        rim.extend([end - left, end + left]);
        let next = &arms[(i + 1) % arms.len()];
        if let Some([along, across]) = corner(arm, next).map(|distances| distances.map(|distance| distance * share)) {
            let reach = MOST_HALF_WIDTHS / 2.0 * arm.half_width.max(next.half_width);
            let in_front = along >= 0.0 && along <= arm.trim + 1e-6 && across <= next.trim + 1e-6;
            let behind = along < 0.0 && along >= -reach && across >= -reach;
            if in_front || behind {
                rim.push(crossing.at + arm.direction * along + left);
            }
        }
    }
    rim
}
