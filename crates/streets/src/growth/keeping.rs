//! What streets keep to when they are attached: a line that a rim leads elsewhere is held against the chain of its growth
//! once more, and so is what every crossing on the way then has (V25).

use super::chain::{Chain, Duplicate, Step};
use super::ground::Ground;
use super::near::{Near, is_within};
use super::{Accepted, Attachment, Draft, Fields, Growth, Refused};
use crate::graph::{Claim, Crowding, Insertion, NewSegment, NodeKey};
use crate::{Class, HalfKey, NodeId, SegmentKey, StreetGraph, StreetId};
use geom::point::units;
use geom::{Angle, Bounds, Point, Seed, tolerance};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;
use std::sync::Arc;

/// What the streets of a growth keep to, wherever they are laid.
#[derive(Clone, Debug)]
pub struct Keeps {
    /// Their class.
    pub class: Class,
    /// What adjusts or refuses them.
    pub constraints: Chain,
    /// Where the chance of rules' own constraints comes from.
    pub seed: Seed,
    /// The maps they grew on.
    pub fields: Arc<Fields>,
}

impl PartialEq for Keeps {
    /// Maps are those of the site.
    fn eq(&self, other: &Self) -> bool {
        (self.class, self.seed) == (other.class, other.seed) && self.constraints == other.constraints
    }
}

impl Keeps {
    /// What a growth keeps to.
    pub fn of(growth: &Growth, fields: &Arc<Fields>) -> Self {
        let (class, constraints, seed) = (growth.class, growth.constraints.clone(), growth.seed);
        Self { class, constraints, seed, fields: fields.clone() }
    }
}

/// Cosine of the least angle; where any will do, none is sharp.
fn cosine_of(chain: &Chain) -> f64 {
    chain.least_angle().map_or(f64::INFINITY, |least| least.cos())
}

/// What is in the graph: from before, and attached since.
#[derive(Debug)]
pub(super) struct Laid {
    /// Which growth, by its place in their order, a street that was attached is of. Only ever looked up.
    by: FxHashMap<StreetId, usize>,
    /// The other streets that were there before at crossings of rims.
    given: FxHashMap<NodeId, SmallVec<[StreetId; 2]>>,
}

impl Laid {
    /// Nothing attached to a graph yet.
    pub fn before(graph: &StreetGraph) -> Self {
        let mut given = FxHashMap::default();
        for (key, node) in graph.nodes_unsorted() {
            let arms = graph.halves_ccw(key).iter();
            let others: SmallVec<[_; 2]> =
                arms.filter(|&&arm| !is_rim(graph, arm)).map(|arm| street_of(graph, *arm)).collect();
            if !others.is_empty() && others.len() < graph.degree(key) {
                given.insert(node.id, others);
            }
        }
        Self { by: FxHashMap::default(), given }
    }

    /// Whether a street that makes an arm at a crossing was there before.
    fn is_given(&self, graph: &StreetGraph, node: NodeId, arm: HalfKey) -> bool {
        self.given.get(&node).is_some_and(|given| given.contains(&street_of(graph, arm)))
    }
}

fn street_of(graph: &StreetGraph, arm: HalfKey) -> StreetId {
    graph.segment(arm.segment()).leading().street
}

fn is_rim(graph: &StreetGraph, arm: HalfKey) -> bool {
    graph.segment(arm.segment()).claims().iter().any(|claim| graph.classes().info(claim.class).closes_quarters)
}

/// One growth's chain, ready to be asked about lines in a graph shared with others.
pub(super) struct Keeper<'a> {
    /// Its growth's place in the order.
    ordinal: usize,
    keeps: &'a Keeps,
    /// The chain as it holds where the present line starts.
    chain: Arc<Chain>,
    ground: Ground<'a>,
    /// Cosine of the least angle; where any will do, none is sharp.
    cosine: f64,
    arms: usize,
    /// Whether its streets may come to lie beyond the rim: over or under it, or across where the chain lets them cross.
    may_leave: bool,
    /// Half of the widest right-of-way around, in LSB.
    widest: i32,
}

