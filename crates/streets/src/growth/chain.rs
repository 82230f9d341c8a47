//! The local constraints as data: an ordered chain of named steps, each with its own parameters (PM01 §3.3,
//! SCH10 §4.2.3).

use super::own::Own;
use super::varying::Varying;
use super::{Area, Constraints};
use crate::PerDistrict;
use geom::{Angle, Vec2};
use std::sync::Arc;

/// What a chain may hold at most.
pub const MOST_STEPS: usize = 32;

/// One local constraint. Lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Shortest and longest piece of street.
    Length(Length),
    /// Streets stay in the legal area: they are pruned, turned along its rim, or bridge over (PM01 §3.3).
    Legal(Legal),
    /// Streets are not steeper than a limit: they are turned, go through the hill, or turn back (SCH10 §4.2.3).
    Slope(Slope),
    /// Streets stay inside a polygon or a map: what leads out is clipped (SCH10 §4.2.3).
    Mask(Area),
    /// A street that crosses another ends there (PM01 §3.3.1).
    Crossing,
    /// A street that ends, or passes a crossing, closer than this goes to the crossing.
    Snap(f64),
    /// A street that would soon meet another goes on to it.
    Extend(Extend),
    /// A street that ends beside another, closer than this, goes to it.
    Join(f64),
    /// Near-parallel streets that run close to each other are one too many.
    Duplicate(Duplicate),
    /// Least angle between streets at a crossing.
    Angle(Angle),
    /// Most streets that meet in a crossing (SCH10 §4.2.2).
    Arms(u32),
    /// A constraint that a rule decides.
    Own(Own),
}

impl Step {
    /// Whether another step is of the same kind; masks clip to the same area.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Mask(area), Self::Mask(other)) => area == other,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

/// Shortest and longest piece of street, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length {
    /// Shorter pieces are refused.
    pub least: f64,
    /// Longer proposals are cut.
    pub longest: f64,
}

/// How streets stay in the legal area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Legal {
    /// Least share of its length that a proposal may be cut back to at the rim.
    pub prune: f64,
    /// How far, and how finely, a heading that stays inside is looked for.
    pub turns: TurnSearch,
    /// Whether it is looked for before anything is cut back: so streets follow a shore instead of ending at it.
    pub turns_first: bool,
    /// What may lead over illegal area.
    pub bridge: Option<Bridge>,
}

/// A search for a heading by ascending turns, counter-clockwise first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnSearch {
    /// Step of the search.
    pub step: Angle,
    /// Largest turn; 0 for none.
    pub most: Angle,
}

/// Bridges: they start at the shore, come down straight on legal ground, and are flagged by level 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bridge {
    /// Longest stretch of illegal area that is crossed, in metres.
    pub longest: f64,
    /// Least distance between the ends of two bridges, in metres.
    pub spacing: f64,
    /// What they lead over.
    pub over: Over,
    /// Whether a bridge is tried before a turn: so streets cross a river that they could follow.
    pub is_first: bool,
}

/// What bridges may lead over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// Water alone: see [`Fields::is_water`](super::Fields::is_water).
    Water,
    /// Any illegal area: parks too.
    Any,
}

/// How streets keep to gentle slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Steepest slope anywhere along a street, rise over run.
    pub most: f64,
    /// How far, and how finely, a gentle heading is looked for.
    pub turns: TurnSearch,
    /// Whether a street may turn back, up to the least angle between streets, where nothing else is gentle enough.
    pub has_hairpins: bool,
    /// Longest way through a hill, in metres; 0 for none. Flagged by level -1.
    pub tunnel: f64,
}

/// When two near-parallel streets are one too many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duplicate {
    /// They are closer than this, in metres, along more than half of the shorter one; so are those whose roadways would
    /// overlap.
    pub within: f64,
    /// Whether all pieces of street that a new one runs along count together, rather than each piece between two
    /// crossings by itself.
    pub is_whole: bool,
}

/// When a street goes on to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extend {
    /// Within this multiple of its length; 1 for never.
    pub factor: f64,
    /// Longest piece that it goes on by, in metres.
    pub most: f64,
}

/// The local constraints of a growth, in the order in which they are asked.
///
/// A step that changes a proposal starts the chain anew, so each step has agreed to what is laid; one that cannot settle
/// is refused. What holds between streets whatever their order (crossing, duplicate, angle, arms) or of the ground
/// (legal, slope, mask) is tested on the final line once more, so the order decides how a street is adjusted and never
/// whether it is valid (V25). Numbers may differ by place, and all else but the steps themselves by district: see [`Chain::at`].
#[derive(Clone, Debug)]
pub struct Chain {
    steps: Vec<Step>,
    /// What differs by place; empty where nothing does.
    varying: Option<Arc<[Varying]>>,
    /// What differs by district: chains of the same steps.
    districts: Option<Arc<PerDistrict<Chain>>>,
}

