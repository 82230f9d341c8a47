//! Rules, graphs and checks for the tests of growth.

use crate::faces::{Face, FaceKind, Faces};
use crate::graph::{Claim, Crowding, NewSegment, Refusal};
use crate::growth::{Fields, Growth, GrowthRules, Slot, Steer, Tip};
use crate::{Class, Classes, NodeId, StreetGraph, StreetId};
use geom::polygon::Location;
use geom::{Angle, Bounds, Id, Point, Seed, Vec2, predicates, tolerance};
use std::sync::Arc;

/// A rule as a closure.
pub struct Rule<F>(pub F);

impl<F: Fn(&mut Tip) + Sync> GrowthRules for Rule<F> {
    fn propose(&self, tip: &mut Tip) {
        (self.0)(tip);
    }

    fn origin(&self) -> u16 {
        7
    }
}

pub fn at(x: f64, y: f64) -> Point {
    Point::from_metres(Vec2::new(x, y))
}

pub fn site(side: f64) -> Fields {
    Fields::plain(Bounds::between(at(-side, -side), at(side, side)))
}

pub fn slot(length: f64) -> Option<Slot> {
    Some(Slot { length, turn: Angle::ZERO, delay: 0, width: None })
}

/// PM01's New York rule: `along` and `across` as pitches of a raster through the origin.
pub fn grid(heading: Angle, along: f64, across: f64) -> Rule<impl Fn(&mut Tip) + Send + Sync + 'static> {
    Rule(move |tip: &mut Tip| {
        tip.steer(Steer::Raster { heading, along, across, origin: Vec2::ZERO });
        let (ahead, branch) = if tip.runs_along(heading) { (along, across) } else { (across, along) };
        (tip.slots.ahead, tip.slots.left, tip.slots.right) = (slot(ahead), slot(branch), slot(branch));
    })
}

/// Winding streets whose turns and lengths are drawn by lineage.
pub fn winding() -> Rule<impl Fn(&mut Tip) + Send + Sync + 'static> {
    Rule(|tip: &mut Tip| {
        let draw = |ordinal, low, high| tip.seed.range(ordinal, low, high);
        let slots = [0, 10, 20].map(|base| Slot {
            length: draw(base, 40.0, 110.0),
            turn: Angle::degrees(draw(base + 1, -22.0, 22.0)),
            delay: draw(base + 2, 0.0, 6.0) as i32,
            width: None,
        });
        (tip.slots.ahead, tip.slots.left, tip.slots.right) = (Some(slots[0]), Some(slots[1]), Some(slots[2]));
    })
}

pub fn minors() -> Growth {
    Growth::new(Classes::MINOR, 2 * 1024, Seed(11), Id::root("test", &[]))
}

pub fn never() -> bool {
    false
}

/// Inserts a street of one straight line.
pub fn street(graph: &mut StreetGraph, class: Class, name: u128, from: Point, to: Point) -> StreetId {
    try_street(graph, class, name, from, to).expect("room")
}

/// The same, where there is room.
pub fn try_street(
    graph: &mut StreetGraph,
    class: Class,
    name: u128,
    from: Point,
    to: Point,
) -> Result<StreetId, Refusal> {
    let street = StreetId(Id(name));
    let claim = Claim { street, class, half_width: 2 * 1024, origin: 0, forward: true };
    let id = |p: Point| NodeId(Id::root("node", &[p.x as u128, p.y as u128]));
    let new = NewSegment { from, to, from_id: id(from), to_id: id(to), claim, level: 0 };
    graph.insert(&new, Crowding::Refuse)?;
    Ok(street)
}

/// The quarter around a place.
pub fn quarter_at(graph: &StreetGraph, place: Point) -> Face {
    let faces = Faces::of(graph, FaceKind::Quarter).faces;
    faces.into_iter().find(|face| face.polygon().locate(place) == Location::Inside).expect("a quarter")
}

/// Everything the planar graph promises: no two segments of a level meet but at a common end, what does not meet keeps
/// the separation (V1, V2). By brute force.
pub fn assert_planar(graph: &StreetGraph) {
    let lines: Vec<_> =
        graph.segments_unsorted().map(|(key, segment)| (graph.line(key.forward()), segment.level)).collect();
    for (i, &((a, b), level)) in lines.iter().enumerate() {
        assert!(a.distance_squared(b) >= i64::from(tolerance::SEPARATION).pow(2), "short segment {a:?} {b:?}");
        let bounds = Bounds::between(a, b).grown(tolerance::SEPARATION);
        for &((c, d), _) in lines[i + 1..].iter().filter(|(_, other)| *other == level) {
            if !Bounds::between(c, d).overlaps(&bounds) {
                continue;
            }
            let shared = [c, d].into_iter().filter(|&p| p == a || p == b).count();
            assert!(shared < 2, "double segment {a:?} {b:?}");
            assert!(shared == 1 || !predicates::meets(a, b, c, d), "{a:?} {b:?} meets {c:?} {d:?}");
            for (p, (e, f)) in [(a, (c, d)), (b, (c, d)), (c, (a, b)), (d, (a, b))] {
                let is_foreign = p != e && p != f;
                assert!(
                    !is_foreign || !predicates::within(e, f, p, tolerance::SEPARATION),
                    "{p:?} too near {e:?} {f:?}"
                );
            }
        }
    }
}

/// Least angle between neighbours at any node, in degrees.
pub fn least_angle(graph: &StreetGraph) -> f64 {
    let mut least = f64::INFINITY;
    for (key, _) in graph.nodes_unsorted() {
        let arms = graph.halves_ccw(key);
        for (i, &one) in arms.iter().enumerate() {
            for &other in &arms[i + 1..] {
                let [u, v] = [one, other].map(|arm| graph.line(arm)).map(|(a, b)| Angle::of(b.metres() - a.metres()));
                let degrees = (u - v).wrapped().abs().to_degrees();
                least = least.min(degrees);
            }
        }
    }
    least
}

pub fn shared(fields: Fields) -> Arc<Fields> {
    Arc::new(fields)
}