impl<'a> Keeper<'a> {
    pub fn new(ordinal: usize, keeps: &'a Keeps, widest: i32) -> Self {
        let chain = &keeps.constraints;
        let is_raised = |step: &Step| match step {
            Step::Legal(legal) => legal.bridge.is_some(),
            Step::Slope(slope) => slope.tunnel > 0.0,
            _ => false,
        };
        Self {
            ordinal,
            may_leave: !chain.steps().contains(&Step::Crossing) || chain.any(is_raised),
            keeps,
            chain: Arc::new(chain.clone()),
            ground: Ground::new(&keeps.fields, chain),
            cosine: cosine_of(chain),
            arms: chain.most_arms(),
            widest,
        }
    }

    /// Takes up a line that grew from a place.
    pub fn stand_at(&mut self, start: Point) {
        if let Some(chain) = self.keeps.constraints.at(start.metres()) {
            self.ground.adopt(&chain);
            (self.cosine, self.arms) = (cosine_of(&chain), chain.most_arms());
            self.chain = Arc::new(chain);
        }
    }

    /// Takes in what lies around the way from the hinge of a stub to another place, before anything is attached: so pieces
    /// of the rim are as its own streets make them.
    pub fn look_around(&self, graph: &StreetGraph, stub: &Attachment, to: Point) -> Near {
        let mut near = Near::of(self.keeps.class);
        near.gather(graph, self.around(stub, to));
        near
    }

    fn around(&self, stub: &Attachment, to: Point) -> Bounds {
        let apart = self.widest.saturating_mul(2).max(tolerance::LAYING);
        let within = self.duplicate().map_or(0, |duplicate| units(duplicate.within));
        Bounds::between(stub.hinge, to).grown(apart.max(within))
    }

    /// Whether the last piece of a stub may lead from its hinge to another place on the rim: along free ground, and as
    /// every step of the chain wants it. `near` is what was there [before](Self::look_around).
    pub fn may_lead(
        &self,
        graph: &StreetGraph,
        laid: &Laid,
        near: &Near,
        accepted: &Accepted,
        stub: &Attachment,
        to: Point,
    ) -> Result<(), Refused> {
        let laying = i64::from(tolerance::LAYING);
        let ahead = graph.first_crossing(stub.hinge, to, 0);
        if ahead.is_some_and(|met| met.at.distance_squared(to) > laying * laying) {
            return Err(Refused::Crowded);
        }
        let mut near = near.clone();
        near.add_where(graph, self.around(stub, to), |key| {
            let is_own = |claim: &Claim| laid.by.get(&claim.street).is_some_and(|&ordinal| ordinal == self.ordinal);
            graph.segment(key).claims().iter().any(is_own)
        });
        self.chain.steps().iter().try_for_each(|step| self.check(step, &near, accepted, stub, to))
    }

    fn duplicate(&self) -> Option<Duplicate> {
        self.chain.find(|step| if let Step::Duplicate(duplicate) = step { Some(*duplicate) } else { None })
    }

