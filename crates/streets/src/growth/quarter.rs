//! Growth inside one quarter: a function of the quarter alone, so that many can run at once.
//!
//! A quarter grows in a private graph that holds a copy of its rim: straight sides between corners, without the
//! crossings that streets of other quarters make with it. What happens on the other side of a rim, or in what order
//! quarters are grown, therefore changes nothing. Where its streets meet the rim, [`Attachment`]s say so.

use super::kernel::Grower;
use super::{Fields, Growth, GrowthLog, GrowthRules, Home, Keeps, SeedPoint, Stopped};
use crate::faces::{Face, Side};
use crate::graph::{Claim, Crowding, NewSegment, Refusal};
use crate::{Class, NodeId, SegmentKey, StreetGraph, StreetId};
use geom::point::units;
use geom::polygon::Location;
use geom::{Angle, Bounds, Id, Point, Polygon, predicates, tolerance};
use rustc_hash::FxHashSet;
use std::sync::Arc;

/// Precision of the first seed's place, in metres.
const POLE_PRECISION: f64 = 1.0;
/// Candidates for further seeds: this many for each square of the reseeding distance in the quarter's box, within
/// [`CANDIDATES`].
const CANDIDATES_PER_SQUARE: f64 = 8.0;
const CANDIDATES: (f64, f64) = (32.0, 16_384.0);
/// The two-dimensional golden ratio sequence: fractions of 2⁶⁴ by which consecutive candidates differ (1/p and 1/p² for
/// the real root p of p³ = p + 1).
const LOW_DISCREPANCY: (u64, u64) = (0xc13f_a9a9_02a6_328f, 0x91e1_0da5_c79e_7b1c);

/// How a quarter is filled.
#[derive(Clone, Debug)]
pub struct QuarterSettings {
    /// How its streets grow. What grows hangs on this root and on the quarter's rim.
    pub growth: Growth,
    /// Further seeds are planted farther than this from every street, in metres, until there is no such place: so
    /// parts that a park or water cuts off are filled too.
    pub reseed: f64,
    /// Least distance of any seed from every street, in metres: a narrower quarter stays whole.
    pub clearance: f64,
}

impl QuarterSettings {
    /// Default distances: seeds 20 m from every street, further ones 120 m.
    pub fn new(growth: Growth) -> Self {
        Self { growth, reseed: 120.0, clearance: 20.0 }
    }
}

/// Where a grown street meets the rim of its quarter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Position in the log's `accepted` of what ends here.
    pub line: usize,
    /// The street of the rim.
    pub street: StreetId,
    /// Which side of the rim, counted over [`Face::sides`] and then [`Face::hole_sides`].
    pub side: usize,
    /// Where it meets the side (rounded).
    pub at: Point,
    /// The crossing there in the quarter's own graph.
    pub node: NodeId,
    /// The last crossing before the rim: from here on, the street may be bent to meet another quarter's.
    pub hinge: Point,
    /// Its identity in the quarter's own graph.
    pub hinge_node: NodeId,
}

/// What grew in a quarter.
#[derive(Clone, Debug, PartialEq)]
pub struct QuarterGrowth {
    /// [`Face::id`] of the quarter.
    pub quarter: Id,
    /// What was laid and refused. The lines in `accepted`, inserted in their order, are the streets of the quarter.
    pub log: GrowthLog,
    /// Where they meet the rim, in the order of `accepted`.
    pub attachments: Vec<Attachment>,
    /// What they keep to.
    pub keeps: Keeps,
    /// Why nothing grew: the rim could not be copied.
    pub fault: Option<Refusal>,
}

/// Grows streets inside a quarter of a graph; a pure function of the quarter.
///
/// `face` must be a face of `graph`. Streets given inside the quarter (dead ends of majors, minors drawn by hand) are
/// met like any other. When `cancel` answers true, the log says [`Stopped::Cancelled`].
pub fn grow_quarter(
    graph: &StreetGraph,
    face: &Face,
    settings: &QuarterSettings,
    rules: &dyn GrowthRules,
    fields: &Arc<Fields>,
    cancel: &dyn Fn() -> bool,
) -> QuarterGrowth {
    let mut result = QuarterGrowth {
        quarter: face.id,
        log: GrowthLog::default(),
        attachments: Vec::new(),
        keeps: Keeps::of(&settings.growth, fields),
        fault: None,
    };
    let rim = QuarterRim::of(graph, face);
    let mut private = match rim.enclosure(graph, face) {
        Ok(private) => private,
        Err(refusal) => {
            result.fault = Some(refusal);
            return result;
        }
    };
    let home = Home { at: rim.polygon.pole(POLE_PRECISION).metres(), heading: rim.main_heading() };
    let mut grower = Grower::new(&mut private, &settings.growth, rules, fields, cancel).at_home(home);
    // Lineage hangs on a side of the rim, not on the outline.
    rim.fill(&mut grower, settings, settings.growth.root.with(&[face.root(graph).0]), &home);
    result.log = grower.log;
    result.attachments = rim.attachments(&private, &result.log);
    result
}

