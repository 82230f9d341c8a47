//! Streets that were there before growth: they stay as drawn, their free ends go on, and streets sprout along them as
//! if the rule had grown them.

use super::kernel::Grower;
use super::lineage::{Aim, Origin, node_of};
use super::{Fields, Growth, GrowthLog, GrowthRules};
use crate::{Class, NodeKey, StreetGraph, StreetId};
use geom::{Angle, Id, Point, Vec2};
use std::sync::Arc;

/// What the lineage of a sprout, and of a free end, is derived with.
const SPROUT: u128 = 0x7370_726f_7574;
const END: u128 = 0x0065_6e64;

/// Most sprouts along one street: a rule that proposes centimetres ahead would sprout for ever.
const MOST_SPROUTS: u64 = 100_000;

/// Grows streets from those of the growth's class that a graph already has. The given ones keep their lines; where they
/// end freely the rule is asked to go on, and along them it is asked for branches, in the distances that it proposes
/// ahead (SCH10 §4.2.2: appending, prepending and branching on existing streets).
pub fn grow_from_streets(
    graph: &mut StreetGraph,
    settings: &Growth,
    rules: &dyn GrowthRules,
    fields: &Arc<Fields>,
    cancel: &dyn Fn() -> bool,
) -> GrowthLog {
    let mut grower = Grower::new(graph, settings, rules, fields, cancel);
    grower.take_up_all(settings.root, &|_| true);
    grower.log
}

/// The streets with a claim of that class on the ground, by id.
fn streets_of_class(graph: &StreetGraph, class: Class) -> Vec<StreetId> {
    let on_ground = graph.segments_unsorted().filter(|(_, segment)| segment.level == 0);
    let claims = on_ground.flat_map(|(_, segment)| segment.claims().iter()).filter(|claim| claim.class == class);
    let mut streets: Vec<_> = claims.map(|claim| claim.street).collect();
    streets.sort_unstable();
    streets.dedup();
    streets
}

impl Grower<'_> {
    /// Grows from all streets of its class that the graph has, where `allowed` admits it, if the settings say so.
    pub fn take_up_all(&mut self, root: Id, allowed: &dyn Fn(Point) -> bool) {
        if !self.settings.sprouts {
            return;
        }
        for street in streets_of_class(self.graph, self.settings.class) {
            self.take_up(street, root, allowed);
        }
        self.run();
    }

    /// Queues what the rule proposes along a street of the graph and at its free ends, where `allowed` admits it.
    fn take_up(&mut self, street: StreetId, root: Id, allowed: &dyn Fn(Point) -> bool) {
        let root = root.with(&[street.0.0]);
        let half_width = self.half_width_of(street);
        let mut ordinal = 0;
        for chain in Chain::all_of(self.graph, street) {
            for origin in chain.free_ends(self.graph, root, street, half_width) {
                if allowed(origin.at) {
                    self.succeed(&origin);
                }
            }
            self.sprout_along(&chain, street, root, &mut ordinal, allowed);
        }
    }

    fn half_width_of(&self, street: StreetId) -> i32 {
        let segments = self.graph.segments_of(street);
        let claims = segments.iter().flat_map(|&key| self.graph.segment(key).claims());
        claims.filter(|claim| claim.street == street).map(|claim| claim.half_width).max().unwrap_or(1)
    }

    /// Branches along a chain: the rule's own length ahead leads from one place to the next.
    fn sprout_along(
        &mut self,
        chain: &Chain,
        street: StreetId,
        root: Id,
        ordinal: &mut u64,
        allowed: &dyn Fn(Point) -> bool,
    ) {
        let mut along = 0.0;
        let mut age = 0;
        while *ordinal < MOST_SPROUTS {
            let Some((at, heading)) = chain.place(along) else { return };
            let id = root.with(&[SPROUT, u128::from(*ordinal)]);
            *ordinal += 1;
            let half_width = self.settings.half_width;
            let (node, fired) = (node_of(id), age + 1);
            let (length, generation, lead) = (along, 0, None);
            let origin = Origin {
                id,
                node,
                at,
                heading,
                street,
                half_width,
                age,
                length,
                generation,
                lead,
                is_reversed: false,
                fired,
            };
            self.ask(&origin);
            let Some(step) = self.step_ahead(at, heading) else { return };
            self.tip.slots.ahead = None;
            if along > 0.0 && allowed(at) {
                self.queue_successors(&origin);
            }
            along += step;
            age += 1;
        }
    }

    /// Metres to the next place that the rule would go on to, on a raster to its next crossing.
    fn step_ahead(&self, at: Point, heading: Angle) -> Option<f64> {
        let slots = self.tip.slots;
        let length = slots.ahead?.length;
        let limits = self.settings.constraints.length_at(at.metres());
        let aim = Aim { steer: slots.steer, longest: limits.longest, least: limits.least, lead: slots.lead };
        let (target, _) = aim.target(at.metres(), heading, length)?;
        let step = (target - at.metres()).dot(heading.unit());
        (step >= limits.least.max(1.0)).then_some(step)
    }
}