    fn check(
        &self,
        step: &Step,
        near: &Near,
        accepted: &Accepted,
        stub: &Attachment,
        to: Point,
    ) -> Result<(), Refused> {
        let (hinge, end) = (stub.hinge.metres(), to.metres());
        let (is_kept, reason) = match step {
            Step::Length(length) => {
                let whole = (end - accepted.start().metres()).length();
                (whole >= length.least, Refused::TooShort)
            }
            Step::Legal(_) => (self.ground.legal_share(hinge, end) >= 1.0, Refused::Illegal),
            Step::Slope(_) => (self.ground.is_gentle(hinge, end), Refused::Steep),
            Step::Mask(_) => (self.ground.covered_share(hinge, end) >= 1.0, Refused::Masked),
            Step::Angle(_) => (
                !near.is_sharp(stub.hinge, to, self.cosine) && !near.is_sharp(to, stub.hinge, self.cosine),
                Refused::Sharp,
            ),
            Step::Duplicate(duplicate) => {
                let half_width = accepted.line.claim.half_width;
                let within = units(duplicate.within);
                let is_one_too_many = |end: Point| {
                    near.is_duplicate(stub.hinge, end, half_width, within)
                        || (duplicate.is_whole && near.runs_along(stub.hinge, end, half_width, within))
                };
                // A last piece may be so short that it lies beside a street where it is, too.
                (!is_one_too_many(to) || is_one_too_many(stub.at), Refused::Duplicate)
            }
            Step::Own(own) => return self.ask(&*own.0, accepted, to),
            // How many streets meet is counted once it is laid.
            Step::Arms(_) | Step::Crossing | Step::Snap(_) | Step::Extend(_) | Step::Join(_) => return Ok(()),
        };
        if is_kept { Ok(()) } else { Err(reason) }
    }

    /// A rule's own constraint must agree to the line from its start to its new end.
    fn ask(&self, own: &dyn super::Constrain, accepted: &Accepted, to: Point) -> Result<(), Refused> {
        let (from, to) = (accepted.start().metres(), to.metres());
        let mut draft = Draft {
            id: accepted.lineage.id,
            from,
            to,
            heading: Angle::of(to - from),
            class: self.keeps.class,
            level: accepted.line.level,
            meets_street: true,
            seed: self.keeps.seed.of(accepted.lineage.id),
            fields: Arc::clone(&self.keeps.fields),
            refused: None,
        };
        own.constrain(&mut draft);
        match draft.refused {
            Some(_) => Err(Refused::ByRule),
            None if draft.to != to => Err(Refused::Unsettled),
            None => Ok(()),
        }
    }

    /// Inserts a line, unless it then broke what it holds among streets that it did not grow with: a crossing on it had more
    /// streets than it may, a sharp angle, or a street beside it.
    pub fn lay(&self, graph: &mut StreetGraph, laid: &mut Laid, line: &NewSegment) -> Result<(), Refused> {
        if self.may_leave && self.is_beside_others(graph, laid, line) {
            return Err(Refused::Duplicate);
        }
        let mut refused = Refused::Full;
        let done = graph.attempt(|graph| match graph.insert(line, Crowding::Refuse) {
            Ok(insertion) => self.holds(graph, laid, line, &insertion).map_err(|reason| refused = reason).ok(),
            Err(refusal) => {
                refused = refusal.into();
                None
            }
        });
        if done.is_some() {
            laid.by.insert(line.claim.street, self.ordinal);
        }
        done.ok_or(refused)
    }

    /// Whether a segment is of a street that this growth may not have known of: another growth laid it, or it was there
    /// before, beyond the rim.
    fn is_of_others(&self, graph: &StreetGraph, laid: &Laid, key: SegmentKey) -> bool {
        let other = |street| laid.by.get(street).map_or(self.may_leave, |&ordinal| ordinal != self.ordinal);
        graph.segment(key).claims().iter().any(|claim| other(&claim.street))
    }

    fn is_beside_others(&self, graph: &StreetGraph, laid: &Laid, line: &NewSegment) -> bool {
        let Some(duplicate) = self.duplicate().filter(|_| line.level == 0) else { return false };
        let (half_width, within) = (line.claim.half_width, units(duplicate.within));
        let mut near = Near::of(self.keeps.class);
        let around = Bounds::between(line.from, line.to).grown(within.max(half_width.saturating_add(self.widest)));
        near.gather_where(graph, around, |key| self.is_of_others(graph, laid, key));
        near.is_duplicate(line.from, line.to, half_width, within)
            || (duplicate.is_whole && near.runs_along(line.from, line.to, half_width, within))
    }