/// One straight side of the rim, with what its copy needs.
#[derive(Clone, Copy, Debug)]
struct RimSide {
    from: Point,
    to: Point,
    from_id: NodeId,
    to_id: NodeId,
    claim: Claim,
}

/// The rim of a quarter: the outer sides, then those of the holes.
#[derive(Debug)]
struct QuarterRim {
    sides: Vec<RimSide>,
    polygon: Polygon,
}

impl QuarterRim {
    fn of(graph: &StreetGraph, face: &Face) -> Self {
        let loops = std::iter::once(&face.sides).chain(&face.hole_sides);
        Self { sides: loops.flat_map(|sides| rim_sides(graph, sides)).collect(), polygon: face.polygon() }
    }

    /// A graph of the rim and of the streets given inside it.
    fn enclosure(&self, graph: &StreetGraph, face: &Face) -> Result<StreetGraph, Refusal> {
        let mut private = StreetGraph::new(graph.classes().clone());
        for side in &self.sides {
            let RimSide { from, to, from_id, to_id, claim } = *side;
            match private.insert(&NewSegment { from, to, from_id, to_id, claim, level: 0 }, Crowding::Refuse) {
                // The ends of a side shorter than the laying distance fall together: the rim stays closed.
                Ok(_) | Err(Refusal::TooShort) => {}
                Err(refusal) => return Err(refusal),
            }
        }
        for key in self.given_inside(graph, face) {
            // One that finds no room is only not seen by what grows; the merge meets it.
            let _ = private.insert(&copy_of(graph, key), Crowding::Refuse);
        }
        Ok(private)
    }

    /// Segments on the ground inside the quarter, by id.
    fn given_inside(&self, graph: &StreetGraph, face: &Face) -> Vec<SegmentKey> {
        let mut keys: Vec<_> = face.antennas.iter().copied().filter(|&key| graph.segment(key).level == 0).collect();
        if let Some(bounds) = self.polygon.bounds() {
            graph.for_segments_near(bounds, |key| {
                let closes = |claim: &Claim| graph.classes().info(claim.class).closes_quarters;
                if !graph.segment(key).claims().iter().any(closes)
                    && graph.segment(key).level == 0
                    && self.is_inside(graph.line(key.forward()))
                {
                    keys.push(key);
                }
            });
        }
        keys.sort_by_key(|&key| graph.segment(key).id);
        keys
    }

    /// Whether a segment that does not cross the rim lies inside it.
    fn is_inside(&self, (a, b): (Point, Point)) -> bool {
        let middle =
            Point::new(((i64::from(a.x) + i64::from(b.x)) / 2) as i32, ((i64::from(a.y) + i64::from(b.y)) / 2) as i32);
        self.polygon.locate(middle) == Location::Inside
    }

    /// Plants seeds and lets them grow, until no place far from all streets is left.
    fn fill(&self, grower: &mut Grower, settings: &QuarterSettings, root: Id, home: &Home) {
        let Some(bounds) = self.polygon.bounds() else { return };
        let (reseed, clearance) = (units(settings.reseed), units(settings.clearance));
        let heading = home.heading;
        let mut ordinal = 0;
        let mut plant = |grower: &mut Grower, at: Point, distance: i32| {
            let is_free = |graph: &StreetGraph, p: Point, distance: i32| {
                self.polygon.locate(p) == Location::Inside && graph.nearest_segment(p, distance, 0).is_none()
            };
            if !is_free(grower.graph, at, distance) {
                return;
            }
            let seed = SeedPoint { at, heading, root: root.child(ordinal) };
            if grower.plant(&seed, &|graph, p| is_free(graph, p, clearance)) {
                ordinal += 1;
                grower.run();
            }
        };
        grower.take_up_all(root, &|p| self.polygon.locate(p) == Location::Inside);
        plant(grower, Point::from_metres(home.at), clearance);
        for candidate in candidates(bounds, settings.reseed) {
            if grower.log.stopped.is_some() {
                break;
            }
            plant(grower, candidate, reseed.max(clearance));
        }
        // A street given inside may lie on the pole, and near to every other place: then any place will do.
        for candidate in candidates(bounds, settings.reseed) {
            if grower.log.stopped.is_some() || !grower.log.accepted.is_empty() {
                break;
            }
            plant(grower, candidate, clearance);
        }
    }

    /// Direction of the longest side: what rules that follow no pattern start from.
    fn main_heading(&self) -> Angle {
        let length = |side: &RimSide| (side.from.distance_squared(side.to), std::cmp::Reverse(side.from));
        let longest = self.sides.iter().max_by_key(|side| length(side));
        longest.map_or(Angle::ZERO, |side| Angle::of(side.to.metres() - side.from.metres()))
    }

