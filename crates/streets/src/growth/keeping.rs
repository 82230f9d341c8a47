//! What streets keep to when they are attached: a line that a rim leads elsewhere is held against the chain of its growth
//! once more, and so is what every crossing on the way then has (V25).

use super::chain::{Chain, Duplicate, Step};
use super::ground::Ground;
use super::near::{Near, is_within};
use super::{Accepted, Attachment, Draft, Fields, Growth, Refused};
use crate::graph::{Crowding, Insertion, NewSegment, NodeKey};
use crate::{Class, SegmentKey, StreetGraph, StreetId};
use geom::point::units;
use geom::{Angle, Bounds, Point, Seed, tolerance};
use rustc_hash::FxHashMap;
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

/// Which growth, by its place in their order, a street that was attached is of. Only ever looked up.
pub(super) type LaidBy = FxHashMap<StreetId, usize>;

/// One growth's chain, ready to be asked about lines in a graph shared with others.
pub(super) struct Keeper<'a> {
    /// Its growth's place in the order.
    ordinal: usize,
    keeps: &'a Keeps,
    /// The chain as it holds where the present line starts.
    chain: Arc<Chain>,
    ground: Ground<'a>,
    near: Near,
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
            may_leave: !chain.steps().contains(&Step::Crossing) || chain.steps().iter().any(is_raised),
            keeps,
            chain: Arc::new(chain.clone()),
            ground: Ground::new(&keeps.fields, chain),
            near: Near::of(keeps.class),
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

    /// Whether the last piece of a stub may lead from its hinge to another place on the rim: along free ground, and as
    /// every step of the chain wants it.
    pub fn may_lead(
        &mut self,
        graph: &StreetGraph,
        accepted: &Accepted,
        stub: &Attachment,
        to: Point,
    ) -> Result<(), Refused> {
        let laying = i64::from(tolerance::LAYING);
        let ahead = graph.first_crossing(stub.hinge, to, 0);
        if ahead.is_some_and(|met| met.at.distance_squared(to) > laying * laying) {
            return Err(Refused::Crowded);
        }
        let apart = accepted.line.claim.half_width.saturating_add(self.widest).max(tolerance::LAYING);
        let within = self.duplicate().map_or(0, |duplicate| units(duplicate.within));
        self.near.gather(graph, Bounds::between(stub.hinge, to).grown(apart.max(within)));
        let chain = Arc::clone(&self.chain);
        chain.steps().iter().try_for_each(|step| self.check(step, accepted, stub, to))
    }

    fn duplicate(&self) -> Option<Duplicate> {
        self.chain.find(|step| if let Step::Duplicate(duplicate) = step { Some(*duplicate) } else { None })
    }

    fn check(&self, step: &Step, accepted: &Accepted, stub: &Attachment, to: Point) -> Result<(), Refused> {
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
                !self.near.is_sharp(stub.hinge, to, self.cosine) && !self.near.is_sharp(to, stub.hinge, self.cosine),
                Refused::Sharp,
            ),
            Step::Duplicate(duplicate) => {
                let half_width = accepted.line.claim.half_width;
                let within = units(duplicate.within);
                let is_one_too_many = |end: Point| {
                    self.near.is_duplicate(stub.hinge, end, half_width, within)
                        || (duplicate.is_whole && self.near.runs_along(stub.hinge, end, half_width, within))
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
    pub fn lay(&mut self, graph: &mut StreetGraph, laid_by: &mut LaidBy, line: &NewSegment) -> Result<(), Refused> {
        if self.may_leave && self.is_beside_others(graph, laid_by, line) {
            return Err(Refused::Duplicate);
        }
        let mut refused = Refused::Full;
        let laid = graph.attempt(|graph| match graph.insert(line, Crowding::Refuse) {
            Ok(insertion) => self.holds(graph, laid_by, line, &insertion).map_err(|reason| refused = reason).ok(),
            Err(refusal) => {
                refused = refusal.into();
                None
            }
        });
        if laid.is_some() {
            laid_by.insert(line.claim.street, self.ordinal);
        }
        laid.ok_or(refused)
    }

    /// Whether a segment is of a street that this growth may not have known of: another growth laid it, or it was there
    /// before, beyond the rim.
    fn is_of_others(&self, graph: &StreetGraph, laid_by: &LaidBy, key: SegmentKey) -> bool {
        let other = |street| laid_by.get(street).map_or(self.may_leave, |&ordinal| ordinal != self.ordinal);
        graph.segment(key).claims().iter().any(|claim| other(&claim.street))
    }

    fn is_beside_others(&mut self, graph: &StreetGraph, laid_by: &LaidBy, line: &NewSegment) -> bool {
        let Some(duplicate) = self.duplicate().filter(|_| line.level == 0) else { return false };
        let (half_width, within) = (line.claim.half_width, units(duplicate.within));
        let mut near = std::mem::replace(&mut self.near, Near::of(self.keeps.class));
        let around = Bounds::between(line.from, line.to).grown(within.max(half_width.saturating_add(self.widest)));
        near.gather_where(graph, around, |key| self.is_of_others(graph, laid_by, key));
        let is_beside = near.is_duplicate(line.from, line.to, half_width, within)
            || (duplicate.is_whole && near.runs_along(line.from, line.to, half_width, within));
        self.near = near;
        is_beside
    }

    fn holds(&self, graph: &StreetGraph, laid_by: &LaidBy, line: &NewSegment, laid: &Insertion) -> Result<(), Refused> {
        let path = &laid.path;
        if path.iter().any(|&node| graph.degree(node) > self.arms) {
            return Err(Refused::Full);
        }
        for (i, &node) in path.iter().enumerate() {
            let arms = graph.halves_ccw(node);
            let is_end = i == 0 || i + 1 == path.len();
            let is_moved = is_end && graph.at(node) != if i == 0 { line.from } else { line.to };
            let is_shared = || arms.iter().any(|arm| self.is_of_others(graph, laid_by, arm.segment()));
            if is_moved || is_shared() {
                // What is over or under the ground meets nobody on its way.
                if line.level != 0 {
                    return Err(Refused::Crowded);
                }
                let before = i.checked_sub(1).and_then(|i| path.get(i));
                for &next in before.into_iter().chain(path.get(i + 1)) {
                    self.holds_at(graph, node, next, is_moved)?;
                }
            }
        }
        Ok(())
    }

    /// Whether the piece between two crossings makes no sharp angle at the first of them; and is fit, where it was moved.
    fn holds_at(&self, graph: &StreetGraph, node: NodeKey, next: NodeKey, is_moved: bool) -> Result<(), Refused> {
        let (at, to) = (graph.at(node), graph.at(next));
        if is_moved && !self.ground.is_fit(to.metres(), at.metres()) {
            return Err(Refused::Unsettled);
        }
        let others = graph.halves_ccw(node).iter().map(|&arm| graph.target(arm)).filter(|&target| target != next);
        let is_sharp = others.into_iter().any(|other| is_within(at.to(to), at.to(graph.at(other)), self.cosine));
        if is_sharp { Err(Refused::Sharp) } else { Ok(()) }
    }
}