    fn holds(&self, graph: &StreetGraph, laid: &Laid, line: &NewSegment, insertion: &Insertion) -> Result<(), Refused> {
        let path = &insertion.path;
        for (i, &node) in path.iter().enumerate() {
            let arms = graph.halves_ccw(node);
            let is_end = i == 0 || i + 1 == path.len();
            let is_moved = is_end && graph.at(node) != if i == 0 { line.from } else { line.to };
            let before = i.checked_sub(1).and_then(|i| path.get(i));
            let beside = before.into_iter().chain(path.get(i + 1));
            if !beside.clone().all(|&next| self.has_room(graph, laid, node, next)) {
                return Err(Refused::Full);
            }
            // Between what ends at a rim and what grew beyond lie the streets of the rim.
            let is_parted = !self.may_leave && arms.iter().any(|&arm| is_rim(graph, arm));
            let is_shared = || !is_parted && arms.iter().any(|arm| self.is_of_others(graph, laid, arm.segment()));
            if is_moved || is_shared() {
                // What is over or under the ground meets nobody on its way.
                if line.level != 0 {
                    return Err(Refused::Crowded);
                }
                for &next in beside {
                    self.holds_at(graph, node, next, is_moved)?;
                }
            }
        }
        Ok(())
    }

    /// Whether a crossing has room for the piece that leads from it to another. Between two streets of a rim there may be as
    /// many as this side's share, whatever the others use of theirs.
    fn has_room(&self, graph: &StreetGraph, laid: &Laid, node: NodeKey, next: NodeKey) -> bool {
        let (arms, id) = (graph.halves_ccw(node), graph.node(node).id);
        let rims: SmallVec<[usize; 4]> = (0..arms.len()).filter(|&i| is_rim(graph, arms[i])).collect();
        if rims.len() < 2 {
            return arms.len() <= self.arms;
        }
        let own = arms.iter().position(|&arm| graph.target(arm) == next && !is_rim(graph, arm));
        // What lies along a rim is none more.
        let Some(own) = own else { return true };
        let after = rims.partition_point(|&rim| rim < own);
        let (sector, end) = ((after + rims.len() - 1) % rims.len(), rims[after % rims.len()]);
        let between = (rims[sector] + 1..).map(|i| i % arms.len()).take_while(|&i| i != end);
        let there = between.filter(|&i| !laid.is_given(graph, id, arms[i])).count();
        let given = laid.given.get(&id).map_or(0, SmallVec::len);
        let free = self.arms.saturating_sub(rims.len() + given);
        // What does not go up goes to sides by the name of the crossing, counted from the first street of the rims.
        let first = (0..rims.len()).min_by_key(|&i| {
            let arm = arms[rims[i]];
            let claim = graph.segment(arm.segment()).leading();
            (claim.street, claim.forward == arm.is_forward())
        });
        let turn = (id.0.0 % rims.len() as u128) as usize;
        let ordinal = (sector + 2 * rims.len() - first.unwrap_or(0) - turn) % rims.len();
        there <= free / rims.len() + usize::from(ordinal < free % rims.len())
    }

    /// Whether the piece between two crossings makes no sharp angle at the first of them; and is fit, where it was moved.
    fn holds_at(&self, graph: &StreetGraph, node: NodeKey, next: NodeKey, is_moved: bool) -> Result<(), Refused> {
        let (at, to) = (graph.at(node), graph.at(next));
        if is_moved && !self.ground.is_fit(to.metres(), at.metres()) {
            return Err(Refused::Unsettled);
        }
        let arms = graph.halves_ccw(node).iter();
        let mut others = arms.map(|&arm| graph.target(arm)).filter(|&target| target != next);
        let is_sharp = others.any(|other| is_within(at.to(to), at.to(graph.at(other)), self.cosine));
        if is_sharp { Err(Refused::Sharp) } else { Ok(()) }
    }
}
