//! Several patterns at once (PM01 §3.2.2: "all of them are evaluated", figure 7).
//!
//! PM01 sums the proposed values, weighted. For angles that is wrong: the mean of 350° and 10° is not 180°, and a grid
//! has four headings, none of them the first. So headings are blended as fields with their symmetry: patterns of one
//! symmetry k as the sum of w·(cos kθ, sin kθ), different symmetries as the sum of the headings nearest the tip's own.
//! Lengths, widths and delays are weighted means.

use super::{GrowthRules, Slot, Slots, Steer, Tip, Weight};
use geom::{Angle, Vec2};
use smallvec::SmallVec;

/// Below this share of all weight, fields cancel each other out, and the leading pattern decides alone.
const LEAST_AGREEMENT: f64 = 0.2;
/// How much heavier than the pattern that led a street so far another must be to take the lead.
const LOYALTY: f64 = 1.25;
/// The share of all weight that the patterns proposing a slot must exceed together.
const MAJORITY: f64 = 0.5;

/// One pattern of a blend.
pub struct BlendPart {
    /// The pattern.
    pub rules: Box<dyn GrowthRules + Send>,
    /// How much it counts, and where.
    pub weight: Weight,
}

/// Patterns that share a city: at each tip all those of positive weight propose, and their proposals are blended slot by
/// slot. Where a single one has weight, it alone is asked, and its answer stands unchanged; where none has, the first is.
pub struct Blend {
    parts: Vec<BlendPart>,
}

/// What a part proposes at a tip.
struct Voice {
    part: u16,
    /// Share of all weight.
    weight: f64,
    slots: Slots,
    /// One of its headings before the turn of a slot.
    heading: Angle,
    folds: u32,
}

type Voices = SmallVec<[Voice; 4]>;

impl Blend {
    /// A blend of patterns, the basic one first; of none, which proposes nothing.
    pub fn of(parts: Vec<BlendPart>) -> Self {
        Self { parts }
    }

    /// The parts of positive weight at a place, with their share of all weight; the first one where there is none.
    fn weighed(&self, place: Vec2) -> SmallVec<[(u16, f64); 4]> {
        let weights = self.parts.iter().map(|part| part.weight.at(place));
        let mut weighed: SmallVec<[(u16, f64); 4]> = (0..).zip(weights).filter(|(_, weight)| *weight > 0.0).collect();
        if weighed.is_empty() {
            weighed.push((0, 1.0));
        }
        let total: f64 = weighed.iter().map(|(_, weight)| weight).sum();
        weighed.iter_mut().for_each(|(_, weight)| *weight /= total);
        weighed
    }

    fn ask(&self, part: u16, tip: &mut Tip) {
        tip.slots = Slots::default();
        if let Some(part) = self.parts.get(usize::from(part)) {
            part.rules.propose(tip);
        }
        tip.slots.lead = Some(part);
    }

    fn voice(&self, part: u16, weight: f64, tip: &mut Tip) -> Voice {
        self.ask(part, tip);
        let steer = tip.slots.steer.unwrap_or(Steer::Cross { heading: tip.heading, folds: 1 });
        let (heading, folds) = steer.cross(tip.place());
        if let Steer::Rings(rings) = steer
            && !rings.has_ray_at(tip.place(), tip.steered().unit())
        {
            (tip.slots.left, tip.slots.right) = (None, None);
        }
        Voice { part, weight, slots: tip.slots, heading, folds }
    }
}

impl GrowthRules for Blend {
    fn propose(&self, tip: &mut Tip) {
        let weighed = self.weighed(tip.place());
        if let [(part, _)] = weighed.as_slice() {
            return self.ask(*part, tip);
        }
        let voices: Voices = weighed.into_iter().map(|(part, weight)| self.voice(part, weight, tip)).collect();
        tip.slots = blended(&voices, tip);
    }

    fn origin(&self) -> u16 {
        self.origin_of(None)
    }

    fn is_in_vain(&self) -> bool {
        self.parts.iter().any(|part| part.rules.is_in_vain())
    }

    fn origin_of(&self, lead: Option<u16>) -> u16 {
        self.parts.get(usize::from(lead.unwrap_or(0))).map_or(0, |part| part.rules.origin())
    }
}