/// A stretch of a street on the ground, node by node in the street's direction.
struct Chain {
    nodes: Vec<NodeKey>,
    points: Vec<Point>,
}

impl Chain {
    /// The stretches of a street, by the id of the node they start from; a closed one starts at its node of least id.
    fn all_of(graph: &StreetGraph, street: StreetId) -> Vec<Self> {
        let mut halves: Vec<_> = graph
            .segments_of(street)
            .into_iter()
            .filter(|&key| graph.segment(key).level == 0)
            .filter_map(|key| {
                let claim = graph.segment(key).claims().iter().find(|claim| claim.street == street)?;
                let half = if claim.forward { key.forward() } else { key.backward() };
                Some((graph.origin(half), graph.target(half)))
            })
            .collect();
        halves.sort_unstable_by_key(|&(from, to)| (graph.node(from).id, graph.node(to).id));
        let mut chains = Vec::new();
        while !halves.is_empty() {
            let is_start = |&(from, _): &(NodeKey, NodeKey)| !halves.iter().any(|&(_, to)| to == from);
            let first = halves.iter().position(is_start).unwrap_or(0);
            let (from, mut to) = halves.remove(first);
            let mut nodes = vec![from, to];
            while let Some(next) = halves.iter().position(|&(start, _)| start == to) {
                to = halves.remove(next).1;
                nodes.push(to);
            }
            let points = nodes.iter().map(|&node| graph.at(node)).collect();
            chains.push(Self { nodes, points });
        }
        chains
    }

    /// The ends at which no other street is met, as tips to go on from: the start against the street's direction.
    fn free_ends(&self, graph: &StreetGraph, root: Id, street: StreetId, half_width: i32) -> Vec<Origin> {
        let last = self.nodes.len() - 1;
        let ends = [(0, 1, true), (last, last - 1, false)];
        let free = ends.into_iter().filter(|&(end, ..)| graph.degree(self.nodes[end]) == 1);
        free.map(|(end, before, is_reversed)| {
            let at = self.points[end];
            Origin {
                id: root.with(&[END, u128::from(is_reversed)]).with(&[graph.node(self.nodes[end]).id.0.0]),
                node: graph.node(self.nodes[end]).id,
                at,
                heading: Angle::of(at.metres() - self.points[before].metres()),
                street,
                half_width,
                age: 0,
                length: 0.0,
                generation: 0,
                lead: None,
                is_reversed,
                fired: 1,
            }
        })
        .collect()
    }

    /// The place so many metres along, and the heading there; `None` beyond the last node.
    fn place(&self, along: f64) -> Option<(Point, Angle)> {
        let mut left = along;
        for pair in self.points.windows(2) {
            let (from, to) = (pair[0].metres(), pair[1].metres());
            let span: Vec2 = to - from;
            let length = span.length();
            if left < length {
                return Some((Point::from_metres(from + span * (left / length)), Angle::of(span)));
            }
            left -= length;
        }
        None
    }
}