    fn attachments(&self, private: &StreetGraph, log: &GrowthLog) -> Vec<Attachment> {
        let streets: FxHashSet<_> = self.sides.iter().map(|side| side.claim.street).collect();
        let ends = log.accepted.iter().enumerate().filter(|(_, accepted)| accepted.outcome.ends_street());
        ends.filter_map(|(line, accepted)| {
            let key = private.find_node(accepted.end_id())?;
            let arms = private.halves_ccw(key);
            let claims = |arm| private.segment(crate::HalfKey::segment(arm)).claims();
            let on_rim = arms.iter().any(|&arm| claims(arm).iter().any(|claim| streets.contains(&claim.street)));
            let at = private.at(key);
            let side = if on_rim { self.side_at(at)? } else { return None };
            let own = |claim: &Claim| claim.street == accepted.lineage.street;
            let arm = arms.iter().copied().find(|&arm| claims(arm).iter().any(own))?;
            let hinge = private.target(arm);
            Some(Attachment {
                line,
                street: self.sides[side].claim.street,
                side,
                at,
                node: private.node(key).id,
                hinge: private.at(hinge),
                hinge_node: private.node(hinge).id,
            })
        })
        .collect()
    }

    /// The side that a node of the private graph lies on, corners left out: these are crossings of the rim itself.
    fn side_at(&self, at: Point) -> Option<usize> {
        let lies_on = |side: &RimSide| predicates::within(side.from, side.to, at, tolerance::SEPARATION);
        let position = self.sides.iter().position(lies_on)?;
        let is_corner = self.sides.iter().any(|side| side.from == at);
        (!is_corner).then_some(position)
    }
}

/// The sides of a loop with what their copies need.
fn rim_sides(graph: &StreetGraph, sides: &[Side]) -> impl Iterator<Item = RimSide> {
    let id = |side: &Side| graph.node(side.from_node).id;
    let next = sides.iter().cycle().skip(1);
    sides.iter().zip(next).map(move |(side, next)| RimSide {
        from: side.from,
        to: side.to,
        from_id: id(side),
        to_id: id(next),
        claim: claim_of(graph, side),
    })
}

/// The claim of a side's street where the side starts, running along the side.
fn claim_of(graph: &StreetGraph, side: &Side) -> Claim {
    let wanted = side.from.to(side.to);
    let arms = graph.halves_ccw(side.from_node).iter();
    let found = arms
        .flat_map(|&arm| graph.segment(arm.segment()).claims().iter().map(move |claim| (arm, claim)))
        .filter(|(_, claim)| claim.street == side.street)
        .max_by_key(|(arm, _)| {
            let direction = graph.direction(*arm);
            direction.0 * wanted.0 + direction.1 * wanted.1
        });
    match found {
        Some((arm, claim)) => Claim { forward: claim.forward == arm.is_forward(), ..*claim },
        None => Claim { street: side.street, class: Class(0), half_width: side.half_width, origin: 0, forward: true },
    }
}

/// A segment of the graph as it would be inserted.
fn copy_of(graph: &StreetGraph, key: SegmentKey) -> NewSegment {
    let segment = graph.segment(key);
    let claim = *segment.leading();
    let half = if claim.forward { key.forward() } else { key.backward() };
    let (from, to) = (graph.node(graph.origin(half)), graph.node(graph.target(half)));
    NewSegment { from: from.at, to: to.at, from_id: from.id, to_id: to.id, claim, level: segment.level }
}

/// Places spread evenly over a box, the same for the same box: integer arithmetic only.
pub(super) fn candidates(bounds: Bounds, spacing: f64) -> impl Iterator<Item = Point> {
    let size = bounds.size();
    let squares = size.x * size.y / (spacing * spacing).max(1.0);
    let count = (squares * CANDIDATES_PER_SQUARE).clamp(CANDIDATES.0, CANDIDATES.1) as u64;
    let place = |low: i32, high: i32, share: u64| {
        let span = (i64::from(high) - i64::from(low)) as u128;
        (i64::from(low) + ((span * u128::from(share)) >> 64) as i64) as i32
    };
    (1..=count).map(move |i| {
        let (x, y) = (i.wrapping_mul(LOW_DISCREPANCY.0), i.wrapping_mul(LOW_DISCREPANCY.1));
        Point::new(place(bounds.min.x, bounds.max.x, x), place(bounds.min.y, bounds.max.y, y))
    })
}

impl QuarterGrowth {
    /// Whether it was cancelled: then it is not to be used.
    pub fn is_cancelled(&self) -> bool {
        self.log.stopped == Some(Stopped::Cancelled)
    }
}