fn blended(voices: &Voices, tip: &Tip) -> Slots {
    let lead = lead(voices, tip.lead);
    let every = |_: &Slots| Some(Slot { length: 0.0, turn: Angle::ZERO, delay: 0, width: None });
    let heading = heading(&proposing(voices, every), tip.heading, Angle::ZERO, lead);
    let slot = |of: fn(&Slots) -> Option<Slot>, side: Angle| {
        let proposing = proposing(voices, of);
        let share: f64 = proposing.iter().map(|(voice, _)| voice.weight).sum();
        // Of two equal halves the one that leads decides.
        let is_wanted =
            share > MAJORITY || (share == MAJORITY && proposing.iter().any(|(voice, _)| voice.part == lead));
        is_wanted
            .then(|| mean(&proposing, tip.width, self::heading(&proposing, tip.heading, side, lead) - heading - side))
    };
    Slots {
        steer: Some(Steer::Cross { heading, folds: 1 }),
        ahead: slot(|slots| slots.ahead, Angle::ZERO),
        left: slot(|slots| slots.left, Angle::RIGHT),
        right: slot(|slots| slots.right, -Angle::RIGHT),
        lead: Some(lead),
    }
}

type Proposing<'a> = SmallVec<[(&'a Voice, Slot); 4]>;

fn proposing(voices: &Voices, of: impl Fn(&Slots) -> Option<Slot>) -> Proposing<'_> {
    let slot = |voice: &Voice| of(&voice.slots).and_then(Slot::kept).filter(is_usable);
    voices.iter().filter_map(|voice| Some((voice, slot(voice)?))).collect()
}

fn is_usable(slot: &Slot) -> bool {
    slot.length.is_finite() && slot.turn.to_radians().is_finite()
}

/// The part that leads: the heaviest, the first of equals; but the one that led the street so far as long as none is much
/// heavier.
fn lead(voices: &Voices, before: Option<u16>) -> u16 {
    let Some(heaviest) = voices.iter().reduce(|best, voice| if voice.weight > best.weight { voice } else { best })
    else {
        return 0;
    };
    let loyal = voices.iter().find(|voice| Some(voice.part) == before);
    loyal.filter(|voice| voice.weight * LOYALTY >= heaviest.weight).unwrap_or(heaviest).part
}

/// Lengths, widths and delays as weighted means.
fn mean(proposing: &Proposing, own_width: f64, turn: Angle) -> Slot {
    let total: f64 = proposing.iter().map(|(voice, _)| voice.weight).sum();
    let mean =
        |of: &dyn Fn(&Slot) -> f64| proposing.iter().map(|(voice, slot)| voice.weight * of(slot)).sum::<f64>() / total;
    let has_width = proposing.iter().any(|(_, slot)| slot.width.is_some());
    Slot {
        length: mean(&|slot| slot.length),
        turn: turn.wrapped(),
        delay: mean(&|slot| f64::from(slot.delay)).round() as i32,
        width: has_width.then(|| mean(&|slot| slot.width.unwrap_or(own_width))),
    }
}

/// The sum of the fields of one symmetry.
#[derive(Clone, Copy)]
struct Group {
    folds: u32,
    sum: Vec2,
}

/// The groups of patterns that share a symmetry, for streets that leave to a side.
fn groups(proposing: &Proposing, side: Angle) -> SmallVec<[Group; 4]> {
    let mut groups: SmallVec<[Group; 4]> = SmallVec::new();
    for (voice, slot) in proposing {
        let heading = (voice.heading + slot.turn + side) * f64::from(voice.folds);
        let vector = heading.unit() * voice.weight;
        match groups.iter_mut().find(|group| group.folds == voice.folds) {
            Some(group) => group.sum += vector,
            None => groups.push(Group { folds: voice.folds, sum: vector }),
        }
    }
    groups
}

impl Group {
    /// Its heading nearest to another.
    fn nearest(&self, wanted: Angle) -> Angle {
        let one = Angle::radians(Angle::of(self.sum).to_radians() / f64::from(self.folds.max(1)));
        one.nearest_of_cross(self.folds, wanted)
    }
}

/// The blended heading of the streets that leave a tip to a side.
fn heading(proposing: &Proposing, own: Angle, side: Angle, lead: u16) -> Angle {
    let wanted = own + side;
    let vector = |group: &Group| group.nearest(wanted).unit() * group.sum.length();
    let sum: Vec2 = groups(proposing, side).iter().map(vector).sum();
    let total: f64 = proposing.iter().map(|(voice, _)| voice.weight).sum();
    if sum.length() >= LEAST_AGREEMENT * total {
        return Angle::of(sum);
    }
    let leading = proposing.iter().find(|(voice, _)| voice.part == lead);
    let heaviest = proposing.iter().reduce(|best, next| if next.0.weight > best.0.weight { next } else { best });
    leading
        .or(heaviest)
        .map_or(wanted, |(voice, slot)| (voice.heading + slot.turn + side).nearest_of_cross(voice.folds, wanted))
}

#[cfg(test)]
mod tests;