impl PartialEq for Chain {
    /// What differs by place is equal to itself only.
    fn eq(&self, other: &Self) -> bool {
        let vary_alike = is_same(self.varying.as_ref(), other.varying.as_ref());
        vary_alike && is_same(self.districts.as_ref(), other.districts.as_ref()) && self.steps == other.steps
    }
}

fn is_same<T: ?Sized>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        _ => false,
    }
}

impl Chain {
    /// A chain of at most [`MOST_STEPS`] steps; what is beyond is left out.
    pub fn new(mut steps: Vec<Step>) -> Self {
        steps.truncate(MOST_STEPS);
        Self { steps, varying: None, districts: None }
    }

    /// The same chain with numbers that differ by place; those that no step has change nothing.
    #[must_use]
    pub fn varied(self, varying: Vec<Varying>) -> Self {
        Self { varying: (!varying.is_empty()).then(|| varying.into()), ..self }
    }

    /// The same chain with others in districts; `None` where their steps are not of the same kinds in the same order, since
    /// what a growth prepares for its steps holds everywhere.
    pub fn in_districts(self, districts: PerDistrict<Self>) -> Option<Self> {
        let is_like = |other: &Self| {
            self.steps.len() == other.steps.len() && self.steps.iter().zip(&other.steps).all(|(a, b)| a.is_like(b))
        };
        let are_like = districts.values().all(is_like);
        are_like.then(|| Self { districts: Some(Arc::new(districts)), ..self.clone() })
    }

    /// The chains of districts and the one of all other ground, where there are any.
    pub fn districts(&self) -> Option<&PerDistrict<Self>> {
        self.districts.as_deref()
    }

    /// Whether a step of it is so, here or in a district.
    pub(super) fn any(&self, is: impl Fn(&Step) -> bool) -> bool {
        let own = self.districts.iter().flat_map(|districts| districts.values());
        own.chain([self]).any(|chain| chain.steps.iter().any(&is))
    }

    /// The numbers that differ by place.
    pub fn varying(&self) -> &[Varying] {
        self.varying.as_deref().unwrap_or_default()
    }

    /// The steps in order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The same chain with a step added at its end.
    #[must_use]
    pub fn with(mut self, step: Step) -> Self {
        self.steps.push(step);
        self.steps.truncate(MOST_STEPS);
        self
    }

    /// The same chain without the steps that `is_dropped` names.
    #[must_use]
    pub fn without(mut self, is_dropped: impl Fn(&Step) -> bool) -> Self {
        self.steps.retain(|step| !is_dropped(step));
        self
    }

    /// The snapping distance in metres; 0 where nothing snaps.
    pub fn snap(&self) -> f64 {
        self.find(|step| if let Step::Snap(metres) = step { Some(*metres) } else { None }).unwrap_or(0.0)
    }

    /// The least angle between streets; none where any will do.
    pub fn least_angle(&self) -> Option<Angle> {
        self.find(|step| if let Step::Angle(least) = step { Some(*least) } else { None })
    }

    /// The most streets that a crossing may have; no limit where the chain says nothing.
    pub fn most_arms(&self) -> usize {
        self.find(|step| if let Step::Arms(most) = step { Some(*most as usize) } else { None }).unwrap_or(usize::MAX)
    }

    /// Shortest and longest piece of street; no limits where the chain says nothing.
    pub fn length(&self) -> Length {
        let found = self.find(|step| if let Step::Length(length) = step { Some(*length) } else { None });
        found.unwrap_or(Length { least: 0.0, longest: f64::INFINITY })
    }

    /// The same for a proposal that starts at a place in metres.
    pub fn length_at(&self, place: Vec2) -> Length {
        self.at(place).map_or_else(|| self.length(), |chain| chain.length())
    }

    /// The snapping distance there, likewise.
    pub fn snap_at(&self, place: Vec2) -> f64 {
        self.at(place).map_or_else(|| self.snap(), |chain| chain.snap())
    }

    pub(super) fn find<T>(&self, pick: impl Fn(&Step) -> Option<T>) -> Option<T> {
        self.steps.iter().find_map(pick)
    }
}

impl Default for Chain {
    /// The standard chain with its defaults for minors.
    fn default() -> Self {
        Constraints::default().into()
    }
}
